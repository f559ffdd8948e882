//! What compensating the tool tip alone costs beside tool tip and orientation, on every built-in machine: a map's work, points all over
//! the workspace under a turning force, each tool angle from the one before. Prints the ratio of both, of the same run and by turns.

use std::time::Instant;

use kinetostat::{
    Batch, CompensationSettings, Machine, Method, MillingForce, Session, Target, TaskPoint, compensate,
    compensation::compensate_batch, machine::catalogue, nalgebra::Vector3,
};

/// Most time that the tool tip may cost, in those of the full pose.
const GOAL: f64 = 2.0;

/// Points that can be reached, spread evenly over the workspace box.
fn points(machine: &Machine, count: usize) -> Vec<Vector3<f64>> {
    let share = |i: u32, step: f64| (0.5 + f64::from(i) * step).fract();
    let spread = (0..10_000).map(|i| {
        let at = Vector3::new(share(i, 0.819_172_5), share(i, 0.671_043_6), share(i, 0.549_700_5));
        machine.workspace.min + (machine.workspace.max - machine.workspace.min).component_mul(&at)
    });
    spread.filter(|&at| machine.inverse_kinematics(&machine.pose_at(at)).is_ok()).take(count).collect()
}

/// Seconds and points solved of all tool angles at `points`.
fn turn(machine: &Machine, points: &[Vector3<f64>], angles: u32, target: Target, is_alone: bool) -> (f64, usize) {
    let mut solved = 0;
    let mut batch = Batch::new(machine);
    let mut sessions: Vec<Session> =
        points.iter().map(|_| Session::new(machine, machine, CompensationSettings::default())).collect();
    let started = Instant::now();
    for (points, sessions) in points.chunks(Batch::WIDTH).zip(sessions.chunks_mut(Batch::WIDTH)) {
        for i in 0..angles {
            let phi = std::f64::consts::TAU * f64::from(i) / f64::from(angles);
            let load = MillingForce::KLIMCHIK_GROOVE.wrench(phi, &machine.tool());
            let task = |&at| TaskPoint::new(machine.pose_at(at), load, target);
            let tasks: Vec<TaskPoint> = points.iter().map(task).collect();
            let mut sessions: Vec<&mut Session> = sessions.iter_mut().collect();
            let answers = match is_alone {
                true => {
                    sessions.iter_mut().zip(&tasks).map(|(own, task)| compensate(own, task, Method::Direct)).collect()
                }
                false => compensate_batch(&mut sessions, &tasks, Method::Direct, &mut batch),
            };
            solved += answers.iter().filter(|answer| answer.status.is_success()).count();
        }
    }
    (started.elapsed().as_secs_f64(), solved)
}

fn main() {
    let is_test = std::env::args().any(|argument| argument == "--test");
    let (count, angles, rounds) = if is_test { (8, 2, 1) } else { (64, 36, 5) };
    for name in catalogue::names() {
        let machine = Machine::named_or_file(name).expect("built in");
        let points = points(&machine, count);
        let ways =
            [(Target::ToolTip, false), (Target::FullPose, false), (Target::ToolTip, true), (Target::FullPose, true)];
        let mut best = [f64::INFINITY; 4];
        let mut solved = [0; 4];
        for _ in 0..rounds {
            for (i, (target, is_alone)) in ways.into_iter().enumerate() {
                let (seconds, count) = turn(&machine, &points, angles, target, is_alone);
                best[i] = best[i].min(seconds);
                solved[i] = count;
            }
        }
        let ratio = best[0] / best[1];
        println!(
            "{name:16} tool_tip {ratio:5.2} times full_pose (goal {GOAL}), {:6.1} µs a point; alone {:5.2} and {:5.2} times that; solved {} and {}",
            1e6 * best[0] / solved[0].max(1) as f64,
            best[2] / best[1],
            best[3] / best[1],
            solved[0],
            solved[1],
        );
    }
}
