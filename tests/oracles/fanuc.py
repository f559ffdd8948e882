#!/usr/bin/env python3
"""An interpreter of Fanuc and Haas milling programs with custom macro B, written from the controls' manuals.

Looked up (stored pages of cncmanuals.com, easymanua.ls, manualshive.com; manual and page as shown there):
  16MC   FANUC 16/18/160/180-C for machining centre, operator's manual, p. 147 (page 9.2): G15/G16: G90 from the zero of the work (or G52)
         system, G91 from where the tool is; an angle alone may be incremental
  15MA   FANUC 15i/150i-MA B-63324EN/03 p. 470: G68: centre left out = where the tool is; increments after G68 turn about the tool; R absolute
         by default; no change of plane within; p. 293 (shown 315): Q and I J K modal, M and repeats
  16LA   FANUC 16i/160i-LA B-63194EN/02 p. 219: G68/G69 as above, G69 may stand with other words
  16PB   FANUC 16i-PB B-63684EN/01 p. 278: G65 arguments I and II mixed (the later counts), local levels, not of M98
  16TC   FANUC 16/18-C lathe p. 287: brackets; p. 47 (shown 67): R before I J K; nothing is moved if the end is the start and R is used
  0i     FANUC B-64124EN/01 p. 136: M98 P: the digits above four are the number of calls; M99 need not be alone
  H8000  HAAS mill operator's manual 96-8000: p. 176 G68; p. 217 M97 (L, the same locals), M98 L; p. 118 assignments, WHILE, M99 P
  M700V  Mitsubishi M700V (same language) p. 314 vacant variables; p. 86 polar; p. 519 G10 L20 = G54.1
  zanotowane.pl/117/8692 (Fanuc G81): Z from R and R from the initial level in G91; G98/G99; K
  zappettiniconsulting.com macro-arithmetic: functions, * / AND, + - OR XOR   (16TC p. 286 puts AND with * and OR, XOR with +)
Not looked up (as known):
  a number without a point at a coordinate is mm (calculator type; the other setting is um); values of variables are not rounded to the least
  increment at an address; the initial level is the Z at the start of the series; a block of a series with none of X Y Z R drills nothing;
  R arcs of more than half a turn have R < 0; G17/18/19 and the sense of G2 (from the tip of the third axis: G18 Z to X); whole turn if the end
  is the start and I J K is used; ,R ,C at the end of a line or arc that another follows (C beside an arc refused here); G52 adds in all work
  systems and X0 Y0 Z0 ends it; G10 L2 in G91 adds; GOTO looks on from where it stands, then from the start; Haas M97 uses the first N of the file;
  G28/G30/G53 leave the named axes unknown here; pecks of G73 and G83 lie on the way; G74 G84 G85 G86 G89 back up: 84 85 89 74 with the feed,
  else rapidly; G76 as G86; G87, G88, G66, G92, G50/51, G41/42 refused.
"""
import math, os, random, re, sys
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from move import Move, Refused
from contour import Seg, Chain, sweep, centre_by_radius

DIALECT = "fanuc"
DIGITS = 8           # of a number: the range of values is 99999.999 mm, or 9999.9999 by the finer increment (as known)
LIMIT = 200000
ARG = dict(A=1, B=2, C=3, I=4, J=5, K=6, D=7, E=8, F=9, H=11, M=13, Q=17, R=18, S=19, T=20, U=21, V=22, W=23, X=24, Y=25, Z=26)
E3 = ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))
PLANES = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}
QUIET = {4, 5.1, 9, 15, 21, 40, 43, 44, 49, 61, 64, 69, 80, 50, 50.1, 17, 8, 187, 103}


class Null:
    def __repr__(self): return "null"
NULL = Null()


class Prog:
    def __init__(self, file, number, first):
        self.file, self.number, self.first, self.lines = file, number, first, []      # (line number, text)


def programs(files, main):
    """All programs: by number; the first of the main file is run."""
    found, first = {}, None
    for name in [main] + [f for f in files if f != main]:
        cur = None
        for n, raw in enumerate(files[name].decode("latin-1").splitlines(), 1):
            s = raw.strip()
            if s == "%": continue
            m = re.match(r"(?i)[O:]\s*(\d+)", s)
            if m:
                cur = Prog(name, int(m.group(1)), n); found.setdefault(cur.number, cur)
                s = s[m.end():]
            elif cur is None and not strip(s): continue          # comments before the O word
            elif cur is None:
                d = re.match(r"(?i)O?(\d+)", os.path.basename(name))
                cur = Prog(name, int(d.group(1)) if d else -1, n); found.setdefault(cur.number, cur)
            if first is None and name == main: first = cur
            cur.lines.append((n, s))
    return first, found


def strip(s):
    s = re.sub(r"\([^)]*\)", "", s)
    return re.sub(r"\s+", "", s.split(";")[0]).upper()


class Machine:
    def __init__(self, files, main, opt):
        self.files, self.opt = files, opt
        g = opt.get("gcode", {})
        self.haas = g.get("dialect", "fanuc") == "haas"
        self.main, self.progs = programs(files, main)
        self.common, self.levels = {}, [{}]
        self.unit = 25.4 if g.get("unit") == "inch" else 1.0
        self.pos = [None]*3                     # in machine coordinates, as far as known
        self.plane, self.abs, self.mode, self.feed, self.feedmode = 17, True, 0, None, 94
        self.sys, self.local, self.rot, self.polar = "G54", [0.0]*3, None, False
        self.polar_last = [None, None]
        self.cycle, self.g99, self.initial = None, False, None
        self.off, self.zero, self.measured = {}, None, False
        given = {k: v for k, v in g.items() if re.match(r"g5\d_mm", k)}
        if given or g.get("offsets_mm"):
            self.off["G54"] = [0.0]*3
            for k, v in given.items(): self.off[k[:3].upper()] = list(v)
            for k, v in g.get("offsets_mm", {}).items(): self.off[k] = list(v)
        self.chain, self.steps = Chain(), 0
        self.where = (main, 0)
        self.pending_rot = False

    def no(self, why): raise Refused(self.where[0], self.where[1], why)

    # ---------- variables and expressions
    def var(self, n):
        n = int(round(n))
        if n == 0: return NULL
        if n <= 33: return self.levels[-1].get(n, NULL)
        if 100 <= n <= 199 or 500 <= n <= 999: return self.common.get(n, NULL)
        if n in (5001, 5002, 5003, 5041, 5042, 5043):       # where the last block ended, in the work system
            p = self.prog_pos()
            v = p[(n-1) % 10]
            if v is None: self.no("position read where it is not known")
            return v / self.unit
        self.no("variable #%d of the machine" % n)
    def assign(self, n, v):
        n = int(round(n))
        if 1 <= n <= 33: self.levels[-1][n] = v
        elif 100 <= n <= 199 or 500 <= n <= 999: self.common[n] = v
        else: self.no("assignment to #%d" % n)

    def expr(self, s, i=0):
        """Sum level: + - OR XOR, left to right. -> value, next"""
        a, i = self.term(s, i)
        while i < len(s):
            m = re.match(r"\+|-|OR|XOR", s[i:])
            if not m: break
            b, i = self.term(s, i+m.end())
            a, b = num(a), num(b)
            a = {"+": lambda: a+b, "-": lambda: a-b, "OR": lambda: float(int(a) | int(b)), "XOR": lambda: float(int(a) ^ int(b))}[m.group()]()
        return a, i
    def term(self, s, i):
        a, i = self.factor(s, i)
        while i < len(s):
            m = re.match(r"\*|/|AND|MOD", s[i:])
            if not m: break
            b, i = self.factor(s, i+m.end())
            x, y = num(a), num(b)
            if m.group() in ("/", "MOD") and y == 0: self.no("division by zero")
            a = {"*": lambda: x*y, "/": lambda: x/y, "AND": lambda: float(int(x) & int(y)), "MOD": lambda: math.fmod(x, y)}[m.group()]()
        return a, i
    def factor(self, s, i):
        if i >= len(s): self.no("expression ends early")
        if s[i] in "+-":
            v, j = self.factor(s, i+1)
            return (-num(v) if s[i] == "-" else v), j
        if s[i] == "[":
            v, j = self.expr(s, i+1)
            if s[j:j+1] != "]": self.no("bracket not closed in " + s)
            return v, j+1
        if s[i] == "#":
            m = re.match(r"\d+", s[i+1:])
            if m: return self.var(int(m.group())), i+1+m.end()
            v, j = self.factor(s, i+1)
            return self.var(num(v)), j
        m = re.match(r"\d+\.?\d*|\.\d+", s[i:])
        if m: return float(m.group()), i+m.end()
        m = re.match(r"(SIN|COS|TAN|ASIN|ACOS|ATAN|SQRT|SQR|ABS|ROUND|RND|FIX|FUP|LN|EXP)\[", s[i:])
        if not m: self.no("expression not understood: " + s[i:])
        v, j = self.expr(s, i+m.end())
        if s[j:j+1] != "]": self.no("bracket not closed in " + s)
        j += 1
        f, x = m.group(1), num(v)
        if f == "ATAN":
            if s[j:j+2] == "/[":
                w, k = self.expr(s, j+2)
                return math.degrees(math.atan2(x, num(w))) % 360.0, k+1      # 0 to 360; the other setting is -180 to 180
            return math.degrees(math.atan(x)), j
        try:
            return {"SIN": lambda: math.sin(math.radians(x)), "COS": lambda: math.cos(math.radians(x)), "TAN": lambda: math.tan(math.radians(x)),
                    "ASIN": lambda: math.degrees(math.asin(x)), "ACOS": lambda: math.degrees(math.acos(x)), "SQRT": lambda: math.sqrt(x),
                    "SQR": lambda: math.sqrt(x), "ABS": lambda: abs(x), "ROUND": lambda: half(x), "RND": lambda: half(x), "FIX": lambda: float(math.trunc(x)),
                    "FUP": lambda: float(math.ceil(x) if x > 0 else math.floor(x)), "LN": lambda: math.log(x), "EXP": lambda: math.exp(x)}[f](), j
        except ValueError: self.no("%s of %g" % (f, x))

    def cond(self, s):
        """The condition of the brackets that s begins with. -> bool, next. Conditions may be joined as [[..]AND[..]]."""
        if s[0] != "[": self.no("condition expected: " + s)
        d, i = 0, 0
        while True:
            d += {"[": 1, "]": -1}.get(s[i], 0); i += 1
            if d == 0: break
            if i >= len(s): self.no("bracket not closed")
        body = s[1:i-1]
        if body.startswith("[") and re.search(r"\](AND|OR|XOR)\[", body) and re.search(r"EQ|NE|GT|LT|GE|LE", body):
            try: a, j = self.cond(body)
            except Refused: a = None
            m = re.match(r"AND|OR|XOR", body[j:]) if a is not None else None
            if m:
                b, k = self.cond(body[j+m.end():])
                return {"AND": a and b, "OR": a or b, "XOR": a != b}[m.group()], i
        a, j = self.expr(body)
        m = re.match(r"EQ|NE|GT|LT|GE|LE", body[j:])
        if not m: self.no("comparison expected: " + body)
        b, _ = self.expr(body, j+2)
        op = m.group()
        if op in ("EQ", "NE"):                          # vacant and 0 differ for these two only (M700V p. 314)
            same = (a is NULL) == (b is NULL) and (a is NULL or a == b)
            return same == (op == "EQ"), i
        x, y = num(a), num(b)
        return {"GT": x > y, "LT": x < y, "GE": x >= y, "LE": x <= y}[op], i

    # ---------- frames
    def offset(self):
        if self.sys not in self.off:
            if self.zero is None: return None
            if self.sys == self.zero: return [0.0]*3
            self.no("zero of %s not known" % self.sys)
        if self.zero is not None and self.zero not in self.off: self.no("zero of %s not known from %s" % (self.sys, self.zero))
        return self.off[self.sys]
    def base(self):
        o = self.offset()
        if o is None: o = [0.0]*3
        return [o[i]+self.local[i] for i in range(3)]
    def turn2(self, u, v, s=1):
        c, n = math.cos(math.radians(self.rot[2])), s*math.sin(math.radians(self.rot[2]))
        return c*u-n*v, n*u+c*v
    def prog_pos(self):
        """Where the tool is in the coordinates that the program uses now (turned ones, if G68 is on)."""
        b = self.base()
        p = [None if self.pos[i] is None else self.pos[i]-b[i] for i in range(3)]
        if self.rot:
            i, j, _ = PLANES[self.plane]
            if p[i] is not None and p[j] is not None:
                u, v = self.turn2(p[i]-self.rot[0], p[j]-self.rot[1], -1)
                p[i], p[j] = u+self.rot[0], v+self.rot[1]
            else: p[i] = p[j] = None
        return p
    def to_machine(self, p):
        p = list(p)
        if self.rot:
            i, j, _ = PLANES[self.plane]
            u, v = self.turn2(p[i]-self.rot[0], p[j]-self.rot[1])
            p[i], p[j] = u+self.rot[0], v+self.rot[1]
        b = self.base()
        return [p[k]+b[k] for k in range(3)]
    def in_w(self, p):
        if self.zero is None: self.zero = self.sys
        z = self.off.get(self.zero, [0.0]*3)
        if "w" not in self.__dict__: self.w = list(z)       # the first frame stays where it was when it was used first
        return tuple(p[k]-self.w[k] for k in range(3))

    # ---------- moves
    def target(self, w):
        """End of the block in machine coordinates; None for what is not known."""
        i, j, k = PLANES[self.plane]
        L = "XYZ"
        if self.polar and (L[i] in w or L[j] in w):
            r, a = self.polar_last
            if r is None:
                p = self.prog_pos()
                r, a = math.hypot(p[i], p[j]), math.degrees(math.atan2(p[j], p[i]))
            if not self.abs:
                if L[i] in w: self.no("G91 with a radius in G16")
                a += w[L[j]]
            else:
                r = w[L[i]]*self.unit if L[i] in w else r
                a = w[L[j]] if L[j] in w else a
            self.polar_last = [r, a]
            p = self.prog_pos()
            p[i], p[j] = r*math.cos(math.radians(a)), r*math.sin(math.radians(a))
            if L[k] in w: p[k] = w[L[k]]*self.unit + (0 if self.abs else p[k])
            return self.to_machine(p) if None not in p else self.partial(p)
        if not self.abs:
            d = [w.get(c, 0.0)*self.unit for c in L]
            if self.rot: d[i], d[j] = self.turn2(d[i], d[j])
            out = list(self.pos)
            for n in range(3):
                if d[n] or L[n] in w:
                    if out[n] is None: self.no("increment from an unknown place")
                    out[n] += d[n]
            return out
        p = self.prog_pos()
        if self.rot:
            if self.pending_rot and (L[i] in w) != (L[j] in w): self.no("one axis of the plane alone right after G68")
            if L[i] in w and L[j] in w: self.pending_rot = False
        for n in range(3):
            if L[n] in w: p[n] = w[L[n]]*self.unit
        return self.to_machine(p) if None not in p else self.partial(p)
    def partial(self, p):
        if self.rot: self.no("G68 where the tool is not known")
        b = self.base()
        return [None if p[k] is None else p[k]+b[k] for k in range(3)]

    def put(self, kind, end, corner=None, c=None, ang=0.0, loose=False):
        a = None if None in self.pos else self.in_w(self.pos)
        self.pos = list(end)
        if None in end: return
        e = self.in_w(end)
        i, j, k = PLANES[self.plane]
        s = Seg(kind, a or e, e, (E3[i], E3[j], E3[k]), self.where[0], self.where[1], self.feed,
                self.in_w(c) if c else None, E3[k] if c else None, ang)
        s.corner = corner
        n = len(self.chain.moves)
        self.chain.put(s)
        if loose:
            for m in self.chain.moves[n:]: m.loose = True

    def line(self, w, corner):
        if self.mode == 0 and corner: self.no("corner at a rapid move")
        e = self.target(w)
        if e == self.pos: return
        self.put("rapid" if self.mode == 0 else "line", e, corner)

    def arc(self, w, corner):
        i, j, k = PLANES[self.plane]
        if None in self.pos: self.no("arc from an unknown place")
        e = self.target(w)
        sense = 1 if self.mode == 3 else -1
        a2, b2 = (self.pos[i], self.pos[j]), (e[i], e[j])
        if "R" in w:
            if math.hypot(a2[0]-b2[0], a2[1]-b2[1]) < 1e-9:
                if e[k] != self.pos[k]: self.no("R arc that goes nowhere but along its axis")
                return
            c2 = centre_by_radius(a2, b2, w["R"]*self.unit, sense)
            if c2 is None: self.no("radius too small")
        else:
            I = "IJK"
            if I[k] in w and w[I[k]]: self.no("centre outside the plane")
            if I[i] not in w and I[j] not in w: self.no("arc without a centre")
            d = [w.get(I[i], 0.0)*self.unit, w.get(I[j], 0.0)*self.unit]
            if self.rot: d = self.turn2(*d)
            c2 = (a2[0]+d[0], a2[1]+d[1])
        ra, rb = math.hypot(a2[0]-c2[0], a2[1]-c2[1]), math.hypot(b2[0]-c2[0], b2[1]-c2[1])
        if abs(ra-rb) > 0.02: self.no("radii of the arc differ by %.4f mm" % abs(ra-rb))
        c = list(self.pos); c[i], c[j] = c2
        self.put("arc", e, corner, c, sweep(a2, b2, c2, sense))

    def drill(self, w, g):
        L = "XYZ"
        i, j, k = PLANES[self.plane]
        c = self.cycle
        fresh = c is None or g is not None
        if c is None:
            if self.pos[k] is None: self.no("cycle from an unknown height")
            c = self.cycle = {"initial": self.pos[k]}
        if g is not None: c["g"] = g
        for q in ("R", L[k]):
            if q in w: c[q] = (w[q], self.abs)
        times = int(w.get("L" if self.haas or "L" in w else "K", 1))
        if not fresh and not any(q in w for q in "XYZR"): return
        if fresh and not any(q in w for q in "XYZR"): return
        if "R" not in c or L[k] not in c: self.no("cycle without R or depth")
        if self.rot and self.plane != 17: self.no("cycle turned in another plane")
        zero = self.base()[k]
        r = c["R"][0]*self.unit + (zero if c["R"][1] else c["initial"])
        z = c[L[k]][0]*self.unit + (zero if c[L[k]][1] else r)
        for _ in range(times):
            e = self.target({q: v for q, v in w.items() if q in (L[i], L[j])})
            if None in e: self.no("hole at an unknown place")
            e[k] = self.pos[k]
            if e != self.pos: self.put("rapid", list(e), loose=True)
            e[k] = r
            if e != self.pos: self.put("rapid", list(e), loose=True)
            e[k] = z
            self.put("line", list(e))
            e[k] = r
            up = c["g"] in (74, 84, 85, 89)
            if up: self.put("line", list(e), loose=True)      # out of the finished hole
            if not self.g99: e[k] = c["initial"]
            if e != self.pos: self.put("rapid", list(e), loose=True)

    # ---------- blocks
    def words(self, s):
        out, i = [], 0
        while i < len(s):
            if s[i] == ",":
                key, i = "," + s[i+1:i+2], i+2
            else: key, i = s[i], i+1
            if not key[-1].isalpha(): self.no("not a word: " + s)
            m = re.match(r"[-+]?(\d+\.?\d*|\.\d+)", s[i:])
            if m: v, i = float(m.group()), i+m.end()
            elif s[i:i+1] in "#[" or s[i:i+2] in ("-#", "-[", "+#", "+["): v, i = self.factor(s, i)
            else: self.no("word without a number: " + key + s[i:])
            out.append((key, v))
        return out

    def block(self, s, call):
        w, gs, ms, ijk = {}, [], [], []
        for k, v in self.words(s):
            if v is NULL: continue                     # M700V p. 314: a vacant variable takes its address with it
            if k == "G": gs.append(round(v, 1) if v != int(v) else int(v))
            elif k == "M": ms.append(int(round(v)))
            elif k != "N": w[k] = v
            if k in ("I", "J", "K"): ijk.append((k, v))
        if 65 in gs: return call("G65", w, ijk, s)
        ax = {k: v for k, v in w.items() if k in "XYZ" or k in ("I", "J", "K", "R")}
        for k in w:
            if k in ("A", "B", "C", "U", "V", "W") and w[k]: self.no("axis " + k)
        corner = None
        if ",R" in w: corner = ("round", abs(w[",R"])*self.unit)
        if ",C" in w:
            if corner: self.no(",R and ,C in one block")
            corner = ("leg", abs(w[",C"])*self.unit)
        special = None
        for g in gs:
            if g in (0, 1, 2, 3): self.mode, self.cycle = g, None
            elif g in PLANES:
                if self.rot and g != self.plane: self.no("plane changed within G68")
                self.plane = g
            elif g == 20: self.unit = 25.4
            elif g == 21: self.unit = 1.0
            elif g in (90, 91): self.abs = g == 90
            elif g in (93, 94, 95): self.feedmode = g
            elif g in (98, 99): self.g99 = g == 99
            elif g in (54, 55, 56, 57, 58, 59, 54.1, 154):
                if self.rot: self.no("work system changed within G68")
                if g in (54.1, 154) or (g == 54 and "P" in w): self.sys = "G54.1 P%d" % int(w["P"])
                else: self.sys = "G%d" % g
            elif g in (52, 10, 68, 69, 28, 30, 53, 16, 15, 92): special = g if special is None or g in (52, 10, 28, 30, 53, 68) else special
            elif g == 80: self.cycle = None
            elif g in (73, 74, 76, 81, 82, 83, 84, 85, 86, 89): pass
            elif g in QUIET: pass
            else: self.no("G%g" % g)
        if "F" in w: self.feed = w["F"]*self.unit if self.feedmode == 94 else None
        corner = corner and corner + (self.where[1], self.feed)
        if 15 in gs: self.polar = False
        if 69 in gs:
            self.rot = None
        if special == 10:
            if w.get("L") not in (2, 20): return
            if w.get("L") == 2 and not 1 <= w.get("P", 0) <= 6: self.no("G10 L2 P%g" % w.get("P", -1))
            if self.opt.get("gcode", {}).get("g55_mm") and self.abs: self.no("G10 L2 beside zeros of the process")
            key = "G%d" % (53+int(w["P"])) if w["L"] == 2 else "G54.1 P%d" % int(w["P"])
            if not self.abs and key not in self.off:
                if key == self.zero: self.off[key] = [0.0]*3
                elif self.zero is None and key == self.sys and all(x is None for x in self.pos): self.off[key] = [0.0]*3
                else: self.no("G10 in G91 of a zero that is not known")
            if key == self.zero and key not in self.off: self.no("G10 of the zero in use, whose place is not known")
            if self.abs and key not in self.off and not all(c in w for c in "XYZ"): self.no("G10 of a new zero without all axes")
            o = self.off.get(key, [0.0]*3)
            self.off[key] = [w[c]*self.unit + (0 if self.abs else o[n]) if c in w else o[n] for n, c in enumerate("XYZ")]
            return
        if special == 52:
            if self.rot: self.no("G52 within G68")
            self.local = [w[c]*self.unit if c in w else self.local[n] for n, c in enumerate("XYZ")]
            return self.misc(ms, w, call)
        if special in (28, 30, 53):
            for n, c in enumerate("XYZ"):
                if c in w: self.pos[n] = None
            self.chain.flush()
            return self.misc(ms, w, call)
        if special == 92: self.no("G92")
        if special == 68:
            if any(k in w for k in "IJK"): self.no("G68 in space")
            if "R" not in w: self.no("G68 without an angle")
            i, j, _ = PLANES[self.plane]
            self.rot = None
            p = self.prog_pos()
            c = [w[q]*self.unit if q in w else p[n] for q, n in (("XYZ"[i], i), ("XYZ"[j], j))]
            if None in c: self.no("G68 about an unknown place")
            self.rot, self.pending_rot = (c[0], c[1], w["R"]), True
            return
        if 16 in gs: self.polar, self.polar_last = True, [None, None]
        cyc = next((g for g in gs if g in (73, 74, 76, 81, 82, 83, 84, 85, 86, 89)), None)
        before, after = [m for m in ms if m not in (0, 1, 2, 30, 5, 9, 98, 97, 99)], ms
        if cyc is not None or self.cycle is not None:
            if cyc is not None or any(k in w for k in "XYZR"): self.drill(w, cyc)
        elif any(k in w for k in "XYZ") or (self.mode in (2, 3) and any(k in w for k in "IJK")):
            if 4 in gs: pass
            elif self.mode in (2, 3): self.arc(ax, corner)
            else: self.line(ax, corner)
        elif corner: self.no("corner without a move")
        return self.misc(ms, w, call)

    def misc(self, ms, w, call):
        for m in ms:
            if m in (2, 30): return "end"
            if m in (97, 98, 99): return call("M%d" % m, w, None, None)
            if m == 96: self.no("M96")

    def play(self, prog, start=0, depth=0, sub=False):
        """Runs a program; returns "end" or the N to go on at in the caller, or None."""
        if depth > 9: self.no("calls too deep")
        lines = [(n, strip(t), t) for n, t in prog.lines]
        lab = {}
        for i, (n, s, _) in enumerate(lines):
            m = re.match(r"/?\d?N(\d+)", s)
            if m: lab.setdefault(int(m.group(1)), []).append(i)
        def find(n, i):
            if n not in lab: self.no("N%d not found" % n)
            return next((k for k in lab[n] if k > i), lab[n][0])
        def loops(i, what):                     # from a WHILE/DO m to its END m
            for k in range(i+1, len(lines)):
                if re.match(r"/?(N\d+)?END%d$" % what, lines[k][1]): return k
            self.no("END%d not found" % what)
        i = start
        active = {}
        while i < len(lines):
            self.steps += 1
            if self.steps > LIMIT: self.no("does not end")
            n, s, raw = lines[i]
            self.where = (prog.file, n)
            if s.startswith("/"): s = re.sub(r"^/\d?(?=[A-Z#])", "", s)
            s = re.sub(r"^N\d+", "", s)
            i += 1
            if not s: continue
            if s.startswith("#"):
                m = re.match(r"#(\d+)=", s)
                if m: k, j = float(m.group(1)), m.end()
                else:
                    k, j = self.factor(s, 1)
                    if s[j:j+1] != "=": self.no("not understood: " + s)
                    j += 1
                v, e = self.expr(s, j)
                if e != len(s): self.no("not understood: " + s[e:])
                self.assign(num(k), v); continue
            if s.startswith("IF"):
                ok, j = self.cond(s[2:])
                rest = s[2+j:]
                if rest.startswith("GOTO"):
                    if ok: i = find(int(num(self.expr(rest, 4)[0])), i-1)
                elif rest.startswith("THEN"):
                    if ok:
                        m = re.match(r"#(\d+)=", rest[4:])
                        if not m: self.no("THEN without an assignment")
                        self.assign(float(m.group(1)), self.expr(rest, 4+m.end())[0])
                else: self.no("IF without GOTO or THEN")
                continue
            if s.startswith("GOTO"):
                i = find(int(num(self.expr(s, 4)[0])), i-1); continue
            m = re.match(r"(WHILE(\[.*\]))?DO(\d)$", s)
            if m:
                k = int(m.group(3))
                end = loops(i-1, k)
                if m.group(1) and not self.cond(m.group(2))[0]: i = end+1; continue
                active[end] = i-1; continue
            m = re.match(r"END(\d)$", s)
            if m:
                if i-1 not in active: self.no("END without WHILE")
                i = active[i-1]; continue
            jump = []
            def call(what, w, ijk, text):
                if what == "M99":
                    if sub: jump.append(("back", int(w["P"]) if "P" in w else None)); return
                    if "P" in w: jump.append(("goto", int(w["P"]))); return
                    self.no("M99 of the main program repeats for ever")
                if "P" not in w: self.no(what + " without P")
                P, times = int(w["P"]), int(w.get("L", 1))
                if what == "M97":
                    if not self.haas: self.no("M97 is of Haas")
                    at = find(P, -1)
                    for _ in range(times):
                        r = self.play(prog, at, depth+1, True)
                        if r == "end": return "end"
                    return
                if what == "M98" and not self.haas and P > 9999:
                    if "L" in w: self.no("M98 with L and more than four digits")
                    times, P = P // 10000, P % 10000
                if P not in self.progs:
                    self.no("program O%d is missing" % P)
                if what == "G65":
                    a, num_i = {}, {"I": 0, "J": 0, "K": 0}
                    twice = len(ijk) != len({k for k, _ in ijk})
                    if twice:
                        grp, last = 0, -1
                        for k, v in ijk:                  # arguments II: I J K by groups in order
                            o = "IJK".index(k)
                            if o <= last: grp += 1
                            last = o; a[4+3*grp+o] = v
                    for k, v in w.items():
                        if k in ARG and not (twice and k in "IJK"): a[ARG[k]] = v
                    self.levels.append(a)
                for _ in range(times):
                    if what == "G65": self.levels[-1] = dict(a)
                    r = self.play(self.progs[P], 0, depth+1, True)
                    if r == "end": return "end"
                    if isinstance(r, int): jump.append(("goto", r)); break
                if what == "G65": self.levels.pop()
                self.where = (prog.file, n)
            if self.block(s, call) == "end": return "end"
            if jump:
                k, v = jump[0]
                if k == "back": return v
                i = find(v, i-1)
        if sub: self.no("subprogram without M99")
        return "end"


def num(v): return 0.0 if v is NULL else v
def half(x): return float(math.floor(abs(x)+0.5) * (1 if x >= 0 else -1))


def run(files, main, options):
    m = Machine(files, main, options)
    m.play(m.main)
    m.chain.flush()
    return m.chain.moves


# ---------- programs
class Gen:
    def __init__(self, seed):
        q = self.q = random.Random(seed)
        self.haas = q.random() < 0.4
        self.inch = q.random() < 0.2
        self.dec = 4 if self.inch else 3
        self.sp = q.choice(["", " ", " ", "  "]) if q.random() < 0.9 else " "
        self.low = q.random() < 0.12
        self.zero2 = q.choice([True, False])                 # G0 or G00
        self.style = q.choice(["min", "min", "full", "int"])
        self.lines, self.subs, self.beside = [], [], {}
        self.num = q.choice([0, 0, 5, 10, 1])
        self.n = 0
        self.label = 1000
        self.sub_no = q.choice([1000, 8000, 100, 9000]) + q.randint(0, 50)
        self.mains = q.choice([1, 10, 100, 1234])
        self.g = {"dialect": "haas" if self.haas else "fanuc"}
        self.gcode_zeros = False
    def v(self, x):
        """A number of millimetres as the program writes it."""
        x = round(x/25.4 if self.inch else x, self.dec)
        if x == 0: x = 0.0
        if self.style == "full": t = "%.*f" % (self.dec, x)
        else:
            t = ("%.*f" % (self.dec, x)).rstrip("0")
            if self.style == "int" and t.endswith(".") and self.q.random() < 0.5: t = t[:-1]
            elif self.style == "min":
                if t.startswith("0.") and len(t) > 2: t = t[1:]
                elif t.startswith("-0.") and len(t) > 3: t = "-" + t[2:]
                elif t.endswith(".") and self.q.random() < 0.3: t += "0"
        return t
    def G(self, n): return "G0%d" % n if self.zero2 and n < 10 else "G%d" % n
    def xy(self, x=None, y=None, z=None): return [c + self.v(t) for c, t in (("X", x), ("Y", y), ("Z", z)) if t is not None]
    def put(self, *ws, to=None):
        out = (self.sp if self.sp else "").join(x for x in ws if x)
        t = self.lines if to is None else to
        if to is None and self.num and out and out[0] not in "(N/%O":
            self.n += self.num; out = "N%d" % self.n + (self.sp or " ") + out
        if self.q.random() < 0.04: out += " (" + self.q.choice(["ROUGH", "pass 2", "T3 D10.", "CHECK Z"]) + ")"
        if self.haas and self.q.random() < 0.03 or self.q.random() < 0.01: out += ";"
        t.append(out.lower() if self.low and "(" not in out else out)
    def f(self): return "F%s" % (self.v(self.q.choice([200, 350.5, 500, 800, 1200])) if self.inch else self.q.choice(["200", "350.5", "500.", "800", "1200."]))
    def r(self, a, b): return round(self.q.uniform(a, b), self.q.choice([0, 1, 3]))
    def at(self): return self.r(-90, 90), self.r(-90, 90)
    def down(self, x, y, to=None, z=None):
        """Rapid to x y above the part, then down with the feed."""
        z = self.r(-12, -1) if z is None else z
        self.put(self.G(0), *self.xy(x, y), to=to)
        if self.q.random() < 0.6: self.put(*([self.G(0)] if self.q.random() < .3 else []), *self.xy(z=self.q.choice([2, 3, 5])), to=to)
        self.put(self.G(1), *self.xy(z=z), self.f(), to=to)
        return z
    def up(self, to=None): self.put(self.G(0), *self.xy(z=self.q.choice([25, 30, 50])), to=to)

    # pieces
    def contour(self, to=None, at=None):
        q = self.q
        x, y = at or self.at()
        z = self.down(x, y, to)
        for _ in range(q.randint(2, 6)):
            k = q.choice("lllaarRih")
            if k == "l":
                nx, ny = x+self.r(-30, 30), y+self.r(-30, 30)
                what = q.choice(["x", "y", "xy", "xy", "xyz"])
                x2, y2 = (nx if "x" in what else x), (ny if "y" in what else y)
                zz = None
                if "z" in what: z = self.r(-12, -1); zz = z
                if (x2, y2) == (x, y) and zz is None: continue
                self.put(q.choice([self.G(1), ""]) if self.modal == 1 else self.G(1), *self.xy(x2 if "x" in what else None, y2 if "y" in what else None, zz),
                         self.f() if q.random() < .15 else "", to=to)
                x, y = x2, y2
                self.modal = 1
            elif k in "arR":                      # an arc by its centre, by R, by R < 0
                R = self.q.choice([2, 5, 8, 12.5, 20]); a0 = q.choice([0, 90, 180, 270]) if k == "a" else 0
                sense = q.choice([2, 3])
                if k == "a":
                    cx, cy = x-R*math.cos(math.radians(a0)), y-R*math.sin(math.radians(a0))
                    da = q.choice([90, 180, 270, 360])*(1 if sense == 3 else -1)
                    ex, ey = cx+R*math.cos(math.radians(a0+da)), cy+R*math.sin(math.radians(a0+da))
                    ends = [] if abs(da) == 360 and q.random() < .5 else self.xy(ex, ey)
                    zz = []
                    if q.random() < .2: z = self.r(-12, -1); zz = self.xy(z=z)
                    ij = [c+self.v(t) for c, t in (("I", cx-x), ("J", cy-y)) if abs(t) > 1e-9 or q.random() < .5]
                    self.put(self.G(sense), *ends, *zz, *ij, to=to)
                    x, y = ex, ey
                else:
                    chord = q.uniform(0.4, 1.7)*R; t = q.uniform(0, 2*math.pi)
                    ex, ey = round(x+chord*math.cos(t), 3), round(y+chord*math.sin(t), 3)
                    self.put(self.G(sense), *self.xy(ex, ey), "R" + self.v(R if k == "r" else -R), to=to)
                    x, y = ex, ey
                self.modal = sense
            elif k == "i":                        # some incremental blocks
                self.put("G91", to=to)
                for _ in range(q.randint(1, 3)):
                    dx, dy = self.r(-15, 15), self.r(-15, 15)
                    self.put(self.G(1), *self.xy(dx, dy), to=to); x, y = x+dx, y+dy
                if q.random() < .4:
                    s = q.choice([2, 3]); R = q.choice([3, 6, 10])
                    self.put(self.G(s), *self.xy(2*R, 0), "I" + self.v(R), *(["J0"] if q.random() < .5 else []), to=to); x += 2*R
                self.put("G90", to=to); self.modal = 1
                x, y = self.q.choice([(x, y), (x, y)])
                if self.inch or True:
                    x, y = round(x+5, 1), round(y-5, 1)
                    self.put(self.G(1), *self.xy(x, y), to=to)
            else:                                 # helix of R in and down
                R = q.choice([4, 7.5]); z2 = z-q.choice([0.5, 1, 2.25])
                self.put(self.G(q.choice([2, 3])), *self.xy(x, y, z2), "I"+self.v(R), "J0" if q.random() < .5 else "", to=to); z = z2
                self.modal = 2
                self.put(self.G(1), *self.xy(x+4, y), to=to); x += 4; self.modal = 1
            x, y = max(-140, min(140, x)), max(-140, min(140, y))
            if abs(x) == 140 or abs(y) == 140: self.put(self.G(1), *self.xy(x, y), to=to); self.modal = 1
        self.up(to)
        self.modal = 0

    def corners(self):
        q = self.q
        x, y = self.at(); w, h = q.uniform(20, 60), q.uniform(20, 60)
        w, h = round(w, 1), round(h, 1)
        self.down(x, y)
        pts = [(x+w, y), (x+w, y+h), (x, y+h), (x, y-5)]
        if q.random() < .3: pts = [(x+w, y+3), (x+w-5, y+h), (x-4, y+h+2), (x-4, y-6)]
        for i, p in enumerate(pts):
            c = "" if i == 3 else q.choice(["", ",R"+self.v(q.choice([2, 3.5, 5])), ",C"+self.v(q.choice([1, 2, 3]))])
            self.put(self.G(1) if i == 0 or q.random() < .3 else "", *self.xy(*p), c)
        self.up()

    def planes(self):
        q = self.q
        x, y = self.at(); R = q.choice([4, 8, 10]); s = q.choice([2, 3])
        z = -2
        self.down(x, y, z=z)
        if q.random() < .5:                       # a half circle over or under in the ZX plane
            self.put("G18"); e = x+2*R*q.choice([1, -1])
            self.put(self.G(s), "X"+self.v(e), *(["Z"+self.v(z)] if q.random() < .5 else []),
                     *(["I"+self.v((e-x)/2), "K0."] if q.random() < .6 else ["R"+self.v(R)]))
            self.put("G17"); self.put(self.G(1), *self.xy(e, y+6))
        else:
            self.put("G19"); e = y+2*R*q.choice([1, -1])
            self.put(self.G(s), "Y"+self.v(e), *(["J"+self.v((e-y)/2), "K0"] if q.random() < .6 else ["R"+self.v(R)]))
            self.put("G17"); self.put(self.G(1), *self.xy(x+6, e))
        self.up()

    def cycle(self, to=None, polar=False):
        q = self.q
        c = q.choice([81, 81, 82, 83, 73, 84, 85, 86, 89])
        x, y = self.at()
        self.put(self.G(0), *self.xy(x, y), to=to); self.put(self.G(0), *self.xy(z=25), to=to)
        g9 = q.choice(["G98", "G99"])
        extra = {82: ["P500"], 89: ["P300"], 83: ["Q"+self.v(2)], 73: ["Q"+self.v(1.5)], 84: [], 85: [], 86: []}.get(c, [])
        z, r = self.r(-20, -3), q.choice([1, 2, 3])
        if q.random() < .25:                      # a row of holes by increments
            self.put("G91", to=to)
            dx, dy = q.choice([(12, 0), (0, -9), (7.5, 7.5)])
            self.put("G98", "G%d" % c, *self.xy(dx, dy), "Z"+self.v(-10), "R"+self.v(-22), *extra, ("L" if self.haas else "K")+str(q.randint(2, 4)), self.f(), to=to)
            self.put("G80", to=to); self.put("G90", to=to)
            self.put(self.G(0), *self.xy(0, 0), to=to); self.up(to)
            return
        self.put(*([g9] if q.random() < .8 else []), "G%d" % c, *(self.xy(x, y) if q.random() < .6 else []), "Z"+self.v(z), "R"+self.v(r), *extra, self.f(), to=to)
        if not any(True for _ in [0]): pass
        for _ in range(q.randint(1, 4)):
            nx, ny = self.at()
            what = q.choice(["x", "y", "xy", "xyz"])
            self.put(*self.xy(nx if "x" in what else None, ny if "y" in what else None), *(["Z"+self.v(self.r(-20, -3))] if "z" in what else []), to=to)
        self.put("G80", to=to)
        self.up(to)

    def polar(self):
        q = self.q
        self.up()
        self.put("G16")
        R, a = self.r(20, 80), self.r(0, 80)
        if q.random() < .6:
            self.put("G99" if q.random() < .5 else "G98", "G81", "X"+self.v(R), "Y%g" % a, "Z"+self.v(-8), "R"+self.v(2), self.f())
            n = q.randint(2, 5)
            inc = q.random() < .3
            if inc: self.put("G91", "Y%g" % round(360/n, 3), ("L" if self.haas else "K")+"%d" % (n-1))
            else:
                for i in range(1, n): self.put("Y%g" % round(a+360*i/n, 3))
            self.put("G80")
            if inc: self.put("G90")
        else:
            self.put(self.G(0), "X"+self.v(R), "Y%g" % a); self.put(self.G(1), *self.xy(z=-3), self.f())
            for i in range(q.randint(2, 5)): self.put("X"+self.v(self.r(20, 80)), "Y%g" % round(a+25*i, 1))
            self.up()
        self.put("G15")
        self.put(self.G(0), *self.xy(*self.at()))

    def rotate(self):
        q = self.q
        self.up()
        c = self.at(); ang = q.choice([30, 45, -15.5, 90, 180, 12.345])
        self.put("G68", *self.xy(*c), "R%g" % ang)
        self.modal = 0
        k = q.choice(["contour", "corner", "hole"])
        if k == "contour": self.contour(at=(c[0]+self.r(5, 20), c[1]+self.r(-20, 20)))
        elif k == "hole": self.cycle()
        else: self.corners()
        self.put("G69")
        self.put(self.G(0), *self.xy(*self.at()))

    def frames(self):
        q = self.q
        k = q.choice(["52", "52", "g55", "541"])
        self.up()
        if k == "52":
            self.put("G52", *self.xy(self.r(-50, 50), self.r(-50, 50), q.choice([None, self.r(-5, 5)])))
            self.modal = 0; self.contour(); self.put("G52", "X0", "Y0", "Z0")
        else:
            w = "G55" if k == "g55" else ("G154" if self.haas and q.random() < .5 else "G54.1")+self.sp+"P%d" % q.choice([1, 2])
            self.put(w); self.put(self.G(0), *self.xy(*self.at())); self.modal = 0
            (self.contour if q.random() < .7 else self.cycle)()
            self.put("G54")
        self.put(self.G(0), *self.xy(*self.at())); self.put(self.G(0), *self.xy(z=30))

    def holes_by_loop(self):
        q = self.q
        a, b = q.sample([100, 101, 102, 110, 120, 500, 1, 2, 24], 2)
        n = q.randint(3, 7); R = self.v(self.r(15, 60)); cx, cy = self.at()
        self.put("#%d=0" % a)
        w = q.random()
        x = "X[%s+%s*COS[#%d*360/%d]]" % (self.v(cx), R, a, n)
        y = "Y[%s+%s*SIN[#%d*360/%d]]" % (self.v(cy), R, a, n)
        step = "#%d=#%d+1" % (a, a)
        body = [(self.G(0), x, y), (self.G(0), "Z"+self.v(2)), (self.G(1), "Z"+self.v(-5), self.f()), (self.G(0), "Z"+self.v(25))]
        if w < .4:
            self.put("WHILE[#%d%sLT%s%d]%sDO1" % (a, self.sp, self.sp, n, self.sp))
            for t in body: self.put(*t)
            self.put(step); self.put("END1")
        elif w < .7:
            lab = self.label; self.label += 10
            self.lines.append("N%d" % lab)
            for t in body: self.put(*t)
            self.put(step)
            self.put("IF[#%d%s%d]GOTO%s%d" % (a, q.choice(["LT", " LT ", " NE "]), n, q.choice(["", " "]), lab))
        else:
            lab = self.label; self.label += 20
            self.lines.append("N%d" % lab)
            self.put("IF[#%d GE %d]GOTO%d" % (a, n, lab+10))
            for t in body: self.put(*t)
            self.put("#%d=[#%d+1]" % (a, a)); self.put("GOTO%d" % lab)
            self.lines.append("N%d" % (lab+10))

    def steps_by_loop(self):
        q = self.q
        x, y = self.at(); w = self.r(10, 40); top, dz, n = 0, q.choice([1, 1.5, 2.5]), q.randint(2, 4)
        a = q.choice([100, 103, 510, 3])
        self.put(self.G(0), *self.xy(x, y)); self.put(self.G(0), *self.xy(z=5))
        self.put("#%d=%s" % (a, self.v(-dz)))
        self.put("WHILE [#%d GE %s] DO2" % (a, self.v(-dz*n-.001)) if q.random() < .5 else "WHILE[#%dGT%s]DO2" % (a, self.v(-dz*(n+.5))))
        self.put(self.G(1), "Z#%d" % a, self.f())
        if q.random() < .5:
            self.put("G91"); self.put("X"+self.v(w)); self.put("Y"+self.v(w)); self.put(self.G(q.choice([2, 3])), "X"+self.v(-w), "R"+self.v(w)); self.put(self.G(1), "Y"+self.v(-w)); self.put("G90")
        else:
            self.put("X[%s+%s]" % (self.v(x), self.v(w))); self.put("Y"+self.v(y+w)); self.put(self.G(q.choice([2, 3])), "X"+self.v(x), "Y"+self.v(y), "R"+self.v(w))
        self.put("#%d=#%d-%s" % (a, a, self.v(dz)))
        self.put("END2"); self.up()

    def ellipse(self):
        q = self.q
        cx, cy = self.at(); A, B = self.r(15, 40), self.r(10, 25); st = q.choice([30, 45, 60])
        t = [1, 2, 3] if q.random() < .5 else [101, 102, 103]
        self.put("#%d=%s" % (t[0], self.v(A))); self.put("#%d=%s(MINOR)" % (t[1], self.v(B))); self.put("#%d=0" % t[2])
        self.down(cx+A, cy)
        self.put("WHILE[#%d LE 360]DO1" % t[2])
        self.put(self.G(1), "X[#%d*COS[#%d]+%s]" % (t[0], t[2], self.v(cx)), "Y[#%d*SIN[#%d]+[%s]]" % (t[1], t[2], self.v(cy)))
        self.put("IF[#%d EQ 180]THEN #%d=#%d+0" % (t[2], t[0], t[0])) if q.random() < .3 else None
        self.put("#%d=#%d+%d" % (t[2], t[2], st)); self.put("END1"); self.up()

    def sub(self):
        q = self.q
        no = self.sub_no; self.sub_no += 1
        k = q.choice(["abs", "inc", "inc"])
        body = []
        self.modal = 0
        num, self.num = self.num, 0
        if k == "abs": self.contour(to=body)
        else:
            s = q.choice([6, 10, 15.5])
            self.put("G91", to=body); self.put(self.G(1), "Z"+self.v(-7), self.f(), to=body)
            self.put("X"+self.v(s), to=body); self.put("Y"+self.v(s), to=body)
            if q.random() < .5: self.put(self.G(3), "X"+self.v(-s), "Y"+self.v(-s), "I"+self.v(-s) if False else "R"+self.v(s), to=body)
            else: self.put("X"+self.v(-s), "Y"+self.v(-s), to=body)
            self.put(self.G(0), "Z"+self.v(7), to=body)
            self.put(q.choice(["G90", "X"+self.v(20)]), to=body)
        self.num = num
        inc_end = body[-1].upper().startswith("X") if k == "inc" else False
        body.append("M99" if not self.low else "m99")
        times = q.randint(2, 3) if inc_end or k == "abs" and q.random() < .3 else 1
        self.put(self.G(0), *self.xy(*(self.r(-90, 20), self.r(-90, 90)))); self.put(self.G(0), *self.xy(z=5))
        if self.haas and q.random() < .5:
            lab = self.label; self.label += 10
            self.put("M97", "P%d" % lab, *(["L%d" % times] if times > 1 else []))
            self.tail.append(["N%d" % lab] + body)
        else:
            if self.haas or q.random() < .5: self.put("M98", "P%d" % no, *(["L%d" % times] if times > 1 else []))
            else: self.put("M98", "P%s%04d" % (q.choice(["%d", "%03d", "%04d"]) % times if times > 1 else "", no) if no <= 9999 else "P%d" % no)
            text = [("O%04d" % no) + q.choice(["", " (SUB)", "(POCKET)"])] + body
            if q.random() < .4: self.beside["O%04d%s" % (no, q.choice(["", ".nc", ".NC"]))] = text
            else: self.subs.append(text)
        if inc_end or k == "inc": self.put("G90")
        self.up()
        self.modal = 0

    def macro(self):
        q = self.q
        no = self.sub_no; self.sub_no += 1
        body = []
        num, self.num = self.num, 0
        P = lambda *t: self.put(*t, to=body)
        P(self.G(0), "X#24", "Y#25") ; P(self.G(0), "Z#18")
        if q.random() < .5:
            P("#30=0"); P("WHILE[#30LT#26]DO1"); P("#30=#30+%s" % self.v(2)); P("IF[#30GT#26]THEN#30=#26")
            P(self.G(1), "Z-#30", "F#9"); P("X[#24+#20/2]") ; P(self.G(3), "I[-#20/2]"); P(self.G(1), "X#24"); P("END1")
        else:
            P(self.G(1), "Z-#26", "F#9"); P("IF[#3EQ#0]GOTO10"); P("Y[#25+#3]"); body.append("N10 (NEXT)"); P("X[#24+#20]") ; P("Y[#25+SQRT[#20*#20]/2]"); P("X#24", "Y#25")
        P(self.G(0), "Z#18")
        body.append("M99")
        self.num = num
        pt = lambda x: (lambda t: t if "." in t else t+".")(self.v(x))
        for _ in range(q.randint(1, 2)):
            a = ["X"+pt(self.r(-80, 80)), "Y"+pt(self.r(-80, 80)), "Z"+pt(self.r(2, 7)), "R"+pt(5), "T"+pt(q.choice([10, 16, 24])), "F"+pt(500)]
            if q.random() < .4: a.append("C"+pt(7))
            q.shuffle(a)
            self.put("G65", "P%d" % no, *a)
        self.put("G90"); self.up()
        text = ["O%04d(MACRO)" % no] + body
        if q.random() < .4: self.beside["O%04d" % no] = text
        else: self.subs.append(text)
        self.modal = 0

    def nested(self):
        """Calls in calls, M99 P, two loops, conditions joined, a place read back, blanks and signs as people write them."""
        q = self.q
        k = q.choice(["loops", "goto", "m99p", "calls", "read", "spell", "callmove", "g65ijk", "home"])
        x, y = self.at()
        if k == "loops":
            a, b = q.sample([100, 101, 105, 501, 7, 8, 33], 2)
            self.put("#%d=1" % a)
            self.put("WHILE[#%d LE %d]DO1" % (a, q.randint(2, 3))); self.put("#%d=0" % b)
            self.put("WHILE[[#%d LT 3] AND [#%d GT 0]] DO2" % (b, a) if q.random() < .4 else "WHILE[#%d LT 2]DO2" % b)
            self.put(self.G(0), "X[%s+#%d*%s]" % (self.v(x), b, self.v(11)), "Y[%s-%s*[#%d-1]]" % (self.v(y), self.v(8), a))
            self.put(self.G(0), *self.xy(z=2)); self.put(self.G(1), *self.xy(z=-3), self.f()); self.put(self.G(0), *self.xy(z=5))
            self.put("#%d=#%d+1" % (b, b)); self.put("END2"); self.put("#%d=#%d+1" % (a, a)); self.put("END1")
        elif k == "goto":
            a = q.choice([100, 9]); lab = self.label; self.label += 30
            self.put("#%d=%d" % (a, q.randint(0, 2)))
            self.put("GOTO[%d+10*#%d]" % (lab, a) if self.haas or q.random() < .5 else "IF[#%d NE 0]GOTO%d" % (a, lab+10))
            self.down(x, y)
            self.up()
            for d in (0, 10, 20): self.lines.append("N%d" % (lab+d)); self.put(self.G(0), *self.xy(x+d/2, y)); self.put(self.G(1), *self.xy(z=-2), self.f()); self.put(self.G(0), *self.xy(z=8))
        elif k == "m99p":
            no = self.sub_no; self.sub_no += 1; lab = self.label; self.label += 10
            self.put(self.G(0), *self.xy(x, y)); self.put(self.G(0), *self.xy(z=5))
            self.put("M98", "P%d" % no)
            self.put(self.G(1), *self.xy(x+50, y), self.f())          # skipped
            self.lines.append("N%d" % lab)
            self.subs.append(["O%04d" % no, "G91", self.G(1)+"Z"+self.v(-6)+self.f(), "X"+self.v(9), self.G(0)+"Z"+self.v(6), "G90", "M99P%d" % lab])
        elif k == "calls":
            n1 = self.sub_no; self.sub_no += 2
            self.put(self.G(0), *self.xy(x, y)); self.put(self.G(0), *self.xy(z=3)); self.put("M98", "P%d" % n1, *(["L2"] if q.random() < .5 else []))
            self.subs.append(["O%04d" % n1, "M98 P%d" % (n1+1), "G91 %s X%s" % (self.G(0), self.v(7)), "G90", "M98 P%d" % (n1+1), "M99"])
            self.subs.append(["O%04d" % (n1+1), self.G(1)+" Z%s %s" % (self.v(-2), self.f()), "G91", self.G(3)+" Y%s R%s" % (self.v(8), self.v(4)), "Y%s R%s" % (self.v(-8), self.v(4)), "G90", self.G(0)+" Z%s" % self.v(3), "M99"])
        elif k == "read":
            self.down(x, y)
            self.put("#100=#5001+%s" % self.v(10)) if not self.haas or True else None
            self.put(self.G(1), "X#100", "Y[#5002-%s]" % self.v(5))
        elif k == "spell":
            self.down(x, y)
            self.put(self.G(1), "X+%s" % self.v(abs(x)), "Y %s" % self.v(y))
            self.put("X 0%s" % self.v(abs(x)+3) if not self.v(abs(x)+3).startswith(".") else "X"+self.v(abs(x)+3))
            self.put("Y[%s]" % self.v(y+4), "Z-[%s]" % self.v(2))
            self.put("# 101 = - %s" % self.v(3)); self.put("Z# 101" if self.sp else "Z#101")
            self.put("/" + self.G(1) + " X" + self.v(x))
            self.put("N%d%sY%s" % (self.label+5, self.sp, self.v(y-6))); self.label += 10
        elif k == "callmove":
            no = self.sub_no; self.sub_no += 1
            self.put(self.G(0), *self.xy(z=4)); self.put(self.G(0), *self.xy(x, y), "M98", "P%d" % no)
            self.put(self.G(0), *self.xy(x-20, y+9), "M98", "P%d" % no)
            self.subs.append([":%04d" % no if q.random() < .2 else "O%04d" % no, self.G(1)+"Z"+self.v(-4)+self.f(), self.G(2)+"I"+self.v(q.choice([3, -5]))+"J0", self.G(0)+"Z"+self.v(4)+"M99"])
        elif k == "g65ijk":
            no = self.sub_no; self.sub_no += 1
            p = lambda t: (lambda u: u if "." in u else u+".")(self.v(t))
            self.put(self.G(0), *self.xy(z=4))
            self.put("G65", "P%d" % no, "I"+p(x), "J"+p(y), "K"+p(-4), "I"+p(x+12), "J"+p(y+3), *(["L2"] if q.random() < .2 else []))
            self.subs.append(["O%04d(IJK)" % no, self.G(0)+"X#4Y#5", "G65P%d Z#6X#7Y#8" % (no+1), self.G(0)+"Z"+self.v(4), "IF[#24NE#0]GOTO99", "#33=1.", "N99M99"])
            self.subs.append(["O%04d(INNER)" % (no+1), "#1=ABS[#26]/2", self.G(1)+"Z-#1"+self.f(), "X#24Y#25", "Z#26", "M99"]); self.sub_no += 1
        else:
            self.put("G91", "G28", "Z0"); self.put("G90") if q.random() < .7 else self.put("G90", "G0", *self.xy(x, y))
            self.put(self.G(0), *self.xy(x, y)); self.put(self.G(0), *self.xy(z=40)); self.down(x, y)
        self.up()
        self.modal = 0

    def g10(self):
        """At the start: two zeros in machine coordinates, later one of them moved."""
        q = self.q
        for p in (1, 2): self.put("G90", "G10", "L2", "P%d" % p, *self.xy(-300+self.r(-20, 20), -200+self.r(-20, 20), -400+self.r(-5, 5)))
        self.g10_used = True

    def build(self, seed):
        q = self.q
        self.tail, self.modal, self.g10_used = [], 0, False
        frames_known = q.random() < .5
        if q.random() < .85: self.lines.append("%")
        self.lines.append(("O%04d" % self.mains) + q.choice(["", " (PART %d)" % seed, "(made by hand)"]))
        self.put("G20" if self.inch else "G21", *q.choice([["G90", "G17", "G40", "G49", "G80"], ["G17", "G90"], ["G40", "G80", "G90", "G94"]]))
        if q.random() < .3: self.put("G91", "G28", "Z0"); self.put("G90")
        if q.random() < .5: self.put("T%d" % q.randint(1, 12), "M6" if q.random() < .7 else "M06")
        kinds = [self.contour, self.contour, self.corners, self.planes, self.cycle, self.cycle, self.polar, self.rotate, self.holes_by_loop, self.steps_by_loop,
                 self.ellipse, self.sub, self.sub, self.macro, self.nested, self.nested, self.nested]
        if self.haas: kinds.remove(self.polar)
        if frames_known:
            if q.random() < .4: self.g10()
            else:
                self.g["g54_mm"] = [0.0, 0.0, 0.0]
                self.g["g55_mm"] = [self.r(-40, 40), self.r(-40, 40), self.r(-5, 5)]
                self.g["offsets_mm"] = {"G54.1 P1": [self.r(-40, 40), 12.5, 3.0], "G54.1 P2": [-25.0, self.r(-40, 40), 0.0]}
                kinds += [self.frames, self.frames]
        else: kinds += [lambda: self.frames52()]
        self.put(*q.choice([["G54"], ["G90", "G54"]]), self.G(0), *self.xy(*self.at()), *(["S3000", "M3"] if q.random() < .5 else []))
        self.put(*(["G43", "H1"] if q.random() < .7 else []), *self.xy(z=q.choice([50, 60, 80])), *(["M8"] if q.random() < .3 else []))
        while True:
            self.modal = 0
            q.choice(kinds)()
            if q.random() < .06: self.lines.append("")
            if q.random() < .06: self.lines.append("(----- NEXT %d)" % q.randint(1, 9))
            if self.g10_used and q.random() < .3:
                self.put("G55"); self.put(self.G(0), *self.xy(*self.at())); self.modal = 0; self.contour(); self.put("G54"); self.put(self.G(0), *self.xy(*self.at()))
                if q.random() < .5: self.put("G91", "G10", "L2", "P1", *self.xy(self.r(-9, 9), 3, None)); self.put("G90"); self.put(self.G(0), *self.xy(*self.at()))
            if len(self.lines) > 22 or len(self.lines) > 14 and q.random() < .3: break
        self.put(self.G(0), *self.xy(z=80), *(["M9"] if q.random() < .3 else []))
        self.put(q.choice(["M30", "M30", "M2"]) if not self.subs else "M30")
        for t in self.tail: self.lines += t
        for t in self.subs: self.lines += t
        if self.lines[0] == "%": self.lines.append("%")
        nl = q.choice(["\n", "\n", "\r\n"])
        name = q.choice(["O%04d.nc" % self.mains, "part.nc", "PART.NC", "p.tap"])
        files = {name: (nl.join(self.lines)+nl).encode()}
        for k, t in self.beside.items(): files[k] = (nl.join(["%"]+t+["%"])+nl).encode()
        return files, name, {"gcode": self.g}
    def frames52(self):
        self.up(); self.put("G52", *self.xy(self.r(-50, 50), self.r(-50, 50)))
        self.modal = 0; self.contour(); self.put("G52", "X0", "Y0")
        self.put(self.G(0), *self.xy(*self.at()))


def generate(seed):
    for k in range(50):                      # a corner that does not fit, and the like: the next try
        files, main, opt = Gen(seed*64+k).build(seed)
        try: mv = run(files, main, opt)
        except Refused: continue
        if len(mv) > 8 and all(max(map(abs, m.end)) <= 300 for m in mv): return files, main, opt
    raise RuntimeError("no program for seed %d" % seed)


def rows(text, main="O1", **kw):
    f = {main: text.encode()} if isinstance(text, str) else {k: v.encode() for k, v in text.items()}
    return [(m.kind, m.line, tuple(round(c, 4)+0.0 for c in m.end)) for m in run(f, main, {"gcode": kw})]


def selftest(n=2000):
    A = "O1\nG21G90G17G54\nG0X0Y0Z10\n"
    assert rows(A+"G1Z-1F100\nG3X10Y10I0J10\nM30\n") == [("rapid", 3, (0, 0, 10)), ("line", 4, (0, 0, -1)), ("arc", 5, (10, 10, -1))]
    m = run({"a": (A+"G3X10Y10R-10.F1\nG3I5.\nM30").encode()}, "a", {})
    assert [round(math.degrees(x.turn[2]), 6) for x in m[1:]] == [270, 360], m
    assert tuple(round(x, 6) for x in m[1].centre) == (10, 0, 10)
    m = run({"a": (A+"G18\nG2X20.I10.F1\nG19G3Y10.R5.\nM30").encode()}, "a", {})
    assert abs(m[1].turn[1]+math.pi) < 1e-9 and abs(m[2].turn[0]-math.pi) < 1e-9       # G2 in ZX: clockwise from +Y
    assert rows(A+"#1=3\nWHILE[#1GT0]DO1\nG1X[#1*10]F1\n#1=#1-1\nEND1\nM30")[1:] == [("line", 6, (x, 0, 10)) for x in (30, 20, 10)]
    assert rows(A+"#1=0\nN5#1=#1+1\nG1Y#1F1\nIF[#1LT2]GOTO5\nM30")[1:] == [("line", 6, (0, 1, 10)), ("line", 6, (0, 2, 10))]
    assert rows(A+"M98P20002\nM30\nO2\nG91G1X5.F1\nG90M99")[1:] == [("line", 7, (5, 0, 10)), ("line", 7, (10, 0, 10))]
    assert rows(A+"M97P7L2\nM30\nN7G91G1X5.F1\nG90M99", dialect="haas")[1:] == [("line", 6, (5, 0, 10)), ("line", 6, (10, 0, 10))]
    assert rows({"O1": A+"G65P9A1.B2.I3.I4.F1.\nM30", "O9": "G1X#1Y#2F1\nX#4Y#7\nIF[#5EQ#0]THEN#1=9\nX#1\nM99"})[1:] == \
        [("line", 1, (1, 2, 10)), ("line", 2, (3, 4, 10)), ("line", 4, (9, 4, 10))]
    assert rows(A+"G68X10.Y0R90.\nG1X20.Y0F1\nG91X5.\nG90G69X0Y0\nM30")[1:] == [("line", 5, (10, 10, 10)), ("line", 6, (10, 15, 10)), ("line", 7, (0, 0, 10))]
    assert rows(A+"G68X10.Y0R90.\nG91G1X5.F1\nM30")[1:] == [("line", 5, (0, 5, 10))]      # before an absolute word: about the tool
    assert rows(A+"G16\nG1X10.Y90.F1\nY180.\nG91Y90.\nG15G90X1.Y1.\nM30")[1:] == [("line", 5, (0, 10, 10)), ("line", 6, (-10, 0, 10)), ("line", 7, (0, -10, 10)), ("line", 8, (1, 1, 10))]
    assert rows(A+"G1X10.,R2.F1\nY10.,C3.\nX0\nM30")[1:] == [("line", 4, (8, 0, 10)), ("arc", 4, (10, 2, 10)), ("line", 5, (10, 7, 10)), ("line", 5, (7, 10, 10)), ("line", 6, (0, 10, 10))]
    assert rows(A+"G52X5.Z1.\nG1X1.Y1.Z0F1\nG52X0Z0\nX0Y0\nM30")[1:] == [("line", 5, (6, 1, 1)), ("line", 7, (0, 0, 1))]
    assert rows("O1\nG21G90\nG10L2P1X-100.Y0Z0\nG10L2P2X-80.Y5.Z1.\nG54G0X0Y0Z10.\nG55X0\nM30") == [("rapid", 5, (0, 0, 10)), ("rapid", 6, (20, 0, 10))]
    assert rows(A+"G54.1P1G0X0Y0Z0\nM30", g54_mm=[0, 0, 0], offsets_mm={"G54.1 P1": [1, 2, 3]})[1:] == [("rapid", 4, (1, 2, 3))]
    assert rows(A+"G99G81X5.Y5.Z-3.R2.F1\nX6.\nG98Y9.\nG80G0X0\nM30")[1:] == [
        ("rapid", 4, (5, 5, 10)), ("rapid", 4, (5, 5, 2)), ("line", 4, (5, 5, -3)), ("rapid", 4, (5, 5, 2)), ("rapid", 5, (6, 5, 2)), ("line", 5, (6, 5, -3)),
        ("rapid", 5, (6, 5, 2)), ("rapid", 6, (6, 9, 2)), ("line", 6, (6, 9, -3)), ("rapid", 6, (6, 9, 10)), ("rapid", 7, (0, 9, 10))]
    assert rows(A+"G91G98G81X5.Z-4.R-8.K2F1\nG80\nM30")[1:] == [("rapid", 4, (5, 0, 10)), ("rapid", 4, (5, 0, 2)), ("line", 4, (5, 0, -2)), ("rapid", 4, (5, 0, 10)),
                                                                ("rapid", 4, (10, 0, 10)), ("rapid", 4, (10, 0, 2)), ("line", 4, (10, 0, -2)), ("rapid", 4, (10, 0, 10))]
    assert rows(A.replace("21", "20")+"G1X1.F10.\nM30")[1:] == [("line", 4, (25.4, 0, 254))]
    assert rows(A+"#1=ATAN[1]/[-1]\n#2=ROUND[2.5]+FUP[1.1]*2-FIX[-1.9]\nG1X#1Y#2F1\nM30")[1:] == [("line", 6, (135, 8, 10))]
    seen, moves, arcs = set(), 0, 0
    for s in range(n):
        f, main, o = generate(s)
        key = tuple(sorted(f.items())); assert key not in seen; seen.add(key)
        mv = run(f, main, o)
        assert mv[0].kind == "rapid"
        at = None
        for m in mv:
            if m.kind == "arc":
                k = max(range(3), key=lambda i: abs(m.turn[i])); ij = [i for i in range(3) if i != k]
                ra, rb = (math.hypot(*(p[i]-m.centre[i] for i in ij)) for p in (at, m.end))
                assert abs(ra-rb) < 0.006 and ra > 0.9, (s, m, ra, rb)
                arcs += 1
            at = m.end
        moves += len(mv)
    print("ok: %d programs, %d moves, %d arcs" % (n, moves, arcs))


if __name__ == "__main__":
    selftest(int(sys.argv[1]) if len(sys.argv) > 1 else 2000)
