//! Points and frames that a KRL program or the `.dat` beside it declares or assigns.

use std::{
    collections::{HashMap, HashSet},
    ops::Range,
};

use crate::{
    model::robot::RobotFault,
    read::{
        robot::{LineCursor, krl::frame, trimmed},
        scan::Scan,
    },
};

/// Value of a variable.
#[derive(Clone, Debug)]
enum Value {
    /// The text in these bytes of the `.src` (`None`), or of a file beside it.
    Written { beside: Option<usize>, at: Range<usize> },
    /// Unknown to the reader since this line.
    Computed(usize),
}

/// Variables and their values.
#[derive(Debug)]
pub(crate) struct Points<'a> {
    source: &'a [u8],
    beside: &'a [(String, Vec<u8>)],
    /// By name in upper case, with the index as written: `XP1`, `XP[3]`.
    values: HashMap<String, Value>,
}

impl<'a> Points<'a> {
    /// Starts with the declarations of the `.dat`, and with the tools and bases of `$config.dat` that it does not have (`beside`).
    pub fn new(source: &'a [u8], beside: &'a [(String, Vec<u8>)]) -> Self {
        let mut points = Self { source, beside, values: HashMap::new() };
        let (of_all, own): (Vec<_>, Vec<_>) = beside.iter().enumerate().partition(|(_, (name, _))| is_config(name));
        for (file, (name, bytes)) in of_all.into_iter().chain(own) {
            let mut lines = LineCursor::new(bytes);
            while let Some(line) = lines.advance() {
                let code = super::code_range(bytes, line);
                let found = name_and_braces(bytes, code);
                let is_read = |name: &str| name.starts_with("TOOL_DATA[") || name.starts_with("BASE_DATA[");
                if let Some((name, at)) = found.filter(|(found, _)| !is_config(name) || is_read(found)) {
                    points.values.insert(name, Value::Written { beside: Some(file), at });
                }
            }
        }
        points.forget_assigned();
        points
    }

    /// Makes data of the `.dat` unknown that the program assigns anywhere: they keep what the last run has left.
    fn forget_assigned(&mut self) {
        let root_of = |name: &String| name[..name.find('[').unwrap_or(name.len())].to_owned();
        let roots: HashSet<String> = self.values.keys().map(root_of).collect();
        let mut lines = LineCursor::new(self.source);
        while let Some(line) = lines.advance() {
            let code = super::code_range(self.source, line);
            let mut scan = Scan::new(&self.source[code]);
            let Ok(name) = super::state::variable_name(&mut scan) else { continue };
            if !scan.takes(b'=') || scan.peek() == Some(b'=') {
                continue;
            }
            let root = &name[..name.find(['.', '[']).unwrap_or(name.len())];
            let is_assigned = |known: &String| {
                *known == name || known == root || known.strip_prefix(root).is_some_and(|rest| rest.starts_with('['))
            };
            if !roots.contains(root) {
                continue;
            }
            let of_element =
                name.ends_with(']') && name[root.len() + 1..name.len() - 1].bytes().all(|own| own.is_ascii_digit());
            for (known, value) in &mut self.values {
                if (of_element && *known == name) || (!of_element && is_assigned(known)) {
                    *value = Value::Computed(lines.line);
                }
            }
        }
    }

    /// Adds the declaration in the bytes `code` of the `.src`, on line `line`.
    pub fn declare(&mut self, code: Range<usize>, line: usize) {
        if let Some((name, at)) = name_and_braces(self.source, code.clone()) {
            self.values.insert(name, Value::Written { beside: None, at });
        } else if let Some((name, value)) = name_and_value(self.source, code) {
            // Without a value it is not known until one is assigned.
            match value.is_empty() {
                true => drop(self.values.remove(&name)),
                false => drop(self.values.insert(name, Value::Computed(line))),
            }
        }
    }

    /// Adds the assignment of the bytes `value` to `name` on line `line`; unless it `runs_once`, the value counts as computed.
    pub fn assign(&mut self, name: String, value: Range<usize>, line: usize, runs_once: bool) {
        // Of `XP1.Z` and `XP[I]` it is not known what is left of XP1 and XP.
        let end = name.find(['.', '[']).unwrap_or(name.len());
        let (root, rest) = name.split_at(end);
        let is_whole =
            rest.is_empty() || (rest.ends_with(']') && rest[1..rest.len() - 1].bytes().all(|b| b.is_ascii_digit()));
        let entry = match is_whole && runs_once && is_in_braces(&self.source[value.clone()]) {
            true => Value::Written { beside: None, at: value },
            false => Value::Computed(line),
        };
        let key = if is_whole { name.clone() } else { root.to_owned() };
        self.values.insert(key, entry);
    }

    /// Returns the text in braces that `name` (upper case) stands for; `None` if it is not declared, `Err` if it is computed.
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
            Some(Value::Written { beside: None, at }) => Ok(Some(&self.source[at.clone()])),
            Some(Value::Written { beside: Some(file), at }) => {
                Ok(self.beside.get(*file).map(|(_, bytes)| &bytes[at.clone()]))
            }
        }
    }

    /// Returns the fault that there is no point `name`, in the file or the `.dat` beside it.
    pub fn missing_point(&self, name: &str) -> RobotFault {
        let own = self.beside.iter().find(|(name, _)| !is_config(name));
        let beside = own.map_or_else(
            || " (there is no .dat beside it)".to_owned(),
            |(beside, _)| format!(" or beside it in {beside}"),
        );
        RobotFault::NoPoint { name: name.to_owned(), beside }
    }
}

/// Whether the file `name` is the one with the tools and bases of all programs.
pub(crate) fn is_config(name: &str) -> bool {
    name.rsplit('/').next().is_some_and(|name| name.eq_ignore_ascii_case("$config.dat"))
}

/// Returns the name in a declaration or assignment, and the bytes behind its `=`, which may be none; `None` without a name.
fn name_and_value(source: &[u8], code: Range<usize>) -> Option<(String, Range<usize>)> {
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

/// Returns the name that a declaration or assignment gives a value in braces, and the bytes of the braces; `None` for other values.
fn name_and_braces(source: &[u8], code: Range<usize>) -> Option<(String, Range<usize>)> {
    let (name, value) = name_and_value(source, code)?;
    let value = trimmed(source, value);
    is_in_braces(&source[value.clone()]).then_some((name, value))
}

/// Whether `text` is a single value in braces.
fn is_in_braces(text: &[u8]) -> bool {
    text.starts_with(b"{") && frame::brace_span(&mut Scan::new(text), text).is_ok_and(|braces| braces.end == text.len())
}
