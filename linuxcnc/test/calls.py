#!/usr/bin/env python3
"""Feeds rows to the component in halrun, a cycle each, and writes what it answers to calls.csv.

The parts: `free` (corners of the box and random places, random loads, no bounds, every fourth switched off), `bounded` (a tool at rest
under steps of the force, switched off and on, then moving, with range checks of other places in between), `same` (the same without these
range checks), `faults` (a force that is not a number, one out of range, a place out of reach, one that is not a number), `beyond` (places
that limits of joints allow outside of the box, each for three cycles, every other one switched off)."""

import csv
import itertools
import math
import random
import subprocess
import time

LOW, HIGH = (-73.65, -73.65, 26.35), (126.35, 126.35, 226.35)
FORCE_N, MOMENT_NMM = 200.0, 2000.0
BOUNDS = {"free": (100.0, 1e6), "bounded": (0.6, 5.0), "same": (0.6, 5.0), "faults": (100.0, 1e6), "beyond": (100.0, 1e6)}
# Limits of joints in sim/orthoglide.ini, and the geometry of the Orthoglide.
JOINTS = (-405.0, -155.0)
LEG, OFFSET, TOOL = 310.0, 31.0, (0.0, 0.0, 100.0)
INPUTS = "x y z ahead_x ahead_y ahead_z force_x force_y force_z moment_x moment_y moment_z on".split()
OUTPUTS = (
    "joint_0 joint_1 joint_2 back_0 back_1 back_2 correction_0 correction_1 correction_2 "
    "wanted_0 wanted_1 wanted_2 status saturations answer"
).split()
STILL = (40.0, 20.0, 120.0)
NO_LOAD = (0.0,) * 6


def rigid(place):
    """Joints of the rigid machine with its tool tip at a place, by the lengths of its legs."""
    p = [a - b for a, b in zip(place, TOOL)]
    inside = [LEG**2 - sum(c * c for c in p) + c * c for c in p]
    return tuple(c - OFFSET - math.sqrt(s) for c, s in zip(p, inside))


def position(joints):
    """Where its tool tip is: each leg is a sphere about its foot, and the sum of their equations is one for the square of the distance."""
    feet = [joint + OFFSET for joint in joints]
    a = sum(0.25 / f**2 for f in feet)
    b = sum(0.5 * (f**2 - LEG**2) / f**2 for f in feet) - 1.0
    c = sum(0.25 * (f**2 - LEG**2) ** 2 / f**2 for f in feet)
    found = []
    for sign in (1.0, -1.0):
        square = (sign * math.sqrt(b**2 - 4.0 * a * c) - b) / (2.0 * a)
        found.append([(square + f**2 - LEG**2) / (2.0 * f) for f in feet])
    # The other one is its mirror image behind the feet.
    return tuple(p + t for p, t in zip(max(found, key=sum), TOOL))


def rows(part):
    """(place, place of the range check, load, on) of each cycle."""
    chance = random.Random(3)
    place = lambda: tuple(chance.uniform(low, high) for low, high in zip(LOW, HIGH))
    load = lambda: tuple(chance.uniform(-most, most) for most in [FORCE_N] * 3 + [MOMENT_NMM] * 3)
    if part == "free":
        corners = [corner for corner in itertools.product(*zip(LOW, HIGH)) for _ in range(4)]
        places = corners + [place() for _ in range(600)]
        return [(here, place(), load(), number % 4 != 0) for number, here in enumerate(places)]
    if part == "faults":
        not_a_number, too_much = (math.nan,) + load()[1:], (1e6,) + load()[1:]
        first = load()
        return [(STILL, STILL, first, True)] * 5 + [(STILL, STILL, not_a_number, True)] * 5 + [
            (STILL, STILL, too_much, True)] * 5 + [(STILL, (500.0, 0.0, 100.0), first, True)] * 5 + [(STILL, STILL, first, True)] * 5 + [
            ((STILL[0], math.nan, STILL[2]), STILL, first, True)] * 5 + [(STILL, STILL, first, True)] * 5
    if part == "beyond":
        steps = [JOINTS[0] + share * (JOINTS[1] - JOINTS[0]) for share in (0.0, 0.25, 0.5, 0.75, 1.0)]
        joints = list(itertools.product(steps, repeat=3)) + [tuple(chance.uniform(*JOINTS) for _ in range(3)) for _ in range(600)]
        outside = [p for p in map(position, joints) if any(not low <= c <= high for low, c, high in zip(LOW, p, HIGH))]
        places = [(p, p, load(), number % 2 == 0) for number, p in enumerate(outside)]
        return [cycle for cycle in places for _ in range(3)]
    pressed = (140.0, -90.0, 60.0, 1000.0, -2000.0, 500.0)
    still = [(NO_LOAD, True)] * 300 + [(pressed, True)] * 300 + [(pressed, False)] * 200 + [(pressed, True)] * 300 + [(NO_LOAD, True)] * 200
    way = [tuple(s + 0.05 * k * d for s, d in zip(STILL, (1.0, 0.6, -0.8))) for k in range(600)]
    cycles = [(STILL, load, on) for load, on in still] + [(p, pressed, True) for p in way]
    return [(p, place() if part == "bounded" else p, load, on) for p, load, on in cycles]


def halcmd(*words):
    subprocess.run(["halcmd", *words], check=True)


def main():
    import hal

    component = hal.component("calls")
    inputs = hal.stream(component, hal.streamer_base, "f" * 13 + "b")
    outputs = hal.stream(component, hal.sampler_base, "f" * 13 + "sus")
    component.ready()
    asked, last = {}, 0.0
    with open("calls.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["part", "row", *INPUTS, *OUTPUTS])
        for part, (size, rate) in BOUNDS.items():
            halcmd("setp", "kinetostat.max-correction", str(size))
            halcmd("setp", "kinetostat.max-correction-rate", str(rate))
            for number, cycle in enumerate(rows(part)):
                asked[len(asked) + 1] = (part, number, cycle)
                place, ahead, load, on = cycle
                inputs.write((float(len(asked)), *place, *ahead, *load, on))
            halcmd("setp", "streamer.0.enable", "1")
            while inputs.depth:
                time.sleep(0.1)
            halcmd("setp", "streamer.0.enable", "0")
            while (answer := outputs.read()) is not None:
                # The pins keep their last row between parts.
                if answer[0] != last:
                    last, (part, number, (place, ahead, load, on)) = answer[0], asked[int(answer[0])]
                    table.writerow([part, number, *place, *ahead, *load, int(on), *answer[1:]])
            if outputs.num_overruns:
                raise SystemExit("calls.py: samples were lost")


if __name__ == "__main__":
    main()
