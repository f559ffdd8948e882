//! A path study as CSV (RFC 4180), units in the headers.

use nalgebra::Vector3;

use crate::{
    machine::Machine,
    report::table::{correction_columns, force_columns, shown_positions},
    study::{
        Source,
        path::PathAnswer,
        path_study::{PathResults, Station},
    },
};

/// One row per point and source: where the point put right should be, how far it is moved at the nominal command, where to
/// command P instead, drive forces then, and the rotation left over. `status` and `reason` say why numbers are missing.
pub fn points_csv(results: &PathResults) -> csv::Result<Vec<u8>> {
    let machine = &results.study.machine;
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header(machine))?;
    for (k, station) in results.study.stations.iter().enumerate() {
        let demand = &results.study.demands[k];
        let wanted = demand.pose.transform(demand.offset(machine));
        for source in Source::ALL {
            let along = &results.sources[source as usize];
            let mut row = place(k, station, wanted, source);
            let compensated = &along.compensated[k];
            row.push(compensated.compensation.status.label().into());
            row.push(compensated.compensation.status.reason(machine));
            displacement(&along.plain[k], &mut row);
            command(machine, compensated, &mut row);
            writer.write_record(&row)?;
        }
    }
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}

fn header(machine: &Machine) -> Vec<String> {
    let mut names: Vec<String> = [
        "point",
        "arc_length_mm",
        "phi_deg",
        "wanted_x_mm",
        "wanted_y_mm",
        "wanted_z_mm",
        "source",
        "status",
        "reason",
        "displacement_mm",
        "displacement_x_mm",
        "displacement_y_mm",
        "displacement_z_mm",
        "commanded_platform_x_mm",
        "commanded_platform_y_mm",
        "commanded_platform_z_mm",
        "leftover_rotation_x_deg",
        "leftover_rotation_y_deg",
        "leftover_rotation_z_deg",
        "error_left_mm",
    ]
    .map(String::from)
    .into();
    names.extend(correction_columns(machine));
    names.extend(force_columns(machine));
    names
}

fn place(k: usize, station: &Station, wanted: Vector3<f64>, source: Source) -> Vec<String> {
    let mut row = vec![k.to_string(), station.arc_length_mm.to_string()];
    row.push(station.phi_deg.map_or_else(String::new, |phi| phi.to_string()));
    row.extend(wanted.iter().map(f64::to_string));
    row.push(source.label().into());
    row
}

fn displacement(plain: &PathAnswer, row: &mut Vec<String>) {
    match &plain.compensation.outcome {
        Some(_) => {
            let error = plain.compensation.position_error;
            row.push(error.norm().to_string());
            row.extend(error.iter().map(f64::to_string));
        }
        None => row.extend(std::iter::repeat_n(String::new(), 4)),
    }
}

fn command(machine: &Machine, answer: &PathAnswer, row: &mut Vec<String>) {
    let drive_count = machine.drive_count();
    let Some(target) = answer.target.filter(|_| answer.compensation.status.is_success()) else {
        row.extend(std::iter::repeat_n(String::new(), 7 + 2 * drive_count));
        return;
    };
    row.extend(target.translation.iter().map(f64::to_string));
    row.extend(answer.compensation.leftover_rotation.iter().map(|v| v.to_degrees().to_string()));
    row.push(answer.compensation.position_error.norm().to_string());
    row.extend(shown_positions(machine, &answer.delta_rho()).iter().map(f64::to_string));
    row.extend(answer.compensation.drive_forces.iter().map(f64::to_string));
}

/// One row per method: what it leaves and how many corrections it needs. Time is not here, as it differs between runs.
pub fn methods_csv(results: &PathResults) -> csv::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "method",
        "points",
        "solved",
        "failed",
        "corrections_mean",
        "error_max_mm",
        "error_rms_mm",
        "leftover_rotation_max_deg",
    ])?;
    for method in &results.methods {
        let s = &method.summary;
        writer.write_record([
            method.method.label(),
            s.points.to_string(),
            s.solved.to_string(),
            method.failed.to_string(),
            s.mean_corrections.to_string(),
            s.max_mm.to_string(),
            s.rms_mm.to_string(),
            s.max_leftover_rotation.to_degrees().to_string(),
        ])?;
    }
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}
