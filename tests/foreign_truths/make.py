#!/usr/bin/env python3
"""Measurements of two machines that yield in ways which no model of springs with constant stiffness can express.

    make.py FOLDER SETS

Writes for each truth, machine and set three sheets of measurements: TRUTH-MACHINE-SET-fitted.csv, poses with a load each;
…-repeated.csv, fewer poses with several loads each; …-unseen.csv, other poses. The kinematics and statics are written here from the
published tables and share nothing with the engine: an arm (FANUC R-2000iC, modified Denavit-Hartenberg frames) and a hexapod (6-UPS,
Nategh & Agheli). Deflections are small: their effects add up. Readings have noise of 3 % of their root mean square.
"""

import math
import random
import sys
from pathlib import Path

# Poses, and loads at each.
SHEETS = {"fitted": (20, 1), "repeated": (8, 5), "unseen": (40, 1)}
NOISE = 0.03

ZERO = (0.0, 0.0, 0.0)


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def scaled(a, s):
    return tuple(x * s for x in a)


def sub(a, b):
    return add(a, scaled(b, -1.0))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def solve(rows, right):
    """Gauss's elimination with pivots."""
    n = len(right)
    m = [list(row) + [value] for row, value in zip(rows, right)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda r: abs(m[r][i]))
        m[i], m[pivot] = m[pivot], m[i]
        for r in range(n):
            if r != i:
                factor = m[r][i] / m[i][i]
                m[r] = [a - factor * b for a, b in zip(m[r], m[i])]
    return [m[i][n] / m[i][i] for i in range(n)]


# What an elastic joint or leg of stiffness k does under a moment or force; `usual` is how large that is by the loads here.


def spring(load, before, k, usual, draw):
    """What the models assume."""
    return load / k - before / k


def hardening(load, before, k, usual, draw):
    """A gear that is 1.5 times as stiff (secant) under the usual load as without any."""
    def deflection(f):
        # k e (1 + (e / e0)²) = f, where the bracket is 1.5 under the usual load.
        e0 = usual / (1.5 * k) / math.sqrt(0.5)
        e = f / k
        for _ in range(60):
            e -= (k * e * (1.0 + (e / e0) ** 2) - f) / (k * (1.0 + 3.0 * (e / e0) ** 2))
        return e
    return deflection(load) - deflection(before)


def play(load, before, k, usual, draw):
    """Lost motion either way, to the side to which it is pressed: as much as 0.3 of the usual load deflects."""
    def deflection(f):
        return f / k + (math.copysign(0.3 * usual / k, f) if f != 0.0 else 0.0)
    return deflection(load) - deflection(before)


def friction(load, before, k, usual, draw):
    """Dry friction beside the spring, 0.3 of the usual load: it sticks until it slips, and holds any part of that before."""
    most = 0.3 * usual
    e = (before - draw.uniform(-most, most)) / k
    start = e
    if load - k * e > most:
        e = (load - most) / k
    elif load - k * e < -most:
        e = (load + most) / k
    return e - start


LAWS = {"spring": spring, "hardening": hardening, "play": play, "friction": friction}


class Arm:
    """FANUC R-2000iC: modified Denavit-Hartenberg table, masses and tool tip as published by Liu et al. 2026; mm, N, N·mm, rad."""

    name = "fanuc_r2000ic"
    header = "J1_rad,J2_rad,J3_rad,J4_rad,J5_rad,J6_rad"
    table = [
        (0.0, 0.0, 0.0, 670.0), (-math.pi / 2, 312.0, -math.pi / 2, 0.0), (0.0, 1075.0, 0.0, 0.0),
        (-math.pi / 2, 225.0, 0.0, 1280.0), (math.pi / 2, 0.0, 0.0, 0.0), (-math.pi / 2, 0.0, 0.0, 215.0),
    ]
    masses = [
        (262.614, (-13.9, 76.5, -110.7)), (156.154, (424.8, 42.87, 216.3)), (149.341, (134.2, 241.5, 39.1)),
        (10.19, (0.0, 1.9, -105.5)), (17.698, (0.0, 54.3, -27.7)), (41.45, (0.5, -33.6, 265.4)),
    ]
    tip = (6.9, 245.3, 319.3)
    # Not the published ones, at which a fit starts.
    stiffness = (8.0e8, 3.2e9, 2.1e9, 2.6e8, 3.6e8, 1.2e8)
    force = 900.0
    usual_force = 500.0
    # Levers at which the usual force acts on the joints, mm.
    lever = (1500.0, 1200.0, 1200.0, 300.0, 400.0, 250.0)

    def pose(self, draw):
        middle = (0.0, 14.0, -50.0, 0.0, 50.0, 0.0)
        return tuple(math.radians(angle + draw.uniform(-35.0, 35.0)) for angle in middle)

    def frames(self, shown):
        """Axes (columns x, y, z) and origin of each frame."""
        q1, q2, q3, q4, q5, q6 = shown
        x, y, z, o = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), ZERO
        frames = []
        for q, (alpha, a, offset, d) in zip((q1, q2, -(q2 + q3), -q4, -q5, -q6), self.table):
            o = add(o, scaled(x, a))
            y, z = add(scaled(y, math.cos(alpha)), scaled(z, math.sin(alpha))), sub(scaled(z, math.cos(alpha)), scaled(y, math.sin(alpha)))
            o = add(o, scaled(z, d))
            angle = q + offset
            x, y = add(scaled(x, math.cos(angle)), scaled(y, math.sin(angle))), sub(scaled(y, math.cos(angle)), scaled(x, math.sin(angle)))
            frames.append((x, y, z, o))
        return frames

    @staticmethod
    def at(frame, point):
        x, y, z, o = frame
        return add(o, add(scaled(x, point[0]), add(scaled(y, point[1]), scaled(z, point[2]))))

    def displacement(self, shown, force, truth, draw):
        frames = self.frames(shown)
        tip = self.at(frames[5], self.tip)
        moved = ZERO
        for i, (_, _, axis, origin) in enumerate(frames):
            arm = cross(axis, sub(tip, origin))
            weight = sum(
                dot(axis, cross(sub(self.at(frames[j], at), origin), (0.0, 0.0, -9.81 * kg))) for j, (kg, at) in list(enumerate(self.masses))[i:]
            )
            by_force = dot(arm, force)
            turn = LAWS.get(truth, spring)(weight + by_force, weight, self.stiffness[i], self.usual_force * self.lever[i], draw)
            moved = add(moved, scaled(arm, turn))
        if truth == "beams":
            # Upper arm and forearm as cantilevers of Euler and Bernoulli, round tubes of cast iron.
            for start, end in ((frames[1][3], frames[2][3]), (self.at(frames[2], (225.0, 0.0, 0.0)), frames[3][3])):
                moved = add(moved, self.beam(start, end, tip, force))
        return moved

    @staticmethod
    def beam(start, end, tip, force, bending=2.0e12, torsion=1.6e12, tension=1.0e9):
        """What bending, torsion and tension of a cantilever move the tip by under a force on the tip."""
        length = math.sqrt(dot(sub(end, start), sub(end, start)))
        along = scaled(sub(end, start), 1.0 / length)
        lever = sub(tip, end)
        moment = cross(lever, force)
        axial, twist = dot(along, force), dot(along, moment)
        side, bend = sub(force, scaled(along, axial)), sub(moment, scaled(along, twist))
        # A moment m across bends the end aside by m × along · L²/2EI.
        shift = add(scaled(side, length**3 / 3.0 / bending), scaled(cross(bend, along), length**2 / 2.0 / bending))
        shift = add(shift, scaled(along, axial * length / tension))
        turn = add(scaled(cross(along, side), length**2 / 2.0 / bending), scaled(bend, length / bending))
        turn = add(turn, scaled(along, twist * length / torsion))
        return add(shift, cross(turn, lever))


class Hexapod:
    """6-UPS, joints of base and platform by Nategh & Agheli 2009; mm, N."""

    name = "hexapod"
    header = "command_x_mm,command_y_mm,command_z_mm"
    base = [
        (305.4001, 111.1565, 0.0), (-56.4357, 320.0625, 0.0), (-248.9644, 208.906, 0.0),
        (-248.9644, -208.906, 0.0), (-56.4357, -320.0625, 0.0), (305.4001, -111.1565, 0.0),
    ]
    platform = [
        (92.1597, 84.4488, 0.0), (27.055, 122.037, 0.0), (-119.2146, 37.5882, 0.0),
        (-119.2146, -37.5882, 0.0), (27.055, -122.037, 0.0), (92.1597, -84.4488, 0.0),
    ]
    tip = (0.0, 0.0, 100.0)
    # Screw and strut one behind the other.
    stiffness = 7.0e4
    force = 2000.0
    # Along a leg, by such a force.
    usual = 1500.0

    def pose(self, draw):
        return tuple(draw.uniform(-100.0, 100.0) + centre for centre in (0.0, 0.0, 800.0))

    def displacement(self, position, force, truth, draw):
        legs, rows = [], []
        for base, joint in zip(self.base, self.platform):
            leg = sub(add(position, joint), base)
            leg = scaled(leg, 1.0 / math.sqrt(dot(leg, leg)))
            legs.append(leg)
            rows.append(leg + cross(joint, leg))
        loads = solve([list(column) for column in zip(*rows)], list(force + cross(self.tip, force)))
        longer = []
        for number, (leg, load) in enumerate(zip(legs, loads)):
            own = LAWS.get(truth, spring)(load, 0.0, self.stiffness, self.usual, draw)
            if truth == "beams":
                # Each foot stands on a post that bends, three of them longer than the others: cantilevers of steel.
                height, bending, tension = (350.0 if number % 2 else 250.0), 8.0e11, 1.0e9
                own += load * ((1.0 - leg[2] ** 2) * height**3 / 3.0 / bending + leg[2] ** 2 * height / tension)
            longer.append(own)
        twist = solve([list(row) for row in rows], longer)
        return add(tuple(twist[:3]), cross(tuple(twist[3:]), self.tip))


TRUTHS = ("spring", "hardening", "play", "friction", "beams", "force_law")


def measured(machine, truth, draw):
    """Rows of all sheets: number of the pose, pose, force, what is read; and the standard deviation of the noise."""
    sheets = {name: [] for name in SHEETS}
    for name, (poses, loads) in SHEETS.items():
        for number in range(poses):
            pose = machine.pose(draw)
            for _ in range(loads):
                force = tuple(draw.uniform(-1.0, 1.0) * machine.force for _ in range(3))
                acting = force
                if truth == "force_law":
                    # The force grows with its nominal size as a power, as the specific cutting force falls with the thickness of the chip.
                    acting = scaled(force, (math.sqrt(dot(force, force)) / machine.force) ** -0.3)
                sheets[name].append((number + 1, pose, force, machine.displacement(pose, acting, truth, draw)))
    exact = [d for rows in sheets.values() for *_, d in rows]
    noise = NOISE * math.sqrt(sum(dot(d, d) for d in exact) / 3 / len(exact))
    for rows in sheets.values():
        rows[:] = [(*row, tuple(x + draw.gauss(0.0, noise) for x in d)) for *row, d in rows]
    return sheets, noise


def write(folder, name, machine, sheets, noise):
    """The sheets of a machine as files whose names begin with `name`."""
    head = f"pose,{machine.header},force_x_N,force_y_N,force_z_N,displacement_x_mm,displacement_y_mm,displacement_z_mm,std_mm\n"
    for sheet, rows in sheets.items():
        lines = [",".join([str(pose), *(f"{x:.9g}" for x in (*at, *force, *d, noise))]) + "\n" for pose, at, force, d in rows]
        (folder / f"{name}-{sheet}.csv").write_text(head + "".join(lines))


def main():
    folder, sets = Path(sys.argv[1]), int(sys.argv[2])
    for machine in (Arm(), Hexapod()):
        for number, truth in enumerate(TRUTHS):
            for own in range(sets):
                sheets, noise = measured(machine, truth, random.Random(1000 * number + own))
                write(folder, f"{truth}-{machine.name}-{own}", machine, sheets, noise)


if __name__ == "__main__":
    main()
