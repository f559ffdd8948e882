//! Names and plain numbers in statements of robot programs.

use std::ops::Range;

use crate::{
    model::robot::RobotFault,
    read::scan::{DEEPEST, Scan, bracket_depth},
};

/// Refuses a level `depth` of the statement `text` beyond [`DEEPEST`].
pub(crate) fn check_depth(text: &[u8], depth: usize) -> Result<(), RobotFault> {
    match depth > DEEPEST {
        true => Err(RobotFault::TooDeep { depth: bracket_depth(text).max(depth), most: DEEPEST }),
        false => Ok(()),
    }
}

/// Most digits of a number behind leading zeros: more than any control writes, of which 17 identify an `f64`.
const MAX_DIGITS: usize = 24;

impl<'a> Scan<'a> {
    /// Creates a cursor over a statement, in which line endings are blank.
    #[must_use]
    pub fn new(line: &'a [u8]) -> Self {
        Self { line, at: 0, is_blank: |byte| byte.is_ascii_whitespace() }
    }

    /// Skips blanks; returns whether nothing is left.
    pub fn is_done(&mut self) -> bool {
        self.next().is_none()
    }

    /// Skips blanks and takes `byte`. `Err` names what is `expected` if another byte comes next.
    pub fn expect(&mut self, byte: u8, expected: &'static str) -> Result<(), RobotFault> {
        if self.takes(byte) { Ok(()) } else { Err(RobotFault::Form { expected }) }
    }

    /// Skips blanks, takes a name of letters, digits, `_` and `$`, and returns it with its range; empty if there is none.
    pub fn name(&mut self) -> (&'a str, Range<usize>) {
        let start = self.skip_blanks().at;
        let is_of_name = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$');
        if self.peek().is_some_and(|byte| !byte.is_ascii_digit()) {
            self.take_while(is_of_name);
        }
        // The bytes are ASCII.
        (std::str::from_utf8(&self.line[start..self.at]).unwrap_or_default(), start..self.at)
    }

    /// Skips blanks, takes a plain number, and returns it with its range. `Err` if none comes next, or none that is finite.
    pub fn number(&mut self) -> Result<(f64, Range<usize>), RobotFault> {
        let fault = RobotFault::Form { expected: "a plain number" };
        let start = self.skip_blanks().at;
        let mut at = start + usize::from(matches!(self.peek(), Some(b'+' | b'-')));
        let digits = |mut at: usize| {
            while self.line.get(at).is_some_and(u8::is_ascii_digit) {
                at += 1;
            }
            at
        };
        let zeros = self.line[at.min(self.line.len())..]
            .iter()
            .take_while(|byte| matches!(byte, b'0' | b'.'))
            .filter(|byte| **byte == b'0')
            .count();
        let whole = at;
        at = digits(at);
        let mut count = at - whole;
        if self.line.get(at) == Some(&b'.') {
            let end = digits(at + 1);
            count += end - at - 1;
            at = end;
        }
        if count == 0 || count > MAX_DIGITS + zeros {
            return Err(fault);
        }
        if matches!(self.line.get(at), Some(b'e' | b'E')) {
            let sign = at + 1 + usize::from(matches!(self.line.get(at + 1), Some(b'+' | b'-')));
            let end = digits(sign);
            if end > sign {
                at = end;
            }
        }
        let text = std::str::from_utf8(&self.line[start..at]).unwrap_or_default();
        let value = text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or(fault)?;
        self.at = at;
        Ok((value, start..at))
    }

    /// Whether an operator comes next, so that what was read is only part of an expression.
    pub fn is_in_expression(&mut self) -> bool {
        matches!(self.next(), Some(b'+' | b'-' | b'*' | b'/' | b':'))
    }
}
