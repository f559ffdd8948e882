//! Words of a line: letters with their numbers.
//!
//! Most lines of long programs are nothing else, and are read at once; of others it is then looked for what is wrong with them.

use crate::toolpath::model::gcode::{Fault, Refusal, Word};

/// The words in `text`, a line whose comments and tabs are blanked out, in order.
pub(crate) fn words(text: &str) -> Result<Vec<Word>, Refusal> {
    plain(text, Fault::MAX_DIGITS).map_or_else(|| parted(text), Ok)
}

/// The words of a line in which each is a letter and behind it a number of at most `longest` bytes; `None` of any other.
fn plain(text: &str, longest: usize) -> Option<Vec<Word>> {
    let bytes = text.as_bytes();
    let mut words = Vec::with_capacity(8);
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        if byte == b' ' {
            at += 1;
            continue;
        }
        let sign = usize::from(matches!(bytes.get(at + 1), Some(b'+' | b'-')));
        let digits = at + 1 + sign;
        let is_number = |byte: &&u8| byte.is_ascii_digit() || **byte == b'.';
        let length = bytes.get(digits..)?.iter().take_while(is_number).count();
        if !byte.is_ascii_alphabetic() || length > longest || is_exponent(bytes, at) {
            return None;
        }
        // No number: nothing, a point alone, two points.
        let value = text[at + 1..digits + length].parse().ok()?;
        words.push(Word::plain(char::from(byte.to_ascii_uppercase()), value, at..digits + length));
        at = digits + length;
    }
    Some(words)
}

/// Whether an E stands at `at` directly behind a number: to whom wrote it an exponent, to controls a word of its own.
fn is_exponent(bytes: &[u8], at: usize) -> bool {
    let is_number = |byte: u8| byte.is_ascii_digit() || byte == b'.';
    matches!(bytes[at], b'E' | b'e') && at > 0 && is_number(bytes[at - 1])
}

/// The words in `text`, in which blanks may part letters from their numbers and numbers may be long.
fn parted(text: &str) -> Result<Vec<Word>, Refusal> {
    check_signs_and_digits(text)?;
    if let Some(at) = (0..text.len()).find(|at| is_exponent(text.as_bytes(), *at)) {
        return Err(Refusal { fault: Fault::Exponent, ..not_a_word(text, at) });
    }
    let (joined, letters) = joined(text);
    let mut words = plain(&joined, usize::MAX).ok_or_else(|| not_words(&joined))?;
    for word in &mut words {
        if let Ok(index) = letters.binary_search_by_key(&word.span.start, |(_, to)| *to) {
            word.span.start = letters[index].0;
        }
    }
    Ok(words)
}

/// `text` with letters that blanks part from their numbers (`X 10`) moved to them, and from where to where.
fn joined(text: &str) -> (String, Vec<(usize, usize)>) {
    let mut bytes = text.as_bytes().to_vec();
    let mut moved = Vec::new();
    for from in 0..bytes.len() {
        let rest = &text.as_bytes()[from + 1..];
        let blanks = rest.iter().take_while(|b| **b == b' ').count();
        let alone = from == 0 || !text.as_bytes()[from - 1].is_ascii_alphabetic();
        let number = rest.get(blanks).is_some_and(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.'));
        if bytes[from].is_ascii_alphabetic() && alone && blanks > 0 && number {
            bytes.swap(from, from + blanks);
            moved.push((from, from + blanks));
        }
    }
    (String::from_utf8_lossy(&bytes).into_owned(), moved)
}

/// Refuses two signs in a row, and numbers of more digits than a coordinate can hold.
fn check_signs_and_digits(text: &str) -> Result<(), Refusal> {
    let bytes = text.as_bytes();
    if let Some(at) = bytes.windows(2).position(|pair| pair.iter().all(|b| matches!(b, b'+' | b'-'))) {
        return Err(not_a_word(text, at));
    }
    let mut start = 0;
    for run in bytes.split(|b| !b.is_ascii_digit()) {
        if run.len() > Fault::MAX_DIGITS {
            return Err(Refusal::new(start..start + run.len(), Fault::TooManyDigits { digits: run.len() }));
        }
        start += run.len() + 1;
    }
    Ok(())
}

/// Refuses the first part of `text` between blanks with the worst that is wrong with any: it is no letters and numbers, its last letter
/// has no number, or several letters have one.
fn not_words(text: &str) -> Refusal {
    let mut at = 0;
    let parts = text.split(' ').map(|part| {
        let start = at;
        at += part.len() + 1;
        (start, part)
    });
    let worst = parts.filter_map(|(start, part)| Some((wrong_with(part)?, start))).min_by_key(|(wrong, _)| *wrong);
    not_a_word(text, worst.map_or(0, |(_, start)| start))
}

/// How bad it is, 0 the worst, if anything is wrong with text without blanks.
fn wrong_with(mut rest: &str) -> Option<u8> {
    let mut found = None;
    while !rest.is_empty() {
        let letters = rest.bytes().take_while(u8::is_ascii_alphabetic).count();
        let behind = &rest[letters..];
        let digits = |from: usize| behind[from..].bytes().take_while(u8::is_ascii_digit).count();
        let sign = usize::from(behind.starts_with(['+', '-']));
        let whole = sign + digits(sign);
        let end = if behind[whole..].starts_with('.') { whole + 1 + digits(whole + 1) } else { whole };
        match (letters, behind[..end].parse::<f64>()) {
            (1.., Err(_)) if behind.is_empty() => return Some(1),
            (0, _) | (_, Err(_)) => return Some(0),
            (1, Ok(_)) => {}
            (_, Ok(_)) => found = Some(2),
        }
        rest = &behind[end..];
    }
    found
}

/// Refuses the blank-separated text around `at`.
fn not_a_word(text: &str, at: usize) -> Refusal {
    let start = text[..at].rfind(' ').map_or(0, |p| p + 1);
    let end = text[at..].find(' ').map_or(text.len(), |p| at + p);
    Refusal::new(start..end, what_instead(text, start))
}

/// What else text that is no word may be: that of another language or a macro.
fn what_instead(text: &str, start: usize) -> Fault {
    const MACRO: [&str; 24] = [
        "IF",
        "THEN",
        "GOTO",
        "WHILE",
        "DO",
        "END",
        "SUB",
        "ENDSUB",
        "CALL",
        "RETURN",
        "ELSE",
        "ELSEIF",
        "ENDIF",
        "ENDWHILE",
        "REPEAT",
        "ENDREPEAT",
        "BREAK",
        "CONTINUE",
        "SETVN",
        "POPEN",
        "DPRNT",
        "PCLOS",
        "BPRNT",
        "O",
    ];
    let name_at = |at: usize| -> String { text[at..].chars().take_while(char::is_ascii_alphabetic).collect() };
    let before = || text[..start].trim_end().rfind(' ').map_or(0, |p| p + 1);
    let name = Some(name_at(start)).filter(|name| !name.is_empty()).unwrap_or_else(|| name_at(before())).to_uppercase();
    let o_word = text.trim_start().starts_with(['o', 'O']);
    match name.len() {
        _ if MACRO.contains(&name.as_str()) && (name != "O" || o_word) => Fault::Variable,
        3.. => Fault::Language,
        _ => Fault::NotAWord,
    }
}
