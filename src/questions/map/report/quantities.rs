//! The numbers of a map: what a source does at a grid point.

use crate::{
    answer::{FoundOr, OfDrives, Quantity, TableOf, status_cells},
    files::{
        exchange::{Cell, Row, Table, cells, numbers, texts},
        table::tidy_degrees,
    },
    machine::Machine,
    page::{
        Better::{Larger, Neither, Smaller},
        WORST_ANGLE,
    },
    questions::map::{MapPoint, SourceEffect},
};

type Of = Quantity<SourceEffect>;

pub(super) const DEFLECTION: Of =
    Of::new("deflection_mm", "worst tool deflection", Smaller, |effect| Some(effect.deflection_mm));
pub(super) const ANGLE: Of =
    Of::new("deflection_phi_deg", WORST_ANGLE, Neither, |effect| effect.phi_deg.map(tidy_degrees));
/// The principal ones of the tool tip.
pub(super) const STIFFNESS: [Of; 3] = [
    Of::new("stiffness_min_N_per_mm", "smallest principal stiffness", Larger, |e| {
        Some(e.principal_stiffness_n_per_mm[0])
    }),
    Of::new("stiffness_mid_N_per_mm", "middle principal stiffness", Larger, |e| {
        Some(e.principal_stiffness_n_per_mm[1])
    }),
    Of::new("stiffness_max_N_per_mm", "largest principal stiffness", Larger, |e| {
        Some(e.principal_stiffness_n_per_mm[2])
    }),
];
pub(super) const SUPERPOSITION_ERROR: Of =
    Of::new("superposition_error_mm", "superposition error", Smaller, SourceEffect::superposition_error_mm);
pub(super) const SUPERPOSITION_ERROR_SHARE: Of =
    Of::new("superposition_error_over_deflection", "superposition error over deflection", Smaller, |effect| {
        Some(effect.superposition_error_mm().filter(|_| effect.deflection_mm > 0.0)? / effect.deflection_mm)
    });
/// What corrected drives leave.
pub(super) const LEFT: Of =
    Of::in_table("residual_error_mm", |effect| effect.delta_rho.as_ref().ok().map(|_| effect.residual_mm));

fn deflection_along() -> [Of; 3] {
    Of::vector_mm("deflection", "deflection", |effect| Some(effect.deflection_vector_mm))
}

/// Corrections and forces of the drives.
pub(super) fn drives(machine: &Machine) -> OfDrives<SourceEffect> {
    let correction = |effect: &SourceEffect, drive: usize| Some(effect.delta_rho.as_ref().ok()?[drive]);
    OfDrives::new(machine, Smaller, correction, |effect, drive| Some(effect.drive_force[drive]))
}

/// Those of a page, in its order.
pub(super) fn on_page(drives: &OfDrives<SourceEffect>) -> Vec<Of> {
    let mut all = vec![DEFLECTION];
    all.extend(drives.largest().cloned());
    all.extend(STIFFNESS);
    all.extend([SUPERPOSITION_ERROR, SUPERPOSITION_ERROR_SHARE, ANGLE]);
    all.extend(deflection_along());
    all.extend(drives.each.iter().cloned());
    all
}

/// The columns of [`table()`].
pub(super) fn columns(machine: &Machine) -> TableOf<SourceEffect> {
    // What has no equilibrium to start from is not corrected either.
    fn correction(effect: FoundOr<'_, SourceEffect>) -> [Cell; 2] {
        status_cells(effect.and_then(|effect| effect.delta_rho.as_ref()))
    }
    let status = Of::text("correction_status", |effect| correction(effect)[0].clone());
    let reason = Of::text("correction_reason", |effect| correction(effect)[1].clone());
    let mut all = vec![status, reason, DEFLECTION];
    all.extend(deflection_along());
    all.push(ANGLE);
    all.extend(STIFFNESS);
    all.push(SUPERPOSITION_ERROR);
    all.extend(Of::vector_mm("superposition_error", "", |effect| effect.superposition_error_vector_mm));
    all.push(SUPERPOSITION_ERROR_SHARE);
    all.extend(drives(machine).each);
    // The drives cannot put all of the error right.
    all.extend(machine.uncontrolled_axes().next().map(|_| LEFT));
    TableOf::new([numbers(["x_mm", "y_mm", "z_mm"]), texts(["source"])].concat(), all)
}

/// One row per point and source; `status` and `reason` say why numbers are missing, `correction_status` and
/// `correction_reason` why those of the drive corrections are.
pub fn table(machine: &Machine, points: &[MapPoint]) -> Table {
    columns(machine).table(points.iter().flat_map(|point| {
        point.effects.iter().map(|(source, effect)| {
            let mut lead: Row = cells(point.position_mm).collect();
            lead.push(source.label().into());
            (lead, effect.as_ref())
        })
    }))
}
