//! The largest force of a process on the tool tip.

use crate::process::{ForceLaw, MillingForce, Process, cutting::CuttingLaw};

/// The largest force that a process has, N, whatever its path.
///
/// # Errors
/// Its force is known only along a path.
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub fn largest_force_N(process: &Process) -> Result<f64, String> {
    let of_tools = process.own_forces.of_tools.values();
    let all = of_tools.chain(process.own_forces.of_features.iter().map(|(_, law)| law));
    let mut largest = largest(&process.cutting)?;
    for law in all {
        largest = largest.max(self::largest(law)?);
    }
    Ok(largest)
}

fn largest(law: &CuttingLaw) -> Result<f64, String> {
    match law {
        CuttingLaw::None => Ok(0.0),
        CuttingLaw::PathFrame(frame) => Ok(of_milling(&frame.force)),
        CuttingLaw::Table(table) => Ok(table.largest_force_N()),
        CuttingLaw::FromPath | CuttingLaw::SlotMilling(_) | CuttingLaw::EndMilling(_) | CuttingLaw::Drilling(_) => Err(
            "the force of this process is known only along a path: expected the largest force that the table is for"
                .into(),
        ),
    }
}

/// Over all tool angles.
fn of_milling(force: &MillingForce) -> f64 {
    let (radial, tangential) = (force.radial.abs(), force.tangential.abs());
    let across = match force.law {
        // |F|² = F_r² + F_t² + 2 F_r F_t sin 2φ.
        ForceLaw::Printed => radial + tangential,
        ForceLaw::Rotated => radial.hypot(tangential),
    };
    across.hypot(force.axial)
}
