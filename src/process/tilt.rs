//! Checks that a machine's tool can follow a tilted workpiece.

use crate::{
    input::{check::Check, error::Result},
    machine::{Coordinate, Machine},
};

/// Which of roll, pitch and yaw of a workpiece are, or may become, nonzero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TiltAngles {
    pub roll: bool,
    pub pitch: bool,
    pub yaw: bool,
}

impl TiltAngles {
    /// Refuses a tilt that needs a rotation `machine` does not control; `key` gives the key of an angle's name.
    ///
    /// Roll turns about x, pitch about y; a workpiece that is yawed as well turns about both for either.
    pub fn check(self, machine: &Machine, key: impl Fn(&str) -> Check) -> Result<()> {
        let controls = |axis: usize| machine.controls.contains(&Coordinate::Rotation(axis));
        for (name, about, is_turned) in [("roll_deg", 0, self.roll), ("pitch_deg", 1, self.pitch)] {
            let missing = [about, 1 - about].into_iter().find(|&axis| (axis == about || self.yaw) && !controls(axis));
            if let (true, Some(axis)) = (is_turned, missing) {
                let problem = format!(
                    "machine {} does not control rotation about {}, so its tool cannot follow a workpiece tilted so: \
                     expected 0",
                    machine.name,
                    ["x", "y"][axis]
                );
                key(name).misfit(problem, ())?;
            }
        }
        Ok(())
    }
}
