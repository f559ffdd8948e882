//! Uncertain inputs: draws, distributions, a machine with a design for each mounting, and the spread of a map against closed forms and brute force.

use std::collections::BTreeSet;

use kinetostat::{
    Machine, Overrides, Study, Work,
    compensation::{Method, Session, TaskPoint, compensate, compensate_batch},
    machine::Configuration,
    map::{self, MapPoint, WorkspaceMapStudy},
    process::uncertainty::{Distribution, P95, normal_cdf, normal_quantile, quantile, sobol},
    questions::StudyKind,
    simulation::{
        Source, settings,
        spread::{Audit, DeflectionSpread},
    },
    statics::{Batch, Sensitivities},
};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::support::{
    command::told,
    uncertain::{Drawn, EXACT_MODEL, LEVER, TOLERANCES, drawn, force, study_text},
};

// ---- draws ----------------------------------------------------------------------------------------------------------

#[test]
fn scrambles_are_evenly_spread_in_each_dimension_and_differ() {
    let (scrambles, points) = (3, 256);
    let all = sobol::points(sobol::MAX_DIMENSIONS, scrambles, points, 7);
    assert_eq!(all.len(), sobol::MAX_DIMENSIONS);
    for (dimension, own) in all.iter().enumerate() {
        assert_eq!(own.len(), scrambles * points);
        assert!(own.iter().all(|u| *u > 0.0 && *u < 1.0));
        for scramble in own.chunks(points) {
            let mut cells: Vec<usize> = scramble.iter().map(|u| (u * points as f64) as usize).collect();
            cells.sort_unstable();
            assert!(cells.iter().enumerate().all(|(cell, found)| cell == *found), "dimension {dimension}");
        }
        assert!(own[..points] != own[points..2 * points], "dimension {dimension}: two scrambles are the same");
    }
    // A dimension does not depend on how many there are, and another seed gives other points.
    assert_eq!(sobol::points(3, scrambles, points, 7)[..], all[..3]);
    assert!(sobol::points(3, scrambles, points, 8)[0] != all[0]);
}

/// The first two dimensions of the Sobol sequence are a (0, m, 2)-net: every box of the area of a point, of any proportions, holds one. The published
/// direction numbers of the next ones give nets of low t, which random points are far from.
#[test]
fn the_first_dimensions_are_nets() {
    let bits = 8;
    let points = sobol::points(6, 4, 1 << bits, 1);
    let most_in_a_box = |a: &[f64], b: &[f64]| {
        let of_shape = |wide: usize| {
            let (columns, rows) = (1 << wide, 1 << (bits - wide));
            let mut counts = vec![0; columns * rows];
            for (x, y) in a.iter().zip(b) {
                counts[(x * columns as f64) as usize * rows + (y * rows as f64) as usize] += 1;
            }
            counts.into_iter().max().unwrap()
        };
        (0..=bits).map(of_shape).max().unwrap()
    };
    for scramble in 0..4 {
        let own = |dimension: usize| &points[dimension][scramble << bits..(scramble + 1) << bits];
        assert_eq!(most_in_a_box(own(0), own(1)), 1);
        for dimension in 1..5 {
            assert!(most_in_a_box(own(dimension), own(dimension + 1)) <= 8, "dimensions {dimension} and the next");
        }
    }
}

/// A product of twenty factors whose integral is 1: evenly spread points integrate it far better than random ones, whose error at 4096 would be 0.5 %.
#[test]
fn twenty_dimensions_integrate_a_product() {
    let points = sobol::points(20, 16, 256, 0);
    let product = |index: usize| -> f64 {
        points.iter().enumerate().map(|(k, own)| 1.0 + (own[index] - 0.5) / (1.0 + k as f64)).product()
    };
    let mean = (0..4096).map(product).sum::<f64>() / 4096.0;
    assert!((mean - 1.0).abs() < 5e-4, "{mean}");
}

#[test]
fn normal_quantiles_are_exact() {
    // Values of tables with 15 digits.
    for (share, expected) in [
        (0.5, 0.0),
        (0.95, 1.644_853_626_951_472_7),
        (0.975, 1.959_963_984_540_054_2),
        (0.999, 3.090_232_306_167_813_5),
        (1e-10, -6.361_340_902_404_056),
    ] {
        let found = normal_quantile(share);
        assert!((found - expected).abs() < 1e-12, "{share}: {found} instead of {expected}");
        assert!((normal_cdf(found) / share - 1.0).abs() < 1e-12);
    }
}

#[test]
fn an_interval_fixes_both_its_quantiles() {
    let shares = [-1.0, 0.0, 1.0].map(|side: f64| side * normal_quantile(0.975));
    let of = |spread: Distribution, nominal: f64| shares.map(|z| spread.value(nominal, z));
    let logarithm = Distribution::Logarithm { below: 2f64.ln() / shares[2], above: 1.5f64.ln() / shares[2] };
    for (found, expected) in of(logarithm, 10.0).into_iter().zip([5.0, 10.0, 15.0]) {
        assert!((found - expected).abs() < 1e-12, "{found} instead of {expected}");
    }
    let uniform = Distribution::Uniform { least: -0.1, largest: 0.3 };
    for (found, expected) in of(uniform, 1.0).into_iter().zip([0.91, 1.1, 1.29]) {
        assert!((found - expected).abs() < 1e-12, "{found} instead of {expected}");
    }
    // Standard deviation over the median of draws.
    let spread = Distribution::of_relative_std(0.3);
    let values: Vec<f64> =
        sobol::points(1, 16, 4096, 0)[0].iter().map(|u| spread.value(1.0, normal_quantile(*u))).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    assert!((square.sqrt() - 0.3).abs() < 1e-3, "{}", square.sqrt());
}

// ---- a design for each mounting -------------------------------------------------------------------------------------

#[test]
fn a_machine_with_separate_mounts_is_the_same_and_has_more_parameters() {
    for name in kinetostat::machine::catalogue::names() {
        let machine = Machine::named(name).unwrap();
        let (separate, designs) = machine.with_separate_mounts().unwrap();
        assert_eq!(separate.chains, machine.chains, "{name}");
        assert_eq!(separate.home, machine.home, "{name}");
        let (own, shared) = (separate.parameters(), machine.parameters());
        if designs.is_empty() {
            assert_eq!(own, shared, "{name}");
            continue;
        }
        // What stood once for several chains stands once for each; provenance goes with it.
        for parameter in &own {
            let copy = designs.iter().filter(|(copy, _)| parameter.name.starts_with(&format!("{copy}.")));
            let copy = copy.max_by_key(|(copy, _)| copy.len());
            let in_design = copy.map(|(copy, design)| format!("{design}{}", &parameter.name[copy.len()..]));
            let of_mount = shared.iter().find(|own| own.name == parameter.name);
            let of_design = in_design.and_then(|name| shared.iter().find(|own| own.name == name));
            let from =
                of_mount.or(of_design).unwrap_or_else(|| panic!("{name}: {} comes from nowhere", parameter.name));
            assert_eq!((parameter.value, parameter.grade, parameter.interval), (from.value, from.grade, from.interval));
        }
    }
}

/// The derivative by a number that three legs share is the sum of those by each leg's own.
#[test]
fn derivatives_of_mounts_add_up_to_that_of_the_design() {
    let machine = Machine::named("orthoglide").unwrap();
    let (separate, _) = machine.with_separate_mounts().unwrap();
    let at = machine.inverse_kinematics_at(Vector3::new(40.0, -30.0, 20.0)).unwrap();
    let load = kinetostat::MillingForce::KLIMCHIK_GROOVE.wrench(0.7, &machine.tool_at(&at.pose.rotation));
    let derivatives = |machine: &Machine, names: &[&str]| {
        let (state, outcome) = crate::support::engine::settle(machine, &at, &load);
        assert_eq!(outcome.status, kinetostat::Status::Solved);
        let mut sensitivities = Sensitivities::new(machine, names).unwrap();
        let mut scratch = kinetostat::statics::Scratch::new(machine);
        sensitivities.at(machine, &at.drives, &state, &|_| load, &mut scratch).unwrap()
    };
    let shared = derivatives(&machine, &["leg.foot.width"])[0].twist;
    let own: Vec<_> = derivatives(&separate, &["x.foot.width", "y.foot.width", "z.foot.width"]);
    let sum = own.iter().fold(nalgebra::Vector6::zeros(), |sum, own| sum + own.twist);
    assert!((sum - shared).norm() < 1e-6 * shared.norm(), "{sum} instead of {shared}");
    assert!(own.iter().all(|own| own.twist.norm() > 0.01 * shared.norm()));
}

// ---- maps -----------------------------------------------------------------------------------------------------------

fn map_study(text: &str) -> WorkspaceMapStudy {
    match Study::from_toml(text, "study.toml", kinetostat::Folder::in_memory([]), &Overrides::default()).unwrap().kind {
        StudyKind::WorkspaceMap(map, _) => *map,
        _ => panic!("not a map"),
    }
}

/// A map with its slice at height 0.
fn study_of(machine: &str, process: &str, uncertainty: &str, map: &str) -> String {
    study_text(machine, process, uncertainty, &format!("[workspace_map]\nslices_z_mm = [0.0]\n{map}"))
}

/// Compliance and force are lognormal, so that the deflection is, whose quantiles are exact.
#[test]
fn a_lever_has_the_exact_quantiles() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lever.toml"), LEVER).unwrap();
    let (stiffness, load): (f64, f64) = (0.3, 0.15);
    let uncertainty = format!(
        "[[uncertainty.parameter]]\nname = \"guide.slide.stiffness\"\nrelative_std = {stiffness}\n[uncertainty.process]\nforce_relative_std = {load}"
    );
    let process = "process.tolerance_mm = 0.12\n".to_string() + &force(1000.0, 0.0, 0.0);
    let text = study_of("lever.toml", &process, &uncertainty, "grid = [2, 1, 1]");
    let study = Study::from_toml(&text, "study.toml", folder.path().to_path_buf(), &Overrides::default()).unwrap();
    let StudyKind::WorkspaceMap(study, _) = study.kind else { panic!("not a map") };
    let points = map::run(&study, &Work::default()).unwrap().points;
    // Of the logarithm: the standard deviation over the median is given.
    let variance = |relative: f64| (0.5 * (1.0 + (1.0 + 4.0 * relative * relative).sqrt())).ln();
    let std = (variance(stiffness) + variance(load)).sqrt();
    for point in &points {
        let spread = point.effect(Source::All).unwrap().spread.clone().unwrap();
        let exact = |share| 0.1 * (std * normal_quantile(share)).exp();
        let standard_error = spread.p95_standard_error_mm.unwrap();
        for (found, share) in [(spread.p95_mm, 0.95), (spread.median_mm, 0.5)] {
            let found = found.unwrap();
            // Three standard errors of 4096 draws.
            let error = (found / exact(share) - 1.0).abs();
            assert!(error < 0.008 && error * found < 3.0 * standard_error, "{found} instead of {}", exact(share));
        }
        let within = normal_cdf((0.12f64 / 0.1).ln() / std);
        assert!((spread.within_tolerance.unwrap() - within).abs() < 6e-3, "{spread:?} instead of {within}");
        assert_eq!(spread.main_cause.as_deref(), Some("guide.slide.stiffness"));
        let expected = variance(stiffness) / (variance(stiffness) + variance(load));
        assert!((spread.main_cause_share.unwrap() - expected).abs() < 0.02, "{spread:?} instead of {expected}");
        assert!(spread.check_difference.unwrap().abs() < 1e-6 && spread.solved_draws == 4, "{spread:?}");
    }
}

/// A worn tool needs more force than a sharp one, never less: the deflection is a lognormal number times a uniform one, whose quantiles are found by integration.
#[test]
fn a_worn_tool_on_a_lever_has_the_exact_quantiles() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lever.toml"), LEVER).unwrap();
    let (stiffness, load, wear): (f64, f64, f64) = (0.2, 0.15, 0.6);
    let study_with = |wear: &str| {
        let uncertainty = format!(
            "[[uncertainty.parameter]]\nname = \"guide.slide.stiffness\"\nrelative_std = {stiffness}\n[uncertainty.process]\nforce_relative_std = {load}\n{wear}"
        );
        let process = "process.tolerance_mm = 0.15\n".to_string() + &force(1000.0, 0.0, 0.0);
        let text = study_of("lever.toml", &process, &uncertainty, "grid = [1, 1, 1]");
        let study = Study::from_toml(&text, "study.toml", folder.path().to_path_buf(), &Overrides::default()).unwrap();
        let StudyKind::WorkspaceMap(study, _) = study.kind else { panic!("not a map") };
        study
    };
    let study = study_with(&format!("wear_force_increase = {wear}"));
    let spread_of = |study: &WorkspaceMapStudy| {
        map::run(study, &Work::default()).unwrap().points[0].effect(Source::All).unwrap().spread.clone().unwrap()
    };
    let spread = spread_of(&study);
    let variance = |relative: f64| (0.5 * (1.0 + (1.0 + 4.0 * relative * relative).sqrt())).ln();
    // Probability that the deflection is within `size`, by the rule of the middle.
    let steps: u32 = 2000;
    let within = |[stiffness, load, wear]: [f64; 3], size: f64| {
        let std = (variance(stiffness) + variance(load)).sqrt();
        let factor = |step: usize| 1.0 + wear * (step as f64 + 0.5) / f64::from(steps);
        (0..steps as usize).map(|step| normal_cdf((size / 0.1 / factor(step)).ln() / std)).sum::<f64>()
            / f64::from(steps)
    };
    let quantile_of = |relative: [f64; 3], share: f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if within(relative, middle) < share { low = middle } else { high = middle }
        }
        low
    };
    let relative = [stiffness, load, wear];
    let check = |found: Option<f64>, exact: f64| {
        let found = found.unwrap();
        assert!((found / exact - 1.0).abs() < 6e-3, "{found} instead of {exact}");
    };
    check(spread.p95_mm, quantile_of(relative, 0.95));
    check(spread.median_mm, quantile_of(relative, 0.5));
    assert!((spread.within_tolerance.unwrap() - within(relative, 0.15)).abs() < 6e-3, "{spread:?}");
    // Of a tool that is replaced when it needs half as much more.
    let uncertainty = study.uncertainty.clone().unwrap();
    let (half, words) = uncertainty.measured("tool wear").unwrap();
    let kept = WorkspaceMapStudy { uncertainty: Some(half), ..(*study).clone() };
    check(spread_of(&kept).p95_mm, quantile_of([stiffness, load, 0.5 * wear], 0.95));
    assert_eq!(words, "kept to half by changing tools earlier");
    assert!(!uncertainty.has_nominal_medians() && uncertainty.wear_force_increase() == Some(wear));
    // All else is drawn as without wear, and the factor of it is that of the force.
    let without = study_with("").uncertainty.unwrap();
    assert!(without.has_nominal_medians());
    assert_eq!((&without.draws.normal, &without.draws.model), (&uncertainty.draws.normal, &uncertainty.draws.model));
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    for (draw, factor) in without.draws.force_of(0).iter().enumerate() {
        let [sharp, wear] = uncertainty.draws.sharp_and_wear(0, draw);
        assert!((sharp / factor - 1.0).abs() < 1e-14);
        (least, most) = (least.min(wear), most.max(wear));
    }
    assert!((1.0..1.001).contains(&least) && (1.599..1.6).contains(&most), "{least} {most}");
    let [low, high] = uncertainty.force_factor_95().unwrap();
    for (found, share) in [(low, 0.025), (high, 0.975)] {
        check(Some(0.1 * found), quantile_of([0.0, load, wear], share));
    }
}

/// What the model leaves out is a share of the displacement in all directions, and the engine says so too.
#[test]
fn a_model_that_leaves_something_out_spreads_a_lever() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lever.toml"), LEVER).unwrap();
    let share = 0.3;
    let text = study_of(
        "lever.toml",
        &force(1000.0, 0.0, 0.0),
        &format!("[uncertainty.model]\nrelative_std = {share}"),
        "grid = [2, 1, 1]",
    );
    let study = Study::from_toml(&text, "study.toml", folder.path().to_path_buf(), &Overrides::default()).unwrap();
    let StudyKind::WorkspaceMap(study, _) = study.kind else { panic!("not a map") };
    let points = map::run(&study, &Work::default()).unwrap().points;
    let z: Vec<Vec<f64>> = sobol::points(3, 1, 1 << 14, 99);
    let at = |axis: usize, index: usize| share / 3.0f64.sqrt() * normal_quantile(z[axis][index]);
    let size = |index: usize| 0.1 * Vector3::new(1.0 + at(0, index), at(1, index), at(2, index)).norm();
    let mut sizes: Vec<f64> = (0..1 << 14).map(size).collect();
    let spread = points[0].effect(Source::All).unwrap().spread.clone().unwrap();
    for (found, share) in [(spread.p95_mm, P95), (spread.median_mm, 0.5)] {
        let (found, expected) = (found.unwrap(), quantile(&mut sizes, share));
        assert!((found / expected - 1.0).abs() < 6e-3, "{found} instead of {expected}");
    }
    assert_eq!(spread.main_cause.as_deref(), Some("what the model leaves out"));
    assert!(spread.check_difference.unwrap().abs() < 1e-6 && spread.solved_draws == 4, "{spread:?}");
}

/// The study's text with its slice at the floor of the workspace of a built-in machine.
fn on_the_floor(text: &str, machine: &str) -> String {
    let z = Machine::named(machine).unwrap().workspace.min.z;
    text.replace("slices_z_mm = [0.0]", &format!("slices_z_mm = [{z:?}]"))
}

/// Nobody says what the model of a machine leaves out: a default, and the first screen says so.
#[test]
fn what_a_model_leaves_out_has_a_default() {
    let force_alone = "[uncertainty.process]\nforce_relative_std = 0.1";
    let text = study_of("kr270", &force(1.0, 0.0, 0.0), force_alone, "grid = [1, 1, 1]\nphi_step_deg = 180.0");
    let study = map_study(&on_the_floor(&text.replace(EXACT_MODEL, ""), "kr270"));
    assert_eq!(study.uncertainty.as_ref().unwrap().model.relative_std, 0.26);
    let said = map::report::text(&map::report::Summary::new(&study), &[]).cautions;
    assert!(said.contains("The model itself is assumed to be wrong by 26 % of what the force does"), "{said}");
    assert_eq!(map_study(&on_the_floor(&text, "kr270")).uncertainty.unwrap().model.relative_std, 0.0);
}

/// Longest displacements over φ in `count` draws at each of `positions`, without the surrogate and the draws of the map. Positions are side by side: with the
/// bits that they have one by one, as the first of every 500 draws shows.
fn brute_force(study: &WorkspaceMapStudy, positions: &[Vector3<f64>], count: usize) -> Vec<Vec<f64>> {
    const IN_A_PIECE: usize = 500;
    let (load_case, uncertainty) = (&study.load_case, study.uncertainty.as_ref().unwrap());
    let commands: Vec<_> =
        positions.iter().map(|position| load_case.machine.inverse_kinematics_at(*position).unwrap()).collect();
    let sizes = |Drawn { unloaded, actual, factor }: &Drawn, is_alone: bool| -> Vec<f64> {
        let at_home = Session::new(&load_case.machine, actual, settings()).with_unloaded_machine(unloaded);
        let begin = |at| {
            let mut session = at_home.clone();
            session.set_rigid(at);
            session
        };
        let mut sessions: Vec<Session> = commands.iter().map(begin).collect();
        let mut batch = Batch::new(actual);
        let mut longest = vec![0.0f64; commands.len()];
        for phi in &load_case.phis {
            let task = |at: &Configuration| {
                let load = load_case.force.wrench(*phi, &load_case.machine.tool_at(&at.pose.rotation)).scale(*factor);
                TaskPoint::new(at.pose, load, load_case.target)
            };
            let tasks: Vec<TaskPoint> = commands.iter().map(task).collect();
            let answers = if is_alone {
                sessions.iter_mut().zip(&tasks).map(|(own, task)| compensate(own, task, Method::None)).collect()
            } else {
                compensate_batch(&mut sessions.iter_mut().collect::<Vec<_>>(), &tasks, Method::None, &mut batch)
            };
            for (longest, answer) in longest.iter_mut().zip(answers) {
                let size = if answer.status.is_success() { answer.tool_displacement.norm() } else { f64::INFINITY };
                *longest = longest.max(size);
            }
        }
        longest
    };
    let points = sobol::points(uncertainty.parameters.len() + 2, 1, count, 4711);
    let piece = |first: usize| -> Vec<Vec<f64>> {
        let draw = |index: usize| {
            let z: Vec<f64> = points.iter().map(|own| normal_quantile(own[first + index])).collect();
            let drawn = drawn(uncertainty, &load_case.errors, &z);
            let own = sizes(&drawn, false);
            assert!(index > 0 || own == sizes(&drawn, true), "{}", load_case.machine.name);
            own
        };
        (0..IN_A_PIECE.min(count - first)).map(draw).collect()
    };
    let firsts: Vec<usize> = (0..count).step_by(IN_A_PIECE).collect();
    let draws = firsts.into_par_iter().map(piece).collect::<Vec<_>>().concat();
    (0..positions.len()).map(|at| draws.iter().map(|own| own[at]).collect()).collect()
}

/// Compares the spread at `points` of `study` with brute force of `count` draws: quantiles within `share`, probabilities within 1.5 %.
fn check_against_brute_force(study: &WorkspaceMapStudy, points: &[&MapPoint], count: usize, share: f64) {
    let name = &study.load_case.machine.name;
    let positions: Vec<_> = points.iter().map(|point| Vector3::from(point.position_mm)).collect();
    for (point, mut sizes) in points.iter().zip(brute_force(study, &positions, count)) {
        let spread = point.effect(Source::All).unwrap().spread.clone().unwrap();
        for (what, found, at) in [("P95", spread.p95_mm, P95), ("median", spread.median_mm, 0.5)] {
            let found = found.unwrap();
            let expected = quantile(&mut sizes, at);
            let error = found / expected - 1.0;
            assert!(
                error.abs() < share,
                "{name} {:?}: {what} {found} instead of {expected}, {spread:?}",
                point.position_mm
            );
        }
        if let (Some(tolerance), Some(found)) = (study.load_case.tolerance_mm, spread.within_tolerance) {
            let expected = sizes.iter().filter(|size| **size <= tolerance).count() as f64 / count as f64;
            assert!((found - expected).abs() < 0.015, "{name} {:?}: {found} instead of {expected}", point.position_mm);
        }
    }
}

fn uncertain_stiffness(pattern: &str, relative_std: f64) -> String {
    format!(
        "[uncertainty]\n[[uncertainty.parameter]]\nname = \"{pattern}\"\nrelative_std = {relative_std}\n{TOLERANCES}"
    )
}

/// The map of a point of `machine` with these uncertain parameters beside [`TOLERANCES`].
fn map_of(machine: &str, load: &str, tolerance: f64, uncertainty: &str, z: f64) -> (WorkspaceMapStudy, Vec<MapPoint>) {
    let process = format!("process.tolerance_mm = {tolerance}\n{load}");
    let text = study_of(machine, &process, uncertainty, "grid = [2, 1, 1]\nphi_step_deg = 30.0");
    let study = map_study(&text.replace("slices_z_mm = [0.0]", &format!("slices_z_mm = [{z:?}]")));
    let points = map::run(&study, &Work::default()).unwrap().points;
    (study, points)
}

/// An overconstrained machine whose legs pull against one another, by elastic constants and by sections; one with six legs and a beam each; an arm
/// under its weight.
#[test]
fn maps_agree_with_brute_force() {
    let (small, large) = (force(215.0, -10.0, -25.0), force(800.0, 300.0, -200.0));
    for (machine, pattern, relative, load, tolerance, z) in [
        ("orthoglide", "material.aluminium.*", 0.3, &small, 0.7, 0.0),
        ("orthoglide", "leg.foot.height", 0.08, &small, 0.7, 0.0),
        ("hexapod", "leg.screw.stiffness", 0.3, &large, 0.1, 800.0),
        ("kr500", "arm.*.stiffness", 0.3, &large, 1.0, 850.0),
    ] {
        let (study, points) = map_of(machine, load, tolerance, &uncertain_stiffness(pattern, relative), z);
        check_against_brute_force(&study, &[&points[0]], 2048, 0.015);
    }
}

/// Compliances that vary so much that what two do to one another counts: the surrogate differs from the engine, and draws correct it.
#[test]
fn what_the_surrogate_leaves_out_is_corrected_by_the_engine() {
    let uncertainty = uncertain_stiffness("leg.foot.height", 0.2);
    let (study, points) = map_of("orthoglide", &force(215.0, -10.0, -25.0), 0.7, &uncertainty, 0.0);
    let spread = points[0].effect(Source::All).unwrap().spread.clone().unwrap();
    assert!(spread.check_difference.unwrap().abs() > 0.005 && spread.solved_draws > 4, "{spread:?}");
    check_against_brute_force(&study, &[&points[0]], 2048, 0.02);
}

/// A mass on a soft revolute joint: the draws in which it falls over count as out of tolerance.
#[test]
fn draws_without_equilibrium_are_out_of_tolerance() {
    let folder = tempfile::tempdir().unwrap();
    let pendulum = r#"
schema = 1
name = "pendulum"
title = "a mass on a revolute joint"
zeroed = "weightless"
[platform]
tool_tip_mm = [0.0, 0.0, 10.0]
controls = ["x"]
mass = { kg = 10.0 }
[home]
position_mm = [0.0, 0.0, 1000.0]
[workspace]
min_mm = [0.0, 0.0, 1000.0]
max_mm = [0.0, 0.0, 1000.0]
[[chain]]
name = "arm"
elements = [
  { revolute_drive = { name = "hinge", axis = "y", stiffness_Nmm_per_rad = 147150.0 } },
  { fixed = { translation_mm = [0.0, 0.0, 1000.0] } },
]
[[mount]]
name = "arm"
chain = "arm"
"#;
    std::fs::write(folder.path().join("pendulum.toml"), pendulum).unwrap();
    let uncertainty = "[[uncertainty.parameter]]\nname = \"arm.hinge.stiffness\"\nrelative_std = 0.5\n";
    let process = "process.tolerance_mm = 1e3\n".to_string() + &force(0.01, 0.0, 0.0);
    let map = "grid = [1, 1, 1]\nphi_step_deg = 90.0";
    let text =
        study_of("pendulum.toml", &process, uncertainty, map).replace("slices_z_mm = [0.0]", "slices_z_mm = [1000.0]");
    let study = Study::from_toml(&text, "study.toml", folder.path().to_path_buf(), &Overrides::default()).unwrap();
    let StudyKind::WorkspaceMap(study, _) = study.kind else { panic!("not a map") };
    let points = map::run(&study, &Work::default()).unwrap().points;
    let spread = points[0].effect(Source::All).unwrap().spread.clone().unwrap();
    // It falls where the stiffness is below weight times length, two thirds of the nominal one.
    let std = (0.5f64 * (1.0 + 2f64.sqrt())).ln().sqrt();
    let falls = normal_cdf((98_100.0f64 / 147_150.0).ln() / std);
    let failed = spread.failed_draws as f64 / spread.solved_draws as f64;
    assert!((failed - falls).abs() < 0.01, "{failed} instead of {falls}: {spread:?}");
    assert!((spread.within_tolerance.unwrap() - (1.0 - falls)).abs() < 0.02, "{spread:?}");
    assert!(spread.p95_mm.is_none() && spread.first_failure.is_some(), "{spread:?}");
    assert!(spread.median_mm.is_some_and(f64::is_finite));
}

/// Rods of carbon that buckle where they are soft: the tool says nothing of it before, and draws next to the 95 % quantile need not. Each point counts them all.
#[test]
fn rods_that_buckle_count_at_each_point() {
    let uncertainty = "[[uncertainty.parameter]]\nname = \"material.carbon.youngs_modulus\"\nrelative_std = 0.4\n"
        .to_string()
        + TOLERANCES;
    let map = "grid = [4, 4, 2]\nphi_step_deg = 180.0";
    let text = study_of("rotary_delta", &force(300.0, -100.0, -100.0), &uncertainty, map);
    let study = map_study(&on_the_floor(&text, "rotary_delta"));
    let (mut audit, mut shares, mut positions) = (Audit::default(), Vec::new(), Vec::new());
    for point in map::run(&study, &Work::default()).unwrap().points {
        let Some(spread) = point.effect(Source::All).and_then(|own| own.spread.clone()) else { continue };
        audit.add(&spread.audit);
        shares.push(spread.failed_share);
        positions.push(Vector3::from(point.position_mm));
    }
    let failed = |sizes: &Vec<f64>| sizes.iter().filter(|size| size.is_infinite()).count() as f64 / sizes.len() as f64;
    let expected: Vec<f64> = brute_force(&study, &positions, 512).iter().map(failed).collect();
    let most = expected.iter().fold(0.0, |most: f64, own| most.max(*own));
    // Three standard deviations of a share of 512 draws.
    let is_near = |(own, share): (&f64, &f64)| (own - share).abs() < 3.0 * (most * (1.0 - most) / 512.0).sqrt();
    assert!(most > 0.02 && shares.iter().zip(&expected).all(is_near), "{shares:?} instead of {expected:?}");
    assert!(audit.draws > 500 && audit.failed > 5 && audit.unforeseen == 0, "{audit:?}");
}

#[test]
fn spreads_are_the_same_on_any_number_of_threads() {
    let uncertainty = uncertain_stiffness("leg.*.stiffness", 0.3);
    let text =
        study_of("orthoglide", &force(215.0, -10.0, -25.0), &uncertainty, "grid = [3, 3, 2]\nphi_step_deg = 90.0");
    let study = map_study(&text);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| map::run(&study, &Work::default()).unwrap().points)
    };
    let one = on(1);
    assert_eq!(one, on(3));
    // A point alone is checked by more draws than one among others, and is the same by more than its check.
    let p95 = |point: &MapPoint| point.effect(Source::All).unwrap().spread.as_ref().unwrap().p95_mm.unwrap();
    let alone = &map::run_range(&study, 11..12, &Work::default()).unwrap()[0];
    assert!((p95(alone) / p95(&one[11]) - 1.0).abs() < 5e-3, "{alone:?}, {:?}", one[11]);
}

/// What is assumed varies on every built-in machine that has something so graded: matrices of links as a whole.
#[test]
fn provenance_of_built_in_machines_is_accepted() {
    let mut count = 0;
    for name in kinetostat::machine::catalogue::names() {
        let machine = Machine::named(name).unwrap();
        let z = machine.workspace.min.z;
        let text =
            study_of(name, &force(100.0, 0.0, 0.0), "[uncertainty]\nmachine = \"provenance\"", "grid = [1, 1, 1]");
        let text = text.replace("slices_z_mm = [0.0]", &format!("slices_z_mm = [{z:?}]"));
        match Study::from_toml(&text, "study.toml", kinetostat::Folder::in_memory([]), &Overrides::default()) {
            Ok(_) => count += 1,
            Err(error) => assert!(error.to_string().contains("varies nothing"), "{name}: {error}"),
        }
    }
    assert!(count >= 5, "{count} machines");
}

/// The cause is what alone spreads the length of the displacement, also where the nominal one is zero.
#[test]
fn the_main_cause_is_what_moves_the_tool() {
    let uncertainty = "[[uncertainty.parameter]]\nname = \"leg.rail.stiffness\"\nrelative_std = 0.2\n[[uncertainty.chain_error]]\nchain = \"x\"\n\
         drive_offsets_mm_or_deg = { std = 0.2 }";
    let text = study_of("orthoglide", &force(0.0, 0.0, 0.0), uncertainty, "grid = [2, 1, 1]\nphi_step_deg = 90.0");
    let points = map::run(&map_study(&text), &Work::default()).unwrap().points;
    let spread = points[0].effect(Source::All).unwrap().spread.clone().unwrap();
    assert_eq!(spread.main_cause.as_deref(), Some("x.rail.offset"), "{spread:?}");
    assert!(spread.main_cause_share.unwrap() > 0.99, "{spread:?}");
}

/// A pattern names the stiffnesses of drives and, as wholes, the matrices of links beside them; `shared` takes all mountings together.
#[test]
fn a_pattern_names_matrices_and_numbers() {
    let names_of = |shared: &str| -> Vec<Vec<String>> {
        let uncertainty =
            format!("[[uncertainty.parameter]]\nname = \"leg.*.stiffness\"\nrelative_std = 0.1\nshared = {shared}");
        let text = study_of("delta_3puu", &force(100.0, 0.0, 0.0), &uncertainty, "grid = [1, 1, 1]");
        let machine = Machine::named("delta_3puu").unwrap();
        let study = map_study(&text.replace("[0.0]", &format!("[{:?}]", machine.workspace.min.z)));
        let names = |own: &kinetostat::process::uncertainty::UncertainParameter| {
            own.values.iter().map(|(name, _)| name.clone()).collect()
        };
        study.uncertainty.unwrap().parameters.iter().map(names).collect()
    };
    let own = names_of("false");
    assert_eq!(own.iter().map(Vec::len).collect::<Vec<_>>(), [1, 21, 1, 21, 1, 21], "{own:?}");
    assert!(own[0][0].ends_with(".rail.stiffness") && own[1].iter().all(|name| name.contains(".rod.stiffness.")));
    let shared = names_of("true");
    assert_eq!(shared.iter().map(Vec::len).collect::<Vec<_>>(), [3, 63], "{shared:?}");
}

/// A tool that is probably within tolerance, but not with 95 % probability, is not said to be out of it with 95 % probability.
#[test]
fn the_verdict_says_what_is_known() {
    let load = force(800.0, 300.0, -200.0);
    let verdict = |tolerance: f64| {
        let uncertainty = uncertain_stiffness("leg.screw.stiffness", 0.3);
        let (study, points) = map_of("hexapod", &load, tolerance, &uncertainty, 800.0);
        let spread = points[0].effect(Source::All).unwrap().spread.clone().unwrap();
        let mut summary = map::report::Summary::new(&study);
        points.iter().for_each(|point| summary.add(point));
        (spread, map::report::text(&summary, &[]).place)
    };
    let (spread, all) = verdict(10.0);
    assert!(all.contains("The tool is within tolerance (10 mm) in all of the box with 95 % probability."), "{all}");
    let between = 0.5 * (spread.median_mm.unwrap() + spread.p95_mm.unwrap());
    let (spread, none) = verdict(between);
    assert!(spread.within_tolerance.unwrap() > 0.5, "{spread:?}");
    assert!(
        none.contains(&format!("The tool is nowhere within tolerance ({between} mm) with 95 % probability.")),
        "{none}"
    );
    assert!(!none.contains("probability the tool is out of tolerance"), "{none}");
}

/// With the stiffness of the lever known to ±5 % the quantile is that of other lognormal numbers; the model, of which nobody says anything, is fitted.
#[test]
fn an_answer_says_what_a_measurement_gains() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    std::fs::create_dir(&study).unwrap();
    std::fs::write(study.join("lever.toml"), LEVER).unwrap();
    let said = |tolerance: f64, stiffness: &str, model: &str| -> (String, serde_json::Value) {
        let process = format!("process.tolerance_mm = {tolerance}\n{}", force(1000.0, 0.0, 0.0));
        let uncertainty =
            format!("[uncertainty]\n{stiffness}[uncertainty.process]\nforce_relative_std = 0.15\n{model}");
        let text = study_of("lever.toml", &process, &uncertainty, "grid = [2, 1, 1]");
        let text = if model.is_empty() { text.replace(EXACT_MODEL, "") } else { text };
        std::fs::write(study.join("study.toml"), text).unwrap();
        let out = folder.path().join("out");
        let own = ["run", study.to_str().unwrap(), "--out", out.to_str().unwrap(), "--no-figures"];
        let (code, printed, err) = told(&own);
        assert_eq!(code, Some(0), "{printed}{err}");
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        let words = printed.split_whitespace().collect::<Vec<_>>().join(" ");
        (words, serde_json::from_str(&summary).unwrap())
    };
    let stiffness = "[[uncertainty.parameter]]\nname = \"guide.slide.stiffness\"\nrelative_std = 0.3\n";
    let (words, summary) = said(0.12, stiffness, EXACT_MODEL);
    let log = |relative: f64| (0.5 * (1.0 + (1.0 + 4.0 * relative * relative).sqrt())).ln().sqrt();
    let exact = |std: f64| 0.1 * (std.hypot(log(0.15)) * normal_quantile(P95)).exp();
    let found = summary["uncertainty"]["if_measured"]["p95_mm"].as_array().unwrap();
    for (found, exact) in found.iter().zip([exact(log(0.3)), exact(1.05f64.ln() / normal_quantile(0.975))]) {
        assert!((found.as_f64().unwrap() / exact - 1.0).abs() < 0.005, "{found} {exact}");
    }
    assert!(
        words.contains("Worth most: guide.slide.stiffness known to ±5 %. Where the 95 % quantile is the largest, that of this place alone would fall from 0.1"),
        "{words}"
    );
    let (words, _) = said(0.05, stiffness, EXACT_MODEL);
    assert!(words.contains("but nominally nothing is within tolerance, so a stiffer machine"), "{words}");
    let (words, summary) = said(0.12, "", "");
    assert_eq!(summary["uncertainty"]["if_measured"]["cause"], "cutting force");
    assert!(
        words.contains("Within tolerance, with all stiffnesses taken as exact: ")
            || words.contains("Out of tolerance, with all stiffnesses taken as exact: "),
        "{words}"
    );
}

// ---- all built-in machines ------------------------------------------------------------------------------------------

/// Events whose probability lies in one tenth of 0 to 1.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    events: usize,
    expected: f64,
    within: usize,
}

/// P95 at up to 20 points of every built-in machine: stiffness 30 %, force 15 %, errors of chains ±0.1°, against 100,000 independent draws: within 1 % at
/// 99 % of the points. And probabilities within tolerance, for five tolerances, against how often it is so: in each of ten bins within 3 %.
#[test]
#[ignore = "takes a quarter of an hour on two cores; .ci/full runs it"]
fn long_maps_of_all_machines_agree_with_brute_force() {
    let given = std::env::var("BRUTE_FORCE_DRAWS").ok().map(|own| own.parse().unwrap());
    let count: usize = given.unwrap_or(1 << 14);
    let errors_of = |name: &str| -> (Vec<f64>, [Bin; 10]) {
        let machine = Machine::named(name).unwrap();
        let is_elastic = |own: &kinetostat::machine::Parameter| {
            own.unit.is_stiffness() && own.value.is_some_and(|value| value > 0.0) && !own.name.contains("carrier")
        };
        // The entries of a matrix vary as a whole.
        let whole =
            |name: &str| name.find(".stiffness.").map_or(name, |at| &name[..at + ".stiffness".len()]).to_owned();
        let elastic: BTreeSet<String> =
            machine.parameters().into_iter().filter(is_elastic).map(|own| whole(&own.name)).collect();
        let entry = |name: &String| format!("[[uncertainty.parameter]]\nname = \"{name}\"\nrelative_std = 0.3\n");
        let uncertainty = elastic.iter().map(entry).collect::<String>() + TOLERANCES;
        let text =
            study_of(name, &force(300.0, -100.0, -100.0), &uncertainty, "grid = [5, 2, 2]\nphi_step_deg = 180.0");
        let mut study = map_study(&on_the_floor(&text, name));
        let points = map::run(&study, &Work::default()).unwrap().points;
        let known: Vec<(&MapPoint, f64)> = points
            .iter()
            .filter_map(|point| Some((point, point.effect(Source::All)?.spread.as_ref()?.p95_mm?)))
            .collect();
        assert!(known.len() >= 10, "{name}: {} points with a P95", known.len());
        let positions: Vec<_> = known.iter().map(|(point, _)| Vector3::from(point.position_mm)).collect();
        let brute = brute_force(&study, &positions, count);
        let error =
            |((_, found), sizes): (&(&MapPoint, f64), &Vec<f64>)| found / quantile(&mut sizes.clone(), P95) - 1.0;
        let errors: Vec<f64> = known.iter().zip(&brute).map(error).collect();
        let mut bins = [Bin::default(); 10];
        for share in [0.1, 0.3, 0.5, 0.7, 0.9] {
            let tolerance = quantile(&mut brute.concat(), share);
            study.load_case.tolerance_mm = Some(tolerance);
            for point in map::run(&study, &Work::default()).unwrap().points {
                let Some(spread) = point.effect(Source::All).and_then(|own| own.spread.as_ref()) else { continue };
                let Some(at) = known.iter().position(|(own, _)| own.position_mm == point.position_mm) else { continue };
                let probability = spread.within_tolerance.unwrap();
                let bin = &mut bins[((10.0 * probability) as usize).min(9)];
                bin.events += count;
                bin.expected += probability * count as f64;
                bin.within += brute[at].iter().filter(|size| **size <= tolerance).count();
            }
        }
        let most = errors.iter().fold(0.0, |most: f64, error| most.max(error.abs()));
        let sum = |of: fn(&DeflectionSpread) -> usize| -> usize {
            known.iter().map(|(point, _)| of(point.effect(Source::All).unwrap().spread.as_ref().unwrap())).sum()
        };
        let [draws, unforeseen, apart] =
            [sum(|own| own.audit.draws), sum(|own| own.audit.unforeseen), sum(|own| own.audit.apart)];
        println!("{name}: {apart} of {draws} draws apart, {unforeseen} without equilibrium that were not foreseen");
        assert_eq!(unforeseen, 0, "{name}");
        println!("{name}: {} points, P95 off by at most {:.2} %", errors.len(), 100.0 * most);
        (errors, bins)
    };
    let names: Vec<&str> = kinetostat::machine::catalogue::names().collect();
    let (errors, bins): (Vec<Vec<f64>>, Vec<[Bin; 10]>) = names.par_iter().map(|name| errors_of(name)).unzip();
    for number in 0..10 {
        let all = bins.iter().map(|own| own[number]);
        let [events, within] =
            [all.clone().map(|own| own.events).sum(), all.clone().map(|own| own.within).sum::<usize>()];
        let [expected, found] = [all.map(|own| own.expected).sum(), within as f64].map(|own: f64| own / events as f64);
        println!("of {events} with a probability near {expected:.3}, {found:.3} are within tolerance");
        assert!(events >= 4000 && (found - expected).abs() < 0.03, "{expected}: {found} of {events}");
    }
    let far = |own: &Vec<f64>| own.iter().filter(|error| error.abs() > 0.01).count();
    let (far, all): (usize, usize) = (errors.iter().map(far).sum(), errors.iter().map(Vec::len).sum());
    assert!(far * 100 <= all && errors.iter().flatten().all(|error| error.abs() < 0.015), "{far} of {all}: {errors:?}");
}
