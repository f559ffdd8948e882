//! Questions and answers as JSON texts.

use serde::{Deserialize, Serialize};

use super::{EffectAsked, Explorer, PlaceAsked, Scene, SliceAsked, ToolAsked};
use crate::input::error::{Error, Result};

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
        Err(fault) => Err(Error::Argument { argument: "call".into(), problem: fault.to_string() }),
    };
    answered.unwrap_or_else(|error| serde_json::json!({ "error": error.to_string() }).to_string())
}

/// What is answered, as the text of its JSON.
fn answer(explorer: &mut Option<Explorer>, asked: Call) -> Result<String> {
    let opened = explorer
        .as_mut()
        .ok_or_else(|| Error::Argument { argument: "call".into(), problem: "there is no scene: expected open".into() });
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
    let fault = |fault: serde_json::Error| Error::Argument { argument: "answer".into(), problem: fault.to_string() };
    serde_json::to_string(answer).map(|json| format!("{{\"answer\":{json}}}")).map_err(fault)
}
