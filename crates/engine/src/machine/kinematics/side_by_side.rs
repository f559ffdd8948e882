//! Rigid configurations near known ones, as many at a time as the processor's vector registers hold.

use super::Configuration;
#[cfg(target_arch = "x86_64")]
use super::lane_newton::{LaneNewton, Wanted};
#[cfg(target_arch = "x86_64")]
use crate::lanes::{F64x4, F64x8, Real};
use crate::{lanes::Level, machine::Machine, spatial::Pose};

/// Storage for one machine.
#[derive(Debug, Clone)]
pub struct SideBySide {
    machine: Machine,
    lanes: Lanes,
}

#[derive(Debug, Clone)]
enum Lanes {
    /// All is left to the scalar search.
    None,
    #[cfg(target_arch = "x86_64")]
    Four(Box<LaneNewton<F64x4>>),
    #[cfg(target_arch = "x86_64")]
    Eight(Box<LaneNewton<F64x8>>),
}

impl SideBySide {
    /// For `machine`, with the widest registers of this processor.
    pub fn new(machine: &Machine) -> Self {
        Self::at_level(machine, Level::best())
    }

    /// For `machine` at `level`, or one at a time where this processor does not have it.
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

    /// [`Machine::inverse_kinematics_from`] of each start and target, to the last bit; `None` is left to it.
    pub fn inverse_kinematics(&mut self, asked: &[(&Configuration, Pose)]) -> Vec<Option<Configuration>> {
        #[cfg(target_arch = "x86_64")]
        {
            let wanted: Vec<_> = asked.iter().map(|(start, target)| (*start, Wanted::Task(target))).collect();
            let found = self.solve(&wanted).into_iter().zip(asked);
            let within = |at: Configuration, target: &Pose| self.machine.within_limits(at, target).ok();
            found.map(|(at, (_, target))| within(at?, target)).collect()
        }
        #[cfg(not(target_arch = "x86_64"))]
        vec![None; asked.len()]
    }

    /// [`Machine::forward_kinematics_from`] of each start and drives (mm, rad), to the last bit; `None` is left to it.
    pub fn forward_kinematics(&mut self, asked: &[(&Configuration, &[f64])]) -> Vec<Option<Configuration>> {
        #[cfg(target_arch = "x86_64")]
        {
            let wanted: Vec<_> = asked.iter().map(|(start, drives)| (*start, Wanted::Drives(drives))).collect();
            self.solve(&wanted)
        }
        #[cfg(not(target_arch = "x86_64"))]
        vec![None; asked.len()]
    }

    #[cfg(target_arch = "x86_64")]
    fn solve(&mut self, asked: &[(&Configuration, Wanted<'_>)]) -> Vec<Option<Configuration>> {
        fn in_lanes<R: Real>(
            newton: &mut LaneNewton<R>,
            machine: &Machine,
            asked: &[(&Configuration, Wanted<'_>)],
        ) -> Vec<Option<Configuration>> {
            asked.chunks(R::LANES).flat_map(|asked| newton.solve(machine, asked)).collect()
        }
        // One alone is found as quickly without lanes.
        match &mut self.lanes {
            Lanes::Eight(newton) if asked.len() > 1 => in_lanes(newton, &self.machine, asked),
            Lanes::Four(newton) if asked.len() > 1 => in_lanes(newton, &self.machine, asked),
            _ => vec![None; asked.len()],
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::machine::catalogue;

    /// Poses about home: near ones that lanes find, and one far beyond reach.
    fn targets(machine: &Machine) -> Vec<Pose> {
        let home = machine.home.pose;
        let way = |k: usize| {
            let k = k as f64;
            Vector3::new((1.3 * k).sin(), (0.7 * k).cos() - 1.0, (2.1 * k).sin()) * (0.02 * machine.reach)
        };
        let near = (0..19).map(|k| machine.pose_at(machine.as_controlled(home.translation + way(k))));
        near.chain([machine.pose_at(home.translation + Vector3::repeat(10.0 * machine.reach))]).collect()
    }

    fn assert_found(
        machine: &Machine,
        found: &[Option<Configuration>],
        alone: impl Fn(usize) -> Option<Configuration>,
    ) {
        for (k, at) in found.iter().enumerate() {
            if at.is_some() {
                assert_eq!(*at, alone(k), "{}, {k}", machine.name);
            }
        }
        assert!(found.iter().flatten().count() >= 16, "{}: {found:?}", machine.name);
    }

    #[test]
    fn lanes_find_what_is_found_alone() {
        for name in catalogue::names() {
            let machine = Machine::named(name).unwrap();
            let targets = targets(&machine);
            for level in Level::available().into_iter().filter(|level| *level != Level::One) {
                let mut lanes = SideBySide::at_level(&machine, level);
                let asked: Vec<_> = targets.iter().map(|target| (&machine.home, *target)).collect();
                let found = lanes.inverse_kinematics(&asked);
                if machine.redundancy > 0 {
                    assert!(found.iter().all(Option::is_none));
                    continue;
                }
                assert_found(&machine, &found, |k| machine.inverse_kinematics_from(&machine.home, &targets[k]).ok());
                let drives: Vec<Vec<f64>> = found.iter().flatten().map(|at| at.drives.clone()).collect();
                let asked: Vec<_> = drives.iter().map(|drives| (&machine.home, drives.as_slice())).collect();
                let back = lanes.forward_kinematics(&asked);
                assert_found(&machine, &back, |k| machine.forward_kinematics_from(&machine.home, &drives[k]).ok());
            }
        }
    }
}
