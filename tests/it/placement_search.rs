//! Placement studies against attacks: what is recommended can be cut there, is the best place known, and is as good as
//! brute force finds.

use std::{cell::Cell, path::Path};

use crate::support::{
    cases::cases,
    placement::{searched, study_in},
};
use kinetostat::figures::shapes::hull;
use kinetostat::questions::placement::{
    Bounds, End, Entry, Evaluator, Metric, Metrics, PlacementResults, PlacementStudy, Probe, Site, SiteGrid, basis,
    compare, dominates, levels, margin_along, report::summary_text, undominated,
};
use proptest::test_runner::RngSeed;
use rayon::prelude::*;

/// Three slides and a beam; the prismatic joint along x can go 60 mm either way from home.
const GANTRY: &str = r#"schema = 1
name = "gantry"
title = "Three slides and a beam"
platform = { tool_tip_mm = [0.0, 0.0, -50.0], controls = ["x", "y", "z"] }
home = { position_mm = [100.0, 0.0, 0.0] }
workspace = { min_mm = [0.0, -100.0, -100.0], max_mm = [200.0, 100.0, 100.0] }
material = { steel = { youngs_modulus_N_per_mm2 = 210000.0, shear_modulus_N_per_mm2 = 81000.0 } }
mount = [{ name = "arm", chain = "arm" }]
[[chain]]
name = "arm"
elements = [
  { prismatic_drive = { name = "x", axis = "x", stiffness_N_per_mm = 1e5, travel_mm = [-60.0, 60.0] } },
  { prismatic_drive = { name = "y", axis = "y", stiffness_N_per_mm = 1e5 } },
  { prismatic_drive = { name = "z", axis = "z", stiffness_N_per_mm = 1e5 } },
  { beam = { length_mm = 100.0, section = { round = { diameter_mm = 40.0 } }, material = "steel" } },
]
"#;

const STUDY: &str = r#"schema = 3
question = "where?"
machine = "gantry.toml"
[placement]
clearance_mm = 0.0
[[placement.feature]]
name = "line"
process = "process.toml"
file = "line.csv"
tolerance_mm = 0.1
[placement.allowance]
position_mm = 0.0
angle_deg = 0.0
[placement.objective]
weights = { worst_deflection = 1.0 }
"#;

/// A line of `length` along x about the origin of W, under a force along x, on the gantry.
fn line(length: f64, force_x: f64, rest: &str) -> PlacementStudy {
    line_under(GANTRY, length, [force_x, 0.0], rest)
}

/// The same under a force along x and y, on a machine like the gantry.
fn line_under(gantry: &str, length: f64, [force_x, force_y]: [f64; 2], rest: &str) -> PlacementStudy {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("gantry.toml", gantry);
    write("process.toml", "schema = 1\n[placement]\nreference = \"platform_point\"\n[force]\nfrom_path = true\n");
    let half = 0.5 * length;
    let row = |x: f64| format!("{x:?},0,0,{force_x:?},{force_y:?},0\n");
    let header = "x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N\n";
    write("line.csv", &format!("{header}{}{}{}", row(-half), row(0.0), row(half)));
    study_in(folder.path(), &format!("{STUDY}{rest}")).unwrap_or_else(|e| panic!("{e}"))
}

const ALONG_X: &str = "[placement.bounds]\nx_mm = [40.0, 180.0]\n[placement.fixed]\ny_mm = 0.0\nz_mm = 0.0\n\
                       [placement.search]\ngrid = { x = 15 }\n";

fn entry<'a>(entries: &'a [Entry], name: &str) -> &'a Entry {
    entries.iter().find(|entry| entry.name == name).unwrap_or_else(|| panic!("no {name}"))
}

/// The recommendation is one of the entries, which can be cut at, within the bounds, and no better one is known.
fn check_recommendation(results: &PlacementResults) {
    let best = results.best.as_ref().unwrap();
    let recommended = &results.entries[best.entry];
    assert!(recommended.feasible().is_some(), "{recommended:?}");
    assert_eq!(recommended.value, best.value);
    let bounds = &results.study.bounds;
    for other in results.entries.iter().filter(|e| e.feasible().is_some() && bounds.inside(&e.site).is_some()) {
        assert!(other.value >= best.value, "{} is better than {}", other.name, recommended.name);
    }
    let evaluator = Evaluator::new(&results.study, &Metric::ALL);
    evaluator.evaluate(&best.site).unwrap_or_else(|failure| panic!("it is recommended, but {failure:?}"));
}

#[test]
fn what_is_recommended_can_be_cut_there_with_corrected_drives() {
    // 1000 N move the prismatic joint by 0.01 mm: against −x the corrected drive goes past 60 mm before the nominal one.
    let candidates = "[[placement.candidate]]\nname = \"end of the travel\"\norigin_mm = [145.0, 0.0, 0.0]\n\
                      [[placement.candidate]]\nname = \"just before\"\norigin_mm = [144.9, 0.0, 0.0]\n";
    let study = line(30.0, -1000.0, &format!("{ALONG_X}{candidates}"));
    let results = searched(&study);
    check_recommendation(&results);
    let refused = entry(&results.entries, "end of the travel").refusal().unwrap();
    assert_eq!(&*refused.status, "unreachable");
    let reason =
        "the corrected drive x of chain arm would stand at 60.020 mm, beyond its travel of -60.000 to 60.000 mm";
    assert!(refused.reason.ends_with(reason), "{}", refused.reason);
    assert!(entry(&results.entries, "just before").feasible().is_some());
    // The search refuses what the table refuses, though deflections do not need the correction.
    let evaluator = Evaluator::new(&study, &[Metric::WorstDeflection]);
    let at = |x: f64| evaluator.evaluate(&Site([x, 0.0, 0.0, 0.0, 0.0, 0.0]));
    assert!(at(145.0).is_err() && at(144.9).is_ok());
}

#[test]
fn a_line_as_long_as_the_travel_fits() {
    let study = line(
        120.0,
        0.0,
        &format!("{ALONG_X}[[placement.candidate]]\npoint = \"home\"\n")
            .replace("point = \"home\"", "name = \"middle\"\norigin_mm = [100.0, 0.0, 0.0]"),
    );
    assert!(entry(&compare(&study), "middle").feasible().is_some());
    let longer = line(
        120.001,
        0.0,
        &format!("{ALONG_X}[[placement.candidate]]\nname = \"middle\"\norigin_mm = [100.0, 0.0, 0.0]\n"),
    );
    assert!(entry(&compare(&longer), "middle").feasible().is_none());
}

#[test]
fn narrow_room_within_the_travel_is_found() {
    // The line may be moved by 0.5 mm either way; the places of the sweep are 10 mm apart and 3 mm off.
    let rest = ALONG_X.replace("[40.0, 180.0]", "[43.0, 183.0]");
    let results = searched(&line(119.0, 0.0, &rest));
    check_recommendation(&results);
    assert!((results.best.as_ref().unwrap().site.0[0] - 100.0).abs() <= 0.5);
    assert_eq!(results.gaps.coarse, [0]);
    let said = summary_text(&results);
    assert!(
        said.contains("The sweep is coarser than the regions that it found: its steps along x (10.0 mm)"),
        "{said}"
    );
}

/// Walls along x that leave a window for a line of 30 mm, `room` wider than that, at 97 mm.
fn window(room: f64) -> String {
    let half = 15.0 + 0.5 * room;
    let wall = |name: &str, low: f64, high: f64| {
        format!(
            "[[placement.forbidden]]\nname = \"{name}\"\nmin_mm = [{low:?}, -50.0, -50.0]\nmax_mm = [{high:?}, 50.0, 50.0]\n"
        )
    };
    wall("left", 0.0, 97.0 - half) + &wall("right", 97.0 + half, 200.0)
}

#[test]
fn where_no_place_can_be_cut_every_kind_of_reason_is_told_with_its_count() {
    // At 45, 91.7 and 138.3 mm the line of 30 mm is in the wall; at 185 mm the drive, which goes to 160 mm, is beyond its travel.
    let rest = ALONG_X.replace("[40.0, 180.0]", "[45.0, 185.0]").replace("x = 15", "x = 4");
    let wall = "[[placement.forbidden]]\nname = \"wall\"\nmin_mm = [0.0, -50.0, -50.0]\nmax_mm = [140.0, 50.0, 50.0]\n";
    let said = summary_text(&searched(&line(30.0, 100.0, &format!("{rest}{wall}"))));
    for expected in [
        "can be cut at none of the 4 places",
        "At 3 of them, such as (45.0, 0.0, 0.0) mm: ",
        "At 1 of them, such as (185.0, 0.0, 0.0) mm: ",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    assert!(said.contains("wall") && said.contains("travel"), "{said}");
}

#[test]
fn a_window_between_boxes_is_found_however_narrow() {
    for room in [2.0, 1.0, 0.01] {
        let results = searched(&line(30.0, 100.0, &format!("{ALONG_X}{}", window(room))));
        assert!(results.ranking.is_empty());
        check_recommendation(&results);
        assert!((results.best.as_ref().unwrap().site.0[0] - 97.0).abs() <= 0.5 * room + 1e-9);
        assert!(!summary_text(&results).contains("can be cut at none"));
    }
}

#[test]
fn flatness_does_not_go_through_thin_boxes() {
    let plate = "[[placement.forbidden]]\nname = \"plate\"\nmin_mm = [120.0, -50.0, -50.0]\nmax_mm = [120.02, 50.0, 50.0]\n\
                 [[placement.candidate]]\nname = \"beside\"\norigin_mm = [90.0, 0.0, 0.0]\n";
    let results = searched(&line(30.0, 100.0, &format!("{ALONG_X}{plate}")));
    let best = results.best.as_ref().unwrap();
    let x = best.site.0[0];
    // The deflection hardly changes along x: only plate, travel and bounds end the way.
    let room = results.flatness.iter().find(|room| room.direction > 0.0).unwrap();
    let expected = if x < 120.0 { 120.0 - 15.0 - x } else { 160.0 - 15.0 - x };
    assert!(room.distance <= expected + 1e-6, "{room:?} from {x}");
    if x < 120.0 {
        assert!((room.distance - expected).abs() < 1e-6, "{room:?} from {x}");
        assert!(matches!(&room.end, End::Infeasible(reason) if reason.contains("\"plate\"")), "{room:?}");
    }
    let back = results.flatness.iter().find(|room| room.direction < 0.0).unwrap();
    assert!(x - back.distance >= if x > 120.0 { 135.02 - 1e-6 } else { 55.0 - 1e-6 }, "{back:?} from {x}");
}

#[test]
fn flatness_does_not_go_through_the_end_of_a_travel() {
    // The slide along x is asked for most while the line lies along it, where the best place is 45° away.
    let bounds = "[placement.bounds]\nyaw_deg = [-45.0, 57.0]\n[placement.fixed]\nx_mm = 100.0\ny_mm = 0.0\nz_mm = 0.0\n\
                  [placement.search]\ngrid = { yaw = 16 }\n";
    // With a thick beam the deflection hardly depends on the angle.
    let gantry = GANTRY.replace("diameter_mm = 40.0", "diameter_mm = 400.0");
    // 0.05 mm of the way of an end, and how much the line is longer than the travel for that.
    let half = 0.025 / 60.0;
    for force in [1.0, 1000.0] {
        let study = |length: f64| line_under(&gantry, length, [force, force], bounds);
        let fits = |study: &PlacementStudy, yaw: f64| {
            let evaluator = Evaluator::new(study, &[Metric::WorstDeflection]);
            evaluator.evaluate(&Site([100.0, 0.0, 0.0, yaw, 0.0, 0.0])).is_ok()
        };
        let (mut fitting, mut longer) = (119.9, 120.1);
        while longer - fitting > 1e-8 {
            let middle = 0.5 * (fitting + longer);
            if fits(&study(middle), 0.0) { fitting = middle } else { longer = middle }
        }
        let study = study(fitting + 120.0 * 0.5 * half * half);
        // It cannot be cut in a narrow window only.
        assert!(!fits(&study, 0.0) && [-2.0, 2.0].into_iter().all(|at| fits(&study, at * half)));
        let results = searched(&study);
        let best = results.best.as_ref().unwrap().site.0[3];
        let room = results.flatness.iter().find(|room| room.direction == -best.signum()).unwrap();
        assert!(best.abs() > 0.5 && best.abs() - room.distance > 0.0, "{room:?} from {best}");
        assert!(best.abs() - room.distance < 3.0 * half, "{room:?} from {best}");
        let End::Infeasible(reason) = &room.end else { panic!("{room:?}") };
        assert!(reason.contains("travel"), "{reason}");
    }
}

#[test]
fn the_clearance_around_forbidden_boxes_is_kept() {
    let clamp = "[[placement.forbidden]]\nname = \"clamp\"\nmin_mm = [120.0, -5.0, -5.0]\nmax_mm = [140.0, 5.0, 5.0]\n\
                 [[placement.candidate]]\nname = \"near\"\norigin_mm = [101.0, 0.0, 0.0]\n\
                 [[placement.candidate]]\nname = \"far enough\"\norigin_mm = [100.0, 0.0, 0.0]\n";
    let mut study = line(30.0, 100.0, &format!("{ALONG_X}{clamp}"));
    assert_eq!(study.clearance_mm, 0.0);
    study.clearance_mm = 5.0;
    let entries = compare(&study);
    assert!(entry(&entries, "far enough").feasible().is_some());
    let refused = entry(&entries, "near").refusal().unwrap();
    let reason = "the workpiece would stand within the clearance of 5 mm around the forbidden box \"clamp\"";
    assert_eq!((&*refused.status, refused.reason.as_str()), ("forbidden", reason));
}

#[test]
fn a_path_that_leaves_the_workspace_box_is_not_recommended() {
    // Travel along y has no limit, the workspace ends at 100 mm.
    let rest = "[placement.bounds]\ny_mm = [60.0, 160.0]\n[placement.fixed]\nx_mm = 100.0\nz_mm = 0.0\n\
                [placement.search]\ngrid = { y = 5 }\n\
                [[placement.candidate]]\nname = \"outside\"\norigin_mm = [100.0, 101.0, 0.0]\n";
    let results = searched(&line(30.0, 100.0, rest));
    check_recommendation(&results);
    assert!(results.best.as_ref().unwrap().site.0[1] <= 100.0 + 1e-9);
    let outside = entry(&results.entries, "outside");
    let refusal = outside.refusal().unwrap();
    assert_eq!(&*refusal.status, "outside_workspace");
    assert!(
        refusal.reason.contains("y = 101 mm is outside the machine's workspace box, -100 to 100 mm"),
        "{refusal:?}"
    );
    // What would happen there is told all the same.
    assert!(outside.outcome.is_ok() && outside.feasible().is_none());
}

#[test]
fn a_workpiece_box_holds_its_paths() {
    let rest = format!("{ALONG_X}[placement.workpiece]\nmin_mm = [-14.0, -5.0, -5.0]\nmax_mm = [14.0, 5.0, 5.0]\n");
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("gantry.toml", GANTRY);
    write("process.toml", "schema = 1\n[force]\nfrom_path = true\n");
    write("line.csv", "x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N\n-10,0,0,1,0,0\n15,0,0,1,0,0\n");
    let error = study_in(folder.path(), &format!("{STUDY}{rest}")).unwrap_err().to_string();
    let expected = "placement.workpiece: the box (-14, -5, -5) to (14, 5, 5) mm does not hold point 25 of feature \"line\" at \
                    (15.000, 0.000, 0.000) mm, to which the tool cuts";
    assert!(error.contains(expected), "{error}");
    // The tool comes from above: there the path may begin outside.
    let above = "x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N\n-10,0,9,1,0,0\n10,0,0,1,0,0\n";
    write("line.csv", above);
    assert!(study_in(folder.path(), &format!("{STUDY}{rest}")).is_ok());
    // Above is where the axis of the tool says, wherever the tip is beside P.
    let aside = GANTRY
        .replace("tool_tip_mm = [0.0, 0.0, -50.0]", "tool_tip_mm = [150.0, 0.0, -50.0], tool_axis = [0.0, 0.0, -1.0]");
    assert_ne!(aside, GANTRY);
    write("gantry.toml", &aside);
    assert!(study_in(folder.path(), &format!("{STUDY}{rest}")).is_ok());
    write("line.csv", &above.replace("-10,0,9", "-60,0,-4"));
    assert!(study_in(folder.path(), &format!("{STUDY}{rest}")).is_err());
    write("gantry.toml", GANTRY);
    // Above the part it is in air, wherever it is.
    write("line.csv", &above.replace("-10,0,9,1,0,0", "-30,0,9,1,0,0\n-10,0,9,1,0,0"));
    assert!(study_in(folder.path(), &format!("{STUDY}{rest}")).is_ok());
    write("line.csv", &above.replace("-10,0,9", "-10,0,-9"));
    assert!(study_in(folder.path(), &format!("{STUDY}{rest}")).is_err());
}

#[test]
fn an_angle_goes_round() {
    let rest = "[placement.bounds]\nyaw_deg = [-180.0, 180.0]\n[placement.fixed]\nx_mm = 100.0\ny_mm = 0.0\nz_mm = 0.0\n\
                [placement.search]\ngrid = { yaw = 5 }\n\
                [[placement.candidate]]\nname = \"turned on\"\norigin_mm = [100.0, 0.0, 0.0]\nyaw_deg = 530.0\n";
    let mut study = line(30.0, 1000.0, rest);
    let degrees: Vec<f64> = study.grid.axes[3].iter().map(|yaw| yaw.to_degrees().round()).collect();
    assert_eq!(degrees, [-180.0, -108.0, -36.0, 36.0, 108.0]);
    study.search.max_iterations = 40;
    let results = searched(&study);
    check_recommendation(&results);
    // 530° is 170°: a start.
    let near = |refinement: &kinetostat::questions::placement::Refinement| {
        (refinement.start.0[3].to_degrees() - 170.0).abs() < 1e-6
    };
    assert!(results.refinements.iter().any(near));
    // The force lies along the beam where the line does: twice in a turn, the same either way.
    let ends: Vec<f64> = results.refinements.iter().map(|refinement| refinement.value).collect();
    let least = ends.iter().copied().fold(f64::MAX, f64::min);
    assert!(ends.iter().all(|value| *value <= least * 1.001), "{ends:?}");
}

#[test]
fn a_search_cut_short_by_its_iterations_goes_on_and_says_so() {
    let rest = "[placement.bounds]\ny_mm = [-90.0, 90.0]\nyaw_deg = [-80.0, 80.0]\n[placement.fixed]\nx_mm = 100.0\nz_mm = 0.0\n\
                [placement.search]\ngrid = { y = 2, yaw = 2 }\nmax_iterations = 3\nstarts = 1\n";
    let results = searched(&line(30.0, 1000.0, rest));
    let refinement = &results.refinements[0];
    assert!(refinement.continued > 0 && refinement.iterations > 3, "{refinement:?}");
    let said = summary_text(&results);
    assert!(said.contains("went on after max_iterations"), "{said}");
}

#[test]
fn nothing_is_better_than_zero() {
    // Without force and errors nothing deflects.
    let results = searched(&line(30.0, 0.0, ALONG_X));
    let said = summary_text(&results);
    assert!(!said.contains("% better") && !said.contains("inf") && !said.contains("NaN"), "{said}");
}

#[test]
fn a_named_place_within_the_bounds_is_a_start_and_never_loses() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/studies/03_placement_circle"));
    // The sweep is two corners; the named place is far better than both.
    let study = study_in(
        folder,
        &groove(
            13,
            "x_mm = [-48.0, 101.0]\ny_mm = [-48.0, 101.0]",
            "grid = { x = 2, y = 2 }\nstarts = 1\nmax_iterations = 2\n[[placement.candidate]]\nname = \"good\"\norigin_mm = [-40.0, -30.0, 60.0]",
            "worst_deflection = 1.0",
        ),
    );
    let results = searched(&study.unwrap());
    check_recommendation(&results);
    assert!(results.best.as_ref().unwrap().value <= entry(&results.entries, "good").value);
}

fn groove(points: usize, bounds: &str, search: &str, weights: &str) -> String {
    format!(
        "schema = 3\nquestion = \"where?\"\nmachine = \"orthoglide\"\n[placement]\nclearance_mm = 0.0\n\
         [[placement.feature]]\nname = \"groove\"\nprocess = \"process.toml\"\ntolerance_mm = 0.6\n\
         circle = {{ centre_mm = [0.0, 0.0, 0.0], diameter_mm = 50.0, points = {points} }}\n\
         [placement.bounds]\n{bounds}\n[placement.fixed]\nz_mm = 60.0\n\
         [placement.objective]\nweights = {{ {weights} }}\npareto = [\"worst_deflection\", \"worst_correction\"]\n\
         [placement.search]\n{search}\n"
    )
}

/// Numbers in [0, 1) that a seed gives.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * ((self.0 >> 33) as f64 / (1u64 << 31) as f64)
    }
}

/// A groove somewhere in the Orthoglide, with boxes in the way and weights drawn.
fn random_problem(seed: u64) -> PlacementStudy {
    let mut dice = Dice(seed.wrapping_mul(7919) + 17);
    dice.roll(0.0, 1.0);
    let mut ends = || {
        let low = dice.roll(-48.0, 20.0);
        let high = low + dice.roll(30.0, 101.0 - low);
        format!("[{low:?}, {high:?}]")
    };
    let bounds = format!("x_mm = {}\ny_mm = {}", ends(), ends());
    let weights = match seed % 3 {
        0 => "worst_deflection = 1.0".to_string(),
        1 => format!("worst_deflection = 1.0, worst_correction = {:?}", dice.roll(0.2, 2.0)),
        _ => format!("rms_deflection = 1.0, worst_drive_force = {:?}", dice.roll(0.0005, 0.004)),
    };
    let mut search = "grid = { x = 5, y = 5 }\nstarts = 3".to_string();
    for k in 0..seed % 3 {
        let corner = [dice.roll(-70.0, 60.0), dice.roll(-70.0, 60.0)];
        let size = [dice.roll(1.0, 40.0), dice.roll(1.0, 40.0)];
        search += &format!(
            "\n[[placement.forbidden]]\nname = \"box {k}\"\nmin_mm = [{:?}, {:?}, 0.0]\nmax_mm = [{:?}, {:?}, 100.0]",
            corner[0],
            corner[1],
            corner[0] + size[0],
            corner[1] + size[1]
        );
    }
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/studies/03_placement_circle"));
    study_in(folder, &groove(9, &bounds, &search, &weights)).unwrap_or_else(|e| panic!("{e}"))
}

/// All places of a grid that can be cut at, with their metrics.
fn gridded(evaluator: &Evaluator, bounds: &Bounds, n: usize) -> Vec<(Site, Metrics)> {
    let grid = SiteGrid::new(bounds, [n, n, 1, 1, 1, 1]);
    let evaluated = (0..grid.len()).into_par_iter().filter_map(|index| {
        let site = grid.site(index);
        evaluator.evaluate(&site).ok().map(|evaluation| (site, evaluation.metrics))
    });
    evaluated.collect()
}

/// Places of a fine grid, and of ever finer ones around the best of them.
fn brute_force(study: &PlacementStudy) -> (f64, Vec<(Site, Metrics)>) {
    let evaluator = Evaluator::new(study, &study.objective.metrics());
    let all = gridded(&evaluator, &study.bounds, 41);
    let mut sorted: Vec<&(Site, Metrics)> = all.iter().collect();
    let value = |place: &(Site, Metrics)| study.objective.value(&place.1);
    sorted.sort_by(|a, b| value(a).total_cmp(&value(b)));
    let mut least = f64::MAX;
    for start in sorted.iter().take(3) {
        let (mut centre, mut best) = (start.0, value(start));
        let mut half = [study.bounds.range(0) / 40.0, study.bounds.range(1) / 40.0];
        for _ in 0..4 {
            let mut near = study.bounds;
            for (i, half) in half.iter_mut().enumerate() {
                near.low[i] = (centre.0[i] - *half).max(study.bounds.low[i]);
                near.high[i] = (centre.0[i] + *half).min(study.bounds.high[i]);
                *half *= 0.3;
            }
            for place in gridded(&evaluator, &near, 9) {
                if value(&place) < best {
                    (centre, best) = (place.0, value(&place));
                }
            }
        }
        least = least.min(best);
    }
    (least, all)
}

/// The goal: within 0.1 % of brute force, and no compromise of the front beaten by more than that.
const GOAL: f64 = 1e-3;

/// By what share the best place of a random problem is worse than that of brute force, and the most by which all that a
/// compromise shows is beaten there.
fn against_brute_force(seed: u64) -> Option<[f64; 2]> {
    let study = random_problem(seed);
    let results = searched(&study);
    let (least, all) = brute_force(&study);
    let Some(best) = &results.best else {
        assert!(all.is_empty(), "problem {seed}: nothing is found, but there is a place of {least}");
        return None;
    };
    check_recommendation(&results);
    let excess = best.value / least - 1.0;
    let by = |front: &Metrics, other: &Metrics| {
        let gain = |metric: &Metric| {
            let (own, other) = (metric.cost(front.get(*metric).unwrap()), metric.cost(other.get(*metric).unwrap()));
            (own - other) / own.abs()
        };
        study.objective.pareto.iter().map(gain).fold(f64::MAX, f64::min)
    };
    let compared = results.front.iter().flat_map(|(_, values)| all.iter().map(move |(_, other)| by(values, other)));
    let beaten = compared.fold(0.0, f64::max);
    println!(
        "problem {seed}: {:.6} against {least:.6} ({:+.4} %); front of {} beaten by up to {:.4} %",
        best.value,
        100.0 * excess,
        results.front.len(),
        100.0 * beaten
    );
    Some([excess, beaten])
}

#[test]
fn random_problems_are_solved_as_well_as_by_brute_force() {
    let drawn = cases(2);
    let RngSeed::Fixed(seed) = drawn.rng_seed else { panic!("INVARIANT_CASES: expected PROPTEST_RNG_SEED beside it") };
    let first = seed.saturating_sub(1);
    let problems = (first..first + u64::from(drawn.cases)).filter_map(against_brute_force);
    let [worst, beaten] = problems.fold([f64::MIN, 0.0], |all, one| [0, 1].map(|k| f64::max(all[k], one[k])));
    assert!(worst <= GOAL, "{:.3} % worse than brute force", 100.0 * worst);
    assert!(beaten <= GOAL, "a compromise is beaten by {:.3} %", 100.0 * beaten);
}

/// In the first two few ways lead on from compromises, along a bound, on an edge of two worst values. In the third the least deflection lies
/// in another region than the least that the sweep knows.
#[test]
fn compromises_of_problems_that_were_hard_are_not_beaten() {
    for seed in [90_210_954, 1_795_639_505, 1_796_045_405] {
        let [_, beaten] = against_brute_force(seed).expect("a place");
        assert!(beaten <= GOAL, "problem {seed}: a compromise is beaten by {:.3} %", 100.0 * beaten);
    }
}

/// The way of a quantity, and how often it was looked at.
fn followed(reach: f64, step: f64, share: impl Fn(f64) -> f64) -> (f64, End, usize) {
    let looks = Cell::new(0);
    let look = |at: f64| {
        looks.set(looks.get() + 1);
        let share = share(at);
        if share.abs() > 1.0 { Err(End::Worse) } else { Ok(Probe { at, shares: vec![0.1, share] }) }
    };
    let (distance, end) = margin_along(reach, step, look);
    (distance, end, looks.get())
}

#[test]
fn a_way_ends_where_it_gets_worse_or_at_the_bound() {
    let look = |at: f64| if at > 3.3 { Err(End::Worse) } else { Ok(Probe { at, shares: Vec::new() }) };
    let (distance, end) = margin_along(10.0, 1.0, look);
    assert!((distance - 3.3).abs() < 5e-4 && distance <= 3.3 && end == End::Worse);
    let free = |at: f64| Ok(Probe { at, shares: vec![at] });
    assert_eq!(margin_along(0.9, 1.0, free), (0.9, End::Bound));
    assert_eq!(margin_along(0.0, 1.0, free), (0.0, End::Bound));
    assert_eq!(margin_along(0.0, 1.0, |_| Err(End::Worse)), (0.0, End::Worse));
}

#[test]
fn no_limit_is_exceeded_between_looks_however_narrowly() {
    // The rise of a circle of radius 200 about `middle`, beyond the limit by half a `width` to either side.
    for (middle, width) in [(33.3, 2.0), (33.3, 0.05), (33.3, 0.004), (0.7, 0.05), (99.6, 0.05), (50.0, 0.05)] {
        for sign in [1.0, -1.0] {
            let rise = |at: f64| (200.0f64.powi(2) - (at - middle).powi(2)).sqrt();
            let share = |at: f64| sign * (1.0 + (rise(at) - rise(middle + 0.5 * width)) / 60.0);
            let (distance, _, looks) = followed(100.0, 100.0 / 32.0, share);
            let expected = middle - 0.5 * width;
            assert!(distance <= expected && distance > expected - 0.002, "{middle} {width}: {distance}");
            assert!(looks < 120, "{looks}");
        }
    }
}

#[test]
fn a_limit_that_is_just_kept_ends_no_way() {
    for below in [1e-6, 1e-9] {
        // Nearest to the limit at the start, within and at the end; along it; away from it.
        for middle in [0.0, 33.3, 100.0] {
            let (distance, end, looks) = followed(100.0, 3.125, |at| 1.0 - below - (at - middle).powi(2) / 24_000.0);
            assert_eq!((distance, end), (100.0, End::Bound));
            assert!(looks < 150, "{looks}");
        }
        assert_eq!(followed(100.0, 3.125, |_| 1.0 - below).2, 33);
        assert!(followed(100.0, 3.125, |at| 1.0 - below - 0.01 * at - 1e-5 * at * at).2 < 40);
    }
}

#[test]
fn levels_hold_every_point_once_and_grow() {
    for count in [1, 5, 31, 32, 361, 1000] {
        let points: Vec<usize> = (10..10 + count).collect();
        let levels = levels(&points);
        let mut all: Vec<usize> = levels.iter().flatten().copied().collect();
        all.sort_unstable();
        assert_eq!(all, points);
        assert!(levels[0].len() <= 32);
    }
}

#[test]
fn every_basis_is_orthonormal() {
    for (n, turn) in [(1, 3), (2, 0), (2, 1), (3, 7), (6, 100)] {
        let basis = basis(n, turn);
        for (i, a) in basis.iter().enumerate() {
            for (j, b) in basis.iter().enumerate() {
                let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 1e-12, "{n} {turn}");
            }
        }
    }
}

#[test]
fn consecutive_bases_of_a_plane_leave_no_wide_gap() {
    for first in 0..64 {
        let axes = (first..first + 8).flat_map(|round| basis(2, round));
        let mut angles: Vec<f64> = axes.map(|axis| axis[1].atan2(axis[0]).to_degrees().rem_euclid(90.0)).collect();
        angles.sort_by(f64::total_cmp);
        angles.push(angles[0] + 90.0);
        let gap = angles.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        assert!(gap <= 22.5, "{first}: {gap}");
    }
}

fn place(deflection: f64, margin: f64) -> (Site, Metrics) {
    let mut metrics = Metrics::default();
    metrics.set(Metric::WorstDeflection, deflection);
    metrics.set(Metric::StabilityMargin, margin);
    (Site([deflection, margin, 0.0, 0.0, 0.0, 0.0]), metrics)
}

#[test]
fn the_front_is_what_nothing_dominates() {
    let metrics = [Metric::WorstDeflection, Metric::StabilityMargin];
    // A larger margin is better.
    let places = [place(3.0, 9.0), place(1.0, 5.0), place(2.0, 5.0), place(2.0, 8.0), place(1.0, 5.0)];
    let found: Vec<[f64; 2]> = undominated(&places, &metrics).iter().map(|(site, _)| [site.0[0], site.0[1]]).collect();
    assert_eq!(found, [[1.0, 5.0], [2.0, 8.0], [3.0, 9.0]]);
    assert!(dominates(&places[3].1, &places[2].1, &metrics));
    assert!(!dominates(&places[1].1, &places[4].1, &metrics));
    assert!(undominated(&places, &[]).is_empty());
}

#[test]
fn the_hull_of_a_box_is_its_outline() {
    let points = [(0.0, 0.0), (2.0, 0.0), (1.0, 0.5), (0.0, 1.0), (2.0, 1.0), (2.0, 0.0), (1.0, 0.0)];
    assert_eq!(hull(points.to_vec()), [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]);
    assert_eq!(hull(vec![(1.0, 1.0), (1.0, 1.0)]), [(1.0, 1.0)]);
}
