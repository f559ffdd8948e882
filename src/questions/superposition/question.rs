//! This question in the list of questions.

use super::{SuperpositionStudy, resolve, spec::SuperpositionSpec};
#[cfg(feature = "report")]
use crate::answer::{Output, Run};
use crate::{
    input::error::Result,
    questions::{Given, Question, Resolved, Template},
    work::{Work, here},
};

impl Question for SuperpositionStudy {
    type Spec = SuperpositionSpec;
    type Shown = super::Shown;
    const NAME: &str = "a superposition study";
    const TEMPLATE: Template = Template {
        name: "superposition",
        about: "Whether the effects of cutting force and chain errors may be added",
        files: &[("study.toml", include_str!("template/study.toml"))],
    };
    const TABLES: &[&str] = &["map", "safe_load", "locations", "largest_factors", "scaling", "slopes", "ablation"];

    fn resolve(spec: &SuperpositionSpec, given: &Given<'_>) -> Result<Resolved<Self>> {
        resolve::resolve(spec, given)
    }

    fn items(&self) -> (usize, &'static str) {
        (self.grid.len() + self.locations.len(), "points")
    }

    fn image_points(&self) -> Option<usize> {
        Some(self.grid.len())
    }

    fn pieces(&self) -> usize {
        super::map_pieces(self) + self.locations.len()
    }

    fn compute(&self, work: &Work) -> Result<()> {
        here(super::run_map(self, work, |_| Ok(())))?;
        here(super::run_locations(self, work))?;
        work.gathered()
    }

    #[cfg(feature = "report")]
    fn answer(&self, shown: &Self::Shown, run: &Run<'_>) -> Result<Output> {
        super::report::answer(self, shown, run)
    }
}
