//! The allowance of a place: it can be cut, and is as good as said, wherever the workpiece is clamped within it.

use std::path::Path;

use kinetostat::questions::placement::{Allowance, Evaluator, Metric, PlacementStudy, Site};
use nalgebra::Vector3;

use crate::support::placement::{searched, study_in};

/// A groove on the Orthoglide with a wall at either side, as far from one another as `gap` mm.
fn between_walls(gap: f64, allowance: &str) -> PlacementStudy {
    let wall = |name: &str, from: f64| {
        format!(
            "[[placement.forbidden]]\nname = \"{name}\"\nmin_mm = [{from:?}, -500.0, -500.0]\nmax_mm = [{:?}, 500.0, 500.0]\n",
            from + 5.0
        )
    };
    let toml = format!(
        r#"
schema = 3
question = "where?"
machine = "orthoglide"
[placement]
clearance_mm = 0.0
[[placement.feature]]
name = "groove"
process = "process.toml"
circle = {{ centre_mm = [0.0, 0.0, 0.0], diameter_mm = 30.0, points = 17 }}
tolerance_mm = 0.6
[placement.workpiece]
min_mm = [-20.0, -20.0, 0.0]
max_mm = [20.0, 20.0, 10.0]
{}{}
[placement.bounds]
x_mm = [-40.0, 40.0]
y_mm = [-20.0, 20.0]
[placement.fixed]
z_mm = 0.0
[placement.objective]
weights = {{ worst_deflection = 1.0 }}
[placement.search]
grid = {{ x = 5, y = 3 }}
starts = 1
max_iterations = 6
{allowance}
"#,
        wall("left", -0.5 * gap - 5.0),
        wall("right", 0.5 * gap),
    );
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/03_placement_circle");
    study_in(Path::new(folder), &toml).unwrap_or_else(|e| panic!("{e}"))
}

const NONE: &str = "[placement.allowance]\nposition_mm = 0.0\nangle_deg = 0.0";

fn worst(study: &PlacementStudy, site: &Site) -> f64 {
    let evaluator = Evaluator::new(study, &[Metric::WorstDeflection]);
    evaluator.evaluate(site).unwrap().metrics.get(Metric::WorstDeflection).unwrap()
}

#[test]
fn a_gap_as_wide_as_the_part_has_no_room_to_clamp_it() {
    // 0.5 mm on each side: less than anybody clamps to.
    assert!(searched(&between_walls(41.0, NONE)).best.is_some());
    assert!(searched(&between_walls(41.0, "")).best.is_none());
    // 1 mm, and what a rotation by 0.5° takes of it, about the origin of the part.
    let needed = 2.0 * (1.0 + 20.0 * (0.5f64.to_radians().cos() + 0.5f64.to_radians().sin()));
    assert!(searched(&between_walls(needed - 0.01, "")).best.is_none());
    let results = searched(&between_walls(needed + 0.5, ""));
    let best = results.best.unwrap();
    assert!(best.site.0[0].abs() <= 0.25 + 1e-9, "{best:?}");
    // Anywhere between the corners it stands free, too: its room is at least what it is clamped within.
    for margin in results.flatness {
        let at_bound = results.study.bounds.high[margin.coordinate] - best.site.0[margin.coordinate].abs() < 1.0;
        assert!(at_bound || margin.distance >= 1.0, "{margin:?}");
    }
}

#[test]
fn a_place_is_as_good_as_the_worst_corner_of_its_allowance() {
    let (wide, exact) =
        (between_walls(400.0, "[placement.allowance]\nposition_mm = 2.0\nangle_deg = 1.0"), between_walls(400.0, NONE));
    assert!(exact.allowance.is_none());
    assert_eq!(wide.allowance.text(), "±2 mm along x and y and ±1° of yaw");
    let site = Site::new(Vector3::new(12.0, -7.0, 0.0), 0.1);
    let corners = [-1.0, 1.0]
        .into_iter()
        .flat_map(|x| [-1.0, 1.0].into_iter().flat_map(move |y| [-1.0, 1.0].map(|yaw| [x, y, yaw])));
    let at_corners = corners.map(|[x, y, yaw]| {
        worst(&exact, &Site::new(Vector3::new(12.0 + 2.0 * x, -7.0 + 2.0 * y, 0.0), 0.1 + yaw * 1f64.to_radians()))
    });
    let expected = at_corners.fold(worst(&exact, &site), f64::max);
    let evaluator = Evaluator::new(&wide, &[Metric::WorstDeflection]);
    let evaluation = evaluator.evaluate(&site).unwrap();
    let found = evaluation.metrics.get(Metric::WorstDeflection).unwrap();
    assert!((found - expected).abs() <= 1e-12 * expected, "{found} {expected}");
    assert_eq!(evaluation.as_placed.get(Metric::WorstDeflection), Some(worst(&exact, &site)));
    assert!(found > worst(&exact, &site));
}

#[test]
fn what_hinders_a_corner_is_said_with_the_corner() {
    let study = between_walls(41.0, "");
    let evaluator = Evaluator::new(&study, &[Metric::WorstDeflection]);
    let said = evaluator.evaluate(&Site::new(Vector3::zeros(), 0.0)).unwrap_err();
    assert_eq!(said.status, "forbidden");
    assert!(
        said.reason.starts_with("clamped at x −1 mm, y −1 mm, yaw −0.5° from there: the workpiece would stand in"),
        "{}",
        said.reason
    );
}

#[test]
fn runs_side_by_side_find_what_one_walk_finds() {
    let study = PlacementStudy { allowance: Allowance::default(), ..between_walls(400.0, NONE) };
    let evaluator = Evaluator::new(&study, &Metric::ALL);
    for site in [Site::new(Vector3::new(12.0, -7.0, 0.0), 0.1), Site::new(Vector3::new(-30.0, 15.0, 20.0), -1.0)] {
        let runs = evaluator.evaluate(&site).unwrap();
        let walk = evaluator.solve_points(&site, 1).outcome.unwrap();
        for metric in Metric::ALL {
            let (Some(runs), Some(walk)) = (runs.metrics.get(metric), walk.metrics.get(metric)) else { continue };
            assert!((runs - walk).abs() <= 1e-9 * (1.0 + walk.abs()), "{metric:?}: {runs} {walk}");
        }
    }
}
