//! Checks of input values, each naming file, key, value and what was expected.

use nalgebra::{Matrix6, Vector3};

use crate::error::{Error, Result};

/// Version of the machine and study file formats.
pub const SCHEMA: u32 = 1;

/// No quantity of a machine is larger, in mm, N, rad and products of these; none that must be positive is smaller than
/// the inverse. Products of a few such numbers stay finite.
pub const LARGEST: f64 = 1e18;

/// Longest part of a file name that a file may ask for: no system has less than 255 bytes for the whole name.
const LONGEST_IN_A_FILE_NAME: usize = 100;

/// A name as part of a file name: letters and digits, the rest as underscores.
pub fn file_stem(name: &str) -> String {
    let kept: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { ' ' }).collect();
    kept.split_whitespace().collect::<Vec<_>>().join("_")
}

/// The place of a value: a file and a key path in it.
#[derive(Debug, Clone)]
pub struct Check {
    origin: String,
    path: String,
}

impl Check {
    /// The top of the file (or command line) called `origin`.
    pub fn new(origin: &str) -> Self {
        Self { origin: origin.into(), path: String::new() }
    }

    /// The key `key` below this place.
    pub fn key(&self, key: &str) -> Self {
        let path = if self.path.is_empty() { key.into() } else { format!("{}.{key}", self.path) };
        Self { origin: self.origin.clone(), path }
    }

    /// Item `index` of the list at this place.
    pub fn item(&self, index: usize) -> Self {
        Self { origin: self.origin.clone(), path: format!("{}[{index}]", self.path) }
    }

    /// The top of the same file.
    pub fn root(&self) -> Self {
        Self::new(&self.origin)
    }

    /// File and key path in words.
    pub fn place(&self) -> String {
        format!("{}: {}", self.origin, self.path)
    }

    /// The error that this place holds a wrong value.
    pub fn fail<T>(&self, problem: String) -> Result<T> {
        Err(Error::Value { file: self.origin.clone(), key: self.path.clone(), problem })
    }

    /// The error that the file lacks `key` at its top.
    pub fn missing<T>(&self, key: &str) -> Result<T> {
        let (file, problem) = (self.origin.clone(), format!("missing key `{key}`"));
        Err(Error::Syntax { file, line: Some(1), key: String::new(), problem })
    }

    /// The file format version.
    pub fn schema(&self, version: u32) -> Result<()> {
        if version == SCHEMA {
            return Ok(());
        }
        self.key("schema").fail(format!("this program reads version {SCHEMA}, got {version}"))
    }

    /// A number of sensible size.
    pub fn finite_scalar(&self, value: f64) -> Result<f64> {
        if value.abs() <= LARGEST {
            return Ok(value);
        }
        self.fail(format!("must be a number between {:e} and {LARGEST:e}, got {value:?}", -LARGEST))
    }

    /// A number above zero, of sensible size.
    pub fn positive(&self, value: f64) -> Result<f64> {
        if (1.0 / LARGEST..=LARGEST).contains(&value) {
            return Ok(value);
        }
        let sense =
            if value <= 0.0 { "greater than 0".into() } else { format!("between {:e} and {LARGEST:e}", 1.0 / LARGEST) };
        self.fail(format!("must be {sense}, got {value:?}"))
    }

    /// A number of sensible size that is not below zero.
    pub fn not_negative(&self, value: f64) -> Result<f64> {
        if (0.0..=LARGEST).contains(&value) {
            return Ok(value);
        }
        self.fail(format!("must be a number from 0 to {LARGEST:e}, got {value:?}"))
    }

    /// A finite number above zero, if given.
    pub fn optional_positive(&self, value: Option<f64>) -> Result<Option<f64>> {
        value.map(|v| self.positive(v)).transpose()
    }

    /// Components of sensible size.
    pub fn finite(&self, value: [f64; 3]) -> Result<Vector3<f64>> {
        if value.iter().all(|v| v.abs() <= LARGEST) {
            return Ok(value.into());
        }
        self.fail(format!("components must be numbers between {:e} and {LARGEST:e}, got {value:?}", -LARGEST))
    }

    /// A direction, made a unit vector.
    pub fn direction(&self, value: [f64; 3]) -> Result<Vector3<f64>> {
        let v = self.finite(value)?;
        if v.norm() > 1e-12 { Ok(v.normalize()) } else { self.fail(format!("must not be zero, got {value:?}")) }
    }

    /// [smallest, largest], scaled by `unit`.
    pub fn interval(&self, value: Option<[f64; 2]>, unit: f64) -> Result<Option<(f64, f64)>> {
        match value {
            None => Ok(None),
            Some([low, high]) if -LARGEST <= low && low < high && high <= LARGEST => {
                Ok(Some((low * unit, high * unit)))
            }
            Some(pair) => self.fail(format!("must be [smallest, largest], got {pair:?}")),
        }
    }

    /// Corners of a box in the right order.
    pub fn ordered_box(&self, min: Vector3<f64>, max: Vector3<f64>) -> Result<()> {
        match (0..3).find(|&i| min[i] > max[i]) {
            None => Ok(()),
            Some(i) => {
                let axis = ["x", "y", "z"][i];
                self.fail(format!("min_mm must not exceed max_mm, but along {axis} {} > {}", min[i], max[i]))
            }
        }
    }

    /// The corners `min_mm` and `max_mm` of a box.
    pub fn corners(&self, min_mm: [f64; 3], max_mm: [f64; 3]) -> Result<[Vector3<f64>; 2]> {
        let corners = [self.key("min_mm").finite(min_mm)?, self.key("max_mm").finite(max_mm)?];
        self.ordered_box(corners[0], corners[1])?;
        Ok(corners)
    }

    /// A name of letters, digits, `_` and `-`.
    pub fn identifier(&self, name: &str) -> Result<()> {
        let valid = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
        if valid { Ok(()) } else { self.fail(format!("must be letters, digits, _ or -, got \"{name}\"")) }
    }

    /// A name that may hold any characters that can be read.
    pub fn readable(&self, name: &str) -> Result<()> {
        let valid = !name.trim().is_empty() && !name.chars().any(char::is_control);
        if valid { Ok(()) } else { self.fail(format!("must be a name on one line, got {name:?}")) }
    }

    /// A name not used before.
    pub fn unique<'a>(&self, name: &str, mut others: impl Iterator<Item = &'a str>) -> Result<()> {
        if others.any(|other| other == name) {
            return self.fail(format!("\"{name}\" is used twice"));
        }
        Ok(())
    }

    /// A name that is not too long for a part of a file name.
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

    /// A name that gives other files than those before, also where files are not told apart by case.
    pub fn unique_file<'a>(&self, name: &str, mut others: impl Iterator<Item = &'a str>) -> Result<()> {
        self.short(name)?;
        match others.find(|other| file_stem(other).eq_ignore_ascii_case(&file_stem(name))) {
            None => Ok(()),
            Some(other) => self.fail(format!(
                "\"{name}\" names the same files as \"{other}\": expected other letters or digits, of any case"
            )),
        }
    }

    /// A symmetric positive definite 6×6 matrix given by rows.
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
