//! G-code with rotary axes: control of the tip and machine coordinates, heads and tables.

use kinetostat_programs::{
    Orientation, Sampling, Toolpath, WriteOptions,
    gcode::{GcodeOptions, GcodeProgram, Rotary, RotaryAxis, RotarySide},
};
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::support::cases::cases;

fn axis(letter: char, about: Vector3<f64>, turns: RotarySide, through_mm: Option<[f64; 3]>) -> RotaryAxis {
    RotaryAxis { letter, about, turns, through_mm: through_mm.map(Vector3::from), travel_deg: None }
}

/// A table that swivels about x and turns about z on it, 50 mm under the part.
fn table() -> Rotary {
    let through = Some([0.0, 0.0, -50.0]);
    let axes = vec![
        axis('A', Vector3::x(), RotarySide::Workpiece, through),
        axis('C', Vector3::z(), RotarySide::Workpiece, through),
    ];
    Rotary { axes, always_of_tip: false }
}

/// A fork head whose pivot is 200 mm above the tip.
fn head() -> Rotary {
    let through = Some([0.0, 0.0, 200.0]);
    let axes =
        vec![axis('C', Vector3::z(), RotarySide::Tool, through), axis('B', Vector3::y(), RotarySide::Tool, through)];
    Rotary { axes, always_of_tip: false }
}

fn options(rotary: Rotary) -> GcodeOptions {
    GcodeOptions { rotary, ..GcodeOptions::default() }
}

fn read(source: &str, rotary: Rotary) -> (GcodeProgram, Toolpath) {
    let program = GcodeProgram::parse(source, "part.nc", &options(rotary)).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    (program, path)
}

fn refused(source: &str, rotary: Rotary) -> String {
    GcodeProgram::parse(source, "part.nc", &options(rotary)).unwrap_err().to_string()
}

fn axis_of(path: &Toolpath, k: usize) -> Vector3<f64> {
    match path.points()[k].orientation {
        Some(Orientation::ToolAxis(axis)) => axis,
        other => panic!("{other:?}"),
    }
}

const TIP: &str = "G21 G90 G17\nG0 X0 Y0 Z20 B0 C0\nG43.4 H1\nG0 Z2\nG1 Z0 F300\nG1 X20 B10 F600\nX40 Y10 B-20 C30 (swing)\nG2 X60 Y10 \
                   I10 J0 C60\nG1 B0 C0\nG49\nG0 Z20\nM30\n";

#[test]
fn with_control_of_the_tip_coordinates_are_those_of_the_tip_and_angles_turn_the_tool() {
    let (program, path) = read(TIP, head());
    let last_of = |segment: usize| path.points().iter().rposition(|point| point.source.segment == segment).unwrap();
    let (sin, cos) = 10f64.to_radians().sin_cos();
    let end = last_of(3);
    assert_eq!(program.line_of(3), Some(6));
    assert_eq!(path.points()[end].position_mm, Vector3::new(20.0, 0.0, 0.0));
    assert!((axis_of(&path, end) - Vector3::new(sin, 0.0, cos)).norm() < 1e-12);
    // Between, the angles turn evenly, here 20 pieces of 1 mm and half a degree each.
    assert_eq!(end - last_of(2), 20);
    let half = axis_of(&path, end - 10);
    assert!((half - Vector3::new(5f64.to_radians().sin(), 0.0, 5f64.to_radians().cos())).norm() < 1e-12);
    // A line of angles alone turns the tool about its tip, 80 degrees in pieces of 2 at most.
    let turning = last_of(6);
    assert_eq!(path.points()[turning].position_mm, path.points()[last_of(5)].position_mm);
    assert_eq!(turning - last_of(5), 40);
    assert_eq!(axis_of(&path, turning), Vector3::z());
}

#[test]
fn in_machine_coordinates_the_tip_is_where_the_machine_brings_it() {
    // The head swings by 30 degrees about its pivot while it stays: the tip goes round it.
    let (_, path) = read("G21 G90\nG0 X0 Y0 Z0 B0 C0\nG1 X0 B30 F100\n", head());
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let last = path.points().last().unwrap();
    assert!((last.position_mm - Vector3::new(-200.0 * sin, 0.0, 200.0 * (1.0 - cos))).norm() < 1e-9);
    assert!((last.tangent - Vector3::new(-cos, 0.0, sin)).norm() < 1e-4);
    let circumference = path.points().windows(2).map(|pair| (pair[1].position_mm - pair[0].position_mm).norm());
    assert!((circumference.sum::<f64>() - 200.0 * 30f64.to_radians()).abs() < 0.01);
    // A turn of the table by 90 degrees, the tool beside its centre: the tool goes round the part.
    let (_, path) = read("G21 G90\nG0 X30 Y0 Z0 A0 C0\nG1 C90 F100\n", table());
    assert!((path.points().last().unwrap().position_mm - Vector3::new(0.0, -30.0, 0.0)).norm() < 1e-9);
    assert!(path.points().iter().all(|point| (point.position_mm.norm() - 30.0).abs() < 1e-9));
    // The length of the path is that of the way round, though no coordinate of the program changes.
    assert!((path.length_mm() - 30.0 * 90f64.to_radians()).abs() < 0.01, "{}", path.length_mm());
    // So is the feed of a block that is to take a minute.
    let (_, path) = read("G21 G90\nG0 X30 Y0 Z0 A0 C0\nG93\nG1 C90 F1\n", table());
    let feed = path.points().last().unwrap().feed_mm_per_min.unwrap();
    assert!((feed - 30.0 * 90f64.to_radians()).abs() < 0.01, "{feed}");
}

#[test]
fn what_is_not_known_of_rotary_axes_is_refused_by_name() {
    assert_eq!(
        refused("G0 X0 Y0 Z0 A0\nG1 A10 F9\n", Rotary::default()),
        "part.nc:2:4: `A10`: turns A, which stood at 0; expected rotary axes that keep one value, or [[gcode.rotary]] in the process file, \
         which says what A turns"
    );
    let mut nowhere = head();
    nowhere.axes[1].through_mm = None;
    assert_eq!(
        refused("G0 X0 Y0 Z0 B0\nG1 X5 B10 F9\n", nowhere.clone()),
        "part.nc:2:4: `X5`: B is not 0 and X, Y and Z are not those of the tip; expected G43.4 before, through_mm of B in \
         [[gcode.rotary]], or rotary_tip = \"always\" in [gcode]"
    );
    assert!(GcodeProgram::parse("G0 X0 Y0 Z0 B0\nG43.4\nG1 X5 B10 F9\n", "part.nc", &options(nowhere.clone())).is_ok());
    let always = Rotary { always_of_tip: true, ..nowhere };
    assert!(GcodeProgram::parse("G0 X0 Y0 Z0 B0\nG1 X5 B10 F9\n", "part.nc", &options(always)).is_ok());
    assert_eq!(
        refused("G0 X0 Y0 Z0 A20\nG43.4 H1\nG1 X5 F9\n", head()),
        "part.nc:3:4: `X5`: A = 20 with control of the tip; expected [[gcode.rotary]] in the process file, which says what A turns"
    );
    assert_eq!(
        refused("G0 X0 Y0 Z0 B20\nG81 X5 R2 Z-3 F9\n", head()),
        "part.nc:2:1: `G81`: a cycle with the tool turned (B = 20); expected it written out as G0 and G1 moves"
    );
    assert!(refused("G43.5 X0 Y0 Z0 I0 J0 K1\n", head()).contains("tool axes as vectors (G43.5) are not supported"));
}

#[test]
fn a_move_that_is_split_turns_on_as_it_did() {
    let source = "G21 G90\nG43.4 H1\nG0 X0 Y0 Z0 B0 C0\nG1 X10 B10. C-20 F500 (a)\nG91\nG1 X10 B-5.5 C10\nG90\nX0 B0\n";
    let (program, path) = read(source, head());
    let mut bent = path.positions_mm();
    for (at, point) in bent.iter_mut().zip(path.points()) {
        at.z += 0.02 * point.position_mm.x * (1.0 - point.source.parameter);
    }
    let rewritten = program.rewrite(&path, &bent, WriteOptions::with_decimals(program.own_format())).unwrap();
    let text = String::from_utf8(rewritten.bytes().to_vec()).unwrap();
    let start = "G21 G90\nG43.4 H1\nG0 X0 Y0 Z0 B0 C0\nG1 X0.667 Z0.012 B0.6667 C-1.3333 F500 (a)\nX1.333 Z0.023 B1.3333 C-2.6667\n";
    assert!(text.starts_with(start), "{text}");
    assert!(text.contains("\nX10 Z0.000 B10. C-20\nG91\nG1 X1.000 Z0.198 B-0.5500 C1.0000\n"), "{text}");
    let back = rewritten.read_back().unwrap();
    for (point, (wanted, own)) in back.points().iter().zip(bent.iter().zip(path.points())) {
        assert!((point.position_mm - wanted).amax() <= 1.001e-3);
        assert!(point.orientation.unwrap().angle_to(&own.orientation.unwrap()) < 3e-6);
    }
}

fn machine_called(name: &str) -> Rotary {
    let [above, below] = [Some([0.0, 0.0, 180.0]), Some([0.0, 0.0, -50.0])];
    let axes = match name {
        "head_bc" => return head(),
        "table_ac" => return table(),
        "head_ab" => {
            vec![axis('B', Vector3::y(), RotarySide::Tool, above), axis('A', Vector3::x(), RotarySide::Tool, above)]
        }
        "mixed_bc" => {
            vec![
                axis('B', Vector3::y(), RotarySide::Tool, above),
                axis('C', Vector3::z(), RotarySide::Workpiece, below),
            ]
        }
        other => panic!("{other}"),
    };
    Rotary { axes, always_of_tip: false }
}

/// Without correction the same bytes; with one, points and axes where they should be.
fn check_written(name: &str, program: &GcodeProgram) {
    let path = program.toolpath(Sampling::default()).unwrap();
    let positions = path.positions_mm();
    let own: Vec<Orientation> = path.points().iter().map(|point| point.orientation.unwrap()).collect();
    assert!(own.iter().any(|orientation| orientation.angle_to(&Orientation::ToolAxis(Vector3::z())) > 0.02), "{name}");
    let format = program.own_format();
    for orientations in [None, Some(own.as_slice())] {
        let same =
            program.rewrite_turned(&path, &positions, orientations, WriteOptions::with_decimals(format)).unwrap();
        assert_eq!(String::from_utf8_lossy(same.bytes()), String::from_utf8_lossy(program.source()), "{name}");
    }
    let moved: Vec<Vector3<f64>> = positions
        .iter()
        .map(|p| p + 0.2 * Vector3::new((p.y * 0.11).sin(), (p.x * 0.07 + p.z).cos(), (0.05 * (p.x - p.y)).sin()))
        .collect();
    let by = |p: &Vector3<f64>| UnitQuaternion::from_scaled_axis(Vector3::new(1e-3 * (p.x * 0.1).sin(), -1e-3, 0.0));
    let turned: Vec<Orientation> =
        (0..path.len()).map(|k| Orientation::ToolAxis(by(&positions[k]) * axis_of(&path, k))).collect();
    for (tolerance_mm, orientations) in [(0.0, None), (0.005, None), (0.005, Some(turned.as_slice()))] {
        let rewritten = program
            .rewrite_turned(
                &path,
                &moved,
                orientations,
                WriteOptions { tolerance_mm, ..WriteOptions::with_decimals(format) },
            )
            .unwrap();
        let text = String::from_utf8_lossy(rewritten.bytes()).into_owned();
        let back = rewritten.read_back().unwrap_or_else(|refused| panic!("{name}: {refused}\n{text}"));
        assert_eq!(back.len(), path.len(), "{name}");
        for (k, point) in back.points().iter().enumerate() {
            let off = (point.position_mm - moved[k]).norm();
            // Machine coordinates swing the tip by the rounding of their angles.
            assert!(off < 0.012, "{name}: point {k} is {off} mm off\n{text}");
            let wanted = orientations.map_or(own[k], |orientations| orientations[k]);
            let off = point.orientation.unwrap().angle_to(&wanted);
            // Near the pole of its axes, where the tool stands along z, a machine turns it in one direction only.
            let can_turn = name.starts_with("head_ab") || axis_of(&path, k).z < 0.99;
            let most = match orientations {
                None => 2e-4,
                Some(_) if can_turn => 3e-4,
                Some(_) => own[k].angle_to(&wanted) + 3e-4,
            };
            assert!(off < most, "{name}: point {k} is turned by {off} rad\n{text}");
        }
    }
}

#[test]
fn programs_of_several_machines_and_controls_are_followed_and_written_back() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/five_axis_programs");
    let mut names = Vec::new();
    for machine in ["head_ab", "head_bc", "mixed_bc", "table_ac"] {
        for entry in std::fs::read_dir(folder.join(machine)).unwrap() {
            names.push(format!("{machine}/{}", entry.unwrap().file_name().to_string_lossy()));
        }
    }
    names.sort();
    assert!(names.len() >= 15, "{names:?}");
    for name in names {
        let rotary = machine_called(name.split('/').next().unwrap());
        let program = GcodeProgram::parse(std::fs::read(folder.join(&name)).unwrap(), &name, &options(rotary));
        check_written(&name, &program.unwrap_or_else(|refused| panic!("{refused}")));
    }
}

#[test]
fn with_and_without_control_of_the_tip_the_tool_stays_where_it_is() {
    let source = "G21 G90\nG43.4 H1\nG0 X0 Y0 Z0 B30 C0\nG49\nG1 Z10 F100\nG43.4 H1\nG1 X5\n";
    let (_, path) = read(source, head());
    let last_of = |segment: usize| path.points().iter().rfind(|point| point.source.segment == segment).unwrap();
    let (sin, cos) = 30f64.to_radians().sin_cos();
    // The head stands at (200 sin 30°, 0, 200 cos 30° - 200) and goes to 10 in Z alone.
    let rise = 10.0 - 200.0 * (cos - 1.0);
    assert!((last_of(1).position_mm - Vector3::new(0.0, 0.0, rise)).norm() < 1e-9, "{sin}");
    assert!((last_of(2).position_mm - Vector3::new(5.0, 0.0, rise)).norm() < 1e-9);
}

/// Programs that turn B and the axis `other`, of moves with some of the words.
fn programs(other: char) -> impl Strategy<Value = String> {
    let word = |letter: char, range: std::ops::Range<i32>| {
        proptest::option::of(range)
            .prop_map(move |n| n.map_or(String::new(), |n| format!(" {letter}{}", f64::from(n) / 10.0)))
    };
    let line = (
        0..2u8,
        word('X', -300..300),
        word('Y', -300..300),
        word('Z', -100..100),
        word('B', -400..400),
        word(other, -900..900),
    )
        .prop_map(|(code, x, y, z, b, other)| format!("G{code}{x}{y}{z}{b}{other}\n"));
    (proptest::collection::vec(line, 1..12), any::<bool>(), any::<bool>()).prop_map(move |(lines, tip, steps)| {
        let tip = if tip { "G43.4 H1\n" } else { "" };
        format!(
            "G21 G90 G94\n{tip}G0 X0 Y0 Z0 B0 {other}0\nF800\n{}{}M30\n",
            if steps { "G91\n" } else { "" },
            lines.concat()
        )
    })
}

/// Points moved along x and the tool turned, evenly and with the place: both are read back.
fn is_turned_as_asked(source: &str, x: f64, turn: (f64, f64), bend: f64) -> Result<(), TestCaseError> {
    let rotary = || {
        let through = Some([0.0, 0.0, 200.0]);
        let axes = vec![
            axis('B', Vector3::y(), RotarySide::Tool, through),
            axis('A', Vector3::x(), RotarySide::Tool, through),
        ];
        Rotary { axes, always_of_tip: false }
    };
    let (program, path) = read(source, rotary());
    let own: Vec<Orientation> = path.points().iter().map(|point| point.orientation.unwrap()).collect();
    let positions = path.positions_mm();
    let as_it_was = program
        .rewrite_turned(&path, &positions, Some(&own), WriteOptions::with_decimals(program.own_format()))
        .unwrap();
    prop_assert_eq!(std::str::from_utf8(as_it_was.bytes()).unwrap(), source);
    let moved: Vec<Vector3<f64>> = positions.iter().map(|p| p + Vector3::new(x, 0.0, 0.0)).collect();
    let turned: Vec<Orientation> = (0..path.len())
        .map(|k| {
            let by = Vector3::new(turn.0 + bend * positions[k].y, turn.1 - bend * positions[k].x, 0.0);
            Orientation::ToolAxis(UnitQuaternion::from_scaled_axis(by) * axis_of(&path, k))
        })
        .collect();
    let writing = WriteOptions::with_decimals(program.own_format());
    let rewritten = program.rewrite_turned(&path, &moved, Some(&turned), writing).unwrap();
    let back = rewritten.read_back().unwrap();
    prop_assert_eq!(back.len(), path.len());
    for (k, point) in back.points().iter().enumerate() {
        let (off, turn) = ((point.position_mm - moved[k]).norm(), point.orientation.unwrap().angle_to(&turned[k]));
        let text = String::from_utf8_lossy(rewritten.bytes());
        // With A near 90 degrees the tool does not turn with B.
        let is_near_pole = axis_of(&path, k).y.abs() > 0.99;
        prop_assert!(off < 6e-3, "{off} mm at point {k}\n{source}\n{text}");
        prop_assert!(turn < 2.9e-4 || is_near_pole, "{turn} rad at point {k}\n{source}\n{text}");
    }
    Ok(())
}

/// Drawn once: what was written could not be read back.
#[test]
fn a_block_that_leads_nowhere_is_read_back_as_often_as_it_was_written() {
    let source = "G21 G90 G94\nG0 X0 Y0 Z0 B0 A0\nF800\nG0 B-5\nG0 B-5\nM30\n";
    is_turned_as_asked(source, 0.0, (0.0, 0.0), 5.422_769_649_968_909_5e-6).unwrap();
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn programs_that_turn_keep_their_bytes_or_go_where_they_are_sent(
        source in programs('C'), x in -0.05..0.05f64, z in -0.002..0.002f64,
    ) {
        let (program, path) = read(&source, head());
        let own = path.positions_mm();
        let rewritten = program.rewrite(&path, &own, WriteOptions::with_decimals(program.own_format())).unwrap();
        prop_assert_eq!(std::str::from_utf8(rewritten.bytes()).unwrap(), source.as_str());
        let moved: Vec<Vector3<f64>> = own.iter().map(|p| p + Vector3::new(x, 0.0, z * p.x)).collect();
        let rewritten = program.rewrite(&path, &moved, WriteOptions::with_decimals(program.own_format())).unwrap();
        let back = rewritten.read_back().unwrap();
        prop_assert_eq!(back.len(), path.len());
        for (point, (wanted, own)) in back.points().iter().zip(moved.iter().zip(path.points())) {
            let off = (point.position_mm - wanted).norm();
            prop_assert!(off < 3e-3, "{off} at {:?}\n{}", own.source, String::from_utf8_lossy(rewritten.bytes()));
            prop_assert!(point.orientation.unwrap().angle_to(&own.orientation.unwrap()) < 1e-5);
        }
    }

    #[test]
    fn the_tool_is_turned_as_asked(
        source in programs('A'), x in -0.05..0.05f64, turn in (-2e-3..2e-3f64, -2e-3..2e-3f64), bend in -1e-5..1e-5f64,
    ) {
        is_turned_as_asked(&source, x, turn, bend)?;
    }
}
