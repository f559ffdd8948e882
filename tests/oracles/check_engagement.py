#!/usr/bin/env python3
"""python3 check_engagement.py KINETOSTAT --from SEED --count N [--shape flat|ball|bull_nose] [--points K] [--keep FOLDER]

N random programs of six scenes each on a box of stock: passes at any angle and height, offset walls, islands, thin walls, ramps, helices, and a judged move
over what they leave. `compensate` runs once a program; at points of every move the force of its points table is held against engagement.py: within
0.5 % of the sum of the sizes of the forces of all heights or 0.5 N, whichever is more (balls and corners, at allowances from 0.02 mm on: 5 % or 0.02 N).

A row says what the tool meets on the way to its point: a force between those of the places of that step counts as right. Where an edge is within 1e-4 mm, so
does one between those of places so far apart ("at a hair"). Depth, entry and exit of flat ends, as extremes over all heights, are held within 0.02 mm and 1.5 degrees (6 where something slopes, as regions of height have one arc there) of those places. Forces are compared in the frame of the feed, whose direction is judged apart, or in that of the workpiece.
"""
import argparse, collections, csv, math, os, random, shutil, subprocess, sys, tempfile, time
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import numpy as np
import engagement
from engagement import Cut, Law, Move, Stock, Tool

MACHINE = '''schema = 1
name = "xyz"
title = "Slides on springs"
gravity_m_per_s2 = [0.0, 0.0, 0.0]
[home]
position_mm = [0.0, 0.0, 0.0]
[platform]
controls = ["x", "y", "z"]
tool_tip_mm = [0.0, 0.0, -100.0]
tool_axis = [0.0, 0.0, -1.0]
[workspace]
min_mm = [-2000.0, -2000.0, -2000.0]
max_mm = [2000.0, 2000.0, 2000.0]
[[point]]
name = "C"
position_mm = [0.0, 0.0, 0.0]
[[chain]]
name = "g"
elements = [
 { prismatic_drive = { name = "X", axis = "x", stiffness_N_per_mm = 500000.0, travel_mm = [-2000.0, 2000.0] } },
 { prismatic_drive = { name = "Y", axis = "y", stiffness_N_per_mm = 400000.0, travel_mm = [-2000.0, 2000.0] } },
 { prismatic_drive = { name = "Z", axis = "z", stiffness_N_per_mm = 800000.0, travel_mm = [-2000.0, 2000.0] } },
]
[[mount]]
name = "m"
chain = "g"
'''
STEP = 0.25         # mm, of the rows
HAIR = 1e-4         # mm
SPACING = 80.0      # mm between scenes
SCENES = 6
KEYS = ("tangential_cutting", "tangential_edge", "radial_cutting", "radial_edge", "axial_cutting", "axial_edge")


class Program:
    """The text of a program and its moves with their lines."""
    def __init__(self, tool, speed, top):
        self.tool, self.speed, self.top, self.lines, self.moves = tool, speed, top, [], []
        self.put("G21 G90 G17"); self.put("T1 M6"); self.put(f"S{speed} M3"); self.put("G0 Z30")

    def put(self, text): self.lines.append(text)

    def down(self, p):
        self.put(f"G0 X{p[0]:.6f} Y{p[1]:.6f}")
        self.put(f"G0 Z{self.top + 1:.6f}")
        self.put(f"G1 Z{p[2]:.6f} F300")
        self.add(Move(self.tool, (p[0], p[1], self.top + 1), p), "plunge")
        self.last = p

    def up(self): self.put("G0 Z30")

    def add(self, move, kind, feed=0.0):
        move.line, move.kind, move.feed = len(self.lines), kind, feed
        self.moves.append(move)

    def straight(self, q, kind, feed):
        q = rounded(q)
        self.put(f"G1 X{q[0]:.6f} Y{q[1]:.6f} Z{q[2]:.6f} F{feed}")
        self.add(Move(self.tool, self.last, q), kind, feed)
        self.last = q

    def arc(self, centre, sweep, z, kind, feed):
        """About `centre` from where the tool is; a whole turn at most."""
        c = rounded(centre)
        a = math.atan2(self.last[1] - c[1], self.last[0] - c[0])
        rho = math.hypot(self.last[1] - c[1], self.last[0] - c[0])
        whole = abs(sweep) > TURN - 1e-3
        q = rounded((c[0] + rho * math.cos(a + sweep), c[1] + rho * math.sin(a + sweep), z))
        if whole: q = (self.last[0], self.last[1], q[2]); sweep = math.copysign(TURN, sweep)
        self.put(f"G{3 if sweep > 0 else 2} X{q[0]:.6f} Y{q[1]:.6f} Z{q[2]:.6f} I{c[0] - self.last[0]:.6f} J{c[1] - self.last[1]:.6f} F{feed}")
        self.add(Move(self.tool, self.last, q, c, sweep), kind, feed)
        self.last = q


TURN = 2 * math.pi
def rounded(p): return tuple(round(x, 6) for x in p)


def scene(rng, program, cx, r, feed, shape):
    """Passes about (cx, 0) that leave something, and moves to be judged; says which kind it is."""
    u = rng.uniform
    through = lambda angle, off, half=28.0: ((cx - off * math.sin(angle) - half * math.cos(angle), off * math.cos(angle) - half * math.sin(angle)),
                                             (cx - off * math.sin(angle) + half * math.cos(angle), off * math.cos(angle) + half * math.sin(angle)))
    def slot(angle, off, z0, z1=None, kind="setup", half=28.0, down=True):
        a, b = through(angle, off, half)
        if down: program.down(rounded((*a, z0)))
        program.straight((*b, z0 if z1 is None else z1), kind, feed)
        program.up()
    def ring(x, y, rho, z0, z1, sweep, start, kind="setup"):
        c = rounded((x, y))
        program.down(rounded((c[0] + rho * math.cos(start), c[1] + rho * math.sin(start), z0)))
        program.arc(c, sweep, z1, kind, feed)
    kind = rng.choice(("steps", "steps", "walls", "walls", "finish", "island", "thin", "ramp", "ramp", "helix", "helix", "arc", "any"))
    if shape != "flat": kind = rng.choice(("steps", "walls", "thin", "thin", "finish", "arc") + (("slope",) * 5 if shape == "ball" else ()))
    angle, sign = u(0, TURN), rng.choice((-1, 1))
    depth = -10**u(-0.5, 0.75)
    if kind == "steps":
        for _ in range(rng.randint(1, 4)): slot(u(0, TURN), u(-6, 6), depth * u(0.1, 0.95))
        slot(angle, u(-2, 2), depth, kind="judged")
    elif kind == "walls":
        for _ in range(rng.randint(1, 3)): slot(angle, sign * 10**u(-1.5, 0.9), depth * u(0.05, 0.98))
        slot(angle, 0.0, depth, kind="judged")
    elif kind == "finish":      # a wall and a floor of a little, in one pass
        wall, floor = 10**u(-1.5, -0.2), 10**u(-1.5, -0.2)
        slot(angle, sign * wall, depth + floor)
        if rng.random() < 0.5: slot(u(0, TURN), u(-4, 4), depth + floor * u(0.1, 0.9))
        slot(angle, 0.0, depth, kind="judged")
    elif kind == "island":
        if rng.random() < 0.5:
            rho = r + 10**u(-0.3, 0.6)
            ring(cx, 0, rho, depth * u(0.4, 1), depth * u(0.4, 1), sign * TURN, u(0, TURN)); program.up()
        else:
            for off in (-1, 1): slot(angle, off * (r + u(0.3, 3)), depth * u(0.4, 1))
            for off in (-1, 1): slot(angle + u(0.8, 2.2), off * (r + u(0.3, 3)), depth * u(0.4, 1))
        slot(u(0, TURN), u(-r, r), depth, kind="judged")
    elif kind == "thin":
        width = 10**u(-0.7, 0.5)
        for off in (-1, 1): slot(angle + u(-0.1, 0.1), off * (r + width / 2), depth * u(0.3, 1))
        slot(angle + rng.choice((0, u(0.3, 1.5))), u(-0.9, 0.9) * r, depth, kind="judged")
    elif kind == "ramp":
        for _ in range(rng.randint(0, 3)): slot(u(0, TURN), u(-6, 6), depth * u(0.1, 0.9), depth * u(0.1, 0.9) if rng.random() < 0.4 else None)
        up = rng.random() < 0.3
        slot(angle, u(-2, 2), 0.5 if not up else depth, depth if not up else 0.5, kind="judged")
    elif kind == "helix":
        for _ in range(rng.randint(0, 2)): slot(u(0, TURN), u(-8, 8), depth * u(0.1, 0.9))
        rho, pitch = u(2.0, 12.0), 10**u(-0.7, 0.2)
        x, y = cx + u(-3, 3), u(-3, 3)
        start, z = u(0, TURN), 0.3
        sweep = sign * (TURN if rng.random() < 0.7 else u(1.0, 5.0))
        program.down(rounded((x + rho * math.cos(start), y + rho * math.sin(start), z)))
        for _ in range(rng.randint(1, 3)):
            z -= pitch * abs(sweep) / TURN
            program.arc((x, y), sweep, z, "judged", feed)
            if abs(sweep) < TURN: break
        if abs(sweep) == TURN and rng.random() < 0.6: program.arc((x, y), sweep, z, "judged", feed)
        program.up()
    elif kind == "arc":
        for _ in range(rng.randint(1, 3)): slot(u(0, TURN), u(-6, 6), depth * u(0.1, 0.95))
        if rng.random() < 0.5:
            z = depth * u(0.3, 0.9)
            ring(cx, 0, u(6, 14), z, depth * u(0.3, 0.9) if shape == "flat" else z, sign * u(2, TURN), u(0, TURN)); program.up()
        ring(cx + u(-3, 3), u(-3, 3), u(3, 14), depth, depth, sign * u(1.5, TURN), u(0, TURN), kind="judged"); program.up()
    elif kind == "slope":       # a ball along a slope, over a pass of the allowance before
        allowance, fall = 10**u(-1.7, -0.3), u(-8, 8)
        deep = -9.0
        for off in (-0.4, 0.0, 0.4): slot(angle, off, deep + fall / 2 + allowance, deep - fall / 2 + allowance)
        if rng.random() < 0.5: slot(angle, sign * u(0.1, 0.5), deep + fall / 2, deep - fall / 2)
        slot(angle, 0.0, deep + fall / 2, deep - fall / 2, kind="judged")
    else:
        for _ in range(rng.randint(2, 5)):
            if rng.random() < 0.6: slot(u(0, TURN), u(-9, 9), depth * u(0.1, 1.3), depth * u(0.1, 1.3) if rng.random() < 0.5 else None)
            else: ring(cx + u(-6, 6), u(-6, 6), u(2, 12), depth * u(0.1, 1.2), depth * u(0.1, 1.2), sign * u(1, TURN), u(0, TURN)); program.up()
        slot(angle, u(-3, 3), depth * u(0.3, 1), depth, kind="judged")
    return kind


def generate(seed, shape):
    rng = random.Random(seed)
    radius = rng.choice((3.0, 4.0, 5.0, 6.0))
    corner = {"flat": 0.0, "ball": radius, "bull_nose": rng.choice((0.5, 1.0, 2.0))}[shape]
    tool = Tool(radius, rng.randint(2, 5), corner)
    speed = rng.choice((4000, 8000, 10000))
    feed = round(rng.uniform(0.02, 0.12) * speed * tool.teeth)
    k = (rng.uniform(500, 2500), rng.uniform(0, 30), rng.uniform(100, 900), rng.uniform(0, 25), rng.uniform(-400, 0), rng.uniform(-4, 0))
    k = tuple(round(x, 3) for x in k)
    program = Program(tool, speed, 0.0)
    low, high = (-30.0, -18.0, -25.0), (SPACING * (SCENES - 1) + 30.0, 18.0, 0.0)
    kinds = []
    for i in range(SCENES):
        first = len(program.moves)
        kinds.append(scene(rng, program, SPACING * i, radius, feed, shape))
        for m in program.moves[first:]: m.scene = kinds[-1]
    program.put("M30")
    names = "tangential_cutting_N_per_mm2 tangential_edge_N_per_mm radial_cutting_N_per_mm2 radial_edge_N_per_mm axial_cutting_N_per_mm2 axial_edge_N_per_mm".split()
    process = f'''schema = 1
[placement]
origin_mm = [0.0, 0.0, -100.0]
yaw_deg = 0.0
[force.end_milling]
coefficients = {{ {", ".join(f"{n} = {v}" for n, v in zip(names, k))} }}
[stock]
box = {{ min_mm = {list(low)}, max_mm = {list(high)} }}
[tools.1]
diameter_mm = {2 * radius}
teeth = {tool.teeth}
shape = "{shape}"
{f"corner_radius_mm = {corner}" if shape == "bull_nose" else ""}
[compensate]
corner_mm = 0.0
[sampling]
max_segment_mm = {STEP}
'''
    return program, process, Stock(low, high), Law(*k), rng


def removed(stock, moves, facets=192):
    """Volume that a flat end takes, by solids of manifold3d less one another: prisms over what is level, hulls of neighbouring discs where it slopes."""
    import manifold3d as m3
    top = stock.high[2] + 2
    def disc(m, t): return m3.Manifold.cylinder(top - m.z(t), m.tool.radius, circular_segments=facets).translate((*m.at(t), m.z(t)))
    solids = []
    for m in moves:
        if not m.flat_length: solids.append(disc(m, 0 if m.a[2] < m.b[2] else 1)); continue
        n = 1 if m.centre is None else max(8, math.ceil(abs(m.sweep) / 0.04))
        ends = [disc(m, t) for t in np.linspace(0, 1, n + 1)]
        solids += [m3.Manifold.batch_hull(pair) for pair in zip(ends, ends[1:])]
    box = m3.Manifold.cube(tuple(stock.high - stock.low)).translate(tuple(stock.low))
    return box.volume() - (box - m3.Manifold.batch_boolean(solids, m3.OpType.Add)).volume()


def number(text): return float(text) if text else math.nan


class Row:
    def __init__(self, r):
        self.p = tuple(float(r[k]) for k in ("x_mm", "y_mm", "z_mm"))
        self.force = np.array([float(r[f"cutting_force_{k}_N"]) for k in "xyz"])
        self.phi, self.raw = number(r["phi_deg"]), r


def tolerance(sizes, share=0.005): return max(0.5 if share == 0.005 else 0.02, share * sizes)


def judge(stock, move, before, row, law, speed, share):
    """Verdict, what is said of it, deviation as a share of the tolerance."""
    t1, t0 = move.share(row.p), move.share(before.p)
    hair = HAIR / move.length
    gap = math.dist((*move.at(t1), move.z(t1)), row.p)
    if gap > 2e-3: return "wrong", f"the point is {gap:.4f} mm off the move", math.inf
    if t1 <= t0: return "skipped: no step", "", 0.0
    chip = move.feed / (speed * move.tool.teeth)
    if math.isfinite(row.phi):
        heading = math.radians(-90 - row.phi)       # phi counts about the axis of the tool, which points down
        at = sorted((move.heading(t0), move.heading(t1)))
        off = (heading - at[0]) % TURN
        turned = 0.0 if off <= at[1] - at[0] else min(off - (at[1] - at[0]), TURN - off)
        if turned > 2e-3: return "wrong", f"phi {row.phi} is {math.degrees(turned):.3f} degrees beside the feed", math.inf
    else: heading = move.heading((t0 + t1) / 2)
    mine = turned_by(row.force, -heading)
    def beside(places):
        """How far the force of the row is from those of these places and between: in the frame of the feed, or in that of the workpiece."""
        shares, forces = places
        in_part = np.array([turned_by(f, move.heading(t)) for t, f in zip(shares, forces)])
        return min(from_line(mine, forces), from_line(row.force, in_part))
    def met(shares, steps=96, shift=None):
        m = moved(move, *shift, move.heading(t1)) if shift else move
        cuts = [Cut(stock, m, t, law, chip, steps) for t in shares]
        return (shares, np.array([c.force for c in cuts])), max(c.sizes for c in cuts)
    shares = [t0 + min(hair, (t1 - t0) / 4), (t0 + t1) / 2, max(t1 - hair, (t0 + t1) / 2)]
    places, sizes = met(shares)
    tol, away, forces = tolerance(sizes, share), beside(places), places[1]
    said = f"has {show(mine)}, right {show(forces[2])} N (begin {show(forces[0])}, middle {show(forces[1])}), off by {away:.2f} N of {sizes:.1f}, allowed {tol:.2f}"
    changing = float(np.linalg.norm(np.ptp(forces, axis=0))) > 2 * tol
    if away <= tol: return "agree, changing in the step" if changing else "agree", said, away / tol
    # Edges may come and go within the step, and lie within a hair.
    fine, more = met([*np.linspace(t0, t1, 17)[1:-1], shares[2]], 400)
    if beside(fine) <= tolerance(max(sizes, more), share): return "agree, changing in the step", said, 1.0
    around = [met(shares, shift=(a, u)) for a in (-HAIR, 0, HAIR) for u in (-HAIR, 0, HAIR)]
    wide = np.concatenate([p[1] for p, _ in around])
    if np.linalg.norm(np.maximum(0, np.maximum(wide.min(0) - mine, mine - wide.max(0)))) <= tolerance(max(s for _, s in around), share): return "agree, at a hair", said, 1.0
    return "wrong", said, away / tol


def judge_extremes(stock, move, before, row, law, speed):
    """What is wrong with depth, entry and exit of a row of a flat end; nothing if they lie between those of the places of its step, or of places a hair aside."""
    t1, t0 = move.share(row.p), move.share(before.p)
    own = [number(row.raw[f"engagement_{k}"]) for k in ("depth_mm", "entry_deg", "exit_deg")]
    if t1 <= t0 or not math.isfinite(own[1]): return ""
    chip, hair = move.feed / (speed * move.tool.teeth), HAIR / move.length
    shares = np.linspace(t0 + min(hair, (t1 - t0) / 4), max(t1 - hair, (t0 + t1) / 2), 9)
    all_of = []
    for a, u in ((0, 0), (0, HAIR), (0, -HAIR), (HAIR, 0), (-HAIR, 0)):
        shifted = moved(move, a, u, move.heading(t1))
        cuts = [Cut(stock, shifted, t, law, chip) for t in shares]
        all_of += [(c.depth, math.degrees(c.entry), math.degrees(c.exit)) for c in cuts if math.isfinite(c.entry)]
        if not all_of: continue
        low, high = np.min(all_of, 0), np.max(all_of, 0)
        angle = 6.0 if move.rise or any(not m.level for m in stock.moves) else 1.5
        slack = np.array([0.02, angle, angle])
        off = np.maximum(low - slack - own, own - high - slack)
        if (off <= 0).all(): return ""
    if not all_of: return f"has depth, entry, exit {show(own)}, but meets nothing"
    return f"has depth, entry, exit {show(own)}, right {show(low)} to {show(high)}"


def turned_by(v, angle):
    """From (feed, left, up) into axes of the workpiece, where the feed has this angle; of its negative, back."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]])


def from_line(p, line):
    best = float(np.linalg.norm(line[0] - p))
    for a, b in zip(line, line[1:]):
        d = b - a
        t = np.clip((p - a) @ d / (d @ d), 0, 1) if d @ d else 0.0
        best = min(best, float(np.linalg.norm(a + t * d - p)))
    return best


def moved(m, across, up, heading):
    x, y = -math.sin(heading) * across, math.cos(heading) * across
    return Move(m.tool, m.a + (x, y, up), m.b + (x, y, up), None if m.centre is None else m.centre + (x, y), m.sweep)


def show(v): return "(" + ", ".join(f"{x:.2f}" for x in v) + ")"


def run(binary, folder, program, process):
    os.makedirs(folder, exist_ok=True)
    for name, text in (("p.nc", "\n".join(program.lines) + "\n"), ("p.toml", process), ("xyz.toml", MACHINE)):
        with open(os.path.join(folder, name), "w") as f: f.write(text)
    p = subprocess.run([binary, "compensate", "p.nc", "--machine", "xyz.toml", "--process", "p.toml", "--out", "out.nc", "--points", "all", "--force",
                        "--method", "linear", "--progress", "none"], cwd=folder, capture_output=True, text=True, errors="replace")
    table = os.path.join(folder, "out.nc.points.csv")
    if p.returncode not in (0, 1) or not os.path.exists(table): return None, (p.stderr or p.stdout).strip()
    rows = collections.defaultdict(list)
    last = None
    with open(table) as f:
        for r in csv.DictReader(f):
            r = Row(r)
            r.before, last = last, r
            rows[int(r.raw["line"])].append(r)
    return rows, ""


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("kinetostat")
    ap.add_argument("--from", dest="first", type=int, default=1)
    ap.add_argument("--count", type=int, default=10)
    ap.add_argument("--shape", choices=("flat", "ball", "bull_nose"), default="flat")
    ap.add_argument("--points", type=int, default=4, help="of a judged move; of others one")
    ap.add_argument("--volume", action="store_true", help="also the volume removed; needs manifold3d")
    ap.add_argument("--keep", help="folder for the programs that are wrong")
    ap.add_argument("--verbose", action="store_true")
    a = ap.parse_args()
    binary = os.path.abspath(a.kinetostat)
    count, by_kind, worst, wrong_moves, judged = collections.Counter(), collections.Counter(), [], set(), 0
    root = tempfile.mkdtemp(prefix="engagement_")
    began, inside = time.process_time(), 0.0
    for seed in range(a.first, a.first + a.count):
        program, process, stock, law, rng = generate(seed, a.shape)
        folder = os.path.join(root, f"s{seed}")
        rows, told = run(binary, folder, program, process)
        if rows is None:
            count["skipped: refused"] += 1
            print(f"seed {seed}: refused: {told.splitlines()[-1] if told else '?'}")
            worst.append((math.inf, f"seed {seed} refused"))
            continue
        bad = []
        for m in program.moves:
            if m.kind != "plunge":
                mine = rows.get(m.line, [])
                if not mine:
                    bad.append(f"line {m.line} has no points"); count["wrong"] += 1
                else:
                    some = mine[2:-1] or mine[-1:]
                    picked = rng.sample(some, min(len(some), a.points if m.kind == "judged" else 1))
                    if m.kind == "judged": judged += 1
                    for row in picked:
                        verdict, said, off = judge(stock, m, row.before, row, law, program.speed, share_of(a.shape, m))
                        count[verdict] += 1
                        if verdict.startswith("agree") and a.shape == "flat":
                            extremes = judge_extremes(stock, m, row.before, row, law, program.speed)
                            count["extremes"] += 1
                            if extremes: verdict, said, off = "wrong", extremes, 2.0
                        what = f"seed {seed} line {m.line} {m.scene} point {row.raw['point']} at {show(row.p)}: {said}"
                        if verdict == "wrong":
                            bad.append(what); wrong_moves.add((seed, m.line)); by_kind[m.scene, m.kind] += 1
                        worst.append((off, what))
                        if a.verbose: print(verdict, what)
            stock.moves.append(m)
        if a.volume and a.shape == "flat" and "engagement_removed_mm2" in next(iter(rows.values()))[0].raw:
            own = removed(stock, stock.moves)
            has = sum(float(r.raw["engagement_removed_mm2"]) * (float(r.raw["arc_length_mm"]) - float(r.before.raw["arc_length_mm"])) for mine in rows.values() for r in mine if r.before)
            count["volumes"] += 1
            print(f"seed {seed}: removed {has:.1f} mm3 by the table, {own:.1f} by solids, {100 * (has / own - 1):+.2f} %")
            if abs(has / own - 1) > 0.002: bad.append(f"seed {seed}: volume {has:.1f}, right {own:.1f} mm3"); count["volumes wrong"] += 1
        if bad:
            print(*bad[:6], sep="\n")
            if a.keep:
                os.makedirs(a.keep, exist_ok=True)
                to = os.path.join(a.keep, f"{a.shape}_{seed}")
                shutil.rmtree(to, ignore_errors=True); os.makedirs(to)
                for n in ("p.nc", "p.toml", "xyz.toml"): shutil.copy(os.path.join(folder, n), to)
                open(os.path.join(to, "wrong.txt"), "w").write("\n".join(bad) + "\n")
        shutil.rmtree(folder)
    os.rmdir(root)
    worst.sort(key=lambda w: -w[0])
    points = sum(count.values()) - count["extremes"]
    print(f"{a.count} programs, {judged} judged moves, {points} points: " + ", ".join(f"{v} {k}" for k, v in sorted(count.items())))
    if by_kind: print(f"wrong in {len(wrong_moves)} moves:", ", ".join(f"{k[0]} ({k[1]}) {v}" for k, v in by_kind.most_common()))
    print("worst:", *(f"  {o:.2f} of what is allowed: {w}" for o, w in worst[:3]), sep="\n")
    print(f"{time.process_time() - began:.0f} s of processor time for the judge")
    sys.exit(1 if count["wrong"] or count["volumes wrong"] or count["skipped: refused"] else 0)


def share_of(shape, move): return 0.005 if shape == "flat" else 0.05


if __name__ == "__main__":
    main()
