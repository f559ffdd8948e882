//! Report of readings predicted at other poses: a table, and sentences with cautions.

use super::{summary::Report, text};
use crate::{
    files::{
        counted,
        exchange::{Cell, Row, Table, numbers, texts},
        millimetres,
    },
    input::error::Result as InputResult,
    machine::Machine,
    questions::identification::{
        self, IdentificationStudy, Identified, Measurement, Prediction, RowUse, written_files::MachineFile,
    },
    simulation::{Failure, SOLVED},
    work::Work,
};

/// Readings predicted for the rows of a file.
#[derive(Debug, Clone)]
pub struct PredictedRows {
    /// A row for each reading: mm, rotations in degrees, with the standard deviations of its interval; or why a pose has none.
    pub table: Table,
    /// How well measured readings are predicted, with cautions; or why nothing is predicted.
    pub words: String,
    /// Whether all rows are predicted.
    pub is_complete: bool,
}

/// Fits the study and predicts the readings of the rows in the CSV text `source`, called `file` in messages. Without a fit each row says
/// why. `Err` as of [`identification::read`], or if the work was stopped.
pub fn predict_rows(study: &IdentificationStudy, source: &[u8], file: &str, work: &Work) -> InputResult<PredictedRows> {
    let poses = identification::read(source, file, &study.machine, RowUse::Predictions)?;
    // Intervals of predictions rest on the fit alone.
    let study = &IdentificationStudy { profile: false, folds: 0, alternatives: Vec::new(), ..study.clone() };
    let failure = match identification::run(study, work)? {
        Ok(results) if results.fit.is_converged => {
            let predictions = identification::predict(study, &results, &poses)?;
            let text = prediction_text(study, &results, &poses, &predictions);
            return Ok(PredictedRows::new(&poses, &predictions, text));
        }
        Ok(_) => {
            let reason = "the search for the parameters did not end".into();
            Failure { status: "not_converged".into(), reason }
        }
        Err(failure) => failure,
    };
    let text = format!("Nothing is predicted: {}.", failure.reason.trim_end_matches('.'));
    Ok(PredictedRows::new(&poses, &vec![Err(failure); poses.len()], text))
}

/// Predicts the readings of the rows in the CSV text `source`, called `file` in messages, for `machine` as it is, without intervals; its
/// chain errors act, but the commands do not know of them. `Err` as of [`identification::read`].
pub fn predict_rows_of(machine: &Machine, source: &[u8], file: &str) -> InputResult<PredictedRows> {
    let poses = identification::read(source, file, &machine.nominal()?, RowUse::Predictions)?;
    let predictions = identification::predict_as_is(machine, &poses)?;
    let text = text::beyond_travel(machine, &poses, |i| format!("pose {}", poses[i].name)).unwrap_or_default();
    Ok(PredictedRows::new(&poses, &predictions, text))
}

impl PredictedRows {
    /// Makes the result of `poses` with the predictions, or the reason for none, of each; `words` are the sentences about them.
    fn new(poses: &[Measurement], predictions: &[Result<Vec<Prediction>, Failure>], words: String) -> Self {
        Self { table: table(poses, predictions), words, is_complete: predictions.iter().all(Result::is_ok) }
    }
}

/// Makes the table of predicted readings, a row for each: mm, rotations in degrees; a pose without a prediction has one row with the reason.
fn table(poses: &[Measurement], predicted: &[Result<Vec<Prediction>, Failure>]) -> Table {
    let mut columns = texts(["pose", "reading", "status", "reason"]);
    columns.extend(numbers(["predicted", "low_95", "high_95", "std_numbers", "std_misfit", "std_reading", "measured"]));
    let mut rows: Vec<Row> = Vec::new();
    for (pose, predictions) in poses.iter().zip(predicted) {
        let predictions = match predictions {
            Ok(predictions) => predictions,
            Err(failure) => {
                let mut row: Row = vec![pose.name.as_str().into(), Cell::Missing];
                row.extend([Cell::from(&*failure.status), failure.reason.as_str().into()]);
                row.extend((0..7).map(|_| Cell::Missing));
                rows.push(row);
                continue;
            }
        };
        for prediction in predictions {
            let shown = |value: f64| if prediction.column.ends_with("_deg") { value.to_degrees() } else { value };
            let cell = |value: f64| Cell::from(value.is_finite().then(|| shown(value)));
            let mut row: Row = vec![pose.name.as_str().into(), prediction.column.into(), SOLVED.into(), Cell::Missing];
            row.extend(
                [prediction.value, prediction.value - prediction.half_width, prediction.value + prediction.half_width]
                    .map(cell),
            );
            row.extend(prediction.stds.map(cell));
            row.push(prediction.measured.map(shown).into());
            rows.push(row);
        }
    }
    Table::new(columns, rows)
}

/// Says how well the readings measured at `poses` are predicted, with the cautions of the identification.
fn prediction_text(
    study: &IdentificationStudy,
    results: &Identified,
    poses: &[Measurement],
    predicted: &[Result<Vec<Prediction>, Failure>],
) -> String {
    let of_lengths = predicted.iter().flatten().flatten().filter(|prediction| !prediction.column.ends_with("_deg"));
    let off: Vec<(f64, f64)> = of_lengths
        .filter_map(|prediction| Some((prediction.measured? - prediction.value, prediction.half_width)))
        .collect();
    let mut sentences = Vec::new();
    if !off.is_empty() {
        let rms = (off.iter().map(|(off, _)| off * off).sum::<f64>() / off.len() as f64).sqrt();
        let covered = off.iter().filter(|(off, half_width)| off.abs() <= *half_width).count();
        let lengths = counted(off.len(), "length");
        sentences.push(format!(
            "{lengths} read: predicted to {} RMS, {covered} within their 95 % interval.",
            millimetres(rms, 3)
        ));
    }
    let has_no_misfit = |prediction: &Prediction| !prediction.stds[1].is_finite();
    if predicted.iter().flatten().flatten().any(has_no_misfit) {
        sentences.push(
            "Lengths or rotations of which none were fitted have no interval: how much the model leaves of them is not known.".to_owned(),
        );
    }
    sentences.extend(text::beyond_travel(&study.machine, poses, |i| format!("pose {}", poses[i].name)));
    let file = MachineFile { text: None, left_out: Vec::new(), problem: None };
    let report = Report { study, results, file: &file, errors: &[] };
    sentences.extend(text::misfit_caution(&report));
    sentences.extend(text::unit_factor_text(&report));
    sentences.join(" ")
}
