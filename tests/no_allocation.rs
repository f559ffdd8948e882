//! A Newton iteration allocates nothing: warm solves that need more iterations allocate as often, and as much, as those
//! that need fewer.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use kinetostat::{
    machine::{ChainError, Configuration, Machine},
    process::MillingForce,
    statics::{Batch, Case, Level, Scratch, Settings, State, Status, equilibrium},
};

thread_local! {
    /// Allocations and bytes of this thread.
    static ALLOCATED: Cell<(usize, usize)> = const { Cell::new((0, 0)) };
}

/// The system's allocator, counted per thread.
struct Counting;

fn count(bytes: usize) {
    // A thread that is being torn down has no counter any more.
    let _ = ALLOCATED.try_with(|cell| {
        let (times, total) = cell.get();
        cell.set((times + 1, total + bytes));
    });
}

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size);
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Iterations and allocations (times, bytes) of one solve.
#[derive(Debug, Clone, Copy)]
struct Cost {
    iterations: usize,
    allocated: (usize, usize),
}

/// Solves from `start` under the milling wrench at `phi_deg`.
fn solve(machine: &Machine, at: &Configuration, start: &State, phi_deg: f64, scratch: &mut Scratch) -> Cost {
    let load = MillingForce::KLIMCHIK_GROOVE.wrench(phi_deg.to_radians(), &machine.tool());
    let mut state = start.clone();
    let before = ALLOCATED.get();
    let outcome = equilibrium(machine, &at.drives, &load, &mut state, scratch, &Settings::default());
    let after = ALLOCATED.get();
    assert_eq!((outcome.status, outcome.load_steps), (Status::Solved, 1));
    Cost { iterations: outcome.iterations, allocated: (after.0 - before.0, after.1 - before.1) }
}

#[test]
fn more_newton_iterations_do_not_allocate_more() {
    let nominal = Machine::named_or_file("orthoglide").unwrap();
    let turns = nominal.chains.iter().zip([1.0f64, -1.0, 1.0]);
    let errors: Vec<_> =
        turns.map(|(chain, degrees)| ChainError::turn_about_drive_axis(chain, degrees.to_radians())).collect();
    let actual = nominal.with_errors(&errors);
    let at = nominal.inverse_kinematics(&nominal.pose_at(nominal.point("Q1").unwrap().position)).unwrap();
    let rigid = State::rigid(&nominal, &at);
    let mut scratch = Scratch::new(&actual);
    let first = solve(&actual, &at, &rigid, 0.0, &mut scratch);
    assert!(first.allocated.0 > 0, "the allocator does not count");

    let load = MillingForce::KLIMCHIK_GROOVE.wrench(0.0, &nominal.tool());
    let mut loaded = rigid.clone();
    equilibrium(&actual, &at.drives, &load, &mut loaded, &mut scratch, &Settings::default());
    let costs: Vec<Cost> = [(&loaded, 0.0), (&loaded, 0.01), (&loaded, 20.0), (&rigid, 180.0)]
        .into_iter()
        .map(|(start, phi_deg)| solve(&actual, &at, start, phi_deg, &mut scratch))
        .collect();

    let iterations: Vec<usize> = costs.iter().map(|cost| cost.iterations).collect();
    let (least, most) = (iterations.iter().min().unwrap(), iterations.iter().max().unwrap());
    assert!(most - least >= 2, "the solves must differ in their iterations to verify anything: {iterations:?}");
    for cost in &costs {
        assert_eq!(cost.allocated, costs[0].allocated, "{costs:?}");
    }
}

/// The same where rigid links leave the platform more unknowns than its twist, and with weight, springs between points and
/// loops.
#[test]
fn more_newton_iterations_do_not_allocate_more_with_rigid_links() {
    for name in
        ["hexapod", "tricept", "linear_delta", "robot_6r", "hybrid_3ups", "fourbar_robot", "coupled_6r", "nested"]
    {
        let machine = Machine::from_file(format!("{}/tests/machines/{name}.toml", env!("CARGO_MANIFEST_DIR")).as_ref());
        let machine = machine.unwrap_or_else(|e| panic!("{e}"));
        let at = &machine.home;
        let rigid = State::rigid(&machine, at);
        let mut scratch = Scratch::new(&machine);
        let load = MillingForce::KLIMCHIK_GROOVE.wrench(0.0, &machine.tool());
        let mut loaded = rigid.clone();
        equilibrium(&machine, &at.drives, &load, &mut loaded, &mut scratch, &Settings::default());
        let costs = [(&loaded, 0.0), (&loaded, 20.0), (&rigid, 180.0)]
            .map(|(start, phi_deg)| solve(&machine, at, start, phi_deg, &mut scratch));
        assert!(costs[2].iterations - costs[0].iterations >= 2, "{name}: {costs:?}");
        for cost in &costs {
            assert_eq!(cost.allocated, costs[0].allocated, "{name}: {costs:?}");
        }
    }
}

/// Cases from states near and far, side by side: what is allocated is what is handed back.
#[test]
fn more_newton_iterations_do_not_allocate_more_in_lanes() {
    for name in ["hexapod", "robot_6r", "hybrid_3ups", "fourbar_robot", "coupled_6r", "nested"] {
        let machine = Machine::from_file(format!("{}/tests/machines/{name}.toml", env!("CARGO_MANIFEST_DIR")).as_ref());
        let machine = machine.unwrap_or_else(|e| panic!("{e}"));
        let at = &machine.home;
        for level in Level::available() {
            let mut batch = Batch::at_level(&machine, level);
            let rigid = vec![State::rigid(&machine, at); Batch::WIDTH];
            let mut solve = |start: &[State], phi_deg: f64| {
                let mut states = start.to_vec();
                let mut drives = vec![at.drives.clone(); Batch::WIDTH];
                let mut cases: Vec<Case<'_>> = states
                    .iter_mut()
                    .zip(&mut drives)
                    .enumerate()
                    .map(|(i, (state, drives))| {
                        let phi = (phi_deg + 5.0 * i as f64).to_radians();
                        Case {
                            drives,
                            load: MillingForce::KLIMCHIK_GROOVE.wrench(phi, &machine.tool()),
                            state,
                            task: None,
                        }
                    })
                    .collect();
                let before = ALLOCATED.get();
                let outcomes = batch.equilibria(&mut cases, &Settings::default());
                let after = ALLOCATED.get();
                assert!(outcomes.iter().all(|outcome| outcome.status == Status::Solved), "{name}: {outcomes:?}");
                let iterations = outcomes.iter().map(|outcome| outcome.iterations).sum();
                (states, Cost { iterations, allocated: (after.0 - before.0, after.1 - before.1) })
            };
            let (loaded, _) = solve(&rigid, 0.0);
            let costs = [(&loaded, 0.0), (&loaded, 20.0), (&rigid, 180.0)].map(|(start, phi)| solve(start, phi).1);
            assert!(costs[2].iterations - costs[0].iterations >= 2, "{name}: {costs:?}");
            for cost in &costs {
                assert_eq!(cost.allocated, costs[0].allocated, "{name}, {level:?}: {costs:?}");
            }
        }
    }
}
