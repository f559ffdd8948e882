//! ABB RAPID: statements of a module, with the targets, tools, work objects and speeds that it declares.
//!
//! Followed are MoveL, MoveC, MoveJ and MoveAbsJ; what is known not to move the tool is passed by, and all else is
//! refused. All motions stand in one routine; from where it is called does not matter, since every motion names its
//! tool, work object and speed.

use crate::toolpath::{
    model::robot::{RobotFault, RobotOptions, Statement},
    read::{
        robot::{
            Bases, Refusal, Tools,
            rapid::{
                data::Data,
                lex::{Unit, Units},
            },
        },
        scan::Scan,
    },
};

mod data;
mod lex;
mod motion;

/// Goes through a module from its begin on.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    source: &'a [u8],
    options: &'a RobotOptions,
    units: Units<'a>,
    /// `None` before the first statement is asked for.
    data: Option<Data>,
    bases: Bases<'a>,
    tools: Tools<'a>,
    /// Branches and loops around the statement, and where they begin.
    around: Vec<(String, usize)>,
    /// Where the routine begins, and its name in capitals.
    routine: (usize, String),
    /// Where the routine with the motions begins.
    moving: Option<usize>,
    /// Where the routine ends, if before its end.
    ended: Option<usize>,
    /// Whether VelSet leaves velocities as they are programmed.
    speeds_hold: bool,
}

impl<'a> Reader<'a> {
    pub fn new(source: &'a [u8], options: &'a RobotOptions) -> Self {
        Self {
            source,
            options,
            units: Units::new(source),
            data: None,
            bases: Bases::new(options),
            tools: Tools::new(options),
            around: Vec::new(),
            routine: (1, String::new()),
            moving: None,
            ended: None,
            speeds_hold: true,
        }
    }

    /// The tools that motions used so far.
    pub fn tools(&self) -> &Tools<'a> {
        &self.tools
    }

    /// The next statement that moves the tool.
    pub fn next(&mut self) -> Result<Option<Statement>, Refusal> {
        if self.data.is_none() {
            self.data = Some(Data::of(self.source)?);
        }
        while let Some(unit) = self.units.next()? {
            let found = if unit.is_statement { self.statement(&unit) } else { self.structure(&unit) };
            let refuse = |fault| Refusal { line: unit.line, at: unit.at.clone(), fault };
            if let Some(statement) = found.map_err(refuse)? {
                return Ok(Some(statement));
            }
        }
        Ok(None)
    }

    fn structure(&mut self, unit: &Unit) -> Result<Option<Statement>, RobotFault> {
        let mut scan = Scan::new(&self.source[unit.at.clone()]);
        let mut word = scan.name().0.to_ascii_uppercase();
        if word == "LOCAL" {
            word = scan.name().0.to_ascii_uppercase();
        }
        match word.as_str() {
            "PROC" | "FUNC" | "TRAP" => {
                self.routine = (unit.line, scan.name().0.to_ascii_uppercase());
                (self.ended, self.around) = (None, Vec::new());
                if word == "TRAP" {
                    self.around.push((word, unit.line));
                }
            }
            "ENDPROC" | "ENDFUNC" | "ENDTRAP" => self.around.clear(),
            "IF" | "FOR" | "WHILE" | "TEST" => self.around.push((word, unit.line)),
            "ENDIF" | "ENDFOR" | "ENDWHILE" | "ENDTEST" => drop(self.around.pop()),
            // What handles errors runs if there are any.
            "ERROR" | "UNDO" | "BACKWARD" => self.around.push((word, unit.line)),
            _ => {}
        }
        Ok(None)
    }

    fn statement(&mut self, unit: &Unit) -> Result<Option<Statement>, RobotFault> {
        match unit.word.as_str() {
            "MOVEL" | "MOVEC" | "MOVEJ" | "MOVEABSJ" => return self.motion(unit).map(Some),
            word if is_other_motion(word) => {
                return Err(RobotFault::NotFollowed {
                    what: "motions with signals, searches and processes are",
                    expected: "MoveL, MoveC, MoveJ and MoveAbsJ",
                });
            }
            "IF" => self.if_with_statement(unit)?,
            "GOTO" => {
                return Err(RobotFault::NotFollowed {
                    what: "jumps are",
                    expected: "the motions in the order they run",
                });
            }
            "RETURN" | "EXIT" if self.around.is_empty() => self.ended = Some(unit.line),
            "PDISPON" | "PDISPSET" | "EOFFSON" | "EOFFSSET" | "SOFTACT" | "CORRCON" | "CORRWRITE" | "WORLDACCLIM" => {
                return Err(RobotFault::NotFollowed {
                    what: "displaced programs are",
                    expected: "targets where they are",
                });
            }
            "CIRPATHMODE" if !self.text(unit).to_ascii_uppercase().contains("\\PATHFRAME") => {
                return Err(RobotFault::NotFollowed {
                    what: "circles that carry the orientation along are",
                    expected: "CirPathMode\\PathFrame",
                });
            }
            "VELSET" => {
                let first = Scan::new(&self.text(unit).as_bytes()[unit.word.len()..]).number();
                self.speeds_hold = first.is_ok_and(|(share, _)| share == 100.0);
            }
            "CONST" | "PERS" | "VAR" | "LOCAL" | "TASK" | "ALIAS" => {}
            word if KEPT.split_whitespace().any(|kept| kept == word) => {}
            "" => return Err(RobotFault::Unknown { expected: "a statement of RAPID" }),
            word => {
                let text = self.text(unit);
                let mut behind = Scan::new(&text.as_bytes()[word.len()..]);
                let is_assignment = lex::code(text.as_bytes())
                    .any(|(at, byte)| byte == b':' && text.as_bytes().get(at + 1) == Some(&b'='));
                let is_place = matches!(behind.next(), Some(b':' | b'.' | b'{'));
                if !(is_assignment && is_place) {
                    self.check_call(word)?;
                }
            }
        }
        Ok(None)
    }

    fn text(&self, unit: &Unit) -> String {
        String::from_utf8_lossy(&self.source[unit.at.clone()]).into_owned()
    }

    /// `IF condition statement;`, without THEN.
    fn if_with_statement(&self, unit: &Unit) -> Result<(), RobotFault> {
        let text = self.text(unit).to_ascii_uppercase();
        let words = || text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        let moves = |word: &str| matches!(word, "MOVEL" | "MOVEC" | "MOVEJ" | "MOVEABSJ") || is_other_motion(word);
        match words().any(|word| moves(word) || word == "GOTO") {
            true => Err(RobotFault::Branch { keyword: "IF".into(), line: unit.line }),
            false => Ok(()),
        }
    }

    fn check_call(&self, name: &str) -> Result<(), RobotFault> {
        let kept = self.options.calls_kept.iter().any(|kept| kept.eq_ignore_ascii_case(name));
        // All motions are in one routine, so that a routine of the module that another calls moves nothing, or is the
        // one that does.
        let known = self.data.as_ref().is_some_and(|data| data.procedures.iter().any(|known| known == name));
        if kept || (known && name != self.routine.1) { Ok(()) } else { Err(RobotFault::Call { name: name.to_owned() }) }
    }

    /// Whether a motion stands where it runs once, in the one routine that moves the tool.
    fn check_runs_once(&mut self) -> Result<(), RobotFault> {
        if let Some((keyword, line)) = self.around.first() {
            return Err(RobotFault::Branch { keyword: keyword.clone(), line: *line });
        }
        if let Some(end) = self.ended {
            return Err(RobotFault::AfterEnd { end });
        }
        let first = *self.moving.get_or_insert(self.routine.0);
        match first == self.routine.0 {
            true => Ok(()),
            false => Err(RobotFault::SecondRoutine { line: self.routine.0, first }),
        }
    }
}

/// Instructions that neither move the tool nor change what a motion means.
const KEPT: &str = "SET RESET SETDO SETAO SETGO PULSEDO INVERTDO WAITTIME WAITDI WAITDO WAITAI WAITGI WAITUNTIL WAITROB \
    WAITSYNCTASK TPWRITE TPERASE TPREADFK TPREADNUM CONFL CONFJ SINGAREA ACCSET PATHACCLIM PATHRESOL PDISPOFF \
    EOFFSOFF SOFTDEACT GRIPLOAD ACTUNIT DEACTUNIT INCR DECR ADD CLEAR CLKRESET CLKSTART CLKSTOP OPEN CLOSE WRITE \
    STOP BREAK CIRPATHMODE RETURN";

fn is_other_motion(word: &str) -> bool {
    let begins = [
        "MOVE", "TRIGGL", "TRIGGC", "TRIGGJ", "SEARCH", "ARCL", "ARCC", "PAINT", "SPOT", "DISPL", "DISPC", "CAPL",
        "CAPC",
    ];
    begins.iter().any(|begin| word.starts_with(begin))
        || matches!(word, "STARTMOVE" | "INDAMOVE" | "INDRMOVE" | "INDCMOVE")
}
