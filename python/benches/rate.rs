//! Equilibria of `Batch` alone: commands and rigid states known, cases set and solved on all threads. `rate.py` runs it, and is held against it.
//!
//! ```sh
//! echo | cargo run --release --example rate -- orthoglide 300 333
//! ```
//!
//! Prints how many cases there are, so many poses that can be commanded under so many loads each; then, for each line that it reads, solves all and
//! prints how many cases there were, how many have an equilibrium, and the largest displacement of the tool tip, mm.

use std::io::stdin;

use kinetostat::{
    Machine, Wrench,
    machine::Configuration,
    nalgebra::Vector3,
    simulation::settings,
    statics::{Batch, Case, State, Status},
};
use rayon::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let [name, poses, loads] = &given[..] else { return Err("expected: rate MACHINE POSES LOADS".into()) };
    let (machine, poses, loads): (_, usize, usize) = (Machine::named(name)?, poses.parse()?, loads.parse()?);
    let share = |i: usize, step: f64| (0.5 + i as f64 * step).fract();
    let place = |i: usize| Vector3::new(share(i, 0.819_172_5), share(i, 0.671_043_6), share(i, 0.549_700_5));
    let size = machine.workspace.max - machine.workspace.min;
    let known = (0..poses).into_par_iter().flat_map_iter(|i| {
        let at = machine.inverse_kinematics_at(machine.workspace.min + size.component_mul(&place(i))).ok();
        at.map(|at| (State::rigid(&machine, &at), at))
    });
    let known: Vec<(State, Configuration)> = known.collect();
    let count = known.len() * loads;
    let load = |j: usize| Wrench::new([215.0, -10.0, -25.0, 0.0, 0.0, 0.0].map(|n| n * (j + 1) as f64 / loads as f64));
    let settings = settings().equilibrium;
    let solve = |batch: &mut Batch, first: usize| {
        let cases = first..count.min(first + Batch::WIDTH);
        let mut own: Vec<_> =
            cases.clone().map(|i| &known[i / loads]).map(|(s, at)| (s.clone(), at.drives.clone())).collect();
        let told = cases.clone().zip(&mut own);
        let mut told: Vec<_> =
            told.map(|(i, (state, drives))| Case { drives, load: load(i % loads), state, task: None }).collect();
        let outcomes = batch.equilibria(&mut told, &settings);
        let (mut solved, mut largest) = (0, 0.0);
        for ((i, outcome), (state, _)) in cases.zip(outcomes).zip(&own) {
            if outcome.status == Status::Solved {
                solved += 1;
                largest = f64::max(largest, machine.tool_displacement(&known[i / loads].1.pose, &state.pose).norm());
            }
        }
        (solved, largest)
    };
    println!("{count}");
    for line in stdin().lines() {
        line?;
        let groups = (0..count).into_par_iter().step_by(Batch::WIDTH);
        let found = groups.map_init(|| Batch::new(&machine), solve);
        let (solved, largest) = found.reduce(|| (0, 0.0), |a: (usize, f64), b| (a.0 + b.0, a.1.max(b.1)));
        println!("{count} {solved} {largest:.9}");
    }
    Ok(())
}
