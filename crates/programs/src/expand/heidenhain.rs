//! Heidenhain's programs block by block: Q parameters and FN functions, labels, repetitions, jumps and calls of programs.
//!
//! They run as Heidenhain, *iTNC 530 User's Manual Conversational Programming*, says (subprograms and program section repeats, Q parameters).

use std::collections::BTreeMap;

use crate::{
    expand::{
        calls::CallTarget,
        contour::signed,
        expression::Reader,
        line::SourceLine,
        run::{Next, Run, Section, Step},
        sinumerik::expect_end,
        variables::Variables,
    },
    model::{
        format_plain,
        gcode::{Fault, Foreign, MacroFault},
    },
    read::gcode::Origin,
};

/// Words with which a motion begins.
pub(crate) const MOTIONS: [&str; 7] = ["L", "C", "CR", "CT", "LP", "CP", "CTP"];

impl SourceLine {
    /// Whether the line is END PGM.
    fn ends_program(&self) -> bool {
        self.keyword() == "END" && self.rest()["END".len()..].trim_start().starts_with("PGM")
    }
}

impl Run<'_> {
    /// Runs a block of Heidenhain's, and returns which comes next.
    pub(crate) fn follow_heidenhain(&mut self, line: &SourceLine) -> Step {
        let at = |fault| (line.begin, fault);
        let before = self.here.line.checked_sub(1).map(|before| &self.source().lines[before].bytes);
        let is_continued = before.is_some_and(|before| before.trim_ascii_end().ends_with(b"~"));
        let rest = line.rest();
        if is_continued || (self.defines_cycle && line.n_number.is_none() && rest.starts_with('Q')) {
            let bytes = if self.defines_cycle { self.cycle_parameter(line).map_err(at)? } else { line.bytes.clone() };
            self.write_line(bytes);
            return Ok(Next::Line);
        }
        self.defines_cycle = rest.starts_with("CYCL DEF 2");
        if self.defines_cycle {
            self.cycle_parameters.clear();
        }
        let calls_cycle = rest.starts_with("CYCL CALL") || line.has_word(b'M', &[99.0]);
        if calls_cycle && !rest.starts_with('*') && self.cycle_parameters.values().any(|is_changed| *is_changed) {
            let expected = "CYCL DEF once more where its Q parameters have changed";
            return Err(at(Fault::Foreign(Foreign::CycleValue { expected })));
        }
        let is_main = self.calls.iter().all(|call| call.is_section());
        match line.keyword() {
            "LBL" => match self.calls.last() {
                Some(call) if call.is_section() && line.label.as_deref() == Some("0") => self.end_call().map_err(at),
                _ => Ok(Next::Line),
            },
            "CALL" => self.call_heidenhain(line).map_err(at),
            "FN" => self.follow_function(line).map_err(at),
            "Q" | "QL" | "QR" => self.assign(line, line.begin).map_err(at),
            "BEGIN" if !self.calls.is_empty() => match rest.ends_with("INCH") == self.is_in_inches() {
                true => Ok(Next::Line),
                false => {
                    Err(at(Fault::Macro(MacroFault::Expression { expected: "the unit of the program that calls" })))
                }
            },
            _ if line.ends_program() && !self.calls.is_empty() => {
                if self.calls.last().is_some_and(|call| call.is_section()) {
                    return Err(at(Fault::Macro(MacroFault::NoReturn)));
                }
                self.end_call().map_err(at)
            }
            keyword => {
                self.decimals = self.decimals.max(line.decimals());
                let bytes = evaluate(line, &mut self.variables, &mut self.cycle_parameters).map_err(at)?;
                self.write_line(bytes);
                let may_end = MOTIONS.contains(&keyword) || matches!(keyword, "M" | "STOP");
                let ends = may_end && line.has_word(b'M', &[2.0, 30.0]);
                match ends || line.ends_program() {
                    true if is_main => {
                        let end = self.sources[0].lines.iter().rposition(SourceLine::ends_program);
                        if let (Some(end), true) = (end, ends) {
                            self.here = Origin { file: 0, line: end };
                            self.write_line(self.sources[0].lines[end].bytes.clone());
                        }
                        Ok(Next::End)
                    }
                    true => Err(at(Fault::Macro(MacroFault::Expression {
                        expected: "no M2 or M30 in a program that is called",
                    }))),
                    false => Ok(Next::Line),
                }
            }
        }
    }

    /// Whether the main program is in inches.
    fn is_in_inches(&self) -> bool {
        self.sources[0].lines.iter().any(|line| line.keyword() == "BEGIN" && line.rest().ends_with("INCH"))
    }

    /// Sets the parameter of a cycle, `Q200=+2`, and returns its line with the value.
    fn cycle_parameter(&mut self, line: &SourceLine) -> Result<Vec<u8>, Fault> {
        let Some(equals) = line.code[line.begin..].find('=').map(|at| line.begin + at) else {
            return Ok(line.bytes.clone());
        };
        let mut reader = Reader::new(&line.code, line.begin, &self.variables);
        let name = reader.q_name()?;
        reader.at = equals + 1;
        let value = read_cycle_value(&mut reader)?;
        let text = &line.code[equals + 1..reader.at];
        self.variables.set(&name, value)?;
        self.cycle_parameters.insert(name, false);
        let Some(value) = value.filter(|_| text.contains('Q')) else { return Ok(line.bytes.clone()) };
        Ok([&line.bytes[..=equals], signed(value).as_bytes(), &line.bytes[equals + 1 + text.trim_end().len()..]]
            .concat())
    }

    /// Runs an assignment that begins at byte `at`: `Q1 = Q2 * SIN Q3`.
    fn assign(&mut self, line: &SourceLine, at: usize) -> Result<Next, Fault> {
        let mut reader = Reader::new(&line.code, at, &self.variables);
        let name = reader.q_name()?;
        if !reader.takes("=") {
            return Err(Fault::Macro(MacroFault::Expression { expected: "= behind a Q parameter" }));
        }
        let value = reader.expression()?.ok_or(Fault::Macro(MacroFault::NoValue))?;
        expect_end(&mut reader)?;
        self.variables.set(&name, Some(value))?;
        if let Some(is_changed) = self.cycle_parameters.get_mut(&name) {
            *is_changed = true;
        }
        Ok(Next::Line)
    }

    /// Runs FN 0 to FN 8 and FN 13, which assign, or FN 9 to FN 12, which jump.
    fn follow_function(&mut self, line: &SourceLine) -> Result<Next, Fault> {
        let mut reader = Reader::new(&line.code, line.begin, &self.variables);
        reader.takes("FN");
        let number: u32 = reader.identifier().parse().unwrap_or(u32::MAX);
        reader.takes(":");
        match number {
            0..=8 | 13 => {
                let at = reader.at;
                self.assign(line, at)
            }
            9..=12 if reader.takes("IF") => {
                let is_true = reader.expression()?.ok_or(Fault::Macro(MacroFault::NoValue))? != 0.0;
                if !reader.takes("GOTO") || !reader.takes("LBL") {
                    return Err(Fault::Macro(MacroFault::Expression { expected: "GOTO LBL" }));
                }
                let name = label_name(&line.code[reader.at..]);
                let target = self.label_line(&name)?;
                Ok(if is_true { self.jump_to(target) } else { Next::Line })
            }
            18 => Err(Fault::Macro(MacroFault::MachineState)),
            _ => Err(Fault::Foreign(Foreign::Parameter)),
        }
    }

    /// Index of the line with the label `name`.
    fn label_line(&self, name: &str) -> Result<usize, Fault> {
        let mut lines = self.source().lines.iter();
        lines.position(|line| line.label.as_deref() == Some(name)).ok_or(Fault::Macro(MacroFault::NoLabel))
    }

    /// Runs CALL LBL, with REP a repetition of the section from the label to here, or CALL PGM.
    fn call_heidenhain(&mut self, line: &SourceLine) -> Result<Next, Fault> {
        let what = line.rest()["CALL".len()..].trim();
        if let Some(name) = what.strip_prefix("PGM") {
            // As it is written: names of files may have small letters.
            let start = line.code.find(what).map_or(0, |at| at + what.len() - name.len());
            let name = String::from_utf8_lossy(&line.bytes[start..start + name.len()]).into_owned();
            let name = name.rsplit(['\\', '/', ':']).next().unwrap_or_default().trim().trim_matches('"').to_owned();
            let begin = self.find_subprogram(&name, CallTarget::File)?;
            return self.call(begin, 1, Some(Vec::new()));
        }
        let Some(label) = what.strip_prefix("LBL") else { return Err(Fault::Foreign(Foreign::Call)) };
        let (label, times) =
            label.split_once("REP").map_or((label, None), |(label, times)| (label, Some(times.trim())));
        let begin = self.label_line(&label_name(label))?;
        let Some(times) = times else {
            return self.call(Origin { line: begin + 1, ..self.here }, 1, None);
        };
        let times = times.split('/').next().map(str::trim).and_then(|times| times.parse().ok());
        let runs_left = times.ok_or(Fault::Macro(MacroFault::Expression { expected: "REP and a whole number" }))?;
        let here = self.here.line;
        if begin >= here {
            return Err(Fault::Macro(MacroFault::NoLabel));
        }
        if runs_left == 0 {
            return Ok(Next::Line);
        }
        self.sections.push(Section { begin, stop: here, return_to: here + 1, runs_left, depth: self.calls.len() });
        Ok(Next::At(begin))
    }
}

/// Returns the name of a label as written behind LBL: a number, or text in quotes.
pub(crate) fn label_name(text: &str) -> String {
    let text = text.trim().trim_matches('"');
    text.parse::<u32>().map_or(text.to_owned(), |number| number.to_string())
}

/// Takes the value of a parameter of a cycle; `None` for MAX, AUTO and the like, which are no numbers.
fn read_cycle_value(reader: &mut Reader<'_>) -> Result<Option<f64>, Fault> {
    let is_word = reader.peek().is_some_and(|byte| byte.is_ascii_alphabetic() && byte != b'Q');
    if is_word { Ok(None) } else { reader.number().map(Some) }
}

/// Returns a block with values for its Q parameters.
fn evaluate(
    line: &SourceLine,
    variables: &mut Variables,
    cycle_parameters: &mut BTreeMap<String, bool>,
) -> Result<Vec<u8>, Fault> {
    let text = line.code.as_bytes();
    let (mut out, mut from, mut at, mut is_quoted) = (Vec::new(), 0, line.begin, false);
    while at < text.len() {
        is_quoted ^= text[at] == b'"';
        let digits = at + 1 + usize::from(matches!(text.get(at + 1), Some(b'L' | b'R')));
        if is_quoted || text[at] != b'Q' || !text.get(digits).is_some_and(u8::is_ascii_digit) {
            at += 1;
            continue;
        }
        let before = line.code[..at].trim_end();
        let sign = before.ends_with(['+', '-']);
        let address = before.trim_end_matches(['+', '-']).trim_end();
        // The control finds them.
        let number = text[digits..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let is_found_angle = matches!(&text[at + 1..digits + number], b"120" | b"121" | b"122");
        if is_found_angle && address.ends_with(['A', 'B', 'C']) && !before.ends_with('-') {
            if variables.is_set(&line.code[at..digits + number]) {
                return Err(Fault::Macro(MacroFault::Expression { expected: "Q120 to Q122 as PLANE finds them" }));
            }
            at = digits + number;
            continue;
        }
        let mut reader = Reader::new(&line.code, if sign { before.len() - 1 } else { at }, variables);
        if line.rest().starts_with("CYCL DEF") && line.code[digits + number..].trim_start().starts_with('=') {
            // A parameter of the cycle, on the line of its CYCL DEF.
            let name = reader.q_name()?;
            reader.takes("=");
            at = reader.at;
            let value = read_cycle_value(&mut reader)?;
            variables.set(&name, value)?;
            cycle_parameters.insert(name, false);
            continue;
        }
        let start = reader.at;
        let value = reader.number()?;
        let is_coordinate = address.ends_with(['X', 'Y', 'Z', 'A', 'B', 'C']) || address.ends_with("PR");
        out.extend_from_slice(&line.bytes[from..start]);
        let plain = || format_plain((value * 1e7).round() / 1e7 + 0.0);
        out.extend(if sign || is_coordinate { signed(value) } else { plain() }.bytes());
        (from, at) = (reader.at, reader.at);
    }
    out.extend_from_slice(&line.bytes[from..]);
    Ok(out)
}
