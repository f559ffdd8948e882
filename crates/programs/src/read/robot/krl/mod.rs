//! KUKA Robot Language: lines of a `.src`, with the points that it or the `.dat` beside it declares.
//!
//! Followed are LIN, CIRC, PTP, LIN_REL, PTP_REL and their spline motions, `$BASE`, `$TOOL`, `$VEL.CP` and what inline forms set. What else may move the tool, or
//! change what a motion means, is refused; the rest is ignored.

use std::ops::Range;

use crate::{
    model::robot::{RobotFault, RobotOptions, Statement},
    read::{
        robot::{Base, Bases, LineCursor, LocatedFault, Tool, Tools, krl::points::Points, trimmed},
        scan::Scan,
    },
};

mod calls;
mod frame;
mod motion;
pub(crate) mod points;
mod spline;
mod state;
mod units;

pub(crate) use {
    calls::check_program,
    frame::brace_span,
    spline::{WithPart, check_turn, is_of_inline_forms, with_parts},
    units::next_unit,
};

/// LocatedFault of fixed tools, for which the robot carries the part.
const FIXED_TOOL: RobotFault =
    RobotFault::NotFollowed { what: "fixed tools ($IPO_MODE #TCP) are", expected: "a tool that the robot carries" };

/// A reader of KRL lines with the modes in force.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    source: &'a [u8],
    options: &'a RobotOptions,
    lines: LineCursor<'a>,
    points: Points<'a>,
    bases: Bases<'a>,
    tools: Tools<'a>,
    base: Option<Base>,
    tool: Option<Tool>,
    feed_mm_per_min: Option<f64>,
    /// Numbers of tool and base in the last FDAT_ACT.
    frame_data: [Option<usize>; 2],
    /// Keywords and lines of the open branches and loops.
    enclosing: Vec<(String, usize)>,
    /// Lines on which routines begin, from 1.
    routines: Vec<usize>,
    /// Line on which the program ends.
    end_line: Option<usize>,
    /// Line that set $CIRC_TYPE to carry the orientation along circles.
    circ_type_line: Option<usize>,
    /// The block of SPLINE that is open.
    block: Option<spline::Block>,
    /// Whether the last spline motion had another base, or another tool, than that in force.
    left_frames: [bool; 2],
}

impl<'a> Reader<'a> {
    /// Starts at the first line; `beside` are names and bytes of the `.dat` and of `$config.dat`.
    pub fn new(source: &'a [u8], beside: &'a [(String, Vec<u8>)], options: &'a RobotOptions) -> Self {
        Self {
            source,
            options,
            lines: LineCursor::new(source),
            points: Points::new(source, beside),
            bases: Bases::new(options, source),
            tools: Tools::new(options),
            base: None,
            tool: None,
            feed_mm_per_min: None,
            frame_data: [None; 2],
            enclosing: Vec::new(),
            routines: Vec::new(),
            end_line: None,
            circ_type_line: None,
            block: None,
            left_frames: [false; 2],
        }
    }

    /// Returns the tools that motions have used so far.
    pub fn tools(&self) -> &Tools<'a> {
        &self.tools
    }

    /// Returns the next statement that moves the tool; `None` at the end, `Err` for a statement that is not followed.
    pub fn next(&mut self) -> Result<Option<Statement>, LocatedFault> {
        while let Some(line) = self.lines.advance() {
            let code = code_range(self.source, line);
            if code.is_empty() || self.source[code.start] == b'&' {
                continue;
            }
            let refuse = |fault| LocatedFault { line: self.lines.line, at: code.clone(), fault };
            if self.source[code.clone()].ends_with(b"\\") {
                return Err(refuse(RobotFault::Form { expected: "a statement on one line" }));
            }
            let checked = calls::check_functions(&self.source[code.clone()], self.options);
            let found = checked.and_then(|()| self.follow_line(code.clone()));
            if let Some(statement) = found.map_err(|fault| LocatedFault { line: self.lines.line, at: code, fault })? {
                return Ok(Some(statement));
            }
        }
        match self.block.take() {
            Some(block) => Err(LocatedFault {
                line: block.line,
                at: block.at,
                fault: RobotFault::Form { expected: "ENDSPLINE behind it" },
            }),
            None => Ok(None),
        }
    }

    /// Follows a line of code, the bytes `code`: returns the statement if it moves the tool, or else sets modes.
    fn follow_line(&mut self, code: Range<usize>) -> Result<Option<Statement>, RobotFault> {
        let text = &self.source[code.clone()];
        let mut scan = Scan::new(text);
        let (word, _) = scan.name();
        let word = word.to_ascii_uppercase();
        if let [first, .., line] = self.routines[..]
            && !matches!(word.as_str(), "DEF" | "DEFFCT" | "GLOBAL")
        {
            // Whether and when other routines run is not known.
            return if is_motion_word(&word) { Err(RobotFault::SecondRoutine { line, first }) } else { Ok(None) };
        }
        spline::check_in_block(&word, self.block.is_some())?;
        match word.as_str() {
            "SPLINE" => {
                self.check_runs_once()?;
                self.open_block(scan, code)?;
            }
            "ENDSPLINE" => self.close_block(scan)?,
            _ if is_motion_word(&word) => return self.motion(&word, code),
            "" => return Err(RobotFault::Unknown { expected: "a statement of KRL" }),
            "DEF" | "DEFFCT" => self.routines.push(self.lines.line),
            "END" | "ENDFCT" | "RETURN" if self.enclosing.is_empty() => self.end_line = Some(self.lines.line),
            "GLOBAL" => return self.follow_global(scan),
            "IF" | "FOR" | "WHILE" | "LOOP" | "REPEAT" | "SWITCH" => self.enclosing.push((word, self.lines.line)),
            "ENDIF" | "ENDFOR" | "ENDWHILE" | "ENDLOOP" | "UNTIL" | "ENDSWITCH" => drop(self.enclosing.pop()),
            "GOTO" => {
                return RobotFault::not_followed("jumps are", "the motions in the order they run");
            }
            "INTERRUPT" => check_interrupt(scan, text)?,
            "TRIGGER" => self.check_trigger(scan, text)?,
            "DECL" | "CONST" | "INT" | "REAL" | "BOOL" | "CHAR" | "FRAME" | "POS" | "E6POS" | "AXIS" | "E6AXIS" => {
                self.points.declare(code, self.lines.line);
            }
            "RESUME" | "CWRITE" | "ASYPTP" | "ASYCONT" | "ASYSTOP" | "BRAKE" => {
                return RobotFault::not_followed("motions beside the program are", "none");
            }
            "RETURN" | "ELSE" | "CASE" | "DEFAULT" | "DEFDAT" | "ENDDAT" | "PUBLIC" | "INI" | "WAIT" | "HALT"
            | "PULSE" | "ANIN" | "ANOUT" | "DIGIN" | "SIGNAL" | "EXT" | "EXTFCT" | "IMPORT" | "ENUM" | "STRUC"
            | "CONTINUE" | "EXIT" | "CONFIRM" | "CHANNEL" => {}
            "BAS" => self.follow_bas(scan)?,
            _ => self.assignment_or_call(code)?,
        }
        Ok(None)
    }

    /// Follows what comes after GLOBAL: a routine or an interrupt.
    fn follow_global(&mut self, mut scan: Scan<'_>) -> Result<Option<Statement>, RobotFault> {
        let text = scan;
        let (word, _) = scan.name();
        match word.to_ascii_uppercase().as_str() {
            "DEF" | "DEFFCT" => self.routines.push(self.lines.line),
            "INTERRUPT" => check_interrupt(scan, text.rest())?,
            _ => {}
        }
        Ok(None)
    }

    /// Checks that a trigger acts at the start of the next motion, and what it calls.
    fn check_trigger(&mut self, mut scan: Scan<'_>, text: &[u8]) -> Result<(), RobotFault> {
        let at_start = scan.name().0.eq_ignore_ascii_case("WHEN")
            && scan.name().0.eq_ignore_ascii_case("DISTANCE")
            && scan.takes(b'=')
            && scan.number().is_ok_and(|(number, _)| number == 0.0)
            && matches!(scan.name().0.to_ascii_uppercase().as_str(), "DELAY" | "DO");
        if !at_start {
            return RobotFault::not_followed(
                "triggers on the way or at the end of a motion are",
                "TRIGGER WHEN DISTANCE=0",
            );
        }
        let text = String::from_utf8_lossy(text).to_ascii_uppercase();
        let action: String = text.split_whitespace().skip_while(|word| *word != "DO").skip(1).collect();
        match (action.contains('='), action.split_once('(')) {
            (false, Some((name, _))) => self.options.check_call(name),
            (true, _) if !OUTPUTS.iter().any(|output| action.starts_with(output)) => {
                RobotFault::not_followed("triggers that change other data than outputs are", "outputs and calls")
            }
            _ => Ok(()),
        }
    }

    /// Refuses a line within a branch or loop.
    fn check_runs_once(&self) -> Result<(), RobotFault> {
        match self.enclosing.first() {
            Some((keyword, line)) => Err(RobotFault::Branch { keyword: keyword.clone(), line: *line }),
            None => Ok(()),
        }
    }
}

/// What triggers may set.
const OUTPUTS: [&str; 5] = ["$OUT", "$ANOUT", "$FLAG", "$CYCFLAG", "$TIMER"];

/// Whether `word` (upper case) moves the tool.
pub(crate) fn is_motion_word(word: &str) -> bool {
    matches!(
        word,
        "LIN"
            | "PTP"
            | "CIRC"
            | "LIN_REL"
            | "PTP_REL"
            | "CIRC_REL"
            | "SPLINE"
            | "SPL"
            | "SLIN"
            | "SPTP"
            | "SCIRC"
            | "SLIN_REL"
            | "SPTP_REL"
            | "SCIRC_REL"
            | "SPL_REL"
            | "PTP_SPLINE"
    )
}

/// Refuses an interrupt that does more than stop the robot.
fn check_interrupt(mut scan: Scan<'_>, text: &[u8]) -> Result<(), RobotFault> {
    let is_declared = scan.name().0.eq_ignore_ascii_case("DECL");
    let upper = String::from_utf8_lossy(text).to_ascii_uppercase();
    let stops = upper.split(|own: char| !own.is_ascii_alphanumeric() && own != '_').any(|word| word == "IR_STOPM");
    match is_declared && !stops {
        true => RobotFault::not_followed("interrupts are", "none but that of IR_STOPM"),
        false => Ok(()),
    }
}

/// Returns the range of a line's code without its comment and the blanks around it.
fn code_range(source: &[u8], line: Range<usize>) -> Range<usize> {
    let mut in_text = false;
    let comment = source[line.clone()].iter().position(|byte| {
        in_text ^= *byte == b'"';
        *byte == b';' && !in_text
    });
    let end = comment.map_or(line.end, |length| line.start + length);
    // A byte order mark is no code.
    let start = if source[line.clone()].starts_with(b"\xef\xbb\xbf") { line.start + 3 } else { line.start };
    trimmed(source, start.min(end)..end)
}
