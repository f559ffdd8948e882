#!/usr/bin/env python3
"""python3 check_robots.py KINETOSTAT --dialect krl|rapid|urscript|fanuc_ls --from SEED --count N [--keep FOLDER] [--program MAIN [FILE ...]]

As check.py, for robots. The machine is a gantry of three equal slides that carries three crossing axes of 1e16 N·mm/rad: with a force
of 100 N along the tool, away from the part, the tip is off by 0.1 mm along the tool's axis wherever it is, so that a cutting move's end
at p with the tool along t (unit, from the spindle to the tip, in the first workpiece frame) has to be written as p + 0.1 t, and
rapid and joint moves stay. t comes from the pose as this folder's interpreter reads it, and from the tool's frame: the machine's tool
lies along z of the flange. Judged: ends and orientations of all moves in order; what was put in between lies on the path + 0.1 t; arcs;
zones of what was put in between below half the distance to its neighbours; feed; and, where no line was added, all text but numbers.
"""
import argparse
import collections
import importlib
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from check import reason, toml
from move import Refused
from robmath import add, angle_between, app, circle, dist, dot, fmul, mul, norm, rotvec, sca, sub, to_rotvec, tr, turn_about

MACHINE = '''schema = 1
name = "gantry6"
title = "Gantry robot with a wrist whose axes meet in the flange"
[platform]
tool_tip_mm = [0.0, 0.0, 300.0]
tool_axis = [0.0, 0.0, 1.0]
controls = ["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"]
[home]
position_mm = [0.0, 0.0, 300.0]
rotation_deg = [0.0, 180.0, 0.0]
[workspace]
min_mm = [-9000.0, -9000.0, -9000.0]
max_mm = [9000.0, 9000.0, 9000.0]
[[chain]]
name = "arm"
elements = [
  { prismatic_drive = { name = "X", axis = "x", stiffness_N_per_mm = 1000.0, home_mm = 0.0 } },
  { prismatic_drive = { name = "Y", axis = "y", stiffness_N_per_mm = 1000.0, home_mm = 0.0 } },
  { prismatic_drive = { name = "Z", axis = "z", stiffness_N_per_mm = 1000.0, home_mm = 300.0 } },
  { revolute_drive = { name = "C", axis = "z", stiffness_Nmm_per_rad = 1.0e16 } },
  { revolute_drive = { name = "A", axis = "x", stiffness_Nmm_per_rad = 1.0e16, home_deg = 180.0 } },
  { revolute_drive = { name = "B", axis = "y", stiffness_Nmm_per_rad = 1.0e16} },
]
[[mount]]
name = "arm"
chain = "arm"
'''
PROCESS = "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 0.0]\n"
FORCE = "[force.path_frame]\nradial_force_N = 0.0\ntangential_force_N = 0.0\naxial_force_N = -100.0\n[compensate]\ncorner_mm = 0.0\n"
TOL, NEAR, RAMP, SIZE = 6e-6, 0.012, 2.2, 0.1
ROT = 2e-6
MOVE = rb"(?i)(LIN|PTP|CIRC|SPL|SLIN|SPTP|SCIRC|MoveL|MoveJ|MoveC|movel|movej|movep|movec|L|J|C|A)$"
CUT = ("line", "arc", "spline")


def axis(m, R=None):
    R = R or m.axis_or_rotation
    return app(R, (0.0, 0.0, 1.0)) if m.standing else app(mul(R, tr(m.tool)), (0.0, 0.0, 1.0))


def fmt(p):
    return "(" + ", ".join(f"{x:.6f}".rstrip("0").rstrip(".") for x in p) + ")" if p else "?"


def sample(p0, R0, m, n):
    """n poses along a move, orientations turned at one rate about one axis."""
    out = []
    v = to_rotvec(mul(tr(R0), m.axis_or_rotation)) if R0 else (0, 0, 0)
    R0 = R0 or m.axis_or_rotation
    for i in range(1, n + 1):
        t = i / n
        R = mul(R0, rotvec(sca(t, v)))
        if m.kind == "arc" and m.turn:
            w = norm(m.turn)
            p = add(m.centre, turn_about(sca(1 / w, m.turn), w * t, sub(p0, m.centre)))
        else:
            p = add(p0, sca(t, sub(m.end, p0)))
        out.append((p, R))
    return out


def fine(p0, R0, m):
    """How many pieces: chords of arcs within 1 um, turns of the tool in steps of less than a degree."""
    if m.kind == "arc":
        return max(60, math.ceil(norm(m.turn) * math.sqrt(dist(p0, m.centre) / 0.008)))
    return 1 if R0 and angle_between(R0, m.axis_or_rotation) < 1e-7 else 60


def to_line(p, chain):
    best = 1e9
    for a, b in zip(chain, chain[1:]):
        d = sub(b, a)
        q = dot(d, d)
        t = max(0.0, min(1.0, dot(sub(p, a), d) / q)) if q else 0.0
        best = min(best, dist(p, add(a, sca(t, d))))
    return min(best, dist(p, chain[0])) if chain else best


def compare(orig, new, size=SIZE):
    """None, or what is wrong; what is only wrong with zones comes last, with ZONE before it."""
    zones = []
    w = moves_differ(orig, new, size, zones)
    return w or (zones and "ZONE " + zones[0]) or None


def moves_differ(orig, new, size, zones):
    j, po, pn, Ro, before = 0, None, None, None, True
    for m in orig:
        cut = m.kind in CUT
        if not cut:
            # what lies between may only be cutting moves that belong to none: no
            if j >= len(new):
                return f"{m.file}:{m.line}: {m.kind} to {fmt(m.end)} is missing"
            n = new[j]
            if n.kind != m.kind:
                return f"{m.file}:{m.line}: {m.kind} to {fmt(m.end)}, written {n.file}:{n.line} {n.kind} to {fmt(n.end)}"
            if m.end is None:
                if n.joints != m.joints:
                    return f"{m.file}:{m.line}: joints changed to {n.joints}"
                po = pn = Ro = None
            else:
                e = dist(m.end, n.end)
                if e > TOL:
                    return f"{m.file}:{m.line}: {m.kind} to {fmt(m.end)} was moved by {fmt(sub(n.end, m.end))} in {n.file}:{n.line}"
                if angle_between(m.axis_or_rotation, n.axis_or_rotation) > ROT:
                    return f"{m.file}:{m.line}: {m.kind}: turned by {math.degrees(angle_between(m.axis_or_rotation, n.axis_or_rotation)):.5f} deg"
                po, pn, Ro = m.end, n.end, m.axis_or_rotation
            j += 1
            before = True
            continue
        want = add(m.end, sca(size, axis(m)))
        mine, best = [], None
        k = j
        while k < len(new) and new[k].kind in CUT:
            n = new[k]
            e = dist(n.end, want)
            if best is None or e < best[0]:
                best = (e, n)
            mine.append(n)
            k += 1
            if e <= TOL and angle_between(m.axis_or_rotation, n.axis_or_rotation) <= ROT:
                # an arc that comes by its own end first (a whole turn) is not handled: programs do not split there
                break
        else:
            b = f"nearest {best[1].file}:{best[1].line} off by {fmt(sub(best[1].end, want))}, turned by {math.degrees(angle_between(best[1].axis_or_rotation, m.axis_or_rotation)):.6f} deg" \
                if best else ("next is a " + new[k].kind if k < len(new) else "nothing left")
            return f"{m.file}:{m.line}: {m.kind} to {fmt(m.end)}, expected {fmt(want)}: {b}"
        j = k
        # what was put in between, and where the path runs
        if po is not None and pn is not None:
            chain = [add(p, sca(size, axis(m, R))) for p, R in [(po, Ro)] + sample(po, Ro, m, fine(po, Ro, m))]
            if m.kind != "spline":
                at, s = pn, 0.0
                for n in mine:
                    if n.kind == "spline":
                        return f"{m.file}:{m.line}: {m.kind} became a spline"
                    for p, _ in sample(at, None, n, 24 if n.kind == "arc" else 4):
                        if before and dist(p, po) < RAMP + size:
                            continue
                        e = to_line(p, chain + ([pn] if before else []))
                        if before:
                            e = min(e, to_line(p, [pn] + chain[-1:]) if m.kind != "arc" else e)
                        if e > NEAR + (size if before and m.kind == "arc" else 0) and not (before and m.kind == "line"):
                            return f"{m.file}:{m.line}: {m.kind} to {fmt(m.end)}: the written path is {e:.4f} mm off at {fmt(p)} ({n.file}:{n.line})"
                    at = n.end
            elif len(mine) > 1:
                return f"{m.file}:{m.line}: a spline's point was split"
            if len(mine) == 1 and m.kind == "arc" and mine[0].kind == "arc" and not before:
                n = mine[0]
                if dist(m.turn, n.turn) > 1e-3 + 2 * size / dist(n.end, n.centre) * 0 + 0.05:
                    return f"{m.file}:{m.line}: the arc turns by {fmt(n.turn)} rad instead of {fmt(m.turn)}"
            if len(mine) == 1 and m.kind == "line" and mine[0].kind != "line":
                return f"{m.file}:{m.line}: a line became {mine[0].kind}"
        if mine[-1].zone != m.zone and not (len(mine) > 1 and mine[-1].zone is not None and m.zone is not None):
            return f"{m.file}:{m.line}: zone of the kept end {mine[-1].zone} instead of {m.zone} ({mine[-1].file}:{mine[-1].line})"
        for q, n in enumerate(mine[:-1]):
            d1 = dist(n.end, mine[q - 1].end if q else pn) if (q or pn) else 1e9
            d2 = dist(n.end, mine[q + 1].end)
            if n.zone is not None and n.zone > min(d1, d2) / 2 + 1e-9:
                zones.append(f"{m.file}:{m.line}: a point put in at {n.file}:{n.line} has a zone of {n.zone} mm, its neighbours are {min(d1, d2):.4f} mm away")
        for n in mine:
            if m.feed is not None and n.feed is not None and abs(n.feed - m.feed) > 1e-6 * m.feed:
                return f"{m.file}:{m.line}: feed {n.feed} instead of {m.feed}"
        po, pn, Ro, before = m.end, mine[-1].end, m.axis_or_rotation, False
    if j < len(new):
        return f"written {new[j].file}:{new[j].line}: a {new[j].kind} more, to {fmt(new[j].end)}"
    return None


def judge_itself(mod, seeds):
    """The judge has to find what is put wrong into moves that are right."""
    import random
    from dataclasses import replace
    n = collections.Counter()
    for s in seeds:
        r = random.Random(s)
        o = mod.trace(*mod.generate(s))
        shift = lambda m: replace(m, end=add(m.end, sca(SIZE, axis(m)))) if m.kind in CUT else m
        good = [shift(m) for m in o]
        at = None
        for i, m in enumerate(o):
            if m.kind == "arc":     # both ends and the point between are moved
                c = circle(good[i - 1].end, add(m.via, sca(SIZE, axis(m))), good[i].end)
                if i and o[i - 1].kind in CUT and angle_between(o[i - 1].axis_or_rotation, m.axis_or_rotation) < 1e-7:
                    good[i] = replace(good[i], centre=add(m.centre, sca(SIZE, axis(m))))
                elif i and o[i - 1].kind in CUT and c:
                    good[i] = replace(good[i], centre=c[0], turn=sca(c[3], c[2]))
        w = compare(o, good)
        turned = any(a.axis_or_rotation and b.axis_or_rotation and angle_between(a.axis_or_rotation, b.axis_or_rotation) > 1e-6 for a, b in zip(o, o[1:]))
        arcs_after_rapid = any(m.kind == "arc" and (i == 0 or o[i - 1].kind not in CUT) for i, m in enumerate(o))
        n["right found right" if not w else "right called wrong" + (" (a turned tool)" if turned else " (arc behind a rapid)" if arcs_after_rapid else "")] += 1
        if w and not turned and not arcs_after_rapid:
            print("seed", s, w)
        assert compare(o, o) is not None, s
        cuts = [i for i, m in enumerate(o) if m.kind in CUT]
        i = r.choice(cuts)
        assert compare(o, good[:i] + [replace(good[i], end=add(good[i].end, (0, 1e-4, 0)))] + good[i + 1:]), (s, "an end off by 0.1 um")
        assert compare(o, good[:i] + [o[i]] + good[i + 1:]), (s, "a correction lost")
        rap = [i for i, m in enumerate(o) if m.kind == "rapid"]
        i = r.choice(rap)
        assert compare(o, good[:i] + [replace(o[i], end=add(o[i].end, sca(SIZE, axis(o[i]))))] + good[i + 1:]), (s, "a rapid corrected")
        i = r.choice(cuts)
        if dist(o[i].end, o[i - 1].end if i and o[i - 1].end else (9e9, 0, 0)) > .1:
            assert compare(o, good[:i] + good[i + 1:]), (s, "a block lost")
    print(dict(n))


def text(a, b):
    """Where no line was added: the same but for numbers."""
    la, lb = re.split(rb"\r\n|\n|\r", a), re.split(rb"\r\n|\n|\r", b)
    if len(la) != len(lb):
        return None
    if a.count(b"\r\n") != b.count(b"\r\n"):
        return "line ends changed"
    for i, (x, y) in enumerate(zip(la, lb), 1):
        m = [re.sub(rb"[-+]?\d*\.?\d+(?:[eE][-+]?\d+)?", b"#", t) for t in (x, y)]
        # a declared point may be replaced by its numbers in a move: then only the rest of the line has to be kept
        w = [re.match(rb"\s*(?:#:\s*)?(\w+)", t) for t in m]
        if w[0] and w[1] and w[0].group(1) == w[1].group(1) and re.match(MOVE, w[0].group(1)):
            continue
        if m[0] != m[1]:
            return f"line {i}: {y.decode('latin-1').strip()!r} instead of {x.decode('latin-1').strip()!r}"
    return None


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("kinetostat")
    ap.add_argument("--dialect", required=True)
    ap.add_argument("--from", dest="first", type=int, default=1)
    ap.add_argument("--count", type=int, default=20)
    ap.add_argument("--keep")
    ap.add_argument("--program", nargs="*")
    ap.add_argument("--opt", default="{}")
    ap.add_argument("--wt", type=float, help="write_tolerance_mm")
    ap.add_argument("--verbose", action="store_true")
    a = ap.parse_args()
    mod = importlib.import_module(a.dialect)
    if a.kinetostat == "self":
        return judge_itself(mod, range(a.first, a.first + a.count))
    count, reasons, lines, wrong, shapes = collections.Counter(), collections.Counter(), {}, [], collections.Counter()
    root = tempfile.mkdtemp(prefix="orcr_")
    for seed in ([0] if a.program else range(a.first, a.first + a.count)):
        if a.program:
            files = {os.path.basename(p): open(p, "rb").read() for p in a.program}
            name, opt = os.path.basename(a.program[0]), json.loads(a.opt)
        else:
            files, name, opt = mod.generate(seed)
        try:
            orig = mod.trace(files, name, opt)
        except Refused as r:
            count["not followed by the interpreter"] += 1
            print(f"seed {seed}: the interpreter itself refuses: {r}")
            continue
        w = os.path.join(root, f"s{seed}")
        os.makedirs(os.path.join(w, "in"))
        for k, v in files.items():
            open(os.path.join(w, "in", k), "wb").write(v)
        open(os.path.join(w, "machine.toml"), "w").write(MACHINE.replace("[0.0, 0.0, 300.0]\ntool_axis", f"{[float(v) for v in opt.get('tip', (0, 0, 300))]}\ntool_axis"))
        g = dict(opt.get("gcode", {}))
        g.setdefault("decimals_mm", 6)
        if a.wt is not None:
            g["write_tolerance_mm"] = a.wt
        gc = "[gcode]\n" + "".join(f"{k} = {toml(v)}\n" for k, v in g.items())
        for n, t in (("p0", PROCESS), ("p1", PROCESS + FORCE)):
            open(os.path.join(w, n + ".toml"), "w").write(t + gc + opt.get("toml", ""))
        verdict, told = None, ""
        for n in ("p0", "p1"):
            os.makedirs(os.path.join(w, n))
            out = os.path.join(w, n, name)
            p = subprocess.run(["nice", "-n", "15", a.kinetostat, "compensate", os.path.join(w, "in", name), "--machine", os.path.join(w, "machine.toml"), "--process",
                                os.path.join(w, n + ".toml"), "--out", out, "--force", "--method", "direct", "--progress", "none"], capture_output=True, text=True, errors="replace")
            if p.returncode not in (0, 1) or not os.path.exists(out):
                short, told = reason(p.stderr)
                if p.returncode == 3 or p.returncode < 0:
                    short = "INTERNAL " + short
                verdict = "refused" if n == "p0" else "refused with force"
                reasons[(verdict, short)] += 1
                lines.setdefault((verdict, short), (seed, " ".join(p.stderr.split())))
                break
            got = {k: (open(os.path.join(w, n, k), "rb").read() if os.path.exists(os.path.join(w, n, k)) else None) for k in files}
            if n == "p0":
                bad = [k for k in files if got[k] is not None and got[k] != files[k]]
                if bad:
                    verdict, told = "WRONG", "without a force not the same bytes: " + ", ".join(bad)
                    break
            else:
                full = {k: (got[k] if got[k] is not None else files[k]) for k in files}
                extra = [k for k in os.listdir(os.path.join(w, n)) if k not in files and not re.search(r"\.(html|json|csv)$", k)]
                for k in extra:
                    full[k] = open(os.path.join(w, n, k), "rb").read()
                try:
                    new = mod.trace(full, name, opt)
                except Refused as r:
                    verdict, told = "WRONG", f"the written program is not followed: {r}"
                else:
                    told = compare(orig, new)
                    for k in files:
                        if not told and got[k] is not None and b"written out by kinetostat" not in got[k]:
                            t = text(files[k], got[k])
                            told = t and f"{k}: {t}"
                    shapes["same lines" if all(got[k] is None or len(got[k].splitlines()) == len(files[k].splitlines()) for k in files) else "lines added or written out"] += 1
                    verdict = ("right but for zones" if told.startswith("ZONE") else "WRONG") if told else "right"
        count[verdict] += 1
        if verdict in ("WRONG", "right but for zones"):
            wrong.append((seed, told))
        if a.verbose or a.program:
            print(f"seed {seed}: {verdict} {told or ''}", flush=True)
        if a.keep and (verdict == "WRONG" or a.program or a.keep.endswith("all")):
            k = os.path.join(a.keep, f"{a.dialect}_{seed}")
            shutil.rmtree(k, ignore_errors=True)
            shutil.copytree(w, k)
        shutil.rmtree(w)
    shutil.rmtree(root, ignore_errors=True)
    print(f"{a.dialect}: {sum(count.values())} programs: " + ", ".join(f"{n} {k}" for k, n in count.most_common()) + (f"; of those accepted {dict(shapes)}" if shapes else ""))
    for (v, s), n in reasons.most_common():
        print(f"  {n:4d} {v}: {s}\n         seed {lines[(v, s)][0]}: {lines[(v, s)][1][:330]}")
    for seed, t in wrong:
        print(f"  {'' if t.startswith('ZONE') else 'WRONG '}seed {seed}: {t}")
    # KUKA begins a zone at half the distance to a neighbour at the earliest, whatever it is set to.
    is_wrong = any(not told.startswith("ZONE") for _, told in wrong)
    sys.exit(1 if is_wrong or not any(str(k).startswith("right") for k in count) else 0)


if __name__ == "__main__":
    main()
