//! The URDF's text, the errors that quote it (file, line, joint or link, and what is written there), and notes that name its things.

use crate::input::error::{Error, Result};

/// Longest piece of a file that is quoted, characters.
const QUOTED: usize = 80;

/// The text of a URDF and the name of its file in messages.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source<'a> {
    pub origin: &'a str,
    pub text: &'a str,
}

impl Source<'_> {
    /// Returns `Err` with `problem`, at the line of byte `at`, about `place`, such as `joint "a"`.
    pub fn fail<T>(&self, at: usize, place: String, problem: String) -> Result<T> {
        let line = 1 + self.text.bytes().take(at).filter(|&byte| byte == b'\n').count();
        Err(Error::Syntax { file: self.origin.into(), line: Some(line), key: place, problem })
    }

    /// Returns `Err` with `problem` about the file as a whole, without a line.
    pub fn fail_whole_file<T>(&self, problem: String) -> Result<T> {
        Err(Error::Syntax { file: self.origin.into(), line: None, key: String::new(), problem })
    }
}

/// Quotes a text on one line, with unprintable characters escaped and its end cut off if it is long.
pub(super) fn quoted(text: &str) -> String {
    let mut begin: String = text.chars().take(QUOTED).collect();
    if begin.len() < text.len() {
        begin.push('…');
    }
    format!("{begin:?}")
}

/// Joins names, each in quotation marks, by commas.
pub(super) fn quoted_list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    names.into_iter().map(quoted).collect::<Vec<_>>().join(", ")
}

/// Adds a note that says `what` about the things called `names`, if there are any.
pub(super) fn note_names<'a>(notes: &mut Vec<String>, what: &str, names: impl IntoIterator<Item = &'a str>) {
    let names = quoted_list(names);
    if !names.is_empty() {
        notes.push(format!("{what}: {names}"));
    }
}

/// Converts a name to the characters that machine files permit, others to underscores, at most 60.
pub(super) fn identifier(name: &str) -> String {
    const LONGEST: usize = 60;
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    name.chars().take(LONGEST).map(plain).collect()
}
