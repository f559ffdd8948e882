//! What happens with the tool at a place under a load: what `kinetostat point` tells, and the machine's lines.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Explorer, check};
use crate::{
    compensation::Target,
    input::error::{Error, Result},
    inspect::point::{Place, PointLoad, PointQuestion, solve},
    machine::{ChainError, Clearance, Machine, Skeleton},
    process::{ForceLaw, MillingForce},
    simulation::{Failure, SOLVED, Source, settled::settled},
    spatial::{Pose, Wrench},
    statics::Status,
};

/// Step of the tool angle over a turn, degrees.
const TURN_STEP_DEG: u16 = 10;

/// A load on the tool.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LoadAsked {
    /// At P in axes of O: N and N·mm.
    Wrench([f64; 6]),
    /// The milling force on the tool tip.
    Milling {
        /// N.
        radial: f64,
        /// N.
        tangential: f64,
        /// N.
        axial: f64,
        /// How it turns with φ.
        law: ForceLaw,
        /// φ; of a map, none means a whole turn.
        phi_deg: Option<f64>,
    },
}

impl LoadAsked {
    /// The load at one tool angle.
    ///
    /// # Errors
    /// A value that is no number of a load, or no tool angle.
    pub(super) fn one(&self) -> Result<PointLoad> {
        match self.all()?.as_slice() {
            [one] => Ok(*one),
            _ => Err(Error::argument("load", "phi_deg: missing: expected the tool angle in degrees")),
        }
    }

    /// The load at each tool angle that is asked for.
    ///
    /// # Errors
    /// A value that is no number of a load.
    pub(super) fn all(&self) -> Result<Vec<PointLoad>> {
        match *self {
            Self::Wrench(values) => {
                check("load", "numbers", &values)?;
                Ok(vec![PointLoad::Wrench(Wrench::new(values))])
            }
            Self::Milling { radial, tangential, axial, law, phi_deg } => {
                check("load", "numbers", &[radial, tangential, axial, phi_deg.unwrap_or(0.0)])?;
                let force = MillingForce { radial, tangential, axial, law };
                let at = |degrees: f64| PointLoad::Milling(force, degrees.to_radians());
                let turn = (0..360).step_by(TURN_STEP_DEG.into()).map(|degrees: u16| at(degrees.into()));
                Ok(phi_deg.map_or_else(|| turn.collect(), |phi| vec![at(phi)]))
            }
        }
    }
}

/// Where the tool is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PlaceOfTool {
    /// Of P, mm, oriented as at home.
    Position([f64; 3]),
    /// Of P: x, y, z in mm, roll, pitch and yaw in degrees about the fixed axes of O.
    Pose([f64; 6]),
}

/// A place of the tool and a load.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolAsked {
    /// Where.
    pub at: PlaceOfTool,
    /// What pushes it.
    pub load: LoadAsked,
    /// Assembly error of each chain: turn about its drive's axis, degrees; none if not given.
    #[serde(default)]
    pub assembly_deg: Vec<f64>,
}

/// What happens there: mm, degrees, N and N·mm.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ToolAnswer {
    /// `solved`, or why there is no equilibrium.
    pub status: String,
    /// The same in words, empty where it is solved.
    pub reason: String,
    /// Displacement of the tool tip, O axes, mm.
    pub displacement: Option<[f64; 3]>,
    /// The wrench at P.
    pub wrench: Option<[f64; 6]>,
    /// Drive positions at the nominal command.
    pub drives: Vec<f64>,
    /// Forces of the drives there.
    pub forces: Vec<f64>,
    /// What compensation adds to the drive positions, or why there is none.
    pub corrections: Option<Vec<f64>>,
    /// Forces of the drives after it.
    pub forces_after: Option<Vec<f64>>,
    /// Why there is no compensation.
    pub not_compensated: Option<Failure>,
    /// Principal stiffnesses of the tool tip, ascending, N/mm.
    pub stiffness: Option<[f64; 3]>,
    /// Distance to singularity.
    pub conditioning: Option<f64>,
    /// The branch of an arm.
    pub branch: Option<String>,
    /// How far it is from the singularities between branches.
    pub clearance: Option<Clearance>,
    /// The machine as commanded.
    pub commanded: Option<Skeleton>,
    /// The machine under load.
    pub loaded: Option<Skeleton>,
}

impl Explorer {
    /// Asks for the tool at a place.
    ///
    /// # Errors
    /// This is no place or no load. Where the machine cannot go is an answer.
    pub fn tool(&self, asked: &ToolAsked) -> Result<ToolAnswer> {
        let errors = self.assembly(&asked.assembly_deg)?;
        let question = PointQuestion {
            machine: self.machine.clone(),
            machines: self.machines.with_errors(&errors),
            errors,
            place: place(asked.at)?,
            load: asked.load.one()?,
            target: Target::ToolTip,
        };
        let answer = match solve(&question) {
            Ok(answer) => answer,
            Err(unreachable) => return Ok(ToolAnswer::refused(&Failure::from(unreachable))),
        };
        let machine = &question.machine;
        let (commanded, bent) = match settled(&question.machines, Source::All, &answer.task()) {
            Ok(settled) => (settled.commanded, Some(settled.loaded)),
            Err(_) => (machine.rigid_skeleton(&answer.nominal), None),
        };
        let is_solved = answer.loaded.status == Status::Solved;
        let loaded = &answer.loaded;
        let displacement = answer.zero.as_ref().ok().map(|zero| machine.tool_displacement(zero, &loaded.pose));
        let compensated = answer.compensated.as_ref();
        Ok(ToolAnswer {
            status: if is_solved { SOLVED.into() } else { loaded.status.label().into() },
            reason: if is_solved { String::new() } else { loaded.status.reason(machine) },
            displacement: displacement.filter(|_| is_solved).map(Into::into),
            wrench: Some(answer.wrench.to_array()),
            drives: shown(machine, &answer.nominal.drives),
            forces: if is_solved { loaded.drive_forces() } else { Vec::new() },
            corrections: answer.change().map(|change| shown(machine, &change)),
            forces_after: compensated.ok().map(|done| done.solution.drive_forces()),
            not_compensated: compensated.err().cloned(),
            stiffness: answer.tool_stiffness,
            conditioning: Some(answer.conditioning),
            branch: answer.branch.map(|(branch, _)| branch.label().into()),
            clearance: answer.branch.map(|(_, clearance)| clearance),
            commanded: Some(commanded),
            loaded: bent,
        })
    }

    fn assembly(&self, degrees: &[f64]) -> Result<Vec<ChainError>> {
        let chains = self.machine.chains.len();
        let problem = match degrees.iter().find_map(|angle| ChainError::too_large(angle.to_radians())) {
            Some(problem) => problem,
            None if degrees.is_empty() || degrees.len() == chains => return Ok(self.machine.assembly_errors(degrees)),
            None => format!("expected {chains} angles, one for each chain, got {}", degrees.len()),
        };
        Err(Error::argument("assembly_deg", problem))
    }
}

impl ToolAnswer {
    fn refused(failure: &Failure) -> Self {
        Self {
            status: failure.status.to_string(),
            reason: failure.reason.clone(),
            not_compensated: Some(failure.clone()),
            ..Self::default()
        }
    }
}

fn place(asked: PlaceOfTool) -> Result<Place> {
    let numbers: &[f64] = match &asked {
        PlaceOfTool::Position(numbers) => numbers,
        PlaceOfTool::Pose(numbers) => numbers,
    };
    check("at", "numbers", numbers)?;
    Ok(match asked {
        PlaceOfTool::Position(position) => Place::Position(position.into()),
        PlaceOfTool::Pose([x, y, z, roll, pitch, yaw]) => {
            let turned = Pose::from_roll_pitch_yaw(Vector3::new(roll, pitch, yaw).map(f64::to_radians));
            Place::Pose(Pose { translation: Vector3::new(x, y, z), ..turned })
        }
    })
}

/// Drive values as shown.
pub(super) fn shown(machine: &Machine, values: &[f64]) -> Vec<f64> {
    values.iter().zip(machine.drives()).map(|(value, (_, drive))| drive.motion.shown(*value)).collect()
}
