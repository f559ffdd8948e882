//! Programs of machines: points with their loads, what commands lead to along them, and the program written anew.

use std::{
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
};

use kinetostat::{
    Method, Result,
    nalgebra::Vector3,
    products::program::{CompensateOptions, Compensated, NoFiles, Pass, ProgramJob},
    simulation::{along_path::PathPointResult, spread::DeflectionSpread, spread_along::LargestSpread},
    work::{Event, Work},
};
use pyo3::{
    prelude::*,
    types::{PyBytes, PyDict},
};

use crate::{
    arrays::array,
    error::{raised, refused},
    machine::{Machine, method_named},
    poses::write_pose,
    waiting::wait_for,
};

/// What a machine does: placement, force, chain errors, limits.
#[pyclass(frozen, module = "kinetostat._kinetostat")]
#[derive(Debug, Clone)]
pub struct Process {
    process: kinetostat::Process,
}

#[pymethods]
impl Process {
    /// The process file `path`, on `machine`.
    #[staticmethod]
    fn from_file(path: PathBuf, machine: &Machine) -> PyResult<Self> {
        Self::of(machine, |nominal| kinetostat::Process::open(&path, nominal))
    }

    /// The process that is written in `toml`; files that it names are sought relative to `folder`.
    #[staticmethod]
    fn from_toml(toml: &str, origin: &str, folder: PathBuf, machine: &Machine) -> PyResult<Self> {
        Self::of(machine, |nominal| kinetostat::Process::from_toml(toml, origin, folder, nominal))
    }

    /// What it says, as pairs of words.
    fn facts(&self) -> Vec<(&'static str, String)> {
        self.process.facts()
    }

    /// What it was taken to be where it does not say.
    fn assumed(&self) -> Vec<(&'static str, String)> {
        self.process.assumed()
    }
}

impl Process {
    /// What `read` makes of the machine, which commands.
    fn of(machine: &Machine, read: impl FnOnce(&kinetostat::Machine) -> Result<kinetostat::Process>) -> PyResult<Self> {
        let nominal = machine.own();
        if !nominal.parameter_errors().is_empty() {
            let problem = "has errors of its chains among its parameters, by which nothing is commanded: expected them in \
                           [[chain_error]] of the process";
            return Err(refused(&nominal.name, problem));
        }
        Ok(Self { process: read(nominal).map_err(raised)? })
    }
}

/// A program on a machine.
#[pyclass(frozen, module = "kinetostat._kinetostat")]
#[derive(Debug)]
pub struct Program {
    job: ProgramJob,
}

#[pymethods]
impl Program {
    /// The program in the file `path`.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf, process: &Process) -> PyResult<Self> {
        let process = process.process.clone().as_programmed("Python").map_err(raised)?;
        Self::opened(py, |work| ProgramJob::open(process, &path, work))
    }

    /// The program that `content` of a file called `name` is.
    #[staticmethod]
    fn parse(py: Python<'_>, content: Vec<u8>, name: &str, process: &Process) -> PyResult<Self> {
        let process = process.process.clone().as_programmed("Python").map_err(raised)?;
        let program = process.parse_program(content, name.as_ref()).map_err(raised)?;
        Self::opened(py, |work| ProgramJob::new(process, program, name, work))
    }

    fn __len__(&self) -> usize {
        self.job.path.len()
    }

    /// Its points as arrays by name.
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (dict, count) = (PyDict::new(py), self.job.path.len());
        let (mut pose, mut wrench) = (vec![0.0; 16 * count], Vec::with_capacity(6 * count));
        let mut rows = pose.chunks_mut(16);
        for part in self.job.parts() {
            for task in part.map_err(raised)?.tasks() {
                wrench.extend(task.load.to_array());
                if let Some(row) = rows.next() {
                    write_pose(&task.pose, row);
                }
            }
        }
        let points = self.job.path.points();
        let line =
            |segment: usize| self.job.file.line_of(segment).and_then(|line| i64::try_from(line).ok()).unwrap_or(0);
        dict.set_item("position", array(py, numbers(points.iter().map(|point| &point.position_mm)), [count, 3])?)?;
        dict.set_item("pose", array(py, pose, [count, 4, 4])?)?;
        dict.set_item("wrench", array(py, wrench, [count, 6])?)?;
        dict.set_item("arc_length", array(py, points.iter().map(|point| point.arc_length_mm).collect(), [count])?)?;
        dict.set_item("cutting", array(py, (0..count).map(|k| self.job.is_counted(k)).collect(), [count])?)?;
        dict.set_item("line", array(py, points.iter().map(|point| line(point.source.segment)).collect(), [count])?)?;
        Ok(dict)
    }

    /// What the commands of a method lead to at each point, as arrays by name.
    fn follow<'py>(&self, py: Python<'py>, method: &str, told: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let method = method_named(method)?;
        self.job.process.clone().exact_for("following a program").map_err(raised)?;
        let (answers, pass) = self.wait(py, told, 1, |job, work| {
            let mut answers = Vec::with_capacity(job.path.len());
            let pass = job.pass_by(method, &|| work.tell(Event::Computed(1)), |_, found| {
                answers.extend_from_slice(found);
                work.check()
            })?;
            Ok((answers, pass))
        })?;
        let dict = self.answers(py, &answers)?;
        dict.set_item("summary", summary(py, &pass)?)?;
        Ok(dict)
    }

    /// The program that commands what a method finds, with what it leaves without compensation and as written; where there is no command
    /// for a point at which the tool cuts, those points and why.
    fn compensated<'py>(
        &self,
        py: Python<'py>,
        method: &str,
        told: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let asked = CompensateOptions::by(method_named(method)?);
        let (passes, found) = self.wait(py, told, asked.pass_count(&self.job), |job, work| {
            Ok(match job.compensate(&asked, &mut NoFiles, work)? {
                Compensated::Verified(verified) => (verified.passes, Ok((verified.written, verified.spread))),
                Compensated::Refused(refused) => {
                    let none = job.pass_by(Method::None, &|| work.tell(Event::Computed(1)), |_, _| work.check())?;
                    ([none].into_iter().chain(refused.pass).collect(), Err(refused.failures))
                }
            })
        })?;
        let dict = PyDict::new(py);
        let summaries = PyDict::new(py);
        for (index, pass) in passes.iter().enumerate() {
            let name = if index == 2 { "as_written" } else { &pass.name };
            summaries.set_item(name, summary(py, pass)?)?;
        }
        dict.set_item("summaries", summaries)?;
        match found {
            Ok((written, spread)) => {
                let spread = spread.map(|own| {
                    let of = |own: LargestSpread| {
                        let DeflectionSpread { median_mm, p95_mm, within_tolerance, .. } = own.spread;
                        (median_mm, p95_mm, within_tolerance)
                    };
                    (of(own.plain), own.compensated.map(of), own.worse)
                });
                dict.set_item("spread", spread)?;
                let count = written.sent.positions.len();
                dict.set_item("bytes", PyBytes::new(py, &written.bytes))?;
                dict.set_item("position", array(py, numbers(written.sent.positions.iter()), [count, 3])?)?;
                dict.set_item("rounded_mm", written.rounded_mm)?;
                dict.set_item("failures", Vec::<(usize, String)>::new())?;
            }
            Err(failures) => dict.set_item("failures", failures)?,
        }
        Ok(dict)
    }
}

impl Program {
    /// Waits for `make`, which seeks γ if the process asks for the best one.
    fn opened(py: Python<'_>, make: impl FnOnce(&Work) -> Result<ProgramJob> + Send) -> PyResult<Self> {
        let job = wait_for(py, |_| Ok(()), |stop| make(&Work::new(None, Arc::clone(stop), Box::new(|_| ()))))?;
        Ok(Self { job: job.map_err(raised)? })
    }

    /// Lets `compute` work while `told` is told how many of so many `passes` over the points are done.
    fn wait<T: Send>(
        &self,
        py: Python<'_>,
        told: &Bound<'_, PyAny>,
        passes: usize,
        compute: impl FnOnce(&ProgramJob, &Work) -> Result<T> + Send,
    ) -> PyResult<T> {
        let (count, total) = (Arc::new(AtomicUsize::new(0)), passes * self.job.path.len());
        let counted = Arc::clone(&count);
        let tell = |done: usize| if told.is_none() { Ok(()) } else { told.call1((done, total, "points")).map(|_| ()) };
        let found = wait_for(
            py,
            |_| tell(count.load(Ordering::Relaxed)),
            |stop| {
                let watch = move |event| {
                    if let Event::Computed(points) = event {
                        counted.fetch_add(points, Ordering::Relaxed);
                    }
                };
                compute(&self.job, &Work::new(None, Arc::clone(stop), Box::new(watch)))
            },
        )?;
        tell(count.load(Ordering::Relaxed))?;
        found.map_err(raised)
    }

    fn answers<'py>(&self, py: Python<'py>, answers: &[PathPointResult]) -> PyResult<Bound<'py, PyDict>> {
        let (dict, count, drives) = (PyDict::new(py), answers.len(), self.job.machine.drive_count());
        let mut command = vec![f64::NAN; 16 * count];
        for (row, answer) in command.chunks_mut(16).zip(answers) {
            if let Some(target) = &answer.target {
                write_pose(target, row);
            }
        }
        let of_drives = |own: &dyn Fn(&PathPointResult) -> Vec<f64>| {
            let rows = answers.iter().map(|answer| {
                let row = own(answer);
                if row.len() == drives { row } else { vec![f64::NAN; drives] }
            });
            rows.collect::<Vec<_>>().concat()
        };
        let settled = |own: &dyn Fn(&PathPointResult) -> Vector3<f64>| {
            let rows =
                answers.iter().map(|answer| if answer.is_settled { own(answer) } else { Vector3::repeat(f64::NAN) });
            numbers(rows.collect::<Vec<_>>().iter())
        };
        dict.set_item("drives", array(py, of_drives(&|answer| answer.drives.clone()), [count, drives])?)?;
        dict.set_item(
            "nominal_drives",
            array(py, of_drives(&|answer| answer.nominal_drives.clone()), [count, drives])?,
        )?;
        let forces =
            |answer: &PathPointResult| if answer.is_settled { answer.drive_forces.clone() } else { Vec::new() };
        dict.set_item("drive_forces", array(py, of_drives(&forces), [count, drives])?)?;
        dict.set_item("command", array(py, command, [count, 4, 4])?)?;
        dict.set_item("error", array(py, settled(&|answer| answer.position_error), [count, 3])?)?;
        dict.set_item("rotation", array(py, settled(&|answer| answer.residual_rotation), [count, 3])?)?;
        dict.set_item("status", answers.iter().map(|answer| answer.status.label()).collect::<Vec<_>>())?;
        let failed = answers.iter().enumerate().filter(|(_, answer)| !answer.status.is_success());
        let reasons = failed.map(|(k, answer)| (k, answer.status.reason(&self.job.machine)));
        dict.set_item("reasons", reasons.collect::<Vec<_>>())?;
        Ok(dict)
    }
}

fn numbers<'a>(vectors: impl Iterator<Item = &'a Vector3<f64>>) -> Vec<f64> {
    vectors.flat_map(|vector| vector.iter().copied()).collect()
}

/// What a pass leaves over the points at which the tool cuts.
fn summary<'py>(py: Python<'py>, pass: &Pass) -> PyResult<Bound<'py, PyDict>> {
    let (dict, summary) = (PyDict::new(py), &pass.summary);
    dict.set_item("points", summary.points)?;
    dict.set_item("solved", summary.solved)?;
    dict.set_item("failed", summary.failed)?;
    dict.set_item("max_mm", summary.max_mm)?;
    dict.set_item("rms_mm", summary.rms_mm)?;
    Ok(dict)
}
