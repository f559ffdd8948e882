//! Rigid kinematics of any machine: all chain ends on one platform pose, springs undeflected.
//!
//! Unknowns are the drives, the passive joints and the platform pose; equations are the six closure errors of each chain
//! and what is commanded (task coordinates in the inverse problem, drives in the forward one). They are solved by a damped
//! least-squares Newton (Levenberg–Marquardt) that follows the straight line from a known configuration, usually home,
//! in steps short enough to stay on its assembly mode. Where the drives control more than the task asks for, the module
//! `redundancy` says what they do; where the straight line does not lead to the target, `ways_around` tries others.

use std::{borrow::Cow, f64::consts::TAU};

use nalgebra::{DMatrix, DVector, Vector3};
use serde::{Deserialize, Serialize};

use super::{Chain, Coordinate, Machine, Motion, MoveScrew, task_space::shown};
use crate::spatial::{Pose, rotation_exp, rotation_log};

/// A rigid configuration of the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    /// Pose of P in O.
    pub pose: Pose,
    /// Coordinates of all drives in machine order, mm or rad.
    pub drives: Vec<f64>,
    /// Passive joint coordinates of each chain, mm or rad.
    pub passive: Vec<Vec<f64>>,
}

/// Why a target cannot be reached.
#[derive(Debug, Clone, PartialEq, thiserror::Error, Serialize, Deserialize)]
pub enum Unreachable {
    /// No configuration closes the chains.
    #[error("chain {chain} cannot close: gap {gap_mm:.3} mm")]
    Closure {
        /// The chain with the largest gap.
        chain: String,
        /// Its gap where the search stopped, rotations weighted by the machine's reach.
        gap_mm: f64,
    },
    /// The chains do not close at the target: the straight way there ends before it.
    #[error("chain {chain} cannot close there; the straight way ends {short_mm:.1} mm before")]
    TooFar {
        /// The chain that closes worst.
        chain: String,
        /// From where the straight way ends to the target in the controlled coordinates, rotations weighted by the machine's
        /// reach.
        short_mm: f64,
    },
    /// The chains close there, but the way from home leads through a singularity or to another assembly mode.
    #[error("only on another assembly mode than home, or beyond a singularity")]
    OtherMode,
    /// Neither the straight line from home nor another way leads there.
    #[error("{straight}; ways around tried: {tried}")]
    NoWay {
        /// What the straight line ends with.
        straight: Box<Unreachable>,
        /// What else was tried.
        tried: Cow<'static, str>,
    },
    /// A coordinate is asked for that the drives do not control, and the machine is elsewhere in it.
    #[error(
        "{axis}: asked {asked} mm, the machine stays at {stands} mm: difference {} mm; it controls {controls}",
        shown(.asked - .stands)
    )]
    Uncontrolled {
        /// The coordinate: x, y or z of P.
        axis: Cow<'static, str>,
        /// What is asked for, mm.
        asked: f64,
        /// Where P stands, mm.
        stands: f64,
        /// The coordinates that are controlled.
        controls: String,
    },
    /// The platform turns with its position, and the point that is to be led is not where it should be.
    #[error(
        "the platform turns with its position: no place of it was found that puts the point of the path where it is asked for \
         (the nearest leaves {beside_mm:.3} mm)"
    )]
    Turned {
        /// How far the point is from where it is asked for, mm.
        beside_mm: f64,
    },
    /// A drive would leave its travel.
    #[error("drive {drive} of chain {chain} at {value:.3} {unit}, travel {low:.3} to {high:.3} {unit}")]
    Travel {
        /// Its chain.
        chain: String,
        /// Its name.
        drive: String,
        /// Where it would have to stand.
        value: f64,
        /// Lower end of the travel.
        low: f64,
        /// Upper end of the travel.
        high: f64,
        /// `mm` or `deg`.
        unit: Cow<'static, str>,
    },
    /// A passive joint would leave its limits.
    #[error("joint {joint} of chain {chain} at {value:.3} {unit}, limits {low:.3} to {high:.3} {unit}")]
    JointLimit {
        /// Its chain.
        chain: String,
        /// Its name.
        joint: String,
        /// Where it would have to stand.
        value: f64,
        /// Lower limit.
        low: f64,
        /// Upper limit.
        high: f64,
        /// `mm` or `deg`.
        unit: Cow<'static, str>,
    },
}

/// Largest closure error accepted, as a fraction of the machine's reach.
const CLOSURE_TOLERANCE: f64 = 1e-14;
/// Closure error down to which the iteration may stall on rounding and still count as solved.
pub(super) const CLOSURE_ROUNDING: f64 = 1e-12;
const MAX_ITERATIONS: usize = 12;
/// A drive or joint is at its limit, not beyond it, within this share of the limit: rounding of what the search for the
/// configuration, and a program's numbers, leave.
const LIMIT_ROUNDING: f64 = 1e-9;
/// A chain with a smaller gap is closed as far as a user is concerned, mm.
const CLOSED_MM: f64 = 1e-3;
/// A pivot below this fraction of the largest is zero.
const RANK_TOLERANCE: f64 = 1e-9;
/// Largest change of a rotation within one continuation step, rad.
const MAX_STEP_ROTATION: f64 = 0.5;
const MIN_CONTINUATION_STEP: f64 = 1.0 / 1024.0;
/// Where a straight way ends is found to this share of the machine's reach, but to no less than this share of the way.
const WAY_END: f64 = 1e-4;
const MIN_WAY_STEP: f64 = 1.0 / 16384.0;

impl Configuration {
    /// Joint values from which a machine's home is sought.
    pub(super) fn start(chains: &[Chain], pose: Pose) -> Self {
        Self {
            pose,
            drives: chains.iter().flat_map(|chain| chain.drives.iter().map(|drive| drive.home)).collect(),
            passive: chains.iter().map(|chain| chain.passive.iter().map(|joint| joint.home).collect()).collect(),
        }
    }
}

/// Value of each coordinate of `chain` for drives `drives` and passive joints `passive`, springs undeflected.
fn rigid_values(chain: &Chain, drives: &[f64], passive: &[f64], values: &mut Vec<f64>) {
    values.clear();
    values.resize(chain.virtual_count, 0.0);
    for (drive, &rho) in chain.drives.iter().zip(drives) {
        values[drive.coordinate] = rho;
    }
    values.extend_from_slice(passive);
}

/// Largest distance from P to a chain's base or to a joint axis when the chains stand as in `start`, mm.
pub(super) fn reach(chains: &[Chain], start: &Configuration) -> f64 {
    let (mut values, mut screws) = (Vec::new(), Vec::new());
    let mut first_drive = 0;
    let mut reach: f64 = 1.0;
    for (chain, passive) in chains.iter().zip(&start.passive) {
        rigid_values(chain, &start.drives[first_drive..], passive, &mut values);
        first_drive += chain.drives.len();
        let end = chain.forward(&values, &mut screws);
        reach = reach.max((end.translation - chain.base.translation).norm());
        for screw in &screws {
            reach = reach.max(screw.twist.linear.norm() * screw.twist.angular.norm());
        }
    }
    reach
}

/// What is commanded.
pub(super) enum Command<'a> {
    /// The controlled task coordinates of this pose.
    Task(&'a Pose),
    /// The drives.
    Drives(&'a [f64]),
}

/// Where a search stopped.
pub(super) struct Reached {
    pub at: Configuration,
    /// Whether `at` solves the equations on the branch of the start.
    pub solved: bool,
}

/// The closure equations of a machine, linearised at a configuration.
pub(super) struct Closure<'a> {
    pub machine: &'a Machine,
    values: Vec<f64>,
    screws: Vec<MoveScrew>,
    pub jacobian: DMatrix<f64>,
    pub residual: DVector<f64>,
    /// Drives of a redundant machine that stay where they are: index and value, mm or rad.
    pub held: Vec<(usize, f64)>,
}

impl<'a> Closure<'a> {
    pub fn new(machine: &'a Machine) -> Self {
        Self {
            held: Vec::new(),
            machine,
            values: Vec::new(),
            screws: Vec::new(),
            jacobian: DMatrix::zeros(0, 0),
            residual: DVector::zeros(0),
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
        let (m, reach) = (machine.chains.len(), machine.reach);
        let drive_count = machine.drive_count();
        let commanded = match command {
            Command::Task(_) => machine.controls.len(),
            Command::Drives(_) => drive_count,
        };
        let shape = (6 * m + commanded, self.unknown_count());
        if self.jacobian.shape() != shape {
            self.jacobian = DMatrix::zeros(shape.0, shape.1);
            self.residual = DVector::zeros(shape.0);
        }
        self.jacobian.fill(0.0);
        let (mut drive, mut joint) = (6, 6 + drive_count);
        for (c, chain) in machine.chains.iter().enumerate() {
            rigid_values(chain, &at.drives[drive - 6..], &at.passive[c], &mut self.values);
            let end = chain.forward(&self.values, &mut self.screws);
            let row = 6 * c;
            let gap = end.translation - at.pose.translation;
            let turn = rotation_log(&(end.rotation * at.pose.rotation.transpose())) * reach;
            self.residual.fixed_rows_mut::<3>(row).copy_from(&gap);
            self.residual.fixed_rows_mut::<3>(row + 3).copy_from(&turn);
            for i in 0..6 {
                self.jacobian[(row + i, i)] = -1.0;
            }
            for screw in &self.screws {
                let column = if screw.coordinate >= chain.virtual_count {
                    joint + screw.coordinate - chain.virtual_count
                } else if let Some(d) = chain.drives.iter().position(|d| d.coordinate == screw.coordinate) {
                    drive + d
                } else {
                    continue;
                };
                let is_revolute = screw.twist.angular != Vector3::zeros();
                let unit = if is_revolute { 1.0 / reach } else { 1.0 };
                for i in 0..3 {
                    self.jacobian[(row + i, column)] += screw.twist.linear[i] * unit;
                    self.jacobian[(row + 3 + i, column)] += screw.twist.angular[i];
                }
            }
            drive += chain.drives.len();
            joint += chain.passive.len();
        }
        self.command_rows(at, command, 6 * m);
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
                let turn = rotation_log(&(target.rotation.transpose() * at.pose.rotation));
                for (row, coordinate) in self.machine.controls.iter().enumerate() {
                    match *coordinate {
                        Coordinate::Translation(axis) => {
                            self.residual[first + row] = at.pose.translation[axis] - target.translation[axis];
                            self.jacobian[(first + row, axis)] = 1.0;
                        }
                        Coordinate::Rotation(axis) => {
                            self.residual[first + row] = turn[axis] * self.machine.reach;
                            for i in 0..3 {
                                self.jacobian[(first + row, 3 + i)] = target.rotation[(i, axis)];
                            }
                        }
                    }
                }
            }
        }
    }

    /// Damped Newton from `start`; the configuration where it stops, and whether it is a solution close enough to the
    /// first-order prediction to lie on the same branch.
    pub fn newton(&mut self, start: &Configuration, command: &Command<'_>) -> Reached {
        let reach = self.machine.reach;
        let mut at = start.clone();
        let (mut damping, mut best) = (1e-12, f64::INFINITY);
        let (mut first_step, mut later_steps) = (0.0, 0.0);
        for iteration in 0..MAX_ITERATIONS {
            self.linearise(&at, command);
            if !self.residual.iter().all(|entry| entry.is_finite()) {
                return Reached { at, solved: false };
            }
            let error = self.residual.amax();
            let stalled = error < CLOSURE_ROUNDING * reach && error > 0.3 * best;
            if error < CLOSURE_TOLERANCE * reach || stalled {
                let on_branch = iteration <= 1 || later_steps <= 0.5 * first_step;
                let accepted = on_branch && self.rotation_change(start, &at) < MAX_STEP_ROTATION;
                return Reached { at, solved: accepted };
            }
            damping = if error < best { (damping * 0.1f64).max(1e-14) } else { (damping * 100.0).max(1e-6) };
            best = best.min(error);
            let step = match command {
                Command::Task(_) if self.machine.redundancy > 0 => self.least_motion(&at),
                _ => self.damped_step(damping),
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

    /// Least-squares step of the present linearisation, damped by this share of its largest diagonal entry.
    fn damped_step(&self, damping: f64) -> Option<DVector<f64>> {
        let transposed = self.jacobian.transpose();
        let mut normal = &transposed * &self.jacobian;
        let level = damping * normal.diagonal().amax();
        for i in 0..normal.nrows() {
            normal[(i, i)] += level;
        }
        Some(normal.cholesky()?.solve(&(transposed * -&self.residual)))
    }

    pub fn advance(&self, at: &mut Configuration, step: &DVector<f64>) {
        let translation: Vector3<f64> = step.fixed_rows::<3>(0).into();
        let rotation: Vector3<f64> = step.fixed_rows::<3>(3).into();
        at.pose.translation += translation;
        at.pose.rotation = rotation_exp(rotation / self.machine.reach) * at.pose.rotation;
        let joints = at.drives.iter_mut().chain(at.passive.iter_mut().flatten());
        for ((value, motion), step) in joints.zip(self.motions()).zip(step.iter().skip(6)) {
            *value += step / self.unit(motion);
        }
    }

    /// Motion of each drive, then of each passive joint.
    fn motions(&self) -> impl Iterator<Item = Motion> {
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

    /// Whether a singularity lies between two near configurations: the determinant of the linearised problem changes sign,
    /// with the drives commanded (parallel singularity) or with the task commanded (the end of a chain's reach).
    ///
    /// The problem has more equations than unknowns where the machine is over-constrained; its determinant is taken on
    /// the column space at `from`. A machine with idle joints is always singular, and is not judged; one that is singular at
    /// `from` and not at home does not lead on.
    fn passes_singularity(&mut self, from: &Configuration, to: &Configuration) -> bool {
        let by_drives = (Command::Drives(&from.drives), Command::Drives(&to.drives));
        let by_task = (Command::Task(&from.pose), Command::Task(&to.pose));
        [by_drives, by_task].iter().any(|(before, after)| {
            self.linearise(from, before);
            if self.jacobian.nrows() < self.jacobian.ncols() {
                return false;
            }
            let (basis, triangle) = self.jacobian.clone().qr().unpack();
            let pivots = triangle.diagonal();
            if is_singular(&pivots) {
                return !self.is_singular_at_home(before);
            }
            self.linearise(to, after);
            let projected = basis.transpose() * &self.jacobian;
            projected.determinant() * pivots.iter().map(|p| p.signum()).product::<f64>() < 0.0
        })
    }

    /// Whether the linearised problem is singular at home for commands such as this one.
    fn is_singular_at_home(&mut self, command: &Command<'_>) -> bool {
        let home = &self.machine.home;
        match command {
            Command::Drives(_) => self.linearise(home, &Command::Drives(&home.drives)),
            Command::Task(_) => self.linearise(home, &Command::Task(&home.pose)),
        }
        self.jacobian.nrows() < self.jacobian.ncols() || is_singular(&self.jacobian.clone().qr().unpack_r().diagonal())
    }

    /// Why `command` is not met, as seen at `at`, where the search stopped: the chain that closes worst, and its gap.
    fn why_not(&mut self, at: &Configuration, command: &Command<'_>) -> Unreachable {
        self.linearise(at, command);
        let gaps = self.machine.chains.iter().enumerate().map(|(c, chain)| {
            let gap = self.residual.rows(6 * c, 6).norm();
            (chain.name.clone(), gap)
        });
        match gaps.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((chain, gap_mm)) if gap_mm.is_nan() || gap_mm >= CLOSED_MM => Unreachable::Closure { chain, gap_mm },
            _ => Unreachable::OtherMode,
        }
    }
}

/// Whether the triangle with these diagonal entries has a pivot that is zero.
fn is_singular(pivots: &DVector<f64>) -> bool {
    pivots.amin() < RANK_TOLERANCE * pivots.amax()
}

impl Machine {
    /// Inverse kinematics: the configuration that puts the controlled task coordinates of P on those of `target`, on the
    /// assembly mode of home.
    ///
    /// It is the one that the straight line from home leads to. Where that does not lead there, or beyond a limit, other
    /// ways are tried: a serial machine takes any posture that its travel allows, the nearest to home of those found, since
    /// nothing is in the way from one to another; a parallel one goes around, without passing a singularity. Hinges are
    /// taken a full turn back or on where that brings them within their travel. Where the drives control more than the
    /// task asks for, they stand as near to home as they can, see [`Machine::redundancy`].
    ///
    /// # Errors
    /// [`Unreachable`] if no such configuration is found, or only beyond a limit.
    pub fn inverse_kinematics(&self, target: &Pose) -> Result<Configuration, Unreachable> {
        self.inverse_kinematics_from(&self.home, target).or_else(|straight| self.way_around(target, straight))
    }

    /// Inverse kinematics continued on the straight line from a known configuration `start` instead of home; no other way
    /// is tried.
    ///
    /// # Errors
    /// As [`Machine::inverse_kinematics`].
    pub fn inverse_kinematics_from(&self, start: &Configuration, target: &Pose) -> Result<Configuration, Unreachable> {
        let configuration = self.unlimited_inverse_kinematics_from(start, target)?;
        self.within_limits(configuration, target)
    }

    /// As [`Machine::inverse_kinematics_from`], as if travel and joints had no limits.
    pub(crate) fn unlimited_inverse_kinematics_from(
        &self,
        start: &Configuration,
        target: &Pose,
    ) -> Result<Configuration, Unreachable> {
        let turn = rotation_log(&(start.pose.rotation.transpose() * target.rotation));
        let shift = target.translation - start.pose.translation;
        let start_pose = start.pose;
        let along = move |s: f64| Pose {
            rotation: start_pose.rotation * rotation_exp(turn * s),
            translation: start_pose.translation + shift * s,
        };
        let length = shift.norm().hypot(turn.norm() * self.reach);
        let least_step = (WAY_END * self.reach / length).clamp(MIN_WAY_STEP, MIN_CONTINUATION_STEP);
        let reached = self.follow(start, least_step, |s, closure, from| {
            let pose = if s == 1.0 { *target } else { along(s) };
            closure.newton(from, &Command::Task(&pose))
        });
        let end = reached.at.pose;
        self.closed(reached, &Command::Task(target)).map_err(|unreachable| match unreachable {
            Unreachable::Closure { chain, .. } => Unreachable::TooFar { chain, short_mm: self.way_left(&end, target) },
            other => other,
        })
    }

    /// From `at` to `target` in the controlled coordinates, mm, rotations weighted by the reach.
    fn way_left(&self, at: &Pose, target: &Pose) -> f64 {
        let turn = rotation_log(&(at.rotation.transpose() * target.rotation)) * self.reach;
        let shift = target.translation - at.translation;
        let left = self.controls.iter().map(|coordinate| match *coordinate {
            Coordinate::Translation(axis) => shift[axis],
            Coordinate::Rotation(axis) => turn[axis],
        });
        left.map(|left| left * left).sum::<f64>().sqrt()
    }

    /// `at`, which meets `target`, moved by what is free: full turns, and the freedom of redundant drives.
    ///
    /// # Errors
    /// A limit that is violated all the same.
    pub(super) fn within_limits(&self, at: Configuration, target: &Pose) -> Result<Configuration, Unreachable> {
        let mut at = if self.redundancy > 0 { self.nearest_to_home(at, target) } else { at };
        if self.check_limits(&at).is_err() {
            self.turn_within_travel(&mut at);
        }
        self.check_limits(&at)?;
        Ok(at)
    }

    /// Takes hinge drives beyond their travel a full turn back or on where that brings them within.
    fn turn_within_travel(&self, at: &mut Configuration) {
        for ((_, drive), rho) in self.drives().zip(&mut at.drives) {
            let Some((low, high)) = drive.travel.filter(|_| drive.motion == Motion::Revolute) else { continue };
            let (up, down) = (*rho + ((low - *rho) / TAU).ceil() * TAU, *rho - ((*rho - high) / TAU).ceil() * TAU);
            match *rho {
                value if value < low && up <= high => *rho = up,
                value if value > high && down >= low => *rho = down,
                _ => {}
            }
        }
    }

    /// Derivative of the drives by the controlled task coordinates at `at`: one row per drive (mm, rad), one column per
    /// coordinate (mm, rad about the axes of the platform). Redundant drives move as little as they can, slides in mm and
    /// hinges in mm at the machine's reach. `None` at the end of a chain's reach.
    pub fn drive_jacobian(&self, at: &Configuration) -> Option<DMatrix<f64>> {
        let mut closure = Closure::new(self);
        closure.linearise(at, &Command::Task(&at.pose));
        let (equations, coordinates) = (closure.jacobian.nrows(), self.controls.len());
        let mut right = DMatrix::zeros(equations, coordinates);
        for (i, coordinate) in self.controls.iter().enumerate() {
            right[(equations - coordinates + i, i)] = match coordinate {
                Coordinate::Translation(_) => 1.0,
                Coordinate::Rotation(_) => self.reach,
            };
        }
        let mut by_task = if self.redundancy > 0 {
            closure.least_motions(&right)?
        } else {
            let transposed = closure.jacobian.transpose();
            let factor = (&transposed * &closure.jacobian).cholesky()?;
            let unknowns = factor.solve(&(transposed * right));
            unknowns.rows(6, self.drive_count()).into_owned()
        };
        for (mut row, (_, drive)) in by_task.row_iter_mut().zip(self.drives()) {
            row /= closure.unit(drive.motion);
        }
        Some(by_task)
    }

    /// Forward kinematics: the configuration with drives at `drives` (mm, rad), on the assembly mode of home. Limits of
    /// passive joints are not checked.
    ///
    /// # Errors
    /// [`Unreachable::Closure`] if the chains cannot close with these drives.
    pub fn forward_kinematics(&self, drives: &[f64]) -> Result<Configuration, Unreachable> {
        self.forward_kinematics_from(&self.home, drives)
    }

    /// Forward kinematics continued from a known configuration `start` instead of home.
    ///
    /// # Errors
    /// As [`Machine::forward_kinematics`].
    pub fn forward_kinematics_from(&self, start: &Configuration, drives: &[f64]) -> Result<Configuration, Unreachable> {
        let reached = self.follow(start, MIN_CONTINUATION_STEP, |s, closure, from| {
            let rho: Vec<f64> = start.drives.iter().zip(drives).map(|(a, b)| a + (b - a) * s).collect();
            closure.newton(from, &Command::Drives(&rho))
        });
        self.closed(reached, &Command::Drives(drives))
    }

    /// Follows a one-parameter family of commands from s = 0 (solved by `start`) to s = 1 with adaptive steps, down to
    /// `least_step`.
    fn follow<'a>(
        &'a self,
        start: &Configuration,
        least_step: f64,
        mut solve: impl FnMut(f64, &mut Closure<'a>, &Configuration) -> Reached,
    ) -> Reached {
        let mut closure = Closure::new(self);
        let (mut at, mut s, mut step) = (start.clone(), 0.0, 1.0f64);
        while s < 1.0 {
            let next = f64::min(1.0, s + step);
            let reached = solve(next, &mut closure, &at);
            if reached.solved && !closure.passes_singularity(&at, &reached.at) {
                at = reached.at;
                s = next;
                step *= 2.0;
            } else if step > least_step {
                step *= 0.5;
            } else {
                return Reached { at, solved: false };
            }
        }
        Reached { at, solved: true }
    }

    /// The configuration reached, or the chain that closes worst where the search for it stops.
    fn closed(&self, reached: Reached, command: &Command<'_>) -> Result<Configuration, Unreachable> {
        if reached.solved {
            return Ok(reached.at);
        }
        let mut closure = Closure::new(self);
        let mut nearest = reached.at;
        for _ in 0..8 {
            nearest = closure.newton(&nearest, command).at;
        }
        Err(closure.why_not(&nearest, command))
    }

    /// Closes all chains at the home pose, from the joint values given in the machine file.
    pub(super) fn assemble_at_home(&self) -> Result<Configuration, Unreachable> {
        let mut closure = Closure::new(self);
        let command = Command::Task(&self.home.pose);
        let mut at = self.home.clone();
        for _ in 0..20 {
            at = closure.newton(&at, &command).at;
            closure.linearise(&at, &command);
            if closure.residual.amax() < CLOSURE_ROUNDING * self.reach {
                self.unwind(&mut at);
                self.check_limits(&at)?;
                return Ok(at);
            }
        }
        Err(closure.why_not(&at, &command))
    }

    /// Takes back full turns that the search has made: of drives and of joints without a spring, to which they are nothing.
    fn unwind(&self, at: &mut Configuration) {
        let nearest = |value: f64, home: f64| value - ((value - home) / TAU).round() * TAU;
        for ((_, drive), rho) in self.drives().zip(&mut at.drives) {
            if drive.motion == Motion::Revolute {
                *rho = nearest(*rho, drive.home);
            }
        }
        for (chain, values) in self.chains.iter().zip(&mut at.passive) {
            for (joint, q) in chain.passive.iter().zip(values) {
                if joint.motion == Motion::Revolute && joint.stiffness == 0.0 {
                    *q = nearest(*q, joint.home);
                }
            }
        }
    }

    /// Whether a drive's travel or a passive joint is limited.
    pub(crate) fn has_limits(&self) -> bool {
        let drives = self.drives().any(|(_, drive)| drive.travel.is_some());
        drives || self.chains.iter().flat_map(|chain| &chain.passive).any(|joint| joint.limits.is_some())
    }

    /// Travel and joint limits at a configuration.
    pub(crate) fn check_limits(&self, at: &Configuration) -> Result<(), Unreachable> {
        for ((c, drive), &rho) in self.drives().zip(&at.drives) {
            if let Some((low, high)) = drive.travel
                && beyond(rho, low, high) > 0.0
            {
                let (unit, scale) = user_unit(drive.motion);
                return Err(Unreachable::Travel {
                    chain: self.chains[c].name.clone(),
                    drive: drive.name.clone(),
                    value: rho * scale,
                    low: low * scale,
                    high: high * scale,
                    unit: unit.into(),
                });
            }
        }
        for (chain, values) in self.chains.iter().zip(&at.passive) {
            for (joint, &q) in chain.passive.iter().zip(values) {
                if let Some((low, high)) = joint.limits
                    && beyond(q, low, high) > 0.0
                {
                    let (unit, scale) = user_unit(joint.motion);
                    return Err(Unreachable::JointLimit {
                        chain: chain.name.clone(),
                        joint: joint.name.clone(),
                        value: q * scale,
                        low: low * scale,
                        high: high * scale,
                        unit: unit.into(),
                    });
                }
            }
        }
        Ok(())
    }

    /// How far the drive or joint farthest beyond its limits is beyond them, mm or degrees; 0 within.
    pub(crate) fn limit_excess(&self, at: &Configuration) -> f64 {
        let drives = self.drives().zip(&at.drives).map(|((_, drive), &rho)| (drive.travel, drive.motion, rho));
        let joints = self.chains.iter().zip(&at.passive).flat_map(|(chain, values)| {
            chain.passive.iter().zip(values).map(|(joint, &q)| (joint.limits, joint.motion, q))
        });
        let excess = |(limits, motion, value): (Option<(f64, f64)>, Motion, f64)| {
            limits.map_or(0.0, |(low, high)| beyond(value, low, high) * user_unit(motion).1)
        };
        drives.chain(joints).map(excess).fold(0.0, f64::max)
    }

    /// Adds to `shares` where each limited drive and joint stands in its range: −1 at the lower end and 1 at the upper one,
    /// as [`Machine::check_limits`] takes them.
    pub(crate) fn limit_shares(&self, at: &Configuration, shares: &mut Vec<f64>) {
        let drives = self.drives().zip(&at.drives).map(|((_, drive), &rho)| (drive.travel, rho));
        let joints = self
            .chains
            .iter()
            .zip(&at.passive)
            .flat_map(|(chain, values)| chain.passive.iter().zip(values).map(|(joint, &q)| (joint.limits, q)));
        let limited = drives.chain(joints).filter_map(|(limits, value)| limits.map(|limits| (limits, value)));
        shares.extend(limited.map(|((low, high), value)| {
            let half = 0.5 * (high - low) + rounding(low, high);
            (value - 0.5 * (low + high)) / half
        }));
    }

    /// Closure Jacobian at `at`: `6m` rows (mm, rad × reach), columns twist of P, drives, passive joints.
    pub(super) fn closure_jacobian(&self, at: &Configuration) -> DMatrix<f64> {
        let mut closure = Closure::new(self);
        closure.linearise(at, &Command::Drives(&at.drives));
        closure.jacobian.rows(0, 6 * self.chains.len()).into_owned()
    }
}

/// How far `value` is beyond the limits, in its unit; 0 within them and as far outside as rounding may put it.
fn beyond(value: f64, low: f64, high: f64) -> f64 {
    let excess = f64::max(low - value, value - high);
    if excess > rounding(low, high) { excess } else { 0.0 }
}

/// How far beyond its limits rounding may put a value.
fn rounding(low: f64, high: f64) -> f64 {
    LIMIT_ROUNDING * low.abs().max(high.abs()).max(high - low)
}

/// Unit in which a joint is shown, and the factor to it.
fn user_unit(motion: Motion) -> (&'static str, f64) {
    match motion {
        Motion::Prismatic => ("mm", 1.0),
        Motion::Revolute => ("deg", 180.0 / std::f64::consts::PI),
    }
}
