//! Quantities of the drives: correction and force of each, and the largest of each kind.

use super::Quantity;
use crate::{
    answer::drive_columns::{correction_columns, force_columns, kind_word},
    machine::{Machine, Motion},
    page::Better,
};

/// Quantities of the drives of a machine, computed from a result of type `E`.
pub struct DriveQuantities<E> {
    /// Correction of each drive, mm or degrees, then force of each.
    pub each: Vec<Quantity<E>>,
    /// Largest correction of all drives, for prismatic and revolute ones apart.
    pub corrections: Vec<(Motion, Quantity<E>)>,
    /// Largest force of all drives, for prismatic and revolute ones apart.
    pub forces: Vec<(Motion, Quantity<E>)>,
}

impl<E: 'static> DriveQuantities<E> {
    /// Makes the quantities of the drives of `machine`. `correction` (mm or rad) and `force` (N or N·mm) read them from an entry by drive
    /// index, `None` where they are not known; `better` says which correction is better.
    pub fn new(
        machine: &Machine,
        better: Better,
        correction: fn(&E, usize) -> Option<f64>,
        force: fn(&E, usize) -> Option<f64>,
    ) -> Self {
        let labels = machine.drive_labels();
        let motions: Vec<Motion> = machine.drives().map(|(_, drive)| drive.motion).collect();
        let corrections = correction_columns(machine).enumerate().map(|(k, name)| {
            let motion = motions[k];
            let shown = move |entry: &E| correction(entry, k).map(|value| motion.to_shown(value));
            Quantity::computed(name, format!("correction of drive {}", labels[k]), better, shown)
        });
        let forces = force_columns(machine).enumerate().map(|(k, name)| {
            let label = format!("{} of drive {}", motions[k].force_word(), labels[k]);
            Quantity::computed(name, label, better, move |entry: &E| force(entry, k))
        });
        let (corrections, forces): (Vec<_>, Vec<_>) = (corrections.collect(), forces.collect());
        let largest = |all: &[Quantity<E>], kind: Motion, name: String, what: &str, sign: &str| {
            let each = all.iter().zip(&motions).filter(|(_, motion)| **motion == kind).map(|(each, _)| each.clone());
            let label = match machine.has_mixed_drives() {
                false => format!("largest drive {what} {sign}"),
                true => format!("largest {what} of {} {sign}", kind_word(machine, kind)),
            };
            (kind, Quantity::largest_of(name, label, Better::Smaller, each.collect()))
        };
        let of_corrections = |kind: Motion| {
            let name = format!("delta_rho_largest_drive_{}", kind.position_unit());
            largest(&corrections, kind, name, "correction", "|Δρ|")
        };
        let of_forces = |kind: Motion| {
            let name = format!("drive_{}_largest_drive_{}", kind.force_word(), kind.force_unit());
            largest(&forces, kind, name, kind.force_word(), "|τ|")
        };
        Self {
            corrections: machine.drive_kinds().map(of_corrections).collect(),
            forces: machine.drive_kinds().map(of_forces).collect(),
            each: [corrections, forces].concat(),
        }
    }

    /// Returns the quantities of the largest correction of each kind of drive, then those of the largest force.
    pub fn largest(&self) -> impl Iterator<Item = &Quantity<E>> {
        self.corrections.iter().chain(&self.forces).map(|(_, quantity)| quantity)
    }
}
