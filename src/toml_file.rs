//! TOML text to raw specs, with errors that name file, line and key.

use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

/// Parses `text`; `origin` names it in error messages.
pub fn parse<T: DeserializeOwned>(text: &str, origin: &str) -> Result<T> {
    let fault = |error: &toml::de::Error, key: String| Error::Syntax {
        file: origin.to_string(),
        line: error.span().map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count()),
        key,
        problem: error.message().trim_end().replace('\n', "; "),
    };
    let deserializer = toml::Deserializer::parse(text).map_err(|error| fault(&error, String::new()))?;
    serde_path_to_error::deserialize(deserializer).map_err(|error| {
        let key = error.path().to_string();
        fault(error.inner(), key)
    })
}
