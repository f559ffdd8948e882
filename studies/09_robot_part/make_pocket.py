#!/usr/bin/env python3
"""Writes pocket.src: a pocket of 90 mm x 60 mm, 6 mm deep, on a face slanted by 35 degrees, cleared in two levels and finished along
its wall with a 12 mm cutter, as a KRL program. The frame is that of the part: z up, origin in the middle of the face.

usage: make_pocket.py > pocket.src
"""

from math import cos, radians, sin

SLANT = 35.0
CUTTER = 12.0
LENGTH, WIDTH, DEPTH, LEVELS = 90.0, 60.0, 6.0, 2
STEP = 7.0
CLEAR = 15.0


def pose(u, v, w):
    """A place on the face: u down the slope, v along it, w out of it."""
    c, s = cos(radians(SLANT)), sin(radians(SLANT))
    x, y, z = u * c + w * s, v, -u * s + w * c
    # Z-Y-X angles of a tool frame whose z axis points into the face.
    return f"{{X {x:.3f},Y {y:.3f},Z {z:.3f},A 0.000,B {SLANT:.3f},C 180.000}}"


def rings():
    """Half lengths and widths of the rings that clear the pocket, from the middle out; the last leaves 0.3 mm for the wall."""
    most_u, most_v = LENGTH / 2 - CUTTER / 2 - 0.3, WIDTH / 2 - CUTTER / 2 - 0.3
    count = int(most_v // STEP) + 1
    return [(most_u - most_v + most_v * k / count, most_v * k / count) for k in range(1, count + 1)]


def ring(u, v, w):
    return [(u, -v, w), (u, v, w), (-u, v, w), (-u, -v, w), (u, -v, w)]


lines = [
    "&ACCESS RVP",
    "&REL 1",
    "DEF pocket( )",
    ";FOLD INI",
    "  BAS(#INITMOV,0 )",
    ";ENDFOLD (INI)",
    "; pocket on a slanted face, cutter 12 mm",
    "$BASE = BASE_DATA[1]",
    "$TOOL = TOOL_DATA[1]",
    "$VEL.CP = 0.1",
    "PTP " + pose(0, 0, 80),
    "$OUT[1] = TRUE",
    "LIN " + pose(0, 0, CLEAR) + " C_DIS",
]
for level in range(1, LEVELS + 1):
    w = -DEPTH * level / LEVELS
    lines += [f"; level {level}", "$VEL.CP = 0.005", "LIN " + pose(0, 0, w), "$VEL.CP = 0.02"]
    for u, v in rings():
        lines += ["LIN " + pose(*point) + " C_DIS" for point in ring(u, v, w)]
    lines += ["LIN " + pose(0, 0, w) + " C_DIS"]
lines += ["; wall", "$VEL.CP = 0.015"]
u, v = LENGTH / 2 - CUTTER / 2, WIDTH / 2 - CUTTER / 2
lines += ["LIN " + pose(*point) + " C_DIS" for point in ring(u, v, -DEPTH)]
lines += ["LIN " + pose(0, 0, -DEPTH), "$VEL.CP = 0.1", "LIN " + pose(0, 0, CLEAR), "$OUT[1] = FALSE", "PTP " + pose(0, 0, 80), "END"]
print("\n".join(lines))
