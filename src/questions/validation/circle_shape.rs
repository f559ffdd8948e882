//! Shape of a closed path in the xy-plane, to compare with a circle.

use nalgebra::{Matrix2, SymmetricEigen, Vector2};

/// Centre and principal axes of a closed path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// Mean of the points, mm.
    pub centre: Vector2<f64>,
    /// Unit vector along which the points are spread most.
    pub longest: Vector2<f64>,
    /// Unit vector along which the points are spread least.
    pub shortest: Vector2<f64>,
    /// Whether the spread is the same in all directions but for rounding, so that the axes mean nothing.
    pub is_round: bool,
}

/// Largest relative difference between the spreads of a round path.
const ROUND: f64 = 1e-9;

impl Shape {
    /// Computes the shape of points at equal steps, mm, of which the last repeats the first; `None` without points.
    pub fn of(points: &[Vector2<f64>]) -> Option<Self> {
        let revolution = points.get(..points.len().checked_sub(1)?).filter(|revolution| !revolution.is_empty())?;
        let centre = revolution.iter().sum::<Vector2<f64>>() / revolution.len() as f64;
        let spread: Matrix2<f64> = revolution.iter().map(|p| (p - centre) * (p - centre).transpose()).sum();
        let eigen = SymmetricEigen::new(spread);
        let major = usize::from(eigen.eigenvalues[1] > eigen.eigenvalues[0]);
        let axis = |i: usize| eigen.eigenvectors.column(i).into_owned();
        let [large, small] = [eigen.eigenvalues[major], eigen.eigenvalues[1 - major]];
        Some(Self { centre, longest: axis(major), shortest: axis(1 - major), is_round: large - small <= ROUND * large })
    }
}

/// Returns the angle between two axes, degrees from 0 to 90.
pub fn angle_deg(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    libm::atan2(a.perp(b).abs(), a.dot(b).abs()).to_degrees()
}

/// Returns how often a closed path crosses the circle of `radius` around `centre`, mm; the last point repeats the first.
pub fn crossings(points: &[Vector2<f64>], centre: &Vector2<f64>, radius: f64) -> usize {
    let is_outside = |p: &Vector2<f64>| (p - centre).norm() > radius;
    points.windows(2).filter(|pair| is_outside(&pair[0]) != is_outside(&pair[1])).count()
}
