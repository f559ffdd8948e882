//! Routines of a robot program as trees: statements, and branches and loops with what stands in them.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
    rc::Rc,
};

use crate::toolpath::{
    model::robot::RobotFault,
    read::robot::{
        Refusal,
        rapid::{CodeUnit, CodeUnits, is_motion},
    },
};

use super::expression::{Reader, names_in};

/// A statement, or a branch or loop with its arms.
#[derive(Clone, Debug)]
pub(crate) enum Node {
    Statement(CodeUnit),
    Block(Block),
}

/// A branch or loop: each arm begins with a word (IF, ELSEIF, ELSE, CASE, …), the first with that of the block.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub arms: Vec<(CodeUnit, Vec<Node>)>,
    /// From its first word to its last.
    pub at: Range<usize>,
}

impl Block {
    /// Returns the statement with which the block begins.
    pub fn head(&self) -> &CodeUnit {
        &self.arms[0].0
    }
}

/// A parameter of a routine.
#[derive(Clone, Debug)]
pub(crate) struct Parameter {
    /// In capitals.
    pub name: String,
    pub is_optional: bool,
    /// Whether the routine may change what it is given.
    pub is_reference: bool,
}

/// A routine of a module.
#[derive(Clone, Debug)]
pub(crate) struct Routine {
    /// In capitals.
    pub name: String,
    /// PROC, FUNC or TRAP.
    pub kind: String,
    /// The line that declares it.
    pub head: CodeUnit,
    pub parameters: Vec<Parameter>,
    pub body: Vec<Node>,
    /// Bytes of what runs: from behind the head to the word that ends it, or begins to handle errors.
    pub inside: Range<usize>,
    /// Its end.
    pub end: usize,
    pub handles_errors: bool,
    /// Whether it, or what it calls, moves the tool.
    pub moves: bool,
}

/// What a module consists of.
#[derive(Debug, Default)]
pub(crate) struct Module {
    /// By names in capitals.
    pub routines: BTreeMap<String, Rc<Routine>>,
    /// Declarations outside of routines.
    pub data: Vec<CodeUnit>,
    /// Where the module's first line ends, behind which a comment may stand.
    pub head_end: usize,
}

/// Most branches and loops in one another.
const DEEPEST: usize = 24;

impl Module {
    /// Reads the module `source`; `Err` for what is not closed.
    pub fn read(source: &[u8]) -> Result<Module, Refusal> {
        let mut module = Module::default();
        let mut units = CodeUnits::new(source);
        let mut found: Vec<Routine> = Vec::new();
        while let Some(unit) = units.next()? {
            match first_word(source, &unit).as_str() {
                "MODULE" => module.head_end = unit.at.end,
                kind @ ("PROC" | "FUNC" | "TRAP") => found.push(read_routine(source, unit, kind, &mut units)?),
                _ if unit.is_statement => module.data.push(unit),
                _ => {}
            }
        }
        mark_moving(source, &mut found);
        for routine in found {
            let (line, at) = (routine.head.line, routine.head.at.clone());
            if module.routines.insert(routine.name.clone(), Rc::new(routine)).is_some() {
                let fault = RobotFault::Form { expected: "each routine once" };
                return Err(Refusal { line, at, fault });
            }
        }
        Ok(module)
    }

    /// Returns the routine that runs first: `main`, or the only procedure with motions that no other routine calls. `Err` if another one that
    /// moves the tool is not called.
    pub fn entry(&self, source: &[u8]) -> Result<Rc<Routine>, Refusal> {
        let mut called = BTreeSet::new();
        for routine in self.routines.values() {
            let own = names_in(&source[routine.inside.clone()]).into_iter();
            let names = own.map(|at| String::from_utf8_lossy(&source[routine.inside.clone()][at]).to_ascii_uppercase());
            called.extend(names.filter(|name| *name != routine.name));
        }
        let mut first: Vec<_> = self.routines.values().filter(|routine| routine.moves).collect();
        first.retain(|routine| routine.name == "MAIN" || !called.contains(&routine.name));
        first.sort_by_key(|routine| (routine.name != "MAIN", routine.head.line));
        let refuse = |routine: &Routine, fault| Refusal { line: routine.head.line, at: routine.head.at.clone(), fault };
        match first[..] {
            [] => {
                let fault = RobotFault::Form { expected: "a procedure with motions that no other calls" };
                let any = self.routines.values().next();
                Err(any.map_or(Refusal { line: 1, at: 0..0, fault: fault.clone() }, |routine| refuse(routine, fault)))
            }
            [only] if only.kind == "PROC" && only.parameters.is_empty() => Ok(Rc::clone(only)),
            [only] => Err(refuse(only, RobotFault::Form { expected: "a procedure without parameters that calls it" })),
            [one, other, ..] => Err(refuse(other, RobotFault::Uncalled { first: one.head.line })),
        }
    }
}

/// Returns the first word of a unit in capitals, without LOCAL.
pub(crate) fn first_word(source: &[u8], unit: &CodeUnit) -> String {
    let words = names_in(&source[unit.at.clone()]);
    let word = |at: Option<&Range<usize>>| {
        let text = at.map(|at| String::from_utf8_lossy(&source[unit.at.clone()][at.clone()]).to_ascii_uppercase());
        text.unwrap_or_default()
    };
    match unit.word.as_str() {
        "LOCAL" if !unit.is_statement => word(words.get(1)),
        word => word.to_owned(),
    }
}

/// Reads a routine that begins at `head` up to its end.
fn read_routine(source: &[u8], head: CodeUnit, kind: &str, units: &mut CodeUnits<'_>) -> Result<Routine, Refusal> {
    let (name, parameters) = signature(source, &head, kind).map_err(|fault| refuse(&head, fault))?;
    let mut inside = head.at.end..head.at.end;
    let mut handles_errors = false;
    // Blocks that are open, and what stands in the innermost arm.
    let mut open: Vec<Block> = Vec::new();
    let mut body = Vec::new();
    loop {
        let Some(unit) = units.next()? else {
            return Err(refuse(&head, RobotFault::Form { expected: "the end of the routine" }));
        };
        let word = if unit.is_statement { "" } else { unit.word.as_str() };
        if matches!(word, "ENDPROC" | "ENDFUNC" | "ENDTRAP" | "ERROR" | "UNDO" | "BACKWARD") && !handles_errors {
            inside.end = unit.at.start;
        }
        match word {
            "ENDPROC" | "ENDFUNC" | "ENDTRAP" => {
                if let Some(block) = open.first() {
                    return Err(refuse(block.head(), RobotFault::Form { expected: "the end of the branch or loop" }));
                }
                let end = unit.at.end;
                let kind = kind.to_owned();
                return Ok(Routine { name, kind, head, parameters, body, inside, end, handles_errors, moves: false });
            }
            "ERROR" | "UNDO" | "BACKWARD" => handles_errors = true,
            _ if handles_errors => {}
            "IF" | "FOR" | "WHILE" | "TEST" => {
                if open.len() == DEEPEST {
                    return Err(refuse(
                        &unit,
                        RobotFault::Form { expected: "fewer branches and loops in one another" },
                    ));
                }
                open.push(Block { at: unit.at.clone(), arms: vec![(unit, Vec::new())] });
            }
            "ELSEIF" | "ELSE" | "CASE" | "DEFAULT" => match open.last_mut() {
                Some(block) => block.arms.push((unit, Vec::new())),
                None => return Err(refuse(&unit, RobotFault::Form { expected: "IF or TEST before it" })),
            },
            "ENDIF" | "ENDFOR" | "ENDWHILE" | "ENDTEST" => match open.pop() {
                Some(mut block) if word[3..] == block.head().word => {
                    block.at.end = unit.at.end;
                    push(Node::Block(block), &mut open, &mut body);
                }
                _ => return Err(refuse(&unit, RobotFault::Form { expected: "the beginning of the branch or loop" })),
            },
            _ => push(Node::Statement(unit), &mut open, &mut body),
        }
    }
}

/// Adds `node` to the innermost open arm, or to `body`.
fn push(node: Node, open: &mut [Block], body: &mut Vec<Node>) {
    match open.last_mut().and_then(|block| block.arms.last_mut()) {
        Some((_, arm)) => arm.push(node),
        None => body.push(node),
    }
}

/// Returns the refusal of a unit.
fn refuse(unit: &CodeUnit, fault: RobotFault) -> Refusal {
    Refusal { line: unit.line, at: unit.at.clone(), fault }
}

/// Reads name and parameters of a routine: `PROC slot(robtarget start,VAR num n\num depth)`.
fn signature(source: &[u8], head: &CodeUnit, kind: &str) -> Result<(String, Vec<Parameter>), RobotFault> {
    const EXPECTED: RobotFault =
        RobotFault::Form { expected: "the name of the routine and its parameters in brackets" };
    let text = String::from_utf8_lossy(&source[head.at.clone()]).to_ascii_uppercase();
    let text = text.split('!').next().unwrap_or_default();
    let (before, inside) = match text.split_once('(') {
        Some((before, inside)) => (before, inside.split_once(')').ok_or(EXPECTED)?.0),
        None => (text, ""),
    };
    let name = before.split_whitespace().last().filter(|name| *name != kind).ok_or(EXPECTED)?.to_owned();
    let mut parameters = Vec::new();
    for part in inside.split(',') {
        for (k, text) in part.split('\\').enumerate() {
            let text = text.replace("{*}", " ");
            let words: Vec<&str> = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
            let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
            let Some(name) = words.last() else { continue };
            let is_reference = matches!(words[0], "VAR" | "INOUT" | "PERS" | "REF");
            parameters.push(Parameter { name: (*name).to_owned(), is_optional: k > 0, is_reference });
        }
    }
    Ok((name, parameters))
}

/// Marks the routines that move the tool, or call one that does.
fn mark_moving(source: &[u8], routines: &mut [Routine]) {
    let names = |routine: &Routine| -> BTreeSet<String> {
        let inside = &source[routine.inside.clone()];
        let names = names_in(inside).into_iter();
        names.map(|at| String::from_utf8_lossy(&inside[at]).to_ascii_uppercase()).collect()
    };
    let names: Vec<_> = routines.iter().map(names).collect();
    let own: BTreeSet<String> = routines.iter().map(|routine| routine.name.clone()).collect();
    let mut moving: BTreeSet<String> = BTreeSet::new();
    loop {
        let before = moving.len();
        for (routine, names) in routines.iter_mut().zip(&names) {
            routine.moves |= names.iter().any(|name| match own.contains(name) {
                true => moving.contains(name) && *name != routine.name,
                false => is_motion(name),
            });
            if routine.moves {
                moving.insert(routine.name.clone());
            }
        }
        if moving.len() == before {
            return;
        }
    }
}

/// Splits `IF condition statement;`: the ranges of both in the source.
pub(crate) fn one_line_if(source: &[u8], unit: &CodeUnit) -> Result<(Range<usize>, CodeUnit), RobotFault> {
    let from = unit.at.start + unit.word.len();
    let text = &source[from..unit.at.end];
    let mut reader = Reader::without_values(text);
    reader.expression()?;
    let start = from + reader.scan.skip_blanks().at;
    let mut scan = crate::toolpath::read::scan::Scan::new(&source[start..unit.at.end]);
    let word = scan.name().0.to_ascii_uppercase();
    let line = unit.line + source[unit.at.start..start].iter().filter(|byte| **byte == b'\n').count();
    Ok((from..start, CodeUnit { at: start..unit.at.end, line, word, is_statement: true }))
}
