//! Parts of studies, computed anywhere as bytes, and merged into the results of one run.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use kinetostat::{
    Overrides, RunOptions, Start, Study,
    run::parts::remove_parts,
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

/// What a part is: its number, of how many, its round (from 1), whether nothing was left to other parts or a later round, and its pieces.
type Head = (u32, u32, u32, bool, u64);

/// A study whose finished parts are in a folder.
#[pyclass(frozen, module = "kinetostat._kinetostat")]
#[derive(Debug)]
pub struct KeptParts {
    study: Study,
    folder: PathBuf,
    program: String,
}

#[pymethods]
impl KeptParts {
    /// The study `path`, changed as `grid` and `points` say, and the `folder` of its parts, which need not be there yet.
    #[staticmethod]
    #[pyo3(signature = (path, folder, grid, points))]
    fn open(
        py: Python<'_>,
        path: PathBuf,
        folder: PathBuf,
        grid: Option<[usize; 3]>,
        points: Option<usize>,
    ) -> PyResult<Self> {
        Ok(Self { study: opened(py, &path, grid, points)?, folder, program: build(py)?.to_string() })
    }

    /// Number of pieces that do not need one another; as [`study_pieces`].
    #[getter]
    fn pieces(&self) -> usize {
        self.study.kind.pieces()
    }

    /// Whether it goes in rounds; as [`study_pieces`].
    #[getter]
    fn goes_in_rounds(&self) -> bool {
        self.study.kind.goes_in_rounds()
    }

    /// Refuses, before anything is computed, a folder `out` into which results cannot be written.
    fn check_out(&self, py: Python<'_>, out: PathBuf) -> PyResult<()> {
        let options = self.options();
        py.detach(|| self.study.prepare_run(&out, &options).map(drop)).map_err(raised)
    }

    /// All parts in the folder, which are of this study by this build.
    fn heads(&self, py: Python<'_>) -> PyResult<Vec<Head>> {
        Ok(self.read(py)?.iter().map(head_of).collect())
    }

    /// Keeps the bytes of a part in the folder.
    fn keep(&self, py: Python<'_>, part: Vec<u8>) -> PyResult<Head> {
        let kept = py.detach(|| self.study.keep_part(&part, &self.folder, Some(&self.program)));
        Ok(head_of(&kept.map_err(raised)?))
    }

    /// What parts of `round` need of those of all rounds before, as bytes.
    fn excerpt<'py>(&self, py: Python<'py>, round: u32) -> PyResult<Bound<'py, PyBytes>> {
        let before = self.read(py)?.into_iter().filter(|part| part.head().round < round).collect();
        let program = Some(self.program.as_str());
        let excerpt = wait_for(py, |_| Ok(()), |stop| self.study.excerpt(before, program, Arc::clone(stop)))?;
        Ok(PyBytes::new(py, &excerpt.map_err(raised)?))
    }

    /// Results of all parts in the folder `out`.
    fn merge(&self, py: Python<'_>, out: PathBuf) -> PyResult<()> {
        merged(py, &self.study, self.read(py)?, &out, &self.options())
    }

    /// Removes the parts, and the folder if nothing else is in it.
    fn remove(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| remove_parts(&self.folder)).map_err(raised)
    }
}

impl KeptParts {
    fn read(&self, py: Python<'_>) -> PyResult<Vec<Part>> {
        py.detach(|| self.study.kept_parts(&self.folder, Some(&self.program))).map_err(raised)
    }

    fn options(&self) -> RunOptions {
        options(&self.program)
    }
}

fn head_of(part: &Part) -> Head {
    let head = part.head();
    (head.share.part(), head.share.of(), head.round, head.is_complete, head.pieces)
}

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

/// Part `number` of `count` (from 1) of the study `path` as bytes; `before` are all parts of the rounds before, or their excerpt. On so many threads, 0 for as many
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
    let options = options(build(py)?);
    merged(py, &study, parts, &out, &options)
}

/// The head of a part.
#[pyfunction]
pub fn part_head(part: Vec<u8>) -> PyResult<Head> {
    Ok(head_of(&Part::read(source(0, part)).map_err(raised)?))
}

fn options(program: &str) -> RunOptions {
    RunOptions { begin: Start::Resume, program: Some(program.into()), ..RunOptions::default() }
}

fn merged(py: Python<'_>, study: &Study, parts: Vec<Part>, out: &Path, options: &RunOptions) -> PyResult<()> {
    let merge = |stop: &Arc<_>| study.merge_into(parts, out, options, Arc::clone(stop), |_| ()).map(|_| ());
    wait_for(py, |_| Ok(()), merge)?.map_err(raised)
}

fn opened(py: Python<'_>, path: &std::path::Path, grid: Option<[usize; 3]>, points: Option<usize>) -> PyResult<Study> {
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
