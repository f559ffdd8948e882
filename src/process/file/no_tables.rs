//! The tables that pages ignore: the program has checked them, and pages have the path as it was turned, fed and cut.

use serde::de::IgnoredAny;

use super::spec::{GcodeSpec, ProcessSpec};
use crate::{
    compensation::Target,
    input::{Folder, Inputs, check::Check, error::Result},
    machine::Machine,
    process::{Placement, Process, RedundancySettings, cutting::CuttingLaw, feed::FeedLimits, stock::StockRemoval},
    toolpath::{
        Sampling,
        gcode::{Rotary, RotaryColumn},
        robot::RobotOptions,
    },
};

/// The table `cell`.
pub(crate) mod cell {
    use std::sync::Arc;

    use super::*;

    pub(crate) type CellSpec = IgnoredAny;

    /// No bodies.
    #[derive(Debug)]
    pub enum ProcessCell {}

    /// Returns no bodies.
    pub(crate) fn cell(
        _: &ProcessSpec,
        _: Option<&StockRemoval>,
        _: &Machine,
        _: &Folder,
        _: &Check,
    ) -> Result<(Option<Arc<ProcessCell>>, Inputs)> {
        Ok(Default::default())
    }
}

/// The table `feed`.
pub(crate) mod feed {
    use super::*;

    pub(crate) type FeedSpec = IgnoredAny;

    /// Returns no limits.
    pub(crate) fn limits<'a>(
        _: &ProcessSpec,
        _: impl Iterator<Item = &'a CuttingLaw>,
        _: &Check,
    ) -> Result<Option<FeedLimits>> {
        Ok(None)
    }
}

/// The table `redundancy`.
pub(crate) mod redundancy {
    use super::*;

    pub(crate) type RedundancySpec = IgnoredAny;

    /// Returns the settings of tools that stay as programmed.
    pub(crate) fn settings(_: &RedundancySpec, _: &Machine, _: &Check) -> Result<RedundancySettings> {
        Ok(RedundancySettings::default())
    }
}

/// The table `robot_program`.
pub(crate) mod robot {
    use super::*;

    pub(crate) type RobotSpec = IgnoredAny;

    /// Returns what holds without the table.
    pub(crate) fn options(_: &RobotSpec, _: bool, _: &Check) -> Result<RobotOptions> {
        Ok(RobotOptions::default())
    }
}

/// The list `rotary`.
pub(crate) mod rotary {
    use super::*;

    pub(crate) type RotaryList = IgnoredAny;

    /// Returns no axes: pages get programs with rotary axes as points.
    pub(crate) fn rotary(
        _: &GcodeSpec,
        _: &Machine,
        _: &Placement,
        _: Target,
        _: &Check,
    ) -> Result<(Rotary, Vec<RotaryColumn>)> {
        Ok(Default::default())
    }
}

/// The tables `stock` and `tools`.
pub(crate) mod stock {
    use super::*;

    pub(crate) type StockSpec = IgnoredAny;
    pub(crate) type ToolSpec = IgnoredAny;

    /// Returns no stock.
    pub(crate) fn stock(_: &ProcessSpec, _: Sampling, _: &Folder, _: &Check) -> Result<(Option<StockRemoval>, Inputs)> {
        Ok(Default::default())
    }

    /// Returns none.
    pub(crate) fn natural_frequencies_hz(_: &ProcessSpec) -> &[f64] {
        &[]
    }

    /// Returns the process as it is.
    pub(crate) fn with_earlier(process: Process, _: Option<&StockSpec>, _: &Folder, _: &Check) -> Result<Process> {
        Ok(process)
    }
}
