//! Measurements on a loaded machine, as a CSV file has them: a row for each place and load.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::{
    input::{
        check::Check,
        csv_rows::{self, line_number},
        error::Result,
    },
    machine::{Configuration, Machine, Motion},
};

/// One row: where the machine was sent, how it was loaded, and what was read.
#[derive(Debug, Clone)]
pub struct Measurement {
    /// What it is called: the column `pose`, or its number in the file.
    pub name: String,
    /// Its line in the file, from 1; 0 if it is of none.
    pub line: usize,
    /// Where the unloaded machine of the study stands.
    pub at: Configuration,
    /// The load.
    pub load: Applied,
    /// The load under which displacements and rotations are zero.
    pub reference: Applied,
    /// The point measured, seen from P in the platform's axes, mm; the tool tip if not given.
    pub marker: Option<Vector3<f64>>,
    /// What was read.
    pub readings: Vec<Reading>,
}

/// A load on the tool tip, in the axes of O.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Applied {
    /// N.
    pub force: Vector3<f64>,
    /// N·mm.
    pub moment: Vector3<f64>,
}

/// A number that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The column.
    pub column: &'static str,
    /// What it is of.
    pub quantity: Quantity,
    /// mm or rad.
    pub value: f64,
    /// Its standard deviation, mm or rad, if the file says it.
    pub std: Option<f64>,
}

/// What is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quantity {
    /// Displacement of the marker from where it is under the reference load, along this unit vector of O, mm.
    Displacement(Vector3<f64>),
    /// Coordinate of the marker in O, mm.
    Position(usize),
    /// Component of the rotation from the reference load, axes of O, rad.
    Rotation(usize),
}

impl Measurement {
    /// The same place, loaded from rest by `load`, where the tool tip is to be read.
    pub fn at_same_place(&self, load: Applied, readings: &[Reading]) -> Self {
        let nothing = Applied { force: Vector3::zeros(), moment: Vector3::zeros() };
        let (name, at) = (self.name.clone(), self.at.clone());
        Self { name, line: self.line, at, load, reference: nothing, marker: None, readings: readings.to_vec() }
    }
}

impl Reading {
    /// Whether it is of what the load changes, and not of where the machine stands.
    pub fn is_change(&self) -> bool {
        !matches!(self.quantity, Quantity::Position(_))
    }

    /// Those that need no direction of a gauge, still to be made: displacements first.
    pub fn all_to_come() -> Vec<Self> {
        [DISPLACEMENT, POSITION, ROTATION].into_iter().flatten().filter_map(Self::to_come).collect()
    }

    /// Displacements of the tool tip along the axes of O, still to be made.
    pub fn displacements_to_come() -> Vec<Self> {
        DISPLACEMENT.into_iter().filter_map(Self::to_come).collect()
    }

    /// A reading of this column that is still to be made; `None` where it is none, or needs to know along what.
    fn to_come(column: &'static str) -> Option<Self> {
        let at = |columns: [&str; 3]| columns.iter().position(|other| *other == column);
        let quantity = at(DISPLACEMENT)
            .map(|axis| Quantity::Displacement(Vector3::ith(axis, 1.0)))
            .or_else(|| at(POSITION).map(Quantity::Position))
            .or_else(|| at(ROTATION).map(Quantity::Rotation))?;
        Some(Self { column, quantity, value: 0.0, std: None })
    }
}

impl Quantity {
    /// Whether it is a rotation.
    pub fn is_rotation(self) -> bool {
        matches!(self, Self::Rotation(_))
    }
}

const DISPLACEMENT: [&str; 3] = ["displacement_x_mm", "displacement_y_mm", "displacement_z_mm"];
const POSITION: [&str; 3] = ["position_x_mm", "position_y_mm", "position_z_mm"];
const ROTATION: [&str; 3] = ["rotation_x_deg", "rotation_y_deg", "rotation_z_deg"];
const GAUGE: &str = "gauge_mm";
const GAUGE_ALONG: [&str; 3] = ["gauge_along_x", "gauge_along_y", "gauge_along_z"];
pub(super) const FORCE: [&str; 3] = ["force_x_N", "force_y_N", "force_z_N"];
const MOMENT: [&str; 3] = ["moment_x_Nmm", "moment_y_Nmm", "moment_z_Nmm"];
const REFERENCE_FORCE: [&str; 3] = ["reference_force_x_N", "reference_force_y_N", "reference_force_z_N"];
const REFERENCE_MOMENT: [&str; 3] = ["reference_moment_x_Nmm", "reference_moment_y_Nmm", "reference_moment_z_Nmm"];
const MARKER: [&str; 3] = ["marker_x_mm", "marker_y_mm", "marker_z_mm"];
const COMMAND: [&str; 3] = ["command_x_mm", "command_y_mm", "command_z_mm"];
const STD: [&str; 2] = ["std_mm", "std_deg"];
const NAME: &str = "pose";

fn known() -> impl Iterator<Item = &'static str> {
    let vectors = [
        COMMAND,
        FORCE,
        MOMENT,
        REFERENCE_FORCE,
        REFERENCE_MOMENT,
        MARKER,
        DISPLACEMENT,
        POSITION,
        ROTATION,
        GAUGE_ALONG,
    ];
    vectors.into_iter().flatten().chain([GAUGE, NAME]).chain(STD)
}

/// Columns that say where a drive stands: name, and what makes mm or rad of it.
fn drive_columns(machine: &Machine) -> Vec<Vec<(String, f64)>> {
    let names: Vec<&str> = machine.drives().map(|(_, drive)| drive.name.as_str()).collect();
    let of = |((_, drive), label): ((usize, &crate::machine::Drive), String)| {
        let is_only = names.iter().filter(|name| **name == drive.name).count() == 1;
        let words = [Some(label), is_only.then(|| drive.name.clone())].into_iter().flatten();
        let units: &[(&str, f64)] = match drive.motion {
            Motion::Prismatic => &[("mm", 1.0)],
            Motion::Revolute => &[("deg", std::f64::consts::PI / 180.0), ("rad", 1.0)],
        };
        words.flat_map(|word| units.iter().map(move |(unit, factor)| (format!("{word}_{unit}"), *factor))).collect()
    };
    machine.drives().zip(machine.drive_labels()).map(of).collect()
}

/// A row with its numbers by column; empty cells are not there.
struct Cells<'a> {
    columns: &'a [String],
    numbers: BTreeMap<&'a str, f64>,
    check: Check,
    line: usize,
}

/// Readings are not known better than this, mm or degrees: a nanometre.
const LEAST_STD: f64 = 1e-6;

/// How well a reading is known, as written.
pub(super) fn std(given: f64, check: &Check) -> Result<f64> {
    match check.positive(given)? {
        std if std < LEAST_STD => check.fail(format!("must be at least {LEAST_STD:e}, got {std:e}")),
        std => Ok(std),
    }
}

impl Cells<'_> {
    fn get(&self, column: &str) -> Option<f64> {
        self.numbers.get(column).copied()
    }

    /// All three, or none.
    fn vector(&self, columns: [&str; 3]) -> Result<Option<Vector3<f64>>> {
        let found = columns.map(|column| self.get(column));
        match found {
            [Some(x), Some(y), Some(z)] => Ok(Some(Vector3::new(x, y, z))),
            [None, None, None] => Ok(None),
            _ => {
                let missing = columns.iter().zip(found).find(|(_, value)| value.is_none()).map_or("", |(name, _)| name);
                self.check.key(missing).fail("missing beside the other two components".into())
            }
        }
    }

    /// Components without a column are zero, and all of them where no cell is filled.
    fn load(&self, force: [&str; 3], moment: [&str; 3]) -> Result<Applied> {
        let of = |columns: [&str; 3]| {
            let is_empty = |column: &&str| self.get(column).is_none() && self.columns.iter().any(|own| own == column);
            let has_some = columns.iter().any(|column| self.get(column).is_some());
            match columns.iter().find(|column| has_some && is_empty(column)) {
                Some(column) => self.check.key(column).fail("empty beside other components: expected a number".into()),
                None => Ok(Vector3::from(columns.map(|column| self.get(column).unwrap_or(0.0)))),
            }
        };
        Ok(Applied { force: of(force)?, moment: of(moment)? })
    }
}

/// What rows are read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WhatFor {
    /// What was read there: each row has at least one reading.
    Readings,
    /// Poses and loads alone: readings have no effect.
    Places,
    /// Poses and loads whose readings are predicted: a row may have some.
    Predictions,
}

/// Reads the measurements of `machine` in `source`, called `file` in messages.
///
/// # Errors
/// A column that is unknown, repeated or missing; a cell that is no number; a place that the machine does not reach.
pub fn read(source: &[u8], file: &str, machine: &Machine, what_for: WhatFor) -> Result<Vec<Measurement>> {
    let at_line = |at: usize| Check::new(&format!("{file}:{}", line_number(source, at)));
    if let Err(fault) = std::str::from_utf8(source) {
        return at_line(fault.valid_up_to()).key("row").fail("is no text in UTF-8".into());
    }
    let rows = match csv_rows::read(source) {
        Ok(rows) => rows,
        Err((at, reason)) => return at_line(at).key("row").fail(format!("is not CSV: {reason}")),
    };
    let drives = drive_columns(machine);
    let Some((header, rows)) = rows.split_first() else {
        return at_line(0).key("header").fail("missing: expected the names of the columns".into());
    };
    let names: Vec<String> = header.fields.iter().map(|name| String::from_utf8_lossy(name).into_owned()).collect();
    let check = at_line(header.span.start);
    for (i, name) in names.iter().enumerate() {
        let is_known = known().any(|other| other == name) || drives.iter().flatten().any(|(other, _)| other == name);
        if !is_known {
            let own: Vec<&str> =
                drives.iter().filter_map(|columns| columns.first()).map(|(name, _)| name.as_str()).collect();
            let others: Vec<&str> = known().collect();
            let problem = format!("unknown column; expected any of {}, {}", own.join(", "), others.join(", "));
            return check.key(name).fail(problem);
        }
        if names[..i].contains(name) {
            return check.key(name).fail("second column of this name; expected one".into());
        }
    }
    for columns in &drives {
        let mut given = columns.iter().map(|(name, _)| name).filter(|name| names.contains(name));
        if let (Some(first), Some(second)) = (given.next(), given.next()) {
            return check
                .key(second)
                .fail(format!("says where the same drive stands as the column {first}: expected one"));
        }
    }
    let mut measurements = Vec::with_capacity(rows.len());
    for (number, row) in rows.iter().enumerate() {
        let check = at_line(row.span.start);
        if row.fields.len() != names.len() {
            let problem = format!("has {} values; expected {}, as many as columns", row.fields.len(), names.len());
            return check.key("row").fail(problem);
        }
        let (mut numbers, mut called) = (BTreeMap::new(), format!("{}", number + 1));
        for (name, field) in names.iter().zip(&row.fields) {
            let text = String::from_utf8_lossy(field);
            match (name.as_str(), text.is_empty()) {
                (_, true) => {}
                (NAME, false) => called = text.into_owned(),
                (name, false) => match text.parse::<f64>() {
                    Ok(value) if value.is_finite() => {
                        numbers.insert(name, check.key(name).finite_scalar(value)?);
                    }
                    _ => return check.key(name).fail(format!("must be a number, got `{text}`")),
                },
            }
        }
        let line = line_number(source, row.span.start);
        let cells = Cells { columns: &names, numbers, check, line };
        measurements.push(measurement(called, &cells, &drives, machine, what_for)?);
    }
    match measurements.is_empty() {
        true => at_line(source.len()).key("row").fail("missing: expected a row for each measurement".into()),
        false => Ok(measurements),
    }
}

fn measurement(
    name: String,
    cells: &Cells<'_>,
    drives: &[Vec<(String, f64)>],
    machine: &Machine,
    what_for: WhatFor,
) -> Result<Measurement> {
    Ok(Measurement {
        name,
        line: cells.line,
        at: place(cells, drives, machine, what_for)?,
        load: cells.load(FORCE, MOMENT)?,
        reference: cells.load(REFERENCE_FORCE, REFERENCE_MOMENT)?,
        marker: cells.vector(MARKER)?,
        readings: match what_for {
            WhatFor::Readings => readings(cells)?,
            WhatFor::Predictions if has_reading(cells) => readings(cells)?,
            WhatFor::Places | WhatFor::Predictions => Vec::new(),
        },
    })
}

/// Where the machine of the study stands.
///
/// Where something was read the drives stood, whatever the machine file has as travel.
fn place(
    cells: &Cells<'_>,
    drives: &[Vec<(String, f64)>],
    machine: &Machine,
    what_for: WhatFor,
) -> Result<Configuration> {
    let given = |columns: &Vec<(String, f64)>| columns.iter().find_map(|(name, unit)| Some(cells.get(name)? * unit));
    // A column that is not there is called as those of other drives are.
    let form = |drive: usize| drives[drive].iter().position(|(name, _)| cells.columns.contains(name));
    let usual = (0..drives.len()).find_map(form).unwrap_or_default();
    let column = |drive: usize| {
        let (name, _) = drives[drive].get(form(drive).unwrap_or(usual)).unwrap_or(&drives[drive][0]);
        name.clone()
    };
    let positions: Vec<Option<f64>> = drives.iter().map(given).collect();
    let command = cells.vector(COMMAND)?;
    let found = match (positions.iter().any(Option::is_some), command) {
        (false, Some(position)) => machine.command(position).map_err(|fault| (COMMAND[0].to_string(), fault)),
        (true, None) => {
            if let Some(missing) = positions.iter().position(Option::is_none) {
                return cells
                    .check
                    .key(&column(missing))
                    .fail("missing beside the positions of the other drives".into());
            }
            let positions: Vec<f64> = positions.into_iter().flatten().collect();
            match machine.drive_beyond_travel(&positions) {
                Some((drive, fault)) if what_for == WhatFor::Places => Err((column(drive), fault)),
                _ => machine.forward_kinematics(&positions).map_err(|fault| (column(0), fault)),
            }
        }
        _ => {
            let own: Vec<&str> = drives.iter().map(|columns| columns[0].0.as_str()).collect();
            let problem =
                format!("give either the positions of the drives ({}) or {} of P", own.join(", "), COMMAND.join(", "));
            return cells.check.key(COMMAND[0]).fail(problem);
        }
    };
    found.or_else(|(column, fault)| cells.check.key(&column).fail(fault.to_string()))
}

fn has_reading(cells: &Cells<'_>) -> bool {
    [DISPLACEMENT, POSITION, ROTATION].into_iter().flatten().chain([GAUGE]).any(|column| cells.get(column).is_some())
}

fn readings(cells: &Cells<'_>) -> Result<Vec<Reading>> {
    let mut readings = Vec::new();
    let given = |column: &str| cells.get(column).map(|own| std(own, &cells.check.key(column))).transpose();
    let (std_mm, std_rad) = (given(STD[0])?, given(STD[1])?.map(f64::to_radians));
    let mut add = |column: &'static str, quantity: Quantity, value: f64| {
        let (value, std) = if quantity.is_rotation() { (value.to_radians(), std_rad) } else { (value, std_mm) };
        readings.push(Reading { column, quantity, value, std });
    };
    for column in (0..3).flat_map(|axis| [DISPLACEMENT[axis], POSITION[axis], ROTATION[axis]]) {
        if let (Some(value), Some(Reading { quantity, .. })) = (cells.get(column), Reading::to_come(column)) {
            add(column, quantity, value);
        }
    }
    if let Some(value) = cells.get(GAUGE) {
        let Some(along) = cells.vector(GAUGE_ALONG)? else {
            return cells
                .check
                .key(GAUGE_ALONG[0])
                .fail("missing: expected the direction along which the gauge reads".into());
        };
        add(GAUGE, Quantity::Displacement(cells.check.key(GAUGE_ALONG[0]).direction(along.into())?), value);
    }
    match readings.is_empty() {
        true => cells.check.key("row").fail(format!(
            "nothing was read: expected a number in any of {}, {}, {}, {GAUGE}",
            DISPLACEMENT.join(", "),
            POSITION.join(", "),
            ROTATION.join(", ")
        )),
        false => Ok(readings),
    }
}
