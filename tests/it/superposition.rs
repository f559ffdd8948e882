//! The superposition study: what its numbers must satisfy.

use std::path::Path;

use crate::support::engine::*;
use kinetostat::{
    answer::Run,
    figures::Colours,
    files::exchange::{WrittenRows, csv},
    machine::{ChainError, Machine},
    process::{ForceLaw, MillingForce},
    questions::{
        Answered, Overrides, Study, StudyKind,
        over_workspace::Shown,
        superposition::{
            LocationResult, Scaling, Superposition, SuperpositionStudy,
            ablation::Cause,
            growth, report, run,
            safe::LargestFactor,
            superposition_error::{Followed, Sum},
        },
    },
    simulation::LoadCase,
    spatial::{Grid, Pose, Wrench},
    statics::{Scratch, tool_compliance, unloaded_stiffness},
    work::Work,
};
use nalgebra::{Matrix3, Vector3};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/05_superposition");

fn study(grid: [usize; 3]) -> SuperpositionStudy {
    let overrides = Overrides { grid: Some(grid), ..Overrides::default() };
    match Study::open(Path::new(FOLDER), &overrides).unwrap_or_else(|e| panic!("{e}")).kind {
        StudyKind::Superposition(study, _) => *study,
        other => panic!("not a superposition study: {other:?}"),
    }
}

/// The study with both sources multiplied.
fn scaled(study: &SuperpositionStudy, load: f64, errors: f64) -> SuperpositionStudy {
    let MillingForce { radial, tangential, axial, law } = study.load_case.force;
    let mut scaled = study.clone();
    scaled.load_case.force =
        MillingForce { radial: radial * load, tangential: tangential * load, axial: axial * load, law };
    scaled.load_case.errors = study.load_case.errors.iter().map(|error| error.scale(errors)).collect();
    scaled
}

fn solve(study: &SuperpositionStudy) -> Superposition {
    run(study, &Work::default()).unwrap()
}

fn summary(results: &Superposition) -> report::Summary<'_> {
    let mut summary = report::Summary::new(&results.study);
    results.points.iter().for_each(|point| summary.add(point));
    summary
}

fn tool_superposition_error(location: &LocationResult) -> f64 {
    location.superposition_errors.as_ref().unwrap().superposed_tool_mm()
}

/// Every superposition error of a sum on the map and at the locations, mm.
fn superposition_errors(results: &Superposition, sum: Sum) -> Vec<f64> {
    let map = results.points.iter().map(|point| &point.superposition_errors);
    let all = map.chain(results.locations.iter().map(|location| &location.superposition_errors));
    let sizes = |superposition_errors: &Result<_, _>| {
        let superposition_errors: &kinetostat::questions::superposition::superposition_error::SuperpositionErrors =
            superposition_errors.as_ref().unwrap();
        Followed::ALL.map(|followed| superposition_errors.worst(sum, followed).unwrap().superposition_error_mm)
    };
    all.flat_map(sizes).collect()
}

#[test]
fn superposition_error_grows_with_each_source_and_with_the_square_of_both() {
    for location in solve(&study([1, 1, 1])).locations {
        for (scaled, power) in [(Scaling::Load, 1.0), (Scaling::Errors, 1.0), (Scaling::Both, 2.0)] {
            for followed in Followed::ALL {
                let fit = location.growth[scaled as usize].fit(Sum::Superposition, followed).unwrap();
                let place = format!("{} {} {}", location.location.name, scaled.label(), followed.label());
                assert!((fit.slope - power).abs() < 0.05 && fit.is_power_law() && fit.points == 7, "{place}: {fit:?}");
            }
        }
        let aggregated = location.growth[Scaling::Both as usize].fit(Sum::Aggregation, Followed::Tool).unwrap();
        assert!((aggregated.slope - 2.0).abs() < 0.05, "{}: {aggregated:?}", location.location.name);
    }
}

#[test]
fn superposition_error_is_zero_where_a_source_is_absent() {
    let whole = study([2, 2, 2]);
    let without_errors = solve(&scaled(&whole, 1.0, 0.0));
    let without_load = solve(&scaled(&whole, 0.0, 1.0));
    for results in [&without_errors, &without_load] {
        assert!(
            superposition_errors(results, Sum::Superposition)
                .iter()
                .all(|superposition_error| *superposition_error < 1e-9)
        );
        for largest in results.points.iter().map(|point| &point.largest_load) {
            assert_eq!(largest, &LargestFactor::BelowToLimit(16.0));
        }
        assert_eq!(summary(results).safe_share(), Some(1.0));
    }
    assert!(
        superposition_errors(&without_errors, Sum::Aggregation)
            .iter()
            .all(|superposition_error| *superposition_error < 1e-9)
    );
    // What aggregation leaves out of the chain errors alone stays without load.
    assert!(
        superposition_errors(&without_load, Sum::Aggregation)
            .iter()
            .any(|superposition_error| *superposition_error > 1e-3)
    );
    let growth = &without_errors.locations[1].growth[Scaling::Load as usize];
    assert_eq!(growth.fit(Sum::Superposition, Followed::Tool), None);
}

/// The Orthoglide is the same from each of its three rails; so must be the maps when load and errors are, too.
#[test]
fn maps_have_the_symmetry_of_the_machine() {
    let mut machine = catalogue_machine("orthoglide");
    machine.tool_tip = Vector3::zeros();
    let whole = study([1, 1, 1]);
    let box_ = machine.workspace;
    let load_case = LoadCase {
        // At φ = 0 the law as printed gives the force (radial, tangential, axial).
        force: MillingForce { radial: 120.0, tangential: 120.0, axial: 120.0, law: ForceLaw::PaperEq17 },
        phis: vec![0.0],
        errors: machine.assembly_errors(&[1.0; 3]),
        machine,
        ..whole.load_case.clone()
    };
    let grid = Grid::new(box_.min, box_.max, [3; 3]);
    let symmetric = SuperpositionStudy { load_case, grid, locations: Vec::new(), ..whole };
    let results = solve(&symmetric);
    let turn = Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let at = |position: Vector3<f64>| {
        let near = |p: &&kinetostat::questions::superposition::GridPoint| {
            (Vector3::from(p.position_mm) - position).norm() < 1e-9
        };
        results.points.iter().find(near).unwrap()
    };
    for point in &results.points {
        let turned = at(turn * Vector3::from(point.position_mm));
        let (here, there) =
            (point.superposition_errors.as_ref().unwrap(), turned.superposition_errors.as_ref().unwrap());
        for sum in Sum::ALL {
            let vector = |d: &kinetostat::questions::superposition::superposition_error::SuperpositionErrors| {
                Vector3::from(d.worst(sum, Followed::Platform).unwrap().superposition_error_vector_mm)
            };
            let gap = (turn * vector(here) - vector(there)).norm();
            assert!(gap < 1e-9, "{} at {:?}: {gap:e}", sum.label(), point.position_mm);
        }
        let [a, b] = [point, turned].map(|point| point.largest_load.factor().unwrap());
        assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
    }
    let largest = superposition_errors(&results, Sum::Superposition).into_iter().fold(0.0, f64::max);
    assert!(largest > 1e-3, "nothing to compare: {largest}");
}

#[test]
fn parts_of_the_superposition_error_add_up_to_it() {
    let mut tripteron = study([1, 1, 1]);
    tripteron.load_case.machine = catalogue_machine("tripteron");
    tripteron.load_case.errors = [0.3, 0.2, -0.4].map(assembly_error).to_vec();
    tripteron.locations.truncate(1);
    tripteron.locations[0].position = Vector3::new(400.0, 650.0, 550.0);
    for study in [study([1, 1, 1]), tripteron] {
        for location in solve(&study).locations {
            let angles = location.ablation.unwrap_or_else(|e| panic!("{}: {e:?}", location.location.name));
            assert_eq!(angles.len(), 36);
            for angle in angles {
                for followed in Followed::ALL {
                    let sum: Vector3<f64> = angle.parts.iter().map(|part| part.of(followed)).sum();
                    let gap = (sum - angle.superposition_error.of(followed)).norm();
                    assert!(gap < 1e-13, "{} {:.0}°: {gap:e}", location.location.name, angle.phi_deg);
                }
            }
        }
    }
}

/// Displacement of the tool tip by the load at the scale `load` and the errors at the scale `errors`.
fn moved(study: &SuperpositionStudy, position: Vector3<f64>, phi: f64, load: f64, errors: f64) -> Vector3<f64> {
    let (pose, _) = pose_under(study, position, phi, load, errors);
    study.load_case.machine.tool_displacement(&study.load_case.machine.pose_at(position), &pose)
}

fn pose_under(study: &SuperpositionStudy, position: Vector3<f64>, phi: f64, load: f64, errors: f64) -> (Pose, Wrench) {
    let errors: Vec<ChainError> = study.load_case.errors.iter().map(|error| error.scale(errors)).collect();
    let at = at_position(&study.load_case.machine, position);
    let wrench = study.load_case.force.wrench(phi, &study.load_case.machine.tool());
    (settle(&study.load_case.machine.with_errors(&errors), &at, &wrench.scale(load)).0.pose, wrench)
}

/// Tool displacement per force on the nominal machine, unloaded, P at `position`.
fn unloaded_response(machine: &Machine, position: Vector3<f64>, force: Vector3<f64>) -> Vector3<f64> {
    let at = at_position(machine, position);
    let stiffness = unloaded_stiffness(machine, &at, &mut Scratch::new(machine)).unwrap();
    tool_compliance(&stiffness.try_inverse().unwrap(), machine.tool_tip) * force
}

#[test]
fn small_superposition_errors_are_the_mixed_derivative_and_its_causes_are_its_parts() {
    let small = 0.01;
    let whole = study([1, 1, 1]);
    let results = solve(&scaled(&whole, small, small));
    for location in results.locations {
        let position = location.location.position;
        for angle in location.ablation.unwrap().into_iter().step_by(5) {
            let phi = angle.phi_deg.to_radians();
            let u = |load: f64, errors: f64| moved(&whole, position, phi, load, errors);
            let h = 0.03;
            let mixed = (u(h, h) - u(h, -h) - u(-h, h) + u(-h, -h)) / (4.0 * h * h);
            let expected = -mixed * small * small;
            let scale = expected.norm().max(1e-8);
            let gap = (angle.superposition_error.tool - expected).norm();
            assert!(gap < 0.02 * scale, "{} {:.0}°: {gap:e} of {scale:e}", location.location.name, angle.phi_deg);
            let first: Vector3<f64> = angle.parts[..3].iter().map(|part| part.tool).sum();
            assert!((first - expected).norm() < 0.02 * scale, "{} {:.0}°", location.location.name, angle.phi_deg);
            let rest = angle.parts[3].tool.norm() + angle.parts[4].tool.norm();
            assert!(rest < 0.02 * scale, "{rest:e} is not of higher order");
        }
    }
}

#[test]
fn the_shift_of_the_point_is_what_the_unloaded_stiffness_elsewhere_says() {
    let whole = study([1, 1, 1]);
    for location in solve(&whole).locations {
        let position = location.location.position;
        for angle in location.ablation.unwrap().into_iter().step_by(7) {
            let phi = angle.phi_deg.to_radians();
            let (shifted, _) = pose_under(&whole, position, phi, 0.0, 1.0);
            let force = whole.load_case.force.force(phi);
            let response = |position| unloaded_response(&whole.load_case.machine, position, force);
            let expected = response(position) - response(shifted.translation);
            let found = angle.parts[Cause::Point as usize].tool;
            assert!((found - expected).norm() < 1e-9, "{}: {found:?} {expected:?}", location.location.name);
        }
    }
}

#[test]
fn at_the_largest_factor_the_superposition_error_is_the_tolerance() {
    let mut whole = study([1, 1, 1]);
    whole.tolerance = 0.012;
    let found = solve(&whole);
    for (index, location) in found.locations.iter().enumerate() {
        for kind in Scaling::ALL {
            let LargestFactor::Reached(factor) = location.largest[kind as usize] else {
                panic!("{:?}", location.largest);
            };
            let (load, errors) = kind.load_and_error_factors(factor);
            let there = tool_superposition_error(&solve(&scaled(&whole, load, errors)).locations[index]);
            assert!(
                (there / whole.tolerance - 1.0).abs() < 1e-5,
                "{} {}: {there}",
                location.location.name,
                kind.label()
            );
        }
    }
}

#[test]
fn a_tolerance_never_reached_ends_at_the_limit_or_with_the_equilibrium() {
    let mut whole = study([1, 1, 1]);
    whole.locations.truncate(2);
    (whole.tolerance, whole.largest_factor) = (0.2, 5.0);
    assert_eq!(solve(&whole).locations[0].largest[0], LargestFactor::BelowToLimit(5.0));
    (whole.tolerance, whole.largest_factor) = (1e9, 1e4);
    whole.locations.remove(0);
    let results = solve(&whole);
    let LargestFactor::NoEquilibrium(factor, failure) = &results.locations[0].largest[0] else {
        panic!("{:?}", results.locations[0].largest[0]);
    };
    assert!(["not_converged", "snap_through", "unstable", "buckled"].contains(&&*failure.status), "{failure:?}");
    whole.largest_factor = 1.0;
    assert!(solve(&scaled(&whole, 0.999 * factor, 1.0)).locations[0].superposition_errors.is_ok());
    assert!(solve(&scaled(&whole, 1.001 * factor, 1.0)).locations[0].superposition_errors.is_err());
}

#[test]
fn places_out_of_reach_are_labelled_everywhere() {
    let mut whole = study([1, 1, 1]);
    whole.locations[0].position = Vector3::new(900.0, 0.0, 0.0);
    let axis = vec![0.0, 900.0];
    whole.grid = Grid { axes: [axis.clone(), vec![0.0], vec![0.0]] };
    let results = solve(&whole);
    assert!(results.points[0].superposition_errors.is_ok());
    let failure = results.points[1].superposition_errors.as_ref().unwrap_err();
    assert_eq!(failure.status, "unreachable");
    assert_eq!(results.points[1].largest_load, LargestFactor::Unsolved(failure.clone()));
    let lost = &results.locations[0];
    assert!(lost.ablation.is_err() && lost.superposition_errors.is_err());
    assert!(lost.growth.iter().flat_map(|growth| &growth.steps).all(|(_, found)| found.is_err()));
    for table in [
        report::map_table(&results.points),
        report::locations_table(&results.locations),
        report::scaling_table(&results.locations),
        report::ablation_table(&results.locations),
        report::safe_load_table(&results.study, &results.points),
        report::largest_factors_table(&results.locations),
    ] {
        let text = String::from_utf8(csv(&table).unwrap()).unwrap();
        assert!(text.contains("unreachable") && !text.contains("NaN") && !text.contains("inf,"), "{text}");
    }
    let (study, locations, summary) = (&results.study, &results.locations, summary(&results));
    assert!(report::summary_text(&summary, locations).contains("Q0: unreachable: "));
    assert_eq!(summary.json(locations)["grid_points_solved"], 1);
    let folder = tempfile::tempdir().unwrap();
    let run =
        Run { out: folder.path(), formats: &[], rows: WrittenRows::default(), figures: true, work: &Work::default() };
    for (name, figure) in study.answer(&Shown { slices_z: vec![0.0], not_used: Vec::new() }, &run).unwrap().figures {
        figure.svg(Colours::Viridis).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let whole = study([3, 2, 2]);
    let tables = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let results = pool.install(|| solve(&whole));
        [
            report::map_table(&results.points),
            report::safe_load_table(&results.study, &results.points),
            report::ablation_table(&results.locations),
        ]
    };
    assert!(tables(1) == tables(3));
}

#[test]
fn a_power_law_is_found() {
    let pairs: Vec<(f64, f64)> = [0.1, 0.4, 1.0, 3.0].into_iter().map(|x: f64| (x, 0.02 * x.powf(1.7))).collect();
    let found = growth::fit(&pairs).unwrap();
    assert!((found.slope - 1.7).abs() < 1e-12 && (found.coefficient_mm - 0.02).abs() < 1e-14, "{found:?}");
    assert!((found.worst_ratio - 1.0).abs() < 1e-12 && found.points == 4 && found.is_power_law());
}

#[test]
fn a_point_off_the_line_is_noticed_and_one_point_is_no_line() {
    let found = growth::fit(&[(1.0, 1.0), (2.0, 2.0), (4.0, 8.0)]).unwrap();
    assert!((found.slope - 1.5).abs() < 1e-12 && !found.is_power_law(), "{found:?}");
    assert_eq!(growth::fit(&[(1.0, 1.0)]), None);
}
