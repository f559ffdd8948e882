//! Positions as numbers on a line: unit, origin, absolute or incremental, rounded to the decimals written.

use nalgebra::Vector3;

use crate::toolpath::model::{
    fixed,
    gcode::{Centre, Distance, Known, Modal, Motion, Word},
    last_place,
};

/// How positions are written on a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    mm: f64,
    /// By axis: a word may say it itself.
    distances: [Distance; 3],
    origin: Vector3<f64>,
    decimals: u8,
    /// Whether every axis of absolute coordinates gets a word, needed or not.
    spelled: bool,
}

/// Where an axis word leads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reached {
    /// The number to write; nothing where the line is right as it is.
    pub number: Option<String>,
    /// The coordinate, mm in the workpiece frame.
    pub at: Option<f64>,
}

impl Place {
    /// `words` are those of the line that is changed; none for a new line.
    pub fn new(modal: &Modal, words: &[Word], origin: Vector3<f64>, decimals: u8) -> Place {
        let own = |letter| words.iter().find(|word| word.letter == letter).and_then(|word| word.distance);
        let distances = ['X', 'Y', 'Z'].map(|letter| own(letter).unwrap_or(modal.distance));
        Place { mm: modal.unit.mm(), distances, origin, decimals, spelled: false }
    }

    /// The same, with a word for every axis of absolute coordinates if `spelled`.
    pub fn spelled(self, spelled: bool) -> Place {
        Place { spelled, ..self }
    }

    /// This format with the distance mode in force, for all axes: a new line has no words of its own.
    pub fn on_new_line(self, modal: &Modal) -> Place {
        Place { distances: [modal.distance; 3], ..self }
    }

    /// mm in a unit of the line.
    pub fn mm(self) -> f64 {
        self.mm
    }

    /// One unit of the last decimal, mm.
    pub fn unit_mm(self) -> f64 {
        last_place(self.decimals) * self.mm
    }

    /// Whether two coordinates are the same to half a unit of the last decimal.
    pub fn same(self, a: f64, b: f64) -> bool {
        (a - b).abs() <= self.unit_mm() * (0.5 + 1e-6)
    }

    /// The number that leads from `from` to `goal`, and where it leads, rounded as it is.
    pub fn write(self, axis: usize, from: Option<f64>, goal: f64) -> Reached {
        let zero = match (self.distances[axis], from) {
            (Distance::Incremental, Some(from)) => from,
            _ => self.origin[axis],
        };
        let number = fixed((goal - zero) / self.mm, self.decimals);
        let at = number.parse::<f64>().map_or(goal, |value| value * self.mm + zero);
        Reached { number: Some(number), at: Some(at) }
    }

    /// Where the words of `motion` lead as they are, from where the tool really is.
    pub fn as_they_are(self, motion: &Motion, tracked: Known) -> [Reached; 3] {
        [0, 1, 2].map(|axis| Reached { number: None, at: self.as_it_is(&motion.words, tracked, axis) })
    }

    /// Where the word for `axis` leads as it is, or the tool stays without one.
    pub fn as_it_is(self, words: &[Word], tracked: Known, axis: usize) -> Option<f64> {
        let word = words.iter().find(|word| word.letter == ['X', 'Y', 'Z'][axis]);
        match (word, self.distances[axis]) {
            (None, _) => tracked[axis],
            (Some(word), Distance::Absolute) => Some(word.value * self.mm + self.origin[axis]),
            (Some(word), Distance::Incremental) => tracked[axis].map(|from| word.value * self.mm + from),
        }
    }

    /// The words that lead to `goal`: as they are where that is right.
    pub fn end(self, words: &[Word], tracked: Known, goal: &Vector3<f64>) -> [Reached; 3] {
        [0, 1, 2].map(|axis| self.reach(words, tracked, axis, goal[axis]))
    }

    /// The word for `axis` that leads to `goal`: as it is where that is right.
    pub fn reach(self, words: &[Word], tracked: Known, axis: usize, goal: f64) -> Reached {
        match self.as_it_is(words, tracked, axis) {
            Some(at) if self.same(at, goal) && !self.lacks(words, axis) => Reached { number: None, at: Some(at) },
            _ => self.write(axis, tracked[axis], goal),
        }
    }

    /// Whether `axis` is to have a word that is not among `words`.
    fn lacks(self, words: &[Word], axis: usize) -> bool {
        let is_there = || words.iter().any(|word| word.letter == ['X', 'Y', 'Z'][axis]);
        self.spelled && self.distances[axis] == Distance::Absolute && !is_there()
    }

    /// The centre of an arc moved by `shift`, and the numbers to write for it: only a centre in absolute
    /// coordinates moves against its words.
    pub fn centre(self, motion: &Motion, shift: Vector3<f64>) -> (Option<Centre>, [Option<String>; 2]) {
        let Some(Centre::At(mut at)) = motion.centre else {
            return (motion.centre, [None, None]);
        };
        let mut numbers = [None, None];
        let axes = motion.modal.plane.axes();
        for k in 0..2 {
            if !self.same(shift[axes[k]], 0.0) {
                let origin = self.origin[axes[k]];
                let number = fixed((at[k] + shift[axes[k]] - origin) / self.mm, self.decimals);
                at[k] = number.parse::<f64>().map_or(at[k], |value| value * self.mm + origin);
                numbers[k] = Some(number);
            }
        }
        (Some(Centre::At(at)), numbers)
    }

    /// The words that give an arc from `start` about `at` its centre, in the form of those of `motion`, and the centre as they
    /// say it. `is_long`: the arc turns by more than half a turn.
    pub fn write_centre(
        self,
        motion: &Motion,
        start: &Vector3<f64>,
        at: [f64; 2],
        is_long: bool,
    ) -> Option<(Centre, Vec<(char, String)>)> {
        let axes = motion.modal.plane.axes();
        let from_start = [0, 1].map(|k| at[k] - start[axes[k]]);
        let number = |mm: f64| {
            let number = fixed(mm / self.mm, self.decimals);
            number.parse::<f64>().ok().map(|value| (number, value * self.mm))
        };
        let letters = [0, 1].map(|k| ['I', 'J', 'K'][axes[k]]);
        match motion.centre? {
            // One centre for several arcs.
            Centre::Pole(_) => None,
            Centre::Radius(_) => {
                let radius = from_start[0].hypot(from_start[1]);
                let (text, radius) = number(if is_long { -radius } else { radius })?;
                Some((Centre::Radius(radius), vec![('R', text)]))
            }
            Centre::FromStart(_) => {
                let [(i, x), (j, y)] = [number(from_start[0])?, number(from_start[1])?];
                Some((Centre::FromStart([x, y]), vec![(letters[0], i), (letters[1], j)]))
            }
            Centre::At(_) => {
                let zero = [0, 1].map(|k| self.origin[axes[k]]);
                let [(i, x), (j, y)] = [number(at[0] - zero[0])?, number(at[1] - zero[1])?];
                Some((Centre::At([x + zero[0], y + zero[1]]), vec![(letters[0], i), (letters[1], j)]))
            }
        }
    }
}
