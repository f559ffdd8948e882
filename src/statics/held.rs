//! What a load step leaves in place of a chain's residual.

use super::chain_system::ChainSystem;
use crate::spatial::{Pose, Twist, rotation_exp};

/// Residual of a chain at the start of load stepping.
#[derive(Debug, Clone, Default)]
pub(super) struct Held {
    /// Rows θ, F, q; the rows F are held as a shift of the target instead.
    residual: Vec<f64>,
    /// Closure error: shift in O axes, and turn in platform axes.
    closure: Twist,
}

impl Held {
    /// Remembers the present residual of `system`, at the platform pose `platform`.
    pub fn remember(&mut self, system: &ChainSystem, platform: &Pose) {
        self.residual.clear();
        self.residual.extend((0..system.unknown_count()).map(|row| system.right_hand_side(row)));
        let Twist { linear, angular } = system.closure.into();
        self.closure = Twist { linear, angular: platform.rotation.transpose() * angular };
    }

    /// Where the chain's end belongs when `share` of the closure error is left in place.
    ///
    /// The shift is fixed to O and the turn to the platform, so that the target moves with the twist of the platform and
    /// the iteration stays a Newton iteration however large the turn is.
    pub fn target(&self, platform: &Pose, share: f64) -> Pose {
        Pose {
            rotation: platform.rotation * rotation_exp(self.closure.angular * share),
            translation: platform.translation + self.closure.linear * share,
        }
    }

    /// Takes `share` of the held generalised forces off the present ones.
    pub fn release(&self, system: &mut ChainSystem, share: f64) {
        let (wrench, unknowns) = (system.wrench_row(), system.unknown_count());
        for row in (0..wrench).chain(wrench + 6..unknowns) {
            system.release(row, share * self.residual[row]);
        }
    }
}
