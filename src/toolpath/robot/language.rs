//! The languages programs of poses are written in.

use std::path::Path;

/// A language that programs of poses are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// KUKA Robot Language.
    Krl,
    /// RAPID of ABB.
    Rapid,
    /// APT, and the CLDATA of CAM systems as text.
    Apt,
}

impl Language {
    /// The language of a file, as its name ends and, where other programs have such names too, as its first words are;
    /// `None` for what is no program of poses.
    #[must_use]
    pub fn of(file: &Path, bytes: &[u8]) -> Option<Language> {
        let extension = file.extension()?.to_string_lossy().to_ascii_lowercase();
        match extension.as_str() {
            "src" => Some(Language::Krl),
            "apt" | "cl" | "cls" | "ncl" | "cldata" => Some(Language::Apt),
            "modx" => Some(Language::Rapid),
            "mod" | "prg" => {
                first_words(bytes).any(|word| matches!(word.as_str(), "MODULE" | "PROC")).then_some(Language::Rapid)
            }
            _ => None,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Language::Krl => "KRL",
            Language::Rapid => "RAPID",
            Language::Apt => "APT",
        }
    }

    /// What its programs are called in `language` of reports.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Language::Krl => "krl",
            Language::Rapid => "rapid",
            Language::Apt => "apt",
        }
    }
}

/// The first words of lines, in capitals.
fn first_words(bytes: &[u8]) -> impl Iterator<Item = String> {
    bytes.split(|byte| matches!(byte, b'\n' | b'\r')).map(|line| {
        let line = line.trim_ascii_start();
        let end = line.iter().position(|byte| !byte.is_ascii_alphanumeric()).unwrap_or(line.len());
        String::from_utf8_lossy(&line[..end]).to_ascii_uppercase()
    })
}
