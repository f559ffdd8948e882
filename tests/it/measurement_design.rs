//! Plans of measurements: what is chosen tells more than what is drawn, and what is promised is kept when it has been measured.

use crate::support::{
    command::{printed, told},
    engine::catalogue_machine,
    robot_data::robot_data,
};
use kinetostat::{
    input::Folder,
    machine::{Machine, catalogue},
    questions::{
        Overrides, Study, StudyKind,
        identification::{self, IdentificationStudy, LossSpec, Measurement, Noise, Search},
        measurement_design::{Criterion, DesignProblem, MeasurementDesignStudy, Plan, end_of_arm, run},
    },
    work::Work,
};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;

fn open(machine: &str, keys: &str, files: &[(&str, &str)]) -> Result<StudyKind, String> {
    let text = format!("schema = 3\nquestion = \"Which?\"\nmachine = \"{machine}\"\n{keys}");
    let folder = Folder::in_memory(files.iter().map(|(name, text)| (name.to_string(), text.as_bytes().to_vec())));
    let study = Study::from_toml(&text, "study.toml", folder, &Overrides::default()).map_err(|e| e.to_string())?;
    Ok(study.kind)
}

fn design(machine: &str, keys: &str, files: &[(&str, &str)]) -> MeasurementDesignStudy {
    match open(machine, &format!("[measurement_design]\n{keys}"), files).unwrap_or_else(|e| panic!("{machine}: {e}")) {
        StudyKind::MeasurementDesign(study, ()) => *study,
        _ => panic!("another question"),
    }
}

fn identification(machine: &str, keys: &str, data: &str) -> IdentificationStudy {
    match open(machine, &format!("[identification]\ndata = \"data.csv\"\n{keys}"), &[("data.csv", data)]).unwrap() {
        StudyKind::Identification(study, ()) => *study,
        _ => panic!("another question"),
    }
}

fn planned(machine: &str, keys: &str, files: &[(&str, &str)]) -> Plan {
    run(&design(machine, keys, files), &Work::default()).unwrap().unwrap_or_else(|e| panic!("{machine}: {}", e.reason))
}

const SPREAD: &str = "[measurement_design.candidate]\nposes = 25\nforces_N = [[300.0, 0.0, 0.0], [0.0, 300.0, 0.0], [0.0, 0.0, 300.0]]\n";

/// Machines and what is sought of them.
const SOUGHT: [(&str, &str); 4] = [
    ("orthoglide", "\"leg.rail.stiffness\", \"leg.foot.height\""),
    ("fanuc_r2000ic", "\"arm.J*.stiffness\""),
    ("hexapod", "\"leg.screw.stiffness\", \"leg.strut.length\""),
    ("delta_3puu", "\"leg.rail.stiffness\""),
];

#[test]
fn what_is_chosen_tells_more_than_what_is_drawn() {
    for (machine, unknowns) in SOUGHT {
        let keys = format!("unknowns = [{unknowns}]\ncount = 6\nstd_mm = 0.01\n{SPREAD}");
        let plan = planned(machine, &keys, &[]);
        assert_eq!(plan.chosen.len(), 6, "{machine}");
        let volume = |widths: &[f64]| widths.iter().map(|width| width.ln()).sum::<f64>();
        let (chosen, random) = (plan.widths.last().unwrap(), plan.random.last().unwrap());
        assert!(volume(&chosen.each) < volume(&random.each), "{machine}: {chosen:?} {random:?}");
        // Each measurement more leaves every interval narrower, or as it was.
        for pair in plan.widths.windows(2) {
            assert!(pair[0].each.iter().zip(&pair[1].each).all(|(before, after)| after <= &(before * 1.000_001)));
        }
    }
}

#[test]
fn where_a_part_counts_its_error_is_smaller_than_by_the_best_of_all_numbers() {
    let part = "arm_J1_deg,arm_J2_deg,arm_J3_deg,arm_J4_deg,arm_J5_deg,arm_J6_deg,force_x_N,force_y_N,force_z_N\n\
        0,10,-40,0,50,0,0,0,-500\n10,20,-40,0,60,0,0,0,-500\n-10,20,-50,0,60,0,0,0,-500\n";
    let keys =
        "unknowns = [\"arm.J*.stiffness\"]\ncount = 4\nstd_mm = 0.01\ncriterion = \"tested\"\ntested = \"part.csv\"\n";
    let own = planned("fanuc_r2000ic", &format!("{keys}{SPREAD}"), &[("part.csv", part)]);
    let all = keys.replace("criterion = \"tested\"\ntested = \"part.csv\"\n", "");
    let all = planned("fanuc_r2000ic", &format!("{all}{SPREAD}"), &[]);
    // The same measure for both: where the best of all numbers is tested on the part.
    let study = design("fanuc_r2000ic", &format!("{keys}{SPREAD}"), &[("part.csv", part)]);
    let chosen: Vec<Measurement> = all.chosen.iter().map(|&i| study.candidates[i].clone()).collect();
    let made = MeasurementDesignStudy { measured: chosen, count: 1, draws: 0, ..study };
    let made = run(&made, &Work::default()).unwrap().unwrap();
    let of_part = own.widths.last().unwrap().tested_mm.unwrap();
    let of_all = made.widths[0].tested_mm.unwrap();
    println!("{of_part} mm where the part counts, {of_all} mm by all numbers");
    assert!(of_part < of_all, "{of_part} {of_all}");
    assert!(of_part < own.random.last().unwrap().tested_mm.unwrap());
}

/// Intervals that a plan promises are those that an identification of its measurements finds.
#[test]
fn what_is_promised_is_kept() {
    let keys = format!("unknowns = [\"arm.J*.stiffness\"]\ncount = 10\nstd_mm = 0.01\n{SPREAD}");
    let study = design("fanuc_r2000ic", &keys, &[]);
    let plan = run(&study, &Work::default()).unwrap().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    std::fs::create_dir(at("plan")).unwrap();
    let text =
        format!("schema = 3\nquestion = \"Which?\"\nmachine = \"fanuc_r2000ic\"\n[measurement_design]\n{}", keys);
    std::fs::write(at("plan/study.toml"), text).unwrap();
    let said = printed(&["design-measurements", &at("plan"), "--out", &at("out"), "--no-figures"]);
    assert!(said.contains("10 measurements will identify all 6 parameters"), "{said}");
    // A sheet in which nothing is filled in may be written over.
    printed(&["design-measurements", &at("plan"), "--out", &at("out"), "--no-figures"]);
    // What the machine itself would read, filled in.
    let sheet = std::fs::read_to_string(at("out/sheet.csv")).unwrap();
    let machine = catalogue_machine("fanuc_r2000ic");
    let chosen: Vec<&Measurement> = plan.chosen.iter().map(|&i| &study.candidates[i]).collect();
    let start = DVector::zeros(study.unknowns.len());
    let model = identification::LoadedModel::new(&machine, &study.unknowns, &start, &study.unknowns).unwrap();
    let mut filled = String::new();
    for (i, line) in sheet.lines().enumerate() {
        let Some(at) = i.checked_sub(1) else {
            filled += &format!("{line}\n");
            continue;
        };
        let read = model.each(&[chosen[at]]).remove(0).unwrap().values;
        filled += &format!("{}{},{},{}\n", line.trim_end_matches(','), format_args!(",{}", read[0]), read[1], read[2]);
    }
    std::fs::write(at("out/sheet.csv"), &filled).unwrap();
    let (code, _, error) = told(&["design-measurements", &at("plan"), "--out", &at("out"), "--no-figures"]);
    assert!(code == Some(2) && error.contains("sheet.csv: has readings from line 2 on"), "{code:?} {error}");
    assert_eq!(std::fs::read_to_string(at("out/sheet.csv")).unwrap(), filled);
    let found =
        identification("fanuc_r2000ic", "unknowns = [\"arm.J*.stiffness\"]\nstd_mm = 0.01\nfolds = 2\n", &filled);
    let found = identification::run(&found, &Work::default()).unwrap().unwrap();
    for (own, promised) in found.estimates.iter().zip(&plan.widths.last().unwrap().each) {
        let off = (own.half_width / promised - 1.0).abs();
        assert!(off < 1e-3, "{}: {} instead of {promised}", own.unknown.name, own.half_width);
    }
}

#[test]
fn what_no_candidate_tells_is_said() {
    // Forces along z alone do not turn the first joint, whose axis is z.
    let keys = "unknowns = [\"arm.J1.stiffness\", \"arm.J2.stiffness\"]\ncount = 3\nstd_mm = 0.01\n\
        [measurement_design.candidate]\nposes = 5\nforces_N = [[0.0, 0.0, -500.0]]\n";
    let plan = planned("fanuc_r2000ic", keys, &[]);
    let reached = plan.widths.last().unwrap();
    assert!(plan.most_information[0] < 1e-6 && reached.each[0] > 100.0, "{plan:?}");
    assert!(reached.each[1] < 0.1, "{plan:?}");
}

#[test]
fn candidates_keep_their_box_and_out_of_forbidden_ones() {
    let keys = "unknowns = [\"arm.J*.stiffness\"]\ncount = 3\nstd_mm = 0.01\n[measurement_design.candidate]\nposes = 30\n\
        forces_N = [[0.0, 0.0, -500.0]]\nmin_mm = [1000.0, -800.0, 400.0]\nmax_mm = [2400.0, 800.0, 1600.0]\n\
        branches = [\"front-up-noflip\"]\n[[measurement_design.candidate.forbidden]]\nname = \"table\"\n\
        min_mm = [1400.0, -400.0, 0.0]\nmax_mm = [2400.0, 400.0, 900.0]\n";
    let study = design("fanuc_r2000ic", keys, &[]);
    assert_eq!(study.candidates.len(), 30);
    for own in &study.candidates {
        let tip = own.at.pose.transform(study.machine.tool_tip);
        let is_in = |min: [f64; 3], max: [f64; 3]| (0..3).all(|i| (min[i]..=max[i]).contains(&tip[i]));
        assert!(is_in([1000.0, -800.0, 400.0], [2400.0, 800.0, 1600.0]), "{tip}");
        assert!(!is_in([1400.0, -400.0, 0.0], [2400.0, 400.0, 900.0]), "{tip}");
        assert_eq!(study.machine.branch_of(&own.at).unwrap().to_string(), "front-up-noflip");
    }
}

#[test]
fn bad_plans_are_refused_by_key() {
    let good = "unknowns = [\"arm.J1.stiffness\"]\ncount = 3\nstd_mm = 0.01\n";
    let spread = "[measurement_design.candidate]\nposes = 5\nforces_N = [[0.0, 0.0, -500.0]]\n";
    for (keys, expected) in [
        (format!("{}{spread}", good.replace("count = 3", "count = 0")), "count: must be from 1 to 5"),
        (format!("{}{spread}", good.replace("count = 3", "count = 6")), "count: must be from 1 to 5"),
        (format!("{}{spread}", good.replace("0.01", "-1.0")), "std_mm: must be greater than 0"),
        (format!("{}{spread}", good.replace("J1", "J9")), "unknowns[0]: arm.J9.stiffness: no parameter is called so"),
        (good.to_string(), "candidates: give either a file of candidates, or [measurement_design.candidate]"),
        (format!("{good}candidates = \"none.csv\"\n"), "candidates: \"none.csv\" is not a file"),
        (format!("{good}reads = [\"gauge_mm\"]\n{spread}"), "reads[0]: must be any of displacement_x_mm"),
        (format!("{good}reads = [\"rotation_x_deg\"]\n{spread}"), "std_deg: missing: rotation_x_deg is to be read"),
        (format!("{good}criterion = \"tested\"\n{spread}"), "tested: missing"),
        (format!("{good}tested = \"a.csv\"\n{spread}"), "tested: has no effect"),
        (format!("{good}{}", spread.replace("poses = 5", "poses = 0")), "candidate.poses: must be from 1 to 100000"),
        (
            format!("{good}{}", spread.replace("[[0.0, 0.0, -500.0]]", "[]")),
            "candidate.forces_N: must have at least one",
        ),
        (
            format!(
                "{good}{}",
                spread.replace("poses = 5", "poses = 100000").replace("[[", "[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [")
            ),
            "candidate.forces_N: 100000 poses under 3 forces are 300000 candidates: expected at most 200000",
        ),
        (format!("{good}{spread}min_mm = [0.0, 0.0, 0.0]\n"), "missing key `max_mm`"),
        (
            format!("{good}{spread}min_mm = [9e4, 0.0, 0.0]\nmax_mm = [1e5, 1.0, 1.0]\n"),
            "candidate.poses: 0 of 5 poses",
        ),
        (format!("{good}{spread}branches = [\"sideways\"]\n"), "candidate.branches[0]"),
    ] {
        let error = open("fanuc_r2000ic", &format!("[measurement_design]\n{keys}"), &[]).unwrap_err();
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}

/// RMS of what a fit to some of the robot's poses leaves of the others, mm.
fn left_of_others(study: &IdentificationStudy, kept: &[usize]) -> f64 {
    let (unknowns, priors) = (&study.unknowns, &study.priors);
    let noise = Noise { length: None, rotation: None, is_estimated: true };
    let work = Work::default();
    let search = Search { machine: &study.machine, unknowns, priors, noise, loss: LossSpec::Squares, work: &work };
    let own: Vec<&Measurement> = kept.iter().map(|&i| &study.measurements[i]).collect();
    let fit = search.fit(&own, &DVector::zeros(unknowns.len())).unwrap_or_else(|e| panic!("{e:?}"));
    let others: Vec<&Measurement> =
        (0..study.measurements.len()).filter(|i| !kept.contains(i)).map(|i| &study.measurements[i]).collect();
    let model = identification::LoadedModel::new(&study.machine, unknowns, &fit.x, &[]).unwrap();
    let (mut squares, mut count) = (0.0, 0);
    for (own, predicted) in others.iter().zip(model.each(&others)) {
        for (reading, predicted) in own.readings.iter().zip(predicted.unwrap().values.iter()) {
            squares += (reading.value - predicted).powi(2);
            count += 1;
        }
    }
    (squares / f64::from(count)).sqrt()
}

/// Twelve poses chosen before anything was measured predict the others better than twelve random ones.
#[test]
fn twelve_chosen_poses_of_the_robot_beat_twelve_random_ones() {
    let Some(data) = robot_data() else { return };
    let keys = "unknowns = [\"arm.J*.stiffness\"]\n";
    let study = identification("fanuc_r2000ic", keys, &data);
    let asked = format!("{keys}count = 12\nstd_mm = 0.2\ncandidates = \"poses.csv\"\n");
    // One pose stood beyond the travel of the file.
    let robot = catalogue::find("fanuc_r2000ic").unwrap().toml.replace("[-114.6, 114.6]", "[-125.0, 125.0]");
    let plan = planned("robot.toml", &asked, &[("poses.csv", &data), ("robot.toml", &robot)]);
    let chosen = left_of_others(&study, &plan.chosen);
    let draws = 50;
    let mut random: Vec<f64> = (0..draws)
        .map(|seed| {
            let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
            let mut all: Vec<usize> = (0..study.measurements.len()).collect();
            let count = all.len();
            (0..12).for_each(|k| all.swap(k, random.random_range(k..count)));
            left_of_others(&study, &all[..12])
        })
        .collect();
    random.sort_by(f64::total_cmp);
    let median = random[random.len() / 2];
    println!(
        "RMS error of the poses not used: {chosen:.3} mm by the chosen, {median:.3} mm by random ones (median of {draws})"
    );
    assert!(chosen < median, "{chosen} {median}");
}

/// The value of a criterion for an information matrix.
fn criterion_value(criterion: &Criterion, information: &DMatrix<f64>) -> f64 {
    let factors = information.clone().cholesky().unwrap();
    match criterion {
        Criterion::AllNumbers => factors.determinant().ln(),
        Criterion::Tested(tested) => -factors.solve(tested).trace().ln(),
    }
}

/// All sets of four of nine, by trying each.
#[test]
fn what_is_chosen_is_the_best_of_all_sets_or_nearly() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut rows = || DMatrix::from_fn(2, 3, |_, _| random.random_range(-1.0..1.0));
    let candidates: Vec<DMatrix<f64>> = (0..9).map(|_| rows()).collect();
    let tested = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 4.0, 0.5]);
    for criterion in [Criterion::AllNumbers, Criterion::Tested(tested)] {
        let choice = DesignProblem { candidates: &candidates, known: DMatrix::identity(3, 3) * 1e-6, criterion };
        let criterion_value = |set: &[usize]| criterion_value(&choice.criterion, &choice.information(set));
        let found = criterion_value(&choice.choose(4, &Work::default()).unwrap());
        let sets = (0u32..1 << 9).filter(|bits| bits.count_ones() == 4);
        let best = sets
            .map(|bits| criterion_value(&(0..9).filter(|i| bits >> i & 1 == 1).collect::<Vec<_>>()))
            .fold(f64::NEG_INFINITY, f64::max);
        // Exchanges of one end where no single one helps, which may be below the best of all sets.
        assert!(found <= best + 1e-9 && found > best - 0.05, "{found} {best}");
    }
}

#[test]
fn what_one_adds_is_what_the_measure_grows_by() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut rows = || DMatrix::from_fn(2, 3, |_, _| random.random_range(-1.0..1.0));
    let candidates: Vec<DMatrix<f64>> = (0..5).map(|_| rows()).collect();
    let tested = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 4.0, 0.5]);
    for criterion in [Criterion::AllNumbers, Criterion::Tested(tested)] {
        let choice = DesignProblem { candidates: &candidates, known: DMatrix::identity(3, 3) * 1e-6, criterion };
        let before = choice.information(&[0, 1]);
        let gains = choice.gains(&before, &[0]);
        assert_eq!(gains[0], f64::NEG_INFINITY);
        for (i, gain) in gains.iter().enumerate().skip(1) {
            let grown = criterion_value(&choice.criterion, &choice.information(&[0, 1, i]))
                - criterion_value(&choice.criterion, &before);
            assert!((gain - grown).abs() < 1e-9 * grown.abs().max(1.0), "{gain} {grown}");
        }
    }
}

#[test]
fn the_end_of_an_arm_is_where_the_search_for_it_ends() {
    let machine = Machine::named_or_file("fanuc_r2000ic").unwrap();
    for drives in [[0.3, 0.2, -0.5, 1.0, 0.7, -2.0], [-0.4, -0.3, 0.1, -0.2, -0.9, 0.5]] {
        let (end, found) = (end_of_arm(&machine, &drives).unwrap(), machine.forward_kinematics(&drives).unwrap().pose);
        assert!((end.translation - found.translation).norm() < 1e-9);
        assert!((end.rotation - found.rotation).norm() < 1e-12);
    }
    assert!(end_of_arm(&Machine::named_or_file("orthoglide").unwrap(), &[0.0; 3]).is_none());
}
