#!/usr/bin/env python3
"""Judge of the cutting force from the stock: what a tool meets, by geometry of its own, and the force of that, by the formulas of docs/your_force.md at each height.

At each height the plan of the material is the stock without what earlier moves have swept whose floor lies below: stadiums of lines, of arcs their
kin, discs of plunges; of ramps and helices the part of the move whose tip is below the height. The circle of the tool is cut with the edges of these (lines and
circles: exactly), the pieces between are asked whether they lie in material, and the law of the chip is integrated along them in closed form.
Of a ball or a corner a height has its own radius and the angle kappa of its surface, and heights are steps of kappa.

Written from the guide by someone who has not seen the program's engagement. Needs numpy; shapely for the proofs of `python3 engagement.py` alone.
"""
import math
import numpy as np

EPS = 1e-7      # mm: nearer than this a point is on an edge and not inside
SLIVER = 2e-3   # rad: a narrower arc is of rounding, and no extreme
TURN = 2 * math.pi


class Tool:
    """`corner` is 0 of a flat end, the radius of a ball."""
    def __init__(self, radius, teeth, corner=0.0):
        self.radius, self.teeth, self.corner = radius, teeth, corner

    def at(self, height):
        """Radius at heights above the tip; negative where there is no tool."""
        height = np.asarray(height, float)
        if not self.corner: return np.where(height >= 0, self.radius, -1.0)
        up = np.clip(height, 0.0, self.corner)
        return np.where(height >= 0, self.radius - self.corner + np.sqrt(np.maximum(0.0, self.corner**2 - (self.corner - up)**2)), -1.0)


class Law:
    """F_t = K_tc h + K_te, F_r = K_rc h + K_re, F_a = K_ac h + K_ae for each mm of edge."""
    def __init__(self, tc, te, rc, re, ac, ae):
        self.tc, self.te, self.rc, self.re, self.ac, self.ae = tc, te, rc, re, ac, ae


class Move:
    """From a to b, (x, y, z) of the tip, straight or, with a centre, about it through `sweep` radians (positive: counter-clockwise)."""
    def __init__(self, tool, a, b, centre=None, sweep=0.0):
        self.tool, self.a, self.b = tool, np.array(a, float), np.array(b, float)
        self.centre, self.sweep = None if centre is None else np.array(centre[:2], float), sweep
        if centre is not None:
            d = self.a[:2] - self.centre
            self.rho, self.start = float(np.hypot(*d)), math.atan2(d[1], d[0])
        self.flat_length = float(np.hypot(*(self.b - self.a)[:2])) if centre is None else self.rho * abs(sweep)
        self.rise = float(self.b[2] - self.a[2])
        self.length = math.hypot(self.flat_length, self.rise)
        # What a plunge sweeps is what it does where it ends.
        self.level = not self.rise or not self.flat_length
        self.floor = float(min(self.a[2], self.b[2]))

    def at(self, t):
        """Plan of the tip at shares t of the move."""
        t = np.asarray(t, float)[..., None]
        if self.centre is None: return self.a[:2] + t * (self.b - self.a)[:2]
        w = self.start + self.sweep * t
        return self.centre + self.rho * np.concatenate([np.cos(w), np.sin(w)], -1)

    def z(self, t): return self.a[2] + t * self.rise

    def heading(self, t):
        """Direction of the feed in the plan, radians."""
        if self.centre is None:
            d = self.b - self.a
            return math.atan2(d[1], d[0])
        return self.start + self.sweep * t + math.copysign(math.pi / 2, self.sweep)

    def share(self, p):
        """Share of the move at which the tip is nearest to p."""
        if self.centre is None:
            d = self.b - self.a
            return float(np.clip((np.array(p) - self.a) @ d / (d @ d), 0, 1))
        w = math.atan2(p[1] - self.centre[1], p[0] - self.centre[0]) - self.start
        w = (w if self.sweep > 0 else -w) % TURN
        turns = [w + TURN * k for k in range(-1, int(abs(self.sweep) // TURN) + 2)]
        turns = [v for v in turns if -1e-6 <= v <= abs(self.sweep) + 1e-6]
        if not turns: return 0.0 if (w > math.pi + abs(self.sweep) / 2) else 1.0
        best = min(turns, key=lambda v: abs(self.z(v / abs(self.sweep)) - p[2]))
        return min(1.0, max(0.0, best / abs(self.sweep)))

    def until(self, t):
        """The part of the move that is done at the share t."""
        m = Move.__new__(Move)
        m.__dict__.update(self.__dict__)
        xy = self.at(t)
        m.b = np.array([xy[0], xy[1], self.z(t)])
        m.sweep, m.flat_length, m.rise, m.length = self.sweep * t, self.flat_length * t, self.rise * t, self.length * t
        return m

    # What it sweeps at the heights z (an array): part of the move, and radius.

    def part(self, z):
        """Shares between which the tool is at the heights z with its full radius of there: (first, last), NaN where never.
        A flat end is where its tip is below; of other tools a level move has them all or none, and of a slope only what is above its corner."""
        if self.level:
            there = self.floor <= z
            return np.where(there, 0.0, np.nan), np.where(there, 1.0, np.nan)
        t = (z - self.tool.corner - self.a[2]) / self.rise
        if self.rise < 0: first, last = np.clip(t, 0, None), np.ones_like(t)
        else: first, last = np.zeros_like(t), np.clip(t, None, 1)
        bad = first > last
        return np.where(bad, np.nan, first), np.where(bad, np.nan, last)

    def swept_radius(self, z):
        return self.tool.at(z - self.floor) if self.level else np.full_like(z, self.tool.radius)

    def inside(self, q, z):
        """Whether points q (rows of heights, points, 2) at the heights z are swept."""
        first, last = self.part(z)
        r = self.swept_radius(z)
        there = np.isfinite(first) & (r > 0)
        f, l = np.where(there, first, 0.0), np.where(there, last, 0.0)
        a, b = self.at(f)[:, None, :], self.at(l)[:, None, :]
        if self.centre is None:
            d = b - a
            dd = np.sum(d * d, -1)
            t = np.clip(np.sum((q - a) * d, -1) / np.where(dd > 0, dd, 1.0), 0, 1)
            gap = np.linalg.norm(q - a - t[..., None] * d, axis=-1)
        else:
            v = q - self.centre
            w = np.arctan2(v[..., 1], v[..., 0]) - (self.start + self.sweep * f)[:, None]
            w = (w if self.sweep > 0 else -w) % TURN
            within = w <= (abs(self.sweep) * (l - f))[:, None]
            ends = np.minimum(np.linalg.norm(q - a, axis=-1), np.linalg.norm(q - b, axis=-1))
            gap = np.where(within, np.abs(np.linalg.norm(v, axis=-1) - self.rho), ends)
        out = there[:, None] & (gap < r[:, None] - EPS)
        if self.tool.corner and not self.level:
            out |= self.in_capsule(q, z)
        return out

    def in_capsule(self, q, z):
        """Of a ball on a slope: nearer to the line of its centre than its radius."""
        if self.centre is not None or self.tool.corner != self.tool.radius: raise NotImplementedError("a corner or an arc on a slope")
        r = self.tool.radius
        a, d = self.a + [0, 0, r], self.b - self.a
        p = np.concatenate([q, np.broadcast_to(z[:, None, None], q.shape[:2] + (1,))], -1) - a
        t = np.clip(p @ d / (d @ d), 0, 1)
        return np.linalg.norm(p - t[..., None] * d, axis=-1) < r - EPS

    def edges(self, p, r, z):
        """Angles (of the plan) at which circles about p with the radii r cross the edges of what is swept at the heights z."""
        first, last = self.part(z)
        rm = self.swept_radius(z)
        a, b = self.at(first), self.at(last)
        out = [circle(p, r, a, rm), circle(p, r, b, rm)]
        if self.centre is None:
            d = (self.b - self.a)[:2]
            if np.hypot(*d) > 0:
                n = np.array([-d[1], d[0]]) / np.hypot(*d)
                out += [line(p, r, n, n @ self.a[:2] + rm), line(p, r, n, n @ self.a[:2] - rm)]
        else:
            out += [circle(p, r, np.broadcast_to(self.centre, a.shape), self.rho + rm), circle(p, r, np.broadcast_to(self.centre, a.shape), np.abs(self.rho - rm))]
        return np.concatenate(out, 1)


def circle(p, r, q, s):
    """Angles on circles about p (2) with radii r (rows) where they cross circles about q (rows, 2) with radii s (rows)."""
    d = q - p
    gap = np.linalg.norm(d, axis=1)
    with np.errstate(all="ignore"):
        c = (r*r + gap*gap - s*s) / (2 * r * gap)
        w = np.arccos(c)
    m = np.arctan2(d[:, 1], d[:, 0])
    return np.stack([m - w, m + w], 1)


def line(p, r, n, offset):
    """The same with a line n·x = offset."""
    with np.errstate(all="ignore"):
        w = np.arccos((offset - n @ p) / r)
    m = math.atan2(n[1], n[0])
    return np.stack([m - w, m + w], 1)


class Stock:
    """A box less what moves have swept."""
    def __init__(self, low, high):
        self.low, self.high, self.moves = np.array(low, float), np.array(high, float), []

    def edges(self, p, r, z, moves):
        sides = [line(p, r, np.array(n, float), np.full_like(r, o)) for n, o in
                 (((1, 0), self.low[0]), ((1, 0), self.high[0]), ((0, 1), self.low[1]), ((0, 1), self.high[1]))]
        return np.concatenate(sides + [m.edges(p, r, z) for m in moves], 1)

    def material(self, q, z, moves):
        inside = np.all((q > self.low[:2] + EPS) & (q < self.high[:2] - EPS), -1) & ((z > self.low[2]) & (z < self.high[2]))[:, None]
        for m in moves:
            if not inside.any(): break
            inside &= ~m.inside(q, z)
        return inside


class Cut:
    """What a move meets at the share t of it: `force` on the tool in (feed, left of the feed, towards the spindle), the sum of the `sizes` of the forces
    of its heights, and as extremes over them `entry`, `exit` and `depth`. With `slices` it has a fault: one arc at the middle of each so many mm."""
    def __init__(self, stock, move, t, law, chip, steps=96, slices=None, narrow=None):
        tool = move.tool
        p, tip = move.at(t), move.z(t)
        chip_across, chip_up = chip * move.flat_length / move.length, chip * move.rise / move.length
        near = [m for m in stock.moves if near_to(m, p, tool.radius)]
        moves = near + ([move.until(t)] if t > 0 else [])
        top = stock.high[2]
        self.force, self.sizes = np.zeros(3), 0.0
        self.entry, self.exit, self.depth = math.inf, -math.inf, 0.0
        if tip >= top: return
        # Heights where something begins or ends.
        levels = {tip, top, stock.low[2]}
        for m in moves:
            for z in (m.a[2], m.b[2]):
                levels |= {z, z + m.tool.corner}
        if tool.corner: levels.add(tip + tool.corner)
        if narrow:
            tip_level, top = max(tip, narrow[0]), min(top, narrow[1])
            levels |= {tip_level, top}
        levels = sorted(z for z in levels if (tip_level if narrow else tip) <= z <= top and z >= stock.low[2])
        if slices: levels = list(np.linspace(tip, top, math.ceil((top - tip) / slices) + 1))
        rows = []       # z, height of the row along the edge, kappa
        for lo, hi in zip(levels, levels[1:]):
            if hi - lo < 1e-9: continue
            corner = tool.corner and hi <= tip + tool.corner + 1e-12
            changes = any(not m.level and min(m.a[2], m.b[2]) < hi and max(m.a[2], m.b[2]) + m.tool.corner > lo for m in moves) or \
                any(m.tool.corner and m.a[2] < hi and m.a[2] + m.tool.corner > lo for m in moves)
            if corner:
                k0, k1 = (math.acos(max(-1.0, min(1.0, 1 - (z - tip) / tool.corner))) for z in (lo, hi))
                n = max(12, steps)
                for i in range(n):
                    k = k0 + (k1 - k0) * (i + 0.5) / n
                    rows.append((tip + tool.corner * (1 - math.cos(k)), tool.corner * (k1 - k0) / n, k))
            else:
                n = steps if changes and not slices else 1
                for i in range(n): rows.append((lo + (hi - lo) * (i + 0.5) / n, (hi - lo) / n, math.pi / 2))
        if not rows: return
        slopes = [m for m in moves if m.tool.corner and not m.level]
        if slopes and not narrow:      # once coarsely; then where something was cut
            cut = Cut(stock, move, t, law, chip, 48, narrow=(tip, top))
            if not cut.sizes: return
            cut = Cut(stock, move, t, law, chip, max(48, steps // 2), narrow=cut.between)
            self.__dict__.update(cut.__dict__)
            return
        z, length, kappa = (np.array(c) for c in zip(*rows))
        r = tool.at(z - tip)
        heading = move.heading(t)
        psi_of = lambda angle: (heading + math.pi / 2 - angle) % TURN      # from the left of the feed towards the feed, seen from the spindle clockwise
        edges = psi_of(stock.edges(p, r, z, moves))
        # The chip h = alpha sin psi + beta, and where it ends.
        alpha, beta = chip_across * np.sin(kappa), -chip_up * np.cos(kappa)
        with np.errstate(all="ignore"):
            w = np.arcsin(np.clip(-beta / np.where(alpha > 0, alpha, 1.0), -1, 1))
        marks = [edges, (w % TURN)[:, None], ((math.pi - w) % TURN)[:, None], np.zeros((len(z), 1)), np.full((len(z), 1), TURN)]
        if slopes: marks.append(self.found(stock, moves, p, r, z, heading))
        marks = np.sort(np.where(np.isfinite(np.concatenate(marks, 1)), np.concatenate(marks, 1), 0.0), 1)
        a, b = marks[:, :-1], marks[:, 1:]
        mid = (a + b) / 2
        angle = heading + math.pi / 2 - mid
        q = p + r[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], -1)
        cuts = (b - a > 1e-12) & (alpha[:, None] * np.sin(mid) + beta[:, None] > 1e-15)
        cuts &= stock.material(q, z, moves)
        a, b = np.where(cuts, a, 0.0), np.where(cuts, b, 0.0)
        one, sin, cos = b - a, np.cos(a) - np.cos(b), np.sin(b) - np.sin(a)
        sin2, sincos = (b - a) / 2 - (np.sin(2*b) - np.sin(2*a)) / 4, (np.sin(b)**2 - np.sin(a)**2) / 2
        cos2 = (b - a) - sin2
        A, B = alpha[:, None], beta[:, None]
        s, k = np.sin(kappa)[:, None], np.cos(kappa)[:, None]
        # Each of t, r, a times 1, sin, cos.
        def along(c, e): return c * (A * sin + B * one) + e * one, c * (A * sin2 + B * sin) + e * sin, c * (A * sincos + B * cos) + e * cos
        t1, ts, tc = along(law.tc, law.te)
        r1, rs, rc = along(law.rc, law.re)
        a1, as_, ac = along(law.ac, law.ae)
        f = -tc - s * rs + k * as_
        n = ts - s * rc + k * ac
        up = k * r1 + s * a1
        each = np.stack([f.sum(1), n.sum(1), up.sum(1)], 1) * (length * tool.teeth / TURN)[:, None]
        self.force, self.sizes = each.sum(0), float(np.linalg.norm(each, axis=1).sum())
        wide = cuts & (b - a > SLIVER)
        some = wide.any(1)
        if some.any():
            self.entry, self.exit = float(a[wide].min()), float(b[wide].max())
            self.depth = float((z + np.where(kappa == math.pi / 2, length / 2, 0) - tip)[some].max())
            i = np.flatnonzero(some)
            self.between = float(z[max(0, i[0] - 2)]) if i[0] > 1 else tip, float(z[min(len(z) - 1, i[-1] + 2)]) if i[-1] < len(z) - 2 else top

    @staticmethod
    def found(stock, moves, p, r, z, heading, n=360):
        """Edges that no formula gives, looked for in steps of a degree and halved."""
        grid = np.linspace(0, TURN, n + 1)
        def is_in(psi):
            angle = heading + math.pi / 2 - psi
            return stock.material(p + r[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], -1), z, moves)
        at = is_in(np.broadcast_to(grid + 1e-9, (len(z), n + 1)))
        change = at[:, 1:] != at[:, :-1]
        most = int(change.sum(1).max())
        if not most: return np.zeros((len(z), 1))
        order = np.argsort(~change, 1, kind="stable")[:, :most]
        lo, hi = grid[order], grid[order + 1]
        first = np.take_along_axis(at, order, 1)
        for _ in range(30):
            mid = (lo + hi) / 2
            same = is_in(mid) == first
            lo, hi = np.where(same, mid, lo), np.where(same, hi, mid)
        return (lo + hi) / 2


def near_to(m, p, r):
    """Whether the move comes near enough to matter."""
    reach = r + m.tool.radius + 0.01
    if m.centre is None:
        d = (m.b - m.a)[:2]
        dd = d @ d
        t = np.clip((p - m.a[:2]) @ d / dd, 0, 1) if dd else 0.0
        return np.hypot(*(p - m.a[:2] - t * d)) < reach
    return abs(np.hypot(*(p - m.centre)) - m.rho) < reach


def by_polygons(stock, move, t, law, chip, heights=200, angles=20000):
    """The force of a flat end once more: polygons of shapely less one another at each height, and teeth in small steps of the turn."""
    import shapely
    tool, p, tip = move.tool, move.at(t), move.z(t)
    low, high = max(tip, stock.low[2]), stock.high[2]
    if low >= high: return np.zeros(3)
    heading, ahead, force = move.heading(t), move.flat_length / move.length, np.zeros(3)
    psi = (np.arange(angles) + 0.5) * math.pi / angles
    edge = np.stack([np.cos(heading + math.pi / 2 - psi), np.sin(heading + math.pi / 2 - psi)], 1)
    at = shapely.points(p + tool.radius * edge)
    h = chip * ahead * np.sin(psi)
    ft, fr, fa = law.tc * h + law.te, law.rc * h + law.re, law.ac * h + law.ae
    each = np.stack([-ft * np.cos(psi) - fr * np.sin(psi), ft * np.sin(psi) - fr * np.cos(psi), fa], 1) * tool.teeth / TURN * math.pi / angles
    levels = sorted({low, high} | {z for m in stock.moves + [move.until(t)] for z in (m.a[2], m.b[2]) if low < z < high})
    for lo, hi in zip(levels, levels[1:]):
        n = max(1, round(heights * (hi - lo) / (high - low)))
        for z in lo + (hi - lo) * (np.arange(n) + 0.5) / n:
            plan = shapely.box(*stock.low[:2], *stock.high[:2]).intersection(shapely.Point(p).buffer(1.2 * tool.radius))
            swept = []
            for m, last in [(m, 1.0) for m in stock.moves] + [(move, t)]:
                s = np.linspace(0, last, 2 + int(abs(m.sweep * last) / 0.003) if m.centre is not None else 201 if m.rise else 2)
                s = s[m.z(s) <= z]
                # The end of it exactly, as the edge of the tool lies on it.
                if m.rise and len(s) and s[-1] < last:
                    s = np.append(s, np.clip((z - m.a[2]) / m.rise, 0, last))
                if m.rise < 0 and len(s): s = np.insert(s, 0, np.clip((z - m.a[2]) / m.rise, 0, last))
                if not len(s): continue
                line = shapely.LineString(m.at(s)) if len(s) > 1 and m.flat_length > 0 else shapely.Point(m.at(s[0]))
                # Of the move itself a hair less, so that the edge of the tool does not lie in what it sweeps.
                swept.append(line.buffer(m.tool.radius - (1e-4 if m is move else 0.0), quad_segs=200))
            plan = plan.difference(shapely.union_all(swept))
            shapely.prepare(plan)
            force += each[shapely.contains(plan, at)].sum(0) * (hi - lo) / n
    return force


def proofs():
    """Closed forms, the numbers of `right` that were worked out elsewhere, another way over polygons, and a fault that must show."""
    import random
    from check_engagement import generate
    law, tool, chip = Law(900, 12, 400, 10, -150, -2), Tool(5.0, 4), 0.075
    def near(a, b, tol=1e-3): assert np.allclose(a, b, atol=tol), (a, b)
    def box(y0=-20.0): return Stock((-30, y0, -20), (30, 20, 0))
    def x_pass(y, z): return Move(tool, (-50, y, z), (50, y, z))
    # A full slot, 2 mm deep.
    N, a = 4, 2.0
    c = Cut(box(), x_pass(0, -2), 0.5, law, chip)
    near(c.force, (-N*a/4*400*chip - N*a/math.pi*10, N*a/4*900*chip + N*a/math.pi*12, -N*a/math.pi*150*chip - N*a/2*2))
    near((c.entry, c.exit), (0, math.pi))
    # A shoulder 2.5 mm wide and 5 deep: the table of the guide, Al 7075-T6 (down milling is to the right).
    al = Law(767.01, 27.7, 168.8, 26.6, -222, -0.7)
    near(Cut(box(2.5), Move(tool, (50, 0, -5), (-50, 0, -5)), 0.5, al, chip).force, (90.31, 188.76, -28.83), 0.01)
    near(Cut(box(2.5), x_pass(0, -5), 0.5, al, chip).force[:2], (-199.74, 11.88), 0.01)
    # Passes over floors.
    for y, z, deep, right in ((-0.1, -2.4, -3, (-31.8, 46.4, -12.0)), (-0.1, -2.7, -3, (-19.7, 21.1, -6.6)), (-0.1, -2.6, -3, (-23.7, 29.5, -8.4)), (-4, -0.45, -0.9, (-39.2, 44.4, -11.6))):
        s = box()
        s.moves = [x_pass(y, z)]
        near(Cut(s, x_pass(0, deep), 0.44, law, chip).force, right, 0.06)
        assert np.linalg.norm(Cut(s, x_pass(0, deep), 0.44, law, chip, slices=1.0).force - right) > 1.0
    # A ramp through the full is a slot as deep as it is there, its chip that of the plan; a ball in the full, level, by steps of depth.
    m = Move(tool, (-20, 0, 0), (20, 0, -4))
    near(Cut(box(), m, 0.5, law, chip, steps=1).force, Cut(box(), x_pass(0, -2), 0.5, law, chip * 40 / math.hypot(40, 4)).force)
    ball, force = Tool(3.0, 2, 3.0), np.zeros(3)
    for k in (np.arange(4000) + 0.5) / 4000 * math.pi / 3:      # to the depth of 1.5 mm
        for psi in (np.arange(64) + 0.5) / 64 * math.pi:
            h, out = 0.05 * math.sin(psi) * math.sin(k), np.array([math.sin(psi), math.cos(psi), 0.0])
            n, up = np.array([*(math.sin(k) * out[:2]), -math.cos(k)]), np.array([*(math.cos(k) * out[:2]), math.sin(k)])
            t = np.array([math.cos(psi), -math.sin(psi), 0.0])
            force += (-(law.tc*h + law.te) * t - (law.rc*h + law.re) * n + (law.ac*h + law.ae) * up) * 3.0 * math.pi / 3 / 4000 * 2 / TURN * math.pi / 64
    near(Cut(box(), Move(ball, (-20, 0, -1.5), (20, 0, -1.5)), 0.5, law, 0.05).force, force, 0.02)
    # The other way, of random programs; and how many of them the fault would change.
    rng, seen, fault = random.Random(5), 0, 0
    worst = 0.0
    for seed in range(900, 904):
        program, _, stock, law, _ = generate(seed, "flat")
        for m in program.moves:
            if m.kind == "judged":
                t = rng.uniform(0.1, 0.9)
                cut = Cut(stock, m, t, law, 0.05)
                here = Stock(stock.low, stock.high)
                here.moves = [o for o in stock.moves if near_to(o, m.at(t), m.tool.radius)]
                tol = max(0.5, 0.005 * cut.sizes)
                off = float(np.linalg.norm(by_polygons(here, m, t, law, 0.05) - cut.force)) / tol
                assert off < 0.5, (seed, m.scene, t, off)
                worst, seen = max(worst, off), seen + 1
                fault += np.linalg.norm(Cut(stock, m, t, law, 0.05, slices=1.0).force - cut.force) > tol
            stock.moves.append(m)
    assert fault > seen / 4, (fault, seen)
    print(f"closed forms; {seen} cuts by polygons, at most {worst:.2f} of what is allowed apart; one arc at mid-height is wrong in {fault} of them")


if __name__ == "__main__":
    proofs()
