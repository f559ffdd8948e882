//! The class that a machine is in Python.

use std::path::PathBuf;

use kinetostat::{
    Method, Target,
    machine::{Motion, Parameter, catalogue},
    nalgebra::Vector3,
    simulation::Machines,
    urdf,
};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    arrays::array,
    error::{raised, refused},
    parameters::{Sets, deflections, machines_of},
    poses::{Asked, Commands, write_pose},
    settle::{Commanded, STATUSES, Settled, settle},
    waiting::wait_for,
};

/// Names of the built-in machines.
#[pyfunction]
pub fn machine_names() -> Vec<&'static str> {
    catalogue::names().collect()
}

/// A machine: what was read, what was set, and those that command and answer.
#[pyclass(frozen, module = "kinetostat._kinetostat")]
#[derive(Debug, Clone)]
pub struct Machine {
    /// Names it in messages and studies.
    origin: String,
    toml: String,
    /// As it was read, and with the numbers that were set.
    read: kinetostat::Machine,
    own: kinetostat::Machine,
    set: Vec<(String, f64)>,
    machines: Machines,
}

impl Machine {
    fn read(toml: String, origin: String) -> PyResult<Self> {
        let read = kinetostat::Machine::from_toml(&toml, &origin).map_err(raised)?;
        let machines = machines_of(&read).map_err(raised)?;
        Ok(Self { origin, toml, own: read.clone(), read, set: Vec::new(), machines })
    }

    /// The machine with the numbers that were set.
    pub fn own(&self) -> &kinetostat::Machine {
        &self.own
    }

    /// The machines that command and answer.
    pub fn machines(&self) -> &Machines {
        &self.machines
    }

    fn settled<'py>(
        &self,
        py: Python<'py>,
        asked: &Asked,
        given: Option<Commands>,
        commanded: Commanded,
    ) -> PyResult<Bound<'py, PyDict>> {
        let settled = wait_for(py, |_| Ok(()), |stop| settle(&self.machines, asked, given, commanded, stop))?;
        as_dict(py, settled.map_err(raised)?, self.own.drive_count())
    }
}

/// What came of cases as arrays by name, empty ones left out.
fn as_dict(py: Python<'_>, settled: Settled, drives: usize) -> PyResult<Bound<'_, PyDict>> {
    let (dict, cases) = (PyDict::new(py), settled.status.len());
    let columns = [
        ("drives", settled.drives),
        ("nominal_drives", settled.nominal_drives),
        ("drive_forces", settled.drive_forces),
    ];
    for (name, values) in columns {
        dict.set_item(name, array(py, values, [cases, drives])?)?;
    }
    for (name, values) in [("pose", settled.pose), ("command", settled.command)] {
        if !values.is_empty() || cases == 0 {
            dict.set_item(name, array(py, values, [cases, 4, 4])?)?;
        }
    }
    for (name, values) in [("deflection", settled.deflection), ("error", settled.error), ("rotation", settled.rotation)]
    {
        dict.set_item(name, array(py, values, [cases, 3])?)?;
    }
    for (name, values) in [("stiffness", settled.stiffness), ("compliance", settled.compliance)] {
        if !values.is_empty() || cases == 0 {
            dict.set_item(name, array(py, values, [cases, 6, 6])?)?;
        }
    }
    dict.set_item("corrections", array(py, settled.corrections, [cases])?)?;
    dict.set_item("status", array(py, settled.status, [cases])?)?;
    dict.set_item("statuses", STATUSES)?;
    dict.set_item("reasons", settled.reasons)?;
    Ok(dict)
}

/// What is compensated, by its word.
fn target_named(name: &str) -> PyResult<Target> {
    match name {
        "tool_tip" => Ok(Target::ToolTip),
        "platform_point" => Ok(Target::PlatformPoint),
        "full_pose" => Ok(Target::FullPose),
        other => Err(refused("target", &format!("expected tool_tip, platform_point or full_pose, got \"{other}\""))),
    }
}

#[pymethods]
impl Machine {
    /// The built-in machine called `name`.
    #[staticmethod]
    fn named(name: &str) -> PyResult<Self> {
        // Its own words for a name that is none.
        kinetostat::Machine::named(name).map_err(raised)?;
        let entry = catalogue::find(name).ok_or_else(|| refused("machine", name))?;
        Self::read(entry.toml.into(), entry.name.into())
    }

    /// The machine of a file.
    #[staticmethod]
    fn from_file(path: PathBuf) -> PyResult<Self> {
        let text = kinetostat::input::toml_file::read(&path).map_err(raised)?;
        Self::read(text, path.display().to_string())
    }

    /// The machine that is written in `toml`; `origin` names it in messages.
    #[staticmethod]
    fn from_toml(toml: String, origin: String) -> PyResult<Self> {
        Self::read(toml, origin)
    }

    /// The machine file of a URDF, and what is to be said about it.
    #[staticmethod]
    #[pyo3(signature = (path, tip, tool_tip, tool_angles, stiffness, like))]
    fn urdf(
        path: PathBuf,
        tip: Option<String>,
        tool_tip: [f64; 3],
        tool_angles: Option<[f64; 3]>,
        stiffness: Option<Vec<f64>>,
        like: Option<&Machine>,
    ) -> PyResult<(String, Vec<String>)> {
        let stiffness = match (stiffness, like) {
            (Some(_), Some(_)) => return Err(refused("like", "expected either stiffness or like, got both")),
            (Some(values), None) => urdf::DriveStiffness::Given(values),
            (None, Some(machine)) => urdf::DriveStiffness::Like(machine.own.clone()),
            (None, None) => urdf::DriveStiffness::Unknown,
        };
        let options = urdf::ImportOptions { tool_tip, tool_angles, tip, stiffness };
        let imported = urdf::import_file(&path, &options).map_err(raised)?;
        Ok((imported.toml, imported.notes))
    }

    /// The same machine with other numbers, by name.
    fn with_parameters(&self, values: Vec<(String, f64)>) -> PyResult<Self> {
        let mut set = self.set.clone();
        for (name, value) in values {
            match set.iter_mut().find(|(own, _)| *own == name) {
                Some((_, own)) => *own = value,
                None => set.push((name, value)),
            }
        }
        let own = self.read.with_parameters(&set).map_err(raised)?;
        let machines = machines_of(&own).map_err(raised)?;
        Ok(Self { own, set, machines, ..self.clone() })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.own.name
    }

    #[getter]
    fn title(&self) -> &str {
        &self.own.title
    }

    #[getter]
    fn source(&self) -> &str {
        &self.own.source
    }

    #[getter]
    fn origin(&self) -> &str {
        &self.origin
    }

    #[getter]
    fn toml(&self) -> &str {
        &self.toml
    }

    #[getter]
    fn set_parameters(&self) -> Vec<(String, f64)> {
        self.set.clone()
    }

    #[getter]
    fn characteristic_length_mm(&self) -> f64 {
        self.own.characteristic_length
    }

    #[getter]
    fn drive_names(&self) -> Vec<String> {
        self.own.drive_labels()
    }

    /// Whether each drive is a revolute joint.
    #[getter]
    fn revolute(&self) -> Vec<bool> {
        self.own.drives().map(|(_, drive)| drive.motion == Motion::Revolute).collect()
    }

    #[getter]
    fn workspace_mm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (min, max) = (self.own.workspace.min, self.own.workspace.max);
        array(py, min.iter().chain(max.iter()).copied().collect(), [2, 3])
    }

    #[getter]
    fn tool_tip_mm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vector(py, &self.own.tool_tip)
    }

    #[getter]
    fn home<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut home = vec![0.0; 16];
        write_pose(&self.own.home.pose, &mut home);
        array(py, home, [4, 4])
    }

    #[getter]
    fn points_mm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let points = PyDict::new(py);
        for point in &self.own.points {
            points.set_item(&point.name, vector(py, &point.position)?)?;
        }
        Ok(points)
    }

    /// Name, value, unit, key, grade and 95 % interval of each parameter.
    #[allow(clippy::type_complexity)]
    fn parameters(
        &self,
    ) -> Vec<(String, Option<f64>, &'static str, Option<String>, Option<&'static str>, Option<(f64, f64)>)> {
        let shown = |parameter: Parameter| {
            let Parameter { name, value, unit, key, grade, interval } = parameter;
            (
                name,
                value,
                unit.in_files(),
                key,
                grade.map(kinetostat::machine::Grade::label),
                interval.map(<(f64, f64)>::from),
            )
        };
        self.own.parameters().into_iter().map(shown).collect()
    }

    /// Commanded without compensation: see `kinetostat.Machine.equilibrium`.
    fn equilibria<'py>(
        &self,
        py: Python<'py>,
        pose: PyReadonlyArray2<'py, f64>,
        wrench: PyReadonlyArray2<'py, f64>,
        stiffness: bool,
        at_tip: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let commanded = Commanded::uncompensated(stiffness, at_tip);
        self.settled(py, &Asked::new(&pose, &wrench)?, None, commanded)
    }

    /// With the drives where they are given: see `kinetostat.Machine.equilibrium_at_drives`.
    fn equilibria_at_drives<'py>(
        &self,
        py: Python<'py>,
        drives: PyReadonlyArray2<'py, f64>,
        wrench: PyReadonlyArray2<'py, f64>,
        stiffness: bool,
        at_tip: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let commanded = Commanded::uncompensated(stiffness, at_tip);
        let asked = Asked::of_loads(drives.shape()[0], &wrench)?;
        let given = Commands::of_drives(&self.machines.nominal, &drives)?;
        self.settled(py, &asked, Some(given), commanded)
    }

    /// Poses of P, `[n, 4, 4]`: see `kinetostat.Machine.forward_kinematics`.
    fn forward<'py>(&self, py: Python<'py>, drives: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyAny>> {
        let found = Commands::of_drives(&self.machines.nominal, &drives)?;
        let mut poses = vec![f64::NAN; 16 * found.found().len()];
        for (into, at) in poses.chunks_mut(16).zip(found.found()) {
            if let Ok(at) = at {
                write_pose(&at.pose, into);
            }
        }
        array(py, poses, [found.found().len(), 4, 4])
    }

    /// Drives, `[n, d]`, and their derivatives by the controlled coordinates, `[n, d, k]`: see `kinetostat.Machine.inverse_kinematics`.
    fn inverse<'py>(
        &self,
        py: Python<'py>,
        pose: PyReadonlyArray2<'py, f64>,
        branch: Option<&str>,
        jacobian: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let nominal = &self.machines.nominal;
        let own = match branch {
            Some(name) => nominal.on_branch(name.parse().map_err(raised)?).map_err(raised)?,
            None => nominal.clone(),
        };
        let asked = Asked::new(&pose, &PyArray2::zeros(py, [1, 6], false).readonly())?;
        let found = Commands::of_places(&own, &asked);
        let (cases, drives, controls) = (found.found().len(), own.drive_count(), own.controls.len());
        let width = if jacobian { drives * controls } else { drives };
        let mut rows = vec![f64::NAN; cases * width];
        for (into, at) in rows.chunks_mut(width.max(1)).zip(found.found()) {
            let Ok(at) = at else { continue };
            match jacobian {
                false => into.copy_from_slice(&at.drives),
                true => {
                    if let Some(matrix) = own.drive_jacobian(at) {
                        into.copy_from_slice(matrix.transpose().as_slice());
                    }
                }
            }
        }
        if jacobian { array(py, rows, [cases, drives, controls]) } else { array(py, rows, [cases, drives]) }
    }

    /// Commanded by a method: see `kinetostat.Machine.compensate`.
    fn compensations<'py>(
        &self,
        py: Python<'py>,
        pose: PyReadonlyArray2<'py, f64>,
        wrench: PyReadonlyArray2<'py, f64>,
        method: &str,
        target: &str,
        at_tip: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (method, target) = (method_named(method)?, target_named(target)?);
        let commanded = Commanded { method, target, stiffness: false, command: true, at_tip };
        self.settled(py, &Asked::new(&pose, &wrench)?, None, commanded)
    }

    /// Displacement of the tool tip, `[sets, cases, 3]`: see `kinetostat.Machine.deflection`.
    fn deflections<'py>(
        &self,
        py: Python<'py>,
        parameters: PyReadonlyArray2<'py, f64>,
        names: Vec<String>,
        pose: PyReadonlyArray2<'py, f64>,
        wrench: PyReadonlyArray2<'py, f64>,
        skips_no_machine: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let asked = Asked::new(&pose, &wrench)?;
        // A name that is none is an error of all sets, whatever becomes of single ones.
        for name in &names {
            self.own.parameter(name).map_err(raised)?;
        }
        let values = parameters.as_slice()?;
        let sets = Sets { names: &names, values, skips_no_machine };
        let found = wait_for(py, |_| Ok(()), |stop| deflections(&self.own, &sets, &asked, stop))?;
        array(py, found.map_err(raised)?, [parameters.shape()[0], asked.len(), 3])
    }
}

/// The method called `name`.
pub fn method_named(name: &str) -> PyResult<Method> {
    Method::named(name, 1.0).ok_or_else(|| {
        let names = Method::ALL.map(Method::label).join(", ");
        refused("method", &format!("expected one of {names}, got \"{name}\""))
    })
}

fn vector<'py>(py: Python<'py>, vector: &Vector3<f64>) -> PyResult<Bound<'py, PyAny>> {
    array(py, vector.iter().copied().collect(), [3])
}
