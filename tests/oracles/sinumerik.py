#!/usr/bin/env python3
"""An interpreter of Sinumerik 840D/828D part programs (milling), written from the control's manuals.

Manuals, as they are named in comments below:
  ONE-F   SINUMERIK ONE / MCP, NC programming, 12/2019, 6FC5398-2EP40-0BA0 (page)
  PG-06   840D sl / 840Di sl Fundamentals, 11/2006, 6FC5398-1BP10-2BA0 (page)
  PG-04   840D Fundamentals, 10/2004, 6FC5298-7AB00-0BP1 (page)
  PGA-06  840D sl Job planning, 03/2006, 6FC5398-2BP10-1BA0 (page)
  K2      Function manual Axes, coordinate systems, frames, 11/2006, 6FC5397-0BP10-2BA0 (page)
  808D    808D ADVANCED, programming milling, 01/2014, 6FC5398-4DP10-0BA1 (page)
  PGZ     840D/840Di/810D Cycles, 11.02 (page)
  OP      840D sl Operating manual milling (page)

Not looked up (as known): block structure of IF/FOR/WHILE/LOOP/REPEAT-UNTIL and CASE (PGA); REPEAT with labels; search rules of
GOTO; PROC with parameters, SAVE, P; rounding of REAL to INT; SUPA and G53; TRANS replaces the whole programmable frame; AP=IC;
CYCLE83's sequence, its anticipation distance and degression; sequences of CYCLE84 and CYCLE840 (PGZ 2.1.6, 2.1.7); HOLES1 begins at the nearer end (PGZ) or
at the first hole (later versions); G4 F; which modal states a subprogram hands back; HOLES2 with INDA=0.
"""
import math, os, random, re, sys
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from move import Move, Refused
from contour import *

DIALECT = "sinumerik"
IDENT = ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))
NAME = re.compile(r'\$?[A-Z_][A-Z_][A-Z0-9_]*')
NUM = re.compile(r'[+-]?(?:\d+\.?\d*|\.\d+)(?:EX[+-]?\d+)?')
UNUM = re.compile(r'(?:\d+\.?\d*|\.\d+)(?:EX[+-]?\d+)?')
# words that leave the path as it is (technology, dynamics, messages); ONE-F list of G functions, as known
QUIET = set("""SOFT BRISK DRIVE FFWON FFWOF COMPOF DIAMOF KONT KONTC KONTT NORM CFC CFTCP CFIN STARTFIFO STOPFIFO STOPRE
 DISPLOF DISPLON SBLOF SBLON FNORM ORIWKS ORIMKS UPATH SPATH CPRECOF WALIMON WALIMOF FENDNORM TRAFOOF CUT2D CUT2DF CDOF
 FIFOCTRL RTLION RTLIOF NORMFEED DYNNORM DYNPOS DYNROUGH DYNSEMIFIN DYNFINISH EXTERN""".split())
QUIETARG = {"MSG", "WORKPIECE", "FGROUP", "SETMS", "CYCLE832", "GROUP_BEGIN", "GROUP_END", "EES_"}
QUIETVAL = {"SPOS", "LIMS", "ADIS", "ADISPOS", "FRC", "FRCM", "OVR", "ACC", "FGREF", "DISPR"}
GQUIET = {9, 40, 60, 64, 601, 602, 603, 641, 642, 643, 644, 645, 93, 94, 95, 96, 97, 961, 971, 450, 451, 460}


def num(s):
    if "EX" in s:
        a, b = s.split("EX")
        return float(a) * 10 ** int(b)
    return float(s)


def mat(a, b): return tuple(tuple(sum(a[i][k]*b[k][j] for k in range(3)) for j in range(3)) for i in range(3))


def rot(axis, deg):
    c, s = math.cos(math.radians(deg)), math.sin(math.radians(deg))
    if deg % 90 == 0: c, s = round(c), round(s)
    i, j = ((1, 2), (2, 0), (0, 1))[axis]
    m = [list(r) for r in IDENT]
    m[i][i] = m[j][j] = c
    m[i][j], m[j][i] = -s, s
    return tuple(tuple(r) for r in m)


def chain(f, g):
    """Frame f, then g inside it."""
    return (mat(f[0], g[0]), tuple(f[1][i] + sum(f[0][i][k]*g[1][k] for k in range(3)) for i in range(3)))


class Goto(Exception):
    def __init__(self, pc): self.pc = pc


class Ret(Exception): pass
class End(Exception): pass


class Line:
    def __init__(self, no, raw):
        s, q = "", False
        for ch in raw:
            if ch == '"': q = not q
            if ch == ';' and not q: break
            s += ch if q else ch.upper()
        s = s.strip()
        self.no, self.skip, self.label, self.n = no, False, None, None
        m = re.match(r'/\d?\s*', s)
        if m: self.skip, s = True, s[m.end():]
        m = re.match(r'[N:]\s*(\d+)\s*', s)
        if m: self.n, s = int(m.group(1)), s[m.end():]
        m = re.match(r'([A-Z_][A-Z_][A-Z0-9_]*)\s*:(?!=)\s*', s)
        if m: self.label, s = m.group(1), s[m.end():]
        self.text = "" if s.startswith("%") else s
        m = NAME.match(self.text)
        self.first = m.group(0) if m else ""


class Prog:
    def __init__(self, key, data):
        self.key = key
        rows = data.decode("latin-1").split("\n")
        self.lines = [Line(i + 1, r) for i, r in enumerate(rows)]
        self.match = {}
        stack = []
        for i, l in enumerate(self.lines):
            f = l.first
            if f == "IF" and not re.search(r'\bGOTO[FBC]?\b', l.text): stack.append(("IF", i, None))
            elif f in ("FOR", "WHILE", "LOOP"): stack.append((f, i, None))
            elif f == "REPEAT" and l.text == "REPEAT": stack.append((f, i, None))
            elif f == "ELSE":
                k, a, _ = stack.pop(); stack.append((k, a, i)); self.match[a] = i
            elif f in ("ENDIF", "ENDFOR", "ENDWHILE", "ENDLOOP", "UNTIL"):
                if not stack: raise Refused(key, l.no, f + " without a beginning")
                k, a, e = stack.pop()
                if {"ENDIF": "IF", "ENDFOR": "FOR", "ENDWHILE": "WHILE", "ENDLOOP": "LOOP", "UNTIL": "REPEAT"}[f] != k:
                    raise Refused(key, l.no, f + " does not close " + k)
                if k == "IF":
                    if e is None: self.match[a] = i
                    else: self.match[e] = i
                else:
                    self.match[a], self.match[i] = i, a
        if stack: raise Refused(key, self.lines[stack[-1][1]].no, stack[-1][0] + " is not closed")


class Run:
    def __init__(self, files, main, options):
        self.files = files
        self.byname = {k.upper(): k for k in files}
        g = options.get("gcode", {})
        self.skipon = g.get("block_delete", "run") == "skip"
        self.inch = 25.4 if g.get("unit") == "inch" else 1.0
        self.finch = 1.0
        self.off = {54: tuple(g.get("g54_mm", (0, 0, 0)))}
        for k in (55, 56, 57): 
            if f"g{k}_mm" in g: self.off[k] = tuple(g[f"g{k}_mm"])
        for k, v in g.get("offsets_mm", {}).items():
            if k.startswith("G5"): self.off[int(k[1:])] = tuple(v)
        self.R, self.scopes, self.depth, self.count = {}, [], 0, 0
        self.pos = [None] * 3
        self.wo, self.pf = 54, (IDENT, (0.0, 0, 0))
        self.plane, self.inc, self.mode = 17, False, None
        self.feed, self.mcall, self.busy = None, None, False
        self.pole, self.ap, self.rp = (0.0, 0.0), None, None
        self.tan, self.chain = None, Chain()
        self.stale = set()          # axes with no absolute position since the frame changed
        self.main = main
        self.prog, self.pc = None, 0
        self.calls = set()

    def no(self, why): raise Refused(self.prog.key, self.prog.lines[self.pc].no, why)

    # ---- expressions -----------------------------------------------------------------------------------
    # Priority of operators, high to low: NOT; * / DIV MOD; + -; B_...; AND; XOR; OR; <<; comparison: PGA-06 p. 1-24
    def expr(self, s, i): return self.level(s, i, 0)
    LEV = [("==", "<>", ">=", "<=", ">", "<"), ("<<",), ("OR",), ("XOR",), ("AND",), ("B_OR",), ("B_XOR",), ("B_AND",), ("+", "-"),
           ("*", "/", "DIV", "MOD")]

    def level(self, s, i, k):
        if k == len(self.LEV): return self.unary(s, i)
        a, i = self.level(s, i, k + 1)
        while True:
            j = ws(s, i)
            for op in self.LEV[k]:
                if s.startswith(op, j) and not (op.isalpha() and re.match(r'[A-Z0-9_]', s[j+len(op):j+len(op)+1] or " ")):
                    if op in "<>" and s[j:j+2] in ("<<", "<>", ">=", "<="): continue
                    break
            else: return a, i
            b, i = self.level(s, j + len(op), k + 1)
            a = self.op(op, a, b)

    def op(self, op, a, b):
        if op in ("==", "<>", ">", "<", ">=", "<="):
            # comparison allows a relative error of about 1e-12: ONE-F p. 444
            eq = abs(a - b) <= 1e-12 * max(abs(a), abs(b))
            return {"==": eq, "<>": not eq, ">": a > b and not eq, "<": a < b and not eq, ">=": a >= b or eq, "<=": a <= b or eq}[op]
        if op == "+": return a + b
        if op == "-": return a - b
        if op == "*": return a * b
        if op == "/":                                        # always REAL, as known
            if b == 0: self.no("division by 0")
            return a / b
        if op == "DIV": return math.trunc(a / b)
        if op == "MOD": return math.fmod(a, b)
        if op == "AND": return bool(a) and bool(b)
        if op == "OR": return bool(a) or bool(b)
        if op == "XOR": return bool(a) != bool(b)
        self.no("operator " + op)

    def unary(self, s, i):
        i = ws(s, i)
        if s.startswith("-", i):
            v, i = self.unary(s, i + 1); return -v, i
        if s.startswith("+", i): return self.unary(s, i + 1)
        m = re.match(r'NOT\b', s[i:])
        if m:
            v, i = self.unary(s, i + 3); return not v, i
        return self.atom(s, i)

    def atom(self, s, i):
        i = ws(s, i)
        if s.startswith("(", i):
            v, i = self.expr(s, i + 1)
            return v, self.need(s, i, ")")
        m = UNUM.match(s, i)
        if m: return num(m.group(0)), m.end()
        m = re.compile(r'R\s*(\d+)').match(s, i)
        if m: return self.r(int(m.group(1))), m.end()
        m = re.compile(r'R\s*\[').match(s, i)
        if m:
            k, i = self.expr(s, m.end())
            return self.r(int(k)), self.need(s, i, "]")
        m = NAME.match(s, i)
        if not m: self.no("expression: " + s[i:i+20])
        n = m.group(0); i = m.end()
        if n in ("TRUE", "FALSE"): return n == "TRUE", i
        if n == "$PI": return math.pi, i
        f = FUN.get(n)
        if f:
            i = self.need(s, i, "(")
            a = []
            while True:
                v, i = self.expr(s, i); a.append(v)
                i = ws(s, i)
                if s.startswith(",", i): i += 1; continue
                break
            i = self.need(s, i, ")")
            try: return f(*a), i
            except (ValueError, ZeroDivisionError, TypeError): self.no("value of " + n)
        for sc in (self.scopes[-1],):
            if n in sc:
                j = ws(s, i)
                v = sc[n][1]
                if s.startswith("[", j):
                    k, i = self.expr(s, j + 1)
                    return v[int(k)], self.need(s, i, "]")
                return v, i
        self.no("unknown name " + n)

    def r(self, k):
        if k not in self.R: self.no(f"R{k} has no value")       # R parameters keep what an earlier program left
        return self.R[k]

    def need(self, s, i, ch):
        i = ws(s, i)
        if not s.startswith(ch, i): self.no(f"expected {ch} at {s[i:i+15]}")
        return i + len(ch)

    # ---- frames ----------------------------------------------------------------------------------------
    def frame(self):
        if self.wo not in self.off: self.no(f"G{self.wo} is not known")
        return chain((IDENT, tuple(map(float, self.off[self.wo]))), self.pf)

    def wcs(self):
        R, t = self.frame()
        out = []
        for k in range(3):
            if any(abs(R[j][k]) > 1e-15 and self.pos[j] is None for j in range(3)): out.append(None)
            else: out.append(sum(R[j][k]*(self.pos[j]-t[j]) for j in range(3) if self.pos[j] is not None))
        return out

    def toW(self, p):
        R, t = self.frame()
        out = []
        for j in range(3):
            if any(abs(R[j][k]) > 1e-15 and p[k] is None for k in range(3)): out.append(None)
            else: out.append(t[j] + sum(R[j][k]*p[k] for k in range(3) if p[k] is not None))
        return out

    def axes(self): return {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}[self.plane]    # PG-06 ch. 3: G18 is ZX

    def basis(self):
        R = self.frame()[0]
        return tuple(tuple(R[j][k] for j in range(3)) for k in self.axes())

    def changed(self):
        self.stale = {0, 1, 2}; self.tan = None
        self.chain.flush()

    # ---- program flow ----------------------------------------------------------------------------------
    def go(self):
        try: self.call(self.main, [], None)
        except End: pass
        self.chain.flush(True)
        return self.chain.moves

    def find(self, name):
        for n in (name + ".SPF", name + ".MPF", name, "_N_" + name + "_SPF", "_N_" + name + "_MPF"):
            if n in self.byname: return self.byname[n]
        return None

    def call(self, key, args, times):
        if self.depth > 11: self.no("too many levels")
        self.calls.add(key)
        prog = Prog(key, self.files[key])
        for _ in range(1 if times is None else times):
            old, sc = (self.prog, self.pc), {}
            save = None
            first = next((l for l in prog.lines if l.text), None)
            params = []
            if first and first.first == "PROC":
                m = re.match(r'PROC\s+(\w+)\s*(?:\((.*?)\))?(.*)', first.text)
                for p in [q.strip() for q in (m.group(2) or "").split(",") if q.strip()]:
                    w = re.match(r'(VAR\s+)?(REAL|INT|BOOL)\s+(\w+)(?:\s*=\s*(\S+))?$', p)
                    if not w or w.group(1): self.no("parameter " + p)
                    params.append((w.group(3), w.group(2), w.group(4)))
                if "SAVE" in m.group(3): save = (self.mode, self.plane, self.inc, self.inch, self.wo, self.pf)
            if len(args) > len(params): self.no("more arguments than parameters")
            for k, (n, t, dflt) in enumerate(params):
                v = args[k] if k < len(args) and args[k] is not None else (num(dflt) if dflt else 0.0)
                sc[n] = (t, cast(t, v))
            self.scopes.append(sc)
            self.depth += 1
            self.prog = prog
            try: self.range(0, len(prog.lines))
            except Ret: pass
            finally:
                self.depth -= 1
                if self.depth: self.scopes.pop()
            self.prog, self.pc = old
            if save:
                before = (self.wo, self.pf)
                self.mode, self.plane, self.inc, self.inch, self.wo, self.pf = save
                if before != (self.wo, self.pf): self.changed()

    def range(self, lo, hi):
        pc = lo
        while pc < hi:
            self.pc = pc
            self.count += 1
            if self.count > 100000: self.no("loops without end")
            try: nxt = self.block(pc)
            except Goto as g:
                nxt = g.pc
                if not lo <= nxt < hi: 
                    if (lo, hi) == (0, len(self.prog.lines)): raise
                    self.no("jump out of a repeated section")
            pc = pc + 1 if nxt is None else nxt
        self.pc = min(hi, len(self.prog.lines)) - 1

    def target(self, s, i, how):
        i = ws(s, i)
        m = re.compile(r'N(\d+)\b').match(s, i)
        L = self.prog.lines
        if m: ok = lambda l: l.n == int(m.group(1))
        else:
            m = NAME.match(s, i)
            if not m: self.no("target of a jump")
            ok = lambda l: l.label == m.group(0)
        fw = [k for k in range(self.pc + 1, len(L)) if ok(L[k])]
        bw = [k for k in range(self.pc, -1, -1) if ok(L[k])]
        # GOTOF towards the end, GOTOB towards the beginning, GOTO first forward, then back: as known (PGA, program jumps)
        c = {"GOTOF": fw, "GOTOB": bw, "GOTO": fw + bw}[how]
        if not c: self.no("label not found")
        return c[0], m.end()

    def cond(self, s, i): 
        v, i = self.expr(s, i)
        return bool(v), i

    def block(self, pc):
        l = self.prog.lines[pc]
        if not l.text or (l.skip and self.skipon): return None
        s, f, M = l.text, l.first, self.prog.match
        i = len(f)
        if f in ("PROC", "EXTERN", "ENDLABEL"): return None
        if f == "IF":
            c, i = self.cond(s, i)
            m = re.compile(r'\s*(GOTO[FB]?)\b').match(s, i)
            if m: return self.target(s, m.end(), m.group(1))[0] if c else None
            if re.match(r'\s*GOTO', s[i:]): self.no("GOTOC")
            return None if c else M[pc] + 1
        if f == "ELSE": return M[pc] + 1
        if f == "ENDIF": return None
        if f == "WHILE":
            c, i = self.cond(s, i)
            return None if c else M[pc] + 1
        if f in ("ENDWHILE", "ENDLOOP"): return M[pc]
        if f == "LOOP": return None
        if f == "UNTIL":
            c, i = self.cond(s, i)
            return None if c else M[pc]
        if f == "FOR":
            m = re.match(r'FOR\s*(R\d+|[A-Z_]\w*)\s*=(.*)\bTO\b(.*)$', s)
            if not m: self.no("FOR")
            a, b = self.expr(m.group(2), 0)[0], self.expr(m.group(3), 0)[0]
            self.set(m.group(1), a)
            return None if a <= b else M[pc] + 1
        if f == "ENDFOR":
            h = self.prog.lines[M[pc]].text
            m = re.match(r'FOR\s*(R\d+|[A-Z_]\w*)\s*=(.*)\bTO\b(.*)$', h)
            v = self.expr(m.group(1), 0)[0] + 1
            self.set(m.group(1), v)
            return M[pc] + 1 if v <= self.expr(m.group(3), 0)[0] else None
        if f == "CASE":
            v, i = self.expr(s, i)
            i = self.need(s, i, "OF")
            while True:
                i = ws(s, i)
                if i >= len(s): return None
                d = s.startswith("DEFAULT", i)
                if d: k, i = None, i + 7
                else: k, i = self.expr(s, i)
                m = re.compile(r'\s*(GOTO[FB]?)\b').match(s, i)
                if not m: self.no("CASE")
                if d or k == v: return self.target(s, m.end(), m.group(1))[0]
                i = re.compile(r'\s*\w+').match(s, m.end()).end()
        if f in ("GOTOF", "GOTOB", "GOTO"): return self.target(s, i, f)[0]
        if f == "GOTOS": self.no("GOTOS")
        if f in ("REPEAT", "REPEATB") and s != "REPEAT": return self.repeat(s, i, f)
        if f == "REPEAT": return None
        if f == "DEF": return self.define(s, i)
        return self.words(s)

    def repeat(self, s, i, f):
        # REPEAT LABEL [LABEL2] P=n / REPEATB LABEL P=n: as known (PGA, program section repetition): the end label's block belongs to it
        m = re.match(r'\s*(\w+)(?:\s+(?!P\s*=)(\w+))?(?:\s+P\s*=\s*(.*))?$', s[i:])
        if not m: self.no(f)
        n = 1 if m.group(3) is None else int(self.expr(m.group(3), 0)[0])
        L = self.prog.lines
        at = {l.label: k for k, l in enumerate(L) if l.label and l.label != "ENDLABEL"}
        if m.group(1) not in at or (m.group(2) and m.group(2) not in at): self.no("label not found")
        a, here = at[m.group(1)], self.pc
        if f == "REPEATB": b = a + 1
        elif m.group(2): b = at[m.group(2)] + 1
        else:
            e = [k for k in range(a, len(L)) if L[k].label == "ENDLABEL"]
            if a < here and not (e and e[0] < here): b = here
            elif e: b = e[0] + 1
            else: self.no("REPEAT without an end")
        for _ in range(n): 
            self.range(a, b)
        self.pc = here
        return None

    def define(self, s, i):
        m = re.match(r'\s*(REAL|INT|BOOL)\b', s[i:])
        if not m: self.no("DEF of this type")
        t, i = m.group(1), i + m.end()
        while True:
            i = ws(s, i)
            m = NAME.match(s, i)
            if not m: self.no("DEF")
            n, i = m.group(0), ws(s, m.end())
            v, size = 0.0, None
            if s.startswith("[", i):
                size, i = self.expr(s, i + 1)
                i = ws(s, self.need(s, i, "]"))
                v = [0.0] * int(size)
            if s.startswith("=", i):
                i = ws(s, i + 1)
                if size is not None:
                    m = re.compile(r'(?:SET)?\s*\(').match(s, i)
                    if not m: self.no("list of values")
                    i, k = m.end(), 0
                    while True:
                        x, i = self.expr(s, i); v[k] = cast(t, x); k += 1
                        i = ws(s, i)
                        if s.startswith(",", i): i += 1
                        else: break
                    i = self.need(s, i, ")")
                else:
                    x, i = self.expr(s, i); v = cast(t, x)
            self.scopes[-1][n] = (t, v)
            i = ws(s, i)
            if s.startswith(",", i): i += 1
            elif i >= len(s): return None
            else: self.no("DEF")

    def set(self, n, v, idx=None):
        m = re.match(r'R(\d+)$', n)
        if m: self.R[int(m.group(1))] = float(v); return
        sc = self.scopes[-1]
        if n not in sc: self.no("unknown name " + n)
        t, old = sc[n]
        if idx is None: sc[n] = (t, cast(t, v))
        else: old[int(idx)] = cast(t, v)

    def value(self, s, i):
        """What stands behind an address: (number, None | "AC" | "IC")."""
        i = ws(s, i)
        if s.startswith("=", i):
            i = ws(s, i + 1)
            m = re.compile(r'(AC|IC|DC|ACP|ACN)\s*\(').match(s, i)
            if m:
                if m.group(1) not in ("AC", "IC"): self.no(m.group(1))
                v, i = self.expr(s, m.end())
                return (v, m.group(1)), self.need(s, i, ")")
            v, i = self.expr(s, i)
            return (v, None), i
        m = NUM.match(s, i)
        if not m: self.no("value: " + s[i:i+15])
        return (num(m.group(0)), None), m.end()

    def args(self, s, i):
        out, i = [], i + 1
        while True:
            i = ws(s, i)
            if s[i:i+1] in (",", ")"): out.append(None)
            elif s[i:i+1] == '"':
                j = s.index('"', i + 1); out.append(s[i+1:j]); i = j + 1
            else:
                v, i = self.expr(s, i); out.append(v)
            i = ws(s, i)
            if s.startswith(",", i): i += 1; continue
            i = self.need(s, i, ")")
            return ([] if out == [None] else out), i

    def words(self, s):
        g, ax, par, call, stop, frames, quietF = [], {}, {}, None, None, [], False
        mcall = supa = False
        i = 0
        while True:
            i = ws(s, i)
            if i >= len(s): break
            m = NAME.match(s, i)
            if m:
                n, j = m.group(0), ws(s, m.end())
                if n in self.scopes[-1]:
                    idx = None
                    if s.startswith("[", j): 
                        idx, j = self.expr(s, j + 1); j = ws(s, self.need(s, j, "]"))
                    j = self.need(s, j, "=")
                    v, i = self.expr(s, j)
                    self.set(n, v, idx)
                elif n in ("CR", "AR", "AP", "RP", "RND", "CHF", "CHR", "TURN", "RPL"):
                    par[n], i = self.value(s, self.need(s, j, "=") - 1)
                elif n in ("TRANS", "ATRANS", "ROT", "AROT"): frames.append(n); i = j
                elif n in ("CIP", "CT"): g.append(n); i = j
                elif n == "SUPA": supa = True; i = j
                elif n == "MCALL": mcall = True; i = j
                elif n == "RET": stop = "ret"; i = j
                elif n == "CALL":
                    m = re.compile(r'"([^"]*)"').match(s, j)
                    if not m: self.no("CALL")
                    call, i = (m.group(1).upper(), []), m.end()
                elif n in QUIET: i = j
                elif n in QUIETARG:
                    i = self.close(s, j) if s.startswith("(", j) else j
                elif n in QUIETVAL:
                    _, i = self.value(s, j)
                elif n in ("FXS",): self.no(n)
                elif n == "CYCLE800" :
                    a, i = self.args(s, j)
                    if a: self.no("CYCLE800")
                elif n.startswith("CYCLE") or n in ("HOLES1", "HOLES2") or self.find(n):
                    a = []
                    if s.startswith("(", j): a, j = self.args(s, j)
                    call, i = (n, a), j
                else: self.no(("file is missing or word is unknown: " if re.match(r'\w+$', n) else "") + n)
                continue
            c = s[i]
            m = re.compile(r'R\s*(\d+|\[)').match(s, i)
            if m:
                if m.group(1) == "[":
                    k, j = self.expr(s, m.end()); j = self.need(s, j, "]")
                else: k, j = int(m.group(1)), m.end()
                j = self.need(s, j, "=")
                v, i = self.expr(s, j)
                self.R[int(k)] = float(v)
            elif c == "G":
                m = re.compile(r'G\s*(\d+)').match(s, i)
                if not m: self.no("G")
                g.append(int(m.group(1))); i = m.end()
            elif re.compile(r'[IJK]1\s*=').match(s, i):
                par[s[i:i+2]], i = self.value(s, i + 2)
            elif c in "XYZ":
                if re.compile(r'.\d+\s*=').match(s, i):       # a machine axis: X1=
                    m = re.compile(r'.\d+').match(s, i)
                    ax["M" + c], i = self.value(s, m.end())
                else: ax[c], i = self.value(s, i + 1)
            elif c in "IJKFSTDMHP":
                if c in "SMT" and re.compile(r'.\d+\s*=').match(s, i): i = re.compile(r'.\d+').match(s, i).end() - 1
                if c == "T" and re.compile(r'T\s*=\s*"').match(s, i):
                    i = s.index('"', s.index('"', i) + 1) + 1
                    continue
                par.setdefault(c, [])
                v, i = self.value(s, i + 1)
                par[c].append(v)
            elif c == "L":
                m = re.compile(r'L\s*(\d+)').match(s, i)
                if not m: self.no("L")
                call, i = ("L" + m.group(1), []), m.end()     # leading zeros count: as known
            elif c in "ABCUVWQE": self.no("axis or address " + c)
            else: self.no("text " + s[i:i+15])
        for v, _ in par.get("M", []):
            if v in (0, 1, 3, 4, 5, 6, 7, 8, 9, 19) or 40 <= v <= 45: pass
            elif v in (2, 30): stop = "end"
            elif v == 17: stop = "ret"
            else: self.no(f"M{v:g}")
        if any(x in ax for x in ("MX", "MY", "MZ")) or 74 in g or 75 in g:
            if 74 not in g and 75 not in g: self.no("machine axis")
            self.chain.flush()
            for k, x in enumerate("XYZ"):
                if "M" + x in ax or x in ax: self.pos[k] = None
            self.tan = None
            return self.after(stop)
        if 4 in g: return self.after(stop)                    # G4 F..: dwell; F is not the feed (as known, PG-06 ch. 5)
        if 25 in g or 26 in g: return self.after(stop)
        self.modal(g, frames, ax, par, supa, call, mcall)
        if call or mcall:
            return self.calling(call, mcall, par, stop, ax)
        return self.after(stop)

    def after(self, stop):
        if stop == "end":
            raise End if self.depth == 1 else Ret             # M2/M30 in a subprogram ends it like M17: as known
        if stop == "ret": raise Ret
        return None

    def close(self, s, i):
        q, d = False, 0
        for k in range(i, len(s)):
            if s[k] == '"': q = not q
            elif not q and s[k] == "(": d += 1
            elif not q and s[k] == ")":
                d -= 1
                if d == 0: return k + 1
        self.no("no closing )")

    # ---- motion ----------------------------------------------------------------------------------------
    def modal(self, g, frames, ax, par, supa, call, mcall):
        sup, pole = supa, None
        for x in g:
            if x in (0, 1, 2, 3, "CIP", "CT"): self.mode = x
            elif x in (17, 18, 19):
                if x != self.plane: self.plane, self.pole, self.ap, self.rp = x, None, None, None
            # G70/G71: lengths of the workpiece; G700/G710: feeds as well: ONE-F ch. 2.9.2; 808D p. 54
            elif x in (70, 700): self.inch, self.finch = 25.4, 25.4 if x == 700 else 1.0
            elif x in (71, 710): self.inch = self.finch = 1.0
            elif x in (90, 91): self.inc = x == 91
            elif x in (53, 153): sup = True
            elif 54 <= x <= 57 or x == 500 or 505 <= x <= 599:
                if self.wo != x: self.wo = x; self.frame(); self.changed()
            elif x in (110, 111, 112): pole = x
            elif x in GQUIET: pass
            else: self.no(f"G{x}")
        if par.get("F"): self.feed = par["F"][-1][0] * self.finch
        if frames:
            return self.programmable(frames, ax, par)
        if pole: return self.set_pole(pole, ax, par)
        if sup and ax:
            # G53, G153, SUPA suppress the offsets for this block: as known (PG-06 ch. 6). Where that is in W is not known.
            if self.mode not in (0, 1): self.no("SUPA with an arc")
            self.chain.flush(); self.tan = None
            for k, x in enumerate("XYZ"):
                if x in ax: self.pos[k] = None
            return
        if not ax and not any(k in par for k in ("AP", "RP", "I", "J", "K", "AR", "CR", "TURN")): return
        if call and (ax or "AP" in par): self.no("motion and call in one block")
        self.motion(ax, par)
        if self.mcall and not self.busy: self.modal_call()

    def programmable(self, frames, ax, par):
        # TRANS and ROT replace the programmable frame, ATRANS and AROT add to it: ONE-F p. 309, 316; own blocks: ONE-F p. 309
        if len(frames) > 1: self.no("two frame instructions")
        n = frames[0]
        v = []
        for k, x in enumerate("XYZ"):
            if x in ax:
                if ax[x][1]: self.no(n + " with AC or IC")
                v.append(ax[x][0])
            else: v.append(None)
        new = (IDENT, (0.0, 0, 0))
        if n.endswith("TRANS"):
            new = (IDENT, tuple(self.inch * (a or 0.0) for a in v))          # G70: 808D p. 54
        elif "RPL" in par:
            # RPL turns in the plane G17 to G19: ONE-F p. 316; positive from the first to the second axis of the plane
            new = (rot(self.axes()[2], par["RPL"][0]), (0.0, 0, 0))
        else:
            # ROT X Y Z: RPY, in the order Z, Y', X'': ONE-F p. 309, K2 p. 56
            R = IDENT
            for k in (2, 1, 0):
                if v[k] is not None: R = mat(R, rot(k, v[k]))
            new = (R, (0.0, 0, 0))
        self.chain.flush()
        self.pf = chain(self.pf, new) if n[0] == "A" else new
        self.changed()

    def set_pole(self, g, ax, par):
        # G110 from the last position, G111 from the zero of the workpiece, G112 from the last pole: PG-06 p. 118
        a, b, _ = self.axes()
        if "AP" in par:
            q = (par["RP"][0]*self.inch*math.cos(math.radians(par["AP"][0])), par["RP"][0]*self.inch*math.sin(math.radians(par["AP"][0])))
        else:
            q = []
            for k in (a, b):
                x = "XYZ"[k]
                if x not in ax: self.no("pole without both coordinates")
                q.append(ax[x][0] * self.inch)
        if g == 110:
            p = self.wcs(); o = (p[a], p[b])
        elif g == 111: o = (0.0, 0.0)
        else: o = self.pole or self.no("no pole in this plane")
        if None in o: self.no("pole from an unknown position")
        self.pole, self.ap, self.rp = (o[0] + q[0], o[1] + q[1]), None, None

    def motion(self, ax, par):
        if self.mode is None: self.no("no G0 or G1 before")
        if self.mode in (0, 1) and any(k in par for k in ("I", "J", "K", "I1", "J1", "K1", "CR", "AR", "TURN")): self.no("word of an arc without an arc")
        old = self.wcs()
        new = list(old)
        i1, i2, i3 = self.axes()
        polar = "AP" in par or "RP" in par
        for k, x in enumerate("XYZ"):
            if x not in ax: continue
            v, how = ax[x]
            if polar and k != i3: self.no("polar and Cartesian in one block")
            if how == "IC" or (self.inc and how != "AC"):
                # after a frame changed SD42440 decides whether an incremental move goes the zero's way, too
                if k in self.stale: self.no("incremental after a frame changed: SD42440 decides")
                if old[k] is None: self.no("incremental from an unknown position")
                new[k] = old[k] + v * self.inch
            else:
                new[k] = v * self.inch
                self.stale.discard(k)
        if polar:
            # AP from the first axis of the plane, positive towards the second; both stay: ONE-F p. 174, 808D p. 54
            if self.pole is None: self.no("no pole in this plane")
            if "AP" in par:
                v, how = par["AP"]
                if how == "IC":
                    if self.ap is None: self.no("AP=IC without an angle before")
                    v += self.ap
                self.ap = v
            if "RP" in par:
                v, how = par["RP"]
                if how == "IC":
                    if self.rp is None: self.no("RP=IC without a radius before")
                    self.rp += v * self.inch
                else: self.rp = v * self.inch
            if self.ap is None or self.rp is None: self.no("AP or RP is missing")
            new[i1] = self.pole[0] + self.rp * math.cos(math.radians(self.ap))
            new[i2] = self.pole[1] + self.rp * math.sin(math.radians(self.ap))
            self.stale -= {i1, i2}
        elif ax and ({"XYZ".index(x) for x in ax} & {i1, i2}): self.ap = None
        corner = None
        for n, how in (("RND", "round"), ("CHR", "leg"), ("CHF", "base")):
            # RND: radius; CHR: length along the lines; CHF: length of the chamfer itself, CHF = 2 cos(a) CHR: PG-06 p. 193 f.
            if n in par and par[n][0] > 0:
                if corner: self.no("rounding and chamfer in one block")
                corner = (how, par[n][0] * self.inch, None, self.feed)
        self.to(self.mode, new, par, corner, old)

    def to(self, mode, new, par, corner, old=None):
        old = old or self.wcs()
        l = self.prog.lines[self.pc].no
        if corner: corner = (corner[0], corner[1], l, corner[3])
        startW, endW = list(self.pos), self.toW(new)
        # an axis that is not programmed keeps its place, also where it is not known
        B = self.basis()
        seg = None
        if mode in (0, 1):
            self.pos = endW
            if None in endW:
                self.chain.flush(); self.tan = None
                if corner: self.no("corner at an unknown position")
                return
            if mode == 1 and not self.feed: self.no("no feed")
            seg = Seg("rapid" if mode == 0 else "line", None if None in startW else tuple(startW), tuple(endW), B, self.prog.key, l, self.feed)
        else:
            if None in old: self.no("arc from an unknown position")
            if not self.feed: self.no("no feed")
            seg = self.arc(mode, old, new, par, B, l)
            self.pos = list(seg.b)
        seg.corner = corner
        if seg.a is None:
            if corner: self.no("corner after an unknown position")
            self.chain.flush(); self.tan = None
        else:
            t = seg.dir_at(1)
            if t: self.tan = t
        self.chain.put(seg)

    def arc(self, mode, old, new, par, B, line):
        i1, i2, i3 = self.axes()
        a, b = (old[i1], old[i2]), (new[i1], new[i2])
        turns = int(par.get("TURN", (0, None))[0])
        lift = lambda c: tuple(self.toW([c[0] if k == i1 else c[1] if k == i2 else old[i3] for k in range(3)]))
        if mode == "CIP": return self.cip(old, new, par, B, line, turns)
        if mode == "CT":
            # tangent to the last block with motion, its projection into the plane; a helix if the third axis moves: ONE-F p. 201-204
            if self.tan is None: self.no("CT without a direction before")
            t = (dot(self.tan, B[0]), dot(self.tan, B[1]))
            q = math.hypot(*t)
            if q < 1e-9: self.no("CT after a move across the plane")
            if math.hypot(b[0]-a[0], b[1]-a[1]) < SAME: self.no("CT without a distance")
            c, sense = centre_by_tangent(a, (t[0]/q, t[1]/q), b)
            if sense is None: self.no("CT straight back")
            if sense == 0:                                   # limit case: ONE-F p. 203
                return Seg("line", tuple(self.pos), tuple(self.toW(new)), B, self.prog.key, line, self.feed)
            return Seg("arc", tuple(self.pos), tuple(self.toW(new)), B, self.prog.key, line, self.feed, lift(c), B[2], sweep(a, b, c, sense, turns))
        sense = 1 if mode == 3 else -1                       # G2 clockwise seen against the third axis: ONE-F ch. 2.9.5
        cen = {}
        for k, x in enumerate("IJK"):
            if x in par:
                if k == i3: self.no("centre across the plane")
                v, how = par[x][-1]
                # from the start, whatever G90 and G91 say; AC: absolute: PG-06 ch. 4
                cen[k] = v * self.inch + (0 if how == "AC" else old[k])
        if "AP" in par or "RP" in par: c = self.pole          # the pole is the centre: ONE-F ch. 2.9.3.2, 808D p. 78
        elif "AR" in par and cen:
            c = (cen.get(i1, old[i1]), cen.get(i2, old[i2]))
            if math.hypot(b[0]-a[0], b[1]-a[1]) > SAME: self.no("AR with centre and end")
            w = sense * math.radians(par["AR"][0])
            dx, dy = a[0]-c[0], a[1]-c[1]
            b = (c[0] + dx*math.cos(w) - dy*math.sin(w), c[1] + dx*math.sin(w) + dy*math.cos(w))
            new = list(new); new[i1], new[i2] = b
        elif "AR" in par:
            q = math.hypot(b[0]-a[0], b[1]-a[1])
            w = math.radians(par["AR"][0])
            if not 0 < w < 2*math.pi or q < SAME: self.no("AR")
            r = q / (2*math.sin(w/2))
            c = centre_by_radius(a, b, r if w <= math.pi else -r, sense)
        elif "CR" in par:
            # CR positive: up to 180 degrees, negative: more; no whole circles: ONE-F ch. 2.9.5
            c = centre_by_radius(a, b, par["CR"][0] * self.inch, sense)
            if c is None: self.no("CR too small or no distance")
        elif cen: c = (cen.get(i1, old[i1]), cen.get(i2, old[i2]))
        else: self.no("arc without a centre")
        r, e = math.hypot(a[0]-c[0], a[1]-c[1]), math.hypot(b[0]-c[0], b[1]-c[1])
        if r < 1e-6: self.no("arc without a radius")
        if abs(r - e) > 0.01: self.no(f"end of the circle: radii {r:.6f} and {e:.6f}")     # MD21000, alarm 14040: as known
        return Seg("arc", tuple(self.pos), tuple(self.toW(new)), B, self.prog.key, line, self.feed, lift(c), B[2], sweep(a, b, c, sense, turns))

    def cip(self, old, new, par, B, line, turns):
        # end and intermediate point I1 J1 K1, both by G90/G91; any plane in space: 802D p. 8-156, ONE-F ch. 2.9.6
        mid = list(old)
        for k, x in enumerate(("I1", "J1", "K1")):
            if x in par:
                v, how = par[x]
                inc = how == "IC" or (self.inc and how != "AC")
                mid[k] = v * self.inch + (old[k] if inc else 0)
        if turns: self.no("CIP with TURN")
        a, m, b = tuple(self.pos), tuple(self.toW(mid)), tuple(self.toW(new))
        p, q = add(m, a, -1.0), add(b, a, -1.0)
        n = cross(p, q)
        if norm(q) < SAME: self.no("CIP: a whole circle")
        if norm(n) < 1e-9 * max(1, norm(p)*norm(q)): self.no("CIP: points on a line")
        n2 = dot(n, n)
        c = add(a, mul(add(mul(cross(q, n), dot(p, p)), mul(cross(n, p), dot(q, q))), 1/(2*n2)))
        n = mul(n, 1/norm(n))                                 # start, middle, end run counter-clockwise about n
        u = mul(add(a, c, -1.0), 1/norm(add(a, c, -1.0)))
        v = cross(n, u)
        e = add(b, c, -1.0)
        w = math.atan2(dot(e, v), dot(e, u)) % (2*math.pi)
        return Seg("arc", a, b, B, self.prog.key, line, self.feed, c, n, w)

    # ---- calls and cycles ------------------------------------------------------------------------------
    def calling(self, call, mcall, par, stop, ax):
        times = None
        if "P" in par: times = int(par["P"][0][0])
        if mcall:
            self.mcall = call
            return self.after(stop)
        n, a = call
        if n in CYCLES: CYCLES[n](self, *a)
        else:
            key = self.find(n)
            if key is None: self.no(f"{n}: the file is missing")
            self.call(key, a, times)
        return self.after(stop)

    def modal_call(self):
        n, a = self.mcall
        self.busy = True
        if n in CYCLES: CYCLES[n](self, *a)
        else:
            key = self.find(n)
            if key is None: self.no(f"{n}: the file is missing")
            self.call(key, a, None)
        self.busy = False

    def axis(self, mode, z, feed=None):
        p = self.wcs()
        p[self.axes()[2]] = z
        f = self.feed
        if feed: self.feed = feed
        self.to(mode, p, {}, None)
        self.feed = f

    def head(self, RTP, RFP, SDIS, DP, DPR):
        # RFP + SDIS by rapid, DP absolute or DPR from RFP without sign, RTP by rapid: CYCLE81, helmancnc page on CYCLE81, PGZ 2.1.2
        s = self.inch
        if None in (RTP, RFP): self.no("cycle without planes")
        RTP, RFP, SDIS = RTP*s, RFP*s, (SDIS or 0)*s
        up = 1 if RTP >= RFP else -1
        if RTP == RFP and DP is None: self.no("planes not defined")
        d = RFP - up*abs(DPR)*s if DPR is not None else None if DP is None else DP*s        # DPR counts if both are given: PGZ 2.1.2
        if d is None: self.no("cycle without a depth")
        if not self.feed: self.no("no feed")
        if None in self.wcs(): self.no("cycle at an unknown position")
        return RTP, RFP + up*SDIS, d, up, RFP

    def c81(self, RTP=None, RFP=None, SDIS=None, DP=None, DPR=None, *rest):
        if len(rest) > 1 and any(x is not None for x in rest[1:]): self.no("cycle with new parameters")
        r, z, d, up, _ = self.head(RTP, RFP, SDIS, DP, DPR)
        self.axis(0, z); self.axis(1, d); self.axis(0, r)

    def c83(self, RTP=None, RFP=None, SDIS=None, DP=None, DPR=None, FDEP=None, FDPR=None, DAM=0, DTB=0, DTS=0, FRF=1, VARI=0,
            AXN=None, MDEP=None, VRT=None, DTD=None, DIS1=None, *rest):
        if rest or (AXN not in (None, 0, 3)): self.no("CYCLE83 with new parameters")
        r, z, d, up, ref = self.head(RTP, RFP, SDIS, DP, DPR)
        s = self.inch
        total = abs(ref - d)
        first = abs(FDPR)*s if FDPR is not None else None if FDEP is None else abs(ref - FDEP*s)
        if first is None or first > total + 1e-9: self.no("first drilling depth")     # alarm 61107
        dam = (DAM or 0) * s
        if dam < 0 or MDEP: self.no("degression by a factor")
        depths, step, at = [first], first, first
        while total - at > 1e-9:
            # DAM 0: the same step again. DAM > 0: smaller by DAM, not below DAM; what is left below two steps is halved. As known (PGZ 2.1.4)
            rest_ = total - at
            if dam > 0: step = max(step - dam, dam)
            if rest_ <= step + 1e-9: at = total
            elif rest_ < 2*step - 1e-9: at += rest_/2; step = rest_/2
            else: at += step
            depths.append(at)
        frf = FRF or 1
        self.axis(0, z)
        for k, q in enumerate(depths):
            self.axis(1, ref - up*q, self.feed*frf if k == 0 else None)
            if k + 1 == len(depths): break
            if VARI:                                          # out of the hole, back to above the last depth: as known (PGZ 2.1.4)
                self.axis(0, z)
                ant = DIS1*s if DIS1 else (0.6 if q <= 30 else min(q/50, 7.0))
                self.axis(0, min(ref - up*q + up*ant, z) if up > 0 else max(ref - up*q + up*ant, z))
            else: self.axis(1, ref - up*q + up*(VRT*s if VRT else 1.0))    # by 1 mm with feed: as known (PGZ 2.1.4)
        self.axis(0, r)

    def tap(self, planes, pitch, down, back):
        # by G0 to RFP + SDIS, by G331 (G63, G33) to the depth, the same way back to RFP + SDIS, by G0 to RTP; then the G functions
        # before the cycle are in force again: PGZ 2.1.6, 2.1.7. Judged is the thread: the ways above it are loose
        f, m = self.feed, self.chain.moves
        self.feed = self.feed or 1
        r, z, d, up, ref = self.head(*planes)
        if len(m) > 1 and m[-1].kind == "rapid" and dist(m[-1].end, m[-2].end) < 0.5: m[-1].loose = True      # G0 over the corrected place
        if (z - d)*up <= 0 or (r - ref)*up < 0: self.no("planes not defined")                     # alarm 61101: PGZ 2.1.2
        for mode, to, fd in ((0, z, None), (1, d, pitch*down or None), (1, z, pitch*back or None), (0, r, None)):
            n = len(m)
            self.axis(mode, to, fd)
            if to != d:
                for x in m[n:]: x.loose = True
        self.feed = f

    def c84(self, RTP=None, RFP=None, SDIS=None, DP=None, DPR=None, DTB=None, SDAC=None, MPIT=None, PIT=None, POSS=None, SST=None, SST1=None, AXN=None, *rest):
        if rest or AXN not in (None, 0, 3): self.no("CYCLE84 with new parameters")
        if SST is None or not (PIT or MPIT): self.no("CYCLE84 without pitch or speed")     # 61001: PGZ 2.1.6; MPIT 3 to 48, its pitch is not needed here
        p = abs(PIT) * self.inch if PIT else 1.0
        self.tap((RTP, RFP, SDIS, DP, DPR), p, SST, SST1 or SST)

    def c840(self, RTP=None, RFP=None, SDIS=None, DP=None, DPR=None, DTB=None, SDR=0, SDAC=3, ENC=0, MPIT=None, PIT=None, AXN=None, *rest):
        # compensating chuck; with an encoder (ENC 0, 20) the pitch must be given, without the feed in force may say it: PGZ 2.1.7
        if rest or AXN not in (None, 0, 3): self.no("CYCLE840 with new parameters")
        if (ENC or 0) not in (0, 1, 11, 20): self.no("ENC")
        if not (ENC or 0) % 10 and not (PIT or MPIT): self.no("CYCLE840 without a pitch")
        self.tap((RTP, RFP, SDIS, DP, DPR), 0, 0, 0)

    def place(self, q):
        p = self.wcs()
        i1, i2, _ = self.axes()
        p[i1], p[i2] = q
        self.stale -= {i1, i2}
        n = len(self.chain.moves)
        self.to(0, p, {}, None)
        if self.mcall and self.mcall[0] in ("CYCLE84", "CYCLE840"):
            for x in self.chain.moves[n:]: x.loose = True       # the hole's place, which a written program may leave out
        if self.mcall and not self.busy: self.modal_call()

    def holes1(self, SPCA=None, SPCO=None, STA1=0, FDIS=0, DBH=0, NUM_=None, *rest):
        if rest or NUM_ is None: self.no("HOLES1")
        s = self.inch
        w = math.radians(STA1 or 0)
        pts = [((SPCA or 0)*s + ((FDIS or 0) + k*(DBH or 0))*s*math.cos(w), (SPCO or 0)*s + ((FDIS or 0) + k*(DBH or 0))*s*math.sin(w)) for k in range(int(NUM_))]
        p = self.wcs(); i1, i2, _ = self.axes()
        if p[i1] is not None and p[i2] is not None:
            far = lambda q: math.hypot(q[0]-p[i1], q[1]-p[i2])
            if far(pts[-1]) < far(pts[0]) - 1e-9: pts.reverse()    # from the nearer end: as known (PGZ 2.3.2)
        for q in pts: self.place(q)

    def holes2(self, CPA=None, CPO=None, RAD=None, STA1=0, INDA=0, NUM_=None, *rest):
        # from STA1 on by INDA, or by 360/NUM if that is 0: OP p. 286, PGZ 2.3.3
        if rest or NUM_ is None or RAD is None: self.no("HOLES2")
        s, n = self.inch, int(NUM_)
        ind = INDA if INDA else 360.0 / n
        for k in range(n):
            w = math.radians((STA1 or 0) + k*ind)
            self.place(((CPA or 0)*s + RAD*s*math.cos(w), (CPO or 0)*s + RAD*s*math.sin(w)))


CYCLES = {"CYCLE81": Run.c81, "CYCLE82": Run.c81, "CYCLE83": Run.c83, "CYCLE84": Run.c84, "CYCLE840": Run.c840, "HOLES1": Run.holes1, "HOLES2": Run.holes2}
deg, rad = math.degrees, math.radians
FUN = {"SIN": lambda x: math.sin(rad(x)), "COS": lambda x: math.cos(rad(x)), "TAN": lambda x: math.tan(rad(x)),
       "ASIN": lambda x: deg(math.asin(x)), "ACOS": lambda x: deg(math.acos(x)), "ATAN2": lambda y, x: deg(math.atan2(y, x)),
       "SQRT": math.sqrt, "ABS": abs, "POT": lambda x: x*x, "TRUNC": lambda x: float(math.trunc(x)), "ROUND": lambda x: math.floor(x + 0.5),
       "LN": math.log, "EXP": math.exp, "MINVAL": min, "MAXVAL": max, "BOUND": lambda lo, hi, x: min(max(lo, x), hi)}


def cast(t, v):
    if t == "INT": return math.floor(v + 0.5)        # from half up: as known (PGA, type conversion)
    if t == "BOOL": return bool(v)
    return float(v)


def ws(s, i):
    while i < len(s) and s[i] in " \t\r": i += 1
    return i


def run(files, main, options):
    return Run(files, main, options).go()


PLAIN = os.environ.get("ORC_PLAIN")          # without what the reader of 28 November refuses
# ==== programs at random ================================================================================
class Pen:
    """A contour in a plane, with the letters of its axes."""
    LET = {17: ("X", "Y", "Z", "I", "J"), 18: ("Z", "X", "Y", "K", "I"), 19: ("Y", "Z", "X", "J", "K")}

    def __init__(self, g, plane, x, y):
        self.g, self.r, self.x, self.y = g, g.r, x, y
        self.A, self.B, self.C, self.I, self.J = self.LET[plane]
        self.plane, self.mode, self.t, self.lim = plane, None, None, 120
        self.inc = False
        self.pole = None

    def m(self, w):
        if self.mode == w and self.r.random() < 0.4: return ""
        self.mode = w
        return w

    def end(self, x, y):
        r, n = self.r, self.g.n
        q = r.random()
        def one(L, new, old, must):
            if not must and new == old: return ""
            if self.inc: return f"{L}=AC({n(new)})" if q < 0.1 else L + n(round(new - old, 6))
            if q < 0.12: return f"{L}=IC({n(round(new - old, 6))})"
            return L + n(new)
        return (one(self.A, x, self.x, r.random() < 0.5) + " " + one(self.B, y, self.y, r.random() < 0.5)).strip() or self.A + n(0 if self.inc else x)

    def line(self, x=None, y=None, tail=""):
        r = self.r
        if x is None:
            for _ in range(50):
                x, y = self.g.c(self.lim), self.g.c(self.lim)
                if r.random() < 0.2: x = self.x
                elif r.random() < 0.2: y = self.y
                if math.hypot(x-self.x, y-self.y) > 20: break
        s = f"{self.m('G1')} {self.end(x, y)}{tail}"
        self.t = (x-self.x, y-self.y)
        self.x, self.y = x, y
        return s.strip()

    def arc(self, tail="", third=None):
        """Exact by a quarter, half or three quarters of a turn, or an end rounded as posts do."""
        r, n = self.r, self.g.n
        for _ in range(200):
            i, j = r.choice([(5, 0), (0, 8), (-12, 0), (6, 8), (-3, 4), (10, -10), (7.5, -2.5), (0, -20), (r.randint(-25, 25), r.randint(-25, 25))])
            if math.hypot(i, j) < 3: continue
            sense = r.choice([1, -1])
            q = r.choice([1, 1, 2, 3])
            dx, dy = -i, -j
            for _ in range(q): dx, dy = (-dy, dx) if sense > 0 else (dy, -dx)
            x, y = self.x + i + dx, self.y + j + dy
            odd = r.random() < 0.25
            if odd:
                w = r.uniform(0.5, 5.5) * sense
                dx, dy = -i*math.cos(w) + j*math.sin(w), -i*math.sin(w) - j*math.cos(w)
                x, y = round(self.x + i + dx, 3), round(self.y + j + dy, 3)
                deg = abs(math.degrees(w))
            else: deg = 90*q
            if abs(x) < self.lim + 20 and abs(y) < self.lim + 20: break
        x, y = round(x, 6), round(y, 6)
        R, G = math.hypot(i, j), "G3" if sense > 0 else "G2"
        how = r.choice(["ij", "ac", "cr", "full"] if PLAIN else ["ij", "ij", "ac", "cr", "cr", "ar", "cip", "full"])
        E = self.end(x, y)
        T = f" {self.C}{n(third)}" if third is not None else ""
        if how == "full" and not tail:
            self.t = None
            return f"{self.m(G)} {self.I}{n(i)} {self.J}{n(j)}{T}".strip()
        if how == "cip" and not odd:
            h = math.radians(deg)/2*sense
            mx, my = -i*math.cos(h) + j*math.sin(h), -i*math.sin(h) - j*math.cos(h)
            mx, my = self.x + i + mx, self.y + j + my
            k = {"X": "I1", "Y": "J1", "Z": "K1"}
            if self.inc: mx, my = mx - self.x, my - self.y
            s = f"{self.m('CIP')} {E} {k[self.A]}={n(round(mx, 6))} {k[self.B]}={n(round(my, 6))}"
        elif how == "cr" and R == int(R) and (abs(math.hypot(x-self.x, y-self.y) - 2*R) > 1e-9 or q == 2):
            s = f"{self.m(G)} {E} CR={n(R if deg <= 180 else -R)}"
        elif how == "ar" and not odd and q != 2:
            s = f"{self.m(G)} {E} AR={n(deg)}" if r.random() < 0.5 else f"{self.m(G)} {self.I}{n(i)} {self.J}{n(j)} AR={n(deg)}"
            if "AR" in s and self.I + n(i) in s and f"{self.I}{n(i)} " in s: tail = tail
        elif how == "ac":
            s = f"{self.m(G)} {E} {self.I}=AC({n(round(self.x+i, 6))}) {self.J}=AC({n(round(self.y+j, 6))})"
        else:
            s = f"{self.m(G)} {E} {self.I}{n(i)} {self.J}{n(j)}"
            if r.random() < 0.2: s = s.replace(f" {self.I}{n(0)}", "") if not i else s.replace(f" {self.J}0", "") if not j else s
        self.x, self.y, self.t = x, y, None
        return (s + T + tail).strip()

    def ct(self):
        x, y = self.g.c(self.lim), self.g.c(self.lim)
        s = f"{self.m('CT')} {self.end(x, y)}"
        self.x, self.y, self.t = x, y, None
        return s

    def polar(self):
        """Lines and arcs about a pole; leaves with a Cartesian line."""
        r, n = self.r, self.g.n
        out = []
        px, py = self.g.c(40), self.g.c(40)
        k = r.random()
        if k < 0.6: out.append(f"G111 {self.A}{n(px)} {self.B}{n(py)}")
        elif k < 0.8 or not self.pole: out.append(f"G110 {self.A}{n(round(px-self.x, 6))} {self.B}{n(round(py-self.y, 6))}")
        else: out.append(f"G112 {self.A}{n(round(px-self.pole[0], 6))} {self.B}{n(round(py-self.pole[1], 6))}")
        self.pole = (px, py)
        R, w = r.choice([20, 25.5, 40, 33.3]), r.choice([0, 30, 45, -60, 120, 200, 270])
        out.append(f"{self.m('G1')} RP={n(R)} AP={n(w)}".strip())
        for _ in range(r.randint(1, 4)):
            d = r.choice([30, 60, -45, 90, 72])
            w2 = w + d
            k = r.random()
            if k < 0.5:
                G = r.choice(["G2", "G3"])
                out.append(f"{self.m(G)} AP={n(w2)} RP={n(R)}".strip())
            elif k < 0.7: out.append(f"{self.m('G1')} AP=IC({n(d)})".strip())
            elif k < 0.85:
                R = r.choice([20, 25.5, 40, 33.3])
                out.append(f"{self.m('G1')} AP={n(w2)} RP={n(R)}".strip())
            else: out.append(f"{self.m('G1')} AP={n(w2)}".strip())
            w = w2
        self.x = self.y = None
        x, y = self.g.c(self.lim), self.g.c(self.lim)
        self.mode = "G1"
        out.append(f"G1 {self.A}=AC({n(x)}) {self.B}=AC({n(y)})" if self.inc else f"G1 {self.A}{n(x)} {self.B}{n(y)}")
        self.x, self.y, self.t = x, y, None
        return out

    def contour(self, k, corners=True):
        r, n, out = self.r, self.g.n, []
        out.append(self.line())
        while k > 0:
            k -= 1
            q = r.random()
            if PLAIN: q *= 0.6
            if q < 0.35: out.append(self.line())
            elif q < 0.62: out.append(self.arc())
            elif q < 0.72: out.append(self.ct())
            elif q < 0.9 and corners:
                w = r.choice(["RND", "RND", "CHR", "CHF"])
                tail = f" {w}={n(r.choice([1, 1.5, 2, 3, 4.5]))}"
                out.append(self.line(tail=tail))
                if w == "RND" and r.random() < 0.4: out.append(self.arc())
                else: out.append(self.line())
                k -= 1
            elif corners and r.random() < 0.5:
                out.append(self.arc(tail=f" RND={n(r.choice([1, 2]))}"))
                out.append(self.line())
            elif not self.inc: out += self.polar()
        out.append(self.line())
        return out


class Gen:
    def __init__(self, r):
        self.r, self.files, self.opt = r, {}, {"gcode": {"unit": "mm"}}
        self.lab, self.rp, self.vars, self.defs = 0, 1, 0, []
        self.eq = False
        self.tail, self.g55 = [], None

    def n(self, v):
        r = self.r
        v = round(float(v), 6) + 0.0
        s = f"{v:.6f}".rstrip("0").rstrip(".")
        if s == "-0": s = "0"
        q = r.random()
        if "." not in s and q < 0.12: s += "."
        elif "." not in s and q < 0.16: s += ".000"
        elif s.startswith("0.") and q < 0.3: s = s[1:]
        return s

    def c(self, lim):
        r = self.r
        return round(r.uniform(-lim, lim), r.choice([0, 0, 1, 2, 3]))

    def R(self): self.rp += 1; return f"R{self.rp}"
    def label(self): self.lab += 1; return self.r.choice(["MARKE", "LAB_", "ANF", "NEXT_"]) + str(self.lab)
    def F(self): return "F" + self.n(self.r.choice([100, 200, 350, 500.5, 800, 1200]))

    def start(self, plane=17, lim=100):
        """Rapid to a place, down by feed; gives the pen."""
        r, n = self.r, self.n
        x, y = self.c(lim), self.c(lim)
        P = Pen(self, plane, x, y)
        z = r.choice([-1, -2, -3.5, -0.5, 0, 2])
        out = [f"G0 {P.A}{n(x)} {P.B}{n(y)}"]
        if plane == 17 and r.random() < 0.5: out.append(f"G0 {P.C}{n(r.choice([5, 2, 8]))}" if r.random() < 0.5 else f"{P.C}{n(5)}")
        out.append(f"G1 {P.C}{n(z)} {self.F()}")
        P.mode = "G1"
        return P, out

    def up(self, P):
        k = self.r.random()
        if P.C == "Z": return ["G0 Z" + self.n(50)] if k < 0.8 else ["G0 G90 Z=" + self.n(50)]
        return [f"G0 {P.C}{self.n(40)}", "G0 Z" + self.n(60)]

    # each feature begins above the part in G90 and leaves so
    def f_contour(self):
        P, o = self.start()
        if self.r.random() < 0.25:
            o.append("G91"); P.inc = True
            o += P.contour(self.r.randint(2, 5))
            return o + ["G90"] + self.up(P)
        return o + P.contour(self.r.randint(3, 8)) + self.up(P)

    def f_polar(self):
        P, o = self.start()
        o += P.polar()
        if self.r.random() < 0.5: o += P.polar()
        return o + self.up(P)

    def f_polar_drill(self):
        r, n = self.r, self.n
        x, y = self.c(40), self.c(40)
        o = [f"G111 X{n(x)} Y{n(y)}"]
        for k in range(r.randint(2, 4)):
            o += [f"G0 AP={n(r.randint(0, 350))} RP={n(r.choice([20, 30, 42.5]))}", f"G1 Z{n(-r.randint(1, 9))} {self.F()}", "G0 Z" + n(r.choice([5, 10]))]
        return o + ["G0 Z50"]

    def f_helix(self):
        r, n = self.r, self.n
        x, y = self.c(60), self.c(60)
        R, G, t = r.choice([4, 10, 12.5]), r.choice(["G2", "G3"]), r.choice([0, 1, 2, 5])
        z = -r.randint(2, 12)
        o = [f"G0 X{n(x+R)} Y{n(y)}", f"G1 Z{n(1)} {self.F()}"]
        k = r.random()
        T = f" TURN={n(t) if r.random() < .5 else ' ' + str(t)}" if t else ""
        if k < 0.35: o.append(f"{G} X{n(x+R)} Y{n(y)} Z{n(z)} I{n(-R)} J0{T}")
        elif k < 0.6: o.append(f"{G} Z{n(z)} I=AC({n(x)}) J=AC({n(y)}){T}")
        elif k < 0.8: o.append(f"{G} X{n(x)} Y{n(y+R)} Z{n(z)} CR={n(R if G == 'G3' else -R)}{T}")
        else: o += [f"G111 X{n(x)} Y{n(y)}", f"{G} AP={n(r.choice([90, 180, 225]))} RP={n(R)} Z{n(z)}{T}"]
        if r.random() < 0.5: o.append(f"G1 X{n(x)} Y{n(y)}")
        return o + ["G0 Z50"]

    def f_plane(self):
        r = self.r
        p = r.choice([18, 19])
        P, o = self.start(p, 60)
        P.lim = 60
        o = [f"G{p}"] + o + P.contour(r.randint(2, 5)) + self.up(P) + ["G17"]
        return o

    def f_inch(self):
        r, n = self.r, self.n
        g = r.choice(["G70", "G700"])
        x, y = round(r.uniform(-3, 3), 3), round(r.uniform(-3, 3), 3)
        o = [g, f"G0 X{n(x)} Y{n(y)}", f"G1 Z{n(-.1)} F{n(12.5 if g == 'G700' else 300)}", f"X{n(x+1.25)} RND={n(.125)}", f"Y{n(y+1)}",
             f"G3 X{n(x+.75)} Y{n(y+1.5)} CR={n(.5)}", f"G2 X{n(x+.25)} I{n(-.25)} J0", f"G1 X{n(x)} Y{n(y)}", f"G0 Z{n(2)}"]
        return o + ["G710" if g == "G700" else "G71"] + (["F300"] if r.random() < .3 else [])

    def f_loop(self):
        r, n = self.r, self.n
        kind = r.choice(["FOR", "WHILE", "LOOP", "UNTIL"])
        R1, R2 = self.R(), self.R()
        x, y, st = self.c(60), self.c(60), r.choice([1, 0.5, 1.5, 2])
        N = r.randint(2, 4)
        body = [f"G1 Z=-{R1}*{n(st)} {self.F()}", f"X{n(x+30)}", f"Y=IC({n(20)})" if r.random() < .5 else f"G1 Y{n(y+20)}", f"G1 X{n(x)} Y{n(y)}"]
        if r.random() < 0.4: body[2:3] = [f"G3 X{n(x+30)} Y{n(y+20)} CR={n(10)}"]
        if r.random() < 0.3:      # steps across
            body = [f"G0 X={n(x)}+{R1}*{n(7.5)} Y{n(y)}", f"G1 Z-2 {self.F()}", f"Y={n(y+15)}+SIN({R1}*30)*3", "G0 Z3"]
        o = [f"G0 X{n(x)} Y{n(y)}", "Z3"]
        if kind == "FOR":
            if r.random() < 0.5:
                v = f"ZAEHLER{len(self.defs)}"; self.defs.append(f"DEF INT {v}")
                body = [b.replace(R1, v) for b in body]
                o += [f"FOR {v}=1 TO {N}"] + body + ["ENDFOR"]
            else: o += [f"FOR {R1}=1 TO {N}"] + body + ["ENDFOR"]
        elif kind == "WHILE": o += [f"{R1}=0", f"WHILE {R1}<{N}", f"{R1}={R1}+1"] + body + ["ENDWHILE"]
        elif kind == "LOOP":
            L = self.label()
            o += [f"{R1}=1", "LOOP"] + body + [f"{R1}={R1}+1", f"IF {R1}>{N} GOTOF {L}", "ENDLOOP", f"{L}:"]
        else: o += [f"{R1}=0", "REPEAT", f"{R1}={R1}+1"] + body + [f"UNTIL ({R1}>={N})"]
        return o + ["G0 Z50"]

    def f_sub(self):
        r, n = self.r, self.n
        name = r.choice([f"L{r.randint(1, 900)}", r.choice(["TASCHE", "NUT_A", "KONTUR", "SUB"]) + str(len(self.files) + 1)])
        if name + ".SPF" in self.files: return []
        inc = r.random() < 0.6
        if inc:
            P = Pen(self, 17, 0, 0); P.inc = True; P.lim = 35
            body = ["G91 G1 Z-0.5 " + self.F()]
            P.mode = "G1"
            body += P.contour(r.randint(1, 3), corners=r.random() < .5)
            body += [P.line(0, 0).replace("=AC(", "=AC("), "G90"] if False else [f"G1 X{n(-P.x)} Y{n(-P.y)}", "G90"]
            body = [b for b in body if "AC(" not in b] if all("AC(" not in b for b in body) else None
            if body is None: return self.f_sub()
        else:
            P, body = self.start(); body = body + P.contour(r.randint(1, 3)) + ["G0 Z5"]
        self.files[name + ".SPF"] = ([f"PROC {name}"] if name[0] != "L" and r.random() < .3 else []) + body + [r.choice(["M17", "RET", "M17"])]
        o = [f"G0 X{n(self.c(80))} Y{n(self.c(80))}", "G1 Z0 " + self.F()] if inc else []
        call = name
        if inc or r.random() < 0.3:
            k = r.choice([0, 2, 3])
            if k: call += r.choice([f" P{k}", f" P={k}", f" P{k} "])
        o.append(call)
        if r.random() < 0.4:
            o += ["G0 Z20", f"X{n(self.c(80))} Y{n(self.c(80))}"] + (["G1 Z0 " + self.F()] if inc else []) + [call.strip()]
        return o + ["G0 Z50"]

    def f_proc(self):
        r, n = self.r, self.n
        name = "BOHR" + str(len(self.files) + 1)
        self.files[name + ".SPF"] = [f"PROC {name}(REAL XP, REAL YP, REAL TIEFE)" + r.choice(["", " SAVE", " DISPLOF"]), "DEF REAL H=3",
                                     "G0 X=XP Y=YP", "G0 Z=H", f"G1 Z=-TIEFE {self.F()}", "G91 G1 X5 Y=TIEFE" if r.random() < .5 else "G1 X=XP+5",
                                     "G90 G0 Z=H+10", r.choice(["M17", "RET"])]
        o = []
        if r.random() < .4: self.defs.append(f"EXTERN {name}(REAL, REAL, REAL)")
        a = self.R()
        o.append(f"{a}={n(self.c(50))}")
        for k in range(r.randint(1, 3)): o.append(f"{name}({a}+{k}*12.5, {n(self.c(50))}, {n(r.choice([1, 2.5]))})")
        return o + ["G0 Z50"]

    def f_frame(self):
        r, n = self.r, self.n
        o = []
        k = r.choice(["T", "TA", "TR", "R", "RT", "P"])
        if k[0] == "T": o.append(f"TRANS X{n(self.c(60))} Y{n(self.c(60))}" + (f" Z{n(r.choice([1, -2, 5]))}" if r.random() < .4 else ""))
        if k == "TA": o.append(f"ATRANS X{n(self.c(20))}" + (f" Y{n(self.c(20))}" if r.random() < .5 else ""))
        if k == "TR": o.append(f"AROT Z{n(r.choice([30, 90, -45, 12.5]))}" if r.random() < .6 else f"AROT RPL={n(r.choice([30, 90, 45]))}")
        if k[0] == "R": o.append(f"ROT RPL={n(r.choice([15, 90, -30]))}" if r.random() < .5 else f"ROT Z{n(r.choice([15, 90, 180, -30.5]))}")
        if k == "RT": o.append(f"ATRANS X{n(self.c(40))} Y{n(self.c(40))}")
        if k == "P":
            a = r.choice([3, 4, 6]); R = self.R(); L = self.label()
            P, b = self.start(); P.lim = 50
            b = b + P.contour(1) + ["G0 Z50"]
            return [f"{R}=0", f"{L}:"] + b + [f"AROT Z{n(360/a)}", f"{R}={R}+1", f"IF {R}<{min(a, 3)} GOTOB {L}", r.choice(["ROT", "TRANS"])]
        P, b = self.start(); P.lim = 70
        return o + b + P.contour(r.randint(2, 5)) + ["G0 Z50"] + [r.choice(["TRANS", "ROT"])]

    def f_space(self):
        r, n = self.r, self.n
        o = [f"TRANS X{n(self.c(30))} Y{n(self.c(30))} Z{n(r.choice([-5, 0, 5]))}",
             "AROT " + r.choice([f"X{n(r.choice([10, -15, 90]))}", f"Y{n(r.choice([10, 30, -5]))}", f"X{n(10)} Y{n(-20)}", f"X{n(5)} Y{n(10)} Z{n(30)}", f"Z{n(45)} X{n(12)}"])]
        P = Pen(self, 17, self.c(40), self.c(40)); P.lim = 50
        o += [f"G0 X{n(P.x)} Y{n(P.y)} Z{n(30)}", f"G1 Z{n(-1)} {self.F()}"]
        P.mode = "G1"
        return o + P.contour(r.randint(2, 4)) + ["G0 Z40", r.choice(["TRANS", "ROT"]), f"G0 X{n(self.c(60))} Y{n(self.c(60))} Z60"]

    def cycle(self):
        r, n = self.r, self.n
        k = r.choice([81, 81, 82, 83, 83, 84])
        rtp, rfp, sd, dp = r.choice([10, 20, 5.5]), r.choice([0, 0, 1]), r.choice([1, 2, 2.5]), r.choice([10, 12, 20, 30])
        dep = f"{n(rfp-dp)}," if r.random() < .6 else f",{n(dp)}"
        h = f"({n(rtp)},{r.choice(['', ' '])}{n(rfp)},{n(sd)},{dep}"
        if k == 81: return f"CYCLE81{h})" if r.random() < .5 or dep[0] == "," else f"CYCLE81{h[:-1]})"
        if k == 82: return f"CYCLE82{h},{n(r.choice([0, .5, 1]))})"
        if k == 83:
            f = r.choice([dp/2, dp/4, dp/5])
            fd = f"{n(rfp-f)}," if r.random() < .5 else f",{n(f)}"
            x = r.choice(["", "", ",,,,,,0.4" if False else ""])
            return f"CYCLE83{h},{fd},0,{n(r.choice([0, .2]))},{n(r.choice([0, .1]))},{n(r.choice([1, .8]))},{r.choice([0, 1])})"
        return f"CYCLE84{h},{n(.5)},{r.choice([3, 5])},,{n(r.choice([1, 1.25, -1.5]))},{n(0)},{n(r.choice([200, 400]))},{n(r.choice([200, 500]))})"

    def f_drill(self):
        r, n = self.r, self.n
        o = ["G0 Z30", self.F()]
        for _ in range(r.randint(1, 3)):
            o += [f"G0 X{n(self.c(80))} Y{n(self.c(80))}", self.cycle()]
        return o + ["G0 Z50"]

    def f_mcall(self):
        r, n = self.r, self.n
        c = self.cycle()
        o = [f"G0 X{n(self.c(80))} Y{n(self.c(80))} Z30", self.F(), "MCALL " + c]
        k = r.random()
        x, y = self.c(50), self.c(50)
        if k < 0.5:
            for _ in range(r.randint(2, 4)): o.append(r.choice([f"X{n(self.c(80))} Y{n(self.c(80))}", f"G0 X{n(self.c(80))}", f"Y{n(self.c(80))}", f"X=IC({n(r.choice([10, -15]))})"]))
        elif k < 0.75:
            w, d, N = r.choice([0, 30, 90, -45]), r.choice([10, 12.5]), r.randint(2, 5)
            o[0] = f"G0 X{n(x)} Y{n(y)} Z30"
            o.append(f"HOLES1({n(x)},{n(y)},{n(w)},{n(r.choice([0, 5]))},{n(d)},{N})")
        else:
            N = r.choice([3, 4, 6])
            o.append(f"HOLES2({n(x)},{n(y)},{n(r.choice([15, 20.5, 30]))},{n(r.choice([0, 30, -45]))},{n(r.choice([0, 30, 45]))},{N})")
        return o + ["MCALL", "G0 Z50"]

    def f_repeat(self):
        r, n = self.r, self.n
        A, B = self.label(), self.label()
        k = r.choice(["one", "two", "b", "end"])
        x, y = self.c(50), self.c(50)
        o = [f"G0 X{n(x)} Y{n(y)} Z3", f"G1 Z1 {self.F()}"]
        body = ["G91 G1 Z-1", f"X{n(20)}", f"Y{n(10)}", f"X{n(-20)} Y{n(-10)}"]
        if r.random() < .4: body[2] = f"G3 X{n(0)} Y{n(10)} CR={n(5)}"; body[3] = "G1 " + body[3]
        if k == "one": o += [f"{A}: {body[0]}"] + body[1:] + ["G90", f"REPEAT {A} P={r.randint(1, 3)}"]
        elif k == "two": o += [f"{A}: {body[0]}"] + body[1:] + [f"{B}: G90", "G0 Z5", f"G1 Z1 {self.F()}", f"REPEAT {A} {B} P={r.randint(1, 3)}"]
        elif k == "end": o += [f"{A}: {body[0]}"] + body[1:] + ["G90", "ENDLABEL:", "G0 Z5", f"G0 X{n(self.c(60))} Y{n(self.c(60))}", f"G1 Z1 {self.F()}", f"REPEAT {A} P={r.randint(1, 2)}"]
        else: o += [f"{A}: G1 X=IC({n(5)}) Y=IC({n(3)})", f"REPEATB {A} P={r.randint(2, 4)}"]
        return o + ["G0 Z50"]

    def f_goto(self):
        r, n = self.r, self.n
        a, L, M = self.R(), self.label(), self.label()
        P, o = self.start()
        k = r.random()
        if k < .35:
            return [f"{a}={r.randint(0, 3)}"] + o + [f"IF {a}>1 GOTOF {L}", P.line(), f"GOTOF {M}", f"{L}: G1 X{n(self.c(80))} Y{n(self.c(80))}", f"{M}:", f"G1 X{n(self.c(80))} Y{n(self.c(80))}", "G0 Z50"]
        if k < .7:
            x, y = self.c(80), self.c(80)
            return [f"{a}={r.randint(0, 3)}"] + o + [f"IF ({a}==1) OR ({a}>2)", f"G1 X{n(x)}", "ELSE", f"G1 Y{n(y)}", f"G2 X=IC(10) Y=IC(10) CR={n(10)}", "ENDIF", f"G1 X{n(self.c(80))} Y{n(self.c(80))}", "G0 Z50"]
        return [f"{a}={r.randint(1, 3)}"] + o + [f"CASE {a} OF 1 GOTOF {L}A 2 GOTOF {L}B DEFAULT GOTOF {M}", f"{L}A: G1 X{n(self.c(80))}", f"GOTOF {M}", f"{L}B: G1 Y{n(self.c(80))}", f"{M}: G1 X{n(self.c(60))} Y{n(self.c(60))}", "G0 Z50"]

    def f_supa(self):
        n = self.n
        a = self.r.choice(["SUPA G0 Z0", "G0 SUPA Z0 D0", "G53 G0 Z0", "G0 G53 Z0", "G153 G0 Z-1"])
        return [a, f"G0 X{n(self.c(60))} Y{n(self.c(60))}" + (" D1" if "D0" in a else ""), "G0 Z50"]

    def f_g55(self):
        r, n = self.r, self.n
        if self.g55 is None:
            self.g55 = r.choice([55, 56, 57])
            self.opt["gcode"][f"g{self.g55}_mm"] = [float(r.randint(-40, 40)), float(r.randint(-40, 40)), float(r.choice([0, 5, -3]))]
        P, o = self.start(); P.lim = 60
        return [f"G{self.g55}"] + [f"G0 X{n(P.x)} Y{n(P.y)} Z40"] + o + P.contour(2) + ["G0 Z50", "G54", f"G0 X{n(self.c(50))} Y{n(self.c(50))} Z50"]

    def f_expr(self):
        r, n = self.r, self.n
        a, b, c = self.R(), self.R(), self.R()
        o = [f"{a}={n(self.c(40))} {b}={n(r.choice([10, 20, 15]))}", f"{c}=ABS({a})/2+POT({b})/{n(20)}-TRUNC({n(3.7)})*(2+1)"]
        if r.random() < .5: self.defs.append(f"DEF REAL BREITE{len(self.defs)}={n(12.5)}, HOEHE{len(self.defs)}"); v = self.defs[-1].split()[2].split("=")[0]
        else: v = b
        P, q = self.start()
        o += q + [f"G1 X={a}+{c} Y=-{b}", f"X=IC({v}) RND={n(2)}", f"Y={a}*0.5-{v}*COS(60)", f"G1 X=SQRT({b}*{b}+9)+ATAN2(1,1)" if r.random() < .6 else f"G1 X={a} DIV 3", f"G3 X=IC(2*{b}) Y=IC(0) I={b} J=0", f"G1 F=300+{b} X={a}"]
        return o + ["G0 Z50"]

    def f_cip(self):
        r, n = self.r, self.n
        P, o = self.start()
        o.append(f"CIP X{n(P.x+20)} Y{n(P.y+20)} Z{n(r.choice([1, 0, -4]))} I1={n(P.x+15)} J1={n(P.y+2)} K1={n(r.choice([3, 2, -2]))}")
        o.append(f"G1 X{n(self.c(80))} Y{n(self.c(80))}")
        return o + ["G0 Z50"]

    def f_skip(self):
        r, n = self.r, self.n
        if r.random() < .5: self.opt["gcode"]["block_delete"] = r.choice(["skip", "run"])
        P, o = self.start()
        return o + ["/" + P.line(), P.line(), "G0 Z50"]

    def f_misc(self):
        r, n = self.r, self.n
        o = [r.choice(["G4 F2", "G4 F1.5", "M8", "M9", "G64", "G642 ADIS=0.02" if False else "G60", "MSG(\"Bearbeitung; Seite 1\")", "MSG()", "STOPRE", "; X10 Y20 kein Satz",
                          "T2 D1", "T=\"FRAESER_D10\"", "M6", "S3000 M3", "M5", "FFWON SOFT", "CYCLE832(0.01,1,1)", "CYCLE800()", "G40", "D1", "M1", "WORKPIECE(,,,\"BOX\",112,0,-20,-80,0,0,100,100)"])]
        if o[0][0] == "T" or o[0] == "M6": o.append(f"G0 X{n(self.c(60))} Y{n(self.c(60))} Z{n(50)}")
        return o

    def taps(self):
        """CYCLE84, CYCLE840 with the parameters of PGZ 2.1.6, 2.1.7."""
        r, n = self.r, self.n
        rtp, rfp, dp, k = r.choice([10, 20, 5.5]), r.choice([0, 0, 1, -2]), r.choice([10, 12, 20, 7.5]), r.choice([84, 84, 840])
        sd = r.choice(["", n(1), n(2.5), n(3)])
        dep = r.choice([n(rfp-dp) + ",", n(rfp-dp) + ",", "," + n(dp), n(rfp-dp-1) + "," + n(dp)])
        b = r.choice(["", "", " "])
        h = f"CYCLE{k}({b}{n(rtp)},{b}{n(rfp)},{sd},{dep},{r.choice(['', n(.5)])}"
        pit = r.choice([n(6) + ",", "," + n(1.25), "," + n(-1.5), "," + n(.8)])
        if k == 84: return h + f",{r.choice([3, 4, 5, ''])},{pit},{r.choice(['', '0', '90'])},{n(r.choice([200, 400]))}{r.choice(['', ',' + n(500), ',' + n(300) + ',3'])}{b})"
        return h + f",{r.choice([0, 4])},{r.choice([3, 4])},{r.choice([0, 1])},{pit}{b})"

    def f_tap(self):
        r, n, c = self.r, self.n, self.c
        x, y, pre, post, lim = c(60), c(60), [], [], 50
        k = r.random()
        if k < .12: pre, post = [f"TRANS X{n(c(30))} Y{n(c(30))} Z{n(r.choice([0, 3]))}"], ["TRANS"]
        elif k < .2: pre, post = [f"ROT Z{n(r.choice([30, 90, -45]))}"], ["ROT"]
        elif k < .25: pre, post = [f"TRANS X{n(c(30))} Y{n(c(30))}", f"AROT X{n(10)}", f"G0 X{n(x)} Y{n(y)}"], ["TRANS", f"G0 X{n(x)} Y{n(y)}"]
        o = pre + [f"G0 X{n(x)} Y{n(y)} Z30", f"G1 X{n(x+5)} {self.F()}"]
        # the motion in force before: its first word without G behind the cycle goes by it
        k = r.random()
        if k < .3: o.append(f"G0 X{n(c(lim))} Y{n(c(lim))}")
        elif k < .4: o.append(f"G2 X{n(x+15)} Y{n(y)} CR={n(5)}")
        G91 = r.random() < .2
        step = lambda: r.choice([f"X{n(r.choice([10, -15]))}", f"Y{n(12.5)}", f"X{n(8)} Y{n(-6)}"]) if G91 else r.choice([f"X{n(c(lim))} Y{n(c(lim))}", f"X{n(c(lim))}", f"Y=IC({n(11)})"])
        if G91: o.append("G91")
        go = ["G0 "] if k < .3 or r.random() < .5 else ["G1 "]
        q = r.random()
        if q < .35:
            for _ in range(r.randint(1, 3)): o += [r.choice(go + [""] * (k < .3 or k >= .4)) + step(), self.taps()]
            if k < .3 or k >= .4: o.append(step())
        elif q < .7:
            o.append("MCALL " + self.taps())
            for _ in range(r.randint(1, 4)): o.append((go[0] if _ == 0 or r.random() < .3 else "") + step())
            if r.random() < .2: o.insert(-1, r.choice(["M8", "S300 M3", "F150", "; Kommentar"]))
            o.append("MCALL")
            if r.random() < .5: o.append(step())
        else:
            if G91: o.append("G90"); G91 = False
            x, y, w, N = c(50), c(50), r.choice([0, 30, 90, -45]), r.randint(2, 5)
            o += [f"G0 X{n(x)} Y{n(y)}", "MCALL " + self.taps(), f"HOLES1({n(x)},{n(y)},{n(w)},{n(r.choice([0, 5]))},{n(10)},{N})" if r.random() < .5 else
                  f"HOLES2({n(x)},{n(y)},{n(20.5)},{n(r.choice([0, 30, -45]))},{n(r.choice([0, 30, 45]))},{N})", "MCALL"]
            if r.random() < .5: o.append(step())
        if r.random() < .15 and q < .35: a = self.R(); o = o[:len(pre)] + [f"FOR {a}=1 TO 2"] + o[len(pre):] + ["G90", "G0 Z50", "ENDFOR"]
        return o + ["G90"] * G91 + ["G0 Z50"] + post + [f"G0 X{n(c(60))} Y{n(c(60))} Z60"]


WEIGHTS = [("contour", 5), ("polar", 2), ("polar_drill", 1), ("helix", 2), ("plane", 2), ("inch", 1), ("loop", 3), ("sub", 3), ("proc", 1), ("frame", 3),
           ("space", 2), ("drill", 2), ("mcall", 3), ("repeat", 2), ("goto", 2), ("supa", 1), ("g55", 1), ("expr", 2), ("cip", 1), ("skip", 1), ("misc", 4)]


def attempt(seed, k):
    r = random.Random(f"sinumerik {seed} {k}")
    g = Gen(r)
    o = []
    want = r.randint(20, 60)
    only = os.environ.get("ORC_ONLY")
    if PLAIN and not only: only = "contour,plane,supa,g55,skip"
    pick = [f for f, w in WEIGHTS for _ in range(w) if not only or f in only.split(",")]
    body = []
    while pick and len(body) < want - 8:
        body += getattr(g, "f_" + r.choice(pick))()
    # tapping has a stream of its own: the programs of most seeds stay as they were
    g.r = random.Random(f"sinumerik tap {seed} {k}")
    if g.r.random() < .3 and not only and not PLAIN or "tap" in (only or "").split(","):
        for _ in range(g.r.randint(1, 2)): body += g.f_tap()
    g.r = r
    head = []
    if r.random() < .2: head += ["%_N_TEIL_MPF", ";$PATH=/_N_WKS_DIR/_N_TEIL_WPD"]
    elif r.random() < .3: head += ["; " + r.choice(["Programm von CAM", "TOOL D10 Z4", "(c) post 840D"])]
    head += g.defs
    if r.random() < .5: head.append("T1 D1 M6" if r.random() < .5 else "T=\"MILL_10\" D1")
    unit = r.choice(["G71", "G710", ""])
    head.append(r.choice([f"G17 G90 {unit} G94 G54", f"G54 G17 G90 {unit} G40 G64", f"G90 G17 {unit}"]).replace("  ", " ").strip())
    if r.random() < .5: head.append("S2500 M3")
    head.append(f"G0 X{g.n(g.c(60))} Y{g.n(g.c(60))} Z{g.n(50)}")
    lines = head + body + (["M5"] if r.random() < .4 else []) + [r.choice(["M30", "M30", "M2", "M02"])]
    out, num = [], r.random() < .6
    lower, tight = r.random() < .12, r.random() < .08
    two = r.random() < .2           # G00 G01
    eol = "\r\n" if r.random() < .2 else "\n"
    def dress(ls):
        res, k, step = [], 10, r.choice([1, 5, 10])
        for s in ls:
            if two: s = re.sub(r'\bG([0123])\b', r'G0\1', s)
            if r.random() < .05 and not s.startswith(("%", ";", "DEF", "PROC", "EXTERN", "MSG")): s += r.choice([" ; Kommentar", ";F100 X0", "   "])
            if num and not s.startswith(("%", ";", "/", "PROC")): s = f"N{k} {s}"; k += step
            elif num and s.startswith("/"): s = f"/N{k} {s[1:]}"; k += step
            if lower and '"' not in s: s = s.lower()
            if tight and re.fullmatch(r'(N\d+ )?G\d[ XYZFIJ0-9.\-]*', s): s = s.replace(" ", "")
            res.append(s)
        return (eol.join(res) + eol).encode("latin-1")
    name = r.choice(["TEIL.MPF", "MAIN.MPF", "P100.MPF", "WST_1.MPF"])
    files = {name: dress(lines)}
    for f, ls in g.files.items(): files[f] = dress(ls)
    return files, name, g.opt


def generate(seed):
    for k in range(400):
        try:
            files, name, opt = attempt(seed, k)
            moves = run(files, name, opt)
        except Refused: continue
        if len(moves) < 8 or len(moves) > 400 or any(abs(x) > 300 for m in moves for x in m.end): continue
        last = None
        ok = True
        for m in moves:
            if m.kind == "arc":
                p = add(m.end, m.centre, -1.0)
                t = norm(m.turn)
                kx = mul(m.turn, 1/t)
                rr = norm(add(p, kx, -dot(p, kx)))
                if rr < 1 or rr > 400 or any(abs(x) > 300 + 1e-9 for x in m.centre if rr < 150) : ok = False
                if t < 0.01: ok = False
            last = m.end
        if ok: return files, name, opt
    raise RuntimeError(f"seed {seed}: no program")


# ==== self-test =========================================================================================
def ends(text, opt=None, **more):
    files = {"A.MPF": text.encode()}
    files.update({k + ".SPF": v.encode() for k, v in more.items()})
    return run(files, "A.MPF", opt or {})


def near(a, b): return all(abs(x - y) < 1e-9 for x, y in zip(a, b))


def examples():
    H = "G17 G90 G71 G54\nG0 X0 Y0 Z10\nG1 Z0 F100\n"
    s2 = math.sqrt(0.5)
    def t(text, *want, opt=None, **more):
        got = [(m.kind[0], m.end) for m in ends(text, opt, **more)]
        if text.startswith(H): got = got[2:]
        ok = len(got) == len(want) and all(g[0] == w[0] and near(g[1], w[1:]) for g, w in zip(got, want))
        if not ok:
            print("EXAMPLE", repr(text)); print(" got ", got); print(" want", want); raise SystemExit(1)
    # ends by hand: kind, x, y, z
    t(H + "G1 X10 RND=2\nY10\n", ("l", 8, 0, 0), ("a", 10, 2, 0), ("l", 10, 10, 0))
    t(H + "G1 X10 CHR=2\nY10\n", ("l", 8, 0, 0), ("l", 10, 2, 0), ("l", 10, 10, 0))
    t(H + "G1 X10 CHF=2\nY10\n", ("l", 10 - 2*s2, 0, 0), ("l", 10, 2*s2, 0), ("l", 10, 10, 0))
    # line, then a half circle about (10,5): the rounding of 1 inside the corner of line y=0 and circle from (10,0)... tangent: none
    t(H + "G1 X10 RND=1\nG3 X10 Y10 CR=5\n", ("l", 10, 0, 0), ("a", 10, 10, 0))
    # line along x to (10,0), then clockwise about (10,-... ) tangent too; a real corner: circle about (15,0), start (10,0), clockwise up
    # offset line y=1, offset circle radius 5+1... centre of the rounding left of both: (15-sqrt(35), 1) (outside the circle)
    t(H + "G1 X10 RND=1\nG2 X15 Y5 I5 J0\n", ("l", 15 - math.sqrt(35), 0, 0), ("a", 15 - math.sqrt(35)*5/6, 5/6, 0), ("a", 15, 5, 0))
    t(H + "G1 X10\nCT X20 Y10\n", ("l", 10, 0, 0), ("a", 20, 10, 0))
    m = ends(H + "G1 X10\nCT X20 Y10\n")[-1]; assert near(m.centre, (10, 10, 0)) and near(m.turn, (0, 0, math.pi/2))
    m = ends(H + "G1 X10\nCT X20 Y-10\n")[-1]; assert near(m.centre, (10, -10, 0)) and near(m.turn, (0, 0, -math.pi/2))
    m = ends(H + "G2 X10 Y0 CR=-10\n")[-1]; assert near(m.centre, (5, 10*math.cos(math.pi/6), 0)) and near(m.turn, (0, 0, -5*math.pi/3)), m
    m = ends(H + "G2 X10 Y0 CR=10\n")[-1]; assert near(m.centre, (5, -10*math.cos(math.pi/6), 0)), m
    m = ends(H + "G18\nG3 X10 Z10 CR=10\n")[-1]        # from Z to X is counter-clockwise; centre left of the way (1,1) in (Z,X): Z0 X10
    assert near(m.centre, (10, 0, 0)) and near(m.turn, (0, math.pi/2, 0)), m
    m = ends(H + "G19\nG2 Y10 Z10 CR=10\n")[-1]; assert near(m.centre, (0, 10, 0)) and near(m.turn, (-math.pi/2, 0, 0)), m
    m = ends(H + "G3 X0 Y0 Z-6 I5 J0 TURN=2\n")[-1]; assert near(m.turn, (0, 0, 6*math.pi)) and near(m.end, (0, 0, -6))
    m = ends(H + "G3 I5 J0 AR=180\n")[-1]; assert near(m.end, (10, 0, 0))
    t(H + "G111 X10 Y10\nG1 AP=90 RP=5\nAP=IC(90)\nG110 X1 Y1\nG1 AP=0 RP=2\nG112 X-1 Y0\nG1 AP=-90 RP=3\n",
      ("l", 10, 15, 0), ("l", 5, 10, 0), ("l", 8, 11, 0), ("l", 5, 8, 0))
    t(H + "G18\nG111 Z1 X2\nG1 AP=90 RP=5\n", ("l", 7, 0, 1))
    t(H + "G19\nG111 Y1 Z2\nG1 AP=0 RP=5\n", ("l", 0, 6, 2))
    t(H + "TRANS X10\nAROT Z90\nG1 X5 Y0\nATRANS X5\nG1 X5 Y0\nTRANS Y1\nG1 X0 Y0\nROT\nG1 X0 Y0\n", ("l", 10, 5, 0), ("l", 10, 10, 0), ("l", 0, 1, 0), ("l", 0, 0, 0))
    t(H + "ROT X90 Z90\nG1 X1 Y2 Z3\n", ("l", 3, 1, 2))     # Rz Rx (1,2,3): Rx: (1,-3,2); Rz: (3,1,2)
    t(H + "G70\nG1 X1\nTRANS Y1\nG71\nG1 X0 Y0\n", ("l", 25.4, 0, 0), ("l", 0, 25.4, 0))
    t(H + "G91 G1 X5\nX=AC(3) Y2\nG90 X=IC(1)\n", ("l", 5, 0, 0), ("l", 3, 2, 0), ("l", 4, 2, 0))
    t(H + "FOR R1=1 TO 3\nG1 X=R1*10 Y=-R1\nENDFOR\n", ("l", 10, -1, 0), ("l", 20, -2, 0), ("l", 30, -3, 0))
    t(H + "R1=0\nWHILE R1<2\nR1=R1+1\nG1 X=R1\nENDWHILE\nREPEAT\nR1=R1-1\nG1 Y=R1\nUNTIL R1==0\n", ("l", 1, 0, 0), ("l", 2, 0, 0), ("l", 2, 1, 0), ("l", 2, 0, 0))
    t(H + "AA: G1 X=IC(1)\nBB: Y=IC(1)\nREPEAT AA BB P=1\nREPEATB AA P=2\n", ("l", 1, 0, 0), ("l", 1, 1, 0), ("l", 2, 1, 0), ("l", 2, 2, 0), ("l", 3, 2, 0), ("l", 4, 2, 0))
    t(H + "G4 F5\nL7 P2\nUP(4,,2)\n", ("l", 1, 0, 0), ("l", 2, 0, 0), ("l", 4, 2, 0), L7="G91 G1 X1\nG90\nM17\n", UP="PROC UP(REAL AA, REAL BB, REAL CC)\nG1 X=AA+BB Y=CC\nRET\n")
    t(H + "G0 Z10\nMCALL CYCLE82(5,0,1,-3,,0)\nX1\nMCALL\nX2\n", ("r", 0, 0, 10), ("r", 1, 0, 10), ("r", 1, 0, 1), ("l", 1, 0, -3), ("r", 1, 0, 5), ("r", 2, 0, 5))
    t(H + "G0 Z10\nMCALL CYCLE81(5,0,1,,3)\nHOLES2(0,0,10,90,0,2)\n", ("r", 0, 0, 10), ("r", 0, 10, 10), ("r", 0, 10, 1), ("l", 0, 10, -3), ("r", 0, 10, 5),
      ("r", 0, -10, 5), ("r", 0, -10, 1), ("l", 0, -10, -3), ("r", 0, -10, 5))
    t(H + "G0 Z10\nCYCLE83(5,0,1,-4,,-2,,0,0,0,1,0)\n", ("r", 0, 0, 10), ("r", 0, 0, 1), ("l", 0, 0, -2), ("l", 0, 0, -1), ("l", 0, 0, -4), ("r", 0, 0, 5))
    t(H + "G0 Z10\nG1 X1\nCYCLE84(5,0,1,-3,4,0,3,,1,0,200)\nX2\nCYCLE840(5,0,,,3,,0,,0,6,)\n", ("r", 0, 0, 10), ("l", 1, 0, 10), ("r", 1, 0, 1), ("l", 1, 0, -4), ("l", 1, 0, 1),
      ("r", 1, 0, 5), ("l", 2, 0, 5), ("r", 2, 0, 0), ("l", 2, 0, -3), ("l", 2, 0, 0), ("r", 2, 0, 5))
    t(H + "G0 SUPA Z0\nG0 X5\nG0 Z9\n", ("r", 5, 0, 9))
    t(H + "CIP X10 Y0 I1=5 J1=5 K1=0\n", ("a", 10, 0, 0))
    m = ends(H + "CIP X10 Y0 I1=5 J1=5 K1=0\n")[-1]; assert near(m.centre, (5, 0, 0)) and near(m.turn, (0, 0, -math.pi)), m
    t(H + "IF (1==1) AND (2>3)\nG1 X1\nELSE\nG1 X2\nENDIF\nGOTOF EE\nG1 X3\nEE:\nCASE 2 OF 1 GOTOF A1 2 GOTOF B1\nA1_: G1 X4\nB1: G1 X5\n".replace("A1_:", "AA1:").replace("GOTOF A1", "GOTOF AA1").replace("GOTOF B1", "GOTOF BB1").replace("B1: G1", "BB1: G1"),
      ("l", 2, 0, 0), ("l", 5, 0, 0))
    print("examples right")


if __name__ == "__main__":
    examples()
    selftest(run, generate, int(sys.argv[1]) if len(sys.argv) > 1 else 2000)
