//! This question in the list of questions.

use super::{ValidationStudy, resolve, spec::ValidationSpec};
#[cfg(feature = "report")]
use crate::answer::{Output, Run};
use crate::{
    input::error::Result,
    questions::{Given, Question, Resolved, Template},
    work::Work,
};

impl Question for ValidationStudy {
    type Spec = ValidationSpec;
    type Shown = super::Shown;
    const NAME: &str = "a validation study";
    const TEMPLATE: Template = Template {
        name: "validation",
        about: "Numbers quoted by a paper or a measurement beside those of the model",
        files: &[
            ("study.toml", include_str!("template/study.toml")),
            ("process.toml", include_str!("template/process.toml")),
        ],
    };
    const TABLES: &[&str] = &["summary", "variants"];

    fn resolve(spec: &ValidationSpec, given: &Given<'_>) -> Result<Resolved<Self>> {
        resolve::resolve(spec, given)
    }

    fn items(&self) -> (usize, &'static str) {
        (super::work(self), "points")
    }

    fn pieces(&self) -> usize {
        super::blocks(self)
    }

    fn compute(&self, work: &Work) -> Result<()> {
        super::run(self, work).map(drop)
    }

    #[cfg(feature = "report")]
    fn answer(&self, shown: &Self::Shown, run: &Run<'_>) -> Result<Output> {
        super::report::answer(self, shown, run)
    }
}
