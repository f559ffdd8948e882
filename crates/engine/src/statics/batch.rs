//! Equilibria of many independent cases, as many at a time as the processor's vector registers hold.

use super::{
    equilibrium::equilibrium,
    lane_solver::{Commands, LaneSolver},
    outcome::{Outcome, Settings, TaskError},
    state::{State, Workspace},
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
    /// Where the drives are, mm or rad; where a task is given, they move to meet it.
    pub drives: &'a mut [f64],
    /// Dead wrench at P in O axes.
    pub load: Wrench,
    /// Where the search starts, and where it ends.
    pub state: &'a mut State,
    /// What the drives are to achieve, see [`super::equilibrium_at_task`].
    pub task: Option<&'a dyn Fn(&Pose) -> TaskError>,
}

/// Solves equilibria of one machine, [`Batch::WIDTH`] independent cases side by side.
///
/// Outcomes do not depend on what was solved before. It remembers where each case of the last batch ended: a case that
/// starts there, in the same place, saves the first linearisation of the machine.
#[derive(Debug, Clone)]
pub struct Batch {
    machine: Machine,
    solvers: Solvers,
    scalar: Workspace,
}

#[derive(Debug, Clone)]
enum Solvers {
    One(Vec<LaneSolver<f64>>),
    #[cfg(target_arch = "x86_64")]
    Four(Vec<LaneSolver<F64x4>>),
    #[cfg(target_arch = "x86_64")]
    Eight(Vec<LaneSolver<F64x8>>),
}

impl Batch {
    /// Cases that are worth giving at once.
    pub const WIDTH: usize = MAX_LANES;

    /// For `machine`, with the widest registers of this processor.
    pub fn new(machine: &Machine) -> Self {
        Self::at_level(machine, Level::best())
    }

    /// For `machine` at `level`, or at [`Level::One`] where this processor does not have it.
    pub fn at_level(machine: &Machine, level: Level) -> Self {
        let solvers = match level {
            #[cfg(target_arch = "x86_64")]
            Level::Eight if level.is_available() => Solvers::Eight(side_by_side(machine)),
            #[cfg(target_arch = "x86_64")]
            Level::Four if level.is_available() => Solvers::Four(side_by_side(machine)),
            _ => Solvers::One(side_by_side(machine)),
        };
        Self { machine: machine.clone(), solvers, scalar: Workspace::new(machine) }
    }

    /// [`super::equilibrium()`] of each case, with the same outcomes to the last bit. Tasks are not looked at.
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

    /// [`super::equilibrium_at_task`] of each case, with the same outcomes to the last bit as far as lanes get.
    ///
    /// `None`: the case is as it was, and is left to [`super::equilibrium_at_task`]. All cases must have a task.
    pub fn equilibria_at_task(&mut self, cases: &mut [Case<'_>], settings: &Settings) -> Vec<Option<Outcome>> {
        match cases.iter().all(|case| case.task.is_some()) {
            true => self.solve(cases, None, settings),
            false => vec![None; cases.len()],
        }
    }

    /// As [`Batch::equilibria_at_task`] where the tasks are fewer than the drives, the position of a point: the drives are those of
    /// rigid configurations of `nominal`, whose rotations are those of `poses`, and whose positions are found and left there. `starts`:
    /// the configuration from which each is sought.
    pub(crate) fn equilibria_at_position(
        &mut self,
        nominal: &Machine,
        cases: &mut [Case<'_>],
        starts: &[&Configuration],
        poses: &mut [Pose],
        settings: &Settings,
    ) -> Vec<Option<Outcome>> {
        self.solve(cases, Some(Commands { nominal, starts, poses }), settings)
    }

    /// Solves what lanes can solve.
    fn solve(
        &mut self,
        cases: &mut [Case<'_>],
        commands: Option<Commands<'_>>,
        settings: &Settings,
    ) -> Vec<Option<Outcome>> {
        match &mut self.solvers {
            Solvers::One(solvers) => in_rows(solvers, &self.machine, cases, commands, settings),
            #[cfg(target_arch = "x86_64")]
            Solvers::Four(solvers) => in_rows(solvers, &self.machine, cases, commands, settings),
            #[cfg(target_arch = "x86_64")]
            Solvers::Eight(solvers) => in_rows(solvers, &self.machine, cases, commands, settings),
        }
    }
}

fn side_by_side<R: Real>(machine: &Machine) -> Vec<LaneSolver<R>> {
    vec![LaneSolver::new(machine); MAX_LANES / R::LANES]
}

/// Rows of [`Batch::WIDTH`] cases, each shared out among `solvers`.
fn in_rows<R: Real>(
    solvers: &mut [LaneSolver<R>],
    machine: &Machine,
    cases: &mut [Case<'_>],
    mut commands: Option<Commands<'_>>,
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
