//! Machines beside a machine, from which derivatives by its parameters are taken.

use super::Unit;
use crate::{
    input::error::{Error, Result},
    machine::{Machine, refusal},
};

/// Steps of lengths, as shares of the value and of the machine's characteristic length; of angles, degrees; of all else and of backlash, as a
/// share of the value (of plain numbers, at least of 1).
const SHARE: f64 = 3e-5;
const SHARE_OF_REACH: f64 = 1e-6;
const DEGREES: f64 = 0.005;
/// Of forces and masses that are zero, in which a machine is linear.
const FROM_ZERO: f64 = 1.0;

/// A parameter of a machine, and the machines in which it is a step less and a step more.
#[derive(Debug, Clone)]
pub struct Variation {
    /// Its name.
    pub name: String,
    /// Its value, in `unit`.
    pub value: f64,
    /// The unit of value and step.
    pub unit: Unit,
    /// One step.
    pub step: f64,
    /// One step less, one more.
    pub machines: [Machine; 2],
}

impl Variation {
    /// Steps at which [`Variation::machines`] stand.
    pub const STEPS: [f64; 2] = [-1.0, 1.0];

    /// Weights of values at [`Variation::machines`] whose sum is the derivative per unit of the parameter, exact for polynomials of the second
    /// degree. At a kink (the torsion of a rectangle that is square), it is the mean of both sides.
    pub fn weights(&self) -> [f64; 2] {
        Self::STEPS.map(|steps| steps / (2.0 * self.step))
    }
}

impl Machine {
    /// Variations of the parameters called `names`: for each, the machines in which it is a step less and a step more.
    ///
    /// # Errors
    /// A name that is unknown or given twice, a value that is unknown, or one that cannot be varied: it stands at the end of what is
    /// allowed, other numbers hang on it (components of an axis), or is zero where nothing says how large a step is.
    pub fn variations<N: AsRef<str>>(&self, names: &[N]) -> Result<Vec<Variation>> {
        let mut variations: Vec<Variation> = Vec::new();
        for name in names {
            let name = name.as_ref();
            if variations.iter().any(|other| other.name == name) {
                return Err(refusal(name, "is named twice".into()));
            }
            variations.push(self.variation(name)?);
        }
        Ok(variations)
    }

    /// Variation of one parameter by a step that suits its unit and value.
    fn variation(&self, name: &str) -> Result<Variation> {
        let parameter = self.parameter(name)?;
        let (unit, Some(value)) = (parameter.unit, parameter.value) else {
            return Err(refusal(name, "must have a value to begin with, but the machine file says \"unknown\"".into()));
        };
        let step = match unit {
            _ if name.ends_with(".backlash") => SHARE * value,
            Unit::MM => (SHARE * value.abs()).max(SHARE_OF_REACH * self.characteristic_length),
            Unit::DEG => DEGREES,
            Unit::ONE => SHARE * value.abs().max(1.0),
            Unit::N | Unit::NMM | Unit::KG | Unit::M_PER_S2 if value == 0.0 => FROM_ZERO,
            _ if value == 0.0 => {
                let problem =
                    format!("is 0 {unit}, from where no step is small; expected another value than 0 to begin with");
                return Err(refusal(name, problem));
            }
            _ => SHARE * value.abs(),
        };
        let not_alone = |error: Error| refusal(name, format!("cannot be varied alone: {error}"));
        let at = |steps: f64| self.with_parameters(&[(name, value + steps * step)]).map_err(not_alone);
        let [less, more] = Variation::STEPS;
        Ok(Variation { name: name.into(), value, unit, step, machines: [at(less)?, at(more)?] })
    }
}
