//! Intervals of poses that were left out: of a measured robot, of machines that yield as no model of them can, and where a pose was measured
//! in several rows.

use std::{fmt::Write as _, path::Path, process::Command};

use crate::{
    identification::{Random, csv, displacement, open, places, unknowns},
    support::{engine::catalogue_machine, robot_data::robot_data},
};
use kinetostat::{
    questions::identification::{Identified, RowUse, predict, read, run},
    work::Work,
};
use nalgebra::Vector3;
use rand::SeedableRng as _;
use rand_distr::{Distribution as _, Normal};
use rayon::prelude::*;

/// Of how many readings intervals hold how many.
#[derive(Clone, Copy, Default)]
struct Held {
    held: usize,
    count: usize,
}

impl Held {
    fn share(self) -> f64 {
        self.held as f64 / self.count as f64
    }

    fn sum(all: impl IntoIterator<Item = Self>) -> Self {
        all.into_iter()
            .fold(Self::default(), |sum, own| Self { held: sum.held + own.held, count: sum.count + own.count })
    }
}

/// Identifies `machine` by the sheet `fitted` and predicts the readings of the sheet `out`; with the errors, mm.
fn predicted(machine: &str, keys: &str, fitted: &str, out: &str) -> (Identified, Held, Vec<f64>) {
    let mut study =
        open(machine, &format!("{keys}profile = false\n"), fitted).unwrap_or_else(|e| panic!("{machine}: {e}"));
    study.folds = 0;
    let found = run(&study, &Work::default()).unwrap().unwrap_or_else(|e| panic!("{machine}: {}", e.reason));
    let poses = read(out.as_bytes(), "out.csv", &study.machine, RowUse::Predictions).unwrap();
    let answers = predict(&study, &found, &poses).unwrap();
    let all: Vec<_> = answers.into_iter().flat_map(|own| own.unwrap_or_else(|e| panic!("{}", e.reason))).collect();
    let errors: Vec<f64> = all.iter().map(|own| own.measured.unwrap() - own.value).collect();
    let held = all.iter().zip(&errors).filter(|(own, error)| error.abs() <= own.half_width).count();
    (found, Held { held, count: all.len() }, errors)
}

/// The lines of a sheet for which `is_in` holds of the number of the row, and the others.
fn parted(sheet: &str, is_in: impl Fn(usize) -> bool) -> [String; 2] {
    let (head, rows) = sheet.trim_end().split_once('\n').unwrap();
    [true, false].map(|wanted| {
        let own = rows.lines().enumerate().filter(|(i, _)| is_in(*i) == wanted).map(|(_, row)| row);
        [head].into_iter().chain(own).collect::<Vec<_>>().join("\n")
    })
}

/// Identified on the other folds, intervals of parameters, model error and reading hold about 95 % of what was read at poses left out.
#[test]
fn intervals_hold_the_left_out_poses_of_a_measured_robot() {
    let Some(data) = robot_data() else { return };
    let joints: Vec<String> = (1..=5).map(|joint| format!("arm.J{joint}.stiffness")).collect();
    let joints: Vec<&str> = joints.iter().map(String::as_str).collect();
    let elbow: Vec<&str> = joints.iter().copied().chain(["arm.B3.stiffness.rx_rx"]).collect();
    let sets = [
        ("six joints", "fanuc_r2000ic", unknowns(&["arm.J*.stiffness"])),
        ("five joints", "bearings.toml", unknowns(&joints)),
        ("five joints and the elbow's bearing", "bearings.toml", unknowns(&elbow)),
    ];
    assert_eq!(data.trim_end().lines().count() - 1, 30);
    for (name, machine, keys) in sets {
        for folds in [5, 10] {
            let fold = |fold: usize| {
                let [out, fitted] = parted(&data, |i| i % folds == fold);
                predicted(machine, &keys, &fitted, &out).1
            };
            let each: Vec<Held> = (0..folds).into_par_iter().map(fold).collect();
            let all = Held::sum(each.iter().copied());
            let counts: Vec<usize> = each.iter().map(|own| own.held).collect();
            let of = each[0].count;
            println!(
                "{name}, {folds} folds: {} of {} ({:.3}); each of {of}: {counts:?}",
                all.held,
                all.count,
                all.share()
            );
            assert!((0.90..=0.98).contains(&all.share()), "{name}, {folds} folds: {}", all.share());
            // Of the 18 readings of a fold only 17 are 90 to 98 %. Intervals that are right hold 18 in 4 folds of 10, 16 or fewer in 2.
            assert!(folds != 5 || counts.iter().all(|held| *held >= 14), "{name}: {counts:?}");
        }
    }
}

/// The machines of foreign truths, and what is sought of each.
const FOREIGN: [(&str, &str); 2] = [("fanuc_r2000ic", "arm.J*.stiffness"), ("hexapod", "leg.screw.stiffness")];
/// Sets of sheets of each machine and truth.
const SETS: usize = 10;

/// The folder of sheets that a script of tests/foreign_truths makes, with the first `python3` there is.
fn sheets_of(script: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign_truths").join(script);
    let made = Command::new("python3").arg(&script).arg(folder.path()).arg(SETS.to_string()).status().unwrap();
    assert!(made.success(), "{}", script.display());
    folder
}

/// A machine identified by the sheets of a `truth`, and unseen poses predicted: how many readings intervals hold, and in how many sets the first
/// screen says that the model does not fit. Of poses with a load each, the same with the noise given, poses with five loads, and these with no word of which
/// are one pose. And what is wrong: too few or too many held, where not all sets say that the model does not fit.
fn held_of_foreign(folder: &Path, truth: &str, (machine, sought): (&str, &str)) -> ([(Held, usize); 4], String) {
    let without = |sheet: &str, is_out: fn(&str) -> bool| -> String {
        let kept: Vec<bool> = sheet.lines().next().unwrap().split(',').map(|column| !is_out(column)).collect();
        let cells = |line: &str| {
            let cells = line.split(',').zip(&kept).filter(|(_, kept)| **kept).map(|(cell, _)| cell);
            cells.collect::<Vec<_>>().join(",")
        };
        sheet.lines().map(cells).collect::<Vec<_>>().join("\n")
    };
    let one = |set: usize| {
        let sheet =
            |name: &str| std::fs::read_to_string(folder.join(format!("{truth}-{machine}-{set}-{name}.csv"))).unwrap();
        let (fitted, repeated, unseen) = (sheet("fitted"), sheet("repeated"), sheet("unseen"));
        let is_std = |column: &str| column == "std_mm";
        let is_std_or_pose = |column: &str| ["std_mm", "pose"].contains(&column);
        let unseen_alone = without(&unseen, is_std);
        let keys = unknowns(&[sought]);
        let share = |found: &Identified| {
            let left: f64 = found.fit.residuals.norm_squared();
            let measured = (&found.fit.predicted.values + &found.fit.residuals).norm_squared();
            (left / measured).sqrt()
        };
        let of = |fitted: &str, unseen: &str| {
            let (found, held, _) = predicted(machine, &keys, fitted, unseen);
            // What the first screen says: beyond the noise that is given, or more than a tenth left.
            let is_said = found.fit.is_beyond_noise || share(&found) > 0.1;
            (held, usize::from(is_said))
        };
        [
            of(&without(&fitted, is_std), &unseen_alone),
            of(&fitted, &unseen),
            of(&without(&repeated, is_std), &unseen_alone),
            of(&without(&repeated, is_std_or_pose), &unseen_alone),
        ]
    };
    let each: Vec<[(Held, usize); 4]> = (0..SETS).into_par_iter().map(one).collect();
    let pooled = [0, 1, 2, 3]
        .map(|way| (Held::sum(each.iter().map(|own| own[way].0)), each.iter().map(|own| own[way].1).sum::<usize>()));
    let words = pooled.map(|(held, said)| format!("{:.3} ({said})", held.share()));
    println!("{machine}, {truth}: held, and of {SETS} said not to fit: {}", words.join(", "));
    let mut wrong = String::new();
    // The last way takes readings of one pose for independent, as nobody said that they are not: it stands beside for comparison.
    for (held, said) in &pooled[..3] {
        if !(0.90..=0.98).contains(&held.share()) && *said < SETS {
            writeln!(wrong, "{machine}, {truth}: {:.3}, said {said} times", held.share()).unwrap();
        }
    }
    (pooled, wrong)
}

/// Sheets of machines that yield otherwise than any model here, made by a script that shares nothing with the engine: what is fitted, with a
/// load at each pose and with five, does not follow them. Intervals of poses that were not fitted hold what is read there all the same, or
/// the identification says that the model does not fit.
#[test]
#[ignore = "takes a minute, and Python; .ci/full runs it"]
fn intervals_hold_what_machines_do_that_no_model_expresses() {
    let folder = sheets_of("make.py");
    let mut all_wrong = String::new();
    for machine in FOREIGN {
        for truth in ["spring", "hardening", "play", "friction", "beams", "force_law"] {
            let (pooled, wrong) = held_of_foreign(folder.path(), truth, machine);
            all_wrong += &wrong;
            let words = pooled.map(|(_, said)| said);
            assert!(truth != "spring" || words.iter().all(|said| *said <= 1), "{machine:?}: {words:?}");
            assert!(truth == "spring" || truth == "beams" || words[1] == SETS, "{machine:?}, {truth}: {words:?}");
        }
    }
    assert!(all_wrong.is_empty(), "{all_wrong}");
}

/// The same of links bent as geometrically exact beams of another program.
#[test]
#[ignore = "takes half a minute, and Python with tests/foreign_truths/requirements.txt; .ci/full runs it"]
fn intervals_hold_what_beams_of_exudyn_do_that_no_model_expresses() {
    let folder = sheets_of("exudyn_beams.py");
    let wrong: String = FOREIGN.map(|machine| held_of_foreign(folder.path(), "exudyn", machine).1).concat();
    assert!(wrong.is_empty(), "{wrong}");
}

/// A sheet of ten poses of `machine`, read with noise: all rows, and all again until there are so many `copies`; with the names of poses or not.
fn repeated(machine: &str, seed: u64, copies: usize, is_named: bool) -> String {
    let own = catalogue_machine(machine);
    let mut random = Random::seed_from_u64(seed);
    let noise = Normal::new(0.0, 0.01).unwrap();
    let all = places(&own, 10, 600.0, &mut random);
    let read_there: Vec<Vector3<f64>> =
        all.iter().map(|place| displacement(&own, place).map(|d| d + noise.sample(&mut random))).collect();
    let sheet = csv(&own, &all, &read_there);
    let (head, rows) = sheet.trim_end().split_once('\n').unwrap();
    let mut text = format!("{}{head}\n", if is_named { "pose," } else { "" });
    // Not one after the other: what is one pose is for the name to say.
    for (i, row) in (0..copies).flat_map(|_| rows.lines().enumerate()) {
        writeln!(text, "{}{row}", if is_named { format!("p{i},") } else { String::new() }).unwrap();
    }
    text
}

/// Rows that say the same three times more tell nothing more: with the name of their pose or without it, intervals are about as wide as without
/// them.
#[test]
fn rows_of_one_pose_are_no_independent_readings() {
    let mean = |copies: usize, is_named: bool| {
        let width = |seed: u64| {
            let keys = unknowns(&["arm.J1.stiffness", "arm.J2.stiffness", "arm.J3.stiffness"]) + "profile = false\n";
            let study = open("fanuc_r2000ic", &keys, &repeated("fanuc_r2000ic", seed, copies, is_named)).unwrap();
            let found = run(&study, &Work::default()).unwrap().unwrap();
            found.estimates.iter().map(|own| own.half_width.ln()).sum::<f64>() / 3.0
        };
        let widths: Vec<f64> = (0..20).into_par_iter().map(width).collect();
        widths.iter().sum::<f64>() / 20.0
    };
    let single = mean(1, true);
    let [named, apart] = [true, false].map(|is_named| (mean(4, is_named) - single).exp());
    println!("half widths with four copies of each row: {named:.3} with, {apart:.3} without the names of poses");
    assert!((0.8..1.3).contains(&named), "{named}");
    assert!((apart / named - 1.0).abs() < 0.01, "{apart} {named}");
}

/// A fold has all rows of its poses: its error is that of a fit without any row of them.
#[test]
fn rows_of_one_pose_are_left_out_together() {
    let machine = "fanuc_r2000ic";
    let keys = unknowns(&["arm.J1.stiffness", "arm.J2.stiffness", "arm.J3.stiffness"]);
    let sheet = repeated(machine, 3, 2, true);
    let study = open(machine, &format!("{keys}folds = 5\nprofile = false\n"), &sheet).unwrap();
    let found = run(&study, &Work::default()).unwrap().unwrap();
    let mut errors = Vec::new();
    for fold in 0..5 {
        let [out, fitted] = parted(&sheet, |i| (i % 10) % 5 == fold);
        errors.extend(predicted(machine, &keys, &fitted, &out).2);
    }
    assert_eq!(errors.len(), 60);
    let expected = (errors.iter().map(|error| error * error).sum::<f64>() / 60.0).sqrt();
    let got = found.models[0].predicted_mm.as_ref().unwrap().unwrap();
    assert!((got / expected - 1.0).abs() < 1e-6, "{got} {expected}");
    let error = open(machine, &format!("{keys}folds = 11\n"), &sheet).unwrap_err();
    assert!(error.contains("folds: must be from 2 to 10, the number of poses, got 11"), "{error}");
}
