//! The turn about the tool's axis: the lattice against all ways through it, limits kept, what cannot be told apart from what can be, and
//! the commands that seek it.

use std::{f64::consts::TAU, path::PathBuf};

use crate::support::{arm::ARM, command::told, engine::*};
use kinetostat::{
    compensation::{Method, Target},
    machine::{Branch, Machine},
    process::{
        CutPath, GammaChoice, Placement, Process, RedundancyCost, RedundancyObjective, RedundancySettings,
        cutting::PathLoad,
    },
    products::program::{CompensateOptions, Compensated, NoFiles, ProgramJob},
    redundancy::{FoundGamma, GammaProblem, Infeasible, LatticePath, search_gamma},
    spatial::{Pose, Wrench},
    statics::{Scratch, State, Status, drive_forces, equilibrium},
    toolpath::{Load, Orientation, polyline::Polyline},
    work::Work,
};
use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};

/// A path whose rows are points, with a force in each.
fn path(rows: &[(f64, f64, f64)], feed: f64) -> CutPath {
    let mut text = String::from("x_mm,y_mm,z_mm,feed_mm_per_min\n");
    for (x, y, z) in rows {
        text += &format!("{x},{y},{z},{feed}\n");
    }
    Polyline::read(text, "path.csv").unwrap().toolpath().clone().into()
}

/// Points along a quarter of a circle about the tool tip at home, `step` mm from one to the next.
fn bent(machine: &Machine, count: usize, step: f64) -> CutPath {
    let tip = machine.home.pose.transform(machine.tool_tip);
    let at = |k: usize| {
        let angle = k as f64 * step / 20.0;
        (tip.x + 20.0 * angle.cos(), tip.y + 20.0 * angle.sin(), tip.z + 0.3 * k as f64)
    };
    path(&(0..count).map(at).collect::<Vec<_>>(), 600.0)
}

fn loads(path: &CutPath) -> Vec<PathLoad> {
    let load = |k: usize| Load {
        force_N: Vector3::new(300.0 - 40.0 * k as f64, 100.0 + 20.0 * k as f64, 120.0),
        moment_Nmm: Vector3::zeros(),
    };
    (0..path.len()).map(|k| PathLoad::Workpiece(load(k % 6))).collect()
}

fn asked<'a>(
    machine: &'a Machine,
    placement: &'a Placement,
    path: &'a CutPath,
    loads: &'a [PathLoad],
    turn: &'a RedundancySettings,
) -> GammaProblem<'a> {
    GammaProblem { machine, errors: &[], placement, target: Target::ToolTip, path, loads, settings: turn }
}

fn sought(machine: &Machine, path: &CutPath, turn: &RedundancySettings) -> FoundGamma {
    let loads = loads(path);
    search_gamma(asked(machine, &Placement::default(), path, &loads, turn), &Work::default()).unwrap()
}

/// The best γ on the lattice, of a search that refines only the best constant one.
fn on_lattice(machine: &Machine, path: &CutPath, turn: &RedundancySettings) -> Result<LatticePath, String> {
    let turn = RedundancySettings { gamma: GammaChoice::BestConstant, ..turn.clone() };
    sought(machine, path, &turn).on_lattice.map_err(|dead_end| dead_end.label().to_string())
}

fn seeking(objective: RedundancyObjective) -> RedundancySettings {
    RedundancySettings {
        gamma: GammaChoice::Best,
        objective,
        min_singularity_distance: 0.0,
        ..RedundancySettings::default()
    }
}

/// Where the tip should be and what is on it, posed and loaded by hand.
fn posed(machine: &Machine, point: Vector3<f64>, turn: f64, force: Vector3<f64>) -> (Pose, Wrench) {
    let axis = Unit::new_normalize(machine.tool_axes.column(2).into_owned());
    let rotation = machine.home.pose.rotation * Rotation3::from_axis_angle(&axis, turn).matrix();
    let lever = rotation * machine.tool_tip;
    let load = Wrench { force, moment: lever.cross(&force) };
    (Pose { rotation, translation: point - lever }, load)
}

/// How far the loaded tip is from where it should be with the machine at these drives.
fn deflection(machine: &Machine, at: &kinetostat::machine::Configuration, pose: &Pose, load: &Wrench) -> f64 {
    let (mut state, mut scratch) = (State::rigid(machine, at), Scratch::new(machine));
    let outcome = equilibrium(machine, &at.drives, load, &mut state, &mut scratch, &EXACT);
    assert_eq!(outcome.status, Status::Solved);
    // Each joint beside its spring by its backlash, to the side to which its drive is pressed.
    let forces = drive_forces(machine, &state);
    // A thousandth of the largest torque presses nothing.
    let least = 1e-3 * forces.iter().fold(0.0, |most: f64, force| most.max(force.abs()));
    let side = |force: f64| if force.abs() > least { force.signum() } else { 0.0 };
    let sides = machine.drives().zip(&forces).map(|((_, drive), force)| drive.half_backlash * side(*force));
    let beside: Vec<f64> = at.drives.iter().zip(sides).map(|(drive, beside)| drive + beside).collect();
    if beside != at.drives {
        let outcome = equilibrium(machine, &beside, load, &mut state, &mut scratch, &EXACT);
        assert_eq!(outcome.status, Status::Solved);
    }
    (state.pose.transform(machine.tool_tip) - pose.transform(machine.tool_tip)).norm()
}

/// Of all ways through the lattice of `turns`, one step at most from point to point: the least root mean square and the least largest
/// deflection. Found by trying all of them.
fn all_ways(machine: &Machine, path: &CutPath, turns: usize, low_deg: f64) -> (f64, f64) {
    let step = TAU / turns as f64;
    let branches: Vec<Machine> = Branch::ALL.iter().filter_map(|branch| machine.on_branch(*branch).ok()).collect();
    assert!(branches.len() > 2, "{} branches", branches.len());
    let loads = loads(path);
    let (mut least_squares, mut least_largest) = (f64::INFINITY, f64::INFINITY);
    for on_branch in &branches {
        let node = |k: usize, turn: usize| {
            let PathLoad::Workpiece(load) = &loads[k] else { panic!("given in W") };
            let point = path.points()[k].position_mm;
            let (pose, load) = posed(machine, point, low_deg.to_radians() + turn as f64 * step, load.force_N);
            let posture = on_branch.postures_at(&pose).into_iter().find(|own| Some(own.branch) == on_branch.branch)?;
            posture
                .limits
                .is_ok()
                .then(|| (posture.at.drives.clone(), deflection(on_branch, &posture.at, &pose, &load)))
        };
        let nodes: Vec<Vec<_>> = (0..path.len()).map(|k| (0..turns).map(|turn| node(k, turn)).collect()).collect();
        'ways: for way in 0..turns.pow(path.len() as u32) {
            let turn = |k: usize| way / turns.pow(k as u32) % turns;
            let (mut squares, mut largest) = (0.0, 0.0f64);
            for k in 0..path.len() {
                let Some((drives, cost)) = &nodes[k][turn(k)] else { continue 'ways };
                if k > 0 {
                    let apart = turn(k).abs_diff(turn(k - 1));
                    let Some((before, _)) = &nodes[k - 1][turn(k - 1)] else { continue 'ways };
                    let swings = drives.iter().zip(before).any(|(a, b)| (a - b).abs() > 0.25 * TAU);
                    if apart.min(turns - apart) > 1 || swings {
                        continue 'ways;
                    }
                }
                squares += cost * cost;
                largest = largest.max(*cost);
            }
            least_squares = least_squares.min(squares);
            least_largest = least_largest.min(largest);
        }
    }
    ((least_squares / path.len() as f64).sqrt(), least_largest)
}

#[test]
fn the_lattice_has_the_best_of_all_ways() {
    lattice_is_best(ARM);
}

/// With backlash, which moves the tool by as much again.
#[test]
fn the_lattice_of_loose_drives_has_the_best_of_all_ways() {
    lattice_is_best(&ARM.replace("revolute_drive = { ", "revolute_drive = { backlash_deg = 0.016, "));
}

fn lattice_is_best(arm: &str) {
    let machine = machine_from(arm);
    let path = bent(&machine, 5, 3.0);
    let turn = |objective| RedundancySettings { step_deg: 60.0, max_step_deg_per_mm: 20.0, ..seeking(objective) };
    let (rms, largest) = all_ways(&machine, &path, 6, -180.0);
    let found = on_lattice(&machine, &path, &turn(RedundancyObjective::Rms)).unwrap();
    assert_eq!(found.points, [0, 1, 2, 3, 4]);
    assert!((found.value_mm - rms).abs() < 1e-7 * rms, "{} and {rms}", found.value_mm);
    let found = on_lattice(&machine, &path, &turn(RedundancyObjective::Worst)).unwrap();
    assert!((found.value_mm - largest).abs() < 1e-7 * largest, "{} and {largest}", found.value_mm);
    assert!(largest > 1.0001 * rms);
    let sought = sought(&machine, &path, &turn(RedundancyObjective::Worst));
    assert_eq!(sought.on_lattice.unwrap().value_mm, found.value_mm);
}

#[test]
fn where_joint_6_alone_turns_the_tool_the_turn_changes_nothing() {
    let machine = machine_from(&ARM.replace("tool_tip_mm = [0.0, 0.0, 100.0]", "tool_tip_mm = [100.0, 0.0, 0.0]"));
    let path = bent(&machine, 4, 2.0);
    let found = sought(&machine, &path, &seeking(RedundancyObjective::Rms));
    let programmed = found.as_programmed.rms_mm.unwrap();
    // Other branches may be stiffer; on that of the program nothing changes.
    let own = machine.on_branch(machine.branch_of(&machine.home).unwrap()).unwrap();
    let on_own = sought(&own, &path, &seeking(RedundancyObjective::Rms));
    let best = on_own.best.as_ref().unwrap().along.rms_mm.unwrap();
    assert!((best - programmed).abs() < 1e-9 * programmed, "{best} and {programmed}");
    assert!(found.best.unwrap().along.rms_mm.unwrap() <= programmed * (1.0 + 1e-9));
    // What costs the same stays as programmed.
    for turned in [on_own.best, on_own.best_constant] {
        let turns = turned.unwrap().turns_deg;
        assert!(turns.iter().all(|turn| *turn == 0.0), "{turns:?}");
    }
}

#[test]
fn a_path_turned_as_a_whole_has_its_turns_shifted() {
    // The wrist of this arm bends as well either way: two branches cost the same.
    let arm = machine_from(ARM);
    let machine = arm.on_branch(arm.branch_of(&arm.home).unwrap()).unwrap();
    let own = bent(&machine, 6, 3.0);
    let axis = Unit::new_normalize(machine.tool_axes.column(2).into_owned());
    let home = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(machine.home.pose.rotation));
    let turned = |deg: f64| {
        let platform = home * UnitQuaternion::from_axis_angle(&axis, f64::to_radians(deg));
        own.clone().with_platforms(&vec![platform; own.len()])
    };
    let turn = seeking(RedundancyObjective::Rms);
    let (first, second) =
        (on_lattice(&machine, &own, &turn).unwrap(), on_lattice(&machine, &turned(15.0), &turn).unwrap());
    assert!((first.value_mm - second.value_mm).abs() < 1e-9 * first.value_mm);
    assert_eq!(first.branch, second.branch);
    for (a, b) in first.turns_deg.iter().zip(&second.turns_deg) {
        assert!((a - b - 15.0 + 180.0).rem_euclid(360.0) - 180.0 < 1e-6, "{a} and {b}");
    }
    let refined = (sought(&machine, &own, &turn).best.unwrap(), sought(&machine, &turned(15.0), &turn).best.unwrap());
    assert!((refined.0.along.rms_mm.unwrap() / refined.1.along.rms_mm.unwrap() - 1.0).abs() < 1e-3);
}

/// A robot whose drives have travel, and a path on a slanted face under it.
fn robot() -> (Process, CutPath) {
    let machine = catalogue_machine("fanuc_r2000ic");
    let process = "schema = 1\n[placement]\norigin_mm = [1900.0, 0.0, 800.0]\npitch_deg = -35.0\n\
                   [force.path_frame]\nradial_force_N = 300.0\ntangential_force_N = -200.0\naxial_force_N = -150.0\n";
    let process = Process::from_toml(process, "process.toml", std::path::PathBuf::new(), &machine).unwrap();
    let at = |k: usize| match k {
        0..20 => (2.0 * k as f64, 0.0, 0.0),
        k => (38.0, 2.0 * (k - 19) as f64, 0.0),
    };
    (process, path(&(0..40).map(at).collect::<Vec<_>>(), 600.0))
}

fn robot_sought(turn: &RedundancySettings) -> FoundGamma {
    let (process, path) = robot();
    let loads = process.loads(&path).unwrap();
    search_gamma(asked(&process.machine, &process.placement, &path, &loads, turn), &Work::default()).unwrap()
}

#[test]
fn turns_keep_the_band_travel_and_speed_limits() {
    let (process, path) = robot();
    let turn = RedundancySettings {
        max_step_deg_per_mm: 2.0,
        speed_limits_deg_per_s: vec![8.0, 8.0, 8.0, 12.0, 12.0, 12.0],
        min_singularity_distance: 0.02,
        ..seeking(RedundancyObjective::Rms)
    };
    let found = robot_sought(&turn);
    let best = found.best.as_ref().unwrap();
    assert_eq!(best.along.solved, path.len());
    let mut before: Option<Vec<f64>> = None;
    for (k, point) in best.path.points().iter().enumerate() {
        if k > 0 {
            let change = best.turns_deg[k] - best.turns_deg[k - 1];
            assert!(change.abs() <= 2.0 * 2.0 + 1e-9, "{change} at {k}");
        }
        let Some(Orientation::Platform(platform)) = point.orientation else { panic!("no orientation at {k}") };
        let rotation = process.placement.pose().rotation * platform.to_rotation_matrix().matrix();
        let translation = process.placement.pose().transform(point.position_mm) - rotation * best.machine.tool_tip;
        let pose = Pose { rotation, translation };
        let postures = best.machine.postures_at(&pose);
        let own = postures.into_iter().find(|posture| Some(posture.branch) == best.branch).unwrap();
        assert!(own.limits.is_ok(), "{:?}", own.limits);
        assert!(best.machine.conditioning(&own.at) >= 0.02 * (1.0 - 1e-6));
        if let Some(before) = before {
            for ((a, b), limit) in own.at.drives.iter().zip(&before).zip(&turn.speed_limits_deg_per_s) {
                // 2 mm at 10 mm/s.
                assert!((a - b).abs().to_degrees() <= limit * 0.2 * (1.0 + 1e-6), "{} at {k}", (a - b).to_degrees());
            }
        }
        before = Some(own.at.drives);
    }
    let [programmed, constant, best] =
        [&found.as_programmed, &found.best_constant.as_ref().unwrap().along, &best.along]
            .map(|along| along.rms_mm.unwrap());
    assert!(best <= constant && constant <= programmed, "{programmed}, {constant}, {best}");
}

#[test]
fn a_hexapod_turns_as_far_as_its_legs_allow() {
    let machine = catalogue_machine("hexapod");
    let tip = machine.home.pose.transform(machine.tool_tip);
    let path = path(&[(tip.x, tip.y, tip.z), (tip.x + 4.0, tip.y, tip.z), (tip.x + 8.0, tip.y + 2.0, tip.z)], 600.0);
    let found = sought(&machine, &path, &RedundancySettings { step_deg: 10.0, ..seeking(RedundancyObjective::Rms) });
    let best = found.best.unwrap();
    assert_eq!((best.branch, best.along.solved), (None, 3));
    assert!(best.along.rms_mm <= found.as_programmed.rms_mm);
    assert!(best.turns_deg.iter().all(|turn| turn.abs() < 120.0), "{:?}", best.turns_deg);
}

#[test]
fn other_costs_and_objectives_are_made_small() {
    let with = |cost, objective| robot_sought(&RedundancySettings { cost, ..seeking(objective) }).best.unwrap().along;
    let rms = with(RedundancyCost::Deflection, RedundancyObjective::Rms);
    let worst = with(RedundancyCost::Deflection, RedundancyObjective::Worst);
    assert!(worst.worst_mm <= rms.worst_mm && rms.rms_mm.unwrap() <= worst.rms_mm.unwrap() * (1.0 + 1e-6));
    let across = with(RedundancyCost::AcrossPath, RedundancyObjective::Rms);
    let wall = with(RedundancyCost::AcrossSurface, RedundancyObjective::Rms);
    assert!(wall.rms_mm <= across.rms_mm && across.rms_mm <= rms.rms_mm);
}

#[test]
fn the_same_turns_are_found_on_any_number_of_threads() {
    let found = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found =
            pool.install(|| robot_sought(&RedundancySettings { step_deg: 15.0, ..seeking(RedundancyObjective::Rms) }));
        let best = found.best.unwrap();
        (best.turns_deg, best.along.cost_mm, found.best_constant.unwrap().turns_deg)
    };
    assert_eq!(found(1), found(3));
}

#[test]
fn where_no_turn_goes_all_along_it_is_said_why() {
    let reason = |turn: &RedundancySettings, far_mm: f64| {
        let (process, _) = robot();
        let path = path(&[(0.0, 0.0, 0.0), (far_mm, 0.0, 0.0)], 600.0);
        let loads = process.loads(&path).unwrap();
        let found =
            search_gamma(asked(&process.machine, &process.placement, &path, &loads, turn), &Work::default()).unwrap();
        let dead_end = found.best.unwrap_err();
        assert!(found.best_constant.is_err());
        (dead_end.point, dead_end.label(), dead_end.infeasible)
    };
    let turn = RedundancySettings { step_deg: 15.0, ..seeking(RedundancyObjective::Rms) };
    assert_eq!(reason(&turn, 5000.0), (1, "unreachable", Some(Infeasible::Unreachable)));
    let picky = RedundancySettings { min_singularity_distance: 0.9, ..turn.clone() };
    assert_eq!(reason(&picky, 2.0), (0, "singularity", Some(Infeasible::Singularity)));
    let slow = RedundancySettings { speed_limits_deg_per_s: vec![1e-6; 6], ..turn };
    assert_eq!(reason(&slow, 2.0), (1, "no_continuous_path", None));
}

#[test]
fn machines_without_a_free_turn_are_refused() {
    let refused = |machine: &Machine, placement: Placement| {
        let path = path(&[(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], 600.0);
        let (loads, turn) = (loads(&path), seeking(RedundancyObjective::Rms));
        search_gamma(asked(machine, &placement, &path, &loads, &turn), &Work::default()).unwrap_err().to_string()
    };
    let default = Placement::default();
    let message = refused(&catalogue_machine("orthoglide"), default);
    assert!(message.contains("redundancy") && message.contains("control all six coordinates"), "{message}");
    let tip_at_p = machine_from(&ARM.replace("[0.0, 0.0, 100.0]", "[0.0, 0.0, 0.0]"));
    let message = refused(&tip_at_p, default);
    assert!(message.contains("no axis to rotate about"), "{message}");
    let by_p = Placement { reference: kinetostat::process::PathReference::PlatformPoint, ..default };
    let message = refused(&catalogue_machine("fanuc_r2000ic"), by_p);
    assert!(message.contains("beside the tool's axis") && message.contains("expected tool_tip"), "{message}");
}

#[test]
fn keys_of_the_table_are_checked() {
    let machine = catalogue_machine("fanuc_r2000ic");
    for (table, message) in [
        ("gamma = \"some\"", "redundancy.gamma"),
        ("step_deg = 0.1", "redundancy.step_deg: must be from 0.25 to 90, got 0.1"),
        ("range_deg = [10.0, -10.0]", "redundancy.range_deg: must be the least turn and the largest"),
        ("max_step_deg_per_mm = 0.0", "redundancy.max_step_deg_per_mm"),
        (
            "min_singularity_distance = 1.0",
            "redundancy.min_singularity_distance: must be at least 0 and below 1, got 1",
        ),
        ("speed_limits_deg_per_s = [10.0]", "redundancy.speed_limits_deg_per_s: must be one for each drive"),
        ("colour = 3", "redundancy.colour"),
    ] {
        let text = format!("schema = 1\n[redundancy]\n{table}\n");
        let refused = Process::from_toml(&text, "process.toml", std::path::PathBuf::new(), &machine).unwrap_err();
        assert!(refused.to_string().contains(message), "{refused}");
    }
}

/// A folder with a path study of the robot; `beside` goes into its process.
fn study(beside: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let process = format!(
        "schema = 1\n[placement]\norigin_mm = [1900.0, 0.0, 800.0]\npitch_deg = -35.0\n\
         [force.path_frame]\nradial_force_N = 300.0\ntangential_force_N = -200.0\naxial_force_N = -150.0\n{beside}"
    );
    write("process.toml", &process);
    write("path.csv", "x_mm,y_mm,z_mm,feed_mm_per_min\n0,0,0,600\n8,0,0,600\n8,8,0,600\n");
    write(
        "study.toml",
        "schema = 3\nquestion = \"How is the tool turned best?\"\nmachine = \"fanuc_r2000ic\"\nprocess = \"process.toml\"\n\
         [path]\nfile = \"path.csv\"\n",
    );
    folder
}

#[test]
fn a_run_has_the_path_as_it_was_turned() {
    let folder = study("[redundancy]\ngamma = \"best\"\nstep_deg = 15.0\n");
    let (own, out) = (folder.path().to_str().unwrap(), folder.path().join("out"));
    let run = |beside: &[&str], out: &std::path::Path| {
        let (code, text, err) =
            told(&[&["run", own, "--no-figures", "--verbose", "--out", out.to_str().unwrap()], beside].concat());
        assert_eq!(code, Some(0), "{text}{err}");
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        (text, serde_json::from_str::<serde_json::Value>(&summary).unwrap())
    };
    let (text, summary) = run(&[], &out);
    assert!(text.contains("Rotated about the tool axis by γ = "), "{text}");
    let turns = &summary["redundancy"];
    let rms = |key: &str| turns["gammas"][key]["rms_mm"].as_f64().unwrap();
    assert_eq!((turns["gamma"].as_str(), turns["branch"].is_string()), (Some("best"), true));
    assert!(rms("best") <= rms("best_constant") && rms("best_constant") < rms("as_programmed"));
    let table = std::fs::read_to_string(out.join("redundancy.csv")).unwrap();
    assert_eq!(table.lines().count(), 18);
    // The points of the study are those of the turned path.
    let largest = summary["sources"]["all"]["displacement_max_mm"]["value"].as_f64().unwrap();
    assert!((largest - turns["gammas"]["best"]["worst_mm"].as_f64().unwrap()).abs() < 1e-9);
    let (_, plain) = run(&["--redundancy", "as_programmed"], &folder.path().join("plain"));
    assert!(plain["redundancy"].is_null());
    let programmed = plain["sources"]["all"]["displacement_max_mm"]["value"].as_f64().unwrap();
    assert!((programmed - turns["gammas"]["as_programmed"]["worst_mm"].as_f64().unwrap()).abs() < 1e-9);
}

#[test]
fn a_compensated_polyline_says_how_the_platform_stands() {
    let folder = study("");
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let compensate = |path: &str, out: &str| {
        let (process, program, out) = (at("process.toml"), at(path), at(out));
        let own = ["compensate", &program, "--machine", "fanuc_r2000ic", "--process", &process, "--out", &out];
        told(&[&own[..], &["--redundancy", "best_constant"]].concat())
    };
    let (code, text, err) = compensate("path.csv", "out.csv");
    assert!(code == Some(0) && text.contains("best constant γ"), "{text}{err}");
    let written = Polyline::read(std::fs::read(at("out.csv")).unwrap(), "out.csv").unwrap();
    assert_eq!(written.toolpath().len(), 17);
    assert!(written.toolpath().points().iter().all(|p| matches!(p.orientation, Some(Orientation::Platform(_)))));
    // A process that asks for the best γ gets it from the library as well.
    let process = std::fs::read_to_string(at("process.toml")).unwrap() + "[redundancy]\ngamma = \"best_constant\"\n";
    let process = Process::from_toml(&process, "process", PathBuf::new(), &catalogue_machine("fanuc_r2000ic")).unwrap();
    let job = ProgramJob::open(process, at("path.csv").as_ref(), &Work::default()).unwrap();
    let found = job.compensate(&CompensateOptions::by(Method::Direct), &mut NoFiles, &Work::default()).unwrap();
    let Compensated::Verified(verified) = found else { panic!("no command for some point") };
    assert!(job.redundancy.is_some() && verified.written.bytes == std::fs::read(at("out.csv")).unwrap());
    std::fs::write(at("part.nc"), "G21 G90\nG1 X0 Y0 Z0 F600\nX8\nY8\n").unwrap();
    let (code, _, err) = compensate("part.nc", "out.nc");
    assert!(code == Some(2) && err.contains("expected a polyline (.csv)"), "{err}");
}

#[test]
fn questions_without_turns_refuse_them() {
    let folder = study("[redundancy]\ngamma = \"best\"\n");
    let study = "schema = 3\nquestion = \"Where?\"\nmachine = \"fanuc_r2000ic\"\nprocess = \"process.toml\"\n\
                 [workspace_map]\ngrid = [2, 2, 2]\nslices_z_mm = [900.0]\n";
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let own = folder.path().to_str().unwrap();
    let (code, _, err) = told(&["run", own]);
    assert!(code == Some(2) && err.contains("redundancy.gamma: is best"), "{err}");
    let (code, _, err) = told(&["run", own, "--redundancy", "best_constant"]);
    assert!(code == Some(2) && err.contains("--redundancy: is best_constant"), "{err}");
}
