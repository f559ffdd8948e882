//! Programs of robots and of APT: what each in `tests/robot_programs` means, that it is written back as it is, and moved where
//! it should be.

use std::{f64::consts::FRAC_PI_2, fs, path::PathBuf};

use kinetostat_programs::{
    NumberFormat, Orientation, Sampling, Toolpath, WriteOptions,
    robot::{CutcomPoints, Language, RobotOptions, RobotProgram, abc_of_rotation, rotation_of_abc},
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::support::cases::cases;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/robot_programs")
}

/// What the programs leave open.
fn options(name: &str) -> RobotOptions {
    let mut options =
        RobotOptions { calls_kept: vec!["spindle_on".into(), "spindle_off".into()], ..Default::default() };
    if name.contains("external") {
        options.external_axes = vec!["external_rail_mm".into()];
    }
    if name.contains("tool_data") {
        options.tool_rotation = Some(UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2));
    }
    options
}

/// The program `name` of a folder of `tests/robot_programs`, with what is beside it.
fn program(name: &str) -> RobotProgram {
    let file = folder().join(name);
    let bytes = fs::read(&file).unwrap();
    let language = Language::detect(&file, &bytes).unwrap();
    let data = fs::read(file.with_extension("dat")).or(fs::read(file.with_extension("va")));
    let beside = data.ok().map(|bytes| ("beside.dat".to_owned(), bytes));
    RobotProgram::parse(bytes, name, language, beside, &options(name)).unwrap_or_else(|refused| panic!("{refused}"))
}

fn parse(language: Language, source: &str, options: &RobotOptions) -> Result<RobotProgram, String> {
    let name = ["p.src", "p.mod", "p.ls", "p.script", "p.apt"][language as usize];
    RobotProgram::parse(source, name, language, None, options).map_err(|refused| refused.to_string())
}

/// Of a path in coarse pieces: number of points, of cutting points, its first and its last position, mm.
fn shape(path: &Toolpath) -> (usize, usize, [f64; 3], [f64; 3]) {
    let place = |position: Vector3<f64>| <[f64; 3]>::from(position.map(|c| (c * 1e6).round() / 1e6 + 0.0));
    let points = path.points();
    let cutting = points.iter().filter(|point| point.cutting).count();
    (points.len(), cutting, place(points[0].position_mm), place(points[points.len() - 1].position_mm))
}

fn coarse() -> Sampling {
    Sampling::new(1.0, 10.0).unwrap().with_max_turn(1.0).unwrap()
}

fn platform(path: &Toolpath, point: usize) -> UnitQuaternion<f64> {
    let Some(Orientation::Platform(platform)) = path.points()[point].orientation else { panic!("no orientation") };
    platform
}

fn files(folder_name: &str) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder().join(folder_name))
        .unwrap()
        .map(|entry| format!("{folder_name}/{}", entry.unwrap().file_name().to_string_lossy()))
        .filter(|name| !name.ends_with(".dat") && !name.ends_with(".va"))
        .collect();
    names.sort();
    names
}

/// A smooth correction of up to 0.4 mm.
fn corrected(path: &Toolpath) -> Vec<Vector3<f64>> {
    let field = |p: Vector3<f64>| {
        p + 0.2 * Vector3::new((p.y * 0.11).sin(), (p.x * 0.07 + p.z).cos(), (0.05 * (p.x - p.y)).sin())
    };
    path.positions_mm().into_iter().map(field).collect()
}

fn turned(path: &Toolpath) -> Option<Vec<Orientation>> {
    let turn = |k: usize, orientation: Orientation| {
        let by = UnitQuaternion::from_scaled_axis(Vector3::new(2e-3, -1e-3, 1e-3) * (0.3 * k as f64).sin());
        match orientation {
            Orientation::ToolAxis(axis) => Orientation::ToolAxis(by * axis),
            Orientation::Platform(platform) => Orientation::Platform(by * platform),
        }
    };
    path.points().iter().enumerate().map(|(k, point)| Some(turn(k, point.orientation?))).collect()
}

/// Holds one program against what all must do: without correction the same bytes, with one the points where they should be.
fn check_written(program: &RobotProgram) {
    let (path, format) = (program.toolpath(Sampling::default()).unwrap(), program.own_format());
    let name = program.name();
    assert!(path.points().iter().all(|point| point.position_mm.iter().all(|c| c.is_finite())));
    let same = program.rewrite(&path, &path.positions_mm(), None, WriteOptions::with_decimals(format)).unwrap();
    assert_eq!(String::from_utf8_lossy(same.bytes()), String::from_utf8_lossy(program.source()), "{name}");
    assert_eq!(same.read_back().unwrap().positions_mm(), path.positions_mm(), "{name}");
    let own: Option<Vec<Orientation>> = path.points().iter().map(|point| point.orientation).collect();
    if let Some(own) = own {
        let same =
            program.rewrite(&path, &path.positions_mm(), Some(&own), WriteOptions::with_decimals(format)).unwrap();
        assert_eq!(same.bytes(), program.source(), "{name}");
    }
    let unit_mm =
        10f64.powi(-i32::from(format.mm_decimals())).max(25.4 * 10f64.powi(-i32::from(format.inch_decimals())));
    let wanted = corrected(&path);
    for (tolerance_mm, orientations) in [(0.0, None), (0.005, None), (0.005, turned(&path))] {
        let writing = WriteOptions { tolerance_mm, ..WriteOptions::with_decimals(format) };
        let written = program.rewrite(&path, &wanted, orientations.as_deref(), writing);
        let written = match written {
            Err(refused) if name.contains("steps") && orientations.is_some() => {
                assert!(refused.to_string().contains("corrected orientations of steps are not followed"), "{refused}");
                continue;
            }
            written => written.unwrap_or_else(|refused| panic!("{name}: {refused}")),
        };
        let again =
            written.read().unwrap_or_else(|refused| panic!("{refused}\n{}", String::from_utf8_lossy(written.bytes())));
        let back = written.read_positions(&again).unwrap();
        assert_eq!(back.len(), wanted.len());
        for (k, (back, wanted)) in back.iter().zip(&wanted).enumerate() {
            let off = (back - wanted).norm();
            assert!(
                off <= f64::max(2.0 * unit_mm, tolerance_mm) + 1e-9,
                "{name}: point {k} is {off} mm off, tolerance {tolerance_mm}\n{}",
                String::from_utf8_lossy(written.bytes())
            );
        }
        let stands = written.read_orientations(&again).unwrap();
        for (k, (stands, point)) in stands.iter().zip(path.points()).enumerate() {
            let wanted = orientations.as_ref().map_or(point.orientation, |orientations| Some(orientations[k]));
            let off = stands.zip(wanted).map_or(0.0, |(a, b)| a.angle_to(&b));
            assert!(off < if orientations.is_some() { 2e-4 } else { 1e-3 }, "{name}: point {k} turned by {off} rad");
            assert_eq!(stands.is_some(), wanted.is_some(), "{name}");
        }
        let axes = |path: &Toolpath| {
            path.points().iter().map(|point| (point.external, point.feed_mm_per_min)).collect::<Vec<_>>()
        };
        let back = written.read_back().unwrap();
        for (a, b) in axes(&back).iter().zip(axes(&path)) {
            assert!(a.0.iter().zip(b.0).all(|(a, b)| (a - b).abs() < 0.2) && a.1 == b.1, "{name}: {a:?} {b:?}");
        }
    }
}

#[test]
fn programs_without_correction_are_the_same_and_with_one_lead_where_they_should() {
    for folder in ["krl", "rapid", "ls", "urscript", "apt"] {
        let names = files(folder);
        assert!(names.len() >= 15, "{} programs in {folder}", names.len());
        names.iter().for_each(|name| check_written(&program(name)));
    }
}

/// The centres of the unit vectors between the points of a motion and `centre` turn by these angles about +z, degrees.
fn turned_about(path: &Toolpath, motion: usize, centre: Vector3<f64>) -> f64 {
    let points = path.points();
    let first = points.iter().position(|point| point.source.segment == motion).unwrap();
    let on_arc = points[first - 1..].iter().take_while(|point| point.source.segment <= motion);
    let arms: Vec<Vector3<f64>> = on_arc.map(|point| point.position_mm - centre).collect();
    let turn = |pair: &[Vector3<f64>]| {
        let (a, b) = (pair[0], pair[1]);
        (a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y)
    };
    arms.windows(2).map(turn).sum::<f64>().to_degrees()
}

#[test]
fn arcs_of_apt_turn_as_the_system_that_wrote_them_means_it() {
    let of = |name: &str| program(&format!("apt/{name}")).toolpath(Sampling::default()).unwrap();
    let is_near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-2, "{found} instead of {wanted}");
    // SolidWorks CAM: right-handed about the axis; a full turn that goes down is a helix.
    let path = of("16_circles.apt");
    is_near(turned_about(&path, 2, Vector3::zeros()), 90.0);
    is_near(turned_about(&path, 3, Vector3::new(0.0, 50.0, 0.0)), -270.0);
    is_near(turned_about(&path, 4, Vector3::new(0.0, 50.0, 0.0)), 360.0);
    let middle = path.points().iter().find(|p| p.source.segment == 4 && p.source.parameter >= 0.5).unwrap();
    assert!((middle.position_mm - Vector3::new(-20.0, 50.0, -2.5)).norm() < 0.4, "{}", middle.position_mm);
    assert_eq!((path.points()[5].tool, path.points()[5].feed_mm_per_min), (Some(7), Some(300.0)));
    // NX: clockwise seen against the axis.
    is_near(turned_about(&of("17_circles_nx.cls"), 1, Vector3::zeros()), -90.0);
    // Creo: right-handed.
    is_near(turned_about(&of("18_circles_creo.ncl.3"), 2, Vector3::zeros()), -90.0);
    // CATIA: in the direction of INDIRV, to the first or the second place where the circle meets the line.
    let path = of("19_circles_catia.apt");
    is_near(turned_about(&path, 2, Vector3::zeros()), 135.0);
    is_near(turned_about(&path, 3, Vector3::zeros()), 315.0);
    let up = path.points().iter().filter(|point| point.source.segment == 4);
    assert!(
        up.clone()
            .all(|p| (p.position_mm - Vector3::new(0.0, 10.4, 0.0)).norm() - 10.0 < 1e-3 && p.position_mm.z > 0.0)
    );
    // CSYS says how the tool stands where coordinates are those of the world.
    let path = of("20_setups.apt");
    let axis = |k: usize| path.points()[k].orientation;
    assert_eq!(axis(0), Some(Orientation::ToolAxis(Vector3::z())));
    let last_of = |motion: usize| path.points().iter().rposition(|point| point.source.segment == motion).unwrap();
    assert_eq!(axis(last_of(3)), Some(Orientation::ToolAxis(Vector3::x())));
    assert_eq!(axis(last_of(5)), Some(Orientation::ToolAxis(Vector3::z())));
}

#[test]
fn arcs_of_apt_stay_arcs_where_one_passes_the_corrected_points() {
    let options = RobotOptions::default();
    let program = parse(
        Language::Apt,
        "FEDRAT/100\nGOTO/30.000,0,0\nCIRCLE/0.000,0.000,0,0,0,1\nGOTO/0.000,30.000,0\n",
        &options,
    );
    let program = program.unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    let grown: Vec<Vector3<f64>> =
        path.positions_mm().iter().map(|p| p + p.normalize() * 0.25 + Vector3::new(0.1, -0.2, 0.3)).collect();
    let written = program.rewrite(&path, &grown, None, WriteOptions::with_decimals(program.own_format())).unwrap();
    assert_eq!(
        String::from_utf8_lossy(written.bytes()),
        "FEDRAT/100\nGOTO/30.350,-0.200,0.300\nCIRCLE/0.100,-0.200,0.300,0,0,1\nGOTO/0.100,30.050,0.300\n"
    );
    // Where none does, lines take the place of the circle and of its record.
    let bent: Vec<Vector3<f64>> =
        path.points().iter().map(|p| p.position_mm + Vector3::z() * (9.0 * p.source.parameter).sin() * 0.2).collect();
    let written = program
        .rewrite(
            &path,
            &bent,
            None,
            WriteOptions { tolerance_mm: 0.005, ..WriteOptions::with_decimals(program.own_format()) },
        )
        .unwrap();
    let text = String::from_utf8_lossy(written.bytes()).into_owned();
    assert!(!text.contains("CIRCLE") && text.matches("GOTO/").count() > 4, "{text}");
}

#[test]
fn holes_of_apt_cycles_are_moved_with_their_bottom() {
    let source = "UNITS/MM\nSPINDL/1000,RPM,CLW\nRAPID\nGOTO/10.000,0,30\nCYCLE/INIT\n\
                  CYCLE/DEEP2,FEDTO,12.5,1STPECK,5.,SUBPECK,2.,MMPR,0.1,RAPTO,3.,RTRCTO,25.\nGOTO/10.000,20.000,1.500\n\
                  GOTO/40.000,20.000,1.500\nCYCLE/OFF\nGOTO/40,20,40\nFINI\n";
    let program = parse(Language::Apt, source, &RobotOptions::default()).unwrap();
    let path = program.toolpath(coarse()).unwrap();
    let hole: Vec<_> = path.points().iter().filter(|point| point.source.segment == 1).collect();
    assert!(program.is_hole(1) && program.is_hole(2) && !program.is_hole(0) && !program.is_hole(3));
    let heights: Vec<f64> = hole.iter().map(|point| point.position_mm.z).collect();
    assert_eq!(
        (heights[0], heights[1], heights[heights.len() - 2], heights[heights.len() - 1]),
        (30.0, 4.5, -11.0, 26.5)
    );
    assert!(hole.iter().all(|point| point.cutting == (point.position_mm.z < 4.5)));
    assert_eq!(hole[3].feed_mm_per_min, Some(100.0));
    // From hole to hole at the height of RTRCTO.
    let next = path.points().iter().find(|point| point.source.segment == 2).unwrap();
    assert_eq!(next.position_mm, Vector3::new(40.0, 20.0, 26.5));
    let same =
        program.rewrite(&path, &path.positions_mm(), None, WriteOptions::with_decimals(program.own_format())).unwrap();
    assert_eq!(same.bytes(), source.as_bytes());
    let moved: Vec<Vector3<f64>> = path
        .points()
        .iter()
        .map(|p| p.position_mm + if p.cutting { Vector3::new(0.012, -0.02, 0.1) } else { Vector3::zeros() })
        .collect();
    let written = program.rewrite(&path, &moved, None, WriteOptions::with_decimals(program.own_format())).unwrap();
    let text = String::from_utf8_lossy(written.bytes()).into_owned();
    assert!(text.contains("RTRCTO,25.\nGOTO/10.012,19.980,1.600\nGOTO/40.012,19.980,1.600\nCYCLE/OFF\n"), "{text}");
    let back = written.read_back().unwrap().positions_mm();
    let bottom = path.points().iter().rposition(|point| point.source.segment == 1).unwrap() - 1;
    assert!((back[bottom] - moved[bottom]).norm() < 1e-9);
    // NX writes the depth negative; Creo names it DEPTH and CLEAR; without RTRCTO the tool comes back to where the feed began.
    for cycle in [
        "DRILL,RAPTO,3.,FEDTO,-12.5,MMPM,100",
        "DRILL, DEPTH, 12.5, MMPM, 100, CLEAR, 3.",
        "TAP,FEDTO,12.5,MMPM,100,RAPTO,3.",
    ] {
        let source = format!("GOTO/0,0,9\nCYCLE/{cycle}\nGOTO/5,0,0,0,0,1\nCYCLE/OFF\n");
        let path = parse(Language::Apt, &source, &RobotOptions::default()).unwrap().toolpath(coarse()).unwrap();
        let z: Vec<f64> = path.positions_mm().iter().map(|p| p.z).collect();
        assert_eq!((z[1], z[2], z[z.len() - 2], z[z.len() - 1]), (9.0, 3.0, -12.5, 3.0), "{cycle}");
    }
}

#[test]
fn points_under_cutcom_are_asked_for() {
    let source = "GOTO/0,0,0\nCUTCOM/LEFT\nGOTO/10,0,0\nCUTCOM/OFF\nGOTO/10,10,0\n";
    let with = |cutcom_points| parse(Language::Apt, source, &RobotOptions { cutcom_points, ..Default::default() });
    let refused = with(None).unwrap_err();
    assert!(
        refused.contains("p.apt:2: `CUTCOM/LEFT`") && refused.contains("cutcom_points = \"tool_centre\" or"),
        "{refused}"
    );
    assert!(
        with(Some(CutcomPoints::Contour))
            .unwrap_err()
            .contains("contours from which the control offsets the tool are not")
    );
    check_written(&with(Some(CutcomPoints::ToolCentre)).unwrap());
    // Creo says it itself.
    let creo = |points: &str| {
        parse(
            Language::Apt,
            &format!("$$-> CUTCOM_GEOMETRY_TYPE / OUTPUT_ON_{points}\n{source}"),
            &RobotOptions::default(),
        )
    };
    check_written(&creo("CENTER").unwrap());
    assert!(creo("PROFILE").unwrap_err().contains("contours"));
}

#[test]
fn krl_programs_mean_what_they_say() {
    let of = |name: &str| program(&format!("krl/{name}.src")).toolpath(coarse()).unwrap();
    let path = of("01_plain");
    assert_eq!(shape(&path), (20, 19, [0.0, 0.0, 50.0], [0.0, 0.0, 50.0]));
    assert_eq!(path.points()[3].feed_mm_per_min, Some(3000.0));
    // The z axis of the tool frame is along +x of the base.
    assert!((platform(&path, 3) * Vector3::z() - Vector3::x()).norm() < 1e-12);
    assert_eq!(shape(&of("02_folds_comments")), (6, 6, [10.0, 20.0, 5.0], [30.0, 45.0, 5.0]));
    assert_eq!(shape(&of("03_partial")), (9, 9, [1.5, 2.5, 3.5], [1.5, 2.5, 0.0]));
    let beside = program("krl/04_beside.src");
    let path = beside.toolpath(coarse()).unwrap();
    assert_eq!(shape(&path), (11, 11, [100.125, -20.5, 12.25], [100.125, -20.5, 12.25]));
    assert_eq!(beside.notes().unlocated_lines, [11, 27]);
    assert!(beside.notes().named_points);
    assert_eq!(path.points()[5].feed_mm_per_min, Some(6000.0));
    let path = of("05_circles");
    assert_eq!(
        (path.points()[0].position_mm, path.points()[path.len() - 1].position_mm.z),
        (Vector3::x() * 10.0, 20.0)
    );
    let round = path.points().iter().filter(|point| point.position_mm.z == 0.0);
    assert!(round.clone().count() > 10 && round.clone().all(|point| (point.position_mm.norm() - 10.0).abs() < 1e-9));
    assert!((path.length_mm() - (40.0 * std::f64::consts::PI + 20.0)).abs() < 1e-9);
    let path = of("06_external");
    assert_eq!(path.external_axes(), ["external_rail_mm"]);
    assert_eq!(path.points().iter().map(|point| point.external[0]).collect::<Vec<_>>(), [100.0, 125.0, 150.0, 200.0]);
    assert_eq!(shape(&of("07_crlf")), (3, 3, [1.0, 2.0, 3.0], [11.0, 12.0, 3.0]));
    assert_eq!(shape(&of("08_utf8_no_end")), (4, 4, [1.0, 2.0, 3.0], [31.0, 2.0, 3.0]));
    let bases = program("krl/09_bases.src");
    let path = bases.toolpath(coarse()).unwrap();
    assert_eq!(shape(&path), (8, 8, [0.0, 0.0, 0.0], [20.0, 50.0, 0.0]));
    assert_eq!(bases.notes().tool_tip_mm.as_ref().unwrap().1, Vector3::new(100.0, 0.0, 200.0));
    // All poses are the same orientation of the tool frame; the flange is turned against it by the tool's own B of 90°.
    for point in 0..path.len() {
        assert!(platform(&path, point).angle() < 1e-7, "{point}");
    }
    assert_eq!(shape(&of("10_steps")), (10, 9, [5.0, 5.0, 5.0], [5.0, 5.0, 5.0]));
    assert_eq!(shape(&of("11_assigned")), (8, 8, [0.0, 0.0, 10.0], [25.0, 0.0, 10.0]));
    let fine = program("krl/12_upright.src").toolpath(Sampling::default()).unwrap();
    let turned = platform(&fine, 0).angle_to(&platform(&fine, 20));
    assert!((turned - (0.2f64.to_radians().powi(2) + 1f64.to_radians().powi(2)).sqrt()).abs() < 1e-5, "{turned}");
    let joints = program("krl/13_joints.src");
    assert_eq!(shape(&joints.toolpath(coarse()).unwrap()), (4, 3, [10.0, 0.0, 5.0], [30.0, 10.0, 5.0]));
    assert_eq!(joints.notes().unlocated_lines, [2, 3, 4, 9]);
    assert_eq!(shape(&of("14_numbers")), (4, 4, [10.0, -0.5, 7.0], [30.123456, -0.5, 7.0]));
    let path = of("15_tool_data");
    assert_eq!(shape(&path), (6, 6, [0.0, 0.0, 0.0], [12.0, 30.0, 0.0]));
    assert_eq!(path.points()[1].feed_mm_per_min, Some(1800.0));
    let path = of("16_beside_bases");
    assert_eq!(shape(&path), (4, 4, [0.0, 0.0, 0.0], [10.0, 20.0, 0.0]));
    assert!(platform(&path, 3).angle() < 1e-7);
}

/// Statements of KRL that are refused, and in which words.
const REFUSED_OF_KRL: [(&str, &str); 19] = [
    (
        "FOR i=1 TO 3\nLIN_REL {X 1}\nENDFOR\n",
        "p.src:2: `LIN_REL {X 1}`: in FOR of line 1, where it may be skipped or repeated; expected outside, where it runs once",
    ),
    (
        "FDAT_ACT.BASE_NO=2\n",
        "p.src:1: `FDAT_ACT.BASE_NO=2`: parts of frames and of motion data are not followed; expected whole ones",
    ),
    ("BAS(#TOOL,n)\n", "p.src:1: `BAS(#TOOL,n)`: expected the number of the tool or base"),
    ("GOTO again\n", "p.src:1: `GOTO again`: jumps are not followed; expected the motions in the order they run"),
    (
        "part1()\n",
        "p.src:1: `part1()`: calls PART1, which may move the tool; expected the program in one routine, or PART1 in \
         robot_program.calls_kept if it does not",
    ),
    (
        "LIN XP1\n",
        "p.src:1: `LIN XP1`: XP1 is not known; expected its numbers in the file (there is no .dat beside it), or in the statement",
    ),
    (
        "XP1.Z=5+n\nLIN XP1\n",
        "p.src:2: `LIN XP1`: XP1 is computed in line 1; expected a point whose numbers the file gives",
    ),
    ("LIN {X 1+2,Y 0}\n", "p.src:1: `LIN {X 1+2,Y 0}`: expected , or } behind a plain number"),
    ("LIN {X n,Y 0}\n", "p.src:1: `LIN {X n,Y 0}`: expected a plain number"),
    ("LIN {A1 0,A2 0}\n", "p.src:1: `LIN {A1 0,A2 0}`: expected a pose, not positions of joints"),
    ("LIN {X 1,Y 2\n", "p.src:1: `LIN {X 1,Y 2`: expected } on the same line"),
    (
        "LIN {X 2e6,Y 0,Z 0,A 0,B 0,C 0}\n",
        "p.src:1: `LIN {X 2e6,Y 0,Z 0,A 0,B 0,C 0}`: coordinate or external axis beyond 1000000; expected a position on the machine",
    ),
    (
        "$IPO_MODE=#TCP\n",
        "p.src:1: `$IPO_MODE=#TCP`: fixed tools ($IPO_MODE #TCP) are not followed; expected a tool that the robot carries",
    ),
    (
        "$BASE=EK(MACHINE_DEF[2].ROOT,1,X)\n",
        "p.src:1: `$BASE=EK(MACHINE_DEF[2].ROOT,1,X)`: bases that move with external axes (EK, EB) are not followed; expected a base that stands still",
    ),
    (
        "LIN XP1:XP2\n",
        "p.src:1: `LIN XP1:XP2`: XP1 is not known; expected its numbers in the file (there is no .dat beside it), or in the statement",
    ),
    (
        "PTP XP1:XP2\n",
        "p.src:1: `PTP XP1:XP2`: operators on points are not followed; expected a point whose numbers the file gives",
    ),
    (
        "INTERRUPT DECL 4 WHEN $IN[1] DO stop_here()\n",
        "p.src:1: `INTERRUPT DECL 4 WHEN $IN[1] DO stop_here()`: interrupts are not followed; expected none but that of IR_STOPM",
    ),
    ("what now\n", "p.src:1: `what now`: not a statement that is known; expected a statement of KRL"),
    (
        "CIRC {X 0,Y 0,Z 0,A 0,B 0,C 0},{X 1,Y 0,Z 0,A 0,B 0,C 0}\n",
        "p.src:1: `CIRC {X 0,Y 0,Z 0,A 0,B 0,C 0},{X 1,Y 0,Z 0,A 0,B 0,C 0}`: circular motion from a place that is not known; expected a motion to a full pose before it",
    ),
];

#[test]
fn krl_that_is_not_followed_is_refused_by_line_and_statement() {
    let refused = |source: &str| parse(Language::Krl, source, &RobotOptions::default()).unwrap_err();
    let pose = "LIN {X 0,Y 0,Z 0,A 0,B 0,C 0}\n";
    for (source, message) in REFUSED_OF_KRL {
        assert_eq!(refused(source), message);
    }
    for (source, end) in [
        (
            "CIRC {X 1},{X 2}\n",
            ": start, middle and end are on no circle; expected three points apart and not on a line",
        ),
        ("END\nDEF sub()\nLIN {X 1}\n", ": a motion after the end of the program in line 2; expected none"),
        (
            "LIN_REL {X 1} #TOOL\n",
            ": steps along the axes of the tool, turns and external axes by steps are not followed; expected steps of X, Y and Z in the base",
        ),
        (
            "$BASE=BASE_DATA[2]\nLIN {X 1}\n",
            ": where base_data[2] stands to the base before it is not known; expected its pose in robot_program.bases of the process",
        ),
        (
            "TRIGGER WHEN PATH=5 DELAY=0 DO $OUT[1]=TRUE\n",
            ": triggers on the way or at the end of a motion are not followed; expected TRIGGER WHEN DISTANCE=0",
        ),
        (
            "LIN {X 1,E1 3}\nLIN {X 2,E1 4}\n",
            ": external axis 1 goes from 3 to 4; expected the axis to stand still, or its drive in robot_program.external_axes",
        ),
        (
            "$CIRC_TYPE=#PATH\nCIRC {X 1,Y 1},{X 2}\n",
            ": circles that carry the orientation along ($CIRC_TYPE) are not followed; expected $CIRC_TYPE=#BASE before it",
        ),
        ("$BASE.X=5\n", ": parts of frames and of motion data are not followed; expected whole ones"),
    ] {
        let message = refused(&format!("{pose}{source}"));
        assert!(message.ends_with(end), "{message}");
    }
    let second = refused(&format!("DEF a()\n{pose}END\nDEF b()\n{pose}END\n"));
    assert!(
        second.ends_with(
            "a motion in the routine of line 4, beside those of line 1; expected all motions in one routine"
        ),
        "{second}"
    );
}

#[test]
fn bases_that_the_program_does_not_say_come_from_the_options() {
    let mut options = RobotOptions::default();
    options.bases.insert("base_data[2]".into(), Isometry3::translation(0.0, 50.0, 0.0));
    let source = "LIN {X 0,Y 0,Z 0,A 0,B 0,C 0}\n$BASE=BASE_DATA[2]\nLIN {X 1,Y 0,Z 0,A 0,B 0,C 0}\n";
    let path = parse(Language::Krl, source, &options).unwrap().toolpath(coarse()).unwrap();
    assert_eq!(shape(&path).3, [1.0, 50.0, 0.0]);
}

#[test]
fn a_krl_motion_that_bends_becomes_lines_and_nothing_else_changes() {
    let source = "DEF p()\n  $OUT[1]=TRUE\n  LIN XA ; named\n  LIN {X 20.0, A 0, B 0, C 0, Z 0, Y 0} C_DIS ; second\n  LIN {Y 5.0}\nEND\n";
    let source = source.replace("DEF p()\n", "DEF p()\n  DECL POS XA={X 0.0,Y 0,Z 0,A 0,B 0,C 0}\n");
    let program = parse(Language::Krl, &source, &RobotOptions::default()).unwrap();
    let path = program.toolpath(Sampling::new(0.01, 5.0).unwrap()).unwrap();
    let bent = |p: Vector3<f64>| p + Vector3::new(0.0, 0.01 * p.x * (20.0 - p.x) + 0.25, 0.0);
    let wanted: Vec<Vector3<f64>> = path.positions_mm().into_iter().map(bent).collect();
    let written =
        program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(NumberFormat::new(3, 4).unwrap())).unwrap();
    assert_eq!(
        String::from_utf8_lossy(written.bytes()),
        "DEF p()\n  DECL POS XA={X 0.0,Y 0,Z 0,A 0,B 0,C 0}\n  $OUT[1]=TRUE\n  LIN {X 0.0,Y 0.250,Z 0,A 0,B 0,C 0} ; named\n  \
         LIN {X 5.000, A 0, B 0, C 0, Z 0, Y 1.000} C_DIS\n  LIN {X 10.000, A 0, B 0, C 0, Z 0, Y 1.250} C_DIS\n  \
         LIN {X 15.000, A 0, B 0, C 0, Z 0, Y 1.000} C_DIS\n  LIN {X 20.0, A 0, B 0, C 0, Z 0, Y 0.250} C_DIS ; second\n  \
         LIN {Y 5.250}\nEND\n"
    );
}

#[test]
fn rapid_programs_mean_what_they_say() {
    let of = |name: &str| program(&format!("rapid/{name}.mod")).toolpath(coarse()).unwrap();
    let path = of("01_plain");
    assert_eq!(shape(&path), (10, 9, [0.0, 0.0, 50.0], [40.0, 0.0, 0.0]));
    assert_eq!(path.points()[6].feed_mm_per_min, Some(1200.0));
    assert!((platform(&path, 3) * Vector3::z() + Vector3::z()).norm() < 1e-12);
    let declared = program("rapid/02_declared.mod");
    assert_eq!(shape(&declared.toolpath(coarse()).unwrap()), (8, 7, [10.0, 20.0, 5.0], [10.0, 20.0, 5.0]));
    assert!(declared.notes().named_points);
    assert_eq!(shape(&of("03_offs")), (10, 9, [100.0, 0.0, 70.5], [120.0, 20.0, 20.5]));
    let path = of("04_circle");
    assert!((path.length_mm() - (20.0 * std::f64::consts::PI + 10.0)).abs() < 1e-9, "{}", path.length_mm());
    let external = of("05_external");
    assert_eq!(external.points().iter().map(|point| point.external[0]).collect::<Vec<_>>(), [100.0, 125.0, 150.0]);
    assert_eq!(shape(&of("06_crlf")), (3, 3, [0.0, 0.0, 0.0], [20.0, 0.0, 0.0]));
    assert_eq!(shape(&of("07_utf8_no_end")), (3, 3, [0.0, 0.0, 0.0], [20.0, 0.0, 0.0]));
    assert_eq!(shape(&of("08_comments")), (3, 3, [1.0, 2.0, 3.0], [21.0, 2.0, 3.0]));
    let frames = program("rapid/09_frames.mod");
    let path = frames.toolpath(coarse()).unwrap();
    // The second work object stands 50 mm beside the first and is turned by 90° about z.
    assert_eq!(shape(&path), (9, 9, [0.0, 0.0, 0.0], [40.0, 50.0, 0.0]));
    assert_eq!(frames.notes().tool_tip_mm, Some(("tcut".into(), Vector3::new(31.5, 0.0, 229.0))));
    assert!((platform(&path, 0) * Vector3::z() - Vector3::x()).norm() < 1e-7, "{}", platform(&path, 0));
    let lines = of("10_lines");
    assert_eq!(shape(&lines), (5, 5, [0.0, 0.0, 0.0], [20.0, 20.0, 0.0]));
    assert_eq!(lines.points()[1].feed_mm_per_min, Some(18000.0));
    let joints = program("rapid/11_joints.mod");
    assert_eq!(shape(&joints.toolpath(coarse()).unwrap()), (2, 2, [0.0, 0.0, 0.0], [10.0, 0.0, 0.0]));
    assert_eq!(joints.notes().unlocated_lines, [4, 7]);
    let speeds: Vec<_> = of("12_speeds").points().iter().map(|point| point.feed_mm_per_min).collect();
    assert_eq!(speeds, [Some(1200.0), Some(750.0), Some(300.0), Some(2400.0), None, None]);
    assert_eq!(shape(&of("13_routines")), (3, 3, [0.0, 0.0, 0.0], [20.0, 0.0, 0.0]));
    assert_eq!(shape(&of("14_branches")), (3, 3, [0.0, 0.0, 0.0], [20.0, 0.0, 0.0]));
    assert_eq!(
        shape(&program("rapid/15_program.prg").toolpath(coarse()).unwrap()),
        (3, 2, [0.0, 0.0, 100.0], [10.0, 0.0, 95.0])
    );
}

#[test]
fn rapid_that_is_not_followed_is_refused_by_line_and_statement() {
    let at = |x: f64| format!("[[{x},0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let one = format!("MoveL {},v100,fine,tool0;\n", at(1.0));
    for (source, end) in [
        (
            "MoveL RelTool(p1,0,0,5),v100,fine,tool0;".to_owned(),
            ": computed targets are not followed; expected a target, or Offs of one",
        ),
        (
            "MoveL p1,v100,fine,tool0;".into(),
            ": P1 is not known; expected its numbers in the file, or in the statement",
        ),
        (
            "MoveL *,v100,fine,tool0;".into(),
            ": expected a target: its name, Offs(…), or [[x,y,z],[q1,q2,q3,q4],[…],[…]]",
        ),
        (
            "TriggL p1,v100,t1,fine,tool0;".into(),
            ": motions with signals, searches and processes are not followed; expected MoveL, MoveC, MoveJ and MoveAbsJ",
        ),
        (
            "SearchL di1,p1,p2,v100,tool0;".into(),
            ": motions with signals, searches and processes are not followed; expected MoveL, MoveC, MoveJ and MoveAbsJ",
        ),
        (
            format!("FOR i FROM 1 TO 3 DO\n{one}ENDFOR"),
            ": in FOR of line 2, where it may be skipped or repeated; expected outside, where it runs once",
        ),
        (
            format!("IF di1=1 {one}"),
            ": in IF of line 2, where it may be skipped or repeated; expected outside, where it runs once",
        ),
        (
            "Part_5;".into(),
            ": calls PART_5, which may move the tool; expected the program in one routine, or PART_5 in robot_program.calls_kept if it does not",
        ),
        ("PDispOn p1,tool0;".into(), ": displaced programs are not followed; expected targets where they are"),
        (
            format!("{one}MoveL {},v100\\T:=5,fine,tool0;", at(2.0)),
            ": times of motions (\\T) are not followed; expected a speed",
        ),
        (
            format!("{one}MoveL {},v100,fine,tool1\\WObj:=w9;", at(2.0)),
            ": where w9 stands to the base before it is not known; expected its pose in robot_program.bases of the process",
        ),
        (
            format!("{one}MoveL {},v100,fine,tool1;", at(2.0)),
            ": uses tool1 after tool0: split it into a program for each tool; several in one are read where the program gives their orientation and their tips are the same",
        ),
        (format!("MoveL {},v100,fine,tool0", at(2.0)), ": expected ; at the end of the statement"),
        (
            "MoveL [[1,2,3],[1,0,0,1],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;".into(),
            ": quaternion has length 1.4142135623730951; expected 1",
        ),
        ("MoveL [[1,2],[1,0,0,1]],v100,fine,tool0;".into(), ": expected , behind a plain number"),
        (format!("GOTO again;{one}"), ": jumps are not followed; expected the motions in the order they run"),
        (
            format!("{one}b;\nENDPROC\nPROC b()\n{one}"),
            ": a motion in the routine of line 5, beside those of line 1; expected all motions in one routine",
        ),
    ] {
        let message =
            parse(Language::Rapid, &format!("PROC main()\n{source}\nENDPROC\n"), &RobotOptions::default()).unwrap_err();
        assert!(message.ends_with(end), "{message}");
        assert!(message.starts_with("p.mod:"), "{message}");
    }
}

#[test]
fn a_rapid_target_that_moves_is_written_where_it_is_used() {
    let source = "MODULE m\n CONST robtarget p1:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n PROC main()\n  MoveL p1,v50,fine,tool0;\n  \
                  MoveC Offs(p1,5,5,0), Offs(p1,10,0,0), v50, z1, tool0; ! arc\n  MoveL p1,v50,fine,tool0;\n ENDPROC\nENDMODULE";
    let program = parse(Language::Rapid, source, &RobotOptions::default()).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    let wanted: Vec<Vector3<f64>> = path.positions_mm().into_iter().map(|p| p + Vector3::new(0.0, 0.0, 0.25)).collect();
    let written =
        program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(NumberFormat::new(2, 4).unwrap())).unwrap();
    let at = |x: &str, y: &str| format!("[[{x},{y},0.25],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let expected = source
        .replace("MoveL p1", &format!("MoveL {}", at("0", "0")))
        .replace("Offs(p1,5,5,0)", &at("5.000", "5.000"))
        .replace("Offs(p1,10,0,0)", &at("10.000", "0.000"));
    assert_eq!(String::from_utf8_lossy(written.bytes()), expected);
}

#[test]
fn listings_mean_what_they_say() {
    let of = |name: &str| program(&format!("ls/{name}.ls")).toolpath(coarse()).unwrap();
    let path = of("01_plain");
    assert_eq!(shape(&path), (27, 25, [0.0, 0.0, 50.0], [0.0, 0.0, 50.0]));
    assert_eq!(path.points()[4].feed_mm_per_min, Some(1200.0));
    // W of 180 degrees: the z axis of the tool points down.
    assert!((platform(&path, 3) * Vector3::z() + Vector3::z()).norm() < 1e-12);
    assert_eq!(shape(&of("02_reused")), (13, 13, [0.0; 3], [0.0; 3]));
    let path = of("03_circle");
    assert!((path.length_mm() - 40.0 * std::f64::consts::PI).abs() < 1e-9);
    assert!(path.points().iter().all(|point| (point.position_mm.norm() - 20.0).abs() < 1e-9));
    assert_eq!(shape(&of("04_names")), (4, 4, [1.5, 2.5, 3.5], [31.5, 2.5, 3.5]));
    assert_eq!(of("06_no_numbers").points()[0].feed_mm_per_min, Some(2400.0));
    let path = of("07_external");
    assert_eq!(path.external_axes(), ["external_rail_mm"]);
    assert_eq!((path.points()[0].external[0], path.points()[path.len() - 1].external[0]), (100.0, 200.0));
    let feeds: Vec<_> = of("09_speeds").points().iter().map(|point| (point.feed_mm_per_min, point.cutting)).collect();
    assert_eq!(
        feeds,
        [(Some(1000.0), true), (Some(254.0), true), (None, true), (None, true), (None, true), (None, false)]
    );
    let joints = program("ls/10_joints.ls");
    assert_eq!(joints.notes().unlocated_lines, [18, 21]);
    assert_eq!(shape(&joints.toolpath(coarse()).unwrap()), (3, 3, [10.0, 0.0, 5.0], [30.0, 0.0, 5.0]));
    let frames = program("ls/14_frames.ls");
    let path = frames.toolpath(coarse()).unwrap();
    // The first frame is W; the second stands 20 mm along and 50 mm beside it, turned by 90 degrees, and the position turns back.
    assert_eq!(shape(&path), (8, 8, [0.0; 3], [20.0, 50.0, 0.0]));
    assert_eq!(frames.notes().tool_tip_mm, Some(("utool[3]".into(), Vector3::new(10.0, 0.0, 200.0))));
    let back = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -FRAC_PI_2);
    assert!((0..path.len()).all(|point| platform(&path, point).angle_to(&back) < 1e-7));
    let turned = rotation_of_abc([-0.384, -39.284, -175.389]);
    assert!(platform(&of("16_turned"), 0).angle_to(&turned) < 1e-7);
}

/// A listing of these instructions, and of positions with these coordinates.
fn listing(instructions: &[&str], positions: &[[f64; 3]]) -> String {
    let numbered = instructions.iter().enumerate().map(|(k, text)| format!("{:4}:{text} ;\n", k + 1));
    let positions = positions.iter().enumerate().map(|(k, [x, y, z])| {
        let pose = format!("X = {x}  mm,\tY = {y}  mm,\tZ = {z}  mm,\n\tW = 180.0 deg,\tP = 0.0 deg,\tR = 0.0 deg");
        format!("P[{}]{{\n   GP1:\n\tUF : 1, UT : 1,\tCONFIG : 'N U T, 0, 0, 0',\n\t{pose}\n}};\n", k + 1)
    });
    let (program, positions) = (numbered.collect::<String>(), positions.collect::<String>());
    format!("/PROG  A\n/ATTR\nLINE_COUNT\t= {};\n/MN\n{program}/POS\n{positions}/END\n", instructions.len())
}

#[test]
fn positions_of_a_listing_change_in_their_places_unless_they_are_used_twice() {
    let lines = ["L P[1] 20mm/sec FINE", "L P[2] 20mm/sec CNT50", "  !P two", "L P[1] 20mm/sec FINE"];
    let source = listing(&lines, &[[0.0, 0.0, 0.0], [30.0, 0.0, 0.0]]);
    let program = parse(Language::Ls, &source, &RobotOptions::default()).unwrap();
    let path = program.toolpath(coarse()).unwrap();
    let wanted: Vec<Vector3<f64>> = path.positions_mm().into_iter().map(|p| p + Vector3::new(0.0, 0.0, 0.25)).collect();
    let written = program.rewrite(
        &path,
        &wanted,
        None,
        WriteOptions { tolerance_mm: 0.005, ..WriteOptions::with_decimals(program.own_format()) },
    );
    let body = |x: &str| {
        listing(&[], &[[0.0; 3]])
            .split_once('{')
            .unwrap()
            .1
            .replace("X = 0", &format!("X = {x}"))
            .replace("Z = 0", "Z = 0.250")
    };
    let added = body("0").replace("/END\n", "");
    let expected = source
        .replacen("L P[1]", "L P[3]", 1)
        .replacen("   4:L P[1]", "   4:L P[4]", 1)
        .replace("X = 30  mm,\tY = 0  mm,\tZ = 0 ", "X = 30  mm,\tY = 0  mm,\tZ = 0.250 ")
        .replace("/END\n", &format!("P[3]{{{added}P[4]{{{added}/END\n"));
    assert_eq!(String::from_utf8_lossy(written.unwrap().bytes()), expected);
}

#[test]
fn lines_of_a_listing_are_counted_on_where_one_becomes_several() {
    let source = listing(
        &["L P[1] 20mm/sec FINE", "L P[2] 20mm/sec FINE ACC50", "  !end"],
        &[[0.0, 0.0, 0.0], [20.0, 0.0, 0.0]],
    );
    let program = parse(Language::Ls, &source, &RobotOptions::default()).unwrap();
    let path = program.toolpath(Sampling::new(0.01, 10.0).unwrap()).unwrap();
    let wanted = [Vector3::zeros(), Vector3::new(10.0, 1.0, 0.0), Vector3::new(20.0, 0.0, 0.0)];
    let written =
        program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(NumberFormat::new(3, 4).unwrap())).unwrap();
    let text = String::from_utf8_lossy(written.bytes()).into_owned();
    let (program, positions) = text.split_once("/POS\n").unwrap();
    assert_eq!(
        program,
        "/PROG  A\n/ATTR\nLINE_COUNT\t= 4;\n/MN\n   1:L P[1] 20mm/sec FINE ;\n   2:L P[3] 20mm/sec CNT100 ACC50 ;\n   \
         3:L P[2] 20mm/sec FINE ACC50 ;\n   4:  !end ;\n"
    );
    assert!(
        positions.contains("P[3]{\n   GP1:\n") && positions.contains("X = 10.000  mm,\tY = 1.000  mm,"),
        "{positions}"
    );
}

/// Instructions of a listing that are refused, and why.
const REFUSED_OF_LISTINGS: [(&str, &str); 18] = [
    ("L PR[1] 20mm/sec FINE", "motions to registers (PR) and other places are not followed; expected P[n] of /POS"),
    (
        "L P[R[1]] 20mm/sec FINE",
        "positions whose number is computed are not followed; expected P[n] with a plain number",
    ),
    ("L P[7] 20mm/sec FINE", "P[7] is not known; expected its numbers in the file, or in the statement"),
    ("A P[1] 20mm/sec CNT100", "arcs by A and splines by S are not followed; expected L, C and J"),
    ("L P[1] 2.0sec FINE", "times of motions (sec) are not followed; expected a speed"),
    ("L P[1] 20mm/sec", "expected FINE or CNT behind the speed"),
    ("L P[1] FINE", "expected a speed in mm/sec, cm/min, inch/min, deg/sec or %"),
    ("L P[1] 20mm/sec FINE Offset,PR[1]", OPTIONS),
    ("L P[1] 20mm/sec FINE Tool_Offset", OPTIONS),
    ("L P[1] 20mm/sec FINE INC", OPTIONS),
    ("L P[1] 20mm/sec CNT100 TB .10sec,DO[1]=ON", OPTIONS),
    ("JMP LBL[1]", "jumps are not followed; expected the motions in the order they run, without labels to go to"),
    (
        "IF R[1]=1,JMP LBL[1]",
        "jumps are not followed; expected the motions in the order they run, without labels to go to",
    ),
    (
        "IF R[1]=1,CALL PART",
        "calls PART, which may move the tool; expected the program in one routine, or PART in robot_program.calls_kept if it does not",
    ),
    (
        "Weave Sine[1]",
        "calls WEAVE, which may move the tool; expected the program in one routine, or WEAVE in robot_program.calls_kept if it does not",
    ),
    ("$MNUFRAME[1,1]=PR[1]", "system variables are not followed; expected a program that does not set them"),
    ("UFRAME_NUM=R[1]", "expected a plain number"),
    ("P[R[1]]=LPOS", "assignments to positions without a plain number are not followed; expected P[n]"),
];

#[test]
fn listings_that_are_not_followed_are_refused_by_line_and_instruction() {
    let refused = |lines: &[&str]| {
        let source = listing(lines, &[[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [20.0, 10.0, 0.0]]);
        parse(Language::Ls, &source, &RobotOptions::default()).unwrap_err()
    };
    for (line, message) in REFUSED_OF_LISTINGS {
        assert_eq!(refused(&[line]), format!("p.ls:5: `{line} ;`: {message}"));
    }
    for (lines, message) in [
        (
            &["L P[1] 20mm/sec FINE", "P[1]=LPOS"][..],
            "p.ls:5: `L P[1] 20mm/sec FINE ;`: P[1] is computed in line 6; expected a point whose numbers the file gives",
        ),
        (
            &["FOR R[1]=1 TO 3", "L P[1] 20mm/sec FINE"],
            "p.ls:6: `L P[1] 20mm/sec FINE ;`: in FOR of line 5, where it may be skipped or repeated; expected outside, where it runs once",
        ),
        (
            &["END", "L P[1] 20mm/sec FINE"],
            "p.ls:6: `L P[1] 20mm/sec FINE ;`: a motion after the end of the program in line 5; expected none",
        ),
        (
            &["L P[1] 20mm/sec FINE", "UFRAME[1]=PR[1]"],
            "p.ls:6: `UFRAME[1]=PR[1] ;`: frames that are set between motions are not followed; expected UFRAME_NUM and UTOOL_NUM",
        ),
        (
            &["UFRAME_NUM=2", "L P[1] 20mm/sec FINE"],
            "p.ls:6: `L P[1] 20mm/sec FINE ;`: positions with another UF or UT than the one in force are not followed; expected UFRAME_NUM and UTOOL_NUM as in the position",
        ),
        (
            &["C P[1] P[2] 20mm/sec FINE"],
            "p.ls:5: `C P[1] P[2] 20mm/sec FINE ;`: circular motion from a place that is not known; expected a motion to a full pose before it",
        ),
    ] {
        assert_eq!(refused(lines), message);
    }
    let joints = listing(&["L P[1] 20mm/sec FINE"], &[[0.0; 3]])
        .replace("X = 0  mm,\tY = 0  mm,\tZ = 0  mm,\n\tW = 180.0 deg,\tP = 0.0 deg,\tR = 0.0 deg", "J1= 0 deg");
    for (source, end) in [
        (joints.as_str(), ": L and C to positions of joints (J1 …) are not followed; expected X, Y, Z, W, P, R"),
        (
            "\u{1}\u{2}TP",
            ": expected a listing with /PROG and /MN; a binary .tp becomes one by PrintTP of WinOLPC or ROBOGUIDE, or by saving the program as .ls on the controller (ASCII Upload)",
        ),
        (
            "/PROG A\n/MN\n   1:L P[1] 20mm/sec FINE\n/POS\n",
            "p.ls:3: `L P[1] 20mm/sec FINE`: expected ; at the end of the instruction",
        ),
        ("/PROG A\n/POS\n/MN\n", "p.ls:2: `/POS`: expected /MN before /POS"),
        ("/PROG A\n/MN\nL P[1]\n", "p.ls:3: `L P[1]`: expected the number of a line and :"),
    ] {
        let message = parse(Language::Ls, source, &RobotOptions::default()).unwrap_err();
        assert!(message.ends_with(end), "{message}");
    }
}

/// Refusal of options of motions in a listing.
const OPTIONS: &str = "options other than ACC, Wjnt, PTH, COORD, EV, Ind.EV and BREAK behind FINE or CNT are not followed; expected none that \
                       shift the position (Offset, Tool_Offset, INC, VOFFSET), act on the way (TA, TB, DB, Skip), or turn (RTCP)";

#[test]
fn what_a_listing_does_behind_a_condition_counts() {
    for (line, message) in [
        ("IF (DI[1]),P[1]=PR[1]", "P[1] is computed in line"),
        ("IF R[1]=1,p[1]=P[2]", "P[1] is computed in line"),
        ("P [1]=P[2]", "P[1] is computed in line"),
        ("IF R[1]=1 OR R[2]=3,UFRAME_NUM=2", "in IF of line"),
        ("IF (DI[1]),UFRAME[1]=PR[1]", "frames that are set between motions are not followed"),
        ("IF (DI[1]),$MCR.$GENOVERRIDE=5", "system variables are not followed"),
        ("IF (DI[1]),L P[1] 20mm/sec FINE", "in IF of line"),
        ("SELECT R[1]=1,CALL ARC", "calls ARC"),
        ("WAIT DI[1]=ON TIMEOUT,LBL[1]", "jumps are not followed"),
    ] {
        let source = listing(&["L P[2] 20mm/sec FINE", line, "L P[1] 20mm/sec FINE"], &[[0.0; 3], [10.0, 0.0, 0.0]]);
        let told = parse(Language::Ls, &source, &RobotOptions::default()).unwrap_err();
        assert!(told.contains(message), "{line}: {told}");
    }
    let harmless = [
        "L P[1] 20mm/sec FINE",
        "IF (DI[1]),DO[2]=ON",
        "IF R[1]=1,R[2]=3",
        "WAIT DI[3:timeout flag]=ON",
        "IF DI[5:RUN]=ON,DO[1]=ON",
        "IF SR[1]='a,b',DO[1]=ON",
    ];
    let source = listing(&harmless, &[[0.0; 3], [10.0, 0.0, 0.0]]);
    assert!(parse(Language::Ls, &source, &RobotOptions::default()).is_ok());
}

#[test]
fn scripts_move_once_and_know_what_they_call() {
    let pose = |x: f64| format!("p[{x}, 0.2, 0.1, 0, 3.1416, 0]");
    let head = format!("def prog():\n  a = {}\n  movel(a, a=0.5, v=0.1)\n", pose(0.1));
    for (line, message) in [
        ("ok = urcap_goto_station(2)", "calls urcap_goto_station"),
        ("if urcap_goto_station(2):\n  end", "calls urcap_goto_station"),
        ("return\n  movel(a)", "a motion after the end of the program in line 4"),
        ("get_part()", "calls get_part"),
    ] {
        let told = parse(Language::UrScript, &format!("{head}  {line}\nend\n"), &RobotOptions::default()).unwrap_err();
        assert!(told.contains(message), "{line}: {told}");
    }
    let endless = |change: &str| {
        let source = format!(
            "def prog():\n  a = {}\n  n = 0\n  while True:\n    movel(a, v=0.1)\n    {change}\n  end\nend\n",
            pose(0.1)
        );
        parse(Language::UrScript, &source, &RobotOptions::default()).map(drop)
    };
    let told = endless(&format!("a = {}", pose(0.4))).unwrap_err();
    assert!(told.contains("what the next pass of an endless loop finds changed is not followed"), "{told}");
    for harmless in ["n = n + 1", "v = 3", "textmsg(to_str(get_actual_tcp_pose()))"] {
        endless(harmless).unwrap();
    }
    for call in
        ["if get_digital_in(1):\n  go()\nend", "while n < 3:\n  go()\nend", "thread t():\n  go()\nend", "go()\ngo()"]
    {
        let source = format!("def go():\n  movel({})\nend\n{call}\n", pose(0.1));
        let told = parse(Language::UrScript, &source, &RobotOptions::default()).unwrap_err();
        assert!(told.contains("functions with motions that are called in a branch"), "{call}: {told}");
    }
    // As PolyScope writes them: a function with a name like a motion's, many digits, and a word on safety.
    let source = "def move_part():\n  set_safety_mode_transition_hardness(1)\n  movel(p[0.100000000000000012, 0.2, 0.1, 0, 3.1416, 0])\nend\nmove_part()\n";
    let path = parse(Language::UrScript, source, &RobotOptions::default()).unwrap().toolpath(coarse()).unwrap();
    assert_eq!(shape(&path).0, 1);
}

#[test]
fn frames_of_a_listing_are_known_by_the_process_or_refused() {
    let lines = ["UFRAME_NUM=1", "L P[1] 20mm/sec FINE", "UFRAME_NUM=2", "L P[2] 20mm/sec FINE"];
    let (before, behind) = (listing(&lines, &[[0.0; 3], [5.0, 0.0, 0.0]]), "P[2]{\n   GP1:\n\tUF : 1");
    let source = before.replace(behind, "P[2]{\n   GP1:\n\tUF : 2");
    let message = parse(Language::Ls, &source, &RobotOptions::default()).unwrap_err();
    assert!(message.ends_with("where uframe[2] stands to the base before it is not known; expected its pose in robot_program.bases of the process"));
    let mut options = RobotOptions::default();
    options.bases.insert("uframe[1]".into(), Isometry3::translation(100.0, 0.0, 0.0));
    options.bases.insert("uframe[2]".into(), Isometry3::translation(0.0, 50.0, 0.0));
    let path = parse(Language::Ls, &source, &options).unwrap().toolpath(coarse()).unwrap();
    let (_, _, first, last) = shape(&path);
    assert_eq!((first, last), ([100.0, 0.0, 0.0], [5.0, 50.0, 0.0]));
}

#[test]
fn scripts_mean_what_they_say() {
    let of = |name: &str| program(&format!("urscript/{name}.script")).toolpath(coarse()).unwrap();
    let plain = program("urscript/01_plain.script");
    let path = plain.toolpath(coarse()).unwrap();
    assert_eq!(plain.notes().unlocated_lines, [3]);
    assert_eq!(shape(&path), (11, 11, [400.0, -200.0, 100.0], [460.0, -160.0, 100.0]));
    assert_eq!(path.points()[1].feed_mm_per_min, Some(3000.0));
    assert_eq!(plain.notes().tool_tip_mm.as_ref().unwrap().1, Vector3::new(0.0, 0.0, 200.0));
    // A turn by π about x points the tool down.
    assert!((platform(&path, 3) * Vector3::z() + Vector3::z()).norm() < 1e-8);
    let path = of("02_positional");
    assert_eq!(shape(&path), (16, 16, [400.0, 100.0, 100.0], [400.0, 150.0, 100.0]));
    assert!(path.points().iter().all(|point| point.feed_mm_per_min == Some(1200.0)));
    let path = of("03_circle");
    assert!((path.length_mm() - 40.0 * std::f64::consts::PI).abs() < 1e-9);
    let named = program("urscript/04_named.script");
    let path = named.toolpath(coarse()).unwrap();
    assert_eq!((path.points()[0].cutting, path.points()[1].feed_mm_per_min), (false, Some(15000.0)));
    assert!(named.notes().named_points && named.notes().unlocated_lines.is_empty());
    assert_eq!(shape(&of("05_loop")), (6, 6, [100.0, 200.0, 300.0], [150.0, 200.0, 300.0]));
    // The feature is turned by 90 degrees about z; the first frame is W.
    let path = of("06_feature");
    assert_eq!((path.points()[0].position_mm.norm(), path.points()[5].position_mm), (0.0, Vector3::x() * 50.0));
    assert_eq!(shape(&of("12_lines")), (3, 3, [100.0, 200.0, 300.0], [120.0, 200.0, 300.0]));
    let joints = program("urscript/10_joints.script");
    assert_eq!(joints.notes().unlocated_lines, [3, 6]);
    let feeds: Vec<_> = of("14_times").points().iter().map(|point| point.feed_mm_per_min).collect();
    assert_eq!(feeds, [None, Some(6000.0), Some(6000.0), None, None]);
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(1.2, -0.4, 2.0));
    assert!(platform(&of("11_turned"), 0).angle_to(&rotation) < 1e-7);
}

#[test]
fn features_of_a_script_stand_in_the_base_of_the_robot() {
    let source = fs::read_to_string(folder().join("urscript/06_feature.script")).unwrap();
    let mut options = RobotOptions::default();
    options.bases.insert("base".into(), Isometry3::translation(-100.0, 0.0, 0.0));
    options.bases.insert("world".into(), Isometry3::translation(-100.0, 0.0, 0.0));
    let path = parse(Language::UrScript, &source, &options).unwrap().toolpath(coarse()).unwrap();
    let (_, _, first, last) = shape(&path);
    assert_eq!((first, last), ([400.0, 200.0, 50.0], [380.0, 250.0, 50.0]));
}

#[test]
fn scripts_that_are_not_followed_are_refused_by_line_and_statement() {
    let refused = |source: &str| parse(Language::UrScript, source, &RobotOptions::default()).unwrap_err();
    let pose = "p[0.1,0.2,0.3,0,0,0]";
    let computed = "computed targets and positions of joints are not followed; expected p[x,y,z,rx,ry,rz] in plain numbers, its name, or pose_trans(feature, pose)";
    for (line, message) in [
        ("movel([0,-1.57,1.57,0,0,0])".into(), computed.to_owned()),
        ("movel(pose_add(a, b))".into(), computed.to_owned()),
        ("movel(here)".into(), "here is not known; expected its numbers in the file, or in the statement".into()),
        ("movel(p[0,0,x,0,0,0])".into(), "expected a plain number".into()),
        (format!("movel({pose}, t=2)"), "times of motions (t) are not followed; expected a speed v".into()),
        (format!("movel({pose}, speed=2)"), "expected the arguments of the URScript manual, each once".into()),
        (format!("movel({pose}, a=1, a=2)"), "expected the arguments of the URScript manual, each once".into()),
        (format!("movel({pose}); sleep(1)"), "expected nothing behind the )".into()),
        (format!("movel({pose}"), "expected ( and ) on the same line".into()),
        (
            format!("movec({pose}, {pose}, mode=1)"),
            "circles that carry the orientation along (mode=1) are not followed; expected mode=0".into(),
        ),
        (
            format!("servoj(get_inverse_kin({pose}))"),
            "motions that servo, follow, push or give way are not followed; expected movel, movep, movec and movej".into(),
        ),
        (format!("x = movel({pose})"), "expected a motion on a line of its own".into()),
        (
            "grip(5)".into(),
            "calls grip, which may move the tool; expected the program in one routine, or grip in robot_program.calls_kept if it does not".into(),
        ),
        ("what now".into(), "not a statement that is known; expected a statement of URScript".into()),
    ] {
        assert_eq!(refused(&format!("def a():\n{line}\nend\n")), format!("p.script:2: `{line}`: {message}"));
    }
    for (source, message) in [
        (
            format!("def a():\nx = {pose}\nif y:\nx = p[0,0,0,0,0,0]\nend\nmovel(x)\nend"),
            "p.script:6: `movel(x)`: x is computed in line 4; expected a point whose numbers the file gives",
        ),
        (
            format!("def a():\nset_tcp({pose})\nend\ndef b():\nmovel({pose})\nend"),
            "p.script:5: `movel(p[0.1,0.2,0.3,0,0,0])`: set_tcp in other functions than the motions is not followed; expected set_tcp before them",
        ),
        // What a function finds in a variable depends on when it runs; an argument is another each time.
        (
            format!("x = {pose}\ndef a():\nmovel(x)\nend\nx = p[0,0,0,0,0,0]\na()"),
            "p.script:3: `movel(x)`: x is computed in line 3; expected a point whose numbers the file gives",
        ),
        (
            format!("x = {pose}\ndef a(x):\nmovel(x)\nend\na(x)"),
            "p.script:3: `movel(x)`: x is computed in line 3; expected a point whose numbers the file gives",
        ),
        (
            format!("def a():\nx = {pose}\nb()\nmovel(x)\nend\ndef b():\nglobal x = p[0,0,0,0,0,0]\nend"),
            "p.script:4: `movel(x)`: x is computed in line 4; expected a point whose numbers the file gives",
        ),
        (
            format!("while i < 3:\nmovel({pose})\nend"),
            "p.script:2: `movel(p[0.1,0.2,0.3,0,0,0])`: in while of line 1, where it may be skipped or repeated; expected outside, where it runs once",
        ),
        (
            format!("movel({pose})\nwhile True:\nmovel({pose})\nend"),
            "p.script:3: `movel(p[0.1,0.2,0.3,0,0,0])`: in while of line 2, where it may be skipped or repeated; expected outside, where it runs once",
        ),
        (
            format!("def a():\nmovel({pose})\nend\ndef b():\nmovel({pose})\nend"),
            "p.script:5: `movel(p[0.1,0.2,0.3,0,0,0])`: a motion in the routine of line 4, beside those of line 1; expected all motions in one routine",
        ),
        (
            format!("while True:\nmovel({pose})\nend\nmovel({pose})"),
            "p.script:4: `movel(p[0.1,0.2,0.3,0,0,0])`: a motion after the end of the program in line 3; expected none",
        ),
        (
            format!("while True:\nmovel({pose})\nset_tcp({pose})\nend"),
            "p.script:3: `set_tcp(p[0.1,0.2,0.3,0,0,0])`: set_tcp behind motions of an endless loop is not followed; expected set_tcp before it",
        ),
        (
            format!("movec({pose}, p[0,0,0,0,0,0])"),
            "p.script:1: `movec(p[0.1,0.2,0.3,0,0,0], p[0,0,0,0,0,0])`: circular motion from a place that is not known; expected a motion to a full pose before it",
        ),
    ] {
        assert_eq!(refused(&source), message);
    }
}

/// Radii of blends at the ends of motions in a script and the places of these ends, mm, by a reading of its own.
fn blends_of_script(text: &str) -> Vec<(f64, Vector3<f64>)> {
    let motions = text.lines().filter(|line| line.trim_start().starts_with("movel(p["));
    let motion = |line: &str| {
        let numbers: Vec<f64> = line.split(['[', ',', ']']).filter_map(|number| number.trim().parse().ok()).collect();
        let radius = line.split("r=").nth(1).map_or(0.0, |r| r.trim_end_matches(')').parse().unwrap());
        (radius * 1e3, Vector3::new(numbers[0], numbers[1], numbers[2]) * 1e3)
    };
    motions.map(motion).collect()
}

#[test]
fn blends_of_scripts_do_not_meet() {
    let source = fs::read_to_string(folder().join("urscript/13_blend.script")).unwrap();
    let program = parse(Language::UrScript, &source, &RobotOptions::default()).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    let wanted: Vec<Vector3<f64>> =
        path.positions_mm().into_iter().map(|p| p + Vector3::z() * (0.3 * (p.x * 0.5 + p.y * 0.4).sin())).collect();
    let written = program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(program.own_format())).unwrap();
    let blends = blends_of_script(&String::from_utf8_lossy(written.bytes()));
    assert!(blends.len() > 30, "{}", blends.len());
    for pair in blends.windows(2) {
        let distance = (pair[1].1 - pair[0].1).norm();
        assert!(pair[0].0 + pair[1].0 < distance, "{pair:?}");
    }
    // Those in between go on; the first and the last point are stopped at as before.
    assert!(blends[1..blends.len() - 1].iter().all(|(radius, _)| *radius > 0.1));
    assert_eq!((blends[0].0, blends[blends.len() - 1].0), (0.0, 0.0));
}

#[test]
fn points_in_between_are_blended_in_all_languages() {
    let krl = |x: f64, end: &str| format!("LIN {{X {x},Y 0,Z 0,A 0,B 0,C 0}}{end}\n");
    let rapid = |x: f64, zone: &str| {
        format!("MoveL [[{x},0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v20,{zone},tool0;\n")
    };
    let lines = |texts: [String; 2]| texts.concat();
    for (language, source, spacing_mm, between, end) in [
        (Language::Krl, lines([krl(0.0, ""), krl(60.0, "")]), 10.0, "} C_DIS", "}"),
        (Language::Krl, lines([krl(0.0, ""), krl(60.0, " C_VEL")]), 10.0, "} C_VEL", "} C_VEL"),
        // A stop at the end stays; zones of 1 mm where the program has none, or says not how large they are.
        (Language::Rapid, lines([rapid(0.0, "fine"), rapid(60.0, "fine")]), 10.0, ",v20,z1,tool0;", ",v20,fine,tool0;"),
        (
            Language::Rapid,
            lines([rapid(0.0, "fine"), rapid(60.0, "fine\\Inpos:=inpos50")]),
            10.0,
            ",v20,z1,tool0;",
            ",v20,fine\\Inpos:=inpos50,tool0;",
        ),
        (
            Language::Rapid,
            lines([rapid(0.0, "fine"), rapid(60.0, "myzone")]),
            10.0,
            ",v20,z1,tool0;",
            ",v20,myzone,tool0;",
        ),
        // Below half of 30 mm, and of 10 mm; of 0.5 mm it is none of the predefined ones.
        (Language::Rapid, lines([rapid(0.0, "fine"), rapid(60.0, "z10")]), 30.0, ",v20,z10,tool0;", ",v20,z10,tool0;"),
        (Language::Rapid, lines([rapid(0.0, "fine"), rapid(60.0, "z50")]), 10.0, ",v20,z1,tool0;", ",v20,z50,tool0;"),
        (Language::Rapid, lines([rapid(0.0, "fine"), rapid(3.0, "z5")]), 0.5, ",v20,[FALSE,0.22", ",v20,z5,tool0;"),
        (
            Language::Rapid,
            lines([rapid(0.0, "fine"), rapid(3.0, "[FALSE,0.2,0.2,0.2,0.02,0.2,0.02]")]),
            0.5,
            ",v20,[FALSE,0.2,0.2",
            ",v20,[FALSE,0.2,0.2,0.2,0.02,0.2,0.02],tool0;",
        ),
    ] {
        let source = if language == Language::Rapid { format!("PROC a()\n{source}ENDPROC\n") } else { source };
        let program = parse(language, &source, &RobotOptions::default()).unwrap();
        let path = program.toolpath(Sampling::new(1.0, spacing_mm).unwrap()).unwrap();
        let bent = |(k, p): (usize, Vector3<f64>)| p + Vector3::y() * if k % 2 == 1 { 0.05 } else { 0.0 };
        let wanted: Vec<Vector3<f64>> = path.positions_mm().into_iter().enumerate().map(bent).collect();
        let written = program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(program.own_format())).unwrap();
        let text = String::from_utf8_lossy(written.bytes()).into_owned();
        let motions: Vec<&str> =
            text.lines().filter(|line| line.starts_with("LIN") || line.starts_with("MoveL")).collect();
        assert_eq!(motions.len(), path.len());
        let (last, inner) = motions[1..].split_last().unwrap();
        assert!(last.ends_with(end), "{last}");
        assert!(!inner.is_empty() && inner.iter().all(|line| line.contains(between)), "{inner:?}");
        assert!(!last.ends_with(" C_DIS"), "{last}");
    }
}

#[test]
fn a_circle_of_a_script_that_bends_becomes_lines_with_its_speed() {
    let source = "movel(p[0.02,0,0,0,0,0])\nmovec(p[0,0.02,0,0,0,0], p[-0.02,0,0,0,0,0], 1.5, 0.02, 0, 0) # arc\n";
    let program = parse(Language::UrScript, source, &RobotOptions::default()).unwrap();
    let path = program.toolpath(Sampling::new(5.0, 40.0).unwrap().with_max_turn(2.0).unwrap()).unwrap();
    let bent = |(k, p): (usize, Vector3<f64>)| p + Vector3::z() * if k % 2 == 1 { 2.0 } else { 0.0 };
    let wanted: Vec<Vector3<f64>> = path.positions_mm().into_iter().enumerate().map(bent).collect();
    let written = program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(program.own_format())).unwrap();
    assert_eq!(
        String::from_utf8_lossy(written.bytes()),
        "movel(p[0.02,0,0,0,0,0])\nmovel(p[0.010000,0.017321,0.002000,0,0,0], a=1.5, v=0.02, r=0.0010000)\n\
         movel(p[-0.010000,0.017321,0,0,0,0], a=1.5, v=0.02, r=0.0010000)\n\
         movel(p[-0.02,0,0.002000,0,0,0], a=1.5, v=0.02, r=0) # arc\n"
    );
}

#[test]
fn apt_programs_mean_what_they_say() {
    let of = |name: &str| program(&format!("apt/{name}")).toolpath(coarse()).unwrap();
    let axis = |path: &Toolpath, point: usize| match path.points()[point].orientation {
        Some(Orientation::ToolAxis(axis)) => Some(<[f64; 3]>::from(axis)),
        _ => None,
    };
    let path = of("01_plain.apt");
    assert_eq!(shape(&path), (12, 9, [0.0, 0.0, 100.0], [0.0, 0.0, 100.0]));
    assert_eq!((path.points()[4].feed_mm_per_min, path.points()[4].spindle_rev_per_min), (Some(500.0), Some(8000.0)));
    assert_eq!((path.points()[4].tool, axis(&path, 4)), (Some(3), None));
    let path = of("02_axes.cls");
    assert_eq!(shape(&path), (5, 5, [0.0, 0.0, 0.0], [20.0, 10.0, 0.0]));
    assert_eq!((axis(&path, 0), axis(&path, 4)), (Some([0.0, 0.0, 1.0]), Some([0.6, 0.0, 0.8])));
    let path = of("03_inches.ncl");
    assert_eq!(shape(&path), (4, 4, [25.4, 0.0, 0.0], [50.8, 0.0, 0.0]));
    assert_eq!(path.points()[1].feed_mm_per_min, Some(254.0));
    assert_eq!(shape(&of("04_continued.apt")), (3, 3, [1.5, 2.5, 3.5], [11.5, 12.5, 3.5]));
    assert_eq!(shape(&of("05_crlf.cl")), (3, 3, [0.0, 0.0, 0.0], [20.0, 0.0, 0.0]));
    assert_eq!(shape(&of("06_utf8_no_end.apt")), (3, 3, [0.0, 0.0, 0.0], [20.0, 0.0, 0.0]));
    assert_eq!(shape(&of("07_steps.apt")), (7, 7, [0.0, 0.0, 0.0], [20.0, 20.0, 0.0]));
    assert_eq!(of("08_per_turn.cl").points()[1].feed_mm_per_min, Some(200.0));
    assert_eq!(shape(&of("09_from.apt")), (4, 2, [0.0, 0.0, 50.0], [10.0, 0.0, 0.0]));
    assert_eq!(shape(&of("10_texts.apt")), (3, 3, [0.0, 0.0, 0.0], [20.0, 0.0, 0.0]));
    let path = of("11_axis_kept.cls");
    assert_eq!(axis(&path, path.len() - 1), Some([0.0, 0.6, 0.8]));
    assert_eq!(shape(&of("12_numbers.cldata")), (2, 2, [-0.5, 10.0, 7.0], [-0.5, 20.0, 7.0]));
    let home = program("apt/13_home.apt");
    assert_eq!((home.notes().unlocated_lines.as_slice(), home.toolpath(coarse()).unwrap().len()), ([3].as_slice(), 3));
    assert_eq!(shape(&of("14_lower.apt")), (3, 3, [0.0, 0.0, 0.0], [20.0, 0.0, 0.0]));
    assert_eq!(shape(&of("15_geometry.cl")), (3, 3, [0.0, 0.0, 0.0], [20.0, 0.0, 0.0]));
}

#[test]
fn apt_that_is_not_followed_is_refused_by_line_and_record() {
    let computed = ": turned tables, splines and computed motions are not followed; expected GOTO/x,y,z,i,j,k";
    let functions = ": G functions that give coordinates another meaning are not followed; expected none of them, or PREFUN in robot_program.calls_kept if they do not";
    let circle = ": expected x,y,z,i,j,k (SolidWorks CAM), x,y,z,i,j,k,r behind a header of Pro/CLfile (Creo), or x,y,z,i,j,k,r,t,f,d,e (NX)";
    let cycle = ": expected DRILL, DEEP, BRKCHP, FACE, REAM, BORE or TAP with FEDTO or DEPTH, RAPTO or CLEAR, and RTRCTO, each before its number";
    let block = ": blocks of a control that INSERT puts into the program are not followed; expected a comment, or INSERT in \
                 robot_program.calls_kept if none moves the tool";
    let behind = ": expected the motion of the circle behind CIRCLE or INDIRV";
    let turned = ": expected TLON,GOFWD/(CIRCLE/x,y,z,r),ON,(LINE/…) or (CYLNDR/x,y,z,i,j,k,r),ON,(PLANE/…) behind INDIRV, outside of cycles and RAPID";
    let hole = ": expected GOTO of a hole in a cycle, and no RAPID before the end of an arc";
    let no_circle = ": start, middle and end are on no circle; expected three points apart and not on a line";
    for (source, end) in [
        ("CIRCLE/0,0,0,0,0,1,5,0.01", circle),
        ("CIRCLE/0,0,0,0,0,1,5", circle),
        ("CIRCLE/0,5,0,0,0,0\nGOTO/0,10,0", ": expected an axis i,j,k of length 1"),
        (
            "CIRCLE/0,5,0,0,0,1,5,.01,.5,10,0,TIMES,2",
            ": helices of several turns (TIMES) are not followed; expected an arc for each turn",
        ),
        ("CIRCLE/0,5,0,0,0,1\nFEDRAT/5\nGOTO/0,10,0", behind),
        ("RAPID\nCIRCLE/0,5,0,0,0,1\nGOTO/0,10,0", hole),
        (
            "CIRCLE/0,5,0,0,0,1\nGOTO/0,11,0",
            ": arc starts 5.0000 mm and ends 6.0000 mm from its centre; expected equal radii to 0.005 mm or 0.1 %",
        ),
        (
            "CIRCLE/0,5,0,0,0,1\nGOTO/5,5,0\nGOTO/0,10,0",
            ": points on the circle behind its first are not followed; expected one GOTO behind CIRCLE, the end of the arc",
        ),
        ("INDIRV/1,0,0\nTLON,GOFWD/C1,PAST,L2", turned),
        ("INDIRV/1,0,0\nGOTO/0,10,0", behind),
        // The first place where the circle meets the line is the other one; the direction is not that of the circle.
        ("INDIRV/-1,0,0\nTLON,GOFWD/(CIRCLE/0,5,0,5),ON,(LINE/0,5,0,5,5,0)", no_circle),
        ("INDIRV/1,1,0\nTLON,GOFWD/(CIRCLE/0,5,0,5),ON,(LINE/0,5,0,5,5,0)", no_circle),
        ("CYCLE/DRILL,5,MMPM,100", cycle),
        ("CYCLE/DRILL,FEDTO,0,RAPTO,3", cycle),
        ("CYCLE/DRILL,FEDTO,5,RAPTO,3,OPTION,2", cycle),
        ("CYCLE/MILL,FEDTO,5,RAPTO,3", cycle),
        ("CYCLE/DRILL,FEDTO,5,RAPTO,3\nGODLTA/1,0,0", hole),
        ("CYCLE/DRILL,FEDTO,5,RAPTO,3\nRAPID\nGOTO/1,0,0", hole),
        ("INSERT/G0 Z100", block),
        ("INSERT/N10 M6", block),
        ("INSERT/L Z+100 FMAX", block),
        ("INSERT CALL LBL 5", block),
        ("INSERT/#500=3", block),
        ("TLDATA/TURN,1,2", ": programs of lathes are not followed; expected a program of a mill"),
        ("TOOLNO/1,TURN,2", ": programs of lathes are not followed; expected a program of a mill"),
        ("PREFUN/68", functions),
        ("PREFUN/54,90\nPREFUN/54\nPREFUN/55", functions),
        ("TRNTYP/LOCAL,0,0,0", ": other kinds of coordinates are not followed; expected TRNTYP/WORLD,0,0,0"),
        (
            "$$-> CSYS / 1,0,0,0, $\n0,1,0,0,0,0,1,0\n$$-> CSYS / 1,0,0,5, $\n0,1,0,0,0,0,1,0",
            ": second systems of coordinates are not followed; expected one for all points",
        ),
        (
            "$$*CATIA0\n$$ A\n$$ 1 0 0 0\n$$ 0 1 0 0\n$$ 0 0 1 0\n$$*CATIA0\n$$ B\n$$ 1 0 0 0\n$$ 0 1 0 9\n$$ 0 0 1 0",
            ": second systems of coordinates are not followed; expected one for all points",
        ),
        (
            "GOTO/0,0,0,1,0,0\nMULTAX/OFF\nGOTO/1,0,0",
            ": expected the tool axis i,j,k behind MULTAX/OFF, or TLAXIS before",
        ),
        ("NURBS/", computed),
        ("GOFWD/L1,TO,L2", computed),
        ("ROTABL/AAXIS,90", computed),
        ("GOTO/P1", ": expected a plain number"),
        ("GOTO/1,2", ": expected three plain numbers x,y,z, or six with the tool axis i,j,k"),
        ("GOTO/1,2,3,0,0,2", ": tool axis has length 2; expected 1"),
        ("UNITS/FEET", ": expected UNITS/MM or UNITS/INCHES"),
        (
            "SWIVEL/3",
            ": calls SWIVEL, which may move the tool; expected the program in one routine, or SWIVEL in robot_program.calls_kept if it does not",
        ),
        ("FINI\nGOTO/1,2,3", ": a motion after the end of the program in line 2; expected none"),
        (
            "MSYS/0,0,0,1,0,0,0,1,0\nMSYS/5,0,0,1,0,0,0,1,0",
            ": second systems of coordinates are not followed; expected one for all points",
        ),
    ] {
        let message = parse(Language::Apt, &format!("GOTO/0,0,0\n{source}\n"), &RobotOptions::default()).unwrap_err();
        assert!(message.starts_with("p.apt:") && message.ends_with(end), "{message}");
    }
}

#[test]
fn a_line_of_apt_that_bends_becomes_records() {
    let source = "FEDRAT/100,MMPM\nGOTO/0,0,0\n GOTO / 20.00 ,0,0 $$ end\nFINI\n";
    let program = parse(Language::Apt, source, &RobotOptions::default()).unwrap();
    let path = program.toolpath(Sampling::new(0.01, 10.0).unwrap()).unwrap();
    let wanted = [Vector3::zeros(), Vector3::new(10.0, 1.0, 0.0), Vector3::new(20.0, 0.0, 0.0)];
    let written =
        program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(NumberFormat::new(3, 4).unwrap())).unwrap();
    assert_eq!(
        String::from_utf8_lossy(written.bytes()),
        "FEDRAT/100,MMPM\nGOTO/0,0,0\n GOTO / 10.000 ,1.000,0\n GOTO / 20.00 ,0,0 $$ end\nFINI\n"
    );
}

#[test]
fn names_and_first_words_tell_the_language() {
    use std::path::Path;
    let of = |name: &str, text: &str| Language::detect(Path::new(name), text.as_bytes());
    assert_eq!(of("a.SRC", ""), Some(Language::Krl));
    assert_eq!(of("a.mod", "%%%\n VERSION:1\n%%%\nMODULE a"), Some(Language::Rapid));
    assert_eq!(of("a.prg", "G0 X1\n"), None);
    for name in ["a.ncl", "a.ncl.12", "a.aptsource", "a.clsf"] {
        assert_eq!(of(name, ""), Some(Language::Apt), "{name}");
    }
    assert_eq!((of("a.nc.1", ""), of("ncl.1", "")), (None, None));
    assert_eq!(of("a.script", ""), Some(Language::UrScript));
    assert_eq!((of("a.LS", ""), of("a.tp", "")), (Some(Language::Ls), Some(Language::Ls)));
    assert_eq!((of("a.nc", "MODULE"), of("a", "")), (None, None));
}

#[test]
fn a_write_tolerance_that_is_none_is_refused() {
    let program = parse(Language::Krl, "LIN {X 0,Y 0,Z 0,A 0,B 0,C 0}\n", &RobotOptions::default()).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    for tolerance_mm in [-0.1, f64::NAN, f64::INFINITY] {
        let writing = WriteOptions { tolerance_mm, ..WriteOptions::with_decimals(program.own_format()) };
        let refused = program.rewrite(&path, &path.positions_mm(), None, writing).unwrap_err();
        assert!(refused.to_string().starts_with(&format!("write tolerance {tolerance_mm} mm: expected")), "{refused}");
    }
}

#[test]
fn a_circle_that_grows_becomes_circles_within_the_tolerance() {
    for (language, head, keyword) in [(Language::Krl, "", "CIRC"), (Language::Rapid, "PROC a()\n", "MoveC")] {
        let pose = |x: f64, y: f64| match language {
            Language::Krl => format!("{{X {x},Y {y},Z 0,A 0,B 0,C 0}}"),
            _ => format!("[[{x},{y},0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"),
        };
        let end = if language == Language::Krl { " C_DIS\n" } else { ",v10,z1,tool0;\n" };
        let first = keyword.replace("CIRC", "LIN").replace("MoveC", "MoveL");
        let circle = format!("{first} {}{end}{keyword} {},{}{end}", pose(20.0, 0.0), pose(0.0, 20.0), pose(-20.0, 0.0));
        let program = parse(language, &format!("{head}{circle}"), &RobotOptions::default()).unwrap();
        let path = program.toolpath(Sampling::default()).unwrap();
        let grown = |p: Vector3<f64>| p * (1.0 + 0.01 * (p.y * 0.2).sin());
        let wanted: Vec<Vector3<f64>> = path.positions_mm().into_iter().map(grown).collect();
        let format = program.own_format();
        let count = |tolerance_mm: f64| {
            let written = program
                .rewrite(&path, &wanted, None, WriteOptions { tolerance_mm, ..WriteOptions::with_decimals(format) })
                .unwrap();
            let back = written.read_positions(&written.read().unwrap()).unwrap();
            assert!(back.iter().zip(&wanted).all(|(back, wanted)| (back - wanted).norm() <= tolerance_mm.max(0.002)));
            let text = String::from_utf8(written.into_bytes()).unwrap();
            (text.matches(keyword).count(), text.matches(&first).count())
        };
        assert_eq!(count(0.0), (0, path.len()));
        let (circles, lines) = count(0.005);
        assert!((2..12).contains(&circles) && lines < 6, "{circles} circles, {lines} lines");
    }
}

#[test]
fn a_number_that_stands_at_its_name_does_not_become_part_of_it() {
    let source = "LIN {X-5.0,Y.5,Z 0,A 0,B 0,C 0}\nLIN {X-15.0,Y.5}\n";
    let program = parse(Language::Krl, source, &RobotOptions::default()).unwrap();
    let path = program.toolpath(Sampling::new(0.1, 100.0).unwrap()).unwrap();
    let wanted: Vec<Vector3<f64>> = path.positions_mm().into_iter().map(|p| p + Vector3::new(10.0, 1.0, 0.0)).collect();
    let written = program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(program.own_format())).unwrap();
    let text = String::from_utf8_lossy(written.bytes()).into_owned();
    assert_eq!(text, "LIN {X 5.000,Y 1.500,Z 0,A 0,B 0,C 0}\nLIN {X-5.000,Y 1.500}\n");
}

fn number(most: f64) -> impl Strategy<Value = String> {
    (-most..most, 0..5usize).prop_map(|(value, decimals)| format!("{value:.decimals$}"))
}

fn krl_line() -> impl Strategy<Value = String> {
    let n = || number(300.0);
    let angles = || (number(179.0), number(89.0), number(179.0)).prop_map(|(a, b, c)| format!(",A {a},B {b},C {c}"));
    prop_oneof![
        (n(), n(), n(), angles()).prop_map(|(x, y, z, abc)| format!("LIN {{X {x},Y {y},Z {z}{abc}}} C_DIS ; ü")),
        (n(), n()).prop_map(|(x, z)| format!("  lin {{z {z}, x {x}}}")),
        (n(), n()).prop_map(|(x, z)| format!("LIN_REL {{Z {z}, X {x}}}")),
        (n(), n(), n(), angles()).prop_map(|(x, y, z, abc)| format!("PTP {{X {x},Y {y},Z {z}{abc},S 2,T 3}} C_PTP")),
        (n(), n(), n(), n()).prop_map(|(a, b, c, d)| format!("CIRC {{X {a},Y {b}}},{{X {c},Y {d}}} C_DIS")),
        number(2.0).prop_map(|speed| format!("$VEL.CP={speed}")),
        (n(), n(), angles()).prop_map(|(x, y, abc)| format!("$BASE={{X {x},Y {y},Z 1{abc}}}")),
        Just("PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}".into()),
        Just(";FOLD x {y}".into()),
        Just("WAIT SEC 1".into()),
    ]
}

/// Coordinates are refused beyond it, mm.
const MAX_MM: f64 = 1e6;

/// How far from zero a circle of the program may go, mm: by the circumference through its three points, which are read as the ends of lines.
fn farthest_circle_mm(language: Language, lines: &[String], ending: &str) -> f64 {
    let straight = |line: &String| match (language, line.split_once("},{"), line.split_once(",\n ")) {
        (Language::Krl, Some((via, end)), _) if line.starts_with("CIRC") => {
            format!("LIN {}}}{ending}LIN {{{}", via.trim_start_matches("CIRC "), end.trim_end_matches(" C_DIS"))
        }
        (Language::Rapid, _, Some((via, end))) if line.starts_with("MoveC") => {
            format!("MoveL {},v20,z5,t1;{ending}MoveL {end}", via.trim_start_matches("MoveC "))
        }
        _ => line.clone(),
    };
    let lines: Vec<String> = lines.iter().map(straight).collect();
    let path = parse(language, &lines.join(ending), &RobotOptions::default()).unwrap().toolpath(coarse()).unwrap();
    let ends = path.points().iter().filter(|point| point.source.parameter == 1.0);
    let mut ends: Vec<Vector3<f64>> = ends.map(|point| point.position_mm).collect();
    ends.dedup();
    let reach = |three: &[Vector3<f64>]| {
        let [a, b, c] = [three[1] - three[0], three[2] - three[1], three[0] - three[2]];
        let diameter = a.norm() * b.norm() * c.norm() / a.cross(&b).norm();
        three[0].norm() + diameter
    };
    ends.windows(3).map(reach).fold(0.0, f64::max)
}

/// A random program of an accepted kind is the same without correction, and leads where it should with one.
fn check_random(language: Language, lines: &[String], ending: &str) -> Result<(), TestCaseError> {
    let program = match parse(language, &lines.join(ending), &RobotOptions::default()) {
        Ok(program) => program,
        // Circles may be none.
        Err(refused) => {
            prop_assert!(refused.contains("circ") || refused.contains("B = ±90°"), "{}", refused);
            return Ok(());
        }
    };
    let path = match program.toolpath(Sampling::new(0.5, 40.0).unwrap().with_max_turn(0.3).unwrap()) {
        Ok(path) => path,
        Err(refused) => {
            prop_assert!(refused.to_string().contains("expected a position on the machine"), "{}", refused);
            let farthest = farthest_circle_mm(language, lines, ending);
            prop_assert!(farthest > MAX_MM, "{} though no circle goes beyond {} mm", refused, farthest);
            return Ok(());
        }
    };
    let format = program.own_format();
    let same = program.rewrite(&path, &path.positions_mm(), None, WriteOptions::with_decimals(format)).unwrap();
    prop_assert_eq!(same.bytes(), program.source());
    let wanted = corrected(&path);
    let written = program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(format)).unwrap();
    let back = written.read_positions(&written.read().unwrap()).unwrap();
    let unit_mm =
        10f64.powi(-i32::from(format.mm_decimals())).max(25.4 * 10f64.powi(-i32::from(format.inch_decimals())));
    for (back, wanted) in back.iter().zip(&wanted) {
        prop_assert!((back - wanted).norm() < 2.0 * unit_mm, "{} instead of {}", back, wanted);
    }
    Ok(())
}

fn rapid_line() -> impl Strategy<Value = String> {
    let target = || {
        (
            number(300.0),
            number(300.0),
            number(300.0),
            prop_oneof![Just("1,0,0,0"), Just("0.6,0,0.8,0"), Just("0,-0.70710678,0,0.70710678")],
        )
            .prop_map(|(x, y, z, q)| format!("[[{x},{y},{z}],[{q}],[0,-1,0,1],[9E9,9E+09,9E9,9E9,9E9,9E9]]"))
    };
    prop_oneof![
        target().prop_map(|p| format!("MoveL {p},v100,z1,t1\\WObj:=wobj0;")),
        target().prop_map(|p| format!("  MoveJ {p}, vmax, fine, t1; ! ü;")),
        (number(200.0), number(200.0)).prop_map(|(x, y)| format!("moveL Offs(p1,{x},{y},0.5),[20,500,0,0],fine,t1;")),
        (target(), target()).prop_map(|(p, q)| format!("MoveC {p},\n {q},v20,z5,t1;")),
        Just("MoveAbsJ [[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t1;".into()),
        Just("WaitTime 0.5; MoveL p1,v50,fine,t1; SetDO do1,1;".into()),
        Just("! MoveL nowhere".into()),
        Just("IF di1=1 THEN\nSet do2;\nENDIF".into()),
    ]
}

fn apt_line() -> impl Strategy<Value = String> {
    let n = || number(300.0);
    prop_oneof![
        (n(), n(), n()).prop_map(|(x, y, z)| format!("GOTO/{x},{y},{z}")),
        (n(), n(), n()).prop_map(|(x, y, z)| format!("GOTO / {x}, {y},$\n {z},0.6,0,0.8 $$ ü")),
        (n(), n()).prop_map(|(x, y)| format!("GODLTA/{x},{y},0")),
        Just("RAPID".into()),
        Just("UNITS/INCHES".into()),
        Just("UNITS/MM".into()),
        Just("GOHOME".into()),
        Just("FEDRAT/250.5,MMPM".into()),
        Just("PPRINT $ and GOTO/1,2,3".into()),
    ]
}

/// Drawn once: three points so nearly on a line that the way round leads beyond what coordinates may be.
#[test]
fn a_circle_that_goes_round_far_away_is_refused() {
    let lines = [
        "$BASE=$NULLFRAME",
        "LIN {X 0,Y 0,Z 0,A 0,B 10,C 0}",
        "$BASE={X 261,Y -181,Z 1,A -92,B -75.7,C 116.6}",
        "CIRC {X 203,Y -288},{X 27.1,Y 109} C_DIS",
    ]
    .map(str::to_owned);
    let program = parse(Language::Krl, &lines.join("\n"), &RobotOptions::default()).unwrap();
    let refused = program.toolpath(coarse()).unwrap_err().to_string();
    assert!(refused.starts_with("p.src:4: ") && refused.contains("expected a position on the machine"), "{refused}");
    assert!(farthest_circle_mm(Language::Krl, &lines, "\n") > MAX_MM);
    check_random(Language::Krl, &lines, "\n").unwrap();
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn random_rapid_is_written_back(lines in prop::collection::vec(rapid_line(), 1..15), crlf in any::<bool>()) {
        let p1 = "VAR robtarget p1:=[[1,2,3.5],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];";
        let first = ["MODULE a", p1, "PROC main()", "MoveL p1,v100,z1,t1;"].map(str::to_owned);
        let last = ["ENDPROC".to_owned(), "ENDMODULE".to_owned()];
        let lines: Vec<String> = first.into_iter().chain(lines).chain(last).collect();
        check_random(Language::Rapid, &lines, if crlf { "\r\n" } else { "\n" })?;
    }

    #[test]
    fn random_apt_is_written_back(lines in prop::collection::vec(apt_line(), 1..20), crlf in any::<bool>()) {
        let lines: Vec<String> = ["GOTO/0,0,0".to_owned()].into_iter().chain(lines).collect();
        check_random(Language::Apt, &lines, if crlf { "\r\n" } else { "\n" })?;
    }

    #[test]
    fn random_krl_is_written_back(lines in prop::collection::vec(krl_line(), 1..20), crlf in any::<bool>()) {
        let first = ["$BASE=$NULLFRAME", "LIN {X 0,Y 0,Z 0,A 0,B 10,C 0}"].map(str::to_owned);
        let lines: Vec<String> = first.into_iter().chain(lines).collect();
        check_random(Language::Krl, &lines, if crlf { "\r\n" } else { "\n" })?;
    }
}

proptest! {
    #![proptest_config(cases(128))]

    #[test]
    fn angles_lead_back_to_their_rotation(a in -180.0..180.0f64, b in -90.0..90.0f64, c in -180.0..180.0f64) {
        let rotation = rotation_of_abc([a, b, c]);
        prop_assert!(rotation_of_abc(abc_of_rotation(&rotation, 0.0)).angle_to(&rotation) < 1e-7);
    }

    #[test]
    fn where_b_is_a_right_angle_c_stays(a in -180.0..180.0f64, c in -180.0..180.0f64, up in any::<bool>()) {
        let rotation = rotation_of_abc([a, if up { 90.0 } else { -90.0 }, c]);
        let found = abc_of_rotation(&rotation, c);
        prop_assert!(rotation_of_abc(found).angle_to(&rotation) < 1e-7);
        prop_assert!(((found[0] - a) / 360.0 - ((found[0] - a) / 360.0).round()).abs() < 1e-7, "{:?}", found);
    }
}

#[test]
fn angles_are_those_of_kuka() {
    // R_z(A) R_y(B) R_x(C): the approach of a tool with A = 0, B = 90, C = 0 is along +x.
    assert!((rotation_of_abc([0.0, 90.0, 0.0]) * Vector3::z() - Vector3::x()).norm() < 1e-15);
    assert!((rotation_of_abc([90.0, 90.0, 0.0]) * Vector3::z() - Vector3::y()).norm() < 1e-15);
    assert!((rotation_of_abc([0.0, 0.0, 90.0]) * Vector3::z() + Vector3::y()).norm() < 1e-15);
}

/// The first coordinates, mm, to which the motions of a KRL program in base 1, 2 or 3 lead, whose bases in the world `data` says; or why it is refused.
fn in_bases(bases: &[usize], data: &str, options: &RobotOptions) -> Result<Vec<f64>, String> {
    let motion = |base: &usize| format!("$BASE=BASE_DATA[{base}]\nLIN {{X 0,Y 0,Z 0,A 0,B 0,C 0}}\n");
    let source = format!("DEF a ( )\n{}END\n", bases.iter().map(motion).collect::<String>());
    let beside = ("a.dat".to_owned(), data.as_bytes().to_vec());
    let program = RobotProgram::parse(source, "a.src", Language::Krl, Some(beside), options);
    let path = program.map_err(|refused| refused.to_string())?.toolpath(coarse()).unwrap();
    let ends = path.points().iter().filter(|point| point.source.parameter == 1.0);
    Ok(ends.map(|point| (point.position_mm.x * 1e9).round() / 1e9 + 0.0).collect())
}

/// The frame `name` at `x` mm, as a data list says it.
fn frame(name: &str, x: f64) -> String {
    format!("{name}={{X {x},Y 0,Z 0,A 0,B 0,C 0}}\n")
}

#[test]
fn the_first_base_is_the_workpiece_and_others_stand_to_it() {
    let mut options = RobotOptions::default();
    let data = format!("DEFDAT a\n{}{}ENDDAT\n", frame("BASE_DATA[1]", 100.0), frame("BASE_DATA[2]", 130.0));
    assert_eq!(in_bases(&[1, 2, 1], &data, &options).unwrap(), [0.0, 30.0, 0.0]);
    assert_eq!(in_bases(&[2, 1], &data, &options).unwrap(), [0.0, -30.0]);
    assert!(in_bases(&[1, 3], &data, &options).unwrap_err().contains("base_data[3] stands to the base"));
    // One that is nowhere is the workpiece as well, and nothing stands to it.
    assert_eq!(in_bases(&[3, 3], &data, &options).unwrap(), [0.0, 0.0]);
    assert!(in_bases(&[3, 1], &data, &options).is_err());
    // Before any base is named there is one without a name, to which none stands.
    let bare = "DEF a ( )\nLIN {X 7,Y 0,Z 0,A 0,B 0,C 0}\n";
    let unnamed = |rest: &str| parse(Language::Krl, &format!("{bare}{rest}END\n"), &RobotOptions::default());
    assert_eq!(unnamed("").unwrap().toolpath(coarse()).unwrap().points()[0].position_mm.x, 7.0);
    assert!(unnamed("$BASE={X 1,Y 0,Z 0,A 0,B 0,C 0}\nLIN {X 7,Y 0,Z 0,A 0,B 0,C 0}\n").is_err());
    options.bases.insert("base_data[2]".into(), Isometry3::translation(5.0, 0.0, 0.0));
    assert!(in_bases(&[1, 2], &data, &options).is_err());
    assert_eq!(in_bases(&[2, 1], &data, &options).unwrap(), [5.0, -25.0]);
}

#[test]
fn a_second_tool_is_refused_unless_its_tip_is_the_same() {
    let tools = [1.0, 1.0, 2.0].iter().enumerate().map(|(k, x)| frame(&format!("TOOL_DATA[{}]", k + 1), *x));
    let data = format!("DEFDAT a\n{}ENDDAT\n", tools.collect::<String>());
    let of_tools = |tools: &[usize]| {
        let motion = |tool: &usize| format!("$TOOL=TOOL_DATA[{tool}]\nLIN {{X 0,Y 0,Z 0,A 0,B 0,C 0}}\n");
        let source = format!("DEF a ( )\n{}END\n", tools.iter().map(motion).collect::<String>());
        let beside = ("a.dat".to_owned(), data.as_bytes().to_vec());
        RobotProgram::parse(source, "a.src", Language::Krl, Some(beside), &RobotOptions::default())
    };
    let refused = of_tools(&[1, 2, 3]).unwrap_err().to_string();
    assert!(
        refused.ends_with(
            "uses tool_data[3] after tool_data[1]: split it into a program for each tool; several in one are read where the program gives their orientation and their tips are the same"
        ),
        "{refused}"
    );
    let same = of_tools(&[1, 2]).unwrap();
    assert_eq!(same.notes().tool_tip_mm, Some(("tool_data[1]".into(), Vector3::new(1.0, 0.0, 0.0))));
}

#[test]
fn numbers_end_where_they_end() {
    let x = |text: &str| {
        let source = format!("DEF a ( )\nLIN {{X{text},Y .25,Z 7. ,A 0,B 0,C 0,E1 -1.5E-3}}\nEND\n");
        Ok::<f64, String>(
            parse(Language::Krl, &source, &RobotOptions::default())?.toolpath(coarse()).unwrap().points()[0]
                .position_mm
                .x,
        )
    };
    for (text, number) in [
        (" -1.5E-3", -0.0015),
        (" +.25", 0.25),
        (" 7.", 7.0),
        (" 2.5e1", 25.0),
        (" -0.000000000000125000000000000000000", -1.25e-13),
    ] {
        assert_eq!(x(text), Ok(number), "{text}");
    }
    // The exponent is none without digits: what follows the number is not part of it.
    for (text, is_number) in [
        (" 3EX", true),
        (" 3E", true),
        ("", false),
        (" .", false),
        (" 1234567890.123456789012345", false),
        (" 1e999", false),
    ] {
        let refused = x(text).unwrap_err();
        assert!(refused.contains("a plain number"), "{text}: {refused}");
        assert_eq!(refused.contains("behind a plain number"), is_number, "{text}: {refused}");
    }
}

/// A base that is given for other programs says nothing of one that writes its own.
#[test]
fn bases_given_for_other_programs_leave_an_explicit_base_known() {
    let mut options = RobotOptions::default();
    options.bases.insert("base_data[7]".into(), Isometry3::translation(5.0, 0.0, 0.0));
    let motions =
        "$TOOL={X 0,Y 0,Z 100,A 0,B 0,C 0}\nLIN {X 10,Y 0,Z 5,A 0,B 0,C 0}\nLIN {X 20,Y 0,Z 5,A 0,B 0,C 0}\nEND\n";
    let explicit = format!("DEF a ( )\n$BASE={{X 1,Y 0,Z 0,A 0,B 0,C 0}}\n{motions}");
    let path = parse(Language::Krl, &explicit, &options).unwrap().toolpath(coarse()).unwrap();
    assert_eq!(path.points()[0].position_mm, Vector3::new(10.0, 0.0, 5.0));
    let rapid = "MODULE m\nPERS tooldata t:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\nPROC main()\n\
                 MoveL [[10,0,5],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t\\WObj:=wobj0;\nENDPROC\nENDMODULE\n";
    assert!(parse(Language::Rapid, rapid, &options).is_ok());
    // A part of another name is not the name.
    let mut short = RobotOptions::default();
    short.bases.insert("base".into(), Isometry3::translation(5.0, 0.0, 0.0));
    assert!(parse(Language::Krl, &explicit.replace("DEF a", "DEF base_of"), &short).is_ok());
    // Named and given nowhere, it is asked for, and beside one that is given so is an explicit one.
    let named = format!("DEF a ( )\n$BASE=BASE_DATA[3]\n{motions}");
    assert!(parse(Language::Krl, &named, &options).unwrap_err().contains("base_data[3] stands to the base"));
    let both = format!("{}\n", explicit.replace("END\n", "$BASE=BASE_DATA[7]\nLIN {X 1,Y 0,Z 5,A 0,B 0,C 0}\nEND\n"));
    assert!(parse(Language::Krl, &both, &options).is_err());
}

/// The orientation of a tool decides all poses: where nothing gives it, that is said.
#[test]
fn a_tool_without_a_frame_is_said_to_be_assumed() {
    let source =
        "DEF a ( )\n$BASE={X 1,Y 0,Z 0,A 0,B 0,C 0}\n$TOOL=TOOL_DATA[2]\nLIN {X 10,Y 0,Z 5,A 0,B 0,C 0}\nEND\n";
    let mut options = RobotOptions::default();
    let assumed = |options: &RobotOptions, source: &str| {
        parse(Language::Krl, source, options).unwrap().notes().assumed_tool.clone()
    };
    assert_eq!(assumed(&options, source).as_deref(), Some("tool_data[2]"));
    assert_eq!(assumed(&options, &source.replace("TOOL_DATA[2]", "{X 0,Y 0,Z 9,A 0,B 0,C 0}")), None);
    assert_eq!(assumed(&options, &source.replace("$TOOL=TOOL_DATA[2]\n", "")).as_deref(), Some("the tool"));
    options.tool_rotation = Some(UnitQuaternion::identity());
    assert_eq!(assumed(&options, source), None);
}

/// The same words are other frames each time.
#[test]
fn frames_with_computed_indices_are_refused() {
    let options = RobotOptions::default();
    let motion = "LIN {X 10,Y 0,Z 5,A 0,B 0,C 0}\n";
    for line in ["$BASE=BASE_DATA[i]", "$TOOL=TOOL_DATA[n+1]"] {
        let refused = parse(Language::Krl, &format!("DEF a ( )\n{line}\n{motion}END\n"), &options).unwrap_err();
        assert!(
            refused.contains("whose index is computed are not followed; expected the index as a number"),
            "{refused}"
        );
    }
    let rapid = |wobj: &str, tool: &str| {
        let line =
            format!("MoveL [[10,0,5],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,{tool}\\WObj:={wobj};");
        parse(Language::Rapid, &format!("MODULE m\nPROC main()\n{line}\nENDPROC\nENDMODULE\n"), &options)
    };
    assert!(rapid("w{i}", "tool0").unwrap_err().contains("whose index is computed"));
    assert!(rapid("wobj0", "t{i}").unwrap_err().contains("whose index is computed"));
    assert!(rapid("wobj0", "tool0").is_ok());
}
