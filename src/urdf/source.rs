//! The URDF's text as messages name it: file, line, joint or link, and what was written there.

use crate::input::error::{Error, Result};

/// Longest piece of a file that is quoted, characters.
const QUOTED: usize = 80;

/// A text and the name of the file it is from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source<'a> {
    pub origin: &'a str,
    pub text: &'a str,
}

impl Source<'_> {
    /// The error that something is wrong at byte `at`, in `place`, such as `joint "a"`.
    pub fn fail<T>(&self, at: usize, place: String, problem: String) -> Result<T> {
        let line = 1 + self.text.bytes().take(at).filter(|&byte| byte == b'\n').count();
        Err(Error::Syntax { file: self.origin.into(), line: Some(line), key: place, problem })
    }

    /// The error that something is wrong with the file as a whole.
    pub fn fail_everywhere<T>(&self, problem: String) -> Result<T> {
        Err(Error::Syntax { file: self.origin.into(), line: None, key: String::new(), problem })
    }
}

/// Part of a file on one line in quotation marks, what cannot be read written out, its end left off if it is long.
pub(super) fn quoted(text: &str) -> String {
    let mut begin: String = text.chars().take(QUOTED).collect();
    if begin.len() < text.len() {
        begin.push('…');
    }
    format!("{begin:?}")
}

/// Names in quotation marks.
pub(super) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    names.into_iter().map(quoted).collect::<Vec<_>>().join(", ")
}

/// `name` in the characters that names in machine files may have, the rest as underscores.
pub(super) fn identifier(name: &str) -> String {
    const LONGEST: usize = 60;
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    name.chars().take(LONGEST).map(plain).collect()
}
