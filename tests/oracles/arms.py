"""Serial arms and bodies of another hand: kinematics from the elements of machine files as docs/machine_format.md has them, distances by Coal.

Shared by bodies.py and sweeps.py. Poses are 4 by 4 matrices, lengths mm, angles rad; joints are those of the chain, not what a pendant shows.
"""

import json
import subprocess
import tomllib

import coal
import numpy as np

AXES = {"x": 0, "y": 1, "z": 2}
# Names of the catalogue: the list of `machines` is for readers, and a machine file says whether it is of an arm.
CATALOGUE_COLUMN = 2
# Elements that neither move the frame nor turn it.
STILL = ("mass", "body", "frame")
# Where the search for joints has come to, mm and rad.
REACHED = 1e-10
# Kinematics that are the same differ by no more.
SAME_MM, SAME_RAD = 1e-6, 1e-8


def turn(axis, angle):
    """The rotation about a local axis."""
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    rotation[i, i] = rotation[j, j] = c
    rotation[i, j], rotation[j, i] = -s, s
    return rotation


def roll_pitch_yaw(degrees):
    roll, pitch, yaw = np.radians(degrees)
    return turn(2, yaw) @ turn(1, pitch) @ turn(0, roll)


def angles(rotation):
    """Roll, pitch and yaw of a rotation."""
    across = np.hypot(rotation[0, 0], rotation[1, 0])
    pitch = np.arctan2(-rotation[2, 0], across)
    if across < 1e-9:
        # Roll and yaw turn about one axis.
        return np.array([0.0, pitch, np.arctan2(-rotation[0, 1], rotation[1, 1])])
    return np.array([np.arctan2(rotation[2, 1], rotation[2, 2]), pitch, np.arctan2(rotation[1, 0], rotation[0, 0])])


def pose(rotation=None, at=(0.0, 0.0, 0.0)):
    matrix = np.eye(4)
    if rotation is not None:
        matrix[:3, :3] = rotation
    matrix[:3, 3] = at
    return matrix


def along(direction):
    """A rotation that takes z into a direction."""
    z = np.asarray(direction, float) / np.linalg.norm(direction)
    x = np.cross(z, np.eye(3)[np.argmin(abs(z))])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def frame_pose(table):
    """The pose of a frame: its origin, and two of its axes or three angles."""
    if "x_axis" in table:
        x, y = (np.array(table[name], float) / np.linalg.norm(table[name]) for name in ("x_axis", "y_axis"))
        rotation = np.column_stack([x, y, np.cross(x, y)])
    else:
        rotation = roll_pitch_yaw(table.get("rotation_deg", (0.0, 0.0, 0.0)))
    return pose(rotation, table.get("position_mm", (0.0, 0.0, 0.0)))


def machine_file(program, name):
    return subprocess.run([program, "machines", "--show", name], check=True, capture_output=True, text=True).stdout


def catalogue(program):
    """The machine files of the catalogue by name."""
    listed = subprocess.run([program, "machines"], check=True, capture_output=True, text=True).stdout
    rows = [line for line in listed.splitlines()[2:] if line[CATALOGUE_COLUMN : CATALOGUE_COLUMN + 1].strip()]
    names = [row.split()[0] for row in rows]
    return {name: tomllib.loads(machine_file(program, name)) for name in names}


def is_arm(machine):
    kinds = [kind for element in machine["chain"][0]["elements"] for kind in element]
    moving = [kind for kind in kinds if kind not in STILL and kind != "fixed"]
    return len(machine["mount"]) == 1 and moving == 6 * ["revolute_drive"]


class Arm:
    """An arm of six revolute drives."""

    def __init__(self, machine):
        self.name = machine["name"]
        [mount], [chain] = machine["mount"], machine["chain"]
        self.base = frame_pose(mount.get("base", {}))
        # Fixed transforms before each drive and behind the last.
        self.fixed, self.axes, drives = [np.eye(4)], [], []
        for element in chain["elements"]:
            [(kind, own)] = element.items()
            if kind == "fixed":
                rotation = roll_pitch_yaw(own.get("rotation_deg", (0.0, 0.0, 0.0)))
                self.fixed[-1] = self.fixed[-1] @ pose(rotation, own.get("translation_mm", (0.0, 0.0, 0.0)))
            elif kind == "revolute_drive":
                self.axes.append(AXES[own["axis"]])
                self.fixed.append(np.eye(4))
                drives.append(own)
            elif kind not in STILL:
                raise ValueError(f"{self.name}: {kind}")
        self.fixed[-1] = self.fixed[-1] @ np.linalg.inv(frame_pose(mount.get("platform", {})))
        # What a pendant shows is shown = matrix · joints + offset.
        names = [own["name"] for own in drives]
        self.labels = [f"{mount['name']}_{name}" for name in names]
        self.shown, self.offset = np.eye(len(names)), np.zeros(len(names))
        for k, own in enumerate(drives):
            if "shown" in own:
                self.shown[k] = [own["shown"]["of"].get(name, 0.0) for name in names]
                self.offset[k] = np.radians(own["shown"].get("offset_deg", 0.0))
        self.travel = np.radians([own["travel_deg"] for own in drives])
        self.home_guess = self.joints(np.radians([own.get("home_deg", 0.0) for own in drives]))
        home = machine["home"]
        self.home = frame_pose(home)
        self.tip = np.array(machine["platform"]["tool_tip_mm"], float)
        axis = np.array(machine["platform"].get("tool_axis", self.tip), float)
        self.tool_axis = axis / np.linalg.norm(axis)
        # Farthest that the flange is from the base, about, mm.
        self.reach = sum(np.linalg.norm(fixed[:3, 3]) for fixed in self.fixed[1:])

    def joints(self, shown):
        return np.linalg.solve(self.shown, shown - self.offset)

    def frames(self, joints):
        """The poses of O, of the frame behind each drive, and of P."""
        poses, at = [np.eye(4)], self.base
        for fixed, axis, angle in zip(self.fixed, self.axes, joints):
            at = at @ fixed
            at[:3, :3] = at[:3, :3] @ turn(axis, angle)
            poses.append(at)
        return [*poses, at @ self.fixed[-1]]

    def jacobian(self, poses):
        """How P moves and turns, in O, with each joint."""
        columns = []
        for frame, axis in zip(poses[1:], self.axes):
            direction = frame[:3, axis]
            columns.append([*np.cross(direction, poses[-1][:3, 3] - frame[:3, 3]), *direction])
        return np.array(columns).T

    def solve(self, guess, wanted):
        """The joints with P at a pose, by Newton's method from a guess."""
        joints = np.array(guess, float)
        for _ in range(50):
            poses = self.frames(joints)
            off = wanted[:3, :3] @ poses[-1][:3, :3].T
            twist = 0.5 * np.array([off[2, 1] - off[1, 2], off[0, 2] - off[2, 0], off[1, 0] - off[0, 1]])
            error = np.array([*(wanted[:3, 3] - poses[-1][:3, 3]), *twist])
            if abs(error).max() < REACHED:
                return joints
            step = np.linalg.solve(self.jacobian(poses), error)
            joints += step / max(1.0, abs(step).max() / 0.3)
        raise ValueError(f"{self.name}: no joints for {wanted[:3, 3]}")


def check_home(program, arm, points):
    """Holds these kinematics against the machine file and the program; returns the largest difference, mm.

    From the angles at which its drives stand about home they must come to home, and at each named point both have P where the file has it and the same joints.
    """
    home, worst = arm.solve(arm.home_guess, arm.home), 0.0
    for point in points:
        wanted = pose(arm.home[:3, :3], point["position_mm"])
        command = [program, "point", "--machine", arm.name, "--at", point["name"], "--json"]
        told = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        theirs = arm.joints(np.radians(told["rho_nominal_deg"]))
        off = arm.frames(theirs)[-1] - wanted
        worst = max(worst, abs(off[:3, 3]).max(), arm.reach * abs(off[:3, :3]).max())
        if worst > SAME_MM or abs(theirs - arm.solve(home, wanted)).max() > SAME_RAD:
            raise SystemExit(f"{arm.name} at {point['name']}: the joints of the program are {np.degrees(theirs)} degrees")
    if not points:
        raise SystemExit(f"{arm.name}: no named point to compare")
    return worst


# A shape is its kind and its sizes, about its own centre and along its own z axis, as crates/cell/examples/pairs.rs has them.


def words(shape):
    kind, *sizes = shape
    numbers = np.ravel(sizes[0] if kind == "hull" else sizes)
    return f"{kind} {' '.join(repr(float(number)) for number in numbers)}"


def geometry(shape):
    """A shape for Coal."""
    kind, *sizes = shape
    if kind == "box":
        return coal.Box(*sizes)
    if kind == "hull":
        points = coal.StdVec_Vec3s()
        for point in sizes[0]:
            points.append(np.asarray(point, float))
        return coal.Convex.convexHull(points, False, None)
    length, radius = sizes
    return (coal.Capsule if kind == "capsule" else coal.Cylinder)(radius, length)


def ball(shape):
    """The radius of a ball about the centre of a shape that encloses it."""
    kind, *sizes = shape
    if kind == "box":
        return 0.5 * np.linalg.norm(sizes)
    if kind == "hull":
        return max(np.linalg.norm(point) for point in sizes[0])
    length, radius = sizes
    return 0.5 * length + radius if kind == "capsule" else np.hypot(0.5 * length, radius)


def transform(matrix):
    return coal.Transform3s(matrix[:3, :3], matrix[:3, 3])


REQUEST = coal.DistanceRequest()
REQUEST.enable_signed_distance = True
REQUEST.gjk_tolerance, REQUEST.epa_tolerance = 1e-9, 1e-6
REQUEST.gjk_max_iterations = REQUEST.epa_max_iterations = 1000


def distance(one, at, other, beside):
    """The distance of two shapes of Coal at poses, mm; minus the depth where they overlap."""
    return coal.distance(one, at, other, beside, REQUEST, coal.DistanceResult())


def extent(shape, directions):
    """How far a shape reaches from its centre along directions, in closed form."""
    kind, *sizes = shape
    if kind == "box":
        return abs(directions) @ (0.5 * np.array(sizes))
    if kind == "hull":
        return (directions @ np.transpose(sizes[0])).max(axis=1)
    length, radius = sizes
    across = np.hypot(directions[:, 0], directions[:, 1]) if kind == "cylinder" else 1.0
    return 0.5 * length * abs(directions[:, 2]) + radius * across


def by_directions(one, at, other, beside, seed=1):
    """The distance of two shapes as the most that lies between them along a direction: all over the sphere, then closer around the best one.

    It needs no search of another's for a nearest point, and is never more than the distance.
    """
    rng = np.random.default_rng(seed)
    apart = lambda own: own @ (beside[:3, 3] - at[:3, 3]) - extent(one, own @ at[:3, :3]) - extent(other, -own @ beside[:3, :3])
    unit = lambda own: own / np.linalg.norm(own, axis=1, keepdims=True)
    axes = np.vstack([at[:3, :3].T, beside[:3, :3].T])
    directions = unit(np.vstack([axes, -axes, rng.normal(size=(100_000, 3))]))
    found, size = apart(directions), 0.05
    best, most = directions[found.argmax()], found.max()
    while size > 1e-12:
        around = unit(best + size * rng.normal(size=(1000, 3)))
        found = apart(around)
        if found.max() > most:
            best, most = around[found.argmax()], found.max()
        else:
            size *= 0.6
    return float(most)


def quaternion(rotation):
    """w, x, y, z of a rotation."""
    trace = np.array([1 + rotation.trace(), *(1 + 2 * np.diag(rotation) - rotation.trace())])
    k = int(np.argmax(trace))
    off = [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    products = 4.0 * np.outer(np.ones(4), np.ones(4))
    products[0, 1:] = products[1:, 0] = off
    for i in range(3):
        for j in range(3):
            products[1 + i, 1 + j] = rotation[i, j] + rotation[j, i] if i != j else trace[1 + i]
    products[0, 0] = trace[0]
    found = products[k]
    return found / np.linalg.norm(found)


def pose_words(matrix):
    return " ".join(repr(float(number)) for number in [*matrix[:3, 3], *quaternion(matrix[:3, :3])])
