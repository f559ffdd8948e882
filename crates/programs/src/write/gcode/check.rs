//! Checks that a candidate block passes the corrected points within tolerance, and finds where on it each point lies.

use nalgebra::Vector3;

use crate::model::{MotionGeometry, PathPoint, gcode::Angles};

/// A written arc may turn by as much more or less than the programmed one, rad.
const TURN_RAD: f64 = 0.5;

/// Consecutive points of a programmed block and their corrected positions.
#[derive(Clone, Copy)]
pub(crate) struct Stretch<'a> {
    /// The block as programmed.
    pub nominal: &'a MotionGeometry,
    /// Parameter and correction, mm, of where the points begin.
    pub before: (f64, Vector3<f64>),
    pub points: &'a [PathPoint],
    pub corrected: &'a [Vector3<f64>],
    /// Corrected angles of the rotary axes at the points, degrees, if they turn or are corrected.
    pub angles: Option<&'a [Angles]>,
}

/// How far a written block may be from the corrected points, mm.
#[derive(Clone, Copy)]
pub(crate) struct WriteTolerance {
    /// Limit of each coordinate for a point that lies as far along the written block as along the programmed one.
    pub unit_mm: f64,
    /// Limit of the distance from a point to the written curve.
    pub tolerance_mm: f64,
}

/// A position that a written block should pass.
pub(crate) struct DesiredPosition {
    /// How far along the stretch the position lies, from 0 to 1.
    share: f64,
    pub position: Vector3<f64>,
    /// Whether the position is a path point, not the middle between two of them.
    is_point: bool,
}

impl<'a> Stretch<'a> {
    /// Returns the stretch of the first `count` points.
    pub fn first_points(self, count: usize) -> Stretch<'a> {
        let angles = self.angles.map(|angles| &angles[..count]);
        Stretch { points: &self.points[..count], corrected: &self.corrected[..count], angles, ..self }
    }

    /// Returns the rest of the stretch after the first `count` points.
    pub fn after_points(self, count: usize) -> Stretch<'a> {
        let before = self.correction(count.checked_sub(1));
        let angles = self.angles.map(|angles| &angles[count..]);
        Stretch { before, points: &self.points[count..], corrected: &self.corrected[count..], angles, ..self }
    }

    /// Returns the parameter and the correction (mm) of point `k`; those of the beginning for `None`.
    fn correction(&self, k: Option<usize>) -> (f64, Vector3<f64>) {
        let of_point =
            |(point, corrected): (&PathPoint, &Vector3<f64>)| (point.source.parameter, corrected - point.position_mm);
        k.and_then(|k| self.points.get(k).zip(self.corrected.get(k))).map_or(self.before, of_point)
    }

    /// Iterates over the corrected points, and before each the middle of the curve to it, moved by the mean of the two corrections: an
    /// arc in the other direction could pass the points alone.
    pub fn goals(self) -> impl Iterator<Item = DesiredPosition> + use<'a> {
        let begin = self.before.0;
        let length = self.correction(self.points.len().checked_sub(1)).0 - begin;
        let share = move |t: f64| if length > 0.0 { (t - begin) / length } else { 1.0 };
        (0..self.points.len()).flat_map(move |k| {
            let (from, to) = (self.correction(k.checked_sub(1)), self.correction(Some(k)));
            let middle = f64::midpoint(from.0, to.0);
            let between = self.nominal.at(middle).map(|(position, _)| DesiredPosition {
                share: share(middle),
                position: position + (from.1 + to.1) / 2.0,
                is_point: false,
            });
            let point = DesiredPosition { share: share(to.0), position: self.corrected[k], is_point: true };
            between.into_iter().chain([point])
        })
    }

    /// Whether a candidate arc turns by about the programmed angle: near its ends, points do not tell a full turn from none.
    fn has_programmed_sweep(&self, candidate: &MotionGeometry) -> bool {
        let (MotionGeometry::Arc(nominal), MotionGeometry::Arc(candidate)) = (self.nominal, candidate) else {
            return true;
        };
        let share = self.correction(self.points.len().checked_sub(1)).0 - self.before.0;
        (candidate.sweep_rad() - nominal.sweep_rad() * share).abs() < TURN_RAD
    }

    /// Whether rotary axes that turn evenly from `from` to `to` have the corrected angles at `parameters` within `allowed` degrees.
    pub fn has_angles_at(&self, parameters: &[f64], [from, to]: [&Angles; 2], allowed: f64) -> bool {
        let is_reached = |(parameter, corrected): (&f64, &Angles)| {
            (0..3).all(|axis| (from[axis] + (to[axis] - from[axis]) * parameter - corrected[axis]).abs() <= allowed)
        };
        self.angles.is_none_or(|angles| parameters.iter().zip(angles).all(is_reached))
    }

    /// Returns where on `candidate` the points lie, from 0 to 1 in ascending order; `None` if it does not pass them within `allowed`.
    pub fn parameters(self, candidate: &MotionGeometry, allowed: WriteTolerance) -> Option<Vec<f64>> {
        if !self.has_programmed_sweep(candidate) {
            return None;
        }
        let is_straight = [self.nominal, candidate].into_iter().all(|curve| matches!(curve, MotionGeometry::Line(..)));
        let mut parameters = Vec::with_capacity(self.points.len());
        let mut from = 0.0;
        for goal in self.goals().filter(|goal| goal.is_point || !is_straight) {
            from = passes_at(candidate, from, &goal, allowed, self.angles.is_some())?;
            parameters.extend(goal.is_point.then_some(from));
        }
        // The last one is where the written way ends.
        *parameters.last_mut()? = 1.0;
        Some(parameters)
    }
}

/// Returns the parameter, at least `from`, at which `candidate` passes `goal`; `None` if it is too far off. If rotary axes turn along it
/// (`turns`), only the goal's own share counts.
fn passes_at(
    candidate: &MotionGeometry,
    from: f64,
    goal: &DesiredPosition,
    allowed: WriteTolerance,
    turns: bool,
) -> Option<f64> {
    let error = |t: f64| Some(candidate.at(t)?.0 - goal.position);
    let error_at_share = error(goal.share)?;
    if error_at_share.amax() <= allowed.unit_mm || (turns && error_at_share.norm() <= allowed.tolerance_mm) {
        return Some(goal.share.max(from));
    }
    if turns {
        return None;
    }
    let parameter = if goal.share < 1.0 { nearest(candidate, &goal.position, goal.share)?.max(from) } else { 1.0 };
    (error(parameter)?.norm() <= allowed.tolerance_mm).then_some(parameter)
}

/// Returns the parameter (0 to 1) at which `geometry` passes nearest to `goal` (mm), by iteration from `guess`; `None` if it has no points.
fn nearest(geometry: &MotionGeometry, goal: &Vector3<f64>, guess: f64) -> Option<f64> {
    let length = geometry.length();
    let mut t = guess;
    for _ in 0..MAX_STEPS {
        let (position, tangent) = geometry.at(t)?;
        let step = (goal - position).dot(&tangent) / length;
        if step.is_nan() || step.abs() * length <= NEAR_MM {
            break;
        }
        t = (t + step).clamp(0.0, 1.0);
    }
    Some(t)
}

/// Steps to the nearest place, each shorter than the one before by the distance over the radius.
const MAX_STEPS: usize = 20;
/// A place is found when it moves by less, mm.
const NEAR_MM: f64 = 1e-7;
