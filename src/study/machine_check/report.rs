//! Findings about a machine, for reading.

use nalgebra::{Matrix6, Vector3, Vector6};

use crate::{
    machine::{Drive, Geometry, Machine, ToolAxisSource, UnknownStiffness},
    report::{
        table::shown_positions,
        words::{counted, typographic},
    },
    study::machine_check::Findings,
};

/// The findings as text.
pub fn machine_text(machine: &Machine, findings: &Findings) -> String {
    let mut text = rigid_text(machine, findings);
    text += &stiffness_text(findings);
    text += "  where the tool's compliance at home comes from\n";
    for (name, share) in &findings.compliance_shares {
        text += &format!("    {:<38} {:>7.3} %\n", name, share * 100.0);
    }
    text + &provenance_text(machine) + &warnings_text(findings)
}

/// The findings about a machine of which only the geometry is known, as text.
pub fn geometry_text(geometry: &Geometry, findings: &Findings) -> String {
    let unknown: Vec<&str> = geometry.unknown().iter().map(|UnknownStiffness { drive, .. }| drive.as_str()).collect();
    let mut text = rigid_text(geometry.kinematics(), findings);
    text += &format!("  stiffness          unknown of {}: how far the tool moves cannot be said\n", unknown.join(", "));
    text + &provenance_text(geometry.kinematics()) + &warnings_text(findings)
}

fn provenance_text(machine: &Machine) -> String {
    let told = machine.provenance.iter();
    let lines: String = told
        .map(|told| format!("    {:<11} {}\n                {}\n", told.grade.label(), told.what, told.source))
        .collect();
    if lines.is_empty() { lines } else { format!("  where its numbers come from\n{lines}") }
}

fn warnings_text(findings: &Findings) -> String {
    let warnings: String = findings.warnings.iter().map(|warning| format!("warning: {warning}\n")).collect();
    if warnings.is_empty() { "no warnings\n".into() } else { warnings }
}

/// What does not depend on stiffness.
fn rigid_text(machine: &Machine, findings: &Findings) -> String {
    let mobility = &findings.mobility;
    let mut text = format!("{} — {}\n", machine.name, machine.title);
    text += &format!(
        "  chains             {} ({}), {}\n",
        machine.chains.len(),
        machine.chains.iter().map(|chain| chain.name.as_str()).collect::<Vec<_>>().join(", "),
        counted(machine.drive_count(), "drive")
    );
    text += &format!(
        "  mobility           {} ({} of the platform), over-constraint {}, left with drives locked {}\n",
        mobility.mechanism, mobility.platform, mobility.over_constraint, mobility.uncontrolled
    );
    if machine.redundancy > 0 {
        text += &format!(
            "  redundant          by {}: {} for {}; the drives stand as near to home as the task allows \
             (least squares, hinges at {:.0} mm){}\n",
            machine.redundancy,
            counted(machine.drive_count(), "drive"),
            counted(machine.controls.len(), "controlled coordinate"),
            machine.reach,
            if mobility.platform > machine.controls.len() { ", and the platform's other motions follow" } else { "" }
        );
    }
    let shown = |(rho, (_, drive)): (f64, (usize, &Drive))| drive.motion.position_words(rho);
    let drives: Vec<String> =
        shown_positions(machine, &findings.home_drives).into_iter().zip(machine.drives()).map(shown).collect();
    text += &format!("  drives at home     {}\n", drives.join(", "));
    text += &format!("  reach at home      {:.1} mm\n", machine.reach);
    text += &format!(
        "  tool axis          {} of the platform, {} of the base at home, from the spindle to the tip{}\n",
        direction(machine.tool_axes.column(2).into()),
        direction((machine.home.pose.rotation * machine.tool_axes).column(2).into()),
        tool_axis_words(machine.tool_axis_source)
    );
    let failures = findings.reached.iter().filter(|(_, _, reached)| reached.is_err()).count();
    text += &format!(
        "  places reached     {} of {} (home, named points, workspace corners)\n",
        findings.reached.len() - failures,
        findings.reached.len()
    );
    text += &format!(
        "  round trip         {:.1e} mm, {:.1e} rad (forward after inverse kinematics, largest)\n",
        findings.round_trip.0, findings.round_trip.1
    );
    text
}

/// How a tool axis was found that the machine file does not give, in brackets.
pub(crate) fn tool_axis_words(source: ToolAxisSource) -> &'static str {
    match source {
        ToolAxisSource::Given => "",
        ToolAxisSource::TowardsTip => " (assumed: from P to the tool tip)",
        ToolAxisSource::PlatformZ => " (assumed: z of the platform, as the tool tip is P)",
    }
}

/// The tool axis at home and the signs of forces about it, for pages.
pub(crate) fn tool_axis_fact(machine: &Machine) -> String {
    format!(
        "{} of the base at home, from the spindle to the tip{}; radial pushes the tool along φ, tangential along φ + 90°, \
         negative axial into the spindle",
        typographic(&direction((machine.home.pose.rotation * machine.tool_axes).column(2).into())),
        tool_axis_words(machine.tool_axis_source)
    )
}

/// Rounded components of a unit vector, without a minus sign before zero.
fn direction(v: Vector3<f64>) -> String {
    let [x, y, z]: [f64; 3] = v.map(|c| (c * 1e3).round() / 1e3 + 0.0).into();
    format!("({x}, {y}, {z})")
}

fn stiffness_text(findings: &Findings) -> String {
    let mut text = String::new();
    match findings.tool_stiffness {
        Some(principal) => {
            let shown = principal.map(|k| if k.is_infinite() { "rigid".into() } else { format!("{k:.1}") });
            text += &format!("  tool stiffness     {} N/mm (principal, of the tool tip, at home)\n", shown.join(", "));
        }
        None => text += "  tool stiffness     none: the platform is free or unstable at home\n",
    }
    match (&findings.stiffness, &findings.compliance) {
        (Some(stiffness), _) => {
            text += "  K_C at home        N/mm, N; N, N·mm/rad\n";
            text += &matrix_text(stiffness, 1e-6);
        }
        (None, Some(compliance)) => {
            let (wrenches, chains) = &findings.rigid;
            let cause = match chains.as_slice() {
                [] => String::new(),
                [chain] => format!(" by chain {chain}"),
                chains => format!(" by chains {}", chains.join(", ")),
            };
            text += &format!("  K_C at home        none: rigid in {} of 6 directions{cause}\n", wrenches.len());
            for wrench in wrenches {
                text += &format!("    no motion by     {} at P\n", wrench_text(wrench));
            }
            text += "  compliance at home mm/N, mm/(N·mm); rad/N, rad/(N·mm) at P\n";
            text += &matrix_text(compliance, 1e-12 * compliance.amax());
        }
        (None, None) => text += "  K_C at home        none: the platform is free or unstable at home\n",
    }
    text
}

/// Rows of a matrix; entries below `least` are zero.
fn matrix_text(matrix: &Matrix6<f64>, least: f64) -> String {
    let rows = matrix.row_iter().map(|row| {
        let cells: Vec<String> =
            row.iter().map(|v| format!("{:>12.4e}", if v.abs() < least { 0.0 } else { *v })).collect();
        format!("    {}\n", cells.join(" "))
    });
    rows.collect()
}

/// A wrench by its components.
fn wrench_text(wrench: &Vector6<f64>) -> String {
    let names = ["N along x", "N along y", "N along z", "N·mm about x", "N·mm about y", "N·mm about z"];
    let parts = wrench.iter().zip(names).filter(|(value, _)| **value != 0.0);
    parts.map(|(value, name)| format!("{} {name}", (value * 1e3).round() / 1e3)).collect::<Vec<_>>().join(" with ")
}
