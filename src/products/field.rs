//! What a correction in a control leaves on machines and under forces as they may be, at check positions all over its field.
//!
//! Each draw is one machine and one factor of the force for the whole field, solved by the engine in full.

use std::ops::Range;

use nalgebra::Vector3;
use serde::Serialize;

use crate::{
    compensation::{Session, TaskPoint, simulate_drives},
    input::error::Result,
    machine::{ChainError, Configuration, Machine},
    process::uncertainty::{Draws, ToolOnWorkpiece, Uncertainty},
    simulation::{
        Failure, Machines, Source,
        spread::{DeflectionSpread, Draw, DrawnMachines, under},
        spread_along::share_larger,
    },
    work::{Event, Stage, Work},
};

/// What is found in a draw, or why there is no equilibrium.
type Found<T> = std::result::Result<T, Failure>;

/// A position under a load at which ways to correct the drives are checked; cases of one position stand together.
pub(super) struct FieldCase {
    /// Pose and load that the control is told.
    pub task: TaskPoint,
    /// The nominal machine there.
    pub at: Configuration,
    /// Position by which it is called, O, mm.
    pub position: Vector3<f64>,
    /// Drives without correction, then with each way to correct them, mm or rad.
    pub drives: Vec<Vec<f64>>,
}

/// Distances of the tool from where it is wanted in a field, where inputs are uncertain: without correction first, then with each way to correct.
#[derive(Debug, Clone, Serialize)]
pub struct FieldSpread {
    /// Of the largest distance anywhere in the field.
    pub ways: Vec<WaySpread>,
    /// At each check position, largest over its loads.
    pub points: Vec<FieldPoint>,
    /// Number of positions and loads.
    pub cases: usize,
}

/// Distribution of the largest distance in the field with a way to correct.
#[derive(Debug, Clone, Serialize)]
pub struct WaySpread {
    /// The distribution.
    pub largest: DeflectionSpread,
    /// Probability that it is smaller than without correction, by more than 0.5 %, 0 to 1.
    pub better: f64,
    /// Probability that it is larger than without correction, by more than 0.5 %, 0 to 1.
    pub worse: f64,
    /// Check position with the largest 95 % quantile, O, mm.
    pub worst_position_mm: [f64; 3],
}

/// Distributions at a check position.
#[derive(Debug, Clone, Serialize)]
pub struct FieldPoint {
    /// The position, O, mm.
    pub position_mm: [f64; 3],
    /// Distance from it without correction, then with each way to correct.
    pub ways: Vec<DeflectionSpread>,
}

/// Returns cases at each of `places`: under each of `loads`, and under the one of `tried` that leads the tool of `machines` farthest off without correction.
/// `case` makes them.
///
/// # Errors
/// Of `case`.
pub(super) fn cases<P, L>(
    machines: &Machines,
    places: &[P],
    [loads, tried]: [&[L]; 2],
    mut case: impl FnMut(&P, &L) -> Result<FieldCase>,
) -> Result<Vec<FieldCase>> {
    let (mut session, mut all) = (machines.session(Source::All), Vec::new());
    for place in places {
        let mut farthest: Option<(f64, FieldCase)> = None;
        for load in tried {
            let own = case(place, load)?;
            let found = error_at(&mut session, &machines.nominal, &own, 0, 1.0);
            let size = found.map_or(f64::INFINITY, |error| controlled_size(&machines.nominal, error));
            if farthest.as_ref().is_none_or(|(most, _)| size > *most) {
                farthest = Some((size, own));
            }
        }
        for load in loads {
            all.push(case(place, load)?);
        }
        all.extend(farthest.map(|(_, own)| own));
    }
    Ok(all)
}

/// Error of the compensated point in a case with the drives of a way and the load times `factor`, O axes, mm.
fn error_at(
    session: &mut Session,
    nominal: &Machine,
    case: &FieldCase,
    way: usize,
    factor: f64,
) -> Found<Vector3<f64>> {
    session.set_rigid(&case.at);
    let found = simulate_drives(session, &under(&case.task, factor), &case.drives[way]);
    match found.status.is_success() {
        true => Ok(found.position_error),
        false => Err(Failure::of(&found.status, nominal)),
    }
}

/// Size of an `error` (O axes, mm), as far as the drives of the `nominal` machine control it.
fn controlled_size(nominal: &Machine, mut error: Vector3<f64>) -> f64 {
    nominal.uncontrolled_axes().for_each(|axis| error[axis] = 0.0);
    error.norm()
}

impl FieldSpread {
    /// Solves the `cases` on the machines and under the forces that `uncertainty` makes of `machines` with their chain `errors`, in the first
    /// scramble of the draws of all questions. Cases of one position follow one another, and all have drives for the same methods. `tolerance_mm`: of which the
    /// probability is wanted. `None` where inputs are taken as exact, and in pages.
    ///
    /// # Errors
    /// No machines can be drawn, those of `cases`, and work that is stopped.
    pub(super) fn solve(
        uncertainty: Option<&Uncertainty>,
        machines: &Machines,
        errors: &[ChainError],
        cases: impl FnOnce() -> Result<Vec<FieldCase>>,
        tolerance_mm: Option<f64>,
        work: &Work,
    ) -> Result<Option<Self>> {
        let Some(drawn) = DrawnMachines::new(uncertainty, machines, errors)? else { return Ok(None) };
        let cases = cases()?;
        work.tell(Event::Stage(Stage { of: "draws", items: Draws::PER_SCRAMBLE }));
        let ways = cases.first().map_or(0, |case| case.drives.len());
        let found = drawn.in_first_scramble(|draw| {
            work.check()?;
            let sizes = sizes(&drawn, &machines.nominal, draw, &cases);
            work.tell(Event::Computed(1));
            Ok(Ok(sizes))
        })?;
        let largest = |way: usize, range: Range<usize>| -> Vec<Found<f64>> {
            let in_draw = |draw: &Found<Vec<Found<f64>>>| {
                let sizes = &draw.as_ref().map_err(Failure::clone)?[way * cases.len()..][range.clone()];
                sizes.iter().try_fold(0.0, |most: f64, size| Ok(most.max(*size.as_ref().map_err(Failure::clone)?)))
            };
            found.iter().map(in_draw).collect()
        };
        let (mut points, mut end) = (Vec::new(), 0);
        for group in cases.chunk_by(|a, b| a.position == b.position) {
            let range = end..end + group.len();
            end = range.end;
            let of = |way| DeflectionSpread::of_solved(&largest(way, range.clone()), tolerance_mm);
            points.push(FieldPoint { position_mm: group[0].position.into(), ways: (0..ways).map(of).collect() });
        }
        let sizes = |found: &[Found<f64>]| -> Vec<f64> {
            found.iter().map(|own| *own.as_ref().unwrap_or(&f64::INFINITY)).collect()
        };
        let plain = sizes(&largest(0, 0..cases.len()));
        let of = |way: usize| {
            let found = largest(way, 0..cases.len());
            let own = sizes(&found);
            let p95 = |point: &FieldPoint| point.ways[way].p95_mm.unwrap_or(f64::INFINITY);
            // The first of those that are alike.
            let worst = points.iter().rev().max_by(|a, b| p95(a).total_cmp(&p95(b)));
            WaySpread {
                largest: DeflectionSpread::of_solved(&found, tolerance_mm),
                better: share_larger(&plain, &own, 0.0),
                worse: share_larger(&own, &plain, 0.0),
                worst_position_mm: worst.map_or([0.0; 3], |point| point.position_mm),
            }
        };
        Ok(Some(Self { ways: (0..ways).map(of).collect(), points, cases: cases.len() }))
    }
}

/// Distances of the tool from where it is wanted in a draw, mm: of all `cases` without correction, then with each way.
fn sizes(
    drawn: &DrawnMachines,
    nominal: &Machine,
    (index, machines, factors): Draw<'_>,
    cases: &[FieldCase],
) -> Vec<Found<f64>> {
    let mut session = machines.session(Source::All);
    let mut size = |case: &FieldCase, way: usize| {
        let mut error = |factor: f64| error_at(&mut session, nominal, case, way, factor);
        let loaded = error(factors.all)?;
        let free = drawn.has_model_error().then(|| error(0.0)).transpose()?;
        // No workpiece is turned in a box.
        let axis = case.task.pose.rotation * nominal.tool_axes.column(2);
        let moved = drawn
            .uncertainty
            .setup_displacement(index, &ToolOnWorkpiece { axis, position_mm: Vector3::zeros(), pass: 0 });
        Ok(controlled_size(nominal, drawn.actual_displacement(index, free, loaded) + moved))
    };
    let ways = cases.first().map_or(0, |case| case.drives.len());
    (0..ways).flat_map(|way| cases.iter().map(move |case| (case, way))).map(|(case, way)| size(case, way)).collect()
}
