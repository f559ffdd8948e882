//! This question in the list of questions.

use super::{PathStudy, resolve, spec::PathSpec};
#[cfg(feature = "report")]
use crate::answer::{Output, Run};
use crate::{
    input::error::Result,
    questions::{Given, Question, Resolved, Template},
    work::Work,
};

impl Question for PathStudy {
    type Spec = PathSpec;
    type Shown = super::Shown;
    const NAME: &str = "a path study";
    const TEMPLATE: Template = Template {
        name: "path",
        about: "How far the tool leaves a path, and which compensation puts it back",
        files: &[
            ("study.toml", include_str!("template/study.toml")),
            ("process.toml", include_str!("template/process.toml")),
        ],
    };
    const TABLES: &[&str] = &["points", "methods"];

    fn resolve(spec: &PathSpec, given: &Given<'_>) -> Result<Resolved<Self>> {
        resolve::resolve(spec, given)
    }

    fn items(&self) -> (usize, &'static str) {
        (self.stations.len() * super::passes(self), "points")
    }

    fn pieces(&self) -> usize {
        super::blocks(self)
    }

    fn compute(&self, work: &Work) -> Result<()> {
        super::run_in_parts(self.turned(work)?.as_ref(), work, |_| Ok(())).map(drop)
    }

    #[cfg(feature = "report")]
    fn answer(&self, shown: &Self::Shown, run: &Run<'_>) -> Result<Output> {
        super::report::answer(self, shown, run)
    }
}
