"""Linear virtual joint method in NumPy, as one would write it from the formulas.

Per chain: Jacobians of virtual and passive joints from the product of homogeneous transforms, compliance of the virtual
joints, passive joints condensed, stiffnesses of the chains added, and the platform's displacement from one 6x6 system:

    [ J_th K_th^-1 J_th^T   J_q ] [F]   [dx]
    [ J_q^T                 0   ] [dq] = [0 ]      K_C = sum K_i,    dx = K_C^-1 F

Everything at the unloaded pose: there is no iteration, and no effect of the load on the geometry.
"""

import sys

import numpy as np
import orthoglide as o

ROUNDS = 200


def translation(axis, value):
    h = np.eye(4)
    h[axis, 3] = value
    return h


def rotation(axis, angle):
    h = np.eye(4)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    h[i, i] = h[j, j] = np.cos(angle)
    h[i, j], h[j, i] = -np.sin(angle), np.sin(angle)
    return h


def column(h, axis, is_rotation, p):
    """Twist at `p` of a joint along `axis` of the frame `h`."""
    direction = h[:3, axis]
    if is_rotation:
        return np.concatenate([np.cross(direction, p - h[:3, 3]), direction])
    return np.concatenate([direction, np.zeros(3)])


def parallelogram_stiffness(q2):
    """5x5: two bars with released end joints, seen from the middle; the motion across the bars is the passive joint."""
    length = o.BAR_LENGTH
    bar = o.released(o.beam_stiffness(length, o.BAR), [0, length, 0, 0, 0, 1], [0, 0, 0, 0, 0, 1])
    total = np.zeros((6, 6))
    for sign in (1, -1):
        x, y, z = sign * o.SHORT_LINK / 2 * np.array([np.sin(q2), np.cos(q2), 0])
        shift = np.eye(6)
        shift[:3, 3:] = -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        total += shift.T @ bar @ shift
    kept = [0, 2, 3, 4, 5]
    return total[np.ix_(kept, kept)]


def chain_stiffness(position, base):
    q1, q2 = o.passive_angles(position, base)
    c = base.T @ position
    rho = c[0] - o.PLATFORM_OFFSET - o.BAR_LENGTH * np.cos(q1) * np.cos(q2)
    h = np.eye(4)
    h[:3, :3] = base
    h = h @ translation(0, rho)
    virtual, passive = [column(h, 0, False, position)], []
    h = h @ rotation(1, -o.FOOT_LEAN)
    virtual += [column(h, axis, turns, position) for turns in (False, True) for axis in range(3)]
    h = h @ rotation(1, o.FOOT_LEAN)
    passive.append(column(h, 1, True, position))
    h = h @ rotation(1, q1)
    # The platform end of a parallelogram only translates when q2 changes.
    h = h @ rotation(2, q2)
    passive.append(np.concatenate([o.BAR_LENGTH * h[:3, 1], np.zeros(3)]))
    h = h @ translation(0, o.BAR_LENGTH)
    virtual += [column(h, axis, turns, position) for axis, turns in ((0, 0), (2, 0), (0, 1), (1, 1), (2, 1))]
    h = h @ rotation(2, -q2)
    passive.append(column(h, 1, True, position))

    compliance = np.zeros((12, 12))
    compliance[0, 0] = 1 / o.DRIVE_STIFFNESS
    compliance[1:7, 1:7] = np.linalg.inv(o.beam_stiffness(o.FOOT_LENGTH, o.FOOT))
    compliance[7:, 7:] = np.linalg.inv(parallelogram_stiffness(q2))
    j_theta, j_q = np.column_stack(virtual), np.column_stack(passive)
    bordered = np.block([[j_theta @ compliance @ j_theta.T, j_q], [j_q.T, np.zeros((3, 3))]])
    return np.linalg.inv(bordered)[:6, :6]


def stiffness(position):
    return sum(chain_stiffness(position, base) for base in o.BASES)


def tool_displacement(twist):
    return twist[:3] + np.cross(twist[3:], o.TOOL)


def main():
    points = []
    for name, (position, cases) in o.cases(sys.argv[1]).items():
        wrenches = [wrench for share, _, wrench in cases if share == 1]
        k = stiffness(position)
        new_place, _ = o.best(ROUNDS, lambda: tool_displacement(np.linalg.solve(stiffness(position), wrenches[0])))
        turn, _ = o.best_turn(ROUNDS, lambda wrench: tool_displacement(np.linalg.solve(k, wrench)), wrenches)
        points.append(
            {
                "name": name,
                "new_place_us": 1e6 * new_place,
                "solve_us": 1e6 * turn / len(wrenches),
                "iterations": None,
                "tool_displacements_mm": [tool_displacement(np.linalg.solve(k, w)).tolist() for *_, w in cases],
            }
        )
    o.report(sys.argv[2], f"NumPy {np.__version__}", [{"model": "linear VJM, unloaded stiffness", "points": points}])


if __name__ == "__main__":
    main()
