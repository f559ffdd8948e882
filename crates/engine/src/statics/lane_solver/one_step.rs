//! One Newton step of the whole machine as a function of numbers: what controllers compute.
//!
//! A state as a row of numbers has the positions of the drives, the axes of the platform (its rotation column by column) and
//! its origin, and of each chain its coordinates, its wrench and those of its loops, each force (N) before moment (N·mm).

use super::{Iteration, LaneSolver, MAX_LANES, Progress};
use crate::{
    lanes::{Computation, Frame, Real, Screw, Vec3, pairs, record},
    machine::Machine,
    spatial::{Pose, Wrench},
    statics::{ChainState, State, platform::SquareTask},
};

/// Input of a step besides the state and the wrench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepInput {
    /// Position of the tool tip, mm in O: the step finds the drives.
    Tip,
    /// Nothing: the drives stay as the state has them, and the step finds the platform.
    Drives,
}

impl StepInput {
    /// Number of inputs besides the state: three of a position (mm), if there is one, and six of the wrench (N, N·mm).
    pub fn count(self) -> usize {
        match self {
            StepInput::Tip => 3 + 6,
            StepInput::Drives => 6,
        }
    }
}

/// Index of the platform's origin (mm) in the numbers of a state, for a machine with `drives` drives.
pub fn origin_index(drives: usize) -> usize {
    drives + 9
}

/// Drive positions (mm, rad) and a state as a row of numbers.
pub fn state_numbers(drives: &[f64], state: &State) -> Vec<f64> {
    let pose = state.platform();
    let mut numbers = drives.to_vec();
    numbers.extend(pose.rotation.iter().chain(pose.translation.iter()));
    for chain in &state.chains {
        numbers.extend(&chain.coordinates);
        for wrench in std::iter::once(&chain.wrench).chain(&chain.loops) {
            numbers.extend(wrench.force.iter().chain(wrench.moment.iter()));
        }
    }
    numbers
}

/// Drive positions (mm, rad) and state from a row of numbers, the inverse of [`state_numbers`].
pub fn state_from_numbers(machine: &Machine, numbers: &[f64]) -> (Vec<f64>, State) {
    let mut rest = numbers.iter().copied();
    let mut take = |count: usize| rest.by_ref().take(count).collect::<Vec<f64>>();
    let drives = take(machine.drive_count());
    let rotation = nalgebra::Matrix3::from_iterator(take(9));
    let pose = Pose { rotation, translation: nalgebra::Vector3::from_iterator(take(3)) };
    let wrench_of = |numbers: Vec<f64>| {
        let mut wrench = [0.0; 6];
        for (entry, number) in wrench.iter_mut().zip(numbers) {
            *entry = number;
        }
        Wrench::new(wrench)
    };
    let chains = machine.chains.iter().map(|chain| ChainState {
        coordinates: take(chain.coordinate_count()),
        wrench: wrench_of(take(6)),
        loops: (0..chain.route.loop_count()).map(|_| wrench_of(take(6))).collect(),
    });
    let chains = chains.collect();
    (drives, State { pose, chains, body: None })
}

/// Records a Newton step of `machine`, whose drives control its three translations, as operations from the numbers of a state and the
/// inputs of kind `input` to the numbers of the next state. The wrench is a dead one about the tool tip, the platform oriented as at home.
/// `postures` are rows of inputs that decide which branches are recorded; `None` where the step cannot be written as one list of operations.
pub fn step_program(machine: &Machine, input: StepInput, postures: &[Vec<f64>]) -> Option<Computation> {
    record(postures, |inputs| step(machine, input, inputs))
}

/// Computes the Newton step that [`step_program`] records; `None` where it takes more than a full step over condensed chains.
pub fn step<R: Real>(machine: &Machine, input: StepInput, inputs: &[R]) -> Option<Vec<R>> {
    let (state, extra) = inputs.split_at(inputs.len() - input.count());
    let (position, wrench) = extra.split_at(extra.len() - 6);
    let mut solver: LaneSolver<R> = LaneSolver::new(machine);
    let gravity = Vec3::splat(&machine.gravity);
    solver.set_numbers(state);
    solver.linearise(machine, gravity);
    let task = (input == StepInput::Tip).then(|| solver.tip_error(machine, position));
    let imbalance = solver.imbalance(machine, gravity, wrench_at_platform(machine, wrench));
    let mut progress = Progress {
        iterations: [Iteration::new(); MAX_LANES],
        residuals: [0.0; MAX_LANES],
        active: R::ALL & solver.condensed,
        solved: 0,
    };
    solver.step_lanes(machine, imbalance, task.as_ref(), &mut progress);
    (progress.active == R::ALL).then(|| solver.to_numbers())
}

/// Wrench at P of `wrench` about the tool tip, the platform oriented as at home (N, N·mm).
fn wrench_at_platform<R: Real>(machine: &Machine, wrench: &[R]) -> [R; 6] {
    let mut numbers = [R::zero(); 6];
    numbers.copy_from_slice(wrench);
    let mut at_platform = Screw::from_array(numbers);
    let lever = Vec3::splat(&(machine.home.pose.rotation * machine.tool_tip));
    at_platform.angular += lever.cross(at_platform.linear);
    at_platform.to_array()
}

impl<R: Real> LaneSolver<R> {
    /// Sets drives, platform and chains from numbers in the order of [`state_numbers`].
    fn set_numbers(&mut self, numbers: &[R]) {
        let mut rest = numbers.iter().copied();
        let mut put = |number: &mut R| {
            if let Some(value) = rest.next() {
                *number = value;
            }
        };
        self.drives.iter_mut().for_each(&mut put);
        self.platform.axes.iter_mut().for_each(|axis| axis.0.iter_mut().for_each(&mut put));
        self.platform.origin.0.iter_mut().for_each(&mut put);
        for chain in &mut self.chains {
            chain.coordinates.iter_mut().for_each(&mut put);
            for wrench in std::iter::once(&mut chain.wrench).chain(&mut chain.loops) {
                wrench.linear.0.iter_mut().for_each(&mut put);
                wrench.angular.0.iter_mut().for_each(&mut put);
            }
        }
    }

    /// Drives, platform and chains as numbers in the order of [`state_numbers`]; the inverse of `set_numbers`.
    fn to_numbers(&self) -> Vec<R> {
        let mut numbers = self.drives.clone();
        numbers.extend(self.platform.axes.iter().flat_map(|axis| axis.0));
        numbers.extend(self.platform.origin.0);
        for chain in &self.chains {
            numbers.extend(&chain.coordinates);
            for wrench in std::iter::once(&chain.wrench).chain(&chain.loops) {
                numbers.extend(wrench.to_array());
            }
        }
        numbers
    }

    /// Position of the tool tip less `target` (mm, O), and its derivative by the twist of P; the drives control all three translations.
    fn tip_error(&self, machine: &Machine, target: &[R]) -> SquareTask<R> {
        let Frame { axes: _, origin } = self.platform;
        let lever = self.platform.outward(Vec3::splat(&machine.tool_tip));
        let tip = origin + lever;
        let (mut error, mut slope) = ([R::zero(); 6], [[R::zero(); 6]; 6]);
        for axis in 0..3 {
            let mut along = Vec3::zero();
            along.0[axis] = R::splat(1.0);
            error[axis] = tip.0[axis] - target[axis];
            slope[axis][axis] = along.0[axis];
            for (entry, part) in pairs(&mut slope[axis][3..], lever.cross(along).0) {
                *entry = part;
            }
        }
        SquareTask { count: 3, error, slope, command: None }
    }
}
