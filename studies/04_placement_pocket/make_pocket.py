#!/usr/bin/env python3
"""Writes pocket.nc: the last pass over the floor of a pocket with two round islands.

The pocket is 64 mm x 44 mm with corners of radius 8 mm, its middle is the origin, the top of the part is z = 0. The
Orthoglide's tool points to +z, so the floor is at z = 2 mm and the tool is lifted to z = -5 mm. A tool of 10 mm clears it in lines along x, going around the islands, and finishes with the wall of
the pocket (counter-clockwise about z) and of the islands (clockwise). Coordinates are those of the tool tip.

    python3 make_pocket.py > pocket.nc
"""
from math import sqrt

LENGTH, WIDTH, CORNER = 64.0, 44.0, 8.0
TOOL = 10.0
ISLANDS = [(-13.0, 4.0, 6.0), (14.0, -5.0, 5.0)]  # centre x, y, radius
FLOOR, SAFE = 2.0, -5.0
STEP = 6.8  # between lines, at most
FEED, SPINDLE = 900, 6000  # mm/min, rev/min: 0.05 mm per tooth with three teeth


def free_intervals(y, half):
    """Parts of the line at height y, from -half to half, that keep the tool off the islands."""
    parts = [(-half, half)]
    for x0, y0, radius in ISLANDS:
        reach = radius + TOOL / 2
        if abs(y - y0) >= reach:
            continue
        chord = sqrt(reach**2 - (y - y0) ** 2)
        cut = []
        for a, b in parts:
            cut += [(a, min(b, x0 - chord)), (max(a, x0 + chord), b)]
        parts = [(a, b) for a, b in cut if b - a > 1e-9]
    return parts


def cut(points):
    """Goes down at the first point, cuts to the others, goes up."""
    (x, y), rest = points[0], points[1:]
    print(f"G0 X{x:.3f} Y{y:.3f}")
    print(f"G1 Z{FLOOR:.3f} F300")
    for k, (x, y) in enumerate(rest):
        print(f"G1 X{x:.3f} Y{y:.3f}" + (f" F{FEED}" if k == 0 else ""))
    print(f"G0 Z{SAFE:.3f}")


def main():
    half_x, half_y = (LENGTH - TOOL) / 2, (WIDTH - TOOL) / 2
    print("(Pocket with two islands, floor and walls; written by make_pocket.py)")
    print(f"G21 G17 G90 G54\nT1 M6\nS{SPINDLE} M3\nG0 X0.000 Y0.000 Z{SAFE:.3f}")
    print("(floor)")
    inner_x, inner_y = half_x - 0.5, half_y - 0.5
    lines = int(2 * inner_y / STEP) + 1
    for k in range(lines + 1):
        y = -inner_y + 2 * inner_y * k / lines
        parts = free_intervals(y, inner_x)
        if k % 2:
            parts = [(b, a) for a, b in reversed(parts)]
        for a, b in parts:
            cut([(a, y), (b, y)])
    print("(wall of the pocket)")
    r = CORNER - TOOL / 2
    x, y = half_x, half_y
    print(f"G0 X0.000 Y{-y:.3f}\nG1 Z{FLOOR:.3f} F300")
    print(f"G1 X{x - r:.3f} F{FEED}\nG3 X{x:.3f} Y{-y + r:.3f} I0.000 J{r:.3f}")
    print(f"G1 Y{y - r:.3f}\nG3 X{x - r:.3f} Y{y:.3f} I{-r:.3f} J0.000")
    print(f"G1 X{-x + r:.3f}\nG3 X{-x:.3f} Y{y - r:.3f} I0.000 J{-r:.3f}")
    print(f"G1 Y{-y + r:.3f}\nG3 X{-x + r:.3f} Y{-y:.3f} I{r:.3f} J0.000")
    print(f"G1 X0.000\nG0 Z{SAFE:.3f}")
    print("(walls of the islands)")
    for x0, y0, radius in ISLANDS:
        reach = radius + TOOL / 2
        print(f"G0 X{x0 + reach:.3f} Y{y0:.3f}\nG1 Z{FLOOR:.3f} F300")
        print(f"G2 X{x0 - reach:.3f} Y{y0:.3f} I{-reach:.3f} J0.000 F{FEED}")
        print(f"G2 X{x0 + reach:.3f} Y{y0:.3f} I{reach:.3f} J0.000")
        print(f"G0 Z{SAFE:.3f}")
    print("M5\nM30")


main()
