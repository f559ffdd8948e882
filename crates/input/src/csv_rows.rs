//! The rows of a CSV file, with their bytes and line numbers.

use std::ops::Range;

use csv::{ByteRecord, ReaderBuilder, Trim};
use thiserror::Error;

/// A row of a CSV file that is not blank.
pub struct Row {
    /// The fields, without blanks around them.
    pub fields: ByteRecord,
    /// The row's bytes in the file, without line ending.
    pub span: Range<usize>,
    /// Number of its first line, from 1.
    pub line: usize,
}

/// Why the rows of a file cannot be read as values; the message says what was expected.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RowFault {
    /// The CSV reader could not make out the row.
    #[error("{reason}; expected comma-separated values")]
    NotCsv {
        /// What it says.
        reason: String,
    },
    /// A row with more or fewer values than the header has columns.
    #[error("{found} values; expected {expected}, as many as columns in the header")]
    Width {
        /// Values in the row.
        found: usize,
        /// Columns in the header.
        expected: usize,
    },
    /// A value that its column cannot hold.
    #[error("{column} = `{value}`; expected {expected}")]
    Value {
        /// The column's name.
        column: String,
        /// The value as written.
        value: String,
        /// What the column holds.
        expected: &'static str,
    },
}

/// Reads all rows of `source`, the header included; `Err` has the byte where it cannot be parsed, and the reason.
pub fn read(source: &[u8]) -> Result<Vec<Row>, (usize, String)> {
    let mut reader = ReaderBuilder::new().has_headers(false).flexible(true).trim(Trim::All).from_reader(source);
    let mut records = Vec::new();
    let mut starts = Vec::new();
    for record in reader.byte_records() {
        let start = starts.last().copied().unwrap_or(0);
        let record = record.map_err(|e| (start, e.to_string()))?;
        starts.push(record.position().map_or(start, |p| usize::try_from(p.byte()).unwrap_or(start)));
        records.push(record);
    }
    starts.push(source.len());
    let spans: Vec<Range<usize>> = starts.windows(2).map(|pair| trim_endings(source, pair[0]..pair[1])).collect();
    let lines = line_numbers(source, spans.iter().map(|span| span.start));
    let rows = records.into_iter().zip(spans).zip(lines);
    Ok(rows.map(|((fields, span), line)| Row { fields, span, line }).collect())
}

/// Returns `span` without line endings at either end: the CSV reader counts a row's `\n` to the next row.
fn trim_endings(source: &[u8], span: Range<usize>) -> Range<usize> {
    let ending = |b: &u8| matches!(b, b'\r' | b'\n');
    let bytes = &source[span.clone()];
    let Some(first) = bytes.iter().position(|b| !ending(b)) else {
        return span.start..span.start;
    };
    let last = bytes.iter().rposition(|b| !ending(b)).unwrap_or(first);
    span.start + first..span.start + last + 1
}

/// Returns the number, from 1, of the line that contains byte `at`.
pub fn line_number(source: &[u8], at: usize) -> usize {
    let ends = |i: &usize| match source[*i] {
        b'\n' => true,
        b'\r' => source.get(i + 1) != Some(&b'\n'),
        _ => false,
    };
    1 + (0..at.min(source.len())).filter(ends).count()
}

/// Returns the line numbers, from 1, of bytes in ascending order, each the first of its line.
pub fn line_numbers(source: &[u8], starts: impl Iterator<Item = usize>) -> Vec<usize> {
    let (mut before, mut line) = (0, 1);
    let number = |start: usize| {
        line += line_number(&source[before..start], start - before) - 1;
        before = start;
        line
    };
    starts.map(number).collect()
}
