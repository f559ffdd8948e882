"""The Orthoglide as the peers need it: numbers from the machine file, places of the joints, cases, timing.

Lengths mm, forces N, angles rad. Chain axes: e along the rail, u along the parallelogram's short link, n = e x u.
"""

import json
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

MACHINE_FILE = Path(__file__).parents[2] / "crates/engine/src/machine/catalogue/orthoglide.toml"


def element(document, kind):
    return next(e[kind] for e in document["chain"][0]["elements"] if kind in e)


with MACHINE_FILE.open("rb") as file:
    _document = tomllib.load(file)
_foot, _leg = element(_document, "beam"), element(_document, "parallelogram")
_aluminium = _document["material"]["aluminium"]
_fixed = [e["fixed"] for e in _document["chain"][0]["elements"] if "fixed" in e]

E = _aluminium["youngs_modulus_N_per_mm2"]
G = _aluminium["shear_modulus_N_per_mm2"]
DRIVE_STIFFNESS = element(_document, "prismatic_drive")["stiffness_N_per_mm"]
FOOT_LENGTH = _foot["length_mm"]
FOOT_LEAN = -np.radians(_fixed[0]["rotation_deg"][1])
BAR_LENGTH, SHORT_LINK = _leg["length_mm"], _leg["width_mm"]
PLATFORM_OFFSET = _fixed[-1]["translation_mm"][0]
TOOL = np.array(_document["platform"]["tool_tip_mm"])
BASES = [np.roll(np.eye(3), i, axis=0) for i in range(3)]  # BASES[i] @ v: from chain axes into O's


@dataclass
class Section:
    """Rectangle: width along local y, height along local z."""

    width: float
    height: float

    @property
    def area(self):
        return self.width * self.height

    @property
    def i_y(self):
        return self.width * self.height**3 / 12

    @property
    def i_z(self):
        return self.height * self.width**3 / 12

    @property
    def torsion(self):
        a, c = max(self.width, self.height), min(self.width, self.height)
        return a * c**3 * (1 / 3 - 0.21 * c / a * (1 - c**4 / (12 * a**4)))


FOOT = Section(_foot["section"]["rectangle"]["width_mm"], _foot["section"]["rectangle"]["height_mm"])
BAR = Section(_leg["bar_section"]["rectangle"]["width_mm"], _leg["bar_section"]["rectangle"]["height_mm"])


def beam_stiffness(length, section):
    """End stiffness (6x6) of a beam along x that is clamped at its start."""
    k = np.diag(
        [
            E * section.area / length,
            12 * E * section.i_z / length**3,
            12 * E * section.i_y / length**3,
            G * section.torsion / length,
            4 * E * section.i_y / length,
            4 * E * section.i_z / length,
        ]
    )
    k[1, 5] = k[5, 1] = -6 * E * section.i_z / length**2
    k[2, 4] = k[4, 2] = 6 * E * section.i_y / length**2
    return k


def released(k, *directions):
    """`k` with the elastic displacements along `directions` given up to joints that carry no load."""
    j = np.array(directions, dtype=float).T
    return k - k @ j @ np.linalg.solve(j.T @ k @ j, j.T @ k)


def passive_angles(position, base):
    """(q1, q2) of a chain whose platform stands at `position`."""
    c = base.T @ position - [PLATFORM_OFFSET, 0, 0]
    q2 = np.arcsin(c[1] / BAR_LENGTH)
    return np.arcsin(-c[2] / (BAR_LENGTH * np.cos(q2))), q2


@dataclass
class Leg:
    """Where a chain's parts stand in O's axes when nothing is loaded."""

    e: np.ndarray
    u: np.ndarray
    n: np.ndarray
    slider: np.ndarray
    foot_tip: np.ndarray  # joints q1
    platform_joint: np.ndarray  # joint q3
    along: np.ndarray  # unit vector of the bars
    normal: np.ndarray  # axis of the parallelogram's joints

    def foot_axes(self):
        x = self.e * np.cos(FOOT_LEAN) + self.n * np.sin(FOOT_LEAN)
        return np.column_stack([x, self.u, np.cross(x, self.u)])

    def bar_axes(self):
        return np.column_stack([self.along, np.cross(self.normal, self.along), self.normal])


def legs(position):
    result = []
    for base in BASES:
        e, u, n = base.T
        q1, q2 = passive_angles(position, base)
        turned = np.cos(q1) * e - np.sin(q1) * n  # Ry(q1) applied to e
        along = np.cos(q2) * turned + np.sin(q2) * u
        platform_joint = position - PLATFORM_OFFSET * e
        foot_tip = platform_joint - BAR_LENGTH * along
        lean = e * np.cos(FOOT_LEAN) + n * np.sin(FOOT_LEAN)
        result.append(Leg(e, u, n, foot_tip - FOOT_LENGTH * lean, foot_tip, platform_joint, along, np.cross(turned, u)))
    return result


def cases(path):
    """{point: (position, wrenches per load share)} as our program solved them."""
    document = json.loads(Path(path).read_text())
    return {
        point["name"]: (
            np.array(point["position_mm"]),
            [(c["load_share"], c["tool_angle_deg"], np.array(c["wrench_N_Nmm"])) for c in point["cases"]],
        )
        for point in document["points"]
    }


def best(rounds, work):
    """Shortest of `rounds` times of `work`, in seconds, and its last result."""
    shortest = float("inf")
    for _ in range(rounds):
        started = time.perf_counter()
        result = work()
        shortest = min(shortest, time.perf_counter() - started)
    return shortest, result


def best_turn(rounds, solve, loads):
    """Sum over `loads` of the shortest of `rounds` times each, in seconds, and the last results.

    A turn of a slow program is longer than the quiet moments of a computer; a single load fits into one.
    """
    shortest = [float("inf")] * len(loads)
    for _ in range(rounds):
        results = []
        for i, load in enumerate(loads):
            started = time.perf_counter()
            results.append(solve(load))
            shortest[i] = min(shortest[i], time.perf_counter() - started)
    return sum(shortest), results


def report(path, program, models):
    Path(path).write_text(json.dumps({"program": program, "models": models}, indent=1) + "\n")
