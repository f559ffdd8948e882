//! Materials with published cutting coefficients, each with its source: `materials.toml` beside this file.

use serde::Deserialize;

use super::{EdgeForce, Kienzle};
use crate::{
    input::{error::Result, toml_file},
    machine::Grade,
};

/// The published cutting coefficients of a material, by machining operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coefficients {
    /// Average cutting coefficients of end mills.
    Milling {
        /// K_tc and K_te.
        tangential: EdgeForce,
        /// K_rc and K_re.
        radial: EdgeForce,
        /// K_ac and K_ae.
        axial: EdgeForce,
    },
    /// The main cutting force of turning, by Kienzle's law.
    Kienzle(Kienzle),
    /// Material constant of thrust and torque of twist drills.
    Drilling(f64),
}

/// A material with its cutting coefficients and their source.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The material's name in process files.
    pub name: String,
    /// The cutting coefficients.
    pub coefficients: Coefficients,
    /// The tool of the tests, where the source says it.
    pub tool: Option<String>,
    /// How reliable the coefficients are.
    pub grade: Grade,
    /// The publication that the coefficients come from.
    pub source: String,
}

/// Returns all materials, in the order of `materials.toml`; fails only if that file has a mistake.
pub fn all() -> Result<Vec<Material>> {
    let file: FileSpec = toml_file::parse(include_str!("materials.toml"), "materials.toml")?;
    let force = |[cutting, edge]: [f64; 2]| EdgeForce { cutting, edge };
    let milling = file.milling.into_iter().map(|spec| Material {
        coefficients: Coefficients::Milling {
            tangential: force(spec.tangential),
            radial: force(spec.radial),
            axial: force(spec.axial),
        },
        tool: Some(spec.tool),
        name: spec.name,
        grade: spec.grade,
        source: spec.source,
    });
    let kienzle = file.kienzle.into_iter().map(|spec| Material {
        coefficients: Coefficients::Kienzle(Kienzle { specific_force: spec.specific_force, exponent: spec.exponent }),
        tool: None,
        name: spec.name,
        grade: spec.grade,
        source: spec.source,
    });
    let drilling = file.drilling.into_iter().map(|spec| Material {
        coefficients: Coefficients::Drilling(spec.constant),
        tool: None,
        name: spec.name,
        grade: spec.grade,
        source: spec.source,
    });
    Ok(milling.chain(kienzle).chain(drilling).collect())
}

/// The contents of `materials.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileSpec {
    milling: Vec<MillingSpec>,
    kienzle: Vec<KienzleSpec>,
    drilling: Vec<DrillingSpec>,
}

/// A material with milling coefficients in `materials.toml`: K_c in N/mm² and K_e in N/mm for each direction.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MillingSpec {
    name: String,
    tangential: [f64; 2],
    radial: [f64; 2],
    axial: [f64; 2],
    tool: String,
    grade: Grade,
    source: String,
}

/// A material with Kienzle coefficients in `materials.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KienzleSpec {
    name: String,
    specific_force: f64,
    exponent: f64,
    grade: Grade,
    source: String,
}

/// A material with a drilling constant in `materials.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DrillingSpec {
    name: String,
    constant: f64,
    grade: Grade,
    source: String,
}
