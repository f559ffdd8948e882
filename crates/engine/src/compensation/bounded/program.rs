//! The convex program of one linearisation of the path, objective and limits as its rows: the only place that knows clarabel.
//!
//! With x the step of the drives in units that move the tool by about 1 mm, `e_k + J_k x_k` the linearised task errors of
//! the points over a length σ and `A x ≤ b` all limits, linearised and scaled row by row:
//!
//! ```text
//! Squares    min ½ Σ ‖e_k + J_k x_k‖²                                      A x ≤ b
//! Largest    min t                          ‖e_k + J_k x_k‖ ≤ t            A x ≤ b
//! Within t   min ½ Σ ‖e_k + J_k x_k‖²       ‖e_k + J_k x_k‖ ≤ t            A x ≤ b
//! Excess     min ξ + ½ ε ‖x‖²               A x ≤ b + ξ |limit| on forces, ξ ≥ 0
//! ```
//!
//! All objectives get `½ ε ‖x‖²`, which only matters where the drives are redundant or the objective leaves them free.

use clarabel::{
    algebra::CscMatrix,
    solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT},
};

use nalgebra::{DMatrix, DVector};

use super::{
    limits::{Bounds, LimitKind, Side},
    outcome::Errors,
    path::Simulation,
};

/// Objective of the program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Objective {
    /// Sum of squared errors.
    Squares,
    /// The largest error.
    Largest,
    /// Sum of squared errors, none of them above this, mm.
    Within(f64),
    /// Largest relative excess of a force over its limit.
    Excess,
}

/// One limit in the program: `coefficients · x ≤ margin`.
struct Row {
    limit: RowLimit,
    /// Column and coefficient.
    coefficients: Vec<(usize, f64)>,
    /// Distance to the limit, may be negative.
    margin: f64,
    /// Unit of the limit per unit of the row.
    scale: f64,
    /// Whether both ends of the limit are one: an equation.
    is_equation: bool,
}

/// The limit that a row stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RowLimit {
    /// Index among the points that take part.
    pub point: usize,
    pub drive: usize,
    pub kind: LimitKind,
    pub side: Side,
}

/// A limit that binds, and its multiplier: fall of the objective (mm² for squares, mm for the largest error) per unit of its relaxation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Multiplier {
    pub limit: RowLimit,
    pub value: f64,
}

/// Solution of the convex program.
pub(super) struct ConvexSolution {
    /// Step of each drive of each point, mm or rad.
    pub step: Vec<f64>,
    /// Limits that bind, with their multipliers.
    pub binding: Vec<Multiplier>,
    /// Value of the last variable: t in mm, or the relative excess ξ.
    pub extra: f64,
    /// Whether full accuracy was reached.
    pub is_accurate: bool,
    /// Interior-point iterations.
    pub iterations: usize,
}

/// Reason why there is no solution.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum NoSolution {
    /// The limits exclude one another.
    Infeasible,
    /// Anything else: the solver's word.
    Other(String),
}

/// Weight of the steps' own size in the objective.
const STEP_WEIGHT: f64 = 1e-9;
/// An interval shorter than this, mm at the tool, is a single value.
const SINGLE: f64 = 1e-9;
/// Errors below this length are not resolved, mm.
const SMALLEST_LENGTH: f64 = 1e-9;

/// The linearised path.
pub(super) struct LinearisedPath<'a> {
    results: &'a [Simulation],
    bounds: &'a Bounds,
    /// Drive motion that moves the tool by about 1 mm, mm or rad.
    unit: Vec<f64>,
    /// σ, mm.
    length: f64,
    rows: Vec<Row>,
}

impl<'a> LinearisedPath<'a> {
    /// The program linearised at `corrections` (point-major, mm or rad), which `bounds` must hold for, with the simulated `results` there.
    pub fn new(results: &'a [Simulation], corrections: &[f64], bounds: &'a Bounds) -> Self {
        let count = bounds.drive_count();
        let unit = (0..count).map(|i| motion_per_mm(results, i)).collect();
        let largest = results.iter().map(|result| result.error.norm()).fold(SMALLEST_LENGTH, f64::max);
        let mut program = Self { results, bounds, unit, length: largest, rows: Vec::new() };
        for k in 0..results.len() {
            for i in 0..count {
                program.add_range(k, i, corrections);
                program.add_change(k, i, corrections);
                program.add_force(k, i);
            }
        }
        program
    }

    /// Task errors after a step (point-major, mm or rad), by the linearisation.
    pub fn errors_after(&self, step: &[f64]) -> Errors {
        let steps = step.chunks_exact(self.bounds.drive_count());
        let error = |(result, step): (&Simulation, &[f64])| {
            (&result.error + &result.error_by_drives * DVector::from_column_slice(step)).norm()
        };
        Errors::from_lengths(self.results.iter().zip(steps).map(error))
    }

    /// Index of the variable of a drive at a point.
    fn column(&self, point: usize, drive: usize) -> usize {
        point * self.bounds.drive_count() + drive
    }

    /// Adds the limits on correction and travel of a drive at a point.
    fn add_range(&mut self, point: usize, drive: usize, corrections: &[f64]) {
        let (column, scale) = (self.column(point, drive), self.unit[drive]);
        let [low, high] = self.bounds.range[column];
        let is_equation = high.value - low.value <= SINGLE * scale;
        let ends = [(high.value, high.kind, 1.0, Side::Upper), (low.value, low.kind, -1.0, Side::Lower)];
        for (value, kind, sign, side) in ends.into_iter().take(if is_equation { 1 } else { 2 }) {
            let limit = RowLimit { point, drive, kind, side };
            let margin = sign * (value - corrections[column]) / scale;
            self.add_row(Row { limit, coefficients: vec![(column, sign)], margin, scale, is_equation });
        }
    }

    /// Adds the limit on the change of a drive's correction from the point before.
    fn add_change(&mut self, point: usize, drive: usize, corrections: &[f64]) {
        let (change, scale) = (self.bounds.change[drive], self.unit[drive]);
        if !self.bounds.is_consecutive[point] {
            return;
        }
        let (column, before) = (self.column(point, drive), self.column(point - 1, drive));
        let present = corrections[column] - corrections[before];
        let is_equation = change <= SINGLE * scale;
        let ends = [(1.0, Side::Upper), (-1.0, Side::Lower)];
        for (sign, side) in ends.into_iter().take(if is_equation { 1 } else { 2 }) {
            let limit = RowLimit { point, drive, kind: LimitKind::Change, side };
            let coefficients = vec![(column, sign), (before, -sign)];
            let margin = ((if is_equation { 0.0 } else { change }) - sign * present) / scale;
            self.add_row(Row { limit, coefficients, margin, scale, is_equation });
        }
    }

    /// Adds the linearised force limits of a drive at a point.
    fn add_force(&mut self, point: usize, drive: usize) {
        let largest = self.bounds.force[drive];
        let result = &self.results[point];
        let Some(by_drives) = &result.forces_by_drives else { return };
        let slope: Vec<f64> = self.unit.iter().enumerate().map(|(j, unit)| by_drives[(drive, j)] * unit).collect();
        // Where the drives have no influence the force itself is the scale, and the row says whether it is kept.
        let scale = slope.iter().map(|s| s * s).sum::<f64>().sqrt().max(1e-6 * largest);
        for (sign, side) in [(1.0, Side::Upper), (-1.0, Side::Lower)] {
            let limit = RowLimit { point, drive, kind: LimitKind::Force, side };
            let coefficients = (0..slope.len()).map(|j| (self.column(point, j), sign * slope[j] / scale)).collect();
            let margin = (largest - sign * result.forces[drive]) / scale;
            self.add_row(Row { limit, coefficients, margin, scale, is_equation: false });
        }
    }

    /// Adds a row, unless its limit is infinite.
    fn add_row(&mut self, row: Row) {
        if row.margin.is_finite() {
            self.rows.push(row);
        }
    }

    /// Solves the program for `goal`; `Err` if its limits exclude one another or the convex solver gives up.
    pub fn solve(&self, goal: Objective) -> Result<ConvexSolution, NoSolution> {
        let steps = self.results.len() * self.bounds.drive_count();
        let has_extra = matches!(goal, Objective::Largest | Objective::Excess);
        let variables = steps + usize::from(has_extra);
        let (hessian, gradient) = self.objective(goal, variables);
        let (equations, others): (Vec<&Row>, Vec<&Row>) = self.rows.iter().partition(|row| row.is_equation);
        let order: Vec<&Row> = equations.iter().chain(&others).copied().collect();
        let mut constraints = self.linear_constraints(goal, steps, &order);
        let inequalities = constraints.right.len() - equations.len();
        let mut cones =
            vec![SupportedConeT::ZeroConeT(equations.len()), SupportedConeT::NonnegativeConeT(inequalities)];
        self.add_cones(goal, steps, &mut constraints, &mut cones);
        let matrix = constraints.matrix(variables);
        let mut solver =
            DefaultSolver::new(&hessian, &gradient, &matrix, &constraints.right, &cones, solver_settings(goal))
                .map_err(|error| NoSolution::Other(error.to_string()))?;
        solver.solve();
        let solution = &solver.solution;
        let is_accurate = match solution.status {
            SolverStatus::Solved => true,
            SolverStatus::AlmostSolved => false,
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
                return Err(NoSolution::Infeasible);
            }
            status => return Err(NoSolution::Other(format!("{status:?}"))),
        };
        let count = self.bounds.drive_count();
        let unscaled = |(column, value): (usize, &f64)| value * self.unit[column % count];
        let multipliers = order.iter().zip(solution.s.iter().zip(&solution.z));
        Ok(ConvexSolution {
            step: solution.x[..steps].iter().enumerate().map(unscaled).collect(),
            binding: multipliers.filter_map(|(row, (slack, dual))| self.multiplier(goal, row, *slack, *dual)).collect(),
            extra: if has_extra { solution.x[steps] * self.extra_scale(goal) } else { 0.0 },
            is_accurate,
            iterations: solution.iterations as usize,
        })
    }

    /// Constraints `A x ≤ b` of the rows in `order`; for [`Objective::Excess`], forces may exceed theirs by ξ, the variable in column `steps`.
    fn linear_constraints(&self, goal: Objective, steps: usize, order: &[&Row]) -> Constraints {
        let mut constraints = Constraints::default();
        for row in order {
            constraints.add_row(row.coefficients.iter().copied(), row.margin);
            if goal == Objective::Excess && row.limit.kind == LimitKind::Force {
                constraints.append_entry(steps, -self.bounds.force[row.limit.drive] / row.scale);
            }
        }
        if goal == Objective::Excess {
            constraints.add_row([(steps, -1.0)], 0.0);
        }
        constraints
    }

    /// Multiplier of a row whose limit binds, else `None`: interior points leave either `slack` or `dual` well away from zero.
    fn multiplier(&self, goal: Objective, row: &Row, slack: f64, dual: f64) -> Option<Multiplier> {
        let mut limit = row.limit;
        if row.is_equation && dual < 0.0 {
            limit.side = Side::Lower;
        }
        let value = self.multiplier_scale(goal) * dual.abs() / row.scale;
        (row.is_equation || dual > slack).then_some(Multiplier { limit, value })
    }

    /// Unit of the objective, in mm² or mm.
    fn multiplier_scale(&self, goal: Objective) -> f64 {
        match goal {
            Objective::Squares | Objective::Within(_) => self.length * self.length,
            Objective::Largest => self.length,
            Objective::Excess => 1.0,
        }
    }

    /// Unit of the last variable: mm for the largest error, else 1.
    fn extra_scale(&self, goal: Objective) -> f64 {
        if goal == Objective::Largest { self.length } else { 1.0 }
    }

    /// Sensitivity `J_k` and error `e_k` of point `point` in the program's units: lengths over σ, steps over `unit`.
    fn scaled_linearisation(&self, point: usize) -> (DMatrix<f64>, DVector<f64>) {
        let result = &self.results[point];
        let mut slope = &result.error_by_drives / self.length;
        for (mut column, unit) in slope.column_iter_mut().zip(&self.unit) {
            column *= *unit;
        }
        (slope, &result.error / self.length)
    }

    /// Hessian (upper triangle) and gradient of the objective over the program's variables, whose number is `variables`.
    fn objective(&self, goal: Objective, variables: usize) -> (CscMatrix<f64>, Vec<f64>) {
        let count = self.bounds.drive_count();
        let mut hessian = Triplets::default();
        let mut gradient = vec![0.0; variables];
        for point in 0..self.results.len() {
            let first = self.column(point, 0);
            let squares = match goal {
                Objective::Squares | Objective::Within(_) => {
                    let (slope, error) = self.scaled_linearisation(point);
                    let linear = slope.tr_mul(&error);
                    gradient[first..first + count].copy_from_slice(linear.as_slice());
                    slope.tr_mul(&slope)
                }
                Objective::Largest | Objective::Excess => DMatrix::zeros(count, count),
            };
            for j in 0..count {
                for i in 0..=j {
                    let step_weight = if i == j { STEP_WEIGHT } else { 0.0 };
                    hessian.push(first + i, first + j, squares[(i, j)] + step_weight);
                }
            }
        }
        if matches!(goal, Objective::Largest | Objective::Excess) {
            gradient[variables - 1] = 1.0;
        }
        (hessian.matrix(variables, variables), gradient)
    }

    /// Adds the cones `‖e_k + J_k x_k‖ ≤ t` where `goal` bounds the largest error: t is variable `step_count`, or fixed ([`Objective::Within`]).
    fn add_cones(
        &self,
        goal: Objective,
        step_count: usize,
        constraints: &mut Constraints,
        cones: &mut Vec<SupportedConeT<f64>>,
    ) {
        let fixed_bound = match goal {
            Objective::Largest => None,
            Objective::Within(bound) => Some(bound / self.length),
            Objective::Squares | Objective::Excess => return,
        };
        for point in 0..self.results.len() {
            let (slope, error) = self.scaled_linearisation(point);
            let first = self.column(point, 0);
            match fixed_bound {
                Some(bound) => constraints.add_row([], bound),
                None => constraints.add_row([(step_count, -1.0)], 0.0),
            }
            for (row, error) in slope.row_iter().zip(error.iter()) {
                constraints.add_row(row.iter().enumerate().map(|(j, value)| (first + j, -value)), *error);
            }
            cones.push(SupportedConeT::SecondOrderConeT(1 + error.len()));
        }
    }
}

/// Motion of a drive (mm or rad) that moves the tool by about 1 mm: the inverse of its root mean square sensitivity along the path.
pub(super) fn motion_per_mm(results: &[Simulation], drive: usize) -> f64 {
    let squares: f64 = results.iter().map(|result| result.error_by_drives.column(drive).norm_squared()).sum();
    let mean = (squares / results.len().max(1) as f64).sqrt();
    if mean > 0.0 { 1.0 / mean } else { 1.0 }
}

/// Settings of clarabel, as accurate as it gets: programs with cones end at 10⁻⁸ of the length σ.
fn solver_settings(goal: Objective) -> DefaultSettings<f64> {
    let (tolerance, reduced) = match goal {
        Objective::Squares | Objective::Excess => (1e-10, 1e-6),
        Objective::Largest | Objective::Within(_) => (1e-8, 1e-5),
    };
    DefaultSettings {
        verbose: false,
        presolve_enable: false,
        tol_gap_abs: tolerance,
        tol_gap_rel: tolerance,
        tol_feas: tolerance,
        reduced_tol_gap_abs: reduced,
        reduced_tol_gap_rel: reduced,
        reduced_tol_feas: reduced,
        max_threads: 1,
        ..DefaultSettings::default()
    }
}

/// Entries of a sparse matrix.
#[derive(Default)]
struct Triplets {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

impl Triplets {
    /// Adds an entry.
    fn push(&mut self, row: usize, column: usize, value: f64) {
        self.rows.push(row);
        self.columns.push(column);
        self.values.push(value);
    }

    /// The sparse matrix of the entries.
    fn matrix(self, rows: usize, columns: usize) -> CscMatrix<f64> {
        CscMatrix::new_from_triplets(rows, columns, self.rows, self.columns, self.values)
    }
}

/// Rows `b − A x` that cones constrain.
#[derive(Default)]
struct Constraints {
    entries: Triplets,
    right: Vec<f64>,
}

impl Constraints {
    /// Adds a row with these coefficients of A and its entry of b.
    fn add_row(&mut self, coefficients: impl IntoIterator<Item = (usize, f64)>, right: f64) {
        for (column, value) in coefficients {
            self.entries.push(self.right.len(), column, value);
        }
        self.right.push(right);
    }

    /// Adds an entry of A to the last row.
    fn append_entry(&mut self, column: usize, value: f64) {
        self.entries.push(self.right.len() - 1, column, value);
    }

    /// The matrix A, whose entries are taken out.
    fn matrix(&mut self, variables: usize) -> CscMatrix<f64> {
        std::mem::take(&mut self.entries).matrix(self.right.len(), variables)
    }
}
