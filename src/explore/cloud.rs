//! Estimates where the tool may be under a load, where the machine and the force are not known exactly: a cloud of tips, a draw each.

use std::sync::OnceLock;

use nalgebra::Vector3;
use serde::Serialize;

use super::{
    Explorer,
    tool::{ToolRequest, command_from},
};
use crate::{
    compensation::{Method, Session, Target, TaskPoint, compensate},
    input::{
        check::Check,
        error::{Error, Result},
    },
    machine::{ChainError, Configuration, Machine, ZeroState},
    process::uncertainty::{Cause, Draws, P95, Response, Role, Surrogate, Uncertainty, UncertaintyTable, quantile},
    simulation::{
        Failure, Machines, SOLVED, Source,
        spread::{machines_at_ends, under},
    },
    statics::State,
};

/// What is not known exactly in a scene, and its machines, made when a cloud is first asked for.
#[derive(Debug)]
pub(super) struct Uncertain {
    table: UncertaintyTable,
    /// Errors of the process's chains, which a covariance must have.
    errors: Vec<ChainError>,
    by: &'static str,
    drawn: OnceLock<std::result::Result<Drawn, Failure>>,
}

/// The machines from which displacements in all draws are estimated.
#[derive(Debug)]
struct Drawn {
    uncertainty: Uncertainty,
    /// Machines with each parameter alone at its ends ([`Response::ENDS`]).
    ends: Vec<[Option<Machines>; 2]>,
    end_coordinates: Vec<[f64; 2]>,
    /// Whether the unloaded machine stands elsewhere where it is softer.
    sinks: bool,
}

/// Where the tool tip may be under a load, mm: an estimate that no draw of the engine checks.
#[derive(Debug, Clone, Default, Serialize)]
pub struct CloudResult {
    /// `solved`, or why nothing can be said.
    pub status: String,
    /// The reason in words, empty where solved.
    pub reason: String,
    /// Length of the nominal displacement.
    pub nominal: Option<f64>,
    /// 95 % of all draws move the tool less.
    pub p95: Option<f64>,
    /// What varies by a default, as nobody has said how well it is known.
    pub assumed: Vec<String>,
    /// Displacement of the tool tip in each draw of the first scramble, O axes.
    pub displacements: Vec<[f64; 3]>,
}

impl Uncertain {
    /// What the `table` of a study says, whose process has these chain `errors`.
    pub(super) fn new(table: UncertaintyTable, errors: &[ChainError]) -> Self {
        Self { table, errors: errors.to_vec(), by: "[uncertainty] of study or process", drawn: OnceLock::new() }
    }

    /// What the file of the `machine` alone says.
    pub(super) fn of_machine_file(machine: &str) -> Self {
        let table = UncertaintyTable::of_machine_file(Check::new(machine).key("provenance"));
        Self { by: "[[provenance]] of the machine file", ..Self::new(table, &[]) }
    }

    /// Where it stands.
    pub(super) fn by(&self) -> &'static str {
        self.by
    }

    /// Makes the machines of the nominal ones.
    fn drawn(&self, nominal: &Machines) -> Result<Drawn> {
        let machine = &nominal.nominal;
        let uncertainty = self.table.of_one_load(machine, &self.errors)?;
        Ok(Drawn {
            ends: machines_at_ends(&uncertainty, nominal, &[])?,
            end_coordinates: uncertainty.end_coordinates(),
            sinks: machine.zeroed != ZeroState::AtRest && machine.own_load_text().is_some(),
            uncertainty,
        })
    }
}

/// Solves `task` on the machine of `session`, whose commands are those of `nominal`, from `state`; `words` say in the reason which machine has no equilibrium.
fn solve(
    nominal: &Machine,
    session: &mut Session,
    task: &TaskPoint,
    at: &Configuration,
    state: &State,
    words: &str,
) -> std::result::Result<Vector3<f64>, Failure> {
    session.set_state(at, state);
    let answer = compensate(session, task, Method::None);
    match answer.status.is_success() {
        true => Ok(answer.tool_displacement),
        false => Err(Failure::of(&answer.status, nominal).on(words)),
    }
}

impl Drawn {
    /// Estimates the cloud under `task` at the nominal configuration `at`; `Err` where the machine of an end has no equilibrium. Each place is solved from
    /// its rigid configuration, whatever was asked before.
    fn cloud(
        &self,
        nominal: &Machines,
        at: &Configuration,
        task: &TaskPoint,
    ) -> std::result::Result<CloudResult, Failure> {
        let machine = &nominal.nominal;
        let tasks = [0.0, 1.0].map(|factor| under(task, factor));
        let mut session = nominal.session(Source::All);
        let response = |nominal| Response { nominal, ends: vec![[None; 2]; self.ends.len()] };
        let (words, rigid) = ("with nominal numbers", State::rigid(machine, at));
        let mut free = response(solve(machine, &mut session, &tasks[0], at, &rigid, words)?);
        let unloaded = session.state().clone();
        let mut loaded = response(solve(machine, &mut session, &tasks[1], at, &unloaded, words)?);
        let bent = session.state().clone();
        for (own, ends) in self.ends.iter().enumerate() {
            // What only bends does nothing to a machine without load, unless it sinks under its weight.
            let stays = self.uncertainty.parameters[own].role == Role::Elasticity && !self.sinks;
            for (end, machines) in ends.iter().enumerate() {
                let Some(machines) = machines else { continue };
                let (mut session, words) = (machines.session(Source::All), self.uncertainty.end_text(own, end));
                free.ends[own][end] = Some(match stays {
                    true => free.nominal,
                    false => solve(machine, &mut session, &tasks[0], at, &unloaded, &words)?,
                });
                loaded.ends[own][end] = Some(solve(machine, &mut session, &tasks[1], at, &bent, &words)?);
            }
        }
        let surrogate = Surrogate::under_one_load(&self.end_coordinates, &free, &loaded);
        let mut displacements = surrogate.displacements(&self.uncertainty.draws);
        let mut sizes: Vec<f64> = displacements.iter().map(|own| Vector3::from(*own).norm()).collect();
        let p95 = quantile(&mut sizes, P95);
        displacements.truncate(Draws::PER_SCRAMBLE);
        let model = self.uncertainty.model.is_assumed().then_some(Cause::MODEL);
        Ok(CloudResult {
            status: SOLVED.into(),
            reason: String::new(),
            nominal: Some(loaded.nominal.norm()),
            p95: Some(p95).filter(|p95| p95.is_finite()),
            assumed: self.uncertainty.assumed().chain(model).map(String::from).collect(),
            displacements,
        })
    }
}

impl Explorer {
    /// Estimates where the tool may be. A place where a machine has no equilibrium is a result, and so are numbers that make no machine.
    ///
    /// # Errors
    /// Nothing is uncertain in this scene, the place or the load is invalid, or assembly errors are given beside those that are drawn.
    pub fn cloud(&self, request: &ToolRequest) -> Result<CloudResult> {
        let uncertain = self.uncertain.as_ref();
        let uncertain = uncertain.ok_or_else(|| Error::argument("cloud", "nothing is uncertain in this scene"))?;
        if !request.assembly_deg.is_empty() {
            return Err(Error::argument("assembly_deg", "expected none: errors of chains are drawn"));
        }
        let (command, load) = (command_from(request.at)?, request.load.single_load()?);
        let drawn = uncertain
            .drawn
            .get_or_init(|| uncertain.drawn(&self.machines).map_err(|error| Failure::no_machine(&error)));
        let machine: &Machine = &self.machine;
        let found = drawn.as_ref().map_err(Failure::clone).and_then(|drawn| {
            let at = command.command(machine)?;
            let load = load.wrench(&machine.tool_at(&at.pose.rotation));
            let task = TaskPoint::new(at.pose, load, Target::ToolTip);
            drawn.cloud(&self.machines, &at, &task)
        });
        let failed = |Failure { status, reason }| CloudResult { status: status.into(), reason, ..Default::default() };
        Ok(found.unwrap_or_else(failed))
    }
}
