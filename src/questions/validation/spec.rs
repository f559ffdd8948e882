//! A validation study as written.

use serde::Deserialize;

use crate::questions::{
    spec::CircleSpec,
    validation::{FigureKind, Quantity, Relation},
};

/// Circles cut under one or more processes, and numbers somebody quotes for them.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValidationSpec {
    /// Processes; the first one is that of tables and figures, the others show what a choice changes.
    pub variant: Vec<VariantSpec>,
    /// What is cut.
    pub case: Vec<CaseSpec>,
    /// Numbers to compare with.
    #[serde(default)]
    pub quoted: Vec<QuotedSpec>,
    /// Pictures.
    #[serde(default)]
    pub figure: Vec<FigureSpec>,
}

/// A process under a name.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VariantSpec {
    /// Its name.
    pub name: String,
    /// Process file, relative to the study's folder; the process of the study if not given.
    pub process: Option<String>,
}

/// A circle under a name.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseSpec {
    /// Its name.
    pub name: String,
    /// The path.
    pub circle: CircleSpec,
}

/// A number somebody quotes.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuotedSpec {
    /// Where it stands.
    pub source: String,
    /// The case it is about.
    pub case: String,
    /// What it is.
    pub quantity: Quantity,
    /// The number, in the unit of the quantity.
    pub value: f64,
    /// How it is meant.
    #[serde(default)]
    pub relation: Relation,
    /// Share by which "about" may differ; 0.1.
    pub agreement: Option<f64>,
    /// Why ours is another, in one line.
    pub reason: Option<String>,
}

/// A picture.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureSpec {
    /// Begin of its file names.
    pub name: String,
    /// Its heading.
    pub title: String,
    /// What it shows.
    pub kind: FigureKind,
    /// The cases shown, in order; one for paths and sources.
    pub cases: Vec<String>,
}
