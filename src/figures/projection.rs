//! Parallel projection of frame O onto the page.

use super::drawing::Point;

/// Parallel projection of frame O (mm) onto the page (pixels).
pub(super) struct Projection {
    /// Directions in O that point to the right and upward on the page.
    right: [f64; 3],
    up: [f64; 3],
    /// Direction in O that points away from the eye.
    away: [f64; 3],
    /// Pixels per mm.
    pub scale: f64,
    /// The origin of O on the page.
    pub origin: Point,
}

impl Projection {
    /// Returns the projection as seen from `azimuth` from +x and `elevation` from the xy plane, degrees, at one pixel per mm.
    pub fn new(azimuth: f64, elevation: f64) -> Self {
        let (az, el) = (azimuth.to_radians(), elevation.to_radians());
        Self {
            right: [-libm::sin(az), libm::cos(az), 0.0],
            up: [-libm::sin(el) * libm::cos(az), -libm::sin(el) * libm::sin(az), libm::cos(el)],
            away: [-libm::cos(el) * libm::cos(az), -libm::cos(el) * libm::sin(az), -libm::sin(el)],
            scale: 1.0,
            origin: [0.0, 0.0],
        }
    }

    /// Projects a point in O (mm) onto the page.
    pub fn project(&self, point: [f64; 3]) -> Point {
        let dot = |along: [f64; 3]| (0..3).map(|axis| along[axis] * point[axis]).sum::<f64>();
        [self.origin[0] + self.scale * dot(self.right), self.origin[1] - self.scale * dot(self.up)]
    }

    /// Returns how far a point in O (mm) is from the eye, from any constant.
    pub fn depth(&self, point: [f64; 3]) -> f64 {
        (0..3).map(|axis| self.away[axis] * point[axis]).sum()
    }

    /// Returns the ranges along x and y of the projections of `points`.
    pub fn ranges(&self, points: impl Iterator<Item = [f64; 3]>) -> [(f64, f64); 2] {
        let nothing = (f64::INFINITY, f64::NEG_INFINITY);
        points
            .map(|point| self.project(point))
            .fold([nothing; 2], |[x, y], at| [(x.0.min(at[0]), x.1.max(at[0])), (y.0.min(at[1]), y.1.max(at[1]))])
    }
}
