//! Cartesian stiffness of chains and machine, eqs. (4)–(6), and what is read off it.

use nalgebra::{Matrix3, Matrix3x6, Matrix6};

use super::{
    equilibrium::{chain_inputs, subtract_half_moment},
    state::{State, Workspace},
};
use crate::{
    machine::{Configuration, Machine},
    spatial::skew,
};

/// Stiffness `K_C^(i)` of each chain at `state`, eqs. (4), (5): change of the wrench a chain receives per twist of its
/// end, at P in O axes (N, N·mm; mm, rad). In a loaded state it includes the wrench-weighted Hessians.
///
/// `None` for a chain that is unstable when held at its end, or whose end cannot move elastically in six directions.
pub fn chain_stiffnesses(
    machine: &Machine,
    drives: &[f64],
    state: &State,
    workspace: &mut Workspace,
) -> Vec<Option<Matrix6<f64>>> {
    let inputs = chain_inputs(machine, state, drives);
    let systems = workspace.chains.iter_mut().zip(&machine.chains).zip(inputs);
    let stiffness = systems.map(|((system, chain), (chain_state, drives))| {
        system.linearise(chain, drives, chain_state, &state.pose);
        let mut stiffness = system.condense()?;
        subtract_half_moment(&mut stiffness, chain_state.wrench);
        Some(stiffness)
    });
    stiffness.collect()
}

/// Unloaded Cartesian stiffness K_C of the machine at a rigid configuration, eq. (6); `None` where a chain's is.
pub fn unloaded_stiffness(machine: &Machine, at: &Configuration, workspace: &mut Workspace) -> Option<Matrix6<f64>> {
    let state = State::rigid(machine, at);
    chain_stiffnesses(machine, &at.drives, &state, workspace).into_iter().sum()
}

/// Compliance of a point fixed to the platform at `offset` mm from P (O axes): its displacement per force acting on it,
/// mm/N, from the compliance of P.
pub fn tool_compliance(compliance: &Matrix6<f64>, offset: nalgebra::Vector3<f64>) -> Matrix3<f64> {
    let mut to_point = Matrix3x6::zeros();
    to_point.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
    to_point.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(offset));
    to_point * compliance * to_point.transpose()
}

/// Principal stiffnesses of a point, ascending, N/mm: the inverse eigenvalues of its compliance (mm/N).
pub fn principal_stiffnesses(compliance: &Matrix3<f64>) -> [f64; 3] {
    let symmetric = (compliance + compliance.transpose()) * 0.5;
    let mut stiffnesses: [f64; 3] = symmetric.symmetric_eigenvalues().map(|c| 1.0 / c).into();
    stiffnesses.sort_by(f64::total_cmp);
    stiffnesses
}

/// Smallest eigenvalue in N/mm of the symmetric part of a 6×6 stiffness whose rotations are multiplied by `reach` mm.
/// Positive: stable. NaN where the stiffness is not finite.
pub fn smallest_eigenvalue(stiffness: &Matrix6<f64>, reach: f64) -> f64 {
    let mut scaled = (stiffness + stiffness.transpose()) * 0.5;
    for i in 3..6 {
        scaled.row_mut(i).unscale_mut(reach);
        scaled.column_mut(i).unscale_mut(reach);
    }
    // The eigenvalue iteration does not end on entries that are not finite.
    if !scaled.iter().all(|entry| entry.is_finite()) {
        return f64::NAN;
    }
    scaled.symmetric_eigenvalues().min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stiffness_that_is_not_finite_has_no_eigenvalue_instead_of_no_end() {
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(smallest_eigenvalue(&(Matrix6::identity() * bad), 100.0).is_nan());
        }
        assert!((smallest_eigenvalue(&Matrix6::identity(), 1.0) - 1.0).abs() < 1e-15);
    }
}
