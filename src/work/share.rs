//! A share of a computation that several machines compute: part i of n.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

/// Part `i` of `n`: of the pieces of a computation, numbered from 0, those whose number leaves the remainder `i − 1` when divided by `n`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "(u32, u32)", into = "(u32, u32)")]
pub struct Share {
    part: u32,
    of: u32,
}

/// Most parts.
const MOST: u32 = 1_000_000;

impl Share {
    /// Returns the share of part `part` of `of`, counted from 1.
    ///
    /// # Errors
    /// There is no such part; the message says what was expected.
    pub fn new(part: u32, of: u32) -> Result<Self, String> {
        if of == 0 || of > MOST {
            return Err(format!("expected 1 to {MOST} parts, got {of}"));
        }
        if part == 0 || part > of {
            return Err(format!("of {of} expected a part from 1 to {of}, got {part}"));
        }
        Ok(Self { part, of })
    }

    /// Returns the number of the part, from 1.
    #[must_use]
    pub fn part(self) -> u32 {
        self.part
    }

    /// Returns the number of parts.
    #[must_use]
    pub fn of(self) -> u32 {
        self.of
    }

    /// Returns whether piece number `number`, from 0, is in this share.
    #[must_use]
    pub fn holds(self, number: usize) -> bool {
        number % self.of as usize == self.part as usize - 1
    }

    /// Returns how many of the first `pieces` pieces are in this share.
    #[must_use]
    pub fn count(self, pieces: usize) -> usize {
        (pieces + self.of as usize - self.part as usize) / self.of as usize
    }

    /// Returns the beginning of the names of the part's files in round `round`, from 1.
    #[must_use]
    pub fn stem(self, round: u32) -> String {
        let part = format!("part_{:04}_of_{:04}", self.part, self.of);
        if round == 1 { part } else { format!("round_{round:02}_{part}") }
    }
}

impl TryFrom<(u32, u32)> for Share {
    type Error = String;

    fn try_from((part, of): (u32, u32)) -> Result<Self, String> {
        Self::new(part, of)
    }
}

impl From<Share> for (u32, u32) {
    fn from(share: Share) -> Self {
        (share.part, share.of)
    }
}

impl FromStr for Share {
    type Err = String;

    /// Parses a share such as `3/10`.
    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(part, of)| Some((part.parse().ok()?, of.parse().ok()?)));
        let (part, of) = numbers.ok_or("expected i/n such as 3/10: the third of ten parts")?;
        Self::new(part, of)
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.part, self.of)
    }
}
