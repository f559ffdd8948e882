//! Limits by which the feed of a program is chosen.

use crate::input::check::Check;

/// What a limit is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FeedQuantity {
    /// Size of the force on the tool, as its law gives it, N.
    Force,
    /// Mean torque about the axis of the spindle, N·m.
    Torque,
    /// That torque times the speed of the spindle, kW.
    Power,
    /// Distance of the tool from its path without compensation, mm.
    Deflection,
    /// The feed itself, mm/min.
    Feed,
}

impl FeedQuantity {
    /// All of them, in order.
    pub const ALL: [Self; 5] = [Self::Force, Self::Torque, Self::Power, Self::Deflection, Self::Feed];

    /// Returns the key of the limit.
    pub fn key(self) -> &'static str {
        ["max_force_N", "max_torque_Nm", "max_power_kW", "max_deflection_mm", "max_mm_per_min"][self as usize]
    }

    /// Returns its name.
    pub fn name(self) -> &'static str {
        ["force", "torque", "power", "deflection", "feed"][self as usize]
    }

    /// Returns its unit.
    pub fn unit(self) -> &'static str {
        ["N", "N·m", "kW", "mm", "mm/min"][self as usize]
    }
}

/// Limits of a program, in order of [`FeedQuantity::ALL`], and how much its feed may change.
#[derive(Debug, Clone)]
pub struct FeedLimits {
    /// The limits; one of the first four is given.
    pub most: [Option<f64>; 5],
    /// Least and largest feed, as shares of the programmed one: at most and at least 1.
    pub change: [f64; 2],
    /// Location of the table.
    pub check: Check,
}

impl FeedLimits {
    /// The quantities with a limit, and the limit.
    pub fn given(&self) -> impl Iterator<Item = (FeedQuantity, f64)> {
        FeedQuantity::ALL.into_iter().zip(self.most).filter_map(|(quantity, most)| Some((quantity, most?)))
    }
}
