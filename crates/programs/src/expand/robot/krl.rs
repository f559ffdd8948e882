//! Statements of KRL that are run: declarations, what sets velocity, bases and tools, and motions.
//!
//! Types, operators and functions are those of KUKA, *Expert Programming* (KSS 5.2): declarations and standard functions. Data of a `.dat` keep
//! what the last run has left in them: what the program assigns is not known before.

use std::ops::Range;

use crate::{
    expand::robot::{
        expression::{Argument, KRL_PARTS, Reader, krl_part_type},
        functions,
        routine::Parameter,
        run::{Run, Slot, number_text, whole_expression},
        syntax::{KRL_TYPES, is_motion, names_in},
        value::Value,
    },
    model::robot::{Language, RobotFault},
    read::{
        robot::{
            krl::{brace_span, is_of_inline_forms},
            rapid::CodeUnit,
            trimmed,
        },
        scan::Scan,
    },
};

/// Functions of numbers.
const FUNCTIONS: [&str; 7] = ["SIN", "COS", "TAN", "ACOS", "ATAN2", "SQRT", "ABS"];

/// Types that are not followed: records of the controller and of programs.
pub(crate) const OTHER_TYPE: &str = "another type";

/// Most elements of arrays in a frame.
const MAX_ELEMENTS: usize = 2_000;

/// Most tools and bases.
const MAX_FRAMES: usize = 1000;

impl Run<'_> {
    /// Adds what the declaration `unit` declares, or the value that a line of a `.dat` gives an element.
    pub fn declare_krl(&mut self, unit: &CodeUnit, of_module: bool) {
        let text = &self.source[unit.at.clone()];
        let mut scan = Scan::new(text);
        let [mut is_declared, mut is_global, mut is_constant] = [false; 3];
        let mut kind = scan.name().0.to_ascii_uppercase();
        while let Some(is_here) = match kind.as_str() {
            "DECL" => Some(&mut is_declared),
            "GLOBAL" => Some(&mut is_global),
            "CONST" => Some(&mut is_constant),
            _ => None,
        } {
            *is_here = true;
            kind = scan.name().0.to_ascii_uppercase();
        }
        let kind = match KRL_TYPES.iter().find(|known| **known == kind) {
            Some(kind) => kind,
            None if is_declared || is_constant => OTHER_TYPE,
            None if of_module => return self.give_element(unit),
            None => return,
        };
        // Of the data of all programs only tools and bases are read.
        let mut ahead = scan;
        if of_module && self.is_of_all(unit) && !is_frame_data(&ahead.name().0.to_ascii_uppercase()) {
            return;
        }
        loop {
            let name = scan.name().0.to_ascii_uppercase();
            if name.is_empty() {
                return;
            }
            let mut sizes = Vec::new();
            if scan.takes(b'[') {
                while let Ok((size, _)) = scan.number() {
                    sizes.push(size as usize);
                    scan.takes(b',');
                }
                scan.takes(b']');
            }
            let has_value = scan.takes(b'=');
            let count = sizes.iter().fold(1usize, |count, size| count.saturating_mul(*size));
            self.frame().elements = self.frame().elements.saturating_add(count);
            let is_small = self.frame().elements <= MAX_ELEMENTS;
            let mut value = if is_small { blank(kind, &sizes) } else { None };
            if has_value {
                let mut reader = Reader::new(&text[scan.at..], self);
                let read = reader.expression();
                scan.at += reader.scan.at;
                value = read.and_then(|value| value.taken_as(kind)).ok().filter(|_| kind != OTHER_TYPE);
            }
            // Another program may change what all programs know.
            let is_setting = is_global && !is_constant && ["INT", "REAL", "BOOL", "CHAR"].contains(&kind);
            let kind = if is_setting { "" } else { kind };
            if of_module && !is_constant && (is_setting || self.assigned.contains(&name)) {
                value = None;
            }
            let written = (has_value && value.is_some()).then(|| unit.at.clone());
            let mut slot = Slot { value, written, kind, ..Slot::default() };
            if of_module {
                self.forget_parts(&name, &mut slot);
            }
            let frame = self.frame();
            match frame.slots.get_mut(&name).filter(|_| frame.is_called) {
                // A parameter keeps what it was given.
                Some(given) if given.refers_to.is_none() => {
                    let value = given.value.take().and_then(|value| value.taken_as(kind).ok());
                    (given.value, given.kind) = (value, kind);
                }
                Some(_) => {}
                None => drop(frame.slots.insert(name, slot)),
            }
            if !scan.takes(b',') {
                return;
            }
        }
    }

    /// Whether `unit` is from the data of all programs, not from those of this one.
    fn is_of_all(&self, unit: &CodeUnit) -> bool {
        unit.at.start < self.module.own_data
    }

    /// Makes the parts of a datum unknown that the program assigns by themselves.
    fn forget_parts(&self, name: &str, slot: &mut Slot) {
        for (at, part) in KRL_PARTS.iter().enumerate() {
            if self.assigned.contains(&format!("{name}.{part}")) {
                slot.written = None;
                if let Some(Ok(part)) = slot.value.as_mut().map(|value| value.part(at)) {
                    *part = Value::Number(f64::NAN);
                }
            }
        }
    }

    /// Gives an element its value in a line of a `.dat`: `XP[2]={X 1, …}`.
    fn give_element(&mut self, unit: &CodeUnit) {
        let text = &self.source[unit.at.clone()];
        let mut reader = Reader::new(text, self);
        let name = reader.scan.name().0.to_ascii_uppercase();
        let (path, is_given) = (reader.path(), reader.scan.takes(b'='));
        let value = reader.expression();
        let is_frame_data = is_frame_data(&name);
        let is_known = is_frame_data || !self.is_of_all(unit) && self.frames[0].slots.contains_key(&name);
        let (Ok(path), true, Ok(value)) = (path, is_given && is_known, value) else { return };
        let is_assigned = self.assigned.iter().any(|known| known.split('.').next() == Some(name.as_str()));
        let slot = self.frames[0].slots.entry(name).or_default();
        let Ok(value) = value.taken_as(slot.kind) else { return };
        if is_assigned {
            slot.value = None;
            return;
        }
        let mut place = slot.value.get_or_insert(Value::List(Vec::new()));
        for at in path {
            match place {
                // Tools and bases need no declaration here.
                Value::List(parts) if is_frame_data && (parts.len()..MAX_FRAMES).contains(&at) => {
                    parts.resize(at + 1, Value::Unknown);
                }
                _ => {}
            }
            let Ok(part) = place.part(at) else { return };
            place = part;
        }
        *place = value;
        slot.written = Some(unit.at.clone());
    }

    /// Returns the type of what stands at `path` of the datum `name`, a part of a record if `is_part`; empty if any.
    pub fn kind_of(&self, name: &str, path: &[usize], is_part: bool) -> &'static str {
        let (depth, name) = self.place(name);
        match path.last() {
            _ if !self.is_krl() => "",
            Some(at) if is_part => krl_part_type(*at),
            _ => self.frames[depth].slots.get(&name).map_or("", |slot| slot.kind),
        }
    }

    /// Returns what the parameter of a routine is, called with `argument`.
    pub fn krl_argument(&self, parameter: &Parameter, argument: &Argument) -> Result<Slot, RobotFault> {
        let name = argument.text.trim_end_matches("[]").trim_end().to_ascii_uppercase();
        let is_name = names_in(name.as_bytes(), Language::Krl).first() == Some(&(0..name.len()));
        if parameter.is_reference && is_name && !matches!(name.as_str(), "TRUE" | "FALSE") {
            return Ok(Slot { refers_to: Some(self.place(&name)), ..Slot::default() });
        }
        let value = Some(argument.value.clone()?);
        Ok(Slot { value, is_fixed: parameter.is_reference, ..Slot::default() })
    }

    /// Whether `statement` calls, behind its first word, what may change its arguments.
    pub fn may_call_by_reference(&self, statement: &[u8]) -> bool {
        const WORDS: [&str; 12] =
            ["AND", "OR", "EXOR", "NOT", "B_AND", "B_OR", "B_EXOR", "B_NOT", "FOR", "TO", "STEP", "SEC"];
        names_in(statement, Language::Krl).into_iter().skip(1).any(|at| {
            let name = String::from_utf8_lossy(&statement[at.clone()]).to_ascii_uppercase();
            let is_call = Scan::new(&statement[at.end..]).next() == Some(b'(');
            let routine = self.module.routines.get(&name);
            let is_harmless = routine.map_or_else(
                || WORDS.contains(&name.as_str()) || FUNCTIONS.contains(&name.as_str()) || is_of_inline_forms(&name),
                |routine| routine.parameters.iter().all(|parameter| !parameter.is_reference),
            );
            is_call && !is_harmless
        })
    }

    /// Returns the text of a statement that sets data of the system, or calls BAS, with numbers for what is computed; `None` for another one.
    pub fn krl_setting(&mut self, unit: &CodeUnit) -> Result<Option<Vec<u8>>, RobotFault> {
        let source = self.source;
        let text = &source[unit.at.clone()];
        let (from, to) = match unit.word.as_str() {
            "BAS" => (b',', text.iter().rposition(|byte| *byte == b')')),
            word if word.starts_with('$') => (b'=', Some(text.len())),
            _ => return Ok(None),
        };
        let from = text.iter().position(|byte| *byte == from).map(|at| at + 1);
        let (Some(from), Some(to)) = (from, to) else { return self.substituted(unit.at.clone()).map(Some) };
        let at = trimmed(source, unit.at.start + from..unit.at.start + to.max(from));
        let is_plain = Scan::new(&source[at.clone()]).number().is_ok_and(|(_, number)| number.len() == at.len());
        let is_whole = !text[..from].contains(&b'.');
        let written = match unit.word.as_str() {
            "$BASE" | "$TOOL" if is_whole => self.frame_text(at.clone())?,
            "BAS" | "$VEL" if !is_plain => {
                let value = whole_expression(&source[at.clone()], self).and_then(|value| value.number());
                value.ok().map(number_text)
            }
            _ => None,
        };
        let mut out = self.substituted(unit.at.start..at.start)?;
        match written {
            Some(written) => out.extend(written.bytes()),
            None => out.extend(self.substituted(at.clone())?),
        }
        out.extend(self.substituted(at.end..unit.at.end)?);
        Ok(Some(out))
    }

    /// Returns the text of a frame that is computed; `None` if it can stay.
    fn frame_text(&mut self, at: Range<usize>) -> Result<Option<String>, RobotFault> {
        let text = &self.source[at.clone()];
        let first = names_in(text, Language::Krl).into_iter().next();
        let is_call = first.is_some_and(|first| Scan::new(&text[first.end..]).next() == Some(b'('));
        if is_call {
            return Ok(None);
        }
        match self.named_text(at)? {
            Some(named) => Ok(named),
            None => {
                let frame = whole_expression(text, self)?;
                frame.pose()?;
                Ok(value_text(&frame))
            }
        }
    }

    /// Returns how a point or frame whose numbers the program gives is written: `None` if it is computed, else its text if that changes.
    fn named_text(&mut self, at: Range<usize>) -> Result<Option<Option<String>>, RobotFault> {
        let text = &self.source[at];
        if text.starts_with(b"{") {
            let is_all = brace_span(&mut Scan::new(text), text)? == (0..text.len());
            return Ok(is_all.then_some(None));
        }
        let mut over = Reader::without_values(text, Language::Krl);
        let name = over.scan.name().0;
        over.path()?;
        if name.is_empty() || !over.scan.is_done() {
            return Ok(None);
        }
        let place = self.place(&name.to_ascii_uppercase());
        let slot = self.frames[place.0].slots.get(&place.1);
        let is_given = slot.is_none_or(|slot| slot.written.is_some());
        if !is_given || self.is_own(&place) || self.is_hidden(&place.1) {
            return Ok(None);
        }
        let mut reader = Reader::new(text, self);
        reader.scan.name();
        let path: Vec<String> = reader.path()?.iter().map(|at| (at + 1).to_string()).collect();
        let is_same = path.is_empty() || text.ends_with(format!("[{}]", path.join(",")).as_bytes());
        let name = if place.1.eq_ignore_ascii_case(name) { name.to_owned() } else { place.1 };
        let is_same = is_same && text.starts_with(name.as_bytes());
        Ok(Some((!is_same).then(|| match path.is_empty() {
            true => name,
            false => format!("{name}[{}]", path.join(",")),
        })))
    }

    /// Returns the text of a motion as it is written: with numbers in place of points that are computed.
    pub fn krl_motion_text(&mut self, unit: &CodeUnit) -> Result<Vec<u8>, RobotFault> {
        let source = self.source;
        let end = unit.inside(source).end;
        let count = match unit.word.as_str() {
            "SPLINE" | "PTP_SPLINE" => 0,
            word if word.contains("CIRC") => 2,
            _ => 1,
        };
        let (mut out, mut copied) = (Vec::new(), unit.at.start);
        let mut from = unit.inside(source).start;
        for point in 0..count {
            let at = self.expression_range(from..end)?;
            out.extend(self.substituted(copied..at.start)?);
            let written = match self.named_text(at.clone())? {
                Some(named) => named,
                None => {
                    let value = whole_expression(&source[at.clone()], self)?;
                    let text = value_text(&value).filter(|text| text.starts_with('{'));
                    Some(text.ok_or(RobotFault::Form { expected: "a point all of whose numbers are known" })?)
                }
            };
            match written {
                Some(written) => out.extend(written.bytes()),
                None => out.extend_from_slice(&source[at.clone()]),
            }
            copied = at.end;
            let mut scan = Scan::new(&source[at.end..end]);
            if point + 1 < count {
                scan.expect(b',', ", and the end of the circle")?;
            }
            from = at.end + scan.at;
        }
        let mut scan = Scan::new(&source[from..end]);
        if count == 2 && scan.takes(b',') && scan.name().0.eq_ignore_ascii_case("CA") {
            scan.takes(b'=');
            let at = self.expression_range(from + scan.at..end)?;
            out.extend(self.substituted(copied..at.start)?);
            let text = &source[at.clone()];
            match Scan::new(text).number() {
                Ok((_, number)) if number.len() == text.len() => out.extend_from_slice(text),
                _ => out.extend(number_text(whole_expression(text, self)?.number()?).bytes()),
            }
            copied = at.end;
        }
        out.extend(self.substituted(copied..unit.at.end)?);
        Ok(out)
    }

    /// Returns the range of the expression with which `within` begins.
    fn expression_range(&self, within: Range<usize>) -> Result<Range<usize>, RobotFault> {
        let mut over = Reader::without_values(&self.source[within.clone()], Language::Krl);
        over.expression()?;
        Ok(trimmed(self.source, within.start..within.start + over.scan.at))
    }
}

/// Whether `name` is that of the tools or bases of all programs.
fn is_frame_data(name: &str) -> bool {
    matches!(name, "TOOL_DATA" | "BASE_DATA")
}

/// Returns the value of a datum of the type `kind` before one is assigned; `None` if it has no parts.
fn blank(kind: &str, sizes: &[usize]) -> Option<Value> {
    let is_record = matches!(kind, "FRAME" | "POS" | "E6POS" | "AXIS" | "E6AXIS");
    let element = if is_record { Value::record() } else { Value::Unknown };
    let value = sizes.iter().rev().fold(element, |element, size| Value::List(vec![element; *size]));
    (value != Value::Unknown).then_some(value)
}

/// Returns the names (in capitals) of data that a statement with `word` assigns, parts as `P.X`, of all its `names`.
pub(crate) fn assigned_in(statement: &[u8], word: &str, names: Vec<String>) -> Vec<String> {
    const HARMLESS: &str = "; WAIT HALT CONTINUE PULSE BAS CONFIRM EXIT RETURN GOTO ENDSPLINE";
    if is_motion(word, Language::Krl) || HARMLESS.split_whitespace().any(|known| known == word) {
        return Vec::new();
    }
    let mut scan = Scan::new(&statement[word.len().min(statement.len())..]);
    match scan.next() {
        Some(b'=' | b'[') => vec![word.to_owned()],
        Some(b'.') => {
            scan.at += 1;
            vec![format!("{word}.{}", scan.name().0.to_ascii_uppercase())]
        }
        _ => names,
    }
}

/// Returns the value of a function of KRL; `Err` for one that is not followed.
pub(crate) fn function(name: &str, arguments: &[Argument]) -> Result<Value, RobotFault> {
    match (name, arguments) {
        ("ABS", [Argument { value: Ok(Value::Integer(number)), .. }]) => Value::integer(f64::from(*number).abs()),
        _ if FUNCTIONS.contains(&name) => functions::function(name, arguments),
        _ => Err(RobotFault::NoValue { name: name.to_owned() }),
    }
}

/// Returns the frame that stands at its parent.
pub(crate) fn null_frame() -> Value {
    let mut frame = Value::record();
    if let Value::List(parts) = &mut frame {
        parts[..6].fill(Value::Number(0.0));
    }
    frame
}

/// Returns a value as it is written in a statement: a REAL with its point, so that it is none of INT; `None` for an unknown value, an infinite number
/// and an array.
pub(crate) fn value_text(value: &Value) -> Option<String> {
    let plain = |value: &Value| match value {
        Value::Integer(number) => Some(number.to_string()),
        value => value.number().ok().map(number_text),
    };
    match value {
        Value::Number(_) => plain(value).map(|text| if text.contains('.') { text } else { text + ".0" }),
        Value::Integer(_) => plain(value),
        Value::Truth(truth) => Some(if *truth { "TRUE" } else { "FALSE" }.to_owned()),
        Value::Text(text) => Some(text.clone()),
        Value::List(parts) if parts.len() == KRL_PARTS.len() => {
            let known = KRL_PARTS.iter().zip(parts).filter(|(_, part)| **part != Value::Unknown);
            let known: Option<Vec<String>> =
                known.map(|(name, part)| Some(format!("{name} {}", plain(part)?))).collect();
            known.filter(|known| !known.is_empty()).map(|known| format!("{{{}}}", known.join(",")))
        }
        _ => None,
    }
}
