//! Manufacturing and assembly errors of a chain as parameters: `x.turn`, `x.base.translation.y`, `x.rail.offset`.

use nalgebra::Vector3;

use super::Unit;
use crate::{
    machine::{Chain, ChainError, Drive},
    spatial::Twist,
};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Errors of one mounted chain, zero unless set; mm and degrees.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MountErrors {
    /// Rotation about the axis of the first drive.
    turn_deg: f64,
    base: FrameError,
    end: FrameError,
    /// Zero-point errors of the drives' joints, mm or degrees.
    offsets: Vec<f64>,
}

/// Displacement and rotation vector of a frame, in its own axes.
#[derive(Debug, Clone, Default, PartialEq)]
struct FrameError {
    translation_mm: [f64; 3],
    turn_deg: [f64; 3],
}

impl FrameError {
    /// The error as a twist in the frame's axes, mm and rad.
    fn twist(&self) -> Twist {
        let [linear, angular] = [self.translation_mm, self.turn_deg].map(Vector3::from);
        Twist { linear, angular: angular.map(f64::to_radians) }
    }
}

impl MountErrors {
    /// Errors of `chain`, all zero.
    pub fn none(chain: &Chain) -> Self {
        let (base, end) = (FrameError::default(), FrameError::default());
        Self { turn_deg: 0.0, base, end, offsets: vec![0.0; chain.drives.len()] }
    }

    /// Whether all errors are zero.
    pub fn is_none(&self, chain: &Chain) -> bool {
        *self == Self::none(chain)
    }

    /// Calls `each` with name, unit and value of every error of `chain`.
    pub fn walk(&mut self, chain: &Chain, each: &mut dyn FnMut(String, Unit, &mut f64)) {
        let Self { turn_deg, base, end, offsets } = self;
        if !chain.drives.is_empty() {
            each(format!("{}.turn", chain.name), Unit::DEG, turn_deg);
        }
        for (frame, FrameError { translation_mm, turn_deg }) in [("base", base), ("end", end)] {
            for (kind, unit, values) in [("translation", Unit::MM, translation_mm), ("turn", Unit::DEG, turn_deg)] {
                for (axis, value) in AXES.into_iter().zip(values) {
                    each(format!("{}.{frame}.{kind}.{axis}", chain.name), unit, value);
                }
            }
        }
        for (Drive { name, motion, .. }, offset) in chain.drives.iter().zip(offsets) {
            each(format!("{}.{name}.offset", chain.name), motion.choose(Unit::MM, Unit::DEG), offset);
        }
    }

    /// Converts the errors to mm and rad; rotations of the base are added as rotation vectors.
    pub fn chain_error(&self, chain: &Chain) -> ChainError {
        let about_drive = ChainError::turn_about_drive_axis(chain, self.turn_deg.to_radians());
        let base = self.base.twist();
        let has_offsets = self.offsets.iter().any(|&offset| offset != 0.0);
        let offsets = chain.drives.iter().zip(&self.offsets).filter(|_| has_offsets);
        ChainError {
            base: Twist { linear: base.linear, angular: about_drive.base.angular + base.angular },
            end: self.end.twist(),
            drive_offsets: offsets.map(|(drive, &offset)| drive.motion.from_shown(offset)).collect(),
        }
    }
}
