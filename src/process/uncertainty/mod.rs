//! What is not known exactly: distributions, draws, and the displacements in all draws from a few solved ones.
//!
//! Parameters of the machine (stiffnesses, sections, errors of chains) and the cutting force. The question makes the machines and solves them;
//! nothing here does.

mod covariance;
mod distribution;
mod draws;
mod resolve;
mod shares;
pub mod sobol;
pub(crate) mod spec;
mod surrogate;

pub use covariance::{COVARIANCE_COLUMNS, DISTRIBUTIONS, MODEL};
pub use distribution::{Distribution, Z_95_INTERVAL, normal_cdf, normal_quantile};
use draws::Distributions;
pub use draws::Draws;
pub use resolve::{CutBy, UNMEASURED_FORCE_STD, UncertaintyTable, refuse};
pub use shares::{CauseShare, Shares, Varying};
pub use surrogate::{Harmonics, P95, Quantiles, Response, Surrogate, mean_and_error, quantile};

use nalgebra::Vector3;

use crate::{
    machine::{Grade, Machine, Parameter, Unit},
    spatial::Wrench,
};

/// A parameter of the machine that is not known exactly, or several that have the same draws.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainParameter {
    /// Names in [`Uncertainty::machine`], each with its nominal value; none of a setup, whose nominal error is 0.
    pub values: Vec<(String, f64)>,
    /// Unit of the values.
    pub unit: Unit,
    /// Distribution of each value about its nominal one.
    pub spread: Distribution,
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
    /// No number of the machine: how it is set up. It moves the tool against the workpiece, and nothing else.
    Setup(Setup),
}

/// What is set up for a job, and not exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setup {
    /// The tool is longer than the control knows.
    ToolLength,
    /// The workpiece is farther along this axis of the base (0, 1, 2).
    Workpiece(usize),
    /// The workpiece is turned about its origin, about this axis of the base (0, 1, 2).
    WorkpieceRotation(usize),
    /// The control leads the tool farther along this axis of the base (0, 1, 2) than it is commanded.
    Accuracy(usize),
    /// This pass is farther along this axis of the base (0, 1, 2) than the mean of many.
    Repeatability(usize),
}

/// Where the tool is on the workpiece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolOnWorkpiece {
    /// Axis of the tool, from the spindle to the tip (O axes).
    pub axis: Vector3<f64>,
    /// The path's wanted point from the origin of the workpiece, mm (O axes).
    pub position_mm: Vector3<f64>,
    /// Number of the pass.
    pub pass: usize,
}

/// Who cuts: the index of the tool ([`Uncertainty::tool_index`]), and the number of its pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cut {
    /// Index of the tool.
    pub tool: usize,
    /// Number of the pass: from where the tool begins to cut to where it no longer does.
    pub pass: usize,
}

impl Setup {
    /// Those that the table itself gives, in the order of the parameters.
    const GIVEN: [Setup; 7] = [
        Setup::ToolLength,
        Setup::Workpiece(0),
        Setup::Workpiece(1),
        Setup::Workpiece(2),
        Setup::WorkpieceRotation(0),
        Setup::WorkpieceRotation(1),
        Setup::WorkpieceRotation(2),
    ];

    /// Its name.
    fn name(self) -> &'static str {
        match self {
            Setup::ToolLength => "tool length",
            Setup::Workpiece(axis) => ["workpiece x", "workpiece y", "workpiece z"][axis],
            Setup::WorkpieceRotation(axis) => {
                ["workpiece rotation about x", "workpiece rotation about y", "workpiece rotation about z"][axis]
            }
            Setup::Accuracy(axis) => ["accuracy along x", "accuracy along y", "accuracy along z"][axis],
            Setup::Repeatability(axis) => {
                ["repeatability along x", "repeatability along y", "repeatability along z"][axis]
            }
        }
    }

    /// How the `tool` moves against the workpiece for each mm or degree (O axes): rotations are small.
    fn direction(self, tool: &ToolOnWorkpiece) -> Vector3<f64> {
        match self {
            Setup::ToolLength => tool.axis,
            Setup::Workpiece(axis) => -Vector3::ith(axis, 1.0),
            Setup::WorkpieceRotation(axis) => -Vector3::ith(axis, 1f64.to_radians()).cross(&tool.position_mm),
            Setup::Accuracy(axis) | Setup::Repeatability(axis) => Vector3::ith(axis, 1.0),
        }
    }
}

/// Where a spread comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpreadSource {
    /// The table itself.
    Given,
    /// An interval in the machine file.
    Provenance,
    /// The default for what the machine file gives this grade and no interval.
    Grade(Grade),
    /// The covariance that an identification wrote.
    Identified,
}

impl SpreadSource {
    /// Its word in files.
    pub fn label(self) -> &'static str {
        match self {
            SpreadSource::Given => "given",
            SpreadSource::Provenance => "machine file",
            SpreadSource::Grade(grade) => grade.label(),
            SpreadSource::Identified => "identification",
        }
    }
}

impl UncertainParameter {
    /// Name for readers: that of the first parameter.
    pub fn name(&self) -> &str {
        match self.role {
            Role::Setup(setup) => setup.name(),
            _ => self.values.first().map_or("", |(name, _)| name),
        }
    }

    /// Values of its parameters for the standard normal number `z`.
    pub fn at(&self, z: f64) -> impl Iterator<Item = (&str, f64)> {
        self.values.iter().map(move |(name, nominal)| (name.as_str(), self.spread.value(*nominal, z)))
    }

    /// Coordinate in which displacements are nearly linear, for the standard normal number `z`: the relative change of the compliance of what is a
    /// stiffness, else the difference from the nominal value.
    pub fn coordinate(&self, z: f64) -> f64 {
        match self.compliance_ratio(z) {
            Some(ratio) if !matches!(self.spread, Distribution::Difference { .. }) => ratio - 1.0,
            _ => self.spread.value(self.nominal(), z) - self.nominal(),
        }
    }

    /// Compliance over the nominal one of what is a stiffness, for the standard normal number `z`; `None` of what is none.
    pub fn compliance_ratio(&self, z: f64) -> Option<f64> {
        let is_stiffness = self.unit.is_stiffness() && self.nominal() != 0.0;
        is_stiffness.then(|| self.nominal() / self.spread.value(self.nominal(), z))
    }

    /// Interval that holds 95 % of the values of its first parameter.
    pub fn interval_95(&self) -> [f64; 2] {
        self.spread.interval_95(self.nominal())
    }

    /// Nominal value of its first parameter.
    fn nominal(&self) -> f64 {
        self.values.first().map_or(0.0, |(_, nominal)| *nominal)
    }
}

/// What the model leaves out: a displacement d by the cutting force is really (I + E) d, with a matrix E (O axes) of nine independent normal
/// numbers for each machine, the same everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelError {
    /// Root mean square of |E d| over |d|.
    pub relative_std: f64,
    /// Who says so.
    pub source: SpreadSource,
}

impl ModelError {
    /// Whether it leaves something out, and nobody has said how much.
    pub fn is_assumed(&self) -> bool {
        self.relative_std > 0.0 && self.source == SpreadSource::Grade(Grade::Assumed)
    }
}

/// Distribution of the factor of the cutting force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ForceSpread {
    /// Of the force of a sharp tool over the nominal one; exact if `None`.
    pub sharp: Option<Distribution>,
    /// Of the force of a worn tool over that of a sharp one, from 1 on; tools stay sharp if `None`.
    pub wear: Option<Distribution>,
    /// Of each component over its nominal one, beside these factors of the whole.
    pub components: [Option<Distribution>; ForceSpread::COMPONENTS.len()],
    /// Number of further tools whose force and wear vary by themselves; 0 where one factor is for all.
    pub other_tools: usize,
}

impl ForceSpread {
    /// Names of the components.
    pub const COMPONENTS: [&str; 3] = ["tangential force", "radial force", "axial force"];

    /// Whether the force is exact.
    pub fn is_exact(&self) -> bool {
        self.sharp.is_none() && self.wear.is_none() && !self.has_components()
    }

    /// Whether a component varies by itself.
    pub fn has_components(&self) -> bool {
        self.varied_components().next().is_some()
    }

    /// Indices of the components that vary by themselves, with their distributions.
    pub fn varied_components(&self) -> impl Iterator<Item = (usize, Distribution)> + use<> {
        self.components.into_iter().enumerate().filter_map(|(own, spread)| Some((own, spread?)))
    }

    /// Factors by which the force of a sharp tool and of a worn one are larger, for their standard normal numbers.
    pub fn factors(&self, normal: [f64; 2]) -> [f64; 2] {
        let factor = |(own, z): (Option<Distribution>, f64)| own.map_or(1.0, |spread| spread.value(1.0, z));
        [(self.sharp, normal[0]), (self.wear, normal[1])].map(factor)
    }
}

/// The cutting force at a point of a path, as draws change it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DrawnForceAt {
    /// Index of the tool that cuts there ([`Draws::force_of`]).
    pub tool: usize,
    /// Wrenches at P of the components of the force, which add up to it (O axes); zero where none varies by itself.
    pub components: [Wrench; ForceSpread::COMPONENTS.len()],
}

/// Factors of the cutting force in a draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceFactors {
    /// Of the whole.
    pub all: f64,
    /// Of each component, less 1.
    pub components: [f64; ForceSpread::COMPONENTS.len()],
}

impl ForceFactors {
    /// Those of the force times `all`.
    pub fn of_all(all: f64) -> Self {
        Self { all, components: [0.0; ForceSpread::COMPONENTS.len()] }
    }

    /// Returns the wrench of a cutting force that is nominally `load` and has these `components`.
    pub fn on(&self, load: &Wrench, components: &[Wrench]) -> Wrench {
        if self.components == [0.0; ForceSpread::COMPONENTS.len()] {
            return load.scale(self.all);
        }
        let with = |Wrench { force, moment }, (factor, own): (&f64, &Wrench)| Wrench {
            force: force + own.force * *factor,
            moment: moment + own.moment * *factor,
        };
        self.components.iter().zip(components).fold(*load, with).scale(self.all)
    }
}

/// What may spread a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Cause {
    /// Parameters, by their indices: one, or those that are correlated together.
    Parameters(Vec<usize>),
    /// The cutting force of sharp tools.
    Force,
    /// What tool wear adds to it.
    Wear,
    /// A component of the cutting force, by its index.
    Component(usize),
    /// What the model leaves out.
    Model,
}

impl Cause {
    /// Name of what the model leaves out.
    pub const MODEL: &str = "what the model leaves out";
}

/// What is not known exactly, and the draws made of it.
#[derive(Debug, Clone)]
pub struct Uncertainty {
    /// The nominal machine with a chain design for each mounting, so that each has parameters of its own.
    pub machine: Machine,
    /// Parameters that vary.
    pub parameters: Vec<UncertainParameter>,
    /// Names of parameters whose correlations with others an entry of the study drops.
    pub dropped_correlations: Vec<String>,
    /// Whether parameters should vary as the machine file says, and it says it of none that no entry names.
    pub finds_no_provenance: bool,
    /// Whether the study says that what is not named is taken as exact.
    pub is_exact_by_choice: bool,
    /// Distribution of the factor of the cutting force.
    pub force: ForceSpread,
    /// Numbers of the tools whose force and wear vary by themselves, in the order in which they cut; empty where one factor is for all.
    pub tools: Vec<u32>,
    /// What the model leaves out.
    pub model: ModelError,
    /// The draws.
    pub draws: Draws,
}

/// Whether one of `parameters` is called `name`.
fn varies(parameters: &[UncertainParameter], name: &str) -> bool {
    parameters.iter().flat_map(|own| &own.values).any(|(own, _)| own == name)
}

/// Parameter values of the machine in a draw, by name.
pub type Values<'a> = Vec<(&'a str, f64)>;

impl Uncertainty {
    /// Values of parameters, by their indices, for their standard normal numbers: those that do not say where parts are, and those that do.
    fn values(&self, normal: impl Iterator<Item = (usize, f64)>) -> [Values<'_>; 2] {
        let mut values = [Vec::new(), Vec::new()];
        for (parameter, z) in normal {
            let own = &self.parameters[parameter];
            values[usize::from(own.role != Role::Elasticity)].extend(own.at(z));
        }
        values
    }

    /// Returns these inputs without what the model leaves out.
    #[must_use]
    pub fn without_model(self) -> Self {
        let model = ModelError { relative_std: 0.0, source: SpreadSource::Given };
        Self { model, draws: Draws { model: Vec::new(), model_range: 0.0, ..self.draws }, ..self }
    }

    /// Parameter values of the draw `index`, without those that say where parts are, and those.
    pub fn values_of_draw(&self, index: usize) -> [Values<'_>; 2] {
        self.values(self.draws.normal.iter().map(|own| own[index]).enumerate())
    }

    /// Values given one after another in the order of the parameters: those that do not say where parts are, and those that do.
    pub fn values_of_row(&self, row: &[f64]) -> [Values<'_>; 2] {
        let mut values = [Vec::new(), Vec::new()];
        let named = self.parameters.iter().flat_map(|own| own.values.iter().map(|(name, _)| (name.as_str(), own.role)));
        for ((name, role), value) in named.zip(row) {
            values[usize::from(role != Role::Elasticity)].push((name, *value));
        }
        values
    }

    /// Parameter values with only `parameter` off its median, by the standard normal number `z`.
    pub fn values_at(&self, parameter: usize, z: f64) -> [Values<'_>; 2] {
        self.values(std::iter::once((parameter, z)))
    }

    /// Values of all stiffnesses of the machine, so low that under the nominal force it is as weak as the weakest draw.
    pub fn weakest_values(&self) -> Vec<(String, f64)> {
        let stiffnesses = self.machine.parameters().into_iter().filter(|own| own.unit.is_stiffness());
        stiffnesses.filter_map(|own| Some((own.name, own.value? / self.draws.weakest))).collect()
    }

    /// Interval that holds 95 % of the factors of the cutting force, with tool wear as drawn; `None` where that is exact.
    pub fn force_factor_95(&self) -> Option<[f64; 2]> {
        let ForceSpread { sharp, wear, .. } = self.force;
        match wear {
            None => sharp.map(|spread| spread.interval_95(1.0)),
            Some(_) => Some([0.025, 0.975].map(|share| quantile(&mut self.draws.force_of(0).to_vec(), share))),
        }
    }

    /// Intervals that hold 95 % of the factors of the components of the force that vary by themselves, with their names.
    pub fn component_factors_95(&self) -> impl Iterator<Item = (&'static str, [f64; 2])> {
        self.force.varied_components().map(|(own, spread)| (ForceSpread::COMPONENTS[own], spread.interval_95(1.0)))
    }

    /// Index of the tool with this number among those whose force varies by itself ([`Draws::force_of`]); 0 where one factor is for all.
    pub fn tool_index(&self, number: Option<u32>) -> usize {
        self.tools.iter().position(|own| Some(*own) == number).unwrap_or(0)
    }

    /// Share by which the force of a worn tool may be above that of a sharp one; `None` where tools stay sharp.
    pub fn wear_force_increase(&self) -> Option<f64> {
        match self.force.wear {
            Some(Distribution::Uniform { largest, .. }) => Some(largest),
            _ => None,
        }
    }

    /// What may spread a result, by name: each parameter by itself, those that are correlated together; force and model last.
    pub fn causes(&self) -> impl Iterator<Item = (String, Cause)> {
        let correlated = &self.draws.correlated;
        let together = (!correlated.is_empty()).then(|| {
            let names: Vec<&str> = correlated.iter().map(|own| self.parameters[*own].name()).collect();
            (names.join(" with "), Cause::Parameters(correlated.clone()))
        });
        let stated = [("accuracy", 0), ("repeatability", 1)].into_iter().filter_map(|(name, which)| {
            let is_it = |own: &usize| match self.parameters[*own].role {
                Role::Setup(Setup::Accuracy(_)) => which == 0,
                Role::Setup(Setup::Repeatability(_)) => which == 1,
                _ => false,
            };
            let all: Vec<usize> = (0..self.parameters.len()).filter(is_it).collect();
            (!all.is_empty()).then(|| (name.into(), Cause::Parameters(all)))
        });
        let is_stated = |own: &usize| {
            matches!(self.parameters[*own].role, Role::Setup(Setup::Accuracy(_) | Setup::Repeatability(_)))
        };
        let alone = (0..self.parameters.len()).filter(move |own| !correlated.contains(own) && !is_stated(own));
        let alone = alone.map(|own| (self.parameters[own].name().to_string(), Cause::Parameters(vec![own])));
        let wear = self.force.wear.map(|_| ("tool wear".into(), Cause::Wear));
        let component = |(own, _): (usize, Distribution)| (ForceSpread::COMPONENTS[own].into(), Cause::Component(own));
        let components = self.force.varied_components().map(component);
        let force = std::iter::once(("cutting force".into(), Cause::Force)).chain(components).chain(wear);
        alone.chain(stated).chain(together).chain(force).chain([(Cause::MODEL.into(), Cause::Model)])
    }

    /// The same with the cause called `name` measured, and how well it is known then; parameters that are correlated, as measurements of one tell the others,
    /// all of them. `None` of what the model leaves out unless that is assumed.
    pub fn measured(&self, name: &str) -> Option<(Self, &'static str)> {
        let mut own = self.clone();
        let text = match self.causes().find(|(own, _)| own == name)?.1 {
            Cause::Parameters(which) if which.len() > 1 => {
                let is_stated = matches!(self.parameters[which[0]].role, Role::Setup(_));
                // Deviations of what is identified fall with the square root of the number of measurements.
                which.iter().for_each(|one| own.parameters[*one].spread = own.parameters[*one].spread.halved());
                match is_stated {
                    true => "halved",
                    false => "known twice as well, by four times as many measurements (design-measurements says which)",
                }
            }
            Cause::Parameters(which) => {
                let one = *which.first()?;
                let (spread, text) = self.parameters[one].spread.measured();
                own.parameters[one].spread = spread;
                text
            }
            Cause::Force => {
                let (spread, text) = self.force.sharp?.measured();
                own.force.sharp = Some(spread);
                text
            }
            Cause::Component(which) => {
                let (spread, text) = self.force.components[which]?.measured();
                own.force.components[which] = Some(spread);
                text
            }
            Cause::Wear => {
                own.force.wear = Some(self.force.wear?.measured().0);
                "kept to half by changing tools earlier"
            }
            Cause::Model if self.model.source == SpreadSource::Grade(Grade::Assumed) => {
                own.model.relative_std = resolve::FITTED_MODEL_ERROR;
                "reduced to 19 % by an identification, as by the best one of a measured robot"
            }
            Cause::Model => return None,
        };
        own.draws = Draws::new(own.distributions(), own.draws.seed);
        Some((own, text))
    }

    /// The same with `count` draws that are independent of one another and of these.
    #[must_use]
    pub fn with_independent_draws(&self, count: usize) -> Self {
        let seed = self.draws.seed;
        // One draw of each scramble; no other random numbers of a seed have this bit ([`sobol::points`]).
        let draws = Draws::in_scrambles(self.distributions(), seed, u64::from(seed) | 1 << 44, count, 1);
        Self { draws, ..self.clone() }
    }

    fn distributions(&self) -> Distributions<'_> {
        let (Draws { correlated, factor, .. }, model_std) = (&self.draws, self.model.relative_std);
        Distributions { parameters: &self.parameters, correlated, factor, force: self.force, model_std }
    }

    /// Whether the median of each parameter and of the force is its nominal value, so that a 95 % quantile of a distance is not below the nominal one.
    pub fn has_nominal_medians(&self) -> bool {
        let is_nominal = |own: &UncertainParameter| own.coordinate(0.0).abs() <= 1e-9 * own.coordinate(1.0).abs();
        self.force.wear.is_none() && self.parameters.iter().all(is_nominal)
    }

    /// Names of parameters that vary by a default.
    pub fn assumed(&self) -> impl Iterator<Item = &str> {
        self.parameters.iter().filter(|own| matches!(own.source, SpreadSource::Grade(_))).map(UncertainParameter::name)
    }

    /// Names of the parameters that vary by the default of their grade, by grade and standard deviation over their values, with the factors between which 95 % of their values are.
    pub fn graded(&self) -> Vec<(Grade, f64, [f64; 2], Vec<&str>)> {
        let mut found: Vec<(Grade, f64, [f64; 2], Vec<&str>)> = Vec::new();
        for own in &self.parameters {
            let SpreadSource::Grade(grade) = own.source else { continue };
            let ends = own.interval_95().map(|end| end / own.nominal());
            let std = own.spread.relative_std();
            match found.iter_mut().find(|other| other.0 == grade && (other.1 - std).abs() < 1e-9) {
                Some(other) => other.3.push(own.name()),
                None => found.push((grade, std, ends, vec![own.name()])),
            }
        }
        found
    }

    /// Names of stiffnesses and elastic constants that do not vary.
    pub fn exact_stiffnesses(&self) -> impl Iterator<Item = String> {
        let is_exact =
            |own: &Parameter| own.unit.is_stiffness() && own.value != Some(0.0) && !varies(&self.parameters, &own.name);
        self.machine.parameters().into_iter().filter(is_exact).map(|own| own.name)
    }

    /// How the `tool` moves against the workpiece for each mm or degree of the parameter with this index (O axes); `None` of a number of the machine.
    pub fn setup_direction(&self, parameter: usize, tool: &ToolOnWorkpiece) -> Option<Vector3<f64>> {
        match self.parameters[parameter].role {
            Role::Setup(setup) => Some(setup.direction(tool)),
            _ => None,
        }
    }

    /// How far the setup of the draw `index` moves the `tool` against the workpiece, mm (O axes).
    pub fn setup_displacement(&self, index: usize, tool: &ToolOnWorkpiece) -> Vector3<f64> {
        let at = |own: usize| self.draws.coordinates[own][self.draws.place(own, index, tool.pass)];
        let moved = |own: usize| Some(at(own) * self.setup_direction(own, tool)?);
        (0..self.parameters.len()).filter_map(moved).sum()
    }

    /// Whether a number of the machine or the force varies, and not the setup alone.
    pub fn varies_machine_or_force(&self) -> bool {
        !self.force.is_exact() || self.parameters.iter().any(|own| !matches!(own.role, Role::Setup(_)))
    }

    /// Names of what is set up and not exact.
    pub fn setups(&self) -> impl Iterator<Item = &str> {
        let mut named = Vec::new();
        for own in self.parameters.iter().filter(|own| matches!(own.role, Role::Setup(_))) {
            let name = match own.role {
                Role::Setup(Setup::Accuracy(_)) => "accuracy",
                Role::Setup(Setup::Repeatability(_)) => "repeatability",
                _ => own.name(),
            };
            if !named.contains(&name) {
                named.push(name);
            }
        }
        named.into_iter()
    }

    /// Which ends of `parameter` are solved: both, but of an error of a chain, which is small and acts linearly, the farther; of a setup none.
    pub fn solved_ends(&self, parameter: usize) -> [bool; 2] {
        let own = &self.parameters[parameter];
        let [low, high] = Response::ENDS.map(|z| own.coordinate(z).abs());
        match own.role {
            Role::ChainError => [low > high, low <= high],
            Role::Setup(_) => [false; 2],
            _ => [true; 2],
        }
    }

    /// Words for the machine with `parameter` alone at one of its ends.
    pub fn end_text(&self, parameter: usize, end: usize) -> String {
        format!("with {} at its {} quantile", self.parameters[parameter].name(), ["5 %", "95 %"][end])
    }

    /// Coordinates of each parameter at one end of what the response is computed at, and at the other ([`Response`]).
    pub fn end_coordinates(&self) -> Vec<[f64; 2]> {
        self.parameters.iter().map(|own| Response::ENDS.map(|z| own.coordinate(z))).collect()
    }
}
