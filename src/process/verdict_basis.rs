//! What a verdict on a path, a program or a place rests on: each cause of error with what machine and process say of it.

use std::collections::{BTreeMap, BTreeSet};

use kinetostat_budget::{Budget, Cause, Entry, Mark};
use nalgebra::Vector3;
use serde::Deserialize;

use super::{
    KnownForce,
    uncertainty::{ForceSpread, Role, SpreadSource, UncertainParameter, Uncertainty},
};
use crate::{
    input::{check::Check, error::Result},
    machine::{ChainError, Grade, Machine, Stated},
};

/// The table `verdict` as written.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct VerdictSpec {
    /// The causes that the verdict is about, which then says so; all if not given.
    causes: Option<Vec<Cause>>,
    /// Causes with a bound that the program does not compute.
    #[serde(default)]
    known: BTreeMap<Cause, KnownSpec>,
}

/// A bound as written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct KnownSpec {
    /// How far it moves the tool or the surface at most; 0 of what was checked and is none.
    mm: f64,
    /// How it is known.
    grade: BoundGrade,
    /// Who says so.
    source: String,
}

/// How a bound is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum BoundGrade {
    /// Measured on this machine.
    Measured,
    /// By a computation or a check elsewhere.
    Bounded,
    /// In a maker's data sheet.
    DataSheet,
    /// Taken because it is likely.
    Assumed,
}

/// The table `temperature` as written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TemperatureSpec {
    /// Farthest that the machine is from the temperature at which the workpiece was located, K.
    #[serde(rename = "change_K")]
    change_kelvin: f64,
    /// Thermal expansion of its links, such as 12e-6 of steel, 1/K.
    #[serde(rename = "expansion_per_K")]
    expansion_per_kelvin: f64,
    /// How the change is known.
    grade: BoundGrade,
    /// Who says so.
    source: String,
}

impl TemperatureSpec {
    /// Returns by how much the links of `machine` move the tool tip at most, one after another: α·ΔT along the chain; unknown of several chains, whose
    /// legs move the platform by more than they grow.
    fn resolve(&self, machine: &Machine, check: &Check) -> Result<Entry> {
        let change = check.key("change_K").not_negative(self.change_kelvin)?;
        let expansion = check.key("expansion_per_K").positive(self.expansion_per_kelvin)?;
        if expansion > LARGEST_EXPANSION {
            let problem = format!("is {expansion} per K, expected at most {LARGEST_EXPANSION}: steel has 12e-6");
            return check.key("expansion_per_K").fail(problem);
        }
        let all = std::iter::once(machine).chain(&machine.carrier);
        let lengths: Option<Vec<f64>> = all.map(Machine::serial_length_mm).collect();
        let Some(lengths) = lengths else {
            let why = "the machine has several chains, of which α·L is no bound: give one in [verdict.known.heat]";
            return Ok(Entry::unknown(Cause::Heat, why));
        };
        let length: f64 = lengths.iter().sum();
        let source = format!("{}{change} K on {:.2} m of links: {}", self.grade.text(), length / 1000.0, self.source);
        Ok(Entry::bound(Cause::Heat, change * expansion * length, self.grade.mark(), source))
    }
}

/// Largest thermal expansion that is taken for one, 1/K: that of plastics.
const LARGEST_EXPANSION: f64 = 3e-4;

impl BoundGrade {
    fn mark(self) -> Mark {
        match self {
            Self::Measured | Self::Bounded => Mark::Full,
            Self::DataSheet | Self::Assumed => Mark::Half,
        }
    }

    fn text(self) -> &'static str {
        if self == Self::Assumed { "assumed: " } else { "" }
    }
}

/// The table `verdict`, checked.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VerdictTable {
    scope: Option<Vec<Cause>>,
    known: Vec<Entry>,
}

/// What is computed by the program itself, of which no bound is taken.
const COMPUTED: [Cause; 2] = [Cause::Force, Cause::ForceUncertainty];

impl VerdictTable {
    /// Checks the tables of the file at `check` for `machine`.
    pub(crate) fn resolve(
        spec: &VerdictSpec,
        temperature: Option<&TemperatureSpec>,
        machine: &Machine,
        file: &Check,
    ) -> Result<Self> {
        let check = &file.key("verdict");
        if spec.causes.as_ref().is_some_and(Vec::is_empty) {
            return check.key("causes").fail("is empty: expected at least one cause, or no such key".into());
        }
        let known = |(cause, spec): (&Cause, &KnownSpec)| -> Result<Entry> {
            let name = cause.text().replace(' ', "_");
            let check = check.key(&format!("known.{name}"));
            if COMPUTED.contains(cause) {
                return check.fail(format!(
                    "{} is computed, or taken from [uncertainty]: expected another cause",
                    cause.text()
                ));
            }
            let twice = match cause {
                Cause::Accuracy => machine.accuracy.systematic().is_some(),
                Cause::Repeatability => machine.accuracy.repeatability.is_some(),
                _ => false,
            };
            if twice {
                return check.fail(format!(
                    "the machine file states its {} already, which must not count twice: expected one of them",
                    cause.text()
                ));
            }
            if *cause == Cause::Heat && temperature.is_some_and(|_| machine.serial_length_mm().is_some()) {
                return check
                    .fail("[temperature] gives it already, which must not count twice: expected one of them".into());
            }
            let mm = check.key("mm").not_negative(spec.mm)?;
            Ok(Entry::bound(*cause, mm, spec.grade.mark(), format!("{}{}", spec.grade.text(), spec.source)))
        };
        let mut scope = spec.causes.clone();
        scope.iter_mut().for_each(|own| {
            own.sort();
            own.dedup();
        });
        let mut known = spec.known.iter().map(known).collect::<Result<Vec<_>>>()?;
        let heat = temperature.map(|own| own.resolve(machine, &file.key("temperature"))).transpose()?;
        known.extend(heat.filter(|heat| known.iter().all(|own| own.cause != heat.cause)));
        Ok(Self { scope, known })
    }
}

/// What of a path, a program or a place is known besides machine and process.
#[derive(Debug, Clone, Copy)]
pub struct Basis<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Errors of its chains.
    pub errors: &'a [ChainError],
    /// What is sampled; `None` where inputs are nominal.
    pub uncertainty: Option<&'a Uncertainty>,
    /// How much of the force is known; `None` where there is no force.
    pub force: Option<KnownForce>,
    /// Half the widest interval in which open backlash and friction leave the tool, mm; `None` where it was not assessed.
    pub open_backlash_mm: Option<f64>,
    /// Largest programmed feed of the tool where it cuts, mm/s; `None` unless all cuts have one.
    pub fastest_mm_per_s: Option<f64>,
    /// Whether the number is of a program as written, with its digits.
    pub is_written: bool,
}

impl Basis<'_> {
    /// Returns what is known of each cause, with what `table` says: a bound of what is known otherwise comes on top of it.
    pub fn budget(&self, table: &VerdictTable) -> Budget {
        let mut budget = Budget::default();
        let asks_accuracy = table.scope.as_ref().is_none_or(|own| own.contains(&Cause::Accuracy));
        let own = [
            self.force(),
            self.weight(),
            self.force_uncertainty(),
            self.stiffness(),
            self.geometry(asks_accuracy),
            self.accuracy(),
            self.stated(Cause::Repeatability, self.machine.accuracy.repeatability.as_ref()),
            self.backlash(),
            match self.is_written {
                true => Entry::counted(Cause::Rounding, Mark::Full, "simulated as written"),
                false => Entry::unknown(Cause::Rounding, "no program is written here"),
            },
            Entry::unknown(Cause::Heat, "neither [temperature] nor a bound in [verdict.known]"),
            Entry::unknown(Cause::Bodies, "not assessed: holder, clamps, wrist"),
            Entry::unknown(Cause::Vibration, "not computed"),
        ];
        for own in own {
            let bound = table.known.iter().find(|bound| bound.cause == own.cause);
            budget.set(match bound {
                Some(bound) => own.plus(bound.clone()),
                None => own,
            });
        }
        budget.within(table.scope.clone())
    }

    fn force(&self) -> Entry {
        match self.force {
            None => Entry::unknown(Cause::Force, "no cutting force is given"),
            Some(KnownForce::Everywhere) => Entry::counted(Cause::Force, Mark::Full, "simulated"),
            Some(KnownForce::Partly) => Entry::unknown(Cause::Force, "not known everywhere"),
            Some(KnownForce::Nowhere) => Entry::unknown(Cause::Force, "known nowhere"),
        }
    }

    fn weight(&self) -> Entry {
        match self.machine.gravity == Vector3::zeros() {
            true => Entry::counted(Cause::Weight, Mark::Full, "no gravity in the machine file"),
            false if self.machine.has_weight() => {
                Entry::counted(Cause::Weight, Mark::Half, "simulated, with the masses of the machine file")
            }
            false => Entry::unknown(Cause::Weight, "no mass in the machine file"),
        }
    }

    fn force_uncertainty(&self) -> Entry {
        match self.uncertainty {
            None => Entry::unknown(Cause::ForceUncertainty, "inputs are nominal: no [uncertainty]"),
            Some(own)
                if own.force.sharp.is_none()
                    && own.force.varied_components().count() < ForceSpread::COMPONENTS.len() =>
            {
                Entry::unknown(Cause::ForceUncertainty, "force_relative_std: taken as exact")
            }
            Some(_) => Entry::counted(Cause::ForceUncertainty, Mark::Half, "as [uncertainty.process] gives it"),
        }
    }

    fn stiffness(&self) -> Entry {
        let Some(own) = self.uncertainty else {
            return Entry::unknown(Cause::Stiffness, "inputs are nominal: no [uncertainty]");
        };
        let varied: Vec<&UncertainParameter> =
            own.parameters.iter().filter(|own| own.role == Role::Elasticity).collect();
        let fixed = varied.iter().find(|own| own.interval_95()[0] == own.interval_95()[1]);
        if let Some(exact) = own.exact_stiffnesses().next().or(fixed.map(|own| own.name().into())) {
            return Entry::unknown(Cause::Stiffness, format!("{exact} is taken as exact"));
        }
        if varied.is_empty() || own.model.relative_std == 0.0 {
            let what = if varied.is_empty() { "no stiffness varies" } else { "the model is taken as exact" };
            return Entry::unknown(Cause::Stiffness, what);
        }
        let is_identified = |own: SpreadSource| own == SpreadSource::Identified;
        let other = varied.iter().map(|own| own.source).chain([own.model.source]).find(|own| !is_identified(*own));
        match other {
            None => Entry::counted(Cause::Stiffness, Mark::Full, "identified"),
            Some(other) => Entry::counted(Cause::Stiffness, Mark::Half, other.label().replace('_', " ")),
        }
    }

    fn geometry(&self, asks_accuracy: bool) -> Entry {
        if self.machine.accuracy.has_geometry() && asks_accuracy {
            return Entry::counted(Cause::Geometry, Mark::Half, "in the accuracy, which is from the base");
        }
        let is_geometry = |role: Role| matches!(role, Role::Geometry | Role::ChainError);
        let varied = self.uncertainty.iter().flat_map(|own| &own.parameters).filter(|own| is_geometry(own.role));
        let sources: Vec<SpreadSource> = varied.map(|own| own.source).collect();
        let chains = self.machine.chains.iter();
        let given =
            chains.zip(self.errors).filter(|(_, own)| **own != ChainError::default()).map(|own| own.0.name.as_str());
        let varied = self.uncertainty.iter().flat_map(|own| &own.parameters).filter(|own| is_geometry(own.role));
        let varied = varied.flat_map(|own| &own.values).filter_map(|own| own.0.split('.').next());
        let known = given.chain(varied).collect::<BTreeSet<&str>>().len();
        match sources.as_slice() {
            [] if known == 0 => Entry::unknown(Cause::Geometry, "no error of a chain and no calibration is given"),
            _ if known < self.machine.chains.len() => {
                Entry::unknown(Cause::Geometry, format!("errors of only {known} chains are given"))
            }
            _ if self.machine.carrier.is_some() => {
                Entry::unknown(Cause::Geometry, "nothing is given of the workpiece carrier")
            }
            [] => Entry::counted(Cause::Geometry, Mark::Half, "errors of chains, taken as exact"),
            all if all.iter().all(|own| *own == SpreadSource::Identified) => {
                Entry::counted(Cause::Geometry, Mark::Full, "identified")
            }
            _ => Entry::counted(Cause::Geometry, Mark::Half, "as [uncertainty] gives it"),
        }
    }

    /// What is stated of poses says nothing of paths: without AT it is known in part.
    fn accuracy(&self) -> Entry {
        let accuracy = &self.machine.accuracy;
        let mut own = self.stated(Cause::Accuracy, accuracy.systematic());
        // What is larger along an axis may be said by a smaller distance.
        own.mm = accuracy.path.iter().chain(&accuracy.pose).map(|stated| stated.mm).reduce(f64::max);
        let lacks = match (&accuracy.path, self.fastest_mm_per_s) {
            _ if own.mark == Mark::Hollow => return own,
            (None, _) => "of poses alone, no path accuracy (AT) is stated".into(),
            (Some(_), None) => "at a speed, and not every cut has a feed".into(),
            (Some(path), Some(fastest)) if path.speed_mm_per_s.is_none_or(|at| fastest > at * (1.0 + 1e-9)) => {
                format!("the tool cuts at up to {fastest:.0} mm/s")
            }
            _ => return own,
        };
        own.lacking(&lacks)
    }

    /// A stated accuracy: sampled where inputs are uncertain, else a bound.
    fn stated(&self, cause: Cause, stated: Option<&Stated>) -> Entry {
        let Some(stated) = stated else {
            return Entry::unknown(cause, "not in [accuracy] of the machine file");
        };
        let mark = if stated.grade == Grade::Identified { Mark::Full } else { Mark::Half };
        let at = stated.speed_mm_per_s.map_or_else(String::new, |own| format!(", at {own} mm/s"));
        let source = format!("{}{at}: {}", stated.grade.label().replace('_', " "), stated.source);
        match self.uncertainty {
            Some(_) => Entry::counted(cause, mark, source).of_mm(stated.mm),
            None => Entry::bound(cause, stated.mm, mark, source),
        }
    }

    fn backlash(&self) -> Entry {
        let without = self.machine.drives().filter(|(_, drive)| drive.half_backlash == 0.0).count();
        match (without, self.open_backlash_mm) {
            (drives @ 1.., open) if open.is_none_or(|open| open == 0.0) => {
                Entry::unknown(Cause::Backlash, format!("not in the machine file of {drives} drives"))
            }
            (_, None) => Entry::unknown(Cause::Backlash, "not assessed by this question"),
            (drives, Some(open)) => {
                let text = "machine file: what is open; loaded flanks are simulated";
                let own = Entry::bound(Cause::Backlash, open, Mark::Half, text);
                match drives {
                    _ if self.machine.carrier.as_ref().is_some_and(|own| own.drive_count() > 0) => {
                        own.lacking("the workpiece carrier is not assessed")
                    }
                    0 => own,
                    drives => own.lacking(&format!("not in the machine file of {drives} drives")),
                }
            }
        }
    }
}
