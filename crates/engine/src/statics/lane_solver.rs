//! The linearised machine and its Newton step, for one case or for one per lane; and the iteration of many cases in lanes.
//!
//! [`super::equilibrium()`] takes the same steps with one number at a time, so that a lane has its bits. In lanes, a case that
//! converges early is left as it is; one that needs anything but full steps over condensed chains (load steps, a chain that cannot
//! be condensed, a stability that is not plain) fails, and is left to [`super::equilibrium()`].

pub mod one_step;

use std::ops::Range;

use nalgebra::Matrix6xX;

use super::{
    batch::Case,
    chain_system::{ChainInput, ChainResidual, ChainSystem},
    iteration::{Iteration, IterationStatus},
    outcome::{Outcome, Settings, Status},
    platform::{self, Square, SquareTask},
    rigid_directions::RigidDirections,
    state::State,
    tool, weight,
};
use crate::{
    lanes::{Frame, MAX_LANES, Real, Screw, Vec3, clear, pairs, rotation_exp},
    machine::{Chain, CommandStep, Configuration, Machine},
    spatial::{Pose, Wrench},
};

/// One case per lane, and the linearised machine at their states. States and linearisation are kept from solve to solve, so that a case which
/// starts where the last one in its lane ended does not linearise the machine again.
#[derive(Debug, Clone)]
pub struct LaneSolver<R = f64> {
    pub(super) drives: Vec<R>,
    pub(super) platform: Frame<R>,
    chains: Vec<LaneChain<R>>,
    pub(super) systems: Vec<ChainSystem<R>>,
    pub(super) rigid: RigidDirections<R>,
    residuals: Vec<ChainResidual<R>>,
    /// Load of each lane at P in O axes, N and N·mm, for a tool that bends.
    pub(super) loads: [Wrench; MAX_LANES],
    /// Whether the systems are linearised at the present states.
    is_linearised: bool,
    /// Lanes in which all chains could be condensed.
    pub(super) condensed: u8,
    pub(super) tangent: Square<R>,
    drive_step: Vec<R>,
    /// Step of the command, where it is sought (see [`LaneSolver::solve_commanded`]); else that of the drives.
    command_step: [R; 6],
    command: Option<CommandStep<R>>,
    /// Of each drive: wrench with the platform held, and at the end the twist under constant load.
    pub(super) drive_wrenches: Vec<[R; 6]>,
}

/// Unknowns of one chain, see [`super::ChainState`].
#[derive(Debug, Clone)]
struct LaneChain<R> {
    coordinates: Vec<R>,
    wrench: Screw<R>,
    loops: Vec<Screw<R>>,
    /// Indices of its drives in the machine.
    drives: Range<usize>,
}

/// A nominal machine, and for each case where it stands and what is commanded: a pose whose rotation stays.
pub(super) struct CommandedPoses<'a> {
    pub nominal: &'a Machine,
    pub starts: &'a [&'a Configuration],
    pub poses: &'a mut [Pose],
}

impl CommandedPoses<'_> {
    /// The commands of the cases in the range `cases`.
    pub fn part(&mut self, cases: Range<usize>) -> CommandedPoses<'_> {
        CommandedPoses { nominal: self.nominal, starts: &self.starts[cases.clone()], poses: &mut self.poses[cases] }
    }
}

/// Task errors at the poses of the lanes.
struct Tasks<R> {
    square: SquareTask<R>,
    /// Length of each lane's task error, mm.
    sizes: [f64; MAX_LANES],
    /// Lanes with as many coordinates as may move.
    fitting: u8,
}

/// Progress of the iteration in each lane.
struct Progress {
    iterations: [Iteration; MAX_LANES],
    residuals: [f64; MAX_LANES],
    /// Lanes still iterating, and lanes solved, as bits.
    active: u8,
    solved: u8,
}

impl<R: Real> LaneSolver<R> {
    /// A solver for `machine`, all unknowns zero.
    pub fn new(machine: &Machine) -> Self {
        let mut drive_count = 0;
        let chains = machine.chains.iter().map(|chain| {
            let first = drive_count;
            drive_count += chain.drives.len();
            LaneChain {
                coordinates: vec![R::zero(); chain.coordinate_count()],
                wrench: Screw::zero(),
                loops: vec![Screw::zero(); chain.route.loop_count()],
                drives: first..drive_count,
            }
        });
        let chains: Vec<_> = chains.collect();
        let nothing = ChainResidual { gap: R::zero(), force: R::zero() };
        let systems = ChainSystem::all(machine);
        Self {
            drives: vec![R::zero(); machine.drive_count()],
            platform: Frame { axes: [Vec3::zero(); 3], origin: Vec3::zero() },
            residuals: vec![nothing; chains.len()],
            rigid: RigidDirections::new(&systems),
            systems,
            chains,
            loads: [Wrench::zero(); MAX_LANES],
            is_linearised: false,
            condensed: 0,
            tangent: [[R::zero(); 6]; 6],
            drive_step: vec![R::zero(); machine.drive_count()],
            command_step: [R::zero(); 6],
            command: None,
            drive_wrenches: Vec::with_capacity(machine.drive_count()),
        }
    }

    /// Solves up to [`Real::LANES`] cases and appends their outcomes; `None` for those that need the scalar iteration, which stay as is.
    pub fn solve(
        &mut self,
        machine: &Machine,
        cases: &mut [Case<'_>],
        settings: &Settings,
        outcomes: &mut Vec<Option<Outcome>>,
    ) {
        self.solve_commanded(machine, cases, None, settings, outcomes);
    }

    /// Solves as [`LaneSolver::solve`]. With `commands`, the drives follow the nominal machine, whose P moves, its rotation kept, so that
    /// the tasks are met; the poses in `commands` get the positions found.
    pub(super) fn solve_commanded(
        &mut self,
        machine: &Machine,
        cases: &mut [Case<'_>],
        mut commands: Option<CommandedPoses<'_>>,
        settings: &Settings,
        outcomes: &mut Vec<Option<Outcome>>,
    ) {
        debug_assert!(cases.len() <= R::LANES);
        for (lane, case) in cases.iter().enumerate() {
            let bends_otherwise = machine.tool_compliance.is_some() && self.loads[lane] != case.load;
            self.loads[lane] = case.load;
            self.set_state(lane, case.drives, case.state);
            self.is_linearised &= !bends_otherwise;
        }
        if let Some(commands) = &commands {
            let command = self.command.get_or_insert_with(|| CommandStep::new(commands.nominal));
            for lane in 0..R::LANES {
                // Lanes to spare do what the first one does.
                let from = if lane < cases.len() { lane } else { 0 };
                command.set_lane(lane, commands.starts[from], cases[from].drives, &commands.poses[from]);
            }
        }
        let gravity = Vec3::splat(&machine.gravity);
        let mut progress = Progress {
            iterations: [Iteration::new(); MAX_LANES],
            residuals: [f64::INFINITY; MAX_LANES],
            active: u8::MAX >> (MAX_LANES - cases.len()),
            solved: 0,
        };
        for iteration in 0..=settings.max_iterations {
            if !self.is_linearised {
                self.linearise(machine, gravity);
            }
            let count = match (&commands, &self.command) {
                (Some(_), Some(command)) => command.coordinate_count(),
                _ => self.drives.len(),
            };
            let mut tasks = self.task_errors(machine, cases, progress.active, count);
            if let (Some(commands), Some(tasks)) = (&commands, &mut tasks) {
                self.linearise_command(commands.nominal, tasks);
            }
            let imbalance = self.judge_lanes(machine, cases, tasks.as_ref(), &mut progress, settings);
            if iteration == 0 {
                progress.active &= self.plainly_stable(machine);
            }
            if progress.active == 0 {
                break;
            }
            let task = tasks.as_ref().map(|tasks| &tasks.square);
            self.step_lanes(machine, imbalance, task, &mut progress);
            if let (Some(commands), Some(command)) = (&commands, &mut self.command) {
                let (step, mask) = (&self.command_step, R::mask_from_bits(progress.active));
                R::vectorized(
                    #[inline(always)]
                    || command.advance(commands.nominal, step, mask),
                );
            }
        }
        self.append_outcomes(machine, cases, &progress, outcomes);
        if let (Some(commands), Some(command)) = (&mut commands, &self.command) {
            for (lane, pose) in commands.poses.iter_mut().enumerate() {
                pose.translation = command.commanded_position(lane);
            }
        }
    }

    /// Linearises the nominal machine at its command: `tasks` get how the drives move with it, and sizes not below its closure errors, mm.
    fn linearise_command(&mut self, nominal: &Machine, tasks: &mut Tasks<R>) {
        let Some(command) = &mut self.command else { return };
        let (error, motions, good) = R::vectorized(
            #[inline(always)]
            || command.linearise(nominal),
        );
        tasks.fitting &= good;
        tasks.square.command = Some(motions);
        for (lane, size) in tasks.sizes.iter_mut().enumerate().take(R::LANES) {
            *size = size.larger(error.lane(lane));
        }
    }

    /// Copies drive positions (mm, rad) and a state into `lane`; the linearisation is kept if they are there already.
    pub(super) fn set_state(&mut self, lane: usize, drives: &[f64], state: &State) {
        // Without a task the drives stay.
        clear(&mut self.drive_step);
        let mut is_new = false;
        let mut put = |number: &mut R, value: f64| {
            is_new |= number.lane(lane) != value;
            number.set_lane(lane, value);
        };
        for (number, &value) in pairs(&mut self.drives, drives) {
            put(number, value);
        }
        let pose = state.platform();
        for (j, axis) in self.platform.axes.iter_mut().enumerate() {
            for (i, number) in axis.0.iter_mut().enumerate() {
                put(number, pose.rotation[(i, j)]);
            }
        }
        for (i, number) in self.platform.origin.0.iter_mut().enumerate() {
            put(number, pose.translation[i]);
        }
        for (chain, from) in pairs(&mut self.chains, &state.chains) {
            for (number, &value) in pairs(&mut chain.coordinates, &from.coordinates) {
                put(number, value);
            }
            let wrenches = std::iter::once(&mut chain.wrench).chain(&mut chain.loops);
            for (own, from) in wrenches.zip(std::iter::once(&from.wrench).chain(&from.loops)) {
                for i in 0..3 {
                    put(&mut own.linear.0[i], from.force[i]);
                    put(&mut own.angular.0[i], from.moment[i]);
                }
            }
        }
        self.is_linearised &= !is_new;
    }

    /// Linearises and condenses the machine at the present states, a kilogram having the weight `gravity` (N, O axes).
    pub(super) fn linearise(&mut self, machine: &Machine, gravity: Vec3<R>) {
        self.linearise_with(
            machine,
            gravity,
            true,
            #[inline(always)]
            |_, system, chain, platform, input| system.fill(chain, platform, input),
        );
    }

    /// Linearises the machine by `fill`, which fills the system of each chain from its number, the platform and inputs; may condense them.
    #[inline(always)]
    pub(super) fn linearise_with(
        &mut self,
        machine: &Machine,
        gravity: Vec3<R>,
        condenses: bool,
        fill: impl Fn(usize, &mut ChainSystem<R>, &Chain, &Frame<R>, &ChainInput<'_, R>),
    ) {
        R::vectorized(
            #[inline(always)]
            || {
                self.condensed = if condenses { R::ALL } else { 0 };
                for (number, (((system, chain), chain_state), residual)) in
                    pairs(pairs(pairs(&mut self.systems, &machine.chains), &self.chains), &mut self.residuals)
                        .enumerate()
                {
                    fill(number, system, chain, &self.platform, &chain_state.input(&self.drives, gravity));
                    *residual = system.residual(machine.characteristic_length);
                    if condenses {
                        self.condensed &= system.eliminate();
                    }
                }
                if !condenses {
                    return;
                }
                self.tangent = platform::tangent(&self.systems);
                weight::add_stiffness(machine, &self.platform, gravity, &mut self.tangent);
                if machine.tool_compliance.is_some() {
                    self.add_tool_stiffness(machine);
                }
                self.condensed &= self.rigid.factorise(&self.systems, &self.tangent, machine.characteristic_length);
            },
        );
        self.is_linearised = condenses;
    }

    /// Adds the stiffness by the load that a deflected tool carries aside to the tangent, lane by lane.
    fn add_tool_stiffness(&mut self, machine: &Machine) {
        for lane in 0..R::LANES {
            let mut stiffness = [[0.0; 6]; 6];
            tool::add_stiffness(machine, &self.platform.lane(lane), &self.loads[lane], &mut stiffness);
            for (row, stiffness) in pairs(&mut self.tangent, &stiffness) {
                for (number, &part) in pairs(row, stiffness) {
                    number.set_lane(lane, number.lane(lane) + part);
                }
            }
        }
    }

    /// Lanes in which the platform is clearly stable at its present state. Other starts are left to the scalar iteration.
    fn plainly_stable(&self, machine: &Machine) -> u8 {
        R::vectorized(
            #[inline(always)]
            || platform::plainly_definite(&self.tangent, machine.characteristic_length),
        )
    }

    /// Task errors of the `active` lanes at their poses, in `count` coordinates; `None` if one of them has no task.
    fn task_errors(&self, machine: &Machine, cases: &[Case<'_>], active: u8, count: usize) -> Option<Tasks<R>> {
        let nothing = SquareTask { count, error: [R::zero(); 6], slope: [[R::zero(); 6]; 6], command: None };
        let mut tasks = Tasks { square: nothing, sizes: [0.0; MAX_LANES], fitting: 0 };
        for lane in lanes(active) {
            let body = self.platform.lane(lane);
            let task = cases[lane].task?(&tool::deflected_pose(machine, &body, &cases[lane].load));
            tasks.sizes[lane] = task.size();
            let Some(square) = SquareTask::new(&task, count) else { continue };
            tasks.fitting |= 1 << lane;
            for (row, from) in pairs(&mut tasks.square.slope, &square.slope) {
                for (number, &value) in pairs(row, from) {
                    number.set_lane(lane, value);
                }
            }
            for (number, &value) in pairs(&mut tasks.square.error, &square.error) {
                number.set_lane(lane, value);
            }
        }
        Some(tasks)
    }

    /// Judges the active lanes by their residuals, for `progress`, and returns the imbalance: applied wrench less chain wrenches (N, N·mm).
    fn judge_lanes(
        &self,
        machine: &Machine,
        cases: &[Case<'_>],
        tasks: Option<&Tasks<R>>,
        progress: &mut Progress,
        settings: &Settings,
    ) -> [R; 6] {
        let mut load = [R::zero(); 6];
        for (lane, case) in cases.iter().enumerate() {
            let on_body = match machine.tool_compliance {
                None => case.load,
                Some(_) => tool::load_on_body(machine, &self.platform.lane(lane), &case.load),
            };
            for (number, value) in pairs(load.iter_mut(), on_body.to_array()) {
                number.set_lane(lane, value);
            }
        }
        let (imbalance, residuals) = R::vectorized(
            #[inline(always)]
            || {
                let imbalance = self.imbalance(machine, Vec3::splat(&machine.gravity), load);
                (imbalance, self.residual(machine.characteristic_length, load, imbalance))
            },
        );
        progress.active &= self.condensed & tasks.map_or(u8::MAX, |tasks| tasks.fitting);
        for lane in lanes(progress.active) {
            let task_error = tasks.map_or(0.0, |tasks| tasks.sizes[lane] / machine.characteristic_length);
            let residual = task_error.larger(residuals.lane(lane));
            progress.residuals[lane] = residual;
            match progress.iterations[lane].judge(residual, settings) {
                IterationStatus::Continue => {}
                IterationStatus::Failed => progress.active &= !(1 << lane),
                IterationStatus::Solved => {
                    progress.active &= !(1 << lane);
                    progress.solved |= 1 << lane;
                }
            }
        }
        imbalance
    }

    /// Dimensionless residual: the largest closure gap over `scale` mm, or force out of balance over the largest wrench (the `load` on the
    /// platform's body, that of a chain, 1 N); `imbalance` is the platform's.
    #[inline(always)]
    pub(super) fn residual(&self, scale: f64, load: [R; 6], imbalance: [R; 6]) -> R {
        let one = R::splat(1.0);
        let mut largest_wrench = Screw::from_array(load).wrench_norm(scale);
        largest_wrench = R::select(largest_wrench.greater(one), largest_wrench, one);
        let (mut gap, mut force) = (R::zero(), R::zero());
        for (chain, residual) in pairs(&self.chains, &self.residuals) {
            gap = gap.larger(residual.gap);
            force = force.larger(residual.force);
            let wrench = chain.wrench.wrench_norm(scale);
            largest_wrench = R::select(wrench.greater(largest_wrench), wrench, largest_wrench);
        }
        force = force.larger(Screw::from_array(imbalance).wrench_norm(scale));
        (gap / R::splat(scale)).larger(force / largest_wrench)
    }

    /// Imbalance of the platform at P in O axes (N, N·mm): `load` on its body and its weight, less the chain wrenches.
    #[inline(always)]
    pub(super) fn imbalance(&self, machine: &Machine, gravity: Vec3<R>, load: [R; 6]) -> [R; 6] {
        let mut imbalance = load;
        if machine.platform_mass.is_some() {
            let weight = weight::wrench(machine, &self.platform, gravity);
            for (entry, part) in pairs(imbalance.iter_mut(), weight.to_array()) {
                *entry += part;
            }
        }
        for chain in &self.chains {
            for (entry, part) in pairs(imbalance.iter_mut(), chain.wrench.to_array()) {
                *entry -= part;
            }
        }
        imbalance
    }

    /// Takes a full Newton step in the active lanes; lanes without one, or with too large a one, are active no more.
    fn step_lanes(
        &mut self,
        machine: &Machine,
        imbalance: [R; 6],
        task: Option<&SquareTask<R>>,
        progress: &mut Progress,
    ) {
        let (twist, turn) = R::vectorized(
            #[inline(always)]
            || {
                let (twist, regular) = self.step(imbalance, task);
                progress.active &= regular;
                (twist, self.largest_rotation(&twist))
            },
        );
        for lane in lanes(progress.active) {
            if !progress.iterations[lane].accept_step(turn.lane(lane)) {
                progress.active &= !(1 << lane);
            }
        }
        self.apply(machine, twist, progress.active);
    }

    /// Computes the full Newton step of condensed chains, in which the drives move if there is a `task`: the twist of P (mm, rad), and the
    /// lanes in which there is one. The steps of the chains are left in their systems.
    #[inline(always)]
    pub(super) fn step(&mut self, imbalance: [R; 6], task: Option<&SquareTask<R>>) -> ([R; 6], u8) {
        let (systems, rigid, wrenches) = (&mut self.systems, &mut self.rigid, &mut self.drive_wrenches);
        let right = platform::right_hand_side(systems, &imbalance);
        let (twist, regular) = match task {
            None => platform::step(systems, rigid, self.tangent, right),
            Some(task) => {
                platform::drive_wrenches(systems, wrenches);
                let (twist, command, regular) =
                    platform::step_to_task(systems, rigid, self.tangent, right, wrenches, task, &mut self.drive_step);
                self.command_step = command;
                (twist, regular)
            }
        };
        let mut slacks = rigid.slacks();
        for (system, lane_chain) in pairs(systems, &self.chains) {
            let (own_slacks, others) = slacks.split_at(system.slack_count());
            slacks = others;
            system.substitute(1.0, &twist, &self.drive_step[lane_chain.drives.clone()], Some(own_slacks));
        }
        (twist, regular)
    }

    /// Largest rotation in the step, rad: of a joint, of a spring, or a component of the platform's `twist`.
    #[inline(always)]
    pub(super) fn largest_rotation(&self, twist: &[R; 6]) -> R {
        let mut turn = R::zero();
        for component in &twist[3..] {
            turn = turn.larger(component.abs());
        }
        for system in &self.systems {
            turn = turn.larger(system.largest_rotation());
        }
        turn
    }

    /// Adds the step, with the `twist` of P, to the states of the `active` lanes.
    pub(super) fn apply(&mut self, machine: &Machine, twist: [R; 6], active: u8) {
        R::vectorized(
            #[inline(always)]
            || {
                let mask = R::mask_from_bits(active);
                for (drive, &step) in pairs(&mut self.drives, &self.drive_step) {
                    *drive = R::select(mask, *drive + step, *drive);
                }
                for ((system, chain), state) in pairs(pairs(&self.systems, &machine.chains), &mut self.chains) {
                    for (coordinate, value) in state.coordinates.iter_mut().enumerate() {
                        *value = R::select(mask, *value + system.coordinate_step(coordinate), *value);
                    }
                    // The chain's step is that of the joint, ρ + θ_a; ρ has taken its part of it.
                    for (joint, drive) in chain.drives.iter().enumerate() {
                        let value = state.coordinates[drive.coordinate];
                        let mut deflection = value;
                        for (moved, &step) in self.drive_step[state.drives.clone()].iter().enumerate() {
                            match chain.joint_per_drive(joint, moved) {
                                0.0 => {}
                                1.0 => deflection -= step,
                                share => deflection -= R::splat(share) * step,
                            }
                        }
                        state.coordinates[drive.coordinate] = R::select(mask, deflection, value);
                    }
                    let mut wrench = state.wrench.to_array();
                    for (entry, step) in pairs(wrench.iter_mut(), system.wrench_step(&twist)) {
                        *entry = R::select(mask, *entry + step, *entry);
                    }
                    state.wrench = Screw::from_array(wrench);
                    if !state.loops.is_empty() {
                        let mut number = 0;
                        system.loop_wrench_steps(&mut |steps| {
                            let mut wrench = state.loops[number].to_array();
                            for (entry, step) in pairs(wrench.iter_mut(), steps) {
                                *entry = R::select(mask, *entry + step, *entry);
                            }
                            state.loops[number] = Screw::from_array(wrench);
                            number += 1;
                        });
                    }
                }
                let Frame { axes, origin } = self.platform;
                let step = Screw::from_array(twist);
                let turned = self.platform.turned_axes(&rotation_exp(step.angular));
                for (axis, (turned, old)) in pairs(&mut self.platform.axes, pairs(turned, axes)) {
                    *axis = Vec3::select(mask, turned, old);
                }
                self.platform.origin = Vec3::select(mask, origin + step.linear, origin);
            },
        );
        self.is_linearised = active == 0;
    }

    /// Appends the outcome of each case, with its drives and state, if its lane is solved and clearly stable; `None` otherwise.
    fn append_outcomes(
        &mut self,
        machine: &Machine,
        cases: &mut [Case<'_>],
        progress: &Progress,
        outcomes: &mut Vec<Option<Outcome>>,
    ) {
        let (compliance, good) = R::vectorized(
            #[inline(always)]
            || {
                let definite = platform::plainly_definite(&self.tangent, machine.characteristic_length);
                let (compliance, regular) = self.compliance();
                (compliance, definite & regular)
            },
        );
        let is_good = |lane: usize| (progress.solved & good) >> lane & 1 == 1;
        for (lane, case) in cases.iter_mut().enumerate() {
            outcomes.push(is_good(lane).then(|| {
                for (value, number) in pairs(&mut *case.drives, &self.drives) {
                    *value = number.lane(lane);
                }
                self.read_state(lane, case.state);
                let (steps, residual) = (progress.iterations[lane].steps, progress.residuals[lane]);
                let mut outcome = self.outcome(machine, lane, &compliance, Status::Solved, steps, residual);
                tool::convert_to_tool_end(machine, &case.load, case.state, &mut outcome);
                outcome
            }));
        }
    }

    /// Compliance of P with condensed chains, and the lanes in which there is one; turns the drive wrenches into twists of P per unit motion.
    #[inline(always)]
    pub(super) fn compliance(&mut self) -> (Square<R>, u8) {
        let (compliance, regular) = platform::compliance(&mut self.rigid, self.tangent);
        let twists = &mut self.drive_wrenches;
        platform::drive_twists(&self.systems, &mut self.rigid, &self.tangent, &compliance, twists);
        (compliance, regular)
    }

    /// Outcome of a lane after [`LaneSolver::compliance`], the full load taken at once.
    pub(super) fn outcome(
        &self,
        machine: &Machine,
        lane: usize,
        compliance: &Square<R>,
        status: Status,
        iterations: usize,
        residual: f64,
    ) -> Outcome {
        let (twists, compliance) = (&self.drive_wrenches, platform::lane_matrix(compliance, lane));
        let stiffness = match self.rigid.is_empty() {
            true => Some(platform::lane_matrix(&self.tangent, lane)),
            false => platform::stiffness(&compliance, machine.characteristic_length, self.rigid.slack_compliance()),
        };
        Outcome {
            status,
            iterations,
            residual,
            load_steps: 1,
            stiffness: stiffness.as_ref().map(platform::to_matrix),
            compliance: Some(platform::to_matrix(&compliance)),
            drive_sensitivity: Matrix6xX::from_fn(twists.len(), |i, j| twists[j][i].lane(lane)),
        }
    }

    /// Copies the state of `lane` to `state`, the pose being that of the platform's body.
    pub(super) fn read_state(&self, lane: usize, state: &mut State) {
        state.pose = self.platform.lane(lane);
        state.body = None;
        for (to, chain) in pairs(&mut state.chains, &self.chains) {
            for (value, number) in pairs(&mut to.coordinates, &chain.coordinates) {
                *value = number.lane(lane);
            }
            let lane_wrench = |wrench: &Screw<R>| Wrench::new(wrench.to_array().map(|number| number.lane(lane)));
            to.wrench = lane_wrench(&chain.wrench);
            for (to, wrench) in pairs(&mut to.loops, &chain.loops) {
                *to = lane_wrench(wrench);
            }
        }
    }
}

impl<R: Real> LaneChain<R> {
    /// Inputs of the chain's system, the machine's drives at `drives` (mm, rad) and a kilogram having the weight `gravity` (N).
    #[inline(always)]
    fn input<'a>(&'a self, drives: &'a [R], gravity: Vec3<R>) -> ChainInput<'a, R> {
        let (wrench, loops) = (self.wrench, &self.loops[..]);
        ChainInput { drives: &drives[self.drives.clone()], coordinates: &self.coordinates, wrench, loops, gravity }
    }
}

/// Indices of the lanes whose bits are set.
fn lanes(bits: u8) -> impl Iterator<Item = usize> {
    (0..MAX_LANES).filter(move |lane| bits >> lane & 1 == 1)
}
