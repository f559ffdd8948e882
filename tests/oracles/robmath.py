"""Rotations, frames, circles and the move of robots: shared by krl.py, rapid.py, urscript.py, fanuc_ls.py."""
import math
from dataclasses import dataclass

from move import Move

I3 = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
NULL = (I3, (0.0, 0.0, 0.0))


@dataclass
class RMove(Move):
    via: object = None      # arcs: the point that was programmed between start and end, in the first workpiece frame
    start: object = None    # where the move begins, if known
    zone: object = None     # mm, or None where it is not known; 0 for an exact stop
    tool: object = None     # rotation of the tool's frame in the flange's
    standing: bool = False  # the tool stands, the robot carries the part
    joints: object = None   # of joint targets, whose end is not known
    note: str = ""


def mul(a, b):
    return tuple(tuple(sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)) for i in range(3))


def tr(a):
    return tuple(zip(*a))


def app(a, v):
    return tuple(sum(a[i][k] * v[k] for k in range(3)) for i in range(3))


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def sca(s, a):
    return tuple(s * x for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def norm(a):
    return math.sqrt(dot(a, a))


def dist(a, b):
    return norm(sub(a, b))


def fmul(f, g):
    return (mul(f[0], g[0]), add(app(f[0], g[1]), f[1]))


def finv(f):
    r = tr(f[0])
    return (r, sca(-1.0, app(r, f[1])))


def rx(a):
    c, s = math.cos(a), math.sin(a)
    return ((1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c))


def ry(a):
    c, s = math.cos(a), math.sin(a)
    return ((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c))


def rz(a):
    c, s = math.cos(a), math.sin(a)
    return ((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0))


def zyx(a, b, c):
    """Rz(a) Ry(b) Rx(c), degrees: KUKA's A, B, C and FANUC's R, P, W."""
    a, b, c = (math.radians(v) for v in (a, b, c))
    return mul(mul(rz(a), ry(b)), rx(c))


def to_zyx(r):
    b = math.atan2(-r[2][0], math.hypot(r[0][0], r[1][0]))
    if math.hypot(r[0][0], r[1][0]) > 1e-9:
        a, c = math.atan2(r[1][0], r[0][0]), math.atan2(r[2][1], r[2][2])
    else:
        a, c = math.atan2(-r[0][1], r[1][1]), 0.0
    return tuple(math.degrees(v) for v in (a, b, c))


def quat(q):
    n = math.sqrt(sum(v * v for v in q))
    w, x, y, z = (v / n for v in q)
    return ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))


def to_quat(r):
    t = [1 + r[0][0] + r[1][1] + r[2][2], 1 + r[0][0] - r[1][1] - r[2][2],
         1 - r[0][0] + r[1][1] - r[2][2], 1 - r[0][0] - r[1][1] + r[2][2]]
    k = max(range(4), key=lambda i: t[i])
    s = 2 * math.sqrt(t[k])
    a, b, c = r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]
    d, e, f = r[0][1] + r[1][0], r[0][2] + r[2][0], r[1][2] + r[2][1]
    q = [(s / 4, a / s, b / s, c / s), (a / s, s / 4, d / s, e / s), (b / s, d / s, s / 4, f / s), (c / s, e / s, f / s, s / 4)][k]
    return tuple(-v for v in q) if q[0] < 0 else q


def rotvec(v):
    a = norm(v)
    if a < 1e-15:
        return I3
    x, y, z = sca(1 / a, v)
    return quat((math.cos(a / 2), math.sin(a / 2) * x, math.sin(a / 2) * y, math.sin(a / 2) * z))


def to_rotvec(r):
    w, *v = to_quat(r)
    s = norm(v)
    if s < 1e-15:
        return (0.0, 0.0, 0.0)
    return sca(2 * math.atan2(s, w) / s, v)


def angle_between(r, s):
    return norm(to_rotvec(mul(tr(r), s)))


def circle(p, q, r):
    """Centre, radius, unit axis of the turn p -> q -> r, and its angle (0 to 2 pi)."""
    u, v = sub(q, p), sub(r, p)
    n = cross(u, v)
    m = dot(n, n)
    if m < 1e-18:
        return None
    c = add(p, sca(1 / (2 * m), add(sca(dot(u, u), cross(v, n)), sca(dot(v, v), cross(n, u)))))
    n = sca(1 / math.sqrt(m), n)
    a, b = sub(p, c), sub(r, c)
    ang = math.atan2(dot(cross(a, b), n), dot(a, b)) % (2 * math.pi)
    return c, norm(a), n, ang


def turn_about(axis, ang, v):
    return app(rotvec(sca(ang, axis)), v)


# What a program that cannot be read makes of an interpreter.
UNREAD = (IndexError, KeyError, TypeError, AttributeError, ValueError, ZeroDivisionError)


def selftest(name, hand, run, generate, n, near=1e-6, mismatch=1e-6, also=lambda move: True):
    """Checks the programs `hand` (name, files, main, ends) and `n` random ones, no two alike: arcs whose radii agree at both ends, and what `also` asks of moves."""
    for label, files, main, want in hand:
        got = [m.end for m in run(files, main, {})]
        assert len(got) == len(want) and all(dist(a, b) < near for a, b in zip(got, want)), (label, got)
    seen, count = set(), 0
    for s in range(n):
        files, main, opt = generate(s)
        assert files[main] not in seen
        seen.add(files[main])
        mv = run(files, main, opt)
        count += len(mv)
        for m in mv:
            if m.kind == "arc":
                assert abs(dist(m.start, m.centre) - dist(m.end, m.centre)) < mismatch, (s, m)
            assert also(m), (s, m)
    print(f"{name}: {len(hand)} by hand, {n} programs, {count} moves")
