//! A rigid configuration in each lane.

use super::{
    Configuration,
    equations::{mm_per_unit, move_platform},
};
use crate::{
    lanes::{Frame, Real, Vec3, pairs},
    machine::{Machine, Motion},
    spatial::Pose,
};

/// A configuration in each lane.
#[derive(Debug, Clone)]
pub(super) struct LaneConfiguration<R> {
    pub platform: Frame<R>,
    pub drives: Vec<R>,
    pub passive: Vec<Vec<R>>,
}

impl<R: Real> LaneConfiguration<R> {
    /// P at home, drives and joints at zero, in all lanes.
    pub fn new(machine: &Machine) -> Self {
        Self {
            platform: Frame::splat(&machine.home.pose),
            drives: vec![R::zero(); machine.drive_count()],
            passive: machine.chains.iter().map(|chain| vec![R::zero(); chain.passive.len()]).collect(),
        }
    }

    /// Sets `lane` to the configuration `from`.
    pub fn set_lane(&mut self, lane: usize, from: &Configuration) {
        set_lane_pose(&mut self.platform, lane, &from.pose);
        set_lane_values(&mut self.drives, lane, &from.drives);
        for (numbers, from) in pairs(&mut self.passive, &from.passive) {
            set_lane_values(numbers, lane, from);
        }
    }

    /// The configuration in `lane`.
    #[cfg(target_arch = "x86_64")]
    pub fn lane(&self, lane: usize) -> Configuration {
        let numbers = |row: &Vec<R>| row.iter().map(|number| number.lane(lane)).collect();
        Configuration {
            pose: self.platform.lane(lane),
            drives: numbers(&self.drives),
            passive: self.passive.iter().map(numbers).collect(),
        }
    }

    /// Moves by `step`, mm: the twist of P, the drives, the passive joints, whose kinds are `motions`.
    #[inline(always)]
    pub fn advance(&mut self, machine: &Machine, mut motions: &[Motion], mut step: &[R], mask: R::Mask) {
        let LaneConfiguration { platform, drives, passive } = self;
        let next = move_platform(platform, step, machine.characteristic_length);
        select_frame(platform, &next, mask);
        step = &step[6..];
        for values in std::iter::once(drives).chain(passive) {
            advance(machine, values, motions, step, mask);
            (motions, step) = (&motions[values.len()..], &step[values.len()..]);
        }
    }

    /// Copies the lanes of `mask` from `from`, of the same machine.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    pub fn copy_lanes(&mut self, from: &Self, mask: R::Mask) {
        select_frame(&mut self.platform, &from.platform, mask);
        let numbers = self.drives.iter_mut().chain(self.passive.iter_mut().flatten());
        for (number, from) in pairs(numbers, from.drives.iter().chain(from.passive.iter().flatten())) {
            *number = R::select(mask, *from, *number);
        }
    }
}

/// Copies the lanes of `mask` from one frame to another.
#[inline(always)]
fn select_frame<R: Real>(to: &mut Frame<R>, from: &Frame<R>, mask: R::Mask) {
    for (axis, from) in pairs(&mut to.axes, from.axes) {
        *axis = Vec3::select(mask, from, *axis);
    }
    to.origin = Vec3::select(mask, from.origin, to.origin);
}

/// Sets `lane` of `frame` to `pose`.
pub(super) fn set_lane_pose<R: Real>(frame: &mut Frame<R>, lane: usize, pose: &Pose) {
    for (j, axis) in frame.axes.iter_mut().enumerate() {
        for (i, number) in axis.0.iter_mut().enumerate() {
            number.set_lane(lane, pose.rotation[(i, j)]);
        }
    }
    for (i, number) in frame.origin.0.iter_mut().enumerate() {
        number.set_lane(lane, pose.translation[i]);
    }
}

/// Sets `lane` of `numbers` to the values `from`.
fn set_lane_values<R: Real>(numbers: &mut [R], lane: usize, from: &[f64]) {
    for (number, &value) in pairs(numbers, from) {
        number.set_lane(lane, value);
    }
}

/// Adds `steps`, mm, to the values of joints in the lanes of `mask`.
#[inline(always)]
fn advance<R: Real>(machine: &Machine, values: &mut [R], motions: &[Motion], steps: &[R], mask: R::Mask) {
    for (value, (&motion, &step)) in pairs(values, pairs(motions, steps)) {
        *value = R::select(mask, *value + step / R::splat(mm_per_unit(machine, motion)), *value);
    }
}
