//! Drives commanded in what a pendant shows: the same arm with and without coupled coordinates stands, gives way and is
//! compensated in the same way, its drives mapped.

use crate::support::{
    engine::{EXACT, machine_from, motion_between, resettle, settle, stiffness_difference},
    machines::{places, share, some_errors, some_load},
};
use kinetostat::{
    compensation::{CompensationSettings, Method, Session, Target, TaskPoint, compensate},
    machine::{Machine, Unreachable},
    spatial::{Pose, Wrench, rotation_exp},
    statics::{Scratch, State, Status, drive_force_sensitivity, drive_forces},
};
use nalgebra::{DMatrix, DVector, Vector3};

/// The arm of `tests/machines/coupled_6r.toml`.
fn arm_text() -> String {
    let file = format!("{}/tests/machines/coupled_6r.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(file).unwrap()
}

const SHOWN: &str = ", shown = { of = { J2 = -1.0, J3 = -1.0 } }";
const J3: &str = "home_deg = -30.0, travel_deg = [-90.0, 40.0]";

fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replace(from, to)
}

/// The same arm commanded in the angles of its joints.
fn plain_text() -> String {
    replaced(&replaced(&arm_text(), SHOWN, ""), J3, "home_deg = 35.0")
}

/// An arm with shown coordinates, and what its joints are: `joint = per_shown · shown + offset`.
struct Pair {
    coupled: Machine,
    plain: Machine,
    per_shown: DMatrix<f64>,
    offset: DVector<f64>,
}

impl Pair {
    /// `shown`: rows of factors by which joints make the shown coordinates, and offsets in degrees.
    fn new(coupled: Machine, shown: [[f64; 6]; 6], offsets_deg: [f64; 6]) -> Self {
        let per_shown = DMatrix::from_fn(6, 6, |i, j| shown[i][j]).try_inverse().unwrap();
        let offset = -&per_shown * DVector::from_iterator(6, offsets_deg.into_iter().map(f64::to_radians));
        Self { coupled, plain: machine_from(&plain_text()), per_shown, offset }
    }

    /// `forces` (rows: drives) as the coupled arm has them: with the sign that each drive shows its own joint with.
    fn shown_signs(&self, mut forces: DMatrix<f64>) -> DMatrix<f64> {
        forces.row_iter_mut().enumerate().for_each(|(i, mut row)| row *= self.per_shown[(i, i)].signum());
        forces
    }

    fn shown_forces(&self, forces: &[f64]) -> Vec<f64> {
        self.shown_signs(DMatrix::from_column_slice(forces.len(), 1, forces)).as_slice().to_vec()
    }

    fn joints(&self, shown: &[f64]) -> Vec<f64> {
        (&self.per_shown * DVector::from_column_slice(shown) + &self.offset).as_slice().to_vec()
    }

    fn all() -> Vec<Self> {
        let identity = |i: usize| std::array::from_fn::<_, 6, _>(|j| if i == j { 1.0 } else { 0.0 });
        let plain: [[f64; 6]; 6] = std::array::from_fn(identity);
        let mut forearm = plain;
        forearm[2] = [0.0, -1.0, -1.0, 0.0, 0.0, 0.0];
        let as_made = Self::new(machine_from(&arm_text()), forearm, [0.0; 6]);
        // Every drive shows something else, by factors and offsets.
        let mut all = plain;
        all[0][0] = -1.0;
        all[2] = [0.0, -0.5, 2.0, 0.0, 0.0, 0.0];
        all[4] = [0.0, 0.0, 0.0, 0.25, -1.0, 0.0];
        all[5] = [0.1, 0.0, 0.0, 0.5, 1.0, 3.0];
        let offsets = [10.0, 0.0, 33.0, 0.0, -90.0, 180.0];
        let mut text = replaced(&arm_text(), SHOWN, ", shown = { of = { J2 = -0.5, J3 = 2.0 }, offset_deg = 33.0 }");
        text = replaced(&text, J3, "home_deg = 105.5");
        text =
            replaced(&text, "3.1e9 }", "3.1e9, home_deg = 10.0, shown = { of = { J1 = -1.0 }, offset_deg = 10.0 } }");
        text = replaced(
            &text,
            "home_deg = 30.0 }",
            "home_deg = -120.0, shown = { of = { J4 = 0.25, J5 = -1.0 }, offset_deg = -90.0 } }",
        );
        text = replaced(
            &text,
            "4e8 }",
            "4e8, home_deg = 210.0, shown = { of = { J1 = 0.1, J4 = 0.5, J5 = 1.0, J6 = 3.0 }, offset_deg = 180.0 } }",
        );
        vec![as_made, Self::new(machine_from(&text), all, offsets)]
    }
}

fn assert_near(what: &str, got: &[f64], expected: &[f64], allowed: f64) {
    assert_eq!(got.len(), expected.len(), "{what}");
    for (i, (a, b)) in got.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= allowed, "{what}[{i}]: {a} instead of {b}");
    }
}

#[test]
fn the_forearm_shows_its_angle_to_the_floor() {
    let machine = machine_from(&arm_text());
    let at = |shown: [f64; 6]| {
        let shown = shown.map(f64::to_radians);
        machine.forward_kinematics(&shown).unwrap().pose
    };
    let home = machine.home.drives.iter().map(|rho| rho.to_degrees()).collect::<Vec<_>>();
    let [a, b] = [-20.0, 40.0].map(|j2| at([home[0], j2, -25.0, home[3], home[4], home[5]]));
    // J2 alone moves the forearm without turning it.
    let turn = motion_between(&a, &b);
    assert!(turn.fixed_rows::<3>(3).amax() < 1e-12 && turn.fixed_rows::<3>(0).norm() > 500.0, "{turn}");
}

#[test]
fn commands_in_shown_coordinates_lead_where_the_joints_do() {
    for pair in Pair::all() {
        assert_near("home", &pair.joints(&pair.coupled.home.drives), &pair.plain.home.drives, 1e-12);
        for at in places(&pair.coupled, 8) {
            let there = pair.plain.forward_kinematics(&pair.joints(&at.drives)).unwrap();
            let off = motion_between(&there.pose, &at.pose).amax();
            assert!(off < 1e-9, "pose off by {off:e}");
        }
        for seed in 0..12 {
            let mut target = pair.plain.home.pose;
            target.translation += Vector3::from_fn(|i, _| 200.0 * share(seed, i));
            target.rotation *= rotation_exp(Vector3::from_fn(|i, _| 0.3 * share(seed, 3 + i)));
            let [coupled, plain] =
                [&pair.coupled, &pair.plain].map(|machine| machine.inverse_kinematics(&target).unwrap());
            assert_near("inverse kinematics", &pair.joints(&coupled.drives), &plain.drives, 1e-9);
            let [a, b] = [(&pair.coupled, coupled), (&pair.plain, plain)].map(|(m, at)| m.drive_jacobian(&at).unwrap());
            let off = (&pair.per_shown * &a - &b).amax();
            assert!(off < 1e-9 * b.amax(), "drive Jacobian off by {off:e}");
        }
    }
}

#[test]
fn a_coupled_arm_gives_way_as_one_that_is_not() {
    for pair in Pair::all() {
        for (seed, at) in places(&pair.coupled, 5).into_iter().enumerate() {
            let load = some_load(&pair.plain, 2000.0, seed);
            // Offsets are those of the joints.
            let errors = some_errors(&pair.plain, seed);
            let (coupled, plain) = (pair.coupled.with_errors(&errors), pair.plain.with_errors(&errors));
            let joints = pair.joints(&at.drives);
            let there = plain.home.clone();
            let there = pair.plain.forward_kinematics_from(&there, &joints).unwrap();
            let ((got, outcome), (expected, as_plain)) = (settle(&coupled, &at, &load), settle(&plain, &there, &load));
            assert_eq!((&outcome.status, &as_plain.status), (&Status::Solved, &Status::Solved));
            assert!(motion_between(&expected.pose, &got.pose).amax() < 1e-9);
            assert_near("deflections", &got.chains[0].coordinates, &expected.chains[0].coordinates, 1e-12);
            let off = stiffness_difference(&outcome.stiffness.unwrap(), &as_plain.stiffness.unwrap());
            assert!(off < 1e-9, "stiffness off by {off:e}");
            let mapped = &as_plain.drive_sensitivity * &pair.per_shown;
            let off = (&outcome.drive_sensitivity - &mapped).amax();
            assert!(off < 1e-9 * mapped.amax(), "drive sensitivity off by {off:e}");
            assert_near(
                "torques",
                &drive_forces(&coupled, &got),
                &pair.shown_forces(&drive_forces(&plain, &expected)),
                1e-2,
            );
            let by = |machine: &Machine, drives: &[f64], state: &State, outcome: &kinetostat::statics::Outcome| {
                let twists = &outcome.drive_sensitivity;
                drive_force_sensitivity(machine, drives, state, twists, &mut Scratch::new(machine)).unwrap()
            };
            let (a, b) = (by(&coupled, &at.drives, &got, &outcome), by(&plain, &joints, &expected, &as_plain));
            let mapped = pair.shown_signs(&b * &pair.per_shown);
            let off = (&a - &mapped).amax();
            assert!(off < 1e-8 * b.amax(), "force sensitivity off by {off:e}");
            let mut uncondensed = Scratch::uncondensed(&coupled);
            let a = drive_force_sensitivity(&coupled, &at.drives, &got, &outcome.drive_sensitivity, &mut uncondensed);
            let off = (a.unwrap() - &mapped).amax();
            assert!(off < 1e-8 * b.amax(), "force sensitivity without condensation off by {off:e}");
        }
    }
}

#[test]
fn a_drive_carries_what_works_where_its_shown_position_grows() {
    for name in ["kr270", "kr500", "orthoglide", "hexapod"] {
        let machine = Machine::named(name).unwrap().weightless();
        let load = some_load(&machine, 50.0, 1);
        let (state, outcome) = settle(&machine, &machine.home, &load);
        assert_eq!(outcome.status, Status::Solved);
        let work = |drive: usize| {
            let at = |step: f64| {
                let mut drives = machine.home.drives.clone();
                drives[drive] += step;
                machine.forward_kinematics_from(&machine.home, &drives).unwrap().pose
            };
            load.to_vector().dot(&motion_between(&at(-1e-4), &at(1e-4))) / 2e-4
        };
        let work: Vec<f64> = (0..machine.drive_count()).map(work).collect();
        let most = work.iter().fold(0.0, |most: f64, work| most.max(work.abs()));
        assert_near(name, &drive_forces(&machine, &state), &work, 0.02 * most);
    }
}

#[test]
fn a_coupled_arm_is_compensated_by_the_same_joints() {
    for pair in Pair::all() {
        let errors = some_errors(&pair.plain, 1);
        for seed in 0..3 {
            let mut pose = pair.plain.home.pose;
            pose.translation += Vector3::from_fn(|i, _| 150.0 * share(seed, i));
            let load = some_load(&pair.plain, 1500.0, seed);
            let task = TaskPoint::new(pose, load, Target::FullPose);
            for method in Method::ALL {
                let [coupled, plain] = [&pair.coupled, &pair.plain].map(|machine| {
                    let actual = machine.with_errors(&errors);
                    let mut session = Session::new(machine, &actual, CompensationSettings::default());
                    compensate(&mut session, &task, method)
                });
                assert_eq!(coupled.status, plain.status, "{}", method.label());
                let what = format!("{}: drives", method.label());
                assert_near(&what, &pair.joints(&coupled.drives), &plain.drives, 1e-8);
                assert_near("torques", &coupled.drive_forces, &pair.shown_forces(&plain.drive_forces), 1.0);
            }
        }
    }
}

#[test]
fn travel_is_that_of_what_is_shown() {
    let machine = machine_from(&arm_text());
    // The forearm level, and the upper arm leant back and forth: J3 stays within, its joint does not.
    let shown = [0.0, -40.0, 0.0, 0.0, 30.0, 0.0].map(f64::to_radians);
    let within = machine.forward_kinematics(&shown).unwrap();
    let at = machine.inverse_kinematics_from(&within, &within.pose).unwrap();
    assert_near("drives", &at.drives, &shown, 1e-10);
    let raised = [0.0, -20.0, 41.0, 0.0, 30.0, 0.0].map(f64::to_radians);
    let beyond = machine.forward_kinematics(&raised).unwrap();
    match machine.inverse_kinematics_from(&within, &beyond.pose) {
        Err(Unreachable::Travel { drive, value, high, .. }) => {
            assert_eq!(drive, "J3");
            assert!((value - 41.0).abs() < 1e-6 && (high - 40.0).abs() < 1e-9, "{value} of {high}");
        }
        other => panic!("{other:?}"),
    }
    let limits = machine.skeleton(&[chain_values(&machine, &raised)], &beyond.pose);
    let mark = limits.chains[0].joints.iter().find(|joint| joint.name == "J3").unwrap();
    assert!((mark.value - 41.0).abs() < 1e-9, "{mark:?}");
}

fn chain_values(machine: &Machine, drives: &[f64]) -> Vec<f64> {
    crate::support::balance::joint_values(&machine.chains[0], drives, &vec![0.0; machine.chains[0].coordinate_count()])
}

/// A full turn of what is shown is none of the joint where a gear is between them.
#[test]
fn a_geared_joint_is_not_taken_a_full_turn_of_what_is_shown() {
    for (factor, travel) in [(4.0, "[-100.0, 300.0]"), (2.0, "[-400.0, 100.0]"), (0.5, "[-100.0, 100.0]")] {
        // At home J6 stands at 0; shown coordinates far from where home is looked for.
        let text = replaced(
            &arm_text(),
            "4e8 }",
            &format!(
                "4e8, home_deg = 20.0, travel_deg = {travel}, shown = {{ of = {{ J6 = {factor:?} }}, offset_deg = 230.0 }} }}"
            ),
        );
        let Ok(machine) = Machine::from_toml(&text, "geared") else { continue };
        let plain = machine_from(&plain_text());
        let off = motion_between(&plain.home.pose, &machine.home.pose).amax();
        let stands = machine.forward_kinematics(&machine.home.drives).unwrap();
        assert!(off < 1e-9 && motion_between(&stands.pose, &machine.home.pose).amax() < 1e-9, "factor {factor}");
        let mut state = State::rigid(&machine.weightless(), &machine.home);
        let outcome = resettle(&machine.weightless(), &machine.home.drives, &Wrench::zero(), &mut state);
        assert_eq!((outcome.status, outcome.iterations), (Status::Solved, 0), "factor {factor}: home is not closed");
        for angle in [-2.9f64, -1.0, 0.5, 2.0, 3.0] {
            let mut target = plain.home.pose;
            target.rotation *= rotation_exp(Vector3::z() * angle);
            let Ok(at) = machine.inverse_kinematics(&target) else { continue };
            let mut closed = State::rigid(&machine.weightless(), &at);
            let drives = &at.drives;
            let outcome = resettle(&machine.weightless(), drives, &Wrench::zero(), &mut closed);
            assert_eq!((outcome.status, outcome.iterations), (Status::Solved, 0), "factor {factor}, {angle} rad");
            let off = motion_between(&target, &at.pose).amax();
            assert!(off < 1e-9, "factor {factor}, {angle} rad: off by {off:e}");
        }
    }
}

/// Behind the arm, where the straight line from home does not lead.
#[test]
fn an_arm_turned_round_is_reached_whatever_way_its_first_hinge_counts() {
    let plain = machine_from(&plain_text());
    for first in ["J1 = -1.0", "J1 = 0.5", "J1 = -2.0"] {
        let text = replaced(&plain_text(), "3.1e9 }", &format!("3.1e9, shown = {{ of = {{ {first} }} }} }}"));
        let coupled = machine_from(&text);
        for degrees in [100.0f64, 140.0, 170.0, -160.0] {
            let turn = Pose::from_rotation_vector(Vector3::z() * degrees.to_radians());
            let target = turn.compose(&plain.home.pose);
            let expected = plain.inverse_kinematics(&target);
            assert!(expected.is_ok(), "{degrees}: {expected:?}");
            let got = coupled.inverse_kinematics(&target).unwrap_or_else(|e| panic!("{first}, {degrees}°: {e}"));
            let stands = coupled.forward_kinematics_from(&got, &got.drives).unwrap();
            assert!(motion_between(&target, &stands.pose).amax() < 1e-8, "{first}, {degrees}°");
        }
    }
}

/// A design mounted twice in a module, whose drives show each other.
#[test]
fn drives_of_a_module_know_each_other_by_the_names_of_their_design() {
    let text = r#"
schema = 1
name = "twins"
title = "two arms that hold one bar"
platform = { tool_tip_mm = [0.0, 0.0, 50.0], controls = ["x"] }
home = { position_mm = [0.0, 0.0, 0.0] }
workspace = { min_mm = [0.0, 0.0, 0.0], max_mm = [0.0, 0.0, 0.0] }
[material.steel]
youngs_modulus_N_per_mm2 = 210000.0
shear_modulus_N_per_mm2 = 81000.0
[[chain]]
name = "side"
elements = [
  { revolute_drive = { name = "a", axis = "z", stiffness_Nmm_per_rad = 1e8 } },
  { beam = { length_mm = 200.0, section = { round = { diameter_mm = 20.0 } }, material = "steel" } },
  { revolute_drive = { name = "b", axis = "z", stiffness_Nmm_per_rad = 1e8, shown = { of = { a = 1.0, b = 1.0 } } } },
  { beam = { length_mm = 200.0, section = { round = { diameter_mm = 20.0 } }, material = "steel" } },
]
[[chain]]
name = "both"
elements = [ { module = { mounts = [
  { name = "left", chain = "side", base = { position_mm = [-400.0, 0.0, 0.0] } },
  { name = "right", chain = "side", base = { position_mm = [400.0, 0.0, 0.0], rotation_deg = [0.0, 0.0, 180.0] }, platform = { rotation_deg = [0.0, 0.0, 180.0] } },
] } } ]
[[mount]]
name = "both"
chain = "both"
"#;
    let machine = machine_from(text);
    let coupling = machine.chains[0].coupling.as_ref().unwrap();
    for (first, second) in [(0, 1), (2, 3)] {
        assert_eq!((coupling.per_shown[(second, first)], coupling.per_shown[(second, second)]), (-1.0, 1.0));
    }
    let (_, outcome) = settle(&machine, &machine.home, &Wrench::new([10.0, 20.0, 30.0, 0.0, 0.0, 0.0]));
    assert_eq!(outcome.status, Status::Solved);
    assert!(outcome.residual < EXACT.tolerance * 1e3);
}
