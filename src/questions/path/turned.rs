//! The search for γ, the rotation about the tool axis, along the path of a study, before anything else is computed.

use std::{borrow::Cow, sync::Arc};

use super::PathStudy;
use crate::{
    input::error::{Error, Result},
    process::{CutPath, GammaChoice, file::Process},
    questions::question::Question,
    redundancy::{FoundGamma, GammaProblem, search_gamma},
    simulation::tasks::tasks_under,
    work::{Event, Stage, Work},
};

/// The search for γ along a path, and its result.
#[derive(Debug, Clone)]
pub struct PathGammaSearch {
    process: Box<Process>,
    path: CutPath,
    origin: String,
    /// Result of the search; `None` before it has run.
    pub found: Option<Arc<FoundGamma>>,
}

impl PathGammaSearch {
    /// Returns the search along `path`, which errors call `origin`; `None` if the process does not ask for one.
    #[must_use]
    pub(super) fn of(process: &Process, path: &CutPath, origin: &str) -> Option<Self> {
        let search =
            || Self { process: process.clone().into(), path: path.clone(), origin: origin.into(), found: None };
        process.redundancy.is_sought().then(search)
    }

    /// Returns the choice of γ that the process asks for.
    #[must_use]
    pub fn choice(&self) -> GammaChoice {
        self.process.redundancy.gamma
    }

    /// Returns the settings of the search.
    #[must_use]
    pub fn settings(&self) -> &crate::process::RedundancySettings {
        &self.process.redundancy
    }
}

impl PathStudy {
    /// Returns the study with machine and tasks at the best γ found along the path; unchanged where none is sought or possible. `Err` if
    /// the machine cannot rotate its tool about its axis, or `work` was stopped.
    pub fn with_gamma(&self, work: &Work) -> Result<Cow<'_, Self>> {
        let Some(search) = self.gamma_search.as_ref().filter(|search| search.found.is_none()) else {
            return Ok(Cow::Borrowed(self));
        };
        let (process, path) = (&search.process, &search.path);
        let fault = |fault| Error::Argument { argument: search.origin.clone(), problem: format!("{fault}") };
        let loads = process.loads(path).map_err(fault)?;
        let search_problem = GammaProblem {
            machine: &process.machine,
            errors: &process.errors,
            placement: &process.placement,
            target: process.target,
            path,
            loads: &loads,
            settings: &process.redundancy,
        };
        let found = search_gamma(search_problem, work)?;
        let (items, of) = self.items();
        work.tell(Event::Stage(Stage { of, items }));
        let mut study = self.clone();
        if let Some(Ok(at_gamma)) = found.result_for(search.choice()) {
            study.tracked.machine = at_gamma.machine.clone();
            study.tasks = tasks_under(&at_gamma.machine, &process.placement, process.target, &at_gamma.path, &loads);
        }
        study.gamma_search = Some(PathGammaSearch { found: Some(Arc::new(found)), ..search.clone() });
        Ok(Cow::Owned(study))
    }
}
