//! The loaded stiffness K_C is the derivative of the force–deflection relation in both directions; the unloaded one is
//! symmetric and positive definite; drive sensitivities are derivatives; f and f⁻¹ are inverse to each other.

use crate::support::{
    cases::cases,
    engine::*,
    machines::{HUNG, machine_file, places, some_errors, some_load},
};
use kinetostat::{
    machine::{Configuration, Machine, Motion},
    spatial::Wrench,
    statics::{
        Outcome, Scratch, Solution, State, Status, drive_force_sensitivity, drive_forces, unloaded_stiffness,
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
        Self::of(machine, at, wrench_from(500.0, 40_000.0, parts))
    }

    fn of(machine: Machine, at: Configuration, load: Wrench) -> Self {
        let (state, outcome) = settle(&machine, &at, &load);
        assert_eq!(outcome.status, Status::Solved, "{} at {:?} under {load:?}", machine.name, at.pose);
        Self { machine, at, load, state, outcome }
    }

    /// Machines with weight, springs between points, modules and shown coordinates, their errors built in.
    fn hung() -> Vec<Self> {
        let of = |name: &str| {
            let nominal = machine_file(name);
            let loaded = |(seed, at)| {
                let machine = nominal.with_errors(&some_errors(&nominal, seed));
                Self::of(machine, at, some_load(&nominal, 800.0, seed))
            };
            places(&nominal, 4).into_iter().enumerate().map(loaded).collect::<Vec<_>>()
        };
        HUNG.into_iter().flat_map(of).collect()
    }

    fn stiffness(&self) -> Matrix6<f64> {
        self.outcome.stiffness.unwrap()
    }

    /// Step in mm or rad along motion `index`.
    fn small_step(&self, index: usize) -> f64 {
        if index < 3 { 1e-2 } else { 1e-2 / self.machine.characteristic_length }
    }

    fn wrench_after(&self, motion: &Vector6<f64>) -> Vector6<f64> {
        let pose = moved(&self.state.pose, motion);
        let (mut state, mut scratch) = (self.state.clone(), Scratch::new(&self.machine));
        let force = wrench_at_pose(&self.machine, &self.at.drives, &pose, &mut state, &mut scratch, &DIFFERENCES);
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

impl Loaded {
    fn check_stiffness(&self) {
        let differences = columns(|i| {
            let step = self.small_step(i);
            without_square(|factor| {
                let motion = unit_motion(i) * (factor * step);
                (self.wrench_after(&motion) - self.wrench_after(&-motion)) / (2.0 * factor * step)
            })
        });
        let off = stiffness_difference(&self.stiffness(), &differences);
        assert!(off < 1e-6, "{}: K_C is off the differences of f by {off:e}", self.machine.name);
    }

    fn check_compliance(&self) {
        let differences = columns(|i| {
            let step = self.small_step(i) * self.stiffness()[(i, i)];
            without_square(|factor| {
                let change = unit_motion(i) * (factor * step);
                (self.motion_after(&change) - self.motion_after(&-change)) / (2.0 * factor * step)
            })
        });
        let off = stiffness_difference(&self.outcome.compliance.unwrap(), &differences);
        assert!(off < 1e-6, "{}: K_C⁻¹ is off the differences of f⁻¹ by {off:e}", self.machine.name);
    }

    /// Step of a drive in mm or rad.
    fn drive_step(&self, drive: usize) -> f64 {
        match self.machine.drives().nth(drive).unwrap().1.motion {
            Motion::Prismatic => 1e-2,
            Motion::Revolute => 1e-2 / self.machine.characteristic_length,
        }
    }

    /// The state with a drive moved by `step`.
    fn pushed(&self, drive: usize, step: f64) -> State {
        let mut drives = self.at.drives.clone();
        drives[drive] += step;
        let mut state = self.state.clone();
        let outcome = resettle(&self.machine, &drives, &self.load, &mut state);
        assert!(outcome.is_equilibrium(), "{:?}", outcome.status);
        state
    }

    fn check_drive_sensitivity(&self) {
        for drive in 0..self.machine.drive_count() {
            let step = self.drive_step(drive);
            let pushed = |step: f64| motion_between(&self.state.pose, &self.pushed(drive, step).pose);
            let difference = (pushed(step) - pushed(-step)) / (2.0 * step);
            let off = (self.outcome.drive_sensitivity.column(drive) - difference).amax();
            assert!(off < 1e-6 * difference.amax(), "{}: drive {drive} off by {off:e}", self.machine.name);
        }
    }

    fn check_drive_force_sensitivity(&self) {
        let (machine, drives) = (&self.machine, &self.at.drives);
        let twists = &self.outcome.drive_sensitivity;
        let mut scratch = Scratch::new(machine);
        let exact = drive_force_sensitivity(machine, drives, &self.state, twists, &mut scratch).unwrap();
        for drive in 0..machine.drive_count() {
            let step = self.drive_step(drive);
            let pushed = |step: f64| drive_forces(machine, &self.pushed(drive, step));
            for (i, (more, less)) in pushed(step).into_iter().zip(pushed(-step)).enumerate() {
                let off = (exact[(i, drive)] - (more - less) / (2.0 * step)).abs();
                // Forces are known to rounding of the stiffest drive's.
                let rounding =
                    1e-16 * drive_forces(machine, &self.state).into_iter().fold(1e8, |a, b| b.abs().max(a)) / step;
                assert!(
                    off < 1e-6 * exact.amax() + 1e3 * rounding.max(1e-8),
                    "{}: ∂τ_{i}/∂ρ_{drive} off by {off:e}, of {:e}",
                    machine.name,
                    exact.amax()
                );
            }
        }
    }

    /// `f(f⁻¹(F)) = F`, from the rigid state.
    fn check_inverse(&self) {
        let name = &self.machine.name;
        let mut state = State::rigid(&self.machine, &self.at);
        let mut scratch = Scratch::new(&self.machine);
        let (pose, drives) = (&self.state.pose, &self.at.drives);
        let force = wrench_at_pose(&self.machine, drives, pose, &mut state, &mut scratch, &DIFFERENCES)
            .unwrap_or_else(|| panic!("{name}: no wrench at a solved pose"));
        let reach = self.machine.characteristic_length;
        let largest = self.state.chains.iter().map(|c| c.wrench.norm(reach)).fold(1.0, f64::max);
        let off = Wrench::from_vector(&(force.wrench.to_vector() - self.load.to_vector())).norm(reach);
        assert!(off < 1e-8 * largest, "{name}: f(f⁻¹(F)) is off F by {off:e} N");
        let off = stiffness_difference(&force.stiffness, &self.stiffness());
        assert!(off < 1e-8, "{name}: the two K_C differ by {off:e}");
    }
}

/// Tight, with room for rounding: [`wrench_at_pose`] does not accept a stalled residual.
const DIFFERENCES: kinetostat::statics::Settings =
    kinetostat::statics::Settings { tolerance: 1e-12, max_iterations: 20 };

/// A central difference without its error in the square of the step, from those with one and two steps.
fn without_square(central: impl Fn(f64) -> Vector6<f64>) -> Vector6<f64> {
    (central(1.0) * 4.0 - central(2.0)) / 3.0
}

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
            loaded.check_stiffness();
        }
    }

    #[test]
    fn loaded_compliance_is_the_derivative_of_the_equilibrium(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            loaded.check_compliance();
        }
    }

    #[test]
    fn drive_sensitivity_is_the_derivative_by_the_drives(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            loaded.check_drive_sensitivity();
        }
    }

    #[test]
    fn drive_force_sensitivity_is_the_derivative_by_the_drives(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            loaded.check_drive_force_sensitivity();
        }
    }

    #[test]
    fn wrench_and_equilibrium_are_inverse(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            loaded.check_inverse();
        }
    }

    #[test]
    fn chain_wrenches_add_up_to_the_load_and_internal_ones_to_zero(s in share(), p in parts(), d in degrees()) {
        for (name, ..) in CATALOGUE {
            let loaded = Loaded::new(name, s, p, d);
            let solution = Solution::new(
                &loaded.machine, &loaded.at.drives, &loaded.state, &loaded.outcome,
                &mut Scratch::new(&loaded.machine),
            );
            let reach = loaded.machine.characteristic_length;
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
            let stiffness = unloaded_stiffness(&machine, &at, &mut Scratch::new(&machine)).unwrap();
            let off = stiffness_difference(&stiffness.transpose(), &stiffness);
            prop_assert!(off < 1e-12, "{name}: asymmetry {off:e}");
            prop_assert!(stiffness.cholesky().is_some(), "{name}: K_C is not positive definite at {s:?}");
        }
    }
}

#[test]
fn stiffness_with_weight_springs_and_modules_is_the_derivative_of_the_wrench() {
    Loaded::hung().iter().for_each(Loaded::check_stiffness);
}

#[test]
fn compliance_with_weight_springs_and_modules_is_the_derivative_of_the_equilibrium() {
    Loaded::hung().iter().for_each(Loaded::check_compliance);
}

#[test]
fn drive_sensitivities_with_weight_springs_and_modules_are_derivatives() {
    Loaded::hung().iter().for_each(Loaded::check_drive_sensitivity);
}

#[test]
fn drive_force_sensitivities_with_weight_springs_and_modules_are_derivatives() {
    Loaded::hung().iter().for_each(Loaded::check_drive_force_sensitivity);
}

#[test]
fn wrench_and_equilibrium_with_weight_springs_and_modules_are_inverse() {
    Loaded::hung().iter().for_each(Loaded::check_inverse);
}
