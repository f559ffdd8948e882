//! What the measurements do not tell, and which further one would tell most of it: a force along an axis of O at one of their places.

use nalgebra::{DMatrix, DVector, SymmetricEigen, Vector3};

use super::{
    fit::{Fit, Search},
    measurements::{Applied, Measurement, Reading},
    model::{LoadedModel, Predicted},
};
use crate::{input::error::Result, work::Work};

/// A combination of unknowns that the measurements leave open.
#[derive(Debug, Clone, PartialEq)]
pub struct Open {
    /// Its parts, by index of the unknown, the largest first; a unit vector of coordinates.
    pub parts: Vec<(usize, f64)>,
    /// Standard deviation along it; infinite where it is not told at all.
    pub std: f64,
}

/// A measurement that would tell more.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// At the place of this measurement.
    pub measurement: usize,
    /// The force on the tool tip, N.
    pub force: Vector3<f64>,
    /// Standard deviation along the least known combination, before and after.
    pub std: [f64; 2],
}

/// A combination counts as open if its standard deviation is larger: half a factor of e, half a millimetre or degree.
const OPEN: f64 = 0.5;
/// A smaller part of a combination is left out.
const LEAST_PART: f64 = 0.2;
/// Information that counts as none, over the largest.
const NOTHING: f64 = 1e-13;

fn std_of(information: f64, most: f64) -> f64 {
    if information > NOTHING * most && information > 0.0 { information.sqrt().recip() } else { f64::INFINITY }
}

/// Combinations that are open, the least known first.
pub fn open(fit: &Fit) -> Vec<Open> {
    let told = SymmetricEigen::new(fit.information.clone());
    let most = told.eigenvalues.amax();
    let all = told.eigenvalues.iter().zip(told.eigenvectors.column_iter());
    let mut open: Vec<Open> = all
        .filter(|(value, _)| std_of(**value, most) > OPEN)
        .map(|(value, vector)| {
            let mut parts: Vec<(usize, f64)> = vector.iter().copied().enumerate().collect();
            parts.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            // The largest part is positive, so that the same answer has the same signs.
            let sign = parts.first().map_or(1.0, |(_, part)| part.signum());
            parts.retain(|(_, part)| part.abs() >= LEAST_PART);
            Open { parts: parts.into_iter().map(|(k, part)| (k, part * sign)).collect(), std: std_of(*value, most) }
        })
        .collect();
    open.sort_by(|a, b| b.std.total_cmp(&a.std));
    open
}

/// The force along an axis, as large as the largest that was applied, that raises the least information most; `None` where none does.
///
/// # Errors
/// The work was stopped, or there is no such machine.
pub fn advice(search: &Search<'_>, fit: &Fit, measurements: &[Measurement], work: &Work) -> Result<Option<Advice>> {
    let largest = measurements.iter().map(|m| m.load.force.norm()).fold(0.0, f64::max);
    if largest == 0.0 {
        return Ok(None);
    }
    let std = typical_std(fit, measurements);
    let least = |information: &DMatrix<f64>| {
        let told = SymmetricEigen::new(information.clone());
        let at = told.eigenvalues.imin();
        (told.eigenvalues[at], told.eigenvalues.amax(), told.eigenvectors.column(at).into_owned())
    };
    let (before, most, direction) = least(&fit.information);
    let loads = (0..3).map(|axis| Applied { force: Vector3::ith(axis, largest), moment: Vector3::zeros() });
    let loads: Vec<Applied> = loads.collect();
    let displacements = Reading::displacements_to_come();
    let candidates: Vec<(usize, Measurement)> = (measurements.iter().enumerate())
        .flat_map(|(i, own)| loads.iter().map(move |load| (i, own, *load)))
        .map(|(i, own, load)| (i, own.at_same_place(load, &displacements)))
        .collect();
    let asked: Vec<&Measurement> = candidates.iter().map(|(_, candidate)| candidate).collect();
    work.check()?;
    let model = LoadedModel::new(search.machine, search.unknowns, &fit.x, search.unknowns)?;
    let mut best: Option<(f64, Advice)> = None;
    for ((measurement, candidate), predicted) in candidates.iter().zip(model.each(&asked)) {
        let Ok(Predicted { slopes, .. }) = predicted else { continue };
        let slopes = slopes / std;
        // What it tells of the least known combination decides where the least of all is one of several that are equal.
        let gain = (&slopes * &direction).norm_squared();
        let (after, most, _) = least(&(&fit.information + slopes.transpose() * &slopes));
        let score = after.max(0.0) + 1e-9 * gain;
        if gain > NOTHING * most && best.as_ref().is_none_or(|(found, _)| score > *found) {
            let (measurement, force) = (*measurement, candidate.load.force);
            best = Some((score, Advice { measurement, force, std: [0.0, std_of(after, most)] }));
        }
    }
    Ok(best.map(|(_, advice)| Advice { std: [std_of(before, most), advice.std[1]], ..advice }))
}

/// Of the lengths that were read, mm.
fn typical_std(fit: &Fit, measurements: &[Measurement]) -> f64 {
    let quantities = measurements.iter().flat_map(|m| m.readings.iter().map(|reading| reading.quantity));
    let lengths: DVector<f64> = DVector::from_vec(
        quantities.zip(fit.stds.iter()).filter(|(quantity, _)| !quantity.is_rotation()).map(|(_, std)| *std).collect(),
    );
    if lengths.is_empty() { 1.0 } else { lengths.mean() }
}
