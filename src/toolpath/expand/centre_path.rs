//! Cutter radius compensation (G41, G42; RL, RR) as the path of the tool centre.
//!
//! The centre runs beside the programmed contour at the radius of the cutter: around outer corners on an arc, through the point where the
//! parallels meet at inner ones. It reaches the contour, and leaves it, square to its first and its last block. What would cut into the contour
//! is refused, also where a control would make it.

use std::collections::BTreeMap;

use crate::toolpath::{
    expand::{
        contour::signed,
        edit::LineEdit,
        geometry::{Element, Point},
        line::{SourceLine, long_number, word_number},
    },
    model::{
        MotionGeometry, Plane, TurnDirection,
        gcode::{
            CutterOf, Dialect, Distance, Fault, FeedMode, GWord, GcodeError, Motion, MotionCode, RadiusFault, Refusal,
            Setting, Word, located,
        },
    },
    read::gcode::{
        Block, LineReader, Program, Statement, Style,
        lines::{self, Lines},
    },
};

/// Lines and arcs that meet at less than this angle have no corner, rad.
const SMOOTH_RAD: f64 = 1e-6;
/// Elements that turn back by less have no side on which the cutter goes round, rad.
const BACK_RAD: f64 = 1e-3;
/// At outer corners the parallels are prolonged where that leaves the cutter nearer to its radius than this, mm.
const MITRE_MM: f64 = 1e-4;
/// A contour whose ends are nearer to one another is closed, mm.
const CLOSED_MM: f64 = 1e-3;
/// How far into the contour rounding may lead, mm.
const ROUNDING_MM: f64 = 1e-5;

/// What a line switches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Switch {
    /// 1 with the cutter to the left of the contour, -1 to the right, 0 with its centre on it.
    side: f64,
    /// Number of the D word in force.
    offset: Option<u32>,
    /// Radius that the line gives itself (LinuxCNC's G41.1), in the unit of the program.
    radius: Option<f64>,
}

/// What lines switch, by their index.
pub(crate) type Switches = BTreeMap<usize, Switch>;

/// Radii in use, mm, with what they are of.
pub(crate) type RadiiInUse = BTreeMap<CutterOf, f64>;

/// Takes compensation out of `source`, which then is the contour alone with G40 or R0; returns what it was. `Err` gives the index of the line.
pub(crate) fn take_switches(source: &mut Vec<u8>, dialect: Dialect) -> Result<Switches, (usize, Refusal)> {
    let all = Lines::split(source);
    let (mut switches, mut bytes) = (Switches::new(), Vec::with_capacity(source.len()));
    let mut reader = match dialect.is_iso() {
        true => LineReader::new(dialect),
        false => LineReader::of_contours(dialect),
    };
    let (mut offset, mut has_delta) = (None, false);
    for line in 0..all.len() {
        let content = &source[all.content(line)];
        let (switch, text) = match dialect {
            Dialect::Heidenhain => {
                let code = SourceLine::of(content, dialect).code;
                if code.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ').starts_with("TOOL CALL") {
                    has_delta = code.contains(" DR");
                }
                let found = conversational_switch(&code);
                if let Some((at, _)) = found.filter(|(_, side)| has_delta && *side != 0.0) {
                    return Err((line, Refusal::new(at..at + 2, Fault::Radius(RadiusFault::Delta))));
                }
                found.map_or((None, None), |(at, side)| {
                    let text = [&content[..at], b"R0", &content[at + 2..]].concat();
                    (Some(Switch { side, offset: None, radius: None }), Some(text))
                })
            }
            _ => match reader.parse_line(content) {
                Ok(Statement::Words { words, .. }) => {
                    let d = words.iter().find(|word| word.letter == 'D');
                    offset = d.and_then(|word| word.whole_number().ok()).or(offset);
                    coded_switch(&words, dialect, offset).map_or((None, None), |(at, switch)| {
                        let mut edit = LineEdit::new(content, &words, Style::plain(dialect));
                        edit.replace(at, "G40".into());
                        if let Some(index) = edit.find(|word| word.letter == 'D' && dialect.is_iso()) {
                            edit.remove(index);
                        }
                        (Some(switch), Some(edit.render()))
                    })
                }
                // What cannot be read is refused later.
                _ => (None, None),
            },
        };
        switches.extend(switch.map(|switch| (line, switch)));
        bytes.extend_from_slice(text.as_deref().unwrap_or(content));
        bytes.extend_from_slice(&source[all.ending(line)]);
    }
    if switches.values().any(|switch| switch.side != 0.0) {
        *source = bytes;
        Ok(switches)
    } else {
        Ok(Switches::new())
    }
}

/// Returns where the G word of compensation stands among `words`, and what it switches.
fn coded_switch(words: &[Word], dialect: Dialect, offset: Option<u32>) -> Option<(usize, Switch)> {
    words.iter().enumerate().filter(|(_, word)| word.letter == 'G').find_map(|(at, word)| {
        let own = || words.iter().find(|word| word.letter == 'D').map(|word| word.value / 2.0);
        let (side, radius) = match word.tenths()? {
            400 => (0.0, None),
            410 => (1.0, None),
            420 => (-1.0, None),
            411 if dialect == Dialect::LinuxCnc => (1.0, Some(own()?)),
            421 if dialect == Dialect::LinuxCnc => (-1.0, Some(own()?)),
            _ => return None,
        };
        Some((at, Switch { side, offset, radius }))
    })
}

/// Returns where RL, RR or R0 stands in a line of Heidenhain's, and the side.
fn conversational_switch(code: &str) -> Option<(usize, f64)> {
    let verb = code.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ' || c == '/');
    let moves = ["L ", "C ", "CR ", "CT ", "LP ", "CP ", "CTP "].iter().any(|begin| verb.starts_with(begin));
    let is_free = |byte: Option<&u8>| byte.is_none_or(|byte| !byte.is_ascii_alphanumeric() && !b".,".contains(byte));
    [("RL", 1.0), ("RR", -1.0), ("R0", 0.0)].into_iter().find_map(|(text, side)| {
        let bytes = code.as_bytes();
        let mut ends = code.match_indices(text).map(|(at, _)| at);
        let at =
            ends.find(|at| is_free(bytes.get(at + 2)) && is_free(at.checked_sub(1).and_then(|at| bytes.get(at))))?;
        moves.then_some((at, side))
    })
}

/// A motion in compensation.
struct Piece {
    line: usize,
    prefix: usize,
    has_motion_word: bool,
    motion: Motion,
    /// Its line or arc in the plane, if it has a length there.
    element: Option<Element>,
}

impl Piece {
    fn is_rapid(&self) -> bool {
        self.motion.code == MotionCode::Rapid
    }
}

/// A contour with compensation: the move to it, the contour, and the move away from it.
struct Section {
    switch: Switch,
    /// Radius of the cutter, signed: positive to the left, mm; 0 before the first piece.
    distance: f64,
    pieces: Vec<Piece>,
    /// Whether compensation is switched off, and whether the last piece leads away from the contour.
    ends: bool,
    is_left: bool,
}

/// A corner between two elements of a contour.
struct Corner {
    /// Where the centre is at the end of the first and the start of the second.
    points: [Point; 2],
    /// Sense of the arc from one to the other.
    turn: Option<TurnDirection>,
}

/// A program in which the contours with compensation are found and written as the path of the centre.
struct CentrePath<'p> {
    program: &'p Program,
    switches: &'p Switches,
    section: Option<Section>,
    /// New lines in place of those with these indices.
    lines: BTreeMap<usize, Vec<Vec<u8>>>,
    radii: RadiiInUse,
}

impl Program {
    /// Returns the program, which is the contour without compensation, with the path of the tool centre where `switches` switch it on, and the
    /// index of the line that each of its lines comes from. `Err` for what is not followed.
    pub(crate) fn with_centre_path(
        &self,
        switches: &Switches,
    ) -> Result<(Vec<u8>, Vec<usize>, RadiiInUse), GcodeError> {
        let mut path =
            CentrePath { program: self, switches, section: None, lines: BTreeMap::new(), radii: RadiiInUse::new() };
        self.walk_words(
            |line, words| (line, self.obstacle(words)),
            |block, (line, obstacle)| {
                path.follow(line, block, obstacle).map_err(|(line, refusal)| self.located(line, refusal))
            },
        )?;
        path.close().map_err(|(line, refusal)| self.located(line, refusal))?;
        let (mut bytes, mut origins) = (Vec::with_capacity(self.source.len()), Vec::new());
        for line in 0..self.lines.len() {
            let own = [self.content(line).to_vec()];
            for text in path.lines.get(&line).map_or(&own[..], |lines| lines) {
                bytes.extend_from_slice(text);
                bytes.extend_from_slice(self.lines.ending_or_newline(&self.source, line));
                origins.push(line);
            }
        }
        Ok((bytes, origins, path.radii))
    }

    fn located(&self, line: usize, refusal: Refusal) -> GcodeError {
        refusal.locate(&self.name, line + 1, self.content(line)).with_dialect(self.dialect)
    }

    /// Returns the word of a line that must not stand in compensation, and whether not behind its end either.
    fn obstacle(&self, words: &[Word]) -> Option<(Word, bool)> {
        words.iter().find_map(|word| {
            if word.letter == 'M' && word.value == 6.0 {
                return Some((word.clone(), false));
            }
            let meaning = match word.meaning {
                Some(vocable) => vocable.meaning,
                None if word.letter == 'G' => self.dialect.g_word(word).ok()?,
                None => return None,
            };
            let is_of_zero = match meaning {
                GWord::Setting(Setting::Pole) => return None,
                GWord::Setting(_)
                | GWord::Align(_)
                | GWord::FindAngles(_)
                | GWord::TipControl
                | GWord::TipControlEnds => true,
                GWord::Plane(Plane::Xy) => return None,
                GWord::Plane(_)
                | GWord::Unit(_)
                | GWord::UnitOfCoordinates(_)
                | GWord::WorkOffset(_)
                | GWord::Preset
                | GWord::Home
                | GWord::Machine
                | GWord::Retract
                | GWord::Motion(MotionCode::Cycle(_))
                | GWord::Feed(FeedMode::InverseTime) => false,
                _ => return None,
            };
            Some((word.clone(), is_of_zero))
        })
    }
}

/// A refusal with the index of its line.
type Located = (usize, Refusal);

impl CentrePath<'_> {
    /// Follows a line with its block, if it is one, and the word in it that may be an obstacle.
    fn follow(&mut self, line: usize, block: Option<&Block>, obstacle: Option<(Word, bool)>) -> Result<(), Located> {
        let refuse = |line: usize, fault: RadiusFault| {
            let content = self.program.content(line);
            let begin = lines::prefix_len(content);
            (line, Refusal::new(begin..content.len().max(begin), Fault::Radius(fault)))
        };
        if let Some(switch) = self.switches.get(&line) {
            match &mut self.section {
                Some(section) if switch.side == 0.0 => section.ends = true,
                Some(section) if !section.ends && section.switch == *switch => {}
                Some(_) => return Err(refuse(line, RadiusFault::Changed)),
                None if switch.side == 0.0 => {}
                None => {
                    let (switch, pieces) = (*switch, Vec::new());
                    self.section = Some(Section { switch, distance: 0.0, pieces, ends: false, is_left: false });
                }
            }
        }
        let Some(section) = &self.section else { return Ok(()) };
        if let Some((word, _)) = obstacle.filter(|(_, is_of_zero)| !section.ends || *is_of_zero) {
            return Err((line, word.refuse(Fault::Radius(RadiusFault::Inside))));
        }
        let Some(block) = block else { return Ok(()) };
        for motion in &block.motions {
            let has_plane_words = motion.words.iter().any(|word| matches!(word.letter, 'X' | 'Y' | 'I' | 'J'));
            let Some(section) = &self.section else { return Ok(()) };
            if !has_plane_words {
                continue;
            }
            let (is_first, switch) = (section.pieces.is_empty(), section.switch);
            if is_first && section.ends {
                // Nothing was cut in it.
                self.section = None;
                return Ok(());
            }
            let at_motion = |fault| (line, Refusal::new(motion.span.clone(), Fault::Radius(fault)));
            let distance = match is_first {
                true => self.radius(&switch, motion).map_err(at_motion)? * switch.side,
                false => section.distance,
            };
            let Some(section) = &mut self.section else { return Ok(()) };
            section.distance = distance;
            let is_arc = matches!(motion.code, MotionCode::Arc(_));
            if motion.turning.turns() {
                return Err(at_motion(RadiusFault::Turns));
            }
            if is_arc && (is_first || section.ends) {
                return Err(at_motion(RadiusFault::Arc));
            }
            let ends = motion.end[0].zip(motion.end[1]).map(|(x, y)| [x, y]);
            let element = match motion.geometry {
                MotionGeometry::Line(from, to) => element([from.x, from.y], [to.x, to.y], None),
                MotionGeometry::Arc(arc) => {
                    let MotionCode::Arc(turn) = motion.code else { return Err(at_motion(RadiusFault::Inside)) };
                    let (from, to) = (motion.start, motion.end);
                    let (Some(from), Some(to)) = (located(from), located(to)) else {
                        return Err(at_motion(RadiusFault::Unknown));
                    };
                    if arc.sweep_rad().abs() > std::f64::consts::TAU + 1e-9 || motion.modal.plane != Plane::Xy {
                        return Err(at_motion(RadiusFault::Inside));
                    }
                    Some(Element { from: [from.x, from.y], to: [to.x, to.y], arc: Some((arc.centre(), turn)) })
                }
                // Its height may not be known yet.
                _ => {
                    motion.start[0].zip(motion.start[1]).zip(ends).and_then(|(from, to)| element(from.into(), to, None))
                }
            };
            if ends.is_none() {
                match section.ends {
                    // From a place that the machine knows.
                    true => return self.close(),
                    false => return Err(at_motion(RadiusFault::Unknown)),
                }
            }
            let piece = Piece {
                line,
                prefix: block.prefix,
                has_motion_word: block.motion_word.is_some(),
                motion: motion.clone(),
                element,
            };
            section.pieces.push(piece);
            if section.ends {
                section.is_left = true;
                return self.close();
            }
        }
        Ok(())
    }

    /// Returns the radius, mm, for `switch` where `motion` leads to the contour, and keeps what it is of.
    fn radius(&mut self, switch: &Switch, motion: &Motion) -> Result<f64, RadiusFault> {
        if let Some(radius) = switch.radius {
            return Ok(radius * motion.modal.unit.mm());
        }
        // Of Sinumerik, D is of a tool.
        let offset = switch.offset.filter(|_| self.program.dialect.is_iso());
        let names = [offset.map(CutterOf::Offset), motion.modal.tool.map(CutterOf::Tool)];
        let radii = self.program.options.cutter_radii_mm.as_ref();
        let found = names.into_iter().flatten().find_map(|name| Some((name, *radii?.get(&name)?)));
        let (name, radius) = match (found, offset) {
            (Some(found), _) => found,
            (None, Some(0)) => (CutterOf::Offset(0), 0.0),
            (None, _) => return Err(RadiusFault::NotGiven { of: names.into_iter().flatten().next() }),
        };
        self.radii.insert(name, radius);
        Ok(radius)
    }

    /// Writes the section that ends here, if there is one.
    fn close(&mut self) -> Result<(), Located> {
        let Some(section) = self.section.take() else { return Ok(()) };
        let contour: Vec<usize> = (1..section.pieces.len().saturating_sub(usize::from(section.is_left)))
            .filter(|index| section.pieces[*index].element.is_some())
            .collect();
        let Some(first) = contour.first() else { return Ok(()) };
        let elements: Vec<&Element> =
            contour.iter().filter_map(|index| section.pieces[*index].element.as_ref()).collect();
        let refuse = |index: usize, fault: RadiusFault| {
            let Piece { line, motion, .. } = &section.pieces[index];
            (*line, Refusal::new(motion.span.clone(), Fault::Radius(fault)))
        };
        // Where the centre is at the start and the end of each element, and the corner before it.
        let distance = section.distance;
        let mut ways = vec![[elements[0].beside(false, distance); 2]; elements.len()];
        let mut turns = vec![None; elements.len()];
        for at in 1..elements.len() {
            let is_rapid = [at - 1, at].map(|at| section.pieces[contour[at]].is_rapid());
            let corner = corner([elements[at - 1], elements[at]], is_rapid, distance)
                .map_err(|fault| refuse(contour[at], fault))?;
            (ways[at - 1][1], ways[at][0], turns[at]) = (corner.points[0], corner.points[1], corner.turn);
        }
        ways[elements.len() - 1][1] = elements[elements.len() - 1].beside(true, distance);
        for (at, element) in elements.iter().enumerate() {
            if !keeps_its_way(element, ways[at], distance) {
                return Err(refuse(contour[at], RadiusFault::Narrow));
            }
        }
        let path = Path { section: &section, contour: &contour, elements: &elements, ways: &ways, turns: &turns };
        if let Some((index, line)) = path.cut_into() {
            return Err(refuse(index, RadiusFault::CutsInto { line: line + 1 }));
        }
        // The move to the contour ends, and that away from it starts, beside it.
        let mut at = section.pieces[0].motion.start[0].zip(section.pieces[0].motion.start[1]).map(|(x, y)| [x, y]);
        for (index, piece) in section.pieces.iter().enumerate() {
            let number = contour.partition_point(|other| *other < index);
            let (to, corner) = match () {
                () if index < *first => (ways[0][0], None),
                () if contour.get(number) == Some(&index) => (ways[number][1], turns[number]),
                () if section.is_left && index + 1 == section.pieces.len() => {
                    let [x, y, _] = piece.motion.end;
                    (x.zip(y).map_or([0.0; 2], |(x, y)| [x, y]), None)
                }
                () => (at.unwrap_or_default(), None),
            };
            let around = corner.map(|turn| (ways[number][0], elements[number].from, turn));
            self.write(piece, at, to, around).map_err(|fault| refuse(index, fault))?;
            at = Some(to);
        }
        Ok(())
    }

    /// Writes `piece` from `from` to `to`, behind the arc to a point about a corner if there is one there.
    fn write(
        &mut self,
        piece: &Piece,
        from: Option<Point>,
        to: Point,
        around: Option<(Point, Point, TurnDirection)>,
    ) -> Result<(), RadiusFault> {
        let motion = &piece.motion;
        let content = self.program.content(piece.line);
        let mut edit = LineEdit::new(content, &motion.words, self.program.style);
        let style = edit.style();
        let mm = motion.modal.unit.mm();
        let dialect = self.program.dialect;
        let number = |value: f64| match dialect.is_iso() {
            true => word_number(b'X', value),
            false => long_number(b'X', value),
        };
        let mut written = Vec::new();
        let mut begin = from;
        if let Some((end, centre, turn)) = around {
            let start = from.unwrap_or_default();
            begin = Some(end);
            let steps = motion.modal.distance == Distance::Incremental;
            let base = |axis: usize| if steps { start[axis] } else { motion.origin[axis] };
            let text = if dialect == Dialect::Heidenhain {
                let radius = libm::hypot(end[0] - centre[0], end[1] - centre[1]);
                let [x, y] = [0, 1].map(|axis| signed((end[axis] - motion.origin[axis]) / mm));
                let sense = if turn == TurnDirection::CounterClockwise { "+" } else { "-" };
                format!("CR X{x} Y{y} R{} DR{sense}", signed(radius / mm))
            } else {
                let middle = |axis: usize| match motion.modal.centres {
                    Distance::Absolute => motion.origin[axis],
                    Distance::Incremental => start[axis],
                };
                let mut words = vec![style.motion(MotionCode::Arc(turn))];
                words.extend([0, 1].map(|axis| style.axis(axis, &number((end[axis] - base(axis)) / mm))));
                let centres = [('I', 0), ('J', 1)];
                words.extend(centres.map(|(letter, at)| style.word(letter, &number((centre[at] - middle(at)) / mm))));
                words.join(style.separator())
            };
            written.push([&content[..piece.prefix], text.as_bytes()].concat());
        }
        let stays =
            |axis: usize, a: Option<Point>, b: Option<f64>| a.zip(b).is_none_or(|(a, b)| (a[axis] - b).abs() < 1e-9);
        let is_kept = around.is_none()
            && (0..2).all(|axis| stays(axis, begin, motion.start[axis]) && stays(axis, Some(to), motion.end[axis]));
        if is_kept {
            return Ok(());
        }
        for axis in 0..2 {
            let index = edit.find(|word| word.letter == ['X', 'Y'][axis]);
            let own = index.and_then(|index| motion.words[index].distance);
            let base = match own.unwrap_or(motion.modal.distance) {
                Distance::Absolute => motion.origin[axis],
                Distance::Incremental => begin.ok_or(RadiusFault::Unknown)?[axis],
            };
            let text = number((to[axis] - base) / mm);
            match index {
                Some(index) => edit.set_number(index, &text),
                None => edit.add_axis(axis, &text),
            }
        }
        if let (MotionCode::Arc(_), Some(Element { arc: Some((centre, _)), .. }), Some(begin)) =
            (motion.code, &piece.element, begin)
        {
            let find = |letter: char| motion.words.iter().position(|word| word.letter == letter);
            let radius = find('R');
            match radius {
                Some(index) if dialect == Dialect::Heidenhain => {
                    let size = libm::hypot(to[0] - centre[0], to[1] - centre[1]) / mm;
                    edit.set_number(index, &signed(size.copysign(motion.words[index].value)));
                }
                None if find('I').or(find('J')).is_none() => {}
                _ => {
                    if let Some(index) = radius {
                        edit.remove(index);
                    }
                    for (axis, letter) in [(0, 'I'), (1, 'J')] {
                        let own = find(letter).and_then(|index| motion.words[index].distance);
                        let base = match own.unwrap_or(motion.modal.centres) {
                            Distance::Absolute => motion.origin[axis],
                            Distance::Incremental => begin[axis],
                        };
                        edit.set_arc_word(letter, &number((centre[axis] - base) / mm));
                    }
                }
            }
        }
        if around.is_some() && !piece.has_motion_word && dialect != Dialect::Heidenhain {
            edit.set_motion(motion.code);
        }
        written.push(edit.render());
        self.lines.insert(piece.line, written);
        Ok(())
    }
}

/// Returns the element between two points; `None` if they are the same.
fn element(from: Point, to: Point, arc: Option<(Point, TurnDirection)>) -> Option<Element> {
    (libm::hypot(to[0] - from[0], to[1] - from[1]) > 1e-9).then_some(Element { from, to, arc })
}

/// Returns how the centre passes the corner between two elements, of which some are rapid.
fn corner([a, b]: [&Element; 2], is_rapid: [bool; 2], distance: f64) -> Result<Corner, RadiusFault> {
    let (end, start) = (a.beside(true, distance), b.beside(false, distance));
    let at_once = |point: Point| Ok(Corner { points: [point; 2], turn: None });
    match is_rapid {
        [true, false] => return at_once(start),
        [_, true] => return at_once(end),
        _ => {}
    }
    let angle = a.turn_to(b);
    if angle.abs() < SMOOTH_RAD || distance == 0.0 {
        return at_once(start);
    }
    if std::f64::consts::PI - angle.abs() < BACK_RAD {
        return Err(RadiusFault::TurnsBack);
    }
    let meeting = a.meeting(b, distance);
    if angle * distance > 0.0 {
        return at_once(meeting.ok_or(RadiusFault::Narrow)?);
    }
    let reach = |p: &Point| libm::hypot(p[0] - a.to[0], p[1] - a.to[1]) - distance.abs();
    if let Some(point) = meeting.filter(|point| reach(point) < MITRE_MM) {
        return at_once(point);
    }
    let turn = if angle > 0.0 { TurnDirection::CounterClockwise } else { TurnDirection::Clockwise };
    Ok(Corner { points: [end, start], turn: Some(turn) })
}

/// Whether the parallel of `element` from one point to another leads the same way as the element.
fn keeps_its_way(element: &Element, [from, to]: [Point; 2], distance: f64) -> bool {
    match element.arc {
        None => {
            let [x, y] = element.tangent(true);
            (to[0] - from[0]) * x + (to[1] - from[1]) * y > 0.0
        }
        Some(about) => {
            if element.parallel_radius(about, distance) < 1e-6 {
                return false;
            }
            // By how much the ends are moved along the arc.
            let moved = |p: Point, q: Point| {
                let [a, b] = [p, q].map(|p| libm::atan2(p[1] - about.0[1], p[0] - about.0[0]));
                let sense = if about.1 == TurnDirection::CounterClockwise { 1.0 } else { -1.0 };
                libm::remainder((b - a) * sense, std::f64::consts::TAU)
            };
            let [lost, added] = [moved(element.from, from), moved(element.to, to)];
            let whole = super::geometry::sweep(element.from, element.to, about.0, about.1).abs();
            whole + added - lost > 0.0 && lost < whole && -added < whole
        }
    }
}

/// A path of the centre beside its contour.
struct Path<'s> {
    section: &'s Section,
    /// Indices of the pieces of the contour.
    contour: &'s [usize],
    elements: &'s [&'s Element],
    ways: &'s [[Point; 2]],
    turns: &'s [Option<TurnDirection>],
}

impl Path<'_> {
    /// Returns the index of the first piece that cuts into the contour, with the line of the contour; `None` if none does.
    fn cut_into(&self) -> Option<(usize, usize)> {
        let Section { pieces, distance, is_left, .. } = self.section;
        let radius = distance.abs();
        if radius == 0.0 {
            return None;
        }
        let is_fed = |index: usize| !pieces[index].is_rapid();
        // The first and the last block of an open contour lead to the part and away from it, in air.
        let (Some(begin), Some(end)) = (self.elements.first(), self.elements.last()) else { return None };
        let is_closed = libm::hypot(begin.from[0] - end.to[0], begin.from[1] - end.to[1]) < CLOSED_MM;
        let skipped = usize::from(!is_closed);
        let count = self.elements.len().saturating_sub(2 * skipped);
        let contour: Vec<(usize, &Element, [Point; 2])> = (self.contour.iter().zip(self.elements))
            .skip(skipped)
            .take(count)
            .filter(|(index, _)| is_fed(**index))
            .map(|(index, element)| (*index, *element, element.bounds()))
            .collect();
        let cuts = |index: usize, way: &Element, but: Option<usize>| {
            let [low, high] = way.bounds();
            contour.iter().find_map(|(other, element, bounds)| {
                let is_apart = (0..2).any(|i| bounds[0][i] > high[i] + radius || bounds[1][i] < low[i] - radius);
                // Beside its own block, the way to the contour and from it is only to stay on its side.
                let rounding = ROUNDING_MM + way.radius_mismatch() + element.radius_mismatch();
                let least = if but == Some(*other) { 0.0 } else { radius - rounding };
                let is_near = !is_apart && way.distance(element) <= least;
                is_near.then_some((index, pieces[*other].line))
            })
        };
        let begin = pieces[0].motion.start[0].zip(pieces[0].motion.start[1]);
        let first = self.contour.first().copied();
        let to_it = begin.and_then(|(x, y)| element([x, y], self.ways[0][0], None)).filter(|_| is_fed(0));
        if let Some(found) = to_it.and_then(|way| cuts(0, &way, first)) {
            return Some(found);
        }
        for (at, &index) in self.contour.iter().enumerate().filter(|(_, index)| is_fed(**index)) {
            let own = self.elements[at];
            let arc = self.turns[at].map(|turn| Element {
                from: self.ways[at - 1][1],
                to: self.ways[at][0],
                arc: Some((own.from, turn)),
            });
            let [from, to] = self.ways[at];
            let found = arc.and_then(|arc| cuts(index, &arc, None));
            if let Some(found) = found.or_else(|| cuts(index, &Element { from, to, arc: own.arc }, None)) {
                return Some(found);
            }
        }
        let last = pieces.len() - 1;
        let away = pieces[last].motion.end[0].zip(pieces[last].motion.end[1]).filter(|_| *is_left && is_fed(last));
        let way = away.and_then(|(x, y)| element(self.ways.last()?[1], [x, y], None));
        way.and_then(|way| cuts(last, &way, self.contour.last().copied()))
    }
}
