//! Quantities and tables of a path study: effects of the sources at each point, and residual errors of the methods.

use super::cutting_force;
use crate::{
    answer::{
        DriveQuantities, Quantity, QuantityTable,
        command_columns::{drive_cells, drive_columns, pose_cells, pose_columns},
        play::{play_cells, play_columns},
    },
    files::exchange::{Row, Table, cells, counts, numbers, texts},
    machine::Machine,
    page::{
        Better::{Larger, Neither, Smaller},
        DrawsTable,
    },
    questions::{
        path::{MethodAlongPath, PathPart, PathStudy, PointEffect},
        spread_report::{self, WithSpread},
    },
    simulation::{Source, spread::DeflectionSpread},
};

type Of = Quantity<PointEffect>;

pub(crate) const DISPLACEMENT: Of =
    Of::new("displacement_mm", "displacement without compensation", Smaller, |at| Some(at.displacement()?.norm()));
pub(super) const RESIDUAL_ERROR: Of =
    Of::new("residual_error_mm", "residual error", Smaller, |at| Some(at.compensated()?.position_error.norm()));

/// Returns the distribution of the distance from the path at the nominal command; `None` for single sources, and where inputs are taken as exact.
pub(super) fn plain_spread(at: &PointEffect) -> Option<&DeflectionSpread> {
    Some(&at.spread.as_ref()?.plain)
}

impl WithSpread for PointEffect {
    /// Returns the distribution of the residual error; `None` for single sources, where inputs are taken as exact, and where compensation failed.
    fn distribution(&self) -> Option<&DeflectionSpread> {
        self.spread.as_ref()?.compensated.as_ref()
    }
}

pub(super) const P95_DISPLACEMENT: Of =
    Of::new("displacement_p95_mm", "95 % quantile of the displacement without compensation", Smaller, |at| {
        plain_spread(at)?.p95_mm
    });
pub(super) const P95_RESIDUAL: Of =
    Of::new("residual_error_p95_mm", "95 % quantile of the residual error", Smaller, |at| at.distribution()?.p95_mm);
pub(super) const MEDIAN_RESIDUAL: Of =
    Of::new("residual_error_median_mm", "median residual error", Smaller, |at| at.distribution()?.median_mm);
pub(super) const WITHOUT_FORCE: Of =
    Of::new("residual_without_force_mm", "residual error where the force is absent", Smaller, |at| {
        at.spread.as_ref()?.without_force_mm
    });
const WORSE: Of = Of::new("worse_probability", "probability that compensation makes it worse", Smaller, |at| {
    at.spread.as_ref()?.worse
});
const WITHIN: Of = Of::new(
    "residual_within_tolerance_probability",
    "probability that the residual error is within tolerance",
    Larger,
    |at| at.distribution()?.within_tolerance,
);

/// Lists the quantities of the distributions that pages show; none where inputs are taken as exact.
pub(super) fn spread_quantities(study: &PathStudy) -> Vec<Of> {
    if study.uncertainty.is_none() {
        return Vec::new();
    }
    let within = study.tolerance_mm.map(|_| WITHIN);
    let all = [P95_RESIDUAL, MEDIAN_RESIDUAL, P95_DISPLACEMENT, WITHOUT_FORCE, WORSE];
    all.into_iter().chain(within).collect()
}

/// Lists the columns of the distributions that only tables have.
fn spread_columns(study: &PathStudy) -> Vec<Of> {
    if study.uncertainty.is_none() {
        return Vec::new();
    }
    let median = Of::in_table("displacement_median_mm", |at| plain_spread(at)?.median_mm);
    let names =
        ["residual_error_p95_standard_error_mm", "residual_error_main_cause", "residual_error_main_cause_share"];
    [median].into_iter().chain(spread_report::columns(names)).collect()
}

/// Returns the components of the displacement at the nominal command, O axes, mm.
pub(crate) fn displacement_components() -> [Of; 3] {
    Of::vector_mm("displacement", "displacement", |at| Some(at.displacement()?.into()))
}

/// Returns corrections and forces of the drives on the compensated path.
pub(crate) fn drives(machine: &Machine) -> DriveQuantities<PointEffect> {
    let correction = |at: &PointEffect, drive: usize| {
        let answer = at.compensated()?;
        Some(answer.drives.get(drive)? - answer.nominal_drives.get(drive)?)
    };
    DriveQuantities::new(machine, Neither, correction, |at, drive| at.compensated()?.drive_forces.get(drive).copied())
}

/// Column and label of the length along the path.
pub(crate) const ARC_LENGTH: [&str; 2] = ["arc_length_mm", "length along the path"];
/// Column and label of the tool angle.
pub(crate) const ANGLE: [&str; 2] = ["phi_deg", "tool angle φ"];

/// Makes the table of points, one row per point and source: positions, errors, cutting force, commands, and drive corrections and forces.
pub(crate) fn points_table(study: &PathStudy, part: &PathPart) -> Table {
    let machine = &study.machine;
    let displacement: Vec<Of> = [DISPLACEMENT].into_iter().chain(displacement_components()).collect();
    let residual_rotation = Of::vector("residual_rotation", "deg", "", |at| {
        Some(at.compensated()?.residual_rotation.map(f64::to_degrees).into())
    });
    let residual: Vec<Of> = residual_rotation.into_iter().chain([RESIDUAL_ERROR]).collect();
    let drives = drives(machine).each;
    let spread: Vec<Of> = spread_quantities(study).into_iter().chain(spread_columns(study)).collect();
    let columns = |quantities: &[Of]| quantities.iter().map(Of::column).collect();
    let columns = [
        counts(["point"]),
        numbers([ARC_LENGTH[0], ANGLE[0], "wanted_x_mm", "wanted_y_mm", "wanted_z_mm"]),
        texts(["source", "status", "reason"]),
        columns(&displacement),
        numbers(cutting_force::columns()),
        numbers(["nominal", "commanded"].into_iter().flat_map(pose_columns)),
        columns(&residual),
        numbers(drive_columns(machine)),
        columns(&drives),
        columns(&spread),
        play_columns(machine),
    ];
    let row = |k: usize, source: Source| {
        let (station, task, at) = (&study.stations[k], &study.tasks[k], part.at(source, k));
        let (result, compensated) = (&at.answer, at.compensated());
        let mut row: Row = vec![k.into(), station.arc_length_mm.into(), station.phi_deg.into()];
        row.extend(cells(task.pose.transform(task.offset(machine)).iter().copied()));
        row.extend([source.label().into(), result.status.label().into(), result.status.reason(machine).into()]);
        row.extend(displacement.iter().map(|quantity| quantity.cell_of(Ok(at))));
        row.extend(cutting_force::force_cells(&source.task(task)));
        row.extend(pose_cells(Some(&task.pose)));
        row.extend(pose_cells(compensated.and_then(|result| result.target.as_ref())));
        row.extend(residual.iter().map(|quantity| quantity.cell_of(Ok(at))));
        row.extend(drive_cells(machine, task, result, compensated.is_some()));
        row.extend(drives.iter().chain(&spread).map(|quantity| quantity.cell_of(Ok(at))));
        row.extend(play_cells(machine, at.plain.play.as_ref(), compensated));
        row
    };
    let sources = part.sources.sources();
    let rows = part.points().flat_map(|k| sources.iter().map(move |source| (k, *source)));
    Table::new(columns.concat(), rows.map(|(k, source)| row(k, source)))
}

type OfMethod = Quantity<MethodAlongPath>;

const CORRECTIONS: OfMethod =
    OfMethod::new("corrections_mean", "steps per point", Smaller, |method| method.summary.mean_corrections);
const ERROR_MAX: OfMethod =
    OfMethod::new("error_max_mm", "largest residual error", Smaller, |method| method.summary.max_mm);
const ERROR_RMS: OfMethod =
    OfMethod::new("error_rms_mm", "rms residual error", Smaller, |method| method.summary.rms_mm);
const ROTATION: OfMethod = OfMethod::new("residual_rotation_max_deg", "residual rotation", Neither, |method| {
    method.summary.max_residual_rotation.map(f64::to_degrees)
});

/// Quantities of the view of the methods, in its order.
pub(super) const METHOD_QUANTITIES: [OfMethod; 4] = [ERROR_MAX, ERROR_RMS, CORRECTIONS, ROTATION];

/// Makes the table of methods, one row each: residual errors and mean corrections. Computing time differs between runs, so it is left out.
pub(super) fn methods_table(methods: &[MethodAlongPath]) -> Table {
    let quantities = vec![
        OfMethod::count("points", |method| Some(method.summary.points)),
        OfMethod::count("solved", |method| Some(method.summary.solved)),
        OfMethod::count("failed", |method| Some(method.summary.failed)),
        OfMethod::text("first_failure", |method| {
            method.ok().and_then(|own| own.summary.first_failure.as_deref()).into()
        }),
        CORRECTIONS,
        ERROR_MAX,
        ERROR_RMS,
        ROTATION,
    ];
    let rows = methods.iter().map(|method| (vec![method.method.label().into()], Ok(method)));
    QuantityTable::without_status(texts(["method"]), quantities).table(rows)
}

/// The largest distance in each draw.
pub(super) const DRAWS: DrawsTable =
    DrawsTable { file: "draws.csv", distances: ["largest_distance_mm", "compensated_largest_distance_mm"] };

/// Makes the table of the largest distance in each draw without and with compensation, of the draws of which both are known, or one where the other is in none.
pub(super) fn draws_table(draws: &[Vec<f64>; 2]) -> Table {
    let known = draws.iter().map(Vec::len).filter(|known| *known > 0).min().unwrap_or(0);
    let size = |sizes: &Vec<f64>, draw: usize| sizes.get(draw).copied().filter(|size| size.is_finite()).into();
    let row = |draw: usize| std::iter::once(draw.into()).chain(draws.iter().map(|own| size(own, draw))).collect();
    let columns = numbers(DRAWS.distances);
    Table::new([counts(["draw"]), columns].concat(), (0..known).map(row))
}
