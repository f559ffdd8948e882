//! Drives that control more than the task asks for: they stand as near to home as the task allows.
//!
//! With the unknowns of the closure equations split into drives d and the rest r (twist of P, passive joints), a step of
//! Newton's method solves `A r + B d = −e`. The rest is eliminated by the projector `P` onto what A does not reach; of the
//! drive motions left, `P B d = −P e`, the shortest is taken, revolute joints in mm at the machine's characteristic length. Motions in the null space
//! of `P B` are free: along them the drives go towards home.

use nalgebra::{DMatrix, DVector};

use super::{
    Configuration, Machine,
    kinematics::{CLOSURE_ROUNDING, Closure, Command},
};
use crate::spatial::{Pose, RankRevealing};

/// A pivot below this fraction of the largest is zero.
const RANK_TOLERANCE: f64 = 1e-9;
/// Steps towards home, and halvings of each.
const MAX_STEPS: usize = 60;
const HALVINGS: usize = 6;
/// What is left to go towards home where the drives count as nearest to it, as a fraction of the machine's characteristic length.
const NEAREST: f64 = 1e-12;

/// Equations are changed as they should be if this share is missing at most.
const MET: f64 = 1e-6;

/// A drive is moved to the end of its travel in steps of this share of the machine's characteristic length.
const LONGEST_HOLD: f64 = 0.1;

/// Decomposes `matrix`; `None` where its entries are not finite.
fn decompose(matrix: DMatrix<f64>) -> Option<RankRevealing> {
    matrix.iter().all(|entry| entry.is_finite()).then(|| RankRevealing::new(matrix, RANK_TOLERANCE))
}

/// Whether the equations change by `changed` as wanted, by `right`: in a singularity, some do not.
pub(super) fn is_met(changed: &DMatrix<f64>, right: &DMatrix<f64>) -> bool {
    (changed - right).amax() <= MET * right.amax()
}

impl Closure<'_> {
    /// Shortest drive motions that change the equations by the columns of `right`, the rest of the unknowns, and the length of the free part.
    /// `free`: a motion of the drives whose part in the null space is added. `None` where the equations are not finite or cannot be solved.
    fn min_norm(&self, right: &DMatrix<f64>, free: Option<&DVector<f64>>) -> Option<(DMatrix<f64>, DMatrix<f64>, f64)> {
        let drive_count = self.machine.drive_count();
        let rest = self.jacobian.clone().remove_columns(6, drive_count);
        let mut by_drives = self.jacobian.columns(6, drive_count).into_owned();
        for &(drive, _) in &self.locked {
            by_drives.column_mut(drive).fill(0.0);
        }
        let rest = decompose(rest)?;
        let reached = rest.column_space();
        let project = |m: &DMatrix<f64>| m - &reached * reached.tr_mul(m);
        let drives = decompose(project(&by_drives))?;
        let mut motion = drives.solve(&project(right))?;
        let mut free_length = 0.0;
        if let Some(free) = free {
            let mut free = free.clone();
            for &(drive, _) in &self.locked {
                free[drive] = 0.0;
            }
            let needed = drives.row_space();
            let free = &free - &needed * needed.tr_mul(&free);
            free_length = free.norm();
            motion += &free;
        }
        let others = rest.solve(&(right - by_drives * &motion))?;
        Some((motion, others, free_length))
    }

    /// Joins drive motions and the rest of the unknowns in the order of the equations.
    fn join_unknowns(&self, drives: &DMatrix<f64>, rest: &DMatrix<f64>) -> DVector<f64> {
        let drive_count = drives.nrows();
        DVector::from_fn(drive_count + rest.nrows(), |i, _| match i.checked_sub(6) {
            None => rest[(i, 0)],
            Some(d) if d < drive_count => drives[(d, 0)],
            Some(_) => rest[(i - drive_count, 0)],
        })
    }

    /// Newton step of the present linearisation with the shortest motion of the drives; `None` where it cannot be solved.
    pub(super) fn min_norm_step(&self, at: &Configuration) -> Option<DVector<f64>> {
        self.step_with_free(at, None).map(|(step, _)| step)
    }

    /// Newton step with the shortest motion of the drives and the part of `free` in their null space; also the length of that part. `None` where it
    /// cannot be solved.
    fn step_with_free(&self, at: &Configuration, free: Option<&DVector<f64>>) -> Option<(DVector<f64>, f64)> {
        let mut right = DMatrix::from_column_slice(self.residual.len(), 1, (-&self.residual).as_slice());
        let to_lock: Vec<(usize, f64)> = self.locked.iter().map(|&(d, value)| (d, self.gap_mm(at, d, value))).collect();
        for &(drive, way) in &to_lock {
            right -= self.jacobian.column(6 + drive) * way;
        }
        let (mut drives, rest, free_length) = self.min_norm(&right, free)?;
        for &(drive, way) in &to_lock {
            drives[(drive, 0)] = way;
        }
        Some((self.join_unknowns(&drives, &rest), free_length))
    }

    /// Shortest motions of the drives, mm, that change the equations by the columns of `right`; `None` where nothing does.
    pub(super) fn min_norm_motions(&self, right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let (drives, rest, _) = self.min_norm(right, None)?;
        let drive_count = drives.nrows();
        let changed = self.jacobian.columns(6, drive_count) * &drives
            + self.jacobian.clone().remove_columns(6, drive_count) * rest;
        is_met(&changed, right).then_some(drives)
    }

    /// Displacement that drive `drive` needs from its position in `at` to `value` (mm, rad), as a length in mm.
    fn gap_mm(&self, at: &Configuration, drive: usize, value: f64) -> f64 {
        let unit = self.machine.drives().nth(drive).map_or(1.0, |(_, d)| self.mm_per_unit(d.motion));
        (value - at.drives[drive]) * unit
    }

    /// Displacements of all drives from `at` to home, as lengths in mm.
    fn vector_to_home(&self, at: &Configuration) -> DVector<f64> {
        let home = &self.machine.home.drives;
        DVector::from_fn(home.len(), |d, _| self.gap_mm(at, d, home[d]))
    }

    /// Moves `at`, which meets the task, along the free motions towards home until nothing is gained.
    fn move_towards_home(&mut self, mut at: Configuration, target: &Pose) -> Configuration {
        let command = Command::Task(target);
        let scale = self.machine.characteristic_length;
        let mut last = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            self.linearise(&at, &command);
            let vector_to_home = self.vector_to_home(&at);
            let Some((_, remaining)) = self.step_with_free(&at, Some(&vector_to_home)) else { return at };
            if remaining <= NEAREST * scale {
                return at;
            }
            let (before, mut share) = (vector_to_home.norm_squared(), 1.0);
            let next = (0..HALVINGS).find_map(|_| {
                self.linearise(&at, &command);
                let (step, _) = self.step_with_free(&at, Some(&(&vector_to_home * share)))?;
                let mut moved = at.clone();
                self.advance(&mut moved, &step);
                let met = self.solve_from(moved, &command);
                share *= 0.5;
                // Near the end the sums of squares differ by rounding only, and what is left to go decides.
                met.filter(|met| remaining < 1e-6 * scale || self.vector_to_home(met).norm_squared() < before)
            });
            match next {
                Some(next) if remaining < last || remaining > 1e-6 * scale => at = next,
                _ => return at,
            }
            last = remaining;
        }
        at
    }

    /// Locks a drive and moves it from `at` to its locked value with the task met; `None` where that fails.
    fn lock_drive(&mut self, at: &Configuration, locked: (usize, f64), target: &Pose) -> Option<Configuration> {
        let (drive, value) = locked;
        let (from, command) = (at.drives[drive], Command::Task(target));
        let longest = LONGEST_HOLD * self.machine.characteristic_length;
        let steps = (self.gap_mm(at, drive, value).abs() / longest).ceil().clamp(1.0, 100.0);
        let mut at = at.clone();
        self.locked.push(locked);
        for step in 1..=steps as usize {
            let share = step as f64 / steps;
            if let Some(last) = self.locked.last_mut() {
                last.1 = if share < 1.0 { from + (value - from) * share } else { value };
            }
            self.linearise(&at, &command);
            let motion = self.min_norm_step(&at)?;
            self.advance(&mut at, &motion);
            at = self.solve_from(at, &command)?;
        }
        Some(at)
    }

    /// Configuration that meets `command`, searched from `at` on whatever branch; `None` if none is found.
    pub(super) fn solve_from(&mut self, mut at: Configuration, command: &Command<'_>) -> Option<Configuration> {
        for _ in 0..3 {
            at = self.approach(&at, command);
            self.linearise(&at, command);
            if self.residual.amax() < CLOSURE_ROUNDING * self.machine.characteristic_length {
                return Some(at);
            }
        }
        None
    }
}

impl Machine {
    /// The configuration that meets `target` with the drives nearest to home and, as far as their freedom allows, within
    /// their travel; `at` meets it, and lies where the search begins.
    pub(super) fn nearest_to_home(&self, at: Configuration, target: &Pose) -> Configuration {
        let mut closure = Closure::new(self);
        let mut at = closure.move_towards_home(at, target);
        for &(drive, value) in &self.locked {
            at.drives[drive] = value;
        }
        for _ in self.locked.len()..self.redundancy {
            let beyond = self.drives().zip(&at.drives).enumerate().find_map(|(d, ((_, drive), rho))| {
                let (low, high) = drive.travel?;
                (!(low..=high).contains(rho)).then(|| (d, rho.clamp(low, high)))
            });
            let Some(locked) = beyond else { break };
            let Some(met) = closure.lock_drive(&at, locked, target) else { break };
            at = closure.move_towards_home(met, target);
            for &(drive, value) in &closure.locked {
                at.drives[drive] = value;
            }
        }
        at
    }

    /// Number of independent motions of the drives at home beyond the number of controlled coordinates.
    pub(super) fn redundancy_at_home(&self) -> usize {
        let mobility = self.mobility(&self.home);
        mobility.mechanism.saturating_sub(mobility.uncontrolled).saturating_sub(self.controls.len())
    }

    /// Distance of the drives from home to `at`: prismatic joints in mm, revolute joints in mm at the machine's characteristic length.
    pub(super) fn distance_from_home(&self, at: &Configuration) -> f64 {
        Closure::new(self).vector_to_home(at).norm()
    }
}
