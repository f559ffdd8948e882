//! The cutting force of programs behind corners, held against the law, which is evaluated here from vectors, of motions that the test draws
//! itself; how jumps are spread is not known here but by what must hold of it.

use kinetostat::{
    compensation::TaskPoint,
    input::Folder,
    machine::Machine,
    process::{Process, cutting::CuttingLaw},
    products::program::{CuttingLawCheck, Part, ProgramJob},
    spatial::Wrench,
    work::Work,
};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3, Vector6};
use proptest::prelude::*;

use crate::support::cases::cases;

/// Three prismatic joints one on the other, the tool along −z.
const MILL: &str = r#"schema = 1
name = "mill"
title = "Three prismatic joints"
platform = { tool_tip_mm = [3.0, -20.0, -70.0], tool_axis = [0.0, 0.0, -1.0], controls = ["x", "y", "z"] }
home = { position_mm = [0.0, 0.0, 0.0] }
workspace = { min_mm = [-1e5, -1e5, -1e5], max_mm = [1e5, 1e5, 1e5] }
mount = [{ name = "mill", chain = "mill" }]
[[chain]]
name = "mill"
elements = [
  { prismatic_drive = { name = "X", axis = "x", stiffness_N_per_mm = 1000.0, home_mm = 0.0 } },
  { prismatic_drive = { name = "Y", axis = "y", stiffness_N_per_mm = 2000.0, home_mm = 0.0 } },
  { prismatic_drive = { name = "Z", axis = "z", stiffness_N_per_mm = 4000.0, home_mm = 0.0 } },
]
"#;

const PATH_FRAME: &str = "radial_force_N = 200.0\ntangential_force_N = -80.0\naxial_force_N = -100.0\n";

/// A force of each kind, the keys of its table.
const FORCES: [(&str, &str); 6] = [
    ("path_frame", PATH_FRAME),
    ("path_frame", "radial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\nlaw = \"paper_eq17\"\n"),
    (
        "slot_milling",
        "tangential_cutting_N_per_mm2 = 900.0\nradial_cutting_N_per_mm2 = 400.0\naxial_cutting_N_per_mm2 = -150.0\n\
         tangential_edge_N_per_mm = 12.0\naxial_depth_mm = 2.0\nteeth = 3\n",
    ),
    (
        "end_milling",
        "diameter_mm = 10.0\nteeth = 4\naxial_depth_mm = 5.0\nradial_width_mm = 2.5\ncut = \"down\"\nmaterial = \"Al 7075-T6\"\n",
    ),
    (
        "end_milling",
        "diameter_mm = 6.0\nteeth = 2\naxial_depth_mm = 1.0\nradial_width_mm = 5.0\ncut = \"up\"\nmaterial = \"Al 7075-T6\"\n\
         load = \"peak\"\nspindle = \"counter_clockwise\"\n",
    ),
    ("drilling", "diameter_mm = 8.0\nmaterial_constant = 2.41\n"),
];

/// Turns per minute of the spindle.
const SPEED: f64 = 4000.0;

/// Force and moment about the tip in W, N and N·mm, on a tool along `a` (W) that moves along `t` with the feed `feed`.
fn law(law: &CuttingLaw, t: Vector3<f64>, a: Vector3<f64>, feed: f64) -> Vector6<f64> {
    let across = t - a * t.dot(&a);
    let sine = across.norm();
    let forward = if sine > 1e-6 { across / sine } else { Vector3::zeros() };
    let left = forward.cross(&a);
    // Nothing across the tool along its axis, all of it from 5° on.
    let share = ((sine - 1e-6) / (5f64.to_radians().sin() - 1e-6)).clamp(0.0, 1.0);
    // Of the side of a mill all of it: along its axis it cuts nothing.
    let (force, torque, along) = match law {
        CuttingLaw::PathFrame(frame) => {
            let [r, f] = [frame.force.radial, frame.force.tangential];
            let turned = match frame.force.law {
                kinetostat::process::ForceLaw::Rotated => left * r + forward * f,
                kinetostat::process::ForceLaw::PaperEq17 => {
                    let x = (Vector3::x() - a * a.x).normalize();
                    let y = a.cross(&x);
                    // φ is 90° behind the heading.
                    let (cos, sin) = (forward.dot(&y), -forward.dot(&x));
                    x * (r * cos + f * sin) + y * (r * sin + f * cos)
                }
            };
            return six(turned * share + a * frame.force.axial, Vector3::zeros());
        }
        CuttingLaw::SlotMilling(cut) => (cut.mean_force(feed / SPEED / 3.0), 0.0, share),
        CuttingLaw::EndMilling(cut) => {
            let whole = cut.force(feed / SPEED / f64::from(cut.teeth));
            (whole.force_N, whole.torque_Nmm, share)
        }
        CuttingLaw::Drilling(_) if t.dot(&a) < 5f64.to_radians().cos() => return Vector6::zeros(),
        CuttingLaw::Drilling(drill) => {
            let (thrust, torque) = drill.thrust_and_torque(feed / SPEED);
            (Vector3::new(0.0, 0.0, thrust), torque, 1.0)
        }
        other => panic!("{other:?}"),
    };
    six((forward * force.x + left * force.y) * share - a * force.z * along, -a * torque * along)
}

fn six(force: Vector3<f64>, moment: Vector3<f64>) -> Vector6<f64> {
    Wrench { force, moment }.to_vector()
}

/// N, moments at 10 mm.
fn size(load: &Vector6<f64>) -> f64 {
    load.fixed_rows::<3>(0).norm().max(load.fixed_rows::<3>(3).norm() / 10.0)
}

fn job(machine: &Machine, process: &str, program: &str, name: &str) -> ProgramJob {
    let process = Process::from_toml(&format!("schema = 1\n{process}"), "process", Folder::in_memory([]), machine)
        .unwrap_or_else(|error| panic!("{error}"));
    let folder = Folder::in_memory([(name.into(), program.into())]);
    let file = process.program_in_folder(&folder, name).unwrap_or_else(|error| panic!("{error}\n{program}"));
    ProgramJob::new(process, file, name, &Work::default()).unwrap_or_else(|error| panic!("{error}\n{program}"))
}

/// A point of a program.
#[derive(Debug, Clone, Copy)]
struct Seen {
    segment: usize,
    parameter: f64,
    position: Vector3<f64>,
    at_mm: f64,
    cutting: bool,
    feature: Option<u16>,
    /// Tool along it, W.
    axis: Vector3<f64>,
    /// What the job has about the tip, W.
    load: Vector6<f64>,
}

/// The points of `job`, with W turned by `workpiece`.
fn seen(job: &ProgramJob, workpiece: &Matrix3<f64>) -> Vec<Seen> {
    let mut all = Vec::new();
    for part in job.parts() {
        let part = part.unwrap();
        for (point, task) in part.points.iter().zip(part.tasks()) {
            let tool = job.machine.tool_at(&task.pose.rotation);
            let at_tip = task.load.moment - tool.translation.cross(&task.load.force);
            all.push(Seen {
                segment: point.source.segment,
                parameter: point.source.parameter,
                position: point.position_mm,
                at_mm: point.arc_length_mm,
                cutting: point.cutting,
                feature: point.feature,
                axis: workpiece.tr_mul(&tool.rotation.column(2)),
                load: six(workpiece.tr_mul(&task.load.force), workpiece.tr_mul(&at_tip)),
            });
        }
    }
    all
}

/// Whether a plane separates `load` from all of `others`: then it is no convex combination of them.
fn is_apart(load: &Vector6<f64>, others: &[Vector6<f64>]) -> bool {
    let scaled = |load: &Vector6<f64>| {
        let mut scaled = *load;
        scaled.fixed_rows_mut::<3>(3).apply(|moment| *moment /= 10.0);
        scaled
    };
    let load = scaled(load);
    let others: Vec<Vector6<f64>> = others.iter().map(|other| scaled(other) - load).collect();
    let mut nearest = others[0];
    for _ in 0..2000 {
        if nearest.norm() < 1e-5 {
            return false;
        }
        let along = |other: &&Vector6<f64>| other.dot(&nearest);
        let far = others.iter().min_by(|a, b| along(a).total_cmp(&along(b))).unwrap();
        if far.dot(&nearest) > 1e-6 * nearest.norm() {
            return true;
        }
        let step = far - nearest;
        let length = step.norm_squared();
        if length == 0.0 {
            return false;
        }
        nearest += step * (-nearest.dot(&step) / length).clamp(0.0, 1.0);
    }
    false
}

/// Holds the loads of `points` against those of the law, `of`; `jump` is that in the corner at the end of a move, where it is known.
fn held(
    points: &[Seen],
    of: impl Fn(&Seen) -> Vector6<f64>,
    jump: impl Fn(&Seen, &Seen) -> Option<f64>,
    length: f64,
) -> Result<(), TestCaseError> {
    let law: Vec<Vector6<f64>> =
        points.iter().map(|point| if point.cutting { of(point) } else { Vector6::zeros() }).collect();
    let mut begin = 0;
    for (k, point) in points.iter().enumerate() {
        if !point.cutting {
            begin = k + 1;
        }
        let behind = |j: &usize| points[*j].segment != points[j + 1].segment && points[*j].at_mm > point.at_mm - length;
        let corners: Vec<usize> = (begin..k).filter(behind).collect();
        if corners.is_empty() {
            prop_assert!(size(&(point.load - law[k])) < 1e-3, "{k} {point:?} {}", law[k]);
            continue;
        }
        let mut blended = vec![law[k]];
        blended.extend(corners.iter().map(|j| law[*j]));
        prop_assert!(!is_apart(&point.load, &blended), "{k} {point:?} {blended:?}");
        // No farther from the law than what the jumps behind still miss.
        let misses =
            |j: &usize| Some(jump(&points[*j], &points[j + 1])? * (1.0 - (point.at_mm - points[*j].at_mm) / length));
        if let Some(missing) = corners.iter().map(misses).sum::<Option<f64>>() {
            let off = size(&(point.load - law[k]));
            // The first chord of a helix says within a hundredth where it begins.
            let most = blended.iter().map(size).fold(1.0, f64::max);
            prop_assert!(off <= missing + 0.02 * most, "{k} {point:?} {off} {missing}");
        }
    }
    Ok(())
}

/// A move of a drawn program, W, mm.
#[derive(Debug, Clone, Copy)]
struct Move {
    to: Vector3<f64>,
    /// First axis of the plane of an arc, its centre, start and sweep as angles.
    arc: Option<(usize, [f64; 2], [f64; 2])>,
    feed: f64,
    cutting: bool,
}

impl Move {
    fn place(&self, from: &Vector3<f64>, t: f64) -> (Vector3<f64>, Vector3<f64>) {
        let along = self.to - from;
        let Some((first, centre, [start, sweep])) = self.arc else {
            return (from + along * t, along.normalize());
        };
        let (second, normal) = ((first + 1) % 3, (first + 2) % 3);
        let radius_of = |p: &Vector3<f64>| (p[first] - centre[0]).hypot(p[second] - centre[1]);
        let widening = radius_of(&self.to) - radius_of(from);
        let radius = radius_of(from) + widening * t;
        let (sin, cos) = (start + sweep * t).sin_cos();
        let (mut position, mut velocity) = (Vector3::zeros(), Vector3::zeros());
        (position[first], position[second]) = (centre[0] + radius * cos, centre[1] + radius * sin);
        position[normal] = from[normal] + t * along[normal];
        (velocity[first], velocity[second]) =
            (widening * cos - radius * sweep * sin, widening * sin + radius * sweep * cos);
        velocity[normal] = along[normal];
        (position, velocity.normalize())
    }
}

/// What a move is drawn from: its kind, numbers from −1 to 1, and its length.
type Draw = (u8, [f64; 4], f64);

fn rounded(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

/// A program and its moves: lines any way, up and down, on and back, arcs in all planes, also such as go on from the move before but for
/// a thousandth of a millimetre, rapid moves.
fn program(draws: &[Draw], only_lines: bool) -> (String, Vec<Move>) {
    let mut text = format!("G21 G90 G17\nS{SPEED:?} M3\n(BETA)\nG0 X0 Y0 Z0\nG1 Z-1 F300\n(ALPHA)\nG1 X1\n");
    let (mut at, mut along) = (Vector3::new(1.0, 0.0, -1.0), Vector3::x());
    let mut moves = vec![
        Move { to: Vector3::zeros(), arc: None, feed: 0.0, cutting: false },
        Move { to: -Vector3::z(), arc: None, feed: 300.0, cutting: true },
        Move { to: at, arc: None, feed: 300.0, cutting: true },
    ];
    let mut feed = 300.0;
    for &(kind, [a, b, c, d], length) in draws {
        if d > 0.5 {
            feed = 200.0 + (b.abs() * 10.0).round() * 50.0;
        }
        text += if c > 0.7 {
            "(BETA)\n"
        } else if c < -0.7 {
            "(ALPHA)\n"
        } else {
            ""
        };
        let line = |to: Vector3<f64>| (to.map(rounded), None);
        let kind = if only_lines { kind % 4 } else { kind };
        let (to, arc) = match kind {
            0 => line(at + Vector3::z() * (length * a.signum())),
            1 => line(at + along * (length * b.signum())),
            2 => line(at + Vector3::new(a, b, 0.0) * length),
            3 => line(at + Vector3::new(a, b, c) * length),
            9 => line(at + Vector3::new(a, b, 1.0)),
            _ => {
                let first = usize::from(kind % 3);
                let (second, normal) = ((first + 1) % 3, (first + 2) % 3);
                let side = d.signum();
                // Half of them begin along the move before, nearly.
                let begin = match kind % 2 == 0 && along[first].hypot(along[second]) > 0.1 {
                    true => along[second].atan2(along[first]) + 1e-3 * c * a,
                    false => std::f64::consts::PI * a,
                };
                let outward = begin - side * std::f64::consts::FRAC_PI_2;
                let radius = 0.05 + length * 0.5;
                let offset = [-radius * outward.cos(), -radius * outward.sin()].map(rounded);
                let centre = [at[first] + offset[0], at[second] + offset[1]];
                let from = (-offset[1]).atan2(-offset[0]);
                let to_angle = from + side * (0.2 + 2.8 * (b + 1.0));
                let radius = offset[0].hypot(offset[1]);
                let mut to = at;
                (to[first], to[second]) = (centre[0] + radius * to_angle.cos(), centre[1] + radius * to_angle.sin());
                to[normal] += if c > 0.0 { c * length } else { 0.0 };
                let to = to.map(rounded);
                let end = (to[second] - centre[1]).atan2(to[first] - centre[0]);
                let sweep = side * ((end - from) * side).rem_euclid(std::f64::consts::TAU);
                (to, Some((first, centre, [from, sweep])))
            }
        };
        if (to - at).norm() < 1e-3 {
            continue;
        }
        let (x, y, z) = (to.x, to.y, to.z);
        let position = format!("X{x:.6} Y{y:.6} Z{z:.6}");
        match arc {
            None if kind == 9 => text += &format!("G0 {position}\n"),
            None => text += &format!("G1 {position} F{feed:?}\n"),
            Some((first, centre, [_, sweep])) => {
                let plane = ["G17", "G19", "G18"][first];
                let code = if sweep > 0.0 { "G3" } else { "G2" };
                let letters = ['I', 'J', 'K'];
                let second = (first + 1) % 3;
                let (i, j) = (rounded(centre[0] - at[first]), rounded(centre[1] - at[second]));
                text += &format!(
                    "{plane} {code} {position} {}{i:.6} {}{j:.6} F{feed:?}\n",
                    letters[first], letters[second]
                );
            }
        }
        let own = Move { to, arc, feed, cutting: kind != 9 };
        along = own.place(&at, 1.0).1;
        moves.push(own);
        at = to;
    }
    (text + "M30\n", moves)
}

fn forces([alpha, beta]: [usize; 2], corner_mm: f64) -> String {
    let of = |name: &str, force: usize| format!("[force_of_feature.{name}.{}]\n{}", FORCES[force].0, FORCES[force].1);
    format!("{}{}[compensate]\ncorner_mm = {corner_mm:?}\n", of("ALPHA", alpha), of("BETA", beta))
}

fn draws(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Draw>> {
    let lengths = prop_oneof![0.02f64..0.6, 0.5f64..6.0];
    prop::collection::vec((0u8..10, prop::array::uniform4(-1.0f64..1.0), lengths), count)
}

proptest! {
    #![proptest_config(cases(120))]

    #[test]
    fn behind_corners_the_load_lies_between_loads_of_the_law_and_leaves_it_by_no_more_than_the_jump(
        draws in draws(1..14), laws in prop::array::uniform2(0..FORCES.len()), corner_mm in 0.2f64..4.0, yaw in -180.0f64..180.0,
    ) {
        let machine = Machine::from_toml(MILL, "mill.toml").unwrap();
        let (text, moves) = program(&draws, false);
        let placed = format!("[placement]\norigin_mm = [5.0, 7.0, -9.0]\nyaw_deg = {yaw:?}\n{}", forces(laws, corner_mm));
        let job = job(&machine, &placed, &text, "drawn.nc");
        let workpiece = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw.to_radians());
        let points = seen(&job, workpiece.matrix());
        let place = |segment: usize, t: f64| moves[segment].place(&moves[segment.max(1) - 1].to, t);
        for point in points.iter().filter(|point| point.segment > 0) {
            let drawn = place(point.segment, point.parameter).0;
            prop_assert!((point.position - drawn).norm() < 1e-4, "{point:?} {drawn}\n{text}");
            prop_assert_eq!(point.cutting, moves[point.segment].cutting);
        }
        let of = |point: &Seen, [segment, t]: [f64; 2]| {
            let own = &job.process.own_forces.by_feature[usize::from(point.feature.unwrap())].1;
            let segment = segment as usize;
            law(own, place(segment, t).1, point.axis, moves[segment].feed)
        };
        let at = |point: &Seen| of(point, [point.segment as f64, point.parameter]);
        let jump = |from: &Seen, to: &Seen| Some(size(&(of(to, [to.segment as f64, 0.0]) - at(from))));
        // A drill begins to drill at an angle, which rounding may miss.
        let is_at_edge = |point: &Seen| {
            let leaning = |t: f64| (place(point.segment, t).1.dot(&point.axis) - 5f64.to_radians().cos()).abs() < 1e-5;
            leaning(point.parameter) || leaning(0.0)
        };
        prop_assume!(!points.iter().any(|point| point.segment > 0 && is_at_edge(point)));
        held(&points, at, jump, corner_mm).map_err(|fault| TestCaseError::fail(format!("{fault}\n{text}")))?;
    }

    #[test]
    fn between_lines_the_load_is_the_mean_of_the_law_over_the_length_behind(
        draws in draws(1..14), laws in prop::array::uniform2(0..FORCES.len()), corner_mm in 0.2f64..4.0,
    ) {
        let machine = Machine::from_toml(MILL, "mill.toml").unwrap();
        let (text, moves) = program(&draws, true);
        let job = job(&machine, &forces(laws, corner_mm), &text, "drawn.nc");
        let points = seen(&job, &Matrix3::identity());
        let mut pieces: Vec<(f64, Vector6<f64>)> = Vec::new();
        for point in &points {
            if point.segment == 0 {
                continue;
            }
            let own = &job.process.own_forces.by_feature[usize::from(point.feature.unwrap())].1;
            let along = (moves[point.segment].to - moves[point.segment - 1].to).normalize();
            let load = law(own, along, point.axis, moves[point.segment].feed);
            // Before cutting began, as if it had begun earlier.
            let from = pieces.last().map_or(f64::NEG_INFINITY, |piece| piece.0);
            pieces.push((point.at_mm, load));
            let mut mean = Vector6::zeros();
            let mut begin = f64::NEG_INFINITY;
            for (end, load) in &pieces {
                mean += load * ((end - begin.max(point.at_mm - corner_mm)).max(0.0) / corner_mm);
                begin = *end;
            }
            prop_assert!(from <= point.at_mm && size(&(point.load - mean)) < 1e-6, "{point:?} {mean}\n{text}");
        }
    }

    #[test]
    fn on_a_robot_that_turns_its_tool_the_load_lies_between_loads_of_the_law(
        rows in prop::collection::vec((prop::array::uniform3(-1.0f64..1.0), prop::array::uniform3(-0.5f64..0.5), 0.1f64..5.0), 2..14),
        force in 0..2usize, corner_mm in 0.2f64..4.0,
    ) {
        let machine = Machine::named("kr270").unwrap();
        let mut text = String::from("x_mm,y_mm,z_mm,platform_qw,platform_qx,platform_qy,platform_qz\n");
        let (mut at, mut places) = (Vector3::zeros(), Vec::new());
        for (step, turn, length) in rows {
            let q = UnitQuaternion::from_scaled_axis(Vector3::from(turn)).into_inner();
            text += &format!("{:?},{:?},{:?},{:?},{:?},{:?},{:?}\n", at.x, at.y, at.z, q.w, q.i, q.j, q.k);
            places.push(at);
            at += Vector3::from(step) * length;
        }
        let process = format!(
            "[placement]\norigin_mm = [1500.0, 20.0, 900.0]\nroll_deg = 20.0\npitch_deg = -30.0\nyaw_deg = 50.0\n\
             [force.{}]\n{}[compensate]\ncorner_mm = {corner_mm:?}\n", FORCES[force].0, FORCES[force].1
        );
        let job = job(&machine, &process, &text, "rows.csv");
        let [roll, pitch, yaw] = [20f64, -30.0, 50.0].map(f64::to_radians);
        let workpiece = Rotation3::from_euler_angles(roll, pitch, yaw);
        let points = seen(&job, workpiece.matrix());
        let chord = |row: usize| (places[row] - places[row - 1]).normalize();
        // On a row the direction of arrival, or on a curve the mean.
        let direction = |point: &Seen| {
            let row = point.segment.max(1);
            let arrival = chord(row);
            let next = (point.parameter == 1.0 && point.segment > 0 && row + 1 < places.len()).then(|| chord(row + 1));
            next.filter(|next| arrival.angle(next) <= 20f64.to_radians()).map_or(arrival, |next| (arrival + next).normalize())
        };
        let of = |point: &Seen| law(&job.process.cutting, direction(point), point.axis, 0.0);
        held(&points, of, |_, _| None, corner_mm)?;
    }
}

/// Sizes of the force along a program on the mill, by the first of the laws.
fn along(program: &str) -> Vec<f64> {
    let machine = Machine::from_toml(MILL, "mill.toml").unwrap();
    let job = job(&machine, &format!("[force.path_frame]\n{PATH_FRAME}"), program, "program.nc");
    seen(&job, &Matrix3::identity()).iter().map(|point| point.load.fixed_rows::<3>(0).norm()).collect()
}

#[test]
fn an_arc_behind_a_corner_and_one_that_begins_along_the_tool_have_no_more_force_than_the_law() {
    let most = Vector3::new(200.0, 80.0, 100.0).norm();
    for program in [
        "G21 G90 G17\nG0 X0 Y0 Z0\nG1 X10 F100\nG2 X10 Y0.6 I0 J0.3\nG1 X20\nM30\n",
        "G21 G90 G17\nG0 X10.013 Y-0.094 Z5\nG1 Z-1 F500\nG18 G2 X9.013 Z-2 I-1 K0.001\nG1 X-20\nG0 Z5\nM30\n",
        "G21 G90 G17\nG0 X8.946 Y-0.094 Z5\nG1 Z-7.905 F500\nG19 G3 Y0. Z-8. R0.095\nG1 Y30\nG0 Z5\nM30\n",
    ] {
        let sizes = along(program);
        let found = sizes.iter().copied().fold(0.0, f64::max);
        assert!(found <= most * (1.0 + 1e-9) && found > 0.99 * most, "{found} {sizes:?}\n{program}");
    }
}

#[test]
fn a_micrometre_in_a_centre_changes_the_force_by_little() {
    let arc = |k: f64| {
        let program = format!("G21 G90 G17\nG0 X10.013 Y0 Z5\nG1 Z-1 F500\nG18 G2 X9.013 Z-2 I-1 K{k:.6}\nG1 X-20\n");
        let machine = Machine::from_toml(MILL, "mill.toml").unwrap();
        let job = job(&machine, &format!("[force.path_frame]\n{PATH_FRAME}"), &program, "arc.nc");
        seen(&job, &Matrix3::identity())
    };
    let exact = arc(0.0);
    for k in [1e-3, -1e-3, 1e-5, -1e-6] {
        let off = arc(k);
        assert_eq!(off.len(), exact.len());
        for (off, exact) in off.iter().zip(&exact) {
            let differs = (off.load - exact.load).norm();
            // With the centre off by k the radius of 1 mm turns the beginning by k, and what it is longer at the end, a right angle on,
            // by 2 k/π: shares of the 5° on which the force comes in.
            let turned = k.abs() * (1.0 + std::f64::consts::FRAC_2_PI);
            let expected = Vector3::new(200.0, 80.0, 0.0).norm() * turned / 5f64.to_radians().sin() * 1.01 + 1e-3;
            assert!(differs < expected, "{k} {differs} {off:?} {exact:?}");
        }
    }
}

#[test]
fn a_force_that_the_law_does_not_give_is_no_proof() {
    let machine = Machine::named("orthoglide").unwrap();
    let process = format!("schema = 1\n[force.path_frame]\n{PATH_FRAME}");
    let process = Process::from_toml(&process, "process", Folder::in_memory([]), &machine).unwrap();
    let program = b"G21 G90 G17\nG0 X0 Y0 Z0\nG1 X10 F100\nG2 X10 Y0.6 I0 J0.3\nG1 X20\nG0 Z5\n";
    let folder = Folder::in_memory([("part.nc".into(), program.to_vec())]);
    let file = process.program_in_folder(&folder, "part.nc").unwrap();
    let job = ProgramJob::new(process, file, "part.nc", &Work::default()).unwrap();
    let part = job.parts().next().unwrap().unwrap();
    let proof_of = |part: &Part<'_>| CuttingLawCheck::new(&job).check(part);
    proof_of(&part).unwrap();
    let first = part.tasks()[1].load;
    let wrong: [&dyn Fn(&TaskPoint) -> Wrench; 4] = [
        &|task| task.load.scale(1.000_001),
        &|task| Wrench { force: -task.load.force, ..task.load },
        &|task| Wrench { moment: task.load.moment.add_scalar(0.01), ..task.load },
        // That of the first move all along.
        &|_| first,
    ];
    for load in wrong {
        let refused =
            proof_of(&part.with_tasks(|task| TaskPoint { load: load(task), ..*task })).unwrap_err().to_string();
        assert!(refused.contains("is not between those of its law"), "{refused}");
    }
}
