//! KRL lines that set a mode: bases, tools, velocity, variables.

use std::ops::Range;

use crate::{
    model::robot::RobotFault,
    read::{
        robot::{
            Base, Tool, check_index,
            krl::{FIXED_TOOL, Reader, frame},
            trimmed,
        },
        scan::Scan,
    },
};

/// 1 m/s in mm/min.
pub(crate) const PER_METRE_PER_SECOND: f64 = 60_000.0;

/// LocatedFault of orientations that go another way than the shortest.
pub(crate) const TURNING_UNEVENLY: RobotFault = RobotFault::NotFollowed {
    what: "orientations that do not turn evenly along a motion ($ORI_TYPE) are",
    expected: "#VAR",
};

const FRAME_VALUE: RobotFault = RobotFault::Form {
    expected: "{X …, Y …, Z …, A …, B …, C …}, base_data[n], tool_data[n], a declared frame, $NULLFRAME or $WORLD",
};

impl Reader<'_> {
    /// Follows a line that begins with no keyword: an assignment, a call or a label.
    pub(crate) fn assignment_or_call(&mut self, code: Range<usize>) -> Result<(), RobotFault> {
        let text = &self.source[code.clone()];
        let mut scan = Scan::new(text);
        let name = variable_name(&mut scan)?;
        if scan.takes(b'=') {
            let value = trimmed(self.source, code.start + scan.at..code.end);
            return self.assign(name, value);
        }
        if scan.takes(b'(') {
            return self.options.check_call(&name);
        }
        // A label.
        if scan.takes(b':') && scan.is_done() {
            Ok(())
        } else {
            Err(RobotFault::Unknown { expected: "a statement of KRL" })
        }
    }

    /// Follows the assignment of the bytes `value` to `name` (upper case).
    fn assign(&mut self, name: String, value: Range<usize>) -> Result<(), RobotFault> {
        let text = &self.source[value.clone()];
        let is = |word: &str| text.eq_ignore_ascii_case(word.as_bytes());
        match name.as_str() {
            "$BASE" | "$TOOL" => {
                self.check_runs_once()?;
                let (frame_name, frame) = self.frame_value(text)?;
                match name.as_str() {
                    "$BASE" => self.set_base(Base { name: frame_name, in_world: frame }),
                    _ => self.set_tool(Tool { name: frame_name, in_flange: frame }),
                }
            }
            "$VEL.CP" => {
                let speed = Scan::new(text).number().ok().filter(|(_, at)| at.end == text.len());
                self.set_speed(speed.map(|(speed, _)| speed));
            }
            "$VEL" => self.set_speed(None),
            "$IPO_MODE" if !is("#BASE") => return Err(FIXED_TOOL),
            _ if ["$ROBROOT", "$WORLD", "$ERSYSROOT", "$NULLFRAME"].iter().any(|frame| name.starts_with(frame)) => {
                return RobotFault::not_followed("places of the robot that are set are", "$BASE and $TOOL");
            }
            "$ORI_TYPE" if !is("#VAR") => return Err(TURNING_UNEVENLY),
            _ if name.starts_with("$SPL_") => {
                return RobotFault::not_followed("data that change splines ($SPL_…) are", "none");
            }
            _ if name.starts_with("$CIRC_MODE") => {
                return RobotFault::not_followed(
                    "data that say how circles turn the tool ($CIRC_MODE) are",
                    "WITH behind SCIRC",
                );
            }
            "$CIRC_TYPE" if !is("#BASE") => self.circ_type_line = Some(self.lines.line),
            // A branch may not have run.
            "$CIRC_TYPE" if self.enclosing.is_empty() => self.circ_type_line = None,
            "$CIRC_TYPE" => {}
            "LDAT_ACT" => self.follow_motion_data(text)?,
            "FDAT_ACT" => {
                self.check_runs_once()?;
                let data = match text.starts_with(b"{") {
                    true => Some(text),
                    false => self.points.find(&String::from_utf8_lossy(text).to_ascii_uppercase())?,
                };
                let data = data.ok_or_else(|| self.points.missing_point(&String::from_utf8_lossy(text)))?;
                self.frame_data = frame::frame_numbers(data)?;
            }
            _ if ["$BASE.", "$TOOL.", "$BASE_C", "FDAT_ACT.", "LDAT_ACT."]
                .iter()
                .any(|part| name.starts_with(part)) =>
            {
                return RobotFault::not_followed("parts of frames and of motion data are", "whole ones");
            }
            _ if name.starts_with('$') => {}
            _ => {
                let runs_once = self.enclosing.is_empty();
                self.points.assign(name, value, self.lines.line, runs_once);
            }
        }
        Ok(())
    }

    /// Follows the data of a motion, by which inline forms set how the tool turns.
    fn follow_motion_data(&mut self, text: &[u8]) -> Result<(), RobotFault> {
        let data = match text.starts_with(b"{") {
            true => Some(text),
            false => self.points.find(&String::from_utf8_lossy(text).to_ascii_uppercase())?,
        };
        let data = String::from_utf8_lossy(data.unwrap_or_default()).to_ascii_uppercase();
        if word_behind(&data, "ORI_TYP").is_some_and(|word| word != "#VAR") {
            return RobotFault::not_followed(
                "orientations that do not turn evenly along a motion (ORI_TYP) are",
                "#VAR",
            );
        }
        if word_behind(&data, "CIRC_TYP").is_some_and(|word| word != "#BASE") {
            self.circ_type_line = Some(self.lines.line);
        }
        Ok(())
    }

    /// Returns the name and pose (mm, in its parent) of the frame that `text` names or gives; no pose if only the controller knows it.
    pub(crate) fn frame_value(&self, text: &[u8]) -> Result<(String, Option<nalgebra::Isometry3<f64>>), RobotFault> {
        let mut scan = Scan::new(text);
        if scan.peek() == Some(b'{') {
            let braces = frame::brace_span(&mut scan, text)?;
            let name = String::from_utf8_lossy(&text[braces.clone()]).into_owned();
            return if scan.is_done() {
                Ok((name, Some(frame::parse_frame(&text[braces])?)))
            } else {
                Err(FRAME_VALUE)
            };
        }
        // In brackets: one frame in another.
        if scan.next() == Some(b'(') {
            return Err(FRAME_VALUE);
        }
        let name = variable_name(&mut scan)?;
        if matches!(name.as_str(), "EK" | "EB") && scan.takes(b'(') {
            return RobotFault::not_followed(
                "bases that move with external axes (EK, EB) are",
                "a base that stands still",
            );
        }
        if !scan.is_done() {
            return Err(FRAME_VALUE);
        }
        match name.as_str() {
            "$NULLFRAME" | "$WORLD" => return Ok((name.to_ascii_lowercase(), Some(nalgebra::Isometry3::identity()))),
            _ if name.starts_with('$') => return Err(FRAME_VALUE),
            _ => {}
        }
        let written = self.points.find(&name)?;
        let is_data = name.starts_with("BASE_DATA[") || name.starts_with("TOOL_DATA[");
        check_index(&name, '[', ']')?;
        match written {
            Some(written) => Ok((name.to_ascii_lowercase(), Some(frame::parse_frame(written)?))),
            None if is_data => Ok((name.to_ascii_lowercase(), None)),
            None => Err(self.points.missing_point(&name)),
        }
    }

    /// Follows `BAS(#…, …)`, by which inline forms set velocity, tool and base.
    pub(crate) fn follow_bas(&mut self, mut scan: Scan<'_>) -> Result<(), RobotFault> {
        scan.expect(b'(', "(")?;
        scan.expect(b'#', "# and a word")?;
        let word = scan.name().0.to_ascii_uppercase();
        let value = if scan.takes(b',') { scan.number().ok().map(|(value, _)| value) } else { None };
        let index = value.filter(|value| *value >= 0.0 && value.fract() == 0.0).map(|value| value as usize);
        match word.as_str() {
            "VEL_CP" => self.set_speed(value),
            "CP_PARAMS" => {
                self.set_speed(value);
                let frames = self.frame_data;
                self.set_frames(frames)?;
            }
            "PTP_PARAMS" | "FRAMES" => {
                let frames = self.frame_data;
                self.set_frames(frames)?;
            }
            "TOOL" | "BASE" if index.is_none() => {
                return Err(RobotFault::Form { expected: "the number of the tool or base" });
            }
            "TOOL" => self.set_frames([index, None])?,
            "BASE" => self.set_frames([None, index])?,
            "EX_BASE" => {
                return RobotFault::not_followed("bases that move are", "a base that stands still");
            }
            _ => {}
        }
        Ok(())
    }

    /// Sets the feed from a speed in m/s; `None`, or a line within a branch or loop, makes it unknown.
    fn set_speed(&mut self, metres_per_second: Option<f64>) {
        let speed = metres_per_second.filter(|speed| *speed > 0.0 && self.enclosing.is_empty());
        self.feed_mm_per_min = speed.map(|speed| speed * PER_METRE_PER_SECOND);
    }

    /// Sets tool and base by their numbers; `None` changes nothing.
    fn set_frames(&mut self, [tool, base]: [Option<usize>; 2]) -> Result<(), RobotFault> {
        if tool.is_some() || base.is_some() {
            self.check_runs_once()?;
        }
        let tool = tool.map(|number| self.numbered_frame("TOOL_DATA", number)).transpose()?;
        let base = base.map(|number| self.numbered_frame("BASE_DATA", number)).transpose()?;
        if let Some((name, in_flange)) = tool {
            self.set_tool(Tool { name, in_flange });
        }
        if let Some((name, in_world)) = base {
            self.set_base(Base { name, in_world });
        }
        Ok(())
    }

    /// Sets the base in force.
    fn set_base(&mut self, base: Base) {
        (self.base, self.left_frames[0]) = (Some(base), false);
    }

    /// Sets the tool in force.
    fn set_tool(&mut self, tool: Tool) {
        (self.tool, self.left_frames[1]) = (Some(tool), false);
    }

    /// Returns the name and pose of a tool or base (`kind`) by its number; 0 is the flange or the world.
    pub(crate) fn numbered_frame(
        &self,
        kind: &str,
        number: usize,
    ) -> Result<(String, Option<nalgebra::Isometry3<f64>>), RobotFault> {
        match number {
            0 => Ok(("$nullframe".to_owned(), Some(nalgebra::Isometry3::identity()))),
            _ => self.frame_value(format!("{kind}[{number}]").as_bytes()),
        }
    }
}

/// Returns the word behind `key` in `data`, both in upper case, empty where another sign follows; `None` without the key.
pub(crate) fn word_behind<'a>(data: &'a str, key: &str) -> Option<&'a str> {
    let (_, behind) = data.split_once(key)?;
    behind.trim_start().split(|own: char| !own.is_ascii_alphanumeric() && !matches!(own, '#' | '_')).next()
}

/// Takes a variable with indices and parts, and returns it in upper case without blanks: `XP[3]`, `$VEL.CP`.
pub(crate) fn variable_name(scan: &mut Scan<'_>) -> Result<String, RobotFault> {
    let mut name = scan.name().0.to_ascii_uppercase();
    if name.is_empty() {
        return Err(RobotFault::Unknown { expected: "a statement of KRL" });
    }
    loop {
        if scan.takes(b'[') {
            let index = scan.rest();
            let length = index.iter().position(|byte| *byte == b']');
            let length = length.ok_or(RobotFault::Form { expected: "] on the same line" })?;
            let is_not_blank = |byte: &&u8| !byte.is_ascii_whitespace();
            let inside: Vec<u8> = index[..length].iter().filter(is_not_blank).copied().collect();
            name += &format!("[{}]", String::from_utf8_lossy(&inside).to_ascii_uppercase());
            scan.at += length + 1;
        } else if scan.takes(b'.') {
            name += &format!(".{}", scan.name().0.to_ascii_uppercase());
        } else {
            return Ok(name);
        }
    }
}
