//! Closed-form derivatives of the chains against central differences: Jacobian columns (screws), and, through the loaded
//! chain stiffness, the wrench-weighted Hessians: eqs. (4), (5) are transcribed here with J and H from differences of
//! the chain's pose alone.

use crate::support::cases::cases;
use crate::support::engine::*;
use kinetostat::{
    machine::{Chain, Machine, MoveScrew, SpringLaw},
    spatial::{Pose, Wrench},
    statics::{Scratch, State, Status, chain_stiffnesses},
};
use nalgebra::{DMatrix, DVector, Matrix6, Vector3, Vector6};
use proptest::prelude::*;

const STEP: f64 = 1e-4;

/// A chain with its drives at fixed positions; `x` are its coordinates θ, q.
struct At<'a> {
    chain: &'a Chain,
    drives: &'a [f64],
}

impl At<'_> {
    fn values(&self, x: &DVector<f64>) -> Vec<f64> {
        let mut values: Vec<f64> = x.iter().copied().collect();
        for (drive, rho) in self.chain.drives.iter().zip(self.drives) {
            values[drive.coordinate] += rho;
        }
        values
    }

    /// Closed-form Jacobian at P in O axes.
    fn screws(&self, x: &DVector<f64>) -> DMatrix<f64> {
        let mut screws: Vec<MoveScrew> = Vec::new();
        self.chain.forward(&self.values(x), &mut screws);
        let mut jacobian = DMatrix::zeros(6, x.len());
        for screw in screws {
            let mut column = jacobian.column_mut(screw.coordinate);
            column += screw.twist.to_vector();
        }
        jacobian
    }

    /// The same by central differences of the pose.
    fn differences(&self, x: &DVector<f64>) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(6, x.len());
        for (k, mut column) in jacobian.column_iter_mut().enumerate() {
            let pose = |step: f64| {
                let mut moved = x.clone();
                moved[k] += step;
                self.chain.forward(&self.values(&moved), &mut Vec::new())
            };
            column.copy_from(&(motion_between(&pose(-STEP), &pose(STEP)) / (2.0 * STEP)));
        }
        jacobian
    }

    /// Out-of-balance generalised forces ∂U/∂x − JᵀF.
    fn balance(&self, x: &DVector<f64>, wrench: &Vector6<f64>) -> DVector<f64> {
        spring_forces(self.chain, x) - self.screws(x).transpose() * wrench
    }

    /// Eqs. (4), (5): the wrench per twist of the end, with the derivative of the balance by central differences.
    fn stiffness(&self, x: &DVector<f64>, wrench: &Vector6<f64>) -> Matrix6<f64> {
        let n = x.len();
        let mut system = DMatrix::zeros(n + 6, n + 6);
        for k in 0..n {
            let balance = |step: f64| {
                let mut moved = x.clone();
                moved[k] += step;
                self.balance(&moved, wrench)
            };
            let slope = (balance(STEP) - balance(-STEP)) / (2.0 * STEP);
            system.view_mut((0, k), (n, 1)).copy_from(&slope);
        }
        let jacobian = self.screws(x);
        system.view_mut((0, n), (n, 6)).copy_from(&-jacobian.transpose());
        system.view_mut((n, 0), (6, n)).copy_from(&jacobian);
        let mut right = DMatrix::zeros(n + 6, 6);
        right.view_mut((n, 0), (6, 6)).fill_with_identity();
        let solution = system.lu().solve(&right).expect("regular chain");
        solution.fixed_view::<6, 6>(n, 0).into_owned()
    }
}

/// Gradient of the chain's elastic energy.
fn spring_forces(chain: &Chain, x: &DVector<f64>) -> DVector<f64> {
    let mut forces = DVector::zeros(x.len());
    for spring in &chain.springs {
        let size = spring.law.size();
        let theta = x.rows(spring.start, size).into_owned();
        let stiffness = DMatrix::from_fn(size, size, |i, j| match &spring.law {
            SpringLaw::Drive(k) => *k,
            SpringLaw::Link(k) => k[(i, j)],
            SpringLaw::Parallelogram { passive, terms } => {
                let q = x[*passive];
                terms[0][(i, j)] + terms[1][(i, j)] * (2.0 * q).cos() + terms[2][(i, j)] * (2.0 * q).sin()
            }
        });
        let mut rows = forces.rows_mut(spring.start, size);
        rows += stiffness * &theta;
        if let SpringLaw::Parallelogram { passive, terms } = &spring.law {
            let q = x[*passive];
            let slope = (terms[2] * (2.0 * q).cos() - terms[1] * (2.0 * q).sin()) * 2.0;
            forces[*passive] += 0.5 * (theta.transpose() * slope * &theta)[(0, 0)];
        }
    }
    for (j, joint) in chain.passive.iter().enumerate() {
        let row = chain.passive_coordinate(j);
        forces[row] += joint.stiffness * (x[row] - joint.neutral);
    }
    forces
}

/// Every element kind in one chain, in skew directions.
const ZOO: &str = r#"
schema = 1
name = "zoo"
title = "one chain with every kind of element"
platform = { tool_tip_mm = [10.0, -20.0, 30.0], controls = ["x"] }
home = { position_mm = [450.0, 150.0, -150.0] }
workspace = { min_mm = [0.0, 0.0, 0.0], max_mm = [0.0, 0.0, 0.0] }
[material.m]
youngs_modulus_N_per_mm2 = 70000.0
shear_modulus_N_per_mm2 = 27000.0
[[chain]]
name = "all"
elements = [
  { revolute_drive = { name = "swing", axis = "z", stiffness_Nmm_per_rad = 1e8 } },
  { beam = { length_mm = 150.0, section = { round = { diameter_mm = 20.0 } }, material = "m" } },
  { fixed = { translation_mm = [0.0, 12.0, -7.0], rotation_deg = [20.0, -30.0, 40.0] } },
  { prismatic_drive = { name = "rail", axis = "y", stiffness_N_per_mm = 1e4 } },
  { revolute_joint = { name = "hinge", axis = "x", stiffness_Nmm_per_rad = 1e7 } },
  { beam = { length_mm = 200.0, section = { tube = { outer_diameter_mm = 30.0, inner_diameter_mm = 20.0 } }, material = "m" } },
  { parallelogram = { name = "pa", length_mm = 180.0, width_mm = 60.0, bar_section = { rectangle = { width_mm = 10.0, height_mm = 8.0 } }, material = "m" } },
  { prismatic_joint = { name = "slide", axis = "z", stiffness_N_per_mm = 2e3 } },
  { revolute_joint = { name = "wrist", axis = "y" } },
  { beam = { length_mm = 90.0, section = { rectangle = { width_mm = 15.0, height_mm = 9.0 } }, material = "m" } },
]
[[mount]]
name = "zoo"
chain = "all"
base = { position_mm = [5.0, -6.0, 7.0], rotation_deg = [10.0, 20.0, 30.0] }
platform = { position_mm = [3.0, 4.0, -5.0], rotation_deg = [0.0, 45.0, 15.0] }
"#;

/// Two chains of every element kind on one platform: the second is the first turned about the platform point, so that
/// together they resist every motion.
fn zoo() -> Machine {
    let mut machine = machine_from(ZOO);
    let turn = Pose::from_rotation_vector(Vector3::new(0.5, -1.0, 1.8));
    let x_op = machine.home.pose;
    let mut about_p = turn;
    about_p.translation = x_op.translation - turn.rotation * x_op.translation;
    let mut second = machine.chains[0].clone();
    second.name = "second".into();
    second.route.base = about_p.compose(&second.route.base);
    second.route.attachment =
        second.route.attachment.compose(&x_op.inverse().compose(&about_p.inverse()).compose(&x_op));
    machine.chains.push(second);
    machine.home.drives.extend_from_within(..);
    machine.home.passive.extend_from_within(..);
    machine
}

fn coordinates(count: usize, raw: &[f64], size: f64) -> DVector<f64> {
    DVector::from_fn(count, |i, _| raw[i % raw.len()] * size)
}

fn machines() -> Vec<Machine> {
    vec![catalogue_machine("orthoglide"), catalogue_machine("tripteron"), zoo()]
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn screws_are_the_derivative_of_the_pose(raw in prop::collection::vec(-1.0..1.0f64, 40), rho in -100.0..100.0f64) {
        for machine in machines() {
            for chain in &machine.chains {
                let drives = vec![rho; chain.drives.len()];
                let at = At { chain, drives: &drives };
                let x = coordinates(chain.coordinate_count(), &raw, 0.8);
                let off = (at.screws(&x) - at.differences(&x)).amax();
                prop_assert!(off < 1e-5, "{}: chain {}: J off by {off:e}", machine.name, chain.name);
            }
        }
    }

    #[test]
    fn loaded_chain_stiffness_is_eqs_4_and_5(share in prop::array::uniform3(0.0..1.0f64), p in prop::array::uniform6(-1.0..1.0f64)) {
        for (name, low, high) in CATALOGUE {
            let nominal = catalogue_machine(name);
            let at = at_position(&nominal, position_in_box(&nominal, low, high, share));
            let machine = with_assembly_errors(&nominal, [1.0, -0.7, 0.4]);
            check_chains(&machine, &State::rigid(&nominal, &at), &at.drives, &wrench_from(2000.0, 2e5, p))?;
        }
        let machine = zoo();
        check_chains(&machine, &State::rigid(&machine, &machine.home), &machine.home.drives, &wrench_from(100.0, 1e4, p))?;
    }
}

fn check_chains(machine: &Machine, from: &State, drives: &[f64], load: &Wrench) -> Result<(), TestCaseError> {
    let mut state = from.clone();
    let outcome = resettle(machine, drives, load, &mut state);
    prop_assert_eq!(&outcome.status, &Status::Solved, "{} under {:?}", machine.name, load);
    let stiffnesses = chain_stiffnesses(machine, drives, &state, &mut Scratch::new(machine));
    let mut first = 0;
    for ((chain, own), stiffness) in machine.chains.iter().zip(&state.chains).zip(stiffnesses) {
        let at = At { chain, drives: &drives[first..first + chain.drives.len()] };
        first += chain.drives.len();
        let x = DVector::from_column_slice(&own.coordinates);
        let wrench = own.wrench.to_vector();
        let residual = at.balance(&x, &wrench).amax();
        prop_assert!(
            residual < 1e-6 * wrench.amax(),
            "{}: chain {} out of balance by {residual:e}",
            machine.name,
            chain.name
        );
        let off = block_difference(&stiffness.unwrap(), &at.stiffness(&x, &wrench));
        prop_assert!(off < 1e-7, "{}: chain {}: K_C off eqs. (4), (5) by {off:e}", machine.name, chain.name);
    }
    Ok(())
}
