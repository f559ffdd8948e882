//! The next measurements: which poses and loads tell most of some numbers of a machine, and how far those will be known.

mod candidates;
mod choose;
#[cfg(feature = "report")]
mod report;
mod resolve;
pub(crate) mod spec;

use nalgebra::{DMatrix, DVector};

pub use candidates::{Region, end_of_arm};
pub use choose::{Choice, Criterion, Widths, widths};
pub use spec::CriterionSpec;

use crate::{
    input::error::Result,
    machine::Machine,
    questions::identification::{LoadedModel, Measurement, Noise, Predicted, Unknown},
    simulation::Failure,
    work::{Event, Work},
};

/// A checked plan of measurements.
#[derive(Debug, Clone)]
pub struct MeasurementDesignStudy {
    /// The machine as it is known so far.
    pub machine: Machine,
    /// What is sought.
    pub unknowns: Vec<Unknown>,
    /// What is known beforehand: the unknown, its coordinate and the standard deviation of that.
    pub priors: Vec<(usize, f64, f64)>,
    /// Measurements that have been made.
    pub measured: Vec<Measurement>,
    /// What may be measured.
    pub candidates: Vec<Measurement>,
    /// Poses and loads whose prediction counts.
    pub tested: Vec<Measurement>,
    /// Of readings that have no standard deviation of their own.
    pub noise: Noise,
    /// What is made small.
    pub criterion: CriterionSpec,
    /// How many measurements are to be chosen.
    pub count: usize,
    /// Half a 95 % interval that is enough, in coordinates of the unknowns.
    pub target: Option<f64>,
    /// Random choices to compare with.
    pub draws: usize,
}

/// What was chosen.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The candidates chosen, that which tells most first.
    pub chosen: Vec<usize>,
    /// Why a candidate could not be computed.
    pub failures: Vec<(usize, Failure)>,
    /// How far the unknowns are known with 0, 1, 2, … of the chosen.
    pub widths: Vec<Widths>,
    /// The same of random choices of as many: the median of each over all draws.
    pub random: Vec<Widths>,
    /// Most that any candidate's readings change with each unknown, standard deviations per unit of its coordinate.
    pub most_information: Vec<f64>,
}

/// Nothing is known of an unknown beforehand but that it is within a factor of e^1000, 1000 mm, 1000 degrees.
const NOTHING_KNOWN: f64 = 1e-6;

impl MeasurementDesignStudy {
    fn rows(&self, model: &LoadedModel, asked: &[Measurement]) -> Vec<std::result::Result<DMatrix<f64>, Failure>> {
        let asked: Vec<&Measurement> = asked.iter().collect();
        let predicted = model.each(&asked).into_iter().zip(&asked);
        let in_deviations = |predicted: Predicted, own: &Measurement| {
            let mut slopes = predicted.slopes;
            for (mut row, reading) in slopes.row_iter_mut().zip(&own.readings) {
                row /= self.noise.of(reading);
            }
            slopes
        };
        predicted.map(|(found, own)| found.map(|predicted| in_deviations(predicted, own))).collect()
    }
}

/// Chooses the measurements; on the current rayon pool, with the same result for any number of threads.
///
/// # Errors
/// The work was stopped, or the machine's numbers cannot be varied.
pub fn run(study: &MeasurementDesignStudy, work: &Work) -> Result<std::result::Result<Plan, Failure>> {
    work.check()?;
    let start = DVector::zeros(study.unknowns.len());
    let model = LoadedModel::new(&study.machine, &study.unknowns, &start, &study.unknowns)?;
    let (mut candidates, mut of, mut failures) = (Vec::new(), Vec::new(), Vec::new());
    for (first, part) in study.candidates.chunks(PROGRESS).enumerate() {
        work.check()?;
        for (k, rows) in study.rows(&model, part).into_iter().enumerate() {
            match rows {
                Ok(rows) => {
                    candidates.push(rows);
                    of.push(first * PROGRESS + k);
                }
                Err(failure) => failures.push((first * PROGRESS + k, failure)),
            }
        }
        work.tell(Event::Computed(part.len()));
    }
    let known = match known(study, &model) {
        Ok(known) => known,
        Err(failure) => return Ok(Err(failure)),
    };
    let criterion = match study.criterion {
        CriterionSpec::AllNumbers => Criterion::AllNumbers,
        CriterionSpec::Tested => match tested(study, &model) {
            Ok(tested) => Criterion::Tested(tested),
            Err(failure) => return Ok(Err(failure)),
        },
    };
    let choice = Choice { candidates: &candidates, known, criterion };
    work.check()?;
    let chosen = choice.chosen(study.count, work)?;
    work.check()?;
    let most = |k: usize| candidates.iter().map(|rows| rows.column(k).norm()).fold(0.0, f64::max);
    Ok(Ok(Plan {
        widths: widths(&choice, &chosen),
        random: choose::random(&choice, chosen.len(), study.draws),
        most_information: (0..study.unknowns.len()).map(most).collect(),
        chosen: chosen.into_iter().map(|i| of[i]).collect(),
        failures,
    }))
}

/// Candidates between two reports of progress.
const PROGRESS: usize = 64;

/// Information of the priors and of what was measured.
fn known(study: &MeasurementDesignStudy, model: &LoadedModel) -> std::result::Result<DMatrix<f64>, Failure> {
    let count = study.unknowns.len();
    let mut known = DMatrix::identity(count, count) * NOTHING_KNOWN;
    for &(k, _, std) in &study.priors {
        known[(k, k)] += 1.0 / (std * std);
    }
    for (rows, own) in study.rows(model, &study.measured).into_iter().zip(&study.measured) {
        let rows = rows.map_err(|failure| Failure {
            reason: format!("measurement {} that was made: {}", own.name, failure.reason),
            ..failure
        })?;
        known += rows.transpose() * rows;
    }
    Ok(known)
}

/// The mean over the tested of what the unknowns do to where the tool is, mm² per square of their coordinates.
fn tested(study: &MeasurementDesignStudy, model: &LoadedModel) -> std::result::Result<DMatrix<f64>, Failure> {
    let count = study.unknowns.len();
    let mut sum = DMatrix::zeros(count, count);
    let tested: Vec<&Measurement> = study.tested.iter().collect();
    for (predicted, own) in model.each(&tested).into_iter().zip(&study.tested) {
        let predicted = predicted
            .map_err(|failure| Failure { reason: format!("tested row {}: {}", own.name, failure.reason), ..failure })?;
        sum += predicted.slopes.transpose() * predicted.slopes;
    }
    Ok(sum / study.tested.len() as f64)
}
