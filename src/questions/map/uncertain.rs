//! Spread of the deflection by all sources at grid points, where inputs are uncertain.

use nalgebra::Vector3;

use super::{SessionGroup, WorkspaceMapStudy};
use crate::{
    compensation::{Method, TaskPoint},
    input::error,
    machine::Configuration,
    process::uncertainty::{Cut, Harmonics, Response},
    simulation::{
        Failure, Machines, Source,
        spread::{DeflectionSpread, Draw, DrawnMachines, WantedSpread, under},
    },
    spatial::Wrench,
    statics::Batch,
    work::Work,
};

/// Fewest draws chosen at random that are solved in a map, as far as these many at each point suffice.
const FEWEST_AUDITS: usize = 1024;
const MAX_AUDITS_AT_POINT: usize = 32;

/// Adds the digits of a coordinate to those of the others, so that each point has a number of its own.
fn place_bits(others: u64, coordinate: &f64) -> u64 {
    others.rotate_left(21) ^ coordinate.to_bits()
}

/// Tool angles, a sixth of a revolution apart, at which displacements of machines of ends are solved: what the end changes is nearly linear in the load, whose
/// components are sines and cosines of φ, so that the first two harmonics give it at the others.
struct Nodes {
    /// Angles from one node to the next.
    every: usize,
    /// Waves at each angle.
    waves: Vec<[f64; Harmonics::COUNT]>,
}

impl Nodes {
    /// Largest part of the third harmonic that nodes show, of which they see the cosine alone: what is left unseen the checks by all angles see, over the displacement, with which the others are taken to follow the first two.
    const LARGEST_REST: f64 = 1e-4;

    /// Makes those of `study`; `None` where there are hardly more angles, or loads are not of these harmonics.
    fn of(study: &WorkspaceMapStudy) -> Option<Self> {
        let phis = &study.load_case.phis;
        let every = phis.len() / Harmonics::NODES;
        if every < 2 || every * Harmonics::NODES != phis.len() {
            return None;
        }
        let waves: Vec<_> = (0..phis.len()).map(|own| Harmonics::waves(own as f64 / phis.len() as f64)).collect();
        let pose = study.load_case.machine.home.pose;
        let loads: Vec<Wrench> = phis.iter().map(|phi| study.load_case.task_point(pose, Some(*phi)).load).collect();
        let follows = |part: fn(&Wrench) -> Vector3<f64>| {
            let harmonics = Harmonics::through(&std::array::from_fn(|node| part(&loads[node * every])));
            let is_near = |(load, waves): (&Wrench, _)| {
                (harmonics.at(waves) - part(load)).norm() <= 1e-9 * (1.0 + part(load).norm())
            };
            loads.iter().zip(&waves).all(is_near)
        };
        (follows(|load| load.force) && follows(|load| load.moment)).then_some(Self { every, waves })
    }

    /// Fills in what the end `end` of the parameter `own` does at the other angles; `false` where the nodes show more than the first two harmonics.
    fn fill(&self, responses: &mut [Response], own: usize, end: usize) -> bool {
        // Behind that without load.
        let loaded = &mut responses[1..];
        let mut changes = [Vector3::zeros(); Harmonics::NODES];
        for (change, response) in changes.iter_mut().zip(loaded.iter().step_by(self.every)) {
            let Some(found) = response.ends[own][end] else { return true };
            *change = found - response.nominal;
        }
        let rest = changes.iter().rev().fold(Vector3::zeros(), |sum, change| change - sum).norm();
        let largest = loaded.iter().fold(0.0, |most: f64, response| most.max(response.nominal.norm()));
        if rest > Harmonics::NODES as f64 * Self::LARGEST_REST * largest {
            return false;
        }
        let harmonics = Harmonics::through(&changes);
        for (response, waves) in loaded.iter_mut().zip(&self.waves) {
            response.ends[own][end] = Some(response.nominal + harmonics.at(waves));
        }
        true
    }
}

/// Solver of the spread at neighbouring grid points side by side; that of one point depends on the others as far as they show how well engine and estimate
/// agree.
pub(super) struct SpreadSolver<'a> {
    study: &'a WorkspaceMapStudy,
    drawn: &'a DrawnMachines,
    nominal: SessionGroup,
    /// Sessions of the machines with each parameter alone at its ends.
    ends: Vec<[Option<SessionGroup>; 2]>,
    nodes: Option<Nodes>,
}

impl<'a> SpreadSolver<'a> {
    /// Sessions for a group of grid points, of `nominal` machines and of those `drawn`.
    pub fn new(study: &'a WorkspaceMapStudy, nominal: &Machines, drawn: &'a DrawnMachines) -> Self {
        let group = |machines: &Machines| SessionGroup::new(machines, Source::All);
        let ends = drawn.ends.iter().map(|ends| ends.each_ref().map(|own| own.as_ref().map(group))).collect();
        Self { study, drawn, nominal: group(nominal), ends, nodes: Nodes::of(study) }
    }

    /// Distribution of the deflection at each of `configurations`, worst over the tool angle φ, whose displacements under each load are in `nominal`;
    /// `None` for the others. `Err` if `work` is stopped.
    pub fn solve<'d>(
        &mut self,
        configurations: &[&Configuration],
        nominal: impl Iterator<Item = Option<&'d [Vector3<f64>]>>,
        work: &Work,
    ) -> error::Result<Vec<Option<DeflectionSpread>>> {
        let Self { nominal: group, ends, nodes, .. } = self;
        let (study, drawn) = (self.study, self.drawn);
        let response = |nominal: Vector3<f64>| Response { nominal, ends: vec![[None; 2]; ends.len()] };
        let of_point = |loaded: &[Vector3<f64>]| {
            Ok(std::iter::once(Vector3::zeros()).chain(loaded.iter().copied()).map(response).collect())
        };
        let mut points: Vec<Option<Responses>> = nominal.map(|loaded| loaded.map(of_point)).collect();
        let mut sweep = Sweep { study, configurations, points: &mut points };
        let all = vec![true; configurations.len()];
        group.set_rigid(configurations);
        sweep.solve(group, &[0], &all, "without cutting force", |response, found| response.nominal = found);
        let is_node = |load: &usize| {
            nodes.as_ref().is_none_or(|nodes| load.checked_sub(1).is_none_or(|angle| angle.is_multiple_of(nodes.every)))
        };
        let (at_nodes, others): (Vec<usize>, Vec<usize>) = (0..=study.load_case.phis.len()).partition(is_node);
        for (own, ends) in ends.iter_mut().enumerate() {
            for (end, group) in ends.iter_mut().enumerate() {
                let Some(group) = group else { continue };
                let (text, put) = (drawn.uncertainty.end_text(own, end), |response: &mut Response, found| {
                    response.ends[own][end] = Some(found);
                });
                group.set_rigid(configurations);
                sweep.solve(group, &at_nodes, &all, &text, put);
                let Some(nodes) = &nodes else { continue };
                let is_rough = |point: &mut Option<Responses>| match point {
                    Some(Ok(responses)) => !nodes.fill(responses, own, end),
                    _ => false,
                };
                let rough: Vec<bool> = sweep.points.iter_mut().map(is_rough).collect();
                if rough.contains(&true) {
                    sweep.solve(group, &others, &rough, &text, put);
                }
            }
        }
        let solve = |point: usize, draw: Draw<'_>| {
            work.check()?;
            Ok(largest_displacement(study, drawn, configurations[point], draw))
        };
        let (tolerance_mm, audits) = (study.load_case.tolerance_mm, FEWEST_AUDITS.div_ceil(study.grid.len()));
        let audits = audits.min(MAX_AUDITS_AT_POINT);
        let seed = |point: usize| configurations[point].pose.translation.iter().fold(0, place_bits);
        let (checks, most_next) = (true, None);
        let wanted = WantedSpread {
            drawn,
            tolerance_mm,
            cut: &|_| Cut::default(),
            solve: &solve,
            checks,
            most_next,
            audits,
            seed: &seed,
        };
        let responses = points.iter().map(|point| point.as_ref().map(|found| found.as_deref().ok()));
        let found = wanted.spreads(&responses.collect::<Vec<_>>())?;
        Ok(found.into_iter().map(|own| own.map(|(spread, _)| spread)).collect())
    }
}

/// Length of the longest displacement over φ at `at` in a draw, mm, undeflected to begin with.
fn largest_displacement(
    study: &WorkspaceMapStudy,
    drawn: &DrawnMachines,
    at: &Configuration,
    (index, machines, factors): Draw<'_>,
) -> Result<f64, Failure> {
    let mut group = SessionGroup::new(machines, Source::All);
    group.set_rigid(&[at; Batch::WIDTH]);
    let (mut largest, mut free) = (0.0f64, None);
    if drawn.has_model_error() {
        let task = under(&study.load_case.task_point(at.pose, None), 0.0);
        let found = group.command(&study.load_case.machine, None, Method::None, &[0], |_| task);
        for answer in found {
            free = Some(answer?.tool_displacement);
        }
    }
    for phis in study.load_case.phis.chunks(Batch::WIDTH) {
        let tasks: Vec<TaskPoint> =
            phis.iter().map(|phi| under(&study.load_case.task_point(at.pose, Some(*phi)), factors.all)).collect();
        let lanes: Vec<usize> = (0..tasks.len()).collect();
        for answer in group.command(&study.load_case.machine, None, Method::None, &lanes, |lane| tasks[lane]) {
            largest = largest.max(drawn.actual_displacement(index, free, answer?.tool_displacement).norm());
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
    /// Solves these `loads`, by their indices in no load and the cutting force at each φ, at the points `wanted` with the machine of `group`, and hands each
    /// displacement to `put`. A point at which one is missing fails; `words` say with which machine.
    fn solve(
        &mut self,
        group: &mut SessionGroup,
        loads: &[usize],
        wanted: &[bool],
        text: &str,
        put: impl Fn(&mut Response, Vector3<f64>),
    ) {
        let Self { study, configurations, points } = self;
        for &load in loads {
            let phi = load.checked_sub(1).map(|load| study.load_case.phis[load]);
            let is_wanted = |lane: &usize| wanted[*lane] && matches!(points[*lane], Some(Ok(_)));
            let lanes: Vec<usize> = (0..points.len()).filter(is_wanted).collect();
            let task = |lane: usize| under(&study.load_case.task_point(configurations[lane].pose, phi), 1.0);
            let found = group.command(&study.load_case.machine, None, Method::None, &lanes, task);
            for (lane, found) in lanes.into_iter().zip(found) {
                match (found, &mut points[lane]) {
                    (Ok(answer), Some(Ok(responses))) => put(&mut responses[load], answer.tool_displacement),
                    (Err(failure), point) => *point = Some(Err(failure.on(text))),
                    (Ok(_), _) => {}
                }
            }
        }
    }
}
