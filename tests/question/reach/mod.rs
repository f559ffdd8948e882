//! How far the machine's named points are from home: the least a question can be.

#[cfg(feature = "report")]
mod report;

use nalgebra::Vector3;
use serde::Deserialize;

use crate::{
    input::{Inputs, error::Result},
    machine::{Machine, Unreachable},
    questions::{StudyContext, Question, Resolved, Template},
    work::{Event, Work},
};

/// The question as written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReachSpec {
    /// Longest way from home that is wanted.
    pub at_most_mm: f64,
}

/// A checked question.
#[derive(Debug, Clone)]
pub struct ReachStudy {
    /// The machine.
    pub machine: Machine,
    /// Longest way from home that is wanted, mm.
    pub at_most_mm: f64,
}

/// A named point and its way from home, mm, if the machine gets there.
#[derive(Debug, Clone)]
pub struct Way {
    /// Its name.
    pub name: String,
    /// The way, O, mm.
    pub way: std::result::Result<Vector3<f64>, Unreachable>,
}

impl Question for ReachStudy {
    type Spec = ReachSpec;
    type Shown = ();
    const NAME: &str = "a reach study";
    const TEMPLATE: Template = Template {
        name: "reach",
        about: "How far the machine's named points are from home",
        files: &[("study.toml", include_str!("template/study.toml"))],
    };
    const TABLES: &[&str] = &["ways"];

    fn resolve(spec: &ReachSpec, given: &StudyContext<'_>) -> Result<Resolved<Self>> {
        let at_most_mm = given.check.key("at_most_mm").positive(spec.at_most_mm)?;
        let study = Self { machine: given.machine.clone(), at_most_mm };
        Ok(Resolved { study, shown: (), inputs: Inputs::default() })
    }

    fn items(&self) -> (usize, &'static str) {
        (self.machine.points.len(), "points")
    }

    fn pieces(&self) -> usize {
        1
    }

    fn compute(&self, work: &Work) -> Result<()> {
        run(self, work).map(drop)
    }
}

/// The way to each named point.
///
/// # Errors
/// Of `work`.
pub fn run(study: &ReachStudy, work: &Work) -> Result<Vec<Way>> {
    let home = study.machine.home.pose.translation;
    let way = |point: &crate::machine::NamedPoint| {
        work.check()?;
        work.tell(Event::Computed(1));
        let reached = study.machine.inverse_kinematics_at(point.position);
        Ok(Way { name: point.name.clone(), way: reached.map(|at| at.pose.translation - home) })
    };
    study.machine.points.iter().map(way).collect()
}
