//! Studies in parts: a part as bytes, computed by any process, and the results of all of them.

use std::path::PathBuf;

use kinetostat::{
    Begin, Event, Overrides, RunOptions, Study,
    work::{
        part_file::{Part, PartSource},
        share::Share,
    },
};
use pyo3::{prelude::*, pybacked::PyBackedBytes, types::PyBytes};
use rayon::ThreadPoolBuilder;

use crate::{
    build::build,
    error::{raised, refused},
    waiting::wait_for,
};

/// How many pieces the study `path` has that do not need one another, and whether it goes in rounds.
#[pyfunction]
pub fn study_pieces(py: Python<'_>, path: PathBuf) -> PyResult<(usize, bool)> {
    let study = open(py, &path)?;
    Ok((study.kind.pieces(), study.kind.goes_in_rounds()))
}

/// Part `number` of `count`, from 1, on so many threads, 0 for all processors; `before` are all parts of earlier
/// rounds.
#[pyfunction]
pub fn compute_part<'py>(
    py: Python<'py>,
    path: PathBuf,
    number: u32,
    count: u32,
    before: Vec<PyBackedBytes>,
    threads: usize,
) -> PyResult<Bound<'py, PyBytes>> {
    let share = Share::new(number, count).map_err(|problem| refused("part", &problem))?;
    let (study, program) = (open(py, &path)?, build(py)?);
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|fault| refused("threads", &fault.to_string()))?;
    let compute = |stop: &_| {
        let before = read(&before)?;
        pool.install(|| study.part(share, before, Some(program), std::sync::Arc::clone(stop), |_: Event| ()))
    };
    let bytes = wait_for(py, |_| Ok(()), compute)?.map_err(raised)?;
    Ok(PyBytes::new(py, &bytes))
}

/// The results of the study `path` from all its parts, in any order, into the folder `out`.
#[pyfunction]
pub fn merge_parts(py: Python<'_>, path: PathBuf, parts: Vec<PyBackedBytes>, out: PathBuf) -> PyResult<()> {
    let (study, program) = (open(py, &path)?, build(py)?);
    let options = RunOptions { begin: Begin::Resume, program: Some(program.into()), ..RunOptions::default() };
    let merge = |stop: &_| study.merge_into(read(&parts)?, &out, &options, std::sync::Arc::clone(stop), |_: Event| ());
    wait_for(py, |_| Ok(()), merge)?.map_err(raised).map(drop)
}

/// What a part says of itself: its number, of how many, its round, whether nothing is left to others or a later round,
/// its pieces.
#[pyfunction]
pub fn part_head(part: PyBackedBytes) -> PyResult<(u32, u32, u32, bool, u64)> {
    let part = read(std::slice::from_ref(&part)).map_err(raised)?;
    let head = part.first().map(Part::head).ok_or_else(|| refused("part", "is not there"))?;
    Ok((head.share.part(), head.share.of(), head.round, head.is_complete, head.pieces))
}

fn open(py: Python<'_>, path: &std::path::Path) -> PyResult<Study> {
    py.detach(|| Study::open(path, &Overrides::default())).map_err(raised)
}

fn read(parts: &[PyBackedBytes]) -> kinetostat::Result<Vec<Part>> {
    let source = |(number, bytes): (usize, &PyBackedBytes)| {
        Part::read(PartSource::Bytes(format!("bytes {number}"), bytes.as_ref().into()))
    };
    parts.iter().enumerate().map(source).collect()
}
