//! Redundancy maps, held against equilibria of single tasks on the branches.

use std::path::Path;

use kinetostat::{
    compensation::{Method, Target, TaskPoint, compensate},
    process::{Placement, cutting::PathFrame},
    questions::{
        Overrides, Study, StudyKind,
        redundancy_map::{AtGamma, RedundancyMap, RedundancyMapPoint, RedundancyMapStudy, run},
    },
    simulation::{Machines, Source},
    spatial::{frame_about, rotation_exp},
    toolpath::Orientation,
    work::Work,
};
use nalgebra::Vector3;

use crate::support::command::told;

fn study(machine: &str, table: &str) -> RedundancyMapStudy {
    let text = format!(
        "schema = 3\nquestion = \"?\"\nmachine = \"{machine}\"\n[process.force.path_frame]\nradial_force_N = 300.0\n\
         tangential_force_N = -200.0\naxial_force_N = -100.0\n[redundancy_map]\n{table}\n"
    );
    let study = Study::from_toml(&text, "study.toml", Path::new("."), &Overrides::default()).unwrap();
    let StudyKind::RedundancyMap(study, _) = study.kind else { panic!("a redundancy map") };
    *study
}

fn map(study: &RedundancyMapStudy) -> RedundancyMap {
    run(study, &Work::default()).unwrap()
}

/// The largest deflection over the directions of the force with the platform turned so, by the machine tracked there on its own.
fn alone(study: &RedundancyMapStudy, point: &RedundancyMapPoint, at: &AtGamma) -> f64 {
    let case = &study.load_case;
    let machine = at.branch.map_or_else(|| case.machine.clone(), |branch| case.machine.on_branch(branch).unwrap());
    let machines = Machines::new(&machine, &case.errors).unwrap();
    let axis = study.axes[point.axis];
    let placed = Placement::default().on_machine(&case.machine.home.pose.rotation, &case.machine.tool());
    let placed = placed.with_tool_orientation(&Orientation::ToolAxis(axis));
    let turned = rotation_exp(-axis * at.gamma_deg.to_radians()) * placed.orientation();
    let placed = placed.with_platform_rotation(&turned);
    let pose = placed.platform_pose(point.position_mm.into());
    assert!((pose.rotation * machine.tool_axes.column(2) + axis).norm() < 1e-9);
    let deflection = |phi: f64| {
        let force = frame_about(-axis) * PathFrame { force: case.force }.force.force(phi);
        let load = placed.wrench(&kinetostat::toolpath::Load { force_N: force, moment_Nmm: Vector3::zeros() });
        let task = TaskPoint::new(pose, load, Target::ToolTip);
        let mut session = machines.session(Source::All);
        compensate(&mut session, &task, Method::None).position_error.norm()
    };
    case.phis.iter().map(|phi| deflection(*phi)).fold(0.0, f64::max)
}

#[test]
fn best_and_worst_turns_are_what_the_machine_does_there() {
    for (machine, table) in [
        (
            "fanuc_r2000ic",
            "grid = [2, 1, 2]\ntool_axes = [[0.0, 0.0, 1.0], [-0.5, 0.2, 0.8]]\ngamma_step_deg = 60.0\nslices_z_mm = [700.0]",
        ),
        (
            "hexapod",
            "grid = [1, 2, 1]\ngamma_step_deg = 90.0\nmin_mm = [0.0, -20.0, 880.0]\nmax_mm = [0.0, 20.0, 880.0]\nslices_z_mm = [880.0]",
        ),
    ] {
        let study = study(machine, table);
        let map = map(&study);
        assert_eq!(map.points.len(), study.grid.len() * study.axes.len());
        assert!(map.points.iter().filter(|point| point.gammas.is_ok()).count() * 2 > map.points.len(), "{machine}");
        for point in &map.points {
            let Ok(gammas) = &point.gammas else { continue };
            assert!(gammas.best.deflection_mm <= gammas.worst.deflection_mm && gammas.possible <= study.gamma_count());
            for at in [&gammas.best, &gammas.worst] {
                let found = alone(&study, point, at);
                assert!((found - at.deflection_mm).abs() < 1e-6, "{machine} {found} {at:?}");
            }
        }
    }
}

#[test]
fn a_place_without_a_turn_says_what_hinders() {
    let table = "grid = [1, 1, 2]\ngamma_step_deg = 90.0\nmin_mm = [2000.0, 0.0, 700.0]\nmax_mm = [2000.0, 0.0, 9000.0]\nslices_z_mm = [700.0]";
    let study = study("fanuc_r2000ic", table);
    let map = map(&study);
    assert!(map.points[0].gammas.is_ok());
    let failure = map.points[1].gammas.as_ref().unwrap_err();
    assert_eq!(failure.status, "unreachable");
    assert_eq!(failure.reason, "none of 4 values of γ is possible on any branch: 8 out of reach");
}

#[test]
fn a_map_of_turns_is_a_study_with_tables_pictures_and_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().display().to_string();
    assert_eq!(told(&["new", "redundancy", &format!("{place}/t")]).0, Some(0));
    let run =
        |extra: &[&str]| told(&[&["run", &format!("{place}/t"), "--out", &format!("{place}/out")], extra].concat());
    let (code, text, said) = run(&["--grid", "2", "--no-figures"]);
    assert!(matches!(code, Some(0 | 1)), "{text}{said}");
    assert!(text.contains("At the best rotation γ about its axis, the tool of fanuc_r2000ic moves by"), "{text}");
    let table = std::fs::read_to_string(format!("{place}/out/redundancy_map.csv")).unwrap();
    // Two directions and the worst of them, at eight places.
    assert_eq!(table.lines().count(), 1 + 3 * 8);
    assert!(table.starts_with("x_mm,y_mm,z_mm,direction,tool_axis_x,"));
    // "From … to … over all grid points and directions" and the share within tolerance are counted over the same.
    let text = std::fs::read_to_string(format!("{place}/t/study.toml")).unwrap();
    std::fs::write(
        format!("{place}/t/study.toml"),
        text.replacen("# process.tolerance_mm = 0.5", "process.tolerance_mm = 1.9", 1),
    )
    .unwrap();
    let (code, said, faults) = run(&["--grid", "2", "--no-figures", "--restart"]);
    assert!(matches!(code, Some(0 | 1)), "{said}{faults}");
    // x, y, z, "direction", its three components, status, reason, best; the rows of the worst direction have no quotes.
    let best = |line: &str| line.split('"').nth(2).and_then(|rest| rest.split(',').nth(6)?.parse::<f64>().ok());
    assert_eq!(table.lines().filter(|line| line.contains('"')).count(), 16);
    let within = table.lines().filter_map(best).filter(|mm| *mm <= 1.9).count();
    assert!((1..16).contains(&within), "{within}");
    let summary: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(format!("{place}/out/summary.json")).unwrap()).unwrap();
    let share = summary["share_within_tolerance"].as_f64().unwrap();
    assert!((share - within as f64 / 16.0).abs() < 1e-12, "{share} of {within}\n{table}");
    assert!(said.replace('\n', " ").contains("over all grid points and directions"), "{said}");
    std::fs::write(format!("{place}/t/study.toml"), &text).unwrap();
    for (given, wrong, expected) in [
        ("\"fanuc_r2000ic\"", "\"orthoglide\"", "machine orthoglide controls 3 coordinates"),
        ("[-0.5, 0.0, 0.866]", "[0.0, 0.0, 0.0]", "redundancy_map.tool_axes[1]: has no length: expected a direction"),
        (
            "gamma_step_deg = 15.0",
            "gamma_step_deg = 0.5",
            "redundancy_map.gamma_step_deg: must be from 1 to 180, got 0.5",
        ),
        ("# cone =", "cone =", "redundancy_map.cone: give one of tool_axes and cone"),
        ("slices_z_mm = [700.0]", "slices_z_mm = [7000.0]", "redundancy_map.slices_z_mm: must be within the map's box"),
    ] {
        assert!(text.contains(given), "{given}");
        std::fs::write(format!("{place}/t/study.toml"), text.replacen(given, wrong, 1)).unwrap();
        let (code, _, said) = run(&["--grid", "2", "--no-figures", "--restart"]);
        assert_eq!(code, Some(2), "{said}");
        assert!(said.replace('\n', " ").contains(expected), "{said}");
    }
}

#[test]
fn threads_change_nothing() {
    let table = "grid = [2, 1, 1]\ngamma_step_deg = 45.0\nslices_z_mm = [700.0]";
    let study = study("kr270", &table.replace("700.0", "500.0"));
    let on = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| map(&study).points)
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_cone_has_its_middle_and_directions_all_around_it() {
    let cone = "grid = [2, 2, 1]\nslices_z_mm = [700.0]\ncone = { about = [0.0, 0.0, 2.0], half_angle_deg = 30.0, around = 4 }";
    let axes = study("fanuc_r2000ic", cone).axes;
    assert_eq!(axes.len(), 5);
    assert_eq!(axes[0], Vector3::z());
    assert!(axes[1..].iter().all(|axis| (axis.angle(&Vector3::z()).to_degrees() - 30.0).abs() < 1e-9));
    assert!((axes[1..].iter().sum::<Vector3<f64>>().xy()).norm() < 1e-12);
}
