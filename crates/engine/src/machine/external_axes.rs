//! External axes: drives that a path commands point by point, a rail before an arm or those under a workpiece;
//! and the carrier of a workpiece touched by the tool.

use nalgebra::Vector3;

use super::{Configuration, Drive, Machine, kinematics::Unreachable};
use crate::spatial::Pose;

/// Where the external axes of a machine stand, mm or rad: the drives locked, as in [`Model::locked`](super::Model::locked), then those of its
/// workpiece carrier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExternalAxes([f64; ExternalAxes::MOST]);

impl ExternalAxes {
    /// The most axes that a path commands.
    pub const MOST: usize = 6;

    /// Has axis `index` stand at `position`, mm or rad.
    ///
    /// # Panics
    /// There are no more than [`ExternalAxes::MOST`].
    pub fn set(&mut self, index: usize, position: f64) {
        self.0[index] = position;
    }
}

/// A machine that stands with its external axes where tasks have them: made, each time, of the machine as it came, so that it does
/// not depend on where it stood before.
#[derive(Debug, Clone)]
pub struct Standing {
    original: Machine,
    now: Machine,
    axes: ExternalAxes,
}

impl Standing {
    /// `machine` as it comes.
    pub fn new(machine: &Machine) -> Self {
        Self { original: machine.clone(), now: machine.clone(), axes: machine.external_axes() }
    }

    /// The machine as it came.
    pub fn original(&self) -> &Machine {
        &self.original
    }

    /// Moves the external axes to `axes`, or to where they came with. Whether they have moved.
    ///
    /// # Errors
    /// As [`Machine::standing`]; the machine then stands where it did.
    pub fn move_to(&mut self, axes: Option<ExternalAxes>) -> Result<bool, Unreachable> {
        let axes = axes.unwrap_or_else(|| self.original.external_axes());
        if axes == self.axes {
            return Ok(false);
        }
        self.now = self.original.standing(&axes)?;
        self.axes = axes;
        Ok(true)
    }
}

impl std::ops::Deref for Standing {
    type Target = Machine;

    fn deref(&self) -> &Machine {
        &self.now
    }
}

impl Machine {
    /// How many external axes there are.
    pub fn external_axis_count(&self) -> usize {
        self.locked.len() + self.carrier.as_ref().map_or(0, |carrier| carrier.drive_count())
    }

    /// Where the external axes stand; the first [`ExternalAxes::MOST`] of them.
    pub fn external_axes(&self) -> ExternalAxes {
        let carried = self.carrier.iter().flat_map(|carrier| carrier.home.drives.iter().copied());
        let mut values = self.locked.iter().map(|&(_, value)| value).chain(carried);
        ExternalAxes(std::array::from_fn(|_| values.next().unwrap_or(0.0)))
    }

    /// The external axis with this label, and its place among all.
    pub fn external_axis(&self, label: &str) -> Option<(usize, &Drive)> {
        self.locked_drives()
            .into_iter()
            .enumerate()
            .find(|(_, (own, ..))| own == label)
            .map(|(i, (.., drive))| (i, drive))
    }

    /// Notes for words that a path moves these external axes, by label, between two positions as shown.
    pub fn note_moved(&mut self, axes: Vec<(String, [f64; 2])>) {
        self.written.along_path = axes;
    }

    /// This machine with its external axes at `axes`: home moves with a rail, as in [`Machine::with_locked_drives`].
    ///
    /// # Errors
    /// [`Unreachable::External`] if the other drives cannot meet the task there.
    pub fn standing(&self, axes: &ExternalAxes) -> Result<Machine, Unreachable> {
        let mut machine = self.carried(axes);
        let mut moves = false;
        for ((_, value), &there) in machine.locked.iter_mut().zip(&axes.0) {
            moves |= *value != there;
            *value = there;
        }
        if moves {
            machine.lock_at_home("external axes").map_err(|why| Unreachable::External { reason: why.to_string() })?;
        }
        Ok(machine)
    }

    /// This machine with the drives under its workpiece at `axes`, and its own as they are.
    pub fn carried(&self, axes: &ExternalAxes) -> Machine {
        let mut machine = self.clone();
        let own = self.locked.len();
        if let Some(carrier) = &self.carrier {
            let positions = &axes.0[own..own + carrier.drive_count()];
            if positions != carrier.home.drives {
                let home = carrier.serial_posture(positions);
                if let Some(carrier) = &mut machine.carrier {
                    carrier.home = home;
                }
            }
        }
        machine
    }

    /// Takes the point of this carrier that is at `place` (O, mm) without load for its P, on which wrenches then act, and gives the
    /// configuration it has there. Home stays that of the workpiece frame.
    pub fn touched_at(&mut self, place: Vector3<f64>) -> Configuration {
        let from_workpiece = self.home.pose.inverse().transform(place);
        for chain in &mut self.chains {
            chain.route.attachment.translation = from_workpiece;
        }
        Configuration { pose: Pose { translation: place, ..self.home.pose }, ..self.home.clone() }
    }
}
