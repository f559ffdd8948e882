//! The nominal machine led along a path from point to point, and where it would have to change its posture.

use crate::{
    compensation::{CompensationStatus, Demand},
    machine::{Configuration, Machine, SideBySide, Standing},
};

/// Where the nominal machine stands at a point of a path, if it reaches it, and why it cannot be led there, if it cannot.
#[derive(Debug, Clone)]
pub(super) struct LedPoint {
    pub at: Option<Configuration>,
    pub asked: Result<(), CompensationStatus>,
}

/// A piece of a path along which a machine is to be led.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch<'a> {
    /// The points before it, which decide in which posture it begins.
    pub passed: &'a [Demand],
    /// Its points.
    pub demands: &'a [Demand],
}

/// `nominal` led along each of `stretches`, as many of them at a time as the processor can. A stretch ends where `goes_on`, told its
/// number and its last point, says no.
pub(super) fn led_along(
    nominal: &Machine,
    stretches: &[Stretch<'_>],
    mut goes_on: impl FnMut(usize, &LedPoint) -> bool,
) -> Vec<Vec<LedPoint>> {
    let mut storage = SideBySide::new(nominal);
    let mut led: Vec<LedAlong> = stretches.iter().map(|_| LedAlong::new(nominal)).collect();
    if nominal.may_change_posture() {
        let passed: Vec<&[Demand]> = stretches.iter().map(|stretch| stretch.passed).collect();
        step_by_step(&mut led, &passed, &mut storage, |_, _| true);
        led.iter_mut().for_each(LedAlong::begin);
    }
    let demands: Vec<&[Demand]> = stretches.iter().map(|stretch| stretch.demands).collect();
    let mut points: Vec<Vec<LedPoint>> = demands.iter().map(|demands| Vec::with_capacity(demands.len())).collect();
    step_by_step(&mut led, &demands, &mut storage, |k, point| {
        let goes_on = goes_on(k, &point);
        points[k].push(point);
        goes_on
    });
    points
}

/// Leads each machine along its demands, all of them to their next points before any goes on. `take` gets each point with the number
/// of its machine, and says whether that goes on.
fn step_by_step(
    led: &mut [LedAlong],
    demands: &[&[Demand]],
    storage: &mut SideBySide,
    mut take: impl FnMut(usize, LedPoint) -> bool,
) {
    let mut going: Vec<usize> = (0..led.len()).collect();
    for point in 0.. {
        going.retain(|&k| point < demands[k].len());
        if going.is_empty() {
            break;
        }
        // With external axes each stands on a machine of its own.
        let plain: Vec<usize> = going.iter().copied().filter(|&k| demands[k][point].external.is_none()).collect();
        let asked: Vec<_> = plain.iter().map(|&k| (&led[k].near, demands[k][point].pose)).collect();
        let mut found = plain.iter().zip(storage.inverse_kinematics(&asked)).peekable();
        going.retain(|&k| {
            let straight = found.next_if(|(own, _)| **own == k).and_then(|(_, at)| at);
            let (at, asked) = led[k].step(&demands[k][point], straight);
            take(k, LedPoint { at, asked })
        });
    }
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
    /// A machine at home.
    fn new(nominal: &Machine) -> Self {
        Self { nominal: Standing::new(nominal), near: nominal.home.clone(), before: None }
    }

    /// Begins a stretch: what is commanded from here on does not depend on the way here.
    fn begin(&mut self) {
        self.near = self.nominal.as_it_came().home.clone();
    }

    /// The configuration at the next point, if it can be reached, and why the machine cannot be led there, if it cannot: also where it
    /// would stand in another posture than at the point before. `straight`: the configuration to which the straight line leads, where
    /// it was found before.
    fn step(
        &mut self,
        demand: &Demand,
        straight: Option<Configuration>,
    ) -> (Option<Configuration>, Result<(), CompensationStatus>) {
        if let Err(unreachable) = self.nominal.move_to(demand.external) {
            return (None, Err(CompensationStatus::Unreachable(unreachable)));
        }
        let is_from_before = self.before.as_ref() == Some(&self.near);
        let straight = match straight {
            Some(at) => Ok(at),
            None => self.nominal.inverse_kinematics_from(&self.near, &demand.pose),
        };
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
