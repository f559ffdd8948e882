//! Every number of a machine under one name, read and set without touching its file.
//!
//! A name says where the number stands: `arm.A2.stiffness` is the stiffness of the element A2 of the chain design arm,
//! `leg.foot.height` the height of the section of its beam foot, `leg.beam_2.length` the length of its second beam, which has
//! no name of its own; `x.base.position.z` belongs to the mount x, `platform.tool_tip.z`, `gravity.z` and
//! `material.steel.youngs_modulus` to the machine. Vectors have components x, y, z, intervals min and max, the matrix of a link
//! its upper triangle (`leg.link_1.stiffness.x_ry`). Errors of a chain, zero unless set, are the mount's: `x.turn` about the axis
//! of its first drive, `x.base.translation.y`, `x.base.turn.y`, the same of its `end`, and the zero of a drive, `x.rail.offset`.

mod mount_errors;
mod separate;
mod unit;
mod variation;
mod walk;

use std::sync::Arc;

use serde::Serialize;

pub use unit::Unit;
pub use variation::Variation;
pub(super) use walk::GRAVITY;

use self::{
    mount_errors::MountErrors,
    walk::{FoundParameter, walk},
};
use super::{ChainError, Grade, Machine, Provenance, provenance::is_named, refusal, resolve, spec::MachineSpec};
use crate::input::{
    check::{Check, LARGEST},
    error::{Error, Result},
    names::nearest,
    toml_file::line_of,
};

/// A number of a machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Its name, which no other has.
    pub name: String,
    /// Its value in [`Self::unit`]; `None` where the machine file calls it unknown.
    pub value: Option<f64>,
    /// mm, degrees, N and their products, as in machine files.
    pub unit: Unit,
    /// Where the machine file has it, vectors and matrices as a whole; `None` for an error of a chain.
    pub key: Option<String>,
    /// How far it may be trusted, where `[[provenance]]` names it.
    pub grade: Option<Grade>,
    /// 95 % interval in [`Self::unit`], where `[[provenance]]` has one.
    pub interval: Option<[f64; 2]>,
}

/// The machine file of a machine, and what was changed since.
#[derive(Debug, Clone)]
pub(super) struct Definition {
    spec: Arc<MachineSpec>,
    origin: Arc<str>,
    /// The file as written.
    text: Arc<str>,
    /// Errors set as parameters, one entry for each chain; empty where none is set.
    errors: Vec<(MountErrors, ChainError)>,
    /// Errors built in otherwise, in this order.
    built_in: Vec<Vec<ChainError>>,
    /// Drives locked, by name, in shown units.
    pub locked: Vec<(String, f64)>,
    /// Those of them that a path moves, and between which positions.
    pub path_axes: Vec<(String, [f64; 2])>,
    /// Drives that a path leaves at home, since nothing commands them, by label.
    pub resting: Vec<String>,
    /// Whether the locked drives decide how the platform is turned, and no task does: see [`Machine::with_commanded_drives`].
    pub is_commanded: bool,
}

impl Definition {
    /// The definition of a machine without errors, locked drives and path axes; `text`: the file as written, `origin` names it in errors.
    pub fn new(spec: MachineSpec, origin: &str, text: Arc<str>) -> Self {
        Self {
            spec: Arc::new(spec),
            origin: origin.into(),
            text,
            errors: Vec::new(),
            built_in: Vec::new(),
            locked: Vec::new(),
            path_axes: Vec::new(),
            resting: Vec::new(),
            is_commanded: false,
        }
    }

    /// The machine file, as parsed and since changed.
    pub fn spec(&self) -> &MachineSpec {
        &self.spec
    }

    /// Name of the machine file in errors: its path, unless it is built in.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// Records errors that are built in otherwise than as parameters.
    pub fn record_errors(&mut self, errors: &[ChainError]) {
        self.built_in.push(errors.to_vec());
    }

    /// Sets the gravity of the machine file to zero.
    pub fn clear_gravity(&mut self) {
        Arc::make_mut(&mut self.spec).gravity = Some([0.0; 3]);
    }
}

/// A parameter value to be set, whether the parameter was found, and its key in the machine file.
struct Setting<'a> {
    name: &'a str,
    value: f64,
    found: bool,
    key: String,
}

impl Machine {
    /// All parameters: those of the machine file but for named points, at their default where it leaves them out, and the chain errors.
    ///
    /// Errors that [`Machine::with_errors`] has built in are not among them.
    pub fn parameters(&self) -> Vec<Parameter> {
        self.parameters_called(&|_| true)
    }

    /// All parameters for whose name `is_wanted` returns true.
    fn parameters_called(&self, is_wanted: &dyn Fn(&str) -> bool) -> Vec<Parameter> {
        let mut parameters = Vec::new();
        walk(&mut MachineSpec::clone(&self.definition.spec), &mut |FoundParameter { name, key, unit, slot }| {
            if !is_wanted(name) {
                return;
            }
            let about = self.provenance_of(name);
            parameters.push(Parameter {
                name: name.into(),
                value: slot.value(),
                unit,
                key: Some(key.into()),
                grade: about.map(|about| about.grade),
                interval: about.and_then(|about| about.interval),
            });
        });
        for (errors, chain) in self.mount_errors().iter_mut().zip(&self.chains) {
            errors.walk(chain, &mut |name, unit, value| {
                if is_wanted(&name) {
                    let value = Some(*value);
                    parameters.push(Parameter { name, value, unit, key: None, grade: None, interval: None });
                }
            });
        }
        parameters
    }

    /// What the machine file says of the parameter called `name`: its entry of provenance that names the most of it; `None` if none names it.
    pub fn provenance_of(&self, name: &str) -> Option<&Provenance> {
        let named = self.provenance.iter().filter_map(|about| about.match_length(name).map(|part| (part, about)));
        named.max_by_key(|(part, _)| *part).map(|(_, about)| about)
    }

    /// Line of the machine file, from 1, with the value at `key` ([`Parameter::key`]), or else with the innermost table around it; `None` if it has
    /// neither.
    pub fn line_of(&self, key: &str) -> Option<usize> {
        line_of(&self.definition.text, key)
    }

    /// The parameter called `name`.
    ///
    /// # Errors
    /// There is none; the message has the nearest names.
    pub fn parameter(&self, name: &str) -> Result<Parameter> {
        let called = self.parameters_called(&|candidate| candidate == name).into_iter().next();
        called.ok_or_else(|| unknown_parameter(name, &self.parameter_names()))
    }

    /// Names of all parameters.
    fn parameter_names(&self) -> Vec<String> {
        self.parameters().into_iter().map(|parameter| parameter.name).collect()
    }

    /// This machine with other parameter values, checked and assembled anew; all others stay, and so does the branch that was chosen.
    ///
    /// Chain errors are built in as by [`Machine::with_errors`]; commands are those of the machine without them, [`Machine::nominal`].
    ///
    /// # Errors
    /// A name that is unknown or given twice, or a value that makes no machine; messages begin with the name. With these numbers, the
    /// branch that was chosen ([`Machine::on_branch`]) is not within travel at home.
    pub fn with_parameters<N: AsRef<str>>(&self, values: &[(N, f64)]) -> Result<Machine> {
        let mut settings: Vec<Setting<'_>> = Vec::new();
        for (name, value) in values {
            let name = name.as_ref();
            if settings.iter().any(|other| other.name == name) {
                return Err(refusal(name, "is set twice".into()));
            }
            settings.push(Setting { name, value: *value, found: false, key: String::new() });
        }
        let mut spec = MachineSpec::clone(&self.definition.spec);
        walk(&mut spec, &mut |FoundParameter { name, key, mut slot, .. }| {
            if let Some(setting) = settings.iter_mut().find(|setting| setting.name == name) {
                slot.set(setting.value);
                (setting.found, setting.key) = (true, key.into());
            }
        });
        let mut errors = self.mount_errors();
        for (errors, chain) in errors.iter_mut().zip(&self.chains) {
            errors.walk(chain, &mut |name, _, value| {
                if let Some(setting) = settings.iter_mut().find(|setting| !setting.found && setting.name == name) {
                    (*value, setting.found) = (setting.value, true);
                }
            });
        }
        if let Some(setting) = settings.iter().find(|setting| !setting.found) {
            return Err(unknown_parameter(setting.name, &self.parameter_names()));
        }
        if let Some(setting) = settings.iter().find(|setting| setting.value.is_nan() || setting.value.abs() > LARGEST) {
            let problem = format!("must be a number between {:e} and {LARGEST:e}, got {:?}", -LARGEST, setting.value);
            return Err(refusal(setting.name, problem));
        }
        let machine = self.resolve_again(spec).map_err(|error| in_parameter_names(error, &settings))?;
        machine.with_all_errors(errors, &settings, &self.definition.built_in)
    }

    /// This machine rebuilt from another machine file, with the errors that it has; `Err` where `spec` makes no machine.
    pub(super) fn rebuild_from(&self, spec: MachineSpec) -> Result<Machine> {
        self.resolve_again(spec)?.with_all_errors(self.mount_errors(), &[], &self.definition.built_in)
    }

    /// Resolves `spec` as the file of this machine, on the same branch and with the same drives locked; `Err` where it makes no machine.
    fn resolve_again(&self, spec: MachineSpec) -> Result<Machine> {
        let machine = resolve::resolve_machine(spec, &self.definition.origin, Arc::clone(&self.definition.text))?;
        let (machine, locked) = (machine.on_branch_if_any(self.branch)?, &self.definition.locked);
        match self.definition.is_commanded {
            true => machine.with_commanded_drives(locked),
            false => machine.with_locked_drives(locked),
        }
    }

    /// This machine with `errors` as parameters, set by `settings`, and those `built_in` otherwise; `Err` where they turn a chain too far.
    fn with_all_errors(
        self,
        errors: Vec<MountErrors>,
        settings: &[Setting<'_>],
        built_in: &[Vec<ChainError>],
    ) -> Result<Machine> {
        let machine = self.with_mount_errors(errors, settings)?;
        Ok(built_in.iter().fold(machine, |machine, more| machine.with_errors(more)))
    }

    /// The machine without errors of chains, by which this one is commanded.
    ///
    /// # Errors
    /// None, as long as its numbers make a machine whose drives can be locked where they are.
    pub fn nominal(&self) -> Result<Machine> {
        self.resolve_again(MachineSpec::clone(&self.definition.spec))
    }

    /// Errors of its chains that are set as parameters, for [`Machine::with_errors`]; empty where none is.
    pub fn parameter_errors(&self) -> Vec<ChainError> {
        self.definition.errors.iter().map(|(_, error)| error.clone()).collect()
    }

    /// Whether any errors of its chains are part of the machine.
    pub(super) fn has_recorded_errors(&self) -> bool {
        !(self.definition.errors.is_empty() && self.definition.built_in.is_empty())
    }

    /// Errors set as parameters, one entry for each chain.
    fn mount_errors(&self) -> Vec<MountErrors> {
        match self.definition.errors.is_empty() {
            true => self.chains.iter().map(MountErrors::none).collect(),
            false => self.definition.errors.iter().map(|(errors, _)| errors.clone()).collect(),
        }
    }

    /// This machine with `errors` of its chains; `Err` where they turn a chain too far.
    fn with_mount_errors(self, errors: Vec<MountErrors>, settings: &[Setting<'_>]) -> Result<Machine> {
        if errors.iter().zip(&self.chains).all(|(errors, chain)| errors.is_none(chain)) {
            return Ok(self);
        }
        let chain_errors: Vec<ChainError> =
            errors.iter().zip(&self.chains).map(|(errors, chain)| errors.chain_error(chain)).collect();
        for (error, chain) in chain_errors.iter().zip(&self.chains) {
            let is_own = |setting: &&Setting<'_>| setting.key.is_empty() && is_named(setting.name, &chain.name);
            let turns = [error.base.angular.norm(), error.end.angular.norm()];
            if let Some(problem) = turns.into_iter().find_map(ChainError::rotation_problem) {
                return Err(refusal(&setting_names(settings.iter().filter(is_own)), problem));
            }
        }
        let mut machine = self.with_errors_unrecorded(&chain_errors);
        machine.definition.errors = errors.into_iter().zip(chain_errors).collect();
        Ok(machine)
    }
}

/// Whether `name` matches `pattern`, in which `*` stands for any letters but a dot.
pub fn is_pattern_of(pattern: &str, name: &str) -> bool {
    // No star reaches over a dot, so that what is between the dots is matched by itself.
    let (mut patterns, mut parts) = (pattern.split('.'), name.split('.'));
    loop {
        match (patterns.next(), parts.next()) {
            (Some(pattern), Some(part)) if is_pattern_of_part(pattern, part) => {}
            (pattern, part) => return pattern.is_none() && part.is_none(),
        }
    }
}

/// Whether `part`, which has no dot, matches `pattern`; in a time that grows with the length of both, however many stars there are.
fn is_pattern_of_part(pattern: &str, part: &str) -> bool {
    let Some((before, rest)) = pattern.split_once('*') else { return pattern == part };
    let (between, after) = rest.rsplit_once('*').unwrap_or(("", rest));
    let middle = part.strip_prefix(before).and_then(|tail| tail.strip_suffix(after));
    // The first place of each word leaves most to those behind it.
    middle.is_some_and(|middle| {
        let behind = between.split('*').try_fold(middle, |tail, word| Some(&tail[tail.find(word)? + word.len()..]));
        behind.is_some()
    })
}

/// Names of all parameters of the machine file `spec`.
pub(super) fn names(spec: &MachineSpec) -> Vec<String> {
    let mut names = Vec::new();
    walk(&mut spec.clone(), &mut |parameter| names.push(parameter.name.to_string()));
    names
}

/// Refuses a `pattern` that names none of `names`.
pub(super) fn check_pattern(names: &[String], pattern: &str, check: &Check) -> Result<()> {
    if names.iter().any(|name| is_named(name, pattern)) {
        return Ok(());
    }
    let near = suggested_names(pattern, names);
    check.fail(format!("\"{pattern}\" is neither the name of a parameter nor the part of names before a dot{near}"))
}

/// Error that no parameter is called `name`, with the nearest of `names`.
fn unknown_parameter(name: &str, names: &[String]) -> Error {
    refusal(name, format!("no parameter is called so{}", suggested_names(name, names)))
}

/// End of a message: those of `names` nearest to `name`, or some of them.
fn suggested_names(name: &str, names: &[String]) -> String {
    let near = nearest(name, names);
    if !near.is_empty() {
        return format!("; there are: {}", near.join(", "));
    }
    let some: Vec<&str> = names.iter().step_by(names.len().div_ceil(4).max(1)).map(String::as_str).collect();
    format!("; there are {}, such as {}", names.len(), some.join(", "))
}

/// Names of up to three settings, separated by commas, and how many more there are.
fn setting_names<'s>(settings: impl Iterator<Item = &'s Setting<'s>>) -> String {
    let mut names: Vec<&str> = settings.map(|setting| setting.name).collect();
    let count = names.len();
    names.truncate(3);
    match count - names.len() {
        0 => names.join(", "),
        more => format!("{} and {more} more", names.join(", ")),
    }
}

/// Rewrites an error of a machine file so that it names the parameters that were set.
fn in_parameter_names(error: Error, settings: &[Setting<'_>]) -> Error {
    let Error::Value { file, key, problem, .. } = error else { return error };
    let is_within = |part: &str, whole: &str| {
        part.strip_prefix(whole).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    };
    let at_fault: Vec<&Setting<'_>> =
        settings.iter().filter(|set| is_within(&set.key, &key) || is_within(&key, &set.key)).collect();
    if at_fault.is_empty() {
        return refusal(&setting_names(settings.iter()), format!("{file}: {key}: {problem}"));
    }
    refusal(&setting_names(at_fault.into_iter()), problem)
}
