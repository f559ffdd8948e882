"""Random programs and the exact volumes that they leave, for tests/volumes.rs.

    python3 -m venv venv && venv/bin/pip install manifold3d==3.5.4 numpy
    venv/bin/python crates/removal/tests/volumes/make.py crates/removal/tests/volumes/programs.json

What a cutter sweeps on a straight move is the convex hull of the cutter at both ends, as cutters are convex and open upwards. Such hulls are
subtracted from the stock with manifold3d. Circles are polygons of n and of 2 n corners, half of whose deviation is inside and half outside; the
volumes of both are extrapolated to n = infinity (the deviation is as 1/n²). `chord_error` is what the extrapolation moved the removed volume of 2 n
by, as a share of it: a bound of what is wrong after it. Arcs are chords in the program itself, so they are exact.
"""

import json
import math
import random
import sys

import numpy as np
from manifold3d import Manifold, OpType

HEIGHT = 60.0


def cutter_points(cutter, n):
    """Corners of the cutter with its tip at the origin, as a polyhedron about a body of revolution."""
    radius, corner = cutter["diameter"] / 2, cutter["corner"]
    # Equal area: a polygon of this radius has that of the circle.
    grow = math.sqrt(2 * math.pi / n / math.sin(2 * math.pi / n))
    rings = []
    if corner > 0:
        steps = max(2, n // 4)
        for k in range(steps + 1):
            phi = k * math.pi / 2 / steps
            rings.append((radius - corner + corner * math.sin(phi), corner * (1 - math.cos(phi))))
    else:
        rings.append((radius, 0.0))
    rings.append((radius, HEIGHT))
    points = []
    for r, z in rings:
        if r < 1e-12:
            points.append((0.0, 0.0, z))
            continue
        for k in range(n):
            a = 2 * math.pi * (k + 0.5) / n
            points.append((grow * r * math.cos(a), grow * r * math.sin(a), z))
    return np.array(points)


def stock_solid(stock, n):
    if stock["kind"] == "box":
        size = [h - l for l, h in zip(stock["low"], stock["high"])]
        return Manifold.cube(size).translate(stock["low"])
    radius = stock["diameter"] / 2
    grow = math.sqrt(2 * math.pi / n / math.sin(2 * math.pi / n))
    return Manifold.cylinder(stock["height"], radius * grow, radius * grow, n).translate(stock["base"])


def volumes(program, n):
    solid = stock_solid(program["stock"], 8 * n)
    before = solid.volume()
    sweeps = []
    for path in program["paths"]:
        points = cutter_points(path["cutter"], n)
        for a, b in zip(path["points"], path["points"][1:]):
            sweeps.append(Manifold.hull_points(np.vstack([points + a, points + b])))
    after = (solid - Manifold.batch_boolean(sweeps, OpType.Add)).volume()
    return before, after


def random_program(rng):
    if rng.random() < 0.6:
        w, d, h = rng.uniform(20, 45), rng.uniform(20, 45), rng.uniform(8, 20)
        x, y = rng.uniform(-5, 5), rng.uniform(-5, 5)
        stock = {"kind": "box", "low": [x, y, -h], "high": [x + w, y + d, 0.0]}
        centre, extent = (x + w / 2, y + d / 2), min(w, d) / 2
    else:
        diameter, h = rng.uniform(25, 50), rng.uniform(8, 20)
        centre, extent = (rng.uniform(-5, 5), rng.uniform(-5, 5)), diameter / 2
        stock = {"kind": "cylinder", "base": [*centre, -h], "diameter": diameter, "height": h}
    paths = []
    for _ in range(rng.randint(2, 5)):
        diameter = rng.choice([6.0, 8.0, 10.0, 12.0])
        corner = rng.choice([0.0, 0.0, diameter / 2, 1.0])
        paths.append({"cutter": {"diameter": diameter, "corner": corner}, "points": random_path(rng, centre, extent, h)})
    return {"stock": stock, "paths": paths}


def random_path(rng, centre, extent, height):
    def at(z):
        return [centre[0] + rng.uniform(-1.1, 1.1) * extent, centre[1] + rng.uniform(-1.1, 1.1) * extent, z]

    depth = -rng.uniform(0.5, 0.7 * height)
    kind = rng.choice(["lines", "ramps", "arc", "pocket"])
    if kind == "lines":
        return [at(depth) for _ in range(rng.randint(2, 5))]
    if kind == "ramps":
        return [at(-rng.uniform(0.2, 0.7 * height)) for _ in range(rng.randint(2, 4))]
    if kind == "arc":
        middle, radius = at(depth), rng.uniform(3, 0.8 * extent)
        start, span, chords = rng.uniform(0, 6.28), rng.uniform(1, 6.28), rng.randint(6, 16)
        angles = [start + span * k / chords for k in range(chords + 1)]
        return [[middle[0] + radius * math.cos(a), middle[1] + radius * math.sin(a), depth] for a in angles]
    a, b = at(depth), at(depth)
    rows = rng.randint(2, 4)
    points = []
    for row in range(rows + 1):
        y = a[1] + (b[1] - a[1]) * row / rows
        ends = [[a[0], y, depth], [b[0], y, depth]]
        points += ends if row % 2 == 0 else ends[::-1]
    return points


def main(out):
    rng = random.Random(20261127)
    programs = []
    while len(programs) < 50:
        program = random_program(rng)
        n = 96
        while True:
            (_, coarse), (before, fine) = volumes(program, n), volumes(program, 2 * n)
            exact_before = before
            after = fine + (fine - coarse) / 3
            removed = exact_before - after
            error = abs(fine - coarse) / 3 / max(removed, 1e-9)
            if error < 1e-4 or n >= 400:
                break
            n *= 2
        if removed < 50:
            continue
        program.update(stock_mm3=exact_before, removed_mm3=removed, chord_error=error)
        programs.append(program)
        print(len(programs), n, f"{removed:.3f} {error:.1e}", flush=True)
    with open(out, "w") as file:
        json.dump(programs, file, separators=(",", ":"))
        file.write("\n")



if __name__ == "__main__":
    main(sys.argv[1])
