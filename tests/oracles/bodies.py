#!/usr/bin/env python3
"""python3 bodies.py KINETOSTAT PAIRS [--poses N] [--seed S] [--arm NAME]

Bodies of the catalogue's arms in N random postures each, and a part that each overlaps, comes near, or encloses: distances of the example `pairs` of
crates/cell against Coal. Postures come from these kinematics (arms.py), which are held against the program and its machine files first.

Of each posture the three pairs with the part that are nearest, and of the links' own pairs one. Where the two do not agree, what lies between the bodies
along each of many directions decides. Fails where a sign differs beyond 0.05 mm, a distance by more than 1e-3 mm or a depth by more than 0.05 mm, and
where a class is empty.
"""

import argparse
import collections
import subprocess
import sys

import arms
import numpy as np

SIGN_MM, DISTANCE_MM, DEPTH_MM = 0.05, 1e-3, 0.05
# Apart by less than this is near, mm.
NEAR_MM = 20.0
# Sizes in mm are those of an arm with so much reach.
REACH_MM = 2900.0
# Shares of the postures in which the part overlaps, and in which it overlaps or is near; of the overlapping ones those where one encloses the other.
OVERLAPS, NEARS, ENCLOSES = 0.30, 0.74, 0.2
# Share in which the part has its faces and axes along those of a body, and its middle on one of its axes or in its middle, as clamps and fixtures do.
ALIGNED = 0.25
# Of these, the share in which the part touches the body, as closely as numbers tell.
TOUCHES = 0.3
CLASSES = ("encloses", "overlaps", "near", "apart")


def bodies_of(arm):
    """The bodies of an arm: name, index of the frame, shape and its pose in the frame."""
    size = arm.reach / REACH_MM
    home = arm.frames(arm.solve(arm.home_guess, arm.home))
    height = 0.6 * max(200.0 * size, home[2][2, 3])
    found = [("pedestal", 0, ("cylinder", height, 250.0 * size), arms.pose(at=(0.0, 0.0, 0.5 * height)))]
    kinds = ["box", "hull", "capsule", "cylinder", "capsule", "cylinder"]
    radii = [200.0, 160.0, 180.0, 150.0, 140.0, 110.0]
    rng = np.random.default_rng(7)
    for k, (kind, radius) in enumerate(zip(kinds, radii)):
        to, radius = arm.fixed[k + 1][:3, 3], radius * size
        length = np.linalg.norm(to)
        direction = to if length > 1.0 else np.eye(3)[arm.axes[k]]
        # Links of a wrist whose axes meet have no length of their own.
        length = max(length, 60.0 * size)
        at = arms.pose(arms.along(direction), 0.5 * to)
        if kind == "box":
            shape = (kind, 2.0 * radius, 1.6 * radius, length)
        elif kind == "hull":
            around = rng.uniform(0.0, 2.0 * np.pi, 24)
            across = radius * np.column_stack([np.cos(around), 0.7 * np.sin(around)]) * rng.uniform(0.6, 1.0, (24, 1))
            shape = (kind, np.column_stack([across, 0.55 * length * np.repeat([-1.0, 1.0], 12)]))
        else:
            shape = (kind, length, radius)
        found.append((f"link {k + 1}", k + 1, shape, at))
    length = 300.0 * size
    centre = arm.tip - (0.5 * length + 20.0 * size) * arm.tool_axis
    found.append(("spindle", 7, ("cylinder", length, 60.0 * size), arms.pose(arms.along(arm.tool_axis), centre)))
    return found


def a_part(rng, size, low, high):
    """A box, a cylinder or a hull of half extents in an interval."""
    kind = rng.choice(["box", "cylinder", "hull"])
    half = size * np.exp(rng.uniform(np.log(low), np.log(high), 3))
    if kind == "box":
        return (kind, *(2.0 * half))
    if kind == "cylinder":
        return (kind, 2.0 * half[0], half[1])
    return (kind, rng.uniform(-1.0, 1.0, (int(rng.integers(6, 30)), 3)) * half)


def encloses(outer, at, inner, beside):
    """Whether a convex body encloses another wholly: a ball around that one is deeper in it than it is wide."""
    radius = arms.ball(inner)
    return arms.distance(arms.geometry(outer), arms.transform(at), arms.coal.Sphere(radius), arms.transform(beside)) < -2.0 * radius


class Postures:
    """Random postures of an arm with a part, by a seed."""

    def __init__(self, arm, seed):
        self.arm, self.bodies, self.rng = arm, bodies_of(arm), np.random.default_rng(seed)
        self.size = arm.reach / REACH_MM
        self.shapes = [shape for _, _, shape, _ in self.bodies]
        self.solids = [arms.geometry(shape) for shape in self.shapes]
        self.balls = [arms.ball(shape) for shape in self.shapes]
        frames = [frame for _, frame, _, _ in self.bodies]
        # Neighbours overlap in their joint, whatever the posture.
        self.own = [(a, b) for b in range(len(frames)) for a in range(b) if frames[b] - frames[a] > 1]

    def turned(self):
        return arms.roll_pitch_yaw(self.rng.uniform(-180.0, 180.0, 3))

    def part(self, poses):
        """A part, its pose, and the class that is wanted, for which there is none where it is anywhere."""
        rng, share = self.rng, self.rng.random()
        k = int(rng.integers(len(poses)))
        rotation, middle = self.turned(), poses[k][:3, 3]
        is_aligned = rng.random() < ALIGNED
        if is_aligned:
            rotation = poses[k][:3, :3] @ arms.roll_pitch_yaw(90.0 * rng.integers(0, 4, 3))
        jitter = 0.0 if is_aligned else 0.1 * self.balls[k]
        if share < OVERLAPS * ENCLOSES:
            if rng.random() < 0.5:
                small = a_part(rng, self.balls[k], 0.02, 0.06)
                return small, arms.pose(rotation, middle + jitter * rng.uniform(-1.0, 1.0, 3))
            large = ("box", *(2.0 * self.balls[k] * rng.uniform(1.2, 2.0, 3)))
            return large, arms.pose(rotation, middle + jitter * rng.uniform(-1.0, 1.0, 3))
        shape = a_part(rng, self.size, 10.0, 250.0)
        if share > NEARS:
            return shape, arms.pose(rotation, self.rng.uniform(-1.0, 1.0, 3) * self.arm.reach)
        wanted = -60.0 * self.size * rng.random() if share < OVERLAPS else NEAR_MM * rng.random()
        if is_aligned and rng.random() < TOUCHES:
            wanted = 0.0
        # Along a line away from the body, to where the distance is what is wanted.
        away = rng.normal(size=3)
        away = rotation[:, rng.integers(3)] if is_aligned else away / np.linalg.norm(away)
        solid, near, far = arms.geometry(shape), 0.0, self.balls[k] + arms.ball(shape) + NEAR_MM
        for _ in range(14 if wanted else 48):
            at = arms.pose(rotation, middle + 0.5 * (near + far) * away)
            is_near = arms.distance(self.solids[k], arms.transform(poses[k]), solid, arms.transform(at)) < wanted
            near, far = (0.5 * (near + far), far) if is_near else (near, 0.5 * (near + far))
        return shape, arms.pose(rotation, middle + near * away)

    def one(self):
        """The class of a posture, and its pairs: shapes, poses and the distance by Coal."""
        travel = self.arm.travel
        frames = self.arm.frames(self.rng.uniform(travel[:, 0], travel[:, 1]))
        poses = [frames[frame] @ at for _, frame, _, at in self.bodies]
        placed = [arms.transform(at) for at in poses]
        part, at = self.part(poses)
        solid, beside = arms.geometry(part), arms.transform(at)
        apart = [arms.distance(own, place, solid, beside) for own, place in zip(self.solids, placed)]
        nearest = np.argsort(apart)[:3]
        pairs = [(self.shapes[k], part, poses[k], at, apart[k]) for k in nearest]
        a, b = self.own[int(self.rng.integers(len(self.own)))]
        found = arms.distance(self.solids[a], placed[a], self.solids[b], placed[b])
        pairs.append((self.shapes[a], self.shapes[b], poses[a], poses[b], found))
        first = nearest[0]
        kind = "overlaps" if apart[first] < 0.0 else "near" if apart[first] < NEAR_MM else "apart"
        if kind == "overlaps":
            deep = [k for k in nearest if apart[k] < 0.0]
            both = [((self.shapes[k], poses[k]), (part, at)) for k in deep]
            if any(encloses(*one, *other) or encloses(*other, *one) for one, other in both):
                kind = "encloses"
        return kind, pairs


def distances(pairs_program, pairs):
    """The distances that the example says."""
    lines = [f"{arms.words(a)}|{arms.words(b)}|{arms.pose_words(at)}|{arms.pose_words(beside)}\n" for a, b, at, beside, _ in pairs]
    told = subprocess.run([pairs_program, "-"], input="".join(lines), check=True, capture_output=True, text=True)
    found = [float(line) for line in told.stdout.split()]
    if len(found) != len(pairs):
        raise SystemExit(f"{len(pairs)} pairs, {len(found)} distances")
    return found, lines


def judge(pairs, found, lines):
    """The numbers of pairs apart and overlapping, the largest differences of them, how often Coal was wrong, and what else is."""
    count, worst, overruled, wrong = [0, 0], [0.0, 0.0], 0, []
    for (one, other, at, beside, theirs), own, line in zip(pairs, found, lines):
        if not agrees(own, theirs):
            # Where searches of both end in other places, directions tell which is right.
            right = arms.by_directions(one, at, other, beside)
            overruled += not agrees(right, theirs)
            theirs = right
        overlaps = theirs < 0.0
        count[overlaps] += 1
        worst[overlaps] = max(worst[overlaps], abs(theirs - own))
        if not agrees(own, theirs):
            wrong.append(f"{line.strip()}: {own} mm, right is {theirs}")
    return count, worst, overruled, wrong


def agrees(own, theirs):
    has_other_sign = abs(theirs) > SIGN_MM and (own < 0.0) != (theirs < 0.0)
    return not has_other_sign and abs(theirs - own) <= (DEPTH_MM if theirs < 0.0 else DISTANCE_MM)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinetostat")
    parser.add_argument("pairs", help="the example of crates/cell")
    parser.add_argument("--poses", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--arm", help="this one of the catalogue alone")
    asked = parser.parse_args()
    machines = {name: own for name, own in arms.catalogue(asked.kinetostat).items() if arms.is_arm(own)}
    faults, seen = [], 0
    for name, machine in machines.items():
        if asked.arm not in (None, name):
            continue
        arm = arms.Arm(machine)
        off = arms.check_home(asked.kinetostat, arm, machine["point"])
        postures = Postures(arm, asked.seed)
        kinds, pairs = collections.Counter(), []
        for _ in range(asked.poses):
            kind, own = postures.one()
            kinds[kind] += 1
            pairs += own
        count, worst, overruled, wrong = judge(pairs, *distances(asked.pairs, pairs))
        told = ", ".join(f"{kinds[kind]} {kind}" for kind in CLASSES)
        print(f"{name}: kinematics agree within {off:.0e} mm; {asked.poses} postures: {told}")
        print(f"  {count[0]} pairs apart, off by at most {worst[0]:.1e} mm; {count[1]} overlapping, off by at most {worst[1]:.1e} mm")
        print(f"  {len(wrong)} wrong, and {overruled} of Coal, as directions say", flush=True)
        faults += wrong
        faults += [f"{name}: no posture {kind}" for kind in CLASSES if not kinds[kind]]
        seen += 1
    if not seen:
        faults.append("no arm in the catalogue")
    if faults:
        print(f"{len(faults)} wrong, of which the shortest are")
    for fault in sorted(faults, key=len)[:20]:
        print(" ", fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
