//! Routines of a robot program as trees: statements, and branches and loops with what stands in them.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
    rc::Rc,
};

use crate::{
    expand::robot::syntax::{Units, is_motion, matters_to_motions, names_of},
    model::robot::{Language, RobotFault},
    read::robot::{
        LocatedFault,
        rapid::{CODE_BEHIND, CodeUnit, MOTION_IN_FUNCTION, has_code_behind, one_line_statement, uncalled},
        scan::check_depth,
    },
};

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
    /// PROC, FUNC or TRAP; DEF of KRL is PROC, and DEFFCT is FUNC.
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
    /// Whether it, or what it calls, moves the tool or sets what a motion means.
    pub matters: bool,
}

/// What a module consists of.
#[derive(Debug)]
pub(crate) struct Module {
    pub language: Language,
    /// By names in capitals.
    pub routines: BTreeMap<String, Rc<Routine>>,
    /// Declarations outside of routines.
    pub data: Vec<CodeUnit>,
    /// Where the module's first line ends, behind which a comment may stand.
    pub head_end: usize,
    /// Name of the first routine.
    first: Option<String>,
    /// Where the data begin that are no other program's.
    pub own_data: usize,
    /// Names of procedures of RAPID that nothing calls.
    pub uncalled: BTreeSet<String>,
}

impl Module {
    /// Reads the module `source`; `Err` for what is not closed. All beyond `length` bytes are data, which are its own from `own_data` on.
    pub fn read(source: &[u8], length: usize, own_data: usize, language: Language) -> Result<Module, LocatedFault> {
        let (routines, data) = (BTreeMap::new(), Vec::new());
        let uncalled = if language == Language::Rapid { uncalled(&source[..length])? } else { BTreeSet::new() };
        let mut module = Module { language, routines, data, head_end: 0, first: None, own_data, uncalled };
        let mut units = Units::new(source, language);
        let mut found: Vec<Routine> = Vec::new();
        while let Some(unit) = units.next()? {
            let word = first_word(source, &unit, language);
            if matches!(word.as_str(), "PROC" | "FUNC" | "TRAP") && has_code_behind(&source[unit.at.clone()], &word) {
                return Err(refuse(&unit, CODE_BEHIND));
            }
            match word.as_str() {
                "MODULE" => module.head_end = unit.at.end,
                kind @ ("PROC" | "FUNC" | "TRAP") => found.push(read_routine(source, length, unit, kind, &mut units)?),
                kind @ ("DEF" | "DEFFCT") if language == Language::Krl => {
                    if found.is_empty() {
                        module.head_end = end_of_line(source, unit.at.end);
                    }
                    let kind = if kind == "DEF" { "PROC" } else { "FUNC" };
                    found.push(read_routine(source, length, unit, kind, &mut units)?);
                }
                word if language == Language::Krl && word != ";" && unit.at.start < length => {
                    return Err(refuse(&unit, RobotFault::Form { expected: "DEF before it" }));
                }
                _ if unit.is_statement => module.data.push(unit),
                _ => {}
            }
        }
        let moving = moving(source, &found, language, is_motion);
        let mattering = self::moving(source, &found, language, matters_to_motions);
        module.first = found.first().map(|routine| routine.name.clone());
        for mut routine in found {
            routine.moves = moving.contains(&routine.name);
            routine.matters = mattering.contains(&routine.name);
            let (line, at) = (routine.head.line, routine.head.at.clone());
            if module.routines.insert(routine.name.clone(), Rc::new(routine)).is_some() {
                let fault = RobotFault::Form { expected: "each routine once" };
                return Err(LocatedFault { line, at, fault });
            }
        }
        Ok(module)
    }

    /// Returns the routine that runs first: `main`, or the only procedure with motions that no other routine calls; the first one of KRL. `Err`
    /// if another one that moves the tool is not called.
    pub fn entry(&self, source: &[u8]) -> Result<Rc<Routine>, LocatedFault> {
        let mut called = BTreeSet::new();
        for routine in self.routines.values() {
            let names = names_of(&source[routine.inside.clone()], self.language);
            called.extend(names.filter(|name| *name != routine.name));
        }
        let is_first = |routine: &Routine| match self.language {
            Language::Krl => self.first.as_ref() == Some(&routine.name),
            _ => routine.name == "MAIN",
        };
        let is_run = |routine: &&Rc<Routine>| routine.moves && !self.uncalled.contains(&routine.name);
        let mut first: Vec<_> = self.routines.values().filter(is_run).collect();
        first.retain(|routine| is_first(routine) || !called.contains(&routine.name));
        first.sort_by_key(|routine| (!is_first(routine), routine.head.line));
        let refuse =
            |routine: &Routine, fault| LocatedFault { line: routine.head.line, at: routine.head.at.clone(), fault };
        // Where a function is called in an expression, its motions would be lost.
        if let Some(function) = self.routines.values().find(|routine| routine.kind == "FUNC" && is_run(routine)) {
            return Err(refuse(function, MOTION_IN_FUNCTION));
        }
        match first[..] {
            [] => {
                let fault = RobotFault::Form { expected: "a procedure with motions that no other calls" };
                let any = self.routines.values().next();
                Err(any
                    .map_or(LocatedFault { line: 1, at: 0..0, fault: fault.clone() }, |routine| refuse(routine, fault)))
            }
            [only] if self.language == Language::Krl && !is_first(only) => {
                let first = self.first.as_ref().and_then(|name| self.routines.get(name));
                let first = first.map_or(1, |routine| routine.head.line);
                Err(refuse(only, RobotFault::Uncalled { first }))
            }
            [only] if only.kind == "PROC" && only.parameters.is_empty() => Ok(Rc::clone(only)),
            [only] => Err(refuse(only, RobotFault::Form { expected: "a procedure without parameters that calls it" })),
            [one, other, ..] => Err(refuse(other, RobotFault::Uncalled { first: one.head.line })),
        }
    }
}

/// Returns the first word of a unit in capitals, without LOCAL.
fn first_word(source: &[u8], unit: &CodeUnit, language: Language) -> String {
    match unit.word.as_str() {
        "LOCAL" if !unit.is_statement => names_of(&source[unit.at.clone()], language).nth(1).unwrap_or_default(),
        word => word.to_owned(),
    }
}

/// Reads a routine that begins at `head` up to its end.
fn read_routine(
    source: &[u8],
    length: usize,
    head: CodeUnit,
    kind: &str,
    units: &mut Units<'_>,
) -> Result<Routine, LocatedFault> {
    let (name, parameters) = signature(source, &head, kind).map_err(|fault| refuse(&head, fault))?;
    let from = end_of_line(source, head.at.end);
    let mut inside = from..from;
    let mut handles_errors = false;
    // Blocks that are open, and what stands in the innermost arm.
    let mut open: Vec<Block> = Vec::new();
    let mut body = Vec::new();
    loop {
        let Some(unit) = units.next()? else {
            return Err(refuse(&head, RobotFault::Form { expected: "the end of the routine" }));
        };
        let word = if unit.is_statement { "" } else { unit.word.as_str() };
        let is_end = matches!(word, "ENDPROC" | "ENDFUNC" | "ENDTRAP" | "END" | "ENDFCT");
        if (is_end || matches!(word, "ERROR" | "UNDO" | "BACKWARD")) && !handles_errors {
            inside.end = unit.at.start;
        }
        match word {
            _ if is_end => {
                if let Some(block) = open.first() {
                    return Err(refuse(block.head(), RobotFault::Form { expected: "the end of the branch or loop" }));
                }
                if unit.at.start >= length {
                    return Err(refuse(&head, RobotFault::Form { expected: "the end of the routine" }));
                }
                let end = if word == "END" { end_of_line(source, unit.at.end) } else { unit.at.end };
                let (kind, moves, matters) = (kind.to_owned(), false, false);
                return Ok(Routine { name, kind, head, parameters, body, inside, end, handles_errors, moves, matters });
            }
            "ERROR" | "UNDO" | "BACKWARD" => handles_errors = true,
            _ if handles_errors => {}
            "DEF" | "DEFFCT" => {
                return Err(refuse(&head, RobotFault::Form { expected: "the end of the routine" }));
            }
            "TEST" if has_code_behind(&source[unit.at.clone()], word) => return Err(refuse(&unit, CODE_BEHIND)),
            "IF" | "FOR" | "WHILE" | "TEST" | "LOOP" | "REPEAT" | "SWITCH" => {
                check_depth(&source[unit.at.clone()], open.len() + 1).map_err(|fault| refuse(&unit, fault))?;
                open.push(Block { at: unit.at.clone(), arms: vec![(unit, Vec::new())] });
            }
            "ELSEIF" | "ELSE" | "CASE" | "DEFAULT" => match open.last_mut() {
                Some(block) => block.arms.push((unit, Vec::new())),
                None => return Err(refuse(&unit, RobotFault::Form { expected: "IF, TEST or SWITCH before it" })),
            },
            "ENDIF" | "ENDFOR" | "ENDWHILE" | "ENDTEST" | "ENDLOOP" | "ENDSWITCH" | "UNTIL" => match open.pop() {
                Some(mut block)
                    if word[3..] == block.head().word || block.head().word == "REPEAT" && word == "UNTIL" =>
                {
                    block.at.end = unit.at.end;
                    if word == "UNTIL" {
                        block.arms.push((unit, Vec::new()));
                    }
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
fn refuse(unit: &CodeUnit, fault: RobotFault) -> LocatedFault {
    LocatedFault { line: unit.line, at: unit.at.clone(), fault }
}

/// Reads name and parameters of a routine: `PROC slot(robtarget start,VAR num n\num depth)`, `DEF slot(start:IN,n[]:OUT)`.
fn signature(source: &[u8], head: &CodeUnit, kind: &str) -> Result<(String, Vec<Parameter>), RobotFault> {
    const EXPECTED: RobotFault =
        RobotFault::Form { expected: "the name of the routine and its parameters in brackets" };
    let text = String::from_utf8_lossy(&source[head.at.clone()]).to_ascii_uppercase();
    let text = text.split('!').next().unwrap_or_default();
    let (before, inside) = match text.split_once('(') {
        Some((before, inside)) => (before, inside.split_once(')').ok_or(EXPECTED)?.0),
        None => (text, ""),
    };
    let name = before.split_whitespace().last().filter(|name| ![kind, "DEF", "DEFFCT"].contains(name));
    let name = name.ok_or(EXPECTED)?.to_owned();
    let is_krl = matches!(head.word.as_str(), "DEF" | "DEFFCT");
    let mut parameters = Vec::new();
    for part in inside.split(',') {
        for (k, text) in part.split('\\').enumerate() {
            let text = text.replace("{*}", " ");
            let words: Vec<&str> = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
            let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
            let Some(name) = (if is_krl { words.first() } else { words.last() }) else { continue };
            let is_reference = match is_krl {
                true => words.get(1) != Some(&"IN"),
                false => matches!(words[0], "VAR" | "INOUT" | "PERS" | "REF"),
            };
            parameters.push(Parameter { name: (*name).to_owned(), is_optional: k > 0, is_reference });
        }
    }
    Ok((name, parameters))
}

/// Returns the names of the routines with words that `moves` tells, and of those that call them.
fn moving(
    source: &[u8],
    routines: &[Routine],
    language: Language,
    moves: fn(&str, Language) -> bool,
) -> BTreeSet<String> {
    let names =
        |routine: &Routine| -> BTreeSet<String> { names_of(&source[routine.inside.clone()], language).collect() };
    let own: BTreeSet<&String> = routines.iter().map(|routine| &routine.name).collect();
    // By name, the routines that call it.
    let (mut callers, mut next) = (BTreeMap::<String, Vec<&String>>::new(), Vec::new());
    for routine in routines {
        for name in names(routine) {
            match own.contains(&name) {
                true => callers.entry(name).or_default().push(&routine.name),
                false => next.extend(moves(&name, language).then_some(&routine.name)),
            }
        }
    }
    let mut moving = BTreeSet::new();
    while let Some(name) = next.pop() {
        if moving.insert(name.clone()) {
            next.extend(callers.get(name).into_iter().flatten());
        }
    }
    moving
}

/// Returns where the line of byte `at` ends.
fn end_of_line(source: &[u8], at: usize) -> usize {
    let rest = &source[at..];
    at + rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')).unwrap_or(rest.len())
}

/// Splits `IF condition statement;`: the ranges of both in the source.
pub(crate) fn one_line_if(source: &[u8], unit: &CodeUnit) -> Result<(Range<usize>, CodeUnit), RobotFault> {
    let from = unit.at.start + unit.word.len();
    let start = one_line_statement(&source[unit.at.clone()]);
    let start = unit.at.start + start.ok_or(RobotFault::Form { expected: "IF condition statement" })?;
    let mut scan = crate::read::scan::Scan::new(&source[start..unit.at.end]);
    let word = scan.name().0.to_ascii_uppercase();
    let line = unit.line + source[unit.at.start..start].iter().filter(|byte| **byte == b'\n').count();
    Ok((from..start, CodeUnit { at: start..unit.at.end, line, word, is_statement: true }))
}
