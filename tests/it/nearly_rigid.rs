//! Links that hardly yield stand where rigid ones do.

use kinetostat::{
    compensation::{Method, Session, Target, TaskPoint, compensate},
    machine::{Machine, catalogue},
    simulation::settings,
    spatial::Wrench,
    statics::{Scratch, Settings, State, Status, equilibrium},
};
use nalgebra::Vector3;

use crate::support::{
    balance::assert_balanced,
    engine::{EXACT, machine_from, position_in_box},
};

/// Stiffness of a link in files, and the lever at which a force bends it as far as it draws it out, mm.
#[derive(Clone, Copy)]
struct Link {
    newtons_per_mm: f64,
    lever_mm: f64,
}

impl Link {
    fn matrix(self) -> String {
        // Files have no larger numbers.
        let turned = (self.lever_mm * self.lever_mm * self.newtons_per_mm).min(1e18);
        let entry = |i: usize| if i < 3 { self.newtons_per_mm } else { turned };
        let row = |i: usize| format!("{:?}", std::array::from_fn::<f64, 6, _>(|j| if i == j { entry(i) } else { 0.0 }));
        (0..6).map(row).collect::<Vec<_>>().join(", ")
    }
}

/// A built-in machine whose beams have this stiffness, and another such link behind each drive: the first `count` of them, others, and
/// all if `None`, are declared rigid.
fn with_links(text: &str, stiffness: Option<Link>, count: usize) -> String {
    let number = |line: &str, key: &str| -> Option<f64> {
        let behind = &line[line.find(key)? + key.len()..];
        behind[..behind.find([',', ' ', '}'])?].parse().ok()
    };
    let mut left = count;
    let mut link = |advance: f64| match stiffness {
        Some(stiffness) if left > 0 => {
            left -= 1;
            format!("  {{ link = {{ advance_mm = {advance:?}, stiffness_N_mm_rad = [{}] }} }},", stiffness.matrix())
        }
        _ => format!("  {{ fixed = {{ translation_mm = [{advance:?}, 0.0, 0.0] }} }},"),
    };
    let mut lines = Vec::new();
    for line in text.lines() {
        if line.contains("beam = {") {
            let advance = number(line, "advance_mm = ").or_else(|| number(line, "length_mm = "));
            lines.push(link(advance.unwrap()));
            continue;
        }
        lines.push(line.to_string());
        if line.contains("_drive = {") {
            lines.push(link(0.0));
        }
    }
    // What is said of the beams that are gone is said of nothing.
    let text = lines.join("\n");
    let head = text.find("[[provenance]]").unwrap_or(0);
    let end = text.find("[platform]").unwrap_or(0);
    format!("{}{}", &text[..head.min(end)], &text[end..])
}

/// How the machine settles, where its tip is, mm, and its softest stiffness, N/mm.
fn tip(machine: &Machine, position: Vector3<f64>, force: Vector3<f64>) -> (Status, Vector3<f64>, f64) {
    let at = machine.inverse_kinematics_at(position).unwrap_or_else(|e| panic!("{}: {e}", machine.name));
    let mut state = State::rigid(machine, &at);
    let moment = (at.pose.rotation * machine.tool_tip).cross(&force);
    let load = Wrench { force, moment };
    let outcome = equilibrium(machine, &at.drives, &load, &mut state, &mut Scratch::new(machine), &EXACT);
    let softest = outcome.least_stiffness(machine.characteristic_length).unwrap_or(f64::NAN);
    (outcome.status, state.pose.transform(machine.tool_tip), softest)
}

#[test]
fn links_that_hardly_yield_stand_where_rigid_ones_do() {
    for entry in catalogue::ENTRIES {
        let rigid = machine_from(&with_links(entry.toml, None, 0));
        for share in [[0.5, 0.5, 0.5], [0.3, 0.6, 0.4]] {
            let position = position_in_box(&rigid, 0.2, 0.8, share);
            let force = Vector3::new(300.0, -200.0, 250.0);
            let (status, expected, soft) = tip(&rigid, position, force);
            assert_eq!(status, Status::Solved, "{}, rigid", entry.name);
            let off = |newtons_per_mm: f64, lever_mm: f64, count: usize| {
                let machine = machine_from(&with_links(entry.toml, Some(Link { newtons_per_mm, lever_mm }), count));
                let (status, found, softest) = tip(&machine, position, force);
                assert_eq!(status, Status::Solved, "{}, {newtons_per_mm:e} N/mm", entry.name);
                assert!((softest / soft - 1.0).abs() < 1e-3, "{}, {newtons_per_mm:e}: {softest} {soft}", entry.name);
                found - expected
            };
            for power in 11..=15 {
                for count in [usize::MAX, 2] {
                    let off = off(10f64.powi(power), 1000.0, count).norm();
                    assert!(off < 1e-6, "{}, 1e{power} N/mm, {count} links: {off} mm", entry.name);
                }
            }
            // What they do yield is a tenth where they are ten times as stiff.
            let (more, less) = (off(1e11, 100.0, usize::MAX), off(1e12, 100.0, usize::MAX));
            assert!((more - 10.0 * less).norm() < 1e-3 * more.norm(), "{}: {more} {less}", entry.name);
        }
    }
}

/// One joint, and a link of 1e13 N/mm.
#[test]
fn an_arm_of_one_nearly_rigid_link_is_not_singular() {
    let file = |link: &str| {
        format!(
            "schema = 1\nname = \"lk\"\ntitle = \"lk\"\n[platform]\ntool_tip_mm = [0.0, 0.0, -100.0]\ncontrols = [\"rotation_z\"]\n\
             [home]\nposition_mm = [400.0, 0.0, 0.0]\nrotation_deg = [0.0, 0.0, 0.0]\n\
             [workspace]\nmin_mm = [350.0, -50.0, -50.0]\nmax_mm = [450.0, 50.0, 50.0]\n\
             [[chain]]\nname = \"c\"\nelements = [\n\
             {{ revolute_drive = {{ name = \"A\", axis = \"z\", stiffness_Nmm_per_rad = 20000000.0, home_deg = 0.0 }} }},\n{link}\n]\n\
             [[mount]]\nname = \"m\"\nchain = \"c\"\n"
        )
    };
    let matrix = Link { newtons_per_mm: 1e13, lever_mm: 100.0 }.matrix();
    let nearly =
        machine_from(&file(&format!("{{ link = {{ advance_mm = 400.0, stiffness_N_mm_rad = [{matrix}] }} }}")));
    let rigid = machine_from(&file("{ fixed = { translation_mm = [400.0, 0.0, 0.0] } }"));
    let [(status, nearly, command), (_, rigid, rigid_command)] = [&nearly, &rigid].map(|machine| {
        let mut state = State::rigid(machine, &machine.home);
        let load = Wrench { force: Vector3::new(10.0, 50.0, -20.0), moment: Vector3::zeros() };
        let drives = &machine.home.drives;
        let outcome = equilibrium(machine, drives, &load, &mut state, &mut Scratch::new(machine), &EXACT);
        let mut session = Session::new(machine, machine, settings());
        let pose = machine.home.pose;
        let task = TaskPoint::new(pose, load, Target::FullPose);
        let corrected = compensate(&mut session, &task, Method::Direct);
        (outcome.status, state.pose.transform(machine.tool_tip), corrected)
    });
    assert_eq!(status, Status::Solved);
    // A place is not called singular because a link is much stiffer than the drive.
    assert_eq!(command.status.label(), rigid_command.status.label());
    assert!(
        (command.drives[0] - rigid_command.drives[0]).abs() < 1e-9,
        "{:?} {:?}",
        command.drives,
        rigid_command.drives
    );
    assert!((nearly - rigid).norm() < 1e-6, "{nearly} {rigid}");
}

/// Two chains of three drives leave a platform no motion, and nearly one: the smallest singular value of their closures is 1/600 of the largest,
/// so that springs of less than 2 kN make them hold each other with 336 kN. Two systems of equations, one condensed, say so; balance is checked without either.
const RIGID: &str = r#"
schema = 1
name = "rigid"
title = "Rigid"
gravity_m_per_s2 = [0.0, 0.0, 0.0]
platform = { tool_tip_mm = [5.0, -3.0, 60.0], controls = ["x", "y", "z"] }
workspace = { min_mm = [-10.0, -10.0, -10.0], max_mm = [10.0, 10.0, 10.0] }
home = { position_mm = [0.0, 0.0, 0.0], rotation_deg = [0.0, -0.0, 0.0] }
[[chain]]
name = "c0"
elements = [
  { prismatic_drive = { name = "e0", axis = "z", home_mm = 0.0, stiffness_N_per_mm = 3.162e3 } },
  { fixed = { translation_mm = [0.0, 0.0, 0.0], rotation_deg = [0.0, -0.0, 0.0] } },
  { frame = "f2" },
  { revolute_drive = { name = "e3", axis = "x", home_deg = 0.0, stiffness_Nmm_per_rad = 1e8 } },
  { fixed = { translation_mm = [0.0, 0.0, 0.0], rotation_deg = [-128.14385350503295, -87.53279075568601, 180.0] } },
  { revolute_drive = { name = "e5", axis = "x", home_deg = 0.0, stiffness_Nmm_per_rad = 1e8 } },
  { spring = { name = "s0", from = { frame = "O", at_mm = [0.0, 0.0, 0.0] }, to = { frame = "f2", at_mm = [0.0, 0.0, 178.0] }, stiffness_N_per_mm = 3.2e1, free_length_mm = 225.0, preload_N = 296.8796937820459 } },
]
[[mount]]
name = "m0"
chain = "c0"
base = { position_mm = [135.53858754591215, -115.01687485467848, -122.30107397206609], rotation_deg = [131.80415257650344, 20.248534943431824, 94.34040963206873] }
platform = { position_mm = [135.53858754591215, -115.01687485467848, -122.30107397206609], rotation_deg = [113.80269248515879, 37.583239266245876, -15.646845138527175] }
[[mount]]
name = "m1"
chain = "c0"
base = { position_mm = [0.0, -135.95935150495572, -117.14123382697534], rotation_deg = [-50.523247249580635, 52.13313396891932, 92.19525653842571] }
platform = { position_mm = [0.0, -135.95935150495572, -117.14123382697534], rotation_deg = [20.314188060628386, -25.07932519426642, 150.56381176956006] }
"#;

#[test]
fn forces_of_a_machine_that_cannot_move_are_found_beside_a_singular_place() {
    let machine = Machine::from_toml(RIGID, "rigid.toml").unwrap();
    let at = machine.inverse_kinematics(&machine.home.pose).unwrap();
    let load = Wrench::new([100.0, 200.0, 100.0, 1e4, 0.0, 0.0]);
    for scratch in [Scratch::new(&machine), Scratch::uncondensed(&machine)].iter_mut() {
        let mut state = State::rigid(&machine, &at);
        let outcome = equilibrium(&machine, &at.drives, &load, &mut state, scratch, &Settings::default());
        assert_eq!(outcome.status, Status::Solved, "{outcome:?}");
        assert!(state.pose.translation.norm() < 1e-8, "{}", state.pose.translation);
        let held = state.chains[0].wrench.force.norm();
        assert!((held / 336e3 - 1.0).abs() < 0.02, "{held} N");
        assert_balanced(&machine, &at.drives, &load, &state);
    }
}
