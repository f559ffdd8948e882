//! Follows statements of robot programs: where each leads in the workpiece frame W, and along which way.

use nalgebra::Vector3;

use crate::{
    model::{
        Hole, MAX_COORDINATE_MM, MotionGeometry, Orientation, PathPoint, PointSource, Sampling, Way, direction,
        even_parameters,
        robot::{
            AptCircle, Arc, ArmData, CircleTurn, Component, Drilling, Language, MotionKind, RobotFault, RobotOptions,
            Statement, Target, rotation,
        },
    },
    read::robot::krl::check_turn,
};
use kinetostat_spatial::MAX_EXTERNAL_AXES;

/// Position, orientation and external axes of the tool in the workpiece frame W.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ToolState {
    /// Position of the tip, mm.
    pub position: Vector3<f64>,
    pub orientation: Option<Orientation>,
    /// Positions of external axes, mm or degrees; `None` if unknown.
    pub external: [Option<f64>; MAX_EXTERNAL_AXES],
}

/// A statement with its start, end and geometry.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    pub statement: Statement,
    /// State at its start, if known.
    pub start: Option<ToolState>,
    pub end: Option<ToolState>,
    pub geometry: MotionGeometry,
    /// What the program says of the posture of the arm at its end.
    pub arm: Option<ArmData>,
}

/// Feeds above this are ignored.
const MAX_FEED_MM_PER_MIN: f64 = 1e9;
/// Spindle speeds above this are ignored.
const MAX_REV_PER_MIN: f64 = 1e9;

/// The state that motions lead to, statement by statement.
#[derive(Debug)]
pub(crate) struct Follower {
    language: Language,
    /// Number of external axes with names; they come first.
    named_axes: usize,
    ignores_configuration: bool,
    here: Option<ToolState>,
    /// First position of each external axis.
    external: [Option<f64>; MAX_EXTERNAL_AXES],
    /// The arc of APT that the last motion was.
    arc: Option<Arc>,
    /// Angles of the joints to which the motion before has led, rad, if it gave no pose.
    joints: Option<[f32; 6]>,
}

impl Follower {
    /// Starts before the first statement.
    pub fn new(language: Language, options: &RobotOptions) -> Self {
        let (named_axes, ignores_configuration) = (options.external_axes.len(), options.ignores_configuration);
        Self {
            language,
            named_axes,
            ignores_configuration,
            here: None,
            external: [None; MAX_EXTERNAL_AXES],
            arc: None,
            joints: None,
        }
    }

    /// Returns the motion of the next `statement`, and updates the state. `Err` for what cannot be followed.
    pub fn follow(&mut self, mut statement: Statement) -> Result<Motion, RobotFault> {
        statement.feed_mm_per_min = statement.feed_mm_per_min.filter(|feed| *feed <= MAX_FEED_MM_PER_MIN);
        statement.spindle_rev_per_min = statement.spindle_rev_per_min.filter(|speed| *speed <= MAX_REV_PER_MIN);
        let start = self.here;
        let end = match &statement.end {
            Some(target) => target_state(self.language, &statement, target, start.as_ref())?,
            None => None,
        };
        if let Some(end) = &end {
            self.check_external(end)?;
        }
        let arc_before = self.arc.take();
        let geometry = match (statement.kind, &start, &end) {
            (_, _, None) => MotionGeometry::Unlocated,
            (MotionKind::Line, _, Some(end)) if statement.apt.drilling.is_some() => {
                MotionGeometry::Hole(hole(&statement, start.map_or(end.position, |start| start.position), end))
            }
            (MotionKind::Line, Some(start), Some(end))
                if (end.position - start.position).norm() > ON_CIRCLE_MM
                    && arc_before.is_some_and(|arc| arc.goes_on_to(&end.position, ON_CIRCLE_MM)) =>
            {
                return RobotFault::not_followed(
                    "points on the circle behind its first are",
                    "one GOTO behind CIRCLE, the end of the arc",
                );
            }
            (MotionKind::Line, Some(start), Some(end)) => MotionGeometry::Line(start.position, end.position),
            (MotionKind::Spline, Some(start), Some(end)) => MotionGeometry::Spline {
                start: start.position,
                end: end.position,
                tangent: direction(end.position - start.position),
            },
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
        let from = std::mem::replace(&mut self.joints, statement.joints).filter(|_| end.is_some());
        let arm = self.arm_data(&statement, from);
        Ok(Motion { statement, start, end, geometry, arm })
    }

    /// Returns what `statement` says of the posture of the arm at its end, `from` the angles of the joints to which the motion before led, rad;
    /// `None` where it says nothing and these are not known, or postures are ignored.
    fn arm_data(&self, statement: &Statement, from: Option<[f32; 6]>) -> Option<ArmData> {
        if self.ignores_configuration {
            return None;
        }
        let said = statement.end.as_ref().filter(|_| !statement.is_posture_open);
        let said = said.and_then(|target| ArmData::of_target(self.language, target));
        let numbers = said.map_or([None; 6], |said| said.numbers);
        let is_taken = statement.kind == MotionKind::PointToPoint;
        (said.is_some() || from.is_some()).then_some(ArmData { language: self.language, numbers, is_taken, from })
    }

    /// Returns the arc of a circle statement from `start` to `end`; `Err` if its points are on no circle.
    fn arc(&mut self, statement: &Statement, start: &ToolState, end: &ToolState) -> Result<MotionGeometry, RobotFault> {
        if let Some(circle) = &statement.apt.circle {
            let arc = circle.arc_between(statement, &circle.record, [start.position, end.position])?;
            self.arc = Some(arc);
            return Ok(MotionGeometry::Circle(arc));
        }
        let via = match &statement.via {
            Some(via) => target_state(self.language, statement, via, Some(start))?,
            None => None,
        };
        let via = via.ok_or(RobotFault::NoCircle)?;
        if let Some(spline) = &statement.spline {
            check_turn(statement, spline, [start, &via, end])?;
        }
        let via = via.position;
        let arc = Arc::through([start.position, via, end.position], statement.sweep_rad);
        Ok(MotionGeometry::Circle(arc.ok_or(RobotFault::NoCircle)?))
    }

    /// Returns number, from 1, and position of each external axis that stands somewhere and has no name.
    pub fn unnamed_axes(&self) -> impl Iterator<Item = (usize, f64)> {
        let axes = self.external.into_iter().enumerate().skip(self.named_axes);
        axes.filter_map(|(axis, position)| Some((axis + 1, position?)))
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
    let axis = statement.apt.tool_axis.map(|axis| Orientation::ToolAxis(frames.base.rotation * axis));
    let orientation_before = axis.or(here.and_then(|here| here.orientation));
    let orientation = rotation::tool_orientation(language, target, frames, orientation_before)?;
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

/// Points that lie nearer to a circle than this are on it, mm.
const ON_CIRCLE_MM: f64 = 1e-3;
/// Cosine of the angle between INDIRV and the tangent above which they are the same direction.
const ALONG: f64 = 0.99;

/// Returns the tool axis of `orientation` in W, from tip to spindle: +z of the base of `statement` where none is given.
pub(crate) fn tool_axis(statement: &Statement, orientation: Option<Orientation>) -> Vector3<f64> {
    match orientation {
        Some(Orientation::ToolAxis(axis)) => axis,
        _ => statement.frames.base.rotation * Vector3::z(),
    }
}

/// Returns the way from `start` (mm in W) through the hole of the cycle of `statement`, whose point leads to `surface`.
fn hole(statement: &Statement, start: Vector3<f64>, surface: &ToolState) -> Hole {
    let axis = tool_axis(statement, surface.orientation);
    let Drilling { depth_mm, clear_mm, back_mm } = statement.apt.drilling.unwrap_or_default();
    let at = |height_mm: f64| surface.position + axis * height_mm;
    let over = at((start - surface.position).dot(&axis).max(clear_mm));
    Hole { start, over, clear: at(clear_mm), bottom: at(-depth_mm), back: at(back_mm), is_first: false }
}

impl AptCircle {
    /// Returns the arc of `statement` from a start to an end (mm in W) about the centre that `record` gives. `Err` if radii differ.
    pub fn arc_between(
        &self,
        statement: &Statement,
        record: &Target,
        [start, end]: [Vector3<f64>; 2],
    ) -> Result<Arc, RobotFault> {
        let frames = &statement.frames;
        let radius_mm = record.number(Component::Radius).map(|radius| radius * frames.unit_mm);
        let centre = self.centre(statement, record);
        let axis = match self.turn {
            CircleTurn::About(axis) => frames.base.rotation * axis,
            CircleTurn::Towards { direction, .. } => {
                let axis = (start - centre).cross(&(frames.base.rotation * direction));
                axis.try_normalize(f64::MIN_POSITIVE).ok_or(RobotFault::NoCircle)?
            }
        };
        let arc = Arc::about([start, end, centre], axis, radius_mm).map_err(RobotFault::Arc)?;
        match self.turn {
            CircleTurn::Towards { direction, is_second } => {
                let tangent = frames.base.rotation * direction;
                let is_plane = (end - start).dot(&axis).abs() <= ON_CIRCLE_MM;
                let is_tangent = arc.at(0.0).1.dot(&tangent) > ALONG;
                let half_turns = arc.sweep_rad() / std::f64::consts::PI;
                let is_reached = if is_second { half_turns > 0.999 } else { half_turns < 1.001 };
                if is_plane && is_tangent && is_reached { Ok(arc) } else { Err(RobotFault::NoCircle) }
            }
            CircleTurn::About(_) => Ok(arc),
        }
    }

    /// Returns the centre (mm in W) that `record` of `statement` gives.
    pub fn centre(&self, statement: &Statement, record: &Target) -> Vector3<f64> {
        let number = |axis| record.number(Component::Position(axis)).unwrap_or_default() * statement.frames.unit_mm;
        statement.frames.base.transform_point(&Vector3::new(number(0), number(1), number(2)).into()).coords
    }
}

impl Motion {
    /// Sets the tangent at the end of an SPL, of which only the points are known, by the motion behind it: in the same block the direction in
    /// which a line or circle begins, or before another SPL the mean of the directions of arrival and departure; else that of arrival stays.
    pub(crate) fn set_spline_tangent(&mut self, next: Option<&Motion>) {
        let block = |motion: &Motion| motion.statement.spline.and_then(|spline| spline.block);
        let next = next.filter(|next| block(next).is_some() && block(next) == block(self));
        let (MotionGeometry::Spline { tangent, .. }, Some(next)) = (&mut self.geometry, next) else { return };
        let (Some(start), Some(end)) = (next.start, next.end) else { return };
        let departure = match &next.geometry {
            MotionGeometry::Spline { .. } => *tangent + direction(end.position - start.position),
            geometry => geometry.at(0.0).map_or(Vector3::zeros(), |(_, tangent)| tangent),
        };
        if direction(departure) != Vector3::zeros() {
            *tangent = direction(departure);
        }
    }

    /// Returns the parameters of the ends of `pieces` pieces of the motion, from 0 to 1.
    pub fn parameters(&self, pieces: usize) -> Vec<f64> {
        match self.geometry {
            MotionGeometry::Hole(_) => Hole::parameters(pieces).collect(),
            _ => even_parameters(pieces),
        }
    }

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
    pub fn external_at(&self, t: f64) -> [Option<f64>; MAX_EXTERNAL_AXES] {
        let Some(end) = self.end else { return [None; MAX_EXTERNAL_AXES] };
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
            let (cutting, length_so_far) = match &self.geometry {
                MotionGeometry::Hole(hole) => (Hole::is_feeding_at(parameter), hole.length_to(parameter)),
                _ => (self.may_cut(), length * parameter),
            };
            points.push(PathPoint {
                position_mm,
                orientation: self.orientation_at(parameter),
                tangent,
                arc_length_mm: before_mm + length_so_far,
                cutting,
                feed_mm_per_min: self.statement.feed_mm_per_min.filter(|_| cutting),
                spindle_rev_per_min: self.statement.spindle_rev_per_min,
                tool: self.statement.tool,
                feature: None,
                load: None,
                external: self.external_at(parameter).map(Option::unwrap_or_default),
                source: PointSource { segment, parameter },
                arm: self.arm.filter(|_| parameter == 1.0),
                way: match self.geometry {
                    MotionGeometry::Arrival(_) | MotionGeometry::Unlocated => Way::Unknown,
                    MotionGeometry::Spline { .. } => Way::Curve,
                    _ if cutting => Way::Followed,
                    MotionGeometry::Hole(_) => Way::Rapid,
                    _ => Way::PointToPoint,
                },
            });
        }
    }
}
