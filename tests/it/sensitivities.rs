//! Exact derivatives of loaded poses by parameters of machines, against formulas and against differences of whole solves.

use crate::support::{
    cases::cases,
    engine::*,
    planar::{Leg, machine},
};
use kinetostat::{
    machine::{Configuration, Machine, catalogue},
    spatial::{Pose, Wrench},
    statics::{Outcome, Scratch, Sensitivities, Sensitivity, Settings, State, Status, equilibrium, wrench_at_pose},
};
use nalgebra::{Vector3, Vector6};
use proptest::prelude::*;

/// Solved until rounding stops it.
fn exactly(machine: &Machine, at: &Configuration, load: &Wrench, state: &mut State) -> Outcome {
    let settings = Settings { tolerance: 1e-16, max_iterations: 20 };
    equilibrium(machine, &at.drives, load, state, &mut Scratch::new(machine), &settings)
}

fn sensitivities(machine: &Machine, at: &Configuration, load: &Wrench, names: &[&str]) -> (State, Vec<Sensitivity>) {
    let (state, outcome) = settle(machine, at, load);
    assert_eq!(outcome.status, Status::Solved, "{}", machine.name);
    let mut all = Sensitivities::new(machine, names).unwrap_or_else(|e| panic!("{}: {e}", machine.name));
    let found = all.at(machine, &at.drives, &state, &|_| *load, &mut Scratch::new(machine));
    (state, found.expect("a platform that is held"))
}

/// A lever of 100 mm on a revolute joint of 2e6 N·mm/rad, pressed by a dead force across it: `k φ = F L cos φ`.
#[test]
fn a_lever_on_a_hinge_turns_as_its_formula_says() {
    let (length, stiffness, force) = (100.0, 2e6, 4000.0);
    let revolute = r#"{ revolute_drive = { name = "hinge", axis = "z", stiffness_Nmm_per_rad = 2e6 } }"#;
    let lever = r#"{ fixed = { name = "lever", translation_mm = [100.0, 0.0, 0.0] } }"#;
    let machine = machine("lever", [length, 0.0, 0.0], r#""y""#, &[Leg::new("arm", &[revolute, lever], "")]);
    let load = Wrench::new([0.0, force, 0.0, 0.0, 0.0, 0.0]);
    let names = ["arm.hinge.stiffness", "arm.lever.translation.x", "arm.lever.translation.y", "arm.hinge.offset"];
    let (state, found) = sensitivities(&machine, &machine.home, &load, &names);
    let angle = state.pose.rotation[(1, 0)].asin();
    let (sine, cosine) = angle.sin_cos();
    assert!((stiffness * angle - force * length * cosine).abs() < 1e-6 * stiffness * angle);
    let resists = stiffness + force * length * sine;
    // The lever's own displacement, and that by its turn.
    let turned = Vector3::new(-length * sine, length * cosine, 0.0);
    let along = Vector3::new(cosine, sine, 0.0);
    let across = Vector3::new(-sine, cosine, 0.0);
    let cases = [
        (-angle / resists, Vector3::zeros()),
        (force * cosine / resists, along),
        (-force * sine / resists, across),
        (stiffness / resists * 1f64.to_radians(), Vector3::zeros()),
    ];
    for ((name, (turn, own)), found) in names.iter().zip(cases).zip(found) {
        let moved = turned * turn + own;
        let expected = Vector6::new(moved.x, moved.y, 0.0, 0.0, 0.0, turn);
        let off = (found.twist - expected).amax() / expected.amax();
        assert!(off < 1e-8, "{name}: {} instead of {expected}, {off:e}", found.twist);
    }
}

/// A force on the tool tip turns the lever by more where the tip is farther out, and the tip moves with it.
#[test]
fn the_tool_tip_moves_its_load_and_itself() {
    let robot = catalogue_machine("fanuc_r2000ic");
    let at = robot.home.clone();
    let force = Vector3::new(-300.0, 200.0, -500.0);
    let load = |machine: &Machine| Wrench { force, moment: (at.pose.rotation * machine.tool_tip).cross(&force) };
    let (state, _) = settle(&robot, &at, &load(&robot));
    let names = ["platform.tool_tip.x", "platform.tool_tip.z"];
    let mut all = Sensitivities::new(&robot, &names).unwrap();
    let found = all.at(&robot, &at.drives, &state, &load, &mut Scratch::new(&robot)).unwrap();
    for (variation, found) in all.variations().zip(found) {
        let mut expected = Vector3::zeros();
        for (beside, weight) in variation.machines.iter().zip(variation.weights()) {
            let (there, _) = settle(beside, &at, &load(beside));
            expected += weight * there.pose.transform(beside.tool_tip);
        }
        let (linear, angular) = (found.twist.fixed_rows::<3>(0), found.twist.fixed_rows::<3>(3));
        let rotation = state.pose.rotation;
        let got = linear + angular.cross(&(rotation * robot.tool_tip)) + rotation * found.tool_tip;
        assert!((got - expected).amax() < 1e-8, "{}: {got} {expected}", variation.name);
        assert!(found.twist.amax() > 0.0 && found.tool_tip.amax() > 0.9);
    }
}

/// Names of parameters that can be varied, and the share of all that they are.
fn variable(machine: &Machine) -> (Vec<String>, f64) {
    let all = machine.parameters();
    // Errors of chains are of the same kinds for each; axes and travel cannot or need not be varied.
    // Bars of the catalogue are square, where the torsion formula has a kink between width and height: no solve beside is linear there.
    let is_of_use = |name: &str| !["_axis", "workspace", "home", "bar_section"].iter().any(|word| name.contains(word));
    let names: Vec<String> = all.into_iter().map(|p| p.name).filter(|name| is_of_use(name)).collect();
    let count = names.len() as f64;
    let step = names.len().div_ceil(60);
    let names: Vec<String> = names.into_iter().step_by(step).collect();
    let names: Vec<String> = names.into_iter().filter(|name| machine.variations(&[name]).is_ok()).collect();
    let share = (names.len() * step) as f64 / count;
    (names, share)
}

/// Largest difference of twists, rotations at the machine's characteristic length.
fn size(machine: &Machine, twist: &Vector6<f64>) -> f64 {
    twist.fixed_rows::<3>(0).norm() + twist.fixed_rows::<3>(3).norm() * machine.characteristic_length
}

/// Derivatives by all parameters that can be varied against the same differences of equilibria of the varied machines.
fn check_against_solves(machine: &Machine, at: &Configuration, load: &Wrench, names: &[String]) {
    let mut state = State::rigid(machine, at);
    let outcome = exactly(machine, at, load, &mut state);
    if outcome.status != Status::Solved {
        return;
    }
    let displaced = size(machine, &motion_between(&at.pose, &state.pose));
    let mut all = Sensitivities::new(machine, names).unwrap();
    let found = all.at(machine, &at.drives, &state, &|_| *load, &mut Scratch::new(machine)).unwrap();
    for (variation, found) in all.variations().zip(found) {
        let mut expected = Vector6::zeros();
        for (beside, weight) in variation.machines.iter().zip(variation.weights()) {
            let mut there = state.clone();
            let outcome = exactly(beside, at, load, &mut there);
            assert_eq!(outcome.status, Status::Solved, "{} with {}", machine.name, variation.name);
            expected += weight * motion_between(&state.pose, &there.pose);
        }
        // How far whole solves are converged, over a step; and terms that the difference neglects.
        let rounding = 1e-12 * machine.characteristic_length / variation.step;
        let off = size(machine, &(found.twist - expected));
        let allowed = rounding + 1e-6 * (size(machine, &expected) + 1e-3 * displaced / variation.step);
        assert!(
            off < allowed,
            "{}: {} by {off:e}, allowed {allowed:e}: {} instead of {expected}",
            machine.name,
            variation.name,
            found.twist
        );
    }
}

#[test]
fn derivatives_are_those_of_whole_solves_for_every_machine_of_the_catalogue() {
    for name in catalogue::names() {
        let machine = catalogue_machine(name);
        let (names, share) = variable(&machine);
        assert!(names.len() > 10 && share > 0.5, "{name}: {} parameters, {share}", names.len());
        check_against_solves(&machine, &machine.home, &Wrench::new([90.0, -150.0, -60.0, 4e3, -2e3, 3e3]), &names);
    }
}

proptest! {
    #![proptest_config(cases(8))]

    #[test]
    fn derivatives_are_those_of_whole_solves_anywhere(
        share in prop::array::uniform3(0.0..1.0f64),
        parts in prop::array::uniform6(-1.0..1.0f64),
        pick in 0..1000usize,
    ) {
        for name in catalogue::names() {
            let machine = catalogue_machine(name);
            let Ok(at) = machine.inverse_kinematics_at(position_in_box(&machine, 0.2, 0.8, share)) else { continue };
            // Square bars have a kink, see above.
            let all: Vec<_> = machine.parameters().into_iter().filter(|p| !p.name.contains("bar_section")).collect();
            let names: Vec<String> = (0..5).map(|i| all[(pick * (7 * i + 1) + 31 * i) % all.len()].name.clone()).collect();
            let mut names: Vec<String> = names.into_iter().filter(|name| machine.variations(&[name]).is_ok()).collect();
            names.sort();
            names.dedup();
            check_against_solves(&machine, &at, &wrench_from(200.0, 5e3, parts), &names);
        }
    }
}

/// Loops, rigid links, springs, weight, tools that bend: condensed as without condensation.
#[test]
fn condensed_chains_answer_as_the_whole_system_does() {
    let files = ["hybrid_3ups", "fourbar_robot", "robot_6r", "nested", "tricept", "linear_delta"];
    let files = files.map(|file| format!("tests/machines/{file}.toml"));
    for name in catalogue::names().map(String::from).chain(files) {
        let machine = catalogue_machine(&name);
        let (names, _) = variable(&machine);
        let load = Wrench::new([90.0, -150.0, -60.0, 4e3, -2e3, 3e3]);
        let (state, outcome) = settle(&machine, &machine.home, &load);
        assert_eq!(outcome.status, Status::Solved, "{name}");
        let mut all = Sensitivities::new(&machine, &names).unwrap();
        let mut answer = |mut scratch: Scratch| {
            all.at(&machine, &machine.home.drives, &state, &|_| load, &mut scratch).expect("held")
        };
        let condensed = answer(Scratch::new(&machine));
        let whole = answer(Scratch::uncondensed(&machine));
        for ((name, one), other) in names.iter().zip(condensed).zip(whole) {
            let off = size(&machine, &(one.twist - other.twist));
            let allowed = 1e-6 * size(&machine, &other.twist) + 1e-9;
            assert!(off < allowed, "{}: {name}: {} {}", machine.name, one.twist, other.twist);
        }
    }
}

#[test]
fn whole_solves_agree_for_loops_springs_and_tools_that_bend() {
    let matrix = "tool = { compliance_mm_rad_N = [\
        [2e-5, 1e-6, 0.0, 0.0, 4e-8, 0.0], [1e-6, 3e-5, 0.0, -5e-8, 0.0, 0.0], [0.0, 0.0, 5e-6, 0.0, 0.0, 1e-9], \
        [0.0, -5e-8, 0.0, 4e-10, 0.0, 0.0], [4e-8, 0.0, 0.0, 0.0, 3e-10, 0.0], [0.0, 0.0, 1e-9, 0.0, 0.0, 1e-9]] }\n";
    for (file, tool) in [("hybrid_3ups", ""), ("fourbar_robot", ""), ("robot_6r", matrix), ("linear_delta", matrix)] {
        let text = std::fs::read_to_string(format!("tests/machines/{file}.toml")).unwrap();
        let machine = machine_from(&text.replacen("[platform]\n", &format!("[platform]\n{tool}"), 1));
        assert_eq!(machine.tool_compliance.is_some(), !tool.is_empty());
        let (names, _) = variable(&machine);
        let bends = |name: &String| name.contains("tool.compliance");
        assert_eq!(names.iter().any(bends), !tool.is_empty(), "{file}: {names:?}");
        check_against_solves(&machine, &machine.home, &Wrench::new([310.0, -240.0, -420.0, 2e4, -1e4, 9e3]), &names);
    }
}

/// `dF = −K_C dt` with the platform held.
#[test]
fn a_held_platform_feels_what_the_stiffness_makes_of_the_twist() {
    let machine = catalogue_machine("orthoglide");
    let load = Wrench::new([90.0, -150.0, -60.0, 4e3, -2e3, 3e3]);
    let names = ["leg.rail.stiffness", "leg.foot.height", "material.aluminium.youngs_modulus", "x.rail.offset"];
    let (state, outcome) = settle(&machine, &machine.home, &load);
    let mut all = Sensitivities::new(&machine, &names).unwrap();
    let found = all.at(&machine, &machine.home.drives, &state, &|_| load, &mut Scratch::new(&machine)).unwrap();
    let wrench = |machine: &Machine, pose: &Pose| {
        let mut there = state.clone();
        wrench_at_pose(machine, &machine.home.drives, pose, &mut there, &mut Scratch::new(machine), &EXACT)
            .unwrap()
            .wrench
    };
    for (variation, found) in all.variations().zip(found) {
        let expected: Vector6<f64> = (variation.machines.iter().zip(variation.weights()))
            .map(|(beside, weight)| weight * wrench(beside, &state.pose).to_vector())
            .sum();
        let got = -outcome.stiffness.unwrap() * found.twist;
        assert!((got - expected).norm() < 1e-6 * expected.norm(), "{}: {got} {expected}", variation.name);
    }
}

#[test]
fn what_cannot_be_varied_is_refused_by_name() {
    let machine = catalogue_machine("orthoglide");
    for (names, expected) in [
        (&["leg.foot.heigth"][..], "leg.foot.heigth: no parameter is called so"),
        (&["leg.foot.height", "leg.foot.height"], "leg.foot.height: is named twice"),
    ] {
        let error = machine.variations(names).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    let puu = catalogue_machine("delta_3puu");
    let is_empty = |p: &kinetostat::machine::Parameter| p.unit.to_string() == "N/rad" && p.value == Some(0.0);
    let zero = puu.parameters().into_iter().find(is_empty).expect("an entry that is zero").name;
    let error = puu.variations(&[&zero]).unwrap_err().to_string();
    assert!(error.starts_with(&format!("{zero}: is 0 N/rad, from where no step is small")), "{error}");
}
