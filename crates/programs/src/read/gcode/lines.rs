//! Lines of a program: their ranges and endings, and which bytes of them are code.

use std::ops::Range;

use crate::model::gcode::{Fault, Refusal, Unsupported};

/// Ranges of the lines of a source, without gaps.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Lines {
    /// For each line the end of its content and the end of its ending.
    ends: Vec<[usize; 2]>,
}

impl Lines {
    /// Splits `source` at its line endings.
    pub fn split(source: &[u8]) -> Lines {
        let mut ends = Vec::new();
        let mut start = 0;
        while start < source.len() {
            let rest = &source[start..];
            let length = rest.iter().position(|b| matches!(b, b'\r' | b'\n')).unwrap_or(rest.len());
            let end = start + length;
            let next = match &source[end..] {
                [b'\r', b'\r', b'\n', ..] => end + 3,
                [b'\r', b'\n', ..] => end + 2,
                [_, ..] => end + 1,
                [] => end,
            };
            ends.push([end, next]);
            start = next;
        }
        Lines { ends }
    }

    /// Number of lines.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns the range of line `index` (from 0) without its ending.
    pub fn content(&self, index: usize) -> Range<usize> {
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before][1]);
        start..self.ends[index][0]
    }

    /// Returns the range of the ending of line `index`: one of `\n`, `\r\n`, `\r\r\n` and `\r`, or nothing at the end of the file.
    pub fn ending(&self, index: usize) -> Range<usize> {
        let [content, ending] = self.ends[index];
        content..ending
    }

    /// Returns the ending of line `index` of `source` for lines written in its place: `\n` if it has none.
    pub fn ending_or_newline<'a>(&self, source: &'a [u8], index: usize) -> &'a [u8] {
        if self.ending(index).is_empty() { b"\n" } else { &source[self.ending(index)] }
    }
}

/// Kind of a line, without its comments.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Code {
    /// A `%` that opens or closes the program.
    Percent,
    /// A command to a Grbl control (`$`, `?`, `!`, `~`), no code.
    Command {
        /// Whether it may move the machine: `$H`, `$J=`.
        moves: bool,
    },
    /// Words, at their own places in the line; all else is blanks.
    Words {
        text: String,
        /// The length of the leading blanks and block-delete mark.
        prefix: usize,
    },
}

/// Parses a line of ISO code: blanks out comments and the block-delete mark, words stay in place. `Err` for what no word has.
pub(crate) fn parse_code(line: &[u8]) -> Result<Code, Refusal> {
    let mut text = String::with_capacity(line.len());
    match line.get(blank_len(line)) {
        Some(b'%') => return Ok(Code::Percent),
        Some(b'$') => {
            let moves = line.get(blank_len(line) + 1).is_some_and(|b| matches!(b.to_ascii_uppercase(), b'H' | b'J'));
            return Ok(Code::Command { moves });
        }
        Some(b'?' | b'!' | b'~') => return Ok(Code::Command { moves: false }),
        _ => {}
    }
    let prefix = prefix_len(line);
    text.extend(std::iter::repeat_n(' ', prefix));
    let message = message_start(line, prefix);
    while let Some(&byte) = line.get(text.len()) {
        let at = text.len();
        match byte {
            _ if message.is_some_and(|begin| at >= begin) => text.push(' '),
            b'(' => text.extend(std::iter::repeat_n(' ', comment_length(line, at)?)),
            b';' => text.extend(std::iter::repeat_n(' ', line.len() - at)),
            _ if is_blank(byte) => text.push(' '),
            // A program number, as tapes have it.
            b':' if text.trim().is_empty() && line.get(at + 1).is_some_and(u8::is_ascii_digit) => text.push('O'),
            b'+' | b'-' | b'.' => text.push(char::from(byte)),
            _ if byte.is_ascii_alphanumeric() => text.push(char::from(byte)),
            _ => match corner_rate_length(line, at) {
                0 => return Err(unexpected_byte(line, at)),
                length => text.extend(std::iter::repeat_n(' ', length)),
            },
        }
    }
    Ok(Code::Words { text, prefix })
}

/// Returns the length of the word at byte `at` if it is `,K80` behind G61.1, which says how much of the feed is kept at corners; else 0.
fn corner_rate_length(line: &[u8], at: usize) -> usize {
    let digits = line.get(at + 2..).map_or(0, |rest| rest.iter().take_while(|byte| byte.is_ascii_digit()).count());
    let is_exact = line[..at].windows(5).any(|word| word.eq_ignore_ascii_case(b"G61.1"));
    if is_exact && matches!(line[at..], [b',', b'K' | b'k', ..]) && digits > 0 { 2 + digits } else { 0 }
}

/// Length of the leading blanks and the block-delete mark.
pub(crate) fn prefix_len(line: &[u8]) -> usize {
    let blanks = blank_len(line);
    if !is_deletable(line) {
        return blanks;
    }
    // A digit after the slash is the number of the delete switch.
    blanks + 1 + usize::from(line.get(blanks + 1).is_some_and(u8::is_ascii_digit))
}

/// Returns the index at which the text of a message (M117, M118) begins; `None` if the line has none.
fn message_start(line: &[u8], prefix: usize) -> Option<usize> {
    let digits = |from: usize| line[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let skip = |from: usize| from + line[from..].iter().take_while(|b| is_blank(**b)).count();
    let mut at = prefix;
    if matches!(line.get(at), Some(b'N' | b'n')) {
        at = skip(at + 1 + digits(at + 1));
    }
    let end = at + 4;
    let is_message = line.get(at..end).is_some_and(|word| matches!(&word.to_ascii_uppercase()[..], b"M117" | b"M118"));
    (is_message && digits(end) == 0).then_some(end)
}

/// Whether the line begins with a block-delete mark.
pub(crate) fn is_deletable(line: &[u8]) -> bool {
    first_byte(line) == Some(b'/')
}

/// The first byte that is not blank; `None` in a blank line.
pub(crate) fn first_byte(line: &[u8]) -> Option<u8> {
    line.get(blank_len(line)).copied()
}

/// Length of the leading blanks, with the byte-order mark of a UTF-8 file.
pub(crate) fn blank_len(line: &[u8]) -> usize {
    let mark = if line.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    mark + line[mark..].iter().take_while(|b| is_blank(**b)).count()
}

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Whether `byte` is blank or left by tapes and old file systems: NUL, form feed, reader codes, end of file.
pub(crate) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0 | 0x0b | 0x0c | 0x11..=0x14 | 0x1a)
}

/// Returns the length of the comment that opens at byte `at`: up to the first closing parenthesis, and those that close nested comments.
pub(crate) fn comment_length(line: &[u8], at: usize) -> Result<usize, Refusal> {
    let rest = &line[at..];
    let Some(close) = rest.iter().position(|&b| b == b')') else {
        return Err(Refusal::new(at..line.len(), Fault::OpenComment));
    };
    let mut length = close + 1;
    for _ in 1..rest[..close].iter().filter(|b| **b == b'(').count() {
        let blanks = rest[length..].iter().take_while(|b| is_blank(**b)).count();
        match rest.get(length + blanks) {
            Some(b')') => length += blanks + 1,
            _ => break,
        }
    }
    Ok(length)
}

/// Returns the refusal of the byte at `at`, which cannot be code, and of the text around it.
fn unexpected_byte(line: &[u8], at: usize) -> Refusal {
    let fault = match line[at] {
        // `X=10` is Sinumerik's; in a macro, what is assigned has a `#`.
        b'=' if !line.contains(&b'#') => Fault::Language,
        b'#' | b'[' | b']' | b'=' | b'<' | b'>' => Fault::Variable,
        b'*' => Fault::Checksum,
        b',' => Fault::Unsupported(Unsupported::Corner),
        b'"' => Fault::Language,
        b')' if line[..at].contains(&b'(') => Fault::NestedComment,
        _ => Fault::Character,
    };
    let bounds = |b: &u8| is_blank(*b) || matches!(b, b'(' | b';');
    let start = line[..at].iter().rposition(bounds).map_or(0, |p| p + 1);
    let end = line[at..].iter().position(bounds).map_or(line.len(), |p| at + p);
    Refusal::new(start..end, fault)
}
