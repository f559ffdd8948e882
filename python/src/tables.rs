//! Tables of result folders as arrays, column by column.

use std::{fs::File, io::BufReader, path::PathBuf};

use csv::ReaderBuilder;
use kinetostat::files::exchange::{Cell, Kind, Table};
use pyo3::{
    prelude::*,
    types::{PyDict, PyList},
};

use crate::{arrays::array, error::refused};

enum Column {
    /// NaN where there is nothing.
    Numbers(Vec<f64>),
    Texts(Vec<String>),
}

/// The columns of the CSV file `path` by name: numbers, where `is_number` says so of a column, or else texts.
#[pyfunction]
pub fn read_table(py: Python<'_>, path: PathBuf, is_number: Vec<bool>) -> PyResult<Bound<'_, PyDict>> {
    let read = py.detach(|| read(&path, &is_number));
    let (names, columns) = read.map_err(|problem| refused(&path.display().to_string(), &problem))?;
    let dict = PyDict::new(py);
    for (name, column) in names.iter().zip(columns) {
        match column {
            Column::Numbers(numbers) => {
                let count = numbers.len();
                dict.set_item(name, array(py, numbers, [count])?)?;
            }
            Column::Texts(texts) => dict.set_item(name, texts)?,
        }
    }
    Ok(dict)
}

/// The columns of `table` as name, unit and values: numbers, NaN where there is none, or texts.
pub fn columns_of<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyList>> {
    let columns = PyList::empty(py);
    for (k, column) in table.columns().iter().enumerate() {
        let cells = table.rows().iter().map(|row| &row[k]);
        let values = if column.kind == Kind::Text {
            let texts = cells.map(|cell| if let Cell::Text(text) = cell { text.as_str() } else { "" });
            PyList::new(py, texts)?.into_any()
        } else {
            array(py, cells.map(Cell::number_or_nan).collect(), [table.rows().len()])?
        };
        columns.append((&column.name, column.unit().unwrap_or_default(), values))?;
    }
    Ok(columns)
}

fn read(path: &PathBuf, is_number: &[bool]) -> Result<(Vec<String>, Vec<Column>), String> {
    let file = File::open(path).map_err(|fault| format!("cannot be read: {fault}"))?;
    let mut reader = ReaderBuilder::new().from_reader(BufReader::new(file));
    let names: Vec<String> = reader.headers().map_err(|fault| fault.to_string())?.iter().map(String::from).collect();
    if names.len() != is_number.len() {
        return Err(format!("has {} columns; expected {}, as csv-metadata.json says", names.len(), is_number.len()));
    }
    let empty = |is_number: &bool| if *is_number { Column::Numbers(Vec::new()) } else { Column::Texts(Vec::new()) };
    let mut columns: Vec<Column> = is_number.iter().map(empty).collect();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(|fault| fault.to_string())? {
        for ((column, text), name) in columns.iter_mut().zip(&record).zip(&names) {
            match column {
                Column::Numbers(numbers) if text.is_empty() => numbers.push(f64::NAN),
                Column::Numbers(numbers) => match text.parse() {
                    Ok(number) => numbers.push(number),
                    Err(_) => {
                        let line = record.position().map_or(0, csv::Position::line);
                        return Err(format!("line {line}: {name}: expected a number, got \"{text}\""));
                    }
                },
                Column::Texts(texts) => texts.push(text.into()),
            }
        }
    }
    Ok((names, columns))
}
