//! Study folders to start from: the templates of questions, filled with what one machine has.
//!
//! A template says in its own text what it takes from a machine, and what stands there without one.

use std::path::Path;

use minijinja::{
    Environment, UndefinedBehavior, context,
    syntax::SyntaxConfig,
    value::{Serde, Value},
};
use nalgebra::{DVector, Vector3};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::Serialize;

use super::{
    Overrides, Study, Template,
    identification::{LoadedModel, Measurement, Reading, Unknown, unknowns},
    measurement_design::{Region, plan_measurements, poses},
};
use crate::{
    answer::drive_columns::{measured_drive_columns, shown_positions},
    input::{
        Folder,
        check::Check,
        error::{Error, Result},
        toml_file,
    },
    machine::{Machine, Motion, Parameter, catalogue, is_pattern_of},
    statics::{Scratch, principal_stiffnesses, tool_compliance, unloaded_compliance},
};

/// A machine for which a study is begun.
#[derive(Debug, Clone)]
pub struct StudyMachine {
    machine: Machine,
    /// What the study calls it: a built-in machine, or the file in its folder.
    called: String,
    /// Text of its file, if it is not built in.
    text: Option<String>,
}

/// Name of the copy of a machine file in a study's folder, if its own name is taken.
const MACHINE_FILE: &str = "machine.toml";
/// Name of the study file.
const STUDY_FILE: &str = "study.toml";

impl StudyMachine {
    /// Reads the built-in machine called `name`, or else the machine file at this path, which is copied into the study's folder. `Err` if
    /// there is neither, or the file is no machine.
    pub fn named_or_file(name: &str) -> Result<Self> {
        let machine = Machine::named_or_file(name)?;
        if catalogue::find(name).is_some() {
            return Ok(Self { machine, called: name.into(), text: None });
        }
        let text = toml_file::read(Path::new(name))?;
        let own = Path::new(name).file_name().and_then(|own| own.to_str());
        let taken = [STUDY_FILE, "process.toml", "README.md", "measurements.csv"];
        let is_free =
            |own: &&str| !taken.iter().any(|taken| taken.eq_ignore_ascii_case(own)) && catalogue::find(own).is_none();
        let called = own.filter(is_free).unwrap_or(MACHINE_FILE).to_string();
        Ok(Self { machine, called, text: Some(text) })
    }
}

impl Template {
    /// Returns names and texts of a study folder's files, for `machine` or the template's own. `Err` if this machine does not fit it.
    pub fn filled(&self, machine: Option<&StudyMachine>) -> Result<Vec<(String, String)>> {
        let mut environment = Environment::new();
        let fault = |name: &str, fault: &minijinja::Error| Error::Page {
            template: format!("{} of {}", name, self.name),
            problem: format!("{fault:#}"),
        };
        let syntax = SyntaxConfig::builder().trim_blocks(true).keep_trailing_newline(true).build();
        environment.set_syntax(syntax.map_err(|error| fault("syntax", &error))?);
        environment.set_undefined_behavior(match machine {
            Some(_) => UndefinedBehavior::SemiStrict,
            None => UndefinedBehavior::Chainable,
        });
        let Some(machine) = machine else {
            let filled = |(name, text): &(&str, &str)| {
                let filled = environment.render_named_str(name, text, context! {});
                Ok((name.to_string(), filled.map_err(|error| fault(name, &error))?))
            };
            return self.files.iter().map(filled).collect();
        };
        let refuse = |problem: String| {
            Error::argument("--machine", format!("{} is no machine for {}: {problem}", machine.called, self.name))
        };
        let values = MachineValues::of(machine);
        // Arrays as lists, not as tuples.
        let lists = serde_json::to_value(&values)
            .map_err(|error| Error::Page { template: self.name.into(), problem: error.to_string() })?;
        let mut files: Vec<(String, String)> = Vec::new();
        for (name, text) in self.files {
            let filled = match name.ends_with(".csv") {
                true => measurements(&machine.machine, &values.stiffness).map_err(refuse)?,
                false => environment
                    .render_named_str(name, text, Value::from(Serde(&lists)))
                    .map_err(|error| fault(name, &error))?,
            };
            files.push((name.to_string(), filled));
        }
        files.extend(machine.text.iter().map(|text| (machine.called.clone(), text.clone())));
        let in_memory = files.iter().map(|(name, text)| (name.clone(), text.clone().into_bytes()));
        let study = files.iter().find(|(name, _)| name == STUDY_FILE).map_or("", |(_, text)| text);
        match Study::from_toml(study, STUDY_FILE, Folder::in_memory(in_memory), &Overrides::default()) {
            Ok(_) => Ok(files),
            // What is wrong with the machine itself needs no key of a file that is not written.
            Err(Error::Value { key, problem, .. } | Error::Syntax { key, problem, .. }) if key == "machine" => {
                Err(refuse(problem))
            }
            Err(error) => Err(refuse(error.to_string())),
        }
    }
}

/// What templates take from a machine; positions in mm.
#[derive(Debug, Serialize)]
struct MachineValues {
    /// What the study calls the machine, as TOML.
    machine: String,
    errors: Vec<ChainErrors>,
    grid: Grids,
    /// The middle half of the workspace box of P.
    inner_box: [[f64; 3]; 2],
    /// The workspace box, moved to where the tool tip is at home.
    tip_box: [[f64; 3]; 2],
    /// Heights within the workspace box.
    slices: Vec<f64>,
    /// A height within `tip_box`.
    tip_slice: Vec<f64>,
    middle: [f64; 3],
    /// Named point farthest from home, as TOML.
    far: Option<String>,
    /// Named point nearest to home, as TOML.
    near: Option<String>,
    circle: CircleValues,
    /// Ends of a line across the circle.
    line: [[f64; 3]; 2],
    site: SiteValues,
    /// Directions from the tip to the spindle.
    tool_axes: [[f64; 3]; 2],
    stiffness: StiffnessValues,
}

/// Zero-point errors of the drives of a chain.
#[derive(Debug, Serialize)]
struct ChainErrors {
    chain: String,
    offsets: Vec<f64>,
}

/// Grids that have one point along axes on which the workspace has no extent.
#[derive(Debug, Serialize)]
struct Grids {
    fine: [usize; 3],
    coarse: [usize; 3],
    flat: [usize; 3],
}

/// A circle of P that the machine is asked to follow, in the frame in which the workpiece is placed.
#[derive(Debug, Serialize)]
struct CircleValues {
    centre_mm: [f64; 3],
    diameter_mm: f64,
}

/// Where the workpiece may stand, so that the tool tip follows the circle around its origin.
#[derive(Debug, Serialize)]
struct SiteValues {
    sought: Vec<SoughtValue>,
    fixed: Vec<FixedValue>,
    today_mm: [f64; 3],
    table_mm: [[f64; 2]; 2],
    table_z_mm: f64,
    clamp_mm: [[f64; 3]; 2],
}

/// A coordinate of the workpiece that is sought.
#[derive(Debug, Serialize)]
struct SoughtValue {
    name: &'static str,
    range: [f64; 2],
}

/// A coordinate of the workpiece that is fixed.
#[derive(Debug, Serialize)]
struct FixedValue {
    name: &'static str,
    value: f64,
}

/// Stiffnesses that can be identified, and forces under which the tool yields enough to be measured.
#[derive(Debug, Serialize)]
struct StiffnessValues {
    #[serde(serialize_with = "as_toml")]
    unknowns: Vec<String>,
    /// A part of them, as TOML, if there are several.
    some: Option<String>,
    /// One of them, as TOML, its value, and a standard deviation.
    last: String,
    value: f64,
    std: f64,
    #[serde(rename = "forces_N")]
    forces: [[f64; 3]; 3],
}

/// Serializes names as a list in TOML, which has other quotes than lists in templates.
fn as_toml<S: serde::Serializer>(names: &[String], serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.serialize_str(&toml_text(names.to_vec()))
}

/// Returns a text, or a list of texts, as TOML.
fn toml_text(value: impl Into<toml::Value>) -> String {
    value.into().to_string()
}

/// How far chain errors move the tool, about, mm.
const ERROR_MM: f64 = 0.5;
/// Most chains with errors.
const ERRONEOUS: usize = 3;
/// Largest diameter of the circle, mm.
const DIAMETER_MM: f64 = 50.0;
/// How far the tool yields under the forces of measurements, about, mm.
const YIELD_MM: f64 = 2.0;
/// Largest force of measurements, N.
const LARGEST_N: f64 = 1000.0;
/// Angle between the two tool directions.
const TILT_DEG: f64 = 30.0;
const AXES: [&str; 3] = ["x", "y", "z"];

impl MachineValues {
    /// Returns what templates take from the machine, with rounded lengths.
    fn of(study_machine: &StudyMachine) -> Self {
        let machine = &study_machine.machine;
        let (min, max) = (machine.workspace.min, machine.workspace.max);
        let (size, middle, home) = (max - min, 0.5 * (min + max), machine.home.pose);
        let is_wide = |axis: usize| size[axis] > 0.0;
        let counts = |full: [usize; 3]| [0, 1, 2].map(|axis| if is_wide(axis) { full[axis] } else { 1 });
        let lever = home.rotation * machine.tool_tip;
        let by_distance = |sign: f64| {
            let distance = |at: Vector3<f64>| sign * (at - home.translation).norm();
            // Points are places in the base, not on what carries the workpiece.
            let points = machine.points.iter().filter(|_| machine.carrier.is_none());
            points.max_by(|a, b| distance(a.position).total_cmp(&distance(b.position)))
        };
        let narrowest = (0..2).filter(|&axis| is_wide(axis)).map(|axis| size[axis]).fold(2.0 * DIAMETER_MM, f64::min);
        let diameter_mm = round_down(0.5 * narrowest);
        // The circle stays in the box, as near to home as it can.
        let margin = Vector3::new(0.5 * diameter_mm, 0.5 * diameter_mm, 0.0);
        let centre = Vector3::from_fn(|axis, _| match is_wide(axis) {
            true => home.translation[axis].clamp(min[axis] + margin[axis], max[axis] - margin[axis]),
            false => middle[axis],
        });
        let to_workpiece = |at: Vector3<f64>| match &machine.carrier {
            Some(carrier) => carrier.home.pose.inverse().transform(at),
            None => at,
        };
        let on_workpiece = rounded(to_workpiece(centre), 0.1);
        let radius = Vector3::new(0.5 * diameter_mm, 0.0, 0.0);
        Self {
            machine: toml_text(study_machine.called.as_str()),
            errors: chain_errors(machine),
            grid: Grids { fine: counts([7; 3]), coarse: counts([5; 3]), flat: counts([7, 7, 3]) },
            inner_box: [middle - 0.25 * size, middle + 0.25 * size].map(|corner| rounded(corner, 0.1).into()),
            tip_box: [min + lever, max + lever].map(|corner| rounded(corner, 0.1).into()),
            slices: slices([min.z, max.z]),
            tip_slice: vec![height_near(middle.z + lever.z, [min.z + lever.z, max.z + lever.z])],
            middle: rounded(middle, 0.1).into(),
            far: by_distance(1.0).map(|point| toml_text(point.name.as_str())),
            near: by_distance(-1.0).map(|point| toml_text(point.name.as_str())),
            circle: CircleValues { centre_mm: on_workpiece.into(), diameter_mm },
            line: [on_workpiece - radius, on_workpiece + radius].map(Into::into),
            site: SiteValues::of(to_workpiece(middle + lever), to_workpiece(centre + lever), size, diameter_mm),
            tool_axes: tool_axes(machine, middle),
            stiffness: StiffnessValues::of(machine),
        }
    }
}

impl SiteValues {
    /// Chooses places of a workpiece around the `middle` so that a circle of `diameter_mm` stays in a box of `size`, `today` being one; mm.
    fn of(middle: Vector3<f64>, today: Vector3<f64>, size: Vector3<f64>, diameter_mm: f64) -> Self {
        let today = rounded(today, 0.1);
        let clamp_low = [today.x - 2.0 * diameter_mm, today.y - diameter_mm, today.z];
        let clamp_high = [today.x - diameter_mm, today.y + diameter_mm, today.z + diameter_mm];
        let mut site = SiteValues {
            sought: Vec::new(),
            fixed: Vec::new(),
            today_mm: today.into(),
            table_mm: [-0.5, 0.5].map(|share| rounded(middle + share * size, 0.1).xy().into()),
            table_z_mm: today.z - 20.0,
            clamp_mm: [clamp_low, clamp_high],
        };
        for axis in 0..3 {
            let half = 0.5 * (size[axis] - diameter_mm);
            match axis < 2 && size[axis] > 0.0 {
                true => {
                    let step = round_down(0.1 * half);
                    let low = ((middle[axis] - half) / step).ceil() * step + 0.0;
                    let range = [low, ((middle[axis] + half) / step).floor() * step + 0.0];
                    site.sought.push(SoughtValue { name: AXES[axis], range });
                }
                false => site.fixed.push(FixedValue { name: AXES[axis], value: today[axis] }),
            }
        }
        site
    }
}

impl StiffnessValues {
    /// Chooses the stiffnesses of the drives, or else all others, or else elastic moduli; none of a rigid machine.
    fn of(machine: &Machine) -> Self {
        let all = machine.parameters();
        let drives: Vec<String> = machine.drives().map(|(_, drive)| format!(".{}.stiffness", drive.name)).collect();
        let chosen = |is_chosen: &dyn Fn(&str) -> bool| -> Vec<&Parameter> {
            all.iter().filter(|one| one.value.is_some_and(|value| value > 0.0) && is_chosen(&one.name)).collect()
        };
        let kinds: [&dyn Fn(&str) -> bool; 3] = [
            &|name| drives.iter().any(|ending| name.ends_with(ending)),
            &|name| name.ends_with(".stiffness"),
            &|name| name.ends_with(".youngs_modulus"),
        ];
        let stiffnesses = kinds.into_iter().map(chosen).find(|stiffnesses| !stiffnesses.is_empty()).unwrap_or_default();
        let names: Vec<String> = stiffnesses.iter().map(|one| one.name.clone()).collect();
        let pattern = pattern_of(&names).filter(|pattern| {
            all.iter().filter(|one| is_pattern_of(pattern, &one.name)).map(|one| &one.name).eq(names.iter())
        });
        let last = stiffnesses.last();
        let value = last.and_then(|one| one.value).unwrap_or(1.0);
        let force = yielding_force(machine);
        Self {
            some: (names.len() > 1).then(|| toml_text(names[..names.len().div_ceil(2)].to_vec())),
            last: toml_text(last.map_or("", |one| one.name.as_str())),
            value,
            std: 0.2 * value,
            unknowns: pattern.map_or(names, |pattern| vec![pattern]),
            forces: [[force, 0.0, 0.0], [0.0, force, 0.0], [0.0, 0.0, -force]],
        }
    }
}

/// Returns a pattern `head*tail` for names that differ in one part; `None` for fewer than two, or if no name has both ends.
fn pattern_of(names: &[String]) -> Option<String> {
    let [first, rest @ ..] = names else { return None };
    let common = |same: fn(&str, &str) -> usize| rest.iter().map(|other| same(first, other)).min();
    let head = common(|a, b| a.bytes().zip(b.bytes()).take_while(|(a, b)| a == b).count())?;
    let tail = common(|a, b| a.bytes().rev().zip(b.bytes().rev()).take_while(|(a, b)| a == b).count())?;
    let (head, tail) = (first.get(..head)?, first.get(first.len() - tail.min(first.len() - head)..)?);
    Some(format!("{head}*{tail}"))
}

/// Returns zero-point errors of the drives of a machine, by which the tool moves by some tenths of a millimetre.
fn chain_errors(machine: &Machine) -> Vec<ChainErrors> {
    let driven = machine.chains.iter().filter(|chain| !chain.drives.is_empty());
    let errors = driven.take(ERRONEOUS).enumerate().map(|(i, chain)| {
        let offset = |(drive, sign): (&crate::machine::Drive, f64)| match drive.motion {
            Motion::Prismatic => sign * ERROR_MM,
            Motion::Revolute => sign * round_down((ERROR_MM / machine.characteristic_length).to_degrees()),
        };
        let signs = [1.0, -1.0].into_iter().cycle().skip(i);
        ChainErrors {
            chain: toml_text(chain.name.as_str()),
            offsets: chain.drives.iter().zip(signs).map(offset).collect(),
        }
    });
    errors.collect()
}

/// Returns the largest of 1, 2 and 5 times a power of ten that is not above `value`, which is above 0.
fn round_down(value: f64) -> f64 {
    let power = libm::log10(value).floor();
    let digit = [5.0, 2.0].into_iter().find(|digit| digit * libm::pow(10.0, power) <= value).unwrap_or(1.0);
    // Of decimals as they are typed.
    if power < 0.0 { digit / libm::pow(10.0, -power) } else { digit * libm::pow(10.0, power) }
}

/// Returns `at`, mm or without unit, with components rounded to multiples of `step`, a power of ten below 1.
fn rounded(at: Vector3<f64>, step: f64) -> Vector3<f64> {
    at.map(|value| (value / step).round() / (1.0 / step).round() + 0.0)
}

/// Returns the height within the ends, a multiple of a round step, nearest to `z`, mm.
fn height_near(z: f64, [low, high]: [f64; 2]) -> f64 {
    if high <= low {
        return low;
    }
    let step = round_down((high - low) / 8.0);
    ((z / step).round() * step).clamp(low, high) + 0.0
}

/// Returns three round heights between the ends, low, in the middle and high, mm; one where these are the same.
fn slices(ends: [f64; 2]) -> Vec<f64> {
    let [low, high] = ends;
    let mut heights = [0.125, 0.5, 0.875].map(|share| height_near(low + share * (high - low), ends)).to_vec();
    heights.dedup();
    heights
}

/// Returns the unit direction (O) from the tip to the spindle at home, and one tilted by [`TILT_DEG`] towards the base.
fn tool_axes(machine: &Machine, middle: Vector3<f64>) -> [[f64; 3]; 2] {
    let along = -(machine.home.pose.rotation * machine.tool_axes.column(2));
    let to_base = Vector3::new(-middle.x, -middle.y, 0.0).try_normalize(1.0).unwrap_or(-Vector3::x());
    let across = [to_base, -Vector3::x(), Vector3::z()]
        .into_iter()
        .find_map(|side| (side - along * along.dot(&side)).try_normalize(1e-3))
        .unwrap_or(to_base);
    let (sin, cos) = libm::sincos(TILT_DEG.to_radians());
    [along, along * cos + across * sin].map(|axis| rounded(axis, 0.001).into())
}

/// Returns the round force under which the tool yields by about [`YIELD_MM`] at home where it is softest, N.
fn yielding_force(machine: &Machine) -> f64 {
    let lever = machine.home.pose.rotation * machine.tool_tip;
    let softest = unloaded_compliance(machine, &machine.home, &mut Scratch::new(machine))
        .map(|compliance| principal_stiffnesses(&tool_compliance(&compliance, lever))[0]);
    let force = softest.map_or(LARGEST_N, |stiffness| YIELD_MM * stiffness).min(LARGEST_N);
    // NaN too.
    if force >= 1e-3 { round_down(force) } else { LARGEST_N }
}

/// Places at which the template of an identification has the machine measured.
const MEASURED: usize = 16;
/// Factors between the stiffnesses that measure and those of the machine file, one after another.
const FACTORS: [f64; 4] = [0.8, 1.3, 0.7, 1.2];
/// Standard deviation of the measurements, mm.
const NOISE_MM: f64 = 0.01;

/// Returns measurements of `machine` with other stiffnesses, with noise, as the text of a CSV file; `Err` says why there are none.
fn measurements(machine: &Machine, stiffness: &StiffnessValues) -> std::result::Result<String, String> {
    let words = |error: Error| error.to_string();
    if stiffness.unknowns.is_empty() {
        return Err("its file has no stiffness to identify".into());
    }
    let sought: Vec<Unknown> = unknowns(machine, &stiffness.unknowns, &Check::new("unknowns")).map_err(words)?;
    let values: Vec<(&str, f64)> = sought
        .iter()
        .zip(FACTORS.into_iter().cycle())
        .map(|(unknown, factor)| (unknown.name.as_str(), factor * unknown.start))
        .collect();
    let actual = machine.with_parameters(&values).map_err(words)?;
    let model = LoadedModel::new(&actual, &[], &DVector::zeros(0), &[]).map_err(words)?;
    let anywhere = Region { tip: None, forbidden: Vec::new(), branches: Vec::new() };
    let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
    let component = Uniform::new(-1.0, 1.0).map_err(|error| error.to_string())?;
    let (readings, largest_force) = (Reading::planned_displacements(), stiffness.forces[0][0]);
    let mut columns = vec!["pose".to_string()];
    columns.extend(measured_drive_columns(machine));
    columns.extend(["force_x_N", "force_y_N", "force_z_N"].map(String::from));
    columns.extend(readings.iter().map(|reading| reading.column.to_string()));
    let mut text = columns.join(",") + "\n";
    let thousandths = |value: f64| (value * 1e3).round() / 1e3 + 0.0;
    let mut count = 0;
    for at in poses(machine, &anywhere, 2 * MEASURED) {
        // As a person types them.
        let typed: Vec<f64> = shown_positions(machine, &at.drives).into_iter().map(thousandths).collect();
        let drives: Vec<f64> =
            machine.drives().zip(&typed).map(|((_, drive), typed)| drive.motion.from_shown(*typed)).collect();
        let Ok(at) = machine.forward_kinematics(&drives) else { continue };
        let force = Vector3::from_fn(|_, _| thousandths(largest_force * component.sample(&mut random)));
        let planned = plan_measurements(&[at], &[force], &readings);
        let Some(Ok(read)) = model.each(&planned.iter().collect::<Vec<&Measurement>>()).pop() else { continue };
        count += 1;
        let read = read.values.iter().map(|value| {
            let noise: f64 = StandardNormal.sample(&mut random);
            thousandths(value + NOISE_MM * noise)
        });
        let cells: Vec<String> =
            typed.iter().copied().chain(force.iter().copied()).chain(read).map(|cell| cell.to_string()).collect();
        text += &format!("{count},{}\n", cells.join(","));
        if count == MEASURED {
            return Ok(text);
        }
    }
    Err(format!("{count} of {MEASURED} poses were found in its workspace at which it bears {largest_force} N"))
}
