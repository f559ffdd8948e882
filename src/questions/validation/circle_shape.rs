//! The shape of a closed path in the xy-plane, against the circle it should be.

use nalgebra::{Matrix2, SymmetricEigen, Vector2};

/// Middle and principal axes of a closed path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shape {
    /// Mean of the points, mm.
    pub middle: Vector2<f64>,
    /// Direction in which the points are spread most.
    pub longest: Vector2<f64>,
    /// Direction in which they are spread least.
    pub shortest: Vector2<f64>,
    /// Whether the spread is the same in all directions, but for rounding: the axes mean nothing.
    pub is_round: bool,
}

/// Spreads are the same if they differ by less than this share.
const ROUND: f64 = 1e-9;

impl Shape {
    /// Of points at equal steps; the last one repeats the first. `None` without points.
    pub fn of(points: &[Vector2<f64>]) -> Option<Self> {
        let turn = points.get(..points.len().checked_sub(1)?).filter(|turn| !turn.is_empty())?;
        let middle = turn.iter().sum::<Vector2<f64>>() / turn.len() as f64;
        let spread: Matrix2<f64> = turn.iter().map(|p| (p - middle) * (p - middle).transpose()).sum();
        let eigen = SymmetricEigen::new(spread);
        let most = usize::from(eigen.eigenvalues[1] > eigen.eigenvalues[0]);
        let axis = |i: usize| eigen.eigenvectors.column(i).into_owned();
        let [large, small] = [eigen.eigenvalues[most], eigen.eigenvalues[1 - most]];
        Some(Self { middle, longest: axis(most), shortest: axis(1 - most), is_round: large - small <= ROUND * large })
    }
}

/// Angle between two axes, degrees from 0 to 90.
pub(super) fn angle_deg(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    a.perp(b).abs().atan2(a.dot(b).abs()).to_degrees()
}

/// How often a closed path crosses the circle around `centre`; the last point repeats the first.
pub(super) fn crossings(points: &[Vector2<f64>], centre: &Vector2<f64>, radius: f64) -> usize {
    let is_outside = |p: &Vector2<f64>| (p - centre).norm() > radius;
    points.windows(2).filter(|pair| is_outside(&pair[0]) != is_outside(&pair[1])).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ellipse(a: f64, b: f64, turn: f64, middle: [f64; 2]) -> Vec<Vector2<f64>> {
        let (sin, cos) = turn.sin_cos();
        let at = |k: usize| {
            let (s, c) = (std::f64::consts::TAU * k as f64 / 72.0).sin_cos();
            Vector2::new(cos * a * c - sin * b * s, sin * a * c + cos * b * s) + Vector2::from(middle)
        };
        (0..=72).map(at).collect()
    }

    #[test]
    fn the_axes_of_an_ellipse_are_found() {
        let shape = Shape::of(&ellipse(3.0, 1.0, 0.4, [5.0, -2.0])).unwrap();
        assert!((shape.middle - Vector2::new(5.0, -2.0)).norm() < 1e-12);
        assert!(angle_deg(&shape.longest, &Vector2::new(0.4f64.cos(), 0.4f64.sin())) < 1e-9);
        assert!((angle_deg(&shape.longest, &shape.shortest) - 90.0).abs() < 1e-9);
        assert!(!shape.is_round && Shape::of(&ellipse(2.0, 2.0, 0.4, [5.0, -2.0])).unwrap().is_round);
        assert!(Shape::of(&[]).is_none());
    }

    #[test]
    fn crossings_of_an_ellipse_and_a_circle() {
        let path = ellipse(3.0, 1.0, 0.4, [0.0, 0.0]);
        assert_eq!(crossings(&path, &Vector2::zeros(), 2.0), 4);
        assert_eq!(crossings(&path, &Vector2::zeros(), 4.0), 0);
    }
}
