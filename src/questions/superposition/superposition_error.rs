//! Displacements by single sources and by all at once, and the superposition error of their sum.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{SuperpositionStudy, rig::LockedMachine};
use crate::{
    machine::{ChainError, Configuration, Machine},
    simulation::{Failure, Machines, Source},
    spatial::{Pose, Twist, Wrench},
    statics::{Scratch, aggregate_errors},
};

/// Displacement of tool tip and platform point, O axes, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Displacement {
    /// Displacement of the tool tip T.
    pub tool: Vector3<f64>,
    /// Displacement of the platform point P.
    pub platform: Vector3<f64>,
}

impl Displacement {
    /// Returns the displacement of tool tip and P (O axes, mm) when P moves from pose `from` to pose `to`, both in O.
    pub fn between(machine: &Machine, from: &Pose, to: &Pose) -> Self {
        Self { tool: machine.tool_displacement(from, to), platform: to.translation - from.translation }
    }

    /// Returns the displacement of tool tip and P by a small twist of P (mm, rad) at pose `at`, to first order.
    pub fn by_twist(machine: &Machine, twist: Twist, at: &Pose) -> Self {
        Self { tool: twist.shift(at.rotation * machine.tool_tip).linear, platform: twist.linear }
    }

    /// Returns the displacement of the point `followed`, O axes, mm.
    pub fn of(&self, followed: Followed) -> Vector3<f64> {
        match followed {
            Followed::Tool => self.tool,
            Followed::Platform => self.platform,
        }
    }
}

impl std::ops::Add for Displacement {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { tool: self.tool + other.tool, platform: self.platform + other.platform }
    }
}

impl std::ops::Sub for Displacement {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { tool: self.tool - other.tool, platform: self.platform - other.platform }
    }
}

/// A point of the platform whose displacement is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Followed {
    /// The tool tip T.
    Tool,
    /// The platform point P.
    Platform,
}

impl Followed {
    /// Both, in table order.
    pub const ALL: [Followed; 2] = [Followed::Tool, Followed::Platform];

    /// Returns the word for the followed point in tables.
    pub fn label(self) -> &'static str {
        match self {
            Followed::Tool => "tool",
            Followed::Platform => "platform",
        }
    }
}

/// Model of the displacement by chain errors that is added to that by the cutting force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sum {
    /// Nonlinear model with the errors as the only source: superposition.
    Superposition,
    /// Linear aggregation, eqs. (14) and (15).
    Aggregation,
}

impl Sum {
    /// Both, in table order.
    pub const ALL: [Sum; 2] = [Sum::Superposition, Sum::Aggregation];

    /// Returns the word for the sum in tables.
    pub fn label(self) -> &'static str {
        match self {
            Sum::Superposition => "superposition",
            Sum::Aggregation => "aggregation",
        }
    }
}

/// Superposition error of one sum at one point of the platform, worst over φ.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Worst {
    /// Largest superposition error, mm.
    pub superposition_error_mm: f64,
    /// The largest superposition error as a vector, O axes, mm.
    pub superposition_error_vector_mm: [f64; 3],
    /// φ at which it occurs, degrees.
    pub phi_deg: f64,
    /// Displacement by both sources at once at that φ, mm.
    pub simultaneous_mm: f64,
    /// Largest displacement by both sources at once over φ, mm.
    pub largest_simultaneous_mm: f64,
    /// Largest ratio of superposition error to displacement by both at the same φ, large where sources nearly cancel; `None` where nothing moves.
    pub ratio: Option<f64>,
    /// φ at which the ratio is largest, degrees; `None` where nothing moves.
    pub ratio_phi_deg: Option<f64>,
}

impl Worst {
    /// Returns the largest superposition error over the largest displacement; `None` where nothing moves.
    pub fn relative(&self) -> Option<f64> {
        Some(self.superposition_error_mm / self.largest_simultaneous_mm).filter(|ratio| ratio.is_finite())
    }
}

/// Superposition errors at a location, worst over φ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SuperpositionErrors {
    /// Errors of superposition, in the order of [`Followed::ALL`].
    pub superposition: [Worst; 2],
    /// Errors of linear aggregation, in the same order, or why there are none.
    pub aggregation: Result<[Worst; 2], Failure>,
}

impl SuperpositionErrors {
    /// Returns the superposition error at the tool tip, mm, which is compared with the tolerance.
    pub fn superposed_tool_mm(&self) -> f64 {
        self.superposition[0].superposition_error_mm
    }

    /// Returns the superposition error of `sum` at `followed`.
    pub fn worst(&self, sum: Sum, followed: Followed) -> Result<&Worst, &Failure> {
        match sum {
            Sum::Superposition => Ok(&self.superposition[followed as usize]),
            Sum::Aggregation => self.aggregation.as_ref().map(|worst| &worst[followed as usize]),
        }
    }
}

/// Displacements by each source and by all, from the pose in which the machine is calibrated.
pub(super) struct Displacements {
    /// `u(W)`, by weight where that is one of the sources, else 0.
    pub weight: Displacement,
    /// `u(F, 0)`, by the cutting force at each φ.
    pub cutting: Vec<Displacement>,
    /// `u(0, E)`, by the chain errors.
    pub assembly: Displacement,
    /// `u(F, E)`, by all sources at each φ.
    pub both: Vec<Displacement>,
}

impl Displacements {
    /// Returns the superposition error `d` at each φ, with `errors` as the displacement by chain errors.
    pub fn errors_over_phi(&self, errors: Displacement) -> impl Iterator<Item = Displacement> {
        let weight = self.weight;
        self.cutting.iter().zip(&self.both).map(move |(cutting, both)| *cutting + errors + weight - *both)
    }
}

/// One command of P, at which the sources act one by one and together.
pub(super) struct Case<'a> {
    pub study: &'a SuperpositionStudy,
    /// Machines with the chain errors of the study.
    pub machines: &'a Machines,
    /// Configuration of the nominal machine at the command.
    pub at: Configuration,
    /// Pose of P of the nominal machine at rest, unloaded: the commanded pose, unless weight or springs act.
    pub rest: Pose,
    /// Pose from which displacement by all is measured: `rest`, or the commanded pose where weight is one of the sources.
    zero: Pose,
    /// Displacement by weight, where that is one of the sources.
    weight: Displacement,
}

impl<'a> Case<'a> {
    /// Commands P of the nominal machine to `position`, O, mm; `Err` if it cannot be reached or has no equilibrium.
    pub fn new(study: &'a SuperpositionStudy, machines: &'a Machines, position: Vector3<f64>) -> Result<Self, Failure> {
        let machine = &study.load_case.machine;
        let at = machine.inverse_kinematics_at(position)?;
        let rest_of = |machine: &Machine| -> Result<Pose, Failure> {
            let mut rig = LockedMachine::at_command(machine, &at);
            rig.equilibrium_under(&Wrench::zero())?;
            Ok(rig.state.pose)
        };
        let rest = rest_of(machines.actual(Source::Cutting))?;
        let (zero, weight) = match Source::parts(machine).contains(&Source::Weight) {
            true => (at.pose, Displacement::between(machine, &at.pose, &rest_of(machines.actual(Source::Weight))?)),
            false => (rest, Displacement::default()),
        };
        Ok(Self { study, machines, at, rest, zero, weight })
    }

    /// Returns the nominal machine and the actual ones with the chain errors of the study times `factor`.
    pub fn machines_with_errors(&self, factor: f64) -> Machines {
        let errors: Vec<ChainError> = self.study.load_case.errors.iter().map(|error| error.scale(factor)).collect();
        self.machines.with_errors(&errors)
    }

    /// Returns the wrench at P, O axes, of the cutting force times `factor`, at each φ.
    pub fn cutting_wrenches(&self, factor: f64) -> Vec<Wrench> {
        let case = &self.study.load_case;
        let tool = case.machine.tool_at(&self.at.pose.rotation);
        case.phis.iter().map(|phi| case.force.wrench(*phi, &tool).scale(factor)).collect()
    }

    /// Solves the displacements by the cutting force times `load_factor`, by chain errors of `machines`, and by both. `Err` if one fails.
    pub fn displacements(&self, machines: &Machines, load_factor: f64) -> Result<Displacements, Failure> {
        let machine = &self.study.load_case.machine;
        let displacement_from = |from: Pose| move |pose: &Pose| Displacement::between(machine, &from, pose);
        let displacement = displacement_from(self.rest);
        let (loads, phis) = (self.cutting_wrenches(load_factor), &self.study.load_case.phis);
        let cutting =
            LockedMachine::at_command(machines.actual(Source::Cutting), &self.at).poses_under(&loads, phis)?;
        let mut alone = LockedMachine::at_command(machines.actual(Source::Geometry), &self.at);
        alone.equilibrium_under(&Wrench::zero())?;
        let assembly = displacement(&alone.state.pose);
        let both = match Source::parts(machine).contains(&Source::Weight) {
            true => LockedMachine::at_command(&machines.actual, &self.at).poses_under(&loads, phis)?,
            false => alone.poses_under(&loads, phis)?,
        };
        Ok(Displacements {
            weight: self.weight,
            cutting: cutting.iter().map(displacement).collect(),
            assembly,
            both: both.iter().map(displacement_from(self.zero)).collect(),
        })
    }

    /// Returns the displacement by linear aggregation of the chain errors of `machines`, eq. (15).
    fn aggregated_displacement(&self, machines: &Machines) -> Result<Displacement, Failure> {
        let machine = &self.study.load_case.machine;
        let twist = aggregate_errors(machine, machines.actual(Source::Geometry), &self.at, &mut Scratch::new(machine));
        match twist {
            Some(twist) => Ok(Displacement::by_twist(machine, twist, &self.at.pose)),
            None => {
                let reason = "the chains have no 6×6 stiffnesses with a regular sum, as eq. (15) needs them".into();
                Err(Failure { status: "singular".into(), reason })
            }
        }
    }

    /// Computes the superposition errors, worst over φ, mm, at tool tip and platform point, under the cutting force times `load_factor` and the
    /// chain errors of `machines`. `Err` if an equilibrium is missing; a failed aggregation is in the result.
    pub fn superposition_errors(&self, machines: &Machines, load_factor: f64) -> Result<SuperpositionErrors, Failure> {
        let displacements = self.displacements(machines, load_factor)?;
        let worst = |errors| Followed::ALL.map(|followed| self.worst_over_phi(&displacements, errors, followed));
        Ok(SuperpositionErrors {
            superposition: worst(displacements.assembly),
            aggregation: self.aggregated_displacement(machines).map(worst),
        })
    }

    /// Computes the superposition error at the tool tip, worst over φ, mm; arguments and `Err` as of [`Case::superposition_errors`].
    pub fn superposed_tool_mm(&self, machines: &Machines, load_factor: f64) -> Result<f64, Failure> {
        let displacements = self.displacements(machines, load_factor)?;
        Ok(displacements.errors_over_phi(displacements.assembly).map(|d| d.tool.norm()).fold(0.0, f64::max))
    }

    /// Returns the superposition error at `followed`, worst over φ, with `errors` as the displacement by chain errors.
    fn worst_over_phi(&self, displacements: &Displacements, errors: Displacement, followed: Followed) -> Worst {
        let mut worst = Worst::default();
        let superposition_errors = displacements.errors_over_phi(errors);
        for (index, ((superposition_error, both), phi)) in
            superposition_errors.zip(&displacements.both).zip(&self.study.load_case.phis).enumerate()
        {
            let (vector, simultaneous) = (superposition_error.of(followed), both.of(followed).norm());
            if index == 0 || vector.norm() > worst.superposition_error_mm {
                worst.superposition_error_mm = vector.norm();
                worst.superposition_error_vector_mm = vector.into();
                worst.phi_deg = phi.to_degrees();
                worst.simultaneous_mm = simultaneous;
            }
            worst.largest_simultaneous_mm = worst.largest_simultaneous_mm.max(simultaneous);
            let ratio = Some(vector.norm() / simultaneous).filter(|ratio| ratio.is_finite());
            if ratio > worst.ratio {
                worst.ratio = ratio;
                worst.ratio_phi_deg = Some(phi.to_degrees());
            }
        }
        worst
    }
}
