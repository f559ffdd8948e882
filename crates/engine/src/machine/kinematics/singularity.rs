//! Singularities between two near configurations, by the sign of a determinant.
//!
//! The linearised problem has the columns twist of P, drives and passive joints. Passive joints move the rows of their own
//! chain alone, so they are eliminated chain by chain; what is left has as many columns as P and the drives have coordinates.

use nalgebra::{DMatrix, DVector};

use super::{
    Configuration,
    closure::{Closure, Command},
    equations::task_entry,
};
use crate::{
    lanes::{Frame, dot, subtract},
    machine::Machine,
    spatial::larger,
};

/// A pivot below this fraction of the largest is zero.
const RANK_TOLERANCE: f64 = 1e-9;

/// Singularities that a way may not pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::machine) enum Barriers {
    /// Those in which the drives do not hold the platform, and those in which they cannot move it in some way.
    All,
    /// Only the former: drives that are commanded pass the others.
    OfDrives,
}

impl Machine {
    /// Whether a singularity lies between two near configurations, whichever drives or task coordinates are commanded.
    pub fn passes_singularity(&self, from: &Configuration, to: &Configuration) -> bool {
        let mut closure = Closure::new(self);
        closure.linearise(from, &Command::Task(&from.pose));
        closure.start_jacobian.clone_from(&closure.jacobian);
        closure.linearise(to, &Command::Task(&to.pose));
        closure.has_passed_singularity(from, to, Barriers::All)
    }
}

impl Closure<'_> {
    /// Whether a singularity lies between two near configurations: the determinant of the linearised problem changes sign,
    /// with the drives commanded (parallel singularity) or with the task commanded (the end of a chain's reach).
    ///
    /// The problem has more equations than unknowns where the machine is over-constrained; its determinant is taken on the column space at `from`.
    /// A machine with idle joints is always singular, and is not judged; one that is singular at `from` and not at home does not lead on.
    ///
    /// To be asked behind a search that began at `from` and found `to`, which has linearised the problem at both.
    pub(super) fn has_passed_singularity(
        &mut self,
        from: &Configuration,
        to: &Configuration,
        barriers: Barriers,
    ) -> bool {
        let (by_drives, by_task) = judged_commands(self.machine, barriers);
        if !by_drives && !by_task {
            return false;
        }
        let (closures, drives) = (6 * self.machine.closure_count(), self.machine.drive_count());
        let Some(both) = ReducedEquations::new(self.machine, [&self.start_jacobian, &self.jacobian], closures) else {
            return self.has_passed_unreduced(from, to, by_drives, by_task);
        };
        let changes = |commanded: usize, row: &dyn Fn(usize, usize, usize) -> f64| both.sign_change(commanded, row);
        let driven = by_drives.then(|| changes(drives, &|_, i, j| if j == 6 + i { 1.0 } else { 0.0 }));
        let tasked = by_task.then(|| {
            let platforms = [Frame::splat(&from.pose), Frame::splat(&to.pose)];
            let controls = &self.machine.controls;
            changes(controls.len(), &|end, i, j| task_entry(controls[i], &platforms[end], j))
        });
        let mut passes = |change: Option<SignChange>, command: &Command<'_>| match change {
            None | Some(SignChange::None) => false,
            Some(SignChange::OfSign) => true,
            Some(SignChange::FromSingular) => !self.is_singular_at_home(command),
        };
        passes(driven, &Command::Drives(&from.drives)) || passes(tasked, &Command::Task(&from.pose))
    }

    /// As [`Self::has_passed_singularity`], by all equations: for chains whose passive joints are singular at both ends (stretched).
    fn has_passed_unreduced(
        &mut self,
        from: &Configuration,
        to: &Configuration,
        by_drives: bool,
        by_task: bool,
    ) -> bool {
        let driven = (Command::Drives(&from.drives), Command::Drives(&to.drives));
        let tasked = (Command::Task(&from.pose), Command::Task(&to.pose));
        [(by_drives, driven), (by_task, tasked)].iter().filter(|(is_asked, _)| *is_asked).any(|(_, (before, after))| {
            self.linearise(from, before);
            let count = self.jacobian.ncols();
            let mut both = self.jacobian.clone().resize_horizontally(2 * count, 0.0);
            self.linearise(to, after);
            both.columns_mut(count, count).copy_from(&self.jacobian);
            let pivots = make_triangular(&mut both, count);
            if is_singular(pivots.iter()) {
                return !self.is_singular_at_home(before);
            }
            let there = both.view((0, count), (count, count)).into_owned().determinant();
            there * sign_product(pivots.iter()) < 0.0
        })
    }

    /// Whether the linearised problem is singular at home for commands of this kind.
    fn is_singular_at_home(&mut self, command: &Command<'_>) -> bool {
        let home = &self.machine.home;
        match command {
            Command::Drives(_) => self.linearise(home, &Command::Drives(&home.drives)),
            Command::Task(_) => self.linearise(home, &Command::Task(&home.pose)),
        }
        self.jacobian.nrows() < self.jacobian.ncols()
            || is_singular(self.jacobian.clone().qr().unpack_r().diagonal().iter())
    }
}

/// Whether to judge with the drives commanded and with the task commanded: not where joints are idle, or unknowns are more than equations.
pub(super) fn judged_commands(machine: &Machine, barriers: Barriers) -> (bool, bool) {
    let mut chains = machine.chains.iter();
    let is_idle = chains.any(|chain| chain.passive.len() > 6 * (1 + chain.route.loop_count()));
    let passive: usize = machine.chains.iter().map(|chain| chain.passive.len()).sum();
    let unknowns = 6 + machine.drive_count() + passive;
    let is_judged = |commanded: usize| !is_idle && 6 * machine.closure_count() + commanded >= unknowns;
    (is_judged(machine.drive_count()), barriers == Barriers::All && is_judged(machine.controls.len()))
}

/// Change of the sign of a determinant between two configurations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SignChange {
    None,
    OfSign,
    /// The determinant is zero at the first configuration.
    FromSingular,
}

/// The closure equations at both ends of a step, without passive joints.
struct ReducedEquations {
    /// Columns: twist of P and drives at the first end, then at the second.
    rows: DMatrix<f64>,
    /// Pivots of the passive joints at the first end.
    pivots: Vec<f64>,
    /// Sign of the determinants of the passive joints at both ends.
    sign: f64,
}

impl ReducedEquations {
    /// Eliminates the passive joints from the first `closures` rows of the linearised problems at both `ends`; `None` where those at the second end
    /// cannot be eliminated by the equations that do so at the first.
    fn new(machine: &Machine, ends: [&DMatrix<f64>; 2], closures: usize) -> Option<Self> {
        let others = 6 + machine.drive_count();
        let passive = ends[0].ncols() - others;
        let mut reduced = Self {
            rows: DMatrix::zeros(closures - passive, 2 * others),
            pivots: Vec::with_capacity(passive),
            sign: 1.0,
        };
        let (mut row, mut joint, mut own_row) = (0, others, 0);
        for chain in &machine.chains {
            let (equations, joints) = (6 * (1 + chain.route.loop_count()), chain.passive.len());
            // Joints at both ends, then the others at both ends.
            let mut block = DMatrix::zeros(equations, 2 * (joints + others));
            for (end, matrix) in ends.iter().enumerate() {
                let (joint_column, other_column) = (end * joints, 2 * joints + end * others);
                block.columns_mut(joint_column, joints).copy_from(&matrix.view((row, joint), (equations, joints)));
                block.columns_mut(other_column, others).copy_from(&matrix.view((row, 0), (equations, others)));
            }
            let pivots = make_triangular(&mut block, joints);
            reduced.sign *= sign_product(pivots.iter()) * eliminate_joints(&mut block, joints, others)?;
            reduced.pivots.extend(pivots.iter());
            let rest = equations - joints;
            reduced.rows.rows_mut(own_row, rest).copy_from(&block.view((joints, 2 * joints), (rest, 2 * others)));
            (row, joint, own_row) = (row + equations, joint + joints, own_row + rest);
        }
        Some(reduced)
    }

    /// Change of the sign of the determinant with `commanded` rows more, whose `entry` is given by end (0, 1), row and column.
    fn sign_change(&self, commanded: usize, entry: &dyn Fn(usize, usize, usize) -> f64) -> SignChange {
        let (closures, others) = (self.rows.nrows(), self.rows.ncols() / 2);
        let mut matrix = DMatrix::zeros(closures + commanded, 2 * others);
        matrix.rows_mut(0, closures).copy_from(&self.rows);
        for end in 0..2 {
            for j in 0..others {
                for i in 0..commanded {
                    matrix[(closures + i, end * others + j)] = entry(end, i, j);
                }
            }
        }
        let pivots = make_triangular(&mut matrix, others);
        if is_singular(self.pivots.iter().chain(pivots.iter())) {
            return SignChange::FromSingular;
        }
        let there = matrix.view((0, others), (others, others)).into_owned().determinant();
        match self.sign * sign_product(pivots.iter()) * there {
            product if product < 0.0 => SignChange::OfSign,
            product if product.is_nan() => SignChange::FromSingular,
            _ => SignChange::None,
        }
    }
}

/// Eliminates the joints at the second end (columns `joints` to `2 joints`) with the first `joints` rows as pivots, in place. Returns the sign
/// of the pivots' determinant; `None` where it is zero. `others`: columns at each end behind those of the joints.
fn eliminate_joints(block: &mut DMatrix<f64>, joints: usize, others: usize) -> Option<f64> {
    let rows = block.nrows();
    let largest = block.view((0, joints), (joints, joints)).amax();
    let mut sign = 1.0;
    for k in 0..joints {
        let column = joints + k;
        let size = |row: &usize| block[(*row, column)].abs();
        let pivot_row = (k..joints).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        if pivot_row != k {
            block.swap_rows(k, pivot_row);
            sign = -sign;
        }
        let pivot = block[(k, column)];
        if pivot.is_nan() || pivot.abs() <= RANK_TOLERANCE * largest {
            return None;
        }
        sign *= pivot.signum();
        let (first, later) = block.as_mut_slice().split_at_mut((column + 1) * rows);
        let factors = &mut first[column * rows + k + 1..];
        factors.iter_mut().for_each(|factor| *factor /= pivot);
        let (joint_part, other) = later.split_at_mut((joints - k - 1) * rows);
        for column in joint_part.chunks_exact_mut(rows).chain(other.chunks_exact_mut(rows).skip(others)) {
            let share = column[k];
            subtract(&mut column[k + 1..], share, factors);
        }
    }
    Some(sign)
}

/// Makes the first `count` columns upper triangular by reflections of all columns; returns their diagonal. Entries on and below it hold no result.
fn make_triangular(matrix: &mut DMatrix<f64>, count: usize) -> DVector<f64> {
    let rows = matrix.nrows();
    let mut pivots = DVector::zeros(count);
    for j in 0..count {
        let (first, later) = matrix.as_mut_slice().split_at_mut((j + 1) * rows);
        let mirror = &mut first[j * rows + j..];
        let (head, norm) = (mirror[0], dot(mirror, mirror).sqrt());
        if norm == 0.0 {
            continue;
        }
        let diagonal = if head > 0.0 { -norm } else { norm };
        mirror[0] = head - diagonal;
        let weight = 1.0 / (norm * (norm + head.abs()));
        for column in later.chunks_exact_mut(rows) {
            let along = weight * dot(mirror, &column[j..]);
            subtract(&mut column[j..], along, mirror);
        }
        pivots[j] = diagonal;
    }
    pivots
}

/// Sign of the product of `pivots`, +1 or −1.
fn sign_product<'p>(pivots: impl Iterator<Item = &'p f64>) -> f64 {
    pivots.map(|pivot| pivot.signum()).product()
}

/// Whether one of the pivots is zero, compared with the largest, or one is not a number.
fn is_singular<'p>(pivots: impl Iterator<Item = &'p f64>) -> bool {
    let (least, largest) = pivots
        .fold((f64::INFINITY, 0.0), |(least, most), pivot| (f64::min(least, pivot.abs()), larger(most, pivot.abs())));
    largest.is_nan() || least < RANK_TOLERANCE * largest
}
