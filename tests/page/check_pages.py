#!/usr/bin/env python3
"""Opens report pages in a real browser and checks what a reader meets.

    check_pages.py PAGE.html... [--screenshots FOLDER]
    check_pages.py results/*/report.html --screenshots results/screenshots

At 1280 and 400 px width, light and dark: no console error, no request beyond the file itself, no horizontal overflow,
no text or control over another, contrast of at least 4.5 (3 for large text). Quantity, source and slice are switched with
the keyboard, a table is sorted, the page is printed, and it is opened once more without WebGL.
"""

import argparse
import io
import shutil
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

BROWSER = shutil.which("chromium") or "/usr/bin/chromium"
WIDTHS = [1280, 400]
SCHEMES = ["light", "dark"]
# The browser paints no taller picture than 8192 pixels in one piece.
TILE = 4000

# Texts and controls that must not lie over one another. Tables scroll in boxes of their own.
OVERLAPS = """
() => {
  const seen = (element) => {
    const box = element.getBoundingClientRect();
    return element.checkVisibility({ visibilityProperty: true }) && box.width > 0 && box.height > 0;
  };
  const close = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1.5
    && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1.5;
  const groups = [[...document.querySelectorAll(
    'h1, h2, h3, h4, main p, dt, dd, figcaption, img, select, input, output, .controls span, button, .scroll, .plot, summary')]
    .filter((element) => !element.parentElement.closest('.scroll, .plot, .contents') && seen(element))];
  for (const plot of document.querySelectorAll('.plot')) {
    groups.push([...plot.querySelectorAll('.xtick text, .ytick text, .xtitle, .ytitle, .cbaxis text, .cbtitle text, .legendtext, .colorbar text')]
      .filter(seen));
  }
  const found = [];
  for (const group of groups) {
    const boxes = group.map((element) => element.getBoundingClientRect());
    for (let i = 0; i < group.length; i++) {
      for (let j = i + 1; j < group.length; j++) {
        const nested = group[i].contains(group[j]) || group[j].contains(group[i]);
        if (!nested && close(boxes[i], boxes[j])) {
          found.push([group[i], group[j]].map((e) => e.tagName + ' "' + (e.textContent || e.alt || '').replace(/\\s+/g, ' ').trim().slice(0, 40) + '"').join(' over '));
        }
      }
    }
  }
  return found.slice(0, 10);
}
"""

# Texts of too little contrast with what is behind them (WCAG 2.2, 1.4.3).
CONTRASTS = """
() => {
  const parse = (text) => (text.match(/[\\d.]+/g) || []).map(Number);
  const light = (colour) => {
    const [r, g, b] = colour.slice(0, 3).map((c) => { c /= 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = (element) => {
    for (let e = element; e; e = e.parentElement) {
      const colour = parse(getComputedStyle(e).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return colour;
    }
    return [255, 255, 255];
  };
  const found = new Set();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement;
    if (!walker.currentNode.textContent.trim() || ['SCRIPT', 'STYLE', 'NOSCRIPT', 'OPTION'].includes(element.tagName)) continue;
    const style = getComputedStyle(element);
    const inChart = element instanceof SVGElement;
    if (!element.checkVisibility({ visibilityProperty: true })) continue;
    if (inChart && style.textShadow !== 'none') continue;
    const ink = parse(inChart ? style.fill : style.color);
    const [a, b] = [light(ink), light(behind(element))].sort((x, y) => y - x);
    const ratio = (a + 0.05) / (b + 0.05);
    const size = parseFloat(style.fontSize);
    const large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    if (ratio < (large ? 3 : 4.5)) found.add(ratio.toFixed(2) + ' "' + walker.currentNode.textContent.trim().slice(0, 40) + '"');
  }
  return [...found].slice(0, 10);
}
"""

UNNAMED = """
() => [...document.querySelectorAll('select, input, button, img, a, [role=img], [role=region]')].filter((e) => {
  const labelled = e.getAttribute('aria-labelledby');
  const name = e.getAttribute('aria-label') || e.alt || (labelled && document.getElementById(labelled)?.textContent)
    || e.closest('label')?.textContent || e.textContent;
  return !name || !name.trim();
}).map((e) => e.outerHTML.slice(0, 80))
"""

OVERFLOW = "() => [document.documentElement.scrollWidth, window.innerWidth]"
SETTLED = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 120))))"


class Page:
    """A page in the browser, with all that goes wrong on it."""

    def __init__(self, browser, file, width, scheme):
        self.name = f"{file} at {width} px, {scheme}"
        self.faults = []
        self.page = browser.new_page(
            viewport={"width": width, "height": 900}, color_scheme=scheme, device_scale_factor=0.75
        )
        self.page.on("console", self.console)
        self.page.on("pageerror", lambda error: self.fault(f"script error: {error}"))
        self.page.on("requestfailed", lambda request: self.fault(f"request failed: {request.url[:100]}"))
        self.page.on("request", self.request)
        self.address = file.resolve().as_uri()
        self.page.goto(self.address)
        self.page.wait_for_function("document.documentElement.dataset.ready === 'true'", timeout=60000)
        self.scroll_through()

    def fault(self, words):
        self.faults.append(f"{self.name}: {words}")

    def expect(self, holds, words):
        if not holds:
            self.fault(words)

    def console(self, message):
        if message.type == "error":
            self.fault(f"console: {message.text[:200]}")

    def request(self, request):
        if request.url != self.address and not request.url.startswith(("data:", "blob:")):
            self.fault(f"asks for {request.url[:100]}")

    def settle(self):
        self.page.evaluate(SETTLED)

    def scroll_through(self):
        """Views that are drawn when they come into sight are drawn."""
        height = self.page.evaluate("document.documentElement.scrollHeight")
        for y in range(0, height, 600):
            self.page.evaluate(f"window.scrollTo({{top: {y}, behavior: 'instant'}})")
            self.settle()
        self.page.evaluate("window.scrollTo({top: 0, behavior: 'instant'})")
        self.settle()

    def check_layout(self):
        needed, given = self.page.evaluate(OVERFLOW)
        self.expect(needed <= given, f"is {needed} px wide in a window of {given} px")
        for kind, script in [("overlap", OVERLAPS), ("contrast", CONTRASTS), ("no name", UNNAMED)]:
            for found in self.page.evaluate(script):
                self.fault(f"{kind}: {found}")

    def check_views(self):
        """Every control of every view changes something, by keyboard."""
        views = self.page.locator(".explorer")
        switched = 0
        for v in range(views.count()):
            view = views.nth(v)
            self.expect(view.locator(".plot .plotly, .missing").count() > 0, f"view {v} shows nothing")
            for control in ["select", "input[type=range]"]:
                for c in range(view.locator(control).count()):
                    item = view.locator(control).nth(c)
                    if not item.is_visible() or item.evaluate("e => e.options?.length === 1"):
                        continue
                    before = self.state(view)
                    item.focus()
                    item.press("ArrowDown" if control == "select" else "ArrowRight")
                    if control == "select" and item.evaluate("e => e.selectedIndex === 0"):
                        item.press("ArrowUp")
                    self.settle()
                    self.expect(self.state(view) != before, f"view {v}: {control} {c} changes nothing")
                    switched += 1
            boxes = view.locator("input[type=checkbox], .turns button")
            for b in range(boxes.count()):
                boxes.nth(b).focus()
                boxes.nth(b).press("Space")
                self.settle()
        return switched

    @staticmethod
    def state(view):
        return view.evaluate(
            "v => [v.querySelector('.readout').textContent, ...[...v.querySelectorAll('h4, .plot')].map(e => e.ariaLabel + e.textContent)].join('|')"
        )

    def check_hover(self):
        """The pointer over a map or a curve shows values."""
        plot = self.page.locator(".explorer .plot").first
        plot.scroll_into_view_if_needed()
        box = plot.locator(".nsewdrag").first.bounding_box()
        for share in (0.5, 0.37, 0.62):
            self.page.mouse.move(box["x"] + share * box["width"], box["y"] + 0.45 * box["height"], steps=4)
            self.page.wait_for_timeout(150)
            if plot.locator(".hovertext").count() > 0:
                return
        self.fault("the pointer over a chart shows no value")

    def check_table(self):
        table = self.page.locator("table.sortable").first
        numbers = table.locator("thead th.number button")
        button = numbers.first if numbers.count() else table.locator("thead button").first
        header = button.locator("xpath=..")
        column = header.evaluate("h => h.cellIndex")
        cells = f"t => [...t.tBodies[0].rows].map(r => parseFloat(r.cells[{column}].dataset.sort)).filter(Number.isFinite)"
        for press, direction in [("click", "ascending"), ("key", "descending")]:
            if press == "click":
                button.click()
            else:
                button.focus()
                button.press("Enter")
            self.expect(header.get_attribute("aria-sort") == direction, f"the table is not sorted {direction}")
            values = table.evaluate(cells)
            ordered = sorted(values, reverse=direction == "descending")
            self.expect(values == ordered, f"column {column} is not {direction}: {values[:5]}")

    def check_theme(self):
        ground = "() => getComputedStyle(document.body).backgroundColor"
        before = self.page.evaluate(ground)
        self.page.locator("#theme").focus()
        self.page.locator("#theme").press("Enter")
        self.settle()
        self.expect(self.page.evaluate(ground) != before, "the theme button changes nothing")
        self.check_layout()
        self.page.locator("#theme").press("Enter")
        self.settle()

    def check_print(self):
        self.page.emulate_media(media="print")
        self.page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
        self.settle()
        for control in ["#theme", ".controls", ".contents"]:
            item = self.page.locator(control).first
            self.expect(item.count() == 0 or not item.is_visible(), f"{control} is printed")
        pdf = self.page.pdf(format="A4", print_background=True)
        self.expect(pdf.startswith(b"%PDF"), "is not printed")
        self.page.evaluate("window.dispatchEvent(new Event('afterprint'))")
        self.page.emulate_media(media="screen")
        return pdf

    def close(self):
        self.page.close()
        return self.faults


def save_screenshot(page, file):
    """The whole page in few colours: small enough to be kept in git."""
    page.add_style_tag(content=".contents { position: static !important; }")
    size = page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
    tiles = []
    for top in range(0, size[1], TILE):
        clip = {"x": 0, "y": top, "width": size[0], "height": min(TILE, size[1] - top)}
        tiles.append(Image.open(io.BytesIO(page.screenshot(full_page=True, clip=clip))))
    image = Image.new("RGB", (tiles[0].width, sum(tile.height for tile in tiles)))
    for k, tile in enumerate(tiles):
        image.paste(tile, (0, sum(tile.height for tile in tiles[:k])))
    image.quantize(256, dither=Image.Dither.NONE).save(file, optimize=True)


def check_file(browser, file, screenshots, stem):
    faults = []
    switched = 0
    for width in WIDTHS:
        for scheme in SCHEMES:
            page = Page(browser, file, width, scheme)
            page.check_layout()
            if screenshots and scheme == ("light" if width == WIDTHS[0] else "dark"):
                save_screenshot(page.page, screenshots / f"{stem}_{width}_{scheme}.png")
            if scheme == "light":
                switched += page.check_views()
                page.check_layout()
                page.check_table()
            if scheme == "light" and width == WIDTHS[0]:
                page.check_hover()
                page.check_theme()
                page.check_print()
            faults += page.close()
    if switched == 0:
        faults.append(f"{file}: no view was switched")
    return faults, switched


def check_without_webgl(playwright, file):
    browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox", "--disable-3d-apis"])
    page = Page(browser, file, WIDTHS[0], "light")
    for space in page.page.locator(".chart.space").all():
        page.expect(space.locator(".missing").is_visible(), "says nothing of missing WebGL")
    page.check_layout()
    faults = page.close()
    browser.close()
    return [f"without WebGL, {fault}" for fault in faults]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("--screenshots", type=Path)
    arguments = parser.parse_args()
    if arguments.screenshots:
        arguments.screenshots.mkdir(parents=True, exist_ok=True)
    faults = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=BROWSER, args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        )
        for file in arguments.pages:
            stem = file.parent.resolve().name if file.name == "report.html" else file.stem
            found, switched = check_file(browser, file, arguments.screenshots, stem)
            found += check_without_webgl(playwright, file)
            print(f"{file}: {switched} controls used, {len(found)} faults")
            faults += found
        browser.close()
    for fault in faults:
        print(f"FAULT {fault}", file=sys.stderr)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
