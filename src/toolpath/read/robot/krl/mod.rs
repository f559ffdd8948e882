//! KUKA Robot Language: lines of a `.src`, with the points that it or the `.dat` beside it declares.
//!
//! Followed are LIN, CIRC, PTP, LIN_REL and PTP_REL, `$BASE`, `$TOOL`, `$VEL.CP` and what inline forms set; all else
//! that does not move the tool is passed by, and what may move it, or change what a motion means, is refused.

use std::ops::Range;

use crate::toolpath::{
    model::robot::{RobotFault, RobotOptions, Statement},
    read::{
        robot::{Base, Bases, LineCursor, Refusal, Tool, Tools, krl::points::Points, trimmed},
        scan::Scan,
    },
};

mod frame;
mod motion;
mod points;
mod state;

/// Tools that stand still with the part in the hand of the robot.
const FIXED_TOOL: RobotFault =
    RobotFault::NotFollowed { what: "fixed tools ($IPO_MODE #TCP) are", expected: "a tool that the robot carries" };

/// Goes through a program from its first line on.
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
    /// What FDAT_ACT was set to last: numbers of tool and base.
    frame_data: [Option<usize>; 2],
    /// Branches and loops around the line, and where they begin.
    around: Vec<(String, usize)>,
    /// Where routines begin, from 1.
    routines: Vec<usize>,
    /// Where the program ends.
    ended: Option<usize>,
    /// Where circles were told to carry the orientation along.
    carried_on_circles: Option<usize>,
}

impl<'a> Reader<'a> {
    /// `beside`: name and bytes of the `.dat`.
    pub fn new(source: &'a [u8], beside: Option<(&'a str, &'a [u8])>, options: &'a RobotOptions) -> Self {
        Self {
            source,
            options,
            lines: LineCursor::new(source),
            points: Points::new(source, beside),
            bases: Bases::new(options),
            tools: Tools::new(options),
            base: None,
            tool: None,
            feed_mm_per_min: None,
            frame_data: [None; 2],
            around: Vec::new(),
            routines: Vec::new(),
            ended: None,
            carried_on_circles: None,
        }
    }

    /// The tools that motions used so far.
    pub fn tools(&self) -> &Tools<'a> {
        &self.tools
    }

    /// The next statement that moves the tool.
    pub fn next(&mut self) -> Result<Option<Statement>, Refusal> {
        while let Some(line) = self.lines.advance() {
            let code = code(self.source, line);
            if code.is_empty() || self.source[code.start] == b'&' {
                continue;
            }
            let refuse = |fault| Refusal { line: self.lines.line, at: code.clone(), fault };
            if self.source[code.clone()].ends_with(b"\\") {
                return Err(refuse(RobotFault::Form { expected: "a statement on one line" }));
            }
            let found = self.line(code.clone());
            if let Some(statement) = found.map_err(|fault| Refusal { line: self.lines.line, at: code, fault })? {
                return Ok(Some(statement));
            }
        }
        Ok(None)
    }

    fn line(&mut self, code: Range<usize>) -> Result<Option<Statement>, RobotFault> {
        let text = &self.source[code.clone()];
        let mut scan = Scan::new(text);
        let (word, _) = scan.name();
        let word = word.to_ascii_uppercase();
        if let [first, .., line] = self.routines[..]
            && !matches!(word.as_str(), "DEF" | "DEFFCT" | "GLOBAL")
        {
            // Whether and when other routines run is not known.
            return if is_motion(&word) { Err(RobotFault::SecondRoutine { line, first }) } else { Ok(None) };
        }
        match word.as_str() {
            _ if is_motion(&word) => return self.motion(&word, code),
            "" => return Err(RobotFault::Unknown { expected: "a statement of KRL" }),
            "DEF" | "DEFFCT" => self.routines.push(self.lines.line),
            "END" | "ENDFCT" | "RETURN" if self.around.is_empty() => self.ended = Some(self.lines.line),
            "GLOBAL" => return self.global(scan),
            "IF" | "FOR" | "WHILE" | "LOOP" | "REPEAT" | "SWITCH" => self.around.push((word, self.lines.line)),
            "ENDIF" | "ENDFOR" | "ENDWHILE" | "ENDLOOP" | "UNTIL" | "ENDSWITCH" => drop(self.around.pop()),
            "GOTO" => {
                return Err(RobotFault::NotFollowed {
                    what: "jumps are",
                    expected: "the motions in the order they run",
                });
            }
            "INTERRUPT" => interrupt(scan, text)?,
            "TRIGGER" => self.trigger(scan, text)?,
            "DECL" | "CONST" | "INT" | "REAL" | "BOOL" | "CHAR" | "FRAME" | "POS" | "E6POS" | "AXIS" | "E6AXIS" => {
                self.points.declare(code, self.lines.line);
            }
            "RESUME" | "CWRITE" | "ASYPTP" | "ASYCONT" | "ASYSTOP" | "BRAKE" => {
                return Err(RobotFault::NotFollowed { what: "motions beside the program are", expected: "none" });
            }
            "RETURN" | "ELSE" | "CASE" | "DEFAULT" | "DEFDAT" | "ENDDAT" | "PUBLIC" | "INI" | "WAIT" | "HALT"
            | "PULSE" | "ANIN" | "ANOUT" | "DIGIN" | "SIGNAL" | "EXT" | "EXTFCT" | "IMPORT" | "ENUM" | "STRUC"
            | "CONTINUE" | "EXIT" | "CONFIRM" | "CHANNEL" => {}
            "BAS" => self.bas(scan)?,
            _ => self.assignment_or_call(code)?,
        }
        Ok(None)
    }

    /// What follows GLOBAL.
    fn global(&mut self, mut scan: Scan<'_>) -> Result<Option<Statement>, RobotFault> {
        let text = scan;
        let (word, _) = scan.name();
        match word.to_ascii_uppercase().as_str() {
            "DEF" | "DEFFCT" => self.routines.push(self.lines.line),
            "INTERRUPT" => interrupt(scan, text.rest())?,
            _ => {}
        }
        Ok(None)
    }

    /// A trigger acts at the begin of the next motion, which stays its begin.
    fn trigger(&mut self, mut scan: Scan<'_>, text: &[u8]) -> Result<(), RobotFault> {
        let at_start = scan.name().0.eq_ignore_ascii_case("WHEN")
            && scan.name().0.eq_ignore_ascii_case("DISTANCE")
            && scan.takes(b'=')
            && scan.number().is_ok_and(|(number, _)| number == 0.0);
        if !at_start {
            return Err(RobotFault::NotFollowed {
                what: "triggers on the way or at the end of a motion are",
                expected: "TRIGGER WHEN DISTANCE=0",
            });
        }
        let text = String::from_utf8_lossy(text).to_ascii_uppercase();
        let action = text.split_once(" DO ").map_or("", |(_, action)| action);
        match (action.contains('='), action.split_once('(')) {
            (false, Some((name, _))) => self.check_call(name.trim()),
            _ => Ok(()),
        }
    }

    fn check_call(&self, name: &str) -> Result<(), RobotFault> {
        let known = self.options.calls_kept.iter().any(|kept| kept.eq_ignore_ascii_case(name));
        if known { Ok(()) } else { Err(RobotFault::Call { name: name.to_owned() }) }
    }

    /// Whether the line stands where it runs once.
    fn check_runs_once(&self) -> Result<(), RobotFault> {
        match self.around.first() {
            Some((keyword, line)) => Err(RobotFault::Branch { keyword: keyword.clone(), line: *line }),
            None => Ok(()),
        }
    }
}

fn is_motion(word: &str) -> bool {
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
            | "PTP_SPLINE"
    )
}

/// What an interrupt may run: it stops the robot as the standard says.
fn interrupt(mut scan: Scan<'_>, text: &[u8]) -> Result<(), RobotFault> {
    let is_declared = scan.name().0.eq_ignore_ascii_case("DECL");
    let stops = String::from_utf8_lossy(text).to_ascii_uppercase().contains("IR_STOPM");
    match is_declared && !stops {
        true => Err(RobotFault::NotFollowed { what: "interrupts are", expected: "none but that of IR_STOPM" }),
        false => Ok(()),
    }
}

/// The code of a line, without comment and blanks around it.
fn code(source: &[u8], line: Range<usize>) -> Range<usize> {
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
