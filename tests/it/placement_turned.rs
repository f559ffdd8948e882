//! Placements judged by the parts of the deflection that make the workpiece wrong, and at the best turn about the tool's axis.

use std::path::Path;

use kinetostat::study::{
    Overrides, Study, StudyKind,
    placement::{Metric, PlacementResults, PlacementStudy, run},
};
use kinetostat::work::Work;

const ROWS: &str = "x_mm,y_mm,z_mm,axis_x,axis_y,axis_z\n0,0,0,0.5,0,0.866\n20,0,-11.54,0.5,0,0.866\n20,30,-11.54,0.5,0,0.866\n0,30,0,0.5,0,0.866\n";

fn study(turn: &str, objective: &str, search: &str) -> Result<PlacementStudy, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("path.csv"), ROWS).unwrap();
    let text = format!(
        "schema = 2\nquestion = \"?\"\nmachine = \"fanuc_r2000ic\"\n[process]\ntolerance_mm = 0.5\n[process.sampling]\nmax_segment_mm = 10.0\n\
         [process.force.path_frame]\nradial_force_N = 180.0\ntangential_force_N = -300.0\naxial_force_N = -120.0\n\
         [process.tool_turn]\nredundancy = \"{turn}\"\nstep_deg = 30.0\n\
         [[placement.feature]]\nname = \"pocket\"\nfile = \"path.csv\"\n[placement.bounds]\nx_mm = [1950.0, 2250.0]\ny_mm = [-200.0, 200.0]\n\
         [placement.fixed]\nz_mm = 550.0\n[placement.objective]\nweights = {{ {objective} = 1.0 }}\n[placement.search]\ngrid = {{ x = 2, y = 3 }}\n\
         starts = 1\nmax_iterations = 6\n{search}\n"
    );
    let study =
        Study::from_toml(&text, "study.toml", folder.path(), &Overrides::default()).map_err(|e| e.to_string())?;
    let StudyKind::Placement(study, _) = study.kind else { panic!("a placement") };
    Ok(*study)
}

fn results(turn: &str, objective: &str, search: &str) -> PlacementResults {
    run(&study(turn, objective, search).unwrap(), &Work::default()).unwrap()
}

fn values(results: &PlacementResults, metric: Metric) -> Vec<Option<f64>> {
    results.cells.iter().map(|cell| cell.complete().and_then(|metrics| metrics.get(metric))).collect()
}

#[test]
fn parts_of_the_deflection_are_no_more_than_all_of_it() {
    let results = results("as_programmed", "worst_across_surface", "coarse_to_fine = false");
    let [all, path, wall] = [Metric::WorstDeflection, Metric::WorstAcrossPath, Metric::WorstAcrossSurface]
        .map(|metric| values(&results, metric));
    assert!(all.iter().filter(|value| value.is_some()).count() >= 3, "{all:?}");
    for ((all, path), wall) in all.iter().zip(&path).zip(&wall) {
        assert!(wall <= path && path <= all, "{all:?} {path:?} {wall:?}");
        assert!(wall.is_none() || wall.unwrap() > 0.01);
    }
    // Another objective has no such numbers.
    let without = self::results("as_programmed", "worst_deflection", "coarse_to_fine = false");
    assert!(values(&without, Metric::WorstAcrossPath).iter().all(Option::is_none));
    assert_eq!(values(&without, Metric::WorstDeflection), all);
}

#[test]
fn each_place_is_judged_at_its_own_best_turn() {
    let turned = results("best_constant", "rms_deflection", "coarse_to_fine = false");
    let plain = results("as_programmed", "rms_deflection", "coarse_to_fine = false");
    let [there, here] = [&turned, &plain].map(|results| values(results, Metric::RmsDeflection));
    let mut better = 0;
    for (k, (turned_rms, plain_rms)) in there.iter().zip(&here).enumerate() {
        let Some(turned_rms) = turned_rms else { continue };
        let site = turned.cells[k].site;
        let turn = turned.study.features[0].turn_at(&site).unwrap().unwrap();
        assert!((turn.to_degrees() / 30.0 - (turn.to_degrees() / 30.0).round()).abs() < 1e-9);
        // All points of so short a path are tried, so what is found is no worse than as programmed.
        if let Some(plain_rms) = plain_rms {
            assert!(turned_rms <= &(plain_rms * (1.0 + 1e-6)), "{turned_rms} {plain_rms}");
            better += usize::from(*turned_rms < 0.99 * plain_rms);
        }
    }
    assert!(better > 0, "{there:?} {here:?}");
    let refused = study("best", "rms_deflection", "").unwrap_err();
    assert!(
        refused.contains("tool_turn.redundancy: is best: a place is judged at one turn for each feature"),
        "{refused}"
    );
}

#[test]
fn coarse_to_fine_is_exact_with_turns_and_parts() {
    for objective in ["worst_across_path", "rms_across_surface"] {
        let [exact, fast] = ["coarse_to_fine = false", "coarse_to_fine = true"]
            .map(|search| results("best_constant", objective, search));
        let best = |results: &PlacementResults| {
            let first = *results.ranking.first().unwrap();
            (first, results.study.objective.value(results.cells[first].metrics().unwrap()))
        };
        assert_eq!(best(&exact), best(&fast), "{objective}");
        // What was given up is no better than it was told to be at least.
        for (exact_cell, fast_cell) in exact.cells.iter().zip(&fast.cells) {
            let (Some(exact_value), Some(bound)) = (exact_cell.metrics(), fast_cell.metrics()) else { continue };
            let value = |metrics| exact.study.objective.value(metrics);
            assert!(value(bound) <= value(exact_value) * (1.0 + 1e-12));
        }
    }
}

#[test]
fn a_machine_without_a_free_turn_is_refused() {
    let text = include_str!("../../studies/03_placement_circle/study.toml");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/03_placement_circle");
    let overrides =
        Overrides { redundancy: Some(kinetostat::process::Redundancy::BestConstant), ..Overrides::default() };
    let refused = Study::from_toml(text, "study.toml", folder.as_path(), &overrides).unwrap_err().to_string();
    assert!(refused.contains("machine orthoglide controls 3 coordinates"), "{refused}");
}

/// Parts of 0 to 20 mm before an arm on a rail along y, held at `rail`, with the middle of their bounds at `y`.
fn on_a_rail(rail: f64, y: f64) -> PlacementResults {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("path.csv"), "x_mm,y_mm,z_mm\n0,0,0\n20,0,0\n20,10,0\n").unwrap();
    let machine = include_str!("../machines/kr270_rail.toml");
    std::fs::write(
        folder.path().join("arm.toml"),
        machine.replace("min_mm = [1300.0, -600.0", "min_mm = [1300.0, -2600.0"),
    )
    .unwrap();
    let (low, high) = (y - 200.0, y + 200.0);
    let text = format!(
        "schema = 2\nquestion = \"?\"\nmachine = \"arm.toml\"\n[held]\nrail = {rail:.1}\n[process]\ntolerance_mm = 0.5\n\
         [process.sampling]\nmax_segment_mm = 5.0\n[process.force.path_frame]\nradial_force_N = 180.0\ntangential_force_N = -300.0\n\
         axial_force_N = -120.0\n[[placement.feature]]\nname = \"edge\"\nfile = \"path.csv\"\n[placement.bounds]\n\
         y_mm = [{low:.1}, {high:.1}]\n[placement.fixed]\nx_mm = 1600.0\nz_mm = 800.0\n[placement.objective]\n\
         weights = {{ worst_deflection = 1.0 }}\n[placement.search]\ngrid = {{ y = 5 }}\nstarts = 1\nmax_iterations = 4\n"
    );
    let study = Study::from_toml(&text, "study.toml", folder.path(), &Overrides::default()).unwrap();
    let StudyKind::Placement(study, _) = study.kind else { panic!("a placement") };
    run(&study, &Work::default()).unwrap()
}

#[test]
fn a_rail_that_is_driven_on_is_a_part_that_stands_back() {
    let [here, driven_on] =
        [on_a_rail(0.0, 0.0), on_a_rail(-1500.0, -1500.0)].map(|results| values(&results, Metric::WorstDeflection));
    assert!(here.iter().filter(|value| value.is_some_and(|mm| mm > 0.1)).count() >= 4, "{here:?}");
    for (a, b) in here.iter().zip(&driven_on) {
        assert_eq!(a.is_some(), b.is_some());
        assert!(a.zip(*b).is_none_or(|(a, b)| (a - b).abs() < 1e-9 * a), "{here:?} {driven_on:?}");
    }
}
