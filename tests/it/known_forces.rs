//! What is known of a force: drills that enlarge a hole or enter, ends of tools, F of rotary axes alone, mean or peak. Right values come from sums of their own and from programs that
//! say the same otherwise.

use std::f64::consts::TAU;

use kinetostat::{
    Machine, Work,
    input::Folder,
    process::{
        Engaged, Process, RightForce, UnknownForce, VerdictForce,
        cutting::{EdgeForce, EdgeLaw, EndMilling},
    },
    products::program::ProgramJob,
    toolpath::PathPoint,
};
use nalgebra::Vector3;

use crate::support::{command::told, uncertain::job};

/// A box that begins at z = −5, cut by tools that come from below along +z, as on the Orthoglide.
fn drills(law: &str, y_from: f64) -> String {
    let tool = |number: u32, diameter: f64| {
        format!(
            "[force_of_tool.{number}.drilling]\ndiameter_mm = {diameter:?}\n{law}\n\
             [tools.{number}]\ndiameter_mm = {diameter:?}\nteeth = 2\nshape = \"drill\"\n"
        )
    };
    format!(
        "[sampling]\nmax_segment_mm = 1.0\n[stock]\nbox = {{ min_mm = [-30.0, {y_from:?}, -5.0], max_mm = [30.0, 30.0, 25.0] }}\n{}{}",
        tool(1, 7.8),
        tool(2, 8.0)
    )
}

const PLACED: &str = "tolerance_mm = 0.05\n[placement]\norigin_mm = [0.0, 0.0, 100.0]\n";
const KIENZLE: &str = "kienzle = { specific_force_N_per_mm2 = 2500.0, exponent = 0.26 }\nthrust_ratio = 0.6";
const CONSTANT: &str = "material_constant = 2.41";
const ENLARGED: &str =
    "G21 G90\nT1 M6\nS2000 M3\nG0 X0 Y0 Z-10\nG1 Z12 F300\nG0 Z-10\nT2 M6\nG1 Z12 F300\nG0 Z-10\nM30\n";
const FEED_PER_REV: f64 = 0.15;

fn engaged_points(job: &ProgramJob, tool: u32) -> Vec<(PathPoint, Engaged)> {
    let points = job.path.points().iter().copied().zip(job.path.engagements().iter().copied());
    points.filter(|own| own.0.tool == Some(tool) && own.1.removed_mm2 > 0.0).collect()
}

/// Thrust and torque of two lips by Kienzle's law, summed along them from the radius `from` to `to`, N and N·mm.
fn lips(from: f64, to: f64) -> (f64, f64) {
    let (steps, sine) = (100_000, 59f64.to_radians().sin());
    let h = FEED_PER_REV / 2.0 * sine;
    let step = (to - from) / steps as f64;
    let on_edge = 2500.0 * h.powf(1.0 - 0.26);
    let (mut thrust, mut torque) = (0.0, 0.0);
    for k in 0..steps {
        let radius = from + (k as f64 + 0.5) * step;
        let own = 2.0 * on_edge * step / sine;
        thrust += 0.6 * own * sine;
        torque += radius * own;
    }
    (thrust, torque)
}

/// A drill that enlarges a hole receives what its lips do from the hole's radius to its own.
#[test]
fn a_drill_that_enlarges_a_hole_has_the_force_of_the_rest_of_its_lips() {
    let found = job("orthoglide", &drills(KIENZLE, -30.0), ("part.nc", ENLARGED));
    for (tool, from, to) in [(1, 0.0, 3.9), (2, 3.9, 4.0)] {
        let (thrust, torque) = lips(from, to);
        let at_bottom = engaged_points(&found, tool).into_iter().find(|own| own.0.position_mm.z > 0.0).unwrap();
        let load = at_bottom.0.load.unwrap();
        assert!((load.force_N + thrust * Vector3::z()).norm() < 2e-3 * thrust, "{tool}: {load:?} instead of {thrust}");
        assert!((load.moment_Nmm.norm() - torque).abs() < 2e-3 * torque, "{tool}: {load:?} instead of {torque}");
    }
    // Of the point alone what is in material: at 1 mm of 2.34 mm its radius is 1.664 mm.
    let entering = engaged_points(&found, 1)[0];
    assert!((entering.0.position_mm.z + 4.0).abs() < 1e-9);
    let thrust = lips(0.0, 59f64.to_radians().tan()).0;
    assert!((entering.0.load.unwrap().force_N.z + thrust).abs() < 5e-3 * thrust, "{entering:?} instead of {thrust}");
}

/// By a law of solid drilling the force is known in solid material alone: where it is not, there is none, and this is said first, with the lines.
#[test]
fn solid_drilling_says_nothing_of_a_hole_that_is_there() {
    let found = job("orthoglide", &drills(CONSTANT, -30.0), ("part.nc", ENLARGED));
    let own = engaged_points(&found, 1);
    assert!(own[0].0.load.is_none() && own[0].1.unknown == Some(UnknownForce::PartlySolid), "{:?}", own[0]);
    let solid = 570.0 * 2.41 * 7.8 * FEED_PER_REV.powf(0.85);
    assert!((own.last().unwrap().0.load.unwrap().force_N.z + solid).abs() < 1e-9);
    for own in engaged_points(&found, 2) {
        assert!(own.0.load.is_none() && own.1.unknown == Some(UnknownForce::PartlySolid), "{own:?}");
    }
    let text = found.process.unknown_force_text(&found.path, &|segment| found.file.line_name(segment));
    assert!(
        text.starts_with("No force is known and none is compensated") && text.contains("(line 5, line 8)"),
        "{text}"
    );
}

/// A hole whose axis is on the side of the stock: half of a turn of each lip is in air, which leaves a force aside.
#[test]
fn a_drill_half_in_air_has_half_the_thrust_and_a_force_aside() {
    let one = ENLARGED.replace("T2 M6\nG1 Z12 F300\nG0 Z-10\n", "");
    let found = job("orthoglide", &drills(KIENZLE, 0.0), ("part.nc", &one));
    let load = engaged_points(&found, 1).last().unwrap().0.load.unwrap();
    let ((thrust, torque), sine) = (lips(0.0, 3.9), 59f64.to_radians().sin());
    // All that the lips receive against their motion over a turn, N; that towards the axis is q cot κ of it.
    let all = thrust / (0.6 * sine);
    let inward = 0.6 * 59f64.to_radians().cos() * all;
    let (mut aside, steps) = (Vector3::zeros(), 100_000);
    for k in 0..steps {
        let (sin, cos) = (TAU / 2.0 * (k as f64 + 0.5) / steps as f64).sin_cos();
        // Clockwise seen from the spindle, which is below: with the angle from x to y.
        let motion = Vector3::new(-sin, cos, 0.0);
        aside += (-motion * all - Vector3::new(cos, sin, 0.0) * inward) * (0.5 / steps as f64);
    }
    let expected = aside - 0.5 * thrust * Vector3::z();
    assert!((load.force_N - expected).norm() < 5e-3 * thrust, "{load:?} instead of {expected}");
    assert!((load.moment_Nmm.z.abs() - 0.5 * torque).abs() < 5e-3 * torque, "{load:?} instead of {torque}");
    let solid = job("orthoglide", &drills(CONSTANT, 0.0), ("part.nc", &one));
    assert!(engaged_points(&solid, 1).iter().all(|own| own.0.load.is_none()));
}

/// Where no force of a cut is known, numbers without it judge nothing: the first line says so, and the exit code is 1.
#[test]
fn where_no_force_is_known_nothing_is_judged() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(at("part.nc"), ENLARGED.replace("T2 M6\nG1 Z12 F300\nG0 Z-10\n", "")).unwrap();
    std::fs::write(at("process.toml"), format!("schema = 1\n{PLACED}{}", drills(CONSTANT, 0.0))).unwrap();
    let of = ["--machine", "orthoglide", "--process", &at("process.toml")];
    let (code, printed, _) = told(&[&["compensate", &at("part.nc"), "--out", &at("out.nc")], &of[..]].concat());
    assert_eq!(code, Some(1), "{printed}");
    assert!(printed.starts_with("✗ No force is known where the tool cuts"), "{printed}");
    assert!(printed.contains("No force of this cut is known, so none is compensated."), "{printed}");
    assert!(!printed.contains("within the tolerance"), "{printed}");
    let (code, printed, _) = told(&[&["compare", "--path", &at("part.nc")], &of[..]].concat());
    assert_eq!(code, Some(1), "{printed}");
    assert!(printed.starts_with("No force is known and none is compensated"), "{printed}");
}

#[test]
fn a_drill_that_contradicts_its_law_is_refused() {
    let process = drills(&format!("{KIENZLE}\npoint_angle_deg = 140.0"), -30.0);
    let machine = Machine::named("orthoglide").unwrap();
    let found = crate::stock::job_beside(&process, &machine, ENLARGED, &[]).map(|_| ()).unwrap_err().to_string();
    assert!(found.contains("drills with a point of 118.0° by its tool and 140.0° by its force"), "{found}");
}

const MILL: &str = "[sampling]\nmax_segment_mm = 1.0\n[force.end_milling]\nmaterial = \"Al 7075-T6\"\n[stock]\n\
     box = { min_mm = [-60.0, -50.0, -5.0], max_mm = [60.0, 50.0, 20.0] }\n[tools.1]\ndiameter_mm = 10.0\nteeth = 4\n";

/// Plunges and ramps of a flat end have no force that is known; what falls by rounding alone has.
#[test]
fn the_end_of_a_tool_has_no_known_force() {
    let program =
        |down: &str| format!("G21 G90\nS8000 M3\nG0 X-40 Y0 Z-10\nG1 Z-3 F600\nX-20 F2400\nX20 {down}\nG0 Z-10\n");
    let line_of = |process: &str, down: &str| {
        let found = job("orthoglide", process, ("part.nc", &program(down)));
        let text = found.process.unknown_force_text(&found.path, &|segment| found.file.line_name(segment));
        let points: Vec<_> =
            found.path.points().iter().zip(found.path.engagements()).map(|own| (*own.0, *own.1)).collect();
        (points.into_iter().filter(|own| own.0.source.segment == 3).collect::<Vec<_>>(), text)
    };
    let of_line = |down: &str| line_of(MILL, down).0;
    for own in of_line("Z0") {
        assert!(own.0.load.is_some() && own.1.unknown == Some(UnknownForce::EndOnRamp), "{own:?}");
    }
    let level = of_line("Z-3.0");
    for (level, falling) in level.iter().zip(of_line("Z-2.9999999999")) {
        let (own, other) = (level.0.load.unwrap().force_N, falling.0.load.unwrap().force_N);
        assert!(falling.1.unknown.is_none() && (own - other).norm() < 1e-3 * own.norm(), "{own} {other}");
    }
    // A ramp has about the force of the level slot, and its lines come first; a plunge has none.
    let (ramp, text) = line_of(MILL, "Z-2.5");
    assert!(
        text.contains("On ramps only the force of the side of the tool is known") && text.contains("(line 6)"),
        "{text}"
    );
    assert!(text.contains("its end teeth are in no law (line 4)"), "{text}");
    for (level, down) in level.iter().zip(&ramp).skip(1) {
        let deeper = 1.0 + (down.0.position_mm.z + 3.0) / 2.0;
        let (own, other) = (level.0.load.unwrap().force_N * deeper, down.0.load.unwrap().force_N);
        assert!(down.1.unknown == Some(UnknownForce::EndOnRamp), "{:?}", down.1);
        assert!((own - other).norm() < 0.03 * own.norm(), "{own} {other}");
    }
    // Without a stock: of the side of an end mill.
    let law = "[force.end_milling]\ndiameter_mm = 10.0\nteeth = 4\naxial_depth_mm = 2.0\nradial_width_mm = 10.0\nmaterial = \"Al 7075-T6\"\n";
    let found = job("orthoglide", law, ("part.nc", &program("Z0")));
    let text = found.process.unknown_force_text(&found.path, &|segment| found.file.line_name(segment));
    assert!(
        text.contains("where the end of a milling tool goes down into material: its end teeth are in no law (line 4)"),
        "{text}"
    );
    assert!(
        text.contains("On ramps only the force of the side of the tool is known") && text.contains("(line 6)"),
        "{text}"
    );
}

const TRUNNION: &str = r#"
schema = 1
name = "xyzt"
title = "mill with trunnion"
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
  { revolute_drive = { name = "C", axis = "z", stiffness_Nmm_per_rad = 1.2e8, travel_deg = [-360.0, 360.0] } },
]
[[mount]]
name = "mill"
chain = "mill"
[workpiece_carrier]
name = "table"
chain = "trunnion"
base = { position_mm = [0.0, 0.0, 0.0] }
"#;
const SIDE: &str = "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 0.0]\n[sampling]\nmax_segment_mm = 2.0\nmax_turn_deg = 2.0\n[force.end_milling]\ndiameter_mm = 10.0\n\
     teeth = 4\naxial_depth_mm = 5.0\nradial_width_mm = 4.0\ncut = \"down\"\nmaterial = \"Al 6082-T6\"\n";

fn on_trunnion(process: &str, program: &str) -> kinetostat::input::error::Result<ProgramJob> {
    let machine = Machine::from_toml(TRUNNION, "xyzt.toml").unwrap();
    let process = Process::from_toml(process, "process.toml", Folder::in_memory([]), &machine)?;
    let folder = Folder::in_memory([("part.nc".to_owned(), program.as_bytes().to_vec())]);
    let program = process.program_in_folder(&folder, "part.nc")?;
    ProgramJob::new(process, program, "part.nc", &Work::default())
}

fn turned(line: &str) -> String {
    format!("G21 G90 G17 G94\nS8000 M3\nG0 X10 Y0 Z5 A0 C0\nG1 Z0 F200\n{line}\nG94 G1 X50 F200\nM30\n")
}

/// F is in degrees a minute where rotary axes move alone, which inverse time says without any doubt.
#[test]
fn rotary_axes_alone_take_the_time_that_inverse_time_says() {
    let feeds = |program: &str, dialect: &str| -> Vec<(f64, Vector3<f64>)> {
        let job = on_trunnion(&format!("{SIDE}[gcode]\ndialect = \"{dialect}\"\n"), program).unwrap();
        let own = |point: &PathPoint| {
            let load = job.process.load(point).unwrap().on_tool(point.tangent, &nalgebra::Matrix3::identity());
            (point.feed_mm_per_min.unwrap_or_default(), load.force_N)
        };
        job.path.points().iter().map(own).collect()
    };
    for (line, other) in [
        ("G1 C90 F200", "G93 G1 C90 F2.2222222222222223"),
        ("G1 A-30 C40 F100", "G93 G1 A-30 C40 F2"),
        // At the axis the tip stands.
        ("G1 X0\nG1 C90 F200", "G1 X0\nG93 G1 C90 F2.2222222222222223"),
    ] {
        for dialect in ["iso", "fanuc", "linuxcnc"] {
            let (own, other) = (feeds(&turned(line), dialect), feeds(&turned(other), dialect));
            assert_eq!(own.len(), other.len());
            for (own, other) in own.iter().zip(&other) {
                let close = (own.0 - other.0).abs() <= 1e-9 * own.0 && (own.1 - other.1).norm() < 1e-6;
                assert!(close, "{line} {dialect}: {own:?} {other:?}");
            }
        }
    }
    // A quarter turn with r = 10 mm in 0.45 min, in chords of two degrees.
    let fed = feeds(&turned("G1 C90 F200"), "iso");
    assert!(fed.iter().any(|own| (own.0 - 2.5 * TAU / 0.45).abs() < 2e-3), "{fed:?}");
    let haas = on_trunnion(&format!("{SIDE}[gcode]\ndialect = \"haas\"\n"), &turned("G1 C90 F200")).map(|_| ());
    let haas = haas.unwrap_err().to_string();
    assert!(
        haas.contains("In line 5 rotary axes move alone: to Haas F is the feed at the diameter of settings 34 and 79"),
        "{haas}"
    );
}

/// What is written of a rotary axis alone takes its time on a control that takes F for X, Y and Z as soon as one of them moves.
#[test]
fn corrected_rotary_moves_take_the_time_of_the_program() {
    takes_nine_tenths_of_a_minute("G1 C90 F200\nG1 C0");
    // What F means on the line itself does not end the inverse time that is put before it.
    takes_nine_tenths_of_a_minute("G94 G1 C90 F200\nG94 G1 C0");
}

fn takes_nine_tenths_of_a_minute(lines: &str) {
    let job = on_trunnion(SIDE, &turned(lines)).unwrap();
    let asked = kinetostat::products::program::CompensateOptions::by(kinetostat::compensation::Method::Direct);
    let mut receiver = kinetostat::products::program::NoFiles;
    let kinetostat::products::program::Compensated::Verified(verified) =
        job.compensate(&asked, &mut receiver, &Work::default()).unwrap()
    else {
        panic!("refused")
    };
    let text = String::from_utf8(verified.written.bytes.clone()).unwrap();
    // The time by the words alone: of LinuxCNC's rule, by F in inverse time or over the way in X, Y and Z.
    let (mut minutes, mut inverse, mut feed, mut at) = (0.0, false, 0.0, [10.0, 0.0, 0.0, 0.0]);
    for line in text.lines().skip_while(|line| !line.contains("Z-0") && !line.contains("G1 Z0")).skip(1) {
        let value = |letter: char| line.split(' ').find_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
        inverse = line.contains("G93") || (inverse && !line.contains("G94"));
        feed = value('F').unwrap_or(feed);
        let to = [('X', 0), ('Y', 1), ('Z', 2), ('C', 3)].map(|(letter, k)| value(letter).unwrap_or(at[k]));
        if to == at || line.contains("X49.9") || line.contains("X50") {
            at = to;
            continue;
        }
        let way = (0..3).map(|k| (to[k] - at[k]).powi(2)).sum::<f64>().sqrt();
        if to[3] != at[3] {
            minutes += if inverse {
                1.0 / feed
            } else if way > 0.0 {
                way / feed
            } else {
                (to[3] - at[3]).abs() / feed
            };
        }
        at = to;
    }
    assert!((minutes - 0.9).abs() < 0.009, "{minutes} min\n{text}");
    assert!(text.contains("G94 F200"), "{text}");
}

/// Which force a verdict rests on, with the peak by the sum over straight teeth of the closed form.
#[test]
fn a_verdict_says_which_force_it_rests_on() {
    let slot = |frequencies: &str, speed: u32| {
        let law = "[force.end_milling]\ndiameter_mm = 10.0\nteeth = 2\naxial_depth_mm = 2.0\nradial_width_mm = 10.0\n\
                   coefficients = { tangential_cutting_N_per_mm2 = 900.0, radial_cutting_N_per_mm2 = 400.0, axial_cutting_N_per_mm2 = -150.0 }\n";
        let feed = speed / 10;
        let program = format!("G21 G90\nS{speed} M3\nG0 X-20 Y0 Z-10\nG1 Z0 F600\nX20 F{feed}\nG0 Z-10\n");
        let job = job("orthoglide", &format!("{frequencies}\n{law}"), ("part.nc", &program));
        VerdictForce::of(&job.process, &job.path).unwrap()
    };
    let own = slot("", 6000);
    assert_eq!((own.right(), own.teeth_Hz), (RightForce::Unknown, Some([200.0, 200.0])));
    assert!(own.sentence().contains("is not known without natural_frequencies_Hz"), "{}", own.sentence());
    // One tooth of two is in the slot: F_t, F_r and F_a at the thickest chip, over the turn on average a quarter and 1/π of them.
    let c = 0.05;
    let [t, r, a] = [900.0, 400.0, 150.0].map(|k: f64| k * c * 2.0);
    let mean = (2.0 * Vector3::new(t / 4.0, r / 4.0, a / TAU * 2.0)).norm();
    assert!((own.mean_N - mean).abs() < 1e-6 * mean, "{own:?} instead of {mean}");
    assert!((own.peak_N - Vector3::new(t, r, a).norm()).abs() < 1e-3 * own.peak_N, "{own:?}");
    for (frequency, right) in
        [(66.0, RightForce::Mean), (67.0, RightForce::Neither), (599.0, RightForce::Neither), (601.0, RightForce::Peak)]
    {
        assert_eq!(
            slot(&format!("natural_frequencies_Hz = [900.0, {frequency:?}]"), 6000).right(),
            right,
            "{frequency}"
        );
    }
    // From the stock as from width and depth.
    let line = "G21 G90\nS8000 M3\nG0 X-20 Y0 Z-10\nG1 Z0 F2400\nX20\nG0 Z-10\n";
    let found = job("orthoglide", &MILL.replace("-50.0, -5.0", "2.5, -5.0"), ("part.nc", line));
    let found = VerdictForce::of(&found.process, &found.path).unwrap();
    let edge = |cutting: f64, edge: f64| EdgeForce { cutting, edge };
    let given = EndMilling {
        edge: EdgeLaw::Linear { tangential: edge(767.01, 27.7), radial: edge(168.8, 26.6), axial: edge(-222.0, -0.7) },
        diameter_mm: 10.0,
        teeth: 4,
        depth_mm: 5.0,
        width_mm: 2.5,
        direction: kinetostat::process::cutting::CutDirection::Down,
        feed_per_tooth_mm: None,
        spindle: kinetostat::toolpath::TurnDirection::Clockwise,
        over_turn: Default::default(),
    };
    let (mean, peak) = (given.mean(0.075).force_N.norm(), given.peak(0.075).force_N.norm());
    assert!(
        (found.mean_N - mean).abs() < 0.02 * mean && (found.peak_N - peak).abs() < 0.02 * peak,
        "{found:?}: {mean} {peak}"
    );
}
