//! Measurements on a loaded machine, read from a CSV file: a row for each pose and load.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::{
    input::{
        check::Check,
        csv_rows::{self, line_number},
        error::Result,
        names::listed,
    },
    machine::{Configuration, Machine, Motion},
};

/// One measurement: commanded configuration, load, and readings.
#[derive(Debug, Clone)]
pub struct Measurement {
    /// Name of the pose: the column `pose`, or the number of the row from 1.
    pub name: String,
    /// Number of the pose, from 0 by first appearance. Rows of one name, or whose drives stand alike, share what the model lacks there.
    pub pose: usize,
    /// Line in the file, from 1; 0 if it is from none.
    pub line: usize,
    /// Configuration of the unloaded machine of the study at the commanded drive positions or position of P.
    pub at: Configuration,
    /// Load when it was read.
    pub load: AppliedLoad,
    /// Load under which displacements and rotations are zero.
    pub reference: AppliedLoad,
    /// Measured point, from P in platform axes, mm; the tool tip if not given.
    pub marker: Option<Vector3<f64>>,
    /// Readings under the load.
    pub readings: Vec<Reading>,
}

/// Drives that stand nearer to those of another row are at its pose, mm and degrees: files round positions, and what a model lacks changes little
/// on such a way.
const SAME_POSE: f64 = 0.05;

/// Sets the number of the pose of each row: that of the rows of its name, or of the first pose whose drives stand as its own do, whatever it
/// is called, as on another day.
fn number_poses(rows: &mut [Measurement], machine: &Machine) {
    let nearness: Vec<f64> = machine.drives().map(|(_, drive)| drive.motion.from_shown(SAME_POSE)).collect();
    let is_near = |a: &[f64], b: &[f64]| a.iter().zip(b).zip(&nearness).all(|((a, b), near)| (a - b).abs() <= *near);
    let (mut by_name, mut count) = (BTreeMap::new(), 0);
    // The pose and the drives of its first row, by the place of its first drive.
    let mut standing = BTreeMap::<i64, Vec<(usize, Vec<f64>)>>::new();
    for row in rows {
        let drives = &row.at.drives;
        let place = drives.first().zip(nearness.first()).map_or(0, |(at, near)| (at / near).floor() as i64);
        let beside = (place - 1..=place + 1).filter_map(|place| standing.get(&place)).flatten();
        let found = by_name.get(&row.name).or(beside.into_iter().find(|own| is_near(&own.1, drives)).map(|own| &own.0));
        row.pose = found.copied().unwrap_or(count);
        if row.pose == count {
            count += 1;
            standing.entry(place).or_default().push((row.pose, drives.clone()));
        }
        by_name.insert(row.name.clone(), row.pose);
    }
}

/// A load on the tool tip, in the axes of O.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AppliedLoad {
    /// Force, N.
    pub force: Vector3<f64>,
    /// Moment about the tool tip, N·mm.
    pub moment: Vector3<f64>,
}

/// One reading of a measurement, made or planned.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Column of the file.
    pub column: &'static str,
    /// Measured quantity.
    pub quantity: Quantity,
    /// Value, mm or rad; 0 if planned.
    pub value: f64,
    /// Standard deviation of the value, mm or rad, if the file gives it.
    pub std: Option<f64>,
}

/// Quantity of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quantity {
    /// Displacement of the marker from its position under the reference load, along this unit vector of O, mm.
    Displacement(Vector3<f64>),
    /// Coordinate of the marker in O along this axis, mm.
    Position(usize),
    /// Component of the rotation from the reference load about this axis of O, rad.
    Rotation(usize),
}

impl Measurement {
    /// Returns a planned measurement in the same configuration under `load`, from no load, with these readings of the tool tip.
    pub fn planned_under(&self, load: AppliedLoad, readings: &[Reading]) -> Self {
        let no_load = AppliedLoad { force: Vector3::zeros(), moment: Vector3::zeros() };
        let (name, pose, at) = (self.name.clone(), self.pose, self.at.clone());
        Self { name, pose, line: self.line, at, load, reference: no_load, marker: None, readings: readings.to_vec() }
    }
}

impl Reading {
    /// Whether the reading is of a change by the load (displacement or rotation), not a position.
    pub fn is_change(&self) -> bool {
        !matches!(self.quantity, Quantity::Position(_))
    }

    /// Returns planned readings of all columns that need no gauge direction, displacements first.
    pub fn all_planned() -> Vec<Self> {
        [DISPLACEMENT, POSITION, ROTATION].into_iter().flatten().filter_map(Self::planned).collect()
    }

    /// Returns planned readings of the displacement of the tool tip along the axes of O.
    pub fn planned_displacements() -> Vec<Self> {
        DISPLACEMENT.into_iter().filter_map(Self::planned).collect()
    }

    /// Returns a planned reading of this column; `None` if the column is no reading, or is a gauge, which needs a direction.
    fn planned(column: &'static str) -> Option<Self> {
        let axis_in = |columns: [&str; 3]| columns.iter().position(|other| *other == column);
        let quantity = axis_in(DISPLACEMENT)
            .map(|axis| Quantity::Displacement(Vector3::ith(axis, 1.0)))
            .or_else(|| axis_in(POSITION).map(Quantity::Position))
            .or_else(|| axis_in(ROTATION).map(Quantity::Rotation))?;
        Some(Self { column, quantity, value: 0.0, std: None })
    }
}

impl Quantity {
    /// Whether the quantity is a rotation.
    pub fn is_rotation(self) -> bool {
        matches!(self, Self::Rotation(_))
    }
}

const DISPLACEMENT: [&str; 3] = ["displacement_x_mm", "displacement_y_mm", "displacement_z_mm"];
const POSITION: [&str; 3] = ["position_x_mm", "position_y_mm", "position_z_mm"];
const ROTATION: [&str; 3] = ["rotation_x_deg", "rotation_y_deg", "rotation_z_deg"];
/// Columns of readings that are vectors of O.
pub(super) const READ_VECTORS: [[&str; 3]; 3] = [DISPLACEMENT, POSITION, ROTATION];
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

/// Returns the names of all columns that a file may have, but for drive positions.
fn known_columns() -> impl Iterator<Item = &'static str> {
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

/// Returns for each drive the columns that may give its position: name, and factor from its unit to mm or rad.
fn drive_columns(machine: &Machine) -> Vec<Vec<(String, f64)>> {
    let names: Vec<&str> = machine.drives().map(|(_, drive)| drive.name.as_str()).collect();
    let columns_of = |((_, drive), label): ((usize, &crate::machine::Drive), String)| {
        let is_only = names.iter().filter(|name| **name == drive.name).count() == 1;
        let text = [Some(label), is_only.then(|| drive.name.clone())].into_iter().flatten();
        let units: &[(&str, f64)] = match drive.motion {
            Motion::Prismatic => &[("mm", 1.0)],
            Motion::Revolute => &[("deg", std::f64::consts::PI / 180.0), ("rad", 1.0)],
        };
        text.flat_map(|word| units.iter().map(move |(unit, factor)| (format!("{word}_{unit}"), *factor))).collect()
    };
    machine.drives().zip(machine.drive_labels()).map(columns_of).collect()
}

/// Numbers of one row by column, without its empty cells, and where the row is.
struct RowCells<'a> {
    columns: &'a [String],
    numbers: BTreeMap<&'a str, f64>,
    check: Check,
    line: usize,
}

/// Smallest standard deviation of a reading, mm or degrees: a nanometre.
const LEAST_STD: f64 = 1e-6;

/// Returns the standard deviation `written` in a file, mm or degrees; `Err` if it is not positive or below [`LEAST_STD`].
pub(super) fn checked_std(written: f64, check: &Check) -> Result<f64> {
    match check.positive(written)? {
        std if std < LEAST_STD => check.fail(format!("must be at least {LEAST_STD:e}, got {std:e}")),
        std => Ok(std),
    }
}

impl RowCells<'_> {
    /// Returns the number in a column of the row; `None` if the cell is empty or the column missing.
    fn cell(&self, column: &str) -> Option<f64> {
        self.numbers.get(column).copied()
    }

    /// Returns the vector in three columns of the row; `None` if all are empty, `Err` if only some are.
    fn vector(&self, columns: [&str; 3]) -> Result<Option<Vector3<f64>>> {
        let cells = columns.map(|column| self.cell(column));
        match cells {
            [Some(x), Some(y), Some(z)] => Ok(Some(Vector3::new(x, y, z))),
            [None, None, None] => Ok(None),
            _ => {
                let missing = columns.iter().zip(cells).find(|(_, value)| value.is_none()).map_or("", |(name, _)| name);
                self.check.key(missing).fail("missing beside the other two components".into())
            }
        }
    }

    /// Returns the load in these columns, N and N·mm; 0 where they are missing or all empty, `Err` if only some of three are empty.
    fn load(&self, force: [&str; 3], moment: [&str; 3]) -> Result<AppliedLoad> {
        let vector_of = |columns: [&str; 3]| {
            let is_empty = |column: &&str| self.cell(column).is_none() && self.columns.iter().any(|c| c == column);
            let has_some = columns.iter().any(|column| self.cell(column).is_some());
            match columns.iter().find(|column| has_some && is_empty(column)) {
                Some(column) => self.check.key(column).fail("empty beside other components: expected a number".into()),
                None => Ok(Vector3::from(columns.map(|column| self.cell(column).unwrap_or(0.0)))),
            }
        };
        Ok(AppliedLoad { force: vector_of(force)?, moment: vector_of(moment)? })
    }
}

/// Purpose for which rows are read, which decides whether they must have readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowUse {
    /// Measurements: each row has at least one reading.
    Readings,
    /// Poses and loads alone: readings are ignored, and drives must be within their travel.
    Poses,
    /// Poses and loads at which readings are predicted: a row may have measured ones.
    Predictions,
}

/// Reads the measurements of `machine` in the CSV text `source`, called `file` in messages; `purpose` says whether rows must have readings.
///
/// # Errors
/// A column that is unknown, repeated or missing; a cell that is no number; a pose that the machine cannot take.
pub fn read(source: &[u8], file: &str, machine: &Machine, purpose: RowUse) -> Result<Vec<Measurement>> {
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
    let is_known = |name: &&String| {
        known_columns().any(|other| other == *name) || drives.iter().flatten().any(|(other, _)| other == *name)
    };
    let unknown: Vec<&str> = names.iter().filter(|name| !is_known(name)).map(String::as_str).collect();
    if !unknown.is_empty() {
        let drive_names = drives.iter().filter_map(|columns| columns.first()).map(|(name, _)| name.clone());
        let expected = drive_names.chain(known_columns().map(String::from)).collect::<Vec<_>>().join(", ");
        if unknown.len() == names.len() {
            // What is no table of measurements may be anybody's file, which no message shows.
            let problem = format!("has no column of a table of measurements; expected any of {expected}");
            return check.key("header").fail(problem);
        }
        let what = if unknown.len() == 1 { "unknown column" } else { "unknown columns" };
        return check.key(&listed(unknown)).fail(format!("{what}; expected any of {expected}"));
    }
    for (i, name) in names.iter().enumerate() {
        if names[..i].contains(name) {
            return check.key(name).fail("second column of this name; expected one".into());
        }
    }
    for columns in &drives {
        let mut used = columns.iter().map(|(name, _)| name).filter(|name| names.contains(name));
        if let (Some(first), Some(second)) = (used.next(), used.next()) {
            return check
                .key(second)
                .fail(format!("says where the same drive stands as the column {first}: expected one"));
        }
    }
    let mut measurements = Vec::with_capacity(rows.len());
    for (number, row) in rows.iter().enumerate() {
        let check = Check::new(&format!("{file}:{}", row.line));
        if row.fields.len() != names.len() {
            let problem = format!("has {} values; expected {}, as many as columns", row.fields.len(), names.len());
            return check.key("row").fail(problem);
        }
        let (mut numbers, mut pose_name) = (BTreeMap::new(), format!("{}", number + 1));
        for (name, field) in names.iter().zip(&row.fields) {
            let text = String::from_utf8_lossy(field);
            match (name.as_str(), text.is_empty()) {
                (_, true) => {}
                (NAME, false) => pose_name = text.into_owned(),
                (name, false) => match text.parse::<f64>() {
                    Ok(value) if value.is_finite() => {
                        numbers.insert(name, check.key(name).finite_scalar(value)?);
                    }
                    _ => return check.key(name).fail(format!("must be a number, got `{text}`")),
                },
            }
        }
        let cells = RowCells { columns: &names, numbers, check, line: row.line };
        measurements.push(row_measurement(pose_name, &cells, &drives, machine, purpose)?);
    }
    number_poses(&mut measurements, machine);
    match measurements.is_empty() {
        true => at_line(source.len())
            .key("row")
            .fail("missing: there are names of columns and no measurements below; add a row for each".into()),
        false => Ok(measurements),
    }
}

/// Makes the measurement of one row, from its name and cells and the position columns of each drive.
fn row_measurement(
    name: String,
    cells: &RowCells<'_>,
    drives: &[Vec<(String, f64)>],
    machine: &Machine,
    purpose: RowUse,
) -> Result<Measurement> {
    Ok(Measurement {
        name,
        pose: 0,
        line: cells.line,
        at: configuration(cells, drives, machine, purpose)?,
        load: cells.load(FORCE, MOMENT)?,
        reference: cells.load(REFERENCE_FORCE, REFERENCE_MOMENT)?,
        marker: cells.vector(MARKER)?,
        readings: match purpose {
            RowUse::Readings => row_readings(cells)?,
            RowUse::Predictions if has_reading(cells) => row_readings(cells)?,
            RowUse::Poses | RowUse::Predictions => Vec::new(),
        },
    })
}

/// Returns the configuration of the unloaded machine at the drive positions, or the commanded position of P, in a row.
///
/// A position beyond the travel is an error only for [`RowUse::Poses`]: at a pose where something was read, the drives did stand.
fn configuration(
    cells: &RowCells<'_>,
    drives: &[Vec<(String, f64)>],
    machine: &Machine,
    purpose: RowUse,
) -> Result<Configuration> {
    let read = |columns: &Vec<(String, f64)>| columns.iter().find_map(|(name, unit)| Some(cells.cell(name)? * unit));
    // A column that is not there is called as those of other drives are.
    let form = |drive: usize| drives[drive].iter().position(|(name, _)| cells.columns.contains(name));
    let usual = (0..drives.len()).find_map(form).unwrap_or_default();
    let column = |drive: usize| {
        let (name, _) = drives[drive].get(form(drive).unwrap_or(usual)).unwrap_or(&drives[drive][0]);
        name.clone()
    };
    let positions: Vec<Option<f64>> = drives.iter().map(read).collect();
    let command = cells.vector(COMMAND)?;
    let reached = match (positions.iter().any(Option::is_some), command) {
        (false, Some(position)) => {
            machine.inverse_kinematics_at(position).map_err(|fault| (COMMAND[0].to_string(), fault))
        }
        (true, None) => {
            if let Some(missing) = positions.iter().position(Option::is_none) {
                return cells
                    .check
                    .key(&column(missing))
                    .fail("missing beside the positions of the other drives".into());
            }
            let positions: Vec<f64> = positions.into_iter().flatten().collect();
            match machine.drive_beyond_travel(&positions) {
                Some((drive, fault)) if purpose == RowUse::Poses => Err((column(drive), fault)),
                _ => machine.forward_kinematics(&positions).map_err(|fault| (column(0), fault)),
            }
        }
        _ => {
            let all: Vec<&str> = drives.iter().map(|columns| columns[0].0.as_str()).collect();
            let problem =
                format!("give either the positions of the drives ({}) or {} of P", all.join(", "), COMMAND.join(", "));
            return cells.check.key(COMMAND[0]).fail(problem);
        }
    };
    reached.or_else(|(column, fault)| cells.check.key(&column).fail(fault.to_string()))
}

/// Whether the row has at least one reading.
fn has_reading(cells: &RowCells<'_>) -> bool {
    [DISPLACEMENT, POSITION, ROTATION].into_iter().flatten().chain([GAUGE]).any(|column| cells.cell(column).is_some())
}

/// Returns the readings of a row with their standard deviations; `Err` if there are none.
fn row_readings(cells: &RowCells<'_>) -> Result<Vec<Reading>> {
    let mut readings = Vec::new();
    let std_of = |column: &str| cells.cell(column).map(|std| checked_std(std, &cells.check.key(column))).transpose();
    let (std_mm, std_rad) = (std_of(STD[0])?, std_of(STD[1])?.map(f64::to_radians));
    let mut add = |column: &'static str, quantity: Quantity, value: f64| {
        let (value, std) = if quantity.is_rotation() { (value.to_radians(), std_rad) } else { (value, std_mm) };
        readings.push(Reading { column, quantity, value, std });
    };
    for column in (0..3).flat_map(|axis| [DISPLACEMENT[axis], POSITION[axis], ROTATION[axis]]) {
        if let (Some(value), Some(Reading { quantity, .. })) = (cells.cell(column), Reading::planned(column)) {
            add(column, quantity, value);
        }
    }
    if let Some(value) = cells.cell(GAUGE) {
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
