//! Questions and answers as JSON texts.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

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
    match answered {
        Ok(answer) => json!({ "answer": answer }).to_string(),
        Err(error) => json!({ "error": error.to_string() }).to_string(),
    }
}

fn answer(explorer: &mut Option<Explorer>, asked: Call) -> Result<Value> {
    if let Call::Open(scene) = asked {
        let opened = explorer.insert(Explorer::open(scene)?);
        return value(&opened.view());
    }
    let Some(explorer) = explorer else {
        return Err(Error::Argument { argument: "call".into(), problem: "there is no scene: expected open".into() });
    };
    match asked {
        Call::Open(_) => Ok(Value::Null),
        Call::Set { parameters } => {
            explorer.set(parameters)?;
            value(&explorer.view())
        }
        Call::Place(asked) => value(&explorer.place(&asked)?),
        Call::Tool(asked) => value(&explorer.tool(&asked)?),
        Call::Slice(asked) => value(&explorer.slice(&asked)?),
        Call::Effect(asked) => value(&explorer.effect(&asked)?),
        Call::StudyFile { place } => value(&explorer.study_file(place)?),
    }
}

fn value(answer: &impl Serialize) -> Result<Value> {
    let fault = |fault: serde_json::Error| Error::Argument { argument: "answer".into(), problem: fault.to_string() };
    serde_json::to_value(answer).map_err(fault)
}
