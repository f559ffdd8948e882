//! Six-axis arms in words: the branch on which one stands, what a program asks of it, and how many external axes go with it.

use std::{fmt, str::FromStr};

use kinetostat_input::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// The most external axes that a path commands.
pub const MAX_EXTERNAL_AXES: usize = 6;

/// An angle this near to a border, rad, is on both sides of it: KUKA's control reads turns so, and a wrong side cannot mean another posture.
pub const ARM_BORDER: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// A branch factor this near to zero has both signs.
const STRAIGHT: f64 = 1e-4;

/// On which side of axis 1 the wrist centre is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shoulder {
    /// On the side to which the shoulder (axis 2) is set off from axis 1; where it is not, on the side of home.
    Front,
    /// Behind axis 1: the arm reaches over its shoulder.
    Back,
}

/// How the elbow (axis 3) bends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Elbow {
    /// As where the arm reaches to the front, its elbow above (along axis 1, away from the base) the line from shoulder to wrist centre.
    Up,
    /// The other way.
    Down,
}

/// How the wrist (axis 5) bends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wrist {
    /// From where axis 6 leads on along axis 4, by up to half a turn in the positive sense of the fifth drive, as a pendant shows it.
    Noflip,
    /// In its negative sense.
    Flip,
}

/// A branch of the inverse kinematics of a six-axis arm, a function of its joints 2, 3 and 5; between two branches is always a singularity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Branch {
    /// Side of the wrist centre.
    pub shoulder: Shoulder,
    /// Bend of axis 3.
    pub elbow: Elbow,
    /// Bend of axis 5.
    pub wrist: Wrist,
}

impl Branch {
    /// All eight.
    pub const ALL: [Branch; 8] = {
        const fn branch(number: usize) -> Branch {
            Branch {
                shoulder: if number & 4 == 0 { Shoulder::Front } else { Shoulder::Back },
                elbow: if number & 2 == 0 { Elbow::Up } else { Elbow::Down },
                wrist: if number & 1 == 0 { Wrist::Noflip } else { Wrist::Flip },
            }
        }
        [branch(0), branch(1), branch(2), branch(3), branch(4), branch(5), branch(6), branch(7)]
    };

    /// Words of the branch, such as `front-up-noflip`.
    pub const fn label(&self) -> &'static str {
        match (self.shoulder, self.elbow, self.wrist) {
            (Shoulder::Front, Elbow::Up, Wrist::Noflip) => "front-up-noflip",
            (Shoulder::Front, Elbow::Up, Wrist::Flip) => "front-up-flip",
            (Shoulder::Front, Elbow::Down, Wrist::Noflip) => "front-down-noflip",
            (Shoulder::Front, Elbow::Down, Wrist::Flip) => "front-down-flip",
            (Shoulder::Back, Elbow::Up, Wrist::Noflip) => "back-up-noflip",
            (Shoulder::Back, Elbow::Up, Wrist::Flip) => "back-up-flip",
            (Shoulder::Back, Elbow::Down, Wrist::Noflip) => "back-down-noflip",
            (Shoulder::Back, Elbow::Down, Wrist::Flip) => "back-down-flip",
        }
    }

    /// The branch with these signs of the wrist centre's distance ahead of axis 1 and of the bends of elbow and wrist.
    pub fn from_signs([shoulder, elbow, wrist]: [f64; 3]) -> Self {
        Self {
            shoulder: if shoulder >= 0.0 { Shoulder::Front } else { Shoulder::Back },
            elbow: if elbow >= 0.0 { Elbow::Up } else { Elbow::Down },
            wrist: if wrist >= 0.0 { Wrist::Noflip } else { Wrist::Flip },
        }
    }

    /// Signs of the branch factors, +1 or −1.
    pub fn signs(self) -> [f64; 3] {
        let sign = |is_positive: bool| if is_positive { 1.0 } else { -1.0 };
        [sign(self.shoulder == Shoulder::Front), sign(self.elbow == Elbow::Up), sign(self.wrist == Wrist::Noflip)]
    }
}

impl fmt::Display for Branch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.label())
    }
}

impl FromStr for Branch {
    type Err = Error;

    /// Parses the words of a branch, such as `front-up-noflip`; the error lists all.
    fn from_str(word: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|branch| branch.label() == word).ok_or_else(|| Error::Argument {
            argument: "branch".into(),
            problem: format!("expected one of {}, got \"{word}\"", branch_labels(Self::ALL)),
        })
    }
}

/// Words of several branches, separated by commas.
pub fn branch_labels(branches: impl IntoIterator<Item = Branch>) -> String {
    branches.into_iter().map(|branch| branch.label()).collect::<Vec<_>>().join(", ")
}

/// What a program says of the posture of a six-axis arm at a point; all that is not said is free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AskedPosture {
    /// Side of the wrist centre.
    pub shoulder: Option<Shoulder>,
    /// Bend of axis 3.
    pub elbow: Option<Elbow>,
    /// Bend of axis 5.
    pub wrist: Option<Wrist>,
    /// Between which angles each of the six drives stands, as a pendant shows it, rad.
    pub between: [[f32; 2]; 6],
    /// The posture is the one nearest to these angles, rad.
    pub near: Option<[f32; 6]>,
    /// Whether the arm takes this posture whatever it had before; otherwise it is to have it.
    pub is_taken: bool,
    /// Angles of the drives from which the motion to this point begins, rad.
    pub from: Option<[f32; 6]>,
}

impl Default for AskedPosture {
    /// Asks for nothing.
    fn default() -> Self {
        Self {
            shoulder: None,
            elbow: None,
            wrist: None,
            between: [[f32::NEG_INFINITY, f32::INFINITY]; 6],
            near: None,
            is_taken: false,
            from: None,
        }
    }
}

impl AskedPosture {
    /// Whether it says anything of the posture at the point itself.
    pub fn says_something(&self) -> bool {
        *self != Self { is_taken: self.is_taken, from: self.from, ..Self::default() }
    }

    /// Whether the arm takes the posture that it says, or the one nearest to where the motion begins, whatever it had before.
    pub fn is_chosen(&self) -> bool {
        self.is_taken && (self.from.is_some() || self.says_something())
    }

    /// Whether it allows a posture with these branch factors and angles of the drives, rad.
    pub fn allows(&self, factors: Option<[f64; 3]>, angles: &[f64; 6]) -> bool {
        let sign = |is_positive: bool| if is_positive { 1.0 } else { -1.0 };
        let asked = [
            self.shoulder.map(|side| sign(side == Shoulder::Front)),
            self.elbow.map(|bend| sign(bend == Elbow::Up)),
            self.wrist.map(|bend| sign(bend == Wrist::Noflip)),
        ];
        let has_signs = factors.is_none_or(|factors| {
            asked.iter().zip(factors).all(|(sign, factor)| sign.is_none_or(|sign| sign * factor >= -STRAIGHT))
        });
        has_signs && (0..6).all(|joint| self.allows_angle(joint, angles[joint], ARM_BORDER))
    }

    /// Whether it allows drive `joint` of the arm to stand at `angle`, up to `beyond` its borders, rad.
    pub fn allows_angle(&self, joint: usize, angle: f64, beyond: f64) -> bool {
        let [low, high] = self.between[joint].map(f64::from);
        (low - beyond..=high + beyond).contains(&angle)
    }

    /// Whether it allows an arm on this branch, if it has one, with its drives at `angles`, rad.
    pub fn allows_posture(&self, branch: Option<Branch>, angles: &[f64; 6]) -> bool {
        self.allows(branch.map(Branch::signs), angles)
    }
}
