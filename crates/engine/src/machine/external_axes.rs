//! External axes (drives that a path commands point by point), and the carrier of a workpiece touched by the tool.

use nalgebra::Vector3;

use super::{Configuration, Drive, Machine, kinematics::Unreachable};
use crate::spatial::{MAX_EXTERNAL_AXES, Pose};

/// Positions of a machine's external axes, mm or rad: its locked drives ([`Model::locked`](super::Model::locked)), then its carrier's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExternalAxes([f64; ExternalAxes::MOST]);

impl ExternalAxes {
    /// The most axes that a path commands.
    pub const MOST: usize = MAX_EXTERNAL_AXES;

    /// Sets axis `index` to `position`, mm or rad.
    ///
    /// # Panics
    /// There are no more than [`ExternalAxes::MOST`].
    pub fn set(&mut self, index: usize, position: f64) {
        self.0[index] = position;
    }
}

/// A machine with its external axes where tasks have them, derived each time from the original: where it stood before does not matter.
#[derive(Debug, Clone)]
pub struct PositionedMachine {
    original: Machine,
    current: Machine,
    axes: ExternalAxes,
}

impl PositionedMachine {
    /// Takes `machine` with its external axes as they are.
    pub fn new(machine: &Machine) -> Self {
        Self { original: machine.clone(), current: machine.clone(), axes: machine.external_axes() }
    }

    /// The machine as given to [`PositionedMachine::new`].
    pub fn original(&self) -> &Machine {
        &self.original
    }

    /// Moves the external axes to `axes`, or for `None` to those of the original machine; returns whether they have moved.
    ///
    /// # Errors
    /// As [`Machine::with_external_axes`]; the machine then stands where it did.
    pub fn move_to(&mut self, axes: Option<ExternalAxes>) -> Result<bool, Unreachable> {
        let axes = axes.unwrap_or_else(|| self.original.external_axes());
        if axes == self.axes {
            return Ok(false);
        }
        self.current = self.original.with_external_axes(&axes)?;
        self.axes = axes;
        Ok(true)
    }
}

impl std::ops::Deref for PositionedMachine {
    type Target = Machine;

    fn deref(&self) -> &Machine {
        &self.current
    }
}

impl Machine {
    /// Number of external axes: locked drives and the drives of the workpiece carrier.
    pub fn external_axis_count(&self) -> usize {
        self.locked.len() + self.carrier.as_ref().map_or(0, |carrier| carrier.drive_count())
    }

    /// Positions of the external axes; the first [`ExternalAxes::MOST`] of them.
    pub fn external_axes(&self) -> ExternalAxes {
        let carried = self.carrier.iter().flat_map(|carrier| carrier.home.drives.iter().copied());
        let mut values = self.locked.iter().map(|&(_, value)| value).chain(carried);
        ExternalAxes(std::array::from_fn(|_| values.next().unwrap_or(0.0)))
    }

    /// Index and drive of the external axis called `label`, as tables call its drive; `None` if there is none.
    pub fn external_axis(&self, label: &str) -> Option<(usize, &Drive)> {
        self.locked_drives()
            .into_iter()
            .enumerate()
            .find(|(_, (axis_label, ..))| axis_label == label)
            .map(|(i, (.., drive))| (i, drive))
    }

    /// Records, for messages, the external axes that a path moves, by label, and between which shown positions.
    pub fn record_path_axes(&mut self, axes: Vec<(String, [f64; 2])>) {
        self.definition.path_axes = axes;
    }

    /// This machine with its external axes at `axes`: home moves with a rail, as in [`Machine::with_locked_drives`].
    ///
    /// # Errors
    /// [`Unreachable::External`] if the other drives cannot meet the task there.
    pub fn with_external_axes(&self, axes: &ExternalAxes) -> Result<Machine, Unreachable> {
        let mut machine = self.with_carrier_axes(axes);
        let mut moves = false;
        for ((_, value), &position) in machine.locked.iter_mut().zip(&axes.0) {
            moves |= *value != position;
            *value = position;
        }
        if moves {
            machine
                .rehome_at_locked("external axes")
                .map_err(|why| Unreachable::External { reason: why.to_string() })?;
        }
        Ok(machine)
    }

    /// This machine with the drives of its workpiece carrier as in `axes`, and its own as they are.
    pub fn with_carrier_axes(&self, axes: &ExternalAxes) -> Machine {
        let mut machine = self.clone();
        let locked_count = self.locked.len();
        if let Some(carrier) = &self.carrier {
            let positions = &axes.0[locked_count..locked_count + carrier.drive_count()];
            if positions != carrier.home.drives {
                let home = carrier.serial_configuration(positions);
                if let Some(carrier) = &mut machine.carrier {
                    carrier.home = home;
                }
            }
        }
        machine
    }

    /// Moves P of this carrier to the point at `place` (O, mm, without load), where wrenches then act; returns the configuration there. Home stays.
    pub fn set_touch_point(&mut self, place: Vector3<f64>) -> Configuration {
        let from_workpiece = self.home.pose.inverse().transform(place);
        for chain in &mut self.chains {
            chain.route.attachment.translation = from_workpiece;
        }
        Configuration { pose: Pose { translation: place, ..self.home.pose }, ..self.home.clone() }
    }
}
