#!/usr/bin/env python3
"""Writes cone.nc: the wall of a frustum of a cone, 60 mm wide at its top, leaning in by 12 degrees, cut with the side of the tool in three
levels. The tool leans with the wall: A and C are those of a head that turns about z and then about x; the control keeps the tip in place.

usage: make_cone.py > cone.nc
"""

from math import cos, degrees, pi, radians, sin, tan

LEAN = 12.0
RADIUS = 30.0
LEVELS = [-4.0, -8.0, -12.0]
CUTTER = 5.0
STEPS = 72

print("%\nO0010 (CONE, 10 MM CUTTER)\nG21 G90 G17 G94 G40\nT1 M6\nS9000 M3\nG0 X0. Y0. Z40. A0. C0.\nG43.4 H1")
for level in LEVELS:
    radius = RADIUS - level * tan(radians(LEAN)) + CUTTER / cos(radians(LEAN))
    for k in range(STEPS + 1):
        angle = 2 * pi * k / STEPS
        x, y = radius * cos(angle), radius * sin(angle)
        # C turns x of the head along the wall, A leans the tool towards the middle.
        c = degrees(angle) + 90.0
        if k == 0:
            print(f"G0 X{x + 10:.3f} Y{y:.3f} A{-LEAN:.3f} C{c:.3f}")
            print(f"Z{level:.3f}")
            print(f"G1 X{x:.3f} Y{y:.3f} F1200.")
        else:
            print(f"X{x:.3f} Y{y:.3f} C{c:.3f}")
    print(f"X{x + 10:.3f} Y{y:.3f}")
    print("G0 Z10.")
    print("C90.")
print("G0 Z40. A0. C0.\nG49\nM5\nM30\n%")
