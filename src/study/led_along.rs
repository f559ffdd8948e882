//! The nominal machine led along a path from point to point, and where it would have to change its posture.

use crate::{
    compensation::{CompensationStatus, Demand},
    machine::{Configuration, Machine, Standing},
};

/// Where the nominal machine stands at a point of a path, if it reaches it, and why it cannot be led there, if it cannot.
#[derive(Debug, Clone)]
pub(super) struct LedPoint {
    pub at: Option<Configuration>,
    pub asked: Result<(), CompensationStatus>,
}

/// `nominal` led along `demands`, its way along the points `passed` behind it: point after point as they are asked for.
pub(super) fn led_along<'a>(
    nominal: &Machine,
    passed: &[Demand],
    demands: &'a [Demand],
) -> impl Iterator<Item = LedPoint> + use<'a> {
    let mut led = LedAlong::after(nominal, passed);
    demands.iter().map(move |demand| {
        let (at, asked) = led.step(demand);
        LedPoint { at, asked }
    })
}

/// A machine on its way along a path.
struct LedAlong {
    nominal: Standing,
    /// From where the next point is sought.
    near: Configuration,
    /// Where the machine stands at the point before: `near`, but at the beginning. `None` there, and of machines that have one posture.
    before: Option<Configuration>,
}

impl LedAlong {
    /// A machine at home, its way along the points `passed` behind it. What it commands from here on is what it would without them.
    pub fn after(nominal: &Machine, passed: &[Demand]) -> Self {
        let mut led = Self { nominal: Standing::new(nominal), near: nominal.home.clone(), before: None };
        if nominal.may_change_posture() {
            for demand in passed {
                let _ = led.step(demand);
            }
            led.near = nominal.home.clone();
        }
        led
    }

    /// The configuration at the next point, if it can be reached, and why the machine cannot be led there, if it cannot: also where it
    /// would stand in another posture than at the point before.
    pub fn step(&mut self, demand: &Demand) -> (Option<Configuration>, Result<(), CompensationStatus>) {
        if let Err(unreachable) = self.nominal.move_to(demand.external) {
            return (None, Err(CompensationStatus::Unreachable(unreachable)));
        }
        let is_from_before = self.before.as_ref() == Some(&self.near);
        let straight = self.nominal.inverse_kinematics_from(&self.near, &demand.pose);
        let is_led = straight.is_ok();
        let at = match straight.or_else(|_| self.nominal.inverse_kinematics(&demand.pose)) {
            Ok(at) => at,
            Err(unreachable) => return (None, Err(CompensationStatus::Unreachable(unreachable))),
        };
        self.near.clone_from(&at);
        let kept = match self.nominal.check_led(&demand.pose, &at) {
            Ok(()) if self.nominal.may_change_posture() => self.keep_posture(&at, is_led && is_from_before, demand),
            Ok(()) => Ok(()),
            Err(unreachable) => Err(CompensationStatus::Unreachable(unreachable)),
        };
        (Some(at), kept)
    }

    /// Whether the machine at `at`, which meets `demand`, stands in the posture of the point before. `is_led`: whether the straight line
    /// is known to lead from there.
    fn keep_posture(&mut self, at: &Configuration, is_led: bool, demand: &Demand) -> Result<(), CompensationStatus> {
        let Some(before) = self.before.replace(at.clone()) else { return Ok(()) };
        let is_led = is_led || self.nominal.inverse_kinematics_from(&before, &demand.pose).is_ok();
        match self.nominal.posture_change(&before, at, is_led) {
            None => Ok(()),
            Some(change) => {
                let (before_mm, here_mm) = (before.pose.translation, at.pose.translation);
                Err(CompensationStatus::ChangesPosture { change, before_mm, here_mm })
            }
        }
    }
}
