//! Maps on a grid as VTK image data (`.vti`), which ParaView opens.
//!
//! An image has one array per quantity and kind of row of its tables, such as `both/deflection_mm`, and `both/status`, whole
//! numbers that say at each point whether there is a solution or why not ([`STATUSES`]). VTK has no missing values; as
//! ParaView does, images put NaN where a number is missing, and only images do. Every array has its status beside it.
//!
//! Origin and spacing of an image are of single precision in the crate that writes it (`vtk_file`), a millionth of the
//! workspace; `position_mm` holds the positions themselves.

use std::{io, path::Path};

use serde_json::{Value, json};

use super::table::{Cell, Column, Kind, Row, SCHEMA, Table};
use crate::{
    files::OutputFile,
    input::error::{self, Error},
    simulation::STATUSES,
    spatial::Grid,
};

/// Maps over one grid, for export as VTK image data.
#[derive(Debug, Clone)]
pub struct Image {
    /// The grid of all layers.
    pub grid: Grid,
    /// Tables with rows for every grid point, in the order of the grid.
    pub layers: Vec<Layer>,
}

/// A table with the same number of rows for each grid point.
#[derive(Debug, Clone, Copy)]
pub struct Layer {
    /// Name of the table.
    pub table: &'static str,
    /// Columns of words that distinguish the rows of a point.
    pub keys: &'static [&'static str],
    /// Quantities whose columns `_x_mm`, `_y_mm` and `_z_mm` form a vector.
    pub vectors: &'static [&'static str],
}

/// A named array of values over the grid.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    pub name: String,
    unit: Option<String>,
    pub values: Values,
}

/// Values of an array, one for each grid point.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
    Scalars(Vec<f64>),
    Vectors(Vec<[f64; 3]>),
    Statuses(Vec<i32>),
}

impl Image {
    /// Returns the image and its description as files of `folder`; `Err` when the image cannot hold the data.
    pub fn files(&self, folder: &Path, tables: &[(String, Table)]) -> error::Result<Vec<OutputFile>> {
        let fault = |source| Error::Write { file: folder.join("map.vti"), source };
        let (bytes, described) = self.vti(tables).map_err(fault)?;
        Ok(vec![OutputFile::new("map.vti", bytes), OutputFile::new("map.vti.json", format!("{described:#}\n"))])
    }

    /// Returns the image as the bytes of a `.vti` file, and its description as JSON: arrays, units, statuses. `Err` when a table is
    /// missing or does not fit the grid, or a status is unknown.
    pub fn vti(&self, tables: &[(String, Table)]) -> io::Result<(Vec<u8>, Value)> {
        let arrays = self.arrays(tables)?;
        let description = self.description(&arrays);
        let bytes = super::vtk_file::image(&self.grid, arrays)?;
        Ok((bytes, description))
    }

    /// Returns the arrays of all layers, quantities first, then statuses and positions.
    fn arrays(&self, tables: &[(String, Table)]) -> io::Result<Vec<Array>> {
        let mut arrays = Vec::new();
        for layer in &self.layers {
            let entry = tables.iter().find(|(name, _)| name == layer.table);
            let (_, table) = entry.ok_or_else(|| io::Error::other(format!("there is no table {}", layer.table)))?;
            arrays.extend(layer.arrays(table, self.grid.len())?);
        }
        // Programs show the first array: a quantity of the first table.
        arrays.sort_by_key(|array| matches!(array.values, Values::Statuses(_)));
        let positions = (0..self.grid.len()).map(|index| self.grid.position(index).into()).collect();
        arrays.push(Array { name: "position_mm".into(), unit: Some("mm".into()), values: Values::Vectors(positions) });
        Ok(arrays)
    }

    /// Returns the arrays as JSON, with their units and the numbers of statuses.
    fn description(&self, arrays: &[Array]) -> Value {
        let arrays = arrays.iter().map(|array| {
            let components = if matches!(array.values, Values::Vectors(_)) { 3 } else { 1 };
            json!({ "name": array.name, "unit": array.unit, "components": components })
        });
        let numbers: serde_json::Map<String, Value> =
            STATUSES.iter().enumerate().map(|(number, status)| ((*status).to_string(), json!(number))).collect();
        json!({
            "schema": SCHEMA,
            "points": self.grid.counts(),
            "missing": "NaN; the array status of the same name says why",
            "status": numbers,
            "arrays": arrays.collect::<Vec<_>>(),
        })
    }
}

impl Layer {
    /// Returns the arrays of the layer's table for each kind of row; `Err` if its rows do not fit the number of grid points.
    fn arrays(&self, table: &Table, points: usize) -> io::Result<Vec<Array>> {
        let (rows, kinds) = (table.rows(), table.rows().len() / points);
        if kinds * points != rows.len() {
            return Err(io::Error::other(format!("{}: {} rows for {points} points", self.table, rows.len())));
        }
        let mut arrays = Vec::new();
        for (kind, first) in rows.iter().take(kinds).enumerate() {
            let label = self.label(table, first)?;
            let rows: Vec<&Row> = rows.iter().skip(kind).step_by(kinds).collect();
            for (index, column) in table.columns().iter().enumerate() {
                if let Some((name, values)) = self.values(column, index, &rows)? {
                    let name = format!("{label}/{name}");
                    arrays.push(Array { name, unit: column.unit().map(String::from), values });
                }
            }
        }
        Ok(arrays)
    }

    /// Returns the beginning of the arrays' names: the words that distinguish the row, or the name of the table.
    fn label(&self, table: &Table, row: &Row) -> io::Result<String> {
        let word = |key: &&str| match table.position(key).map(|index| &row[index]) {
            Some(Cell::Text(word)) => Ok(word.clone()),
            other => Err(io::Error::other(format!("{}: {key} is {other:?}, not a word", self.table))),
        };
        let words = self.keys.iter().map(word).collect::<io::Result<Vec<_>>>()?;
        Ok(if words.is_empty() { self.table.into() } else { words.join("/") })
    }

    /// Returns name and values of the array for column `index`; `None` for positions, words, later components of a vector, and numbers
    /// that are missing at all points.
    fn values(&self, column: &Column, index: usize, rows: &[&Row]) -> io::Result<Option<(String, Values)>> {
        let name = column.name.as_str();
        if name == "status" || name.ends_with("_status") {
            let numbers = rows.iter().map(|row| status_number(&row[index])).collect::<io::Result<_>>()?;
            return Ok(Some((name.into(), Values::Statuses(numbers))));
        }
        let is_known = rows.iter().any(|row| row[index] != Cell::Missing);
        if column.kind == Kind::Text || ["x_mm", "y_mm", "z_mm"].contains(&name) || !is_known {
            return Ok(None);
        }
        let of_vector = self.vectors.iter().find_map(|vector| {
            let axis = name.strip_prefix(vector)?.strip_suffix("_mm")?;
            Some((vector, ["_x", "_y", "_z"].iter().position(|component| axis == *component)?))
        });
        Ok(match of_vector {
            Some((vector, 0)) => {
                let vectors = rows.iter().map(|row| [0, 1, 2].map(|axis| row[index + axis].number_or_nan())).collect();
                Some((format!("{vector}_vector_mm"), Values::Vectors(vectors)))
            }
            Some(_) => None,
            None => Some((name.into(), Values::Scalars(rows.iter().map(|row| row[index].number_or_nan()).collect()))),
        })
    }
}

/// Returns the number of a status in images; `Err` if the cell holds no known status.
fn status_number(cell: &Cell) -> io::Result<i32> {
    let index_of = |word: &String| STATUSES.iter().position(|status| status == word);
    let index = if let Cell::Text(word) = cell { index_of(word) } else { None };
    let number = index.and_then(|index| i32::try_from(index).ok());
    number.ok_or_else(|| io::Error::other(format!("status {cell:?} has no number in images")))
}
