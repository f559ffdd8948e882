//! Checks the stock and the tools that cut it in a process file.

use std::collections::BTreeMap;

use kinetostat_removal::{Cutter, RemovalError, Stock};
use serde::Deserialize;

use super::{force::teeth, spec::ProcessSpec};
use crate::{
    input::{check::Check, error::Result},
    process::{
        cutting::Stub,
        stock::{StockRemoval, StockShape, StockTool},
    },
};

/// The table `stock`: what is cut, in the frame of the workpiece.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StockSpec {
    /// A box along the axes of the workpiece.
    #[serde(rename = "box")]
    pub cuboid: Option<BoxSpec>,
    /// A cylinder along z of the workpiece.
    pub cylinder: Option<CylinderSpec>,
    /// Largest cell of the field; a fortieth of the smallest tool's diameter if not given.
    pub cell_mm: Option<f64>,
    /// Natural frequencies of machine, tool and part.
    #[serde(default, rename = "natural_frequencies_Hz")]
    pub natural_frequencies_hz: Vec<f64>,
}

/// A box between two corners.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Least coordinates.
    pub min_mm: [f64; 3],
    /// Largest coordinates.
    pub max_mm: [f64; 3],
}

/// A cylinder along z.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderSpec {
    /// Centre of the lower end.
    pub base_mm: [f64; 3],
    /// Diameter.
    pub diameter_mm: f64,
    /// Height.
    pub height_mm: f64,
}

/// A tool of a program that cuts stock.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolSpec {
    /// Its shape.
    #[serde(default)]
    pub shape: ShapeSpec,
    /// D.
    pub diameter_mm: f64,
    /// Corner radius of a bull nose.
    pub corner_radius_mm: Option<f64>,
    /// Point angle of a drill; 118 if not given.
    pub point_angle_deg: Option<f64>,
    /// Number of teeth.
    pub teeth: u32,
    /// Angle of the helix.
    pub helix_deg: Option<f64>,
    /// Length from the holder to the tip.
    pub stick_out_mm: Option<f64>,
    /// Young's modulus.
    #[serde(rename = "youngs_modulus_N_per_mm2")]
    pub youngs_modulus_n_per_mm2: Option<f64>,
    /// Diameter of the cylinder that bends as the tool does; 0.8 of its own if not given.
    pub equivalent_diameter_mm: Option<f64>,
    /// Stiffness of spindle and holder across the tool; rigid if not given.
    #[serde(rename = "holder_N_per_mm")]
    pub holder_n_per_mm: Option<f64>,
}

/// The shape of a tool, as written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeSpec {
    /// End mill with sharp corners.
    #[default]
    Flat,
    /// Ball end mill.
    Ball,
    /// End mill with round corners.
    BullNose,
    /// Twist drill.
    Drill,
}

/// Point angle of a drill if none is given, degrees.
const POINT_ANGLE_DEG: f64 = 118.0;

/// Checks the stock with the tools that cut it, by number; `None` where neither is given.
pub(super) fn stock(process: &ProcessSpec, check: &Check) -> Result<Option<StockRemoval>> {
    let tools = &process.tools;
    let Some(spec) = &process.stock else {
        return match tools.keys().next() {
            Some(name) => check.key("tools").key(name).fail("has no effect without [stock]: expected that".into()),
            None => Ok(None),
        };
    };
    let check_stock = check.key("stock");
    let shape = match (spec.cuboid, spec.cylinder) {
        (Some(BoxSpec { min_mm, max_mm }), None) => {
            let check = check_stock.key("box");
            let shape =
                StockShape::Box { min: check.key("min_mm").finite(min_mm)?, max: check.key("max_mm").finite(max_mm)? };
            shape.along_z().or_else(|error| check.fail(error.to_string()))?;
            shape
        }
        (None, Some(CylinderSpec { base_mm, diameter_mm, height_mm })) => {
            let check = check_stock.key("cylinder");
            let base = check.key("base_mm").finite(base_mm)?;
            let diameter_mm = check.key("diameter_mm").positive(diameter_mm)?;
            StockShape::Cylinder { base, diameter_mm, height_mm: check.key("height_mm").positive(height_mm)? }
        }
        _ => return check_stock.fail("expected one of box and cylinder".into()),
    };
    let mut by_number = BTreeMap::new();
    for (name, spec) in tools {
        let check = check.key("tools").key(name);
        let Ok(number) = name.parse::<u32>() else {
            return check.fail("is no tool: expected the number of a tool, as after T in a program".into());
        };
        if by_number.insert(number, tool(spec, &check)?).is_some() {
            return check.fail(format!("is tool {number} again"));
        }
    }
    if by_number.is_empty() {
        return check.key("tools").fail("missing: expected the tools that cut the stock, such as [tools.1]".into());
    }
    if process.uncertainty.is_some()
        && let Some((number, _)) = by_number.iter().find(|own| own.1.stub.is_some())
    {
        let problem =
            "is given where inputs are uncertain: the bend of a tool is not varied with them, expected one of both";
        return check.key("tools").key(&number.to_string()).key("stick_out_mm").fail(problem.into());
    }
    let cell_mm = check_stock.key("cell_mm").optional_positive(spec.cell_mm)?;
    let chords_mm = super::resolve::sampling_of(process, check)?.chordal_tolerance_mm();
    let frequencies = &spec.natural_frequencies_hz;
    for (number, own) in frequencies.iter().enumerate() {
        check_stock.key(&format!("natural_frequencies_Hz[{number}]")).positive(*own)?;
    }
    let frequencies = frequencies.clone();
    Ok(Some(StockRemoval::new((shape, cell_mm), (by_number, frequencies), chords_mm, check_stock)))
}

impl StockShape {
    /// The stock where the tool points down along z, so that what makes none is found when it is read.
    fn along_z(&self) -> std::result::Result<Stock, RemovalError> {
        match self {
            StockShape::Box { min, max } => Stock::cuboid(*min, *max),
            StockShape::Cylinder { base, diameter_mm, height_mm } => Stock::cylinder(*base, *diameter_mm, *height_mm),
        }
    }
}

fn tool(spec: &ToolSpec, check: &Check) -> Result<StockTool> {
    let diameter_mm = check.key("diameter_mm").positive(spec.diameter_mm)?;
    let only = |key: &str, given: Option<f64>, shape: ShapeSpec, name: &str| match given {
        Some(_) if spec.shape != shape => {
            check.key(key).fail(format!("is of shape = \"{name}\": expected no such key"))
        }
        _ => Ok(()),
    };
    only("corner_radius_mm", spec.corner_radius_mm, ShapeSpec::BullNose, "bull_nose")?;
    only("point_angle_deg", spec.point_angle_deg, ShapeSpec::Drill, "drill")?;
    let cutter = match (spec.shape, spec.corner_radius_mm) {
        (ShapeSpec::Flat, _) => Cutter::flat(diameter_mm),
        (ShapeSpec::Ball, _) => Cutter::ball(diameter_mm),
        (ShapeSpec::BullNose, Some(corner)) => Cutter::bull(diameter_mm, corner),
        (ShapeSpec::BullNose, None) => {
            return check.key("corner_radius_mm").fail("missing: expected the radius of the corner".into());
        }
        (ShapeSpec::Drill, _) => Cutter::drill(diameter_mm, spec.point_angle_deg.unwrap_or(POINT_ANGLE_DEG)),
    };
    let cutter = cutter.or_else(|error| check.fail(error.to_string()))?;
    Ok(StockTool { cutter, teeth: teeth(spec.teeth, check)?, stub: stub(spec, diameter_mm, check)? })
}

/// Checks how the tool bends: all that it needs is given, or nothing.
fn stub(spec: &ToolSpec, diameter_mm: f64, check: &Check) -> Result<Option<Stub>> {
    let others = [
        ("helix_deg", spec.helix_deg),
        ("youngs_modulus_N_per_mm2", spec.youngs_modulus_n_per_mm2),
        ("equivalent_diameter_mm", spec.equivalent_diameter_mm),
        ("holder_N_per_mm", spec.holder_n_per_mm),
    ];
    let Some(stick_out_mm) = spec.stick_out_mm else {
        return match others.iter().find(|own| own.1.is_some()) {
            Some((key, _)) => check.key(key).fail("has no effect without stick_out_mm: expected that".into()),
            None => Ok(None),
        };
    };
    if spec.shape == ShapeSpec::Drill {
        return check.key("stick_out_mm").fail("is of a tool that makes walls: expected no such key of a drill".into());
    }
    if let Some((key, _)) = others[..2].iter().find(|own| own.1.is_none()) {
        return check.key(key).fail("missing: a tool with stick_out_mm bends by it".into());
    }
    let positive = |key: &str, given: Option<f64>, other: f64| check.key(key).positive(given.unwrap_or(other));
    let helix = check.key("helix_deg").not_negative(spec.helix_deg.unwrap_or(0.0))?;
    if helix >= 80.0 {
        return check.key("helix_deg").fail(format!("is {helix}: expected from 0 to below 80"));
    }
    let equivalent = positive("equivalent_diameter_mm", spec.equivalent_diameter_mm, 0.8 * diameter_mm)?;
    let modulus = positive("youngs_modulus_N_per_mm2", spec.youngs_modulus_n_per_mm2, 1.0)?;
    let inertia = std::f64::consts::PI * equivalent.powi(4) / 64.0;
    Ok(Some(Stub {
        stick_out_mm: check.key("stick_out_mm").positive(stick_out_mm)?,
        rigidity_Nmm2: modulus * inertia,
        holder_mm_per_N: spec
            .holder_n_per_mm
            .map_or(Ok(0.0), |own| check.key("holder_N_per_mm").positive(own).map(|own| 1.0 / own))?,
        lag_per_mm: 2.0 * libm::tan(helix.to_radians()) / diameter_mm,
    }))
}
