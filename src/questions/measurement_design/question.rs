//! This question in the list of questions.

use super::{MeasurementDesignStudy, resolve, spec::MeasurementDesignSpec};
#[cfg(feature = "report")]
use crate::answer::{Output, Run};
use crate::{
    input::error::Result,
    questions::{Given, Question, Resolved, Template},
    work::Work,
};

impl Question for MeasurementDesignStudy {
    type Spec = MeasurementDesignSpec;
    type Shown = ();
    const NAME: &str = "a plan of measurements";
    const TEMPLATE: Template = Template {
        name: "measurements",
        about: "Which poses and loads to measure next, and how far numbers will be known then",
        files: &[("study.toml", include_str!("template/study.toml"))],
    };
    const TABLES: &[&str] = &["chosen", "widths", "candidates"];

    fn resolve(spec: &MeasurementDesignSpec, given: &Given<'_>) -> Result<Resolved<Self>> {
        resolve::resolve(spec, given)
    }

    fn items(&self) -> (usize, &'static str) {
        (self.candidates.len(), "candidates")
    }

    /// It is over before it would be divided.
    fn pieces(&self) -> usize {
        0
    }

    fn compute(&self, _: &Work) -> Result<()> {
        Ok(())
    }

    #[cfg(feature = "report")]
    fn answer(&self, (): &Self::Shown, run: &Run<'_>) -> Result<Output> {
        super::report::answer(self, run)
    }
}
