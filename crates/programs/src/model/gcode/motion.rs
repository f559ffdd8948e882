//! One motion of a G-code program: where it starts, its geometry, where it ends, and its path points.

use std::ops::Range;

use nalgebra::Vector3;

use crate::model::{
    Hole, MotionGeometry, Orientation, PathPoint, PointSource, Sampling, Way, direction, even_parameters,
    gcode::{Centre, Coordinates, FeedMode, ModalState, MotionCode, Rotary, RotaryMotion, Word, rotary},
};

/// A position of which some coordinates may be unknown, mm in the workpiece frame.
pub(crate) type PartialPosition = [Option<f64>; 3];

/// Returns the position, mm; `None` if a coordinate is unknown.
pub(crate) fn located(position: PartialPosition) -> Option<Vector3<f64>> {
    match position {
        [Some(x), Some(y), Some(z)] => Some(Vector3::new(x, y, z)),
        _ => None,
    }
}

/// Shares of a motion between which it is taken as straight.
const NEARBY: f64 = 1e-5;
/// A motion of a G-code program, with the modal state, zero and words of its line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    /// The motion's line, from 1.
    pub line: usize,
    /// The modal state on the line, its own words included.
    pub modal: ModalState,
    /// The motion itself, `modal.motion`.
    pub code: MotionCode,
    /// Zero of the coordinates in force, mm in the workpiece frame.
    pub origin: Vector3<f64>,
    pub start: PartialPosition,
    pub end: PartialPosition,
    /// The angles of the rotary axes along the motion.
    pub turning: RotaryMotion,
    /// The centre of an arc, as the words give it.
    pub centre: Option<Centre>,
    pub geometry: MotionGeometry,
    /// The words of the line.
    pub words: Vec<Word>,
    /// Bytes of the line that command the motion: its motion word if it has one, or its first coordinate.
    pub span: Range<usize>,
}

impl Motion {
    /// Whether the motion moves the tool from or to an unknown position; a cycle that drills nothing and a rotary word at its angle do not.
    pub fn is_unlocated(&self) -> bool {
        let names_angles_alone =
            self.words.iter().all(|word| !matches!(word.letter, 'X' | 'Y' | 'Z' | 'I' | 'J' | 'K' | 'R'));
        let stays = match self.code {
            // L0; at a height that is not known, a hole ends where it begins, too.
            MotionCode::Cycle(_) => self.words.iter().any(|word| matches!(word.letter, 'L' | 'K') && word.value == 0.0),
            _ => names_angles_alone && !self.turning.turns(),
        };
        self.geometry == MotionGeometry::Unlocated && !(stays && self.start == self.end)
    }

    /// Returns by which angle rotary axes turn while X, Y and Z stand, degrees, of several axes the root of the sum of squares; `None` where X, Y or Z move, and where the
    /// control keeps the tip in place.
    pub fn turned_alone_deg(&self) -> Option<f64> {
        let stands = matches!(self.geometry, MotionGeometry::Line(start, end) if start == end);
        let is_alone = stands && self.turning.turns() && self.turning.coordinates != Coordinates::Tip;
        let turned = [0, 1, 2].map(|axis| self.turning.to[axis] - self.turning.from[axis]);
        is_alone.then(|| turned.iter().map(|own| own * own).sum::<f64>().sqrt())
    }

    /// Returns the time that a motion of `length_mm` takes by F, min; `None` if F does not say it.
    ///
    /// F is in degrees a minute where rotary axes move alone:
    ///
    /// ```text
    /// Fanuc        Power Mate i-D/H Operator's Manual, B-63174EN/03, 4.2
    /// LinuxCNC     docs, G-code, CNC Machine Overview, Feed Rate: of several axes in their pseudo-Cartesian system
    /// Sinumerik    ONE Programming Manual, 6FC5398-2EP40-0BA0, 2.7.1: unless FGREF gives another radius
    /// Heidenhain   TNC 640 User's Manual, 34059x-01, 11.4: unless M116 is on
    /// ```
    ///
    /// To Haas it is in mm or inches a minute at the diameter of settings 34 and 79 (G93 in the Mill Operator's Manual), which no program says.
    pub fn minutes(&self, length_mm: f64) -> Option<f64> {
        let feed = self.modal.per_minute().filter(|feed| *feed > 0.0)?;
        match (self.modal.feed_mode, self.turned_alone_deg()) {
            (FeedMode::InverseTime, _) => Some(1.0 / feed),
            (_, Some(_)) if !self.modal.has_degrees => None,
            (_, Some(turned)) => Some(turned * self.modal.feed_unit_mm / feed),
            (_, None) => Some(length_mm / feed),
        }
    }

    /// Returns the feed of a motion of `length_mm`, mm/min, hardly any where the tip stands; `None` if F (and for feed per revolution S) does not
    /// give it.
    pub fn feed_mm_per_min(&self, length_mm: f64) -> Option<f64> {
        if self.modal.feed_mode != FeedMode::InverseTime && self.turned_alone_deg().is_none() {
            return self.modal.per_minute();
        }
        self.minutes(length_mm).map(|minutes| (length_mm / minutes).max(f64::MIN_POSITIVE))
    }

    /// Whether the motion is a flat arc in the program that would rise along its normal from `start` to `end` (mm in W).
    pub fn would_be_helical(&self, start: &Vector3<f64>, end: &Vector3<f64>) -> bool {
        let normal = self.modal.plane.axes()[2];
        matches!(self.code, MotionCode::Arc(_))
            && self.start[normal] == self.end[normal]
            && start[normal] != end[normal]
    }

    /// Returns into how many path pieces the motion is split; `None` for more than a path may have points. A rapid move is
    /// never split: controllers need not drive it straight, and nothing is cut.
    pub fn pieces(&self, sampling: Sampling, rotary: &Rotary) -> Option<usize> {
        match (self.geometry, self.code) {
            (MotionGeometry::Unlocated, _) => Some(0),
            (_, MotionCode::Rapid) => Some(1),
            (geometry, _) => geometry.pieces(sampling, self.turn_bound_rad(rotary)),
        }
    }

    /// Returns where the motion's `pieces` pieces end, as shares of the motion from 0 to 1.
    pub fn parameters(&self, pieces: usize) -> Vec<f64> {
        match self.geometry {
            MotionGeometry::Hole(_) => Hole::parameters(pieces).collect(),
            _ => even_parameters(pieces),
        }
    }

    /// Returns an upper bound of the angle by which the tool turns relative to the workpiece along the motion, rad.
    fn turn_bound_rad(&self, rotary: &Rotary) -> f64 {
        if !self.turning.turns() {
            return 0.0;
        }
        // An axis may turn the tool about itself, or out and back.
        let turned = |letter: char| {
            let axis = rotary::axis_index(letter);
            if rotary.has_axis(letter) {
                (self.turning.to[axis] - self.turning.from[axis]).abs().to_radians()
            } else {
                0.0
            }
        };
        ['A', 'B', 'C'].map(turned).iter().sum()
    }

    /// Returns the tip position (mm in W) and the unit tangent at the share `t` (0 to 1), whether X, Y, Z are of tip or head; `None` if
    /// unknown.
    pub fn at(&self, t: f64, rotary: &Rotary) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let (position, tangent) = self.geometry.at(t)?;
        if !self.turning.displaces_tip() {
            return Some((position, tangent));
        }
        if let Coordinates::Inclined(plane) = self.turning.coordinates {
            return Some((plane.transform(position), plane.rotation * tangent));
        }
        let tip = |t: f64| Some(rotary.tip_position(self.geometry.at(t)?.0, &self.turning.at(t)));
        let tangent = match self.geometry {
            MotionGeometry::Arrival(_) => tangent,
            _ => direction(tip((t + NEARBY).min(1.0))? - tip((t - NEARBY).max(0.0))?),
        };
        Some((tip(t)?, tangent))
    }

    /// Appends the path points at `parameters` (0 to 1) to `points`; `segment` is the motion's index, `before_mm` the path length before
    /// it.
    pub fn sample(
        &self,
        segment: usize,
        parameters: &[f64],
        before_mm: f64,
        rotary: &Rotary,
        points: &mut Vec<PathPoint>,
    ) {
        // Of coordinates that are not the tip's, the length is that of the tip, in pieces along which axes turn by little.
        let is_moved = self.turning.displaces_tip()
            && self.turning.turns()
            && !matches!(self.geometry, MotionGeometry::Arrival(_));
        let mut tip_passed = self.at(0.0, rotary).filter(|_| is_moved).map(|(begin, _)| (begin, 0.0));
        let mut length_to = |parameter: f64| match (&mut tip_passed, &self.geometry) {
            (Some((before, length)), _) => {
                let here = self.at(parameter, rotary).map_or(*before, |(position, _)| position);
                *length += (here - std::mem::replace(before, here)).norm();
                *length
            }
            (None, MotionGeometry::Hole(hole)) => hole.length_to(parameter),
            (None, geometry) => geometry.length() * parameter,
        };
        let lengths: Vec<f64> = parameters.iter().map(|parameter| length_to(*parameter)).collect();
        let length = lengths.last().copied().filter(|_| is_moved).unwrap_or_else(|| self.geometry.length());
        for (&parameter, length_so_far) in parameters.iter().zip(lengths) {
            let Some((position_mm, tangent)) = self.at(parameter, rotary) else {
                return;
            };
            let cutting = match self.geometry {
                MotionGeometry::Hole(_) => Hole::is_feeding_at(parameter),
                _ => self.code != MotionCode::Rapid,
            };
            points.push(PathPoint {
                position_mm,
                orientation: (!rotary.is_empty())
                    .then(|| Orientation::ToolAxis(rotary.tool_axis(&self.turning.at(parameter)))),
                tangent,
                arc_length_mm: before_mm + length_so_far,
                cutting,
                feed_mm_per_min: self.feed_mm_per_min(length).filter(|_| cutting),
                spindle_rev_per_min: self.modal.spindle_rev_per_min(),
                tool: self.modal.tool,
                feature: self.modal.feature,
                load: None,
                external: Default::default(),
                source: PointSource { segment, parameter },
                arm: None,
                way: match self.geometry {
                    MotionGeometry::Arrival(_) | MotionGeometry::Unlocated => Way::Unknown,
                    MotionGeometry::Spline { .. } => Way::Curve,
                    _ if cutting => Way::Followed,
                    _ => Way::Rapid,
                },
            });
        }
    }
}
