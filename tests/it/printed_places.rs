//! A place is what is printed: typed into a path study it has the verdict that the placement gave it.

use std::{fs, path::Path};

use kinetostat::{
    compensation::Target,
    process::{CutPath, GammaChoice, Process, RedundancySettings},
    questions::{
        Overrides, Study, StudyKind,
        path::run as run_path,
        placement::{Metric, PlacementResults, report::summary_text, run},
    },
    redundancy::{GammaProblem, search_gamma},
    simulation::Source,
    toolpath::polyline::Polyline,
    work::Work,
};
use nalgebra::{Rotation3, Unit, Vector3};

use crate::support::engine::catalogue_machine;

/// Placement studies that come with the program, and a coarser grid for each.
const STUDIES: [(&str, &str); 3] = [
    ("03_placement_circle", "x = 3\ny = 3\nz = 2"),
    ("04_placement_pocket", "x = 3\ny = 3\nyaw = 2"),
    ("09_robot_part", "x = 3\ny = 3\nyaw = 2"),
];

fn table(text: &str) -> toml::Table {
    text.parse().unwrap()
}

fn studied(folder: &Path, study: &toml::Table) -> StudyKind {
    let text = toml::to_string(study).unwrap();
    Study::from_toml(&text, "study.toml", folder, &Overrides::default()).unwrap().kind
}

/// The numbers in the brackets and behind the angles of "At the recommended place, (1.0, −2.0, 3.0) mm at yaw 4.0°:".
fn printed(results: &PlacementResults) -> ([f64; 3], Vec<(String, f64)>) {
    let text = summary_text(results).replace('\u{2212}', "-").replace('\u{a0}', " ");
    let place = text.split_once("At the recommended place, (").unwrap().1.split_once(", wherever").unwrap().0;
    let (position, angles) = place.split_once(") mm").unwrap();
    let position: Vec<f64> = position.split(", ").map(|own| own.parse().unwrap()).collect();
    let angles = angles.trim_start_matches(" at ").split(", ").filter(|own| !own.is_empty());
    let angle = |own: &str| {
        let (name, degrees) = own.split_once(' ').unwrap();
        (format!("{name}_deg"), degrees.trim_end_matches('°').parse().unwrap())
    };
    (position.try_into().unwrap(), angles.map(angle).collect())
}

#[test]
fn the_printed_place_of_every_placement_study_has_its_verdict_in_a_path_study() {
    for (name, grid) in STUDIES {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(name);
        let mut study = table(&fs::read_to_string(folder.join("study.toml")).unwrap());
        let search = format!("starts = 1\nmax_iterations = 12\n[grid]\n{grid}\n");
        let placement = study["placement"].as_table_mut().unwrap();
        placement.insert("search".into(), table(&search).into());
        placement.remove("candidate");
        placement["objective"].as_table_mut().unwrap().remove("pareto");
        let features = placement["feature"].as_array().unwrap().clone();
        let StudyKind::Placement(placed, _) = studied(&folder, &study) else { panic!("{name}") };
        let results = run(&placed, &Work::default()).unwrap();
        let best = results.best.as_ref().unwrap();
        for (i, value) in best.site.shown().into_iter().enumerate() {
            let steps = value * if i < 3 { 100.0 } else { 10.0 };
            assert!((steps - steps.round()).abs() < 1e-6, "{name}: coordinate {i} is {value}");
        }
        let (position, angles) = printed(&results);
        let entry = &results.entries[best.entry];
        let mut worst = 0.0f64;
        for (feature, gamma) in features.iter().zip(&entry.gammas) {
            let feature = feature.as_table().unwrap();
            let file = feature.get("process").or_else(|| study.get("process")).unwrap().as_str().unwrap();
            let mut process = table(&fs::read_to_string(folder.join(file)).unwrap());
            process.remove("schema");
            let mut place =
                process.get("placement").map_or_else(toml::Table::new, |own| own.as_table().unwrap().clone());
            place.insert("origin_mm".into(), position.to_vec().into());
            place.extend(angles.iter().map(|(key, value)| (key.clone(), (*value).into())));
            process.insert("placement".into(), place.into());
            if let Some(gamma) = gamma {
                let degrees = (10.0 * gamma.to_degrees()).round() / 10.0;
                let redundancy = process["redundancy"].as_table_mut().unwrap();
                redundancy.insert("range_deg".into(), vec![degrees; 2].into());
            }
            let mut path = table("schema = 3\nquestion = \"?\"\n[path]\nmethods = [\"none\"]");
            path.insert("machine".into(), study["machine"].clone());
            // A placement stays on the branch of home.
            if let Some(branch) = placed.machine.branch_of(&placed.machine.home).filter(|_| gamma.is_some()) {
                path.insert("branch".into(), branch.label().into());
            }
            path.insert("process".into(), process.into());
            let own = ["circle", "file"].into_iter().find_map(|key| Some((key, feature.get(key)?.clone())));
            let (key, value) = own.unwrap();
            path["path"].as_table_mut().unwrap().insert(key.into(), value);
            let StudyKind::Path(path, _) = studied(&folder, &path) else { panic!("{name}") };
            let along = run_path(&path, &Work::default()).unwrap();
            let machine = &along.study.machine;
            let outside =
                along.study.tasks.iter().filter(|task| machine.outside_workspace(task.pose.translation).is_some());
            assert_eq!(outside.count(), 0, "{name}: {position:?} {angles:?}");
            let counts = |k: &usize| along.study.stations[*k].cutting;
            let cuts = (0..along.study.stations.len()).any(|k| counts(&k));
            let counted = (0..along.study.stations.len()).filter(|k| !cuts || counts(k));
            let sizes = counted.map(|k| along.whole.displacement(Source::All, k).unwrap().norm());
            worst = sizes.fold(worst, f64::max);
        }
        let judged = entry.feasible().unwrap().as_placed.get(Metric::WorstDeflection).unwrap();
        assert!((worst / judged - 1.0).abs() < 1e-6, "{name}: {worst} and {judged}");
    }
}

/// Points of a straight line along y in front of the R-2000iC, whose tool stands 245 mm beside its flange.
fn line() -> CutPath {
    let rows: String = (0..9).map(|k| format!("0.0,{},0.0,600\n", 5.0 * f64::from(k))).collect();
    Polyline::read(format!("x_mm,y_mm,z_mm,feed_mm_per_min\n{rows}"), "path.csv").unwrap().toolpath().clone().into()
}

#[test]
fn gamma_along_a_path_keeps_p_in_the_workspace_box() {
    let mut machine = catalogue_machine("fanuc_r2000ic");
    let text = "schema = 1\n[placement]\norigin_mm = [1900.0, 0.0, 900.0]\n\
                [force.path_frame]\nradial_force_N = 300.0\ntangential_force_N = -200.0\naxial_force_N = -150.0\n";
    let process = Process::from_toml(text, "process.toml", std::path::PathBuf::new(), &machine).unwrap();
    let path = line();
    let loads = process.loads(&path).unwrap();
    // P where the tip is at a point: the tool is turned about its axis as a rigid body.
    let axis = Unit::new_normalize(machine.tool_axes.column(2).into_owned());
    let home = machine.home.pose.rotation;
    let tip = machine.tool_tip;
    let p_at = |k: usize, gamma: f64| {
        let position = process.placement.pose().transform(path.points()[k].position_mm);
        position - home * (Rotation3::from_axis_angle(&axis, gamma.to_radians()) * tip)
    };
    let settings = |gamma| RedundancySettings { gamma, step_deg: 30.0, ..RedundancySettings::default() };
    let wide: Vector3<f64> = Vector3::repeat(1e4);
    (machine.workspace.min, machine.workspace.max) = (-wide, wide);
    let free = sought(&machine, &process, &path, &loads, &settings(GammaChoice::Best));
    let constant = free.best_constant.as_ref().unwrap().turns_deg[0];
    // A box that holds P as programmed, and not where γ is best.
    let ends = (0..path.len()).map(|k| p_at(k, 0.0));
    let (low, high) = ends.fold((wide, -wide), |(low, high), p| (low.inf(&p), high.sup(&p)));
    (machine.workspace.min, machine.workspace.max) = (low - Vector3::repeat(60.0), high + Vector3::repeat(60.0));
    let is_inside = |p: Vector3<f64>| {
        (0..3).all(|i| p[i] >= machine.workspace.min[i] - 1e-6 && p[i] <= machine.workspace.max[i] + 1e-6)
    };
    assert!(!is_inside(p_at(0, constant)), "γ = {constant} keeps the box anyway");
    for choice in [GammaChoice::BestConstant, GammaChoice::Best] {
        let found = sought(&machine, &process, &path, &loads, &settings(choice));
        let turned = found.result_for(choice).unwrap().as_ref().unwrap();
        assert!(!found.leaves_box);
        for (k, gamma) in turned.turns_deg.iter().enumerate() {
            assert!(is_inside(p_at(k, *gamma)), "{choice:?}: γ = {gamma} at point {k}");
        }
    }
    // Where no γ keeps the box, those outside are admitted, and that is known.
    machine.workspace.max = machine.workspace.min + Vector3::repeat(1.0);
    assert!(sought(&machine, &process, &path, &loads, &settings(GammaChoice::BestConstant)).leaves_box);
}

fn sought(
    machine: &kinetostat::machine::Machine,
    process: &Process,
    path: &CutPath,
    loads: &[kinetostat::process::cutting::PathLoad],
    settings: &RedundancySettings,
) -> kinetostat::redundancy::FoundGamma {
    let placement = &process.placement;
    let problem = GammaProblem { machine, errors: &[], placement, target: Target::ToolTip, path, loads, settings };
    search_gamma(problem, &Work::default()).unwrap()
}
