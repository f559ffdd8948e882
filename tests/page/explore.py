#!/usr/bin/env python3
"""Opens pages that carry the engine in a real browser, and moves what can be moved.

    explore.py FOLDER PROGRAM...
    explore.py /tmp/explored target/release/kinetostat

Makes the pages in FOLDER, opens them from disk at 1280 and 400 px, light and dark: no request, no console error. The tool and the
part are dragged by mouse, keyboard and touch; numbers agree with `kinetostat point` to 1e-9 mm; the study file and the command that
the page gives are run; a frame of a drag along a path of 300 points takes less than 16 ms of computation. The machine stands where the
part is: its tip at the point of the path where the error is the largest. What is shaded as reached, `kinetostat point` reaches. Numbers
stand in the first screen of 1280 × 900 px.
"""

import csv
import json
import math
import shlex
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
# The force that the page of the arm begins with.
WRENCH = [-20, 300, -500, 0, 1000, 0]
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
        own = ["--wrench", ",".join(map(str, WRENCH))] if machine == "kr270" else []
        subprocess.run([*program, "explore", machine, *own, "--out", str(page)], check=True, cwd=folder, stdout=subprocess.DEVNULL)
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


def point(program, folder, command):
    """What `kinetostat point` prints; None where it refuses the place."""
    run = subprocess.run([*program, *shlex.split(command), "--json"], capture_output=True, text=True, cwd=folder)
    if not run.stdout.startswith("{"):
        return None
    return json.loads(run.stdout)


def check_first_screen(own):
    """Sentence and numbers of the drives are seen without scrolling."""
    own.page.evaluate("window.scrollTo({top: 0, behavior: 'instant'})")
    for part in ("headline", "drives"):
        box = own.page.locator(f'[data-part="{part}"]').bounding_box()
        own.expect(box["height"] > 20 and box["y"] + box["height"] <= 900, f"{part} is not in the first screen: {box}")


def check_reach(own, program, folder):
    """The command line reaches what is shaded, and no cell that is not; three of each plane."""
    page = own.page
    machine = page.evaluate("kinetostat.live.view.machine")
    tool, wrench = page.evaluate("[kinetostat.state.tool, kinetostat.state.wrench]")
    offset = [b - a for a, b in zip(tool, page.evaluate("kinetostat.live.tool.commanded.tool_tip_mm"))]
    for name in ("above", "front"):
        plane = page.evaluate(f"kinetostat.live.reach.{name}")
        words = page.text_content(f'[data-part="reach-{name}"]')
        own.expect(plane is not None and "coarse" in words, f"{name}: no region is shown as coarse: {words}")
        if plane is None:
            return
        cells = {tuple(cell): True for cell in plane["reached"]}
        low, all_cells = plane["low"], []
        a, b, across = plane["axes"]
        for j in range(plane["counts"][1]):
            for i in range(plane["counts"][0]):
                cell = [0.0, 0.0, 0.0]
                cell[across] = plane["level"]
                cell[a], cell[b] = (low[n] + plane["step"] * (k + 0.5) for n, k in enumerate((i, j)))
                near = [c for c in cells if math.dist(c, cell) < 1e-6]
                all_cells.append((near[0] if near else cell, bool(near)))
        for wanted in (True, False):
            some = [cell for cell, reached in all_cells if reached == wanted]
            for cell in some[:: max(1, len(some) // 3)][:3]:
                place = [c - o for c, o in zip(cell, offset)]
                numbers = lambda list_: ",".join(map(repr, list_))
                turned = ["--pose", numbers([*place, *tool[3:]])]
                where = turned if machine["turns"] else ["--position", numbers(place)]
                words = ["point", "--machine", machine["name"], *where, "--wrench", numbers(wrench), *machine["options"]]
                command = shlex.join(words)
                printed = point(program, folder, command)
                found = printed is not None and printed["tool_displacement_mm"] is not None
                own.expect(found == wanted, f"{name}: shaded is {wanted}, but: {command}")


def check_spin(own):
    """The round handle turns the tool about its own axis: its tip stays, and its axis."""
    page = own.page
    if not page.evaluate("kinetostat.live.view.machine.turns && kinetostat.live.tool.commanded !== null"):
        return
    told = "[kinetostat.live.tool.commanded.tool_tip_mm, toolFrame(kinetostat).axis, toolFrame(kinetostat).side]"
    tip, axis, side = page.evaluate(told)
    (x, y), (cx, cy) = own.place("above", "spin"), own.place("above", "tool")
    page.mouse.move(x, y)
    page.mouse.down()
    for k in range(1, 21):
        angle = math.radians(1.5 * k)
        c, s = math.cos(angle), math.sin(angle)
        page.mouse.move(cx + c * (x - cx) - s * (y - cy), cy + s * (x - cx) + c * (y - cy))
        page.wait_for_timeout(16)
    page.mouse.up()
    own.rest()
    tip_after, axis_after, side_after = page.evaluate(told)
    own.expect(math.dist(tip, tip_after) < 1e-6, f"turning the tool moves its tip from {tip} to {tip_after}")
    own.expect(math.dist(axis, axis_after) < 1e-9, f"turning the tool tilts it from {axis} to {axis_after}")
    turned = math.degrees(math.acos(max(-1.0, min(1.0, sum(p * q for p, q in zip(side, side_after))))))
    own.expect(abs(turned - 30) < 2, f"a drag of 30° turns the tool by {turned}°")


def check_tool(own, program, folder):
    """The tool is pulled; what the page shows is what its command prints."""
    page = own.page
    page.click('[data-mode-button="tool"]')
    own.rest()
    if own.file.stem == "kr270":
        own.expect(own.state()["wrench"] == WRENCH, f"begins with the force {own.state()['wrench']}")
    check_first_screen(own)
    if own.file.stem in ("kr270", "orthoglide", "hexapod", "kr270_rail"):
        check_reach(own, program, folder)
    before = own.state()["tool"]
    own.drag("above", "tool", 12, -8)
    own.rest()
    own.expect(own.state()["tool"] != before, "the tool was not dragged")
    check_spin(own)
    answer = page.evaluate("kinetostat.live.tool")
    command = page.evaluate("kinetostat.command()").replace("kinetostat ", "", 1)
    printed = point(program, folder, command)
    if printed is None:
        own.fault(f"is refused: {command}")
        return
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


def check_machine(own, folder):
    """The machine stands where the part is: its tip at a point of the path, which the part's place and the file tell."""
    page = own.page
    with open(folder / "circle.csv") as table:
        path = [[float(row[name]) for name in ("x_mm", "y_mm", "z_mm")] for row in csv.DictReader(table)]
    machine, place = page.evaluate("[kinetostat.live.part.machine, kinetostat.state.place]")
    yaw = math.radians(place[3])
    x, y, z = path[machine["point"][1]]
    c, s = math.cos(yaw), math.sin(yaw)
    wanted = [place[0] + c * x - s * y, place[1] + s * x + c * y, place[2] + z]
    drawn = page.evaluate("kinetostat.live.marks.above.machine")
    own.expect(math.dist(drawn, wanted) < 1e-6, f"the tip of the machine is drawn at {drawn}, the part is at {wanted}")
    worst = next(m["value"] for m in page.evaluate("kinetostat.live.part.metrics") if m["name"] == "worst_deflection")
    moved = math.hypot(*machine["displacement"])
    own.expect(abs(moved - worst) < 1e-6, f"the machine is bent by {moved} mm, the worst error is {worst} mm")


def check_part(own, program, folder):
    page = own.page
    own.rest()
    check_first_screen(own)
    check_machine(own, folder)
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
    check_machine(own, folder)
    own.drag("above", "handle", 20, 40)
    own.rest()
    own.expect(own.state()["place"][3] != after[3], "the part was not turned")
    check_machine(own, folder)
    # Outside the box the error is said all the same.
    put = "(place) => { kinetostat.state.place = place; kinetostat.changed(); }"
    page.evaluate(put, [110.0, 0.0, 100.0, 0.0, 0.0, 0.0])
    own.rest()
    worst = next(m["value"] for m in page.evaluate("kinetostat.live.part.metrics") if m["name"] == "worst_deflection")
    words = page.text_content('[data-part="headline"]')
    error = page.evaluate("(v) => Data.number(v) + ' mm'", worst)
    own.expect("workspace box" in words and error in words, f"outside the box: {words}")
    page.evaluate(put, after)
    own.rest()
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
