//! The R-2000iC of the catalogue against displacements measured on it under load: 30 poses that Liu et al. 2026 published. The
//! repository does not hold them; they are read from the folder `KINETOSTAT_DATA`, or `../shared/data` beside the repository.

use std::path::PathBuf;

use crate::support::engine::{EXACT, catalogue_machine, machine_from};
use kinetostat::{
    machine::{Configuration, Machine, catalogue},
    spatial::Wrench,
    statics::{State, Status, Workspace, equilibrium, tool_compliance, unloaded_compliance},
};
use nalgebra::{Matrix3, Matrix3x6, Matrix4, Vector3};

const MACHINE: &str = "fanuc_r2000ic";

/// A measured pose: joints as the pendant shows them (rad), force on the tool tip (N) and its displacement (mm), base axes.
struct Pose {
    joints: [f64; 6],
    force: Vector3<f64>,
    displacement: Vector3<f64>,
}

/// `None` and a printed reason where the measurements are not at hand.
fn poses() -> Option<Vec<Pose>> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("KINETOSTAT_DATA").map_or_else(beside, PathBuf::from);
    let file = folder.join(MACHINE).join("poses.csv");
    let Ok(text) = std::fs::read_to_string(&file) else {
        println!("skipped: no measurements at {}; the project does not ship them", file.display());
        return None;
    };
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.trim().parse().unwrap()).collect();
        assert_eq!(cells.len(), 13, "{line}");
        let vector = |first: usize| Vector3::from_column_slice(&cells[first..first + 3]);
        Pose { joints: cells[1..7].try_into().unwrap(), force: vector(7), displacement: vector(10) }
    };
    let poses: Vec<Pose> = text.lines().skip(1).filter(|line| !line.is_empty()).map(row).collect();
    assert_eq!(poses.len(), 30);
    Some(poses)
}

fn at(machine: &Machine, pose: &Pose) -> Configuration {
    machine.forward_kinematics(&pose.joints).unwrap_or_else(|e| panic!("{:?}: {e}", pose.joints))
}

/// What the force does to the tool tip of the machine at rest under its weight, mm.
fn predicted(machine: &Machine, pose: &Pose, workspace: &mut Workspace) -> Vector3<f64> {
    let at = at(machine, pose);
    let moment = (at.pose.rotation * machine.tool_tip).cross(&pose.force);
    let mut settle = |load: Wrench| {
        let mut state = State::rigid(machine, &at);
        let outcome = equilibrium(machine, &at.drives, &load, &mut state, workspace, &EXACT);
        assert_eq!(outcome.status, Status::Solved);
        state.pose
    };
    let rest = settle(Wrench::zero());
    machine.tool_displacement(&rest, &settle(Wrench { force: pose.force, moment }))
}

/// The published modified Denavit-Hartenberg table: α and a of the link before, offset of θ, d; rad, mm.
fn frames(pendant: &[f64; 6]) -> [Matrix4<f64>; 6] {
    use std::f64::consts::FRAC_PI_2;
    let table = [
        (0.0, 0.0, 0.0, 670.0),
        (-FRAC_PI_2, 312.0, -FRAC_PI_2, 0.0),
        (0.0, 1075.0, 0.0, 0.0),
        (-FRAC_PI_2, 225.0, 0.0, 1280.0),
        (FRAC_PI_2, 0.0, 0.0, 0.0),
        (-FRAC_PI_2, 0.0, 0.0, 215.0),
    ];
    let [q1, q2, q3, q4, q5, q6] = *pendant;
    let joints = [q1, q2, -(q2 + q3), -q4, -q5, -q6];
    let mut frame = Matrix4::identity();
    std::array::from_fn(|i| {
        let (alpha, a, offset, d) = table[i];
        let (s, c) = (joints[i] + offset).sin_cos();
        let (sa, ca) = alpha.sin_cos();
        #[rustfmt::skip]
        let step = Matrix4::new(
            c, -s, 0.0, a,
            s * ca, c * ca, -sa, -d * sa,
            s * sa, c * sa, ca, d * ca,
            0.0, 0.0, 0.0, 1.0,
        );
        frame *= step;
        frame
    })
}

/// J C Jᵀ of the tool tip, mm/N, from the published table and joint stiffnesses alone.
fn joint_compliance(pendant: &[f64; 6]) -> (Vector3<f64>, Matrix3<f64>) {
    let frames = frames(pendant);
    let tip = frames[5].transform_point(&nalgebra::Point3::new(6.9, 245.3, 319.3)).coords;
    let stiffness = [9.339e8, 4.129e9, 1.908e9, 2.332e8, 4.044e8, 7.962e7];
    let mut jacobian = Matrix3x6::zeros();
    for (i, frame) in frames.iter().enumerate() {
        let (axis, origin) = (frame.fixed_view::<3, 1>(0, 2), frame.fixed_view::<3, 1>(0, 3));
        jacobian.set_column(i, &(axis.cross(&(tip - origin)) / f64::sqrt(stiffness[i])));
    }
    (tip, jacobian * jacobian.transpose())
}

#[test]
fn pendant_angles_and_linear_compliance_are_those_of_the_published_table() {
    let machine = catalogue_machine(MACHINE);
    let home: [f64; 6] = machine.home.drives.as_slice().try_into().unwrap();
    let mut joints = vec![home, [0.3, -0.4, 0.2, -0.5, 0.7, 1.2]];
    joints.extend(poses().iter().flatten().map(|pose| pose.joints));
    let mut workspace = Workspace::new(&machine);
    for pendant in joints {
        let at = machine.forward_kinematics(&pendant).unwrap();
        let (tip, expected) = joint_compliance(&pendant);
        assert!((at.pose.transform(machine.tool_tip) - tip).norm() < 1e-9, "{pendant:?}");
        let compliance = unloaded_compliance(&machine, &at, &mut workspace).unwrap();
        let got = tool_compliance(&compliance, at.pose.rotation * machine.tool_tip);
        assert!((got - expected).amax() < 1e-6 * expected.amax(), "{pendant:?}: {got} {expected}");
    }
}

/// What a model leaves of the measured displacements.
struct Left {
    /// RMS of the components, mm.
    per_axis: f64,
    /// RMS of the vectors, as a share of that of the measured ones.
    share: f64,
    /// Largest vector, mm.
    worst: f64,
}

fn left(machine: &Machine, poses: &[Pose]) -> Left {
    let mut workspace = Workspace::new(machine);
    let residuals = poses.iter().map(|pose| (predicted(machine, pose, &mut workspace) - pose.displacement).norm());
    let residuals: Vec<f64> = residuals.collect();
    let sum: f64 = residuals.iter().map(|r| r * r).sum();
    let measured: f64 = poses.iter().map(|pose| pose.displacement.norm_squared()).sum();
    Left {
        per_axis: (sum / (3 * poses.len()) as f64).sqrt(),
        share: (sum / measured).sqrt(),
        worst: residuals.iter().copied().fold(0.0, f64::max),
    }
}

#[test]
fn published_stiffnesses_leave_a_quarter_of_the_measured_displacement() {
    let Some(poses) = poses() else { return };
    let text = catalogue::find(MACHINE).unwrap().toml;
    let published = ["9.339e8", "4.129e9", "1.908e9", "2.332e8", "4.044e8", "7.962e7"];
    // Six compliances fitted to all 43 published poses by least squares.
    let fitted = ["8.61e8", "2.72e9", "1.96e9", "2.71e8", "4.25e8", "2.1e8"];
    let with = |stiffnesses: [&str; 6]| {
        let pairs = published.iter().zip(stiffnesses);
        let changed = |text: String, (from, to): (&&str, &str)| {
            let key = |value: &str| format!("stiffness_Nmm_per_rad = {value}");
            assert!(text.contains(&key(from)), "{from}");
            text.replace(&key(from), &key(to))
        };
        machine_from(&pairs.fold(text.to_string(), changed))
    };
    let mut rigid_sixth = published;
    rigid_sixth[5] = "1e13";
    let of = |what: &str, stiffnesses: [&str; 6]| {
        let left = left(&with(stiffnesses), &poses);
        println!(
            "{what}: {:.3} mm RMS per axis, {:.1} % of the measured RMS displacement, {:.2} mm at most",
            left.per_axis,
            left.share * 100.0,
            left.worst
        );
        left
    };
    let left = of("published stiffnesses", published);
    let fit = of("least-squares fit (of these and 13 more poses)", fitted);
    let rigid = of("published, sixth joint rigid", rigid_sixth);
    for pose in poses.iter().take(1) {
        assert!(at(&with(published), pose).pose.translation.norm() > 1000.0);
    }
    assert!((left.per_axis - 0.2556).abs() < 0.0010, "{}", left.per_axis);
    assert!((left.share - 0.2611).abs() < 0.0010, "{}", left.share);
    // What the data cannot tell: a sixth joint 2.6 times stiffer, or rigid, is no worse.
    assert!(fit.per_axis < left.per_axis && rigid.per_axis < left.per_axis, "{} {}", fit.per_axis, rigid.per_axis);
}
