//! Writing polyline files: the same file with moved points, or a new one.

use csv::{ReaderBuilder, WriterBuilder};
use nalgebra::Vector3;

use super::Polyline;
use super::column::Column;
use crate::process::toolpath::number::{fixed, last_place};
use crate::process::toolpath::path::check_positions;
use crate::process::toolpath::{Format, PathPoint, PositionsError, Toolpath};

impl Polyline {
    /// The file with its points moved to `corrected_mm`, positions in the workpiece frame.
    ///
    /// Only coordinates that move by more than half a unit of the last decimal of `format` are written anew; all
    /// other values, columns, blanks and line endings are copied. Without correction the bytes are the same.
    ///
    /// # Errors
    /// When there is not one finite position for every row.
    pub fn rewrite(&self, corrected_mm: &[Vector3<f64>], format: Format) -> Result<Vec<u8>, PositionsError> {
        check_positions(&self.path, corrected_mm)?;
        let mut out = Vec::with_capacity(self.source.len());
        let mut copied = 0;
        for ((row, point), corrected) in self.rows.iter().zip(self.path.points()).zip(corrected_mm) {
            let half = last_place(format.mm_decimals()) * (0.5 + 1e-6);
            let moved = [0, 1, 2].map(|axis| {
                ((corrected - point.position_mm)[axis].abs() > half)
                    .then(|| fixed(corrected[axis], format.mm_decimals()))
            });
            if moved.iter().any(Option::is_some) {
                out.extend_from_slice(&self.source[copied..row.start]);
                out.extend(self.row(&self.source[row.clone()], moved));
                copied = row.end;
            }
        }
        out.extend_from_slice(&self.source[copied..]);
        Ok(out)
    }

    /// The row `text` with the coordinates in `moved` in place of its own.
    fn row(&self, text: &[u8], moved: [Option<String>; 3]) -> Vec<u8> {
        let mut reader = ReaderBuilder::new().has_headers(false).from_reader(text);
        let record = reader.byte_records().flatten().next().unwrap_or_default();
        let fields = self.columns.iter().zip(record.iter().map(on_one_line)).map(|(column, field)| match column {
            Column::Position(axis) => match &moved[*axis] {
                Some(number) => in_place_of(field, number),
                None => field.to_vec(),
            },
            _ => field.to_vec(),
        });
        fields.collect::<Vec<_>>().join(&b","[..])
    }
}

/// The field without the line endings that it may have around it only in quotes, which are not written.
fn on_one_line(field: &[u8]) -> &[u8] {
    if field.iter().any(|byte| matches!(byte, b'\r' | b'\n')) { field.trim_ascii() } else { field }
}

/// `number` with the blanks that stood around `field`.
fn in_place_of(field: &[u8], number: &str) -> Vec<u8> {
    let before = field.len() - field.trim_ascii_start().len();
    let after = field.trim_ascii_end().len().max(before);
    [&field[..before], number.as_bytes(), &field[after..]].concat()
}

/// A new polyline file with the points of `path` at `positions_mm`, in the workpiece frame; rows end in `\n`.
///
/// Besides the positions, with the decimals of `format`, it has the columns that every point has a value for;
/// `cutting` only if some point is not.
///
/// # Errors
/// When there is not one finite position for every point.
pub fn write(path: &Toolpath, positions_mm: &[Vector3<f64>], format: Format) -> Result<Vec<u8>, PositionsError> {
    check_positions(path, positions_mm)?;
    let points = path.points();
    let everywhere = |column: &Column| points.iter().all(|point| value(point, *column).is_some());
    let some_idle = points.iter().any(|point| !point.cutting);
    let wanted = |column: &Column| match column {
        Column::Position(_) => true,
        Column::Cutting => some_idle,
        column => everywhere(column),
    };
    let columns: Vec<Column> = Column::ALL.into_iter().filter(wanted).collect();
    let mut rows = vec![columns.iter().map(|column| column.name().to_owned()).collect::<Vec<_>>()];
    for (point, position) in points.iter().zip(positions_mm) {
        let text = |column: &Column| match column {
            Column::Position(axis) => fixed(position[*axis], format.mm_decimals()),
            column => value(point, *column).map_or_else(String::new, |value| value.to_string()),
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

/// What a point has for a column.
fn value(point: &PathPoint, column: Column) -> Option<f64> {
    match column {
        Column::Position(axis) => Some(point.position_mm[axis]),
        Column::Feed => point.feed_mm_per_min,
        Column::Spindle => point.spindle_rev_per_min,
        Column::Force(axis) => point.load.map(|load| load.force_N[axis]),
        Column::Moment(axis) => point.load.map(|load| load.moment_Nmm[axis]),
        Column::Cutting => Some(f64::from(u8::from(point.cutting))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::toolpath::{Circle, Load, Plane, Turn};

    #[test]
    fn only_moved_coordinates_change() {
        let source = "\u{feff}z_mm,x_mm, y_mm,feed_mm_per_min\r\n5, 1.50 ,2,1e2\r\n\r\n5,\"3\",4,0200\r\n6,3,4,200";
        let polyline = Polyline::read(source, "path.csv").unwrap();
        let nominal = polyline.toolpath().positions_mm();
        let format = polyline.own_format();
        assert_eq!(format.mm_decimals(), 3);
        assert_eq!(polyline.rewrite(&nominal, format).unwrap(), source.as_bytes());
        let mut moved = nominal;
        moved[0].x += 0.0126;
        moved[0].z += 0.0004;
        moved[1].y -= 4.0001;
        let written = String::from_utf8(polyline.rewrite(&moved, format).unwrap()).unwrap();
        assert_eq!(
            written,
            "\u{feff}z_mm,x_mm, y_mm,feed_mm_per_min\r\n5, 1.513 ,2,1e2\r\n\r\n5,3,0.000,0200\r\n6,3,4,200"
        );
    }

    #[test]
    fn a_generated_path_is_read_back_as_it_was() {
        let circle = Circle {
            centre_mm: Vector3::new(1.0, 2.0, 3.0),
            diameter_mm: 8.0,
            plane: Plane::Yz,
            turn: Turn::Clockwise,
            start_angle_rad: 0.0,
            points: 9,
        };
        let path = circle.toolpath().unwrap().with_feed(300.5).with_spindle(8000.0);
        let load = Load { force_N: Vector3::new(1.25, -2.0, 3.0), moment_Nmm: Vector3::zeros() };
        let loaded = path.points().iter().map(|point| PathPoint { load: Some(load), ..*point });
        let path = Toolpath::assemble(loaded.collect());
        let bytes = write(&path, &path.positions_mm(), Format::new(9, 9).unwrap()).unwrap();
        let back = Polyline::read(bytes, "circle.csv").unwrap();
        for (a, b) in path.points().iter().zip(back.toolpath().points()) {
            assert!((a.position_mm - b.position_mm).amax() <= 0.5e-9 * 1.001);
            assert_eq!((a.feed_mm_per_min, a.load, a.cutting), (b.feed_mm_per_min, b.load, b.cutting));
        }
    }

    #[test]
    fn positions_must_fit_the_path() {
        let polyline = Polyline::read("x_mm,y_mm,z_mm\n1,2,3\n", "path.csv").unwrap();
        let refused =
            |positions: &[Vector3<f64>]| polyline.rewrite(positions, Format::default()).unwrap_err().to_string();
        assert_eq!(refused(&[]), "0 corrected positions for a path of 1 points: expected one for each point");
        assert_eq!(
            refused(&[Vector3::new(f64::NAN, 0.0, 0.0)]),
            "corrected position 0 is (NaN, 0, 0) mm: expected finite numbers up to 1000000"
        );
    }
}
