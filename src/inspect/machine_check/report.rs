//! Text of the findings about a machine.

use std::fmt::Display;

use nalgebra::{Matrix6, Vector3, Vector6};

use crate::{
    answer::{direction, drive_columns::shown_positions, tool_axis_text},
    files::words::counted,
    inspect::machine_check::{BodiesFound, Droop, Findings, Payload, Softest, Span, Survey},
    machine::{Clearance, Drive, Geometry, Machine, Mobility, UnknownStiffness},
    spatial::PARALLEL_TO_X,
};

/// Returns the findings about a machine as text.
pub fn machine_text(machine: &Machine, findings: &Findings) -> String {
    let known = kinematics_text(machine, findings) + &stiffness_text(machine, findings) + &survey_text(findings);
    known + &shares_text(machine, findings) + &provenance_text(machine) + &warnings_text(findings)
}

/// Returns the findings about a machine of which only the geometry is known, as text.
pub fn geometry_text(geometry: &Geometry, findings: &Findings) -> String {
    let unknown: Vec<&str> = geometry.unknown().iter().map(|UnknownStiffness { drive, .. }| drive.as_str()).collect();
    let mut text = kinematics_text(geometry.kinematics(), findings);
    text += &line("stiffness", format!("unknown of {}: how far the tool moves cannot be said", unknown.join(", ")));
    text + &provenance_text(geometry.kinematics()) + &warnings_text(findings)
}

/// Returns a line of the findings: the label `what` and its value.
fn line(what: &str, value: impl Display) -> String {
    format!("  {what:<18} {value}\n")
}

/// Returns the compliance share of each element, at home and at the softest place.
fn shares_text(machine: &Machine, findings: &Findings) -> String {
    let softest = findings.survey.as_ref().and_then(|survey| survey.softest.as_ref());
    let title = match &machine.carrier {
        Some(_) => "compliance between tool and workpiece",
        None => "where the tool's compliance comes from",
    };
    if findings.compliance_shares.is_empty() {
        return String::new();
    }
    let mut text = match softest {
        Some(_) => format!("  {title:<42} at home   softest\n"),
        None => format!("  {title:<42} at home\n"),
    };
    for (i, (name, share)) in findings.compliance_shares.iter().enumerate() {
        let at_softest = softest.and_then(|softest| softest.compliance_shares.get(i));
        let at_softest = at_softest.map_or_else(String::new, |(_, share)| format!(" {:>7.3} %", share * 100.0));
        text += &format!("    {name:<38} {:>7.3} %{at_softest}\n", share * 100.0);
    }
    text
}

/// Returns the lines on the workspace: places reached, softest place, droop by weight and payload; empty if it was not surveyed.
fn survey_text(findings: &Findings) -> String {
    let Some(Survey { counts: [nx, ny, nz], reached, softest, droop, payload, left_out }) = &findings.survey else {
        return String::new();
    };
    let mut text = format!("  over the workspace {reached} of {} places reached ({nx} x {ny} x {nz})\n", nx * ny * nz);
    if let Some(Softest { position_mm, tool_stiffness_n_per_mm: [least, ..], .. }) = softest {
        text += &format!("    softest          {least:.1} N/mm {}\n", position_text(position_mm));
    }
    if let Some(Droop { range_mm: [least, largest], position_mm, .. }) = droop
        && least.is_finite()
    {
        text += &format!(
            "    droop by weight  {least:.3} to {largest:.3} mm of the tool tip from the rigid machine, most {}\n",
            position_text(position_mm)
        );
    }
    text += &match payload {
        Some(Payload { kilograms, drive, position_mm }) => format!(
            "    payload          {}{kilograms:.1} kg at the tool tip, at rest, beside its own weight: {drive} is then at its limit {}\n",
            if *left_out > 0 { "at most " } else { "" },
            position_text(position_mm)
        ),
        None if *reached == 0 || *left_out > 0 => String::new(),
        None => "    payload          not known: no drive with a force or torque limit carries it\n".into(),
    };
    if *left_out > 0 {
        text += &format!(
            "    not assessed    droop and payload at {left_out} of these places: those before took too long\n"
        );
    }
    text
}

/// Returns a position of P (mm) as text, rounded to 0.1 mm.
fn position_text(position: &Vector3<f64>) -> String {
    let [x, y, z]: [f64; 3] = position.map(|v| (v * 10.0).round() / 10.0 + 0.0).into();
    format!("at ({x}, {y}, {z}) mm")
}

/// Returns how far P goes from home along the controlled axes, as a line; empty if none is controlled.
fn spans_text(findings: &Findings) -> String {
    let end = |value: f64| if value.is_finite() { format!("{:+.1}", value + 0.0) } else { "without end".into() };
    let along = |(axis, span): (&str, &Option<Span>)| {
        span.as_ref().map(|[back, forth]| format!("{axis} {} to {}", end(*back), end(*forth)))
    };
    let spans: Vec<String> = ["x", "y", "z"].into_iter().zip(&findings.spans).filter_map(along).collect();
    if spans.is_empty() {
        return String::new();
    }
    line("from home", format!("{} mm, one axis at a time, oriented as at home", spans.join(", ")))
}

/// Returns the sources of the machine's parameters with their grades.
fn provenance_text(machine: &Machine) -> String {
    let entry = machine.provenance.iter().enumerate();
    let lines: String = entry
        .map(|(i, entry)| {
            let line =
                machine.line_of(&format!("provenance[{i}]")).map_or_else(String::new, |n| format!(" (line {n})"));
            format!("    {:<11} {}{line}\n                {}\n", entry.grade.label(), entry.what, entry.source)
        })
        .collect();
    if lines.is_empty() { lines } else { format!("  where the parameters come from\n{lines}") }
}

/// Returns all warnings, a line each.
fn warnings_text(findings: &Findings) -> String {
    let warnings: String = findings.warnings.iter().map(|warning| format!("warning: {warning}\n")).collect();
    if warnings.is_empty() { "no warnings\n".into() } else { warnings }
}

/// Returns the findings that do not depend on stiffness.
fn kinematics_text(machine: &Machine, findings: &Findings) -> String {
    let mobility = &findings.mobility;
    let mut text = format!("{} — {}\n", machine.name, machine.title);
    let (drives, chains) = (counted(machine.drive_count(), "drive"), machine.chains.len());
    let names: Vec<&str> = machine.chains.iter().map(|chain| chain.name.as_str()).collect();
    text += &line("chains", format!("{chains} ({}), {drives}", names.join(", ")));
    let Mobility { mechanism, platform, over_constraint, uncontrolled, .. } = mobility;
    text += &line(
        "mobility",
        format!(
            "{mechanism} ({platform} of the platform), over-constraint {over_constraint}, left with drives locked {uncontrolled}"
        ),
    );
    if machine.redundancy > 0 {
        let controlled = counted(machine.controls.len(), "controlled coordinate");
        let others = if *platform > machine.controls.len() { ", and the platform's other motions follow" } else { "" };
        text += &line(
            "redundant",
            format!(
                "by {}: {drives} for {controlled}; the drives stand as near to home as the task allows \
                 (least squares, revolute joints at {:.0} mm){others}",
                machine.redundancy, machine.characteristic_length
            ),
        );
    }
    if let Some(carrier) = &machine.carrier {
        let [x, y, z]: [f64; 3] = carrier.home.pose.translation.map(|v| (v * 1e3).round() / 1e3 + 0.0).into();
        let (name, drives) = (&carrier.name, counted(carrier.drive_count(), "drive"));
        let at = position_list(carrier, &carrier.home.drives);
        text += &line("workpiece carrier", format!("{name}, {drives} ({at}), W at ({x}, {y}, {z}) mm of the base"));
    }
    text += &line("drives at home", position_list(machine, &findings.home_drives));
    text += &line("char. length", format!("{:.1} mm", machine.characteristic_length));
    let of_platform = direction(machine.tool_axes.column(2).into());
    let of_base = direction((machine.home.pose.rotation * machine.tool_axes).column(2).into());
    let assumed = tool_axis_text(machine.tool_axis_source);
    text += &line(
        "tool axis",
        format!("{of_platform} of the platform, {of_base} of the base at home, from the spindle to the tip{assumed}"),
    );
    let [of_platform, of_base] = [machine.tool_axes, machine.home.pose.rotation * machine.tool_axes]
        .map(|axes| direction(axes.column(0).into()));
    let is_along_x = machine.tool_axes[(0, 0)] <= PARALLEL_TO_X;
    let why = if is_along_x { ", its y axis, as the tool is along its x axis" } else { "" };
    text +=
        &line("tool angle", format!("φ = 0 along {of_platform} of the platform{why}; {of_base} of the base at home"));
    text += &spans_text(findings);
    let (places, (off_mm, off_rad)) = (findings.reached.len(), findings.round_trip);
    let reached = findings.reached.iter().filter(|(_, _, reached)| reached.is_ok()).count();
    text += &line("places reached", format!("{reached} of {places} (home, named points, workspace corners)"));
    text +=
        &line("round trip", format!("{off_mm:.1e} mm, {off_rad:.1e} rad (forward after inverse kinematics, largest)"));
    text += &line("singularity", conditioning_text(findings.conditioning));
    text += &findings.bodies.as_ref().map_or_else(String::new, bodies_text);
    text + &branches_text(machine, findings)
}

/// Returns the bodies and which of them come nearest, as a line.
fn bodies_text(bodies: &BodiesFound) -> String {
    let mut text = format!("{} ({})", bodies.names.len(), bodies.names.join(", "));
    if let Some(own) = &bodies.at_home {
        text += &format!("; at home {}", own.text());
    }
    if let Some((place, own)) = bodies.anywhere.as_ref().filter(|(place, _)| place != "home") {
        text += &format!("; at {place} {}", own.text());
    }
    line("bodies", text)
}

/// Returns a distance to singularity in words.
pub(crate) fn conditioning_text(conditioning: f64) -> String {
    format!("{conditioning:.4} away: inverse condition number of the Jacobian, 0 where singular")
}

/// Returns the distances of an arm from changing its branch, by shoulder, elbow and wrist, as text.
pub(crate) fn branch_margin_text(clearance: &Clearance) -> String {
    let Clearance { shoulder_mm, elbow_deg, wrist_deg } = clearance;
    let side = if *shoulder_mm < 0.0 { "behind" } else { "ahead of" };
    format!(
        "wrist centre {:.1} mm {side} axis 1, elbow bent by {elbow_deg:.1}°, wrist by {wrist_deg:.1}°",
        shoulder_mm.abs()
    )
}

/// Returns the posture at home on each branch of an arm; empty for other machines.
fn branches_text(machine: &Machine, findings: &Findings) -> String {
    let Some(clearance) = &findings.clearance else { return String::new() };
    let home_branch = machine.branch_of(&machine.home);
    let mut text = line("at home", branch_margin_text(clearance)) + "  branches at home\n";
    for (branch, posture) in &findings.branches {
        let mark = if home_branch == Some(*branch) { " (home)" } else { "" };
        let words = match posture {
            None => "not reached".into(),
            Some(posture) => {
                let limits = match &posture.limits {
                    Ok(()) => "within travel".into(),
                    Err(limit) => limit.to_string(),
                };
                format!("{}: {limits}{mark}", position_list(machine, &posture.at.drives))
            }
        };
        text += &format!("    {branch:<18} {words}\n");
    }
    text
}

/// Returns drive positions (mm, rad) as text in the units that readers see.
fn position_list(machine: &Machine, drives: &[f64]) -> String {
    let shown = |(rho, (_, drive)): (f64, (usize, &Drive))| drive.motion.position_text(rho);
    shown_positions(machine, drives).into_iter().zip(machine.drives()).map(shown).collect::<Vec<_>>().join(", ")
}

/// Returns tool stiffness, stiffness matrix or compliance at home.
fn stiffness_text(machine: &Machine, findings: &Findings) -> String {
    let none = "none: the platform is free or unstable at home";
    let mut text = match findings.tool_stiffness {
        Some(principal) => {
            let shown = principal.map(|k| if k.is_infinite() { "rigid".into() } else { format!("{k:.1}") }).join(", ");
            let without = if machine.has_weight() { ", without weight" } else { "" };
            line("tool stiffness", format!("{shown} N/mm (principal, of the tool tip, at home{without})"))
        }
        None => line("tool stiffness", none),
    };
    match (&findings.stiffness, &findings.compliance) {
        (Some(stiffness), _) => {
            text += &line("K_C at home", "N/mm, N; N, N·mm/rad");
            text += &matrix_text(stiffness, 1e-6);
        }
        (None, Some(compliance)) => {
            let (wrenches, chains) = &findings.rigid;
            let cause = match chains.as_slice() {
                [] => String::new(),
                [chain] => format!(" by chain {chain}"),
                chains => format!(" by chains {}", chains.join(", ")),
            };
            text += &line("K_C at home", format!("none: rigid in {} of 6 directions{cause}", wrenches.len()));
            text.extend(wrenches.iter().map(|wrench| format!("    no motion by     {} at P\n", wrench_text(wrench))));
            text += &line("compliance at home", "mm/N, mm/(N·mm); rad/N, rad/(N·mm) at P");
            text += &matrix_text(compliance, 1e-12 * compliance.amax());
        }
        (None, None) => text += &line("K_C at home", none),
    }
    text
}

/// Returns the rows of a matrix as text; entries smaller than `least` are shown as zero.
fn matrix_text(matrix: &Matrix6<f64>, least: f64) -> String {
    let rows = matrix.row_iter().map(|row| {
        let cells: Vec<String> =
            row.iter().map(|v| format!("{:>12.4e}", if v.abs() < least { 0.0 } else { *v })).collect();
        format!("    {}\n", cells.join(" "))
    });
    rows.collect()
}

/// Returns the nonzero components of a wrench (N, N·mm) in words.
fn wrench_text(wrench: &Vector6<f64>) -> String {
    let names = ["N along x", "N along y", "N along z", "N·mm about x", "N·mm about y", "N·mm about z"];
    let parts = wrench.iter().zip(names).filter(|(value, _)| **value != 0.0);
    parts.map(|(value, name)| format!("{} {name}", (value * 1e3).round() / 1e3)).collect::<Vec<_>>().join(" with ")
}
