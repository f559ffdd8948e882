//! What a placement is judged by.

use serde::{Deserialize, Serialize};

use crate::machine::{Machine, Motion};

/// A number that a placement has. All but the margins and shares are better the smaller they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Metric {
    /// Largest distance of the point put right from its path at the nominal command, both sources.
    WorstDeflection,
    /// Root mean square of that distance over the length of the path.
    RmsDeflection,
    /// Largest |Δρ| of any drive that puts the path right exactly. Where a machine has slides and hinges, whose values have
    /// no common unit: of any slide.
    WorstCorrection,
    /// Largest force of any drive when the path is put right exactly. Where a machine has slides and hinges: of any slide.
    WorstDriveForce,
    /// Largest |Δρ| of any hinge that puts the path right exactly, where a machine has slides, too.
    WorstHingeCorrection,
    /// Largest torque of any hinge when the path is put right exactly, where a machine has slides, too.
    WorstHingeTorque,
    /// Smallest share of its force limit that a drive has left then. Larger is better.
    ForceMargin,
    /// Largest distance left by the correction within limits.
    WorstResidual,
    /// Root mean square of that distance over the length of the path.
    RmsResidual,
    /// Largest difference between the sum of both sources' displacements and the displacement by both at once.
    Departure,
    /// Smallest eigenvalue of the loaded stiffness, rotations at the machine's reach. Larger is better.
    StabilityMargin,
    /// Share of the path's length within tolerance at the nominal command. Larger is better.
    ShareWithin,
    /// Share of the path's length within tolerance after the correction within limits. Larger is better.
    ShareWithinCorrected,
    /// Largest part across the direction of motion of the distance from the path at the nominal command: what walls and floor are off by.
    WorstAcrossPath,
    /// Root mean square of that part over the length of the path.
    RmsAcrossPath,
    /// Largest part across the direction of motion and the tool's axis: normal to the wall that the side of the tool leaves.
    WorstAcrossSurface,
    /// Root mean square of that part over the length of the path.
    RmsAcrossSurface,
}

impl Metric {
    /// All metrics, in table order.
    pub const ALL: [Metric; 17] = [
        Metric::WorstDeflection,
        Metric::RmsDeflection,
        Metric::WorstCorrection,
        Metric::WorstDriveForce,
        Metric::WorstHingeCorrection,
        Metric::WorstHingeTorque,
        Metric::ForceMargin,
        Metric::WorstResidual,
        Metric::RmsResidual,
        Metric::Departure,
        Metric::StabilityMargin,
        Metric::ShareWithin,
        Metric::ShareWithinCorrected,
        Metric::WorstAcrossPath,
        Metric::RmsAcrossPath,
        Metric::WorstAcrossSurface,
        Metric::RmsAcrossSurface,
    ];

    /// Word used in study files.
    pub fn label(self) -> &'static str {
        match self {
            Metric::WorstDeflection => "worst_deflection",
            Metric::RmsDeflection => "rms_deflection",
            Metric::WorstCorrection => "worst_correction",
            Metric::WorstDriveForce => "worst_drive_force",
            Metric::WorstHingeCorrection => "worst_hinge_correction",
            Metric::WorstHingeTorque => "worst_hinge_torque",
            Metric::ForceMargin => "force_margin",
            Metric::WorstResidual => "worst_residual",
            Metric::RmsResidual => "rms_residual",
            Metric::Departure => "departure",
            Metric::StabilityMargin => "stability_margin",
            Metric::ShareWithin => "share_within_tolerance",
            Metric::ShareWithinCorrected => "share_within_tolerance_corrected",
            Metric::WorstAcrossPath => "worst_across_path",
            Metric::RmsAcrossPath => "rms_across_path",
            Metric::WorstAcrossSurface => "worst_across_surface",
            Metric::RmsAcrossSurface => "rms_across_surface",
        }
    }

    /// The metric called `name` in a study file.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|metric| metric.label() == name)
    }

    /// What it is, in words. What drives carry is a torque where all of them are hinges.
    pub fn words(self, machine: &Machine) -> &'static str {
        match self {
            Metric::WorstDriveForce if self.drives(machine) == Motion::Revolute => "largest drive torque",
            Metric::WorstDeflection => "worst deflection",
            Metric::RmsDeflection => "rms deflection",
            Metric::WorstCorrection => "largest drive correction",
            Metric::WorstDriveForce => "largest drive force",
            Metric::WorstHingeCorrection => "largest correction of hinges",
            Metric::WorstHingeTorque => "largest torque of hinges",
            Metric::ForceMargin => "margin to the force limits",
            Metric::WorstResidual => "worst error left within limits",
            Metric::RmsResidual => "rms error left within limits",
            Metric::Departure => "departure of superposition",
            Metric::StabilityMargin => "stability margin",
            Metric::ShareWithin => "share of the path within tolerance",
            Metric::ShareWithinCorrected => "share within tolerance after correction",
            Metric::WorstAcrossPath => "worst deflection across the motion",
            Metric::RmsAcrossPath => "rms deflection across the motion",
            Metric::WorstAcrossSurface => "worst deflection normal to the wall",
            Metric::RmsAcrossSurface => "rms deflection normal to the wall",
        }
    }

    /// The same for the head of a narrow column.
    pub fn short_words(self, machine: &Machine) -> &'static str {
        match self {
            Metric::WorstDriveForce if self.drives(machine) == Motion::Revolute => "drive torque",
            Metric::WorstDeflection => "worst",
            Metric::RmsDeflection => "rms",
            Metric::WorstCorrection => "correction",
            Metric::WorstDriveForce => "drive force",
            Metric::WorstHingeCorrection => "of hinges",
            Metric::WorstHingeTorque => "hinge torque",
            Metric::ForceMargin => "force margin",
            Metric::WorstResidual => "worst left",
            Metric::RmsResidual => "rms left",
            Metric::Departure => "departure",
            Metric::StabilityMargin => "stability",
            Metric::ShareWithin => "within",
            Metric::ShareWithinCorrected => "within, corrected",
            Metric::WorstAcrossPath => "worst across",
            Metric::RmsAcrossPath => "rms across",
            Metric::WorstAcrossSurface => "worst, wall",
            Metric::RmsAcrossSurface => "rms, wall",
        }
    }

    /// The drives whose corrections or forces it is about: the only kind, or slides beside hinges.
    fn drives(self, machine: &Machine) -> Motion {
        match self {
            Metric::WorstHingeCorrection | Metric::WorstHingeTorque => Motion::Revolute,
            _ => machine.drive_kinds().next().unwrap_or(Motion::Prismatic),
        }
    }

    /// Its unit on `machine`; empty for shares.
    pub fn unit(self, machine: &Machine) -> &'static str {
        match self {
            Metric::WorstDeflection
            | Metric::RmsDeflection
            | Metric::WorstResidual
            | Metric::RmsResidual
            | Metric::Departure
            | Metric::WorstAcrossPath
            | Metric::RmsAcrossPath
            | Metric::WorstAcrossSurface
            | Metric::RmsAcrossSurface => "mm",
            Metric::WorstCorrection | Metric::WorstHingeCorrection => self.drives(machine).position_unit(),
            Metric::WorstDriveForce | Metric::WorstHingeTorque => self.drives(machine).force_unit(),
            Metric::StabilityMargin => "N_per_mm",
            Metric::ForceMargin | Metric::ShareWithin | Metric::ShareWithinCorrected => "",
        }
    }

    /// Name of its table column: label and unit.
    pub fn column(self, machine: &Machine) -> String {
        match (self, self.unit(machine)) {
            (_, "") => self.label().into(),
            (Metric::WorstDriveForce, unit) => {
                format!("{}_{unit}", self.label().replace("force", self.drives(machine).force_word()))
            }
            (_, unit) => format!("{}_{unit}", self.label()),
        }
    }

    /// Its unit as shown on axes and pages; empty for shares.
    pub fn shown_unit(self, machine: &Machine) -> &'static str {
        match self {
            Metric::WorstCorrection | Metric::WorstHingeCorrection => self.drives(machine).shown_position_unit(),
            Metric::WorstDriveForce | Metric::WorstHingeTorque => self.drives(machine).shown_force_unit(),
            Metric::StabilityMargin => "N/mm",
            _ => self.unit(machine),
        }
    }

    /// Its value with unit, for sentences.
    pub fn shown(self, machine: &Machine, value: f64) -> String {
        match (self, self.shown_unit(machine)) {
            (Metric::WorstCorrection | Metric::WorstHingeCorrection, _) => self.drives(machine).position_words(value),
            (_, "") => format!("{:.1} %", 100.0 * value),
            (_, unit @ "mm") => format!("{value:.3} {unit}"),
            (_, unit) => format!("{value:.0} {unit}"),
        }
    }

    /// Whether placements on `machine` have it.
    pub fn exists_on(self, machine: &Machine) -> bool {
        !matches!(self, Metric::WorstHingeCorrection | Metric::WorstHingeTorque) || machine.has_mixed_drives()
    }

    /// Whether a larger value is better.
    pub fn larger_is_better(self) -> bool {
        matches!(
            self,
            Metric::ForceMargin | Metric::StabilityMargin | Metric::ShareWithin | Metric::ShareWithinCorrected
        )
    }

    /// The value as something to be made small.
    pub fn cost(self, value: f64) -> f64 {
        if self.larger_is_better() { -value } else { value }
    }

    /// Whether it is a part of the distance from the path, which is computed where the objective asks for such parts.
    pub fn is_across(self) -> bool {
        matches!(
            self,
            Metric::WorstAcrossPath | Metric::RmsAcrossPath | Metric::WorstAcrossSurface | Metric::RmsAcrossSurface
        )
    }

    /// Whether it comes from the correction within limits.
    pub fn is_bounded(self) -> bool {
        matches!(self, Metric::WorstResidual | Metric::RmsResidual | Metric::ShareWithinCorrected)
    }
}

/// The metrics of a placement; `None` for those that were not computed or do not exist.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Metrics([Option<f64>; Metric::ALL.len()]);

impl Metrics {
    /// The value of `metric`, in its [`Metric::unit`].
    pub fn get(&self, metric: Metric) -> Option<f64> {
        self.0[metric as usize]
    }

    pub(super) fn set(&mut self, metric: Metric, value: f64) {
        self.0[metric as usize] = Some(value);
    }

    pub(super) fn clear(&mut self, metric: Metric) {
        self.0[metric as usize] = None;
    }
}

/// What is made small: a weighted sum of metrics, and the metrics whose best compromises are wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct Objective {
    /// Weights, all above 0; margins and shares enter with the opposite sign.
    pub weights: Vec<(Metric, f64)>,
    /// The metrics of the Pareto front; none, two or three.
    pub pareto: Vec<Metric>,
}

impl Objective {
    /// `Σ weight · metric`; infinite where a metric has no value.
    pub fn value(&self, metrics: &Metrics) -> f64 {
        let term = |(metric, weight): &(Metric, f64)| {
            metrics.get(*metric).map_or(f64::INFINITY, |value| weight * metric.cost(value))
        };
        self.weights.iter().map(term).sum()
    }

    /// The metrics it needs.
    pub fn metrics(&self) -> Vec<Metric> {
        let mut needed: Vec<Metric> = self.weights.iter().map(|(metric, _)| *metric).collect();
        needed.extend(&self.pareto);
        needed
    }

    /// Whether a study with this objective has `metric`.
    pub fn has(&self, metric: Metric) -> bool {
        !metric.is_across() || self.metrics().iter().any(|asked| asked.is_across())
    }

    /// What the objective is, in words.
    pub fn words(&self, machine: &Machine) -> String {
        match self.weights.as_slice() {
            [(metric, _)] => metric.words(machine).into(),
            terms => {
                let term = |(metric, weight): &(Metric, f64)| match metric.shown_unit(machine) {
                    "" => format!("{weight} × {}", metric.words(machine)),
                    unit if unit.contains('/') => format!("{weight}/({unit}) × {}", metric.words(machine)),
                    unit => format!("{weight}/{unit} × {}", metric.words(machine)),
                };
                terms.iter().map(term).collect::<Vec<_>>().join(" + ")
            }
        }
    }
}
