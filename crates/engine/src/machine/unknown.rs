//! Machine files with drives of unknown stiffness: their kinematics can be computed, their deflection not.

use std::fmt;

use serde::{
    Deserialize,
    de::{Deserializer, Unexpected, Visitor},
};

use super::{
    Branch, Machine, Parameter, resolve,
    spec::{ChainSpec, ElementSpec, MachineSpec},
};
use super::{catalogue, unknown_machine};
use crate::input::{
    error::{Error, Result},
    names::listed,
};

/// The word for a stiffness that is not known.
const UNKNOWN: &str = "unknown";
/// What stands for it where only geometry is asked for, N/mm or N·mm/rad.
const STAND_IN: f64 = 1.0;

/// Stiffness of a drive as written: a number, or the word "unknown".
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StiffnessSpec {
    /// In the unit of the key.
    Known(f64),
    /// Somebody has still to measure it or look it up.
    Unknown,
}

impl StiffnessSpec {
    /// The number, or a stand-in of 1 where it is unknown.
    pub(super) fn number(self) -> f64 {
        match self {
            StiffnessSpec::Known(number) => number,
            StiffnessSpec::Unknown => STAND_IN,
        }
    }
}

impl<'de> Deserialize<'de> for StiffnessSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(NumberOrUnknown)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for StiffnessSpec {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Stiffness".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "anyOf": [{ "type": "number", "exclusiveMinimum": 0 }, { "const": UNKNOWN }] })
    }
}

/// Reads a number or the word "unknown".
struct NumberOrUnknown;

impl Visitor<'_> for NumberOrUnknown {
    type Value = StiffnessSpec;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "a number or \"{UNKNOWN}\"")
    }

    fn visit_f64<E>(self, value: f64) -> std::result::Result<StiffnessSpec, E> {
        Ok(StiffnessSpec::Known(value))
    }

    #[allow(clippy::cast_precision_loss)]
    fn visit_i64<E>(self, value: i64) -> std::result::Result<StiffnessSpec, E> {
        Ok(StiffnessSpec::Known(value as f64))
    }

    #[allow(clippy::cast_precision_loss)]
    fn visit_u64<E>(self, value: u64) -> std::result::Result<StiffnessSpec, E> {
        Ok(StiffnessSpec::Known(value as f64))
    }

    fn visit_str<E: serde::de::Error>(self, value: &str) -> std::result::Result<StiffnessSpec, E> {
        if value == UNKNOWN {
            return Ok(StiffnessSpec::Unknown);
        }
        Err(E::invalid_value(Unexpected::Str(value), &self))
    }
}

/// A stiffness that a machine file calls unknown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownStiffness {
    /// Name of the drive.
    pub drive: String,
    /// Where the file calls it so, such as `chain[0].elements[1].revolute_drive.stiffness_Nmm_per_rad`.
    pub key: String,
}

/// A machine whose drives may have unknown stiffness: fit for kinematics, not for deflections.
#[derive(Debug, Clone)]
pub struct Geometry {
    origin: String,
    machine: Machine,
    unknown: Vec<UnknownStiffness>,
}

impl Geometry {
    /// Checks a machine given as TOML text; `origin` names it in error messages.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self> {
        let spec: MachineSpec = crate::input::toml_file::parse(text, origin)?;
        let unknown = unknown_stiffnesses(&spec);
        let machine = resolve::resolve_machine(spec, origin, text.into()).map_err(|error| error.in_toml(text))?;
        Ok(Self { origin: origin.into(), machine, unknown })
    }

    /// Parameters of the machine, see [`Machine::parameters`]; unknown ones have no value.
    pub fn parameters(&self) -> Vec<Parameter> {
        self.machine.parameters()
    }

    /// This geometry with other parameter values, see [`Machine::with_parameters`]; unknown stiffnesses may become known.
    pub fn with_parameters<N: AsRef<str>>(&self, values: &[(N, f64)]) -> Result<Self> {
        let machine = self.machine.with_parameters(values)?;
        Ok(Self { origin: self.origin.clone(), unknown: unknown_stiffnesses(machine.definition.spec()), machine })
    }

    /// This geometry on `branch`, see [`Machine::on_branch`].
    pub fn on_branch(self, branch: Branch) -> Result<Self> {
        Ok(Self { machine: self.machine.on_branch(branch)?, ..self })
    }

    /// The geometry of the built-in machine called `name`, or else of the file at this path.
    pub fn named_or_file(name: &str) -> Result<Self> {
        let file = std::path::Path::new(name);
        match catalogue::find(name) {
            Some(entry) => Self::from_toml(entry.toml, entry.name),
            None if file.extension().is_some() || file.exists() => {
                Self::from_toml(&crate::input::toml_file::read(file)?, name)
            }
            None => Err(unknown_machine(&format!("no built-in machine \"{name}\" and no file of this name"))),
        }
    }

    /// The machine for kinematics only: the stiffness of drives where it is unknown is a placeholder.
    pub fn kinematics(&self) -> &Machine {
        &self.machine
    }

    /// Drives whose stiffness is unknown.
    pub fn unknown(&self) -> &[UnknownStiffness] {
        &self.unknown
    }

    /// The machine for all computations; `Err` if the stiffness of a drive is unknown.
    pub fn machine(self) -> Result<Machine> {
        if self.unknown.is_empty() {
            return Ok(self.machine);
        }
        let key = listed(self.unknown.iter().map(|u| format!("{} of drive {}", u.key, u.drive)));
        let problem = "unknown, expected a number; a URDF can be imported again with --stiffness or --like".into();
        Err(Error::Value { file: self.origin, line: None, key, problem })
    }
}

/// Drives of `spec` whose stiffness is unknown, in the order of the file.
fn unknown_stiffnesses(spec: &MachineSpec) -> Vec<UnknownStiffness> {
    spec.chain.iter().enumerate().flat_map(|(index, design)| unknown_in_chain(index, design)).collect()
}

/// Drives of chain design number `index` whose stiffness is unknown.
fn unknown_in_chain(index: usize, design: &ChainSpec) -> impl Iterator<Item = UnknownStiffness> {
    design.elements.iter().enumerate().filter_map(move |(e, element)| {
        let (stiffness, drive, key) = match element {
            ElementSpec::PrismaticDrive(drive) => (drive.stiffness, &drive.name, "prismatic_drive.stiffness_N_per_mm"),
            ElementSpec::RevoluteDrive(drive) => (drive.stiffness, &drive.name, "revolute_drive.stiffness_Nmm_per_rad"),
            _ => return None,
        };
        let key = format!("chain[{index}].elements[{e}].{key}");
        (stiffness == StiffnessSpec::Unknown).then(|| UnknownStiffness { drive: drive.clone(), key })
    })
}
