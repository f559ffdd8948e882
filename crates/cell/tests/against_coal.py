"""Distances of random pairs of bodies against Coal (pip install coal==3.0.3 numpy).

cargo run --release -p kinetostat-cell --example pairs -- 1 20000 | python3 crates/cell/tests/against_coal.py

Fails where a sign differs beyond 0.05 mm, a distance by more than 1e-3 mm, or a depth by more than 0.05 mm.
"""

import sys

import coal
import numpy as np

SIGN_MM, DISTANCE_MM, DEPTH_MM = 0.05, 1e-3, 0.05


def shape(text):
    kind, *numbers = text.split()
    numbers = [float(number) for number in numbers]
    if kind == "box":
        return coal.Box(*numbers)
    if kind in ("capsule", "cylinder"):
        length, radius = numbers
        return (coal.Capsule if kind == "capsule" else coal.Cylinder)(radius, length)
    points = coal.StdVec_Vec3s()
    for point in np.reshape(numbers, (-1, 3)):
        points.append(point)
    return coal.Convex.convexHull(points, False, None)


def pose(text):
    *at, w, x, y, z = (float(number) for number in text.split())
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    return coal.Transform3s(turn, np.array(at))


def main():
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance, request.epa_tolerance = 1e-9, 1e-6
    request.gjk_max_iterations = request.epa_max_iterations = 1000
    count, worst, faults = [0, 0], [0.0, 0.0], []
    for line in sys.stdin:
        one, other, at, beside, own = line.rstrip("\n").split("|")
        theirs = coal.distance(shape(one), pose(at), shape(other), pose(beside), request, coal.DistanceResult())
        overlaps = theirs < 0
        off = abs(theirs - float(own))
        count[overlaps] += 1
        worst[overlaps] = max(worst[overlaps], off)
        has_other_sign = abs(theirs) > SIGN_MM and overlaps != (float(own) < 0)
        if has_other_sign or off > (DEPTH_MM if overlaps else DISTANCE_MM):
            faults.append(f"{one} and {other}: {own} mm, by Coal {theirs}")
    print(
        f"{count[0]} apart, off by at most {worst[0]:.1e} mm; {count[1]} that overlap, off by at most {worst[1]:.1e} mm"
    )
    sys.exit("\n".join(faults[:10]) if faults or not all(count) else 0)


if __name__ == "__main__":
    main()
