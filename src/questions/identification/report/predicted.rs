//! Report of readings predicted at other poses: a table, and sentences with cautions.

use super::{summary::Report, text};
use crate::{
    files::{
        counted,
        exchange::{Cell, Row, Table, numbers, texts},
        millimetres,
    },
    questions::identification::{IdentificationStudy, Identified, Measurement, Prediction, written_files::MachineFile},
    simulation::{Failure, SOLVED},
};

/// Makes the table of predicted readings, a row for each: mm, rotations in degrees, with the standard deviations of the interval.
pub fn table(poses: &[Measurement], predicted: &[Result<Vec<Prediction>, Failure>]) -> Table {
    let mut columns = texts(["pose", "reading", "status", "reason"]);
    columns.extend(numbers(["predicted", "low_95", "high_95", "std_numbers", "std_misfit", "std_reading", "measured"]));
    let mut rows: Vec<Row> = Vec::new();
    for (pose, answers) in poses.iter().zip(predicted) {
        let answers = match answers {
            Ok(answers) => answers,
            Err(failure) => {
                let mut row: Row = vec![pose.name.as_str().into(), Cell::Missing];
                row.extend([Cell::from(&*failure.status), failure.reason.as_str().into()]);
                row.extend((0..7).map(|_| Cell::Missing));
                rows.push(row);
                continue;
            }
        };
        for own in answers {
            let shown = |value: f64| if own.column.ends_with("_deg") { value.to_degrees() } else { value };
            let cell = |value: f64| Cell::from(value.is_finite().then(|| shown(value)));
            let mut row: Row = vec![pose.name.as_str().into(), own.column.into(), SOLVED.into(), Cell::Missing];
            row.extend([own.value, own.value - own.half_width, own.value + own.half_width].map(cell));
            row.extend(own.stds.map(cell));
            row.push(own.measured.map(shown).into());
            rows.push(row);
        }
    }
    Table::new(columns, rows)
}

/// Says how well the readings measured at `poses` are predicted, with the cautions of the identification.
pub fn prediction_words(
    study: &IdentificationStudy,
    found: &Identified,
    poses: &[Measurement],
    predicted: &[Result<Vec<Prediction>, Failure>],
) -> String {
    let of_lengths = predicted.iter().flatten().flatten().filter(|own| !own.column.ends_with("_deg"));
    let off: Vec<(f64, f64)> = of_lengths.filter_map(|own| Some((own.measured? - own.value, own.half_width))).collect();
    let mut said = Vec::new();
    if !off.is_empty() {
        let rms = (off.iter().map(|(off, _)| off * off).sum::<f64>() / off.len() as f64).sqrt();
        let held = off.iter().filter(|(off, half_width)| off.abs() <= *half_width).count();
        let lengths = counted(off.len(), "length");
        said.push(format!(
            "{lengths} read: predicted to {} RMS, {held} within their 95 % interval.",
            millimetres(rms, 3)
        ));
    }
    let has_no_misfit = |own: &Prediction| !own.stds[1].is_finite();
    if predicted.iter().flatten().flatten().any(has_no_misfit) {
        said.push(
            "Lengths or rotations of which none were fitted have no interval: how much the model leaves of them is not known.".to_owned(),
        );
    }
    said.extend(text::beyond_travel(&study.machine, poses, |i| format!("pose {}", poses[i].name)));
    let file = MachineFile { text: None, left_out: Vec::new(), problem: None };
    let report = Report { study, found, file: &file, errors: &[] };
    said.extend(text::misfit_caution(&report));
    said.extend(text::unit_factor_words(&report));
    said.join(" ")
}
