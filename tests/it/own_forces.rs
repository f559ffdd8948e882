//! Springs and weight that move a machine without a load: what each source is, and that all commands say the same of a place.

use crate::support::command::told;
use crate::support::engine::*;
use kinetostat::{
    compensation::{Method, Session, Target, TaskPoint, compensate},
    inspect::{
        machine_check,
        point::{NominalCommand, PointLoad, PointQuestion, solve},
    },
    machine::Machine,
    simulation::{Machines, Source, settings},
    spatial::Wrench,
};
use nalgebra::Vector3;

/// What `check` finds of a machine without bodies in files.
fn check(machine: &Machine) -> machine_check::Findings {
    machine_check::check(machine).unwrap()
}

/// A slide along z under 100 kg, and a spring from above that bears more than that.
fn balanced(zeroed: &str, kilograms: f64) -> String {
    format!(
        r#"
schema = 1
name = "balanced"
title = "A slide and a spring"
zeroed = "{zeroed}"
[platform]
tool_tip_mm = [0.0, 0.0, 0.0]
controls = ["z"]
mass = {{ kg = {kilograms}, at_mm = [0.0, 0.0, 0.0] }}
[home]
position_mm = [0.0, 0.0, 100.0]
[workspace]
min_mm = [0.0, 0.0, 90.0]
max_mm = [0.0, 0.0, 110.0]
[[chain]]
name = "z"
elements = [
  {{ prismatic_drive = {{ name = "Z", axis = "z", stiffness_N_per_mm = 1000.0, home_mm = 100.0, travel_mm = [0.0, 200.0] }} }},
  {{ frame = "s" }},
  {{ spring = {{ name = "bal", from = {{ frame = "O", at_mm = [0.0, 0.0, 1100.0] }}, to = {{ frame = "s" }}, stiffness_N_per_mm = 1.0, free_length_mm = 500.0, preload_N = 500.0 }} }},
]
[[mount]]
name = "z"
chain = "z"
"#
    )
}

fn moved(machines: &Machines, source: Source, position: [f64; 3], force: [f64; 3]) -> f64 {
    let load = Wrench { force: force.into(), moment: Vector3::zeros() };
    let pose = machines.nominal.pose_at(position.into());
    let task = TaskPoint::new(pose, load, Target::ToolTip);
    let mut session = machines.session(source);
    let answer = compensate(&mut session, &source.task(&task), Method::None);
    assert!(answer.status.is_success(), "{:?}", answer.status);
    answer.tool_displacement.z
}

#[test]
fn a_preloaded_spring_is_neither_cutting_nor_chain_errors() {
    // Forces of weight and spring at a place z, and the stiffness of both springs.
    let own = |kilograms: f64, z: f64| (1000.0 - (z - 100.0) - 500.0 + 500.0 - 9.81 * kilograms) / 1001.0;
    for (zeroed, kilograms) in [("at_rest", 100.0), ("weightless", 100.0), ("at_home", 100.0), ("weightless", 1e-9)] {
        let machine = machine_from(&balanced(zeroed, kilograms));
        let machines = Machines::new(&machine, &machine.assembly_errors(&[0.0])).unwrap();
        for z in [95.0, 100.0, 108.0] {
            let at = |source, force| moved(&machines, source, [0.0, 0.0, z], [0.0, 0.0, force]);
            let cutting = at(Source::Cutting, -100.0);
            assert!((cutting + 100.0 / 1001.0).abs() < 1e-9, "{zeroed} {z}: cutting {cutting}");
            assert!(at(Source::Geometry, -100.0).abs() < 1e-9, "{zeroed} {z}: no chain errors");
            let here = if zeroed == "at_home" { own(kilograms, z) - own(kilograms, 100.0) } else { own(kilograms, z) };
            assert!((at(Source::Weight, 0.0) - here).abs() < 1e-9, "{zeroed} {z}: {} {here}", at(Source::Weight, 0.0));
            let parts: f64 = Source::parts(&machine).iter().map(|part| at(*part, -100.0)).sum();
            assert!((parts - at(Source::All, -100.0)).abs() < 1e-9, "{zeroed} {z}: the machine is linear");
        }
    }
}

#[test]
fn a_machine_with_springs_alone_says_so() {
    let text = balanced("weightless", 1.0).replace("mass = { kg = 1, at_mm = [0.0, 0.0, 0.0] }\n", "");
    let machine = machine_from(&text);
    assert_eq!(machine.own_load_text(), Some("springs"));
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("machine.toml"), text).unwrap();
    let study = "schema = 3\nquestion = \"How far?\"\nmachine = \"machine.toml\"\n[process.force.path_frame]\n\
                 radial_force_N = 0.0\ntangential_force_N = 0.0\naxial_force_N = -100.0\n\
                 [workspace_map]\ngrid = [1, 1, 3]\nslices_z_mm = [100.0]\nphi_step_deg = 180.0\n";
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let (code, said, _) = told(&[
        "run",
        "--verbose",
        folder.path().to_str().unwrap(),
        "--out",
        folder.path().join("out").to_str().unwrap(),
    ]);
    assert_eq!(code, Some(0), "{said}");
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("are measured from the rigid model, without springs (zeroed = \"weightless\")"), "{said}");
    assert!(said.contains("The cutting force alone moves the tool by 0.100 mm"), "{said}");
    assert!(said.contains("The machine's springs alone move the tool by 0.989 mm"), "{said}");
    assert!(!said.contains("Chain errors alone"), "{said}");
}

#[test]
fn every_method_works_with_a_tool_that_bends() {
    for name in ["orthoglide", "kr270"] {
        let mut machine = Machine::named(name).unwrap();
        let stiffer = [1e-3, 1e-3, 1e-4, 1e-8, 1e-8, 1e-8];
        machine.tool_compliance = Some(Box::new(nalgebra::Matrix6::from_diagonal(&stiffer.into())));
        let home = machine.home.clone();
        let load = Wrench { force: Vector3::new(150.0, -80.0, 60.0), moment: Vector3::zeros() }
            .shift(-(home.pose.rotation * machine.tool_tip));
        let task = TaskPoint::new(home.pose, load, Target::ToolTip);
        let direct = compensate(&mut Session::new(&machine, &machine, settings()), &task, Method::Direct);
        assert!(direct.status.is_success());
        for method in [Method::Newton, Method::FixedMatrix { alpha: 1.0 }, Method::MatrixFree { alpha: 1.0 }] {
            let found = compensate(&mut Session::new(&machine, &machine, settings()), &task, method);
            assert!(found.status.is_success(), "{name} {method:?}: {:?}", found.status);
            for (a, b) in found.drives.iter().zip(&direct.drives) {
                assert!((a - b).abs() < 1e-6, "{name} {method:?}: {a} {b}");
            }
        }
    }
}

fn question(machine: &Machine, place: NominalCommand, load: Wrench) -> PointQuestion {
    let errors = machine.assembly_errors(&vec![0.0; machine.chains.len()]);
    PointQuestion {
        machines: Machines::new(machine, &errors).unwrap(),
        machine: machine.clone(),
        errors,
        place,
        load: PointLoad::Wrench(load),
        target: Target::ToolTip,
    }
}

#[test]
fn drives_to_spare_stay_where_they_are_asked_for() {
    let machine = machine_from(include_str!("../machines/kr270_cell.toml"));
    let mut drives = machine.home.drives.clone();
    drives[0] = 400.0;
    drives[1] = 0.2;
    let load = Wrench { force: Vector3::new(0.0, 0.0, -1.0), moment: Vector3::zeros() };
    let answer = solve(&question(&machine, NominalCommand::Drives(drives.clone()), load)).unwrap();
    let compensated = answer.compensated.unwrap();
    for (rho, asked) in compensated.drives.iter().zip(&drives) {
        assert!((rho - asked).abs() < 0.5, "{rho} {asked}");
    }
}

#[test]
fn an_orientation_that_cannot_be_had_is_refused() {
    let (code, said, _) = told(&["point", "-m", "orthoglide", "--pose", "0,0,0,0,90,20", "--wrench", "10,0,0,0,0,0"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("unreachable: orientation: ")
            && said.contains(
                "degrees from that of the platform there, roll, pitch and yaw (0, 0, 0); the machine controls x, y, z"
            ),
        "{said}"
    );
    let (code, ..) = told(&["point", "-m", "orthoglide", "--pose", "0,0,0,0,0,0", "--wrench", "10,0,0,0,0,0"]);
    assert_eq!(code, Some(0));
}

#[test]
fn a_singular_wrist_is_at_its_singularity() {
    let machine = Machine::named("kr270").unwrap();
    for first in [0.0, 0.3] {
        let drives = [first, -1.0, 1.7, 0.0, 0.0, 0.0];
        let at = machine.forward_kinematics(&drives).unwrap();
        assert_eq!(machine.conditioning(&at), 0.0);
        let mut beside = drives;
        beside[4] = 1e-3;
        let near = machine.conditioning(&machine.forward_kinematics(&beside).unwrap());
        assert!(near > 0.0 && near < 1e-3, "{near}");
    }
}

#[test]
fn a_serial_arm_has_no_internal_force() {
    let machine = Machine::named("fanuc_r2000ic").unwrap();
    let drives = machine.home.drives.clone();
    let answer = solve(&question(&machine, NominalCommand::Drives(drives), Wrench::zero())).unwrap();
    let chain = &answer.loaded.chains[0];
    let internal = chain.internal_wrench.unwrap().norm(machine.characteristic_length);
    assert!(internal < 1e-6 && chain.wrench.force.norm() > 100.0, "{internal} {}", chain.wrench.force.norm());
}

/// A rod on a revolute joint about y with a mass at its end.
fn rod(stiffness: f64, more: &str) -> String {
    format!(
        r#"
schema = 1
name = "rod"
title = "A rod that stands on a revolute joint"
[platform]
tool_tip_mm = [0.0, 0.0, 0.0]
controls = ["x"]
{more}
[home]
position_mm = [0.0, 0.0, 1000.0]
[workspace]
min_mm = [-10.0, 0.0, 1000.0]
max_mm = [10.0, 0.0, 1000.0]
[[chain]]
name = "rod"
elements = [
  {{ revolute_drive = {{ name = "B", axis = "y", stiffness_Nmm_per_rad = {stiffness:e}, torque_limit_Nmm = 1e6 }} }},
  {{ fixed = {{ translation_mm = [0.0, 0.0, 1000.0] }} }},
]
[[mount]]
name = "rod"
chain = "rod"
"#
    )
}

#[test]
fn a_machine_that_falls_over_has_no_droop_but_a_warning() {
    let findings = check(&machine_from(&rod(1e6, "mass = { kg = 1000.0, at_mm = [0.0, 0.0, 0.0] }")));
    let droop = findings.survey.unwrap().droop.unwrap();
    assert!(droop.range_mm[0].is_infinite() && droop.without.is_some());
    assert!(
        findings.warnings.iter().any(|warning| warning.contains("no stable equilibrium")),
        "{:?}",
        findings.warnings
    );
}

#[test]
fn a_tip_on_the_only_axis_is_rigid_and_has_no_shares() {
    let text = rod(1e6, "")
        .replace("controls = [\"x\"]", "controls = [\"rotation_z\"]")
        .replace("axis = \"y\"", "axis = \"z\"");
    let machine = machine_from(&text);
    let findings = check(&machine);
    assert!(findings.tool_stiffness.is_none_or(|principal| principal.iter().all(|k| k.is_infinite())));
    assert!(findings.compliance_shares.is_empty());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rod.toml");
    std::fs::write(&file, text).unwrap();
    let (_, said, _) = told(&["check", file.to_str().unwrap()]);
    assert!(!said.contains("NaN") && !said.contains("inf") && said.contains("rigid"), "{said}");
}

#[test]
fn a_program_at_home_is_right_as_it_is_for_a_machine_zeroed_there() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let program = "x_mm,y_mm,z_mm\n0,0,100.0000\n0,0,108.0000\n";
    std::fs::write(file("path.csv"), program).unwrap();
    std::fs::write(file("machine.toml"), balanced("at_home", 100.0)).unwrap();
    let process =
        "schema = 1\n[force.path_frame]\nradial_force_N = 0.0\ntangential_force_N = 0.0\naxial_force_N = 0.0\n";
    std::fs::write(file("process.toml"), process).unwrap();
    let [path, machine, process, out] = ["path.csv", "machine.toml", "process.toml", "out.csv"].map(file);
    let (code, text, said) = told(&["compensate", &path, "--machine", &machine, "--process", &process, "--out", &out]);
    assert_eq!(code, Some(0), "{text}{said}");
    let written = std::fs::read_to_string(&out).unwrap();
    let heights: Vec<&str> = written.lines().skip(1).map(|line| line.rsplit(',').next().unwrap()).collect();
    assert_eq!(heights.first(), Some(&"100.0000"));
    // 8 mm higher the spring pulls with 8 N less, and the prismatic joint gives 8/1001 mm.
    let last: f64 = heights.last().unwrap().parse().unwrap();
    assert!((last - (108.0 + 8.0 / 1000.0)).abs() < 2e-4, "{last}");
}
