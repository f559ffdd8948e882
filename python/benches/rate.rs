//! Equilibria at random places under one load, as a program in Rust computes them on all processors: commanded, settled, kept in arrays. What
//! `rate.py` is held against.
//!
//! ```sh
//! cargo run --release --example rate -- 1000000
//! ```

use std::time::Instant;

use kinetostat::{
    Machine, Wrench,
    nalgebra::Vector3,
    simulation::settings,
    statics::{Batch, Case, State, Status},
};
use rayon::prelude::*;

const GROUP: usize = Batch::WIDTH;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count: usize = std::env::args().nth(1).as_deref().unwrap_or("100000").parse()?;
    let machine = Machine::named("orthoglide")?;
    let load = Wrench::new([215.0, -10.0, -25.0, 0.0, 0.0, 0.0]);
    let share = |i: usize, step: f64| (0.5 + i as f64 * step).fract();
    let size = machine.workspace.max - machine.workspace.min;
    let place = |i: usize| Vector3::new(share(i, 0.819_172_5), share(i, 0.671_043_6), share(i, 0.549_700_5));
    let places: Vec<Vector3<f64>> = (0..count).map(|i| machine.workspace.min + size.component_mul(&place(i))).collect();
    let settings = settings().equilibrium;

    let started = Instant::now();
    let (mut poses, mut moved) = (vec![f64::NAN; 16 * count], vec![f64::NAN; 3 * count]);
    let (mut drives, mut solved) = (vec![f64::NAN; 3 * count], vec![false; count]);
    let rows = poses.par_chunks_mut(16 * GROUP).zip(moved.par_chunks_mut(3 * GROUP));
    let rows = rows.zip(drives.par_chunks_mut(3 * GROUP)).zip(solved.par_chunks_mut(GROUP));
    rows.zip(places.par_chunks(GROUP)).for_each_init(
        || Batch::new(&machine),
        |batch, ((((poses, moved), drives), solved), places)| {
            let at: Vec<_> = places.iter().map(|place| machine.command(*place)).collect();
            let mut states: Vec<_> = at.iter().flatten().map(|at| State::rigid(&machine, at)).collect();
            let mut told: Vec<_> = at.iter().flatten().map(|at| at.drives.clone()).collect();
            let cases = told.iter_mut().zip(&mut states);
            let mut cases: Vec<_> = cases.map(|(drives, state)| Case { drives, load, state, task: None }).collect();
            let outcomes = batch.equilibria(&mut cases, &settings);
            let mut found = outcomes.iter().zip(&states).zip(&told);
            for (row, at) in at.iter().enumerate() {
                let (Ok(at), Some(((outcome, state), told))) = (at, if at.is_ok() { found.next() } else { None })
                else {
                    continue;
                };
                solved[row] = outcome.status == Status::Solved;
                let displacement = machine.tool_displacement(&at.pose, &state.pose);
                moved[3 * row..3 * row + 3].copy_from_slice(displacement.as_slice());
                drives[3 * row..3 * row + 3].copy_from_slice(told);
                let pose = state.pose.rotation.insert_column(3, 0.0).insert_row(3, 0.0);
                poses[16 * row..16 * row + 16].copy_from_slice(pose.as_slice());
            }
        },
    );
    let seconds = started.elapsed().as_secs_f64();
    let largest = moved.chunks(3).map(|v| Vector3::from_row_slice(v).norm()).fold(0.0, f64::max);
    let solved = solved.iter().filter(|solved| **solved).count();
    println!("{:.1} {solved} {largest:.9}", count as f64 / seconds);
    Ok(())
}
