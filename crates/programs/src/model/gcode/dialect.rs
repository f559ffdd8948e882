//! The dialects of G-code.

use serde::Deserialize;

/// A dialect of G-code, the language of a control.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Dialect {
    /// ISO code, as far as Fanuc, Haas, LinuxCNC and Grbl read it alike.
    #[default]
    Iso,
    /// ISO code of Fanuc.
    Fanuc,
    /// ISO code of Haas.
    Haas,
    /// ISO code of LinuxCNC, whose work offsets Grbl sets alike.
    #[serde(rename = "linuxcnc")]
    LinuxCnc,
    /// Siemens Sinumerik 840D and its kin.
    Sinumerik,
    /// Heidenhain's conversational language (Klartext).
    Heidenhain,
}

impl Dialect {
    /// All of them.
    pub const ALL: [Dialect; 6] =
        [Dialect::Iso, Dialect::Fanuc, Dialect::Haas, Dialect::LinuxCnc, Dialect::Sinumerik, Dialect::Heidenhain];

    /// Whether the dialect is ISO code, of any control.
    #[must_use]
    pub fn is_iso(self) -> bool {
        !matches!(self, Dialect::Sinumerik | Dialect::Heidenhain)
    }

    /// Returns the dialect's name in files and on the command line.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Dialect::Iso => "iso",
            Dialect::Fanuc => "fanuc",
            Dialect::Haas => "haas",
            Dialect::LinuxCnc => "linuxcnc",
            Dialect::Sinumerik => "sinumerik",
            Dialect::Heidenhain => "heidenhain",
        }
    }

    /// Returns the dialect's name in sentences.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Dialect::Iso => "ISO",
            Dialect::Fanuc => "Fanuc",
            Dialect::Haas => "Haas",
            Dialect::LinuxCnc => "LinuxCNC",
            Dialect::Sinumerik => "Sinumerik",
            Dialect::Heidenhain => "Heidenhain",
        }
    }

    /// Returns the ending of messages that names the dialect: ` (read as Fanuc)`; empty for ISO.
    pub(crate) fn message_suffix(self) -> String {
        if self == Dialect::Iso { String::new() } else { format!(" (read as {})", self.name()) }
    }
}
