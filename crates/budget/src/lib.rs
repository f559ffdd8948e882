//! What a verdict on a machined part rests on: causes of error with their values, bounds and sources, and when "within tolerance" may be said.

use serde::{Deserialize, Serialize};

/// Why a tool or a machined surface is not where it should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// Deflection by the cutting force, as computed.
    Force,
    /// Deflection by the weight of the machine itself.
    Weight,
    /// How well that force is known.
    ForceUncertainty,
    /// How well stiffnesses and the model are known.
    Stiffness,
    /// Geometric errors of the chains, or what a calibration leaves of them.
    Geometry,
    /// How far the control leads the unloaded machine from where it is commanded.
    Accuracy,
    /// How far one pass is from the mean of many.
    Repeatability,
    /// Backlash of the drives where they reverse.
    Backlash,
    /// Digits of the program as written.
    Rounding,
    /// Expansion of machine, tool and part by heat.
    Heat,
    /// Bodies that meet: holder, clamps, wrist, part.
    Bodies,
    /// Vibration.
    Vibration,
}

impl Cause {
    /// All, in the order in which they are told.
    pub const ALL: [Self; 12] = [
        Self::Force,
        Self::Weight,
        Self::ForceUncertainty,
        Self::Stiffness,
        Self::Geometry,
        Self::Accuracy,
        Self::Repeatability,
        Self::Backlash,
        Self::Rounding,
        Self::Heat,
        Self::Bodies,
        Self::Vibration,
    ];

    /// All, those first that are wont to be large and are easily found out about: what to ask about first where nobody knows.
    pub const BY_SIZE: [Self; 12] = [
        Self::Force,
        Self::Accuracy,
        Self::Stiffness,
        Self::ForceUncertainty,
        Self::Geometry,
        Self::Weight,
        Self::Backlash,
        Self::Repeatability,
        Self::Heat,
        Self::Bodies,
        Self::Vibration,
        Self::Rounding,
    ];

    /// Returns what readers call it.
    pub fn text(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::Weight => "weight",
            Self::ForceUncertainty => "force uncertainty",
            Self::Stiffness => "stiffness",
            Self::Geometry => "geometry",
            Self::Accuracy => "accuracy",
            Self::Repeatability => "repeatability",
            Self::Backlash => "backlash",
            Self::Rounding => "rounding",
            Self::Heat => "heat",
            Self::Bodies => "bodies",
            Self::Vibration => "vibration",
        }
    }
}

/// How a cause is known; what is known worse is larger.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// Measured or bounded.
    Full,
    /// By a data sheet, a catalogue, a default or an assumption.
    Half,
    /// Not assessed.
    Hollow,
}

impl Mark {
    /// Returns its sign.
    pub fn sign(self) -> char {
        match self {
            Self::Full => '●',
            Self::Half => '◐',
            Self::Hollow => '○',
        }
    }
}

/// What is known of a cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// The cause.
    pub cause: Cause,
    /// How it is known.
    pub mark: Mark,
    /// Its millimetres where they are known by themselves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mm: Option<f64>,
    /// Whether they are in the number that is judged; else they are added to it.
    pub counted: bool,
    /// Where this is from, in a few words.
    pub source: String,
}

impl Entry {
    /// Returns a cause that is in the number that is judged.
    pub fn counted(cause: Cause, mark: Mark, source: impl Into<String>) -> Self {
        Self { cause, mark, mm: None, counted: true, source: source.into() }
    }

    /// Returns a cause that adds at most `mm` to the number that is judged.
    pub fn bound(cause: Cause, mm: f64, mark: Mark, source: impl Into<String>) -> Self {
        Self { cause, mark, mm: Some(mm), counted: false, source: source.into() }
    }

    /// Returns a cause that nobody knows; `source` says what is missing.
    pub fn unknown(cause: Cause, source: impl Into<String>) -> Self {
        Self { cause, mark: Mark::Hollow, mm: None, counted: false, source: source.into() }
    }

    /// Returns this entry as known in part: its millimetres count, and nobody knows what is added; `what` is missing.
    #[must_use]
    pub fn lacking(self, what: &str) -> Self {
        Self { mark: Mark::Hollow, source: format!("{what}: {}", self.source), ..self }
    }

    /// Returns this entry with its millimetres, which are in the number that is judged.
    #[must_use]
    pub fn of_mm(mut self, mm: f64) -> Self {
        self.mm = Some(mm);
        self
    }

    /// Returns this entry with a `bound` of the same cause, which comes on top of what is known of it.
    #[must_use]
    pub fn plus(self, bound: Self) -> Self {
        let own_mm = self.mm.filter(|_| !self.counted);
        let mm = [own_mm, bound.mm].into_iter().flatten().reduce(|own, more| own + more);
        let mark = if self.mark == Mark::Hollow { bound.mark } else { self.mark.max(bound.mark) };
        Self { mark, mm, counted: false, source: bound.source, ..self }
    }

    /// Returns what is known by this and another entry of one cause, which both count: what is known worse, and the larger of their millimetres.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let mm = [self.mm, other.mm].into_iter().flatten().reduce(f64::max);
        let counted = self.counted && other.counted;
        let worse = if other.mark > self.mark { other } else { self };
        Self { mm, counted, ..worse }
    }

    /// Returns mark, name and millimetres.
    pub fn text(&self) -> String {
        let more = if self.mark == Mark::Hollow { "\u{a0}or\u{a0}more" } else { "" };
        let mm = self.mm.map_or_else(String::new, |mm| format!("\u{a0}{mm:.3}\u{a0}mm{more}"));
        format!("{}\u{a0}{}{mm}", self.mark.sign(), self.cause.text().replace(' ', "\u{a0}"))
    }
}

/// What is known of every cause, and about which the reader asks.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// An entry for each cause at most.
    entries: Vec<Entry>,
    /// The causes that are asked about; all if `None`.
    scope: Option<Vec<Cause>>,
}

/// What may be said of a number that is judged.
#[derive(Debug, Clone, PartialEq)]
pub enum Decision {
    /// All causes that are asked about have a value or a bound, and fit.
    Within {
        /// The number and all bounds, mm.
        used_mm: f64,
    },
    /// What is known fits, and nobody knows the rest.
    NotDecided {
        /// The number and all bounds, mm.
        used_mm: f64,
        /// What nobody knows.
        unknown: Vec<Cause>,
    },
    /// What is known does not fit.
    Out {
        /// The number and all bounds, mm.
        used_mm: f64,
    },
}

impl Budget {
    /// Sets what is known of a cause, in place of what was.
    pub fn set(&mut self, entry: Entry) {
        self.entries.retain(|own| own.cause != entry.cause);
        self.entries.push(entry);
        self.entries.sort_by_key(|own| own.cause);
    }

    /// Asks about these causes alone.
    #[must_use]
    pub fn within(mut self, scope: Option<Vec<Cause>>) -> Self {
        self.scope = scope;
        self
    }

    /// Returns the causes that are asked about; `None` where these are all.
    pub fn scope(&self) -> Option<&[Cause]> {
        self.scope.as_deref()
    }

    /// Returns what is known, in the order of [`Cause::ALL`], of the causes that are asked about.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(|own| self.asks_about(own.cause))
    }

    /// Returns the causes that are asked about and nobody knows, in the order of [`Cause::BY_SIZE`].
    pub fn unknown(&self) -> Vec<Cause> {
        let is_known = |cause: Cause| self.entries.iter().any(|own| own.cause == cause && own.mark != Mark::Hollow);
        Cause::BY_SIZE.into_iter().filter(|cause| self.asks_about(*cause) && !is_known(*cause)).collect()
    }

    /// Returns the sum of the bounds that are not in the number that is judged, mm.
    pub fn bounds_mm(&self) -> f64 {
        self.entries().filter(|own| !own.counted).filter_map(|own| own.mm).sum()
    }

    /// Decides on the number `judged_mm`, a deviation that is held to `tolerance_mm`: it and all bounds together.
    pub fn decide(&self, judged_mm: f64, tolerance_mm: f64) -> Decision {
        let used_mm = judged_mm + self.bounds_mm();
        let unknown = self.unknown();
        match used_mm <= tolerance_mm {
            false => Decision::Out { used_mm },
            true if unknown.is_empty() => Decision::Within { used_mm },
            true => Decision::NotDecided { used_mm, unknown },
        }
    }

    /// Returns what is known of two parts of the same work together: of each cause, what is known worse.
    #[must_use]
    pub fn worse(mut self, other: Self) -> Self {
        for theirs in other.entries {
            let own = self.entries.iter().find(|own| own.cause == theirs.cause).cloned();
            self.set(own.map_or_else(|| theirs.clone(), |own| own.and(theirs.clone())));
        }
        self.scope = match (self.scope, other.scope) {
            (Some(own), Some(theirs)) => {
                Some(Cause::ALL.into_iter().filter(|cause| own.contains(cause) || theirs.contains(cause)).collect())
            }
            _ => None,
        };
        self
    }

    fn asks_about(&self, cause: Cause) -> bool {
        self.scope.as_ref().is_none_or(|own| own.contains(&cause))
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
