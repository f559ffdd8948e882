//! Statements followed one after another: where each leads in the workpiece frame, and on which way.

use nalgebra::Vector3;

use crate::{
    machine::ExternalAxes,
    toolpath::model::{
        MAX_COORDINATE_MM, Orientation, PathPoint, PointSource, Sampling, Way,
        robot::{Arc, Component, Kind, Language, RobotFault, Statement, Target, rotation},
    },
};

/// Where the tool stands, in the workpiece frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stand {
    /// mm.
    pub position: Vector3<f64>,
    pub orientation: Option<Orientation>,
    /// External axes, mm or degrees, those that are known.
    pub external: [Option<f64>; ExternalAxes::MOST],
}

/// A statement and where it leads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    pub statement: Statement,
    /// Where it begins, if that is known.
    pub start: Option<Stand>,
    pub end: Option<Stand>,
    pub way: Way,
}

/// A feed above any machine is none.
const MOST_FEED_MM_PER_MIN: f64 = 1e9;
/// A spindle speed above any machine is none.
const MOST_REV_PER_MIN: f64 = 1e9;

/// What of statements before is in force.
#[derive(Debug)]
pub(crate) struct Follower {
    language: Language,
    /// External axes that are named, the first ones.
    named_axes: usize,
    here: Option<Stand>,
    /// Where external axes were first.
    external: [Option<f64>; ExternalAxes::MOST],
}

impl Follower {
    pub fn new(language: Language, named_axes: usize) -> Self {
        Self { language, named_axes, here: None, external: [None; ExternalAxes::MOST] }
    }

    pub fn follow(&mut self, mut statement: Statement) -> Result<Motion, RobotFault> {
        statement.feed_mm_per_min = statement.feed_mm_per_min.filter(|feed| *feed <= MOST_FEED_MM_PER_MIN);
        statement.spindle_rev_per_min = statement.spindle_rev_per_min.filter(|speed| *speed <= MOST_REV_PER_MIN);
        let start = self.here;
        let end = match &statement.end {
            Some(target) => lead(self.language, &statement, target, start.as_ref())?,
            None => None,
        };
        if let Some(end) = &end {
            self.check_external(end)?;
        }
        let way = match (statement.kind, &start, &end) {
            (_, _, None) => Way::Unlocated,
            (Kind::Line, Some(start), Some(end)) => Way::Line(start.position, end.position),
            (Kind::Circle, Some(start), Some(end)) => self.arc(&statement, start, end)?,
            (Kind::Circle, None, Some(_)) => return Err(RobotFault::CircleFromNowhere),
            (_, _, Some(end)) => Way::Arrival(end.position),
        };
        // A circle may end where its angle says.
        let end = end.map(|end| Stand { position: way.at(1.0).map_or(end.position, |(position, _)| position), ..end });
        if end.is_some_and(|end| end.position.amax() > MAX_COORDINATE_MM) {
            return Err(RobotFault::TooFar);
        }
        self.here = end;
        Ok(Motion { statement, start, end, way })
    }

    fn arc(&self, statement: &Statement, start: &Stand, end: &Stand) -> Result<Way, RobotFault> {
        let via = match &statement.via {
            Some(via) => lead(self.language, statement, via, Some(start))?,
            None => None,
        };
        let via = via.ok_or(RobotFault::NoCircle)?.position;
        let arc = Arc::through([start.position, via, end.position], statement.sweep_rad);
        Ok(Way::Circle(arc.ok_or(RobotFault::NoCircle)?))
    }

    /// Axes with names must be known, the others must stand still.
    fn check_external(&mut self, end: &Stand) -> Result<(), RobotFault> {
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

/// Where `target` of `statement` leads from `here`; `None` if that is not known.
pub(crate) fn lead(
    language: Language,
    statement: &Statement,
    target: &Target,
    here: Option<&Stand>,
) -> Result<Option<Stand>, RobotFault> {
    let frames = &statement.frames;
    let before = here.map(|here| frames.base.inverse_transform_point(&here.position.into()));
    let coordinate = |axis: usize| match (target.number(Component::Position(axis)), statement.is_step) {
        (Some(value), false) => Some(value * frames.unit_mm),
        (Some(step), true) => Some(before?[axis] + step * frames.unit_mm),
        (None, _) => Some(before?[axis]),
    };
    let orientation = rotation::orientation(language, target, frames, here.and_then(|here| here.orientation))?;
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
    Ok(Some(Stand { position, orientation, external }))
}

impl Motion {
    /// Whether the tool may cut on the way.
    pub fn may_cut(&self) -> bool {
        self.statement.kind != Kind::PointToPoint
    }

    /// How the tool stands at `t` from 0 to 1.
    pub fn orientation_at(&self, t: f64) -> Option<Orientation> {
        let end = self.end?.orientation?;
        match self.start.and_then(|start| start.orientation) {
            Some(start) if t < 1.0 => Some(start.towards(&end, t)),
            _ => Some(end),
        }
    }

    /// Where the external axes stand at `t` from 0 to 1.
    pub fn external_at(&self, t: f64) -> [Option<f64>; ExternalAxes::MOST] {
        let Some(end) = self.end else { return [None; ExternalAxes::MOST] };
        std::array::from_fn(|axis| match self.start.and_then(|start| start.external[axis]) {
            Some(start) if t < 1.0 => end.external[axis].map(|end| start + (end - start) * t),
            _ => end.external[axis],
        })
    }

    fn turn_rad(&self) -> f64 {
        let start = self.start.and_then(|start| start.orientation);
        start.zip(self.end.and_then(|end| end.orientation)).map_or(0.0, |(start, end)| start.angle_to(&end))
    }

    /// Into how many pieces the motion is split; `None` when into more than a path may have points. A motion from point
    /// to point is never split: nothing says on which way it goes.
    pub fn pieces(&self, sampling: Sampling) -> Option<usize> {
        self.way.pieces(sampling, self.turn_rad())
    }

    /// Adds the points of the motion at `parameters` to `points`; `segment` is its index in the program, `before_mm`
    /// the length of the path before it.
    pub fn sample(&self, segment: usize, parameters: &[f64], before_mm: f64, points: &mut Vec<PathPoint>) {
        let length = self.way.length();
        for &parameter in parameters {
            let Some((position_mm, tangent)) = self.way.at(parameter) else { return };
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
