//! The closure equations of a machine with what is commanded, and the damped Newton iteration that solves them.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::{Configuration, Unreachable, normal_step::NormalStep};
use crate::{
    machine::{Chain, Coordinate, Machine, Motion, MoveScrew, Route},
    spatial::{Pose, product, rotation_exp, rotation_log},
};

/// Largest closure error accepted, as a fraction of the machine's reach.
const CLOSURE_TOLERANCE: f64 = 1e-14;
/// Closure error down to which the iteration may stall on rounding and still count as solved.
pub(in crate::machine) const CLOSURE_ROUNDING: f64 = 1e-12;
const MAX_ITERATIONS: usize = 12;
/// A chain with a smaller gap is closed as far as a user is concerned, mm.
const CLOSED_MM: f64 = 1e-3;
/// A solution is on the branch of the start if all later steps together are no longer than this share of the first.
const NEAR: f64 = 0.5;
/// Largest change of a rotation within one continuation step, rad.
const MAX_STEP_ROTATION: f64 = 0.5;

/// Largest distance from P to a chain's base or to a joint axis when the chains stand as in `start`, mm.
pub(in crate::machine) fn reach(chains: &[Chain], start: &Configuration) -> f64 {
    let (mut values, mut screws) = (Vec::new(), Vec::new());
    let mut first_drive = 0;
    let mut reach: f64 = 1.0;
    for (chain, passive) in chains.iter().zip(&start.passive) {
        chain.rigid_values(&start.drives[first_drive..], passive, &mut values);
        first_drive += chain.drives.len();
        let end = chain.forward(&values, &mut screws);
        reach = reach.max((end.translation - chain.route.base.translation).norm());
        for screw in &screws {
            reach = reach.max(screw.twist.linear.norm() * screw.twist.angular.norm());
        }
    }
    reach
}

/// What is commanded.
pub(in crate::machine) enum Command<'a> {
    /// The controlled task coordinates of this pose.
    Task(&'a Pose),
    /// The drives.
    Drives(&'a [f64]),
}

/// Where a search stopped.
pub(in crate::machine) struct Reached {
    pub at: Configuration,
    /// Whether `at` solves the equations on the branch of the start.
    pub solved: bool,
}

/// Elementary motions and frames of a route.
#[derive(Default)]
struct Walk {
    screws: Vec<MoveScrew>,
    frames: Vec<Pose>,
}

/// The unknowns that move a chain coordinate, and by how much.
type Columns = Vec<(usize, f64)>;

/// Of each chain, the columns of its coordinates; none for those of springs, which stay undeflected.
fn columns(machine: &Machine) -> Vec<Vec<Columns>> {
    let (mut drive, mut joint) = (6, 6 + machine.drive_count());
    let of_chain = |chain: &Chain| {
        let mut columns = vec![Columns::new(); chain.virtual_count];
        for (shown, moved) in chain.drives.iter().enumerate() {
            columns[moved.coordinate] = match &chain.coupling {
                None => vec![(drive + shown, 1.0)],
                Some(coupling) => {
                    let shares = coupling.per_shown.row(shown);
                    let shares = shares.iter().enumerate().filter(|(_, share)| **share != 0.0);
                    shares.map(|(other, share)| (drive + other, *share)).collect()
                }
            };
        }
        columns.extend((joint..joint + chain.passive.len()).map(|column| vec![(column, 1.0)]));
        drive += chain.drives.len();
        joint += chain.passive.len();
        columns
    };
    machine.chains.iter().map(of_chain).collect()
}

/// The closure equations of a machine, linearised at a configuration.
pub(in crate::machine) struct Closure<'a> {
    pub machine: &'a Machine,
    values: Vec<f64>,
    /// What the rows of a route are made of, one for each depth of loops.
    walks: Vec<Walk>,
    pub jacobian: DMatrix<f64>,
    pub residual: DVector<f64>,
    /// The Jacobian where the last search began.
    pub(super) begun: DMatrix<f64>,
    normal_step: NormalStep,
    columns: Vec<Vec<Columns>>,
    /// Drives of a redundant machine that stay where they are: index and value, mm or rad; first those of [`Machine::held`](crate::machine::Model::held).
    pub held: Vec<(usize, f64)>,
}

impl<'a> Closure<'a> {
    pub fn new(machine: &'a Machine) -> Self {
        Self {
            held: machine.held.clone(),
            machine,
            values: Vec::new(),
            walks: Vec::new(),
            jacobian: DMatrix::zeros(0, 0),
            residual: DVector::zeros(0),
            begun: DMatrix::zeros(0, 0),
            normal_step: NormalStep::default(),
            columns: columns(machine),
        }
    }

    fn unknown_count(&self) -> usize {
        6 + self.machine.drive_count() + self.machine.chains.iter().map(|chain| chain.passive.len()).sum::<usize>()
    }

    /// Residual and Jacobian; all rotations, errors and unknowns alike, are multiplied by the reach and so are in mm.
    ///
    /// Unknowns: twist of P (6), drives, passive joints chain by chain.
    pub fn linearise(&mut self, at: &Configuration, command: &Command<'_>) {
        let machine = self.machine;
        let drive_count = machine.drive_count();
        let commanded = match command {
            Command::Task(_) => machine.controls.len(),
            Command::Drives(_) => drive_count,
        };
        let closures = machine.closure_count();
        let shape = (6 * closures + commanded, self.unknown_count());
        if self.jacobian.shape() != shape {
            self.jacobian = DMatrix::zeros(shape.0, shape.1);
            self.residual = DVector::zeros(shape.0);
        }
        self.jacobian.fill(0.0);
        let (mut drive, mut row) = (6, 0);
        let (mut walks, columns) = (std::mem::take(&mut self.walks), std::mem::take(&mut self.columns));
        for (c, chain) in machine.chains.iter().enumerate() {
            chain.rigid_values(&at.drives[drive - 6..], &at.passive[c], &mut self.values);
            for i in 0..6 {
                self.jacobian[(row + i, i)] = -1.0;
            }
            self.route_rows(&chain.route, &columns[c], &Pose::identity(), &at.pose, &mut row, &mut walks);
            drive += chain.drives.len();
        }
        (self.walks, self.columns) = (walks, columns);
        self.command_rows(at, command, 6 * closures);
    }

    /// Rows of a route that starts at `start` and should end at `target`, and behind them those of its loops. `row`: the first
    /// of them, and then the first behind them.
    fn route_rows(
        &mut self,
        route: &Route,
        columns: &[Columns],
        start: &Pose,
        target: &Pose,
        row: &mut usize,
        walks: &mut Vec<Walk>,
    ) {
        let mut walk = walks.pop().unwrap_or_default();
        let end = route.forward(start, &self.values, &mut walk.screws, &mut walk.frames);
        let gap = end.translation - target.translation;
        let turn = rotation_log(&product(&end.rotation, &target.rotation.transpose())) * self.machine.reach;
        self.residual.fixed_rows_mut::<3>(*row).copy_from(&gap);
        self.residual.fixed_rows_mut::<3>(*row + 3).copy_from(&turn);
        for screw in &walk.screws {
            self.add_screw(*row, columns, screw, 1.0);
        }
        *row += 6;
        if !route.loops.is_empty() {
            let before = route.moves_before_frames();
            for inner in &route.loops {
                let (from, to) = (walk.frames[inner.from], walk.frames[inner.to]);
                let first = *row;
                self.route_rows(&inner.route, columns, &from, &to, row, walks);
                // What the frame at the loop's end does with the motions between its ends.
                for screw in &walk.screws[before[inner.from]..before[inner.to]] {
                    let mut screw = *screw;
                    screw.twist.linear += screw.twist.angular.cross(&(to.translation - end.translation));
                    self.add_screw(first, columns, &screw, -1.0);
                }
            }
        }
        walks.push(walk);
    }

    /// Adds `sign` times the motion of an elementary motion to the rows from `row` on.
    fn add_screw(&mut self, row: usize, columns: &[Columns], screw: &MoveScrew, sign: f64) {
        let columns = &columns[screw.coordinate];
        if columns.is_empty() {
            return;
        }
        let is_revolute = screw.twist.angular != Vector3::zeros();
        let unit = if is_revolute { 1.0 / self.machine.reach } else { 1.0 };
        for &(column, share) in columns {
            let share = sign * share;
            let mut entries = self.jacobian.fixed_view_mut::<6, 1>(row, column);
            for i in 0..3 {
                entries[i] += share * screw.twist.linear[i] * unit;
                entries[3 + i] += share * screw.twist.angular[i];
            }
        }
    }

    fn command_rows(&mut self, at: &Configuration, command: &Command<'_>, first: usize) {
        match command {
            Command::Drives(rho) => {
                for (d, (&wanted, (_, drive))) in rho.iter().zip(self.machine.drives()).enumerate() {
                    self.residual[first + d] = (at.drives[d] - wanted) * self.unit(drive.motion);
                    self.jacobian[(first + d, 6 + d)] = 1.0;
                }
            }
            Command::Task(target) => {
                let turn = rotation_log(&product(&target.rotation.transpose(), &at.pose.rotation));
                for (row, coordinate) in self.machine.controls.iter().enumerate() {
                    self.residual[first + row] = match *coordinate {
                        Coordinate::Translation(axis) => at.pose.translation[axis] - target.translation[axis],
                        Coordinate::Rotation(axis) => turn[axis] * self.machine.reach,
                    };
                    for i in 0..6 {
                        self.jacobian[(first + row, i)] = task_entry(*coordinate, &target.rotation, i);
                    }
                }
            }
        }
    }

    /// Damped Newton from `start`, ended where its result can no longer be a solution close enough to the first-order prediction to
    /// lie on the same branch; the configuration where it stops, and whether it is one.
    pub fn newton(&mut self, start: &Configuration, command: &Command<'_>) -> Reached {
        self.iterate(start, command, true)
    }

    /// Where damped Newton from `start` stops, on whatever branch.
    pub fn approach(&mut self, start: &Configuration, command: &Command<'_>) -> Configuration {
        self.iterate(start, command, false).at
    }

    fn iterate(&mut self, start: &Configuration, command: &Command<'_>, only_on_branch: bool) -> Reached {
        let reach = self.machine.reach;
        let closures = 6 * self.machine.closure_count();
        let mut at = start.clone();
        let (mut damping, mut best) = (1e-12, f64::INFINITY);
        let (mut first_step, mut later_steps) = (0.0, 0.0);
        for iteration in 0..MAX_ITERATIONS {
            self.linearise(&at, command);
            if !self.residual.iter().all(|entry| entry.is_finite()) {
                return Reached { at, solved: false };
            }
            if iteration == 0 {
                self.begun.clone_from(&self.jacobian);
            }
            let error = self.residual.amax();
            let stalled = error < CLOSURE_ROUNDING * reach && error > 0.3 * best;
            if error < CLOSURE_TOLERANCE * reach || stalled {
                let on_branch = iteration <= 1 || later_steps <= NEAR * first_step;
                let accepted = on_branch && self.rotation_change(start, &at) < MAX_STEP_ROTATION;
                return Reached { at, solved: accepted };
            }
            if only_on_branch && iteration > 1 && later_steps > NEAR * first_step {
                return Reached { at, solved: false };
            }
            damping = if error < best { (damping * 0.1f64).max(1e-14) } else { (damping * 100.0).max(1e-6) };
            best = best.min(error);
            let step = match command {
                Command::Task(_) if self.machine.redundancy > 0 => self.least_motion(&at),
                _ => self.normal_step.solve(self.machine, &self.jacobian, &self.residual, closures, damping),
            };
            let Some(step) = step else { return Reached { at, solved: false } };
            if !step.iter().all(|v| v.is_finite()) {
                return Reached { at, solved: false };
            }
            let length = step.norm();
            if iteration == 0 {
                first_step = length
            } else {
                later_steps += length
            }
            self.advance(&mut at, &step);
        }
        Reached { at, solved: false }
    }

    pub fn advance(&self, at: &mut Configuration, step: &DVector<f64>) {
        let translation: Vector3<f64> = step.fixed_rows::<3>(0).into();
        let rotation: Vector3<f64> = step.fixed_rows::<3>(3).into();
        at.pose.translation += translation;
        at.pose.rotation = product(&rotation_exp(rotation / self.machine.reach), &at.pose.rotation);
        let joints = at.drives.iter_mut().chain(at.passive.iter_mut().flatten());
        for ((value, motion), step) in joints.zip(self.motions()).zip(step.iter().skip(6)) {
            *value += step / self.unit(motion);
        }
    }

    /// Motion of each drive, then of each passive joint.
    pub(super) fn motions(&self) -> impl Iterator<Item = Motion> {
        let machine = self.machine;
        let passive = machine.chains.iter().flat_map(|chain| chain.passive.iter().map(|joint| joint.motion));
        machine.drives().map(|(_, drive)| drive.motion).chain(passive)
    }

    /// What a joint's coordinate is multiplied by to make it a length.
    pub fn unit(&self, motion: Motion) -> f64 {
        match motion {
            Motion::Prismatic => 1.0,
            Motion::Revolute => self.machine.reach,
        }
    }

    /// Largest change of a revolute joint, rad.
    fn rotation_change(&self, from: &Configuration, to: &Configuration) -> f64 {
        let values =
            |c: &Configuration| -> Vec<f64> { c.drives.iter().chain(c.passive.iter().flatten()).copied().collect() };
        let changes = values(from).into_iter().zip(values(to)).zip(self.motions());
        changes.filter(|(_, motion)| *motion == Motion::Revolute).fold(0.0, |most, ((a, b), _)| most.max((a - b).abs()))
    }

    /// Why `command` is not met, as seen at `at`, where the search stopped: the chain that closes worst, and its gap.
    pub(super) fn why_not(&mut self, at: &Configuration, command: &Command<'_>) -> Unreachable {
        self.linearise(at, command);
        let gaps = self.machine.closure_names().into_iter().enumerate().map(|(c, name)| {
            let gap = self.residual.rows(6 * c, 6).norm();
            (name, gap)
        });
        match gaps.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((chain, gap_mm)) if gap_mm.is_nan() || gap_mm >= CLOSED_MM => Unreachable::Closure { chain, gap_mm },
            _ => Unreachable::OtherMode,
        }
    }
}

/// What a task coordinate gains by the unknown `i` where a platform turned by `rotation` is commanded.
pub(super) fn task_entry(coordinate: Coordinate, rotation: &Matrix3<f64>, i: usize) -> f64 {
    match coordinate {
        Coordinate::Translation(axis) if i == axis => 1.0,
        Coordinate::Rotation(axis) if (3..6).contains(&i) => rotation[(i - 3, axis)],
        _ => 0.0,
    }
}

impl Machine {
    /// Closure Jacobian at `at`: `6m` rows (mm, rad × reach), columns twist of P, drives, passive joints.
    pub(in crate::machine) fn closure_jacobian(&self, at: &Configuration) -> DMatrix<f64> {
        let mut closure = Closure::new(self);
        closure.linearise(at, &Command::Drives(&at.drives));
        closure.jacobian.rows(0, 6 * self.closure_count()).into_owned()
    }

    /// Number of routes that must end where another does or where P is: chains and their loops.
    pub(super) fn closure_count(&self) -> usize {
        self.chains.iter().map(|chain| 1 + chain.route.loop_count()).sum()
    }

    /// Names of these routes, in the order of their equations.
    fn closure_names(&self) -> Vec<String> {
        fn loops(route: &Route, chain: &str, names: &mut Vec<String>) {
            for inner in &route.loops {
                names.push(format!("{chain} ({})", inner.name));
                loops(&inner.route, chain, names);
            }
        }
        let mut names = Vec::new();
        for chain in &self.chains {
            names.push(chain.name.clone());
            loops(&chain.route, &chain.name, &mut names);
        }
        names
    }
}
