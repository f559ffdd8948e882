//! Contours of Sinumerik and Heidenhain as the lines and arcs that the control makes of them: polar coordinates, arcs by three points, by the
//! tangent before and of several turns, roundings and chamfers, and coordinates rotated in the plane.

use std::f64::consts::TAU;

use crate::{
    expand::{
        check_length,
        edit::acts_at_end,
        geometry::{About, CutCorner, Element, Point, circle_through, round_corner, sweep},
        line::long_number,
    },
    model::{
        Plane, TurnDirection,
        gcode::{
            BlockDelete, Dialect, Distance, Fault, Foreign, GWord, LengthUnit, MacroFault, MotionCode, Refusal,
            Setting, Word, centre_by_radius,
        },
    },
    read::gcode::{
        LineReader, Statement,
        lines::{self, Lines},
    },
};

/// Bytes of a program, the index of the line that each of its lines comes from, and whether they differ from what was read.
type Written = (Vec<u8>, Vec<usize>, bool);

/// Motion and centre of arcs that a line puts in force.
type InForce = (Option<MotionCode>, Option<[f64; 2]>);

/// How the way to the end of a block is found.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Code(MotionCode),
    /// CIP: an arc through a third point.
    Through,
    /// CT: an arc along the tangent before it.
    Tangential,
}

/// A corner that is cut off, by an arc of this radius or a chamfer.
#[derive(Clone, Copy, Debug)]
enum Corner {
    Arc(f64),
    /// Length of the chamfer itself (CHF of Sinumerik).
    Chamfer(f64),
    /// How much of each line it takes.
    Leg(f64),
}

/// A move to the coordinates that are named, an arc about `centre`.
#[derive(Clone, Debug)]
struct Move {
    code: MotionCode,
    to: [Option<f64>; 3],
    centre: Option<[f64; 2]>,
}

/// A motion block that is not yet written, as a corner may follow.
struct Waiting {
    line: usize,
    words: Vec<Word>,
    prefix: usize,
    moves: Vec<Move>,
    /// Its last move, if it is in the plane and known.
    element: Option<Element>,
    corner: Option<Corner>,
    is_rewritten: bool,
    /// A coordinate of it whose end is not known, which cannot be written anew.
    open: Option<Word>,
    /// Whether a block without motion follows.
    is_interrupted: bool,
    /// Lines behind it, and what they put in force.
    held: Vec<(Vec<u8>, usize, InForce)>,
}

/// The coordinates from which a block leads to which, the axes that are written, and whether it is a helix by CP.
#[derive(Clone, Copy)]
struct Span {
    from: [Option<f64>; 3],
    to: [Option<f64>; 3],
    named: [bool; 3],
    is_helix: bool,
}

impl Span {
    /// Returns of `at` the coordinates that are written.
    fn written(&self, at: [Option<f64>; 3]) -> [Option<f64>; 3] {
        [0, 1, 2].map(|axis| at[axis].filter(|_| self.named[axis]))
    }
}

/// State of the control; lengths are in the unit of the program, positions in its rotated coordinates.
struct Contour<'a> {
    dialect: Dialect,
    source: &'a [u8],
    lines: Lines,
    written: Written,
    at: [Option<f64>; 3],
    unit: LengthUnit,
    plane: Plane,
    way: Way,
    distance: Distance,
    pole: Option<[f64; 2]>,
    /// Last polar radius and, if the last motion was polar, angle (degrees).
    polar: [Option<f64>; 2],
    /// RNDM, 0 if it is off.
    rounding: f64,
    /// Rotation of the coordinates in the plane, degrees, and shift of the zero by TRANS.
    angle: f64,
    shift: [f64; 3],
    /// Axes that were not named since their zero changed.
    has_new_zero: [bool; 3],
    /// Motion and centre in force in what is written.
    code: Option<MotionCode>,
    centre: Option<[f64; 2]>,
    waiting: Option<Waiting>,
    /// The line of the waiting motion that was refused.
    refused: Option<usize>,
}

/// Returns `source` with its contours as lines and arcs. `Err` gives the index of the line that cannot be.
pub(crate) fn follow(source: &[u8], dialect: Dialect, skips: BlockDelete) -> Result<Written, (usize, Refusal)> {
    let lines = Lines::split(source);
    let mut contour = Contour {
        dialect,
        source,
        lines,
        written: (Vec::with_capacity(source.len()), Vec::new(), false),
        at: [None; 3],
        unit: LengthUnit::Millimetre,
        plane: Plane::Xy,
        way: Way::Code(MotionCode::Rapid),
        distance: Distance::Absolute,
        pole: (dialect == Dialect::Sinumerik).then_some([0.0; 2]),
        polar: [None; 2],
        rounding: 0.0,
        angle: 0.0,
        shift: [0.0; 3],
        has_new_zero: [false; 3],
        code: Some(MotionCode::Rapid),
        centre: None,
        waiting: None,
        refused: None,
    };
    let mut reader = LineReader::of_contours(dialect);
    for line in 0..contour.lines.len() {
        let located = |refusal| (line, refusal);
        let content = contour.content(line);
        check_length(contour.written.0.len(), String::new)
            .map_err(|fault| (line, Refusal::new(0..content.len(), fault)))?;
        if skips == BlockDelete::Skip && lines::is_deletable(content) {
            contour.hold(content.to_vec(), line, (None, None));
            continue;
        }
        match reader.parse_line(content).map_err(located)? {
            Statement::Words { words, prefix } => {
                let followed = contour.follow_line(line, words, prefix);
                followed.map_err(|refusal| (contour.refused.unwrap_or(line), refusal))?;
            }
            _ => contour.hold(content.to_vec(), line, (None, None)),
        }
    }
    contour.flush(None).map_err(|refusal| (contour.refused.unwrap_or_default(), refusal))?;
    Ok(contour.written)
}

/// Returns the refusal of `word` with what was expected.
fn refuse(word: &Word, expected: &'static str) -> Refusal {
    word.refuse(Fault::Macro(MacroFault::Contour { expected }))
}

/// Returns the refusal of a block with these words whose start or end is not known.
fn unknown_position(words: &[Word]) -> Refusal {
    let axis = ['X', 'Y', 'Z'].into_iter().find_map(|letter| words.iter().find(|word| word.letter == letter));
    let blame = axis.or(words.first());
    blame.map_or_else(|| Refusal::new(0..0, Fault::NoMotion), |word| refuse(word, "a position that is known before it"))
}

impl<'a> Contour<'a> {
    fn content(&self, line: usize) -> &'a [u8] {
        &self.source[self.lines.content(line)]
    }

    /// Writes a line now or, if a motion is waiting, behind it; not one of which nothing is left.
    fn hold(&mut self, text: Vec<u8>, line: usize, in_force: InForce) {
        if text.trim_ascii().is_empty() && !self.content(line).trim_ascii().is_empty() {
            return;
        }
        match &mut self.waiting {
            Some(waiting) => waiting.held.push((text, line, in_force)),
            None => {
                self.write(&text, line);
                (self.code, self.centre) = (in_force.0.or(self.code), in_force.1.or(self.centre));
            }
        }
    }

    /// Forgets where the tool and the pole are, as the zero or the unit is another one.
    fn forget(&mut self) {
        self.at = [None; 3];
        self.pole = self.pole.filter(|pole| *pole == [0.0; 2] && self.dialect == Dialect::Sinumerik);
    }

    fn write(&mut self, text: &[u8], line: usize) {
        self.written.0.extend_from_slice(text);
        self.written.0.extend_from_slice(self.lines.ending_or_newline(self.source, line));
        self.written.1.push(line);
    }

    /// Follows the words of a line.
    fn follow_line(&mut self, line: usize, words: Vec<Word>, prefix: usize) -> Result<(), Refusal> {
        let find = |letter: char| words.iter().find(|word| word.letter == letter);
        let axes = ['X', 'Y', 'Z'].map(find);
        let mut is_motion = axes.iter().any(Option::is_some) || find('a').or(find('p')).is_some();
        if let Some(retract) = find(Word::RETRACT) {
            // Tapping, which is over with its line.
            self.flush(None)?;
            self.hold(self.content(line).to_vec(), line, (None, None));
            self.at[2] = Some(retract.value);
            return Ok(());
        }
        let Some((is_position, mut names_motion)) = self.apply_modes(line, &words)? else { return Ok(()) };
        is_motion &= is_position;
        if let Some(word) = find('w') {
            return self.set_frame(line, &words, word, None);
        }
        if let Some(word) = find('m') {
            self.rounding = word.value;
        }
        for (letter, way) in [('v', Way::Through), ('u', Way::Tangential)] {
            (self.way, names_motion) = find(letter).map_or((self.way, names_motion), |_| (way, true));
        }
        let corner = words.iter().find_map(|word| match word.letter {
            'f' if word.value != 0.0 => Some((word, Corner::Arc(word.value))),
            'c' => Some((word, Corner::Chamfer(word.value))),
            'h' => Some((word, Corner::Leg(word.value))),
            _ => None,
        });
        is_motion |=
            matches!(self.way, Way::Code(MotionCode::Arc(_))) && ['I', 'J', 'K'].iter().any(|l| find(*l).is_some());
        if let (Some((word, corner)), false) = (corner, is_motion) {
            // Heidenhain's RND and CHF are blocks of their own.
            self.written.2 = true;
            let waiting = self.waiting.as_mut().filter(|waiting| waiting.corner.is_none() && waiting.held.is_empty());
            waiting.ok_or_else(|| refuse(word, "a line or arc before it"))?.corner = Some(corner);
            return Ok(());
        }
        if !is_motion {
            let is_kept = find('m').is_none() && words.iter().all(|word| !word.is_of_contour());
            let text = if is_kept { self.content(line).to_vec() } else { self.without_motion(line, &words, "") };
            let is_centre = words.iter().any(|word| word.meaning.is_some_and(|vocable| vocable.name == "CC"));
            if let Some(waiting) = &mut self.waiting {
                waiting.is_interrupted |= !is_centre && words.iter().any(|word| word.letter != 'N');
            }
            let code = match self.way {
                Way::Code(code) if names_motion => Some(code),
                _ => None,
            };
            self.hold(text, line, (code, self.pole.filter(|_| is_centre)));
            return Ok(());
        }
        let corner = corner.map(|(_, corner)| corner).or((self.rounding > 0.0).then_some(Corner::Arc(self.rounding)));
        let mut next = self.block(line, words, prefix)?;
        next.corner = corner;
        next.is_rewritten |= !names_motion && !matches!(self.way, Way::Code(_));
        self.flush(Some(&mut next))?;
        self.waiting = Some(next);
        Ok(())
    }

    /// Puts the G words of a line in force; returns whether its coordinates are a position and whether it names a motion, `None` for a pole or a frame,
    /// with which the line is done.
    fn apply_modes(&mut self, line: usize, words: &[Word]) -> Result<Option<(bool, bool)>, Refusal> {
        let axes = ['X', 'Y', 'Z'].map(|letter| words.iter().find(|word| word.letter == letter));
        let (mut is_position, mut names_motion) = (true, false);
        for word in words.iter().filter(|word| word.letter == 'G' || word.meaning.is_some()) {
            if word.meaning.is_none() && (110.0..=112.0).contains(&word.value) {
                return self.set_pole(line, words, word).map(|()| None);
            }
            match word.meaning.map_or_else(|| self.dialect.g_word(word), |vocable| Ok(vocable.meaning))? {
                GWord::Motion(code) => (self.way, names_motion) = (Way::Code(code), true),
                GWord::Plane(plane) if plane == self.plane => {}
                GWord::Plane(_) if self.angle != 0.0 => {
                    return Err(refuse(word, "one plane while coordinates are rotated"));
                }
                GWord::Plane(plane) => {
                    self.flush(None)?;
                    (self.plane, self.polar) = (plane, [None; 2]);
                }
                GWord::Distance(distance) => self.distance = distance,
                GWord::Unit(unit) | GWord::UnitOfCoordinates(unit) => {
                    self.unit = unit;
                    self.forget();
                }
                GWord::WorkOffset(_) | GWord::Preset => self.forget(),
                GWord::Machine | GWord::Home | GWord::Retract => {
                    let names_all = axes.iter().all(Option::is_none);
                    (0..3).filter(|axis| names_all || axes[*axis].is_some()).for_each(|axis| self.at[axis] = None);
                    is_position = false;
                }
                GWord::Setting(Setting::Translation { afresh }) => {
                    return self.set_frame(line, words, word, Some(afresh)).map(|()| None);
                }
                GWord::Setting(Setting::Pole) => {
                    let [first, second, _] = self.plane.axes();
                    if axes[3 - first - second].is_some() {
                        return Err(word.refuse(Fault::PoleAxes));
                    }
                    let at = self.ends(axes, words)?;
                    self.pole = at[first].zip(at[second]).map(|(a, b)| [a, b]);
                    self.polar = [None; 2];
                    is_position = false;
                }
                GWord::Setting(Setting::Incline(_))
                | GWord::Align(_)
                | GWord::FindAngles(_)
                | GWord::Passive("rotation") => {
                    self.forget();
                    is_position = false;
                }
                GWord::Dwell | GWord::Setting(_) => is_position = false,
                _ => {}
            }
        }
        Ok(Some((is_position, names_motion)))
    }

    /// Returns the coordinates that a block leads to.
    fn ends(&mut self, axes: [Option<&Word>; 3], words: &[Word]) -> Result<[Option<f64>; 3], Refusal> {
        let mut to = self.at;
        for (axis, word) in axes.into_iter().enumerate() {
            let Some(word) = word else { continue };
            let distance = word.distance.unwrap_or(self.distance);
            if std::mem::take(&mut self.has_new_zero[axis]) && distance == Distance::Incremental {
                return Err(word.refuse(Fault::Foreign(Foreign::StepToNewZero)));
            }
            to[axis] = match distance {
                Distance::Absolute => Some(word.value),
                Distance::Incremental => self.at[axis].map(|at| at + word.value),
            };
        }
        let [first, second, _] = self.plane.axes();
        let find = |letter: char| words.iter().find(|word| word.letter == letter);
        let (radius, angle) = (find('p'), find('a'));
        let Some(word) = angle.or(radius) else {
            if axes[first].or(axes[second]).is_some() {
                self.polar[1] = None;
            }
            return Ok(to);
        };
        let is_step = |word: &Word| word.distance.unwrap_or(self.distance) == Distance::Incremental;
        let pole = self.pole.ok_or_else(|| refuse(word, "a pole before it"))?;
        let is_arc = matches!(self.way, Way::Code(MotionCode::Arc(_)));
        if let (Dialect::Heidenhain, true, Some(word)) = (self.dialect, is_arc, radius) {
            return Err(refuse(word, "CP without PR, as the tool is at the radius that it has"));
        }
        let arm = self.at[first].zip(self.at[second]).map(|(a, b)| [a - pole[0], b - pole[1]]);
        let last = match self.polar[1] {
            None if is_arc => arm.map(|[a, b]| libm::atan2(b, a).to_degrees()),
            angle => angle,
        };
        let given_here = |word: &Word| {
            word.distance.is_some() || self.dialect == Dialect::Heidenhain || self.distance == Distance::Absolute
        };
        let angle = match angle {
            Some(word) if !given_here(word) => None,
            Some(word) if is_step(word) => last.map(|last| last + word.value),
            Some(word) => Some(word.value),
            None => last,
        };
        let radius = match radius {
            Some(word) if is_step(word) => None,
            Some(word) => Some(word.value),
            None if is_arc && self.dialect == Dialect::Heidenhain => arm.map(|[a, b]| libm::hypot(a, b)),
            None => self.polar[0],
        };
        let (Some(radius), Some(angle)) = (radius, angle) else {
            return Err(refuse(word, "radius and angle that are known, a step only from an angle before it"));
        };
        if axes[first].or(axes[second]).is_some() {
            return Err(refuse(word, "polar coordinates or others in the plane"));
        }
        self.polar = [Some(radius), Some(angle)];
        let (sin, cos) = libm::sincos(angle.to_radians());
        (to[first], to[second]) = (Some(pole[0] + radius * cos), Some(pole[1] + radius * sin));
        Ok(to)
    }

    /// Returns the moves of a motion block, and moves on.
    fn block(&mut self, line: usize, words: Vec<Word>, prefix: usize) -> Result<Waiting, Refusal> {
        let [first, second, normal] = self.plane.axes();
        let find = |letter: char| words.iter().find(|word| word.letter == letter);
        let axes = ['X', 'Y', 'Z'].map(find);
        let is_again = |(at, word): &(usize, &Word)| {
            matches!(word.letter, 'X' | 'Y' | 'Z' | 'a' | 'p')
                && words[..*at].iter().any(|one| one.letter == word.letter)
        };
        if let Some((_, word)) = words.iter().enumerate().find(is_again) {
            return Err(refuse(word, "each coordinate once"));
        }
        let from = self.at;
        let to = self.ends(axes, &words)?;
        let open = (0..3).find_map(|axis| axes[axis].filter(|_| to[axis].is_none())).cloned();
        let flat = |p: [Option<f64>; 3]| p[first].zip(p[second]).map(|(a, b)| [a, b]);
        let (start, end) = (flat(from), flat(to));
        let is_polar = find('a').or(find('p')).is_some();
        let mut named = [0, 1, 2].map(|axis| axes[axis].is_some());
        let is_polar_arc =
            self.dialect == Dialect::Heidenhain && is_polar && matches!(self.way, Way::Code(MotionCode::Arc(_)));
        let is_helix = is_polar_arc && axes[normal].is_some() && from[normal] != to[normal];
        named[normal] &= is_helix || !is_polar_arc;
        if is_polar
            || (self.angle != 0.0 && (named[first] || named[second]))
            || !matches!(self.way, Way::Code(MotionCode::Rapid | MotionCode::Line))
        {
            (named[first], named[second]) = (true, true);
        }
        let unknown = || unknown_position(&words);
        let is_special = words.iter().any(|word| word.is_of_contour() && !matches!(word.letter, 'f' | 'c' | 'h' | 'm'));
        let is_rewritten = is_special || self.angle != 0.0 || !matches!(self.way, Way::Code(_));
        if is_rewritten && (named[first] || named[second]) && end.is_none() {
            return Err(unknown());
        }
        let both = start.zip(end);
        let (code, centre) = match self.way {
            Way::Code(code @ MotionCode::Arc(turn)) => (code, self.centre_of(&words, both, turn, is_polar)?),
            Way::Code(code) => (code, None),
            Way::Through => {
                let (start, end) = both.ok_or_else(unknown)?;
                let (centre, turn) = self.arc_through(&words, start, end, to[normal] == from[normal])?;
                (MotionCode::Arc(turn), Some(centre))
            }
            Way::Tangential => {
                let (start, end) = both.ok_or_else(unknown)?;
                self.tangential(start, end).ok_or_else(unknown)?
            }
        };
        self.at = to;
        let span = Span { from, to, named, is_helix };
        let mut moves = match (code, centre, both) {
            (MotionCode::Arc(turn), Some(centre), Some(ends)) => {
                self.turns(&words, &span, ends, (centre, turn)).ok_or_else(unknown)?
            }
            _ => Vec::new(),
        };
        match is_helix {
            false => moves.push(Move { code, to: span.written(to), centre }),
            true if moves.is_empty() => return Err(unknown()),
            true => {}
        }
        let is_flat = from[normal] == to[normal] || !named[normal];
        let element = both.filter(|_| is_flat).and_then(|(from, to)| fed_element(code, centre, from, to));
        Ok(Waiting {
            line,
            words,
            prefix,
            moves,
            element,
            corner: None,
            is_rewritten,
            open,
            is_interrupted: false,
            held: Vec::new(),
        })
    }

    /// Returns the arc (CIP) from `start` through the point of I1, J1, K1 to `end`, which must be in the plane.
    fn arc_through(&self, words: &[Word], start: Point, end: Point, is_level: bool) -> Result<About, Refusal> {
        let [first, second, normal] = self.plane.axes();
        let find = |letter: char| words.iter().find(|word| word.letter == letter);
        let via = [first, second].map(|axis| find(['i', 'j', 'k'][axis]));
        let is_flat = find(['i', 'j', 'k'][normal]).is_none() && is_level;
        let [Some(a), Some(b)] = via else { return Err(unknown_position(words)) };
        let value = |word: &Word, from: f64| {
            if word.distance.unwrap_or(self.distance) == Distance::Absolute { word.value } else { from + word.value }
        };
        let via = [value(a, start[0]), value(b, start[1])];
        let found = circle_through(start, via, end).filter(|_| is_flat);
        found.ok_or_else(|| refuse(a, "three points of an arc in the plane"))
    }

    /// Returns the arc or line (CT) from `start` to `end` along the tangent of the motion before; `None` if that is not known, or leads away.
    fn tangential(&self, start: Point, end: Point) -> Option<(MotionCode, Option<Point>)> {
        let [t, u] = self.waiting.as_ref()?.element.as_ref()?.tangent(true);
        let [x, y] = [end[0] - start[0], end[1] - start[1]];
        let (aside, along) = (t * y - u * x, t * x + u * y);
        if aside.abs() > 1e-9 * libm::hypot(x, y) {
            let radius = (x * x + y * y) / (2.0 * aside);
            let turn = if radius > 0.0 { TurnDirection::CounterClockwise } else { TurnDirection::Clockwise };
            return Some((MotionCode::Arc(turn), Some([start[0] - u * radius, start[1] + t * radius])));
        }
        (along > 0.0).then_some((MotionCode::Line, None))
    }

    /// Returns the full turns of an arc before its last move, of a helix all its lines; `None` for a number of turns that it cannot have.
    fn turns(&self, words: &[Word], span: &Span, (start, end): (Point, Point), about: About) -> Option<Vec<Move>> {
        let (Span { from, to, named, is_helix }, (centre, turn)) = (*span, about);
        let normal = self.plane.axes()[2];
        let find = |letter: char| words.iter().find(|word| word.letter == letter);
        let arc = sweep(start, end, centre, turn);
        let turns = match (find('t'), find('a')) {
            (Some(word), _) => word.value,
            (None, Some(word)) if self.dialect == Dialect::Heidenhain && word.distance.is_some() => {
                let is_right = (word.value > 0.0) == (arc > 0.0);
                let turns = (word.value.abs().to_radians() - arc.abs()) / TAU;
                if is_right { turns.round() } else { f64::NAN }
            }
            _ => 0.0,
        };
        let rises = named[normal] && from[normal].zip(to[normal]).is_none();
        if !(0.0..=999.0).contains(&turns)
            || turns.fract() != 0.0
            || ((turns > 0.0 || is_helix) && (rises || words.iter().any(is_rotary)))
        {
            return None;
        }
        let whole = arc.abs() + TAU * turns;
        if is_helix {
            // Older controls have no other block for it than CP.
            return self.chords(from, to, centre, whole.copysign(arc));
        }
        let full_turn = |number: u32| {
            let share = f64::from(number) * TAU / whole;
            let mut at = from;
            at[normal] = from[normal].zip(to[normal]).map(|(from, to)| from + share * (to - from));
            Move { code: MotionCode::Arc(turn), to: span.written(at), centre: Some(centre) }
        };
        Some((1..=turns as u32).map(full_turn).collect())
    }

    /// Returns the lines that a helix about `centre`, which turns by `sweep` (rad), is within [`CHORD_MM`] of; `None` if its ends
    /// are not known, it has no radius, or too many turns.
    fn chords(&self, from: [Option<f64>; 3], to: [Option<f64>; 3], centre: [f64; 2], sweep: f64) -> Option<Vec<Move>> {
        let [first, second, normal] = self.plane.axes();
        let (a, b, low, high) = (from[first]?, from[second]?, from[normal]?, to[normal]?);
        let arm = [a - centre[0], b - centre[1]];
        let radius_mm = libm::hypot(arm[0], arm[1]) * self.unit.mm();
        let most = 2.0 * libm::acos((1.0 - CHORD_MM / radius_mm).max(0.0));
        let count = (sweep.abs() / most).ceil().max(1.0);
        if radius_mm < CHORD_MM || count > MAX_CHORDS {
            return None;
        }
        let count = count as u32;
        let chord = |k: u32| {
            let share = f64::from(k) / f64::from(count);
            let [x, y] = turn(arm, (sweep * share).to_degrees());
            let mut at = to;
            if k < count {
                (at[first], at[second]) = (Some(centre[0] + x), Some(centre[1] + y));
                at[normal] = Some(low + (high - low) * share);
            }
            Move { code: MotionCode::Line, to: at, centre: None }
        };
        Some((1..=count).map(chord).collect())
    }

    /// Returns the centre of an arc by its words, `None` if its ends are unknown.
    fn centre_of(
        &self,
        words: &[Word],
        ends: Option<([f64; 2], [f64; 2])>,
        turn: TurnDirection,
        is_polar: bool,
    ) -> Result<Option<[f64; 2]>, Refusal> {
        let Some((from, to)) = ends else { return Ok(None) };
        let [first, second, _] = self.plane.axes();
        let find = |letter: char| words.iter().find(|word| word.letter == letter);
        if let Some(word) = find('R') {
            return centre_by_radius(from, to, word.value, turn)
                .map(Some)
                .map_err(|fault| word.refuse(Fault::Arc(fault)));
        }
        let centre = [find(['I', 'J', 'K'][first]), find(['I', 'J', 'K'][second])];
        if self.dialect == Dialect::Heidenhain || (is_polar && centre == [None; 2]) {
            return Ok(self.pole);
        }
        let value = |word: Option<&Word>, from: f64| match word {
            Some(word) if word.distance == Some(Distance::Absolute) => word.value,
            word => from + word.map_or(0.0, |word| word.value),
        };
        Ok(Some([value(centre[0], from[0]), value(centre[1], from[1])]))
    }

    /// Sets the pole by G110 to G112.
    fn set_pole(&mut self, line: usize, words: &[Word], word: &Word) -> Result<(), Refusal> {
        let [first, second, _] = self.plane.axes();
        let from = match word.value {
            110.0 => self.at[first].zip(self.at[second]).map(|(a, b)| [a, b]),
            112.0 => self.pole,
            _ => Some([0.0; 2]),
        };
        let from = from.ok_or_else(|| refuse(word, "a position that is known before it"))?;
        let find = |letter: char| words.iter().find(|word| word.letter == letter);
        if find('a').or(find('p')).is_some() {
            return Err(refuse(word, "the pole in X, Y or Z"));
        }
        let value = |axis: usize| find(['X', 'Y', 'Z'][axis]).map_or(0.0, |word| word.value);
        self.pole = Some([from[0] + value(first), from[1] + value(second)]);
        self.polar = [None; 2];
        let text = self.without_motion(line, words, "");
        self.hold(text, line, (None, None));
        Ok(())
    }

    /// Changes the frame by TRANS (`afresh`) or ATRANS, or ROT, AROT and their kin; what is written has its shift alone.
    fn set_frame(&mut self, line: usize, words: &[Word], verb: &Word, afresh: Option<bool>) -> Result<(), Refusal> {
        self.flush(None)?;
        let axes = ['X', 'Y', 'Z'].map(|letter| words.iter().find(|word| word.letter == letter));
        let value = |axis: usize| axes[axis].map_or(0.0, |word: &Word| word.value);
        let [first, second, normal] = self.plane.axes();
        // RPL stands alone: beside an axis it would leave open which of them counts.
        let in_plane = words.iter().find(|word| word.letter == 'l');
        let is_bare = axes == [None; 3] && in_plane.is_none();
        let is_open = axes != [None; 3] && in_plane.is_some();
        let (old, shift) = (self.angle, self.shift);
        let turned = turn([value(first), value(second)], old);
        match (afresh, verb.value as u32) {
            (Some(true), _) => (self.angle, self.shift) = (0.0, [0, 1, 2].map(value)),
            (Some(false), _) => {
                let steps: [f64; 3] = match self.dialect {
                    // CYCL DEF 7 sets axis by axis; what stands there moves as the reader says.
                    Dialect::Heidenhain => [0.0; 3],
                    _ => std::array::from_fn(|axis| {
                        if axis == first {
                            turned[0]
                        } else if axis == second {
                            turned[1]
                        } else {
                            value(normal)
                        }
                    }),
                };
                (0..3).for_each(|axis| self.shift[axis] += steps[axis]);
            }
            (None, _) if is_open => return Err(refuse(verb, "RPL alone, or axes without it")),
            (None, 0 | 2) if is_bare => (self.angle, self.shift) = (0.0, [0.0; 3]),
            (None, 0 | 1) if value(first) == 0.0 && value(second) == 0.0 => {
                let angle = in_plane.map_or(value(normal), |word| word.value);
                (self.angle, self.shift) = if verb.value == 0.0 { (angle, [0.0; 3]) } else { (old + angle, shift) };
            }
            (None, 2 | 3) if axes.iter().flatten().all(|word| word.value == 1.0) => {
                if verb.value == 2.0 {
                    (self.angle, self.shift) = (0.0, [0.0; 3]);
                }
            }
            _ => return Err(refuse(verb, "a rotation in the plane, and neither scale nor mirror")),
        }
        let is_turned = old != self.angle;
        for axis in (0..3).filter(|_| self.dialect == Dialect::Sinumerik) {
            self.has_new_zero[axis] |= shift[axis] != self.shift[axis] || (is_turned && axis != normal);
        }
        // Where the tool stands, in the new coordinates.
        let at = self.at;
        let plane = at[first].zip(at[second]).map(|(a, b)| {
            let at = turn([a, b], old);
            turn([at[0] + shift[first] - self.shift[first], at[1] + shift[second] - self.shift[second]], -self.angle)
        });
        self.at[normal] = at[normal].map(|at| at + shift[normal] - self.shift[normal]);
        let moved = |axis: usize| at[axis].map(|at| at + shift[axis] - self.shift[axis]);
        let single = if old == 0.0 && self.angle == 0.0 { [moved(first), moved(second)] } else { [None; 2] };
        (self.at[first], self.at[second]) = plane.map_or((single[0], single[1]), |[a, b]| (Some(a), Some(b)));
        self.polar[1] = None;
        if self.dialect == Dialect::Heidenhain {
            self.forget();
        } else {
            self.pole = self.pole.filter(|pole| *pole == [0.0; 2]);
        }
        let text = if old == 0.0 && self.angle == 0.0 && afresh.is_some() {
            self.content(line).to_vec()
        } else {
            let named = [0, 1, 2].into_iter().filter(|axis| self.shift[*axis] != 0.0);
            let words_of =
                named.map(|axis| format!(" {}{}", ['X', 'Y', 'Z'][axis], long_number(b'X', self.shift[axis])));
            let trans = format!("TRANS{}", words_of.collect::<String>());
            self.without_motion(line, words, &trans)
        };
        self.hold(text, line, (None, None));
        Ok(())
    }

    /// Returns a line with `text` in place of its words that say where it moves.
    fn without_motion(&mut self, line: usize, words: &[Word], text: &str) -> Vec<u8> {
        self.written.2 = true;
        let content = self.content(line);
        let is_moved = |word: &&Word| match word.letter {
            'X' | 'Y' | 'Z' | 'I' | 'J' | 'K' | 'R' | Word::SENSE => true,
            'G' if word.meaning.is_none() && (110.0..=112.0).contains(&word.value) => true,
            'G' => {
                let meaning = word.meaning.map_or_else(|| self.dialect.g_word(word), |vocable| Ok(vocable.meaning));
                matches!(meaning, Ok(GWord::Motion(_) | GWord::Setting(_)))
            }
            _ => word.is_of_contour(),
        };
        let (mut out, mut from, mut text) = (Vec::new(), 0, Some(text).filter(|text| !text.is_empty()));
        for word in words.iter().filter(is_moved) {
            let before = &content[from..word.span.start];
            out.extend_from_slice(if text.is_some() || from == 0 { before } else { before.trim_ascii_end() });
            out.extend(text.take().unwrap_or_default().bytes());
            from = word.span.end;
        }
        out.extend_from_slice(&content[from..]);
        out
    }

    /// Writes the waiting motion, if there is one, up to where its corner before `next` begins, and the corner.
    fn flush(&mut self, next: Option<&mut Waiting>) -> Result<(), Refusal> {
        let line = self.waiting.as_ref().map(|waiting| waiting.line);
        self.write_waiting(next).inspect_err(|_| self.refused = line)
    }

    /// Returns where the corner between the `waiting` motion and `next` begins and ends; `None` where there is none.
    fn corner_of(&self, waiting: &Waiting, next: Option<&Waiting>) -> Result<Option<CutCorner>, Refusal> {
        let Some(cut) = waiting.corner else { return Ok(None) };
        let is_explicit = waiting.words.iter().any(|word| matches!(word.letter, 'f' | 'c' | 'h'))
            || self.dialect == Dialect::Heidenhain;
        let fail = || {
            let expected =
                "a corner in the plane between two blocks, one behind the other, of lines or arcs that are long enough";
            waiting.words.first().map_or_else(|| Refusal::new(0..0, Fault::NoMotion), |word| refuse(word, expected))
        };
        let ends = waiting.element.as_ref().zip(next.and_then(|next| next.element.as_ref()));
        let corner = match ends {
            Some((a, b)) if waiting.moves.len() == 1 && next.is_some_and(|next| next.moves.len() == 1) => match cut {
                Corner::Arc(radius) => round_corner(a, b, radius),
                Corner::Chamfer(length) => a.chamfer(b, length, false),
                Corner::Leg(length) => a.chamfer(b, length, true),
            }
            .map_err(|()| fail())?,
            _ if is_explicit => return Err(fail()),
            _ => None,
        };
        let next_words = next.map_or(&[][..], |next| &next.words);
        let is_turned = waiting.words.iter().chain(next_words).any(is_rotary);
        if corner.is_some() && (waiting.is_interrupted || is_turned) {
            return Err(fail());
        }
        Ok(corner)
    }

    fn write_waiting(&mut self, next: Option<&mut Waiting>) -> Result<(), Refusal> {
        let Some(mut waiting) = self.waiting.take() else { return Ok(()) };
        let [first, second, _] = self.plane.axes();
        let corner = self.corner_of(&waiting, next.as_deref())?;
        let Waiting { line, words, prefix, mut moves, held, open, .. } = waiting;
        if let (Some((begin, arc, end)), Some(next)) = (corner, next) {
            let place = |p: [f64; 2]| {
                let mut to = [None; 3];
                (to[first], to[second]) = (Some(p[0]), Some(p[1]));
                to
            };
            if let Some(last) = moves.last_mut() {
                last.to = place(begin);
            }
            let code = arc.map_or(MotionCode::Line, |(_, turn)| MotionCode::Arc(turn));
            moves.push(Move { code, to: place(end), centre: arc.map(|(centre, _)| centre) });
            if let Some(element) = &mut next.element {
                element.from = end;
            }
            if let Some(last) = next.moves.last_mut() {
                (last.to[first], last.to[second]) =
                    next.element.as_ref().map_or((None, None), |e| (Some(e.to[0]), Some(e.to[1])));
            }
            (waiting.is_rewritten, next.is_rewritten) = (true, true);
        }
        let names_motion =
            words.iter().any(|word| word.letter == 'G' && matches!(word.tenths(), Some(0 | 10 | 20 | 30)));
        let needs_code =
            self.dialect == Dialect::Sinumerik && !names_motion && self.code != moves.first().map(|one| one.code);
        let is_about_pole = self.dialect == Dialect::Heidenhain && words.iter().all(|word| word.letter != 'R');
        let has_other_pole = is_about_pole && moves.iter().any(|one| one.centre.is_some() && one.centre != self.centre);
        let has_corner_word = words.iter().any(|word| word.is_of_contour());
        if !(waiting.is_rewritten || needs_code || has_other_pole || has_corner_word) {
            self.code = moves.last().map(|one| one.code);
            self.write(self.content(line), line);
        } else if let Some(word) = open {
            return Err(refuse(&word, "a position that is known before it"));
        } else {
            let lead = &self.content(line)[..prefix];
            for (number, one) in moves.iter().enumerate() {
                let text = self.move_text(one, lead, line);
                if number > 0 {
                    self.write(&[lead, text.as_bytes()].concat(), line);
                    continue;
                }
                let whole = self.without_motion(line, &words, &text);
                let late = words.iter().find(|word| acts_at_end(word)).filter(|_| moves.len() > 1 && corner.is_none());
                if let Some(word) = late {
                    return Err(refuse(word, "M functions that act behind a motion in a block of their own"));
                }
                self.write(&whole, line);
            }
        }
        for (text, line, in_force) in held {
            self.hold(text, line, in_force);
        }
        Ok(())
    }

    /// Returns the words of a move, and writes the centre of an arc before it where the dialect has that in a block of its own.
    fn move_text(&mut self, one: &Move, lead: &[u8], line: usize) -> String {
        let [first, second, _] = self.plane.axes();
        let mut to = one.to;
        if let (Some(a), Some(b)) = (to[first], to[second]) {
            let [a, b] = turn([a, b], self.angle);
            (to[first], to[second]) = (Some(a), Some(b));
        }
        let centre = one.centre.map(|centre| turn(centre, self.angle));
        let named = |to: [Option<f64>; 3]| (0..3).filter_map(move |axis| Some((axis, to[axis]?)));
        self.code = Some(one.code);
        if self.dialect == Dialect::Sinumerik {
            let words =
                named(to).map(|(axis, value)| format!(" {}=AC({})", ['X', 'Y', 'Z'][axis], long_number(b'X', value)));
            let about = centre.into_iter().flat_map(|[a, b]| [(first, a), (second, b)]);
            let about =
                about.map(|(axis, value)| format!(" {}=AC({})", ['I', 'J', 'K'][axis], long_number(b'X', value)));
            return format!("G{}{}", one.code.number(), words.chain(about).collect::<String>());
        }
        let word = |(axis, value): (usize, f64)| format!(" {}{}", ['X', 'Y', 'Z'][axis], signed(value));
        if let Some([a, b]) = centre.filter(|_| one.centre != self.centre) {
            let mut words = [(first, a), (second, b)];
            words.sort_by_key(|(axis, _)| *axis);
            self.write(&[lead, format!("CC{}{}", word(words[0]), word(words[1])).as_bytes()].concat(), line);
            self.centre = one.centre;
        }
        let words: String = named(to).map(word).collect();
        match one.code {
            MotionCode::Arc(TurnDirection::Clockwise) => format!("C{words} DR-"),
            MotionCode::Arc(TurnDirection::CounterClockwise) => format!("C{words} DR+"),
            _ => format!("L{words}"),
        }
    }
}

/// How far the lines that a helix becomes may be from it, mm.
const CHORD_MM: f64 = 0.001;
/// Most lines of a helix.
const MAX_CHORDS: f64 = 100_000.0;

/// Returns the line or arc of a move at feed; `None` of a rapid one, or an arc whose centre is not known.
fn fed_element(code: MotionCode, centre: Option<Point>, from: Point, to: Point) -> Option<Element> {
    let arc = match (code, centre) {
        (MotionCode::Arc(turn), Some(centre)) => Some((centre, turn)),
        (MotionCode::Arc(_) | MotionCode::Rapid, _) | (_, Some(_)) => return None,
        (_, None) => None,
    };
    Some(Element { from, to, arc })
}

/// Whether `word` is A, B or C.
fn is_rotary(word: &Word) -> bool {
    matches!(word.letter, 'A' | 'B' | 'C')
}

/// Returns `p` turned by `angle` degrees.
fn turn(p: [f64; 2], angle: f64) -> [f64; 2] {
    if angle == 0.0 {
        return p;
    }
    let (sin, cos) = libm::sincos(angle.to_radians());
    [p[0] * cos - p[1] * sin, p[0] * sin + p[1] * cos]
}

/// Formats a coordinate with its sign, plus included.
pub(crate) fn signed(value: f64) -> String {
    let text = long_number(b'X', value);
    if text.starts_with('-') { text } else { format!("+{text}") }
}
