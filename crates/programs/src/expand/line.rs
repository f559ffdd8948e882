//! Lines of a program with macros: labels, keywords, assignments, and words with their values.

use std::ops::Range;

use crate::{
    expand::{expression::Reader, heidenhain, variables::Variables},
    model::{
        decimals_in,
        gcode::{Contradiction, Dialect, Fault, MacroFault},
    },
    read::{
        gcode::{dialect::block_numbers, lines},
        scan::Scan,
    },
};

/// A line with its label and code.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SourceLine {
    pub bytes: Vec<u8>,
    /// Code in upper case with blanks for comments, as many bytes as the line; empty if the line is no code.
    pub code: String,
    /// The name after a leading O: `100` or `<NAME>`; that of Sinumerik's `%_N_NAME_SPF`.
    pub o_name: Option<String>,
    /// The label that the line has: Sinumerik's `NAME:`, Heidenhain's `LBL 5`.
    pub label: Option<String>,
    /// The number after a leading N.
    pub n_number: Option<u32>,
    /// Index of the code behind the block-delete mark, N and the O name.
    pub begin: usize,
}

impl SourceLine {
    /// Returns the most decimals of the line's coordinates that are written as plain numbers; 0 if there is none.
    pub fn decimals(&self) -> usize {
        let is_letter = |c: char| c.is_ascii_alphabetic();
        let letters = self.code.chars().filter(|c| is_letter(*c));
        let words = letters.zip(self.code.split(is_letter).skip(1).map(str::trim));
        let coordinates = words.filter(|(letter, _)| matches!(letter, 'X'..='Z' | 'I'..='K' | 'R'));
        let is_plain =
            |number: &&str| number.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'.' | b',' | b'+' | b'-'));
        coordinates
            .map(|(_, number)| number.trim_start_matches(['=', ' ']))
            .filter(is_plain)
            .map(decimals_in)
            .max()
            .unwrap_or(0)
    }

    /// Splits a line of a program in `dialect`.
    pub fn of(bytes: &[u8], dialect: Dialect) -> SourceLine {
        match dialect {
            Dialect::Sinumerik => SourceLine::of_sinumerik(bytes),
            Dialect::Heidenhain => SourceLine::of_heidenhain(bytes),
            _ => SourceLine::new(bytes),
        }
    }

    /// Splits a line of Sinumerik's into block-delete mark, N, label and code; a line with a % is a program's name, if it is anything.
    fn of_sinumerik(bytes: &[u8]) -> SourceLine {
        let mut scan = Scan::of_line(bytes, lines::prefix_len(bytes));
        let mut line = SourceLine::bare(bytes, scan.line.iter().map(|byte| ascii_upper(*byte)).collect());
        if scan.next() == Some(b'%') {
            let name = line.code.trim().strip_prefix("%_N_").and_then(|name| name.rsplit_once('_'));
            line.o_name = name.map(|(name, _)| name.to_owned());
            line.code.clear();
            return line;
        }
        if matches!(scan.peek(), Some(b'N' | b'n' | b':')) {
            let mut number = scan;
            number.at += 1;
            let digits = number.take_while(|byte| byte.is_ascii_digit());
            if !digits.is_empty() {
                line.n_number = line.code[digits].parse().ok();
                scan = number;
            }
        }
        scan.next();
        let mut label = scan;
        let name = label.take_while(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let is_name = name.len() > 1 && !line.code[name.clone()].starts_with(|c: char| c.is_ascii_digit());
        if is_name && label.peek() == Some(b':') {
            line.label = Some(line.code[name].to_owned());
            label.at += 1;
            scan = label;
        }
        line.begin = scan.at;
        line
    }

    /// Splits a block of Heidenhain's into its number, its label and code.
    fn of_heidenhain(bytes: &[u8]) -> SourceLine {
        let number = block_numbers::leading_number(bytes);
        let begin = number.as_ref().map_or_else(|| lines::prefix_len(bytes), |(range, _)| range.end);
        let scan = Scan::of_line(bytes, begin);
        let mut line = SourceLine::bare(bytes, scan.line.iter().map(|byte| ascii_upper(*byte)).collect());
        line.n_number = number.and_then(|(_, number)| u32::try_from(number).ok());
        line.begin = scan.at + scan.line[scan.at..].iter().take_while(|byte| lines::is_blank(**byte)).count();
        line.label = line.rest().strip_prefix("LBL").map(heidenhain::label_name);
        line
    }

    /// Returns a line with `code` that has neither number nor name.
    fn bare(bytes: &[u8], code: String) -> SourceLine {
        SourceLine { bytes: bytes.to_vec(), code, o_name: None, label: None, n_number: None, begin: 0 }
    }

    /// Splits a line into block-delete mark, N, O name and code.
    pub fn new(bytes: &[u8]) -> SourceLine {
        let mut line = SourceLine::bare(bytes, code_text(bytes));
        let text = line.code.as_bytes();
        let mut at = text.iter().take_while(|b| **b == b' ').count();
        if text.get(at) == Some(&b'/') {
            at += 1 + text[at + 1..].iter().take_while(|b| **b == b' ' || b.is_ascii_digit()).count();
        }
        let digits = |from: usize| text[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let blanks = |from: usize| text[from..].iter().take_while(|b| **b == b' ').count();
        if text.get(at) == Some(&b'N') && digits(at + 1) > 0 {
            let end = at + 1 + digits(at + 1);
            line.n_number = line.code[at + 1..end].parse().ok();
            at = end + blanks(end);
        }
        if matches!(text.get(at), Some(b'O' | b':')) {
            let length = match text.get(at + 1) {
                Some(b'<') => text[at..].iter().position(|b| *b == b'>').unwrap_or(0),
                _ => digits(at + 1),
            };
            if length > 0 {
                let end = at + 1 + length;
                let name = line.code[at + 1..end].replace(' ', "");
                line.o_name = Some(name.parse::<u32>().map_or(name, |number| number.to_string()));
                at = end + blanks(end);
            }
        }
        line.begin = at.min(line.code.len());
        line
    }

    /// The code behind the block-delete mark, N and the O name.
    pub fn rest(&self) -> &str {
        self.code[self.begin..].trim()
    }

    /// The letters that the rest begins with: `SUB`, `WHILE`.
    pub fn keyword(&self) -> &str {
        let rest = self.rest();
        &rest[..rest.bytes().take_while(u8::is_ascii_alphabetic).count()]
    }

    /// The letters, digits and `_` that the rest begins with: `WHILE`, `L100`, `CYCLE81`.
    pub fn first_word(&self) -> &str {
        let rest = self.rest();
        &rest[..rest.bytes().take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'_').count()]
    }

    /// Whether the line is only the number or name of a program.
    pub fn begins_program(&self) -> bool {
        self.o_name.is_some() && self.rest().is_empty()
    }

    /// Returns the words of a line that assigns nothing, with their evaluated numbers; `Err` gives the byte of the fault.
    pub fn words(&self, variables: &Variables) -> Result<Vec<CalledWord>, (usize, Fault)> {
        let text = self.code.as_bytes();
        let (mut words, mut at) = (Vec::new(), self.begin);
        while at < text.len() {
            match text[at] {
                b' ' => at += 1,
                letter if letter.is_ascii_alphabetic() => {
                    let mut reader = Reader::new(&self.code, at + 1, variables);
                    let value = reader.value().map_err(|fault| (at, fault))?;
                    words.push(CalledWord { letter: char::from(letter), value, span: at..reader.at });
                    at = reader.at;
                }
                _ => return Err((at, Fault::Character)),
            }
        }
        Ok(words)
    }

    /// Whether the line has a word of `letter` with one of `numbers`, written plainly: `M98`, `M 098`, `G65`.
    pub fn has_word(&self, letter: u8, numbers: &[f64]) -> bool {
        (self.begin..self.code.len()).filter(|at| self.code.as_bytes()[*at] == letter).any(|at| {
            let digits = self.code[at + 1..].trim_start();
            let length = digits.bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
            digits[..length].parse::<f64>().is_ok_and(|number| numbers.contains(&number))
        })
    }

    /// Whether the line is a % that opens or closes the program.
    pub fn is_percent(&self) -> bool {
        lines::first_byte(&self.bytes) == Some(b'%')
    }

    /// Whether the line has no code, not even a % or an O.
    pub fn is_without_code(&self) -> bool {
        self.code.trim().is_empty() && !self.is_percent()
    }

    /// Returns the line without `words`, which are in order; `None` if nothing but N remains.
    pub fn without_words(&self, words: &[CalledWord]) -> Option<SourceLine> {
        let mut bytes = self.bytes.clone();
        for word in words.iter().rev() {
            let blanks = bytes[..word.span.start].iter().rev().take_while(|b| **b == b' ').count();
            bytes.drain(word.span.start - blanks..word.span.end);
        }
        let rest = SourceLine::new(bytes.trim_ascii_end());
        (!rest.rest().is_empty()).then_some(rest)
    }
}

/// A word with its evaluated number (`None` is Fanuc's null) and its bytes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CalledWord {
    pub letter: char,
    pub value: Option<f64>,
    pub span: Range<usize>,
}

/// Returns the code of a line in upper case, as many bytes long, with blanks for comments and all that is not ASCII.
fn code_text(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    if lines::first_byte(bytes).is_some_and(|b| matches!(b, b'%' | b'$' | b'?' | b'!' | b'~')) {
        return text;
    }
    while let Some(&byte) = bytes.get(text.len()) {
        match byte {
            b'(' => {
                let at = text.len();
                let length = lines::comment_length(bytes, at).unwrap_or(bytes.len() - at);
                text.extend(std::iter::repeat_n(' ', length));
            }
            b';' => break,
            _ => text.push(ascii_upper(byte)),
        }
    }
    text
}

/// Returns the character of a byte in upper case, a blank for what is not ASCII.
fn ascii_upper(byte: u8) -> char {
    if matches!(byte, b' '..=b'~') { char::from(byte.to_ascii_uppercase()) } else { ' ' }
}

/// Returns a line of a macro program of Fanuc's kind with numbers of at most eight digits for its expressions and without its assignments `#n = …`, which
/// are made in `variables` once all words have their values. `Err` gives the index of the faulty byte in the line, and the fault: so is ROUND in a word,
/// which controls round differently (LinuxCNC's excepted).
pub(crate) fn evaluate_line(line: &SourceLine, variables: &mut Variables) -> Result<Vec<u8>, (usize, Fault)> {
    if !line.code.contains(['#', '[']) {
        return Ok(line.bytes.clone());
    }
    let text = line.code.as_bytes();
    let (mut out, mut from, mut at) = (Vec::new(), 0, line.begin);
    let mut assigned = Vec::new();
    while at < text.len() {
        match text[at] {
            b'#' => {
                let mut reader = Reader::new(&line.code, at + 1, variables);
                let assignment = reader.name().and_then(|name| match reader.takes("=") {
                    true => reader.expression().map(|value| (name, value)),
                    false => Err(Fault::Macro(MacroFault::Expression { expected: "= after a variable" })),
                });
                assigned.push(assignment.map_err(|fault| (at, fault))?);
                out.extend_from_slice(&line.bytes[from..at]);
                at = reader.at;
                from = at;
            }
            b if b.is_ascii_alphabetic() => {
                let mut reader = Reader::new(&line.code, at + 1, variables);
                reader.skip_blanks();
                let value_at = reader.at;
                let value = reader.number().map_err(|fault| (at, fault))?;
                if reader.has_rounded && variables.dialect != Dialect::LinuxCnc {
                    return Err((at, Fault::Contradicts(Contradiction::Rounded)));
                }
                if text[value_at..reader.at].iter().any(|b| !matches!(b, b'0'..=b'9' | b'.' | b'+' | b'-' | b' ')) {
                    out.extend_from_slice(&line.bytes[from..=at]);
                    out.extend_from_slice(word_number(text[at], value).as_bytes());
                    from = reader.at;
                }
                at = reader.at;
            }
            b' ' => at += 1,
            _ => return Err((at, Fault::Character)),
        }
    }
    out.extend_from_slice(&line.bytes[from..]);
    for (name, value) in assigned {
        variables.set(&name, value).map_err(|fault| (line.begin, fault))?;
    }
    Ok(out)
}

/// Most digits of a computed number: what controls read.
const MAX_DIGITS: usize = 8;

/// Formats a value as a word of `letter` takes it: whole, or with a decimal point and at most eight digits.
pub(crate) fn word_number(letter: u8, value: f64) -> String {
    let min_decimals = u8::from(!matches!(letter, b'G' | b'M' | b'N' | b'T' | b'H' | b'D' | b'O' | b'P' | b'L'));
    // Controls read eight digits.
    let whole = format!("{:.0}", value.abs().trunc()).len();
    write_scaled(value, 10f64.powi(i32::try_from(MAX_DIGITS.saturating_sub(whole)).unwrap_or(0)), min_decimals)
}

/// Formats a value for Sinumerik or Heidenhain as a word of `letter` takes it: whole, or with a decimal point and at most seven decimals.
pub(crate) fn long_number(letter: u8, value: f64) -> String {
    write_scaled(value, 1e7, u8::from(!matches!(letter, b'G' | b'M' | b'N' | b'T' | b'H' | b'D' | b'L')))
}

/// Formats a value for Sinumerik or Heidenhain with at most seven decimals, without a decimal point if it is whole.
pub(crate) fn plain_number(value: f64) -> String {
    write_scaled(value, 1e7, 0)
}

/// Formats a value that is rounded to whole steps of 1 / `scale`.
fn write_scaled(value: f64, scale: f64, min_decimals: u8) -> String {
    let text = crate::model::number::format_shortest((value * scale).round() / scale + 0.0, min_decimals);
    if min_decimals == 0 { text.trim_end_matches('.').to_owned() } else { text }
}
