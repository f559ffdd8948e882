//! Checks the limits by which the feed of a program is chosen.

use serde::Deserialize;

use crate::{
    input::{check::Check, error::Result},
    process::{
        cutting::CuttingLaw,
        feed::{FeedLimits, FeedQuantity},
        file::spec::ProcessSpec,
    },
};

/// The table `feed`: what limits the feed of a program.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeedSpec {
    /// Most force on the tool.
    #[serde(rename = "max_force_N")]
    pub max_force: Option<f64>,
    /// Most torque about the spindle.
    #[serde(rename = "max_torque_Nm")]
    pub max_torque: Option<f64>,
    /// Most power of the spindle.
    #[serde(rename = "max_power_kW")]
    pub max_power: Option<f64>,
    /// Most distance from the path without compensation.
    pub max_deflection_mm: Option<f64>,
    /// Fastest feed where the tool cuts.
    pub max_mm_per_min: Option<f64>,
    /// Least and largest feed, as shares of the programmed one; [`CHANGE`] if not given.
    pub change: Option<[f64; 2]>,
}

/// How much a feed may change if the file does not say it.
const CHANGE: [f64; 2] = [0.5, 1.5];
/// Slower feeds are no cut, and numbers after F do not tell them apart.
const LEAST_CHANGE: f64 = 0.01;

/// Checks the limits of the feed; fails where no force of the `laws` can be changed by it.
pub(crate) fn limits<'a>(
    process: &ProcessSpec,
    laws: impl Iterator<Item = &'a CuttingLaw>,
    top: &Check,
) -> Result<Option<FeedLimits>> {
    let Some(spec) = process.feed else { return Ok(None) };
    let check = top.key("feed");
    let given = [spec.max_force, spec.max_torque, spec.max_power, spec.max_deflection_mm, spec.max_mm_per_min];
    let mut most = [None; 5];
    for ((quantity, given), most) in FeedQuantity::ALL.into_iter().zip(given).zip(&mut most) {
        *most = check.key(quantity.key()).optional_positive(given)?;
    }
    if most[..4].iter().all(Option::is_none) {
        return check
            .fail("expected at least one of max_force_N, max_torque_Nm, max_power_kW and max_deflection_mm".into());
    }
    let change = spec.change.unwrap_or(CHANGE);
    let [low, high] = change;
    if !((LEAST_CHANGE..=1.0).contains(&low) && high >= 1.0 && high.is_finite()) {
        let problem = format!(
            "must be two shares of the programmed feed, one from {LEAST_CHANGE} to 1, one at least 1, got {change:?}"
        );
        return check.key("change").fail(problem);
    }
    let known: Vec<_> = laws.map(CuttingLaw::knows).filter(|own| own[0]).collect();
    if known.is_empty() || known.iter().any(|own| !own[1]) {
        let problem = "needs cutting forces that the feed of the program changes: expected slot_milling, end_milling or drilling without \
                       feed_per_tooth_mm and feed_per_rev_mm, for all that cuts";
        return check.fail(problem.into());
    }
    let of_torque = [FeedQuantity::Torque, FeedQuantity::Power].into_iter().find(|own| most[*own as usize].is_some());
    if let Some(quantity) = of_torque.filter(|_| known.iter().any(|own| !own[2])) {
        let problem = "needs the mean torque, which slot_milling and load = \"peak\" do not give: expected end_milling or drilling";
        return check.key(quantity.key()).fail(problem.into());
    }
    if process.cutting.max_feed_mm_per_min.is_some() {
        let problem = "says by the feed what cuts, and [feed] changes it: expected another rule, or [stock]";
        return top.key("cutting").key("max_feed_mm_per_min").fail(problem.into());
    }
    Ok(Some(FeedLimits { most, change, check: check.at_once() }))
}
