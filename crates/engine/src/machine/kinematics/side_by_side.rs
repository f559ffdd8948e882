//! Rigid kinematics in batches: as many configurations at a time as the processor's vector registers hold.

use super::Configuration;
#[cfg(target_arch = "x86_64")]
use super::{
    inverse::StraightLine,
    lane_newton::{LaneNewton, LaneWay},
};
#[cfg(target_arch = "x86_64")]
use crate::lanes::{F64x4, F64x8, Real};
use crate::{lanes::Level, machine::Machine, spatial::Pose};

/// Kinematics of one machine for many targets at once, in vector lanes.
#[derive(Debug, Clone)]
pub struct BatchKinematics {
    machine: Machine,
    lanes: Lanes,
}

/// Searches in as many lanes as there are.
#[derive(Debug, Clone)]
enum Lanes {
    /// All is left to the scalar search.
    None,
    #[cfg(target_arch = "x86_64")]
    Four(Box<LaneNewton<F64x4>>),
    #[cfg(target_arch = "x86_64")]
    Eight(Box<LaneNewton<F64x8>>),
}

impl BatchKinematics {
    /// Kinematics of `machine` with the widest registers of this processor.
    pub fn new(machine: &Machine) -> Self {
        Self::at_level(machine, Level::best())
    }

    /// Kinematics of `machine` at `level`, or one at a time where this processor does not have it.
    pub fn at_level(machine: &Machine, level: Level) -> Self {
        let lanes = match level {
            // Redundant drives are moved in another way.
            _ if machine.redundancy > 0 => Lanes::None,
            #[cfg(target_arch = "x86_64")]
            Level::Eight if level.is_available() => Lanes::Eight(Box::new(LaneNewton::new(machine))),
            #[cfg(target_arch = "x86_64")]
            Level::Four if level.is_available() => Lanes::Four(Box::new(LaneNewton::new(machine))),
            _ => Lanes::None,
        };
        Self { machine: machine.clone(), lanes }
    }

    /// Solves [`Machine::inverse_kinematics_from`] for each start and target, in order, to the last bit; `None`: not found in lanes.
    pub fn inverse_kinematics(&mut self, searches: &[(&Configuration, Pose)]) -> Vec<Option<Configuration>> {
        #[cfg(target_arch = "x86_64")]
        {
            let lines = searches.iter().map(|(start, target)| StraightLine::new(&start.pose, target));
            let lines: Vec<StraightLine> = lines.collect();
            let ways: Vec<_> =
                searches.iter().zip(&lines).map(|((start, _), line)| (*start, LaneWay::Task(line))).collect();
            let found = self.solve(&ways).into_iter().zip(searches);
            let within = |at: Configuration, target: &Pose| self.machine.adjust_to_limits(at, target).ok();
            found.map(|(at, (_, target))| within(at?, target)).collect()
        }
        #[cfg(not(target_arch = "x86_64"))]
        vec![None; searches.len()]
    }

    /// Solves [`Machine::forward_kinematics_from`] for each start and drives (mm, rad), to the last bit; `None`: not found in lanes.
    pub fn forward_kinematics(&mut self, commands: &[(&Configuration, &[f64])]) -> Vec<Option<Configuration>> {
        #[cfg(target_arch = "x86_64")]
        {
            let ways: Vec<_> = commands.iter().map(|(start, drives)| (*start, LaneWay::Drives(drives))).collect();
            self.solve(&ways)
        }
        #[cfg(not(target_arch = "x86_64"))]
        vec![None; commands.len()]
    }

    /// Searches in lanes from each start along its way; all `None` without lanes or for a single one.
    #[cfg(target_arch = "x86_64")]
    fn solve(&mut self, searches: &[(&Configuration, LaneWay<'_>)]) -> Vec<Option<Configuration>> {
        /// Searches in groups of as many as there are lanes.
        fn solve_in_lanes<R: Real>(
            newton: &mut LaneNewton<R>,
            machine: &Machine,
            searches: &[(&Configuration, LaneWay<'_>)],
        ) -> Vec<Option<Configuration>> {
            searches.chunks(R::LANES).flat_map(|searches| newton.solve(machine, searches)).collect()
        }
        // One alone is found as quickly without lanes.
        match &mut self.lanes {
            Lanes::Eight(newton) if searches.len() > 1 => solve_in_lanes(newton, &self.machine, searches),
            Lanes::Four(newton) if searches.len() > 1 => solve_in_lanes(newton, &self.machine, searches),
            _ => vec![None; searches.len()],
        }
    }
}
