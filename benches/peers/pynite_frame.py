"""The Orthoglide as a linear space frame in PyNite.

The same beams and released ends as in `opensees_frame.py`, but first-order theory: one linear system for all loads. The
drive is a support spring along the rail. A turn of the tool is one `analyze_linear` with one load combination per angle.
"""

import sys
from importlib.metadata import version

import numpy as np
import orthoglide as o
from Pynite import FEModel3D

ROUNDS = 8
# Rigid parts: times area and moments of inertia of a bar.
STIFFER = 1e6
DIRECTIONS = ["FX", "FY", "FZ", "MX", "MY", "MZ"]


def frame(position, wrenches):
    model = FEModel3D()
    model.add_material("aluminium", o.E, o.G, o.E / (2 * o.G) - 1, 0)
    for name, section, factor in (("foot", o.FOOT, 1), ("bar", o.BAR, 1), ("rigid", o.BAR, STIFFER)):
        numbers = (section.area, section.i_y, section.i_z, section.torsion)
        model.add_section(name, *(factor * number for number in numbers))

    def node(name, at):
        return model.add_node(name, *at.tolist())

    def beam(start, end, section, z, **releases):
        name = f"{start}-{end}"
        model.add_member(name, start, end, "aluminium", section)
        # PyNite chooses the local y and z itself; turn them about the beam until z is ours.
        member = model.members[name]
        x, y, own_z = member.T()[:3, :3]
        member.rotation = np.degrees(np.arctan2(np.dot(np.cross(own_z, z), x), np.dot(own_z, z)))
        assert np.allclose(member.T()[2, :3], z / np.linalg.norm(z)), name
        if releases:
            model.def_releases(name, **releases)

    node("P", position)
    node("T", position + o.TOOL)
    beam("P", "T", "rigid", np.array([1.0, 0.0, 0.0]))
    for axis, leg in zip("XYZ", o.legs(position)):
        slider, tip = node(f"slider {axis}", leg.slider), node(f"foot tip {axis}", leg.foot_tip)
        end = node(f"platform joint {axis}", leg.platform_joint)
        model.def_support(slider, *(axis != other for other in "XYZ"), True, True, True)
        model.def_support_spring(slider, f"D{axis}", o.DRIVE_STIFFNESS)
        beam(slider, tip, "foot", leg.foot_axes()[:, 2], Ryj=True)
        for side in (1, -1):
            arm = side * o.SHORT_LINK / 2 * leg.u
            near, far = node(f"near {axis}{side}", leg.foot_tip + arm), node(f"far {axis}{side}", leg.platform_joint + arm)
            beam(tip, near, "rigid", leg.normal)
            beam(end, far, "rigid", leg.normal)
            beam(near, far, "bar", leg.normal, Rzi=True, Rzj=True)
        beam(end, "P", "rigid", leg.n, Ryi=True)
    for i, wrench in enumerate(wrenches):
        for direction, value in zip(DIRECTIONS, wrench.tolist()):
            model.add_node_load("P", direction, value, case=f"load {i}")
        model.add_load_combo(str(i), {f"load {i}": 1})
    return model


def solve(model, count):
    model.analyze_linear(check_stability=False)
    tool = model.nodes["T"]
    return [[tool.DX[str(i)], tool.DY[str(i)], tool.DZ[str(i)]] for i in range(count)]


def main():
    points = []
    for name, (position, cases) in o.cases(sys.argv[1]).items():
        turn_loads = [wrench for share, _, wrench in cases if share == 1]
        new_place, _ = o.best(ROUNDS, lambda: solve(frame(position, turn_loads[:1]), 1))
        model = frame(position, turn_loads)
        turn, _ = o.best(ROUNDS, lambda: solve(model, len(turn_loads)))
        model = frame(position, [wrench for *_, wrench in cases])
        displacements = solve(model, len(cases))
        points.append(
            {
                "name": name,
                "new_place_us": 1e6 * new_place,
                "solve_us": 1e6 * turn / len(turn_loads),
                "iterations": None,
                "tool_displacements_mm": [[float(value) for value in moved] for moved in displacements],
            }
        )
    model = "linear frame, all tool angles in one analysis"
    o.report(sys.argv[2], f"PyNite {version('PyNiteFEA')}", [{"model": model, "points": points}])


if __name__ == "__main__":
    main()
