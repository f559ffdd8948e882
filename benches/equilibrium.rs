//! Loaded equilibria of the Orthoglide: one alone, and many several at a time, warm from the neighbouring tool angle as a
//! study runs them. Prints rates per core against the goal, the ratio of lanes to the scalar path, how the cost grows with
//! the number of points, what a second thread gives, and what machines of rigid links cost beside the Orthoglide.

use std::{hint::black_box, sync::Barrier, time::Instant};

use criterion::Criterion;
use kinetostat::{
    machine::{Configuration, Machine},
    process::MillingForce,
    spatial::Wrench,
    statics::{Batch, Case, Level, Scratch, Settings, State, Status, equilibrium},
};
use nalgebra::Vector3;

/// Loaded equilibria per second and core that this bench is held against.
const GOAL_PER_SECOND: f64 = 200_000.0;
/// Gain of a second thread that this bench is held against.
const GOAL_TWO_THREADS: f64 = 1.9;

/// Floating-point operations of a warm equilibrium at Q1; counted by a test in `crates/engine/tests/it/operations.rs`.
const OPERATIONS: f64 = 50_650.0;

/// Points of the actual machine under the loads of one turn.
struct Setting {
    actual: Machine,
    points: Vec<(Configuration, State)>,
    loads: Vec<Wrench>,
}

impl Setting {
    fn new(positions: impl Iterator<Item = Vector3<f64>>, angles: u32) -> Self {
        let nominal = Machine::named_or_file("orthoglide").expect("built in");
        let actual = nominal.with_errors(&nominal.assembly_errors(&[1.0, -1.0, 1.0]));
        Self::of(&nominal, actual, positions, angles)
    }

    fn of(nominal: &Machine, actual: Machine, positions: impl Iterator<Item = Vector3<f64>>, angles: u32) -> Self {
        let points = positions.map(|position| {
            let at = nominal.inverse_kinematics(&nominal.pose_at(position)).expect("reachable");
            let state = State::rigid(nominal, &at);
            (at, state)
        });
        let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(angles);
        let loads = (0..angles).map(|i| MillingForce::KLIMCHIK_GROOVE.wrench(angle(i), &nominal.tool())).collect();
        Self { points: points.collect(), actual, loads }
    }

    fn equilibria(&self) -> f64 {
        (self.points.len() * self.loads.len()) as f64
    }

    /// A turn at each point, each tool angle from the one before; Newton iterations made.
    fn turn_alone(&self, states: &mut [State], scratch: &mut Scratch) -> usize {
        let mut iterations = 0;
        for ((at, _), state) in self.points.iter().zip(states) {
            for load in &self.loads {
                let outcome = equilibrium(&self.actual, &at.drives, load, state, scratch, &Settings::default());
                assert_eq!(outcome.status, Status::Solved);
                iterations += outcome.iterations;
            }
        }
        iterations
    }

    /// The same, as many points at a time as a batch holds.
    fn turn_together(&self, states: &mut [State], batch: &mut Batch) -> usize {
        let mut iterations = 0;
        for (points, states) in self.points.chunks(Batch::WIDTH).zip(states.chunks_mut(Batch::WIDTH)) {
            let mut drives: Vec<Vec<f64>> = points.iter().map(|(at, _)| at.drives.clone()).collect();
            for load in &self.loads {
                let cases = drives.iter_mut().zip(&mut *states);
                let mut cases: Vec<Case<'_>> =
                    cases.map(|(drives, state)| Case { drives, load: *load, state, task: None }).collect();
                for outcome in batch.equilibria(&mut cases, &Settings::default()) {
                    assert_eq!(outcome.status, Status::Solved);
                    iterations += outcome.iterations;
                }
            }
        }
        iterations
    }

    fn states(&self) -> Vec<State> {
        self.points.iter().map(|(_, state)| state.clone()).collect()
    }
}

/// Eight points around a named one.
fn around(name: &str) -> Setting {
    let machine = Machine::named_or_file("orthoglide").expect("built in");
    let centre = machine.point(name).expect("named point").position;
    Setting::new((0..8).map(|i| centre - Vector3::new(1.0, 2.0, 3.0) * f64::from(i)), 36)
}

/// Points spread over the workspace evenly.
fn spread(count: u32) -> impl Iterator<Item = Vector3<f64>> {
    let machine = Machine::named_or_file("orthoglide").expect("built in");
    let share = |i: u32, step: f64| (0.5 + f64::from(i) * step).fract();
    (0..count).map(move |i| {
        let at = Vector3::new(share(i, 0.819_172_5), share(i, 0.671_043_6), share(i, 0.549_700_5));
        machine.workspace.min + (machine.workspace.max - machine.workspace.min).component_mul(&at)
    })
}

fn seconds(work: impl FnOnce()) -> f64 {
    let started = Instant::now();
    work();
    started.elapsed().as_secs_f64()
}

fn main() {
    // Cargo passes harness options, and `cargo test --benches` only asks that the bench runs.
    let is_test = std::env::args().any(|argument| argument == "--test");
    let mut criterion = Criterion::default().configure_from_args();
    for name in ["Q0", "Q1"] {
        let setting = around(name);
        let mut scratch = Scratch::new(&setting.actual);
        let (at, rigid) = &setting.points[0];
        let mut state = rigid.clone();
        criterion.bench_function(&format!("equilibrium, cold, {name}"), |bencher| {
            bencher.iter(|| {
                state.clone_from(rigid);
                let (actual, load) = (&setting.actual, &setting.loads[13]);
                black_box(equilibrium(actual, &at.drives, load, &mut state, &mut scratch, &Settings::default()))
            });
        });
    }
    criterion.final_summary();
    for name in ["Q0", "Q1"] {
        compare_levels(name, if is_test { 1 } else { 200 });
    }
    operations_per_second(is_test);
    rigid_links(if is_test { 1 } else { 100 });
    let (count, rounds) = if is_test { (8, 1) } else { (2000, 20) };
    random_poses(count, rounds);
    linear_cost(if is_test { &[16, 32] } else { &[64, 128, 256, 512, 1024, 2048, 4096] }, if is_test { 1 } else { 60 });
    two_threads(if is_test { 1 } else { 400 });
}

/// The scalar path and all levels in turns, so that what else the computer does disturbs all of them; best of all rounds.
fn compare_levels(name: &str, rounds: usize) {
    let setting = around(name);
    let (mut states, mut scratch) = (setting.states(), Scratch::new(&setting.actual));
    let mut batches: Vec<(Level, Batch, Vec<State>)> = Level::available()
        .into_iter()
        .map(|level| (level, Batch::at_level(&setting.actual, level), setting.states()))
        .collect();
    let mut best = vec![f64::INFINITY; 1 + batches.len()];
    let mut iterations = 0;
    for _ in 0..rounds {
        best[0] = best[0].min(seconds(|| iterations = setting.turn_alone(&mut states, &mut scratch)));
        for ((_, batch, states), best) in batches.iter_mut().zip(&mut best[1..]) {
            *best = best.min(seconds(|| assert_eq!(setting.turn_together(states, batch), iterations)));
        }
    }
    println!(
        "{name}, 8 points x 36 tool angles, warm, one core, {:.2} Newton iterations each:",
        iterations as f64 / setting.equilibria()
    );
    let labels = ["scalar path".to_string()].into_iter();
    let labels = labels.chain(batches.iter().map(|(level, ..)| format!("batch, {level:?}")));
    for (label, time) in labels.zip(&best) {
        let rate = setting.equilibria() / time;
        println!(
            "  {label:<12} {rate:>8.0} loaded equilibria per second, {:>5.2} times the scalar path, {:.2} times the goal",
            best[0] / time,
            rate / GOAL_PER_SECOND
        );
    }
}

/// Machines whose chains are elastic in their drives only, at eight points in the middle of their workspaces, beside the
/// Orthoglide; all in turns, best of all rounds.
fn rigid_links(rounds: usize) {
    let foreign = |name: &str| {
        let file = format!("{}/tests/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let machine = Machine::from_file(file.as_ref()).expect("a machine file");
        let centre = (machine.workspace.min + machine.workspace.max) * 0.5;
        let positions = (0..8).map(|i| centre + Vector3::new(1.0, 2.0, 3.0) * f64::from(i));
        (name.to_string(), Setting::of(&machine, machine.clone(), positions, 36))
    };
    let mut settings = vec![("orthoglide, Q1".to_string(), around("Q1"))];
    settings.extend(["hexapod", "tricept", "linear_delta", "kr270"].map(foreign));
    let mut workers: Vec<_> = settings
        .iter()
        .map(|(_, s)| (s.states(), Scratch::new(&s.actual), s.states(), Batch::new(&s.actual)))
        .collect();
    let mut best = vec![[f64::INFINITY; 2]; settings.len()];
    for _ in 0..rounds {
        for (((_, setting), (alone, scratch, together, batch)), best) in
            settings.iter().zip(&mut workers).zip(&mut best)
        {
            best[0] = best[0].min(seconds(|| {
                setting.turn_alone(alone, scratch);
            }));
            best[1] = best[1].min(seconds(|| {
                setting.turn_together(together, batch);
            }));
        }
    }
    println!(
        "rigid links, 8 points x 36 tool angles, warm, one core; loaded equilibria per second (and time over the Orthoglide's):"
    );
    for ((name, setting), times) in settings.iter().zip(&best) {
        let rate =
            |way: usize| format!("{:>8.0} ({:.2})", setting.equilibria() / times[way], times[way] / best[0][way]);
        println!("  {name:<14} scalar path {}, batch {}", rate(0), rate(1));
    }
}

/// Machines of all kinds with what their rates are held against, equilibria per second on one core.
const KINDS: [(&str, f64); 6] = [
    ("orthoglide", f64::NAN),
    ("robot_6r", 500_000.0),
    ("hexapod", 150_000.0),
    ("linear_delta", 100_000.0),
    ("hybrid_3ups", f64::NAN),
    ("fourbar_robot", f64::NAN),
];

/// Equilibria from the rigid configuration at random poses under random forces, residual 1e-10; all machines in turns, best
/// of all rounds.
fn random_poses(count: usize, rounds: usize) {
    let mut machines: Vec<_> = KINDS
        .iter()
        .map(|&(name, goal)| {
            let file = format!("{}/tests/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
            let machine = match Machine::named(name) {
                Ok(machine) if name == "orthoglide" => machine,
                _ => Machine::from_file(file.as_ref()).expect("a machine file"),
            };
            let mut share = random_shares();
            let mut problems = Vec::new();
            while problems.len() < count {
                let size = machine.workspace.max - machine.workspace.min;
                let at = Vector3::from_fn(|_, _| share());
                let force = Vector3::from_fn(|_, _| 1000.0 * (share() - 0.5));
                let Ok(at) = machine.inverse_kinematics_at(machine.workspace.min + size.component_mul(&at)) else {
                    continue;
                };
                let moment = (at.pose.rotation * machine.tool_tip).cross(&force);
                let start = State::rigid(&machine, &at);
                problems.push((at, Wrench { force, moment }, start));
            }
            let batch = Batch::new(&machine);
            (name, goal, problems, batch, f64::INFINITY, 0)
        })
        .collect();
    for _ in 0..rounds {
        for (_, _, problems, batch, best, iterations) in &mut machines {
            let mut states: Vec<State> = problems.iter().map(|(_, _, start)| start.clone()).collect();
            let mut drives: Vec<Vec<f64>> = problems.iter().map(|(at, ..)| at.drives.clone()).collect();
            *iterations = 0;
            let mut took = 0.0;
            for first in (0..problems.len()).step_by(Batch::WIDTH) {
                let part = first..problems.len().min(first + Batch::WIDTH);
                let cases = drives[part.clone()].iter_mut().zip(&mut states[part.clone()]).zip(&problems[part]);
                let mut cases: Vec<Case<'_>> = cases
                    .map(|((drives, state), (_, load, _))| Case { drives, load: *load, state, task: None })
                    .collect();
                took += seconds(|| {
                    for outcome in batch.equilibria(&mut cases, &Settings::default()) {
                        assert_eq!(outcome.status, Status::Solved);
                        *iterations += outcome.iterations;
                    }
                });
            }
            *best = best.min(took);
        }
    }
    println!("{count} random poses, random forces, cold, residual 1e-10, one core; loaded equilibria per second:");
    for (name, goal, problems, _, best, iterations) in &machines {
        let rate = problems.len() as f64 / best;
        let steps = *iterations as f64 / problems.len() as f64;
        let held = if goal.is_nan() { String::new() } else { format!(", {:.2} times the goal", rate / goal) };
        println!("  {name:<14} {rate:>8.0}, {steps:.2} Newton iterations each{held}");
    }
}

/// Numbers in 0..1, the same at every call.
fn random_shares() -> impl FnMut() -> f64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Floating-point operations per second of the warm equilibria at Q1, at each level.
fn operations_per_second(is_test: bool) {
    let setting = around("Q1");
    for level in Level::available() {
        let (mut states, mut batch) = (setting.states(), Batch::at_level(&setting.actual, level));
        let mut solving = f64::INFINITY;
        for _ in 0..if is_test { 1 } else { 200 } {
            solving = solving.min(seconds(|| {
                setting.turn_together(&mut states, &mut batch);
            }));
        }
        println!("{level:?}: {:.1} billion operations per second", 1e-9 * OPERATIONS * setting.equilibria() / solving);
    }
}

/// Time over number of points with the straight line that fits it best.
fn linear_cost(counts: &[u32], rounds: usize) {
    let settings: Vec<Setting> = counts.iter().map(|&count| Setting::new(spread(count), 4)).collect();
    let mut measured: Vec<(f64, f64)> = settings.iter().map(|s| (s.equilibria(), f64::INFINITY)).collect();
    for _ in 0..rounds {
        for (setting, (_, best)) in settings.iter().zip(&mut measured) {
            let (mut states, mut batch) = (setting.states(), Batch::new(&setting.actual));
            *best = best.min(seconds(|| {
                black_box(setting.turn_together(&mut states, &mut batch));
            }));
        }
    }
    // Weighted by 1/time²: what counts is the relative deviation.
    let sum = |term: &dyn Fn(f64, f64) -> f64| measured.iter().map(|&(n, t)| term(n, t) / (t * t)).sum::<f64>();
    let (w, n, t) = (sum(&|_, _| 1.0), sum(&|n, _| n), sum(&|_, t| t));
    let (nn, nt) = (sum(&|n, _| n * n), sum(&|n, t| n * t));
    let slope = (w * nt - n * t) / (w * nn - n * n);
    let offset = (t - slope * n) / w;
    println!("cost over the number of equilibria (4 tool angles at points all over the workspace, first one cold):");
    for (count, time) in &measured {
        let fit = offset + slope * count;
        println!("  {count:>6} in {:>8.2} ms, {:+.1} % from the line", 1e3 * time, 100.0 * (time / fit - 1.0));
    }
    println!("  line: {:.3} µs per equilibrium + {:.3} ms", 1e6 * slope, 1e3 * offset);
}

/// The same work on one thread, and twice on two, which begin together.
fn two_threads(rounds: usize) {
    let setting = Setting::new(spread(32), 36);
    let work = |states: &mut Vec<State>, batch: &mut Batch| {
        black_box(setting.turn_together(states, batch));
    };
    let (mut one, mut two) = (f64::INFINITY, f64::INFINITY);
    let (begin, end) = (Barrier::new(2), Barrier::new(2));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let (mut states, mut batch) = (setting.states(), Batch::new(&setting.actual));
            for _ in 0..rounds {
                begin.wait();
                work(&mut states, &mut batch);
                end.wait();
            }
        });
        let (mut states, mut batch) = (setting.states(), Batch::new(&setting.actual));
        for _ in 0..rounds {
            one = one.min(seconds(|| work(&mut states, &mut batch)));
            begin.wait();
            two = two.min(seconds(|| {
                work(&mut states, &mut batch);
                end.wait();
            }));
        }
    });
    println!("two threads do {:.2} times the work of one (goal {GOAL_TWO_THREADS})", 2.0 * one / two);
}
