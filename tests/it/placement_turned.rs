//! Placements judged by the parts of the deflection that make the workpiece wrong, and at the best turn about the tool's axis.

use std::path::Path;

use kinetostat::questions::{
    Overrides, Study, StudyKind,
    placement::{Evaluator, Metric, PlacementResults, PlacementStudy, compare, report::summary_text, run},
};
use kinetostat::work::Work;
use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::support::{cases::cases, engine::catalogue_machine};

const ROWS: &str = "x_mm,y_mm,z_mm,axis_x,axis_y,axis_z\n0,0,0,0.5,0,0.866\n20,0,-11.54,0.5,0,0.866\n20,30,-11.54,0.5,0,0.866\n0,30,0,0.5,0,0.866\n";

fn study(turn: &str, objective: &str, search: &str) -> Result<PlacementStudy, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("path.csv"), ROWS).unwrap();
    let text = format!(
        "schema = 3\nquestion = \"?\"\nmachine = \"fanuc_r2000ic\"\n[process]\ntolerance_mm = 0.5\n[process.sampling]\nmax_segment_mm = 10.0\n\
         [process.force.path_frame]\nradial_force_N = 180.0\ntangential_force_N = -300.0\naxial_force_N = -120.0\n\
         [process.redundancy]\ngamma = \"{turn}\"\nstep_deg = 30.0\n\
         [[placement.feature]]\nname = \"pocket\"\nfile = \"path.csv\"\n[placement.bounds]\nx_mm = [1950.0, 2250.0]\ny_mm = [-200.0, 200.0]\n\
         [placement.fixed]\nz_mm = 550.0\n[placement.allowance]\nposition_mm = 0.0\nangle_deg = 0.0\n[placement.objective]\nweights = {{ {objective} = 1.0 }}\n[placement.search]\ngrid = {{ x = 2, y = 3 }}\n\
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
        let turn =
            Evaluator::new(&turned.study, &turned.study.objective.metrics()).gamma_at(&site, 0).unwrap().unwrap();
        assert!((turn.to_degrees() / 30.0 - (turn.to_degrees() / 30.0).round()).abs() < 1e-9);
        // All points of so short a path are tried, so what is found is no worse than as programmed.
        if let Some(plain_rms) = plain_rms {
            assert!(turned_rms <= &(plain_rms * (1.0 + 1e-6)), "{turned_rms} {plain_rms}");
            better += usize::from(*turned_rms < 0.99 * plain_rms);
        }
    }
    assert!(better > 0, "{there:?} {here:?}");
    let refused = study("best", "rms_deflection", "").unwrap_err();
    assert!(refused.contains("redundancy.gamma: is best: a place is judged at one γ for each feature"), "{refused}");
}

#[test]
fn a_place_of_today_is_as_programmed_and_as_clamped() {
    let today = "[[placement.candidate]]\nname = \"as clamped today\"\norigin_mm = [2100.0, 100.0, 550.0]";
    let [sought, plain] = ["best_constant", "as_programmed"].map(|turn| results(turn, "worst_deflection", today));
    let named = |results: &PlacementResults| {
        results.entries.iter().find(|entry| entry.name == "as clamped today").unwrap().clone()
    };
    let (there, here) = (named(&sought), named(&plain));
    assert_eq!((there.outcome.clone(), there.value, there.gammas), (here.outcome, here.value, vec![None]));
    // At its best γ the same place is better: a gain against that would not be one against today.
    let best_there = compare(&sought.study).into_iter().find(|entry| entry.name == "as clamped today").unwrap();
    assert!(best_there.value < 0.98 * there.value, "{} {}", best_there.value, there.value);
    let best = sought.best.as_ref().unwrap();
    assert!(best.value <= best_there.value && sought.entries[best.entry].gammas[0].is_some(), "{best:?}");
    let worst = |value: f64| 100.0 * (there.value / value - 1.0);
    let said = format!(
        "Worst deflection at the named places, as programmed: as clamped today {:.3} mm (+{:.0} %).",
        there.value,
        worst(best.value)
    );
    let text = summary_text(&sought);
    assert!(text.contains(&said), "{said}\n{text}");
}

#[test]
fn no_place_next_to_the_best_one_is_better_at_its_own_turn() {
    let results = results("best_constant", "worst_deflection", "");
    let best = results.best.as_ref().unwrap();
    let evaluator = Evaluator::new(&results.study, &results.study.objective.metrics());
    // As far away as the last steps to it were: what ruled places out there was a bound.
    for (coordinate, by) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (0, 8.0), (1, 8.0), (0, -8.0), (1, -8.0)] {
        let mut site = best.site;
        site.0[coordinate] += by;
        if (0..2).any(|i| !(results.study.bounds.low[i]..=results.study.bounds.high[i]).contains(&site.0[i])) {
            continue;
        }
        let Ok(there) = evaluator.evaluate(&site) else { continue };
        let value = results.study.objective.value(&there.metrics);
        assert!(value >= best.value * (1.0 - 1e-3), "{value} {} {coordinate} {by}", best.value);
    }
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
        Overrides { redundancy: Some(kinetostat::process::GammaChoice::BestConstant), ..Overrides::default() };
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
        "schema = 3\nquestion = \"?\"\nmachine = \"arm.toml\"\n[locked]\nrail = {rail:.1}\n[process]\ntolerance_mm = 0.5\n\
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

/// Turns that are tried, 45° apart.
const TURNS: i32 = 8;

/// What is drawn for a placement whose every turn is looked at.
#[derive(Debug, Clone)]
struct Drawn {
    machine: &'static str,
    path: Vec<[f64; 3]>,
    /// Of the tool from straight down, rad.
    tilt: [f64; 3],
    force: [f64; 3],
    weights: &'static str,
    limits: &'static str,
    /// From the middle of the box, mm.
    places: Vec<[f64; 3]>,
}

fn drawn() -> impl Strategy<Value = Drawn> {
    let path = prop::collection::vec(prop::array::uniform3(-80.0..80.0f64), 3..6);
    let weights = prop::sample::select(vec![
        "worst_deflection = 1.0",
        "rms_deflection = 1.0",
        "worst_correction = 1.0",
        "worst_drive_force = 1.0",
        "rms_deflection = 1.0, worst_drive_force = 1e-7",
        "share_within_tolerance = 1.0, worst_deflection = 0.01",
    ]);
    // The legs of the hexapod have forces, the revolute joints of arms torques, whose limits are those of the machine.
    let machines = prop::sample::select(vec![
        ("fanuc_r2000ic", "", 1.0),
        ("kr270", "", 1.0),
        ("hexapod", "[process.limits]\nforce_limit_N = 700.0\n", 0.15),
    ]);
    (
        machines,
        path,
        prop::array::uniform3(-0.5..0.5f64),
        prop::array::uniform3(-400.0..400.0f64),
        weights,
        prop::collection::vec([-900.0..900.0f64, -1200.0..1200.0f64, -700.0..700.0f64], 4),
    )
        .prop_map(|((machine, limits, share), path, tilt, force, weights, places)| {
            let scaled = |vectors: Vec<[f64; 3]>| vectors.into_iter().map(|v| v.map(|x| share * x)).collect();
            let (path, places) = (scaled(path), scaled(places));
            Drawn { machine, path, tilt: tilt.map(|x| share * x), force, weights, limits, places }
        })
}

impl Drawn {
    /// The placement, its path turned by `turn`, rad, about the axis of the tool.
    fn study(&self, redundancy: &str, turn: f64) -> PlacementStudy {
        let machine = catalogue_machine(self.machine);
        let axis = Unit::new_normalize(machine.tool_axes.column(2).into_owned());
        // Down, and some tilt: what the platform is at γ = 0 is given at each point, so that no convention of the program is needed.
        let down = Rotation3::rotation_between(&axis, &-Vector3::z())
            .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        let platform = Rotation3::new(Vector3::from(self.tilt)) * down * Rotation3::from_axis_angle(&axis, turn);
        let q = UnitQuaternion::from_rotation_matrix(&platform);
        let mut csv = String::from("x_mm,y_mm,z_mm,platform_qw,platform_qx,platform_qy,platform_qz\n");
        for [x, y, z] in &self.path {
            csv += &format!("{x},{y},{z},{},{},{},{}\n", q.w, q.i, q.j, q.k);
        }
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("path.csv"), csv).unwrap();
        let middle = (machine.workspace.min + machine.workspace.max) * 0.5;
        let mut text = format!(
            "schema = 3\nquestion = \"?\"\nmachine = \"{}\"\n[process]\ntolerance_mm = 0.5\n\
             [process.force.path_frame]\nradial_force_N = {:?}\ntangential_force_N = {:?}\naxial_force_N = {:?}\n{}\
             [process.redundancy]\ngamma = \"{redundancy}\"\nstep_deg = 45.0\nmin_singularity_distance = 0.0\n\
             travel_margin_mm_or_deg = 0.0\n\
             [[placement.feature]]\nname = \"walk\"\nfile = \"path.csv\"\n[placement.objective]\nweights = {{ {} }}\n\
             [placement.bounds]\nx_mm = [0.0, 1.0]\n[placement.fixed]\ny_mm = 0.0\nz_mm = 0.0\n[placement.search]\ngrid = {{ x = 2 }}\n",
            self.machine, self.force[0], self.force[1], self.force[2], self.limits, self.weights
        );
        for (k, place) in self.places.iter().enumerate() {
            let at = middle + Vector3::from(*place);
            text +=
                &format!("[[placement.candidate]]\nname = \"{k}\"\norigin_mm = [{:?}, {:?}, {:?}]\n", at.x, at.y, at.z);
        }
        let study = Study::from_toml(&text, "study.toml", folder.path(), &Overrides::default());
        let StudyKind::Placement(study, _) = study.unwrap_or_else(|e| panic!("{e}")).kind else {
            panic!("a placement")
        };
        *study
    }
}

/// Of each place, by its name: what it is worth, or why it cannot be cut.
fn worth(study: &PlacementStudy) -> Vec<Result<f64, String>> {
    let entries = compare(study);
    let of = |k: usize| entries.iter().find(|entry| entry.name == k.to_string()).unwrap();
    let value = |k: usize| match of(k).refusal() {
        None => Ok(of(k).value),
        Some(failure) => Err(format!("{}: {}", failure.status, failure.reason)),
    };
    (0..entries.len()).map(value).collect()
}

/// Holds the best constant γ against all turns, each put into the path and then judged as programmed.
fn holds_against_all_turns(drawn: &Drawn) -> Result<(), TestCaseError> {
    let found = worth(&drawn.study("best_constant", 0.0));
    let turned: Vec<_> =
        (0..TURNS).map(|k| worth(&drawn.study("as_programmed", (f64::from(k) * 45.0 - 180.0).to_radians()))).collect();
    for (place, found) in found.iter().enumerate() {
        let best = turned.iter().filter_map(|worth| worth[place].as_ref().ok()).copied().reduce(f64::min);
        match (found, best) {
            (Ok(value), Some(best)) => {
                prop_assert!(
                    (value - best).abs() <= 1e-6 * best.abs().max(1e-3),
                    "place {place}: {value}, but {best} at the best of all turns"
                );
            }
            (Err(_), None) => {}
            _ => prop_assert!(false, "place {place}: {found:?}, but {best:?} at the best of all turns"),
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(2))]

    #[test]
    fn the_turn_of_a_place_is_the_best_of_all_at_which_it_can_be_cut(drawn in drawn()) {
        holds_against_all_turns(&drawn)?;
    }
}

/// A wave of nine points before an arm whose tool lies along the wrist.
const WAVE: [[f64; 2]; 9] = [
    [-40.0, 0.0],
    [-30.0, 10.606],
    [-20.0, 15.0],
    [-10.0, 10.607],
    [0.0, 0.001],
    [10.0, -10.605],
    [20.0, -15.0],
    [30.0, -10.608],
    [40.0, -0.003],
];

#[test]
fn a_place_that_only_a_turn_of_more_deflection_brings_into_the_box_can_be_cut() {
    let folder = tempfile::tempdir().unwrap();
    let mut csv = String::from("x_mm,y_mm,z_mm,platform_qw,platform_qx,platform_qy,platform_qz\n");
    for [x, y] in WAVE {
        csv += &format!("{x},{y},0,0.5,-0.5,0.5,-0.5\n");
    }
    std::fs::write(folder.path().join("path.csv"), csv).unwrap();
    let text = "schema = 3\nquestion = \"?\"\nmachine = \"fanuc_r2000ic\"\n[process]\ntolerance_mm = 0.5\n\
         [process.force.path_frame]\nradial_force_N = 180.0\ntangential_force_N = -300.0\naxial_force_N = -120.0\nlaw = \"rotated\"\n\
         [process.redundancy]\ngamma = \"best_constant\"\nstep_deg = 15.0\n\
         [[placement.feature]]\nname = \"wave\"\nfile = \"path.csv\"\n[placement.allowance]\nposition_mm = 0.0\nangle_deg = 0.0\n[placement.objective]\nweights = { worst_deflection = 1.0 }\n\
         [placement.bounds]\nx_mm = [1500.0, 2100.0]\n[placement.fixed]\ny_mm = 0.0\nz_mm = 850.0\n[placement.search]\ngrid = { x = 2 }\n\
         [[placement.candidate]]\nname = \"0\"\norigin_mm = [1501.0649173215209, 371.40474472428207, 850.0]\n";
    let study = Study::from_toml(text, "study.toml", folder.path(), &Overrides::default()).unwrap();
    let StudyKind::Placement(study, _) = study.kind else { panic!("a placement") };
    let entries = compare(&study);
    let entry = &entries[0];
    assert!(entry.feasible().is_some(), "{:?}", entry.refusal());
    // At −105°, 0.978 mm; the turns that deflect less lead P out of the box.
    assert!((entry.value - 0.978).abs() < 1e-3, "{}", entry.value);
    assert!((entry.gammas[0].unwrap().to_degrees() + 105.0).abs() < 1e-9, "{:?}", entry.gammas);
}
