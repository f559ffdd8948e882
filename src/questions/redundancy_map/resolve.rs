//! Checks of a redundancy map as written, which make it a [`RedundancyMapStudy`].

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::{
    RedundancyMapStudy, blocks, run,
    spec::{ConeSpec, RedundancyMapSpec},
};
use crate::{
    input::{
        check::Check,
        error::{Error, Result},
    },
    machine::Machine,
    process::{Placement, RedundancySettings},
    questions::{
        Question, Resolved, StudyContext, Template,
        over_workspace::{LoadCaseKeys, Region, Shown, load_case},
    },
    redundancy,
    spatial::{frame_about, rotation_exp},
    toolpath::{Sampling, Toolpath},
    work::Work,
};

/// Largest number of positions of a map, all tool directions together.
const MAX_POINTS: usize = 1_000_000;
/// Default step between values of γ, degrees.
const GAMMA_STEP_DEG: f64 = 10.0;
/// Default step between directions of the cutting force, degrees.
const PHI_STEP_DEG: f64 = 45.0;

impl Question for RedundancyMapStudy {
    type Spec = RedundancyMapSpec;
    type Shown = Shown;
    const NAME: &str = "a redundancy map";
    const TEMPLATE: Template = Template {
        name: "redundancy",
        about: "How a six-axis machine should rotate about its tool axis (γ), point by point",
        files: &[("study.toml", include_str!("template/study.toml"))],
    };
    const TABLES: &[&str] = &["redundancy_map"];

    /// Checks the map's table and makes its load case, grid and tool directions.
    fn resolve(spec: &RedundancyMapSpec, context: &StudyContext<'_>) -> Result<Resolved<Self>> {
        context.overrides.refuse_points(context.name)?;
        let phi_step_deg = Some(spec.phi_step_deg.unwrap_or(PHI_STEP_DEG));
        let (load_case, not_used, inputs) = load_case(context, LoadCaseKeys { phi_step_deg, uses_target: true })?;
        let machine = &load_case.machine;
        check_free_rotation(machine).or_else(|problem| context.check.root().key("machine").misfit(problem, ()))?;
        let check = &context.check;
        let axes = tool_directions(spec, machine, check)?;
        let to_tip = machine.home.pose.rotation * machine.tool_tip;
        let around_home = [machine.workspace.min + to_tip, machine.workspace.max + to_tip];
        let region =
            Region { min_mm: spec.min_mm, max_mm: spec.max_mm, grid: spec.grid, slices_z_mm: &spec.slices_z_mm };
        let (grid, slices_z, size) = region.checked_grid(context, around_home, MAX_POINTS / axes.len())?;
        let step_deg = spec.gamma_step_deg.unwrap_or(GAMMA_STEP_DEG);
        if !(1.0..=180.0).contains(&step_deg) {
            return check.key("gamma_step_deg").fail(format!("must be from 1 to 180, got {step_deg}"));
        }
        let default = RedundancySettings::default();
        let distance = spec.min_singularity_distance.unwrap_or(default.min_singularity_distance);
        let min_singularity_distance = check.key("min_singularity_distance").not_negative(distance)?;
        let settings = RedundancySettings { step_deg, min_singularity_distance, ..default };
        let shown = Shown { slices_z, not_used };
        Ok(Resolved { study: RedundancyMapStudy { load_case, grid, axes, settings }, shown, inputs: inputs.and(size) })
    }

    /// Returns the number of grid points of all tool directions.
    fn items(&self) -> (usize, &'static str) {
        (self.grid.len() * self.axes.len(), "places")
    }

    /// Returns the number of blocks of the map.
    fn pieces(&self) -> usize {
        blocks(self).count()
    }

    /// Computes all blocks of the map and keeps them in `work`.
    fn compute(&self, work: &Work) -> Result<()> {
        run(self, work).map(drop)
    }
}

/// Checks that `machine` can rotate freely about its tool axis. `Err` says why it cannot.
fn check_free_rotation(machine: &Machine) -> std::result::Result<(), String> {
    let somewhere =
        Toolpath::line(Vector3::zeros(), Vector3::x(), Sampling::default()).map_err(|fault| fault.to_string())?;
    match redundancy::check(machine, &Placement::default(), &somewhere) {
        Err(Error::Argument { problem, .. }) => Err(problem),
        other => other.map_err(|error| error.to_string()),
    }
}

/// Largest number of tool directions of a map.
const MAX_DIRECTIONS: usize = 64;
/// Default number of directions around a cone.
const DEFAULT_AROUND: usize = 8;

/// Returns the tool directions from the tip to the spindle, unit vectors in O.
pub(super) fn tool_directions(spec: &RedundancyMapSpec, machine: &Machine, check: &Check) -> Result<Vec<Vector3<f64>>> {
    match (&spec.tool_axes, &spec.cone) {
        (Some(_), Some(_)) => check.key("cone").fail("give one of tool_axes and cone".into()),
        (Some(axes), None) => {
            let check = check.key("tool_axes");
            if axes.is_empty() || axes.len() > MAX_DIRECTIONS {
                return check.fail(format!("must have 1 to {MAX_DIRECTIONS} directions, got {}", axes.len()));
            }
            axes.iter().enumerate().map(|(index, axis)| unit_direction(*axis, &check.item(index))).collect()
        }
        (None, Some(cone)) => cone_directions(cone, &check.key("cone")),
        (None, None) => Ok(vec![-(machine.home.pose.rotation * machine.tool_axes.column(2)).normalize()]),
    }
}

/// Returns `axis` as a unit vector. `Err` if it has no length.
fn unit_direction(axis: [f64; 3], check: &Check) -> Result<Vector3<f64>> {
    let axis = check.finite(axis)?;
    axis.try_normalize(1e-9).map_or_else(|| check.fail("has no length: expected a direction".into()), Ok)
}

/// Returns the middle of a cone and the directions around it, unit vectors in O.
fn cone_directions(cone: &ConeSpec, check: &Check) -> Result<Vec<Vector3<f64>>> {
    let about = unit_direction(cone.about, &check.key("about"))?;
    let half = cone.half_angle_deg;
    if !(half > 0.0 && half <= 180.0) {
        return check.key("half_angle_deg").fail(format!("must be above 0 and at most 180, got {half}"));
    }
    let count = cone.around.unwrap_or(DEFAULT_AROUND);
    if !(1..MAX_DIRECTIONS).contains(&count) {
        return check.key("around").fail(format!("must be 1 to {}, got {count}", MAX_DIRECTIONS - 1));
    }
    let (frame, (sin, cos)) = (frame_about(about), libm::sincos(half.to_radians()));
    let on_rim = |k: usize| {
        let rim = frame * Vector3::new(sin, 0.0, cos);
        rotation_exp(about * (TAU * k as f64 / count as f64)) * rim
    };
    Ok(std::iter::once(about).chain((0..count).map(on_rim)).collect())
}
