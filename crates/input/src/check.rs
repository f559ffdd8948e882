//! Checks of input values, each naming file, key, value and what was expected.

use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::{Matrix6, Vector3};

use crate::error::{Error, Result};

/// Version of the machine and study file formats.
pub const SCHEMA: u32 = 1;

/// No quantity of a machine is larger, in mm, N, rad and products of these; none that must be positive is smaller than
/// the inverse. Products of a few such numbers stay finite.
pub const LARGEST: f64 = 1e18;

/// No machine is longer, mm: a thousand kilometres. Beyond, positions have no decimals left and searches no end.
const LONGEST_MM: f64 = 1e9;

/// Longest part of a file name that a file may ask for: no system has less than 255 bytes for the whole name.
const LONGEST_IN_A_FILE_NAME: usize = 100;

/// Converts a name to a part of a file name: ASCII letters and digits, everything else as underscores.
pub fn file_stem(name: &str) -> String {
    let kept: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { ' ' }).collect();
    kept.split_whitespace().collect::<Vec<_>>().join("_")
}

/// The location of a value, its file and key path, with checks whose errors name it.
#[derive(Debug, Clone)]
pub struct Check {
    origin: String,
    path: String,
    /// The misfits found so far, if they are collected.
    misfits: Option<Arc<Mutex<Vec<Error>>>>,
}

impl Check {
    /// Creates the location at the top of the file (or command line) called `origin`.
    pub fn new(origin: &str) -> Self {
        Self { origin: origin.into(), path: String::new(), misfits: None }
    }

    /// Creates the location at the top of the file called `origin`; misfits there and below are collected for [`Check::with_misfits`].
    pub fn collecting(origin: &str) -> Self {
        Self { misfits: Some(Arc::default()), ..Self::new(origin) }
    }

    /// Returns the same location without collecting: misfits there and below are returned as errors.
    pub fn at_once(&self) -> Self {
        Self { misfits: None, ..self.clone() }
    }

    /// Returns the location at the top of the file called `origin`, whose misfits are collected with those of this one.
    pub fn other_file(&self, origin: &str) -> Self {
        Self { misfits: self.misfits.clone(), ..Self::new(origin) }
    }

    /// Returns the location of the key `key` below this one.
    pub fn key(&self, key: &str) -> Self {
        let path = if self.path.is_empty() { key.into() } else { format!("{}.{key}", self.path) };
        Self { path, ..self.clone() }
    }

    /// Returns the location of item `index` of the list here.
    pub fn item(&self, index: usize) -> Self {
        Self { path: format!("{}[{index}]", self.path), ..self.clone() }
    }

    /// Returns the location at the top of the same file.
    pub fn root(&self) -> Self {
        self.other_file(&self.origin)
    }

    /// Returns the name of the file in errors.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// Describes the location as `file: key`.
    pub fn location(&self) -> String {
        format!("{}: {}", self.origin, self.path)
    }

    /// Returns the error that the value here is wrong.
    pub fn fail<T>(&self, problem: String) -> Result<T> {
        Err(Error::Value { file: self.origin.clone(), line: None, key: self.path.clone(), problem })
    }

    /// Returns `instead` for a value that does not fit the machine, so that further misfits are found. Its error is kept for
    /// [`Check::with_misfits`], and returned where none are collected.
    pub fn misfit<T>(&self, problem: String, instead: T) -> Result<T> {
        self.or_misfit(self.fail(problem), instead)
    }

    /// Returns the value of `result`, or what [`Check::misfit`] does for its error.
    pub fn or_misfit<T>(&self, result: Result<T>, instead: T) -> Result<T> {
        match (result, &self.misfits) {
            (Err(error), Some(misfits)) => {
                misfits.lock().unwrap_or_else(PoisonError::into_inner).push(error);
                Ok(instead)
            }
            (result, _) => result,
        }
    }

    /// Returns `result` if no misfit was collected, or else one error with each misfit once and its line, which says that they do not fit
    /// `what`; `text` returns the text of a TOML file by its name in errors. An error of `result` is left out beside misfits, since values
    /// that stand for them may have caused it.
    pub fn with_misfits<'a, T>(
        &self,
        result: Result<T>,
        what: &str,
        text: impl Fn(&str) -> Option<&'a str>,
    ) -> Result<T> {
        let Some(misfits) = &self.misfits else { return result };
        let misfits = std::mem::take(&mut *misfits.lock().unwrap_or_else(PoisonError::into_inner));
        let mut errors: Vec<Error> = misfits.into_iter().map(|error| error.with_line(&text)).collect();
        let mut said = std::collections::HashSet::new();
        errors.retain(|error| said.insert(error.to_string()));
        match errors.len() {
            0 => result,
            1 => Err(errors.remove(0)),
            count => Err(Error::Several { problem: format!("{count} values do not fit {what}"), errors }),
        }
    }

    /// Returns the error that the file lacks `key` at its top.
    pub fn missing<T>(&self, key: &str) -> Result<T> {
        let (file, problem) = (self.origin.clone(), format!("missing key `{key}`"));
        Err(Error::Syntax { file, line: Some(1), key: String::new(), problem })
    }

    /// Checks that the version of the file format is [`SCHEMA`].
    pub fn schema(&self, version: u32) -> Result<()> {
        if version == SCHEMA {
            return Ok(());
        }
        self.key("schema").fail(format!("this program reads version {SCHEMA}, got {version}"))
    }

    /// Checks that a number's magnitude is at most [`LARGEST`].
    pub fn finite_scalar(&self, value: f64) -> Result<f64> {
        if value.abs() <= LARGEST {
            return Ok(value);
        }
        self.fail(format!("must be a number between {:e} and {LARGEST:e}, got {value:?}", -LARGEST))
    }

    /// Checks that a number is above zero, from 1/[`LARGEST`] to [`LARGEST`].
    pub fn positive(&self, value: f64) -> Result<f64> {
        if (1.0 / LARGEST..=LARGEST).contains(&value) {
            return Ok(value);
        }
        let sense =
            if value <= 0.0 { "greater than 0".into() } else { format!("between {:e} and {LARGEST:e}", 1.0 / LARGEST) };
        self.fail(format!("must be {sense}, got {value:?}"))
    }

    /// Checks that a number is from zero to [`LARGEST`].
    pub fn not_negative(&self, value: f64) -> Result<f64> {
        if (0.0..=LARGEST).contains(&value) {
            return Ok(value);
        }
        self.fail(format!("must be a number from 0 to {LARGEST:e}, got {value:?}"))
    }

    /// Checks that a number, if given, is [`positive`](Self::positive).
    pub fn optional_positive(&self, value: Option<f64>) -> Result<Option<f64>> {
        value.map(|v| self.positive(v)).transpose()
    }

    /// Returns how far something may be off to either side, mm, as `tolerance_mm` or half of `tolerance_zone_mm`, the width of a zone of ISO 1101 that is symmetric
    /// about where it should be.
    ///
    /// # Errors
    /// Both are given, or one is not positive.
    pub fn tolerance(&self, either_side: Option<f64>, zone: Option<f64>) -> Result<Option<f64>> {
        match (either_side, zone) {
            (Some(_), Some(_)) => self.key("tolerance_zone_mm").fail(
                "beside tolerance_mm: expected either how far it may be off to either side, or the width of the zone"
                    .into(),
            ),
            (Some(_), None) => self.key("tolerance_mm").optional_positive(either_side),
            (None, zone) => Ok(self.key("tolerance_zone_mm").optional_positive(zone)?.map(|width| 0.5 * width)),
        }
    }

    /// Checks that the magnitude of each component is at most [`LARGEST`].
    pub fn finite(&self, value: [f64; 3]) -> Result<Vector3<f64>> {
        self.components(value, LARGEST, "")
    }

    /// Checks that a position, mm, is one that a machine can have.
    pub fn position(&self, value: [f64; 3]) -> Result<Vector3<f64>> {
        self.components(value, LONGEST_MM, " mm")
    }

    fn components(&self, value: [f64; 3], largest: f64, unit: &str) -> Result<Vector3<f64>> {
        if value.iter().all(|v| v.abs() <= largest) {
            return Ok(value.into());
        }
        self.fail(format!("components must be numbers between {:e} and {largest:e}{unit}, got {value:?}", -largest))
    }

    /// Checks that a length, mm, is above zero and one that a machine can have.
    pub fn length(&self, value: f64) -> Result<f64> {
        match value > LONGEST_MM {
            true => self.fail(format!("must be at most {LONGEST_MM:e} mm, got {value:?}")),
            false => self.positive(value),
        }
    }

    /// Checks that a direction is not zero and returns it as a unit vector.
    pub fn direction(&self, value: [f64; 3]) -> Result<Vector3<f64>> {
        let v = self.finite(value)?;
        if v.norm() > 1e-12 { Ok(v.normalize()) } else { self.fail(format!("must not be zero, got {value:?}")) }
    }

    /// Checks an interval `[smallest, largest]`, if given, and returns both ends multiplied by `unit`, the size of their unit.
    pub fn interval(&self, value: Option<[f64; 2]>, unit: f64) -> Result<Option<(f64, f64)>> {
        match value {
            None => Ok(None),
            Some([low, high]) if -LARGEST <= low && low < high && high <= LARGEST => {
                Ok(Some((low * unit, high * unit)))
            }
            Some(pair) => self.fail(format!("must be [smallest, largest], got {pair:?}")),
        }
    }

    /// Checks that the corner `min` of a box does not exceed `max` along any axis.
    pub fn ordered_box(&self, min: Vector3<f64>, max: Vector3<f64>) -> Result<()> {
        match (0..3).find(|&i| min[i] > max[i]) {
            None => Ok(()),
            Some(i) => {
                let axis = ["x", "y", "z"][i];
                self.fail(format!("min_mm must not exceed max_mm, but along {axis} {} > {}", min[i], max[i]))
            }
        }
    }

    /// Checks the corners `min_mm` and `max_mm` of a box and returns them.
    pub fn corners(&self, min_mm: [f64; 3], max_mm: [f64; 3]) -> Result<[Vector3<f64>; 2]> {
        let corners = [self.key("min_mm").finite(min_mm)?, self.key("max_mm").finite(max_mm)?];
        self.ordered_box(corners[0], corners[1])?;
        Ok(corners)
    }

    /// Checks that a name has only ASCII letters, digits, `_` and `-`.
    pub fn identifier(&self, name: &str) -> Result<()> {
        let valid = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
        if valid { Ok(()) } else { self.fail(format!("must be letters, digits, _ or -, got \"{name}\"")) }
    }

    /// Checks that a name is not blank and has no control characters.
    pub fn readable(&self, name: &str) -> Result<()> {
        let valid = !name.trim().is_empty() && !name.chars().any(char::is_control);
        if valid { Ok(()) } else { self.fail(format!("must be a name on one line, got {name:?}")) }
    }

    /// Checks that a name is not among `others`.
    pub fn unique<'a>(&self, name: &str, mut others: impl Iterator<Item = &'a str>) -> Result<()> {
        if others.any(|other| other == name) {
            return self.fail(format!("\"{name}\" is used twice"));
        }
        Ok(())
    }

    /// Checks that a name, as [`file_stem`] writes it, is not too long for a part of a file name.
    pub fn short(&self, name: &str) -> Result<()> {
        let length = file_stem(name).len();
        if length <= LONGEST_IN_A_FILE_NAME {
            return Ok(());
        }
        let begin: String = name.chars().take(20).collect();
        self.fail(format!(
            "is part of file names: expected at most {LONGEST_IN_A_FILE_NAME} letters and digits, got {length} (\"{begin}…\")"
        ))
    }

    /// Checks that a name gives other file names than `others`, also where case does not count.
    pub fn unique_file<'a>(&self, name: &str, mut others: impl Iterator<Item = &'a str>) -> Result<()> {
        self.short(name)?;
        match others.find(|other| file_stem(other).eq_ignore_ascii_case(&file_stem(name))) {
            None => Ok(()),
            Some(other) => self.fail(format!(
                "\"{name}\" names the same files as \"{other}\": expected other letters or digits, of any case"
            )),
        }
    }

    /// Checks that a 6×6 matrix given by rows is symmetric and positive definite, and returns it.
    pub fn positive_definite(&self, rows: &[[f64; 6]; 6]) -> Result<Matrix6<f64>> {
        let matrix = Matrix6::from_fn(|i, j| rows[i][j]);
        for (i, row) in rows.iter().enumerate() {
            for (j, &entry) in row.iter().enumerate() {
                self.item(i).item(j).finite_scalar(entry)?;
            }
        }
        for i in 0..6 {
            for j in 0..i {
                let scale = (matrix[(i, i)] * matrix[(j, j)]).abs().sqrt();
                if (matrix[(i, j)] - matrix[(j, i)]).abs() > 1e-9 * scale {
                    let (below, above) = (matrix[(i, j)], matrix[(j, i)]);
                    return self
                        .fail(format!("must be symmetric, but [{i}][{j}] is {below} and [{j}][{i}] is {above}"));
                }
            }
        }
        let matrix = (matrix + matrix.transpose()) * 0.5;
        if matrix.cholesky().is_some() {
            return Ok(matrix);
        }
        let least = matrix.symmetric_eigenvalues().min();
        self.fail(format!("must be positive definite, but its smallest eigenvalue is {least:.3e}"))
    }
}
