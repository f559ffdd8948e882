"""Five axes: a second implementation of heads and tables, of tip control and of tilted planes.

Kinematics.  A machine has linear axes that carry the head (or the table; only the relative place counts) and two turning
axes, each of a head or of a table.  An axis is (letter, kind, direction, point): what it turns turns right-handed about the
direction by the programmed angle.  With all axes at 0 the tip stands at the programmed X, Y, Z of W, the tool along z of W.
Points of tables are given in W, points of heads from the tip (pivot).  Axes are listed from the base outwards.
  tip in the machine   m = (X, Y, Z) + Rot(h1,p1) Rot(h2,p2) 0          direction in the machine  R(h1) R(h2) z
  in the workpiece     w = (Rot(t1,q1) Rot(t2,q2))^-1 m                  direction  (R(t1) R(t2))^-1 R(h1) R(h2) z

Rules looked up (search corpus `pages`):
  G53.1 choice        FANUC 16i/18i-MB operator's manual B-63534, page shown as 1380 (cncmanuals.com/fanuc/430): two heads or two tables:
                      least move of the master (first) axis, then of the slave, then master nearest to 0, then slave nearest to 0;
                      mixed: least move of the table, then of the tool's axis (the page is cut off there; the rest as before)
  G68.2 format        FANUC 30i descriptions B-63942EN/02 p. 248: X Y Z origin, I J K Euler angles, G53.1 aims the tool, G69 ends
  PLANE SPATIAL       HEIDENHAIN TNC 620 manual 10/2017 p. 540: about the fixed axes A, then B, then C (the same as C, B, A about moved ones)
  SEQ                 HEIDENHAIN iTNC 530 DIN/ISO 6/2010 p. 404 (table of A-C table: SPB+45 gives A+45 C+90 or A-45 C-90; SEQ is the sign of A;
                      without SEQ the one within the limits that is nearer; from A0 C0 it is A+45 C+90; SEQ into a limit is an error)
  CYCLE800 _DIR       SINUMERIK 828D/840D operating manual milling 08/2018, 10.6, p. 636: minus: lower value of the axis of the
                      direction reference, plus: the higher one; if it cannot be reached the other one is taken
  CYCLE800 axis order SINUMERIK 828D 01/2015 p. 559 (axis by axis, projection, direct) and HiNC NcArgCycle800 (bits 0-1, 2-3, 4-5 of MODE
                      name the axes of A, B, C: 1 X, 2 Y, 3 Z; bits 6-7: 0 axis by axis)
  PLANE EULER         HEIDENHAIN iTNC 530 DIN/ISO 6/2010 p. 392: EULPR about z, EULNU about x turned by it, EULROT about z turned by both
  PLANE VECTOR        HEIDENHAIN iTNC 530 p. 500, TNC 620 10/2017 p. 548: B gives x, N gives z, of any length
  PLANE POINTS        HEIDENHAIN TNC 620 10/2017 p. 549: x from point 1 to 2, y towards point 3; the datum stays
  PLANE RELATIV       HEIDENHAIN TNC7 basic 81762x-19: one angle about an axis of the plane in force, or of W
  PLANE AXIAL         HEIDENHAIN iTNC 530 DIN/ISO 6/2010 p. 404: COORD ROT and TABLE ROT do nothing; here for one axis across z
  CYCLE800 64         HiNC NcArgCycle800: solid angle, A about z and B about y; that y is the new one was not looked up
  rotary axis 1       SINUMERIK 840D sl commissioning manual 21.7.2: carries axis 2; of mixed ones that of the tool
  G68.3               FANUC 30i A-79976E p. 4 (z along the tool, x = P x z); not used in `run`
  LinuxCNC            src/emc/kinematics at 5c41560e (see LINUXCNC below; numbers only)
Not looked up (as known):
  G68.2 I J K are turns about z, then the new x, then the new z (Fanuc's figure was not in the stored text; two forum answers
  contradict it, they describe G68 with I J K 1/0).  G43.4/G49, TRAORI/TRAFOOF, M128/M129: X Y Z of the tip in the table's W.
  CYCLE800 axis by axis turns about the axes as turned so far; A is turned first.  Projection angles are refused.
  SEQ on heads and mixed machines: the sign of the axis nearest to the tool; of its whole turns the one nearest to 0, as else each pair
  could have either sign.
  PLANE ... MOVE/TURN/STAY: the coordinates of the tip in W after the turn are not followed until a full position is given.
"""
import math, random, re, sys
from move import Move, Refused
EPS = 1e-9

# ---------- vectors
def dot(a, b): return a[0]*b[0] + a[1]*b[1] + a[2]*b[2]
def cross(a, b): return (a[1]*b[2]-a[2]*b[1], a[2]*b[0]-a[0]*b[2], a[0]*b[1]-a[1]*b[0])
def add(a, b): return (a[0]+b[0], a[1]+b[1], a[2]+b[2])
def sub(a, b): return (a[0]-b[0], a[1]-b[1], a[2]-b[2])
def mul(a, s): return (a[0]*s, a[1]*s, a[2]*s)
def norm(a): return math.sqrt(dot(a, a))
def unit(a): n = norm(a); return (a[0]/n, a[1]/n, a[2]/n)
def turn(v, axis, deg):
    """v turned right-handed about the unit axis (Rodrigues)."""
    r = math.radians(deg); c, s = math.cos(r), math.sin(r)
    return add(add(mul(v, c), mul(cross(axis, v), s)), mul(axis, dot(axis, v)*(1-c)))
Z = (0.0, 0.0, 1.0)


class Axis:
    def __init__(self, letter, kind, about, through=(0.0, 0.0, 0.0), lo=-1e9, hi=1e9):
        self.letter, self.kind, self.about, self.through, self.lo, self.hi = letter, kind, unit(about), tuple(through), lo, hi
    def move(self, p, deg): return add(self.through, turn(sub(p, self.through), self.about, deg))
    def back(self, p, deg): return self.move(p, -deg)


class Machine:
    def __init__(self, name, axes):
        """axes: of each kind from the base outwards; the first of the list is the master."""
        self.name, self.axes = name, axes
        self.heads = [a for a in axes if a.kind == "head"]
        self.tables = [a for a in axes if a.kind == "table"]
    def forward(self, xyz, ang):
        """Axis values -> tip and direction (from the tip to the spindle) in the workpiece."""
        p, d = (0.0, 0.0, 0.0), Z
        for a in reversed(self.heads):
            p, d = a.move(p, ang[a.letter]), turn(d, a.about, ang[a.letter])
        p = add(p, xyz)
        for a in self.tables:
            p, d = a.back(p, ang[a.letter]), turn(d, a.about, -ang[a.letter])
        return p, d
    def linear(self, tip, ang):
        """Axis values X Y Z that bring the tip to `tip` of W while the angles stand."""
        p, h = tip, (0.0, 0.0, 0.0)
        for a in reversed(self.tables):
            p = a.move(p, ang[a.letter])
        for a in reversed(self.heads):
            h = a.move(h, ang[a.letter])
        return sub(p, h)
    def chain(self):
        """Direction = R(u, su*x) R(v, sv*y) z: the outer and the inner turn seen from the workpiece."""
        return [(a, -1.0) for a in reversed(self.tables)] + [(a, 1.0) for a in self.heads]
    def angles(self, d, now):
        """All pairs of angles in (-180, 180] that give the direction d; at a pole the outer one stays. [(angles, pole)]"""
        (u, su), (v, sv) = self.chain()
        d = unit(d)
        # u.d = u.R(v,b)z = k0 + k1 cos b + k2 sin b
        k0 = dot(v.about, u.about) * dot(v.about, Z)
        k1 = dot(u.about, Z) - k0
        k2 = dot(u.about, cross(v.about, Z))
        n, t = math.hypot(k1, k2), dot(u.about, d) - k0
        if n < EPS or abs(t) > n + 1e-9:
            return []
        t = max(-1.0, min(1.0, t/n))
        mid, half = math.atan2(k2, k1), math.acos(t)
        out = []
        for b in ([mid] if half < 1e-7 else [mid+half, mid-half]) if half < math.pi-1e-7 else [mid+math.pi]:
            e = turn(Z, v.about, math.degrees(b))
            eu, du = sub(e, mul(u.about, dot(e, u.about))), sub(d, mul(u.about, dot(d, u.about)))
            pole = norm(du) < 1e-7
            a = now[u.letter] if pole else su*math.degrees(math.atan2(dot(u.about, cross(eu, du)), dot(eu, du)))
            out.append(({u.letter: a if pole else wrap(a), v.letter: wrap(sv*math.degrees(b))}, pole))
        return out
    def within(self, ang):
        return all(a.lo-1e-9 <= ang[a.letter] <= a.hi+1e-9 for a in self.axes)


def wrap(a):
    a = math.fmod(a, 360.0)
    return a-360.0 if a > 180.0 else a+360.0 if a <= -180.0 else a


def near(m, a, now, free):
    """The value of an angle plus whole turns that is nearest to where the axis stands and within its travel."""
    k = round((now-a)/360.0)
    c = [a+360.0*(k+j) for j in (-1, 0, 1)]
    c = [x for x in c if m.lo-1e-9 <= x <= m.hi+1e-9]
    return min(c, key=lambda x: (round(abs(x-now), 9), round(abs(x), 9), -x)) if c else None


def candidates(mach, d, now):
    out = []
    for ang, _ in mach.angles(d, now):
        c = {a.letter: near(a, ang[a.letter], now[a.letter], True) for a in mach.axes}
        if None not in c.values():
            out.append(c)
    return out


def choose_fanuc(mach, d, now):
    """G53.1: see the docstring. None if it cannot be reached."""
    c = candidates(mach, d, now)
    if not c: return None
    first, second = mach.axes
    if first.kind != second.kind and first.kind != "table":
        first, second = second, first
    r = lambda x: round(abs(x), 7)
    return min(c, key=lambda q: (r(q[first.letter]-now[first.letter]), r(q[second.letter]-now[second.letter]),
                                 r(wrap(q[first.letter])), r(wrap(q[second.letter]))))


def choose_heidenhain(mach, d, now, seq):
    master = mach.heads[-1] if mach.heads else mach.tables[0]
    c = candidates(mach, d, {**now, master.letter: 0.0} if seq else now)
    if seq:
        c = [q for q in c if q[master.letter]*seq >= -1e-9]
    r = lambda x: round(x, 7)
    return min(c, key=lambda q: (r(sum(abs(q[a.letter]-now[a.letter]) for a in mach.axes)), -q[master.letter])) if c else None


def choose_siemens(mach, d, now, direction, reference=None):
    """_DIR -1 or +1 of the axis `reference` (of the machine's commissioning; here the first that can tilt)."""
    c = candidates(mach, d, now)
    ref = reference or next(a for a in mach.axes if abs(dot(a.about, Z)) < 0.99).letter
    if direction == 0 and len({round(q[ref], 6) for q in c}) > 1: return None      # swings nothing: angles not known
    return (min if direction < 0 else max)(c, key=lambda q: q[ref]) if c else None


# ---------- planes: columns are the axes of the plane in W
def frame(*turns):
    """R = T1 T2 T3 ... of turns (axis, degrees) about moved axes."""
    cols = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), Z]
    for ax, deg in reversed(turns):
        cols = [turn(c, ax, deg) for c in cols]
    return cols
X_, Y_, Z_ = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
def euler_fanuc(i, j, k): return frame((Z_, i), (X_, j), (Z_, k))
def spatial(a, b, c): return frame((Z_, c), (Y_, b), (X_, a))
def vectors(b, n):
    z = unit(n)
    x = unit(sub(b, mul(z, dot(b, z))))
    return [x, cross(z, x), z]
def points(p, q, r):
    x, v = unit(sub(q, p)), sub(r, p)
    y = unit(sub(v, mul(x, dot(v, x))))
    return [x, y, cross(x, y)]
def across(mach, ang):
    """The plane across the tool, whose x and y turn with the axes."""
    cols = [X_, Y_, Z_]
    for a in reversed(mach.heads): cols = [turn(c, a.about, ang[a.letter]) for c in cols]
    for a in mach.tables: cols = [turn(c, a.about, -ang[a.letter]) for c in cols]
    return cols
def cycle800(mode, a, b, c):
    if mode == 64 and not c: return frame((Z_, a), (Y_, b))
    if mode >> 6: raise ValueError("only axis by axis")
    ax = {1: X_, 2: Y_, 3: Z_}
    return frame((ax[mode & 3], a), (ax[mode >> 2 & 3], b), (ax[mode >> 4 & 3], c))
def into(cols, p): return add(add(mul(cols[0], p[0]), mul(cols[1], p[1])), mul(cols[2], p[2]))


# ---------- ten machines (through: tables in W, heads from the tip)
S = math.sqrt(0.5)
def machines():
    H, T = "head", "table"
    return [
        Machine("head_ca", [Axis("C", H, (0, 0, 1), (0, 0, 250), -360, 360), Axis("A", H, (1, 0, 0), (0, 0, 250), -110, 110)]),
        Machine("head_ca_off", [Axis("C", H, (0, 0, 1), (12, -7, 300), -360, 360), Axis("A", H, (1, 0, 0), (0, 25, 260), -110, 110)]),
        Machine("head_cb", [Axis("C", H, (0, 0, 1), (0, 0, 250), -360, 360), Axis("B", H, (0, 1, 0), (0, 0, 250), -110, 110)]),
        Machine("head_nutating_cb", [Axis("C", H, (0, 0, 1), (0, 0, 320), -360, 360), Axis("B", H, (0, S, S), (0, 0, 280), -180, 180)]),
        Machine("head_nutating_bc", [Axis("B", H, (0, 1, 0), (0, 30, 320), -120, 120), Axis("C", H, (0, -S, S), (0, 30, 260), -360, 360)]),
        Machine("table_ac", [Axis("A", T, (1, 0, 0), (0, 0, -60), -120, 120), Axis("C", T, (0, 0, 1), (0, 0, -60), -720, 720)]),
        Machine("table_bc_off", [Axis("B", T, (0, -1, 0), (15, 0, -95), -110, 110), Axis("C", T, (0, 0, -1), (-4, 8, -60), -720, 720)]),
        Machine("table_nutating_bc", [Axis("B", T, (0, S, S), (0, 0, -40), -180, 180), Axis("C", T, (0, 0, 1), (20, 10, 0), -720, 720)]),
        Machine("mixed_b_c", [Axis("B", H, (0, 1, 0), (0, 0, 220), -110, 110), Axis("C", T, (0, 0, 1), (30, -20, 0), -720, 720)]),
        Machine("mixed_a_c", [Axis("A", H, (1, 0, 0), (0, 18, 240), -110, 110), Axis("C", T, (0, 0, -1), (-15, 5, 0), -720, 720)]),
    ]


# ---------- LinuxCNC's three modules as machines (parameters: their pins)
def linuxcnc_xyzac(xr, yr, zr, dy, dz):
    """conventional_directions false: the table turns right-handed; A through y = yr+dy, z = zr+dz, C through xr, yr."""
    return Machine("xyzac", [Axis("A", "table", (1, 0, 0), (0, yr+dy, zr+dz)), Axis("C", "table", (0, 0, 1), (xr, yr, 0))])
def linuxcnc_xyzbc(xr, yr, zr, dx, dz):
    return Machine("xyzbc", [Axis("B", "table", (0, 1, 0), (xr+dx, 0, zr+dz)), Axis("C", "table", (0, 0, 1), (xr, yr, 0))])
def linuxcnc_5axis(pivot):
    """B turns the other way round (its note 10)."""
    return Machine("5axis", [Axis("C", "head", (0, 0, 1), (0, 0, pivot)), Axis("B", "head", (0, -1, 0), (0, 0, pivot))])


# ---------- machine files of kinetostat for these machines (format: docs/machine_format.md, docs/five_axis.md)
def rpy(cols):
    """roll, pitch, yaw of R = Rz(yaw) Ry(pitch) Rx(roll), given by columns."""
    p = math.asin(max(-1.0, min(1.0, -cols[0][2])))
    if abs(math.cos(p)) < 1e-9:
        return (0.0, math.degrees(p), math.degrees(math.atan2(-cols[1][0], cols[1][1])))
    return tuple(map(math.degrees, (math.atan2(cols[1][2], cols[2][2]), p, math.atan2(cols[0][1], cols[0][0]))))


def aimed(d):
    """(columns of R with R z = d, columns of R^-1)"""
    r, p = -math.asin(max(-1.0, min(1.0, d[1]))), math.atan2(d[0], d[2])
    c = frame((Y_, math.degrees(p)), (X_, math.degrees(r)))
    inv = [(c[0][i], c[1][i], c[2][i]) for i in range(3)]
    return c, inv


def elements(axes, k):
    out, at = [], (0.0, 0.0, 0.0)
    fmt = lambda v: "[" + ", ".join(repr(float(x)) for x in v) + "]"
    for a in axes:
        c, inv = aimed(a.about)
        out.append("  { fixed = { translation_mm = %s, rotation_deg = %s } }," % (fmt(sub(a.through, at)), fmt(rpy(c))))
        lim = "" if a.lo < -1e8 else ", travel_deg = [%r, %r]" % (float(a.lo), float(a.hi))
        out.append("  { revolute_drive = { name = \"%s\", axis = \"z\", stiffness_Nmm_per_rad = %r%s } }," % (a.letter, k, lim))
        out.append("  { fixed = { rotation_deg = %s } }," % fmt(rpy(inv)))
        at = a.through
    if axes:
        out.append("  { fixed = { translation_mm = %s } }," % fmt(mul(at, -1)))
    return out


def toml(mach, stiffness=1000.0):
    o = ['schema = 1', 'name = "%s"' % mach.name, 'title = "five axes, %s"' % mach.name, '[platform]', 'tool_tip_mm = [0.0, 0.0, 0.0]',
         'tool_axis = [0.0, 0.0, -1.0]', 'controls = ["x", "y", "z"]', '[home]', 'position_mm = [0.0, 0.0, 0.0]', '[workspace]',
         'min_mm = [-100000.0, -100000.0, -100000.0]', 'max_mm = [100000.0, 100000.0, 100000.0]', '[[chain]]', 'name = "mill"', 'elements = [']
    for ax in "XYZ":
        o.append('  { prismatic_drive = { name = "%s", axis = "%s", stiffness_N_per_mm = %r, home_mm = 0.0 } },' % (ax, ax.lower(), stiffness))
    o += elements(mach.heads, 1e15) + [']', '[[mount]]', 'name = "mill"', 'chain = "mill"']
    if mach.tables:
        o += ['[[chain]]', 'name = "tables"', 'elements = ['] + elements(mach.tables, 1e15) + [']', '[workpiece_carrier]', 'name = "table"', 'chain = "tables"']
    return "\n".join(o) + "\n"


# ---------- programs
WORD = re.compile(r'([A-Z])\s*(=?)\s*([-+]?(?:\d+\.?\d*|\.\d+))')


class Run:
    def __init__(self, mach, dialect, file):
        self.m, self.dialect, self.file = mach, dialect, file
        self.lin, self.ang = [0.0, 0.0, 0.0], {a.letter: 0.0 for a in mach.axes}
        self.known = [False]*3
        self.tcp, self.plane, self.mode, self.feed, self.moves, self.absolute = False, None, 0, None, [], True
        self.told = {}
        self.chosen = []                                                        # lines and the angles that the control finds there
    def no(self, line, why): raise Refused(self.file, line, why)
    def here(self): return self.m.forward(tuple(self.lin), self.ang)
    def shown(self):
        """The coordinates that the program would have to give to stay."""
        if self.plane:
            o, c = self.plane
            p = sub(self.here()[0], o)
            return tuple(dot(c[i], p) for i in range(3))
        return self.here()[0] if self.tcp else tuple(self.lin)
    def swing(self, ang, keep_tip, line):
        tip = self.here()[0]
        self.ang = dict(ang)
        if keep_tip: self.lin = list(self.m.linear(tip, self.ang))
        if all(self.known): self.put("rapid", line)
    def put(self, kind, line):
        tip, d = self.here()
        m = Move(kind, self.file, line, tip, d, None, None, self.feed)
        m.lin, m.ang, m.tip_led = tuple(self.lin), dict(self.ang), self.tcp     # for what lies between two ends
        self.moves.append(m)
    def go(self, w, line, rapid):
        xyz = list(self.shown())
        for i, c in enumerate("XYZ"):
            if c in w:
                xyz[i] = w[c] if self.absolute else xyz[i] + w[c]
                self.known[i] = True
        for a in self.m.axes:
            if a.letter in w: self.ang[a.letter] = w[a.letter] if self.absolute else self.ang[a.letter] + w[a.letter]
        if not self.m.within(self.ang): self.no(line, "beyond the travel of an axis")
        if self.plane:
            o, c = self.plane
            self.lin = list(self.m.linear(add(o, into(c, xyz)), self.ang))
        elif self.tcp: self.lin = list(self.m.linear(tuple(xyz), self.ang))
        else: self.lin = xyz
        if all(self.known): self.put("rapid" if rapid else "line", line)


def run(files, main, options):
    mach = next(m for m in machines() if m.name == options["kin"])
    r = Run(mach, options["dialect"], main)
    text = files[main].decode("latin-1")
    one = {"fanuc": iso_line, "sinumerik": sinumerik_line, "heidenhain": heidenhain_line}[r.dialect]
    for n, raw in enumerate(text.splitlines(), 1):
        if one(r, raw, n): break
    options["chosen"] = r.chosen
    return r.moves


def words(s, r, n):
    w, g = {}, []
    for m in WORD.finditer(s):
        v = float(m.group(3))
        if m.group(1) in "GM": g.append((m.group(1), v))
        else: w[m.group(1)] = v
    rest = WORD.sub("", s).strip()
    if rest: r.no(n, "not understood: " + rest)
    return w, g


def iso_line(r, raw, n):
    s = re.sub(r"\(.*?\)", "", raw).upper().strip()
    if not s or s == "%": return
    if s[0] == "O": return
    w, g = words(s, r, n)
    gs = [v for k, v in g if k == "G"]
    if "F" in w: r.feed = w["F"]
    for v in gs:
        if v in (0, 1): r.mode = v
        elif v == 90: r.absolute = True
        elif v == 91: r.absolute = False
        elif v == 43.4: r.tcp = True
        elif v in (43, 49): r.tcp = False
        elif v == 69: r.plane = None
        elif v in (17, 21, 40, 54, 80, 94, 68.2, 53.1): pass
        else: r.no(n, "G%g" % v)
    if 68.2 in gs:
        if r.tcp or r.plane: r.no(n, "G68.2 with the tip controlled or twice")
        r.plane = ((w.get("X", 0.0), w.get("Y", 0.0), w.get("Z", 0.0)), euler_fanuc(w.get("I", 0.0), w.get("J", 0.0), w.get("K", 0.0)))
        return
    if 53.1 in gs:
        c = choose_fanuc(r.m, r.plane[1][2], r.ang) if r.plane else r.no(n, "G53.1 without G68.2")
        if not c: r.no(n, "G53.1 cannot be reached")
        r.chosen.append((n, c))
        r.swing(c, False, n)
        return
    if any(c in w for c in "XYZABC"): r.go(w, n, r.mode == 0)
    return any(k == "M" and v in (2, 30) for k, v in g)


def sinumerik_line(r, raw, n):
    s = raw.split(";")[0].upper().strip()
    m = re.match(r"(N\d+\s*)?(TRAORI|TRAFOOF)(\(\))?$", s)
    if m:
        r.tcp = m.group(2) == "TRAORI"
        return
    m = re.match(r"(N\d+\s*)?CYCLE800\((.*)\)$", s)
    if m:
        a = [x.strip() for x in m.group(2).split(",")]
        if len(a) < 2 or not any(a): r.plane = None; return
        a += [""]*(16-len(a))
        v = lambda i: float(a[i] or 0)
        if int(v(0)) or int(v(2)): r.no(n, "CYCLE800 with retraction or on top of another")
        cols = cycle800(int(v(3)), v(7), v(8), v(9)) if not int(v(3)) >> 7 else r.no(n, "CYCLE800 by projected angles or axes")
        o = add((v(4), v(5), v(6)), into(cols, (v(10), v(11), v(12))))
        c = choose_siemens(r.m, cols[2], r.ang, int(v(13)), (r.m.heads+r.m.tables)[0].letter)
        if not c: r.no(n, "CYCLE800 leaves the angles open")
        r.chosen.append((n, c))
        r.plane = (o, cols)
        r.swing(c, False, n)
        return
    if not s: return
    w, g = words(s, r, n)
    if "F" in w: r.feed = w["F"]
    for v in [v for k, v in g if k == "G"]:
        if v in (0, 1): r.mode = v
        elif v == 90: r.absolute = True
        elif v == 91: r.absolute = False
        elif v in (17, 40, 54, 64, 71, 710, 94): pass
        else: r.no(n, "G%g" % v)
    if any(c in w for c in "XYZABC"): r.go(w, n, r.mode == 0)
    return any(k == "M" and v in (2, 30) for k, v in g)


def heidenhain_line(r, raw, n):
    s = re.sub(r"^\s*\d+\s*", "", raw.split(";")[0]).upper().strip()
    if not s or s.startswith(("BEGIN PGM", "TOOL CALL", "BLK FORM")): return
    if s.startswith("END PGM"): return True
    if s.startswith("PLANE"):
        if s.startswith("PLANE RESET"):
            r.plane = None
            if "STAY" not in s: r.no(n, "PLANE RESET that moves")
            return
        m = re.match(r"PLANE (\w+) (.*?) ?(STAY|TURN|MOVE)(.*)$", s)
        if not m: r.no(n, "PLANE of another kind")
        kind, rest = m.group(1), m.group(4)
        g = {k: float(v) for k, v in re.findall(r"(P\d[XYZ]|[A-Z]+)([-+]?[\d.]+)", m.group(2))}
        v = lambda *names: tuple(g[k] for k in names)
        before = r.plane[1] if r.plane else [X_, Y_, Z_]
        if kind == "SPATIAL": cols = spatial(*v("SPA", "SPB", "SPC"))
        elif kind == "EULER": cols = euler_fanuc(*v("EULPR", "EULNU", "EULROT"))
        elif kind == "VECTOR": cols = vectors(v("BX", "BY", "BZ"), v("NX", "NY", "NZ"))
        elif kind == "POINTS": cols = points(*(v(*("P%d%s" % (i, c) for c in "XYZ")) for i in (1, 2, 3)))
        elif kind == "RELATIV":
            cols = [into(before, c) for c in spatial(*(g.get(k, 0.0) for k in ("SPA", "SPB", "SPC")))]
        elif kind == "AXIAL": cols = across(r.m, {**r.ang, **g})
        else: r.no(n, "PLANE of another kind")
        seq = 1 if "SEQ+" in rest else -1 if "SEQ-" in rest else 0
        if re.search(r"TABLE ROT|COORD ROT", rest): r.no(n, "PLANE with TABLE ROT or COORD ROT")
        c = {**r.ang, **g} if kind == "AXIAL" else choose_heidenhain(r.m, cols[2], r.ang, seq)
        if not c or not r.m.within(c): r.no(n, "PLANE cannot be reached")
        if m.group(3) != "STAY": r.chosen.append((n, c))
        r.plane = ((0.0, 0.0, 0.0), cols)
        r.told = c
        if m.group(3) != "STAY": r.swing(c, m.group(3) == "MOVE", n)
        return
    if not s.startswith("L ") and s not in ("M129", "M128", "M30", "M2"): r.no(n, "not understood: " + s)
    body = s[2:] if s.startswith("L ") else s
    ms = [int(x) for x in re.findall(r"\bM(\d+)", body)]
    body = re.sub(r"\bM\d+", "", body)
    fast = "FMAX" in body
    body = re.sub(r"FMAX|\bR0\b", "", body)
    if re.search(r"\+Q12[012]", body): r.chosen.append((n, r.told))
    for q, l in (("Q120", "A"), ("Q121", "B"), ("Q122", "C")):
        if l+"+"+q in body: body = body.replace(l+"+"+q, l+"%+.6f" % r.told.get(l, 0.0))
    w, _ = words(body, r, n)
    if "F" in w: r.feed = w["F"]
    if 128 in ms: r.tcp = True                      # effective at the start of the block
    if any(c in w for c in "XYZABC"): r.go(w, n, fast)
    if 129 in ms: r.tcp = False                     # effective at the end of the block
    return any(x in (2, 30) for x in ms)


def plane(q, mach, a, ways):
    """A PLANE of any kind, without how it turns; a: angles about x, y and z."""
    kind, cols = q.choice(["SPATIAL", "SPATIAL", "EULER", "VECTOR", "POINTS", "RELATIV", "AXIAL"]), spatial(*a)
    if kind == "EULER": return "EULER EULPR%+.3f EULNU%+.3f EULROT%+.3f" % (a[2], abs(a[0])+3, a[1]+60)
    if kind == "VECTOR":
        return "VECTOR " + " ".join("%s%s%.9f" % (n, c, x) for n, v in (("B", mul(cols[0], q.uniform(0.5, 2))), ("N", mul(cols[2], q.uniform(0.5, 2))))
                                    for c, x in zip("XYZ", v))
    if kind == "POINTS":
        p = tuple(q.uniform(-40, 40) for _ in "xyz")
        far = [p, add(p, mul(cols[0], q.uniform(10, 80))), add(p, add(mul(cols[0], q.uniform(-30, 30)), mul(cols[1], q.uniform(10, 80))))]
        return "POINTS " + " ".join("P%d%s%+.9f" % (i+1, c, x) for i, v in enumerate(far) for c, x in zip("XYZ", v))
    if kind == "RELATIV": return "RELATIV SP%s%+.3f" % (q.choice("ABC"), a[1])
    across_z = [x for x in mach.axes if abs(dot(x.about, Z)) < 1e-9]
    if kind == "AXIAL" and across_z: return "AXIAL %s%+.3f" % (q.choice(across_z).letter, a[0])
    return "SPATIAL SPA%+.3f SPB%+.3f SPC%+.3f" % tuple(a)


def poses(count):
    """Two tables, lines of CSV: the axes of the ten machines from the base outwards, and poses of each: the axes' places, where the tip is and which
    way the tool points, and the angles that a control finds for a plane from there, none if it finds none. The plane is given by its turns
    about z, x and z as turned so far (G53.1), or about x, y and z of W."""
    q = random.Random(20)
    axes = ["machine,letter,turns,about_x,about_y,about_z,through_x_mm,through_y_mm,through_z_mm,least_deg,greatest_deg"]
    rows = ["machine,a_deg,b_deg,c_deg,x_mm,y_mm,z_mm,tip_x_mm,tip_y_mm,tip_z_mm,axis_x,axis_y,axis_z,rule,first_deg,second_deg,third_deg,"
            "found_a_deg,found_b_deg,found_c_deg"]
    places = lambda digits, values: ["%.*f" % (digits, v) for v in values]
    for m in machines():
        for a in m.axes:
            axes.append(",".join([m.name, a.letter, "tool" if a.kind == "head" else "workpiece"] + places(12, a.about)
                                 + places(3, a.through + (a.lo, a.hi))))
        for k in range(count):
            ang = {"A": 0.0, "B": 0.0, "C": 0.0}
            ang.update({a.letter: round(q.uniform(max(a.lo, -179), min(a.hi, 179)), 3) for a in m.axes})
            lin, turns = tuple(round(q.uniform(-300, 300), 3) for _ in "xyz"), [round(q.uniform(-60, 60), 3) for _ in "xyz"]
            rule = ["G53.1", "SEQ+", "SEQ-", "", "_DIR 1", "_DIR -1"][k % 6]
            n = (euler_fanuc if rule == "G53.1" else spatial)(*turns)[2]
            found = (choose_fanuc(m, n, ang) if k % 6 == 0 else choose_heidenhain(m, n, ang, (0, 1, -1, 0)[k % 6]) if k % 6 < 4
                     else choose_siemens(m, n, ang, 1 if k % 6 == 4 else -1, (m.heads+m.tables)[0].letter))
            tip, d = m.forward(lin, ang)
            rows.append(",".join([m.name] + places(3, list(ang.values()) + list(lin)) + places(9, tip+d) + [rule] + places(3, turns)
                                 + (places(9, (found.get(l, 0.0) for l in "ABC")) if found else [""]*3)))
    return axes, rows


def generate(seed):
    q = random.Random(seed)
    mach = q.choice(machines())
    dialect = q.choice(["fanuc", "fanuc", "sinumerik", "heidenhain"])
    planes = q.random() < 0.25
    r3 = lambda a, b: round(q.uniform(a, b), 3)
    lim = {a.letter: ((max(a.lo, -60.0), min(a.hi, 60.0)) if abs(dot(a.about, Z)) < 0.99 else (-170.0, 170.0)) for a in mach.axes}
    ang = {a.letter: r3(*lim[a.letter]) for a in mach.axes}
    sp = q.choice(["", " "])
    num = lambda v: ("%.3f" % v).rstrip("0") if q.random() < 0.3 else "%.3f" % v
    hd = dialect == "heidenhain"
    W = lambda c, v: c + ("%+.3f" % v if hd else num(v))
    L, N = [], [10]
    def put(s):
        if hd: L.append("%d %s" % (len(L), s))
        elif q.random() < 0.6 or N[0] > 10: L.append("N%d %s" % (N[0], s)); N[0] += 10
        else: L.append(s)
    numbered = q.random() < 0.5
    if not numbered and not hd:
        put = lambda s: L.append(s)
    G = lambda m, ws, f=None, extra="": (("L " if hd else "G%s " % (("0%d" % m) if q.random() < .3 else m)) + (" " if hd else sp or " ").join(ws)
                                         + ((" R0 FMAX" if m == 0 else " R0 F%d" % f if f else "") if hd else " F%d" % f if f and m else "") + extra)
    if hd: put("BEGIN PGM P%d MM" % (seed % 1000))
    elif dialect == "fanuc":
        L.append("%"); L.append("O%04d (FIVE AXES)" % (seed % 9000+1)); put("G21 G90 G17 G40 G54")
    else: put("G17 G90 G71 G94 G54")
    first = [W("X", r3(-80, 80)), W("Y", r3(-80, 80)), W("Z", r3(80, 150))]
    if not planes: first += [W(a.letter, ang[a.letter]) for a in mach.axes]
    put(G(0, first, extra=" M3" if hd else ""))
    on = False
    def tip(v):
        nonlocal on
        on = v
        put({"fanuc": "G43.4 H1" if v else "G49", "sinumerik": "TRAORI" if v else "TRAFOOF", "heidenhain": "M128" if v else "M129"}[dialect])
    if planes:
        a = [r3(-50, 50), r3(-50, 50), r3(-90, 90)]
        if dialect == "fanuc":
            put("G68.2 X%s Y%s Z%s I%s J%s K%s" % (r3(-30, 30), r3(-30, 30), r3(-10, 10), a[2], abs(a[0])+3, a[1])); put("G53.1")
        elif dialect == "sinumerik":
            mode = q.choice([57, 54, 27, 39, 64])
            if mode == 64: a = [a[2], a[0], 0]
            put('CYCLE800(0,"TC1",0,%d,%s,%s,%s,%s,%s,%s,0,0,0,%d)' % (mode, r3(-30, 30), r3(-30, 30), 0, a[0], a[1], a[2], q.choice([-1, 1])))
        else:
            ways = ["TURN FMAX", "TURN FMAX SEQ+", "STAY", "TURN FMAX SEQ-"]
            put("PLANE " + plane(q, mach, a, ways) + " " + q.choice(ways))
            if L[-1].split()[2] == "RELATIV" and q.random() < 0.5:
                L[-1:-1] = ["%d PLANE SPATIAL SPA%+.3f SPB+0 SPC+0 TURN FMAX" % (len(L)-1, a[0]/2)]
                L[-1] = re.sub(r"^\d+", str(len(L)-1), L[-1])
            if "STAY" in L[-1]: put("L " + " ".join("%s+Q%d" % (x.letter, 120+"ABC".index(x.letter)) for x in mach.axes) + " R0 FMAX")
        put(G(0, [W("X", r3(-40, 40)), W("Y", r3(-40, 40)), W("Z", 60.0)]))
    else:
        if q.random() < 0.75: tip(True)
        put(G(0, [W("X", r3(-60, 60)), W("Y", r3(-60, 60)), W("Z", r3(20, 60))]))
    for i in range(q.randint(14, 40)):
        if planes:
            ws = [W(c, r3(-60, 60) if c != "Z" else r3(-20, 5)) for c in "XYZ" if q.random() < 0.6]
        else:
            u = q.random()
            for l in ang:
                if u < 0.7: ang[l] = round(max(lim[l][0], min(lim[l][1], ang[l]+q.uniform(-12, 12))), 3)
            if u > 0.95: ang = {l: (0.0 if i % 2 else v) for l, v in ang.items()}
            ws = [W(c, r3(-60, 60) if c != "Z" else r3(-20, 5)) for c in "XYZ" if q.random() < 0.7] + [W(l, v) for l, v in ang.items() if u < 0.7 or u > 0.95]
        if not ws: continue
        if not hd and not planes and q.random() < 0.08:          # a few increments, of angles as well
            put("G91")
            for _ in range(2):
                l = q.choice(list(ang)); dx = round(q.uniform(-6, 6), 3)
                if not lim[l][0] <= ang[l]+dx <= lim[l][1]: dx = 0.0
                ang[l] = round(ang[l]+dx, 3)
                put(G(1, [W(q.choice("XYZ"), r3(-9, 9)), W(l, dx)], 700))
            put("G90")
        put(G(1, ws, q.randint(2, 20)*100 if i == 0 or q.random() < 0.2 else None))
        if not planes and q.random() < 0.06:
            put(G(0, [W("Z", r3(70, 120))])); tip(not on)
            put(G(0, [W("X", r3(-60, 60)), W("Y", r3(-60, 60)), W("Z", r3(40, 90))]))
            put(G(1, [W("Z", r3(-5, 5))], 500))
    put(G(0, [W("Z", 120.0)]))
    if planes: put({"fanuc": "G69", "sinumerik": "CYCLE800()", "heidenhain": "PLANE RESET STAY"}[dialect])
    elif on: tip(False)
    if hd: put("END PGM P%d MM" % (seed % 1000))
    else:
        put("M30")
        if dialect == "fanuc": L.append("%")
    name = {"fanuc": "O1.nc", "sinumerik": "a.mpf", "heidenhain": "a.h"}[dialect]
    return ({name: ("\n".join(L)+"\n").encode()}, name,
            {"kin": mach.name, "dialect": dialect, "machine": toml(mach), "gcode": {"dialect": dialect}})


LINUXCNC = [   # module, pins and axis values, tip: computed by LinuxCNC 5c41560e
    ('a', [-365.635756, 347.433737, 263.774619, -48.986195, -0.912983, -10.101787, 0, 101.622773, 0, 786.634085, -220.382386, 214.875993, 192.353493, 140.999664, -168.241996], [-1608.080810419, 32.851964356, 170.286708842]),
    ('b', [301.826367, 91.153435, -397.772842, -36.514074, -95.535578, 29.909227, 1.840988, 427.56612, 1, 451.705203, 55.258829, 527.40199, 316.200254, 38.058895, -111.095701], [30.41929555, -512.644079846, 222.533954465]),
    ('5', [176.84854, 260.947738, 452.244455, 85.301325, -16.764012, 83.253967, 0, 152.248446, 0, -758.22008, -334.609629, 442.968815, 152.058074, 314.237222, -56.08296], [-819.085587844, -244.090361808, 489.004071935]),
    ('a', [330.035693, 170.305566, -196.631489, 17.516121, 76.4958, 69.239484, 0, 314.124835, 1, -171.372001, -653.985197, 97.597523, 146.189349, 125.629798, -90.213825], [1031.648881531, 669.098354, -815.574295169]),
    ('b', [-61.03837, 8.426488, 278.442615, 4.187684, -21.348981, -2.061296, 0, 219.691185, 1, 294.312331, -662.811406, -546.125308, -351.142859, -216.348215, 302.462233], [-1038.614002426, 294.572586675, 730.721458585]),
    ('5', [48.338467, -95.545132, -156.174109, 69.492198, -29.345167, 81.951003, 0, 261.029298, 0, 37.356567, 122.71573, -147.818641, -319.591226, 266.407312, 50.39952], [-128.704457721, -78.014142452, 129.567575673]),
    ('a', [-300.16058, 4.720467, -15.074888, -28.642007, -30.784416, 7.695759, 124.697891, 301.98074, 0, 609.138969, 270.742181, 101.51253, -229.835525, -294.046987, 36.740978], [288.347710329, -726.975872074, -99.304553626]),
    ('b', [351.274012, 430.950025, -467.540869, 88.714051, -85.909305, 73.615618, 90.599757, 187.257574, 0, 594.575429, -630.779634, -419.431358, -239.421379, -176.244395, 325.409509], [893.80918242, -484.624028798, -197.594552646]),
    ('5', [156.656506, 148.202805, -205.507223, 40.525111, -0.701269, -77.161871, 62.400985, 281.505274, 0, -483.158333, -493.083702, 460.304462, 343.251558, 335.205733, -49.208006], [-560.283717725, -403.707838838, 486.253774604]),
    ('a', [475.553431, -274.625987, -102.684631, -92.934791, 91.978663, -10.866297, 101.261863, 349.58619, 0, 953.952312, 261.543673, 390.101783, -35.39158, 17.204717, -337.895801], [1001.965992756, -249.85025582, 573.003421376]),
    ('b', [174.902578, 303.385513, 159.823892, -14.740124, 47.49025, -74.863336, 0, 218.512641, 0, -379.272745, 878.576864, 487.684237, -60.355971, -178.302166, -353.894211], [769.430039145, 818.261011027, -301.603689085]),
    ('5', [378.717898, -462.083469, 319.414111, 92.440225, 14.056114, -65.696581, 0, 257.882859, 0, -801.949274, 146.765406, 793.131492, 65.814705, -5.50746, 315.326809], [-819.549988312, 164.166471736, 794.321953892]),
    ('a', [-109.939461, 4.107367, -482.799803, 22.425672, -19.535057, -43.729657, 31.393059, 496.126484, 0, -321.808704, -573.940407, 348.910139, 243.144771, 311.17498, -112.428133], [451.792013812, 6.752402514, -1374.701622017]),
    ('b', [382.393202, 187.110182, -15.501277, 97.101646, -53.071913, 45.093037, 0, 141.603903, 0, -463.980112, -335.533044, 11.776966, -176.190317, -116.026862, -277.982703], [-66.43137668, -375.757307311, 885.204436768]),
    ('5', [-264.810489, 443.994899, 279.539846, 43.021728, -2.241435, 15.991411, 154.050632, 71.525789, 0, -239.539521, 982.466754, -705.343234, -269.98758, -277.423659, 62.933704], [-207.266575084, 1045.625207329, -643.058939848]),
    ('a', [426.165442, -423.348363, 50.274754, 13.193303, 90.449246, -27.021639, 0, 301.773092, 1, -784.53863, -908.496531, -408.524126, 81.847386, -349.52533, -62.255208], [248.624467357, 851.244310338, -607.757686171]),
    ('b', [326.119988, 289.878212, -312.077908, 57.102427, 17.358575, -67.596033, 0, 137.419619, 0, -129.794331, 929.38759, 612.974733, 30.906322, 229.212078, 36.150541], [1626.958752065, 131.523149532, -639.710825258]),
    ('5', [211.610947, -185.540258, -292.38538, -36.516732, -94.547491, 57.37199, 185.120735, 297.414494, 0, -202.88968, -871.616037, -365.300924, 73.041771, -31.78225, -179.954766], [-46.243752305, -871.492367797, -320.705375658]),
    ('a', [285.135616, 277.919628, 391.209398, 73.522768, -6.21598, -28.834603, 0, 219.026615, 0, -279.072835, 639.954094, -821.170375, 182.366413, -294.848324, 53.536488], [-311.784351269, 538.356405762, 1560.115689986]),
    ('b', [-161.116213, -272.573766, 466.598088, -91.789549, -62.63743, 58.546361, 115.801327, 185.216471, 0, 88.450828, 157.970873, 191.92508, -183.529437, -345.3307, -184.493304], [-478.453771583, -729.383456985, 293.006563263]),
    ('5', [-427.672466, 51.204755, -429.083632, -84.974042, 27.076419, -41.83569, 158.436952, 307.85892, 0, -798.131086, 555.491817, -343.812897, 6.674425, 118.978163, -230.712173], [-968.666624588, 763.935869092, 113.196356052]),
    ('a', [-350.43706, -358.461821, 365.545648, -38.875425, 41.864798, 66.937832, 0, 541.567339, 0, 90.985923, 445.257098, 559.486901, 231.141486, 88.939856, 123.982794], [-1040.808658605, -425.446398354, 946.055610743]),
    ('b', [52.951521, 443.474611, 486.935338, -58.91317, -40.214724, 7.498463, 0, 188.922524, 0, 364.151656, -106.610018, -139.657176, -179.841731, -43.632857, 27.403134], [-403.153978378, 60.317844087, -219.89723123]),
    ('5', [-489.133474, 336.291003, -328.482395, -2.843378, 58.613415, 86.527888, 0, 84.276897, 0, 160.141142, 187.092664, -723.008405, 347.916288, -160.621681, 46.131798], [140.762435644, 166.932827417, -559.22904202]),
    ('a', [-327.82578, -410.752772, -14.003299, -64.484378, -36.551673, 78.607067, 0, 181.106071, 1, 373.898722, 913.079459, 425.692222, -117.394921, 80.12645, 164.318921], [-911.023683386, 108.084369924, -1309.365893422]),
    ('b', [153.407717, 472.353769, -280.530817, 84.320702, 52.638861, 29.057686, 0, 221.491118, 1, 697.982245, -256.771339, 402.565326, 170.221044, 68.096019, 256.51954], [-756.770184157, -196.748443236, -434.510870458]),
    ('5', [396.604371, 460.078817, 71.232694, -64.744821, -49.880918, -56.476262, 0, 322.264208, 0, 434.306527, -304.036984, 30.111609, -241.345331, 165.525228, -330.689745], [504.5456347, -264.604102753, 664.410647402]),
    ('a', [481.221058, 307.943733, 128.448502, -46.494751, 82.572578, 91.887768, 0, 294.782303, 0, 942.415056, -235.293374, 605.423062, -48.296454, -241.376963, -125.663561], [717.086048415, 1044.857747928, 9.297847436]),
    ('b', [-373.669925, 408.88476, 459.42408, -76.162654, 20.135816, -18.35518, 23.618006, 202.719839, 1, 499.153622, -991.982088, -620.322592, -44.08339, -344.855035, 91.819144], [1008.828411828, 1009.46584353, -830.57207175]),
    ('5', [105.627539, 335.332351, -293.394184, -43.043677, 8.467886, -45.354861, 117.147617, 507.795212, 0, 582.181437, 617.30924, 947.232219, 32.671443, -6.617319, 256.102344], [596.236539383, 674.113239042, 950.615161998]),
]


def selftest():
    q = random.Random(0)
    worst = [0.0]*4
    for k, p, t in LINUXCNC:
        m = (linuxcnc_xyzac(p[0], p[1], p[2], p[4], p[5]+p[6]) if k == "a" else linuxcnc_xyzbc(p[0], p[1], p[2], p[3], p[5]+p[6]) if k == "b"
             else linuxcnc_5axis(p[7]))
        if p[8]:
            for a in m.axes: a.about = mul(a.about, -1)
        g, _ = m.forward(tuple(p[9:12]), {"A": p[12], "B": p[13], "C": p[14]})
        worst[0] = max(worst[0], norm(sub(g, t)))
    assert worst[0] < 1e-6, worst
    n = two = 0
    for m in machines():
        for _ in range(2000):
            ang = {a.letter: q.uniform(max(a.lo, -179), min(a.hi, 179)) for a in m.axes}
            lin = tuple(q.uniform(-300, 300) for _ in "xyz")
            tip, d = m.forward(lin, ang)
            worst[1] = max(worst[1], norm(sub(m.linear(tip, ang), lin)))
            s = m.angles(d, ang)
            assert s, (m.name, ang)
            assert min(max(abs(wrap(x[l]-ang[l])) for l in ang) for x, _ in s) < 1e-4, (m.name, ang, s)
            for x, _ in s:
                t2, d2 = m.forward(m.linear(tip, x), x)
                worst[2] = max(worst[2], norm(sub(t2, tip))); worst[3] = max(worst[3], norm(sub(d2, d)))
            two += len(s) == 2; n += 1
        for pole in ({a.letter: 0.0 for a in m.axes},):
            for c in (0.0, 37.0, -120.0):
                s = m.angles(m.forward((0, 0, 0), pole)[1], {a.letter: c for a in m.axes})
                assert s, m.name
    print("kinematics: %d poses, two solutions at %d; LinuxCNC's numbers %.1e mm, linear and back %.1e mm, tip of both solutions %.1e mm, direction %.1e" % ((n, two)+tuple(worst)))
    # closed forms, by hand
    byname = {m.name: m for m in machines()}
    h = byname["head_ca"]
    t, d = h.forward((10, 20, 30), {"C": 90.0, "A": 90.0})      # A 90 lays the tool along -y, C 90 turns that to +x; pivot 250 above the tip
    assert norm(sub(d, (1, 0, 0))) < 1e-12 and norm(sub(t, (10-250, 20, 30+250))) < 1e-9, (t, d)
    m = byname["table_ac"]
    t, d = m.forward((0, 0, 0), {"A": 90.0, "C": 0.0})          # the table turns y to z: the tool comes from +y of the part
    assert norm(sub(d, (0, 1, 0))) < 1e-12 and norm(sub(t, (0, 60, -60))) < 1e-9, (t, d)
    n45 = byname["head_nutating_cb"]
    t, d = n45.forward((0, 0, 0), {"C": 0.0, "B": 180.0})       # 45 degrees nutated by 180: the tool lies along +y
    assert norm(sub(d, (0, 1, 0))) < 1e-9 and norm(sub(t, (0, -280, 280))) < 1e-9, (t, d)
    # Heidenhain's table for SPB+45 on A-C
    col = spatial(0, 45, 0)[2]
    for lo, hi, a, c, seq, ea, ec in ((-1e9, 1e9, 0, 0, 0, 45, 90), (-1e9, 1e9, 0, 0, 1, 45, 90), (-1e9, 1e9, 0, 0, -1, -45, -90),
                                      (-1e9, 1e9, 0, -105, 0, -45, -90), (-1e9, 1e9, 0, -105, 1, 45, 90), (-1e9, 1e9, 0, -105, -1, -45, -90),
                                      (-90, 10, 0, 0, 0, -45, -90), (-1e9, 1e9, 0, -135, 1, 45, 90)):
        ac = Machine("ac", [Axis("A", "table", X_, (0, 0, 0), lo, hi), Axis("C", "table", Z_, (0, 0, 0), -180, 180)])
        g = choose_heidenhain(ac, col, {"A": a, "C": c}, seq)
        assert g and abs(g["A"]-ea) < 1e-9 and abs(g["C"]-ec) < 1e-9, (g, ea, ec)
    ac = Machine("ac", [Axis("A", "table", X_, (0, 0, 0), -90, 10), Axis("C", "table", Z_, (0, 0, 0), -180, 180)])
    assert choose_heidenhain(ac, col, {"A": 0, "C": 0}, 1) is None
    # the same turn both ways (TNC 620 p. 540)
    for _ in range(50):
        a, b, c = (q.uniform(-180, 180) for _ in range(3))
        v = X_
        for ax, g in ((X_, a), (Y_, b), (Z_, c)): v = turn(v, ax, g)
        assert norm(sub(v, spatial(a, b, c)[0])) < 1e-12
    g = choose_fanuc(byname["table_ac"], euler_fanuc(0, 30, 0)[2], {"A": 0.0, "C": 0.0})
    assert abs(abs(g["A"])-30) < 1e-9 and abs(g["C"]) < 1e-9, g
    assert choose_siemens(byname["mixed_b_c"], frame((X_, 10))[2], {"B": 0.0, "C": 0.0}, -1)["B"] < 0
    # programs
    seen, moves, kinds = set(), 0, {}
    for s in range(2000):
        f, main, o = generate(s)
        assert f[main] not in seen; seen.add(f[main])
        try: mv = run(f, main, o)
        except Refused as e:
            kinds[e.why] = kinds.get(e.why, 0)+1; continue
        assert len(mv) > 8 and mv[0].kind == "rapid"
        assert all(abs(norm(x.axis_or_rotation)-1) < 1e-9 for x in mv)
        assert all(max(map(abs, x.end)) < 2000 for x in mv)
        moves += len(mv)
    print("programs: 2000, %d moves, own refusals %s" % (moves, kinds))
    ex = b"G21 G90 G17 G54\nG0 X0 Y0 Z0 A0 C0\nG0 A90\nG43.4 H1\nG1 X0 Y0 Z0 F100\nC90\nG49\nG1 X1 Y2 Z3\nM30\n"
    got = [(m.line, tuple(round(c, 6)+0.0 for c in m.end)) for m in run({"a": ex}, "a", {"kin": "table_ac", "dialect": "fanuc"})]
    assert got == [(2, (0, 0, 0)), (3, (0, 60, -60)), (5, (0, 0, 0)), (6, (0, 0, 0)), (8, (63, -1, -62))], got
    print("ok")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--poses"]:
        for name, table in zip(("axes.csv", "poses.csv"), poses(30)):
            with open(sys.argv[2] + "/" + name, "w") as file: file.write("\n".join(table) + "\n")
    else: selftest()
