//! Equilibria of many independent cases, as many at a time as the processor's vector registers hold.

use std::sync::atomic::{AtomicU64, Ordering};

use super::{
    equilibrium::equilibrium,
    lane_solver::{CommandedPoses, LaneSolver},
    outcome::{Outcome, Settings, TaskError},
    state::{Scratch, State},
};
#[cfg(target_arch = "x86_64")]
use crate::lanes::{F64x4, F64x8};
use crate::{
    lanes::{Level, MAX_LANES, Real},
    machine::{Configuration, Machine},
    spatial::{Pose, Wrench},
};

/// One equilibrium of a batch.
pub struct Case<'a> {
    /// Drive positions, mm or rad; with a task, the positions that meet it replace them.
    pub drives: &'a mut [f64],
    /// Dead wrench at P in O axes, N and N·mm.
    pub load: Wrench,
    /// Where the search starts; receives the equilibrium.
    pub state: &'a mut State,
    /// Task error that the drives are to bring to zero, see [`super::equilibrium_at_task`]; `None`: the drives stay.
    pub task: Option<&'a dyn Fn(&Pose) -> TaskError>,
}

/// Solves equilibria of one machine, [`Batch::WIDTH`] independent cases side by side.
/// Outcomes do not depend on earlier solves. A case that starts where that of the same index last ended saves a linearisation.
#[derive(Debug, Clone)]
pub struct Batch {
    machine: Machine,
    solvers: Solvers,
    scalar: Scratch,
}

/// Cases that this process has given to batches.
static GIVEN: AtomicU64 = AtomicU64::new(0);

/// Number of equilibria that this process has sought in batches, for benches.
pub fn sought_in_batches() -> u64 {
    GIVEN.load(Ordering::Relaxed)
}

/// Lane solvers with the registers in use: one, four or eight cases each.
#[derive(Debug, Clone)]
enum Solvers {
    One(Vec<LaneSolver<f64>>),
    #[cfg(target_arch = "x86_64")]
    Four(Vec<LaneSolver<F64x4>>),
    #[cfg(target_arch = "x86_64")]
    Eight(Vec<LaneSolver<F64x8>>),
}

impl Batch {
    /// Number of cases solved side by side, and worth giving at once.
    pub const WIDTH: usize = MAX_LANES;

    /// A solver of batches for `machine`, with the widest registers of this processor.
    pub fn new(machine: &Machine) -> Self {
        Self::at_level(machine, Level::best())
    }

    /// A solver of batches for `machine` at `level`, or at [`Level::One`] where this processor does not have it.
    pub fn at_level(machine: &Machine, level: Level) -> Self {
        let solvers = match level {
            #[cfg(target_arch = "x86_64")]
            Level::Eight if level.is_available() => Solvers::Eight(lane_solvers(machine)),
            #[cfg(target_arch = "x86_64")]
            Level::Four if level.is_available() => Solvers::Four(lane_solvers(machine)),
            _ => Solvers::One(lane_solvers(machine)),
        };
        Self { machine: machine.clone(), solvers, scalar: Scratch::new(machine) }
    }

    /// Solves [`super::equilibrium()`] for each case, with the same outcomes to the last bit; clears the cases' tasks.
    pub fn equilibria(&mut self, cases: &mut [Case<'_>], settings: &Settings) -> Vec<Outcome> {
        for case in cases.iter_mut() {
            case.task = None;
        }
        let outcomes = self.solve(cases, None, settings);
        let complete = cases.iter_mut().zip(outcomes).map(|(case, outcome)| {
            outcome.unwrap_or_else(|| {
                equilibrium(&self.machine, case.drives, &case.load, case.state, &mut self.scalar, settings)
            })
        });
        complete.collect()
    }

    /// Solves [`super::equilibrium_at_task`] for each case, with the same outcomes to the last bit. `None` for cases that full steps in
    /// lanes cannot solve, which are left as they were, and for all cases if one has no task.
    pub fn equilibria_at_task(&mut self, cases: &mut [Case<'_>], settings: &Settings) -> Vec<Option<Outcome>> {
        match cases.iter().all(|case| case.task.is_some()) {
            true => self.solve(cases, None, settings),
            false => vec![None; cases.len()],
        }
    }

    /// Solves equilibria at the position of a point, as [`Batch::equilibria_at_task`] with fewer task coordinates than drives: the drives are
    /// those of rigid configurations of `nominal`, always the same machine, sought from `starts`. They have the rotations of `poses`, which
    /// get the positions found; those of `None` mean nothing. All cases must have a task.
    pub(crate) fn equilibria_at_position(
        &mut self,
        nominal: &Machine,
        cases: &mut [Case<'_>],
        starts: &[&Configuration],
        poses: &mut [Pose],
        settings: &Settings,
    ) -> Vec<Option<Outcome>> {
        self.solve(cases, Some(CommandedPoses { nominal, starts, poses }), settings)
    }

    /// Solves the cases in lanes; `None` for those that full Newton steps in lanes cannot solve.
    fn solve(
        &mut self,
        cases: &mut [Case<'_>],
        commands: Option<CommandedPoses<'_>>,
        settings: &Settings,
    ) -> Vec<Option<Outcome>> {
        GIVEN.fetch_add(cases.len() as u64, Ordering::Relaxed);
        match &mut self.solvers {
            Solvers::One(solvers) => solve_in_rows(solvers, &self.machine, cases, commands, settings),
            #[cfg(target_arch = "x86_64")]
            Solvers::Four(solvers) => solve_in_rows(solvers, &self.machine, cases, commands, settings),
            #[cfg(target_arch = "x86_64")]
            Solvers::Eight(solvers) => solve_in_rows(solvers, &self.machine, cases, commands, settings),
        }
    }
}

/// Lane solvers for one row of [`MAX_LANES`] cases.
fn lane_solvers<R: Real>(machine: &Machine) -> Vec<LaneSolver<R>> {
    vec![LaneSolver::new(machine); MAX_LANES / R::LANES]
}

/// Solves rows of [`Batch::WIDTH`] cases, each row shared out among `solvers`; `None` for cases that lanes cannot solve.
fn solve_in_rows<R: Real>(
    solvers: &mut [LaneSolver<R>],
    machine: &Machine,
    cases: &mut [Case<'_>],
    mut commands: Option<CommandedPoses<'_>>,
    settings: &Settings,
) -> Vec<Option<Outcome>> {
    let mut outcomes = Vec::with_capacity(cases.len());
    let mut first = 0;
    for row in cases.chunks_mut(MAX_LANES) {
        for (cases, solver) in row.chunks_mut(R::LANES).zip(&mut *solvers) {
            let own = first..first + cases.len();
            first = own.end;
            solver.solve_commanded(machine, cases, commands.as_mut().map(|all| all.part(own)), settings, &mut outcomes);
        }
    }
    outcomes
}
