//! Machine files resolved: from a file as written to a checked machine.

mod at_home;
mod carrier;
mod chain;
mod coupling;
mod hung;
mod module;
mod section;

use std::sync::Arc;

use kinetostat_cell::spec::BodySpec;
use nalgebra::{Matrix3, Matrix6, Vector3};

use super::{
    Chain, Coordinate, Machine, MachineBody, Model, NamedPoint, PlatformMass, Provenance, ToolAxisSource, WorkspaceBox,
    ZeroState, accuracy,
    branch::Arm,
    kinematics::{self, Configuration},
    parameters::{self, Definition, GRAVITY},
    section::{Material, Section, beam_stiffness},
    spec::{
        BeamSpec, ChainSpec, CoordinateSpec, CutterSpec, ElementSpec, FixedSpec, FrameSpec, LinkSpec, MachineSpec,
        MassSpec, MaterialSpec, ModuleSpec, NamedMassSpec, ZeroedSpec,
    },
};
use crate::{
    input::{check::Check, error::Result, names::listed},
    spatial::{Pose, frame_about},
};

/// Checks the file `definition`, written as `text`, and assembles the machine at home; `origin` names the file in errors.
pub(super) fn resolve_machine(definition: MachineSpec, origin: &str, text: Arc<str>) -> Result<Machine> {
    let spec = &definition;
    let check = Check::new(origin);
    check.schema(spec.schema)?;
    check.key("name").identifier(&spec.name)?;
    // Also those that nothing is made of.
    spec.material.iter().try_for_each(|(name, spec)| elastic_constants(name, spec, &check).map(drop))?;
    let chains = mounted_chains(spec, &check)?;
    let controls = resolve_controls(spec, &check)?;
    let drive_count: usize = chains.iter().map(|chain| chain.drives.len()).sum();
    if drive_count < controls.len() {
        let problem = format!("{} coordinates cannot be controlled by {drive_count} drives", controls.len());
        return check.key("platform.controls").fail(problem);
    }
    let home_check = check.key("home");
    let mut home_pose =
        Pose::from_roll_pitch_yaw(home_check.key("rotation_deg").finite(spec.home.rotation_deg)? * TO_RAD);
    home_pose.translation = home_check.key("position_mm").position(spec.home.position_mm)?;
    let tool_tip = check.key("platform.tool_tip_mm").position(spec.platform.tool_tip_mm)?;
    let (tool_axis, tool_axis_source) = resolve_tool_axis(spec, tool_tip, &check.key("platform.tool_axis"))?;
    let mut machine = Machine::from_model(Model {
        name: spec.name.clone(),
        title: spec.title.clone(),
        source: spec.source.clone(),
        provenance: resolve_provenance(spec, &check)?,
        accuracy: accuracy::resolve(spec.accuracy.as_ref(), &check.key("accuracy"))?,
        home: Configuration::start(&chains, home_pose),
        home_target: home_pose,
        characteristic_length: kinematics::characteristic_length(&chains, &Configuration::start(&chains, home_pose)),
        redundancy: 0,
        has_parasitic_rotation: false,
        locked: Vec::new(),
        carrier: None,
        arm: None,
        branch: None,
        chains,
        tool_tip,
        tool_axes: frame_about(tool_axis),
        tool_axis_source,
        controls,
        workspace: resolve_workspace(spec, &check)?,
        points: resolve_points(spec, &check)?,
        gravity: resolve_gravity(spec.gravity, &check)?,
        tool_compliance: resolve_tool_compliance(spec, &check.key("platform.tool"))?,
        platform_mass: resolve_platform_mass(spec.platform.mass.as_ref(), &check.key("platform.mass"))?,
        base_bodies: resolve_bodies(&spec.body, &check.key("body"))?,
        platform_bodies: resolve_bodies(&spec.platform.body, &check.key("platform.body"))?,
        zeroed: match spec.zeroed {
            ZeroedSpec::AtRest => ZeroState::AtRest,
            ZeroedSpec::Weightless => ZeroState::Weightless,
            ZeroedSpec::AtHome => ZeroState::AtHome,
        },
        definition: Definition::new(definition, origin, text),
    });
    machine.home = match machine.assemble_at_home() {
        Ok(home) => home,
        Err(unreachable) => return home_check.fail(format!("the chains cannot be assembled here: {unreachable}")),
    };
    // What was sought is only where the search began.
    machine.characteristic_length = kinematics::characteristic_length(&machine.chains, &machine.home);
    machine.redundancy = machine.redundancy_at_home();
    machine.has_parasitic_rotation = machine.rotates_parasitically();
    machine.arm = Arm::recognise(&machine).map(Box::new);
    at_home::check_at_home(&machine, machine.definition.spec(), &check)?;
    if let Some(definition) = machine.definition.spec().workpiece_carrier.clone() {
        let check = check.key("workpiece_carrier");
        machine.carrier = Some(carrier::resolve(&definition, machine.definition.spec(), &machine, &check)?);
    }
    machine.check_body_names()?;
    Ok(machine)
}

/// Checks bodies that are fixed to one frame.
fn resolve_bodies(specs: &[BodySpec], check: &Check) -> Result<Vec<MachineBody>> {
    specs.iter().enumerate().map(|(index, spec)| MachineBody::resolve(spec, "", &check.item(index))).collect()
}

/// Checks the entries of provenance, whose patterns must name parameters.
fn resolve_provenance(spec: &MachineSpec, check: &Check) -> Result<Vec<Provenance>> {
    let names = if spec.provenance.is_empty() { Vec::new() } else { parameters::names(spec) };
    let entries = spec.provenance.iter().enumerate().map(|(i, entry)| {
        let check = check.key(&format!("provenance[{i}]"));
        check.key("what").readable(&entry.what)?;
        check.key("source").readable(&entry.source)?;
        for (n, pattern) in entry.parameters.iter().enumerate() {
            parameters::check_pattern(&names, pattern, &check.key("parameters").item(n))?;
        }
        Ok(Provenance {
            what: entry.what.clone(),
            grade: entry.grade,
            source: entry.source.clone(),
            parameters: entry.parameters.clone(),
            interval: entry
                .interval
                .map(|ends| checked_interval(ends, &entry.parameters, &names, &check.key("interval")))
                .transpose()?,
        })
    });
    entries.collect()
}

/// Checks an interval of provenance, which must be about one parameter named in full.
fn checked_interval(ends: [f64; 2], about: &[String], names: &[String], check: &Check) -> Result<[f64; 2]> {
    let [low, high] = ends;
    if low.partial_cmp(&high).is_none_or(std::cmp::Ordering::is_gt) {
        return check.fail(format!("expected two numbers in ascending order, got {low} and {high}"));
    }
    match about {
        [name] if names.contains(name) => Ok(ends),
        _ => check.fail("expected the full name of one number, and no other, in parameters".into()),
    }
}

/// Names of the two ends of a chain among parameters.
const ENDS: [&str; 2] = ["base", "end"];

/// Checks names of elements that need none: identifiers, unique in the chain and not those of its ends.
fn check_element_names(design: &ChainSpec, check: &Check) -> Result<()> {
    let names = ElementSpec::names(&design.elements);
    for (i, element) in design.elements.iter().enumerate() {
        let optional_name = match element {
            ElementSpec::Fixed(FixedSpec { name, .. })
            | ElementSpec::Beam(BeamSpec { name, .. })
            | ElementSpec::Link(LinkSpec { name, .. })
            | ElementSpec::Mass(NamedMassSpec { name, .. })
            | ElementSpec::Module(ModuleSpec { name, .. }) => name,
            _ => continue,
        };
        let Some(name) = optional_name else { continue };
        let kind = element.kind_and_name().0;
        let check = check.key(&format!("elements[{i}].{kind}.name"));
        check.identifier(name)?;
        if ENDS.contains(&name.as_str()) {
            return check.fail(format!("\"{name}\" is the name of an end of every chain: expected another one"));
        }
        let others = names.iter().zip(&design.elements).enumerate();
        let others = others.filter(|&(other, (_, element))| {
            other != i && !matches!(element, ElementSpec::Frame(_) | ElementSpec::Body(_))
        });
        check.unique(name, others.map(|(_, (name, _))| name.as_str()))?;
    }
    Ok(())
}

/// Checks the elastic constants of the material called `name`, N/mm².
fn elastic_constants(name: &str, spec: &MaterialSpec, check: &Check) -> Result<Material> {
    let check = check.key(&format!("material.{name}"));
    Ok(Material {
        youngs_modulus: check.key("youngs_modulus_N_per_mm2").positive(spec.youngs_modulus)?,
        shear_modulus: check.key("shear_modulus_N_per_mm2").positive(spec.shear_modulus)?,
    })
}

/// Elastic constants of the material called `name`; `Err` names those that there are.
fn find_material(spec: &MachineSpec, name: &str, check: &Check) -> Result<Material> {
    let Some(material) = spec.material.get(name) else {
        let known = listed(spec.material.keys());
        let known = if known.is_empty() { "none".into() } else { known };
        return check.fail(format!("no material is called \"{name}\"; there are: {known}"));
    };
    elastic_constants(name, material, &check.root())
}

/// Index of the chain design called `name`; `Err` names those that there are.
fn design_index(spec: &MachineSpec, name: &str, check: &Check) -> Result<usize> {
    match spec.chain.iter().position(|chain| chain.name == name) {
        Some(index) => Ok(index),
        None => {
            let known = listed(spec.chain.iter().map(|chain| &chain.name));
            check.fail(format!("no chain is called \"{name}\"; there are: {known}"))
        }
    }
}

/// The strongest gravity that is not a mistake of the unit, m/s².
const STRONGEST_GRAVITY: f64 = 100.0;

/// Checks the acceleration of gravity in O, m/s²; that of the Earth where none is given.
fn resolve_gravity(spec: Option<[f64; 3]>, check: &Check) -> Result<Vector3<f64>> {
    let check = check.key("gravity_m_per_s2");
    let gravity = check.finite(spec.unwrap_or(GRAVITY))?;
    if gravity.norm() > STRONGEST_GRAVITY {
        let problem = format!(
            "expected a magnitude of at most {STRONGEST_GRAVITY} m/s², got the vector {:?}; is it in mm/s²?",
            gravity.as_slice()
        );
        return check.fail(problem);
    }
    Ok(gravity)
}

/// Checks the mass that moves with P, kg, and its centre, mm; `None` where nothing is given or the mass is 0.
fn resolve_platform_mass(spec: Option<&MassSpec>, check: &Check) -> Result<Option<PlatformMass>> {
    let Some(mass) = spec else { return Ok(None) };
    let kilograms = check.key("kg").not_negative(mass.kg)?;
    let at = check.key("at_mm").position(mass.at_mm)?;
    Ok((kilograms > 0.0).then_some(PlatformMass { kilograms, at }))
}

/// Most chains of a machine, and most coordinates of their joints and springs together: several times those of any
/// machine built, and few enough that a solve takes seconds at worst.
const MAX_CHAINS: usize = 50;
const MAX_COORDINATES: usize = 500;

const TO_RAD: f64 = std::f64::consts::PI / 180.0;

/// Direction of the tool from the spindle to its tip, a unit vector in platform axes, and where it comes from; `tip`: from P, mm.
fn resolve_tool_axis(spec: &MachineSpec, tip: Vector3<f64>, check: &Check) -> Result<(Vector3<f64>, ToolAxisSource)> {
    Ok(match (spec.platform.tool_axis, tip.try_normalize(SHORTEST_TOOL_MM)) {
        (Some(axis), _) => (check.direction(axis)?, ToolAxisSource::Given),
        (None, Some(axis)) => (axis, ToolAxisSource::TowardsTip),
        (None, None) => (Vector3::z(), ToolAxisSource::PlatformZ),
    })
}

/// A tool tip nearer to P than this has no direction from it, mm.
const SHORTEST_TOOL_MM: f64 = 1e-9;

/// Checks the task coordinates that the drives control: at least one, each once.
fn resolve_controls(spec: &MachineSpec, check: &Check) -> Result<Vec<Coordinate>> {
    let check = check.key("platform.controls");
    let mut controls = Vec::new();
    for (i, coordinate) in spec.platform.controls.iter().enumerate() {
        if spec.platform.controls[..i].contains(coordinate) {
            return check.item(i).fail("is named before; name each coordinate once".into());
        }
        controls.push(match coordinate {
            CoordinateSpec::X => Coordinate::Translation(0),
            CoordinateSpec::Y => Coordinate::Translation(1),
            CoordinateSpec::Z => Coordinate::Translation(2),
            CoordinateSpec::RotationX => Coordinate::Rotation(0),
            CoordinateSpec::RotationY => Coordinate::Rotation(1),
            CoordinateSpec::RotationZ => Coordinate::Rotation(2),
        });
    }
    if controls.is_empty() {
        return check.fail("must name at least one coordinate".into());
    }
    Ok(controls)
}

/// Checks the workspace box: its corners (mm), the lower one first.
fn resolve_workspace(spec: &MachineSpec, check: &Check) -> Result<WorkspaceBox> {
    let check = check.key("workspace");
    let min = check.key("min_mm").position(spec.workspace.min_mm)?;
    let max = check.key("max_mm").position(spec.workspace.max_mm)?;
    check.ordered_box(min, max)?;
    Ok(WorkspaceBox { min, max })
}

/// Checks the named locations of P: positions (mm) and names, each once.
fn resolve_points(spec: &MachineSpec, check: &Check) -> Result<Vec<NamedPoint>> {
    let mut points: Vec<NamedPoint> = Vec::new();
    for (i, point) in spec.point.iter().enumerate() {
        let check = check.key(&format!("point[{i}]"));
        check.key("name").readable(&point.name)?;
        check.key("name").unique(&point.name, points.iter().map(|p| p.name.as_str()))?;
        points.push(NamedPoint {
            name: point.name.clone(),
            position: check.key("position_mm").position(point.position_mm)?,
        });
    }
    Ok(points)
}

/// Checks all chain designs and builds the chain of each mount.
fn mounted_chains(spec: &MachineSpec, check: &Check) -> Result<Vec<Chain>> {
    for (i, chain) in spec.chain.iter().enumerate() {
        let check_design = check.key(&format!("chain[{i}]"));
        let check = check_design.key("name");
        check.readable(&chain.name)?;
        check_element_names(chain, &check_design)?;
        check.unique(&chain.name, spec.chain[..i].iter().map(|c| c.name.as_str()))?;
        let carries = spec.workpiece_carrier.as_ref().is_some_and(|carrier| carrier.chain == chain.name);
        let is_mounted = carries || spec.mount.iter().any(|mount| mount.chain == chain.name);
        if !is_mounted && !module::is_design_used(spec, &chain.name) {
            return check.fail(format!("chain \"{}\" is not mounted; add a [[mount]] or remove the chain", chain.name));
        }
    }
    if spec.mount.is_empty() {
        return check.key("mount").fail("a machine needs at least one mounted chain".into());
    }
    if spec.mount.len() > MAX_CHAINS {
        return check.key("mount").fail(format!("expected at most {MAX_CHAINS} chains, got {}", spec.mount.len()));
    }
    let mut coordinates = 0;
    let mut chains: Vec<Chain> = Vec::new();
    for (i, mount) in spec.mount.iter().enumerate() {
        let check_mount = check.key(&format!("mount[{i}]"));
        check_mount.key("name").identifier(&mount.name)?;
        check_mount.key("name").unique(&mount.name, chains.iter().map(|c| c.name.as_str()))?;
        let index = design_index(spec, &mount.chain, &check_mount.key("chain"))?;
        let check_chain = check.key(&format!("chain[{index}]"));
        let chain = chain::mounted_chain(spec, index, mount, &check_chain, &check_mount)?;
        coordinates += chain.coordinate_count();
        if coordinates > MAX_COORDINATES {
            let problem = format!(
                "expected at most {MAX_COORDINATES} coordinates of joints and springs in all chains, got {coordinates} \
                 up to this one"
            );
            return check_mount.key("chain").fail(problem);
        }
        chains.push(chain);
    }
    Ok(chains)
}

/// Pose of a frame (mm) given by its position and by two axes, or by roll, pitch and yaw in degrees.
fn resolve_frame(spec: &FrameSpec, check: &Check) -> Result<Pose> {
    let translation = check.key("position_mm").position(spec.position_mm)?;
    let rotation = match (spec.x_axis, spec.y_axis, spec.rotation_deg) {
        (None, None, None) => Matrix3::identity(),
        (None, None, Some(angles)) => {
            Pose::from_roll_pitch_yaw(check.key("rotation_deg").finite(angles)? * TO_RAD).rotation
        }
        (Some(x), Some(y), None) => {
            let x = check.key("x_axis").direction(x)?;
            let y = check.key("y_axis").direction(y)?;
            if x.dot(&y).abs() > 1e-9 {
                let problem = format!("must be perpendicular to x_axis, but their cosine is {}", x.dot(&y));
                return check.key("y_axis").fail(problem);
            }
            Matrix3::from_columns(&[x, y, x.cross(&y)])
        }
        _ => return check.fail("give x_axis and y_axis, or rotation_deg, or none of them".into()),
    };
    Ok(Pose { rotation, translation })
}

/// Compliance of the tool at T, in its axes (mm, rad; N, N·mm); `None` without a tool that bends.
fn resolve_tool_compliance(spec: &MachineSpec, check: &Check) -> Result<Option<Box<Matrix6<f64>>>> {
    let Some(tool) = &spec.platform.tool else { return Ok(None) };
    let matrix = tool.compliance.as_ref().map(|rows| check.key("compliance_mm_rad_N").positive_definite(rows));
    let cutter = tool.cutter.as_ref().map(|cutter| cutter_compliance(cutter, spec, &check.key("cutter")));
    match (matrix.transpose()?, cutter.transpose()?) {
        (Some(matrix), Some(cutter)) => Ok(Some(Box::new(matrix + cutter))),
        (Some(one), None) | (None, Some(one)) => Ok(Some(Box::new(one))),
        (None, None) => check.fail("give compliance_mm_rad_N, cutter or both".into()),
    }
}

/// Compliance of the end of a cutter, a round cantilever along z (mm, rad; N, N·mm).
fn cutter_compliance(cutter: &CutterSpec, spec: &MachineSpec, check: &Check) -> Result<Matrix6<f64>> {
    let diameter = check.key("diameter_mm").positive(cutter.diameter_mm)?;
    let length = check.key("stick_out_mm").positive(cutter.stick_out_mm)?;
    let material = find_material(spec, &cutter.material, &check.key("material"))?;
    let stiffness = beam_stiffness(&Section::Round { diameter }, &material, length);
    let Some(along_x) = stiffness.cholesky().map(|factor| factor.inverse()) else {
        return check.fail("has no stiffness in some direction, by these dimensions".into());
    };
    // From x along the beam to z along the tool.
    let axes = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
    let mut turn = Matrix6::zeros();
    turn.fixed_view_mut::<3, 3>(0, 0).copy_from(&axes);
    turn.fixed_view_mut::<3, 3>(3, 3).copy_from(&axes);
    Ok(turn * along_x * turn.transpose())
}
