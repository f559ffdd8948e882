//! A compensated program as JSON.

use serde_json::{Value, json};

use crate::{
    compensation::BoundedPath,
    products::program::{
        ProgramJob, WrittenCalls,
        bounded::Exceeded,
        report::{
            Proved,
            units::{limit_unit, shown_price},
        },
    },
    simulation::ProgramFile,
    toolpath::gcode::Notes,
};

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
pub fn program_json(job: &ProgramJob, proved: &Proved<'_>, exceeded: Option<&[Exceeded]>) -> Value {
    let &Proved { passes, bounded, blocks, calls, .. } = proved;
    let (notes, dialect) = match &job.file {
        ProgramFile::Gcode(program) => (program.notes().clone(), Some(program.notes().dialect.label())),
        ProgramFile::Robot(program) => {
            let not_located = program.notes().not_located.clone();
            (Notes { not_located, ..Notes::default() }, Some(program.language().label()))
        }
        ProgramFile::Polyline(_) => (Notes::default(), None),
    };
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
                "leftover_rotation_max_deg": s.max_leftover_rotation.map(f64::to_degrees),
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
        "write_tolerance_mm": (!matches!(job.file, ProgramFile::Polyline(_))).then_some(job.process.write_tolerance_mm),
        "blocks": blocks,
        "workpiece": job.process.place_words(),
        "counts_as_cutting": job.process.cutting_rule.words(),
        "dialect": dialect,
        "unit_taken": notes.unit_taken.map(|(unit, _)| unit.name()),
        "written_out": notes.written_out.map(|[lines, written]| match calls {
            WrittenCalls::Stay { .. } => Value::Null,
            WrittenCalls::None => json!({ "lines": lines, "written": written }),
            WrittenCalls::WrittenOut { because } => json!({ "lines": lines, "written": written, "because": because }),
        }),
        "lines_left_as_written": notes.not_located,
        "axes_left_as_written": job.machine.uncontrolled_axes().map(|axis| ["x", "y", "z"][axis]).collect::<Vec<_>>(),
    })
}
