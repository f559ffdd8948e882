//! Branches of six-axis arms: all of them at a pose, in agreement with another program's closed form; the one that is chosen and kept;
//! paths that would change it.

use std::{collections::HashSet, f64::consts::FRAC_PI_2};

use crate::support::cases::cases;
use crate::support::command::told;
use crate::support::{engine::*, machines::machine_file};
use kinetostat::{
    compensation::{Method, Target, TaskPoint},
    machine::{Branch, Configuration, Elbow, Machine, Posture, Shoulder, Wrist},
    questions::{Overrides, Study, StudyKind},
    simulation::along_path::{Commands, PathCase, run},
    spatial::{Pose, Wrench, rotation_log},
};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use rs_opw_kinematics::{
    glam::{DMat3, DQuat, DVec3},
    kinematic_traits::{Kinematics, Pose as OpwPose},
    kinematics_impl::OPWKinematics,
    parameters::opw_kinematics::Parameters,
};

/// An arm of the catalogue, with its lengths as the other program takes them: m; offsets of joints 2 and 3.
struct Arm {
    name: &'static str,
    lengths: [f64; 6],
    offsets: [f64; 2],
}

const ARMS: [Arm; 4] = [
    Arm { name: "kr270", lengths: [0.35, 0.041, 0.675, 1.15, 1.2, 0.24], offsets: [-FRAC_PI_2, 0.0] },
    Arm { name: "kr500", lengths: [0.5, 0.055, 1.045, 1.3, 1.025, 0.377], offsets: [-FRAC_PI_2, 0.0] },
    Arm { name: "irb7600", lengths: [0.41, -0.165, 0.78, 1.075, 1.056, 0.25], offsets: [0.0, -FRAC_PI_2] },
    Arm { name: "fanuc_r2000ic", lengths: [0.312, -0.225, 0.67, 1.075, 1.28, 0.215], offsets: [0.0, -FRAC_PI_2] },
];

impl Arm {
    fn machine(&self) -> Machine {
        catalogue_machine(self.name)
    }

    fn other_program(&self) -> OPWKinematics {
        let [a1, a2, c1, c2, c3, c4] = self.lengths;
        let [second, third] = self.offsets;
        let offsets = [0.0, second, third, 0.0, 0.0, 0.0];
        let sign_corrections = [1; 6];
        OPWKinematics::new(Parameters { a1, a2, b: 0.0, c1, c2, c3, c4, offsets, sign_corrections, dof: 6 })
    }
}

/// Angles of the joints, not of what a pendant shows.
fn joints(machine: &Machine, at: &Configuration) -> [f64; 6] {
    let chain = &machine.chains[0];
    let offset = |joint: usize| chain.coupling.as_ref().map_or(0.0, |coupling| coupling.offset[joint]);
    let first = chain.drives.len() - 6;
    std::array::from_fn(|joint| {
        let moved = (0..at.drives.len()).map(|d| chain.joint_per_drive(first + joint, d) * at.drives[d]);
        moved.sum::<f64>() + offset(first + joint)
    })
}

fn opw(pose: &Pose) -> OpwPose {
    let rotation = DMat3::from_cols_slice(pose.rotation.as_slice());
    let [x, y, z]: [f64; 3] = (pose.translation * 1e-3).into();
    OpwPose::from_parts(DVec3::new(x, y, z), DQuat::from_mat3(&rotation))
}

fn from_opw(pose: &OpwPose) -> Pose {
    let translation = Vector3::from(pose.translation.to_array()) * 1e3;
    Pose { rotation: Matrix3::from_column_slice(&DMat3::from_quat(pose.rotation).to_cols_array()), translation }
}

fn apart(one: f64, other: f64) -> f64 {
    (one - other).sin().atan2((one - other).cos()).abs()
}

/// Where a machine stands with its drives at shares of their travel.
fn somewhere(machine: &Machine, shares: [f64; 6]) -> Configuration {
    let drives: Vec<f64> = machine
        .drives()
        .zip(shares)
        .map(|((_, drive), share)| {
            let (low, high) = drive.travel.unwrap();
            low + (high - low) * share
        })
        .collect();
    machine.forward_kinematics(&drives).unwrap()
}

/// Largest error of `posture` at `target`: mm and rad, by forward kinematics from it.
fn error(machine: &Machine, posture: &Posture, target: &Pose) -> (f64, f64) {
    let back = machine.forward_kinematics_from(&posture.at, &posture.at.drives).unwrap().pose;
    let turn = rotation_log(&(back.rotation * target.rotation.transpose())).norm();
    ((back.translation - target.translation).norm(), turn)
}

/// Whether no singularity is so near that rounding is magnified.
fn is_regular(machine: &Machine, at: &Configuration) -> bool {
    let clearance = machine.clearance(at).unwrap();
    let bent = |degrees: f64| degrees.to_radians().sin().abs() > 0.02;
    clearance.shoulder_mm.abs() > 20.0 && bent(clearance.elbow_deg) && bent(clearance.wrist_deg)
}

proptest! {
    #![proptest_config(cases(60))]

    /// Ours against rs-opw-kinematics: the same joints on every branch, to 1e-9 rad.
    #[test]
    fn all_branches_agree_with_another_closed_form(arm in 0..ARMS.len(), shares in prop::array::uniform6(0.0..1.0)) {
        let (arm, machine) = (&ARMS[arm], ARMS[arm].machine());
        let other = arm.other_program();
        let at = somewhere(&machine, shares);
        prop_assume!(is_regular(&machine, &at));
        // Their flange has other axes than our P.
        let zero: Vec<f64> = vec![0.0; 6];
        let tool = from_opw(&other.forward(&[0.0; 6])).inverse().compose(&machine.forward_kinematics(&zero).unwrap().pose);
        let flange = at.pose.compose(&tool.inverse());
        let theirs = other.inverse(&opw(&flange));
        let postures = machine.postures_at(&at.pose);
        prop_assert_eq!(postures.len(), theirs.len(), "{}: {:?}", arm.name, at);
        let mut branches = HashSet::new();
        for posture in &postures {
            let (mm, rad) = error(&machine, posture, &at.pose);
            prop_assert!(mm < 1e-8 && rad < 1e-11, "{}: {} leaves {mm} mm, {rad} rad", arm.name, posture.branch);
            prop_assert_eq!(machine.branch_of(&posture.at), Some(posture.branch));
            prop_assert!(branches.insert(posture.branch));
            if is_regular(&machine, &posture.at) {
                let own = joints(&machine, &posture.at);
                let distance = |joints: &[f64; 6]| own.iter().zip(joints).map(|(a, b)| apart(*a, *b)).fold(0.0, f64::max);
                let nearest = theirs.iter().map(distance).fold(f64::INFINITY, f64::min);
                prop_assert!(nearest < 1e-9, "{}: {} is {nearest} rad from theirs", arm.name, posture.branch);
            }
        }
        let own = postures.iter().find(|posture| Some(posture.branch) == machine.branch_of(&at)).unwrap();
        let distance = joints(&machine, &own.at).iter().zip(joints(&machine, &at)).map(|(a, b)| apart(*a, b)).fold(0.0, f64::max);
        prop_assert!(distance < 1e-9, "{}: {distance} rad from where it stood", arm.name);
    }

    /// The signs of the three clearances are the sign of the Jacobian's determinant, and each vanishes where it says.
    #[test]
    fn the_branch_is_the_sign_of_the_jacobians_factors(arm in 0..ARMS.len(), shares in prop::array::uniform6(0.0..1.0)) {
        let machine = ARMS[arm].machine();
        let determinant = |at: &Configuration| machine.drive_jacobian(at).unwrap().determinant();
        let factors = |at: &Configuration| {
            let clearance = machine.clearance(at).unwrap();
            clearance.shoulder_mm * clearance.elbow_deg.to_radians().sin() * clearance.wrist_deg.to_radians().sin()
        };
        let at = somewhere(&machine, shares);
        prop_assume!(is_regular(&machine, &at));
        // 1 / det J = constant / (factors): drives by task.
        let constant = |at: &Configuration| determinant(at) * factors(at);
        let ratio = constant(&at) / constant(&machine.home);
        prop_assert!((ratio - 1.0).abs() < 1e-7, "{}: {ratio}", ARMS[arm].name);
    }
}

#[test]
fn words_are_those_of_the_geometry() {
    for arm in &ARMS {
        let machine = arm.machine();
        let home = machine.branch_of(&machine.home).unwrap();
        assert_eq!((home.shoulder, home.elbow), (Shoulder::Front, Elbow::Up), "{}: {home}", arm.name);
        // The wrist counts by its drive: all have it at 50 deg in the file, the Fanuc shows the opposite.
        let wrist = if machine.home.drives[4] > 0.0 { Wrist::Noflip } else { Wrist::Flip };
        assert_eq!(home.wrist, wrist, "{}", arm.name);
        let clearance = machine.clearance(&machine.home).unwrap();
        assert!(
            (clearance.wrist_deg - machine.home.drives[4].to_degrees()).abs() < 1e-9,
            "{}: {clearance:?}",
            arm.name
        );
    }
    for branch in Branch::ALL {
        assert_eq!(branch.to_string().parse::<Branch>().unwrap(), branch);
    }
    let refusal = "front-up".parse::<Branch>().unwrap_err().to_string();
    assert!(refusal.contains("front-up-noflip, front-up-flip, front-down-noflip"), "{refusal}");
}

#[test]
fn arms_are_known_behind_rails_and_with_coupled_drives_and_others_are_not() {
    for name in ["robot_6r", "robot_6r_plain", "coupled_6r", "kr270", "kr270_rail"] {
        let machine = machine_file(name);
        let found = machine.branch_of(&machine.home);
        assert!(found.is_some(), "{name}");
        let postures = machine.postures_at(&machine.home.pose);
        assert_eq!(found.is_some(), !postures.is_empty(), "{name}");
        for posture in postures {
            let (mm, rad) = error(&machine, &posture, &machine.home.pose);
            assert!(mm < 1e-7 && rad < 1e-10, "{name}: {} leaves {mm} mm, {rad} rad", posture.branch);
        }
    }
    for name in ["hybrid_3ups", "fourbar_robot", "rrr3", "linear_delta", "fivebar"] {
        let machine = machine_file(name);
        assert_eq!(machine.branch_of(&machine.home), None, "{name}");
        assert!(machine.postures_at(&machine.home.pose).is_empty(), "{name}");
        let refusal = machine.on_branch(Branch::ALL[0]).unwrap_err().to_string();
        assert!(refusal.contains("has no branches"), "{name}: {refusal}");
    }
}

#[test]
fn a_machine_stays_on_the_branch_that_was_chosen() {
    for arm in &ARMS {
        let machine = arm.machine();
        let own = machine.branch_of(&machine.home).unwrap();
        assert_eq!(machine.on_branch(own).unwrap().home, machine.home, "{}", arm.name);
        let mut stood = 0;
        for posture in machine.postures_at(&machine.home.pose) {
            let on = match (machine.on_branch(posture.branch), &posture.limits) {
                (Ok(on), Ok(())) => on,
                (Err(error), Err(limit)) => {
                    let words = error.to_string();
                    assert!(words.contains(&limit.to_string()) && words.contains(&own.to_string()), "{words}");
                    continue;
                }
                (on, limits) => panic!("{}: {}: {limits:?}, {:?}", arm.name, posture.branch, on.err()),
            };
            assert_eq!(on.branch_of(&on.home), Some(posture.branch));
            assert!(motion_between(&on.home.pose, &machine.home.pose).amax() < 1e-8);
            for other in [on.nominal().unwrap(), on.with_parameters(&[("arm.fixed_1.translation.x", 1.0)]).unwrap()] {
                assert_eq!((other.branch, other.branch_of(&other.home)), (Some(posture.branch), Some(posture.branch)));
            }
            for share in 0..27 {
                let part = |place: u32| f64::from(share / 3i32.pow(place) % 3) / 2.0;
                let target = on.pose_at(position_in_box(&on, 0.0, 1.0, [part(0), part(1), part(2)]));
                let Ok(at) = on.inverse_kinematics(&target) else { continue };
                assert_eq!(on.branch_of(&at), Some(posture.branch), "{} at {:?}", arm.name, target.translation);
                stood += 1;
            }
        }
        assert!(stood > 27, "{}: {stood} places", arm.name);
    }
}

/// A KR 270 with another home and other travel of its fifth drive.
fn kr270(home: &str, travel_of_fifth: &str) -> Machine {
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/crates/engine/src/machine/catalogue/kr270.toml"))
            .unwrap();
    let text = text.replace("rotation_deg = [0.0, 180.0, 0.0]", home).replace("[-120.0, 120.0]", travel_of_fifth);
    machine_from(&text)
}

#[test]
fn what_only_another_branch_reaches_is_unreachable_and_says_so() {
    // Only one of the two wrists can bend as far as the tool's direction needs.
    let machine = kr270("rotation_deg = [0.0, 180.0, 0.0]", "[-62.0, 120.0]");
    let flip = machine.on_branch("front-up-flip".parse().unwrap()).unwrap();
    let target = flip.pose_at(Vector3::new(1400.0, 0.0, 1100.0));
    let postures = machine.postures_at(&target);
    let within: Vec<String> =
        postures.iter().filter(|posture| posture.limits.is_ok()).map(|posture| posture.branch.to_string()).collect();
    assert_eq!(within, ["front-up-noflip"]);
    let reason = flip.inverse_kinematics(&target).unwrap_err().to_string();
    assert!(
        reason.starts_with("not on branch front-up-flip: drive A5 of chain arm at")
            && reason.ends_with("there: front-up-noflip"),
        "{reason}"
    );
    assert!(machine.inverse_kinematics(&target).is_ok());
    let on_the_other = flip.forward_kinematics(&machine.home.drives).unwrap();
    assert_eq!(
        flip.posture_change(&flip.home, &on_the_other, true).unwrap().to_string(),
        "changes branch from front-up-flip to front-up-noflip"
    );
}

/// Where its wrist passes straight on the way up: the tool leads straight ahead.
const AHEAD: &str = "rotation_deg = [0.0, 90.0, 0.0]";

/// What is wanted along a line upwards in front of `machine`, 0.5 mm from point to point; the wrist is straight half-way between point
/// `changes` − 1 and it.
fn upwards(machine: &Machine, points: usize, changes: usize) -> Vec<TaskPoint> {
    let pose = |z: f64| machine.pose_at(Vector3::new(1700.0, 0.0, z));
    let is_below =
        |z: f64| machine.branch_of(&machine.inverse_kinematics(&pose(z)).unwrap()) == machine.branch_of(&machine.home);
    let (mut low, mut high) = (1700.0, 1800.0);
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        if is_below(middle) { low = middle } else { high = middle }
    }
    let at = |point: usize| pose(low + 0.5 * (point as f64 - changes as f64 + 0.5));
    let task = |point| TaskPoint::new(at(point), Wrench::zero(), Target::ToolTip);
    (0..points).map(task).collect()
}

#[test]
fn a_path_that_would_change_branch_says_where_and_only_there() {
    let machine = kr270(AHEAD, "[-120.0, 120.0]");
    // Within a block of points that are solved one after another, at its border, and beyond.
    for changes in [100, 255, 256, 257, 300] {
        let tasks = upwards(&machine, 320, changes);
        let case = PathCase {
            nominal: &machine,
            actual: &machine,
            unloaded: &machine,
            before: None,
            tasks: &tasks,
            play: true,
        };
        let answers = run(&case, &Commands::Method(Method::None), &|| {});
        for (point, answer) in answers.iter().enumerate() {
            let label = if point == changes { "changes_posture" } else { "applied" };
            assert_eq!(answer.status.label(), label, "point {point} of {changes}: {}", answer.status.reason(&machine));
        }
        let reason = answers[changes].status.reason(&machine);
        let z = |point: usize| format!("{:.3}", tasks[point].pose.translation.z);
        assert_eq!(
            reason,
            format!(
                "changes branch from front-up-flip to front-up-noflip on the way from P at (1700.000, 0.000, {}) to P at (1700.000, \
                 0.000, {}) mm",
                z(changes - 1),
                z(changes)
            )
        );
        // The rest of the path on its own begins where it stands.
        let before = machine.inverse_kinematics(&tasks[changes - 1].pose).unwrap();
        let rest = &tasks[changes..];
        let case = PathCase {
            nominal: &machine,
            actual: &machine,
            unloaded: &machine,
            before: Some(&before),
            tasks: rest,
            play: true,
        };
        let answers = run(&case, &Commands::Method(Method::None), &|| {});
        assert_eq!(answers[0].status.reason(&machine), reason);
        assert!(answers[1..].iter().all(|answer| answer.status.is_success()));
    }
}

#[test]
fn an_arm_kept_on_its_branch_swings_its_wrist_and_that_is_said() {
    let machine = kr270(AHEAD, "[-120.0, 120.0]");
    let kept = machine.on_branch(machine.branch_of(&machine.home).unwrap()).unwrap();
    let tasks = upwards(&machine, 40, 20);
    let case = PathCase { nominal: &kept, actual: &kept, unloaded: &kept, before: None, tasks: &tasks, play: true };
    let answers = run(&case, &Commands::Method(Method::None), &|| {});
    let failed: Vec<usize> = (0..40).filter(|&point| !answers[point].status.is_success()).collect();
    assert_eq!(failed, [20]);
    let reason = answers[20].status.reason(&kept);
    assert!(reason.starts_with("drive arm_A4 jumps from ") && reason.contains("180.0°"), "{reason}");
}

#[test]
fn check_lists_the_eight_branches_at_home() {
    let (code, out, _) = told(&["check", "kr270"]);
    assert_eq!(code, Some(0));
    let rows: Vec<&str> = out.lines().skip_while(|line| *line != "  branches at home").skip(1).take(8).collect();
    for (row, branch) in rows.iter().zip(Branch::ALL) {
        assert!(row.starts_with(&format!("    {branch} ")), "{row}");
    }
    assert!(rows[0].ends_with("within travel (home)") && rows[1].ends_with("within travel"), "{out}");
    assert!(rows[2].contains("drive A5 of chain arm at 161.961 deg"), "{out}");
    assert!(rows[4].contains("drive A1 of chain arm at 180.000 deg") || rows[4].contains("at -180.000 deg"), "{out}");
    let (_, out, _) = told(&["check", "kr270", "--branch", "front-up-flip"]);
    assert!(out.lines().any(|line| line.contains("front-up-flip") && line.ends_with("(home)")), "{out}");
    let (code, out, _) = told(&["check", "orthoglide"]);
    assert!(code == Some(0) && !out.contains("branches"), "{out}");
}

#[test]
fn a_point_is_solved_on_the_branch_of_the_command_line() {
    let place = ["point", "--machine", "kr270", "--at", "near", "--wrench", "0,0,-500,0,0,0"];
    let on = |branch: &str, more: &[&str]| told(&[&place, &["--branch", branch][..], more].concat());
    for (branch, sign) in [("front-up-noflip", 1.0), ("front-up-flip", -1.0)] {
        let (code, out, err) = on(branch, &["--json"]);
        assert_eq!(code, Some(0), "{err}");
        let json: serde_json::Value = serde_json::from_str(&out).unwrap();
        assert_eq!(json["branch"], branch);
        let wrist = json["clearance"]["wrist_deg"].as_f64().unwrap();
        assert!(wrist * sign > 1.0 && (wrist - json["rho_nominal_deg"][4].as_f64().unwrap()).abs() < 1e-9, "{json}");
        let conditioning = json["conditioning"].as_f64().unwrap();
        assert!(conditioning > 0.05 && conditioning < 1.0, "{conditioning}");
    }
    for (arguments, message) in [
        (["kr270", "back-up-flip"], "--branch: back-up-flip at home: drive A1 of chain arm at"),
        (["orthoglide", "front-up-flip"], "--branch: orthoglide has no branches: expected a serial chain"),
        (["kr270", "front-up"], "possible values: front-up-noflip, front-up-flip"),
    ] {
        let [machine, branch] = arguments;
        let (code, _, err) = told(&["point", "--machine", machine, "--position", "0,0,0", "--branch", branch]);
        assert!(code == Some(2) && err.contains(message), "{arguments:?}: {err}");
    }
}

/// A folder with a study of a line that passes the straight wrist, and its machine.
fn study(branch: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/crates/engine/src/machine/catalogue/kr270.toml"))
            .unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("machine.toml", &text.replace("rotation_deg = [0.0, 180.0, 0.0]", AHEAD));
    let force = "[force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n";
    write("process.toml", &format!("schema = 1\n[placement]\norigin_mm = [2000.0, 0.0, 0.0]\n{force}"));
    write("path.csv", "x_mm,y_mm,z_mm\n0,0,1760\n5,0,1800\n");
    write(
        "study.toml",
        &format!(
            "schema = 3\nquestion = \"Where does it change branch?\"\nmachine = \"machine.toml\"\n{branch}process = \"process.toml\"\n\
         [path]\nfile = \"path.csv\"\n"
        ),
    );
    folder
}

#[test]
fn studies_and_programs_name_the_place_where_the_branch_would_change() {
    let folder = study("");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (code, out, err) = told(&["run", &path(""), "--out", &path("results"), "--no-figures"]);
    assert_eq!(code, Some(1), "{out}{err}");
    let table = std::fs::read_to_string(folder.path().join("results/points.csv")).unwrap();
    assert!(
        table.contains("changes_posture") && table.contains("changes branch from front-up-flip to front-up-noflip"),
        "{table}"
    );
    let arguments = ["--machine", &path("machine.toml"), "--process", &path("process.toml"), "--out", &path("out.csv")];
    let (code, out, err) = told(&[&["compensate", &path("path.csv")][..], &arguments].concat());
    assert!(code == Some(1) && out.contains("changes branch from front-up-flip to front-up-noflip"), "{out}{err}");
    assert!(!folder.path().join("out.csv").exists());
}

#[test]
fn the_branch_of_a_study_is_checked() {
    for (branch, message) in [
        ("branch = \"upside-down\"\n", "study.toml: branch: expected one of front-up-noflip, front-up-flip,"),
        ("branch = \"back-up-flip\"\n", "study.toml:4: branch: back-up-flip at home: drive"),
    ] {
        let folder = study(branch);
        let (code, _, err) = told(&["run", folder.path().to_str().unwrap()]);
        assert!(code == Some(2) && err.contains(message), "{err}");
    }
    let folder = study("branch = \"front-up-flip\"\n");
    let open = |branch| Study::open(folder.path(), &Overrides { branch, ..Overrides::default() }).unwrap();
    let machine = |study: &Study| match &study.kind {
        StudyKind::Path(path, _) => path.machine.branch.unwrap().to_string(),
        _ => panic!("a path"),
    };
    let (own, other) = (open(None), open(Some("front-up-noflip".parse().unwrap())));
    assert_eq!((machine(&own).as_str(), machine(&other).as_str()), ("front-up-flip", "front-up-noflip"));
    assert_ne!(own.inputs.sha256(), other.inputs.sha256());
}
