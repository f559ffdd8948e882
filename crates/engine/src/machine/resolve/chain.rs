//! The elements of a chain, one after the other, from a machine file as written.

use nalgebra::{Matrix6, Vector3};

use super::{
    TO_RAD,
    coupling::{self, ShownCoordinate},
    find_material, resolve_frame,
    section::resolve_section,
};
use crate::{
    input::{check::Check, error::Result},
    machine::{
        Chain, Drive, Motion, PassiveJoint, Route, Spring, SpringLaw, Step,
        section::{beam_stiffness, parallelogram_terms},
        spec::{
            AxisSpec, BeamSpec, ElementSpec, LinkSpec, MachineSpec, MountSpec, ParallelogramSpec, PointSpringSpec,
            PrismaticDriveSpec, RevoluteDriveSpec, ShownSpec,
        },
    },
    spatial::{Axis, Pose},
};

/// Numbers of passive coordinates begin here until it is known how many virtual ones there are.
const PASSIVE: usize = 1 << 30;

/// Builds the chain of `mount` from the chain design number `design`.
pub(super) fn mounted_chain(
    spec: &MachineSpec,
    design: usize,
    mount: &MountSpec,
    check_chain: &Check,
    check_mount: &Check,
) -> Result<Chain> {
    let mut builder = ChainBuilder {
        spec,
        chain: Chain {
            name: mount.name.clone(),
            route: Route::default(),
            virtual_count: 0,
            springs: Vec::new(),
            drives: Vec::new(),
            coupling: None,
            passive: Vec::new(),
        },
        route: Route::default(),
        prefix: String::new(),
        frames: Vec::new(),
        springs: Vec::new(),
        designs: Vec::new(),
        shown: Vec::new(),
    };
    builder.add_route(design, mount, check_mount)?;
    let chain = builder.finish()?;
    if chain.coordinate_count() == 0 {
        let problem = "the chain has neither a joint nor an elastic element (drive, beam, link, parallelogram)";
        return check_chain.key("elements").fail(problem.into());
    }
    Ok(chain)
}

/// Collects the steps, coordinates, joints and springs of one chain.
pub(super) struct ChainBuilder<'a> {
    pub spec: &'a MachineSpec,
    pub chain: Chain,
    /// The route under way: the chain's, or that of a loop of a module.
    pub route: Route,
    /// What stands before the names of joints: the mounts of the modules they belong to.
    pub prefix: String,
    /// Names of frames of the route under way.
    pub frames: Vec<(String, usize)>,
    /// Springs of it, with their places in the file: their frames may be named later.
    pub springs: Vec<(PointSpringSpec, Check)>,
    /// Designs under way, the outermost first.
    pub designs: Vec<usize>,
    /// What a pendant shows for each of its drives, where that is not the joint itself.
    pub shown: Vec<ShownCoordinate>,
}

impl ChainBuilder<'_> {
    /// Fills the present route with the elements of chain design number `design`, its ends placed by the frames of `mount`.
    pub fn add_route(&mut self, design: usize, mount: &MountSpec, check_mount: &Check) -> Result<()> {
        self.route.base = resolve_frame(&mount.base, &check_mount.key("base"))?;
        self.route.attachment = resolve_frame(&mount.platform, &check_mount.key("platform"))?.inverse();
        self.designs.push(design);
        let check = check_mount.root().key(&format!("chain[{design}]"));
        for (i, element) in self.spec.chain[design].elements.iter().enumerate() {
            self.add_element(element, i + 1, &check.key(&format!("elements[{i}]")))?;
        }
        self.designs.pop();
        self.add_springs()
    }

    /// Appends a rigid transform, or composes the last step with it if that is rigid, too.
    pub fn add_fixed(&mut self, pose: Pose) {
        match self.route.steps.last_mut() {
            Some(Step::Fixed(last)) => *last = last.compose(&pose),
            _ if pose == Pose::identity() => {}
            _ => self.route.steps.push(Step::Fixed(pose)),
        }
    }

    /// Appends an elastic motion along or about `axis`; returns its new chain coordinate.
    fn add_virtual_move(&mut self, motion: Motion, axis: Axis) -> usize {
        let coordinate = self.chain.virtual_count;
        self.chain.virtual_count += 1;
        self.route.steps.push(Step::Move { motion, axis, coordinate, sign: 1.0 });
        coordinate
    }

    /// Appends a motion by `sign` times the coordinate of passive joint `joint`.
    fn add_passive_move(&mut self, motion: Motion, axis: Axis, joint: usize, sign: f64) {
        self.route.steps.push(Step::Move { motion, axis, coordinate: PASSIVE + joint, sign });
    }

    /// Appends the elastic motions `moves`, with a spring of stiffness `law` over them.
    fn add_spring(&mut self, name: String, law: SpringLaw, moves: &[(Motion, Axis)]) {
        let start = self.chain.virtual_count;
        for &(motion, axis) in moves {
            self.add_virtual_move(motion, axis);
        }
        self.chain.springs.push(Spring { name, start, law });
    }

    /// Appends element number `number` (from 1) of a chain design.
    fn add_element(&mut self, element: &ElementSpec, number: usize, check: &Check) -> Result<()> {
        match element {
            ElementSpec::Fixed(fixed) => {
                let check = check.key("fixed");
                let mut pose =
                    Pose::from_roll_pitch_yaw(check.key("rotation_deg").finite(fixed.rotation_deg)? * TO_RAD);
                pose.translation = check.key("translation_mm").position(fixed.translation_mm)?;
                self.add_fixed(pose);
            }
            ElementSpec::PrismaticDrive(drive) => self.add_prismatic_drive(drive, &check.key("prismatic_drive"))?,
            ElementSpec::RevoluteDrive(drive) => self.add_revolute_drive(drive, &check.key("revolute_drive"))?,
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
                let index = self.add_passive(passive, &check)?;
                self.add_passive_move(Motion::Prismatic, to_axis(joint.axis), index, 1.0);
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
                let index = self.add_passive(passive, &check)?;
                self.add_passive_move(Motion::Revolute, to_axis(joint.axis), index, 1.0);
            }
            ElementSpec::Beam(beam) => {
                let name = self.spring_name(beam.name.as_deref(), "beam", number);
                self.add_beam(name, beam, &check.key("beam"))?
            }
            ElementSpec::Link(link) => {
                let name = self.spring_name(link.name.as_deref(), "link", number);
                self.add_link(name, link, &check.key("link"))?
            }
            ElementSpec::Parallelogram(spec) => self.add_parallelogram(spec, &check.key("parallelogram"))?,
            ElementSpec::UniversalJoint(joint) => {
                let check = check.key("universal_joint");
                let limits = joint.limits_deg.map(|limits| limits.to_vec());
                let [first, second] = joint.axes.map(to_axis);
                if first == second {
                    let got = ["x", "y", "z"][first.index()];
                    return check.key("axes").fail(format!("must be two different axes, got {got} twice"));
                }
                self.add_revolute_joints(&joint.name, &joint.axes, &joint.home_deg, limits, &check)?;
            }
            ElementSpec::SphericalJoint(joint) => {
                let check = check.key("spherical_joint");
                let limits = joint.limits_deg.map(|limits| limits.to_vec());
                let axes = [AxisSpec::X, AxisSpec::Y, AxisSpec::Z];
                self.add_revolute_joints(&joint.name, &axes, &joint.home_deg, limits, &check)?;
            }
            ElementSpec::Mass(mass) => self.add_mass(mass, &check.key("mass"))?,
            ElementSpec::Body(body) => self.add_body(body, &check.key("body"))?,
            ElementSpec::Frame(name) => self.name_frame(name, &check.key("frame"))?,
            ElementSpec::Spring(spring) => self.springs.push((spring.clone(), check.key("spring"))),
            ElementSpec::Module(module) => self.add_module(module, &check.key("module"))?,
        }
        Ok(())
    }

    /// Appends a drive that moves along an axis, in mm and N.
    fn add_prismatic_drive(&mut self, drive: &PrismaticDriveSpec, check: &Check) -> Result<()> {
        let drive_model = Drive {
            name: drive.name.clone(),
            motion: Motion::Prismatic,
            coordinate: self.chain.virtual_count,
            stiffness: in_series(
                check.key("stiffness_N_per_mm").positive(drive.stiffness.number())?,
                check.key("shaft_stiffness_N_per_mm").optional_positive(drive.shaft_stiffness)?,
            ),
            travel: check.key("travel_mm").interval(drive.travel_mm, 1.0)?,
            force_limit: check.key("force_limit_N").optional_positive(drive.force_limit)?,
            half_backlash: 0.5 * check.key("backlash_mm").optional_positive(drive.backlash_mm)?.unwrap_or(0.0),
            friction: check.key("friction_N").optional_positive(drive.friction)?.unwrap_or(0.0),
            home: check.key("home_mm").finite_scalar(drive.home_mm)?,
        };
        self.add_drive(drive_model, drive.axis, drive.shown.as_ref(), check)
    }

    /// Appends a drive that turns about an axis, in degrees and N·mm.
    fn add_revolute_drive(&mut self, drive: &RevoluteDriveSpec, check: &Check) -> Result<()> {
        let drive_model = Drive {
            name: drive.name.clone(),
            motion: Motion::Revolute,
            coordinate: self.chain.virtual_count,
            stiffness: in_series(
                check.key("stiffness_Nmm_per_rad").positive(drive.stiffness.number())?,
                check.key("shaft_stiffness_Nmm_per_rad").optional_positive(drive.shaft_stiffness)?,
            ),
            travel: check.key("travel_deg").interval(drive.travel_deg, TO_RAD)?,
            force_limit: check.key("torque_limit_Nmm").optional_positive(drive.torque_limit)?,
            half_backlash: 0.5
                * check.key("backlash_deg").optional_positive(drive.backlash_deg)?.unwrap_or(0.0)
                * TO_RAD,
            friction: check.key("friction_Nmm").optional_positive(drive.friction)?.unwrap_or(0.0),
            home: check.key("home_deg").finite_scalar(drive.home_deg)? * TO_RAD,
        };
        self.add_drive(drive_model, drive.axis, drive.shown.as_ref(), check)
    }

    /// Name of an elastic link in tables: the `name` given in the file, or else its `kind` and `number` in the chain, from 1.
    fn spring_name(&self, name: Option<&str>, kind: &str, number: usize) -> String {
        match name {
            Some(name) => format!("{}{name}", self.prefix),
            None => format!("{}{kind} (element {number})", self.prefix),
        }
    }

    /// Appends crossed passive revolute joints about `axes`, named after them, with home angles and limits in degrees.
    fn add_revolute_joints(
        &mut self,
        name: &str,
        axes: &[AxisSpec],
        home_deg: &[f64],
        limits_deg: Option<Vec<[f64; 2]>>,
        check: &Check,
    ) -> Result<()> {
        for (i, (&along, &home)) in axes.iter().zip(home_deg).enumerate() {
            let limits = limits_deg.as_ref().map(|limits| limits[i]);
            let joint = PassiveJoint {
                name: format!("{name}_{}", ["x", "y", "z"][to_axis(along).index()]),
                motion: Motion::Revolute,
                limits: check.key("limits_deg").item(i).interval(limits, TO_RAD)?,
                stiffness: 0.0,
                neutral: 0.0,
                home: check.key("home_deg").item(i).finite_scalar(home)? * TO_RAD,
                parallelogram_width: None,
            };
            let index = self.add_passive(joint, check)?;
            self.add_passive_move(Motion::Revolute, to_axis(along), index, 1.0);
        }
        Ok(())
    }

    /// Checks that a joint's name is an identifier that no other joint of the chain has.
    fn check_joint_name(&self, name: &str, check: &Check) -> Result<()> {
        let drives = self.chain.drives.iter().map(|drive| drive.name.as_str());
        let joints = self.chain.passive.iter().map(|joint| joint.name.as_str());
        check.key("name").identifier(name)?;
        check.key("name").unique(name, drives.chain(joints))
    }

    /// Registers a drive and appends its elastic motion, with its stiffness as the spring.
    fn add_drive(&mut self, mut drive: Drive, along: AxisSpec, shown: Option<&ShownSpec>, check: &Check) -> Result<()> {
        drive.name.insert_str(0, &self.prefix);
        self.check_joint_name(&drive.name, check)?;
        if let Some(shown) = shown {
            self.shown.push(ShownCoordinate {
                drive: self.chain.drives.len(),
                prefix: self.prefix.clone(),
                spec: shown.clone(),
                check: check.key("shown"),
            });
        }
        self.add_spring(drive.name.clone(), SpringLaw::Drive(drive.stiffness), &[(drive.motion, to_axis(along))]);
        self.chain.drives.push(drive);
        Ok(())
    }

    /// Registers a passive joint; returns its index among the chain's.
    fn add_passive(&mut self, mut joint: PassiveJoint, check: &Check) -> Result<usize> {
        joint.name.insert_str(0, &self.prefix);
        self.check_joint_name(&joint.name, check)?;
        self.chain.passive.push(joint);
        Ok(self.chain.passive.len() - 1)
    }

    /// Appends a beam: its advance along x and the six elastic motions of its end.
    fn add_beam(&mut self, name: String, beam: &BeamSpec, check: &Check) -> Result<()> {
        let length = check.key("length_mm").length(beam.length_mm)?;
        let advance = check.key("advance_mm").finite_scalar(beam.advance_mm.unwrap_or(length))?;
        let material = find_material(self.spec, &beam.material, &check.key("material"))?;
        let stiffness = beam_stiffness(&resolve_section(&beam.section, &check.key("section"))?, &material, length);
        self.add_elastic_link(name, advance, stiffness, check)
    }

    /// Appends a link given by its 6×6 stiffness or compliance (N, mm, rad).
    fn add_link(&mut self, name: String, link: &LinkSpec, check: &Check) -> Result<()> {
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
        self.add_elastic_link(name, advance, stiffness, check)
    }

    /// Appends a rigid advance along x, mm, and six elastic motions with `stiffness` (N, mm, rad).
    fn add_elastic_link(&mut self, name: String, advance: f64, stiffness: Matrix6<f64>, check: &Check) -> Result<()> {
        use {Axis::*, Motion::*};
        if stiffness.cholesky().is_none() {
            return check.fail("has no stiffness in some direction, by these dimensions".into());
        }
        self.add_fixed(Pose::from_translation(Vector3::x() * advance));
        let moves = [(Prismatic, X), (Prismatic, Y), (Prismatic, Z), (Revolute, X), (Revolute, Y), (Revolute, Z)];
        self.add_spring(name, SpringLaw::Link(Box::new(stiffness)), &moves);
        Ok(())
    }

    /// Appends a parallelogram: `Pa(q; θ) = Rz(q) Tx(L) · [Tx(θ1) Tz(θ2) Rx(θ3) Ry(θ4) Rz(θ5)] · Rz(−q)`.
    fn add_parallelogram(&mut self, spec: &ParallelogramSpec, check: &Check) -> Result<()> {
        use {Axis::*, Motion::*};
        let length = check.key("length_mm").length(spec.length_mm)?;
        let width = check.key("width_mm").positive(spec.width_mm)?;
        let material = find_material(self.spec, &spec.material, &check.key("material"))?;
        let bar = beam_stiffness(&resolve_section(&spec.bar_section, &check.key("bar_section"))?, &material, length);
        let joint = PassiveJoint {
            name: spec.name.clone(),
            motion: Revolute,
            limits: check.key("limits_deg").interval(spec.limits_deg, TO_RAD)?,
            stiffness: 0.0,
            neutral: 0.0,
            home: check.key("home_deg").finite_scalar(spec.home_deg)? * TO_RAD,
            parallelogram_width: Some(width),
        };
        let passive = self.add_passive(joint, check)?;
        self.add_passive_move(Revolute, Z, passive, 1.0);
        self.add_fixed(Pose::from_translation(Vector3::x() * length));
        let law = SpringLaw::Parallelogram {
            passive: PASSIVE + passive,
            terms: Box::new(parallelogram_terms(&bar, length, width)),
        };
        self.add_spring(
            format!("{}{}", self.prefix, spec.name),
            law,
            &[(Prismatic, X), (Prismatic, Z), (Revolute, X), (Revolute, Y), (Revolute, Z)],
        );
        self.add_passive_move(Revolute, Z, passive, -1.0);
        Ok(())
    }

    /// Returns the chain, its passive coordinates numbered behind the virtual ones and the coupling of its drives resolved.
    fn finish(mut self) -> Result<Chain> {
        let count = self.chain.virtual_count;
        let number = |coordinate: &mut usize| {
            if *coordinate >= PASSIVE {
                *coordinate = *coordinate - PASSIVE + count;
            }
        };
        self.chain.route = std::mem::take(&mut self.route);
        self.chain.route.for_each(&mut |route| {
            for step in &mut route.steps {
                if let Step::Move { coordinate, .. } = step {
                    number(coordinate);
                }
            }
        });
        for spring in &mut self.chain.springs {
            if let SpringLaw::Parallelogram { passive, .. } = &mut spring.law {
                number(passive);
            }
        }
        self.chain.coupling = coupling::resolve_coupling(&self.chain, &self.shown)?;
        Ok(self.chain)
    }
}

/// Stiffness of a gear in series with the shaft behind it; of the gear alone if no shaft is given.
fn in_series(gear: f64, shaft: Option<f64>) -> f64 {
    shaft.map_or(gear, |shaft| gear * shaft / (gear + shaft))
}

/// The axis as machine files name it.
fn to_axis(spec: AxisSpec) -> Axis {
    match spec {
        AxisSpec::X => Axis::X,
        AxisSpec::Y => Axis::Y,
        AxisSpec::Z => Axis::Z,
    }
}
