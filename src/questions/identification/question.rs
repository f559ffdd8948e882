//! This question in the list of questions.

use super::{IdentificationStudy, resolve, spec::IdentificationSpec};
#[cfg(feature = "report")]
use crate::answer::{Output, Run};
use crate::{
    input::error::Result,
    questions::{Given, Question, Resolved, Template},
    work::Work,
};

impl Question for IdentificationStudy {
    type Spec = IdentificationSpec;
    type Shown = ();
    const NAME: &str = "an identification";
    const TEMPLATE: Template = Template {
        name: "identification",
        about: "Which stiffnesses and other numbers a machine has, by measurements under load",
        files: &[
            ("study.toml", include_str!("template/study.toml")),
            ("measurements.csv", include_str!("template/measurements.csv")),
        ],
    };
    const TABLES: &[&str] = &["parameters", "residuals", "models", "open"];

    fn resolve(spec: &IdentificationSpec, given: &Given<'_>) -> Result<Resolved<Self>> {
        resolve::resolve(spec, given)
    }

    fn items(&self) -> (usize, &'static str) {
        (self.measurements.len(), "measurements")
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
