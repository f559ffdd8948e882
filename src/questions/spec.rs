//! What study files of several kinds hold, as written: raw, units in the keys, unknown keys refused. The rest stands with
//! its question. Checked by [`super::Study`].

use std::collections::BTreeMap;

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeOwned, IgnoredAny, MapAccess, Visitor, value::MapAccessDeserializer},
};

use crate::{
    input::{
        check::Check,
        error::Result,
        toml_file,
    },
    process::file::{self, spec::ProcessSpec},
};

/// Version of study files.
pub const SCHEMA: u32 = 3;

/// What tells a study of any version.
#[derive(Deserialize)]
struct Versioned {
    schema: u32,
    #[serde(rename = "question")]
    _question: IgnoredAny,
}

/// Parses a study as written. Where it is of another version, that is what is told, not the first key that is unknown in
/// this one; `origin` names it.
///
/// # Errors
/// As [`toml_file::parse`].
pub(crate) fn parse<T: DeserializeOwned>(text: &str, origin: &str) -> Result<T> {
    toml_file::parse_renamed(text, origin, &[&RENAMED[..], &file::RENAMED].concat()).or_else(|fault| {
        if let Ok(versioned) = toml_file::parse::<Versioned>(text, origin) {
            check_schema(versioned.schema, &Check::new(origin))?;
        }
        Err(fault)
    })
}

/// Keys and values of version 2, and what they are since.
pub(crate) const RENAMED: [(&str, &str); 5] = [
    ("held", "locked"),
    ("turn_map", "redundancy_map"),
    ("redundancy_map.turn_step_deg", "gamma_step_deg"),
    ("error_left", "residual_error"),
    ("departure", "superposition_error"),
];

/// Refuses a version that is not read.
///
/// # Errors
/// It is another than [`SCHEMA`].
pub(crate) fn check_schema(schema: u32, check: &Check) -> Result<()> {
    let more = if schema == 2 { "; packaging/convert.py changes files of version 2" } else { "" };
    match schema {
        SCHEMA => Ok(()),
        _ => check.key("schema").fail(format!("this program reads studies of version {SCHEMA}, got {schema}{more}")),
    }
}

/// The keys of a study of any kind.
#[derive(Debug, Clone)]
pub struct Header {
    /// Version of the file format.
    pub schema: u32,
    /// What the study is to answer, in one sentence.
    pub question: String,
    /// A built-in machine, or a machine file relative to the study's folder.
    pub machine: String,
    /// The branch on which an arm is to stand, such as `front-up-noflip`; any if not given.
    pub branch: Option<String>,
    /// Locked drives, mm or degrees, by name.
    pub locked: BTreeMap<String, f64>,
    /// Force, chain errors, placement and what else is said of a process.
    pub process: Option<ProcessRef>,
}

/// The process of a study.
#[derive(Debug, Clone)]
pub enum ProcessRef {
    /// A process file, relative to the study's folder.
    File(String),
    /// The tables of a process file, in the study.
    Tables(Box<ProcessSpec>),
}

impl<'de> Deserialize<'de> for ProcessRef {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct NameOrTables;

        impl<'de> Visitor<'de> for NameOrTables {
            type Value = ProcessRef;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the name of a process file, or its tables")
            }

            fn visit_str<E>(self, name: &str) -> std::result::Result<ProcessRef, E> {
                Ok(ProcessRef::File(name.into()))
            }

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
    /// Centre; a circle has this or `centre_point`.
    pub centre_mm: Option<[f64; 3]>,
    /// Named point of the machine as the centre.
    pub centre_point: Option<String>,
    /// Diameter.
    pub diameter_mm: f64,
    /// Points along it, both ends included.
    pub points: usize,
}

pub(super) fn default_grid() -> [usize; 3] {
    [11; 3]
}
