"""FANUC TP listings (.ls), as R-30iA and R-30iB load them (ASCII program loader).

Manual: "R-30iB HandlingTool Setup and Operations Manual" / "Operator's Manual (Basic Operation)" B-83284EN, chapter 4 Program structure (OM).
Looked up: motion line (type, position, speed, termination, options) and that C goes from where the robot is through its first point to its second
(mh142.com/wiki/Motion_Instructions; industrialmonitordirect fanuc-robot-curved-path); PR + PR adds component by component, and
KAREL's frames multiply by `:` (robot-forum thread 46494).
Not looked up (as known): W, P, R as Rz(R) Ry(P) Rx(W); P[n] is in the user frame UF of its data, and the control refuses a move while another UFRAME_NUM
or UTOOL_NUM is active (INTP-252, -253; "F" takes any); units of speed; INC; Offset,PR[n] adds X, Y, Z in the user frame; Tool_Offset is a frame product on the
right; OFFSET CONDITION; LBL, JMP, IF, SELECT, FOR (upwards TO, downwards DOWNTO, run no time if the end is passed), IF (…) THEN; CALL with arguments AR[n];
A: one position a line, three or more in a row; the first is reached on a line, each pair of neighbours lies on the circle through three that follow each other.
Left open, and not generated: Offset with W, P, R (added, or as a frame about the origin of the user frame), INC with W, P, R, LPOS in a cut, fewer than three A, A whose
points do not lie on one circle, CNT as a distance (it depends on speed and acceleration; so zones cannot be judged but for FINE and CR…mm).
"""
import copy
import math
import os
import random
import re
import sys

from move import Move, Refused
from robmath import (I3, NULL, RMove, add, app, circle, dist, finv, fmul, mul, sca, sub, to_zyx, turn_about, zyx, UNREAD, selftest)

SIMPLE = bool(os.environ.get("ORC_SIMPLE"))
KEYS = ("X", "Y", "Z", "W", "P", "R")


class End(Exception):
    pass


class Prog:
    pass


class Ls:
    def __init__(self, files, main, options):
        self.main, self.options = main, options
        self.fn, self.ln, self.steps = main, 1, 0
        self.progs = {}
        self.R, self.PR, self.uf, self.ut = {}, {}, dict(options.get("uframes", {})), dict(options.get("utools", {}))
        self.ufn = self.utn = None
        self.first, self.flange, self.moves, self.cond = None, None, [], None
        self.arcs = []
        for f in files:
            if f.lower().endswith(".ls"):
                p = self.parse(f, files[f].decode("latin-1"))
                self.progs[p.name] = p
                if f == main:
                    self.entry = p

    def no(self, why):
        raise Refused(self.fn, self.ln, why)

    def parse(self, fn, text):
        p = Prog()
        p.fn, p.name, p.lines, p.pos, p.names = fn, None, [], {}, {}
        part, buf, start = None, "", 0
        for n, t in enumerate(re.split(r"\r\n|\n|\r", text), 1):
            self.fn, self.ln = fn, n
            m = re.match(r"/(PROG|ATTR|APPL|MN|POS|END)\b\s*(\S*)", t)
            if m:
                part = m.group(1)
                if part == "PROG":
                    p.name = m.group(2).upper()
                continue
            if part == "MN":
                # `  12:L P[3] 50mm/sec FINE    ;`, and `    :  P[4] …;` that goes on with the line before
                m = re.match(r"\s*(\d*)\s*:(.*)$", t)
                if not m:
                    if t.strip():
                        self.no("no line number")
                    continue
                if m.group(1) or not buf:
                    buf, start = m.group(2), n
                else:
                    buf += " " + m.group(2)
                if buf.rstrip().endswith(";"):
                    p.lines.append((start, buf.rstrip()[:-1].strip()))
                    buf = ""
            elif part == "POS":
                m = re.match(r'\s*P\[(\d+)(?::"([^"]*)")?\]\s*\{', t)
                if m:
                    cur = p.pos[int(m.group(1))] = {"line": n}
                    continue
                for k, v in re.findall(r"\b(UF|UT)\s*:\s*(\d+|F)", t):
                    cur[k] = v
                for k, v in re.findall(r"\b(X|Y|Z|W|P|R|J\d|E\d)\s*=\s*([-+]?[\d.]+|\*+)\s*(?:mm|deg)", t):
                    if "*" in v:
                        self.no("a position that was not taught")
                    if k in cur:
                        self.no("a second motion group")
                    cur[k] = float(v)
        if p.name is None:
            self.no("no /PROG")
        return p

    # ---- registers
    def num(self, t):
        t = t.strip()
        m = re.fullmatch(r"\(([-+]?[\d.]+)\)", t)
        if m:
            t = m.group(1)
        if re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)", t):
            return float(t)
        m = re.fullmatch(r"(-?)R\[(.+?)(?::[^\]]*)?\]", t)
        if m:
            k = int(self.num(m.group(2)))
            if k not in self.R:
                self.no(f"R[{k}] has no value")
            return -self.R[k] if m.group(1) else self.R[k]
        m = re.fullmatch(r"AR\[(\d+)\]", t)
        if m:
            return self.args[int(m.group(1)) - 1]
        m = re.fullmatch(r"PR\[([^,\]:]+)(?::[^\],]*)?,\s*([^\]]+)\]", t)
        if m:
            k, i = int(self.num(m.group(1))), int(self.num(m.group(2)))
            if k not in self.PR or self.PR[k].get(KEYS[i - 1]) is None:
                self.no(f"PR[{k},{i}] has no value")
            return self.PR[k][KEYS[i - 1]]
        self.no("not read: " + t)

    def calc(self, t):
        """OM 4.5: operands and operators, of equal rank in pairs; mixed logic in brackets."""
        t = t.strip()
        if t.startswith("(") and t.endswith(")") and self.outer(t):
            t = t[1:-1].strip()
        ts = re.findall(r"PR\[[^\]]*(?:\[[^\]]*\][^\]]*)?\]|-?A?R\[[^\]]*(?:\[[^\]]*\][^\]]*)?\]|\(-?[\d.]+\)|\d+\.?\d*|\.\d+|DIV|MOD|[-+*/()]", t)
        if "".join(ts).replace(" ", "") != t.replace(" ", ""):
            self.no("not read: " + t)
        pos = [0]

        def term():
            v = factor()
            while pos[0] < len(ts) and ts[pos[0]] in ("*", "/", "DIV", "MOD"):
                o = ts[pos[0]]; pos[0] += 1
                w = factor()
                v = v * w if o == "*" else v / w if o == "/" else float(math.trunc(v / w)) if o == "DIV" else math.fmod(v, w)
            return v

        def factor():
            x = ts[pos[0]]; pos[0] += 1
            if x == "(":
                v = sums(); pos[0] += 1
                return v
            if x == "-":
                return -factor()
            return self.num(x)

        def sums():
            v = term()
            while pos[0] < len(ts) and ts[pos[0]] in ("+", "-"):
                o = ts[pos[0]]; pos[0] += 1
                w = term()
                v = v + w if o == "+" else v - w
            return v
        v = sums()
        if pos[0] != len(ts):
            self.no("not read: " + t)
        return v

    def outer(self, t):
        d = 0
        for i, c in enumerate(t):
            d += (c == "(") - (c == ")")
            if d == 0:
                return i == len(t) - 1
        return False

    def test(self, t):
        t = t.strip()
        while t.startswith("(") and self.outer(t):
            t = t[1:-1].strip()
        for word, f in ((r"\s+OR\s+", any), (r"\s+AND\s+", all)):
            ps = re.split(word, t)
            if len(ps) > 1:
                return f([self.test(x) for x in ps])
        m = re.fullmatch(r"(.+?)(<>|<=|>=|=|<|>)(.+)", t)
        if not m:
            self.no("condition: " + t)
        a, b = self.calc(m.group(1)), self.calc(m.group(3))
        return {"=": a == b, "<>": a != b, "<": a < b, ">": a > b, "<=": a <= b, ">=": a >= b}[m.group(2)]

    def frame(self, d):
        try:
            return (zyx(d["R"], d["P"], d["W"]), (d["X"], d["Y"], d["Z"]))
        except (KeyError, TypeError):
            self.no("a position without all numbers")

    def posval(self, t, p):
        """P[n], PR[n], with the frames it is in."""
        m = re.fullmatch(r"(PR|P)\[(.+?)(?::[^\]]*)?\]", t.strip())
        if not m:
            self.no("position: " + t)
        k = int(self.num(m.group(2)))
        if m.group(1) == "P":
            if k not in p.pos:
                self.no(f"P[{k}] is not in the file")
            return p.pos[k]
        if k not in self.PR:
            self.no(f"PR[{k}] has no value")
        return self.PR[k]

    # ---- moves
    def frames(self, d):
        for key, now, err in (("UF", self.ufn, "user frame"), ("UT", self.utn, "tool frame")):
            v = d.get(key)
            if v not in (None, "F") and now is not None and int(v) != now:
                self.no(f"{err} {now} is active, the position is in {v}: the control stops")
        # what is active at the start is not in the file: it has to be that of the first position, or the control stops there
        if self.ufn is None and d.get("UF") not in (None, "F"):
            self.ufn = int(d["UF"])
        if self.utn is None and d.get("UT") not in (None, "F"):
            self.utn = int(d["UT"])
        uf = self.ufn if self.ufn is not None else int(d.get("UF", 0)) if d.get("UF") not in (None, "F") else None
        ut = self.utn if self.utn is not None else int(d.get("UT", 0)) if d.get("UT") not in (None, "F") else None
        U = NULL if uf == 0 else self.uf.get(uf)
        T = NULL if ut == 0 else self.ut.get(ut)
        return (U if U is not None else NULL, None if U is not None else ("UF", uf)), (T if T is not None else NULL, None if T is not None else ("UT", ut))

    def motion(self, kind, rest, p):
        self.flusharc(kind)
        n = 2 if kind == "C" else 1
        pts = []
        for _ in range(n):
            m = re.match(r"\s*(PR?\[[^\]]*(?:\[[^\]]*\])?[^\]]*\])\s*", rest)
            if not m:
                self.no("no position: " + rest)
            pts.append(self.posval(m.group(1), p))
            rest = rest[m.end():]
        m = re.match(r"\s*(R\[[^\]]*\]|[\d.]+)\s*(mm/sec|cm/min|inch/min|deg/sec|sec|msec|%)\s*(FINE|CNT\s*(?:\d+|R\[[^\]]*\])|CR\s*\d+\s*(?:mm)?|CD\s*\d+)\s*(.*)$", rest)
        if not m:
            m = re.match(r"\s*(WELD_SPEED|MAX_SPEED)\s*(?:(mm/sec))?\s*(FINE|CNT\d+)\s*(.*)$", rest) or self.no("speed or termination: " + rest)
        sp, unit, term, opts = m.groups()
        v = self.num(sp) if sp[0] in "R.0123456789" else None
        feed = None if v is None else v * 60 if unit == "mm/sec" else v * 10 if unit == "cm/min" else v * 25.4 if unit == "inch/min" else None
        zone = 0.0 if term == "FINE" else float(re.search(r"\d+", term).group(0)) if term.startswith("CR") else None
        inc, off, toff = False, None, None
        for o in re.findall(r"Tool_Offset(?:,\s*PR\[[^\]]*\])?|Offset(?:,\s*PR\[[^\]]*\])?|INC|ACC\s*\d+|Wjnt|PTH|COORD|\S+", opts):
            if o.startswith("Tool_Offset"):
                q = re.search(r"PR\[.*\]", o)
                toff = self.posval(q.group(0), p) if q else self.no("TOOL_OFFSET CONDITION")
            elif o.startswith("Offset"):
                q = re.search(r"PR\[.*\]", o)
                off = self.posval(q.group(0), p) if q else self.cond or self.no("Offset without OFFSET CONDITION")
            elif o == "INC":
                inc = True
            elif re.match(r"ACC|PTH|Wjnt|EV|BREAK", o):
                pass
            else:
                self.no("motion option " + o)
        d = pts[-1]
        if "J1" in d:
            if kind != "J":
                # OM: joint representation in a path: the end is where these joints lead
                self.no("joints as the end of a path")
            self.flange = None
            self.moves.append(RMove("joint", self.fn, self.ln, None, joints=tuple(d.get(f"J{k}") for k in range(1, 7)), zone=zone, note=term))
            return
        (U, uk), (T, tk) = self.frames(d)
        if self.first is None:
            self.first = (U, uk)
        if uk != self.first[1]:
            self.no("several user frames, of which the numbers of one are not known")
        here = lambda: fmul(finv(U), fmul(self.flange[0], T)) if self.flange and self.flange[1] == (uk, tk) else None

        def pose(d):
            if inc:
                c = here() or self.no("INC from where nobody knows")
                if any(d.get(k) for k in "WPR"):
                    self.no("INC with W, P, R")
                f = (c[0], add(c[1], (d["X"], d["Y"], d["Z"])))
            else:
                f = self.frame(d)
            if off is not None:
                if any(off.get(k) for k in "WPR"):
                    self.no("Offset with W, P, R")
                f = (f[0], add(f[1], tuple(off.get(k) or 0.0 for k in "XYZ")))
            if toff is not None:
                f = fmul(f, self.frame({k: toff.get(k) or 0.0 for k in KEYS}))
            return f
        inW = lambda f: fmul(finv(self.first[0]), fmul(U, f))
        start = here() and inW(here())
        E = inW(pose(d))
        k = {"J": "rapid", "L": "line", "C": "arc", "A": "arc"}[kind]
        mv = RMove(k, self.fn, self.ln, E[1], E[0], None, None, None if kind == "J" else feed, None, start and start[1], zone, T[0], note=term)
        if kind == "C":
            if start is None:
                self.no("an arc whose start is not known")
            mv.via = inW(pose(pts[0]))[1]
            c = circle(start[1], mv.via, E[1]) or self.no("an arc through points in line")
            mv.centre, mv.turn = c[0], sca(c[3], c[2])
        self.moves.append(mv)
        if kind == "A":
            self.arcs.append(mv)
        self.flange = (fmul(fmul(U, pose(d)) if not inc else fmul(self.first[0], E), finv(T)), (uk, tk))

    def flusharc(self, kind):
        """A run of A ends: its pieces become arcs."""
        a = self.arcs
        if kind == "A" or not a:
            return
        if len(a) < 3:
            self.no("fewer than three A in a row")
        a[0].kind = "line"
        for i in range(1, len(a)):
            j = min(i, len(a) - 2)
            c = circle(a[j - 1].end, a[j].end, a[j + 1].end) or self.no("A through points in line")
            s = sub(a[i - 1].end, c[0])
            e = sub(a[i].end, c[0])
            x = sub(s, (0, 0, 0))
            from robmath import cross, dot
            ang = math.atan2(dot(cross(s, e), c[2]), dot(s, e)) % (2 * math.pi)
            a[i].centre, a[i].turn, a[i].start = c[0], sca(ang, c[2]), a[i - 1].end
            a[i].via = add(c[0], turn_about(c[2], ang / 2, s))
        self.arcs = []

    # ---- running
    def call(self, p, args, depth=0):
        if depth > 10:
            self.no("calls too deep")
        keep = (self.fn, self.ln, getattr(self, "args", []))
        self.fn, self.args = p.fn, args
        i, loops = 0, []
        L = p.lines
        while i < len(L):
            self.ln, t = L[i]
            self.steps += 1
            if self.steps > 100000:
                self.no("does not end")
            j = i + 1
            if not t or t.startswith("!") or t.startswith("//") or t.startswith("--eg:"):
                pass
            elif re.match(r"[JLCA]\s+PR?\[", t):
                self.motion(t[0], t[1:], p)
            elif re.match(r"LBL\[", t):
                pass
            elif re.match(r"FOR\s", t):
                m = re.match(r"FOR\s+R\[(\d+)[^\]]*\]\s*=\s*(.+?)\s+(TO|DOWNTO)\s+(.+)$", t)
                k, a, b = int(m.group(1)), self.num(m.group(2)), self.num(m.group(4))
                st = 1 if m.group(3) == "TO" else -1
                self.R[k] = a
                if (a > b) if st > 0 else (a < b):
                    j = self.skip(L, i, "FOR", ("ENDFOR",)) + 1
                else:
                    loops.append((k, b, st, i))
            elif t == "ENDFOR":
                k, b, st, at = loops[-1]
                if (self.R[k] + st <= b) if st > 0 else (self.R[k] + st >= b):
                    self.R[k] += st
                    j = at + 1
                else:
                    loops.pop()
            elif re.match(r"IF\b.*\bTHEN$", t):
                if not self.test(re.match(r"IF\s*(.*?)\s*THEN$", t).group(1)):
                    j = self.skip(L, i, "IF", ("ELSE", "ENDIF")) + 1
            elif t == "ELSE":
                j = self.skip(L, i, "IF", ("ENDIF",)) + 1
            elif t == "ENDIF":
                pass
            elif t.startswith("IF"):
                m = re.match(r"IF\s*(.+?),\s*(JMP|CALL|R\[.*)\s*(.*)$", t) or self.no("not read: " + t)
                if self.test(m.group(1)):
                    j = self.action(m.group(2) + " " + m.group(3), p, L, j, depth)
            elif t.startswith("SELECT"):
                m = re.match(r"SELECT\s+(R\[[^\]]*\])\s*=\s*(.+?),\s*(.*)$", t)
                v, rows = self.num(m.group(1)), [(m.group(2), m.group(3))]
                q = i + 1
                while q < len(L) and re.match(r"\s*(=|ELSE,)", L[q][1]):
                    u = L[q][1].strip()
                    rows.append((None, u[5:]) if u.startswith("ELSE") else tuple(x.strip() for x in u[1:].split(",", 1)))
                    q += 1
                j = q
                for c, act in rows:
                    if c is None or self.num(c) == v:
                        j = self.action(act.strip(), p, L, j, depth)
                        break
            elif t.startswith(("JMP", "CALL")):
                j = self.action(t, p, L, j, depth)
            elif t in ("END", "ABORT"):
                self.flusharc("")
                if t == "ABORT":
                    raise End()
                break
            else:
                self.assign(t, p)
            i = j
        self.flusharc("")
        self.fn, self.ln, self.args = keep

    def skip(self, L, i, word, ends):
        d = 0
        for q in range(i + 1, len(L)):
            u = L[q][1]
            if u in ends and d == 0:
                return q
            if re.match(r"FOR\s", u) if word == "FOR" else re.match(r"IF\b.*\bTHEN$", u):
                d += 1
            elif u == "END" + word:
                d -= 1
        self.no("no end of " + word)

    def action(self, t, p, L, j, depth):
        m = re.match(r"JMP\s+LBL\[(\d+)", t)
        if m:
            for q, (n, u) in enumerate(L):
                if re.match(rf"LBL\[{m.group(1)}[\]:]", u):
                    return q
            self.no("no LBL")
        m = re.match(r"CALL\s+([\w-]+)\s*(?:\((.*)\))?\s*$", t)
        if m:
            q = self.progs.get(m.group(1).upper())
            if q is None:
                if m.group(1).upper() in [c.upper() for c in self.options.get("calls_kept", [])]:
                    return j
                self.no(f"program {m.group(1)} is not beside this one")
            self.flusharc("")
            self.call(q, [self.num(a) for a in m.group(2).split(",")] if m.group(2) else [], depth + 1)
            return j
        if t.startswith("R["):
            self.assign(t, p)
            return j
        self.no("not read: " + t)

    def assign(self, t, p):
        if re.match(r"(DO|RO|GO|AO|F|SO|UO)\[.*\]\s*=|WAIT\b|PAUSE|OVERRIDE|PAYLOAD|MESSAGE|TIMER|\$|ERROR|UALM|TOOL_OFFSET|COL |RUN\b|TC_ONLINE|LINE\b|POINT", t):
            if t.startswith("TOOL_OFFSET") or t.startswith("RUN"):
                self.no(t)
            if re.match(r"\$MNUFRAMENUM|\$MNUTOOLNUM", t):
                self.no(t)
            return
        m = re.match(r"(UFRAME_NUM|UTOOL_NUM)\s*=\s*(.+)$", t)
        if m:
            v = int(self.num(m.group(2)))
            if m.group(1)[1] == "F":
                self.ufn = v
            else:
                self.utn = v
            return
        m = re.match(r"OFFSET\s+CONDITION\s+(PR\[.*\])$", t)
        if m:
            self.cond = copy.deepcopy(self.posval(m.group(1), p))
            return
        m = re.match(r"(UFRAME|UTOOL)\[(.+?)\]\s*=\s*(PR\[.+\])$", t)
        if m:
            f = self.frame(self.posval(m.group(3), p))
            (self.uf if m.group(1) == "UFRAME" else self.ut)[int(self.num(m.group(2)))] = f
            return
        m = re.match(r"R\[([^:\]]+)(?::[^\]]*)?\]\s*=\s*(.+)$", t)
        if m:
            self.R[int(self.num(m.group(1)))] = self.calc(m.group(2))
            return
        m = re.match(r"PR\[([^,:\]]+)(?::[^,\]]*)?,\s*([^\]]+?)(?::[^\]]*)?\]\s*=\s*(.+)$", t)
        if m:
            self.PR.setdefault(int(self.num(m.group(1))), {})[KEYS[int(self.num(m.group(2))) - 1]] = self.calc(m.group(3))
            return
        m = re.match(r"PR\[([^,\]:]+)(?::[^\]]*)?\]\s*=\s*(.+)$", t)
        if m:
            k, e = int(self.num(m.group(1))), m.group(2).strip()
            ps = re.split(r"(?<=\])\s*([-+])\s*", e)
            if re.match(r"(LPOS|JPOS|UFRAME|UTOOL)", e):
                self.no(e)
            v = copy.deepcopy(self.posval(ps[0], p))
            v = {q: v.get(q) for q in KEYS + tuple(f"J{n}" for n in range(1, 7)) if q in v}
            for o, x in zip(ps[1::2], ps[2::2]):
                w = self.posval(x, p)
                if "J1" in w or "J1" in v:
                    self.no("joints added")
                v = {q: (v.get(q) or 0.0) + (1 if o == "+" else -1) * (w.get(q) or 0.0) for q in KEYS}
            self.PR[k] = v
            return
        self.no("not read: " + t)


def trace(files, main, options):
    l = Ls(files, main, options)
    try:
        l.call(l.entry, [])
    except End:
        pass
    except UNREAD as e:
        raise Refused(l.fn, l.ln, f"not read ({type(e).__name__}: {e})")
    return l.moves


def run(files, main, options):
    return [m for m in trace(files, main, options) if m.end is not None]


# ---- random programs
def generate(seed):
    r = random.Random(f"ls{seed}")
    for _ in range(60):
        files, main, opt = Gen(r).make()
        try:
            run(files, main, opt)
        except Refused as e:       # three points that rounding put in line
            if "in line" in e.why:
                continue
            raise
        mv = run(files, main, opt)
        if len(mv) >= 5 and all(max(abs(c) for c in m.end) <= 300 for m in mv) and \
                all(m.kind != "arc" or dist(m.start, m.centre) >= 1 for m in mv) and any(m.kind != "rapid" for m in mv):
            return files, main, opt
    raise AssertionError(seed)


class Gen:
    def __init__(self, r):
        self.r, self.dec = r, r.choice([3, 3, 3, 2])
        self.wpr = r.choice([(180.0, 0.0, 0.0), (180.0, 0.0, 90.0), (-180.0, 0.0, 0.0), (round(180 + r.uniform(-20, 20), 3), round(r.uniform(-25, 25), 3), round(r.uniform(-170, 170), 3))])
        self.safe, self.lines, self.pts, self.have, self.subs = 50.0, [], [], set(), {}
        self.uf, self.ut = r.choice([(1, 1), (1, 1), (2, 3), (0, 1), (9, 2)])
        self.vary = r.random() < .25      # the tool turns along the path
        self.e1 = r.random() < .2
        self.cm = r.random() < .2
        self.cur = None

    def rnd(self, a, b):
        return round(self.r.uniform(a, b), self.dec)

    def xy(self):
        return self.rnd(-90, 90), self.rnd(-90, 90)

    def z(self):
        return self.rnd(-15, 4)

    def put(self, t):
        self.lines.append(t)

    def P(self, p, pts=None, uf=None, wpr=None):
        pts = self.pts if pts is None else pts
        pts.append((p, self.uf if uf is None else uf, wpr or self.wpr))
        n = len(pts)
        c = "" if self.r.random() < .85 else ":cut"
        return f"P[{n}{c}]"

    def tail(self):
        sp = self.r.choice(["20mm/sec", "50mm/sec", "100mm/sec", "120cm/min", "R[50]mm/sec"] if not SIMPLE else ["50mm/sec"])
        if sp.startswith("R["):
            if "R50" not in self.have:
                sp = "30mm/sec"
        return f"{sp} {self.r.choice(['FINE', 'CNT0', 'CNT50', 'CNT100', 'FINE'])}" + self.r.choice(["", "", "", " ACC80"])

    def turn(self):
        if self.vary and self.r.random() < .4:
            self.wpr = tuple(round(c + self.r.uniform(-12, 12), 3) for c in self.wpr)

    def lin(self, p):
        self.turn()
        self.put(f"L {self.P(p)} {self.tail()}    ")
        self.cur = p

    def rapid(self, p):
        self.put(f"J {self.P(p)} {self.r.choice(['100%', '50%', '20%'])} {self.r.choice(['FINE', 'CNT100'])}    ")
        self.cur = p

    def arcpts(self, n):
        x, y, z = self.cur
        rad, a0 = self.r.uniform(4, 30), self.r.uniform(0, 6.28)
        sw = self.r.choice([-1, 1]) * self.r.uniform(.6, 4.0)
        cx, cy = x - rad * math.cos(a0), y - rad * math.sin(a0)
        return [(round(cx + rad * math.cos(a0 + sw * k / n), self.dec), round(cy + rad * math.sin(a0 + sw * k / n), self.dec), z) for k in range(1, n + 1)]

    def arc(self):
        a, b = self.arcpts(2)
        if dist(a, b) < 1 or dist(self.cur, a) < 1:
            return
        self.turn()
        self.put(f"C {self.P(a)}    \n    :  {self.P(b)} {self.tail()}    ")
        self.cur = b

    def op(self):
        r = self.r
        k = r.choice(["lin"] * 3 + ["arc", "arc", "A", "offset", "toffset", "inc", "pr", "for", "for", "jmp", "if", "ifthen", "select", "call", "callarg", "misc", "misc", "retract", "joint", "cond"])
        if SIMPLE:
            k = r.choice(["lin", "lin", "arc", "misc", "retract", "joint"])
        z = self.z()
        if k == "lin":
            for _ in range(r.randint(1, 3)):
                self.lin((*self.xy(), z))
        elif k == "arc":
            self.arc()
        elif k == "A":
            pts = [self.cur] + self.arcpts(r.choice([2, 3, 4]))
            if min(dist(a, b) for a, b in zip(pts, pts[1:])) < 1:
                return
            for p in pts:
                self.put(f"A {self.P(p)} {self.tail()}    ")
            self.cur = pts[-1]
            self.lin((*self.xy(), z))
        elif k in ("offset", "toffset", "cond"):
            n = r.randint(1, 5)
            for i in range(6):
                v = self.rnd(-9, 9) if i < 2 else self.rnd(-2, 0) if i == 2 else (self.r.choice([0, 5.0]) if k == "toffset" and i == 5 else 0)
                s = f"({v})" if v < 0 and r.random() < .6 else f"{v}"
                self.put(f"PR[{n},{i + 1}]={s}    ")
            if k == "cond":
                self.put(f"OFFSET CONDITION PR[{n}]    ")
            w = {"offset": f"Offset,PR[{n}]", "toffset": f"Tool_Offset,PR[{n}]", "cond": "Offset"}[k]
            for _ in range(r.randint(1, 2)):
                self.put(f"L {self.P((*self.xy(), z))} {self.tail()} {w}    ")
            self.lin((*self.xy(), z))
        elif k == "inc":
            self.put(f"L {self.P((self.rnd(-9, 9), self.rnd(-9, 9), -0.5), wpr=(0.0, 0.0, 0.0))} 30mm/sec FINE INC    ")
            self.lin((*self.xy(), z))
        elif k == "pr":
            t = self.P((*self.xy(), z))
            self.put(f"PR[10]={t}    ")
            self.put(f"PR[10,3]=PR[10,3]{r.choice(['+', '-'])}{self.rnd(.5, 2)}    ")
            self.put(f"L PR[10{r.choice(['', ':via'])}] {self.tail()}    ")
            self.lin((*self.xy(), z))
        elif k == "for":
            t = self.P((self.rnd(-40, 0), self.rnd(-40, 0), z))
            a, w, b = r.choice([(1, "TO", 3), (0, "TO", 2), (3, "DOWNTO", 1)])
            self.put(f"PR[11]={t}    ")
            self.put(f"FOR R[1:row]={a} {w} {b}    ")
            self.put(f"PR[11,2]=PR[11,2]+{self.rnd(1, 5)}    ")
            self.put(f"L PR[11] {self.tail()}    ")
            self.put(f"PR[11,1]=R[1]*{self.rnd(2, 9)}    ")
            self.put(f"L PR[11] {self.tail()}    ")
            self.put("ENDFOR    ")
            self.lin((*self.xy(), z))
        elif k == "jmp" and "LBL1" not in self.have:
            self.have.add("LBL1")
            self.put("R[2]=0    ")
            self.put("PR[12]=" + self.P((0, 0, 0), wpr=(0, 0, 0)) + "    ")
            self.put("LBL[1:again]    ")
            self.put(f"L {self.P((*self.xy(), z))} {self.tail()} Offset,PR[12]    ")
            self.put(f"L {self.P((*self.xy(), z))} {self.tail()} Offset,PR[12]    ")
            self.put("PR[12,3]=PR[12,3]-1    ")
            self.put("R[2]=R[2]+1    ")
            self.put(r.choice(["IF R[2]<3,JMP LBL[1]    ", "IF (R[2]<3),JMP LBL[1]    "]))
            self.lin((*self.xy(), z))
        elif k == "if" and "LBL5" not in self.have:
            self.have.add("LBL5")
            self.put(f"R[3]={r.randint(0, 2)}    ")
            self.put("IF R[3]=1,JMP LBL[5]    ")
            self.lin((*self.xy(), z))
            self.put("LBL[5]    ")
            self.lin((*self.xy(), z))
        elif k == "ifthen":
            self.put(f"R[4]={r.randint(0, 2)}    ")
            self.put(r.choice(["IF (R[4]=1) THEN    ", "IF (R[4]>0 AND R[4]<2) THEN    "]))
            self.lin((*self.xy(), z))
            self.put("ELSE    ")
            self.lin((*self.xy(), z))
            self.put("ENDIF    ")
            self.lin((*self.xy(), z))
        elif k == "select" and "LBL20" not in self.have:
            self.have.add("LBL20")
            self.put(f"R[6]={r.randint(1, 3)}    ")
            self.put("SELECT R[6]=1,JMP LBL[21]    ")
            self.put("       =2,JMP LBL[22]    ")
            self.put("       ELSE,JMP LBL[23]    ")
            for q in (21, 22):
                self.put(f"LBL[{q}]    ")
                self.lin((*self.xy(), z))
                self.put("JMP LBL[23]    ")
            self.put("LBL[23]    ")
            self.lin((*self.xy(), z))
        elif k == "call" and "SLOT" not in self.subs:
            pts, ls = [], []
            for _ in range(r.randint(2, 3)):
                ls.append(f"L {self.P((*self.xy(), z), pts)} 40mm/sec FINE    ")
            self.subs["SLOT"] = (ls, pts)
            self.put("CALL SLOT    ")
            self.lin((*self.xy(), z))
        elif k == "callarg" and "STEPX" not in self.subs:
            pts = []
            t = self.P((*self.xy(), z), pts)
            self.subs["STEPX"] = ([f"PR[15]={t}    ", "PR[15,1]=PR[15,1]+AR[1]    ", "L PR[15] 40mm/sec FINE    "], pts)
            for v in (3, 7.5):
                self.put(f"CALL STEPX({v})    ")
            self.lin((*self.xy(), z))
        elif k == "misc":
            self.put(r.choice(["! cut    ", "WAIT    .50(sec)    ", "DO[3]=ON    ", "DO[3:spindle]=OFF    ", "    ", "OVERRIDE=100%    ", "// L P[1] 50mm/sec FINE    ", "!level 2    "]))
        elif k == "retract":
            self.lin((self.cur[0], self.cur[1], self.safe))
            p = (*self.xy(), self.safe)
            self.rapid(p)
            self.lin((p[0], p[1], z))
        elif k == "joint":
            self.lin((self.cur[0], self.cur[1], self.safe))
            self.pts.append(None)
            self.put(f"J P[{len(self.pts)}] 50% FINE    ")
            p = (*self.xy(), self.safe)
            self.rapid(p)
            self.lin((p[0], p[1], z))

    def text(self, name, lines, pts, nl):
        r = self.r
        out = [f"/PROG  {name}", "/ATTR", "OWNER\t\t= MNEDITOR;", 'COMMENT\t\t= "posted";', "PROG_SIZE\t= 1024;", f"LINE_COUNT\t= {len(lines)};", "PROTECT\t\t= READ_WRITE;",
               "DEFAULT_GROUP\t= 1,*,*,*,*;", "/MN"]
        for n, t in enumerate(lines, 1):
            a, *b = t.split("\n")
            out.append(f"{n:4d}:{'' if a[:2] in ('J ', 'L ', 'C ', 'A ') else '  '}{a}" + (";" if not b else ""))
            out += [x + ";" for x in b]
        out.append("/POS")
        for n, q in enumerate(pts, 1):
            out.append(f"P[{n}]{{")
            out.append("   GP1:")
            if q is None:
                out.append(f"\tUF : {self.uf}, UT : {self.ut},\t")
                out.append("\tJ1=     0.000 deg,\tJ2=   -20.000 deg,\tJ3=    10.000 deg,")
                out.append("\tJ4=     0.000 deg,\tJ5=   -60.000 deg,\tJ6=     0.000 deg")
            else:
                p, uf, w = q
                out.append(f"\tUF : {uf}, UT : {self.ut},\t\tCONFIG : 'N U T, 0, 0, 0',")
                f = lambda v: f"{v:10.{self.dec}f}"
                out.append(f"\tX = {f(p[0])}  mm,\tY = {f(p[1])}  mm,\tZ = {f(p[2])}  mm,")
                out.append(f"\tW = {w[0]:9.3f} deg,\tP = {w[1]:9.3f} deg,\tR = {w[2]:9.3f} deg" + (",\n\tE1=     0.000  mm" if self.e1 else ""))
            out.append("};")
        out.append("/END")
        return (nl.join("\n".join(out).split("\n")) + nl).encode()

    def make(self):
        r = self.r
        if r.random() < .85:
            self.put(f"UFRAME_NUM={self.uf}    ")
            self.put(f"UTOOL_NUM={self.ut}    ")
        if r.random() < .3:
            self.have.add("R50")
            self.put(f"R[50:speed]={r.choice([20, 35])}    ")
        start = (*self.xy(), self.safe)
        if r.random() < .2:
            self.pts.append(None)
            self.put("J P[1:\"HOME\"] 20% FINE    " if False else "J P[1] 20% FINE    ")
        self.rapid(start)
        self.lin((start[0], start[1], self.z()))
        target = r.randint(14, 36)
        while len(self.lines) < target:
            self.op()
        self.lin((self.cur[0], self.cur[1], self.safe))
        if r.random() < .3:
            self.put("END    ")
        name = r.choice(["PART", "MILL", "JOB_"]) + str(r.randint(1, 99))
        nl = r.choice(["\r\n", "\n"])
        main = name + r.choice([".LS", ".ls"])
        files = {main: self.text(name, self.lines, self.pts, nl)}
        for n, (ls, pts) in self.subs.items():
            files[n + main[-3:]] = self.text(n, ls, pts, nl)
        return files, main, {"tip": (0, 0, 300), "toml": "[robot_program]\ntool_rotation_deg = [0.0, 0.0, 0.0]\n"}


def hand(lines, pts):
    t = "/PROG T\n/MN\n" + "".join(f"{i}:{l} ;\n" for i, l in enumerate(lines, 1)) + "/POS\n"
    for n, p in pts.items():
        t += f"P[{n}]{{\n GP1:\n UF : 1, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n X = {p[0]} mm, Y = {p[1]} mm, Z = {p[2]} mm,\n W = {p[3]} deg, P = {p[4]} deg, R = {p[5]} deg\n}};\n"
    return t + "/END\n"


HAND = [
    ("loop", hand(["UFRAME_NUM=1", "J P[1] 50% FINE", "FOR R[1]=2 DOWNTO 1", "PR[1]=P[2]", "PR[1,3]=R[1]*(-2)", "L PR[1] 10mm/sec CNT50", "ENDFOR", "PR[2,1]=1", "PR[2,2]=2", "PR[2,3]=3",
                   "L P[2] 10mm/sec FINE Offset,PR[2]", "L P[1] 10mm/sec FINE Tool_Offset,PR[2]", "IF R[1]=1,JMP LBL[2]", "L P[2] 10mm/sec FINE", "LBL[2]", "L P[2] 5mm/sec FINE INC"],
                  {1: (0, 0, 50, 180, 0, 0), 2: (1, 2, 3, 0, 0, 0)}),
     [(0, 0, 50), (1, 2, -4), (1, 2, -2), (2, 4, 6), (1, -2, 47), (2, 0, 50)]),
    ("arcs", hand(["J P[1] 50% FINE", "C P[2]\n  : P[3] 10mm/sec FINE", "A P[3] 10mm/sec FINE", "A P[4] 10mm/sec FINE", "A P[1] 10mm/sec FINE", "R[3]=3", "SELECT R[3]=1,JMP LBL[1]", "  =3,JMP LBL[2]",
                   "  ELSE,JMP LBL[1]", "LBL[1]", "L P[2] 9mm/sec FINE", "LBL[2]", "IF (R[3]=3 AND R[3]>4) THEN", "L P[3] 5mm/sec FINE", "ELSE", "L P[4] 5cm/min FINE", "ENDIF"],
                  {1: (10, 0, 0, 0, 0, 0), 2: (0, 10, 0, 0, 0, 0), 3: (-10, 0, 0, 0, 0, 0), 4: (0, -10, 0, 0, 0, 0)}),
     [(10, 0, 0), (-10, 0, 0), (-10, 0, 0), (0, -10, 0), (10, 0, 0), (0, -10, 0)]),
]


if __name__ == "__main__":
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    selftest("fanuc_ls", [(name, {"t.ls": text.encode()}, "t.ls", want) for name, text, want in HAND], run, generate, n, near=1e-9, mismatch=1e-2)
