//! The engine of interactive pages: one place or load after another, asked and answered as JSON. Each answer is what the command line gives
//! for the same question, computed quickly, so that a page can follow a hand that drags a workpiece. A [`Cloud`](CloudResult) is an estimate.
//!
//! An [`Explorer`] holds the machine, the checked study and everything that need not be made anew between two answers. What it
//! is asked and what it answers are JSON ([`call()`]).

mod cloud;
mod effect;
mod place;
mod scene;
mod slice;
mod study;
mod tool;
mod view;

use serde::{Deserialize, Serialize};

pub use self::{
    cloud::CloudResult,
    effect::{EffectRequest, EffectResult},
    place::{MachineAt, PlaceRequest, PlaceResult},
    scene::{BestPlace, Scene},
    slice::{SliceRequest, SliceResult},
    study::ProgramAtProcess,
    tool::{LoadRequest, ToolPlace, ToolRequest, ToolResult},
    view::View,
};
use self::{cloud::Uncertain, effect::Map, study::PageStudy};
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

/// A scene being explored: its machine, workpiece or map, ready for questions.
#[derive(Debug)]
pub struct Explorer {
    scene: Scene,
    overrides: Overrides,
    machine: Machine,
    machines: Machines,
    workpiece: Option<Workpiece>,
    map: Option<Map>,
    uncertain: Option<Uncertain>,
}

/// The workpiece of a scene, with its study and evaluator.
#[derive(Debug)]
struct Workpiece {
    study: PlacementStudy,
    evaluator: Evaluator,
}

/// Name of a scene's study file in messages.
const STUDY: &str = "study.toml";

impl Explorer {
    /// Reads and checks a scene.
    ///
    /// # Errors
    /// Files that are not of the expected form, or a study that is neither a placement nor a map.
    pub fn open(scene: Scene) -> Result<Self> {
        Self::with_parameters(scene, Vec::new())
    }

    /// Sets parameters of the machine by name, see [`Machine::with_parameters`]; all others are as in its file.
    ///
    /// # Errors
    /// A name that is unknown, or a value that makes no machine.
    pub fn set(&mut self, parameters: Vec<(String, f64)>) -> Result<()> {
        *self = Self::with_parameters(self.scene.clone(), parameters)?;
        Ok(())
    }

    /// Opens `scene` with these values of its machine's parameters; errors as for [`Explorer::set`] and [`Explorer::open`].
    fn with_parameters(scene: Scene, parameters: Vec<(String, f64)>) -> Result<Self> {
        let overrides = Overrides { parameters, ..Overrides::default() };
        let folder = scene.folder();
        let (machine, workpiece, map, uncertain) = match &scene.study {
            Some(text) => {
                let (machine, study, table) = study::read(text, &folder, &overrides)?;
                let uncertain = table.map(|table| Uncertain::new(table, study.errors()));
                match study {
                    PageStudy::Placement(study) => (machine, Some(Workpiece::new(*study)), None, uncertain),
                    PageStudy::Map(study) => (machine, None, Some(Map::new(*study)?), uncertain),
                }
            }
            None => (
                study::machine(&scene, &folder, &overrides)?,
                None,
                None,
                Some(Uncertain::of_machine_file(&scene.machine)),
            ),
        };
        Ok(Self { machines: Machines::new(&machine, &[])?, machine, workpiece, map, uncertain, overrides, scene })
    }
}

impl Workpiece {
    /// Prepares an evaluator of the objective's metrics and of those that pages show.
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

/// A question of a page.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "call", rename_all = "snake_case")]
pub enum Call {
    /// Opens a scene, and returns what to draw of it.
    Open(Scene),
    /// Sets parameters of the machine; all others are as in its file.
    Set {
        /// Name and value.
        parameters: Vec<(String, f64)>,
    },
    /// Evaluates the workpiece at a place.
    Place(PlaceRequest),
    /// Solves the tool at a place, under a load.
    Tool(ToolRequest),
    /// Estimates where the tool may be at a place, under a load that is as uncertain as the machine.
    Cloud(ToolRequest),
    /// Solves the nodes of a plane of the workspace.
    Slice(SliceRequest),
    /// Computes the effect of one error source at a grid point of a map.
    Effect(EffectRequest),
    /// Returns the study file with the workpiece's place as one more candidate.
    StudyFile {
        /// x, y, z in mm, yaw, pitch and roll in degrees.
        place: [f64; 6],
    },
}

/// Answers `text`, a [`Call`] as JSON, in the scene that `explorer` holds: `{"answer": …}`, or `{"error": "…"}` in words.
pub fn call(explorer: &mut Option<Explorer>, text: &str) -> String {
    let result = match serde_json::from_str(text) {
        Ok(request) => dispatch(explorer, request),
        Err(fault) => Err(Error::argument("call", fault.to_string())),
    };
    result.unwrap_or_else(|error| serde_json::json!({ "error": error.to_string() }).to_string())
}

/// Returns the answer to a call as JSON text.
fn dispatch(explorer: &mut Option<Explorer>, call: Call) -> Result<String> {
    let opened = explorer.as_mut().ok_or_else(|| Error::argument("call", "there is no scene: expected open"));
    match call {
        Call::Open(scene) => to_json(&explorer.insert(Explorer::open(scene)?).view()),
        Call::Set { parameters } => {
            let opened = opened?;
            opened.set(parameters)?;
            to_json(&opened.view())
        }
        Call::Place(request) => to_json(&opened?.place(&request)?),
        Call::Tool(request) => to_json(&opened?.tool(&request)?),
        Call::Cloud(request) => to_json(&opened?.cloud(&request)?),
        Call::Slice(request) => to_json(&opened?.slice(&request)?),
        Call::Effect(request) => to_json(&opened?.effect(&request)?),
        Call::StudyFile { place } => to_json(&opened?.study_file(place)?),
    }
}

/// Returns `{"answer": …}` as JSON text.
fn to_json(answer: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string(answer).map_err(|fault| Error::argument("answer", fault.to_string()))?;
    Ok(format!("{{\"answer\":{text}}}"))
}

/// Returns an error if one of `values` is not a number of the size that files may have; its message calls them `numbers`.
fn check_numbers(argument: &str, numbers: &str, values: &[f64]) -> Result<()> {
    match values.iter().find(|value| value.is_nan() || value.abs() > LARGEST) {
        Some(value) => {
            Err(Error::argument(argument, format!("expected {numbers} from -{LARGEST:e} to {LARGEST:e}, got {value}")))
        }
        None => Ok(()),
    }
}
