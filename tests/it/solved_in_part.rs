//! Answers that rest on part of the rows, and machines larger than those the tolerances were first chosen for.

use std::path::Path;

use kinetostat::{
    files::exchange::Cell,
    machine::Machine,
    questions::{
        Overrides, Study, StudyKind,
        map::{
            MapPoint, WorkspaceMap, WorkspaceMapStudy,
            report::{Summary, table, text},
            run,
        },
    },
    simulation::Source,
    spatial::Grid,
    work::Work,
};
use nalgebra::Vector3;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

/// A map of the six-axis arm.
fn arm(force_n: f64, compensate: &str) -> WorkspaceMapStudy {
    let text = format!(
        "schema = 3\nquestion = \"?\"\nmachine = \"tests/machines/kr270.toml\"\n\
         [process.force.path_frame]\nradial_force_N = {force_n}\ntangential_force_N = -10.0\naxial_force_N = -25.0\nlaw = \"rotated\"\n\
         [process.compensate]\ntarget = \"{compensate}\"\n[[process.chain_error]]\nchain = \"robot\"\nturn_about_drive_axis_deg = 1.0\n\
         [workspace_map]\ngrid = [3, 3, 3]\nphi_step_deg = 30.0\nslices_z_mm = [1000.0]\n"
    );
    match Study::from_toml(&text, "study.toml", Path::new(FOLDER), &Overrides::default()).unwrap().kind {
        StudyKind::WorkspaceMap(study, _) => *study,
        other => panic!("{other:?}"),
    }
}

fn summary(map: &WorkspaceMap) -> Summary<'_> {
    let mut summary = Summary::new(&map.study);
    map.points.iter().for_each(|point| summary.add(point));
    summary
}

#[test]
fn putting_right_part_of_what_an_arm_controls_is_solved_wherever_the_whole_is() {
    let maps = ["tool_tip", "full_pose"].map(|target| run(&arm(215.0, target), &Work::default()).unwrap());
    for (tip, pose) in maps[0].points.iter().zip(&maps[1].points) {
        for &source in tip.effects.sources() {
            assert_eq!([tip.status(source), pose.status(source)], ["solved"; 2], "{:?} {source:?}", tip.position_mm);
            let deflection = |point: &MapPoint| point.effect(source).unwrap().deflection_mm;
            assert_eq!(deflection(tip), deflection(pose));
        }
    }
}

#[test]
fn a_deflection_is_shown_where_its_correction_is_not() {
    let mut study = arm(215.0, "tool_tip");
    // Straight ahead, the first drive stands at 0 and must go to -1 deg; on the right, it cannot go at all.
    let file = Path::new(FOLDER).join("tests/machines/kr270.toml");
    let arm = std::fs::read_to_string(file).unwrap().replace("[-185.0, 185.0]", "[-0.5, 60.0]");
    study.load_case.machine = Machine::from_toml(&arm, "kr270.toml").unwrap();
    let map = run(&study, &Work::default()).unwrap();
    for point in &map.points {
        let ahead = point.position_mm[1] == 0.0;
        let expected = match (point.position_mm[1], ahead) {
            (y, _) if y < 0.0 => ["unreachable"; 3],
            (_, true) => ["solved", "unreachable", "unreachable"],
            _ => ["solved"; 3],
        };
        assert_eq!(
            Source::of(&map.study.load_case.machine).iter().map(|source| point.status(*source)).collect::<Vec<_>>(),
            expected,
            "{:?}",
            point.position_mm
        );
        assert_eq!(point.effect(Source::All).is_some(), point.position_mm[1] >= 0.0);
    }
    let table = table(&study, &map.points);
    let column = |name: &str| table.columns().iter().position(|column| column.name == name).unwrap();
    let known = |row: &Vec<Cell>, name: &str| row[column(name)] != Cell::Missing;
    let correction = format!("delta_rho_{}_deg", study.load_case.machine.drive_labels()[0]);
    let (mut whole, mut in_part) = (0, 0);
    for row in table.rows() {
        let has = |name: &str| known(row, name);
        assert_eq!(has("deflection_mm"), row[column("status")] == Cell::from("solved"));
        assert_eq!(has(&correction), row[column("correction_status")] == Cell::from("solved"));
        assert_eq!(has("correction_reason"), !has(&correction));
        assert_eq!(has("reason"), !has("deflection_mm"));
        whole += usize::from(has(&correction));
        in_part += usize::from(has("deflection_mm") && !has(&correction));
    }
    // Of 9 points on each side and ahead.
    assert_eq!((whole, in_part), (9 + 27, 18));
    let (said, json) = (text(&summary(&map), &[]).cautions, summary(&map).json());
    assert!(said.contains("At 18 rows the correction is missing; the deflection is known."), "{said}");
    assert_eq!((json["rows"].as_u64(), json["rows_solved"].as_u64()), (Some(81), Some(36)));
}

#[test]
fn what_is_known_at_hardly_any_point_has_no_best_and_worst() {
    let mut study = arm(215.0, "tool_tip");
    // One point in reach of 125.
    study.grid = Grid::new(Vector3::new(1600.0, 0.0, 1000.0), Vector3::new(9000.0, 8000.0, 9000.0), [5, 5, 5]);
    let map = run(&study, &Work::default()).unwrap();
    let said = text(&summary(&map), &[]).details();
    let known = map.points.iter().filter(|point| point.effect(Source::All).is_some()).count();
    assert!((1..=6).contains(&known), "{known}");
    assert!(!said.contains("at the best place"), "{said}");
    assert!(said.contains(&format!("known at {known} of 125 grid points, too few")), "{said}");
}
