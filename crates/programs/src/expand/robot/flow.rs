//! Branches and loops: which of their statements run, and how often.

use crate::{
    expand::robot::{
        expression::Reader,
        routine::{Block, Node},
        run::{COUNTER, Flow, Run, Signal, Slot, number_text, refuse, whole_expression},
        syntax::code_bytes,
        value::Value,
    },
    model::robot::RobotFault,
    read::robot::{LocatedFault, rapid::CodeUnit},
};

impl Run<'_> {
    /// Runs the arms of a branch or loop.
    pub fn run_arms(&mut self, block: &Block) -> Flow {
        let head = block.head();
        self.step(head)?;
        match head.word.as_str() {
            "IF" => {
                for (arm, nodes) in &block.arms {
                    if arm.word == "ELSE" || self.condition(arm, "THEN")? {
                        return self.run_nodes(nodes);
                    }
                }
                Ok(Signal::Next)
            }
            "TEST" | "SWITCH" => self.run_test(block),
            "WHILE" | "LOOP" | "REPEAT" => loop {
                if head.word == "WHILE" && !self.condition(head, if self.is_krl() { "" } else { "DO" })? {
                    return Ok(Signal::Next);
                }
                self.step(head)?;
                match self.run_nodes(&block.arms[0].1)? {
                    Signal::Next => {}
                    Signal::Leave => return Ok(Signal::Next),
                    other => return Ok(other),
                }
                if let Some((until, _)) = block.arms.get(1)
                    && self.condition(until, "")?
                {
                    return Ok(Signal::Next);
                }
            },
            _ => self.run_for(head, &block.arms[0].1),
        }
    }

    /// Returns whether the condition between the word of `unit` and `end` holds.
    fn condition(&mut self, unit: &CodeUnit, end: &'static str) -> Result<bool, LocatedFault> {
        let source = self.source;
        let text = &source[unit.at.start + unit.word.len()..unit.at.end];
        let mut reader = Reader::new(text, self);
        let value = reader.expression().and_then(|value| value.truth());
        let is_whole = value.is_err() || reader.takes_word(end) && reader.scan.is_done();
        let form = RobotFault::Form { expected: "a condition" };
        value.and_then(|truth| if is_whole { Ok(truth) } else { Err(form) }).map_err(|fault| refuse(unit, fault))
    }

    /// Runs the case of TEST that has its value.
    fn run_test(&mut self, block: &Block) -> Flow {
        let (source, head) = (self.source, block.head());
        let text = &source[head.at.start + head.word.len()..head.at.end];
        // Without a comment.
        let text = &text[..code_bytes(text, self.language).last().map_or(0, |(at, _)| at + 1)];
        let tested = whole_expression(text, self).map_err(|fault| refuse(head, fault))?;
        if block.arms[0].1.iter().any(|node| !matches!(node, Node::Statement(unit) if unit.word == ";")) {
            return Err(refuse(head, RobotFault::Form { expected: "CASE behind TEST or SWITCH" }));
        }
        for (arm, nodes) in &block.arms[1..] {
            let mut is_here = arm.word == "DEFAULT";
            if !is_here {
                let text = &source[arm.inside(source)];
                let cases = Reader::new(text, self).arguments(None);
                for case in cases.map_err(|fault| refuse(arm, fault))? {
                    let same = case.value.and_then(|value| tested.is_equal(&value));
                    is_here |= same.map_err(|fault| refuse(arm, fault))?;
                }
            }
            if is_here {
                return self.run_nodes(nodes);
            }
        }
        Ok(Signal::Next)
    }

    /// Runs `FOR i FROM a TO b STEP c DO`: without STEP it counts towards its end. `FOR i=a TO b STEP c` of KRL counts upwards, and its
    /// counter is a datum like others, of which it is not certain what it is behind the loop.
    fn run_for(&mut self, head: &CodeUnit, nodes: &[Node]) -> Flow {
        let (name, [from, to], step) = self.counts(head).map_err(|fault| refuse(head, fault))?;
        let steps = step.unwrap_or(if to < from && !self.is_krl() { -1.0 } else { 1.0 });
        let (depth, name) = if self.is_krl() { self.place(&name) } else { (self.frames.len() - 1, name) };
        if self.is_krl() && self.frames[depth].slots.get(&name).is_some_and(|slot| slot.is_fixed) {
            return Err(refuse(head, COUNTER));
        }
        let before = self.frames[depth].slots.remove(&name);
        let (mut count, mut signal) = (from, Signal::Next);
        let (kind, was_own) = before.as_ref().map_or(("", false), |slot| (slot.kind, slot.is_own));
        // A loop that is written as it stands counts with its own counter.
        let mut after = Slot { kind, is_own: !self.is_silent || was_own, ..Slot::default() };
        while matches!(signal, Signal::Next) && if steps > 0.0 { count <= to } else { count >= to } {
            self.step(head)?;
            let stands_for = if self.is_krl() { None } else { Some(number_text(count)) };
            let value = if self.is_krl() { Value::integer(count) } else { Ok(Value::Number(count)) };
            let value = value.and_then(|value| value.taken_as(after.kind)).map_err(|fault| refuse(head, fault))?;
            let slot = Slot { value: Some(value), stands_for, is_fixed: true, ..after.clone() };
            self.frames[depth].slots.insert(name.clone(), slot);
            signal = self.run_nodes(nodes)?;
            let goes_on = self.is_krl() && matches!(signal, Signal::Next);
            if goes_on && self.counts(head).map_err(|fault| refuse(head, fault))?.1[1] != to {
                let fault = RobotFault::Form { expected: "an end that the loop does not change" };
                return Err(refuse(head, fault));
            }
            count += steps;
        }
        let last = self.frames[depth].slots.remove(&name);
        if self.is_krl() {
            after.value = last.and_then(|slot| slot.value).filter(|_| !matches!(signal, Signal::Next));
            self.frames[depth].slots.insert(name, after);
        } else if let Some(before) = before {
            self.frames[depth].slots.insert(name, before);
        }
        Ok(if matches!(signal, Signal::Leave) { Signal::Next } else { signal })
    }

    /// Returns the counter of a FOR, its first and last value, and its step.
    fn counts(&mut self, head: &CodeUnit) -> Result<(String, [f64; 2], Option<f64>), RobotFault> {
        let expected = match self.is_krl() {
            true => RobotFault::Form { expected: "FOR i=a TO b, or STEP c behind it, where c is not 0" },
            false => RobotFault::Form { expected: "FOR i FROM a TO b DO, or STEP c before DO" },
        };
        let is_krl = self.is_krl();
        let source = self.source;
        let mut reader = Reader::new(&source[head.at.start + head.word.len()..head.at.end], self);
        let name = reader.scan.name().0.to_ascii_uppercase();
        if name.is_empty() || !reader.takes_word(if is_krl { "=" } else { "FROM" }) {
            return Err(expected);
        }
        let from = reader.expression()?.number()?;
        if !reader.takes_word("TO") {
            return Err(expected);
        }
        let to = reader.expression()?.number()?;
        let step = if reader.takes_word("STEP") { Some(reader.expression()?.number()?) } else { None };
        let ends = if is_krl { reader.scan.is_done() } else { reader.takes_word("DO") };
        if !ends || step == Some(0.0) {
            return Err(expected);
        }
        // The last pass must not depend on how the controller rounds.
        if [from, to].iter().chain(&step).any(|number| number.fract() != 0.0) {
            return RobotFault::not_followed("counters that are no whole numbers are", "FOR with whole numbers");
        }
        Ok((name, [from, to], step))
    }
}
