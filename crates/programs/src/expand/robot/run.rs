//! Runs a program of RAPID or KRL from its first routine on, and writes each statement that is run, with computed targets as numbers.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
};

use crate::{
    expand::robot::{
        expression::{Names, Reader},
        routine::{Block, Module, Node, Routine, one_line_if},
        syntax::{Units, comment_mark, is_declaration, is_motion, matters_to_motions, names_of},
        value::Value,
    },
    model::{
        MAX_MIB,
        robot::{Language, RobotFault},
    },
    read::{
        robot::{Chunk, LocatedFault, indent, line_ending, rapid::CodeUnit, scan::check_depth},
        scan::Scan,
    },
};

/// Most statements that are run.
const MAX_STEPS: usize = 1_000_000;

/// What follows a statement.
#[derive(Debug)]
pub(crate) enum Signal {
    Next,
    /// The routine returns.
    Return(Option<Value>),
    /// A jump to a label.
    Jump(String),
    /// The innermost loop ends (EXIT of KRL).
    Leave,
    /// The program ends.
    End,
}

pub(crate) type Flow = Result<Signal, LocatedFault>;

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
    /// Whether its name has no meaning in statements that are written, though its frame's names have: a counter of KRL.
    pub is_own: bool,
    /// What a parameter of KRL is another name for: a frame, and the name there.
    pub refers_to: Option<(usize, String)>,
    /// Type of KRL, of an array that of its elements; empty for others.
    pub kind: &'static str,
}

/// Data of a routine that runs.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    pub slots: BTreeMap<String, Slot>,
    /// Number of elements in its arrays.
    pub elements: usize,
    /// Whether the routine is not that which is written: its data have no names there.
    pub is_called: bool,
}

/// A module that is run.
#[derive(Debug)]
pub(crate) struct Run<'a> {
    pub source: &'a [u8],
    pub module: &'a Module,
    pub language: Language,
    /// Data of the module, and of the routines that run.
    pub frames: Vec<Frame>,
    pub out: Vec<u8>,
    pub chunks: Vec<Chunk>,
    steps: usize,
    /// Bytes of the statements that were run.
    bytes: usize,
    /// Levels of brackets, signs, branches and data that are open.
    pub depth: usize,
    /// Whether statements are only followed, not written.
    pub is_silent: bool,
    /// Number of statements that were followed silently and do more than compute.
    pub effects: usize,
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
            language: module.language,
            frames: vec![Frame::default()],
            out: Vec::new(),
            chunks: Vec::new(),
            steps: 0,
            bytes: 0,
            depth: 0,
            is_silent: false,
            effects: 0,
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
        // What a trigger or an interrupt of KRL runs.
        let mut units = Units::new(source, module.language);
        while let Ok(Some(unit)) = units.next() {
            let mut words = names_of(&source[unit.at.clone()], module.language).take(2);
            if run.is_krl() && words.any(|word| matches!(word.as_str(), "TRIGGER" | "INTERRUPT")) {
                run.assigned_names(unit.at, &mut changed_by_traps);
            }
        }
        (run.assigned, run.changed_by_traps) = (assigned, changed_by_traps);
        for unit in &module.data {
            run.declare(unit, true);
        }
        run
    }

    /// Whether the program is one of KRL.
    pub fn is_krl(&self) -> bool {
        self.language == Language::Krl
    }

    /// Returns where the datum `name` is: the depth of its frame, and its name there.
    pub fn place(&self, name: &str) -> (usize, String) {
        let last = self.frames.len() - 1;
        let depth = if self.frames[last].slots.contains_key(name) { last } else { 0 };
        let slot = self.frames[depth].slots.get(name);
        slot.and_then(|slot| slot.refers_to.clone()).unwrap_or_else(|| (depth, name.to_owned()))
    }

    /// Runs the routine from which the program starts.
    pub fn run_entry(&mut self, entry: &Routine) -> Result<(), LocatedFault> {
        self.frames.push(Frame::default());
        self.last_end = entry.inside.start;
        match self.run_nodes(&entry.body)? {
            Signal::Jump(label) => Err(missing_label(&entry.head, &label)),
            Signal::Leave => Err(refuse(&entry.head, RobotFault::Form { expected: "EXIT in a loop alone" })),
            _ => Ok(()),
        }
    }

    /// Runs statements one after another, and jumps among them.
    pub fn run_nodes(&mut self, nodes: &[Node]) -> Flow {
        let mut at = 0;
        while let Some(node) = nodes.get(at) {
            let signal = match node {
                Node::Statement(unit) => self.run_statement(unit)?,
                Node::Block(block) => self.nested(block.head(), |run| run.run_block(block))?,
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

    /// Counts a step; `Err` beyond [`MAX_STEPS`], and where statements are too long in all.
    pub fn step(&mut self, unit: &CodeUnit) -> Result<(), LocatedFault> {
        self.steps += 1;
        self.count_bytes(unit.at.len());
        match self.steps {
            steps if steps > MAX_STEPS => Err(refuse(unit, RobotFault::TooManySteps { most: MAX_STEPS })),
            _ if self.bytes > MAX_MIB << 20 => Err(refuse(unit, RobotFault::TooManyBytes)),
            _ => Ok(()),
        }
    }

    /// Counts bytes that a step has looked at.
    pub fn count_bytes(&mut self, bytes: usize) {
        self.bytes = self.bytes.saturating_add(bytes);
    }

    /// Runs what stands in `unit` one level deeper.
    fn nested(&mut self, unit: &CodeUnit, run: impl FnOnce(&mut Self) -> Flow) -> Flow {
        self.depth += 1;
        let flow = check_depth(&self.source[unit.at.clone()], self.depth).map_err(|fault| refuse(unit, fault));
        let flow = flow.and_then(|()| run(self));
        self.depth -= 1;
        flow
    }

    /// Runs a branch or loop: what moves nothing stays as it stands.
    fn run_block(&mut self, block: &Block) -> Flow {
        self.count_bytes(block.at.len());
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
        follow: impl FnOnce(&mut Self) -> Result<(), LocatedFault>,
    ) -> Result<(), LocatedFault> {
        let (was_silent, depth) = (std::mem::replace(&mut self.is_silent, true), self.frames.len());
        let followed = follow(self);
        self.is_silent = was_silent;
        self.frames.truncate(depth);
        match followed {
            Err(refusal) if refusal.fault.is_limit() => Err(refusal),
            Err(_) => {
                self.forget(at.clone());
                Ok(())
            }
            Ok(()) => Ok(()),
        }
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
            ";" => {
                if self.is_writing() {
                    self.write(unit, source[unit.at.clone()].to_vec());
                }
                Ok(Signal::Next)
            }
            "IF" => self.nested(unit, |run| run.run_one_line_if(unit)),
            "GOTO" => {
                let label = Scan::new(&source[unit.at.start + 4..unit.at.end]).name().0.to_ascii_uppercase();
                Ok(Signal::Jump(label))
            }
            "RETURN" => {
                let text = source[unit.inside(source)].trim_ascii();
                if text.is_empty() {
                    return Ok(Signal::Return(None));
                }
                let value = whole_expression(text, self).map_err(|fault| refuse(unit, fault))?;
                Ok(Signal::Return(Some(value)))
            }
            "EXIT" if self.is_krl() => Ok(Signal::Leave),
            "EXIT" => {
                self.write_statement(unit)?;
                Ok(Signal::End)
            }
            "SIGNAL" | "STRUC" | "ENUM" | "EXT" | "EXTFCT" if self.is_krl() && self.is_called() => Err(refuse(
                unit,
                RobotFault::NotFollowed {
                    what: "types, signals and external routines of a routine that is called are",
                    expected: "their declaration in the first routine, or in the .dat",
                },
            )),
            word if is_declaration(word, self.language) => {
                self.declare(unit, false);
                if !self.is_called() {
                    self.write_statement(unit)?;
                }
                Ok(Signal::Next)
            }
            word => match self.module.routines.get(word).cloned() {
                Some(routine) => self.call_procedure(unit, &routine),
                None if is_motion(word, self.language) => self.write_motion(unit).map(|()| Signal::Next),
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

    /// Whether the text `at` moves the tool, or calls what does. Calls of KRL are all followed.
    pub fn moves(&self, at: &Range<usize>) -> bool {
        names_of(&self.source[at.clone()], self.language).any(|name| match self.module.routines.get(&name) {
            Some(routine) => routine.matters || self.is_krl() && routine.kind == "PROC",
            None => matters_to_motions(&name, self.language),
        })
    }

    /// Whether the text `at` may end a routine, or jump.
    fn leaves(&self, at: &Range<usize>) -> bool {
        const WORDS: [&str; 7] = ["GOTO", "RETURN", "EXIT", "EXITCYCLE", "RAISE", "RETRY", "TRYNEXT"];
        let mut names = names_of(&self.source[at.clone()], self.language).peekable();
        // EXIT of KRL leaves a loop alone.
        let is_loop = names.peek().is_some_and(|word| matches!(word.as_str(), "FOR" | "WHILE" | "LOOP" | "REPEAT"));
        let stays = |name: &String| self.is_krl() && is_loop && name == "EXIT";
        names.any(|name| WORDS.contains(&name.as_str()) && !stays(&name))
    }

    /// Whether the text `at` uses data that have no names in the program as it is written.
    fn uses_own_data(&self, at: &Range<usize>) -> bool {
        names_of(&self.source[at.clone()], self.language).any(|name| {
            let is_alias = self.frames.last().is_some_and(|frame| frame.slots.contains_key(&name)) && self.is_called();
            is_alias || self.is_hidden(&name) || self.is_own(&self.place(&name))
        })
    }

    /// Whether the first routine has another datum called `name`, which a statement of the present routine would mean if it stood there.
    pub fn is_hidden(&self, name: &str) -> bool {
        let (depth, name) = self.place(name);
        let is_in_first = self.frames.get(1).is_some_and(|frame| frame.slots.contains_key(&name));
        self.is_called() && depth == 0 && is_in_first
    }

    /// Whether the name of the datum at `place` has no meaning in statements that are written.
    pub fn is_own(&self, (depth, name): &(usize, String)) -> bool {
        let frame = &self.frames[*depth];
        let slot = frame.slots.get(name);
        slot.is_some_and(|slot| frame.is_called || slot.is_own || slot.stands_for.is_some())
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
        self.count_bytes(gap.len());
        let start = self.out.len();
        self.out.extend(text);
        self.chunks.push(Chunk { at: start..self.out.len(), origin: unit.at.clone(), is_run: true });
        let rest = &source[unit.at.end..];
        let rest = &rest[..rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')).unwrap_or(rest.len())];
        if unit.word != ";" && rest.trim_ascii_start().first() == Some(&comment_mark(self.language)) {
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
    crate::model::format_shortest(number, 0).trim_end_matches('.').to_owned()
}

/// Returns a value as it is written in a statement: its numbers in brackets; `None` where it, or a part of it, has no value.
pub(crate) fn value_text(value: &Value, language: Language) -> Option<String> {
    match value {
        _ if language == Language::Krl => super::krl::value_text(value),
        Value::Number(number) if !number.is_finite() => None,
        Value::Number(number) if number.abs() >= 9e8 => Some(format!("{number:E}").replace('E', "E+0")),
        Value::Number(number) => Some(number_text(*number)),
        Value::Truth(truth) => Some(if *truth { "TRUE" } else { "FALSE" }.to_owned()),
        Value::Text(text) => Some(text.clone()),
        Value::List(parts) => {
            let parts: Option<Vec<String>> = parts.iter().map(|part| value_text(part, language)).collect();
            Some(format!("[{}]", parts?.join(",")))
        }
        Value::Integer(_) | Value::Unknown => None,
    }
}

/// Returns the refusal of a statement.
pub(crate) fn refuse(unit: &CodeUnit, fault: RobotFault) -> LocatedFault {
    LocatedFault { line: unit.line, at: unit.at.clone(), fault }
}

/// Fault of a counter or a parameter that is assigned.
pub(crate) const COUNTER: RobotFault = RobotFault::NotFollowed {
    what: "parameters that a procedure changes for its caller, and counters that are assigned, are",
    expected: "data of the module",
};

/// Returns the refusal of a jump that leads nowhere.
pub(crate) fn missing_label(head: &CodeUnit, _label: &str) -> LocatedFault {
    refuse(head, RobotFault::NotFollowed { what: "jumps into branches and loops are", expected: "a label outside" })
}

/// Whether `node` is the label `name`.
fn is_label(node: &Node, name: &str) -> bool {
    matches!(node, Node::Statement(unit) if !unit.is_statement && unit.word == name)
}
