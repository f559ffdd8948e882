//! Error sources, and the machines that respond to them: cutting force, weight, chain errors and all together.

use std::ops::{Index, IndexMut};

use serde::{Deserialize, Serialize};

use crate::{
    compensation::{CompensationSettings, Method, Session, Target, TaskPoint, compensate},
    input::error::{Error, Result},
    machine::{ChainError, Configuration, Machine, ZeroState},
    spatial::Wrench,
    statics::{self, Batch},
};

/// A source of tool errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Cutting force on the nominal machine, measured from its equilibrium without load.
    Cutting,
    /// Weight and springs of the nominal machine, against the rigid model.
    Weight,
    /// Chain errors of the unloaded actual machine, measured from the equilibrium of the nominal one.
    Geometry,
    /// All together: the actual case. Weight and springs are part of it unless the machine was calibrated under weight.
    All,
}

impl Source {
    /// Returns the sources of a machine, in table order; without weight if it has none.
    pub fn of(machine: &Machine) -> &'static [Source] {
        Self::for_count(if machine.own_load_text().is_some() { 4 } else { 3 })
    }

    /// Returns the sources of a machine that has `count` of them.
    fn for_count(count: usize) -> &'static [Source] {
        match count {
            4 => &[Source::Cutting, Source::Weight, Source::Geometry, Source::All],
            _ => &[Source::Cutting, Source::Geometry, Source::All],
        }
    }

    /// Returns the sources whose effects superposition adds up.
    pub fn parts(machine: &Machine) -> &'static [Source] {
        match machine.own_load_text().is_some() && machine.zeroed != ZeroState::AtRest {
            true => &[Source::Cutting, Source::Weight, Source::Geometry],
            false => &[Source::Cutting, Source::Geometry],
        }
    }

    /// Returns its word in tables.
    pub fn label(self) -> &'static str {
        match self {
            Source::Cutting => "cutting",
            Source::Weight => "weight",
            Source::Geometry => "geometry",
            Source::All => "all",
        }
    }

    /// Returns its name for readers.
    pub fn text(self) -> &'static str {
        match self {
            Source::Cutting => "cutting force",
            Source::Weight => "weight",
            Source::Geometry => "chain errors",
            Source::All => "all at once",
        }
    }

    /// Returns whether the cutting force acts.
    pub fn has_cutting_force(self) -> bool {
        matches!(self, Source::Cutting | Source::All)
    }
}

/// A value for each source of a machine, in table order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct BySource<T>(Vec<T>);

impl<T> BySource<T> {
    /// Creates values for each source of `machine`.
    pub fn of(machine: &Machine, value: impl FnMut(Source) -> T) -> Self {
        Self(Source::of(machine).iter().copied().map(value).collect())
    }

    /// Collects results, one for each source in table order.
    ///
    /// # Errors
    /// The first error.
    pub(crate) fn from_results(answers: Vec<Result<T>>) -> Result<Self> {
        answers.into_iter().collect::<Result<_>>().map(Self)
    }

    /// Returns its sources.
    pub fn sources(&self) -> &'static [Source] {
        Source::for_count(self.0.len())
    }

    /// Returns each source with its value, in table order.
    pub fn iter(&self) -> impl Iterator<Item = (Source, &T)> {
        self.sources().iter().copied().zip(&self.0)
    }

    /// Returns each source with its value to change, in table order.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (Source, &mut T)> {
        self.sources().iter().copied().zip(&mut self.0)
    }

    /// Returns the values changed by `value`.
    pub fn map<U>(self, mut value: impl FnMut(Source, T) -> U) -> BySource<U> {
        let sources = self.sources();
        BySource(sources.iter().copied().zip(self.0).map(|(source, own)| value(source, own)).collect())
    }

    /// Returns the value of `source`, if the machine has it, else `None`.
    pub fn get(&self, source: Source) -> Option<&T> {
        let place = self.sources().iter().position(|own| *own == source)?;
        self.0.get(place)
    }
}

impl<T> Index<Source> for BySource<T> {
    type Output = T;

    /// Returns the value of `source`.
    ///
    /// # Panics
    /// The machine has no weight, and that is asked for.
    fn index(&self, source: Source) -> &T {
        let place = self.sources().iter().position(|own| *own == source);
        &self.0[place.unwrap_or(self.0.len())]
    }
}

impl<T> IndexMut<Source> for BySource<T> {
    /// Returns the value of `source` to change; panics as `index` does.
    fn index_mut(&mut self, source: Source) -> &mut T {
        let place = self.sources().iter().position(|own| *own == source);
        let place = place.unwrap_or(self.0.len());
        &mut self.0[place]
    }
}

/// The nominal machine, which computes commands, and the machines that respond to the error sources.
#[derive(Debug, Clone)]
pub struct Machines {
    /// The nominal machine.
    pub nominal: Machine,
    /// The nominal machine, calibrated in its equilibrium under weight.
    at_rest: Machine,
    /// The actual machine, for chain errors and for all together: with chain errors, and with drive offsets if it was calibrated at home.
    pub actual: Machine,
    /// The machine without chain errors, for cutting and weight: with these offsets only.
    zeroed: Machine,
}

impl Machines {
    /// Creates the machines of `nominal` and of `errors` of each chain.
    ///
    /// # Errors
    /// The machine is calibrated at home, and no drive positions hold it there under its weight.
    pub fn new(nominal: &Machine, errors: &[ChainError]) -> Result<Self> {
        let zeroed = calibrated_at_home(nominal)?;
        let mut at_rest = nominal.clone();
        if at_rest.zeroed != ZeroState::AtRest {
            at_rest.zeroed = ZeroState::AtRest;
        }
        let perfect = Self { actual: zeroed.clone(), at_rest, zeroed, nominal: nominal.clone() };
        Ok(perfect.with_errors(errors))
    }

    /// Returns the actual machine of `machine`, whose chain errors are those of its parameters, with its drives offset as it was calibrated.
    pub(crate) fn actual_as_zeroed(machine: &Machine) -> Result<Machine> {
        if !is_offset(machine) {
            return Ok(machine.clone());
        }
        Ok(Self::new(&machine.nominal()?, &machine.parameter_errors())?.actual)
    }

    /// Returns the machines with other chain errors.
    pub fn with_errors(&self, errors: &[ChainError]) -> Self {
        Self { actual: self.zeroed.with_errors(errors), ..self.clone() }
    }

    /// Returns these machines with the parameter values of a draw (elastic ones and geometry) of `machine`, the nominal one with a chain design for
    /// each mounting, and with the chain `errors`. Commands stay those of the nominal machine; deflections are measured from the unloaded machine without `geometry`.
    ///
    /// # Errors
    /// Values that make no machine, or one that no drives hold at home under its weight, where it is calibrated there.
    pub fn drawn(
        &self,
        machine: &Machine,
        [elasticity, geometry]: &[Vec<(&str, f64)>; 2],
        errors: &[ChainError],
    ) -> Result<Self> {
        let with = |machine: &Machine, values: &Vec<(&str, f64)>| match values.is_empty() {
            true => Ok(machine.clone()),
            false => machine.with_parameters(values),
        };
        let zeroed = calibrated_at_home(&with(machine, elasticity)?)?;
        let actual = with(&zeroed, geometry)?.with_errors(errors);
        Ok(Self { zeroed, actual, ..self.clone() })
    }

    /// Returns the machines with home at `at`, near which redundant drives stay.
    pub(crate) fn with_home_at(&self, at: &Configuration) -> Self {
        let mut machines = self.clone();
        machines.nominal.home.clone_from(at);
        machines.at_rest.home.clone_from(at);
        machines
    }

    /// Returns the nominal machine that computes commands for `source`; for cutting and chain errors the one calibrated in equilibrium.
    pub fn nominal(&self, source: Source) -> &Machine {
        match source {
            Source::Cutting | Source::Geometry => &self.at_rest,
            Source::Weight | Source::All => &self.nominal,
        }
    }

    /// Returns the actual machine that responds to `source`.
    pub fn actual(&self, source: Source) -> &Machine {
        match source {
            Source::Cutting | Source::Weight => &self.zeroed,
            Source::Geometry | Source::All => &self.actual,
        }
    }

    /// Returns the machine without chain errors; deflections are measured from its unloaded equilibrium where the nominal one is calibrated there.
    pub fn unloaded(&self) -> &Machine {
        &self.zeroed
    }

    /// Returns a session for `source` that begins at home.
    pub fn session(&self, source: Source) -> Session {
        Session::new(self.nominal(source), self.actual(source), settings()).with_unloaded_machine(&self.zeroed)
    }

    /// Returns storage to solve many cases of `source` together.
    pub(crate) fn batch(&self, source: Source) -> Batch {
        Batch::new(self.actual(source))
    }
}

/// Returns whether calibration offsets the drives of `machine`.
fn is_offset(machine: &Machine) -> bool {
    machine.zeroed == ZeroState::AtHome && machine.own_load_text().is_some()
}

/// Returns the machine calibrated at home: its drives are offset so that under weight and springs it stands there as the rigid model does.
fn calibrated_at_home(nominal: &Machine) -> Result<Machine> {
    if !is_offset(nominal) {
        return Ok(nominal.clone());
    }
    let home = &nominal.home;
    let mut session = Session::new(nominal, nominal, settings());
    let task = TaskPoint { wanted: Some(home.pose), ..TaskPoint::new(home.pose, Wrench::zero(), Target::FullPose) };
    let held = compensate(&mut session, &task, Method::Direct);
    if !held.status.is_success() {
        let problem =
            format!("at_home: no drives hold the machine there under its weight: {}", held.status.reason(nominal));
        return Err(Error::Argument { argument: "zeroed".into(), problem });
    }
    let offsets: Vec<f64> = held.drives.iter().zip(&home.drives).map(|(held, home)| held - home).collect();
    Ok(nominal.with_drive_offsets(&offsets))
}

impl Source {
    /// Returns `task` for this source: without load for weight and chain errors, and for weight wanted at the rigid pose.
    pub fn task(self, task: &TaskPoint) -> TaskPoint {
        match self {
            Source::Geometry => task.without_force(),
            Source::Weight => TaskPoint { wanted: Some(task.pose), ..task.without_force() },
            Source::Cutting | Source::All => *task,
        }
    }
}

/// Returns the solver settings of all questions: to 3e-12 of the machine's characteristic length, 1e-9 mm on the Orthoglide.
pub fn settings() -> CompensationSettings {
    CompensationSettings::with_equilibrium_tolerance(1e-12)
}

/// Solver settings for small differences between equilibria: converged to rounding.
pub(crate) const TO_ROUNDING: statics::Settings = statics::Settings { tolerance: 1e-13, max_iterations: 12 };

/// Lengths below this are rounding of equilibria solved with [`settings`] or closer, mm.
pub const ROUNDING_MM: f64 = 1e-9;
