"""The Orthoglide as rigid bodies, joints and springs in Exudyn.

A beam is one ConnectorRigidBodySpringDamper with its 6x6 end stiffness between the body that carries it and the body at its
end: a virtual joint, but each bar has its own. Or it is divided into eight with rigid bodies between them, which comes close
to a beam (then in the intrinsic formulation, which acts half-way between its ends). Rails and passive joints are GenericJoints (algebraic
constraints). The in-plane end joint of a bar is condensed into its spring, the one at its start is a joint. Static solver
with the whole load in one step; the model stays, only the load changes between tool angles, and each solution is the
initial value of the next.
"""

import sys
import time

import numpy as np
import orthoglide as o

sys.exudynFast = True  # the build without range checks
import exudyn as exu  # noqa: E402
from exudyn.itemInterface import (  # noqa: E402
    GenericJoint,
    LoadForceVector,
    LoadTorqueVector,
    MarkerBodyRigid,
    ObjectGround,
    RigidBodySpringDamper,
)
from exudyn.rigidBodyUtilities import InertiaCuboid  # noqa: E402

ROUNDS = 25
# Statics does not use it, but a body must have one.
INERTIA = InertiaCuboid(1e-6, [10, 10, 10])
REVOLUTE_Z = [1, 1, 1, 1, 1, 0]
PRISMATIC_X = [0, 1, 1, 1, 1, 1]


class Mechanism:
    def __init__(self, position, springs_per_beam):
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.springs_per_beam = springs_per_beam
        self.inside = self.total = 0.0
        self.ground = self.mbs.AddObject(ObjectGround()), np.zeros(3)
        self.platform = self.body(position)
        for leg in o.legs(position):
            self.leg(leg)
        marker = self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=self.platform[0]))
        self.force = self.mbs.AddLoad(LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0]))
        self.torque = self.mbs.AddLoad(LoadTorqueVector(markerNumber=marker, loadVector=[0, 0, 0]))
        self.mbs.Assemble()
        self.settings = exu.SimulationSettings()
        self.settings.solution.file.write = False
        static = self.settings.staticSolver
        static.numberOfLoadSteps = 1
        static.adaptiveStep = False
        static.verboseMode = 0
        # Below these the residual of small loads stalls in rounding.
        static.newton.relativeTolerance = static.newton.absoluteTolerance = 1e-8 if springs_per_beam == 1 else 1e-6
        self.settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse

    def body(self, at):
        dictionary = self.mbs.CreateRigidBody(
            referencePosition=at.tolist(), inertia=INERTIA, nodeType=exu.NodeType.RotationRxyz, returnDict=True
        )
        return dictionary["bodyNumber"], at

    def markers(self, first, second, place, axes):
        """The same place and axes on two bodies, each given as (number, its position)."""
        return [
            self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localHT=exu.HT(rotation=axes, translation=place - at)))
            for body, at in (first, second)
        ]

    def joint(self, first, second, place, axes, constrained):
        markers = self.markers(first, second, place, axes)
        self.mbs.AddObject(GenericJoint(markerNumbers=markers, constrainedAxes=constrained))

    def spring(self, first, second, place, axes, stiffness):
        self.mbs.AddObject(
            RigidBodySpringDamper(
                markerNumbers=self.markers(first, second, place, axes),
                stiffness=stiffness,
                damping=np.zeros((6, 6)),
                useIntrinsicFormulation=self.springs_per_beam > 1,
            )
        )

    def beam(self, first, second, start, end, axes, section, *end_releases):
        """Springs from `start` to `end`; the last one without the elastic displacements `end_releases`."""
        count = self.springs_per_beam
        stiffness = o.beam_stiffness(np.linalg.norm(end - start) / count, section)
        for place in np.linspace(start, end, count + 1)[1:-1]:
            middle = self.body(place)
            self.spring(first, middle, place, axes, stiffness)
            first = middle
        self.spring(first, second, end, axes, o.released(stiffness, *end_releases) if end_releases else stiffness)

    def leg(self, leg):
        tip, end = leg.foot_tip, leg.platform_joint
        slider, foot, near_link, far_link = (self.body(at) for at in (tip, tip, tip, end))
        rail = np.column_stack([leg.e, leg.u, leg.n])
        about_u = np.column_stack([leg.n, leg.e, leg.u])
        drive = np.zeros((6, 6))
        drive[0, 0] = o.DRIVE_STIFFNESS
        self.joint(self.ground, slider, tip, rail, PRISMATIC_X)
        self.spring(self.ground, slider, tip, rail, drive)
        self.beam(slider, foot, leg.slider, tip, leg.foot_axes(), o.FOOT)
        self.joint(foot, near_link, tip, about_u, REVOLUTE_Z)
        for side in (1, -1):
            arm = side * o.SHORT_LINK / 2 * leg.u
            bar = self.body(tip + arm)
            self.joint(near_link, bar, tip + arm, leg.bar_axes(), REVOLUTE_Z)
            self.beam(bar, far_link, tip + arm, end + arm, leg.bar_axes(), o.BAR, [0, 0, 0, 0, 0, 1])
        self.joint(far_link, self.platform, end, about_u, REVOLUTE_Z)

    def solve(self, wrench):
        """Newton iterations made and the tool's displacement, from where the last load left the machine."""
        started = time.perf_counter()
        self.mbs.SetLoadParameter(self.force, "loadVector", wrench[:3])
        self.mbs.SetLoadParameter(self.torque, "loadVector", wrench[3:])
        entered = time.perf_counter()
        if not self.mbs.SolveStatic(self.settings, updateInitialValues=True):
            raise RuntimeError(f"Exudyn did not converge under {wrench}")
        self.inside += time.perf_counter() - entered
        moved = self.mbs.GetObjectOutputBody(
            self.platform[0], exu.OutputVariableType.Displacement, localPosition=o.TOOL.tolist()
        )
        result = self.mbs.sys["staticSolver"].it.newtonStepsCount, np.array(moved).tolist()
        self.total += time.perf_counter() - started
        return result


def measure(position, cases, springs_per_beam):
    turn_loads = [wrench.tolist() for share, _, wrench in cases if share == 1]
    new_place, _ = o.best(ROUNDS, lambda: Mechanism(position, springs_per_beam).solve(turn_loads[0]))
    mechanism = Mechanism(position, springs_per_beam)
    displacements = [mechanism.solve(wrench.tolist())[1] for *_, wrench in cases]
    mechanism = Mechanism(position, springs_per_beam)
    turn, solved = o.best_turn(ROUNDS, mechanism.solve, turn_loads)
    return {
        "new_place_us": 1e6 * new_place,
        "solve_us": 1e6 * turn / len(turn_loads),
        "iterations": sum(iterations for iterations, _ in solved) / len(solved),
        "inside_share": mechanism.inside / mechanism.total,
        "tool_displacements_mm": displacements,
    }


def main():
    models = []
    for springs_per_beam in (1, 8):
        points = [
            {"name": name, **measure(position, cases, springs_per_beam)}
            for name, (position, cases) in o.cases(sys.argv[1]).items()
        ]
        division = "1 spring" if springs_per_beam == 1 else f"{springs_per_beam} springs"
        models.append({"model": f"rigid bodies, {division} per beam", "points": points})
    o.report(sys.argv[2], f"Exudyn {exu.config.Version() if hasattr(exu, 'config') else exu.GetVersionString()}", models)


if __name__ == "__main__":
    main()
