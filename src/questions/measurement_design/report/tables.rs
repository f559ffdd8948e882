//! Tables of a design of measurements, and the sheet to fill in at the machine, with the columns that an identification reads.

use nalgebra::Vector3;

use crate::{
    answer::{drive_columns::measured_drive_columns, status_cells},
    files::exchange::{Cell, Column, Row, Table, cells, counts, numbers, texts},
    machine::Machine,
    questions::{
        identification::{Measurement, report::ANYTHING},
        measurement_design::{MeasurementDesignStudy, Plan},
    },
};

/// Returns all tables by name; without a plan those that every run has, without rows.
pub(super) fn tables(study: &MeasurementDesignStudy, plan: Option<&Plan>) -> Vec<(String, Table)> {
    let sheet = plan.map(|plan| ("sheet".into(), sheet(study, plan)));
    let others = [("widths".into(), widths_table(study, plan)), ("candidates".into(), candidates_table(study, plan))];
    std::iter::once(("chosen".into(), chosen_table(study, plan))).chain(sheet).chain(others).collect()
}

/// Returns the columns of drive positions, tool tip and force of a candidate.
fn setup_columns(study: &MeasurementDesignStudy) -> Vec<Column> {
    let drives = numbers(measured_drive_columns(&study.machine));
    let rest = numbers(["tool_x_mm", "tool_y_mm", "tool_z_mm", "force_x_N", "force_y_N", "force_z_N"]);
    [drives, rest].concat()
}

/// Returns the cells of [`setup_columns`] for a candidate (by index).
fn setup_cells(study: &MeasurementDesignStudy, candidate: usize) -> Row {
    let measurement = &study.candidates[candidate];
    let tip = measurement.at.pose.transform(study.machine.tool_tip);
    let drives = tidy_drive_positions(&study.machine, measurement);
    cells(drives.chain(tip.iter().copied()).chain(measurement.load.force.iter().copied())).collect()
}

/// Makes the table of chosen measurements: a row for each, the most informative first, with the widest interval once it is made.
fn chosen_table(study: &MeasurementDesignStudy, plan: Option<&Plan>) -> Table {
    let columns = [
        counts(["order", "candidate"]),
        setup_columns(study),
        numbers(["widest_half_width"]),
        texts(["widest_parameter"]),
    ];
    let chosen = plan.into_iter().flat_map(|plan| plan.chosen.iter().enumerate().map(move |numbered| (plan, numbered)));
    let rows = chosen.map(|(plan, (k, &candidate))| {
        let mut row: Row = vec![(k + 1).into(), (candidate + 1).into()];
        row.extend(setup_cells(study, candidate));
        let widest = plan.widths.get(k + 1).and_then(|widths| widths.widest());
        row.push(widest.map(|(_, width)| bounded_cell(width)).into());
        row.push(widest.map(|(unknown, _)| study.unknowns[unknown].name.as_str()).into());
        row
    });
    Table::new(columns.concat(), rows)
}

/// Returns a cell with a half width, empty where the unknown may have any value.
fn bounded_cell(width: f64) -> Cell {
    (width <= ANYTHING).then_some(width).into()
}

/// Makes the table of half widths: a row per number of measurements and unknown; the error of the tool at tested rows last.
fn widths_table(study: &MeasurementDesignStudy, plan: Option<&Plan>) -> Table {
    let columns =
        [counts(["measurements"]), texts(["parameter", "in"]), numbers(["half_width", "random_half_width"])].concat();
    let mut rows: Vec<Row> = Vec::new();
    for (count, widths) in plan.map_or(&[][..], |plan| &plan.widths).iter().enumerate() {
        let random = plan.and_then(|plan| plan.random.get(count));
        for ((unknown, width), k) in study.unknowns.iter().zip(&widths.each).zip(0..) {
            let (name, unit) = (unknown.name.as_str(), unknown.coordinate_unit());
            let other = random.map(|random| bounded_cell(random.each[k]));
            rows.push(vec![count.into(), name.into(), unit.into(), bounded_cell(*width), other.into()]);
        }
        if let Some(error) = widths.tested_mm {
            let other = random.and_then(|random| random.tested_mm);
            rows.push(vec![count.into(), "tool_at_tested_rows_rms".into(), "mm".into(), error.into(), other.into()]);
        }
    }
    Table::new(columns, rows)
}

/// Makes the table of candidates: a row for each, with its rank in `order` if chosen.
fn candidates_table(study: &MeasurementDesignStudy, plan: Option<&Plan>) -> Table {
    let columns =
        [counts(["candidate"]), texts(["pose", "status", "reason"]), counts(["order"]), setup_columns(study)].concat();
    let rows = plan.into_iter().flat_map(|plan| {
        let mut failures = plan.failures.iter().peekable();
        (0..study.candidates.len()).map(move |i| {
            let failure = failures.next_if(|(failed, _)| *failed == i).map(|(_, failure)| failure);
            let order = plan.chosen.iter().position(|&candidate| candidate == i).map(|k| k + 1);
            let mut row: Row = vec![(i + 1).into(), study.candidates[i].name.as_str().into()];
            row.extend(status_cells(failure.map_or(Ok(()), Err)));
            row.push(order.into());
            row.extend(setup_cells(study, i));
            row
        })
    });
    Table::new(columns, rows)
}

/// Returns the drive positions of `own` in degrees and mm, without rounding errors of radians.
fn tidy_drive_positions<'a>(machine: &'a Machine, own: &'a Measurement) -> impl Iterator<Item = f64> + 'a {
    // What a person types, without the rounding of its way through radians.
    let tidy = |shown: f64| (shown * 1e9).round() / 1e9 + 0.0;
    own.at.drives.iter().zip(machine.drives()).map(move |(position, (_, drive))| tidy(drive.motion.to_shown(*position)))
}

/// Gets a vector of a measurement, if it has one.
type VectorOf = fn(&Measurement) -> Option<Vector3<f64>>;

/// Returns the measurement sheet: poses and loads of the chosen measurements, and empty cells for readings.
pub(super) fn sheet(study: &MeasurementDesignStudy, plan: &Plan) -> Table {
    let machine = &study.machine;
    let chosen: Vec<&Measurement> = plan.chosen.iter().map(|&i| &study.candidates[i]).collect();
    let is_used = |of: &VectorOf| chosen.iter().any(|one| of(one).is_some_and(|vector| vector.norm() > 0.0));
    let vectors: [(&str, &str, VectorOf); 5] = [
        ("force", "N", |one| Some(one.load.force)),
        ("moment", "Nmm", |one| Some(one.load.moment)),
        ("reference_force", "N", |one| Some(one.reference.force)),
        ("reference_moment", "Nmm", |one| Some(one.reference.moment)),
        ("marker", "mm", |one| one.marker),
    ];
    let used: Vec<_> = vectors.into_iter().filter(|(name, _, of)| *name == "force" || is_used(of)).collect();
    let readings = chosen.first().map_or(&[][..], |one| &one.readings);
    let mut columns = [texts(["pose"]), numbers(measured_drive_columns(machine))].concat();
    for (name, unit, _) in &used {
        columns.extend(numbers(["x", "y", "z"].map(|axis| format!("{name}_{axis}_{unit}"))));
    }
    columns.extend(numbers(readings.iter().map(|reading| reading.column)));
    let row = |(number, one): (usize, &&Measurement)| {
        let mut row: Row = vec![Cell::from((number + 1).to_string())];
        row.extend(cells(tidy_drive_positions(machine, one)));
        for (_, _, of) in &used {
            row.extend((0..3).map(|axis| Cell::from(of(one).map(|vector| vector[axis]))));
        }
        row.extend(readings.iter().map(|_| Cell::Missing));
        row
    };
    Table::new(columns, chosen.iter().enumerate().map(row))
}
