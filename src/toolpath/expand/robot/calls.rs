//! Calls of procedures and functions of RAPID, and what names stand for in expressions.

use std::rc::Rc;

use crate::toolpath::{
    expand::robot::{
        expression::{Argument, Names, Reader, names_in},
        functions::function,
        routine::Routine,
        run::{Flow, Frame, Run, Signal, Slot, missing_label, refuse, value_text, whole_expression},
        value::Value,
    },
    model::robot::RobotFault,
    read::robot::rapid::CodeUnit,
};

/// Most calls in one another.
const DEEPEST: usize = 16;

impl Run<'_> {
    /// Calls a procedure: one that moves the tool is run where it is called, another is called as before.
    pub fn call_procedure(&mut self, unit: &CodeUnit, routine: &Rc<Routine>) -> Flow {
        let source = self.source;
        let text = &source[unit.at.start + unit.word.len()..unit.at.end - 1];
        let arguments = Reader::new(text, self).arguments(None).map_err(|fault| refuse(unit, fault))?;
        if self.is_silent || routine.moves {
            let result = self.call(routine, &arguments).map_err(|fault| refuse(unit, fault))?;
            return match result? {
                Signal::Jump(label) => Err(missing_label(&routine.head, &label)),
                Signal::End => Ok(Signal::End),
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
            // A datum stands for the parameter; what is computed, for its value.
            let is_name = names_in(argument.text.as_bytes()).first() == Some(&(0..argument.text.len()));
            let outer = self.frames.last().and_then(|frame| frame.slots.get(&argument.text.to_ascii_uppercase()));
            // What the module changes meanwhile is not known through another name.
            let is_shared = parameter.is_reference && self.assigned.contains(&argument.text.to_ascii_uppercase());
            let value = argument.value.clone().ok().filter(|_| !is_shared);
            let own_text = value.as_ref().and_then(value_text);
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
    /// Returns the value of a datum of the routine or the module.
    fn value(&mut self, name: &str) -> Result<Value, RobotFault> {
        if name == "PI" {
            return Ok(Value::Number(std::f64::consts::PI));
        }
        let unknown = || RobotFault::NoValue { name: name.to_owned() };
        let last = self.frames.len() - 1;
        let depth = if self.frames[last].slots.contains_key(name) { last } else { 0 };
        let slot = self.frames[depth].slots.get_mut(name).ok_or_else(unknown)?;
        if let Some(value) = &slot.value {
            return Ok(value.clone());
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
            return function(name, arguments);
        };
        if routine.kind != "FUNC" || routine.moves {
            return RobotFault::not_followed("functions that move the tool are", "a procedure");
        }
        if routine.parameters.iter().any(|parameter| parameter.is_reference) {
            return RobotFault::not_followed(
                "functions that may change what they are given are",
                "parameters by value",
            );
        }
        let was_silent = std::mem::replace(&mut self.is_silent, true);
        let result = Run::call(self, &routine, arguments);
        self.is_silent = was_silent;
        match result? {
            Ok(Signal::Return(Some(value))) => Ok(value),
            Ok(_) => Err(RobotFault::Form { expected: "a function that returns a value" }),
            Err(refusal) => Err(refusal.fault),
        }
    }
}
