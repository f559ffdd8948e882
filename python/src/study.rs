//! Studies run into folders, as the command line runs them.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use kinetostat::{
    Event, Overrides, RunOptions, Start, Study,
    figures::Colours,
    files::exchange::{Format, WrittenRows},
};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    build::build,
    error::{raised, refused},
    waiting::wait_for,
};

/// How far a study is.
#[derive(Debug, Clone)]
struct Progress {
    of: String,
    done: usize,
    total: usize,
}

/// Opens the study `path`, changed as `grid`, `points` and `parameters` say, and runs it into `out`, or the folder
/// `results/` that the command line takes; `all_points` writes all rows of long tables of path points. `told` gets items done, their number and what they are called.
#[pyfunction]
#[pyo3(signature = (path, out, grid, points, all_points, parameters, figures, colours, begin, told))]
#[allow(clippy::too_many_arguments)]
pub fn run_study<'py>(
    py: Python<'py>,
    path: PathBuf,
    out: Option<PathBuf>,
    grid: Option<[usize; 3]>,
    points: Option<usize>,
    all_points: bool,
    parameters: Vec<(String, f64)>,
    figures: bool,
    colours: &str,
    begin: &str,
    told: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let overrides = Overrides { grid, points, parameters, ..Overrides::default() };
    let begin = one_of("begin", begin, &[("new", Start::New), ("resume", Start::Resume), ("restart", Start::Restart)])?;
    let colours = one_of("colours", colours, &Colours::ALL.map(|colours| (colours.label(), colours)))?;
    let (formats, program) = (vec![Format::Csv], Some(build(py)?.into()));
    let rows = if all_points { WrittenRows::All } else { WrittenRows::default() };
    let options = RunOptions { formats, rows, figures, colours, begin, program };
    let study = py.detach(|| Study::open(&path, &overrides)).map_err(raised)?;
    let out = out.unwrap_or_else(|| Path::new("results").join(&study.name));
    let (total, of) = study.kind.items();
    let progress = Arc::new(Mutex::new(Progress { of: of.into(), done: 0, total }));
    let watched = Arc::clone(&progress);
    let tell = |progress: Progress| match told.is_none() {
        true => Ok(()),
        false => told.call1((progress.done, progress.total, progress.of)).map(|_| ()),
    };
    let finished = wait_for(
        py,
        |_| tell(lock(&progress).clone()),
        |stop| {
            study.run_into(&out, &options, Arc::clone(stop), move |event| {
                let mut progress = lock(&watched);
                match event {
                    Event::Computed(items) | Event::Kept(items) => progress.done += items,
                    Event::Stage(stage) => *progress = Progress { of: stage.of.into(), done: 0, total: stage.items },
                    _ => {}
                }
            })
        },
    )?;
    let finished = finished.map_err(raised)?;
    tell(lock(&progress).clone())?;
    let dict = PyDict::new(py);
    dict.set_item("folder", out)?;
    dict.set_item("question", study.question)?;
    let verdict = finished.headline.verdict.map(|own| format!("{} {}", own.state.sign(), own.words));
    dict.set_item("verdict", verdict)?;
    let causes = finished
        .headline
        .causes
        .into_iter()
        .map(|own| (own.cause.text().replace(' ', "_"), own.mark.sign().to_string(), own.mm, own.source));
    dict.set_item("causes", causes.collect::<Vec<_>>())?;
    dict.set_item("unsolved", finished.headline.unsolved)?;
    dict.set_item("sentence", finished.headline.sentence)?;
    let numbers = finished.headline.numbers.into_iter().map(|key| (key.value, key.unit, key.what, key.against));
    dict.set_item("numbers", numbers.collect::<Vec<_>>())?;
    dict.set_item("basis", finished.headline.basis)?;
    dict.set_item("cautions", finished.headline.cautions)?;
    dict.set_item("details", finished.details)?;
    dict.set_item("is_complete", finished.is_complete)?;
    Ok(dict)
}

/// The TOML of a table that is written as JSON.
#[pyfunction]
pub fn as_toml(json: &str) -> PyResult<String> {
    let value: serde_json::Value = serde_json::from_str(json).map_err(|fault| refused("table", &fault.to_string()))?;
    toml::to_string(&value).map_err(|fault| refused("table", &fault.to_string()))
}

/// What `word` stands for among `choices`.
fn one_of<T: Copy>(what: &str, word: &str, choices: &[(&str, T)]) -> PyResult<T> {
    let found = choices.iter().find(|(own, _)| *own == word).map(|(_, choice)| *choice);
    found.ok_or_else(|| {
        let words = choices.iter().map(|(own, _)| *own).collect::<Vec<_>>().join(", ");
        refused(what, &format!("expected one of {words}, got \"{word}\""))
    })
}

fn lock(progress: &Mutex<Progress>) -> MutexGuard<'_, Progress> {
    progress.lock().unwrap_or_else(PoisonError::into_inner)
}
