//! What a program says of the posture of an arm, and the configurations that have it.

use super::{Branch, Elbow, Shoulder, Wrist};
use crate::{
    machine::{
        Configuration, Machine,
        kinematics::{Closure, Command, wrap_into_travel},
    },
    spatial::Pose,
};

/// An angle this near to a border, rad, is on both sides of it: KUKA's control reads turns so, and a wrong side cannot mean another posture.
const BORDER: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// A branch factor this near to zero has both signs.
const STRAIGHT: f64 = 1e-4;
/// Full turns to each side that a hinge is taken.
const MOST_TURNS: i32 = 2;

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
    fn allows(&self, factors: Option<[f64; 3]>, angles: &[f64; 6]) -> bool {
        let sign = |is_positive: bool| if is_positive { 1.0 } else { -1.0 };
        let asked = [
            self.shoulder.map(|side| sign(side == Shoulder::Front)),
            self.elbow.map(|bend| sign(bend == Elbow::Up)),
            self.wrist.map(|bend| sign(bend == Wrist::Noflip)),
        ];
        let has_signs = factors.is_none_or(|factors| {
            asked.iter().zip(factors).all(|(sign, factor)| sign.is_none_or(|sign| sign * factor >= -STRAIGHT))
        });
        has_signs && (0..6).all(|joint| self.allows_angle(joint, angles[joint], BORDER))
    }

    /// Whether it allows drive `joint` of the arm to stand at `angle`, up to `beyond` its borders, rad.
    fn allows_angle(&self, joint: usize, angle: f64, beyond: f64) -> bool {
        let [low, high] = self.between[joint].map(f64::from);
        (low - beyond..=high + beyond).contains(&angle)
    }

    /// Whether it allows an arm on this branch, if it has one, with its drives at `angles`, rad.
    pub fn allows_posture(&self, branch: Option<Branch>, angles: &[f64; 6]) -> bool {
        self.allows(branch.map(Branch::signs), angles)
    }
}

impl Machine {
    /// Angles (rad) of the six hinges at the end of a serial chain, as a pendant shows them, at `at`; `None` for other machines.
    pub fn arm_angles(&self, at: &Configuration) -> Option<[f64; 6]> {
        at.drives.get(self.six_hinges()?..)?.try_into().ok()
    }

    /// Index of the first of the six hinges at the end of a serial chain; `None` for other machines.
    fn six_hinges(&self) -> Option<usize> {
        let first = self.drive_count().checked_sub(6).filter(|_| self.may_change_posture())?;
        self.full_turns().skip(first).all(|turn| turn.is_some()).then_some(first)
    }

    /// Whether the machine at `at` has the posture that `asked` says. One that is no chain with six hinges at its end has any.
    pub fn has_posture(&self, at: &Configuration, asked: &AskedPosture) -> bool {
        self.arm_angles(at).is_none_or(|angles| asked.allows(self.branch_factors(at), &angles))
    }

    /// Configuration with the six hinges at the end of a serial chain at `angles` (rad), all else as at home; `None` for other machines.
    pub fn at_angles(&self, angles: [f64; 6]) -> Option<Configuration> {
        let (first, mut drives) = (self.six_hinges()?, self.home.drives.clone());
        drives[first..].copy_from_slice(&angles);
        Some(self.serial_configuration(&drives))
    }

    /// The configuration within travel that meets `target` in the posture that `asked` says, nearest to `before` of those; `None` if there is none.
    pub fn posture_asked(&self, target: &Pose, asked: &AskedPosture, before: &Configuration) -> Option<Configuration> {
        let nearest_to = asked.near.map(|near| near.map(f64::from)).or_else(|| self.arm_angles(before))?;
        let met: Vec<Configuration> = match self.arm.is_some() {
            true => self.postures_at(target).into_iter().map(|posture| posture.at).collect(),
            false => {
                let start = self.at_angles(nearest_to)?;
                Closure::new(self).solve_from(start, &Command::Task(target)).into_iter().collect()
            }
        };
        let turned = met.into_iter().filter_map(|at| self.turned_as_asked(at, asked, &nearest_to));
        let distance = |at: &Configuration| {
            let angles = self.arm_angles(at).unwrap_or(nearest_to);
            angles.iter().zip(nearest_to).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
        };
        turned.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// The configuration with its hinges turned fully as `asked` and travel allow, nearest to the angles `near` (rad).
    fn turned_as_asked(&self, mut at: Configuration, asked: &AskedPosture, near: &[f64; 6]) -> Option<Configuration> {
        let first = self.six_hinges()?;
        for (joint, ((_, drive), turn)) in self.drives().zip(self.full_turns()).skip(first).enumerate() {
            let turn = turn?;
            let nearest = at.drives[first + joint] + ((near[joint] - at.drives[first + joint]) / turn).round() * turn;
            let is_allowed = |rho: &f64| {
                asked.allows_angle(joint, *rho, BORDER)
                    && drive.travel.is_none_or(|travel| wrap_into_travel(*rho, travel, None).is_some())
            };
            let turns = (-MOST_TURNS..=MOST_TURNS).map(|turns| nearest + f64::from(turns) * turn);
            // What lies beyond a border only if nothing else does.
            let away = |rho: &f64| (!asked.allows_angle(joint, *rho, 0.0), (rho - near[joint]).abs());
            at.drives[first + joint] = turns.filter(is_allowed).min_by(|a, b| {
                let (a, b) = (away(a), away(b));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            })?;
        }
        (self.has_posture(&at, asked) && self.check_limits(&at).is_ok()).then_some(at)
    }

    /// Branch of an arm whose drives stand at `drives` (mm, rad), `None` without spherical wrist, and the angles of its six hinges, rad; `None` for
    /// machines without these.
    pub fn branch_and_angles(&self, drives: &[f64]) -> Option<(Option<Branch>, [f64; 6])> {
        self.six_hinges()?;
        let at = self.serial_configuration(drives);
        Some((self.branch_of(&at), self.arm_angles(&at)?))
    }
}
