//! What is not known exactly of a machine, in Python.

use std::{
    path::PathBuf,
    sync::atomic::{AtomicBool, Ordering},
};

use kinetostat::{
    Error, Result,
    machine::Unit,
    process::uncertainty::{self, Distribution},
    simulation::Machines,
};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::{
    arrays::array,
    error::{raised, refused},
    machine::Machine,
    poses::Asked,
    settle::{Commanded, settle},
    waiting::wait_for,
};

/// Distributions of numbers of a machine and of the force on its tool: see `kinetostat.Uncertainty`.
#[pyclass(frozen, module = "kinetostat._kinetostat")]
#[derive(Debug)]
pub struct Uncertainty {
    own: uncertainty::Uncertainty,
    /// The machines that command and answer with nominal numbers.
    machines: Machines,
    /// Names of all numbers that vary, those that vary together one after another.
    names: Vec<String>,
}

/// Number, nominal value, unit, 95 % interval, distribution and its two numbers, and index of what varies by itself.
type Input = (String, f64, &'static str, (f64, f64), &'static str, (f64, f64), usize);

/// What says how a distribution lies about its median: standard deviations below and above, or least and largest difference.
fn numbers_of(spread: &Distribution) -> (f64, f64) {
    match *spread {
        Distribution::Logarithm { below, above } | Distribution::Difference { below, above } => (below, above),
        Distribution::Uniform { least, largest } => (least, largest),
    }
}

#[pymethods]
impl Uncertainty {
    /// The table `[uncertainty]` that is written in `toml`, whose files are in `folder`; `origin` names it in messages.
    #[staticmethod]
    fn from_toml(toml: &str, origin: &str, folder: PathBuf, machine: &Machine) -> PyResult<Self> {
        if !machine.own().parameter_errors().is_empty() {
            return Err(refused(
                "machine",
                "has errors of its chains among its parameters: expected them in chain_error",
            ));
        }
        let own = uncertainty::Uncertainty::from_toml(toml, origin, folder, machine.own()).map_err(raised)?;
        if let Some(setup) = own.setups().next() {
            return Err(refused(
                "table",
                &format!("{setup} is no deflection of the machine: expected it in a path or a program"),
            ));
        }
        let names = own.parameters.iter().flat_map(|parameter| &parameter.values).map(|(name, _)| name.clone());
        Ok(Self { names: names.collect(), machines: machine.machines().clone(), own })
    }

    /// All numbers that vary.
    fn inputs(&self) -> Vec<Input> {
        let of = |(group, own): (usize, &uncertainty::UncertainParameter)| {
            let (unit, spread): (Unit, Distribution) = (own.unit, own.spread);
            let input = |(name, nominal): &(String, f64)| {
                let [low, high] = spread.interval_95(*nominal);
                (name.clone(), *nominal, unit.in_files(), (low, high), spread.text(), numbers_of(&spread), group)
            };
            own.values.iter().map(input).collect::<Vec<_>>()
        };
        self.own.parameters.iter().enumerate().flat_map(of).collect()
    }

    /// 95 % interval of the factor of the force; None where that is exact.
    fn force(&self) -> Option<(f64, f64)> {
        self.own.force_factor_95().map(<(f64, f64)>::from)
    }

    /// Share by which the force of a worn tool may be above that of a sharp one; None where tools stay sharp.
    fn wear(&self) -> Option<f64> {
        self.own.wear_force_increase()
    }

    /// Values `[n, k]` and factors of the force `[n]` for independent standard normal numbers `[n, g + 1]`, those of the force last, or `[n, g + 2]`, those of
    /// tool wear behind them, if tools wear.
    fn values<'py>(
        &self,
        py: Python<'py>,
        normal: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        if !self.own.draws.correlated.is_empty() {
            return Err(refused("sample", "has correlations of an identification: expected those of studies, draws()"));
        }
        let of_force = self.own.parameters.len();
        let columns = of_force + if self.own.force.wear.is_some() { 2 } else { 1 };
        let rows = normal.as_slice()?.chunks_exact(columns);
        let of = |row: &[f64]| {
            let [sharp, wear] = self.own.force.factors([row[of_force], row[columns - 1]]);
            (self.row(row), sharp * wear)
        };
        let (values, force): (Vec<Vec<f64>>, Vec<f64>) = rows.map(of).unzip();
        let count = force.len();
        Ok((array(py, values.concat(), [count, self.names.len()])?, array(py, force, [count])?))
    }

    /// Values `[n, k]` and factors of the force `[n]` of the draws that studies make.
    fn draws<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let draws = &self.own.draws;
        let normal = |draw: usize| draws.normal.iter().map(|own| own[draw]).collect::<Vec<f64>>();
        let force = draws.force_of(0).to_vec();
        let count = force.len();
        let values: Vec<f64> = (0..count).flat_map(|draw| self.row(&normal(draw))).collect();
        Ok((array(py, values, [count, self.names.len()])?, array(py, force, [count])?))
    }

    /// Displacement of the tool tip, `[sets, cases, 3]`, where the force is times the factor of each set: see `kinetostat.Uncertainty.deflection`.
    fn deflections<'py>(
        &self,
        py: Python<'py>,
        values: PyReadonlyArray2<'py, f64>,
        force: PyReadonlyArray1<'py, f64>,
        pose: PyReadonlyArray2<'py, f64>,
        wrench: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let asked = Asked::new(&pose, &wrench)?;
        let (values, force) = (values.as_slice()?, force.as_slice()?);
        let found = wait_for(py, |_| Ok(()), |stop| self.solve(values, force, &asked, stop))?;
        array(py, found.map_err(raised)?, [force.len(), asked.len(), 3])
    }
}

impl Uncertainty {
    /// The displacement of the tool tip at all cases on the machine of each row of `values` under its factor of the force, NaN where there is none.
    fn solve(&self, values: &[f64], force: &[f64], asked: &Asked, stop: &AtomicBool) -> Result<Vec<f64>> {
        let (columns, width) = (self.names.len(), 3 * asked.len());
        let mut found = vec![f64::NAN; force.len() * width];
        let rows = found.par_chunks_mut(width.max(1)).zip(force);
        rows.enumerate().try_for_each(|(row, (found, factor))| {
            if stop.load(Ordering::Relaxed) {
                return Err(Error::Stopped);
            }
            let own = &values[row * columns..(row + 1) * columns];
            // Numbers that make no machine have no displacement.
            let Ok(machines) = self.machines.drawn(&self.own.machine, &self.own.values_of_row(own), &[]) else {
                return Ok(());
            };
            let commanded = Commanded::uncompensated(false, false);
            found.copy_from_slice(&settle(&machines, &asked.scaled(*factor), None, commanded, stop)?.deflection);
            Ok(())
        })?;
        Ok(found)
    }

    /// The values for the standard normal numbers of what varies by itself.
    fn row(&self, normal: &[f64]) -> Vec<f64> {
        let parameters = self.own.parameters.iter().zip(normal);
        parameters.flat_map(|(own, z)| own.at(*z).map(|(_, value)| value).collect::<Vec<f64>>()).collect()
    }
}
