//! Corrections as a table that a controller reads: Figure 1a of the paper.
//!
//! At each node of a grid over positions of P, for each drive, the correction Δρ by which the loaded tool is where it is wanted, as a polynomial in
//! the force on the tool tip, so that one table serves measured and predicted forces. Between nodes the controller interpolates linearly along each
//! axis. The grid is the smallest whose worst error at the tool, sought over positions and forces with the loaded machine itself, keeps a tolerance.

mod bound;
mod corrector;
mod loaded;
#[cfg(feature = "report")]
pub mod report;
mod smallest;
mod table;

pub use bound::{Worst, worst};
pub use corrector::{Corrector, JointTable};
pub use loaded::{ResidualPoint, residual_grid, residuals};
pub use table::{CorrectionTable, ForceTerms};

use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

use crate::{
    compensation::Target,
    input::error::Result,
    machine::{ChainError, Machine},
    process::{ForceLaw, MillingForce, Process, cutting::CuttingLaw, uncertainty::Uncertainty},
    products::field::{self, FieldCase, FieldSpread},
    questions::Overrides,
    simulation::Machines,
    spatial::Grid,
    work::Work,
};

/// Input of a correction table.
#[derive(Debug, Clone)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct CorrectionQuestion {
    /// The nominal machine with the tool of the process, by which positions are commanded.
    pub machine: Machine,
    /// Errors of each chain of the actual machine.
    pub errors: Vec<ChainError>,
    /// What is compensated: P, tool tip or full pose.
    pub target: Target,
    /// Commanded orientation `R_OP` of the platform.
    pub orientation: Matrix3<f64>,
    /// Smallest and largest position of P in O, mm.
    pub corners: [Vector3<f64>; 2],
    /// Largest force on the tool tip that the table is for, N.
    pub largest_force_N: f64,
    /// Tolerance: largest distance of the tool from where it is wanted, mm.
    pub tolerance_mm: f64,
    /// By which distance machines as they may be are judged, mm: that of the process, else the tolerance of the table.
    pub judged_mm: f64,
    /// Number of nodes along x, y and z; `None` for the smallest number within tolerance.
    pub counts: Option<[usize; 3]>,
    /// What is not known exactly; `None` where all inputs are taken as exact.
    pub uncertainty: Option<Uncertainty>,
}

/// A correction table and the residual errors with it.
#[derive(Debug, Clone, Serialize)]
pub struct CorrectionResult {
    /// The table.
    pub table: CorrectionTable,
    /// Largest error found with the table.
    pub with_table: Worst,
    /// Largest error at the nodes with the table, mm: a finer grid does not reduce it, since it comes from the terms in the force.
    pub at_nodes_mm: f64,
    /// Largest error found without correction.
    pub without: Worst,
    /// Tables of single drives and the largest error with them; or why there are none.
    pub per_joint: std::result::Result<(Vec<JointTable>, Worst), String>,
    /// Distances on machines and under forces as they may be without correction, with the table, and with tables of single drives if there are any; `None`
    /// where inputs are taken as exact.
    pub spread: Option<FieldSpread>,
}

impl CorrectionResult {
    /// Returns whether the largest error with tables of single drives is smaller than without correction.
    pub fn is_per_joint_of_use(&self) -> bool {
        self.per_joint.as_ref().is_ok_and(|(_, worst)| worst.error_mm < self.without.error_mm)
    }

    /// Returns whether the largest error with tables of single drives is larger than without correction.
    pub fn is_per_joint_harmful(&self) -> bool {
        self.per_joint.as_ref().is_ok_and(|(_, worst)| worst.error_mm > self.without.error_mm)
    }
}

impl CorrectionQuestion {
    /// Describes a table over `corners` (P in O, mm; `None`: the workspace) for forces up to `largest_force_N` (`None`: that of `process`).
    ///
    /// # Errors
    /// An invalid box, force, tolerance or number of nodes; a process whose largest force is known only along a path.
    #[allow(non_snake_case, reason = "the unit is N, not n")]
    pub fn new(
        process: &Process,
        corners: Option<[Vector3<f64>; 2]>,
        largest_force_N: Option<f64>,
        tolerance_mm: f64,
        counts: Option<[usize; 3]>,
    ) -> Result<Self> {
        let machine = process.machine.clone();
        let largest_force_N = match largest_force_N {
            Some(force) if force >= 0.0 && force.is_finite() => force,
            Some(force) => return Overrides::location("force-N").fail(format!("must be at least 0, got {force}")),
            None => process_largest_force(process).or_else(|problem| Overrides::location("force-N").fail(problem))?,
        };
        let question = Self {
            errors: process.errors.clone(),
            target: process.target,
            orientation: process.placement.platform_orientation(&machine.home.pose.rotation),
            corners: table::corners(&machine, corners)?,
            largest_force_N,
            tolerance_mm: Overrides::location("tolerance").positive(tolerance_mm)?,
            judged_mm: process.tolerance_mm.unwrap_or(tolerance_mm),
            counts: None,
            uncertainty: process
                .uncertainty
                .as_ref()
                .map(|table| table.of_box(&machine, &process.errors))
                .transpose()?,
            machine,
        };
        let counts = counts.map(|counts| table::check_counts(&question, counts)).transpose()?;
        Ok(Self { counts, ..question })
    }

    /// Returns a grid over the box with `points` nodes along each axis in which it has extent, and one along others.
    fn grid(&self, points: impl Fn(usize) -> usize) -> Grid {
        let [min, max] = self.corners;
        Grid::new(min, max, [0, 1, 2].map(|axis| if min[axis] < max[axis] { points(axis) } else { 1 }))
    }

    /// Returns the axes of O along which the box has extent.
    pub fn axes(&self) -> impl Iterator<Item = usize> {
        (0..3).filter(|&axis| self.corners[0][axis] < self.corners[1][axis])
    }
}

/// Computes the correction table and searches its largest errors, on the current rayon pool, with the same result on any.
///
/// # Errors
/// A position that the machine does not reach, or without equilibrium under a force; too small a tolerance; errors of `work`.
pub fn answer(question: &CorrectionQuestion, work: &Work) -> Result<CorrectionResult> {
    let machines = Machines::new(&question.machine, &question.errors)?;
    let found = smallest::smallest_table(question, &machines, work)?;
    let cells = &found.table.grid;
    let without = worst(question, &machines, &Corrector::Nothing, cells, f64::INFINITY, work)?;
    let per_joint = match corrector::joint_tables(question, &machines, &found.table)? {
        Ok(tables) => {
            let worst = worst(question, &machines, &Corrector::PerJoint(&tables), cells, f64::INFINITY, work)?;
            Ok((tables, worst))
        }
        Err(reason) => Err(reason),
    };
    let smallest::CheckedTable { table, worst: with_table, at_nodes_mm } = found;
    let tables = per_joint.as_ref().ok().map(|(tables, _)| Corrector::PerJoint(tables));
    let ways: Vec<_> = [Corrector::Nothing, Corrector::Table(&table)].into_iter().chain(tables).collect();
    let cases = || field_cases(question, &machines, &ways, [&without, &with_table]);
    let (uncertainty, tolerance_mm) = (question.uncertainty.as_ref(), Some(question.judged_mm));
    let spread = FieldSpread::solve(uncertainty, &machines, &question.errors, cases, tolerance_mm, work)?;
    Ok(CorrectionResult { table, with_table, at_nodes_mm, without, per_joint, spread })
}

/// Returns the cases by which `ways` to correct are checked where inputs are uncertain: at corners, middles of edges and faces and the middle of the box and
/// where the nominal errors `worst` are, each under no force, the largest one along each axis, those of `worst`, and the one that bends most there.
fn field_cases(
    question: &CorrectionQuestion,
    machines: &Machines,
    ways: &[Corrector<'_>],
    worst: [&Worst; 2],
) -> Result<Vec<FieldCase>> {
    let (grid, mut loaded) = (question.grid(|_| 3), loaded::LoadedMachine::new(question, machines));
    let places: Vec<Vector3<f64>> =
        (0..grid.len()).map(|index| grid.position(index)).chain(worst.map(|own| own.position_mm.into())).collect();
    let mut forces = bound::axis_forces(question.largest_force_N);
    forces.extend(worst.map(|own| Vector3::from(own.force_N)));
    let tried = bound::force_directions(question.largest_force_N);
    field::cases(machines, &places, [&forces, &tried], |&position, &force| {
        let at = loaded.nominal_at(position)?;
        let drives = |way: &Corrector<'_>| {
            let correction = way.correction(&at, position, force);
            at.drives.iter().zip(correction).map(|(nominal, own)| nominal + own).collect()
        };
        let (drives, task) = (ways.iter().map(drives).collect(), loaded.reset_to(&at, force));
        Ok(FieldCase { task, at, position, drives })
    })
}

/// Returns the largest force of a process on the tool tip, N, whatever its path; an error if it is known only along a path.
#[allow(non_snake_case, reason = "the unit is N, not n")]
fn process_largest_force(process: &Process) -> std::result::Result<f64, String> {
    let (tool_forces, first) = (&process.own_forces, std::iter::once(&process.cutting));
    let mut all = first.chain(tool_forces.by_tool.values()).chain(tool_forces.by_feature.iter().map(|(_, law)| law));
    all.try_fold(0.0, |most: f64, law| Ok(most.max(law_largest_force(law)?)))
}

/// Returns the largest force of a cutting-force law, N; `Err` if it is known only along a path.
fn law_largest_force(law: &CuttingLaw) -> std::result::Result<f64, String> {
    match law {
        CuttingLaw::None => Ok(0.0),
        CuttingLaw::PathFrame(frame) => Ok(largest_milling_force(&frame.force)),
        CuttingLaw::Table(table) => Ok(table.largest_force_N()),
        _ => Err(
            "the force of this process is known only along a path: expected the largest force that the table is for"
                .into(),
        ),
    }
}

/// Returns the largest size of a milling force over all immersion directions φ, N.
fn largest_milling_force(force: &MillingForce) -> f64 {
    let (radial, tangential) = (force.radial.abs(), force.tangential.abs());
    let across = match force.law {
        // |F|² = F_r² + F_t² + 2 F_r F_t sin 2φ.
        ForceLaw::PaperEq17 => radial + tangential,
        ForceLaw::Rotated => libm::hypot(radial, tangential),
    };
    libm::hypot(across, force.axial)
}
