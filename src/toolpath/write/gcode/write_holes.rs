//! Holes of cycles as they are written: X, Y, Z and R of a line that stays a cycle.

use nalgebra::Vector3;

use crate::toolpath::{
    expand::edit::LineEdit,
    model::{
        Hole, Way,
        gcode::{Distance, Known, Motion},
    },
    read::gcode::Block,
    write::gcode::{Place, Reached, Targets, Writer, put_axis},
};

/// What the lines written so far leave for the next hole, mm.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Drilled {
    /// The numbers of R and Z.
    clear: Option<f64>,
    depth: Option<f64>,
    /// The height at which the series began.
    initial: Option<f64>,
}

/// Where a hole should be.
#[derive(Clone, Copy)]
struct Goal {
    bottom: Vector3<f64>,
    clear: f64,
}

/// One hole as it is written.
struct Written {
    axes: [Reached; 3],
    clear: Reached,
    tracked: Known,
    drilled: Drilled,
}

impl Written {
    fn is_kept(&self) -> bool {
        self.axes.iter().chain([&self.clear]).all(|reached| reached.number.is_none())
    }

    /// Letter and number of each word that must be written anew; words that are right as they stand are left out.
    fn numbers(&self) -> impl Iterator<Item = (char, &String)> {
        let all = ['X', 'Y', 'Z', 'R'].into_iter().zip(self.axes.iter().chain([&self.clear]));
        all.filter_map(|(letter, reached)| Some((letter, reached.number.as_ref()?)))
    }
}

impl Writer<'_> {
    /// Writes the holes of one line: as it is if that is right for all of them, and a line for each otherwise.
    pub fn holes(&mut self, block: &Block, motions: &[Motion], targets: &[Targets]) {
        let Some(first) = motions.first() else { return };
        let goals: Vec<Goal> = motions.iter().zip(targets).filter_map(goal).collect();
        self.motion_word = Some(first.code);
        self.begin(first);
        let place = self.place(first);
        if goals.len() < motions.len() {
            // Where the tool is is not known, or nothing is drilled (L0).
            for motion in motions.iter().filter(|motion| motion.end != motion.start) {
                self.tracked = place.as_they_are(motion, self.tracked).map(|axis| axis.at);
                self.tracked[2] = None;
            }
            self.drilled = self.drilled.with(first, place.mm());
            self.pieces.extend(targets.iter().map(|_| 0));
            return self.copy(block.line);
        }
        let (before, drilled) = (self.tracked, self.drilled);
        let mut as_it_is = true;
        for (motion, goal) in motions.iter().zip(&goals) {
            let written = self.hole(motion, place, *goal);
            as_it_is &= written.is_kept();
            (self.tracked, self.drilled) = (written.tracked, written.drilled);
        }
        for (motion, targets) in motions.iter().zip(targets) {
            self.stands_for(&motion.parameters(targets.points.len()));
        }
        self.unit_before_mm = place.unit_mm();
        if as_it_is {
            return self.copy(block.line);
        }
        (self.tracked, self.drilled) = (before, drilled);
        let content = self.program.content(block.line);
        for (k, (motion, goal)) in motions.iter().zip(&goals).enumerate() {
            let is_last = k + 1 == motions.len();
            if k == 0 {
                let written = self.hole(motion, place, *goal);
                let mut edit = LineEdit::new(content, &motion.words, self.style);
                for (letter, number) in written.numbers() {
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
                (self.tracked, self.drilled) = (written.tracked, written.drilled);
            } else {
                let mut bare = motion.clone();
                bare.words.clear();
                let written = self.hole(&bare, place, *goal);
                let style = self.style.on_line(content, &motion.words);
                let mut words: Vec<String> =
                    written.numbers().map(|(letter, number)| style.word(letter, number)).collect();
                if words.is_empty() {
                    // A line without a coordinate would be no hole.
                    let here = place.write(0, self.tracked[0], goal.bottom.x);
                    words.extend(here.number.map(|number| style.word('X', &number)));
                }
                self.out.extend_from_slice(&content[..block.prefix]);
                self.out.extend_from_slice(words.join(style.separator()).as_bytes());
                (self.tracked, self.drilled) = (written.tracked, written.drilled);
            }
            self.end_line(block, is_last);
        }
    }

    /// The numbers of one hole, from where the tool is; those of the line where they are right.
    fn hole(&self, motion: &Motion, place: Place, goal: Goal) -> Written {
        let is_first = matches!(motion.geometry, Way::Hole(Hole { is_first: true, .. }));
        let level = self.tracked[2];
        let mut drilled = self.drilled;
        drilled.initial = drilled.initial.filter(|_| !is_first).or(level);
        drilled = drilled.with(motion, place.mm());
        let [x, y] = [0, 1].map(|axis| place.reach(&motion.words, self.tracked, axis, goal.bottom[axis]));
        let steps = motion.modal.distance == Distance::Incremental;
        let height = |number: Option<f64>, from: Option<f64>, goal: f64| {
            let base = if steps { from } else { Some(motion.origin.z) };
            match number.zip(base).map(|(number, base)| number + base) {
                Some(at) if place.same(at, goal) => (Reached { number: None, at: Some(at) }, number),
                _ => {
                    let reached = place.write(2, from, goal);
                    let number = reached.number.as_ref().and_then(|number| number.parse::<f64>().ok());
                    (reached, number.map(|number| number * place.mm()))
                }
            }
        };
        let (clear, clear_number) = height(drilled.clear, level, goal.clear);
        let (bottom, depth_number) = height(drilled.depth, clear.at, goal.bottom.z);
        drilled = Drilled { clear: clear_number, depth: depth_number, ..drilled };
        let back = match motion.modal.returns_to_clear {
            true => clear.at,
            false => clear.at.zip(drilled.initial).map(|(clear, initial)| initial.max(clear)),
        };
        let tracked = [x.at, y.at, back];
        Written { axes: [x, y, bottom], clear, tracked, drilled }
    }
}

impl Drilled {
    /// With the numbers of R and Z that the line has, `mm` in a unit.
    fn with(self, motion: &Motion, mm: f64) -> Drilled {
        let number = |letter| motion.words.iter().find(|word| word.letter == letter).map(|word| word.value * mm);
        Drilled { clear: number('R').or(self.clear), depth: number('Z').or(self.depth), ..self }
    }
}

/// The corrected bottom of a hole and the corrected height of its beginning.
fn goal((_, targets): (&Motion, &Targets)) -> Option<Goal> {
    let [_, clear, .., bottom, _] = targets.corrected else { return None };
    Some(Goal { bottom: *bottom, clear: clear.z })
}
