//! Quantities and table of a map: the effect of each source at each grid point.

use crate::{
    answer::{DriveQuantities, FoundOr, Quantity, QuantityTable, status_cells},
    files::{
        exchange::{Cell, Row, Table, cells, numbers, texts},
        words::tidy_degrees,
    },
    machine::Machine,
    page::{
        Better::{Larger, Neither, Smaller},
        WORST_ANGLE,
    },
    questions::{
        map::{MapPoint, SourceEffect, WorkspaceMapStudy},
        spread_report::{self, WithSpread},
    },
    simulation::spread::DeflectionSpread,
};

type Of = Quantity<SourceEffect>;

pub(super) const DEFLECTION: Of =
    Of::new("deflection_mm", "worst tool deflection", Smaller, |effect| Some(effect.deflection_mm));
pub(super) const ANGLE: Of =
    Of::new("deflection_phi_deg", WORST_ANGLE, Neither, |effect| effect.phi_deg.map(tidy_degrees));
/// Principal stiffnesses of the tool tip, N/mm.
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
/// Residual error after correction of the drives, mm.
pub(super) const RESIDUAL_ERROR: Of =
    Of::in_table("residual_error_mm", |effect| effect.delta_rho.as_ref().ok().map(|_| effect.residual_mm));

impl WithSpread for SourceEffect {
    /// Returns the distribution of the deflection; `None` for single sources, and where inputs are taken as exact.
    fn distribution(&self) -> Option<&DeflectionSpread> {
        self.spread.as_ref()
    }
}

pub(super) const MEDIAN: Of =
    Of::new("deflection_median_mm", "median deflection", Smaller, |effect| effect.distribution()?.median_mm);
pub(super) const P95_DEFLECTION: Of =
    Of::new("deflection_p95_mm", "95 % quantile of the deflection", Smaller, |effect| effect.distribution()?.p95_mm);
pub(super) const PROBABILITY: Of =
    Of::new("within_tolerance_probability", "probability within tolerance", Larger, |e| {
        e.distribution()?.within_tolerance
    });

/// Lists the quantities of the distribution of the deflection that pages show.
fn spread_quantities(study: &WorkspaceMapStudy) -> Vec<Of> {
    if study.uncertainty.is_none() {
        return Vec::new();
    }
    let probability = study.load_case.tolerance_mm.map(|_| PROBABILITY);
    [P95_DEFLECTION, MEDIAN].into_iter().chain(probability).collect()
}

/// Names of the columns of the distribution of the deflection ([`spread_report::columns`]).
const SPREAD_COLUMNS: [&str; 3] = ["deflection_p95_standard_error_mm", "spread_main_cause", "spread_main_cause_share"];

/// Returns the components of the largest deflection, O axes, mm.
fn deflection_components() -> [Of; 3] {
    Of::vector_mm("deflection", "deflection", |effect| Some(effect.deflection_vector_mm))
}

/// Returns the quantities of corrections and forces of the drives, each drive alone and the largest of a kind.
pub(super) fn drives(machine: &Machine) -> DriveQuantities<SourceEffect> {
    let correction = |effect: &SourceEffect, drive: usize| Some(effect.delta_rho.as_ref().ok()?[drive]);
    DriveQuantities::new(machine, Smaller, correction, |effect, drive| Some(effect.drive_force[drive]))
}

/// Lists the quantities of the page's view, in its order.
pub(super) fn page_quantities(study: &WorkspaceMapStudy, drives: &DriveQuantities<SourceEffect>) -> Vec<Of> {
    let mut quantities = vec![DEFLECTION];
    quantities.extend(spread_quantities(study));
    quantities.extend(drives.largest().cloned());
    quantities.extend(STIFFNESS);
    quantities.extend([SUPERPOSITION_ERROR, SUPERPOSITION_ERROR_SHARE, ANGLE]);
    quantities.extend(deflection_components());
    quantities.extend(drives.each.iter().cloned());
    quantities
}

/// Returns the columns of the table of the map, in order; see [`table()`].
pub(super) fn columns(study: &WorkspaceMapStudy) -> QuantityTable<SourceEffect> {
    let machine = &study.load_case.machine;
    // What has no equilibrium to start from is not corrected either.
    /// Returns status and reason of the correction as cells; those of the equilibrium where there is none.
    fn correction(effect: FoundOr<'_, SourceEffect>) -> [Cell; 2] {
        status_cells(effect.and_then(|effect| effect.delta_rho.as_ref()))
    }
    let status = Of::text("correction_status", |effect| correction(effect)[0].clone());
    let reason = Of::text("correction_reason", |effect| correction(effect)[1].clone());
    let mut all = vec![status, reason, DEFLECTION];
    all.extend(deflection_components());
    all.push(ANGLE);
    all.extend(STIFFNESS);
    all.push(SUPERPOSITION_ERROR);
    all.extend(Of::vector_mm("superposition_error", "", |effect| effect.superposition_error_vector_mm));
    all.push(SUPERPOSITION_ERROR_SHARE);
    all.extend(drives(machine).each);
    // The drives cannot put all of the error right.
    all.extend(machine.uncontrolled_axes().next().map(|_| RESIDUAL_ERROR));
    all.extend(spread_quantities(study));
    all.extend(study.uncertainty.iter().flat_map(|_| spread_report::columns(SPREAD_COLUMNS)));
    QuantityTable::new([numbers(["x_mm", "y_mm", "z_mm"]), texts(["source"])].concat(), all)
}

/// Makes the table of the map, one row per point and source, with statuses and reasons where numbers or corrections are missing.
pub fn table(study: &WorkspaceMapStudy, points: &[MapPoint]) -> Table {
    columns(study).table(points.iter().flat_map(|point| {
        point.effects.iter().map(|(source, effect)| {
            let mut lead: Row = cells(point.position_mm).collect();
            lead.push(source.label().into());
            (lead, effect.as_ref())
        })
    }))
}
