//! Sinumerik's programs line by line: R parameters and DEF, branches, loops, jumps and repetitions, and words with their values.
//!
//! Jumps, loops and repetitions run as Siemens, *SINUMERIK 840D sl/828D Programming Manual Fundamentals* (jumps, REPEAT) and *Job Planning*
//! (DEF, check structures) say.

use std::ops::Range;

use crate::{
    expand::{
        calls::CallTarget,
        expression::Reader,
        line::{SourceLine, long_number},
        run::{Next, Run, Section, Step},
        variables::{Arguments, Kind, Variables, is_r_parameter},
    },
    model::gcode::{Fault, Foreign, MacroFault},
    read::{
        gcode::{Origin, dialect::sinumerik_words, lines::is_blank},
        scan::Scan,
    },
};

/// Most elements of an array.
const MAX_ELEMENTS: f64 = 10_000.0;

/// A line with values for its expressions.
pub(crate) struct Evaluated {
    pub bytes: Vec<u8>,
    /// Whether anything is left of its code.
    pub has_code: bool,
    /// Whether it ends the program or subprogram.
    pub ends: bool,
}

impl SourceLine {
    /// Returns 1 if the line begins a block of Sinumerik's (IF, FOR, …), -1 if it ends one, 0 otherwise.
    pub fn block_change(&self) -> i32 {
        match self.first_word() {
            "IF" => i32::from(!self.has_jump()),
            "REPEAT" => i32::from(self.rest() == "REPEAT"),
            "FOR" | "WHILE" | "LOOP" => 1,
            "ENDIF" | "ENDFOR" | "ENDWHILE" | "ENDLOOP" | "UNTIL" => -1,
            _ => 0,
        }
    }

    /// Whether the line jumps.
    fn has_jump(&self) -> bool {
        self.rest().split(|c: char| !c.is_ascii_alphanumeric()).any(|word| word.starts_with("GOTO"))
    }
}

impl Run<'_> {
    /// Runs a line of Sinumerik's, and returns which line comes next.
    pub(crate) fn follow_sinumerik(&mut self, line: &SourceLine) -> Step {
        let at = |fault| (line.begin, fault);
        if line.is_percent() {
            let is_first = self.is_first_code();
            if !self.calls.is_empty() && !is_first {
                return Err((0, Fault::Macro(MacroFault::NoReturn)));
            }
            if self.calls.is_empty() && is_first {
                self.write_line(line.bytes.clone());
            }
            return Ok(if is_first { Next::Line } else { Next::End });
        }
        match line.first_word() {
            "IF" | "ELSE" | "ENDIF" | "WHILE" | "ENDWHILE" | "FOR" | "ENDFOR" | "LOOP" | "ENDLOOP" | "REPEAT"
            | "REPEATB" | "UNTIL" | "GOTO" | "GOTOF" | "GOTOB" | "GOTOC" => {
                self.follow_sinumerik_flow(line).map_err(at)
            }
            "ENDLABEL" => Ok(Next::Line),
            "DEF" => self.declare(line).map_err(at),
            "PROC" | "EXTERN" => Ok(Next::Line),
            name if self.is_call(line, name) => self.call_sinumerik(line).map_err(at),
            _ => {
                self.decimals = self.decimals.max(line.decimals());
                let is_main = self.calls.is_empty();
                let evaluated = evaluate(line, &mut self.variables, is_main)?;
                if evaluated.has_code {
                    self.write_line(evaluated.bytes);
                }
                match evaluated.ends {
                    true if is_main => Ok(Next::End),
                    true => self.end_call().map_err(at),
                    false => Ok(Next::Line),
                }
            }
        }
    }

    /// Whether a line that begins with `name` calls a subprogram: `L100`, `NAME`, `NAME(1,2)`, `CALL "NAME"`.
    fn is_call(&self, line: &SourceLine, name: &str) -> bool {
        let rest = line.rest()[name.len()..].trim_start();
        let is_numbered = name.strip_prefix('L').is_some_and(|number| number.parse::<u32>().is_ok());
        let is_name = name.len() > 1 && name.bytes().take(2).all(|byte| byte.is_ascii_alphabetic() || byte == b'_');
        let has_arguments = rest.starts_with('(');
        let is_free = || matches!(sinumerik_words::plain_name(name, has_arguments), Err(Foreign::Call));
        let ends = rest.is_empty() || has_arguments || rest.starts_with('P') || name == "CALL";
        ends && (is_numbered || (is_name && is_free()))
    }

    /// Runs a call: finds the subprogram and begins it, with its parameters (PROC), as often as P says.
    fn call_sinumerik(&mut self, line: &SourceLine) -> Result<Next, Fault> {
        let mut reader = Reader::new(&line.code, line.begin, &self.variables);
        let mut name = reader.identifier();
        if name == "CALL" {
            let quoted = line.code[reader.at..].trim().strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
            name = quoted.ok_or(Fault::Macro(MacroFault::Expression { expected: "a name in quotes" }))?.to_owned();
            reader.at = line.code.len();
        }
        let values = if reader.peek() == Some(b'(') { arguments(line, &mut reader)? } else { Vec::new() };
        let mut times = 1.0;
        if reader.takes("P") {
            let is_assigned = reader.takes("=");
            let value = if is_assigned { reader.expression()? } else { reader.value()? };
            times = value.filter(|times| times.fract() == 0.0 && (0.0..=9999.0).contains(times)).unwrap_or(f64::NAN);
        }
        expect_end(&mut reader)?;
        if times.is_nan() {
            return Err(Fault::Macro(MacroFault::Expression { expected: "P as a whole number" }));
        }
        let begin = self.find_subprogram(&name, CallTarget::Number)?;
        let parameters = self.parameters(begin)?;
        if values.len() > parameters.len() {
            return Err(Fault::Macro(MacroFault::Expression { expected: "as many arguments as PROC has" }));
        }
        let value = |at: usize| values.get(at).and_then(|value| Some(value.as_ref()?.0));
        let given =
            |(at, (name, kind, default)): (usize, (String, Kind, f64))| (name, kind, value(at).unwrap_or(default));
        let mut arguments: Arguments = parameters.into_iter().enumerate().map(given).collect();
        arguments.iter_mut().for_each(|(_, kind, value)| *value = kind.converted(*value));
        self.call(begin, times as u32, Some(arguments))
    }

    /// Returns the parameters of the PROC that the subprogram at `begin` begins with, and their defaults; none without PROC.
    fn parameters(&self, begin: Origin) -> Result<Arguments, Fault> {
        let lines = self.sources[begin.file].lines[begin.line..].iter();
        let Some(line) =
            lines.into_iter().find(|line| !line.rest().is_empty()).filter(|line| line.first_word() == "PROC")
        else {
            return Ok(Vec::new());
        };
        let mut reader = Reader::new(&line.code, line.begin, &self.variables);
        let (_, _, mut parameters) = (reader.identifier(), reader.identifier(), Vec::new());
        let mut goes_on = reader.takes("(") && !reader.takes(")");
        while goes_on {
            let kind = kind_by_name(&reader.identifier())?;
            let name = reader.identifier();
            let default = if reader.takes("=") { reader.expression()? } else { Some(0.0) };
            parameters.push((name, kind, default.ok_or(Fault::Macro(MacroFault::NoValue))?));
            goes_on = reader.takes(",");
            if !goes_on && !reader.takes(")") {
                return Err(Fault::Macro(MacroFault::Expression { expected: ", or )" }));
            }
        }
        while reader.peek().is_some() {
            if !matches!(reader.identifier().as_str(), "DISPLOF" | "DISPLON" | "SBLOF" | "SBLON" | "ACTBLOCNO") {
                return Err(Fault::Macro(MacroFault::Expression { expected: "PROC without SAVE and the like" }));
            }
        }
        Ok(parameters)
    }

    /// Runs a line that branches, loops, jumps or repeats, and returns which line comes next.
    fn follow_sinumerik_flow(&mut self, line: &SourceLine) -> Result<Next, Fault> {
        let here = self.here.line;
        let missing = || Fault::Macro(MacroFault::NoLabel);
        let after =
            |words: &[&str]| self.source().block_end(here, words).map(|end| Next::At(end + 1)).ok_or_else(missing);
        let begin_of = |word: &str| self.source().block_begin(here, word).ok_or_else(missing);
        let mut reader = Reader::new(&line.code, line.begin, &self.variables);
        let word = reader.identifier();
        if matches!(word.as_str(), "ELSE" | "ENDIF" | "LOOP" | "ENDLOOP" | "ENDWHILE" | "ENDFOR") {
            expect_end(&mut reader)?;
        }
        match word.as_str() {
            "IF" if line.has_jump() => loop {
                let is_true = condition(&mut reader)?;
                let (word, target) = (reader.identifier(), reader.identifier());
                if is_true {
                    return self.jump(&word, &target);
                }
                if !reader.takes("IF") {
                    expect_end(&mut reader)?;
                    return Ok(Next::Line);
                }
            },
            "GOTO" | "GOTOF" | "GOTOB" | "GOTOC" => {
                let target = reader.identifier();
                expect_end(&mut reader)?;
                self.jump(&word, &target)
            }
            "IF" => {
                if last_condition(&mut reader)? {
                    Ok(Next::Line)
                } else {
                    after(&["ELSE", "ENDIF"])
                }
            }
            // The end of a branch that was taken.
            "ELSE" => after(&["ENDIF"]),
            "WHILE" => {
                if last_condition(&mut reader)? {
                    Ok(Next::Line)
                } else {
                    after(&["ENDWHILE"])
                }
            }
            "ENDWHILE" => Ok(Next::At(begin_of("WHILE")?)),
            "ENDLOOP" => Ok(Next::At(begin_of("LOOP")?)),
            "UNTIL" => {
                if last_condition(&mut reader)? {
                    Ok(Next::Line)
                } else {
                    Ok(Next::At(begin_of("REPEAT")?))
                }
            }
            "FOR" => {
                let (counter, first, last) = self.counts(line)?;
                self.last_counts.insert(self.here, last);
                self.count(&counter, first, last, here)
            }
            "ENDFOR" => {
                let begin = begin_of("FOR")?;
                let (counter, _, last) = self.counts(&self.source().lines[begin])?;
                let before = self.last_counts.get(&Origin { line: begin, ..self.here });
                let value = self.variables.get(&counter)?.filter(|_| before == Some(&last));
                let expected = "a last value that the loop does not change";
                let value = value.ok_or(Fault::Macro(MacroFault::Expression { expected }))?;
                self.count(&counter, value + 1.0, last, begin)
            }
            "REPEAT" | "REPEATB" if reader.peek().is_some() => self.repeat(line),
            _ => Ok(Next::Line),
        }
    }

    /// Reads `FOR counter = first TO last`, and returns the three.
    fn counts(&self, line: &SourceLine) -> Result<(String, f64, f64), Fault> {
        let mut reader = Reader::new(&line.code, line.begin, &self.variables);
        reader.identifier();
        let counter = reader.identifier();
        let counter = reader.element(counter)?;
        let no_value = || Fault::Macro(MacroFault::NoValue);
        let is_assigned = reader.takes("=");
        let first = if is_assigned { reader.expression()?.ok_or_else(no_value)? } else { 0.0 };
        if !is_assigned || reader.identifier() != "TO" {
            return Err(Fault::Macro(MacroFault::Expression { expected: "FOR counter = first TO last" }));
        }
        let last = reader.expression()?.ok_or_else(no_value)?;
        expect_end(&mut reader)?;
        Ok((counter, first, last))
    }

    /// Sets the counter of the FOR in line `begin` to `value` and runs the loop, or goes on behind it.
    fn count(&mut self, counter: &str, value: f64, last: f64, begin: usize) -> Result<Next, Fault> {
        if value <= last {
            self.variables.set(counter, Some(value))?;
            return Ok(Next::At(begin + 1));
        }
        // What it is behind the loop, the manual does not say.
        self.variables.set(counter, None)?;
        let end = self.source().block_end(begin, &["ENDFOR"]);
        end.map(|end| Next::At(end + 1)).ok_or(Fault::Macro(MacroFault::NoLabel))
    }

    /// Jumps by `word` (GOTOF and its kin) to `target`, a label or block number.
    fn jump(&mut self, word: &str, target: &str) -> Result<Next, Fault> {
        if !matches!(word, "GOTO" | "GOTOF" | "GOTOB" | "GOTOC") || target.is_empty() {
            return Err(Fault::Macro(MacroFault::Expression {
                expected: "GOTOF, GOTOB or GOTO and a label or block number",
            }));
        }
        match self.source().jump_target(self.here.line, word, target) {
            Some(line) => Ok(self.jump_to(line)),
            None if word == "GOTOC" => Ok(Next::Line),
            None => Err(Fault::Macro(MacroFault::NoLabel)),
        }
    }

    /// Runs REPEAT or REPEATB with a label: repeats the block with the label, or the section from there up to a second label, up to
    /// ENDLABEL or up to here.
    fn repeat(&mut self, line: &SourceLine) -> Result<Next, Fault> {
        let mut reader = Reader::new(&line.code, line.begin, &self.variables);
        let is_block = reader.identifier() == "REPEATB";
        let labels: Vec<String> = std::iter::from_fn(|| {
            let before = reader.at;
            let name = reader.identifier();
            if name == "P" {
                reader.at = before;
            }
            (!name.is_empty() && name != "P").then_some(name)
        })
        .collect();
        let times = if reader.takes("P") {
            let assigns = reader.takes("=");
            let times = if assigns { reader.expression()? } else { reader.value()? };
            times.ok_or(Fault::Macro(MacroFault::NoValue))?
        } else {
            1.0
        };
        expect_end(&mut reader)?;
        let here = self.here.line;
        let target = |label: &str| {
            // A label behind the instruction counts as well as one before it.
            let before = self.source().jump_target(here, "GOTOB", label);
            before.or_else(|| self.source().jump_target(here, "GOTOF", label)).ok_or(Fault::Macro(MacroFault::NoLabel))
        };
        let (begin, stop) = match &labels[..] {
            [label] if is_block => (target(label)?, target(label)? + 1),
            [label] => {
                let begin = target(label)?;
                let is_end = |line: &usize| self.source().lines[*line].label.as_deref() == Some("ENDLABEL");
                let end = (begin..self.source().lines.len()).find(|line| *line == here || is_end(line));
                (
                    begin,
                    end.map(|end| if end == here { here } else { end + 1 }).ok_or(Fault::Macro(MacroFault::NoLabel))?,
                )
            }
            [first, last] if !is_block => (target(first)?, target(last)? + 1),
            _ => return Err(Fault::Macro(MacroFault::Expression { expected: "one or two labels, and P=" })),
        };
        if times.fract() != 0.0 || !(0.0..=1e6).contains(&times) || stop <= begin || (begin..stop).contains(&here) {
            return Err(Fault::Macro(MacroFault::Expression {
                expected: "a section elsewhere and a whole number of repetitions",
            }));
        }
        if times < 1.0 {
            return Ok(Next::Line);
        }
        let (return_to, depth) = (here + 1, self.calls.len());
        self.sections.push(Section { begin, stop, return_to, runs_left: times as u32, depth });
        Ok(Next::At(begin))
    }

    /// Runs DEF: declares variables of a type, with their initial values; 0 if there is none.
    fn declare(&mut self, line: &SourceLine) -> Result<Next, Fault> {
        let mut at = line.begin + line.code[line.begin..].find("DEF").unwrap_or(0) + "DEF".len();
        let mut reader = Reader::new(&line.code, at, &self.variables);
        let kind = kind_by_name(&reader.identifier())?;
        at = reader.at;
        loop {
            let mut reader = Reader::new(&line.code, at, &self.variables);
            let name = reader.identifier();
            if name.is_empty() || is_r_parameter(&name) {
                return Err(Fault::Macro(MacroFault::Expression {
                    expected: "names, each with = and its value or without",
                }));
            }
            let size = if reader.peek() == Some(b'[') { reader.bracket()? } else { None };
            let value = if reader.takes("=") { reader.expression()?.filter(|_| size.is_none()) } else { Some(0.0) };
            let value = value.ok_or(Fault::Macro(MacroFault::NoValue))?;
            let goes_on = reader.takes(",");
            at = reader.at;
            if !goes_on {
                expect_end(&mut reader)?;
            }
            match size {
                None => self.variables.declare(&name, kind, value)?,
                Some(size) if (1.0..=MAX_ELEMENTS).contains(&size) => {
                    (0..size as u32)
                        .try_for_each(|element| self.variables.declare(&format!("{name}[{element}]"), kind, value))?;
                }
                Some(_) => {
                    return Err(Fault::Macro(MacroFault::Expression { expected: "an array of 1 to 10000 elements" }));
                }
            }
            if !goes_on {
                return Ok(Next::Line);
            }
        }
    }
}

/// Returns the kind of variables of the type `name`; `Err` for strings, axes and frames.
pub(crate) fn kind_by_name(name: &str) -> Result<Kind, Fault> {
    match name {
        "REAL" => Ok(Kind::Real),
        "INT" => Ok(Kind::Int),
        "BOOL" => Ok(Kind::Bool),
        _ => Err(Fault::Macro(MacroFault::Expression { expected: "REAL, INT or BOOL" })),
    }
}

/// Reads an expression, and returns whether it is true.
fn condition(reader: &mut Reader<'_>) -> Result<bool, Fault> {
    Ok(reader.expression()?.ok_or(Fault::Macro(MacroFault::NoValue))? != 0.0)
}

/// Returns whether the condition at the end of a line holds.
fn last_condition(reader: &mut Reader<'_>) -> Result<bool, Fault> {
    let is_true = condition(reader)?;
    expect_end(reader).map(|()| is_true)
}

/// Refuses what stands behind a complete statement.
pub(crate) fn expect_end(reader: &mut Reader<'_>) -> Result<(), Fault> {
    if reader.peek().is_some() {
        Err(Fault::Macro(MacroFault::Expression { expected: "the end of the block" }))
    } else {
        Ok(())
    }
}

/// Returns a line of words with values for its expressions and without its assignments, which take effect in their order. `Err` gives
/// the faulty byte. The end of a subprogram, unless it `is_main`, is left out too.
pub(crate) fn evaluate(
    line: &SourceLine,
    variables: &mut Variables,
    is_main: bool,
) -> Result<Evaluated, (usize, Fault)> {
    let text = line.code.as_bytes();
    let (mut out, mut from, mut at) = (Vec::new(), 0, line.begin);
    let (mut ends, mut code_bytes) = (false, line.code[line.begin..].trim().len());
    let mut assigned: Vec<String> = Vec::new();
    while at < text.len() {
        let (begin, byte) = (at, text[at]);
        let fail = |fault| (begin, fault);
        match byte {
            b'(' | b'"' => {
                at = closed_end(line, at).map_err(fail)?;
                continue;
            }
            b'$' => return Err(fail(Fault::Foreign(Foreign::Parameter))),
            _ if byte.is_ascii_alphabetic() || byte == b'_' => {}
            _ => {
                at += 1;
                continue;
            }
        }
        let is_name = byte == b'_' || text.get(at + 1).is_some_and(|next| next.is_ascii_alphabetic() || *next == b'_');
        let mut reader = Reader::new(&line.code, at, variables);
        let mut name = reader.identifier();
        if !is_name {
            // A letter, and digits that are its value or, before =, its number.
            name.truncate(1 + text[at + 1..].iter().take_while(|byte| byte.is_ascii_digit()).count());
            reader.at = at + name.len();
        }
        let name_end = reader.at;
        let is_variable = is_r_parameter(&name) || name == "R" || variables.is_declared(&name);
        if is_variable {
            name = reader.element(name).map_err(fail)?;
        } else if reader.peek() == Some(b'[') {
            reader.at += line.code[reader.at..].find(']').map_or(0, |length| length + 1);
        }
        let (mut values, mut is_end) = (Vec::new(), false);
        let is_assignment = reader.peek() == Some(b'=') && !line.code[reader.at..].starts_with("==");
        if is_assignment {
            reader.takes("=");
            if !is_variable {
                values.extend(assigned_value(line, &mut reader).map_err(fail)?);
            }
        } else if is_name && reader.peek() == Some(b'(') && has_numbers(&name) {
            values = arguments(line, &mut reader).map_err(fail)?.into_iter().flatten().collect();
        } else if is_name {
            is_end = name == "RET";
        } else {
            let value;
            (value, is_end) = letter_value(line, &mut reader, &name, begin..name_end, is_main).map_err(fail)?;
            values.extend(value);
        }
        let variable_value = match is_assignment && is_variable {
            true => Some(
                reader.expression().and_then(|value| value.ok_or(Fault::Macro(MacroFault::NoValue))).map_err(fail)?,
            ),
            false => None,
        };
        at = reader.at.max(begin + 1);
        let mut words = line.code[name_end..at].split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
        if words.any(|word| assigned.iter().any(|name| name == word)) {
            let expected = "a block of its own for a value that the same block assigns";
            return Err(fail(Fault::Macro(MacroFault::Expression { expected })));
        }
        if let Some(value) = variable_value {
            at += text[at..].iter().take_while(|byte| **byte == b' ').count();
            variables.set(&name, Some(value)).map_err(fail)?;
            assigned.push(name);
        }
        ends |= is_end;
        if variable_value.is_some() || (is_end && !is_main) {
            out.extend_from_slice(&line.bytes[from..begin]);
            from = at;
            code_bytes = code_bytes.saturating_sub(line.code[begin..at].len());
        }
        for (value, range) in values.into_iter().filter(|(_, range)| !is_plain(&line.code[range.clone()])) {
            out.extend_from_slice(&line.bytes[from..range.start]);
            out.extend_from_slice(long_number(if is_name { b'X' } else { byte }, value).as_bytes());
            from = range.end;
        }
    }
    out.extend_from_slice(&line.bytes[from..]);
    Ok(Evaluated { bytes: out, has_code: (assigned.is_empty() && (is_main || !ends)) || code_bytes > 0, ends })
}

/// A value, and the bytes of its expression.
type ValueAt = (f64, Range<usize>);

/// Takes the number behind a letter, and digits, with this `name` at these bytes; returns its value if it has an exponent (EX), and whether it ends the
/// program.
fn letter_value(
    line: &SourceLine,
    reader: &mut Reader<'_>,
    name: &str,
    at: Range<usize>,
    is_main: bool,
) -> Result<(Option<ValueAt>, bool), Fault> {
    let is_of_number = |byte: &u8| matches!(byte, b'+' | b'-' | b'.' | b'0'..=b'9');
    let text = line.code.as_bytes();
    reader.at = at.end + text[at.end..].iter().take_while(|byte| is_of_number(byte)).count();
    let number = name[1..].parse::<u32>().unwrap_or(0);
    let is_end = text[at.start] == b'M' && matches!(number, 2 | 17 | 30);
    if is_end && number != 17 && !is_main {
        return Err(Fault::Macro(MacroFault::Expression { expected: "M17 or RET at the end of a subprogram" }));
    }
    if !line.code[reader.at..].starts_with("EX") {
        return Ok((None, is_end));
    }
    reader.at = at.start + 1;
    Ok((Some((reader.number()?, at.start + 1..reader.at)), is_end))
}

/// Returns the index behind the string or bracket that begins at byte `at`.
fn closed_end(line: &SourceLine, at: usize) -> Result<usize, Fault> {
    let mut scan = Scan { line: line.code.as_bytes(), at, is_blank };
    let skipped = if scan.peek() == Some(b'(') { scan.skip_closed(b'(', b')') } else { scan.skip_closed(b'"', b'"') };
    skipped.map(|()| scan.at).map_err(|refusal| refusal.fault)
}

/// Returns `range` without blanks at its end.
fn trimmed(line: &SourceLine, range: Range<usize>) -> Range<usize> {
    range.start..range.start + line.code[range.clone()].trim_end().len()
}

/// Reads the value behind `=`, which may be in IC( ) or the like; `None` for a string.
fn assigned_value(line: &SourceLine, reader: &mut Reader<'_>) -> Result<Option<ValueAt>, Fault> {
    if reader.peek() == Some(b'"') {
        reader.at = closed_end(line, reader.at)?;
        return Ok(None);
    }
    let mut bracket = reader.at;
    let has_mode = ["IC", "AC", "DC", "ACP", "ACN"].iter().any(|mode| {
        let rest = line.code[bracket..].strip_prefix(mode).map(str::trim_start);
        let found = rest.filter(|rest| rest.starts_with('('));
        bracket = found.map_or(bracket, |rest| line.code.len() - rest.len() + 1);
        found.is_some()
    });
    reader.at = bracket;
    let start = reader.at;
    let value = reader.expression()?.ok_or(Fault::Macro(MacroFault::NoValue))?;
    let range = trimmed(line, start..reader.at);
    if has_mode && !reader.takes(")") {
        return Err(Fault::Macro(MacroFault::Expression { expected: ")" }));
    }
    Ok(Some((value, range)))
}

/// Reads arguments in brackets; `None` for those that are left out or strings.
fn arguments(line: &SourceLine, reader: &mut Reader<'_>) -> Result<Vec<Option<ValueAt>>, Fault> {
    let mut values = Vec::new();
    reader.takes("(");
    loop {
        match reader.peek() {
            Some(b',' | b')') => values.push(None),
            Some(b'"') => {
                reader.at = closed_end(line, reader.at)?;
                values.push(None);
            }
            _ => {
                let start = reader.at;
                let value = reader.expression()?.ok_or(Fault::Macro(MacroFault::NoValue))?;
                values.push(Some((value, trimmed(line, start..reader.at))));
            }
        }
        if reader.takes(")") {
            return Ok(values);
        }
        if !reader.takes(",") {
            return Err(Fault::Macro(MacroFault::Expression { expected: ", or )" }));
        }
    }
}

/// Whether what stands in brackets behind `name` is numbers: those of a cycle, not a message.
fn has_numbers(name: &str) -> bool {
    ["CYCLE", "HOLES", "POCKET", "SLOT", "LONGHOLE"].iter().any(|cycle| name.starts_with(cycle))
}

/// Whether `text` is a plain number.
fn is_plain(text: &str) -> bool {
    let digits = text.trim().trim_start_matches(['+', '-']);
    text.trim().len() <= digits.len() + 1 && digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.')
}
