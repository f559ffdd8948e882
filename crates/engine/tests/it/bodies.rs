//! Bodies of machines: where their frames stand, and bounds on how fast their points move.

use kinetostat_cell::{Ball, Motion};
use kinetostat_engine::{
    Machine, Pose,
    machine::{Configuration, MachineMotion, catalogue},
    nalgebra::{Isometry3, Point3, Vector3},
    spatial::rotation_exp,
};
use proptest::{prelude::*, strategy::ValueTree};

/// The text of a machine file with a capsule on every frame behind a joint, and one on the platform.
fn with_bodies(text: &str) -> String {
    let moves = [
        "revolute_drive",
        "prismatic_drive",
        "revolute_joint",
        "prismatic_joint",
        "universal_joint",
        "spherical_joint",
        "parallelogram",
    ];
    let mut number = 0;
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        lines.push(line.into());
        if moves.iter().any(|own| line.contains(&format!("{{ {own} ="))) {
            number += 1;
            let shape = "capsule = { from_mm = [0.0, 0.0, 0.0], to_mm = [60.0, 20.0, 0.0], radius_mm = 40.0 }";
            lines.push(format!("  {{ body = {{ name = \"part {number}\", shapes = [{{ {shape} }}] }} }},"));
        }
    }
    let spindle = "[[platform.body]]\nname = \"spindle\"\ngrade = \"given\"\nshapes = [{ box = { size_mm = [80.0, 90.0, 200.0], at_mm = [0.0, 0.0, 60.0] } }]\n\n[home]";
    lines.join("\n").replacen("[home]", spindle, 1)
}

/// A machine of the tests or of the catalogue with bodies.
fn machine(name: &str) -> Machine {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../tests/machines/{name}.toml"));
    let text = match catalogue::find(name) {
        Some(entry) => entry.toml.to_owned(),
        None => std::fs::read_to_string(file).unwrap(),
    };
    Machine::from_toml(&with_bodies(&text), name).unwrap()
}

/// Machines of several kinds: arms, a rail that stands, hexapod, deltas, the Orthoglide, a hybrid.
const MACHINES: [&str; 8] =
    ["kr270", "fanuc_r2000ic", "ur5e", "coupled_6r", "hexapod", "orthoglide", "linear_delta", "rotary_delta"];

#[test]
fn bodies_stand_where_joints_are_drawn() {
    for name in MACHINES {
        let machine = machine(name);
        let at = &machine.home;
        let mut poses = Vec::new();
        machine.frame_poses(at, &mut poses);
        assert_eq!(poses.len(), machine.frame_count(), "{name}");
        assert!((poses[1].translation.vector - at.pose.translation).norm() < 1e-9);
        // The walk that draws is another one.
        let drawn: Vec<[f64; 3]> = machine
            .rigid_skeleton(at)
            .chains
            .iter()
            .flat_map(|chain| &chain.joints)
            .map(|joint| joint.position_mm)
            .collect();
        let mut seen = 0;
        for pose in &poses[3..] {
            let nearest =
                drawn.iter().map(|own| (Vector3::from(*own) - pose.translation.vector).norm()).fold(f64::MAX, f64::min);
            assert!(nearest < 1e-9, "{name}: {nearest}");
            seen += 1;
        }
        assert!(seen >= 3, "{name}");
        assert_eq!(machine.bodies().unwrap().len(), machine.listed_bodies().count());
    }
}

#[test]
fn a_body_needs_a_name_of_its_own_and_shapes_in_millimetres() {
    let text = with_bodies(catalogue::find("kr270").unwrap().toml);
    for (from, to, expected) in [
        ("\"part 2\"", "\"part 1\"", "chain[0].elements[5].body.name: \"part 1\" is used twice"),
        ("radius_mm = 40.0", "radius_mm = 0.0", "radius_mm: must be greater than 0, got 0"),
        ("radius_mm = 40.0", "radius_mm = 0.04", "from"),
        ("\"given\"", "\"measured\"", "unknown value `measured`"),
        (
            "size_mm = [80.0, 90.0, 200.0]",
            "size_mm = [0.08, 0.09, 0.2]",
            "platform.body[0].shapes[0].box: fits into a ball of 0.117 mm radius",
        ),
        ("shapes = [{ box", "shape = [{ box", "unknown"),
    ] {
        let result = Machine::from_toml(&text.replacen(from, to, 1), "kr270");
        if expected == "from" {
            // A rod of 0.08 mm is none that is known to be wrong.
            assert!(result.is_ok());
        } else {
            let said = result.unwrap_err().to_string();
            assert!(said.contains(expected), "{said}");
        }
    }
}

/// A configuration at a place of the workspace, turned by a vector of rotation if the machine controls that.
fn configuration(machine: &Machine, share: [f64; 3], turn: [f64; 3]) -> Option<Configuration> {
    let (low, high) = (machine.workspace.min, machine.workspace.max);
    let place = Vector3::from_fn(|i, _| low[i] + share[i] * (high[i] - low[i]));
    let mut pose = machine.pose_at(place);
    if machine.controls.len() == 6 {
        pose.rotation = rotation_exp(Vector3::from(turn)) * pose.rotation;
    }
    machine.inverse_kinematics(&pose).ok()
}

/// The largest speed between neighbours of many samples of a point in an interval, mm for each 1 of the parameter.
fn sampled_speed(
    motion: &mut MachineMotion<'_>,
    frame: usize,
    point: Point3<f64>,
    [from, to]: [f64; 2],
    count: usize,
) -> f64 {
    let mut poses = vec![Isometry3::identity(); count];
    let mut place = |k: usize| {
        let s = from + (to - from) * k as f64 / 16.0;
        motion.poses(s, &mut poses).unwrap();
        poses[frame] * point
    };
    let places: Vec<Point3<f64>> = (0..=16).map(&mut place).collect();
    let step = (to - from) / 16.0;
    places.windows(2).map(|pair| (pair[1] - pair[0]).norm() / step).fold(0.0, f64::max)
}

#[test]
fn no_point_of_a_body_is_faster_than_its_bound() {
    let mut rng = proptest::test_runner::TestRunner::deterministic();
    let unit = || proptest::array::uniform3(0.0f64..1.0);
    let mut draw = |strategy: &dyn Fn() -> proptest::array::UniformArrayStrategy<std::ops::Range<f64>, [f64; 3]>| {
        strategy().new_tree(&mut rng).unwrap().current()
    };
    let mut compared = 0;
    for name in MACHINES {
        let machine = machine(name);
        let frames = machine.frame_count();
        for round in 0..12 {
            let ends = [(); 2].map(|()| {
                let (share, turn) = (draw(&unit), draw(&unit).map(|x| 0.5 * (x - 0.5)));
                configuration(&machine, share, turn)
            });
            let [Some(from), Some(to)] = ends else { continue };
            let is_joint_move = round % 3 == 2 && machine.chains.len() == 1;
            let mut motion = if is_joint_move {
                MachineMotion::joints(&machine, &from, &to).unwrap()
            } else {
                MachineMotion::straight(&machine, &from, &to).unwrap()
            };
            let start = draw(&unit)[0] * 0.9;
            let ball = Ball { centre_mm: Point3::new(40.0, -30.0, 20.0), radius_mm: 50.0 };
            let direction = Vector3::from(draw(&unit).map(|x| x - 0.5)).normalize();
            for frame in 0..frames {
                for halvings in [3, 6, 9, 14] {
                    let interval = [start, start + 0.5f64.powi(halvings)];
                    if motion.configuration(start).is_err() || motion.configuration(interval[1]).is_err() {
                        continue;
                    }
                    let bound = motion.speed(frame, &ball, interval);
                    if !bound.is_finite() {
                        assert!(halvings < 14, "{name}, frame {frame}: no bound on an interval of {interval:?}");
                        continue;
                    }
                    for reach in [0.0, 1.0] {
                        let point = ball.centre_mm + direction * (ball.radius_mm * reach);
                        let speed = sampled_speed(&mut motion, frame, point, interval, frames);
                        assert!(
                            speed <= bound * (1.0 + 1e-7) + 1e-6,
                            "{name}, frame {frame}, {interval:?}: {speed} > {bound}"
                        );
                        compared += 1;
                        // A short interval leaves the speed of the ball's centre and its turning.
                        if halvings == 14 && reach == 0.0 {
                            let turning = (bound - speed) / ball.radius_mm;
                            assert!(turning < 20.0, "{name}, frame {frame}: {bound} of {speed}");
                        }
                    }
                }
            }
        }
    }
    assert!(compared > 2000, "{compared}");
}

#[test]
fn machines_without_a_bound_say_why() {
    for (name, expected) in [
        ("tricept", "the platform turns by itself as it moves"),
        ("kr270_rail", "coordinates, more than a pose takes"),
        ("nested", "has a module"),
    ] {
        let machine = machine(name);
        let said = MachineMotion::straight(&machine, &machine.home, &machine.home).unwrap_err();
        assert!(said.contains(expected), "{name}: {said}");
    }
    let hexapod = machine("hexapod");
    assert!(MachineMotion::joints(&hexapod, &hexapod.home, &hexapod.home).unwrap_err().contains("no arm of one chain"));
}

/// A pose of P as an isometry turns and moves points as the pose does.
#[test]
fn frames_turn_as_poses_do() {
    let machine = machine("kr270");
    let turned = rotation_exp(Vector3::new(0.2, -0.1, 0.3)) * machine.home.pose.rotation;
    let at = machine.inverse_kinematics(&Pose { rotation: turned, ..machine.home.pose }).unwrap();
    let mut poses = Vec::new();
    machine.frame_poses(&at, &mut poses);
    let point = Vector3::new(10.0, -20.0, 30.0);
    assert!(((poses[1] * Point3::from(point)).coords - at.pose.transform(point)).norm() < 1e-9);
}
