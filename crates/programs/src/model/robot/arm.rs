//! What programs of robots say of the posture of the arm at a target, in the numbers of each language.
//!
//! - RAPID (Technical reference manual, `confdata`): cf1, cf4, cf6 are the quadrants of axes 1, 4 and 6, counted from 0 (0° to 90°) up and from −1
//!   (−90° to 0°) down; cfx adds 4 where the wrist centre is behind axis 1, 2 where it is behind the lower arm, 1 where axis 5 is negative.
//! - KRL (KUKA System Software, Status and Turn): S has bit 0 where the wrist centre is behind axis 1, bit 1 where A3 is above the angle at which the
//!   elbow is straight, bit 2 where A5 is negative; T has bit i − 1 where axis i is negative. Bits of S above these do not say how the arm stands.
//! - FANUC (CONFIG of a position): N or F, the wrist, N where J5 is negative, as at J5 = −90° with the tool down; U or D, the elbow; T or B, the wrist
//!   centre before or behind J1; then the turns of J1, J4 and J6, of which 0 is from −180° to 180°.
//! - URScript (`get_inverse_kin(pose, qnear)`): of the postures at the pose the one nearest to qnear, rad.

use std::f32::consts::{FRAC_PI_2, PI};

use crate::model::robot::{Component, Language, Target};
use kinetostat_spatial::{AskedPosture, Branch, Elbow, Shoulder, Wrist};

/// What a program says of the posture of the arm at the end of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmData {
    /// The language whose numbers these are.
    pub language: Language,
    /// Numbers in the order of the language; `None` where it does not say one.
    pub numbers: [Option<f32>; 6],
    /// Whether the arm takes this posture whatever it had before: behind a motion from point to point.
    pub is_taken: bool,
    /// Angles of the joints, rad, to which the motion before leads, if it says these alone.
    pub from: Option<[f32; 6]>,
}

/// How an arm stands at a point of a path, as it is simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmPosture {
    /// The branch; `None` of arms without spherical wrist.
    pub branch: Option<Branch>,
    /// Angles of the drives as a pendant shows them, rad.
    pub angles: [f64; 6],
}

impl ArmPosture {
    /// Returns the posture in words: `front-up-flip, axes at 10.0°, …`.
    #[must_use]
    pub fn text(&self) -> String {
        let branch = self.branch.map_or_else(String::new, |branch| format!("{branch}, "));
        let angles = self.angles.map(|angle| format!("{:.1}°", angle.to_degrees()));
        format!("{branch}axes at {}", angles.join(", "))
    }
}

impl Language {
    /// Returns the axis, from 0, whose angle number `index` of its arm data counts, and the angle of one count, rad; `None` for others.
    fn counted(self, index: usize) -> Option<(usize, f32)> {
        const AXES: [usize; 3] = [0, 3, 5];
        match (self, index) {
            (Language::Rapid, 0..3) => Some((AXES[index], FRAC_PI_2)),
            (Language::Ls, 3..6) => Some((AXES[index - 3], 2.0 * PI)),
            _ => None,
        }
    }
}

/// Bits of S that say how the arm stands.
const STATUS_BITS: i32 = 0b111;

impl ArmData {
    /// Returns what `target` says of the posture; `None` if nothing.
    pub(crate) fn of_target(language: Language, target: &Target) -> Option<ArmData> {
        let numbers = std::array::from_fn(|index| target.number(Component::Arm(index)).map(|number| number as f32));
        numbers.iter().any(Option::is_some).then_some(ArmData { language, numbers, is_taken: false, from: None })
    }

    /// Returns what this says in terms of the machine.
    pub fn asked(&self) -> AskedPosture {
        let mut asked = AskedPosture { is_taken: self.is_taken, from: self.from, ..AskedPosture::default() };
        match (self.language, self.numbers) {
            (Language::UrScript, [Some(a), Some(b), Some(c), Some(d), Some(e), Some(f)]) => {
                asked.near = Some([a, b, c, d, e, f]);
            }
            _ => (0..6).for_each(|index| self.ask(index, &mut asked)),
        }
        asked
    }

    /// Adds to `asked` what number `index` says, if it is given.
    fn ask(&self, index: usize, asked: &mut AskedPosture) {
        let Some(number) = self.numbers[index] else { return };
        if let Some((axis, step)) = self.language.counted(index) {
            let low = if self.language == Language::Ls { number - 0.5 } else { number };
            asked.between[axis] = [low * step, (low + 1.0) * step];
            return;
        }
        let has = |bit: i32| number as i32 & bit != 0;
        let shoulder = |is_back: bool| Some(if is_back { Shoulder::Back } else { Shoulder::Front });
        let elbow = |is_down: bool| Some(if is_down { Elbow::Down } else { Elbow::Up });
        let wrist = |is_negative: bool| Some(if is_negative { Wrist::Flip } else { Wrist::Noflip });
        match (self.language, index) {
            (Language::Rapid, 3) => {
                (asked.shoulder, asked.elbow, asked.wrist) = (shoulder(has(4)), elbow(has(2)), wrist(has(1)));
            }
            (Language::Krl, 0) => {
                (asked.shoulder, asked.elbow, asked.wrist) = (shoulder(has(1)), elbow(!has(2)), wrist(has(4)));
            }
            (Language::Krl, 1) => {
                for (axis, between) in asked.between.iter_mut().enumerate() {
                    *between = if has(1 << axis) { [f32::NEG_INFINITY, 0.0] } else { [0.0, f32::INFINITY] };
                }
            }
            // As letters: F, D and B are 1.
            (Language::Ls, 0) => asked.wrist = wrist(number == 0.0),
            (Language::Ls, 1) => asked.elbow = elbow(number != 0.0),
            (Language::Ls, 2) => asked.shoulder = shoulder(number != 0.0),
            // Joints that are as near are those of the same posture.
            (Language::UrScript, _) => asked.between[index] = [number - FRAC_PI_2, number + FRAC_PI_2],
            _ => {}
        }
    }

    /// Returns the numbers of `language` for an arm that stands as in `posture`; `None` where it cannot say this of such an arm.
    #[must_use]
    pub fn of_posture(language: Language, posture: &ArmPosture) -> Option<ArmData> {
        let ArmPosture { branch, angles } = posture;
        let mut numbers = [None; 6];
        for (index, number) in numbers.iter_mut().enumerate() {
            *number = language.counted(index).map(|(axis, step)| {
                let counts = angles[axis] as f32 / step;
                if language == Language::Ls { counts.round() } else { counts.floor() }
            });
        }
        let bits = |back: i32, elbow: (Elbow, i32), negative: i32| -> Option<f32> {
            let branch = (*branch)?;
            let bit = |is_set: bool, bit: i32| if is_set { bit } else { 0 };
            let set = bit(branch.shoulder == Shoulder::Back, back) | bit(branch.elbow == elbow.0, elbow.1);
            Some((set | bit(branch.wrist == Wrist::Flip, negative)) as f32)
        };
        match language {
            Language::Rapid => numbers[3] = Some(bits(4, (Elbow::Down, 2), 1)?),
            Language::Krl => {
                let turn = (0..6).filter(|axis| angles[*axis] < 0.0).fold(0, |turn, axis| turn | 1 << axis);
                (numbers[0], numbers[1]) = (Some(bits(1, (Elbow::Up, 2), 4)?), Some(turn as f32));
            }
            Language::Ls => {
                let branch = (*branch)?;
                let letters =
                    [branch.wrist == Wrist::Noflip, branch.elbow == Elbow::Down, branch.shoulder == Shoulder::Back];
                (0..3).for_each(|index| numbers[index] = Some(f32::from(u8::from(letters[index]))));
            }
            Language::UrScript => numbers = angles.map(|angle| Some(angle as f32)),
            Language::Apt => return None,
        }
        Some(ArmData { language, numbers, is_taken: false, from: None })
    }

    /// Returns the numbers, with their texts, that have to change for an arm that stands as in `posture`: those that do not allow it.
    pub(crate) fn changes(&self, posture: &ArmPosture) -> Vec<(Component, String)> {
        let Some(own) = ArmData::of_posture(self.language, posture) else { return Vec::new() };
        let differs = |index: &usize| {
            let mut asked = AskedPosture::default();
            self.ask(*index, &mut asked);
            !asked.allows_posture(posture.branch, &posture.angles)
        };
        let text = |index: usize| Some((Component::Arm(index), self.number_text(index, own.numbers[index]?)));
        (0..6).filter(differs).filter_map(text).collect()
    }

    /// Returns the text of number `index` with the value `new`; what else a number says stays.
    fn number_text(&self, index: usize, new: f32) -> String {
        match (self.language, index) {
            (Language::Ls, 0..3) => ["NF", "UD", "TB"][index][new as usize..=new as usize].to_owned(),
            (Language::Krl, 0) => {
                let old = self.numbers[0].unwrap_or_default() as i32;
                (old & !STATUS_BITS | new as i32).to_string()
            }
            (Language::UrScript, _) => format!("{new:.6}"),
            _ => (new as i32).to_string(),
        }
    }

    /// Returns the data in words of the language, such as `confdata [0,-1,0,1]`.
    #[must_use]
    pub fn text(&self) -> String {
        let name = |index: usize| if self.language == Language::Krl { ["S ", "T "][index] } else { "" };
        let text =
            |index: usize| self.numbers[index].map(|number| name(index).to_owned() + &self.number_text(index, number));
        let texts: Vec<String> = (0..6).filter_map(text).collect();
        match self.language {
            Language::Rapid => format!("confdata [{}]", texts.join(",")),
            Language::Ls => format!("CONFIG '{}, {}'", texts[..3].join(" "), texts[3..].join(", ")),
            Language::UrScript => format!("qnear [{}]", texts.join(", ")),
            _ => texts.join(", "),
        }
    }
}
