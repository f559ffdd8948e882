//! Spline motions of KRL: SLIN, SCIRC and SPTP, blocks of SPLINE with SPL, SLIN and SCIRC, and what is set by WITH.
//!
//! KUKA, *Operating and Programming Instructions for System Integrators* (KSS 8.3), spline motions: SLIN and SCIRC are lines and circles also
//! in blocks, where the robot stops at corners between them; how SPL leads through its points depends on the points around, and is not published.
//! What WITH sets is that of its motion or block alone. What the functions of inline forms return is that of `bas.src` of KSS 8.6.

use std::ops::Range;

use crate::{
    model::robot::{RobotFault, SplineMotion, Statement},
    read::{
        robot::{
            Base, Tool, ToolState,
            krl::{
                FIXED_TOOL, Reader, frame,
                state::{PER_METRE_PER_SECOND, TURNING_UNEVENLY, variable_name, word_behind},
            },
        },
        scan::Scan,
    },
};

/// Functions by which inline forms set what they say behind WITH. They only compute.
const INLINE_FORMS: &str = "SVEL_CP SVEL_JOINT STOOL2 SBASE SIPO_MODE SLOAD SACC_CP SACC_JOINT SAPO SAPO_PTP SORI_TYP SCIRC_TYP SCIRC_M \
                            SJERK SGEAR_JERK USE_CM_PRO_VALUES";
/// Data behind WITH that change neither where a motion leads nor its feed.
const HARMLESS: &str =
    "$ACC $ACC_AXIS $ACC_EXTAX $VEL_AXIS $VEL_EXTAX $APO $JERK $GEAR_JERK $LOAD $ECO_LEVEL $COLLMON_TOL_PRO";

const FRAMES_BEHIND_WITH: RobotFault = RobotFault::NotFollowed {
    what: "motions without $BASE and $TOOL of their own behind one that has other ones (WITH) are",
    expected: "$BASE and $TOOL for all",
};

/// Whether `name` (upper case) is a function that inline forms of spline motions use.
pub(crate) fn is_of_inline_forms(name: &str) -> bool {
    INLINE_FORMS.split_whitespace().any(|known| known == name)
}

/// Refuses a line that begins with `word` (upper case) within a block of SPLINE (`is_open`), or outside, where it does not belong.
pub(crate) fn check_in_block(word: &str, is_open: bool) -> Result<(), RobotFault> {
    match (word, is_open) {
        ("SPL" | "SLIN" | "SCIRC" | "TRIGGER" | "ENDSPLINE", true) => Ok(()),
        ("PTP_SPLINE", _) => {
            RobotFault::not_followed("splines of joints (PTP_SPLINE) are", "SPLINE, or SPTP by itself")
        }
        ("SPL" | "ENDSPLINE", false) => Err(RobotFault::Form { expected: "SPLINE before it" }),
        (_, false) => Ok(()),
        ("TIME_BLOCK" | "CONST_VEL" | "STOP", true) => {
            RobotFault::not_followed("times, constant velocities and stops within SPLINE are", "segments alone")
        }
        (_, true) => RobotFault::not_followed("statements within SPLINE are", "SPL, SLIN, SCIRC and ENDSPLINE"),
    }
}

/// A datum that WITH sets: its name (upper case), where its part is in the text, and its value.
#[derive(Clone, Debug)]
pub(crate) struct WithPart<'a> {
    pub name: String,
    pub at: Range<usize>,
    value: &'a [u8],
}

/// Takes `WITH $VEL.CP=0.05,$BASE=BASE_DATA[2]` and returns its parts; none if something else comes next.
pub(crate) fn with_parts<'a>(scan: &mut Scan<'a>) -> Result<Vec<WithPart<'a>>, RobotFault> {
    let (mut ahead, mut parts) = (*scan, Vec::new());
    if !ahead.name().0.eq_ignore_ascii_case("WITH") {
        return Ok(parts);
    }
    *scan = ahead;
    loop {
        let start = scan.skip_blanks().at;
        let name = variable_name(scan)?;
        scan.expect(b'=', "= and a value behind each name of WITH")?;
        let value = with_value(scan)?;
        parts.push(WithPart { name, at: start..start + scan.line[start..scan.at].trim_ascii_end().len(), value });
        if !scan.takes(b',') {
            return Ok(parts);
        }
    }
}

/// Takes a value up to the next comma outside of brackets, or to an approximation.
fn with_value<'a>(scan: &mut Scan<'a>) -> Result<&'a [u8], RobotFault> {
    let fault = RobotFault::Form { expected: "a value with its brackets behind each = of WITH" };
    let (start, mut depth) = (scan.skip_blanks().at, 0usize);
    while let Some(byte) = scan.peek() {
        match byte {
            b'(' | b'{' | b'[' => depth += 1,
            b')' | b'}' | b']' => depth = depth.checked_sub(1).ok_or_else(|| fault.clone())?,
            b',' if depth == 0 => break,
            b' ' | b'\t' if depth == 0 && takes_approximation(&mut scan.clone()) => break,
            _ => {}
        }
        scan.at += 1;
    }
    let value = scan.line[start..scan.at].trim_ascii_end();
    if depth > 0 || value.is_empty() { Err(fault) } else { Ok(value) }
}

/// Takes an approximation, if one comes next.
pub(crate) fn takes_approximation(scan: &mut Scan<'_>) -> bool {
    let mut ahead = *scan;
    let word = ahead.name().0.to_ascii_uppercase();
    let is_taken = matches!(word.as_str(), "C_SPL" | "C_DIS" | "C_VEL" | "C_ORI" | "C_PTP");
    if is_taken {
        *scan = ahead;
    }
    is_taken
}

/// What WITH sets for a motion, or for the segments of a block.
#[derive(Clone, Debug, Default)]
pub(crate) struct Settings {
    pub base: Option<Base>,
    pub tool: Option<Tool>,
    /// Feed, mm/min, if it sets one; the inner `None` is an unknown one.
    pub feed_mm_per_min: Option<Option<f64>>,
    /// Whether circles carry the orientation along, if it says so or not.
    carries_orientation: Option<bool>,
    sets_circle_mode: bool,
}

/// A block of SPLINE that is open.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// Line on which it begins, from 1, and the bytes of the statement.
    pub line: usize,
    pub at: Range<usize>,
    settings: Settings,
}

impl Reader<'_> {
    /// Opens a block: `SPLINE WITH …`, the bytes `at`, in `scan` behind its word.
    pub(crate) fn open_block(&mut self, mut scan: Scan<'_>, at: Range<usize>) -> Result<(), RobotFault> {
        let parts = with_parts(&mut scan)?;
        let settings = self.settings(&parts, Settings::default(), false)?;
        self.block = Some(Block { line: self.lines.line, at, settings });
        if scan.is_done() { Ok(()) } else { Err(RobotFault::Form { expected: "WITH behind SPLINE, or nothing" }) }
    }

    /// Closes a block: `ENDSPLINE C_SPL`, in `scan` behind its word.
    pub(crate) fn close_block(&mut self, mut scan: Scan<'_>) -> Result<(), RobotFault> {
        if let Some(block) = self.block.take() {
            self.leave(&block.settings);
        }
        takes_approximation(&mut scan);
        if scan.is_done() { Ok(()) } else { Err(RobotFault::Form { expected: "C_SPL behind ENDSPLINE, or nothing" }) }
    }

    /// Takes what stands behind the last point of a spline motion, and returns what is set for it; only the lines and circles whose end is
    /// known (`is_located`) need it.
    pub(crate) fn spline_settings(&mut self, scan: &mut Scan<'_>, is_located: bool) -> Result<Settings, RobotFault> {
        let parts = with_parts(scan)?;
        let is_approximated = takes_approximation(scan);
        while takes_approximation(scan) {}
        if !scan.is_done() {
            return Err(RobotFault::Form { expected: "WITH or C_SPL behind the point, or nothing" });
        }
        match &self.block {
            Some(_) if is_approximated => {
                RobotFault::not_followed("approximations within SPLINE are", "C_SPL behind ENDSPLINE alone")
            }
            Some(block) => self.settings(&parts, block.settings.clone(), true),
            None if is_located => self.settings(&parts, Settings::default(), false),
            None => {
                // What only the controller knows may be other frames than those in force.
                for (is_left, name) in self.left_frames.iter_mut().zip(["$BASE", "$TOOL"]) {
                    *is_left |= parts.iter().any(|part| part.name == name);
                }
                Ok(Settings::default())
            }
        }
    }

    /// Checks that it is known which frames are in force at a motion with `settings`.
    pub(crate) fn check_frames_known(&self, settings: &Settings) -> Result<(), RobotFault> {
        let [base, tool] = self.left_frames;
        if base && settings.base.is_none() || tool && settings.tool.is_none() {
            Err(FRAMES_BEHIND_WITH)
        } else {
            Ok(())
        }
    }

    /// Ends what `settings` set for a motion or a block: whether other frames hold behind it is not taken for known.
    pub(crate) fn leave(&mut self, settings: &Settings) {
        self.left_frames[0] |= settings.base.is_some() && settings.base != self.base;
        self.left_frames[1] |= settings.tool.is_some() && settings.tool != self.tool;
    }

    /// Returns what the statement of a spline motion needs to know of its block and of `settings`.
    pub(crate) fn spline_motion(&self, settings: &Settings) -> SplineMotion {
        SplineMotion { block: self.block.as_ref().map(|block| block.line), sets_circle_mode: settings.sets_circle_mode }
    }

    /// Whether circles with `settings` carry the orientation along.
    pub(crate) fn carries_orientation(&self, settings: &Settings) -> bool {
        settings.carries_orientation.unwrap_or(self.circ_type_line.is_some())
    }

    /// Returns what `parts` set, beyond what is already `set`.
    fn settings(&self, parts: &[WithPart<'_>], mut set: Settings, in_block: bool) -> Result<Settings, RobotFault> {
        for WithPart { name, value, .. } in parts {
            let is = |word: &str| value.eq_ignore_ascii_case(word.as_bytes());
            let root = &name[..name.find(['.', '[']).unwrap_or(name.len())];
            match name.as_str() {
                "$BASE" | "$TOOL" if in_block => {
                    return RobotFault::not_followed("$BASE and $TOOL of a segment are", "those behind SPLINE WITH");
                }
                "$BASE" => {
                    let (name, in_world) = self.with_frame(value)?;
                    set.base = Some(Base { name, in_world });
                }
                "$TOOL" => {
                    let (name, in_flange) = self.with_frame(value)?;
                    set.tool = Some(Tool { name, in_flange });
                }
                "$VEL" | "$VEL.CP" => {
                    let speed = with_speed(value).filter(|speed| *speed > 0.0);
                    set.feed_mm_per_min = Some(speed.map(|speed| speed * PER_METRE_PER_SECOND));
                }
                "$IPO_MODE" if is("#BASE") || self.frame_data_of(value, "SIPO_MODE", ".IPO_FRAME")?.is_some() => {}
                "$IPO_MODE" => return Err(FIXED_TOOL),
                "$ORI_TYPE" if is("#VAR") || self.says(value, "SORI_TYP", "ORI_TYP", "#VAR")? => {}
                "$ORI_TYPE" => return Err(TURNING_UNEVENLY),
                "$CIRC_TYPE" => {
                    let is_fixed = is("#BASE") || self.says(value, "SCIRC_TYP", "CIRC_TYP", "#BASE")?;
                    set.carries_orientation = Some(!is_fixed);
                }
                "$CIRC_MODE" => set.sets_circle_mode = !self.turns_as_usual(value)?,
                _ if root == "$CIRC_MODE" => set.sets_circle_mode = true,
                "$VEL.ORI1" | "$VEL.ORI2" => {}
                _ if HARMLESS.split_whitespace().any(|known| known == root) => {}
                _ => {
                    return RobotFault::not_followed(
                        "other data behind WITH are",
                        "$VEL, $ACC, $APO, $JERK, $BASE, $TOOL, $LOAD, $ORI_TYPE, $CIRC_TYPE and what else inline forms set",
                    );
                }
            }
        }
        Ok(set)
    }

    /// Returns the name and pose of a frame behind WITH: as other statements give it, or as inline forms do, `STOOL2(FP1)` and
    /// `SBASE(FP1.BASE_NO)`.
    fn with_frame(&self, value: &[u8]) -> Result<(String, Option<nalgebra::Isometry3<f64>>), RobotFault> {
        let number = |number: Option<usize>| number.ok_or(RobotFault::Form { expected: "TOOL_NO and BASE_NO in FDAT" });
        if let Some([tool, _]) = self.frame_data_of(value, "STOOL2", "")? {
            return self.numbered_frame("TOOL_DATA", number(tool)?);
        }
        if let Some([_, base]) = self.frame_data_of(value, "SBASE", ".BASE_NO")? {
            return self.numbered_frame("BASE_DATA", number(base)?);
        }
        self.frame_value(value)
    }

    /// Returns the numbers of tool and base of the datum in `function(FP1.part)`; `None` if `value` is something else.
    fn frame_data_of(
        &self,
        value: &[u8],
        function: &str,
        part: &str,
    ) -> Result<Option<[Option<usize>; 2]>, RobotFault> {
        let Some(argument) = argument_of(value, function) else { return Ok(None) };
        let name = argument.strip_suffix(part).ok_or(RobotFault::Form { expected: "data of inline forms (FDAT)" })?;
        frame::frame_numbers(self.motion_data(name)?).map(Some)
    }

    /// Whether `value` is `function(LCPDAT1)`, and `key` in this datum is `word`.
    fn says(&self, value: &[u8], function: &str, key: &str, word: &str) -> Result<bool, RobotFault> {
        let Some(name) = argument_of(value, function) else { return Ok(false) };
        let data = String::from_utf8_lossy(self.motion_data(&name)?).to_ascii_uppercase();
        Ok(word_behind(&data, key) == Some(word))
    }

    /// Whether `value` is `SCIRC_M(LCPDAT1)`, and this datum lets circles turn the tool all along the way, as without it.
    fn turns_as_usual(&self, value: &[u8]) -> Result<bool, RobotFault> {
        let Some(name) = argument_of(value, "SCIRC_M") else { return Ok(false) };
        let data = String::from_utf8_lossy(self.motion_data(&name)?).to_ascii_uppercase();
        let auxiliary =
            data.split_once("AUX_PT").map_or("", |(_, behind)| behind.split('}').next().unwrap_or_default());
        Ok(!auxiliary.contains("#INTERPOLATE"))
    }

    /// Returns the braces of the datum `name` of an inline form.
    fn motion_data(&self, name: &str) -> Result<&[u8], RobotFault> {
        self.points.find(name)?.ok_or_else(|| self.points.missing_point(name))
    }
}

/// Returns the argument (upper case) of `function` if `value` is a call of it with one, else `None`.
fn argument_of(value: &[u8], function: &str) -> Option<String> {
    let mut scan = Scan::new(value);
    if !scan.name().0.eq_ignore_ascii_case(function) || !scan.takes(b'(') {
        return None;
    }
    let argument = variable_name(&mut scan).ok()?;
    (scan.takes(b')') && scan.is_done()).then_some(argument)
}

/// Returns the speed (m/s) of `0.05`, `{CP 0.05,…}` or `SVEL_CP(0.05, , LCPDAT1)`; `None` if it is no number.
fn with_speed(value: &[u8]) -> Option<f64> {
    let mut scan = Scan::new(value);
    if scan.takes(b'{') {
        let is_speed = scan.name().0.eq_ignore_ascii_case("CP");
        let (speed, _) = scan.number().ok().filter(|_| is_speed)?;
        return matches!(scan.next(), Some(b',' | b'}')).then_some(speed);
    }
    let is_call = scan.name().0.eq_ignore_ascii_case("SVEL_CP") && scan.takes(b'(');
    let (speed, _) = scan.number().ok()?;
    (if is_call { scan.takes(b',') } else { scan.is_done() }).then_some(speed)
}

/// Orientations that differ by less are the same, rad: two decimals of a degree.
const SAME_RAD: f64 = 2e-4;
/// Beyond this the short way is not certain, rad.
const LARGEST_RAD: f64 = 3.1;

/// Checks that a circle of `statement`, with the states at its start, its auxiliary point and its end, turns the tool the short way: SCIRC
/// goes the way on which the orientation of the auxiliary point lies ($CIRC_MODE, #CONSIDER), with CA beyond the end.
pub(crate) fn check_turn(
    statement: &Statement,
    spline: &SplineMotion,
    [start, via, end]: [&ToolState; 3],
) -> Result<(), RobotFault> {
    let angle = |a: &ToolState, b: &ToolState| a.orientation.zip(b.orientation).map_or(0.0, |(a, b)| a.angle_to(&b));
    let (whole, over) = (angle(start, end), angle(start, via) + angle(via, end));
    let is_still = whole.max(over) <= SAME_RAD;
    let only_still = spline.sets_circle_mode || statement.sweep_rad.is_some();
    let is_short = is_still || !only_still && over <= (whole + SAME_RAD).min(LARGEST_RAD);
    let mut axes = start.external.iter().zip(&via.external).zip(&end.external);
    let is_between = axes.all(|((start, via), end)| match (start, via, end) {
        (Some(start), Some(_), Some(end)) if only_still && start != end => false,
        (Some(start), Some(via), Some(end)) => (start.min(*end)..=start.max(*end)).contains(via),
        _ => true,
    });
    match is_short && is_between {
        true => Ok(()),
        false => RobotFault::not_followed(
            "circles (SCIRC) whose auxiliary point does not lie on the short turn of the tool from start to end, or that turn it with CA or \
             $CIRC_MODE, are",
            "A, B, C and external axes of the auxiliary point as at the start",
        ),
    }
}
