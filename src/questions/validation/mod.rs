//! Numbers that somebody quotes, from a paper or a measurement, beside those of the model.

pub mod circle_shape;
mod quantity;
#[cfg(feature = "report")]
pub mod report;
mod resolve;
pub(crate) mod spec;

pub use quantity::Quantity;

use serde::{Deserialize, Serialize};

use crate::{
    input::error,
    machine::{Machine, Motion},
    questions::path::{self, PathResults, PathStudy},
    work::{Work, this_shard},
};

/// A process under a name, with every case cut by it.
#[derive(Debug, Clone)]
pub struct Variant {
    /// Its name.
    pub name: String,
    /// One path per case, in their order.
    pub paths: Vec<PathStudy>,
}

/// How a quoted number is meant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// The number itself: "about", "of", "up to".
    #[default]
    About,
    /// At least the number: "can exceed".
    AtLeast,
    /// At most the number: "not more than".
    AtMost,
}

/// A number that somebody quotes.
#[derive(Debug, Clone, PartialEq)]
pub struct Quoted {
    /// Where it stands.
    pub source: String,
    /// Index of the case it is about.
    pub case: usize,
    /// What it is.
    pub quantity: Quantity,
    /// The number, in the unit of the quantity.
    pub value: f64,
    /// How it is meant.
    pub relation: Relation,
    /// Difference that counts as none: a share of the number, or itself where the number is 0.
    pub agreement: f64,
    /// Why the model's number is another.
    pub reason: String,
}

/// A checked validation study.
#[derive(Debug, Clone)]
pub struct ValidationStudy {
    /// The machine.
    pub machine: Machine,
    /// Names of the cases.
    pub cases: Vec<String>,
    /// The first one is that of tables and figures.
    pub variants: Vec<Variant>,
    /// Numbers to compare with.
    pub quoted: Vec<Quoted>,
}

impl ValidationStudy {
    /// Where the workpiece stands and what is cut under the first process, as labels and words, and what differs under the
    /// others.
    pub fn facts(&self) -> Vec<(String, String)> {
        let facts = |variant: &Variant| variant.paths.first().map_or_else(Vec::new, |path| path.facts.clone());
        let first = self.variants.first().map(facts).unwrap_or_default();
        let mut all: Vec<(String, String)> =
            first.iter().map(|(label, words)| ((*label).to_string(), words.clone())).collect();
        for variant in self.variants.iter().skip(1) {
            let differing = facts(variant).into_iter().filter(|fact| !first.contains(fact));
            all.extend(differing.map(|(label, words)| (format!("{label}, {}", variant.name), words)));
        }
        all
    }
}

/// What pictures of a validation study show.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// In the order in which they are asked for.
    pub pictures: Vec<Picture>,
}

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FigureKind {
    /// Paths in the xy-plane: wanted, moved by each source and by both, and commanded instead.
    Paths,
    /// Paths in the xy-plane: moved by both sources, by their sum, and by chain errors alone.
    Superposition,
    /// Δρ, Δt and τ over the tool angle, one frame per case.
    Curves,
    /// Δρ and Δt by source, one frame per drive and per coordinate.
    Sources,
}

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Begin of its file names.
    pub name: String,
    /// Its heading.
    pub title: String,
    /// What it shows.
    pub kind: FigureKind,
    /// Indices of the cases shown.
    pub cases: Vec<usize>,
}

impl Picture {
    /// Stems of the files it is drawn to. Slides and hinges of one machine are drawn apart.
    pub fn file_stems(&self, machine: &Machine) -> Vec<String> {
        let corrections = machine.drive_kinds().map(|kind| match (machine.has_mixed_drives(), kind) {
            (false, _) => "delta_rho",
            (true, Motion::Prismatic) => "delta_rho_slides",
            (true, Motion::Revolute) => "delta_rho_hinges",
        });
        let forces = machine.drive_kinds().map(|kind| match kind {
            Motion::Prismatic => "drive_force",
            Motion::Revolute => "drive_torque",
        });
        let parts: Vec<&str> = match self.kind {
            FigureKind::Paths | FigureKind::Superposition => return vec![self.name.clone()],
            FigureKind::Curves => corrections.chain(["displacement"]).chain(forces).collect(),
            FigureKind::Sources => corrections.chain(["displacement"]).collect(),
        };
        parts.iter().map(|part| format!("{}_{part}", self.name)).collect()
    }
}

/// A quoted number and ours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compared {
    /// The model's number for each variant, or why there is none.
    pub ours: Vec<Result<f64, String>>,
    /// Whether the first variant's number is what is quoted.
    pub agrees: bool,
}

/// Results of a validation study.
#[derive(Debug, Clone, Serialize)]
pub struct ValidationResults {
    /// The study.
    #[serde(skip)]
    pub study: ValidationStudy,
    /// Every case of the first variant.
    pub paths: Vec<PathResults>,
    /// In the order of the quoted numbers.
    pub compared: Vec<Compared>,
}

impl Quoted {
    /// Difference that counts as none, in the unit of the quantity.
    pub fn allowed(&self) -> f64 {
        self.agreement * if self.value == 0.0 { 1.0 } else { self.value.abs() }
    }

    /// Whether `ours` is the number as it is meant.
    pub fn agrees(&self, ours: f64) -> bool {
        match self.relation {
            Relation::About => (ours - self.value).abs() <= self.allowed(),
            Relation::AtLeast => ours >= self.value,
            Relation::AtMost => ours <= self.value,
        }
    }
}

/// Points of all passes that [`run`] makes.
pub fn work(study: &ValidationStudy) -> usize {
    let paths = study.variants.iter().flat_map(|variant| &variant.paths);
    paths.map(|path| path.stations.len() * path::passes(path)).sum()
}

/// Blocks of all passes.
pub(super) fn blocks(study: &ValidationStudy) -> usize {
    study.variants.iter().flat_map(|variant| &variant.paths).map(path::blocks).sum()
}

/// Runs the study on the current rayon pool.
///
/// # Errors
/// Of `work`.
pub fn run(study: &ValidationStudy, work: &Work) -> error::Result<ValidationResults> {
    let mut ours: Vec<Vec<Result<f64, String>>> = vec![Vec::new(); study.quoted.len()];
    let (mut shown, mut pieces) = (Vec::new(), 0);
    for (index, variant) in study.variants.iter().enumerate() {
        let mut paths: Vec<PathResults> = Vec::with_capacity(variant.paths.len());
        for (case, path) in variant.paths.iter().enumerate() {
            paths.extend(this_shard(path::run(path, &work.part(&format!("{index}/{case}")).after(pieces)))?);
            pieces += path::blocks(path);
        }
        if this_shard(work.barrier())?.is_none() {
            continue;
        }
        for (quoted, ours) in study.quoted.iter().zip(&mut ours) {
            ours.push(quoted.quantity.of(&paths[quoted.case]));
        }
        if index == 0 {
            shown = paths;
        }
    }
    work.barrier()?;
    let compared = study.quoted.iter().zip(ours).map(|(quoted, ours)| {
        let agrees = ours.first().and_then(|value| value.as_ref().ok()).is_some_and(|&value| quoted.agrees(value));
        Compared { ours, agrees }
    });
    Ok(ValidationResults { compared: compared.collect(), paths: shown, study: study.clone() })
}
