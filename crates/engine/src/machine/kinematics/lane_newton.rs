//! The damped Newton iteration of the closure equations in lanes: one search per lane, each in its own steps from where it begins.
//!
//! A lane follows the scalar iteration and its steps bit by bit. One that may pass a singularity fails, and is left to the scalar search.

use std::array;

use super::{
    Configuration,
    between::{SingularityCheck, StepEnds},
    closure::motions,
    continuation::{MIN_STEP, Steps},
    equations::{Equations, LaneCommand, RigidState},
    inverse::StraightLine,
    lane_configuration::{LaneConfiguration, set_lane_pose},
    normal_step::NormalStep,
    search::{MAX_ITERATIONS, MAX_STEP_ROTATION, Search, SearchStatus},
    singularity::{Barriers, judged_commands},
};
use crate::{
    lanes::{Frame, MAX_LANES, Real, dot, pairs},
    machine::{Machine, Motion},
};

/// Way of the search in one lane.
#[derive(Clone, Copy)]
pub(super) enum LaneWay<'a> {
    /// The controlled task coordinates follow this line.
    Task(&'a StraightLine),
    /// The drives go straight from those of the start to these, mm or rad.
    Drives(&'a [f64]),
}

/// Newton searches in lanes, with their storage.
#[derive(Debug, Clone)]
pub(super) struct LaneNewton<R> {
    equations: Equations<R>,
    normal_step: NormalStep<R>,
    between: SingularityCheck<R>,
    /// The Jacobian where the search began.
    start_jacobian: Vec<R>,
    start: LaneConfiguration<R>,
    at: LaneConfiguration<R>,
    /// Goals of the searches: the poses, or the drives.
    target: Frame<R>,
    target_drives: Vec<R>,
    /// Motion of each drive, then of each passive joint.
    motions: Vec<Motion>,
}

impl<R: Real> LaneNewton<R> {
    /// Storage for searches of `machine`.
    pub fn new(machine: &Machine) -> Self {
        Self {
            equations: Equations::new(machine),
            normal_step: NormalStep::new(machine, 1),
            between: SingularityCheck::new(machine),
            start_jacobian: Vec::new(),
            start: LaneConfiguration::new(machine),
            at: LaneConfiguration::new(machine),
            target: Frame::splat(&machine.home.pose),
            target_drives: vec![R::zero(); machine.drive_count()],
            motions: motions(machine).collect(),
        }
    }

    /// Searches from each start along its way, at most [`Real::LANES`] ways of one kind; `None` where a way is not followed to its end.
    pub fn solve(&mut self, machine: &Machine, cases: &[(&Configuration, LaneWay<'_>)]) -> Vec<Option<Configuration>> {
        debug_assert!(cases.len() <= R::LANES);
        let Some(first) = cases.first() else { return Vec::new() };
        let is_task = matches!(first.1, LaneWay::Task(_));
        // Lanes to spare do what the first one does.
        let case_of = |lane: usize| cases.get(lane).unwrap_or(first);
        let mut steps: [Steps; MAX_LANES] = array::from_fn(|lane| {
            Steps::new(match &case_of(lane).1 {
                LaneWay::Task(line) => line.least_step(machine),
                LaneWay::Drives(..) => MIN_STEP,
            })
        });
        for lane in 0..R::LANES {
            self.start.set_lane(lane, case_of(lane).0);
        }
        let mut active = R::ALL;
        while active != 0 {
            for lane in active_lanes(active) {
                let s = steps[lane].next_end();
                match &case_of(lane).1 {
                    LaneWay::Task(line) => set_lane_pose(&mut self.target, lane, &line.pose(s)),
                    LaneWay::Drives(to) => {
                        let from = &case_of(lane).0.drives;
                        for (number, (&from, &to)) in pairs(&mut self.target_drives, pairs(from, *to)) {
                            number.set_lane(lane, from + (to - from) * s);
                        }
                    }
                }
            }
            let solved = self.search(machine, is_task, active);
            let regular = if solved == 0 { 0 } else { solved & self.regular_lanes(machine, is_task) };
            let mut unfinished = 0;
            for lane in active_lanes(active) {
                let is_doubtful = (solved & !regular) >> lane & 1 == 1;
                unfinished |= u8::from(!is_doubtful && steps[lane].advance_or_halve(regular >> lane & 1 == 1)) << lane;
            }
            R::vectorized(
                #[inline(always)]
                || self.start.copy_lanes(&self.at, R::mask_from_bits(regular)),
            );
            active = unfinished;
        }
        (0..cases.len()).map(|lane| steps[lane].is_complete().then(|| self.start.lane(lane))).collect()
    }

    /// Iterates in the lanes `active` from the start; returns those that converge near it.
    fn search(&mut self, machine: &Machine, is_task: bool, mut active: u8) -> u8 {
        let (mut searches, mut solved) = ([Search::new(); MAX_LANES], 0);
        R::vectorized(
            #[inline(always)]
            || self.at.copy_lanes(&self.start, R::mask_from_bits(R::ALL)),
        );
        for iteration in 0..MAX_ITERATIONS {
            let (error, turned) = self.linearise(machine, is_task);
            if iteration == 0 {
                self.start_jacobian.clone_from(&self.equations.jacobian);
            }
            let mut damping = R::zero();
            for lane in active_lanes(active) {
                let search = &mut searches[lane];
                let judged = search.judge(error.lane(lane), machine.characteristic_length);
                if judged == SearchStatus::Continue && !search.has_left_branch() {
                    damping.set_lane(lane, search.update_damping(error.lane(lane)));
                    continue;
                }
                active &= !(1 << lane);
                let is_near = !search.has_left_branch() && turned.lane(lane) < MAX_STEP_ROTATION;
                solved |= u8::from(judged == SearchStatus::Solved && is_near) << lane;
            }
            if active == 0 {
                break;
            }
            let (length, good) = self.step(machine, damping, active);
            active &= good;
            for lane in active_lanes(active) {
                searches[lane].record_step(length.lane(lane));
            }
        }
        solved
    }

    /// Linearises at the present configurations; returns the largest error, mm, and the largest rotation of a joint since the start, rad.
    fn linearise(&mut self, machine: &Machine, is_task: bool) -> (R, R) {
        R::vectorized(
            #[inline(always)]
            || {
                let LaneConfiguration { platform, drives, passive } = &self.at;
                let state = RigidState { platform, drives, passive };
                let command =
                    if is_task { LaneCommand::Task(&self.target) } else { LaneCommand::Drives(&self.target_drives) };
                self.equations.linearise(machine, &state, &command);
                let mut error = R::zero();
                for entry in &self.equations.residual {
                    error = error.larger(entry.abs());
                }
                let mut turned = largest_rotation(&self.motions, &self.start.drives, &self.at.drives);
                let mut first = self.at.drives.len();
                for (from, to) in pairs(&self.start.passive, &self.at.passive) {
                    turned = turned.larger(largest_rotation(&self.motions[first..], from, to));
                    first += from.len();
                }
                (error, turned)
            },
        )
    }

    /// Takes a step in the active lanes; returns its length, mm, and the lanes in which there is one.
    fn step(&mut self, machine: &Machine, damping: R, active: u8) -> (R, u8) {
        R::vectorized(
            #[inline(always)]
            || {
                let Equations { jacobian, residual, .. } = &self.equations;
                let closures = 6 * machine.closure_count();
                let (step, good) = self.normal_step.solve(machine, jacobian, residual, closures, damping);
                let length = dot(step, step).sqrt();
                let good = good & !R::mask_to_bits(length.is_nan()) & !length.lanes_greater(f64::MAX);
                self.at.advance(machine, &self.motions, step, R::mask_from_bits(active & good));
                (length, good)
            },
        )
    }

    /// Returns the lanes in which surely no singularity lies between start and end.
    fn regular_lanes(&mut self, machine: &Machine, is_task: bool) -> u8 {
        let barriers = if is_task { Barriers::All } else { Barriers::OfDrives };
        let (by_drives, by_task) = judged_commands(machine, barriers);
        if !by_drives && !by_task {
            return R::ALL;
        }
        R::vectorized(
            #[inline(always)]
            || {
                let ends = StepEnds {
                    jacobians: [&self.start_jacobian, &self.equations.jacobian],
                    rows: self.equations.rows,
                    platforms: [&self.start.platform, &self.at.platform],
                };
                self.between.regular_lanes(machine, &ends, by_drives, by_task)
            },
        )
    }
}

/// Largest rotation of a revolute joint between two configurations, rad.
#[inline(always)]
fn largest_rotation<R: Real>(motions: &[Motion], from: &[R], to: &[R]) -> R {
    let mut turned = R::zero();
    for (&motion, (&from, &to)) in pairs(motions, pairs(from, to)) {
        if motion == Motion::Revolute {
            turned = turned.larger((from - to).abs());
        }
    }
    turned
}

/// Indices of the lanes whose bits are set.
fn active_lanes(bits: u8) -> impl Iterator<Item = usize> {
    (0..MAX_LANES).filter(move |lane| bits >> lane & 1 == 1)
}
