//! This question in the list of questions.

use super::{OnlineStudy, resolve, spec::OnlineSpec};
#[cfg(feature = "report")]
use crate::answer::{Output, Run};
use crate::{
    input::error::Result,
    questions::{Given, Question, Resolved, Template},
    work::Work,
};

impl Question for OnlineStudy {
    type Spec = OnlineSpec;
    type Shown = ();
    const NAME: &str = "an online study";
    const TEMPLATE: Template = Template {
        name: "online",
        about: "Whether to correct in the controller, by measured forces, or beforehand, by predicted ones",
        files: &[
            ("study.toml", include_str!("template/study.toml")),
            ("process.toml", include_str!("../path/template/process.toml")),
        ],
    };
    const TABLES: &[&str] = &["trials", "bands"];

    fn resolve(spec: &OnlineSpec, given: &Given<'_>) -> Result<Resolved<Self>> {
        resolve::resolve(spec, given)
    }

    fn items(&self) -> (usize, &'static str) {
        (1 + self.force_errors.len() * self.seeds, "trials")
    }

    fn pieces(&self) -> usize {
        1 + self.force_errors.len() * self.seeds
    }

    fn compute(&self, work: &Work) -> Result<()> {
        super::run(self, work).map(drop)
    }

    #[cfg(feature = "report")]
    fn answer(&self, (): &(), run: &Run<'_>) -> Result<Output> {
        super::report::answer(self, run)
    }
}
