//! Settings of a solve, its status and outcome, and the error of a task.

use nalgebra::{Matrix6, Matrix6xX, Vector6};
use serde::{Deserialize, Serialize};

use super::{
    platform,
    stiffness::{largest_compliance, smallest_eigenvalue},
    transmission::Scale,
};
use crate::machine::Machine;

/// A platform whose softest direction is below this share of its stiffest may be held there by the machine's errors alone.
const SOFT: f64 = 1e-4;

/// Tolerance and number of iterations of an equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Largest accepted residual: closure gaps over the machine's characteristic length, and forces out of balance over the largest wrench.
    pub tolerance: f64,
    /// Largest number of Newton iterations of one load step.
    pub max_iterations: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_iterations: 12 }
    }
}

/// How a solve ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Status {
    /// In stable equilibrium.
    Solved,
    /// In equilibrium, but the platform's loaded stiffness is not positive definite. Judged by its symmetric part: under
    /// a dead moment, which is not conservative, this is on the safe side.
    Unstable,
    /// In equilibrium, but this chain would buckle between base and platform.
    Buckled {
        /// Index of the chain.
        chain: usize,
        /// Fractions of the load, weight and chain errors in full: the largest found with which the machine is stable, and the smallest
        /// above with which not, equal where the load has no part in it. `None` where they were not sought.
        load_fractions: Option<[f64; 2]>,
    },
    /// In equilibrium, but the platform can move without resistance.
    Singular,
    /// No equilibrium was found beyond this fraction of the load and of the chain errors.
    NotConverged {
        /// Last fraction that was in equilibrium.
        load_fraction: f64,
    },
    /// No equilibrium that the start leads to: on the way, the stiffness of the platform falls to zero. What equilibria
    /// there may be beyond are reached by snapping through.
    SnapThrough {
        /// Fraction of the load and of the chain errors at which stability is lost.
        load_fraction: f64,
    },
    /// No equilibrium: where the solve starts, the platform or a chain can move without resistance.
    SingularPlace,
}

impl Status {
    /// Word used in tables.
    pub fn label(&self) -> &'static str {
        match self {
            Status::Solved => "solved",
            Status::Unstable => "unstable",
            Status::Buckled { .. } => "buckled",
            Status::Singular => "singular",
            Status::NotConverged { .. } => "not_converged",
            Status::SnapThrough { .. } => "snap_through",
            Status::SingularPlace => "singular",
        }
    }

    /// Whether the solve ended in an equilibrium, stable or not.
    pub fn is_equilibrium(&self) -> bool {
        !matches!(self, Status::NotConverged { .. } | Status::SnapThrough { .. } | Status::SingularPlace)
    }

    /// Reason in words; empty when solved.
    pub fn reason(&self, machine: &Machine) -> String {
        match self {
            Status::Solved => String::new(),
            Status::Unstable => "the loaded stiffness of the platform is not positive definite".into(),
            Status::Buckled { chain, load_fractions } => {
                let share = match load_fractions.map(|fractions| fractions.map(|fraction| 100.0 * fraction)) {
                    None => String::new(),
                    Some([stable, buckled]) if stable == buckled => ", even without the load".into(),
                    Some([stable, buckled]) => {
                        format!(": it buckles between {stable:.1} % and {buckled:.1} % of the load")
                    }
                };
                format!("chain {} is unstable between base and platform{share}", machine.chains[*chain].name)
            }
            Status::Singular => "the platform can move without resistance".into(),
            Status::NotConverged { load_fraction } => {
                format!("no equilibrium beyond {:.1} % of the load and the chain errors", 100.0 * load_fraction)
            }
            Status::SnapThrough { load_fraction } => format!(
                "the machine snaps through: it loses its stability at {:.1} % of the load and the chain errors",
                100.0 * load_fraction
            ),
            Status::SingularPlace => {
                "the place is singular: the platform or a chain can move there without resistance".into()
            }
        }
    }
}

/// Result of a solve besides the state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// How it ended.
    pub status: Status,
    /// Newton iterations, over all load steps.
    pub iterations: usize,
    /// Residual at the end, see [`Settings::tolerance`].
    pub residual: f64,
    /// Load steps; 1 if the full load was taken at once.
    pub load_steps: usize,
    /// Loaded Cartesian stiffness K_C of eq. (6): the change of the applied wrench per twist of P (N, N·mm; mm, rad).
    /// `None` where the machine is rigid in some direction or was not solved.
    pub stiffness: Option<Matrix6<f64>>,
    /// Loaded compliance, its inverse: twist of P per applied wrench. `None` where the platform is free or not solved.
    pub compliance: Option<Matrix6<f64>>,
    /// Twist of P per unit motion of each drive under constant load, one column per drive (mm, rad per mm or rad).
    #[serde(with = "columns")]
    pub drive_sensitivity: Matrix6xX<f64>,
}

/// Twists as the columns of a matrix: nalgebra serializes a matrix of any width only with its feature `std`, which brings `matrixmultiply`.
mod columns {
    use super::{Deserialize, Matrix6xX};

    pub fn serialize<S: serde::Serializer>(matrix: &Matrix6xX<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(matrix.column_iter().map(|column| <[f64; 6]>::from(column.into_owned())))
    }

    pub fn deserialize<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Matrix6xX<f64>, D::Error> {
        let columns = Vec::<[f64; 6]>::deserialize(deserializer)?;
        Ok(Matrix6xX::from_fn(columns.len(), |row, column| columns[column][row]))
    }
}

impl Outcome {
    /// Whether a direction of the platform is so soft that the nominal machine could be singular there.
    pub(crate) fn is_soft(&self, machine: &Machine) -> bool {
        match (&self.stiffness, &self.compliance) {
            (Some(stiffness), _) => {
                platform::definite_beyond(&platform::to_rows(stiffness), machine.characteristic_length, SOFT) == 0
            }
            // Rigid in some directions: against what a drive yields.
            (None, Some(compliance)) => {
                let lever = |i: usize| if i < 3 { 1.0 } else { machine.characteristic_length };
                let yields: f64 = (0..6).map(|i| compliance[(i, i)] * lever(i) * lever(i)).sum();
                yields.is_nan() || yields * SOFT > Scale::for_machine(machine).slack
            }
            (None, None) => true,
        }
    }

    /// Smallest eigenvalue in N/mm of the loaded stiffness, rotations at `scale` mm; of a machine that is rigid in some
    /// directions, that of the others. Negative where it is unstable; `None` where the platform is free or not solved.
    pub fn least_stiffness(&self, scale: f64) -> Option<f64> {
        match (&self.stiffness, &self.compliance) {
            (Some(stiffness), _) => Some(smallest_eigenvalue(stiffness, scale)),
            (None, Some(compliance)) if self.status == Status::Solved => {
                let largest = largest_compliance(compliance, scale);
                (largest > 0.0).then(|| 1.0 / largest)
            }
            _ => None,
        }
    }

    /// Whether the state is an equilibrium, stable or not.
    pub fn is_equilibrium(&self) -> bool {
        self.status.is_equilibrium()
    }
}

/// Error of the compensated task coordinates at a pose. Rows beyond `count` are zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TaskError {
    /// Number of compensated coordinates.
    pub count: usize,
    /// Actual less wanted: mm, and rad for rotations.
    pub error: Vector6<f64>,
    /// Derivative of the error by the twist of P in O axes.
    pub slope: Matrix6<f64>,
    /// Factor that makes each error a length: 1, or the machine's characteristic length in mm for rotations.
    pub lever: Vector6<f64>,
}

impl TaskError {
    /// Length of the error in mm, rotations taken at the machine's characteristic length.
    pub fn size(&self) -> f64 {
        let mut square = 0.0;
        for i in 0..6 {
            let length = self.error[i] * self.lever[i];
            square += length * length;
        }
        square.sqrt()
    }
}
