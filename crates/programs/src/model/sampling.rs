//! How finely lines and arcs are split into path points.

use std::f64::consts::{FRAC_PI_2, PI};

use thiserror::Error;

/// How finely a path is split into points: chordal tolerance and longest piece, mm, and largest tool rotation along a piece, rad; checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    chordal_tolerance_mm: f64,
    max_segment_mm: f64,
    max_turn_rad: f64,
}

/// The error of a [`Sampling`] with a value that is not a finite number above 0.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("{key} = {value}: expected a finite number above 0")]
pub struct SamplingError {
    /// The key of the value, with its unit.
    pub key: &'static str,
    /// The value given.
    pub value: f64,
}

/// Most MiB of lines or statements that an expansion runs through in all.
pub(crate) const MAX_MIB: usize = 256;

impl Sampling {
    /// The most points one path may have. A path that needs more is refused instead of filling the memory.
    pub const MAX_POINTS: usize = 2_000_000;
    /// The most pieces that a move is split into.
    pub(crate) const MAX_PIECES: usize = 20_000_000;

    /// The most the tool turns along a piece unless said otherwise, rad: 2 degrees.
    pub const MAX_TURN_RAD: f64 = PI / 90.0;

    /// Returns the sampling for a path that was sampled before: pieces may be longer by `share`, and the tool may turn by any angle.
    #[cfg(not(target_family = "wasm"))]
    pub fn for_sampled_points(self, share: f64) -> Self {
        Self { max_segment_mm: self.max_segment_mm * (1.0 + share), max_turn_rad: PI, ..self }
    }

    /// Creates a sampling from the largest distance of an arc from the chord between two neighbouring points, and the
    /// longest piece, of lines and arcs alike, measured along the path, both mm. Fails when a value is not a finite number above 0.
    pub fn new(chordal_tolerance_mm: f64, max_segment_mm: f64) -> Result<Sampling, SamplingError> {
        for (key, value) in [("chordal_tolerance_mm", chordal_tolerance_mm), ("max_segment_mm", max_segment_mm)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(SamplingError { key, value });
            }
        }
        Ok(Sampling { chordal_tolerance_mm, max_segment_mm, max_turn_rad: Self::MAX_TURN_RAD })
    }

    /// Returns the same sampling in which the tool turns by at most `max_turn_rad` along a piece ([`Sampling::MAX_TURN_RAD`] by default).
    /// Fails when it is not a finite number above 0.
    pub fn with_max_turn(self, max_turn_rad: f64) -> Result<Sampling, SamplingError> {
        match max_turn_rad.is_finite() && max_turn_rad > 0.0 {
            true => Ok(Sampling { max_turn_rad, ..self }),
            false => Err(SamplingError { key: "max_turn_rad", value: max_turn_rad }),
        }
    }

    /// Returns the largest distance of an arc from its chord, mm.
    #[must_use]
    pub fn chordal_tolerance_mm(self) -> f64 {
        self.chordal_tolerance_mm
    }

    /// Returns the longest piece, mm.
    #[must_use]
    pub fn max_segment_mm(self) -> f64 {
        self.max_segment_mm
    }

    /// Returns the largest rotation of the tool along a piece, rad.
    #[must_use]
    pub fn max_turn_rad(self) -> f64 {
        self.max_turn_rad
    }

    /// Returns into how many pieces a line of `length_mm` is split; `None` for more than 20 million.
    pub fn line_pieces(self, length_mm: f64) -> Option<usize> {
        // The slack keeps a length that is a multiple of the piece from gaining one by rounding.
        pieces((length_mm / self.max_segment_mm) * (1.0 - 1e-12))
    }

    /// Returns into how many pieces a line of `length_mm` is split along which the tool turns by `turn_rad`; `None` for more than 20 million.
    pub(crate) fn turning_pieces(self, length_mm: f64, turn_rad: f64) -> Option<usize> {
        let by_turn = pieces((turn_rad / self.max_turn_rad) * (1.0 - 1e-12))?;
        Some(by_turn.max(self.line_pieces(length_mm)?))
    }

    /// Returns into how many pieces an arc of `length_mm`, radius `radius_mm` and angle `sweep_rad` is split; `None` for more than 20 million.
    ///
    /// The chord over the angle Δ stands r (1 − cos(Δ/2)) = 2 r sin²(Δ/4) off the arc, so Δ = 4 asin √(tol / 2r).
    /// A piece never turns by more than a right angle, whatever the tolerance.
    pub fn arc_pieces(self, radius_mm: f64, sweep_rad: f64, length_mm: f64) -> Option<usize> {
        let half_chord = (self.chordal_tolerance_mm / (2.0 * radius_mm)).min(1.0).sqrt();
        let step_rad = (4.0 * libm::asin(half_chord)).min(FRAC_PI_2);
        let by_angle = pieces((sweep_rad.abs() / step_rad) * (1.0 - 1e-12))?;
        let by_length = self.line_pieces(length_mm)?;
        Some(by_angle.max(by_length))
    }
}

/// Returns the number of pieces for `ratio`, length over longest piece: rounded up, at least 1; `None` above [`Sampling::MAX_PIECES`].
fn pieces(ratio: f64) -> Option<usize> {
    let count = ratio.ceil().max(1.0);
    (ratio.is_finite() && count <= Sampling::MAX_PIECES as f64).then_some(count as usize)
}

impl Default for Sampling {
    /// 1 µm off the arc, pieces of at most 1 mm along which the tool turns by at most 2 degrees.
    fn default() -> Sampling {
        Sampling { chordal_tolerance_mm: 1e-3, max_segment_mm: 1.0, max_turn_rad: Sampling::MAX_TURN_RAD }
    }
}
