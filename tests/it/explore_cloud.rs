//! The cloud of tool tips under the hand: closed forms, and whole machines of its draws solved one by one.

use kinetostat::{
    Machine, Study, Wrench,
    compensation::{Method, Session, Target, TaskPoint, compensate},
    explore::{CloudResult, Explorer, LoadRequest, Scene, ToolPlace, ToolRequest},
    input::Folder,
    process::uncertainty::{P95, Uncertainty, normal_quantile, quantile},
    questions::Overrides,
    simulation::{Machines, settings},
};
use nalgebra::Vector3;

use crate::support::uncertain::{LEVER, TOLERANCES, force, is_error, study_text};

/// The explorer of a map of `machine`, whose file is `toml` if it is not built in, with these tables.
fn explorer(machine: &str, toml: Option<&str>, uncertainty: &str) -> Explorer {
    let z =
        toml.map_or_else(|| Machine::named(machine), |toml| Machine::from_toml(toml, machine)).unwrap().workspace.min.z;
    let map = format!("[workspace_map]\nslices_z_mm = [{z:?}]\ngrid = [1, 1, 1]");
    let text = study_text(machine, &force(1.0, 0.0, 0.0), uncertainty, &map);
    let folder = Folder::in_memory(toml.map(|toml| (machine.to_string(), toml.as_bytes().to_vec())));
    let study = Study::from_toml(&text, "study.toml", folder, &Overrides::default()).unwrap();
    Explorer::open(Scene::from_study(&study).unwrap().unwrap()).unwrap()
}

fn asked(position: [f64; 3], wrench: [f64; 6]) -> ToolRequest {
    ToolRequest { at: ToolPlace::Position(position), load: LoadRequest::Wrench(wrench), assembly_deg: Vec::new() }
}

fn cloud(explorer: &Explorer, position: [f64; 3], wrench: [f64; 6]) -> CloudResult {
    explorer.cloud(&asked(position, wrench)).unwrap()
}

/// Compliance and force of a prismatic joint are lognormal, so that its displacement is.
#[test]
fn the_cloud_of_a_lever_has_the_exact_quantile() {
    let text = "[[uncertainty.parameter]]\nname = \"guide.slide.stiffness\"\nrelative_std = 0.3\n\
                [uncertainty.process]\nforce_relative_std = 0.15\n";
    let found = cloud(&explorer("lever.toml", Some(LEVER), text), [0.0; 3], [1000.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let variance = |relative: f64| (0.5 * (1.0 + (1.0 + 4.0 * relative * relative).sqrt())).ln();
    let exact = 0.1 * ((variance(0.3) + variance(0.15)).sqrt() * normal_quantile(P95)).exp();
    assert!((found.nominal.unwrap() - 0.1).abs() < 1e-9);
    // Of 4096 draws, and of the 256 that are drawn.
    assert!((found.p95.unwrap() / exact - 1.0).abs() < 0.008, "{:?} instead of {exact}", found.p95);
    let mut sizes: Vec<f64> = found.displacements.iter().map(|way| Vector3::from(*way).norm()).collect();
    assert_eq!(sizes.len(), 256);
    let drawn = quantile(&mut sizes, P95);
    assert!((drawn / exact - 1.0).abs() < 0.04, "{drawn} instead of {exact}");
}

/// Each tip is near that of the whole machine of its draw, and so is the 95 % quantile, without the sampling of the cloud.
#[test]
fn tips_of_a_cloud_are_those_of_whole_machines() {
    let stiffness = "[[uncertainty.parameter]]\nname = \"STIFFNESS\"\nrelative_std = 0.2\n";
    let wrench = [120.0, -40.0, -60.0, 0.0, 0.0, 0.0];
    for (name, stiffnesses) in [("orthoglide", "leg.*.stiffness"), ("kr270", "arm.*.stiffness")] {
        let tables = format!("{}{TOLERANCES}", stiffness.replace("STIFFNESS", stiffnesses));
        let text = format!("{tables}[uncertainty.model]\nrelative_std = 0.1\n");
        let machine = Machine::named(name).unwrap();
        let middle = 0.5 * (machine.workspace.min + machine.workspace.max);
        let map = explorer(name, None, &text);
        let found = cloud(&map, middle.into(), wrench);
        let inner =
            String::from("machine = \"exact\"\n") + &text.replace("[uncertainty.", "[").replace("[[uncertainty.", "[[");
        let uncertainty = Uncertainty::from_toml(&inner, "table", Folder::in_memory([]), &machine).unwrap();
        let at = machine.inverse_kinematics_at(middle).unwrap();
        let (mut whole, mut squares) = (Vec::new(), 0.0);
        for (index, tip) in found.displacements.iter().enumerate() {
            let values = |wanted: bool| -> Vec<(&str, f64)> {
                let of = uncertainty.parameters.iter().zip(&uncertainty.draws.normal);
                of.filter(|(own, _)| is_error(own.name()) == wanted).flat_map(|(own, z)| own.at(z[index])).collect()
            };
            let unloaded = uncertainty.machine.with_parameters(&values(false)).unwrap();
            let unloaded = Machines::new(&unloaded, &[]).unwrap().actual;
            let actual = unloaded.with_parameters(&values(true)).unwrap();
            let mut session = Session::new(&machine, &actual, settings()).with_unloaded_machine(&unloaded);
            let [free, moved] = [0.0, uncertainty.draws.force_of(0)[index]].map(|factor| {
                let load = Wrench::new(wrench).scale(factor);
                let task = TaskPoint::new(at.pose, load, Target::ToolTip);
                session.set_rigid(&at);
                let answer = compensate(&mut session, &task, Method::None);
                assert!(answer.status.is_success());
                answer.tool_displacement
            });
            let expected = moved + uncertainty.draws.model_error(index, &(moved - free));
            let off = (Vector3::from(*tip) - expected).norm() / found.p95.unwrap();
            assert!(off < 0.06, "{name}, draw {index}: {tip:?} instead of {expected}");
            whole.push(expected.norm());
            squares += off * off;
        }
        assert!((squares / whole.len() as f64).sqrt() < 0.01, "{name}: {squares}");
        let mut sizes: Vec<f64> = found.displacements.iter().map(|way| Vector3::from(*way).norm()).collect();
        let [estimate, exact] = [&mut sizes, &mut whole].map(|own| quantile(own, P95));
        assert!((estimate / exact - 1.0).abs() < 0.01, "{name}: {estimate} instead of {exact}");
    }
}

#[test]
fn where_no_cloud_can_be_drawn_it_says_why() {
    let pendulum = LEVER
        .replace("gravity_m_per_s2 = [0.0, 0.0, 0.0]\n", "zeroed = \"weightless\"\n")
        .replace(
            "controls = [\"x\"]",
            "controls = [\"x\"]\nmass = { kg = 10.0 }\n[home]\nposition_mm = [0.0, 0.0, 1000.0]",
        )
        .replace("_mm = [-1.0, 0.0, 0.0]", "_mm = [0.0, 0.0, 1000.0]")
        .replace("_mm = [1.0, 0.0, 0.0]", "_mm = [0.0, 0.0, 1000.0]")
        .replace(
            "{ prismatic_drive = { name = \"slide\", axis = \"x\", stiffness_N_per_mm = 1e4 } }",
            "{ revolute_drive = { name = \"slide\", axis = \"y\", stiffness_Nmm_per_rad = 147150.0 } }, \
             { fixed = { translation_mm = [0.0, 0.0, 1000.0] } }",
        );
    let place = [0.0, 0.0, 1000.0];
    let wrench = [0.01, 0.0, 0.0, 0.0, 0.0, 0.0];
    let soft = "[[uncertainty.parameter]]\nname = \"guide.slide.stiffness\"\nrelative_std = STD\n";
    // It falls where its stiffness is below two thirds: at the 5 % quantile, if that is so uncertain.
    let few = cloud(&explorer("arm.toml", Some(&pendulum), &soft.replace("STD", "0.15")), place, wrench);
    assert!(few.p95.is_some() && few.reason.is_empty(), "{few:?}");
    let many = cloud(&explorer("arm.toml", Some(&pendulum), &soft.replace("STD", "0.3")), place, wrench);
    assert!(many.p95.is_none() && many.displacements.is_empty() && many.status != "solved");
    assert!(many.reason.contains("with guide.slide.stiffness at its 5 % quantile: "), "{}", many.reason);
    // A machine alone is as uncertain as its file says; this one says nothing.
    let alone = Explorer::open(Scene::from_machine("lever.toml", Some(LEVER.into()))).unwrap();
    assert!(cloud(&alone, [0.0; 3], [1.0; 6]).reason.contains("varies nothing"));
    assert!(cloud(&Explorer::open(Scene::from_machine("orthoglide", None)).unwrap(), [0.0; 3], [1.0; 6]).p95.is_some());
    // A study without the table takes its inputs as exact.
    let exact = explorer("lever.toml", Some(LEVER), "");
    assert!(exact.view().uncertain_by.is_none() && exact.cloud(&asked([0.0; 3], [0.0; 6])).is_err());
    assert!(!serde_json::to_string(&exact.view()).unwrap().contains("uncertain"));
}

/// The table may stand in the process as well.
#[test]
fn the_process_may_say_what_is_uncertain() {
    let text =
        study_text("kr270", &force(1.0, 0.0, 0.0), "", "[workspace_map]\nslices_z_mm = [1000.0]\ngrid = [1, 1, 1]");
    let of_process = "[process.uncertainty]\nmachine = \"exact\"\n[process.uncertainty.process]\nforce_relative_std = 0.15\n[process.uncertainty.model]\nrelative_std = 0.0\n";
    let text = text.replace("[workspace_map]", &format!("{of_process}[workspace_map]"));
    let study = Study::from_toml(&text, "study.toml", Folder::in_memory([]), &Overrides::default()).unwrap();
    let explorer = Explorer::open(Scene::from_study(&study).unwrap().unwrap()).unwrap();
    let found = cloud(&explorer, [1500.0, 0.0, 1000.0], [100.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let std = (0.5f64 * (1.0 + (1.0 + 4.0 * 0.15f64 * 0.15).sqrt())).ln().sqrt();
    let factor = found.p95.unwrap() / found.nominal.unwrap();
    assert!((factor / (std * normal_quantile(P95)).exp() - 1.0).abs() < 0.005, "{factor}");
}
