//! A line read from left to right.

use std::ops::Range;

use crate::toolpath::{
    model::gcode::{Fault, Foreign, Refusal},
    read::gcode::lines::is_blank,
};

/// A line, and how far it has been read.
#[derive(Clone, Copy)]
pub(crate) struct Scan<'a> {
    /// Without its comment.
    pub line: &'a [u8],
    pub at: usize,
}

impl<'a> Scan<'a> {
    /// `line` from `at` on, as far as a comment behind `;`, which does not begin within quotes.
    pub fn new(line: &'a [u8], at: usize) -> Scan<'a> {
        let mut quoted = false;
        let comment = line.iter().position(|byte| {
            quoted ^= *byte == b'"';
            *byte == b';' && !quoted
        });
        let end = comment.unwrap_or(line.len());
        Scan { line: &line[..end], at: at.min(end) }
    }

    /// The next byte.
    pub fn peek(&self) -> Option<u8> {
        self.line.get(self.at).copied()
    }

    /// The next byte that is no blank.
    pub fn next(&mut self) -> Option<u8> {
        while self.peek().is_some_and(is_blank) {
            self.at += 1;
        }
        self.peek()
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

    /// Steps over letters and gives them in upper case.
    pub fn letters(&mut self) -> String {
        let range = self.run(|byte| byte.is_ascii_alphabetic());
        self.upper(range)
    }

    /// What stands in `range`, in upper case.
    pub fn upper(&self, range: Range<usize>) -> String {
        String::from_utf8_lossy(&self.line[range]).to_ascii_uppercase()
    }

    /// Steps over a number and gives it with its place: sign, digits, and a point or a comma among them. Where none comes next,
    /// nothing is read.
    pub fn number(&mut self) -> Result<Option<(f64, Range<usize>)>, Refusal> {
        let start = self.at;
        let mut probe = *self;
        if matches!(probe.peek(), Some(b'+' | b'-')) {
            probe.at += 1;
        }
        let whole = probe.run(|byte| byte.is_ascii_digit());
        let mut fraction = 0..0;
        if matches!(probe.peek(), Some(b'.' | b',')) {
            probe.at += 1;
            fraction = probe.run(|byte| byte.is_ascii_digit());
        }
        if whole.is_empty() && fraction.is_empty() {
            return Ok(None);
        }
        for digits in [whole, fraction] {
            if digits.len() > Fault::MAX_DIGITS {
                return Err(Refusal::new(digits.clone(), Fault::TooManyDigits { digits: digits.len() }));
            }
        }
        let text = self.upper(start..probe.at).replace(',', ".");
        self.at = probe.at;
        Ok(text.parse().ok().map(|value| (value, start..probe.at)))
    }

    /// Steps over a string or a bracket that begins here, as far as what closes it; brackets may hold strings and brackets.
    pub fn closed(&mut self, open: u8, close: u8) -> Result<(), Refusal> {
        let (start, mut depth, mut quoted) = (self.at, 0usize, false);
        while let Some(byte) = self.peek() {
            self.at += 1;
            if byte == b'"' && open != b'"' {
                quoted = !quoted;
            } else if byte == close && !quoted && (open != close || depth == 1) {
                depth -= 1;
                if depth == 0 {
                    return Ok(());
                }
            } else if byte == open && !quoted {
                depth += 1;
            }
        }
        let fault = Fault::Foreign(Foreign::NotClosed { close: char::from(close) });
        Err(Refusal::new(start..self.line.len(), fault))
    }

    /// `fault` at the text from `start` as far as the next blank.
    pub fn refuse(&self, start: usize, fault: impl Into<Fault>) -> Refusal {
        let rest = &self.line[start..];
        let length = rest.iter().position(|byte| is_blank(*byte)).unwrap_or(rest.len());
        Refusal::new(start..start + length, fault.into())
    }

    /// `fault` at the whole rest from `start`.
    pub fn refuse_all(&self, start: usize, fault: impl Into<Fault>) -> Refusal {
        let length = self.line[start..].trim_ascii_end().len();
        Refusal::new(start..start + length, fault.into())
    }
}

impl From<Foreign> for Fault {
    fn from(foreign: Foreign) -> Fault {
        Fault::Foreign(foreign)
    }
}
