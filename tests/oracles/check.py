#!/usr/bin/env python3
"""python3 check.py KINETOSTAT --dialect NAME --from SEED --count N [--keep FOLDER] [--program FILE ...] [--no-expand]

For each program of NAME.generate(seed): (1) without a force the written files have the bytes of the program's; (2) with a force
that is constant in the frame of the program, on equal slides, the interpreter NAME.run finds in the written files every end of a
cutting move, in order, at its place + D, every end of a rapid move at its place, and arcs whose radii agree at both ends.

A dialect's module may set: DIALECT (name in [gcode]), EXT (of the main file, if it is not in its name), DIGITS (of a number), and options of a program
may hold "gcode": keys of [gcode], "toml": text added to both process files, "machine": text of the machine file, "d": the
constant correction (a 3-vector, if it is not D).
"""
import argparse, collections, importlib, json, math, os, re, shutil, subprocess, sys, tempfile
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from move import Move, Refused

# Slides of 1000 N/mm each, a tool whose compliance couples: 100 N along its axis move the tip by (0.05, 0.03, 0.2) mm.
D = (-0.05, -0.03, -0.2)
MACHINE = '''schema = 1
name = "equal"
title = "Cartesian, equal slides"
[platform]
tool_tip_mm = [0.0, 0.0, 0.0]
tool_axis = [0.0, 0.0, -1.0]
controls = ["x", "y", "z"]
[home]
position_mm = [0.0, 0.0, 0.0]
[workspace]
min_mm = [-100000.0, -100000.0, -100000.0]
max_mm = [100000.0, 100000.0, 100000.0]
[[chain]]
name = "mill"
elements = [
  { prismatic_drive = { name = "X", axis = "x", stiffness_N_per_mm = 1000.0, home_mm = 0.0 } },
  { prismatic_drive = { name = "Y", axis = "y", stiffness_N_per_mm = 1000.0, home_mm = 0.0 } },
  { prismatic_drive = { name = "Z", axis = "z", stiffness_N_per_mm = 1000.0, home_mm = 0.0 } },
]
[[mount]]
name = "mill"
chain = "mill"
'''
PROCESS = "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 0.0]\n"
FORCE = '''[tool]
compliance_mm_rad_N = [
 [0.001, 0.0, -0.0005, 0.0, 0.0, 0.0], [0.0, 0.001, 0.0003, 0.0, 0.0, 0.0], [-0.0005, 0.0003, 0.001, 0.0, 0.0, 0.0],
 [0.0, 0.0, 0.0, 1e-9, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1e-9, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 1e-9]]
[force.path_frame]
radial_force_N = 0.0
tangential_force_N = 0.0
axial_force_N = -100.0
[compensate]
corner_mm = 0.0
'''
TOL = 6e-6          # mm: 1e-6 and the rounding of six decimals, also of angles and of computed ends
NEAR = 0.012        # mm: what may lie between block ends: write tolerance, chords of arcs
RAMP = 2.2          # mm behind a rapid move within which the correction comes up


def vadd(a, b, s=1.0): return tuple(x + s*y for x, y in zip(a, b))
def vlen(a): return math.sqrt(sum(x*x for x in a))
def digits_lose(p, digits):
    """mm by which p in numbers of so many digits is farther off than in six decimals."""
    return vlen([max(0.0, 0.5 * 10.0**(len(str(int(abs(x)))) - digits) - 0.5e-6) for x in p])
def gap(a, b): return vlen(vadd(a, b, -1.0))


def points(a, m, n):
    """n points along the move from a, the last one its end."""
    if m.kind == "arc" and m.turn:
        w = vlen(m.turn)
        k = tuple(x/w for x in m.turn)
        p = vadd(a, m.centre, -1.0)
        h = sum(x*y for x, y in zip(p, k))
        r = vadd(p, k, -h)
        q = (k[1]*r[2]-k[2]*r[1], k[2]*r[0]-k[0]*r[2], k[0]*r[1]-k[1]*r[0])
        e = vadd(m.end, a, -1.0)
        rise = sum(x*y for x, y in zip(e, k))
        out = []
        for i in range(1, n + 1):
            t = w*i/n
            out.append(tuple(m.centre[j] + r[j]*math.cos(t) + q[j]*math.sin(t) + k[j]*(h + rise*i/n) for j in range(3)))
        out[-1] = m.end
        return out
    return [tuple(a[j] + (m.end[j]-a[j])*i/n for j in range(3)) for i in range(1, n + 1)]


def mismatch(a, m):
    """Difference of the radii of an arc at its ends."""
    if m.kind != "arc" or not m.turn: return 0.0
    w = vlen(m.turn)
    k = tuple(x/w for x in m.turn)
    def rad(p):
        p = vadd(p, m.centre, -1.0)
        return vlen(vadd(p, k, -sum(x*y for x, y in zip(p, k))))
    return abs(rad(a) - rad(m.end))


def to_line(p, chain):
    best = 1e9
    for a, b in zip(chain, chain[1:]):
        d = vadd(b, a, -1.0)
        q = sum(x*x for x in d)
        t = max(0.0, min(1.0, sum(x*y for x, y in zip(vadd(p, a, -1.0), d)) / q)) if q else 0.0
        best = min(best, gap(p, vadd(a, d, t)))
    return best


def off(p, a, m):
    """Distance of p from the move from a (helices: nearly)."""
    if m.kind != "arc" or not m.turn: return to_line(p, [a, m.end])
    w = vlen(m.turn)
    k = tuple(x/w for x in m.turn)
    def split(q):
        q = vadd(q, m.centre, -1.0)
        h = sum(x*y for x, y in zip(q, k))
        return h, vadd(q, k, -h)
    h0, r0 = split(a)
    h1, r1 = split(m.end)
    h, r = split(p)
    R0, R1, R = vlen(r0), vlen(r1), vlen(r)
    if R < 1e-9 or R0 < 1e-9: return to_line(p, [a, m.end])
    s = (k[1]*r0[2]-k[2]*r0[1], k[2]*r0[0]-k[0]*r0[2], k[0]*r0[1]-k[1]*r0[0])
    t = math.atan2(sum(x*y for x, y in zip(r, s)), sum(x*y for x, y in zip(r, r0))) % (2*math.pi)
    best = min(gap(p, a), gap(p, m.end))
    while t <= w:
        best = min(best, math.hypot(R - R0 - (R1-R0)*t/w, h - h0 - (h1-h0)*t/w))
        t += 2*math.pi
    return best


def still(moves):
    """Without moves that go nowhere."""
    out, at = [], None
    for m in moves:
        if m.kind != "arc" and at is not None and gap(m.end, at) < 1e-9 and m.axis_or_rotation is None: continue
        out.append(m); at = m.end
    return out


CUT = ("line", "arc", "spline")


def compare(orig, new, d):
    """None, or what is wrong."""
    orig = still(orig)
    at_o, at_n, j = None, None, 0
    prev_rapid = True
    slack, last = 0.0, None
    for m in orig:                       # posts round ends and centres
        if last: slack = max(slack, mismatch(last, m))
        last = m.end
    for i, m in enumerate(orig):
        cut = m.kind in CUT
        if getattr(m, "loose", False):   # the way to a hole and back in a cycle goes along with the hole, and may be none
            if j < len(new) and getattr(new[j], "loose", new[j].kind not in CUT) and gap(new[j].end, m.end) <= vlen(d) + TOL: at_n = new[j].end; j += 1
            at_o, prev_rapid = m.end, True
            continue
        want = vadd(m.end, d) if cut else m.end
        path, found, best = [], False, None
        while j < len(new):
            n = new[j]
            e = gap(n.end, want)
            if (n.kind in CUT) == cut and (best is None or e < best[0]): best = (e, n)
            if at_n and mismatch(at_n, n) > slack + 4*TOL:
                return f"radii of the arc in {n.file}:{n.line} differ by {mismatch(at_n, n):.6f} mm"
            if at_n: path.append((at_n, n))
            ok = (n.kind in CUT) == cut and e <= TOL + m.known
            # a further rapid move has no business there, unless it goes nowhere, or back to where the tool belongs
            if not ok and n.kind not in CUT and not getattr(n, "loose", False) and at_n and gap(n.end, at_n) > 2e-6 and not (at_o and gap(n.end, at_o) < TOL):
                    return (f"{m.file}:{m.line} {m.kind} to {fmt(m.end)}, expected at {fmt(want)}; written {n.file}:{n.line} "
                            f"{n.kind} to {fmt(n.end)}, off by {e:.6f} mm {fmt(vadd(n.end, want, -1.0))}")
            at_n = n.end
            j += 1
            if ok: found = True; break
        if not found:
            b = f"nearest {best[1].file}:{best[1].line} off by {best[0]:.6f} mm {fmt(vadd(best[1].end, want, -1.0))}" if best else "no move of that kind left"
            return f"{m.file}:{m.line} {m.kind} to {fmt(m.end)}, expected at {fmt(want)}: {b}"
        if cut and at_o is not None:
            s, last = 0.0, at_o
            for p in points(at_o, m, 8):
                s += gap(p, last); last = p
                if prev_rapid and s < RAMP: continue
                e = min(off(vadd(p, d), x, y) for x, y in path) if path else 0.0
                if e > NEAR: return f"{m.file}:{m.line} {m.kind} to {fmt(m.end)}: written path is {e:.4f} mm off between its ends"
            if not prev_rapid:          # and the other way round: what is written lies on the path
                for p in (q for x, y in path for q in points(x, y, 2 if y.kind == "line" else 12)):
                    e = off(vadd(p, d, -1.0), at_o, m)
                    if e > NEAR: return f"{m.file}:{m.line} {m.kind} to {fmt(m.end)}: a written point {fmt(p)} is {e:.4f} mm off its path"
        at_o, prev_rapid = m.end, not cut
    for n in new[j:]:
        if getattr(n, "loose", False): continue
        if at_n and gap(n.end, at_n) > 2e-6: return f"written {n.file}:{n.line}: a {n.kind} more, to {fmt(n.end)}"
    return None


def fmt(p): return "(" + ", ".join(f"{x:.6f}".rstrip("0").rstrip(".") for x in p) + ")"


def toml(v):
    if isinstance(v, dict): return "{ " + ", ".join(f'"{k}" = {toml(x)}' for k, x in v.items()) + " }"
    if isinstance(v, (list, tuple)): return "[" + ", ".join(toml(x) for x in v) + "]"
    if isinstance(v, bool): return "true" if v else "false"
    return json.dumps(v)


def reason(err):
    """The first line of an error, without what is special to the program."""
    line = next((l for l in err.splitlines() if l.startswith("error")), (err.strip().splitlines() or ["?"])[0])
    where = re.search(r':(\d+):(\d+)?', line)
    short = re.sub(r'^error:\s*', '', line)
    short = re.sub(r'^[^\s:]+:\d+(:\d+)?:\s*', '', short)
    short = re.sub(r'`[^`]*`', '`…`', short)
    short = re.sub(r'-?\d+(\.\d+)?', '#', short)
    return short[:160], line


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("kinetostat")
    ap.add_argument("--dialect", required=True)
    ap.add_argument("--from", dest="first", type=int, default=1)
    ap.add_argument("--count", type=int, default=20)
    ap.add_argument("--keep")
    ap.add_argument("--program", nargs="*", help="these files instead of generated ones, the first is the main")
    ap.add_argument("--opt", default="{}", help="options of --program, JSON")
    ap.add_argument("--args", default="", help="further arguments of compensate")
    ap.add_argument("--verbose", action="store_true")
    a = ap.parse_args()
    mod = importlib.import_module(a.dialect)
    count, reasons, lines, wrong, other = collections.Counter(), collections.Counter(), {}, [], []
    root = tempfile.mkdtemp(prefix="orc_")
    seeds = [0] if a.program else range(a.first, a.first + a.count)
    for seed in seeds:
        if a.program:
            files = {os.path.basename(p): open(p, "rb").read() for p in a.program}
            name, opt = os.path.basename(a.program[0]), json.loads(a.opt)
        else: files, name, opt = mod.generate(seed)
        try: orig = mod.run(files, name, opt)
        except Refused as r:
            count["not followed by the interpreter"] += 1
            print(f"seed {seed}: the interpreter itself refuses {r}")
            continue
        if hasattr(mod, "DIGITS"):
            for m in orig: m.known += digits_lose(m.end, mod.DIGITS)
        w = os.path.join(root, f"s{seed}")
        os.makedirs(os.path.join(w, "in"))
        for k, v in files.items(): open(os.path.join(w, "in", k), "wb").write(v)
        open(os.path.join(w, "machine.toml"), "w").write(opt.get("machine", MACHINE))
        g = dict(opt.get("gcode", {}))
        g.setdefault("decimals_mm", 6)
        if getattr(mod, "DIALECT", None): g.setdefault("dialect", mod.DIALECT); g.setdefault("decimals_inch", 8)
        if g.get("dialect") == "": g.pop("dialect")
        gc = "[gcode]\n" + "".join(f"{k} = {toml(v)}\n" for k, v in g.items())
        for n, t in (("p0", PROCESS), ("p1", PROCESS + FORCE)):
            open(os.path.join(w, n + ".toml"), "w").write(t + gc + opt.get("toml", ""))
        verdict, told, res = None, "", []
        for n in ("p0", "p1"):
            os.makedirs(os.path.join(w, n))
            out = os.path.join(w, n, name)
            p = subprocess.run(["nice", "-n", "15", a.kinetostat, "compensate", os.path.join(w, "in", name), "--machine", os.path.join(w, "machine.toml"), "--process",
                                os.path.join(w, n + ".toml"), "--out", out, "--force", "--method", "direct", "--progress", "none"] + a.args.split(),
                               capture_output=True, text=True, errors="replace")
            if p.returncode not in (0, 1) or not os.path.exists(out):
                short, told = reason(p.stderr)
                if p.returncode == 3 or p.returncode < 0: short = "INTERNAL " + short
                verdict = "refused" if n == "p0" else "refused with force"
                reasons[(verdict, short)] += 1
                lines.setdefault((verdict, short), (seed, told))
                break
            got = {k: (open(os.path.join(w, n, k), "rb").read() if os.path.exists(os.path.join(w, n, k)) else None) for k in files}
            if n == "p0":
                used = {m.file for m in orig}
                bad = [k for k in files if (got[k] is None and k in used) or (got[k] is not None and got[k] != files[k])]
                if bad:
                    # not the bytes of the program: WRONG if the motion is another, counted apart if it is the same (written out)
                    told = "without a force not the same bytes: " + ", ".join(k + (" missing" if got[k] is None else "") for k in bad)
                    mains = got[name] is not None and got[name] != files[name]
                    try: t = compare(orig, mod.run({k: (v if v is not None else files[k]) for k, v in got.items()}, name, opt), (0.0, 0.0, 0.0))
                    except Refused as r: t = f"not followed: {r}"
                    if t or not mains:
                        verdict, told = "WRONG", told + (f", and another motion: {t}" if t else "")
                        break
                    other.append((seed, told))
            else:
                full = {k: (got[k] if got[k] is not None else files[k]) for k in files}
                try: new = mod.run(full, name, opt)
                except Refused as r: verdict, told = "WRONG", f"the written program is not followed: {r}"
                else:
                    told = compare(orig, new, opt.get("d", D))
                    verdict = "WRONG" if told else "right, but other bytes without a force" if other and other[-1][0] == seed else "right"
        count[verdict] += 1
        if verdict == "WRONG": wrong.append((seed, told))
        if a.verbose or a.program: print(f"seed {seed}: {verdict} {told or ''}")
        if a.keep and verdict == "WRONG":
            k = os.path.join(a.keep, f"{a.dialect}_{seed}")
            shutil.rmtree(k, ignore_errors=True); shutil.copytree(w, k)
        elif a.keep and a.program:
            k = os.path.join(a.keep, f"{a.dialect}_program")
            shutil.rmtree(k, ignore_errors=True); shutil.copytree(w, k)
        shutil.rmtree(w)
    shutil.rmtree(root, ignore_errors=True)
    print(f"{a.dialect}: {sum(count.values())} programs: " + ", ".join(f"{n} {k}" for k, n in count.most_common()))
    for (v, s), n in reasons.most_common():
        print(f"  {n:4d} {v}: {s}\n         seed {lines[(v, s)][0]}: {lines[(v, s)][1][:220]}")
    if other: print("  other bytes without a force, same motion: seeds " + ", ".join(str(x) for x, _ in other))
    for seed, t in wrong: print(f"  WRONG seed {seed}: {t}")
    sys.exit(1 if wrong or not any(str(k).startswith("right") for k in count) else 0)


if __name__ == "__main__":
    main()
