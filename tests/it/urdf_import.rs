//! URDFs become machine files or are refused, and what the files say is what the URDFs say: poses and masses are compared with
//! products made here from what another reader (urdf-rs) finds.
//!
//! Every file in `tests/urdf/imported` and `tests/urdf/refused` has its notes or its message in `tests/urdf/expected.toml`;
//! `UPDATE_GOLDEN=1` writes them anew.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use crate::support::cases::cases;
use crate::support::command::told;
use kinetostat::{
    Machine,
    machine::Geometry,
    spatial::Pose,
    urdf::{DriveStiffness, ImportOptions, ImportedMachine, import, import_file},
};
use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use proptest::prelude::*;
use urdf_rs::{JointType, Robot};

/// Poses and masses agree to this, mm.
const SAME: f64 = 1e-9;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/urdf")
}

/// The URDFs of a folder by name.
fn files(kind: &str) -> BTreeMap<String, PathBuf> {
    let entries = fs::read_dir(folder().join(kind)).unwrap().map(|entry| entry.unwrap().path());
    entries.map(|file| (file.file_stem().unwrap().to_str().unwrap().to_string(), file)).collect()
}

/// The link that is named where there are several tips.
fn tip(name: &str) -> Option<String> {
    match name {
        "several_tips" => Some("tool0".into()),
        "masses_beside_the_chain" => Some("hand".into()),
        "mimic_beside_the_chain" => Some("tip".into()),
        _ => None,
    }
}

fn options(name: &str) -> ImportOptions {
    ImportOptions { tool_tip: [0.0, 10.0, 150.0], tip: tip(name), ..ImportOptions::default() }
}

fn imported(name: &str) -> (String, ImportedMachine) {
    let file = folder().join("imported").join(format!("{name}.urdf"));
    let imported = import_file(&file, &options(name)).unwrap_or_else(|error| panic!("{error}"));
    (fs::read_to_string(file).unwrap(), imported)
}

/// Notes of what is imported and messages of what is refused, as they are.
fn found() -> toml::Table {
    let (mut notes, mut messages) = (toml::Table::new(), toml::Table::new());
    for (name, file) in files("imported") {
        let imported = import_file(&file, &options(&name)).unwrap_or_else(|error| panic!("{error}"));
        notes.insert(name, imported.notes.into());
    }
    for (name, file) in files("refused") {
        let error = import_file(&file, &options(&name)).expect_err(&name).to_string();
        messages.insert(name, error.replace(&format!("{}/", file.parent().unwrap().display()), "").into());
    }
    [("imported".to_string(), notes.into()), ("refused".to_string(), messages.into())].into_iter().collect()
}

#[test]
fn every_urdf_is_imported_with_its_notes_or_refused_with_its_message() {
    let file = folder().join("expected.toml");
    let found = found();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        return fs::write(file, toml::to_string_pretty(&found).unwrap()).unwrap();
    }
    let expected: toml::Table = fs::read_to_string(file).unwrap().parse().unwrap();
    for (kind, least) in [("imported", 30), ("refused", 55)] {
        let (found, expected) = (found[kind].as_table().unwrap(), expected[kind].as_table().unwrap());
        assert!(found.len() >= least && found.len() == expected.len(), "files were lost: {}", found.len());
        for (name, found) in found {
            assert_eq!(found, &expected[name], "{name}");
        }
    }
}

// The independent product.

fn placed(xyz: [f64; 3], rpy: [f64; 3]) -> Isometry3<f64> {
    let [roll, pitch, yaw] = rpy;
    let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Isometry3::from_parts(Translation3::from(Vector3::from(xyz)), turn)
}

fn moved(axis: [f64; 3], is_slide: bool, value: f64) -> Isometry3<f64> {
    let axis = Unit::new_normalize(Vector3::from(axis));
    if is_slide {
        return Isometry3::from_parts(Translation3::from(axis.into_inner() * value), UnitQuaternion::identity());
    }
    Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&axis, value))
}

/// The text as the other reader needs it: it knows no inertial without inertia and no limit without velocity.
fn readable(text: &str) -> Robot {
    urdf_rs::read_from_string(text).unwrap_or_else(|_| {
        let mut parts = text.split("<inertial>");
        let mut plain = parts.next().unwrap().to_string();
        plain.extend(parts.map(|part| part.split_once("</inertial>").unwrap().1));
        urdf_rs::read_from_string(&plain.replace("effort=\"5\"", "effort=\"5\" velocity=\"1\"")).unwrap()
    })
}

/// Pose of each link in mm, with joints on the way to `tip` at `values` (m, rad), from base to tip, and all others at zero.
fn poses(robot: &Robot, tip: &str, values: &[f64]) -> BTreeMap<String, Isometry3<f64>> {
    let carrier = |link: &str| robot.joints.iter().find(|joint| joint.child.link == link);
    let mut way = Vec::new();
    let mut link = tip.to_string();
    while let Some(joint) = carrier(&link) {
        way.push(joint.name.clone());
        link.clone_from(&joint.parent.link);
    }
    way.reverse();
    let is_fixed = |name: &String| robot.joints.iter().any(|j| j.name == *name && j.joint_type == JointType::Fixed);
    way.retain(|name| !is_fixed(name));
    assert_eq!(way.len(), values.len(), "one value for each drive");
    let pose_of = |link: &str| {
        let mut pose = Isometry3::identity();
        let mut link = link.to_string();
        while let Some(joint) = carrier(&link) {
            let value = way.iter().position(|name| *name == joint.name).map_or(0.0, |index| values[index]);
            let is_slide = joint.joint_type == JointType::Prismatic;
            let scale = if is_slide { 1000.0 } else { 1.0 };
            let at = placed(joint.origin.xyz.0.map(|v| v * 1000.0), joint.origin.rpy.0);
            // The axis of a joint that does not move may be zero.
            let motion = match joint.joint_type {
                JointType::Fixed => Isometry3::identity(),
                _ => moved(joint.axis.xyz.0, is_slide, value * scale),
            };
            pose = at * motion * pose;
            link.clone_from(&joint.parent.link);
        }
        pose
    };
    robot.links.iter().map(|link| (link.name.clone(), pose_of(&link.name))).collect()
}

/// What a machine file's elements make: where the masses are (kg, mm) and where the end is.
fn product(elements: &[toml::Value], values: &[f64]) -> (Vec<(f64, Point3<f64>)>, Isometry3<f64>) {
    let vector = |value: Option<&toml::Value>| -> [f64; 3] {
        let numbers = value.map(|v| v.as_array().unwrap().iter().map(|n| n.as_float().unwrap()).collect::<Vec<_>>());
        numbers.map_or([0.0; 3], |numbers| numbers.try_into().unwrap())
    };
    let (mut at, mut masses, mut values) = (Isometry3::identity(), Vec::new(), values.iter());
    for element in elements {
        let (kind, keys) = element.as_table().unwrap().iter().next().unwrap();
        match kind.as_str() {
            "fixed" => {
                let angles = vector(keys.get("rotation_deg")).map(f64::to_radians);
                at *= placed(vector(keys.get("translation_mm")), angles);
            }
            "mass" => {
                let place = at * Point3::from(vector(keys.get("at_mm")));
                masses.push((keys["kg"].as_float().unwrap(), place));
            }
            "body" => {}
            drive => {
                let axis = ["x", "y", "z"].map(|name| f64::from(u8::from(keys["axis"].as_str() == Some(name))));
                let is_slide = drive == "prismatic_drive";
                let value = values.next().unwrap() * if is_slide { 1000.0 } else { 1.0 };
                at *= moved(axis, is_slide, value);
            }
        }
    }
    assert!(values.next().is_none(), "a value was not used");
    (masses, at)
}

fn difference(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    let turn = (a.rotation.to_rotation_matrix().matrix() - b.rotation.to_rotation_matrix().matrix()).amax();
    (a.translation.vector - b.translation.vector).norm().max(1000.0 * turn)
}

/// Numbers between −2 and 2 that look random.
fn numbers(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        4.0 * (state >> 11) as f64 / (1u64 << 53) as f64 - 2.0
    };
    (0..count).map(|_| next()).collect()
}

/// Compares the machine file with the URDF at joint values that look random: the end by the machine's own product and by one
/// made here of its elements, and the masses.
fn compare(name: &str, urdf: &str, imported: &ImportedMachine) {
    let robot = readable(urdf);
    let geometry = Geometry::from_toml(&imported.toml, name).unwrap_or_else(|error| panic!("{error}"));
    let file: toml::Table = imported.toml.parse().unwrap();
    let elements = file["chain"][0]["elements"].as_array().unwrap();
    let end = imported.notes[1].rsplit_once(" to link \"").unwrap().1.trim_end_matches('"').to_string();
    let machine = geometry.kinematics();
    for seed in 1..6 {
        let values = numbers(machine.drive_count(), seed);
        let links = poses(&robot, &end, &values);
        let (masses, by_elements) = product(elements, &values);
        let away = difference(&links[&end], &by_elements);
        assert!(away < SAME, "{name}: the elements end {away} mm away");
        let in_machine: Vec<f64> = values
            .iter()
            .zip(machine.drives())
            .map(|(value, (_, drive))| if drive.motion.label() == "prismatic" { value * 1000.0 } else { *value })
            .collect();
        let pose = machine.chains[0].forward(&in_machine, &mut Vec::new());
        let turn = UnitQuaternion::from_matrix(&pose.rotation);
        let by_machine = Isometry3::from_parts(Translation3::from(pose.translation), turn);
        let away = difference(&links[&end], &by_machine);
        assert!(away < 2.0 * SAME, "{name}: the machine ends {away} mm away");
        compare_masses(name, &robot, &links, &masses, &imported.notes);
    }
}

/// Each mass of the URDF that no note leaves out is there once, at its place.
fn compare_masses(
    name: &str,
    robot: &Robot,
    links: &BTreeMap<String, Isometry3<f64>>,
    found: &[(f64, Point3<f64>)],
    notes: &[String],
) {
    if name == "partial_inertials" || notes.iter().any(|note| note.starts_with("masses: none used")) {
        return;
    }
    let left_out = |link: &str| notes.iter().any(|note| note.starts_with(&format!("mass of link {link:?}: not used")));
    let expected = robot.links.iter().filter(|link| link.inertial.mass.value > 0.0 && !left_out(&link.name));
    let mut left = found.to_vec();
    for link in expected {
        let centre = links[&link.name] * Point3::from(link.inertial.origin.xyz.0.map(|v| v * 1000.0));
        let is_it = |(kg, at): &(f64, Point3<f64>)| *kg == link.inertial.mass.value && (at - centre).norm() < SAME;
        let place = left.iter().position(is_it).unwrap_or_else(|| panic!("{name}: mass of {} is lost", link.name));
        left.remove(place);
    }
    assert!(left.is_empty(), "{name}: masses from nowhere {left:?}");
}

#[test]
fn poses_and_masses_are_those_of_the_urdf() {
    for name in files("imported").into_keys() {
        let (urdf, imported) = imported(&name);
        compare(&name, &urdf, &imported);
    }
}

// What the files say.

fn chain_text(toml: &str) -> &str {
    toml.split_once("elements = [\n").unwrap().1.split_once("]\n\n[[mount]]").unwrap().0
}

#[test]
fn elements_are_in_the_order_in_which_frames_are_reached() {
    let (_, six) = imported("six_axes");
    let expected = r#"  # link "base"
  { mass = { kg = 200.0, at_mm = [0.0, 0.0, 200.0] } },
  # joint "a1"
  { fixed = { translation_mm = [0.0, 0.0, 400.0] } },
  { revolute_drive = { name = "a1", axis = "z", stiffness_Nmm_per_rad = "unknown", home_deg = 0.0, travel_deg = [-114.59155902616465, 143.2394487827058], torque_limit_Nmm = 100000.0 } },
  # link "link1"
  { mass = { kg = 150.0, at_mm = [100.0, 0.0, 100.0] } },
"#;
    assert!(chain_text(&six.toml).starts_with(expected), "{}", six.toml);
    let (_, partial) = imported("partial_inertials");
    let masses: Vec<&str> = partial.toml.lines().filter(|line| line.contains("mass = {")).collect();
    let expected =
        [(200, "[0.0, 0.0, 200.0]"), (150, "[0.0, 0.0, 0.0]"), (120, "[200.0, 0.0, 0.0]"), (5, "[0.0, 0.0, -50.0]")];
    let expected = expected.map(|(kg, at)| format!("  {{ mass = {{ kg = {kg}.0, at_mm = {at} }} }},"));
    assert_eq!(masses, expected);
}

/// An arm of three axes in `folder`/urdf, in a package whose folder has another name, with the meshes that it names.
fn arm_with_bodies(folder: &Path) -> String {
    let shape =
        |kind: &str, at: &str, inner: &str| format!("<{kind}><origin {at}/><geometry>{inner}</geometry></{kind}>");
    let mesh = |name: &str, more: &str| format!("<mesh filename='{name}' {more}/>");
    let link = |name: &str, shapes: &[String]| format!("<link name='{name}'>{}</link>\n", shapes.concat());
    let joint = |name: &str, kind: &str, [parent, child]: [&str; 2], origin: &str, axis: &str| {
        let limit = "<limit lower='-2' upper='2' effort='100' velocity='1'/>";
        format!(
            "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/><origin {origin}/><axis xyz='{axis}'/>{limit}</joint>\n"
        )
    };
    let a_box = "<box size='0.3 0.2 0.1'/>";
    let text = [
        "<robot name='arm'>\n".to_owned(),
        link("base", &[shape("collision", "xyz='0 0 0.05'", a_box), shape("visual", "", "<sphere radius='5'/>")]),
        link("foot", &[shape("collision", "xyz='0 0 0.1'", "<sphere radius='0.05'/>")]),
        link(
            "upper",
            &[shape(
                "collision",
                "xyz='0.2 0 0' rpy='0 1.5707963267948966 0'",
                "<cylinder radius='0.05' length='0.2'/>",
            )],
        ),
        link("fore", &[shape("visual", "xyz='0.25 0 0' rpy='0.1 0.2 0.3'", a_box)]),
        link(
            "hand",
            &[shape("collision", "xyz='0.1 0 0'", &mesh("package://arm/meshes/hand.stl", "scale='0.001 0.001 0.001'"))],
        ),
        link("camera", &["camera.dae", "nothing.stl", "open.stl"].map(|name| shape("collision", "", &mesh(name, "")))),
        link(
            "tool0",
            &[shape("collision", "", "<sphere radius='0.02'/>"), shape("collision", "", "<sphere radius='none'/>")],
        ),
        joint("f", "fixed", ["base", "foot"], "xyz='0.5 0 0' rpy='0.5 0 0'", "0 0 1"),
        joint("a1", "revolute", ["base", "upper"], "xyz='0 0 0.4' rpy='0 0 0.3'", "0 0 1"),
        joint("a2", "revolute", ["upper", "fore"], "xyz='0.5 0 0'", "0 1 0"),
        joint("a3", "revolute", ["fore", "hand"], "xyz='0.5 0 0'", "1 1 0"),
        joint("t", "fixed", ["hand", "tool0"], "xyz='0.3 0 0' rpy='0 0.4 0'", "0 0 1"),
        joint("c", "fixed", ["hand", "camera"], "xyz='0.2 0 0'", "0 0 1"),
        "</robot>\n".to_owned(),
    ]
    .concat();
    for (name, text) in [
        ("meshes/hand.stl", crate::clearance::cube(80.0)),
        ("urdf/camera.dae", "<COLLADA/>".into()),
        ("urdf/open.stl", crate::clearance::cube(0.1).replacen("vertex 0.1 0.1 0.1", "vertex 0.1 0.1 0.2", 1)),
        ("urdf/arm.urdf", text.clone()),
    ] {
        let file = folder.join(name);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
    }
    text
}

/// Import of the arm, whose stiffnesses are given.
fn arm_options() -> ImportOptions {
    let stiffness = DriveStiffness::Given(vec![1e6; 3]);
    ImportOptions { tip: Some("tool0".into()), tool_tip: [100.0, 0.0, 0.0], stiffness, ..ImportOptions::default() }
}

#[test]
fn bodies_stand_where_the_urdf_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let text = arm_with_bodies(folder.path()).replace("radius='none'", "radius='1'");
    let imported = import_file(&folder.path().join("urdf/arm.urdf"), &arm_options()).unwrap();
    compare("arm", &text, &imported);
    let machine = Machine::from_toml(&imported.toml, "elsewhere/arm.toml").unwrap();
    let robot = readable(&text);
    let bodies = machine.bodies().unwrap();
    // In its link: the centre of a ball around it, m.
    let expected = [
        ("base", [0.0, 0.0, 0.05]),
        ("foot", [0.0, 0.0, 0.1]),
        ("tool0", [0.0; 3]),
        ("hand", [0.14, 0.04, 0.04]),
        ("upper", [0.2, 0.0, 0.0]),
        ("fore", [0.25, 0.0, 0.0]),
    ];
    let names = |own: &mut dyn Iterator<Item = &str>| own.map(String::from).collect::<std::collections::BTreeSet<_>>();
    assert_eq!(names(&mut bodies.iter().map(|own| own.name.as_str())), names(&mut expected.iter().map(|own| own.0)));
    let mut frames = Vec::new();
    for place in [machine.workspace.min, machine.workspace.max] {
        let at = machine.inverse_kinematics_at(place).unwrap();
        machine.frame_poses(&at, &mut frames);
        let links = poses(&robot, "tool0", &at.drives);
        for (name, centre) in expected {
            let body = bodies.iter().find(|own| own.name == name).unwrap();
            let found = frames[body.frame] * body.ball().0;
            let away = (found - links[name] * Point3::from(centre.map(|v| v * 1000.0))).norm();
            assert!(away < 1e-4, "{name}: {away} mm away");
        }
    }
    let fixed: Vec<(&str, usize)> = bodies.iter().map(|own| (own.name.as_str(), own.frame)).collect();
    assert_eq!(&fixed[..3], [("base", 0), ("foot", 0), ("hand", 1)], "{}", imported.toml);
    let file: toml::Table = imported.toml.parse().unwrap();
    let hand = &file["platform"]["body"][0];
    assert_eq!([&hand["name"], &hand["grade"]].map(|own| own.as_str().unwrap()), ["hand", "assumed"]);
    assert_eq!(hand["shapes"][0]["mesh"]["unit"].as_str().unwrap(), "mm");
}

#[test]
fn shapes_that_cannot_be_used_are_left_out_with_a_note() {
    let folder = tempfile::tempdir().unwrap();
    arm_with_bodies(folder.path());
    let imported = import_file(&folder.path().join("urdf/arm.urdf"), &arm_options()).unwrap();
    let note = |start: &str| imported.notes.iter().find(|note| note.starts_with(start)).unwrap();
    assert!(note("bodies: ").starts_with("bodies: 6 of 10 shapes of <collision>"), "{}", note("bodies: "));
    let left_out = note("shapes left out");
    for expected in [
        "link \"camera\": shapes[0].mesh.file: expected an STL file, got ",
        "camera.dae",
        "link \"camera\": mesh: \"nothing.stl\" is not found",
        "open.stl is open at the edge",
        "link \"tool0\": shapes: \"<collision><origin /><geometry><sphere radius='none'/>",
        "FreeCAD, MeshLab or Blender make closed STL files of other meshes",
    ] {
        assert!(left_out.contains(expected), "{expected}\n{left_out}");
    }
    assert!(!imported.notes.iter().any(|note| note.starts_with("not read") && note.contains("visual")));
}

#[test]
fn a_mesh_is_that_of_its_package_and_in_its_unit() {
    let folder = tempfile::tempdir().unwrap();
    let within = folder.path().join("cell");
    let text = arm_with_bodies(&within);
    // Beside the package that the file is in, another with a mesh of the same name.
    fs::create_dir_all(folder.path().join("other/meshes")).unwrap();
    fs::write(folder.path().join("other/meshes/hand.stl"), crate::clearance::cube(90.0)).unwrap();
    let urdf = within.join("urdf/arm.urdf");
    fs::write(&urdf, text.replace("package://arm/", "package://other/")).unwrap();
    let imported = import_file(&urdf, &arm_options()).unwrap();
    assert!(imported.toml.contains("other/meshes/hand.stl"), "{}", imported.toml);
    // 80 mm taken for 80 m.
    fs::write(&urdf, text.replace("scale='0.001 0.001 0.001'", "")).unwrap();
    let imported = import_file(&urdf, &arm_options()).unwrap();
    let left_out = imported.notes.iter().find(|note| note.starts_with("shapes left out")).unwrap();
    assert!(left_out.contains("are the numbers of its file millimetres?"), "{left_out}");
}

/// A dome over the whole arm overlaps with all that is not joined to it.
#[test]
fn a_file_whose_bodies_overlap_at_home_works_and_says_which() {
    let folder = tempfile::tempdir().unwrap();
    let text = arm_with_bodies(folder.path());
    let urdf = folder.path().join("urdf/dome.urdf");
    fs::write(&urdf, text.replace("<sphere radius='0.05'/>", "<sphere radius='3'/>")).unwrap();
    let file = folder.path().join("dome.toml");
    let [urdf, file] = [&urdf, &file].map(|own| own.to_str().unwrap());
    let import = [
        "machines",
        "--import",
        urdf,
        "--tool",
        "100,0,0",
        "--tip",
        "tool0",
        "--stiffness",
        "1e6,1e6,1e6",
        "--out",
        file,
    ];
    let (code, _, notes) = told(&import);
    assert!(code == Some(0) && notes.contains("note: may_touch: bodies that overlap at home"), "{notes}");
    let machine = Machine::from_file(Path::new(file)).unwrap();
    for other in ["fore", "hand", "tool0"] {
        let is_it = |pair: &[String; 2]| pair.contains(&"foot".into()) && pair.contains(&other.into());
        assert!(machine.may_touch().iter().any(is_it), "{other}: {:?}", machine.may_touch());
    }
    let (code, found, error) = told(&["check", file]);
    assert!(code == Some(0) && !found.contains("overlap"), "{found}{error}");
    assert!(found.contains("bodies"), "{found}");
}

#[test]
fn limits_become_travel_and_largest_forces() {
    let (_, gantry) = imported("three_slides");
    for expected in [
        "name = \"x\", axis = \"x\", stiffness_N_per_mm = \"unknown\", home_mm = 750.0, travel_mm = [0.0, 1500.0], force_limit_N = 2000.0 }",
        "name = \"z\", axis = \"z\", stiffness_N_per_mm = \"unknown\", home_mm = 300.0, travel_mm = [100.0, 500.0], force_limit_N = 2500.5 }",
        "controls = [\"x\", \"y\", \"z\"]",
    ] {
        assert!(gantry.toml.contains(expected), "{expected}\n{}", gantry.toml);
    }
    let (_, missing) = imported("missing_limits");
    assert!(!missing.toml.contains("travel") || missing.notes.iter().any(|note| note.contains("without travel")));
    assert_eq!(missing.toml.matches("travel_").count(), 0);
    assert_eq!(missing.toml.matches("_limit_N").count(), 1);
    let (_, scara) = imported("scara");
    assert!(scara.toml.contains("controls = [\"x\", \"y\", \"z\", \"rotation_z\"]"), "{}", scara.toml);
}

#[test]
fn home_is_regular_within_travel_and_where_the_file_says() {
    for name in files("imported").into_keys() {
        let (_, imported) = imported(&name);
        let geometry = Geometry::from_toml(&imported.toml, &name).unwrap();
        let machine = geometry.kinematics();
        let away = (machine.home.pose.translation - machine.home_target.translation).norm();
        assert!(away < 1e-9 * machine.characteristic_length, "{name}: home is {away} mm away");
        assert_eq!(machine.controlled_count(&machine.home), machine.controls.len(), "{name}");
        for (rho, (_, drive)) in machine.home.drives.iter().zip(machine.drives()) {
            assert!((rho - drive.home).abs() < 1e-12, "{name}: {} is {rho}, not {}", drive.name, drive.home);
            assert!(drive.travel.is_none_or(|(low, high)| low < *rho && *rho < high), "{name}");
        }
        let corners = [machine.workspace.min, machine.workspace.max];
        assert!(corners.iter().all(|corner| machine.inverse_kinematics_at(*corner).is_ok()), "{name}");
        let is_six = machine.drive_count() >= 6;
        assert!(!is_six || machine.controls.len() == 6 && corners[0] != corners[1], "{name}: {corners:?}");
    }
}

#[test]
fn the_tool_axis_is_given_or_assumed_and_that_is_said() {
    let (urdf, _) = imported("six_axes");
    let axis = |tip: [f64; 3], angles: Option<[f64; 3]>| {
        let options = ImportOptions { tool_tip: tip, tool_angles: angles, ..ImportOptions::default() };
        let text = import(&urdf, "six.urdf", &options).unwrap().toml;
        let lines: Vec<&str> = text.lines().collect();
        let place = lines.iter().position(|line| line.starts_with("tool_axis")).unwrap();
        (lines[place - 1].to_string(), lines[place].to_string())
    };
    let nearest = "# From the spindle to the tip: assumed, the axis of the link nearest to the direction of the tip; set your own.";
    assert_eq!(axis([90.0, 0.0, 320.0], None), (nearest.into(), "tool_axis = [0.0, 0.0, 1.0]".into()));
    assert_eq!(axis([0.0, -50.0, 20.0], None), (nearest.into(), "tool_axis = [0.0, -1.0, 0.0]".into()));
    let z = "# From the spindle to the tip: assumed, z of the link; set your own.";
    assert_eq!(axis([0.0; 3], None), (z.into(), "tool_axis = [0.0, 0.0, 1.0]".into()));
    let given = "# From the spindle to the tip: z of the link turned by the angles given at the import.";
    assert_eq!(axis([0.0, 0.0, 1.0], Some([0.0, 90.0, 0.0])), (given.into(), "tool_axis = [1.0, 0.0, 0.0]".into()));
    assert_eq!(axis([0.0, 0.0, 1.0], Some([90.0, 0.0, 90.0])).1, "tool_axis = [1.0, 0.0, 0.0]");
}

#[test]
fn stiffness_is_given_or_taken_from_a_machine_with_the_same_drives() {
    let (urdf, _) = imported("six_axes");
    let with = |stiffness| import(&urdf, "six.urdf", &ImportOptions { stiffness, ..ImportOptions::default() });
    let given = with(DriveStiffness::Given(vec![3.8e6, 6.6e6, 3.9e6, 5.6e5, 6.6e5, 4.7e5])).unwrap();
    let machine = Machine::from_toml(&given.toml, "six.toml").unwrap();
    let stiffness: Vec<f64> = machine.drives().map(|(_, drive)| drive.stiffness).collect();
    assert_eq!(stiffness, [3.8e9, 6.6e9, 3.9e9, 5.6e8, 6.6e8, 4.7e8]);
    let kr270 = Machine::named_or_file(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/machines/kr270.toml")).unwrap();
    let like = with(DriveStiffness::Like(kr270)).unwrap();
    let machine = Machine::from_toml(&like.toml, "six.toml").unwrap();
    assert_eq!(machine.drives().map(|(_, drive)| drive.stiffness).collect::<Vec<_>>(), stiffness);
    assert!(machine.source.ends_with("stiffness of the drives: as that of kr270"), "{}", machine.source);
    assert!(!like.notes.iter().any(|note| note.contains("stiffness")));
    for (stiffness, expected) in [
        (DriveStiffness::Given(vec![1e6]), "--stiffness: expected 6, one for each of a1, a2, a3, a4, a5, a6, got 1"),
        (DriveStiffness::Given(vec![0.0; 6]), "--stiffness: expected numbers between 1e-12 and 1e15, got 0.0"),
        (
            DriveStiffness::Like(Machine::named("orthoglide").unwrap()),
            "--like: orthoglide has the drives prismatic, prismatic, prismatic; the imported robot has revolute, revolute, revolute, revolute, revolute, revolute: expected the same kinds in the same order, or --stiffness",
        ),
    ] {
        assert_eq!(with(stiffness).unwrap_err().to_string(), expected);
    }
}

#[test]
fn tips_are_named() {
    let (urdf, _) = imported("several_tips");
    let at = |tip: Option<&str>| {
        let options = ImportOptions { tip: tip.map(String::from), ..ImportOptions::default() };
        import(&urdf, "six.urdf", &options).map(|imported| imported.notes[1].clone()).map_err(|error| error.to_string())
    };
    assert_eq!(at(Some("link3")).unwrap(), "chain: from link \"base\", whose frame is O, to link \"link3\"");
    let tips = "\"tool0\" (6 movable joints before it), \"camera\" (6 movable joints before it)";
    assert_eq!(
        at(None).unwrap_err(),
        format!("--tip: six.urdf has several tips: name the link that carries the tool, with --tip: {tips}")
    );
    assert_eq!(at(Some("tool")).unwrap_err(), format!("--tip: six.urdf has no link \"tool\"; its tips are: {tips}"));
    assert_eq!(
        at(Some("base_frame")).unwrap_err(),
        format!("--tip: no movable joint leads to \"base_frame\"; tips of six.urdf are: {tips}")
    );
}

// The command.

#[test]
fn the_command_writes_the_file_and_check_says_what_is_needed_to_go_on() {
    let urdf = folder().join("imported/six_axes.urdf");
    let urdf = urdf.to_str().unwrap();
    let out = tempfile::tempdir().unwrap();
    let file = out.path().join("six.toml");
    let file = file.to_str().unwrap();
    let (code, printed, notes) = told(&["machines", "--import", urdf, "--tool", "0,-10,150"]);
    assert_eq!(code, Some(0), "{notes}");
    assert!(notes.lines().all(|line| line.starts_with("note: ")) && notes.contains("stiffness unknown"), "{notes}");
    let (code, said, _) = told(&["machines", "--import", urdf, "--tool", "0,-10,150", "--out", file]);
    assert_eq!((code, said), (Some(0), format!("Written to {file}. Next:\n  kinetostat check {file}\n")));
    assert_eq!(fs::read_to_string(file).unwrap(), printed);
    let (code, found, error) = told(&["check", file]);
    assert_eq!(code, Some(2));
    for expected in ["6 drives", "char. length", "places reached     9 of 9", "stiffness          unknown of a1, a2"] {
        assert!(found.contains(expected), "{expected}\n{found}");
    }
    for number in 1..=6 {
        assert!(error.contains(&format!("revolute_drive.stiffness_Nmm_per_rad of drive a{number}")), "{error}");
    }
    assert!(error.contains("unknown, expected a number; a URDF can be imported again with --stiffness or --like"));
    let (code, said, error) = told(&["machines", "--import", urdf, "--tool", "0,0,1", "--out", file]);
    assert_eq!((code, said.as_str()), (Some(2), ""));
    assert!(error.contains("exists already and was left as it is"), "{error}");
    assert_eq!(fs::read_to_string(file).unwrap(), printed);
    let stiffness = "3.8e6,6.6e6,3.9e6,5.6e5,6.6e5,4.7e5";
    let known = out.path().join("known.toml");
    let known = known.to_str().unwrap();
    let import = ["machines", "--import", urdf, "--tool", "0,0,150,0,90,0", "--stiffness", stiffness, "--out", known];
    assert_eq!(told(&import).0, Some(0));
    let (code, found, _) = told(&["check", known]);
    assert!(code == Some(0) && found.contains("tool stiffness"), "{found}");
    let (code, found, error) = told(&["point", "-m", known, "--wrench", "100,0,0,0,0,0", "--position", "950,0,1500"]);
    assert!(code < Some(2), "{found}{error}");
}

#[test]
fn arguments_that_make_no_sense_are_refused() {
    let urdf = folder().join("imported/six_axes.urdf");
    let urdf = urdf.to_str().unwrap();
    for (arguments, expected) in [
        (&["--import", urdf][..], "--tool"),
        (&["--tool", "1,2,3"], "--import"),
        (&["--import", urdf, "--tool", "1,2"], "expected 6 numbers separated by commas, got 2 (or 3)"),
        (&["--import", urdf, "--tool", "1,2,x"], "\"x\" is not a number"),
        (&["--import", urdf, "--tool", "1,2,3", "--like", "a", "--stiffness", "1"], "cannot be used with"),
        (&["--import", urdf, "--tool", "1,2,3", "--show", "orthoglide"], "cannot be used with"),
        (&["--import", urdf, "--tool", "1,2,3", "--like", "nothing"], "no built-in machine \"nothing\""),
        (&["--import", "/no/such.urdf", "--tool", "1,2,3"], "/no/such.urdf: cannot be read"),
    ] {
        let (code, printed, error) = told(&[&["machines"], arguments].concat());
        assert_eq!((code, printed.as_str()), (Some(2), ""), "{arguments:?}");
        assert!(error.contains(expected), "{arguments:?}: {error}");
    }
}

// Nothing panics.

#[test]
fn deep_nesting_and_many_parts_are_read_or_refused() {
    let refusal = |text: &str| import(text, "x.urdf", &ImportOptions::default()).unwrap_err().to_string();
    let deep = |count: usize| format!("<robot>{}{}</robot>", "<a>".repeat(count), "</a>".repeat(count));
    assert_eq!(refusal(&deep(100_000)), "x.urdf:1: has no <link>, expected a URDF");
    assert_eq!(refusal(&deep(1_500_000)), "x.urdf: has more than 1000000 XML nodes, expected a URDF");
    let chain = |kind: &str, count: usize| {
        let link = |i: usize| {
            let next = i + 1;
            format!(
                "<link name='l{next}'/><joint name='j{i}' type='{kind}'><parent link='l{i}'/><child link='l{next}'/>\
                 <origin xyz='0.01 0 0' rpy='0.1 0.2 0.3'/><axis xyz='0 0 1'/></joint>\n"
            )
        };
        format!("<robot name='r'>\n<link name='l0'/>{}</robot>", (0..count).map(link).collect::<String>())
    };
    assert_eq!(refusal(&chain("continuous", 101)), "x.urdf: 101 movable joints lead to the tip, expected at most 100");
    assert_eq!(refusal(&chain("fixed", 50_000)), "x.urdf: has no movable joint, expected a robot");
    let long = chain("continuous", 20);
    let imported = import(&long, "x.urdf", &ImportOptions::default()).unwrap();
    compare("long", &long, &imported);
}

#[test]
fn a_file_that_is_too_long_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("long.urdf");
    fs::write(&file, vec![b' '; (16 << 20) + 1]).unwrap();
    let error = import_file(&file, &ImportOptions::default()).unwrap_err().to_string();
    assert!(error.ends_with("long.urdf: cannot be read: longer than 16 MiB"), "{error}");
    assert!(import_file(folder.path(), &ImportOptions::default()).is_err());
}

#[test]
fn files_cut_off_anywhere_are_refused_without_panic() {
    let (urdf, _) = imported("meshes_and_transmissions");
    for end in (0..urdf.trim_end().len() - 1).filter(|end| urdf.is_char_boundary(*end)) {
        assert!(import(&urdf[..end], "cut.urdf", &ImportOptions::default()).is_err(), "{end}");
    }
}

/// URDFs of this host: `URDF_FOLDERS=/opt/ros:/home cargo test --all-features --test it urdf_import:: -- --ignored --nocapture`.
#[test]
#[ignore = "reads whatever URDFs there are on this host"]
fn urdfs_of_this_host_are_imported_or_refused() {
    let folders = std::env::var_os("URDF_FOLDERS").expect("URDF_FOLDERS: folders to look in, separated by colons");
    let mut folders: Vec<PathBuf> = std::env::split_paths(&folders).collect();
    let (mut imported, mut refused) = (0, 0);
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(&folder).into_iter().flatten().map_while(Result::ok).map(|entry| entry.path()) {
            if path.is_dir() && !path.is_symlink() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "urdf") {
                match import_file(&path, &ImportOptions::default()) {
                    Ok(file) => {
                        imported += 1;
                        println!("imported {}\n  {}", path.display(), file.notes.join("\n  "));
                    }
                    Err(error) => {
                        refused += 1;
                        println!("refused  {error}");
                    }
                }
            }
        }
    }
    println!("{imported} imported, {refused} refused");
}

// Chains drawn at random.

#[derive(Debug, Clone)]
struct Part {
    kind: usize,
    xyz: [f64; 3],
    rpy: [f64; 3],
    axis: [f64; 3],
    kg: f64,
    centre: [f64; 3],
    /// A link beside the chain, on a joint that moves or not.
    beside: Option<bool>,
}

fn part() -> impl Strategy<Value = Part> {
    let share = || prop::array::uniform3(-1.0..1.0f64);
    let axis = prop_oneof![
        share(),
        (0..6usize).prop_map(|i| std::array::from_fn(|j| if j != i % 3 {
            0.0
        } else if i < 3 {
            1.0
        } else {
            -1.0
        }))
    ];
    let all = (0..4usize, share(), share(), axis, 10.0..60.0f64, share(), prop::option::of(any::<bool>()));
    all.prop_map(|(kind, xyz, rpy, axis, kg, centre, beside)| Part {
        kind,
        xyz,
        rpy: rpy.map(|angle| 3.0 * angle),
        axis: if Vector3::from(axis).norm() < 1e-3 { [0.0, 1.0, 0.0] } else { axis },
        kg,
        centre: centre.map(|c| 0.1 * c),
        beside,
    })
}

fn urdf(parts: &[Part]) -> String {
    let words = |v: [f64; 3]| v.map(|c| c.to_string()).join(" ");
    let kinds = ["revolute", "prismatic", "fixed", "continuous"];
    let mut text = String::from("<robot name='random'><link name='l0'/>\n");
    let mut link = |name: &str, parent: &str, kind: &str, part: &Part| {
        text += &format!(
            "<link name='{name}'><inertial><mass value='{}'/><origin xyz='{}'/>\
             <inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>\n\
             <joint name='j{name}' type='{kind}'><parent link='{parent}'/><child link='{name}'/>\
             <origin xyz='{}' rpy='{}'/><axis xyz='{}'/><limit lower='-2' upper='2.1' effort='10' velocity='1'/></joint>\n",
            part.kg,
            words(part.centre),
            words(part.xyz),
            words(part.rpy),
            words(part.axis)
        );
    };
    for (i, part) in parts.iter().enumerate() {
        // The first joint moves.
        let kind = if i == 0 { kinds[part.kind % 2] } else { kinds[part.kind] };
        link(&format!("l{}", i + 1), &format!("l{i}"), kind, part);
        if let Some(moves) = part.beside {
            let kg = part.kg + 0.5;
            let kind = if moves { "revolute" } else { "fixed" };
            link(&format!("s{}", i + 1), &format!("l{i}"), kind, &Part { kg, ..part.clone() });
        }
    }
    text + "</robot>\n"
}

proptest! {
    #![proptest_config(cases(40))]

    #[test]
    fn random_chains_have_the_poses_and_masses_of_their_urdf(parts in prop::collection::vec(part(), 1..9)) {
        let text = urdf(&parts);
        let options = ImportOptions { tip: Some(format!("l{}", parts.len())), ..ImportOptions::default() };
        let imported = import(&text, "random.urdf", &options).unwrap();
        compare("random", &text, &imported);
    }

    #[test]
    fn broken_bytes_never_panic(at in 0..4000usize, byte in any::<u8>(), length in 0..20usize) {
        let (text, _) = imported("masses_beside_the_chain");
        let mut bytes = text.into_bytes();
        let at = at % bytes.len();
        let end = (at + length).min(bytes.len());
        bytes.splice(at..end, [byte]);
        let _ = import(&String::from_utf8_lossy(&bytes), "broken.urdf", &options("masses_beside_the_chain"));
    }
}

/// The elements of the machine file of a URDF whose joints are `joints`, one after another.
fn elements_of(joints: &[String]) -> Vec<toml::Value> {
    let links: String = (0..=joints.len()).map(|k| format!("<link name=\"l{k}\"/>\n")).collect();
    let joint = |(k, inner): (usize, &String)| {
        let end = format!("<parent link=\"l{k}\"/><child link=\"l{}\"/></joint>\n", k + 1);
        inner.replace("NAME", &format!("j{k}")) + &end
    };
    let joints: String = joints.iter().enumerate().map(joint).collect();
    let text = format!("<robot name=\"r\">\n{links}{joints}</robot>\n");
    let toml = import(&text, "r.urdf", &ImportOptions::default()).unwrap().toml;
    let table: toml::Table = toml.parse().unwrap();
    table["chain"].as_array().unwrap()[0]["elements"].as_array().unwrap().clone()
}

#[test]
fn lengths_a_thousandfold_keep_what_was_written() {
    for (value, expected) in [(0.1273, 127.3), (-0.00002, -0.02), (0.0, 0.0), (1e-9, 1e-6), (123.456, 123_456.0)] {
        // Beside a length that is not zero, as what does not move is not written.
        let drive = r#"<joint name="NAME" type="prismatic"><axis xyz="1 0 0"/>"#;
        let joint = format!("{drive}<limit lower=\"0\" upper=\"1\"/><origin xyz=\"{value} 7 0\"/>");
        let elements = elements_of(&[joint]);
        let fixed = elements.iter().find_map(|element| element.get("fixed")).unwrap();
        let written = fixed["translation_mm"][0].as_float().unwrap();
        assert_eq!(written.to_bits(), f64::to_bits(expected), "{value}");
    }
}

#[test]
fn rotations_before_and_after_a_drive_undo_each_other() {
    for direction in [[0.0, 0.0, -1.0], [-3.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 2.0, -3.0], [1e-8, 0.0, 1.0]] {
        let [x, y, z] = direction;
        let elements =
            elements_of(&[format!("<joint name=\"NAME\" type=\"continuous\"><axis xyz=\"{x:?} {y:?} {z:?}\"/>")]);
        let drive = elements.iter().position(|element| element.get("revolute_drive").is_some()).unwrap();
        let product = |parts: &[toml::Value]| {
            parts.iter().filter_map(|part| part.get("fixed")).fold(Pose::identity(), |all, fixed| {
                let angle =
                    |k: usize| fixed.get("rotation_deg").map_or(0.0, |all| all[k].as_float().unwrap().to_radians());
                all.compose(&Pose::from_roll_pitch_yaw(Vector3::new(angle(0), angle(1), angle(2))))
            })
        };
        let (before, after) = (product(&elements[..drive]), product(&elements[drive..]));
        assert!((before.compose(&after).rotation - nalgebra::Matrix3::identity()).amax() < 1e-15);
        let axis = elements[drive]["revolute_drive"]["axis"].as_str().unwrap();
        let turned =
            before.rotation.column(["x", "y", "z"].iter().position(|name| *name == axis).unwrap()).into_owned();
        assert!((turned - Vector3::from(direction).normalize()).norm() < 1e-15, "{direction:?}: {turned}");
    }
}
