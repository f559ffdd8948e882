//! What a derivative of a loaded pose by one parameter costs beside a solve, at places all over the workspace. Prints both.

use std::{hint::black_box, time::Instant};

use kinetostat::{
    machine::{Configuration, Machine},
    spatial::Wrench,
    statics::{Scratch, Sensitivities, Settings, State, Status, equilibrium},
};
use nalgebra::Vector3;

/// Share of a solve that this bench is held against.
const GOAL: f64 = 0.25;
const ROUNDS: usize = 40;

const CASES: [(&str, &[&str]); 3] = [
    ("orthoglide", &["leg.rail.stiffness", "leg.foot.length", "leg.foot.height", "x.rail.offset", "y.turn", "z.turn"]),
    (
        "fanuc_r2000ic",
        &[
            "arm.J1.stiffness",
            "arm.J2.stiffness",
            "arm.J3.stiffness",
            "arm.J4.stiffness",
            "arm.J5.stiffness",
            "arm.J6.stiffness",
        ],
    ),
    ("hexapod", &["leg.screw.stiffness", "leg.strut.length", "leg1.screw.offset"]),
];

fn places(machine: &Machine) -> Vec<Configuration> {
    let at = |i: usize| {
        let share = |k: usize| 0.3 + 0.4 * ((i * k) % 7) as f64 / 6.0;
        let size = machine.workspace.max - machine.workspace.min;
        let position = machine.workspace.min + size.component_mul(&Vector3::new(share(1), share(2), share(3)));
        machine.inverse_kinematics_at(position).ok()
    };
    (0..7).filter_map(at).collect()
}

fn main() {
    let load = Wrench::new([90.0, -150.0, -60.0, 4e3, -2e3, 3e3]);
    for (name, parameters) in CASES {
        let machine = Machine::named_or_file(name).expect("built in");
        let mut all = Sensitivities::new(&machine, parameters).unwrap_or_else(|e| panic!("{e}"));
        let mut none = Sensitivities::new::<&str>(&machine, &[]).expect("nothing to be wrong");
        let mut scratch = Scratch::new(&machine);
        let places = places(&machine);
        let (mut solve, mut shared, mut each) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        for _ in 0..ROUNDS {
            let start = Instant::now();
            let states: Vec<State> = (places.iter())
                .map(|at| {
                    let mut state = State::rigid(&machine, at);
                    let outcome =
                        equilibrium(&machine, &at.drives, &load, &mut state, &mut scratch, &Settings::default());
                    assert_eq!(outcome.status, Status::Solved);
                    state
                })
                .collect();
            let per_place = 1e6 / places.len() as f64;
            solve = solve.min(start.elapsed().as_secs_f64() * per_place);
            let mut time = |of: &mut Sensitivities| {
                let start = Instant::now();
                for (at, state) in places.iter().zip(&states) {
                    black_box(of.at(&machine, &at.drives, state, &|_| load, &mut scratch)).expect("held");
                }
                start.elapsed().as_secs_f64() * per_place
            };
            let without = time(&mut none);
            shared = shared.min(without);
            each = each.min((time(&mut all) - without) / parameters.len() as f64);
        }
        let share = each / solve;
        println!("{name}: solve {solve:.1} µs; all sensitivities {shared:.1} µs and {each:.2} µs for each parameter");
        println!("  one parameter more: {share:.2} of a solve (goal {GOAL})");
    }
}
