//! The workpiece carrier, from a machine file as written.

use super::{MAX_COORDINATES, at_home, chain::mounted_chain, design_index};
use crate::{
    input::{check::Check, error::Result},
    machine::{
        Accuracy, Configuration, Machine, Model, ToolAxisSource, ZeroState,
        spec::{CarrierSpec, FrameSpec, MachineSpec, MountSpec},
    },
    spatial::Pose,
};

/// Builds the workpiece carrier as a machine of one chain from O to W, whose P is the origin of W and whose home is where its drives stand.
pub(super) fn resolve(written: &CarrierSpec, spec: &MachineSpec, machine: &Machine, check: &Check) -> Result<Machine> {
    check.key("name").identifier(&written.name)?;
    check.key("name").unique(&written.name, spec.mount.iter().map(|mount| mount.name.as_str()))?;
    let design = design_index(spec, &written.chain, &check.key("chain"))?;
    let mount = MountSpec {
        name: written.name.clone(),
        chain: written.chain.clone(),
        base: written.base.clone(),
        platform: FrameSpec::default(),
    };
    let check_chain = check.root().key(&format!("chain[{design}]"));
    let chain = mounted_chain(spec, design, &mount, &check_chain, check)?;
    if let Some(joint) = chain.passive.first() {
        let problem = format!("chain \"{}\" has the passive joint {}: {MOVES_BY_DRIVES}", written.chain, joint.name);
        return check.key("chain").fail(problem);
    }
    if chain.route.loop_count() > 0 {
        return check.key("chain").fail(format!("chain \"{}\" has a module: {MOVES_BY_DRIVES}", written.chain));
    }
    if chain.coordinate_count() > MAX_COORDINATES {
        let problem = format!(
            "expected at most {MAX_COORDINATES} coordinates of joints and springs, got {}",
            chain.coordinate_count()
        );
        return check.key("chain").fail(problem);
    }
    let mut carrier = Machine::from_model(Model {
        name: written.name.clone(),
        title: written.name.clone(),
        source: String::new(),
        provenance: Vec::new(),
        accuracy: Accuracy::default(),
        home: Configuration::start(std::slice::from_ref(&chain), Pose::identity()),
        chains: vec![chain],
        tool_tip: nalgebra::Vector3::zeros(),
        tool_axes: nalgebra::Matrix3::identity(),
        tool_axis_source: ToolAxisSource::PlatformZ,
        controls: Vec::new(),
        points: Vec::new(),
        platform_mass: None,
        base_bodies: Vec::new(),
        platform_bodies: Vec::new(),
        tool_compliance: None,
        carrier: None,
        locked: Vec::new(),
        arm: None,
        branch: None,
        redundancy: 0,
        has_parasitic_rotation: false,
        ..Model::clone(machine)
    });
    carrier.home = carrier.serial_configuration(&carrier.home.drives);
    carrier.home_target = carrier.home.pose;
    if let Err(beyond) = carrier.check_limits(&carrier.home) {
        return check_chain.key("elements").fail(format!("the carrier's home is beyond a limit: {beyond}"));
    }
    if carrier.zeroed == ZeroState::AtHome && carrier.has_weight() {
        let problem = "\"at_home\" offsets the drives of the machine, which cannot hold the workpiece carrier under its \
                       weight: expected \"at_rest\" or \"weightless\", or a carrier without masses";
        return check.root().key("zeroed").fail(problem.into());
    }
    at_home::check_at_home(&carrier, spec, &check.root())?;
    Ok(carrier)
}

/// What is expected of a carrier.
const MOVES_BY_DRIVES: &str =
    "expected only drives, beams, links, fixed transforms, springs and masses between O and the workpiece";
