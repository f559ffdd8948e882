//! A compensated program's points and errors.

use serde_json::{Value, json};

use crate::{
    compensation::{BoundedPath, LimitKind, Price, Side},
    machine::{Machine, Motion},
    report::{
        exchange::{Cell, Column, Row, Table, cells, counts, numbers, texts},
        table::{correction_columns, force_columns, shown_positions},
        words::counted,
    },
    study::{
        along_path::PathAnswer,
        command_columns::{drive_cells, drive_columns, pose_cells, pose_columns},
        program::bounded::Exceeded,
        program::{Pass, ProgramJob},
    },
};

/// The columns of [`program_table`].
pub fn program_columns(machine: &Machine) -> Vec<Column> {
    let quantities = [
        "x_mm",
        "y_mm",
        "z_mm",
        "commanded_x_mm",
        "commanded_y_mm",
        "commanded_z_mm",
        "error_before_mm",
        "error_after_mm",
        "error_after_x_mm",
        "error_after_y_mm",
        "error_after_z_mm",
        "rotation_left_deg",
    ];
    let mut columns = counts(["point", "line"]);
    columns.extend(numbers(["arc_length_mm"]));
    columns.extend(counts(["cutting"]));
    columns.extend(numbers(quantities));
    columns.extend(texts(["status", "reason", "limits"]));
    columns.extend(numbers(["nominal", "commanded"].into_iter().flat_map(pose_columns)));
    columns.extend(numbers(drive_columns(machine)));
    columns.extend(numbers(correction_columns(machine).chain(force_columns(machine))));
    columns
}

/// One row per point from `first` on: where the tool should be, what is commanded instead (both in the workpiece frame),
/// the error before (mm, by point of the path) and as written (base axes), the poses of P in O and the drive positions
/// without and with compensation, drive corrections and forces as written. An empty cell has its reason in `status` and
/// `reason`. `limits` names the limits that bind, if the path was corrected within limits.
pub fn program_table(
    job: &ProgramJob,
    first: usize,
    answers: &[PathAnswer],
    before: &[Option<f64>],
    bounded: Option<&BoundedPath>,
) -> Table {
    let machine = &job.machine;
    let columns = program_columns(machine);
    let width = columns.len();
    let row = |(k, answer): (usize, &PathAnswer)| {
        let point = &job.path.points()[k];
        let mut row: Row = vec![k.into(), job.file.line_of(point.source.segment).into()];
        row.extend([point.arc_length_mm.into(), usize::from(point.cutting).into()]);
        row.extend(cells(point.position_mm.iter().copied()));
        let commanded = answer.target.map(|pose| job.commanded(k, pose));
        row.extend((0..3).map(|i| commanded.map(|p| p[i]).into()));
        row.push(before[k].into());
        let shown = |value: f64| Cell::from(answer.is_settled.then_some(value));
        row.push(shown(answer.position_error.norm()));
        row.extend(answer.position_error.iter().map(|v| shown(*v)));
        row.push(shown(answer.leftover_rotation.norm().to_degrees()));
        row.extend([
            answer.status.label().into(),
            answer.status.reason(machine).into(),
            binding(job, bounded, k).into(),
        ]);
        row.extend(pose_cells(Some(&job.demands[k].pose)));
        row.extend(pose_cells(answer.target.as_ref()));
        row.extend(drive_cells(machine, &job.demands[k], answer, answer.is_settled));
        row.extend(shown_positions(machine, &answer.delta_rho()).iter().map(|v| shown(*v)));
        row.resize(width - machine.drive_count(), Cell::Missing);
        row.extend(answer.drive_forces.iter().map(|v| shown(*v)));
        row.resize(width, Cell::Missing);
        row
    };
    Table::new(columns, (first..).zip(answers).map(row))
}

/// Limits that bind at point `k`, such as `correction x upper`.
fn binding(job: &ProgramJob, bounded: Option<&BoundedPath>, k: usize) -> String {
    let labels = job.machine.drive_labels();
    let corrected = bounded.and_then(|path| path.points[k].corrected());
    let words = corrected.into_iter().flat_map(|point| &point.binding).map(|binding| {
        let side = match binding.side {
            Side::Lower => "lower",
            Side::Upper => "upper",
        };
        format!("{} {} {side}", binding.kind.label(), labels[binding.drive])
    });
    words.collect::<Vec<_>>().join("; ")
}

/// Which limits bind and what they cost, in sentences.
pub fn bounded_text(machine: &Machine, path: &BoundedPath) -> String {
    let summary = &path.summary;
    let labels = machine.drive_labels();
    if summary.prices.is_empty() {
        return "No limit binds: the unbounded corrections keep all of them.\n".into();
    }
    let mut text =
        format!("Limits bind ({}, {}):\n", summary.status.label(), counted(summary.iterations, "linearisation"));
    for price in &summary.prices {
        let error_mm = shown_price(machine, price);
        text += &format!(
            "  {} of drive {} at {}; the error would fall by {error_mm:.2e} mm per {} of relaxation\n",
            price.kind.label(),
            labels[price.drive],
            counted(price.points, "point"),
            shown_limit_unit(machine, price.kind, price.drive),
        );
    }
    text
}

/// By how much the program as written exceeds limits that its corrections kept, in sentences; nothing if it does not.
pub fn exceeded_text(job: &ProgramJob, exceeded: &[Exceeded]) -> String {
    let labels = job.machine.drive_labels();
    let mut text = String::new();
    for found in exceeded {
        let unit = shown_limit_unit(&job.machine, found.kind, found.drive);
        text += &format!(
            "As written, rounded to the decimals of the program, the {} of drive {} is {:.6} {unit} at point {}: {:.1e} {unit} \
             beyond its limit of {} {unit}. More decimals (decimals_mm in [gcode]) or a limit smaller by this much keep it.\n",
            found.kind.label(),
            labels[found.drive],
            found.value,
            found.point,
            found.value - found.limit,
            found.limit
        );
    }
    text
}

fn exceeded_json(job: &ProgramJob, exceeded: &[Exceeded]) -> Vec<Value> {
    let labels = job.machine.drive_labels();
    let entry = |found: &Exceeded| {
        json!({
            "limit": found.kind.label(),
            "drive": labels[found.drive],
            "point": found.point,
            "value": found.value,
            "limit_value": found.limit,
            "excess": found.value - found.limit,
            "unit": limit_unit(&job.machine, found.kind, found.drive),
        })
    };
    exceeded.iter().map(entry).collect()
}

fn motion_of(machine: &Machine, drive: usize) -> Motion {
    machine.drives().nth(drive).map_or(Motion::Prismatic, |(_, drive)| drive.motion)
}

fn limit_unit(machine: &Machine, kind: LimitKind, drive: usize) -> &'static str {
    let motion = motion_of(machine, drive);
    if kind == LimitKind::Force { motion.force_unit() } else { motion.position_unit() }
}

fn shown_limit_unit(machine: &Machine, kind: LimitKind, drive: usize) -> &'static str {
    let motion = motion_of(machine, drive);
    if kind == LimitKind::Force { motion.shown_force_unit() } else { motion.shown_position_unit() }
}

/// By how much the error would fall, mm, per unit of the limit: mm, degree, N or N·mm.
fn shown_price(machine: &Machine, price: &Price) -> f64 {
    if price.kind == LimitKind::Force { price.price } else { motion_of(machine, price.drive).from_shown(price.price) }
}

fn bounded_json(job: &ProgramJob, path: &BoundedPath) -> Value {
    let labels = job.machine.drive_labels();
    let limits: Vec<Value> = path
        .summary
        .prices
        .iter()
        .map(|price| {
            let error_mm = shown_price(&job.machine, price);
            let unit = limit_unit(&job.machine, price.kind, price.drive);
            json!({
                "limit": price.kind.label(),
                "drive": labels[price.drive],
                "points": price.points,
                (format!("error_mm_per_{unit}")): error_mm,
            })
        })
        .collect();
    json!({
        "status": path.summary.status.label(),
        "linearisations": path.summary.iterations,
        "error_max_mm": path.summary.after.worst,
        "error_rms_mm": path.summary.after.rms,
        "force_excess": path.summary.force_excess,
        "limits_binding": limits,
    })
}

/// Version of the report. In 1, what limits cost was per rad for hinges and had no unit in its key.
const SCHEMA: u32 = 2;

/// What each pass leaves, over the points at which the tool cuts. `exceeded`: limits as the program was written; `None` where
/// nobody looked.
pub fn program_json(
    job: &ProgramJob,
    passes: &[Pass],
    bounded: Option<&BoundedPath>,
    exceeded: Option<&[Exceeded]>,
) -> Value {
    let passes: Vec<Value> = passes
        .iter()
        .map(|pass| {
            let s = &pass.summary;
            json!({
                "commands": pass.name,
                "points": s.points,
                "points_solved": s.solved,
                "points_failed": s.failed,
                "first_failure": s.first_failure,
                "error_max_mm": s.max_mm,
                "error_rms_mm": s.rms_mm,
                "corrections_mean": s.mean_corrections,
                "rotation_left_max_deg": s.max_leftover_rotation.map(f64::to_degrees),
            })
        })
        .collect();
    json!({
        "schema": SCHEMA,
        "machine": job.machine.name,
        "points": job.path.len(),
        "length_mm": job.path.length_mm(),
        "passes": passes,
        "bounded": bounded.map(|path| bounded_json(job, path)),
        "limits_exceeded_as_written": exceeded.map(|exceeded| exceeded_json(job, exceeded)),
        "workpiece": job.process.place_words(),
        "counts_as_cutting": job.process.cutting_rule.words(),
        "axes_left_as_written": job.machine.uncontrolled_axes().map(|axis| ["x", "y", "z"][axis]).collect::<Vec<_>>(),
    })
}
