//! Keys that study files of several kinds share, as written: raw, units in the keys, unknown keys refused. Checked by [`super::Study`].

use std::collections::BTreeMap;

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeOwned, IgnoredAny, MapAccess, Visitor, value::MapAccessDeserializer},
};

use crate::{
    input::{check::Check, error::Result, toml_file},
    process::{file::spec::ProcessSpec, uncertainty::spec::UncertaintySpec},
};

/// Version of study files.
pub const SCHEMA: u32 = 3;

/// The keys by which a study of any version is recognised.
#[derive(Deserialize)]
struct Versioned {
    schema: u32,
    #[serde(rename = "question")]
    _question: IgnoredAny,
}

/// Parses a study file, which `origin` names in errors. For a file of another version the error says so, not which key is unknown.
pub(crate) fn parse<T: DeserializeOwned>(text: &str, origin: &str) -> Result<T> {
    toml_file::parse(text, origin).or_else(|fault| {
        if let Ok(versioned) = toml_file::parse::<Versioned>(text, origin) {
            check_schema(versioned.schema, &Check::new(origin))?;
        }
        Err(fault)
    })
}

/// Checks the version of a study file. `Err` if it is not [`SCHEMA`].
pub(crate) fn check_schema(schema: u32, check: &Check) -> Result<()> {
    match schema {
        SCHEMA => Ok(()),
        _ => check.key("schema").fail(format!("this program reads studies of version {SCHEMA}, got {schema}")),
    }
}

/// The keys of a study of any kind.
#[derive(Debug, Clone)]
pub struct Header {
    /// Version of the file format.
    pub schema: u32,
    /// The question that the study answers, one sentence.
    pub question: String,
    /// A built-in machine, or a machine file relative to the study's folder.
    pub machine: String,
    /// The branch of inverse kinematics of an arm, such as `front-up-noflip`; any if not given.
    pub branch: Option<String>,
    /// Positions of the locked drives, mm or degrees, by name.
    pub locked: BTreeMap<String, f64>,
    /// The process: force, chain errors, placement and tolerance.
    pub process: Option<ProcessRef>,
    /// What is not known exactly; all inputs are taken as exact if not given.
    pub uncertainty: Option<UncertaintySpec>,
}

/// The process of a study: the name of its file, or its tables.
#[derive(Debug, Clone)]
pub enum ProcessRef {
    /// A process file, relative to the study's folder.
    File(String),
    /// The tables of a process file, in the study.
    Tables(Box<ProcessSpec>),
}

impl<'de> Deserialize<'de> for ProcessRef {
    /// Reads a string as a file name and a table as the process itself.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        /// Visitor that accepts a string or a table.
        struct NameOrTables;

        impl<'de> Visitor<'de> for NameOrTables {
            type Value = ProcessRef;

            /// Writes what a process must be, for error messages.
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the name of a process file, or its tables")
            }

            /// Returns the process file called `name`.
            fn visit_str<E>(self, name: &str) -> std::result::Result<ProcessRef, E> {
                Ok(ProcessRef::File(name.into()))
            }

            /// Returns the process given by its tables.
            fn visit_map<A: MapAccess<'de>>(self, tables: A) -> std::result::Result<ProcessRef, A::Error> {
                ProcessSpec::deserialize(MapAccessDeserializer::new(tables)).map(|spec| ProcessRef::Tables(spec.into()))
            }
        }

        deserializer.deserialize_any(NameOrTables)
    }
}

/// A full circle in the xy-plane of the workpiece, counter-clockwise.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CircleSpec {
    /// Centre in W; a circle has this or `centre_point`.
    pub centre_mm: Option<[f64; 3]>,
    /// Named point of the machine as the centre.
    pub centre_point: Option<String>,
    /// Diameter.
    pub diameter_mm: f64,
    /// Number of points along it, both ends included.
    pub points: usize,
}

/// Returns the grid of a map that gives none: 11 × 11 × 11 points.
pub(super) fn default_grid() -> [usize; 3] {
    [11; 3]
}
