//! What a load step leaves in place of a chain's residual.

use super::chain_system::ChainSystem;
use crate::{
    lanes::Screw,
    spatial::{Pose, Twist, rotation_exp},
};

/// Residual of a chain or loop at the start of load stepping.
#[derive(Debug, Clone, Default)]
pub(super) struct Held {
    /// Rows θ, F, q; the rows F are held as a shift of the target instead.
    residual: Vec<f64>,
    /// Closure error: shift in O axes (of a loop, in those of its first frame), and turn in the target's axes.
    closure: Twist,
    loops: Vec<Held>,
}

impl Held {
    /// Remembers the present residual of `system`, at the platform pose `platform`.
    pub fn remember(&mut self, system: &ChainSystem, platform: &Pose) {
        let Twist { linear, angular } = system.closure.into();
        *self = Self::of(system, Twist { linear, angular: platform.rotation.transpose() * angular });
    }

    fn of(system: &ChainSystem, closure: Twist) -> Self {
        let loops = system.loops().iter();
        let loops = loops.map(|inner| Self::of(&inner.system, inner.closure(system).into())).collect();
        Self { residual: system.own_right_hand_sides(), closure, loops }
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

    /// Has the loops of `system` end where `share` of their closure errors is left in place.
    pub fn shift_loops(&self, system: &mut ChainSystem, share: f64) {
        for (inner, held) in system.loops_mut().iter_mut().zip(&self.loops) {
            let Twist { linear, angular } = held.closure;
            inner.shift =
                (share > 0.0).then(|| Screw::from(Twist { linear: linear * share, angular: angular * share }));
            held.shift_loops(&mut inner.system, share);
        }
    }

    /// Takes `share` of the held generalised forces off the present ones.
    pub fn release(&self, system: &mut ChainSystem, share: f64) {
        system.release(&self.residual, share);
        for (inner, held) in system.loops_mut().iter_mut().zip(&self.loops) {
            held.release(&mut inner.system, share);
        }
    }
}
