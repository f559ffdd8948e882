//! Which dialect a program is in, as its text shows.

use crate::toolpath::{
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
    /// The dialect of a program: Heidenhain's has `BEGIN PGM`; Sinumerik's has `%_N_`, addresses and names with `=`, or names and
    /// G words that no other has (`MSG(…)`, `TRANS`, `CYCLE81(…)`, `G710`); others are ISO.
    #[must_use]
    pub fn of(source: &[u8]) -> Dialect {
        let lines = || source.split(|byte| matches!(byte, b'\r' | b'\n'));
        if lines().any(begins_heidenhain) {
            Dialect::Heidenhain
        } else if lines().any(shows_sinumerik) {
            Dialect::Sinumerik
        } else {
            Dialect::Iso
        }
    }
}

fn begins_heidenhain(line: &[u8]) -> bool {
    let start = block_numbers::number(line).map_or(lines::blanks(line), |(range, _)| range.end);
    let mut scan = Scan::of_line(line, start);
    let mut word = || {
        scan.next();
        scan.letters()
    };
    word() == "BEGIN" && word() == "PGM"
}

fn shows_sinumerik(line: &[u8]) -> bool {
    let start = lines::prefix(line);
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
            if scan.closed(b'(', b')').is_err() {
                return false;
            }
        } else if byte.is_ascii_alphabetic() {
            let letters = scan.letters();
            let name = match letters.len() {
                2.. => letters + &String::from_utf8_lossy(&scan.line[scan.run(|byte| byte.is_ascii_alphanumeric())]),
                _ => letters,
            };
            let number = scan.run(|byte| byte.is_ascii_digit() || byte == b'.');
            let is_own_g = name == "G" && sinumerik_words::is_own_g(&scan.upper(number));
            if is_own_g || scan.takes(b'=') || sinumerik_words::is_own(&name, scan.peek() == Some(b'(')) {
                return true;
            }
        } else {
            scan.at += 1;
        }
    }
    false
}
