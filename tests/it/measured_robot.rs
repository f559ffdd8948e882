//! The R-2000iC of the catalogue against displacements measured on it under load: 30 poses that Liu et al. 2026 published. The
//! repository does not hold them; they are read from the folder `KINETOSTAT_DATA`, or `../shared/data` beside the repository.

use std::path::PathBuf;

use crate::support::engine::{EXACT, catalogue_machine, machine_from};
use kinetostat::{
    machine::{Configuration, Machine, catalogue},
    spatial::Wrench,
    statics::{Scratch, State, Status, equilibrium, tool_compliance, unloaded_compliance},
};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3x6, Matrix4, Vector3, Vector6};

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
fn predicted(machine: &Machine, pose: &Pose, scratch: &mut Scratch) -> Vector3<f64> {
    let at = at(machine, pose);
    let moment = (at.pose.rotation * machine.tool_tip).cross(&pose.force);
    let mut settle = |load: Wrench| {
        let mut state = State::rigid(machine, &at);
        let outcome = equilibrium(machine, &at.drives, &load, &mut state, scratch, &EXACT);
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
    let mut scratch = Scratch::new(&machine);
    for pendant in joints {
        let at = machine.forward_kinematics(&pendant).unwrap();
        let (tip, expected) = joint_compliance(&pendant);
        assert!((at.pose.transform(machine.tool_tip) - tip).norm() < 1e-9, "{pendant:?}");
        let compliance = unloaded_compliance(&machine, &at, &mut scratch).unwrap();
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
    let mut scratch = Scratch::new(machine);
    let residuals = poses.iter().map(|pose| (predicted(machine, pose, &mut scratch) - pose.displacement).norm());
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

/// What a unit of an effect moves the tool tip by at a pose, mm.
type Effect = Box<dyn Fn(&Pose) -> Vector3<f64>>;

/// About an axis (0: x, 2: z) of the frame behind a joint: what the tip moves by for a turn of 1 rad, mm, and the moment of the force, N·mm.
fn turned(pose: &Pose, joint: usize, axis: usize) -> (Vector3<f64>, f64) {
    let frames = frames(&pose.joints);
    let tip = frames[5].transform_point(&nalgebra::Point3::new(6.9, 245.3, 319.3)).coords;
    let (axis, origin) = (frames[joint].fixed_view::<3, 1>(0, axis), frames[joint].fixed_view::<3, 1>(0, 3));
    let arm = axis.cross(&(tip - origin));
    (arm, arm.dot(&pose.force))
}

/// RMS along an axis of what a linear model of these effects leaves of poses not fitted, each fifth in turn, as a share of `measured`, mm;
/// and what it leaves of each pose if all are fitted, mm.
fn crossed(effects: &[&Effect], poses: &[Pose], measured: f64) -> (f64, Vec<Vector3<f64>>) {
    let fitted = |is_used: &dyn Fn(usize) -> bool| {
        let used: Vec<&Pose> = poses.iter().enumerate().filter(|(i, _)| is_used(*i)).map(|(_, pose)| pose).collect();
        let design = DMatrix::from_fn(3 * used.len(), effects.len(), |row, k| effects[k](used[row / 3])[row % 3]);
        let read = DVector::from_fn(3 * used.len(), |row, _| used[row / 3].displacement[row % 3]);
        // Columns of one size: compliances and lost motion have other units.
        let sizes: Vec<f64> = design.column_iter().map(|column| column.norm()).collect();
        let scaled = DMatrix::from_fn(design.nrows(), design.ncols(), |i, j| design[(i, j)] / sizes[j]);
        let solved = scaled.svd(true, true).solve(&read, 1e-12).unwrap();
        solved.iter().zip(&sizes).map(|(x, size)| x / size).collect::<Vec<f64>>()
    };
    let left = |pose: &Pose, x: &[f64]| {
        effects.iter().zip(x).fold(pose.displacement, |left, (effect, x)| left - effect(pose) * *x)
    };
    let mut squares = 0.0;
    for fold in 0..5 {
        let x = fitted(&|i| i % 5 != fold);
        squares += poses.iter().skip(fold).step_by(5).map(|pose| left(pose, &x).norm_squared()).sum::<f64>();
    }
    let all = fitted(&|_| true);
    let share = (squares / (3 * poses.len()) as f64).sqrt() / measured;
    (share, poses.iter().map(|pose| left(pose, &all)).collect())
}

/// Lost motion, stiffness that depends on the load, and a tool that yields, each beside five joints and the elbow's bearing: a linear model
/// of the published table, apart from the library's.
#[test]
fn what_remains_of_the_robot_is_no_lost_motion_and_no_stiffness_that_depends_on_the_load() {
    let Some(poses) = poses() else { return };
    let squares: f64 = poses.iter().map(|pose| pose.displacement.norm_squared()).sum();
    let measured = (squares / (3 * poses.len()) as f64).sqrt();
    let compliance = |joint: usize, axis: usize| -> Effect {
        Box::new(move |pose| {
            let (arm, moment) = turned(pose, joint, axis);
            arm * moment
        })
    };
    let mut basis: Vec<Effect> = (0..5).map(|joint| compliance(joint, 2)).collect();
    let (joints, _) = crossed(&basis.iter().collect::<Vec<_>>(), &poses, measured);
    basis.push(compliance(2, 0));
    let with = |more: &[&Effect]| {
        let effects: Vec<&Effect> = basis.iter().chain(more.iter().copied()).collect();
        crossed(&effects, &poses, measured)
    };
    let (elbow, left) = with(&[]);
    println!(
        "RMS of poses not fitted, of the RMS displacement: joints {joints:.3}, with the elbow's bearing {elbow:.3}; with that and"
    );
    assert!((joints - 0.236).abs() < 0.001 && (elbow - 0.195).abs() < 0.001, "{joints} {elbow}");
    for joint in 0..5 {
        let lost: Effect = Box::new(move |pose| {
            let (arm, moment) = turned(pose, joint, 2);
            arm * moment.signum()
        });
        let dependent: Effect = Box::new(move |pose| {
            let (arm, moment) = turned(pose, joint, 2);
            arm * moment * moment.abs()
        });
        let ((lost, _), (dependent, _)) = (with(&[&lost]), with(&[&dependent]));
        println!(
            "lost motion of J{0} {lost:.3}, a compliance of J{0} that grows with its moment {dependent:.3}",
            joint + 1
        );
        assert!(lost > 0.98 * elbow && dependent > 0.98 * elbow, "J{}: {lost} {dependent}", joint + 1);
    }
    let tool: Effect = Box::new(|pose| pose.force);
    let (tool, _) = with(&[&tool]);
    println!("a tool that yields alike along all axes {tool:.3}");
    assert!(tool < 0.95 * elbow, "{tool}");
    // Three neighbours, of which the first contradicts the others, leave most.
    let total: f64 = left.iter().map(Vector3::norm_squared).sum();
    let mut worst: Vec<usize> = (0..poses.len()).collect();
    worst.sort_by(|&a, &b| left[b].norm().total_cmp(&left[a].norm()));
    for &i in &worst[..6] {
        let Pose { force, displacement, .. } = &poses[i];
        let share = 100.0 * left[i].norm_squared() / total;
        println!(
            "row {}: {share:.0} % of the squares: left {:.2?}, measured {:.2?} mm, force {:.0?} N",
            i + 2,
            left[i].as_slice(),
            displacement.as_slice(),
            force.as_slice()
        );
    }
    assert!(worst[0] == 7 && left[7].norm_squared() > 0.2 * total);
    let near = |i: usize, j: usize| (Vector6::from(poses[i].joints) - Vector6::from(poses[j].joints)).norm();
    assert!(near(7, 8) < 0.5 && near(7, 9) < 0.6, "{} {}", near(7, 8), near(7, 9));
    assert!((left[7] - left[8]).norm() > 0.9 && (left[8] - left[9]).norm() < 0.2);
}
