#!/usr/bin/env python3
"""Holds samples.csv of a program run in LinuxCNC against kinetostat and against the bounds of the configuration.

Arguments: program, process file, samples.csv, samples of the same program with LinuxCNC's trivkins, folder for the comparison, clocks of the
processor in a microsecond."""

import sys

from checks import Checks, distance, largest_change, place, read, three
from kinetostat import drives

JOG_MM_PER_S = 90.0
SIZE_MM, RATE_MM_PER_S, CYCLE_S = 2.0, 20.0, 1e-3
# LinuxCNC's own spline and its own rounding.
SPLINE_MM = 1e-9
MAX_COMPARED = 700


def moving(rows):
    """Some of the rows, no two at one place."""
    picked = []
    for row in rows[:: max(1, len(rows) // (3 * MAX_COMPARED))]:
        if not picked or distance(place(row), place(picked[-1])) > 1e-3:
            picked.append(row)
    return picked[:: max(1, len(picked) // MAX_COMPARED)]


def commanded(settings, name, rows):
    """Nominal and corrected drives at the places and forces of rows."""
    program, process, folder = settings
    loads = [(*three(row, "force", "xyz"), 0.0, 0.0, 0.0) for row in rows]
    return drives(program, process, f"{folder}_{name}", [place(row) for row in rows], loads)


def off_spline(rows):
    """How far joints are from the spline that LinuxCNC lays through the answers of the kinematics: weights 1, 4, 1 of three cycles."""
    triples = zip(rows, rows[1:], rows[2:])
    spline = [[(p + 4 * q + r) / 6 for p, q, r in zip(*(three(row, "coarse") for row in triple))] for triple in triples]
    return max(distance(way, three(row, "joint")) for way, row in zip(spline, rows[3:]))


def microseconds(rows, name, clocks):
    times = sorted(row[name] / clocks for row in rows)
    return f"median {times[len(times) // 2]:.1f}, 99.9 % {times[int(0.999 * len(times))]:.1f}, longest {times[-1]:.1f} µs"


def main():
    *settings, clocks = sys.argv[1:]
    program, process, samples, samples_plain, folder = settings
    settings, clocks, checks = (program, process, folder), float(clocks), Checks()
    rows = read(samples)
    run = [row for row in rows if row["phase"] == "program"]
    # The switch is read at the beginning of a cycle and changed in motion; status is told a cycle later.
    loaded = moving([b for a, b, c in zip(run, run[1:], run[2:]) if a["on"] and b["on"] and c["on"] and c["status"] == 0])
    print(f"A program in LinuxCNC, {len(run)} cycles of {1e3 * CYCLE_S:g} ms; {len(loaded)} of them compared with the correction on:")
    nominal, corrected = commanded(settings, "loaded", loaded)
    checks.holds("at least 300 cycles are compared", len(loaded) >= 300)
    checks.at_most("joints from those of kinetostat", max(distance(three(r, "coarse"), d) for r, d in zip(loaded, corrected)), 1e-6)
    largest = max(distance(a, b) for a, b in zip(nominal, corrected))
    checks.holds(f"there is something to correct: {largest:.3f} mm", largest > 0.1)

    off = moving([row for row in run if not row["on"] and max(map(abs, three(row, "correction"))) == 0.0])
    nominal, _ = commanded(settings, "off", off)
    apart = max(distance(three(r, "coarse"), d) for r, d in zip(off, nominal))
    checks.at_most(f"switched off, {len(off)} cycles, from the nominal ones", apart, 1e-6)
    checks.at_most("joints commanded from LinuxCNC's spline of them", off_spline(run), SPLINE_MM)

    step = RATE_MM_PER_S * CYCLE_S
    resting = [[a, b] for a, b in zip(run, run[1:]) if place(a) == place(b)]
    checks.at_most("largest change of a correction in a cycle", largest_change(rows, "correction"), step + 1e-12)
    checks.holds("the tool rests with the correction on for 100 cycles", sum(pair[0]["on"] for pair in resting) > 100)
    checks.at_most("of a joint, the tool commanded to rest", max(largest_change(pair, "coarse") for pair in resting), step + 1e-12)
    checks.at_most("largest correction", max(max(map(abs, three(row, "correction"))) for row in rows), SIZE_MM)
    jumps = [abs(b["force_x"] - a["force_x"]) for a, b in zip(run, run[1:])]
    checks.holds(f"the force steps by {max(jumps):.0f} N from one cycle to the next", max(jumps) > 75)

    modes = [row for row in rows if row["phase"] == "modes"]
    checks.holds("joint mode and back are in the samples", len(modes) > 400)
    checks.at_most("change of a joint in a cycle while modes change", largest_change(modes, "joint"), step + SPLINE_MM)

    beyond = [row for row in rows if row["phase"] == "beyond"]
    far = [row["joint_0"] for row in beyond]
    checks.holds(f"joint 0 is jogged by {max(far) - far[0]:.0f} mm, beyond the box", max(far) - far[0] > 179 and any(r["status"] == 4 for r in beyond))
    checks.at_most("change of a joint in a cycle, axes moved from there", largest_change(beyond, "joint"), JOG_MM_PER_S * CYCLE_S + step + SPLINE_MM)

    plain = [row for row in read(samples_plain) if row["phase"] == "program"]
    print("Time in the servo thread (a simulation on a kernel that is not real-time; other programs interrupt it):")
    print(f"  motion-controller, correction on:  {microseconds([r for r in run if r['on']], 'clocks_motion', clocks)}")
    print(f"  motion-controller, correction off: {microseconds([r for r in run if not r['on']], 'clocks_motion', clocks)}")
    print(f"  motion-controller, beyond the box: {microseconds([r for r in beyond if r['status'] == 4], 'clocks_motion', clocks)}")
    print(f"  motion-controller, LinuxCNC's trivkins: {microseconds(plain, 'clocks_motion', clocks)}")
    print(f"  kinetostat.update: {microseconds(run, 'clocks_update', clocks)}")
    return checks.end()


sys.exit(main())
