//! Cross-sections from a machine file as written.

use crate::{
    input::{check::Check, error::Result},
    machine::{section::Section, spec::SectionSpec},
};

pub(super) fn section(spec: &SectionSpec, check: &Check) -> Result<Section> {
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
    }
}
