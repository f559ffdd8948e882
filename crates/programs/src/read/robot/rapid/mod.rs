//! ABB RAPID: statements of a module, with the targets, tools, work objects and speeds that it declares.
//!
//! Followed are MoveL, MoveC, MoveJ and MoveAbsJ. What is known not to move the tool is ignored, and all else is refused. All motions
//! must be in one routine; its caller does not matter, as each motion names its tool, work object and speed. Procedures that a `main` does not lead
//! to stay as they are.

use std::collections::BTreeSet;

use crate::{
    model::robot::{RobotFault, RobotOptions, Statement},
    read::{
        robot::{Bases, LocatedFault, Tools, rapid::data::ModuleData, scan::check_depth},
        scan::Scan,
    },
};

mod calls;
mod data;
mod lex;
mod motion;

pub(crate) use {
    calls::{has_code_behind, uncalled},
    data::parse_target,
    lex::{CodeUnit, CodeUnits, code_bytes_before, one_line_statement, option_start, split_arguments},
    motion::zone_of,
};

/// A reader of RAPID statements with the modes in force.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    source: &'a [u8],
    options: &'a RobotOptions,
    units: CodeUnits<'a>,
    data: Option<ModuleData>,
    bases: Bases<'a>,
    tools: Tools<'a>,
    /// Keywords and lines of the open branches and loops.
    enclosing: Vec<(String, usize)>,
    /// Line of the present routine, and its name in upper case.
    routine: (usize, String),
    /// Whether it is a function.
    is_function: bool,
    /// Names of routines in upper case that are not called.
    uncalled: BTreeSet<String>,
    /// Those of them that move the tool.
    pub left_out: Vec<String>,
    /// Line of the routine that has the motions.
    motion_routine: Option<usize>,
    /// Line that leaves the routine before its end.
    end_line: Option<usize>,
    /// Whether VelSet leaves velocities as programmed.
    is_speed_unscaled: bool,
    /// Whether the control leaves the posture open on paths and from point to point (ConfL\\Off, ConfJ\\Off).
    is_posture_open: [bool; 2],
}

impl<'a> Reader<'a> {
    /// Starts at the first statement of `source`.
    pub fn new(source: &'a [u8], options: &'a RobotOptions) -> Self {
        Self {
            source,
            options,
            units: CodeUnits::new(source),
            data: None,
            bases: Bases::new(options, source),
            tools: Tools::new(options),
            enclosing: Vec::new(),
            routine: (1, String::new()),
            is_function: false,
            uncalled: BTreeSet::new(),
            left_out: Vec::new(),
            motion_routine: None,
            end_line: None,
            is_speed_unscaled: true,
            is_posture_open: [false; 2],
        }
    }

    /// Returns the tools that motions have used so far.
    pub fn tools(&self) -> &Tools<'a> {
        &self.tools
    }

    /// Returns the next statement that moves the tool; `None` at the end, `Err` for a statement that is not followed.
    pub fn next(&mut self) -> Result<Option<Statement>, LocatedFault> {
        if self.data.is_none() {
            self.data = Some(ModuleData::read(self.source)?);
            self.uncalled = uncalled(self.source)?;
        }
        while let Some(unit) = self.units.next()? {
            if unit.is_statement && self.uncalled.contains(&self.routine.1) {
                if is_motion(&unit.word) && self.left_out.last() != Some(&self.routine.1) {
                    self.left_out.push(self.routine.1.clone());
                }
                continue;
            }
            let found = if unit.is_statement { self.follow_statement(&unit) } else { self.follow_structure(&unit) };
            let refuse = |fault| LocatedFault { line: unit.line, at: unit.at.clone(), fault };
            if let Some(statement) = found.map_err(refuse)? {
                return Ok(Some(statement));
            }
        }
        Ok(None)
    }

    /// Follows a word of structure: routines, branches and loops.
    fn follow_structure(&mut self, unit: &CodeUnit) -> Result<Option<Statement>, RobotFault> {
        let mut scan = Scan::new(&self.source[unit.at.clone()]);
        if scan.peek() == Some(b'%') && !self.routine.1.is_empty() && !self.uncalled.contains(&self.routine.1) {
            return RobotFault::not_followed("calls of procedures whose names are computed are", "the name itself");
        }
        let mut word = scan.name().0.to_ascii_uppercase();
        if word == "LOCAL" {
            word = scan.name().0.to_ascii_uppercase();
        }
        if matches!(word.as_str(), "PROC" | "FUNC" | "TRAP" | "TEST")
            && has_code_behind(&self.source[unit.at.clone()], &word)
        {
            return Err(CODE_BEHIND);
        }
        let asks = matches!(word.as_str(), "IF" | "ELSEIF" | "WHILE" | "FOR" | "TEST" | "CASE");
        if asks && !self.uncalled.contains(&self.routine.1) {
            self.check_functions(unit)?;
        }
        match word.as_str() {
            "PROC" | "FUNC" | "TRAP" => {
                self.is_function = word == "FUNC";
                let name = match self.is_function {
                    true => calls::name_in(&self.source[unit.at.clone()]).unwrap_or_default(),
                    false => scan.name().0.to_ascii_uppercase(),
                };
                self.routine = (unit.line, name);
                (self.end_line, self.enclosing) = (None, Vec::new());
                if word == "TRAP" {
                    self.enclosing.push((word, unit.line));
                }
            }
            "ENDPROC" | "ENDFUNC" | "ENDTRAP" => self.enclosing.clear(),
            "IF" | "FOR" | "WHILE" | "TEST" => self.enclosing.push((word, unit.line)),
            "ENDIF" | "ENDFOR" | "ENDWHILE" | "ENDTEST" => drop(self.enclosing.pop()),
            // What handles errors runs if there are any.
            "ERROR" | "UNDO" | "BACKWARD" => self.enclosing.push((word, unit.line)),
            _ => {}
        }
        Ok(None)
    }

    /// Follows a statement: returns it if it moves the tool, or else sets modes; `Err` if it is not followed.
    fn follow_statement(&mut self, unit: &CodeUnit) -> Result<Option<Statement>, RobotFault> {
        if unit.word != "IF" {
            self.check_functions(unit)?;
        }
        match unit.word.as_str() {
            "MOVEL" | "MOVEC" | "MOVEJ" | "MOVEABSJ" => return self.motion(unit).map(Some),
            word if is_other_motion(word) => {
                return RobotFault::not_followed(
                    "motions with signals, searches and processes are",
                    "MoveL, MoveC, MoveJ and MoveAbsJ",
                );
            }
            "IF" => return self.follow_one_line_if(unit),
            "GOTO" => {
                return RobotFault::not_followed("jumps are", "the motions in the order they run");
            }
            "RETURN" | "EXIT" if self.enclosing.is_empty() => self.end_line = Some(unit.line),
            "PDISPON" | "PDISPSET" | "EOFFSON" | "EOFFSSET" | "SOFTACT" | "CORRCON" | "CORRWRITE" | "WORLDACCLIM" => {
                return RobotFault::not_followed("displaced programs are", "targets where they are");
            }
            "CIRPATHMODE" if !self.text(unit).to_ascii_uppercase().contains("\\PATHFRAME") => {
                return RobotFault::not_followed(
                    "circles that carry the orientation along are",
                    "CirPathMode\\PathFrame",
                );
            }
            "VELSET" => {
                let first = Scan::new(&self.text(unit).as_bytes()[unit.word.len()..]).number();
                self.is_speed_unscaled = first.is_ok_and(|(share, _)| share == 100.0);
            }
            "CONFL" | "CONFJ" => {
                self.is_posture_open[usize::from(unit.word == "CONFJ")] =
                    self.text(unit).to_ascii_uppercase().contains("\\OFF");
            }
            "CONST" | "PERS" | "VAR" | "LOCAL" | "TASK" | "ALIAS" => {}
            word if is_ignored(word) => {}
            "" => return Err(RobotFault::Unknown { expected: "a statement of RAPID" }),
            word => {
                let text = self.text(unit);
                let mut behind = Scan::new(&text.as_bytes()[word.len()..]);
                let is_assignment = lex::code_bytes(text.as_bytes())
                    .any(|(at, byte)| byte == b':' && text.as_bytes().get(at + 1) == Some(&b'='));
                let is_place = matches!(behind.next(), Some(b':' | b'.' | b'{'));
                if !(is_assignment && is_place) {
                    self.check_call(word)?;
                }
            }
        }
        Ok(None)
    }

    /// Returns the text of a unit.
    fn text(&self, unit: &CodeUnit) -> String {
        String::from_utf8_lossy(&self.source[unit.at.clone()]).into_owned()
    }

    /// Follows the statement of `IF condition statement;` as one within a branch.
    fn follow_one_line_if(&mut self, unit: &CodeUnit) -> Result<Option<Statement>, RobotFault> {
        let text = &self.source[unit.at.clone()];
        check_depth(text, 1 + self.enclosing.iter().filter(|(_, line)| *line == unit.line).count())?;
        let start = lex::one_line_statement(text);
        let start = start.ok_or(RobotFault::Form { expected: "IF condition statement" })?;
        let at = unit.at.start + start..unit.at.end;
        self.check_functions(&CodeUnit { at: unit.at.start..at.start, ..unit.clone() })?;
        let word = Scan::new(&self.source[at.clone()]).name().0.to_ascii_uppercase();
        if word == "GOTO" {
            return Err(RobotFault::Branch { keyword: "IF".into(), line: unit.line });
        }
        self.enclosing.push(("IF".into(), unit.line));
        let found = self.follow_statement(&CodeUnit { at, word, ..unit.clone() });
        self.enclosing.pop();
        found
    }

    /// Refuses functions in a unit that are neither the module's nor RAPID's, unless the options say that they move nothing.
    fn check_functions(&self, unit: &CodeUnit) -> Result<(), RobotFault> {
        let is_own = |name: &String| self.data.as_ref().is_some_and(|data| data.functions.contains(name));
        let known = |name: &String| {
            *name == unit.word || calls::is_known(name) || is_own(name) || self.options.keeps_call(name)
        };
        match lex::called_names(&self.source[unit.at.clone()]).find(|name| !known(name)) {
            Some(name) => Err(RobotFault::Call { name }),
            None => Ok(()),
        }
    }

    /// Refuses a call of `name` unless the module has it or the options say that it moves nothing.
    fn check_call(&self, name: &str) -> Result<(), RobotFault> {
        let kept = self.options.keeps_call(name);
        // All motions are in one routine: a routine of the module that another calls moves nothing, or is the one that does.
        let known = self.data.as_ref().is_some_and(|data| data.procedures.iter().any(|known| known == name));
        if kept || (known && name != self.routine.1) { Ok(()) } else { Err(RobotFault::Call { name: name.to_owned() }) }
    }

    /// Refuses a motion within a branch or loop, behind the end, or in a second routine.
    fn check_runs_once(&mut self) -> Result<(), RobotFault> {
        if self.is_function {
            return Err(MOTION_IN_FUNCTION);
        }
        if let Some((keyword, line)) = self.enclosing.first() {
            return Err(RobotFault::Branch { keyword: keyword.clone(), line: *line });
        }
        if let Some(end) = self.end_line {
            return Err(RobotFault::AfterEnd { end });
        }
        let first = *self.motion_routine.get_or_insert(self.routine.0);
        match first == self.routine.0 {
            true => Ok(()),
            false => Err(RobotFault::SecondRoutine { line: self.routine.0, first }),
        }
    }
}

pub(crate) const CODE_BEHIND: RobotFault = RobotFault::Form { expected: "nothing behind it on its line" };
pub(crate) const MOTION_IN_FUNCTION: RobotFault =
    RobotFault::NotFollowed { what: "motions in functions are", expected: "procedures that move" };

/// Instructions that are ignored: they neither move the tool nor change what a motion means.
const IGNORED: &str = "SET RESET SETDO SETAO SETGO PULSEDO INVERTDO WAITTIME WAITDI WAITDO WAITAI WAITGI WAITUNTIL WAITROB \
    WAITSYNCTASK TPWRITE TPERASE TPREADFK TPREADNUM CONFL CONFJ SINGAREA ACCSET PATHACCLIM PATHRESOL PDISPOFF \
    EOFFSOFF SOFTDEACT GRIPLOAD ACTUNIT DEACTUNIT INCR DECR ADD CLEAR CLKRESET CLKSTART CLKSTOP OPEN CLOSE WRITE \
    STOP BREAK CIRPATHMODE RETURN";

/// Whether `word` neither moves the tool nor changes what a motion means.
pub(crate) fn is_ignored(word: &str) -> bool {
    IGNORED.split_whitespace().any(|kept| kept == word)
}

/// Whether `word` moves the tool.
pub(crate) fn is_motion(word: &str) -> bool {
    word.starts_with("MOVE") || is_other_motion(word)
}

/// Whether `word` moves the tool in a way that is not followed.
fn is_other_motion(word: &str) -> bool {
    let begins = [
        "MOVE", "TRIGGL", "TRIGGC", "TRIGGJ", "SEARCH", "ARCL", "ARCC", "PAINT", "SPOT", "DISPL", "DISPC", "CAPL",
        "CAPC",
    ];
    begins.iter().any(|begin| word.starts_with(begin))
        || matches!(word, "STARTMOVE" | "INDAMOVE" | "INDRMOVE" | "INDCMOVE")
}
