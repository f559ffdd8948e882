#!/usr/bin/env python3
"""An interpreter of APT / CLDATA text (ISO 4343) as NX, CATIA, Creo and Autodesk write it.

Looked up:
  ISO     ISO 4343:2000 as quoted clause by clause in a public contract (find_string id 66520930393): 4.2 `$` goes on, `$$` comments; 5.42 RAPID
          holds for the next motion alone; 5.32 MULTAX (bare: ON); 5.21 GOTO with three or six numbers; 10.8.7 CYCLE/DRILL; 5.59 UNITS; 5.13 DELAY
  CREO    support.ptc.com, CL Output for Circular Interpolation: CIRCLE/x,y,z,i,j,k,r between two GOTO, i j k by the right-hand rule; helix: the end's
          height differs; INDIRV and TLON,GOFWD/(CIRCLE/x,y,z,r),ON,(LINE/...); CL Output for Holemaking Cycles: DEPTH, CLEAR, RAPTO, RETURN and the
          fixed order type, z, f, units, t, r, i; Supported CL Data Commands
  NX      NX help, CLSF Manager, quoted at community.plm.automation.siemens.com td-p/461633: CIRCLE/x,y,z,i,j,k,r,t,f,d,e[,TIMES,n]
  CATIA   mfgugrf0603 (APT import): GODLTA with I J K, FEDRAT in both orders, $$*CATIA0; INDIRV is the tangent at the start, the LINE leads from the centre to
          the end, ON,2,INTOF as a public reader documents them (find_string id 55116026303)
  FUSION  apt.cps of Autodesk (find_string MOVARC/): MOVARC/cx,cy,cz,nx,ny,nz,r,ANGLE,deg and the end as GOTO
Found in public files (none of them is part of this):
  NX's CIRCLE (11 numbers) turns LEFT-handed about i,j,k: of the joints of arcs with lines in 4 of the 21 files of HumMan/CLSFProcessor, 623 are smooth that way
  and none the other way ("assuming a clockwise direction" of the help is seen from the tip of the axis); Creo's (7 numbers) turns right-handed
  (86 of 86 in 3 files of MichaHofft/CreoPost, and its help). TIMES,n of NX is n-1 whole turns and the rest up to the end: ramps come out as 2.000 and
  0.400 degrees that way. CAMWorks (aamorim1913/AptPostProcessor, 41 files): UNIT/MM, RAPID/, CYCLE/INIT,
  CIRCLE/ with six numbers, right-handed (a line meets it so in basemach.apt, lines 78 to 80), FEDTO positive, RTRCTO from the GOTO point, DEEP2.
Not looked up (as known):
  GOHOME/ of NX is a rapid move; ON: the first crossing of the circle with the whole line on the way, 2,INTOF: the second; FEDTO of NX is counted
  from the GOTO point along the tool's axis, negative into the part (CAMWorks: positive); a cycle's GOTO is the surface, CLEAR or RAPTO above it the height of rapid moves, RTRCTO
  (NX) and RETURN (Creo) heights above it to go back to; CATIA's CYCLE/DRILL,depth,...: not followed (PP tables differ); without UNITS: mm; MSYS says where the
  coordinates are measured from and moves nothing while it stays; FROM is no move; arcs in a plane that the tool's axis is not normal to are followed.
"""
import math, os, random, re, sys
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from move import Move, Refused

QUIET = set("""PARTNO PPRINT MACHIN LOADTL LOAD SELECT SPINDL COOLNT CUTTER INTOL OUTTOL TOLER STOP OPSTOP DELAY DWELL AUTOPS INSERT REWIND HOLDER PPTABLE
 TLDATA PAINT END-OF-PATH TPRINT SEQNO REMARK DISPLY CLDIST CLAMP END TOOLNO TITLES NOPOST CLPRNT PREFUN AUXFUN SAFETY MODE FEDRTE OP PPFUN CHGTOOL LPRINT
 NOTE TURRET DMIS CLRSRF TMARK LEADER SWITCH""".split())
TEXT = {"PARTNO", "PPRINT", "INSERT", "REMARK", "TPRINT", "NOTE", "TITLES", "TOOL PATH"}
NUM = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][-+]?\d+)?"


def sub(a, b): return tuple(x-y for x, y in zip(a, b))
def dot(a, b): return sum(x*y for x, y in zip(a, b))
def cross(a, b): return (a[1]*b[2]-a[2]*b[1], a[2]*b[0]-a[0]*b[2], a[0]*b[1]-a[1]*b[0])
def norm(a): return math.sqrt(dot(a, a))
def unit(a): n = norm(a); return tuple(x/n for x in a)
def along(a, b, s): return tuple(x+s*y for x, y in zip(a, b))


def statements(text):
    """(first line, last line, statement); `$` at the end goes on, `$$` is a comment (ISO 4.2)."""
    out, cur, first, note = [], "", None, False
    for n, raw in enumerate(text.splitlines(), 1):
        word = re.match(r"\s*([A-Z]+)", raw.upper())
        if not cur and word and word.group(1) in TEXT: s = raw.strip()
        elif not cur and raw.strip().startswith("$$->") and raw.rstrip().endswith("$"): note = True; continue    # Creo goes on in comments
        elif note: note = raw.rstrip().endswith("$"); continue
        else: s = raw.split("$$")[0].rstrip()
        if first is None: first = n
        if s.endswith("$") and not (word and word.group(1) in TEXT and not cur):
            cur += s[:-1]; continue
        cur += s
        if cur.strip(): out.append((first, n, cur.strip()))
        cur, first = "", None
    if cur.strip(): out.append((first, n, cur.strip()))
    return out


class Apt:
    def __init__(self, file):
        self.file, self.pos, self.unit, self.rapid, self.feed, self.moves = file, None, 1.0, False, None, []
        self.known = 0.0                            # mm to which pos is: posts round the end of a circle and its radius apart
        self.axis, self.multax, self.arc, self.dirv, self.cycle, self.msys, self.line = (0.0, 0.0, 1.0), False, None, None, None, None, 0
        self.moved = False
    def no(self, why): raise Refused(self.file, self.line, why)
    def put(self, kind, end, c=None, turn=None, loose=False):
        ax = None if norm(sub(self.axis, (0, 0, 1))) < 1e-9 else self.axis
        m = Move(kind, self.file, self.line, tuple(end), ax, c, turn, None if kind == "rapid" else self.feed, known=self.known)
        if loose: m.loose = True
        self.moves.append(m); self.pos = tuple(end)

    def nums(self, s, n=None):
        v = []
        for t in s.split(","):
            t = t.strip()
            if not re.fullmatch(NUM, t): self.no("number expected: " + t)
            v.append(float(t.upper().replace("D", "E")))
        if n is not None and len(v) not in n: self.no("%d numbers" % len(v))
        return v

    def swept(self, c, k, r, end, times=None, deg=None):
        """The arc from pos about k (unit, right-handed) through c to end; times: that many passes of the end's angle."""
        a, b = sub(self.pos, c), sub(end, c)
        ra, rb = along(a, k, -dot(a, k)), along(b, k, -dot(b, k))
        if abs(norm(ra)-r) > 0.02 or abs(norm(rb)-r) > 0.02: self.no("arc: %.4f and %.4f mm from the centre, radius %.4f" % (norm(ra), norm(rb), r))
        ang = math.atan2(dot(cross(ra, rb), k), dot(ra, rb)) % (2*math.pi)
        whole = norm(sub(ra, rb)) < 1e-4 + 2*self.known or ang < 1e-7
        ang = (2*math.pi if whole else ang) + 2*math.pi*((times or 1)-1)
        if deg is not None and abs(math.degrees(ang)-deg) > 0.01:
            if abs(deg-360) < 1e-6 and whole: pass
            else: self.no("ANGLE %g, but the end is at %g" % (deg, math.degrees(ang)))
        centre = along(c, k, dot(a, k))
        self.put("arc", end, centre, tuple(x*ang for x in k))

    def goto(self, end, axis=None):
        if axis is not None:
            if abs(norm(axis)-1) > 1e-3: self.no("tool axis of length %g" % norm(axis))
            self.axis = unit(axis)
        elif not self.multax and self.moved is None: pass
        if self.cycle and self.cycle != "off": return self.hole(end)
        if self.arc:
            if self.pos is None: self.no("arc from an unknown place")
            c, k, r, t, d = self.arc
            self.arc, self.rapid = None, False
            return self.swept(c, k, r, end, t, d)
        kind = "rapid" if self.rapid else "line"
        self.rapid = False                                   # ISO 5.42
        self.put(kind, end)

    def hole(self, end):
        c, up = self.cycle, self.axis
        self.rapid = False
        top = along(end, up, c["clear"])
        if self.pos is None or norm(sub(self.pos, top)) > 1e-9:
            if self.pos is not None:                          # over the hole at the height where the tool is, then down
                h = dot(sub(self.pos, top), up)
                over = along(top, up, max(h, 0.0))
                if norm(sub(over, self.pos)) > 1e-9: self.put("rapid", over, loose=True)
            if norm(sub(self.pos or (9e9,)*3, top)) > 1e-9: self.put("rapid", top, loose=True)
        bottom = along(end, up, -c["depth"])
        old, self.feed = self.feed, c["feed"] or self.feed
        if c["depth"]: self.put("line", bottom)
        back = along(end, up, c["back"] if c["back"] is not None else c["clear"])
        if c["up"]: self.put("line", top, loose=True)
        if norm(sub(self.pos, back)) > 1e-9: self.put("rapid", back, loose=True)
        self.feed = old

    def cycle_set(self, s):
        w = [t.strip().upper() for t in s.split(",")]
        if w[0] in ("OFF", "INIT", "CLEAR"): self.cycle = None; return
        if w[0] == "ON": self.no("CYCLE/ON")
        if w[0] not in ("DRILL", "DEEP", "BRKCHP", "CSINK", "FACE", "REAM", "BORE", "TAP", "THRU", "DEEP2"): self.no("CYCLE/" + w[0])
        up = w[0] in ("TAP", "REAM", "BORE")
        v = {}
        i = 1
        if len(w) > 1 and re.fullmatch(NUM, w[1]):            # Creo's fixed order: z, f, units, t, r, i ; CATIA's differs
            self.no("CYCLE with numbers by their place")
        while i < len(w):
            if w[i] in ("DEPTH", "FEDTO", "CLEAR", "RAPTO", "RETURN", "RTRCTO", "STEP", "DWELL", "1STPECK", "SUBPECK", "INCR", "MMPM", "IPM", "MMPR", "IPR", "TPI", "ORIENT"):
                if i+1 < len(w) and w[i+1] == "AUTO": v[w[i]] = None
                elif i+1 < len(w) and re.fullmatch(NUM, w[i+1]): v[w[i]] = float(w[i+1])
                else: self.no("CYCLE: value of " + w[i])
                i += 2
            elif w[i] in ("DEEP", "BRKCHP") and i == 1: i += 1
            else: self.no("CYCLE: " + w[i])
        u = self.unit
        if "DEPTH" in v: d = v["DEPTH"]*u
        elif "FEDTO" in v: d = abs(v["FEDTO"])*u
        else: self.no("CYCLE without a depth")
        if d < 0: self.no("CYCLE with a depth of %g" % d)
        clear = v.get("CLEAR", v.get("RAPTO"))
        if clear is None: self.no("CYCLE without CLEAR or RAPTO")
        if "CLEAR" in v and "RAPTO" in v: self.no("CYCLE with CLEAR and RAPTO")
        b = v.get("RTRCTO", v.get("RETURN"))
        if "RETURN" in v and v["RETURN"] == 0: self.no("RETURN 0: the retract plane is not in the file")
        f = v.get("MMPM", v.get("IPM", None))
        if f is not None and "IPM" in v: f *= 25.4
        self.cycle = {"depth": d, "clear": clear*u, "back": None if b is None else b*u, "up": up, "feed": f}

    def tlon(self, s):
        """CATIA's arc: INDIRV/ tangent, TLON,GOFWD/(CIRCLE/c,r) or (CYLNDR/c,axis,r), ON[,2,INTOF], (LINE/c,end) or planes through the end."""
        s = re.sub(r"\s+", "", s).upper()
        if self.pos is None or self.dirv is None: self.no("TLON without a start or INDIRV")
        m = re.match(r"\(CIRCLE/([^()]*)\),ON,(2,INTOF,)?\(LINE/([^()]*)\)$", s)
        if m:
            v = [x*self.unit for x in self.nums(m.group(1), (4,))]
            l = [x*self.unit for x in self.nums(m.group(3), (6,))]
            c, r, k0 = tuple(v[:3]), v[3], (0.0, 0.0, 1.0)
            a, e = tuple(l[:3]), tuple(l[3:])
            second = bool(m.group(2))
        else:
            m = re.match(r"\(CYLNDR/([^()]*)\),ON,(2,INTOF,)?\(PLANE/PERPTO,\(PLANE/\(POINT/[^()]*\),PERPTO,\(VECTOR/[^()]*\)\),\(POINT/([^()]*)\),\(POINT/([^()]*)\)\)$", s)
            if not m: self.no("TLON of another kind")
            v = self.nums(m.group(1), (7,))
            c, k0, r = tuple(x*self.unit for x in v[:3]), unit(v[3:6]), v[6]*self.unit
            a = tuple(x*self.unit for x in self.nums(m.group(3), (3,))); e = tuple(x*self.unit for x in self.nums(m.group(4), (3,)))
            second = bool(m.group(2))
        p = sub(self.pos, c); p = along(p, k0, -dot(p, k0))
        t = dot(cross(k0, p), self.dirv)
        if abs(t) < 1e-3*norm(p): self.no("INDIRV does not lead along the circle")
        k = k0 if t > 0 else tuple(-x for x in k0)
        q = sub(e, c); q = along(q, k0, -dot(q, k0))
        if norm(sub(sub(a, c), tuple(k0[i]*dot(sub(a, c), k0) for i in range(3)))) > 0.01: self.no("the line of ON does not begin at the centre")
        ang = math.atan2(dot(cross(p, q), k), dot(p, q)) % (2*math.pi)
        if norm(sub(p, q)) < 1e-4 + 2*self.known or ang < 1e-7: ang = 2*math.pi
        if (ang > math.pi+1e-6) != second and abs(ang-math.pi) > 1e-6: self.no("ON stops at the other crossing: %.3f degrees%s" % (math.degrees(ang), " with 2,INTOF" if second else ""))
        end = along(along(c, q, r/norm(q)), k0, dot(sub(self.pos, c), k0))
        self.dirv, self.rapid = None, False
        self.swept(c, k, r, end)
        self.known = self.moves[-1].known = abs(norm(q) - r)

    def one(self, a, b, s):
        self.line = b
        m = re.match(r"([A-Za-z][A-Za-z0-9_\-]*(?:\s+PATH)?)\s*(,\s*GOFWD\s*)?(/|$|\s)\s*(.*)$", s, re.S | re.I)
        if not m: self.no("not a statement: " + s)
        w, rest = m.group(1).upper(), m.group(4).strip()
        if m.group(2): w += ",GOFWD"
        if w == "FINI": return True
        if w == "TOOL PATH" or w in QUIET or w.startswith("CSI_"): return
        if w in ("UNITS", "UNIT"):
            self.unit = {"MM": 1.0, "INCHES": 25.4, "INCH": 25.4, "IN": 25.4}.get(rest.upper()) or self.no("UNITS/" + rest)
        elif w == "RAPID": self.rapid = True
        elif w == "FEDRAT":
            self.rapid = False
            t = [x.strip().upper() for x in rest.split(",")]
            n = [x for x in t if re.fullmatch(NUM, x)]
            k = [x for x in t if x not in n]
            if len(n) != 1: self.no("FEDRAT/" + rest)
            f = float(n[0])
            self.feed = f*25.4 if "IPM" in k else f if not k or "MMPM" in k or "PERMIN" in k and self.unit == 1 else f*25.4 if "PERMIN" in k else None
        elif w == "MULTAX": self.multax = rest.upper() != "OFF"
        elif w == "TLAXIS": self.axis = unit(self.nums(rest, (3,)))
        elif w == "FROM":
            v, self.known = self.nums(rest, (3, 6)), 0.0
            self.pos = tuple(x*self.unit for x in v[:3])
            if len(v) == 6: self.axis = unit(v[3:])
        elif w == "GOTO":
            v, self.known = self.nums(rest, (3, 6)), 0.0
            self.goto(tuple(x*self.unit for x in v[:3]), tuple(v[3:]) if len(v) == 6 else None)
        elif w == "GODLTA":
            v = self.nums(rest, (3, 6))
            if self.pos is None: self.no("GODLTA from an unknown place")
            if self.cycle: self.no("GODLTA in a cycle")
            self.goto(along(self.pos, v[:3], self.unit), tuple(v[3:]) if len(v) == 6 else None)
        elif w == "MOVARC":
            t = re.sub(r"\s+", "", rest).upper()
            m = re.match(r"(.*),ANGLE,(%s)$" % NUM, t)
            if not m: self.no("MOVARC/" + rest)
            v = self.nums(m.group(1), (7,))
            self.arc = (tuple(x*self.unit for x in v[:3]), unit(v[3:6]), v[6]*self.unit, None, float(m.group(2)))
        elif w == "CIRCLE":
            t = re.sub(r"\s+", "", rest).upper()
            times = None
            m = re.match(r"(.*),TIMES,(\d+)$", t)
            if m: t, times = m.group(1), int(m.group(2))
            v = self.nums(t, (6, 7, 11))
            c, k = tuple(x*self.unit for x in v[:3]), unit(v[3:6])
            if len(v) == 11: k = tuple(-x for x in k)                                  # NX; else Creo, CAMWorks
            if self.pos is None: self.no("arc from an unknown place")
            p = sub(self.pos, c)
            self.arc = (c, k, v[6]*self.unit if len(v) > 6 else norm(along(p, k, -dot(p, k))), times, None)
        elif w == "GOHOME":
            v = self.nums(rest, (3, 6))
            self.rapid = True; self.goto(tuple(x*self.unit for x in v[:3]), tuple(v[3:]) if len(v) == 6 else None)
        elif w == "CSYS":
            v = self.nums(rest, (12,))
            if self.msys and tuple(v) != self.msys: self.no("another CSYS")
            self.msys = tuple(v)
        elif w == "TRNTYP":
            if re.sub(r"\s", "", rest.upper()) != "WORLD,0,0,0": self.no("TRNTYP/" + rest)
        elif w == "INDIRV": self.dirv = unit(self.nums(rest, (3,)))
        elif w == "PSIS": pass
        elif w == "TLON,GOFWD": self.tlon(rest)
        elif w == "CYCLE": self.cycle_set(rest)
        elif w == "CUTCOM":
            if rest.upper() != "OFF": self.no("CUTCOM/" + rest)
        elif w == "MSYS":
            v = tuple(self.nums(rest, (9, 12)))
            if self.msys and v != self.msys: self.no("another MSYS")
            self.msys = v
        else: self.no("not followed: " + w)
        if self.arc and w not in ("CIRCLE", "MOVARC", "FEDRAT", "PAINT", "SPINDL"): self.no("arc without its end")


def run(files, main, options):
    r = Apt(main)
    for a, b, s in statements(files[main].decode("utf-8", "replace")):
        if r.one(a, b, s): break
    return r.moves


# ---------- programs
class Gen:
    def __init__(self, seed):
        q = self.q = random.Random(seed)
        self.kind = q.choice(["nx", "nx", "nx", "catia", "catia", "catia", "creo", "creo", "fusion", "camworks"])
        self.inch = q.random() < 0.15
        self.dec = {"nx": 4, "catia": 5, "creo": 10, "fusion": 4, "camworks": 4}[self.kind]
        if self.kind == "creo" and q.random() < .5: self.dec = 6
        self.multax = self.kind in ("catia", "creo", "fusion") and q.random() < .35
        self.o = []
        self.pos = None
        self.slash = q.choice(["/", "/ ", " / "]) if self.kind == "creo" else q.choice(["/", "/ ", "/  "]) if self.kind == "catia" else "/"
    def v(self, x):
        x = round(x/(25.4 if self.inch else 1), self.dec)
        t = "%.*f" % (self.dec, x)
        if self.kind == "camworks": t = t.rstrip("0"); t = "0" if t in ("0.", "-0.") else t
        return "0" if x == 0 and self.kind == "camworks" else "0.%s" % ("0"*self.dec) if x == 0 else t
    def r(self, a, b): return round(self.q.uniform(a, b), self.q.choice([0, 1, 3]))
    def put(self, s): self.o.append(s)
    def pt(self, p):
        j = ",    " if self.kind == "catia" else ", " if self.kind == "creo" else ","
        return j.join(self.v(x) for x in p)
    def goto(self, p, ijk=False):
        s = "GOTO" + self.slash + self.pt(p)
        if self.multax or ijk:
            tail = ",0.000000,0.000000,1.000000" if self.kind != "creo" else ", 0.0000000000, 0.0000000000, 1.0000000000"
            if self.q.random() < .15 or self.kind == "creo" and self.dec == 10: s += ", $\n" + tail.lstrip(", ")
            else: s += tail
        self.put(s); self.pos = tuple(p)
    def rapid(self, p, ijk=False): self.put("RAPID/" if self.kind == "camworks" else "RAPID"); self.goto(p, ijk)
    def feed(self):
        f = self.q.choice([200, 350.5, 800, 1200])
        u = "IPM" if self.inch else "MMPM"
        f = f/25.4 if self.inch else f
        self.put({"nx": "FEDRAT/%s,%.4f" % (u, f), "catia": "FEDRAT/ %.4f,%s" % (f, u), "creo": "FEDRAT / %.6f,  %s" % (f, u), "fusion": "FEDRAT/%g, %s" % (round(f, 4), u), "camworks": "FEDRAT/%.4f,%s" % (f, u)}[self.kind])
    def header(self, seed):
        q, k = self.q, self.kind
        if k == "nx":
            self.put("TOOL PATH/%s_%d,TOOL,%s" % (q.choice(["CAVITY_MILL", "PLANAR_MILL", "FINISH-WALLS", "op one"]), seed, q.choice(["MILL_D10R0", "D10-ALU", "T_12"])))
            self.put("TLDATA/MILL,10.0000,0.0000,75.0000,0.0000,0.0000")
            self.put("MSYS/0.0000,0.0000,0.0000,1.0000000,0.0000000,0.0000000,0.0000000,1.0000000,0.0000000")
            if self.inch or q.random() < .3: self.put("UNITS/" + ("INCHES" if self.inch else "MM"))
            self.put("$$ centerline data"); self.put("PAINT/PATH"); self.put("PAINT/SPEED,10")
            if q.random() < .5: self.put("LOAD/TOOL,%d,ADJUST,%d" % (seed % 20+1, seed % 20+1)); self.put("SPINDL/RPM,3600,CLW")
        elif k == "catia":
            self.put("$$ -----------------------------------------------------------------")
            self.put("$$     Generated on %d" % seed); self.put("PARTNO PART_TO_BE_MACHINED"); self.put("COOLNT/ON")
            if q.random() < .5: self.put("$$*CATIA0\n$$Manufacturing Program.1\n$$   1.00000   0.00000   0.00000   0.00000\n$$   0.00000   1.00000   0.00000   0.00000\n$$   0.00000   0.00000   1.00000   0.00000")
            self.put("UNITS/" + ("INCHES" if self.inch else "MM"))
            if q.random() < .5: self.put("CUTTER/ 10.000000,  2.000000,  3.000000,  2.000000,  0.000000,$\n         0.000000, 50.000000\nTOOLNO/1,    10.000000"); self.put("TPRINT/T1 End Mill D 10"); self.put("LOADTL/1")
            self.put("$$ OPERATION NAME : Profile Contouring.%d" % (seed % 9)); self.put("SPINDL/ 3000.0000,RPM,CLW")
        elif k == "creo":
            self.put("$$* Pro/CLfile  Version Creo"); self.put("$$-> MFGNO / MFG%04d" % (seed % 1000)); self.put("PARTNO / MFG%04d" % (seed % 1000)); self.put("$$-> FEATNO / 17")
            self.put("MACHIN / UNCX01, 1"); self.put("$$-> CUTCOM_GEOMETRY_TYPE / OUTPUT_ON_CENTER"); self.put("UNITS / " + ("INCHES" if self.inch else "MM"))
            self.put("LOADTL / 1"); self.put("$$-> CUTTER / 10.000000"); self.put("$$-> CSYS / 1.0000000000, 0.0000000000, 0.0000000000, 0.0000000000, $\n         0.0000000000, 1.0000000000, 0.0000000000, 0.0000000000, $\n         0.0000000000, 0.0000000000, 1.0000000000, 0.0000000000"); self.put("SPINDL / RPM, 3000.000000,  CLW")
        elif k == "camworks":
            self.put("PARTNO/%d" % seed); self.put("UNIT/" + ("INCHES" if self.inch else "MM")); self.put("INSERT/[HOLDER=C40-32ERP412] 12MM EM"); self.put("CUTTER/12.,0,6.,3.605164,31.,0,149.")
            self.put("LOAD/TOOL,15"); self.put("CSI_SET_FLUTE_LENGTH/15."); self.put("SPINDL/1334,RPM,CLW"); self.put("TRNTYP/WORLD,0,0,0"); self.put("CSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0")
        else:
            self.put("PARTNO/%d" % seed); self.put("MACHIN/" + q.choice(["FANUC", "IRBCAM"])); self.put("UNITS/" + ("INCHES" if self.inch else "MM")); self.put("LOADTL/1"); self.put("SPINDL/RPM,5000,CLW")
        if self.multax: self.put("MULTAX" + q.choice(["/ON", ""]) if k == "creo" else q.choice(["MULTAX", "MULTAX/ON"]))
    def arc(self):
        """An arc of the dialect's own from where the tool is."""
        q = self.q
        x, y, z = self.pos
        R = q.choice([3, 5.5, 10, 20]); a0 = math.radians(q.choice([0, 90, 180, 270, q.uniform(0, 360)]))
        sense = q.choice([1, -1]); sw = math.radians(q.choice([90, 180, 270, 360, q.uniform(20, 340)]))
        c = (x-R*math.cos(a0), y-R*math.sin(a0), z)
        e = (c[0]+R*math.cos(a0+sense*sw), c[1]+R*math.sin(a0+sense*sw), z)
        full = abs(sw-2*math.pi) < 1e-9
        if full: e = (x, y, z)
        if abs(e[0]) > 200 or abs(e[1]) > 200: return
        k = self.kind
        if k == "catia":
            if abs(sw-math.pi) < 1e-6: return
            d = (-sense*math.sin(a0), sense*math.cos(a0), 0.0)
            self.put("AUTOPS"); self.put("INDIRV/ %.5f,    %.5f,    %.5f" % d)
            second = sw > math.pi
            line = "(LINE/ %s, %s)" % (self.pt(c), self.pt(e))
            if second: self.put("TLON,GOFWD/ (CIRCLE/ %s,$\n         %s),ON,2,INTOF,$\n         %s" % (self.pt(c), self.v(R), line))
            else: self.put("TLON,GOFWD/ (CIRCLE/ %s,$\n         %s),ON,%s" % (self.pt(c), self.v(R), line))
            # where CATIA's circle ends, by its rounded numbers, is found by the interpreter
            self.pos = e
            return
        rise = q.random() < .2
        if rise: e = (e[0], e[1], z-q.choice([0.5, 1, 3]))
        if k == "nx":
            t = ""
            if rise and q.random() < .5: t = ",TIMES,%d" % q.randint(1, 3)
            self.put("CIRCLE/%s,0.0000000,0.0000000,%.7f,%s,0.0060,0.5000,10.0000,0.0000%s" % (self.pt(c), -sense, self.v(R), t))
            self.goto(e)
        elif k == "camworks":
            if rise: return
            self.put("CIRCLE/%s,0,0,%d." % (self.pt(c), sense)); self.goto(e)
        elif k == "creo":
            self.put("CIRCLE%s%s, $\n0.0000000000, 0.0000000000, %.10f, %s" % (self.slash, self.pt(c), sense, self.v(R)))
            self.goto(e)
        else:
            self.put("MOVARC/%s, 0, 0, %d, %s, ANGLE, %.6f" % (self.pt(c), sense, self.v(R), math.degrees(sw)))
            self.goto(e)
    def cycle(self):
        q, k = self.q, self.kind
        u = "IPM" if self.inch else "MMPM"
        t = q.choice(["DRILL", "DRILL", "DEEP", "TAP", "BORE", "REAM"])
        f = 250/25.4 if self.inch else 250.0
        d, c = self.r(4, 20), q.choice([2, 3, 5])
        x, y = self.r(-80, 80), self.r(-80, 80)
        self.rapid((x, y, 30))
        if k == "nx":
            self.put("CYCLE/%s,RAPTO,%s,FEDTO,%s,RTRCTO,%s,%s,%.4f" % ("DRILL" if t == "DEEP" else t, self.v(c), self.v(-d), q.choice(["AUTO", self.v(c)]), u, f))
        elif k == "camworks":
            self.put("CYCLE/INIT")
            self.put("CYCLE/%s,FEDTO,%s,%s%s,%.6f,RAPTO,%s,RTRCTO,%s%s" % ("DEEP2" if t == "DEEP" else "DRILL", self.v(d), "1STPECK,%s,SUBPECK,%s," % (self.v(4), self.v(2)) if t == "DEEP" else "", u, f, self.v(c), self.v(25), "" if t == "DEEP" else ",DWELL,0"))
        else: self.put("CYCLE%s%s, DEPTH, %s, %s%s, %.6f, CLEAR, %s" % (self.slash, t, self.v(d), "STEP, %s, " % self.v(2) if t == "DEEP" else "", u, f, self.v(c)))
        for i in range(q.randint(1, 5)):
            self.goto((x, y, 0) if i == 0 else (self.r(-80, 80), self.r(-80, 80), 0))
        self.put("CYCLE%sOFF" % self.slash)
        self.rapid((self.pos[0], self.pos[1], 40))
    def build(self, seed):
        q = self.q
        self.header(seed)
        if q.random() < .25: self.put("FROM" + self.slash + self.pt((0, 0, 100)))
        x, y = self.r(-80, 80), self.r(-80, 80)
        self.rapid((x, y, 50), ijk=self.kind == "nx" and q.random() < .5)
        n = q.randint(2, 4)
        for part in range(n):
            if q.random() < .3: self.put(q.choice(["$$ next pass", "PPRINT/ROUGH $ PASS", "COOLNT/FLOOD" if self.kind != "creo" else "COOLNT / ON", "INSERT M08" if self.kind != "nx" else "PAINT/COLOR,31", "STOP", "OPSTOP", "CUTCOM/OFF", "DELAY/2.0"]))
            if q.random() < .25 and not self.multax: self.cycle(); continue
            x, y = self.r(-80, 80), self.r(-80, 80)
            self.rapid((x, y, 30)); self.rapid((x, y, 3)) if q.random() < .6 else None
            self.feed(); self.goto((x, y, self.r(-10, -1)))
            for _ in range(q.randint(3, 9)):
                u = q.random()
                if u < .35 and not self.multax and (self.kind != "camworks" or not self.inch): self.arc()
                elif u < .5 and self.kind != "fusion":
                    d = (self.r(-15, 15), self.r(-15, 15), q.choice([0, 0, self.r(-1, 1)]))
                    if abs(self.pos[0]+d[0]) > 180 or abs(self.pos[1]+d[1]) > 180 or d == (0, 0, 0): continue
                    self.put("GODLTA" + self.slash + self.pt(d)); self.pos = tuple(a+b for a, b in zip(self.pos, d))
                    p = (self.r(-80, 80), self.r(-80, 80), self.r(-10, -1)); self.goto(p)
                else:
                    self.goto((self.r(-80, 80), self.r(-80, 80), self.pos[2] if q.random() < .7 else self.r(-10, -1)))
                if q.random() < .08: self.feed()
                if self.kind == "nx" and q.random() < .1: self.put("PAINT/COLOR,%d" % q.randint(1, 211))
            self.rapid((self.pos[0], self.pos[1], 40))
        self.rapid((self.pos[0], self.pos[1], 80))
        if self.multax: self.put("MULTAX/OFF" if self.kind != "creo" else "MULTAX / OFF")
        self.put("SPINDL/OFF" if self.kind != "creo" else "SPINDL / OFF")
        if self.kind == "nx": self.put("PAINT/SPEED,10"); self.put("PAINT/TOOL,NOMORE"); self.put("END-OF-PATH")
        if self.kind != "nx" or q.random() < .3: self.put("FINI" if q.random() < .8 or self.kind == "nx" else "REWIND\nEND\nFINI")
        nl = q.choice(["\n", "\r\n"])
        text = "\n".join(self.o)+"\n"
        if q.random() < .05: text = text.lower()
        ext = {"nx": "cls", "catia": q.choice(["apt", "aptsource"]) if False else "apt", "creo": "ncl", "fusion": q.choice(["apt", "cl"]), "camworks": "apt"}[self.kind]
        name = "part." + ext
        return {name: text.replace("\n", nl).encode()}, name, {"gcode": {"decimals_inch": 8}}


def generate(seed):
    for k in range(50):
        f, m, o = Gen(seed*64+k).build(seed)
        try: mv = run(f, m, o)
        except Refused: continue
        if len(mv) > 8 and all(max(map(abs, x.end)) <= 300 for x in mv): return f, m, o
    raise RuntimeError("no program for seed %d" % seed)


def rows(text): return [(m.kind, m.line, tuple(round(c, 4)+0.0 for c in m.end)) for m in run({"a": text.encode()}, "a", {})]


def selftest(n=2000):
    A = "UNITS/MM\nRAPID\nGOTO/0,0,10\nGOTO/1,2, $\n  3\n"
    assert rows(A) == [("rapid", 3, (0, 0, 10)), ("line", 5, (1, 2, 3))]
    m = run({"a": (A+"CIRCLE/1,12,3,0,0,-1,10\nGOTO/11,12,3\nCIRCLE/1,12,3,0,0,1,10,.1,.5,10,0,TIMES,2\nGOTO/11,12,1\n").encode()}, "a", {})
    assert [round(math.degrees(x.turn[2]), 6) for x in m[2:]] == [-270, -720], m
    t = A+"INDIRV/1,0,0\nTLON,GOFWD/(CIRCLE/1,12,3,$\n10),ON,(LINE/1,12,3,11,12,3)\nINDIRV/ 0,1,0\nTLON,GOFWD/ (CIRCLE/ 1,12,3, 10),ON,2,INTOF,$\n (LINE/1,12,3,1,2,3)\n"
    m = run({"a": t.encode()}, "a", {})
    assert [(tuple(round(c, 6) for c in x.end), round(math.degrees(x.turn[2]), 6)) for x in m[2:]] == [((11, 12, 3), 90), ((1, 2, 3), 270)], m
    m = run({"a": (A+"MOVARC/1,12,3,0,0,1,10,ANGLE,90\nGOTO/11,12,2\n").encode()}, "a", {})
    assert round(math.degrees(m[2].turn[2]), 6) == 90 and m[2].end == (11, 12, 2)
    assert rows(A+"GODLTA/1,1,1\nRAPID\nGODLTA/0,0,5\n")[2:] == [("line", 6, (2, 3, 4)), ("rapid", 8, (2, 3, 9))]
    assert rows("UNITS/INCHES\nFROM/0,0,1\nGODLTA/1,0,0\n") == [("line", 3, (25.4, 0, 25.4))]
    assert rows(A+"CYCLE/DRILL,DEPTH,5,MMPM,100,CLEAR,2\nGOTO/9,9,0\nGOTO/9,8,0\nCYCLE/OFF\nGOTO/0,0,9\n")[2:] == [
        ("rapid", 7, (9, 9, 3)), ("rapid", 7, (9, 9, 2)), ("line", 7, (9, 9, -5)), ("rapid", 7, (9, 9, 2)), ("rapid", 8, (9, 8, 2)), ("line", 8, (9, 8, -5)), ("rapid", 8, (9, 8, 2)), ("line", 10, (0, 0, 9))]
    m = run({"a": b"MULTAX\nRAPID\nGOTO/0,0,10,0,0.6,0.8\nGOTO/1,0,0,0,0,1\n"}, "a", {})
    assert m[0].axis_or_rotation == (0, 0.6, 0.8) and m[1].axis_or_rotation is None
    for bad in ("CUTCOM/LEFT,1\n", "GOTO/1,2\n", "CYCLE/DRILL,10,5\n", "CIRCLE/0,0,0,0,0,1,99\nGOTO/1,1,1\n"):
        try: rows(A+bad)
        except Refused: pass
        else: raise AssertionError(bad)
    seen, moves, arcs, kinds = set(), 0, 0, {}
    for s in range(n):
        f, main, o = generate(s)
        assert f[main] not in seen; seen.add(f[main])
        mv = run(f, main, o)
        at = None
        for m in mv:
            if m.kind == "arc":
                r = [norm(along(sub(p, m.centre), unit(m.turn), -dot(sub(p, m.centre), unit(m.turn)))) for p in (at, m.end)]
                assert abs(r[0]-r[1]) < 0.01 and r[0] > 0.9, (s, m, r)
                arcs += 1
            at = m.end
        moves += len(mv); kinds[main[5:]] = kinds.get(main[5:], 0)+1
    print("ok: %d programs %s, %d moves, %d arcs" % (n, kinds, moves, arcs))


if __name__ == "__main__":
    selftest(int(sys.argv[1]) if len(sys.argv) > 1 else 2000)
