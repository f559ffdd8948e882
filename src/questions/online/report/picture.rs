//! The picture of an online study: what both corrections leave over the force error.

use super::Compared;
use crate::{
    figures::{Figure, LineFigure, LineSeries},
    files::words::counted,
    questions::online::Band,
};

/// Median and band of both; nothing where neither left anything to compare.
pub(super) fn picture(compared: &Compared<'_>) -> Option<Figure> {
    let series = |label: &str, bands: &[Option<Band>]| LineSeries {
        label: label.into(),
        points: bands.iter().flatten().map(|band| (100.0 * band.force_error, band.median_mm)).collect(),
        dashed: false,
        band: bands.iter().flatten().map(|band| [100.0 * band.force_error, band.low_mm, band.high_mm]).collect(),
    };
    let series = vec![
        series("corrected beforehand, by the predicted force", &compared.offline),
        series("corrected in the controller, by the measured force", &compared.online),
    ];
    let study = compared.study;
    series.iter().any(|series| !series.points.is_empty()).then(|| {
        Figure::Lines(LineFigure {
            title: "What corrections leave, by how wrong the predicted force is".into(),
            subtitle: format!(
                "{}, {}: median and 5 % to 95 %",
                study.path.machine.short_title(),
                counted(study.seeds, "seed")
            ),
            x_label: "standard deviation of the force error [%]".into(),
            y_label: "rms distance from the path [mm]".into(),
            series,
            equal_axes: false,
            log_x: false,
            log_y: false,
            closed_note: None,
        })
    })
}
