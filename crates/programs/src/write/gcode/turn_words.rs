//! The words A, B and C of rotary axes as they are written.

use crate::{
    model::{
        WRITTEN_RAD, format_fixed,
        gcode::{Angles, Coordinates, Distance, Motion, RotaryMotion},
        last_place,
    },
    write::gcode::Writer,
};

/// Decimals of written angles, degrees.
const ANGLE_DECIMALS: u8 = 4;

/// The words that turn rotary axes, and the angles that they reach, degrees.
pub(crate) struct RotaryWords {
    pub words: Vec<(char, String)>,
    pub to: Angles,
}

impl Writer<'_> {
    /// Returns the words that turn the rotary axes from their written angles to `goal`, degrees; `[first, last]`: whether they go to the
    /// first or last line that `motion` becomes. A word of the line `content` that already turns there keeps its text.
    pub(crate) fn rotary_words_to(
        &self,
        motion: &Motion,
        content: &[u8],
        goal: &Angles,
        [first, last]: [bool; 2],
    ) -> RotaryWords {
        let mut turned = RotaryWords { words: Vec::new(), to: self.rotary_angles[1] };
        for (axis, letter) in ['A', 'B', 'C'].into_iter().enumerate() {
            if !self.program.options.rotary.has_axis(letter) {
                continue;
            }
            let word = motion.words.iter().find(|word| word.letter == letter);
            let own_distance = word.and_then(|word| word.distance).unwrap_or(motion.modal.distance);
            let distance = if first { own_distance } else { motion.modal.distance };
            let (here, goal) = (self.rotary_angles[1][axis], goal[axis]);
            let zero = if distance == Distance::Incremental { here } else { 0.0 };
            let unchanged = word.filter(|_| (first || last) && own_distance == distance);
            let unchanged = unchanged.map(|word| (word, word.value + zero)).filter(|(_, at)| is_same(*at, goal));
            match unchanged {
                Some((_, at)) if first || here == at => turned.to[axis] = at,
                Some((word, at)) => {
                    turned.to[axis] = at;
                    turned.words.push((letter, String::from_utf8_lossy(&content[word.number()]).into_owned()));
                }
                None if (first && word.is_some()) || !is_same(here, goal) => {
                    let number = format_fixed(goal - zero, ANGLE_DECIMALS);
                    turned.to[axis] = number.parse::<f64>().map_or(goal, |value| value + zero);
                    turned.words.push((letter, number));
                }
                None => {}
            }
        }
        turned
    }
}

/// Returns the tolerance of rotary angles along a written block, degrees: one unit of the last decimal where X, Y and Z are not those of
/// the tip, as the tip then moves with the axis.
pub(crate) fn angle_tolerance_deg(turning: &RotaryMotion) -> f64 {
    if turning.coordinates != Coordinates::Head { WRITTEN_RAD.to_degrees() } else { last_place(ANGLE_DECIMALS) }
}

/// Whether two angles, degrees, are equal to half a unit of the last decimal.
fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= last_place(ANGLE_DECIMALS) * (0.5 + 1e-6)
}
