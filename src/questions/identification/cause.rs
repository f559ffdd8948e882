//! What would explain a large residual: a drive whose zero is off, or readings along other axes than those of O.

use nalgebra::{Matrix3, Matrix4, Quaternion, SymmetricEigen, UnitQuaternion, Vector3};

use super::{
    IdentificationStudy,
    fit::{Fit, Search},
    measurements::{Measurement, READ_VECTORS},
    unknown::{Unknown, unknowns},
    validate::{outliers, residual_share, rms_mm},
};
use crate::{
    input::{check::Check, error::Result},
    work::Work,
};

/// Something that was tried and leaves far less than the fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Cause {
    /// What was tried.
    pub kind: CauseKind,
    /// RMS residual of lengths with it, mm; `None` without lengths.
    pub residual_mm: Option<f64>,
    /// Residual over what was measured with it, without outliers; `None` where no length changes by the load.
    pub share: Option<f64>,
}

/// Kind of a [`Cause`].
#[derive(Debug, Clone, PartialEq)]
pub enum CauseKind {
    /// The zero of a drive: its error as an unknown, and the value that fits best, or at least that at the end of the search.
    Zero {
        /// The parameter.
        unknown: Unknown,
        /// Its value, mm or degrees.
        value: f64,
        /// Whether it would go farther than it is sought.
        is_at_limit: bool,
    },
    /// All readings are turned by this rotation vector of O, rad.
    Turned(Vector3<f64>),
}

/// Most measurements with which causes are tried.
const MOST: usize = 400;
/// A cause leaves at most this share of the residual: unlike a number more in a fit, it explains.
const EXPLAINS: f64 = 0.5;
/// Fewest readings more than unknowns with which something is explained and not only followed.
const FEWEST: usize = 8;
/// Most fits with turned readings, and the change of the rotation from which it is found, rad.
const FITS: usize = 8;
const FOUND: f64 = 1e-4;

/// Tries each drive's zero, and one rotation of all readings; returns what leaves least, if that explains the residual of `fit`. `Err` if the work was stopped.
pub fn find(study: &IdentificationStudy, fit: &Fit, work: &Work) -> Result<Option<Cause>> {
    let step = study.measurements.len().div_ceil(MOST);
    let rows: Vec<Measurement> = study.measurements.iter().step_by(step).cloned().collect();
    if rows.iter().map(|row| row.readings.len()).sum::<usize>() < study.unknowns.len() + FEWEST {
        return Ok(None);
    }
    let search = study.fitting_problem(&study.unknowns, &study.priors, work);
    let mut best: Option<(f64, Cause)> = None;
    let mut try_one = |fitted: Option<Fit>, rows: &[Measurement], kind: &dyn Fn(&Fit) -> CauseKind| {
        let Some(fitted) = fitted.filter(|own| own.is_converged) else { return };
        let left = misfit(study, &fitted, rows);
        if best.as_ref().is_none_or(|(least, _)| left < *least) {
            let (residuals, far) = (fitted.residuals.as_slice(), outliers(&fitted, rows));
            let share = residual_share(residuals, rows, &far);
            best = Some((left, Cause { kind: kind(&fitted), residual_mm: rms_mm(residuals, rows), share }));
        }
    };
    for (chain, drive) in study.machine.drives() {
        let name = format!("{}.{}.offset", study.machine.chains[chain].name, drive.name);
        let Some(zero) = unknown_zero(study, name) else { continue };
        let all: Vec<Unknown> = study.unknowns.iter().cloned().chain([zero.clone()]).collect();
        let fitted = from_file(&study.fitting_problem(&all, &study.priors, work), &rows);
        work.check()?;
        try_one(fitted, &rows, &|fitted| {
            let x = fitted.x[all.len() - 1];
            CauseKind::Zero { value: zero.value(x), is_at_limit: zero.is_at_limit(x), unknown: zero.clone() }
        });
    }
    if let Some((rotation, turned)) = turned_readings(&search, fit, &rows, step) {
        try_one(from_file(&search, &turned), &turned, &|_| CauseKind::Turned(rotation));
    }
    work.check()?;
    let before = misfit(study, fit, &study.measurements);
    Ok(best.filter(|(left, _)| *left <= EXPLAINS * before).map(|(_, cause)| cause))
}

/// Returns the error of a drive's zero as an unknown; `None` where the study seeks it, or it has none.
fn unknown_zero(study: &IdentificationStudy, name: String) -> Option<Unknown> {
    let is_sought = study.unknowns.iter().any(|unknown| unknown.name == name);
    let found = if is_sought { None } else { unknowns(&study.machine, &[name], &Check::new("")).ok() };
    found.and_then(|found| found.into_iter().next())
}

/// Fits `rows` from the machine file; `None` where that fails.
fn from_file(search: &Search<'_>, rows: &[Measurement]) -> Option<Fit> {
    let start = nalgebra::DVector::zeros(search.unknowns.len());
    search.fit(&rows.iter().collect::<Vec<_>>(), &start).ok()
}

/// Returns the RMS of the residuals over the noise of their readings.
fn misfit(study: &IdentificationStudy, fit: &Fit, rows: &[Measurement]) -> f64 {
    let readings = rows.iter().flat_map(|row| &row.readings).zip(&fit.residuals).zip(&fit.weights);
    let squares = readings.map(|((reading, residual), weight)| weight * (residual / study.noise.of(reading)).powi(2));
    (squares.sum::<f64>() / fit.residuals.len() as f64).sqrt()
}

/// Returns the rotation vector by which all readings of `rows`, each `step`-th of those of `fit`, look turned, and the rows turned back; `None`
/// where a reading is no component of a whole vector. Parameters and rotation are fitted in turn.
fn turned_readings(
    search: &Search<'_>,
    fit: &Fit,
    rows: &[Measurement],
    step: usize,
) -> Option<(Vector3<f64>, Vec<Measurement>)> {
    let vectors = |row: &Measurement| -> Option<Vec<[usize; 3]>> {
        let place = |column: &str| row.readings.iter().position(|reading| reading.column == column);
        let of_kind = |columns: &[&str; 3]| Some([place(columns[0])?, place(columns[1])?, place(columns[2])?]);
        let whole: Vec<[usize; 3]> = READ_VECTORS.iter().filter_map(of_kind).collect();
        (3 * whole.len() == row.readings.len()).then_some(whole)
    };
    let places = rows.iter().map(vectors).collect::<Option<Vec<_>>>()?;
    let turned_by = |rotation: &UnitQuaternion<f64>| {
        let mut turned = rows.to_vec();
        for (row, places) in turned.iter_mut().zip(&places) {
            for place in places {
                let back = rotation.inverse() * Vector3::from(place.map(|i| row.readings[i].value));
                place.iter().zip(&back).for_each(|(&i, value)| row.readings[i].value = *value);
            }
        }
        turned
    };
    let (mut rotation, mut turned, mut fitted) = (UnitQuaternion::identity(), rows.to_vec(), None);
    for _ in 0..FITS {
        fitted = if step == 1 && fitted.is_none() { Some(fit.clone()) } else { from_file(search, &turned) };
        let own = fitted.as_ref()?;
        let (mut products, mut first) = (Matrix3::zeros(), 0);
        for (row, places) in rows.iter().zip(&places) {
            for place in places {
                let predicted = Vector3::from(place.map(|i| own.predicted.values[first + i]));
                let read = Vector3::from(place.map(|i| row.readings[i].value));
                products += predicted * read.transpose() / own.stds[first + place[0]].powi(2);
            }
            first += row.readings.len();
        }
        let next = rotation_of(&products);
        let change = rotation.angle_to(&next);
        (rotation, turned) = (next, turned_by(&next));
        if change < FOUND {
            break;
        }
    }
    Some((rotation.scaled_axis(), turned))
}

/// Returns the rotation that turns vectors a nearest to vectors b, from the sum of a·bᵀ (Horn 1987).
fn rotation_of(products: &Matrix3<f64>) -> UnitQuaternion<f64> {
    let s = products / products.amax().max(f64::MIN_POSITIVE);
    let [x, y, z] = [s[(1, 2)] - s[(2, 1)], s[(2, 0)] - s[(0, 2)], s[(0, 1)] - s[(1, 0)]];
    let mut form = Matrix4::zeros();
    form.fixed_view_mut::<3, 3>(1, 1).copy_from(&(s + s.transpose() - Matrix3::identity() * s.trace()));
    form[(0, 0)] = s.trace();
    for (k, value) in [x, y, z].into_iter().enumerate() {
        (form[(0, k + 1)], form[(k + 1, 0)]) = (value, value);
    }
    let eigen = SymmetricEigen::new(form);
    let q = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]))
}
