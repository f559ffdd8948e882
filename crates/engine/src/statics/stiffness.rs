//! Cartesian stiffness of chains and machine, eqs. (4)–(6), and what follows from it.

use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector6};

use super::{
    equilibrium::equilibrium,
    outcome::{Outcome, Settings},
    platform::subtract_half_moment,
    state::{Scratch, State, chain_inputs},
};
use crate::{
    machine::{Configuration, Machine},
    spatial::{Wrench, skew},
};

/// Stiffness `K_C^(i)` of each chain at `state`, eqs. (4), (5): change of the wrench a chain receives per twist of its
/// end, at P in O axes (N, N·mm; mm, rad). In a loaded state it includes the wrench-weighted Hessians.
/// `None` for a chain that is unstable when held at its end, or whose end cannot move elastically in six directions.
pub fn chain_stiffnesses(
    machine: &Machine,
    drives: &[f64],
    state: &State,
    scratch: &mut Scratch,
) -> Vec<Option<Matrix6<f64>>> {
    let inputs = chain_inputs(machine, state, drives);
    let systems = scratch.solver.systems.iter_mut().zip(&machine.chains).zip(inputs);
    let stiffness = systems.map(|((system, chain), (chain_state, drives))| {
        system.linearise(chain, drives, chain_state, state.platform(), &machine.gravity);
        let mut stiffness = system.condense()?;
        subtract_half_moment(&mut stiffness, chain_state.wrench);
        Some(stiffness)
    });
    stiffness.collect()
}

/// Unloaded Cartesian stiffness K_C of the machine at a rigid configuration, eq. (6); `None` where the machine is rigid in
/// some direction. Where a chain has no stiffness for another reason, it is that of the unloaded equilibrium.
pub fn unloaded_stiffness(machine: &Machine, at: &Configuration, scratch: &mut Scratch) -> Option<Matrix6<f64>> {
    let machine = &machine.weightless();
    let state = State::rigid(machine, at);
    let by_chains: Option<Matrix6<f64>> = chain_stiffnesses(machine, &at.drives, &state, scratch).into_iter().sum();
    // Chains hold the platform's body, and not the end of a tool that bends.
    by_chains.filter(|_| machine.tool_compliance.is_none()).or_else(|| solve_unloaded(machine, at, scratch).stiffness)
}

/// Unloaded compliance of the machine at a rigid configuration: twist of P per wrench at P in O axes; `None` where the platform is free.
pub fn unloaded_compliance(machine: &Machine, at: &Configuration, scratch: &mut Scratch) -> Option<Matrix6<f64>> {
    solve_unloaded(machine, at, scratch).compliance
}

/// Outcome of the unloaded, weightless equilibrium at a rigid configuration.
fn solve_unloaded(machine: &Machine, at: &Configuration, scratch: &mut Scratch) -> Outcome {
    let machine = &machine.weightless();
    let mut state = State::rigid(machine, at);
    equilibrium(machine, &at.drives, &Wrench::zero(), &mut state, scratch, &Settings::default())
}

/// Basis of the wrenches at P (N, N·mm) that this compliance bears rigidly, each with a 1 where others have a 0; rotations at `scale` mm.
pub fn rigid_wrenches(compliance: &Matrix6<f64>, scale: f64) -> Vec<Vector6<f64>> {
    let lever = |i: usize| if i < 3 { 1.0 } else { scale };
    let scaled = Matrix6::from_fn(|i, j| 0.5 * (compliance[(i, j)] + compliance[(j, i)]) * lever(i) * lever(j));
    if !scaled.iter().all(|entry| entry.is_finite()) {
        return Vec::new();
    }
    let eigen = scaled.symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let mut basis: Vec<Vector6<f64>> = (0..6)
        .filter(|&i| eigen.eigenvalues[i].abs() <= RIGID * largest)
        .map(|i| eigen.eigenvectors.column(i).into())
        .collect();
    // Gauss–Jordan: each vector gets a component of its own.
    let mut leads = Vec::new();
    for k in 0..basis.len() {
        let size = |i: &usize| if leads.contains(i) { -1.0 } else { basis[k][*i].abs() };
        let lead = (0..6).fold(0, |most, i| if size(&i) > size(&most) { i } else { most });
        leads.push(lead);
        let pivot = basis[k] / basis[k][lead];
        basis[k] = pivot;
        for (_, vector) in basis.iter_mut().enumerate().filter(|(other, _)| *other != k) {
            *vector -= pivot * vector[lead];
        }
    }
    for (vector, lead) in basis.iter_mut().zip(leads) {
        // What is left of rounding.
        vector.apply(|entry| *entry = if entry.abs() < 1e-9 { 0.0 } else { *entry });
        vector.fixed_rows_mut::<3>(3).scale_mut(scale);
        *vector /= vector[lead];
    }
    basis
}

/// An eigenvalue of a compliance below this fraction of the largest is that of a rigid direction.
const RIGID: f64 = 1e-12;

/// A point that yields less than this, mm/N, is rigid: the stiffest spring that a machine may have.
const RIGID_MM_PER_N: f64 = 1e-18;

/// Compliance of a point fixed to the platform at `offset` mm from P (O axes), its displacement per force, mm/N, from the compliance of P.
pub fn tool_compliance(compliance: &Matrix6<f64>, offset: nalgebra::Vector3<f64>) -> Matrix3<f64> {
    let mut to_point = Matrix3x6::zeros();
    to_point.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
    to_point.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(offset));
    to_point * compliance * to_point.transpose()
}

/// Principal stiffnesses of a point, ascending, N/mm: the inverse eigenvalues of its compliance (mm/N); infinite where it is rigid.
pub fn principal_stiffnesses(compliance: &Matrix3<f64>) -> [f64; 3] {
    let symmetric = (compliance + compliance.transpose()) * 0.5;
    let compliances = symmetric.symmetric_eigenvalues();
    let least = (RIGID * compliances.amax()).max(RIGID_MM_PER_N);
    let mut stiffnesses: [f64; 3] = compliances.map(|c| if c.abs() <= least { f64::INFINITY } else { 1.0 / c }).into();
    stiffnesses.sort_by(f64::total_cmp);
    stiffnesses
}

/// Smallest eigenvalue in N/mm of the symmetric part of a 6×6 stiffness whose rotations are multiplied by `scale` mm.
/// Positive: stable. NaN where the stiffness is not finite.
pub fn smallest_eigenvalue(stiffness: &Matrix6<f64>, scale: f64) -> f64 {
    scaled_eigenvalues(stiffness, |entry| entry / scale).map_or(f64::NAN, |values| values.min())
}

/// Largest eigenvalue in mm/N of the symmetric part of a 6×6 compliance whose rotations are multiplied by `scale` mm: the
/// inverse of the smallest stiffness of a stable machine.
pub fn largest_compliance(compliance: &Matrix6<f64>, scale: f64) -> f64 {
    scaled_eigenvalues(compliance, |entry| entry * scale).map_or(f64::NAN, |values| values.max())
}

/// Eigenvalues of the symmetric part, rows and columns of rotations scaled by `scale`; `None` where an entry is not finite.
fn scaled_eigenvalues(matrix: &Matrix6<f64>, scale: impl Fn(f64) -> f64) -> Option<Vector6<f64>> {
    let mut scaled = (matrix + matrix.transpose()) * 0.5;
    for i in 3..6 {
        scaled.row_mut(i).apply(|entry| *entry = scale(*entry));
        scaled.column_mut(i).apply(|entry| *entry = scale(*entry));
    }
    // The eigenvalue iteration does not end on entries that are not finite.
    scaled.iter().all(|entry| entry.is_finite()).then(|| scaled.symmetric_eigenvalues())
}
