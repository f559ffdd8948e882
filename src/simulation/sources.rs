//! Sources of error, and the machines that answer for them: how any question asks for cutting, weight, chain errors and all.

use std::ops::{Index, IndexMut};

use serde::{Deserialize, Serialize};

use crate::{
    compensation::{CompensationSettings, Method, Session, Target, TaskPoint, compensate},
    input::error::{Error, Result},
    machine::{ChainError, Configuration, Machine, Zeroed},
    spatial::Wrench,
    statics::{self, Batch},
};

/// What makes the tool leave its path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The cutting force on the nominal machine, from where that rests.
    Cutting,
    /// Weight and springs of the nominal machine, against the rigid model.
    Weight,
    /// The chain errors of the unloaded real machine, from where the nominal one rests.
    Errors,
    /// All at once: what happens. Weight and springs are a part of it unless the machine was zeroed at rest.
    All,
}

impl Source {
    /// The sources of a machine, in table order: of one without weight, all others.
    pub fn of(machine: &Machine) -> &'static [Source] {
        Self::of_count(if machine.own_forces().is_some() { 4 } else { 3 })
    }

    fn of_count(count: usize) -> &'static [Source] {
        match count {
            4 => &[Source::Cutting, Source::Weight, Source::Errors, Source::All],
            _ => &[Source::Cutting, Source::Errors, Source::All],
        }
    }

    /// The sources whose sum superposition takes for all of them.
    pub fn parts(machine: &Machine) -> &'static [Source] {
        match machine.own_forces().is_some() && machine.zeroed != Zeroed::AtRest {
            true => &[Source::Cutting, Source::Weight, Source::Errors],
            false => &[Source::Cutting, Source::Errors],
        }
    }

    /// Word used in tables.
    pub fn label(self) -> &'static str {
        match self {
            Source::Cutting => "cutting",
            Source::Weight => "weight",
            Source::Errors => "errors",
            Source::All => "all",
        }
    }

    /// What it is, as readers see it.
    pub fn words(self) -> &'static str {
        match self {
            Source::Cutting => "cutting force",
            Source::Weight => "weight",
            Source::Errors => "chain errors",
            Source::All => "all at once",
        }
    }

    /// Whether the cutting force acts.
    pub fn has_cutting_force(self) -> bool {
        matches!(self, Source::Cutting | Source::All)
    }
}

/// A value for each source of a machine, in table order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct BySource<T>(Vec<T>);

impl<T> BySource<T> {
    /// What `value` has for each source of `machine`.
    pub fn of(machine: &Machine, value: impl FnMut(Source) -> T) -> Self {
        Self(Source::of(machine).iter().copied().map(value).collect())
    }

    /// Answers, one for each source of a machine in table order.
    ///
    /// # Errors
    /// The first of them.
    pub(crate) fn answered(answers: Vec<Result<T>>) -> Result<Self> {
        answers.into_iter().collect::<Result<_>>().map(Self)
    }

    /// Its sources.
    pub fn sources(&self) -> &'static [Source] {
        Source::of_count(self.0.len())
    }

    /// Each source with its value, in table order.
    pub fn iter(&self) -> impl Iterator<Item = (Source, &T)> {
        self.sources().iter().copied().zip(&self.0)
    }

    /// The same, to change the values.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (Source, &mut T)> {
        self.sources().iter().copied().zip(&mut self.0)
    }

    /// Each value changed to what `value` makes of it.
    pub fn map<U>(self, mut value: impl FnMut(Source, T) -> U) -> BySource<U> {
        let sources = self.sources();
        BySource(sources.iter().copied().zip(self.0).map(|(source, own)| value(source, own)).collect())
    }

    /// The value of `source`, if the machine has it.
    pub fn get(&self, source: Source) -> Option<&T> {
        let place = self.sources().iter().position(|own| *own == source)?;
        self.0.get(place)
    }
}

impl<T> Index<Source> for BySource<T> {
    type Output = T;

    /// # Panics
    /// The machine has no weight, and that is asked for.
    fn index(&self, source: Source) -> &T {
        let place = self.sources().iter().position(|own| *own == source);
        &self.0[place.unwrap_or(self.0.len())]
    }
}

impl<T> IndexMut<Source> for BySource<T> {
    fn index_mut(&mut self, source: Source) -> &mut T {
        let place = self.sources().iter().position(|own| *own == source);
        let place = place.unwrap_or(self.0.len());
        &mut self.0[place]
    }
}

/// The nominal machine, by which commands are computed, and those that answer for the sources.
#[derive(Debug, Clone)]
pub struct Machines {
    /// Commands.
    pub nominal: Machine,
    /// The same, zeroed where it rests.
    at_rest: Machine,
    /// Answers for chain errors and for all at once: it has those errors, and the drives' offsets if it was zeroed at home.
    pub real: Machine,
    /// Answers for cutting and weight: it has those offsets alone.
    zeroed: Machine,
}

impl Machines {
    /// `nominal`, and the same with `errors` of each chain.
    ///
    /// # Errors
    /// The machine is zeroed at home, and no drives hold it there under its weight.
    pub fn new(nominal: &Machine, errors: &[ChainError]) -> Result<Self> {
        let zeroed = zeroed_at_home(nominal)?;
        let mut at_rest = nominal.clone();
        if at_rest.zeroed != Zeroed::AtRest {
            at_rest.zeroed = Zeroed::AtRest;
        }
        let perfect = Self { real: zeroed.clone(), at_rest, zeroed, nominal: nominal.clone() };
        Ok(perfect.with_errors(errors))
    }

    /// The machine that stands where `machine`, whose errors are those of its parameters, is sent: as it was zeroed.
    ///
    /// # Errors
    /// Those of [`Machines::new`], and of [`Machine::nominal`].
    pub(crate) fn zeroed_as_used(machine: &Machine) -> Result<Machine> {
        if !is_offset(machine) {
            return Ok(machine.clone());
        }
        Ok(Self::new(&machine.nominal()?, &machine.parameter_errors())?.real)
    }

    /// The same machine with other errors of its chains.
    pub fn with_errors(&self, errors: &[ChainError]) -> Self {
        Self { real: self.zeroed.with_errors(errors), ..self.clone() }
    }

    /// The same machines at home at `at`: redundant drives stand as near to it as they can.
    pub(crate) fn at_home_at(&self, at: &Configuration) -> Self {
        let mut machines = self.clone();
        machines.nominal.home.clone_from(at);
        machines.at_rest.home.clone_from(at);
        machines
    }

    /// The nominal machine, which commands for `source`: cutting and chain errors act from its static equilibrium, however it is calibrated.
    pub fn nominal(&self, source: Source) -> &Machine {
        match source {
            Source::Cutting | Source::Errors => &self.at_rest,
            Source::Weight | Source::All => &self.nominal,
        }
    }

    /// The actual machine, which answers for `source`.
    pub fn actual(&self, source: Source) -> &Machine {
        match source {
            Source::Cutting | Source::Weight => &self.zeroed,
            Source::Errors | Source::All => &self.real,
        }
    }

    /// The machine without chain errors, from whose unloaded equilibrium deflections are measured where the nominal one is calibrated at rest.
    pub fn unloaded(&self) -> &Machine {
        &self.zeroed
    }

    /// A session that answers for `source`, standing at home.
    pub fn session(&self, source: Source) -> Session {
        Session::new(self.nominal(source), self.actual(source), settings()).from_rest_of(&self.zeroed)
    }

    /// Storage for many cases of what answers for `source`.
    pub(crate) fn batch(&self, source: Source) -> Batch {
        Batch::new(self.actual(source))
    }
}

/// Whether zeroing offsets the drives of `machine`.
fn is_offset(machine: &Machine) -> bool {
    machine.zeroed == Zeroed::AtHome && machine.own_forces().is_some()
}

/// The machine as zeroing at home leaves it: its drives offset so that it stands there under its weight and springs as the rigid
/// model does.
fn zeroed_at_home(nominal: &Machine) -> Result<Machine> {
    if !is_offset(nominal) {
        return Ok(nominal.clone());
    }
    let home = &nominal.home;
    let mut session = Session::new(nominal, nominal, settings());
    let task = TaskPoint {
        pose: home.pose,
        load: Wrench::zero(),
        target: Target::FullPose,
        wanted: Some(home.pose),
        external: None,
    };
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
    /// `task` as this source makes it: weight and chain errors act without load, and weight against the rigid model.
    pub fn task(self, task: &TaskPoint) -> TaskPoint {
        match self {
            Source::Errors => TaskPoint { load: Wrench::zero(), ..*task },
            Source::Weight => TaskPoint { load: Wrench::zero(), wanted: Some(task.pose), ..*task },
            Source::Cutting | Source::All => *task,
        }
    }
}

/// With what questions compensate: to 3e-12 of the machine's characteristic length, 1e-9 mm on the Orthoglide.
pub fn settings() -> CompensationSettings {
    CompensationSettings::with_equilibria_to(1e-12)
}

/// With what questions ask for small differences between equilibria: converged to rounding.
pub(crate) const TO_ROUNDING: statics::Settings = statics::Settings { tolerance: 1e-13, max_iterations: 12 };

/// Lengths below this are rounding of equilibria solved with [`settings`] or closer, mm.
pub const ROUNDING_MM: f64 = 1e-9;
