//! What is asked: poses of P and wrenches there, one for all or one each.

use std::collections::HashMap;

use kinetostat::{
    Machine, Pose, Wrench,
    machine::{BatchKinematics, Configuration, Unreachable},
    nalgebra::{Matrix3, Vector3},
    statics::Batch,
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
    /// Its numbers, and zeros where a position has none.
    fn numbers(&self) -> [f64; 12] {
        let mut numbers = [0.0; 12];
        match self {
            Place::Position(position) => numbers[..3].copy_from_slice(position.as_slice()),
            Place::Pose(pose) => {
                numbers[..3].copy_from_slice(pose.translation.as_slice());
                numbers[3..].copy_from_slice(pose.rotation.as_slice());
            }
        }
        numbers
    }

    /// The pose of P that the nominal machine is commanded to.
    fn target(&self, machine: &Machine) -> Pose {
        match self {
            Place::Position(position) => machine.pose_at(*position),
            Place::Pose(pose) => *pose,
        }
    }

    /// Where the nominal machine stands when it is commanded there.
    ///
    /// # Errors
    /// It cannot be reached.
    fn command(&self, machine: &Machine) -> Result<Configuration, Unreachable> {
        self.check(machine, machine.inverse_kinematics(&self.target(machine))?)
    }

    /// `at`, if the machine stands there as it is asked to in the coordinates that the drives do not control.
    fn check(&self, machine: &Machine, at: Configuration) -> Result<Configuration, Unreachable> {
        match self {
            Place::Position(position) => machine.check_uncontrolled(*position, &at)?,
            Place::Pose(pose) => {
                machine.check_uncontrolled(pose.translation, &at)?;
                machine.check_orientation(&pose.rotation, &at)?;
            }
        }
        Ok(at)
    }
}

/// Where the nominal machine stands at each of `places`, with the bits that each has alone, as many at a time as the processor can.
pub fn commands_in_lanes(
    machine: &Machine,
    kinematics: &mut BatchKinematics,
    places: &[&Place],
) -> Vec<Result<Configuration, Unreachable>> {
    let wanted: Vec<_> = places.iter().map(|place| (&machine.home, place.target(machine))).collect();
    let found = kinematics.inverse_kinematics(&wanted).into_iter().zip(places);
    found.map(|(at, place)| at.map_or_else(|| place.command(machine), |at| place.check(machine, at))).collect()
}

/// The same on the threads of the present pool.
fn commands_of(machine: &Machine, places: &[&Place]) -> Vec<Result<Configuration, Unreachable>> {
    // One alone is not worth storage for lanes.
    if let [place] = places {
        return vec![place.command(machine)];
    }
    let begin = || BatchKinematics::new(machine);
    let groups = places.par_chunks(Batch::WIDTH).map_init(begin, |own, places| commands_in_lanes(machine, own, places));
    groups.flatten_iter().collect()
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
        let found = rows.par_chunks(Batch::WIDTH).map_init(
            || BatchKinematics::new(machine),
            |kinematics, rows| {
                let wanted: Vec<_> = rows.iter().map(|drives| (&machine.home, *drives)).collect();
                let found = kinematics.forward_kinematics(&wanted).into_iter().zip(rows);
                found.map(|(at, drives)| at.map_or_else(|| machine.forward_kinematics(drives), Ok)).collect::<Vec<_>>()
            },
        );
        let found: Vec<_> = found.flatten_iter().collect();
        Ok(Self { of_case: (0..found.len()).collect(), found })
    }

    /// Of rows of places, one each.
    pub fn of_places(machine: &Machine, asked: &Asked) -> Self {
        let found = commands_of(machine, &asked.places.iter().collect::<Vec<_>>());
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
        let (mut numbers, mut firsts) = (HashMap::new(), Vec::<&Place>::new());
        let mut of_case = Vec::with_capacity(self.places.len());
        for place in &self.places {
            let number = *numbers.entry(place.numbers().map(f64::to_bits)).or_insert(firsts.len());
            of_case.push(number);
            if number == firsts.len() {
                firsts.push(place);
            }
            if REPEATED * firsts.len() > self.len() && self.places.len() > 1 {
                return None;
            }
        }
        Some(Commands { found: commands_of(machine, &firsts), of_case })
    }

    /// The same cases with their loads times `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { places: self.places.clone(), loads: self.loads.iter().map(|load| load.scale(factor)).collect() }
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
