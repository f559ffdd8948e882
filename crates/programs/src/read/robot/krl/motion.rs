//! Motions of KRL: `LIN {…} C_DIS`, `CIRC {…},{…}, CA 90`, `PTP XP1`, `LIN_REL {Z 5}`.

use std::ops::Range;

use crate::{
    model::robot::{Component, Frames, MotionKind, RobotFault, Statement, Target},
    read::{
        robot::{
            krl::{
                Reader, frame,
                spline::{Settings, takes_approximation},
                state::variable_name,
            },
            trimmed,
        },
        scan::Scan,
    },
};

/// Destination of a motion.
enum Waypoint {
    /// A pose.
    To(Target),
    /// Joint positions (rad), or a point that the program does not give.
    Unknown(Option<[f32; 6]>),
    /// The present position.
    Here,
}

impl Reader<'_> {
    /// Returns the statement of the motion `word` in the bytes `code`; `None` if it stays where the robot is.
    pub(crate) fn motion(&mut self, word: &str, code: Range<usize>) -> Result<Option<Statement>, RobotFault> {
        let is_spline = word.starts_with('S');
        let (kind, is_step) = motion_kind(word)?;
        self.check_runs_once()?;
        if let Some(end) = self.end_line {
            return Err(RobotFault::AfterEnd { end });
        }
        let text = &self.source[code.clone()];
        let mut scan = Scan::new(text);
        let (_, keyword) = scan.name();
        let via = match kind {
            MotionKind::Circle => {
                let Waypoint::To(via) = self.waypoint(kind, &mut scan, text, code.start)? else {
                    return Err(RobotFault::Form { expected: "a point on the circle" });
                };
                scan.expect(b',', ", and the end of the circle")?;
                Some(via)
            }
            _ => None,
        };
        let mut joints = None;
        let end = match self.waypoint(kind, &mut scan, text, code.start)? {
            Waypoint::To(target) => Some(target),
            Waypoint::Unknown(angles) => {
                joints = angles;
                None
            }
            Waypoint::Here => {
                while takes_approximation(&mut scan) {}
                let stays = matches!(kind, MotionKind::Line | MotionKind::PointToPoint) && !is_step;
                if stays && scan.is_done() && self.block.is_none() {
                    return Ok(None);
                }
                return Err(RobotFault::Form { expected: "a point, as where the robot is is not known before" });
            }
        };
        let is_angle_next = kind == MotionKind::Circle && scan.takes(b',');
        let sweep_rad = if is_angle_next { Some(circle_angle(&mut scan)?) } else { None };
        let pose_end = end.as_ref().map_or(code.end, |end| end.at.end);
        let suffix = if is_angle_next { code.start + scan.at } else { pose_end }..code.end;
        let (settings, in_tool) = match is_spline {
            true => (self.spline_settings(&mut scan, end.is_some())?, false),
            false => (Settings::default(), is_in_tool_axes(scan)?),
        };
        if is_step {
            check_step(end.as_ref(), in_tool)?;
        }
        if kind == MotionKind::Circle && self.carries_orientation(&settings) {
            return RobotFault::not_followed(
                "circles that carry the orientation along ($CIRC_TYPE) are",
                "$CIRC_TYPE=#BASE before it",
            );
        }
        let end = end.map(|end| if is_step { without_rotation(end) } else { end });
        let frames = match &end {
            Some(_) => {
                self.check_frames_known(&settings)?;
                Frames {
                    base: self.bases.pose(settings.base.as_ref().or(self.base.as_ref()))?,
                    tool: self.tools.rotation(settings.tool.as_ref().or(self.tool.as_ref()))?,
                    unit_mm: 1.0,
                }
            }
            None => Frames::default(),
        };
        if is_spline && self.block.is_none() {
            self.leave(&settings);
        }
        let keyword = code.start + keyword.start..code.start + keyword.end;
        Ok(Some(Statement {
            suffix,
            via,
            end,
            sweep_rad,
            is_step,
            frames,
            feed_mm_per_min: settings.feed_mm_per_min.unwrap_or(self.feed_mm_per_min),
            spline: is_spline.then(|| self.spline_motion(&settings)),
            joints,
            ..Statement::new(code, self.lines.line, keyword, kind)
        }))
    }

    /// Takes the next point of `text`, which begins at byte `start` of the source, and returns where it leads.
    fn waypoint(
        &self,
        kind: MotionKind,
        scan: &mut Scan<'_>,
        text: &[u8],
        start: usize,
    ) -> Result<Waypoint, RobotFault> {
        let from = scan.skip_blanks().at;
        let written: &[u8] = match scan.peek() {
            Some(b'{') => {
                let braces = frame::brace_span(scan, text)?;
                &text[braces]
            }
            _ => {
                let name = variable_name(scan).map_err(|_| RobotFault::Form { expected: "a point" })?;
                match self.points.find(&name)? {
                    Some(written) => written,
                    None if matches!(name.as_str(), "$AXIS_ACT" | "$POS_ACT") => return Ok(Waypoint::Here),
                    None if kind == MotionKind::PointToPoint => {
                        return if has_operator(*scan) { Err(OPERATOR) } else { Ok(Waypoint::Unknown(None)) };
                    }
                    None => return Err(self.points.missing_point(&name)),
                }
            }
        };
        if has_operator(*scan) {
            return Err(OPERATOR);
        }
        match (frame::parse_point(written)?, kind) {
            (frame::Value::Pose(numbers), _) => {
                let at = trimmed(self.source, start + from..start + scan.at);
                Ok(Waypoint::To(Target { at, text: written.to_vec(), numbers }))
            }
            (frame::Value::Joints(angles), MotionKind::PointToPoint) => Ok(Waypoint::Unknown(Some(angles))),
            (frame::Value::Joints(_), _) => Err(RobotFault::Form { expected: "a pose, not positions of joints" }),
        }
    }
}

/// Returns the kind of the motion `word`, and whether it goes by steps.
fn motion_kind(word: &str) -> Result<(MotionKind, bool), RobotFault> {
    match word {
        "LIN" | "SLIN" => Ok((MotionKind::Line, false)),
        "LIN_REL" => Ok((MotionKind::Line, true)),
        "PTP" | "SPTP" => Ok((MotionKind::PointToPoint, false)),
        "PTP_REL" => Ok((MotionKind::PointToPoint, true)),
        "CIRC" | "SCIRC" => Ok((MotionKind::Circle, false)),
        "CIRC_REL" => RobotFault::not_followed("circles by steps are", "CIRC"),
        "SPL" => Ok((MotionKind::Spline, false)),
        _ => RobotFault::not_followed("spline motions by steps are", "SLIN, SCIRC, SPTP and SPL to points"),
    }
}

/// LocatedFault of an operator on points.
const OPERATOR: RobotFault =
    RobotFault::NotFollowed { what: "operators on points are", expected: "a point whose numbers the file gives" };

/// Whether an operator follows the point.
fn has_operator(mut scan: Scan<'_>) -> bool {
    scan.is_in_expression()
}

/// Takes `CA 90` or `CA=90` (degrees); returns the angle of the circle, rad, negative against the direction to its via point.
fn circle_angle(scan: &mut Scan<'_>) -> Result<f64, RobotFault> {
    let fault = RobotFault::Form { expected: "CA and the angle of the circle, not 0 and at most 36000" };
    if !scan.name().0.eq_ignore_ascii_case("CA") {
        return Err(fault);
    }
    scan.takes(b'=');
    let (degrees, _) = scan.number()?;
    if degrees == 0.0 || degrees.abs() > MAX_DEGREES { Err(fault) } else { Ok(degrees.to_radians()) }
}

/// Largest angle of a circle: a hundred revolutions.
const MAX_DEGREES: f64 = 36_000.0;

/// Takes the modes behind the last point; returns whether `#TOOL`, the axes of the tool, is among them.
fn is_in_tool_axes(mut scan: Scan<'_>) -> Result<bool, RobotFault> {
    let mut in_tool = false;
    while !scan.is_done() {
        let is_mode = scan.takes(b'#');
        let (word, _) = scan.name();
        match word.to_ascii_uppercase().as_str() {
            "C_DIS" | "C_VEL" | "C_ORI" | "C_PTP" | "C_SPL" if !is_mode => {}
            "BASE" if is_mode => {}
            "TOOL" if is_mode => in_tool = true,
            _ => {
                return Err(RobotFault::Form { expected: "C_DIS, C_VEL, C_ORI or C_PTP behind the point, or nothing" });
            }
        }
    }
    Ok(in_tool)
}

/// Refuses a step to `end` along the axes of the tool, or one that turns the tool or moves external axes.
fn check_step(end: Option<&Target>, in_tool: bool) -> Result<(), RobotFault> {
    let turns =
        |target: &Target| (0..3).any(|angle| target.number(Component::Rotation(angle)).is_some_and(|a| a != 0.0));
    let moves_axes = |target: &Target| target.numbers.iter().any(|n| matches!(n.component, Component::External(_)));
    if in_tool || end.is_some_and(|end| turns(end) || moves_axes(end)) {
        return RobotFault::not_followed(
            "steps along the axes of the tool, turns and external axes by steps are",
            "steps of X, Y and Z in the base",
        );
    }
    Ok(())
}

/// Returns a step without its angles, which are all 0, so that it keeps the orientation.
fn without_rotation(mut target: Target) -> Target {
    target.numbers.retain(|number| !matches!(number.component, Component::Rotation(_)));
    target
}
