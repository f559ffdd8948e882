//! Statements that are run: declarations of RAPID, assignments, motions of RAPID, and statements that are copied.

use std::{collections::BTreeSet, ops::Range};

use crate::{
    expand::robot::{
        expression::{Names, Reader},
        krl,
        routine::one_line_if,
        run::{COUNTER, Run, Slot, number_text, refuse, value_text, whole_expression},
        syntax::{Units, is_declaration, names_in, names_of},
        value::Value,
    },
    model::robot::RobotFault,
    read::{
        robot::{
            LocatedFault,
            rapid::{CodeUnit, is_ignored, option_start, parse_target, split_arguments},
            trimmed,
        },
        scan::Scan,
    },
};

impl Run<'_> {
    /// Adds what the declaration `unit` declares. Of data `of_module`, what is no constant and assigned somewhere is not known before it is.
    pub fn declare(&mut self, unit: &CodeUnit, of_module: bool) {
        let source = self.source;
        if self.is_krl() {
            return self.declare_krl(unit, of_module);
        }
        let mut scan = Scan::new(&source[unit.at.clone()]);
        let mut word = scan.name().0.to_ascii_uppercase();
        while matches!(word.as_str(), "LOCAL" | "TASK") {
            word = scan.name().0.to_ascii_uppercase();
        }
        if !matches!(word.as_str(), "CONST" | "PERS" | "VAR") {
            return;
        }
        let kind = scan.name().0.to_ascii_uppercase();
        let name = scan.name().0.to_ascii_uppercase();
        if scan.takes(b'{') {
            scan.take_while(|byte| byte != b'}');
            scan.takes(b'}');
        }
        let has_value = scan.takes(b':') && scan.takes(b'=');
        let written = trimmed(source, unit.at.start + scan.at..unit.at.end - 1);
        // A PERS keeps what the last run, or another program, has left in it; targets are those of the file.
        let is_setting = word == "PERS" && matches!(kind.as_str(), "NUM" | "DNUM" | "BOOL" | "STRING");
        let is_known = word == "CONST" || !(is_setting || of_module && self.assigned.contains(&name));
        let mut slot = Slot { written: (has_value && is_known).then_some(written), ..Slot::default() };
        if !has_value && word == "VAR" && is_known {
            slot.value = match kind.as_str() {
                "NUM" | "DNUM" => Some(Value::Number(0.0)),
                "BOOL" => Some(Value::Truth(false)),
                _ => None,
            };
        }
        self.frame().slots.insert(name, slot);
    }

    /// Adds the names (in capitals) of data that the text `at` may change to `found`: those that it assigns, or passes on to what may, and
    /// those of the routines that it names.
    pub fn assigned_names(&self, at: Range<usize>, found: &mut BTreeSet<String>) {
        // A chain of calls may be long.
        let mut open = vec![at];
        while let Some(at) = open.pop() {
            self.assigned_in(&self.source[at], found, &mut open);
        }
    }

    /// Adds the names that the statements `text` may change to `found`, and what of the routines that they name is not looked at yet to `open`.
    fn assigned_in(&self, text: &[u8], found: &mut BTreeSet<String>, open: &mut Vec<Range<usize>>) {
        let mut units = Units::new(text, self.language);
        while let Ok(Some(unit)) = units.next() {
            let unit = match unit.word.as_str() {
                "IF" if unit.is_statement => one_line_if(text, &unit).map_or(unit, |(_, inner)| inner),
                _ => unit,
            };
            let statement = &text[unit.at.clone()];
            let names: Vec<String> = names_of(statement, self.language).collect();
            for routine in names.iter().filter_map(|name| self.module.routines.get(name)) {
                // Once: routines may call themselves.
                if found.insert(format!("{}()", routine.name)) {
                    open.push(routine.inside.clone());
                }
            }
            let passes_on = |name: &String| {
                let routine = self.module.routines.get(name);
                routine.is_none_or(|routine| routine.parameters.iter().any(|parameter| parameter.is_reference))
            };
            let is_place = matches!(
                Scan::new(&statement[unit.word.len().min(statement.len())..]).next(),
                Some(b':' | b'.' | b'{')
            );
            if self.is_krl() && self.may_call_by_reference(statement) {
                found.extend(names.iter().cloned());
            }
            match unit.word.as_str() {
                "FOR" if self.is_krl() => found.extend(names.into_iter().nth(1)),
                _ if !unit.is_statement => {}
                "LOCAL" | "TASK" => {}
                word if is_declaration(word, self.language) => {}
                word if self.is_krl() => {
                    let is_called =
                        self.module.routines.contains_key(word) && names.first().is_some_and(|name| !passes_on(name));
                    found.extend(if is_called { Vec::new() } else { krl::assigned_in(statement, word, names) });
                }
                _ if is_place => found.extend(names.into_iter().take(1)),
                word if is_harmless(word) && !self.module.routines.contains_key(word) => {}
                _ if names.first().is_some_and(passes_on) => found.extend(names),
                _ => {}
            }
        }
    }

    /// Makes the data unknown that the text `at` may change.
    pub fn forget(&mut self, at: Range<usize>) {
        let mut names = BTreeSet::new();
        self.assigned_names(at, &mut names);
        for name in names {
            // What a parameter stands for changes with it.
            let name = name.split('.').next().unwrap_or_default().to_owned();
            let slot = self.frames.last().and_then(|frame| frame.slots.get(&name));
            let stands_for = slot.and_then(|slot| slot.stands_for.as_ref()).map(|text| text.to_ascii_uppercase());
            for slot in self.frames.iter_mut().filter_map(|frame| frame.slots.get_mut(stands_for.as_ref()?)) {
                (slot.value, slot.written) = (None, None);
            }
            self.set_value(&name, None);
        }
    }

    /// Sets the value of a datum that is known here.
    fn set_value(&mut self, name: &str, value: Option<Value>) {
        let (depth, name) = self.place(name);
        // What a program of KRL does not declare, others may change meanwhile.
        let slot = self.frames[depth].slots.get(&name);
        let is_declared = !self.is_krl() || slot.is_some_and(|slot| !slot.kind.is_empty());
        let is_other = slot.is_some_and(|slot| slot.kind == krl::OTHER_TYPE);
        let is_certain = |value: &Value| !is_other && (is_declared || matches!(value, Value::List(_)));
        let value = value.filter(|value| !self.changed_by_traps.contains(&name) && is_certain(value));
        self.effects += usize::from(depth == 0);
        let slot = self.frames[depth].slots.entry(name).or_default();
        (slot.value, slot.written) = (value, None);
    }

    /// Runs an assignment, or copies the statement.
    pub fn assign_or_copy(&mut self, unit: &CodeUnit) -> Result<(), LocatedFault> {
        let source = self.source;
        let is_krl = self.is_krl();
        if is_krl && let Some(text) = self.krl_setting(unit).map_err(|fault| refuse(unit, fault))? {
            if self.is_writing() {
                self.write(unit, text);
            }
            self.effects += 1;
            return Ok(());
        }
        let text = &source[unit.at.start..unit.inside(source).end];
        let mut reader = Reader::new(text, self);
        let name = reader.scan.name().0.to_ascii_uppercase();
        let steps = !is_krl && matches!(name.as_str(), "INCR" | "DECR" | "ADD" | "CLEAR");
        let path = if steps { Ok(Vec::new()) } else { reader.path() };
        let is_part = text[..reader.scan.at].trim_ascii_end().last() != Some(&b']');
        let is_assignment = (is_krl || reader.scan.takes(b':')) && reader.scan.takes(b'=');
        if steps {
            return self.count(unit, &name);
        }
        if !is_assignment {
            self.write_statement(unit)?;
            if is_krl || !is_harmless(&name) {
                self.forget(unit.at.clone());
            }
            return Ok(());
        }
        let value = reader.expression();
        let is_whole = reader.scan.is_done();
        if value.is_err() && is_krl {
            self.forget(unit.at.clone());
        }
        let value = value.and_then(|value| {
            let path = path?;
            let kind = self.kind_of(&name, &path, is_part);
            let value = value.taken_as(kind)?;
            let mut whole = if path.is_empty() { Value::Truth(true) } else { self.value_of(&name)? };
            let mut part = &mut whole;
            for at in path {
                part = part.part(at)?;
            }
            *part = value;
            Ok(whole)
        });
        self.assign(unit, &name, value.ok().filter(|_| is_whole))
    }

    /// Runs Incr, Decr, Add and Clear.
    fn count(&mut self, unit: &CodeUnit, word: &str) -> Result<(), LocatedFault> {
        let source = self.source;
        let text = &source[unit.inside(source)];
        let arguments = Reader::new(text, self).arguments(None).map_err(|fault| refuse(unit, fault))?;
        let Some(first) = arguments.first() else {
            return Err(refuse(unit, RobotFault::Form { expected: "a datum that is counted" }));
        };
        let number = |at: usize| arguments.get(at).and_then(|argument| argument.value.clone().ok()?.number().ok());
        let by = match word {
            "INCR" => Some(1.0),
            "DECR" => Some(-1.0),
            "ADD" => number(1),
            _ => number(0).map(|number| -number),
        };
        let value = number(0).zip(by).map(|(number, by)| Value::Number(number + by));
        let name = first.text.to_ascii_uppercase();
        if names_in(name.as_bytes(), self.language).first() != Some(&(0..name.len())) {
            return Err(refuse(unit, RobotFault::Form { expected: "a datum with a name of its own" }));
        }
        self.assign(unit, &name, value)
    }

    /// Sets the datum `name`, and writes the statement where the datum has a name in what is written.
    fn assign(&mut self, unit: &CodeUnit, name: &str, value: Option<Value>) -> Result<(), LocatedFault> {
        let place = self.place(name);
        let is_own = self.is_own(&place);
        if self.frames[place.0].slots.get(&place.1).is_some_and(|slot| slot.is_fixed) {
            return Err(refuse(unit, COUNTER));
        }
        if !is_own {
            self.write_statement(unit)?;
        }
        self.set_value(name, value);
        if is_own && let Some(slot) = self.frame().slots.get_mut(name) {
            slot.stands_for = None;
        }
        Ok(())
    }

    /// Returns the value of the datum `name`.
    fn value_of(&mut self, name: &str) -> Result<Value, RobotFault> {
        Names::value(self, name)
    }

    /// Writes a statement as it stands, but for data that have no names in what is written.
    pub fn write_statement(&mut self, unit: &CodeUnit) -> Result<(), LocatedFault> {
        self.effects += 1;
        if self.is_writing() {
            let text = self.substituted(unit.at.clone()).map_err(|fault| refuse(unit, fault))?;
            self.write(unit, text);
        }
        Ok(())
    }

    /// Returns the text `at` with values in place of data that have no names in what is written.
    pub fn substituted(&mut self, at: Range<usize>) -> Result<Vec<u8>, RobotFault> {
        let text = &self.source[at];
        let (mut out, mut copied) = (Vec::with_capacity(text.len()), 0);
        for mut range in names_in(text, self.language) {
            let name = String::from_utf8_lossy(&text[range.clone()]).to_ascii_uppercase();
            if self.is_hidden(&name) {
                return RobotFault::not_followed(
                    "data whose names are those of other data in the first routine are",
                    "names that mean one datum",
                );
            }
            let place = self.place(&name);
            let slot = self.frames[place.0].slots.get(&place.1);
            let stands_for = match slot.and_then(|slot| slot.stands_for.clone()) {
                _ if range.start < copied => continue,
                Some(text) => text,
                // With its parts and indices.
                None if self.is_own(&place) => {
                    let mut reader = Reader::new(&text[range.start..], self);
                    let value = reader.datum()?;
                    range.end = range.start + text[range.start..][..reader.scan.at].trim_ascii_end().len();
                    value_text(&value, self.language).ok_or(RobotFault::NoValue { name: name.clone() })?
                }
                None if place.1 != name => place.1,
                None => continue,
            };
            out.extend_from_slice(&text[copied..range.start]);
            // A sign must not follow an operator.
            let is_behind = out.trim_ascii_end().last().is_some_and(|byte| b"+-*/".contains(byte));
            let is_signed = stands_for.starts_with('-') && is_behind;
            out.extend(if is_signed { format!("({stands_for})") } else { stands_for }.bytes());
            copied = range.end;
        }
        out.extend_from_slice(&text[copied..]);
        Ok(out)
    }

    /// Writes a motion, with the numbers of targets that are computed.
    pub fn write_motion(&mut self, unit: &CodeUnit) -> Result<(), LocatedFault> {
        if !self.is_writing() {
            return Err(refuse(unit, RobotFault::Form { expected: "no motion in a function" }));
        }
        let text = self.motion_text(unit).map_err(|fault| refuse(unit, fault))?;
        self.write(unit, text);
        Ok(())
    }

    /// Returns the text of a motion as it is written.
    fn motion_text(&mut self, unit: &CodeUnit) -> Result<Vec<u8>, RobotFault> {
        let source = self.source;
        if self.is_krl() {
            return self.krl_motion_text(unit);
        }
        let targets = match unit.word.as_str() {
            "MOVEL" | "MOVEJ" => 1,
            "MOVEC" => 2,
            _ => 0,
        };
        let inside = unit.at.start + unit.word.len()..unit.at.end - 1;
        let mut arguments = split_arguments(&source[inside.clone()], inside.start);
        if source[arguments[0].clone()].trim_ascii_start().starts_with(b"\\") {
            arguments.remove(0);
        }
        let (mut out, mut copied) = (Vec::new(), unit.at.start);
        for argument in arguments.into_iter().take(targets) {
            let argument = argument.start..argument.start + option_start(&source[argument]);
            let argument = trimmed(source, argument);
            let written = self.target_text(argument.clone())?;
            out.extend(self.substituted(copied..argument.start)?);
            match written {
                Some(written) => out.extend(written.bytes()),
                None => out.extend_from_slice(&source[argument.clone()]),
            }
            copied = argument.end;
        }
        out.extend(self.substituted(copied..unit.at.end)?);
        Ok(out)
    }

    /// Returns the numbers of the target `at` if it is computed; `None` if it can stay.
    fn target_text(&mut self, at: Range<usize>) -> Result<Option<String>, RobotFault> {
        let source = self.source;
        let text = &source[at];
        if parse_target(text).is_ok() {
            return Ok(None);
        }
        let is_name = names_in(text, self.language).first() == Some(&(0..text.len()));
        if is_name {
            let name = String::from_utf8_lossy(text).to_ascii_uppercase();
            let is_of_routine = self.frames.last().is_some_and(|frame| frame.slots.contains_key(&name));
            let of_module = self.frames[0].slots.get(&name);
            // A declared target stays; where its numbers are not plain, they are put in its place.
            let written = of_module.and_then(|slot| slot.written.clone()).filter(|_| !is_of_routine);
            if let Some(written) = written
                && parse_target(&source[written]).is_ok()
            {
                return Ok(None);
            }
        }
        let value = whole_expression(text, self)?;
        target_numbers(&value).map(Some)
    }
}

/// Returns a target as its numbers are written.
fn target_numbers(value: &Value) -> Result<String, RobotFault> {
    const EXPECTED: RobotFault = RobotFault::Form { expected: "a target: [[x,y,z],[q1,q2,q3,q4],[…],[…]]" };
    let Value::List(parts) = value else { return Err(EXPECTED) };
    let [position, rotation, configuration, external] = &parts[..] else { return Err(EXPECTED) };
    let (position, rotation) = (position.numbers::<3>()?, rotation.numbers::<4>()?);
    let (configuration, external) = (configuration.numbers::<4>()?, external.numbers::<6>()?);
    let list = |numbers: &[f64]| {
        // An axis that is not in use has the number 9E9.
        let text = |number: &f64| if *number >= 9e8 { "9E+09".to_owned() } else { number_text(*number) };
        format!("[{}]", numbers.iter().map(text).collect::<Vec<_>>().join(","))
    };
    Ok(format!("[{},{},{},{}]", list(&position), list(&rotation), list(&configuration), list(&external)))
}

/// Whether a statement with `word` changes no data.
fn is_harmless(word: &str) -> bool {
    is_ignored(word)
        && !matches!(
            word,
            "INCR"
                | "DECR"
                | "ADD"
                | "CLEAR"
                | "TPREADFK"
                | "TPREADNUM"
                | "WAITDI"
                | "WAITDO"
                | "WAITUNTIL"
                | "WAITAI"
                | "WAITGI"
                | "OPEN"
        )
        || word.starts_with("MOVE")
}
