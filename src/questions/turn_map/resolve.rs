//! A map of turns among the questions, and from a study as written to a checked one.

use nalgebra::Vector3;

use super::{TurnMapStudy, axes::axes, blocks, run, spec::TurnMapSpec};
use crate::{
    input::error::{Error, Result},
    machine::Machine,
    process::{Placement, ToolTurn},
    questions::{
        Given, Question, Resolved, Template,
        over_workspace::{OwnKeys, Region, scene},
    },
    redundancy,
    simulation::Shown,
    toolpath::{Sampling, Toolpath},
    work::Work,
};

/// Most places of a map, all directions together.
const MAX_POINTS: usize = 1_000_000;
/// Steps between turns and directions of the force if the study does not say them, degrees.
const TURN_STEP_DEG: f64 = 10.0;
const PHI_STEP_DEG: f64 = 45.0;

impl Question for TurnMapStudy {
    type Spec = TurnMapSpec;
    type Shown = Shown;
    const NAME: &str = "a map of turns";
    const TEMPLATE: Template = Template {
        name: "turns",
        about: "How a six-axis machine should turn its tool about the tool's axis, place by place",
        files: &[("study.toml", include_str!("template/study.toml"))],
    };
    const TABLES: &[&str] = &["turns"];

    fn resolve(spec: &TurnMapSpec, given: &Given<'_>) -> Result<Resolved<Self>> {
        given.overrides.refuse_points(given.name)?;
        let phi_step_deg = Some(spec.phi_step_deg.unwrap_or(PHI_STEP_DEG));
        let (scene, inputs) = scene(given, OwnKeys { phi_step_deg, uses_target: true })?;
        let machine = &scene.machine;
        can_turn(machine).or_else(|problem| given.check.root().key("machine").fail(problem))?;
        let check = &given.check;
        let axes = axes(spec, machine, check)?;
        let to_tip = machine.home.pose.rotation * machine.tool_tip;
        let around_home = [machine.workspace.min + to_tip, machine.workspace.max + to_tip];
        let region =
            Region { min_mm: spec.min_mm, max_mm: spec.max_mm, grid: spec.grid, slices_z_mm: &spec.slices_z_mm };
        let (grid, shown, size) = region.checked(given, around_home, MAX_POINTS / axes.len())?;
        let step_deg = spec.turn_step_deg.unwrap_or(TURN_STEP_DEG);
        if !(1.0..=180.0).contains(&step_deg) {
            return check.key("turn_step_deg").fail(format!("must be from 1 to 180, got {step_deg}"));
        }
        let default = ToolTurn::default();
        let min_singularity_distance = match spec.min_singularity_distance {
            Some(given) => check.key("min_singularity_distance").not_negative(given)?,
            None => default.min_singularity_distance,
        };
        let turn = ToolTurn { step_deg, min_singularity_distance, ..default };
        Ok(Resolved { study: TurnMapStudy { scene, grid, axes, turn }, shown, inputs: inputs.and(size) })
    }

    fn items(&self) -> (usize, &'static str) {
        (self.grid.len() * self.axes.len(), "places")
    }

    fn pieces(&self) -> usize {
        blocks(self)
    }

    fn compute(&self, work: &Work) -> Result<()> {
        run(self, work).map(drop)
    }
}

/// Why `machine` cannot turn its tool freely, if it cannot.
fn can_turn(machine: &Machine) -> std::result::Result<(), String> {
    let somewhere =
        Toolpath::line(Vector3::zeros(), Vector3::x(), Sampling::default()).map_err(|fault| fault.to_string())?;
    match redundancy::check(machine, &Placement::default(), &somewhere) {
        Err(Error::Argument { problem, .. }) => Err(problem),
        other => other.map_err(|error| error.to_string()),
    }
}
