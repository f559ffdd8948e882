//! Parts of studies, computed anywhere as bytes, and merged into the results of one run.

use std::{path::PathBuf, sync::Arc};

use kinetostat::{
    Overrides, RunOptions, Start, Study,
    work::{
        part_file::{Part, PartSource},
        share::Share,
    },
};
use pyo3::{prelude::*, types::PyBytes};

use crate::{
    build::build,
    error::{raised, refused},
    waiting::{pool_of, wait_for, wait_on},
};

/// How many pieces the study `path` has that do not need one another, and whether it goes in rounds, each of which needs all parts of those before.
#[pyfunction]
#[pyo3(signature = (path, grid=None, points=None))]
pub fn study_pieces(
    py: Python<'_>,
    path: PathBuf,
    grid: Option<[usize; 3]>,
    points: Option<usize>,
) -> PyResult<(usize, bool)> {
    let study = opened(py, &path, grid, points)?;
    Ok((study.kind.pieces(), study.kind.goes_in_rounds()))
}

/// Part `number` of `count` (from 1) of the study `path` as bytes; `before` are all parts of the rounds before. On so many threads, 0 for as many
/// as processors.
#[pyfunction]
#[pyo3(signature = (path, number, count, before=Vec::new(), threads=0, grid=None, points=None))]
#[allow(clippy::too_many_arguments)]
pub fn compute_part<'py>(
    py: Python<'py>,
    path: PathBuf,
    number: u32,
    count: u32,
    before: Vec<Vec<u8>>,
    threads: usize,
    grid: Option<[usize; 3]>,
    points: Option<usize>,
) -> PyResult<Bound<'py, PyBytes>> {
    let study = opened(py, &path, grid, points)?;
    let share = Share::new(number, count).map_err(|problem| refused("part", &problem))?;
    let (before, program, pool) = (py.detach(|| read(before))?, build(py)?.to_string(), pool_of(threads)?);
    let found =
        wait_on(py, &pool, |_| Ok(()), |stop| study.part(share, before, Some(&program), Arc::clone(stop), |_| ()))?;
    Ok(PyBytes::new(py, &found.map_err(raised)?))
}

/// All parts of the study `path`, in any order, as results in the folder `out`.
#[pyfunction]
#[pyo3(signature = (path, parts, out, grid=None, points=None))]
pub fn merge_parts(
    py: Python<'_>,
    path: PathBuf,
    parts: Vec<Vec<u8>>,
    out: PathBuf,
    grid: Option<[usize; 3]>,
    points: Option<usize>,
) -> PyResult<()> {
    let study = opened(py, &path, grid, points)?;
    let parts = py.detach(|| read(parts))?;
    let options = RunOptions { begin: Start::Resume, program: Some(build(py)?.into()), ..RunOptions::default() };
    let merged =
        wait_for(py, |_| Ok(()), |stop| study.merge_into(parts, &out, &options, Arc::clone(stop), |_| ()).map(|_| ()))?;
    merged.map_err(raised)
}

/// Which part it is, of how many, of which round (from 1), whether nothing was left to other parts or a later round, and its pieces.
#[pyfunction]
pub fn part_head(part: Vec<u8>) -> PyResult<(u32, u32, u32, bool, u64)> {
    let part = Part::read(source(0, part)).map_err(raised)?;
    let head = part.head();
    Ok((head.share.part(), head.share.of(), head.round, head.is_complete, head.pieces))
}

fn opened(py: Python<'_>, path: &PathBuf, grid: Option<[usize; 3]>, points: Option<usize>) -> PyResult<Study> {
    let overrides = Overrides { grid, points, ..Overrides::default() };
    py.detach(|| Study::open(path, &overrides)).map_err(raised)
}

fn read(parts: Vec<Vec<u8>>) -> PyResult<Vec<Part>> {
    let read = parts.into_iter().enumerate().map(|(number, bytes)| Part::read(source(number, bytes)));
    read.collect::<kinetostat::Result<_>>().map_err(raised)
}

fn source(number: usize, bytes: Vec<u8>) -> PartSource {
    PartSource::Bytes(format!("bytes {number}"), bytes.into())
}
