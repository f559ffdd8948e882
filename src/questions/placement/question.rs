//! This question in the list of questions.

use super::{PlacementStudy, resolve, spec::PlacementStudySpec};
#[cfg(feature = "report")]
use crate::answer::{Output, Run};
use crate::{
    input::error::Result,
    questions::{Given, Question, Resolved, Template},
    work::Work,
};

impl Question for PlacementStudy {
    type Spec = PlacementStudySpec;
    type Shown = ();
    const NAME: &str = "a placement study";
    const TEMPLATE: Template = Template {
        name: "placement",
        about: "Where a workpiece should stand",
        files: &[
            ("study.toml", include_str!("template/study.toml")),
            ("process.toml", include_str!("template/process.toml")),
        ],
    };
    const TABLES: &[&str] = &["candidates", "sweep", "refinements", "pareto"];

    fn resolve(spec: &PlacementStudySpec, given: &Given<'_>) -> Result<Resolved<Self>> {
        resolve::resolve(spec, given)
    }

    fn items(&self) -> (usize, &'static str) {
        (self.grid.len(), "places")
    }

    fn pieces(&self) -> usize {
        super::sweep::pieces(self)
    }

    fn goes_in_rounds(&self) -> bool {
        true
    }

    fn compute(&self, work: &Work) -> Result<()> {
        super::run(self, work).map(drop)
    }

    #[cfg(feature = "report")]
    fn answer(&self, (): &(), run: &Run<'_>) -> Result<Output> {
        super::report::answer(self, run)
    }
}
