//! Displacements by single sources and by both, and how far their sum departs.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{SuperpositionStudy, rig::Rig};
use crate::{
    machine::{ChainError, Configuration, Machine},
    simulation::{Failure, Machines, Source},
    spatial::{Pose, Twist, Wrench},
    statics::{Workspace, aggregate_errors},
};

/// Displacement of the points of the platform that are followed, O axes, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Displacement {
    /// Of the tool tip T.
    pub tool: Vector3<f64>,
    /// Of the platform point P.
    pub platform: Vector3<f64>,
}

impl Displacement {
    /// When P moves from pose `from` to pose `to`.
    pub fn between(machine: &Machine, from: &Pose, to: &Pose) -> Self {
        Self { tool: machine.tool_displacement(from, to), platform: to.translation - from.translation }
    }

    /// By a small twist of P (mm, rad) at pose `at`, to first order.
    pub fn by_twist(machine: &Machine, twist: Twist, at: &Pose) -> Self {
        Self { tool: twist.shift(at.rotation * machine.tool_tip).linear, platform: twist.linear }
    }

    /// Of the point `followed`.
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

/// A point of the platform whose displacement is followed.
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

    /// Word used in tables.
    pub fn label(self) -> &'static str {
        match self {
            Followed::Tool => "tool",
            Followed::Platform => "platform",
        }
    }
}

/// How the effect of chain errors is had that is added to that of the cutting force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sum {
    /// From the nonlinear model with the errors as the only source: superposition.
    Superposition,
    /// By linear aggregation, eqs. (14) and (15).
    Aggregation,
}

impl Sum {
    /// Both, in table order.
    pub const ALL: [Sum; 2] = [Sum::Superposition, Sum::Aggregation];

    /// Word used in tables.
    pub fn label(self) -> &'static str {
        match self {
            Sum::Superposition => "superposition",
            Sum::Aggregation => "aggregation",
        }
    }
}

/// Superposition error of one sum at one followed point, worst over φ.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Worst {
    /// Largest superposition error, mm.
    pub superposition_error_mm: f64,
    /// The superposition error itself, O axes, mm.
    pub superposition_error_vector_mm: [f64; 3],
    /// φ at which it occurs, degrees.
    pub phi_deg: f64,
    /// Displacement by both sources at once at that φ, mm.
    pub simultaneous_mm: f64,
    /// Largest displacement by both sources at once over φ, mm.
    pub largest_simultaneous_mm: f64,
    /// Largest ratio of superposition error to displacement by both sources at the same φ; `None` where nothing moves. Large where
    /// the sources nearly cancel at some φ.
    pub ratio: Option<f64>,
    /// φ at which the ratio is largest, degrees; `None` where nothing moves.
    pub ratio_phi_deg: Option<f64>,
}

impl Worst {
    /// Largest superposition error over largest displacement; `None` where nothing moves.
    pub fn relative(&self) -> Option<f64> {
        Some(self.superposition_error_mm / self.largest_simultaneous_mm).filter(|ratio| ratio.is_finite())
    }
}

/// Superposition errors at a location, worst over φ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SuperpositionErrors {
    /// Of superposition, in the order of [`Followed::ALL`].
    pub superposition: [Worst; 2],
    /// Of linear aggregation, in the same order, or why it cannot be had.
    pub aggregation: Result<[Worst; 2], Failure>,
}

impl SuperpositionErrors {
    /// Superposition error at the tool tip, mm: what is held against the tolerance.
    pub fn superposed_tool_mm(&self) -> f64 {
        self.superposition[0].superposition_error_mm
    }

    /// Superposition error of `sum` at `followed`.
    pub fn worst(&self, sum: Sum, followed: Followed) -> Result<&Worst, &Failure> {
        match sum {
            Sum::Superposition => Ok(&self.superposition[followed as usize]),
            Sum::Aggregation => self.aggregation.as_ref().map(|worst| &worst[followed as usize]),
        }
    }
}

/// Displacements by each source and by all, from where the machine is zeroed.
pub(super) struct Displacements {
    /// `u(W)`, where weight is one of the sources.
    pub weight: Displacement,
    /// `u(F, 0)` at each φ.
    pub cutting: Vec<Displacement>,
    /// `u(0, E)`.
    pub assembly: Displacement,
    /// `u(F, E)` at each φ.
    pub both: Vec<Displacement>,
}

impl Displacements {
    /// `d` at each φ, with `errors` as the displacement by chain errors.
    pub fn superposition_errors(&self, errors: Displacement) -> impl Iterator<Item = Displacement> {
        let weight = self.weight;
        self.cutting.iter().zip(&self.both).map(move |(cutting, both)| *cutting + errors + weight - *both)
    }
}

/// One command to the nominal machine, at which the sources act one by one and together.
pub(super) struct Case<'a> {
    pub study: &'a SuperpositionStudy,
    /// Those of the study, with all of the errors.
    pub machines: &'a Machines,
    /// Nominal inverse kinematics of the command.
    pub at: Configuration,
    /// Where P of the nominal machine rests, unloaded: the commanded pose, unless weight or springs act.
    pub rest: Pose,
    /// From where displacement by all is measured: there, or from the commanded pose where weight is one of the sources.
    zero: Pose,
    /// Displacement by weight, where that is one of the sources.
    weight: Displacement,
}

impl<'a> Case<'a> {
    /// P of the nominal machine commanded to `position` mm.
    pub fn new(study: &'a SuperpositionStudy, machines: &'a Machines, position: Vector3<f64>) -> Result<Self, Failure> {
        let machine = &study.scene.machine;
        let at = machine.command(position)?;
        let rest_of = |machine: &Machine| -> Result<Pose, Failure> {
            let mut rig = Rig::rigid(machine, &at);
            rig.settle(&Wrench::zero())?;
            Ok(rig.state.pose)
        };
        let rest = rest_of(machines.actual(Source::Cutting))?;
        let (zero, weight) = match Source::parts(machine).contains(&Source::Weight) {
            true => (at.pose, Displacement::between(machine, &at.pose, &rest_of(machines.actual(Source::Weight))?)),
            false => (rest, Displacement::default()),
        };
        Ok(Self { study, machines, at, rest, zero, weight })
    }

    /// The machines with the errors multiplied by `factor`.
    pub fn real(&self, factor: f64) -> Machines {
        let errors: Vec<ChainError> = self.study.scene.errors.iter().map(|error| error.scale(factor)).collect();
        self.machines.with_errors(&errors)
    }

    /// Dead wrench at P of the cutting force times `factor`, at each φ.
    pub fn loads(&self, factor: f64) -> Vec<Wrench> {
        let tool = self.study.scene.machine.tool_at(&self.at.pose.rotation);
        self.study.scene.phis.iter().map(|phi| self.study.scene.force.wrench(*phi, &tool).scale(factor)).collect()
    }

    /// Displacements by the cutting force times `load` and the errors of `real`.
    pub fn displacements(&self, machines: &Machines, load: f64) -> Result<Displacements, Failure> {
        let machine = &self.study.scene.machine;
        let moved_from = |from: Pose| move |pose: &Pose| Displacement::between(machine, &from, pose);
        let moved = moved_from(self.rest);
        let (loads, phis) = (self.loads(load), &self.study.scene.phis);
        let cutting = Rig::rigid(machines.actual(Source::Cutting), &self.at).turn(&loads, phis)?;
        let mut alone = Rig::rigid(machines.actual(Source::Errors), &self.at);
        alone.settle(&Wrench::zero())?;
        let assembly = moved(&alone.state.pose);
        let both = match Source::parts(machine).contains(&Source::Weight) {
            true => Rig::rigid(&machines.real, &self.at).turn(&loads, phis)?,
            false => alone.turn(&loads, phis)?,
        };
        Ok(Displacements {
            weight: self.weight,
            cutting: cutting.iter().map(moved).collect(),
            assembly,
            both: both.iter().map(moved_from(self.zero)).collect(),
        })
    }

    /// Displacement by linear aggregation of the errors of `real`, eq. (15).
    fn aggregated(&self, machines: &Machines) -> Result<Displacement, Failure> {
        let machine = &self.study.scene.machine;
        let twist = aggregate_errors(machine, machines.actual(Source::Errors), &self.at, &mut Workspace::new(machine));
        match twist {
            Some(twist) => Ok(Displacement::by_twist(machine, twist, &self.at.pose)),
            None => {
                let reason = "the chains have no 6×6 stiffnesses with a regular sum, as eq. (15) needs them".into();
                Err(Failure { status: "singular".into(), reason })
            }
        }
    }

    /// Superposition errors under the cutting force times `load` and the errors of `real`.
    pub fn superposition_errors(&self, machines: &Machines, load: f64) -> Result<SuperpositionErrors, Failure> {
        let displacements = self.displacements(machines, load)?;
        let worst = |errors| Followed::ALL.map(|followed| self.worst(&displacements, errors, followed));
        Ok(SuperpositionErrors {
            superposition: worst(displacements.assembly),
            aggregation: self.aggregated(machines).map(worst),
        })
    }

    /// Superposition error at the tool tip, worst over φ, mm.
    pub fn superposed_tool_mm(&self, machines: &Machines, load: f64) -> Result<f64, Failure> {
        let displacements = self.displacements(machines, load)?;
        Ok(displacements.superposition_errors(displacements.assembly).map(|d| d.tool.norm()).fold(0.0, f64::max))
    }

    fn worst(&self, displacements: &Displacements, errors: Displacement, followed: Followed) -> Worst {
        let mut worst = Worst::default();
        let superposition_errors = displacements.superposition_errors(errors);
        for (index, ((superposition_error, both), phi)) in
            superposition_errors.zip(&displacements.both).zip(&self.study.scene.phis).enumerate()
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
