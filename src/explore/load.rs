//! The load on the tool, as a page asks for it.

use serde::Deserialize;

use crate::{
    input::{
        check::LARGEST,
        error::{Error, Result},
    },
    inspect::point::PointLoad,
    process::{ForceLaw, MillingForce},
    spatial::Wrench,
};

/// Step of the tool angle over a turn, degrees.
const TURN_STEP_DEG: u16 = 10;

/// A load on the tool.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LoadAsked {
    /// At P in axes of O: N and N·mm.
    Wrench([f64; 6]),
    /// The milling force on the tool tip.
    Milling {
        /// N.
        radial: f64,
        /// N.
        tangential: f64,
        /// N.
        axial: f64,
        /// How it turns with φ.
        law: ForceLaw,
        /// φ; of a map, none means a whole turn.
        phi_deg: Option<f64>,
    },
}

impl LoadAsked {
    /// The load at one tool angle.
    ///
    /// # Errors
    /// A value that is no number of a load, or no tool angle.
    pub(super) fn one(&self) -> Result<PointLoad> {
        match self.all()?.as_slice() {
            [one] => Ok(*one),
            _ => Err(refused("phi_deg: missing: expected the tool angle in degrees".into())),
        }
    }

    /// The load at each tool angle that is asked for.
    ///
    /// # Errors
    /// A value that is no number of a load.
    pub(super) fn all(&self) -> Result<Vec<PointLoad>> {
        match *self {
            Self::Wrench(values) => {
                check(&values)?;
                Ok(vec![PointLoad::Wrench(Wrench::new(values))])
            }
            Self::Milling { radial, tangential, axial, law, phi_deg } => {
                check(&[radial, tangential, axial, phi_deg.unwrap_or(0.0)])?;
                let force = MillingForce { radial, tangential, axial, law };
                let at = |degrees: f64| PointLoad::Milling(force, degrees.to_radians());
                let turn = (0..360).step_by(TURN_STEP_DEG.into()).map(|degrees: u16| at(degrees.into()));
                Ok(phi_deg.map_or_else(|| turn.collect(), |phi| vec![at(phi)]))
            }
        }
    }
}

fn check(values: &[f64]) -> Result<()> {
    match values.iter().find(|value| value.is_nan() || value.abs() > LARGEST) {
        Some(value) => Err(refused(format!("expected numbers up to {LARGEST:e}, got {value}"))),
        None => Ok(()),
    }
}

fn refused(problem: String) -> Error {
    Error::Argument { argument: "load".into(), problem }
}
