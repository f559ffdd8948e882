#!/usr/bin/env python3
"""Measurements of two machines whose links bend as geometrically exact beams, solved by Exudyn.

    exudyn_beams.py FOLDER SETS

Writes sheets as make.py does, of truth `exudyn`: an arm under its weight, of which upper arm and forearm yield as well, and a hexapod whose
struts bend, as their joints sit beside their axes. Before that, a beam and both machines are held against closed forms. Needs what requirements.txt has.
"""

import math
import random
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

sys.exudynFast = True  # the build without range checks
import exudyn as exu  # noqa: E402
from exudyn.itemInterface import (  # noqa: E402
    Force,
    GenericJoint,
    MarkerBodyRigid,
    NodeRigidBodyEP,
    ObjectBeamGeometricallyExact,
    ObjectGround,
    ObjectRigidBody,
    RigidBodySpringDamper,
    TorsionalSpringDamper,
)
from exudyn.rigidBodyUtilities import RotationMatrix2EulerParameters  # noqa: E402
from make import Arm, Hexapod, add, cross, dot, measured, scaled, solve, sub, write  # noqa: E402

# Of each beam. What they miss of the bending by a force is 1/4n².
ELEMENTS = 8


class Model:
    """Bodies, beams and joints in Exudyn, in m, N and rad: with millimetres its Newton iteration ends late. Arguments are in mm."""

    def __init__(self):
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.ground = self.system.AddObject(ObjectGround()), np.eye(3), np.zeros(3)

    def body(self, at, axes=None):
        """A rigid body with its node: number, axes and origin, and the node."""
        axes, at = np.eye(3) if axes is None else np.asarray(axes), np.asarray(at) / 1e3
        turn = RotationMatrix2EulerParameters(axes)
        # With nodes of rotation vectors its static solver diverges where these are beyond a right angle.
        node = self.system.AddNode(NodeRigidBodyEP(referenceCoordinates=[*at, *turn]))
        # Statics does not use its mass, but it must have one.
        number = self.system.AddObject(ObjectRigidBody(nodeNumber=node, mass=1.0, inertia=[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]))
        return (number, axes, at), node

    def marker(self, body, at, axes=None):
        number, own, origin = body
        local = exu.HT(rotation=own.T @ (np.eye(3) if axes is None else axes), translation=own.T @ (np.asarray(at) / 1e3 - origin))
        return self.system.AddMarker(MarkerBodyRigid(bodyNumber=number, localHT=local))

    def beam(self, start, end, bending, torsion, tension, shear):
        """Bodies at the ends of the elements; stiffnesses in N·mm² and N."""
        start, end = np.asarray(start), np.asarray(end)
        axes = frame_along(end - start)
        section = exu.BeamSection()
        section.stiffnessMatrix = np.diag([tension, shear, shear, torsion / 1e6, bending / 1e6, bending / 1e6]).tolist()
        bodies = [self.body(start + (end - start) * i / ELEMENTS, axes) for i in range(ELEMENTS + 1)]
        length = np.linalg.norm(end - start) / ELEMENTS / 1e3
        for (_, first), (_, second) in zip(bodies, bodies[1:]):
            self.system.AddObject(ObjectBeamGeometricallyExact(nodeNumbers=[first, second], length=length, sectionData=section))
        return [body for body, _ in bodies]

    def joint(self, first, second, at, axes, constrained):
        markers = [self.marker(body, at, axes) for body in (first, second)]
        self.system.AddObject(GenericJoint(markerNumbers=markers, constrainedAxes=constrained))
        return markers

    def pivot(self, first, second, at, axes, stiffness):
        """A hinge about the third axis with a spring of `stiffness`, N·mm/rad."""
        markers = self.joint(first, second, at, axes, [1, 1, 1, 1, 1, 0])
        self.system.AddObject(TorsionalSpringDamper(markerNumbers=markers, stiffness=stiffness / 1e3))

    def slide(self, first, second, at, axes, stiffness):
        """A slide along the first axis with a spring of `stiffness`, N/mm."""
        markers = self.joint(first, second, at, axes, [0, 1, 1, 1, 1, 1])
        spring = np.diag([stiffness * 1e3, 0.0, 0.0, 0.0, 0.0, 0.0])
        self.system.AddObject(RigidBodySpringDamper(markerNumbers=markers, stiffness=spring, damping=np.zeros((6, 6))))

    def load(self, body, at, force):
        return self.system.AddLoad(Force(markerNumber=self.marker(body, at), loadVector=list(force)))

    def moved(self, body, at, loads):
        """Displacement of the point `at` of `body` by `loads` (number, force), mm: from the equilibrium without these to that with them."""
        _, axes, origin = body
        local = (axes.T @ (np.asarray(at) / 1e3 - origin)).tolist()
        self.system.Assemble()
        settings = exu.SimulationSettings()
        settings.solution.file.write = False
        static = settings.staticSolver
        static.numberOfLoadSteps, static.adaptiveStep, static.verboseMode = 1, False, 0
        # N: what rounding leaves of the forces in beams is below it.
        static.newton.relativeTolerance, static.newton.absoluteTolerance = 1e-9, 1e-4
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        places = []
        for share in (0.0, 1.0):
            for number, force in loads:
                self.system.SetLoadParameter(number, "loadVector", [share * f for f in force])
            # Raises where it does not converge.
            self.system.SolveStatic(settings, updateInitialValues=True)
            places.append(np.array(self.system.GetObjectOutputBody(body[0], exu.OutputVariableType.Position, localPosition=local)))
        return tuple(1e3 * (places[1] - places[0]))


def frame_along(direction):
    """Axes whose first one is along `direction`, the second one level."""
    x = np.asarray(direction) / np.linalg.norm(direction)
    y = np.cross((0.0, 0.0, 1.0) if abs(x[2]) < 0.99 else (0.0, 1.0, 0.0), x)
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


class BeamArm(Arm):
    """The arm with upper arm and forearm as round tubes of cast iron, `softness` times as soft as those of the truth `beams`."""

    softness = 2.0

    def displacement(self, shown, force, _truth, _draw):
        model, frames = Model(), self.frames(shown)
        sections = [stiffness / self.softness for stiffness in (2.0e12, 1.6e12, 1.0e9)]
        wrist = frames[3][3]
        spans = {1: (frames[1][3], frames[2][3]), 2: (self.at(frames[2], (225.0, 0.0, 0.0)), wrist)}
        end = model.ground
        for i, (frame, (kg, centre)) in enumerate(zip(frames, self.masses)):
            bodies = model.beam(*spans[i], *sections, 1e10) if i in spans else [model.body(frame[3])[0]]
            model.pivot(end, bodies[0], frame[3], np.column_stack(frame[:3]), self.stiffness[i])
            # Its weight hangs on the nearest body of the link.
            at = self.at(frame, centre)
            carrier = min(bodies, key=lambda body: np.linalg.norm(1e3 * body[2] - at))
            model.load(carrier, at, (0.0, 0.0, -9.81 * kg))
            end = bodies[-1]
        tip = self.at(frames[5], self.tip)
        return model.moved(end, tip, [(model.load(end, tip, force), force)])


class BeamHexapod(Hexapod):
    """The hexapod with struts as steel tubes, 60 mm outside and 40 mm inside, whose joints sit `beside` their axes by so many mm."""

    beside = 30.0
    # N/mm.
    screw = 1.0e5
    bending, tension = 2.1e5 * math.pi / 64 * (60.0**4 - 40.0**4), 2.1e5 * math.pi / 4 * (60.0**2 - 40.0**2)

    def displacement(self, position, force, _truth, _draw):
        model = Model()
        platform = model.body(position)[0]
        for base, joint in zip(self.base, self.platform):
            top = add(position, joint)
            axes = frame_along(sub(top, base))
            start, end = (add(at, tuple(self.beside * axes[:, 1])) for at in (base, top))
            foot = model.body(base, axes)[0]
            strut = model.beam(start, end, self.bending, self.bending / 1.3, self.tension, 1e10)
            # The leg does not turn about itself.
            model.joint(model.ground, foot, base, axes, [1, 1, 1, 1, 0, 0])
            model.slide(foot, strut[0], base, axes, self.screw)
            model.joint(strut[-1], platform, top, axes, [1, 1, 1, 0, 0, 0])
        tip = add(position, self.tip)
        return model.moved(platform, tip, [(model.load(platform, tip, force), force)])

    def linear(self, position, force):
        """The same by closed forms: a strut pulled beside its axis is bent by one moment all along."""
        legs = [sub(add(position, joint), base) for base, joint in zip(self.base, self.platform)]
        lengths = [math.sqrt(dot(leg, leg)) for leg in legs]
        rows = [scaled(leg, 1.0 / length) + cross(joint, scaled(leg, 1.0 / length)) for leg, length, joint in zip(legs, lengths, self.platform)]
        loads = solve([list(column) for column in zip(*rows)], list(force + cross(self.tip, force)))
        compliance = 1.0 / self.tension + self.beside**2 / self.bending
        longer = [load * (1.0 / self.screw + length * compliance) for load, length in zip(loads, lengths)]
        twist = solve([list(row) for row in rows], longer)
        return add(tuple(twist[:3]), cross(tuple(twist[3:]), self.tip))


def check():
    """Exudyn's models against closed forms, under loads so small that effects add up."""
    off = {}

    def held(name, found, exact, share):
        off[name] = np.linalg.norm(np.subtract(found, exact)) / np.linalg.norm(exact)
        assert off[name] < share, f"{name}: {found} instead of {exact}"

    # A cantilever across a slanted line: what elements miss of bending stands at ELEMENTS.
    length, bending, tension, shear = 1000.0, 2.0e12, 1.0e9, 4.0e8
    axes = frame_along((2.0, 1.0, 2.0))
    tip, force = length * axes[:, 0], 10.0 * axes @ (3.0, -1.0, 2.0)
    model = Model()
    beam = model.beam((0.0, 0.0, 0.0), tip, bending, 1.6e12, tension, shear)
    model.joint(model.ground, beam[0], (0.0, 0.0, 0.0), axes, [1] * 6)
    across = length**3 / 3.0 / bending
    exact = axes @ (axes.T @ force * (length / tension, across + length / shear, across + length / shear))
    missed = axes @ (axes.T @ force * (0.0, across, across)) / (4.0 * ELEMENTS**2)
    held("cantilever", model.moved(beam[-1], tip, [(model.load(beam[-1], tip, force), force)]), exact - missed, 1e-4)

    draw = random.Random(0)
    arm, hexapod = BeamArm(), BeamHexapod()
    arm.softness = 1.0
    for number in range(3):
        force = tuple(draw.uniform(-20.0, 20.0) for _ in range(3))
        pose = arm.pose(draw)
        held(f"arm {number}", arm.displacement(pose, force, None, None), Arm.displacement(arm, pose, force, "beams", None), 5e-3)
        pose = hexapod.pose(draw)
        held(f"hexapod {number}", hexapod.displacement(pose, force, None, None), hexapod.linear(pose, force), 1e-4)
    print("off from closed forms:", ", ".join(f"{name} {share:.1e}" for name, share in off.items()))


def one(machine, own):
    return machine.name, own, *measured(machine, "exudyn", random.Random(7000 + own))


def main():
    folder, sets = Path(sys.argv[1]), int(sys.argv[2])
    check()
    machines = {machine.name: machine for machine in (BeamArm(), BeamHexapod())}
    with ProcessPoolExecutor() as pool:
        tasks = [pool.submit(one, machine, own) for machine in machines.values() for own in range(sets)]
        for name, own, sheets, noise in (task.result() for task in tasks):
            write(folder, f"exudyn-{name}-{own}", machines[name], sheets, noise)


if __name__ == "__main__":
    main()
