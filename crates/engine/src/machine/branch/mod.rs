//! Branches of six-axis arms with a spherical wrist: the eight joint configurations for one pose of the flange, in words.
//!
//! `arm` says which machines are such arms and on which branch they stand, `closed_form` finds the joints of all branches at a
//! pose, `postures` what drives and limits make of them, `change` what becomes of a path that would change branch.

mod arm;
mod asked;
mod change;
mod closed_form;
mod postures;

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

pub(super) use arm::Arm;
pub use arm::Clearance;
pub use asked::AskedPosture;
pub use change::PostureChange;
pub use postures::Posture;

use crate::input::error::{Error, Result};

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
    fn from_signs([shoulder, elbow, wrist]: [f64; 3]) -> Self {
        Self {
            shoulder: if shoulder >= 0.0 { Shoulder::Front } else { Shoulder::Back },
            elbow: if elbow >= 0.0 { Elbow::Up } else { Elbow::Down },
            wrist: if wrist >= 0.0 { Wrist::Noflip } else { Wrist::Flip },
        }
    }

    /// Signs of the branch factors, +1 or −1.
    fn signs(self) -> [f64; 3] {
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
            problem: format!("expected one of {}, got \"{word}\"", labels(Self::ALL)),
        })
    }
}

/// Words of several branches, separated by commas.
fn labels(branches: impl IntoIterator<Item = Branch>) -> String {
    branches.into_iter().map(|branch| branch.label()).collect::<Vec<_>>().join(", ")
}
