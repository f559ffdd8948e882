//! The same machine written in two ways has the same answers: chains as the ways of a module, springs between points as
//! sprung joints, masses of the platform as masses of its chain, drives with shown coordinates as drives without.

use crate::support::{
    balance::{assert_balanced, drives_by_chain},
    engine::{EXACT, machine_from, motion_between},
    machines::{machine_file, places, share, some_load},
};
use kinetostat::{
    machine::{ChainError, Configuration, Machine, catalogue},
    spatial::Wrench,
    statics::{Outcome, Scratch, State, Status, aggregate_errors, drive_force_sensitivity, drive_forces, equilibrium},
};
use nalgebra::{DMatrix, Matrix6};
use toml::{Table, Value};

fn table_of(name: &str) -> Table {
    let file = format!("{}/tests/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(file);
    text.unwrap_or_else(|_| catalogue::find(name).unwrap().toml.into()).parse().unwrap()
}

fn value(text: &str) -> Value {
    format!("x = {text}").parse::<Table>().unwrap()["x"].clone()
}

fn machine(table: &Table) -> Machine {
    machine_from(&toml::to_string(table).unwrap())
}

fn array<'a>(table: &'a mut Table, key: &str) -> &'a mut Vec<Value> {
    table.get_mut(key).unwrap().as_array_mut().unwrap()
}

/// The machine as one chain that is a module of its chains.
fn as_module(mut table: Table) -> Table {
    let mounts = std::mem::replace(array(&mut table, "mount"), vec![value(r#"{ name = "all", chain = "all" }"#)]);
    let mut chain = value(r#"{ name = "all", elements = [{ module = { mounts = [] } }] }"#);
    chain["elements"][0]["module"]["mounts"] = Value::Array(mounts);
    array(&mut table, "chain").push(chain);
    table
}

/// With a mass on the platform, and one behind each element of the chains.
fn with_masses(mut table: Table) -> Table {
    table["platform"]
        .as_table_mut()
        .unwrap()
        .insert("mass".into(), value("{ kg = 60.0, at_mm = [20.0, -30.0, 80.0] }"));
    table.insert("gravity_m_per_s2".into(), value("[2.0, -3.0, -9.0]"));
    for (number, chain) in array(&mut table, "chain").iter_mut().enumerate() {
        let elements = chain["elements"].as_array_mut().unwrap();
        let hung = std::mem::take(elements).into_iter().enumerate().flat_map(|(i, element)| {
            let mass = format!(
                "{{ mass = {{ kg = {:?}, at_mm = [30.0, {:?}, -25.0] }} }}",
                5.0 + number as f64,
                10.0 * i as f64
            );
            [element, value(&mass)]
        });
        *elements = hung.collect();
    }
    table
}

struct Solved {
    state: State,
    outcome: Outcome,
    forces: Vec<f64>,
    force_sensitivity: Option<DMatrix<f64>>,
}

fn solve(machine: &Machine, at: &Configuration, load: &Wrench) -> Solved {
    let (mut state, mut scratch) = (State::rigid(machine, at), Scratch::new(machine));
    let outcome = equilibrium(machine, &at.drives, load, &mut state, &mut scratch, &EXACT);
    let forces = drive_forces(machine, &state);
    let twists = &outcome.drive_sensitivity;
    let force_sensitivity = drive_force_sensitivity(machine, &at.drives, &state, twists, &mut scratch);
    Solved { state, outcome, forces, force_sensitivity }
}

fn assert_close(what: &str, got: &[f64], expected: &[f64], allowed: f64) {
    assert_eq!(got.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(1e-12f64, |most, v| most.max(v.abs()));
    for (i, (a, b)) in got.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= allowed * scale, "{what}[{i}]: {a} against {b}, of {scale}");
    }
}

fn assert_same(what: &str, machine: &Machine, got: &Solved, expected: &Solved) {
    assert_eq!(got.outcome.status, expected.outcome.status, "{what}");
    let off = motion_between(&expected.state.pose, &got.state.pose);
    assert!(off.amax() < 1e-8, "{what}: pose off by {off}");
    let reach = machine.characteristic_length;
    for (kind, a, b, lever) in [
        ("stiffness", got.outcome.stiffness, expected.outcome.stiffness, 1.0 / reach),
        ("compliance", got.outcome.compliance, expected.outcome.compliance, reach),
    ] {
        assert_eq!(a.is_some(), b.is_some(), "{what}: {kind}");
        if let (Some(a), Some(b)) = (a, b) {
            let scaled = |m: &Matrix6<f64>| {
                let lever = |i: usize| if i < 3 { 1.0 } else { lever };
                Matrix6::from_fn(|i, j| m[(i, j)] * lever(i) * lever(j))
            };
            assert_close(&format!("{what}: {kind}"), scaled(&a).as_slice(), scaled(&b).as_slice(), 1e-7);
        }
    }
    let sensitivity = expected.outcome.drive_sensitivity.as_slice();
    assert_close(&format!("{what}: drive sensitivity"), got.outcome.drive_sensitivity.as_slice(), sensitivity, 1e-7);
    assert_close(&format!("{what}: drive forces"), &got.forces, &expected.forces, 1e-7);
    let stiffest = machine.drives().map(|(_, drive)| drive.stiffness).fold(0.0, f64::max);
    if let (Some(a), Some(b)) = (&got.force_sensitivity, &expected.force_sensitivity) {
        let off = (a - b).amax();
        assert!(off < 1e-8 * stiffest, "{what}: force sensitivity off by {off:e} of {stiffest:e}");
    }
}

#[test]
fn a_module_is_the_machine_of_its_chains() {
    for (name, newtons) in
        [("orthoglide", 200.0), ("tripteron", 200.0), ("hexapod", 2000.0), ("tricept", 1500.0), ("linear_delta", 700.0)]
    {
        for is_heavy in [false, true] {
            let table = if is_heavy { with_masses(table_of(name)) } else { table_of(name) };
            let (apart, as_one) = (machine(&table), machine(&as_module(table)));
            assert_eq!(as_one.chains.len(), 1);
            for (seed, at) in places(&apart, 3).iter().enumerate() {
                let load = some_load(&apart, newtons, seed);
                let there = as_one.forward_kinematics(&at.drives).unwrap_or_else(|e| panic!("{name}: {e}"));
                let what = format!("{name}, heavy: {is_heavy}, place {seed}");
                assert!(motion_between(&at.pose, &there.pose).amax() < 1e-8, "{what}");
                let (expected, got) = (solve(&apart, at, &load), solve(&as_one, &there, &load));
                assert_eq!(expected.outcome.status, Status::Solved, "{what}");
                assert_same(&what, &apart, &got, &expected);
                assert_balanced(&as_one, &at.drives, &load, &got.state);
            }
        }
    }
}

/// A robot whose gravity compensator is a spring between points, and one that has it as a leg with a sprung joint beside
/// the shoulder.
#[test]
fn a_spring_between_points_is_a_leg_with_a_sprung_joint() {
    let table = table_of("robot_6r");
    let mut as_leg = table.clone();
    let elements = array(&mut as_leg, "chain")[0]["elements"].as_array_mut().unwrap();
    let named = |elements: &[Value], name: &str| {
        elements.iter().position(|e| e.get("frame").and_then(Value::as_str) == Some(name)).unwrap()
    };
    let (column, arm) = (named(elements, "column"), named(elements, "arm"));
    let spring = elements.iter().position(|e| e.get("spring").is_some()).unwrap();
    let after: Vec<Value> = elements.drain(arm + 1..spring).collect();
    let shoulder: Vec<Value> = elements.drain(column + 1..arm).collect();
    elements.truncate(column);
    let module = r#"{ module = { mounts = [
        { name = "shoulder", chain = "shoulder" },
        { name = "compensator", chain = "compensator", base = { position_mm = [-360.0, 0.0, 640.0] }, platform = { position_mm = [-70.0, 0.0, 170.0] } },
    ] } }"#;
    elements.push(value(&module.replace('\n', " ")));
    elements.extend(after);
    // From (−360, 640) to where the point of the arm is at home, in the plane of the shoulder.
    let angle = -10.0f64.to_radians();
    let (x, z) = (350.0 - 70.0 * angle.cos() + 170.0 * angle.sin(), 750.0 + 70.0 * angle.sin() + 170.0 * angle.cos());
    let (dx, dz) = (x + 360.0, z - 640.0);
    let tilt = dx.atan2(dz).to_degrees();
    let leg = format!(
        r#"{{ name = "compensator", elements = [
            {{ universal_joint = {{ name = "u", axes = ["y", "x"], home_deg = [{tilt:?}, 0.0] }} }},
            {{ prismatic_joint = {{ name = "length", axis = "z", home_mm = {:?}, stiffness_N_per_mm = 80.0, neutral_mm = 420.0 }} }},
            {{ spherical_joint = {{ name = "s", home_deg = [0.0, {:?}, 0.0] }} }},
        ] }}"#,
        dx.hypot(dz),
        -10.0 - tilt,
    );
    let chains = array(&mut as_leg, "chain");
    let mut swing = value(r#"{ name = "shoulder", elements = [] }"#);
    swing["elements"] = Value::Array(shoulder);
    chains.extend([swing, value(&leg.replace('\n', " "))]);
    let (with_spring, with_leg) = (machine(&table), machine(&as_leg));
    assert_eq!(with_leg.chains[0].route.loops.len(), 1);
    for (seed, at) in places(&with_spring, 6).iter().enumerate() {
        let there = with_leg.forward_kinematics(&at.drives).unwrap();
        let load = some_load(&with_spring, 2000.0, seed);
        let (expected, got) = (solve(&with_spring, at, &load), solve(&with_leg, &there, &load));
        assert_eq!(expected.outcome.status, Status::Solved);
        assert_same(&format!("place {seed}"), &with_spring, &got, &expected);
    }
}

#[test]
fn what_moves_with_the_platform_may_hang_on_its_chain() {
    for name in ["robot_6r", "fourbar_robot"] {
        let table = table_of(name);
        let mut moved = table.clone();
        let mass = moved["platform"].as_table_mut().unwrap().remove("mass").unwrap();
        let chains = array(&mut moved, "chain");
        let own = chains.iter_mut().find(|chain| chain["name"].as_str() == Some("arm")).unwrap();
        let mut element = value("{ mass = 0 }");
        element["mass"] = mass;
        own["elements"].as_array_mut().unwrap().push(element);
        let (on_platform, on_chain) = (machine(&table), machine(&moved));
        for (seed, at) in places(&on_platform, 4).iter().enumerate() {
            let load = some_load(&on_platform, 2000.0, seed);
            let (expected, got) = (solve(&on_platform, at, &load), solve(&on_chain, at, &load));
            assert_eq!(expected.outcome.status, Status::Solved);
            assert_same(&format!("{name}, place {seed}"), &on_platform, &got, &expected);
        }
    }
}

/// A mass at P is a dead load there, gravity or no gravity.
#[test]
fn a_mass_at_the_platform_point_is_a_force() {
    for name in ["hexapod", "orthoglide", "kr270"] {
        let mut table = table_of(name);
        let light = machine(&table);
        table["platform"].as_table_mut().unwrap().insert("mass".into(), value("{ kg = 50.0 }"));
        table.insert("gravity_m_per_s2".into(), value("[3.0, -5.0, -8.0]"));
        let heavy = machine(&table);
        for (seed, at) in places(&light, 3).iter().enumerate() {
            let load = some_load(&light, 300.0, seed);
            let mut with_weight = load;
            with_weight.force += heavy.gravity * 50.0;
            let (expected, got) = (solve(&light, at, &with_weight), solve(&heavy, at, &load));
            assert_same(&format!("{name}, place {seed}"), &light, &got, &expected);
        }
    }
}

#[test]
fn a_machine_without_gravity_is_one_without_masses() {
    for name in ["robot_6r_plain", "fourbar_robot"] {
        let mut table = table_of(name);
        let weightless = machine(&table).weightless();
        assert!(!weightless.has_weight() && machine(&table).has_weight());
        table["platform"].as_table_mut().unwrap().remove("mass");
        for chain in array(&mut table, "chain") {
            chain["elements"].as_array_mut().unwrap().retain(|element| element.get("mass").is_none());
        }
        let massless = machine(&table);
        for (seed, at) in places(&weightless, 3).iter().enumerate() {
            let load = some_load(&weightless, 2000.0, seed);
            let (expected, got) = (solve(&massless, at, &load), solve(&weightless, at, &load));
            assert_eq!(expected.outcome.status, Status::Solved);
            assert_same(&format!("{name}, place {seed}"), &massless, &got, &expected);
        }
    }
    let machine = machine_file("hybrid_3ups");
    let rigid = State::rigid(&machine, &machine.home);
    let mut state = rigid.clone();
    let weightless = machine.weightless();
    let drives = &machine.home.drives;
    let outcome = equilibrium(&weightless, drives, &Wrench::zero(), &mut state, &mut Scratch::new(&weightless), &EXACT);
    assert_eq!((outcome.status, outcome.iterations), (Status::Solved, 0));
}

#[test]
fn offsets_of_drives_in_a_module_are_those_of_the_machine_of_its_chains() {
    for (name, size) in [("hexapod", 0.3), ("orthoglide", 0.2), ("tricept", 0.3)] {
        let table = with_masses(table_of(name));
        let (apart, as_one) = (machine(&table), machine(&as_module(table)));
        let offsets: Vec<f64> = (0..apart.drive_count()).map(|i| size * share(i, 3)).collect();
        let error = |offsets: &[f64]| ChainError { drive_offsets: offsets.to_vec(), ..ChainError::default() };
        let own = drives_by_chain(&apart, &offsets).into_iter().map(error).collect::<Vec<_>>();
        let (actual, real_as_one) = (apart.with_errors(&own), as_one.with_errors(&[error(&offsets)]));
        for (seed, at) in places(&apart, 3).iter().enumerate() {
            let load = some_load(&apart, 200.0, seed);
            let there = as_one.forward_kinematics(&at.drives).unwrap();
            let (expected, got) = (solve(&actual, at, &load), solve(&real_as_one, &there, &load));
            let what = format!("{name}, place {seed}");
            assert_same(&what, &apart, &got, &expected);
            assert_balanced(&real_as_one, &at.drives, &load, &got.state);
            let aggregated = |nominal: &Machine, actual: &Machine, at: &Configuration| {
                aggregate_errors(nominal, actual, at, &mut Scratch::new(nominal)).map(|twist| twist.to_vector())
            };
            if let Some(expected) = aggregated(&apart, &actual, at) {
                let got = aggregated(&as_one, &real_as_one, &there).unwrap();
                // Finite errors of two machines agree to first order.
                let off = (got - expected).amax();
                assert!(off < 2e-3 * expected.amax(), "{what}: aggregate off by {off:e}: {got} {expected}");
            }
        }
    }
}
