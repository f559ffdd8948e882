"""Universal Robots URScript, as PolyScope 5 (and 10) reads it.

Manual: "The URScript Programming Language", pages of www.universal-robots.com/manuals/EN/HTML/SW5_25_1 and SW10_x, prod-scriptmanual (SM).
Looked up: poses are three metres and an axis-angle in radians (Module motion); movec: from where the robot is through pose_via (of which only
the position is used) to pose_to, r blends at pose_to, mode 0 turns the tool from here to there, mode 1 keeps it to the tangent (movec page);
pose_add adds positions and multiplies rotations, p_3.R = p_1.R * p_2.R (pose_add page and forum 19207); pose_trans(feature, p) is the frame
product, movel's pose is in the base (how-to 20115); joint lists are allowed where poses are, by forward kinematics.
Not looked up (as known): if/elif/else/while/end, positional order of arguments (movel(pose, a, v, t, r), movej(q, a, v, t, r), movep(pose, a, v,
r), movec(via, to, a, v, r, mode)), defaults (v 0.25), pose_inv, pose_sub, interpolate_pose, rpy2rotvec as Rz(rz) Ry(ry) Rx(rx), d2r, r2d, precedence,
`global`, and that a file that holds one def only runs it, and else its statements.
Left open, and not generated: the end orientation of movec in mode 1, movec through more than half a turn by movep blends, get_actual_tcp_pose while the
robot moves or after a stop in the cut, threads, feature variables of an installation (…_p, …_const), integer division.
"""
import copy
import math
import os
import random
import re
import sys

from move import Move, Refused
from robmath import (I3, NULL, RMove, add, app, circle, dist, finv, fmul, mul, rotvec, rx, ry, rz, sca, sub, to_rotvec, tr, zyx, to_zyx, UNREAD, selftest)

SIMPLE = bool(os.environ.get("ORC_SIMPLE"))
TOK = re.compile(r"""[ \t]*(?:
 (?P<num>(?:\d+\.\d*|\.\d+|\d+)(?:[eE][+-]?\d+)?)
|(?P<pose>p\[)
|(?P<name>[A-Za-z_]\w*)
|(?P<str>"[^"]*"|'[^']*')
|(?P<op>==|!=|<=|>=|[-+*/%()\[\],:=<>.])
)""", re.X)
IGNORE = {"set_payload", "set_payload_mass", "set_payload_cog", "set_gravity", "sleep", "sync", "textmsg", "popup", "set_digital_out", "set_standard_digital_out",
          "set_tool_digital_out", "set_analog_out", "set_standard_analog_out", "set_configurable_digital_out", "set_tool_voltage", "stopl", "stopj", "write_output_boolean_register",
          "set_target_payload", "set_safety_mode_transition_hardness", "modbus_set_output_signal", "set_flag", "set_tool_communication"}
ORDER = {"movel": ("pose", "a", "v", "t", "r"), "movej": ("q", "a", "v", "t", "r"), "movep": ("pose", "a", "v", "r"), "movec": ("pose_via", "pose_to", "a", "v", "r", "mode")}


class Pose(list):
    pass


class Flow(Exception):
    pass


class Break(Flow):
    pass


class Continue(Flow):
    pass


class Halt(Flow):
    pass


class Return(Flow):
    def __init__(self, v):
        self.v = v


class Ur:
    def __init__(self, files, main, options):
        self.main, self.options = main, options
        self.fn, self.ln, self.steps = main, 1, 0
        self.funcs, self.moves, self.at, self.tool, self.depth = {}, [], None, options.get("tool", I3), 0
        self.globals = {"pi": math.pi, "True": True, "False": False, "true": True, "false": False}
        text = files[main].decode("latin-1")
        self.lines = []
        for n, t in enumerate(re.split(r"\r\n|\n|\r", text), 1):
            t = self.cut(t).strip()
            if t:
                self.lines.append((n, t))
        self.pos = 0
        self.tree = self.block(())

    def no(self, why):
        raise Refused(self.fn, self.ln, why)

    def cut(self, t):
        q = None
        for i, c in enumerate(t):
            if q:
                q = None if c == q else q
            elif c in "\"'":
                q = c
            elif c == "#":
                return t[:i]
        return t

    def block(self, ends):
        out = []
        while self.pos < len(self.lines):
            n, t = self.lines[self.pos]
            self.ln = n
            w = re.match(r"\w*", t).group(0)
            if w in ends:
                return out
            self.pos += 1
            if w in ("def", "sec"):
                m = re.match(r"\w+\s+(\w+)\s*\((.*)\)\s*:\s*$", t) or self.no("not read: " + t)
                ps = [(a.split("=") + [None])[:2] for a in m.group(2).split(",") if a.strip()] if "[" not in m.group(2) else self.no("default values with brackets")
                body = self.block(("end",)); self.pos += 1
                out.append((n, "def", m.group(1), [(a.strip(), d) for a, d in ps], body))
            elif w == "thread":
                self.no("threads")
            elif w == "while":
                c = t[5:].rstrip()
                body = self.block(("end",)); self.pos += 1
                out.append((n, "while", c[:-1], body))
            elif w == "if":
                arms, other = [], []
                c = t[2:].rstrip()[:-1]
                while True:
                    b = self.block(("elif", "else", "end"))
                    arms.append((c, b)) if c is not None else other.extend(b)
                    u = self.lines[self.pos][1]; self.pos += 1
                    if u.startswith("elif"):
                        c = u[4:].rstrip()[:-1]
                    elif u.startswith("else"):
                        c = None
                    else:
                        break
                out.append((n, "if", arms, other))
            else:
                out.append((n, "line", t))
        if ends:
            self.no("no end of a block")
        return out

    # ---- expressions
    def toks(self, t):
        out, i = [], 0
        while i < len(t.rstrip()):
            m = TOK.match(t, i)
            if not m or m.end() == i:
                self.no("cannot read: " + t[i:i + 20])
            out.append((m.lastgroup, m.group(m.lastgroup)))
            i = m.end()
        return out

    def ev(self, t, env):
        ts = self.toks(t) if isinstance(t, str) else t
        v, i = self.x_or(ts, 0, env)
        if i != len(ts):
            self.no("left over: " + "".join(x[1] for x in ts[i:]))
        return v

    def x_or(self, ts, i, env):
        v, i = self.x_and(ts, i, env)
        while i < len(ts) and ts[i][1] in ("or", "xor"):
            o = ts[i][1]
            w, i = self.x_and(ts, i + 1, env)
            v = (v or w) if o == "or" else bool(v) != bool(w)
        return v, i

    def x_and(self, ts, i, env):
        v, i = self.x_not(ts, i, env)
        while i < len(ts) and ts[i][1] == "and":
            w, i = self.x_not(ts, i + 1, env)
            v = v and w
        return v, i

    def x_not(self, ts, i, env):
        if i < len(ts) and ts[i][1] == "not":
            v, i = self.x_not(ts, i + 1, env)
            return not v, i
        v, i = self.x_sum(ts, i, env)
        if i < len(ts) and ts[i][1] in ("==", "!=", "<", ">", "<=", ">="):
            o = ts[i][1]
            w, i = self.x_sum(ts, i + 1, env)
            v = {"==": lambda: v == w, "!=": lambda: v != w, "<": lambda: v < w, ">": lambda: v > w, "<=": lambda: v <= w, ">=": lambda: v >= w}[o]()
        return v, i

    def x_sum(self, ts, i, env):
        v, i = self.x_mul(ts, i, env)
        while i < len(ts) and ts[i][1] in ("+", "-"):
            o = ts[i][1]
            w, i = self.x_mul(ts, i + 1, env)
            if isinstance(v, list) or isinstance(w, list):
                self.no("lists added")
            v = v + w if o == "+" else v - w
        return v, i

    def x_mul(self, ts, i, env):
        v, i = self.x_un(ts, i, env)
        while i < len(ts) and ts[i][1] in ("*", "/", "%"):
            o = ts[i][1]
            w, i = self.x_un(ts, i + 1, env)
            if isinstance(v, list) or isinstance(w, list):
                self.no("lists multiplied")
            if o == "/" and isinstance(v, int) and isinstance(w, int) and v % w:
                self.no("a whole number divided by one: not followed")
            v = v * w if o == "*" else v / w if o == "/" else math.fmod(v, w)
        return v, i

    def x_un(self, ts, i, env):
        if i >= len(ts):
            self.no("ends early")
        if ts[i][1] == "-":
            v, i = self.x_un(ts, i + 1, env)
            return -v, i
        if ts[i][1] == "+":
            return self.x_un(ts, i + 1, env)
        return self.x_prim(ts, i, env)

    def items(self, ts, i, env, end):
        out = []
        while ts[i][1] != end:
            v, i = self.x_or(ts, i, env)
            out.append(v)
            if ts[i][1] == ",":
                i += 1
            elif ts[i][1] != end:
                self.no("expected , or " + end)
        return out, i + 1

    def x_prim(self, ts, i, env):
        k, x = ts[i]
        if k == "num":
            v, i = (float(x) if re.search(r"[.eE]", x) else int(x)), i + 1
        elif k == "str":
            v, i = x[1:-1], i + 1
        elif k == "pose":
            v, i = self.items(ts, i + 1, env, "]")
            v = Pose(float(c) for c in v)
        elif x == "[":
            v, i = self.items(ts, i + 1, env, "]")
        elif x == "(":
            v, i = self.x_or(ts, i + 1, env)
            if ts[i][1] != ")":
                self.no("expected )")
            i += 1
        elif k == "name":
            if i + 1 < len(ts) and ts[i + 1][1] == "(":
                args, kw, i = [], {}, i + 2
                while ts[i][1] != ")":
                    n = None
                    if ts[i][0] == "name" and ts[i + 1][1] == "=":
                        n, i = ts[i][1], i + 2
                    v, i = self.x_or(ts, i, env)
                    if n:
                        kw[n] = v
                    else:
                        args.append(v)
                    if ts[i][1] == ",":
                        i += 1
                v, i = self.func(x, args, kw, env), i + 1
            else:
                v = env[x] if x in env else self.globals.get(x)
                if v is None:
                    self.no(f"{x} has no value")
                i += 1
        else:
            self.no("unexpected " + x)
        while i < len(ts) and ts[i][1] == "[":
            n, i = self.x_or(ts, i + 1, env)
            v, i = v[int(n)], i + 1
        return v, i

    def fr(self, p):
        if not isinstance(p, Pose) or len(p) != 6:
            self.no("no pose")
        return (rotvec(tuple(p[3:])), tuple(p[:3]))

    def pose(self, f):
        return Pose(list(f[1]) + list(to_rotvec(f[0])))

    def func(self, n, a, kw, env):
        if n in ORDER:
            return self.move(n, a, kw)
        if n in IGNORE:
            return None
        if n == "set_tcp":
            self.tool = self.fr(a[0])[0] if isinstance(a[0], Pose) else self.no("set_tcp")
            if self.at is not None:
                # the pose of the new tool is not that of the old one (SM set_tcp): known again after the next move with a pose
                self.at = None
            return None
        if n == "pose_trans":
            return self.pose(fmul(self.fr(a[0]), self.fr(a[1])))
        if n == "pose_inv":
            return self.pose(finv(self.fr(a[0])))
        if n == "pose_add":
            f, g = self.fr(a[0]), self.fr(a[1])
            return self.pose((mul(f[0], g[0]), add(f[1], g[1])))
        if n == "pose_sub":
            self.no("pose_sub: not followed")
        if n == "interpolate_pose":
            f, g = self.fr(a[0]), self.fr(a[1])
            v = to_rotvec(mul(tr(f[0]), g[0]))
            return self.pose((mul(f[0], rotvec(sca(a[2], v))), add(f[1], sca(a[2], sub(g[1], f[1])))))
        if n in ("get_actual_tcp_pose", "get_target_tcp_pose", "get_forward_kin"):
            self.no(n + ": where the robot is")
        if n in ("sin", "cos", "tan", "asin", "acos", "atan", "sqrt", "exp", "floor", "ceil"):
            return getattr(math, n)(a[0])
        if n == "atan2":
            return math.atan2(a[0], a[1])
        if n == "pow":
            return a[0] ** a[1]
        if n == "d2r":
            return math.radians(a[0])
        if n == "r2d":
            return math.degrees(a[0])
        if n == "rpy2rotvec":
            v = a[0] if isinstance(a[0], list) else a
            return list(to_rotvec(mul(mul(rz(v[2]), ry(v[1])), rx(v[0]))))
        if n == "length":
            return len(a[0])
        if n == "norm":
            return abs(a[0]) if not isinstance(a[0], list) else math.sqrt(sum(c * c for c in a[0]))
        if n == "point_dist":
            return dist(a[0][:3], a[1][:3])
        if n == "to_num":
            return float(a[0])
        if n not in self.funcs:
            self.no(f"function {n} is not in the file")
        ps, body = self.funcs[n]
        loc = {}
        for k, (name, d) in enumerate(ps):
            if k < len(a):
                loc[name] = copy.deepcopy(a[k])
            elif name in kw:
                loc[name] = kw[name]
            elif d is not None:
                loc[name] = self.ev(d, {})
            else:
                self.no("too few arguments")
        self.depth += 1
        if self.depth > 50:
            self.no("calls too deep")
        ln = self.ln
        try:
            self.run(body, loc)
            r = None
        except Return as x:
            r = x.v
        self.depth -= 1
        self.ln = ln
        return r

    def move(self, n, a, kw):
        d = dict(zip(ORDER[n], a))
        if "pose" in kw and n == "movej":
            kw["q"] = kw.pop("pose")
        d.update(kw)
        t = d[ORDER[n][1] if n == "movec" else ORDER[n][0]]
        zone = 1000.0 * float(d.get("r", 0))
        feed = float(d.get("v", 0.25)) * 60000 if not d.get("t") else None
        if not isinstance(t, Pose):
            if n != "movej":
                self.no("joints as the target of a path")
            self.at = None
            self.moves.append(RMove("joint", self.fn, self.ln, None, joints=tuple(float(v) for v in t), zone=zone))
            return
        R, p = self.fr(t)
        p = sca(1000.0, p)
        start = self.at
        kind = {"movej": "rapid", "movec": "arc"}.get(n, "line")
        c = turn = via = None
        if kind == "arc":
            if start is None:
                self.no("an arc whose start is not known")
            if not isinstance(d["pose_via"], Pose):
                self.no("joints on an arc")
            via = sca(1000.0, tuple(d["pose_via"][:3]))
            q = circle(start[1], via, p)
            if q is None:
                self.no("an arc through points in line")
            c, turn = q[0], sca(q[3], q[2])
            if d.get("mode", 0) == 1:
                # fixed to the tangent: what the tool turns to at the end is the start turned by the arc (SM movec)
                R = mul(rotvec(turn), start[0])
        self.moves.append(RMove(kind, self.fn, self.ln, p, R, c, turn, None if kind == "rapid" else feed, via, start and start[1], zone, self.tool))
        self.at = (R, p)

    # ---- statements
    def run(self, body, env):
        for s in body:
            self.ln = s[0]
            self.steps += 1
            if self.steps > 100000:
                self.no("does not end")
            if s[1] == "def":
                self.funcs[s[2]] = (s[3], s[4])
            elif s[1] == "while":
                while self.ev(s[2], env):
                    self.steps += 1
                    if self.steps > 100000:
                        self.no("does not end")
                    try:
                        self.run(s[3], env)
                    except Break:
                        break
                    except Continue:
                        pass
                    self.ln = s[0]
            elif s[1] == "if":
                for c, b in s[2]:
                    if self.ev(c, env):
                        self.run(b, env)
                        break
                else:
                    self.run(s[3], env)
            else:
                self.line(s[2], env)

    def line(self, t, env):
        w = re.match(r"\w*", t).group(0)
        if w == "break":
            raise Break()
        if w == "continue":
            raise Continue()
        if w == "halt":
            raise Halt()
        if w == "return":
            raise Return(self.ev(t[6:], env) if t[6:].strip() else None)
        if w == "pass":
            return
        if w in ("run", "join", "kill", "enter_critical", "exit_critical"):
            self.no("threads")
        m = re.match(r"(?:(global|local)\s+)?([A-Za-z_]\w*)\s*(\[[^=\]]*\])?\s*=(?!=)\s*(.+)$", t)
        if m:
            v = copy.deepcopy(self.ev(m.group(4), env))
            n = m.group(2)
            if m.group(3):
                box = env[n] if n in env else self.globals.get(n)
                if box is None:
                    self.no(n + " has no value")
                box[int(self.ev(m.group(3)[1:-1], env))] = v
            elif m.group(1) == "global":
                self.globals[n] = v
            elif m.group(1) == "local" or n not in self.globals:
                env[n] = v
            else:
                self.globals[n] = v
            return
        self.ev(t, env)


def trace(files, main, options):
    u = Ur(files, main, options)
    try:
        defs = [s for s in u.tree if s[1] == "def"]
        if len(defs) == len(u.tree):
            if len(defs) != 1:
                raise Refused(main, 1, "several def and no statement")
            u.run(u.tree, {})
            u.func(defs[0][2], [], {}, {})
        else:
            u.run(u.tree, u.globals)
    except Halt:
        pass
    except Flow:
        u.no("break or return outside")
    except UNREAD as e:
        raise Refused(u.fn, u.ln, f"not read ({type(e).__name__}: {e})")
    return u.moves


def run(files, main, options):
    return [m for m in trace(files, main, options) if m.end is not None]


# ---- random programs
def generate(seed):
    r = random.Random(f"ur{seed}")
    for _ in range(60):
        files, main, opt = Gen(r).make()
        try:
            run(files, main, opt)
        except Refused as e:       # three points that rounding put in line
            if "in line" in e.why:
                continue
            raise
        mv = run(files, main, opt)
        if len(mv) >= 5 and files[main].count(b"\n") <= 75 and all(max(abs(c) for c in m.end) <= 300 for m in mv) and \
                all(m.kind != "arc" or dist(m.start, m.centre) >= 1 for m in mv) and any(m.kind != "rapid" for m in mv):
            return files, main, opt
    raise AssertionError(seed)


class Gen:
    def __init__(self, r):
        self.r, self.dec = r, r.choice([3, 4, 5, 6])
        self.ind = r.choice(["  ", "  ", "    ", "\t", ""])
        self.rot = r.choice([(0, math.pi, 0), (math.pi, 0, 0), (2.2214, -2.2214, 0), (0, 3.1416, 0), tuple(r.uniform(-.3, .3) + b for b in (0, 3.0, 0)),
                             (r.uniform(-2, 2), r.uniform(-2, 2), r.uniform(-1, 1))])
        self.vary = r.random() < .25      # the tool turns along the path
        self.rd = r.choice([4, 5, 6])
        self.safe = 50.0
        self.out, self.defs, self.have, self.head = [], [], set(), []
        self.n = 0
        self.feat = not SIMPLE and r.random() < .3
        self.named = r.random() < .6
        self.cur = None

    def f(self, mm):
        return f"{mm / 1000:.{self.dec}f}" if self.r.random() < .8 else f"{round(mm / 1000, self.dec):g}"

    def rnd(self, a, b):
        return round(self.r.uniform(a, b), max(0, self.dec - 3))

    def xy(self):
        return self.rnd(-90, 90), self.rnd(-90, 90)

    def z(self):
        return self.rnd(-15, 4)

    def lit(self, p, rot=None):
        rot = rot or self.rot
        sep = self.r.choice([",", ", "])
        return "p[" + sep.join([self.f(c) for c in p] + [f"{c:.{self.rd}f}" if self.r.random() < .8 and c else f"{round(c, self.rd):g}" for c in rot]) + "]"

    def tgt(self, p):
        x = self.r.random()
        if x < .25:
            self.n += 1
            n = f"{self.r.choice(['p_', 'wp', 'Point_'])}{self.n}"
            self.put(f"{self.r.choice(['', '', 'global ', 'local '])}{n} = {self.lit(p)}" if self.r.random() < .5 else f"{n}={self.lit(p)}")
            t = n
        else:
            t = self.lit(p)
        if self.feat:
            t = f"pose_trans(part, {t})"
        return t

    def tail(self, n="movel"):
        r = self.r
        v, a, b = r.choice(["0.02", "0.015", "0.05", "v_cut"]), r.choice(["1.2", "0.5", "acc"]), r.choice(["", "", "0.001", "0.0005", "0.002"])
        for k in (v, a):
            if k in ("v_cut", "acc") and k not in self.have:
                self.have.add(k)
                self.head.append({"v_cut": "v_cut = 0.03", "acc": "global acc=0.8"}[k])
        if self.named:
            s = f", a={a}, v={v}" if r.random() < .5 else f",a={a},v={v}"
            if b:
                s += f", r={b}"
        elif n in ("movep", "movec"):
            s = f", {a}, {v}" + (f", {b}" if b else "")
        else:
            s = f", {a}, {v}" + (f", 0, {b}" if b else "")
        return s

    def put(self, t, d=1):
        self.out.append(self.ind * d + t)

    def turn(self):
        if self.vary and self.r.random() < .4:
            self.rot = tuple(c + self.r.uniform(-.2, .2) for c in self.rot)

    def lin(self, p, d=1):
        self.turn()
        n = "movel" if self.r.random() < .8 else "movep"
        t = self.tgt(p)
        self.put(f"{n}({t}{self.tail(n)})", d)
        self.cur = p

    def rapid(self, p):
        t = self.tgt(p)
        self.put(f"movej({t}, a=1.4, v=1.05)" if self.named else f"movej({t}, 1.4, 1.05)")
        self.cur = p

    def arc(self):
        x, y, z = self.cur
        rad, a0 = self.r.uniform(4, 30), self.r.uniform(0, 6.28)
        sw = self.r.choice([-1, 1]) * self.r.uniform(.6, 4.0)
        cx, cy = x - rad * math.cos(a0), y - rad * math.sin(a0)
        k = max(0, self.dec - 3)
        g = lambda s: (round(cx + rad * math.cos(a0 + s), k), round(cy + rad * math.sin(a0 + s), k), z)
        a, b = g(sw / 2), g(sw)
        if dist(a, b) < 2 or dist(self.cur, a) < 2:
            return
        self.turn()
        t1, t2 = self.tgt(a), self.tgt(b)
        s = self.tail("movec")
        if self.r.random() < .3:
            s += ", mode=0" if self.named else ""
        self.put(f"movec({t1}, {t2}{s})")
        self.cur = b

    def op(self):
        r = self.r
        k = r.choice(["lin"] * 3 + ["arc"] * 2 + ["trans", "add", "while", "while", "if", "def", "deff", "misc", "misc", "retract", "joint", "index", "list", "interp"])
        if SIMPLE:
            k = r.choice(["lin", "lin", "arc", "misc", "retract", "joint"])
        z = self.z()
        if k == "lin":
            for _ in range(r.randint(1, 3)):
                self.lin((*self.xy(), z))
        elif k == "arc":
            self.arc()
        elif k == "trans":
            p = (*self.xy(), z)
            t = self.tgt(p)
            self.put(f"movel(pose_trans({t}, p[0.005, {self.f(self.rnd(-9, 9))}, -0.001, 0, 0, {r.choice(['0', '0.2', 'd2r(10)'])}]){self.tail()})")
            self.lin((*self.xy(), z))
        elif k == "add":
            t = self.tgt((*self.xy(), z))
            self.put(f"movel(pose_add({t}, p[{self.f(self.rnd(-9, 9))}, 0.002, 0, 0, 0, {r.choice(['0', '0', '0.1'])}]){self.tail()})")
            self.lin((*self.xy(), z))
        elif k == "while":
            i = r.choice(["i", "count"])
            self.put(f"{i} = 0")
            t = self.lit((self.rnd(-40, 20), self.rnd(-40, 20), z))
            self.put(f"base_p = {t}")
            self.put(f"while {r.choice([f'{i} < 3', f'({i} < 3)', f'{i} <= 2 and True'])}:")
            self.put("q_p = base_p", 2)
            self.put(f"q_p[1] = base_p[1] + {i} * 0.004", 2)
            self.put(f"movel(q_p{self.tail()})", 2)
            self.put(f"q_p[0] = q_p[0] + {self.f(self.rnd(10, 30))}", 2)
            self.put(f"movel(q_p{self.tail()})", 2)
            if r.random() < .25:
                self.put(f"if {i} == 1:", 2)
                self.put("break", 3)
                self.put("end", 2)
            self.put(f"{i} = {i} + 1", 2)
            self.put("end")
            self.lin((*self.xy(), z))
        elif k == "if":
            self.put(f"mode_sel = {r.randint(0, 2)}")
            self.put("if mode_sel == 0:" if r.random() < .5 else "if (mode_sel == 0):")
            self.put(f"movel({self.lit((*self.xy(), z))}{self.tail()})", 2)
            if r.random() < .5:
                self.put("elif mode_sel > 1 and not (mode_sel == 3):")
                self.put(f"movel({self.lit((*self.xy(), z))}{self.tail()})", 2)
            self.put("else:")
            self.put(f"movel({self.lit((*self.xy(), z))}{self.tail()})", 2)
            self.put("end")
            self.lin((*self.xy(), z))
        elif k == "def" and "slot" not in self.have:
            self.have.add("slot")
            self.defs.append(["def slot(pos, len):", "movel(pos, a=1.2, v=0.02)", "movel(pose_trans(pos, p[len, 0, 0, 0, 0, 0]), a=1.2, v=0.02)",
                              "movel(pose_add(pos, p[0, 0, 0.001, 0, 0, 0]), a=1.2, v=0.02, r=0)", "end"])
            for _ in range(r.randint(1, 2)):
                self.put(f"slot({self.tgt((*self.xy(), z))}, {self.f(self.rnd(5, 30))})")
            self.lin((*self.xy(), z))
        elif k == "deff" and "on_circle" not in self.have:
            self.have.add("on_circle")
            self.defs.append(["def on_circle(ang):", "local rad = 0.012", f"return p[rad*cos(d2r(ang)), rad*sin(d2r(ang)), {self.f(z)}, {', '.join(f'{c:.{self.rd}f}' for c in self.rot)}]", "end"])
            for a in (0, 50, 120):
                self.put(f"movel(on_circle({a}){self.tail()})")
            self.lin((*self.xy(), z))
        elif k == "misc":
            self.put(r.choice(["# cut", "sleep(0.2)", "set_digital_out(2, True)", 'textmsg("pass")', "sync()", "set_standard_digital_out(0,False)", "", "set_payload(1.5)"]))
        elif k == "retract":
            self.lin((self.cur[0], self.cur[1], self.safe))
            p = (*self.xy(), self.safe)
            self.rapid(p)
            self.lin((p[0], p[1], z))
        elif k == "joint":
            self.lin((self.cur[0], self.cur[1], self.safe))
            self.put(r.choice(["movej([0.0,-1.57,1.57,-1.57,-1.57,0.0], a=1.4, v=1.05)", "movej([0, -1.2, 1.4, -1.7, -1.5, 0.1])"]))
            p = (*self.xy(), self.safe)
            self.rapid(p)
            self.lin((p[0], p[1], z))
        elif k == "index":
            self.put(f"w_p = {self.lit((*self.xy(), z))}")
            self.put(f"w_p[2] = w_p[2] - {r.choice(['0.001', '1/1000.0'])}")
            self.put(f"movel(w_p{self.tail()})")
            self.lin((*self.xy(), z))
        elif k == "list" and "pts" not in self.have:
            self.have.add("pts")
            self.put("pts = [" + ", ".join(self.lit((*self.xy(), z)) for _ in range(3)) + "]")
            self.put("k = 0")
            self.put("while k < length(pts):")
            self.put(f"movel(pts[k]{self.tail()})", 2)
            self.put("k = k + 1", 2)
            self.put("end")
            self.lin((*self.xy(), z))
        elif k == "interp":
            self.put(f"movel(interpolate_pose({self.lit((*self.xy(), z))}, {self.lit((*self.xy(), z))}, 0.25){self.tail()})")
            self.lin((*self.xy(), z))

    def make(self):
        r = self.r
        tip = r.choice([(0, 0, 150), (0, 12, 201.5)])
        trot = (0, 0, 0) if SIMPLE or r.random() < .7 else (0, 1.5708, 0)
        self.head.append("set_tcp(p[" + ", ".join(f"{v / 1000:g}" for v in tip) + ", " + ", ".join(f"{v:g}" for v in trot) + "])")
        if self.feat:
            self.head.append(f"part = p[0.02, -0.03, 0.01, 0, 0, {r.choice(['0', '0.3', '1.5708'])}]")
        start = (*self.xy(), self.safe)
        if r.random() < .3:
            self.put("movej([0.0, -1.57, 1.57, -1.57, -1.57, 0.0], a=1.4, v=1.05)")
        self.rapid(start)
        self.lin((start[0], start[1], self.z()))
        target = r.randint(12, 34)
        while len(self.out) < target:
            self.op()
        self.lin((self.cur[0], self.cur[1], self.safe))
        name = r.choice(["Prog", "mill_part", "program_1"])
        body = [self.ind + x for x in self.head] + self.out
        defs = [self.ind * 1 + x if x.startswith("def") or x == "end" else self.ind * 2 + x for d in self.defs for x in d]
        style = r.random()
        if style < .55:
            lines = [f"def {name}():"] + defs + body + ["end"] + ([f"{name}()"] if r.random() < .5 else [])
        elif style < .8:
            top = [x if x.startswith("def") or x == "end" else self.ind + x for d in self.defs for x in d]
            lines = ["# posted"] + top + [f"def {name}():"] + body + ["end", "", f"{name}()"]
        else:
            top = [x if x.startswith("def") or x == "end" else self.ind + x for d in self.defs for x in d]
            strip = len(self.ind)
            lines = top + [x[strip:] for x in body]
            if any(x.startswith("local ") for x in lines):
                lines = [x.replace("local ", "") if not x.startswith((" ", "\t")) else x for x in lines]
        nl = r.choice(["\n", "\n", "\r\n"])
        f = name + r.choice([".script", ".script", ".urscript"])
        return {f: (nl.join(lines) + nl).encode()}, f, {"tip": tip, "gcode": {"decimals_mm": 6}}


HAND = [
    ("poses", "def p1():\n set_tcp(p[0,0,0.1,0,0,0])\n movej(p[0.01,0.02,0.05,0,0,1.5707963267948966])\n movel(pose_trans(p[0.01,0,0,0,0,1.5707963267948966],p[0.005,0,0,0,0,0]),1.2,0.02,0,0.001)\n"
              " movel(pose_add(p[0.01,0,0,0,0,1.5707963267948966],p[0.005,0,0,0,0,0]))\n a=[p[0.1,0,0,0,0,0],p[0,0.1,0,0,0,0]]\n i=0\n while i<2:\n  movep(a[i],v=0.1)\n  i=i+1\n end\nend\n",
     [(10, 20, 50), (10, 5, 0), (15, 0, 0), (100, 0, 0), (0, 100, 0)]),
    ("arc", "def q(x, y):\n return p[x,y,0,0,0,0]\nend\nmovej(q(0.01,0))\nmovec(q(0,0.01),q(-0.01,0),a=1,v=0.1)\nif False:\n movel(q(1,1))\nelif 2>1:\n movel(q(0.003,0.004))\nelse:\n halt\nend\n",
     [(10, 0, 0), (-10, 0, 0), (3, 4, 0)]),
]


if __name__ == "__main__":
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    selftest("urscript", [(name, {"h.script": text.encode()}, "h.script", want) for name, text, want in HAND], run, generate, n)
