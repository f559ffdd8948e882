//! The machine on a page: its figures, provenance, limits and errors in words.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::description::{Fact, Mark};
use crate::{
    figures::{Figure, PoseFigure, Surroundings, amplification::amplification},
    files::{
        table::tidy_degrees,
        words::{typographic, with_minus_signs},
    },
    machine::{Chain, ChainError, Drive, Machine, Motion, Provenance, Skeleton},
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
    /// Ends of the guideways of its slides, in O, mm.
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

/// Returns what a group of parameters is based on: grade, confidence interval and source.
fn provenance_fact(provenance: &Provenance) -> Fact {
    let interval =
        provenance.interval.map_or(String::new(), |[low, high]| format!(", 95 % interval {low:.4e} to {high:.4e}"));
    Fact {
        label: provenance.what.clone(),
        value: format!("{}{interval}: {}", provenance.grade.label().replace('_', " "), provenance.source),
    }
}

impl MachineDescription {
    /// Describes `machine` at home.
    pub fn new(machine: &Machine) -> Self {
        let mut home = machine.rigid_skeleton(&machine.home);
        home.chains.extend(machine.carrier.iter().flat_map(|carrier| carrier.rigid_skeleton(&carrier.home).chains));
        let mut rails = Vec::new();
        for ((chain, drive), range) in machine.drives().zip(machine.drive_ranges()) {
            let mut joints = home.chains[chain].joints.iter();
            let Some(joint) = joints.find(|joint| joint.is_drive && joint.name == drive.name) else { continue };
            // What is shown of a coupled drive is not where its joint stands.
            if !joint.slides || machine.chains[chain].coupling.is_some() {
                continue;
            }
            let end = |rho: f64| std::array::from_fn(|i| joint.position_mm[i] + (rho - joint.value) * joint.axis[i]);
            rails.push(range.map(end));
        }
        Self {
            name: machine.name.clone(),
            short_title: machine.short_title().into(),
            title: machine.title.clone(),
            source: machine.source.clone(),
            provenance: machine.provenance.iter().map(provenance_fact).collect(),
            home,
            rails,
            workspace_mm: [machine.workspace.min.into(), machine.workspace.max.into()],
            points: machine
                .points
                .iter()
                .map(|point| Mark { label: point.name.clone(), position: point.position.iter().copied().collect() })
                .collect(),
            limits: limit_facts(machine),
        }
    }

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
    pub(crate) fn bent_figure(&self, bent: &DeflectedPose) -> Figure {
        let size = bent.tool_displacement_mm.norm();
        let links = bent.commanded.chains.iter().flat_map(|chain| chain.links.iter().flatten());
        let points: Vec<_> = links.map(|point| (*point).into()).collect();
        let factor = amplification(&points, size);
        let [x, y, z]: [f64; 3] = bent.force_n.map(|part| part.round() + 0.0).into();
        Figure::Pose(Box::new(PoseFigure {
            title: format!("How the machine bends {}", bent.place),
            subtitle: with_minus_signs(&format!(
                "{}, force on the tool ({x:.0}, {y:.0}, {z:.0}) N, tool displacement {size:.3} mm",
                self.name
            )),
            pose: bent.commanded.clone(),
            displaced: Some(amplified_pose(&bent.commanded, &bent.loaded, factor)),
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

/// Returns travel and force limit of each drive, and limits of passive joints, in words.
fn limit_facts(machine: &Machine) -> Vec<Fact> {
    let mut facts = Vec::new();
    let range_words = |(low, high): (f64, f64), motion: Motion| {
        let (low, high, unit) = (motion.to_shown(low), motion.to_shown(high), motion.position_suffix());
        typographic(&match motion {
            Motion::Prismatic => format!("{low} to {high}{unit}"),
            Motion::Revolute => format!("{low:.3}{unit} to {high:.3}{unit}"),
        })
    };
    for ((_, drive), label) in machine.drives().zip(machine.drive_labels()) {
        let unit = drive.motion.shown_force_unit();
        let travel = drive.travel.map(|travel| format!("travel {}", range_words(travel, drive.motion)));
        let force = drive.force_limit.map(|limit| format!("at most {limit} {unit}"));
        let limits_given: Vec<String> = travel.into_iter().chain(force).collect();
        if !limits_given.is_empty() {
            facts.push(Fact::new(format!("drive {label}"), limits_given.join(", ")));
        }
    }
    for chain in &machine.chains {
        for joint in &chain.passive {
            if let Some(limits) = joint.limits {
                let label = format!("joint {} of chain {}", joint.name, chain.name);
                facts.push(Fact::new(label, range_words(limits, joint.motion)));
            }
        }
    }
    if facts.is_empty() {
        facts.push(Fact::new("travel, joint and force limits", "none given"));
    }
    facts
}

/// Returns the chain errors in words, a line for each chain that has any.
pub(crate) fn error_facts(machine: &Machine, errors: &[ChainError]) -> Vec<Fact> {
    let mut facts: Vec<Fact> = Vec::new();
    for (chain, error) in machine.chains.iter().zip(errors) {
        let parts = error_words(chain, error);
        if !parts.is_empty() {
            facts.push(Fact::new(format!("error of chain {}", chain.name), parts.join("; ")));
        }
    }
    if facts.is_empty() {
        facts.push(Fact::new("chain errors", "none"));
    }
    facts
}

/// Describes the rotation vector (degrees) of a `frame`: the angle about one of its axes, or about a direction.
fn rotation_words(frame: &str, rotation: Vector3<f64>) -> String {
    let about: Vec<usize> = (0..3).filter(|&axis| rotation[axis] != 0.0).collect();
    typographic(&match about.as_slice() {
        [axis] => format!("{frame} rotated by {}° about its {} axis", rotation[*axis], ["x", "y", "z"][*axis]),
        _ => {
            let angle = rotation.norm();
            let [x, y, z]: [f64; 3] = (rotation / angle).into();
            format!("{frame} rotated by {angle:.6}° about ({x:.4}, {y:.4}, {z:.4}) of its axes")
        }
    })
}

/// Describes the errors of a chain: shifts and rotations of its base and end, and drive offsets.
fn error_words(chain: &Chain, error: &ChainError) -> Vec<String> {
    let vector = |v: nalgebra::Vector3<f64>, unit: &str| {
        let [x, y, z]: [f64; 3] = v.map(|c| (c * 1e9).round() / 1e9 + 0.0).into();
        typographic(&format!("({x}, {y}, {z}){unit}"))
    };
    let mut parts = Vec::new();
    for (frame, twist) in [("base", error.base), ("end", error.end)] {
        if twist.linear.norm() > 0.0 {
            parts.push(format!("{frame} shifted by {}", vector(twist.linear, " mm")));
        }
        if twist.angular.norm() > 0.0 {
            parts.push(rotation_words(frame, twist.angular.map(|angle| tidy_degrees(angle.to_degrees()) + 0.0)));
        }
    }
    if error.drive_offsets.iter().any(|offset| *offset != 0.0) {
        let offset = |(drive, offset): (&Drive, &f64)| {
            let shown = tidy_degrees(drive.motion.to_shown(*offset)) + 0.0;
            typographic(&format!("{shown}{}", drive.motion.position_suffix()))
        };
        let offsets: Vec<String> = chain.drives.iter().zip(&error.drive_offsets).map(offset).collect();
        parts.push(format!("drive zeros off by {}", offsets.join(", ")));
    }
    parts
}
