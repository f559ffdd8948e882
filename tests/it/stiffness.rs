//! The loaded stiffness K_C is the derivative of the force–deflection relation in both directions; the unloaded one is
//! symmetric and positive definite; drive sensitivities are derivatives; f and f⁻¹ are inverse to each other.

use crate::support::engine::*;
use kinetostat::{
    machine::{Configuration, Machine},
    spatial::Wrench,
    statics::{
        Outcome, Solution, State, Status, Workspace, drive_force_sensitivity, drive_forces, unloaded_stiffness,
        wrench_at_pose,
    },
};
use nalgebra::{Matrix6, Vector6};
use proptest::prelude::*;

/// A loaded equilibrium.
struct Loaded {
    machine: Machine,
    at: Configuration,
    load: Wrench,
    state: State,
    outcome: Outcome,
}

impl Loaded {
    fn new(name: &str, share: [f64; 3], parts: [f64; 6], degrees: [f64; 3]) -> Self {
        let (_, low, high) = CATALOGUE.into_iter().find(|entry| entry.0 == name).unwrap();
        let nominal = catalogue_machine(name);
        let at = at_position(&nominal, position_in_box(&nominal, low, high, share));
        let machine = with_assembly_errors(&nominal, degrees);
        let load = wrench_from(500.0, 40_000.0, parts);
        let (state, outcome) = settle(&machine, &at, &load);
        assert_eq!(outcome.status, Status::Solved, "{name} at {share:?} under {load:?}");
        Self { machine, at, load, state, outcome }
    }

    fn stiffness(&self) -> Matrix6<f64> {
        self.outcome.stiffness.unwrap()
    }

    /// Step in mm or rad along motion `index`.
    fn small_step(&self, index: usize) -> f64 {
        if index < 3 { 1e-2 } else { 1e-2 / self.machine.reach }
    }

    fn wrench_after(&self, motion: &Vector6<f64>) -> Vector6<f64> {
        let pose = moved(&self.state.pose, motion);
        let (mut state, mut workspace) = (self.state.clone(), Workspace::new(&self.machine));
        let force = wrench_at_pose(&self.machine, &self.at.drives, &pose, &mut state, &mut workspace, &DIFFERENCES);
        force.expect("wrench near an equilibrium").wrench.to_vector()
    }

    fn motion_after(&self, change: &Vector6<f64>) -> Vector6<f64> {
        let load = Wrench::from_vector(&(self.load.to_vector() + change));
        let mut state = self.state.clone();
        let outcome = resettle(&self.machine, &self.at.drives, &load, &mut state);
        assert!(outcome.is_equilibrium(), "{:?}", outcome.status);
        motion_between(&self.state.pose, &state.pose)
    }
}

/// Tight, with room for rounding: [`wrench_at_pose`] does not accept a stalled residual.
const DIFFERENCES: kinetostat::statics::Settings =
    kinetostat::statics::Settings { tolerance: 1e-12, max_iterations: 20 };

fn columns(column: impl Fn(usize) -> Vector6<f64>) -> Matrix6<f64> {
    Matrix6::from_columns(&std::array::from_fn::<_, 6, _>(column))
}

fn parts() -> impl Strategy<Value = [f64; 6]> {
    prop::array::uniform6(-1.0..1.0f64)
}

fn share() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(0.0..1.0f64)
}

fn degrees() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-1.5..1.5f64)
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn loaded_stiffness_is_the_derivative_of_the_wrench(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            let differences = columns(|i| {
                let step = loaded.small_step(i);
                let motion = unit_motion(i) * step;
                (loaded.wrench_after(&motion) - loaded.wrench_after(&-motion)) / (2.0 * step)
            });
            let off = stiffness_difference(&loaded.stiffness(), &differences);
            prop_assert!(off < 1e-6, "{name}: K_C is off the differences of f by {off:e}");
        }
    }

    #[test]
    fn loaded_compliance_is_the_derivative_of_the_equilibrium(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            let differences = columns(|i| {
                let step = loaded.small_step(i) * loaded.stiffness()[(i, i)];
                let central = |factor: f64| {
                    let change = unit_motion(i) * (factor * step);
                    (loaded.motion_after(&change) - loaded.motion_after(&-change)) / (2.0 * factor * step)
                };
                // Without the error in the square of the step.
                (central(1.0) * 4.0 - central(2.0)) / 3.0
            });
            let off = stiffness_difference(&loaded.outcome.compliance.unwrap(), &differences);
            prop_assert!(off < 1e-6, "{name}: K_C⁻¹ is off the differences of f⁻¹ by {off:e}");
        }
    }

    #[test]
    fn drive_sensitivity_is_the_derivative_by_the_drives(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            for drive in 0..loaded.machine.drive_count() {
                let pushed = |step: f64| {
                    let mut drives = loaded.at.drives.clone();
                    drives[drive] += step;
                    let mut state = loaded.state.clone();
                    resettle(&loaded.machine, &drives, &loaded.load, &mut state);
                    motion_between(&loaded.state.pose, &state.pose)
                };
                let difference = (pushed(1e-2) - pushed(-1e-2)) / 2e-2;
                let off = (loaded.outcome.drive_sensitivity.column(drive) - difference).amax();
                prop_assert!(off < 1e-6 * difference.amax(), "{name}: drive {drive} off by {off:e}");
            }
        }
    }

    #[test]
    fn drive_force_sensitivity_is_the_derivative_by_the_drives(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            let (machine, drives) = (&loaded.machine, &loaded.at.drives);
            let twists = &loaded.outcome.drive_sensitivity;
            let mut workspace = Workspace::new(machine);
            let exact = drive_force_sensitivity(machine, drives, &loaded.state, twists, &mut workspace).unwrap();
            for drive in 0..machine.drive_count() {
                let pushed = |step: f64| {
                    let mut drives = drives.clone();
                    drives[drive] += step;
                    let mut state = loaded.state.clone();
                    resettle(machine, &drives, &loaded.load, &mut state);
                    drive_forces(machine, &state)
                };
                for (i, (more, less)) in pushed(1e-2).into_iter().zip(pushed(-1e-2)).enumerate() {
                    let off = (exact[(i, drive)] - (more - less) / 2e-2).abs();
                    prop_assert!(off < 1e-6 * exact.amax() + 1e-5, "{name}: ∂τ_{i}/∂ρ_{drive} off by {off:e} N/mm");
                }
            }
        }
    }

    #[test]
    fn wrench_and_equilibrium_are_inverse(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            let mut state = State::rigid(&catalogue_machine(name), &loaded.at);
            let mut workspace = Workspace::new(&loaded.machine);
            let force = wrench_at_pose(
                &loaded.machine, &loaded.at.drives, &loaded.state.pose, &mut state, &mut workspace, &DIFFERENCES,
            ).expect("wrench at a solved pose");
            let reach = loaded.machine.reach;
            let largest = loaded.state.chains.iter().map(|c| c.wrench.norm(reach)).fold(1.0, f64::max);
            let off = Wrench::from_vector(&(force.wrench.to_vector() - loaded.load.to_vector())).norm(reach);
            prop_assert!(off < 1e-8 * largest, "{name}: f(f⁻¹(F)) is off F by {off:e} N");
            let off = stiffness_difference(&force.stiffness, &loaded.stiffness());
            prop_assert!(off < 1e-8, "{name}: the two K_C differ by {off:e}");
        }
    }

    #[test]
    fn chain_wrenches_add_up_to_the_load_and_internal_ones_to_zero(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            let solution = Solution::new(
                &loaded.machine, &loaded.at.drives, &loaded.load, &loaded.state, &loaded.outcome,
                &mut Workspace::new(&loaded.machine),
            );
            let reach = loaded.machine.reach;
            let largest = solution.chains.iter().map(|c| c.wrench.norm(reach)).fold(1.0, f64::max);
            let sum: Vector6<f64> = solution.chains.iter().map(|c| c.wrench.to_vector()).sum();
            let off = Wrench::from_vector(&(sum - loaded.load.to_vector())).norm(reach);
            prop_assert!(off < 1e-11 * largest, "{name}: Σ chain wrenches is off the load by {off:e} N");
            let internal: Vector6<f64> = solution.chains.iter().map(|c| c.internal_wrench.unwrap().to_vector()).sum();
            let off = Wrench::from_vector(&internal).norm(reach);
            prop_assert!(off < 1e-8 * largest, "{name}: Σ internal wrenches is {off:e} N");
        }
    }

    #[test]
    fn unloaded_stiffness_is_symmetric_and_positive_definite(s in share()) {
        for (name, low, high) in CATALOGUE {
            let machine = catalogue_machine(name);
            let at = at_position(&machine, position_in_box(&machine, low, high, s));
            let stiffness = unloaded_stiffness(&machine, &at, &mut Workspace::new(&machine)).unwrap();
            let off = stiffness_difference(&stiffness.transpose(), &stiffness);
            prop_assert!(off < 1e-12, "{name}: asymmetry {off:e}");
            prop_assert!(stiffness.cholesky().is_some(), "{name}: K_C is not positive definite at {s:?}");
        }
    }
}
