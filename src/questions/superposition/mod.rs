//! Superposition study: whether displacements by single sources of error may be added, and with which error.
//!
//! A machine with chain errors `E`, commanded to a location and loaded by the wrench `F`, moves by `u(F, E)`: from where
//! the nominal machine rests there, unloaded, to the loaded equilibrium of the actual one. Superposition solves for each
//! source alone and adds; it departs from the simultaneous model by
//!
//! `d(F, E) = u(F, 0) + u(0, E) − u(F, E)`.
//!
//! The superposition error vanishes where a source is absent, so its lowest term is the mixed one, `−F E ∂²u/∂F∂E`: it grows with
//! the first power of each source and with the second of both.
//!
//! The same is asked of the linear aggregation of chain errors, eqs. (14) and (15), in place of `u(0, E)`. That superposition error
//! has a part in `E²` as well: what aggregation leaves out of the chain errors alone.
//!
//! - [`GridPoint`]: superposition error over the workspace, and the largest load that keeps it below a tolerance
//! - [`LocationResult`]: superposition error, its [`growth`] with the sources, largest [`safe`] factors, [`ablation`]
//!
//! Where inputs are uncertain, the machine that bends, `u(F, 0)`, is that of a draw, and `E` is all that it differs in where its parts are.

pub mod ablation;
pub mod growth;
#[cfg(feature = "report")]
pub mod report;
mod resolve;
mod rig;
pub mod safe;
pub(crate) mod spec;
pub mod superposition_error;

use std::ops::Range;

use ablation::Ablation;
use growth::Growth;
use nalgebra::Vector3;
use rayon::prelude::*;
use safe::LargestFactor;
use serde::{Deserialize, Serialize};
use superposition_error::{Case, SuperpositionErrors};

use crate::simulation::{
    Failure, LoadCase, Machines,
    spread::{DeflectionSpread, DrawnMachines},
};
use crate::{
    input::error,
    process::uncertainty::Uncertainty,
    spatial::Grid,
    work::{Event, Work, compute_overlapped, if_this_shard},
};

/// A named location of P.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Location {
    /// Name of the location.
    pub name: String,
    /// Commanded position of P, mm.
    pub position: Vector3<f64>,
}

/// A checked superposition study.
#[derive(Debug, Clone)]
pub struct SuperpositionStudy {
    /// Machine, chain errors, cutting force and tool angles.
    pub load_case: LoadCase,
    /// Grid of positions of P on which the map is computed.
    pub grid: Grid,
    /// Locations studied in detail.
    pub locations: Vec<Location>,
    /// Superposition error of the tool tip from which superposition is out of tolerance, mm.
    pub tolerance: f64,
    /// Factors on the sources at which the growth of the superposition error is measured, ascending.
    pub scales: Vec<f64>,
    /// Largest factor tried in the search for the largest one within tolerance.
    pub largest_factor: f64,
    /// What is not known exactly; `None` where all inputs are taken as exact. Without what the model leaves out: it is a share of the displacement by
    /// the cutting force, and has no meaning for a difference between two sums of displacements.
    pub uncertainty: Option<Uncertainty>,
}

/// The sources that are multiplied by a factor: the load, the chain errors or both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scaling {
    /// The cutting force; the chain errors stay.
    Load,
    /// The chain errors; the cutting force stays.
    Errors,
    /// Both by the same factor.
    Both,
}

impl Scaling {
    /// All, in table order.
    pub const ALL: [Scaling; 3] = [Scaling::Load, Scaling::Errors, Scaling::Both];

    /// Returns the word for the scaled sources in tables.
    pub fn label(self) -> &'static str {
        match self {
            Scaling::Load => "load",
            Scaling::Errors => "errors",
            Scaling::Both => "both",
        }
    }

    /// Returns the factors on load and on chain errors when what this scales is multiplied by `factor`.
    pub fn load_and_error_factors(self, factor: f64) -> (f64, f64) {
        match self {
            Scaling::Load => (factor, 1.0),
            Scaling::Errors => (1.0, factor),
            Scaling::Both => (factor, factor),
        }
    }
}

/// Results at one grid point of the map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GridPoint {
    /// Commanded position of P, mm.
    pub position_mm: [f64; 3],
    /// Superposition errors, worst over φ.
    pub superposition_errors: Result<SuperpositionErrors, Failure>,
    /// Largest factor on the load that keeps the superposition error of the tool tip within the tolerance.
    pub largest_load: LargestFactor,
}

/// Detailed results at one location.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LocationResult {
    /// The location.
    pub location: Location,
    /// Superposition errors, worst over φ.
    pub superposition_errors: Result<SuperpositionErrors, Failure>,
    /// Largest factors that keep the superposition error of the tool tip within the tolerance, in the order of [`Scaling::ALL`].
    pub largest: [LargestFactor; 3],
    /// How the superposition error grows, in the order of [`Scaling::ALL`].
    pub growth: [Growth; 3],
    /// Parts of the superposition error by cause, at each φ.
    pub ablation: Result<Vec<Ablation>, Failure>,
    /// Distribution of the superposition error of the tool tip, worst over φ; `None` where inputs are taken as exact, or the nominal one is not solved.
    pub spread: Option<DeflectionSpread>,
}

/// Results of a superposition study.
#[derive(Debug, Clone, Serialize)]
pub struct Superposition {
    /// The study.
    #[serde(skip)]
    pub study: SuperpositionStudy,
    /// Points in grid order.
    pub points: Vec<GridPoint>,
    /// Locations in the order of the study.
    pub locations: Vec<LocationResult>,
}

/// Grid points in one piece of the work, and in one part of the results.
const PIECE: usize = 16;
const PART: usize = 64 * PIECE;

/// Computes map and locations, in parallel on the current rayon pool; the result does not depend on the number of threads. `Err` if `work`
/// was stopped or cannot be kept.
pub fn run(study: &SuperpositionStudy, work: &Work) -> error::Result<Superposition> {
    let mut points = Vec::with_capacity(study.grid.len());
    run_map(study, work, |part| {
        points.extend(part);
        Ok(())
    })?;
    Ok(Superposition { points, locations: run_locations(study, work)?, study: study.clone() })
}

/// Computes the map and gives its points to `take` part by part, in grid order, so that memory does not grow with the grid; the next part
/// is computed meanwhile. `Err` if `work` was stopped or cannot be kept, and that of `take`.
pub fn run_map(
    study: &SuperpositionStudy,
    work: &Work,
    take: impl FnMut(Vec<GridPoint>) -> error::Result<()> + Send,
) -> error::Result<()> {
    let machines = study.load_case.machines()?;
    let (map, total) = (work.part("map"), study.grid.len());
    let compute = |start: usize| map_part(study, &machines, start..total.min(start + PART), &map).map(Some);
    compute_overlapped((0..total).step_by(PART), compute, take)?;
    map.barrier()
}

/// Returns the number of pieces of work in the map.
pub(super) fn map_pieces(study: &SuperpositionStudy) -> usize {
    study.grid.len().div_ceil(PIECE)
}

/// Computes the grid points with these indices, in grid order, on the current rayon pool; indices beyond the grid give none. `Err` if
/// `work` was stopped or cannot be kept.
pub fn run_range(study: &SuperpositionStudy, indices: Range<usize>, work: &Work) -> error::Result<Vec<GridPoint>> {
    let indices = indices.start.min(study.grid.len())..indices.end.min(study.grid.len());
    let points = map_part(study, &study.load_case.machines()?, indices, work)?;
    work.barrier()?;
    Ok(points)
}

/// Computes the grid points with these indices, in grid order, in pieces of `work`, without those that another shard computes. `Err` if `work` was stopped or
/// a piece cannot be kept or read.
fn map_part(
    study: &SuperpositionStudy,
    machines: &Machines,
    indices: Range<usize>,
    work: &Work,
) -> error::Result<Vec<GridPoint>> {
    let pieces = indices.clone().into_par_iter().step_by(PIECE).filter_map(|start| {
        let work = work.shard(start / PIECE);
        let compute = || {
            let solve = |index| {
                work.check()?;
                let point = map_point(study, machines, study.grid.position(index));
                if point.superposition_errors.is_err() {
                    work.tell(Event::Unsolved(1));
                }
                work.tell(Event::Computed(1));
                Ok(point)
            };
            (start..indices.end.min(start + PIECE)).into_par_iter().map(solve).collect()
        };
        if_this_shard(work.piece(&start, Vec::len, compute)).transpose()
    });
    Ok(pieces.collect::<error::Result<Vec<Vec<GridPoint>>>>()?.into_iter().flatten().collect())
}

/// Computes the locations, in parallel on the current rayon pool. `Err` if `work` was stopped or cannot be kept.
pub fn run_locations(study: &SuperpositionStudy, work: &Work) -> error::Result<Vec<LocationResult>> {
    let machines = study.load_case.machines()?;
    let drawn = DrawnMachines::new(study.uncertainty.as_ref(), &machines, &study.load_case.errors)?;
    let named = work.part("locations").numbered_after(map_pieces(study));
    let locations = study.locations.par_iter().enumerate().filter_map(|(index, location)| {
        let compute = || {
            let mut result = location_result(study, &machines, location);
            if let Some(drawn) = drawn.as_ref().filter(|_| result.superposition_errors.is_ok()) {
                let found = drawn.in_first_scramble(|(_, machines, factors)| {
                    work.check()?;
                    let case = Case::new(study, machines, location.position);
                    Ok(case.and_then(|case| case.superposed_tool_mm(machines, factors.all)))
                })?;
                result.spread = Some(DeflectionSpread::of_solved(&found, Some(study.tolerance)));
            }
            named.tell(Event::Computed(1));
            Ok(result)
        };
        if_this_shard(named.shard(index).piece(&index, |_| 1, compute)).transpose()
    });
    let locations = locations.collect::<error::Result<_>>()?;
    named.barrier()?;
    Ok(locations)
}

/// Returns the superposition errors and the largest load with P at `position`, O, mm; failures are in the result.
fn map_point(study: &SuperpositionStudy, machines: &Machines, position: Vector3<f64>) -> GridPoint {
    let position_mm = position.into();
    let case = match Case::new(study, machines, position) {
        Ok(case) => case,
        Err(failure) => {
            let largest_load = LargestFactor::Unsolved(failure.clone());
            return GridPoint { position_mm, superposition_errors: Err(failure), largest_load };
        }
    };
    let superposition_errors = case.superposition_errors(machines, 1.0);
    let at_one = superposition_errors.as_ref().map(|errors| errors.superposed_tool_mm()).map_err(Clone::clone);
    let largest_load = safe::largest_factor(study, at_one, |factor| case.superposed_tool_mm(machines, factor));
    GridPoint { position_mm, superposition_errors, largest_load }
}

/// Returns the results at a location: superposition errors, largest factors, growth and causes; failures are in the result.
fn location_result(study: &SuperpositionStudy, machines: &Machines, location: &Location) -> LocationResult {
    match Case::new(study, machines, location.position) {
        Ok(case) => LocationResult {
            location: location.clone(),
            superposition_errors: case.superposition_errors(machines, 1.0),
            largest: Scaling::ALL.map(|scaled| {
                let superposition_error = |factor: f64| {
                    let (load, errors) = scaled.load_and_error_factors(factor);
                    case.superposed_tool_mm(&case.machines_with_errors(errors), load)
                };
                safe::largest_factor(study, superposition_error(1.0), superposition_error)
            }),
            growth: Scaling::ALL.map(|scaled| growth::measure_growth(&case, scaled)),
            ablation: ablation::ablate(&case),
            spread: None,
        },
        Err(failure) => LocationResult {
            location: location.clone(),
            superposition_errors: Err(failure.clone()),
            largest: Scaling::ALL.map(|_| LargestFactor::Unsolved(failure.clone())),
            growth: Scaling::ALL.map(|_| Growth::unsolved(study, &failure)),
            ablation: Err(failure),
            spread: None,
        },
    }
}
