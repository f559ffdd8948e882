//! Metrics by which a placement is judged, and the objective made of them.

use serde::{Deserialize, Serialize};

use crate::machine::{Machine, Motion};

/// Kind of quantity that a metric measures, which gives its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Measure {
    Length,
    Correction,
    Force,
    Stiffness,
    Share,
    /// What is free between bodies.
    Clearance,
}

/// Declares the metrics, in table order, each with its word in study files, its name, a short name, and what it measures.
macro_rules! metrics {
    ($($(#[$meaning:meta])* $metric:ident: $label:literal, $words:literal, $short:literal, $measure:ident;)*) => {
        /// A metric of a placement. All but margins and shares are better the smaller they are.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
        pub enum Metric {
            $($(#[$meaning])* $metric,)*
        }

        impl Metric {
            /// All metrics, in table order.
            pub const ALL: [Metric; [$($label),*].len()] = [$(Metric::$metric),*];

            /// Returns the names of the metric (in study files, in sentences, in narrow columns) and what it measures.
            fn names(self) -> ([&'static str; 3], Measure) {
                match self {
                    $(Metric::$metric => ([$label, $words, $short], Measure::$measure),)*
                }
            }
        }
    };
}

metrics! {
    /// Largest distance of the compensated point from its path at the nominal command, both sources.
    WorstDeflection: "worst_deflection", "worst deflection", "worst", Length;
    /// Root mean square of that distance over the length of the path.
    RmsDeflection: "rms_deflection", "rms deflection", "rms", Length;
    /// Largest |Δρ| of any drive that compensates the path exactly; of any prismatic one where the machine has prismatic and revolute joints.
    WorstCorrection: "worst_correction", "largest drive correction", "correction", Correction;
    /// Largest force of any drive when the path is compensated exactly. Where a machine has prismatic and revolute joints: of any prismatic one.
    WorstDriveForce: "worst_drive_force", "largest drive force", "drive force", Force;
    /// Largest |Δρ| of any revolute joint that compensates the path exactly, where a machine has prismatic joints, too.
    WorstRotaryCorrection: "worst_rotary_correction", "largest correction of revolute joints", "of revolute joints", Correction;
    /// Largest torque of any revolute joint when the path is compensated exactly, where a machine has prismatic joints, too.
    WorstRotaryTorque: "worst_rotary_torque", "largest torque of revolute joints", "torque of revolute joints", Force;
    /// Smallest share of its force limit that a drive has left then. Larger is better.
    ForceMargin: "force_margin", "margin to the force limits", "force margin", Share;
    /// Largest residual error with the correction within limits.
    WorstResidual: "worst_residual", "worst residual error within limits", "worst residual", Length;
    /// Root mean square of that distance over the length of the path.
    RmsResidual: "rms_residual", "rms residual error within limits", "rms residual", Length;
    /// Largest difference between the sum of both sources' displacements and the displacement by both at once.
    SuperpositionError: "superposition_error", "superposition error", "superposition", Length;
    /// Smallest eigenvalue of the loaded stiffness, rotations at the machine's characteristic length. Larger is better.
    StabilityMargin: "stability_margin", "stability margin", "stability", Stiffness;
    /// Least distance of bodies along the ways of the paths that are looked at, as programmed; none where a shape is assumed. Larger is better.
    LeastClearance: "least_clearance", "least clearance of bodies", "clearance", Clearance;
    /// Share of the path's length within tolerance at the nominal command. Larger is better.
    ShareWithin: "share_within_tolerance", "share of the path within tolerance", "within", Share;
    /// Share of the path's length within tolerance after the correction within limits. Larger is better.
    ShareWithinCorrected:
        "share_within_tolerance_corrected", "share within tolerance after correction", "within, corrected", Share;
    /// Largest part across the direction of motion of the distance from the path at the nominal command: what walls and floor are off by.
    WorstAcrossPath: "worst_across_path", "worst deflection across the motion", "worst across", Length;
    /// Root mean square of that part over the length of the path.
    RmsAcrossPath: "rms_across_path", "rms deflection across the motion", "rms across", Length;
    /// Largest part across the direction of motion and the tool's axis: normal to the wall that the side of the tool leaves.
    WorstAcrossSurface: "worst_across_surface", "worst deflection normal to the wall", "worst, wall", Length;
    /// Root mean square of that part over the length of the path.
    RmsAcrossSurface: "rms_across_surface", "rms deflection normal to the wall", "rms, wall", Length;
    /// 95 % quantile of the worst deflection, where inputs are uncertain; infinite where too many draws have no equilibrium.
    P95Deflection: "p95_deflection", "95 % quantile of the worst deflection", "P95", Length;
    /// Probability that all of the path is within tolerance at the nominal command, where inputs are uncertain. Larger is better.
    WithinProbability: "probability_within_tolerance", "probability that all is within tolerance", "probability", Share;
}

impl Metric {
    /// Returns the word for the metric in study files.
    pub fn label(self) -> &'static str {
        self.names().0[0]
    }

    /// Returns the metric called `name` in a study file; `None` if there is none.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|metric| metric.label() == name)
    }

    /// Returns whether the metric is the largest drive force on a machine whose drives are all revolute joints: a torque.
    fn is_torque(self, machine: &Machine) -> bool {
        self == Self::WorstDriveForce && self.drives(machine) == Motion::Revolute
    }

    /// Returns the name of the metric for sentences; the drive force is a torque where all drives are revolute joints.
    pub fn text(self, machine: &Machine) -> &'static str {
        if self.is_torque(machine) { "largest drive torque" } else { self.names().0[1] }
    }

    /// Returns the name of the metric for the head of a narrow column.
    pub fn short_text(self, machine: &Machine) -> &'static str {
        if self.is_torque(machine) { "drive torque" } else { self.names().0[2] }
    }

    /// Returns the kind of quantity that the metric measures.
    fn measure(self) -> Measure {
        self.names().1
    }

    /// Returns the kind of drives whose corrections or forces it measures: the only kind, or prismatic joints beside revolute joints.
    fn drives(self, machine: &Machine) -> Motion {
        match self {
            Metric::WorstRotaryCorrection | Metric::WorstRotaryTorque => Motion::Revolute,
            _ => machine.drive_kinds().next().unwrap_or(Motion::Prismatic),
        }
    }

    /// Returns the unit of the metric on `machine` as in column names, such as `N_per_mm`; empty for shares.
    pub fn unit(self, machine: &Machine) -> &'static str {
        match self.measure() {
            Measure::Length | Measure::Clearance => "mm",
            Measure::Correction => self.drives(machine).position_unit(),
            Measure::Force => self.drives(machine).force_unit(),
            Measure::Stiffness => "N_per_mm",
            Measure::Share => "",
        }
    }

    /// Returns the name of the table column of the metric: label and unit.
    pub fn column(self, machine: &Machine) -> String {
        match (self, self.unit(machine)) {
            (_, "") => self.label().into(),
            (Metric::WorstDriveForce, unit) => {
                format!("{}_{unit}", self.label().replace("force", self.drives(machine).force_word()))
            }
            (_, unit) => format!("{}_{unit}", self.label()),
        }
    }

    /// Returns the unit of the metric for axes and pages, such as `N/mm`; empty for shares.
    pub fn shown_unit(self, machine: &Machine) -> &'static str {
        match self.measure() {
            Measure::Correction => self.drives(machine).shown_position_unit(),
            Measure::Force => self.drives(machine).shown_force_unit(),
            Measure::Stiffness => "N/mm",
            _ => self.unit(machine),
        }
    }

    /// Formats `value` of the metric with its unit for sentences.
    pub fn value_text(self, machine: &Machine, value: f64) -> String {
        match self.measure() {
            Measure::Correction => self.drives(machine).position_text(value),
            Measure::Share => format!("{:.1} %", 100.0 * value),
            Measure::Length => format!("{value:.3} mm"),
            // What is said is free.
            Measure::Clearance => format!("{:.1} mm", (10.0 * value).floor() / 10.0),
            Measure::Force => self.drives(machine).force_text(value),
            Measure::Stiffness => format!("{value:.0} {}", self.shown_unit(machine)),
        }
    }

    /// Returns whether placements on `machine` have the metric: those of revolute joints exist only where prismatic joints do, too.
    pub fn exists_on(self, machine: &Machine) -> bool {
        !matches!(self, Metric::WorstRotaryCorrection | Metric::WorstRotaryTorque) || machine.has_mixed_drives()
    }

    /// Returns whether a larger value is better.
    pub fn larger_is_better(self) -> bool {
        matches!(self.measure(), Measure::Stiffness | Measure::Share | Measure::Clearance)
    }

    /// Returns `value` with the sign that makes smaller better: negative for margins and shares.
    pub fn cost(self, value: f64) -> f64 {
        if self.larger_is_better() { -value } else { value }
    }

    /// Returns whether it is a part of the deflection across the motion, which is computed only where the objective asks for one.
    pub fn is_across(self) -> bool {
        matches!(
            self,
            Metric::WorstAcrossPath | Metric::RmsAcrossPath | Metric::WorstAcrossSurface | Metric::RmsAcrossSurface
        )
    }

    /// Returns whether it is of a distribution, which is computed only where the objective asks for one.
    pub fn is_uncertain(self) -> bool {
        matches!(self, Metric::P95Deflection | Metric::WithinProbability)
    }

    /// Returns whether the metric comes from the correction within limits: those that `ResidualTally::write_into` sets.
    pub fn is_bounded(self) -> bool {
        matches!(self, Metric::WorstResidual | Metric::RmsResidual | Metric::ShareWithinCorrected)
    }
}

/// The metrics of a placement; `None` for those that were not computed or do not exist.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Metrics([Option<f64>; Metric::ALL.len()]);

impl Metrics {
    /// Returns the value of `metric`, in its [`Metric::unit`]; `None` if it was not computed or does not exist.
    pub fn get(&self, metric: Metric) -> Option<f64> {
        self.0[metric as usize]
    }

    /// Sets the value of `metric`, in its [`Metric::unit`]; `None` removes it.
    pub fn set(&mut self, metric: Metric, value: impl Into<Option<f64>>) {
        self.0[metric as usize] = value.into();
    }

    /// Returns the worse value of each metric, none where either has none.
    pub(super) fn worse_of(&self, other: &Self) -> Self {
        let mut worse = Self::default();
        for metric in Metric::ALL {
            if let (Some(a), Some(b)) = (self.get(metric), other.get(metric)) {
                worse.set(metric, if metric.cost(a) >= metric.cost(b) { a } else { b });
            }
        }
        worse
    }

    /// Returns these with the least distance of bodies, mm; `None` where it is not known.
    pub(super) fn with_clearance(mut self, least_mm: Option<f64>) -> Self {
        self.set(Metric::LeastClearance, least_mm);
        self
    }
}

/// Objective to be minimised: a weighted sum of metrics; and the metrics of the Pareto front.
#[derive(Debug, Clone, PartialEq)]
pub struct Objective {
    /// Weights, all above 0; margins and shares enter with the opposite sign.
    pub weights: Vec<(Metric, f64)>,
    /// The metrics of the Pareto front; none, two or three.
    pub pareto: Vec<Metric>,
}

impl Objective {
    /// Returns `Σ weight · metric`; infinite where a metric has no value.
    pub fn value(&self, metrics: &Metrics) -> f64 {
        let term = |(metric, weight): &(Metric, f64)| {
            metrics.get(*metric).map_or(f64::INFINITY, |value| weight * metric.cost(value))
        };
        self.weights.iter().map(term).sum()
    }

    /// Returns the metrics that a study with this objective needs: those with weights, then those of the Pareto front.
    pub fn metrics(&self) -> Vec<Metric> {
        let mut needed: Vec<Metric> = self.weights.iter().map(|(metric, _)| *metric).collect();
        needed.extend(&self.pareto);
        needed
    }

    /// Returns whether a study with this objective computes `metric`: parts across the motion and what is uncertain only if the objective has one.
    pub fn has(&self, metric: Metric) -> bool {
        let needs = |group: fn(Metric) -> bool| self.metrics().into_iter().any(group);
        (!metric.is_across() || needs(Metric::is_across)) && (!metric.is_uncertain() || needs(Metric::is_uncertain))
    }

    /// Returns the objective in words: the metric, or the weighted sum of several.
    pub fn text(&self, machine: &Machine) -> String {
        match self.weights.as_slice() {
            [(metric, _)] => metric.text(machine).into(),
            terms => {
                let term = |(metric, weight): &(Metric, f64)| match metric.shown_unit(machine) {
                    "" => format!("{weight} × {}", metric.text(machine)),
                    unit if unit.contains('/') => format!("{weight}/({unit}) × {}", metric.text(machine)),
                    unit => format!("{weight}/{unit} × {}", metric.text(machine)),
                };
                terms.iter().map(term).collect::<Vec<_>>().join(" + ")
            }
        }
    }
}
