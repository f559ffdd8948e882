//! Words into motions: what each line does, given the lines before it.

use nalgebra::Vector3;

use crate::toolpath::{
    model::gcode::{
        Dialect, Distance, Fault, FeedMode, GWord, GcodeOptions, Known, Modal, Motion, MotionCode, Notes, Refusal,
        Rotary, Setting, Unsupported, Word, WorkOffset,
    },
    read::gcode::{Cycle, Offsets, Pole, Request, that_count},
};

/// Follows a program line by line.
pub(crate) struct Interpreter {
    pub(crate) modal: Modal,
    pub(crate) offsets: Offsets,
    pub(crate) position: Known,
    pub(crate) dialect: Dialect,
    /// The centre of arcs that give none (Heidenhain's CC).
    pub(crate) pole: Option<[f64; 2]>,
    /// The cycle in force.
    pub(crate) cycle: Option<Cycle>,
    /// Axes of which a position was known at some time.
    pub(crate) ever_known: [bool; 3],
    /// The line that made the position unknown again, if one did.
    lost_in: Option<usize>,
    /// The line with M2, M30 or the second %.
    ended_in: Option<usize>,
    /// The number after T, and whether an M6 has been.
    selected: Option<u32>,
    tool_changed: bool,
    /// The feature that the next line begins.
    begun: Option<u16>,
    /// Where A, B and C stand.
    pub(crate) rotary: [Option<f64>; 3],
    /// Where they stood before the line.
    pub(crate) rotary_before: [Option<f64>; 3],
    /// Of which of them a line, as G28, has made it unknown where they stand, and that before the line.
    pub(crate) rotary_lost: [bool; 3],
    pub(crate) rotary_lost_before: [bool; 3],
    /// What they turn.
    pub(crate) rotary_axes: Rotary,
    /// What M70 has kept.
    kept: Option<(Modal, WorkOffset)>,
    named: bool,
    unit_said: bool,
    pub notes: Notes,
}

/// What a line does to the tool.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Effect {
    /// The motion word on the line.
    pub motion_word: Option<MotionCode>,
    /// The motions it makes: one, or the holes of a cycle.
    pub motions: Vec<Motion>,
    /// Where the tool is that the coordinates of the line are said of (G92, G10 L20).
    pub origin_at: Option<OriginAt>,
    /// The centre that it sets.
    pub pole: Option<Pole>,
}

/// A line that sets a zero by where the tool is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OriginAt {
    /// The place, by axis that the line has a coordinate for.
    pub place: Known,
    /// mm in a unit of the line.
    pub unit_mm: f64,
    /// The words of the line.
    pub words: Vec<Word>,
}

impl Interpreter {
    pub fn new(options: &GcodeOptions, dialect: Dialect) -> Interpreter {
        let unit = options.unit.unwrap_or_default();
        let centres = if dialect.is_iso() { options.arc_centres.into() } else { Distance::Incremental };
        let start = options.start_mm.map_or([None; 3], |p| [Some(p.x), Some(p.y), Some(p.z)]);
        Interpreter {
            modal: Modal::at_start(unit, centres),
            offsets: Offsets::new(options),
            position: start,
            dialect,
            pole: None,
            cycle: None,
            ever_known: start.map(|p| p.is_some()),
            lost_in: None,
            ended_in: None,
            selected: None,
            tool_changed: false,
            begun: None,
            rotary: [None; 3],
            rotary_before: [None; 3],
            rotary_lost: [false; 3],
            rotary_lost_before: [false; 3],
            rotary_axes: options.rotary.clone(),
            kept: None,
            named: false,
            unit_said: options.unit.is_some(),
            notes: Notes { dialect, ..Notes::default() },
        }
    }

    /// The program ends in line `number`.
    pub fn end_in(&mut self, number: usize) {
        self.ended_in.get_or_insert(number);
    }

    /// Whether the program has ended.
    pub fn has_ended(&self) -> bool {
        self.ended_in.is_some()
    }

    /// Follows the words of line `number` (from 1).
    pub fn line(&mut self, number: usize, words: Vec<Word>) -> Result<Effect, Refusal> {
        if let Some(end) = self.ended_in {
            let moving = words.iter().find(|word| moves(word));
            return moving.map_or(Ok(Effect::default()), |word| Err(word.refuse(Fault::AfterEnd { end })));
        }
        let request = Request::of(that_count(&words), self.dialect)?;
        self.program_number(&request)?;
        self.keep_modes(&request)?;
        self.apply_modal(&request)?;
        self.take_tool(&request)?;
        request.check_parameters(matches!(self.modal.motion, Some(MotionCode::Cycle(_))))?;
        self.turn(&request)?;
        let mut effect = Effect { motion_word: request.motion_word(), ..Effect::default() };
        if request.leaves() {
            self.leave(number, &request)?;
        } else if let Some((word, Setting::Pole)) = request.setting() {
            effect.pole = Some(self.set_pole(&request, word)?);
        } else if let Some((word, setting)) = request.setting() {
            effect.origin_at = self.set(&request, word, setting)?;
        } else if matches!(self.modal.motion, Some(MotionCode::Cycle(_))) && request.g(GWord::Dwell).is_none() {
            effect.motions = self.drill(number, &request)?;
        } else {
            effect.motions = self.motion(number, &request)?.into_iter().collect();
        }
        if request.g(GWord::TipControlEnds).is_some() {
            self.control_tip(false);
        }
        if request.ends_program {
            self.ended_in = Some(number);
        }
        for motion in &mut effect.motions {
            motion.words.clone_from(&words);
        }
        if effect.motions.iter().any(Motion::is_lost) {
            self.notes.not_located.push(number);
        }
        if let Some(origin_at) = &mut effect.origin_at {
            origin_at.words = words;
        } else if let Some(pole) = &mut effect.pole {
            pole.words = words;
        }
        Ok(effect)
    }

    /// M70 to M73 of a main program, which M73 has no end of a subprogram to restore at.
    fn keep_modes(&mut self, request: &Request) -> Result<(), Refusal> {
        let Some((word, code)) = request.keeps else { return Ok(()) };
        match code {
            71 => self.kept = None,
            72 => {
                let (kept, offset) = self.kept.ok_or_else(|| word.refuse(Fault::NothingKept))?;
                self.control_tip(kept.tip_control);
                let Modal { motion, tool, feature, .. } = self.modal;
                self.modal = Modal { motion, tool, feature, ..kept };
                self.offsets.activate(offset);
            }
            _ => self.kept = Some((self.modal, self.offsets.active())),
        }
        Ok(())
    }

    /// A program has one number; a second one begins a subprogram.
    fn program_number(&mut self, request: &Request) -> Result<(), Refusal> {
        if let Some(word) = request.letter('O') {
            word.whole()?;
            if std::mem::replace(&mut self.named, true) {
                return Err(word.refuse(Fault::Unsupported(Unsupported::Subprogram)));
            }
        }
        Ok(())
    }

    /// Everything that stays in force, in the order RS-274 controllers take it: units before feed.
    fn apply_modal(&mut self, request: &Request) -> Result<(), Refusal> {
        if request.g(GWord::CancelMotion).is_some() {
            self.modal.motion = None;
            self.cycle = None;
        }
        for &(word, g) in &request.g_words {
            match g {
                GWord::Motion(code) => {
                    self.modal.motion = Some(code);
                    self.cycle = self.cycle.filter(|_| matches!(code, MotionCode::Cycle(_)));
                }
                GWord::ReturnsToClear(clear) => self.modal.returns_to_clear = clear,
                GWord::Plane(plane) => self.modal.plane = plane,
                GWord::Unit(unit) | GWord::UnitOfCoordinates(unit) => {
                    self.modal.unit = unit;
                    self.unit_said = true;
                    if g == GWord::Unit(unit) {
                        self.modal.feed_unit_mm = self.dialect.feed_unit_mm(unit);
                    }
                }
                GWord::Distance(distance) => self.modal.distance = distance,
                GWord::Centres(distance) => self.modal.centres = distance,
                GWord::PolarOff => {
                    if let Some(word) = request.letter('H') {
                        let offset = WorkOffset::of_okuma(word.whole()?);
                        self.offsets.activate(offset.ok_or_else(|| word.refuse(Fault::NoExtended))?);
                    }
                }
                GWord::WorkOffset(offset) => self.offsets.activate(work_offset(word, offset, request)?),
                GWord::Preset => {
                    self.offsets.activate(WorkOffset::preset(word.whole()?));
                    (0..3).for_each(|axis| self.offsets.set_local(axis, 0.0));
                }
                GWord::FeedOfTool => self.modal.feed = None,
                GWord::Feed(mode) if mode != self.modal.feed_mode => {
                    self.modal.feed_mode = mode;
                    self.modal.feed = None;
                }
                GWord::CountsTurns(counts) if counts != self.modal.counts_turns => {
                    self.modal.counts_turns = counts;
                    self.modal.spindle = None;
                }
                GWord::TipControl => self.control_tip(true),
                GWord::Passive("tool length") => self.control_tip(false),
                _ => {}
            }
        }
        if let Some(word) = request.letter('F') {
            let mm = if self.modal.feed_mode == FeedMode::InverseTime { 1.0 } else { self.modal.feed_unit_mm };
            self.modal.feed = Some(speed(word, "a feed of 0 to 1e9")? * mm);
        }
        if let Some(word) = request.letter('S') {
            self.modal.spindle = Some(speed(word, "a spindle speed of 0 to 1e9")?);
        }
        Ok(())
    }

    /// The next line begins this feature.
    pub fn begin_feature(&mut self, feature: u16) {
        self.begun = Some(feature);
    }

    /// Which tool is in the spindle, and which feature of the program the line is in.
    fn take_tool(&mut self, request: &Request) -> Result<(), Refusal> {
        if let Some(word) = request.letter('T') {
            self.selected = Some(word.whole()?);
        }
        if request.changes_tool {
            self.tool_changed = true;
            self.modal.feature = None;
        }
        if request.changes_tool || !self.tool_changed {
            self.modal.tool = self.selected;
        }
        self.modal.feature = self.begun.take().or(self.modal.feature);
        Ok(())
    }

    /// Zero of the coordinates in force; `word` is blamed if it was not given.
    pub(crate) fn origin(&mut self, word: &Word) -> Result<Vector3<f64>, Refusal> {
        self.offsets.origin().map_err(|fault| word.refuse(fault))
    }

    /// A move to a place outside the workpiece frame (G28, G30, G53): it is copied as it is, and where it ends is
    /// not known.
    fn leave(&mut self, number: usize, request: &Request) -> Result<(), Refusal> {
        let axes = request.axes();
        request.refuse_arc_words()?;
        let home = request.g(GWord::Home).is_some();
        let along_tool = request.g(GWord::Retract).map(|_| self.modal.plane.axes()[2]);
        if let (false, Some(MotionCode::Arc(_)), Some(word)) = (home, self.modal.motion, request.g(GWord::Machine)) {
            return Err(word.refuse(Fault::Unsupported(Unsupported::MachineArc)));
        }
        let all = home && axes.iter().all(Option::is_none);
        let lost = [0, 1, 2].map(|axis| all || axes[axis].is_some() || along_tool == Some(axis));
        self.lose(number, lost);
        Ok(())
    }

    /// Where the tool is along `axes` is not known after line `number`.
    pub fn lose(&mut self, number: usize, axes: [bool; 3]) {
        for (axis, _) in axes.into_iter().enumerate().filter(|(_, lost)| *lost) {
            self.position[axis] = None;
            self.lost_in = Some(number);
        }
    }

    /// " after line 12", if a line made the position unknown.
    pub(crate) fn since(&self) -> String {
        self.lost_in.map_or_else(String::new, |line| format!(" after line {line}"))
    }

    /// A length is read with the unit in force.
    pub(crate) fn take_unit(&mut self, line: usize) {
        if !std::mem::replace(&mut self.unit_said, true) {
            self.notes.unit_taken = Some((self.modal.unit, line));
        }
    }

    /// The tool is at `end`.
    pub(crate) fn arrive(&mut self, end: Known) {
        self.position = end;
        for (known, at) in self.ever_known.iter_mut().zip(end) {
            *known |= at.is_some();
        }
    }
}

/// Which work offset a word with its P selects.
fn work_offset(word: &Word, offset: Option<WorkOffset>, request: &Request) -> Result<WorkOffset, Refusal> {
    if let Some(offset) = offset {
        return Ok(offset);
    }
    let number = request.letter('P').map(Word::whole).transpose()?;
    number.and_then(WorkOffset::extended).ok_or_else(|| word.refuse(Fault::NoExtended))
}

/// Whether a line after the end with this word would move the tool.
fn moves(word: &Word) -> bool {
    matches!(word.letter, 'X' | 'Y' | 'Z' | 'I' | 'J' | 'K') || (word.letter == 'M' && word.value == 98.0)
}

fn speed(word: &Word, expected: &'static str) -> Result<f64, Refusal> {
    if (0.0..=1e9).contains(&word.value) { Ok(word.value) } else { Err(word.refuse(Fault::Speed { expected })) }
}
