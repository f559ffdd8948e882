//! What limits do to a program, in sentences.

use crate::{
    compensation::BoundedPath,
    files::words::{counted, millimetres},
    machine::Machine,
    products::program::{
        ProgramJob,
        bounded::Exceeded,
        report::units::{shown_limit_unit, shown_price},
    },
    simulation::ProgramFile,
};

/// Which limits bind and what they cost, in sentences.
pub fn bounded_text(machine: &Machine, path: &BoundedPath) -> String {
    let summary = &path.summary;
    let labels = machine.drive_labels();
    if summary.prices.is_empty() {
        return "No limit binds: the corrections without limits keep all of them.\n".into();
    }
    let mut text =
        format!("Limits bind ({}, {}):\n", summary.status.label(), counted(summary.iterations, "linearisation"));
    for price in &summary.prices {
        let error_mm = shown_price(machine, price);
        text += &format!(
            "  {} of drive {} at {}; the error would fall by {} per {} of relaxation\n",
            price.kind.label(),
            labels[price.drive],
            counted(price.points, "point"),
            millimetres(error_mm, 4),
            shown_limit_unit(machine, price.kind, price.drive),
        );
    }
    text + &forced_text(machine, path)
}

/// That limits force more error on the worst point than there is without correction, and which; nothing if they do not.
fn forced_text(machine: &Machine, path: &BoundedPath) -> String {
    let corrected = path.points.iter().enumerate().filter_map(|(k, point)| Some((k, point.corrected()?)));
    let worst = corrected.max_by(|(_, a), (_, b)| a.error.total_cmp(&b.error));
    let before = path.summary.before.worst;
    let Some((k, worst)) = worst.filter(|(_, worst)| worst.error > before * (1.0 + 1e-9)) else {
        return String::new();
    };
    let labels = machine.drive_labels();
    let limits = worst.binding.iter().map(|limit| format!("{} of drive {}", limit.kind.label(), labels[limit.drive]));
    let mut limits: Vec<String> = limits.collect();
    limits.dedup();
    let limits = if limits.is_empty() { "limits of points near it".into() } else { limits.join(", ") };
    format!(
        "At point {k} the limits force more error than there is without correction anywhere: {}, not {} ({limits}).\n",
        millimetres(worst.error, 4),
        millimetres(before, 4)
    )
}

/// By how much the program as written exceeds limits that its corrections kept, in sentences; nothing if it does not.
pub fn exceeded_text(job: &ProgramJob, exceeded: &[Exceeded]) -> String {
    let labels = job.machine.drive_labels();
    let mut text = String::new();
    let nearer = match &job.file {
        ProgramFile::Gcode(_) | ProgramFile::Robot(_) if job.process.write_tolerance_mm > 0.0 => {
            "More decimals and a smaller write tolerance (decimals_mm, write_tolerance_mm in [gcode])"
        }
        _ => "More decimals (decimals_mm in [gcode])",
    };
    for found in exceeded {
        let unit = shown_limit_unit(&job.machine, found.kind, found.drive);
        text += &format!(
            "As written, the {} of drive {} is {:.6} {unit} at point {}: {:.1e} {unit} beyond its limit of {} {unit}. \
             {nearer} or a limit smaller by this much keep it.\n",
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

/// What no drive can compensate, where there is such a thing; `left_mm` is left by the commands.
pub fn left_text(machine: &Machine, left_mm: Option<f64>) -> String {
    let (Some(axes), Some(left)) = (machine.uncontrolled_names(), left_mm) else { return String::new() };
    let left = millimetres(left, 4);
    format!("Compensation leaves up to {left}: the drives do not control {axes}.\n")
}

/// How far writing holes of cycles has moved positions on their ways, where there are any.
pub fn holes_text(in_holes_mm: Option<f64>) -> String {
    in_holes_mm.map_or_else(String::new, |most| {
        let most = millimetres(most, 4);
        format!("Holes of cycles have the correction of their bottoms: on the ways in and out, it differs by up to {most}.\n")
    })
}
