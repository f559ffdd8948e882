//! The linear system of all unknowns without condensation: for chains that are not elastic in six directions (a serial arm with few
//! springs, rigid legs), have idle joints, or have buckled. Slower; pivots by a factorisation that shows the rank.

use nalgebra::{DMatrix, DVector, Dyn, Matrix6, Matrix6xX, SymmetricEigen, Vector6};

use super::{adjoint::Adjoint, chain_system::ChainSystem, outcome::Status};
use crate::{
    machine::Chain,
    spatial::{RankRevealing, skew},
};

/// A pivot or eigenvalue below this fraction of the largest, after equilibration, is zero.
const RANK_TOLERANCE: f64 = 1e-12;
/// A pivot of a solve below this fraction of the largest is zero: beside a singular place, stiff drives outweigh by 1e12 what rigid chains carry.
const PIVOT_TOLERANCE: f64 = 1e-14;
/// An unknown with a smaller part in a motion of unit length does not move.
const LEAST_PART: f64 = 1e-6;

/// Linear system of the unknowns of all chains, then dt; scaled symmetrically so that rows have comparable size.
struct FullSystem {
    matrix: DMatrix<f64>,
    scale: DVector<f64>,
    /// First unknown of each chain; last entry: first row of the platform.
    first: Vec<usize>,
}

impl FullSystem {
    /// Assembles linearised, not yet condensed, chain systems; `weight`: the platform's own stiffness, by its weight.
    fn new(chains: &[ChainSystem], weight: &Matrix6<f64>) -> Self {
        let mut first = vec![0];
        for chain in chains {
            first.push(first[first.len() - 1] + chain.unknown_count());
        }
        let platform = first[chains.len()];
        let mut matrix = DMatrix::zeros(platform + 6, platform + 6);
        for (chain, &start) in chains.iter().zip(&first) {
            chain.assemble(&mut matrix, start, platform);
            let mut block = matrix.fixed_view_mut::<3, 3>(platform + 3, platform + 3);
            block -= skew(chain.moment.0.into()) * 0.5;
        }
        let mut block = matrix.fixed_view_mut::<6, 6>(platform, platform);
        block += weight;
        let scale = equilibration(&matrix);
        for i in 0..matrix.nrows() {
            for j in 0..matrix.ncols() {
                matrix[(i, j)] *= scale[i] * scale[j];
            }
        }
        Self { matrix, scale, first }
    }

    /// First row of the platform.
    fn platform_row(&self) -> usize {
        self.first[self.first.len() - 1]
    }

    /// Whether eigenvalues can be computed: their iterations do not end otherwise.
    fn is_finite(&self) -> bool {
        self.matrix.iter().all(|entry| entry.is_finite())
    }

    /// Solution of minimal length for each column of `right`; `None` for a system that is not finite.
    fn solve(&self, mut right: DMatrix<f64>) -> Option<DMatrix<f64>> {
        if !(self.is_finite() && right.iter().all(|entry| entry.is_finite())) {
            return None;
        }
        for (mut row, scale) in right.row_iter_mut().zip(self.scale.iter()) {
            row *= *scale;
        }
        let factors = RankRevealing::new(self.matrix.clone(), PIVOT_TOLERANCE);
        let mut solution = factors.solve(&right)?;
        // Factors are good to rounding of the largest unknown only: one refinement serves the small ones.
        let rest = &right - &self.matrix * &solution;
        solution += factors.solve(&rest)?;
        for (mut row, scale) in solution.row_iter_mut().zip(self.scale.iter()) {
            row *= *scale;
        }
        Some(solution)
    }

    /// Stability by the inertia of the symmetric part: stable if it has as many positive eigenvalues as there are motions that meet resistance. A
    /// chain that has fewer of them when held at its end buckles. Also whether something moves without resistance, if only within a chain.
    fn stability(&self, chains: &[ChainSystem]) -> (Status, bool) {
        if !self.is_finite() {
            return (Status::Singular, false);
        }
        let symmetric = (&self.matrix + self.matrix.transpose()) * 0.5;
        let closures = (0..chains.len()).flat_map(|chain| self.closure_rows(chains, chain)).collect::<Vec<_>>();
        let eigen = symmetric.clone().symmetric_eigen();
        let zero = RANK_TOLERANCE * eigen.eigenvalues.amax();
        let moves_freely = |rows: &dyn Fn(usize) -> bool| {
            eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()).any(|(value, vector)| {
                let mut moving = vector.iter().enumerate().filter(|(_, part)| part.abs() > LEAST_PART);
                value.abs() <= zero && moving.any(|(row, _)| rows(row))
            })
        };
        let is_idle = moves_freely(&|row| !closures.contains(&row));
        let status = if is_unstable(&eigen, &closures) {
            let buckled = (0..chains.len()).find(|&chain| self.buckles(chains, chain));
            buckled.map_or(Status::Unstable, |chain| Status::Buckled { chain, load_fractions: None })
        } else if moves_freely(&|row| row >= self.platform_row()) {
            Status::Singular
        } else {
            Status::Solved
        };
        (status, is_idle)
    }

    /// Rows of the closure equations of `chain`.
    fn closure_rows(&self, chains: &[ChainSystem], chain: usize) -> Vec<usize> {
        chains[chain].closure_rows(self.first[chain])
    }

    /// Whether `chain` is unstable when its end is held.
    fn buckles(&self, chains: &[ChainSystem], chain: usize) -> bool {
        let (start, size) = (self.first[chain], chains[chain].unknown_count());
        let block = self.matrix.view((start, start), (size, size)).into_owned();
        let closures: Vec<usize> = self.closure_rows(chains, chain).iter().map(|row| row - start).collect();
        is_unstable(&((&block + block.transpose()) * 0.5).symmetric_eigen(), &closures)
    }
}

/// Whether fewer eigenvalues are positive than there are motions with resistance. Counting negative ones would not do: of those that belong
/// to closure equations, some are all but zero where links that hardly yield hold one another.
fn is_unstable(eigen: &SymmetricEigen<f64, Dyn>, closures: &[usize]) -> bool {
    let zero = RANK_TOLERANCE * eigen.eigenvalues.amax();
    let motions: Vec<usize> = (0..eigen.eigenvalues.len()).filter(|row| !closures.contains(row)).collect();
    let positive = eigen.eigenvalues.iter().filter(|&&value| value > zero).count();
    let none: Vec<usize> =
        eigen.eigenvalues.iter().enumerate().filter(|(_, value)| value.abs() <= zero).map(|(k, _)| k).collect();
    if none.is_empty() {
        return motions.len() > positive;
    }
    // Motions without resistance, and what closures carry against one another: each is all of one kind or of the other.
    let moved = eigen.eigenvectors.select_rows(&motions).select_columns(&none);
    let shares = (moved.transpose() * &moved).symmetric_eigenvalues();
    motions.len() > positive + shares.iter().filter(|&&share| share > 0.5).count()
}

/// Symmetric scaling that brings the largest entry of each row near 1 (Ruiz's iteration).
fn equilibration(matrix: &DMatrix<f64>) -> DVector<f64> {
    let size = matrix.nrows();
    let mut scale = DVector::from_element(size, 1.0);
    for _ in 0..10 {
        let row_size = |i: usize| (0..size).map(|j| (matrix[(i, j)] * scale[i] * scale[j]).abs()).fold(0.0, f64::max);
        let sizes: Vec<f64> = (0..size).map(row_size).collect();
        for (s, size) in scale.iter_mut().zip(sizes) {
            if size > 0.0 {
                *s /= size.sqrt();
            }
        }
    }
    scale
}

/// Computes one Newton step of the whole machine: returns the twist of P (mm, rad) and leaves each chain's step in its system; `None` where
/// there is no finite solution. `imbalance`: applied wrench less the sum of the chain wrenches (N, N·mm).
pub(super) fn step(
    chains: &mut [ChainSystem],
    weight: &Matrix6<f64>,
    imbalance: &Vector6<f64>,
) -> Option<Vector6<f64>> {
    let system = FullSystem::new(chains, weight);
    let platform = system.platform_row();
    let mut right = DMatrix::zeros(platform + 6, 1);
    for (chain, &start) in chains.iter().zip(&system.first) {
        for (i, rest) in chain.right_hand_sides().into_iter().enumerate() {
            right[(start + i, 0)] = -rest;
        }
        let closure_moment = chain.closure_moment();
        for i in 0..3 {
            right[(platform + 3 + i, 0)] -= closure_moment.0[i];
        }
    }
    for i in 0..6 {
        right[(platform + i, 0)] += imbalance[i];
    }
    let solution = system.solve(right).filter(|solution| solution.iter().all(|value| value.is_finite()))?;
    let column = solution.column(0);
    for (chain, &start) in chains.iter_mut().zip(&system.first) {
        let unknowns: Vec<f64> = column.rows(start, chain.unknown_count()).iter().copied().collect();
        chain.set_solution(&unknowns);
    }
    Some(column.fixed_rows::<6>(platform).into())
}

/// Solutions of the transposed system for a unit wrench along, then about each axis of O; `None` for a system that is not finite.
pub(super) fn adjoints(chains: &[ChainSystem], weight: &Matrix6<f64>) -> Option<Vec<Adjoint>> {
    let mut system = FullSystem::new(chains, weight);
    system.matrix.transpose_mut();
    let platform = system.platform_row();
    let mut right = DMatrix::zeros(platform + 6, 6);
    right.rows_mut(platform, 6).fill_with_identity();
    let solution = system.solve(right)?;
    let column = |j: usize| {
        let chain_part = |(chain, &start): (&ChainSystem, &usize)| {
            solution.column(j).rows(start, chain.unknown_count()).iter().copied().collect()
        };
        let unknowns = chains.iter().zip(&system.first).map(chain_part).collect();
        Adjoint { chains: unknowns, twist: solution.fixed_view::<6, 1>(platform, j).into() }
    };
    Some((0..6).map(column).collect())
}

/// Tangent of the whole machine at an equilibrium.
pub(super) struct FullTangent {
    pub status: Status,
    /// Whether something moves without resistance, if only within a chain.
    pub has_idle_motion: bool,
    /// Twist of P per wrench at P (mm, rad; N, N·mm); `None` where the platform is free.
    pub compliance: Option<Matrix6<f64>>,
    /// Twist of P per unit motion of each drive under constant load, one column per drive.
    pub drive_sensitivity: Matrix6xX<f64>,
    /// `∂θ_a/∂ρ`: deflection of each actuated joint (rows) per unit motion of each drive; `None` where there is no solution.
    pub joint_deflection: Option<DMatrix<f64>>,
}

/// Compliance, drive sensitivities and stability from chain systems linearised at an equilibrium.
pub(super) fn tangent(machine_chains: &[Chain], chains: &[ChainSystem], weight: &Matrix6<f64>) -> FullTangent {
    let system = FullSystem::new(chains, weight);
    let platform = system.platform_row();
    let drive_count: usize = machine_chains.iter().map(|chain| chain.drives.len()).sum();
    let mut right = DMatrix::zeros(platform + 6, 6 + drive_count);
    for i in 0..6 {
        right[(platform + i, i)] = 1.0;
    }
    // Rows of the drives' joints in the system, and joints per drive.
    let mut rows = Vec::new();
    let mut per_drive = DMatrix::zeros(drive_count, drive_count);
    for ((chain, chain_system), &start) in machine_chains.iter().zip(chains).zip(&system.first) {
        let first = rows.len();
        for (joint, drive) in chain.drives.iter().enumerate() {
            let row = chain_system.row_of(drive.coordinate, start).unwrap_or(start);
            rows.push(row);
            for moved in 0..chain.drives.len() {
                let share = chain.joint_per_drive(joint, moved);
                per_drive[(first + joint, first + moved)] = share;
                right[(row, 6 + first + moved)] = drive.stiffness * share;
            }
        }
    }
    let (mut status, has_idle_motion) = system.stability(chains);
    let mut compliance = None;
    let mut drive_sensitivity = Matrix6xX::zeros(drive_count);
    let mut joint_deflection = None;
    match system.solve(right) {
        Some(solution) => {
            let twists = solution.rows(platform, 6);
            if status != Status::Singular {
                compliance = Some(twists.fixed_columns::<6>(0).into_owned().fixed_view::<6, 6>(0, 0).into());
            }
            for (j, column) in twists.column_iter().skip(6).enumerate() {
                drive_sensitivity.set_column(j, &column);
            }
            let motion = DMatrix::from_fn(drive_count, drive_count, |i, j| solution[(rows[i], 6 + j)]);
            joint_deflection = Some(motion - per_drive);
        }
        None => status = Status::Singular,
    }
    FullTangent { status, has_idle_motion, compliance, drive_sensitivity, joint_deflection }
}

/// Stiffness from a compliance; `None` where the machine is rigid in some direction. `scale` in mm makes rotations comparable.
pub(super) fn invert_if_regular(compliance: &Matrix6<f64>, scale: f64) -> Option<Matrix6<f64>> {
    let mut scaled = *compliance;
    for i in 3..6 {
        scaled.row_mut(i).scale_mut(scale);
        scaled.column_mut(i).scale_mut(scale);
    }
    let values = scaled.singular_values();
    if values.min() > RANK_TOLERANCE * values.max() { compliance.try_inverse() } else { None }
}
