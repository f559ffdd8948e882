//! Parses TOML files into raw specs, with errors that name file, line and key.

mod reader;

use std::marker::PhantomData;
use std::ops::Range;
use std::path::Path;

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

use crate::error::{Error, Result};

/// A longer file is no machine or study file, bytes.
pub const MAX_LENGTH: u64 = 1 << 20;

/// Reads `file` as UTF-8 text; fails if it is no file, longer than 1 MiB or no text.
pub fn read(file: &Path) -> Result<String> {
    text(crate::file::read_at_most(file, MAX_LENGTH)?, file)
}

/// Decodes the bytes of `file` as UTF-8 text.
pub fn text(bytes: Vec<u8>, file: &Path) -> Result<String> {
    let fault = |_| Error::Read { file: file.to_path_buf(), source: std::io::Error::other("not a text file (UTF-8)") };
    String::from_utf8(bytes).map_err(fault)
}

/// Returns the line, from 1, of the value with the key path `key` in `text`, such as `chain[0].elements[2].beam.length_mm`; where the file
/// leaves it out, that of the innermost table or list around it. `None` if it has none of these.
pub fn line_of(text: &str, key: &str) -> Option<usize> {
    let file = DeTable::parse(text).ok()?.into_inner();
    let mut steps = key.split(['.', '[']);
    let (_, mut value) = file.get_key_value(steps.next()?)?;
    for step in steps {
        let below = match value.get_ref() {
            DeValue::Table(table) => table.get(step),
            DeValue::Array(items) => step.strip_suffix(']').and_then(|index| items.get(index.parse::<usize>().ok()?)),
            _ => None,
        };
        match below {
            Some(inner) => value = inner,
            None => break,
        }
    }
    Some(line_at(text, value.span().start))
}

/// Returns the line, from 1, of the byte `at` of `text`.
fn line_at(text: &str, at: usize) -> usize {
    1 + text[..at.min(text.len())].matches('\n').count()
}

/// Parses `text` as TOML into `T`; errors name it `origin` and have line and key.
pub fn parse<T: DeserializeOwned>(text: &str, origin: &str) -> Result<T> {
    let fault = |message: &str, span: Option<Range<usize>>, key: String| Error::Syntax {
        file: origin.to_string(),
        line: span.as_ref().map(|span| line_at(text, span.start)),
        key,
        problem: toml_message(message, span.and_then(|span| text.get(span)).unwrap_or_default()),
    };
    let table = DeTable::parse(text).map_err(|error| fault(error.message(), error.span(), String::new()))?;
    let read = reader::Reader::from(table).read(PhantomData);
    read.map_err(|error| fault(&error.to_string(), error.span(), error.key()))
}

/// Rewrites a parser's message about the text `place` in the terms of TOML files instead of programming terms.
fn toml_message(message: &str, place: &str) -> String {
    let message = message.trim_end().replace('\n', "; ");
    if message == "duplicate key" {
        return format!("key `{place}` is given twice");
    }
    let (problem, expected) = message.split_once(", expected ").unwrap_or((&message, ""));
    let problem = problem
        .replace("unknown variant", "unknown value")
        .replace("unknown field", "unknown key")
        .replace("missing field", "missing key")
        .replace("invalid type: map", "invalid type: table");
    match expected {
        "" => problem,
        "a string" => format!("{problem}, expected a text in quotes"),
        "f64" => format!("{problem}, expected a number"),
        "u32" | "usize" => format!("{problem}, expected a whole number, 0 or more"),
        table if table.starts_with("struct ") => format!("{problem}, expected a table"),
        other => format!("{problem}, expected {other}"),
    }
}
