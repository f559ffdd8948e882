//! What an equilibrium costs.

use kinetostat_engine::{
    Machine, Wrench,
    nalgebra::Vector3,
    statics::{Case, LaneSolver, Settings, State},
};

use crate::counted::{Counted, take_counts};

/// The milling force of the paper, eq. (17), at the angle `phi` rad.
fn milling_wrench(machine: &Machine, phi: f64) -> Wrench {
    let (sin, cos) = phi.sin_cos();
    let tool = machine.tool();
    let force = tool.rotation * Vector3::new(215.0 * cos - 10.0 * sin, 215.0 * sin - 10.0 * cos, -25.0);
    Wrench { force, moment: tool.translation.cross(&force) }
}

/// Operations of a warm equilibrium as `benches/README.md` and `benches/equilibrium.rs` have them.
const DOCUMENTED: u64 = 50_650;

#[test]
fn an_equilibrium_costs_the_operations_documented() {
    let nominal = Machine::named_or_file("orthoglide").unwrap();
    let actual = nominal.with_errors(&nominal.assembly_errors(&[1.0, -1.0, 1.0]));
    let at = nominal.inverse_kinematics(&nominal.pose_at(nominal.point("Q1").unwrap().position)).unwrap();
    let (mut drives, mut state) = (at.drives.clone(), State::rigid(&nominal, &at));
    let mut solver: LaneSolver<Counted> = LaneSolver::new(&actual);
    let mut turn = || {
        let mut iterations = 0;
        for i in 0..36 {
            let load = milling_wrench(&nominal, (10.0 * f64::from(i)).to_radians());
            let case = Case { drives: &mut drives, load, state: &mut state, task: None };
            let mut outcomes = Vec::new();
            solver.solve(&actual, &mut [case], &Settings::default(), &mut outcomes);
            iterations += outcomes[0].as_ref().expect("solved").iterations;
        }
        iterations
    };
    turn();
    take_counts();
    let iterations = turn();
    let counts = take_counts();
    let total = counts.iter().sum::<u64>() / 36;
    assert!(
        total.abs_diff(DOCUMENTED) < DOCUMENTED / 100,
        "{total} operations per equilibrium with {iterations} iterations for 36: {counts:?}"
    );
}
