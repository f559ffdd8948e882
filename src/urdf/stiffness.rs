//! Stiffness of the drives, which a URDF cannot say: unknown, given, or that of another machine.

use super::chain::Drive;
use crate::{
    input::{
        error::{Error, Result},
        names::listed,
    },
    machine::{Machine, Motion},
};

/// The source of the drives' stiffness.
#[derive(Debug, Clone, Default)]
pub enum DriveStiffness {
    /// Unknown; to be written into the file.
    #[default]
    Unknown,
    /// One number for each drive from base to tip: N·m/rad of revolute joints, N/mm of prismatic joints.
    Given(Vec<f64>),
    /// That of another machine with the same kinds of drives in the same order.
    Like(Machine),
}

impl DriveStiffness {
    /// Returns the stiffness of each drive (N/mm or N·mm/rad), `None` if unknown; fails if numbers or machine do not fit the drives.
    pub(super) fn for_drives(&self, drives: &[&Drive]) -> Result<Vec<Option<f64>>> {
        match self {
            DriveStiffness::Unknown => Ok(vec![None; drives.len()]),
            DriveStiffness::Given(values) => given_stiffness(values, drives),
            DriveStiffness::Like(machine) => stiffness_like(machine, drives),
        }
    }

    /// Describes the source of the stiffness in words.
    pub(super) fn text(&self) -> String {
        match self {
            DriveStiffness::Unknown => "stiffness of the drives: unknown".into(),
            DriveStiffness::Given(_) => "stiffness of the drives: given at the import".into(),
            DriveStiffness::Like(machine) => format!("stiffness of the drives: as that of {}", machine.name),
        }
    }
}

/// Converts given numbers (N·m/rad, N/mm) to the units of machine files; fails if they are not one of sensible size for each drive.
fn given_stiffness(values: &[f64], drives: &[&Drive]) -> Result<Vec<Option<f64>>> {
    let fail = |problem: String| Err(Error::Argument { argument: "--stiffness".into(), problem });
    if values.len() != drives.len() {
        let names = listed(drives.iter().map(|drive| &drive.name));
        return fail(format!("expected {}, one for each of {names}, got {}", drives.len(), values.len()));
    }
    if let Some(wrong) = values.iter().find(|value| !(SOFTEST..=STIFFEST).contains(*value)) {
        return fail(format!("expected numbers between {SOFTEST:e} and {STIFFEST:e}, got {wrong:?}"));
    }
    let in_files = |(drive, &value): (&&Drive, &f64)| match drive.motion {
        Motion::Prismatic => Some(value),
        Motion::Revolute => Some(super::chain::times_thousand(value)),
    };
    Ok(drives.iter().zip(values).map(in_files).collect())
}

/// Numbers that somebody can mean, N·m/rad or N/mm.
const SOFTEST: f64 = 1e-12;
const STIFFEST: f64 = 1e15;

/// Returns the stiffness of the drives of `machine` (N/mm or N·mm/rad); fails if their kinds and order are not those of `drives`.
fn stiffness_like(machine: &Machine, drives: &[&Drive]) -> Result<Vec<Option<f64>>> {
    let kinds = |motions: &mut dyn Iterator<Item = Motion>| {
        motions
            .map(|motion| if motion == Motion::Revolute { "revolute" } else { "prismatic" })
            .collect::<Vec<_>>()
            .join(", ")
    };
    let imported = kinds(&mut drives.iter().map(|drive| drive.motion));
    let other = kinds(&mut machine.drives().map(|(_, drive)| drive.motion));
    if imported != other {
        let problem = format!(
            "{} has the drives {other}; the imported robot has {imported}: expected the same kinds in the same order, or --stiffness",
            machine.name
        );
        return Err(Error::Argument { argument: "--like".into(), problem });
    }
    Ok(machine.drives().map(|(_, drive)| Some(drive.stiffness)).collect())
}
