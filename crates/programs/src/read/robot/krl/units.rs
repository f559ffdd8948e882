//! Splits a KRL program into units: lines of code, each a statement or a word of structure, and lines of comment.

use crate::{
    model::robot::RobotFault,
    read::{
        robot::{LineCursor, LocatedFault, krl::code_range, rapid::CodeUnit, trimmed},
        scan::Scan,
    },
};

/// Words that open or close a part of a program.
const STRUCTURE: &str = "DEF DEFFCT END ENDFCT IF ELSE ENDIF FOR ENDFOR WHILE ENDWHILE LOOP ENDLOOP REPEAT UNTIL SWITCH CASE \
    DEFAULT ENDSWITCH";

/// Returns the unit of the next line that is not empty; the word of a comment is `;`. `None` at the end, `Err` for a statement that goes on
/// in the next line.
pub(crate) fn next_unit(source: &[u8], lines: &mut LineCursor<'_>) -> Result<Option<CodeUnit>, LocatedFault> {
    while let Some(range) = lines.advance() {
        let line = lines.line;
        let mut at = code_range(source, range.clone());
        let is_comment = at.is_empty();
        if is_comment {
            at = trimmed(source, at.start..range.end);
        }
        let text = &source[at.clone()];
        if text.is_empty() || text[0] == b'&' {
            continue;
        }
        if is_comment {
            return Ok(Some(CodeUnit { at, line, word: ";".to_owned(), is_statement: true }));
        }
        if text.ends_with(b"\\") {
            return Err(LocatedFault { line, at, fault: RobotFault::Form { expected: "a statement on one line" } });
        }
        let mut scan = Scan::new(text);
        let mut word = scan.name().0.to_ascii_uppercase();
        let mut ahead = scan;
        let is_label = !word.is_empty() && ahead.takes(b':') && ahead.is_done();
        let second = scan.name().0.to_ascii_uppercase();
        if word == "GLOBAL" && matches!(second.as_str(), "DEF" | "DEFFCT") {
            word = second;
        }
        let is_statement = !is_label && !STRUCTURE.split_whitespace().any(|known| known == word);
        return Ok(Some(CodeUnit { at, line, word, is_statement }));
    }
    Ok(None)
}
