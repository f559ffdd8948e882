//! The engine in a page: the machine and the workpiece, to be moved by hand.

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

/// The engine as WebAssembly, compressed by Brotli; `web/README.md` says how it is made.
const ENGINE: &[u8] = include_bytes!("assets/engine.wasm.br");
/// Its scripts, in the order they run.
pub(super) const SCRIPTS: [&str; 6] = [
    include_str!("assets/engine.js"),
    include_str!("assets/explore_space.js"),
    include_str!("assets/explore_draw.js"),
    include_str!("assets/bending.js"),
    include_str!("assets/explore_map.js"),
    include_str!("assets/explore.js"),
];
/// Its styles.
const STYLE: &str = include_str!("assets/explore.css");

/// What a page of a run lets its reader try, as `report.json` has it.
#[derive(Debug, Clone, PartialEq, Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ToTry {
    /// The scene that the engine opens.
    Scene(Value),
    /// Nothing, and why.
    Nothing(String),
}

/// What the block of the engine shows.
#[derive(Debug, Serialize)]
pub(super) struct EngineView {
    title: &'static str,
    hint: &'static str,
    reason: Option<String>,
    scene: String,
    bytes: String,
    script: String,
    style: &'static str,
}

impl EngineView {
    /// `heading`: its title, and what can be done in a few words.
    pub fn new((title, hint): (&'static str, &'static str), to_try: &ToTry) -> Self {
        let (reason, scene) = match to_try {
            ToTry::Scene(scene) => (None, Some(scene)),
            ToTry::Nothing(reason) => (Some(reason.clone()), None),
        };
        Self {
            title,
            hint,
            reason,
            scene: scene.map(script_json).unwrap_or_default(),
            bytes: scene.map(|_| STANDARD.encode(engine())).unwrap_or_default(),
            script: scene.map(|_| SCRIPTS.concat()).unwrap_or_default(),
            style: STYLE,
        }
    }
}

#[derive(Debug, Serialize)]
struct ExplorePage<'a> {
    name: &'a str,
    question: &'a str,
    engine: EngineView,
}

/// A page of nothing but `scene`, which is called `name`; `question` is its heading.
///
/// # Errors
/// The page's template is at fault.
pub fn explore_page(name: &str, question: &str, scene: Value) -> Result<String> {
    let engine = EngineView::new(("Try", ""), &ToTry::Scene(scene));
    render("explore.html", &ExplorePage { name, question, engine })
}

/// The engine as pages have it: compressed by gzip, which browsers can undo.
fn engine() -> &'static [u8] {
    static PACKED: OnceLock<Vec<u8>> = OnceLock::new();
    PACKED.get_or_init(|| {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        let written = std::io::copy(&mut Decompressor::new(ENGINE, BUFFER), &mut packed).and_then(|_| packed.finish());
        written.expect("the engine is part of the program, and memory takes it")
    })
}
