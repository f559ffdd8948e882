//! Writes polyline CSV files: the same file with moved points, or a new one.

use csv::{ReaderBuilder, WriterBuilder};
use nalgebra::Vector3;

use crate::{
    model::{
        NumberFormat, Orientation, PathPoint, PositionsError, Rewritten, Toolpath, WRITTEN_RAD, check_corrected,
        even_parameters, format_fixed, last_place,
    },
    read::polyline::{Column, Polyline},
};

impl Polyline {
    /// Rewrites the file with its own points moved to `corrected_mm`, positions in the workpiece frame; see [`Polyline::rewrite_sampled`].
    /// Fails when there is not one finite position for every row.
    pub fn rewrite(&self, corrected_mm: &[Vector3<f64>], format: NumberFormat) -> Result<Vec<u8>, PositionsError> {
        Ok(self.rewrite_sampled(&self.path, corrected_mm, format)?.bytes)
    }

    /// Rewrites the file with the points of `path`, from [`Polyline::sampled`], moved to `corrected_mm`, positions in the workpiece frame.
    ///
    /// Of the rows of the file, only coordinates that move by more than half a unit of the last decimal of `format` are written anew; all
    /// other values, columns, blanks and line endings are copied. Where the straight line between two written rows passes a corrected point
    /// between them by more than one unit of the last decimal, the points between them become rows: with the values of the row they lead to,
    /// and interpolated forces and moments. Without correction the bytes are the same. Fails when there is not one finite position for every point.
    pub fn rewrite_sampled(
        &self,
        path: &Toolpath,
        corrected_mm: &[Vector3<f64>],
        format: NumberFormat,
    ) -> Result<Rewritten<Polyline>, PositionsError> {
        self.rewrite_turned(path, corrected_mm, None, format)
    }

    /// Rewrites the file like [`Polyline::rewrite_sampled`], with the tool turned to `orientations` as well, if they are given: those
    /// that differ by more than 1e-8 rad are written anew, with nine decimals, and points become rows where the interpolated
    /// orientation would be off by more than 1e-4 rad. Fails when there is not one finite position, and one orientation, for every point.
    pub fn rewrite_turned(
        &self,
        path: &Toolpath,
        corrected_mm: &[Vector3<f64>],
        orientations: Option<&[Orientation]>,
        format: NumberFormat,
    ) -> Result<Rewritten<Polyline>, PositionsError> {
        check_corrected(path, corrected_mm, orientations)?;
        let (unit, points) = (last_place(format.mm_decimals()), path.points());
        let tool_at = |k: usize| orientations.map_or(points[k].orientation, |orientations| Some(orientations[k]));
        let mut out = Vec::with_capacity(self.source.len());
        let (mut copied, mut next, mut pieces) = (0, 0, Vec::with_capacity(self.rows.len()));
        let mut parameters = Vec::with_capacity(points.len());
        let mut before: Option<(Vector3<f64>, Option<Orientation>)> = None;
        for (index, row) in self.rows.iter().enumerate() {
            let first = next;
            while points.get(next).is_some_and(|point| point.source.segment == index) {
                next += 1;
            }
            let Some(last) = next.checked_sub(1).filter(|last| *last >= first) else { continue };
            let written: Vec<[Option<String>; 3]> =
                (first..next).map(|k| changed_coordinates(&points[k], &corrected_mm[k], format)).collect();
            let end = position_as_written(&points[last].position_mm, &written[last - first]);
            let between = |t: f64, start: Option<Orientation>| Some(start?.towards(&tool_at(last)?, t));
            let is_straight = |(start, from): (Vector3<f64>, Option<Orientation>)| {
                (first..last).all(|k| {
                    let t = points[k].source.parameter;
                    let turn = between(t, from).zip(tool_at(k)).map_or(0.0, |(a, b)| a.angle_to(&b));
                    (start.lerp(&end, t) - corrected_mm[k]).amax() <= unit * (1.0 + 1e-6)
                        && (orientations.is_none() || turn <= WRITTEN_RAD)
                })
            };
            let is_split = before.is_some_and(|start| !is_straight(start));
            if is_split {
                out.extend_from_slice(&self.source[copied..row.start]);
                copied = row.start;
                for k in first..last {
                    let position = corrected_mm[k].map(|c| format_fixed(c, format.mm_decimals()));
                    let cells = [0, 1, 2].map(|axis| Some(position[axis].clone()));
                    let inserted = PathPoint { orientation: tool_at(k), ..points[k] };
                    out.extend(self.write_row(&self.source[row.clone()], &cells, Inserted::Point(&inserted)));
                    out.extend_from_slice(self.line_ending());
                    pieces.push(1);
                    parameters.push(1.0);
                }
            }
            pieces.push(if is_split { 1 } else { next - first });
            parameters.extend(even_parameters(pieces[pieces.len() - 1]));
            let turns = |(a, b): (Orientation, Orientation)| a.angle_to(&b) > SAME_RAD;
            let new = points[last].orientation.zip(tool_at(last)).filter(|pair| turns(*pair)).map(|(_, new)| new);
            if new.is_some() || written[last - first].iter().any(Option::is_some) {
                out.extend_from_slice(&self.source[copied..row.start]);
                let inserted = new.map_or(Inserted::Nothing, Inserted::Orientation);
                out.extend(self.write_row(&self.source[row.clone()], &written[last - first], inserted));
                copied = row.end;
            }
            before = Some((end, new.or(points[last].orientation)));
        }
        out.extend_from_slice(&self.source[copied..]);
        Ok(Rewritten { bytes: out, pieces, parameters, line_ends: Vec::new(), reading: () })
    }

    /// Returns the row `text` with its coordinates replaced where `changed` has one, and with the values that `inserted` has.
    fn write_row(&self, text: &[u8], changed: &[Option<String>; 3], inserted: Inserted<'_>) -> Vec<u8> {
        let mut reader = ReaderBuilder::new().has_headers(false).from_reader(text);
        let record = reader.byte_records().flatten().next().unwrap_or_default();
        let fields = self.columns.iter().zip(record.iter().map(without_line_endings)).map(|(column, field)| {
            let new_text = match column {
                Column::Position(axis) => changed[*axis].clone(),
                Column::ToolAxis(_) | Column::Platform(_) => inserted
                    .orientation()
                    .and_then(|orientation| orientation_entry(&orientation, *column))
                    .map(|value| match inserted {
                        Inserted::Orientation(_) => format_fixed(value, ORIENTATION_DECIMALS),
                        _ => value.to_string(),
                    }),
                Column::Force(_) | Column::Moment(_) | Column::External(_) => match inserted {
                    Inserted::Point(point) => column_value(point, *column).map(|value| value.to_string()),
                    _ => None,
                },
                Column::Feed | Column::Spindle | Column::Cutting => None,
            };
            new_text.map_or_else(|| field.to_vec(), |number| replace_field(field, &number))
        });
        fields.collect::<Vec<_>>().join(&b","[..])
    }

    /// Returns the line ending of this file, as its first line has it.
    fn line_ending(&self) -> &'static [u8] {
        match self.source.iter().position(|byte| *byte == b'\n') {
            Some(at) if at > 0 && self.source[at - 1] == b'\r' => b"\r\n",
            Some(_) => b"\n",
            None => b"\r",
        }
    }
}

/// Orientations that differ by less are the same, rad.
const SAME_RAD: f64 = 1e-8;

/// Decimals of written directions and quaternions.
const ORIENTATION_DECIMALS: u8 = 9;

/// Which values a row gets besides its coordinates.
#[derive(Clone, Copy)]
enum Inserted<'a> {
    Nothing,
    /// Another orientation.
    Orientation(Orientation),
    /// Forces, moments, orientation and external axes of a point between two rows.
    Point(&'a PathPoint),
}

impl Inserted<'_> {
    /// Returns the orientation to write; `None` if the row keeps its own.
    fn orientation(&self) -> Option<Orientation> {
        match self {
            Inserted::Nothing => None,
            Inserted::Orientation(orientation) => Some(*orientation),
            Inserted::Point(point) => point.orientation,
        }
    }
}

/// Formats the coordinates (mm) of a point moved to `corrected` that change by more than half a unit of the last decimal; `None` for the others.
fn changed_coordinates(point: &PathPoint, corrected: &Vector3<f64>, format: NumberFormat) -> [Option<String>; 3] {
    let half = last_place(format.mm_decimals()) * (0.5 + 1e-6);
    [0, 1, 2].map(|axis| {
        ((corrected - point.position_mm)[axis].abs() > half)
            .then(|| format_fixed(corrected[axis], format.mm_decimals()))
    })
}

/// Returns the position (mm in W) of a row at `original` whose coordinates are rewritten as `changed` says.
fn position_as_written(original: &Vector3<f64>, changed: &[Option<String>; 3]) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| changed[axis].as_ref().and_then(|number| number.parse().ok()).unwrap_or(original[axis]))
}

/// Returns a CSV field without blanks and line endings at its ends if it contains a line ending (allowed when read only inside quotes, and quotes
/// are not written); any other field unchanged.
fn without_line_endings(field: &[u8]) -> &[u8] {
    if field.iter().any(|byte| matches!(byte, b'\r' | b'\n')) { field.trim_ascii() } else { field }
}

/// Returns `number` with the blanks that are around `field`.
fn replace_field(field: &[u8], number: &str) -> Vec<u8> {
    let before = field.len() - field.trim_ascii_start().len();
    let after = field.trim_ascii_end().len().max(before);
    [&field[..before], number.as_bytes(), &field[after..]].concat()
}

/// Writes a new polyline file with the points of `path` at `positions_mm`, in the workpiece frame; rows end in `\n`.
///
/// Besides the positions, with the decimals of `format`, it has the columns that every point has a value for;
/// `cutting` only if some point is not. Fails when there is not one finite position for every point.
pub fn write(path: &Toolpath, positions_mm: &[Vector3<f64>], format: NumberFormat) -> Result<Vec<u8>, PositionsError> {
    check_corrected(path, positions_mm, None)?;
    let points = path.points();
    let everywhere = |column: &Column| points.iter().all(|point| column_value(point, *column).is_some());
    let some_idle = points.iter().any(|point| !point.cutting);
    let is_written = |column: &Column| match column {
        Column::Position(_) => true,
        Column::Cutting => some_idle,
        column => everywhere(column),
    };
    let external = path.external_axes();
    let external_columns = (0..external.len()).map(Column::External);
    let columns: Vec<Column> = Column::all().filter(is_written).chain(external_columns).collect();
    let mut rows = vec![columns.iter().map(|column| column.name(external).into_owned()).collect::<Vec<_>>()];
    for (point, position) in points.iter().zip(positions_mm) {
        let text = |column: &Column| match column {
            Column::Position(axis) => format_fixed(position[*axis], format.mm_decimals()),
            column => column_value(point, *column).map_or_else(String::new, |value| value.to_string()),
        };
        rows.push(columns.iter().map(text).collect());
    }
    let mut writer = WriterBuilder::new().from_writer(Vec::new());
    for row in rows {
        // Writing rows of one width into memory cannot fail.
        let _ = writer.write_record(row);
    }
    Ok(writer.into_inner().unwrap_or_default())
}

/// Returns the value of `orientation` for a column of orientations; `None` if it has none.
fn orientation_entry(orientation: &Orientation, column: Column) -> Option<f64> {
    match (column, orientation) {
        (Column::ToolAxis(axis), Orientation::ToolAxis(direction)) => Some(direction[axis]),
        (Column::Platform(entry), Orientation::Platform(q)) => Some([q.w, q.i, q.j, q.k][entry]),
        _ => None,
    }
}

/// Returns the value of `point` for a column, in the column's unit; `None` if it has none.
fn column_value(point: &PathPoint, column: Column) -> Option<f64> {
    match column {
        Column::Position(axis) => Some(point.position_mm[axis]),
        Column::Feed => point.feed_mm_per_min,
        Column::Spindle => point.spindle_rev_per_min,
        Column::Force(axis) => point.load.map(|load| load.force_N[axis]),
        Column::Moment(axis) => point.load.map(|load| load.moment_Nmm[axis]),
        Column::ToolAxis(_) | Column::Platform(_) => {
            point.orientation.and_then(|orientation| orientation_entry(&orientation, column))
        }
        Column::External(axis) => Some(point.external[axis]),
        Column::Cutting => Some(f64::from(u8::from(point.cutting))),
    }
}
