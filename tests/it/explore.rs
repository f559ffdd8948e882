//! What pages are answered is what the command line answers.

use std::path::Path;

use kinetostat::{
    Evaluator, Machine, Metric, Site, Study, StudyKind, Wrench,
    compensation::Target,
    explore::{EffectRequest, Explorer, LoadRequest, PlaceRequest, Scene, SliceRequest, ToolPlace, ToolRequest},
    input::Folder,
    inspect::point::{NominalCommand, PointLoad, PointQuestion, solve},
    machine::catalogue,
    questions::{Overrides, map::run},
    simulation::{Machines, Source},
    work::Work,
};
use nalgebra::Vector3;

use crate::support::command::{printed, told};

const WRENCH: [f64; 6] = [120.0, -40.0, -60.0, 0.0, 500.0, 0.0];

fn displacement(machine: &Machine, position: Vector3<f64>) -> Vector3<f64> {
    let question = PointQuestion {
        machine: machine.clone(),
        machines: Machines::new(machine, &[]).unwrap(),
        errors: Vec::new(),
        place: NominalCommand::Position(position),
        load: PointLoad::Wrench(Wrench::new(WRENCH)),
        target: Target::ToolTip,
    };
    let answer = solve(&question).unwrap();
    machine.tool_displacement(&answer.zero.unwrap(), &answer.loaded.pose)
}

fn study(folder: &str) -> Study {
    Study::open(Path::new(folder), &Overrides::default()).unwrap()
}

#[test]
fn the_tool_and_a_node_of_a_map_move_as_point_says() {
    for name in ["orthoglide", "kr270"] {
        let machine = Machine::named(name).unwrap();
        let explorer = Explorer::open(Scene::from_machine(name, None)).unwrap();
        let low = machine.workspace.min;
        let load = LoadRequest::Wrench(WRENCH);
        let middle = 0.5 * (low + machine.workspace.max);
        let at = ToolPlace::Position(middle.into());
        let answer = explorer.tool(&ToolRequest { at, load, assembly_deg: Vec::new() }).unwrap();
        let expected = displacement(&machine, middle);
        assert!((Vector3::from(answer.displacement.unwrap()) - expected).norm() < 1e-9, "{name}: {answer:?}");
        let asked = SliceRequest { axis: 2, level: middle.z, counts: [3, 3], nodes: [4, 5], load };
        let slice = explorer.slice(&asked).unwrap();
        assert!((slice.displacement[0].unwrap() - expected.norm()).abs() < 1e-9, "{name}: {slice:?}");
    }
}

#[test]
fn a_changed_stiffness_is_that_of_with_parameters() {
    let mut explorer = Explorer::open(Scene::from_machine("orthoglide", None)).unwrap();
    let softer = vec![("leg.rail.stiffness".to_string(), 2e5)];
    explorer.set(softer.clone()).unwrap();
    let machine = Machine::named("orthoglide").unwrap().with_parameters(&softer).unwrap();
    let at = ToolPlace::Position([10.0, 20.0, 30.0]);
    let asked = ToolRequest { at, load: LoadRequest::Wrench(WRENCH), assembly_deg: Vec::new() };
    let moved = Vector3::from(explorer.tool(&asked).unwrap().displacement.unwrap());
    assert!((moved - displacement(&machine, Vector3::new(10.0, 20.0, 30.0))).norm() < 1e-9);
    assert!(explorer.set(vec![("no such number".into(), 1.0)]).is_err());
}

#[test]
fn a_place_is_judged_as_its_study_judges_it() {
    let study = study("studies/03_placement_circle");
    let scene = Scene::from_study(&study).unwrap().unwrap();
    let StudyKind::Placement(placement, ()) = &study.kind else { panic!("a placement study") };
    let explorer = Explorer::open(scene).unwrap();
    let place = [26.0, 20.0, 30.0, 0.0, 0.0, 0.0];
    let answer = explorer.place(&PlaceRequest { place, most: None, shown: None }).unwrap();
    let evaluator = Evaluator::new(placement, &Metric::ALL);
    let expected = evaluator.examine(&Site::new(Vector3::new(26.0, 20.0, 30.0), 0.0)).unwrap();
    let exactly_there = placement.objective.value(&expected.as_placed);
    assert!((answer.objective.unwrap() - exactly_there).abs() <= 1e-12 * exactly_there);
    assert!(exactly_there < placement.objective.value(&expected.metrics));
    for shown in &answer.metrics {
        let judged = expected.as_placed.get(Metric::named(shown.name).unwrap()).unwrap();
        // Walked in one go, not in runs side by side.
        assert!((shown.value - judged).abs() <= 1e-12 * judged.abs(), "{}: {} {judged}", shown.name, shown.value);
    }
    // A part of the points knows no more than all of them.
    let thinned = explorer.place(&PlaceRequest { place, most: Some(20), shown: Some([0, 3]) }).unwrap();
    assert!(thinned.stride > 1 && thinned.objective.is_none());
    assert!(thinned.metrics[0].value <= answer.metrics[0].value);
    // The machine stands at the worst point, or at the one that is asked for, as commanded and as the table of errors says.
    let worst = answer.machine.unwrap();
    let error =
        |point: usize| Vector3::from(answer.features[0].iter().find(|p| p.index == point).unwrap().before.unwrap());
    let largest = answer.metrics.iter().find(|metric| metric.name == "worst_deflection").unwrap().value;
    assert!((error(worst.point[1]).norm() - largest).abs() < 1e-9);
    for machine in [&worst, thinned.machine.as_ref().unwrap()] {
        let moved = Vector3::from(machine.loaded.tool_tip_mm) - Vector3::from(machine.commanded.tool_tip_mm);
        assert!((moved - error(machine.point[1])).norm() < 1e-6, "{moved}");
        assert!((moved - Vector3::from(machine.displacement)).norm() < 1e-6);
    }
    assert_eq!(thinned.machine.unwrap().point, [0, 3]);
    let beyond = PlaceRequest { place, most: Some(1), shown: Some([0, 100_000]) };
    assert!(explorer.place(&beyond).unwrap().machine.is_none());
    let text = explorer.study_file(place).unwrap();
    assert!(text.contains("by hand 1"));
}

#[test]
fn a_path_can_be_put_elsewhere() {
    let path = Scene::from_study(&study("studies/02_groove_50mm")).unwrap().unwrap();
    assert!(Explorer::open(path).unwrap().view().workpiece.is_some());
    assert!(Scene::from_study(&study("studies/05_superposition")).unwrap().is_none());
}

/// A map of a machine with weight, zeroed as said.
fn map_with_weight(zeroed: &str) -> Study {
    let toml = catalogue::find("fanuc_r2000ic").unwrap().toml;
    let machine = toml.replace("zeroed = \"at_home\"", &format!("zeroed = \"{zeroed}\""));
    let text = "schema = 3\nquestion = \"Where?\"\nmachine = \"arm.toml\"\n[process.force.path_frame]\n\
                radial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n[[process.chain_error]]\n\
                chain = \"arm\"\nturn_about_drive_axis_deg = 0.1\n[workspace_map]\nslices_z_mm = [1000.0]\n\
                min_mm = [1300.0, -100.0, 900.0]\nmax_mm = [1500.0, 100.0, 1100.0]\nphi_step_deg = 30.0\n";
    let folder = Folder::in_memory([("arm.toml".to_string(), machine.into_bytes())]);
    Study::from_toml(text, "study.toml", folder, &Overrides { grid: Some([2, 1, 2]), ..Overrides::default() }).unwrap()
}

#[test]
fn the_bent_machine_of_a_map_is_moved_as_its_table_says() {
    let overrides = Overrides { grid: Some([2, 2, 1]), ..Overrides::default() };
    let orthoglide = Study::open(Path::new("studies/01_workspace_map"), &overrides).unwrap();
    for study in [orthoglide, map_with_weight("at_rest"), map_with_weight("weightless"), map_with_weight("at_home")] {
        let explorer = Explorer::open(Scene::from_study(&study).unwrap().unwrap()).unwrap();
        let StudyKind::WorkspaceMap(map, _) = &study.kind else { panic!("a map") };
        let mut compared = 0;
        for point in run(map, &Work::default()).unwrap().points {
            for (source, effect) in point.effects.iter() {
                let Ok(effect) = effect else { continue };
                let asked = EffectRequest { position: point.position_mm, source, phi_deg: effect.phi_deg };
                let answer = explorer.effect(&asked).unwrap();
                let (before, loaded) = (answer.before.unwrap(), answer.loaded.unwrap());
                let moved = Vector3::from(answer.displacement.unwrap());
                let off = (moved - Vector3::from(effect.deflection_vector_mm)).norm();
                assert!(off < 1e-7, "{source:?} at {:?}: {off}", point.position_mm);
                let drawn = Vector3::from(loaded.tool_tip_mm) - Vector3::from(before.tool_tip_mm);
                assert!((drawn - moved).norm() < 1e-7, "{source:?}: drawn {drawn}, moved {moved}");
                compared += 1;
            }
        }
        assert!(compared >= 12, "{compared}");
    }
}

#[test]
fn what_a_map_cannot_be_asked_is_refused_in_words() {
    let scene = Scene::from_study(&study("studies/01_workspace_map")).unwrap().unwrap();
    let explorer = Explorer::open(scene).unwrap();
    let asked = EffectRequest { position: [0.0; 3], source: Source::All, phi_deg: Some(40.0) };
    let refused = |asked| explorer.effect(&asked).unwrap_err().to_string();
    assert!(refused(EffectRequest { phi_deg: None, ..asked }).contains("expected the tool angle"));
    assert!(refused(EffectRequest { position: [f64::NAN, 0.0, 0.0], ..asked }).contains("position"));
    let far = explorer.effect(&EffectRequest { position: [1e4, 0.0, 0.0], ..asked }).unwrap();
    assert!(far.loaded.is_none() && far.status != "solved" && !far.reason.is_empty(), "{far:?}");
    let alone = Explorer::open(Scene::from_machine("orthoglide", None)).unwrap();
    assert!(alone.effect(&asked).unwrap_err().to_string().contains("no map"));
}

#[test]
fn a_page_begins_with_the_force_that_it_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("page.html");
    let out = out.to_str().unwrap();
    let begins_with = |own: &[&str]| {
        printed(&[&["explore", "orthoglide", "--out", out], own].concat());
        let page = std::fs::read_to_string(out).unwrap();
        page.split_once("data-wrench=\"").map(|(_, rest)| rest.split_once('"').unwrap().0.to_string())
    };
    assert_eq!(begins_with(&[]), None);
    assert_eq!(begins_with(&["--wrench", "-20,300,-500.5,0,1e3,0"]).as_deref(), Some("-20,300,-500.5,0,1000,0"));
    let cutter = ["--cutter", "D=10,z=4,ae=5,ap=8,fz=0.08,cut=down", "--material", "Al 6082-T6"];
    let first = begins_with(&cutter).unwrap();
    let point = printed(
        &[&["point", "--machine", "orthoglide", "--position", "0,0,0", "--phi", "0", "--json"], &cutter[..]].concat(),
    );
    let point: serde_json::Value = serde_json::from_str(&point).unwrap();
    let expected: Vec<f64> = serde_json::from_value(point["wrench_N_Nmm"].clone()).unwrap();
    let numbers: Vec<f64> = first.split(',').map(|number| number.parse().unwrap()).collect();
    assert_eq!(numbers, expected);
    let both = told(&[&["explore", "orthoglide", "--out", out, "--wrench", "1,0,0,0,0,0"], &cutter[..]].concat());
    assert!(both.0 == Some(2) && both.2.contains("cannot be used with"), "{}", both.2);
    assert_eq!(told(&["explore", "orthoglide", "--out", out, "--wrench", "1,2"]).0, Some(2));
}
