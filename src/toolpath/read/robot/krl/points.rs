//! Points and frames that a `.src` or the `.dat` beside it declares or assigns.

use std::{collections::HashMap, ops::Range};

use crate::toolpath::{
    model::robot::RobotFault,
    read::{
        robot::{LineCursor, krl::frame, trimmed},
        scan::Scan,
    },
};

/// What a name stands for.
#[derive(Clone, Debug)]
enum Value {
    /// What stands in these bytes of the `.src`, or of the file beside it.
    Written { beside: bool, at: Range<usize> },
    /// What nobody but the controller knows, from this line on.
    Computed(usize),
}

/// Names and what they stand for.
#[derive(Debug)]
pub(crate) struct Points<'a> {
    source: &'a [u8],
    beside: Option<(&'a str, &'a [u8])>,
    /// By names in capitals, indices as they are written: `XP1`, `XP[3]`.
    values: HashMap<String, Value>,
}

impl<'a> Points<'a> {
    pub fn new(source: &'a [u8], beside: Option<(&'a str, &'a [u8])>) -> Self {
        let mut points = Self { source, beside, values: HashMap::new() };
        let Some((_, bytes)) = beside else { return points };
        let mut lines = LineCursor::new(bytes);
        while let Some(line) = lines.advance() {
            let code = super::code(bytes, line);
            if let Some((name, value)) = declared(bytes, code) {
                points.values.insert(name, Value::Written { beside: true, at: value });
            }
        }
        points
    }

    /// Takes a declaration of the `.src`, in the bytes `code`.
    pub fn declare(&mut self, code: Range<usize>, line: usize) {
        if let Some((name, at)) = declared(self.source, code.clone()) {
            self.values.insert(name, Value::Written { beside: false, at });
        } else if let Some((name, value)) = named(self.source, code) {
            // Without a value it is not known until one is assigned.
            match value.is_empty() {
                true => drop(self.values.remove(&name)),
                false => drop(self.values.insert(name, Value::Computed(line))),
            }
        }
    }

    /// Takes an assignment of what stands in the bytes `value` to `name`, in line `line`.
    pub fn assign(&mut self, name: String, value: Range<usize>, line: usize, runs_once: bool) {
        // Of `XP1.Z` and `XP[I]` it is not known what is left of XP1 and XP.
        let end = name.find(['.', '[']).unwrap_or(name.len());
        let (root, rest) = name.split_at(end);
        let is_whole =
            rest.is_empty() || (rest.ends_with(']') && rest[1..rest.len() - 1].bytes().all(|b| b.is_ascii_digit()));
        let entry = match is_whole && runs_once && is_in_braces(&self.source[value.clone()]) {
            true => Value::Written { beside: false, at: value },
            false => Value::Computed(line),
        };
        let key = if is_whole { name.clone() } else { root.to_owned() };
        self.values.insert(key, entry);
    }

    /// The text in braces that `name` (capitals) stands for, if it is known at all.
    pub fn find(&self, name: &str) -> Result<Option<&'a [u8]>, RobotFault> {
        let root = &name[..name.find('[').unwrap_or(name.len())];
        let computed = |line: usize| RobotFault::Computed { name: name.to_owned(), line };
        if root != name
            && let Some(Value::Computed(line)) = self.values.get(root)
        {
            return Err(computed(*line));
        }
        match self.values.get(name) {
            None => Ok(None),
            Some(Value::Computed(line)) => Err(computed(*line)),
            Some(Value::Written { beside: false, at }) => Ok(Some(&self.source[at.clone()])),
            Some(Value::Written { at, .. }) => Ok(self.beside.map(|(_, bytes)| &bytes[at.clone()])),
        }
    }

    /// That there is no point `name`.
    pub fn missing(&self, name: &str) -> RobotFault {
        let beside = self.beside.map_or_else(
            || " (there is no .dat beside it)".to_owned(),
            |(beside, _)| format!(" or beside it in {beside}"),
        );
        RobotFault::NoPoint { name: name.to_owned(), beside }
    }
}

/// The name that a declaration declares or an assignment assigns, and the bytes behind its `=`.
fn named(source: &[u8], code: Range<usize>) -> Option<(String, Range<usize>)> {
    let text = &source[code.clone()];
    let equals = text.iter().position(|byte| *byte == b'=').unwrap_or(text.len());
    let value = (code.start + equals + 1).min(code.end)..code.end;
    // The name is the last word before it, with its index.
    let before = String::from_utf8_lossy(text[..equals].trim_ascii_end()).to_ascii_uppercase();
    let (words, index) = match before.strip_suffix(']').and_then(|before| before.rsplit_once('[')) {
        Some((words, index)) => (words.trim_end().to_owned(), format!("[{}]", index.replace(' ', ""))),
        None => (before, String::new()),
    };
    let name = words.rsplit([' ', '\t', ',']).next().filter(|name| !name.is_empty())?;
    // Without value, the size of an array is no index.
    let index = if value.is_empty() { String::new() } else { index };
    Some((format!("{name}{index}"), value))
}

/// The same where the value stands in braces, with the bytes of the braces.
fn declared(source: &[u8], code: Range<usize>) -> Option<(String, Range<usize>)> {
    let (name, value) = named(source, code)?;
    let value = trimmed(source, value);
    is_in_braces(&source[value.clone()]).then_some((name, value))
}

/// Whether `text` is one value in braces.
fn is_in_braces(text: &[u8]) -> bool {
    text.starts_with(b"{") && frame::braces(&mut Scan::new(text), text).is_ok_and(|braces| braces.end == text.len())
}
