//! Detects the dialect of a program by its text.

use crate::{
    model::gcode::Dialect,
    read::{
        gcode::{
            dialect::{block_numbers, sinumerik_words},
            lines,
        },
        scan::Scan,
    },
};

impl Dialect {
    /// Detects the dialect of a program: Heidenhain's has `BEGIN PGM`; Sinumerik's has `%_N_`, addresses and names with `=`, or names and G
    /// words that no other has (`MSG(…)`, `TRANS`, `CYCLE81(…)`, `G710`); others are ISO.
    #[must_use]
    pub fn detect(source: &[u8]) -> Dialect {
        let lines = || source.split(|byte| matches!(byte, b'\r' | b'\n'));
        if lines().any(is_heidenhain_begin) {
            Dialect::Heidenhain
        } else if lines().any(is_sinumerik_line) {
            Dialect::Sinumerik
        } else {
            Dialect::Iso
        }
    }
}

/// Returns the first line of `source` that is not blank; `None` if all are.
fn first_line(source: &[u8]) -> Option<&[u8]> {
    source.split(|byte| matches!(byte, b'\r' | b'\n')).map(<[u8]>::trim_ascii).find(|line| !line.is_empty())
}

/// Whether the first line of `source` is the name of a file of Okuma's OSP: `$PART.MIN%`.
pub(super) fn is_okuma(source: &[u8]) -> bool {
    let name = first_line(source).and_then(|line| line.strip_prefix(b"$")?.strip_suffix(b"%"));
    let ending =
        name.and_then(|name| Some(name[name.iter().rposition(|byte| *byte == b'.')? + 1..].to_ascii_uppercase()));
    ending.is_some_and(|ending| [&b"MIN"[..], b"SSB", b"SUB", b"LIB"].contains(&&ending[..]))
}

/// Whether the first line of `source` is that of a program of Heidenhain's DIN/ISO: `%PART G71`, with or without `*`.
pub(super) fn is_din_iso(source: &[u8]) -> bool {
    let Some(rest) = first_line(source).and_then(|line| line.strip_prefix(b"%")) else { return false };
    let mut words = rest.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    // Sinumerik's names begin with _N_.
    let is_of_name = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-');
    let is_named = words.next().is_some_and(|name| name.iter().all(is_of_name) && !name.starts_with(b"_N_"));
    let is_unit = |word: &[u8]| {
        let word = word.strip_suffix(b"*").unwrap_or(word).to_ascii_uppercase();
        word == b"G70" || word == b"G71"
    };
    is_named && words.any(is_unit)
}

/// Whether `line` is `BEGIN PGM`, the first block of a Heidenhain program.
fn is_heidenhain_begin(line: &[u8]) -> bool {
    let start = block_numbers::leading_number(line).map_or(lines::blank_len(line), |(range, _)| range.end);
    let mut scan = Scan::of_line(line, start);
    let mut word = || {
        scan.next();
        scan.take_letters()
    };
    word() == "BEGIN" && word() == "PGM"
}

/// Whether `line` has names or G words that only Sinumerik programs have.
fn is_sinumerik_line(line: &[u8]) -> bool {
    let start = lines::prefix_len(line);
    if line[start..].starts_with(b"%_N_") {
        return true;
    }
    // What macros have of other controls.
    if line[start..].iter().any(|byte| matches!(byte, b'#' | b'<' | b'%' | b'$' | b'?' | b'!' | b'~')) {
        return false;
    }
    let mut scan = Scan::of_line(line, start);
    while let Some(byte) = scan.next() {
        if byte == b'(' {
            // A comment of ISO.
            if scan.skip_closed(b'(', b')').is_err() {
                return false;
            }
        } else if byte.is_ascii_alphabetic() {
            let letters = scan.take_letters();
            let name = match letters.len() {
                2.. => {
                    letters + &String::from_utf8_lossy(&scan.line[scan.take_while(|byte| byte.is_ascii_alphanumeric())])
                }
                _ => letters,
            };
            let number = scan.take_while(|byte| byte.is_ascii_digit() || byte == b'.');
            let is_own_g = name == "G" && sinumerik_words::is_sinumerik_g(&scan.upper_text(number));
            if is_own_g || scan.takes(b'=') || sinumerik_words::is_sinumerik_name(&name, scan.peek() == Some(b'(')) {
                return true;
            }
        } else {
            scan.at += 1;
        }
    }
    false
}
