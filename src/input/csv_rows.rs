//! The rows of a CSV file, with the bytes and the line each stands on.

use std::ops::Range;

use csv::{ByteRecord, ReaderBuilder, Trim};

/// One row that is not blank.
pub(crate) struct Row {
    /// Its fields, without blanks around them.
    pub fields: ByteRecord,
    /// Its bytes in the file, without line ending.
    pub span: Range<usize>,
}

/// All rows of `source`, the header among them; or the byte where the reader gave up, and why.
pub(crate) fn read(source: &[u8]) -> Result<Vec<Row>, (usize, String)> {
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
    let spans = starts.windows(2).map(|pair| without_endings(source, pair[0]..pair[1]));
    Ok(records.into_iter().zip(spans).map(|(fields, span)| Row { fields, span }).collect())
}

/// `span` without the line endings at either end: the reader counts a row's `\n` to the next row.
fn without_endings(source: &[u8], span: Range<usize>) -> Range<usize> {
    let ending = |b: &u8| matches!(b, b'\r' | b'\n');
    let bytes = &source[span.clone()];
    let Some(first) = bytes.iter().position(|b| !ending(b)) else {
        return span.start..span.start;
    };
    let last = bytes.iter().rposition(|b| !ending(b)).unwrap_or(first);
    span.start + first..span.start + last + 1
}

/// The number, from 1, of the line the byte at `at` is in.
pub(crate) fn line_number(source: &[u8], at: usize) -> usize {
    let ends = |i: &usize| match source[*i] {
        b'\n' => true,
        b'\r' => source.get(i + 1) != Some(&b'\n'),
        _ => false,
    };
    1 + (0..at.min(source.len())).filter(ends).count()
}

/// The same of bytes in ascending order, each the first of its line.
pub(crate) fn line_numbers(source: &[u8], starts: impl Iterator<Item = usize>) -> Vec<usize> {
    let (mut before, mut line) = (0, 1);
    let number = |start: usize| {
        line += line_number(&source[before..start], start - before) - 1;
        before = start;
        line
    };
    starts.map(number).collect()
}
