//! Reader of polyline files.

use std::ops::Range;

use csv::ByteRecord;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::{
    model::{Load, NumberFormat, Orientation, PathPoint, PointSource, Sampling, Toolpath, Way, direction, number},
    read::polyline::{Column, EXTERNAL_WORDS, Polyline, PolylineError, PolylineFault},
};
use kinetostat_input::csv_rows::{self, Row, RowFault, line_number};
use kinetostat_spatial::MAX_EXTERNAL_AXES;

impl Polyline {
    /// Reads a polyline file. `name` is its name, for messages; `source` its bytes. `Err` for an unknown, repeated or missing column, a row
    /// of another width, a value that cannot be read, or no rows.
    pub fn read(source: impl Into<Vec<u8>>, name: &str) -> Result<Polyline, PolylineError> {
        let source = source.into();
        let parsed = parse(&source).map_err(|(at, fault)| PolylineError {
            file: name.to_owned(),
            line: line_number(&source, at),
            fault,
        })?;
        let Parsed { columns, external, rows, lines, points, decimals } = parsed;
        let path = Toolpath::assemble(points).with_external_axes(&external);
        let own_format = NumberFormat::of_source(decimals, 0);
        Ok(Polyline { name: name.to_owned(), source, columns, rows, lines, path, own_format })
    }
}

/// Content of a polyline file.
struct Parsed {
    columns: Vec<Column>,
    /// Names of the external axes.
    external: Vec<String>,
    rows: Vec<Range<usize>>,
    lines: Vec<usize>,
    points: Vec<PathPoint>,
    /// The most decimals of a coordinate.
    decimals: usize,
}

/// Parses a polyline file; the tangents and arc lengths of its points are set. `Err` gives the byte of the fault.
fn parse(source: &[u8]) -> Result<Parsed, (usize, PolylineFault)> {
    let rows = csv_rows::read(source).map_err(|(at, reason)| (at, RowFault::NotCsv { reason }.into()))?;
    let Some((header, rows)) = rows.split_first() else {
        return Err((0, PolylineFault::NoPoints));
    };
    let (columns, external) = header_columns(&header.fields).map_err(|fault| (header.span.start, fault))?;
    if rows.is_empty() {
        return Err((source.len(), PolylineFault::NoPoints));
    }
    if rows.len() >= Sampling::MAX_POINTS {
        return Err((source.len(), PolylineFault::TooManyPoints));
    }
    let mut points = Vec::with_capacity(rows.len());
    let mut decimals = 0;
    for Row { fields, span, .. } in rows {
        let values = row_values(&columns, &external, fields).map_err(|fault| (span.start, fault.into()))?;
        let orientation = row_orientation(&columns, &values).map_err(|fault| (span.start, fault))?;
        points.push(PathPoint { orientation, ..row_point(&columns, &values, points.len()) });
        decimals = decimals.max(most_decimals(&columns, fields));
    }
    set_lengths_and_tangents(&mut points);
    let (rows, lines) = rows.iter().map(|row| (row.span.clone(), row.line)).unzip();
    Ok(Parsed { columns, external, rows, lines, points, decimals })
}

/// Returns the columns of the header and the names of external axes; `Err` for unknown, repeated, missing or contradictory columns.
fn header_columns(header: &ByteRecord) -> Result<(Vec<Column>, Vec<String>), PolylineFault> {
    let (mut columns, mut external) = (Vec::new(), Vec::new());
    for name in header {
        let name = String::from_utf8_lossy(name);
        let Some(column) = Column::from_name(&name, &mut external) else {
            let optional = Column::all().skip(3).map(|column| column.name(&external));
            let optional = optional.chain([EXTERNAL_WORDS.into()]).collect::<Vec<_>>().join(", ");
            return Err(PolylineFault::UnknownColumn { name: name.into_owned(), optional });
        };
        if columns.contains(&column) {
            return Err(PolylineFault::RepeatedColumn { name: name.into_owned() });
        }
        columns.push(column);
    }
    let with_others = columns.iter().flat_map(|c| c.companions()).map(|c| (c, "with its companions"));
    let always = [0, 1, 2].map(|axis| (Column::Position(axis), "in every file"));
    for (column, because) in always.into_iter().chain(with_others) {
        if !columns.contains(&column) {
            return Err(PolylineFault::MissingColumn { name: column.name(&external).into_owned(), because });
        }
    }
    if [Column::ToolAxis(0), Column::Platform(0)].iter().all(|column| columns.contains(column)) {
        return Err(PolylineFault::TwoOrientations);
    }
    if external.len() > MAX_EXTERNAL_AXES {
        return Err(PolylineFault::TooManyAxes { count: external.len() });
    }
    Ok((columns, external))
}

/// Parses the numbers of a row, in the order of `columns`; `Err` if one is missing or out of range.
fn row_values(columns: &[Column], external: &[String], record: &ByteRecord) -> Result<Vec<f64>, RowFault> {
    if record.len() != columns.len() {
        return Err(RowFault::Width { found: record.len(), expected: columns.len() });
    }
    let value = |(column, field): (&Column, &[u8])| {
        let read = std::str::from_utf8(field).ok().and_then(|text| column.parse(text));
        read.ok_or_else(|| RowFault::Value {
            column: column.name(external).into_owned(),
            value: String::from_utf8_lossy(field).into_owned(),
            expected: column.expected(),
        })
    };
    columns.iter().zip(record).map(value).collect()
}

/// Returns the most decimals of the coordinates in a row.
fn most_decimals(columns: &[Column], record: &ByteRecord) -> usize {
    let positions = columns.iter().zip(record).filter(|(c, _)| matches!(c, Column::Position(_)));
    positions.map(|(_, field)| number::decimals_in(&String::from_utf8_lossy(field))).max().unwrap_or(0)
}

/// Returns the orientation of the tool in a row of `values`; `None` if the file has no columns for it. `Err` if its length is wrong.
fn row_orientation(columns: &[Column], values: &[f64]) -> Result<Option<Orientation>, PolylineFault> {
    let entry = |column: Column| columns.iter().position(|c| *c == column).map(|at| values[at]);
    if let [Some(x), Some(y), Some(z)] = [0, 1, 2].map(|axis| entry(Column::ToolAxis(axis))) {
        let axis = Vector3::new(x, y, z).try_normalize(LEAST_AXIS);
        return axis.map(|axis| Some(Orientation::ToolAxis(axis))).ok_or(PolylineFault::NoDirection);
    }
    let [Some(w), Some(x), Some(y), Some(z)] = [0, 1, 2, 3].map(|index| entry(Column::Platform(index))) else {
        return Ok(None);
    };
    let quaternion = Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    match (norm - 1.0).abs() <= NOT_UNIT {
        true => Ok(Some(Orientation::Platform(UnitQuaternion::new_normalize(quaternion)))),
        false => Err(PolylineFault::NotUnit { norm }),
    }
}

/// Tool axes shorter than this have no direction.
const LEAST_AXIS: f64 = 1e-9;
/// Most deviation of a quaternion's length from 1: files have few digits.
const NOT_UNIT: f64 = 1e-3;

/// Creates the point of row `segment` from its `values`, without orientation, tangent and arc length.
fn row_point(columns: &[Column], values: &[f64], segment: usize) -> PathPoint {
    let value = |column: Column| columns.iter().position(|c| *c == column).map(|at| values[at]);
    let vector = |component: fn(usize) -> Column| {
        let [x, y, z] = [0, 1, 2].map(|axis| value(component(axis)));
        Some(Vector3::new(x?, y?, z?))
    };
    let (force, moment) = (vector(Column::Force), vector(Column::Moment));
    let load = (force.is_some() || moment.is_some())
        .then(|| Load { force_N: force.unwrap_or_default(), moment_Nmm: moment.unwrap_or_default() });
    PathPoint {
        position_mm: vector(Column::Position).unwrap_or_default(),
        orientation: None,
        tangent: Vector3::zeros(),
        arc_length_mm: 0.0,
        cutting: value(Column::Cutting) != Some(0.0),
        feed_mm_per_min: value(Column::Feed),
        spindle_rev_per_min: value(Column::Spindle),
        tool: None,
        feature: None,
        load,
        external: std::array::from_fn(|axis| value(Column::External(axis)).unwrap_or(0.0)),
        source: PointSource { segment, parameter: 1.0 },
        arm: None,
        way: Way::Followed,
    }
}

/// Angle above which a path has a corner, rad; below it is a curve given by points.
const CORNER_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;

/// Sets arc lengths (mm) and tangents. On a curve the tangent is the mean of the directions of arrival and departure, at a corner that of
/// arrival, as in a program. A closed path turns at its ends too.
fn set_lengths_and_tangents(points: &mut [PathPoint]) {
    let steps = points.windows(2).map(|pair| direction(pair[1].position_mm - pair[0].position_mm));
    let moving: Vec<Vector3<f64>> = steps.filter(|step| *step != Vector3::zeros()).collect();
    let is_closed = points.first().map(|p| p.position_mm) == points.last().map(|p| p.position_mm);
    let beyond_end = |end: Option<&Vector3<f64>>| end.copied().filter(|_| is_closed).unwrap_or_else(Vector3::zeros);
    let (mut arrival, last_departure) = (beyond_end(moving.last()), beyond_end(moving.first()));
    let mut length = 0.0;
    for k in 0..points.len() {
        let here = points[k].position_mm;
        let step = points.get(k + 1).map_or_else(Vector3::zeros, |next| next.position_mm - here);
        let departure = if k + 1 < points.len() { direction(step) } else { last_departure };
        // Without arrival there is no corner: of a zero vector the angle below may be −0 and half a turn.
        let is_corner = arrival != Vector3::zeros()
            && libm::atan2(arrival.cross(&departure).norm(), arrival.dot(&departure)) > CORNER_RAD;
        points[k].tangent = if is_corner { arrival } else { direction(arrival + departure) };
        points[k].arc_length_mm = length;
        length += step.norm();
        if departure != Vector3::zeros() {
            arrival = departure;
        }
    }
}
