//! Design of measurements: which poses and loads are most informative about parameters of a machine, and how wide their intervals will be.

mod candidates;
mod choose;
#[cfg(feature = "report")]
mod report;
mod resolve;
pub(crate) mod spec;

use nalgebra::{DMatrix, DVector};

pub use candidates::{Region, end_of_arm};
#[cfg(feature = "report")]
pub(crate) use candidates::{plan_measurements, poses};
pub use choose::{Criterion, DesignProblem, HalfWidths, widths};
pub use spec::CriterionSpec;

use crate::{
    input::error::Result,
    machine::Machine,
    questions::identification::{LoadedModel, Measurement, Noise, Predicted, Unknown},
    simulation::Failure,
    work::{Event, Work},
};

/// A checked design of measurements.
#[derive(Debug, Clone)]
pub struct MeasurementDesignStudy {
    /// Machine with the parameters known so far.
    pub machine: Machine,
    /// Parameters to identify.
    pub unknowns: Vec<Unknown>,
    /// Gaussian priors: index of the unknown, expected coordinate, standard deviation of that coordinate.
    pub priors: Vec<(usize, f64, f64)>,
    /// Measurements made already.
    pub measured: Vec<Measurement>,
    /// Candidate measurements.
    pub candidates: Vec<Measurement>,
    /// Poses and loads at which the prediction of the tool counts.
    pub tested: Vec<Measurement>,
    /// Standard deviations of readings that have none of their own.
    pub noise: Noise,
    /// Design criterion.
    pub criterion: CriterionSpec,
    /// Number of measurements to choose.
    pub count: usize,
    /// Half width of a 95 % interval that is sufficient, in coordinates of the unknowns.
    pub target: Option<f64>,
    /// Number of random choices to compare with.
    pub draws: usize,
}

/// Results of a design: the chosen measurements and the intervals that they will give.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Indices of the chosen candidates, the most informative first.
    pub chosen: Vec<usize>,
    /// Indices of candidates that could not be computed, and why.
    pub failures: Vec<(usize, Failure)>,
    /// Half widths with 0, 1, 2, … of the chosen candidates.
    pub widths: Vec<HalfWidths>,
    /// Half widths with as many random candidates: the median of each over all draws.
    pub random: Vec<HalfWidths>,
    /// Largest sensitivity of any candidate to each unknown, standard deviations of readings per unit of its coordinate.
    pub most_information: Vec<f64>,
}

/// Information on each unknown without priors and measurements: a standard deviation of 1000 in its coordinate.
const NOTHING_KNOWN: f64 = 1e-6;

impl MeasurementDesignStudy {
    /// Returns the Jacobian of each measurement over the standard deviations of its readings, or why it is not known.
    fn jacobians(&self, model: &LoadedModel, asked: &[Measurement]) -> Vec<std::result::Result<DMatrix<f64>, Failure>> {
        let asked: Vec<&Measurement> = asked.iter().collect();
        let predicted = model.each(&asked).into_iter().zip(&asked);
        let over_stds = |predicted: Predicted, one: &Measurement| {
            let mut slopes = predicted.slopes;
            for (mut row, reading) in slopes.row_iter_mut().zip(&one.readings) {
                row /= self.noise.of(reading);
            }
            slopes
        };
        predicted.map(|(found, one)| found.map(|predicted| over_stds(predicted, one))).collect()
    }
}

/// Chooses the measurements, on the current rayon pool; results do not depend on the number of threads. `Err` if the work was stopped or a
/// parameter cannot be varied; the inner `Err` says where the machine has no equilibrium.
pub fn run(study: &MeasurementDesignStudy, work: &Work) -> Result<std::result::Result<Plan, Failure>> {
    work.check()?;
    let start = DVector::zeros(study.unknowns.len());
    let model = LoadedModel::new(&study.machine, &study.unknowns, &start, &study.unknowns)?;
    let (mut candidates, mut candidate_of, mut failures) = (Vec::new(), Vec::new(), Vec::new());
    for (first, part) in study.candidates.chunks(PROGRESS).enumerate() {
        work.check()?;
        for (k, rows) in study.jacobians(&model, part).into_iter().enumerate() {
            match rows {
                Ok(rows) => {
                    candidates.push(rows);
                    candidate_of.push(first * PROGRESS + k);
                }
                Err(failure) => failures.push((first * PROGRESS + k, failure)),
            }
        }
        work.tell(Event::Computed(part.len()));
    }
    let known = match base_information(study, &model) {
        Ok(known) => known,
        Err(failure) => return Ok(Err(failure)),
    };
    let criterion = match study.criterion {
        CriterionSpec::AllNumbers => Criterion::AllNumbers,
        CriterionSpec::Tested => match weight_matrix(study, &model) {
            Ok(tested) => Criterion::Tested(tested),
            Err(failure) => return Ok(Err(failure)),
        },
    };
    let problem = DesignProblem { candidates: &candidates, known, criterion };
    work.check()?;
    let chosen = problem.choose(study.count, work)?;
    work.check()?;
    let largest_norm = |k: usize| candidates.iter().map(|rows| rows.column(k).norm()).fold(0.0, f64::max);
    Ok(Ok(Plan {
        widths: widths(&problem, &chosen),
        random: choose::random_widths(&problem, chosen.len(), study.draws),
        most_information: (0..study.unknowns.len()).map(largest_norm).collect(),
        chosen: chosen.into_iter().map(|i| candidate_of[i]).collect(),
        failures,
    }))
}

/// Number of candidates between two reports of progress.
const PROGRESS: usize = 64;

/// Returns the information matrix of the priors and of the measurements made already. `Err` if one of these has no equilibrium.
fn base_information(study: &MeasurementDesignStudy, model: &LoadedModel) -> std::result::Result<DMatrix<f64>, Failure> {
    let count = study.unknowns.len();
    let mut information = DMatrix::identity(count, count) * NOTHING_KNOWN;
    for &(k, _, std) in &study.priors {
        information[(k, k)] += 1.0 / (std * std);
    }
    for (rows, measurement) in study.jacobians(model, &study.measured).into_iter().zip(&study.measured) {
        let rows = rows.map_err(|failure| Failure {
            reason: format!("measurement {} that was made: {}", measurement.name, failure.reason),
            ..failure
        })?;
        information += rows.transpose() * rows;
    }
    Ok(information)
}

/// Returns the mean of `JᵀJ` over tested rows, J the Jacobian of the tool's displacement, mm² per square of coordinates. `Err` if one
/// fails.
fn weight_matrix(study: &MeasurementDesignStudy, model: &LoadedModel) -> std::result::Result<DMatrix<f64>, Failure> {
    let count = study.unknowns.len();
    let mut sum = DMatrix::zeros(count, count);
    let tested: Vec<&Measurement> = study.tested.iter().collect();
    for (predicted, row) in model.each(&tested).into_iter().zip(&study.tested) {
        let predicted = predicted
            .map_err(|failure| Failure { reason: format!("tested row {}: {}", row.name, failure.reason), ..failure })?;
        sum += predicted.slopes.transpose() * predicted.slopes;
    }
    Ok(sum / study.tested.len() as f64)
}
