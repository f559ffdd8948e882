//! The configurations of a machine that have the posture that a program asks for.

use crate::{
    machine::{
        Configuration, Machine,
        kinematics::{Closure, Command, wrap_into_travel},
    },
    spatial::{ARM_BORDER, AskedPosture, Branch, Pose},
};

/// Full turns to each side that a revolute joint is taken.
const MAX_TURNS: i32 = 2;

impl Machine {
    /// Angles (rad) of the six revolute joints at the end of a serial chain, as a pendant shows them, at `at`; `None` for other machines.
    pub fn arm_angles(&self, at: &Configuration) -> Option<[f64; 6]> {
        at.drives.get(self.six_revolute()?..)?.try_into().ok()
    }

    /// Index of the first of the six revolute joints at the end of a serial chain; `None` for other machines.
    fn six_revolute(&self) -> Option<usize> {
        let first = self.drive_count().checked_sub(6).filter(|_| self.may_change_posture())?;
        self.full_turns().skip(first).all(|turn| turn.is_some()).then_some(first)
    }

    /// Whether the machine at `at` has the posture that `asked` says. One that is no chain with six revolute joints at its end has any.
    pub fn has_posture(&self, at: &Configuration, asked: &AskedPosture) -> bool {
        self.arm_angles(at).is_none_or(|angles| asked.allows(self.branch_factors(at), &angles))
    }

    /// Configuration with the six revolute joints at the end of a serial chain at `angles` (rad), all else as at home; `None` for other machines.
    pub fn at_angles(&self, angles: [f64; 6]) -> Option<Configuration> {
        let (first, mut drives) = (self.six_revolute()?, self.home.drives.clone());
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

    /// The configuration with its revolute joints turned fully as `asked` and travel allow, nearest to the angles `near` (rad); `None` if they allow
    /// none, and for machines without six revolute joints at the end of a serial chain.
    fn turned_as_asked(&self, mut at: Configuration, asked: &AskedPosture, near: &[f64; 6]) -> Option<Configuration> {
        let first = self.six_revolute()?;
        for (joint, ((_, drive), turn)) in self.drives().zip(self.full_turns()).skip(first).enumerate() {
            let turn = turn?;
            let nearest = at.drives[first + joint] + ((near[joint] - at.drives[first + joint]) / turn).round() * turn;
            let is_allowed = |rho: &f64| {
                asked.allows_angle(joint, *rho, ARM_BORDER)
                    && drive.travel.is_none_or(|travel| wrap_into_travel(*rho, travel, None).is_some())
            };
            let turns = (-MAX_TURNS..=MAX_TURNS).map(|turns| nearest + f64::from(turns) * turn);
            // What lies beyond a border only if nothing else does.
            let away = |rho: &f64| (!asked.allows_angle(joint, *rho, 0.0), (rho - near[joint]).abs());
            at.drives[first + joint] = turns.filter(is_allowed).min_by(|a, b| {
                let (a, b) = (away(a), away(b));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            })?;
        }
        (self.has_posture(&at, asked) && self.check_limits(&at).is_ok()).then_some(at)
    }

    /// Branch of an arm whose drives stand at `drives` (mm, rad), `None` without spherical wrist, and the angles of its six revolute joints, rad; `None` for
    /// machines without these.
    pub fn branch_and_angles(&self, drives: &[f64]) -> Option<(Option<Branch>, [f64; 6])> {
        self.six_revolute()?;
        let at = self.serial_configuration(drives);
        Some((self.branch_of(&at), self.arm_angles(&at)?))
    }
}
