#!/usr/bin/env python3
"""Holds calls.csv against kinetostat and against the bounds. Arguments: program, process file, calls.csv, folder for the comparison."""

import sys

from calls import BOUNDS, HIGH, LOW, rigid
from checks import Checks, distance, largest_change, place, read, three
from kinetostat import drives

CYCLE_S = 1e-3
ROUNDING = 1e-12


def load(row):
    return (*three(row, "force", "xyz"), *three(row, "moment", "xyz"))


def main():
    program, process, calls, folder = sys.argv[1:]
    parts, checks = {}, Checks()
    for row in read(calls):
        parts.setdefault(row["part"], []).append(row)
    free, bounded, same, faults, beyond = (parts[name] for name in ("free", "bounded", "same", "faults", "beyond"))

    corrected = list(zip(*drives(program, process, folder, [place(row) for row in free], [load(row) for row in free])))
    wanted = [loaded if row["on"] else nominal for row, (nominal, loaded) in zip(free, corrected)]
    print(f"{len(free)} places and loads, called in halrun:")
    checks.holds("every call answers", all(row["answer"] == 0 for row in free + bounded + same))
    checks.at_most("joints from those of kinetostat", max(distance(three(r, "joint"), w) for r, w in zip(free, wanted)), 1e-6)
    checks.at_most("forward of inverse from the place", max(distance(three(r, "back"), place(r)) for r in free), 1e-6)

    size, rate = BOUNDS["bounded"]
    resting = bounded[300:1300]
    print(f"Steps of force and switching, corrections within {size} mm and {rate} mm/s, {len(bounded)} cycles:")
    checks.at_most("largest change of a joint at rest in a cycle", largest_change(resting, "joint"), rate * CYCLE_S + ROUNDING)
    checks.holds("it is the bound at a step", largest_change(resting, "joint") > 0.99 * rate * CYCLE_S)
    checks.at_most("largest correction", max(max(map(abs, three(r, "correction"))) for r in bounded[300:]), size + ROUNDING)
    checks.holds("more was wanted", max(max(map(abs, three(r, "wanted"))) for r in bounded) > size)
    limited = [r for r in bounded[1:] if distance(three(r, "correction"), three(r, "wanted")) > 0]
    checks.holds(f"saturations counted: {len(limited)}", bounded[-1]["saturations"] - bounded[0]["saturations"] == len(limited) > 0)
    checks.holds("and told by the status", all((r["status"] == 1) == (r in limited) for r in bounded[1:]))
    nominal, _ = drives(program, process, folder + "_nominal", [place(bounded[799]), place(bounded[-1])], [(0.0,) * 6] * 2)
    checks.at_most("switched off, joints from the nominal ones", distance(three(bounded[799], "joint"), nominal[0]), 1e-6)
    checks.at_most("forward of inverse while bounded", max(distance(three(r, "back"), place(r)) for r in bounded), 1e-6)
    rest = max(distance(three(a, "joint"), three(b, "joint")) for a, b in zip(bounded[300:], same[300:]))
    checks.at_most("range checks of other places change joints by", rest, 0.0)

    print("Faults:")
    kept = {(row["status"], three(row, "joint")) for row in faults[5:10]}
    checks.holds("a force that is not a number keeps the last one, status 3", kept == {(3.0, three(faults[4], "joint"))})
    checks.holds("a force out of range is shortened, status 2", all(r["status"] == 2 and r["answer"] == 0 for r in faults[10:15]))
    checks.holds("a place out of reach is refused", all(r["answer"] == 1 for r in faults[15:20]))
    checks.holds("one that is not a number, too", all(r["answer"] == 2 for r in faults[25:30]))
    for last in (faults[24], faults[-1]):
        checks.holds("and it goes on behind", last["status"] == 0 and three(last, "joint") == three(faults[4], "joint"))

    print(f"{len(beyond)} cycles beyond the box:")
    settled = beyond[2::3]
    on, off = [row for row in settled if row["on"]], [row for row in settled if not row["on"]]
    nearest = [tuple(min(max(c, low), high) for c, low, high in zip(place(row), LOW, HIGH)) for row in on]
    nominal, loaded = drives(program, process, folder + "_nearest", nearest, [load(row) for row in on])
    corrections = [tuple(b - a for a, b in zip(*both)) for both in zip(nominal, loaded)]
    wanted = [tuple(a + b for a, b in zip(rigid(place(row)), correction)) for row, correction in zip(on, corrections)]
    checks.holds("every call answers", all(row["answer"] == 0 for row in beyond))
    checks.holds("told by the status", all(row["status"] == 4 for row in settled))
    checks.at_most("switched off, joints from those of the legs' lengths", max(distance(three(r, "joint"), rigid(place(r))) for r in off), 1e-6)
    checks.at_most("joints from these with the correction of the nearest place", max(distance(three(r, "joint"), w) for r, w in zip(on, wanted)), 1e-6)
    checks.at_most("forward of inverse from the place", max(distance(three(r, "back"), place(r)) for r in beyond), 1e-6)
    return checks.end()


sys.exit(main())
