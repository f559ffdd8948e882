//! A correction as a polynomial in the force on the tool tip.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::loaded::Loaded;
use crate::{input::error::Result, machine::Configuration};

/// Terms of the polynomial, F in N.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ForceTerms {
    /// 1: there is no force.
    Constant,
    /// 1, F_x, F_y, F_z.
    Linear,
    /// These and F_x², F_y², F_z², F_x F_y, F_x F_z, F_y F_z.
    Quadratic,
}

/// Axes of the mixed terms.
const MIXED: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

impl ForceTerms {
    /// Names of the terms, with the powers of N by which their coefficients are divided.
    pub fn names(self) -> &'static [(&'static str, u8)] {
        const ALL: [(&str, u8); 10] = [
            ("1", 0),
            ("Fx", 1),
            ("Fy", 1),
            ("Fz", 1),
            ("Fx_Fx", 2),
            ("Fy_Fy", 2),
            ("Fz_Fz", 2),
            ("Fx_Fy", 2),
            ("Fx_Fz", 2),
            ("Fy_Fz", 2),
        ];
        &ALL[..self.count()]
    }

    /// Number of terms.
    pub fn count(self) -> usize {
        match self {
            ForceTerms::Constant => 1,
            ForceTerms::Linear => 4,
            ForceTerms::Quadratic => 10,
        }
    }

    /// The terms at a force, N; zeros beyond [`ForceTerms::count`].
    pub fn values(self, f: Vector3<f64>) -> [f64; 10] {
        let mut values = [1.0, f.x, f.y, f.z, f.x * f.x, f.y * f.y, f.z * f.z, f.x * f.y, f.x * f.z, f.y * f.z];
        values[self.count()..].fill(0.0);
        values
    }

    /// Coefficients at a place, drive after drive, that give the exact correction without force, and for the other terms central
    /// differences over forces of the size `largest` N: what is odd in the force is met there, and so is, with quadratic terms, what is
    /// even, along each axis and in the middle between two.
    ///
    /// # Errors
    /// There is no correction under one of these forces.
    pub(super) fn at(self, loaded: &mut Loaded<'_>, at: &Configuration, largest: f64) -> Result<Vec<f64>> {
        let zero = loaded.exact(at, Vector3::zeros())?;
        let mut coefficients = vec![0.0; zero.len() * self.count()];
        let mut pair = |force: Vector3<f64>| {
            Ok::<_, crate::input::error::Error>([loaded.exact(at, force)?, loaded.exact(at, -force)?])
        };
        let (mut odd, mut even) = (Vec::new(), Vec::new());
        for axis in 0..if self == ForceTerms::Constant { 0 } else { 3 } {
            let [plus, minus] = pair(Vector3::ith(axis, largest))?;
            odd.push(plus.iter().zip(&minus).map(|(p, m)| (p - m) / (2.0 * largest)).collect::<Vec<f64>>());
            even.push(curvature(&zero, [&plus, &minus], largest));
        }
        let mut mixed = Vec::new();
        for [i, j] in if self == ForceTerms::Quadratic { &MIXED[..] } else { &[] } {
            let force = (Vector3::ith(*i, largest) + Vector3::ith(*j, largest)) / 2f64.sqrt();
            let [plus, minus] = pair(force)?;
            let along = curvature(&zero, [&plus, &minus], largest);
            mixed
                .push(along.iter().enumerate().map(|(d, c)| 2.0 * c - even[*i][d] - even[*j][d]).collect::<Vec<f64>>());
        }
        for (drive, own) in coefficients.chunks_mut(self.count()).enumerate() {
            let all = [odd.as_slice(), if self == ForceTerms::Quadratic { &even } else { &[] }, &mixed];
            let of_drive = all.into_iter().flatten().map(|term| term[drive]);
            own.iter_mut().zip(std::iter::once(zero[drive]).chain(of_drive)).for_each(|(c, value)| *c = value);
        }
        Ok(coefficients)
    }
}

/// Half the second derivative along a force of the size `largest` by its correction and that of its opposite.
fn curvature(zero: &[f64], [plus, minus]: [&[f64]; 2], largest: f64) -> Vec<f64> {
    let sums = plus.iter().zip(minus).map(|(p, m)| 0.5 * (p + m));
    sums.zip(zero).map(|(mean, own)| (mean - own) / (largest * largest)).collect()
}
