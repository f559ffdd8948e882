//! A RAPID module as units: statements up to their `;`, and words of structure.

use std::ops::Range;

use crate::toolpath::{
    model::robot::RobotFault,
    read::{robot::Refusal, scan::Scan},
};

/// A statement, or what opens or closes a part of a module.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unit {
    /// The bytes of the source, with the `;`.
    pub at: Range<usize>,
    /// The line it begins on, from 1.
    pub line: usize,
    /// Its first word in capitals; empty if it begins with none.
    pub word: String,
    /// Whether it ends in `;`.
    pub is_statement: bool,
}

/// Goes through the units of a source.
#[derive(Clone, Debug)]
pub(crate) struct Units<'a> {
    source: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Units<'a> {
    pub fn new(source: &'a [u8]) -> Self {
        let at = if source.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { source, at, line: 1 }
    }

    pub fn next(&mut self) -> Result<Option<Unit>, Refusal> {
        self.skip();
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
            "CASE" => self.behind(b':'),
            "IF" | "ELSEIF" => self.behind_word("THEN"),
            "FOR" | "WHILE" => self.behind_word("DO"),
            _ => None,
        };
        let is_statement = end.is_none();
        let end = end.or_else(|| self.behind(b';'));
        let at = start..end.unwrap_or(self.source.len());
        if end.is_none() {
            return Err(Refusal { line, at, fault: RobotFault::Form { expected: "; at the end of the statement" } });
        }
        self.go_to(at.end);
        Ok(Some(Unit { at, line, word, is_statement }))
    }

    fn go_to(&mut self, end: usize) {
        let passed = &self.source[self.at..end];
        // \r\n is one ending.
        let endings = passed.iter().enumerate().filter(|(at, byte)| {
            **byte == b'\n' || (**byte == b'\r' && self.source.get(self.at + at + 1) != Some(&b'\n'))
        });
        self.line += endings.count();
        self.at = end;
    }

    /// Skips blanks, comments and empty statements.
    fn skip(&mut self) {
        loop {
            let rest = &self.source[self.at..];
            let blanks =
                rest.iter().position(|byte| !byte.is_ascii_whitespace() && *byte != b';').unwrap_or(rest.len());
            self.go_to(self.at + blanks);
            if self.source.get(self.at) != Some(&b'!') {
                return;
            }
            self.go_to(self.end_of_line());
        }
    }

    fn end_of_line(&self) -> usize {
        let rest = &self.source[self.at..];
        self.at + rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')).unwrap_or(rest.len())
    }

    /// Behind the next byte `wanted` that is in no text and no comment.
    fn behind(&self, wanted: u8) -> Option<usize> {
        code(&self.source[self.at..]).find(|(_, byte)| *byte == wanted).map(|(at, _)| self.at + at + 1)
    }

    /// Behind the next `word`, if it comes before `;`.
    fn behind_word(&self, word: &str) -> Option<usize> {
        let rest = &self.source[self.at..];
        let is_of_name = |byte: Option<&u8>| byte.is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
        for (at, byte) in code(rest) {
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

/// The bytes of `text` that are in no text in quotes and no comment, with their places.
pub(crate) fn code(text: &[u8]) -> impl Iterator<Item = (usize, u8)> {
    let (mut in_text, mut in_comment) = (false, false);
    text.iter().copied().enumerate().filter(move |(_, byte)| {
        match byte {
            b'\r' | b'\n' => (in_text, in_comment) = (false, false),
            b'"' if !in_comment => {
                in_text ^= true;
                return false;
            }
            b'!' if !in_text => in_comment = true,
            _ => {}
        }
        !in_text && !in_comment
    })
}

/// `text`, which begins at byte `start` of the source, at its commas that stand in no brackets.
pub(crate) fn arguments(text: &[u8], start: usize) -> Vec<Range<usize>> {
    let (mut depth, mut from, mut found) = (0usize, 0, Vec::new());
    for (at, byte) in code(text) {
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
