//! The table `redundancy` of a process file: how the redundancy angle γ is chosen, as written and checked.

use serde::Deserialize;

use crate::{
    input::{check::Check, error::Result},
    machine::{Machine, Motion},
    process::{GammaChoice, RedundancyCost, RedundancyObjective, RedundancySettings},
};

/// The table `redundancy`: how the redundancy angle γ is chosen, as written.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RedundancySpec {
    /// How γ is chosen at the points of a path.
    #[serde(default)]
    pub gamma: GammaChoice,
    /// Which component of the deviation from the path counts.
    #[serde(default)]
    pub cost: RedundancyCost,
    /// Which statistic over the path is minimised.
    #[serde(default)]
    pub objective: RedundancyObjective,
    /// Step between neighbouring angles of the search lattice; 5 if not given.
    pub step_deg: Option<f64>,
    /// Least and largest γ; ±180 if not given.
    pub range_deg: Option<[f64; 2]>,
    /// Most change of γ per length of the path; 5 if not given.
    pub max_step_deg_per_mm: Option<f64>,
    /// Least inverse condition number of the Jacobian; 0.01.
    pub min_singularity_distance: Option<f64>,
    /// Least distance of each drive and joint from the ends of its travel; 0.5.
    pub travel_margin_mm_or_deg: Option<f64>,
    /// Fastest motion of each drive at the programmed feed; any if not given.
    pub speed_limits_deg_per_s: Option<Vec<f64>>,
}

/// The smallest step of the lattice, degrees.
const FINEST_DEG: f64 = 0.25;

/// Checks the table at `check`, with defaults for what is not given, and converts it to settings.
pub(crate) fn settings(spec: &RedundancySpec, machine: &Machine, check: &Check) -> Result<RedundancySettings> {
    let default = RedundancySettings::default();
    let step_deg = check.key("step_deg").positive(spec.step_deg.unwrap_or(default.step_deg))?;
    if !(FINEST_DEG..=90.0).contains(&step_deg) {
        return check.key("step_deg").fail(format!("must be from {FINEST_DEG} to 90, got {step_deg}"));
    }
    let range_deg = spec.range_deg.unwrap_or(default.range_deg);
    if !(-360.0 <= range_deg[0] && range_deg[0] <= range_deg[1] && range_deg[1] - range_deg[0] <= 360.0) {
        let problem = format!(
            "must be the least turn and the largest, at most a full turn apart, got {} and {}",
            range_deg[0], range_deg[1]
        );
        return check.key("range_deg").fail(problem);
    }
    let most = spec.max_step_deg_per_mm.unwrap_or(default.max_step_deg_per_mm);
    let least = spec.min_singularity_distance.unwrap_or(default.min_singularity_distance);
    if !(0.0..1.0).contains(&least) {
        return check.key("min_singularity_distance").fail(format!("must be at least 0 and below 1, got {least}"));
    }
    Ok(RedundancySettings {
        gamma: spec.gamma,
        cost: spec.cost,
        objective: spec.objective,
        step_deg,
        range_deg,
        max_step_deg_per_mm: check.key("max_step_deg_per_mm").positive(most)?,
        min_singularity_distance: least,
        travel_margin: check
            .key("travel_margin_mm_or_deg")
            .not_negative(spec.travel_margin_mm_or_deg.unwrap_or(default.travel_margin))?,
        speed_limits_deg_per_s: speed_limits(spec, machine, &check.key("speed_limits_deg_per_s"))?,
    })
}

/// Checks the speed limits of the drives, degrees per second: one for each, only where all drives are revolute joints; empty if not given.
fn speed_limits(spec: &RedundancySpec, machine: &Machine, check: &Check) -> Result<Vec<f64>> {
    let Some(limits) = &spec.speed_limits_deg_per_s else { return Ok(Vec::new()) };
    if machine.drives().any(|(_, drive)| drive.motion != Motion::Revolute) {
        let problem =
            format!("machine {} has drives that are no revolute joints: expected no speed limits", machine.name);
        return check.misfit(problem, Vec::new());
    }
    if limits.len() != machine.drive_count() {
        let drives = machine.drive_labels().join(", ");
        return check.misfit(format!("must be one for each drive ({drives}), got {}", limits.len()), Vec::new());
    }
    limits.iter().enumerate().map(|(k, limit)| check.item(k).positive(*limit)).collect()
}
