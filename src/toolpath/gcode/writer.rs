//! The program as it is being written, block by block.

use nalgebra::Vector3;

use crate::toolpath::{
    NumberFormat, PathPoint,
    gcode::{
        Block, Program,
        arc::Centre,
        check::Check,
        edit::{LineEdit, Style, acts_at_end, is_arc_word, takes_parameters},
        follow::route,
        interpret::OriginAt,
        modal::{FeedMode, LengthUnit, MotionCode},
        motion::{Known, Motion, located},
        place::{Place, Reached},
        write_holes::Drilled,
    },
    number::shortest,
};

/// The points of one motion and where they should be.
#[derive(Clone, Copy)]
pub(super) struct Targets<'a> {
    pub points: &'a [PathPoint],
    pub corrected: &'a [Vector3<f64>],
}

/// One block that passes all its targets: what to write, and where it leads.
struct Kept {
    axes: [Reached; 3],
    centre: [Option<String>; 2],
}

/// The program as far as it is written.
pub(super) struct Writer<'p> {
    pub(super) program: &'p Program,
    format: NumberFormat,
    pub(super) style: Style,
    newline: &'p [u8],
    pub out: Vec<u8>,
    /// How many path points each motion written stands for.
    pub pieces: Vec<usize>,
    /// Where the words written so far have led, as a controller adds them up.
    pub(super) tracked: Known,
    /// The centre of arcs that give none, as it is written.
    pub(super) pole: Option<[f64; 2]>,
    /// The cycle in force, as it is written.
    pub(super) drilled: Drilled,
    /// One unit of the last decimal of the block written last, mm: the next one starts from its rounding.
    pub(super) unit_before_mm: f64,
    /// The motion in force at the end of what is written.
    pub motion_word: Option<MotionCode>,
}

impl<'p> Writer<'p> {
    pub fn new(program: &'p Program, format: NumberFormat) -> Writer<'p> {
        let endings = program.lines.iter().map(|line| &program.source[line.ending.clone()]);
        Writer {
            program,
            format,
            style: program.style(),
            newline: endings.into_iter().find(|ending| !ending.is_empty()).unwrap_or(b"\n"),
            out: Vec::with_capacity(program.source.len() * 2),
            pieces: Vec::new(),
            tracked: [None; 3],
            pole: None,
            drilled: Drilled::default(),
            unit_before_mm: 0.0,
            motion_word: None,
        }
    }

    /// Copies line `index` as it is.
    pub fn copy(&mut self, index: usize) {
        let line = &self.program.lines[index];
        self.out.extend_from_slice(&self.program.source[line.content.start..line.ending.end]);
    }

    /// Writes a motion block, as one block if one will do.
    pub fn motion(&mut self, block: &Block, motion: &Motion, targets: Targets) {
        self.begin(motion);
        let place = self.place(motion);
        if targets.points.is_empty() {
            let axes = place.as_they_are(motion, self.tracked);
            self.write_kept(block, motion, Kept { axes, centre: [None, None] });
            self.pieces.push(0);
        } else if let Some(kept) = self.keep(motion, place, targets) {
            self.write_kept(block, motion, kept);
            self.pieces.push(targets.points.len());
        } else {
            self.write_split(block, motion, place, targets.corrected);
            self.pieces.extend(targets.points.iter().map(|_| 1));
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

    pub(super) fn decimals(&self, unit_mm: f64) -> u8 {
        if unit_mm == LengthUnit::Inch.mm() { self.format.inch_decimals() } else { self.format.mm_decimals() }
    }

    /// Both sides know an axis or neither does; before the first word, the tool is at the given start.
    pub(super) fn begin(&mut self, motion: &Motion) {
        for axis in 0..3 {
            let known = self.tracked[axis].or(motion.start[axis]);
            self.tracked[axis] = motion.start[axis].and(known);
        }
    }

    pub(super) fn place(&self, motion: &Motion) -> Place {
        Place::new(&motion.modal, &motion.words, motion.origin, self.decimals(motion.modal.unit.mm()))
    }

    /// The one block that passes all targets, if there is one.
    fn keep(&self, motion: &Motion, place: Place, targets: Targets) -> Option<Kept> {
        let goal = targets.corrected.last()?;
        let axes = place.end(&motion.words, self.tracked, goal);
        let end = located(axes.each_ref().map(|reached| reached.at))?;
        let (Some(start), Some(nominal_start)) = (located(self.tracked), located(motion.start)) else {
            // Coming from nowhere known, only the end matters.
            return Some(Kept { axes, centre: [None, None] });
        };
        let nominal_end = located(motion.end)?;
        if makes_helix(motion, nominal_end - nominal_start, end - start) {
            return None;
        }
        let (centre, centre_words) = place.centre(motion, end - nominal_end);
        let centre = if let Some(Centre::Pole(_)) = centre { self.pole.map(Centre::Pole) } else { centre };
        let candidate = route(motion.code, motion.modal, start, end, centre).ok()?;
        let check = Check {
            nominal: &motion.geometry,
            candidate: &candidate,
            tolerance: place.unit_mm().max(self.unit_before_mm),
        };
        let mut before = (0.0, start - nominal_start);
        for (point, corrected) in targets.points.iter().zip(targets.corrected) {
            let here = (point.source.parameter, corrected - point.position_mm);
            if !check.passes(before, here) {
                return None;
            }
            before = here;
        }
        Some(Kept { axes, centre: centre_words })
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
        if block.motion_word.is_none() && self.motion_word.is_some_and(|code| code != motion.code) {
            edit.set_motion(motion.code);
        }
        self.motion_word = Some(motion.code);
        self.out.extend(edit.render());
        self.end_line(block, true);
    }

    /// Writes the block as G1 blocks, one to each of `corrected`.
    fn write_split(&mut self, block: &Block, motion: &Motion, place: Place, corrected: &[Vector3<f64>]) {
        let content = self.program.content(block.line);
        let mut edit = LineEdit::new(content, &motion.words, self.style);
        if block.motion_word.is_some() || self.motion_word != Some(MotionCode::Line) {
            edit.set_motion(MotionCode::Line);
        }
        self.motion_word = Some(MotionCode::Line);
        // Each of the lines takes its part of the time.
        let feed = motion.modal.feed.filter(|_| motion.modal.feed_mode == FeedMode::InverseTime);
        let feed = feed.map(|feed| shortest(feed * corrected.len() as f64, 1));
        if let (Some(feed), Some(index)) = (&feed, edit.find(|word| word.letter == 'F')) {
            edit.set_number(index, feed);
        }
        let mut at_end = Vec::new();
        let parameters_at_end = motion.words.iter().filter(|word| takes_parameters(word)).all(acts_at_end);
        for (index, word) in motion.words.iter().enumerate() {
            let moves = acts_at_end(word) || (parameters_at_end && matches!(word.letter, 'E' | 'P' | 'Q'));
            if is_arc_word(word) {
                edit.remove(index);
            } else if corrected.len() > 1 && moves {
                at_end.extend(edit.remove(index));
            }
        }
        let style = edit.style();
        let mut first_line = Some(edit);
        for (k, goal) in corrected.iter().enumerate() {
            let last = k + 1 == corrected.len();
            let place = if first_line.is_some() { place } else { place.on_new_line(&motion.modal) };
            let numbers = self.step(motion, content, place, goal, [first_line.is_some(), last]);
            if let Some(mut edit) = first_line.take() {
                numbers.iter().for_each(|(axis, number)| put_axis(&mut edit, *axis, number));
                self.out.extend(edit.render());
            } else {
                let mut words: Vec<String> = style.next_line().into_iter().collect();
                words.extend(numbers.iter().map(|(axis, number)| style.axis(*axis, number)));
                words.extend(feed.as_ref().map(|feed| style.word('F', feed)));
                if last {
                    words.append(&mut at_end);
                }
                self.out.extend_from_slice(&content[..block.prefix]);
                self.out.extend_from_slice(words.join(style.separator()).as_bytes());
            }
            self.end_line(block, last);
        }
    }

    /// The numbers that lead to `goal`, by axis; on the block's first line, also those its own words ask for. Where a word of
    /// the block leads there as it is, on the first line or the last, it keeps its text.
    fn step(
        &mut self,
        motion: &Motion,
        content: &[u8],
        place: Place,
        goal: &Vector3<f64>,
        [first, last]: [bool; 2],
    ) -> Vec<(usize, String)> {
        let mut numbers = Vec::new();
        for axis in 0..3 {
            let word = motion.words.iter().find(|word| word.letter == ['X', 'Y', 'Z'][axis]);
            let here = self.tracked[axis];
            let own = word.filter(|_| first || last).and_then(|word| {
                let at = place.as_it_is(&motion.words, self.tracked, axis).filter(|at| place.same(*at, goal[axis]))?;
                Some((String::from_utf8_lossy(&content[word.number()]).into_owned(), at))
            });
            match own {
                Some((number, at)) if first || here != Some(at) => {
                    self.tracked[axis] = Some(at);
                    numbers.push((axis, number));
                }
                _ if (first && word.is_some()) || here.is_none_or(|at| !place.same(at, goal[axis])) => {
                    let reached = place.write(axis, here, goal[axis]);
                    self.tracked[axis] = reached.at;
                    numbers.extend(reached.number.map(|number| (axis, number)));
                }
                _ => {}
            }
        }
        if numbers.is_empty() {
            // A block without a coordinate would be no block; this one repeats the point it is at.
            let at = self.tracked[0].unwrap_or(goal.x);
            numbers.extend(place.write(0, Some(at), at).number.map(|number| (0, number)));
        }
        numbers
    }

    /// Ends a line of `block`: the last with the ending it had, the others with the program's.
    pub(super) fn end_line(&mut self, block: &Block, last: bool) {
        let own = &self.program.source[self.program.lines[block.line].ending.clone()];
        self.out.extend_from_slice(if last || !own.is_empty() { own } else { self.newline });
    }
}

/// Whether a flat arc would become a helix, which not every controller can drive.
fn makes_helix(motion: &Motion, nominal: Vector3<f64>, written: Vector3<f64>) -> bool {
    let normal = motion.modal.plane.axes()[2];
    matches!(motion.code, MotionCode::Arc(_)) && nominal[normal] == 0.0 && written[normal] != 0.0
}

/// Puts an axis number on the line, in its word or a new one.
pub(super) fn put_axis(edit: &mut LineEdit, axis: usize, number: &str) {
    let letter = ['X', 'Y', 'Z'][axis];
    match edit.find(|word| word.letter == letter) {
        Some(index) => edit.set_number(index, number),
        None => edit.add_axis(axis, number),
    }
}
