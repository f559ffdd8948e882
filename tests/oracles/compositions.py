#!/usr/bin/env python3
"""python3 compositions.py KINETOSTAT --dialect urscript|rapid|krl|sinumerik --from SEED --count N [--keep FOLDER]
python3 compositions.py KINETOSTAT --dialect heidenhain|sinumerik_frames|iso|planes|fanuc_ls|apt|rapid_frames|krl_frames --from SEED --count N [--keep FOLDER] [--verbose]
python3 compositions.py KINETOSTAT --deep

Random programs whose targets are compositions of frames, offsets and displacements, nested to six levels. Those of the first line are judged by the
interpreters of this folder as check_robots.py and check.py do, and need ORC_SIMPLE unset. Those of the second by what this file itself makes of
the manuals: kinetostat's own points (OUT.points.csv) pass each end of a move, 0.001 mm and 0.001 degrees; so do those of what it writes with a
force, with the correction; and what a manual has and kinetostat does not follow is an error with its line, never a path.
What kinetostat refuses is counted by its reason. --deep: 20,000 levels are an error and no crash.
"""
import collections
import csv
import importlib
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import check
import check_robots
from robmath import NULL, angle_between, cross, dot, finv, fmul, mul, norm, rx, ry, rz, to_quat, to_rotvec, to_zyx, tr, zyx

DOWN = ry(math.pi)


def target(r):
    """The tool points down, a little turned."""
    return (mul(mul(rz(r.uniform(-0.5, 0.5)), rx(r.uniform(-0.3, 0.3))), DOWN), (r.uniform(-80, 80), r.uniform(-80, 80), r.uniform(-15, 4)))


def frame(r):
    return (mul(mul(rz(r.uniform(-2, 2)), ry(r.uniform(-1, 1))), rx(r.uniform(-1, 1))), tuple(r.uniform(-90, 90) for _ in range(3)))


def urscript(seed):
    r = random.Random(f"compose ur {seed}")
    head, n = [], [0]
    wide, plain = r.random() < 0.25, r.random() < 0.6       # also what is not read yet; pose_trans of literals and of names of literals alone

    def number(v): return f"{v:.9f}"
    def lit(f): return "p[" + ", ".join([number(x / 1000) for x in f[1]] + [number(x) for x in to_rotvec(f[0])]) + "]"
    def name(text):
        n[0] += 1
        head.append(f"{r.choice(['', 'global '])}f_{n[0]} = {text}")
        return f"f_{n[0]}"

    def of(f, depth, feature):
        """An expression for the pose f. A feature may be anything, a target what is not turned back."""
        x = r.random()
        if depth == 0 or x < 0.15: return name(lit(f)) if r.random() < 0.4 else lit(f)
        if x < 0.3 and (feature and not plain or wide): return name(of(f, depth - 1, feature))
        if x < 0.45 and (feature and not plain or wide): return f"pose_inv({of(finv(f), depth - 1, True)})"
        if x < 0.5 and wide: return f"pose_add({of((NULL[0], (1.0, 2.0, 3.0)), depth - 1, True)}, {of((f[0], tuple(a - b for a, b in zip(f[1], (1.0, 2.0, 3.0)))), depth - 1, False)})"
        a = frame(r)
        return f"pose_trans({of(a, 0 if right else depth - 1, True)}, {of(fmul(finv(a), f), depth - 1, feature)})"
    right = r.random() < 0.4        # nested in the second place alone
    if right: wide, plain = False, True
    body = []
    for i in range(r.randint(5, 9)):
        depth = r.randint(1, 6)
        body.append(f"{'movej' if i == 0 else 'movel'}({of(target(r), depth, False)}, a=1.2, v=0.05)")
    lines = ["def prog():"] + ["  " + x for x in ["set_tcp(p[0,0,0.15,0,0,0])"] + head + body] + ["end"]
    return {"prog.script": ("\n".join(lines) + "\n").encode()}, "prog.script", {"tip": (0, 0, 150), "gcode": {"decimals_mm": 6}}


def rapid(seed):
    r = random.Random(f"compose rapid {seed}")
    data, n, wide = [], [0], r.random() < 0.25
    def q(R): return "[" + ",".join(f"{c:.12f}" for c in to_quat(R)) + "]"
    def pose(f): return f"[[{f[1][0]:.6f},{f[1][1]:.6f},{f[1][2]:.6f}],{q(f[0])}]"
    def lit(f): return f"[{pose(f)[1:-1]},[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"

    def of(f, depth):
        x = r.random()
        if depth == 0:
            if r.random() < 0.5: return lit(f)
            n[0] += 1
            data.append(f"CONST robtarget p{n[0]}:={lit(f)};")
            return f"p{n[0]}"
        if x < 0.4:
            d = tuple(round(r.uniform(-30, 30), 3) for _ in range(3))
            return f"Offs({of((f[0], tuple(a - b for a, b in zip(f[1], d))), depth - 1)},{d[0]},{d[1]},{d[2]})"
        d, turns = tuple(round(r.uniform(-20, 20), 3) for _ in range(3)), [(k, round(r.uniform(-40, 40), 3)) for k in ("Rx", "Ry", "Rz") if r.random() < 0.5]
        of_turn = dict(turns)
        D = mul(mul(rx(math.radians(of_turn.get("Rx", 0))), ry(math.radians(of_turn.get("Ry", 0)))), rz(math.radians(of_turn.get("Rz", 0))))
        return f"RelTool({of(fmul(f, finv((D, d))), depth - 1)},{d[0]},{d[1]},{d[2]}{''.join(f'{chr(92)}{k}:={v}' for k, v in turns)})"
    w = f'PERS wobjdata w1:=[FALSE,TRUE,"",{pose(frame(r))},{pose(frame(r))}];'
    tool = "PERS tooldata t1:=[TRUE,[[0,0,150],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];"
    body = []
    for i in range(r.randint(5, 9)):
        if wide and i and r.random() < 0.3: body.append(f"PDispSet PoseMult({pose(frame(r))},PoseInv({pose(frame(r))}));")
        body.append(f"{'MoveJ' if i == 0 else 'MoveL'} {of(target(r), r.randint(1, 6))},v50,fine,t1\\WObj:=w1;")
    lines = ["MODULE M", tool, w, *data, "PROC main()", *body, "ENDPROC", "ENDMODULE"]
    return {"m.mod": ("\n".join(lines) + "\n").encode()}, "m.mod", {"tip": (0, 0, 150), "hold": False, "gcode": {"decimals_mm": 6}}


def krl(seed):
    r = random.Random(f"compose krl {seed}")
    decl, sets, n = [], [], [0]
    def lit(f):
        a = to_zyx(f[0])
        return "{" + ",".join(f"{k} {v:.7f}" for k, v in zip("XYZABC", (*f[1], *a))) + "}"
    def name(f):
        n[0] += 1
        decl.append(f"DECL FRAME F{n[0]}"); sets.append(f"F{n[0]}={lit(f)}")
        return f"F{n[0]}"
    def of(f, depth):
        if depth == 0: return lit(f) if r.random() < 0.5 else name(f)
        a = frame(r)
        left = of(a, 0 if r.random() < 0.5 else depth - 1)
        right = of(fmul(finv(a), f), depth - 1)
        left = left if ":" not in left else f"({left})"
        return f"{left}:{right if ':' not in right or r.random() < 0.5 else f'({right})'}" if ":" in right and right.startswith("(") or ":" not in right else f"{left}:({right})"
    body = [f"PTP {lit(target(r))}"]
    for _ in range(r.randint(4, 8)): body.append(f"LIN {of(target(r), r.randint(1, 6))}")
    lines = ["DEF prog()", *decl, "$BASE=$NULLFRAME", "$TOOL={X 0,Y 0,Z 150,A 0,B 0,C 0}", "$VEL.CP=0.02", *sets, *body, "END"]
    return {"prog.src": ("\n".join(lines) + "\n").encode()}, "prog.src", {"tip": (0, 0, 150), "gcode": {"decimals_mm": 6}}


def sinumerik(seed):
    r = random.Random(f"compose sinumerik {seed}")
    u = lambda a: f"{r.uniform(-a, a):.3f}"
    out = ["G54 G17 G90 G71 G94", "T1 D1 M6", "S1000 M3", "G0 X0 Y0 Z20"]
    flat = r.random() < 0.7
    for _ in range(r.randint(2, 4)):
        out.append(r.choice(["TRANS", "ROT", "TRANS X%s Y%s Z%s" % (u(30), u(30), u(5)), f"ROT Z{u(80)}"]))
        for _ in range(r.randint(1, 6)):
            out.append(r.choice([f"ATRANS X{u(30)} Y{u(30)}", f"ATRANS X{u(20)} Z{u(5)}", f"AROT Z{u(80)}", f"AROT RPL={u(60)}"] if flat else [f"ATRANS X{u(20)} Z{u(5)}", f"AROT Z{u(80)}", f"AROT X{u(40)}", f"AROT Y{u(40)}", f"AROT X{u(20)} Y{u(20)} Z{u(20)}", f"AROT RPL={u(60)}"]))
        out.append(f"G0 X{u(40)} Y{u(40)} Z{u(5)}")
        for _ in range(r.randint(2, 4)): out.append(f"G1 X{u(40)} Y{u(40)} Z{u(5)} F500")
        if r.random() < 0.5: out.append(f"ATRANS X{u(10)}"); out.append(f"G1 X{u(40)} Y{u(40)} F500")
    out += ["TRANS", "G0 X0 Y0 Z50", "M30"]
    return {"n.mpf": ("\n".join(out) + "\n").encode()}, "n.mpf", {}


# ---- Of the second line: a program is a tree of texts with what each does to the frames in force, and is evaluated as it is made.
class Leaf:
    def __init__(self, text, act=None, sub=None): self.text, self.act, self.sub, self.line = text, act, sub, None


class Loop:
    def __init__(self, head, body, tail, n): self.head, self.body, self.tail, self.n = head, body, tail, n


def lay(items, lines):
    for x in items:
        if isinstance(x, Loop): lay([Leaf(x.head)], lines) or lay(x.body, lines) or lay([Leaf(x.tail)], lines)
        else: lines.append(x.text); x.line = len(lines)


def follow(items, state, moves):
    for x in items:
        if isinstance(x, Loop):
            for _ in range(x.n): follow(x.body, state, moves)
            continue
        pose = x.act(state) if x.act else None
        if pose: moves.append((x.line, *pose))
        if x.sub is not None: follow(x.sub, state, moves)
        if x.sub is not None and x.act: state["back"].pop()()


def made(head, items, tail, subs, state, **opt):
    """Program text, and the moves of `items`; `subs` are (first line, items, last line)."""
    lines, moves = list(head), []
    lay(items, lines)
    lines += tail
    for first, body, last in subs:
        lines.append(first); lay(body, lines); lines.append(last)
    follow(items, state, moves)
    return "\n".join(lines + opt.pop("end", [])) + "\n", moves, opt


def shift(*d): return (NULL[0], d)
def xyz(r, a, z=None): return [round(r.uniform(-a, a), 3), round(r.uniform(-a, a), 3), round(r.uniform(-(z or a), z or a), 3)]
def exact(r, turn=60):
    """A frame of numbers with three decimals, and its X Y Z, and its angles about z, the new y and the new x."""
    p, a = xyz(r, 60), xyz(r, turn)
    return (zyx(*a), tuple(p)), p, a


ROBOT = {"machine": check_robots.MACHINE.replace("[0.0, 0.0, 300.0]\ntool_axis", "[0.0, 0.0, 150.0]\ntool_axis"), "size": 0.1}
MILL = {"machine": check.MACHINE, "size": "mill"}


def heidenhain(seed):
    """HEIDENHAIN TNC 640 User's Manual 892903, Coordinate Transformations: CYCL DEF 7 counts from the preset axis by axis, incremental from the datum in force; CYCL DEF 247
    ends it. Polar coordinates are about CC in the datum in force. Cycles 8, 10, 11, 26 and TRANS change the path: what has one is never read."""
    r = random.Random(f"frames heidenhain {seed}")
    zero = {n: xyz(r, 40, 5) for n in (1, 2, 3)}
    wide = r.random() < 0.25

    def move(s, p): s["at"] = p; return None, tuple(a + b + c for a, b, c in zip(p, s["shift"], s["zero"]))
    def straight(n):
        p = xyz(r, 40, 5)
        if n < 0.5: return [Leaf("L X%+.3f Y%+.3f Z%+.3f F500" % tuple(p), lambda s: move(s, p))]
        if n < 0.7: return [Leaf("L X%+.3f Y%+.3f Z%+.3f F500" % tuple(p), lambda s: move(s, p)), Leaf("L IX%+.3f IY%+.3f" % tuple(p[:2]), lambda s: move(s, [2 * p[0], 2 * p[1], p[2]]))]
        q, a, z = r.randint(5, 30), r.randint(-180, 180), xyz(r, 5)[2]
        end = [p[0] + q * math.cos(math.radians(a)), p[1] + q * math.sin(math.radians(a)), z]
        return [Leaf("CC X%+.3f Y%+.3f" % tuple(p[:2])), Leaf("LP PR%+d PA%+d Z%+.3f F300" % (q, a, z), lambda s: move(s, end))]
    def shifted():
        out = [Leaf("CYCL DEF 7.0 DATUM SHIFT")]
        for k, axis in enumerate("XYZ"):
            if r.random() < 0.6:
                v, step = round(r.uniform(-15, 15), 3), r.random() < 0.6
                def act(s, k=k, v=v, step=step): s["shift"][k] = v + (s["shift"][k] if step else 0)
                out.append(Leaf(f"CYCL DEF 7.{len(out)} {'I' if step else ''}{axis}{v:+.3f}", act))
        return out if len(out) > 1 else shifted()
    def preset():
        n = r.choice((1, 2, 3))
        def act(s): s["zero"], s["shift"] = zero[n], [0, 0, 0]
        return [Leaf(f"CYCL DEF 247 DATUM SETTING Q339=+{n}", act)]
    n, subs = [0], []
    def level(depth):
        out = shifted() if r.random() < 0.8 else preset()
        out += straight(r.random())
        if depth:
            n[0] += 1
            k = n[0]
            if r.random() < 0.4:
                times = r.randint(1, 2)
                out.append(Loop(f"LBL {k}", level(depth - 1) if depth < 3 else shifted() + straight(0), f"CALL LBL {k} REP {times}", times + 1))
            else:
                body = level(depth - 1)
                subs.append((f"LBL {k}", body, "LBL 0"))
                out += [Leaf(f"CALL LBL {k}", sub=body)] * (1 + (r.random() < 0.3))
        return out + straight(r.random())
    items = preset() + [Leaf("L X+0 Y+0 Z+50 FMAX", lambda s: move(s, [0, 0, 50]))] + level(r.randint(1, 6))
    if wide: items += [Leaf(r.choice(["CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X", "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+35", "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 IROT+35",
                                      "CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL0.9", "CYCL DEF 26.0 AXIS-SPEC. SCALING\nCYCL DEF 26.1 X1.1 Y0.9", "TRANS DATUM AXIS X+10", "TRANS DATUM RESET",
                                      "TRANS MIRROR AXIS X", "TRANS ROTATION ROT+30", "TRANS SCALE SCL0.9", "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+20"]))] + straight(0)
    text, moves, opt = made(["BEGIN PGM N MM", "TOOL CALL 1 Z S1000"], items, ["M30"], subs, {"shift": [0, 0, 0], "zero": [0, 0, 0], "back": []}, end=["END PGM N MM"], never=wide, **MILL)
    opt["gcode"] = {"offsets_mm": {f"preset {k}": v for k, v in zero.items()}}
    return {"n.h": text.encode()}, "n.h", moves, opt


def sinumerik_frames(seed):
    """SINUMERIK 840D sl Programming Manual Fundamentals 6FC5398-1BP40, Coordinate transformations (frames): TRANS and ROT stand in the place of all programmable frames, ATRANS and
    AROT add to them on the right; ROT of the plane by RPL. G54 … and G505 … stay below them, whatever comes first. SCALE and MIRROR are never read."""
    r = random.Random(f"frames sinumerik {seed}")
    zero = {g: xyz(r, 40, 5) for g in ("G54", "G55", "G56", "G505")}
    wide, n = r.random() < 0.25, [0]

    def move(p): return Leaf("G1 X%.3f Y%.3f Z%.3f F500" % tuple(p), lambda s: (None, fmul(fmul(shift(*zero[s["g"]]), s["frame"]), shift(*p))[1]))
    def change():
        kind, p, a = r.choice(("ATRANS", "ATRANS", "AROT", "AROT", "AROT", "TRANS", "ROT", "G")), xyz(r, 20, 4), round(r.uniform(-90, 90), 3)
        if kind == "G":
            g = r.choice(sorted(zero))
            return [Leaf(g, lambda s: s.update(g=g))]
        if kind[-3:] == "ROT": text, f = f"{kind} {r.choice(('Z', 'RPL='))}{a}", (rz(math.radians(a)), (0, 0, 0))
        else: text, f = kind + " X%.3f Y%.3f Z%.3f" % tuple(p), shift(*p)
        if r.random() < 0.1 and kind[0] != "A": text, f = kind, NULL
        return [Leaf(text, lambda s: s.update(frame=fmul(s["frame"], f) if kind[0] == "A" else f))]
    def level(depth):
        out = change() + [move(xyz(r, 40, 5))]
        if depth and r.random() < 0.85:
            body = level(depth - 1)
            if r.random() < 0.35 and depth < 4:
                n[0] += 1
                k = r.randint(1, 3)
                body = [Loop(f"FOR R{n[0]}=1 TO {k}", body, "ENDFOR", k)]
            out += body
        return out + [move(xyz(r, 40, 5))]
    items = [Leaf("G0 X0 Y0 Z50", lambda s: (None, tuple(zero["G54"][:2]) + (zero["G54"][2] + 50,)))] + level(6)
    if wide: items += [Leaf(r.choice(["MIRROR X0", "AMIRROR Y0", "SCALE X2", "ASCALE X1.5 Y1.5", "G58 X10", "G59 X5", "AROT X30", "ROTS X10 Y20", "AROTS Z10 X5", "CROTS Z10 X5", "CFINE(X,1)", "$P_PFRAME=CTRANS(X,10)",
                                      "$P_PFRAME=CTRANS(X,10):CROT(Z,45):CMIRROR(X):CSCALE(X,2)", "$P_UIFR[1]=CTRANS(X,10)", "TOFRAME", "TOROT", "PAROT", "CYCLE800(1,\"TC1\",0,57,0,0,0,10,20,0,0,0,0,1)",
                                      "G52 X10", "ROT RPL=30 X10"]))] + [move(xyz(r, 40, 5))]
    text, moves, opt = made(["G54 G17 G90 G71 G94"], items, ["M30"], [], {"frame": NULL, "g": "G54", "back": []}, never=wide, **MILL)
    opt["gcode"] = {"g54_mm": zero["G54"], "g55_mm": zero["G55"], "g56_mm": zero["G56"], "offsets_mm": {"G505": zero["G505"]}, "dialect": "sinumerik"}
    return {"n.mpf": text.encode()}, "n.mpf", moves, opt


def iso(seed):
    """FANUC Series 30i Operator's Manual B-63944EN: G52 moves the zero of all work coordinate systems, from that zero and not on from where it is; G68 X Y R turns about X, Y as
    programmed in it; polar coordinates are about the zero of the local system, and are turned as others are. G51, G51.1 and G50.1 are never read."""
    r = random.Random(f"frames iso {seed}")
    zero = {g: xyz(r, 40, 5) for g in ("G54", "G55", "G56")}
    wide, subs = r.random() < 0.2, []

    def place(s, p): return (None, tuple(a + b + c for a, b, c in zip(fmul(s["turn"], shift(*p))[1], s["local"], zero[s["g"]])))
    def move(g="G1"):
        p = xyz(r, 40, 5)
        return [Leaf(g + " X%.3f Y%.3f Z%.3f F500" % tuple(p), lambda s: place(s, p))]
    def polar():
        q, a, z = r.randint(5, 30), r.randint(-180, 180), xyz(r, 5)[2]
        return [Leaf("G16"), Leaf(f"G1 X{q} Y{a} Z{z} F500", lambda s: place(s, (q * math.cos(math.radians(a)), q * math.sin(math.radians(a)), z))), Leaf("G15")]
    def turned():
        c, a = xyz(r, 20), round(r.uniform(-170, 170), 3)
        def act(s): s["turn"] = fmul(fmul(shift(c[0], c[1], 0), (rz(math.radians(a)), (0, 0, 0))), shift(-c[0], -c[1], 0))
        def off(s): s["turn"] = NULL
        return [Leaf(f"G68 X{c[0]} Y{c[1]} R{a}", act)] + move() + (polar() if r.random() < 0.5 else []) + [Leaf("G69", off)] + move()
    def local():
        p = xyz(r, 20, 4)
        return [Leaf("G52 X%.3f Y%.3f Z%.3f" % tuple(p), lambda s: s.update(local=p))]
    def level(depth):
        g = r.choice(sorted(zero))
        out = (local() if r.random() < 0.6 else [Leaf(g, lambda s: s.update(g=g))]) + move()
        if r.random() < 0.5: out += turned()
        if depth:
            body = level(depth - 1)
            subs.append((f"O{100 + len(subs)}", body, "M99"))
            out += [Leaf(f"M98 P{99 + len(subs)}", sub=body)]
        return out + move()
    items = move("G0") + level(r.randint(1, 6))
    if wide: items += [Leaf(r.choice(["G51 X0 Y0 P2", "G51.1 X0", "G51 X0 Y0 Z0 I2 J1 K1", "G68 X0 Y0 R10\nG68 X5 Y5 R10", "G68 X0 Y0 Z0 I1 J0 K0 R10", "G68.4 X0 Y0 Z0 I0 J0 K0", "G54.2 P1", "G84.1 X0",
                                      "G68 X0 Y0 R10\nG52 X5"]))] + move()
    text, moves, opt = made(["%", "O0001", "G21 G17 G90 G94 G54"], items, ["M30"], subs, {"turn": NULL, "local": [0, 0, 0], "g": "G54", "back": []}, end=["%"], never=wide, **MILL)
    opt["gcode"] = {"dialect": "fanuc", **{g.lower() + "_mm": z for g, z in zero.items()}}
    return {"n.nc": text.encode()}, "n.nc", moves, opt


def planes(seed):
    """HEIDENHAIN TNC 640 User's Manual 892903, The PLANE function: SPATIAL, EULER and VECTOR about the datum in force, and PLANE RELATIV, which turns the plane in force about one of
    its own axes, here up to six in one another; coordinates are of the tip in it. One table of two axes."""
    r = random.Random(f"frames planes {seed}")
    import five_axis
    mach = r.choice([m for m in five_axis.machines() if "nutating" not in m.name])
    def move(g="F500"):
        p = xyz(r, 40, 10)
        p[2] += 20
        return [Leaf("L X%+.3f Y%+.3f Z%+.3f R0 %s" % (*p, g), lambda s: (Along(tuple(v[2] for v in s["frame"][0])), fmul(s["frame"], shift(*p))[1]))]
    def plane(kind):
        if kind == "SPATIAL":
            a = [round(r.uniform(-30, 30), 3) for _ in range(3)]
            text, R = "SPATIAL SPA%+.3f SPB%+.3f SPC%+.3f" % tuple(a), zyx(a[2], a[1], a[0])
        elif kind == "EULER":
            a = [round(r.uniform(-90, 90), 3), round(r.uniform(5, 40), 3), round(r.uniform(-90, 90), 3)]
            text, R = "EULER EULPR%+.3f EULNU%+.3f EULROT%+.3f" % tuple(a), mul(mul(rz(math.radians(a[0])), rx(math.radians(a[1]))), rz(math.radians(a[2])))
        else:
            k, a = r.randrange(3), round(r.uniform(-15, 15), 3)
            text, R = f"RELATIV SP{'ABC'[k]}{a:+.3f}", (rx, ry, rz)[k](math.radians(a))
        way = r.choice(["TURN FMAX", "TURN FMAX SEQ+", "TURN FMAX SEQ-", "MOVE FMAX DIST20"])
        def act(s): s["frame"] = fmul(s["frame"] if kind == "RELATIV" else shift(*s["shift"]), (R, (0, 0, 0)))
        return [Leaf(f"PLANE {text} {way}", act)]
    d = xyz(r, 20, 5)
    def datum(s): s["frame"], s["shift"] = shift(*d), d
    def off(s): s["frame"] = shift(*s["shift"])
    items = move("FMAX")
    if r.random() < 0.5: items += [Leaf("CYCL DEF 7.0 DATUM SHIFT"), Leaf("CYCL DEF 7.1 X%+.3f" % d[0]), Leaf("CYCL DEF 7.2 Y%+.3f" % d[1]), Leaf("CYCL DEF 7.3 Z%+.3f" % d[2], datum)] + move("FMAX")
    for _ in range(r.randint(1, 2)):
        items += plane(r.choice(["SPATIAL", "EULER", "RELATIV"])) + move("FMAX") + move()
        for _ in range(r.randint(0, 6)): items += plane("RELATIV") + move("FMAX") + move()
        items += [Leaf("PLANE RESET TURN FMAX", off)] + move("FMAX")
    text, moves, opt = made(["BEGIN PGM N MM", "TOOL CALL 1 Z S1000"], items, ["M30"], [], {"frame": NULL, "shift": (0, 0, 0), "back": []}, end=["END PGM N MM"], never=False, machine=five_axis.toml(mach), size=-0.2)
    return {"n.h": text.encode()}, "n.h", moves, opt


def fanuc_ls(seed):
    """FANUC R-30iB Operator's Manual (Basic Operation) B-83284EN, Setting coordinate systems: a user frame stands in the world, a tool frame in the flange, and a position is that of the
    tool frame in the user frame; W, P, R are about the fixed x, y, z. Offset, Tool_Offset, INC, PR and frames that the program sets are never read."""
    r = random.Random(f"frames ls {seed}")
    uf, ut = {0: (NULL, [0] * 3, [0] * 3)}, {}
    for k in range(1, 7): uf[k] = exact(r)
    for k in range(1, 4): a = xyz(r, 30); ut[k] = ((zyx(*a), (0, 0, 150)), [0, 0, 150], a)
    def va(name, frames): return f"[*SYSTEM*]{name}  Storage: SHADOW  Access: RW  : ARRAY[2,9] OF POSITION\n" + "".join(
        f"     [1,{k}] = \n  Group: 1   Config: N D B, 0, 0, 0\n  X:{p[0]:10.3f}   Y:{p[1]:10.3f}   Z:{p[2]:10.3f}\n  W:{a[2]:10.3f}   P:{a[1]:10.3f}   R:{a[0]:10.3f}\n" for k, (_, p, a) in frames.items() if k)
    wide, items, pos, now = r.random() < 0.25, [], [], [None, None]
    for i in range(r.randint(6, 14)):
        if not i or r.random() < 0.5: now = [r.choice(sorted(uf)), r.choice(sorted(ut))]; items += [Leaf(f"UFRAME_NUM={now[0]}"), Leaf(f"UTOOL_NUM={now[1]}")]
        U, T = uf[now[0]][0], ut[now[1]][0]
        want = fmul(finv(U), fmul(shift(*xyz(r, 60)), (mul(target(r)[0], T[0]), (0, 0, 0))))     # the tool points down, whatever the frames
        a, p = [round(v, 3) for v in to_zyx(want[0])], [round(v, 3) for v in want[1]]
        f = fmul(U, fmul((zyx(*a), tuple(p)), finv((T[0], (0, 0, 0)))))
        pos.append(f"P[{i + 1}]{{\n   GP1:\n\tUF : {now[0]}, UT : {now[1]},\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = {p[0]:9.3f}  mm,\tY = {p[1]:9.3f}  mm,\tZ = {p[2]:9.3f}  mm,\n\tW = {a[2]:9.3f} deg,\tP = {a[1]:9.3f} deg,\tR = {a[0]:9.3f} deg\n}};")
        def act(s, f=f, U=U):
            s.setdefault("first", U)
            return fmul(finv(s["first"]), f)
        how, more = "100% FINE" if not i else "20mm/sec FINE", ""
        if wide and i and (r.random() < 0.2 or len(pos) == 6):
            k = r.randrange(9)
            items += [[Leaf("PR[1]=P[1]"), Leaf("OFFSET CONDITION PR[1]")], [Leaf("UFRAME[1]=PR[1]")], [Leaf("UTOOL[1]=PR[1]")], [Leaf("PR[1]=UFRAME[1]:UFRAME[2]")], [Leaf("$MNUFRAME[1,1]=PR[1]")], [Leaf("P[1]=PR[1]:PR[2]")],
                      [], [Leaf("TOOL_OFFSET CONDITION PR[1]")], []][k]
            more = ["  Offset", "", "", "  Offset,PR[1]", "", "", "  INC", "  Tool_Offset", "  VOFFSET,VR[1]"][k]
        items.append(Leaf(f"{'J' if not i else 'L'} P[{i + 1}] {how}{more}    ", act))
    text, moves, opt = made(["/PROG  N", "/ATTR", "DEFAULT_GROUP\t= 1,*,*,*,*;", "/MN"], items, ["/POS"], [], {"back": []}, end=pos + ["/END"], never=wide and any(x in str([i.text for i in items]) for x in ("Offset", "INC", "PR[", "VOFFSET")), **ROBOT)
    n, lines = 0, []
    for x in text.split("\n"):
        if "/POS" in x: n = -99
        if "/MN" in lines and n >= 0: n += 1; x = f"{n:4}:{x};"
        lines.append(x)
    opt["toml"] = "[robot_program]\nignore_configuration = true\n"
    return {"n.ls": "\n".join(lines).encode(), "sysframe.va": (va("$MNUFRAME", uf) + va("$MNUTOOL", ut)).encode()}, "n.ls", moves, opt


def apt(seed):
    """ISO 4343 and APT (IBM APT-AC Numerical Control Processor Program Reference, SH20-1414): GOTO gives the tip and the axis from there to the spindle, GODLTA a step, in the unit in force; TLAXIS and
    CSYS behind TRNTYP/WORLD turn the axis of what follows. TRACUT, COPY, ORIGIN, REFSYS, ROTABL and a second MSYS move coordinates: never read."""
    r = random.Random(f"frames apt {seed}")
    wide, items = r.random() < 0.35, []
    state = {"unit": 1.0, "axis": (0.0, 0.0, 1.0), "at": None, "back": []}
    def goto(p, axis=None, step=False):
        def act(s):
            s["at"] = tuple(v * s["unit"] + (o if step else 0) for v, o in zip(p, s["at"] or (0, 0, 0)))
            if axis: s["axis"] = axis
            return s["axis"], s["at"]
        return Leaf(("GODLTA/" if step else "GOTO/") + ",".join(f"{v:.6f}" for v in (*p, *(axis or ()))), act)
    def up():
        R = mul(mul(rz(r.uniform(-3, 3)), rx(r.uniform(-0.7, 0.7))), rz(r.uniform(-3, 3)))
        return R, tuple(row[2] for row in R)
    items.append(Leaf("MULTAX/ON"))
    if r.random() < 0.5: items.append(Leaf("MSYS/10,20,30,1,0,0,0,1,0"))
    world = r.random() < 0.4
    if world: items.append(Leaf("TRNTYP/WORLD,0,0,0"))
    unit, out = 1.0, False
    for i in range(r.randint(8, 20)):
        x = r.random()
        if x < 0.15: unit = r.choice([1.0, 25.4]); items.append(Leaf("UNITS/" + ("MM" if unit == 1 else "INCHES"), lambda s, u=unit: s.update(unit=u)))
        elif x < 0.3: a = up()[1]; items.append(Leaf("TLAXIS/" + ",".join(f"{v:.9f}" for v in a), lambda s, a=a: s.update(axis=a)))
        elif x < 0.45 and world:
            R, a = up()
            items.append(Leaf("CSYS/" + ",".join(f"{v:.9f}" for row in R for v in (*row, r.uniform(-50, 50))), lambda s, a=a: s.update(axis=a)))
        elif x < 0.5: items.append(Leaf(r.choice(["MSYS/10.0,20.,30,1,0,0,0,1,0" if len(items) > 1 and items[1].text[0] == "M" else "TRACUT/NOMORE", "TRACUT/OFF", "ROTABL/OFF"])))
        elif x < 0.6 and wide: out = True; items.append(Leaf(r.choice(["M1=MATRIX/TRANSL,10,0,0\nTRACUT/M1", "TRACUT/1,0,0,10,0,1,0,0,0,0,1,0", "M1=MATRIX/XYROT,30\nM2=MATRIX/M1,M1\nTRACUT/M2", "COPY/1,TRANSL,10,0,0,3",
            "COPY/1,XYROT,30,5", "COPY/1,SAME,2", "INDEX/1", "INDEX/1,NOMORE", "ORIGIN/10,0,0", "REFSYS/M1", "ROTABL/30,CLW", "ROTHED/30", "TRANS/10,0,0", "MSYS/11,20,30,1,0,0,0,1,0\nMSYS/1,2,3,1,0,0,0,1,0",
            "CSYS/1,0,0,10,0,1,0,0,0,0,1\nCSYS/1,0,0,11,0,1,0,0,0,0,1", "CALL/MAC1", "TRNTYP/LOCAL", "ROTATE/HEAD,BAXIS,30", "TRANTO/10", "MCSYS/1,0,0,0,1,0\nMCSYS/2,0,0,0,1,0", "ZSURF/5", "LINTRN/1", "ROTTBL/30"])))
        p = [v / unit for v in xyz(r, 60)]
        items.append(goto([v / 6 for v in p], None, True) if i and r.random() < 0.2 else goto(p, up()[1] if r.random() < 0.5 else None))
    text, moves, opt = made(["PARTNO/N"], items, ["FINI"], [], state, never=wide and out, **ROBOT)
    return {"n.apt": text.encode()}, "n.apt", moves, opt


def rapid_frames(seed):
    """ABB RAPID reference manual 3HAC050917: Offs along the axes of the object, RelTool along those of the tool, turned by Rx, Ry, Rz about new axes; OrientZYX about z, the new y, the new x; a work
    object's oframe stands in its uframe. PDispOn, PDispSet, EOffsSet, PoseMult and their kin are never read."""
    r = random.Random(f"frames rapid {seed}")
    def q(R): return "[" + ",".join(f"{c:.12f}" for c in to_quat(R)) + "]"
    def pose(f): return "[[%.6f,%.6f,%.6f],%s]" % (*f[1], q(f[0]))
    def lit(f): return f"[{pose(f)[1:-1]},[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    u, o = frame(r), [frame(r), frame(r), frame(r)]
    tools = [NULL[0], frame(r)[0]]
    wide, subs = r.random() < 0.25, []
    data = [f'PERS wobjdata w{k}:=[FALSE,TRUE,"",{pose(u)},{pose(f)}];' for k, f in enumerate(o)] + [f"PERS tooldata t{k}:=[TRUE,[[0,0,150],{q(R)}],[1,[0,0,1],[1,0,0,0],0,0,0]];" for k, R in enumerate(tools)] + ["VAR robtarget q;"]
    def change():
        d = xyz(r, 15)
        if r.random() < 0.4: return lambda t: "Offs(%s,%.3f,%.3f,%.3f)" % (t, *d), lambda f: (f[0], tuple(a + b for a, b in zip(f[1], d)))
        w = {k: round(r.uniform(-20, 20), 3) if r.random() < 0.6 else 0 for k in ("Rx", "Ry", "Rz")}
        D = (mul(mul(rx(math.radians(w["Rx"])), ry(math.radians(w["Ry"]))), rz(math.radians(w["Rz"]))), tuple(d))
        return lambda t: "RelTool(%s,%.3f,%.3f,%.3f%s)" % (t, *d, "".join(f"\\{k}:={v}" for k, v in w.items() if v)), lambda f: fmul(f, D)
    def nested(name, depth):
        text, acts = name, []
        for _ in range(depth): t, a = change(); text = t(text); acts.append(a)
        def act(f):
            for a in acts: f = a(f)
            return f
        return text, act
    def move(name, kind="MoveL"):
        text, act = nested(name, r.randint(0, 6))
        w, t = (0, 0) if kind == "MoveJ" else (r.randrange(3), r.randrange(2))
        return Leaf(f"{kind} {text},v50,fine,t{t}\\WObj:=w{w};", lambda s: fmul(fmul(finv(o[0]), o[w]), fmul(act(s[name][-1]), (tr(tools[t]), (0, 0, 0)))))
    def assign(name):
        x = r.random()
        def trans(s): f = s[name].pop(); s[name].append((f[0], tuple(a + b for a, b in zip(f[1], d))))
        def rot(s): f = s[name].pop(); s[name].append((zyx(a[0], a[1] + 180, a[2]), f[1]))
        def call(s): s[name].append(act(s[name].pop()))
        d, a = xyz(r, 10), xyz(r, 20)
        if x < 0.2: return Leaf("%s.trans:=%s.trans+[%.3f,%.3f,%.3f];" % (name, name, *d), trans)
        if x < 0.35: return Leaf("%s.rot:=OrientZYX(%.3f,%.3f,%.3f);" % (name, a[0], a[1] + 180, a[2]), rot)
        text, act = nested(name, r.randint(1, 4))
        return Leaf(f"{name}:={text};", call)
    def level(depth, name):
        out = [assign("q"), move("q")] + ([move(name)] if name != "q" else [])
        if depth:
            k, n = len(subs), r.randint(1, 2)
            subs.append(None)
            body = level(depth - 1, "p")
            subs[k] = (f"PROC lay{k}(robtarget p)", body, "ENDPROC")
            text, act = nested(name, r.randint(0, 2))
            def go(s): s["p"].append(act(s[name][-1])); s["back"].append(s["p"].pop)
            call = Leaf(f"lay{k} {text};", go, body)
            out.append(Loop(f"FOR i FROM 1 TO {n} DO", [call], "ENDFOR", n) if r.random() < 0.4 else call)
        return out + [assign("q"), move(name)]
    first = target(r)
    first = (first[0], tuple(round(v, 6) for v in first[1]))
    def begin(s): s["q"] = [first]
    items = [Leaf(f"q:={lit(first)};", begin), move("q", "MoveJ")] + level(r.randint(1, 6), "q")
    if wide: items += [Leaf(r.choice(["PDispSet [[10,0,0],[1,0,0,0]];", "PDispOn q,t0;", "PDispOn \\Rot,q,t0\\WObj:=w1;", "PDispOn\\ExeP:=q,q,t0;", "EOffsSet [10,0,0,0,0,0];", "EOffsOn q;", "q:=CRobT();", "w0.oframe.trans.x:=5;",
        "w1.uframe:=[[0,0,0],[1,0,0,0]];", "t0.tframe.trans.x:=3;", "q.trans:=PoseVect([[1,2,3],[1,0,0,0]],q.trans);", "w1.oframe:=PoseMult(w1.oframe,w2.oframe);", "w1.oframe:=DefFrame(q,q,q);", "q:=ORobT(q);", "q:=MirPos(q,w1);",
        "CorrCon a;", "PDispSet PoseMult(w1.uframe,PoseInv(w2.uframe));", "w1:=w2;", "t0:=t1;"]))] + [move("q"), Leaf("MoveL q,v50,fine,t0\\WObj:=w1;")]
    # Moves that would leave the tool far from pointing down are as good: the arm has no limits of its wrist.
    text, moves, opt = made(["MODULE M"] + data + ["PROC main()"], items, ["ENDPROC"], subs, {"p": [], "back": []}, end=["ENDMODULE"], never=wide, **ROBOT)
    return {"m.mod": text.encode()}, "m.mod", moves, opt


def krl_frames(seed):
    """KUKA KSS 8.3 Operating and Programming Instructions for System Integrators, and KRL Reference Guide: A:B is B given in A; $BASE stands in $WORLD; A, B, C about z, the new y, the new x. INV_POS,
    EK and parts of $BASE are never read."""
    r = random.Random(f"frames krl {seed}")
    def lit(p, a): return "{X %.4f,Y %.4f,Z %.4f,A %.4f,B %.4f,C %.4f}" % (*p, *a)
    wide, subs, bases = r.random() < 0.2, [], {k: exact(r) for k in (1, 2, 3)}
    def nest(depth, s0):
        """Text and value, of frames that F1, F2, F3 have then."""
        if depth == 0 or r.random() < 0.2:
            if r.random() < 0.5: k = r.randint(1, 3); return f"F{k}", lambda s: s[k]
            f, p, a = exact(r, 25)
            return lit(p, a), lambda s: f
        (a, fa), (b, fb) = nest(depth - 1, s0), nest(depth - 1 if r.random() < 0.5 else 0, s0)
        b = f"({b})" if ":" in b else b
        return f"{a if r.random() < 0.5 or ':' not in a else '(' + a + ')'}:{b}", lambda s: fmul(fa(s), fb(s))
    def move():
        text, f = nest(r.randint(1, 6), None)
        return Leaf("LIN " + text, lambda s: put(s, f(s)))
    def put(s, f):
        s.setdefault("first", s["base"])
        s["at"] = fmul(s["base"], f)
        return fmul(finv(s["first"]), fmul(s["at"], (tr(s["tool"]), (0, 0, 0))))
    def assign():
        k = r.randint(1, 3)
        if r.random() < 0.5: text, f = nest(r.randint(1, 5), None)
        else:
            f0, p, a = exact(r, 20)
            text, f = f"F{k}:{lit(p, a)}", lambda s: fmul(s[k], f0)
        return Leaf(f"F{k}={text}", lambda s: s.update({k: f(s)}))
    def based():
        x = r.random()
        if x < 0.5: text, f = nest(r.randint(0, 3), None)
        elif x < 0.7: text, f = r.choice([("$NULLFRAME", lambda s: NULL), ("$WORLD", lambda s: NULL)])
        else:
            k, (f, p, a), deep = r.randint(1, 3), exact(r), r.random() < 0.5
            return [Leaf(f"$BASE=BASE_DATA[{k}]" + (":" + lit(p, a) if deep else ""), lambda s: s.update(base=fmul(bases[k][0], f) if deep else bases[k][0]))]
        return [Leaf("$BASE=" + text, lambda s: s.update(base=f(s)))]
    def tool(): a = xyz(r, 30); R = zyx(*a); return Leaf("$TOOL=" + lit((0, 0, 150), a), lambda s: s.update(tool=R))
    def rel(): d = xyz(r, 15); return Leaf("LIN_REL {X %.3f,Y %.3f,Z %.3f}" % tuple(d), lambda s: put(s, (fmul(finv(s["base"]), s["at"])[0], tuple(a + b for a, b in zip(fmul(finv(s["base"]), s["at"])[1], d)))))
    def level(depth):
        out = [assign(), move()]
        if r.random() < 0.4: out += based() + [move()]
        if r.random() < 0.2: out += [tool(), move()]
        if r.random() < 0.3: out.append(rel())
        if depth:
            body, n = level(depth - 1), r.randint(1, 2)
            if r.random() < 0.4 and depth < 4: out.append(Loop(f"FOR I{depth}=1 TO {n}", body, "ENDFOR", n))
            else: subs.append((f"DEF lay{len(subs)}()", body, "END")); out.append(Leaf(f"lay{len(subs) - 1}()", sub=body))
        return out + [move()]
    fs = {k: exact(r, 20) for k in (1, 2, 3)}
    start = (mul(target(r)[0], NULL[0]), (5.0, 6.0, 7.0))
    a = [round(v, 4) for v in to_zyx(start[0])]
    head = [Leaf(f"F{k}={lit(*fs[k][1:])}", lambda s, k=k: s.update({k: fs[k][0]})) for k in fs]
    items = head + [Leaf("$BASE=$NULLFRAME", lambda s: s.update(base=NULL))] + [tool()] + [Leaf(f"PTP {lit(start[1], a)}", lambda s: put(s, (zyx(*a), start[1])))] + level(r.randint(1, 6))
    if wide: items += [Leaf(r.choice(["F1=INV_POS(F1)", "$BASE=EK(F1,#ERSYS,F1)", "$BASE.X=5", "$TOOL.X=5", "$BASE=INV_POS(F1)", "F1=$POS_ACT", "F1=F1:$BASE", "$BASE=$ROBROOT", "$BASE_C=F1", "F1=MIRROR(F1)"])), Leaf("LIN F1"), Leaf("LIN_REL {X 1}"), Leaf("LIN F1:F1")]
    decl = ["DEF prog()", "DECL INT " + ",".join(f"I{k}" for k in range(7))]
    text, moves, opt = made(decl, items, ["END"], subs, {"back": []}, never=wide, **ROBOT)
    return {"prog.src": text.encode(), "prog.dat": b"DEFDAT prog\nDECL FRAME F1\nDECL FRAME F2\nDECL FRAME F3\nENDDAT\n",
            "$config.dat": ("DEFDAT $CONFIG PUBLIC\n" + "".join(f"BASE_DATA[{k}]={lit(*v[1:])}\n" for k, v in bases.items()) + "ENDDAT\n").encode()}, "prog.src", moves, opt


FRAMES = {"heidenhain": heidenhain, "sinumerik_frames": sinumerik_frames, "iso": iso, "planes": planes, "fanuc_ls": fanuc_ls, "apt": apt, "rapid_frames": rapid_frames, "krl_frames": krl_frames}


def passed(rows, moves, with_lines=True):
    """None, or the first move whose pose the points do not pass: 0.001 mm, 0.001 degrees."""
    i, at = 0, None
    here = lambda k: tuple(float(rows[k][c]) for c in ("x_mm", "y_mm", "z_mm"))
    for line, R, p in moves:
        is_line = lambda k: not with_lines or int(rows[k]["line"]) == line
        if at and check.gap(at[1], p) < 1e-7 and at[0] == R:        # no motion: a point or none
            i += i < len(rows) and is_line(i) and check.gap(here(i), p) < 1e-6
            continue
        at, best = (R, p), None
        while i < len(rows) and (is_line(i) or not best):
            e, turned = check.gap(here(i), p), 0.0
            if isinstance(R, tuple):
                S = mul(mul(rz(angle(rows[i], "C")), rx(angle(rows[i], "A"))), ry(angle(rows[i], "B")))
                z = tuple(-v[2] for v in S)
                turned = math.degrees(angle_between(R, S) if isinstance(R[0], tuple) else math.atan2(norm(cross(R, z)), dot(R, z)))
            if is_line(i) and (best is None or e + turned < best[0] + best[1]): best = (e, turned, here(i))
            i += 1
            if best and best[0] < 1e-3 and best[1] < 1e-3: break
        if not best: return f"line {line}: no point"
        if best[0] > 1e-3 or best[1] > 1e-3: return f"line {line}: expected {check.fmt(p)}, read {check.fmt(best[2])}: {best[0]:.4f} mm, {best[1]:.4f} degrees"
    return f"line {rows[i]['line']}: a point more" if i < len(rows) and with_lines else None


def angle(row, drive): return math.radians(float(row[f"rho_nominal_arm_{drive}_deg"]))


def corrected(text, moves, opt):
    """The moves that have to be written, as check.py, check_robots.py and check_five.py have them: what cuts is moved, rapid moves are not."""
    lines, out = text.splitlines(), []
    for n, R, p in moves:
        if not re.search(r"FMAX|\bG0\b|^J|:\s*J |^PTP|MoveJ", lines[n - 1]):
            if opt["size"] == "mill": p = tuple(a + b for a, b in zip(p, check.D))
            else: p = tuple(a + opt["size"] * b for a, b in zip(p, R.axis if isinstance(R, Along) else tuple(-v for v in R) if not isinstance(R[0], tuple) else tuple(v[2] for v in R)))
        out.append((n, R, p))
    return out


class Along:
    """The axis of an inclined plane, along which the machine's tool gives way; the angles are those that the control finds."""
    def __init__(self, axis): self.axis = axis
    def __eq__(self, other): return isinstance(other, Along) and check.gap(self.axis, other.axis) < 1e-12


def frames(binary, name, first, count, keep):
    total, reasons, wrong = collections.Counter(), collections.Counter(), []
    for seed in range(first, first + count):
        files, main_file, moves, opt = FRAMES[name](seed)
        text = files[main_file].decode()
        with tempfile.TemporaryDirectory() as w:
            def run(folder, force):
                """Compensates the program in `folder` and returns its points, or the error."""
                for k, v in {**({} if folder == "out2" else files), "machine.toml": opt["machine"].encode()}.items(): open(os.path.join(w, folder, k), "wb").write(v)
                gcode = "[sampling]\nmax_segment_mm = 1000.0\nmax_turn_deg = 90.0\n[gcode]\ndecimals_mm = 6\n" + "".join(f"{k} = {check.toml(v)}\n" for k, v in opt.get("gcode", {}).items())
                open(os.path.join(w, folder, "p.toml"), "w").write(check.PROCESS + force + gcode + opt.get("toml", ""))
                out = {"in": "out", "in2": "out2", "out2": "out3"}[folder]
                os.makedirs(os.path.join(w, out))
                p = subprocess.run([binary, "compensate", main_file, "--machine", "machine.toml", "--process", "p.toml", "--out", f"../{out}/{main_file}", "--force", "--method", "direct", "--progress", "none",
                                    "--points", "all"], cwd=os.path.join(w, folder), capture_output=True, text=True, errors="replace")
                points = os.path.join(w, out, main_file + ".points.csv")
                return (list(csv.DictReader(open(points))), "") if p.returncode in (0, 1) and os.path.exists(points) else (None, f"{p.returncode} {p.stderr}")
            os.makedirs(os.path.join(w, "in")); os.makedirs(os.path.join(w, "in2"))
            rows, error = run("in", "")
            told = None
            if rows is None:
                short, line = check.reason(error)
                reasons[("" if opt["never"] else "though it should be read: ") + short + (" | " + line[-150:] if "--verbose" in sys.argv else "")] += 1
                if error[0] != "2" or not re.search(re.escape(main_file) + r":\d+", line): told = "refused without its line: " + error[:200]
                elif not opt["never"]: total["of them what should be read"] += 1
                verdict = "refused"
            elif opt["never"]: told = "read, though it has what is never read"
            else:
                told = passed(rows, moves)
                if not told:
                    force = check_robots.FORCE if opt["size"] == 0.1 else check.FORCE if opt["size"] == "mill" else check.FORCE.replace("-0.0005", "0.0").replace("0.0003", "0.0")
                    rows, error = run("in2", force)
                    if rows is not None:
                        for k in files:
                            if not os.path.exists(os.path.join(w, "out2", k)): shutil.copy(os.path.join(w, "in", k), os.path.join(w, "out2", k))
                        rows, error = run("out2", "")
                    told = "with a force: " + (error[:300] if rows is None else passed(rows, corrected(text, moves, opt), False) or "")
                    told = None if told == "with a force: " else told
                verdict = "right"
            verdict = "WRONG" if told else verdict
            total[verdict] += 1
            total["moves"] += len(moves) if verdict == "right" else 0
            if told:
                wrong.append((seed, told))
                if keep: shutil.copytree(w, os.path.join(keep, f"{name}_{seed}"), dirs_exist_ok=True)
    print(f"{name}: {count} programs: {total['right']} right with {total['moves']} moves, {total['refused']} refused ({total['of them what should be read']} that should be read), {total['WRONG']} wrong")
    for k, n in reasons.most_common(): print(f"  {n:4} refused: {k}")
    for seed, told in wrong: print(f"  WRONG seed {seed}: {told}")
    return not wrong and total["right"]


def deep(binary):
    """20,000 levels: exit code 2 or the like and one error, within a minute; procedures of RAPID that each run once are read without levels."""
    n, tool = 20000, "PERS tooldata t1:=[TRUE,[[0,0,300],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n"
    programs = {
        "d.script": "def p():\n set_tcp(p[0,0,0.15,0,0,0])\n movel(" + "pose_trans(p[0,0,0.001,0,0,0], " * n + "p[0,0,0,0,3.14,0]" + ")" * n + ")\nend\n",
        "v.script": "def p():\n set_tcp(p[0,0,0.15,0,0,0])\n f0 = p[0,0,0,0,3.14,0]\n" + "".join(f" f{i} = pose_trans(p[0,0,0.001,0,0,0], f{i - 1})\n" for i in range(1, n)) + f" movel(f{n - 1})\nend\n",
        "b.script": "def p():\n movel(" + "(" * n + "p[0,0,0,0,3.14,0]" + ")" * n + ")\nend\n",
        "d.mod": "MODULE M\nPROC main()\nMoveL " + "Offs(" * n + "[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]" + ",0,0,1)" * n + ",v50,fine,tool0;\nENDPROC\nENDMODULE\n",
        "d.src": "DEF p()\n$BASE=$NULLFRAME\nLIN " + "{X 0,Y 0,Z 1,A 0,B 0,C 0}:(" * n + "{X 0,Y 0,Z 0,A 0,B 180,C 0}" + ")" * n + "\nEND\n",
        "d.mpf": "G71 G90 G0 X0 Y0 Z0\nG1 X=" + "(" * n + "1" + ")" * n + " F100\nM30\n",
        "frames.mod": "MODULE M\nVAR robtarget q:=[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nPROC main()\nMoveJ RelTool(" + "Offs(RelTool(" * (n // 2) + "q" + ",0,0,1\\Rz:=1),0,0,1)" * (n // 2)
        + ",0,0,0),v50,fine,tool0;\nENDPROC\nENDMODULE\n",
        "calls.mod": "MODULE M\n" + tool + "PROC main()\np0 1;\nENDPROC\n" + "".join(f"PROC p{i}(num a)\np{i + 1} a;\nENDPROC\n" for i in range(n)) + f"PROC p{n}(num a)\nMoveL [[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v50,fine,t1;\nENDPROC\nENDMODULE\n",
        "base.src": "DEF p()\n$BASE=" + "{X 0,Y 0,Z 1,A 0,B 0,C 0}:(" * n + "$NULLFRAME" + ")" * n + "\nLIN {X 0,Y 0,Z 0,A 0,B 180,C 0}\nEND\n",
        "calls.src": "DEF p()\nq0()\nEND\n" + "".join(f"DEF q{i}()\nq{i + 1}()\nEND\n" for i in range(n)) + f"DEF q{n}()\nLIN {{X 0,Y 0,Z 0,A 0,B 180,C 0}}\nEND\n",
        "calls.h": "BEGIN PGM D MM\nTOOL CALL 1 Z\nCALL LBL 1\nM30\n" + "".join(f"LBL {i}\nCYCL DEF 7.0\nCYCL DEF 7.1 IX+1\nCALL LBL {i + 1}\nLBL 0\n" for i in range(1, n)) + f"LBL {n}\nL X+1 Y+1 Z+1 F100\nLBL 0\nEND PGM D MM\n",
        "plane.h": "BEGIN PGM D MM\nTOOL CALL 1 Z\n" + "PLANE RELATIV SPA+1 TURN FMAX\n" * n + "L X+1 Y+1 Z+1 F100\nEND PGM D MM\n",
        "frames.mpf": "G71 G90 G0 X0 Y0 Z0\n" + "".join(f"FOR R{i % 99}=1 TO 1\nAROT Z1\n" for i in range(n)) + "G1 X1 F100\n" + "ENDFOR\n" * n + "M30\n",
        "calls.nc": "%\nO1\nG21 G90 G0 X0 Y0 Z0\nM98 P10\nM30\n" + "".join(f"O{i}\nG52 X{i}\nM98 P{i + 1}\nM99\n" for i in range(10, n)) + f"O{n}\nG1 X1 F100\nM99\n%\n",
        "d.ls": "/PROG D\n/MN\n   1:J P[1] 100% FINE;\n   2:L P[" + "R[" * n + "1" + "]" * n + "] 20mm/sec FINE;\n/POS\nP[1]{\n GP1:\n UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n X = 0 mm, Y = 0 mm, Z = 0 mm,\n W = 180 deg, P = 0 deg, R = 0 deg\n};\n/END\n",
        "if.ls": "/PROG D\n/MN\n   1:" + "IF (" * n + "1" + ")" * n + " THEN;\n/POS\n/END\n",
        "pr.ls": "/PROG D\n/MN\n   1:PR[1]=" + "(" * n + "PR[1]" + ":PR[2])" * n + ";\n   2:L PR[1] 20mm/sec FINE;\n/POS\n/END\n",
        "d.apt": "GOTO/" + "(POINT/" * n + "1,2,3" + ")" * n + "\nFINI\n",
        "m.apt": "M0=MATRIX/TRANSL,1,0,0\n" + "".join(f"M{i}=MATRIX/M{i - 1},M{i - 1}\n" for i in range(1, n)) + f"TRACUT/M{n - 1}\nGOTO/1,2,3\nFINI\n",
        "c.apt": "INDEX/1\n" * n + "GOTO/1,2,3\n" + "COPY/1,TRANSL,1,0,0,1\n" * n + "FINI\n",
        "d.h": "BEGIN PGM D MM\nQ1 = " + "(" * n + "1" + ")" * n + "\nL X+Q1 F100\nEND PGM D MM\n",
    }
    bad = 0
    with tempfile.TemporaryDirectory() as w:
        open(os.path.join(w, "machine.toml"), "w").write(check_robots.MACHINE)
        open(os.path.join(w, "p.toml"), "w").write(check_robots.PROCESS + check_robots.FORCE)
        for name, text in programs.items():
            open(os.path.join(w, name), "w").write(text)
            p = subprocess.run([binary, "compensate", name, "--machine", "machine.toml", "--process", "p.toml", "--out", "out_" + name], cwd=w, capture_output=True, text=True, errors="replace", timeout=120)
            said = next((x for x in p.stderr.splitlines() if x.startswith("error")), "")
            right = p.returncode in (1, 2) and said or name == "calls.mod" and p.returncode == 0
            bad += not right
            print("error" if said and right else "read" if right else "WRONG", name, p.returncode, (said or p.stderr.strip())[:160])
    return bad


def main():
    if "--deep" in sys.argv: sys.exit(1 if deep(os.path.abspath(sys.argv[1])) else 0)
    value = lambda name, other: sys.argv[sys.argv.index(name) + 1] if name in sys.argv else other
    dialect = value("--dialect", None)
    if dialect in FRAMES: sys.exit(0 if frames(os.path.abspath(sys.argv[1]), dialect, int(value("--from", 1)), int(value("--count", 20)), value("--keep", None)) else 1)
    importlib.import_module(dialect).generate = globals()[dialect]
    (check if dialect == "sinumerik" else check_robots).main()


if __name__ == "__main__":
    main()
