//! Dialects of G-code: what differs is how the words of a line are found, what they ask for, and how new words look. Words are
//! followed and changed alike.

use crate::toolpath::{
    model::gcode::{Dialect, Fault, GWord, GcodeError, LengthUnit, Refusal, Word},
    read::gcode::{
        lex,
        lines::{self, Code, Lines},
    },
};

pub(crate) mod block_numbers;
mod detect;
mod heidenhain;
mod heidenhain_words;
pub(crate) mod scan;
pub(crate) mod sinumerik;
mod sinumerik_words;

/// Whether all of them are read. The engine of pages, which is to be small, reads ISO alone.
const READS_ALL: bool = !cfg!(target_family = "wasm");

impl Dialect {
    /// What `word`, a G word, asks for.
    pub(crate) fn g_word(self, word: &Word) -> Result<GWord, Refusal> {
        match self {
            Dialect::Sinumerik if READS_ALL => sinumerik_words::g_word(word),
            _ => GWord::of(word, self),
        }
    }

    /// mm in a unit of the feed. Heidenhain's feed is in tenths of an inch.
    pub(crate) fn feed_unit_mm(self, unit: LengthUnit) -> f64 {
        match (self, unit) {
            (Dialect::Heidenhain, LengthUnit::Inch) => 2.54,
            (_, unit) => unit.mm(),
        }
    }

    /// The line that says how many `written` lines stand for the `lines` of a program, and how many lines of `bytes` come before it.
    pub(crate) fn header(self, bytes: &[u8], written: usize, lines: usize) -> (String, usize) {
        let text = format!("written out by kinetostat: {written} lines for {lines}");
        let all = Lines::of(bytes);
        let begins =
            |line: &usize, marks: &[u8]| lines::first(&bytes[all.content(*line)]).is_some_and(|b| marks.contains(&b));
        match self {
            _ if self.is_iso() => (format!("({text})\n"), usize::from(all.len() > 0 && begins(&0, b"%"))),
            Dialect::Sinumerik => {
                (format!("; {text}\n"), (0..all.len()).take_while(|line| begins(line, b"%;")).count())
            }
            _ => {
                // With the number of the block before, from which blocks are then counted on.
                let number = (all.len() > 0).then(|| block_numbers::number(&bytes[all.content(0)])).flatten();
                let number = number.map_or_else(String::new, |(_, number)| format!("{number} "));
                (format!("{number}; {text}\n"), usize::from(all.len() > 0))
            }
        }
    }

    /// A program as it is written, its block numbers rising if the dialect has such.
    pub(crate) fn numbered(self, source: &[u8], written: Vec<u8>) -> Vec<u8> {
        match self {
            Dialect::Heidenhain => block_numbers::rising(source, written),
            _ => written,
        }
    }
}

/// What a line says.
pub(crate) enum Statement {
    /// A `%` that opens or closes the program.
    Percent,
    /// A command to a Grbl control.
    Command {
        /// Whether it may move the machine.
        moves: bool,
    },
    /// Words; all else is kept as it is.
    Words {
        words: Vec<Word>,
        /// Length of what new lines of the block begin with as well.
        prefix: usize,
    },
}

/// Reads lines, one after the other.
pub(crate) enum Language {
    Iso,
    Sinumerik,
    Heidenhain(heidenhain::Reader),
}

impl Language {
    pub fn new(dialect: Dialect) -> Language {
        match dialect {
            Dialect::Sinumerik => Language::Sinumerik,
            Dialect::Heidenhain => Language::Heidenhain(heidenhain::Reader::default()),
            _ => Language::Iso,
        }
    }

    /// What `line` says.
    pub fn statement(&mut self, line: &[u8]) -> Result<Statement, Refusal> {
        match self {
            Language::Sinumerik if READS_ALL => sinumerik::statement(line),
            Language::Heidenhain(reader) if READS_ALL => reader.statement(line),
            _ => match lines::code(line)? {
                Code::Percent => Ok(Statement::Percent),
                Code::Command { moves } => Ok(Statement::Command { moves }),
                Code::Words { text, prefix } => Ok(Statement::Words { words: lex::words(&text)?, prefix }),
            },
        }
    }
}

/// The dialect of `source`: the one `given`, or the one that it shows.
///
/// # Errors
/// One that is not read.
pub(crate) fn chosen(source: &[u8], name: &str, given: Option<Dialect>) -> Result<Dialect, GcodeError> {
    match given {
        Some(dialect) if READS_ALL || dialect.is_iso() => Ok(dialect),
        Some(dialect) => Err(on_first_line(source, name, dialect, Fault::Language)),
        None if READS_ALL => Ok(Dialect::of(source)),
        None => Ok(Dialect::Iso),
    }
}

/// That a program is not in ISO code and cannot be written out.
pub(crate) fn not_written_out(source: &[u8], name: &str, dialect: Dialect) -> GcodeError {
    on_first_line(source, name, dialect, Fault::NotWrittenOut)
}

fn on_first_line(source: &[u8], name: &str, dialect: Dialect, fault: Fault) -> GcodeError {
    let lines = Lines::of(source);
    let first = if lines.len() > 0 { &source[lines.content(0)] } else { &[] };
    Refusal::new(0..first.len(), fault).locate(name, 1, first).read_as(dialect)
}
