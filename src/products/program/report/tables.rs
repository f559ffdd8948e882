//! Tables and JSON of a compensated program: its points, and its passes.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::{
    Report, feed,
    words::{self, limit_unit, shown_price},
};
use crate::{
    answer::{
        Quantity,
        budget::BUDGET,
        command_columns::{drive_cells, drive_columns, pose_cells, pose_columns},
        drive_columns::{correction_columns, force_columns, shown_positions},
        play::{play_cells, play_columns},
    },
    compensation::{BoundedPath, Side},
    files::{
        exchange::{Cell, Column, Row, Table, cells, counts, numbers, texts},
        or_dash,
    },
    page::Better::{Larger, Smaller},
    process::{Engaged, UnknownForce, VerdictForce},
    products::program::{
        ForceCheck, Pass, ProgramJob, VerifiedPart, VerifiedProgram, WrittenCalls, bounded::LimitExcess,
    },
    questions::{
        path::{
            Station,
            report::{ANGLE, cutting_force},
            resolve::stations,
        },
        spread_report::{self, WithSpread, share_interval},
    },
    simulation::{Source, along_path::PathPointResult, spread::DeflectionSpread, spread_along::PointSpread},
    toolpath::{ProgramFile, gcode::Notes},
};

/// Columns of [`program_table`] whose largest values are the worst points.
pub const PROGRAM_RANKS: [&str; 2] = ["error_before_mm", "error_after_mm"];

/// Column of the error as written where the cutting force is absent.
pub(super) const WITHOUT_FORCE: &str = "error_without_force_mm";

impl WithSpread for PointSpread {
    /// Returns the distribution of the error as written; `None` where compensation failed.
    fn distribution(&self) -> Option<&DeflectionSpread> {
        self.compensated.as_ref()
    }
}

type Of = Quantity<PointSpread>;

pub(super) const P95_BEFORE: Of =
    Of::new("error_before_p95_mm", "95 % quantile of the error without compensation", Smaller, |at| at.plain.p95_mm);
pub(super) const P95_AFTER: Of =
    Of::new("error_after_p95_mm", "95 % quantile of the error as written", Smaller, |at| at.distribution()?.p95_mm);
const MEDIAN_AFTER: Of =
    Of::new("error_after_median_mm", "median error as written", Smaller, |at| at.distribution()?.median_mm);
const WORSE: Of =
    Of::new("worse_probability", "probability that the written program is farther off", Smaller, |at| at.worse);
const WITHIN: Of = Of::new(
    "error_after_within_tolerance_probability",
    "probability that the error as written is within tolerance",
    Larger,
    |at| at.distribution()?.within_tolerance,
);

/// Lists the quantities of the distributions that pages show; none where inputs are taken as exact.
pub(super) fn spread_quantities(job: &ProgramJob) -> Vec<Of> {
    let within = job.process.tolerance_mm.map(|_| WITHIN);
    let all = [P95_AFTER, MEDIAN_AFTER, P95_BEFORE, WORSE].into_iter().chain(within);
    if job.uncertainty.is_some() { all.collect() } else { Vec::new() }
}

/// Lists all columns of the distributions; none where inputs are taken as exact.
fn spread_columns(job: &ProgramJob) -> Vec<Of> {
    let names = ["error_after_p95_standard_error_mm", "error_after_main_cause", "error_after_main_cause_share"];
    let in_tables = job.uncertainty.iter().flat_map(|_| spread_report::columns(names));
    spread_quantities(job).into_iter().chain(in_tables).collect()
}

/// Returns the columns of [`program_table`].
pub fn program_columns(job: &ProgramJob) -> Vec<Column> {
    let (machine, calls_files) = (&job.machine, !job.file.called_files().is_empty());
    let mut columns = counts(["point", "line"]);
    columns.extend(texts(calls_files.then_some("called_file")));
    columns.extend(numbers(["arc_length_mm", ANGLE[0]]));
    columns.extend(counts(["cutting"]));
    columns.extend(numbers(["x_mm", "y_mm", "z_mm", "commanded_x_mm", "commanded_y_mm", "commanded_z_mm"]));
    columns.extend(numbers(Source::of(machine).iter().map(|source| error_before_column(*source))));
    columns.extend(numbers(["error_after_mm", "error_after_x_mm", "error_after_y_mm", "error_after_z_mm"]));
    columns.extend(numbers([WITHOUT_FORCE]));
    columns.extend(numbers(["residual_rotation_deg"]));
    columns.extend(numbers(cutting_force::columns()));
    if !job.path.engagements().is_empty() {
        columns.extend(counts(["engagement_regions"]));
        columns.extend(numbers(ENGAGEMENT));
        columns.extend(texts(["engagement_milling"]));
    }
    columns.extend(texts(["status", "reason", "limits"]));
    columns.extend(numbers(["nominal", "commanded"].into_iter().flat_map(pose_columns)));
    columns.extend(numbers(drive_columns(machine)));
    columns.extend(numbers(correction_columns(machine).chain(force_columns(machine))));
    columns.extend(spread_columns(job).iter().map(Of::column));
    columns.extend(play_columns(machine));
    columns
}

/// Columns of how the tool is in material on the way to a point.
const ENGAGEMENT: [&str; 11] = [
    "engagement_depth_mm",
    "engagement_width_mm",
    "engagement_entry_deg",
    "engagement_exit_deg",
    "engagement_chip_mm",
    "engagement_most_removed_mm2",
    "engagement_end_mm2",
    "engagement_bend_mm",
    "engagement_across_mean_N",
    "engagement_across_wall_N",
    "engagement_across_peak_N",
];

/// Returns the cells of these columns, and how teeth pass through the material; empty angles and chip in air.
fn engagement_cells(own: &Engaged) -> Vec<Cell> {
    let bend = own.bend.as_ref();
    let across = |at: usize| Cell::from(bend.and_then(|bend| bend.across_N[at]).map(f64::from));
    vec![
        own.regions.into(),
        own.depth_mm.into(),
        own.width_mm.into(),
        own.entry_rad.map(f64::to_degrees).into(),
        own.exit_rad.map(f64::to_degrees).into(),
        own.chip_mm.into(),
        own.removed_mm2.into(),
        own.end_mm2.into(),
        bend.map(|bend| bend.aimed_mm.dot(&bend.left)).into(),
        across(0),
        across(1),
        across(2),
        own.milling.into(),
    ]
}

/// Returns the name of the column of the error without compensation under `source`.
pub(super) fn error_before_column(source: Source) -> String {
    match source {
        Source::All => "error_before_mm".into(),
        alone => format!("error_before_{}_mm", alone.label()),
    }
}

/// Returns a row per point of `verified`: the line that leads there (of `called_file`, if the program calls some), the tool angle φ, the wanted
/// and the commanded position (both in the workpiece frame), the error before (mm, by point of the path) and as written (base axes), the
/// cutting force, the poses of P in O and the drive positions without and with compensation, drive corrections and forces as written. An
/// empty cell has its reason in `status` and `reason`. `limits` names the limits that bind, if the path was corrected within limits. Where inputs are
/// uncertain, distributions follow.
pub fn program_table(job: &ProgramJob, verified: &VerifiedPart<'_>, bounded: Option<&BoundedPath>) -> Table {
    let machine = &job.machine;
    let columns = program_columns(job);
    let called = job.file.called_files();
    let spread_columns = spread_columns(job);
    let width = columns.len() - spread_columns.len() - play_columns(machine).len();
    let VerifiedPart { part, before, written, without_force, spread, .. } = verified;
    let (points, tasks) = (part.points, part.tasks());
    let stations = stations(&job.process, points, tasks, Some(&job.file));
    let mut track = job.tracker();
    let row = |((i, answer), station): ((usize, &PathPointResult), Station)| {
        let (k, point, task) = (part.first + i, &points[i], &tasks[i]);
        let mut row: Row = vec![k.into(), job.file.line_of(point.source.segment).into()];
        if !called.is_empty() {
            let file = job.file.file_of(point.source.segment).checked_sub(1);
            row.push(file.map_or_else(String::new, |file| called[file].clone()).into());
        }
        row.extend([point.arc_length_mm.into(), station.phi_deg.into(), usize::from(point.cutting).into()]);
        row.extend(cells(point.position_mm.iter().copied()));
        let commanded = answer.target.map(|pose| job.commanded_point(&mut track, point, task.external, pose));
        row.extend((0..3).map(|i| commanded.map(|point| point.position_mm[i]).into()));
        row.extend(Source::of(machine).iter().map(|source| before[*source][i].map(|error| error.norm()).into()));
        let shown = |value: f64| Cell::from(answer.is_settled.then_some(value));
        row.push(shown(answer.position_error.norm()));
        row.extend(answer.position_error.iter().map(|v| shown(*v)));
        row.push(without_force[i].map(|error| error.norm()).into());
        row.push(shown(answer.residual_rotation.norm().to_degrees()));
        row.extend(cutting_force::force_cells(task));
        if let Some(own) = job.path.engagements().get(k) {
            row.extend(engagement_cells(own));
        }
        row.extend([
            answer.status.label().into(),
            answer.status.reason(machine).into(),
            binding_limits(job, bounded, k).into(),
        ]);
        row.extend(pose_cells(Some(&task.pose)));
        row.extend(pose_cells(answer.target.as_ref()));
        row.extend(drive_cells(machine, task, answer, answer.is_settled));
        row.extend(shown_positions(machine, &answer.delta_rho()).iter().map(|v| shown(*v)));
        row.resize(width - machine.drive_count(), Cell::Missing);
        row.extend(answer.drive_forces.iter().map(|v| shown(*v)));
        row.resize(width, Cell::Missing);
        let spread = spread.get(i).and_then(Option::as_ref);
        row.extend(spread_columns.iter().map(|own| spread.map_or(Cell::Missing, |found| own.cell_of(Ok(found)))));
        row.extend(play_cells(machine, answer.play.as_ref(), Some(answer)));
        row
    };
    Table::new(columns, written.iter().enumerate().zip(stations).map(row))
}

/// Returns header and rows of a table of the errors of `passes`, lengths formatted by `shown`; `in_full` adds steps and any residual rotation.
pub fn passes_table(
    passes: &[Pass],
    in_full: bool,
    shown: impl Fn(f64) -> String + Copy,
) -> (Vec<&'static str>, Vec<Vec<String>>) {
    let turns = |pass: &Pass| pass.summary.max_residual_rotation.filter(|_| in_full);
    let has_turns = passes.iter().filter_map(turns).any(|angle| angle > 0.0);
    let mut header = vec!["commands", "largest", "rms"];
    header.extend(if in_full { vec!["steps", "solved"] } else { vec!["points solved"] });
    header.extend(has_turns.then_some("turned"));
    let row = |pass: &Pass| {
        let s = &pass.summary;
        let mut row = vec![pass.name.clone(), or_dash(s.max_mm, shown), or_dash(s.rms_mm, shown)];
        row.extend(in_full.then(|| or_dash(s.mean_corrections, |mean| format!("{mean:.1}"))));
        row.push(format!("{} of {}", s.solved, s.points));
        row.extend(has_turns.then(|| or_dash(turns(pass), |angle| format!("{:.3}°", angle.to_degrees()))));
        row
    };
    (header, passes.iter().map(row).collect())
}

/// Returns the limits that bind at point `k` in words, such as `correction x upper`.
fn binding_limits(job: &ProgramJob, bounded: Option<&BoundedPath>, k: usize) -> String {
    let labels = job.machine.drive_labels();
    let corrected = bounded.and_then(|path| path.points[k].corrected());
    let text = corrected.into_iter().flat_map(|point| &point.binding).map(|binding| {
        let side = match binding.side {
            Side::Lower => "lower",
            Side::Upper => "upper",
        };
        format!("{} {} {side}", binding.kind.label(), labels[binding.drive])
    });
    text.collect::<Vec<_>>().join("; ")
}

/// Returns quantities against their limits as JSON, such as where the program as written exceeds them.
fn exceeded_json(job: &ProgramJob, exceeded: &[LimitExcess]) -> Vec<Value> {
    let labels = job.machine.drive_labels();
    let entry = |found: &LimitExcess| {
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

/// Returns status, errors and binding limits of a path corrected within limits, as JSON.
fn bounded_json(job: &ProgramJob, path: &BoundedPath, forces: Option<&ForceCheck>) -> Value {
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
    let mut bounded = json!({
        "status": path.summary.status.label(),
        "linearisations": path.summary.iterations,
        "error_max_mm": path.summary.after.worst,
        "error_rms_mm": path.summary.after.rms,
        "force_excess": path.summary.force_excess,
        "limits_binding": limits,
    });
    if let Some(ForceCheck { draws, within, failed, p95, tightened, untightened_mm }) = forces {
        bounded["forces"] = json!({
            "probability": *within as f64 / *draws as f64,
            "probability_interval_95": share_interval(*within, *draws),
            "draws": draws,
            "draws_within": within,
            "draws_without_equilibrium": failed,
            "p95": exceeded_json(job, std::slice::from_ref(p95)).pop(),
            "untightened_error_max_mm": untightened_mm,
            "tightened_share": labels.iter().cloned().zip(tightened.iter().map(|share| json!(share))).collect::<Map<_, _>>(),
        });
    }
    bounded
}

/// Returns where the tool cuts and its force is not known, as JSON: each move once.
fn unknown_json(job: &ProgramJob) -> Value {
    let mut found: Vec<(usize, UnknownForce)> = Vec::new();
    for (k, point) in job.path.points().iter().enumerate() {
        let own = job.process.unknown_force(&job.path, k).map(|why| (point.source.segment, why));
        found.extend(own.filter(|own| found.last() != Some(own)));
    }
    let entry =
        |(segment, why): &(usize, UnknownForce)| json!({ "line": job.file.line_of(*segment), "why": why.label() });
    found.iter().map(entry).collect()
}

/// Returns what is said of a program as it was read, and its dialect or language; of a robot's program, the lines alone.
fn notes_and_dialect(file: &ProgramFile) -> (Notes, Option<&'static str>) {
    match file {
        ProgramFile::Gcode(program) => (program.notes().clone(), Some(program.notes().dialect.label())),
        ProgramFile::Robot(program) => {
            let notes = program.notes();
            let (unlocated_lines, written_out) = (notes.unlocated_lines.clone(), notes.written_out);
            (Notes { unlocated_lines, written_out, ..Notes::default() }, Some(program.language().label()))
        }
        ProgramFile::Polyline(_) => (Notes::default(), None),
    }
}

/// Returns the errors of a pass as JSON.
fn pass_json(pass: &Pass) -> Value {
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
        "residual_rotation_max_deg": s.max_residual_rotation.map(f64::to_degrees),
    })
}

/// Returns which force the verdict rests on, the mean or the peak of the teeth, as JSON; null without a force.
fn verdict_force_json(job: &ProgramJob) -> Value {
    match VerdictForce::of(&job.process, &job.path) {
        Some(own) => json!({
            "rests_on": own.rests_on.label(),
            "mean_N": own.mean_N,
            "peak_N": own.peak_N,
            "tooth_frequency_Hz": own.teeth_Hz,
            "first_natural_frequency_Hz": own.natural_Hz,
            "right": own.right().label(),
        }),
        None if job.process.has_force() => json!({ "rests_on": "as given" }),
        None => Value::Null,
    }
}

/// Version of the report.
const SCHEMA: u32 = 3;

/// Returns the report of the program as JSON: its passes, limits, blocks, calls and assumptions.
pub fn program_json(report_of: &Report<'_>) -> Value {
    let budget = words::budget(report_of);
    let Report { job, verified, findings, .. } = report_of;
    let VerifiedProgram { passes, bounded, exceeded, written, .. } = verified;
    let (notes, dialect) = notes_and_dialect(&job.file);
    let mut report = json!({
        "schema": SCHEMA,
        "machine": job.machine.name,
        "points": job.path.len(),
        "length_mm": job.path.length_mm(),
        "clearance": findings.clearance,
        "passes": passes.iter().map(pass_json).collect::<Vec<_>>(),
        "bounded": bounded.as_ref().map(|path| bounded_json(job, path, verified.forces.as_ref())),
        "without_force": json!({
            "point": verified.without_force.most.map(|(point, _)| point),
            "error_max_mm": verified.without_force.most.map(|(_, size)| size),
            "points_unknown": verified.without_force.unknown,
        }),
        "limits_exceeded_as_written": exceeded.as_ref().map(|exceeded| exceeded_json(job, exceeded)),
        "write_tolerance_mm": (!matches!(job.file, ProgramFile::Polyline(_))).then_some(job.process.write_tolerance_mm),
        "blocks": written.blocks,
        "workpiece": job.process.placement_text(),
        "counts_as_cutting": job.process.cutting_text(),
        "cuts_nowhere": job.cuts_nowhere(),
        "dialect": dialect,
        "unit_taken": notes.assumed_unit.map(|(unit, _)| unit.name()),
        "written_out": notes.written_out.map(|[lines, grown]| match &written.calls {
            WrittenCalls::Stay { .. } => Value::Null,
            WrittenCalls::None => json!({ "lines": lines, "written": grown }),
            WrittenCalls::WrittenOut { because } => json!({ "lines": lines, "written": grown, "because": because }),
        }),
        "lines_left_as_written": notes.unlocated_lines,
        "lines_corrected_at_points_alone": match &job.file {
            ProgramFile::Robot(program) => program.notes().spline_lines.clone(),
            _ => Vec::new(),
        },
        "angles_of_the_control": notes.chosen_angles.iter().map(|(line, [a, b, c])| json!({ "line": line, "A": a, "B": b, "C": c })).collect::<Vec<_>>(),
        "cutter_radii_written_out_mm": notes.cutter_radii_mm.iter().map(|(of, radius)| (of.to_string(), json!(radius))).collect::<serde_json::Map<_, _>>(),
        "axes_left_as_written": job.machine.uncontrolled_axes().map(|axis| ["x", "y", "z"][axis]).collect::<Vec<_>>(),
    });
    report["verdict_force"] = verdict_force_json(job);
    report["force_not_known"] = unknown_json(job);
    report[BUDGET] = words::of_verdict(report_of, &budget).json();
    let resting: BTreeMap<_, _> = job.machine.resting_drives().collect();
    if !resting.is_empty() {
        report["drives_left_at_home"] = json!(resting);
    }
    if let Some(uncertainty) = &job.uncertainty {
        report["uncertainty"] = spread_report::json(uncertainty, &findings.spread);
        report["uncertainty"]["largest"] = json!(verified.spread);
    }
    if let Some(found) = &job.feed {
        report["feed"] = feed::json(found);
    }
    if let Some(play) = findings.play.json() {
        report["play"] = play;
    }
    if let Some(machined) = &findings.machined {
        report["machined_surface"] = machined.json(job);
    }
    if let Some(found) = &verified.deflected_cut {
        let (point, size) = found.largest;
        report["without_compensation_in_its_own_cut"] = json!({
            "error_max_mm": size,
            "point": point,
            "in_the_programmed_cut_mm": found.programmed_mm,
            "cuts": found.rounds,
            "disagreement_mm": found.left_mm,
            "share_of_points_agreed": found.agreed,
            "converged": found.has_converged(),
        });
    }
    report
}
