//! Combinations of unknowns that the measurements do not identify, and which further force at one of their poses would identify them best.

use nalgebra::{DMatrix, SymmetricEigen, Vector3};

use super::{
    fit::{Fit, Search},
    measurements::{AppliedLoad, Measurement, Reading},
    model::{LoadedModel, Predicted},
};
use crate::{input::error::Result, work::Work};

/// A combination of unknowns that the measurements do not identify well enough.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenCombination {
    /// Indices of the unknowns with their components of the unit vector of coordinates, the largest first, small ones left out.
    pub parts: Vec<(usize, f64)>,
    /// Standard deviation along it; infinite where it is not identifiable at all.
    pub std: f64,
}

/// A further measurement that would identify more.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// Index of the measurement whose pose it has.
    pub measurement: usize,
    /// Force on the tool tip, axes of O, N.
    pub force: Vector3<f64>,
    /// Largest standard deviation of any combination of the unknowns, before and after it.
    pub std: [f64; 2],
}

/// Standard deviation from which a combination is open: half a factor of e, half a millimetre or degree.
const OPEN: f64 = 0.5;
/// Smallest component of a combination that is listed.
const LEAST_PART: f64 = 0.2;
/// Smallest information of an identifiable direction, as a share of the largest.
const NOTHING: f64 = 1e-13;

/// Returns the standard deviation along an eigenvector with the eigenvalue `information`; infinite below [`NOTHING`] of the `largest`.
fn std_along(information: f64, largest: f64) -> f64 {
    if information > NOTHING * largest && information > 0.0 { information.sqrt().recip() } else { f64::INFINITY }
}

/// Returns the combinations of unknowns with a standard deviation above [`OPEN`], eigenvectors of the information matrix; the largest
/// first.
pub fn open_combinations(fit: &Fit) -> Vec<OpenCombination> {
    let eigen = SymmetricEigen::new(fit.information.clone());
    let largest = eigen.eigenvalues.amax();
    let eigenpairs = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    let mut open: Vec<OpenCombination> = eigenpairs
        .filter(|(value, _)| std_along(**value, largest) > OPEN)
        .map(|(value, vector)| {
            let mut parts: Vec<(usize, f64)> = vector.iter().copied().enumerate().collect();
            parts.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            // The largest part is positive, so that the same answer has the same signs.
            let sign = parts.first().map_or(1.0, |(_, part)| part.signum());
            parts.retain(|(_, part)| part.abs() >= LEAST_PART);
            OpenCombination {
                parts: parts.into_iter().map(|(k, part)| (k, part * sign)).collect(),
                std: std_along(*value, largest),
            }
        })
        .collect();
    open.sort_by(|a, b| b.std.total_cmp(&a.std));
    open
}

/// Chooses the measurement that raises the smallest eigenvalue of the information most: at a pose measured before, with the largest force
/// applied so far along an axis of O; `None` where none does, `Err` if the work was stopped or the fit makes no valid machine.
pub fn advise(search: &Search<'_>, fit: &Fit, measurements: &[Measurement], work: &Work) -> Result<Option<Advice>> {
    let largest = measurements.iter().map(|m| m.load.force.norm()).fold(0.0, f64::max);
    if largest == 0.0 {
        return Ok(None);
    }
    let std = typical_std(fit, measurements);
    let weakest = |information: &DMatrix<f64>| {
        let eigen = SymmetricEigen::new(information.clone());
        let index = eigen.eigenvalues.imin();
        (eigen.eigenvalues[index], eigen.eigenvalues.amax(), eigen.eigenvectors.column(index).into_owned())
    };
    let (before, most, direction) = weakest(&fit.information);
    let loads = [0, 1, 2].map(|axis| AppliedLoad { force: Vector3::ith(axis, largest), moment: Vector3::zeros() });
    let displacements = Reading::planned_displacements();
    let candidates = measurements.iter().flat_map(|row| loads.map(|load| row.planned_under(load, &displacements)));
    let candidates: Vec<Measurement> = candidates.collect();
    let plans: Vec<&Measurement> = candidates.iter().collect();
    work.check()?;
    let model = LoadedModel::new(search.machine, search.unknowns, &fit.x, search.unknowns)?;
    let mut best: Option<(f64, Advice)> = None;
    for (i, predicted) in model.each(&plans).into_iter().enumerate() {
        let Ok(Predicted { slopes, .. }) = predicted else { continue };
        let slopes = slopes / std;
        // What it tells of the least known combination decides where the least of all is one of several that are equal.
        let gain = (&slopes * &direction).norm_squared();
        let (after, most, _) = weakest(&(&fit.information + slopes.transpose() * &slopes));
        let score = after.max(0.0) + 1e-9 * gain;
        if gain > NOTHING * most && best.as_ref().is_none_or(|(found, _)| score > *found) {
            let (measurement, force) = (i / loads.len(), candidates[i].load.force);
            best = Some((score, Advice { measurement, force, std: [0.0, std_along(after, most)] }));
        }
    }
    Ok(best.map(|(_, advice)| Advice { std: [std_along(before, most), advice.std[1]], ..advice }))
}

/// Returns the mean standard deviation of the lengths read, mm; 1 without any.
fn typical_std(fit: &Fit, measurements: &[Measurement]) -> f64 {
    let readings = measurements.iter().flat_map(|row| &row.readings).zip(&fit.stds);
    let lengths: Vec<f64> = readings.filter(|(own, _)| !own.quantity.is_rotation()).map(|(_, std)| *std).collect();
    if lengths.is_empty() { 1.0 } else { lengths.iter().sum::<f64>() / lengths.len() as f64 }
}
