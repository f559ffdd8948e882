//! A text read from left to right.

use std::ops::Range;

/// A text, and how far it has been read.
#[derive(Clone, Copy, Debug)]
pub struct Scan<'a> {
    /// The text, of a line without its comment.
    pub line: &'a [u8],
    /// Where the next byte is.
    pub at: usize,
    /// Which bytes are blank.
    pub is_blank: fn(u8) -> bool,
}

impl<'a> Scan<'a> {
    /// The next byte.
    #[must_use]
    pub fn peek(&self) -> Option<u8> {
        self.line.get(self.at).copied()
    }

    /// Skips blanks.
    pub fn blanks(&mut self) -> &mut Self {
        self.run(self.is_blank);
        self
    }

    /// The next byte that is no blank.
    pub(crate) fn next(&mut self) -> Option<u8> {
        self.blanks().peek()
    }

    /// Steps over `byte`, blanks before it as well, if it comes next.
    pub fn takes(&mut self, byte: u8) -> bool {
        let found = self.next() == Some(byte);
        self.at += usize::from(found);
        found
    }

    /// Steps over the bytes that pass `test`.
    pub fn run(&mut self, test: impl Fn(u8) -> bool) -> Range<usize> {
        let start = self.at;
        while self.peek().is_some_and(&test) {
            self.at += 1;
        }
        start..self.at
    }

    /// What is left.
    #[must_use]
    pub fn rest(&self) -> &'a [u8] {
        &self.line[self.at..]
    }
}
