//! Cutter radius compensation (G41, G42; RL, RR) as the path of the tool centre.
//!
//! The centre runs beside the programmed contour at the radius of the cutter: around outer corners on an arc, through the point where the
//! parallels meet at inner ones. It reaches the contour, and leaves it, square to its first and its last block. What would cut into the contour
//! is refused, also where a control would make it.

use std::collections::BTreeMap;

use crate::{
    expand::{
        beside::{corner, offset_keeps_direction},
        contour::signed,
        edit::LineEdit,
        geometry::{About, Element, Point, sweep},
        line::{long_number, word_number},
        switches::{Switch, Switches},
    },
    model::{
        MotionGeometry, Plane, TurnDirection,
        gcode::{
            CutterOf, Dialect, Distance, Fault, FeedMode, GWord, GcodeError, Motion, MotionCode, PartialPosition,
            RadiusFault, Refusal, Setting, Word, located,
        },
    },
    read::gcode::{Block, GcodeProgram, Style, lines},
};

/// A contour whose ends are nearer to one another is closed, mm.
const CLOSED_MM: f64 = 1e-3;
/// How far the path may be from where it is to be as it is read again, mm: controls read eight digits.
const READ_MM: f64 = 2e-3;
/// How far into the contour rounding may lead, mm.
const ROUNDING_MM: f64 = 1e-5;

/// Radii in use, mm, with what they are of.
pub(crate) type RadiiInUse = BTreeMap<CutterOf, f64>;

/// A motion in compensation.
struct Piece {
    line: usize,
    prefix: usize,
    has_motion_word: bool,
    motion: Motion,
    /// Distance modes, of coordinates and of centres, before the line.
    modes: [Distance; 2],
    /// Its line or arc in the plane, if it has a length there.
    element: Option<Element>,
}

impl Piece {
    fn is_rapid(&self) -> bool {
        self.motion.code == MotionCode::Rapid
    }

    /// What a number counts from: the origin, or where the move begins.
    fn base(&self, mode: Distance, from: Point, axis: usize) -> f64 {
        if mode == Distance::Absolute { self.motion.origin[axis] } else { from[axis] }
    }
}

/// A contour with compensation: the move to it, the contour, and the move away from it.
struct Section {
    switch: Switch,
    /// Number of the D word in force.
    offset: Option<u32>,
    /// Radius of the cutter, signed: positive to the left, mm; 0 before the first piece.
    distance: f64,
    pieces: Vec<Piece>,
    /// Whether compensation is switched off, and whether the last piece leads away from the contour.
    ends: bool,
    is_left: bool,
}

impl Section {
    /// Whether `switch` switches what is in force.
    fn is_same(&self, switch: &Switch) -> bool {
        let Switch { side, radius, offset, .. } = *switch;
        side == self.switch.side
            && radius == self.switch.radius
            && (offset.is_none() || self.pieces.is_empty() || offset == self.offset)
    }
}

/// Where a written line leads: its end, and the signed angle of an arc, rad.
#[derive(Clone, Copy)]
struct Way {
    to: Point,
    sweep_rad: Option<f64>,
}

/// Where a word must not stand.
#[derive(Clone, Copy, PartialEq)]
enum Barred {
    /// Behind the line that switches on.
    BehindFirst,
    /// In compensation.
    Inside,
    /// Nor before the move away from the contour.
    BeforeLeaving,
}

/// What matters of the words of a line.
struct Seen {
    line: usize,
    offset: Option<u32>,
    modes: [Option<Distance>; 2],
    barred: Option<(Word, Barred)>,
}

/// A program in which the contours with compensation are found and written as the path of the centre.
struct CentrePath<'p> {
    program: &'p GcodeProgram,
    switches: &'p Switches,
    section: Option<Section>,
    /// New lines in place of those with these indices.
    lines: BTreeMap<usize, Vec<(Vec<u8>, Way)>>,
    radii: RadiiInUse,
    /// Number of the last D word.
    offset: Option<u32>,
    /// Distance modes in force before the line.
    modes: [Distance; 2],
}

impl GcodeProgram {
    /// Returns the program, which is the contour without compensation, with the path of the tool centre where `switches` switch it on, and the
    /// index of the line that each of its lines comes from. `Err` for what is not followed.
    pub(crate) fn with_centre_path(
        &self,
        switches: &Switches,
    ) -> Result<(Vec<u8>, Vec<usize>, RadiiInUse), GcodeError> {
        let centres = if self.dialect.is_iso() { self.options.arc_centres.into() } else { Distance::Incremental };
        let mut path = CentrePath {
            program: self,
            switches,
            section: None,
            lines: BTreeMap::new(),
            radii: RadiiInUse::new(),
            offset: None,
            modes: [Distance::Absolute, centres],
        };
        self.walk_words(
            |line, words| self.look(line, words),
            |block, seen| path.follow(block, seen).map_err(|(line, refusal)| self.located(line, refusal)),
        )?;
        path.close().map_err(|(line, refusal)| self.located(line, refusal))?;
        let (mut bytes, mut origins) = (Vec::with_capacity(self.source.len()), Vec::new());
        let mut ways = BTreeMap::new();
        for line in 0..self.lines.len() {
            let ending = self.lines.ending_or_newline(&self.source, line);
            let Some(written) = path.lines.get(&line) else {
                bytes.extend_from_slice(self.content(line));
                bytes.extend_from_slice(ending);
                origins.push(line);
                continue;
            };
            for (text, way) in written {
                ways.insert(origins.len(), *way);
                bytes.extend_from_slice(text);
                bytes.extend_from_slice(ending);
                origins.push(line);
            }
        }
        self.check_written(&bytes, &origins, ways)?;
        Ok((bytes, origins, path.radii))
    }

    /// Reads the written program again; `Err` if a line with one of these `ways` leads elsewhere.
    fn check_written(&self, bytes: &[u8], origins: &[usize], mut ways: BTreeMap<usize, Way>) -> Result<(), GcodeError> {
        let misread = |line: usize| {
            let origin = origins.get(line).copied().unwrap_or_default();
            self.located(origin, Refusal::new(0..self.content(origin).len(), Fault::Radius(RadiusFault::Misread)))
        };
        let written = GcodeProgram::parse(bytes.to_vec(), &self.name, &self.options).map_err(|error| GcodeError {
            line: origins.get(error.line.saturating_sub(1)).map_or(error.line, |line| line + 1),
            ..error
        })?;
        written.walk(|block| {
            let Some(way) = ways.remove(&block.line) else { return Ok(()) };
            let is_right = block.motions.iter().all(|motion| {
                let is_there =
                    (0..2).all(|axis| motion.end[axis].is_some_and(|at| (at - way.to[axis]).abs() < READ_MM));
                let sweep = match &motion.geometry {
                    MotionGeometry::Arc(arc) => Some(arc.sweep_rad()),
                    _ => None,
                };
                let is_same = match (sweep, way.sweep_rad) {
                    (Some(a), Some(b)) => (a - b).abs() < std::f64::consts::PI,
                    (a, b) => a.is_some() == b.is_some(),
                };
                is_there && is_same
            });
            if is_right { Ok(()) } else { Err(misread(block.line)) }
        })?;
        ways.keys().next().map_or(Ok(()), |line| Err(misread(*line)))
    }

    fn located(&self, line: usize, refusal: Refusal) -> GcodeError {
        refusal.locate(&self.name, line + 1, self.content(line)).with_dialect(self.dialect)
    }

    /// Returns what matters of the `words` of line `line`.
    fn look(&self, line: usize, words: &[Word]) -> Seen {
        let d = words.iter().find(|word| word.letter == 'D' && self.dialect.is_iso());
        let meaning = |word: &Word| match word.meaning {
            Some(vocable) => Some(vocable.meaning),
            None if word.letter == 'G' => self.dialect.g_word(word).ok(),
            None => None,
        };
        let mut seen =
            Seen { line, offset: d.and_then(|word| word.whole_number().ok()), modes: [None; 2], barred: None };
        for word in words {
            match meaning(word) {
                Some(GWord::Distance(distance)) => seen.modes[0] = Some(distance),
                Some(GWord::Centres(distance)) => seen.modes[1] = Some(distance),
                _ => {}
            }
            let barred = match meaning(word) {
                None if word.letter == 'M' && word.value == 6.0 => Barred::BehindFirst,
                None if word.mode_save_code(self.dialect).is_some() => Barred::Inside,
                Some(GWord::Setting(Setting::Pole) | GWord::Plane(Plane::Xy)) | None => continue,
                Some(
                    GWord::Setting(_)
                    | GWord::Align(_)
                    | GWord::FindAngles(_)
                    | GWord::TipControl
                    | GWord::TipControlEnds,
                ) => Barred::BeforeLeaving,
                Some(GWord::Unit(_) | GWord::UnitOfCoordinates(_) | GWord::WorkOffset(_) | GWord::Preset) => {
                    Barred::BehindFirst
                }
                Some(
                    GWord::Plane(_)
                    | GWord::Home
                    | GWord::Machine
                    | GWord::Retract
                    | GWord::Motion(MotionCode::Cycle(_))
                    | GWord::Feed(FeedMode::InverseTime),
                ) => Barred::Inside,
                Some(_) => continue,
            };
            if seen.barred.as_ref().is_none_or(|(_, other)| *other == Barred::BehindFirst) {
                seen.barred = Some((word.clone(), barred));
            }
        }
        seen
    }
}

/// A refusal with the index of its line.
type Located = (usize, Refusal);

impl CentrePath<'_> {
    /// Follows a line, of which this was `seen`, with its block, if it is one.
    fn follow(&mut self, block: Option<&Block>, seen: Seen) -> Result<(), Located> {
        let (line, modes) = (seen.line, self.modes);
        for (mode, own) in self.modes.iter_mut().zip(seen.modes) {
            *mode = own.unwrap_or(*mode);
        }
        let refuse = |line: usize, fault: RadiusFault| {
            let content = self.program.content(line);
            let begin = lines::prefix_len(content);
            (line, Refusal::new(begin..content.len().max(begin), Fault::Radius(fault)))
        };
        let switch = self.switches.get(&line);
        let is_linuxcnc = self.program.dialect == Dialect::LinuxCnc;
        // LinuxCNC looks at the D beside G41 alone.
        let named = switch.and_then(|switch| switch.offset).or(seen.offset.filter(|_| !is_linuxcnc));
        let mut is_first_line = false;
        if let Some(switch) = switch {
            match &mut self.section {
                Some(section) if switch.side == 0.0 => section.ends = true,
                Some(section) if !section.ends && section.is_same(switch) => {}
                Some(_) => return Err(refuse(line, RadiusFault::Changed)),
                None if switch.side == 0.0 => {}
                None => {
                    is_first_line = true;
                    self.offset = if is_linuxcnc { None } else { self.offset };
                    self.section = Some(Section {
                        switch: *switch,
                        offset: None,
                        distance: 0.0,
                        pieces: Vec::new(),
                        ends: false,
                        is_left: false,
                    });
                }
            }
        }
        self.offset = named.or(self.offset);
        let Some(section) = &self.section else { return Ok(()) };
        if !section.ends && !section.pieces.is_empty() && self.offset != section.offset {
            return Err(refuse(line, RadiusFault::Changed));
        }
        let is_barred = |barred: Barred| match barred {
            Barred::BehindFirst => !section.ends && !is_first_line,
            Barred::Inside => !section.ends,
            Barred::BeforeLeaving => true,
        };
        if let Some((word, _)) = seen.barred.filter(|(_, barred)| is_barred(*barred)) {
            return Err((line, word.refuse(Fault::Radius(RadiusFault::Inside))));
        }
        let Some(block) = block else { return Ok(()) };
        for motion in &block.motions {
            self.add_piece(block, motion, line, modes)?;
        }
        Ok(())
    }

    /// Adds `motion` of the block on line `line`, before which these `modes` were in force, to the section; closes the section where it leads away.
    fn add_piece(&mut self, block: &Block, motion: &Motion, line: usize, modes: [Distance; 2]) -> Result<(), Located> {
        let has_plane_words = motion.words.iter().any(|word| matches!(word.letter, 'X' | 'Y' | 'I' | 'J'));
        let Some(section) = &self.section else { return Ok(()) };
        if !has_plane_words {
            return Ok(());
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
        let offset = self.offset;
        let Some(section) = &mut self.section else { return Ok(()) };
        section.distance = distance;
        if is_first {
            section.offset = offset;
        }
        if motion.modal.plane != Plane::Xy {
            return Err(at_motion(RadiusFault::Inside));
        }
        let is_arc = matches!(motion.code, MotionCode::Arc(_));
        if motion.turning.turns() {
            return Err(at_motion(RadiusFault::Turns));
        }
        if is_arc && (is_first || section.ends) {
            return Err(at_motion(RadiusFault::Arc));
        }
        let ends = in_plane(motion.end);
        let element = match motion.geometry {
            MotionGeometry::Line(from, to) => element([from.x, from.y], [to.x, to.y], None),
            MotionGeometry::Arc(arc) => {
                let MotionCode::Arc(turn) = motion.code else { return Err(at_motion(RadiusFault::Inside)) };
                let (from, to) = (motion.start, motion.end);
                let (Some(from), Some(to)) = (located(from), located(to)) else {
                    return Err(at_motion(RadiusFault::Unknown));
                };
                if arc.sweep_rad().abs() > std::f64::consts::TAU + 1e-9 {
                    return Err(at_motion(RadiusFault::Inside));
                }
                Some(Element { from: [from.x, from.y], to: [to.x, to.y], arc: Some((arc.centre(), turn)) })
            }
            // Its height may not be known yet.
            _ => in_plane(motion.start).zip(ends).and_then(|(from, to)| element(from, to, None)),
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
            modes,
            element,
        };
        section.pieces.push(piece);
        if section.ends {
            section.is_left = true;
            return self.close();
        }
        Ok(())
    }

    /// Returns the radius, mm, for `switch` where `motion` leads to the contour, and keeps what it is of.
    fn radius(&mut self, switch: &Switch, motion: &Motion) -> Result<f64, RadiusFault> {
        if let Some(radius) = switch.radius {
            return Ok(radius * motion.modal.unit.mm());
        }
        let tool = motion.modal.tool.filter(|_| !switch.is_named).map(CutterOf::Tool);
        let offset = self.offset.filter(|_| self.program.dialect.is_iso()).map(CutterOf::Offset);
        let radii = self.program.options.cutter_radii_mm.as_ref();
        let given = |name: CutterOf| radii.and_then(|radii| radii.get(&name)).copied();
        let (name, radius) = match offset.or(tool) {
            None => return Err(RadiusFault::NotGiven { of: None }),
            Some(name @ CutterOf::Offset(0)) if self.program.dialect != Dialect::LinuxCnc => {
                (name, given(name).unwrap_or(0.0))
            }
            Some(name) => (name, given(name).ok_or(RadiusFault::NotGiven { of: Some(name) })?),
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
        let refuse = |index: usize, fault: RadiusFault| {
            let Piece { line, motion, .. } = &section.pieces[index];
            (*line, Refusal::new(motion.span.clone(), Fault::Radius(fault)))
        };
        let Some(first) = contour.first() else {
            let is_alone = section.distance != 0.0 && !section.pieces.is_empty();
            return if is_alone { Err(refuse(0, RadiusFault::Alone)) } else { Ok(()) };
        };
        let elements: Vec<&Element> =
            contour.iter().filter_map(|index| section.pieces[*index].element.as_ref()).collect();
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
            if !offset_keeps_direction(element, ways[at], distance) {
                return Err(refuse(contour[at], RadiusFault::Narrow));
            }
        }
        let path = Path { section: &section, contour: &contour, elements: &elements, ways: &ways, turns: &turns };
        if let Some((index, line)) = path.cut_into() {
            return Err(refuse(index, RadiusFault::CutsInto { line: line + 1 }));
        }
        // The move to the contour ends, and that away from it starts, beside it.
        let mut at = in_plane(section.pieces[0].motion.start);
        for (index, piece) in section.pieces.iter().enumerate() {
            let number = contour.partition_point(|other| *other < index);
            let (to, corner) = match () {
                () if index < *first => (ways[0][0], None),
                () if contour.get(number) == Some(&index) => (ways[number][1], turns[number]),
                () if section.is_left && index + 1 == section.pieces.len() => {
                    (in_plane(piece.motion.end).unwrap_or_default(), None)
                }
                () => (at.unwrap_or_default(), None),
            };
            let around = corner.map(|turn| (ways[number][0], elements[number].from, turn));
            self.write(piece, at, to, around).map_err(|fault| refuse(index, fault))?;
            at = Some(to);
        }
        Ok(())
    }

    /// Formats a coordinate in the unit of the program.
    fn number(&self, value: f64) -> String {
        if self.program.dialect.is_iso() { word_number(b'X', value) } else { long_number(b'X', value) }
    }

    /// Returns the words of an arc from `start` to `end`, about the corner before `piece`.
    fn arc_text(&self, piece: &Piece, style: Style, start: Point, end: Point, (centre, turn): About) -> String {
        let mm = piece.motion.modal.unit.mm();
        if self.program.dialect == Dialect::Heidenhain {
            let radius = libm::hypot(end[0] - centre[0], end[1] - centre[1]);
            let [x, y] = [0, 1].map(|axis| signed((end[axis] - piece.motion.origin[axis]) / mm));
            let sense = if turn == TurnDirection::CounterClockwise { "+" } else { "-" };
            return format!("CR X{x} Y{y} R{} DR{sense}", signed(radius / mm));
        }
        let [ends, centres] = [(end, piece.modes[0]), (centre, piece.modes[1])]
            .map(|(at, mode)| [0, 1].map(|axis| self.number((at[axis] - piece.base(mode, start, axis)) / mm)));
        let mut words = vec![style.motion(MotionCode::Arc(turn))];
        words.extend([0, 1].map(|axis| style.axis(axis, &ends[axis])));
        words.extend([0, 1].map(|axis| style.word(['I', 'J'][axis], &centres[axis])));
        words.join(style.separator())
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
        let mm = motion.modal.unit.mm();
        let dialect = self.program.dialect;
        let mut written = Vec::new();
        let mut begin = from;
        if let Some((end, centre, turn)) = around {
            let start = from.unwrap_or_default();
            begin = Some(end);
            let text = self.arc_text(piece, edit.style(), start, end, (centre, turn));
            let sweep_rad = Some(sweep(start, end, centre, turn));
            written.push(([&content[..piece.prefix], text.as_bytes()].concat(), Way { to: end, sweep_rad }));
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
            let mode = own.unwrap_or(motion.modal.distance);
            if mode == Distance::Incremental && begin.is_none() {
                return Err(RadiusFault::Unknown);
            }
            let text = self.number((to[axis] - piece.base(mode, begin.unwrap_or_default(), axis)) / mm);
            match index {
                Some(index) => edit.set_number(index, &text),
                None => edit.add_axis(axis, &text),
            }
        }
        let mut sweep_rad = None;
        if let (MotionCode::Arc(_), Some(Element { arc: Some((centre, turn)), .. }), Some(begin)) =
            (motion.code, &piece.element, begin)
        {
            let turned = sweep(begin, to, *centre, *turn);
            sweep_rad = Some(turned);
            let find = |letter: char| motion.words.iter().position(|word| word.letter == letter);
            let radius = find('R');
            match radius {
                Some(index) if dialect == Dialect::Heidenhain => {
                    let size = libm::hypot(to[0] - centre[0], to[1] - centre[1]) / mm;
                    let is_long = turned.abs() > std::f64::consts::PI;
                    edit.set_number(index, &signed(if is_long { -size } else { size }));
                }
                None if find('I').or(find('J')).is_none() => {}
                _ => {
                    if let Some(index) = radius {
                        edit.remove(index);
                    }
                    for (axis, letter) in [(0, 'I'), (1, 'J')] {
                        let own = find(letter).and_then(|index| motion.words[index].distance);
                        let from = piece.base(own.unwrap_or(motion.modal.centres), begin, axis);
                        edit.set_arc_word(letter, &self.number((centre[axis] - from) / mm));
                    }
                }
            }
        }
        if around.is_some() && !piece.has_motion_word && dialect != Dialect::Heidenhain {
            edit.set_motion(motion.code);
        }
        written.push((edit.render(), Way { to, sweep_rad }));
        self.lines.insert(piece.line, written);
        Ok(())
    }
}

/// Returns the coordinates X and Y of a position; `None` if one is unknown.
fn in_plane([x, y, _]: PartialPosition) -> Option<Point> {
    Some([x?, y?])
}

/// Returns the element between two points; `None` if they are the same.
fn element(from: Point, to: Point, arc: Option<(Point, TurnDirection)>) -> Option<Element> {
    (libm::hypot(to[0] - from[0], to[1] - from[1]) > 1e-9).then_some(Element { from, to, arc })
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
        let cuts = |index: usize, way: &Element, but: Option<usize>, own_mm: f64| {
            let [low, high] = way.bounds();
            contour.iter().find_map(|(other, element, bounds)| {
                let is_apart = (0..2).any(|i| bounds[0][i] > high[i] + radius || bounds[1][i] < low[i] - radius);
                // Beside its own block, the way to the contour and from it is only to stay on its side.
                let rounding = ROUNDING_MM + own_mm + way.radius_mismatch() + element.radius_mismatch();
                let least = if but == Some(*other) { 0.0 } else { radius - rounding };
                let is_near = !is_apart && way.distance(element) <= least;
                is_near.then_some((index, pieces[*other].line))
            })
        };
        let first = self.contour.first().copied();
        let begin = in_plane(pieces[0].motion.start);
        let to_it = begin.and_then(|begin| element(begin, self.ways[0][0], None)).filter(|_| is_fed(0));
        if let Some(found) = to_it.and_then(|way| cuts(0, &way, first, 0.0)) {
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
            let found = arc.and_then(|arc| cuts(index, &arc, None, own.radius_mismatch()));
            if let Some(found) =
                found.or_else(|| cuts(index, &Element { from, to, arc: own.arc }, None, own.radius_mismatch()))
            {
                return Some(found);
            }
        }
        let last = pieces.len() - 1;
        let end = in_plane(pieces[last].motion.end).filter(|_| *is_left && is_fed(last));
        let way = end.and_then(|end| element(self.ways.last()?[1], end, None));
        way.and_then(|way| cuts(last, &way, self.contour.last().copied(), 0.0))
    }
}
