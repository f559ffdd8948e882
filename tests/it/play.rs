//! Play of the drives along paths and in compensated programs, against closed forms and against machines whose chains are moved by it.

use kinetostat::{
    Overrides, Study, Work,
    compensation::{Method, Session, Target, TaskPoint, compensate, simulate_drives},
    input::Folder,
    machine::{ChainError, Configuration, Machine, ZeroState},
    process::Process,
    products::program::{CompensateOptions, Compensated, NoFiles, ProgramJob, VerifiedProgram},
    questions::{
        StudyKind,
        path::{self, PathResults, Shown, report},
        placement::{self, Metric, PlacementResults},
    },
    simulation::{
        Machines, Source,
        along_path::{Commands, PathCase, PathPointResult, run},
        settings,
    },
    spatial::Wrench,
    statics::drive_forces,
};
use serde_json::Value;

use crate::support::{
    command::printed,
    engine::{catalogue_machine, machine_from, settle},
    machines::{machine_path, places, some_load},
    uncertain::{LEVER, force, study_text},
};

/// The lever, its slide with these keys of play.
fn lever(play: &str) -> String {
    LEVER.replace("name = \"slide\",", &format!("name = \"slide\", {play},"))
}

/// Out along x and back, under a force of 1000 N along the feed: 0.1 mm on the prismatic joint.
const OUT_AND_BACK: &str = "x_mm,y_mm,z_mm\n-0.5,0,0\n0.5,0,0\n-0.25,0,0\n";

/// The path of the lever there and back; the results, what the first screen says, and the summary.
fn there_and_back(machine: &str, uncertainty: &str) -> (PathResults, String, Value) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lever.toml"), machine).unwrap();
    std::fs::write(folder.path().join("path.csv"), OUT_AND_BACK).unwrap();
    let process = "process.placement = { origin_mm = [0.0, 0.0, 50.0] }\nprocess.sampling = { max_segment_mm = 0.25 }\n"
        .to_string() + &force(0.0, 1000.0, 0.0);
    let question = "[path]\nmethods = [\"none\", \"direct\"]\nfile = \"path.csv\"";
    std::fs::write(folder.path().join("study.toml"), study_text("lever.toml", &process, uncertainty, question))
        .unwrap();
    let StudyKind::Path(study, _) = Study::open(folder.path(), &Overrides::default()).unwrap().kind else {
        panic!("a path")
    };
    let results = path::run(&study, &Work::default()).unwrap();
    let mut summary = report::Summary::new(&study, Shown { is_circle: false });
    summary.add(&results.whole);
    summary.add_whole(&results.spread);
    let text = report::text(&summary);
    let out = folder.path().join("out");
    printed(&["run", folder.path().to_str().unwrap(), "--out", out.to_str().unwrap(), "--quiet"]);
    let json = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    (results, text.cautions, json)
}

#[test]
fn a_slide_stands_on_the_side_of_its_play_to_which_the_force_presses_it() {
    let (results, said, json) = there_and_back(&lever("backlash_mm = 0.04, friction_N = 100.0"), "");
    let points = &results.whole.sources[Source::All];
    let mut reversed = Vec::new();
    for (k, at) in points.iter().enumerate() {
        // Along the feed: the other way on the way back.
        let force = results.study.tasks[k].load.force.x;
        let (plain, answer) = (at.plain.play.as_ref().unwrap(), at.answer.play.as_ref().unwrap());
        let side = if force.abs() > 100.0 { force.signum() } else { 0.0 };
        assert_eq!((plain.sides[0], answer.sides[0]), (side as i8, side as i8), "{k}: {force}");
        assert!((at.plain.position_error.x - (force / 1e4 + 0.02 * side)).abs() < 1e-9, "{k}: {:?}", at.plain);
        assert!((plain.seated_mm.x - 0.02 * side).abs() < 1e-9 && (answer.seated_mm.x - 0.02 * side).abs() < 1e-9);
        // Friction over stiffness is left, and all of the play where the friction holds the force.
        assert!((answer.open_mm.x - if side == 0.0 { 0.03 } else { 0.01 }).abs() < 1e-9, "{k}: {answer:?}");
        assert!(at.answer.position_error.norm() < 1e-9);
        assert!((at.answer.delta_rho()[0] + force / 1e4 + 0.02 * side).abs() < 1e-9);
        reversed.extend((!answer.reversed.is_empty()).then_some(k));
    }
    assert_eq!(reversed.len(), 1);
    let (most, n, first) = (points[0].displacement().unwrap().norm(), points.len(), reversed[0]);
    assert!((most - 0.12).abs() < 1e-9);
    assert!(said.contains("Play of the drives moves the tool by up to 0.020 mm"), "{said}");
    assert!(said.contains(&format!("at {n} of {n} points, in no distance here")), "{said}");
    assert!(said.contains("Drives change the side of their backlash at 1 point, first at line"), "{said}");
    assert_eq!(json["play"]["first_reversed_point"], first);
    assert_eq!(json["play"]["points_reversed"], 1);
    assert!((json["play"]["seated_max_mm"].as_f64().unwrap() - 0.02).abs() < 1e-9);
    assert!((results.methods[0].summary.max_mm.unwrap() - 0.12).abs() < 1e-9);
    assert!(results.methods[1].summary.max_mm.unwrap() < 1e-9);
}

#[test]
fn friction_that_holds_the_force_leaves_the_play_open() {
    let (results, said, _) = there_and_back(&lever("backlash_mm = 0.04, friction_N = 1200.0"), "");
    for at in &results.whole.sources[Source::All] {
        let play = at.answer.play.as_ref().unwrap();
        assert_eq!((play.sides[0], play.seated_mm.norm()), (0, 0.0));
        assert!((play.open_mm.x - 0.14).abs() < 1e-9, "{play:?}");
        assert!(at.plain.position_error.norm() < 0.1 + 1e-9);
    }
    assert!(said.contains("leave up to ±0.140 mm") && !said.contains("moves the tool"), "{said}");
    // Without play nothing is said or kept.
    let (results, said, json) = there_and_back(LEVER, "");
    assert!(results.whole.sources[Source::All].iter().all(|at| at.plain.play.is_none() && at.answer.play.is_none()));
    assert!(!said.contains("lay of the drives") && json.get("play").is_none(), "{said}");
}

/// Where the force is uncertain, the play is in the distances as programmed, taken back where compensated, and in the way in air.
#[test]
fn distributions_along_a_path_have_the_seated_play() {
    let uncertainty = "[[uncertainty.parameter]]\nname = \"guide.slide.stiffness\"\nrelative_std = 0.2\n\
                       [uncertainty.process]\nforce_relative_std = 0.1\n";
    let of = |machine: &str| there_and_back(machine, uncertainty);
    let ((with, said, _), (without, ..)) = (of(&lever("backlash_mm = 0.04, friction_N = 100.0")), of(LEVER));
    let [with_at, without_at] =
        [&with, &without].map(|results| results.whole.sources[Source::All][1].spread.clone().unwrap());
    let p95 = |spread: &kinetostat::simulation::spread::DeflectionSpread| spread.p95_mm.unwrap();
    assert!((p95(&with_at.plain) - p95(&without_at.plain) - 0.02).abs() < 0.005 * p95(&with_at.plain));
    let [left, left_without] = [with_at.compensated.as_ref().unwrap(), without_at.compensated.as_ref().unwrap()];
    assert!((p95(left) / p95(left_without) - 1.0).abs() < 0.01, "{left:?} {left_without:?}");
    // In air the drive is open, in the middle of its play; the command is at the far side.
    assert!((with_at.without_force_mm.unwrap() - 0.12).abs() < 1e-9);
    assert!(said.contains("in no distance here"), "{said}");
}

/// Three prismatic joints of 5, 4 and 8 kN/mm with a backlash of 0.01 mm and this friction, under a force of (∓20, ∓50, −10) N along x and (50, −20, −10) N along y.
fn placed_on_loose_slides(friction_n: f64) -> PlacementResults {
    let slide = |name: &str, axis: &str, stiffness: f64| {
        format!(
            "{{ prismatic_drive = {{ name = \"{name}\", axis = \"{axis}\", stiffness_N_per_mm = {stiffness:?}, travel_mm = [-500.0, 500.0], backlash_mm = 0.02, friction_N = {friction_n:?} }} }}"
        )
    };
    let machine = format!(
        "schema = 1\nname = \"xyz\"\ntitle = \"Slides on springs\"\n[platform]\ncontrols = [\"x\", \"y\", \"z\"]\ntool_tip_mm = [0.0, 0.0, -100.0]\n\
         tool_axis = [0.0, 0.0, -1.0]\n[workspace]\nmin_mm = [-400.0, -400.0, -400.0]\nmax_mm = [400.0, 400.0, 400.0]\n[[chain]]\nname = \"g\"\n\
         elements = [{}, {}, {}]\n[[mount]]\nname = \"m\"\nchain = \"g\"\n",
        slide("X", "x", 5e3),
        slide("Y", "y", 4e3),
        slide("Z", "z", 8e3)
    );
    let text = "schema = 3\nquestion = \"?\"\nmachine = \"xyz.toml\"\n[process]\ntolerance_mm = 0.5\n[process.force.path_frame]\nradial_force_N = 50.0\n\
         tangential_force_N = -20.0\naxial_force_N = -10.0\n[[placement.feature]]\nname = \"edge\"\nfile = \"path.csv\"\n[placement.bounds]\nx_mm = [-50.0, 50.0]\n\
         y_mm = [-50.0, 50.0]\n[placement.fixed]\nz_mm = -100.0\n[placement.allowance]\nposition_mm = 0.0\nangle_deg = 0.0\n[placement.objective]\nweights = { worst_deflection = 1.0 }\n[placement.search]\ngrid = { x = 2, y = 2 }\n\
         starts = 1\nmax_iterations = 4\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("xyz.toml"), machine).unwrap();
    std::fs::write(folder.path().join("path.csv"), "x_mm,y_mm,z_mm\n0,0,0\n30,0,0\n30,25,0\n0,25,0\n").unwrap();
    let study = Study::from_toml(text, "study.toml", folder.path(), &Overrides::default()).unwrap();
    let StudyKind::Placement(study, _) = study.kind else { panic!("a placement") };
    placement::run(&study, &Work::default()).unwrap()
}

/// As along a path: seated where a force presses it, open where friction holds that.
#[test]
fn places_are_judged_with_the_play_of_the_drives() {
    let near = |found: Option<f64>, expected: f64| {
        assert!(found.is_some_and(|found| (found - expected).abs() < 1e-6), "{found:?} instead of {expected}");
    };
    let size = |own: [f64; 3]| nalgebra::Vector3::from(own).norm();
    let pressed = placed_on_loose_slides(0.001);
    for entry in &pressed.entries {
        let found = entry.feasible().unwrap();
        // Along x: the springs, and the backlash to the side of the force.
        let (along_x, along_y) = ([0.014, 0.0225, 0.01125], [0.02, 0.015, 0.01125]);
        near(found.metrics.get(Metric::WorstDeflection), size(along_x).max(size(along_y)));
        near(found.metrics.get(Metric::WorstCorrection), 0.0225);
        near(found.open_backlash_mm, 0.0);
    }
    // A force below 30 N presses no drive.
    let held = placed_on_loose_slides(30.0);
    for entry in &held.entries {
        let found = entry.feasible().unwrap();
        let (along_x, along_y) = ([0.004, 0.0225, 0.00125], [0.02, 0.005, 0.00125]);
        near(found.metrics.get(Metric::WorstDeflection), size(along_x).max(size(along_y)));
        let open = [[0.016, 0.0075, 0.01375], [0.006, 0.0175, 0.01375]].map(size);
        near(found.open_backlash_mm, open[0].max(open[1]));
    }
}

// ---- against machines whose chains are moved ------------------------------------------------------------------------

/// Each drive's backlash: 0.01° or 0.02 mm, no two alike.
fn with_play(text: &str) -> Machine {
    let mut count = 0.0;
    let mut keyed = |line: &str| {
        ["revolute_drive = { ", "prismatic_drive = { "].iter().fold(line.to_string(), |line, key| {
            if !line.contains(key) {
                return line;
            }
            count += 1.0;
            let size = if key.starts_with('r') { "backlash_deg = 0.01" } else { "backlash_mm = 0.02" };
            line.replace(key, &format!("{key}{size}{count}, "))
        })
    };
    machine_from(&text.lines().map(&mut keyed).collect::<Vec<_>>().join("\n"))
}

/// How far the joints of `machine` stand beside their springs, chain by chain: backlash on the side of each spring's deflection.
fn seated(machine: &Machine, sides: &[f64]) -> Vec<ChainError> {
    let mut sides = sides.iter();
    let chain = |chain: &kinetostat::machine::Chain| {
        let offsets = chain.drives.iter().map(|drive| drive.half_backlash * sides.next().unwrap()).collect();
        ChainError { drive_offsets: offsets, ..ChainError::default() }
    };
    machine.chains.iter().map(chain).collect()
}

/// Sides to which the springs of an arm are pressed in the equilibrium at `at` under its weight; an upright axis to neither.
fn pressed(machine: &Machine, at: &Configuration) -> Vec<f64> {
    let (state, _) = settle(machine, at, &Wrench::zero());
    let torques = drive_forces(machine, &state);
    let most = torques.iter().fold(0.0, |most: f64, torque| most.max(torque.abs()));
    let deflections = machine.drives().map(|(chain, drive)| state.chains[chain].coordinates[drive.coordinate].signum());
    deflections.zip(&torques).map(|(side, torque)| if torque.abs() > 1e-3 * most { side } else { 0.0 }).collect()
}

/// Machines of each way to be calibrated and built, with weight or without.
fn loose_machines() -> Vec<Machine> {
    let from_file = |name: &str| with_play(&std::fs::read_to_string(machine_path(name)).unwrap());
    let mut all: Vec<Machine> =
        ["robot_6r", "kr270", "coupled_6r", "hexapod", "tricept", "linear_delta"].map(from_file).into();
    all.push(with_play(kinetostat::machine::catalogue::find("fanuc_r2000ic").unwrap().toml));
    all
}

/// The play is an offset of each joint: the same machine with chains moved by it, solved anew, stands where the path has it, and its drives are
/// pressed to those sides.
#[test]
fn seated_play_is_a_machine_whose_joints_are_moved() {
    let mut zeros = Vec::new();
    for machine in loose_machines() {
        let machines = Machines::new(&machine, &[]).unwrap();
        zeros.push((machine.zeroed, machine.own_load_text().is_some()));
        for target in [Target::ToolTip, Target::FullPose] {
            let places = places(&machine, 4);
            let task = |(k, at): (usize, &Configuration)| {
                let load = some_load(&machine, 400.0, k);
                TaskPoint::new(at.pose, load, target)
            };
            let tasks: Vec<TaskPoint> = places.iter().enumerate().map(task).collect();
            let (nominal, actual) = (&machines.nominal, &machines.actual);
            let of = |play: bool, method: Method| {
                let case =
                    PathCase { nominal, actual, unloaded: machines.unloaded(), before: None, tasks: &tasks, play };
                run(&case, &Commands::Method(method), &|| ())
            };
            let [plain, answers, bare, without] =
                [(true, Method::None), (true, Method::Direct), (false, Method::None), (false, Method::Direct)]
                    .map(|(play, method)| of(play, method));
            for (k, task) in tasks.iter().enumerate() {
                let name = format!("{} {target:?} {k}", machine.name);
                let calibrated = match machine.zeroed {
                    ZeroState::AtRest if machine.own_load_text().is_some() => pressed(machines.unloaded(), &places[k]),
                    ZeroState::AtHome => pressed(machines.unloaded(), &machine.home),
                    _ => vec![0.0; machine.drive_count()],
                };
                let beside = |result: &PathPointResult| {
                    let sides = &result.play.as_ref().unwrap_or_else(|| panic!("{name}: {result:?}")).sides;
                    assert!(sides.iter().filter(|side| **side == 0).count() <= 1, "{name}: {sides:?}");
                    let from = sides.iter().zip(&calibrated).map(|(side, before)| f64::from(*side) - before);
                    actual.with_errors(&seated(&machine, &from.collect::<Vec<_>>()))
                };
                let session_of = |moved: &Machine| {
                    Session::new(nominal, moved, settings()).with_unloaded_machine(machines.unloaded())
                };
                // As programmed.
                let moved = beside(&plain[k]);
                let mut session = session_of(&moved);
                let found = compensate(&mut session, task, Method::None);
                assert!((found.position_error - plain[k].position_error).norm() < 1e-7, "{name}: {found:?}");
                let sides: Vec<f64> =
                    drive_forces(&moved, session.state()).iter().map(|force| force.signum()).collect();
                let told: Vec<f64> = plain[k].drive_forces.iter().map(|force| force.signum()).collect();
                assert_eq!(sides, told, "{name}");
                let by_play = plain[k].position_error - bare[k].position_error;
                assert!((by_play - plain[k].play.as_ref().unwrap().seated_mm).norm() < 1e-12, "{name}");
                // Compensated: the moved machine, sent to these drives, is as near as it was without play.
                let moved = beside(&answers[k]);
                let mut session = session_of(&moved);
                let found = simulate_drives(&mut session, task, &answers[k].drives);
                assert!(found.position_error.norm() < 1e-7, "{name}: {}", found.position_error.norm());
                if target == Target::FullPose && machine.controls.len() == 6 {
                    assert!(found.residual_rotation.norm() < 1e-9, "{name}");
                }
                // The program's pose commands those drives, and to first order the correction is that of the play.
                let reached = nominal.inverse_kinematics_from(&places[k], &answers[k].target.unwrap()).unwrap();
                let far = reached.drives.iter().zip(&answers[k].drives).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(far < 1e-9, "{name}: {far}");
                let taken = (answers[k].target.unwrap().transform(machine.tool_tip)
                    - without[k].target.unwrap().transform(machine.tool_tip)
                    + answers[k].play.as_ref().unwrap().seated_mm)
                    .norm();
                assert!(taken < 0.01 * answers[k].play.as_ref().unwrap().seated_mm.norm() + 1e-6, "{name}: {taken}");
            }
        }
    }
    assert!(zeros.contains(&(ZeroState::AtRest, true)) && zeros.contains(&(ZeroState::AtHome, true)), "{zeros:?}");
    assert!(zeros.contains(&(ZeroState::Weightless, true)) && zeros.contains(&(ZeroState::AtRest, false)), "{zeros:?}");
}

// ---- programs -------------------------------------------------------------------------------------------------------

const PROGRAM: &str = "x_mm,y_mm,z_mm\n0,0,0\n20,0,0\n20,15,0\n0,0,0\n";

fn verified(machine: &Machine, process: &str, asked: &CompensateOptions) -> Box<VerifiedProgram> {
    let process =
        Process::from_toml(&format!("schema = 1\n{process}"), "process", Folder::in_memory([]), machine).unwrap();
    let folder = Folder::in_memory([("path.csv".to_owned(), PROGRAM.as_bytes().to_vec())]);
    let file = process.program_in_folder(&folder, "path.csv").unwrap();
    let job = ProgramJob::new(process, file, "path.csv", &Work::default()).unwrap();
    match job.compensate(asked, &mut NoFiles, &Work::default()).unwrap() {
        Compensated::Verified(verified) => verified,
        Compensated::Refused(refused) => panic!("{refused:?}"),
    }
}

/// The program as written, read back and solved anew with the play, keeps the tool on its path, on an arm (whose orientation a program of
/// positions does not correct) and on a hexapod; one that is not compensated leaves it by the play.
#[test]
fn a_compensated_program_takes_the_play_back() {
    let arm = kinetostat::machine::catalogue::find("fanuc_r2000ic").unwrap().toml;
    let arm_process = "[placement]\norigin_mm = [2100.0, 0.0, 650.0]\n[force.path_frame]\nradial_force_N = 300.0\n\
                       tangential_force_N = -200.0\naxial_force_N = -100.0\n";
    let hexapod = kinetostat::machine::catalogue::find("hexapod").unwrap().toml;
    let centre = catalogue_machine("hexapod").home.pose.transform(catalogue_machine("hexapod").tool_tip);
    let hexapod_process = format!(
        "[placement]\norigin_mm = [{:?}, {:?}, {:?}]\n[force.path_frame]\nradial_force_N = 300.0\ntangential_force_N = -200.0\n\
         axial_force_N = -100.0\n",
        centre.x, centre.y, centre.z
    );
    for (text, process) in [(arm, arm_process), (hexapod, &hexapod_process)] {
        let machine = with_play(text);
        let taken = verified(&machine, process, &CompensateOptions::by(Method::Direct));
        let largest = |verified: &VerifiedProgram| verified.passes.last().unwrap().summary.max_mm.unwrap();
        let bare = verified(&machine_from(text), process, &CompensateOptions::by(Method::None));
        let with = verified(&machine, process, &CompensateOptions::by(Method::None));
        assert!(taken.takes_play_back && !with.takes_play_back);
        assert!(taken.worse_as_written().is_none(), "{:?}", taken.worse_as_written());
        assert!(largest(&taken) < 2.0 * taken.written.rounded_mm + 1e-6, "{}: {}", machine.name, largest(&taken));
        assert!(largest(&with) > largest(&bare) + 0.02, "{} {}", largest(&with), largest(&bare));
    }
}

/// What `compensate` and the table of points say.
#[test]
fn the_first_screen_of_a_program_says_what_its_play_does() {
    let here = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        std::fs::write(here.path().join(name), text).unwrap();
        here.path().join(name).display().to_string()
    };
    let machine = write("lever.toml", &lever("backlash_mm = 0.04, friction_N = 100.0"));
    let process = write(
        "process.toml",
        &format!(
            "schema = 1\ncompensate = {{ corner_mm = 0.0 }}\nplacement = {{ origin_mm = [0.0, 0.0, 50.0] }}\nsampling = {{ max_segment_mm = 0.25 }}\n{}",
            force(0.0, 1000.0, 0.0).replace("process.", "")
        ),
    );
    let (program, out) = (write("path.csv", OUT_AND_BACK), here.path().join("out.csv").display().to_string());
    let arguments = ["compensate", &program, "--machine", &machine, "--process", &process, "--out", &out];
    let said = printed(&arguments).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("moves the tool by up to 0.020 mm: the program as written takes it back"), "{said}");
    assert!(said.contains("leave up to ±0.010 mm at 8 of 8 points"), "{said}");
    assert!(said.contains("change the side of their backlash at 1 point, first at line 4"), "{said}");
    assert!(said.contains("for backlash of the drives"), "{said}");
    let points = std::fs::read_to_string(here.path().join("out.csv.points.csv")).unwrap();
    let rows: Vec<Vec<&str>> = points.lines().map(|row| row.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|own| *own == name).unwrap_or_else(|| panic!("{name}: {points}"));
    let sides: Vec<&str> = rows[1..].iter().map(|row| row[column("play_sides")]).collect();
    assert!(sides.contains(&"guide+") && sides.contains(&"guide-"), "{sides:?}");
    assert_eq!(rows[1..].iter().filter(|row| row[column("play_reversed")] == "guide").count(), 1);
    let report: Value =
        serde_json::from_slice(&std::fs::read(here.path().join("out.csv.report.json")).unwrap()).unwrap();
    assert_eq!(report["play"]["points_reversed"], 1);
    let kept = printed(&[&arguments[..], &["--method", "none", "--force"]].concat());
    assert!(kept.split_whitespace().collect::<Vec<_>>().join(" ").contains("does not take it back"), "{kept}");
}
