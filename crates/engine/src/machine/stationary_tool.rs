//! A machine that holds the part, seen from the part: O is its platform, and the platform is its base, with P at the tip of the tool that stands in it.
//!
//! What moves and bends between part and tool is the same, whichever of them is held. P is at the tip so that no lever from P to it turns. The chain is taken from its end: `X⁻¹` of each transform,
//! and half turns about a drive, which turn its positive sense round.

use nalgebra::Vector3;

use super::{
    Machine,
    spec::{AxisSpec, BoxSpec, ChainSpec, ElementSpec, FixedSpec, HomeSpec, MachineSpec, MountSpec, ZeroedSpec},
};
use crate::{
    input::{check::Check, error::Result},
    spatial::Pose,
};

/// Bound of the workspace, mm: the box of the file is one of the part.
const WORKSPACE_MM: f64 = 1e5;

impl Machine {
    /// Returns the file of this machine seen from the part that it holds, with the tip of the tool at `tip_mm` of O; `check` locates what asks for
    /// it. With `without_weight` its masses and springs are left out.
    ///
    /// # Errors
    /// More than one chain, passive or elastic links, a workpiece carrier, errors of its chains, less than six controlled coordinates, and weight
    /// unless it is left out, as gravity would turn with the part.
    pub(super) fn seen_from_part(&self, tip_mm: [f64; 3], without_weight: bool, check: &Check) -> Result<MachineSpec> {
        let spec = self.definition.spec();
        let ([mount], None, 6) = (&spec.mount[..], &spec.workpiece_carrier, spec.platform.controls.len()) else {
            let problem = "expected a machine of one chain that controls six coordinates, and no workpiece_carrier";
            return check.fail(problem.into());
        };
        if self.has_recorded_errors() {
            return check.fail("expected a machine without errors of its chains".into());
        }
        let own = spec.chain.iter().find(|chain| chain.name == mount.chain);
        let own: &[ElementSpec] = own.map_or(&[], |chain| &chain.elements);
        let mut elements = Vec::with_capacity(3 * own.len());
        let mut has_weight = spec.platform.mass.as_ref().is_some_and(|mass| mass.kg > 0.0);
        for (name, element) in ElementSpec::names(own).into_iter().zip(own).rev() {
            let axis = match element {
                ElementSpec::Fixed(fixed) => {
                    let at = Pose {
                        translation: fixed.translation_mm.into(),
                        ..Pose::from_roll_pitch_yaw(Vector3::from(fixed.rotation_deg).map(f64::to_radians))
                    };
                    elements.push(fixed_element(name, &at.inverse()));
                    continue;
                }
                ElementSpec::Frame(_) | ElementSpec::Body(_) => continue,
                ElementSpec::Mass(_) | ElementSpec::Spring(_) => {
                    has_weight = true;
                    continue;
                }
                ElementSpec::RevoluteDrive(drive) => drive.axis,
                ElementSpec::PrismaticDrive(drive) => drive.axis,
                _ => return check.fail(format!("{name} is no drive: expected a chain whose drives alone bend")),
            };
            let half_turn = match axis {
                AxisSpec::X => Vector3::y(),
                AxisSpec::Y => Vector3::z(),
                AxisSpec::Z => Vector3::x(),
            };
            let half_turn = Pose::from_roll_pitch_yaw(half_turn * std::f64::consts::PI);
            elements.push(fixed_element(format!("{name}_turned"), &half_turn));
            elements.push(element.clone());
            elements.push(fixed_element(format!("{name}_turned_back"), &half_turn));
        }
        if has_weight && !without_weight {
            let problem = "weight is not followed where the part is held, as gravity turns with it: expected a machine without masses and \
                           springs, or without_weight = true, which leaves them out";
            return check.fail(problem.into());
        }
        let home = self.home.pose.inverse().compose(&Pose::from_translation(tip_mm.into()));
        let mut seen = spec.clone();
        // Bodies stand where the machine had its base and its platform, which change their places.
        seen.body.clear();
        seen.platform.body.clear();
        seen.may_touch.clear();
        seen.chain = vec![ChainSpec { name: mount.chain.clone(), elements }];
        let [base, mut platform] = [mount.platform.clone(), mount.base.clone()];
        platform.position_mm.iter_mut().zip(tip_mm).for_each(|(at, tip)| *at -= tip);
        seen.mount = vec![MountSpec { base, platform, ..mount.clone() }];
        seen.platform.tool_tip_mm = [0.0; 3];
        seen.home = HomeSpec { position_mm: home.translation.into(), rotation_deg: home.roll_pitch_yaw_deg() };
        seen.workspace = BoxSpec { min_mm: [-WORKSPACE_MM; 3], max_mm: [WORKSPACE_MM; 3] };
        (seen.gravity, seen.zeroed, seen.point) = (Some([0.0; 3]), ZeroedSpec::AtRest, Vec::new());
        seen.platform.mass = None;
        // What it says of numbers is of where they were.
        seen.provenance.retain(|known| known.parameters.iter().all(|name| name.ends_with(".stiffness")));
        seen.title = format!("{}, holding the part", spec.title);
        Ok(seen)
    }
}

/// Returns the element of a rigid transform to `at`.
fn fixed_element(name: String, at: &Pose) -> ElementSpec {
    ElementSpec::Fixed(FixedSpec {
        name: Some(name),
        translation_mm: at.translation.into(),
        rotation_deg: at.roll_pitch_yaw_deg(),
    })
}
