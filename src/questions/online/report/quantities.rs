//! Quantities, tables and figure of an online study.

use super::{Compared, about_percent};
use crate::{
    answer::{Quantity, QuantityTable},
    figures::{Figure, LineFigure, LineSeries},
    files::{
        exchange::{Cell, Row, Table, counts, numbers, texts},
        words::counted,
    },
    page::Better::Smaller,
    questions::online::{Band, BreakEven, Trial},
    simulation::SOLVED,
};

/// Returns the status of a trial: solved, or solved in part where a point of it is not.
pub(super) fn status(trial: &Trial) -> &'static str {
    match [trial.offline, trial.online].iter().all(|residual| residual.solved == residual.points) {
        true => SOLVED,
        false => "solved_in_part",
    }
}

/// Makes the table of trials, a row for each force error and seed.
pub(super) fn trials_table(trials: &[Trial]) -> Table {
    let lead = [numbers([FORCE_ERROR]), counts(["seed"]), texts(["status"])].concat();
    let row = |trial: &Trial| -> Row { vec![percent_cell(trial.force_error), trial.seed.into(), status(trial).into()] };
    let quantities = vec![
        Quantity::in_table("force_factor", |trial: &Trial| Some(trial.force_factor)),
        Quantity::in_table("predicted_rms_mm", |trial| trial.offline.rms_mm),
        Quantity::in_table("predicted_max_mm", |trial| trial.offline.max_mm),
        Quantity::count("predicted_solved", |trial| Some(trial.offline.solved)),
        Quantity::in_table("measured_rms_mm", |trial| trial.online.rms_mm),
        Quantity::in_table("measured_max_mm", |trial| trial.online.max_mm),
        Quantity::count("measured_solved", |trial| Some(trial.online.solved)),
        Quantity::count("points", |trial| Some(trial.online.points)),
    ];
    QuantityTable::without_status(lead, quantities).table(trials.iter().map(|trial| (row(trial), Ok(trial))))
}

pub(super) const FORCE_ERROR: &str = "force_error_percent";

/// Returns a cell with a share in per cent.
fn percent_cell(share: f64) -> Cell {
    (100.0 * share).into()
}

/// Words for the two ways to correct, by the force that each uses.
pub(super) const WAYS: [&str; 2] = ["predicted", "measured"];

type BandQuantity = Quantity<Band>;

pub(super) const LOW: BandQuantity =
    BandQuantity::new("rms_low_mm", "rms distance that 5 % of the seeds stay below", Smaller, |band| Some(band.low_mm));
pub(super) const MEDIAN: BandQuantity =
    BandQuantity::new("rms_median_mm", "median of the rms distance", Smaller, |band| Some(band.median_mm));
pub(super) const HIGH: BandQuantity =
    BandQuantity::new("rms_high_mm", "rms distance that 5 % of the seeds exceed", Smaller, |band| Some(band.high_mm));

/// Makes the table of bands, a row for each force error and way to correct.
pub(super) fn bands_table(compared: &Compared<'_>) -> Table {
    let lead = [numbers([FORCE_ERROR]), texts(["correction"])].concat();
    let rows = WAYS.into_iter().zip([&compared.offline, &compared.online]).flat_map(|(way, bands)| {
        bands.iter().flatten().map(move |band| (vec![percent_cell(band.force_error), way.into()], Ok(band)))
    });
    QuantityTable::without_status(lead, vec![LOW, MEDIAN, HIGH]).table(rows)
}

/// Draws the residual error (RMS over the path: median, 5 % to 95 % over the seeds) against the force error, corrected beforehand and corrected in
/// the controller; `None` if no trial was solved.
pub(super) fn residual_figure(compared: &Compared<'_>) -> Option<Figure> {
    let series = |label: &str, bands: &[Option<Band>]| LineSeries {
        label: label.into(),
        points: bands.iter().flatten().map(|band| (100.0 * band.force_error, band.median_mm)).collect(),
        dashed: false,
        band: bands.iter().flatten().map(|band| [100.0 * band.force_error, band.low_mm, band.high_mm]).collect(),
    };
    let mut series = vec![
        series("corrected beforehand, by the predicted force", &compared.offline),
        series("corrected in the controller, by the measured force", &compared.online),
    ];
    if let Some(BreakEven::From(error)) = compared.break_even {
        let (at, top) = (100.0 * error, series[0].band.iter().map(|[.., high]| *high).fold(0.0, f64::max));
        let label = format!("measuring pays from about {} on", about_percent(error));
        series.push(LineSeries::new(label, vec![(at, 0.0), (at, top)], true));
    }
    let (name, seeds) = (&compared.study.path.machine.name, counted(compared.study.seeds, "seed"));
    series.iter().any(|series| !series.points.is_empty()).then(|| {
        let title = "Residual error against the error of the predicted force";
        let labels = ["standard deviation of the force error [%]", "rms distance from the path [mm]"];
        Figure::Lines(LineFigure::new(
            title,
            format!("{name}, {seeds}: lines are medians, bands 5 % to 95 %"),
            labels,
            series,
        ))
    })
}
