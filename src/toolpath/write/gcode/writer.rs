//! The program as it is being written, block by block.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::toolpath::{
    expand::edit::LineEdit,
    model::{
        NumberFormat, PathPoint,
        gcode::{Angles, Centre, Known, LengthUnit, Motion, MotionCode, Writing, located},
        shortest,
    },
    read::gcode::{Block, OriginAt, Pole, Program, Style, route},
    write::gcode::{Allowed, Drilled, Place, Reached, Stretch, Turned, allowed_deg},
};

/// The points of one motion and where they should be.
#[derive(Clone, Copy)]
pub(crate) struct Targets<'a> {
    pub points: &'a [PathPoint],
    pub corrected: &'a [Vector3<f64>],
    /// Where rotary axes should stand, if they turn or are corrected.
    pub angles: Option<&'a [Angles]>,
}

impl Targets<'_> {
    /// Where rotary axes should stand at the end of `motion`, degrees.
    fn turned(&self, motion: &Motion) -> Angles {
        self.angles.and_then(|angles| angles.last()).copied().unwrap_or(motion.turning.to)
    }
}

/// One block that passes all its targets: what to write, and where it leads.
struct Kept {
    axes: [Reached; 3],
    centre: [Option<String>; 2],
    turned: Turned,
    /// Where on it each of the targets lies, from 0 to 1.
    places: Vec<f64>,
}

/// The program as far as it is written.
pub(crate) struct Writer<'p> {
    pub(crate) program: &'p Program,
    pub(crate) writing: Writing,
    pub(crate) style: Style,
    newline: &'p [u8],
    pub out: Vec<u8>,
    /// How many path points each motion written stands for.
    pub pieces: Vec<usize>,
    /// Where on its motion each of them lies, from 0 to 1.
    pub places: Vec<f64>,
    /// Where the bytes of each line end, of a program written out.
    pub line_ends: Vec<usize>,
    /// Lines, from 1, whose moves get a word for every axis.
    spelled: &'p BTreeSet<usize>,
    /// Where the words written so far have led, as a controller adds them up.
    pub(crate) tracked: Known,
    /// Where rotary axes stand by the program, and where the words written so far have turned them, degrees.
    pub(crate) stands: [Angles; 2],
    /// Whether the coordinates written last were those of the tip.
    of_tip: bool,
    /// The centre of arcs that give none, as it is written.
    pub(crate) pole: Option<[f64; 2]>,
    /// The cycle in force, as it is written.
    pub(crate) drilled: Drilled,
    /// One unit of the last decimal of the block written last, mm: the next one starts from its rounding.
    pub(crate) unit_before_mm: f64,
    /// The motion in force at the end of what is written.
    pub motion_word: Option<MotionCode>,
}

impl<'p> Writer<'p> {
    pub fn new(program: &'p Program, writing: Writing, spelled: &'p BTreeSet<usize>) -> Writer<'p> {
        let mut endings = (0..program.lines.len()).map(|line| &program.source[program.lines.ending(line)]);
        Writer {
            program,
            writing,
            style: program.style,
            newline: endings.find(|ending| !ending.is_empty()).unwrap_or(b"\n"),
            out: Vec::with_capacity(program.source.len()),
            pieces: Vec::with_capacity(program.motions.len()),
            places: Vec::new(),
            line_ends: Vec::new(),
            spelled,
            tracked: [None; 3],
            stands: [[0.0; 3]; 2],
            of_tip: program.options.rotary.always_of_tip,
            pole: None,
            drilled: Drilled::default(),
            unit_before_mm: 0.0,
            motion_word: None,
        }
    }

    /// Copies line `index` as it is.
    pub fn copy(&mut self, index: usize) {
        let lines = &self.program.lines;
        self.out.extend_from_slice(&self.program.source[lines.content(index).start..lines.ending(index).end]);
    }

    /// Copies line `index`, which is no block.
    pub fn copy_line(&mut self, index: usize) {
        self.copy(index);
        self.end_of_block();
    }

    /// All that a line becomes has been written.
    pub fn end_of_block(&mut self) {
        if self.program.written_out.is_some() {
            self.line_ends.push(self.out.len());
        }
    }

    /// Writes a motion block, as one block if one will do.
    pub fn motion(&mut self, block: &Block, motion: &Motion, targets: Targets) {
        self.begin(motion);
        let place = self.place(motion);
        let turned = self.turn_to(motion, self.program.content(block.line), &targets.turned(motion), [true, true]);
        match (targets.corrected.last(), self.stretch(motion, targets)) {
            (None, _) => {
                let axes = place.as_they_are(motion, self.tracked);
                self.write_kept(block, motion, Kept { axes, centre: [None, None], turned, places: Vec::new() });
            }
            (Some(goal), None) => {
                // Coming from nowhere known, only the end matters.
                let axes = place.end(&motion.words, self.tracked, goal);
                self.write_kept(block, motion, Kept { axes, centre: [None, None], turned, places: vec![1.0] });
            }
            (Some(goal), Some(stretch)) => match self.keep(motion, place, stretch, goal, turned) {
                Some(kept) => self.write_kept(block, motion, kept),
                None => self.split(block, motion, place, stretch),
            },
        }
        self.unit_before_mm = place.unit_mm();
    }

    /// Writes a line that sets a zero by where the tool is, so that the zero stays where the program has it.
    pub fn origin(&mut self, block: &Block, origin: &OriginAt) {
        let content = self.program.content(block.line);
        let mut edit = LineEdit::new(content, &origin.words, self.style);
        for axis in 0..3 {
            let (Some(place), Some(here)) = (origin.place[axis], self.tracked[axis]) else { continue };
            let index = edit.find(|word| word.letter == ['X', 'Y', 'Z'][axis]);
            // Nothing that could add up is left of the difference.
            if let Some(index) = index.filter(|_| (here - place).abs() > NumberFormat::FINEST) {
                let value = origin.words[index].value + (here - place) / origin.unit_mm;
                edit.set_number(index, &shortest(value, self.decimals(origin.unit_mm)));
            }
        }
        self.out.extend(edit.render());
        self.end_line(block, true);
    }

    /// Writes a line that sets a centre, moved by `shift`.
    pub fn pole(&mut self, block: &Block, pole: &Pole, shift: Vector3<f64>) {
        let place = Place::new(&pole.modal, &pole.words, pole.origin, self.decimals(pole.modal.unit.mm()));
        let tracked = [0, 1, 2].map(|axis| pole.start[axis].and(self.tracked[axis].or(pole.start[axis])));
        let content = self.program.content(block.line);
        let mut edit = LineEdit::new(content, &pole.words, self.style);
        let [first, second, _] = pole.modal.plane.axes();
        let mut written = [tracked[first], tracked[second]];
        let has_words = edit.find(|word| word.letter == ['X', 'Y', 'Z'][first]).is_some();
        if let Some(at) = pole.place.filter(|_| has_words) {
            for (k, axis) in [first, second].into_iter().enumerate() {
                let reached = place.reach(&pole.words, tracked, axis, at[k] + shift[axis]);
                if let Some(number) = &reached.number {
                    put_axis(&mut edit, axis, number);
                }
                written[k] = reached.at;
            }
        }
        self.pole = written[0].zip(written[1]).filter(|_| pole.place.is_some()).map(|(first, second)| [first, second]);
        self.out.extend(edit.render());
        self.end_line(block, true);
    }

    pub(crate) fn decimals(&self, unit_mm: f64) -> u8 {
        if unit_mm == LengthUnit::Inch.mm() {
            self.writing.format.inch_decimals()
        } else {
            self.writing.format.mm_decimals()
        }
    }

    /// Both sides know an axis or neither does; before the first word, the tool is at the given start.
    pub(crate) fn begin(&mut self, motion: &Motion) {
        if motion.turning.of_tip != self.of_tip {
            self.of_tip = motion.turning.of_tip;
            self.tracked = self.program.options.rotary.switched(self.tracked, &self.stands[1], self.of_tip);
        }
        for axis in 0..3 {
            let known = self.tracked[axis].or(motion.start[axis]);
            self.tracked[axis] = motion.start[axis].and(known);
        }
        if self.stands[0] != motion.turning.from {
            // Something else has turned them.
            self.stands = [motion.turning.from; 2];
        }
    }

    pub(crate) fn place(&self, motion: &Motion) -> Place {
        Place::new(&motion.modal, &motion.words, motion.origin, self.decimals(motion.modal.unit.mm()))
            .spelled(self.spelled.contains(&motion.line))
    }

    /// The one block that passes all of `stretch` and ends at `goal`, if there is one.
    fn keep(
        &self,
        motion: &Motion,
        place: Place,
        stretch: Stretch,
        goal: &Vector3<f64>,
        turned: Turned,
    ) -> Option<Kept> {
        let axes = place.end(&motion.words, self.tracked, goal);
        let end = located(axes.each_ref().map(|reached| reached.at))?;
        let (start, nominal_end) = (located(self.tracked)?, located(motion.end)?);
        if motion.makes_helix(&start, &end) {
            return None;
        }
        let (centre, centre_words) = place.centre(motion, end - nominal_end);
        let centre = if let Some(Centre::Pole(_)) = centre { self.pole.map(Centre::Pole) } else { centre };
        let candidate = route(motion.code, motion.modal, start, end, centre).ok()?;
        let places = stretch.places(&candidate, self.allowed(place))?;
        let is_turned = stretch.is_turned(&places, [&self.stands[1], &turned.to], allowed_deg(&motion.turning));
        is_turned.then_some(Kept { axes, centre: centre_words, turned, places })
    }

    /// The whole of a motion, if it is known where it begins.
    fn stretch<'m>(&self, motion: &'m Motion, targets: Targets<'m>) -> Option<Stretch<'m>> {
        let (start, nominal) = (located(self.tracked)?, located(motion.start)?);
        let Targets { points, corrected, angles } = targets;
        Some(Stretch { nominal: &motion.geometry, before: (0.0, start - nominal), points, corrected, angles })
    }

    /// How far off a block may be that is written as `place` says.
    pub(crate) fn allowed(&self, place: Place) -> Allowed {
        Allowed { unit_mm: place.unit_mm().max(self.unit_before_mm), tolerance_mm: self.writing.tolerance_mm }
    }

    /// A motion that stands for points at `places` of it has been written.
    pub(crate) fn stands_for(&mut self, places: &[f64]) {
        self.pieces.push(places.len());
        self.places.extend_from_slice(places);
    }

    /// Writes the block as one line, changing the numbers that must change.
    fn write_kept(&mut self, block: &Block, motion: &Motion, kept: Kept) {
        let content = self.program.content(block.line);
        let mut edit = LineEdit::new(content, &motion.words, self.style);
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
        kept.turned.words.iter().for_each(|(letter, number)| edit.put_turn(*letter, number));
        self.stands = [motion.turning.to, kept.turned.to];
        if block.motion_word.is_none() && self.motion_word.is_some_and(|code| code != motion.code) {
            edit.set_motion(motion.code);
        }
        self.motion_word = Some(motion.code);
        self.stands_for(&kept.places);
        self.out.extend(edit.render());
        self.end_line(block, true);
    }

    /// Ends a line of `block`: the last with the ending it had, the others with the program's.
    pub(crate) fn end_line(&mut self, block: &Block, last: bool) {
        let own = &self.program.source[self.program.lines.ending(block.line)];
        self.out.extend_from_slice(if last || !own.is_empty() { own } else { self.newline });
    }
}

/// Puts an axis number on the line, in its word or a new one.
pub(crate) fn put_axis(edit: &mut LineEdit, axis: usize, number: &str) {
    let letter = ['X', 'Y', 'Z'][axis];
    match edit.find(|word| word.letter == letter) {
        Some(index) => edit.set_number(index, number),
        None => edit.add_axis(axis, number),
    }
}
