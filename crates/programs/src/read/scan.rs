//! A cursor over the bytes of a line or statement.

use std::ops::Range;

/// A cursor over the bytes of a line or statement.
#[derive(Clone, Copy, Debug)]
pub struct Scan<'a> {
    /// The text, without its comment.
    pub line: &'a [u8],
    /// Index of the next byte.
    pub at: usize,
    /// Which bytes are blank.
    pub is_blank: fn(u8) -> bool,
}

impl<'a> Scan<'a> {
    /// Returns the next byte, blank or not; `None` at the end.
    #[must_use]
    pub fn peek(&self) -> Option<u8> {
        self.line.get(self.at).copied()
    }

    /// Skips blanks.
    pub fn skip_blanks(&mut self) -> &mut Self {
        self.take_while(self.is_blank);
        self
    }

    /// Skips blanks and returns the next byte without taking it; `None` at the end.
    pub(crate) fn next(&mut self) -> Option<u8> {
        self.skip_blanks().peek()
    }

    /// Skips blanks and takes `byte` if it comes next; returns whether it did.
    pub fn takes(&mut self, byte: u8) -> bool {
        let found = self.next() == Some(byte);
        self.at += usize::from(found);
        found
    }

    /// Takes the bytes that pass `test`, and returns their range.
    pub fn take_while(&mut self, test: impl Fn(u8) -> bool) -> Range<usize> {
        let start = self.at;
        while self.peek().is_some_and(&test) {
            self.at += 1;
        }
        start..self.at
    }

    /// Returns the bytes that are not taken yet.
    #[must_use]
    pub fn rest(&self) -> &'a [u8] {
        &self.line[self.at..]
    }

    /// Returns the name that ends `text`, but for blanks; empty if none does.
    pub(crate) fn name_before(text: &[u8]) -> &str {
        let text = text.trim_ascii_end();
        let is_of_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let start = text.iter().rposition(|byte| !is_of_name(byte)).map_or(0, |at| at + 1);
        std::str::from_utf8(&text[start..]).unwrap_or_default()
    }
}

/// Most levels of brackets, signs, branches and data in one another that are followed.
pub(crate) const DEEPEST: usize = 64;

/// Returns how many levels of brackets stand in one another in `text`.
pub(crate) fn bracket_depth(text: &[u8]) -> usize {
    let (mut depth, mut most) = (0usize, 0);
    for byte in text {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        most = most.max(depth);
    }
    most
}
