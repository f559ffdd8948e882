//! Balance of the platform where chains transmit wrenches rigidly.
//!
//! Chains of rigid links come with a slack spring in each wrench f that they transmit ([`super::transmission`]). The
//! platform's unknowns are its twist and the motions y that take these springs' deflections back:
//!
//! ```text
//! K dt +  W y = F             K: tangent with slack springs, W: wrench per slack
//! E y  −  Wᵀ dt = y₀          E: what is left of each slack with the platform held
//! ```
//!
//! `S = E + Wᵀ K⁻¹ W` is positive semidefinite where the machine is stable. Where chains block the same motion twice
//! (over-constraint), a row of it depends on those before: what one of them carries is not determined, and does not change.

use super::{
    chain_system::ChainSystem,
    platform::{self, Square, dot},
};
use crate::lanes::{Real, clear, pairs, solve, subtract};

/// A pivot of S above this fraction of `1/s` is regular.
const REGULAR: f64 = 1e-7;
/// A pivot of S below this fraction of `1/s` is zero.
const DEPENDENT: f64 = 1e-10;

/// A direction of the platform that yields less than this fraction of a slack is nearly rigid: no measure of how soft others are.
const NEARLY_RIGID: f64 = 1e-7;

/// The slacks of all chains, and the platform's response to them.
#[derive(Debug, Clone)]
pub(super) struct RigidDirections<R = f64> {
    /// Stiffness 1/s of the slack springs, N/mm.
    stiffness: f64,
    /// Columns of W, and of K⁻¹ W.
    wrenches: Vec<[R; 6]>,
    responses: Vec<[R; 6]>,
    /// S by rows, factorised in place; inverse pivots.
    factor: Vec<R>,
    inverse: Vec<R>,
    /// Slacks of the last step.
    slacks: Vec<R>,
    /// Slacks of each twist of the last step to a task.
    columns: Vec<R>,
}

impl<R: Real> RigidDirections<R> {
    /// Storage for the slacks of `chains`.
    pub fn new(chains: &[ChainSystem<R>]) -> Self {
        let count = chains.iter().map(ChainSystem::slack_count).sum();
        let drives: usize = chains.iter().map(ChainSystem::drive_count).sum();
        Self {
            stiffness: chains.iter().find_map(ChainSystem::slack_stiffness).unwrap_or(1.0),
            wrenches: vec![[R::zero(); 6]; count],
            responses: vec![[R::zero(); 6]; count],
            factor: vec![R::zero(); count * count],
            inverse: vec![R::zero(); count],
            slacks: vec![R::zero(); count],
            columns: vec![R::zero(); count * (1 + drives)],
        }
    }

    /// Number of slacks.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.wrenches.len()
    }

    /// Compliance s of the slack springs, mm/N.
    pub fn slack_compliance(&self) -> f64 {
        1.0 / self.stiffness
    }

    /// Compliance of the platform below which a direction is nearly rigid, mm/N; 0 where no chain has slack springs.
    pub fn nearly_rigid_compliance(&self) -> f64 {
        if self.is_empty() { 0.0 } else { NEARLY_RIGID / self.stiffness }
    }

    /// Whether no chain has slack springs.
    pub fn is_empty(&self) -> bool {
        self.wrenches.is_empty()
    }

    /// Factorises S of condensed chains with their `tangent`. Returns the lanes in which the platform, made softer by slack springs, is
    /// clearly stable and S regular but for over-constraint. `scale` in mm makes rotations comparable.
    #[inline(always)]
    pub fn factorise(&mut self, chains: &[ChainSystem<R>], tangent: &Square<R>, scale: f64) -> u8 {
        let count = self.count();
        if count == 0 {
            return R::ALL;
        }
        let mut first = 0;
        for chain in chains {
            for slack in 0..chain.slack_count() {
                self.wrenches[first + slack] = chain.slack_wrench(slack);
            }
            first += chain.slack_count();
        }
        self.responses.copy_from_slice(&self.wrenches);
        let mut good = platform::plainly_definite(tangent, scale) & solve(*tangent, 6, &mut self.responses);
        for (row, wrench) in pairs(self.factor.chunks_exact_mut(count), &self.wrenches) {
            for (entry, response) in pairs(row.iter_mut(), &self.responses) {
                *entry = dot(wrench, response);
            }
        }
        first = 0;
        for chain in chains {
            for i in 0..chain.slack_count() {
                for j in 0..chain.slack_count() {
                    self.factor[(first + i) * count + first + j] += chain.slack_response(i, j);
                }
            }
            first += chain.slack_count();
        }
        let (regular, dependent) = (R::splat(REGULAR * self.stiffness), R::splat(DEPENDENT * self.stiffness));
        for k in 0..count {
            let (above, below) = self.factor.split_at_mut((k + 1) * count);
            let pivot_row = &above[k * count..];
            let size = pivot_row[k].abs();
            let is_regular = size.greater(regular);
            good &= R::mask_to_bits(is_regular) | R::mask_to_bits(dependent.greater(size));
            self.inverse[k] = R::select(is_regular, R::splat(1.0) / pivot_row[k], R::zero());
            for row in below.chunks_exact_mut(count) {
                let factor = row[k] * self.inverse[k];
                row[k] = factor;
                subtract(&mut row[k + 1..], factor, &pivot_row[k + 1..]);
            }
        }
        good
    }

    /// Solves for the platform's twist and the slacks in place of `twist` = K⁻¹ F and `slacks` = y₀.
    #[inline(always)]
    fn solve_in_place(&self, twist: &mut [R; 6], slacks: &mut [R]) {
        let count = self.count();
        for (slack, wrench) in pairs(slacks.iter_mut(), &self.wrenches) {
            *slack += dot(wrench, twist);
        }
        for k in 0..count {
            let (known, rest) = slacks.split_at_mut(k + 1);
            for (i, slack) in rest.iter_mut().enumerate() {
                *slack -= self.factor[(k + 1 + i) * count + k] * known[k];
            }
        }
        for k in (0..count).rev() {
            let mut rest = slacks[k];
            let row = &self.factor[k * count..][..count];
            for (&entry, &known) in pairs(&row[k + 1..], &slacks[k + 1..]) {
                rest -= entry * known;
            }
            slacks[k] = rest * self.inverse[k];
        }
        for (response, &slack) in pairs(&self.responses, &*slacks) {
            for (entry, &part) in pairs(twist.iter_mut(), response) {
                *entry -= part * slack;
            }
        }
    }

    /// Corrects the twist of a step found with slack springs to that without them, and keeps the slacks.
    #[inline(always)]
    pub fn correct_step(&mut self, chains: &[ChainSystem<R>], twist: &mut [R; 6]) {
        if self.is_empty() {
            return;
        }
        let mut slacks = std::mem::take(&mut self.slacks);
        fill_slacks(chains, &mut slacks);
        self.solve_in_place(twist, &mut slacks);
        self.slacks = slacks;
    }

    /// Corrects the twist caused by a wrench on the platform to that without slack springs, and keeps the slacks.
    pub fn correct_response(&mut self, twist: &mut [R; 6]) {
        let mut slacks = std::mem::take(&mut self.slacks);
        clear(&mut slacks);
        self.solve_in_place(twist, &mut slacks);
        self.slacks = slacks;
    }

    /// Corrects the twists of a step to a task (first with drives held, then per unit motion of each) to those without slack springs.
    #[inline(always)]
    pub fn correct_task_twists(&mut self, chains: &[ChainSystem<R>], twists: &mut [[R; 6]]) {
        let count = self.count();
        if count == 0 {
            return;
        }
        let mut columns = std::mem::take(&mut self.columns);
        let (held, by_drives) = columns.split_at_mut(count);
        let (held_twist, drive_twists) = twists.split_at_mut(1);
        fill_slacks(chains, held);
        self.solve_in_place(&mut held_twist[0], held);
        self.correct_drive_columns(chains, drive_twists, by_drives);
        self.columns = columns;
    }

    /// Combines and keeps the slacks of the step to a task in which the drives move by `drive_step`.
    #[inline(always)]
    pub fn combine_task_slacks(&mut self, drive_step: &[R]) {
        let count = self.count();
        for (k, slack) in self.slacks.iter_mut().enumerate() {
            *slack = self.columns[k];
            for (drive, &step) in drive_step.iter().enumerate() {
                *slack -= self.columns[(1 + drive) * count + k] * step;
            }
        }
    }

    /// Corrects `twists` = K⁻¹ times the wrench per motion of each drive to those without slack springs; their slacks go into `slacks`.
    #[inline(always)]
    fn correct_drive_columns(&self, chains: &[ChainSystem<R>], twists: &mut [[R; 6]], slacks: &mut [R]) {
        let count = self.count();
        let (mut first, mut column) = (0, 0);
        for chain in chains {
            for drive in 0..chain.drive_count() {
                let slacks = &mut slacks[column * count..][..count];
                clear(slacks);
                for slack in 0..chain.slack_count() {
                    slacks[first + slack] = -chain.slack_force(slack, Some(drive));
                }
                self.solve_in_place(&mut twists[column], slacks);
                column += 1;
            }
            first += chain.slack_count();
        }
    }

    /// Corrects a compliance by rows, found with slack springs, to that without them.
    #[inline(always)]
    pub fn correct_compliance(&mut self, compliance: &mut Square<R>) {
        if self.is_empty() {
            return;
        }
        let mut slacks = std::mem::take(&mut self.slacks);
        for j in 0..6 {
            let mut twist = [R::zero(); 6];
            for (entry, row) in pairs(twist.iter_mut(), &*compliance) {
                *entry = row[j];
            }
            clear(&mut slacks);
            self.solve_in_place(&mut twist, &mut slacks);
            for (row, entry) in pairs(compliance.iter_mut(), twist) {
                row[j] = entry;
            }
        }
        self.slacks = slacks;
    }

    /// Replaces `columns`, wrenches per unit drive motion (platform held), by twists of P under constant load; keeps the drives' slacks.
    #[inline(always)]
    pub fn drive_twists(&mut self, chains: &[ChainSystem<R>], tangent: &Square<R>, columns: &mut [[R; 6]]) {
        solve(*tangent, 6, columns);
        let mut slacks = std::mem::take(&mut self.columns);
        self.correct_drive_columns(chains, columns, &mut slacks);
        self.columns = slacks;
        for entry in columns.iter_mut().flatten().chain(&mut self.columns) {
            *entry = -*entry;
        }
    }

    /// Slacks of the last step.
    #[inline(always)]
    pub fn slacks(&self) -> &[R] {
        &self.slacks
    }

    /// Slacks per unit motion of drive `drive`, by the last [`RigidDirections::drive_twists`].
    pub fn drive_slacks(&self, drive: usize) -> &[R] {
        &self.columns[drive * self.count()..][..self.count()]
    }
}

/// Fills `slacks` with y₀, by the right-hand sides of the chains.
#[inline(always)]
fn fill_slacks<R: Real>(chains: &[ChainSystem<R>], slacks: &mut [R]) {
    let mut first = 0;
    for chain in chains {
        for slack in 0..chain.slack_count() {
            slacks[first + slack] = chain.slack_force(slack, None);
        }
        first += chain.slack_count();
    }
}
