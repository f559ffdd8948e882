#!/usr/bin/env python3
"""Whether contours with cutter radius compensation become the path that LinuxCNC's interpreter makes of them.

    check_centre_path.py KINETOSTAT [--from SEED] [--count N] [--rs274 FILE] [--keep FOLDER]

Random contours of lines and arcs, a cutter of 10 mm on either side. kinetostat writes them out (cutter_compensation =
"off"), rs274 of Debian's linuxcnc-uspace runs them as they are; from the end of the first block on, ends and centres
have to agree within 1e-4 mm, the digits of rs274. It leads to the contour square to its own move and looks at no other
block than the next: what kinetostat refuses is counted where rs274 comes nearer to the contour than the radius, and
otherwise listed. Exit code 1 if a path differs.
"""

import argparse
import math
import os
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import check

RADIUS = 5.0
# mm: rs274 prints four decimals.
TOLERANCE = 1.2e-4
PROCESS = """schema = 1
[placement]
origin_mm = [0.0, 0.0, 0.0]
[gcode]
dialect = "linuxcnc"
cutter_compensation = "off"
decimals_mm = 6
write_tolerance_mm = 0.0
"""


def contour(seed):
    """A program, its side (1: left) and its elements: (arc?, end, centre, sense)."""
    draw = random.Random(seed)
    side = draw.choice([1, -1])
    at, heading, elements, lines = (0.0, 0.0), 0.0, [], []
    for _ in range(draw.randint(1, 7)):
        angle, length = draw.choice([-1, 1]) * math.radians(draw.uniform(8, 100)), draw.uniform(6, 30)
        if draw.random() < 0.45:
            radius, sense = draw.uniform(3, 40), math.copysign(1, angle)
            sweep = sense * min(length / radius, 5.5)
            arm = (sense * radius * math.sin(heading), -sense * radius * math.cos(heading))
            centre = (at[0] - arm[0], at[1] - arm[1])
            cos, sin = math.cos(sweep), math.sin(sweep)
            at = (centre[0] + arm[0] * cos - arm[1] * sin, centre[1] + arm[0] * sin + arm[1] * cos)
            lines.append("G%d X%.7f Y%.7f I%.7f J%.7f" % (3 if sense > 0 else 2, *at, -arm[0], -arm[1]))
            elements.append((at, centre, sense))
            heading += sweep
        else:
            at = (at[0] + length * math.cos(heading), at[1] + length * math.sin(heading))
            lines.append("G1 X%.7f Y%.7f" % at)
            elements.append((at, None, 0))
        heading += draw.choice([angle / 2, 0.0])
    away = (at[0] + 40 * math.cos(heading), at[1] + 40 * math.sin(heading))
    switch = "G41.1" if side > 0 else "G42.1"
    head = ["G21 G90 G17 G40", "G0 X-20 Y%d Z0" % (14 * side), f"{switch} D10 G1 X0 Y0 F100"]
    return "\n".join([*head, *lines, "G40 G0 X%.7f Y%.7f" % away, "M2"]) + "\n", elements


def by_rs274(rs274, folder, text):
    """What rs274 makes of a program; `None` if it refuses."""
    program, table = folder / "contour.ngc", folder / "tool.tbl"
    program.write_text(text)
    table.write_text("T1 P1 D10 ;\n")
    command = [rs274, "-g", "-v", folder / "rs274.var", "-t", table, program]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    if ran.returncode:
        return None
    found = []
    for line in ran.stdout.splitlines():
        if feed := re.search(r"STRAIGHT_FEED\(([-\d.]+), ([-\d.]+)", line):
            found.append(((float(feed[1]), float(feed[2])), None, 0))
        if arc := re.search(r"ARC_FEED\(([-\d.]+), ([-\d.]+), ([-\d.]+), ([-\d.]+), (-?\d+)", line):
            x, y, i, j = (float(arc[k]) for k in range(1, 5))
            found.append(((x, y), (i, j), math.copysign(1, int(arc[5]))))
    return found


def by_kinetostat(kinetostat, folder, text):
    """What kinetostat writes, or why not."""
    (folder / "part.ngc").write_text(text)
    for old in folder.glob("out.ngc*"):
        old.unlink()
    files = {"--machine": "mill.toml", "--process": "process.toml", "--out": "out.ngc"}
    command = [kinetostat, "compensate", "part.ngc", *(word for pair in files.items() for word in pair)]
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    if ran.returncode:
        return None, ran.stderr.strip()
    found, at, code = [], (0.0, 0.0), 0
    for line in (folder / "out.ngc").read_text().splitlines():
        line = line.split("(")[0]
        words = {letter: float(number) for letter, number in re.findall(r"([XYIJ])(-?[\d.]+)", line)}
        motions = re.findall(r"G0?([0-3])(?![\d.])", line)
        code = int(motions[-1]) if motions else code
        if words:
            to = (words.get("X", at[0]), words.get("Y", at[1]))
            centre = (at[0] + words.get("I", 0.0), at[1] + words.get("J", 0.0)) if code > 1 else None
            if code:
                found.append((to, centre, {2: -1, 3: 1}.get(code, 0)))
            at = to
    return found, ""


def points(begin, elements):
    """Points along elements, about every 0.1 mm."""
    found, at = [begin], begin
    for to, centre, sense in elements:
        if centre is None:
            count = max(2, int(math.dist(at, to) / 0.1))
            shares = [k / count for k in range(1, count + 1)]
            found += [(at[0] + (to[0] - at[0]) * k, at[1] + (to[1] - at[1]) * k) for k in shares]
        else:
            radius = math.dist(at, centre)
            angles = [math.atan2(p[1] - centre[1], p[0] - centre[0]) for p in (at, to)]
            sweep = sense * ((sense * (angles[1] - angles[0])) % math.tau)
            count = max(2, int(abs(sweep) * radius / 0.1))
            turned = [angles[0] + sweep * k / count for k in range(1, count + 1)]
            found += [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in turned]
        at = to
    return found


def differs(ours, theirs):
    """The first of our moves from the end that is not theirs; `None` if only the way to the contour is."""
    for number, (own, other) in enumerate(zip(reversed(ours), reversed(theirs))):
        if number == len(ours) - 1:
            return None
        gap = math.dist(own[0], other[0])
        if (own[1] is None) != (other[1] is None) or own[2] != other[2]:
            return own
        if own[1]:
            gap = max(gap, math.dist(own[1], other[1]))
        if gap > TOLERANCE:
            return own
    return ours[0] if len(ours) > len(theirs) else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinetostat", type=Path)
    parser.add_argument("--from", type=int, default=1, dest="first")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--rs274", default="rs274")
    parser.add_argument("--keep", type=Path)
    asked = parser.parse_args()
    folder = asked.keep or Path(tempfile.mkdtemp(prefix="centre_path_"))
    folder.mkdir(exist_ok=True)
    (folder / "mill.toml").write_text(check.MACHINE)
    (folder / "process.toml").write_text(PROCESS)
    agree, gouges, refused, wrong = 0, 0, [], []
    for seed in range(asked.first, asked.first + asked.count):
        text, elements = contour(seed)
        theirs = by_rs274(asked.rs274, folder, text)
        ours, why = by_kinetostat(asked.kinetostat.resolve(), folder, text)
        if ours and theirs:
            found = differs(ours, theirs)
            if found is None:
                agree += 1
            else:
                wrong.append(f"seed {seed}: {found}")
        elif ours is None and theirs:
            own = points((0.0, 0.0), elements)
            path = points(theirs[0][0], theirs[1:])
            nearest = min(math.dist(p, q) for p in path for q in own)
            gouges += nearest < RADIUS - 1e-3
            refused += [] if nearest < RADIUS - 1e-3 else [f"seed {seed}: {why[:150]}"]
    print(f"{asked.count} contours: {agree} agree with rs274, {len(wrong)} differ")
    print(f"refused: {gouges} that rs274 cuts into, {len(refused)} others")
    for line in wrong + refused:
        print(" ", line)
    return 1 if wrong or agree == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
