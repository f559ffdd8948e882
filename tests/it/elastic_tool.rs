//! Spindle, holder and cutter bend too: a compliance between P and T, as part of the balance.

use crate::support::engine::*;
use kinetostat::{
    machine::{Configuration, Machine},
    spatial::{Wrench, rotation_exp},
    statics::{
        Batch, Case, Level, Outcome, Scratch, State, Status, elastic_energy, equilibrium, weight_energy, wrench_at_pose,
    },
};
use nalgebra::{Matrix6, Vector3, Vector6};

const CUTTER: &str = "tool = { cutter = { diameter_mm = 16.0, stick_out_mm = 90.0, material = \"carbide\" } }\n";
const CARBIDE: &str = "\n[material.carbide]\nyoungs_modulus_N_per_mm2 = 600000.0\nshear_modulus_N_per_mm2 = 240000.0\n";
const MATRIX: &str = "tool = { compliance_mm_rad_N = [\
    [2e-5, 1e-6, 0.0, 0.0, 4e-8, 0.0], [1e-6, 3e-5, 0.0, -5e-8, 0.0, 0.0], [0.0, 0.0, 5e-6, 0.0, 0.0, 1e-9], \
    [0.0, -5e-8, 0.0, 4e-10, 0.0, 0.0], [4e-8, 0.0, 0.0, 0.0, 3e-10, 0.0], [0.0, 0.0, 1e-9, 0.0, 0.0, 1e-9]] }\n";

fn with_tool(file: &str, tool: &str) -> Machine {
    let text = std::fs::read_to_string(format!("tests/machines/{file}.toml")).unwrap();
    let text = text.replacen("[platform]\n", &format!("[platform]\n{tool}"), 1) + CARBIDE;
    machine_from(&text)
}

fn machines() -> Vec<(Machine, Configuration)> {
    let files = [("robot_6r", CUTTER), ("robot_6r", MATRIX), ("fourbar_robot", MATRIX), ("linear_delta", CUTTER)];
    files
        .into_iter()
        .map(|(file, tool)| {
            let machine = with_tool(file, tool);
            let at =
                machine.inverse_kinematics_at(machine.home.pose.translation + Vector3::new(13.0, -20.0, 17.0)).unwrap();
            (machine, at)
        })
        .collect()
}

fn load() -> Wrench {
    Wrench::new([310.0, -240.0, -420.0, 2.1e4, -1.3e4, 0.9e4])
}

fn settled(machine: &Machine, at: &Configuration, load: &Wrench) -> (State, Outcome) {
    let (state, outcome) = settle(machine, at, load);
    assert_eq!(outcome.status, Status::Solved, "{}", machine.name);
    (state, outcome)
}

#[test]
fn a_cutter_on_a_machine_bends_as_a_cantilever_does() {
    let machine = with_tool("linear_delta", CUTTER);
    let mut straight = machine.clone();
    straight.tool_compliance = None;
    // A force across the tool, small enough for all to be linear.
    let across = machine.home.pose.rotation * machine.tool_axes.column(0) * 1.0;
    let lever = machine.home.pose.rotation * machine.tool_tip;
    let load = Wrench { force: across, moment: lever.cross(&across) };
    let moved = |machine: &Machine| {
        let ends = [Wrench::zero(), load].map(|load| settled(machine, &machine.home, &load).0.pose);
        machine.tool_displacement(&ends[0], &ends[1])
    };
    let second_moment = std::f64::consts::PI * 16f64.powi(4) / 64.0;
    let expected = across * (90f64.powi(3) / (3.0 * 600_000.0 * second_moment));
    let bent = moved(&machine) - moved(&straight);
    assert!((bent - expected).norm() < 1e-5 * expected.norm(), "{bent} {expected}");
}

#[test]
fn stiffness_and_sensitivities_are_those_of_finite_differences() {
    for (machine, at) in machines() {
        let (_, outcome) = settled(&machine, &at, &load());
        let compliance = outcome.compliance.unwrap();
        let size = Vector6::from_fn(|i, _| if i < 3 { 0.5 } else { 200.0 });
        let by_load = Matrix6::from_columns(&std::array::from_fn::<_, 6, _>(|i| {
            let mut step = Vector6::zeros();
            step[i] = size[i];
            let ends = [1.0, -1.0].map(|sign| {
                let loaded = load().to_vector() + step * sign;
                settled(&machine, &at, &Wrench::from_vector(&loaded)).0.pose
            });
            motion_between(&ends[1], &ends[0]) / (2.0 * size[i])
        }));
        let scale = |i: usize| compliance[(i, i)].sqrt();
        for i in 0..6 {
            for j in 0..6 {
                let off = (by_load[(i, j)] - compliance[(i, j)]).abs() / (scale(i) * scale(j));
                assert!(off < 2e-6, "{} [{i}][{j}]: {} {}", machine.name, by_load[(i, j)], compliance[(i, j)]);
            }
        }
        let stiffness = outcome.stiffness.unwrap();
        assert!((stiffness * compliance - Matrix6::identity()).amax() < 1e-6);
        for drive in 0..machine.drive_count() {
            let h = 1e-5;
            let ends = [h, -h].map(|h| {
                let mut moved = at.clone();
                moved.drives[drive] += h;
                settled(&machine, &moved, &load()).0.pose
            });
            let by_drive = motion_between(&ends[1], &ends[0]) / (2.0 * h);
            let column = outcome.drive_sensitivity.column(drive);
            assert!((by_drive - column).norm() < 1e-5 * column.norm().max(1.0), "{} {drive}", machine.name);
        }
    }
}

#[test]
fn forces_are_the_gradient_of_the_energy() {
    for (machine, at) in machines() {
        // A force alone is conservative, and so is its moment about P.
        let force = |share: f64| Wrench::new([310.0 * share, -240.0 * share, -420.0 * share, 0.0, 0.0, 0.0]);
        let energy =
            |state: &State| elastic_energy(&machine, &at.drives, state) + weight_energy(&machine, &at.drives, state);
        let parts = 64;
        let mut last = settled(&machine, &at, &force(0.0)).0;
        let (first, mut work) = (energy(&last), 0.0);
        for part in 1..=parts {
            let share = f64::from(part) / f64::from(parts);
            let next = settled(&machine, &at, &force(share)).0;
            let middle = force(share - 0.5 / f64::from(parts)).to_vector();
            work += middle.dot(&motion_between(&last.pose, &next.pose));
            last = next;
        }
        let gained = energy(&last) - first;
        assert!((gained - work).abs() < 1e-6 * work.abs(), "{}: {gained} {work}", machine.name);
    }
}

#[test]
fn lanes_the_dense_solver_and_the_inverse_agree() {
    for (machine, at) in machines() {
        let (state, outcome) = settled(&machine, &at, &load());
        let mut dense = State::rigid(&machine, &at);
        let mut scratch = Scratch::uncondensed(&machine);
        let other = equilibrium(&machine, &at.drives, &load(), &mut dense, &mut scratch, &EXACT);
        assert_eq!(other.status, Status::Solved);
        assert!(motion_between(&state.pose, &dense.pose).amax() < 1e-8, "{}", machine.name);
        for level in Level::available() {
            let mut batch = Batch::at_level(&machine, level);
            let (mut drives, mut own) = (at.drives.clone(), State::rigid(&machine, &at));
            let case = Case { drives: &mut drives, load: load(), state: &mut own, task: None };
            let together = batch.equilibria(&mut [case], &EXACT);
            assert_eq!((&own, &together[0].compliance), (&state, &outcome.compliance), "{} {level:?}", machine.name);
        }
        let mut held = State::rigid(&machine, &at);
        let mut scratch = Scratch::new(&machine);
        if let Some(found) = wrench_at_pose(&machine, &at.drives, &state.pose, &mut held, &mut scratch, &EXACT) {
            let left = (found.wrench.to_vector() - load().to_vector())
                .component_div(&Vector6::from_fn(|i, _| if i < 3 { 1.0 } else { machine.characteristic_length }));
            assert!(left.amax() < 1e-5 * load().norm(machine.characteristic_length), "{}: {left}", machine.name);
        }
    }
}

#[test]
fn turning_machine_load_and_gravity_together_turns_the_result() {
    let turn = rotation_exp(Vector3::new(0.3, -0.5, 0.7));
    for (machine, at) in machines() {
        let mut turned = machine.clone();
        let about_o = kinetostat::spatial::Pose { rotation: turn, translation: Vector3::zeros() };
        for chain in turned.chains.iter_mut() {
            chain.route.base = about_o.compose(&chain.route.base);
        }
        turned.gravity = turn * machine.gravity;
        let moved = Configuration { pose: about_o.compose(&at.pose), ..at.clone() };
        let turned_load = Wrench { force: turn * load().force, moment: turn * load().moment };
        let here = settled(&machine, &at, &load()).0.pose;
        let there = settled(&turned, &moved, &turned_load).0.pose;
        assert!(motion_between(&about_o.compose(&here), &there).amax() < 1e-8, "{}", machine.name);
    }
}
