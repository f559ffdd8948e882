#!/usr/bin/env python3
"""python3 compositions.py KINETOSTAT --dialect urscript|rapid|krl|sinumerik --from SEED --count N [--keep FOLDER]
python3 compositions.py KINETOSTAT --deep

Random programs whose targets are compositions of frames, offsets and displacements, nested to six levels, judged by the interpreters of this folder as
check_robots.py and check.py do. What kinetostat refuses is counted by its reason. --deep: 20,000 levels are an error and no crash.
Needs ORC_SIMPLE unset. FANUC listings, APT and Heidenhain have none that kinetostat reads beside what check.py and check_robots.py generate.
"""
import importlib
import math
import os
import random
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import check
import check_robots
from robmath import NULL, finv, fmul, mul, rx, ry, rz, to_quat, to_rotvec, to_zyx, zyx

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


def deep(binary):
    """20,000 levels: exit code 2 or the like and one error, within a minute."""
    n = 20000
    programs = {
        "d.script": "def p():\n set_tcp(p[0,0,0.15,0,0,0])\n movel(" + "pose_trans(p[0,0,0.001,0,0,0], " * n + "p[0,0,0,0,3.14,0]" + ")" * n + ")\nend\n",
        "v.script": "def p():\n set_tcp(p[0,0,0.15,0,0,0])\n f0 = p[0,0,0,0,3.14,0]\n" + "".join(f" f{i} = pose_trans(p[0,0,0.001,0,0,0], f{i - 1})\n" for i in range(1, n)) + f" movel(f{n - 1})\nend\n",
        "b.script": "def p():\n movel(" + "(" * n + "p[0,0,0,0,3.14,0]" + ")" * n + ")\nend\n",
        "d.mod": "MODULE M\nPROC main()\nMoveL " + "Offs(" * n + "[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]" + ",0,0,1)" * n + ",v50,fine,tool0;\nENDPROC\nENDMODULE\n",
        "d.src": "DEF p()\n$BASE=$NULLFRAME\nLIN " + "{X 0,Y 0,Z 1,A 0,B 0,C 0}:(" * n + "{X 0,Y 0,Z 0,A 0,B 180,C 0}" + ")" * n + "\nEND\n",
        "d.mpf": "G71 G90 G0 X0 Y0 Z0\nG1 X=" + "(" * n + "1" + ")" * n + " F100\nM30\n",
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
            right = p.returncode in (1, 2) and said
            bad += not right
            print("error" if right else "WRONG", name, p.returncode, (said or p.stderr.strip())[:160])
    return bad


def main():
    if "--deep" in sys.argv: sys.exit(1 if deep(os.path.abspath(sys.argv[1])) else 0)
    dialect = sys.argv[sys.argv.index("--dialect") + 1]
    importlib.import_module(dialect).generate = globals()[dialect]
    (check if dialect == "sinumerik" else check_robots).main()


if __name__ == "__main__":
    main()
