"""The Orthoglide as a frame of corotational beams in OpenSees (through OpenSeesPy).

Feet and bars are elasticBeamColumn elements under the Corotational transformation. Every passive joint is the released end
of a beam, whose axis turns with the beam: q1 at the foot's tip, q2 at both ends of both bars, q3 at the platform. Short
links, platform and tool are beams far stiffer than the rest. The drive is a zeroLength spring along the rail. Static
Newton analysis with the whole load in one step; the model stays and only the load changes between tool angles.
"""

import sys
import time

import numpy as np
import openseespy.opensees as ops
import orthoglide as o

ROUNDS = 25
# Rigid parts: times area and moments of inertia of a bar.
STIFFER = 1e6
PLATFORM, TOOL = 1, 2


class Frame:
    def __init__(self, position, elements):
        self.tag = 100
        self.inside = self.total = 0.0
        ops.wipe()
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        ops.uniaxialMaterial("Elastic", 1, o.DRIVE_STIFFNESS)
        ops.timeSeries("Constant", 1)
        ops.node(PLATFORM, *position.tolist())
        ops.node(TOOL, *(position + o.TOOL).tolist())
        self.rigid(PLATFORM, TOOL, [1.0, 0.0, 0.0])
        for i, leg in enumerate(o.legs(position)):
            self.leg(i, leg, elements)
        ops.system("BandGeneral")
        ops.numberer("RCM")
        ops.constraints("Plain")
        ops.test("NormDispIncr", 1e-9, 30)
        ops.algorithm("Newton")
        ops.integrator("LoadControl", 1.0)
        ops.analysis("Static")

    def next_tag(self):
        self.tag += 1
        return self.tag

    def node(self, at):
        tag = self.next_tag()
        ops.node(tag, *at.tolist())
        return tag

    def beam(self, start, end, section, z, *release):
        transformation, tag = self.next_tag(), self.next_tag()
        ops.geomTransf("Corotational", transformation, *[float(c) for c in z])
        numbers = [section.area, o.E, o.G, section.torsion, section.i_y, section.i_z]
        ops.element("elasticBeamColumn", tag, start, end, *numbers, transformation, *release)

    def rigid(self, start, end, z, *release):
        a, i, j = (STIFFER * value for value in (o.BAR.area, o.BAR.i_y, o.BAR.torsion))
        transformation, tag = self.next_tag(), self.next_tag()
        ops.geomTransf("Corotational", transformation, *[float(c) for c in z])
        ops.element("elasticBeamColumn", tag, start, end, a, o.E, o.G, j, i, i, transformation, *release)

    def beams(self, start, end, places, section, z, option, release):
        """A beam divided at `places`; `release` is 0, 1 (start), 2 (end) or 3, as OpenSees counts."""
        nodes = [start, *map(self.node, places), end]
        for k, (first, second) in enumerate(zip(nodes, nodes[1:])):
            code = release & ((k == 0) + 2 * (k == len(places)))
            self.beam(first, second, section, z, *((option, code) if code else ()))

    def leg(self, axis, leg, elements):
        ground, slider, foot_tip, platform_joint = map(
            self.node, (leg.slider, leg.slider, leg.foot_tip, leg.platform_joint)
        )
        ops.fix(ground, 1, 1, 1, 1, 1, 1)
        # The rail is parallel to an axis of O: only that translation is free.
        ops.fix(slider, *[int(dof != axis) for dof in range(6)])
        ops.element("zeroLength", self.next_tag(), ground, slider, "-mat", 1, "-dir", axis + 1)
        places = np.linspace(leg.slider, leg.foot_tip, elements + 1)[1:-1]
        self.beams(slider, foot_tip, places, o.FOOT, leg.foot_axes()[:, 2], "-releasey", 2)
        for side in (1, -1):
            arm = side * o.SHORT_LINK / 2 * leg.u
            places = np.linspace(leg.foot_tip + arm, leg.platform_joint + arm, elements + 1)
            near, far = self.node(places[0]), self.node(places[-1])
            self.rigid(foot_tip, near, leg.normal)
            self.rigid(platform_joint, far, leg.normal)
            self.beams(near, far, places[1:-1], o.BAR, leg.normal, "-releasez", 3)
        self.rigid(platform_joint, PLATFORM, leg.n, "-releasey", 1)

    def solve(self, wrench):
        """Newton iterations made and the tool's displacement, from where the last load left the frame."""
        started = time.perf_counter()
        ops.remove("loadPattern", 1)
        ops.pattern("Plain", 1, 1)
        ops.load(PLATFORM, *wrench)
        entered = time.perf_counter()
        if ops.analyze(1) != 0:
            raise RuntimeError(f"OpenSees did not converge under {wrench}")
        self.inside += time.perf_counter() - entered
        result = ops.testIter(), [ops.nodeDisp(TOOL, k) for k in (1, 2, 3)]
        self.total += time.perf_counter() - started
        return result


def measure(position, cases, elements):
    turn_loads = [wrench.tolist() for share, _, wrench in cases if share == 1]
    new_place, _ = o.best(ROUNDS, lambda: Frame(position, elements).solve(turn_loads[0]))
    frame = Frame(position, elements)
    displacements = [frame.solve(wrench.tolist())[1] for *_, wrench in cases]
    frame = Frame(position, elements)
    turn, solved = o.best_turn(ROUNDS, frame.solve, turn_loads)
    return {
        "new_place_us": 1e6 * new_place,
        "solve_us": 1e6 * turn / len(turn_loads),
        "iterations": sum(iterations for iterations, _ in solved) / len(solved),
        "inside_share": frame.inside / frame.total,
        "tool_displacements_mm": displacements,
    }


def main():
    models = []
    for elements in (1, 8):
        points = [
            {"name": name, **measure(position, cases, elements)}
            for name, (position, cases) in o.cases(sys.argv[1]).items()
        ]
        division = "1 element" if elements == 1 else f"{elements} elements"
        models.append({"model": f"corotational beams, {division} per beam", "points": points})
    ops.wipe()
    o.report(sys.argv[2], f"OpenSees {ops.version()}", models)


if __name__ == "__main__":
    main()
