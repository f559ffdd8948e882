//! What is not known exactly: distributions, draws, and the displacements in all draws from a few solved ones.
//!
//! Parameters of the machine (stiffnesses, sections, errors of chains) and the cutting force. The question makes the machines and solves them;
//! nothing here does.

mod draws;
mod resolve;
pub mod sobol;
pub(crate) mod spec;
mod spread;
mod surrogate;

pub use draws::Draws;
pub use resolve::{ASSUMED_RELATIVE_STD, resolve};
pub use spread::{Spread, Z_95_INTERVAL, normal_cdf, normal_quantile};
pub use surrogate::{P95, Quantiles, Response, Surrogate, quantile};

use crate::machine::{Machine, Unit};

/// A parameter of the machine that is not known exactly, or several that have the same draws.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainParameter {
    /// Names in [`Uncertainty::machine`], each with its nominal value.
    pub values: Vec<(String, f64)>,
    /// Unit of the values.
    pub unit: Unit,
    /// Distribution of each value about its nominal one.
    pub spread: Spread,
    /// What of the machine it changes.
    pub role: Role,
    /// Who says so.
    pub source: SpreadSource,
}

/// What a parameter changes of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// How it bends: stiffnesses, sections, masses, springs.
    Elasticity,
    /// Where its parts are: lengths, axes. Commands are computed without it, so that the tool is off without load.
    Geometry,
    /// An error of a chain: geometry that is small.
    ChainError,
}

/// Where a spread comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpreadSource {
    /// The study.
    Given,
    /// An interval in the machine file.
    Provenance,
    /// The default for what the machine file grades as assumed.
    Assumed,
}

impl SpreadSource {
    /// Its word in files.
    pub fn label(self) -> &'static str {
        match self {
            SpreadSource::Given => "study",
            SpreadSource::Provenance => "machine file",
            SpreadSource::Assumed => "assumed",
        }
    }
}

impl UncertainParameter {
    /// Name for readers: that of the first parameter.
    pub fn name(&self) -> &str {
        self.values.first().map_or("", |(name, _)| name)
    }

    /// Values of its parameters for the standard normal number `z`.
    pub fn at(&self, z: f64) -> impl Iterator<Item = (&str, f64)> {
        self.values.iter().map(move |(name, nominal)| (name.as_str(), self.spread.value(*nominal, z)))
    }

    /// Coordinate in which displacements are nearly linear, for the standard normal number `z`: the relative change of the compliance of what is a
    /// stiffness, else the difference from the nominal value.
    pub fn coordinate(&self, z: f64) -> f64 {
        let (nominal, value) = (self.nominal(), self.spread.value(self.nominal(), z));
        let is_compliance = is_stiffness(self.unit) && !matches!(self.spread, Spread::Difference { .. });
        if is_compliance { nominal / value - 1.0 } else { value - nominal }
    }

    /// Interval that holds 95 % of the values of its first parameter.
    pub fn interval_95(&self) -> [f64; 2] {
        [-Z_95_INTERVAL, Z_95_INTERVAL].map(|z| self.spread.value(self.nominal(), z))
    }

    /// Nominal value of its first parameter.
    fn nominal(&self) -> f64 {
        self.values.first().map_or(0.0, |(_, nominal)| *nominal)
    }
}

/// What is not known exactly, and the draws made of it.
#[derive(Debug, Clone)]
pub struct Uncertainty {
    /// The nominal machine with a chain design for each mounting, so that each has parameters of its own.
    pub machine: Machine,
    /// Parameters that vary.
    pub parameters: Vec<UncertainParameter>,
    /// Distribution of the factor of the cutting force.
    pub force: Option<Spread>,
    /// The draws.
    pub draws: Draws,
}

/// Whether `unit` is that of a stiffness or an elastic constant.
fn is_stiffness(unit: Unit) -> bool {
    [Unit::N_PER_MM, Unit::NMM_PER_RAD, Unit::N_PER_MM2].contains(&unit)
}

/// Up to four of `names`, and how many more there are; `None` without any.
fn some_of(mut names: Vec<&str>) -> Option<String> {
    let count = names.len();
    names.truncate(4);
    let more = if count > names.len() { format!(" and {} more", count - names.len()) } else { String::new() };
    (count > 0).then(|| names.join(", ") + &more)
}

/// Parameter values of the machine in a draw, by name.
pub type Values<'a> = Vec<(&'a str, f64)>;

impl Uncertainty {
    /// Values of `parameters` for their standard normal numbers `z`: those that do not say where parts are, and those that do.
    fn values(&self, z: impl Fn(usize) -> f64) -> [Values<'_>; 2] {
        let mut values = [Vec::new(), Vec::new()];
        for (i, parameter) in self.parameters.iter().enumerate() {
            values[usize::from(parameter.role != Role::Elasticity)].extend(parameter.at(z(i)));
        }
        values
    }

    /// Parameter values of the draw `index`, without those that say where parts are, and those.
    pub fn values_of_draw(&self, index: usize) -> [Values<'_>; 2] {
        self.values(|parameter| self.draws.normal[parameter][index])
    }

    /// Parameter values with only `parameter` off its median, by the standard normal number `z`.
    pub fn values_at(&self, parameter: usize, z: f64) -> [Values<'_>; 2] {
        let own = &self.parameters[parameter];
        let mut values = [Vec::new(), Vec::new()];
        values[usize::from(own.role != Role::Elasticity)].extend(own.at(z));
        values
    }

    /// What varies, counted: "6 uncertain parameters and an uncertain force".
    pub fn words(&self) -> String {
        let parameters = match self.parameters.len() {
            1 => "an uncertain parameter".into(),
            count => format!("{count} uncertain parameters"),
        };
        match (self.parameters.is_empty(), &self.force) {
            (true, _) => "an uncertain force".into(),
            (false, None) => parameters,
            (false, Some(_)) => format!("{parameters} and an uncertain force"),
        }
    }

    /// Interval that holds 95 % of the factors of the cutting force; `None` where that is exact.
    pub fn force_factor_95(&self) -> Option<[f64; 2]> {
        self.force.map(|spread| [-Z_95_INTERVAL, Z_95_INTERVAL].map(|z| spread.value(1.0, z)))
    }

    /// Names of parameters that vary by a default, some of them where they are many; `None` without any.
    pub fn assumed_words(&self) -> Option<String> {
        let assumed = self.parameters.iter().filter(|own| own.source == SpreadSource::Assumed);
        some_of(assumed.map(UncertainParameter::name).collect())
    }

    /// Names of stiffnesses and elastic constants that do not vary, some of them where they are many; `None` without any.
    pub fn exact_words(&self) -> Option<String> {
        let varies = |name: &str| self.parameters.iter().flat_map(|own| &own.values).any(|(own, _)| own == name);
        let all = self.machine.parameters();
        let exact = all.iter().filter(|own| is_stiffness(own.unit) && own.value != Some(0.0) && !varies(&own.name));
        some_of(exact.map(|own| own.name.as_str()).collect())
    }

    /// Which ends of `parameter` are solved: both, but of an error of a chain, which is small and acts linearly, the farther.
    pub fn solved_ends(&self, parameter: usize) -> [bool; 2] {
        let own = &self.parameters[parameter];
        let [low, high] = Response::ENDS.map(|z| own.coordinate(z).abs());
        if own.role == Role::ChainError { [low > high, low <= high] } else { [true; 2] }
    }

    /// Coordinates of each parameter at one end of what the response is computed at, and at the other ([`Response`]).
    pub fn end_coordinates(&self) -> Vec<[f64; 2]> {
        self.parameters.iter().map(|own| Response::ENDS.map(|z| own.coordinate(z))).collect()
    }
}
