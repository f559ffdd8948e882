//! The table `[validation]` of a study file as written, with units in its keys; checked by [`crate::questions::Study`].

use serde::Deserialize;

use crate::questions::{
    spec::CircleSpec,
    validation::{FigureKind, Quantity, Relation},
};

/// The table `[validation]` of a study file: circles cut under one or more processes, and numbers quoted for them.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValidationSpec {
    /// Processes; tables and figures are of the first, the others show what a choice changes.
    pub variant: Vec<VariantSpec>,
    /// Paths that are cut.
    pub case: Vec<CaseSpec>,
    /// Quoted numbers to compare with.
    #[serde(default)]
    pub quoted: Vec<QuotedSpec>,
    /// Figures to draw.
    #[serde(default)]
    pub figure: Vec<FigureSpec>,
}

/// A named process with which every case is cut.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VariantSpec {
    /// Name of the process.
    pub name: String,
    /// Process file, relative to the study's folder; the process of the study if not given.
    pub process: Option<String>,
}

/// A named circle that is cut.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseSpec {
    /// Name of the case.
    pub name: String,
    /// The circle.
    pub circle: CircleSpec,
}

/// A number quoted by a paper or a measurement.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuotedSpec {
    /// Paper or measurement that quotes it.
    pub source: String,
    /// Name of the case that it is about.
    pub case: String,
    /// Quantity that it is the value of.
    pub quantity: Quantity,
    /// Quoted value, in the unit of the quantity.
    pub value: f64,
    /// How it is to be compared.
    #[serde(default)]
    pub relation: Relation,
    /// Largest relative difference that agrees; 0.1 if not given.
    pub agreement: Option<f64>,
    /// Explanation of a difference, in one line.
    pub reason: Option<String>,
}

/// A figure to draw.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureSpec {
    /// Beginning of its file names.
    pub name: String,
    /// Title of the figure.
    pub title: String,
    /// Kind of the figure.
    pub kind: FigureKind,
    /// Names of the cases shown, in order; one for paths and sources.
    pub cases: Vec<String>,
}
