//! A table that is written while its rows are computed, so that memory does not grow with it.

use std::{
    error::Error as StdError,
    io::{BufWriter, Error as IoError, IntoInnerError},
    path::{Path, PathBuf},
};

use tempfile::NamedTempFile;

use super::{Column, CsvFile, Format, ParquetFile, Table};
use crate::{
    files::{OutputFile, temporary_file},
    input::error::{Error, Result},
};

type Out = BufWriter<NamedTempFile>;

/// The files of a table in the formats asked for, filled part by part. They are temporary until they are written with the
/// others; dropped before, nothing of them is left.
pub struct StreamedTable {
    csv: Option<(PathBuf, CsvFile<Out>)>,
    parquet: Option<(PathBuf, ParquetFile<Out>)>,
}

impl StreamedTable {
    /// Empty files for a table of `columns` called `stem` in `folder`.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn new(folder: &Path, stem: &str, columns: &[Column], formats: &[Format]) -> Result<Self> {
        let open = |ending: &str| {
            let path = folder.join(format!("{stem}.{ending}"));
            let file = temporary_file(folder).map_err(|error| fault(&path, error))?;
            Ok::<_, Error>((path, BufWriter::new(file)))
        };
        let mut streamed = Self { csv: None, parquet: None };
        if formats.contains(&Format::Csv) {
            let (path, out) = open("csv")?;
            let mut file = CsvFile::new(out);
            // A table without rows has a header all the same.
            file.add(&Table::new(columns.to_vec(), [])).map_err(|error| fault(&path, error))?;
            streamed.csv = Some((path, file));
        }
        if formats.contains(&Format::Parquet) {
            let (path, out) = open("parquet")?;
            let file = ParquetFile::new(columns, out).map_err(|error| fault(&path, error))?;
            streamed.parquet = Some((path, file));
        }
        Ok(streamed)
    }

    /// Adds the rows of `table`, which has the columns of the files.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn add(&mut self, table: &Table) -> Result<()> {
        if let Some((path, file)) = &mut self.csv {
            file.add(table).map_err(|error| fault(path, error))?;
        }
        if let Some((path, file)) = &mut self.parquet {
            file.add(table).map_err(|error| fault(path, error))?;
        }
        Ok(())
    }

    /// The files with all that was added.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn finish(self) -> Result<Vec<OutputFile>> {
        let mut files = Vec::new();
        if let Some((path, file)) = self.csv {
            let out = file.finish().map_err(|error| fault(&path, error))?;
            files.push(complete(&path, out)?);
        }
        if let Some((path, file)) = self.parquet {
            let out = file.finish().map_err(|error| fault(&path, error))?;
            files.push(complete(&path, out)?);
        }
        Ok(files)
    }
}

fn complete(path: &Path, out: Out) -> Result<OutputFile> {
    let file = out.into_inner().map_err(IntoInnerError::into_error).map_err(|error| fault(path, error))?;
    Ok(OutputFile::written(path.file_name().unwrap_or_default().to_string_lossy(), file))
}

fn fault(path: &Path, error: impl Into<Box<dyn StdError + Send + Sync>>) -> Error {
    Error::Write { file: path.to_path_buf(), source: IoError::other(error) }
}
