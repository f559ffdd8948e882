//! Readings predicted for rows of poses and loads, as the command `predict` does.

use std::{
    path::PathBuf,
    sync::{Arc, atomic::AtomicBool},
};

use kinetostat::{
    Overrides, Study,
    input::Folder,
    questions::{
        StudyKind,
        identification::report::predicted::{PredictedRows, predict_rows, predict_rows_of},
    },
    work::Work,
};
use pyo3::{prelude::*, types::PyList};

use crate::{
    error::{raised, refused},
    machine::Machine,
    tables::columns_of,
    waiting::wait_for,
};

/// Columns of predicted readings (name, unit, values), what is said of them, and whether all rows are predicted.
type Predicted<'py> = (Bound<'py, PyList>, String, bool);

/// Readings of the rows in the CSV text `source`, called `name` in messages, or else in the file `name`, predicted by the identification in the
/// study `path`, whose machine has these `parameters` set: with intervals.
#[pyfunction]
pub fn predict_by_study<'py>(
    py: Python<'py>,
    path: PathBuf,
    parameters: Vec<(String, f64)>,
    source: Option<Vec<u8>>,
    name: &str,
) -> PyResult<Predicted<'py>> {
    let study = py.detach(|| Study::open(&path, &Overrides { parameters, ..Overrides::default() })).map_err(raised)?;
    let StudyKind::Identification(study, ()) = &study.kind else {
        let problem = "is a study of another kind: expected one with [identification]";
        return Err(refused(&path.display().to_string(), problem));
    };
    let source = rows(source, name)?;
    let work = |stop: &Arc<AtomicBool>| Work::new(None, Arc::clone(stop), Box::new(|_| ()));
    let found = wait_for(py, |_| Ok(()), |stop| predict_rows(study, &source, name, &work(stop)))?;
    in_python(py, found.map_err(raised)?)
}

/// Readings of the same rows predicted for `machine` as it is: without intervals.
#[pyfunction]
pub fn predict_by_machine<'py>(
    py: Python<'py>,
    machine: &Machine,
    source: Option<Vec<u8>>,
    name: &str,
) -> PyResult<Predicted<'py>> {
    let source = rows(source, name)?;
    let found = wait_for(py, |_| Ok(()), |_| predict_rows_of(machine.own(), &source, name))?;
    in_python(py, found.map_err(raised)?)
}

/// The CSV text `source`, or that of the file `name`.
fn rows(source: Option<Vec<u8>>, name: &str) -> PyResult<Vec<u8>> {
    source.map_or_else(|| Folder::from(PathBuf::new()).bytes(name).map_err(raised), Ok)
}

fn in_python(py: Python<'_>, found: PredictedRows) -> PyResult<Predicted<'_>> {
    let PredictedRows { table, words, is_complete } = found;
    Ok((columns_of(py, &table)?, words, is_complete))
}
