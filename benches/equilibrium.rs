//! One loaded equilibrium of the Orthoglide: cold from the rigid configuration, and warm from the neighbouring tool
//! angle as a study runs it. Prints the rate per core against the goal.

use std::{hint::black_box, time::Instant};

use criterion::Criterion;
use kinetostat::{
    machine::{Configuration, Machine},
    process::MillingForce,
    spatial::Wrench,
    statics::{Settings, State, Status, Workspace, equilibrium},
};

/// Loaded equilibria per second and core that this bench is held against.
const GOAL_PER_SECOND: f64 = 30_000.0;

struct Setting {
    name: &'static str,
    real: Machine,
    at: Configuration,
    rigid: State,
    loads: Vec<Wrench>,
}

fn settings() -> Vec<Setting> {
    let nominal = Machine::named_or_file("orthoglide").expect("built in");
    let errors = nominal.assembly_errors(&[1.0, -1.0, 1.0]);
    let loads: Vec<Wrench> =
        (0..36).map(|i| MillingForce::PAPER.wrench((10.0 * f64::from(i)).to_radians(), nominal.tool_tip)).collect();
    ["Q0", "Q1"]
        .map(|name| {
            let position = nominal.point(name).expect("named point").position;
            let at = nominal.inverse_kinematics(&nominal.pose_at(position)).expect("reachable");
            let rigid = State::rigid(&nominal, &at);
            Setting { name, real: nominal.with_errors(&errors), at, rigid, loads: loads.clone() }
        })
        .into()
}

/// Solves all tool angles of one turn, each from the one before; Newton iterations made.
fn turn(setting: &Setting, state: &mut State, workspace: &mut Workspace) -> usize {
    let mut iterations = 0;
    for load in &setting.loads {
        let outcome = equilibrium(&setting.real, &setting.at.drives, load, state, workspace, &Settings::default());
        assert_eq!(outcome.status, Status::Solved);
        iterations += outcome.iterations;
    }
    iterations
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    for setting in &settings() {
        let mut workspace = Workspace::new(&setting.real);
        criterion.bench_function(&format!("equilibrium, cold, {}", setting.name), |bencher| {
            let mut state = setting.rigid.clone();
            bencher.iter(|| {
                state.clone_from(&setting.rigid);
                let load = &setting.loads[13];
                black_box(equilibrium(
                    &setting.real,
                    &setting.at.drives,
                    load,
                    &mut state,
                    &mut workspace,
                    &Settings::default(),
                ))
            });
        });
        let mut state = setting.rigid.clone();
        criterion.bench_function(&format!("36 tool angles, warm, {}", setting.name), |bencher| {
            bencher.iter(|| black_box(turn(setting, &mut state, &mut workspace)));
        });
        rate(setting, &mut state, &mut workspace);
    }
    criterion.final_summary();
}

/// Best of several blocks, which a shared machine disturbs least.
fn rate(setting: &Setting, state: &mut State, workspace: &mut Workspace) {
    let mut best = f64::INFINITY;
    let mut iterations = 0;
    for _ in 0..20 {
        let started = Instant::now();
        for _ in 0..20 {
            iterations = turn(setting, state, workspace);
        }
        best = best.min(started.elapsed().as_secs_f64() / (20.0 * setting.loads.len() as f64));
    }
    println!(
        "{}: {:.0} loaded equilibria per second on one core ({:.2} Newton iterations each), {:.2} times the goal of {:.0}\n",
        setting.name,
        1.0 / best,
        iterations as f64 / setting.loads.len() as f64,
        1.0 / (best * GOAL_PER_SECOND),
        GOAL_PER_SECOND
    );
}
