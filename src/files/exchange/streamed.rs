//! A table that is written while its rows are computed, so that it does not fill the memory.

use std::{
    error::Error as StdError,
    io::{BufWriter, Error as IoError, IntoInnerError},
    path::{Path, PathBuf},
};

use super::{Column, CsvFile, Format, KeptRows, ParquetFile, Table};
use crate::{
    files::{OutputFile, PartialFile, temporary_file},
    input::error::{Error, Result},
};

type Out = BufWriter<PartialFile>;

/// Files of one table in several formats, filled part by part. They are temporary, and removed unless they are written as results.
pub struct StreamedTable {
    stem: String,
    /// Rows that the CSV file gets at the end, if not all.
    kept: Option<KeptRows>,
    csv: Option<(PathBuf, CsvFile<Out>)>,
    parquet: Option<(PathBuf, ParquetFile<Out>)>,
}

impl StreamedTable {
    /// Creates empty files for a table with `columns`, called `stem`, in `folder`; its CSV file gets the rows `kept`, or all. `Err` when they
    /// cannot be written.
    pub fn new(
        folder: &Path,
        stem: &str,
        columns: &[Column],
        formats: &[Format],
        kept: Option<KeptRows>,
    ) -> Result<Self> {
        let open = |ending: &str| {
            let path = folder.join(format!("{stem}.{ending}"));
            let file = temporary_file(folder).map_err(|error| write_error(&path, error))?;
            Ok::<_, Error>((path, BufWriter::new(file)))
        };
        let mut streamed = Self { stem: stem.into(), kept, csv: None, parquet: None };
        if formats.contains(&Format::Csv) {
            let (path, out) = open("csv")?;
            let mut file = CsvFile::new(out);
            // A table without rows has a header all the same.
            file.add(&Table::new(columns.to_vec(), [])).map_err(|error| write_error(&path, error))?;
            streamed.csv = Some((path, file));
        }
        if formats.contains(&Format::Parquet) {
            let (path, out) = open("parquet")?;
            let file = ParquetFile::new(columns, out).map_err(|error| write_error(&path, error))?;
            streamed.parquet = Some((path, file));
        }
        Ok(streamed)
    }

    /// Adds the rows of `table`, which has the columns of the files; `Err` when they cannot be written.
    pub fn add(&mut self, table: &Table) -> Result<()> {
        if let Some((path, file)) = &mut self.csv {
            let added = match &mut self.kept {
                Some(kept) => kept.add(table),
                None => file.add(table),
            };
            added.map_err(|error| write_error(path, error))?;
        }
        if let Some((path, file)) = &mut self.parquet {
            file.add(table).map_err(|error| write_error(path, error))?;
        }
        Ok(())
    }

    /// Returns the finished files, and a sentence on which rows the CSV file has, if not all; `Err` when they cannot be written.
    pub fn finish(self) -> Result<(Vec<OutputFile>, Option<String>)> {
        let (mut files, mut note) = (Vec::new(), None);
        if let Some((path, file)) = self.csv {
            let mut out = file.finish().map_err(|error| write_error(&path, error))?;
            let kept = self.kept.map(|kept| kept.finish(&self.stem, &mut out));
            note = kept.transpose().map_err(|error| write_error(&path, error))?;
            files.push(finish_file(&path, out)?);
        }
        if let Some((path, file)) = self.parquet {
            let out = file.finish().map_err(|error| write_error(&path, error))?;
            files.push(finish_file(&path, out)?);
        }
        Ok((files, note))
    }
}

/// Flushes a temporary file and returns it as the output file `path`.
fn finish_file(path: &Path, out: Out) -> Result<OutputFile> {
    let file = out.into_inner().map_err(IntoInnerError::into_error).map_err(|error| write_error(path, error))?;
    Ok(OutputFile::from_temporary(path.file_name().unwrap_or_default().to_string_lossy(), file))
}

/// Wraps an error as one of writing the file `path`.
fn write_error(path: &Path, error: impl Into<Box<dyn StdError + Send + Sync>>) -> Error {
    Error::Write { file: path.to_path_buf(), source: IoError::other(error) }
}
