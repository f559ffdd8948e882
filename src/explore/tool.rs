//! Solves the tool at a place under a load: the results of `kinetostat point`, and the machine as lines.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Explorer, check_numbers};
use crate::{
    compensation::Target,
    input::error::{Error, Result},
    inspect::point::{NominalCommand, PointLoad, PointQuestion, solve},
    machine::{ChainError, Clearance, Machine},
    process::{ForceLaw, MillingForce},
    simulation::{Failure, SOLVED, Source, settled::equilibrium_under},
    spatial::{Pose, Skeleton, Wrench},
    statics::Status,
};

/// Step of the tool angle φ over a turn, degrees.
const TURN_STEP_DEG: u16 = 10;

/// A load on the tool.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LoadRequest {
    /// A wrench at P in axes of O, N and N·mm.
    Wrench([f64; 6]),
    /// A milling force on the tool tip.
    Milling {
        /// Radial force, N.
        radial: f64,
        /// Tangential force, N.
        tangential: f64,
        /// Axial force, N.
        axial: f64,
        /// Rotation of the force with φ, eq. (17).
        law: ForceLaw,
        /// Tool angle φ, degrees; in a plane, none means a whole turn.
        phi_deg: Option<f64>,
    },
}

impl LoadRequest {
    /// Returns the wrench, or the milling force at the tool angle requested; an error for an invalid number, or without tool angle.
    pub(super) fn single_load(&self) -> Result<PointLoad> {
        match self.loads()?.as_slice() {
            [single_load] => Ok(*single_load),
            _ => Err(Error::argument("load", "phi_deg: missing: expected the tool angle in degrees")),
        }
    }

    /// Returns the wrench, or the milling force at each tool angle requested (10° apart without one); an error for an invalid number.
    pub(super) fn loads(&self) -> Result<Vec<PointLoad>> {
        match *self {
            Self::Wrench(values) => {
                check_numbers("load", "numbers", &values)?;
                Ok(vec![PointLoad::Wrench(Wrench::new(values))])
            }
            Self::Milling { radial, tangential, axial, law, phi_deg } => {
                check_numbers("load", "numbers", &[radial, tangential, axial, phi_deg.unwrap_or(0.0)])?;
                let force = MillingForce { radial, tangential, axial, law };
                let load_at = |degrees: f64| PointLoad::Milling(force, degrees.to_radians());
                let turn = (0..360).step_by(TURN_STEP_DEG.into()).map(|degrees: u16| load_at(degrees.into()));
                Ok(phi_deg.map_or_else(|| turn.collect(), |phi| vec![load_at(phi)]))
            }
        }
    }
}

/// Commanded position or pose of P.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ToolPlace {
    /// Position of P in O, mm, oriented as at home.
    Position([f64; 3]),
    /// Pose of P: x, y, z in mm, roll, pitch and yaw in degrees about the fixed axes of O.
    Pose([f64; 6]),
}

/// A place of the tool and a load on it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolRequest {
    /// Commanded place.
    pub at: ToolPlace,
    /// Load on the tool.
    pub load: LoadRequest,
    /// Assembly error of each chain: rotation about its drive's axis, degrees; empty for none.
    #[serde(default)]
    pub assembly_deg: Vec<f64>,
}

/// Equilibrium and compensation of the tool at a place: mm, degrees, N and N·mm.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ToolResult {
    /// `solved`, or why there is no equilibrium.
    pub status: String,
    /// The reason in words, empty where solved.
    pub reason: String,
    /// Displacement of the tool tip, O axes, mm.
    pub displacement: Option<[f64; 3]>,
    /// The wrench at P.
    pub wrench: Option<[f64; 6]>,
    /// Drive positions at the nominal command.
    pub drives: Vec<f64>,
    /// Forces of the drives there.
    pub forces: Vec<f64>,
    /// Drive corrections Δρ; `None` if there is no compensation.
    pub corrections: Option<Vec<f64>>,
    /// Drive forces after compensation.
    pub forces_after: Option<Vec<f64>>,
    /// Why there is no compensation.
    pub not_compensated: Option<Failure>,
    /// Principal stiffnesses of the tool tip, ascending, N/mm.
    pub stiffness: Option<[f64; 3]>,
    /// Distance to singularity.
    pub conditioning: Option<f64>,
    /// The branch of an arm.
    pub branch: Option<String>,
    /// Distance of an arm from the singularities between branches.
    pub clearance: Option<Clearance>,
    /// The machine as commanded.
    pub commanded: Option<Skeleton>,
    /// The machine under load.
    pub loaded: Option<Skeleton>,
}

impl Explorer {
    /// Solves the tool at a place. A place that the machine cannot reach is a result.
    ///
    /// # Errors
    /// The place or the load is invalid.
    pub fn tool(&self, request: &ToolRequest) -> Result<ToolResult> {
        let errors = self.assembly_errors(&request.assembly_deg)?;
        let question = PointQuestion {
            machine: self.machine.clone(),
            machines: self.machines.with_errors(&errors),
            errors,
            place: command_from(request.at)?,
            load: request.load.single_load()?,
            target: Target::ToolTip,
        };
        let answer = match solve(&question) {
            Ok(answer) => answer,
            Err(unreachable) => return Ok(ToolResult::from_failure(&Failure::from(unreachable))),
        };
        let machine = &question.machine;
        let (commanded, loaded_skeleton) = match equilibrium_under(&question.machines, Source::All, &answer.task()) {
            Ok(settled) => (settled.commanded, Some(settled.loaded)),
            Err(_) => (machine.rigid_skeleton(&answer.nominal), None),
        };
        let is_solved = answer.loaded.status == Status::Solved;
        let loaded = &answer.loaded;
        let displacement = answer.zero.as_ref().ok().map(|zero| machine.tool_displacement(zero, &loaded.pose));
        let compensated = answer.compensated.as_ref();
        Ok(ToolResult {
            status: if is_solved { SOLVED.into() } else { loaded.status.label().into() },
            reason: if is_solved { String::new() } else { loaded.status.reason(machine) },
            displacement: displacement.filter(|_| is_solved).map(Into::into),
            wrench: Some(answer.wrench.to_array()),
            drives: shown_values(machine, &answer.nominal.drives),
            forces: if is_solved { loaded.drive_forces() } else { Vec::new() },
            corrections: answer.corrections().map(|change| shown_values(machine, &change)),
            forces_after: compensated.ok().map(|done| done.solution.drive_forces()),
            not_compensated: compensated.err().cloned(),
            stiffness: answer.tool_stiffness,
            conditioning: Some(answer.conditioning),
            branch: answer.branch.map(|(branch, _)| branch.label().into()),
            clearance: answer.branch.map(|(_, clearance)| clearance),
            commanded: Some(commanded),
            loaded: loaded_skeleton,
        })
    }

    /// Returns the chain errors of these angles, degrees; an error if their number or size is wrong.
    fn assembly_errors(&self, degrees: &[f64]) -> Result<Vec<ChainError>> {
        let chains = self.machine.chains.len();
        let problem = match degrees.iter().find_map(|angle| ChainError::rotation_problem(angle.to_radians())) {
            Some(problem) => problem,
            None if degrees.is_empty() || degrees.len() == chains => return Ok(self.machine.assembly_errors(degrees)),
            None => format!("expected {chains} angles, one for each chain, got {}", degrees.len()),
        };
        Err(Error::argument("assembly_deg", problem))
    }
}

impl ToolResult {
    /// Returns the result of a place that cannot be reached.
    fn from_failure(failure: &Failure) -> Self {
        Self {
            status: failure.status.to_string(),
            reason: failure.reason.clone(),
            not_compensated: Some(failure.clone()),
            ..Self::default()
        }
    }
}

/// Returns the commanded place, or an error for an invalid number.
pub(super) fn command_from(place: ToolPlace) -> Result<NominalCommand> {
    let numbers: &[f64] = match &place {
        ToolPlace::Position(numbers) => numbers,
        ToolPlace::Pose(numbers) => numbers,
    };
    check_numbers("at", "numbers", numbers)?;
    Ok(match place {
        ToolPlace::Position(position) => NominalCommand::Position(position.into()),
        ToolPlace::Pose([x, y, z, roll, pitch, yaw]) => {
            let rotation = Pose::from_roll_pitch_yaw(Vector3::new(roll, pitch, yaw).map(f64::to_radians));
            NominalCommand::Pose(Pose { translation: Vector3::new(x, y, z), ..rotation })
        }
    })
}

/// Returns drive values (mm, rad) in the units that pages show.
pub(super) fn shown_values(machine: &Machine, values: &[f64]) -> Vec<f64> {
    values.iter().zip(machine.drives()).map(|(value, (_, drive))| drive.motion.to_shown(*value)).collect()
}
