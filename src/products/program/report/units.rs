//! Units of limits of slides and of hinges.

use crate::{
    compensation::{LimitKind, Price},
    machine::{Machine, Motion},
};

fn motion_of(machine: &Machine, drive: usize) -> Motion {
    machine.drives().nth(drive).map_or(Motion::Prismatic, |(_, drive)| drive.motion)
}

pub(super) fn limit_unit(machine: &Machine, kind: LimitKind, drive: usize) -> &'static str {
    let motion = motion_of(machine, drive);
    if kind == LimitKind::Force { motion.force_unit() } else { motion.position_unit() }
}

pub(super) fn shown_limit_unit(machine: &Machine, kind: LimitKind, drive: usize) -> &'static str {
    let motion = motion_of(machine, drive);
    if kind == LimitKind::Force { motion.shown_force_unit() } else { motion.shown_position_unit() }
}

/// By how much the error would fall, mm, per unit of the limit: mm, degree, N or N·mm.
pub(super) fn shown_price(machine: &Machine, price: &Price) -> f64 {
    if price.kind == LimitKind::Force { price.price } else { motion_of(machine, price.drive).from_shown(price.price) }
}
