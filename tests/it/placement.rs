//! Placement studies: the search against brute force, symmetry, reasons, threads.

use std::{
    f64::consts::{PI, TAU},
    path::Path,
    sync::{Arc, Mutex},
};

use kinetostat::{
    machine::catalogue,
    questions::placement::{
        Bounds, Cell, Evaluator, Metric, Origin, PlaceOutcome, PlacementResults, PlacementStudy, Site, SiteGrid,
        compare,
        report::{candidates_table, cautions_text, sweep_table},
        run,
    },
    work::{Event, Work},
};
use nalgebra::Vector3;

use crate::support::{cases::cases, placement::searched};

fn study_in(folder: &Path, toml: &str) -> PlacementStudy {
    crate::support::placement::study_in(folder, toml).unwrap_or_else(|e| panic!("{e}"))
}

/// A 50 mm groove on the Orthoglide, its centre anywhere in the plane z = 0.
const GROOVE: &str = r#"
schema = 3
question = "where?"
machine = "orthoglide"
[placement]
clearance_mm = 0.0
[[placement.feature]]
name = "groove"
process = "process.toml"
circle = { centre_mm = [0.0, 0.0, 0.0], diameter_mm = 50.0, points = 33 }
tolerance_mm = 0.6
[placement.bounds]
x_mm = [-48.65, 101.35]
y_mm = [-48.65, 101.35]
[placement.fixed]
z_mm = 0.0
[placement.allowance]
position_mm = 0.0
angle_deg = 0.0
[placement.objective]
weights = { worst_deflection = 1.0 }
[placement.search]
grid = { x = 5, y = 5 }
starts = 2
tolerance = 1e-5
"#;

fn groove_folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/studies/03_placement_circle"))
}

fn groove(changes: &[(&str, &str)]) -> PlacementStudy {
    let mut toml = GROOVE.to_string();
    for (old, new) in changes {
        assert!(toml.contains(old), "{old}");
        toml = toml.replace(old, new);
    }
    study_in(groove_folder(), &toml)
}

#[test]
fn the_best_place_is_said_to_be_that_of_an_assumed_workspace_box() {
    assert!(!cautions_text(&groove(&[])).contains("assumed"));
    let folder = tempfile::tempdir().unwrap();
    let machine = catalogue::find("orthoglide").unwrap().toml.replace("grade = \"published\"", "grade = \"assumed\"");
    let line = 1 + machine.lines().position(|line| line == "[workspace]").unwrap();
    std::fs::write(folder.path().join("machine.toml"), machine).unwrap();
    std::fs::copy(groove_folder().join("process.toml"), folder.path().join("process.toml")).unwrap();
    let study = study_in(folder.path(), &GROOVE.replace("machine = \"orthoglide\"", "machine = \"machine.toml\""));
    let said = format!(
        "The workspace box of orthoglide is assumed, line {line} of its file: places at which P would leave it do not count, and the best \
         place is that of the box given.\n"
    );
    assert!(cautions_text(&study).contains(&said), "{}", cautions_text(&study));
}

/// The least worst deflection on a grid of 21 × 21 places, and where it is.
fn brute_force(study: &PlacementStudy, low: [f64; 2], high: [f64; 2]) -> (f64, Site) {
    let evaluator = Evaluator::new(study, &[Metric::WorstDeflection]);
    let bounds = Bounds { low: [low[0], low[1], 0.0, 0.0, 0.0, 0.0], high: [high[0], high[1], 0.0, 0.0, 0.0, 0.0] };
    let grid = SiteGrid::new(&bounds, [21, 21, 1, 1, 1, 1]);
    let value = |site: &Site| evaluator.evaluate(site).unwrap().metrics.get(Metric::WorstDeflection).unwrap();
    let values = (0..grid.len()).map(|index| (value(&grid.site(index)), grid.site(index)));
    values.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

#[test]
fn the_search_finds_what_brute_force_finds() {
    let study = groove(&[]);
    let best = searched(&study).best.unwrap();
    let coarse = brute_force(&study, [-48.65; 2], [101.35; 2]);
    // A finer grid around the best places of the coarse one, which are 7.5 mm apart.
    let [x, y, ..] = coarse.1.0;
    let fine = brute_force(&study, [x - 7.5, (y - 10.0).max(-48.65)], [x + 10.0, y + 10.0]);
    assert!(best.value <= fine.0, "{best:?}, brute force {fine:?}");
    assert!(best.value >= 0.995 * fine.0, "{best:?}, brute force {fine:?}");
    assert!((best.site.position_mm() - fine.1.position_mm()).amax() < 1.5, "{best:?}, brute force {fine:?}");
    assert!(matches!(best.found, Origin::Refinement(_)));
}

#[test]
fn an_optimum_at_a_bound_is_found_there() {
    // Between these bounds the deflection grows with x and y.
    let study = groove(&[("x_mm = [-48.65, 101.35]\ny_mm = [-48.65", "x_mm = [40.0, 90.0]\ny_mm = [40.0")]);
    let best = searched(&study).best.unwrap();
    let [x, y, ..] = best.site.0;
    assert!((40.0..40.001).contains(&x) && (40.0..40.001).contains(&y), "{best:?}");
}

#[test]
fn giving_places_up_changes_no_winner_no_start_and_no_front() {
    let thorough = cases(1).cases > 1;
    for (weights, pareto) in [
        ("worst_deflection = 1.0", "[]"),
        ("rms_deflection = 1.0, worst_drive_force = 0.002", "[]"),
        ("worst_deflection = 1.0", "[\"rms_deflection\", \"worst_drive_force\"]"),
        ("share_within_tolerance = 1.0, worst_correction = 0.5", "[\"stability_margin\", \"superposition_error\"]"),
    ] {
        let objective = format!("weights = {{ {weights} }}\npareto = {pareto}");
        let objective = ("weights = { worst_deflection = 1.0 }", &*objective);
        let fewer = [objective, ("points = 33", "points = 25"), ("x = 5, y = 5", "x = 4, y = 4")];
        let mut study = groove(if thorough { &fewer[..1] } else { &fewer });
        study.search.max_iterations = if thorough { 10 } else { 4 };
        let pruned = searched(&study);
        study.search.coarse_to_fine = false;
        let full = searched(&study);
        assert!(full.cells.iter().all(|cell| cell.complete().is_some()));
        let stopped = pruned.cells.iter().filter(|cell| matches!(cell.verdict, PlaceOutcome::Pruned(_))).count();
        assert!(stopped > 0 || weights.contains("share"), "{weights}: nothing is pruned");
        assert_eq!(pruned.best, full.best, "{weights}");
        assert_eq!(pruned.refinements, full.refinements, "{weights}");
        assert_eq!(pruned.front, full.front, "{weights} {pareto}");
        let starts = |results: &PlacementResults| results.ranking[..study.search.starts].to_vec();
        assert_eq!(starts(&pruned), starts(&full), "{weights}");
        bounds_hold(&study, &pruned.cells, &full.cells);
    }
}

/// What is known of a place given up is no worse than the truth.
fn bounds_hold(study: &PlacementStudy, pruned: &[Cell], full: &[Cell]) {
    for (pruned, full) in pruned.iter().zip(full) {
        let (known, truth) = (pruned.metrics().unwrap(), full.metrics().unwrap());
        for metric in study.objective.metrics() {
            let (known, truth) = (known.get(metric).unwrap(), truth.get(metric).unwrap());
            assert!(metric.cost(known) <= metric.cost(truth), "{metric:?}: {known} {truth}");
        }
    }
}

#[test]
fn a_path_wholly_out_of_tolerance_has_no_share_within_and_one_wholly_within_has_all() {
    let feature = |name: &str, diameter: f64, points: usize, tolerance: f64| {
        format!(
            "[[placement.feature]]\nname = \"{name}\"\nprocess = \"process.toml\"\ntolerance_mm = {tolerance:?}\n\
             circle = {{ centre_mm = [0.0, 0.0, 0.0], diameter_mm = {diameter:?}, points = {points} }}\n"
        )
    };
    let (_, rest) = GROOVE.split_once("tolerance_mm = 0.6\n").unwrap();
    let rest = rest.replace("x = 5, y = 5", "x = 2, y = 2").replace("starts = 2", "starts = 1\nmax_iterations = 3");
    for points in [35, 50] {
        for (tolerance, expected) in [(1e-12, 0.0), (1e3, 1.0)] {
            let features = feature("one", 50.0, points, tolerance) + &feature("two", 31.7, points + 3, tolerance);
            let head = "schema = 3\nquestion = \"where?\"\nmachine = \"orthoglide\"\n";
            let study = study_in(groove_folder(), &format!("{head}{features}{rest}"));
            let results = searched(&study);
            for cell in &results.cells {
                let (PlaceOutcome::Complete(metrics) | PlaceOutcome::Pruned(metrics)) = &cell.verdict else { continue };
                // Bounds of places given up count what was not looked at as within.
                let is_complete = matches!(cell.verdict, PlaceOutcome::Complete(_));
                let share = metrics.get(Metric::ShareWithin).unwrap();
                assert!(share == expected || !is_complete && share > expected, "{points}: {share}");
            }
            for entry in &results.entries {
                let evaluation = entry.outcome.as_ref().unwrap();
                for metrics in evaluation.features.iter().chain([&evaluation.metrics]) {
                    assert_eq!(metrics.get(Metric::ShareWithin).unwrap(), expected, "{points} points, {}", entry.name);
                }
            }
        }
    }
}

#[test]
fn every_stage_of_a_search_counts_to_its_end() {
    let events = Arc::new(Mutex::new(Vec::new()));
    let watch = Arc::clone(&events);
    let work = Work::new(None, Arc::default(), Box::new(move |event| watch.lock().unwrap().push(event)));
    let study = groove(&[("grid = { x = 5, y = 5 }", "grid = { x = 3, y = 3 }")]);
    run(&study, &work).unwrap();
    let (mut stages, mut done) = (vec![("places", study.grid.len())], vec![0]);
    for event in events.lock().unwrap().iter() {
        match event {
            Event::Stage(stage) => {
                stages.push((stage.of, stage.items));
                done.push(0);
            }
            Event::Computed(items) => *done.last_mut().unwrap() += items,
            _ => {}
        }
    }
    assert_eq!(stages.iter().map(|(_, items)| *items).collect::<Vec<_>>(), done, "{stages:?}");
    assert!(stages.iter().any(|(of, _)| *of == "searches") && stages.len() >= 3, "{stages:?}");
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let study = groove(&[("starts = 2", "starts = 3\nmax_iterations = 12")]);
    let tables = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let results = pool.install(|| searched(&study));
        (sweep_table(&results), candidates_table(&study, &results.entries), results.flatness)
    };
    assert!(tables(1) == tables(4));
}

/// Names of these candidates for the groove, and why it cannot be cut there; best first.
fn reasons(candidates: &str, rest: &str) -> Vec<(String, Option<(String, String)>)> {
    let toml = format!("{}\n{rest}\n{candidates}", GROOVE);
    let entries = compare(&study_in(groove_folder(), &toml));
    let failure = |outcome: &Result<_, kinetostat::simulation::Failure>| {
        outcome.as_ref().err().map(|f| (f.status.to_string(), f.reason.clone()))
    };
    entries.iter().map(|entry| (entry.name.clone(), failure(&entry.outcome))).collect()
}

fn candidate(name: &str, [x, y, z]: [f64; 3]) -> String {
    format!("[[placement.candidate]]\nname = \"{name}\"\norigin_mm = [{x:?}, {y:?}, {z:?}]\n")
}

#[test]
fn a_place_just_out_of_reach_is_refused_for_the_chain_that_ends_there() {
    let study = groove(&[]);
    let machine = &study.machine;
    let reaches = |z: f64| {
        let place = |point: &kinetostat::toolpath::PathPoint| point.position_mm + Vector3::new(0.0, 0.0, z);
        let path = study.features[0].feature.path.points();
        path.iter().map(place).all(|at| machine.inverse_kinematics(&machine.pose_at(at)).is_ok())
    };
    let (mut inside, mut outside) = (100.0, 600.0);
    assert!(reaches(inside) && !reaches(outside));
    while outside - inside > 1e-3 {
        let middle = 0.5 * (inside + outside);
        if reaches(middle) { inside = middle } else { outside = middle }
    }
    let found =
        reasons(&(candidate("inside", [0.0, 0.0, inside - 0.01]) + &candidate("outside", [0.0, 0.0, outside])), "");
    let (name, failure) = &found[1];
    let (status, reason) = failure.as_ref().unwrap();
    assert_eq!((name.as_str(), status.as_str()), ("outside", "unreachable"));
    assert!(reason.starts_with("feature groove, point "), "{reason}");
    assert!(reason.contains("cannot close there; the straight way") || reason.contains("singularity"), "{reason}");
    // The place inside is in reach; whether the loaded machine stands so near the end of its reach is another matter.
    assert!(found[0].1.as_ref().is_none_or(|(status, _)| status != "unreachable"), "{found:?}");
}

#[test]
fn a_forbidden_box_is_named() {
    let clamp = "[[placement.forbidden]]\nname = \"clamp\"\nmin_mm = [24.0, -5.0, -5.0]\nmax_mm = [30.0, 5.0, 5.0]";
    let found = reasons(&(candidate("touching", [-1.0, 0.0, 0.0]) + &candidate("over it", [0.0, 0.0, 0.0])), clamp);
    assert_eq!(found[0], ("touching".to_string(), None));
    let reason = "the workpiece would stand in the forbidden box \"clamp\"";
    assert_eq!(found[1], ("over it".to_string(), Some(("forbidden".to_string(), reason.to_string()))));
}

#[test]
fn a_drive_force_beyond_its_limit_is_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let process = std::fs::read_to_string(groove_folder().join("process.toml")).unwrap();
    let limits = "\n[limits]\nforce_limit_N = 230.0\n";
    let split = process.find("# Assembling").unwrap();
    let limited = format!("{}{limits}\n{}", &process[..split], &process[split..]);
    std::fs::write(folder.path().join("process.toml"), limited).unwrap();
    let toml = GROOVE.to_string() + &candidate("Q0", [0.0; 3]) + &candidate("corner", [101.0; 3]);
    let entries = compare(&study_in(folder.path(), &toml));
    let metrics = entries[0].outcome.as_ref().unwrap().metrics;
    let (force, margin) = (metrics.get(Metric::WorstDriveForce).unwrap(), metrics.get(Metric::ForceMargin).unwrap());
    assert!((margin - (230.0 - force) / 230.0).abs() < 1e-12);
    let failure = entries[1].outcome.as_ref().unwrap_err();
    assert_eq!((entries[1].name.as_str(), &*failure.status), ("corner", "force_limit"));
    assert!(failure.reason.contains("its limit is 230.0 N"), "{}", failure.reason);
}

/// The Orthoglide without a tool looks the same along x, y and z; so does this triangle with these forces.
#[test]
fn what_is_symmetric_is_ranked_so() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let catalogue = kinetostat::machine::catalogue::find("orthoglide").unwrap().toml;
    write("machine.toml", &catalogue.replace("tool_tip_mm = [0.0, 0.0, 100.0]", "tool_tip_mm = [0.0, 0.0, 0.0]"));
    write("process.toml", "schema = 1\n[force]\nfrom_path = true\n");
    write(
        "triangle.csv",
        "x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N\n20,0,-5,200,30,0\n-5,20,0,0,200,30\n0,-5,20,30,0,200\n\
         20,0,-5,200,30,0\n",
    );
    let toml = GROOVE
        .replace("machine = \"orthoglide\"", "machine = \"machine.toml\"")
        .replace("circle = { centre_mm = [0.0, 0.0, 0.0], diameter_mm = 50.0, points = 33 }", "file = \"triangle.csv\"")
        .replace(
            "x_mm = [-48.65, 101.35]\ny_mm = [-48.65, 101.35]\n",
            "x_mm = [-40.0, 80.0]\ny_mm = [-40.0, 80.0]\nz_mm = [-40.0, 80.0]\n",
        )
        .replace("[placement.fixed]\nz_mm = 0.0\n", "")
        .replace("x = 5, y = 5", "x = 3, y = 3, z = 3");
    let mut study = study_in(folder.path(), &toml);
    study.search.coarse_to_fine = false;
    study.search.max_iterations = 2;
    let results = searched(&study);
    let grid = &study.grid;
    let value =
        |[x, y, z]: [usize; 3]| study.objective.value(results.cells[grid.index([x, y, z, 0, 0, 0])].metrics().unwrap());
    for (x, y, z) in (0..27).map(|k| (k % 3, k / 3 % 3, k / 9)) {
        let (a, b) = (value([x, y, z]), value([z, x, y]));
        assert!((a - b).abs() < 1e-9 * a, "{x} {y} {z}: {a} {b}");
    }
    // Ranked by value: places that are images of one another stand together.
    let values: Vec<f64> =
        results.ranking.iter().map(|&index| study.objective.value(results.cells[index].metrics().unwrap())).collect();
    assert!(values.windows(2).all(|pair| pair[0] <= pair[1]));
}

#[test]
fn a_full_circle_may_be_turned() {
    let rotated = groove(&[]);
    let evaluator = Evaluator::new(&rotated, &[Metric::WorstDeflection]);
    let at = |yaw: f64| {
        let site = Site::new(Vector3::new(10.0, 20.0, 0.0), yaw);
        evaluator.evaluate(&site).unwrap().metrics.get(Metric::RmsDeflection).unwrap()
    };
    // The printed force law is no rotation, but half a turn of it is half a turn.
    assert!((at(0.0) - at(std::f64::consts::PI)).abs() < 1e-9);
}

fn turned(yaw: f64) -> Site {
    Site::new(Vector3::zeros(), yaw)
}

fn yaw_from(low: f64, high: f64) -> Bounds {
    let (mut bounds_low, mut bounds_high) = ([0.0; 6], [0.0; 6]);
    (bounds_low[3], bounds_high[3]) = (low, high);
    Bounds { low: bounds_low, high: bounds_high }
}

#[test]
fn the_ends_of_a_full_turn_are_one_place() {
    let bounds = yaw_from(-PI, PI);
    let degrees: Vec<f64> = bounds.values(3, 4).iter().map(|v| v.to_degrees().round()).collect();
    assert_eq!(degrees, [-180.0, -90.0, 0.0, 90.0]);
    assert!(bounds.distance(3, -PI, PI) < 1e-12);
    assert!((bounds.distance(3, -3.0, 3.0) - (TAU - 6.0)).abs() < 1e-12);
    let past = bounds.moved(&turned(3.0), 3, 0.5).0[3];
    assert!((past - (3.5 - TAU)).abs() < 1e-12, "{past}");
    // Half a turn ends at its bounds.
    let half = yaw_from(0.0, PI);
    assert_eq!(half.moved(&turned(3.0), 3, 0.5).0[3], PI);
    assert_eq!(half.values(3, 3).len(), 3);
    assert_eq!(half.distance(3, 0.0, PI), PI);
}

#[test]
fn an_angle_is_within_bounds_whatever_its_turns() {
    let bounds = yaw_from(0.5 * PI, PI);
    for yaw in [0.75 * PI, -1.25 * PI, 2.75 * PI] {
        assert!((bounds.inside(&turned(yaw)).unwrap().0[3] - 0.75 * PI).abs() < 1e-12);
    }
    assert!(bounds.inside(&turned(0.0)).is_none());
    assert!(bounds.inside(&Site::new(Vector3::new(1.0, 0.0, 0.0), 2.0)).is_none());
    assert!(yaw_from(0.0, 0.0).inside(&turned(0.0)).is_some());
}
