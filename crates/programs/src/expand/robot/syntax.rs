//! What the languages of robot programs write differently: units, comments, names and words.

use std::ops::Range;

use crate::{
    model::robot::Language,
    read::robot::{
        LineCursor, LocatedFault, krl,
        rapid::{self, CodeUnit, CodeUnits, code_bytes_before},
    },
};

/// An iterator over the units of a source.
pub(crate) enum Units<'a> {
    Rapid(CodeUnits<'a>),
    Krl(&'a [u8], LineCursor<'a>),
}

impl<'a> Units<'a> {
    /// Starts at the first unit.
    pub fn new(source: &'a [u8], language: Language) -> Self {
        match language {
            Language::Krl => Units::Krl(source, LineCursor::new(source)),
            _ => Units::Rapid(CodeUnits::new(source)),
        }
    }

    /// Returns the next unit; `None` at the end, `Err` for a statement without end.
    pub fn next(&mut self) -> Result<Option<CodeUnit>, LocatedFault> {
        match self {
            Units::Rapid(units) => units.next(),
            Units::Krl(source, lines) => krl::next_unit(source, lines),
        }
    }
}

/// Returns the byte with which a comment begins.
pub(crate) fn comment_mark(language: Language) -> u8 {
    if language == Language::Krl { b';' } else { b'!' }
}

/// Iterates over the bytes of `text` outside strings and comments, with their indices.
pub(crate) fn code_bytes(text: &[u8], language: Language) -> impl Iterator<Item = (usize, u8)> {
    code_bytes_before(text, comment_mark(language))
}

/// Whether `word` (in capitals) moves the tool.
pub(crate) fn is_motion(word: &str, language: Language) -> bool {
    if language == Language::Krl { krl::is_motion_word(word) } else { rapid::is_motion(word) }
}

/// Whether `word` (in capitals) moves the tool, or sets what a motion means.
pub(crate) fn matters_to_motions(word: &str, language: Language) -> bool {
    const SET: &str = "$BASE $TOOL $VEL $IPO_MODE $ORI_TYPE $CIRC_TYPE BAS FDAT_ACT";
    is_motion(word, language) || language == Language::Krl && SET.split_whitespace().any(|known| known == word)
}

/// Whether `word` (in capitals) begins a declaration of data whose values may be followed.
pub(crate) fn is_declaration(word: &str, language: Language) -> bool {
    match language {
        Language::Krl => matches!(word, "DECL" | "CONST") || KRL_TYPES.contains(&word),
        _ => matches!(word, "CONST" | "PERS" | "VAR"),
    }
}

/// Types of KRL whose values are followed.
pub(crate) const KRL_TYPES: [&str; 9] = ["INT", "REAL", "BOOL", "CHAR", "FRAME", "POS", "E6POS", "AXIS", "E6AXIS"];

/// Whether `byte` may be in a name.
pub(crate) fn is_of_name(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$')
}

/// Returns where the names of data and routines in `text` are, outside strings and comments: not those of parts (`.x`), options (`\V`),
/// words of an enumeration (`#BASE`), numbers, and what stands in braces of KRL.
pub(crate) fn names_in(text: &[u8], language: Language) -> Vec<Range<usize>> {
    let (mut found, mut end, mut depth): (Vec<Range<usize>>, usize, usize) = (Vec::new(), 0, 0);
    for (at, byte) in code_bytes(text, language) {
        match byte {
            b'{' if language == Language::Krl => depth += 1,
            b'}' if language == Language::Krl => depth = depth.saturating_sub(1),
            _ => {}
        }
        let before = at.checked_sub(1).and_then(|before| text.get(before)).copied();
        let continues = before.is_some_and(is_of_name);
        if depth > 0 || at < end || continues || !is_of_name(byte) || byte.is_ascii_digit() {
            continue;
        }
        end = at + text[at..].iter().take_while(|byte| is_of_name(**byte)).count();
        let joined = text[..at].trim_ascii_end().last().copied();
        if !matches!(joined, Some(b'.' | b'\\')) && !matches!(before, Some(b'#' | b'\'')) {
            found.push(at..end);
        }
    }
    found
}

/// Returns the names that [`names_in`] finds, in capitals.
pub(crate) fn names_of(text: &[u8], language: Language) -> impl Iterator<Item = String> {
    names_in(text, language).into_iter().map(|at| String::from_utf8_lossy(&text[at]).to_ascii_uppercase())
}
