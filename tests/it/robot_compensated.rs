//! Programs of robots and APT programs as jobs: compensated on a loaded arm, and what the process file says of them.

use std::sync::Arc;

use kinetostat::{
    compensation::Method,
    files::Foreign,
    input::Folder,
    machine::Machine,
    process::Process,
    products::program::{
        CompensateOptions, CorrectedPath, Part, ProgramAsWritten, ProgramJob,
        files::{ProgramFiles, ProgramOutcome, compensate_into},
    },
    toolpath::{Orientation, ProgramFile, polyline::Polyline},
    work::Work,
};
use nalgebra::{UnitQuaternion, Vector3};

const PLACED: &str = "[placement]\norigin_mm = [2100.0, 0.0, 650.0]\n[force.path_frame]\nradial_force_N = 300.0\n\
                      tangential_force_N = -200.0\naxial_force_N = -100.0\n";

fn arm() -> Machine {
    Machine::named_or_file("fanuc_r2000ic").unwrap()
}

pub fn process(more: &str) -> Process {
    try_process(more).unwrap_or_else(|refused| panic!("{refused}"))
}

fn try_process(more: &str) -> Result<Process, String> {
    let text = format!("schema = 1\n{PLACED}{more}");
    Process::from_toml(&text, "process", Folder::in_memory([]), &arm()).map_err(|refused| refused.to_string())
}

fn folder(files: &[(&str, &str)]) -> Folder {
    Folder::in_memory(files.iter().map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec())))
}

pub fn compensated(process: Process, files: &[(&str, &str)]) -> (ProgramJob, ProgramAsWritten) {
    let name = files[0].0;
    let file = process.program_in_folder(&folder(files), name).unwrap_or_else(|refused| panic!("{refused}"));
    let job = ProgramJob::new(process, file, name, &Work::default()).unwrap_or_else(|refused| panic!("{refused}"));
    let mut corrected = CorrectedPath::new(&job);
    let take = |part: &Part<'_>, answers: &[_]| {
        corrected.add(&job, part, answers);
        Ok(())
    };
    let pass = job.pass_by(Method::Direct, &|| (), take).unwrap();
    assert_eq!(corrected.failures, []);
    assert!(pass.summary.max_mm.unwrap() < 1e-6, "{:?}", pass.summary.max_mm);
    let written = job.write(&corrected).unwrap();
    (job, written)
}

const KRL: &str = "DEF part()\nPTP HOME\n$VEL.CP=0.02\nLIN XSTART\nLIN {X 30.000,Y 0.000,Z 0.000,A -90,B 3,C -90,E1 0} C_DIS\nLIN_REL {Z 20}\nEND\n";
const DATA: &str = "DEFDAT part\nDECL E6POS XSTART={X 0.0,Y 0.0,Z 0.0,A -90.0,B 0.0,C -90.0,E1 0.0}\nENDDAT\n";

#[test]
fn programs_of_robots_are_compensated_on_a_loaded_arm() {
    let rapid = "MODULE part\nPROC main()\n  ConfJ\\Off;\n  ConfL\\Off;\n  MoveJ [[0,0,30],[0.5,-0.5,0.5,-0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,spindle;\n  \
                 MoveL [[0,0,0],[0.5,-0.5,0.5,-0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v20,z1,spindle;\n  \
                 MoveC [[10,10,0],[0.5,-0.5,0.5,-0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],\n    \
                 [[20,0,0],[0.5,-0.5,0.5,-0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v20,z1,spindle;\nENDPROC\nENDMODULE\n";
    let apt = "UNITS/MM\nRAPID\nGOTO/0,0,30,0,0,1\nFEDRAT/500,MMPM\nGOTO/0.000,0.000,0.000\nGOTO/30.000,0.000,0.000,0.1,0,0.99498744\nFINI\n";
    for files in [&[("part.src", KRL), ("part.dat", DATA)][..], &[("part.mod", rapid)], &[("part.apt", apt)]] {
        let (job, written) = compensated(process(""), files);
        assert!(
            written.rounded_mm <= 0.005 * 1.01 && written.blocks.is_none(),
            "{}: {}",
            files[0].0,
            written.rounded_mm
        );
        let moved = job.path.points().iter().zip(&written.sent.positions);
        let most = moved.map(|(point, to)| (to - point.position_mm).norm()).fold(0.0, f64::max);
        assert!((0.3..5.0).contains(&most), "{}: corrections up to {most} mm", files[0].0);
        // What was written is a program of the same kind; its orientations are those of the path.
        let mut again = files.to_vec();
        let text = String::from_utf8(written.bytes).unwrap();
        again[0].1 = &text;
        let back = process("").program_in_folder(&folder(&again), files[0].0).unwrap();
        let path = back.toolpath(job.process.sampling).unwrap();
        let [last, was] = [&path, &job.path].map(|path| path.points()[path.len() - 1].orientation.unwrap());
        assert!(last.angle_to(&was) < 1e-6);
    }
}

const FULL_POSE: &str = "[compensate]\ntarget = \"full_pose\"\n";

/// The columns of the points tell of each source alone, whatever is asked.
#[test]
fn files_of_a_program_tell_of_each_source() {
    let files = [("part.src", KRL), ("part.dat", DATA)];
    let (job, _) = compensated(process(""), &files);
    let here = tempfile::tempdir().unwrap();
    let out = ProgramFiles::prepare(&here.path().join("part.src"), Foreign::Kept).unwrap();
    let work = Work::new(None, Arc::default(), Box::new(|_| ()));
    let left = compensate_into(job, &CompensateOptions::by(Method::Direct), &out, "part.src", &work).unwrap();
    assert!(matches!(left, ProgramOutcome::Written(_)));
    let points = std::fs::read_to_string(here.path().join("part.src.points.csv")).unwrap();
    let head: Vec<&str> = points.lines().next().unwrap().split(',').collect();
    let cutting = head.iter().position(|name| *name == "error_before_cutting_mm").unwrap();
    assert!(points.lines().skip(1).all(|row| row.split(',').nth(cutting).unwrap().parse::<f64>().is_ok()), "{points}");
}

#[test]
fn the_tool_is_turned_back_where_the_full_pose_is_compensated() {
    let points = "x_mm,y_mm,z_mm,platform_qw,platform_qx,platform_qy,platform_qz,feed_mm_per_min\n\
                  0,0,0,0.5,-0.5,0.5,-0.5,600\n15,0,0,0.5,-0.5,0.5,-0.5,600\n30,5,0,0.5,-0.45,0.55,-0.49497475,600\n";
    let axes =
        "x_mm,y_mm,z_mm,axis_x,axis_y,axis_z,feed_mm_per_min\n0,0,0,0,0,1,600\n15,0,0,0,0,1,600\n30,5,0,0.1,0,1,600\n";
    let apt = "UNITS/MM\nRAPID\nGOTO/0,0,30,0,0,1\nFEDRAT/500,MMPM\nGOTO/0.000,0.000,0.000\nGOTO/30.000,0.000,0.000,0.1,0,0.99498744\nFINI\n";
    let nc = "G21 G90\nG43.4 H1\nG0 X0 Y0 Z0 A0 B0\nG1 X20 A3 F600\nG3 X20 Y20 I0 J10 A-4 B5\nM30\n";
    let rotary = "[[gcode.rotary]]\nletter = \"B\"\nabout = [0.0, 1.0, 0.0]\nturns = \"tool\"\n\
                  [[gcode.rotary]]\nletter = \"A\"\nabout = [1.0, 0.0, 0.0]\nturns = \"tool\"\n";
    // Steps say no orientation of their own.
    let krl = KRL.replace("LIN_REL {Z 20}\n", "");
    let mut left = Vec::new();
    for files in [
        &[("part.src", krl.as_str()), ("part.dat", DATA)][..],
        &[("part.csv", points)],
        &[("axes.csv", axes)],
        &[("part.apt", apt)],
        &[("part.nc", nc)],
    ] {
        let more = if files[0].0 == "part.nc" { rotary } else { "" };
        let (job, written) = compensated(process(&format!("{FULL_POSE}{more}")), files);
        let verification = job
            .verify("as written".into(), &written, &CompensateOptions::by(Method::Direct), &Work::default(), |_| Ok(()))
            .unwrap()
            .passes;
        let [none, verified] = &verification[..] else { panic!("{verification:?}") };
        let before = none.summary.max_residual_rotation.unwrap().to_degrees();
        let after = verified.summary.max_residual_rotation.unwrap().to_degrees();
        assert!(before > 0.03, "{}: {before}", files[0].0);
        assert!(verified.summary.max_mm.unwrap() < 0.02, "{}: {:?}", files[0].0, verified.summary.max_mm);
        // The tool's axis alone leaves the turn about it.
        left.push((files[0].0, before, after));
    }
    for (name, before, after) in left {
        let says_all = matches!(name, "part.src" | "part.csv");
        assert!(if says_all { after < 0.007 } else { after < 0.9 * before }, "{name}: {after} of {before} degrees");
    }
}

#[test]
fn a_program_that_does_not_say_how_the_tool_stands_is_not_turned() {
    let files = [("part.nc", "G21 G90\nG0 X0 Y0 Z0\nG1 X20 F600\nM30\n")];
    let process = process(FULL_POSE);
    let file = process.program_in_folder(&folder(&files), "part.nc").unwrap();
    let refused = ProgramJob::new(process, file, "part.nc", &Work::default()).unwrap_err().to_string();
    assert!(
        refused.starts_with("part.nc: full_pose cannot be written: the program does not say how the tool stands"),
        "{refused}"
    );
}

#[test]
fn a_robot_stands_as_its_program_says() {
    let (job, written) = compensated(process(""), &[("part.src", KRL), ("part.dat", DATA)]);
    let Some(Orientation::Platform(platform)) = job.path.points()[0].orientation else { panic!("no orientation") };
    // The tool of this arm, along y of the flange, points down at home and here.
    assert!((platform * Vector3::y() + Vector3::z()).norm() < 1e-12);
    assert_eq!(job.file.line_of(job.path.points()[0].source.segment), Some(4));
    // The named point has its numbers where it is used; nothing else but the motions has changed.
    let text = String::from_utf8(written.bytes).unwrap();
    assert!(text.starts_with("DEF part()\nPTP HOME\n$VEL.CP=0.02\nLIN {X ") && text.ends_with("\nEND\n"), "{text}");
    assert!(text.lines().nth(3).unwrap().ends_with(",A -90.0,B 0.0,C -90.0,E1 0.0}"), "{text}");
}

#[test]
fn a_tool_of_another_length_is_refused() {
    let with_tool = KRL.replace("LIN XSTART", "$TOOL={X 6.9,Y 245.3,Z 300,A 0,B 0,C 0}\nLIN XSTART");
    let file = process("").program_in_folder(&folder(&[("part.src", &with_tool), ("part.dat", DATA)]), "part.src");
    let message = file.unwrap_err().to_string();
    assert!(
        message.contains("has its tip at (6.9, 245.3, 300) mm of the flange")
            && message.contains("(6.9, 245.3, 319.3) mm"),
        "{message}"
    );
    let right = with_tool.replace("Z 300", "Z 319.3");
    assert!(process("").program_in_folder(&folder(&[("part.src", &right), ("part.dat", DATA)]), "part.src").is_ok());
}

#[test]
fn pages_get_the_points_of_a_program() {
    let recording = folder(&[("part.src", KRL), ("part.dat", DATA)]).recording();
    let file = process("").program_in_folder(&recording, "part.src").unwrap();
    let path = file.toolpath(Default::default()).unwrap();
    let recorded = recording.recorded()["part.src"].clone();
    let again = process("").parse_program(recorded.clone(), "part.src".as_ref()).unwrap();
    assert!(matches!(again, ProgramFile::Polyline(_)));
    let points = Polyline::read(recorded, "part.src").unwrap();
    assert_eq!(points.toolpath().len(), path.len());
    for (a, b) in points.toolpath().points().iter().zip(path.points()) {
        assert!((a.position_mm - b.position_mm).norm() < 1e-8);
        assert!(a.orientation.unwrap().angle_to(&b.orientation.unwrap()) < 1e-7);
        assert_eq!(a.feed_mm_per_min, Some(1200.0));
    }
}

#[test]
fn the_process_file_says_what_programs_leave_open() {
    let options = process(
        "[robot_program]\ntool_rotation_deg = [0.0, 90.0, 0.0]\nexternal_axes = [\"external_rail_mm\"]\ncalls_kept = [\"Spindle_On\"]\n\
         [robot_program.bases]\nWobj1 = { origin_mm = [1.0, 2.0, 3.0], rotation_deg = [90.0, 0.0, 0.0] }\n",
    )
    .robot_program;
    let about_y = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    assert!(options.tool_rotation.unwrap().angle_to(&about_y) < 1e-7);
    let base = options.bases["wobj1"];
    assert!((base * nalgebra::Point3::new(1.0, 0.0, 0.0) - nalgebra::Point3::new(1.0, 3.0, 3.0)).norm() < 1e-12);
    assert_eq!(
        (options.external_axes, options.calls_kept),
        (vec!["external_rail_mm".to_owned()], vec!["spindle_on".to_owned()])
    );
    for (text, problem) in [
        ("external_axes = [\"rail\"]", "robot_program.external_axes"),
        ("tool_rotation_deg = [nan, 0.0, 0.0]", "robot_program.tool_rotation_deg"),
        ("turn = 1", "unknown key `turn`"),
    ] {
        let message = try_process(&format!("[robot_program]\n{text}\n")).unwrap_err();
        assert!(message.contains(problem), "{message}");
    }
}

#[test]
fn tools_and_bases_of_a_backup_are_read_where_the_program_stands_in_it() {
    let tip = arm().tool_tip;
    let source = "DEF part()\nBAS(#TOOL,2)\nBAS(#BASE,1)\nPTP XSTART\nBAS(#BASE,3)\nLIN XSTART\nEND\n";
    let data = "DEFDAT part\nDECL E6POS XSTART={X 1,Y 2,Z 3,A 0,B 0,C 0}\nDECL FRAME OTHER={X 1,Y 1,Z 1,A 0,B 0,C 0}\nENDDAT\n";
    let config = format!(
        "DEFDAT $CONFIG PUBLIC\nTOOL_DATA[2]={{X {},Y {},Z {},A 0,B 90,C 0}}\nBASE_DATA[1]={{X 10,Y 0,Z 0,A 0,B 0,C 0}}\nBASE_DATA[3]={{X 10,Y \
         20,Z 0,A 0,B 0,C 0}}\nFRAME XSTART={{X 9,Y 9,Z 9,A 0,B 0,C 0}}\nENDDAT\n",
        tip.x, tip.y, tip.z
    );
    let read = |program: &str, at: &str| {
        let files = [(program, source), (&program.replace(".src", ".dat"), data), (at, &config)];
        let process = process("");
        let file = process.program_in_folder(&folder(&files), program).unwrap_or_else(|refused| panic!("{refused}"));
        (file.toolpath(process.sampling).unwrap(), file)
    };
    let places = [
        ("part.src", "$config.dat"),
        ("KRC/R1/Program/part.src", "KRC/R1/System/$config.dat"),
        ("KRC/R1/Program/Mill/Job/part.src", "KRC/R1/System/$config.dat"),
    ];
    for (program, at) in places {
        let (path, file) = read(program, at);
        let points = path.points();
        assert!((points[points.len() - 1].position_mm - Vector3::new(1.0, 22.0, 3.0)).norm() < 1e-9, "{program}");
        let Some(Orientation::Platform(platform)) = points[0].orientation else { panic!("no orientation") };
        let about_y = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -std::f64::consts::FRAC_PI_2);
        assert!(platform.angle_to(&about_y) < 1e-9, "{program}");
        let ProgramFile::Robot(robot) = file else { panic!("no program of a robot") };
        assert_eq!(robot.notes().assumed_tool, None);
    }
    // Elsewhere it is that of another robot.
    let process = process("");
    let files = [("part.src", source), ("part.dat", data), ("Other/$config.dat", &config)];
    let refused = process.program_in_folder(&folder(&files), "part.src").unwrap_err().to_string();
    assert!(refused.contains("where base_data[3] stands to the base before it is not known"), "{refused}");
}
