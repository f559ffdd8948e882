//! The workspace map: on a grid over the workspace, how far the tool moves under the cutting force, with and without
//! chain errors, what must be commanded instead, and how far superposition departs from the simultaneous model.

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::Source;
use crate::{
    compensation::{Compensation, Demand, Method, Session, Settings, Target, compensate},
    machine::{ChainError, Configuration, Machine, Unreachable},
    process::MillingForce,
    spatial::Wrench,
    statics::{self, Outcome, State, tool_compliance},
};

/// A regular grid over a box of positions of P, both ends included.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Coordinates along x, y and z, mm, ascending.
    pub axes: [Vec<f64>; 3],
}

impl Grid {
    /// `counts` points per axis; a single point lies in the middle.
    pub fn new(min: Vector3<f64>, max: Vector3<f64>, counts: [usize; 3]) -> Self {
        let axis = |i: usize| match counts[i] {
            1 => vec![0.5 * (min[i] + max[i])],
            n => (0..n)
                .map(|k| if k + 1 == n { max[i] } else { min[i] + (max[i] - min[i]) * k as f64 / (n - 1) as f64 })
                .collect(),
        };
        Self { axes: [axis(0), axis(1), axis(2)] }
    }

    /// Points along x, y and z.
    pub fn counts(&self) -> [usize; 3] {
        [self.axes[0].len(), self.axes[1].len(), self.axes[2].len()]
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.counts().iter().product()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Point `index`; x runs fastest, then y, then z.
    pub fn position(&self, index: usize) -> Vector3<f64> {
        let [nx, ny, _] = self.counts();
        Vector3::new(self.axes[0][index % nx], self.axes[1][index / nx % ny], self.axes[2][index / (nx * ny)])
    }

    /// Share of the box that is nearer to point `index` than to its neighbours: half a cell along each axis at the ends.
    pub fn cell_share(&self, index: usize) -> f64 {
        let [nx, ny, _] = self.counts();
        let share = |axis: usize, i: usize| {
            let steps = self.axes[axis].len() - 1;
            match i {
                _ if steps == 0 => 1.0,
                i if i == 0 || i == steps => 0.5 / steps as f64,
                _ => 1.0 / steps as f64,
            }
        };
        share(0, index % nx) * share(1, index / nx % ny) * share(2, index / (nx * ny))
    }
}

/// A checked workspace-map study.
#[derive(Debug, Clone)]
pub struct WorkspaceMapStudy {
    /// The nominal machine, by which positions are commanded.
    pub machine: Machine,
    /// Errors of each chain of the real machine.
    pub errors: Vec<ChainError>,
    /// Where.
    pub grid: Grid,
    /// The cutting force.
    pub force: MillingForce,
    /// Tool angles φ, rad.
    pub phis: Vec<f64>,
    /// What compensation puts right.
    pub target: Target,
    /// Heights of the slices drawn, mm.
    pub slices_z: Vec<f64>,
}

/// What a source does at a grid point, worst over φ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SourceEffect {
    /// Largest displacement of the tool tip, mm.
    pub deflection_mm: f64,
    /// The displacement itself, O axes, mm.
    pub deflection_vector_mm: [f64; 3],
    /// φ at which it occurs, degrees; `None` without cutting force.
    pub phi_deg: Option<f64>,
    /// Largest |Δρ| of each drive over φ: compensated less nominal drive position, mm or rad.
    pub delta_rho: Vec<f64>,
    /// Largest |τ| of each drive over φ at the nominal command, N or N·mm.
    pub drive_force: Vec<f64>,
    /// Principal stiffnesses of the tool tip at the worst φ, ascending, N/mm.
    pub principal_stiffness_n_per_mm: [f64; 3],
    /// Superposition less simultaneous tool displacement at the worst φ, O axes, mm; only for both sources.
    pub departure_vector_mm: Option<[f64; 3]>,
}

impl SourceEffect {
    /// Norm of the departure of superposition, mm.
    pub fn departure_mm(&self) -> Option<f64> {
        self.departure_vector_mm.map(|v| Vector3::from(v).norm())
    }

    /// Largest |τ| of all drives, N or N·mm.
    pub fn largest_drive_force(&self) -> f64 {
        self.drive_force.iter().copied().fold(0.0, f64::max)
    }
}

/// Why a point has no numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failure {
    /// Word used in tables: `unreachable`, `unstable`, `buckled`, `singular`, `not_converged`, or how
    /// compensation failed: `slow`, `diverged`, `uncontrollable`.
    pub status: &'static str,
    /// Reason in words.
    pub reason: String,
}

/// One grid point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapPoint {
    /// Commanded position of P, mm.
    pub position_mm: [f64; 3],
    /// Effects in the order of [`Source::ALL`].
    pub effects: [Result<SourceEffect, Failure>; 3],
}

impl MapPoint {
    /// The effect of `source`, if it could be computed.
    pub fn effect(&self, source: Source) -> Option<&SourceEffect> {
        self.effects[source as usize].as_ref().ok()
    }
}

/// Results of a workspace-map study.
#[derive(Debug, Clone)]
pub struct WorkspaceMap {
    /// The study.
    pub study: WorkspaceMapStudy,
    /// Points in grid order.
    pub points: Vec<MapPoint>,
}

/// Computes all points, in parallel on the current rayon pool; the result does not depend on the number of threads.
///
/// `done` is called after each point.
pub fn run(study: &WorkspaceMapStudy, done: &(dyn Fn() + Sync)) -> WorkspaceMap {
    let real = study.machine.with_errors(&study.errors);
    let points = (0..study.grid.len())
        .into_par_iter()
        .map_init(
            || PointSolver {
                study,
                nominal: Pair::new(&study.machine, &study.machine),
                real: Pair::new(&study.machine, &real),
            },
            |solver, index| {
                let point = solver.solve(study.grid.position(index));
                done();
                point
            },
        )
        .collect();
    WorkspaceMap { study: study.clone(), points }
}

impl From<Unreachable> for Failure {
    fn from(unreachable: Unreachable) -> Self {
        Failure { status: "unreachable", reason: unreachable.to_string() }
    }
}

/// One machine commanded twice: without and with compensation.
struct Pair<'a> {
    plain: Session<'a>,
    corrected: Session<'a>,
}

impl<'a> Pair<'a> {
    fn new(nominal: &'a Machine, real: &'a Machine) -> Self {
        let settings = super::path::settings();
        let plain = Session::new(nominal, real, Settings { equilibrium: statics::Settings::default(), ..settings });
        Self { plain, corrected: Session::new(nominal, real, settings) }
    }
}

/// Tool displacements over φ and their effect, of one source.
struct Turn {
    /// Tool displacement at each φ, mm.
    displacements: Vec<Vector3<f64>>,
    effect: SourceEffect,
}

struct PointSolver<'a> {
    study: &'a WorkspaceMapStudy,
    /// The nominal machine, answering as it should.
    nominal: Pair<'a>,
    /// The machine with its errors.
    real: Pair<'a>,
}

impl PointSolver<'_> {
    fn solve(&mut self, position: Vector3<f64>) -> MapPoint {
        let position_mm = position.into();
        let machine = &self.study.machine;
        let at = match machine.inverse_kinematics(&machine.pose_at(position)) {
            Ok(at) => at,
            Err(unreachable) => {
                let failure = Failure::from(unreachable);
                return MapPoint { position_mm, effects: std::array::from_fn(|_| Err(failure.clone())) };
            }
        };
        let rigid = State::rigid(machine, &at);
        let phis: Vec<Option<f64>> = self.study.phis.iter().copied().map(Some).collect();
        for pair in [&mut self.nominal, &mut self.real] {
            pair.plain.stand(&at, &rigid);
        }
        let cutting = turn(self.study, &mut self.nominal, &at, &phis);
        let assembly = turn(self.study, &mut self.real, &at, &[None]);
        let mut both = turn(self.study, &mut self.real, &at, &phis);
        if let (Ok(cutting), Ok(assembly), Ok(both)) = (&cutting, &assembly, &mut both) {
            let worst = index_of_largest(&both.displacements);
            let superposed = cutting.displacements[worst] + assembly.displacements[0];
            both.effect.departure_vector_mm = Some((superposed - both.displacements[worst]).into());
        }
        MapPoint { position_mm, effects: [cutting, assembly, both].map(|turn| turn.map(|turn| turn.effect)) }
    }
}

/// Equilibria without and with compensation for each load (a φ, or none), each started from the one before.
fn turn(
    study: &WorkspaceMapStudy,
    pair: &mut Pair<'_>,
    at: &Configuration,
    phis: &[Option<f64>],
) -> Result<Turn, Failure> {
    let machine = &study.machine;
    let lever = at.pose.rotation * machine.tool_tip;
    let mut displacements = Vec::with_capacity(phis.len());
    let mut delta_rho = vec![0.0f64; machine.drive_count()];
    let mut drive_force = delta_rho.clone();
    let mut worst: Option<Worst> = None;
    for (index, &phi) in phis.iter().enumerate() {
        let load = phi.map_or(Wrench::zero(), |phi| study.force.wrench(phi, lever));
        let demand = Demand { pose: at.pose, load, target: study.target };
        let plain = commanded(machine, &mut pair.plain, &demand, Method::None, phi)?;
        if index == 0 {
            pair.corrected.stand(at, pair.plain.state());
        }
        let corrected = commanded(machine, &mut pair.corrected, &demand, Method::Direct, phi)?;
        for (most, force) in drive_force.iter_mut().zip(&plain.drive_forces) {
            *most = most.max(force.abs());
        }
        for ((most, rho), nominal) in delta_rho.iter_mut().zip(&corrected.drives).zip(&at.drives) {
            *most = most.max((rho - nominal).abs());
        }
        let state = pair.plain.state();
        let displacement = machine.tool_displacement(&at.pose, &state.pose);
        if worst.as_ref().is_none_or(|worst| displacement.norm() > worst.displacement.norm()) {
            let lever = state.pose.rotation * machine.tool_tip;
            worst = Some(Worst { displacement, phi, outcome: plain.outcome, lever });
        }
        displacements.push(displacement);
    }
    let Some(worst) = worst else {
        return Err(Failure { status: "not_converged", reason: "there is no load".into() });
    };
    Ok(Turn {
        effect: SourceEffect {
            deflection_mm: worst.displacement.norm(),
            deflection_vector_mm: worst.displacement.into(),
            phi_deg: worst.phi.map(f64::to_degrees),
            delta_rho,
            drive_force,
            principal_stiffness_n_per_mm: tool_stiffnesses(worst.outcome.as_ref(), worst.lever),
            departure_vector_mm: None,
        },
        displacements,
    })
}

/// The load with the largest displacement so far.
struct Worst {
    displacement: Vector3<f64>,
    phi: Option<f64>,
    outcome: Option<Outcome>,
    /// From P to the displaced tool tip, O axes, mm.
    lever: Vector3<f64>,
}

fn commanded(
    machine: &Machine,
    session: &mut Session<'_>,
    demand: &Demand,
    method: Method,
    phi: Option<f64>,
) -> Result<Compensation, Failure> {
    let done = compensate(session, demand, method);
    if done.status.is_success() {
        return Ok(done);
    }
    let at = phi.map_or_else(String::new, |phi| format!(" (phi {:.1} deg)", phi.to_degrees()));
    Err(Failure { status: done.status.label(), reason: done.status.reason(machine) + &at })
}

fn index_of_largest(displacements: &[Vector3<f64>]) -> usize {
    let mut largest = 0;
    for (index, displacement) in displacements.iter().enumerate() {
        if displacement.norm() > displacements[largest].norm() {
            largest = index;
        }
    }
    largest
}

/// Inverse eigenvalues of the tool tip's compliance, ascending, N/mm; 0 where the tip is free.
fn tool_stiffnesses(outcome: Option<&Outcome>, lever: Vector3<f64>) -> [f64; 3] {
    let Some(compliance) = outcome.and_then(|outcome| outcome.compliance) else { return [0.0; 3] };
    statics::principal_stiffnesses(&tool_compliance(&compliance, lever))
}
