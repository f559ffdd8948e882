//! Letters, numbers and brackets in lines of dialects.

use std::ops::Range;

use crate::{
    model::gcode::{Fault, Foreign, Refusal},
    read::{gcode::lines::is_blank, scan::Scan},
};

impl<'a> Scan<'a> {
    /// Creates a cursor over `line` from byte `at` on, without the comment behind a `;` outside quotes.
    pub fn of_line(line: &'a [u8], at: usize) -> Scan<'a> {
        let mut quoted = false;
        let comment = line.iter().position(|byte| {
            quoted ^= *byte == b'"';
            *byte == b';' && !quoted
        });
        let end = comment.unwrap_or(line.len());
        Scan { line: &line[..end], at: at.min(end), is_blank }
    }

    /// Takes letters, and returns them in upper case.
    pub fn take_letters(&mut self) -> String {
        let range = self.take_while(|byte| byte.is_ascii_alphabetic());
        self.upper_text(range)
    }

    /// Returns the text in the bytes `range`, in upper case.
    pub fn upper_text(&self, range: Range<usize>) -> String {
        String::from_utf8_lossy(&self.line[range]).to_ascii_uppercase()
    }

    /// Takes a number (sign, digits, a point or comma) and returns it with its range; `None` if none comes next, `Err` for too many digits.
    pub fn take_decimal(&mut self) -> Result<Option<(f64, Range<usize>)>, Refusal> {
        let start = self.at;
        let mut probe = *self;
        if matches!(probe.peek(), Some(b'+' | b'-')) {
            probe.at += 1;
        }
        let whole = probe.take_while(|byte| byte.is_ascii_digit());
        let mut fraction = 0..0;
        if matches!(probe.peek(), Some(b'.' | b',')) {
            probe.at += 1;
            fraction = probe.take_while(|byte| byte.is_ascii_digit());
        }
        if whole.is_empty() && fraction.is_empty() {
            return Ok(None);
        }
        for digits in [whole, fraction] {
            if digits.len() > Fault::MAX_DIGITS {
                return Err(Refusal::new(digits.clone(), Fault::TooManyDigits { digits: digits.len() }));
            }
        }
        let text = self.upper_text(start..probe.at).replace(',', ".");
        self.at = probe.at;
        Ok(text.parse().ok().map(|value| (value, start..probe.at)))
    }

    /// Skips a string or bracket that begins here, up to what closes it; brackets may hold strings and brackets.
    pub fn skip_closed(&mut self, open: u8, close: u8) -> Result<(), Refusal> {
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

    /// Returns a refusal with `fault` of the text from byte `start` up to the next blank.
    pub fn refuse(&self, start: usize, fault: impl Into<Fault>) -> Refusal {
        let rest = &self.line[start..];
        let length = rest.iter().position(|byte| is_blank(*byte)).unwrap_or(rest.len());
        Refusal::new(start..start + length, fault.into())
    }

    /// Returns a refusal with `fault` of the whole rest of the line from byte `start`.
    pub fn refuse_all(&self, start: usize, fault: impl Into<Fault>) -> Refusal {
        let length = self.line[start..].trim_ascii_end().len();
        Refusal::new(start..start + length, fault.into())
    }
}

impl From<Foreign> for Fault {
    /// Wraps a refused statement as a fault.
    fn from(foreign: Foreign) -> Fault {
        Fault::Foreign(foreign)
    }
}
