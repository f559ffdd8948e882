//! The engine of interactive pages: one place or load after another, asked and answered as JSON. Each answer is what the command line
//! gives for the same question, one at a time and quickly, so that a page can follow a hand that drags a workpiece.
//!
//! An [`Explorer`] holds the machine, the checked study and everything that need not be made anew between two answers. What it
//! is asked and what it answers are JSON ([`call()`]).

mod effect;
mod place;
mod scene;
mod slice;
mod study;
mod tool;
mod view;

use serde::{Deserialize, Serialize};

use self::{effect::Map, study::Asked};
pub use self::{
    effect::{EffectAnswer, EffectAsked},
    place::{PlaceAnswer, PlaceAsked},
    scene::{BestPlace, Scene},
    slice::{SliceAnswer, SliceAsked},
    study::ProgramAtProcess,
    tool::{LoadAsked, PlaceOfTool, ToolAnswer, ToolAsked},
    view::View,
};
use crate::{
    input::{
        check::LARGEST,
        error::{Error, Result},
    },
    machine::Machine,
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
            Some(text) => match study::read(text, &folder, &overrides)? {
                (machine, Asked::Placement(study)) => (machine, Some(Workpiece::new(*study)), None),
                (machine, Asked::Map(study)) => (machine, None, Some(Map::new(*study)?)),
            },
            None => (study::machine(&scene, &folder, &overrides)?, None, None),
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

/// What can be asked.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "call", rename_all = "snake_case")]
pub enum Call {
    /// Opens a scene, and tells what is drawn of it.
    Open(Scene),
    /// Sets numbers of the machine; all others are as in its file.
    Set {
        /// Name and value.
        parameters: Vec<(String, f64)>,
    },
    /// What happens with the workpiece at a place.
    Place(PlaceAsked),
    /// What happens with the tool at a place, under a load.
    Tool(ToolAsked),
    /// What happens at the nodes of a plane of the workspace.
    Slice(SliceAsked),
    /// What a source does at a place of a map.
    Effect(EffectAsked),
    /// The study file with the workpiece's place among those compared.
    StudyFile {
        /// x, y, z in mm, yaw, pitch and roll in degrees.
        place: [f64; 6],
    },
}

/// Answers `text`, a [`Call`], for the scene that `explorer` holds, which the first call opens: `{"answer": …}`, or
/// `{"error": "…"}` in words.
pub fn call(explorer: &mut Option<Explorer>, text: &str) -> String {
    let answered = match serde_json::from_str(text) {
        Ok(asked) => answer(explorer, asked),
        Err(fault) => Err(Error::argument("call", fault.to_string())),
    };
    answered.unwrap_or_else(|error| serde_json::json!({ "error": error.to_string() }).to_string())
}

/// What is answered, as the text of its JSON.
fn answer(explorer: &mut Option<Explorer>, asked: Call) -> Result<String> {
    let opened = explorer.as_mut().ok_or_else(|| Error::argument("call", "there is no scene: expected open"));
    match asked {
        Call::Open(scene) => written(&explorer.insert(Explorer::open(scene)?).view()),
        Call::Set { parameters } => {
            let opened = opened?;
            opened.set(parameters)?;
            written(&opened.view())
        }
        Call::Place(asked) => written(&opened?.place(&asked)?),
        Call::Tool(asked) => written(&opened?.tool(&asked)?),
        Call::Slice(asked) => written(&opened?.slice(&asked)?),
        Call::Effect(asked) => written(&opened?.effect(&asked)?),
        Call::StudyFile { place } => written(&opened?.study_file(place)?),
    }
}

fn written(answer: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string(answer).map_err(|fault| Error::argument("answer", fault.to_string()))?;
    Ok(format!("{{\"answer\":{text}}}"))
}

/// Refuses values that are not `numbers` as files may have them.
fn check(argument: &str, numbers: &str, values: &[f64]) -> Result<()> {
    match values.iter().find(|value| value.is_nan() || value.abs() > LARGEST) {
        Some(value) => Err(Error::argument(argument, format!("expected {numbers} up to {LARGEST:e}, got {value}"))),
        None => Ok(()),
    }
}
