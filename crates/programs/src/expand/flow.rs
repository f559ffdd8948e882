//! Branches, loops and jumps: Fanuc's IF, WHILE and GOTO, LinuxCNC's O words.

use crate::{
    expand::{
        calls::CallTarget,
        expression::Reader,
        jumps::{do_number, end_number},
        line::{SourceLine, evaluate_line},
        run::{Next, Run},
        variables::{Arguments, Kind},
    },
    model::gcode::{Fault, MacroFault},
    read::gcode::Origin,
};

impl Run<'_> {
    /// Runs a line with Fanuc's IF, GOTO, WHILE, DO or END, and returns which line comes next.
    pub(crate) fn follow_fanuc_flow(&mut self, line: &SourceLine) -> Result<Next, Fault> {
        let from = line.code.len() - line.code[line.begin..].trim_start().len();
        let mut reader = Reader::new(&line.code, from, &self.variables);
        let labelled = |number: f64| {
            self.source().label_at(self.here.line, number as u32).map(Next::At).ok_or(Fault::Macro(MacroFault::NoLabel))
        };
        if reader.takes("GOTO") {
            return labelled(reader.number()?);
        }
        if let Some(number) = end_number(line) {
            return self
                .source()
                .find_do_before(self.here.line, number)
                .map(Next::At)
                .ok_or(Fault::Macro(MacroFault::NoLabel));
        }
        if reader.takes("IF") {
            let is_true = reader.bracket()?.is_some_and(|value| value != 0.0);
            if reader.takes("GOTO") {
                return if is_true { labelled(reader.number()?) } else { Ok(Next::Line) };
            }
            if !reader.takes("THEN") {
                return Err(Fault::Macro(MacroFault::Expression { expected: "GOTO or THEN" }));
            }
            if is_true {
                let rest = SourceLine::new(&line.code.as_bytes()[reader.at..]);
                evaluate_line(&rest, &mut self.variables).map_err(|(_, fault)| fault)?;
            }
            return Ok(Next::Line);
        }
        let Some(number) = do_number(line) else {
            return Err(Fault::Macro(MacroFault::Expression { expected: "DO and a number" }));
        };
        let is_true = !reader.takes("WHILE") || reader.bracket()?.is_some_and(|value| value != 0.0);
        let after = self.source().find_end_after(self.here.line, number).ok_or(Fault::Macro(MacroFault::NoLabel))?;
        Ok(if is_true { Next::Line } else { Next::At(after + 1) })
    }

    /// Returns the line behind the first ELSEIF that is true, ELSE or ENDIF, of the IF of O word `name` on this line.
    fn other_branch(&self, name: &str) -> Result<Next, Fault> {
        let mut next = self.here.line;
        loop {
            next = self
                .source()
                .next_o_line(next + 1, name, &["ELSEIF", "ELSE", "ENDIF"])
                .ok_or(Fault::Macro(MacroFault::NoLabel))?;
            let branch = &self.source().lines[next];
            if branch.keyword() != "ELSEIF" {
                return Ok(Next::At(next + 1));
            }
            let from = branch.code.len() - branch.code[branch.begin..].trim_start().len() + "ELSEIF".len();
            if Reader::new(&branch.code, from, &self.variables).bracket()?.is_some_and(|value| value != 0.0) {
                return Ok(Next::At(next + 1));
            }
        }
    }

    /// Runs a line with LinuxCNC's O word `name` (sub, call, if, while, repeat, …), and returns which line comes next.
    pub(crate) fn follow_o_word(&mut self, line: &SourceLine, name: &str) -> Result<Next, Fault> {
        let here = self.here.line;
        let from = line.code.len() - line.code[line.begin..].trim_start().len() + line.keyword().len();
        let mut reader = Reader::new(&line.code, from, &self.variables);
        let missing = || Fault::Macro(MacroFault::NoLabel);
        let after = |keywords: &[&str]| self.source().next_o_line(here + 1, name, keywords).ok_or_else(missing);
        match line.keyword() {
            "SUB" => Ok(Next::At(after(&["ENDSUB"])? + 1)),
            "ENDSUB" | "RETURN" => {
                let value = if reader.peek() == Some(b'[') { reader.bracket()? } else { None };
                let next = self.end_call()?;
                self.variables.set("_VALUE", value)?;
                Ok(next)
            }
            "CALL" => {
                let mut arguments: Arguments = Vec::new();
                while reader.peek() == Some(b'[') {
                    let value = reader.bracket()?.ok_or(Fault::Macro(MacroFault::NoValue))?;
                    arguments.push(((arguments.len() + 1).to_string(), Kind::Real, value));
                }
                let begin = self.find_subprogram(name, CallTarget::Word)?;
                let next = self.call(begin, 1, Some(arguments))?;
                self.call_frames.last_mut().into_iter().for_each(|frame| frame.by_o_word = true);
                Ok(next)
            }
            "IF" => {
                let is_true = reader.bracket()?.is_some_and(|value| value != 0.0);
                if is_true {
                    return Ok(Next::Line);
                }
                self.other_branch(name)
            }
            // The end of a branch that was taken.
            "ELSEIF" | "ELSE" => Ok(Next::At(after(&["ENDIF"])? + 1)),
            "ENDIF" | "DO" => Ok(Next::Line),
            "WHILE" => {
                let is_true = reader.bracket()?.is_some_and(|value| value != 0.0);
                match self.source().next_o_line(here + 1, name, &["ENDWHILE"]) {
                    Some(end) => Ok(if is_true { Next::Line } else { Next::At(end + 1) }),
                    None if is_true => {
                        self.source().last_o_line(here, name, &["DO"]).map(|at| Next::At(at + 1)).ok_or_else(missing)
                    }
                    None => Ok(Next::Line),
                }
            }
            "ENDWHILE" => self.source().last_o_line(here, name, &["WHILE"]).map(Next::At).ok_or_else(missing),
            "REPEAT" => {
                let times = reader.number()?;
                let end = after(&["ENDREPEAT"])?;
                if times < 1.0 {
                    return Ok(Next::At(end + 1));
                }
                self.repeats.push((self.here, times as u32));
                Ok(Next::Line)
            }
            "ENDREPEAT" => {
                let begin = self.source().last_o_line(here, name, &["REPEAT"]).ok_or_else(missing)?;
                let file = self.here.file;
                let active = self.repeats.last_mut().filter(|(at, _)| *at == Origin { file, line: begin });
                let (_, runs_left) = active.ok_or_else(missing)?;
                *runs_left -= 1;
                if *runs_left > 0 {
                    return Ok(Next::At(begin + 1));
                }
                self.repeats.pop();
                Ok(Next::Line)
            }
            "BREAK" | "CONTINUE" => {
                let is_repeat = self.source().last_o_line(here, name, &["REPEAT"]).is_some();
                let end = after(&["ENDWHILE", "ENDREPEAT", "WHILE"])?;
                if line.keyword() == "CONTINUE" {
                    return Ok(Next::At(end));
                }
                if is_repeat {
                    self.repeats.pop();
                }
                Ok(Next::At(end + 1))
            }
            _ => Err(Fault::Macro(MacroFault::Expression {
                expected: "a word such as sub, call, if, while, repeat or do",
            })),
        }
    }
}
