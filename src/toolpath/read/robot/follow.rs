//! Follows statements of robot programs: where each leads in the workpiece frame W, and along which way.

use nalgebra::Vector3;

use crate::{
    machine::ExternalAxes,
    toolpath::model::{
        MAX_COORDINATE_MM, MotionGeometry, Orientation, PathPoint, PointSource, Sampling,
        robot::{Arc, Component, Language, MotionKind, RobotFault, Statement, Target, rotation},
    },
};

/// Position, orientation and external axes of the tool in the workpiece frame W.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ToolState {
    /// Position of the tip, mm.
    pub position: Vector3<f64>,
    pub orientation: Option<Orientation>,
    /// Positions of external axes, mm or degrees; `None` if unknown.
    pub external: [Option<f64>; ExternalAxes::MOST],
}

/// A statement with its start, end and geometry.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    pub statement: Statement,
    /// State at its start, if known.
    pub start: Option<ToolState>,
    pub end: Option<ToolState>,
    pub geometry: MotionGeometry,
}

/// Feeds above this are ignored.
const MOST_FEED_MM_PER_MIN: f64 = 1e9;
/// Spindle speeds above this are ignored.
const MOST_REV_PER_MIN: f64 = 1e9;

/// The state that motions lead to, statement by statement.
#[derive(Debug)]
pub(crate) struct Follower {
    language: Language,
    /// Number of external axes with names; they come first.
    named_axes: usize,
    here: Option<ToolState>,
    /// First position of each external axis.
    external: [Option<f64>; ExternalAxes::MOST],
}

impl Follower {
    /// Starts before the first statement.
    pub fn new(language: Language, named_axes: usize) -> Self {
        Self { language, named_axes, here: None, external: [None; ExternalAxes::MOST] }
    }

    /// Returns the motion of the next `statement`, and updates the state. `Err` for what cannot be followed.
    pub fn follow(&mut self, mut statement: Statement) -> Result<Motion, RobotFault> {
        statement.feed_mm_per_min = statement.feed_mm_per_min.filter(|feed| *feed <= MOST_FEED_MM_PER_MIN);
        statement.spindle_rev_per_min = statement.spindle_rev_per_min.filter(|speed| *speed <= MOST_REV_PER_MIN);
        let start = self.here;
        let end = match &statement.end {
            Some(target) => target_state(self.language, &statement, target, start.as_ref())?,
            None => None,
        };
        if let Some(end) = &end {
            self.check_external(end)?;
        }
        let geometry = match (statement.kind, &start, &end) {
            (_, _, None) => MotionGeometry::Unlocated,
            (MotionKind::Line, Some(start), Some(end)) => MotionGeometry::Line(start.position, end.position),
            (MotionKind::Circle, Some(start), Some(end)) => self.arc(&statement, start, end)?,
            (MotionKind::Circle, None, Some(_)) => return Err(RobotFault::CircleFromNowhere),
            (_, _, Some(end)) => MotionGeometry::Arrival(end.position),
        };
        // A circle may end where its angle says.
        let end = end.map(|end| ToolState { position: geometry.at(1.0).map_or(end.position, |(at, _)| at), ..end });
        if end.is_some_and(|end| end.position.amax() > MAX_COORDINATE_MM) {
            return Err(RobotFault::TooFar);
        }
        self.here = end;
        Ok(Motion { statement, start, end, geometry })
    }

    /// Returns the arc of a circle statement from `start` to `end`; `Err` if its points are on no circle.
    fn arc(&self, statement: &Statement, start: &ToolState, end: &ToolState) -> Result<MotionGeometry, RobotFault> {
        let via = match &statement.via {
            Some(via) => target_state(self.language, statement, via, Some(start))?,
            None => None,
        };
        let via = via.ok_or(RobotFault::NoCircle)?.position;
        let arc = Arc::through([start.position, via, end.position], statement.sweep_rad);
        Ok(MotionGeometry::Circle(arc.ok_or(RobotFault::NoCircle)?))
    }

    /// Checks external axes: those with names must be known, the others must stand still.
    fn check_external(&mut self, end: &ToolState) -> Result<(), RobotFault> {
        for (axis, now) in end.external.into_iter().enumerate() {
            match (self.external[axis], now) {
                (_, None) if axis < self.named_axes => return Err(RobotFault::NoExternal { axis: axis + 1 }),
                (Some(from), Some(to)) if axis >= self.named_axes && from != to => {
                    return Err(RobotFault::External { axis: axis + 1, from, to });
                }
                (before, now) => self.external[axis] = before.or(now),
            }
        }
        Ok(())
    }
}

/// Returns the state that `target` of `statement` leads to from `here`; `None` if it is unknown.
pub(crate) fn target_state(
    language: Language,
    statement: &Statement,
    target: &Target,
    here: Option<&ToolState>,
) -> Result<Option<ToolState>, RobotFault> {
    let frames = &statement.frames;
    let before = here.map(|here| frames.base.inverse_transform_point(&here.position.into()));
    let coordinate = |axis: usize| match (target.number(Component::Position(axis)), statement.is_step) {
        (Some(value), false) => Some(value * frames.unit_mm),
        (Some(step), true) => Some(before?[axis] + step * frames.unit_mm),
        (None, _) => Some(before?[axis]),
    };
    let orientation = rotation::tool_orientation(language, target, frames, here.and_then(|here| here.orientation))?;
    let (Some(x), Some(y), Some(z)) = (coordinate(0), coordinate(1), coordinate(2)) else { return Ok(None) };
    if orientation.is_none() && language != Language::Apt {
        return Ok(None);
    }
    let external = std::array::from_fn(|axis| {
        target.number(Component::External(axis)).or_else(|| here.and_then(|here| here.external[axis]))
    });
    let position = frames.base.transform_point(&Vector3::new(x, y, z).into()).coords;
    // Not-a-numbers compare as false.
    if !position.iter().chain(external.iter().flatten()).all(|number| number.abs() <= MAX_COORDINATE_MM) {
        return Err(RobotFault::TooFar);
    }
    Ok(Some(ToolState { position, orientation, external }))
}

impl Motion {
    /// Whether the tool may cut during the motion: it is not point to point.
    pub fn may_cut(&self) -> bool {
        self.statement.kind != MotionKind::PointToPoint
    }

    /// Returns the orientation of the tool at the share `t` (0 to 1) of the motion, if it is known.
    pub fn orientation_at(&self, t: f64) -> Option<Orientation> {
        let end = self.end?.orientation?;
        match self.start.and_then(|start| start.orientation) {
            Some(start) if t < 1.0 => Some(start.towards(&end, t)),
            _ => Some(end),
        }
    }

    /// Returns the positions of the external axes at the share `t` (0 to 1) of the motion, mm or degrees.
    pub fn external_at(&self, t: f64) -> [Option<f64>; ExternalAxes::MOST] {
        let Some(end) = self.end else { return [None; ExternalAxes::MOST] };
        std::array::from_fn(|axis| match self.start.and_then(|start| start.external[axis]) {
            Some(start) if t < 1.0 => end.external[axis].map(|end| start + (end - start) * t),
            _ => end.external[axis],
        })
    }

    /// Returns the angle between the orientations at start and end, rad; 0 if one is unknown.
    fn rotation_rad(&self) -> f64 {
        let start = self.start.and_then(|start| start.orientation);
        start.zip(self.end.and_then(|end| end.orientation)).map_or(0.0, |(start, end)| start.angle_to(&end))
    }

    /// Returns the number of pieces into which `sampling` splits the motion, 1 if point to point; `None` if more than a path may have.
    pub fn piece_count(&self, sampling: Sampling) -> Option<usize> {
        self.geometry.pieces(sampling, self.rotation_rad())
    }

    /// Appends the path points at `parameters` (0 to 1) to `points`. `segment` is the motion's index, `before_mm` the arc length before it.
    pub fn sample(&self, segment: usize, parameters: &[f64], before_mm: f64, points: &mut Vec<PathPoint>) {
        let length = self.geometry.length();
        for &parameter in parameters {
            let Some((position_mm, tangent)) = self.geometry.at(parameter) else { return };
            points.push(PathPoint {
                position_mm,
                orientation: self.orientation_at(parameter),
                tangent,
                arc_length_mm: before_mm + length * parameter,
                cutting: self.may_cut(),
                feed_mm_per_min: self.statement.feed_mm_per_min.filter(|_| self.may_cut()),
                spindle_rev_per_min: self.statement.spindle_rev_per_min,
                tool: self.statement.tool,
                feature: None,
                load: None,
                external: self.external_at(parameter).map(Option::unwrap_or_default),
                source: PointSource { segment, parameter },
            });
        }
    }
}
