//! Runs a RAPID module from its first routine on, and writes each statement that is run, with computed targets as numbers.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
};

use crate::toolpath::{
    expand::robot::{
        expression::{Names, Reader, names_in},
        routine::{Block, Module, Node, Routine, one_line_if},
        value::Value,
    },
    model::robot::RobotFault,
    read::{
        robot::{
            Chunk, Refusal, indent, line_ending,
            rapid::{CodeUnit, code_bytes, is_motion},
        },
        scan::Scan,
    },
};

/// Most statements that are run.
const MOST_STEPS: usize = 1_000_000;

/// What follows a statement.
#[derive(Debug)]
pub(crate) enum Signal {
    Next,
    /// The routine returns.
    Return(Option<Value>),
    /// A jump to a label.
    Jump(String),
    /// The program ends.
    End,
}

pub(crate) type Flow = Result<Signal, Refusal>;

/// A datum.
#[derive(Clone, Debug, Default)]
pub(crate) struct Slot {
    /// `None` if it is not known.
    pub value: Option<Value>,
    /// The expression of its first value, until another is assigned.
    pub written: Option<Range<usize>>,
    /// Whether that is being evaluated.
    pub is_open: bool,
    /// What stands for it in statements that are written, if its own name has no meaning there.
    pub stands_for: Option<String>,
    /// Whether assignments to it are refused: parameters by reference, and counters.
    pub is_fixed: bool,
}

/// Data of a routine that runs.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    pub slots: BTreeMap<String, Slot>,
    /// Whether the routine is not that which is written: its data have no names there.
    pub is_called: bool,
}

/// A module that is run.
#[derive(Debug)]
pub(crate) struct Run<'a> {
    pub source: &'a [u8],
    pub module: &'a Module,
    /// Data of the module, and of the routines that run.
    pub frames: Vec<Frame>,
    pub out: Vec<u8>,
    pub chunks: Vec<Chunk>,
    steps: usize,
    /// Whether statements are only followed, not written.
    pub is_silent: bool,
    /// Names of data that the module assigns anywhere, and of those that interrupts assign.
    pub assigned: BTreeSet<String>,
    pub changed_by_traps: BTreeSet<String>,
    line_ending: &'static [u8],
    /// End of the last statement that was written.
    last_end: usize,
}

impl<'a> Run<'a> {
    /// Prepares to run `module`, whose text is `source`.
    pub fn new(source: &'a [u8], module: &'a Module) -> Self {
        let mut run = Self {
            source,
            module,
            frames: vec![Frame::default()],
            out: Vec::new(),
            chunks: Vec::new(),
            steps: 0,
            is_silent: false,
            assigned: BTreeSet::new(),
            changed_by_traps: BTreeSet::new(),
            line_ending: line_ending(source),
            last_end: 0,
        };
        let (mut assigned, mut changed_by_traps) = (BTreeSet::new(), BTreeSet::new());
        for routine in module.routines.values() {
            run.assigned_names(routine.head.at.end..routine.end, &mut assigned);
            if routine.kind == "TRAP" {
                run.assigned_names(routine.inside.clone(), &mut changed_by_traps);
            }
        }
        (run.assigned, run.changed_by_traps) = (assigned, changed_by_traps);
        for unit in &module.data {
            run.declare(unit, true);
        }
        run
    }

    /// Runs the routine from which the program starts.
    pub fn run_entry(&mut self, entry: &Routine) -> Result<(), Refusal> {
        self.frames.push(Frame::default());
        self.last_end = entry.inside.start;
        match self.run_nodes(&entry.body)? {
            Signal::Jump(label) => Err(missing_label(&entry.head, &label)),
            _ => Ok(()),
        }
    }

    /// Runs statements one after another, and jumps among them.
    pub fn run_nodes(&mut self, nodes: &[Node]) -> Flow {
        let mut at = 0;
        while let Some(node) = nodes.get(at) {
            let signal = match node {
                Node::Statement(unit) => self.run_statement(unit)?,
                Node::Block(block) => self.run_block(block)?,
            };
            at = match signal {
                Signal::Next => at + 1,
                Signal::Jump(label) => match nodes.iter().position(|node| is_label(node, &label)) {
                    Some(target) => target,
                    None => return Ok(Signal::Jump(label)),
                },
                other => return Ok(other),
            };
        }
        Ok(Signal::Next)
    }

    /// Counts a step; `Err` beyond [`MOST_STEPS`].
    fn step(&mut self, unit: &CodeUnit) -> Result<(), Refusal> {
        self.steps += 1;
        match self.steps > MOST_STEPS {
            true => Err(refuse(unit, RobotFault::TooManySteps { most: MOST_STEPS })),
            false => Ok(()),
        }
    }

    /// Runs a branch or loop: what moves nothing stays as it stands.
    fn run_block(&mut self, block: &Block) -> Flow {
        let stays =
            !self.is_silent && !self.moves(&block.at) && !self.leaves(&block.at) && !self.uses_own_data(&block.at);
        if !stays {
            return self.run_arms(block);
        }
        let head = block.head();
        self.write(&CodeUnit { at: block.at.clone(), ..head.clone() }, self.source[block.at.clone()].to_vec());
        self.follow_silently(&block.at, |run| run.run_arms(block).map(drop))?;
        Ok(Signal::Next)
    }

    /// Follows what is written as it stands: where that cannot be followed, what it assigns is not known from there on.
    pub fn follow_silently(
        &mut self,
        at: &Range<usize>,
        follow: impl FnOnce(&mut Self) -> Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        let (was_silent, depth) = (std::mem::replace(&mut self.is_silent, true), self.frames.len());
        let followed = follow(self);
        self.is_silent = was_silent;
        self.frames.truncate(depth);
        match followed {
            Err(refusal) if matches!(refusal.fault, RobotFault::TooManySteps { .. }) => Err(refusal),
            Err(_) => {
                self.forget(at.clone());
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    /// Runs the arms of a branch or loop.
    fn run_arms(&mut self, block: &Block) -> Flow {
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
            "TEST" => self.run_test(block),
            "WHILE" => {
                while self.condition(head, "DO")? {
                    self.step(head)?;
                    match self.run_nodes(&block.arms[0].1)? {
                        Signal::Next => {}
                        other => return Ok(other),
                    }
                }
                Ok(Signal::Next)
            }
            _ => self.run_for(head, &block.arms[0].1),
        }
    }

    /// Returns whether the condition between the word of `unit` and `end` holds.
    fn condition(&mut self, unit: &CodeUnit, end: &'static str) -> Result<bool, Refusal> {
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
        let text = &text[..code_bytes(text).last().map_or(0, |(at, _)| at + 1)];
        let tested = whole_expression(text, self).map_err(|fault| refuse(head, fault))?;
        if !block.arms[0].1.is_empty() {
            return Err(refuse(head, RobotFault::Form { expected: "CASE behind TEST" }));
        }
        for (arm, nodes) in &block.arms[1..] {
            let mut is_here = arm.word == "DEFAULT";
            if !is_here {
                let text = &source[arm.at.start + arm.word.len()..arm.at.end - 1];
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

    /// Runs `FOR i FROM a TO b STEP c DO`: without STEP it counts towards its end.
    fn run_for(&mut self, head: &CodeUnit, nodes: &[Node]) -> Flow {
        let (name, [from, to], step) = self.counts(head).map_err(|fault| refuse(head, fault))?;
        let step = step.unwrap_or(if to < from { -1.0 } else { 1.0 });
        let before = self.frame().slots.remove(&name);
        let (mut count, mut signal) = (from, Signal::Next);
        while matches!(signal, Signal::Next) && if step > 0.0 { count <= to } else { count >= to } {
            self.step(head)?;
            let stands_for = Some(number_text(count));
            let slot = Slot { value: Some(Value::Number(count)), stands_for, is_fixed: true, ..Slot::default() };
            self.frame().slots.insert(name.clone(), slot);
            signal = self.run_nodes(nodes)?;
            count += step;
        }
        self.frame().slots.remove(&name);
        if let Some(before) = before {
            self.frame().slots.insert(name, before);
        }
        Ok(signal)
    }

    /// Returns the counter of a FOR, its first and last value, and its step.
    fn counts(&mut self, head: &CodeUnit) -> Result<(String, [f64; 2], Option<f64>), RobotFault> {
        const EXPECTED: RobotFault = RobotFault::Form { expected: "FOR i FROM a TO b DO, or STEP c before DO" };
        let source = self.source;
        let mut reader = Reader::new(&source[head.at.start + head.word.len()..head.at.end], self);
        let name = reader.scan.name().0.to_ascii_uppercase();
        if name.is_empty() || !reader.takes_word("FROM") {
            return Err(EXPECTED);
        }
        let from = reader.expression()?.number()?;
        if !reader.takes_word("TO") {
            return Err(EXPECTED);
        }
        let to = reader.expression()?.number()?;
        let step = if reader.takes_word("STEP") { Some(reader.expression()?.number()?) } else { None };
        if !reader.takes_word("DO") || step == Some(0.0) {
            return Err(EXPECTED);
        }
        // The last pass must not depend on how the controller rounds.
        if [from, to].iter().chain(&step).any(|number| number.fract() != 0.0) {
            return RobotFault::not_followed("counters that are no whole numbers are", "FOR with whole numbers");
        }
        Ok((name, [from, to], step))
    }

    /// Runs a statement.
    fn run_statement(&mut self, unit: &CodeUnit) -> Flow {
        self.step(unit)?;
        let source = self.source;
        match unit.word.as_str() {
            _ if !unit.is_statement => {
                // A label, or a call by a computed name, which is refused where it is read.
                if source[unit.at.start] == b'%' {
                    self.write(unit, source[unit.at.clone()].to_vec());
                }
                Ok(Signal::Next)
            }
            "IF" => self.run_one_line_if(unit),
            "GOTO" => {
                let label = Scan::new(&source[unit.at.start + 4..unit.at.end]).name().0.to_ascii_uppercase();
                Ok(Signal::Jump(label))
            }
            "RETURN" => {
                let text = source[unit.at.start + 6..unit.at.end - 1].trim_ascii();
                if text.is_empty() {
                    return Ok(Signal::Return(None));
                }
                let value = whole_expression(text, self).map_err(|fault| refuse(unit, fault))?;
                Ok(Signal::Return(Some(value)))
            }
            "EXIT" => {
                self.write_statement(unit)?;
                Ok(Signal::End)
            }
            "CONST" | "PERS" | "VAR" => {
                self.declare(unit, false);
                if !self.is_called() {
                    self.write_statement(unit)?;
                }
                Ok(Signal::Next)
            }
            word => match self.module.routines.get(word).cloned() {
                Some(routine) => self.call_procedure(unit, &routine),
                None if is_motion(word) => self.write_motion(unit).map(|()| Signal::Next),
                None => self.assign_or_copy(unit).map(|()| Signal::Next),
            },
        }
    }

    /// Runs `IF condition statement;`.
    fn run_one_line_if(&mut self, unit: &CodeUnit) -> Flow {
        let (condition, inner) = one_line_if(self.source, unit).map_err(|fault| refuse(unit, fault))?;
        let stays =
            !self.is_silent && !self.leaves(&inner.at) && !self.moves(&inner.at) && !self.uses_own_data(&unit.at);
        if stays {
            self.write(unit, self.source[unit.at.clone()].to_vec());
            self.follow_silently(&unit.at, |run| run.run_inner(unit, &condition, &inner).map(drop))?;
            return Ok(Signal::Next);
        }
        self.run_inner(unit, &condition, &inner)
    }

    /// Runs the statement `inner` if its condition holds.
    fn run_inner(&mut self, unit: &CodeUnit, condition: &Range<usize>, inner: &CodeUnit) -> Flow {
        let source = self.source;
        let value = whole_expression(&source[condition.clone()], self).and_then(|value| value.truth());
        match value.map_err(|fault| refuse(unit, fault))? {
            true => self.run_statement(inner),
            false => Ok(Signal::Next),
        }
    }

    /// Returns the data of the routine that runs.
    pub fn frame(&mut self) -> &mut Frame {
        let last = self.frames.len() - 1;
        &mut self.frames[last]
    }

    /// Whether a called routine runs.
    pub fn is_called(&self) -> bool {
        self.frames.last().is_some_and(|frame| frame.is_called)
    }

    /// Whether the text `at` moves the tool, or calls what does.
    pub fn moves(&self, at: &Range<usize>) -> bool {
        let text = &self.source[at.clone()];
        names_in(text).into_iter().any(|at| {
            let name = String::from_utf8_lossy(&text[at]).to_ascii_uppercase();
            self.module.routines.get(&name).map_or_else(|| is_motion(&name), |routine| routine.moves)
        })
    }

    /// Whether the text `at` may end a routine, or jump.
    fn leaves(&self, at: &Range<usize>) -> bool {
        const WORDS: [&str; 7] = ["GOTO", "RETURN", "EXIT", "EXITCYCLE", "RAISE", "RETRY", "TRYNEXT"];
        let text = &self.source[at.clone()];
        names_in(text)
            .into_iter()
            .any(|at| WORDS.iter().any(|word| text[at.clone()].eq_ignore_ascii_case(word.as_bytes())))
    }

    /// Whether the text `at` uses data that have no names in the program as it is written.
    fn uses_own_data(&self, at: &Range<usize>) -> bool {
        let text = &self.source[at.clone()];
        let Some(frame) = self.frames.last() else { return false };
        names_in(text).into_iter().any(|at| {
            let slot = frame.slots.get(&String::from_utf8_lossy(&text[at]).to_ascii_uppercase());
            slot.is_some_and(|slot| frame.is_called || slot.stands_for.is_some())
        })
    }

    /// Whether statements are written.
    pub fn is_writing(&self) -> bool {
        !self.is_silent
    }

    /// Writes `text` in place of the statement `unit`, with comments before and behind it.
    pub fn write(&mut self, unit: &CodeUnit, text: Vec<u8>) {
        let source = self.source;
        let gap = source.get(self.last_end..unit.at.start).unwrap_or_default();
        // Comments on lines of their own right before it.
        let is_comment = |line: &&[u8]| line.is_empty() || line.starts_with(b"!");
        let lines = gap.split(|byte| *byte == b'\n').skip(1).map(<[u8]>::trim_ascii);
        let lines: Vec<&[u8]> = lines.collect();
        let comments = lines.iter().rev().copied().take_while(is_comment).filter(|line| !line.is_empty());
        for comment in comments.collect::<Vec<_>>().into_iter().rev() {
            self.out.extend_from_slice(indent(source, unit.at.start).0);
            self.out.extend_from_slice(comment);
            self.out.extend_from_slice(self.line_ending);
        }
        self.out.extend_from_slice(indent(source, unit.at.start).0);
        let start = self.out.len();
        self.out.extend(text);
        self.chunks.push(Chunk { at: start..self.out.len(), origin: unit.at.clone(), is_run: true });
        let rest = &source[unit.at.end..];
        let rest = &rest[..rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')).unwrap_or(rest.len())];
        if rest.trim_ascii_start().starts_with(b"!") {
            self.out.extend_from_slice(rest);
        }
        self.out.extend_from_slice(self.line_ending);
        self.last_end = unit.at.end;
    }
}

/// Returns the value of the expression that is all of `text`.
pub(crate) fn whole_expression(text: &[u8], names: &mut dyn Names) -> Result<Value, RobotFault> {
    let mut reader = Reader::new(text, names);
    let value = reader.expression()?;
    match reader.scan.is_done() {
        true => Ok(value),
        false => Err(RobotFault::Form { expected: "an expression and nothing behind it" }),
    }
}

/// Returns a number as it is written in a statement.
pub(crate) fn number_text(number: f64) -> String {
    crate::toolpath::model::format_shortest(number, 0).trim_end_matches('.').to_owned()
}

/// Returns a value as it is written in a statement: its numbers in brackets.
pub(crate) fn value_text(value: &Value) -> Option<String> {
    match value {
        Value::Number(number) if number.abs() >= 9e8 => Some(format!("{number:E}").replace('E', "E+0")),
        Value::Number(number) => Some(number_text(*number)),
        Value::Truth(truth) => Some(if *truth { "TRUE" } else { "FALSE" }.to_owned()),
        Value::Text(text) => Some(text.clone()),
        Value::List(parts) => {
            let parts: Option<Vec<String>> = parts.iter().map(value_text).collect();
            Some(format!("[{}]", parts?.join(",")))
        }
    }
}

/// Returns the refusal of a statement.
pub(crate) fn refuse(unit: &CodeUnit, fault: RobotFault) -> Refusal {
    Refusal { line: unit.line, at: unit.at.clone(), fault }
}

/// Returns the refusal of a jump that leads nowhere.
pub(crate) fn missing_label(head: &CodeUnit, _label: &str) -> Refusal {
    refuse(head, RobotFault::NotFollowed { what: "jumps into branches and loops are", expected: "a label outside" })
}

/// Whether `node` is the label `name`.
fn is_label(node: &Node, name: &str) -> bool {
    matches!(node, Node::Statement(unit) if !unit.is_statement && unit.word == name)
}
