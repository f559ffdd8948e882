//! Sources of error, and the machines that answer for them: how any question asks for cutting, chain errors and both.

use serde::Serialize;

use crate::{
    compensation::{CompensationSettings, Demand, Session},
    machine::{ChainError, Machine},
    spatial::Wrench,
    statics::{self, Batch},
};

/// What makes the tool leave its path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The cutting force on the nominal machine.
    Cutting,
    /// The chain errors of the unloaded real machine.
    Assembly,
    /// Both at once: the cutting force on the real machine.
    Both,
}

impl Source {
    /// All sources, in table order.
    pub const ALL: [Source; 3] = [Source::Cutting, Source::Assembly, Source::Both];

    /// Word used in tables.
    pub fn label(self) -> &'static str {
        match self {
            Source::Cutting => "cutting",
            Source::Assembly => "assembly",
            Source::Both => "both",
        }
    }
}

/// The nominal machine, by which commands are computed, and the real one, which has the errors.
#[derive(Debug, Clone)]
pub struct Machines {
    /// Commands, and answers for the cutting force alone.
    pub nominal: Machine,
    /// Answers for all that chain errors have a part in.
    pub real: Machine,
}

impl Machines {
    /// `nominal`, and the same with `errors` of each chain.
    pub fn new(nominal: &Machine, errors: &[ChainError]) -> Self {
        Self { nominal: nominal.clone(), real: nominal.with_errors(errors) }
    }

    /// The machine that answers for `source`.
    pub fn answering(&self, source: Source) -> &Machine {
        match source {
            Source::Cutting => &self.nominal,
            Source::Assembly | Source::Both => &self.real,
        }
    }

    /// A session that answers for `source`, standing at home.
    pub fn session(&self, source: Source) -> Session {
        Session::new(&self.nominal, self.answering(source), settings())
    }

    /// Storage for many cases of what answers for `source`.
    pub(crate) fn batch(&self, source: Source) -> Batch {
        Batch::new(self.answering(source))
    }
}

impl Source {
    /// `demand` as this source makes it: chain errors act alone without load.
    pub fn demand(self, demand: &Demand) -> Demand {
        match self {
            Source::Assembly => Demand { load: Wrench::zero(), ..*demand },
            Source::Cutting | Source::Both => *demand,
        }
    }
}

/// With what questions compensate: to 3e-12 of the machine's reach, 1e-9 mm on the Orthoglide.
pub fn settings() -> CompensationSettings {
    CompensationSettings::with_equilibria_to(1e-12)
}

/// With what questions ask for small differences between equilibria: converged to rounding.
pub(crate) const TO_ROUNDING: statics::Settings = statics::Settings { tolerance: 1e-13, max_iterations: 12 };

/// Lengths below this are rounding of equilibria solved with [`settings`] or closer, mm.
pub const ROUNDING_MM: f64 = 1e-9;
