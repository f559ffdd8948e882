//! Cross-sections from a machine file as written.

use crate::{
    input::{check::Check, error::Result},
    machine::{section::Section, spec::SectionSpec},
};

/// Checks the dimensions of a cross-section, mm.
pub(super) fn resolve_section(spec: &SectionSpec, check: &Check) -> Result<Section> {
    match spec {
        SectionSpec::Rectangle(spec) => {
            let check = check.key("rectangle");
            Ok(Section::Rectangle {
                width: check.key("width_mm").positive(spec.width_mm)?,
                height: check.key("height_mm").positive(spec.height_mm)?,
            })
        }
        SectionSpec::Round(spec) => {
            Ok(Section::Round { diameter: check.key("round.diameter_mm").positive(spec.diameter_mm)? })
        }
        SectionSpec::Tube(spec) => {
            let check = check.key("tube");
            let outer = check.key("outer_diameter_mm").positive(spec.outer_diameter_mm)?;
            let check_inner = check.key("inner_diameter_mm");
            let inner = check_inner.positive(spec.inner_diameter_mm)?;
            if inner >= outer {
                return check_inner.fail(format!("must be smaller than the outer diameter {outer}, got {inner}"));
            }
            Ok(Section::Tube { outer, inner })
        }
        SectionSpec::IBeam(spec) => {
            let check = check.key("i_beam");
            let (width, height) =
                (check.key("width_mm").positive(spec.width_mm)?, check.key("height_mm").positive(spec.height_mm)?);
            let flange = bounded(&check.key("flange_mm"), spec.flange_mm, 0.5 * height, "half the height")?;
            let web = check.key("web_mm").positive(spec.web_mm)?;
            if web > width {
                return check.key("web_mm").fail(format!("must not be wider than the flanges, {width}, got {web}"));
            }
            Ok(Section::I { width, height, flange, web })
        }
        SectionSpec::Box(spec) => {
            let check = check.key("box");
            let (width, height) =
                (check.key("width_mm").positive(spec.width_mm)?, check.key("height_mm").positive(spec.height_mm)?);
            let wall = bounded(&check.key("wall_mm"), spec.wall_mm, 0.5 * width.min(height), "half the smaller side")?;
            Ok(Section::Box { width, height, wall })
        }
        SectionSpec::TaperedTube(spec) => {
            let check = check.key("tapered_tube");
            let start = check.key("start_diameter_mm").positive(spec.start_diameter_mm)?;
            let end = check.key("end_diameter_mm").positive(spec.end_diameter_mm)?;
            let wall = bounded(&check.key("wall_mm"), spec.wall_mm, 0.5 * start.min(end), "half the smaller diameter")?;
            Ok(Section::TaperedTube { start, end, wall })
        }
    }
}

/// Checks that a thickness is positive and less than `most`, which messages call `what`.
fn bounded(check: &Check, value: f64, most: f64, what: &str) -> Result<f64> {
    let value = check.positive(value)?;
    if value < most { Ok(value) } else { check.fail(format!("must be less than {what}, {most}, got {value}")) }
}
