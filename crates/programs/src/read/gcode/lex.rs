//! Splits a line into words: letters with their numbers.
//!
//! Most lines are plain words and are read in one pass; other lines are then searched for what is wrong with them.

use crate::model::gcode::{Fault, Refusal, Word};

/// Splits `text`, a line with comments and tabs blanked out, into words; `Err` says what is wrong.
pub(crate) fn words(text: &str) -> Result<Vec<Word>, Refusal> {
    let words = plain_words(text, Fault::MAX_DIGITS).map_or_else(|| spaced_words(text), Ok)?;
    // G4 X01 is a time.
    let dwells = || words.iter().any(|word| word.letter == 'G' && word.value == 4.0);
    match words.iter().find(|word| has_implied_point(text, word)).filter(|_| !dwells()) {
        Some(word) => Err(word.refuse(Fault::ImpliedPoint)),
        None => Ok(words),
    }
}

/// Whether `word` of the line `text` is a coordinate with leading zeros and no point: old controls count its point from one end.
fn has_implied_point(text: &str, word: &Word) -> bool {
    if !matches!(word.letter, 'X' | 'Y' | 'Z' | 'A' | 'B' | 'C' | 'I' | 'J' | 'R') || word.value == 0.0 {
        return false;
    }
    let digits = text[word.span.start + 1..word.span.end].trim_start_matches([' ', '+', '-']);
    digits.len() > 1 && digits.starts_with('0') && !digits.contains('.')
}

/// Splits a line of letters directly followed by numbers of at most `longest` bytes into words; `None` if it has anything else.
fn plain_words(text: &str, longest: usize) -> Option<Vec<Word>> {
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

/// Whether an E stands at `at` directly behind a number: an exponent to its author, a word to controls.
fn is_exponent(bytes: &[u8], at: usize) -> bool {
    let is_number = |byte: u8| byte.is_ascii_digit() || byte == b'.';
    matches!(bytes[at], b'E' | b'e') && at > 0 && is_number(bytes[at - 1])
}

/// Splits `text` into words, where blanks may part letters from their numbers; `Err` says what is wrong.
fn spaced_words(text: &str) -> Result<Vec<Word>, Refusal> {
    check_signs_and_digits(text)?;
    if let Some(at) = (0..text.len()).find(|at| is_exponent(text.as_bytes(), *at)) {
        return Err(Refusal { fault: Fault::Exponent, ..word_refusal(text, at) });
    }
    let (joined, letters) = join_words(text);
    let mut words = plain_words(&joined, usize::MAX).ok_or_else(|| words_refusal(&joined))?;
    for word in &mut words {
        if let Ok(index) = letters.binary_search_by_key(&word.span.start, |(_, to)| *to) {
            word.span.start = letters[index].0;
        }
    }
    Ok(words)
}

/// Returns `text` with letters moved over blanks to their numbers (`X 10`), and the moves: byte before and after.
fn join_words(text: &str) -> (String, Vec<(usize, usize)>) {
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

/// Refuses two signs in a row, and numbers of more than [`Fault::MAX_DIGITS`] digits.
fn check_signs_and_digits(text: &str) -> Result<(), Refusal> {
    let bytes = text.as_bytes();
    if let Some(at) = bytes.windows(2).position(|pair| pair.iter().all(|b| matches!(b, b'+' | b'-'))) {
        return Err(word_refusal(text, at));
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

/// Returns the refusal of the worst part of `text` between blanks, the first one if several are as bad.
fn words_refusal(text: &str) -> Refusal {
    let mut at = 0;
    let parts = text.split(' ').map(|part| {
        let start = at;
        at += part.len() + 1;
        (start, part)
    });
    let worst = parts.filter_map(|(start, part)| Some((fault_rank(part)?, start))).min_by_key(|(wrong, _)| *wrong);
    word_refusal(text, worst.map_or(0, |(_, start)| start))
}

/// Ranks the fault in text without blanks: 0 no words, 1 no number behind the last letter, 2 several letters before a number; `None` without one.
fn fault_rank(mut rest: &str) -> Option<u8> {
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

/// Returns the refusal of the text around byte `at`, up to the blanks on both sides.
fn word_refusal(text: &str, at: usize) -> Refusal {
    let start = text[..at].rfind(' ').map_or(0, |p| p + 1);
    let end = text[at..].find(' ').map_or(text.len(), |p| at + p);
    Refusal::new(start..end, likely_fault(text, start))
}

/// Returns the most likely fault of the text at byte `start`, which is no word: a macro, another language, or none of these.
fn likely_fault(text: &str, start: usize) -> Fault {
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
