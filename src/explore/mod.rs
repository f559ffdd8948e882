//! A machine and a workpiece to try things on: each answer is what the command line gives for the same question, one at a time
//! and quickly, so that a page can follow a hand that drags them.
//!
//! An [`Explorer`] holds the machine, the checked study and everything that need not be made anew between two answers. What it
//! is asked and what it answers are JSON ([`call()`]).

mod call;
mod effect;
mod load;
mod place;
mod scene;
mod slice;
mod study_file;
mod study_text;
mod tool;
mod view;

pub use call::{Call, call};
pub use effect::{EffectAnswer, EffectAsked};
pub use load::LoadAsked;
pub use place::{PlaceAnswer, PlaceAsked};
pub use scene::{BestPlace, Scene};
pub use slice::{SliceAnswer, SliceAsked};
pub use study_text::ProgramAtProcess;
pub use tool::{PlaceOfTool, ToolAnswer, ToolAsked};
pub use view::View;

use effect::Map;
use study_file::Asked;

use crate::{input::error::Result, machine::Machine};
use crate::{
    questions::{
        Overrides,
        placement::{Evaluator, Metric, PlacementStudy},
    },
    simulation::Machines,
};

/// A scene being explored.
#[derive(Debug)]
pub struct Explorer {
    scene: Scene,
    overrides: Overrides,
    machine: Machine,
    machines: Machines,
    workpiece: Option<Workpiece>,
    map: Option<Map>,
}

/// The workpiece of a scene.
#[derive(Debug)]
struct Workpiece {
    study: PlacementStudy,
    evaluator: Evaluator,
}

/// What a scene's study is called in messages.
const STUDY: &str = "study.toml";

impl Explorer {
    /// Reads and checks a scene.
    ///
    /// # Errors
    /// Files that are not of the expected form, or a study that is neither of a workpiece's place nor a map.
    pub fn open(scene: Scene) -> Result<Self> {
        Self::with_parameters(scene, Vec::new())
    }

    /// The same scene with other numbers of the machine, by name, see [`Machine::with_parameters`]; all others are those of its
    /// file.
    ///
    /// # Errors
    /// A name that is unknown, or a value that makes no machine.
    pub fn set(&mut self, parameters: Vec<(String, f64)>) -> Result<()> {
        *self = Self::with_parameters(self.scene.clone(), parameters)?;
        Ok(())
    }

    fn with_parameters(scene: Scene, parameters: Vec<(String, f64)>) -> Result<Self> {
        let overrides = Overrides { parameters, ..Overrides::default() };
        let folder = scene.folder();
        let (machine, workpiece, map) = match &scene.study {
            Some(text) => match study_file::read(text, &folder, &overrides)? {
                (machine, Asked::Placement(study)) => (machine, Some(Workpiece::new(*study)), None),
                (machine, Asked::Map(study)) => (machine, None, Some(Map::new(*study)?)),
            },
            None => (study_file::machine(&scene, &folder, &overrides)?, None, None),
        };
        Ok(Self { machines: Machines::new(&machine, &[])?, machine, workpiece, map, overrides, scene })
    }
}

impl Workpiece {
    fn new(study: PlacementStudy) -> Self {
        let mut metrics = study.objective.metrics();
        for metric in [Metric::WorstDeflection, Metric::WorstCorrection, Metric::WorstDriveForce] {
            if !metrics.contains(&metric) {
                metrics.push(metric);
            }
        }
        Self { evaluator: Evaluator::new(&study, &metrics), study }
    }
}
