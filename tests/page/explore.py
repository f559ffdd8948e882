#!/usr/bin/env python3
"""Opens pages that carry the engine in a real browser, and moves what can be moved.

    explore.py FOLDER PROGRAM...
    explore.py /tmp/explored target/release/kinetostat

Makes the pages in FOLDER, opens them from disk at 1280 and 400 px, light and dark: no request, no console error. The tool and the
part are dragged by mouse, keyboard and touch; numbers agree with `kinetostat point` to 1e-9 mm; the study file and the command that
the page gives are run; a frame of a drag along a path of 300 points takes less than 16 ms of computation.
"""

import json
import math
import shutil
import subprocess
import sys
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).parents[2]
BROWSER = shutil.which("chromium") or "/usr/bin/chromium"
PROCESS = """schema = 1
[placement]
origin_mm = [0.0, 0.0, 100.0]
[force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
"""
READY = "['ready', 'failed'].includes(document.documentElement.dataset.engine)"
EXACT = "kinetostat.live.exact"


def make(folder, program):
    """The pages: machines alone, with their names, and a circle of 300 points on the Orthoglide."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = [f"{25 * math.cos(a)},{25 * math.sin(a)},0" for a in (2 * math.pi * k / 299 for k in range(300))]
    (folder / "circle.csv").write_text("x_mm,y_mm,z_mm\n" + "\n".join(rows) + "\n")
    (folder / "process.toml").write_text(PROCESS)
    machines = ["orthoglide", "tripteron", "kr270", "hexapod", "rotary_delta", "hybrid_3ups", "fanuc_r2000ic"]
    machines += [str(ROOT / "tests/machines" / name) for name in ("kr270_rail.toml", "kr270_cell.toml", "fivebar.toml", "rrr3.toml")]
    pages = []
    for machine in machines:
        page = folder / f"{Path(machine).stem}.html"
        subprocess.run([*program, "explore", machine, "--out", str(page)], check=True, cwd=folder, stdout=subprocess.DEVNULL)
        pages.append(page)
    circle = folder / "circle.html"
    command = ["explore", "orthoglide", "--path", "circle.csv", "--process", "process.toml", "--tolerance", "0.5"]
    subprocess.run([*program, *command, "--out", str(circle)], check=True, cwd=folder, stdout=subprocess.DEVNULL)
    return pages, circle


class Page:
    def __init__(self, browser, file, width=1280, scheme="light", touch=False):
        self.faults, self.file = [], file
        context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme, has_touch=touch)
        self.page = context.new_page()
        self.page.on("console", lambda m: m.type == "error" and self.fault(f"console: {m.text[:200]}"))
        self.page.on("pageerror", lambda error: self.fault(f"script error: {error}"))
        address = file.resolve().as_uri()
        own = lambda url: url.split("#")[0] == address or url.startswith(("data:", "blob:"))
        self.page.on("request", lambda r: own(r.url) or self.fault(f"asks for {r.url[:100]}"))
        began = time.monotonic()
        self.page.goto(address)
        self.page.evaluate("document.getElementById('try').scrollIntoView()")
        self.until(READY)
        self.seconds = time.monotonic() - began
        self.expect(self.page.evaluate("document.documentElement.dataset.engine") == "ready", "the engine did not start")

    def until(self, condition, seconds=60):
        """Waits. The page's policy forbids evaluated text in its own scripts, so that it is asked from outside."""
        ends = time.monotonic() + seconds
        while not self.page.evaluate(condition):
            if time.monotonic() > ends:
                self.fault(f"never: {condition}")
                return
            self.page.wait_for_timeout(50)

    def fault(self, words):
        self.faults.append(f"{self.file.name}: {words}")

    def expect(self, holds, words):
        if not holds:
            self.fault(words)

    def place(self, name, mark):
        """Where a mark of the view `name` is on the page."""
        return self.page.evaluate(
            """([name, mark]) => {
              const canvas = document.querySelector(`[data-part="${name}"]`);
              canvas.scrollIntoView({ block: "center", behavior: "instant" });
              const box = canvas.getBoundingClientRect();
              const at = kinetostat.views.find((v) => v.name === name).to(kinetostat.live.marks[name][mark]);
              return [box.left + at[0], box.top + at[1]];
            }""",
            [name, mark],
        )

    def drag(self, name, mark, dx, dy, steps=20):
        x, y = self.place(name, mark)
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        for k in range(1, steps + 1):
            self.page.mouse.move(x + dx * k / steps, y + dy * k / steps)
            self.page.wait_for_timeout(16)
        self.page.mouse.up()

    def state(self):
        return self.page.evaluate("structuredClone(kinetostat.state)")

    def rest(self):
        self.page.wait_for_timeout(300)
        self.until("kinetostat.resting()")


def check_tool(own, program, folder):
    """The tool is pulled; what the page shows is what its command prints."""
    page = own.page
    page.click('[data-mode-button="tool"]')
    own.rest()
    before = own.state()["tool"]
    own.drag("above", "tool", 12, -8)
    own.rest()
    own.expect(own.state()["tool"] != before, "the tool was not dragged")
    answer = page.evaluate("kinetostat.live.tool")
    command = page.evaluate("kinetostat.command()").replace("kinetostat ", "", 1)
    import shlex

    run = subprocess.run([*program, *shlex.split(command), "--json"], capture_output=True, text=True, cwd=folder)
    if run.returncode not in (0, 1):
        own.fault(f"{command}: {run.stderr.strip()}")
        return
    printed = json.loads(run.stdout)
    if answer["displacement"] is None:
        own.expect(printed["tool_displacement_mm"] is None, f"no displacement, but {printed['tool_displacement_mm']}")
        return
    off = max(abs(a - b) for a, b in zip(answer["displacement"], printed["tool_displacement_mm"]))
    own.expect(off < 1e-9, f"the displacement is {off} mm off that of: {command}")
    cloud = page.evaluate("kinetostat.live.cloud")
    if cloud and cloud["p95"] is not None:
        size = sum(entry * entry for entry in printed["tool_displacement_mm"]) ** 0.5
        own.expect(abs(cloud["nominal"] - size) < 1e-9, f"the cloud is about {cloud['nominal']} mm, not {size}")
        sizes = sorted(sum(entry * entry for entry in tip) ** 0.5 for tip in cloud["displacements"])
        outside = sum(own_size > cloud["p95"] for own_size in sizes)
        own.expect(len(sizes) == 256 and 4 <= outside <= 24, f"{outside} of {len(sizes)} dots outside 95 %")


def check_part(own, program, folder):
    page = own.page
    own.rest()
    before = own.state()["place"]
    page.evaluate("kinetostat.live.spent.length = 0; kinetostat.live.drawn.length = 0")
    own.drag("above", "origin", 60, 25, 60)
    spent = sorted(page.evaluate("kinetostat.live.spent"))
    drawn = sorted(page.evaluate("kinetostat.live.drawn"))
    own.rest()
    after = own.state()["place"]
    own.expect(after[0] > before[0] + 1 and after[1] < before[1] - 1, f"the part was not dragged: {before}, {after}")
    median = lambda values: values[len(values) // 2] if values else float("nan")
    print(f"{own.file.name}: a frame takes {median(spent):.1f} ms of the engine and {median(drawn):.1f} ms to be drawn")
    own.expect(median(spent) < 16 and median(drawn) < 16, f"frames take {median(spent)} and {median(drawn)} ms")
    own.drag("above", "handle", 20, 40)
    own.rest()
    own.expect(own.state()["place"][3] != after[3], "the part was not turned")
    # Keyboard.
    page.focus('[data-part="above"]')
    start = own.state()["place"]
    for key, axis, by in [("ArrowRight", 0, 1), ("Shift+ArrowUp", 1, 10), ("PageUp", 2, 1), ("[", 3, 1)]:
        page.keyboard.press(key)
        moved = own.state()["place"][axis] - start[axis]
        own.expect(abs(moved - by) < 1e-9, f"{key} moves by {moved}")
    own.rest()
    # The study file is accepted by `run`, and finds the same there.
    shown = page.evaluate("structuredClone(kinetostat.live.part)")
    page.click('[data-part="copy-study"]')
    own.until("document.querySelector('[data-part=copied]').value.includes('placement')")
    text = page.input_value('[data-part="copied"]')
    study = folder / "copied"
    study.mkdir(exist_ok=True)
    for name in ("circle.csv", "process.toml"):
        shutil.copy(folder / name, study / name)
    (study / "study.toml").write_text(text)
    run = [*program, "run", str(study), "--grid", "2", "--no-figures", "--out", str(study / "results")]
    ended = subprocess.run(run, capture_output=True, text=True)
    if ended.returncode not in (0, 1):
        own.fault(f"the study file: {ended.stderr.strip()[-300:]}")
        return
    import csv

    with open(study / "results/candidates.csv") as table:
        row = next(row for row in csv.DictReader(table) if row["name"] == "by hand 1")
    for metric, column in [("worst_deflection", "worst_deflection_mm"), ("worst_correction", "worst_correction_mm")]:
        value = next((m["value"] for m in shown["metrics"] if m["name"] == metric), None)
        own.expect(value is not None and abs(value - float(row[column])) < 1e-9, f"{metric} is {value}, the study says {row[column]}")


def check_touch(browser, file):
    own = Page(browser, file, 400, "light", touch=True)
    own.rest()
    before = own.state()["place"]
    x, y = own.place("above", "origin")
    session = own.page.context.new_cdp_session(own.page)
    send = lambda kind, points: session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    send("touchStart", [{"x": x, "y": y}])
    for k in range(1, 11):
        send("touchMove", [{"x": x + 3 * k, "y": y}])
        own.page.wait_for_timeout(16)
    send("touchEnd", [])
    own.rest()
    own.expect(own.state()["place"][0] > before[0] + 1, "a finger does not drag the part")
    return own.faults


def main():
    folder, program = Path(sys.argv[1]), sys.argv[2:]
    program[0] = str(Path(program[0]).resolve()) if Path(program[0]).exists() else program[0]
    pages, circle = make(folder, program)
    faults = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        for file in [*pages, circle]:
            size = file.stat().st_size
            if size > 6_000_000:
                faults.append(f"{file.name} has {size} bytes")
            for width in (1280, 400):
                for scheme in ("light", "dark"):
                    own = Page(browser, file, width, scheme)
                    own.rest()
                    wide, window = own.page.evaluate("[document.documentElement.scrollWidth, window.innerWidth]")
                    own.expect(wide <= window, f"{wide} px wide at {window} px")
                    own.page.screenshot(path=str(folder / f"{file.stem}_{width}_{scheme}.png"), full_page=True)
                    if (width, scheme) == (1280, "light"):
                        if file == circle:
                            check_part(own, program, folder)
                        check_tool(own, program, folder)
                        own.page.click('[data-mode-button="map"]')
                        own.until("kinetostat.live.map && kinetostat.live.map.known > 0")
                        own.page.wait_for_timeout(1500)
                        own.page.screenshot(path=str(folder / f"{file.stem}_map.png"))
                    faults += own.faults
                    own.page.context.close()
        faults += check_touch(browser, circle)
        browser.close()
    for fault in faults:
        print(fault, file=sys.stderr)
    print(f"{len(pages) + 1} pages, {len(faults)} faults")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
