//! Residual of a chain at the start of load stepping, of which each load step holds back a share.

use super::chain_system::ChainSystem;
use crate::{
    lanes::Screw,
    spatial::{Pose, Twist, rotation_exp},
};

/// Residual of a chain or loop at the start of load stepping.
#[derive(Debug, Clone, Default)]
pub(super) struct StartResidual {
    /// Right-hand sides of the rows θ, F, q; those of F are held back by shifting the target instead.
    residual: Vec<f64>,
    /// Closure error: shift in O axes (of a loop, in those of its first frame), and rotation in the target's axes.
    closure: Twist,
    loops: Vec<StartResidual>,
}

impl StartResidual {
    /// Records the present residual of `system`, the platform at `platform`.
    pub fn record(&mut self, system: &ChainSystem, platform: &Pose) {
        let Twist { linear, angular } = system.closure.into();
        *self = Self::from_system(system, Twist { linear, angular: platform.rotation.transpose() * angular });
    }

    /// Residual of `system` and its loops, `closure` being its closure error.
    fn from_system(system: &ChainSystem, closure: Twist) -> Self {
        let loops = system.loops().iter();
        let loops = loops.map(|inner| Self::from_system(&inner.system, inner.closure(system).into())).collect();
        Self { residual: system.route_right_hand_sides(), closure, loops }
    }

    /// Pose where the chain's end belongs, the platform at `platform`, if `share` of the closure error is left.
    /// The shift is fixed to O and the turn to the platform, so that the target moves with the twist of the platform and
    /// the iteration stays a Newton iteration however large the turn is.
    pub fn target(&self, platform: &Pose, share: f64) -> Pose {
        Pose {
            rotation: platform.rotation * rotation_exp(self.closure.angular * share),
            translation: platform.translation + self.closure.linear * share,
        }
    }

    /// Shifts the targets of the loops of `system` so that only `share` of their recorded closure errors remains.
    pub fn shift_loop_ends(&self, system: &mut ChainSystem, share: f64) {
        for (inner, held) in system.loops_mut().iter_mut().zip(&self.loops) {
            let Twist { linear, angular } = held.closure;
            inner.shift =
                (share > 0.0).then(|| Screw::from(Twist { linear: linear * share, angular: angular * share }));
            held.shift_loop_ends(&mut inner.system, share);
        }
    }

    /// Subtracts `share` of the recorded generalised forces from the right-hand sides of `system` and its loops.
    pub fn subtract_share(&self, system: &mut ChainSystem, share: f64) {
        system.subtract_share(&self.residual, share);
        for (inner, held) in system.loops_mut().iter_mut().zip(&self.loops) {
            held.subtract_share(&mut inner.system, share);
        }
    }
}
