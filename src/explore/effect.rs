//! Computes the effect of one error source at a grid point of a map: tool displacement, and the deflected machine as lines.

use serde::{Deserialize, Serialize};

use super::{Explorer, check_numbers};
use crate::{
    compensation::TaskPoint,
    input::error::{Error, Result},
    machine::ZeroState,
    questions::map::WorkspaceMapStudy,
    simulation::{
        Failure, Machines, SOLVED, Source,
        settled::{LoadedLines, equilibrium_under},
    },
    spatial::Skeleton,
};

/// A map study, and the machines of its error sources.
#[derive(Debug)]
pub(super) struct Map {
    study: WorkspaceMapStudy,
    machines: Machines,
}

/// A grid point of a map, an error source, and a tool angle.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectRequest {
    /// Commanded position of P, mm.
    pub position: [f64; 3],
    /// The error source that acts.
    pub source: Source,
    /// Tool angle φ, degrees, where the cutting force acts; the nearest one of the map is used.
    pub phi_deg: Option<f64>,
}

/// Effect of an error source at a grid point, mm.
#[derive(Debug, Clone, Default, Serialize)]
pub struct EffectResult {
    /// `solved`, or why there is no solution.
    pub status: String,
    /// The reason in words, empty where solved.
    pub reason: String,
    /// The tool angle, degrees.
    pub phi_deg: Option<f64>,
    /// Displacement of the tool tip, O axes.
    pub displacement: Option<[f64; 3]>,
    /// The machine from which displacements are measured: as commanded, or in equilibrium under its weight and springs.
    pub before: Option<Skeleton>,
    /// The machine in equilibrium.
    pub loaded: Option<Skeleton>,
}

impl Map {
    /// Prepares the machines of a map study.
    pub(super) fn new(study: WorkspaceMapStudy) -> Result<Self> {
        Ok(Self { machines: study.load_case.machines()?, study })
    }

    /// Computes the effect of the requested source at tool angle `phi`, rad (`None` without cutting force); `Err` if there is no solution.
    fn effect(&self, request: &EffectRequest, phi: Option<f64>) -> std::result::Result<EffectResult, Failure> {
        let Self { study: WorkspaceMapStudy { load_case, .. }, machines } = self;
        let pose = load_case.machine.inverse_kinematics_at(request.position.into())?.pose;
        let task = load_case.task_point(pose, phi);
        let found = lines_under(machines, request.source, &task)?;
        Ok(EffectResult {
            status: SOLVED.into(),
            reason: String::new(),
            phi_deg: phi.map(f64::to_degrees),
            displacement: Some(found.tool_displacement_mm.into()),
            before: Some(found.commanded),
            loaded: Some(found.loaded),
        })
    }
}

/// Returns the machine at `task` under `source`, and in place of the commanded one that from which displacements are measured: in equilibrium under its
/// weight and springs, if it is zeroed so. `Err` where it has no equilibrium or cannot go there.
pub(super) fn lines_under(
    machines: &Machines,
    source: Source,
    task: &TaskPoint,
) -> std::result::Result<LoadedLines, Failure> {
    let found = equilibrium_under(machines, source, task)?;
    let nominal = machines.nominal(source);
    // Weight itself is measured from the rigid machine.
    let is_load = source != Source::Weight;
    let rests = is_load && nominal.zeroed == ZeroState::AtRest && nominal.own_load_text().is_some();
    let commanded = if rests { equilibrium_under(machines, Source::Weight, task)?.loaded } else { found.commanded };
    Ok(LoadedLines { commanded, ..found })
}

impl Explorer {
    /// Computes the effect of an error source at a grid point of the scene's map. A point without equilibrium is a result.
    ///
    /// # Errors
    /// There is no map, or the request is invalid.
    pub fn effect(&self, request: &EffectRequest) -> Result<EffectResult> {
        let map = self.map.as_ref().ok_or_else(|| Error::argument("effect", "there is no map in this scene"))?;
        check_numbers("position", "numbers", &request.position)?;
        let phi = match (request.source.has_cutting_force(), request.phi_deg) {
            (false, _) => None,
            (true, Some(degrees)) if degrees.is_finite() => Some(map.study.nearest_phi(degrees.to_radians())),
            (true, _) => {
                return Err(Error::argument("phi_deg", "expected the tool angle in degrees, where cutting force acts"));
            }
        };
        let failed = |Failure { status, reason }| EffectResult { status: status.into(), reason, ..Default::default() };
        Ok(map.effect(request, phi).unwrap_or_else(failed))
    }
}
