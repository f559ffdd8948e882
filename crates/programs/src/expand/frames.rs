//! Rotated coordinates (G68, G69), polar ones (G16, G15) and corners that the control rounds or bevels (`,R` `,C`), in plain coordinates.
//!
//! Followed in G17. G68 X Y R turns what follows by R, counter-clockwise, about X, Y; the first position behind G68 and G69 must be given by X and Y
//! in G90 (Fanuc, *Series 16/18-C Operator's Manual for Machining Center* B-62764EN, 15.10; Haas, *Mill Operator's Manual*, G68). Under G16, X is the radius about
//! the zero of the work offset and Y the angle (same manual of Fanuc, Polar Coordinate Command). `,R` and `,C` stand behind a line and before
//! another; the length of `,C` counts from the corner (Optional Chamfering and Corner R).

use nalgebra::{Rotation2, Vector2};

use crate::{
    expand::{
        edit::{LineEdit, LineShare, share_of},
        geometry::Element,
        line::{SourceLine, word_number},
    },
    model::gcode::{
        ArcCentres, BlockDelete, Dialect, Fault, GcodeError, GcodeOptions, LengthUnit, MotionCode, Refusal,
        Unsupported, Word,
    },
    read::gcode::{
        Style, effective_words, lex,
        lines::{self, Code, Lines},
    },
};

/// Bytes of a program in plain coordinates, and the line, from 0, that each of its lines comes from.
pub(crate) type PlainLines = (Vec<u8>, Vec<usize>);

/// Whether a corner is round, and its size.
type CornerWord = (bool, f64);

/// Lines that meet at less than this angle have no corner, rad.
const LEAST_TURN_RAD: f64 = 0.017_453_292_519_943_295;

/// A corner that waits for the line behind it.
struct Corner {
    /// The line with the corner, from 0, and its bytes without `,R` or `,C`.
    line: usize,
    content: Vec<u8>,
    from: Vector2<f64>,
    at: Vector2<f64>,
    is_round: bool,
    size: f64,
}

/// State of the control, lengths in the unit of the program.
struct Frames {
    dialect: Dialect,
    block_delete: BlockDelete,
    /// Whether I and J are from the zero.
    has_absolute_centres: bool,
    is_xy: bool,
    is_incremental: bool,
    unit: Option<LengthUnit>,
    motion: u32,
    /// Centre and angle of G68.
    rotation: Option<(Vector2<f64>, Rotation2<f64>)>,
    is_polar: bool,
    /// Radius and angle, degrees, under G16.
    polar: [Option<f64>; 2],
    /// The programmed position, before it is rotated.
    programmed: [Option<f64>; 2],
    /// Whether the next position must be given in full.
    needs_both: bool,
    corner: Option<Corner>,
    is_changed: bool,
    bytes: Vec<u8>,
    origins: Vec<usize>,
}

/// Returns `source`, a program without macros called `name`, with plain coordinates in place of rotated and polar ones, and with its corners
/// written; `None` if it has none of them. `Err` for what is not followed.
pub(crate) fn plain_coordinates(
    source: &[u8],
    name: &str,
    options: &GcodeOptions,
) -> Result<Option<PlainLines>, GcodeError> {
    let all = Lines::split(source);
    let dialect = options.dialect.unwrap_or_default();
    let mut frames = Frames {
        dialect,
        block_delete: options.block_delete,
        has_absolute_centres: options.arc_centres == ArcCentres::Absolute,
        is_xy: true,
        is_incremental: false,
        unit: None,
        motion: 0,
        rotation: None,
        is_polar: false,
        polar: [None; 2],
        programmed: [None; 2],
        needs_both: false,
        corner: None,
        is_changed: false,
        bytes: Vec::with_capacity(source.len()),
        origins: Vec::new(),
    };
    for line in 0..all.len() {
        let content = &source[all.content(line)];
        let followed = frames.follow_line(content, line, all.ending_or_newline(source, line));
        followed.map_err(|refusal| refusal.locate(name, line + 1, content).with_dialect(dialect))?;
    }
    if let Some(Corner { line, content, .. }) = &frames.corner {
        let refusal = Refusal::new(0..content.len(), Fault::Unsupported(Unsupported::CornerPlace));
        return Err(refusal.locate(name, line + 1, content).with_dialect(dialect));
    }
    Ok(frames.is_changed.then_some((frames.bytes, frames.origins)))
}

impl Frames {
    /// Writes `content` as what comes from line `line`.
    fn write(&mut self, content: &[u8], ending: &[u8], line: usize) {
        self.bytes.extend_from_slice(content);
        self.bytes.extend_from_slice(ending);
        self.origins.push(line);
    }

    /// Follows line `line` and writes what stands for it.
    fn follow_line(&mut self, content: &[u8], line: usize, ending: &[u8]) -> Result<(), Refusal> {
        if self.block_delete == BlockDelete::Skip && lines::is_deletable(content) {
            self.write(content, ending, line);
            return Ok(());
        }
        let (content, corner) = without_corner(content)?;
        let (text, is_words) = match lines::parse_code(&content) {
            Ok(Code::Words { text, .. }) => (text, true),
            // What cannot be read is refused once all is written out.
            _ => (String::new(), false),
        };
        let is_code = |words: &Vec<Word>| is_words && words.iter().any(|word| word.letter != 'N');
        let words = lex::words(&text).ok().filter(|words| self.corner.is_some() || is_code(words));
        let Some(words) = words else {
            self.write(&content, ending, line);
            return Ok(());
        };
        let mut edit = LineEdit::new(&content, &words, Style::plain(self.dialect));
        let is_kept = self.apply_modes(&words, &mut edit)?;
        let axes = ['X', 'Y'].map(|letter| effective_words(&words).iter().position(|word| word.letter == letter));
        let is_dwell = has_g(&words, 40);
        let before = self.actual();
        if !is_kept || is_dwell || axes == [None, None] {
            if let Some(waiting) = &self.corner {
                return Err(Refusal::new(0..waiting.content.len().min(content.len()), CORNER));
            }
            if corner.is_some() {
                return Err(Refusal::new(0..content.len(), CORNER));
            }
            self.write(&edit.render(), ending, line);
            return Ok(());
        }
        // What moves along, or acts at the end, would do so on one of the lines alone.
        let is_whole = |word: &Word| {
            matches!(share_of(word, &words), LineShare::Last | LineShare::Axis)
                || matches!(word.letter, 'A' | 'B' | 'C')
        };
        let is_at_corner = corner.is_some() || self.corner.is_some();
        if let Some(word) = words.iter().find(|word| is_at_corner && is_whole(word)) {
            return Err(word.refuse(CORNER));
        }
        self.move_to(&words, axes)?;
        let after = self.actual();
        let mut has_both = self.rotation.is_some() || self.is_polar;
        // The line behind a corner starts elsewhere than its words say.
        if let Some(waiting) = self.corner.take() {
            has_both = true;
            if self.motion != 1 || self.is_incremental || words.iter().any(|word| word.letter == 'Z') {
                return Err(Refusal::new(0..content.len(), CORNER));
            }
            let to = after.ok_or(Refusal::new(0..content.len(), CORNER))?;
            let is_arc = self.write_corner(&waiting, to, ending)?;
            if is_arc {
                edit.set_motion(MotionCode::Line);
            }
        }
        if has_both {
            self.is_changed = true;
            let steps = if self.is_incremental { before } else { Some(Vector2::zeros()) };
            let (Some(after), Some(from)) = (after, steps) else {
                return Err(refuse(&words, axes, Unsupported::FrameStart));
            };
            self.put_position(&mut edit, axes, after - from);
            if let Some((_, rotation)) = self.rotation {
                let centre = words.iter().find(|word| matches!(word.letter, 'I' | 'J'));
                if let Some(word) = centre.filter(|_| self.has_absolute_centres) {
                    return Err(word.refuse(Fault::Unsupported(Unsupported::InFrame)));
                }
                put_centre(&mut edit, &words, rotation);
            }
        }
        match corner {
            None => self.write(&edit.render(), ending, line),
            Some((is_round, size)) => {
                let is_line = self.motion == 1 && !self.is_incremental && self.is_xy;
                let is_flat = words.iter().all(|word| word.letter != 'Z');
                let (true, Some(from), Some(at)) = (is_line && is_flat && size > 0.0, before, after) else {
                    return Err(Refusal::new(0..content.len(), CORNER));
                };
                self.corner = Some(Corner { line, content: edit.render(), from, at, is_round, size });
            }
        }
        Ok(())
    }

    /// Puts the G words of a line in force and takes those of rotated and polar coordinates out of it; returns whether X and Y are a position.
    fn apply_modes(&mut self, words: &[Word], edit: &mut LineEdit<'_>) -> Result<bool, Refusal> {
        let mut is_position = true;
        let is_framed = |frames: &Frames| frames.rotation.is_some() || frames.is_polar;
        for (index, word) in words.iter().enumerate().filter(|(_, word)| word.letter == 'G') {
            match word.tenths() {
                Some(tenths @ (0 | 10 | 20 | 30)) => self.motion = tenths / 10,
                Some(730..=890) => self.motion = 81,
                Some(900) => self.is_incremental = false,
                Some(910) => self.is_incremental = true,
                Some(170) => self.is_xy = true,
                Some(690) if self.rotation.is_some() => {
                    let actual = self.actual();
                    self.programmed = [0, 1].map(|axis| actual.map(|actual| actual[axis]));
                    (self.rotation, self.needs_both) = (None, true);
                    self.remove(edit, index);
                }
                Some(150) if self.is_polar => {
                    self.is_polar = false;
                    self.remove(edit, index);
                }
                Some(160 | 680) => {}
                Some(40 | 50 | 51 | 80 | 90 | 400 | 430 | 440 | 490 | 610 | 611 | 640 | 930..=950 | 970..=990) => {}
                Some(691 | 150) => {}
                Some(690) if is_framed(self) => {}
                Some(tenths @ (901 | 911)) => self.has_absolute_centres = tenths == 901,
                _ if is_framed(self) => return Err(word.refuse(Fault::Unsupported(Unsupported::InFrame))),
                Some(180 | 190) => self.is_xy = false,
                Some(200) => self.set_unit(LengthUnit::Inch),
                Some(210) => self.set_unit(LengthUnit::Millimetre),
                // Its words are arguments.
                Some(650..=669) => is_position = false,
                // X and Y are in other coordinates from here on, or no position.
                Some(540..=593 | 1100..=1299 | 1540) => self.programmed = [None; 2],
                Some(690) => self.programmed = [None; 2],
                Some(100 | 280..=309 | 520 | 530 | 531 | 682 | 920..=929) => {
                    self.programmed = [None; 2];
                    is_position = false;
                }
                _ => {}
            }
        }
        for (index, word) in words.iter().enumerate().filter(|(_, word)| word.letter == 'G') {
            match word.tenths() {
                Some(680) => {
                    self.begin_rotation(words, word, edit)?;
                    self.remove(edit, index);
                    is_position = false;
                }
                Some(160) if words.iter().all(|word| word.letter != 'H') => {
                    if matches!(self.dialect, Dialect::Haas | Dialect::LinuxCnc) || !self.is_xy {
                        return Err(word.refuse(Fault::Unsupported(Unsupported::Transform)));
                    }
                    (self.is_polar, self.polar) = (true, [None; 2]);
                    self.remove(edit, index);
                }
                _ => {}
            }
        }
        Ok(is_position)
    }

    /// Takes the word with index `index` out of the line.
    fn remove(&mut self, edit: &mut LineEdit<'_>, index: usize) {
        edit.remove(index);
        self.is_changed = true;
    }

    /// Puts a unit in force; the position in another one is not converted.
    fn set_unit(&mut self, unit: LengthUnit) {
        if self.unit.replace(unit) != Some(unit) {
            self.programmed = [None; 2];
        }
    }

    /// Begins the rotation of the word G68, whose words leave the line.
    fn begin_rotation(&mut self, words: &[Word], word: &Word, edit: &mut LineEdit<'_>) -> Result<(), Refusal> {
        let value = |letter: char| words.iter().find(|word| word.letter == letter).map(|word| word.value);
        let fault = |unsupported| Err(word.refuse(Fault::Unsupported(unsupported)));
        let is_alone = words.iter().all(|word| match word.letter {
            'G' => matches!(word.tenths(), Some(170 | 680 | 900)),
            letter => matches!(letter, 'N' | 'X' | 'Y' | 'R'),
        });
        match (value('X'), value('Y'), value('R')) {
            _ if self.dialect == Dialect::LinuxCnc => fault(Unsupported::Transform),
            _ if self.rotation.is_some() => fault(Unsupported::InFrame),
            (Some(x), Some(y), Some(degrees)) if is_alone && self.is_xy && !self.is_incremental => {
                self.rotation = Some((Vector2::new(x, y), Rotation2::new(degrees.to_radians())));
                (self.programmed, self.needs_both) = ([None; 2], true);
                for (index, _) in words.iter().enumerate().filter(|(_, word)| matches!(word.letter, 'X' | 'Y' | 'R')) {
                    edit.remove(index);
                }
                Ok(())
            }
            _ => fault(Unsupported::FrameCentre),
        }
    }

    /// Moves the programmed position as the words at `axes` (X and Y) say.
    fn move_to(&mut self, words: &[Word], axes: [Option<usize>; 2]) -> Result<(), Refusal> {
        let value = |axis: usize| axes[axis].map(|index| words[index].value);
        let has = |letters: &[char]| words.iter().any(|word| letters.contains(&word.letter));
        if !self.is_xy {
            // In other planes nothing is rotated, polar or a corner.
            self.programmed = [None; 2];
            return Ok(());
        }
        if self.needs_both && (self.is_incremental || !self.is_polar && axes.contains(&None)) {
            return Err(refuse(words, axes, Unsupported::FrameStart));
        }
        self.needs_both = false;
        if self.is_polar {
            let is_step = self.is_incremental && (value(0).is_some() || has(&['K', 'L']));
            if is_step || has(&['I', 'J']) {
                return Err(refuse(words, axes, Unsupported::InFrame));
            }
            let angle =
                value(1).map(|angle| angle + if self.is_incremental { self.polar[1].unwrap_or(f64::NAN) } else { 0.0 });
            self.polar = [value(0).or(self.polar[0]), angle.or(self.polar[1])];
            let [Some(radius), Some(degrees)] = self.polar else {
                return Err(refuse(words, axes, Unsupported::FrameStart));
            };
            if !degrees.is_finite() {
                return Err(refuse(words, axes, Unsupported::FrameStart));
            }
            let (sin, cos) = libm::sincos(degrees.to_radians());
            self.programmed = [Some(radius * cos), Some(radius * sin)];
            return Ok(());
        }
        for axis in 0..2 {
            if let Some(value) = value(axis) {
                self.programmed[axis] =
                    if self.is_incremental { self.programmed[axis].map(|at| at + value) } else { Some(value) };
            }
        }
        Ok(())
    }

    /// Returns the position in plain coordinates; `None` if it is unknown.
    fn actual(&self) -> Option<Vector2<f64>> {
        let [Some(x), Some(y)] = self.programmed else { return None };
        let programmed = Vector2::new(x, y);
        Some(self.rotation.map_or(programmed, |(centre, rotation)| centre + rotation * (programmed - centre)))
    }

    /// Writes X and Y of `position` into a line whose words of them are at `axes`.
    fn put_position(&self, edit: &mut LineEdit<'_>, axes: [Option<usize>; 2], position: Vector2<f64>) {
        for (axis, index) in axes.into_iter().enumerate() {
            let number = word_number(b'X', position[axis]);
            match index {
                Some(index) => edit.set_number(index, &number),
                None => edit.add_axis(axis, &number),
            }
        }
    }

    /// Writes the line of `corner`, shortened, and the arc or line across it towards `to`; returns whether it is an arc.
    fn write_corner(&mut self, corner: &Corner, to: Vector2<f64>, ending: &[u8]) -> Result<bool, Refusal> {
        self.is_changed = true;
        let refused = || Refusal::new(0..corner.content.len(), CORNER);
        let line = |from: Vector2<f64>, to: Vector2<f64>| Element { from: from.into(), to: to.into(), arc: None };
        let (arriving, leaving) = (line(corner.from, corner.at), line(corner.at, to));
        let turn = arriving.turn_to(&leaving);
        let leg = if corner.is_round { corner.size * libm::tan(turn.abs() / 2.0) } else { corner.size };
        let cut = arriving.chamfer(&leaving, leg, true).ok().flatten();
        let Some((begin, _, [x, y])) = cut.filter(|_| turn.abs() >= LEAST_TURN_RAD) else { return Err(refused()) };
        let Ok(Code::Words { text, .. }) = lines::parse_code(&corner.content) else { return Err(refused()) };
        let words = lex::words(&text).map_err(|_| refused())?;
        let mut edit = LineEdit::new(&corner.content, &words, Style::plain(self.dialect));
        let axes = ['X', 'Y'].map(|letter| words.iter().position(|word| word.letter == letter));
        self.put_position(&mut edit, axes, begin.into());
        let shortened = edit.render();
        self.write(&shortened, ending, corner.line);
        let [x, y] = [x, y].map(|number| word_number(b'X', number));
        let across = match corner.is_round {
            true => format!("G{} X{x} Y{y} R{}", if turn > 0.0 { 3 } else { 2 }, word_number(b'R', corner.size)),
            false => format!("G1 X{x} Y{y}"),
        };
        self.write(across.as_bytes(), ending, corner.line);
        Ok(corner.is_round)
    }
}

const CORNER: Fault = Fault::Unsupported(Unsupported::CornerPlace);

/// Returns `content` without `,R` or `,C` and its number, which are round and size of a corner.
fn without_corner(content: &[u8]) -> Result<(Vec<u8>, Option<CornerWord>), Refusal> {
    let code = SourceLine::new(content).code;
    let Some(at) = code.find(',').filter(|at| matches!(code.as_bytes().get(at + 1), Some(b'R' | b'C'))) else {
        return Ok((content.to_vec(), None));
    };
    let digits = &code[at + 2..];
    let length = digits.bytes().take_while(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b' ')).count();
    let size = digits[..length].replace(' ', "").parse::<f64>().map_err(|_| Refusal::new(at..at + 2, CORNER))?;
    let rest = [content[..at].trim_ascii_end(), &content[at + 2 + digits[..length].trim_end().len()..]].concat();
    Ok((rest, Some((code.as_bytes()[at + 1] == b'R', size))))
}

/// Turns the centre I, J of an arc from its start by `rotation`.
fn put_centre(edit: &mut LineEdit<'_>, words: &[Word], rotation: Rotation2<f64>) {
    let value = |letter: char| words.iter().find(|word| word.letter == letter).map(|word| word.value);
    if value('I').is_some() || value('J').is_some() {
        let turned = rotation * Vector2::new(value('I').unwrap_or(0.0), value('J').unwrap_or(0.0));
        for (letter, number) in [('I', turned.x), ('J', turned.y)] {
            edit.set_arc_word(letter, &word_number(b'I', number));
        }
    }
}

/// Whether one of `words` is the G word of these tenths.
fn has_g(words: &[Word], tenths: u32) -> bool {
    words.iter().any(|word| word.letter == 'G' && word.tenths() == Some(tenths))
}

/// Returns the refusal of the word of X or Y in `words`.
fn refuse(words: &[Word], axes: [Option<usize>; 2], unsupported: Unsupported) -> Refusal {
    let at = axes[0].or(axes[1]).unwrap_or_default();
    words[at].refuse(Fault::Unsupported(unsupported))
}
