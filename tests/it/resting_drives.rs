//! Drives that nothing in a program commands stay at home: as on another machine that has none of them.

use kinetostat::{
    compensation::Method,
    input::Folder,
    machine::Machine,
    process::file::Process,
    products::program::{Part, ProgramJob},
    simulation::along_path::PathPointResult,
    toolpath::PathPoint,
    work::Work,
};
use nalgebra::{Rotation3, Vector3};

use crate::support::command::told;
use crate::support::engine::machine_from;

const X: &str =
    "{ prismatic_drive = { name = \"X\", axis = \"x\", stiffness_N_per_mm = 5e3, travel_mm = [-500.0, 500.0] } }";
const Y: &str =
    "{ prismatic_drive = { name = \"Y\", axis = \"y\", stiffness_N_per_mm = 4e3, travel_mm = [-500.0, 500.0] } }";
const Z: &str =
    "{ prismatic_drive = { name = \"Z\", axis = \"z\", stiffness_N_per_mm = 8e3, travel_mm = [-500.0, 500.0] } }";
const C: &str =
    "{ revolute_drive = { name = \"C\", axis = \"z\", stiffness_Nmm_per_rad = 4e8, travel_deg = [-360.0, 360.0] } }";
const OFFSET: &str = "{ fixed = { translation_mm = [15.0, 0.0, -40.0] } }";
const B: &str =
    "{ revolute_drive = { name = \"B\", axis = \"y\", stiffness_Nmm_per_rad = 2e8, travel_deg = [-110.0, 110.0] } }";
const RAIL: &str =
    "{ prismatic_drive = { name = \"rail\", axis = \"x\", stiffness_N_per_mm = 9e3, travel_mm = [-500.0, 500.0] } }";

/// The spring of a joint that has no drive: compliance along the axis with this index.
fn spring(axis: usize, compliance: f64) -> String {
    let entry = |row: usize, column: usize| match (row == column, row == axis) {
        (true, true) => compliance,
        // As good as rigid: in translation, mm/N, and in rotation, rad/(N mm).
        (true, false) => {
            if row < 3 {
                1e-15
            } else {
                1e-18
            }
        }
        _ => 0.0,
    };
    let rows: Vec<String> =
        (0..6).map(|row| format!("{:?}", (0..6).map(|c| entry(row, c)).collect::<Vec<f64>>())).collect();
    format!("{{ link = {{ advance_mm = 0.0, compliance_mm_rad_N = [{}] }} }}", rows.join(", "))
}

fn gantry(controls: &str, home_mm: [f64; 3], elements: &[&str]) -> String {
    format!(
        "schema = 1\nname = \"gantry\"\ntitle = \"Gantry\"\ngravity_m_per_s2 = [0.0, 0.0, 0.0]\n[home]\nposition_mm = {home_mm:?}\n\
         [platform]\ncontrols = [{controls}]\ntool_tip_mm = [0.0, 0.0, -100.0]\ntool_axis = [0.0, 0.0, -1.0]\n\
         [workspace]\nmin_mm = [-200.0, -200.0, -200.0]\nmax_mm = [200.0, 200.0, 200.0]\n\
         [[chain]]\nname = \"g\"\nelements = [\n{},\n]\n[[mount]]\nname = \"m\"\nchain = \"g\"\n",
        elements.join(",\n")
    )
}

const AT_HOME: [f64; 3] = [15.0, 0.0, -40.0];
const TRANSLATIONS: &str = "\"x\", \"y\", \"z\"";
const PLAIN: &str = "G21 G90 G17\nS8000 M3\nG0 X-50 Y-30 Z30\nG1 Z0 F600\nG1 X60 F1200\nG1 Y40\nG0 Z30\nM30\n";
const FORCE: &str = "[force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -60.0\naxial_force_N = -145.0\n";
const SETTINGS: &str = "[compensate]\ncorner_mm = 0.0\n[sampling]\nmax_segment_mm = 10.0\n[gcode]\nwrite_tolerance_mm = 0.0\ndecimals_mm = 6\n";

fn job(
    machine: &Machine,
    origin: [f64; 3],
    settings: &str,
    (name, program): (&str, &str),
) -> Result<ProgramJob, String> {
    let text = format!("schema = 1\n[placement]\norigin_mm = {origin:?}\n{FORCE}{settings}");
    let process =
        Process::from_toml(&text, "process.toml", Folder::in_memory([]), machine).map_err(|why| why.to_string())?;
    let folder = Folder::in_memory([(name.into(), program.as_bytes().to_vec())]);
    let file = process.program_in_folder(&folder, name).map_err(|why| why.to_string())?;
    ProgramJob::new(process, file, name, &Work::default()).map_err(|why| why.to_string())
}

fn pass(job: &ProgramJob, method: Method) -> Vec<(PathPoint, PathPointResult)> {
    let mut all = Vec::new();
    job.pass_by(method, &|| (), |part: &Part<'_>, answers: &[PathPointResult]| {
        all.extend(part.points.iter().copied().zip(answers.iter().cloned()));
        Ok(())
    })
    .unwrap();
    let failed = all.iter().find(|(_, answer)| !answer.status.is_success());
    assert!(failed.is_none(), "{:?}", failed.map(|(_, answer)| &answer.status));
    all
}

/// Errors without correction, and the prismatic joints X, Y and Z with it, are those of another machine.
fn is_as(job_of: &ProgramJob, slides: [usize; 3], other: &ProgramJob) {
    for method in [Method::None, Method::Direct] {
        let (own, others) = (pass(job_of, method), pass(other, method));
        assert!(own.len() == others.len() && own.len() > 20);
        for ((_, own), (_, other)) in own.iter().zip(&others) {
            assert!((own.position_error - other.position_error).norm() < 1e-6, "{method:?}: {own:?} {other:?}");
            for (slide, expected) in slides.iter().zip(&other.drives) {
                assert!(
                    (own.drives[*slide] - expected).abs() < 1e-6,
                    "{method:?}: {:?} {:?}",
                    own.drives,
                    other.drives
                );
            }
            assert_eq!(own.drives.len(), own.nominal_drives.len());
            let still = (0..own.drives.len()).filter(|drive| !slides.contains(drive));
            assert!(still.into_iter().all(|drive| own.drives[drive] == 0.0), "{:?}", own.drives);
        }
    }
}

#[test]
fn a_head_that_no_word_turns_bends_as_one_bolted_there() {
    let bolted = gantry(TRANSLATIONS, AT_HOME, &[X, Y, Z, &spring(5, 2.5e-9), OFFSET, &spring(4, 5e-9)]);
    let of = |machine: &str| job(&machine_from(machine), [15.0, 0.0, -140.0], SETTINGS, ("plain.nc", PLAIN)).unwrap();
    for controls in [TRANSLATIONS, "\"x\", \"y\", \"z\", \"rotation_x\", \"rotation_y\""] {
        is_as(&of(&gantry(controls, AT_HOME, &[X, Y, Z, C, OFFSET, B])), [0, 1, 2], &of(&bolted));
    }
}

#[test]
fn a_rail_that_no_word_moves_bends_as_a_bolted_one_and_the_answer_says_that_it_stands() {
    let railed = gantry(TRANSLATIONS, [0.0; 3], &[X, Y, RAIL, Z]);
    let bolted = gantry(TRANSLATIONS, [0.0; 3], &[X, Y, &spring(0, 1.0 / 9e3), Z]);
    let of = |machine: &str| job(&machine_from(machine), [0.0, 0.0, -100.0], SETTINGS, ("plain.nc", PLAIN)).unwrap();
    is_as(&of(&railed), [0, 1, 3], &of(&bolted));
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(file("rail.toml"), railed).unwrap();
    std::fs::write(file("plain.nc"), PLAIN).unwrap();
    let process = format!("schema = 1\n[placement]\norigin_mm = [0.0, 0.0, -100.0]\n{FORCE}{SETTINGS}");
    std::fs::write(file("p.toml"), process).unwrap();
    let (machine, process, program, out) = (file("rail.toml"), file("p.toml"), file("plain.nc"), file("o.nc"));
    let (code, said, why) = told(&["compensate", &program, "-m", &machine, "-p", &process, "-o", &out]);
    assert_eq!(code, Some(0), "{said}{why}");
    let words = said.split_whitespace().collect::<Vec<_>>().join(" ");
    let stands = "m_rail at 0 mm (as at home, since nothing in the path commands them: m_rail)";
    assert!(words.contains(stands), "{said}");
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(file("o.nc.report.json")).unwrap()).unwrap();
    assert_eq!(report["drives_left_at_home"], serde_json::json!({ "m_rail": 0.0 }));
    assert!(std::fs::read_to_string(file("o.nc.html")).unwrap().contains("since nothing in the path commands them"));
}

#[test]
fn drives_of_which_nothing_says_which_moves_are_refused_by_name() {
    let other = X.replace("\"X\"", "\"left\"");
    let machine = machine_from(&gantry(TRANSLATIONS, [0.0; 3], &[&other, Y, RAIL, Z]));
    let refused = job(&machine, [0.0, 0.0, -100.0], SETTINGS, ("plain.nc", PLAIN)).unwrap_err();
    assert!(refused.contains("m_left, m_rail: machine gantry has 1 more than its task needs"), "{refused}");
    // One that stands elsewhere than at home is the user's to say.
    let told = machine.with_locked_drives(&[("rail", 30.0)]).unwrap();
    let job = job(&told, [0.0, 0.0, -100.0], SETTINGS, ("plain.nc", PLAIN)).unwrap();
    assert!(pass(&job, Method::None).iter().all(|(_, answer)| answer.drives[2] == 30.0));
    assert_eq!(job.machine.resting_drives().count(), 0);
}

#[test]
fn the_rail_of_an_arm_stands_and_an_axis_that_the_program_has_elsewhere_needs_its_name() {
    let machine = machine_from(include_str!("../machines/kr270_rail.toml"));
    let target = |x: f64, axis: &str| format!("LIN {{X {x},Y 0,Z 0,A 0,B 180,C 0{axis}}}");
    let of = |axis: &str| {
        let moves: Vec<String> = [0.0, 40.0, 80.0].map(|x| target(x, axis)).into();
        let program =
            format!("DEF part()\n$BASE=BASE_DATA[1]\n$TOOL=TOOL_DATA[1]\n$VEL.CP=0.02\n{}\nEND\n", moves.join("\n"));
        let settings = "[robot_program]\ntool_rotation_deg = [0.0, 0.0, 0.0]\n";
        job(&machine, [1600.0, 0.0, 700.0], settings, ("part.src", &program))
    };
    for axis in ["", ",E1 0.0"] {
        let rail: Vec<f64> = pass(&of(axis).unwrap(), Method::Direct).iter().map(|(_, at)| at.drives[0]).collect();
        assert!(rail.len() > 2 && rail.iter().all(|rail| *rail == 0.0), "{rail:?}");
    }
    let refused = of(",E1 500.0").unwrap_err();
    assert!(refused.contains("external axis 1 stands at 500") && refused.contains("robot_rail at 0"), "{refused}");
}

#[test]
fn with_full_pose_a_head_follows_the_angles_that_the_program_names() {
    let controls = "\"x\", \"y\", \"z\", \"rotation_x\", \"rotation_y\"";
    let machine = machine_from(&gantry(controls, AT_HOME, &[X, Y, Z, C, OFFSET, B]));
    let axes = "rotary_tip = \"always\"\n[[gcode.rotary]]\nletter = \"C\"\nabout = [0.0, 0.0, 1.0]\nturns = \"tool\"\n\
                through_mm = [-15.0, 0.0, 0.0]\n[[gcode.rotary]]\nletter = \"B\"\nabout = [0.0, 1.0, 0.0]\nturns = \"tool\"\n\
                through_mm = [0.0, 0.0, 100.0]\n";
    let settings = SETTINGS.replace("corner_mm = 0.0\n", "corner_mm = 0.0\ntarget = \"full_pose\"\n") + axes;
    let origin = Vector3::new(7.0, -4.0, -140.0);
    for (from, to) in [(60.0, 120.0), (170.0, 190.0), (-100.0, -250.0), (10.0, 40.0)] {
        let program = format!(
            "G21 G90 G17\nS8000 M3\nG0 X-20 Y-10 Z20 B25 C{from}\nG1 Z0 F600\nG1 X20 Y5 Z2 B20 C{to}\nG0 Z60\nM30\n"
        );
        let job = job(&machine, origin.into(), &settings, ("hc.nc", &program)).unwrap();
        for (point, answer) in pass(&job, Method::None) {
            let share =
                if point.source.segment == 2 { point.source.parameter } else { f64::from(point.source.segment > 2) };
            let (b, c) = (25.0 - 5.0 * share, from + (to - from) * share);
            let drives = &answer.nominal_drives;
            let off = [drives[3].to_degrees() - c, drives[4].to_degrees() - b].map(f64::abs);
            assert!(off[0] < 1e-6 && off[1] < 1e-6, "{drives:?}: {b} {c}");
            let turn = |axis, angle: f64| Rotation3::from_axis_angle(&axis, angle.to_radians());
            let arm = turn(Vector3::z_axis(), c)
                * (Vector3::new(15.0, 0.0, -40.0) + turn(Vector3::y_axis(), b) * Vector3::new(0.0, 0.0, -100.0));
            let slides = origin + point.position_mm - arm;
            assert!((Vector3::new(drives[0], drives[1], drives[2]) - slides).norm() < 1e-6, "{drives:?} {slides:?}");
        }
        for (_, answer) in pass(&job, Method::Direct) {
            let [c, b] = [answer.nominal_drives[3], answer.nominal_drives[4]];
            let axis = Vector3::new(b.sin() * c.cos(), b.sin() * c.sin(), b.cos());
            // A turn about the tool is left.
            let across = answer.residual_rotation - axis * axis.dot(&answer.residual_rotation);
            assert!(answer.position_error.norm() < 1e-8 && across.norm() < 1e-9, "{across:?} {answer:?}");
            assert!((answer.drives[3] - c).abs() < 1e-3, "{answer:?}");
        }
    }
}
