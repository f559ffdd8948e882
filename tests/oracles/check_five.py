#!/usr/bin/env python3
"""python3 check_five.py KINETOSTAT --from SEED --count N [--machine NAME] [--keep FOLDER] [--program FILE --kin NAME --dialect NAME]

As check.py, for five_axis.py. The machine file is written from the machine of the seed (five_axis.toml); 100 N along the tool move the
tip by 0.2 mm along the tool's axis, wherever it points, so a cutting end p with the axis a has to be written as p - 0.2 a, with the
same angles, and the angles that kinetostat says the control finds for an inclined plane are those found here. Also: the path's points that kinetostat itself writes (OUT.points.csv) at the end of each line agree with this reading."""
import argparse, collections, csv, json, math, os, shutil, subprocess, sys, tempfile
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import check, five_axis as f
from move import Refused

K = -0.2
FORCE = check.FORCE.replace("-0.0005", "0.0").replace("0.0003", "0.0")
TOL, NEAR = 8e-6, 0.02


def shifted(m): return f.add(m.end, f.mul(m.axis_or_rotation, K)) if m.kind != "rapid" else m.end


def between(mach, a, m, n=None):
    """Where the corrected tip has to be on the way from a to m."""
    n = n or (100 if m.tip_led else 1500)
    out = []
    for i in range(n+1):
        t = i/n
        ang = {l: a.ang[l] + (m.ang[l]-a.ang[l])*t for l in a.ang}
        d = mach.forward((0, 0, 0), ang)[1]
        p = f.add(a.end, f.mul(f.sub(m.end, a.end), t)) if m.tip_led else mach.forward(f.add(a.lin, f.mul(f.sub(m.lin, a.lin), t)), ang)[0]
        out.append(f.add(p, f.mul(d, K)))
    return out


def same(a, b): return check.gap(a.end, b.end) < 1e-9 and a.ang == b.ang


def compare(mach, orig, new):
    j, at, worst = 0, None, 0.0
    for m in orig:
        want, found, best, mid = shifted(m), None, None, []
        if at and same(m, at): continue
        while j < len(new):
            n = new[j]; j += 1
            e = check.gap(n.end, want)
            turned = max(abs(n.ang[l]-m.ang[l]) for l in m.ang)
            if n.kind == m.kind and (best is None or e < best[0]): best = (e, n)
            if n.kind == m.kind and e <= TOL and turned < 1e-6: found = n; break
            mid.append(n)
        if not found:
            b = f"nearest line {best[1].line} off by {best[0]:.6f} mm {check.fmt(f.sub(best[1].end, want))} angles {best[1].ang}" if best else "no such move left"
            return f"line {m.line} {m.kind} to {check.fmt(m.end)} {m.ang}: expected at {check.fmt(want)}: {b}"
        if m.kind == "line" and at and at.kind == "line":
            way = between(mach, at, m)
            for p in mid:
                e = check.to_line(p.end, way)
                worst = max(worst, e)
                if e > NEAR: return f"line {m.line}: written line {p.line} is {e:.4f} mm off the path on the way to {check.fmt(m.end)}"
        at = m
    return None


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("kinetostat"); ap.add_argument("--from", dest="first", type=int, default=1); ap.add_argument("--count", type=int, default=20)
    ap.add_argument("--dialect", default=None); ap.add_argument("--machine"); ap.add_argument("--keep"); ap.add_argument("--program"); ap.add_argument("--kin")
    ap.add_argument("--rotary", action="store_true", help="the axes are told by [[gcode.rotary]] as well")
    a = ap.parse_args()
    count, reasons, lines, wrong, per, apart = collections.Counter(), collections.Counter(), {}, [], {}, {}
    finds = collections.Counter()
    root = tempfile.mkdtemp(prefix="orc5_")
    for seed in [0] if a.program else range(a.first, a.first+a.count):
        if a.program:
            name = os.path.basename(a.program); files = {name: open(a.program, "rb").read()}
            opt = {"kin": a.kin, "dialect": a.dialect or "fanuc", "machine": f.toml(next(m for m in f.machines() if m.name == a.kin))}
        else: files, name, opt = f.generate(seed)
        if a.machine and opt["kin"] != a.machine or a.dialect and opt["dialect"] != a.dialect: continue
        mach = next(m for m in f.machines() if m.name == opt["kin"])
        try: orig = f.run(files, name, opt)
        except Refused as r: count["not followed by the interpreter"] += 1; continue
        w = os.path.join(root, "s%d" % seed); os.makedirs(w+"/in")
        open(w+"/in/"+name, "wb").write(files[name]); open(w+"/machine.toml", "w").write(opt["machine"])
        g = '[sampling]\nmax_segment_mm = 5.0\nmax_turn_deg = 2.0\n[gcode]\ndecimals_mm = 6\ndialect = "%s"\n' % opt["dialect"]
        if a.rotary:
            for x in mach.tables + mach.heads if not (mach.tables and mach.heads) else mach.heads + mach.tables:
                g += '[[gcode.rotary]]\nletter = "%s"\nabout = %s\nturns = "%s"\nthrough_mm = %s\n' % (
                    x.letter, list(map(float, x.about)), "tool" if x.kind == "head" else "workpiece", list(map(float, x.through)))
        verdict = told = None
        for n, t in (("p0", check.PROCESS), ("p1", check.PROCESS+FORCE)):
            open(w+"/"+n+".toml", "w").write(t+g); os.makedirs(w+"/"+n); out = w+"/"+n+"/"+name
            p = subprocess.run(["nice", "-n", "15", a.kinetostat, "compensate", w+"/in/"+name, "--machine", w+"/machine.toml", "--process", w+"/"+n+".toml", "--out", out,
                                "--force", "--method", "direct", "--progress", "none", "--points", "all"], capture_output=True, text=True, errors="replace")
            if p.returncode not in (0, 1) or not os.path.exists(out):
                short, told = check.reason(p.stderr); verdict = "refused" if n == "p0" else "refused with force"
                if p.returncode == 3 or p.returncode < 0: short = "INTERNAL "+short
                reasons[(verdict, short)] += 1; lines.setdefault((verdict, short), (seed, told)); break
            got = open(out, "rb").read()
            if n == "p0":
                if got != files[name]: verdict, told = "WRONG", "without a force not the same bytes"; break
                ends = {}
                for r in csv.DictReader(open(out+".points.csv")): ends[int(r["line"])] = (float(r["x_mm"]), float(r["y_mm"]), float(r["z_mm"]))
                for m in orig:
                    if m.line in ends:
                        e = check.gap(ends[m.line], m.end); z = apart.setdefault(opt["kin"], [0, 0.0]); z[0] += 1; z[1] = max(z[1], e)
                        if e > 1e-6 and not told: told = f"line {m.line}: kinetostat has the tip at {check.fmt(ends[m.line])}, this reading at {check.fmt(m.end)} {m.ang}"
                said = [(x["line"], x) for x in json.load(open(out+".report.json"))["angles_of_the_control"]]
                if not told and ([n for n, _ in said] != [n for n, _ in opt["chosen"]] or
                                 any(abs(x[l]-c[l]) > 1e-6 for (_, x), (_, c) in zip(said, opt["chosen"]) for l in c)):
                    told = f"kinetostat says that the control finds {said}, here {opt['chosen']}"
                finds[opt["kin"]] += len(said)
                if told: verdict = "WRONG"; break
            else:
                try: new = f.run({name: got}, name, opt)
                except Refused as r: verdict, told = "WRONG", f"the written program is not followed: {r}"
                else: told = compare(mach, orig, new); verdict = "WRONG" if told else "right"
        count[verdict] += 1; per.setdefault(opt["kin"], collections.Counter())[verdict] += 1
        if verdict == "WRONG": wrong.append((seed, opt["kin"], opt["dialect"], told))
        if a.program: print(verdict, told or "")
        if a.keep and (verdict == "WRONG" or a.program): shutil.rmtree(a.keep+"/five_%d" % seed, True); shutil.copytree(w, a.keep+"/five_%d" % seed)
        shutil.rmtree(w)
    shutil.rmtree(root, True)
    print(f"five_axis: {sum(count.values())} programs: " + ", ".join(f"{n} {k}" for k, n in count.most_common()))
    for k in sorted(per): print(f"  {k:18} {dict(per[k])}" + (f"; {apart[k][0]} line ends, largest distance {apart[k][1]:.3g} mm; {finds[k]} planes" if k in apart else ""))
    for (v, s), n in reasons.most_common(): print(f"  {n:4d} {v}: {s}\n         seed {lines[(v, s)][0]}: {lines[(v, s)][1][:260]}")
    for x in wrong: print("  WRONG seed %d %s %s: %s" % x)
    sys.exit(1 if wrong or not count["right"] else 0)


if __name__ == "__main__": main()
