//! Dialects of G-code: how the words of a line are found, what they mean, and how new words look.

use crate::{
    model::gcode::{Dialect, Fault, GWord, GcodeError, LengthUnit, Refusal, Unsupported, Word},
    read::gcode::{
        lex,
        lines::{self, Code, Lines},
    },
};

pub(crate) mod block_numbers;
mod detect;
mod heidenhain;
mod heidenhain_plane;
mod heidenhain_words;
pub(crate) mod scan;
pub(crate) mod sinumerik;
pub(crate) mod sinumerik_words;

/// Whether all dialects are read. The engine of pages is small and reads ISO alone.
const READS_ALL: bool = !cfg!(target_family = "wasm");

impl Dialect {
    /// Returns the meaning of `word`, a G word, in this dialect; `Err` if it is refused.
    pub(crate) fn g_word(self, word: &Word) -> Result<GWord, Refusal> {
        match self {
            Dialect::Sinumerik if READS_ALL => sinumerik_words::g_word(word),
            _ => GWord::parse(word, self),
        }
    }

    /// Returns the unit of the feed in a program with the unit `unit`, mm; Heidenhain's is 0.1 inch in inch programs.
    pub(crate) fn feed_unit_mm(self, unit: LengthUnit) -> f64 {
        match (self, unit) {
            (Dialect::Heidenhain, LengthUnit::Inch) => 2.54,
            (_, unit) => unit.mm(),
        }
    }

    /// Returns the comment that `written` lines stand for a program of `lines` lines, and the number of lines of `bytes` before it.
    pub(crate) fn header(self, bytes: &[u8], written: usize, lines: usize) -> (String, usize) {
        let text = format!("written out by kinetostat: {written} lines for {lines}");
        let all = Lines::split(bytes);
        let begins_with = |line: &usize, marks: &[u8]| {
            lines::first_byte(&bytes[all.content(*line)]).is_some_and(|b| marks.contains(&b))
        };
        match self {
            _ if self.is_iso() => (format!("({text})\n"), usize::from(all.len() > 0 && begins_with(&0, b"%"))),
            Dialect::Sinumerik => {
                (format!("; {text}\n"), (0..all.len()).take_while(|line| begins_with(line, b"%;")).count())
            }
            _ => {
                // With the number of the block before, from which blocks are then counted on.
                let number = (all.len() > 0).then(|| block_numbers::leading_number(&bytes[all.content(0)])).flatten();
                let number = number.map_or_else(String::new, |(_, number)| format!("{number} "));
                (format!("{number}; {text}\n"), usize::from(all.len() > 0))
            }
        }
    }

    /// Returns `written` with rising block numbers, if the dialect has them; `source` is the program as it was.
    pub(crate) fn renumbered(self, source: &[u8], written: Vec<u8>) -> Vec<u8> {
        match self {
            Dialect::Heidenhain => block_numbers::renumber_blocks(source, written),
            _ => written,
        }
    }
}

/// Content of a line: words, a `%`, or a command to the control.
pub(crate) enum Statement {
    /// A `%` that opens or closes the program.
    Percent,
    /// A command to a Grbl control.
    Command {
        /// Whether it may move the machine.
        moves: bool,
    },
    /// Words; all else stays as it is.
    Words {
        words: Vec<Word>,
        /// Length of what new lines of the block begin with too.
        prefix: usize,
    },
}

/// A reader of lines in one dialect.
pub(crate) enum LineReader {
    Iso,
    Sinumerik {
        /// Whether words of contours are returned, not refused.
        follows_contours: bool,
    },
    Heidenhain(heidenhain::Reader),
}

impl LineReader {
    /// Starts before the first line.
    pub fn new(dialect: Dialect) -> LineReader {
        match dialect {
            Dialect::Sinumerik => LineReader::Sinumerik { follows_contours: false },
            Dialect::Heidenhain => LineReader::Heidenhain(heidenhain::Reader::default()),
            _ => LineReader::Iso,
        }
    }

    /// Starts before the first line of a program whose contours are written out: their words are returned as well.
    pub fn of_contours(dialect: Dialect) -> LineReader {
        match dialect {
            Dialect::Heidenhain => LineReader::Heidenhain(heidenhain::Reader::of_contours()),
            _ => LineReader::Sinumerik { follows_contours: true },
        }
    }

    /// Parses the next line into words, a `%` or a command; `Err` for what is not followed.
    pub fn parse_line(&mut self, line: &[u8]) -> Result<Statement, Refusal> {
        match self {
            LineReader::Sinumerik { follows_contours } if READS_ALL => sinumerik::parse_line(line, *follows_contours),
            LineReader::Heidenhain(reader) if READS_ALL => reader.parse_line(line),
            _ => match lines::parse_code(line)? {
                Code::Percent => Ok(Statement::Percent),
                Code::Command { moves } => Ok(Statement::Command { moves }),
                Code::Words { text, prefix } => Ok(Statement::Words { words: lex::words(&text)?, prefix }),
            },
        }
    }
}

/// Returns the dialect of `source`: the one `given`, or the one that its text shows. `Err`, with the program's `name`, if it is not read.
pub(crate) fn resolve_dialect(source: &[u8], name: &str, given: Option<Dialect>) -> Result<Dialect, GcodeError> {
    match given {
        Some(dialect) if READS_ALL || dialect.is_iso() => Ok(dialect),
        Some(dialect) => Err(first_line_error(source, name, dialect, Fault::Language)),
        None if detect::is_okuma(source) => {
            Err(first_line_error(source, name, Dialect::Iso, Fault::Unsupported(Unsupported::Okuma)))
        }
        None if detect::is_din_iso(source) => {
            Err(first_line_error(source, name, Dialect::Iso, Fault::Unsupported(Unsupported::DinIso)))
        }
        None if READS_ALL => Ok(Dialect::detect(source)),
        None => Ok(Dialect::Iso),
    }
}

/// Returns the error that `fault` is on the first line of `source`.
fn first_line_error(source: &[u8], name: &str, dialect: Dialect, fault: Fault) -> GcodeError {
    let lines = Lines::split(source);
    let first = if lines.len() > 0 { &source[lines.content(0)] } else { &[] };
    Refusal::new(0..first.len(), fault).locate(name, 1, first).with_dialect(dialect)
}
