//! What each cause of error contributes to a distribution: the quantile if it were perfectly known, and its share of the variance.

use kinetostat_budget::Cause;
use serde::{Deserialize, Serialize};

use super::{Draws, P95, Role, Setup, Surrogate, Uncertainty, quantile, surrogate::variance};

/// What varies of uncertain inputs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Varying {
    /// Parameters, by their indices.
    pub terms: Vec<usize>,
    /// Whether the cutting force does.
    pub force: bool,
    /// Whether the model leaves something out.
    pub model: bool,
}

/// What a cause contributes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CauseShare {
    /// The cause; `None` of the setup: the length of the tool and where the workpiece stands.
    pub cause: Option<Cause>,
    /// 95 % quantile if this were perfectly known, mm.
    pub if_known_mm: f64,
    /// Share of the sum of the variances by each alone, 0 to 1.
    pub variance_share: f64,
}

/// What the causes contribute at one place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shares {
    /// 95 % quantile with all of them, mm.
    pub p95_mm: f64,
    /// Mean displacement, the systematic part, in the axes of the base, mm.
    pub mean_mm: [f64; 3],
    /// Expanded uncertainty of each of its components, k = 2, mm: about 95 % of a normal distribution are within it of the mean.
    pub expanded_mm: [f64; 3],
    /// The causes that vary.
    pub causes: Vec<CauseShare>,
}

impl Uncertainty {
    /// Returns what varies by each cause.
    fn by_cause(&self) -> Vec<(Option<Cause>, Varying)> {
        let of_role = |role: Role| match role {
            Role::Elasticity => Some(Cause::Stiffness),
            Role::Geometry | Role::ChainError => Some(Cause::Geometry),
            Role::Setup(Setup::Accuracy(_)) => Some(Cause::Accuracy),
            Role::Setup(Setup::Repeatability(_)) => Some(Cause::Repeatability),
            Role::Setup(_) => None,
        };
        let mut all: Vec<(Option<Cause>, Varying)> = Vec::new();
        let mut of = |cause: Option<Cause>, change: &dyn Fn(&mut Varying)| {
            if !all.iter().any(|own| own.0 == cause) {
                all.push((cause, Varying::default()));
            }
            all.iter_mut().filter(|own| own.0 == cause).for_each(|own| change(&mut own.1));
        };
        if !self.force.is_exact() {
            of(Some(Cause::ForceUncertainty), &|own| own.force = true);
        }
        for (index, parameter) in self.parameters.iter().enumerate() {
            of(of_role(parameter.role), &|own| own.terms.push(index));
        }
        if !self.draws.model.is_empty() {
            of(Some(Cause::Stiffness), &|own| own.model = true);
        }
        all
    }

    /// Returns what the causes contribute to the displacements of `surrogate`.
    pub fn shares(&self, surrogate: &Surrogate) -> Shares {
        let draws = &self.draws;
        let p95 = |varying: &Varying| quantile(&mut surrogate.largest_by(draws, varying, Draws::COUNT), P95);
        let all = self.by_cause();
        let without = |which: usize| {
            let mut others = Varying::default();
            for (_, own) in all.iter().enumerate().filter(|(k, _)| *k != which).map(|(_, own)| own) {
                others.terms.extend(&own.terms);
                others.force |= own.force;
                others.model |= own.model;
            }
            others.terms.sort_unstable();
            others
        };
        let variances: Vec<f64> =
            all.iter().map(|(_, own)| variance(&surrogate.largest_by(draws, own, Draws::PER_SCRAMBLE))).collect();
        let sum: f64 = variances.iter().sum();
        let causes = all.iter().zip(&variances).enumerate().map(|(k, ((cause, _), own))| CauseShare {
            cause: *cause,
            if_known_mm: p95(&without(k)),
            variance_share: if sum > 0.0 { own / sum } else { 0.0 },
        });
        let moved = surrogate.displacements(draws);
        let along = |axis: usize| moved.iter().map(|own| own[axis]).collect::<Vec<f64>>();
        let mean = |axis: usize| along(axis).iter().sum::<f64>() / moved.len().max(1) as f64;
        let expanded = |axis: usize| 2.0 * variance(&along(axis)).sqrt();
        // No index is left out: all that varies is in one of them.
        Shares {
            p95_mm: p95(&without(all.len())),
            mean_mm: [0, 1, 2].map(mean),
            expanded_mm: [0, 1, 2].map(expanded),
            causes: causes.collect(),
        }
    }
}
