//! Whether a way that would be written passes where it should, and where on it each point lies.

use nalgebra::Vector3;

use crate::toolpath::model::{PathPoint, Way, gcode::Angles};

/// A written arc may turn by as much more or less than the programmed one, rad.
const TURN_RAD: f64 = 0.5;

/// Points of a programmed block that follow one another, and where they should be.
#[derive(Clone, Copy)]
pub(crate) struct Stretch<'a> {
    /// The block as programmed.
    pub nominal: &'a Way,
    /// Parameter and correction, mm, of where it begins.
    pub before: (f64, Vector3<f64>),
    pub points: &'a [PathPoint],
    pub corrected: &'a [Vector3<f64>],
    /// Where rotary axes should stand at the points, if they turn or are corrected.
    pub angles: Option<&'a [Angles]>,
}

/// How far off a written way may be, mm.
#[derive(Clone, Copy)]
pub(crate) struct Allowed {
    /// Each coordinate of a point that lies as far along the written way as along the programmed one.
    pub unit_mm: f64,
    /// The way from a point.
    pub tolerance_mm: f64,
}

/// A position that should be passed.
pub(crate) struct Goal {
    /// How far along the stretch, from 0 to 1.
    share: f64,
    pub position: Vector3<f64>,
    /// Whether it is a point of the path, not the middle between two of them.
    is_point: bool,
}

impl<'a> Stretch<'a> {
    /// Its first `count` points.
    pub fn first(self, count: usize) -> Stretch<'a> {
        let angles = self.angles.map(|angles| &angles[..count]);
        Stretch { points: &self.points[..count], corrected: &self.corrected[..count], angles, ..self }
    }

    /// What is left of it behind its first `count` points.
    pub fn behind(self, count: usize) -> Stretch<'a> {
        let before = self.correction(count.checked_sub(1));
        let angles = self.angles.map(|angles| &angles[count..]);
        Stretch { before, points: &self.points[count..], corrected: &self.corrected[count..], angles, ..self }
    }

    fn correction(&self, k: Option<usize>) -> (f64, Vector3<f64>) {
        let of =
            |(point, corrected): (&PathPoint, &Vector3<f64>)| (point.source.parameter, corrected - point.position_mm);
        k.and_then(|k| self.points.get(k).zip(self.corrected.get(k))).map_or(self.before, of)
    }

    /// Its points as they should be, and before each the middle of the way to it, moved by the mean of the two corrections: an
    /// arc could pass both the other way round.
    pub fn goals(self) -> impl Iterator<Item = Goal> + use<'a> {
        let begin = self.before.0;
        let length = self.correction(self.points.len().checked_sub(1)).0 - begin;
        let share = move |t: f64| if length > 0.0 { (t - begin) / length } else { 1.0 };
        (0..self.points.len()).flat_map(move |k| {
            let (from, to) = (self.correction(k.checked_sub(1)), self.correction(Some(k)));
            let middle = f64::midpoint(from.0, to.0);
            let between = self.nominal.at(middle).map(|(position, _)| Goal {
                share: share(middle),
                position: position + (from.1 + to.1) / 2.0,
                is_point: false,
            });
            let point = Goal { share: share(to.0), position: self.corrected[k], is_point: true };
            between.into_iter().chain([point])
        })
    }

    /// Whether an arc turns about as much as programmed: near its ends, points do not tell a full turn from none.
    fn turns_as(&self, candidate: &Way) -> bool {
        let (Way::Arc(nominal), Way::Arc(candidate)) = (self.nominal, candidate) else { return true };
        let share = self.correction(self.points.len().checked_sub(1)).0 - self.before.0;
        (candidate.sweep_rad() - nominal.sweep_rad() * share).abs() < TURN_RAD
    }

    /// Whether axes that turn evenly between these angles stand as they should at the points, which lie at `places`, to `allowed` degrees.
    pub fn is_turned(&self, places: &[f64], [from, to]: [&Angles; 2], allowed: f64) -> bool {
        let stands = |(place, wanted): (&f64, &Angles)| {
            (0..3).all(|axis| (from[axis] + (to[axis] - from[axis]) * place - wanted[axis]).abs() <= allowed)
        };
        self.angles.is_none_or(|angles| places.iter().zip(angles).all(stands))
    }

    /// Where on `candidate` its points lie, from 0 to 1, one after another; `None` if it does not pass them.
    pub fn places(self, candidate: &Way, allowed: Allowed) -> Option<Vec<f64>> {
        if !self.turns_as(candidate) {
            return None;
        }
        let is_straight = [self.nominal, candidate].into_iter().all(|way| matches!(way, Way::Line(..)));
        let mut places = Vec::with_capacity(self.points.len());
        let mut from = 0.0;
        for goal in self.goals().filter(|goal| goal.is_point || !is_straight) {
            from = place(candidate, from, &goal, allowed, self.angles.is_some())?;
            places.extend(goal.is_point.then_some(from));
        }
        // The last one is where the written way ends.
        *places.last_mut()? = 1.0;
        Some(places)
    }
}

/// Where `candidate` passes `goal`, not before `from`; `turns`: rotary axes turn along it, and must stand right there.
fn place(candidate: &Way, from: f64, goal: &Goal, allowed: Allowed, turns: bool) -> Option<f64> {
    let off = |t: f64| Some(candidate.at(t)?.0 - goal.position);
    let off_there = off(goal.share)?;
    if off_there.amax() <= allowed.unit_mm || (turns && off_there.norm() <= allowed.tolerance_mm) {
        return Some(goal.share.max(from));
    }
    if turns {
        return None;
    }
    let place = if goal.share < 1.0 { nearest(candidate, &goal.position, goal.share)?.max(from) } else { 1.0 };
    (off(place)?.norm() <= allowed.tolerance_mm).then_some(place)
}

/// Where `way` passes nearest to `goal`, from 0 to 1, sought from `guess` on.
fn nearest(way: &Way, goal: &Vector3<f64>, guess: f64) -> Option<f64> {
    let length = way.length();
    let mut t = guess;
    for _ in 0..MOST_STEPS {
        let (position, tangent) = way.at(t)?;
        let step = (goal - position).dot(&tangent) / length;
        if step.is_nan() || step.abs() * length <= NEAR_MM {
            break;
        }
        t = (t + step).clamp(0.0, 1.0);
    }
    Some(t)
}

/// Steps to the nearest place, each shorter than the one before by the distance over the radius.
const MOST_STEPS: usize = 20;
/// A place is found when it moves by less, mm.
const NEAR_MM: f64 = 1e-7;
