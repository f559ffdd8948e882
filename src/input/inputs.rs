//! The inputs that results were computed from, their hash, and what changed in them.

use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Everything that decides results, as names and texts: files as they were read, and what the command line set.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Inputs(Vec<(String, String)>);

/// Longest part of a line that is quoted.
const QUOTED: usize = 100;

impl Inputs {
    /// Creates the inputs of one file, named by the last part of its path `origin`.
    pub(crate) fn of_file(origin: &str, text: &str) -> Self {
        let name =
            Path::new(origin).file_name().map_or_else(|| origin.into(), |name| name.to_string_lossy().into_owned());
        Self::of(name, text)
    }

    /// Creates the inputs of one text called `name`.
    pub fn of(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self(vec![(name.into(), text.into())])
    }

    /// Creates the inputs of one file of bytes called `name`: the SHA-256 of these stands for a text.
    pub(crate) fn of_bytes(name: &str, bytes: &[u8]) -> Self {
        Self::of(name, format!("SHA-256 {}", to_hex(&Sha256::digest(bytes))))
    }

    /// Returns these inputs followed by `others`.
    #[must_use]
    pub fn and(mut self, others: Inputs) -> Self {
        self.0.extend(others.0);
        self
    }

    /// Iterates over names and texts.
    pub fn texts(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(name, text)| (name.as_str(), text.as_str()))
    }

    /// Returns the SHA-256 of all texts together, hexadecimal; names do not count.
    pub fn sha256(&self) -> String {
        let mut hasher = Sha256::new();
        for (_, text) in &self.0 {
            hasher.update((text.len() as u64).to_le_bytes());
            hasher.update(text);
        }
        to_hex(&hasher.finalize())
    }

    /// Returns each name with the SHA-256 of its text, hexadecimal.
    pub(crate) fn digests(&self) -> Vec<(String, String)> {
        self.0.iter().map(|(name, text)| (name.clone(), to_hex(&Sha256::digest(text)))).collect()
    }

    /// Returns the names, each once, joined by commas.
    fn names(&self) -> String {
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in &self.0 {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        names.join(", ")
    }

    /// Describes in words the first difference of these inputs from `before`: in their names or in a line; `None` if they are the same.
    pub fn change_since(&self, before: &Inputs) -> Option<String> {
        if !self.0.iter().map(|(name, _)| name).eq(before.0.iter().map(|(name, _)| name)) {
            return Some(format!("the inputs were {}, and are {}", before.names(), self.names()));
        }
        let mut pairs = self.0.iter().zip(&before.0);
        let ((name, now), (_, before)) = pairs.find(|(now, before)| now != before)?;
        let mut lines = (now.lines().map(Some).chain([None])).zip(before.lines().map(Some).chain([None]));
        let Some((number, (now, before))) = lines.by_ref().enumerate().find(|(_, (now, before))| now != before) else {
            return Some(format!("{name}: the ends of its lines differ"));
        };
        let quoted = |line: Option<&str>| match line {
            Some(line) if line.chars().count() > QUOTED => {
                format!("`{}…`", line.chars().take(QUOTED).collect::<String>())
            }
            Some(line) => format!("`{line}`"),
            None => "the end".into(),
        };
        Some(format!("{name}, line {}: was {}, is {}", number + 1, quoted(before), quoted(now)))
    }
}

/// Formats bytes as hexadecimal digits.
pub(crate) fn to_hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
