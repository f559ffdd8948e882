//! The writer of a corrected G-code program, block by block.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::{
    expand::edit::LineEdit,
    model::{
        NumberFormat, PathPoint, format_shortest,
        gcode::{
            Angles, Centre, Coordinates, LengthUnit, Motion, MotionCode, PartialPosition, Refusal, WriteOptions,
            located,
        },
    },
    read::gcode::{Block, GcodeProgram, Pole, Style, ZeroSetting, motion_geometry},
    write::gcode::{
        AxisWord, CoordinateFormat, CycleState, RotaryWords, Stretch, WriteTolerance, angle_tolerance_deg,
        inverse_time_feed, set_feed,
    },
};

/// The points of one motion and their corrected positions and angles.
#[derive(Clone, Copy)]
pub(crate) struct Targets<'a> {
    pub points: &'a [PathPoint],
    pub corrected: &'a [Vector3<f64>],
    /// Corrected angles of the rotary axes at the points, degrees, if they turn or are corrected.
    pub angles: Option<&'a [Angles]>,
}

impl Targets<'_> {
    /// Returns the corrected angles of the rotary axes at the end of `motion`, degrees; those programmed if they are not corrected.
    fn end_angles(&self, motion: &Motion) -> Angles {
        self.angles.and_then(|angles| angles.last()).copied().unwrap_or(motion.turning.to)
    }
}

/// A single block that passes all targets of a motion: what to write, and where it leads.
struct OneBlock {
    axes: [AxisWord; 3],
    centre: [Option<String>; 2],
    turned: RotaryWords,
    /// Where on the block each target lies, from 0 to 1.
    parameters: Vec<f64>,
}

/// The writer of a corrected program: the text written so far, and where it has led the tool.
pub(crate) struct Writer<'p> {
    pub(crate) program: &'p GcodeProgram,
    pub(crate) writing: WriteOptions,
    pub(crate) style: Style,
    newline: &'p [u8],
    pub out: Vec<u8>,
    /// Line, from 1, and refusal of the first word that could not be shared out.
    pub refused: Option<(usize, Refusal)>,
    /// How many path points lie on each written motion.
    pub pieces: Vec<usize>,
    /// Where on its motion each path point lies, from 0 to 1.
    pub parameters: Vec<f64>,
    /// Where the bytes of each line of an expanded program end.
    pub line_ends: Vec<usize>,
    /// Lines, from 1, whose moves get a word for every axis.
    full_lines: &'p BTreeSet<usize>,
    /// The position, mm, that a controller reaches by the words written so far.
    pub(crate) tracked: PartialPosition,
    /// Angles of the rotary axes in the program, and those reached by the words written so far, degrees.
    pub(crate) rotary_angles: [Angles; 2],
    /// What the last written coordinates were those of.
    coordinates: Coordinates,
    /// The written centre for arcs that give none (Heidenhain's CC), mm.
    pub(crate) pole: Option<[f64; 2]>,
    /// The state of the drilling cycle in force, as written.
    pub(crate) cycle: CycleState,
    /// One unit of the last decimal of the previous written block, mm: the next block starts from its rounding.
    pub(crate) unit_before_mm: f64,
    /// The motion mode in force at the end of the written text.
    pub motion_word: Option<MotionCode>,
    /// The one in force before the drilling cycles, as written.
    motion_before_cycle: Option<MotionCode>,
}

impl<'p> Writer<'p> {
    /// Creates a writer with nothing written; moves on the lines `full_lines` (from 1) get a word for every axis.
    pub fn new(program: &'p GcodeProgram, writing: WriteOptions, full_lines: &'p BTreeSet<usize>) -> Writer<'p> {
        let mut endings = (0..program.lines.len()).map(|line| &program.source[program.lines.ending(line)]);
        Writer {
            program,
            writing,
            style: program.style,
            newline: endings.find(|ending| !ending.is_empty()).unwrap_or(b"\n"),
            out: Vec::with_capacity(program.source.len()),
            pieces: Vec::with_capacity(program.motions.len()),
            parameters: Vec::new(),
            line_ends: Vec::new(),
            full_lines,
            tracked: [None; 3],
            rotary_angles: [[0.0; 3]; 2],
            coordinates: program.options.rotary.coordinates(false),
            pole: None,
            cycle: CycleState::default(),
            unit_before_mm: 0.0,
            refused: None,
            motion_word: None,
            motion_before_cycle: None,
        }
    }

    /// Records that the written text has the motion word of `code`.
    pub fn set_motion(&mut self, code: MotionCode) {
        if !matches!(self.motion_word, Some(MotionCode::Cycle(_))) {
            self.motion_before_cycle = self.motion_word;
        }
        self.motion_word = Some(code);
    }

    /// Copies line `index` (from 0) unchanged.
    pub fn copy_text(&mut self, index: usize) {
        let lines = &self.program.lines;
        self.out.extend_from_slice(&self.program.source[lines.content(index).start..lines.ending(index).end]);
    }

    /// Notes that `code` is in force: behind a cycle, G80 on the line or before it has given back the motion before the cycles.
    fn end_cycle(&mut self, code: MotionCode) {
        if !matches!(code, MotionCode::Cycle(_)) && matches!(self.motion_word, Some(MotionCode::Cycle(_))) {
            self.motion_word = self.motion_before_cycle;
        }
    }

    /// Copies a block without motions, with the motion of its kept move if another one is in force.
    pub fn copy_block(&mut self, block: &Block) {
        let kept_move = block.kept_move.as_ref().filter(|_| block.motion_word.is_none());
        let Some((code, _)) = kept_move else { return self.copy_text(block.line) };
        self.end_cycle(*code);
        if self.motion_word.is_none_or(|own| own == *code) {
            return self.copy_text(block.line);
        }
        self.out.extend(self.program.line_with_motion(block));
        self.end_line(block, true);
        self.motion_word = Some(*code);
    }

    /// Copies line `index` (from 0), which is no block, and records its end.
    pub fn copy_line(&mut self, index: usize) {
        self.copy_text(index);
        self.record_line_end();
    }

    /// Records the end of all that a line has become, if the program was expanded.
    pub fn record_line_end(&mut self) {
        if self.program.expansion.is_some() {
            self.line_ends.push(self.out.len());
        }
    }

    /// Writes a motion block: as a single block if one passes all targets, otherwise split.
    pub fn write_motion(&mut self, block: &Block, motion: &Motion, targets: Targets) {
        self.begin_motion(motion);
        let format = self.coordinate_format(motion);
        let turned =
            self.rotary_words_to(motion, self.program.content(block.line), &targets.end_angles(motion), [true, true]);
        match (targets.corrected.last(), self.whole_stretch(motion, targets)) {
            (None, _) => {
                let axes = format.unchanged_words(motion, self.tracked);
                self.write_line(block, motion, OneBlock { axes, centre: [None, None], turned, parameters: Vec::new() });
            }
            (Some(goal), None) => {
                // Coming from nowhere known, only the end matters.
                let axes = format.axis_words(&motion.words, self.tracked, goal);
                self.write_line(block, motion, OneBlock { axes, centre: [None, None], turned, parameters: vec![1.0] });
            }
            (Some(goal), Some(stretch)) => match self.fit_one_block(motion, format, stretch, goal, turned) {
                Some(kept) => self.write_line(block, motion, kept),
                None => self.write_split(block, motion, format, stretch),
            },
        }
        self.unit_before_mm = format.unit_mm();
    }

    /// Writes a line that sets a zero from the tool's position (such as G92), so that the zero stays where the program has it.
    pub fn write_origin(&mut self, block: &Block, origin: &ZeroSetting) {
        let content = self.program.content(block.line);
        let mut edit = LineEdit::new(content, &origin.words, self.style);
        for axis in 0..3 {
            let (Some(position), Some(here)) = (origin.position[axis], self.tracked[axis]) else { continue };
            let index = edit.find(|word| word.letter == ['X', 'Y', 'Z'][axis]);
            // Nothing that could add up is left of the difference.
            if let Some(index) = index.filter(|_| (here - position).abs() > NumberFormat::FINEST) {
                let value = origin.words[index].value + (here - position) / origin.unit_mm;
                edit.set_number(index, &format_shortest(value, self.decimals(origin.unit_mm)));
            }
        }
        self.out.extend(edit.render());
        self.end_line(block, true);
    }

    /// Writes a line that sets the centre of arcs, moved by `shift` (mm).
    pub fn write_pole(&mut self, block: &Block, pole: &Pole, shift: Vector3<f64>) {
        let format = CoordinateFormat::new(&pole.modal, &pole.words, pole.origin, self.decimals(pole.modal.unit.mm()));
        let tracked = [0, 1, 2].map(|axis| pole.start[axis].and(self.tracked[axis].or(pole.start[axis])));
        let content = self.program.content(block.line);
        let mut edit = LineEdit::new(content, &pole.words, self.style);
        let [first, second, _] = pole.modal.plane.axes();
        let mut written = [tracked[first], tracked[second]];
        let has_words = edit.find(|word| word.letter == ['X', 'Y', 'Z'][first]).is_some();
        if let Some(at) = pole.centre.filter(|_| has_words) {
            for (k, axis) in [first, second].into_iter().enumerate() {
                let reached = format.axis_word(&pole.words, tracked, axis, at[k] + shift[axis]);
                if let Some(number) = &reached.number {
                    put_axis(&mut edit, axis, number);
                }
                written[k] = reached.at;
            }
        }
        self.pole = written[0].zip(written[1]).filter(|_| pole.centre.is_some()).map(|(first, second)| [first, second]);
        self.out.extend(edit.render());
        self.end_line(block, true);
    }

    /// Returns the number of decimals for coordinates in the unit of `unit_mm`.
    pub(crate) fn decimals(&self, unit_mm: f64) -> u8 {
        if unit_mm == LengthUnit::Inch.mm() {
            self.writing.format.inch_decimals()
        } else {
            self.writing.format.mm_decimals()
        }
    }

    /// Prepares for `motion`: brings written position and angles in line with what the program knows at its start.
    pub(crate) fn begin_motion(&mut self, motion: &Motion) {
        self.end_cycle(motion.code);
        let before = std::mem::replace(&mut self.coordinates, motion.turning.coordinates);
        let rotary = &self.program.options.rotary;
        self.tracked = rotary.convert_position(self.tracked, &self.rotary_angles[1], [before, self.coordinates]);
        for axis in 0..3 {
            let known = self.tracked[axis].or(motion.start[axis]);
            self.tracked[axis] = motion.start[axis].and(known);
        }
        if self.rotary_angles[0] != motion.turning.from {
            // Something else has turned them.
            self.rotary_angles = [motion.turning.from; 2];
        }
    }

    /// Returns how positions are written on the line of `motion`.
    pub(crate) fn coordinate_format(&self, motion: &Motion) -> CoordinateFormat {
        CoordinateFormat::new(&motion.modal, &motion.words, motion.origin, self.decimals(motion.modal.unit.mm()))
            .with_all_axes(self.full_lines.contains(&motion.line))
    }

    /// Returns the single block that passes all points of `stretch` within tolerance and ends at `goal` (mm in W), if there is one.
    fn fit_one_block(
        &self,
        motion: &Motion,
        format: CoordinateFormat,
        stretch: Stretch,
        goal: &Vector3<f64>,
        turned: RotaryWords,
    ) -> Option<OneBlock> {
        let axes = format.axis_words(&motion.words, self.tracked, goal);
        let end = located(axes.each_ref().map(|reached| reached.at))?;
        let (start, nominal_end) = (located(self.tracked)?, located(motion.end)?);
        if motion.would_be_helical(&start, &end) {
            return None;
        }
        let (centre, centre_words) = format.moved_centre(motion, end - nominal_end);
        let centre = if let Some(Centre::Pole(_)) = centre { self.pole.map(Centre::Pole) } else { centre };
        let candidate = motion_geometry(motion.code, motion.modal, start, end, centre).ok()?;
        let parameters = stretch.parameters(&candidate, self.tolerance(format))?;
        let is_turned = stretch.has_angles_at(
            &parameters,
            [&self.rotary_angles[1], &turned.to],
            angle_tolerance_deg(&motion.turning),
        );
        is_turned.then_some(OneBlock { axes, centre: centre_words, turned, parameters })
    }

    /// Returns all points of a motion as one stretch; `None` if its start is unknown.
    fn whole_stretch<'m>(&self, motion: &'m Motion, targets: Targets<'m>) -> Option<Stretch<'m>> {
        let (start, nominal) = (located(self.tracked)?, located(motion.start)?);
        let Targets { points, corrected, angles } = targets;
        Some(Stretch { nominal: &motion.geometry, before: (0.0, start - nominal), points, corrected, angles })
    }

    /// Returns how far a block written in the format `format` may be from the corrected points.
    pub(crate) fn tolerance(&self, format: CoordinateFormat) -> WriteTolerance {
        WriteTolerance { unit_mm: format.unit_mm().max(self.unit_before_mm), tolerance_mm: self.writing.tolerance_mm }
    }

    /// Records that a motion with path points at `parameters` (0 to 1) has been written.
    pub(crate) fn record_points(&mut self, parameters: &[f64]) {
        self.pieces.push(parameters.len());
        self.parameters.extend_from_slice(parameters);
    }

    /// Writes the block as one line, `kept`, in which only the numbers that must change do.
    fn write_line(&mut self, block: &Block, motion: &Motion, kept: OneBlock) {
        let content = self.program.content(block.line);
        let mut edit = LineEdit::new(content, &motion.words, self.style);
        let moves =
            kept.axes.iter().zip(self.tracked).any(|(reached, at)| reached.number.is_some() && reached.at != at);
        let is_inverse = moves && self.needs_inverse_time(motion);
        if is_inverse {
            self.begin_inverse_time(block, motion, &mut edit);
            set_feed(&mut edit, inverse_time_feed(motion, 1.0, true));
        }
        for (axis, reached) in kept.axes.iter().enumerate() {
            if let Some(number) = &reached.number {
                put_axis(&mut edit, axis, number);
            }
            self.tracked[axis] = reached.at;
        }
        for (axis, number) in motion.modal.plane.axes().into_iter().zip(kept.centre) {
            let letter = ['I', 'J', 'K'][axis];
            if let (Some(number), Some(index)) = (number, edit.find(|word| word.letter == letter)) {
                edit.set_number(index, &number);
            }
        }
        kept.turned.words.iter().for_each(|(letter, number)| edit.set_rotary(*letter, number));
        self.rotary_angles = [motion.turning.to, kept.turned.to];
        if block.motion_word.is_none() && self.motion_word.is_some_and(|code| code != motion.code) {
            edit.set_motion(motion.code);
        }
        self.motion_word = Some(motion.code);
        self.record_points(&kept.parameters);
        self.out.extend(edit.render());
        self.end_line(block, !is_inverse);
        if is_inverse {
            self.end_inverse_time(block, motion);
        }
    }

    /// Ends a line of `block`: the last one with the block's own line ending, the others with the program's.
    pub(crate) fn end_line(&mut self, block: &Block, last: bool) {
        let ending = &self.program.source[self.program.lines.ending(block.line)];
        self.out.extend_from_slice(if last || !ending.is_empty() { ending } else { self.newline });
    }
}

/// Sets the number of an axis on the line, in its word or in a new one.
pub(crate) fn put_axis(edit: &mut LineEdit, axis: usize, number: &str) {
    let letter = ['X', 'Y', 'Z'][axis];
    match edit.find(|word| word.letter == letter) {
        Some(index) => edit.set_number(index, number),
        None => edit.add_axis(axis, number),
    }
}
