//! This question in the list of questions.

use super::{PathStudy, resolve, spec::PathSpec};
#[cfg(feature = "report")]
use crate::report::{Output, Run};
use crate::{
    input::error::Result,
    study::{Given, Question, Resolved, Template},
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

    #[cfg(feature = "report")]
    fn answer(&self, shown: &Self::Shown, run: &Run<'_>) -> Result<Output> {
        super::report::answer(self, shown, run)
    }
}
