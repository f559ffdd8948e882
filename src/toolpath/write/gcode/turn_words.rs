//! A, B and C as they are written.

use crate::toolpath::{
    model::{
        WRITTEN_RAD, fixed,
        gcode::{Angles, Distance, Motion, Turning},
        last_place,
    },
    write::gcode::Writer,
};

/// Decimals of written angles, degrees.
const ANGLE_DECIMALS: u8 = 4;

/// The words that turn rotary axes, and where they turn them.
pub(crate) struct Turned {
    pub words: Vec<(char, String)>,
    pub to: Angles,
}

impl Writer<'_> {
    /// What turns the axes to `goal` from where the words written so far have turned them; `[first, last]`: on which lines of those that
    /// `motion` becomes. Where a word of the line, `content`, turns there as it is, it keeps its text.
    pub(crate) fn turn_to(&self, motion: &Motion, content: &[u8], goal: &Angles, [first, last]: [bool; 2]) -> Turned {
        let mut turned = Turned { words: Vec::new(), to: self.stands[1] };
        for (axis, letter) in ['A', 'B', 'C'].into_iter().enumerate() {
            if !self.program.options.rotary.has(letter) {
                continue;
            }
            let word = motion.words.iter().find(|word| word.letter == letter);
            let own_distance = word.and_then(|word| word.distance).unwrap_or(motion.modal.distance);
            let distance = if first { own_distance } else { motion.modal.distance };
            let (here, goal) = (self.stands[1][axis], goal[axis]);
            let zero = if distance == Distance::Incremental { here } else { 0.0 };
            let own = word.filter(|_| (first || last) && own_distance == distance);
            let own = own.map(|word| (word, word.value + zero)).filter(|(_, at)| same(*at, goal));
            match own {
                Some((_, at)) if first || here == at => turned.to[axis] = at,
                Some((word, at)) => {
                    turned.to[axis] = at;
                    turned.words.push((letter, String::from_utf8_lossy(&content[word.number()]).into_owned()));
                }
                None if (first && word.is_some()) || !same(here, goal) => {
                    let number = fixed(goal - zero, ANGLE_DECIMALS);
                    turned.to[axis] = number.parse::<f64>().map_or(goal, |value| value + zero);
                    turned.words.push((letter, number));
                }
                None => {}
            }
        }
        turned
    }
}

/// How far from its angle an axis may stand along a written block whose angles are corrected, degrees: where X, Y and Z are not those of the
/// tip, the tip goes with it.
pub(crate) fn allowed_deg(turning: &Turning) -> f64 {
    if turning.of_tip { WRITTEN_RAD.to_degrees() } else { last_place(ANGLE_DECIMALS) }
}

/// Whether two angles are the same to half a unit of the last decimal.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= last_place(ANGLE_DECIMALS) * (0.5 + 1e-6)
}
