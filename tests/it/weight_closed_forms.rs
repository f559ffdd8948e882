//! Weight, springs between points and modules simple enough for a formula: pendulum, counterweight, balanced arms, flexure.

use crate::support::{
    engine::*,
    planar::{Leg, machine},
};
use kinetostat::{
    machine::Machine,
    spatial::{Pose, Wrench, skew},
    statics::{Outcome, Scratch, State, Status, drive_force_sensitivity, drive_forces, equilibrium, weight_energy},
};
use nalgebra::{Matrix6, Vector3};

/// Of gravity where a machine file says nothing, N/kg.
const G: f64 = 9.81;

fn loaded(machine: &Machine, drives: &[f64], load: &Wrench) -> (State, Outcome) {
    let at = machine.forward_kinematics(drives).unwrap();
    settle(machine, &at, load)
}

fn near(what: &str, got: f64, expected: f64, allowed: f64) {
    assert!((got - expected).abs() <= allowed, "{what}: {got} instead of {expected}");
}

// ---- pendulum -------------------------------------------------------------------------------------------------------

const MASS_KG: f64 = 12.0;
const LENGTH_MM: f64 = 400.0;

/// A slide along y and a free revolute joint about it, a mass below or above.
fn pendulum(below: f64) -> Machine {
    let slide = r#"{ prismatic_drive = { name = "slide", axis = "y", stiffness_N_per_mm = 1e4 } }"#;
    let revolute = r#"{ revolute_joint = { name = "hinge", axis = "y" } }"#;
    let mass = format!("{{ mass = {{ kg = {MASS_KG:?}, at_mm = [0.0, 0.0, {:?}] }} }}", -below);
    machine("pendulum", [0.0; 3], r#""y""#, &[Leg::new("pendulum", &[slide, revolute, &mass], "")])
}

#[test]
fn a_pendulum_is_held_by_its_weight() {
    let machine = pendulum(LENGTH_MM);
    let largest = MASS_KG * G * LENGTH_MM;
    for scratch in [Scratch::new(&machine), Scratch::uncondensed(&machine)] {
        let mut scratch = scratch;
        for share in [0.0, 1e-3, 0.3, -0.6] {
            let load = Wrench::new([0.0, 0.0, 0.0, 0.0, share * largest, 0.0]);
            let mut state = State::rigid(&machine, &machine.home);
            let drives = &machine.home.drives;
            let outcome = equilibrium(&machine, drives, &load, &mut state, &mut scratch, &EXACT);
            assert_eq!(outcome.status, Status::Solved, "{share}: {outcome:?}");
            let angle = share.asin();
            let turn = motion_between(&machine.home.pose, &state.pose);
            near("angle", turn[4], angle, 1e-10);
            let compliance = outcome.compliance.unwrap();
            near("compliance", compliance[(4, 4)] * largest, 1.0 / angle.cos(), 1e-8);
            near("slide", compliance[(1, 1)], 1e-4, 1e-12);
            assert!(outcome.stiffness.is_none(), "the platform is rigid in four directions");
        }
    }
}

#[test]
fn a_pendulum_does_not_stand_on_its_head() {
    let machine = pendulum(-LENGTH_MM);
    let (_, outcome) = settle(&machine, &machine.home, &Wrench::zero());
    assert!(!matches!(outcome.status, Status::Solved), "{:?}", outcome.status);
}

#[test]
fn weight_energy_of_a_pendulum_is_its_height() {
    let machine = pendulum(LENGTH_MM);
    let mut state = State::rigid(&machine, &machine.home);
    for angle in [0.0f64, 0.4, -1.0] {
        state.chains[0].coordinates[1] = angle;
        let energy = weight_energy(&machine, &[0.0], &state);
        near("energy", energy, -MASS_KG * G * LENGTH_MM * angle.cos(), 1e-9);
    }
}

// ---- springs between points -----------------------------------------------------------------------------------------

/// A slide along x with the end of a spring, the other end at (x, y); `spring`: stiffness, free length, preload.
fn slide([x, y]: [f64; 2], [stiffness, free, preload]: [f64; 3]) -> Machine {
    let slide = r#"{ prismatic_drive = { name = "slide", axis = "x", stiffness_N_per_mm = 100.0 } }"#;
    let spring = format!(
        r#"{{ spring = {{ from = {{ frame = "end" }}, to = {{ frame = "O", at_mm = [{x:?}, {y:?}, 0.0] }}, stiffness_N_per_mm = {stiffness:?}, free_length_mm = {free:?}, preload_N = {preload:?} }} }}"#
    );
    machine("slide", [0.0; 3], r#""x""#, &[Leg::new("slide", &[slide, r#"{ frame = "end" }"#, &spring], "")])
}

#[test]
fn a_preloaded_spring_pulls_by_its_law() {
    for law in [[40.0, 60.0, 0.0], [40.0, 60.0, 700.0], [40.0, 90.0, -300.0], [25.0, 0.0, 0.0], [25.0, 0.0, 300.0]] {
        let [stiffness, free, preload] = law;
        let machine = slide([0.0, 50.0], law);
        for drive in [-120.0, -20.0, 35.0, 90.0] {
            let (state, outcome) = loaded(&machine, &[drive], &Wrench::zero());
            assert_eq!(outcome.status, Status::Solved, "{law:?} at {drive}");
            let x = state.pose.translation.x;
            let length = x.hypot(50.0);
            let tension = preload + stiffness * (length - free);
            near("balance", 100.0 * (x - drive), -tension * x / length, 1e-7);
            let along = x / length;
            let expected = 100.0 + stiffness * along * along + tension / length * (1.0 - along * along);
            near("compliance", outcome.compliance.unwrap()[(0, 0)] * expected, 1.0, 1e-8);
            near("sensitivity", outcome.drive_sensitivity[(0, 0)], 100.0 / expected, 1e-8);
        }
    }
}

/// Where the ends of a spring meet, its direction is not determined; one without a free length has no force there.
#[test]
fn a_spring_of_free_length_zero_may_have_its_ends_meet() {
    let machine = slide([0.0, 0.0], [25.0, 0.0, 0.0]);
    for drive in [0.0, 8.0, -3.0] {
        let (state, outcome) = loaded(&machine, &[drive], &Wrench::zero());
        assert_eq!(outcome.status, Status::Solved, "{drive}");
        near("place", state.pose.translation.x, drive * 0.8, 1e-9);
        near("compliance", outcome.compliance.unwrap()[(0, 0)], 1.0 / 125.0, 1e-9);
    }
    // A string pulled taut by 5 N has no equilibrium that could be named where its ends meet, and is no panic.
    let taut = slide([3.0, 0.0], [25.0, 0.0, 5.0]);
    let (_, outcome) = loaded(&taut, &[3.0], &Wrench::zero());
    assert!(!outcome.is_equilibrium(), "{:?}", outcome.status);
    let (state, outcome) = loaded(&taut, &[11.0], &Wrench::zero());
    assert_eq!(outcome.status, Status::Solved);
    near("place", state.pose.translation.x, (1100.0 + 75.0 - 5.0) / 125.0, 1e-9);
}

#[test]
fn a_mass_hangs_on_a_spring_by_its_weight() {
    let slide = r#"{ prismatic_drive = { name = "slide", axis = "x", stiffness_N_per_mm = 1e4 } }"#;
    let joint = r#"{ prismatic_joint = { name = "weight", axis = "z", home_mm = -200.0 } }"#;
    let mass = r#"{ mass = { kg = 30.0 } }"#;
    let spring = r#"{ spring = { from = { frame = "top" }, to = { frame = "weight" }, stiffness_N_per_mm = 6.0, free_length_mm = 180.0, preload_N = 20.0 } }"#;
    let elements = [slide, r#"{ frame = "top" }"#, joint, r#"{ frame = "weight" }"#, mass, spring];
    let machine = machine("weight", [0.0, 0.0, -200.0], r#""x""#, &[Leg::new("weight", &elements, "")]);
    let (state, outcome) = settle(&machine, &machine.home, &Wrench::zero());
    assert_eq!(outcome.status, Status::Solved);
    near("height", state.pose.translation.z, -(180.0 + (30.0 * G - 20.0) / 6.0), 1e-9);
    near("compliance", outcome.compliance.unwrap()[(2, 2)], 1.0 / 6.0, 1e-10);
}

// ---- balanced arms --------------------------------------------------------------------------------------------------

/// Stiffness of the drives of arms, N·mm/rad.
const DRIVE: f64 = 1e8;

/// An arm about y, `drive` its revolute joint, with what hangs on it.
fn arm(revolute: &str, hung: &[&str]) -> Machine {
    let slide = r#"{ prismatic_drive = { name = "slide", axis = "y", stiffness_N_per_mm = 1e4 } }"#;
    let mut elements = vec![slide, revolute, r#"{ frame = "arm" }"#];
    elements.extend(hung);
    let controls = if revolute.contains("drive") { r#""y", "rotation_y""# } else { r#""y""# };
    machine("arm", [0.0; 3], controls, &[Leg::new("arm", &elements, "")])
}

fn driven() -> String {
    format!(r#"{{ revolute_drive = {{ name = "arm", axis = "y", stiffness_Nmm_per_rad = {DRIVE:e} }} }}"#)
}

const FREE: &str = r#"{ revolute_joint = { name = "arm", axis = "y" } }"#;
const ARM_MASS: &str = r#"{ mass = { kg = 40.0, at_mm = [0.0, 0.0, 700.0] } }"#;
const COUNTERWEIGHT: &str = r#"{ mass = { kg = 112.0, at_mm = [0.0, 0.0, -250.0] } }"#;

/// k a h = m g L with a = 200 mm on the arm and h = 300 mm above the revolute joint.
fn zero_length_spring() -> String {
    let stiffness = 40.0 * G * 700.0 / (200.0 * 300.0);
    format!(
        r#"{{ spring = {{ from = {{ frame = "O", at_mm = [0.0, 0.0, 300.0] }}, to = {{ frame = "arm", at_mm = [0.0, 0.0, 200.0] }}, stiffness_N_per_mm = {stiffness:?}, free_length_mm = 0.0 }} }}"#
    )
}

#[test]
fn an_arm_without_balance_loads_its_drive_by_its_weight() {
    let machine = arm(&driven(), &[ARM_MASS]);
    let torque = 40.0 * G * 700.0;
    for angle in [0.0f64, 0.5, 1.5, 3.0, -2.0] {
        let (state, outcome) = loaded(&machine, &[0.0, angle], &Wrench::zero());
        assert_eq!(outcome.status, Status::Solved, "{angle}");
        let at = angle + state.chains[0].coordinates[1];
        near("torque", drive_forces(&machine, &state)[1], torque * at.sin(), 1e-4);
        let stiffness = DRIVE - torque * at.cos();
        near("sensitivity", outcome.drive_sensitivity[(4, 1)], DRIVE / stiffness, 1e-9);
        let twists = &outcome.drive_sensitivity;
        let mut scratch = Scratch::new(&machine);
        let forces = drive_force_sensitivity(&machine, &[0.0, angle], &state, twists, &mut scratch).unwrap();
        near("force sensitivity", forces[(1, 1)] / DRIVE, DRIVE / stiffness - 1.0, 1e-9);
    }
}

#[test]
fn counterweights_and_springs_of_free_length_zero_balance_an_arm_at_all_angles() {
    let spring = zero_length_spring();
    for hung in [[ARM_MASS, COUNTERWEIGHT], [ARM_MASS, &spring]] {
        let machine = arm(&driven(), &hung);
        for i in 0..24 {
            let angle = 0.26 * f64::from(i) - 3.0;
            let (state, outcome) = loaded(&machine, &[0.0, angle], &Wrench::zero());
            assert_eq!(outcome.status, Status::Solved, "{angle}");
            near("torque", drive_forces(&machine, &state)[1], 0.0, 1e-6);
            near("sensitivity", outcome.drive_sensitivity[(4, 1)], 1.0, 1e-11);
        }
        // Nothing holds the arm on a free revolute joint, and nothing moves it.
        let machine = arm(FREE, &hung);
        for angle in [0.0f64, 0.7, 2.5] {
            let mut state = State::rigid(&machine, &machine.home);
            state.pose = Pose::from_rotation_vector(Vector3::y() * angle);
            state.chains[0].coordinates[1] = angle;
            let before = state.clone();
            let outcome = resettle(&machine, &machine.home.drives, &Wrench::zero(), &mut state);
            assert!(matches!(outcome.status, Status::Singular | Status::SingularPlace), "{angle}: {outcome:?}");
            assert!(motion_between(&before.pose, &state.pose).amax() < 1e-9);
        }
    }
}

/// The ends of the spring meet where the arm stands upright.
#[test]
fn a_spring_balances_an_arm_through_where_its_ends_meet() {
    let stiffness = 40.0 * G * 700.0 / (250.0 * 250.0);
    let spring = format!(
        r#"{{ spring = {{ from = {{ frame = "O", at_mm = [0.0, 0.0, 250.0] }}, to = {{ frame = "arm", at_mm = [0.0, 0.0, 250.0] }}, stiffness_N_per_mm = {stiffness:?}, free_length_mm = 0.0 }} }}"#
    );
    let machine = arm(&driven(), &[ARM_MASS, &spring]);
    for angle in [0.0f64, 1e-9, 0.3, -2.0] {
        let (state, outcome) = loaded(&machine, &[0.0, angle], &Wrench::zero());
        assert_eq!(outcome.status, Status::Solved, "{angle}");
        near("torque", drive_forces(&machine, &state)[1], 0.0, 1e-6);
        near("sensitivity", outcome.drive_sensitivity[(4, 1)], 1.0, 1e-11);
    }
}

// ---- beams ----------------------------------------------------------------------------------------------------------

#[test]
fn a_cantilever_sags_under_a_mass_at_its_end() {
    let slide = r#"{ prismatic_drive = { name = "slide", axis = "x", stiffness_N_per_mm = 1e13 } }"#;
    let beam = r#"{ beam = { length_mm = 300.0, section = { rectangle = { width_mm = 20.0, height_mm = 10.0 } }, material = "steel" } }"#;
    let mass = r#"{ mass = { kg = 2e-4, at_mm = [50.0, 0.0, 0.0] } }"#;
    let elements = [slide, beam, mass];
    let machine = machine("sag", [300.0, 0.0, 0.0], r#""x""#, &[Leg::new("beam", &elements, "")]);
    let (state, _) = settle(&machine, &machine.home, &Wrench::zero());
    let (force, stiffness) = (2e-4 * G, 210_000.0 * 20.0 * 1000.0 / 12.0);
    // Force and moment of the mass 50 mm beyond the end.
    let expected = -force * (300.0f64.powi(3) / 3.0 + 50.0 * 300.0f64.powi(2) / 2.0) / stiffness;
    near("sag", state.pose.translation.z / expected, 1.0, 1e-6);
}

/// Stiffness at a point at `lever` from where a link with stiffness `own` ends.
fn seen_from(own: &Matrix6<f64>, lever: Vector3<f64>) -> Matrix6<f64> {
    let mut to_end = Matrix6::identity();
    to_end.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(lever));
    to_end.transpose() * own * to_end
}

#[test]
fn a_flexure_of_two_beams_has_the_sum_of_their_stiffnesses() {
    let slide = r#"{ prismatic_drive = { name = "slide", axis = "x", stiffness_N_per_mm = 1e12 } }"#;
    let module = r#"{ module = { mounts = [
        { name = "a", chain = "beam", base = { position_mm = [0.0, 60.0, 10.0] }, platform = { position_mm = [0.0, 60.0, 10.0] } },
        { name = "b", chain = "beam", base = { position_mm = [0.0, -40.0, 0.0] }, platform = { position_mm = [0.0, -40.0, 0.0] } },
    ] } }"#;
    let beam = r#"{ beam = { length_mm = 300.0, section = { rectangle = { width_mm = 20.0, height_mm = 6.0 } }, material = "steel" } }"#;
    let text = format!(
        "schema = 1\nname = \"flexure\"\ntitle = \"flexure\"\nplatform = {{ tool_tip_mm = [0.0, 0.0, 0.0], controls = [\"x\"] }}\n\
         home = {{ position_mm = [300.0, 0.0, 0.0] }}\nworkspace = {{ min_mm = [0.0, 0.0, 0.0], max_mm = [0.0, 0.0, 0.0] }}\n\
         [material.steel]\nyoungs_modulus_N_per_mm2 = 210000.0\nshear_modulus_N_per_mm2 = 80000.0\n\
         [[chain]]\nname = \"beam\"\nelements = [{beam}]\n[[chain]]\nname = \"all\"\nelements = [{slide}, {}]\n\
         [[mount]]\nname = \"all\"\nchain = \"all\"\n",
        module.replace('\n', " ")
    );
    let machine = machine_from(&text);
    let (iy, iz) = (20.0 * 216.0 / 12.0, 6.0 * 8000.0 / 12.0);
    let (e, l): (f64, f64) = (210_000.0, 300.0);
    let ratio: f64 = 6.0 / 20.0;
    let torsion = 20.0 * 216.0 * (1.0 / 3.0 - 0.21 * ratio * (1.0 - ratio.powi(4) / 12.0));
    let mut own = Matrix6::zeros();
    for (i, stiffness) in [
        e * 120.0 / l,
        12.0 * e * iz / l.powi(3),
        12.0 * e * iy / l.powi(3),
        80_000.0 * torsion / l,
        4.0 * e * iy / l,
        4.0 * e * iz / l,
    ]
    .into_iter()
    .enumerate()
    {
        own[(i, i)] = stiffness;
    }
    for (i, j, coupling) in [(1, 5, -6.0 * e * iz / (l * l)), (2, 4, 6.0 * e * iy / (l * l))] {
        (own[(i, j)], own[(j, i)]) = (coupling, coupling);
    }
    let expected = seen_from(&own, Vector3::new(0.0, 60.0, 10.0)) + seen_from(&own, Vector3::new(0.0, -40.0, 0.0));
    let (_, outcome) = settle(&machine, &machine.home, &Wrench::zero());
    let off = block_difference(&outcome.stiffness.unwrap(), &expected);
    assert!(off < 1e-6, "off by {off:e}: {} instead of {expected}", outcome.stiffness.unwrap());
}
