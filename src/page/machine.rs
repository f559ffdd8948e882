//! The machine on a page, and its figures.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::description::{Fact, Mark};
use crate::{
    figures::{Figure, PoseFigure, Surroundings, amplification::amplification},
    files::words::with_minus_signs,
    spatial::Skeleton,
};

/// What a page says of a machine: its lines at home, guideways, workspace and named points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineDescription {
    /// Short name.
    pub name: String,
    /// What machine it is, in a few words, for headings.
    pub short_title: String,
    /// What machine it is, in one line.
    pub title: String,
    /// Where its parameters come from.
    pub source: String,
    /// Sources of single groups of parameters, with grade and confidence interval.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub provenance: Vec<Fact>,
    /// Its lines at home, in frame O.
    pub home: Skeleton,
    /// Ends of the guideways of its prismatic joints, in O, mm.
    pub rails: Vec<[[f64; 3]; 2]>,
    /// Lower and upper corner of the workspace of P, mm.
    pub workspace_mm: [[f64; 3]; 2],
    /// Named positions of P, in O.
    pub points: Vec<Mark>,
    /// Limits of drives and joints, one line each.
    pub limits: Vec<Fact>,
}

/// A machine without and with its deflection under a load.
#[derive(Debug, Clone, PartialEq)]
pub struct DeflectedPose {
    /// Position and load, in words.
    pub place: String,
    /// Nominal machine at its drive commands.
    pub commanded: Skeleton,
    /// Actual machine in equilibrium under the load.
    pub loaded: Skeleton,
    /// Displacement of the tool tip in O, mm.
    pub tool_displacement_mm: Vector3<f64>,
    /// Force on the tool in O, N.
    pub force_n: Vector3<f64>,
}

impl MachineDescription {
    /// Returns a figure of the machine at home.
    pub fn figure(&self) -> Figure {
        Figure::Pose(Box::new(PoseFigure {
            title: format!("{} at home", self.title),
            subtitle: "frame O of the machine base; P is the platform's reference point, T the tool tip".into(),
            pose: self.home.clone(),
            displaced: None,
            rails: self.rails.clone(),
            workspace: self.workspace_mm,
            surroundings: Surroundings::default(),
            note: None,
        }))
    }

    /// Returns a figure of the machine deflected by a load, with displacements amplified so that they can be seen.
    pub(crate) fn deflected_figure(&self, deflected: &DeflectedPose) -> Figure {
        let size = deflected.tool_displacement_mm.norm();
        let links = deflected.commanded.chains.iter().flat_map(|chain| chain.links.iter().flatten());
        let points: Vec<_> = links.map(|point| (*point).into()).collect();
        let factor = amplification(&points, size);
        let [x, y, z]: [f64; 3] = deflected.force_n.map(|part| part.round() + 0.0).into();
        Figure::Pose(Box::new(PoseFigure {
            title: format!("How the machine bends {}", deflected.place),
            subtitle: with_minus_signs(&format!(
                "{}, force on the tool ({x:.0}, {y:.0}, {z:.0}) N, tool displacement {size:.3} mm",
                self.name
            )),
            pose: deflected.commanded.clone(),
            displaced: Some(amplified_pose(&deflected.commanded, &deflected.loaded, factor)),
            rails: self.rails.clone(),
            workspace: self.workspace_mm,
            surroundings: Surroundings::default(),
            note: Some(format!("displacements drawn {factor} times as large")),
        }))
    }
}

/// Returns the pose `from` displaced by `factor` times the displacement to `to`; both are poses of the same machine.
fn amplified_pose(from: &Skeleton, to: &Skeleton, factor: f64) -> Skeleton {
    let amplified = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| a[i] + factor * (b[i] - a[i]));
    let mut pose = to.clone();
    for (chain, start) in pose.chains.iter_mut().zip(&from.chains) {
        let ends = chain.links.iter_mut().flatten().zip(start.links.iter().flatten());
        ends.for_each(|(end, start)| *end = amplified(*start, *end));
        let ends = chain.springs.iter_mut().flatten().zip(start.springs.iter().flatten());
        ends.for_each(|(end, start)| *end = amplified(*start, *end));
        for (joint, start) in chain.joints.iter_mut().zip(&start.joints) {
            joint.position_mm = amplified(start.position_mm, joint.position_mm);
        }
        for (mass, start) in chain.masses.iter_mut().zip(&start.masses) {
            mass.position_mm = amplified(start.position_mm, mass.position_mm);
        }
    }
    for (mass, start) in pose.platform_mass.iter_mut().zip(&from.platform_mass) {
        mass.position_mm = amplified(start.position_mm, mass.position_mm);
    }
    pose.platform_mm = amplified(from.platform_mm, to.platform_mm);
    pose.tool_tip_mm = amplified(from.tool_tip_mm, to.tool_tip_mm);
    pose
}
