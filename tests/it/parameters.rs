//! Numbers of machines by name: all are there, each is set alone, and what is set is what the file would have said.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::support::command::{kinetostat, printed};
use crate::support::engine::settle;
use kinetostat::{
    machine::{Geometry, Grade, Machine, Parameter, catalogue},
    spatial::Wrench,
    statics::{Scratch, Settings, State, Status, equilibrium},
};
use serde_json::Value;

/// All machines of the catalogue and of `tests/machines`.
fn machines() -> Vec<Machine> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/machines");
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    assert!(files.len() > 10, "{files:?}");
    let built_in = catalogue::names().map(|name| Machine::named(name).unwrap());
    built_in.chain(files.iter().map(|file| Machine::from_file(file).unwrap_or_else(|e| panic!("{e}")))).collect()
}

fn values(machine: &Machine) -> Vec<(String, f64)> {
    machine.parameters().into_iter().map(|p| (p.name, p.value.expect("known"))).collect()
}

/// The loaded state at home, to the bit.
fn state_at_home(machine: &Machine) -> String {
    let load = Wrench::new([30.0, -20.0, -10.0, 100.0, -200.0, 50.0]);
    let mut state = State::rigid(machine, &machine.home);
    let mut scratch = Scratch::new(machine);
    let outcome = equilibrium(machine, &machine.home.drives, &load, &mut state, &mut scratch, &Settings::default());
    format!("{outcome:?} {state:?} {:?}", machine.home)
}

#[test]
fn own_values_change_nothing() {
    for machine in machines() {
        let again = machine.with_parameters(&values(&machine)).unwrap_or_else(|e| panic!("{}: {e}", machine.name));
        assert_eq!(again.parameters(), machine.parameters(), "{}", machine.name);
        assert_eq!(state_at_home(&again), state_at_home(&machine), "{}", machine.name);
    }
}

#[test]
fn one_that_is_set_changes_alone() {
    for machine in machines() {
        let before = machine.parameters();
        // The others of large machines are of the same kinds.
        let step = before.len().div_ceil(40);
        let mut changed = 0;
        for (i, parameter) in before.iter().enumerate().step_by(step) {
            let value = parameter.value.unwrap();
            let other = value + 1e-6 * value.abs().max(1.0);
            // An axis alone does not stay perpendicular to the other, a chain may no longer close.
            let Ok(machine) = machine.with_parameters(&[(&parameter.name, other)]) else { continue };
            changed += 1;
            for (j, (now, then)) in machine.parameters().iter().zip(&before).enumerate() {
                let expected = if i == j { Some(other) } else { then.value };
                assert_eq!(now.value, expected, "{}: {} by {}", machine.name, now.name, parameter.name);
            }
        }
        assert!(2 * changed * step > before.len(), "{}: {changed} of {} changed", machine.name, before.len());
    }
}

#[test]
fn names_are_told_apart_and_have_units_and_keys() {
    for machine in machines() {
        let parameters = machine.parameters();
        for (i, Parameter { name, key, unit, .. }) in parameters.iter().enumerate() {
            assert!(parameters[..i].iter().all(|other| other.name != *name), "{}: {name} twice", machine.name);
            let Some(key) = key else { continue };
            let last = key.rsplit('.').next().unwrap();
            let is_named = last == "kg" || last.contains(unit.in_files()) || last.contains("_rad");
            assert!(is_named, "{}: {name} in {unit}, {key}", machine.name);
        }
    }
}

fn named(machine: &Machine, name: &str) -> Parameter {
    machine.parameter(name).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn names_are_those_of_the_page() {
    let orthoglide = Machine::named("orthoglide").unwrap();
    for (name, value, unit, grade) in [
        ("leg.rail.stiffness", 1e6, "N/mm", Some(Grade::Assumed)),
        ("leg.foot.height", 20.0, "mm", Some(Grade::Identified)),
        ("leg.foot.length", 165.0, "mm", Some(Grade::Identified)),
        ("leg.lean.rotation.y", -45.0, "°", None),
        ("leg.q2.bar_section.width", 12.0, "mm", Some(Grade::Published)),
        ("material.aluminium.youngs_modulus", 70000.0, "N/mm²", Some(Grade::Published)),
        ("platform.tool_tip.z", 100.0, "mm", Some(Grade::Published)),
        ("gravity.z", -9.81, "m/s²", None),
        ("y.base.x_axis.y", 1.0, "", None),
        ("x.turn", 0.0, "°", None),
        ("x.base.translation.y", 0.0, "mm", None),
        ("z.end.turn.x", 0.0, "°", None),
        ("z.rail.offset", 0.0, "mm", None),
    ] {
        let found = named(&orthoglide, name);
        assert_eq!((found.value, found.unit.to_string().as_str(), found.grade), (Some(value), unit, grade), "{name}");
    }
    let robot = Machine::from_file(&file("robot_6r")).unwrap();
    for (name, value) in [
        ("arm.A2.stiffness", 6.6e9),
        ("arm.fixed_3.translation.x", 1100.0),
        ("arm.mass_4.at.x", -90.0),
        ("arm.compensator.from.at.z", 640.0),
        ("arm.compensator.preload", 0.0),
        ("platform.mass.kg", 55.0),
        ("arm.A6.offset", 0.0),
    ] {
        assert_eq!(named(&robot, name).value, Some(value), "{name}");
    }
    let hybrid = Machine::from_file(&file("hybrid_3ups")).unwrap();
    assert_eq!(named(&hybrid, "machine.module_1.leg_1.platform.position.x").value, Some(200.0));
    assert_eq!(named(&hybrid, "leg.u.home.y").value, Some(0.0));
    let puu = Machine::named("delta_3puu").unwrap();
    let entry = named(&puu, "leg.rod.stiffness.z_ry");
    assert_eq!(entry.unit.to_string(), "N/rad");
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/machines/{name}.toml"))
}

#[test]
fn a_number_that_is_set_is_the_number_of_the_file() {
    let text = fs::read_to_string(file("robot_6r")).unwrap();
    let edited = text.replace("kg = 310.0", "kg = 333.0").replace("free_length_mm = 420.0", "free_length_mm = 400.0");
    assert_ne!(text, edited);
    let by_file = Machine::from_toml(&edited, "edited").unwrap();
    let by_name = Machine::from_toml(&text, "text").unwrap();
    let by_name = by_name.with_parameters(&[("arm.mass_2.kg", 333.0), ("arm.compensator.free_length", 400.0)]).unwrap();
    assert_eq!(by_name.parameters(), by_file.parameters());
    assert_eq!(state_at_home(&by_name), state_at_home(&by_file));
}

#[test]
fn an_entry_of_a_link_is_set_on_both_sides_of_the_diagonal() {
    let puu = Machine::named("delta_3puu").unwrap();
    let value = named(&puu, "leg.rod.stiffness.y_rz").value.unwrap();
    let softer = puu.with_parameters(&[("leg.rod.stiffness.y_rz", 0.9 * value)]).unwrap();
    assert_ne!(state_at_home(&softer), state_at_home(&puu));
    let back = softer.with_parameters(&[("leg.rod.stiffness.y_rz", value)]).unwrap();
    assert_eq!(state_at_home(&back), state_at_home(&puu));
}

/// Deflection of the tool in z under 1 N.
fn deflection(machine: &Machine, nominal: &Machine) -> f64 {
    let (state, outcome) = settle(machine, &nominal.home, &Wrench::new([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]));
    assert_eq!(outcome.status, Status::Solved);
    nominal.tool_displacement(&nominal.home.pose, &state.pose).z
}

/// Under a light load a deflection is homogeneous in the stiffnesses: `Σ kᵢ ∂δ/∂kᵢ = −δ`.
#[test]
fn differences_by_stiffness_are_those_of_theory() {
    let machine = Machine::from_file(&file("kr270")).unwrap();
    let mut sum = 0.0;
    for drive in 1..=6 {
        let name = format!("arm.A{drive}.stiffness");
        let stiffness = named(&machine, &name).value.unwrap();
        let step = 1e-3 * stiffness;
        let at = |value: f64| deflection(&machine.with_parameters(&[(&name, value)]).unwrap(), &machine);
        sum += stiffness * (at(stiffness + step) - at(stiffness - step)) / (2.0 * step);
    }
    let whole = deflection(&machine, &machine);
    assert!((sum / whole + 1.0).abs() < 1e-5, "{sum} {whole}");
}

#[test]
fn errors_of_chains_are_those_of_assembly() {
    let nominal = Machine::named("orthoglide").unwrap();
    let by_name = nominal.with_parameters(&[("x.turn", 1.0), ("z.turn", -0.5)]).unwrap();
    let by_hand = nominal.with_errors(&nominal.assembly_errors(&[1.0, 0.0, -0.5]));
    let load = Wrench::new([100.0, 50.0, -30.0, 0.0, 0.0, 0.0]);
    let state = |machine: &Machine| format!("{:?}", settle(machine, &nominal.home, &load).0);
    assert_eq!(state(&by_name), state(&by_hand));
    assert_eq!(by_name.parameter_errors(), nominal.assembly_errors(&[1.0, 0.0, -0.5]));
    // Others can be set on top, and taken back.
    let moved = by_name.with_parameters(&[("y.base.translation.x", 0.3), ("y.rail.offset", 0.1)]).unwrap();
    assert_ne!(state(&moved), state(&by_name));
    let zero = [("x.turn", 0.0), ("z.turn", 0.0), ("y.base.translation.x", 0.0), ("y.rail.offset", 0.0)];
    assert_eq!(state(&moved.with_parameters(&zero).unwrap()), state(&nominal));
    assert_eq!(state(&moved.nominal().unwrap()), state(&nominal));
    // What was built in otherwise stays.
    let stiff = [("leg.rail.stiffness", 2e6)];
    let errors = nominal.assembly_errors(&[1.0, -1.0, 1.0]);
    let one = nominal.with_errors(&errors).with_parameters(&stiff).unwrap();
    let other = nominal.with_parameters(&stiff).unwrap().with_errors(&errors);
    assert_eq!(state(&one), state(&other));
}

#[test]
fn any_machine_can_be_given_a_payload() {
    for entry in catalogue::ENTRIES {
        let machine = Machine::named(entry.name).unwrap();
        let payload = [("platform.mass.kg", 12.0), ("platform.mass.at.z", 80.0)];
        let loaded = machine.with_parameters(&payload).unwrap_or_else(|e| panic!("{}: {e}", entry.name));
        let mass = loaded.platform_mass.as_ref().unwrap();
        assert_eq!((mass.kilograms, mass.at.z), (12.0, 80.0), "{}", entry.name);
        assert!(loaded.has_weight(), "{}", entry.name);
        let without = loaded.with_parameters(&[("platform.mass.kg", 0.0)]).unwrap();
        assert!(without.platform_mass.is_none(), "{}", entry.name);
    }
}

#[test]
fn a_machine_without_weight_stays_without() {
    let machine = Machine::from_file(&file("robot_6r")).unwrap();
    let changed = machine.weightless().with_parameters(&[("arm.A2.stiffness", 5e9)]).unwrap();
    assert!(!changed.has_weight() && machine.has_weight());
}

#[test]
fn what_is_unknown_becomes_known() {
    let text = fs::read_to_string(file("kr270")).unwrap().replacen("3.8e9", "\"unknown\"", 1);
    let geometry = Geometry::from_toml(&text, "robot").unwrap();
    let stiffness = geometry.parameters().into_iter().find(|p| p.name == "arm.A1.stiffness").unwrap();
    assert_eq!(stiffness.value, None);
    let known = geometry.with_parameters(&[("arm.A1.stiffness", 3.8e9)]).unwrap().machine().unwrap();
    assert_eq!(state_at_home(&known), state_at_home(&Machine::from_file(&file("kr270")).unwrap()));
    assert!(geometry.with_parameters(&[("arm.A2.stiffness", 3.8e9)]).unwrap().machine().is_err());
}

#[test]
fn what_makes_no_machine_is_refused_by_name() {
    let machine = Machine::named("orthoglide").unwrap();
    let long = "leg.foot.length, leg.foot.width, leg.foot.height and 1 more: orthoglide: home: the chains cannot be assembled here: ";
    for (set, expected) in [
        (
            &[("leg.rail.stifness", 1.0)][..],
            "leg.rail.stifness: no parameter is called so; there are: leg.rail.stiffness",
        ),
        (
            &[("leg.foot", 1.0)],
            "leg.foot: no parameter is called so; there are: leg.foot.length, leg.foot.advance, leg.foot.width, leg.foot.height",
        ),
        (&[("", 1.0)], ": no parameter is called so; there are "),
        (&[("x.turn", 1.0), ("x.turn", 2.0)], "x.turn: is set twice"),
        (&[("leg.rail.stiffness", -1.0)], "leg.rail.stiffness: must be greater than 0, got -1.0"),
        (&[("leg.rail.stiffness", f64::NAN)], "leg.rail.stiffness: must be a number between -1e18 and 1e18, got NaN"),
        (&[("x.turn", f64::INFINITY)], "x.turn: must be a number between -1e18 and 1e18, got inf"),
        (
            &[("x.turn", 45.0)],
            "x.turn: must be at most 30 deg either way, which no error of assembly exceeds, got 45.000 deg",
        ),
        (
            &[("y.base.x_axis.z", 1.0)],
            "y.base.x_axis.z: orthoglide: mount[1].base.y_axis: must be perpendicular to x_axis",
        ),
        (&[("workspace.min.x", 500.0)], "workspace.min.x: min_mm must not exceed max_mm, but along x 500 > 126.35"),
        (
            &[("gravity.x", 500.0)],
            "gravity.x: expected a magnitude of at most 100 m/s², got the vector [500.0, 0.0, -9.81]; is it in mm/s²?",
        ),
        (
            &[
                ("leg.foot.length", 100.0),
                ("leg.foot.width", 20.0),
                ("leg.foot.height", 20.0),
                ("x.base.position.y", 4000.0),
            ],
            long,
        ),
    ] {
        let found = machine.with_parameters(set).expect_err(expected).to_string();
        assert!(found.starts_with(expected), "\n  expected: {expected}\n  found:    {found}");
    }
    let found = machine.parameter("x.tune").unwrap_err().to_string();
    assert!(found.starts_with("x.tune: no parameter is called so; there are: x.turn"), "{found}");
}

// The command line.

fn refused(arguments: &[&str], message: &str) {
    let output = kinetostat(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    let found = String::from_utf8(output.stderr).unwrap();
    assert!(found.contains(message), "{arguments:?}\n  expected: {message}\n  found:    {found}");
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&printed(arguments)).unwrap()
}

#[test]
fn machines_lists_the_numbers_of_one() {
    let machine = Machine::named("orthoglide").unwrap();
    let table = printed(&["machines", "orthoglide", "--parameters"]);
    let listed = json(&["machines", "orthoglide", "--parameters", "--json"]);
    let listed = listed["parameters"].as_array().unwrap();
    assert_eq!(listed.len(), machine.parameters().len());
    for (row, parameter) in listed.iter().zip(machine.parameters()) {
        assert_eq!(row["name"], parameter.name.as_str());
        assert_eq!(row["value"].as_f64(), parameter.value, "{row}");
        assert_eq!(row["unit"], parameter.unit.in_files());
        assert_eq!(row["grade"].as_str(), parameter.grade.map(Grade::label));
        assert!(table.contains(&parameter.name), "{table}");
    }
    assert_eq!(printed(&["machines", "orthoglide"]), table);
    refused(&["machines", "--parameters"], "NAME");
}

#[test]
fn a_point_is_solved_with_numbers_that_are_set() {
    let at = |more: &[&str]| {
        json(&[&["point", "--machine", "orthoglide", "--at", "Q1", "--phi", "130", "--json"][..], more].concat())
    };
    let turned = at(&["--set", "x.turn=1", "--set", "y.turn=-1", "--set", "z.turn=1"]);
    let assembled = at(&["--chain-errors", "1,-1,1"]);
    assert_eq!(turned["loaded"], assembled["loaded"]);
    assert_eq!(turned["compensated"], assembled["compensated"]);
    assert_eq!(turned["set"]["y.turn"], -1.0);
    assert!(assembled.get("set").is_none());
    let edited = printed(&["machines", "--show", "orthoglide"]).replace("height_mm = 20.0", "height_mm = 25.0");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("edited.toml");
    fs::write(&file, edited).unwrap();
    let mut by_name = at(&["--set", "leg.foot.height=25"]);
    let by_file = json(&["point", "--machine", file.to_str().unwrap(), "--at", "Q1", "--phi", "130", "--json"]);
    by_name.as_object_mut().unwrap().remove("set");
    assert_eq!(by_name, by_file);
    let text =
        printed(&["point", "--machine", "orthoglide", "--at", "Q1", "--phi", "0", "--set", "leg.foot.height=25"]);
    assert!(text.starts_with("with leg.foot.height = 25\n"), "{text}");
}

#[test]
fn unknown_stiffness_is_asked_for_until_it_is_set() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bad_input/machines/stiffness_unknown.toml");
    let point = ["point", "--machine", file, "--at", "centre", "--wrench", "10,0,0,0,0,0"];
    let asked = "chain[0].elements[1].prismatic_drive.stiffness_N_per_mm of drive y, \
                 chain[0].elements[2].prismatic_drive.stiffness_N_per_mm of drive z: unknown, expected a number";
    refused(&point, asked);
    let set = ["--set", "arm.y.stiffness=1e5"];
    refused(&[&point[..], &set].concat(), "prismatic_drive.stiffness_N_per_mm of drive z: unknown, expected a number");
    refused(&["check", file], asked);
    let all = [&set[..], &["--set", "arm.z.stiffness=1e5"]].concat();
    printed(&[&point[..], &all].concat());
    printed(&[&["check", file][..], &all].concat());
    let list = kinetostat(&["machines", file, "--parameters"]);
    let list = String::from_utf8(list.stdout).unwrap();
    assert!(list.lines().any(|line| line.contains("arm.y.stiffness") && line.contains("unknown")), "{list}");
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let point = ["point", "--machine", "orthoglide", "--at", "Q1", "--set"];
    let with = |set: &'static str, message: &str| refused(&[&point[..], &[set]].concat(), message);
    with("leg.foot.hight=3", "--set: leg.foot.hight: no parameter is called so; there are: leg.foot.height");
    with("leg.foot.height", "\"leg.foot.height\" is not of the form NAME=VALUE");
    with("leg.foot.height=much", "\"much\" is not a number");
    with("leg.foot.height=-3", "--set: leg.foot.height: must be greater than 0, got -3.0");
    refused(
        &[&point[..], &["x.turn=1", "--chain-errors", "1,0,0"]].concat(),
        "--set: errors of chains are given by --chain-errors or by --set, not by both",
    );
    refused(
        &["check", "orthoglide", "--set", "x.turn=1"],
        "--set: check looks at the machine without errors of its chains: set numbers of its file",
    );
    assert_ne!(printed(&["check", "orthoglide", "--set", "leg.foot.height=25"]), printed(&["check", "orthoglide"]));
}
