//! The turn about the tool's axis, from a process file as written to a checked one.

use serde::Deserialize;

use crate::{
    input::{check::Check, error::Result},
    machine::{Machine, Motion},
    process::{GammaChoice, RedundancySettings, RedundancyCost, RedundancyObjective},
};

/// How the turn about the tool's axis is chosen, as written.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RedundancySpec {
    /// Which turn the points of a path have.
    #[serde(default)]
    pub gamma: GammaChoice,
    /// What of the distance from the path counts.
    #[serde(default)]
    pub cost: RedundancyCost,
    /// What is made small over the path.
    #[serde(default)]
    pub objective: RedundancyObjective,
    /// Between neighbouring turns of the lattice; 5.
    pub step_deg: Option<f64>,
    /// Least and largest turn; a full one if not given.
    pub range_deg: Option<[f64; 2]>,
    /// Most change of the turn per length of the path; 5.
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

/// Checks the table, which stands at `check`.
pub(super) fn redundancy(spec: &RedundancySpec, machine: &Machine, check: &Check) -> Result<RedundancySettings> {
    let own = RedundancySettings::default();
    let step_deg = check.key("step_deg").positive(spec.step_deg.unwrap_or(own.step_deg))?;
    if !(FINEST_DEG..=90.0).contains(&step_deg) {
        return check.key("step_deg").fail(format!("must be from {FINEST_DEG} to 90, got {step_deg}"));
    }
    let range_deg = spec.range_deg.unwrap_or(own.range_deg);
    if !(-360.0 <= range_deg[0] && range_deg[0] < range_deg[1] && range_deg[1] - range_deg[0] <= 360.0) {
        let problem = format!(
            "must be the least turn and a larger one, at most a full turn apart, got {} and {}",
            range_deg[0], range_deg[1]
        );
        return check.key("range_deg").fail(problem);
    }
    let most = spec.max_step_deg_per_mm.unwrap_or(own.max_step_deg_per_mm);
    let least = spec.min_singularity_distance.unwrap_or(own.min_singularity_distance);
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
            .not_negative(spec.travel_margin_mm_or_deg.unwrap_or(own.travel_margin))?,
        speed_limits_deg_per_s: speed_limits(spec, machine, &check.key("speed_limits_deg_per_s"))?,
    })
}

fn speed_limits(spec: &RedundancySpec, machine: &Machine, check: &Check) -> Result<Vec<f64>> {
    let Some(limits) = &spec.speed_limits_deg_per_s else { return Ok(Vec::new()) };
    if machine.drives().any(|(_, drive)| drive.motion != Motion::Revolute) {
        return check.fail(format!("machine {} has drives that are no hinges: expected no speed limits", machine.name));
    }
    if limits.len() != machine.drive_count() {
        let drives = machine.drive_labels().join(", ");
        return check.fail(format!("must be one for each drive ({drives}), got {}", limits.len()));
    }
    limits.iter().enumerate().map(|(k, limit)| check.item(k).positive(*limit)).collect()
}
