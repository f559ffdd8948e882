//! A machine in words: what a page says of it, its provenance, limits and errors.

use nalgebra::Vector3;

use crate::{
    files::words::{tidy_degrees, typographic},
    machine::{Chain, ChainError, Drive, Machine, Motion, NamedPoint, Provenance},
    page::{Fact, MachineDescription, Mark},
};

/// Returns what a page says of `machine` at home.
pub fn described(machine: &Machine) -> MachineDescription {
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
    MachineDescription {
        name: machine.name.clone(),
        short_title: machine.short_title().into(),
        title: machine.title.clone(),
        source: machine.source.clone(),
        provenance: machine.provenance.iter().map(provenance_fact).collect(),
        home,
        rails,
        workspace_mm: [machine.workspace.min.into(), machine.workspace.max.into()],
        points: marks(machine),
        limits: limit_facts(machine),
    }
}

/// Returns the named points of `machine` as pages mark them.
pub(super) fn marks(machine: &Machine) -> Vec<Mark> {
    let mark = |own: &NamedPoint| Mark { label: own.name.clone(), position: own.position.iter().copied().collect() };
    machine.points.iter().map(mark).collect()
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

/// Returns travel and force limit of each drive, and limits of passive joints, in words.
fn limit_facts(machine: &Machine) -> Vec<Fact> {
    let mut facts = Vec::new();
    let range_text = |(low, high): (f64, f64), motion: Motion| {
        let (low, high, unit) = (motion.to_shown(low), motion.to_shown(high), motion.position_suffix());
        typographic(&match motion {
            Motion::Prismatic => format!("{low} to {high}{unit}"),
            Motion::Revolute => format!("{low:.3}{unit} to {high:.3}{unit}"),
        })
    };
    for ((_, drive), label) in machine.drives().zip(machine.drive_labels()) {
        let unit = drive.motion.shown_force_unit();
        let travel = drive.travel.map(|travel| format!("travel {}", range_text(travel, drive.motion)));
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
                facts.push(Fact::new(label, range_text(limits, joint.motion)));
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
        let parts = error_text(chain, error);
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
fn rotation_text(frame: &str, rotation: Vector3<f64>) -> String {
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
fn error_text(chain: &Chain, error: &ChainError) -> Vec<String> {
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
            parts.push(rotation_text(frame, twist.angular.map(|angle| tidy_degrees(angle.to_degrees()) + 0.0)));
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
