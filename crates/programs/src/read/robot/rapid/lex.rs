//! Splits a RAPID module into units: statements up to their `;`, and words of structure.

use std::ops::Range;

use crate::{
    model::robot::RobotFault,
    read::{robot::LocatedFault, scan::Scan},
};

/// A statement, or a word of structure that opens or closes a part of a module.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CodeUnit {
    /// Bytes of the source, with the `;`.
    pub at: Range<usize>,
    /// Line on which it begins, from 1.
    pub line: usize,
    /// First word in upper case; empty if there is none.
    pub word: String,
    /// Whether it is a statement, which ends in `;`.
    pub is_statement: bool,
}

impl CodeUnit {
    /// Returns the bytes behind its first word, without what ends it.
    pub fn inside(&self, source: &[u8]) -> Range<usize> {
        let start = (self.at.start + self.word.len()).min(self.at.end);
        let is_ended = matches!(source[start..self.at.end].last(), Some(b';' | b':'));
        start..self.at.end - usize::from(is_ended)
    }
}

/// An iterator over the units of a source.
#[derive(Clone, Debug)]
pub(crate) struct CodeUnits<'a> {
    source: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> CodeUnits<'a> {
    /// Starts at the first unit, behind a byte order mark.
    pub fn new(source: &'a [u8]) -> Self {
        let at = if source.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { source, at, line: 1 }
    }

    /// Returns the next unit; `None` at the end, `Err` for a statement without `;`.
    pub fn next(&mut self) -> Result<Option<CodeUnit>, LocatedFault> {
        self.skip_blanks();
        let Some(first) = self.source.get(self.at).copied() else { return Ok(None) };
        let (start, line) = (self.at, self.line);
        let mut scan = Scan::new(&self.source[start..]);
        let word = scan.name().0.to_ascii_uppercase();
        let behind = start + scan.at;
        let is_label = scan.takes(b':') && scan.peek() != Some(b'=');
        let end = match word.as_str() {
            _ if first == b'%' => Some(self.end_of_line()),
            "VERSION" | "LANGUAGE" if is_label => Some(self.end_of_line()),
            _ if is_label && word != "CASE" => Some(start + scan.at),
            "MODULE" | "PROC" | "FUNC" | "TRAP" | "RECORD" | "TEST" => Some(self.end_of_line()),
            "LOCAL" if matches!(scan.name().0.to_ascii_uppercase().as_str(), "PROC" | "FUNC" | "TRAP" | "RECORD") => {
                Some(self.end_of_line())
            }
            "ENDMODULE" | "ENDPROC" | "ENDFUNC" | "ENDTRAP" | "ENDRECORD" | "ENDIF" | "ENDFOR" | "ENDWHILE"
            | "ENDTEST" | "ELSE" | "ERROR" | "UNDO" | "BACKWARD" => Some(behind),
            "CASE" => self.end_after(b':'),
            "IF" | "ELSEIF" => self.end_after_word("THEN"),
            "FOR" | "WHILE" => self.end_after_word("DO"),
            _ => None,
        };
        let is_statement = end.is_none();
        let end = end.or_else(|| self.end_after(b';'));
        let at = start..end.unwrap_or(self.source.len());
        if end.is_none() {
            return Err(LocatedFault {
                line,
                at,
                fault: RobotFault::Form { expected: "; at the end of the statement" },
            });
        }
        self.advance_to(at.end);
        Ok(Some(CodeUnit { at, line, word, is_statement }))
    }

    /// Moves on to byte `end` and counts the lines passed.
    fn advance_to(&mut self, end: usize) {
        let passed = &self.source[self.at..end];
        // \r\n is one ending.
        let endings = passed.iter().enumerate().filter(|(at, byte)| {
            **byte == b'\n' || (**byte == b'\r' && self.source.get(self.at + at + 1) != Some(&b'\n'))
        });
        self.line += endings.count();
        self.at = end;
    }

    /// Skips blanks, comments and empty statements.
    fn skip_blanks(&mut self) {
        loop {
            let rest = &self.source[self.at..];
            let blanks =
                rest.iter().position(|byte| !byte.is_ascii_whitespace() && *byte != b';').unwrap_or(rest.len());
            self.advance_to(self.at + blanks);
            if self.source.get(self.at) != Some(&b'!') {
                return;
            }
            self.advance_to(self.end_of_line());
        }
    }

    /// Returns the index of the next line ending.
    fn end_of_line(&self) -> usize {
        let rest = &self.source[self.at..];
        self.at + rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')).unwrap_or(rest.len())
    }

    /// Returns the index behind the next byte `stop` outside strings and comments; `None` if none follows.
    fn end_after(&self, stop: u8) -> Option<usize> {
        code_bytes(&self.source[self.at..]).find(|(_, byte)| *byte == stop).map(|(at, _)| self.at + at + 1)
    }

    /// Returns the index behind the next `word`, if it comes before `;`.
    fn end_after_word(&self, word: &str) -> Option<usize> {
        let rest = &self.source[self.at..];
        let is_of_name = |byte: Option<&u8>| byte.is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
        for (at, byte) in code_bytes(rest) {
            if byte == b';' {
                return None;
            }
            let end = at + word.len();
            let is_here = rest.get(at..end).is_some_and(|text| text.eq_ignore_ascii_case(word.as_bytes()));
            if is_here
                && !is_of_name(rest.get(end))
                && !is_of_name(at.checked_sub(1).and_then(|before| rest.get(before)))
            {
                return Some(self.at + end);
            }
        }
        None
    }
}

/// Returns where the statement of `IF condition statement;` begins in `text`: where one operand follows another; `None` if none does, or the
/// condition cannot be read.
pub(crate) fn one_line_statement(text: &[u8]) -> Option<usize> {
    let mut scan = Scan::new(text);
    scan.name();
    let mut is_behind_operand = false;
    loop {
        let byte = scan.next()?;
        let start = scan.at;
        match byte {
            b'(' | b'{' => scan.at = end_of_group(text, start)?,
            b'[' | b'"' | b'0'..=b'9' if is_behind_operand => return Some(start),
            b'[' => scan.at = end_of_group(text, start)?,
            b'!' => {
                scan.take_while(|byte| !matches!(byte, b'\r' | b'\n'));
                continue;
            }
            b'"' => {
                // A quotation mark in a string is written twice.
                scan.at += 1;
                loop {
                    scan.take_while(|byte| byte != b'"');
                    scan.peek()?;
                    scan.at += 1;
                    if scan.peek() != Some(b'"') {
                        break;
                    }
                    scan.at += 1;
                }
            }
            b'0'..=b'9' | b'.' if !is_behind_operand => {
                scan.number().ok()?;
                // 0x1F is no 0.
                if scan.peek().is_some_and(|byte| byte.is_ascii_alphanumeric() || byte == b'_') {
                    return None;
                }
            }
            b'.' => {
                scan.at += 1;
                scan.name();
            }
            b'+' | b'-' | b'*' | b'/' | b'<' | b'>' | b'=' => {
                scan.at += 1;
                is_behind_operand = false;
                continue;
            }
            _ => {
                let (name, at) = scan.name();
                match name.to_ascii_uppercase().as_str() {
                    "" => return None,
                    "AND" | "OR" | "XOR" | "DIV" | "MOD" | "NOT" => {
                        is_behind_operand = false;
                        continue;
                    }
                    _ if is_behind_operand => return Some(at.start),
                    _ => {}
                }
            }
        }
        is_behind_operand = true;
    }
}

/// Returns the index behind the bracket that closes the one at byte `start` of `text`; `None` if none does.
fn end_of_group(text: &[u8], start: usize) -> Option<usize> {
    let mut depth = 0usize;
    let last = code_bytes(&text[start..]).find(|(_, byte)| {
        match byte {
            b'[' | b'(' | b'{' => depth += 1,
            b']' | b')' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth == 0
    });
    last.map(|(at, _)| start + at + 1)
}

/// Returns the names (in capitals) before brackets in `text`.
pub(crate) fn called_names(text: &[u8]) -> impl Iterator<Item = String> {
    let opens = code_bytes(text).filter(|(_, byte)| *byte == b'(').map(|(at, _)| at);
    let names = opens.map(|at| Scan::name_before(&text[..at]).to_ascii_uppercase());
    names.filter(|name| name.starts_with(|c: char| c.is_ascii_alphabetic()))
}

/// Iterates over the bytes of `text` outside strings and comments, with their indices.
pub(crate) fn code_bytes(text: &[u8]) -> impl Iterator<Item = (usize, u8)> {
    code_bytes_before(text, b'!')
}

/// Iterates over bytes as [`code_bytes`] does, where a comment begins with `mark`.
pub(crate) fn code_bytes_before(text: &[u8], mark: u8) -> impl Iterator<Item = (usize, u8)> {
    let (mut in_text, mut in_comment) = (false, false);
    text.iter().copied().enumerate().filter(move |(_, byte)| {
        match byte {
            b'\r' | b'\n' => (in_text, in_comment) = (false, false),
            b'"' if !in_comment => {
                in_text ^= true;
                return false;
            }
            byte if *byte == mark && !in_text => in_comment = true,
            _ => {}
        }
        !in_text && !in_comment
    })
}

/// Returns the index of the first `\` outside brackets, where the options of an argument begin; the length of `text` without one.
pub(crate) fn option_start(text: &[u8]) -> usize {
    let mut depth = 0usize;
    let slash = code_bytes(text).find(|(_, byte)| {
        match byte {
            b'[' | b'(' | b'{' => depth += 1,
            b']' | b')' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        *byte == b'\\' && depth == 0
    });
    slash.map_or(text.len(), |(at, _)| at)
}

/// Splits `text`, which begins at byte `start` of the source, at commas outside brackets; returns the arguments' ranges in the source.
pub(crate) fn split_arguments(text: &[u8], start: usize) -> Vec<Range<usize>> {
    let (mut depth, mut from, mut found) = (0usize, 0, Vec::new());
    for (at, byte) in code_bytes(text) {
        match byte {
            b'[' | b'(' | b'{' => depth += 1,
            b']' | b')' | b'}' => depth = depth.saturating_sub(1),
            b',' if depth == 0 => {
                found.push(start + from..start + at);
                from = at + 1;
            }
            _ => {}
        }
    }
    found.push(start + from..start + text.len());
    found
}
