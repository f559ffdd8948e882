//! The collaborative arms of the catalogue against the Denavit-Hartenberg tables of their maker: where joints put the flange, what is said of their
//! stiffness, and where a program in URScript puts the joints.

use std::f64::consts::FRAC_PI_2;

use kinetostat::{
    compensation::Method,
    input::Folder,
    machine::{Grade, Machine, catalogue},
    process::Process,
    products::program::{Part, ProgramJob},
    simulation::along_path::PathPointResult,
    spatial::Pose,
    work::Work,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::support::engine::{catalogue_machine, machine_from};

/// An arm as Universal Robots has it on its page "DH Parameters for calculations of kinematics and dynamics": a and d of each joint, mm; α is 90, 0, 0, 90,
/// −90 and 0 degrees, θ the joint.
struct Cobot {
    name: &'static str,
    a: [f64; 6],
    d: [f64; 6],
    /// Joints with the tool down in front, degrees.
    before: [f64; 6],
}

const COBOTS: [Cobot; 2] = [
    Cobot {
        name: "ur10e",
        a: [0.0, -612.7, -571.55, 0.0, 0.0, 0.0],
        d: [180.7, 0.0, 0.0, 174.15, 119.85, 116.55],
        before: [13.0, -98.0, -105.0, -67.0, 90.0, -77.0],
    },
    Cobot {
        name: "ur5e",
        a: [0.0, -425.0, -392.2, 0.0, 0.0, 0.0],
        d: [162.5, 0.0, 0.0, 133.3, 99.7, 99.6],
        before: [16.0, -90.0, -115.0, -65.0, 90.0, -74.0],
    },
];

impl Cobot {
    /// The flange in the base, by one transform for each joint: about z by θ, along z by d, along x by a, about x by α.
    fn flange(&self, joints: &[f64]) -> Isometry3<f64> {
        let alpha = [FRAC_PI_2, 0.0, 0.0, FRAC_PI_2, -FRAC_PI_2, 0.0];
        let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
        (0..6).fold(Isometry3::identity(), |reached, i| {
            let place = Translation3::new(self.a[i], 0.0, self.d[i]);
            let turned = Isometry3::from_parts(Translation3::identity(), about(Vector3::z_axis(), joints[i]));
            reached * turned * Isometry3::from_parts(place, about(Vector3::x_axis(), alpha[i]))
        })
    }

    /// Joints `moved` by degrees from where the tool is down in front, rad.
    fn joints(&self, moved: [f64; 6]) -> [f64; 6] {
        std::array::from_fn(|i| (self.before[i] + moved[i]).to_radians())
    }
}

/// How far a pose is from another: mm, and the largest difference of their axes.
fn apart(one: &Pose, other: &Isometry3<f64>) -> (f64, f64) {
    let turned = one.rotation - other.rotation.to_rotation_matrix().matrix();
    ((one.translation - other.translation.vector).norm(), turned.amax())
}

#[test]
fn joints_put_the_flange_where_the_makers_table_has_it() {
    let half = 180.0;
    let shown: [[f64; 6]; 6] = [
        [0.0; 6],
        [0.0, -90.0, -90.0, -90.0, 90.0, 0.0],
        [half, -90.0, 90.0, -90.0, -90.0, half],
        [37.0, -71.0, 128.0, -200.0, 64.0, 311.0],
        [-123.0, -40.0, -97.0, 12.0, -135.0, -half],
        [0.0, -90.0, -90.0, 0.0, half, 90.0],
    ];
    for cobot in &COBOTS {
        let machine = catalogue_machine(cobot.name);
        for degrees in shown {
            let joints = degrees.map(f64::to_radians);
            let (mm, rad) = apart(&machine.forward_kinematics(&joints).unwrap().pose, &cobot.flange(&joints));
            assert!(mm < 1e-9 && rad < 1e-9, "{} at {degrees:?}: {mm} mm, {rad} rad", cobot.name);
        }
        let (mm, rad) = apart(&machine.home.pose, &cobot.flange(&machine.home.drives));
        assert!(mm < 1e-9 && rad < 1e-9, "{} at home: {mm} mm, {rad} rad", cobot.name);
    }
}

/// Sums of the table by hand: at zero the arm lies along −x of the base with the flange towards −y; a pendant shows the same.
#[test]
fn at_zero_the_arms_lie_along_minus_x() {
    for (name, expected) in [("ur10e", [-1184.25, -290.7, 60.85]), ("ur5e", [-817.2, -232.9, 62.8])] {
        let pose = catalogue_machine(name).forward_kinematics(&[0.0; 6]).unwrap().pose;
        assert!((pose.translation - Vector3::from(expected)).norm() < 1e-9, "{name}: {}", pose.translation);
        assert!((pose.rotation.column(2) + Vector3::y()).norm() < 1e-12, "{name}: {}", pose.rotation);
    }
}

#[test]
fn stiffnesses_that_nobody_published_are_assumed_with_wide_intervals() {
    for cobot in &COBOTS {
        let parameters = catalogue_machine(cobot.name).parameters();
        let of = |part: &str| parameters.iter().filter(move |own| own.name.ends_with(part)).collect::<Vec<_>>();
        let stiffnesses = of(".stiffness");
        assert_eq!(stiffnesses.len(), 6, "{}", cobot.name);
        for own in stiffnesses {
            let ([least, most], value) = (own.interval.unwrap(), own.value.unwrap());
            assert_eq!(own.grade, Some(Grade::Assumed), "{}: {}", cobot.name, own.name);
            assert!(least < value && value < most && most / least >= 3.0, "{}: {own:?}", cobot.name);
        }
        for known in ["travel.max", "torque_limit", ".kg"] {
            let grades: Vec<_> =
                of(known).iter().filter(|own| own.name.starts_with("arm.")).map(|own| own.grade).collect();
            assert_eq!(grades, [Some(Grade::DataSheet); 6], "{}: {known}", cobot.name);
        }
    }
}

/// A program through `poses` of the tool at `tip` (mm and rotation vector in the flange), in m and rad.
fn script(tip: &Isometry3<f64>, poses: &[Isometry3<f64>]) -> String {
    let written = |pose: &Isometry3<f64>| {
        let (at, turn) = (pose.translation.vector * 1e-3, pose.rotation.scaled_axis());
        format!("p[{:.15},{:.15},{:.15},{:.15},{:.15},{:.15}]", at.x, at.y, at.z, turn.x, turn.y, turn.z)
    };
    let motions: String = poses.iter().map(|pose| format!("  movel({}, a=1.2, v=0.05)\n", written(pose))).collect();
    format!("def part():\n  set_tcp({})\n{motions}end\n", written(tip))
}

/// Drives by nominal inverse kinematics, and commanded ones with the pose of P that they are to reach, at the point of the program that is nearest to each of
/// `tips`.
fn followed(
    machine: &Machine,
    process: &str,
    script: &str,
    tips: &[Isometry3<f64>],
) -> Vec<(Vec<f64>, Vec<f64>, Pose)> {
    let folder = Folder::in_memory([("part.script".to_owned(), script.as_bytes().to_vec())]);
    let text = format!(
        "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 0.0]\n[force.path_frame]\nradial_force_N = 60.0\ntangential_force_N = -40.0\n\
         axial_force_N = -20.0\n{process}"
    );
    let process =
        Process::from_toml(&text, "process", Folder::in_memory([]), machine).unwrap_or_else(|e| panic!("{e}"));
    let file = process.program_in_folder(&folder, "part.script").unwrap_or_else(|e| panic!("{e}"));
    let job = ProgramJob::new(process, file, "part.script", &Work::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut results: Vec<PathPointResult> = Vec::new();
    let take = |_: &Part<'_>, part: &[PathPointResult]| {
        results.extend_from_slice(part);
        Ok(())
    };
    job.pass_by(Method::Direct, &|| (), take).unwrap();
    let nearest = |tip: &Isometry3<f64>| {
        let far = |k: &usize| (job.path.points()[*k].position_mm - tip.translation.vector).norm();
        let k = (0..results.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
        assert!(far(&k) < 1e-6, "no point at {tip}");
        let result = &results[k];
        assert!(result.status.is_success(), "{}", result.status.reason(machine));
        (result.nominal_drives.clone(), result.drives.clone(), result.target.unwrap())
    };
    tips.iter().map(nearest).collect()
}

const MOVED: [[f64; 6]; 4] = [
    [0.0; 6],
    [20.0, 8.0, -12.0, 5.0, -15.0, 30.0],
    [-25.0, -10.0, 15.0, -20.0, 10.0, -40.0],
    // Wrist 3 beyond half a turn.
    [-10.0, 5.0, 10.0, 10.0, 15.0, -120.0],
];

#[test]
fn a_program_puts_the_joints_where_the_makers_table_has_them() {
    let straight = Isometry3::new(Vector3::new(0.0, 0.0, 150.0), Vector3::new(0.0, 0.0, 0.7));
    // The tool sideways: its z axis is −y of the flange.
    let sideways = Isometry3::new(Vector3::new(10.0, -80.0, 60.0), Vector3::new(FRAC_PI_2, 0.0, 0.0));
    let own_tool = "[tool]\ntip_mm = [10.0, -80.0, 60.0]\naxis = [0.0, -1.0, 0.0]\n";
    for cobot in &COBOTS {
        let machine = catalogue_machine(cobot.name);
        for (tip, process) in [(&straight, ""), (&sideways, own_tool)] {
            let joints = MOVED.map(|moved| cobot.joints(moved));
            let tips = joints.map(|joints| cobot.flange(&joints) * tip);
            for ((nominal, commanded, target), expected) in
                followed(&machine, process, &script(tip, &tips), &tips).iter().zip(joints)
            {
                for (found, expected) in nominal.iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-8, "{}: {nominal:?} instead of {expected}", cobot.name);
                }
                // Corrected drives stand at the corrected pose.
                let (mm, rad) = apart(target, &cobot.flange(commanded));
                assert!(mm < 1e-6 && rad < 1e-9, "{}: {mm} mm, {rad} rad", cobot.name);
                let moved = (target.translation - cobot.flange(nominal).translation.vector).norm();
                assert!((0.1..10.0).contains(&moved), "{}: corrected by {moved} mm", cobot.name);
            }
        }
    }
}

/// The machine file of a cobot with home at other joints (rad).
fn with_home(cobot: &Cobot, joints: &[f64; 6]) -> Machine {
    let flange = cobot.flange(joints);
    let (roll, pitch, yaw) = flange.rotation.euler_angles();
    let mut drive = joints.iter();
    let line = |line: &str| match line.trim_start() {
        text if text.contains("home_deg = ") => {
            let (before, rest) = line.split_once("home_deg = ").unwrap();
            let (_, behind) = rest.split_once(',').unwrap();
            format!("{before}home_deg = {:?},{behind}", drive.next().unwrap().to_degrees())
        }
        text if text.starts_with("rotation_deg = ") => {
            format!("rotation_deg = {:?}", [roll, pitch, yaw].map(f64::to_degrees))
        }
        _ => line.to_owned(),
    };
    let text: Vec<String> = catalogue::find(cobot.name).unwrap().toml.lines().map(line).collect();
    let home = text.join("\n");
    let (before, rest) = home.split_once("[home]\nposition_mm = ").unwrap();
    let (_, behind) = rest.split_once('\n').unwrap();
    let [x, y, z]: [f64; 3] = flange.translation.vector.into();
    machine_from(&format!("{before}[home]\nposition_mm = {:?}\n{behind}", [x, y, z]))
}

/// A pose can be reached in up to eight ways. The one along a program is that of home, which the machine file says.
#[test]
fn the_joints_along_a_program_are_those_of_the_way_of_home() {
    let tip = Isometry3::new(Vector3::new(0.0, 0.0, 150.0), Vector3::zeros());
    let cobot = &COBOTS[0];
    // The base joint at half a turn; wrist 2 bent the other way; the elbow down.
    for degrees in [
        [180.0, -98.0, -105.0, -67.0, 90.0, -77.0],
        [13.0, -98.0, -105.0, -67.0, -90.0, -77.0],
        [-7.0, -150.0, 100.0, -50.0, -90.0, 180.0],
    ] {
        let home = degrees.map(f64::to_radians);
        let machine = with_home(cobot, &home);
        let ahead = std::array::from_fn::<f64, 6, _>(|i| home[i] + [0.1, -0.05, 0.08, 0.1, 0.05, 0.4][i]);
        let tips = [home, ahead].map(|joints| cobot.flange(&joints) * tip);
        let found = followed(&machine, "", &script(&tip, &tips), &tips);
        for ((nominal, ..), expected) in found.iter().zip([home, ahead]) {
            let most = nominal.iter().zip(expected).map(|(found, own)| (found - own).abs()).fold(0.0, f64::max);
            assert!(most < 1e-8, "{degrees:?}: {nominal:?} instead of {expected:?}");
        }
    }
}

/// Where the joints stand another way than home, the machine at rest is the one at these joints.
#[test]
fn without_a_force_a_machine_at_rest_does_not_move_whatever_way_its_joints_stand() {
    let payload = ["--set", "platform.mass.kg=120"];
    for (machine, joints, more) in [
        ("ur10e", "13,-98,-105,-67,-90,-77", &[][..]),
        ("ur5e", "-7,-150,100,-50,-90,180", &[]),
        ("kr270", "0,35,-107,0,110,0", &payload),
    ] {
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_kinetostat"))
            .args(["point", "--json", "--machine", machine, "--wrench", "0,0,0,0,0,0", &format!("--joints={joints}")])
            .args(more)
            .output()
            .unwrap();
        assert!(run.status.success(), "{machine}: {}", String::from_utf8_lossy(&run.stderr));
        let json: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
        let moved = |key: &str| {
            let of = |k: usize| json[key][k].as_f64().unwrap();
            Vector3::new(of(0), of(1), of(2)).norm()
        };
        let (displacement, sag) = (moved("tool_displacement_mm"), moved("tool_displacement_by_weight_mm"));
        assert!(displacement < 1e-9 && sag > 0.3, "{machine}: {displacement} mm, by weight {sag} mm");
    }
}

/// With wrist 2 at half a turn the last axis is parallel to shoulder, elbow and wrist 1: no correction that swings the arm about is given as one.
#[test]
fn at_a_singular_wrist_no_correction_swings_the_arm() {
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_kinetostat"))
        .args(["point", "--machine", "ur10e", "--joints=0,-70,-120,10,180,0", "--wrench=0,0,-100,0,0,0"])
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&run.stdout);
    let is_refused = told.contains("not compensated: drive arm_J") && told.contains("° to keep the tool there");
    assert!(is_refused && told.contains("there is no correction"), "{told}");
}
