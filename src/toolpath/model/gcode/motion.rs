//! One motion block: where it starts, how it goes, where it ends.

use std::ops::Range;

use nalgebra::Vector3;

use crate::toolpath::model::{
    Orientation, PathPoint, PointSource, Sampling, direction, even_places,
    gcode::{Arc, Centre, Modal, MotionCode, Rotary, Turning, Word, rotary},
};

/// Coordinates of which some may not be known, mm in the workpiece frame.
pub(crate) type Known = [Option<f64>; 3];

/// The position, if every coordinate is known.
pub(crate) fn located(position: Known) -> Option<Vector3<f64>> {
    match position {
        [Some(x), Some(y), Some(z)] => Some(Vector3::new(x, y, z)),
        _ => None,
    }
}

/// The way through one hole, mm in the workpiece frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hole {
    pub start: Vector3<f64>,
    /// Over the hole, as high as the tool comes.
    pub over: Vector3<f64>,
    /// At the plane R.
    pub clear: Vector3<f64>,
    pub bottom: Vector3<f64>,
    pub back: Vector3<f64>,
    /// Whether a series of holes begins here.
    pub is_first: bool,
}

impl Hole {
    /// Parameters of the corners of the way.
    const OVER: f64 = 0.125;
    const CLEAR: f64 = 0.25;
    const BOTTOM: f64 = 0.75;

    /// Parameters of its points; the feed into the hole is split into all but three of `pieces`.
    pub fn parameters(pieces: usize) -> impl Iterator<Item = f64> {
        let feeds = pieces.saturating_sub(3).max(1);
        let feed = move |k: usize| Hole::CLEAR + (Hole::BOTTOM - Hole::CLEAR) * (k as f64 / feeds as f64);
        [Hole::OVER, Hole::CLEAR].into_iter().chain((1..=feeds).map(feed)).chain([1.0])
    }

    /// Whether the tool feeds at parameter `t`.
    pub fn feeds_at(t: f64) -> bool {
        t > Hole::CLEAR && t <= Hole::BOTTOM
    }

    /// Position and unit tangent at `t` from 0 to 1.
    pub fn at(&self, t: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (from, to, s) = match t {
            _ if t <= Hole::OVER => (self.start, self.over, t / Hole::OVER),
            _ if t <= Hole::CLEAR => (self.over, self.clear, (t - Hole::OVER) / (Hole::CLEAR - Hole::OVER)),
            _ if t <= Hole::BOTTOM => (self.clear, self.bottom, (t - Hole::CLEAR) / (Hole::BOTTOM - Hole::CLEAR)),
            _ => (self.bottom, self.back, (t - Hole::BOTTOM) / (1.0 - Hole::BOTTOM)),
        };
        (if s < 1.0 { from.lerp(&to, s) } else { to }, direction(to - from))
    }

    /// Length of the way as far as `t`, mm.
    pub fn length_to(&self, t: f64) -> f64 {
        let corners =
            [(0.0, self.start), (Hole::OVER, self.over), (Hole::CLEAR, self.clear), (Hole::BOTTOM, self.bottom)];
        let ways = corners.iter().zip([Hole::OVER, Hole::CLEAR, Hole::BOTTOM, 1.0]);
        let way = |((from, begins), ends): (&(f64, Vector3<f64>), f64)| {
            if t <= *from { 0.0 } else { (self.at(t.min(ends)).0 - begins).norm() }
        };
        ways.map(way).sum()
    }
}

/// The way a motion takes, in the workpiece frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Geometry {
    /// Some coordinate of its end is not known: the path has no point for it.
    Unlocated,
    /// Its start is not known: the path has only its end.
    Arrival(Vector3<f64>),
    /// Straight from the first to the second.
    Line(Vector3<f64>, Vector3<f64>),
    /// Round.
    Arc(Arc),
    /// Into a hole and out again.
    Hole(Hole),
}

impl Geometry {
    /// Position and unit tangent at `t` from 0 to 1; the tangent is zero where the motion has none.
    pub fn at(&self, t: f64) -> Option<(Vector3<f64>, Vector3<f64>)> {
        match self {
            Geometry::Unlocated => None,
            Geometry::Arrival(end) => Some((*end, Vector3::zeros())),
            Geometry::Line(start, end) => {
                let position = if t < 1.0 { start.lerp(end, t) } else { *end };
                Some((position, direction(end - start)))
            }
            Geometry::Arc(arc) => Some(arc.at(t)),
            Geometry::Hole(hole) => Some(hole.at(t)),
        }
    }

    /// Where it passes nearest to `goal`, from 0 to 1, sought from `guess` on.
    pub fn nearest(&self, goal: &Vector3<f64>, guess: f64) -> Option<f64> {
        let length = self.length();
        let mut t = guess;
        for _ in 0..MOST_STEPS {
            let (position, tangent) = self.at(t)?;
            let step = (goal - position).dot(&tangent) / length;
            if step.is_nan() || step.abs() * length <= NEAR_MM {
                break;
            }
            t = (t + step).clamp(0.0, 1.0);
        }
        Some(t)
    }

    /// Length, mm, of what is known of it.
    pub fn length(&self) -> f64 {
        match self {
            Geometry::Unlocated | Geometry::Arrival(_) => 0.0,
            Geometry::Line(start, end) => (end - start).norm(),
            Geometry::Arc(arc) => arc.length(),
            Geometry::Hole(hole) => hole.length_to(1.0),
        }
    }
}

/// Steps to the nearest place, each shorter than the one before by the distance over the radius.
const MOST_STEPS: usize = 20;
/// Shares of a motion between which it is taken as straight.
const NEARBY: f64 = 1e-5;
/// A place is found when it moves by less, mm.
const NEAR_MM: f64 = 1e-7;

/// A line of the program that moves the tool.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    /// The line it is on, from 1.
    pub line: usize,
    /// What is in force on the line, its own words included.
    pub modal: Modal,
    /// The motion itself, `modal.motion`.
    pub code: MotionCode,
    /// Zero of the coordinates in force, mm in the workpiece frame.
    pub origin: Vector3<f64>,
    pub start: Known,
    pub end: Known,
    /// How rotary axes turn along it.
    pub turning: Turning,
    /// For arcs, the centre as the words give it.
    pub centre: Option<Centre>,
    pub geometry: Geometry,
    /// The words of the line.
    pub words: Vec<Word>,
    /// Bytes of the line that say it moves: its motion word if it has one, or its first coordinate.
    pub span: Range<usize>,
}

impl Motion {
    /// Whether it moves the tool from or to a place that is not known; a cycle that drills nothing (L0) does not move it, nor does an angle
    /// at which its axis stands.
    pub fn is_lost(&self) -> bool {
        let names_angles_alone =
            self.words.iter().all(|word| !matches!(word.letter, 'X' | 'Y' | 'Z' | 'I' | 'J' | 'K' | 'R'));
        let stays = matches!(self.code, MotionCode::Cycle(_)) || (names_angles_alone && !self.turning.turns());
        self.geometry == Geometry::Unlocated && !(stays && self.start == self.end)
    }

    /// Whether it is a flat arc that would rise from `start` to `end`.
    pub fn makes_helix(&self, start: &Vector3<f64>, end: &Vector3<f64>) -> bool {
        let normal = self.modal.plane.axes()[2];
        matches!(self.code, MotionCode::Arc(_))
            && self.start[normal] == self.end[normal]
            && start[normal] != end[normal]
    }

    /// Into how many pieces the motion is split; `None` when into more than a path may have points. A rapid move is
    /// never split: controllers need not drive it straight, and nothing is cut on the way.
    pub fn pieces(&self, sampling: Sampling, rotary: &Rotary) -> Option<usize> {
        let turn = self.turn(rotary);
        match (&self.geometry, self.code) {
            (Geometry::Unlocated, _) => Some(0),
            (Geometry::Arrival(_), _) | (_, MotionCode::Rapid) => Some(1),
            (Geometry::Hole(hole), _) => Some(3 + sampling.line_pieces((hole.bottom - hole.clear).norm())?),
            (Geometry::Line(..), _) => sampling.turning_pieces(self.geometry.length(), turn),
            (Geometry::Arc(arc), _) => {
                let of_arc = sampling.arc_pieces(arc.radius(), arc.sweep_rad(), arc.length())?;
                Some(of_arc.max(sampling.turning_pieces(0.0, turn)?))
            }
        }
    }

    /// The ends of its `pieces` equal pieces, from 0 to 1.
    pub fn parameters(&self, pieces: usize) -> Vec<f64> {
        match self.geometry {
            Geometry::Hole(_) => Hole::parameters(pieces).collect(),
            _ => even_places(pieces),
        }
    }

    /// The most by which the tool turns along it, rad, seen from the workpiece.
    fn turn(&self, rotary: &Rotary) -> f64 {
        if !self.turning.turns() {
            return 0.0;
        }
        // An axis may turn the tool about itself, or out and back.
        let turned = |letter: char| {
            let axis = rotary::index(letter);
            if rotary.has(letter) { (self.turning.to[axis] - self.turning.from[axis]).abs().to_radians() } else { 0.0 }
        };
        ['A', 'B', 'C'].map(turned).iter().sum()
    }

    /// Position in W, mm, and unit tangent at `t` from 0 to 1, whatever its coordinates are those of.
    pub fn at(&self, t: f64, rotary: &Rotary) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let (position, tangent) = self.geometry.at(t)?;
        if !self.turning.displaces() {
            return Some((position, tangent));
        }
        let tip = |t: f64| Some(rotary.tip(self.geometry.at(t)?.0, &self.turning.at(t)));
        let tangent = match self.geometry {
            Geometry::Arrival(_) => tangent,
            _ => direction(tip((t + NEARBY).min(1.0))? - tip((t - NEARBY).max(0.0))?),
        };
        Some((tip(t)?, tangent))
    }

    /// Adds the points of the motion at `parameters` to `points`; `segment` is its index in the program and `before_mm` the
    /// length of the path before it.
    pub fn sample(
        &self,
        segment: usize,
        parameters: &[f64],
        before_mm: f64,
        rotary: &Rotary,
        points: &mut Vec<PathPoint>,
    ) {
        // Of coordinates that are not the tip's, the length is that of the tip, in pieces along which axes turn by little.
        let is_moved =
            self.turning.displaces() && self.turning.turns() && !matches!(self.geometry, Geometry::Arrival(_));
        let mut passed = self.at(0.0, rotary).filter(|_| is_moved).map(|(begin, _)| (begin, 0.0));
        let mut length_to = |parameter: f64| match (&mut passed, &self.geometry) {
            (Some((before, length)), _) => {
                let here = self.at(parameter, rotary).map_or(*before, |(position, _)| position);
                *length += (here - std::mem::replace(before, here)).norm();
                *length
            }
            (None, Geometry::Hole(hole)) => hole.length_to(parameter),
            (None, geometry) => geometry.length() * parameter,
        };
        let lengths: Vec<f64> = parameters.iter().map(|parameter| length_to(*parameter)).collect();
        let length = lengths.last().copied().filter(|_| is_moved).unwrap_or_else(|| self.geometry.length());
        for (&parameter, so_far) in parameters.iter().zip(lengths) {
            let Some((position_mm, tangent)) = self.at(parameter, rotary) else {
                return;
            };
            let cutting = match self.geometry {
                Geometry::Hole(_) => Hole::feeds_at(parameter),
                _ => self.code != MotionCode::Rapid,
            };
            points.push(PathPoint {
                position_mm,
                orientation: (!rotary.is_empty())
                    .then(|| Orientation::ToolAxis(rotary.tool_axis(&self.turning.at(parameter)))),
                tangent,
                arc_length_mm: before_mm + so_far,
                cutting,
                feed_mm_per_min: self.modal.feed_mm_per_min(length).filter(|_| cutting),
                spindle_rev_per_min: self.modal.spindle_rev_per_min(),
                tool: self.modal.tool,
                feature: self.modal.feature,
                load: None,
                external: Default::default(),
                source: PointSource { segment, parameter },
            });
        }
    }
}
