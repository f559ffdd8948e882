"""KUKA Robot Language, as KSS 8.x reads it: .src with .dat and $config.dat.

Manuals: "KSS 8.3 Operating and Programming Instructions for System Integrators" (SI), chapter 11 (programming for user group
"Expert"); "KRC2 / KSS 5.x Expert Programming" (XP).
Looked up (stored pages, 28 Nov): LIN_REL and PTP_REL default to #BASE, #TOOL turns them to the tool, missing components are 0;
`{X 1}` and `{POS: X 1}` are the same; p1 : {…} is a frame product; the orientation at the auxiliary point is not used; $ORI_TYPE and
$CIRC_TYPE are set on lines of their own. (industrialmonitordirect.com: kuka-lin-rel-vs-geometric-operator, kuka-krl-ptp-rel,
kuka-krc2-base-moving, kuka-krc4-circ-motion-aux-point.) The stored copies of the manuals end before their chapters on KRL.
A REAL given to an INT is rounded to the nearest: 5 + 10.6 gives 16 (KUKA College, "Robot Programming 2", KSS 8, changing
values of variables, as told at cloud.tencent.com/developer/article/2034380).
Not looked up (as known): everything else marked "as known" below; above all A, B, C as Rz Ry Rx, missing components of a target are
those of the position before, integer division, rules of CA, BAS() and the inline forms, SPLINE, FOR/WHILE/… and EXIT.
Left open by the manuals, and not generated: the orientation at the end of a CIRC with CA when it differs from that at the start; A, B, C
in LIN_REL #BASE; comparison and AND without brackets; a REAL given to an INT halfway between two; the counter behind
a FOR; E1–E6 that move the base.
"""
import copy
import math
import os
import random
import re
import sys

from move import Move, Refused
from robmath import (NULL, RMove, add, app, circle, dist, finv, fmul, mul, norm, sca, sub, to_zyx, tr, turn_about, zyx, UNREAD, selftest)

SIMPLE = bool(os.environ.get("ORC_SIMPLE"))   # straight programs only, to look at readers that follow no more
FLOW = bool(os.environ.get("ORC_FLOW"))       # mostly branches, loops, calls, computed points; no splines, other files
XYZABC = ("X", "Y", "Z", "A", "B", "C")
TOK = re.compile(r"""\s*(?:
 (?P<num>(?:\d+\.\d*|\.\d+|\d+)(?:[eE][+-]?\d+)?)
|(?P<name>[$A-Za-z_][$\w]*)
|(?P<str>"[^"]*")
|(?P<enum>\#\w+)
|(?P<bit>'[HhBb][0-9A-Fa-f]+')
|(?P<op><>|<=|>=|==|[-+*/:(){}\[\],.<>=])
)""", re.X)
MOVES = ("PTP", "LIN", "CIRC", "PTP_REL", "LIN_REL", "CIRC_REL", "SPL", "SLIN", "SCIRC", "SPTP", "SLIN_REL", "SCIRC_REL", "SPL_REL", "SPTP_REL")
SKIP = re.compile(r"^(HALT|WAIT\b|CONTINUE|INTERRUPT\b|TRIGGER\b|PULSE\b|ANOUT\b|ANIN\b|BRAKE|SIGNAL\b|EXT\b|EXTFCT\b|IMPORT\b|ENUM\b|STRUC\b|"
                  r"TIME_BLOCK\b|CONST_VEL\b|STOP\s+WHEN)", re.I)


def strip_comment(t):
    out, q = [], False
    for c in t:
        if c == '"':
            q = not q
        if c == ";" and not q:
            break
        out.append(c)
    return "".join(out).strip()


class Exit(Exception):
    pass


class Return(Exception):
    def __init__(self, v):
        self.v = v


class Goto(Exception):
    def __init__(self, label):
        self.label = label


class Proc:
    def __init__(self, module, file, line, name, params, is_func, public):
        self.module, self.file, self.line, self.name, self.params, self.is_func, self.public = module, file, line, name, params, is_func, public
        self.lines, self.body = [], None


class Krl:
    def __init__(self, files, main, options):
        self.files, self.main, self.options = files, main, options
        self.moves, self.procs, self.glob, self.mods, self.types = [], {}, {}, {}, {}
        self.steps = 0
        self.flange = None          # pose of the flange in the root frame, once known
        self.sys = {"$NULLFRAME": dict(zip(XYZABC, [0.0] * 6)), "$WORLD": dict(zip(XYZABC, [0.0] * 6))}
        self.sys["$NULLFRAME"]["_"] = self.sys["$WORLD"]["_"] = "FRAME"
        self.base_key, self.tool_key = None, None   # names of frames whose values nobody tells
        self.first = None
        self.fn, self.ln = main, 1
        self.load()

    def no(self, why):
        raise Refused(self.fn, self.ln, why)

    # ---- files
    def load(self):
        mainmod = self.main.rsplit(".", 1)[0].upper()
        for fn in sorted(self.files, key=lambda f: (not f.lower().endswith("config.dat"), f)):
            low = fn.lower()
            if not (low.endswith(".src") or low.endswith(".dat") or low.endswith(".sub")):
                continue
            text = self.files[fn].decode("latin-1")
            mod = fn.rsplit("/", 1)[-1].rsplit(".", 1)[0].upper()
            cur, first = None, True
            for n, raw in enumerate(re.split(r"\r\n|\n|\r", text), 1):
                t = strip_comment(raw)
                self.fn, self.ln = fn, n
                if not t or t.startswith("&"):
                    continue
                if low.endswith(".dat"):
                    if re.match(r"(?i)(DEFDAT|ENDDAT)\b", t) or SKIP.match(t):
                        continue
                    glob = "CONFIG" in mod or bool(re.search(r"(?i)\bGLOBAL\b", t))
                    self.declare(t, self.glob if glob else self.mods.setdefault(mod, {}), {"mod": mod, "vars": {}}, True)
                    continue
                m = re.match(r"(?i)(GLOBAL\s+)?(DEF|DEFFCT)\s+(?:(\w+)\s+)?([$\w]+)\s*\((.*)\)\s*$", t)
                if m and not re.match(r"(?i)DEFDAT", t):
                    params = [tuple(x.strip().upper() for x in (p.split(":") + ["OUT"])[:2]) for p in m.group(5).split(",") if p.strip()]
                    cur = Proc(mod, fn, n, m.group(4).upper(), params, m.group(2).upper() == "DEFFCT", first or bool(m.group(1)))
                    self.procs[(mod, cur.name)] = cur
                    if first:
                        self.mods.setdefault(mod, {})
                        if fn == self.main:
                            self.entry = cur
                    first = False
                elif re.match(r"(?i)(END|ENDFCT)\s*$", t):
                    cur = None
                elif cur is not None:
                    cur.lines.append((n, t))
        if not hasattr(self, "entry"):
            raise Refused(self.main, 1, "no DEF in the file")

    # ---- blocks
    def parse(self, p):
        """Lines of a routine as a tree."""
        self.fn = p.file
        pos = [0]

        def block(ends):
            out = []
            while pos[0] < len(p.lines):
                n, t = p.lines[pos[0]]
                up = t.upper()
                word = re.match(r"[$\w]*", up).group(0)
                if word in ends:
                    return out
                pos[0] += 1
                self.ln = n
                if word == "FOR":
                    m = re.match(r"(?i)FOR\s+([$\w]+)\s*=\s*(.+?)\s+TO\s+(.+?)(?:\s+STEP\s+(.+))?$", t)
                    body = block(("ENDFOR",)); pos[0] += 1
                    out.append((n, "for", m.group(1).upper(), m.group(2), m.group(3), m.group(4) or "1", body))
                elif word == "WHILE":
                    body = block(("ENDWHILE",)); pos[0] += 1
                    out.append((n, "while", t[5:], body))
                elif word == "REPEAT":
                    body = block(("UNTIL",)); u = p.lines[pos[0]]; pos[0] += 1
                    out.append((n, "repeat", u[1][5:], body))
                elif word == "LOOP":
                    body = block(("ENDLOOP",)); pos[0] += 1
                    out.append((n, "loop", body))
                elif word == "IF":
                    m = re.match(r"(?i)IF\b(.*)\bTHEN\s*$", t)
                    a = block(("ELSE", "ENDIF")); b = []
                    if p.lines[pos[0]][1].upper().startswith("ELSE"):
                        pos[0] += 1
                        b = block(("ENDIF",))
                    pos[0] += 1
                    out.append((n, "if", m.group(1), a, b))
                elif word == "SWITCH":
                    cases, default = [], None
                    if block(("CASE", "DEFAULT", "ENDSWITCH")):
                        self.no("statements before CASE")
                    while p.lines[pos[0]][1].upper() != "ENDSWITCH":
                        u = p.lines[pos[0]][1]; pos[0] += 1
                        body = block(("CASE", "DEFAULT", "ENDSWITCH"))
                        if u.upper().startswith("DEFAULT"):
                            default = body
                        else:
                            cases.append((u[4:], body))
                    pos[0] += 1
                    out.append((n, "switch", t[6:], cases, default))
                elif word == "SPLINE":
                    body = block(("ENDSPLINE",)); tail = p.lines[pos[0]]; pos[0] += 1
                    out.append((n, "spline", t[6:], body, tail[1]))
                else:
                    out.append((n, "line", t))
            if ends:
                self.no("block does not end: " + "/".join(ends))
            return out
        p.body = block(())

    # ---- expressions
    def tokens(self, t):
        out, i = [], 0
        t = t.rstrip()
        while i < len(t):
            m = TOK.match(t, i)
            if not m or m.end() == i:
                self.no("cannot read: " + t[i:i + 20])
            k = m.lastgroup
            out.append((k, m.group(k)))
            i = m.end()
        return out

    def expr(self, t, env):
        ts = self.tokens(t) if isinstance(t, str) else t
        v, i = self.e_or(ts, 0, env)
        if i != len(ts):
            self.no("left over: " + " ".join(x[1] for x in ts[i:]))
        return v

    # XP ch. operators: NOT, then * /, + -, AND, EXOR, OR, comparisons (as known). Comparisons are read tighter than AND here, which only
    # differs where nobody writes brackets and the control has no meaning for it.
    def e_or(self, ts, i, env):
        v, i = self.e_and(ts, i, env)
        while i < len(ts) and ts[i][1].upper() in ("OR", "EXOR"):
            o = ts[i][1].upper()
            w, i = self.e_and(ts, i + 1, env)
            v = (v or w) if o == "OR" else (v != w)
        return v, i

    def e_and(self, ts, i, env):
        v, i = self.e_cmp(ts, i, env)
        while i < len(ts) and ts[i][1].upper() == "AND":
            w, i = self.e_cmp(ts, i + 1, env)
            v = v and w
        return v, i

    def e_cmp(self, ts, i, env):
        v, i = self.e_sum(ts, i, env)
        while i < len(ts) and ts[i][1] in ("==", "<>", "<", ">", "<=", ">="):
            o = ts[i][1]
            w, i = self.e_sum(ts, i + 1, env)
            v = {"==": lambda: v == w, "<>": lambda: v != w, "<": lambda: v < w, ">": lambda: v > w, "<=": lambda: v <= w, ">=": lambda: v >= w}[o]()
        return v, i

    def e_sum(self, ts, i, env):
        v, i = self.e_mul(ts, i, env)
        while i < len(ts) and ts[i][1] in ("+", "-"):
            o = ts[i][1]
            w, i = self.e_mul(ts, i + 1, env)
            v = v + w if o == "+" else v - w
        return v, i

    def e_mul(self, ts, i, env):
        v, i = self.e_geo(ts, i, env)
        while i < len(ts) and ts[i][1] in ("*", "/"):
            o = ts[i][1]
            w, i = self.e_geo(ts, i + 1, env)
            if o == "*":
                v = v * w
            elif isinstance(v, int) and isinstance(w, int):
                # XP, arithmetic operators: INT / INT is INT, the rest is dropped (as known)
                q = abs(v) // abs(w)
                v = q if (v < 0) == (w < 0) else -q
            else:
                v = v / w
        return v, i

    def e_geo(self, ts, i, env):
        # XP, geometric operator: frame product from left to right; the type is that of the right operand (as known; product looked up)
        v, i = self.e_un(ts, i, env)
        while i < len(ts) and ts[i][1] == ":":
            w, i = self.e_un(ts, i + 1, env)
            f = fmul(self.frame(v), self.frame(w))
            a = to_zyx(f[0])
            r = {k: x for k, x in zip(XYZABC, f[1] + a)}
            r["_"] = "POS" if "POS" in (w.get("_", "") + v.get("_", "")) else "FRAME"
            v = r
        return v, i

    def e_un(self, ts, i, env):
        if i >= len(ts):
            self.no("expression ends early")
        x = ts[i][1].upper()
        if x == "-":
            v, i = self.e_un(ts, i + 1, env)
            return -v, i
        if x == "+":
            return self.e_un(ts, i + 1, env)
        if x == "NOT":
            v, i = self.e_un(ts, i + 1, env)
            return not v, i
        return self.e_prim(ts, i, env)

    def e_prim(self, ts, i, env):
        k, x = ts[i]
        if k == "num":
            return (float(x) if re.search(r"[.eE]", x) else int(x)), i + 1
        if k == "str":
            return x[1:-1], i + 1
        if k == "enum":
            return x.upper(), i + 1
        if k == "bit":
            return int(x[2:-1], 16 if x[1] in "Hh" else 2), i + 1
        if x == "(":
            v, i = self.e_or(ts, i + 1, env)
            return v, self.need(ts, i, ")")
        if x == "{":
            return self.aggregate(ts, i + 1, env)
        if k == "name":
            up = x.upper()
            if up in ("TRUE", "FALSE"):
                return up == "TRUE", i + 1
            if i + 1 < len(ts) and ts[i + 1][1] == "(":
                args, j = [], i + 2
                while ts[j][1] != ")":
                    a0 = j
                    v, j = self.e_or(ts, j, env)
                    args.append((v, ts[a0:j]))
                    if ts[j][1] == ",":
                        j += 1
                return self.func(up, args, env), j + 1
            ref, i = self.ref(ts, i, env)
            v = ref[0]()
            if v is None:
                self.no(f"{x} has no value")
            return v, i
        self.no("unexpected " + x)

    def need(self, ts, i, what):
        if i >= len(ts) or ts[i][1] != what:
            self.no("expected " + what)
        return i + 1

    def aggregate(self, ts, i, env):
        # SI 11.4: { [type:] component value, … } (as known); the type may be left out (looked up)
        out = {}
        if ts[i][0] == "name" and ts[i + 1][1] == ":":
            out["_"] = ts[i][1].upper()
            i += 2
        while ts[i][1] != "}":
            name = ts[i][1].upper()
            i += 1
            if ts[i][1] == "[":       # POINT2[] "…"
                i = self.need(ts, i + 1, "]")
            v, i = self.e_or(ts, i, env)
            out[name] = v
            if ts[i][1] == ",":
                i += 1
        if "_" not in out:
            ks = set(out)
            out["_"] = ("E6AXIS" if ks & {"A1", "A2", "A3", "A4", "A5", "A6"} else
                        "E6POS" if ks & {"E1", "E2", "E3", "E4", "E5", "E6"} else "POS" if ks & {"S", "T"} else "FRAME")
        return out, i + 1

    def func(self, name, args, env):
        a = [x[0] for x in args]
        if name in ("SIN", "COS", "TAN"):      # degrees (XP, standard functions; as known)
            return getattr(math, name.lower())(math.radians(a[0]))
        if name == "ACOS":
            return math.degrees(math.acos(a[0]))
        if name == "ATAN2":                    # ATAN2(Y, X)
            return math.degrees(math.atan2(a[0], a[1]))
        if name == "SQRT":
            return math.sqrt(a[0])
        if name == "ABS":
            return abs(a[0])
        if name == "INV_POS":
            f = finv(self.frame(a[0]))
            return dict(zip(XYZABC, f[1] + to_zyx(f[0])), _="FRAME")
        p = self.find(name, env)
        if p is None or not p.is_func:
            self.no(f"function {name} is not known")
        return self.call(p, args, env)

    def ref(self, ts, i, env):
        """(get, set) of a variable with its indices and components."""
        name = ts[i][1].upper()
        i += 1
        path = []
        while i < len(ts) and ts[i][1] in ("[", "."):
            if ts[i][1] == ".":
                path.append(ts[i + 1][1].upper())
                i += 2
            else:
                idx = []
                i += 1
                while ts[i][1] != "]":
                    v, i = self.e_or(ts, i, env)
                    idx.append(v)
                    if ts[i][1] == ",":
                        i += 1
                i += 1
                path.append(tuple(idx))
        store = self.store(name, env)

        def get():
            if name in ("$POS_ACT", "$POS_INT", "$POS_FOR"):
                v = self.current()
            else:
                v = store.get(name)
            for q in path:
                if v is None:
                    return None
                v = v.get(q)
            return v

        def put(val):
            if name.startswith("$") and not path:
                store[name] = copy.deepcopy(val)
                return
            if not path:
                t = env["types"].get(name) or self.types.get((env["mod"], name)) or self.types.get(("", name))
                store[name] = self.conv(t, copy.deepcopy(val))
                return
            v = store.setdefault(name, {})
            if v is None:
                v = store[name] = {}
            for q in path[:-1]:
                v = v.setdefault(q, {})
            v[path[-1]] = copy.deepcopy(val)
        return (get, put, name, path), i

    def conv(self, t, val):
        if t == "INT" and isinstance(val, float):
            if abs(abs(val) % 1 - 0.5) < 1e-4:
                self.no("a REAL halfway between two INT is given to one")
            return math.floor(val + 0.5)
        if t == "REAL" and isinstance(val, int) and not isinstance(val, bool):
            return float(val)
        if isinstance(val, dict) and t in ("FRAME", "POS", "E6POS", "AXIS", "E6AXIS"):
            val["_"] = t
        return val

    def store(self, name, env):
        if name.startswith("$"):
            return self.sys
        if name in env["vars"]:
            return env["vars"]
        m = self.mods.get(env["mod"], {})
        if name in m:
            return m
        if name in self.glob:
            return self.glob
        return env["vars"]

    # ---- declarations
    def declare(self, t, store, env, in_dat=False):
        m = re.match(r"(?i)(?:GLOBAL\s+)?(DECL\s+)?(?:GLOBAL\s+)?(?:CONST\s+)?(\w+)\s+(.+)$", t)
        if in_dat and not (m and (m.group(1) or m.group(2).upper() in BASIC)):
            # BASE_DATA[1]={…}, in $config.dat
            ts = self.tokens(t)
            if ts[0][0] != "name":
                self.no("not read in a .dat: " + t)
            eq = next((k for k, x in enumerate(ts) if x[1] == "="), None)
            if eq is None:
                self.no("not read in a .dat: " + t)
            name = ts[0][1].upper()
            val = self.expr(ts[eq + 1:], {"vars": {}, "types": {}, "mod": env["mod"]})
            idx = tuple(int(x[1]) for x in ts[1:eq] if x[0] == "num")
            if idx:
                store.setdefault(name, {})[idx] = val
            else:
                store[name] = val
            return True
        if not m or not (m.group(1) or m.group(2).upper() in BASIC):
            return False
        typ = m.group(2).upper()
        rest = self.tokens(m.group(3))
        i = 0
        while i < len(rest):
            name = rest[i][1].upper()
            i += 1
            dims = ()
            arr = False
            if i < len(rest) and rest[i][1] == "[":
                arr = True
                j = i
                while rest[j][1] != "]":
                    j += 1
                dims = tuple(int(x[1]) for x in rest[i:j] if x[0] == "num")
                i = j + 1
            val = {} if arr else None
            if i < len(rest) and rest[i][1] == "=":
                val, i = self.e_or(rest, i + 1, dict(env, types={}, vars=env.get("vars", {})))
                val = self.conv(typ, val)
            # a parameter is declared again with its type, and keeps what it was given (SI 11.7; as known)
            store[name] = self.conv(typ, store[name]) if val is None and store is env.get("vars") and name in store else val
            (env.get("types") if "types" in env else {}).__setitem__(name, None if arr else typ)
            if in_dat:
                self.types[("" if store is self.glob else env["mod"], name)] = None if arr else typ
            if i < len(rest):
                i = self.need(rest, i, ",")
        return True

    # ---- frames
    def frame(self, d):
        try:
            return (zyx(d["A"], d["B"], d["C"]), (float(d["X"]), float(d["Y"]), float(d["Z"])))
        except KeyError as k:
            self.no(f"frame without {k}")

    def setframe(self, what, val, key):
        if what == "$BASE":
            self.base_key, self.base = key, (self.frame(val) if val is not None else NULL)
        else:
            self.tool_key, self.tool = key, (self.frame(val) if val is not None else NULL)

    base, tool = NULL, NULL

    def current(self):
        if self.flange is None:
            self.no("the position before is not known")
        if self.flange[1:] != (self.base_key, self.tool_key) and (self.flange[1] or self.flange[2] or self.base_key or self.tool_key):
            self.no("the position in another base or tool whose numbers are not known")
        f = fmul(finv(self.base), fmul(self.flange[0], self.tool))
        return dict(zip(XYZABC, f[1] + to_zyx(f[0])), _="POS", **{"#f": f})

    def target(self, v, rel, tool):
        """Pose in the base of an aggregate; missing components are those of the position before (SI 11.5; as known)."""
        if rel:
            c = self.current()["#f"]
            d = {k: float(v.get(k, 0.0)) for k in XYZABC}
            if tool:
                return fmul(c, self.frame(d))
            if any(d[k] for k in "ABC"):
                self.no("A, B, C in a relative move in the base")
            return (c[0], add(c[1], (d["X"], d["Y"], d["Z"])))
        if all(k in v for k in XYZABC):
            return self.frame(v)
        c = self.current()
        if all(k not in v for k in "ABC"):
            return (c["#f"][0], tuple(float(v.get(k, p)) for k, p in zip("XYZ", c["#f"][1])))
        return self.frame({k: v.get(k, c[k]) for k in XYZABC})

    def world(self, pose):
        f = fmul(self.base, pose)
        if self.first is None:
            self.first = (self.base, self.base_key)
        if self.base_key != self.first[1]:
            self.no("several bases, of which the numbers of one are not known")
        return fmul(finv(self.first[0]), f)

    # ---- moves
    def motion(self, word, t, env, spline=False):
        ts = self.tokens(t)
        rel = word.endswith("_REL")
        w = word[:-4] if rel else word
        i, pts = 1, []
        n = 2 if w in ("CIRC", "SCIRC") else 1
        act = False
        for k in range(n):
            if k:
                i = self.need(ts, i, ",")
            act = ts[i][1].upper() in ("$POS_ACT", "$AXIS_ACT")
            if ts[i][1].upper() == "$AXIS_ACT":
                v, i = {"_": "E6AXIS"}, i + 1
            else:
                v, i = self.e_geo(ts, i, env)
            pts.append(v)
        ca, zone, tool, feed = None, 0.0, False, self.vel()
        while i < len(ts):
            x = ts[i][1].upper()
            i += 1
            if x == ",":
                continue
            if x == "CA":
                ca, i = self.e_sum(ts, i, env)
            elif x == "#TOOL":
                tool = True
            elif x == "#BASE":
                pass
            elif x == "C_DIS":
                z = self.sys.get("$APO", {})
                zone = z.get("CDIS") if isinstance(z, dict) else None
            elif x in ("C_PTP", "C_VEL", "C_ORI", "C_SPL"):
                zone = None if zone == 0.0 else zone
            elif x == "WITH":
                while i < len(ts):
                    q = ts[i][1].upper()
                    j = i
                    while ts[j][1] != "=":
                        j += 1
                    v, j = self.e_or(ts, j + 1, env)
                    if q == "$VEL" and ts[i + 2][1].upper() == "CP":
                        feed = v * 60000
                    if q in ("$BASE", "$TOOL"):
                        self.no("WITH $BASE or $TOOL")
                    i = j
                    if i < len(ts) and ts[i][1] == ",":
                        i += 1
                        continue
                    break
            else:
                self.no("not read behind a move: " + x)
        joint = w in ("PTP", "SPTP")
        if act:
            return              # to where the robot is: the move to the programmed path before the first one (BCO)
        if pts[0].get("_") in ("AXIS", "E6AXIS"):
            if not joint:
                self.no("axes as the target of a path")
            self.flange = None
            keys = sorted(k for k in pts[0] if re.match(r"A[1-6]$", k))
            self.moves.append(RMove("joint", self.fn, self.ln, None, joints=tuple((k, float(pts[0][k])) for k in keys) + (("REL", rel),)))
            return
        if joint and rel and tool is False and any(pts[0].get(k) for k in "ABC"):
            self.no("A, B, C in a relative move in the base")
        poses = [self.target(v, rel, tool) if k == n - 1 else self.aux(v, rel, tool) for k, v in enumerate(pts)]
        start = self.world(self.current()["#f"]) if self.flange and self.flange[1:] == (self.base_key, self.tool_key) else None
        end = poses[-1]
        ew = self.world(end)
        kind = "rapid" if joint else {"LIN": "line", "SLIN": "line", "SPL": "spline"}.get(w, "arc")
        centre = turn = via = None
        if kind == "arc":
            if start is None:
                self.no("an arc whose start is not known")
            via = self.world((end[0], poses[0]))[1]
            c = circle(start[1], via, ew[1])
            if c is None:
                self.no("an arc through three points in line")
            centre, r, axis, ang = c
            if ca is not None:
                # SI 9.x / 11.6 (as known): CA is the whole angle, above 0 in the sense start -> auxiliary -> end, below 0 against it;
                # the programmed end then only defines the circle
                if norm(sub(to_v(start[0]), to_v(ew[0]))) > 1e-9:
                    self.no("CA with a turn of the tool")
                ang = math.radians(ca)
                ew = (ew[0], add(centre, turn_about(axis, ang, sub(start[1], centre))))
            turn = sca(ang, axis)
        self.moves.append(RMove(kind, self.fn, self.ln, ew[1], ew[0], centre, turn, None if joint else feed, via, start and start[1], zone, self.tool[0]))
        here = fmul(self.first[0], ew)
        self.flange = (fmul(here, finv(self.tool)), self.base_key, self.tool_key)

    def aux(self, v, rel, tool):
        c = self.current()["#f"]
        if rel:
            d = tuple(float(v.get(k, 0.0)) for k in "XYZ")
            return add(c[1], app(c[0], d) if tool else d)
        return tuple(float(v.get(k, p)) for k, p in zip("XYZ", c[1]))

    def vel(self):
        v = self.sys.get("$VEL")
        return v["CP"] * 60000 if isinstance(v, dict) and v.get("CP") is not None else None

    # ---- statements
    def call(self, p, args, env):
        new = {"vars": {}, "types": {}, "mod": p.module, "depth": env.get("depth", 0) + 1}
        if new["depth"] > 50:
            self.no("calls too deep")
        outs = []
        for (name, way), (v, ts) in zip(p.params, args):
            new["vars"][name] = copy.deepcopy(v)
            if way == "OUT" and ts and ts[0][0] == "name":
                outs.append((name, ts))
        back = (self.fn, self.ln)
        if p.body is None:
            self.parse(p)
        self.fn = p.file
        ret = None
        try:
            self.routine(p.body, new)
        except Return as r:
            ret = r.v
        self.fn, self.ln = back
        for name, ts in outs:
            (g, put, _, _), _ = self.ref(ts, 0, env)
            put(new["vars"][name])
        return ret

    def routine(self, body, env):
        start = 0
        while True:
            try:
                self.run(body[start:], env)
                return
            except Goto as g:
                for k, s in enumerate(body):
                    if s[1] == "line" and s[2].upper().rstrip() == g.label + ":":
                        start = k
                        break
                else:
                    self.no("GOTO into a block: not followed")

    def find(self, name, env):
        p = self.procs.get((env["mod"], name))
        if p:
            return p
        for (m, n), q in self.procs.items():
            if n == name and q.public:
                return q
        return None

    def run(self, body, env):
        for s in body:
            self.ln = s[0]
            self.steps += 1
            if self.steps > 200000:
                self.no("does not end")
            k = s[1]
            if k == "line":
                self.line(s[2], env)
            elif k in ("if", "loop") and idle([s]):
                continue
            elif k == "for":
                g, put = self.var(s[2], env)
                v, end, step = (self.expr(s[j], env) for j in (3, 4, 5))
                put(v)
                while (v <= end) if step > 0 else (v >= end):
                    try:
                        self.run(s[6], env)
                    except Exit:
                        break
                    v = g() + step
                    put(v)
                    self.ln = s[0]
            elif k == "while":
                try:
                    while self.expr(s[2], env):
                        self.run(s[3], env)
                        self.ln = s[0]
                        self.steps += 1
                        if self.steps > 200000:
                            self.no("does not end")
                except Exit:
                    pass
            elif k == "repeat":
                try:
                    while True:
                        self.run(s[3], env)
                        self.steps += 1
                        if self.steps > 200000:
                            self.no("does not end")
                        if self.expr(s[2], env):
                            break
                except Exit:
                    pass
            elif k == "loop":
                try:
                    while True:
                        self.run(s[2], env)
                        self.steps += 1
                        if self.steps > 200000:
                            self.no("does not end")
                except Exit:
                    pass
            elif k == "if":
                self.run(s[3] if self.expr(s[2], env) else s[4], env)
            elif k == "switch":
                v = self.expr(s[2], env)
                for cs, b in s[3]:
                    if any(self.expr(c, env) == v for c in self.split(cs)):
                        self.run(b, env)
                        break
                else:
                    if s[4] is not None:
                        self.run(s[4], env)
            elif k == "spline":
                keep = copy.deepcopy(self.sys)
                t = s[2].strip()
                if t:
                    for a in self.split(re.sub(r"(?i)^WITH\b", "", t)):
                        self.assign(a, env)
                self.run(s[3], env)
                self.sys = keep

    def split(self, t):
        out, d, cur = [], 0, ""
        for c in t:
            d += (c in "([{") - (c in ")]}")
            if c == "," and d == 0:
                out.append(cur)
                cur = ""
            else:
                cur += c
        return out + [cur]

    def var(self, name, env):
        (g, put, _, _), _ = self.ref(self.tokens(name), 0, env)
        return g, put

    def line(self, t, env):
        word = re.match(r"[$\w]*", t).group(0).upper()
        if word in MOVES:
            return self.motion(word, t, env)
        if SKIP.match(t):
            return
        if word == "EXIT":
            raise Exit()
        if word == "RETURN":
            raise Return(self.expr(t[6:], env) if t[6:].strip() else None)
        if word == "GOTO":
            raise Goto(t[4:].strip().upper())
        if re.match(r"\w+:\s*$", t):
            return
        if word == "DECL" or word in BASIC:
            if self.declare(t, env["vars"], env):
                return
        if word == "BAS" or word == "BAS ":
            return self.bas(t, env)
        m = re.match(r"([\w]+)\s*\((.*)\)\s*$", t)
        if m and self.find(m.group(1).upper(), env):
            ts = self.tokens(m.group(2)) if m.group(2).strip() else []
            args, i = [], 0
            while i < len(ts):
                a0 = i
                v, i = self.e_or(ts, i, env)
                args.append((v, ts[a0:i]))
                if i < len(ts):
                    i = self.need(ts, i, ",")
            self.call(self.find(m.group(1).upper(), env), args, env)
            return
        if m and "=" not in m.group(1):
            if m.group(1).upper() in [c.upper() for c in self.options.get("calls_kept", [])]:
                return
            self.no(f"subprogram {m.group(1)} is not beside the program")
        self.assign(t, env)

    def assign(self, t, env):
        ts = self.tokens(t)
        if not ts or ts[0][0] != "name":
            self.no("not read: " + t)
        if ts[0][1].upper() in ("$OUT", "$ANOUT", "$FLAG", "$CYCFLAG", "$TIMER", "$TIMER_STOP"):
            return
        (g, put, name, path), i = self.ref(ts, 0, env)
        i = self.need(ts, i, "=")
        rhs = ts[i:]
        if name in ("$BASE", "$TOOL") and not path:
            arr = rhs[0][1].upper()
            if arr in ("BASE_DATA", "TOOL_DATA") and rhs[-1][1] == "]":
                (g2, _, _, p2), _ = self.ref(rhs, 0, env)
                v = g2()
                self.setframe(name, v, None if v is not None else (arr, p2[0]))
                put(v)
                return
            v = self.expr(rhs, env)
            self.setframe(name, v, None)
            put(v)
            return
        if name in ("$BASE", "$TOOL"):
            v = self.expr(rhs, env)
            put(v)
            self.setframe(name, self.sys[name], None)
            return
        if name == "$IPO_MODE" and self.expr(rhs, env) == "#BASE":
            self.no("a stationary tool ($IPO_MODE=#BASE)")
        put(self.expr(rhs, env))

    def bas(self, t, env):
        # bas.src of every controller (as known): #INITMOV, #TOOL, #BASE, #VEL_CP, #VEL_PTP, #ACC_CP, #ACC_PTP, #CP_PARAMS, #PTP_PARAMS, #FRAMES
        args = [self.expr(a, env) for a in self.split(re.match(r"(?i)BAS\s*\((.*)\)\s*$", t).group(1))]
        cmd, v = args[0], (args[1] if len(args) > 1 else None)
        if cmd in ("#TOOL", "#BASE"):
            arr, sysv = ("TOOL_DATA", "$TOOL") if cmd == "#TOOL" else ("BASE_DATA", "$BASE")
            self.pick(sysv, arr, int(v))
        elif cmd == "#VEL_CP":
            self.sys.setdefault("$VEL", {})["CP"] = float(v)
        elif cmd in ("#CP_PARAMS", "#PTP_PARAMS", "#FRAMES"):
            if cmd == "#CP_PARAMS":
                self.sys.setdefault("$VEL", {})["CP"] = float(v)
            st = self.store("FDAT_ACT", env)
            f = st.get("FDAT_ACT")
            if f:
                if f.get("IPO_FRAME", "#BASE") != "#BASE":
                    self.no("a stationary tool (IPO_FRAME)")
                self.pick("$TOOL", "TOOL_DATA", f["TOOL_NO"])
                self.pick("$BASE", "BASE_DATA", f["BASE_NO"])
            ld = self.store("LDAT_ACT", env).get("LDAT_ACT")
            if cmd == "#CP_PARAMS" and ld and "APO_DIST" in ld:
                self.sys.setdefault("$APO", {})["CDIS"] = float(ld["APO_DIST"])
        elif cmd not in ("#INITMOV", "#VEL_PTP", "#ACC_CP", "#ACC_PTP", "#OV_PRO"):
            self.no("BAS(" + str(cmd))

    def pick(self, sysv, arr, n):
        if n == 0:
            self.setframe(sysv, self.sys["$NULLFRAME"], None)
            return
        v = self.glob.get(arr, {}).get((n,))
        self.setframe(sysv, v, None if v is not None else (arr, (n,)))


FLOW_ONLY = ("out", "through", "grid", "array", "ints", "goto", "early", "data", "speed", "bases", "stay")
FLOWS = ("lin", "lin", "arc", "geo", "for", "while", "repeat", "loop", "if", "switch", "sub", "func", "misc",
    "retract", "base", "joint", "zig") + 2 * FLOW_ONLY
BASIC = ("INT", "REAL", "BOOL", "CHAR", "FRAME", "POS", "E6POS", "AXIS", "E6AXIS", "FDAT", "LDAT", "PDAT", "LOAD")


def idle(body, in_loop=False):
    """Whether a block only sets outputs and waits: what it depends on does not matter to where the robot goes."""
    kept = r"(?i)(\$OUT\[|WAIT\b" + (r"|EXIT\s*$)" if in_loop else ")")
    return all(re.match(kept, s[2]) if s[1] == "line" else s[1] in ("if", "loop") and
               all(idle(b, in_loop or s[1] == "loop") for b in s[2:] if isinstance(b, list)) for s in body)


def to_v(r):
    return tuple(x for row in r for x in row)


def trace(files, main, options):
    k = Krl(files, main, options)
    try:
        k.call(k.entry, [], {"vars": {}, "types": {}, "mod": k.entry.module})
    except RecursionError:
        k.no("too deep")
    except UNREAD as e:
        raise Refused(k.fn, k.ln, f"not read ({type(e).__name__}: {e})")
    return k.moves


def run(files, main, options):
    return [m for m in trace(files, main, options) if m.end is not None]


# ---- random programs
def generate(seed):
    r = random.Random(f"krl{seed}")
    for k in range(50):
        g = Gen(r)
        files, main, options = g.make()
        try:
            mv = run(files, main, options)
        except Refused as e:       # three points that rounding put in line
            if "in line" in e.why:
                continue
            raise
        if len(mv) >= 5 and all(max(abs(c) for c in m.end) <= 300 for m in mv) and \
                all(m.kind != "arc" or dist(m.start, m.centre) >= 1 for m in mv) and len(files[main].splitlines()) <= 75 and \
                any(m.kind in ("line", "arc", "spline") for m in mv):
            return files, main, options
    raise AssertionError("no program")


class Gen:
    def __init__(self, r):
        self.r = r
        self.dec = r.choice([1, 2, 3, 3, 4])
        self.low = r.random() < 0.15
        self.ind = r.choice(["", "", "  ", "   "])
        self.tilt = r.choice([(0.0, 0.0, 180.0), (0.0, 0.0, 180.0), (90.0, 0.0, 180.0), (0.0, 90.0, 0.0),
                              tuple(round(r.uniform(-40, 40), 2) + b for b in (0, 0, 180)), (round(r.uniform(-170, 170), 1), round(r.uniform(-25, 25), 1), 180.0)])
        self.vary = r.random() < .25      # the tool turns along the path
        self.full = r.choice(["plain", "e6", "type", "plain"])
        self.dat, self.pts, self.decl, self.out, self.subs, self.extra = [], 0, [], [], [], {}
        self.style = r.choice(["data", "data", "bas", "literal", "inline", "none", "nullbase", "datlocal"])
        self.cur = None
        self.vars = set()
        self.safe = 40.0
        self.wordcase = r.random() < 0.1

    def f(self, v):
        s = f"{v:.{self.dec}f}"
        if self.r.random() < 0.2 and "." in s:
            s = s.rstrip("0")
            s = s[:-1] if s.endswith(".") else s
        return "0" if s in ("-0", "") else s

    def rnd(self, a, b):
        return round(self.r.uniform(a, b), self.dec)

    def xy(self):
        return self.rnd(-100, 100), self.rnd(-100, 100)

    def agg(self, p, abc=None, full=True):
        abc = abc or self.abc()
        sep = self.r.choice([",", ", "])
        cs = [f"{k} {self.f(v)}" for k, v in zip("XYZ", p)]
        if full:
            cs += [f"{k} {v:g}" if self.r.random() < .5 else f"{k} {v:.3f}" for k, v in zip("ABC", abc)]
        if full and self.full == "e6":
            cs += self.r.choice([["E1 0", "E2 0", "E3 0", "E4 0", "E5 0", "E6 0"], ["S 2", "T 35", "E1 0.0", "E2 0.0", "E3 0.0", "E4 0.0", "E5 0.0", "E6 0.0"], ["E1 0.0"]])
        pre = ""
        if self.full == "type" and full:
            pre = self.r.choice(["POS: ", "FRAME: ", "POS:"])
        return "{" + pre + sep.join(cs) + "}"

    def abc(self):
        return self.tilt

    def put(self, t, ind=None):
        self.out.append((self.ind if ind is None else ind) + t)

    def point(self, p):
        self.pts += 1
        n = f"XP{self.pts}"
        abc = self.abc()
        self.dat.append(f"DECL E6POS {n}={{X {self.f(p[0])},Y {self.f(p[1])},Z {self.f(p[2])},A {abc[0]:g},B {abc[1]:g},C {abc[2]:g},S 2,T 10,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}}")
        return n

    def apo(self):
        return self.r.choice(["", "", " C_DIS", " C_DIS", " C_VEL", " C_DIS C_DIS"])

    def cutz(self):
        return self.rnd(-15, 4)

    def lin(self, p, word="LIN"):
        how = self.r.random()
        if self.vary and how < 0.55 and self.r.random() < .5 and word == "LIN" and self.cur is not None:
            self.tilt = tuple(round(a + self.r.uniform(-15, 15), 2) for a in self.tilt)
        if self.style == "inline" and how < 0.6:
            return self.inline(word, p)
        if how < 0.55 or self.cur is None:
            self.put(f"{word} {self.agg(p)}{self.apo()}")
        elif how < 0.7:
            n = self.point(p)
            self.put(f"{word} {n.lower() if self.r.random() < .3 else n}{self.apo()}")
        else:
            diff = [k for k, a, b in zip("XYZ", p, self.cur) if a != b] or ["X"]
            d = dict(zip("XYZ", p))
            self.put(f"{word} {{" + ",".join(f"{k} {self.f(d[k])}" for k in diff) + "}" + self.apo())
        self.cur = p

    def inline(self, word, p):
        self.pts += 1
        k = self.pts
        abc = self.abc()
        self.dat += [f"DECL E6POS XP{k}={{X {self.f(p[0])},Y {self.f(p[1])},Z {self.f(p[2])},A {abc[0]:g},B {abc[1]:g},C {abc[2]:g},S 6,T 27,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}}",
                     f'DECL FDAT FP{k}={{TOOL_NO 1,BASE_NO 1,IPO_FRAME #BASE,POINT2[] " "}}']
        cont = self.r.random() < .5
        if word == "LIN":
            self.dat.append(f"DECL LDAT LCPDAT{k}={{VEL 2.0,ACC 100.0,APO_DIST 3.0,APO_FAC 50.0,ORI_TYP #VAR}}")
            self.put(f";FOLD LIN P{k} {'CONT ' if cont else ''}Vel=0.05 m/s CPDAT{k} Tool[1]:mill Base[1]:part;%{{PE}}%R 8.3.31,%MKUKATPBASIS,%CMOVE,%VLIN,%P 1:LIN", "")
            self.put("$BWDSTART=FALSE", "")
            self.put(f"LDAT_ACT=LCPDAT{k}", "")
            self.put(f"FDAT_ACT=FP{k}", "")
            self.put("BAS(#CP_PARAMS,0.05)", "")
            self.put(f"LIN XP{k}" + (" C_DIS C_DIS" if cont else ""), "")
        else:
            self.dat.append(f"DECL PDAT PPDAT{k}={{VEL 100.0,ACC 100.0,APO_DIST 100.0}}")
            self.put(f";FOLD PTP P{k} Vel=100 % PDAT{k} Tool[1]:mill Base[1]:part;%{{PE}}%R 8.3.31,%MKUKATPBASIS,%CMOVE,%VPTP,%P 1:PTP", "")
            self.put("$BWDSTART=FALSE", "")
            self.put(f"PDAT_ACT=PPDAT{k}", "")
            self.put(f"FDAT_ACT=FP{k}", "")
            self.put("BAS(#PTP_PARAMS,100)", "")
            self.put(f"PTP XP{k}", "")
        self.put(";ENDFOLD", "")
        self.cur = p

    def arc(self, word="CIRC"):
        x, y, z = self.cur
        rad, a0 = self.r.uniform(3, 30), self.r.uniform(0, 2 * math.pi)
        sw = self.r.choice([-1, 1]) * self.r.uniform(0.5, 4.5)
        cx, cy = x - rad * math.cos(a0), y - rad * math.sin(a0)
        dz = self.r.choice([0, 0, 0, self.r.uniform(-3, 3)])
        q = lambda s: (round(cx + rad * math.cos(a0 + s), self.dec), round(cy + rad * math.sin(a0 + s), self.dec), round(z + dz * s / sw, self.dec))
        via, end = q(sw / 2), q(sw)
        mode = self.r.random()
        if dist(via, end) < 1 or dist(via, self.cur) < 1:
            return
        if mode < 0.5:
            self.put(f"{word} {self.agg(via)},{self.agg(end)}{self.apo()}")
            self.cur = end
        elif mode < 0.65:
            self.put(f"{word} {self.agg(via, full=False)}, {self.agg(end, full=False)}{self.apo()}")
            self.cur = end
        elif mode < 0.75:
            a, b = self.point(via), self.point(end)
            self.put(f"{word} {a},{b}{self.apo()}")
            self.cur = end
        elif mode < 0.85 and not SIMPLE and not FLOW:
            d1, d2 = sub(via, self.cur), sub(end, self.cur)
            self.put(f"{word}_REL {self.agg(d1, full=False)},{self.agg(d2, full=False)}")
            self.cur = tuple(round(c + round(d, self.dec), 6) for c, d in zip(self.cur, d2))
        else:
            ca = self.r.choice([90, 180, 360, 400, -90, -180, 270.5])
            self.put(f"{word} {self.agg(via)},{self.agg(end)},CA {ca}")
            self.lin((*self.xy(), self.cutz()))

    def retract(self):
        x, y, _ = self.cur
        p = (x, y, self.safe)
        if self.r.random() < 0.4:
            self.put(f"LIN_REL {{Z {self.f(round(self.safe - self.cur[2], self.dec))}}}")
            self.cur = (x, y, round(self.cur[2] + round(self.safe - self.cur[2], self.dec), 6))
        q = (*self.xy(), self.safe)
        if self.style == "inline" and self.r.random() < .7:
            self.inline("PTP", q)
        elif self.r.random() < .25:
            n = self.point(q)
            self.put(f"{'PTP' if SIMPLE or FLOW else self.r.choice(['PTP', 'PTP', 'SPTP'])} {n}")
        else:
            word = "PTP" if SIMPLE or FLOW else self.r.choice(["PTP", "PTP", "PTP", "SPTP"])
            self.put(f"{word} {self.agg(q)}" + self.r.choice(["", "", " C_PTP"]))
        self.cur = q
        self.lin((q[0], q[1], self.cutz()))

    def v(self, typ, name):
        if (typ, name) not in self.vars:
            self.vars.add((typ, name))
            self.decl.append(f"DECL {typ} {name}" if self.r.random() < .6 or typ not in BASIC else f"{typ} {name}")
        return name

    def op(self):
        r = self.r
        k = r.choice(["lin"] * 4 + ["arc"] * 3 + ["rel", "reltool", "geo", "for", "while", "repeat", "loop", "if", "switch", "sub", "subfile", "func",
                                                    "spline", "slin", "scirc", "misc", "misc", "retract", "base", "joint", "zig"])
        if FLOW:
            k = r.choice(FLOWS)
        if SIMPLE:
            k = r.choice(["lin", "lin", "arc", "rel", "misc", "retract", "joint", "base"])
        z = self.cutz()
        if k in FLOW_ONLY:
            getattr(self, "flow_" + k)(z)
        elif k == "lin":
            for _ in range(r.randint(1, 3)):
                self.lin((*self.xy(), r.choice([z, self.cur[2]])))
        elif k == "arc":
            self.arc()
        elif k == "rel":
            d = (self.rnd(-20, 20), self.rnd(-20, 20), 0.0)
            self.put("LIN_REL {X " + self.f(d[0]) + ",Y " + self.f(d[1]) + "}" + r.choice(["", " #BASE", " C_DIS", " C_DIS #BASE"]))
            self.cur = tuple(round(a + b, 6) for a, b in zip(self.cur, d))
        elif k == "reltool":
            self.put(r.choice(["LIN_REL {X 3,Z -5} #TOOL", "LIN_REL {Z -5.5} #TOOL", "LIN_REL {X 2,Y 1,Z 0,A 0,B 0,C 0} #TOOL"]))
            self.lin((*self.xy(), z))
        elif k == "geo":
            n = self.v("E6POS" if r.random() < .5 else "POS", "gp")
            p = (*self.xy(), z)
            if r.random() < .5:
                self.put(f"{n}={self.agg(p)}")
                self.put(f"LIN {n}:{{X {self.rnd(-9, 9)},Y 2,Z 0,A 0,B 0,C {r.choice([0, 0, 4.5])}}}")
            else:
                m = self.point(p)
                self.put(f"LIN {m}:{{X 5,Y {self.rnd(-9, 9)},Z -1.5,A {r.choice([0, 0, 8])},B 0,C 0}}")
            self.lin((*self.xy(), z)) if self.style != "inline" else self.put(f"LIN {self.agg((*self.xy(), z))}")
            x, y = self.xy()
            self.put(f"LIN {self.agg((x, y, z))}")
            self.cur = (x, y, z)
        elif k in ("for", "zig"):
            i, n = self.v("INT", "i"), self.v("POS", "wp")
            x, y = self.xy()
            self.put(f"{n}={self.agg((x, y, z))}")
            a, b, st = r.choice([(0, 2, None), (1, 3, 1), (4, 0, -2), (3, 1, -1), (0, 4, 2)])
            self.put(f"FOR {i}={a} TO {b}" + (f" STEP {st}" if st else ""))
            self.put(f"  {n}.Y={self.f(y)}+{i}*{self.rnd(1, 6)}")
            self.put(f"  LIN {n} C_DIS")
            self.put(f"  {n}.X={self.f(x)}{r.choice(['+', '-'])}{self.rnd(5, 30)}")
            self.put(f"  LIN {n}")
            if r.random() < .4:
                self.put(f"  IF ({i}=={a}) THEN")
                self.put("    LIN_REL {Z -0.5}")
                self.put("  ENDIF")
            if r.random() < .3:
                self.put(f"  {n}.X={self.f(x)}")
            self.put("ENDFOR")
            self.after()
        elif k in ("while", "repeat", "loop"):
            c = self.v("INT", "cnt")
            d = self.v("REAL", "dz")
            self.put(f"{c}={r.choice([0, 1])}")
            self.put(f"{d}={self.f(self.rnd(0.5, 2))}")
            body = [f"LIN_REL {{X {self.rnd(2, 8)}}}", f"LIN_REL {{Y {self.rnd(-8, 8)},Z -0.25}} C_DIS", f"{c}={c}+1"]
            if k == "while":
                self.put(f"WHILE {c}<3" if r.random() < .5 else f"WHILE ({c} < 3)")
            elif k == "repeat":
                self.put("REPEAT")
            else:
                self.put("LOOP")
            for b in body:
                self.put("  " + b)
            if k == "while":
                self.put("ENDWHILE")
            elif k == "repeat":
                self.put(f"UNTIL {c}>=3")
            else:
                self.put(f"  IF {c}>2 THEN")
                self.put("    EXIT")
                self.put("  ENDIF")
                self.put("ENDLOOP")
            self.after()
        elif k == "if":
            b = self.v("BOOL", "deep")
            self.put(f"{b}={r.choice(['TRUE', 'FALSE'])}")
            self.put(f"IF {r.choice([b, 'NOT ' + b, '(' + b + '==TRUE)'])} THEN")
            self.put(f"  LIN {self.agg((*self.xy(), z))}")
            if r.random() < .7:
                self.put("ELSE")
                self.put(f"  LIN {self.agg((*self.xy(), z))} C_DIS")
            self.put("ENDIF")
            self.after()
        elif k == "switch":
            c = self.v("INT", "sel")
            self.put(f"{c}={r.randint(1, 4)}")
            self.put(f"SWITCH {c}")
            for cs in ("1", "2,3"):
                self.put(f"CASE {cs}")
                self.put(f"  LIN {self.agg((*self.xy(), z))}")
            self.put("DEFAULT")
            self.put(f"  LIN {self.agg((*self.xy(), z))}")
            self.put("ENDSWITCH")
            self.after()
        elif k == "sub" and not any("slot" in s for s in self.subs):
            self.subs += ["", "DEF slot (lx:IN,depth:IN)", "REAL lx,depth", "LIN_REL {Z -1.0}", "rp={X 0,Y 0,Z 0,A 0,B 0,C 0}", "rp.X=lx", "rp.Z=depth", "LIN_REL rp",
                          "LIN_REL {Y 3.5} C_DIS", "END"]
            self.subs.insert(-8, "DECL POS rp")
            for _ in range(r.randint(1, 2)):
                self.put(f"slot({self.f(self.rnd(4, 15))},{self.f(self.rnd(-1, 0))})" if r.random() < .5 else f"slot ( {self.f(self.rnd(4, 15))} , -0.5 )")
            self.after()
        elif k == "subfile" and not self.extra:
            a, b = (*self.xy(), z), (*self.xy(), z)
            self.extra["CONTOUR.src"] = f"DEF CONTOUR( )\n;one contour\nLIN {self.agg(a)}\nLIN {self.agg(b)} C_DIS\nLIN_REL {{Z -1}}\nEND\n"
            self.put("CONTOUR( )")
            self.cur = (b[0], b[1], round(b[2] - 1, 6))
            if r.random() < .4:
                self.put("contour()")
        elif k == "func" and not any("half" in s for s in self.subs):
            self.subs += ["", "DEFFCT REAL half(v:IN)", "REAL v", "RETURN v/2.0", "ENDFCT"]
            d = self.v("REAL", "hh")
            n = self.v("POS", "wp")
            x, y = self.xy()
            self.put(f"{d}=half({self.f(x)})+SIN(30)*SQRT(16.0)")
            self.put(f"{n}={self.agg((x, y, z))}")
            self.put(f"{n}.X={d}")
            self.put(f"LIN {n}")
            self.after()
        elif k == "spline":
            self.put("SPLINE" + r.choice(["", " WITH $VEL.CP=0.03"]))
            for _ in range(r.randint(2, 4)):
                x, y = self.xy()
                q = r.random()
                if q < .4:
                    self.put(f"  SPL {self.agg((x, y, z))}")
                elif q < .75:
                    self.put(f"  SLIN {self.agg((x, y, z))}")
                else:
                    self.put(f"  SCIRC {self.agg((round(x + 20, 3), round(y + 7, 3), z))},{self.agg((x, y, z))}")
            self.put(f"  SLIN {self.agg((*self.xy(), z))}")
            self.put("ENDSPLINE" + r.choice(["", " C_SPL"]))
            self.after()
        elif k == "slin":
            x, y = self.xy()
            self.put(f"SLIN {self.agg((x, y, z))}" + r.choice(["", " WITH $VEL.CP=0.08", " C_SPL"]))
            self.cur = (x, y, z)
        elif k == "scirc":
            self.arc("SCIRC")
        elif k == "misc":
            self.put(r.choice(["; cut", "WAIT SEC 0.2", "$OUT[5]=TRUE", f"$VEL.CP={r.choice(['0.02', '0.015', '.05'])}", "$APO.CDIS=2.5", "", "HALT", "$ADVANCE=3",
                               ";FOLD SPINDLE ON", "WAIT FOR $IN[3]", "CONTINUE", "$ORI_TYPE=#VAR", "PULSE($OUT[2],TRUE,0.2)"]))
            if self.out[-1].strip() == ";FOLD SPINDLE ON":
                self.put("$OUT[12]=TRUE")
                self.put(";ENDFOLD")
        elif k == "retract":
            self.retract()
        elif k == "base" and self.style in ("data", "bas") and self.cfg:
            self.retract_up()
            self.put("$BASE=BASE_DATA[2]" if self.style == "data" else "BAS(#BASE,2)")
            q = (self.rnd(-40, 40), self.rnd(-40, 40), self.safe)
            self.put(f"PTP {self.agg(q)}")
            self.cur = q
            for _ in range(2):
                p = (self.rnd(-40, 40), self.rnd(-40, 40), z)
                self.put(f"LIN {self.agg(p)}")
                self.cur = p
            if r.random() < .6:
                self.retract_up()
                self.put("$BASE=BASE_DATA[1]" if self.style == "data" else "BAS (#BASE,1)")
                q = (*self.xy(), self.safe)
                self.put(f"PTP {self.agg(q)}")
                self.cur = q
                self.lin((q[0], q[1], z))
        elif k == "joint" and r.random() < .5:
            self.retract_up()
            self.put(r.choice(["PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}", "PTP XHOME", "PTP {E6AXIS: A1 5,A2 -80,A3 100,A4 0,A5 20,A6 0,E1 0,E2 0,E3 0,E4 0,E5 0,E6 0}"]))
            q = (*self.xy(), self.safe)
            self.put(f"PTP {self.agg(q)}")
            self.cur = q
            self.put(f"LIN {self.agg((q[0], q[1], z))}")
            self.cur = (q[0], q[1], z)

    # ---- what branches, loops and calls compute
    def block(self, lines):
        for t in lines:
            self.put(t)

    def sub(self, lines):
        if lines[0] not in self.subs:
            self.subs += [""] + lines

    def shift_sub(self):
        self.sub(["DEF shift (p:OUT,d:IN)", "POS p", "REAL d", "p.X=p.X+d", "IF d>0 THEN", "p.Y=p.Y-1.5", "ELSE",
            "p.Y=p.Y+d*2", "ENDIF", "LIN p C_DIS", "END"])

    def flow_out(self, z):
        self.shift_sub()
        n = self.v("POS", "wp")
        self.block([f"{n}={self.agg((*self.xy(), z))}", f"shift({n},{self.f(self.rnd(1, 9))})",
            f"LIN {n}:{{X 1,Y 0,Z 0,A 0,B 0,C 0}}", f"shift ( {n} , -3 )"])
        self.after()

    def flow_through(self, z):
        self.shift_sub()
        self.sub(["DEF outer (q:OUT,k:IN)", "POS q", "INT k,m", "FOR m=1 TO k", "shift(q,m*1.5)", "ENDFOR",
            "q.Z=q.Z+0.5", "END"])
        n = self.v("E6POS" if self.r.random() < .5 else "POS", "tp")
        self.block([f"{n}={self.agg((*self.xy(), z))}", f"outer({n},{self.r.randint(0, 2)})", f"LIN {n}"])
        self.after()

    def flow_grid(self, z):
        i, j, n = self.v("INT", "gi"), self.v("INT", "gj"), self.v("POS", "gq")
        x, y = self.xy()
        self.block([f"{n}={self.agg((x, y, z))}", f"FOR {i}=0 TO {self.r.randint(0, 2)}", f"FOR {j}=1 TO 0 STEP -1",
            f"IF ({i}+{j})/2*2=={i}+{j} THEN",
                    f"{n}.X={self.f(x)}+{i}*{self.rnd(1, 9)}", f"{n}.Y={self.f(y)}-{j}*4", "ELSE",
                        f"{n}.X={self.f(x)}-({i}+1)*3", f"{n}.Y={self.f(y)}+{j}/2-2.5", "ENDIF",
                    f"LIN {n}", "ENDFOR", "ENDFOR"])
        self.after()

    def flow_array(self, z):
        i, n = self.v("INT", "ai"), self.v("INT", "an")
        if "ar" not in self.vars:
            self.vars.add("ar")
            self.decl.append(self.r.choice(["DECL POS ar[4]", "POS ar[4]"]))
        x, y = self.xy()
        self.block([f"FOR {i}=1 TO 4", f"ar[{i}]={self.agg((x, y, z))}",
            f"ar[{i}].X={self.f(x)}+{i}*{self.rnd(2, 7)}", "ENDFOR",
            f"ar[2]=ar[4]:{{X 0,Y {self.rnd(1, 9)},Z 0,A 0,B 0,C 0}}",
                    f"{n}=0", f"WHILE {n}<3", f"{n}={n}+1", f"LIN ar[{n}+1]", "ENDWHILE"])
        self.after()

    def flow_ints(self, z):
        a, b, q, n = self.v("INT", "ia"), self.v("INT", "ib"), self.v("REAL", "rq"), self.v("POS", "ip")
        x, y = self.xy()
        num, den = self.r.choice([-1, 1]) * self.r.randint(3, 30), self.r.choice([-4, 2, 3, 7])
        self.block([f"{a}={num}", f"{b}={den}", f"{q}={a}/{b}", f"{n}={self.agg((x, y, z))}",
            f"{n}.X={q}*2+{self.f(self.rnd(-20, 20))}", f"{n}.Y=({a}+0.0)/{b}", f"LIN {n}",
            f"{a}={q}+{self.r.choice([0.3, 0.7, -0.7])}", f"SWITCH {a}",
            f"CASE {self.r.randint(-2, 3)},{self.r.randint(4, 7)}",
                    "LIN_REL {X 1,Y 1}", "CASE -1,0,1", "LIN_REL {X -1}", "ENDSWITCH"])
        self.after()

    def flow_goto(self, z):
        c = self.v("INT", "gn")
        self.labels = getattr(self, "labels", 0) + 1
        self.block([f"{c}=0", f"again{self.labels}:", f"LIN_REL {{X {self.rnd(1, 5)},Y 1}}", f"{c}={c}+1",
            f"IF {c}<{self.r.randint(1, 3)} THEN", f"GOTO again{self.labels}", "ENDIF"])
        self.after()

    def flow_early(self, z):
        self.sub(["DEF early (n:IN)", "INT n", "BOOL b", "LIN_REL {X 2}", "b=(n>1) AND NOT (n==3)",
            "IF b OR (n<0) THEN", "RETURN", "ENDIF", "LIN_REL {Y 2.5} C_DIS", "END"])
        self.block([f"early({self.r.randint(-1, 4)})", f"early({self.r.randint(0, 2)}+1)"])
        self.after()

    def flow_data(self, z):
        n, c = self.v("POS", "dp"), self.v("INT", "dn")
        if "NPASS" not in " ".join(self.dat):
            self.dat += [f"DECL INT NPASS={self.r.randint(1, 3)}", f"REAL DSTEP={self.f(self.rnd(1, 4))}",
                f"DECL FRAME DOFF={{X 1.5,Y {self.rnd(-9, 9)},Z 0,A {self.r.choice([0, 30])},B 0,C 0}}"]
        x, y = self.xy()
        self.block([f"{n}={self.agg((x, y, z))}", f"FOR {c}=1 TO NPASS", f"{n}.X={n}.X+DSTEP*{c}",
            f"LIN {n}:DOFF" + self.r.choice(["", " C_DIS"]), "ENDFOR"])
        self.after()

    def flow_speed(self, z):
        c = self.v("INT", "sn")
        self.block([f"FOR {c}=1 TO 2", f"$VEL.CP=0.01*{c}", f"LIN_REL {{Y {self.rnd(1, 5)}}}", f"$OUT[{c}]=TRUE",
            "ENDFOR", "WAIT SEC 0.1"])
        self.after()

    def flow_bases(self, z):
        if not (self.style in ("data", "bas") and self.cfg):
            return self.flow_grid(z)
        c = self.v("INT", "bn")
        self.retract_up()
        q = (self.rnd(-40, 40), self.rnd(-40, 40), self.safe)
        self.block([f"FOR {c}=2 TO 1 STEP -1", f"$BASE=BASE_DATA[{c}]" if self.style == "data" else f"BAS(#BASE,{c})",
            f"PTP {self.agg(q)}", f"LIN {self.agg((q[0], q[1], z))}",
                    f"LIN {self.agg(q)}", "ENDFOR"])
        self.cur = q
        self.lin((q[0], q[1], z))

    def flow_stay(self, z):
        self.block(["IF $IN[7]==TRUE THEN", "$OUT[7]=FALSE", "ENDIF", "LOOP", "IF $IN[8] THEN", "EXIT", "ENDIF",
            "WAIT SEC 0.05", "ENDLOOP"][:self.r.choice([3, 3, 0])]
                   + [f"LIN {self.agg((*self.xy(), z))}"])
        self.after()

    def retract_up(self):
        p = (self.cur[0], self.cur[1], self.safe)
        self.put(f"LIN {self.agg(p)}")
        self.cur = p

    def after(self):
        p = (*self.xy(), self.cutz())
        self.put(f"LIN {self.agg(p)}{self.apo()}")
        self.cur = p

    def make(self):
        r = self.r
        name = r.choice(["part", "MILL_01", "contour_a", "Job"]) + str(r.randint(1, 99))
        self.cfg = self.style in ("data", "bas", "inline") and r.random() < .7
        body_head = []
        if self.style == "data":
            body_head = ["$BASE=BASE_DATA[1]", "$TOOL=TOOL_DATA[1]"]
        elif self.style == "bas":
            body_head = ["BAS (#INITMOV,0 )", "BAS (#TOOL,1)", "BAS (#BASE,1)", "BAS (#VEL_CP,0.04)"]
        elif self.style == "literal":
            body_head = ["$BASE={X 10,Y 20,Z 30,A 0,B 0,C 0}" if r.random() < .5 else "$BASE = {FRAME: X 1200,Y 0.5,Z 400,A 30,B 0,C 0}", "$TOOL={X 0,Y 0,Z 200,A 0,B 0,C 0}"]
        elif self.style == "nullbase":
            body_head = ["$BASE=$NULLFRAME", "$TOOL=TOOL_DATA[3]"]
        elif self.style == "datlocal":
            self.dat += ["DECL FRAME WORK={X 100.0,Y 50.0,Z 20.0,A 45.0,B 0.0,C 0.0}", "DECL FRAME CUTTER={X 0.0,Y 0.0,Z 150.0,A 0.0,B 0.0,C 0.0}"]
            body_head = ["$BASE=WORK", "$TOOL=CUTTER"]
        elif self.style == "inline":
            body_head = [";FOLD INI", "BAS (#INITMOV,0 )", ";ENDFOLD (INI)"]
        if self.style != "inline" or r.random() < .5:
            body_head.append(f"$VEL.CP={r.choice(['0.02', '0.03', '0.1'])}")
        if r.random() < .4:
            body_head.append("$APO.CDIS=1.5")
        start = (*self.xy(), self.safe)
        joint = r.random() < .2
        if joint:
            body_head.append("PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}" if r.random() < .5 else "PTP XHOME")
        if self.style == "inline":
            self.inline("PTP", start)
        else:
            self.put(f"PTP {self.agg(start)}")
        self.cur = start
        self.lin((start[0], start[1], self.cutz()))
        target = r.randint(14, 40)
        while len(self.out) < target:
            self.op()
        self.retract_up()
        if r.random() < .3:
            self.put("PTP XHOME")
        uses_home = any("XHOME" in x for x in self.out + body_head)
        if uses_home:
            self.dat.append("DECL E6AXIS XHOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}")
        head = r.choice([[], ["&ACCESS RVP", "&REL 1"], ["&ACCESS RVP", "&REL 3", "&PARAM EDITMASK = *", "&PARAM TEMPLATE = C:\\KRC\\Roboter\\Template\\vorgabe"]])
        deft = r.choice([f"DEF {name}( )", f"DEF {name} ( )", f"DEF {name}()"])
        lines = head + [deft] + self.decl + [self.ind + x for x in body_head] + self.out + ["END"] + self.subs
        if self.low:
            lines = [x if x.startswith(("&", ";")) else x.lower() for x in lines]
        nl = r.choice(["\r\n", "\n"])
        main = name + ".src"
        files = {main: (nl.join(lines) + nl).encode()}
        if self.dat:
            files[name + ".dat"] = (nl.join([f"DEFDAT {name}", ";FOLD EXTERNAL DECLARATIONS", "EXT  BAS (BAS_COMMAND  :IN,REAL  :IN )", ";ENDFOLD"] + self.dat + ["ENDDAT"]) + nl).encode()
        for fn, t in self.extra.items():
            files[fn] = t.encode()
        if self.cfg:
            tr_ = r.choice(["A 0.0,B 0.0,C 0.0", "A 0.0,B 0.0,C 0.0", "A 0.0,B -90.0,C 0.0", "A 30.0,B 0.0,C 0.0"])
            files["$config.dat"] = nl.join([
                "DEFDAT  $CONFIG PUBLIC", "DECL FRAME BASE_DATA[32]" if False else ";frames",
                "BASE_DATA[1]={X 900.0,Y -120.0,Z 410.0,A 15.0,B 0.0,C 0.0}", "BASE_DATA[2]={X 930.0,Y -100.0,Z 415.0,A 60.0,B 3.0,C 0.0}",
                "TOOL_DATA[1]={X 0.0,Y 10.0,Z 250.0," + tr_ + "}", "ENDDAT", ""]).encode()
        options = {"tip": (0, 10, 250) if self.cfg else {"literal": (0, 0, 200), "datlocal": (0, 0, 150)}.get(self.style, (0, 0, 300))}
        if not self.cfg and self.style not in ("literal", "datlocal"):
            options["toml"] = "[robot_program]\ntool_rotation_deg = [0.0, 0.0, 0.0]\n"
        return files, main, options


# ---- self-test
HAND = [
    ("lin", {"h.src": b"DEF h()\r\n$BASE=$NULLFRAME\r\n$VEL.CP=0.02\r\nPTP {X 0,Y 0,Z 50,A 0,B 0,C 180}\r\nLIN {Z 0}\r\nLIN_REL {X 5,Y -2}\r\nLIN_REL {Z -3} #TOOL\r\nEND\r\n"},
     [(0, 0, 50), (0, 0, 0), (5, -2, 0), (5, -2, 3)]),
    ("circ", {"h.src": b"DEF h()\nPTP {X 10,Y 0,Z 0,A 0,B 0,C 180}\nCIRC {X 0,Y 10,Z 0},{X -10,Y 0,Z 0},CA 90\nCIRC {X -10,Y 0},{X 0,Y -10}\nCIRC_REL {X 10,Y 10},{X 0,Y 20},CA -180\nEND\n"},
     [(10, 0, 0), (0, 10, 0), (0, -10, 0), (0, 10, 0)]),
    ("base", {"h.src": b"DEF h()\nINT i\nPOS p\n$BASE={X 100,Y 0,Z 0,A 90,B 0,C 0}\nPTP {X 0,Y 0,Z 0,A 0,B 0,C 0}\n$BASE={X 100,Y 10,Z 0,A 0,B 0,C 0}\nLIN {X 0,Y 0,Z 0,A 0,B 0,C 0}\n"
                        b"p=$NULLFRAME\nFOR i=3 TO 1 STEP -2\np.X=i/2\nLIN p\nENDFOR\nLIN p:{X 1,Y 0,Z 0,A 0,B 0,C 0}\nEND\n"},
     [(0, 0, 0), (10, 0, 0), (10, -1, 0), (10, 0, 0), (10, -1, 0)]),
    ("geo", {"h.src": b"DEF h()\nPTP {X 0,Y 0,Z 0,A 90,B 0,C 0}\nsub(2.5)\nLIN {X 1,Y 1,Z 1,A 90,B 0,C 0}:{X 2,Y 0,Z 0,A 0,B 0,C 0}\nEND\nDEF sub(a:IN)\nREAL a\nPOS q\nq={X 0,Y 0,Z 0,A 0,B 0,C 0}\nq.Z=a*2\nLIN q\nEND\n"},
     [(0, 0, 0), (0, 0, 5), (1, 3, 1)]),
    ("flow", {"h.src": b"DEF h()\nINT i,k\nPOS q\nPTP {X 0,Y 0,Z 0,A 0,B 0,C 0}\nq=$NULLFRAME\nFOR i=1 TO 2\nk=i+0.7\n"
                       b"move(q,k)\nENDFOR\nIF (k==3) AND NOT (q.X<4) THEN\nLIN q\nENDIF\nEND\n"
                       b"DEF move(p:OUT,n:IN)\nPOS p\nINT n\np.X=p.X+n\nIF n>2 THEN\nRETURN\nENDIF\nLIN p\nEND\n"},
     [(0, 0, 0), (2, 0, 0), (5, 0, 0)]),
    ("dat", {"h.src": b"DEF h()\nBAS(#TOOL,1)\nBAS(#BASE,2)\nptp xp1\nlin xp2 c_dis\nsub2()\nEND\n", "h.dat": b"DEFDAT h\nDECL E6POS XP1={X 1,Y 2,Z 3,A 0,B 0,C 0,S 0,T 0,E1 0,E2 0,E3 0,E4 0,E5 0,E6 0}\nDECL POS XP2={X 4,Y 5,Z 6,A 0,B 0,C 0}\nENDDAT\n",
             "sub2.src": b"DEF sub2()\nLOOP\nLIN_REL {X 1}\nIF $POS_ACT.X>5.5 THEN\nEXIT\nENDIF\nENDLOOP\nEND\n"},
     [(1, 2, 3), (4, 5, 6), (5, 5, 6), (6, 5, 6)]),
]


if __name__ == "__main__":
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    selftest("krl", [(name, files, "h.src", want) for name, files, want in HAND], run, generate, n, near=1e-9)
