//! This question in the list of questions.

use super::{TurnMapStudy, resolve, spec::TurnMapSpec};
#[cfg(feature = "report")]
use crate::answer::{Output, Run};
use crate::{
    input::error::Result,
    questions::{Given, Question, Resolved, Template},
    work::Work,
};

impl Question for TurnMapStudy {
    type Spec = TurnMapSpec;
    type Shown = resolve::Shown;
    const NAME: &str = "a map of turns";
    const TEMPLATE: Template = Template {
        name: "turns",
        about: "How a six-axis machine should turn its tool about the tool's axis, place by place",
        files: &[("study.toml", include_str!("template/study.toml"))],
    };
    const TABLES: &[&str] = &["turns"];

    fn resolve(spec: &TurnMapSpec, given: &Given<'_>) -> Result<Resolved<Self>> {
        resolve::resolve(spec, given)
    }

    fn items(&self) -> (usize, &'static str) {
        (self.grid.len() * self.axes.len(), "places")
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
