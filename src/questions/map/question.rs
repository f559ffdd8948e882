//! This question in the list of questions.

use super::{WorkspaceMapStudy, resolve, spec::WorkspaceMapSpec};
#[cfg(feature = "report")]
use crate::answer::{Output, Run};
use crate::{
    input::error::Result,
    questions::{Given, Question, Resolved, Template},
    work::Work,
};

impl Question for WorkspaceMapStudy {
    type Spec = WorkspaceMapSpec;
    type Shown = super::Shown;
    const NAME: &str = "a workspace map";
    const TEMPLATE: Template = Template {
        name: "map",
        about: "How far the tool moves over the workspace, and what to command instead",
        files: &[("study.toml", include_str!("template/study.toml"))],
    };
    const TABLES: &[&str] = &["map"];

    fn resolve(spec: &WorkspaceMapSpec, given: &Given<'_>) -> Result<Resolved<Self>> {
        resolve::resolve(spec, given)
    }

    fn items(&self) -> (usize, &'static str) {
        (self.grid.len(), "points")
    }

    fn image_points(&self) -> Option<usize> {
        Some(self.grid.len())
    }

    fn pieces(&self) -> usize {
        super::blocks(self)
    }

    fn compute(&self, work: &Work) -> Result<()> {
        super::run_in_blocks(self, work, |_| Ok(()))
    }

    #[cfg(feature = "report")]
    fn answer(&self, shown: &Self::Shown, run: &Run<'_>) -> Result<Output> {
        super::report::answer(self, shown, run)
    }
}
