//! Play of the drives at a point of a path: to which side each is pressed, how far that moves the tool, and what stays open.
//!
//! A joint that its drive force presses to one side of its backlash stands that far beside its spring, as it would by another command: the
//! engine solves the machine at the moved drives, nothing is linearised. What was there when the machine was calibrated is in its zero: under
//! weight, a drive is where it is expected on the side to which weight presses it, and off by the whole play on the other. A command takes the
//! play back by the opposite motion of the drives.

use nalgebra::{DVector, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use super::{along_path::PathCase, settings};
use crate::{
    FOR_PAGES,
    compensation::{Compensation, CompensationStatus, Session, TaskPoint, simulate_drives},
    machine::{Configuration, Machine, PositionedMachine, Unreachable, ZeroState},
    spatial::{Pose, Wrench},
    statics::{Scratch, State, equilibrium, flank_commands, has_play, loaded_flanks, open_play},
};

/// Play of the drives at a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointPlay {
    /// Side of its backlash to which each drive is pressed, machine order: 1 the way its joint grows, −1 the other way, 0 where it is open.
    pub sides: Vec<i8>,
    /// Motion of the compensated point by the play of drives that are pressed to a side, O axes, mm; to first order where the command takes it back.
    pub seated_mm: Vector3<f64>,
    /// Half the interval in which open play and static friction leave the tool tip, O axes, mm; first order, part of no error.
    pub open_mm: Vector3<f64>,
    /// Drives that are pressed to another side than when they were pressed last along the path, machine order.
    #[serde(skip)]
    pub reversed: Vec<usize>,
}

/// Finds where drives change their side along a path.
#[derive(Debug, Default)]
pub(crate) struct Reversals {
    /// Side to which each drive was pressed last.
    sides: Vec<i8>,
}

impl Reversals {
    /// Sets the reversed drives at the next point of the path.
    pub fn note(&mut self, play: Option<&mut PointPlay>) {
        let Some(PointPlay { sides, reversed, .. }) = play else { return };
        self.sides.resize(sides.len(), 0);
        for (drive, (last, side)) in self.sides.iter_mut().zip(sides).enumerate().filter(|(_, (_, side))| **side != 0) {
            if *last == -*side {
                reversed.push(drive);
            }
            *last = *side;
        }
    }
}

/// A point being solved, at which the nominal machine is tracked to `at`.
pub(crate) struct PlayedPoint<'a> {
    pub case: &'a PathCase<'a>,
    pub task: &'a TaskPoint,
    pub at: &'a Configuration,
    /// Whether the command is given, so that play moves the tool; else it was computed, and takes the play back.
    pub is_given: bool,
}

impl PlayedPoint<'_> {
    /// Adds the play of the drives to what was `found` without, with the `target` that is commanded. `session` is at that equilibrium. `None`
    /// where no drive has play, joints do not follow from drives one by one, or the machine is not there with its play.
    pub fn add(&self, session: &mut Session, found: &mut Compensation, target: &mut Option<Pose>) -> Option<PointPlay> {
        let machine = self.case.actual;
        // The engine of pages is small, and has no room for it.
        if FOR_PAGES || !self.case.play || !has_play(machine) || found.outcome.is_none() {
            return None;
        }
        let calibrated = sides_as_calibrated(self.case.nominal, self.case.unloaded, self.at);
        let offsets_of = |sides: &[i8]| flank_offsets(machine, sides, &calibrated);
        let mut sides = loaded_flanks(machine, session.state());
        let mut offsets = offsets_of(&sides)?;
        let bare_error = found.position_error;
        let mut changes = vec![0; sides.len()];
        let drives = found.drives.clone();
        let mut goes_on = self.is_given && offsets.iter().any(|offset| *offset != 0.0);
        while goes_on {
            self.solve(session, found, &drives, &offsets);
            goes_on = false;
            for ((side, now), changes) in
                sides.iter_mut().zip(loaded_flanks(machine, session.state())).zip(&mut changes)
            {
                if *side != now && *changes < 2 {
                    // Pressed by what the others do, or held by none of its sides.
                    let becomes_pressed = *side == 0 && *changes == 0;
                    (*side, *changes) = if becomes_pressed { (now, 1) } else { (0, 2) };
                    goes_on = found.outcome.is_some();
                }
            }
            offsets = offsets_of(&sides)?;
        }
        let mut seated_mm = found.position_error - bare_error;
        if !self.is_given && offsets.iter().any(|offset| *offset != 0.0) {
            let outcome = found.outcome.as_ref()?;
            let twist = &outcome.drive_sensitivity * DVector::from_column_slice(&offsets);
            let lever = session.state().pose.rotation * self.task.offset(self.case.nominal);
            let angular: Vector3<f64> = twist.fixed_rows::<3>(3).into();
            seated_mm = twist.fixed_rows::<3>(0) + angular.cross(&lever);
            if let Err(reason) = self.take_back(session, found, target, &offsets) {
                *found = session.refused(self.task, CompensationStatus::Unreachable(reason));
            }
        }
        let outcome = found.outcome.as_ref();
        *target = target.filter(|_| outcome.is_some());
        let open_mm = open_play(machine, &session.state().pose, &outcome?.drive_sensitivity, &sides)?;
        Some(PointPlay { sides, seated_mm, open_mm, reversed: Vec::new() })
    }

    /// Solves the machine commanded to `drives`, each standing its entry of `offsets` beside, mm or rad, and puts that in place of what was `found`.
    fn solve(&self, session: &mut Session, found: &mut Compensation, drives: &[f64], offsets: &[f64]) {
        let next = simulate_drives(session, self.task, &sums(drives, offsets, 1.0));
        let status = if next.outcome.is_some() { found.status.clone() } else { next.status.clone() };
        *found = Compensation { drives: drives.to_vec(), history: std::mem::take(&mut found.history), status, ..next };
    }

    /// Moves the command `found` so that the tool is, with drives that stand their entry of `offsets` (mm, rad) beside, where it was without.
    fn take_back(
        &self,
        session: &mut Session,
        found: &mut Compensation,
        target: &mut Option<Pose>,
        offsets: &[f64],
    ) -> Result<(), Unreachable> {
        let PlayedPoint { case, task, .. } = *self;
        // Any motion of the drives can be commanded where all coordinates that they control are compensated, one for each drive.
        let counts = [case.nominal.controls.len(), case.nominal.drive_count()];
        if case.nominal.locked.is_empty() && counts == [task.coordinates(case.nominal).count(); 2] {
            let drives = sums(&found.drives, offsets, -1.0);
            let at = case.nominal.forward_kinematics_from(session.command(), &drives)?;
            case.nominal.check_limits(&at)?;
            (found.drives, *target) = (drives, Some(at.pose));
            return Ok(());
        }
        // Only part of the pose follows the correction, so that the drives cannot simply go back.
        let mut nominal = PositionedMachine::new(case.nominal);
        nominal.move_to(task.external)?;
        let (Some(start), Ok(wanted)) = (*target, session.with_wanted_pose(task)) else {
            let drives = found.drives.clone();
            self.solve(session, found, &drives, offsets);
            return Ok(());
        };
        let error_at = |session: &Session| wanted.task_error(&nominal, &session.state().pose).error;
        let (before, mut shift, mut near) = (error_at(session), Vector6::zeros(), session.command().clone());
        for _ in 0..MAX_SHIFTS {
            let pose = TaskPoint { pose: start, ..wanted }.shifted_pose(&nominal, &shift);
            near = nominal.inverse_kinematics_from(&near, &pose)?;
            nominal.check_limits(&near)?;
            self.solve(session, found, &near.drives, offsets);
            *target = Some(pose);
            let error = error_at(session) - before;
            if found.outcome.is_none() || error.norm() <= settings().tolerance_mm(&nominal) {
                break;
            }
            shift -= error;
        }
        Ok(())
    }
}

/// Sides to which the drives of the `unloaded` machine were pressed where `nominal` was calibrated: under its weight at `here` or at home, or nowhere.
pub(crate) fn sides_as_calibrated(nominal: &Machine, unloaded: &Machine, here: &Configuration) -> Vec<i8> {
    let at = match nominal.zeroed {
        ZeroState::AtRest if unloaded.own_load_text().is_some() => here,
        ZeroState::AtHome if unloaded.own_load_text().is_some() => &nominal.home,
        _ => return vec![0; unloaded.drive_count()],
    };
    let (mut state, mut scratch) = (State::rigid(nominal, at), Scratch::new(unloaded));
    // Without an equilibrium here the point would have failed before.
    equilibrium(unloaded, &at.drives, &Wrench::zero(), &mut state, &mut scratch, &settings().equilibrium);
    loaded_flanks(unloaded, &state)
}

/// Changes of the commands, mm or rad, by which joints that are pressed to `sides` stand beside where they were when they were `calibrated`; `None` where
/// joints do not follow from drives one by one.
pub(crate) fn flank_offsets(machine: &Machine, sides: &[i8], calibrated: &[i8]) -> Option<Vec<f64>> {
    let from: Vec<i8> = sides.iter().zip(calibrated).map(|(side, before)| side - before).collect();
    flank_commands(machine, &from)
}

/// Most shifts of a target, each of which leaves about a hundredth of the error.
const MAX_SHIFTS: usize = 10;

/// Returns `drives` with `factor` times `offsets` added.
fn sums(drives: &[f64], offsets: &[f64], factor: f64) -> Vec<f64> {
    drives.iter().zip(offsets).map(|(drive, offset)| drive + factor * offset).collect()
}
