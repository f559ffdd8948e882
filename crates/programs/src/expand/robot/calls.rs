//! Calls of procedures and functions, and what names stand for in expressions.

use std::rc::Rc;

use crate::{
    expand::robot::{
        expression::{Argument, Names, Reader},
        functions::function,
        krl,
        routine::Routine,
        run::{Flow, Frame, Run, Signal, Slot, missing_label, refuse, value_text, whole_expression},
        syntax::names_in,
        value::Value,
    },
    model::robot::{Language, RobotFault},
    read::robot::rapid::CodeUnit,
};

/// Most calls in one another.
const DEEPEST: usize = 16;

impl Run<'_> {
    /// Calls a procedure: one that moves the tool, or any of KRL, is run where it is called, another is called as before.
    pub fn call_procedure(&mut self, unit: &CodeUnit, routine: &Rc<Routine>) -> Flow {
        let source = self.source;
        let (text, is_krl) = (&source[unit.inside(source)], self.is_krl());
        let mut reader = Reader::new(text, self);
        let mut arguments = || match is_krl {
            false => reader.arguments(None),
            true => {
                reader.scan.expect(b'(', "( and the arguments")?;
                let arguments = reader.arguments(Some(b')'))?;
                reader.scan.expect(b')', ") behind the arguments")?;
                Ok(arguments)
            }
        };
        let arguments = arguments().map_err(|fault| refuse(unit, fault))?;
        if self.is_silent || routine.moves || is_krl {
            let result = self.call(routine, &arguments).map_err(|fault| refuse(unit, fault))?;
            return match result? {
                Signal::Jump(label) => Err(missing_label(&routine.head, &label)),
                Signal::End => Ok(Signal::End),
                Signal::Leave => Err(refuse(&routine.head, RobotFault::Form { expected: "EXIT in a loop alone" })),
                _ => Ok(Signal::Next),
            };
        }
        self.write_statement(unit)?;
        self.follow_silently(&routine.inside, |run| match run.call(routine, &arguments) {
            Ok(followed) => followed.map(drop),
            Err(fault) => Err(refuse(unit, fault)),
        })?;
        // What is passed by reference may have been changed under another name.
        if routine.parameters.iter().any(|parameter| parameter.is_reference) {
            self.forget(unit.at.clone());
        }
        Ok(Signal::Next)
    }

    /// Runs `routine` with `arguments`. The outer error is that of the call, the inner that of a statement of the routine.
    fn call(&mut self, routine: &Routine, arguments: &[Argument]) -> Result<Flow, RobotFault> {
        if self.frames.len() > DEEPEST {
            return RobotFault::not_followed("calls more than 16 deep are", "routines that do not call themselves");
        }
        if routine.handles_errors && routine.moves {
            return RobotFault::not_followed(
                "procedures with motions that handle errors (ERROR, UNDO) are",
                "the handler in the procedure that is called first",
            );
        }
        let mut frame = Frame { is_called: true, ..Frame::default() };
        let mut places = arguments.iter().filter(|argument| argument.name.is_none());
        for parameter in &routine.parameters {
            let named = arguments.iter().find(|argument| argument.name.as_ref() == Some(&parameter.name));
            let given = if parameter.is_optional { named } else { places.next() };
            let Some(argument) = given else {
                if parameter.is_optional {
                    frame.slots.insert(parameter.name.clone(), Slot { is_fixed: true, ..Slot::default() });
                    continue;
                }
                return Err(RobotFault::Form { expected: "an argument for each parameter" });
            };
            if self.is_krl() {
                frame.slots.insert(parameter.name.clone(), self.krl_argument(parameter, argument)?);
                continue;
            }
            // A datum stands for the parameter; what is computed, for its value.
            let is_name = names_in(argument.text.as_bytes(), self.language).first() == Some(&(0..argument.text.len()));
            let outer = self.frames.last().and_then(|frame| frame.slots.get(&argument.text.to_ascii_uppercase()));
            // What the module changes meanwhile is not known through another name.
            let is_shared = parameter.is_reference && self.assigned.contains(&argument.text.to_ascii_uppercase());
            let value = argument.value.clone().ok().filter(|_| !is_shared);
            let own_text = value.as_ref().and_then(|value| value_text(value, self.language));
            let text = match outer.filter(|_| is_name) {
                Some(Slot { stands_for: Some(text), .. }) => Some(text.clone()),
                Some(_) if self.is_called() => own_text,
                _ if is_name
                    && (parameter.is_reference || !matches!(value, Some(Value::Number(_) | Value::Truth(_)))) =>
                {
                    Some(argument.text.clone())
                }
                _ => own_text,
            };
            let Some(text) = text else {
                let fault = argument.value.clone().err();
                return Err(fault.unwrap_or(RobotFault::Form { expected: "an argument that is a datum or a number" }));
            };
            let slot = Slot { value, stands_for: Some(text), is_fixed: parameter.is_reference, ..Slot::default() };
            frame.slots.insert(parameter.name.clone(), slot);
        }
        let is_all = places.next().is_none();
        let is_known = |name: &String| routine.parameters.iter().any(|parameter| parameter.name == *name);
        if !is_all || arguments.iter().filter_map(|argument| argument.name.as_ref()).any(|name| !is_known(name)) {
            return Err(RobotFault::Form { expected: "the parameters that the routine has" });
        }
        self.frames.push(frame);
        let result = self.run_nodes(&routine.body);
        self.frames.pop();
        Ok(result)
    }
}

impl Names for Run<'_> {
    fn language(&self) -> Language {
        self.language
    }

    fn depth(&mut self) -> &mut usize {
        &mut self.depth
    }

    /// Returns the value of a datum of the routine or the module.
    fn value(&mut self, name: &str) -> Result<Value, RobotFault> {
        if self.is_krl() && matches!(name, "$NULLFRAME" | "$WORLD") {
            return Ok(krl::null_frame());
        }
        if name == "PI" && !self.is_krl() {
            return Ok(Value::Number(std::f64::consts::PI));
        }
        let unknown = || RobotFault::NoValue { name: name.to_owned() };
        let (depth, name) = &self.place(name);
        let (depth, name) = (*depth, name.as_str());
        let slot = self.frames[depth].slots.get_mut(name).ok_or_else(unknown)?;
        if let Some(value) = slot.value.clone() {
            self.count_bytes(value.size());
            return Ok(value);
        }
        let written = slot.written.clone().filter(|_| !slot.is_open).ok_or_else(unknown)?;
        slot.is_open = true;
        let source = self.source;
        let value = whole_expression(&source[written], self);
        if let Some(slot) = self.frames[depth].slots.get_mut(name) {
            (slot.value, slot.is_open) = (value.clone().ok(), false);
        }
        value
    }

    /// Returns the value of a function: of RAPID, or of the module.
    fn call(&mut self, name: &str, arguments: &[Argument]) -> Result<Value, RobotFault> {
        if name == "PRESENT" {
            let given = arguments.first().map(|argument| argument.text.to_ascii_uppercase()).unwrap_or_default();
            let slot = self.frames.last().and_then(|frame| frame.slots.get(&given));
            let is_present = slot.is_some_and(|slot| slot.value.is_some() || slot.stands_for.is_some());
            return Ok(Value::Truth(is_present));
        }
        let Some(routine) = self.module.routines.get(name).cloned() else {
            return if self.is_krl() { krl::function(name, arguments) } else { function(name, arguments) };
        };
        if routine.kind != "FUNC" || routine.matters {
            return RobotFault::not_followed("functions that move the tool are", "a procedure");
        }
        if routine.parameters.iter().any(|parameter| parameter.is_reference) {
            return RobotFault::not_followed(
                "functions that may change what they are given are",
                "parameters by value",
            );
        }
        let (was_silent, effects) = (std::mem::replace(&mut self.is_silent, true), self.effects);
        let result = Run::call(self, &routine, arguments);
        self.is_silent = was_silent;
        if self.is_krl() && self.effects != effects {
            return RobotFault::not_followed(
                "functions that do more than compute are",
                "those of their arguments alone",
            );
        }
        match result? {
            Ok(Signal::Return(Some(value))) => Ok(value),
            Ok(_) => Err(RobotFault::Form { expected: "a function that returns a value" }),
            Err(refusal) => Err(refusal.fault),
        }
    }
}
