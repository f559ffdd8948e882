"""ABB RAPID, as RobotWare 6 and 7 read it.

Manuals: "Technical reference manual: RAPID Instructions, Functions and Data types", 3HAC050917 (IFD), "RAPID Overview" 3HAC050947 (OV).
Looked up (stored pages of the RAPID Reference Manual, yumpu 5679047, pages 130, 226, 234, 359): a tool's frame is in the wrist's frame, of
a standing tool in the world; a work object's user frame is in the world, in the wrist's frame with a standing tool, its object frame in
the user frame; roles are reversed with a standing tool; of MoveC the orientation at the circle point is not used for the path; without
\\WObj a position is in the world. PoseMult as frame product (industrialmonitordirect.com abb-rapid-tcp-offset).
Not looked up (as known): syntax of IF/FOR/WHILE/TEST/GOTO, FOR counts down without STEP if the end is lower, precedence, DIV and MOD, Offs in
the object's frame, RelTool (displacement and Rx, Ry, Rz in this order about new axes, in the tool's frame), EulerZYX and OrientZYX, PDispSet
between object and target, MoveL's arguments in order, names without regard to case, quaternions taken as normalised.
Left open, and not generated: MoveC with ends that go back on the arc, PDispOn, ConfL, quaternions off 1 by more than rounding.
"""
import copy
import math
import os
import random
import re
import sys

from move import Move, Refused
from robmath import (NULL, RMove, add, app, circle, dist, finv, fmul, mul, quat, rx, ry, rz, sca, sub, to_quat, zyx, to_zyx, UNREAD, selftest)

SIMPLE = bool(os.environ.get("ORC_SIMPLE"))
TOK = re.compile(r"""
 (?P<num>(?:\d+\.\d*|\.\d+|\d+)(?:[eE][+-]?\d+)?)
|(?P<name>[A-Za-z]\w*)
|(?P<str>"(?:[^"]|"")*")
|(?P<op>:=|<>|<=|>=|[-+*/\\(){}\[\],;:=<>.?])
""", re.X)
FIELDS = {"trans": 0, "rot": 1, "robconf": 2, "x": 0, "y": 1, "z": 2, "q1": 0, "q2": 1, "q3": 2, "q4": 3, "robhold": 0, "tframe": 1, "tload": 2,
          "ufprog": 1, "ufmec": 2, "uframe": 3, "oframe": 4, "robax": 0, "v_tcp": 0, "v_ori": 1, "finep": 0, "pzone_tcp": 1, "pzone_ori": 2,
          "cf1": 0, "cf4": 1, "cf6": 2, "cfx": 3, "rax_1": 0, "rax_2": 1, "rax_3": 2, "rax_4": 3, "rax_5": 4, "rax_6": 5,
          "eax_a": 0, "eax_b": 1, "eax_c": 2, "eax_d": 3, "eax_e": 4, "eax_f": 5, "mass": 0, "cog": 1}
IGNORE = {"confl", "confj", "singarea", "accset", "velset", "tpwrite", "tperase", "setdo", "resetdo", "set", "reset", "waittime", "waitdi", "waituntil", "gripload",
          "stop", "clkreset", "clkstart", "clkstop", "setao", "setgo", "pulsedo", "waitrob", "actunit", "deactunit", "eoffsoff", "softdeact", "pathaccset", "worldacclim",
          "circpathmode", "incnt"}
ZONES = {"fine": 0.0, "z0": 0.3, "z1": 1.0, "z5": 5.0, "z10": 10.0, "z15": 15.0, "z20": 20.0, "z30": 30.0, "z40": 40.0, "z50": 50.0, "z60": 60.0, "z80": 80.0, "z100": 100.0,
         "z150": 150.0, "z200": 200.0}
ONE = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]


class Return(Exception):
    def __init__(self, v):
        self.v = v


class Goto(Exception):
    def __init__(self, l):
        self.label = l


class Stop(Exception):
    pass


class P:
    """Tokens with their lines, and a cursor."""
    def __init__(self, fn, text):
        self.fn, self.t, self.i = fn, [], 0
        line, i = 1, 0
        while i < len(text):
            c = text[i]
            if c == "\n":
                line += 1; i += 1
            elif c.isspace():
                i += 1
            elif c == "!":                     # OV: a comment reaches to the end of the line
                while i < len(text) and text[i] != "\n":
                    i += 1
            elif text.startswith("%%%", i):    # header %%% … %%% of old files
                j = text.index("%%%", i + 3) + 3
                line += text.count("\n", i, j); i = j
            else:
                m = TOK.match(text, i)
                if not m:
                    raise Refused(fn, line, "cannot read: " + text[i:i + 20])
                self.t.append((m.lastgroup, m.group(0), line))
                i = m.end()
        self.t.append(("end", "", line))

    def peek(self, k=0):
        return self.t[min(self.i + k, len(self.t) - 1)][1].lower()

    @property
    def line(self):
        return self.t[self.i][2]

    def next(self):
        t = self.t[self.i]
        self.i += 1
        return t

    def need(self, *w):
        t = self.next()
        if t[1].lower() not in w:
            raise Refused(self.fn, t[2], f"expected {'/'.join(w)}, found {t[1]}")
        return t[1].lower()


class Routine:
    pass


class Rapid:
    def __init__(self, files, main, options):
        self.main, self.options, self.files = main, options, files
        self.routines, self.globals, self.moves = {}, {}, []
        self.types = {}
        self.fn, self.ln, self.steps = main, 1, 0
        self.first, self.disp = None, NULL
        self.at = None           # pose of the tool in the root frame (world; of a standing tool: flange)
        self.g("pi", math.pi)
        self.globals["tool0"] = [True, copy.deepcopy(ONE), [0.001, [0, 0, 0.001], [1, 0, 0, 0], 0, 0, 0]]
        self.globals["wobj0"] = [False, True, "", copy.deepcopy(ONE), copy.deepcopy(ONE)]
        for k, z in ZONES.items():
            self.globals[k] = [k == "fine", z, z * 1.5, z * 1.5, z * .15, z * 1.5, z * .15]
        for v in (5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 7000):
            self.globals[f"v{v}"] = [float(v), 500.0, 5000.0, 1000.0]
        self.globals["vmax"] = [5000.0, 500.0, 5000.0, 1000.0]
        for fn in sorted(files, key=lambda f: f != main):
            if re.search(r"\.(mod|prg|sys|modx|sysx)$", fn, re.I):
                self.module(P(fn, files[fn].decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")))

    def g(self, k, v):
        self.globals[k] = v

    def no(self, why):
        raise Refused(self.fn, self.ln, why)

    # ---- modules
    def module(self, p):
        self.fn = p.fn
        while p.t[p.i][0] != "end":
            self.ln = p.line
            w = p.peek()
            if w == "module":
                p.next(); p.next()
                if p.peek() == "(":
                    while p.peek() != ")":
                        p.next()
                    p.next()
            elif w == "endmodule":
                p.next()
            elif w in ("local", "task", "const", "pers", "var"):
                self.decl(p, self.globals, {})
            elif w in ("proc", "func", "trap"):
                self.routine(p)
            elif w == "record" or w == "alias":
                self.no("RECORD and ALIAS")
            else:
                self.no("not read: " + p.next()[1])

    def decl(self, p, store, env):
        while p.peek() in ("local", "task"):
            p.next()
        p.need("const", "pers", "var")
        typ = p.next()[1].lower()
        name = p.next()[1].lower()
        dims = []
        if p.peek() == "{":
            p.next()
            while p.peek() != "}":
                dims.append(self.ex(self.expr(p), env))
                if p.peek() == ",":
                    p.next()
            p.next()
        val = None
        if p.peek() == ":=":
            p.next()
            val = copy.deepcopy(self.ex(self.expr(p), env))
        p.need(";")
        if val is None:
            one = {"num": 0.0, "dnum": 0.0, "bool": False, "string": "", "pos": [0.0] * 3, "orient": [0.0] * 4, "pose": [[0.0] * 3, [0.0] * 4],
                   "robtarget": [[0.0] * 3, [0.0] * 4, [0.0] * 4, [0.0] * 6], "jointtarget": [[0.0] * 6, [0.0] * 6]}.get(typ)
            if dims and one is not None:
                for d in reversed([int(x) for x in dims]):
                    one = [copy.deepcopy(one) for _ in range(d)]
            val = one
        store[name] = val

    def routine(self, p):
        r = Routine()
        r.fn, r.line = p.fn, p.line
        if p.peek() == "local":
            p.next()
        r.kind = p.next()[1].lower()
        if r.kind == "func":
            p.next()
        r.name = p.next()[1].lower()
        r.params = []
        if r.kind != "trap":
            p.need("(")
            opt = False
            while p.peek() != ")":
                if p.peek() == "\\":
                    p.next(); opt = True
                way = p.next()[1].lower() if p.peek() in ("var", "pers", "inout") else "in"
                if p.peek() == "switch":
                    way = p.next()[1].lower()
                else:
                    p.next()
                r.params.append((p.next()[1].lower(), way, opt))
                if p.peek() == "{":
                    while p.next()[1] != "}":
                        pass
                if p.peek() == ",":
                    p.next(); opt = False
            p.next()
        r.decls = []
        r.start = p.i
        depth_end = {"proc": "endproc", "func": "endfunc", "trap": "endtrap"}[r.kind]
        r.locals = []
        while p.peek() in ("var", "const", "pers", "local"):
            r.locals.append(p.i)
            while p.next()[1] != ";":
                pass
        r.p = p
        r.body = self.block(p, (depth_end, "error", "undo", "backward"))
        while p.peek() != depth_end:
            p.next()
        p.next()
        self.routines[r.name] = r

    def block(self, p, ends):
        out = []
        while p.peek() not in ends:
            self.ln = ln = p.line
            w = p.peek()
            if p.t[p.i][0] == "end":
                self.no("ends within " + ends[0])
            if w == "if":
                p.next()
                c = self.expr(p)
                if p.peek() != "then":      # OV: compact IF
                    out.append((ln, "if", [(c, [self.statement(p)])], []))
                    continue
                p.next()
                arms, other = [(c, self.block(p, ("elseif", "else", "endif")))], []
                while True:
                    k = p.next()[1].lower()
                    if k == "elseif":
                        c = self.expr(p); p.need("then")
                        arms.append((c, self.block(p, ("elseif", "else", "endif"))))
                    elif k == "else":
                        other = self.block(p, ("endif",))
                    else:
                        break
                out.append((ln, "if", arms, other))
            elif w == "for":
                p.next()
                v = p.next()[1].lower(); p.need("from")
                a = self.expr(p); p.need("to")
                b = self.expr(p)
                s = None
                if p.peek() == "step":
                    p.next(); s = self.expr(p)
                p.need("do")
                body = self.block(p, ("endfor",)); p.next()
                out.append((ln, "for", v, a, b, s, body))
            elif w == "while":
                p.next()
                c = self.expr(p); p.need("do")
                body = self.block(p, ("endwhile",)); p.next()
                out.append((ln, "while", c, body))
            elif w == "test":
                p.next()
                v = self.expr(p)
                cases, other = [], []
                while True:
                    k = p.next()[1].lower()
                    if k == "case":
                        cs = [self.expr(p)]
                        while p.peek() == ",":
                            p.next(); cs.append(self.expr(p))
                        p.need(":")
                        cases.append((cs, self.block(p, ("case", "default", "endtest"))))
                    elif k == "default":
                        p.need(":")
                        other = self.block(p, ("endtest",))
                    elif k == "endtest":
                        break
                    else:
                        self.no("TEST: " + k)
                out.append((ln, "test", v, cases, other))
            else:
                out.append(self.statement(p))
        return out

    def statement(self, p):
        ln = p.line
        w = p.peek()
        if w == "goto":
            p.next(); l = p.next()[1].lower(); p.need(";")
            return (ln, "goto", l)
        if w == "return":
            p.next()
            e = None if p.peek() == ";" else self.expr(p)
            p.need(";")
            return (ln, "return", e)
        if w in ("exit", "break"):
            p.next(); p.need(";")
            return (ln, "exit" if w == "exit" else "nop")
        if p.peek(1) == ":" and p.t[p.i][0] == "name":
            p.next(); p.next()
            return (ln, "label", w)
        # assignment or call
        j = p.i
        ref = self.postfix(p)
        if p.peek() == ":=":
            p.next()
            e = self.expr(p)
            p.need(";")
            return (ln, "set", ref, e)
        if ref[0] == "call":
            p.need(";") if p.peek() == ";" else self.no("a function is no statement")
            return (ln, "proc", ref[1], ref[2])
        p.i = j
        name = p.next()[1].lower()
        args = self.args(p, (";",))
        p.need(";")
        return (ln, "proc", name, args)

    def args(self, p, ends):
        """[(name or None, expression or None)]"""
        out = []
        while p.peek() not in ends:
            if p.peek() == ",":
                p.next()
                continue
            if p.peek() == "\\":
                p.next()
                n = p.next()[1].lower()
                if p.peek() == ":=":
                    p.next()
                    out.append((n, self.expr(p)))
                else:
                    out.append((n, None))
                continue
            out.append((None, self.expr(p)))
        return out

    # ---- expressions (OV ch. expressions: NOT; * / DIV MOD; + -; comparisons; AND; XOR OR — as known)
    def expr(self, p):
        e = self.x_and(p)
        while p.peek() in ("or", "xor"):
            o = p.next()[1].lower()
            e = ("bin", o, e, self.x_and(p))
        return e

    def x_and(self, p):
        e = self.x_not(p)
        while p.peek() == "and":
            p.next()
            e = ("bin", "and", e, self.x_not(p))
        return e

    def x_not(self, p):
        if p.peek() == "not":
            p.next()
            return ("not", self.x_not(p))
        e = self.x_sum(p)
        if p.peek() in ("=", "<>", "<", ">", "<=", ">="):
            o = p.next()[1]
            e = ("bin", o, e, self.x_sum(p))
        return e

    def x_sum(self, p):
        e = self.x_mul(p)
        while p.peek() in ("+", "-"):
            o = p.next()[1]
            e = ("bin", o, e, self.x_mul(p))
        return e

    def x_mul(self, p):
        e = self.x_un(p)
        while p.peek() in ("*", "/", "div", "mod"):
            o = p.next()[1].lower()
            e = ("bin", o, e, self.x_un(p))
        return e

    def x_un(self, p):
        if p.peek() in ("-", "+"):
            o = p.next()[1]
            e = self.x_un(p)
            return ("neg", e) if o == "-" else e
        return self.postfix(p)

    def postfix(self, p):
        k, x, ln = p.t[p.i]
        self.ln = ln
        if k == "num":
            p.next()
            return ("lit", float(x))
        if k == "str":
            p.next()
            return ("lit", x[1:-1].replace('""', '"'))
        if x == "(":
            p.next()
            e = self.expr(p)
            p.need(")")
        elif x == "[":
            p.next()
            es = []
            while p.peek() != "]":
                es.append(self.expr(p))
                if p.peek() == ",":
                    p.next()
            p.next()
            e = ("list", es)
        elif k == "name":
            p.next()
            n = x.lower()
            if n in ("true", "false"):
                return ("lit", n == "true")
            if p.peek() == "(":
                p.next()
                a = self.args(p, (")",))
                p.next()
                e = ("call", n, a)
            else:
                e = ("var", n)
        else:
            self.no("unexpected " + x)
        while p.peek() in (".", "{"):
            if p.next()[1] == ".":
                e = ("field", e, p.next()[1].lower())
            else:
                idx = []
                while p.peek() != "}":
                    idx.append(self.expr(p))
                    if p.peek() == ",":
                        p.next()
                p.next()
                e = ("index", e, idx)
        return e

    def ex(self, e, env):
        k = e[0]
        if k == "lit":
            return e[1]
        if k == "list":
            return [self.ex(x, env) for x in e[1]]
        if k == "var":
            v = env[e[1]] if e[1] in env else self.globals.get(e[1])
            if v is None:
                self.no(f"{e[1]} has no value in the files")
            return v
        if k == "field":
            v = self.ex(e[1], env)
            if e[2] == "extax":
                return v[-1]
            if e[2] not in FIELDS:
                self.no("component " + e[2])
            return v[FIELDS[e[2]]]
        if k == "index":
            v = self.ex(e[1], env)
            for x in e[2]:
                v = v[int(self.ex(x, env)) - 1]
            return v
        if k == "neg":
            v = self.ex(e[1], env)
            return [-c for c in v] if isinstance(v, list) else -v
        if k == "not":
            return not self.ex(e[1], env)
        if k == "call":
            return self.func(e[1], e[2], env)
        o = e[1]
        a = self.ex(e[2], env)
        if o == "and":
            return a and self.ex(e[3], env)
        if o == "or":
            return a or self.ex(e[3], env)
        b = self.ex(e[3], env)
        if o == "+":
            return [x + y for x, y in zip(a, b)] if isinstance(a, list) else a + b
        if o == "-":
            return [x - y for x, y in zip(a, b)] if isinstance(a, list) else a - b
        if o == "*":
            if isinstance(a, list) and isinstance(b, list):
                return list(to_quat(mul(quat(a), quat(b)))) if len(a) == 4 else self.no("pos * pos")
            if isinstance(a, list):
                return [x * b for x in a]
            if isinstance(b, list):
                return [x * a for x in b]
            return a * b
        if o == "/":
            return [x / b for x in a] if isinstance(a, list) else a / b
        if o == "div":
            return float(math.trunc(a / b))
        if o == "mod":
            return float(math.fmod(a, b))
        return {"=": a == b, "<>": a != b, "<": None if isinstance(a, (list, str)) else a < b, ">": None if isinstance(a, (list, str)) else a > b,
                "<=": None if isinstance(a, (list, str)) else a <= b, ">=": None if isinstance(a, (list, str)) else a >= b, "xor": bool(a) != bool(b)}[o]

    def fr(self, pose):
        if len(pose[1]) != 4 or abs(math.sqrt(sum(q * q for q in pose[1])) - 1) > 1e-3:
            self.no("a quaternion that is not of length 1")
        return (quat(pose[1]), tuple(float(v) for v in pose[0]))

    def func(self, n, args, env):
        if n == "present":
            return args[0][1][1] in env
        if n in ("cpos", "crobt", "cjointt"):
            self.no(n + ": where the robot is")
        pos = [self.ex(a, env) for k, a in args if k is None]
        opt = {k: (True if a is None else self.ex(a, env)) for k, a in args if k}
        if n == "offs":                 # IFD Offs: added in the object's frame
            t = copy.deepcopy(pos[0])
            t[0] = [t[0][i] + pos[1 + i] for i in range(3)]
            return t
        if n == "reltool":              # IFD RelTool: in the tool's frame; Rx, then about new y, then new z
            t = copy.deepcopy(pos[0])
            R, q = self.fr(t)
            D = mul(mul(rx(math.radians(opt.get("rx", 0))), ry(math.radians(opt.get("ry", 0)))), rz(math.radians(opt.get("rz", 0))))
            t[0] = list(add(q, app(R, tuple(pos[1:4]))))
            if opt:
                t[1] = list(to_quat(mul(R, D)))
            return t
        if n in ("sin", "cos", "tan"):
            return getattr(math, n)(math.radians(pos[0]))
        if n in ("asin", "acos", "atan"):
            return math.degrees(getattr(math, n)(pos[0]))
        if n == "atan2":
            return math.degrees(math.atan2(pos[0], pos[1]))
        if n == "sqrt":
            return math.sqrt(pos[0])
        if n == "abs":
            return abs(pos[0])
        if n == "pow":
            return pos[0] ** pos[1]
        if n == "trunc":
            d = 10 ** opt.get("dec", 0)
            return math.trunc(pos[0] * d) / d
        if n == "round":
            d = 10 ** opt.get("dec", 0)
            return math.copysign(math.floor(abs(pos[0]) * d + 0.5), pos[0]) / d
        if n == "orientzyx":
            return list(to_quat(zyx(*pos)))
        if n == "eulerzyx":
            a = to_zyx(quat(pos[0]))
            return a[0] if "z" in opt else a[1] if "y" in opt else a[2]
        if n == "posemult":
            f = fmul(self.fr(pos[0]), self.fr(pos[1]))
            return [list(f[1]), list(to_quat(f[0]))]
        if n == "poseinv":
            f = finv(self.fr(pos[0]))
            return [list(f[1]), list(to_quat(f[0]))]
        if n == "posevect":
            f = self.fr(pos[0])
            return list(add(f[1], app(f[0], tuple(pos[1]))))
        if n == "distance":
            return dist(pos[0], pos[1])
        if n == "vectmagn":
            return math.sqrt(sum(v * v for v in pos[0]))
        if n == "normalizequat" or n == "norient":
            s = math.sqrt(sum(v * v for v in pos[0]))
            return [v / s for v in pos[0]]
        if n == "valtostr":
            return str(pos[0])
        if n == "dim":
            return float(len(pos[0]))
        r = self.routines.get(n)
        if r is None or r.kind != "func":
            self.no(f"function {n} is not in the files")
        return self.call(r, args, env)

    def call(self, r, args, env):
        if env.get("#", 0) > 60:
            self.no("calls too deep")
        new = {"#": env.get("#", 0) + 1}
        pos = [a for a in args if a[0] is None]
        named = {a[0]: a[1] for a in args if a[0]}
        outs = []
        for n, way, opt in r.params:
            if way == "switch":
                if n in named:
                    new[n] = True
                continue
            if n in named:
                e = named[n]
            elif opt:
                continue
            else:
                if not pos:
                    self.no(f"{r.name}: too few arguments")
                e = pos.pop(0)[1]
            v = self.ex(e, env)
            if way == "in":
                new[n] = copy.deepcopy(v)
            else:
                new[n] = copy.deepcopy(v)
                outs.append((n, e))
        back = (self.fn, self.ln)
        self.fn = r.fn
        for i in r.locals:
            q = r.p
            keep, q.i = q.i, i
            self.decl(q, new, new)
            q.i = keep
        ret = None
        try:
            self.body(r.body, new)
        except Return as x:
            ret = x.v
        self.fn, self.ln = back
        for n, e in outs:
            self.assign(e, new[n], env)
        return ret

    def assign(self, ref, val, env):
        val = copy.deepcopy(val)
        if ref[0] == "var":
            (env if ref[1] in env else self.globals)[ref[1]] = val
            return
        box = self.ex(ref[1], env)
        if ref[0] == "field":
            i = len(box) - 1 if ref[2] == "extax" else FIELDS[ref[2]]
        else:
            ix = [int(self.ex(x, env)) - 1 for x in ref[2]]
            for k in ix[:-1]:
                box = box[k]
            i = ix[-1]
        box[i] = val

    # ---- running
    def body(self, body, env):
        at = 0
        while True:
            try:
                self.run(body[at:], env)
                return
            except Goto as g:
                for k, s in enumerate(body):
                    if s[1] == "label" and s[2] == g.label:
                        at = k
                        break
                else:
                    raise

    def run(self, body, env):
        for s in body:
            self.ln = s[0]
            self.steps += 1
            if self.steps > 100000:
                self.no("does not end")
            k = s[1]
            if k == "set":
                self.assign(s[2], self.ex(s[3], env), env)
            elif k == "proc":
                self.proc(s[2], s[3], env)
            elif k == "if":
                for c, b in s[2]:
                    if self.ex(c, env):
                        self.body(b, env)
                        break
                else:
                    self.body(s[3], env)
            elif k == "for":
                a, b = self.ex(s[3], env), self.ex(s[4], env)
                st = self.ex(s[5], env) if s[5] else (1.0 if b >= a else -1.0)
                inner = dict(env)
                n = math.floor((b - a) / st + 1e-9) + 1
                keep = env.get(s[2])
                for q in range(max(0, n)):
                    env[s[2]] = a + q * st
                    self.body(s[6], env)
                    self.ln = s[0]
                env.pop(s[2], None)
                if keep is not None:
                    env[s[2]] = keep
            elif k == "while":
                while self.ex(s[2], env):
                    self.body(s[3], env)
                    self.ln = s[0]
                    self.steps += 1
                    if self.steps > 100000:
                        self.no("does not end")
            elif k == "test":
                v = self.ex(s[2], env)
                for cs, b in s[3]:
                    if any(self.ex(c, env) == v for c in cs):
                        self.body(b, env)
                        break
                else:
                    self.body(s[4], env)
            elif k == "goto":
                raise Goto(s[2])
            elif k == "return":
                raise Return(self.ex(s[2], env) if s[2] else None)
            elif k == "exit":
                raise Stop()

    def proc(self, n, args, env):
        if n in ("movel", "movej", "movec", "moveabsj", "moveldo", "movejdo", "movecdo", "movelsync"):
            return self.move(n, args, env)
        if n in IGNORE:
            return
        pos = [a for k, a in args if k is None]
        if n in ("incr", "decr", "add", "clear"):
            v = self.ex(pos[0], env)
            d = {"incr": 1.0, "decr": -1.0, "clear": -v}.get(n)
            self.assign(pos[0], v + (d if d is not None else self.ex(pos[1], env)), env)
            return
        if n == "pdispset":
            self.disp = self.fr(self.ex(pos[0], env))
            return
        if n == "pdispoff":
            self.disp = NULL
            return
        r = self.routines.get(n)
        if r is None:
            if n in [c.lower() for c in self.options.get("calls_kept", [])]:
                return
            self.no(f"{n} is not in the files")
        self.call(r, args, env)

    def move(self, n, args, env):
        pos = [a for k, a in args if k is None]
        opt = {k: a for k, a in args if k}
        ln = self.ln
        if "corr" in opt or "sync" in n:
            self.no("\\Corr, sync")
        k = 2 if n.startswith("movec") else 1
        tgts = [copy.deepcopy(self.ex(a, env)) for a in pos[:k]]
        speed, zone, tool = (self.ex(a, env) for a in pos[k:k + 3])
        wobj = self.ex(opt["wobj"], env) if "wobj" in opt else self.globals["wobj0"]
        feed = (self.ex(opt["v"], env) if "v" in opt else speed[0]) * 60
        z = 0.0 if zone[0] else float(zone[1])
        if "z" in opt and not zone[0]:
            z = float(self.ex(opt["z"], env))
        if n == "moveabsj":
            self.at = None
            self.moves.append(RMove("joint", self.fn, ln, None, joints=tuple(float(v) for v in tgts[0][0]), zone=z))
            return
        held = not tool[0]
        if bool(wobj[0]) != held:
            self.no("robhold of tool and object agree in none of both holding")
        if not wobj[1]:
            self.no("a work object moved by an axis")
        O = fmul(self.fr(wobj[3]), self.fr(wobj[4]))
        if self.first is None:
            self.first = (O, held)
        if self.first[1] != held:
            self.no("tools held and standing")
        to = lambda t: fmul(finv(self.first[0]), fmul(O, fmul(self.disp, self.fr(t))))
        E = to(tgts[-1])
        start = self.at
        kind = "rapid" if n.startswith("movej") else "arc" if k == 2 else "line"
        centre = turn = via = None
        if kind == "arc":
            if start is None:
                self.no("an arc whose start is not known")
            via = to([tgts[0][0], tgts[0][1]])[1]
            c = circle(start[1], via, E[1])
            if c is None:
                self.no("an arc through points in line")
            centre, r, ax, ang = c
            turn = sca(ang, ax)
        self.moves.append(RMove(kind, self.fn, ln, E[1], E[0], centre, turn, None if kind == "rapid" else feed, via, start and start[1], z, quat(tool[1][1]), held))
        self.at = E


def trace(files, main, options):
    r = Rapid(files, main, options)
    entry = options.get("entry", "main")
    if entry not in r.routines:
        own = [x for x in r.routines.values() if x.fn == main and x.kind == "proc" and not x.params]
        if len(own) != 1:
            raise Refused(main, 1, "no main")
        entry = own[0].name
    try:
        r.call(r.routines[entry], [], {})
    except Stop:
        pass
    except Goto as g:
        r.no("GOTO " + g.label)
    except UNREAD as e:
        raise Refused(r.fn, r.ln, f"not read ({type(e).__name__}: {e})")
    return r.moves


def run(files, main, options):
    return [m for m in trace(files, main, options) if m.end is not None]


# ---- random programs
def generate(seed):
    r = random.Random(f"rapid{seed}")
    for _ in range(60):
        files, main, opt = Gen(r).make()
        try:
            run(files, main, opt)
        except Refused as e:       # three points that rounding put in line
            if "in line" in e.why:
                continue
            raise
        mv = run(files, main, opt)
        n = sum(t.count(b"\n") for t in files.values())
        if len(mv) >= 5 and n <= 95 and all(max(abs(c) for c in m.end) <= 300 for m in mv) and all(m.kind != "arc" or dist(m.start, m.centre) >= 1 for m in mv) \
                and any(m.kind != "rapid" for m in mv):
            return files, main, opt
    raise AssertionError(seed)


class Gen:
    def __init__(self, r):
        self.r, self.dec, self.safe = r, r.choice([1, 2, 3, 3]), 45.0
        self.ind = r.choice(["  ", "    ", "\t", ""])
        self.low = r.random() < .1
        self.n, self.data, self.loc, self.out, self.procs, self.have = 0, [], [], [], [], set()
        self.names = r.random() < .75
        self.hold = not SIMPLE and r.random() < .12       # the robot carries the part
        self.R = r.choice([zyx(0, 0, 180), zyx(0, 0, 180), zyx(90, 0, 180), zyx(r.uniform(-170, 170), r.uniform(-25, 25), 180 + r.uniform(-20, 20))])
        self.vary = r.random() < .25      # the tool turns along the path
        self.nine = r.choice(["9E+09", "9E9", "9.0E9", "9E+9"])
        self.speed = r.choice(["v20", "v50", "v100", "vcut", "[25,500,5000,1000]"])
        self.toolname, self.wname = r.choice(["tMill", "tool1", "Spindle_T"]), r.choice(["wPart", "wobj1", "Work_1"])
        self.W2 = False

    def f(self, v):
        s = f"{v:.{self.dec}f}"
        if self.r.random() < .3 and "." in s:
            s = s.rstrip("0").rstrip(".")
        return "0" if s in ("-0", "") else s

    def rnd(self, a, b):
        return round(self.r.uniform(a, b), self.dec)

    def xy(self):
        return self.rnd(-90, 90), self.rnd(-90, 90)

    def q(self):
        return "[" + ",".join(f"{c:.9f}".rstrip("0").rstrip(".") or "0" for c in to_quat(self.R)) + "]"

    def lit(self, p):
        sp = self.r.choice(["", "", " "])
        q = self.q().replace(",-0,", ",0,")
        return f"[[{self.f(p[0])},{sp}{self.f(p[1])},{sp}{self.f(p[2])}],{sp}{q},{sp}[0,0,0,0],{sp}[{','.join([self.nine] * 6)}]]"

    def tgt(self, p):
        if not self.names or self.r.random() < .25:
            return self.lit(p)
        self.n += 1
        n = self.r.choice(["p", "Target_", "pCut"]) + str(self.n * 10)
        self.data.append(f"{self.r.choice(['CONST', 'CONST', 'PERS', 'VAR', 'LOCAL CONST'])} robtarget {n}:={self.lit(p)};")
        return n

    def zone(self):
        return self.r.choice(["fine", "z1", "z5", "z0", "fine", "z10"])

    def tail(self, sp=None, zone=None, w=None):
        o = self.r.choice(["", "", "", "\\V:=40"]) if sp is None else ""
        return f"{sp or self.speed}{o},{self.r.choice(['', ' '])}{zone or self.zone()},{self.toolname}{self.r.choice(['', ' '])}\\{self.r.choice(['WObj', 'WObj', 'wobj'])}:={w or self.wname}"

    def put(self, t, d=1):
        self.out.append(self.ind * d + t)

    def z(self):
        return self.rnd(-15, 4)

    def turn(self):
        if self.vary and self.r.random() < .4:
            self.R = mul(self.R, zyx(*(self.r.uniform(-12, 12) for _ in range(3))))

    def lin(self, p, w=None):
        self.turn()
        self.put(f"MoveL {self.tgt(p)},{self.tail(w=w)};")
        self.cur = p

    def rapid(self, p, w=None):
        self.put(f"MoveJ {self.tgt(p)},{self.tail('v1000', w=w)};")
        self.cur = p

    def v(self, typ, name, init=None):
        if name not in self.have:
            self.have.add(name)
            self.loc.append(f"VAR {typ} {name}" + (f":={init};" if init else ";"))
        return name

    def arc(self):
        x, y, z = self.cur
        rad, a0 = self.r.uniform(4, 30), self.r.uniform(0, 6.28)
        sw = self.r.choice([-1, 1]) * self.r.uniform(.6, 4.0)
        cx, cy = x - rad * math.cos(a0), y - rad * math.sin(a0)
        dz = self.r.choice([0, 0, self.r.uniform(-2, 2)])
        g = lambda s: (round(cx + rad * math.cos(a0 + s), self.dec), round(cy + rad * math.sin(a0 + s), self.dec), round(z + dz * s / sw, self.dec))
        a, b = g(sw / 2), g(sw)
        if dist(a, b) < 1 or dist(self.cur, a) < 1:
            return
        self.turn()
        self.put(f"MoveC {self.tgt(a)},{self.tgt(b)},{self.tail()};")
        self.cur = b

    def op(self):
        r = self.r
        k = r.choice(["lin"] * 3 + ["arc"] * 2 + ["offs", "offs", "reltool", "for", "for", "while", "if", "test", "proc", "procarg", "func", "misc", "misc", "retract", "abs", "comp",
                                                    "wobj2", "pdisp", "array", "goto", "inline"])
        if SIMPLE:
            k = r.choice(["lin", "lin", "arc", "misc", "retract", "abs"])
        z = self.z()
        if k == "lin":
            for _ in range(r.randint(1, 3)):
                self.lin((*self.xy(), z))
        elif k == "arc":
            self.arc()
        elif k == "inline":
            p = (*self.xy(), z)
            self.put(f"MoveL {self.lit(p)},{self.tail()};")
            self.cur = p
        elif k == "offs":
            p = (*self.xy(), z)
            t = self.tgt(p)
            d = (self.rnd(-20, 20), self.rnd(-20, 20), self.rnd(-2, 2))
            self.put(f"MoveL Offs({t},{self.f(d[0])},{self.f(d[1])},{self.f(d[2])}),{self.tail()};")
            if r.random() < .5:
                self.put(f"MoveL {t},{self.tail()};")
                self.cur = p
            else:
                self.lin((*self.xy(), z))
        elif k == "reltool":
            t = self.tgt((*self.xy(), z))
            self.put(f"MoveL RelTool({t},{self.rnd(-9, 9)},{self.rnd(-9, 9)},{self.rnd(-4, 0)}{r.choice(['', chr(92) + 'Rz:=' + str(self.rnd(-30, 30)), chr(92) + 'Rx:=5' + chr(92) + 'Ry:=-4.5'])}),{self.tail()};")
            self.lin((*self.xy(), z))
        elif k == "for":
            t = self.tgt((self.rnd(-60, 0), self.rnd(-60, 0), z))
            a, b, s = r.choice([(1, 3, ""), (0, 2, ""), (3, 1, ""), (0, 4, " STEP 2"), (4, 0, " STEP -2")])
            i = r.choice(["i", "k"])
            self.put(f"FOR {i} FROM {a} TO {b}{s} DO")
            self.put(f"MoveL Offs({t},0,{self.rnd(2, 8)}*{i},0),{self.tail()};", 2)
            self.put(f"MoveL Offs({t},{self.rnd(20, 50)},{i}*{self.rnd(2, 8)},-0.5),{self.tail()};", 2)
            if r.random() < .3:
                self.put(f"IF {i}={a} WaitTime 0.1;", 2)
            self.put("ENDFOR")
            self.lin((*self.xy(), z))
        elif k == "while":
            n = self.v("num", "nCount", "0")
            t = self.tgt((*self.xy(), z))
            self.put(f"{n}:=0;")
            self.put(f"WHILE {n}<{r.choice(['3', '2 AND TRUE'])} DO")
            self.put(f"MoveL Offs({t},5*{n},Sin(30*{n})*10,0),{self.tail()};", 2)
            self.put(r.choice([f"{n}:={n}+1;", f"Incr {n};", f"Add {n},1;"]), 2)
            self.put("ENDWHILE")
            self.lin((*self.xy(), z))
        elif k == "if":
            n = self.v("num", "nMode", "0")
            self.put(f"{n}:={r.randint(0, 3)};")
            self.put(f"IF {n}=1 THEN")
            self.lin((*self.xy(), z))
            if r.random() < .5:
                self.put(f"ELSEIF {n}>=2 AND NOT ({n}=3) THEN")
                self.lin((*self.xy(), z))
            self.put("ELSE")
            self.lin((*self.xy(), z))
            self.put("ENDIF")
            self.lin((*self.xy(), z))
        elif k == "test":
            n = self.v("num", "nSel", "0")
            self.put(f"{n}:={r.randint(1, 4)};")
            self.put(f"TEST {n}")
            for c in ("1", "2,3"):
                self.put(f"CASE {c}:")
                self.lin((*self.xy(), z))
            self.put("DEFAULT:")
            self.lin((*self.xy(), z))
            self.put("ENDTEST")
            self.lin((*self.xy(), z))
        elif k == "proc" and "Path_10" not in self.have:
            self.have.add("Path_10")
            keep, self.out = self.out, []
            for _ in range(r.randint(2, 4)):
                self.lin((*self.xy(), z))
            if r.random() < .5:
                self.arc()
            body, self.out = self.out, keep
            self.procs += ["PROC Path_10()"] + body + ["ENDPROC"]
            self.put("Path_10;")
            if r.random() < .3:
                self.put("Path_10;")
        elif k == "procarg" and "Slot" not in self.have:
            self.have.add("Slot")
            self.procs += ["PROC Slot(robtarget pStart,num nLen,\\num nDepth)", self.ind + "VAR num nD:=0;", self.ind + "IF Present(nDepth) nD:=nDepth;",
                           f"{self.ind}MoveL pStart,{self.tail()};", f"{self.ind}MoveL Offs(pStart,0,0,-nD),{self.tail()};", f"{self.ind}MoveL Offs(pStart,nLen,0,-nD),{self.tail()};", "ENDPROC"]
            for _ in range(r.randint(1, 2)):
                self.put(f"Slot {self.tgt((*self.xy(), z))},{self.rnd(5, 30)}{r.choice(['', chr(92) + 'nDepth:=1.5'])};")
            self.lin((*self.xy(), z))
        elif k == "func" and "fPoint" not in self.have:
            self.have.add("fPoint")
            t = self.tgt((*self.xy(), z))
            self.procs += ["FUNC robtarget fPoint(num nA,num nR)", self.ind + f"RETURN Offs({t},nR*Cos(nA),nR*Sin(nA),0);", "ENDFUNC"]
            for a in (0, 60, 135):
                self.put(f"MoveL fPoint({a},{self.rnd(5, 15)}),{self.tail()};")
            self.lin((*self.xy(), z))
        elif k == "misc":
            self.put(r.choice(["! cut", "WaitTime 0.5;", "SetDO doSpindle,1;", 'TPWrite "pass";', "ConfL\\Off;", "SingArea\\Wrist;", "", "AccSet 50,50;", "Reset doCool;"]))
        elif k == "retract":
            self.lin((self.cur[0], self.cur[1], self.safe))
            p = (*self.xy(), self.safe)
            self.rapid(p)
            self.lin((p[0], p[1], z))
        elif k == "abs":
            self.lin((self.cur[0], self.cur[1], self.safe))
            self.put(f"MoveAbsJ [[0,-10,20,0,30,0],[{','.join([self.nine] * 6)}]]{r.choice(['', chr(92) + 'NoEOffs'])},v500,fine,{self.toolname}{r.choice(['', chr(92) + 'WObj:=' + self.wname])};")
            p = (*self.xy(), self.safe)
            self.rapid(p)
            self.lin((p[0], p[1], z))
        elif k == "comp":
            n = self.v("robtarget", "pTmp")
            p = (*self.xy(), z)
            self.put(f"{n}:={self.tgt(p)};")
            self.put(f"{n}.trans.x:={n}.trans.x{r.choice(['+', '-'])}{self.rnd(1, 20)};")
            if r.random() < .4:
                self.put(f"{n}.trans:={n}.trans+[1,2,-0.5];")
            self.put(f"MoveL {n},{self.tail()};")
            self.lin((*self.xy(), z))
        elif k == "wobj2":
            self.W2 = True
            self.lin((self.cur[0], self.cur[1], self.safe))
            self.rapid((self.rnd(-40, 40), self.rnd(-40, 40), self.safe), "wSide")
            self.lin((self.rnd(-40, 40), self.rnd(-40, 40), z), "wSide")
            self.lin((self.rnd(-40, 40), self.rnd(-40, 40), z), "wSide")
            self.rapid((*self.xy(), self.safe))
            self.lin((*self.xy(), z))
        elif k == "pdisp":
            self.put(f"PDispSet [[{self.rnd(-20, 20)},{self.rnd(-20, 20)},0],[1,0,0,0]];" if r.random() < .6 else "PDispSet [[10,0,0],OrientZYX(15,0,0)];")
            self.lin((*self.xy(), z))
            self.lin((*self.xy(), z))
            self.put("PDispOff;")
            self.lin((*self.xy(), z))
        elif k == "array" and "aPts" not in self.have:
            self.have.add("aPts")
            ps = [(*self.xy(), z) for _ in range(3)]
            self.data.append("CONST robtarget aPts{3}:=[" + ",".join(self.lit(p) for p in ps) + "];")
            self.put("FOR j FROM 1 TO 3 DO")
            self.put(f"MoveL aPts{{j}},{self.tail()};", 2)
            self.put("ENDFOR")
            self.cur = ps[-1]
        elif k == "goto" and "again" not in self.have:
            self.have.add("again")
            n = self.v("num", "nPass", "0")
            self.put(f"{n}:=0;")
            self.put("again:")
            self.put(f"MoveL Offs({self.tgt((*self.xy(), z))},0,0,-{n}),{self.tail()};")
            self.put(f"MoveL Offs({self.tgt((*self.xy(), z))},0,0,-{n}),{self.tail()};")
            self.put(f"{n}:={n}+1;")
            self.put(f"IF {n}<2 GOTO again;")
            self.lin((*self.xy(), z))

    def make(self):
        r = self.r
        tip = r.choice([(0, 0, 200), (15.5, 0, 180.25)])
        trot = r.choice(["[1,0,0,0]", "[1,0,0,0]", "[0.707106781,0,0.707106781,0]"]) if not SIMPLE else "[1,0,0,0]"
        wq = r.choice(["[1,0,0,0]", "[0.923879533,0,0,0.382683432]", "[0.965925826,0,0,0.258819045]"])
        u = f"[[{self.rnd(500, 900)},{self.rnd(-200, 200)},400],{wq}]"
        o = r.choice(["[[0,0,0],[1,0,0,0]]", "[[10,20,5],[0.996194698,0,0,0.087155743]]"])
        hold, held = ("FALSE", "TRUE") if self.hold else ("TRUE", "FALSE")
        head = [f"PERS tooldata {self.toolname}:=[{hold},[[{','.join(f'{v:g}' for v in tip)}],{trot}],[3,[0,0,100],[1,0,0,0],0,0,0]];",
                f"{r.choice(['TASK PERS', 'PERS'])} wobjdata {self.wname}:=[{held},TRUE,\"\",{u},{o}];"]
        start = (*self.xy(), self.safe)
        if r.random() < .3:
            self.put(f"MoveAbsJ jHome{r.choice(['', chr(92) + 'NoEOffs'])},v500,fine,tool0;")
            self.data.append(f"CONST jointtarget jHome:=[[0,0,0,0,30,0],[{','.join([self.nine] * 6)}]];")
        self.rapid(start)
        self.lin((start[0], start[1], self.z()))
        target = r.randint(12, 34)
        while len(self.out) < target:
            self.op()
        self.lin((self.cur[0], self.cur[1], self.safe))
        if self.speed == "vcut":
            head.append("CONST speeddata vcut:=[15,500,5000,1000];")
        if self.W2:
            head.append(f"PERS wobjdata wSide:=[{held},TRUE,\"\",{u},[[20,-15,3],[0.991444861,0,0.130526192,0]]];")
        main = [("PROC main()")] + [self.ind + x for x in self.loc] + self.out + ["ENDPROC"]
        body = head + self.data
        procs = self.procs
        files = {}
        name = r.choice(["Module1", "MainModule", "T_ROB1_part"]) + r.choice(["", str(r.randint(1, 9))])
        ext = r.choice([".mod", ".mod", ".MOD", ".prg"])
        i = r.choice(["", "  ", "    "])
        nl = r.choice(["\r\n", "\n"])
        if not SIMPLE and r.random() < .15 and procs and all("LOCAL" not in x for x in body):
            files["Paths.mod"] = (nl.join(["MODULE Paths"] + body + procs + ["ENDMODULE"]) + nl).encode()
            lines = [f"MODULE {name}"] + main + ["ENDMODULE"]
        elif r.random() < .5:
            lines = [f"MODULE {name}"] + body + main + procs + ["ENDMODULE"]
        else:
            lines = [f"MODULE {name}"] + body + procs + main + ["ENDMODULE"]
        if r.random() < .2:
            lines = ["%%%", "  VERSION:1", "  LANGUAGE:ENGLISH", "%%%", ""] + lines
        text = nl.join(i + x for x in lines) + nl
        if self.low:
            text = re.sub(r"\b(PROC|ENDPROC|FOR|ENDFOR|FROM|TO|DO|IF|THEN|ENDIF|MoveL|MoveC|CONST|PERS|VAR|ELSE|WHILE|ENDWHILE|MODULE|ENDMODULE|TRUE|FALSE)\b", lambda m: m.group(0).lower(), text)
        files[name + ext] = text.encode()
        return files, name + ext, {"tip": tip, "hold": self.hold}


Q = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]"
HEAD = ("MODULE M\nPERS tooldata t:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n"
        "PERS wobjdata w:=[FALSE,TRUE,\"\",[[100,0,0],[0.707106781186548,0,0,0.707106781186548]],[[0,0,5],[1,0,0,0]]];\n"
        f"CONST robtarget p:=[[1,2,3],[0,0,1,0],{Q}];\n")
HAND = [
    ("offs", HEAD + "PROC main()\nMoveJ p,v100,fine,t\\WObj:=w;\nFOR i FROM 2 TO 1 DO\nMoveL Offs(p,i,0,0),v100,z1,t\\WObj:=w;\nENDFOR\nMoveL RelTool(p,0,0,10),v100,fine,t\\WObj:=w;\n"
     "MoveL RelTool(p,1,0,0\\Rz:=90),v100,fine,t\\WObj:=w;\nMoveL p,v100,fine,t;\nENDPROC\nENDMODULE\n",
     [(1, 2, 3), (3, 2, 3), (2, 2, 3), (1, 2, -7), (0, 2, 3), (2, 99, -2)]),
    ("flow", HEAD + "PROC main()\nVAR num n:=7;\nVAR robtarget q;\nq:=p;\nq.trans.z:=n DIV 2;\nMoveJ q,v100,fine,t\\WObj:=w;\nwhile n mod 2=1 do\nn:=n+1;\nsub n,2\\d:=1;\nendwhile\n"
     "TEST n\nCASE 1,8: MoveL Offs(q,0,n,0),v100,fine,t\\WObj:=w;\nDEFAULT:\nMoveL p,v10,fine,t\\WObj:=w;\nENDTEST\nMoveC Offs(p,5,5,0),Offs(p,0,10,0),v10\\V:=5,z5,t\\WObj:=w;\nENDPROC\n"
     "PROC sub(num a,num b\\num d)\nIF Present(d) MoveL Offs(p,a,b,d),v100,z1,t\\WObj:=w;\nENDPROC\nENDMODULE\n",
     [(1, 2, 3), (9, 4, 4), (1, 10, 3), (1, 12, 3)]),
]


if __name__ == "__main__":
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    selftest("rapid", [(name, {"h.mod": text.encode()}, "h.mod", want) for name, text, want in HAND], run, generate, n,
             also=lambda m: m.feed is None or m.feed > 0)
