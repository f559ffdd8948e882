//! What is asked: poses of P and wrenches there, one for all or one each.

use std::collections::HashMap;

use kinetostat::{
    Machine, Pose, Wrench,
    machine::{Configuration, Unreachable},
    nalgebra::{Matrix3, Vector3},
};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::error::refused;

/// Entries of a rotation farther than this from orthonormal are no rotation.
const ORTHONORMAL: f64 = 1e-9;
/// No machine is larger and no load greater: what is, are numbers gone wrong.
const LARGEST: f64 = 1e15;

/// Where the nominal machine is commanded to.
#[derive(Debug, Clone, Copy)]
pub enum Place {
    /// A position of P in O, mm, the platform oriented as at home.
    Position(Vector3<f64>),
    /// A pose of P in O.
    Pose(Pose),
}

impl Place {
    /// Bits of its numbers, those that are not given as zero.
    fn bits(&self) -> [u64; 13] {
        let numbers: Vec<f64> = match self {
            Place::Position(position) => position.iter().copied().collect(),
            Place::Pose(pose) => {
                std::iter::once(1.0).chain(pose.translation.iter().chain(pose.rotation.iter()).copied()).collect()
            }
        };
        std::array::from_fn(|i| numbers.get(i).map_or(0, |number| number.to_bits()))
    }

    /// Where the nominal machine stands when it is commanded there.
    ///
    /// # Errors
    /// It cannot be reached.
    pub fn command(&self, machine: &Machine) -> Result<Configuration, Unreachable> {
        match self {
            Place::Position(position) => machine.command(*position),
            Place::Pose(pose) => {
                let at = machine.inverse_kinematics(pose)?;
                machine.check_uncontrolled(pose.translation, &at)?;
                machine.check_orientation(&pose.rotation, &at)?;
                Ok(at)
            }
        }
    }
}

/// Places are computed once where each is asked for so many times.
const REPEATED: usize = 2;

/// Where the nominal machine stands at the places of all cases.
pub struct Commands {
    found: Vec<Result<Configuration, Unreachable>>,
    /// Number of what was found for each case; one for all.
    of_case: Vec<usize>,
}

impl Commands {
    /// Where the nominal machine stands with its drives at each row of `drives`, mm or rad.
    pub fn of_drives(machine: &Machine, drives: &PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let rows: Vec<&[f64]> = rows(drives, "drives")?.collect();
        let found: Vec<_> = rows.par_iter().map(|drives| machine.forward_kinematics(drives)).collect();
        Ok(Self { of_case: (0..found.len()).collect(), found })
    }

    /// Of rows of places, one each.
    pub fn of_places(machine: &Machine, asked: &Asked) -> Self {
        let found: Vec<_> = asked.places.par_iter().map(|place| place.command(machine)).collect();
        Self { of_case: (0..found.len()).collect(), found }
    }

    /// What was found, in order.
    pub fn found(&self) -> &[Result<Configuration, Unreachable>] {
        &self.found
    }

    /// Where it stands in a case.
    pub fn of(&self, case: usize) -> &Result<Configuration, Unreachable> {
        &self.found[if self.of_case.len() == 1 { 0 } else { self.of_case[case] }]
    }
}

/// Cases in a row: a place and a load each, or one of them for all.
#[derive(Debug, Clone)]
pub struct Asked {
    places: Vec<Place>,
    loads: Vec<Wrench>,
}

impl Asked {
    /// Of `pose`, `[k, 3]` positions or `[k, 16]` homogeneous matrices, and `wrench`, `[k, 6]`; each with one row or one for each case.
    ///
    /// # Errors
    /// Numbers that are no poses or wrenches; names the row.
    pub fn new(pose: &PyReadonlyArray2<'_, f64>, wrench: &PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let columns = pose.shape()[1];
        let places = rows(pose, "pose")?.enumerate().map(|(row, numbers)| match columns {
            3 => Ok(Place::Position(Vector3::from_row_slice(numbers))),
            _ => homogeneous(row, numbers).map(Place::Pose),
        });
        let places = places.collect::<PyResult<Vec<_>>>()?;
        Ok(Self { places, loads: loads_of(wrench)? })
    }

    /// Of so many cases whose places are given otherwise, and `wrench` as in [`Asked::new`].
    pub fn of_loads(cases: usize, wrench: &PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        Ok(Self { places: vec![Place::Position(Vector3::zeros()); cases], loads: loads_of(wrench)? })
    }

    /// Number of cases.
    pub fn len(&self) -> usize {
        match (self.places.len(), self.loads.len()) {
            (1, loads) => loads,
            (places, _) => places,
        }
    }

    /// The place of a case.
    pub fn place(&self, case: usize) -> &Place {
        &self.places[if self.places.len() == 1 { 0 } else { case }]
    }

    /// Where the nominal machine stands at the places of all cases, each computed once, if most of them are asked for several times.
    pub fn commands(&self, machine: &Machine) -> Option<Commands> {
        let mut numbers = HashMap::new();
        let mut firsts = Vec::new();
        let of_case: Vec<usize> = (0..if self.places.len() == 1 { 1 } else { self.len() })
            .map(|case| {
                *numbers.entry(self.place(case).bits()).or_insert_with(|| {
                    firsts.push(case);
                    firsts.len() - 1
                })
            })
            .collect();
        (REPEATED * firsts.len() <= self.len() || self.places.len() == 1).then(|| Commands {
            found: firsts.par_iter().map(|case| self.place(*case).command(machine)).collect(),
            of_case,
        })
    }

    /// The load of a case.
    pub fn load(&self, case: usize) -> Wrench {
        self.loads[if self.loads.len() == 1 { 0 } else { case }]
    }
}

fn loads_of(wrench: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Wrench>> {
    Ok(rows(wrench, "wrench")?.map(|numbers| Wrench::new(std::array::from_fn(|i| numbers[i]))).collect())
}

/// The rows of an array of finite numbers.
fn rows<'a>(array: &'a PyReadonlyArray2<'_, f64>, name: &str) -> PyResult<std::slice::ChunksExact<'a, f64>> {
    let columns = array.shape()[1].max(1);
    let numbers = array.as_slice()?;
    if let Some(at) = numbers.iter().position(|number| number.is_nan() || number.abs() > LARGEST) {
        let problem = format!("expected numbers of at most {LARGEST:e}, got {}", numbers[at]);
        return Err(refused(&format!("{name}, row {}", at / columns), &problem));
    }
    Ok(numbers.chunks_exact(columns))
}

/// The pose that a homogeneous matrix is, written row after row.
fn homogeneous(row: usize, numbers: &[f64]) -> PyResult<Pose> {
    let rotation = Matrix3::from_fn(|i, j| numbers[4 * i + j]);
    let skewed = (rotation.transpose() * rotation - Matrix3::identity()).amax();
    let is_pose = skewed <= ORTHONORMAL && rotation.determinant() > 0.0 && numbers[12..] == [0.0, 0.0, 0.0, 1.0];
    if !is_pose {
        let problem =
            "expected a homogeneous matrix: a rotation, a position in mm in the last column, and 0 0 0 1 below";
        return Err(refused(&format!("pose, row {row}"), problem));
    }
    Ok(Pose { rotation, translation: Vector3::from_fn(|i, _| numbers[4 * i + 3]) })
}

/// `pose` as a homogeneous matrix, row after row.
pub fn write_pose(pose: &Pose, into: &mut [f64]) {
    for i in 0..3 {
        for j in 0..3 {
            into[4 * i + j] = pose.rotation[(i, j)];
        }
        into[4 * i + 3] = pose.translation[i];
    }
    into[12..16].copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
}
