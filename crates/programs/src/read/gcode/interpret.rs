//! Interprets the words of each line in the state that the lines before it left.

use nalgebra::Vector3;

use crate::{
    model::gcode::{
        Dialect, Distance, Fault, FeedMode, GWord, GcodeOptions, InclinedFault, ModalState, Motion, MotionCode, Notes,
        PartialPosition, Refusal, Rotary, Setting, Unsupported, Word, WorkOffset,
    },
    read::gcode::{Cycle, Offsets, Pole, Request, effective_words},
};
use kinetostat_spatial::Pose;

/// State of the control after the lines so far.
pub(crate) struct Interpreter {
    pub(crate) modal: ModalState,
    pub(crate) offsets: Offsets,
    pub(crate) position: PartialPosition,
    /// Zero in force when the axis was named last, mm in W.
    pub(crate) zero_named: [Option<f64>; 3],
    pub(crate) dialect: Dialect,
    /// Centre of arcs that give none (Heidenhain's CC), mm, in the axes of the plane.
    pub(crate) pole: Option<[f64; 2]>,
    /// Parameters of the cycle in force.
    pub(crate) cycle: Option<Cycle>,
    /// The motion in force before the cycles, which G80 gives back on most controls.
    pub(super) motion_before_cycle: Option<MotionCode>,
    /// Axes along which the position has been known.
    pub(crate) ever_known: [bool; 3],
    /// Line that last made the position unknown.
    position_lost_in: Option<usize>,
    /// Line of M2, M30 or the second %.
    ended_in: Option<usize>,
    /// Number of the last T word.
    selected: Option<u32>,
    tool_changed: bool,
    /// Index of the feature that the next line begins.
    next_feature: Option<u16>,
    /// Angles of A, B and C, degrees.
    pub(crate) rotary: [Option<f64>; 3],
    /// Angles before the line, degrees.
    pub(crate) rotary_before: [Option<f64>; 3],
    /// Whether a line such as G28 has made the angle unknown; the same before the line.
    pub(crate) rotary_lost: [bool; 3],
    pub(crate) rotary_lost_before: [bool; 3],
    /// Rotary axes that are followed.
    pub(crate) rotary_axes: Rotary,
    /// Pose in W, mm, of the inclined plane in force.
    pub(crate) inclined: Option<Pose>,
    /// Angles of A, B and C, degrees, that PLANE with STAY has found for it.
    pub(crate) found_angles: Option<[f64; 3]>,
    /// Modes and work offset that M70 has saved.
    saved_modes: Option<(ModalState, WorkOffset)>,
    /// Numbers of programs whose calls move nothing.
    calls_kept: Vec<u32>,
    /// Whether it is known where the tool is before the program, so that M99 may end it.
    has_start: bool,
    has_program_number: bool,
    is_unit_given: bool,
    pub notes: Notes,
}

/// Effect of a line on the tool.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Effect {
    /// Motion word on the line.
    pub motion_word: Option<MotionCode>,
    /// Motions it makes: one, or the holes of a cycle.
    pub motions: Vec<Motion>,
    /// Zero that it sets by the tool position (G92, G10 L20).
    pub zero_setting: Option<ZeroSetting>,
    /// Centre of arcs that it sets.
    pub pole: Option<Pole>,
    /// Motion in force and words of a line whose move is not followed: to coordinates of the machine (G53, SUPA), or of a rotary axis alone.
    pub kept_move: Option<(MotionCode, Vec<Word>)>,
}

/// A line that sets the zero by the tool position.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ZeroSetting {
    /// Tool position along the axes that the line has a coordinate for, mm.
    pub position: PartialPosition,
    /// Unit of the line, mm.
    pub unit_mm: f64,
    /// Words of the line.
    pub words: Vec<Word>,
}

impl Interpreter {
    /// Starts in the state that `options` and `dialect` give, before the first line.
    pub fn new(options: &GcodeOptions, dialect: Dialect) -> Interpreter {
        let unit = options.unit.unwrap_or_default();
        let centres = if dialect.is_iso() { options.arc_centres.into() } else { Distance::Incremental };
        let start = options.start_mm.map_or([None; 3], |p| [Some(p.x), Some(p.y), Some(p.z)]);
        Interpreter {
            modal: ModalState { has_degrees: dialect != Dialect::Haas, ..ModalState::at_start(unit, centres) },
            offsets: Offsets::new(options),
            position: start,
            zero_named: [None; 3],
            dialect,
            pole: None,
            cycle: None,
            motion_before_cycle: None,
            ever_known: start.map(|p| p.is_some()),
            position_lost_in: None,
            ended_in: None,
            selected: None,
            tool_changed: false,
            next_feature: None,
            rotary: [None; 3],
            rotary_before: [None; 3],
            rotary_lost: [false; 3],
            rotary_lost_before: [false; 3],
            rotary_axes: options.rotary.clone(),
            inclined: None,
            found_angles: None,
            saved_modes: None,
            calls_kept: options.calls_kept.clone(),
            has_start: options.start_mm.is_some(),
            has_program_number: false,
            is_unit_given: options.unit.is_some(),
            notes: Notes { dialect, ..Notes::default() },
        }
    }

    /// Marks line `number` (from 1) as the end of the program, unless it has ended.
    pub fn set_end(&mut self, number: usize) {
        self.ended_in.get_or_insert(number);
    }

    /// Whether the program has ended.
    pub fn has_ended(&self) -> bool {
        self.ended_in.is_some()
    }

    /// Follows the words of line `number` (from 1) and returns their effect.
    pub fn follow_line(&mut self, number: usize, words: Vec<Word>) -> Result<Effect, Refusal> {
        if let Some(end) = self.ended_in {
            let moving = words.iter().find(|word| may_move(word));
            return moving.map_or(Ok(Effect::default()), |word| Err(word.refuse(Fault::AfterEnd { end })));
        }
        if !self.calls_kept.is_empty() && self.is_kept_call(&words) {
            return Ok(Effect::default());
        }
        let returns = self.has_start && self.dialect.is_iso() && words.iter().any(is_return);
        let without_return: Vec<Word>;
        let followed = match returns {
            true => {
                without_return = words.iter().filter(|word| !is_return(word)).cloned().collect();
                &without_return
            }
            false => &words,
        };
        let mut request = Request::from_words(effective_words(followed), self.dialect)?;
        request.ends_program |= returns;
        self.check_program_number(&request)?;
        self.save_or_restore_modes(&request)?;
        self.apply_modal(number, &request)?;
        self.update_tool(&request)?;
        request.check_parameters(matches!(self.modal.motion, Some(MotionCode::Cycle(_))))?;
        self.check_alignment(&request)?;
        self.update_rotary(number, &request)?;
        let mut effect = Effect { motion_word: request.motion_word(), ..Effect::default() };
        if request.leaves_frame() {
            self.leave_frame(number, &request)?;
            let goes = request.find_g(GWord::Machine).is_some() && request.axis_words().iter().any(Option::is_some);
            effect.kept_move = self.modal.motion.filter(|_| goes).map(|code| (code, words.clone()));
        } else if let Some((word, Setting::Incline(inclination))) = request.setting() {
            self.incline(number, &request, word, inclination)?;
        } else if let Some((word, Setting::Pole)) = request.setting() {
            effect.pole = Some(self.set_pole(&request, word)?);
        } else if let Some((word, setting)) = request.setting() {
            // Zeros are lengths, too.
            if request.axis_words().iter().any(|word| word.is_some_and(|word| word.value != 0.0)) {
                self.note_unit(number);
            }
            effect.zero_setting = self.apply_setting(&request, word, setting)?;
        } else if matches!(self.modal.motion, Some(MotionCode::Cycle(_))) && request.find_g(GWord::Dwell).is_none() {
            effect.motions = self.drill(number, &request)?;
        } else {
            effect.motions = self.motion(number, &request)?.into_iter().collect();
            let turns = effect.motions.is_empty() && words.iter().any(|word| matches!(word.letter, 'A' | 'B' | 'C'));
            effect.kept_move = self.modal.motion.filter(|_| turns).map(|code| (code, words.clone()));
        }
        if let Some((word, choice)) = request.alignment() {
            self.align_tool(number, word, choice)?;
        }
        if let Some((_, choice)) = request.angle_search() {
            self.found_angles = self.angles_along_plane(choice).ok();
        }
        if request.find_g(GWord::TipControlEnds).is_some() {
            self.set_tip_control(false);
        }
        if request.ends_program {
            self.ended_in = Some(number);
        }
        for motion in &mut effect.motions {
            motion.words.clone_from(&words);
        }
        let turns_alone = |motion: &Motion| {
            motion.code != MotionCode::Rapid
                && motion.modal.feed_mode != FeedMode::InverseTime
                && motion.turned_alone_deg().is_some()
        };
        if effect.motions.iter().any(turns_alone) {
            self.notes.turned_alone_lines.push(number);
        }
        if effect.motions.iter().any(Motion::is_unlocated) {
            self.notes.unlocated_lines.push(number);
        }
        if let Some(zero_setting) = &mut effect.zero_setting {
            zero_setting.words = words;
        } else if let Some(pole) = &mut effect.pole {
            pole.words = words;
        }
        Ok(effect)
    }

    /// Whether a line of these `words` calls a program that the options say moves nothing, and does nothing else.
    fn is_kept_call(&self, words: &[Word]) -> bool {
        let has = |letter: char, numbers: &[f64]| {
            words.iter().any(|word| word.letter == letter && numbers.contains(&word.value))
        };
        let number = words.iter().find(|word| word.letter == 'P').and_then(|word| word.whole_number().ok());
        let is_alone = || words.iter().all(|word| matches!(word.letter, 'N' | 'M' | 'P' | 'L'));
        number.is_some_and(|number| self.calls_kept.contains(&number))
            && (has('G', &[65.0]) || has('M', &[98.0, 198.0]) && is_alone())
    }

    /// Saves or restores modes by M70 to M73 in a main program, where M73 acts as M70.
    fn save_or_restore_modes(&mut self, request: &Request) -> Result<(), Refusal> {
        let Some((word, code)) = request.mode_word else { return Ok(()) };
        match code {
            71 => self.saved_modes = None,
            72 if self.inclined.is_some() => return Err(word.refuse(Fault::Inclined(InclinedFault::Inside))),
            72 => {
                let (saved, offset) = self.saved_modes.ok_or_else(|| word.refuse(Fault::NothingKept))?;
                self.set_tip_control(saved.tip_control);
                let ModalState { motion, tool, feature, .. } = self.modal;
                self.modal = ModalState { motion, tool, feature, ..saved };
                self.offsets.activate(offset);
            }
            _ => self.saved_modes = Some((self.modal, self.offsets.active_offset())),
        }
        Ok(())
    }

    /// Refuses a second program number, which begins a subprogram.
    fn check_program_number(&mut self, request: &Request) -> Result<(), Refusal> {
        if let Some(word) = request.find_word('O') {
            word.whole_number()?;
            if std::mem::replace(&mut self.has_program_number, true) {
                return Err(word.refuse(Fault::Unsupported(Unsupported::Subprogram)));
            }
        }
        Ok(())
    }

    /// Sets the modes of the line in the order of RS-274 controllers: units before feed.
    fn apply_modal(&mut self, number: usize, request: &Request) -> Result<(), Refusal> {
        if request.find_g(GWord::CancelMotion).is_some() {
            // To LinuxCNC and Grbl no motion is in force then; to others the one before the cycles.
            self.modal.motion = match self.modal.motion {
                _ if self.dialect == Dialect::LinuxCnc => None,
                Some(MotionCode::Cycle(_)) => self.motion_before_cycle,
                motion => motion,
            };
            self.cycle = None;
        }
        for &(word, g) in &request.g_words {
            self.check_inside_plane(word, g)?;
            match g {
                GWord::Motion(code) => {
                    if !matches!(self.modal.motion, Some(MotionCode::Cycle(_))) {
                        self.motion_before_cycle = self.modal.motion;
                    }
                    self.modal.motion = Some(code);
                    self.cycle = self.cycle.filter(|_| matches!(code, MotionCode::Cycle(_)));
                }
                GWord::ReturnsToClear(clear) => self.modal.returns_to_r_plane = clear,
                GWord::Plane(plane) => self.modal.plane = plane,
                GWord::Unit(unit) | GWord::UnitOfCoordinates(unit) => {
                    self.modal.unit = unit;
                    self.is_unit_given = true;
                    if g == GWord::Unit(unit) {
                        self.modal.feed_unit_mm = self.dialect.feed_unit_mm(unit);
                    }
                }
                GWord::Distance(distance) => self.modal.distance = distance,
                GWord::Centres(distance) => self.modal.centres = distance,
                GWord::PolarOff => {
                    if let Some(word) = request.find_word('H') {
                        let offset = WorkOffset::okuma(word.whole_number()?);
                        self.offsets.activate(offset.ok_or_else(|| word.refuse(Fault::NoExtended))?);
                    }
                }
                GWord::WorkOffset(offset) => self.offsets.activate(work_offset(word, offset, request)?),
                GWord::Preset => {
                    self.offsets.activate(WorkOffset::preset(word.whole_number()?));
                    (0..3).for_each(|axis| self.offsets.set_local(axis, 0.0));
                }
                GWord::FeedOfTool => self.modal.feed = None,
                GWord::Feed(mode) if mode != self.modal.feed_mode => {
                    self.modal.feed_mode = mode;
                    self.modal.feed = None;
                }
                GWord::CountsTurns(counts) if counts != self.modal.is_rev_per_min => {
                    self.modal.is_rev_per_min = counts;
                    self.modal.spindle = None;
                }
                GWord::TipControl => self.set_tip_control(true),
                GWord::Passive("tool length") => self.set_tip_control(false),
                GWord::Passive("rotation") => self.end_plane(number),
                _ => {}
            }
        }
        if let Some(word) = request.find_word('F') {
            let mm = if self.modal.feed_mode == FeedMode::InverseTime { 1.0 } else { self.modal.feed_unit_mm };
            self.modal.feed = Some(checked_speed(word, "a feed of 0 to 1e9")? * mm);
        }
        if let Some(word) = request.find_word('S') {
            self.modal.spindle = Some(checked_speed(word, "a spindle speed of 0 to 1e9")?);
        }
        Ok(())
    }

    /// Makes the next line the first one of `feature` (an index).
    pub fn begin_feature(&mut self, feature: u16) {
        self.next_feature = Some(feature);
    }

    /// Updates the tool in the spindle by T and M6, and the feature of the line.
    fn update_tool(&mut self, request: &Request) -> Result<(), Refusal> {
        if let Some(word) = request.find_word('T') {
            self.selected = Some(word.whole_number()?);
        }
        if request.changes_tool {
            self.tool_changed = true;
            self.modal.feature = None;
        }
        if request.changes_tool || !self.tool_changed {
            self.modal.tool = self.selected;
        }
        self.modal.feature = self.next_feature.take().or(self.modal.feature);
        Ok(())
    }

    /// Returns the zero of the coordinates in force, mm in W or in the inclined plane; if it is unknown, the error points to `word`.
    pub(crate) fn origin(&mut self, word: &Word) -> Result<Vector3<f64>, Refusal> {
        if self.inclined.is_some() {
            return Ok(Vector3::zeros());
        }
        self.offsets.origin().map_err(|fault| word.refuse(fault))
    }

    /// Makes the position unknown after a move outside the workpiece frame (G28, G30, G53) in line `number`, which stays as written.
    fn leave_frame(&mut self, number: usize, request: &Request) -> Result<(), Refusal> {
        let axes = request.axis_words();
        request.refuse_arc_words()?;
        let home = request.find_g(GWord::Home).is_some();
        let along_tool = request.find_g(GWord::Retract).map(|_| self.modal.plane.axes()[2]);
        if let (false, Some(MotionCode::Arc(_)), Some(word)) = (home, self.modal.motion, request.find_g(GWord::Machine))
        {
            return Err(word.refuse(Fault::Unsupported(Unsupported::MachineArc)));
        }
        // Axes of the machine are inclined to those of the plane.
        let all = (home && axes.iter().all(Option::is_none)) || (self.inclined.is_some() && along_tool.is_none());
        let lost = [0, 1, 2].map(|axis| all || axes[axis].is_some() || along_tool == Some(axis));
        self.forget_position(number, lost);
        Ok(())
    }

    /// Makes the position unknown along the axes for which `axes` is true, after line `number`.
    pub fn forget_position(&mut self, number: usize, axes: [bool; 3]) {
        for (axis, _) in axes.into_iter().enumerate().filter(|(_, lost)| *lost) {
            self.position[axis] = None;
            self.position_lost_in = Some(number);
        }
    }

    /// Returns " after line 12" if a line made the position unknown, else nothing.
    pub(crate) fn lost_since(&self) -> String {
        self.position_lost_in.map_or_else(String::new, |line| format!(" after line {line}"))
    }

    /// Notes the unit that is assumed for the first length, unless the program or the options gave one.
    pub(crate) fn note_unit(&mut self, line: usize) {
        if !std::mem::replace(&mut self.is_unit_given, true) {
            self.notes.assumed_unit = Some((self.modal.unit, line));
        }
    }

    /// Sets the tool position, mm in W, `None` where unknown.
    pub(crate) fn set_position(&mut self, end: PartialPosition) {
        self.position = end;
        for (known, at) in self.ever_known.iter_mut().zip(end) {
            *known |= at.is_some();
        }
    }
}

/// Returns the work offset that a G word selects: `offset`, or for G54.1 that of its P.
fn work_offset(word: &Word, offset: Option<WorkOffset>, request: &Request) -> Result<WorkOffset, Refusal> {
    if let Some(offset) = offset {
        return Ok(offset);
    }
    let number = request.find_word('P').map(Word::whole_number).transpose()?;
    number.and_then(WorkOffset::extended).ok_or_else(|| word.refuse(Fault::NoExtended))
}

/// Whether `word` is M99, the return from a subprogram.
fn is_return(word: &Word) -> bool {
    word.letter == 'M' && word.value == 99.0
}

/// Whether a line with this word would move the tool, which is refused behind the end.
fn may_move(word: &Word) -> bool {
    matches!(word.letter, 'X' | 'Y' | 'Z' | 'I' | 'J' | 'K') || (word.letter == 'M' && word.value == 98.0)
}

/// Returns the value of an F or S word; `Err` if it is below 0 or above 1e9.
fn checked_speed(word: &Word, expected: &'static str) -> Result<f64, Refusal> {
    if (0.0..=1e9).contains(&word.value) { Ok(word.value) } else { Err(word.refuse(Fault::Speed { expected })) }
}
