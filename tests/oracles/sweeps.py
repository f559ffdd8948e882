#!/usr/bin/env python3
"""python3 sweeps.py KINETOSTAT [--from SEED] [--count N] [--keep FOLDER]

N random programs on machines of the catalogue, each a path study with bodies on platform, tool or links, and a thin rod put where one of them passes
strictly between two points of the path, or passes 1 mm away. Each way between two points is sampled a hundred times, and finer where that may find
less, by other kinematics (arms.py; platforms that keep their direction) and by Coal. Fails where

- something is hit that is not told, or told that is not hit,
- a program is called clear though it has ways that are not known here: rapid moves of parallel machines whose drives move at constant rates,
- the least distance that is told is more than that of a sample, but where bodies overlap by more than 5 mm, deeper than which nothing is sought,
  or less by more than 0.2 mm and what samples may miss,
- too few of the programs hit something between points alone, or pass it by.
"""

import argparse
import collections
import csv
import dataclasses
import json
import math
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import arms
import numpy as np

# Samples of each way between two points of a path, and to what the least of them is found, mm.
SAMPLES, FOUND_MM = 100, 0.01
# What is told may be above a sample, and below the least one, mm.
ABOVE_MM, BELOW_MM = 1e-3, 0.2
# Of depths beyond this the program tells that they are at least so, mm.
SOUGHT_MM = 5.0
# As near as this to touching, neither a hit nor none is asked for, mm.
TOUCHES_MM = 2e-3
ROD_MM, MISS_MM = 3.0, 1.0
# A rod stands clear of the bodies at the points of the path by this, mm.
CLEAR_MM = 0.5
# Of positions and joints of the two kinematics, mm and degrees.
SAME_MM, SAME_DEG = 1e-6, 1e-6
# Shares of the programs that must hit between points alone, do so on joint ways, and pass a rod by.
BETWEEN, JOINT, PASSED = 0.3, 0.05, 0.1
# Parallel machines whose platform keeps its direction on a straight way.
PARALLEL = ("orthoglide", "delta_3puu", "delta_3prpar", "tripteron", "rotary_delta", "hexapod")


@dataclasses.dataclass
class Body:
    name: str
    # "platform" or "tool", or the number of the drive whose link it is on.
    on: object
    shape: tuple
    # In the frame that it is on.
    at: np.ndarray

    def __post_init__(self):
        self.solid, self.ball = arms.geometry(self.shape), arms.ball(self.shape)


class Machine:
    """A machine with its platform turned as at home: what moves with it, and how."""

    def __init__(self, name, text):
        self.name, self.text = name, text
        own = tomllib.loads(text)
        self.arm = arms.Arm(own) if arms.is_arm(own) else None
        self.rotation = arms.frame_pose(own.get("home", {}))[:3, :3]
        self.low, self.high = (np.array(own["workspace"][key]) for key in ("min_mm", "max_mm"))
        platform = own["platform"]
        self.tip = np.array(platform["tool_tip_mm"], float)
        self.tool = arms.pose(tool_axes(np.array(platform.get("tool_axis", self.tip), float)), self.tip)
        self.home = self.arm.solve(self.arm.home_guess, self.arm.home) if self.arm else None
        self.drives = [element["name"] for element in revolute_drives(own)] if self.arm else []


def tool_axes(along):
    """The axes of the tool frame: z along the tool, x that of P across it, or y of P where the tool is along x."""
    # A machine whose tool tip is P, and says no more, has it along z.
    z = along / np.linalg.norm(along) if along.any() else np.array([0.0, 0.0, 1.0])
    x = np.array([1.0, 0.0, 0.0]) - z[0] * z
    if np.linalg.norm(x) < 1e-6:
        x = np.array([0.0, 1.0, 0.0])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def revolute_drives(machine):
    elements = machine["chain"][0]["elements"]
    return [element["revolute_drive"] for element in elements if "revolute_drive" in element]


class Way:
    """The way between two points of a path: poses of bodies for s from 0 to 1."""

    def __init__(self, machine, bodies, kind, ends, joints):
        self.machine, self.kind, self.ends, self.joints = machine, kind, ends, joints
        self.is_known = kind == "linear" or machine.arm is not None
        self.needs_joints = kind == "joint" or any(isinstance(body.on, int) for body in bodies)
        self.known = {}

    def frames(self, s):
        """The poses of P and, of arms, of the frame behind each drive, by number."""
        if s not in self.known:
            self.known[s] = self.solved(s)
        return self.known[s]

    def solved(self, s):
        machine = self.machine
        position = (1.0 - s) * self.ends[0] + s * self.ends[1]
        if machine.arm and self.needs_joints:
            joints = (1.0 - s) * self.joints[0] + s * self.joints[1]
            if self.kind == "linear":
                joints = machine.arm.solve(joints, arms.pose(machine.rotation, position))
            frames = machine.arm.frames(joints)
            return {"platform": frames[-1], **dict(enumerate(frames[:-1]))}
        return {"platform": arms.pose(machine.rotation, position)}

    def body(self, body, s):
        frames = self.frames(s)
        if body.on == "tool":
            return frames["platform"] @ self.machine.tool @ body.at
        return frames[body.on] @ body.at


def apart(way, body, s, rod):
    at = way.body(body, s)
    return arms.distance(body.solid, arms.transform(at), rod.solid, rod.transform), at


@dataclasses.dataclass
class Rod:
    low: np.ndarray
    length: float

    def __post_init__(self):
        self.solid = arms.coal.Cylinder(ROD_MM, self.length)
        self.transform = arms.transform(arms.pose(at=self.low + [0.0, 0.0, 0.5 * self.length]))


def moved(body, here, there):
    """A bound of how far a point of a body has moved, with a tenth more, as it need not have moved straight."""
    off = there[:3, :3] - here[:3, :3]
    return 1.1 * (np.linalg.norm(there[:3, 3] - here[:3, 3]) + body.ball * np.linalg.norm(off))


def least_on(way, body, rod, known, is_fine):
    """The least distance of samples of a way, and a bound of the least between them as far as it is below `known`."""
    shares = [k / SAMPLES for k in range(SAMPLES + 1)]
    found = [apart(way, body, s, rod) for s in shares]
    least, bound = min(own for own, _ in found), math.inf
    if not is_fine:
        return least, -math.inf
    least = min(least, known)
    open_ways = list(zip(shares, found, shares[1:], found[1:]))
    while open_ways:
        s, here, t, there = open_ways.pop()
        lower = 0.5 * (here[0] + there[0] - moved(body, here[1], there[1]))
        if lower > least - FOUND_MM:
            bound = min(bound, lower)
            continue
        middle = 0.5 * (s + t)
        own = apart(way, body, middle, rod)
        least = min(least, own[0])
        open_ways += [(s, here, middle, own), (middle, own, t, there)]
    return least, bound


class Program:
    """A random program by its seed, and the rod in its way."""

    def __init__(self, machines, seed):
        self.rng = rng = np.random.default_rng(seed)
        self.machine = machine = machines[seed % len(machines)]
        self.rapid = str(rng.choice(["linear", "joint"], p=[0.25, 0.75] if machine.arm else [0.85, 0.15]))
        self.wanted = str(rng.choice(["hit", "near", "any"], p=[0.7, 0.25, 0.05]))
        self.rod_on = str(rng.choice(["base", "part"]))
        self.points()
        self.bodies = self.some_bodies()
        self.ways = self.all_ways()

    def points(self):
        """Ends of the moves, as tips in the frame of the workpiece with three digits."""
        rng, machine = self.rng, self.machine
        middle, half = 0.5 * (machine.low + machine.high), 0.5 * (machine.high - machine.low)
        self.size = 2.0 * half.min()
        centre, reach = middle + rng.uniform(-0.3, 0.3, 3) * half, rng.uniform(0.3, 0.6) * half
        positions = centre + rng.uniform(-1.0, 1.0, (int(rng.integers(4, 8)), 3)) * reach
        if rng.random() < 0.4:
            # Most cuts are at a height.
            positions[1:3, 2] = positions[0, 2]
        offset = machine.rotation @ machine.tip
        self.origin = np.round(centre + offset + rng.uniform(-50.0, 50.0, 3), 3)
        self.tips = np.round(positions + offset - self.origin, 3)
        self.positions = self.tips + self.origin - offset
        self.codes = ["G1", *(str(code) for code in rng.choice(["G1", "G0"], len(positions) - 1))]
        self.segment = round(float(rng.uniform(0.5, 2.0) * np.linalg.norm(reach)), 1)

    def some_bodies(self):
        rng, machine = self.rng, self.machine
        scale = machine.arm.reach / 2900.0 if machine.arm else 0.0
        found = []
        for k in range(int(rng.integers(1, 3))):
            radius = 60.0 * scale if machine.arm and rng.random() < 0.3 else self.size * rng.uniform(0.02, 0.08)
            length, on = self.size * rng.uniform(0.1, 0.4), str(rng.choice(["platform", "tool"]))
            # Along the tool, ending a little behind its tip, and not quite straight.
            frame = np.eye(4) if on == "tool" else machine.tool
            tilt = arms.roll_pitch_yaw(rng.uniform(-15.0, 15.0, 3)) if rng.random() < 0.4 else np.eye(3)
            at = frame @ arms.pose(tilt, (0.0, 0.0, -0.55 * length))
            found.append(Body(f"body {k + 1}", on, a_shape(rng, radius, length), at))
        if machine.arm and rng.random() < 0.3:
            # A forearm or what is behind it, and no more: neighbours meet.
            drive = int(rng.choice([3, 3, 4, 5]))
            to = machine.arm.fixed[drive][:3, 3]
            length = max(np.linalg.norm(to), 60.0 * scale)
            direction = to if np.linalg.norm(to) > 1.0 else np.eye(3)[machine.arm.axes[drive - 1]]
            shape = a_shape(rng, scale * rng.uniform(30.0, 90.0), length)
            found.append(Body("link", drive, shape, arms.pose(arms.along(direction), 0.5 * to)))
        # Without a body up to the tool tip it is told that no cutter was looked at.
        found.append(Body("cutter", "tool", ("capsule", 2.0, 0.5), arms.pose(at=(0.0, 0.0, -1.5))))
        return found

    def all_ways(self):
        """The ways between the points of the path that are known here; a cut is divided as [sampling] says."""
        points, kinds = [self.positions[0]], []
        for end, code in zip(self.positions[1:], self.codes[1:]):
            begin = points[-1]
            pieces = max(1, math.ceil(np.linalg.norm(end - begin) / self.segment - 1e-9)) if code == "G1" else 1
            points += [begin + (end - begin) * k / pieces for k in range(1, pieces + 1)]
            kinds += pieces * ["linear" if code == "G1" else self.rapid]
        self.path, arm = points, self.machine.arm
        self.joints = [None] * len(points)
        if arm:
            self.joints, at = [], self.machine.home
            for point in points:
                at = arm.solve(at, arms.pose(self.machine.rotation, point))
                self.joints.append(at)
        pairs = zip(kinds, zip(points, points[1:]), zip(self.joints, self.joints[1:]))
        ways = [Way(self.machine, self.bodies, kind, ends, joints) for kind, ends, joints in pairs]
        self.is_known = all(way.is_known for way in ways)
        # Where a way ends is known, however it leads there.
        self.ends = [(way, s) for way in ways for s in (0.0, 1.0)]
        return [way for way in ways if way.is_known]

    def least(self, rod, is_fine=True):
        """The least distance along the path, and a bound of what samples may miss."""
        least, bound = self.at_points(rod), math.inf
        for way in self.ways:
            for body in self.bodies:
                own, lower = least_on(way, body, rod, least, is_fine)
                least, bound = min(least, own), min(bound, lower)
        return least, max(0.0, least - bound)

    def at_points(self, rod):
        """The least distance at the points of the path alone."""
        return min(apart(way, body, s, rod)[0] for way, s in self.ends for body in self.bodies)

    def put_rod(self):
        """Puts the rod; `None` where no place for it was found."""
        rng = self.rng
        for _ in range(80 if self.ways else 0):
            way = self.ways[int(rng.integers(len(self.ways)))]
            # Not the cutter, which few rods would meet.
            body = self.bodies[int(rng.integers(len(self.bodies) - 1))]
            self.where = f"{way.kind} ways{' of links' if isinstance(body.on, int) else ''}"
            s = float(rng.uniform(0.2, 0.8))
            here, there = way.body(body, s), way.body(body, s + 0.01)
            direction = (there - here)[:2, 3]
            if np.linalg.norm(direction) < 1e-3:
                continue
            across = np.array([-direction[1], direction[0], 0.0]) / np.linalg.norm(direction) * rng.choice([-1.0, 1.0])
            place = (here @ [0.0, 0.0, rng.uniform(-0.4, 0.4) * height(body.shape), 1.0])[:3]
            below, above = np.exp(rng.uniform(np.log(3.0), np.log(100.0), 2))
            rod = lambda beside: Rod(np.round(place + beside * across - [0.0, 0.0, below], 4), round(float(below + above), 4))
            if self.wanted == "any":
                return rod(rng.uniform(-3.0, 3.0) * body.ball)
            if self.wanted == "hit":
                own = rod(rng.uniform(0.0, 1.0) * width(body.shape))
                if apart(way, body, s, own)[0] < -0.05 and self.at_points(own) > CLEAR_MM:
                    return own
                continue
            # Aside until it is passed by 1 mm.
            near, far = 0.0, 2.0 * body.ball + 10.0
            for _ in range(16):
                middle = 0.5 * (near + far)
                is_near = least_on(way, body, rod(middle), math.inf, False)[0] < MISS_MM
                near, far = (middle, far) if is_near else (near, middle)
            own = rod(far)
            if self.at_points(own) > CLEAR_MM and 0.5 * MISS_MM < self.least(own, False)[0] < 1.5 * MISS_MM:
                return own
        return None

    def write(self, folder, rod):
        """Writes the study into a folder."""
        text, links = self.machine.text, [body for body in self.bodies if isinstance(body.on, int)]
        for body in links:
            name = self.machine.drives[body.on - 1]
            [line] = [line for line in text.splitlines() if "revolute_drive" in line and f'name = "{name}"' in line]
            own = f'  {{ body = {{ name = "{body.name}", grade = "given", shapes = [{toml(body.shape, body.at)}] }} }},'
            text = text.replace(line, f"{line}\n{own}")
        (folder / "machine.toml").write_text(text)
        lines = ["schema = 1", "[placement]", f"origin_mm = {numbers(self.origin)}", "[sampling]", f"max_segment_mm = {self.segment!r}"]
        lines += ["[cell]", f'rapid = "{self.rapid}"']
        others = [body for body in self.bodies if body not in links]
        # How the machine's own links stand to one another is not asked.
        lines += [f"may_touch = {json.dumps([[body.name, link.name] for body in others for link in links])}"]
        for body in others:
            lines += entry(body.name, body.on, toml(body.shape, body.at))
        at = rod.low - (self.origin if self.rod_on == "part" else 0.0)
        lines += entry("rod", self.rod_on, toml(("cylinder", rod.length, ROD_MM), arms.pose(at=at + [0.0, 0.0, 0.5 * rod.length])))
        (folder / "process.toml").write_text("\n".join(lines) + "\n")
        moves = [f"{code} X{x:.3f} Y{y:.3f} Z{z:.3f}{' F1000' if code == 'G1' else ''}" for code, (x, y, z) in zip(self.codes, self.tips)]
        (folder / "part.nc").write_text("\n".join(["G21 G90", *moves, "M30", ""]))
        study = ["schema = 3", 'question = "?"', 'machine = "machine.toml"', 'process = "process.toml"']
        (folder / "study.toml").write_text("\n".join([*study, "[path]", 'file = "part.nc"', 'methods = ["none"]', ""]))


def a_shape(rng, radius, length):
    kind = str(rng.choice(["capsule", "cylinder", "box", "hull"]))
    if kind in ("capsule", "cylinder"):
        return (kind, float(length), float(radius))
    if kind == "box":
        return (kind, float(2.0 * radius), float(1.5 * radius), float(length))
    around = rng.uniform(0.0, 2.0 * np.pi, 16)
    ends = 0.5 * length * np.repeat([-1.0, 1.0], 8)
    return (kind, np.column_stack([radius * np.cos(around), radius * np.sin(around), ends]))


def width(shape):
    """Half the width of a shape across its axis."""
    kind, *sizes = shape
    return {"box": lambda: 0.5 * sizes[0], "hull": lambda: abs(sizes[0][:, 0]).max()}.get(kind, lambda: sizes[1])()


def height(shape):
    kind, *sizes = shape
    return {"box": lambda: sizes[2], "hull": lambda: np.ptp(sizes[0][:, 2])}.get(kind, lambda: sizes[0])()


def numbers(values):
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"


def toml(shape, at):
    """A shape as files have it, at a pose."""
    kind, *sizes = shape
    if kind == "box":
        angles = numbers(np.degrees(arms.angles(at[:3, :3])))
        return f"{{ box = {{ size_mm = {numbers(sizes)}, at_mm = {numbers(at[:3, 3])}, rotation_deg = {angles} }} }}"
    if kind == "hull":
        points = [numbers(at[:3, :3] @ point + at[:3, 3]) for point in sizes[0]]
        return f"{{ hull = {{ points_mm = [{', '.join(points)}] }} }}"
    length, radius = sizes
    ends = [numbers((at @ [0.0, 0.0, end * length, 1.0])[:3]) for end in (-0.5, 0.5)]
    return f"{{ {kind} = {{ from_mm = {ends[0]}, to_mm = {ends[1]}, radius_mm = {float(radius)!r} }} }}"


def entry(name, on, shape):
    return ["[[cell.body]]", f'name = "{name}"', f'on = "{on}"', 'grade = "given"', f"shapes = [{shape}]"]


def check_points(program, table):
    """What differs between the program's points and these; `None` where nothing does."""
    with open(table) as file:
        rows = [row for row in csv.DictReader(file) if row["source"] == "cutting"]
    if len(rows) != len(program.path):
        return f"{len(rows)} points, {len(program.path)} here"
    for k, (row, point, joints) in enumerate(zip(rows, program.path, program.joints)):
        theirs = [float(row[f"nominal_platform_{axis}_mm"]) for axis in "xyz"]
        if abs(np.array(theirs) - point).max() > SAME_MM:
            return f"point {k} at {theirs}, {point} here"
        if joints is not None:
            arm = program.machine.arm
            shown = np.radians([float(row[f"rho_nominal_{label}_deg"]) for label in arm.labels])
            if abs(np.degrees(arm.joints(shown) - joints)).max() > SAME_DEG:
                return f"joints of point {k}: {np.degrees(arm.joints(shown))}, {np.degrees(joints)} here"
    return None


def judge(kinetostat, program, rod, folder):
    """What kind of program it was, and what is wrong with the answer to it."""
    program.write(folder, rod)
    command = [kinetostat, "run", str(folder), "--no-figures", "--out", str(folder / "out")]
    ran = subprocess.run(command, capture_output=True, text=True)
    if ran.returncode not in (0, 1):
        return "refused", [(ran.stdout + ran.stderr).strip()[:300]]
    wrong = [own for own in [check_points(program, folder / "out/points.csv")] if own]
    told = json.loads((folder / "out/summary.json").read_text())["clearance"]
    least, missed = program.least(rod)
    at_points, is_whole = program.at_points(rod), not told["not_looked_at"]
    if told["state"] == "clear" and not program.is_known:
        wrong.append("called clear though where its drives take it is not known")
    if program.is_known and not is_whole:
        wrong.append(f"not looked at: {told['not_looked_at']}")
    said = told["at_least_mm"] if told["at_least_mm"] is not None else math.inf
    is_told = (ran.returncode == 1, told["state"] == "hit")
    if least < -TOUCHES_MM and is_told != (True, True):
        wrong.append(f"a hit by {-least:.4f} mm is not told: {told['state']}, exit code {ran.returncode}")
    if least - missed > TOUCHES_MM and is_told != (False, False):
        wrong.append(f"{least:.4f} mm apart, told {told['state']}, exit code {ran.returncode}")
    if said > max(least, -SOUGHT_MM) + ABOVE_MM:
        wrong.append(f"at least {said} mm is told, a sample is at {least} mm")
    if is_whole and said < least - missed - BELOW_MM:
        wrong.append(f"at least {said} mm is told, the least of samples is {least} mm, which may miss {missed:.3f} mm")
    if least < 0.0:
        kind = "hits between points" if at_points > 0.0 else "hits at a point"
    else:
        kind = "passes" if least < 2.0 * MISS_MM else "is far"
    return (kind if is_whole else f"{kind}, not all looked at"), wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinetostat")
    parser.add_argument("--from", type=int, default=1, dest="first")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--keep", type=Path, help="where the studies of programs with a wrong answer are left")
    asked = parser.parse_args()
    named = {name: own for name, own in arms.catalogue(asked.kinetostat).items() if arms.is_arm(own) or name in PARALLEL}
    machines = [Machine(name, arms.machine_file(asked.kinetostat, name)) for name in named]
    kinds, ways, hits, wrong, without = collections.Counter(), collections.Counter(), collections.Counter(), [], 0
    seed, count = asked.first, 0
    while count < asked.count:
        program = Program(machines, seed)
        rod = program.put_rod()
        if rod is None:
            without += 1
            if without > asked.count:
                raise SystemExit(f"no place for a rod in {without} programs")
            seed += 1
            continue
        folder = Path(tempfile.mkdtemp(prefix="sweeps_"))
        kind, faults = judge(asked.kinetostat, program, rod, folder)
        kinds[kind] += 1
        ways.update(way.kind for way in program.ways)
        hits[program.where] += kind == "hits between points"
        wrong += [f"seed {seed}, {program.machine.name}: {fault}" for fault in faults]
        if faults and asked.keep:
            shutil.copytree(folder, asked.keep / f"seed_{seed}", dirs_exist_ok=True)
        shutil.rmtree(folder)
        seed, count = seed + 1, count + 1
    told = ", ".join(f"{number} {kind}" for kind, number in kinds.most_common())
    print(f"{count} programs ({without} others without a place for a rod), {ways['linear']} linear ways, {ways['joint']} joint ways: {told}")
    print(f"hits between points: {', '.join(f'{number} on {where}' for where, number in hits.most_common())}")
    joint = sum(number for where, number in hits.items() if where.startswith("joint"))
    asked_for = [("hits between points", kinds["hits between points"], BETWEEN), ("hits on joint ways", joint, JOINT), ("passes", kinds["passes"], PASSED)]
    wrong += [f"only {number} of {count}: {kind}" for kind, number, share in asked_for if number < share * count]
    for fault in wrong[:20]:
        print(" ", fault)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
