//! Stability of a correction by measured forces: whether the loop through the cutting force converges.
//!
//! The cutting force changes as the tool leaves its depth: `F = F₀ ∓ k e`, less where the tool gives way out of the material, more where
//! it is drawn in. The tool moves by `e_j = C F_j − C_m F_{j−1}`: bent by the force of now, corrected by a model that is too soft by δ,
//! `C_m = (1 + δ) C`, for the force measured before. In a direction in which the compliance is λ the force goes from cycle to cycle as
//!
//! ```text
//! out of the material   F_j = (F₀ + k (1 + δ) λ F_{j−1}) / (1 + k λ)    gain k (1 + δ) λ / (1 + k λ)
//! drawn in              F_j = (F₀ − k (1 + δ) λ F_{j−1}) / (1 − k λ)    gain k (1 + δ) λ / (1 − k λ)
//! ```
//!
//! and settles if the gain is below 1. Delay and low-pass, whose gain is at most 1 at any frequency, do not make it larger. The
//! second is the worse for δ > −1, and reaches 1 at `k = 1 / ((2 + δ) λ)`; at `k = 1 / λ` the cut itself does not settle, with or
//! without correction.

/// Gain of the loop through the cutting force, in the direction in which the tool is most compliant.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct LoopGain {
    /// λ, the largest compliance of the tool along the path, mm/N.
    pub compliance_mm_per_N: f64,
    /// Cutting stiffness at which the gain reaches 1, N/mm.
    pub largest_stiffness_N_per_mm: f64,
    /// Gain at the given cutting stiffness, if there is one; infinite where the cut itself is unstable.
    pub gain: Option<f64>,
}

impl LoopGain {
    /// Returns the loop gain for a tool compliance λ in mm/N, a model too soft by δ, above −1, and a cutting stiffness k in N/mm, if given.
    pub fn new(compliance: f64, softness: f64, stiffness: Option<f64>) -> Self {
        let gain = |k: f64| match 1.0 - k * compliance {
            denominator if denominator > 0.0 => k * (1.0 + softness) * compliance / denominator,
            _ => f64::INFINITY,
        };
        Self {
            compliance_mm_per_N: compliance,
            largest_stiffness_N_per_mm: 1.0 / ((2.0 + softness) * compliance),
            gain: stiffness.map(gain),
        }
    }
}
