//! The engine as WebAssembly in an HTML page: the reader drags machine and workpiece, and the page computes the deflection.

use std::sync::OnceLock;

use base64::{Engine as _, engine::general_purpose::STANDARD};
use brotli_decompressor::Decompressor;
use flate2::{Compression, write::GzEncoder};
use serde::Serialize;
use serde_json::Value;

use super::{
    packed::script_json,
    template::{BUFFER, render},
};
use crate::input::error::Result;

/// Engine as WebAssembly, compressed by Brotli; `web/README.md` says how it is made.
const ENGINE: &[u8] = include_bytes!("assets/engine.wasm.br");
/// Scripts of the engine's block, in the order they run.
pub(super) const SCRIPTS: [&str; 6] = [
    include_str!("assets/engine.js"),
    include_str!("assets/explore_space.js"),
    include_str!("assets/explore_draw.js"),
    include_str!("assets/bending.js"),
    include_str!("assets/explore_map.js"),
    include_str!("assets/explore.js"),
];
const STYLE: &str = include_str!("assets/explore.css");

/// What a page lets its reader try with the engine, as in `report.json`.
#[derive(Debug, Clone, PartialEq, Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Interactive {
    /// The scene that the engine opens.
    Scene(Value),
    /// Nothing, with the reason.
    Nothing(String),
}

/// Content of the block of the engine in a template.
#[derive(Debug, Serialize)]
pub(super) struct EngineView {
    title: &'static str,
    hint: &'static str,
    reason: Option<String>,
    scene: String,
    /// The load that is tried first, as numbers with commas between; empty for that of the script.
    wrench: String,
    bytes: String,
    script: String,
    style: &'static str,
}

impl EngineView {
    /// Returns the block with its title and hint, and with scene and engine unless there is nothing to try.
    pub fn new((title, hint): (&'static str, &'static str), interactive: &Interactive) -> Self {
        let (reason, scene) = match interactive {
            Interactive::Scene(scene) => (None, Some(scene)),
            Interactive::Nothing(reason) => (Some(reason.clone()), None),
        };
        Self {
            title,
            hint,
            reason,
            scene: scene.map(script_json).unwrap_or_default(),
            wrench: String::new(),
            bytes: scene.map(|_| STANDARD.encode(gzipped_engine())).unwrap_or_default(),
            script: scene.map(|_| SCRIPTS.concat()).unwrap_or_default(),
            style: STYLE,
        }
    }
}

/// Content of the template `explore.html`.
#[derive(Debug, Serialize)]
struct ExplorePage<'a> {
    name: &'a str,
    question: &'a str,
    engine: EngineView,
}

/// Returns an interactive HTML page of `scene` alone, called `name`, with `question` as its heading, on which the tool is pulled by `wrench` (at P, axes
/// of O, N and N·mm) first, or by 100 N along x; `Err` when the template is at fault.
pub fn explore_page(name: &str, question: &str, scene: Value, wrench: Option<[f64; 6]>) -> Result<String> {
    let wrench = wrench.map(|wrench| wrench.map(|number| number.to_string()).join(",")).unwrap_or_default();
    let engine = EngineView { wrench, ..EngineView::new(("Try", ""), &Interactive::Scene(scene)) };
    render("explore.html", &ExplorePage { name, question, engine })
}

/// Returns the engine compressed by gzip, which browsers can decompress.
fn gzipped_engine() -> &'static [u8] {
    static PACKED: OnceLock<Vec<u8>> = OnceLock::new();
    PACKED.get_or_init(|| {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        let written = std::io::copy(&mut Decompressor::new(ENGINE, BUFFER), &mut packed).and_then(|_| packed.finish());
        written.expect("the engine is part of the program, and memory takes it")
    })
}
