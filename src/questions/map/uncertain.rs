//! Spread of the deflection by all sources at grid points, where inputs are uncertain.

use nalgebra::Vector3;

use super::{SessionGroup, WorkspaceMapStudy};
use crate::{
    compensation::{Method, TaskPoint},
    input::error,
    machine::Configuration,
    process::uncertainty::Response,
    simulation::{
        Failure, Machines, Source,
        spread::{DeflectionSpread, Draw, DrawnMachines, WantedSpread, under},
    },
    statics::Batch,
    work::Work,
};

/// Fewest draws chosen at random that are solved in a map, as far as these many at each point suffice.
const FEWEST_AUDITS: usize = 1024;
const MOST_AUDITS_AT_POINT: usize = 32;

/// Adds the digits of a coordinate to those of the others, so that each point has a number of its own.
fn place_bits(others: u64, coordinate: &f64) -> u64 {
    others.rotate_left(21) ^ coordinate.to_bits()
}

/// Solver of the spread at neighbouring grid points side by side; that of one point depends on the others as far as they show how well engine and estimate
/// agree.
pub(super) struct SpreadSolver<'a> {
    study: &'a WorkspaceMapStudy,
    drawn: &'a DrawnMachines,
    nominal: SessionGroup,
    /// Sessions of the machines with each parameter alone at its ends.
    ends: Vec<[Option<SessionGroup>; 2]>,
}

impl<'a> SpreadSolver<'a> {
    /// Sessions for a group of grid points, of `nominal` machines and of those `drawn`.
    pub fn new(study: &'a WorkspaceMapStudy, nominal: &Machines, drawn: &'a DrawnMachines) -> Self {
        let group = |machines: &Machines| SessionGroup::new(machines, Source::All);
        let ends = drawn.ends.iter().map(|ends| ends.each_ref().map(|own| own.as_ref().map(group))).collect();
        Self { study, drawn, nominal: group(nominal), ends }
    }

    /// Distribution of the deflection at each of `configurations`, worst over the tool angle φ, whose displacements under each load are in `nominal`;
    /// `None` for the others. `Err` if `work` is stopped.
    pub fn solve<'d>(
        &mut self,
        configurations: &[&Configuration],
        nominal: impl Iterator<Item = Option<&'d [Vector3<f64>]>>,
        work: &Work,
    ) -> error::Result<Vec<Option<DeflectionSpread>>> {
        let Self { nominal: group, ends, .. } = self;
        let (study, drawn) = (self.study, self.drawn);
        let response = |nominal: Vector3<f64>| Response { nominal, ends: vec![[None; 2]; ends.len()] };
        let of_point = |loaded: &[Vector3<f64>]| {
            Ok(std::iter::once(Vector3::zeros()).chain(loaded.iter().copied()).map(response).collect())
        };
        let mut points: Vec<Option<Responses>> = nominal.map(|loaded| loaded.map(of_point)).collect();
        let mut sweep = Sweep { study, configurations, points: &mut points };
        sweep.solve(group, 1, "without cutting force", |response, found| response.nominal = found);
        for (own, ends) in ends.iter_mut().enumerate() {
            for (end, group) in ends.iter_mut().enumerate() {
                let Some(group) = group else { continue };
                let loads = 1 + study.scene.phis.len();
                sweep.solve(group, loads, &drawn.end_words(own, end), |response, found| {
                    response.ends[own][end] = Some(found);
                });
            }
        }
        let solve = |point: usize, draw: Draw<'_>| {
            work.check()?;
            Ok(largest_displacement((study, drawn), configurations[point], draw))
        };
        let (tolerance_mm, audits) = (study.scene.tolerance_mm, FEWEST_AUDITS.div_ceil(study.grid.len()));
        let audits = audits.min(MOST_AUDITS_AT_POINT);
        let seed = |point: usize| configurations[point].pose.translation.iter().fold(0, place_bits);
        let (checks, most_next) = (true, None);
        let wanted =
            WantedSpread { drawn, tolerance_mm, tool: &|_| 0, solve: &solve, checks, most_next, audits, seed: &seed };
        let responses = points.iter().map(|point| point.as_ref().map(|found| found.as_deref().ok()));
        let found = wanted.spreads(&responses.collect::<Vec<_>>())?;
        Ok(found.into_iter().map(|own| own.map(|(spread, _)| spread)).collect())
    }
}

/// Length of the longest displacement over φ at `at` in a draw, mm, undeflected to begin with.
fn largest_displacement(
    (study, drawn): (&WorkspaceMapStudy, &DrawnMachines),
    at: &Configuration,
    (index, machines, factor): Draw<'_>,
) -> Result<f64, Failure> {
    let mut group = SessionGroup::new(machines, Source::All);
    group.set_rigid(&[at; Batch::WIDTH]);
    let (mut largest, mut free) = (0.0f64, None);
    if drawn.has_model_error() {
        let task = under(&study.scene.task_point(at.pose, None), 0.0);
        let found = group.command(&study.scene.machine, None, Method::None, &[0], |_| task);
        for answer in found {
            free = Some(answer?.tool_displacement);
        }
    }
    for phis in study.scene.phis.chunks(Batch::WIDTH) {
        let tasks: Vec<TaskPoint> =
            phis.iter().map(|phi| under(&study.scene.task_point(at.pose, Some(*phi)), factor)).collect();
        let lanes: Vec<usize> = (0..tasks.len()).collect();
        for answer in group.command(&study.scene.machine, None, Method::None, &lanes, |lane| tasks[lane]) {
            largest = largest.max(drawn.real_displacement(index, free, answer?.tool_displacement).norm());
        }
    }
    Ok(largest)
}

/// Displacements at one point without load and then under each load, or why one of them is missing.
type Responses = Result<Vec<Response>, Failure>;

/// A group of points whose displacements are being solved.
struct Sweep<'a> {
    study: &'a WorkspaceMapStudy,
    configurations: &'a [&'a Configuration],
    /// `None` where even the nominal machine has no displacement.
    points: &'a mut [Option<Responses>],
}

impl Sweep<'_> {
    /// Solves the first `loads` of no load and the cutting force at each φ with the machine of `group`, and hands each displacement to `put`. A
    /// point at which one is missing fails; `words` say with which machine.
    fn solve(
        &mut self,
        group: &mut SessionGroup,
        loads: usize,
        words: &str,
        put: impl Fn(&mut Response, Vector3<f64>),
    ) {
        let Self { study, configurations, points } = self;
        group.set_rigid(configurations);
        for load in 0..loads {
            let phi = load.checked_sub(1).map(|load| study.scene.phis[load]);
            let lanes: Vec<usize> = (0..points.len()).filter(|lane| matches!(points[*lane], Some(Ok(_)))).collect();
            let task = |lane: usize| under(&study.scene.task_point(configurations[lane].pose, phi), 1.0);
            let found = group.command(&study.scene.machine, None, Method::None, &lanes, task);
            for (lane, found) in lanes.into_iter().zip(found) {
                match (found, &mut points[lane]) {
                    (Ok(answer), Some(Ok(responses))) => put(&mut responses[load], answer.tool_displacement),
                    (Err(Failure { status, reason }), point) => {
                        *point = Some(Err(Failure { status, reason: format!("{words}: {reason}") }));
                    }
                    (Ok(_), _) => {}
                }
            }
        }
    }
}
