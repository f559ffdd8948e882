//! The rigid machine whose command is sought together with the equilibrium of the loaded one, in each lane: its Newton step as a function
//! of the coordinates that the command may still move, while the others stay as commanded.

use super::{
    Configuration,
    equations::{Equations, LaneCommand, RigidState, mm_per_unit},
    lane_configuration::{LaneConfiguration, set_lane_pose},
    normal_step::{NormalStep, TWIST},
};
use crate::{
    lanes::{Frame, Real, pairs},
    machine::{Coordinate, Machine, Motion},
    spatial::Pose,
};

/// Motions of the drives, mm and rad: those that they make in any case, and those per mm of each coordinate that the command may move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DriveMotions<R> {
    pub fixed: [R; 6],
    /// By drives.
    pub per_coordinate: [[R; 6]; 6],
}

/// Damping of the step, as that of the inverse kinematics where it converges: an idle joint has a pivot then.
const LEAST_DAMPING: f64 = 1e-14;

/// Storage for one machine, whose translations the command moves.
#[derive(Debug, Clone)]
pub(crate) struct CommandStep<R> {
    equations: Equations<R>,
    normal_step: NormalStep<R>,
    at: LaneConfiguration<R>,
    /// The rotation commanded.
    target: Frame<R>,
    /// What moves are among the controlled coordinates.
    moves: Vec<usize>,
    /// Right-hand sides: the residual, then a unit of each coordinate that moves.
    rights: Vec<R>,
    /// Of each drive, then of each passive joint.
    motions: Vec<Motion>,
}

impl<R: Real> CommandStep<R> {
    /// Storage for `machine`, at no configuration yet.
    pub fn new(machine: &Machine) -> Self {
        let controls = machine.controls.iter().enumerate();
        let moves: Vec<usize> =
            controls.filter(|(_, control)| matches!(control, Coordinate::Translation(_))).map(|(row, _)| row).collect();
        let (closures, rows) = (6 * machine.closure_count(), 6 * machine.closure_count() + machine.controls.len());
        let mut rights = vec![R::zero(); (1 + moves.len()) * rows];
        for (i, &row) in moves.iter().enumerate() {
            rights[(1 + i) * rows + closures + row] = R::splat(-1.0);
        }
        Self {
            equations: Equations::new(machine),
            normal_step: NormalStep::new(machine, 1 + moves.len()),
            at: LaneConfiguration::new(machine),
            target: Frame::splat(&machine.home.pose),
            moves,
            rights,
            motions: super::closure::motions(machine).collect(),
        }
    }

    /// Number of controlled coordinates that the command may move: the translations.
    pub fn coordinate_count(&self) -> usize {
        self.moves.len()
    }

    /// Sets a lane to `start` with the drives at `drives` (mm, rad) and the commanded rotation to that of `target`.
    pub fn set_lane(&mut self, lane: usize, start: &Configuration, drives: &[f64], target: &Pose) {
        self.at.set_lane(lane, start);
        for (number, &value) in pairs(&mut self.at.drives, drives) {
            number.set_lane(lane, value);
        }
        set_lane_pose(&mut self.target, lane, target);
    }

    /// Linearises the machine where it stands; returns its largest error (mm), its drive motions and the lanes where these are determined.
    #[inline(always)]
    pub fn linearise(&mut self, machine: &Machine) -> (R, DriveMotions<R>, u8) {
        let LaneConfiguration { platform, drives, passive } = &self.at;
        self.equations.linearise(machine, &RigidState { platform, drives, passive }, &LaneCommand::Task(&self.target));
        let Equations { rows, unknowns, jacobian, residual, .. } = &self.equations;
        let closures = 6 * machine.closure_count();
        self.rights[..*rows].copy_from_slice(residual);
        for &row in &self.moves {
            self.rights[closures + row] = R::zero();
        }
        let mut error = R::zero();
        for entry in &self.rights[..*rows] {
            error = error.larger(entry.abs());
        }
        let (steps, good) = self.normal_step.solve(machine, jacobian, &self.rights, closures, R::splat(LEAST_DAMPING));
        let mut motions = DriveMotions { fixed: [R::zero(); 6], per_coordinate: [[R::zero(); 6]; 6] };
        for (drive, &motion) in self.motions[..self.at.drives.len()].iter().enumerate() {
            let length = R::splat(mm_per_unit(machine, motion));
            motions.fixed[drive] = steps[TWIST + drive] / length;
            for i in 0..self.moves.len() {
                motions.per_coordinate[drive][i] = steps[(1 + i) * unknowns + TWIST + drive] / length;
            }
        }
        (error, motions, good)
    }

    /// Takes the step in which the command moves by `coordinates`, mm, in the lanes of `mask`.
    #[inline(always)]
    pub fn advance(&mut self, machine: &Machine, coordinates: &[R; 6], mask: R::Mask) {
        let unknowns = self.equations.unknowns;
        let (step, others) = self.normal_step.steps.split_at_mut(unknowns);
        for (other, &coordinate) in others.chunks_exact(unknowns).zip(coordinates) {
            for (entry, &part) in pairs(&mut *step, other) {
                *entry += part * coordinate;
            }
        }
        self.at.advance(machine, &self.motions, step, mask);
    }

    /// Commanded position of P in a lane, O, mm.
    pub fn commanded_position(&self, lane: usize) -> nalgebra::Vector3<f64> {
        self.at.platform.lane(lane).translation
    }
}
