//! A path whose free turn about the tool's axis is sought before anything else is asked of it.

use std::{borrow::Cow, sync::Arc};

use super::PathStudy;
use crate::{
    input::error::{Error, Result},
    process::{GammaChoice, file::Process},
    questions::question::Question,
    redundancy::{FoundGamma, TurnAsked, seek},
    simulation::tasks::tasks_under,
    toolpath::Toolpath,
    work::{Event, Stage, Work},
};

/// A path whose turn is sought.
#[derive(Debug, Clone)]
pub struct PathTurn {
    process: Box<Process>,
    path: Toolpath,
    origin: String,
    /// What was found; `None` before it is sought.
    pub found: Option<Arc<FoundGamma>>,
}

impl PathTurn {
    /// Of a process that seeks the turn along `path`, called `origin` in errors; `None` of others.
    #[must_use]
    pub(super) fn of(process: &Process, path: &Toolpath, origin: &str) -> Option<Self> {
        let sought =
            || Self { process: process.clone().into(), path: path.clone(), origin: origin.into(), found: None };
        process.redundancy.is_sought().then(sought)
    }

    /// Which turn is sought.
    #[must_use]
    pub fn redundancy(&self) -> GammaChoice {
        self.process.redundancy.gamma
    }

    /// How it is sought.
    #[must_use]
    pub fn how(&self) -> &crate::process::RedundancySettings {
        &self.process.redundancy
    }
}

impl PathStudy {
    /// The study of the path as it is turned about the tool's axis, if that is sought: of machine and tasks. Where no turn goes all
    /// along, they stay as programmed, and what was found says why.
    ///
    /// # Errors
    /// A machine that cannot turn its tool freely, and those of `work`.
    pub fn turned(&self, work: &Work) -> Result<Cow<'_, Self>> {
        let Some(turn) = self.turn.as_ref().filter(|turn| turn.found.is_none()) else { return Ok(Cow::Borrowed(self)) };
        let (process, path) = (&turn.process, &turn.path);
        let fault = |fault| Error::Argument { argument: turn.origin.clone(), problem: format!("{fault}") };
        let loads = process.loads(path).map_err(fault)?;
        let asked = TurnAsked {
            machine: &process.machine,
            errors: &process.errors,
            placement: &process.placement,
            target: process.target,
            path,
            loads: &loads,
            turn: &process.redundancy,
        };
        let found = seek(asked, work)?;
        let (items, of) = self.items();
        work.tell(Event::Stage(Stage { of, items }));
        let mut study = self.clone();
        if let Some(Ok(turned)) = found.chosen(turn.redundancy()) {
            study.machine = turned.machine.clone();
            study.tasks = tasks_under(&turned.machine, &process.placement, process.target, &turned.path, &loads);
        }
        study.turn = Some(PathTurn { found: Some(Arc::new(found)), ..turn.clone() });
        Ok(Cow::Owned(study))
    }
}
