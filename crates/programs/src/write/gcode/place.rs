//! Positions as numbers on a G-code line: unit, origin, absolute or incremental, rounded to the written decimals.

use nalgebra::Vector3;

use crate::model::{
    format_fixed,
    gcode::{Centre, Distance, ModalState, Motion, PartialPosition, Word},
    last_place,
};

/// How positions are written on a line: unit, distance mode, zero and decimals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoordinateFormat {
    mm: f64,
    /// The distance mode of each axis: a word may have its own.
    distances: [Distance; 3],
    origin: Vector3<f64>,
    decimals: u8,
    /// Whether every axis in absolute mode gets a word, needed or not.
    writes_all_axes: bool,
}

/// An axis word to write and the coordinate that it commands.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AxisWord {
    /// The number to write; `None` where the line stays as it is.
    pub number: Option<String>,
    /// The coordinate, mm in the workpiece frame.
    pub at: Option<f64>,
}

impl CoordinateFormat {
    /// Creates the format from the modal state, the `words` of the line to change (none for a new line) and the zero, mm.
    pub fn new(modal: &ModalState, words: &[Word], origin: Vector3<f64>, decimals: u8) -> CoordinateFormat {
        let own_distance = |letter| words.iter().find(|word| word.letter == letter).and_then(|word| word.distance);
        let distances = ['X', 'Y', 'Z'].map(|letter| own_distance(letter).unwrap_or(modal.distance));
        CoordinateFormat { mm: modal.unit.mm(), distances, origin, decimals, writes_all_axes: false }
    }

    /// Returns the same format, with a word for every axis in absolute mode if `writes_all_axes`.
    pub fn with_all_axes(self, writes_all_axes: bool) -> CoordinateFormat {
        CoordinateFormat { writes_all_axes, ..self }
    }

    /// Returns the same format for a new line: all axes in the distance mode in force.
    pub fn for_new_line(self, modal: &ModalState) -> CoordinateFormat {
        CoordinateFormat { distances: [modal.distance; 3], ..self }
    }

    /// Returns how many mm one unit of the line is.
    pub fn mm(self) -> f64 {
        self.mm
    }

    /// Returns one unit of the last decimal, mm.
    pub fn unit_mm(self) -> f64 {
        last_place(self.decimals) * self.mm
    }

    /// Whether two coordinates, mm, are equal to half a unit of the last decimal.
    pub fn is_same(self, a: f64, b: f64) -> bool {
        (a - b).abs() <= self.unit_mm() * (0.5 + 1e-6)
    }

    /// Formats the number that moves `axis` from `from` to `goal` (mm in W), and returns it with the coordinate after rounding.
    pub fn new_word(self, axis: usize, from: Option<f64>, goal: f64) -> AxisWord {
        let zero = match (self.distances[axis], from) {
            (Distance::Incremental, Some(from)) => from,
            _ => self.origin[axis],
        };
        let number = format_fixed((goal - zero) / self.mm, self.decimals);
        let at = number.parse::<f64>().map_or(goal, |value| value * self.mm + zero);
        AxisWord { number: Some(number), at: Some(at) }
    }

    /// Returns the unchanged axis words of `motion` with the coordinates (mm in W) to which they lead from the written position `tracked`.
    pub fn unchanged_words(self, motion: &Motion, tracked: PartialPosition) -> [AxisWord; 3] {
        [0, 1, 2].map(|axis| AxisWord { number: None, at: self.unchanged_coordinate(&motion.words, tracked, axis) })
    }

    /// Returns the coordinate, mm, to which the unchanged word for `axis` leads from `tracked`; without a word that of `tracked`. `None` if that is
    /// needed and unknown.
    pub fn unchanged_coordinate(self, words: &[Word], tracked: PartialPosition, axis: usize) -> Option<f64> {
        let word = words.iter().find(|word| word.letter == ['X', 'Y', 'Z'][axis]);
        match (word, self.distances[axis]) {
            (None, _) => tracked[axis],
            (Some(word), Distance::Absolute) => Some(word.value * self.mm + self.origin[axis]),
            (Some(word), Distance::Incremental) => tracked[axis].map(|from| word.value * self.mm + from),
        }
    }

    /// Returns the axis words that lead from `tracked` to `goal`, unchanged where they already do.
    pub fn axis_words(self, words: &[Word], tracked: PartialPosition, goal: &Vector3<f64>) -> [AxisWord; 3] {
        [0, 1, 2].map(|axis| self.axis_word(words, tracked, axis, goal[axis]))
    }

    /// Returns the word for `axis` that leads from `tracked` to `goal` (mm), unchanged where it already does.
    pub fn axis_word(self, words: &[Word], tracked: PartialPosition, axis: usize, goal: f64) -> AxisWord {
        match self.unchanged_coordinate(words, tracked, axis) {
            Some(at) if self.is_same(at, goal) && !self.lacks(words, axis) => AxisWord { number: None, at: Some(at) },
            _ => self.new_word(axis, tracked[axis], goal),
        }
    }

    /// Whether `axis` must have a word and `words` has none for it.
    fn lacks(self, words: &[Word], axis: usize) -> bool {
        let is_there = || words.iter().any(|word| word.letter == ['X', 'Y', 'Z'][axis]);
        self.writes_all_axes && self.distances[axis] == Distance::Absolute && !is_there()
    }

    /// Returns the centre of an arc moved by `shift` (mm), and the numbers to write for it: only an absolute centre needs new ones.
    pub fn moved_centre(self, motion: &Motion, shift: Vector3<f64>) -> (Option<Centre>, [Option<String>; 2]) {
        let Some(Centre::At(mut at)) = motion.centre else {
            return (motion.centre, [None, None]);
        };
        let mut numbers = [None, None];
        let axes = motion.modal.plane.axes();
        for k in 0..2 {
            if !self.is_same(shift[axes[k]], 0.0) {
                let origin = self.origin[axes[k]];
                let number = format_fixed((at[k] + shift[axes[k]] - origin) / self.mm, self.decimals);
                at[k] = number.parse::<f64>().map_or(at[k], |value| value * self.mm + origin);
                numbers[k] = Some(number);
            }
        }
        (Some(Centre::At(at)), numbers)
    }

    /// Returns the centre words, in the form that `motion` uses, for an arc from `start` about `at` (mm), and the centre as rounded.
    /// `is_long`: the arc turns by more than 180°. `None` if the motion has no centre of its own.
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
            let number = format_fixed(mm / self.mm, self.decimals);
            number.parse::<f64>().ok().map(|value| (number, value * self.mm))
        };
        let letters = [0, 1].map(|k| ['I', 'J', 'K'][axes[k]]);
        match motion.centre? {
            // One centre for several arcs.
            Centre::Pole(_) => None,
            Centre::Radius(_) => {
                let radius = libm::hypot(from_start[0], from_start[1]);
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
