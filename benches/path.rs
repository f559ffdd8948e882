//! A 10 000-point path, warm-started along the path: drives and modified target of every point, by every method. Prints
//! the rate per core of the direct method against the goal.

use std::time::Instant;

use kinetostat::{
    compensation::{CompensationSettings, Method, Session, Target, TaskPoint, compensate},
    machine::Machine,
    process::MillingForce,
};
use nalgebra::Vector3;

/// Compensated points per second and core that this bench is held against.
const GOAL_PER_SECOND: f64 = 10_000.0;
const POINTS: u32 = 10_000;

fn main() {
    // Cargo passes harness options, and `cargo test --benches` only asks that the bench runs.
    let points = if std::env::args().any(|argument| argument == "--test") { 10 } else { POINTS };
    let nominal = Machine::named_or_file("orthoglide").expect("built in");
    let errors = nominal.assembly_errors(&[1.0, -1.0, 1.0]);
    let actual = nominal.with_errors(&errors);
    let centre = nominal.point("Q1").expect("named point").position;
    let tasks: Vec<TaskPoint> = (0..points)
        .map(|i| {
            let phi = std::f64::consts::TAU * f64::from(i) / f64::from(points);
            TaskPoint {
                pose: nominal.pose_at(centre + Vector3::new(phi.cos(), phi.sin(), 0.0) * 25.0),
                load: MillingForce::KLIMCHIK_GROOVE.wrench(phi, &nominal.tool()),
                target: Target::ToolTip,
                wanted: None,
                aside: nalgebra::Vector3::zeros(),
                external: None,
                led: None,
                asked: None,
            }
        })
        .collect();
    let settings = CompensationSettings::with_equilibrium_tolerance(1e-12);
    println!("{points} points of a 50 mm circle at Q1, one core");
    for method in Method::ALL {
        let mut session = Session::new(&nominal, &actual, settings);
        let (mut corrections, mut worst) = (0, 0.0f64);
        let started = Instant::now();
        for task in &tasks {
            let done = compensate(&mut session, task, method);
            assert!(done.status.is_success(), "{method:?}: {:?}", done.status);
            assert!(session.target().is_ok());
            corrections += done.iterations();
            worst = worst.max(done.task_error());
        }
        let time = started.elapsed().as_secs_f64() / f64::from(points);
        println!(
            "  {:<14} {:>8.1} µs per point, {:>5.2} corrections, worst residual error {worst:.1e} mm",
            method.label(),
            1e6 * time,
            f64::from(corrections as u32) / f64::from(points)
        );
        if method == Method::Direct {
            println!(
                "{:.0} compensated points per second on one core, {:.2} times the goal of {GOAL_PER_SECOND:.0}",
                1.0 / time,
                1.0 / (time * GOAL_PER_SECOND)
            );
        }
    }
}
