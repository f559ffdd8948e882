//! The tables of an online study.

use crate::{
    files::exchange::{Cell, Row, Table, counts, numbers, texts},
    questions::online::{Band, Residual, Trial},
    simulation::SOLVED,
};

/// Whether every point of a trial is solved.
pub(super) fn status(trial: &Trial) -> &'static str {
    match [trial.offline, trial.online].iter().all(|left| left.solved == left.points) {
        true => SOLVED,
        false => "solved_in_part",
    }
}

/// One row per force error and seed.
pub(super) fn trials(trials: &[Trial]) -> Table {
    let mut columns = numbers(["force_error_percent"]);
    columns.extend(counts(["seed"]));
    columns.extend(texts(["status"]));
    columns.extend(numbers(["force_factor"]));
    for kind in ["predicted", "measured"] {
        columns.extend(numbers([format!("{kind}_rms_mm"), format!("{kind}_max_mm")]));
        columns.extend(counts([format!("{kind}_solved")]));
    }
    columns.extend(counts(["points"]));
    let row = |trial: &Trial| {
        let mut row: Row = vec![(100.0 * trial.force_error).into(), trial.seed.into(), status(trial).into()];
        row.push(trial.force_factor.into());
        for Residual { max_mm, rms_mm, solved, .. } in [trial.offline, trial.online] {
            row.extend([rms_mm.into(), max_mm.into(), Cell::from(solved)]);
        }
        row.push(trial.online.points.into());
        row
    };
    Table::new(columns, trials.iter().map(row))
}

/// One row per force error and way to correct.
pub(super) fn bands(offline: &[Option<Band>], online: &[Option<Band>]) -> Table {
    let mut columns = numbers(["force_error_percent"]);
    columns.extend(texts(["correction"]));
    columns.extend(numbers(["rms_low_mm", "rms_median_mm", "rms_high_mm"]));
    let of = |bands: &[Option<Band>], name: &'static str| {
        let row = |band: &Band| -> Row {
            let mut row: Row = vec![(100.0 * band.force_error).into(), name.into()];
            row.extend([band.low_mm.into(), band.median_mm.into(), Cell::from(band.high_mm)]);
            row
        };
        bands.iter().flatten().map(row).collect::<Vec<Row>>()
    };
    Table::new(columns, of(offline, "predicted").into_iter().chain(of(online, "measured")))
}
