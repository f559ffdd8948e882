//! TP programs of FANUC as listings (`.ls`): `L P[2] 100mm/sec CNT50 ;` in `/MN`, with the positions of `/POS`.
//!
//! Followed are L, C and J to `P[n]`, `UFRAME_NUM` and `UTOOL_NUM`; what frames stand for comes from the options, or from `$MNUFRAME` and
//! `$MNUTOOL` in a `sysframe.va` of the controller's backup. Position registers, offsets, steps, jumps, and whatever else may move the tool
//! or change what a motion means, are refused; instructions that do neither are ignored.

use std::{borrow::Cow, collections::HashMap, ops::Range};

use nalgebra::{Isometry3, Translation3};

use crate::{
    model::robot::{
        Component, Frames, MotionKind, Number, RobotFault, RobotOptions, Statement, Target, rotation_of_abc,
    },
    read::{
        robot::{Base, Bases, LineCursor, LocatedFault, Tool, Tools, scan::check_depth},
        scan::Scan,
    },
};

/// The pose of a position, its numbers of UFRAME and UTOOL, and its angles of joints, rad.
type TakenPosition = (Option<Target>, [Option<u32>; 2], Option<[f32; 6]>);

/// mm/min of the units of speeds along a path.
const SPEEDS: [(&str, f64); 3] = [("mm/sec", 60.0), ("cm/min", 10.0), ("inch/min", 25.4)];

/// A reader of the instructions of a listing with the modes in force.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    source: &'a [u8],
    options: &'a RobotOptions,
    lines: LineCursor<'a>,
    /// Whether `/MN` has been reached.
    is_in_program: bool,
    /// Bytes between the braces of each position.
    positions: HashMap<u32, Range<usize>>,
    /// Lines that assign positions, which then last for the next run.
    assigned: HashMap<u32, usize>,
    system_frames: SystemFrames,
    bases: Bases<'a>,
    tools: Tools<'a>,
    /// Numbers of UFRAME and UTOOL in force, if the program has set them.
    selected: [Option<u32>; 2],
    has_moved: bool,
    /// Keywords and lines of the open branches and loops.
    enclosing: Vec<(String, usize)>,
    end_line: Option<usize>,
}

/// An instruction: its bytes from behind its line number through `;`, and its text with blanks for line breaks and their numbers.
type Instruction<'a> = (Range<usize>, Cow<'a, [u8]>);

impl<'a> Reader<'a> {
    /// Starts at the first line; `system_frames` are the bytes of a `sysframe.va`.
    pub fn new(source: &'a [u8], system_frames: Option<&'a [u8]>, options: &'a RobotOptions) -> Self {
        Self {
            source,
            options,
            lines: LineCursor::new(source),
            is_in_program: false,
            positions: positions(source).collect(),
            assigned: assigned_positions(source),
            system_frames: system_frames.map(read_system_frames).unwrap_or_default(),
            bases: Bases::new(options, source),
            tools: Tools::new(options),
            selected: [None; 2],
            has_moved: false,
            enclosing: Vec::new(),
            end_line: None,
        }
    }

    /// Returns the tools that motions have used so far.
    pub fn tools(&self) -> &Tools<'a> {
        &self.tools
    }

    /// Returns the next statement that moves the tool; `None` at the end, `Err` for a statement that is not followed.
    pub fn next(&mut self) -> Result<Option<Statement>, LocatedFault> {
        while !self.is_in_program {
            let Some(line) = self.lines.advance() else {
                let fault = RobotFault::Form {
                    expected: "a listing with /PROG and /MN; a binary .tp becomes one by PrintTP of WinOLPC or ROBOGUIDE, or by saving the \
                               program as .ls on the controller (ASCII Upload)",
                };
                return Err(LocatedFault { line: 1, at: 0..0, fault });
            };
            self.is_in_program = self.source[line.clone()].starts_with(b"/MN");
            if self.source[line.clone()].starts_with(b"/POS") {
                return Err(LocatedFault {
                    line: self.lines.line,
                    at: line,
                    fault: RobotFault::Form { expected: "/MN before /POS" },
                });
            }
        }
        while let Some(first) = self.lines.advance() {
            if self.source[first.clone()].starts_with(b"/") {
                self.lines = LineCursor::new(&[]);
                return Ok(None);
            }
            let line = self.lines.line;
            let (at, code) = self.instruction(first).map_err(|(at, fault)| LocatedFault { line, at, fault })?;
            let found = self.follow_instruction(at.clone(), line, &code);
            if let Some(statement) = found.map_err(|fault| LocatedFault { line, at, fault })? {
                return Ok(Some(statement));
            }
        }
        Ok(None)
    }

    /// Returns the instruction that begins on the line `first`, with the lines that continue it. `Err` without `:` or `;`.
    fn instruction(&mut self, first: Range<usize>) -> Result<Instruction<'a>, (Range<usize>, RobotFault)> {
        let source = self.source;
        let Some((start, _)) = code_start(source, first.clone()) else {
            let is_blank = source[first.clone()].trim_ascii().is_empty();
            let fault = RobotFault::Form { expected: "the number of a line and :" };
            return if is_blank { Ok((first, Cow::Borrowed(b""))) } else { Err((first, fault)) };
        };
        let mut code = Cow::Borrowed(&source[start..first.end]);
        let mut end = first.end;
        // Without a number, the line continues the one before.
        while !code.trim_ascii_end().ends_with(b";") {
            let fault = RobotFault::Form { expected: "; at the end of the instruction" };
            let next = self.lines.advance().and_then(|next| Some((code_start(source, next.clone())?, next.end)));
            let Some(((more, false), next_end)) = next else { return Err((start..end, fault)) };
            let joined = code.to_mut();
            joined.resize(joined.len() + more - end, b' ');
            joined.extend_from_slice(&source[more..next_end]);
            end = next_end;
        }
        let length = code.trim_ascii_end().len();
        let code = match code {
            Cow::Borrowed(code) => Cow::Borrowed(&code[..length - 1]),
            Cow::Owned(code) => Cow::Owned(code[..length - 1].to_vec()),
        };
        Ok((start..start + length, code))
    }

    /// Follows the instruction `code` at the bytes `at` on line `line`: returns it if it moves the tool, or else sets modes.
    fn follow_instruction(
        &mut self,
        at: Range<usize>,
        line: usize,
        code: &[u8],
    ) -> Result<Option<Statement>, RobotFault> {
        let mut scan = Scan::new(code);
        // Comments, and instructions that are switched off.
        if matches!(scan.next(), None | Some(b'!' | b'/')) || code[scan.at..].starts_with(b"--") {
            return Ok(None);
        }
        let is_case = scan.takes(b'=');
        let mut word = scan.name().0.to_ascii_uppercase();
        if is_case {
            word = "=".to_owned();
        }
        if matches!(word.as_str(), "L" | "C" | "J" | "A" | "S") && matches!(scan.next(), Some(b'P' | b'p')) {
            return self.motion(&word, at, line, code).map(Some);
        }
        match word.as_str() {
            "IF" | "SELECT" | "=" | "ELSE" | "ELSEIF" => {
                self.check_words(code)?;
                let text = code.trim_ascii_end();
                let opens = text.len() >= 4 && text[text.len() - 4..].eq_ignore_ascii_case(b"THEN");
                if let Some(start) = statement_behind_condition(code) {
                    check_depth(code, 1 + self.enclosing.iter().filter(|(_, own)| *own == line).count())?;
                    self.enclosing.push((word, line));
                    let followed = self.follow_instruction(at, line, &code[start..]);
                    self.enclosing.pop();
                    return followed;
                }
                if word == "IF" && opens {
                    self.enclosing.push((word, line));
                }
            }
            "WAIT" if words_in(code).iter().any(|word| word == "TIMEOUT") => return Err(JUMP),
            "FOR" => self.enclosing.push((word, line)),
            "ENDIF" | "ENDFOR" => drop(self.enclosing.pop()),
            "JMP" => return Err(JUMP),
            "CALL" | "RUN" => self.check_words(code)?,
            "END" | "ABORT" if self.enclosing.is_empty() => self.end_line = Some(line),
            "UFRAME_NUM" | "UTOOL_NUM" => {
                let expected = RobotFault::Form { expected: "= and a plain number" };
                if let Some((keyword, line)) = self.enclosing.first() {
                    return Err(RobotFault::Branch { keyword: keyword.clone(), line: *line });
                }
                // UFRAME_NUM[GP1]=1.
                if scan.takes(b'[') {
                    scan.take_while(|byte| byte != b']');
                    scan.expect(b']', "]")?;
                }
                scan.expect(b'=', "= and a plain number")?;
                let number = scan.number()?.0;
                let number = index(number).filter(|_| scan.is_done()).ok_or(expected)?;
                self.selected[usize::from(word == "UTOOL_NUM")] = Some(number);
            }
            "UFRAME" | "UTOOL" if self.has_moved || !self.enclosing.is_empty() => {
                return RobotFault::not_followed("frames that are set between motions are", "UFRAME_NUM and UTOOL_NUM");
            }
            // What it has from here on, the backup does not say.
            "UFRAME" | "UTOOL" => {
                let kind = usize::from(word == "UTOOL");
                let number =
                    if scan.takes(b'[') { scan.number().ok().and_then(|(number, _)| index(number)) } else { None };
                self.system_frames
                    .retain(|(other, own), _| *other != kind || number.is_some_and(|number| number != *own));
            }
            "P" if !scan.takes(b'[') || scan.number().is_err() => {
                return RobotFault::not_followed("assignments to positions without a plain number are", "P[n]");
            }
            word if word.starts_with('$') && !IGNORED_VARIABLES.contains(&word) => {
                return RobotFault::not_followed("system variables are", "a program that does not set them");
            }
            word if word.starts_with('$') || IGNORED.split_whitespace().any(|kept| kept == word) => {}
            word => self.options.check_call(word)?,
        }
        Ok(None)
    }

    /// Refuses an instruction that jumps, or calls what is not known to move nothing.
    fn check_words(&self, code: &[u8]) -> Result<(), RobotFault> {
        let words = words_in(code);
        let mut words = words.iter().map(String::as_str);
        while let Some(word) = words.next() {
            match word {
                "JMP" => return Err(JUMP),
                "CALL" | "RUN" => self.options.check_call(words.next().unwrap_or_default())?,
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns the statement of the motion `word`: L, C, J, or another that is refused.
    fn motion(&mut self, word: &str, at: Range<usize>, line: usize, code: &[u8]) -> Result<Statement, RobotFault> {
        if let Some((keyword, line)) = self.enclosing.first() {
            return Err(RobotFault::Branch { keyword: keyword.clone(), line: *line });
        }
        if let Some(end) = self.end_line {
            return Err(RobotFault::AfterEnd { end });
        }
        let kind = match word {
            "L" => MotionKind::Line,
            "C" => MotionKind::Circle,
            "J" => MotionKind::PointToPoint,
            _ => return RobotFault::not_followed("arcs by A and splines by S are", "L, C and J"),
        };
        self.has_moved = true;
        let mut scan = Scan::new(code);
        let (_, keyword) = scan.name();
        let via = match kind {
            MotionKind::Circle => Some(self.target(&mut scan, at.start, kind)?),
            _ => None,
        };
        let (end, frames, joints) = self.target(&mut scan, at.start, kind)?;
        let suffix = at.start + scan.at..at.end;
        if via.as_ref().is_some_and(|(_, other, _)| *other != frames) {
            return Err(OTHER_FRAME);
        }
        let feed_mm_per_min = speed_mm_per_min(&mut scan, kind)?;
        check_options(scan)?;
        let frames = match &end {
            Some(_) => self.frames(frames)?,
            None => Frames::default(),
        };
        let via = match via {
            Some((None, ..)) => return Err(JOINTS),
            Some((via, ..)) => via,
            None => None,
        };
        let keyword = at.start + keyword.start..at.start + keyword.end;
        // Wjnt turns the wrist as it comes, whatever its configuration.
        let is_posture_open = words_in(code).iter().any(|word| word == "WJNT");
        let statement = Statement::new(at, line, keyword, kind);
        Ok(Statement { suffix, via, end, frames, feed_mm_per_min, is_posture_open, joints, ..statement })
    }

    /// Takes the next position of a motion, `P[2]` or `P[2:name]`, whose text begins at byte `start` of the source: its pose, `None` for joint
    /// positions, its numbers of UFRAME and UTOOL, and the angles of joint positions, rad.
    fn target(&self, scan: &mut Scan<'_>, start: usize, kind: MotionKind) -> Result<TakenPosition, RobotFault> {
        let (name, at) = scan.name();
        if !name.eq_ignore_ascii_case("P") {
            return RobotFault::not_followed("motions to registers (PR) and other places are", "P[n] of /POS");
        }
        scan.expect(b'[', "P[n]")?;
        let number = scan.number().ok().and_then(|(number, _)| index(number));
        let Some(number) = number else {
            return RobotFault::not_followed("positions whose number is computed are", "P[n] with a plain number");
        };
        scan.take_while(|byte| byte != b']');
        scan.expect(b']', "]")?;
        let (name, at) = (format!("P[{number}]"), start + at.start..start + scan.at);
        if let Some(line) = self.assigned.get(&number) {
            return Err(RobotFault::Computed { name, line: *line });
        }
        let Some(body) = self.positions.get(&number) else {
            return Err(RobotFault::NoPoint { name, beside: String::new() });
        };
        let text = &self.source[body.clone()];
        let position = parse_position(text)?;
        if position.numbers.is_empty() {
            return match kind {
                MotionKind::PointToPoint => Ok((None, position.frames, Some(position.joints))),
                _ => Err(JOINTS),
            };
        }
        Ok((Some(Target { at, text: text.to_vec(), numbers: position.numbers }), position.frames, None))
    }

    /// Returns the frames of a position that was taught in the numbers `of_position`.
    fn frames(&mut self, of_position: [Option<u32>; 2]) -> Result<Frames, RobotFault> {
        let mut numbers = [None; 2];
        for (which, number) in numbers.iter_mut().enumerate() {
            *number = match (self.selected[which], of_position[which]) {
                (Some(selected), Some(own)) if selected != own => return Err(OTHER_FRAME),
                (selected, own) => selected.or(own),
            };
        }
        let known = |which: usize, number: u32| match number {
            0 => Some(Isometry3::identity()),
            _ => self.system_frames.get(&(which, number)).copied(),
        };
        let base = numbers[0].map(|n| Base { name: format!("uframe[{n}]"), in_world: known(0, n) });
        let tool = numbers[1].map(|n| Tool { name: format!("utool[{n}]"), in_flange: known(1, n) });
        Ok(Frames { base: self.bases.pose(base.as_ref())?, tool: self.tools.rotation(tool.as_ref())?, unit_mm: 1.0 })
    }
}

const JUMP: RobotFault = RobotFault::NotFollowed {
    what: "jumps are",
    expected: "the motions in the order they run, without labels to go to",
};
const JOINTS: RobotFault =
    RobotFault::NotFollowed { what: "L and C to positions of joints (J1 …) are", expected: "X, Y, Z, W, P, R" };
const OTHER_FRAME: RobotFault = RobotFault::NotFollowed {
    what: "positions with another UF or UT than the one in force are",
    expected: "UFRAME_NUM and UTOOL_NUM as in the position",
};

/// System variables that change no path.
const IGNORED_VARIABLES: [&str; 1] = ["$WAITTMOUT"];

/// Instructions that are ignored: they neither move the tool nor change what motions mean.
const IGNORED: &str = "DO RO GO AO SO UO WO DI RI GI AI F M R SR AR TIMER PR WAIT PAUSE MESSAGE OVERRIDE PAYLOAD \
    LINEAR_MAX_SPEED JOINT_MAX_SPEED LBL UALM RSR LOCK UNLOCK COL END ABORT P ERROR_PROG OFFSET TOOL_OFFSET SKIP";

const SPEED: &str = "a speed in mm/sec, cm/min, inch/min, deg/sec or %";

/// Returns the speed of a path motion, mm/min; `None` if it is unknown. `Err` for the time of an L or C.
fn speed_mm_per_min(scan: &mut Scan<'_>, kind: MotionKind) -> Result<Option<f64>, RobotFault> {
    let number = match scan.next() {
        Some(b'0'..=b'9' | b'.') => Some(scan.number()?.0),
        _ => {
            // R[1]mm/sec, WELD_SPEED, max_speed
            let word = scan.name().0.to_ascii_uppercase();
            if word.starts_with("FINE") || word.starts_with("CNT") || word.is_empty() {
                return Err(RobotFault::Form { expected: SPEED });
            }
            if !scan.takes(b'[') {
                return Ok(None);
            }
            scan.take_while(|byte| byte != b']');
            scan.expect(b']', "]")?;
            None
        }
    };
    let unit = scan.skip_blanks().take_while(|byte| byte.is_ascii_alphabetic() || matches!(byte, b'/' | b'%'));
    let unit = String::from_utf8_lossy(&scan.line[unit]).to_ascii_lowercase();
    match unit.as_str() {
        "%" | "deg/sec" => Ok(None),
        "sec" | "msec" if kind == MotionKind::PointToPoint => Ok(None),
        "sec" | "msec" => RobotFault::not_followed("times of motions (sec) are", "a speed"),
        unit => match SPEEDS.iter().find(|(known, _)| *known == unit) {
            Some((_, mm_per_min)) => Ok(number.map(|n| n * mm_per_min).filter(|_| kind != MotionKind::PointToPoint)),
            None => Err(RobotFault::Form { expected: SPEED }),
        },
    }
}

/// Checks what stands behind the speed: FINE or CNT, and options that move nothing elsewhere.
fn check_options(mut scan: Scan<'_>) -> Result<(), RobotFault> {
    let expected = RobotFault::NotFollowed {
        what: "options other than ACC, Wjnt, PTH, COORD, EV, Ind.EV and BREAK behind FINE or CNT are",
        expected: "none that shift the position (Offset, Tool_Offset, INC, VOFFSET), act on the way (TA, TB, DB, Skip), or turn (RTCP)",
    };
    let mut is_first = true;
    while !scan.is_done() {
        let start = scan.at;
        let word = scan.name().0.to_ascii_uppercase();
        let is_register = scan.next() == Some(b'[');
        let name = if is_register {
            word.strip_suffix('R').unwrap_or(&word)
        } else {
            word.trim_end_matches(|c: char| c.is_ascii_digit())
        };
        let is_termination = matches!(name, "FINE" | "CNT");
        if is_first != is_termination {
            return Err(if is_first {
                RobotFault::Form { expected: "FINE or CNT behind the speed" }
            } else {
                expected
            });
        }
        is_first = false;
        match name {
            "IND" if scan.takes(b'.') && scan.name().0.to_ascii_uppercase().starts_with("EV") => {}
            "" if is_register => {}
            "FINE" | "CNT" | "ACC" | "WJNT" | "PTH" | "COORD" | "EV" | "BREAK" => {}
            _ => return Err(expected),
        }
        // CNTR[1], ACC R[2], EV50%
        if is_register {
            scan.take_while(|byte| byte != b']');
            scan.expect(b']', "]")?;
        }
        scan.skip_blanks().take_while(|byte| byte.is_ascii_digit() || byte == b'%');
        if scan.at == start {
            return Err(expected);
        }
    }
    if is_first { Err(RobotFault::Form { expected: "FINE or CNT behind the speed" }) } else { Ok(()) }
}

/// Returns the index of the first byte behind `:` of a program line, and whether the line has a number; `None` if it is no program line.
pub(crate) fn code_start(source: &[u8], line: Range<usize>) -> Option<(usize, bool)> {
    let mut scan = Scan::new(&source[line.clone()]);
    let digits = scan.skip_blanks().take_while(|byte| byte.is_ascii_digit());
    scan.takes(b':').then(|| {
        scan.skip_blanks();
        (line.start + scan.at, !digits.is_empty())
    })
}

/// Returns the index that `number` is; `None` if it is not whole, negative or too large.
fn index(number: f64) -> Option<u32> {
    (number >= 0.0 && number <= f64::from(u32::MAX) && number.fract() == 0.0).then_some(number as u32)
}

/// Returns where the instruction of `IF condition,instruction` begins in `code`, behind the first comma outside brackets; `None` without one.
fn statement_behind_condition(code: &[u8]) -> Option<usize> {
    let (mut depth, mut in_text) = (0usize, false);
    let comma = code.iter().position(|byte| {
        match byte {
            b'\'' => in_text ^= true,
            _ if in_text => {}
            b'(' | b'[' => depth += 1,
            b')' | b']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        *byte == b',' && depth == 0 && !in_text
    });
    comma.map(|at| at + 1).filter(|start| !code[*start..].trim_ascii().is_empty())
}

/// Returns the words of `code` in capitals, but for remarks in brackets (`DI[3:ready]`) and strings.
fn words_in(code: &[u8]) -> Vec<String> {
    let (mut in_text, mut in_remark, mut depth) = (false, false, 0usize);
    let kept = code.iter().filter(|byte| {
        match byte {
            b'\'' if !in_remark => in_text ^= true,
            b'[' if !in_text => depth += 1,
            b']' if !in_text => (depth, in_remark) = (depth.saturating_sub(1), false),
            b':' if depth > 0 && !in_text => in_remark = true,
            _ => {}
        }
        !in_text && !in_remark
    });
    let text = String::from_utf8_lossy(&kept.copied().collect::<Vec<u8>>()).to_ascii_uppercase();
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || matches!(c, '_' | '$')));
    words.filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// Returns the lines that assign a position, or a part of it, by the position's number.
fn assigned_positions(source: &[u8]) -> HashMap<u32, usize> {
    let (mut lines, mut found) = (LineCursor::new(source), HashMap::new());
    while let Some(line) = lines.advance().filter(|line| !source[line.clone()].starts_with(b"/POS")) {
        let code = code_start(source, line.clone()).map_or(&[][..], |(start, _)| &source[start..line.end]);
        let inner = statement_behind_condition(code).map(|start| code[start..].trim_ascii_start());
        for code in [Some(code), inner].into_iter().flatten() {
            let mut scan = Scan::new(code);
            let is_position = scan.name().0.eq_ignore_ascii_case("P") && scan.takes(b'[');
            let number = scan.number().ok().and_then(|(number, _)| index(number));
            scan.take_while(|byte| byte != b']');
            // One of its numbers, too: P[3,2]=5.
            let number = number.filter(|_| is_position && scan.takes(b']') && scan.takes(b'='));
            found.extend(number.map(|number| (number, lines.line)));
        }
    }
    found
}

/// Iterates over the positions of `/POS`: number, and the bytes between its braces.
pub(crate) fn positions(source: &[u8]) -> impl Iterator<Item = (u32, Range<usize>)> {
    let mut at = section(source, b"/POS").unwrap_or(source.len());
    std::iter::from_fn(move || {
        loop {
            let found = source[at..].windows(2).position(|pair| pair == b"P[")?;
            at += found + 2;
            let Ok((number, _)) = Scan::new(&source[at..]).number() else { continue };
            let open = at + source[at..].iter().position(|byte| *byte == b'{')? + 1;
            let close = open + source[open..].iter().position(|byte| *byte == b'}')?;
            at = close;
            if let Some(number) = index(number) {
                return Some((number, open..close));
            }
        }
    })
}

/// Returns the byte at which the first line that begins with `name` starts; `None` if there is none.
pub(crate) fn section(source: &[u8], name: &[u8]) -> Option<usize> {
    let mut lines = LineCursor::new(source);
    std::iter::from_fn(|| lines.advance()).find(|line| source[line.clone()].starts_with(name)).map(|line| line.start)
}

/// A position of `/POS`: numbers of UFRAME and UTOOL of its first group, and its pose, which is empty for joint positions.
struct Position {
    frames: [Option<u32>; 2],
    numbers: Vec<Number>,
    /// Angles of the joints, rad, of a position that has these.
    joints: [f32; 6],
}

/// Parses the text between the braces of a position; other groups than the first have joints, which count as external axes behind E1 ….
fn parse_position(text: &[u8]) -> Result<Position, RobotFault> {
    let expected = RobotFault::Form {
        expected: "GP1: UF, UT, CONFIG and X, Y, Z in mm, W, P, R in deg, or J1 …, in plain numbers",
    };
    let (mut scan, mut group, mut joints, mut extended) = (Scan::new(text), 0u32, false, 0);
    let mut position = Position { frames: [None; 2], numbers: Vec::new(), joints: [0.0; 6] };
    while !scan.is_done() {
        let (name, _) = scan.name();
        let name = name.to_ascii_uppercase();
        if let Some(number) = name.strip_prefix("GP") {
            group = number.parse().map_err(|_| expected.clone())?;
            scan.expect(b':', ":")?;
            continue;
        }
        if name == "CONFIG" {
            scan.expect(b':', ":")?;
            scan.expect(b'\'', "'")?;
            let at = scan.take_while(|byte| byte != b'\'');
            scan.expect(b'\'', "'")?;
            if group == 1 {
                position.numbers.extend(configuration(text, at).unwrap_or_default());
            }
        } else if let Some(which) = ["UF", "UT"].iter().position(|frame| *frame == name) {
            scan.expect(b':', ":")?;
            // F is the frame in force.
            let number = if scan.next() == Some(b'F') { scan.name().0.parse().ok() } else { index(scan.number()?.0) };
            if group == 1 {
                position.frames[which] = number;
            }
        } else {
            scan.expect(b'=', "=")?;
            let (value, at) = scan.number()?;
            let unit = scan.name().0;
            let axis = |letter: char| name.strip_prefix(letter)?.parse::<usize>().ok()?.checked_sub(1);
            let pose = ["X", "Y", "Z", "R", "P", "W"].iter().position(|known| *known == name).filter(|_| group == 1);
            let component = match (pose, axis('E'), axis('J')) {
                (Some(axis @ 0..3), ..) if unit == "mm" => Component::Position(axis),
                (Some(angle @ 3..), ..) if unit == "deg" => Component::Rotation(angle - 3),
                (None, Some(axis), None) if group == 1 && axis < 3 => {
                    extended = extended.max(axis + 1);
                    Component::External(axis)
                }
                (None, None, Some(axis)) if group == 1 => {
                    joints = true;
                    if let Some(own) = position.joints.get_mut(axis) {
                        *own = value.to_radians() as f32;
                    }
                    scan.takes(b',');
                    continue;
                }
                (None, None, Some(axis)) if group == 2 && extended + axis < 6 => Component::External(extended + axis),
                _ => return Err(expected),
            };
            if position.numbers.iter().any(|number| number.component == component) {
                return Err(RobotFault::Form { expected: "each component once" });
            }
            position.numbers.push(Number { component, at, value });
        }
        scan.takes(b',');
    }
    let count = |is_one: fn(&Component) -> bool| position.numbers.iter().filter(|n| is_one(&n.component)).count();
    let parts = count(|component| matches!(component, Component::Position(_) | Component::Rotation(_)));
    match (joints, parts) {
        (true, 0) => position.numbers.clear(),
        (false, 6) => {}
        _ => return Err(expected),
    }
    Ok(position)
}

/// Parses `N U T, 0, 0, 0` in the bytes `at` of `text`, with L or R before U or D of arms that have it; `None` for other forms.
fn configuration(text: &[u8], at: Range<usize>) -> Option<Vec<Number>> {
    let (mut scan, mut numbers) = (Scan::new(&text[at.clone()]), Vec::with_capacity(6));
    let shift = |own: Range<usize>| at.start + own.start..at.start + own.end;
    for (index, [zero, one]) in [*b"NF", *b"UD", *b"TB"].into_iter().enumerate() {
        if index == 1 && !scan.takes(b'L') {
            scan.takes(b'R');
        }
        let letter = scan.next().filter(|letter| [zero, one].contains(letter))?;
        scan.takes(letter);
        let value = f64::from(u8::from(letter == one));
        numbers.push(Number { component: Component::Arm(index), at: shift(scan.at - 1..scan.at), value });
    }
    for index in 3..6 {
        scan.expect(b',', ",").ok()?;
        let (value, own) = scan.number().ok()?;
        numbers.push(Number { component: Component::Arm(index), at: shift(own), value });
    }
    scan.is_done().then_some(numbers)
}

/// Frames of a controller by kind (0 UFRAME in the world, 1 UTOOL in the flange) and number, mm.
type SystemFrames = HashMap<(usize, u32), Isometry3<f64>>;

/// Reads `$MNUFRAME` and `$MNUTOOL` of motion group 1 in a `sysframe.va`; entries without all six numbers are left out.
fn read_system_frames(bytes: &[u8]) -> SystemFrames {
    let (mut frames, mut kind, mut entry, mut found) = (SystemFrames::new(), None, None, Vec::new());
    for line in String::from_utf8_lossy(bytes).lines() {
        let line = line.trim();
        if let Some(variable) = line.strip_prefix("[*SYSTEM*]") {
            let name = variable.split_whitespace().next();
            kind = ["$MNUFRAME", "$MNUTOOL"].iter().position(|known| Some(*known) == name);
            entry = None;
        } else if let Some(index) = line.strip_prefix('[') {
            let number = index.strip_prefix("1,").and_then(|rest| rest.split(']').next()?.trim().parse().ok());
            (entry, found) = (kind.zip(number), Vec::new());
        } else if let Some(entry) = entry {
            let line = line.replace(':', " ");
            let mut words = line.split_whitespace();
            while let Some(word) = words.next() {
                if "XYZWPR".get(found.len()..=found.len()) == Some(word)
                    && let Some(Ok(number)) = words.next().map(str::parse::<f64>)
                    && number.is_finite()
                {
                    found.push(number);
                }
            }
            if let [x, y, z, w, p, r] = found[..] {
                frames.insert(entry, Isometry3::from_parts(Translation3::new(x, y, z), rotation_of_abc([r, p, w])));
            }
        }
    }
    frames
}
