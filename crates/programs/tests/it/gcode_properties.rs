//! No input panics, and what is read can be written back.

use kinetostat_programs::{
    NumberFormat, Sampling, Toolpath, WriteOptions,
    gcode::{Dialect, GcodeOptions, GcodeProgram},
    polyline::{self, Polyline},
};
use nalgebra::Vector3;
use proptest::prelude::*;

use crate::support::cases::cases;

fn sampling() -> Sampling {
    Sampling::new(0.05, 5.0).unwrap()
}

fn options() -> GcodeOptions {
    GcodeOptions {
        start_mm: Some(Vector3::new(1.0, 2.0, 3.0)),
        dialect: Some(Dialect::LinuxCnc),
        ..GcodeOptions::default()
    }
}

/// Reads `source` as a program; if it is one, writes it back without and with corrections.
fn exercise(source: &[u8]) -> Result<(), TestCaseError> {
    for options in [GcodeOptions::default(), options()] {
        let Ok(program) = GcodeProgram::parse(source, "any.nc", &options) else {
            continue;
        };
        let Ok(path) = program.toolpath(sampling()) else {
            continue;
        };
        if path.len() > 20_000 {
            continue;
        }
        let nominal = path.positions_mm();
        let same = program.rewrite(&path, &nominal, WriteOptions::default()).unwrap();
        prop_assert_eq!(same.bytes(), source);
        for correct in [bent, shifted, stepped] {
            let goals: Vec<_> = nominal.iter().map(correct).collect();
            if goals.iter().all(|p| p.amax() < 999_999.0) {
                meets(&program, &path, &goals)?;
            }
        }
    }
    Ok(())
}

fn bent(p: &Vector3<f64>) -> Vector3<f64> {
    p + Vector3::new((0.3 * p.y).sin(), (0.2 * p.x).cos(), (p.x + p.z).sin()) * 0.2
}

fn shifted(p: &Vector3<f64>) -> Vector3<f64> {
    p + Vector3::new(0.012_345, -0.31, 0.2)
}

fn stepped(p: &Vector3<f64>) -> Vector3<f64> {
    if p.x > 3.0 { p.add_scalar(0.1) } else { *p }
}

/// Writes the program with its points at `goals`, exactly and within tolerances, reads it back and compares.
fn meets(program: &GcodeProgram, path: &Toolpath, goals: &[Vector3<f64>]) -> Result<(), TestCaseError> {
    [0.0, 0.01].into_iter().try_for_each(|tolerance_mm| meets_within(program, path, goals, tolerance_mm))
}

fn meets_within(
    program: &GcodeProgram,
    path: &Toolpath,
    goals: &[Vector3<f64>],
    tolerance_mm: f64,
) -> Result<(), TestCaseError> {
    let writing = WriteOptions { tolerance_mm, ..WriteOptions::default() };
    let written = match program.rewrite(path, goals, writing) {
        Ok(written) => written,
        // Words that move with the tool are refused where their line is split, by name.
        Err(refused) if refused.to_string().contains("an axis that moves with the tool") => return Ok(()),
        Err(refused) => return Err(TestCaseError::fail(refused.to_string())),
    };
    let text = String::from_utf8_lossy(written.bytes());
    let back = written.read_back().map_err(|e| TestCaseError::fail(format!("{e}\n{text}")))?;
    prop_assert_eq!(back.len(), path.len());
    for ((a, b), point) in back.positions_mm().iter().zip(goals).zip(path.points()) {
        // Holes of cycles have the correction of their bottoms.
        if program.is_hole(point.source.segment) && point.source.parameter != 0.75 {
            continue;
        }
        // One unit of the last of five decimals of an inch.
        let is_met = (a - b).amax() <= 2.55e-4 || (a - b).norm() <= tolerance_mm;
        prop_assert!(is_met, "{} at {tolerance_mm}\n{text}", (a - b).amax());
    }
    Ok(())
}

/// Lines a program may be made of, good ones and bad.
fn line() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        (-30i32..30).prop_map(|n| n.to_string()),
        (-300i32..300).prop_map(|n| format!("{:.2}", f64::from(n) / 10.0)),
        (-3000i32..3000).prop_map(|n| format!("{:.5}", f64::from(n) / 777.0)),
    ];
    let word = (prop::sample::select(vec!["X", "Y", "Z", "X", "Y", "I", "J", "K", "R", "F", "S", "x", "y"]), number)
        .prop_map(|(letter, number)| format!("{letter}{number}"));
    let fixed = prop::sample::select(vec![
        "G0",
        "G1",
        "G2",
        "G3",
        "g01",
        "G02",
        "G17",
        "G18",
        "G19",
        "G20",
        "G21",
        "G90",
        "G91",
        "G90.1",
        "G91.1",
        "G28",
        "G54",
        "G55",
        "G52 X2",
        "G92 X1 Y2",
        "G92.1",
        "G10 L2 P1 X5",
        "G10 L2 P2 X7 Y1 Z0",
        "G10 L20 P1 Y3",
        "G93",
        "G94",
        "A5",
        "G98",
        "G99",
        "G81 R2 Z-1",
        "G83 X1 R1 Z0 Q1",
        "X 5",
        "M3",
        "M5",
        "M9",
        "(é)",
        "; ü",
        "/",
        "%",
        "N7",
        "G80",
        "G4 P1",
        "G53",
        "M70",
        "M71",
        "M72",
        "M73",
    ])
    .prop_map(str::to_owned);
    let ending = prop::sample::select(vec!["\n", "\r\n", "\n", ""]);
    let separator = prop::sample::select(vec!["", " ", "  "]);
    (prop::collection::vec(prop_oneof![3 => word, 2 => fixed], 0..6), separator, ending)
        .prop_map(|(words, separator, ending)| words.join(separator) + ending)
}

/// Arcs that exist, in every plane, unit and mode, chained into a program.
fn arc_program() -> impl Strategy<Value = String> {
    let arc = (0usize..3, any::<bool>(), any::<bool>(), 0.5..40.0f64, 0.0..6.3f64, 0.05..6.3f64, -3i32..3);
    (any::<bool>(), any::<bool>(), prop::collection::vec(arc, 1..6)).prop_map(|(inch, incremental, arcs)| {
        let axes = ["XYZ", "ZXY", "YZX"];
        let centres = ["IJK", "KIJ", "JKI"];
        let mut at = [0.0f64; 3];
        let mut text = format!("{} G90\nG0 X0 Y0 Z0\n", if inch { "G20" } else { "G21" });
        text += if incremental { "G91\n" } else { "" };
        for (plane, clockwise, helix, radius, from, sweep, rise) in arcs {
            let indices = [[0, 1, 2], [2, 0, 1], [1, 2, 0]][plane];
            let to = if clockwise { from - sweep } else { from + sweep };
            let offset = [-radius * from.cos(), -radius * from.sin()];
            let step = [radius * to.cos() + offset[0], radius * to.sin() + offset[1], f64::from(rise)];
            text += &format!("G{} G{}", 17 + plane, if clockwise { 2 } else { 3 });
            for k in 0..if helix { 3 } else { 2 } {
                let axis = indices[k];
                let target = at[axis] + step[k];
                let written = format!("{:.4}", if incremental { step[k] } else { target });
                let value: f64 = written.parse().unwrap();
                at[axis] = if incremental { at[axis] + value } else { value };
                text += &format!(" {}{written}", axes[plane].as_bytes()[k] as char);
            }
            text += &format!(" {}{:.4}", centres[plane].as_bytes()[0] as char, offset[0]);
            text += &format!(" {}{:.4} F100\n", centres[plane].as_bytes()[1] as char, offset[1]);
        }
        text
    })
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn any_bytes_are_read_or_refused(source in prop::collection::vec(any::<u8>(), 0..400)) {
        exercise(&source)?;
    }

    #[test]
    fn any_code_like_text_is_read_or_refused(source in "[GXYZIJRFN0-9.+\\-/%();# \r\n]{0,120}") {
        exercise(source.as_bytes())?;
    }

    #[test]
    fn programs_of_random_lines_are_read_or_refused(lines in prop::collection::vec(line(), 1..12)) {
        exercise(("G0 X0 Y0 Z0 F100\n".to_owned() + &lines.concat()).as_bytes())?;
    }

    #[test]
    fn random_arcs_are_bent_and_read_back(source in arc_program()) {
        exercise(source.as_bytes())?;
    }

    #[test]
    fn mutated_programs_are_read_or_refused(
        which in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3u8), 1..6),
    ) {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gcode");
        let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
        files.sort();
        let mut source = std::fs::read(&files[which.index(files.len())]).unwrap();
        for (at, byte, kind) in changes {
            let at = at.index(source.len());
            match kind {
                0 => source[at] = byte,
                1 => source.insert(at, b"0123456789.-GXYIJ \n"[usize::from(byte) % 19]),
                _ => drop(source.remove(at)),
            }
        }
        exercise(&source)?;
    }

    #[test]
    fn any_bytes_are_a_polyline_or_refused(source in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = Polyline::read(source, "any.csv");
    }

    #[test]
    fn polylines_are_read_or_refused_and_written_back(
        rows in "(x_mm,y_mm,z_mm\n)([-0-9.]{0,6},[-0-9.]{1,6},[-0-9]{1,4}(\r\n|\n|\n\n)){0,8}",
    ) {
        if let Ok(polyline) = Polyline::read(rows.clone(), "any.csv") {
            let path = polyline.toolpath();
            let nominal = path.positions_mm();
            let format = NumberFormat::default();
            prop_assert_eq!(polyline.rewrite(&nominal, format).unwrap(), rows.as_bytes());
            let goals: Vec<_> = nominal.iter().map(|p| p.add_scalar(0.123_45)).collect();
            for bytes in [polyline.rewrite(&goals, format).unwrap(), polyline::write(path, &goals, format).unwrap()] {
                let back = Polyline::read(bytes, "back.csv").unwrap();
                prop_assert_eq!(back.toolpath().len(), path.len());
                for (a, b) in back.toolpath().positions_mm().iter().zip(&goals) {
                    prop_assert!((a - b).amax() <= 0.51e-4);
                }
            }
        }
    }
}
