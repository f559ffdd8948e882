//! Loaded equilibria of the nominal Orthoglide for the comparison with other programs: prints the cases (loads at P), where
//! the tool goes, and the time of one equilibrium as JSON. `benches/peers/run.sh` runs it.

use std::{hint::black_box, time::Instant};

use kinetostat::{
    machine::{Configuration, Machine},
    process::MillingForce,
    spatial::Wrench,
    statics::{Batch, Case, Level, Scratch, Settings, State, Status, equilibrium},
};
use nalgebra::Vector3;
use serde_json::{Value, json};

/// Tool angles of one turn; a multiple of the widest batch.
const ANGLES: u32 = 24;
/// Shares of the milling force: as it is, and so little of it that what remains is linear.
const LOAD_SHARES: [f64; 2] = [1.0, 1e-3];

fn main() {
    // `cargo test --benches` only asks that the bench runs.
    let rounds = if std::env::args().any(|argument| argument == "--test") { 1 } else { 400 };
    let machine = Machine::named_or_file("orthoglide").expect("built in");
    let divided = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/peers/orthoglide_divided_feet.toml");
    let divided = Machine::named_or_file(divided).unwrap_or_else(|error| panic!("{error}"));
    let points: Vec<Value> = ["Q0", "Q1"].map(|name| point(&machine, &divided, name, rounds)).into();
    println!("{:#}", json!({ "program": "kinetostat", "points": points }));
}

fn point(machine: &Machine, divided: &Machine, name: &str, rounds: usize) -> Value {
    let position = machine.point(name).expect("named point").position;
    let at = machine.inverse_kinematics(&machine.pose_at(position)).expect("reachable");
    let rigid = State::rigid(machine, &at);
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(ANGLES);
    let loads: Vec<Wrench> =
        (0..ANGLES).map(|i| MillingForce::KLIMCHIK_GROOVE.wrench(angle(i), &machine.tool())).collect();

    let mut cases = Vec::new();
    for share in LOAD_SHARES {
        for (i, load) in (0..).zip(&loads) {
            let load = load.scale(share);
            cases.push(json!({
                "load_share": share,
                "tool_angle_deg": angle(i).to_degrees(),
                "wrench_N_Nmm": load.to_array(),
                "tool_displacement_mm": tool_displacement(machine, position, &load),
                "with_divided_feet_mm": tool_displacement(divided, position, &load),
            }));
        }
    }
    let mut setup = f64::INFINITY;
    for _ in 0..rounds {
        let started = Instant::now();
        let at = machine.inverse_kinematics(&machine.pose_at(position)).expect("reachable");
        black_box(State::rigid(machine, &at));
        setup = setup.min(started.elapsed().as_secs_f64());
    }
    let mut times = alone(machine, &at, &rigid, &loads, rounds);
    times.extend(Level::available().into_iter().map(|level| together(machine, &at, &rigid, &loads, level, rounds)));
    let position = position.as_slice();
    json!({ "name": name, "position_mm": position, "cases": cases, "setup_us": 1e6 * setup, "times": times })
}

fn tool_displacement(machine: &Machine, position: Vector3<f64>, load: &Wrench) -> [f64; 3] {
    let at = machine.inverse_kinematics(&machine.pose_at(position)).expect("reachable");
    let mut state = State::rigid(machine, &at);
    solve(machine, &at, load, &mut state, &mut Scratch::new(machine));
    (state.pose.transform(machine.tool_tip) - at.pose.transform(machine.tool_tip)).into()
}

/// One equilibrium after the other: from the rigid machine, and from the one before.
fn alone(machine: &Machine, at: &Configuration, rigid: &State, loads: &[Wrench], rounds: usize) -> Vec<Value> {
    let mut scratch = Scratch::new(machine);
    let mut state = rigid.clone();
    let (mut cold, mut warm) = (f64::INFINITY, f64::INFINITY);
    let (mut cold_iterations, mut warm_iterations) = (0, 0);
    for _ in 0..rounds {
        let started = Instant::now();
        cold_iterations = 0;
        for load in loads {
            state.clone_from(rigid);
            cold_iterations += solve(machine, at, load, &mut state, &mut scratch);
        }
        cold = cold.min(started.elapsed().as_secs_f64());
        let started = Instant::now();
        warm_iterations = 0;
        for load in loads {
            warm_iterations += solve(machine, at, load, &mut state, &mut scratch);
        }
        warm = warm.min(started.elapsed().as_secs_f64());
    }
    vec![
        time("one at a time, from the rigid machine", cold, cold_iterations, loads),
        time("one at a time, from the last tool angle", warm, warm_iterations, loads),
    ]
}

/// Eight tool angles side by side, from the rigid machine.
fn together(
    machine: &Machine,
    at: &Configuration,
    rigid: &State,
    loads: &[Wrench],
    level: Level,
    rounds: usize,
) -> Value {
    let mut batch = Batch::at_level(machine, level);
    let mut states = vec![rigid.clone(); loads.len()];
    let mut drives = vec![at.drives.clone(); loads.len()];
    let (mut best, mut iterations) = (f64::INFINITY, 0);
    for _ in 0..rounds {
        let started = Instant::now();
        iterations = 0;
        let blocks = loads.chunks(Batch::WIDTH).zip(states.chunks_mut(Batch::WIDTH));
        for ((loads, states), drives) in blocks.zip(drives.chunks_mut(Batch::WIDTH)) {
            states.iter_mut().for_each(|state| state.clone_from(rigid));
            let cases = loads.iter().zip(states).zip(drives);
            let mut cases: Vec<Case<'_>> =
                cases.map(|((load, state), drives)| Case { drives, load: *load, state, task: None }).collect();
            for outcome in batch.equilibria(&mut cases, &Settings::default()) {
                assert_eq!(outcome.status, Status::Solved);
                iterations += outcome.iterations;
            }
        }
        best = best.min(started.elapsed().as_secs_f64());
        black_box(&states);
    }
    time(&format!("several at a time ({level:?}), from the rigid machine"), best, iterations, loads)
}

fn solve(machine: &Machine, at: &Configuration, load: &Wrench, state: &mut State, scratch: &mut Scratch) -> usize {
    let outcome = equilibrium(machine, &at.drives, load, state, scratch, &Settings::default());
    assert_eq!(outcome.status, Status::Solved);
    outcome.iterations
}

fn time(how: &str, turn_s: f64, iterations: usize, loads: &[Wrench]) -> Value {
    let count = loads.len() as f64;
    json!({ "how": how, "solve_us": 1e6 * turn_s / count, "iterations": iterations as f64 / count })
}
