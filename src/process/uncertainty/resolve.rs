//! Checks of `[uncertainty]` as written, which make it an [`Uncertainty`].

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use super::{
    Distribution, Draws, ForceSpread, ModelError, Role, Setup, SpreadSource, UncertainParameter, Uncertainty,
    Z_95_INTERVAL,
    covariance::Covariance,
    draws::Distributions,
    spec::{
        ChainErrorToleranceSpec, ForceComponentsSpec, MachineUncertaintySpec, ParameterUncertaintySpec,
        ProcessUncertaintySpec, SpreadSpec, UncertaintySpec,
    },
    varies,
};
use crate::{
    FOR_PAGES,
    input::{
        Folder, Inputs,
        check::Check,
        error::{Error, Result},
        toml_file,
    },
    machine::{Accuracy, ChainError, Grade, Machine, Parameter, Stated, Unit, is_pattern_of},
    process::file::chain_errors::unknown_chain,
};

/// Most parameters that vary.
const MAX_PARAMETERS: usize = 200;
/// Most tools whose force varies by itself: each takes two dimensions of the draws, and one for each component of the force.
const MAX_TOOLS: usize = 20;
/// What the model of a machine leaves out of which nobody says it: as much of its displacements as that of a measured arm left, with published
/// stiffnesses (FANUC R-2000iC, `studies/07_robot_arm`).
const MODEL_ERROR: f64 = 0.26;
/// What the best models fitted to others of its displacements left out.
pub(super) const FITTED_MODEL_ERROR: f64 = 0.19;
/// Largest standard deviation over the nominal value.
pub(super) const LARGEST_RELATIVE_STD: f64 = 2.0;
/// Standard deviation over the value of stiffnesses of a machine file without an interval, by grade.
///
/// Published values of one joint differ: 12 joints of KUKA's 270 and 500 kg classes and 6 of a FANUC R-2000iC in two sources each (papers, theses, a fit of the same measurements) have a root mean
/// square of the logarithms of their ratios of 1.02, and of 0.80 without the one that differs 16 times. Of one source that is 0.57, a deviation of 0.6. What was assumed is no better known. A maker gives
/// the gear without bearings and housing, which is softer by a fifth to a third; fits of measurements have 95 % intervals of 7 to 34 % where the data say something, and leave out
/// what the model does.
const STIFFNESS_STD: [f64; 4] = [0.6, 0.3, 0.2, 0.6];
/// The same of elastic constants: handbooks differ by some per cent for one alloy, and alloys are taken for one another.
const MATERIAL_STD: [f64; 4] = [0.05, 0.05, 0.1, 0.3];
/// The same of masses: drawings have no cables, oil and screws.
const MASS_STD: [f64; 4] = [0.1, 0.05, 0.1, 0.3];

/// Returns the standard deviation over its value of a `parameter` of this grade without an interval.
fn graded_std(grade: Grade, parameter: &Parameter) -> f64 {
    let of_grade = match parameter.unit {
        Unit::KG => MASS_STD,
        _ if parameter.name.starts_with("material.") => MATERIAL_STD,
        _ => STIFFNESS_STD,
    };
    of_grade[grade as usize]
}

/// Standard deviation over its value of a cutting force that nobody measured. Two sources of one steel give a drill 2191 and 1312 N (docs/your_force.md), K_tc of one aluminium is 600 to 1319
/// N/mm² (`materials.toml`): logarithms of ratios of 0.51 and 0.79, of one source 0.36 and more.
pub const UNMEASURED_FORCE_STD: f64 = 0.35;

/// Parts of names of parameters that are limits, or by which commands are computed and forces applied: what they do is not a displacement of the
/// tool from where it is commanded.
const NOT_VARIED: [&str; 12] = [
    "home",
    "workspace",
    "travel",
    "limits",
    "force_limit",
    "torque_limit",
    "backlash",
    "friction",
    "shown",
    "tool_tip",
    "tool_axis",
    "gravity",
];

/// Largest rotation of the workpiece: its displacements are taken as linear in it, which turns them by half of it.
const LARGEST_ROTATION_DEG: f64 = 5.0;
/// Key of the rotation of the workpiece.
const WORKPIECE_ROTATION: &str = "process.workpiece_rotation_deg";

/// What is known of the cutting force of a path where its uncertain inputs are checked.
#[derive(Debug, Clone, Copy)]
pub struct CutBy<'a> {
    /// Whether a force acts.
    pub has_force: bool,
    /// Whether it is the sum of components, [`Process::component_loads`](crate::process::Process::component_loads).
    pub has_components: bool,
    /// Numbers of the tools that cut at its points.
    pub tools: &'a [Option<u32>],
}

impl CutBy<'_> {
    /// A force that acts or not, without a path.
    pub fn anywhere(has_force: bool) -> Self {
        Self { has_force, has_components: false, tools: &[] }
    }
}

/// The table `[uncertainty]` of a study or a process with its covariance, before it is checked for a machine.
#[derive(Debug, Clone)]
pub struct UncertaintyTable {
    spec: UncertaintySpec,
    /// The file with the covariance, and its path in errors.
    covariance: Option<(Vec<u8>, String)>,
    /// Where it is, for errors.
    pub check: Check,
}

impl UncertaintyTable {
    /// The table of a machine alone: as its file says how sure its numbers are; `check` names it in errors.
    pub fn of_machine_file(check: Check) -> Self {
        let spec = UncertaintySpec { machine: Some(MachineUncertaintySpec::Provenance), ..UncertaintySpec::default() };
        Self { spec, covariance: None, check }
    }

    /// Reads the files of the table at `check`, relative to `folder`, and returns them as inputs, too.
    ///
    /// # Errors
    /// A file that is not there, or cannot be read.
    pub fn read(spec: &UncertaintySpec, folder: &Folder, check: Check) -> Result<(Self, Inputs)> {
        let (mut covariance, mut inputs) = (None, Inputs::default());
        if let Some(file) = spec.covariance.as_ref().filter(|_| !FOR_PAGES) {
            if !folder.has_file(file) {
                return check.key("covariance").fail(format!("\"{file}\" is not a file in its folder"));
            }
            let bytes = folder.bytes(file)?;
            inputs = Inputs::of(file, String::from_utf8_lossy(&bytes).into_owned());
            covariance = Some((bytes.to_vec(), folder.path(file).display().to_string()));
        }
        Ok((Self { spec: spec.clone(), covariance, check }, inputs))
    }

    /// Checks the table as [`UncertaintyTable::of`] does, for a box in which any workpiece may stand.
    ///
    /// # Errors
    /// As [`UncertaintyTable::of`]; a rotation of the workpiece, which has no centre there.
    pub fn of_box(&self, machine: &Machine, errors: &[ChainError]) -> Result<Uncertainty> {
        match self.spec.process.as_ref().and_then(|own| own.workpiece_rotation_deg) {
            Some(_) => self.check.key(WORKPIECE_ROTATION).fail("turns a workpiece about its origin, and a correction in the control holds wherever one stands: expected a program, a path or a placement, or no such key".into()),
            None => self.of(machine, errors),
        }
    }

    /// Checks the table for the nominal `machine` with chain `errors`.
    ///
    /// # Errors
    /// Patterns that name no parameter, parameters named twice, deviations that make no machine, a covariance of another machine.
    pub fn of(&self, machine: &Machine, errors: &[ChainError]) -> Result<Uncertainty> {
        self.of_path(machine, errors, &CutBy::anywhere(true))
    }

    /// Checks the table as [`UncertaintyTable::of`] does, for a load at one place, which some tool makes and is not made of components.
    ///
    /// # Errors
    /// As [`UncertaintyTable::of`].
    pub fn of_one_load(&self, machine: &Machine, errors: &[ChainError]) -> Result<Uncertainty> {
        self.of_path(machine, errors, &CutBy { tools: &[Some(0)], ..CutBy::anywhere(true) })
    }

    /// Checks the table as [`UncertaintyTable::of`] does, for a path that is `cut` so.
    ///
    /// # Errors
    /// As [`UncertaintyTable::of`]; tool wear where no force acts, forces of each tool where no point has one, or of too many, components of a force that has none.
    pub fn of_path(&self, machine: &Machine, errors: &[ChainError], cut: &CutBy<'_>) -> Result<Uncertainty> {
        let process = self.spec.process.clone().unwrap_or_default();
        if process.force_component_relative_std.is_some() && !cut.has_components {
            let problem = "is of a path, a program or a placement whose force is known by its components: expected path_frame, slot_milling, end_milling with its mean or drilling, for each tool and feature, without [stock]";
            return self.check.key("process.force_component_relative_std").fail(problem.into());
        }
        if let Some(wear) = process.wear_force_increase.filter(|_| !cut.has_force) {
            let problem = format!(
                "has no effect, as the process has no cutting force: expected a force in it or no such key, got {wear}"
            );
            return self.check.key("process.wear_force_increase").fail(problem);
        }
        let covariance = self.covariance.as_ref().map(|(bytes, origin)| (&bytes[..], &origin[..]));
        resolve(&self.spec, covariance, machine, errors, cut.tools, &self.check)
    }
}

impl Uncertainty {
    /// Parses and checks a table given as TOML text, for the nominal `machine` without chain errors; `origin` names it in errors, and its files are in
    /// `folder`.
    ///
    /// # Errors
    /// Text of another form, a table that makes no sense for the machine, a file that cannot be read.
    pub fn from_toml(text: &str, origin: &str, folder: impl Into<Folder>, machine: &Machine) -> Result<Self> {
        let spec: UncertaintySpec = toml_file::parse(text, origin)?;
        UncertaintyTable::read(&spec, &folder.into(), Check::new(origin))?.0.of(machine, &[])
    }
}

/// Refuses the table at `check` for what is called `name`, which computes with exact inputs.
///
/// # Errors
/// Always.
pub fn refuse<T>(check: &Check, name: &str) -> Result<T> {
    check.fail(format!(
        "is not computed for {name}: expected a workspace map, a path, a placement, a superposition study, a program to compensate, a correction table, real-time code or an online study, or no such table"
    ))
}

/// Returns how far the control leads the tool from where it is commanded, once for a machine and once for a run of the program: normally distributed, alike along the axes of the base.
fn stated_accuracy(accuracy: &Accuracy) -> impl Iterator<Item = UncertainParameter> {
    let along = |stated: &Stated, setup: fn(usize) -> Setup| {
        let spread = Distribution::Difference { below: stated.axis_std_mm, above: stated.axis_std_mm };
        [0, 1, 2].map(|axis| UncertainParameter {
            values: Vec::new(),
            unit: Unit::MM,
            spread,
            role: Role::Setup(setup(axis)),
            source: SpreadSource::Provenance,
        })
    };
    let systematic = accuracy.systematic().map(|own| along(own, Setup::Accuracy));
    systematic.into_iter().chain(accuracy.repeatability.as_ref().map(|own| along(own, Setup::Repeatability))).flatten()
}

/// Checks the table at `check` for the nominal `machine` with chain `errors`; `covariance` is its file with the name for errors.
///
/// # Errors
/// Patterns that name no parameter, parameters named twice, deviations that make no machine, a covariance of another machine.
fn resolve(
    spec: &UncertaintySpec,
    covariance: Option<(&[u8], &str)>,
    machine: &Machine,
    errors: &[ChainError],
    cutting: &[Option<u32>],
    check: &Check,
) -> Result<Uncertainty> {
    let (machine, designs) = machine.with_separate_mounts().or_else(|error| check.fail(error.to_string()))?;
    let mut found = Found { all: machine.parameters(), machine: &machine, designs, parameters: Vec::new() };
    for (i, entry) in spec.parameter.iter().enumerate() {
        found.add_entry(entry, &check.key(&format!("parameter[{i}]")))?;
    }
    for (i, entry) in spec.chain_error.iter().enumerate() {
        found.add_tolerances(entry, &check.key(&format!("chain_error[{i}]")))?;
    }
    // Its decompositions would make pages larger by a hundredth.
    if FOR_PAGES && spec.covariance.is_some() {
        return check.key("covariance").fail("is not read in pages".into());
    }
    let covariance = covariance.filter(|_| !FOR_PAGES);
    let covariance = covariance.map(|(bytes, origin)| Covariance::read(bytes, origin)).transpose()?;
    let (mut correlated, mut dropped_correlations, mut factor) = (Vec::new(), Vec::new(), DMatrix::zeros(0, 0));
    if let Some(covariance) = &covariance {
        let taken = found.add_from_covariance(covariance, errors, &check.key("covariance"))?;
        factor = covariance.correlation_factor(&taken.iter().map(|(own, _)| *own).collect::<Vec<_>>());
        correlated = taken.iter().map(|(_, parameter)| *parameter).collect();
        let is_cut = |own: &usize| taken.iter().all(|(taken, _)| taken != own);
        dropped_correlations = (0..covariance.parameters.len())
            .filter(is_cut)
            .map(|own| covariance.parameters[own].name.clone())
            .collect();
    }
    let is_exact_by_choice = spec.machine == Some(MachineUncertaintySpec::Exact);
    if !is_exact_by_choice {
        found.add_from_provenance(&check.key("machine"))?;
    }
    for open in covariance.iter().flat_map(|own| &own.open) {
        let may_vary = |own: &Parameter| found.may_vary(&own.name) && !varies(&found.parameters, &own.name);
        let named = found.named(open);
        if !named.is_empty() && named.iter().all(may_vary) {
            return check.key("covariance").fail(format!(
                "the measurements left {open} open: expected an entry [[uncertainty.parameter]] that says how well it is known"
            ));
        }
    }
    let process = spec.process.clone().unwrap_or_default();
    found.add_setup(&process, check)?;
    let mut parameters = found.parameters;
    let is_of_file = |own: &UncertainParameter| matches!(own.source, SpreadSource::Provenance | SpreadSource::Grade(_));
    let finds_no_provenance =
        spec.machine == Some(MachineUncertaintySpec::Provenance) && !parameters.iter().any(is_of_file);
    if parameters.len() > MAX_PARAMETERS {
        return check
            .fail(format!("at most {MAX_PARAMETERS} parameters may vary by themselves, got {}", parameters.len()));
    }
    parameters.extend(stated_accuracy(&machine.accuracy));
    let (force, tools) = force_spread(&process, cutting, check)?;
    let model = model_error(spec, covariance.as_ref().and_then(|own| own.model), check)?;
    let model_varies = model.relative_std > 0.0 && model.source != SpreadSource::Grade(Grade::Assumed);
    if parameters.is_empty() && force.is_exact() && !model_varies {
        let nothing = match spec.machine {
            Some(MachineUncertaintySpec::Exact) => {
                "varies nothing: expected covariance, parameter, chain_error, model or process beside machine = \"exact\""
            }
            Some(_) => {
                "varies nothing: the machine file has neither intervals nor graded stiffnesses in [[provenance]]"
            }
            None => {
                "varies nothing: the machine file has neither intervals nor graded stiffnesses, expected covariance, parameter, chain_error, model or process"
            }
        };
        return check.fail(nothing.into());
    }
    let (correlated, factor, model_std) = (&correlated[..], &factor, model.relative_std);
    let draws = Draws::new(Distributions { parameters: &parameters, correlated, factor, force, model_std }, spec.seed);
    Ok(Uncertainty {
        machine,
        parameters,
        dropped_correlations,
        finds_no_provenance,
        is_exact_by_choice,
        force,
        tools,
        model,
        draws,
    })
}

/// Returns what the model leaves out: as the table says, else as `identified`, else as assumed.
fn model_error(spec: &UncertaintySpec, identified: Option<f64>, check: &Check) -> Result<ModelError> {
    Ok(match (spec.model, identified) {
        (Some(own), _) => {
            let relative_std = relative_std(own.relative_std, &check.key("model.relative_std"))?;
            ModelError { relative_std, source: SpreadSource::Given }
        }
        (None, Some(relative_std)) => ModelError { relative_std, source: SpreadSource::Identified },
        (None, None) => ModelError { relative_std: MODEL_ERROR, source: SpreadSource::Grade(Grade::Assumed) },
    })
}

/// Checks how the cutting force varies, and returns it with the tools that have a force each, of those that are `cutting`.
fn force_spread(
    process: &ProcessUncertaintySpec,
    cutting: &[Option<u32>],
    check: &Check,
) -> Result<(ForceSpread, Vec<u32>)> {
    let share_of_force = |key: &str, given: Option<f64>| -> Result<Option<f64>> {
        let share = given.map(|own| relative_std(own, &check.key(key))).transpose()?;
        Ok(share.filter(|own| *own > 0.0))
    };
    let sharp = share_of_force("process.force_relative_std", process.force_relative_std)?;
    let wear = share_of_force("process.wear_force_increase", process.wear_force_increase)?;
    let wear = wear.map(|largest| Distribution::Uniform { least: 0.0, largest });
    let sharp = sharp.map(Distribution::of_relative_std);
    let mut components = [None; ForceSpread::COMPONENTS.len()];
    let given = process.force_component_relative_std.filter(|_| !FOR_PAGES);
    if let Some(ForceComponentsSpec { tangential, radial, axial }) = given {
        let key = "process.force_component_relative_std";
        for (own, (name, given)) in
            [("tangential", tangential), ("radial", radial), ("axial", axial)].into_iter().enumerate()
        {
            components[own] = share_of_force(&format!("{key}.{name}"), given)?.map(Distribution::of_relative_std);
        }
        if components.iter().all(Option::is_none) {
            return check.key(key).fail("varies nothing: expected tangential, radial or axial above 0".into());
        }
    }
    let mut force = ForceSpread { sharp, wear, components, other_tools: 0 };
    let mut tools: Vec<u32> = Vec::new();
    if process.force_per_tool {
        let check = check.key("process.force_per_tool");
        if force.is_exact() {
            let problem = "has no effect: expected force_relative_std, force_component_relative_std or wear_force_increase beside it";
            return check.fail(problem.into());
        }
        for tool in cutting.iter().flatten() {
            if !tools.contains(tool) {
                tools.push(*tool);
            }
        }
        let most = 2 * MAX_TOOLS / (2 + force.varied_components().count());
        if !(1..=most).contains(&tools.len()) {
            return check.fail(format!(
                "expected a path, a program or a placement that says which tool cuts, 1 to {most} of them, got {}",
                tools.len()
            ));
        }
    }
    force.other_tools = tools.len().saturating_sub(1);
    Ok((force, tools))
}

/// Parameters found so far.
struct Found<'a> {
    machine: &'a Machine,
    all: Vec<Parameter>,
    /// The design of each chain that is mounted several times, by the name of its copy.
    designs: BTreeMap<String, String>,
    parameters: Vec<UncertainParameter>,
}

impl Found<'_> {
    /// Name of the parameter as the machine file has it, of the design and not of its mounting; `None` if it is of no copy of a design.
    fn name_in_design(&self, name: &str) -> Option<String> {
        let of = |(copy, design): (&String, &String)| {
            let rest = name.strip_prefix(copy.as_str()).filter(|rest| rest.starts_with('.'))?;
            Some((copy.len(), format!("{design}{rest}")))
        };
        self.designs.iter().filter_map(of).max().map(|(_, name)| name)
    }

    /// Whether the parameter called `name` moves the tool, and not the workpiece.
    fn may_vary(&self, name: &str) -> bool {
        let of_carrier =
            |carrier: &Machine| name.strip_prefix(&*carrier.name).is_some_and(|rest| rest.starts_with('.'));
        !name.split('.').any(|part| NOT_VARIED.contains(&part))
            && !self.machine.carrier.as_ref().is_some_and(of_carrier)
    }

    /// Names of a parameter: its own, and that which the machine file has for all mountings of its design.
    fn names(&self, parameter: &Parameter) -> Vec<String> {
        let is_of_design = parameter.key.as_ref().is_some_and(|key| key.starts_with("chain["));
        let in_design = self.name_in_design(&parameter.name).filter(|_| is_of_design);
        std::iter::once(parameter.name.clone()).chain(in_design).collect()
    }

    /// Parameters of an entry that may vary, in groups that have the same draws: those whose name, or name in their design, matches `pattern`, all
    /// mountings of a design together if `shared`, and the entries of a link's matrix that matches, as one by one they make no stiffness.
    fn matching(&self, pattern: &str, shared: bool, check: &Check) -> Result<Vec<Vec<Parameter>>> {
        let mut groups = Groups::default();
        let mut refused = None;
        for own in &self.all {
            let names = self.names(own);
            let is_matched = names.iter().any(|name| is_pattern_of(pattern, name));
            let is_entry = || names.iter().filter_map(|name| matrix_of(name)).any(|name| is_pattern_of(pattern, name));
            let is_whole = !is_matched && is_entry();
            if !is_matched && !is_whole {
                continue;
            }
            if !self.may_vary(&own.name) {
                refused.get_or_insert(&own.name);
                continue;
            }
            let in_design = if shared { self.name_in_design(&own.name) } else { None };
            let name = in_design.unwrap_or_else(|| own.name.clone());
            let key = matrix_of(&name).filter(|_| is_whole).unwrap_or(&name);
            groups.add(key, own.clone());
        }
        match (groups.found.is_empty(), refused) {
            (false, _) => Ok(groups.found.into_iter().map(|(_, own)| own).collect()),
            (true, Some(name)) => check.fail(format!(
                "{name} cannot vary: it is a limit, of the workpiece carrier, or commands and forces are computed with it; expected a stiffness, \
                 section, length, mass or error of a chain"
            )),
            (true, None) => {
                // Says the nearest names.
                let error = self.machine.parameter(pattern).err().map_or_else(String::new, |error| error.to_string());
                check.misfit(error, Vec::new())
            }
        }
    }

    /// Adds the parameters of an entry of the study.
    fn add_entry(&mut self, entry: &ParameterUncertaintySpec, check: &Check) -> Result<()> {
        let ParameterUncertaintySpec { name, shared, std, relative_std, interval_95, uniform } = entry;
        let spec = SpreadSpec { std: *std, relative_std: *relative_std, interval_95: *interval_95, uniform: *uniform };
        let mut groups = self.matching(name, *shared, &check.key("name"))?;
        if relative_std.is_some() && name.contains('*') {
            // What is zero has no share, and a pattern is about the others.
            groups.retain(|own| own.iter().any(|own| own.value != Some(0.0)));
        }
        groups.into_iter().try_for_each(|own| self.add(own, &spec, SpreadSource::Given, check))
    }

    /// Adds the errors of chains of an entry of the study.
    fn add_tolerances(&mut self, entry: &ChainErrorToleranceSpec, check: &Check) -> Result<()> {
        let chains: Vec<usize> = (0..self.machine.chains.len())
            .filter(|i| is_pattern_of(&entry.chain, &self.machine.chains[*i].name))
            .collect();
        if chains.is_empty() {
            return check.key("chain").misfit(unknown_chain(self.machine, &entry.chain), ());
        }
        let tolerances = [
            ("turn_about_drive_axis_deg", "turn", &entry.turn_about_drive_axis_deg),
            ("base_translation_mm", "base.translation.*", &entry.base_translation_mm),
            ("base_rotation_deg", "base.turn.*", &entry.base_rotation_deg),
            ("end_translation_mm", "end.translation.*", &entry.end_translation_mm),
            ("end_rotation_deg", "end.turn.*", &entry.end_rotation_deg),
            ("drive_offsets_mm_or_deg", "*.offset", &entry.drive_offsets_mm_or_deg),
        ];
        if tolerances.iter().all(|(.., spec)| spec.is_none()) {
            let keys = tolerances.map(|(key, ..)| key).join(", ");
            return check.fail(format!("names no error: expected one of {keys}"));
        }
        for (key, parameters, spec) in tolerances {
            let Some(spec) = spec else { continue };
            for chain in &chains {
                let pattern = format!("{}.{parameters}", self.machine.chains[*chain].name);
                let is_error = |own: &&Parameter| own.key.is_none() && is_pattern_of(&pattern, &own.name);
                let named: Vec<Parameter> = self.all.iter().filter(is_error).cloned().collect();
                if named.is_empty() {
                    let name = &self.machine.chains[*chain].name;
                    return check.key(key).fail(format!("chain {name} has no such error, as it has no drive"));
                }
                for own in named {
                    self.add(vec![own], spec, SpreadSource::Given, &check.key(key))?;
                }
            }
        }
        Ok(())
    }

    /// Parameters called `name`, themselves or in their design: of a design, those of all mountings.
    fn named(&self, name: &str) -> Vec<Parameter> {
        self.all.iter().filter(|own| self.names(own).iter().any(|own| own == name)).cloned().collect()
    }

    /// Adds the identified parameters that may vary and are not named so far; returns index in the covariance and in the parameters of each.
    fn add_from_covariance(
        &mut self,
        covariance: &Covariance,
        errors: &[ChainError],
        check: &Check,
    ) -> Result<Vec<(usize, usize)>> {
        // Errors of chains stand in the process.
        let with_errors = self.machine.with_errors(errors).parameters();
        let mut taken = Vec::new();
        for (own, identified) in covariance.parameters.iter().enumerate() {
            let named = self.named(&identified.name);
            let Some(first) = named.first() else {
                // Says the nearest names.
                let error = self.machine.parameter(&identified.name).err();
                check.misfit(error.map_or_else(String::new, |error| error.to_string()), ())?;
                continue;
            };
            if named.iter().any(|own| varies(&self.parameters, &own.name) || !self.may_vary(&own.name)) {
                continue;
            }
            let value_of = |parameter: &Parameter| {
                let there = with_errors.iter().find(|own| own.name == parameter.name);
                there.and_then(|own| own.value).unwrap_or_default()
            };
            let differs =
                |value: f64| (value - identified.value).abs() > SAME_VALUE * value.abs().max(identified.value.abs());
            if let Some(value) = named.iter().map(value_of).find(|value| differs(*value)) {
                let (name, machine) = (&identified.name, &self.machine.name);
                let expected = match first.key {
                    Some(_) => "the machine file that the identification wrote",
                    None => "the chain errors that the identification wrote (chain_errors.toml)",
                };
                let found = identified.value;
                return check.fail(format!(
                    "{name} is {found} where it was identified and {value} in machine {machine}: expected {expected}"
                ));
            }
            if identified.is_lognormal && !is_positive(first) {
                let name = &identified.name;
                return check
                    .fail(format!("{name} may be negative, and has no logarithm: expected normal as distribution"));
            }
            taken.push((own, self.parameters.len()));
            self.add_with(named, covariance.spread(own), SpreadSource::Identified, check)?;
        }
        Ok(taken)
    }

    /// Adds parameters that are not named so far and have an interval in the machine file, or a grade.
    fn add_from_provenance(&mut self, check: &Check) -> Result<()> {
        let mut groups = Groups::default();
        for own in self.all.iter().filter(|own| self.may_vary(&own.name)) {
            groups.add(matrix_of(&own.name).unwrap_or(&own.name), own.clone());
        }
        for (_, own) in groups.found {
            let is_given = |own: &&Parameter| own.value != Some(0.0);
            let Some(first) = own.iter().find(is_given).or(own.first()).cloned() else { continue };
            let (spec, source) = match (first.interval, first.grade) {
                _ if own.iter().any(|own| varies(&self.parameters, &own.name)) => continue,
                (Some(ends), _) => {
                    (SpreadSpec { interval_95: Some(ends), ..SpreadSpec::default() }, SpreadSource::Provenance)
                }
                (None, Some(grade)) if is_positive(&first) => (
                    SpreadSpec { relative_std: Some(graded_std(grade, &first)), ..SpreadSpec::default() },
                    SpreadSource::Grade(grade),
                ),
                _ => continue,
            };
            let found = self.add(own, &spec, source, check);
            found.or_else(|error| match error {
                Error::Value { problem, .. } => {
                    check.fail(format!("the machine file's [[provenance]] of {}: {problem}", first.name))
                }
                other => Err(other),
            })?;
        }
        Ok(())
    }

    /// Adds how the tool and the workpiece are set up, where `process` says how sure that is.
    fn add_setup(&mut self, process: &ProcessUncertaintySpec, check: &Check) -> Result<()> {
        for setup in Setup::GIVEN {
            let (key, spec, unit) = match setup {
                Setup::ToolLength => ("process.tool_length_mm", process.tool_length_mm, Unit::MM),
                Setup::Workpiece(_) => ("process.workpiece_position_mm", process.workpiece_position_mm, Unit::MM),
                Setup::WorkpieceRotation(_) => (WORKPIECE_ROTATION, process.workpiece_rotation_deg, Unit::DEG),
                Setup::Accuracy(_) | Setup::Repeatability(_) => continue,
            };
            let Some(spec) = spec else { continue };
            let name = setup.name().to_string();
            let exact = Parameter { name, value: Some(0.0), unit, key: None, grade: None, interval: None };
            let spread = spread(&spec, &exact, &check.key(key))?;
            let [low, high] = spread.interval_95(0.0);
            if matches!(setup, Setup::WorkpieceRotation(_)) && low.abs().max(high.abs()) > LARGEST_ROTATION_DEG {
                let problem = format!(
                    "turns the workpiece by more than is taken as small: expected 95 % within ±{LARGEST_ROTATION_DEG}°, got {low:.3} to {high:.3}"
                );
                return check.key(key).fail(problem);
            }
            let (values, role, source) = (Vec::new(), Role::Setup(setup), SpreadSource::Given);
            self.parameters.push(UncertainParameter { values, unit, spread, role, source });
        }
        Ok(())
    }

    /// Whether the undeflected `machine` stands at home as the nominal one: what differs is not where its parts are.
    fn stands_alike(&self, machine: &Machine) -> bool {
        let (nominal, own) = (&self.machine.home, &machine.home);
        let scale = self.machine.characteristic_length;
        let differences = nominal.drives.iter().zip(&own.drives).map(|(a, b)| (a - b).abs());
        let way = (nominal.pose.translation - own.pose.translation).norm();
        let turn = (nominal.pose.rotation - own.pose.rotation).norm() * scale;
        let passive = nominal.passive.iter().flatten().zip(own.passive.iter().flatten()).map(|(a, b)| (a - b).abs());
        differences.chain(passive).fold(way.max(turn), f64::max) <= SAME_HOME * scale
    }

    /// Adds parameters with the same draws, the first that is not zero before the others: it says what their values are.
    fn add(&mut self, mut named: Vec<Parameter>, spec: &SpreadSpec, source: SpreadSource, check: &Check) -> Result<()> {
        named.sort_by_key(|own| own.value == Some(0.0));
        let Some(first) = named.first() else { return Ok(()) };
        let is_factor = spec.relative_std.is_some() && is_positive(first);
        if !is_factor && named.iter().any(|own| own.value != first.value) {
            return check.fail(format!(
                "{} and others of the same name have several values: they vary together by relative_std alone",
                first.name
            ));
        }
        let spread = spread(spec, first, check)?;
        self.add_with(named, spread, source, check)
    }

    /// Adds parameters with the same draws and this distribution.
    fn add_with(
        &mut self,
        named: Vec<Parameter>,
        spread: Distribution,
        source: SpreadSource,
        check: &Check,
    ) -> Result<()> {
        let mut values = Vec::new();
        for own in &named {
            let Some(value) = own.value else {
                let problem = format!("{} is \"unknown\" in the machine file: expected a nominal value", own.name);
                return check.fail(problem);
            };
            if varies(&self.parameters, &own.name) {
                return check.fail(format!("{} is named by an entry before", own.name));
            }
            values.push((own.name.clone(), value));
        }
        let Some(first) = named.first() else { return Ok(()) };
        let role = if first.key.is_none() { Role::ChainError } else { Role::Elasticity };
        let mut own = UncertainParameter { values, unit: first.unit, spread, role, source };
        for z in [-LARGEST_Z, LARGEST_Z] {
            let made = self.machine.with_parameters(&own.at(z).collect::<Vec<_>>());
            let made = made.or_else(|error| {
                check.fail(format!("makes no machine {LARGEST_Z} standard deviations from the nominal one: {error}"))
            })?;
            if own.role == Role::Elasticity && !self.stands_alike(&made) {
                own.role = Role::Geometry;
            }
        }
        self.parameters.push(own);
        Ok(())
    }
}

/// Largest difference of a value from that which was identified, as a share, that is rounding.
const SAME_VALUE: f64 = 1e-9;
/// Standard normal number at which each parameter alone must still make a machine: one of 16,000 is farther.
const LARGEST_Z: f64 = 4.0;
/// Largest difference of configurations at home, as a share of the characteristic length, that is rounding.
const SAME_HOME: f64 = 1e-9;

/// Parameters in groups, by a key, in the order in which the keys came.
#[derive(Default)]
struct Groups {
    found: Vec<(String, Vec<Parameter>)>,
}

impl Groups {
    fn add(&mut self, key: &str, parameter: Parameter) {
        match self.found.iter_mut().find(|(own, _)| own == key) {
            Some((_, group)) => group.push(parameter),
            None => self.found.push((key.into(), vec![parameter])),
        }
    }
}

/// Name of the matrix of which the parameter called `name` is an entry (`leg.rod.stiffness` of `leg.rod.stiffness.x_ry`), whose entries vary
/// together: one by one they make no stiffness. `None` for other parameters.
fn matrix_of(name: &str) -> Option<&str> {
    let (matrix, entry) = name.rsplit_once('.')?;
    let (row, column) = entry.split_once('_')?;
    let is_axis = |axis: &str| ["x", "y", "z", "rx", "ry", "rz"].contains(&axis);
    (is_axis(row) && is_axis(column)).then_some(matrix)
}

/// Whether the parameter must stay positive.
fn is_positive(parameter: &Parameter) -> bool {
    let is_kind = parameter.unit.is_stiffness() || [Unit::KG, Unit::MM_PER_N].contains(&parameter.unit);
    is_kind && parameter.value.is_some_and(|value| value > 0.0)
}

/// Checks a standard deviation over the nominal value.
fn relative_std(value: f64, check: &Check) -> Result<f64> {
    match (0.0..=LARGEST_RELATIVE_STD).contains(&value) {
        true => Ok(value),
        false => check
            .fail(format!("must be from 0 to {LARGEST_RELATIVE_STD}, got {value}: a share of the value, 0.1 is 10 %")),
    }
}

/// Distribution of `parameter`: lognormal where it must stay positive.
fn spread(spec: &SpreadSpec, parameter: &Parameter, check: &Check) -> Result<Distribution> {
    let (nominal, unit) = (parameter.value.unwrap_or_default(), parameter.unit);
    match (spec.std, spec.relative_std, spec.interval_95, spec.uniform) {
        (Some(std), None, None, None) => {
            let check = check.key("std");
            let std = check.not_negative(std)?;
            match is_positive(parameter) {
                true if std > LARGEST_RELATIVE_STD * nominal => check.fail(format!(
                    "must be at most {LARGEST_RELATIVE_STD} times the value, {nominal} {unit}, got {std}"
                )),
                true => Ok(Distribution::of_relative_std(std / nominal)),
                false => Ok(Distribution::Difference { below: std, above: std }),
            }
        }
        (None, Some(relative), None, None) => {
            let check = check.key("relative_std");
            let relative = relative_std(relative, &check)?;
            match nominal {
                _ if is_positive(parameter) => Ok(Distribution::of_relative_std(relative)),
                0.0 => check.fail(format!(
                    "is a share of the value of {}, which is 0: expected std, interval_95 or uniform",
                    parameter.name
                )),
                _ => Ok(Distribution::Difference { below: relative * nominal.abs(), above: relative * nominal.abs() }),
            }
        }
        (None, None, Some(ends), None) => {
            let [low, high] = interval(ends, parameter, &check.key("interval_95"))?;
            match is_positive(parameter) {
                true => {
                    let [below, above] =
                        [nominal / low, high / nominal].map(|factor| libm::log(factor) / Z_95_INTERVAL);
                    let most = Distribution::std_of_logarithm(LARGEST_RELATIVE_STD);
                    match below.max(above) <= most {
                        true => Ok(Distribution::Logarithm { below, above }),
                        false => check.fail(format!(
                            "must be within a factor of {:.1} of the nominal value {nominal} {unit}, got {low} and {high}",
                            libm::exp(most * Z_95_INTERVAL)
                        )),
                    }
                }
                false => Ok(Distribution::Difference {
                    below: (nominal - low) / Z_95_INTERVAL,
                    above: (high - nominal) / Z_95_INTERVAL,
                }),
            }
        }
        (None, None, None, Some(ends)) => {
            let [low, high] = interval(ends, parameter, &check.key("uniform"))?;
            Ok(Distribution::Uniform { least: low - nominal, largest: high - nominal })
        }
        _ => check.fail(format!(
            "expected one of std, relative_std, interval_95 and uniform for {} ({unit})",
            parameter.name
        )),
    }
}

/// Checks an interval that must hold the nominal value of `parameter`, and be positive where that must.
fn interval([low, high]: [f64; 2], parameter: &Parameter, check: &Check) -> Result<[f64; 2]> {
    let nominal = parameter.value.unwrap_or_default();
    let (low, high) = (check.finite_scalar(low)?, check.finite_scalar(high)?);
    if low > high || !(low..=high).contains(&nominal) {
        let Parameter { name, unit, .. } = parameter;
        return check.fail(format!(
            "expected two ascending numbers with the nominal value of {name} between them, {nominal} {unit}, got {low} and {high}"
        ));
    }
    if is_positive(parameter) && low <= 0.0 {
        return check.fail(format!("must be above 0, as {} is, got {low}", parameter.name));
    }
    Ok([low, high])
}
