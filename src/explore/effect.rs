//! What one source of error does to the machine of a map at one place: how far it moves the tool, and its lines.

use serde::{Deserialize, Serialize};

use super::{Explorer, check};
use crate::{
    input::error::{Error, Result},
    machine::{Skeleton, Zeroed},
    questions::map::WorkspaceMapStudy,
    simulation::{Failure, Machines, SOLVED, Source, settled::settled},
};

/// A map, and the machines that answer for its sources.
#[derive(Debug)]
pub(super) struct Map {
    study: WorkspaceMapStudy,
    machines: Machines,
}

/// A place of a map, a source, and the angle of the tool.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectAsked {
    /// Commanded position of P, mm.
    pub position: [f64; 3],
    /// What acts.
    pub source: Source,
    /// φ in degrees, where the cutting force acts: the nearest of the map's tool angles is taken.
    pub phi_deg: Option<f64>,
}

/// What happens there, mm.
#[derive(Debug, Clone, Default, Serialize)]
pub struct EffectAnswer {
    /// `solved`, or why there is no answer.
    pub status: String,
    /// The same in words, empty where it is solved.
    pub reason: String,
    /// The tool angle, degrees.
    pub phi_deg: Option<f64>,
    /// Displacement of the tool tip, O axes.
    pub displacement: Option<[f64; 3]>,
    /// The machine as displacements are measured from: as commanded, or at rest under its weight and springs.
    pub before: Option<Skeleton>,
    /// The machine in equilibrium.
    pub loaded: Option<Skeleton>,
}

impl Map {
    pub(super) fn new(study: WorkspaceMapStudy) -> Result<Self> {
        Ok(Self { machines: study.scene.machines()?, study })
    }

    fn effect(&self, asked: &EffectAsked, phi: Option<f64>) -> std::result::Result<EffectAnswer, Failure> {
        let Self { study: WorkspaceMapStudy { scene, .. }, machines } = self;
        let pose = scene.machine.command(asked.position.into())?.pose;
        let task = scene.task(pose, phi);
        let found = settled(machines, asked.source, &task)?;
        let nominal = machines.nominal(asked.source);
        // Weight itself is measured from the rigid machine.
        let is_load = asked.source != Source::Weight;
        let rests = is_load && nominal.zeroed == Zeroed::AtRest && nominal.own_forces().is_some();
        let before = if rests { settled(machines, Source::Weight, &task)?.loaded } else { found.commanded };
        Ok(EffectAnswer {
            status: SOLVED.into(),
            reason: String::new(),
            phi_deg: phi.map(f64::to_degrees),
            displacement: Some(found.tool_displacement_mm.into()),
            before: Some(before),
            loaded: Some(found.loaded),
        })
    }
}

impl Explorer {
    /// What a source does at a place of the scene's map.
    ///
    /// # Errors
    /// There is no map, or this is no place of one. Where there is no equilibrium is an answer.
    pub fn effect(&self, asked: &EffectAsked) -> Result<EffectAnswer> {
        let map = self.map.as_ref().ok_or_else(|| Error::argument("effect", "there is no map in this scene"))?;
        check("position", "numbers", &asked.position)?;
        let phi = match (asked.source.has_cutting_force(), asked.phi_deg) {
            (false, _) => None,
            (true, Some(degrees)) if degrees.is_finite() => Some(map.study.nearest_phi(degrees.to_radians())),
            (true, _) => {
                return Err(Error::argument("phi_deg", "expected the tool angle in degrees, where cutting force acts"));
            }
        };
        let failed = |Failure { status, reason }| EffectAnswer { status: status.into(), reason, ..Default::default() };
        Ok(map.effect(asked, phi).unwrap_or_else(failed))
    }
}
