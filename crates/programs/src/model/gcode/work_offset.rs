//! Work offsets (G54 and the like) and their names in all dialects.

use std::{fmt, str::FromStr};

/// A work offset of a control, such as G54 or G54.1 P5; it is displayed by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct WorkOffset(Name);

/// The dialect's way to name a work offset, with its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Name {
    /// G54 to G59, G59.1 to G59.3, from 1 to 9 as G10 counts them.
    Own(u8),
    /// G54.1 P1 and so on, G110 to G129 of Haas.
    Extended(u16),
    /// Sinumerik's G500, G505 to G599.
    Settable(u16),
    /// Those of Heidenhain's preset table.
    Preset(u32),
    /// G15 H1 and so on, of Okuma.
    Numbered(u16),
}

/// The most that G54.1 P goes to.
const MAX_EXTENDED: u16 = 300;

impl WorkOffset {
    /// G54.
    pub const G54: WorkOffset = WorkOffset(Name::Own(1));

    /// Returns the work offset that G10 calls P`number`: 1 for G54 to 9 for G59.3; `None` for any other number.
    #[must_use]
    pub fn from_g10_number(number: u32) -> Option<WorkOffset> {
        u8::try_from(number).ok().filter(|number| (1..=9).contains(number)).map(|number| WorkOffset(Name::Own(number)))
    }

    /// Returns the work offset G54.1 P`number`; `None` unless `number` is 1 to 300.
    #[must_use]
    pub fn extended(number: u32) -> Option<WorkOffset> {
        let number = u16::try_from(number).ok().filter(|number| (1..=MAX_EXTENDED).contains(number));
        number.map(|number| WorkOffset(Name::Extended(number)))
    }

    /// Returns Sinumerik's work offset G`number`; `None` unless it is G500 or one of G505 to G599.
    pub(crate) fn settable(number: u32) -> Option<WorkOffset> {
        let number = u16::try_from(number).ok().filter(|number| matches!(number, 500 | 505..=599));
        number.map(|number| WorkOffset(Name::Settable(number)))
    }

    /// Returns the work offset in line `number` of Heidenhain's preset table.
    pub(crate) fn preset(number: u32) -> WorkOffset {
        WorkOffset(Name::Preset(number))
    }

    /// Returns the ending of a message that names what in the program could define the work offset; empty if nothing can.
    pub(crate) fn program_source_hint(self) -> &'static str {
        match self.0 {
            Name::Own(_) | Name::Extended(_) | Name::Numbered(_) => ", or G10 L2 for both",
            Name::Settable(_) | Name::Preset(_) => "",
        }
    }

    /// Returns Okuma's work offset G15 H`number`; `None` unless `number` is 1 to 300.
    #[must_use]
    pub fn okuma(number: u32) -> Option<WorkOffset> {
        let number = u16::try_from(number).ok().filter(|number| (1..=MAX_EXTENDED).contains(number));
        number.map(|number| WorkOffset(Name::Numbered(number)))
    }

    /// Whether the work offset is one of G54 to G59, which have keys of their own in process files.
    pub fn has_own_key(self) -> bool {
        matches!(self.0, Name::Own(1..=6))
    }

    /// Returns the work offset that a G word selects, from its number in tenths (540 for G54); `None` if it is no such word.
    pub(crate) fn from_g_tenths(tenths: u32) -> Option<WorkOffset> {
        match tenths {
            540 | 550 | 560 | 570 | 580 | 590 => WorkOffset::from_g10_number((tenths - 530) / 10),
            591..=593 => WorkOffset::from_g10_number(tenths - 584),
            1100..=1290 if tenths.is_multiple_of(10) => WorkOffset::extended((tenths - 1090) / 10),
            _ => None,
        }
    }
}

impl fmt::Display for WorkOffset {
    /// Writes the name by which programs call the work offset, such as `G54.1 P5`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Name::Own(number @ 1..=6) => write!(f, "G{}", 53 + number),
            Name::Own(number) => write!(f, "G59.{}", number - 6),
            Name::Extended(number) => write!(f, "G54.1 P{number}"),
            Name::Settable(number) => write!(f, "G{number}"),
            Name::Preset(number) => write!(f, "preset {number}"),
            Name::Numbered(number) => write!(f, "G15 H{number}"),
        }
    }
}

impl FromStr for WorkOffset {
    type Err = ();

    /// Parses a work offset's displayed name.
    fn from_str(name: &str) -> Result<WorkOffset, ()> {
        let number = |prefix: &str| name.strip_prefix(prefix).and_then(|number| number.parse().ok());
        let okuma = || number("G15 H").and_then(WorkOffset::okuma);
        let settable = || number("G").and_then(WorkOffset::settable);
        let others = || number("preset ").map(WorkOffset::preset).or_else(okuma).or_else(settable);
        let found = match number("G54.1 P").and_then(WorkOffset::extended).or_else(others) {
            Some(offset) => Some(offset),
            None => (1..=9).filter_map(WorkOffset::from_g10_number).find(|offset| offset.to_string() == name),
        };
        found.ok_or(())
    }
}
