//! Whether a way that would be written passes where it should.

use nalgebra::Vector3;

use crate::toolpath::gcode::motion::Geometry;

/// A way that would be written, beside the programmed one.
pub(super) struct Check<'a> {
    /// The way as programmed.
    pub nominal: &'a Geometry,
    /// The way that would be written.
    pub candidate: &'a Geometry,
    /// How far off each coordinate may be, mm.
    pub tolerance: f64,
}

impl Check<'_> {
    /// Whether it passes the point with parameter and correction `here`, and goes there from the point `before` on
    /// the programmed way moved by the mean of the two corrections: an arc could pass both the other way round.
    pub fn passes(&self, before: (f64, Vector3<f64>), here: (f64, Vector3<f64>)) -> bool {
        let between = (f64::midpoint(before.0, here.0), (before.1 + here.1) / 2.0);
        self.at(here) && (matches!(self.candidate, Geometry::Line(..)) || self.at(between))
    }

    fn at(&self, (t, correction): (f64, Vector3<f64>)) -> bool {
        match (self.nominal.at(t), self.candidate.at(t)) {
            (Some((nominal, _)), Some((candidate, _))) => (candidate - nominal - correction).amax() <= self.tolerance,
            _ => false,
        }
    }
}
