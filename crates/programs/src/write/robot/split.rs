//! Writes the motions of robot programs: one statement where one passes all corrected points, otherwise a sequence of
//! straight motions and circles.

use std::borrow::Cow;

use nalgebra::Vector3;

use crate::{
    model::{
        MotionGeometry, Orientation, PathPoint, WRITTEN_RAD, longest_piece,
        robot::{ArmPosture, CircleTurn, Language, MotionKind, RobotFault, Target},
    },
    read::robot::{Motion, ToolState, indent, line_ending, tool_axis},
    write::robot::{DesiredPose, LastBlend, Listing, PoseFormat, WrittenPose, suffix_between},
};

/// The points of one motion, and their corrected positions and orientations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points<'a> {
    pub points: &'a [PathPoint],
    /// Corrected positions in the workpiece frame, mm.
    pub corrected: &'a [Vector3<f64>],
    pub orientations: Option<&'a [Orientation]>,
    /// How the arm stands at each point, where that is to be written; else empty.
    pub postures: &'a [Option<ArmPosture>],
}

impl Points<'_> {
    /// Returns the number of points.
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// Returns the tool orientation to write at point `k`: the corrected one, or that of the path; `None` if neither is known.
    pub(crate) fn orientation(&self, k: usize) -> Option<Orientation> {
        self.orientations.map_or(self.points[k].orientation, |orientations| Some(orientations[k]))
    }

    /// Returns where the written pose of point `k` should lead.
    pub(crate) fn goal(&self, k: usize, motion: &Motion) -> DesiredPose {
        DesiredPose {
            position: self.corrected[k],
            orientation: self.orientation(k),
            external: motion.external_at(self.points[k].source.parameter),
            arm: self.postures.get(k).copied().flatten(),
        }
    }

    /// Returns the share of the motion (0 to 1) that the points `range` cover.
    pub(crate) fn motion_share(&self, range: &std::ops::Range<usize>) -> f64 {
        let parameter = |k: usize| self.points[k].source.parameter;
        parameter(range.end - 1) - range.start.checked_sub(1).map_or(0.0, parameter)
    }

    /// Returns the commanded less the programmed tool position of point `k`, in the workpiece frame, mm.
    pub(crate) fn correction(&self, k: usize) -> Vector3<f64> {
        self.corrected[k] - self.points[k].position_mm
    }
}

/// The writer of a corrected robot program: the text written so far, and where it has led the tool.
#[derive(Debug)]
pub(crate) struct Writer<'a> {
    pub(crate) source: &'a [u8],
    pub(crate) format: PoseFormat,
    tolerance_mm: f64,
    pub(crate) out: Vec<u8>,
    /// How many bytes of the source have been copied or replaced.
    copied: usize,
    /// Bytes of the source up to which it was copied or replaced, and of what is written up to there.
    marks: Vec<[usize; 2]>,
    /// Positions that stand apart from the motions.
    listing: Option<Listing>,
    /// The blend at the end of the motion before, where the program gives it a distance that overlapping ones must not have.
    pub(crate) last_blend: Option<LastBlend>,
    /// Where the written statements have led the tool; `None` if unknown.
    tracked: Option<ToolState>,
    pieces: Vec<usize>,
    parameters: Vec<f64>,
}

/// A statement of a split motion: the intermediate pose of a circle, the end pose, and where its points lie on it, from 0 to 1.
pub(crate) struct Piece {
    pub via: Option<WrittenPose>,
    pub end: WrittenPose,
    pub parameters: Vec<f64>,
}

impl<'a> Writer<'a> {
    /// Creates a writer of the program `source` with nothing written; poses get the format `format`.
    pub fn new(source: &'a [u8], format: PoseFormat, tolerance_mm: f64) -> Self {
        let out = Vec::with_capacity(source.len());
        let listing = (format.language == Language::Ls).then(|| Listing::new(source));
        let (pieces, parameters) = (Vec::new(), Vec::new());
        Self {
            source,
            format,
            tolerance_mm,
            out,
            copied: 0,
            marks: vec![[0, 0]],
            listing,
            last_blend: None,
            tracked: None,
            pieces,
            parameters,
        }
    }

    /// Returns where the bytes `edges` of the source, none of them within what was replaced, are in what is written.
    pub fn places(&self, edges: &[usize]) -> Vec<usize> {
        let place = |edge: &usize| {
            let next = self.marks.partition_point(|[source, _]| source <= edge);
            let [source, out] = self.marks[next.saturating_sub(1)];
            out + (edge - source)
        };
        edges.iter().map(place).collect()
    }

    /// Copies the rest of the source and returns the bytes, the number of points of each motion, and where on its motion each lies.
    pub fn finish(mut self) -> (Vec<u8>, Vec<usize>, Vec<f64>) {
        match self.listing {
            Some(listing) => listing.finish(self.source, self.copied, &mut self.out),
            None => self.out.extend_from_slice(&self.source[self.copied..]),
        }
        (self.out, self.pieces, self.parameters)
    }

    /// Writes `motion` with its corrected `points`: as one statement if one passes them all, otherwise split.
    pub fn write_motion(&mut self, motion: &Motion, points: Points<'_>) -> Result<(), RobotFault> {
        let statement = &motion.statement;
        let (Some(target), Some(last)) = (&statement.end, points.len().checked_sub(1)) else {
            (self.tracked, self.last_blend) = (None, None);
            self.pieces.push(0);
            return Ok(());
        };
        let is_one = match (&motion.geometry, self.tracked) {
            (MotionGeometry::Line(..), Some(from)) => {
                let goal = points.goal(last, motion);
                let end = self.format.write_pose(statement, target, &goal, Some(&from))?.ok_or(RobotFault::NoCircle)?;
                let geometry = MotionGeometry::Line(from.position, end.state.position);
                let parameters = self.parameters(&geometry, [from, end.state], motion, points, 0..points.len());
                parameters.map(|parameters| self.write_one_statement(target, &end, parameters)).is_some()
            }
            (MotionGeometry::Hole(_), _) => {
                self.write_hole(motion, target, points)?;
                true
            }
            (MotionGeometry::Circle(arc), Some(from)) => self.write_circle(motion, arc, from, points)?,
            _ => {
                let from = self.tracked;
                let end = self.format.write_pose(statement, target, &points.goal(last, motion), from.as_ref())?;
                let end = end.ok_or(RobotFault::CircleFromNowhere)?;
                self.write_one_statement(target, &end, vec![1.0; points.len()]);
                true
            }
        };
        match is_one {
            true => self.keep_blend(statement),
            false => self.write_split(motion, points)?,
        }
        Ok(())
    }

    /// Writes a hole of a cycle of APT with its bottom where it should be; the cycle stays, and the rest of the way moves along with it.
    fn write_hole(&mut self, motion: &Motion, target: &Target, points: Points<'_>) -> Result<(), RobotFault> {
        let statement = &motion.statement;
        let (Some(drilling), Some(bottom)) = (statement.apt.drilling, points.len().checked_sub(2)) else {
            return Err(RobotFault::CircleFromNowhere);
        };
        let axis = tool_axis(statement, points.orientation(bottom));
        let position = points.corrected[bottom] + axis * drilling.depth_mm;
        let goal = DesiredPose { position, ..points.goal(bottom, motion) };
        let from = self.tracked;
        let pose = self.format.write_pose(statement, target, &goal, from.as_ref())?;
        let mut pose = pose.ok_or(RobotFault::CircleFromNowhere)?;
        pose.state.position += axis * drilling.back_mm;
        let parameters = points.points.iter().map(|point| point.source.parameter).collect();
        self.write_one_statement(target, &pose, parameters);
        Ok(())
    }

    /// Writes a motion that stays one statement, to `pose` in place of `target`, with its points at `parameters` (0 to 1).
    pub(crate) fn write_one_statement(&mut self, target: &Target, pose: &WrittenPose, parameters: Vec<f64>) {
        self.put_target(target, pose);
        self.record_points(pose.state, parameters);
    }

    /// Copies the source up to `target`, and writes `pose` in its place if that changes.
    pub(crate) fn put_target(&mut self, target: &Target, pose: &WrittenPose) {
        if pose.is_changed {
            let text = self.place(target, pose, true);
            self.out.extend_from_slice(&self.source[self.copied..target.at.start]);
            self.out.extend_from_slice(&text);
            self.copied = target.at.end;
            self.marks.push([self.copied, self.out.len()]);
        }
    }

    /// Returns the text that leads to `pose` in a motion: its numbers, or the name of the position in a listing that gets them, which is that
    /// of `target` where `is_own`, and no other motion uses it.
    fn place<'p>(&mut self, target: &Target, pose: &'p WrittenPose, is_own: bool) -> Cow<'p, [u8]> {
        match &mut self.listing {
            Some(listing) => Cow::Owned(listing.place(&self.source[target.at.clone()], pose, is_own)),
            None => Cow::Borrowed(&pose.text),
        }
    }

    /// Records that a motion to `state` with path points at `parameters` (0 to 1) has been written.
    fn record_points(&mut self, state: ToolState, parameters: Vec<f64>) {
        self.tracked = Some(state);
        self.pieces.push(parameters.len());
        self.parameters.extend(parameters);
    }

    /// Returns where on `geometry`, along which the tool turns evenly between the states `from` and `to`, the points `range` lie, from 0 to
    /// 1 in ascending order; `None` if it does not pass them within tolerance.
    pub(crate) fn parameters(
        &self,
        geometry: &MotionGeometry,
        [from, to]: [ToolState; 2],
        motion: &Motion,
        points: Points<'_>,
        range: std::ops::Range<usize>,
    ) -> Option<Vec<f64>> {
        let parameter = |k: usize| points.points[k].source.parameter;
        let start = range.start.checked_sub(1).map_or(0.0, parameter);
        let length = parameter(range.end - 1) - start;
        let unit_mm = self.format.unit_mm(&motion.statement) * (1.0 + 1e-6);
        let mut parameters = Vec::with_capacity(range.len());
        let mut passed = 0.0;
        for k in range.clone() {
            let goal = &points.corrected[k];
            let share = if length > 0.0 { (parameter(k) - start) / length } else { 1.0 };
            let error = |t: f64| Some(geometry.at(t)?.0 - goal);
            let parameter_here = if error(share)?.amax() <= unit_mm {
                share.max(passed)
            } else {
                let parameter_here = if k + 1 < range.end { nearest(geometry, goal, share).max(passed) } else { 1.0 };
                if error(parameter_here)?.norm() > self.tolerance_mm {
                    return None;
                }
                parameter_here
            };
            let here = from.orientation.zip(to.orientation).map(|(from, to)| from.towards(&to, parameter_here));
            if let (Some(_), Some(here), Some(there)) = (points.orientations, here, points.orientation(k))
                && here.angle_to(&there) > WRITTEN_RAD
            {
                return None;
            }
            passed = parameter_here;
            parameters.push(parameter_here);
        }
        *parameters.last_mut()? = 1.0;
        Some(parameters)
    }

    /// Writes a motion as a sequence of straight motions, and of circles where these pass more points.
    fn write_split(&mut self, motion: &Motion, points: Points<'_>) -> Result<(), RobotFault> {
        let statement = &motion.statement;
        let Some(target) = &statement.end else { return Ok(()) };
        let first_pose = statement.via.as_ref().unwrap_or(target).at.start;
        let (source, at) = (self.source, &statement.at);
        let keyword = &source[statement.keyword.clone()];
        let circle = statement.apt.circle.as_ref();
        let (line_keyword, before_pose) = match (statement.kind, self.format.language) {
            (MotionKind::Circle, Language::Krl) => {
                let line = if statement.spline.is_some() { b"SLIN".as_slice() } else { b"LIN" };
                (line, statement.keyword.end..first_pose)
            }
            (MotionKind::Circle, Language::Rapid) => (b"MoveL".as_slice(), statement.keyword.end..first_pose),
            (MotionKind::Circle, Language::Ls) => (b"L".as_slice(), statement.keyword.end..first_pose),
            (MotionKind::Circle, Language::UrScript) => (b"movel".as_slice(), statement.keyword.end..first_pose),
            // The end stands within the words of a circle.
            _ if circle.is_some_and(|circle| matches!(circle.turn, CircleTurn::Towards { .. })) => {
                (b"GOTO/".as_slice(), first_pose..first_pose)
            }
            _ => (keyword, statement.keyword.end..first_pose),
        };
        let prefix = match &mut self.listing {
            Some(listing) => listing.prefix(source, at.start),
            None => indent(source, at.start).0,
        };
        let leading = circle.map_or(at.start..at.start, |circle| circle.leading.clone());
        self.out.extend_from_slice(&source[self.copied..leading.start]);
        self.out.extend_from_slice(&source[leading.end..at.start]);
        // Behind the first piece the tool axis is that of the one before, whatever a record said.
        let without_axis = || {
            let mut motion = motion.clone();
            motion.statement.apt.tool_axis = None;
            motion
        };
        let behind_first = statement.apt.tool_axis.is_some().then(without_axis);
        let (mut pieces, mut lengths_mm, mut next) = (Vec::new(), Vec::new(), 0);
        while next < points.len() {
            let from = self.tracked.ok_or(RobotFault::CircleFromNowhere)?.position;
            let motion = behind_first.as_ref().filter(|_| next > 0).unwrap_or(motion);
            let mut piece = self.longest(motion, target, points, next)?;
            next += piece.parameters.len();
            lengths_mm.push((piece.end.state.position - from).norm());
            self.record_points(piece.end.state, std::mem::take(&mut piece.parameters));
            pieces.push(piece);
        }
        self.shorten_blend_before(at.start, lengths_mm[0]);
        for (k, piece) in pieces.iter().enumerate() {
            let is_line = piece.via.is_none();
            self.out.extend_from_slice(if is_line { line_keyword } else { keyword });
            self.out.extend_from_slice(&source[before_pose.clone()]);
            if let (Some(pose), Some(via)) = (&piece.via, &statement.via) {
                let text = self.place(via, pose, false);
                self.out.extend_from_slice(&text);
                self.out.extend_from_slice(&source[via.at.end..target.at.start]);
            }
            let following_mm = lengths_mm.get(k + 1);
            let text = self.place(target, &piece.end, following_mm.is_none());
            self.out.extend_from_slice(&text);
            let Some(following_mm) = following_mm else {
                let suffix = self.end_suffix(statement, lengths_mm[k], is_line);
                self.out.extend_from_slice(&suffix);
                break;
            };
            let room_mm = lengths_mm[k].min(*following_mm);
            let suffix = suffix_between(self.format.language, source, statement, room_mm, is_line);
            self.out.extend_from_slice(&suffix);
            self.out.extend_from_slice(line_ending(source));
            self.out.extend_from_slice(prefix);
            if let Some(listing) = &mut self.listing {
                listing.added_lines += 1;
            }
        }
        self.copied = at.end;
        self.marks.push([self.copied, self.out.len()]);
        Ok(())
    }

    /// Returns the piece that passes the most points from `first` on; a line to the first point always passes one.
    fn longest(&self, motion: &Motion, target: &Target, points: Points<'_>, first: usize) -> Result<Piece, RobotFault> {
        let from = self.tracked.ok_or(RobotFault::CircleFromNowhere)?;
        let most = if self.tolerance_mm > 0.0 { points.len() - first } else { 1 };
        let pose = |k: usize| {
            let end = self.format.write_pose(&motion.statement, target, &points.goal(k, motion), Some(&from))?;
            end.ok_or(RobotFault::CircleFromNowhere)
        };
        let attempt = |count: usize| -> Result<Option<Piece>, RobotFault> {
            let end = pose(first + count - 1)?;
            let geometry = MotionGeometry::Line(from.position, end.state.position);
            let parameters = self.parameters(&geometry, [from, end.state], motion, points, first..first + count);
            Ok(parameters.map(|parameters| Piece { via: None, end, parameters }))
        };
        let mut best = longest_piece(Piece { via: None, end: pose(first)?, parameters: vec![1.0] }, most, attempt)?;
        if let Some(arc) = self.longest_arc(motion, target, from, points, first..first + most)?
            && arc.parameters.len() > best.parameters.len()
        {
            best = arc;
        }
        Ok(best)
    }
}

/// Returns the parameter (0 to 1) at which `geometry` passes nearest to `goal` (mm); on a circle, the one next to `guess`.
fn nearest(geometry: &MotionGeometry, goal: &Vector3<f64>, guess: f64) -> f64 {
    match geometry {
        MotionGeometry::Line(start, end) => {
            let along = end - start;
            let share = (goal - start).dot(&along) / along.norm_squared();
            if share.is_finite() { share.clamp(0.0, 1.0) } else { guess }
        }
        MotionGeometry::Circle(arc) => arc.nearest(goal, guess),
        _ => 1.0,
    }
}
