//! One motion block: where it starts, how it goes, where it ends.

use std::ops::Range;

use nalgebra::Vector3;

use crate::toolpath::model::{
    Hole, Orientation, PathPoint, PointSource, Sampling, Way, direction, even_places,
    gcode::{Centre, Modal, MotionCode, Rotary, Turning, Word, rotary},
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

/// Shares of a motion between which it is taken as straight.
const NEARBY: f64 = 1e-5;
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
    pub geometry: Way,
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
        self.geometry == Way::Unlocated && !(stays && self.start == self.end)
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
        match (self.geometry, self.code) {
            (Way::Unlocated, _) => Some(0),
            (_, MotionCode::Rapid) => Some(1),
            (way, _) => way.pieces(sampling, self.turn(rotary)),
        }
    }

    /// The ends of its `pieces` equal pieces, from 0 to 1.
    pub fn parameters(&self, pieces: usize) -> Vec<f64> {
        match self.geometry {
            Way::Hole(_) => Hole::parameters(pieces).collect(),
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
            Way::Arrival(_) => tangent,
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
        let is_moved = self.turning.displaces() && self.turning.turns() && !matches!(self.geometry, Way::Arrival(_));
        let mut passed = self.at(0.0, rotary).filter(|_| is_moved).map(|(begin, _)| (begin, 0.0));
        let mut length_to = |parameter: f64| match (&mut passed, &self.geometry) {
            (Some((before, length)), _) => {
                let here = self.at(parameter, rotary).map_or(*before, |(position, _)| position);
                *length += (here - std::mem::replace(before, here)).norm();
                *length
            }
            (None, Way::Hole(hole)) => hole.length_to(parameter),
            (None, geometry) => geometry.length() * parameter,
        };
        let lengths: Vec<f64> = parameters.iter().map(|parameter| length_to(*parameter)).collect();
        let length = lengths.last().copied().filter(|_| is_moved).unwrap_or_else(|| self.geometry.length());
        for (&parameter, so_far) in parameters.iter().zip(lengths) {
            let Some((position_mm, tangent)) = self.at(parameter, rotary) else {
                return;
            };
            let cutting = match self.geometry {
                Way::Hole(_) => Hole::feeds_at(parameter),
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
