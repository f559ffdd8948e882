//! The map as CSV (RFC 4180), units in the headers.

use crate::{
    machine::Machine,
    report::table::{correction_columns, force_columns, shown_positions, tidy_degrees},
    study::{
        Source,
        workspace_map::{Failure, SourceEffect, WorkspaceMap},
    },
};

/// One row per grid point and source. Numbers in shortest form that reads back to the same value; cells without a number
/// are empty, with the reason in `status` and `reason`.
pub fn csv(map: &WorkspaceMap) -> csv::Result<Vec<u8>> {
    let machine = &map.study.machine;
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header(machine))?;
    for point in &map.points {
        for source in Source::ALL {
            let mut row: Vec<String> = point.position_mm.iter().map(f64::to_string).collect();
            row.push(source.label().into());
            match &point.effects[source as usize] {
                Ok(effect) => solved_cells(machine, effect, &mut row),
                Err(failure) => failed_cells(machine, failure, &mut row),
            }
            writer.write_record(&row)?;
        }
    }
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}

/// Column names; drive columns carry the drive's label and unit.
fn header(machine: &Machine) -> Vec<String> {
    let fixed = [
        "x_mm",
        "y_mm",
        "z_mm",
        "source",
        "status",
        "reason",
        "deflection_mm",
        "deflection_x_mm",
        "deflection_y_mm",
        "deflection_z_mm",
        "deflection_phi_deg",
        "stiffness_min_N_per_mm",
        "stiffness_mid_N_per_mm",
        "stiffness_max_N_per_mm",
        "departure_mm",
        "departure_x_mm",
        "departure_y_mm",
        "departure_z_mm",
        "departure_over_deflection",
    ];
    let mut names: Vec<String> = fixed.iter().map(ToString::to_string).collect();
    names.extend(correction_columns(machine));
    names.extend(force_columns(machine));
    names
}

fn solved_cells(machine: &Machine, effect: &SourceEffect, row: &mut Vec<String>) {
    let optional = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    row.extend(["solved".to_string(), String::new(), effect.deflection_mm.to_string()]);
    row.extend(effect.deflection_vector_mm.iter().map(f64::to_string));
    row.push(optional(effect.phi_deg.map(tidy_degrees)));
    row.extend(effect.principal_stiffness_n_per_mm.iter().map(f64::to_string));
    row.push(optional(effect.departure_mm()));
    for i in 0..3 {
        row.push(optional(effect.departure_vector_mm.map(|v| v[i])));
    }
    row.push(optional(effect.departure_mm().filter(|_| effect.deflection_mm > 0.0).map(|d| d / effect.deflection_mm)));
    row.extend(shown_positions(machine, &effect.delta_rho).iter().map(f64::to_string));
    row.extend(effect.drive_force.iter().map(f64::to_string));
}

fn failed_cells(machine: &Machine, failure: &Failure, row: &mut Vec<String>) {
    row.extend([failure.status.to_string(), failure.reason.clone()]);
    row.resize(header(machine).len(), String::new());
}
