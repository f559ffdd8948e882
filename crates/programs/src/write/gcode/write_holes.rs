//! Writes corrected holes of drilling cycles: new X, Y, Z and R; the cycle is kept, not expanded into moves.

use nalgebra::Vector3;

use crate::{
    expand::edit::LineEdit,
    model::{
        Hole, MotionGeometry,
        gcode::{Distance, Motion, MotionCode, PartialPosition, Word},
    },
    read::gcode::Block,
    write::gcode::{AxisWord, CoordinateFormat, Targets, Writer, put_axis},
};

/// The state of the drilling cycle after the lines written so far, mm.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CycleState {
    /// The numbers of R and Z.
    clear: Option<f64>,
    depth: Option<f64>,
    /// The height at which the series of holes began.
    initial: Option<f64>,
}

/// The corrected bottom of a hole and the height of its plane R, mm.
#[derive(Clone, Copy)]
struct DesiredHole {
    bottom: Vector3<f64>,
    clear: f64,
    back: f64,
}

/// One hole as it is written: its words, and position and cycle state after it.
struct WrittenHole {
    axes: [AxisWord; 3],
    clear: AxisWord,
    /// Of a cycle that says so itself, the height to which the tool comes back.
    retract: AxisWord,
    tracked: PartialPosition,
    cycle: CycleState,
}

impl WrittenHole {
    /// Whether all words of the hole stay as they are.
    fn is_unchanged(&self) -> bool {
        self.axes.iter().chain([&self.clear, &self.retract]).all(|reached| reached.number.is_none())
    }

    /// Iterates over letter and number of each word that must be written anew.
    fn numbers(&self) -> impl Iterator<Item = (char, &String)> {
        let letters = ['X', 'Y', 'Z', 'R', Word::RETRACT];
        let all = letters.into_iter().zip(self.axes.iter().chain([&self.clear, &self.retract]));
        all.filter_map(|(letter, reached)| Some((letter, reached.number.as_ref()?)))
    }
}

impl Writer<'_> {
    /// Writes the holes of one line: the line unchanged if it is right for all of them, otherwise a line for each.
    pub fn write_holes(&mut self, block: &Block, motions: &[Motion], targets: &[Targets]) {
        let Some(first) = motions.first() else { return };
        let goals: Vec<DesiredHole> = motions.iter().zip(targets).filter_map(hole_goal).collect();
        let retracts = first.words.iter().any(|word| word.letter == Word::RETRACT);
        if !retracts {
            self.set_motion(first.code);
        }
        self.begin_motion(first);
        let format = self.coordinate_format(first);
        if goals.len() < motions.len() {
            // Where the tool is is not known, or nothing is drilled (L0).
            for motion in motions.iter().filter(|motion| motion.end != motion.start) {
                self.tracked = format.unchanged_words(motion, self.tracked).map(|axis| axis.at);
                self.tracked[2] = None;
            }
            self.cycle = self.cycle.with(first, format.mm());
            self.pieces.extend(targets.iter().map(|_| 0));
            return self.copy_text(block.line);
        }
        let (before, cycle) = (self.tracked, self.cycle);
        let mut is_unchanged = true;
        for (motion, goal) in motions.iter().zip(&goals) {
            let written = self.fit_hole(motion, format, *goal);
            is_unchanged &= written.is_unchanged();
            (self.tracked, self.cycle) = (written.tracked, written.cycle);
        }
        for (motion, targets) in motions.iter().zip(targets) {
            self.record_points(&motion.parameters(targets.points.len()));
        }
        self.unit_before_mm = format.unit_mm();
        if is_unchanged {
            return self.copy_text(block.line);
        }
        (self.tracked, self.cycle) = (before, cycle);
        let content = self.program.content(block.line);
        for (k, (motion, goal)) in motions.iter().zip(&goals).enumerate() {
            let is_last = k + 1 == motions.len();
            if k == 0 {
                let written = self.fit_hole(motion, format, *goal);
                let (over, of_cycle): (Vec<_>, Vec<_>) =
                    written.numbers().partition(|(letter, _)| retracts && matches!(letter, 'X' | 'Y'));
                self.write_way_over(block, &over);
                let mut edit = LineEdit::new(content, &motion.words, self.style);
                for (letter, number) in of_cycle {
                    match edit.find(|word| word.letter == letter) {
                        Some(index) => edit.set_number(index, number),
                        None if letter == 'R' => edit.add_last(letter, number),
                        None => {
                            put_axis(&mut edit, ['X', 'Y', 'Z'].iter().position(|l| *l == letter).unwrap_or(0), number)
                        }
                    }
                }
                let repeats = ['L', 'K'].into_iter().find_map(|letter| edit.find(|word| word.letter == letter));
                if let Some(index) = repeats.filter(|_| !is_last) {
                    edit.remove(index);
                }
                self.out.extend(edit.render());
                (self.tracked, self.cycle) = (written.tracked, written.cycle);
            } else {
                let mut bare = motion.clone();
                bare.words.clear();
                let written = self.fit_hole(&bare, format, *goal);
                let style = self.style.adapted_to(content, &motion.words);
                let mut words: Vec<String> =
                    written.numbers().map(|(letter, number)| style.word(letter, number)).collect();
                if words.is_empty() {
                    // A line without a coordinate would be no hole.
                    let here = format.new_word(0, self.tracked[0], goal.bottom.x);
                    words.extend(here.number.map(|number| style.word('X', &number)));
                }
                self.out.extend_from_slice(&content[..block.prefix]);
                self.out.extend_from_slice(words.join(style.separator()).as_bytes());
                (self.tracked, self.cycle) = (written.tracked, written.cycle);
            }
            self.end_line(block, is_last);
        }
    }

    /// Writes the move to the numbers `over` a hole before its line, if there are any: the cycle drills where the tool is.
    fn write_way_over(&mut self, block: &Block, over: &[(char, &String)]) {
        if over.is_empty() {
            return;
        }
        let words = over.iter().map(|(letter, number)| self.style.word(*letter, number));
        let words: Vec<String> = std::iter::once("G0".to_owned()).chain(words).collect();
        self.out.extend_from_slice(&self.program.content(block.line)[..block.prefix]);
        self.out.extend_from_slice(words.join(self.style.separator()).as_bytes());
        self.end_line(block, false);
        self.pieces.insert(self.pieces.len() - 1, 0);
        self.motion_word = Some(MotionCode::Rapid);
    }

    /// Returns one hole as it is written from the tracked position: words of the line that already lead to `goal` stay.
    fn fit_hole(&self, motion: &Motion, format: CoordinateFormat, goal: DesiredHole) -> WrittenHole {
        let is_first = matches!(motion.geometry, MotionGeometry::Hole(Hole { is_first: true, .. }));
        let level = self.tracked[2];
        let mut cycle = self.cycle;
        cycle.initial = cycle.initial.filter(|_| !is_first).or(level);
        cycle = cycle.with(motion, format.mm());
        let [x, y] = [0, 1].map(|axis| format.axis_word(&motion.words, self.tracked, axis, goal.bottom[axis]));
        let retract = motion.words.iter().find(|word| word.letter == Word::RETRACT);
        let steps = motion.modal.distance == Distance::Incremental && retract.is_none();
        let height = |number: Option<f64>, from: Option<f64>, goal: f64| {
            let base = if steps { from } else { Some(motion.origin.z) };
            match number.zip(base).map(|(number, base)| number + base) {
                Some(at) if format.is_same(at, goal) => (AxisWord { number: None, at: Some(at) }, number),
                _ => {
                    let reached = format.new_word(2, from, goal);
                    let number = reached.number.as_ref().and_then(|number| number.parse::<f64>().ok());
                    (reached, number.map(|number| number * format.mm()))
                }
            }
        };
        let (clear, clear_number) = height(cycle.clear, level, goal.clear);
        let (bottom, depth_number) = height(cycle.depth, clear.at, goal.bottom.z);
        cycle = CycleState { clear: clear_number, depth: depth_number, ..cycle };
        let back = match motion.modal.returns_to_r_plane {
            true => clear.at,
            false => clear.at.zip(cycle.initial).map(|(clear, initial)| initial.max(clear)),
        };
        let retract = match retract {
            Some(word) => height(Some(word.value * format.mm()), level, goal.back).0,
            None => AxisWord { number: None, at: back },
        };
        let tracked = [x.at, y.at, retract.at];
        WrittenHole { axes: [x, y, bottom], clear, retract, tracked, cycle }
    }
}

impl CycleState {
    /// Returns the state updated by R and Z on the line of `motion`; `mm`: how many mm one unit is.
    fn with(self, motion: &Motion, mm: f64) -> CycleState {
        let number = |letter| motion.words.iter().find(|word| word.letter == letter).map(|word| word.value * mm);
        CycleState { clear: number('R').or(self.clear), depth: number('Z').or(self.depth), ..self }
    }
}

/// Returns the corrected bottom of a hole and the corrected height of its plane R; `None` if the motion is no located hole.
fn hole_goal((_, targets): (&Motion, &Targets)) -> Option<DesiredHole> {
    let [_, clear, .., bottom, back] = targets.corrected else { return None };
    Some(DesiredHole { bottom: *bottom, clear: clear.z, back: back.z })
}
