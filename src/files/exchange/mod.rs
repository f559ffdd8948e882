//! Files for other programs: typed tables as CSV and Parquet, maps as VTK image data, surfaces as PLY and VTK polygons.
//!
//! A report makes a [`Table`] of typed columns whose names end with their units; every exporter takes the same table, so
//! all formats hold the same columns and numbers. `SCHEMA` is the version of these columns.

mod csv_file;
mod image;
mod kept_rows;
mod not_built;
#[cfg(feature = "parquet")]
mod parquet_file;
mod streamed;
mod surface;
mod table;
#[cfg(feature = "vtk")]
mod vtk_file;

use std::path::Path;

pub(crate) use csv_file::DESCRIPTION;
pub use csv_file::{CsvFile, csv, description, unescape_formula};
pub use image::{Image, Layer};
pub use kept_rows::{KeptRows, MAX_ROWS, Points, WrittenRows};
#[cfg(not(feature = "parquet"))]
use not_built::parquet_file;
#[cfg(not(feature = "vtk"))]
use not_built::vtk_file;
pub use parquet_file::{ParquetFile, parquet};
pub use streamed::StreamedTable;
pub use surface::Surface;
pub use table::{Cell, Column, Kind, Row, Table, cells, counts, numbers, texts};

use super::OutputFile;
use crate::input::error::{Error, Result};

/// A file format for tables or maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Tables as CSV.
    Csv,
    /// Tables as Apache Parquet.
    Parquet,
    /// Maps on a grid as VTK image data.
    Vti,
}

impl Format {
    /// All formats.
    pub const ALL: [Format; 3] = [Format::Csv, Format::Parquet, Format::Vti];

    /// Returns its name, which is the extension of its files.
    pub fn label(self) -> &'static str {
        match self {
            Format::Csv => "csv",
            Format::Parquet => "parquet",
            Format::Vti => "vti",
        }
    }

    /// Returns the feature with which the program must be built for it, if any.
    fn feature(self) -> Option<&'static str> {
        match self {
            Format::Csv => None,
            Format::Parquet => Some("parquet"),
            Format::Vti => Some("vtk"),
        }
    }

    /// Returns an error if this program was built without the format.
    pub(crate) fn check_built(self) -> std::result::Result<(), NotBuilt> {
        match self {
            Format::Parquet if !cfg!(feature = "parquet") => Err(NotBuilt(self)),
            Format::Vti if !cfg!(feature = "vtk") => Err(NotBuilt(self)),
            _ => Ok(()),
        }
    }
}

/// Error: this program was built without the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotBuilt(Format);

impl std::fmt::Display for NotBuilt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (format, feature) = (self.0.label(), self.0.feature().unwrap_or_default());
        write!(
            f,
            "this program was built without {format}: build it with `--features {feature}`, such as `cargo install \
            --path . --features {feature}`"
        )
    }
}

impl std::error::Error for NotBuilt {}

/// Returns the files of `tables` (name and table) in the formats asked for; `folder` is where they will be written. `streamed` are tables
/// already in files, which only need to be described. `Err` names the file whose format cannot hold the data.
pub fn files(
    folder: &Path,
    tables: &[(String, Table)],
    streamed: &[(String, Table)],
    formats: &[Format],
) -> Result<Vec<OutputFile>> {
    let fault = |name: &str, source| Error::Write { file: folder.join(name), source };
    let mut files = Vec::new();
    if formats.contains(&Format::Csv) {
        let named: Vec<(String, &Table)> = tables.iter().map(|(stem, table)| (format!("{stem}.csv"), table)).collect();
        for (name, table) in &named {
            let bytes = csv(table).map_err(|e| fault(name, std::io::Error::other(e)))?;
            files.push(OutputFile::new(name, bytes));
        }
        let streamed = streamed.iter().map(|(stem, table)| (format!("{stem}.csv"), table));
        let all: Vec<(String, &Table)> = streamed.chain(named).collect();
        let json = description(all.iter().map(|(name, table)| (name.as_str(), *table)));
        files.push(OutputFile::new(DESCRIPTION, format!("{json:#}\n")));
    }
    if formats.contains(&Format::Parquet) {
        for (stem, table) in tables {
            let name = format!("{stem}.parquet");
            let bytes = parquet(table).map_err(|e| fault(&name, std::io::Error::other(e)))?;
            files.push(OutputFile::new(name, bytes));
        }
    }
    Ok(files)
}
