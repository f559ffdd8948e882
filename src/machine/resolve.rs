//! From a machine file as written to a checked machine.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::{
    Chain, Coordinate, Drive, Machine, Model, Motion, NamedPoint, PassiveJoint, Spring, SpringLaw, Step,
    ToolAxisSource, WorkspaceBox,
    kinematics::{self, Configuration},
    section::{Material, Section, beam_stiffness, parallelogram_terms},
    spec::{
        AxisSpec, BeamSpec, ChainSpec, CoordinateSpec, ElementSpec, FrameSpec, LinkSpec, MachineSpec, MaterialSpec,
        MountSpec, ParallelogramSpec, SectionSpec,
    },
};
use crate::{
    input::{check::Check, error::Result},
    spatial::{Axis, Pose, frame_about},
};

/// Checks `spec` and assembles the machine at home; `origin` names the file in errors.
pub(super) fn machine(spec: &MachineSpec, origin: &str) -> Result<Machine> {
    let check = Check::new(origin);
    check.schema(spec.schema)?;
    check.key("name").identifier(&spec.name)?;
    // Also those that nothing is made of.
    spec.material.iter().try_for_each(|(name, spec)| elastic_constants(name, spec, &check).map(drop))?;
    let chains = mounted_chains(spec, &check)?;
    let controls = controls(spec, &check)?;
    let drive_count: usize = chains.iter().map(|chain| chain.drives.len()).sum();
    if drive_count < controls.len() {
        let problem = format!("{} coordinates cannot be controlled by {drive_count} drives", controls.len());
        return check.key("platform.controls").fail(problem);
    }
    let home_check = check.key("home");
    let mut home_pose =
        Pose::from_roll_pitch_yaw(home_check.key("rotation_deg").finite(spec.home.rotation_deg)? * TO_RAD);
    home_pose.translation = home_check.key("position_mm").finite(spec.home.position_mm)?;
    let tool_tip = check.key("platform.tool_tip_mm").finite(spec.platform.tool_tip_mm)?;
    let (tool_axis, tool_axis_source) = tool_axis(spec, tool_tip, &check.key("platform.tool_axis"))?;
    let mut machine = Machine::of(Model {
        name: spec.name.clone(),
        title: spec.title.clone(),
        source: spec.source.clone(),
        home: Configuration::start(&chains, home_pose),
        home_sought: home_pose,
        reach: kinematics::reach(&chains, &Configuration::start(&chains, home_pose)),
        redundancy: 0,
        turns_with_position: false,
        chains,
        tool_tip,
        tool_axes: frame_about(tool_axis),
        tool_axis_source,
        controls,
        workspace: workspace(spec, &check)?,
        points: points(spec, &check)?,
    });
    machine.home = match machine.assemble_at_home() {
        Ok(home) => home,
        Err(unreachable) => return home_check.fail(format!("the chains cannot be assembled here: {unreachable}")),
    };
    // What was sought is only where the search began.
    machine.reach = kinematics::reach(&machine.chains, &machine.home);
    machine.redundancy = machine.redundancy_at_home();
    machine.turns_with_position = machine.turns_beside_home();
    Ok(machine)
}

fn elastic_constants(name: &str, spec: &MaterialSpec, check: &Check) -> Result<Material> {
    let check = check.key(&format!("material.{name}"));
    Ok(Material {
        youngs_modulus: check.key("youngs_modulus_N_per_mm2").positive(spec.youngs_modulus)?,
        shear_modulus: check.key("shear_modulus_N_per_mm2").positive(spec.shear_modulus)?,
    })
}

/// Most chains of a machine, and most coordinates of their joints and springs together: several times those of any
/// machine built, and few enough that a solve takes seconds at worst.
const MAX_CHAINS: usize = 50;
const MAX_COORDINATES: usize = 500;

const TO_RAD: f64 = std::f64::consts::PI / 180.0;

/// Direction of the tool from the spindle to its tip, a unit vector in platform axes.
fn tool_axis(spec: &MachineSpec, tip: Vector3<f64>, check: &Check) -> Result<(Vector3<f64>, ToolAxisSource)> {
    Ok(match (spec.platform.tool_axis, tip.try_normalize(SHORTEST_TOOL_MM)) {
        (Some(axis), _) => (check.direction(axis)?, ToolAxisSource::Given),
        (None, Some(axis)) => (axis, ToolAxisSource::TowardsTip),
        (None, None) => (Vector3::z(), ToolAxisSource::PlatformZ),
    })
}

/// A tool tip nearer to P than this has no direction from it, mm.
const SHORTEST_TOOL_MM: f64 = 1e-9;

fn controls(spec: &MachineSpec, check: &Check) -> Result<Vec<Coordinate>> {
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

fn workspace(spec: &MachineSpec, check: &Check) -> Result<WorkspaceBox> {
    let check = check.key("workspace");
    let min = check.key("min_mm").finite(spec.workspace.min_mm)?;
    let max = check.key("max_mm").finite(spec.workspace.max_mm)?;
    check.ordered_box(min, max)?;
    Ok(WorkspaceBox { min, max })
}

fn points(spec: &MachineSpec, check: &Check) -> Result<Vec<NamedPoint>> {
    let mut points: Vec<NamedPoint> = Vec::new();
    for (i, point) in spec.point.iter().enumerate() {
        let check = check.key(&format!("point[{i}]"));
        check.key("name").readable(&point.name)?;
        check.key("name").unique(&point.name, points.iter().map(|p| p.name.as_str()))?;
        points.push(NamedPoint {
            name: point.name.clone(),
            position: check.key("position_mm").finite(point.position_mm)?,
        });
    }
    Ok(points)
}

fn mounted_chains(spec: &MachineSpec, check: &Check) -> Result<Vec<Chain>> {
    for (i, chain) in spec.chain.iter().enumerate() {
        let check = check.key(&format!("chain[{i}].name"));
        check.readable(&chain.name)?;
        check.unique(&chain.name, spec.chain[..i].iter().map(|c| c.name.as_str()))?;
        if !spec.mount.iter().any(|mount| mount.chain == chain.name) {
            return check.fail(format!("chain \"{}\" is not mounted; add a [[mount]] or remove it", chain.name));
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
        let Some(index) = spec.chain.iter().position(|chain| chain.name == mount.chain) else {
            let known = spec.chain.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ");
            let problem = format!("no chain is called \"{}\"; there are: {known}", mount.chain);
            return check_mount.key("chain").fail(problem);
        };
        let check_chain = check.key(&format!("chain[{index}]"));
        let chain = mounted_chain(spec, &spec.chain[index], mount, &check_chain, &check_mount)?;
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

fn mounted_chain(
    spec: &MachineSpec,
    design: &ChainSpec,
    mount: &MountSpec,
    check_chain: &Check,
    check_mount: &Check,
) -> Result<Chain> {
    let mut builder = ChainBuilder { spec, chain: empty_chain(&mount.name), virtual_order: Vec::new() };
    builder.chain.base = frame(&mount.base, &check_mount.key("base"))?;
    builder.chain.attachment = frame(&mount.platform, &check_mount.key("platform"))?.inverse();
    for (i, element) in design.elements.iter().enumerate() {
        builder.element(element, i + 1, &check_chain.key(&format!("elements[{i}]")))?;
    }
    let chain = builder.finish();
    if chain.coordinate_count() == 0 {
        let problem = "the chain has neither a joint nor an elastic element (drive, beam, link, parallelogram)";
        return check_chain.key("elements").fail(problem.into());
    }
    Ok(chain)
}

fn empty_chain(name: &str) -> Chain {
    Chain {
        name: name.into(),
        base: Pose::identity(),
        steps: Vec::new(),
        attachment: Pose::identity(),
        virtual_count: 0,
        springs: Vec::new(),
        drives: Vec::new(),
        passive: Vec::new(),
    }
}

/// A frame given by two axes or by angles.
fn frame(spec: &FrameSpec, check: &Check) -> Result<Pose> {
    let translation = check.key("position_mm").finite(spec.position_mm)?;
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

/// Collects the steps and coordinates of one chain.
struct ChainBuilder<'a> {
    spec: &'a MachineSpec,
    chain: Chain,
    /// For each move step, in order: is its coordinate virtual? Passive indices are shifted behind the virtual at the end.
    virtual_order: Vec<bool>,
}

impl ChainBuilder<'_> {
    fn fixed(&mut self, pose: Pose) {
        match self.chain.steps.last_mut() {
            Some(Step::Fixed(last)) => *last = last.compose(&pose),
            _ if pose == Pose::identity() => {}
            _ => self.chain.steps.push(Step::Fixed(pose)),
        }
    }

    fn virtual_move(&mut self, motion: Motion, axis: Axis) -> usize {
        let coordinate = self.chain.virtual_count;
        self.chain.virtual_count += 1;
        self.chain.steps.push(Step::Move { motion, axis, coordinate, sign: 1.0 });
        self.virtual_order.push(true);
        coordinate
    }

    fn passive_move(&mut self, motion: Motion, axis: Axis, joint: usize, sign: f64) {
        self.chain.steps.push(Step::Move { motion, axis, coordinate: joint, sign });
        self.virtual_order.push(false);
    }

    /// Elastic motions of a group, and the spring over them.
    fn spring(&mut self, name: String, law: SpringLaw, moves: &[(Motion, Axis)]) {
        let start = self.chain.virtual_count;
        for &(motion, axis) in moves {
            self.virtual_move(motion, axis);
        }
        self.chain.springs.push(Spring { name, start, law });
    }

    fn element(&mut self, element: &ElementSpec, number: usize, check: &Check) -> Result<()> {
        match element {
            ElementSpec::Fixed(fixed) => {
                let check = check.key("fixed");
                let mut pose =
                    Pose::from_roll_pitch_yaw(check.key("rotation_deg").finite(fixed.rotation_deg)? * TO_RAD);
                pose.translation = check.key("translation_mm").finite(fixed.translation_mm)?;
                self.fixed(pose);
            }
            ElementSpec::PrismaticDrive(drive) => {
                let check = check.key("prismatic_drive");
                let drive_model = Drive {
                    name: drive.name.clone(),
                    motion: Motion::Prismatic,
                    coordinate: self.chain.virtual_count,
                    stiffness: check.key("stiffness_N_per_mm").positive(drive.stiffness)?,
                    travel: check.key("travel_mm").interval(drive.travel_mm, 1.0)?,
                    force_limit: check.key("force_limit_N").optional_positive(drive.force_limit)?,
                    home: check.key("home_mm").finite_scalar(drive.home_mm)?,
                };
                self.drive(drive_model, drive.axis, &check)?;
            }
            ElementSpec::RevoluteDrive(drive) => {
                let check = check.key("revolute_drive");
                let drive_model = Drive {
                    name: drive.name.clone(),
                    motion: Motion::Revolute,
                    coordinate: self.chain.virtual_count,
                    stiffness: check.key("stiffness_Nmm_per_rad").positive(drive.stiffness)?,
                    travel: check.key("travel_deg").interval(drive.travel_deg, TO_RAD)?,
                    force_limit: check.key("torque_limit_Nmm").optional_positive(drive.torque_limit)?,
                    home: check.key("home_deg").finite_scalar(drive.home_deg)? * TO_RAD,
                };
                self.drive(drive_model, drive.axis, &check)?;
            }
            ElementSpec::PrismaticJoint(joint) => {
                let check = check.key("prismatic_joint");
                let passive = PassiveJoint {
                    name: joint.name.clone(),
                    motion: Motion::Prismatic,
                    limits: check.key("limits_mm").interval(joint.limits_mm, 1.0)?,
                    stiffness: check.key("stiffness_N_per_mm").optional_positive(joint.stiffness)?.unwrap_or(0.0),
                    neutral: check.key("neutral_mm").finite_scalar(joint.neutral_mm)?,
                    home: check.key("home_mm").finite_scalar(joint.home_mm)?,
                    parallelogram_width: None,
                };
                let index = self.passive(passive, &check)?;
                self.passive_move(Motion::Prismatic, axis(joint.axis), index, 1.0);
            }
            ElementSpec::RevoluteJoint(joint) => {
                let check = check.key("revolute_joint");
                let passive = PassiveJoint {
                    name: joint.name.clone(),
                    motion: Motion::Revolute,
                    limits: check.key("limits_deg").interval(joint.limits_deg, TO_RAD)?,
                    stiffness: check.key("stiffness_Nmm_per_rad").optional_positive(joint.stiffness)?.unwrap_or(0.0),
                    neutral: check.key("neutral_deg").finite_scalar(joint.neutral_deg)? * TO_RAD,
                    home: check.key("home_deg").finite_scalar(joint.home_deg)? * TO_RAD,
                    parallelogram_width: None,
                };
                let index = self.passive(passive, &check)?;
                self.passive_move(Motion::Revolute, axis(joint.axis), index, 1.0);
            }
            ElementSpec::Beam(beam) => self.beam(format!("beam (element {number})"), beam, &check.key("beam"))?,
            ElementSpec::Link(link) => self.link(format!("link (element {number})"), link, &check.key("link"))?,
            ElementSpec::Parallelogram(spec) => self.parallelogram(spec, &check.key("parallelogram"))?,
        }
        Ok(())
    }

    fn unique_joint_name(&self, name: &str, check: &Check) -> Result<()> {
        let drives = self.chain.drives.iter().map(|drive| drive.name.as_str());
        let joints = self.chain.passive.iter().map(|joint| joint.name.as_str());
        check.key("name").identifier(name)?;
        check.key("name").unique(name, drives.chain(joints))
    }

    fn drive(&mut self, drive: Drive, along: AxisSpec, check: &Check) -> Result<()> {
        self.unique_joint_name(&drive.name, check)?;
        self.spring(drive.name.clone(), SpringLaw::Drive(drive.stiffness), &[(drive.motion, axis(along))]);
        self.chain.drives.push(drive);
        Ok(())
    }

    fn passive(&mut self, joint: PassiveJoint, check: &Check) -> Result<usize> {
        self.unique_joint_name(&joint.name, check)?;
        self.chain.passive.push(joint);
        Ok(self.chain.passive.len() - 1)
    }

    fn beam(&mut self, name: String, beam: &BeamSpec, check: &Check) -> Result<()> {
        let length = check.key("length_mm").positive(beam.length_mm)?;
        let advance = check.key("advance_mm").finite_scalar(beam.advance_mm.unwrap_or(length))?;
        let material = self.material(&beam.material, &check.key("material"))?;
        let stiffness = beam_stiffness(&section(&beam.section, &check.key("section"))?, &material, length);
        self.elastic_link(name, advance, stiffness, check)
    }

    fn link(&mut self, name: String, link: &LinkSpec, check: &Check) -> Result<()> {
        let advance = check.key("advance_mm").finite_scalar(link.advance_mm)?;
        let stiffness = match (&link.stiffness, &link.compliance) {
            (Some(rows), None) => check.key("stiffness_N_mm_rad").positive_definite(rows)?,
            (None, Some(rows)) => {
                let check = check.key("compliance_mm_rad_N");
                let compliance = check.positive_definite(rows)?;
                match compliance.cholesky() {
                    Some(factor) => factor.inverse(),
                    None => return check.fail("must be positive definite".into()),
                }
            }
            _ => return check.fail("give exactly one of stiffness_N_mm_rad and compliance_mm_rad_N".into()),
        };
        self.elastic_link(name, advance, stiffness, check)
    }

    fn elastic_link(&mut self, name: String, advance: f64, stiffness: Matrix6<f64>, check: &Check) -> Result<()> {
        use {Axis::*, Motion::*};
        if stiffness.cholesky().is_none() {
            return check.fail("has no stiffness in some direction, by these dimensions".into());
        }
        self.fixed(Pose::from_translation(Vector3::x() * advance));
        let moves = [(Prismatic, X), (Prismatic, Y), (Prismatic, Z), (Revolute, X), (Revolute, Y), (Revolute, Z)];
        self.spring(name, SpringLaw::Link(Box::new(stiffness)), &moves);
        Ok(())
    }

    /// `Pa(q; θ) = Rz(q) Tx(L) · [Tx(θ1) Tz(θ2) Rx(θ3) Ry(θ4) Rz(θ5)] · Rz(−q)`.
    fn parallelogram(&mut self, spec: &ParallelogramSpec, check: &Check) -> Result<()> {
        use {Axis::*, Motion::*};
        let length = check.key("length_mm").positive(spec.length_mm)?;
        let width = check.key("width_mm").positive(spec.width_mm)?;
        let material = self.material(&spec.material, &check.key("material"))?;
        let bar = beam_stiffness(&section(&spec.bar_section, &check.key("bar_section"))?, &material, length);
        let joint = PassiveJoint {
            name: spec.name.clone(),
            motion: Revolute,
            limits: check.key("limits_deg").interval(spec.limits_deg, TO_RAD)?,
            stiffness: 0.0,
            neutral: 0.0,
            home: check.key("home_deg").finite_scalar(spec.home_deg)? * TO_RAD,
            parallelogram_width: Some(width),
        };
        let passive = self.passive(joint, check)?;
        self.passive_move(Revolute, Z, passive, 1.0);
        self.fixed(Pose::from_translation(Vector3::x() * length));
        let law = SpringLaw::Parallelogram { passive, terms: Box::new(parallelogram_terms(&bar, length, width)) };
        self.spring(
            spec.name.clone(),
            law,
            &[(Prismatic, X), (Prismatic, Z), (Revolute, X), (Revolute, Y), (Revolute, Z)],
        );
        self.passive_move(Revolute, Z, passive, -1.0);
        Ok(())
    }

    fn material(&self, name: &str, check: &Check) -> Result<Material> {
        let Some(spec) = self.spec.material.get(name) else {
            let known = self.spec.material.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            let known = if known.is_empty() { "none".into() } else { known };
            return check.fail(format!("no material is called \"{name}\"; there are: {known}"));
        };
        elastic_constants(name, spec, &check.root())
    }

    /// Numbers the passive coordinates behind the virtual ones.
    fn finish(mut self) -> Chain {
        let shift = self.chain.virtual_count;
        let mut is_virtual = self.virtual_order.iter();
        for step in &mut self.chain.steps {
            if let Step::Move { coordinate, .. } = step
                && is_virtual.next() == Some(&false)
            {
                *coordinate += shift;
            }
        }
        for spring in &mut self.chain.springs {
            if let SpringLaw::Parallelogram { passive, .. } = &mut spring.law {
                *passive += shift;
            }
        }
        self.chain
    }
}

fn axis(spec: AxisSpec) -> Axis {
    match spec {
        AxisSpec::X => Axis::X,
        AxisSpec::Y => Axis::Y,
        AxisSpec::Z => Axis::Z,
    }
}

fn section(spec: &SectionSpec, check: &Check) -> Result<Section> {
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
