//! Programs of five axes on machines whose file has the head or the table: A, B and C are drives.

use kinetostat::{
    compensation::Method,
    input::Folder,
    machine::Machine,
    process::file::Process,
    products::program::{CorrectedPath, Part, ProgramJob},
    simulation::along_path::PathPointResult,
    work::Work,
};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::support::command::told;
use crate::support::engine::machine_from;

/// A gantry with a fork head, C before A, whose pivot is 450 mm above the tip.
fn head(controls: &str, home_a_deg: f64) -> Machine {
    machine_from(&head_file(controls, home_a_deg))
}

fn head_file(controls: &str, home_a_deg: f64) -> String {
    format!(
        r#"schema = 1
name = "gantry"
title = "Gantry with a fork head"
[platform]
tool_tip_mm = [0.0, 0.0, 250.0]
controls = ["x", "y", "z", {controls}]
[home]
position_mm = [1000.0, 500.0, 600.0]
rotation_deg = [{}, 0.0, 0.0]
[workspace]
min_mm = [300.0, 100.0, 200.0]
max_mm = [1700.0, 900.0, 1000.0]
[[chain]]
name = "mill"
elements = [
  {{ prismatic_drive = {{ name = "X", axis = "x", stiffness_N_per_mm = 2e3, home_mm = 1000.0, travel_mm = [0.0, 2000.0] }} }},
  {{ prismatic_drive = {{ name = "Y", axis = "y", stiffness_N_per_mm = 3e3, home_mm = 500.0, travel_mm = [0.0, 1000.0] }} }},
  {{ prismatic_drive = {{ name = "Z", axis = "z", stiffness_N_per_mm = 4e3, home_mm = 800.0, travel_mm = [0.0, 1500.0] }} }},
  {{ revolute_drive = {{ name = "C", axis = "z", stiffness_Nmm_per_rad = 5e8 }} }},
  {{ revolute_drive = {{ name = "A", axis = "x", home_deg = {home_a_deg:?}, stiffness_Nmm_per_rad = 2e8, travel_deg = [-110.0, 110.0] }} }},
  {{ fixed = {{ translation_mm = [0.0, 0.0, -200.0], rotation_deg = [180.0, 0.0, 0.0] }} }},
]
[[mount]]
name = "mill"
chain = "mill"
"#,
        180.0 + home_a_deg
    )
}

/// A mill of three prismatic joints over a trunnion table, A before C, whose axes meet in the origin.
fn table() -> Machine {
    machine_from(
        r#"schema = 1
name = "mill"
title = "Mill with a trunnion table"
[platform]
tool_tip_mm = [0.0, 0.0, 0.0]
tool_axis = [0.0, 0.0, -1.0]
controls = ["x", "y", "z"]
[home]
position_mm = [0.0, 0.0, 0.0]
[workspace]
min_mm = [-500.0, -500.0, -500.0]
max_mm = [500.0, 500.0, 500.0]
[[chain]]
name = "mill"
elements = [
  { prismatic_drive = { name = "X", axis = "x", stiffness_N_per_mm = 1000.0, home_mm = 0.0 } },
  { prismatic_drive = { name = "Y", axis = "y", stiffness_N_per_mm = 2000.0, home_mm = 0.0 } },
  { prismatic_drive = { name = "Z", axis = "z", stiffness_N_per_mm = 4000.0, home_mm = 0.0 } },
]
[[chain]]
name = "trunnion"
elements = [
  { revolute_drive = { name = "A", axis = "x", stiffness_Nmm_per_rad = 1.2e8, travel_deg = [-110.0, 110.0] } },
  { revolute_drive = { name = "C", axis = "z", stiffness_Nmm_per_rad = 1.5e8, travel_deg = [-360.0, 360.0] } },
]
[[mount]]
name = "mill"
chain = "mill"
[workpiece_carrier]
name = "table"
chain = "trunnion"
base = { position_mm = [0.0, 0.0, 0.0] }
"#,
    )
}

const FORCE: &str = "[force.path_frame]\nradial_force_N = 200.0\ntangential_force_N = -80.0\naxial_force_N = -100.0\n\
    [sampling]\nmax_segment_mm = 10.0\nmax_turn_deg = 5.0\n[compensate]\ncorner_mm = 0.0\n[gcode]\ndecimals_mm = 6\n";
const ORIGIN: [f64; 3] = [1000.0, 500.0, 200.0];
const ON_TABLE: [f64; 3] = [30.0, -20.0, 40.0];

fn process(machine: &Machine, origin: [f64; 3], more: &str) -> kinetostat::input::error::Result<Process> {
    let text = format!("schema = 1\n[placement]\norigin_mm = {origin:?}\n{FORCE}{more}");
    Process::from_toml(&text, "process.toml", Folder::in_memory([]), machine)
}

fn job(machine: &Machine, origin: [f64; 3], more: &str, program: &str) -> ProgramJob {
    let process = process(machine, origin, more).unwrap_or_else(|error| panic!("{error}"));
    let folder = Folder::in_memory([("part.nc".into(), program.as_bytes().to_vec())]);
    let file = process.program_in_folder(&folder, "part.nc").unwrap();
    ProgramJob::new(process, file, "part.nc", &Work::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// A point of the path in W, the force on the tool there, and what was answered.
struct At {
    tip: Vector3<f64>,
    force: Vector3<f64>,
    answer: PathPointResult,
}

fn pass(job: &ProgramJob, method: Method) -> Vec<At> {
    let mut all = Vec::new();
    let take = |part: &Part<'_>, answers: &[PathPointResult]| {
        for ((point, task), answer) in part.points.iter().zip(part.tasks()).zip(answers) {
            all.push(At { tip: point.position_mm, force: task.load.force, answer: answer.clone() });
        }
        Ok(())
    };
    job.pass_by(method, &|| (), take).unwrap();
    assert!(
        all.iter().all(|at| at.answer.status.is_success()),
        "{:?}",
        all.iter().map(|at| &at.answer.status).find(|s| !s.is_success())
    );
    all
}

fn turn(axis: Vector3<f64>, angle: f64) -> Matrix3<f64> {
    *Rotation3::new(axis * angle).matrix()
}

/// Displacement by `force` at `at`, by revolute joints of axes through `through`: their directions and stiffnesses.
fn revolute(
    at: Vector3<f64>,
    through: Vector3<f64>,
    axes: [(Vector3<f64>, f64); 2],
    force: Vector3<f64>,
) -> Vector3<f64> {
    let of = |(axis, stiffness): (Vector3<f64>, f64)| {
        let lever = axis.cross(&(at - through));
        lever * (lever.dot(&force) / stiffness)
    };
    axes.into_iter().map(of).sum()
}

const TIP: &str = "G21 G90 G17\nG0 X0 Y0 Z50 A5 C0\nG43.4 H1\nG1 Z0 F500\nG1 X60 Y10 A20 C15\nG1 X60 Y60 Z-5 A20 C60\nG1 X0 Y60 A15 C60\n\
    G1 X0 Y20\nG1 A0 X10\nG1 X20 C90\nG49\nM30\n";

#[test]
fn a_fork_head_stands_as_the_program_says_and_its_slides_put_the_tip_right() {
    for (controls, home_a) in [("\"rotation_x\", \"rotation_y\"", 0.0), ("\"rotation_x\", \"rotation_z\"", -10.0)] {
        let machine = head(controls, home_a);
        let job = job(&machine, ORIGIN, "", TIP);
        let plain = pass(&job, Method::None);
        let (mut most, mut tilts) = (0.0f64, 0);
        for at in &plain {
            let drives = &at.answer.nominal_drives;
            let (c, a) = (drives[3], drives[4]);
            let (of_c, of_a) = (turn(Vector3::z(), c), turn(Vector3::x(), a));
            let tip = Vector3::from(ORIGIN) + at.tip;
            let pivot = tip + of_c * of_a * Vector3::new(0.0, 0.0, 450.0);
            assert!((Vector3::new(drives[0], drives[1], drives[2]) - pivot).norm() < 1e-8, "{drives:?} {pivot:?}");
            let slides = at.force.component_div(&Vector3::new(2e3, 3e3, 4e3));
            let axes = [(Vector3::z(), 5e8), (of_c * Vector3::x(), 2e8)];
            let expected = slides + revolute(tip, pivot, axes, at.force);
            let found = at.answer.position_error;
            assert!((found - expected).norm() < 3e-3 * expected.norm() + 1e-9, "{found:?} {expected:?}");
            most = most.max(found.norm());
            tilts += usize::from(a.abs() > 0.05);
        }
        assert!(most > 0.05 && tilts > 20, "{most} {tilts}");
        // At its ends, the lines of the program.
        let end = |angles: [f64; 2]| {
            plain.iter().any(|at| {
                let [c, a] = [at.answer.nominal_drives[3], at.answer.nominal_drives[4]].map(f64::to_degrees);
                (a - angles[0]).abs() < 1e-9 && (c - angles[1]).abs() < 1e-9
            })
        };
        for angles in [[5.0, 0.0], [20.0, 15.0], [20.0, 60.0], [15.0, 60.0], [0.0, 60.0], [0.0, 90.0]] {
            assert!(end(angles), "{angles:?}");
        }
        for at in pass(&job, Method::Direct) {
            assert!(at.answer.position_error.norm() < 1e-8, "{:?}", at.answer.position_error);
            assert_eq!(at.answer.drives[3..], at.answer.nominal_drives[3..], "the head is not corrected");
        }
    }
}

#[test]
fn a_program_that_is_written_keeps_its_angles() {
    let machine = head("\"rotation_x\", \"rotation_z\"", -10.0);
    let job = job(&machine, ORIGIN, "", TIP);
    let mut corrected = CorrectedPath::new(&job);
    job.pass_by(Method::Direct, &|| (), |part, answers| {
        corrected.add(&job, part, answers);
        Ok(())
    })
    .unwrap();
    let written = job.write(&corrected).unwrap();
    let text = String::from_utf8(written.bytes.clone()).unwrap();
    let line = |from: &str, to: &str| text.lines().any(|line| line.starts_with(from) && line.ends_with(to));
    assert!(line("G43.4", " H1") && line("X60.", " A20 C15") && line("X60.", " C60") && line("X-0.", " A15"), "{text}");
    assert!(written.rounded_mm < 0.006, "{}", written.rounded_mm);
    // Read as any control of the tip would, it goes against what the load does.
    let plain = pass(&job, Method::None);
    for (at, sent) in plain.iter().zip(&written.sent.positions) {
        let expected = at.tip - at.answer.position_error;
        assert!((sent - expected).norm() < 0.02 * at.answer.position_error.norm() + 0.006, "{sent:?} {expected:?}");
    }
}

#[test]
fn without_control_of_the_tip_the_words_are_those_of_the_slides() {
    let program = "G21 G90 G17\nG0 X0 Y0 Z50 A0 C0\nG1 X10 Z10 A15 F500\nG1 Y20 C40\nG1 A-10 X0\nM30\n";
    let words = |k: usize| [[0.0, 0.0, 50.0], [10.0, 0.0, 10.0], [10.0, 20.0, 10.0], [0.0, 20.0, 10.0]][k];
    let of_head = job(&head("\"rotation_x\", \"rotation_y\"", 0.0), ORIGIN, "", program);
    let of_table = job(&table(), ON_TABLE, "", program);
    for (job, zero) in [(of_head, Vector3::from(ORIGIN) + Vector3::z() * 450.0), (of_table, Vector3::from(ON_TABLE))] {
        let ends = |k: usize| job.path.points().iter().rposition(|point| point.source.segment == k).unwrap();
        let plain = pass(&job, Method::None);
        for k in 0..4 {
            let drives = &plain[ends(k)].answer.nominal_drives;
            let expected = zero + Vector3::from(words(k));
            assert!(
                (Vector3::new(drives[0], drives[1], drives[2]) - expected).norm() < 1e-7,
                "{k} {drives:?} {expected:?}"
            );
        }
        assert!(pass(&job, Method::Direct).iter().all(|at| at.answer.position_error.norm() < 1e-8));
    }
}

#[test]
fn a_table_moves_the_part_as_the_program_says_and_bends_under_the_opposite_load() {
    let program = "G21 G90 G17\nG0 X0 Y0 Z50 A5 C0\nG43.4 H1\nG1 X0 Y0 Z0 F500\nG1 X60 Y10 A15 C15\nG1 X60 Y60 Z-5 A15 C40\nG1 X0 A-30\nG49\n\
                   M30\n";
    let job = job(&table(), ON_TABLE, "", program);
    let plain = pass(&job, Method::None);
    for (at, point) in plain.iter().zip(job.path.points()) {
        let [a, c] = [0, 1].map(|k| {
            let column = &job.path.external_axes()[k];
            assert_eq!(column, ["external_table_A_deg", "external_table_C_deg"][k]);
            point.external[k].to_radians()
        });
        let of_a = turn(Vector3::x(), a);
        let tip = of_a * turn(Vector3::z(), c) * (Vector3::from(ON_TABLE) + at.tip);
        let drives = &at.answer.nominal_drives;
        assert!((Vector3::new(drives[0], drives[1], drives[2]) - tip).norm() < 1e-8, "{drives:?} {tip:?}");
        let slides = at.force.component_div(&Vector3::new(1e3, 2e3, 4e3));
        let axes = [(Vector3::x(), 1.2e8), (of_a * Vector3::z(), 1.5e8)];
        let expected = slides + revolute(tip, Vector3::zeros(), axes, at.force);
        let found = at.answer.position_error;
        assert!((found - expected).norm() < 3e-3 * expected.norm() + 1e-9, "{found:?} {expected:?}");
    }
    let last = job.path.points().last().unwrap();
    assert_eq!(last.external[..2], [-30.0, 40.0]);
    assert!(pass(&job, Method::Direct).iter().all(|at| at.answer.position_error.norm() < 1e-8));
}

#[test]
fn what_the_process_says_of_a_drive_must_be_so() {
    let axis = |letter: char, about: [f64; 3], turns: &str, through: Option<[f64; 3]>| {
        let through = through.map_or_else(String::new, |through| format!("through_mm = {through:?}\n"));
        format!("[[gcode.rotary]]\nletter = \"{letter}\"\nabout = {about:?}\nturns = \"{turns}\"\n{through}")
    };
    let (x, z) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let refused =
        |machine: &Machine, origin: [f64; 3], more: &str| process(machine, origin, more).unwrap_err().to_string();
    let (mill, gantry) = (table(), head("\"rotation_x\", \"rotation_z\"", -10.0));
    let right =
        axis('A', x, "workpiece", Some([5.0, 20.0, -40.0])) + &axis('C', z, "workpiece", Some([-30.0, 20.0, 9.0]));
    assert!(process(&mill, ON_TABLE, &right).is_ok());
    let right = axis('C', z, "tool", Some([0.0, 0.0, 450.0])) + &axis('A', x, "tool", None);
    assert!(process(&gantry, ORIGIN, &right).is_ok());
    let found = refused(&mill, ON_TABLE, &axis('A', x, "tool", None));
    assert!(
        found.contains("gcode.rotary[0].turns")
            && found.contains("drive table_A of machine mill turns the workpiece: expected \"workpiece\""),
        "{found}"
    );
    let found = refused(&gantry, ORIGIN, &axis('C', z, "workpiece", None));
    assert!(found.contains("turns the tool: expected \"tool\""), "{found}");
    let found = refused(&mill, ON_TABLE, &axis('A', [-1.0, 0.0, 0.0], "workpiece", None));
    assert!(found.contains("gcode.rotary[0].about") && found.contains("turns about (1, 0, 0) of W"), "{found}");
    let found = refused(&mill, ON_TABLE, &axis('C', z, "workpiece", Some([0.0, 0.0, -50.0])));
    assert!(found.contains("gcode.rotary[0].through_mm") && found.contains("passes (-30, 20, -50) mm in W"), "{found}");
    let found = refused(&gantry, ORIGIN, &axis('A', x, "tool", Some([0.0, 0.0, 200.0])));
    assert!(
        found.contains("lies 250.000 mm beside the axis") && found.contains("(0, 0, 450) mm from the tip of the tool"),
        "{found}"
    );
    let found = refused(&mill, ON_TABLE, &(axis('C', z, "workpiece", None) + &axis('A', x, "workpiece", None)));
    assert!(found.contains("C before A: in machine mill drive A carries drive C"), "{found}");
}

#[test]
fn what_would_lead_a_drive_elsewhere_than_its_words_say_is_refused() {
    let read = |machine: &Machine, more: &str, program: &str| {
        let process = process(machine, ORIGIN, more).map_err(|refused| refused.to_string())?;
        let folder = Folder::in_memory([("part.nc".into(), format!("G21 G90 G17\n{program}\nM30\n").into_bytes())]);
        let file = process.program_in_folder(&folder, "part.nc").map_err(|refused| refused.to_string())?;
        ProgramJob::new(process, file, "part.nc", &Work::default()).map_err(|refused| refused.to_string())
    };
    let gantry = head("\"rotation_x\", \"rotation_y\"", 0.0);
    let end = "G0 X0 Y0 Z50 C0\nG43.4\nG1 Z0 F500\nG1 X20";
    for (program, expected) in [
        (format!("G10 L2 P1 A20\n{end}"), "sets where A is 0"),
        (format!("G52 A45\n{end}"), "sets where A is 0"),
        (format!("G92 A45\n{end}"), "sets where A is 0"),
        (format!("G0 A10\nG92 A0\n{end}"), "sets where A is 0"),
        (format!("G0 A10\nG28 A0\n{end}"), "the position of A is not known"),
        (format!("G28 A0\nG91 G0 A5\nG90\n{end}"), "the position of A is not known"),
        ("G0 X0 Y0 Z50 C0\nG28 A0\nG1 X20 A5 F500".into(), "the position of A is not known"),
    ] {
        let refused = read(&gantry, "", &program).unwrap_err();
        assert!(refused.contains(expected), "{program}: {refused}");
    }
    let stands = |program: &str| -> f64 {
        let job = read(&gantry, "", program).unwrap();
        let column = job.path.external_axes().iter().position(|name| name == "external_mill_A_deg").unwrap();
        job.path.points().last().unwrap().external[column]
    };
    assert_eq!(stands(&format!("G10 L2 P1 A0\nG52 A0\nG0 A5\nG92 A5\n{end}")), 5.0);
    assert_eq!(stands(&format!("G53 G0 A45\n{end}")), 45.0);
    assert_eq!(stands(&format!("G28 A0\nG0 A7\n{end}")), 7.0);
    // A line of safety alone leads all of them.
    let tilted = head("\"rotation_x\", \"rotation_z\"", -10.0);
    let safe = read(&tilted, "", "G53 G0 C0\nG0 X0 Y0 Z50\nG1 Z0 F500").unwrap();
    assert_eq!(safe.path.points().last().unwrap().external[..2], [0.0, 0.0]);
    let with_table = head_file("\"rotation_x\", \"rotation_y\"", 0.0)
        + "[[chain]]\nname = \"round\"\nelements = [\n  { revolute_drive = { name = \"C\", axis = \"z\", stiffness_Nmm_per_rad = 1e9 } },\n]\n\
           [workpiece_carrier]\nname = \"table\"\nchain = \"round\"\nbase = { position_mm = [1000.0, 500.0, 100.0] }\n";
    let refused = read(&machine_from(&with_table), "", end).unwrap_err();
    assert!(refused.contains("are both called C"), "{refused}");
    let other = "[[gcode.rotary]]\nletter = \"B\"\nabout = [0.0, 1.0, 0.0]\nturns = \"workpiece\"\n";
    let refused = read(&gantry, other, end).unwrap_err();
    assert!(refused.contains("B is no drive of machine gantry, and mill_C, mill_A are"), "{refused}");
    let pivot = "[[gcode.rotary]]\nletter = \"A\"\nabout = [1.0, 0.0, 0.0]\nturns = \"tool\"\nthrough_mm = [0.0, 0.0, 100.0]\n\
                 [compensate]\ntarget = \"full_pose\"\n";
    let text = format!("schema = 1\n[placement]\norigin_mm = {ORIGIN:?}\n{pivot}");
    let refused = Process::from_toml(&text, "process.toml", Folder::in_memory([]), &gantry).unwrap_err().to_string();
    assert!(refused.contains("lies 350.000 mm beside the axis"), "{refused}");
}

#[test]
fn the_pivot_of_a_head_is_that_of_the_point_that_the_path_leads() {
    let machine = head("\"rotation_x\", \"rotation_y\"", 0.0);
    let text = format!("schema = 1\n[placement]\norigin_mm = {ORIGIN:?}\nreference = \"platform_point\"\n{FORCE}");
    let process = Process::from_toml(&text, "process.toml", Folder::in_memory([]), &machine).unwrap();
    let program = b"G21 G90 G17\nG0 X0 Y0 Z50 A0 C0\nG1 Z0 A10 F500\nM30\n".to_vec();
    let folder = Folder::in_memory([("part.nc".into(), program)]);
    let file = process.program_in_folder(&folder, "part.nc").unwrap();
    let job = ProgramJob::new(process, file, "part.nc", &Work::default()).unwrap();
    // Without control of the tip the words are those of the prismatic joints, of P above its place with A at 0.
    let last = pass(&job, Method::None).pop().unwrap().answer.nominal_drives;
    let expected = Vector3::from(ORIGIN) + Vector3::z() * 200.0;
    assert!((Vector3::new(last[0], last[1], last[2]) - expected).norm() < 1e-7, "{last:?} {expected:?}");
}

#[test]
fn a_drive_stands_at_the_end_of_its_travel_and_turns_as_far_as_it_is_told() {
    let ends = head_file("\"rotation_x\", \"rotation_y\"", 0.0)
        .replace("travel_deg = [-110.0, 110.0]", "travel_deg = [-30.0, 60.0]");
    let at_end =
        job(&machine_from(&ends), ORIGIN, "", "G21 G90 G17\nG0 X0 Y0 Z50 A0 C0\nG43.4\nG1 A60 F500\nG1 A-30\nM30\n");
    assert_eq!(at_end.path.points().last().unwrap().external[1], -30.0);
    // C is told: it has no turn to choose, wherever a block of points begins.
    for x in [253, 254, 255, 256] {
        let program =
            format!("G21 G90 G17\nG0 X0 Y0 Z50 A5 C0\nG43.4\nG1 X{x} F5000\nG0 X{} C200\nG1 X300\nM30\n", x + 1);
        let finely = FORCE.replace("max_segment_mm = 10.0", "max_segment_mm = 1.0");
        let machine = head("\"rotation_x\", \"rotation_y\"", 0.0);
        let text = format!("schema = 1\n[placement]\norigin_mm = {ORIGIN:?}\n{finely}");
        let process = Process::from_toml(&text, "process.toml", Folder::in_memory([]), &machine).unwrap();
        let folder = Folder::in_memory([("part.nc".into(), program.into_bytes())]);
        let file = process.program_in_folder(&folder, "part.nc").unwrap();
        let job = ProgramJob::new(process, file, "part.nc", &Work::default()).unwrap();
        let last = pass(&job, Method::Direct).pop().unwrap().answer.drives;
        assert!((last[3].to_degrees() - 200.0).abs() < 1e-9, "{x}: {last:?}");
    }
}

#[test]
fn travel_holds_for_what_a_program_says() {
    let machine = table();
    let process = process(&machine, ON_TABLE, "").unwrap();
    let program = b"G21 G0 X0 Y0 Z50 A0 C0\nG43.4\nG1 X5 A120 F100\n".to_vec();
    let folder = Folder::in_memory([("part.nc".into(), program)]);
    let file = process.program_in_folder(&folder, "part.nc").unwrap();
    let refused = ProgramJob::new(process, file, "part.nc", &Work::default()).unwrap_err().to_string();
    assert!(
        refused.contains("external_table_A_deg is 115 at move 2: expected its travel of -110 to 110 deg"),
        "{refused}"
    );
}

/// A head along whose first axis the tool stands cannot turn its tool about one axis there; its tip it moves as elsewhere.
#[test]
fn a_tip_is_put_right_where_a_head_cannot_turn_its_tool_every_way() {
    let rigid = head_file("\"rotation_x\", \"rotation_y\"", 0.0);
    let rows = [1e5, 1e5, 1e5, 1e9, 1e9, 1e9].iter().enumerate().map(|(k, stiffness)| {
        let row: Vec<String> = (0..6).map(|j| if j == k { format!("{stiffness:e}") } else { "0.0".into() }).collect();
        format!("[{}]", row.join(", "))
    });
    let link = format!(
        "  {{ link = {{ advance_mm = 0.0, stiffness_N_mm_rad = [{}] }} }},\n",
        rows.collect::<Vec<_>>().join(", ")
    );
    let bends = rigid.replace("  { fixed", &(link + "  { fixed"));
    // Without a stiffness of the platform in every direction there is no Newton's method.
    for (file, method) in [(&rigid, Method::Direct), (&bends, Method::Direct), (&bends, Method::Newton)] {
        let machine = machine_from(file);
        let job = job(&machine, ORIGIN, "", "G21 G90 G17\nG0 X0 Y0 Z50\nG1 Z0 F500\nG1 X60 Y10\nG0 Z50\nM30\n");
        assert!(job.path.external_axes().is_empty() && !job.path.is_oriented());
        for at in pass(&job, method) {
            assert!(at.answer.position_error.norm() < 1e-7, "{:?}", at.answer.position_error);
            let drives = &at.answer.nominal_drives;
            let expected = Vector3::from(ORIGIN) + at.tip + Vector3::z() * 450.0;
            assert!((Vector3::new(drives[0], drives[1], drives[2]) - expected).norm() < 1e-7);
            assert!(drives[3].abs() < 1e-9 && drives[4].abs() < 1e-9, "{drives:?}");
        }
    }
}

#[test]
fn the_command_reads_a_head_from_the_machine_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let machine = head_file("\"rotation_x\", \"rotation_z\"", -10.0);
    let process = format!("schema = 1\n[placement]\norigin_mm = {ORIGIN:?}\n{FORCE}");
    for (name, text) in [("machine.toml", machine.as_str()), ("process.toml", process.as_str()), ("part.nc", TIP)] {
        std::fs::write(file(name), text).unwrap();
    }
    let arguments = [
        "--machine",
        &file("machine.toml"),
        "--process",
        &file("process.toml"),
        "--out",
        &file("out.nc"),
        "--progress",
        "none",
    ];
    let (code, text, said) = told(&[&["compensate", &file("part.nc")], arguments.as_slice()].concat());
    assert_eq!(code, Some(0), "{text}{said}");
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        text.contains(
            "Locked or external axes: mill_C moved within 0 to 90° by the path, mill_A moved within 0 to 20° by the path."
        ),
        "{text}"
    );
    // At another place its angles would be of other axes.
    let (machine, process, program) = (file("machine.toml"), file("process.toml"), file("part.nc"));
    let inputs = ["--process", &process, "--path", &program];
    let compared = ["compare", "--machine", &machine, "--at", "0,0,0"];
    for command in [compared.as_slice(), &["explore", &machine]] {
        let (code, _, said) = told(&[command, inputs.as_slice()].concat());
        assert_eq!(code, Some(2), "{command:?}: {said}");
        assert!(said.contains("part.nc: commands rotary drives"), "{command:?}: {said}");
    }
}
