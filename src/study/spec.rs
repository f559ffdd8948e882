//! What study files of several kinds hold, as written: raw, units in the keys, unknown keys refused. The rest stands with
//! its question. Checked by [`super::Study`].

use std::collections::BTreeMap;

use serde::{
    Deserialize, Deserializer,
    de::{MapAccess, Visitor, value::MapAccessDeserializer},
};

use crate::process::{
    ForceLaw,
    file::{chain_errors::ChainErrorSpec, spec::ProcessSpec},
};

/// Version of study files as they are written now: a study names a process file or holds the same tables.
pub const SCHEMA: u32 = 2;
/// Versions that are read. In schema 1, maps said force and chain errors in keys of their own.
pub const SCHEMAS: [u32; 2] = [1, SCHEMA];

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
    /// Drives that are told where to stand, mm or degrees, by name.
    pub held: BTreeMap<String, f64>,
    /// Force, chain errors, placement and what else is said of a process.
    pub process: Option<ProcessRef>,
    /// Of schema 1: the cutting force of a workspace map or superposition study.
    pub milling: Option<MillingSpec>,
    /// Of schema 1: manufacturing and assembly errors of a workspace map or superposition study.
    pub chain_error: Option<Vec<ChainErrorSpec>>,
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
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrTables;

        impl<'de> Visitor<'de> for NameOrTables {
            type Value = ProcessRef;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the name of a process file, or its tables")
            }

            fn visit_str<E>(self, name: &str) -> Result<ProcessRef, E> {
                Ok(ProcessRef::File(name.into()))
            }

            fn visit_map<A: MapAccess<'de>>(self, tables: A) -> Result<ProcessRef, A::Error> {
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

/// Groove milling, eqs. (16) and (17), in the frame of the tool: see [`crate::process::MillingForce`].
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MillingSpec {
    /// F_r.
    #[serde(rename = "radial_force_N")]
    pub radial_force: f64,
    /// F_t.
    #[serde(rename = "tangential_force_N")]
    pub tangential_force: f64,
    /// F_z.
    #[serde(rename = "axial_force_N")]
    pub axial_force: f64,
    /// `rotated` (default) or `printed`.
    #[serde(default)]
    pub law: ForceLaw,
    /// Step between tool angles over one turn; 10° if not given.
    pub phi_step_deg: Option<f64>,
}

pub(super) fn default_grid() -> [usize; 3] {
    [11; 3]
}
