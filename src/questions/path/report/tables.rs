//! The tables of a path study.

use nalgebra::Vector3;

use crate::{
    answer::command_columns::{drive_cells, drive_columns, pose_cells, pose_columns},
    compensation::Demand,
    files::{
        exchange::{Cell, Column, Row, Table, cells, counts, numbers, texts},
        table::{correction_columns, force_columns, shown_positions},
    },
    machine::Machine,
    questions::path::{MethodAlongPath, PathPart, PathStudy, Station, report::cutting_force},
    simulation::{Source, along_path::PathAnswer},
};

/// One row per point of `part` and source: where the point put right should be, how far it is moved at the nominal command,
/// the cutting force that the source has, the poses of P in O and the drive positions that are commanded without and with compensation, corrections and drive
/// forces then, and the rotation left over. `status` and `reason` say why numbers are missing.
pub(crate) fn points_table(study: &PathStudy, part: &PathPart) -> Table {
    let rows =
        part.points().flat_map(|k| part.sources.sources().iter().map(move |source| row(study, part, k, *source)));
    Table::new(points_columns(&study.machine), rows)
}

fn row(study: &PathStudy, part: &PathPart, k: usize, source: Source) -> Row {
    let (machine, demand) = (&study.machine, &study.demands[k]);
    let wanted = demand.pose.transform(demand.offset(machine));
    let mut row = place(k, &study.stations[k], wanted, source);
    let compensated = part.answer(source, k);
    row.push(compensated.status.label().into());
    row.push(compensated.status.reason(machine).into());
    displacement(part.displacement(source, k), &mut row);
    row.extend(cutting_force::force_cells(&source.demand(demand)));
    row.extend(pose_cells(Some(&demand.pose)));
    command(machine, demand, compensated, &mut row);
    row
}

/// The columns of [`points_table`].
pub(crate) fn points_columns(machine: &Machine) -> Vec<Column> {
    let displacement = ["displacement_mm", "displacement_x_mm", "displacement_y_mm", "displacement_z_mm"];
    let left = ["leftover_rotation_x_deg", "leftover_rotation_y_deg", "leftover_rotation_z_deg", "error_left_mm"];
    let mut columns = counts(["point"]);
    columns.extend(numbers(["arc_length_mm", "phi_deg", "wanted_x_mm", "wanted_y_mm", "wanted_z_mm"]));
    columns.extend(texts(["source", "status", "reason"]));
    columns.extend(numbers(displacement));
    columns.extend(numbers(cutting_force::columns()));
    columns.extend(numbers(["nominal", "commanded"].into_iter().flat_map(pose_columns)));
    columns.extend(numbers(left));
    columns.extend(numbers(drive_columns(machine)));
    columns.extend(numbers(correction_columns(machine).chain(force_columns(machine))));
    columns
}

fn place(k: usize, station: &Station, wanted: Vector3<f64>, source: Source) -> Row {
    let mut row = vec![k.into(), station.arc_length_mm.into(), station.phi_deg.into()];
    row.extend(cells(wanted.iter().copied()));
    row.push(source.label().into());
    row
}

fn displacement(error: Option<Vector3<f64>>, row: &mut Row) {
    match error {
        Some(error) => {
            row.push(error.norm().into());
            row.extend(cells(error.iter().copied()));
        }
        None => row.extend(std::iter::repeat_n(Cell::Missing, 4)),
    }
}

fn command(machine: &Machine, demand: &Demand, answer: &PathAnswer, row: &mut Row) {
    let drive_count = machine.drive_count();
    let Some(target) = answer.target.filter(|_| answer.status.is_success()) else {
        row.extend(std::iter::repeat_n(Cell::Missing, 10));
        row.extend(drive_cells(machine, demand, answer, false));
        row.extend(std::iter::repeat_n(Cell::Missing, 2 * drive_count));
        return;
    };
    row.extend(pose_cells(Some(&target)));
    row.extend(cells(answer.leftover_rotation.iter().map(|v| v.to_degrees())));
    row.push(answer.position_error.norm().into());
    row.extend(drive_cells(machine, demand, answer, true));
    row.extend(cells(shown_positions(machine, &answer.delta_rho())));
    row.extend(cells(answer.drive_forces.iter().copied()));
}

/// One row per method: what it leaves and how many corrections it needs; nothing where it solves no point. Time is not here, as it differs between runs.
pub(crate) fn methods_table(methods: &[MethodAlongPath]) -> Table {
    let mut columns = texts(["method"]);
    columns.extend(counts(["points", "solved", "failed"]));
    columns.extend(texts(["first_failure"]));
    columns.extend(numbers(["corrections_mean", "error_max_mm", "error_rms_mm", "leftover_rotation_max_deg"]));
    let rows = methods.iter().map(|method| {
        let s = &method.summary;
        vec![
            method.method.label().into(),
            s.points.into(),
            s.solved.into(),
            s.failed.into(),
            s.first_failure.as_deref().unwrap_or_default().into(),
            s.mean_corrections.into(),
            s.max_mm.into(),
            s.rms_mm.into(),
            s.max_leftover_rotation.map(f64::to_degrees).into(),
        ]
    });
    Table::new(columns, rows)
}
