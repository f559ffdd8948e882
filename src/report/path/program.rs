//! A compensated program's points and errors.

use serde_json::{Value, json};

use crate::{
    compensation::{BoundedPath, LimitKind, Side},
    machine::{Machine, Motion},
    report::table::{correction_columns, force_columns, shown_positions},
    study::program::{Pass, ProgramJob},
};

/// One row per point: where the tool should be, what is commanded instead (both in the workpiece frame), the error before
/// (first pass) and as written (last pass, base axes), drive corrections and forces as written. An empty cell has its
/// reason in `status` and `reason`. `limits` names the limits that bind, if the path was corrected within limits.
pub fn program_csv(job: &ProgramJob, passes: &[Pass], bounded: Option<&BoundedPath>) -> csv::Result<Vec<u8>> {
    let (Some(before), Some(after)) = (passes.first(), passes.last()) else { return Ok(Vec::new()) };
    let machine = &job.machine;
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut header: Vec<String> = [
        "point",
        "line",
        "arc_length_mm",
        "cutting",
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
        "status",
        "reason",
        "limits",
    ]
    .map(String::from)
    .into();
    header.extend(correction_columns(machine).chain(force_columns(machine)));
    writer.write_record(&header)?;
    for (k, point) in job.path.points().iter().enumerate() {
        let line = job.file.line_of(point.source.segment).map_or_else(String::new, |line| line.to_string());
        let mut row = vec![k.to_string(), line, point.arc_length_mm.to_string(), u8::from(point.cutting).to_string()];
        row.extend(point.position_mm.iter().map(f64::to_string));
        let answer = &after.answers[k];
        let commanded = answer.target.map(|pose| job.process.placement.path_position(&pose, machine.tool_tip));
        row.extend((0..3).map(|i| commanded.map_or_else(String::new, |p| p[i].to_string())));
        let earlier = &before.answers[k].compensation;
        row.push(earlier.outcome.as_ref().map_or_else(String::new, |_| earlier.position_error.norm().to_string()));
        let (now, solved) = (&answer.compensation, answer.compensation.outcome.is_some());
        let shown = |value: f64| if solved { value.to_string() } else { String::new() };
        row.push(shown(now.position_error.norm()));
        row.extend(now.position_error.iter().map(|v| shown(*v)));
        row.push(shown(now.leftover_rotation.norm().to_degrees()));
        row.extend([now.status.label().to_string(), now.status.reason(machine), binding(job, bounded, k)]);
        row.extend(shown_positions(machine, &answer.delta_rho()).iter().map(|v| shown(*v)));
        row.resize(header.len() - machine.drive_count(), String::new());
        row.extend(now.drive_forces.iter().map(|v| shown(*v)));
        writer.write_record(&row)?;
    }
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
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
    let mut text = format!("Limits bind ({}, {} linearisations):\n", summary.status.label(), summary.iterations);
    for price in &summary.prices {
        let unit = match (price.kind, machine.drives().nth(price.drive).map(|(_, drive)| drive.motion)) {
            (LimitKind::Force, Some(Motion::Prismatic)) => "N",
            (LimitKind::Force, _) => "N·mm",
            (_, Some(Motion::Prismatic)) => "mm",
            _ => "rad",
        };
        text += &format!(
            "  {} of drive {} at {} points; the error would fall by {:.2e} mm per {unit} of relaxation\n",
            price.kind.label(),
            labels[price.drive],
            price.points,
            price.price
        );
    }
    text
}

fn bounded_json(job: &ProgramJob, path: &BoundedPath) -> Value {
    let labels = job.machine.drive_labels();
    let limits: Vec<Value> = path
        .summary
        .prices
        .iter()
        .map(|price| {
            json!({
                "limit": price.kind.label(),
                "drive": labels[price.drive],
                "points": price.points,
                "error_mm_per_unit": price.price,
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

/// What each pass leaves, over the points at which the tool cuts.
pub fn program_json(job: &ProgramJob, passes: &[Pass], bounded: Option<&BoundedPath>) -> String {
    let passes: Vec<Value> = passes
        .iter()
        .map(|pass| {
            let s = &pass.summary;
            json!({
                "commands": pass.name,
                "points": s.points,
                "points_solved": s.solved,
                "error_max_mm": s.max_mm,
                "error_rms_mm": s.rms_mm,
                "corrections_mean": s.mean_corrections,
                "rotation_left_max_deg": s.max_leftover_rotation.to_degrees(),
            })
        })
        .collect();
    let report = json!({
        "schema": 1,
        "machine": job.machine.name,
        "points": job.path.len(),
        "length_mm": job.path.length_mm(),
        "passes": passes,
        "bounded": bounded.map(|path| bounded_json(job, path)),
    });
    format!("{report:#}\n")
}
