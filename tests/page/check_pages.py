#!/usr/bin/env python3
"""Opens report pages in a real browser and follows a reader on them.

    check_pages.py PAGE.html... [--screenshots FOLDER] [--step-ms MS] [--brief]
    check_pages.py results/*/report.html --screenshots results/screenshots

At 1280 and 400 px width, light and dark: no console error, no request beyond the file itself, nothing wider than the page,
no text or control over another, neither on the page nor within a figure, contrast of at least 4.5 (3 for large text). What
the headline quotes (`data-checks`, `data-found`) is computed again from the CSV files. Quantity, source and slice are switched with the
keyboard, a point of a map is clicked and found again through its address, "back" goes back, the wheel scrolls the page over
a map, where the page draws the deflected machine as far as its table says, the view in three dimensions is dragged, a table is
sorted over all rows of its file, the page is printed with the answer on page 1 and the view in three dimensions in it, and it is opened once more without WebGL.
The first picture of a map or a path is pointed at, clicked and gone through with the arrow keys: what it says is in the CSV file. A slice follows the slider within
--step-ms, 1000 unless told; with --step-ms 100 and nothing else running, 50 000 points pass. --brief leaves out what is the same on every page of a kind: the
views at 400 px, the switch of the theme, the print, and the page without WebGL.
"""

import argparse
import csv
import decimal
import io
import json
import math
import os
import re
import shutil
import sys
import unicodedata
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from urllib.parse import unquote

from PIL import Image
from pypdf import PdfReader
from playwright.sync_api import sync_playwright

BROWSER = shutil.which("chromium") or "/usr/bin/chromium"
WIDTHS = [1280, 400]
SCHEMES = ["light", "dark"]
# The browser paints no taller picture than 8192 pixels in one piece.
TILE = 4000
# From the unit of a column to that of the number shown.
FACTORS = {("mm", "mm"): 1, ("mm", "µm"): 1e3, ("deg", "°"): 1, ("", ""): 1, ("", "×"): 1, ("", "%"): 100}

# What is asked of a page, in Firefox too.
CHECKS = Path(__file__).with_name("checks.js").read_text(encoding="utf-8")
OVERLAPS, CONTRASTS, UNNAMED, WIDE, FIGURE_TEXTS, ANSWER, OVERFLOW, SETTLED = (
    f"() => ({CHECKS}).{name}()"
    for name in ("overlaps", "contrasts", "unnamed", "wide", "figureTexts", "answer", "overflow", "settled")
)


class Page:
    """A page in the browser, with all that goes wrong on it."""

    def __init__(self, browser, file, width, scheme):
        self.file, self.width = file, width
        self.name = f"{file} at {width} px, {scheme}"
        self.faults = []
        self.browser = browser
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
        self.unfold()
        self.scroll_through()

    def unfold(self):
        """Opens what is folded."""
        self.page.evaluate("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
        self.settle()

    def fold(self):
        """Folds what a reader finds folded."""
        self.page.evaluate("document.querySelectorAll('details').forEach((fold) => { fold.open = false; })")
        self.settle()

    def fault(self, words):
        self.faults.append(f"{self.name}: {words}")

    def expect(self, holds, words):
        if not holds:
            self.fault(words)

    def comes_true(self, holds):
        """Whether `holds` within some seconds: a busy computer draws late."""
        for _ in range(25):
            if holds():
                return True
            self.page.wait_for_timeout(200)
        return False

    def console(self, message):
        if message.type == "error":
            self.fault(f"console: {message.text[:200]}")

    def request(self, request):
        if request.url != self.address and not request.url.startswith(("data:", "blob:")):
            self.fault(f"asks for {request.url[:100]}")

    def settle(self):
        self.page.evaluate(SETTLED)

    def show_in(self, scheme):
        """As a system in light or dark colours shows it."""
        self.name = f"{self.file} at {self.width} px, {scheme}"
        self.page.emulate_media(color_scheme=scheme)
        self.settle()

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
        for kind, script in [("overlap", OVERLAPS), ("wider than the page", WIDE), ("contrast", CONTRASTS), ("no name", UNNAMED)]:
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
        plot = self.page.locator(".explorer .chart:not(.space) .plot").first
        plot.scroll_into_view_if_needed()
        box = plot.locator(".nsewdrag").first.bounding_box()
        for share in (0.5, 0.37, 0.62, 0.2, 0.8):
            self.page.mouse.move(box["x"] + share * box["width"], box["y"] + 0.45 * box["height"], steps=4)
            self.page.wait_for_timeout(150)
            if plot.locator(".hovertext").count() > 0:
                return
        self.fault("the pointer over a chart shows no value")

    def check_headline(self, file):
        """The numbers that the first screen says it quotes are those of the tables."""
        text = self.page.evaluate("() => document.querySelector('[data-checks]')?.dataset.checks ?? ''")
        checks = json.loads(text) if text else []
        for number in self.page.locator("[data-found]").all():
            found = json.loads(number.get_attribute("data-found"))
            shown, unit = (number.locator(part).inner_text().strip() for part in (".value", ".unit"))
            self.expect(shows(shown, unit, found), f"headline: shows {shown} {unit} for {found['value']} of {found['columns']}")
            rule = {"largest": "max", "smallest": "min"}[found.pop("extreme")]
            checks.append({**found, "where": found["rows"], "rule": rule, "any_status": True})
        for check in checks:
            try:
                value = recomputed(check, file.parent)
            except (OSError, KeyError, ValueError) as problem:
                self.fault(f"headline: {check.get('file')} cannot be checked: {problem!r}")
                continue
            close = value is not None and math.isclose(value, check["value"], rel_tol=1e-6, abs_tol=1e-12)
            self.expect(close, f"headline: {check['rule']} of {check['columns']} in {check['file']} is {value}, not {check['value']}")
        return len(checks)

    def check_figures(self):
        for found in self.page.evaluate(FIGURE_TEXTS):
            self.fault(f"overlap in a {found}")

    def check_map(self, step_ms):
        """A map is clicked; the address finds the point again; back goes back; the wheel scrolls; the view turns."""
        plot = self.page.locator(".explorer .plot:has(.heatmaplayer)").first
        if plot.count() == 0:
            return
        view = plot.locator("xpath=ancestor::article[contains(@class, 'explorer')]")
        layer = plot.locator(".nsewdrag").first
        layer.scroll_into_view_if_needed()
        box = layer.bounding_box()
        scrolled = "() => window.scrollY"
        before = self.page.evaluate(scrolled)
        self.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
        self.page.mouse.wheel(0, 160)
        self.expect(self.comes_true(lambda: self.page.evaluate(scrolled) > before), "the page does not scroll under the wheel over a map")
        layer.scroll_into_view_if_needed()
        box = layer.bounding_box()
        address = self.page.url
        chosen = view.locator(".chosen")
        for x, y in [(0.42, 0.47), (0.2, 0.3), (0.7, 0.6)]:
            self.page.mouse.click(box["x"] + x * box["width"], box["y"] + y * box["height"])
            self.page.wait_for_timeout(450)
            if chosen.is_visible():
                break
        self.expect(chosen.is_visible(), "a click on a map shows no numbers")
        self.expect("point=" in unquote(self.page.url), "a point that was clicked is not in the address")
        if not chosen.is_visible():
            return
        self.check_layout()
        rows = chosen.locator("tbody tr")
        self.expect(rows.count() > 0, "the point that was clicked has no numbers")
        heading = chosen.locator("h4").text_content()
        self.check_bent(view, chosen)
        command = chosen.locator("code")
        if command.count():
            self.expect(command.text_content().startswith("kinetostat point "), f"no command: {command.text_content()}")
            chosen.get_by_role("button", name="Copy the command").click()
            self.page.wait_for_timeout(100)
        link = self.page.url
        self.page.go_back()
        self.settle()
        self.expect(self.page.url == address and not chosen.is_visible(), "back does not take the point back")
        self.page.go_forward()
        self.settle()
        self.expect(chosen.is_visible() and chosen.locator("h4").text_content() == heading, "forward does not bring it again")
        other = self.browser.new_page(viewport=self.page.viewport_size)
        other.goto(link)
        other.wait_for_function("document.documentElement.dataset.ready === 'true'", timeout=60000)
        other.evaluate("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
        other.wait_for_timeout(200)
        found = other.locator(".chosen h4").first
        self.expect(found.count() and found.text_content() == heading, "the address leads to another point")
        other.close()
        chosen.get_by_role("button", name="Close the point").click()
        self.settle()
        space = view.locator(".chart.space .plot canvas, .chart.space .plot .nsewdrag").first
        if space.count():
            self.check_space(view)
        self.check_steps(view, step_ms)

    def check_pointed(self, file):
        """On the first picture the pointer, a click and the arrow keys find what the table has at that place."""
        hero = self.page.locator(".hero[data-json]")
        if hero.count() == 0:
            return
        view = hero.locator(".pointed")
        self.expect(view.count() == 1 and view.is_visible(), "the first picture cannot be pointed at")
        self.expect(not hero.locator("> figure img").is_visible(), "the first picture stands beside its figure")
        found = json.loads(self.page.locator("[data-found]").first.get_attribute("data-found"))
        is_grid = view.locator("input[type=range]").count() > 0
        columns = ["x_mm", "y_mm", "z_mm"] if is_grid else ["arc_length_mm"]
        check = {"where": found["rows"], "coordinates": columns}
        rows = {place: row for place, row, _ in rows_of(check, file.parent / unquote(found["file"]))}
        value_at = lambda place: max(abs(float(rows[place][column])) for column in found["columns"])
        # The machine is bent by nominal inputs.
        moved_at = lambda place: float(rows[place]["deflection_mm" if is_grid else "displacement_mm"])
        nearest = lambda told: min(rows, key=lambda place: math.dist(place, told))
        plot = view.locator(".plot").first
        plot.scroll_into_view_if_needed()
        if is_grid:
            slider, box = view.locator("input[type=range]").first.bounding_box(), plot.bounding_box()
            self.expect(0 <= box["y"] - slider["y"] < 80, "the slider does not stand beside the map")
        limit = hero.get_attribute("data-tolerance")
        if is_grid and limit:
            level = numbers_in(view.locator("h4").first.text_content().replace("\u2212", "-"))[0]
            level = min({place[2] for place in rows}, key=lambda z: abs(z - level))
            xs, ys = (sorted({place[axis] for place in rows}) for axis in (0, 1))
            cells = [(i, j, value_at((x, y, level))) for i, x in enumerate(xs) for j, y in enumerate(ys)]
            within = {(i, j): value <= float(limit) for i, j, value in cells}
            beside = [((i, j), (i + a, j + b)) for i, j in within for a, b in ((1, 0), (0, 1))]
            edges = sum(within.get(other, within[cell]) != within[cell] for cell, other in beside)
            drawn = plot.evaluate("(p) => p.data[3].x.length / 3")
            self.expect(drawn == edges, f"the tolerance ends at {drawn} edges of the map, not {edges}")
        # A place of the plot in the window, and where it is.
        inside = """(p, share) => {
          const { xaxis, yaxis } = p._fullLayout, box = p.querySelector(".nsewdrag").getBoundingClientRect();
          const own = p.data[0].type === "heatmap" ? p.data[0] : p.data.at(-2);
          const pick = (list) => list[Math.floor(share * (list.length - 1))];
          return [box.left + xaxis.l2p(pick(own.x)), box.top + yaxis.l2p(pick(own.y))];
        }"""
        for share in (0.3, 0.75):
            self.page.mouse.move(2, 2)
            self.page.mouse.move(*plot.evaluate(inside, share), steps=4)
            self.page.wait_for_timeout(250)
            words = " ".join(plot.locator(".hovertext").all_text_contents()).replace("−", "-")
            told = numbers_in(words)
            # The label may hold numbers, too.
            told = told[: 2 if is_grid else 1] + told[-1:]
            if is_grid and told:
                told.insert(2, numbers_in(view.locator("h4").first.text_content().replace("−", "-"))[0])
            self.expect(len(told) == len(columns) + 1, f"the pointer over the first picture shows: {words}")
            if len(told) == len(columns) + 1:
                value = value_at(nearest(told[:-1]))
                self.expect(math.isclose(told[-1], value, rel_tol=6e-4), f"the pointer shows {words}, the table says {value}")
        chosen = view.locator(".chosen")
        self.page.mouse.click(*plot.evaluate(inside, 0.3))
        self.page.wait_for_timeout(500)
        self.expect(chosen.is_visible(), "a click on the first picture picks nothing")
        if not chosen.is_visible():
            return
        place = self.check_picked(view, nearest, (value_at, moved_at), len(columns))
        self.check_layout()
        # Arrow keys.
        self.page.locator("#theme").focus()
        plot.focus()
        self.page.keyboard.press("ArrowRight")
        self.settle()
        ring = plot.evaluate("p => getComputedStyle(p).outlineStyle")
        self.expect(ring != "none", "the first picture shows no focus")
        along = sorted({other[0] for other in rows if other[1:] == place[1:] or not is_grid})
        wanted = (along[min(along.index(place[0]) + 1, len(along) - 1)], *place[1:])
        stepped = self.check_picked(view, nearest, (value_at, moved_at), len(columns))
        self.expect(stepped == wanted, f"an arrow key goes from {place} to {stepped}, not {wanted}")
        self.page.keyboard.press("Escape")
        self.settle()
        self.expect(not chosen.is_visible(), "Escape does not close the point")

    def check_picked(self, view, nearest, numbers, axes):
        """What is picked on the first picture, which the table has and the machine is bent by; where it is."""
        heading = view.locator(".chosen h4").text_content().replace("−", "-")
        place = nearest(numbers_in(heading)[:axes])
        value, bending = (number(place) for number in numbers)
        told = view.locator(".readout").text_content().replace("−", "-")
        is_told = "Picked" in told and math.isclose(numbers_in(told)[0], value, rel_tol=6e-4)
        self.expect(is_told, f"{told} stands below {heading}, the table says {value}")
        if self.page.locator("#engine").count():
            bent = view.locator(".bent")
            for _ in range(400):
                if bent.locator("canvas").count() or "cannot" in bent.text_content():
                    break
                self.page.wait_for_timeout(50)
            if "the table by" in bent.text_content():
                own, told = numbers_in(bent.text_content())[-2:]
                is_other = math.isclose(told, bending, rel_tol=6e-4) and own != told
                self.expect(is_other, f"refuses to draw the deflected machine by {bending}: {bent.text_content()}")
                return place
            moved = bent.get_attribute("data-moved")
            is_drawn = bent.locator("canvas").count() == 2 and moved is not None
            is_so = is_drawn and math.isclose(float(moved), bending, rel_tol=3e-4)
            words = bent.text_content()
            self.expect(is_so, f"the machine is bent by {moved}, the table says {bending}: {words}")
        return place

    def check_steps(self, view, step_ms):
        """The next slice comes soon; of a machine that is busy with something else the least of three times tells."""
        times = [view.get_attribute("data-step-ms")]
        slider = view.locator("input[type=range]").first
        for key in ["ArrowLeft", "ArrowRight"]:
            if times[0] is None or min(map(float, times)) < step_ms:
                return
            slider.press(key)
            self.settle()
            times.append(view.get_attribute("data-step-ms"))
        self.expect(min(map(float, times)) < step_ms, f"a slice takes {' and '.join(times)} ms")

    def check_bent(self, view, chosen):
        """A page of a map with the engine draws the deflected machine at the place, moved as far as the table says."""
        asked = "(v) => JSON.parse(document.getElementById(v.dataset.json).textContent).sources?.length > 0"
        if self.page.locator("#engine").count() == 0 or not view.evaluate(asked):
            return
        bent = chosen.locator(".bent")
        for _ in range(400):
            if bent.locator("canvas").count() or "cannot" in bent.text_content():
                break
            self.page.wait_for_timeout(50)
        self.expect(bent.locator("canvas").count() == 2, f"the deflected machine is not drawn: {bent.text_content()}")
        if bent.locator("canvas").count() != 2:
            return
        self.settle()
        colours = "(c) => new Set(new Uint32Array(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer)).size"
        for canvas in bent.locator("canvas").all():
            self.expect(canvas.evaluate(colours) > 2, "the picture of the deflected machine is blank")
        moved = float(bent.get_attribute("data-moved"))
        row = chosen.locator("tbody tr").first
        self.expect("deflection" in row.locator("th").text_content(), "the first number of a place is no deflection")
        group = max(0, view.evaluate("v => [...v.querySelectorAll('select')][1]?.selectedIndex ?? 0"))
        told = row.locator("td").nth(group).text_content()
        shown = self.page.evaluate("(v) => Data.withUnit(v, 'mm')", moved)
        self.expect(told == shown, f"the machine is moved by {shown}, the table says {told}")
        self.expect("times as large" in bent.text_content() or "drawn as it is" in bent.text_content(), "no amplification is said")
        self.check_layout()

    def check_space(self, view):
        plot = view.locator(".chart.space .plot")
        plot.scroll_into_view_if_needed()
        self.page.wait_for_timeout(500)
        camera = "(v) => JSON.stringify(v.querySelector('.chart.space .plot')._fullLayout.scene._scene.getCamera())"
        before = view.evaluate(camera)
        box = plot.bounding_box()
        middle = (box["x"] + 0.5 * box["width"], box["y"] + 0.4 * box["height"])
        self.page.mouse.move(*middle)
        self.page.mouse.down()
        self.page.mouse.move(middle[0] + 90, middle[1] + 30, steps=6)
        self.page.mouse.up()
        self.page.wait_for_timeout(500)
        after = view.evaluate(camera)
        self.expect(after != before, "dragging does not turn the view")
        up = json.loads(after)["up"]
        self.expect(abs(up["x"]) < 1e-6 and abs(up["y"]) < 1e-6, f"turning tilts the vertical: {up}")
        scrolled = self.page.evaluate("window.scrollY")
        self.page.mouse.wheel(0, -140)
        self.page.wait_for_timeout(500)
        self.expect(view.evaluate(camera) == after, "the wheel zooms the view")
        self.expect(self.comes_true(lambda: self.page.evaluate("window.scrollY") < scrolled), "the page does not scroll under the wheel over the view")

    def check_table(self, file):
        table = self.page.locator("table.sortable:visible").first
        if table.count() == 0:
            return
        numbers = table.locator("thead th.number button")
        button = numbers.first if numbers.count() else table.locator("thead button").first
        header = button.locator("xpath=..")
        column = header.evaluate("h => h.cellIndex")
        cells = f"t => [...t.tBodies[0].rows].map(r => parseFloat(r.cells[{column}].dataset.sort)).filter(Number.isFinite)"
        seen = set()
        for press in ["click", "key"]:
            if press == "click":
                button.click()
            else:
                button.focus()
                button.press("Enter")
            direction = header.get_attribute("aria-sort")
            seen.add(direction)
            values = table.evaluate(cells)
            ordered = sorted(values, reverse=direction == "descending")
            self.expect(values == ordered, f"column {column} is not {direction}: {values[:5]}")
        self.expect(seen == {"ascending", "descending"}, f"the table is sorted {seen}")
        for ranked in self.page.locator("table.sortable:has(+ script.ranking)").all():
            self.check_ranking(ranked, file)

    def check_ranking(self, table, file):
        """A long table is sorted over all rows of its file."""
        address = table.locator("xpath=ancestor::article").locator("a[href$='.csv']").first.get_attribute("href")
        header = table.locator("thead th.number").last
        name = header.text_content().strip()
        column = header.evaluate("h => h.cellIndex")
        for _ in range(3):
            header.locator("button").click()
            if header.get_attribute("aria-sort") == "descending":
                break
        shown = table.evaluate(f"t => t.tBodies[0].rows[0].cells[{column}].dataset.sort")
        with open(file.parent / unquote(address), newline="", encoding="utf-8") as lines:
            values = [float(row[name]) for row in csv.DictReader(lines) if is_number(row[name])]
        self.expect(math.isclose(float(shown), max(values), rel_tol=1e-3, abs_tol=1e-300), f"{address} sorted by {name} begins with {shown}, not {max(values)}")

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
        if self.page.locator(".hero.live").count():
            self.expect(self.page.locator(".hero > figure img").is_visible(), "the figure of the answer is not printed")
            self.expect(not self.page.locator(".pointed").is_visible(), "what is pointed at is printed")
        spaces = self.page.locator(".chart.space .plot:has(canvas)").evaluate_all(
            "all => all.map((p) => { const c = p.querySelector('canvas.paper'); return c ? [c.width, c.height] : null; })"
        )
        pdf = self.page.pdf(format="A4", print_background=True)
        self.expect(pdf.startswith(b"%PDF"), "is not printed")
        words = lambda text: re.sub(r"\W+", "", unicodedata.normalize("NFKC", text))
        first = words(PdfReader(io.BytesIO(pdf)).pages[0].extract_text())
        answer = self.page.evaluate(ANSWER)
        self.expect(bool(answer), "has no answer")
        for part in answer:
            self.expect(words(part)[:60] in first, f"page 1 of the print does not hold \"{part[:60]}\"")
        self.check_printed_spaces(pdf, spaces)
        self.page.evaluate("window.dispatchEvent(new Event('afterprint'))")
        self.page.emulate_media(media="screen")
        return pdf

    def check_printed_spaces(self, pdf, sizes):
        """What is drawn in three dimensions, in pictures of `sizes`, is on paper, and not blank."""
        if not sizes:
            return
        self.expect(None not in sizes, "the view in three dimensions is not printed")
        images = [image.image for page in PdfReader(io.BytesIO(pdf)).pages for image in page.images]
        for size in filter(None, sizes):
            found = [image for image in images if image and list(image.size) == size]
            self.expect(bool(found), f"no picture of {size} pixels is in the print, as the view in three dimensions is")
            for image in found:
                colours = image.convert("RGB").getcolors(1 << 24) or []
                blank = max((count for count, _ in colours), default=0)
                self.expect(len(colours) > 50 and blank < 0.99 * size[0] * size[1], "the printed view in three dimensions is blank")

    def close(self):
        self.page.close()
        return self.faults


def is_number(text):
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def numbers_in(text):
    return [float(number) for number in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?", text)]


def rows_of(check, file):
    """The rows of a table that count, by place: those of the right group whose statuses are answers."""
    with open(file, newline="", encoding="utf-8") as lines:
        for row in csv.DictReader(lines):
            if any(row[column] != cell for column, cell in check.get("where", [])):
                continue
            statuses = [row[name] for name in ("status", "correction_status") if name in row]
            place = tuple(round(float(row[c]), 7) + 0.0 if is_number(row[c]) else row[c] for c in check.get("coordinates", []))
            yield place, row, all(status in ("solved", "converged") for status in statuses)


def shows(text, unit, found):
    """Whether a number is that of a column, rounded to the digits shown."""
    column = re.search(r"_(mm|deg)$|$", found["columns"][0])[1] or ""
    limit, number = re.fullmatch(r"(less than )?(.*)", text.replace("−", "-")).groups()
    if (column, unit) not in FACTORS:
        return False
    value, shown = found["value"] * FACTORS[column, unit], decimal.Decimal(number)
    half = 0.5 * 10.0 ** shown.as_tuple().exponent
    return 0 <= value < float(shown) if limit else abs(value - float(shown)) <= half * (1 + 1e-9)


def recomputed(check, folder):
    """What a headline quotes, from the tables."""
    columns = check.get("columns") or [check["column"]]
    # Over the same points: where all have a number.
    is_known = lambda row, is_answer: is_answer and all(is_number(row.get(column, "")) for column in columns)
    common = [{place for place, row, is_answer in rows_of(check, folder / unquote(other)) if is_known(row, is_answer)} for other in check.get("common", [])]
    values = []
    for place, row, is_answer in rows_of(check, folder / unquote(check["file"])):
        cells = [row[column] for column in columns]
        if not (is_answer or check.get("any_status")) or not all(map(is_number, cells)) or any(place not in places for places in common):
            continue
        values.append(float(cells[0]) if len(cells) == 1 else max(abs(float(cell)) for cell in cells))
    rules = {"max": max, "min": min, "mean": lambda all: sum(all) / len(all), "count": len, "first": lambda all: all[0]}
    return rules[check["rule"]](values) if values else None


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


def check_file(browser, file, screenshots, stem, step_ms, is_brief):
    faults = []
    switched = quoted = 0
    for width in WIDTHS:
        page = Page(browser, file, width, SCHEMES[0])
        is_wide = width == WIDTHS[0]
        for scheme in SCHEMES:
            page.show_in(scheme)
            page.check_layout()
        if screenshots:
            scheme = SCHEMES[0 if is_wide else 1]
            page.show_in(scheme)
            page.fold()
            save_screenshot(page.page, screenshots / f"{stem}_{width}_{scheme}.png")
            page.unfold()
        if is_brief and not is_wide:
            faults += page.close()
            continue
        page.show_in(SCHEMES[0])
        switched += page.check_views()
        page.check_layout()
        page.check_table(file)
        if is_wide:
            quoted = page.check_headline(file)
            page.check_figures()
            page.check_hover()
            page.check_pointed(file)
            page.check_map(step_ms)
            if not is_brief:
                page.check_theme()
                page.check_print()
        faults += page.close()
    if switched == 0:
        faults.append(f"{file}: no view was switched")
    return faults, switched, quoted


def check_without_webgl(playwright, file):
    browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox", "--disable-3d-apis"])
    page = Page(browser, file, WIDTHS[0], "light")
    for space in page.page.locator(".chart.space").all():
        page.expect(space.locator(".missing").is_visible(), "says nothing of missing WebGL")
    page.check_layout()
    faults = page.close()
    browser.close()
    return [f"without WebGL, {fault}" for fault in faults]


def check_one(file, screenshots, step_ms, is_brief):
    """All that is wrong with a page, and a line that says what was done."""
    stem = file.parent.resolve().name if file.name == "report.html" else file.stem
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=BROWSER, args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        )
        faults, switched, quoted = check_file(browser, file, screenshots, stem, step_ms, is_brief)
        browser.close()
        if not is_brief:
            faults += check_without_webgl(playwright, file)
    return faults, f"{file}: {switched} controls used, {quoted} quoted numbers, {len(faults)} faults"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("--screenshots", type=Path)
    parser.add_argument("--step-ms", type=float, default=1000.0, help="longest time for the next slice of a map")
    parser.add_argument("--brief", action="store_true", help="leave out what is the same on every page of a kind")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="pages checked at a time")
    arguments = parser.parse_args()
    if arguments.screenshots:
        arguments.screenshots.mkdir(parents=True, exist_ok=True)
    faults = []
    with ProcessPoolExecutor(arguments.jobs) as pool:
        checks = [pool.submit(check_one, file, arguments.screenshots, arguments.step_ms, arguments.brief) for file in arguments.pages]
        for check in checks:
            found, line = check.result()
            print(line, flush=True)
            faults += found
    for fault in faults:
        print(f"FAULT {fault}", file=sys.stderr)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
