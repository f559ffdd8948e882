"""Plane geometry shared by sinumerik.py and heidenhain.py: arcs, and corners that a control rounds or breaks."""
import math
from move import Move, Refused


def add(a, b, s=1.0): return tuple(x + s * y for x, y in zip(a, b))
def dot(a, b): return sum(x * y for x, y in zip(a, b))
def cross(a, b): return (a[1]*b[2]-a[2]*b[1], a[2]*b[0]-a[0]*b[2], a[0]*b[1]-a[1]*b[0])
def mul(a, s): return tuple(x * s for x in a)
def norm(a): return math.sqrt(dot(a, a))
def dist(a, b): return norm(add(a, b, -1.0))


SAME = 1e-5      # mm: ends nearer than this are the same point (a whole circle)


def sweep(a, b, c, sense, further=0):
    """Signed angle from a to b about c in the plane; a whole circle if they are the same."""
    if math.hypot(a[0]-b[0], a[1]-b[1]) < SAME:
        ang = 2 * math.pi
    else:
        ang = math.atan2(b[1]-c[1], b[0]-c[0]) - math.atan2(a[1]-c[1], a[0]-c[0])
        ang = (ang if sense > 0 else -ang) % (2 * math.pi)
    return sense * (ang + 2 * math.pi * further)


def centre_by_radius(a, b, r, sense):
    """Centre of the arc a to b; r > 0: at most half a circle, r < 0: more. None if the chord is too long."""
    dx, dy = b[0]-a[0], b[1]-a[1]
    q = math.hypot(dx, dy)
    if q < SAME or q / 2 > abs(r) + 0.01:
        return None
    h = math.sqrt(max(r*r - q*q/4, 0.0))
    s = sense if r > 0 else -sense          # the centre of a short counter-clockwise arc is left of the chord
    return (a[0] + dx/2 - s*h*dy/q, a[1] + dy/2 + s*h*dx/q)


def centre_by_tangent(a, t, b):
    """Centre and sense of the arc from a with the direction t at a to b; (None, 0): a straight line; (None, None): back."""
    dx, dy = b[0]-a[0], b[1]-a[1]
    n = (-t[1], t[0])
    k = dx*n[0] + dy*n[1]
    q = dx*dx + dy*dy
    if abs(k) < 1e-9 * math.sqrt(q):
        return (None, 0) if dx*t[0] + dy*t[1] > 0 else (None, None)
    r = q / (2*k)
    return (a[0] + r*n[0], a[1] + r*n[1]), (1 if r > 0 else -1)


class Seg:
    def __init__(self, kind, a, b, basis, file, line, feed, c=None, n=None, ang=0.0):
        self.kind, self.a, self.b, self.basis = kind, a, b, basis     # basis: u, v, w of the plane in W
        self.file, self.line, self.feed = file, line, feed
        self.c, self.n, self.ang = c, n, ang
        self.corner = None                                            # ("round" | "leg" | "base", value, line, feed)

    def dir_at(self, end):
        """Direction of travel at the start (0) or end (1)."""
        if self.kind != "arc":
            d = add(self.b, self.a, -1.0)
            return mul(d, 1/norm(d)) if norm(d) > 1e-9 else None
        p = add(self.b if end else self.a, self.c, -1.0)
        t = cross(self.n, p)
        return mul(t, (1 if self.ang > 0 else -1) / norm(t))


class Chain:
    """Takes segments in order, inserts corners, hands out moves."""
    def __init__(self):
        self.moves, self.held = [], None

    def put(self, s):
        if self.held:
            p, self.held = self.held, None
            self._corner(p, s)
        if s.corner:
            self.held = s
        else:
            self._out(s)

    def flush(self, end=False):
        """What comes next is not seen by a corner; at the end of the program it is left out."""
        if self.held:
            p, self.held = self.held, None
            if not end: raise Refused(p.file, p.line, "corner without a next move that is followed")
            self._out(p)

    def _out(self, s, known=0.0):
        arc = s.kind == "arc"
        self.moves.append(Move(s.kind, s.file, s.line, s.b, None, s.c if arc else None,
                               mul(s.n, s.ang) if arc else None, s.feed, known=known))

    def _corner(self, p, s):
        how, val, line, feed = p.corner
        known = 0.0
        def no(why): raise Refused(p.file, line, why)
        if p.kind == "rapid" or s.kind == "rapid":
            no("corner at a rapid move")
        u, v, w = p.basis
        P = p.b
        two = lambda q: (dot(add(q, P, -1.0), u), dot(add(q, P, -1.0), v))
        geo = []
        for g, end in ((p, 1), (s, 0)):
            if abs(dot(add(g.b, g.a, -1.0), w)) > 1e-9 or (g.kind == "arc" and abs(abs(dot(g.n, w))-1) > 1e-9):
                no("corner beside a move that leaves the plane")
            t = g.dir_at(end)
            if t is None: no("corner beside a move without length")
            t = (dot(t, u), dot(t, v))
            if g.kind == "arc":
                c = two(g.c)
                geo.append(("arc", t, c, math.hypot(*c), (1 if g.ang > 0 else -1) * (1 if dot(g.n, w) > 0 else -1)))
            else:
                geo.append(("line", t, dist(g.a, g.b)))
        (t1, t2) = geo[0][1], geo[1][1]
        x = t1[0]*t2[1] - t1[1]*t2[0]
        if abs(x) < 1e-7:
            if t1[0]*t2[0] + t1[1]*t2[1] > 0 or how == "none":
                self._out(p); return
            no("corner of 180 degrees")
        side = 1 if x > 0 else -1
        if how != "round":
            if geo[0][0] == "arc" or geo[1][0] == "arc":
                no("chamfer beside an arc")
            leg = val
            if how == "base":
                leg = val / (2 * math.cos(math.atan2(abs(x), t1[0]*t2[0]+t1[1]*t2[1]) / 2))
            if leg >= min(geo[0][2], geo[1][2]) - 1e-6: no("chamfer longer than its lines")
            A, B = mul(t1, -leg), mul(t2, leg)
            M = None
        else:
            M = _nearest(geo, p, s, val * side, two)
            if M is None: no("rounding longer than its neighbours")
            A, B = _foot(geo[0], M), _foot(geo[1], M)
            # Where the radii of an arc differ at its ends, no manual says how it runs between: known to what the other radius makes of the corner.
            far = [g[:3] + (dist(q, e.c),) + g[4:] if g[0] == "arc" else g for g, e, q in ((geo[0], p, p.a), (geo[1], s, s.b))]
            other = _nearest(far, p, s, val * side, two)
            if other is not None:
                known = max(math.dist(A, _foot(far[0], other)), math.dist(B, _foot(far[1], other)))
        up = lambda q: add(add(P, u, q[0]), v, q[1])
        a3, b3 = up(A), up(B)
        if p.kind == "arc":
            p.ang -= (1 if p.ang > 0 else -1) * _back(geo[0], p, M, two, True)
        if s.kind == "arc":
            s.ang -= (1 if s.ang > 0 else -1) * _on(geo[1], s, M, two, True)
        p.b, s.a = a3, b3
        self._out(p, known)
        if M is None:
            self._out(Seg("line", a3, b3, p.basis, p.file, line, feed))
        else:
            self._out(Seg("arc", a3, b3, p.basis, p.file, line, feed, up(M), w, sweep(A, B, M, side)), known)


def _nearest(geo, p, s, r, two):
    """The centre of the rounding that is nearest to the corner; None if none fits."""
    best = None
    for m in _meet(geo, r):
        d = [_back(geo[0], p, m, two), _on(geo[1], s, m, two)]
        if None not in d and (best is None or sum(d) < best[0]): best = (sum(d), m)
    return best and best[1]


def _meet(geo, r):
    """Where the curves at the distance r left of both elements meet (all relative to the corner)."""
    lines = [(g[1], r) for g in geo if g[0] == "line"]
    arcs = [(g[2], g[3] - r*g[4]) for g in geo if g[0] == "arc"]
    if any(R <= 1e-6 for _, R in arcs): return []
    if len(lines) == 2:
        (s, _), (t, _) = lines
        x = s[0]*t[1] - s[1]*t[0]
        # normal(s).q = r and normal(t).q = r
        a, b = (-s[1], s[0]), (-t[1], t[0])
        return [((r*b[1] - r*a[1]) / x, (a[0]*r - b[0]*r) / x)]
    if len(lines) == 1:
        (t, _), (c, R) = lines[0], arcs[0]
        n = (-t[1], t[0])
        k = c[0]*n[0] + c[1]*n[1] - r
        if abs(k) > R: return []
        h = math.sqrt(R*R - k*k)
        f = (c[0] - k*n[0], c[1] - k*n[1])
        return [(f[0] + h*t[0], f[1] + h*t[1]), (f[0] - h*t[0], f[1] - h*t[1])]
    (c, R), (e, S) = arcs
    dx, dy = e[0]-c[0], e[1]-c[1]
    q = math.hypot(dx, dy)
    if q < 1e-9 or q > R+S or q < abs(R-S): return []
    a = (R*R - S*S + q*q) / (2*q)
    h = math.sqrt(max(R*R - a*a, 0))
    return [(c[0] + (a*dx - k*h*dy)/q, c[1] + (a*dy + k*h*dx)/q) for k in (1, -1)]


def _foot(g, m):
    if g[0] == "line":
        k = m[0]*g[1][0] + m[1]*g[1][1]
        return (k*g[1][0], k*g[1][1])
    c, R = g[2], g[3]
    q = math.hypot(m[0]-c[0], m[1]-c[1])
    return (c[0] + (m[0]-c[0])*R/q, c[1] + (m[1]-c[1])*R/q)


def _back(g, seg, m, two, angle=False):
    """Length (or angle) between the foot of m and the corner along the element before it; None beyond its start."""
    f = _foot(g, m)
    if g[0] == "line":
        k = -(f[0]*g[1][0] + f[1]*g[1][1])
        return k if 1e-9 < k < g[2] - 1e-6 else None
    t = abs(sweep(f, (0.0, 0.0), g[2], g[4]))
    if t >= abs(seg.ang) - 1e-7: return None
    return t if angle else t * g[3]


def _on(g, seg, m, two, angle=False):
    f = _foot(g, m)
    if g[0] == "line":
        k = f[0]*g[1][0] + f[1]*g[1][1]
        return k if 1e-9 < k < g[2] - 1e-6 else None
    t = abs(sweep((0.0, 0.0), f, g[2], g[4]))
    if t >= abs(seg.ang) - 1e-7: return None
    return t if angle else t * g[3]


def selftest(run, generate, n):
    """Runs `n` random programs twice: the same ends, all of them numbers, and arcs whose radii agree at both ends."""
    from check import mismatch
    kinds, lens = {}, []
    for seed in range(n):
        files, name, opt = generate(seed)
        mv = run(files, name, opt)
        assert [m.end for m in mv] == [m.end for m in run(files, name, opt)]
        last = None
        for m in mv:
            kinds[m.kind] = kinds.get(m.kind, 0) + 1
            assert all(math.isfinite(x) for x in m.end)
            if m.kind == "arc": assert mismatch(last, m) < .0021, (seed, m, mismatch(last, m))
            last = m.end
        lens.append(files[name].count(b"\n"))
    print(f"{n} programs, {min(lens)} to {max(lens)} lines, moves: {kinds}")
