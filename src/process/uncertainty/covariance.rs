//! The covariance of identified parameters, as an identification writes it: a row for each pair.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use super::{Distribution, resolve::LARGEST_RELATIVE_STD};
use crate::input::{
    csv_rows::{self, line_number},
    error::{Error, Result},
};

/// Columns of the file, in the order in which identifications write them.
pub const COVARIANCE_COLUMNS: [&str; 5] = ["parameter", "other", "distribution", "value", "covariance"];
/// Words of the column `distribution`: the covariance is of the logarithm of the value, or of the value in its unit.
pub const DISTRIBUTIONS: [&str; 2] = ["lognormal", "normal"];

/// Name of the row whose value is the share of the measured displacements that the identified model leaves.
pub const MODEL: &str = "model";

/// Parameters with their covariance.
#[derive(Debug)]
pub(super) struct Covariance {
    /// Parameters that were identified.
    pub parameters: Vec<CovarianceParameter>,
    /// Names of those that the measurements left open.
    pub open: Vec<String>,
    /// Share of the measured displacements that the identified model leaves; `None` where the measurements do not say it.
    pub model: Option<f64>,
    matrix: DMatrix<f64>,
}

/// An identified parameter.
#[derive(Debug)]
pub(super) struct CovarianceParameter {
    /// Its name in the machine.
    pub name: String,
    /// Its value, in its unit.
    pub value: f64,
    /// Whether its logarithm is normally distributed, and not its value.
    pub is_lognormal: bool,
}

/// Largest negative eigenvalue of a covariance of rounded numbers, as a share of the largest.
const ROUNDING: f64 = 1e-9;

impl Covariance {
    /// Reads a covariance from the bytes of the file called `origin`.
    ///
    /// # Errors
    /// Missing columns, cells that are no numbers, pairs that are missing or given twice, a matrix that is no covariance.
    pub fn read(source: &[u8], origin: &str) -> Result<Self> {
        let at = |line: Option<usize>, key: &str, problem: String| Error::Syntax {
            file: origin.into(),
            line,
            key: key.into(),
            problem,
        };
        let rows = csv_rows::read(source).map_err(|(byte, reason)| at(Some(line_number(source, byte)), "", reason))?;
        let Some((header, rows)) = rows.split_first() else {
            return Err(at(Some(1), "", format!("is empty: expected the columns {}", COVARIANCE_COLUMNS.join(", "))));
        };
        let place = |name: &str| {
            let found = header.fields.iter().position(|own| own == name.as_bytes());
            found.ok_or_else(|| {
                at(Some(1), name, "missing column: expected the file that an identification writes".into())
            })
        };
        let [parameter, other, distribution, value, covariance] = COVARIANCE_COLUMNS.map(place);
        let columns = [parameter?, other?, distribution?, value?, covariance?];
        let (mut parameters, mut open, mut pairs) = (Vec::<CovarianceParameter>::new(), Vec::new(), Vec::new());
        // Of each name its index, or none where the measurements left it open.
        let mut known = BTreeMap::<String, Option<usize>>::new();
        let mut model = None;
        for row in rows {
            let line = Some(row.line);
            let cells =
                columns.map(|column| String::from_utf8_lossy(row.fields.get(column).unwrap_or_default()).into_owned());
            let [name, other, distribution, value, covariance] = cells;
            let number = |cell: &str, key: &str| match cell.parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(number),
                _ => Err(at(line, key, format!("expected a number, got \"{cell}\""))),
            };
            if name == MODEL {
                let share = number(&value, "value")?;
                if model.is_some() || !(0.0..=LARGEST_RELATIVE_STD).contains(&share) {
                    let problem =
                        format!("expected one row {MODEL} with a value from 0 to {LARGEST_RELATIVE_STD}, got {share}");
                    return Err(at(line, "value", problem));
                }
                model = Some(share);
                continue;
            }
            if name == other && known.contains_key(&name) {
                return Err(at(line, "parameter", format!("{name} is given twice")));
            }
            if name == other && covariance.is_empty() {
                known.insert(name.clone(), None);
                open.push(name);
                continue;
            }
            if name == other {
                let Some(kind) = DISTRIBUTIONS.iter().position(|word| *word == distribution) else {
                    let expected = DISTRIBUTIONS.join(" or ");
                    return Err(at(line, "distribution", format!("expected {expected}, got \"{distribution}\"")));
                };
                let value = number(&value, "value")?;
                known.insert(name.clone(), Some(parameters.len()));
                parameters.push(CovarianceParameter { name: name.clone(), value, is_lognormal: kind == 0 });
            }
            pairs.push((line, name, other, number(&covariance, "covariance")?));
        }
        let count = parameters.len();
        let mut matrix = DMatrix::from_element(count, count, f64::NAN);
        for (line, name, other, covariance) in pairs {
            let index = |name: &str, key: &str| {
                let found = known.get(name).copied().flatten();
                found.ok_or_else(|| at(line, key, format!("{name} has no row with itself")))
            };
            let (a, b) = (index(&name, "parameter")?, index(&other, "other")?);
            if !matrix[(a, b)].is_nan() {
                return Err(at(line, "other", format!("{name} and {other} are given twice")));
            }
            (matrix[(a, b)], matrix[(b, a)]) = (covariance, covariance);
        }
        let found = Self { parameters, open, model, matrix };
        found.check(|problem| at(None, "", problem))?;
        Ok(found)
    }

    /// Refuses a matrix that lacks pairs or is no covariance.
    fn check(&self, fault: impl Fn(String) -> Error) -> Result<()> {
        let (parameters, matrix, count) = (&self.parameters, &self.matrix, self.parameters.len());
        for a in 0..count {
            if let Some(b) = (0..count).find(|b| matrix[(a, *b)].is_nan()) {
                let (name, other) = (&parameters[a].name, &parameters[b].name);
                return Err(fault(format!("lacks a row of {name} and {other}")));
            }
        }
        for (a, b) in (0..count).flat_map(|a| (0..count).map(move |b| (a, b))) {
            if matrix[(a, a)] == 0.0 && matrix[(a, b)] != 0.0 {
                let (name, other) = (&parameters[a].name, &parameters[b].name);
                return Err(fault(format!("{name} does not vary, and has a covariance with {other}")));
            }
        }
        if let Some(variance) = (0..count).find(|own| matrix[(*own, *own)] < 0.0) {
            let (name, variance) = (&parameters[variance].name, matrix[(variance, variance)]);
            return Err(fault(format!("the variance of {name} is {variance}: expected none below 0")));
        }
        if count == 0 {
            return Ok(());
        }
        let eigenvalues = self.correlation(&(0..count).collect::<Vec<_>>()).symmetric_eigenvalues();
        match eigenvalues.iter().copied().reduce(f64::min) {
            Some(least) if least < -ROUNDING * eigenvalues.amax() => {
                Err(fault(format!("is no covariance: its matrix of correlations has the eigenvalue {least:.3e}")))
            }
            _ => Ok(()),
        }
    }

    /// Correlations of the parameters with these indices; 0 of those that do not vary.
    fn correlation(&self, of: &[usize]) -> DMatrix<f64> {
        let scale = |own: usize| if self.matrix[(own, own)] > 0.0 { 1.0 / self.matrix[(own, own)].sqrt() } else { 0.0 };
        DMatrix::from_fn(of.len(), of.len(), |a, b| scale(of[a]) * self.matrix[(of[a], of[b])] * scale(of[b]))
    }

    /// Distribution of the parameter with index `own` alone.
    pub fn spread(&self, own: usize) -> Distribution {
        let std = self.matrix[(own, own)].sqrt();
        match self.parameters[own].is_lognormal {
            true => Distribution::Logarithm { below: std, above: std },
            false => Distribution::Difference { below: std, above: std },
        }
    }

    /// Factor whose product with independent standard normal numbers has the correlations of the parameters with these indices; each of the products
    /// is a standard normal number, or 0 for one that does not vary. Directions that do not vary are none.
    pub fn correlation_factor(&self, of: &[usize]) -> DMatrix<f64> {
        if of.is_empty() {
            return DMatrix::zeros(0, 0);
        }
        let eigen = self.correlation(of).symmetric_eigen();
        let mut factor = eigen.eigenvectors;
        for (mut column, value) in factor.column_iter_mut().zip(&eigen.eigenvalues) {
            column *= value.max(0.0).sqrt();
        }
        factor
    }
}
