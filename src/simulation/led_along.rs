//! The nominal machine led along a path from point to point, and where it would have to change its posture.

use crate::{
    compensation::{CompensationStatus, Demand},
    machine::{Configuration, Machine, SideBySide, Standing},
};

/// Where the nominal machine stands at a point of a path, if it reaches it, and why it cannot be led there, if it cannot.
#[derive(Debug, Clone)]
pub(crate) struct LedPoint {
    pub at: Option<Configuration>,
    pub asked: Result<(), CompensationStatus>,
}

impl LedPoint {
    /// Where the machine stands, if it can be there at all.
    fn stands(&self) -> Option<&Configuration> {
        self.at.as_ref().filter(|_| !matches!(self.asked, Err(CompensationStatus::Unreachable(_))))
    }
}

/// `nominal` led along each of `stretches`, as many of them at a time as the processor can, each from home, so that none waits for another;
/// [`join`] puts them behind one another. A stretch ends where `goes_on`, told its number and its points so far, says no.
pub(crate) fn led_along(
    nominal: &Machine,
    stretches: &[&[Demand]],
    goes_on: impl Fn(usize, &[LedPoint]) -> bool,
) -> Vec<Vec<LedPoint>> {
    let mut storage = SideBySide::new(nominal);
    let mut led: Vec<LedAlong> = stretches.iter().map(|_| LedAlong::new(nominal)).collect();
    let mut points: Vec<Vec<LedPoint>> = stretches.iter().map(|demands| Vec::with_capacity(demands.len())).collect();
    step_by_step(&mut led, stretches, &mut storage, |k, point| {
        points[k].push(point);
        goes_on(k, &points[k])
    });
    points
}

/// Puts stretches of a path that follow one another, each led from home, behind the point at which the machine stands as in `before`: it
/// goes on there, hinges at the turn that they have reached.
pub(crate) fn join<'a>(
    nominal: &Machine,
    before: Option<&Configuration>,
    stretches: impl Iterator<Item = (&'a [Demand], &'a mut Vec<LedPoint>)>,
) {
    if nominal.may_change_posture() {
        let mut led = LedAlong::new(nominal);
        led.before = before.cloned();
        stretches.for_each(|(demands, points)| led.go_on_with(demands, points));
    }
}

/// Where the machine stands at the last of `led` to which it can be led.
pub(crate) fn last_of(led: &[LedPoint]) -> Option<&Configuration> {
    led.iter().rev().find_map(LedPoint::stands)
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

    /// Puts `points` of `demands`, which were led from home, behind the point before; gives its place to the last of them.
    fn go_on_with(&mut self, demands: &[Demand], points: &mut Vec<LedPoint>) {
        if let (Some(before), Some(first)) =
            (self.before.clone(), points.iter().position(|point| point.stands().is_some()))
        {
            self.go_on_behind(&before, demands, points, first);
        }
        if let Some(last) = last_of(points) {
            self.before = Some(last.clone());
        }
    }

    /// As `go_on_with`, where `first` of the points is the first to which the machine can be led, and the one before is known.
    fn go_on_behind(&mut self, before: &Configuration, demands: &[Demand], points: &mut Vec<LedPoint>, first: usize) {
        let demand = &demands[first];
        let there = match self.nominal.move_to(demand.external) {
            Ok(_) => self.nominal.inverse_kinematics_from(before, &demand.pose).ok(),
            Err(_) => None,
        };
        let Some(from_home) = points[first].at.as_ref() else { return };
        let turns = self.nominal.turns_towards(&from_home.drives, &there.as_ref().unwrap_or(before).drives);
        let is_turned = turns.iter().all(|turn| *turn == 0.0) || turn(&self.nominal, points, &turns);
        if let (true, Some(at)) = (is_turned, points[first].at.clone())
            && there.as_ref().is_none_or(|there| self.nominal.is_beside(there, &at))
        {
            points[first].asked = self.keep_posture(&at, there.is_some(), demand);
            return;
        }
        // From where the machine stands or, where no straight way leads on, from home at the same turn.
        self.near = match there {
            Some(_) => before.clone(),
            None => with_turns(self.nominal.as_it_came().home.clone(), &turns),
        };
        for (demand, point) in demands.iter().zip(points) {
            let (at, asked) = self.step(demand, None);
            *point = LedPoint { at, asked };
        }
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

/// Takes the hinges of `points` as many `turns` (mm or rad) farther, if the machine can be led so to all of them; whether it can.
fn turn(machine: &Machine, points: &mut Vec<LedPoint>, turns: &[f64]) -> bool {
    let turned = |point: &LedPoint| {
        let at = with_turns(point.at.clone()?, turns);
        let is_led = point.asked.is_ok() && machine.drive_beyond_travel(&at.drives).is_none();
        is_led.then_some(LedPoint { at: Some(at), asked: Ok(()) })
    };
    let all: Option<Vec<LedPoint>> = points.iter().map(turned).collect();
    let is_turned = all.is_some();
    *points = all.unwrap_or_else(|| std::mem::take(points));
    is_turned
}

fn with_turns(mut at: Configuration, turns: &[f64]) -> Configuration {
    at.drives.iter_mut().zip(turns).for_each(|(drive, turn)| *drive += turn);
    at
}
