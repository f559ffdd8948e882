//! TOML files to raw specs, with errors that name file, line and key.

#[cfg(not(target_family = "wasm"))]
mod exact;
#[cfg(any(test, target_family = "wasm"))]
mod plain;

use std::path::Path;

#[cfg(target_family = "wasm")]
use serde::Deserialize as _;
use serde::de::DeserializeOwned;

use crate::input::error::{Error, Result};

/// A longer file is no machine or study file, bytes.
#[cfg(feature = "study")]
pub(crate) const MAX_LENGTH: u64 = 1 << 20;

/// Reads `file` as text.
#[cfg(feature = "study")]
pub fn read(file: &Path) -> Result<String> {
    text(crate::input::file::read_at_most(file, MAX_LENGTH)?, file)
}

/// The text that `bytes` of `file` are.
pub fn text(bytes: Vec<u8>, file: &Path) -> Result<String> {
    let fault = |_| Error::Read { file: file.to_path_buf(), source: std::io::Error::other("not a text file (UTF-8)") };
    String::from_utf8(bytes).map_err(fault)
}

/// Parses `text`; `origin` names it in error messages.
pub fn parse<T: DeserializeOwned>(text: &str, origin: &str) -> Result<T> {
    let fault = |error: &toml::de::Error, key: String| Error::Syntax {
        file: origin.to_string(),
        line: error.span().map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count()),
        key,
        problem: in_words(error, text),
    };
    let deserializer = toml::Deserializer::parse(text).map_err(|error| fault(&error, String::new()))?;
    #[cfg(target_family = "wasm")]
    return in_page(deserializer).map_err(|problem| Error::Syntax {
        file: origin.to_string(),
        line: None,
        key: String::new(),
        problem,
    });
    #[cfg(not(target_family = "wasm"))]
    serde_path_to_error::deserialize(exact::Exact(deserializer)).map_err(|error| {
        let key = error.path().to_string();
        fault(error.inner(), key)
    })
}

/// What a page reads the program has read before: without lines and keys in messages the engine is much shorter.
#[cfg(target_family = "wasm")]
fn in_page<T: DeserializeOwned>(deserializer: toml::Deserializer<'_>) -> std::result::Result<T, String> {
    let table = toml::Table::deserialize(deserializer).map_err(|fault| fault.to_string())?;
    T::deserialize(plain::Plain(toml::Value::Table(table))).map_err(|fault| fault.to_string())
}

/// The parser's message, its programming terms replaced by those of a TOML file.
fn in_words(error: &toml::de::Error, text: &str) -> String {
    let message = error.message().trim_end().replace('\n', "; ");
    if message == "duplicate key" {
        let key = error.span().and_then(|span| text.get(span)).unwrap_or_default();
        return format!("key `{key}` is given twice");
    }
    if message.starts_with("wanted exactly 1 element") {
        return "expected a table with exactly one key".into();
    }
    let (found, expected) = message.split_once(", expected ").unwrap_or((&message, ""));
    let found = found
        .replace("unknown variant", "unknown value")
        .replace("unknown field", "unknown key")
        .replace("missing field", "missing key")
        .replace("invalid type: map", "invalid type: table")
        .replace("wanted string or table", "wrong type, expected a word in quotes or a table");
    match expected {
        "" => found,
        "a string" => format!("{found}, expected a text in quotes"),
        "f64" => format!("{found}, expected a number"),
        "u32" | "usize" => format!("{found}, expected a whole number, 0 or more"),
        table if table.starts_with("struct ") => format!("{found}, expected a table"),
        other => format!("{found}, expected {other}"),
    }
}
