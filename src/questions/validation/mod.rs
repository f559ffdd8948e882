//! Validation: compares numbers quoted by a paper or a measurement with those of the model.

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
    work::{Work, if_this_shard},
};

/// A named process with which every case is cut.
#[derive(Debug, Clone)]
pub struct Variant {
    /// Name of the process.
    pub name: String,
    /// Path of each case, in their order.
    pub paths: Vec<PathStudy>,
}

/// How a quoted number is to be compared.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// Equal within the tolerance: "about", "of", "up to".
    #[default]
    About,
    /// A lower limit: "can exceed".
    AtLeast,
    /// An upper limit: "not more than".
    AtMost,
}

/// A number quoted by a paper or a measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Quoted {
    /// Paper or measurement that quotes it.
    pub source: String,
    /// Index of the case it is about.
    pub case: usize,
    /// Quantity that it is the value of.
    pub quantity: Quantity,
    /// Quoted value, in the unit of the quantity.
    pub value: f64,
    /// How it is to be compared.
    pub relation: Relation,
    /// Largest difference that agrees: a share of the value, or absolute where the value is 0.
    pub agreement: f64,
    /// Explanation of a difference, if known.
    pub reason: String,
}

/// A checked validation study: cases cut under one or more processes, and quoted numbers.
#[derive(Debug, Clone)]
pub struct ValidationStudy {
    /// The machine.
    pub machine: Machine,
    /// Names of the cases.
    pub cases: Vec<String>,
    /// Processes; tables and figures are of the first.
    pub variants: Vec<Variant>,
    /// Quoted numbers to compare with.
    pub quoted: Vec<Quoted>,
}

impl ValidationStudy {
    /// Returns labels and words for the placement and cut of the first process, and for what differs under the others.
    pub fn facts(&self) -> Vec<(String, String)> {
        let facts = |variant: &Variant| variant.paths.first().map_or_else(Vec::new, |path| path.facts.clone());
        let first = self.variants.first().map(facts).unwrap_or_default();
        let mut labelled: Vec<(String, String)> =
            first.iter().map(|(label, text)| ((*label).to_string(), text.clone())).collect();
        for variant in self.variants.iter().skip(1) {
            let differing = facts(variant).into_iter().filter(|fact| !first.contains(fact));
            labelled.extend(differing.map(|(label, text)| (format!("{label}, {}", variant.name), text)));
        }
        labelled
    }
}

/// Figures that a validation study asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// The figures, in the order asked for.
    pub pictures: Vec<Picture>,
}

/// Kind of a figure of a validation study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FigureKind {
    /// Paths in the xy-plane: target, displaced by each source and by both, and commanded.
    Paths,
    /// Paths in the xy-plane: displaced by both sources, by their sum, and by chain errors alone.
    Superposition,
    /// Drive corrections Δρ, displacement Δt and drive forces τ over the tool angle, a panel for each case.
    Curves,
    /// Drive corrections Δρ and displacement Δt by source, a panel for each drive and coordinate.
    Sources,
}

/// A figure that a study asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Beginning of its file names.
    pub name: String,
    /// Title of the figure.
    pub title: String,
    /// Kind of the figure.
    pub kind: FigureKind,
    /// Indices of the cases shown.
    pub cases: Vec<usize>,
}

impl Picture {
    /// Returns the stems of the files of this figure. Prismatic and revolute drives of one machine are drawn apart.
    pub fn file_stems(&self, machine: &Machine) -> Vec<String> {
        let corrections = machine.drive_kinds().map(|kind| match (machine.has_mixed_drives(), kind) {
            (false, _) => "delta_rho",
            (true, Motion::Prismatic) => "delta_rho_prismatic",
            (true, Motion::Revolute) => "delta_rho_revolute",
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

/// Comparison of a quoted number with the model's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compared {
    /// The model's value for each variant, or why there is none.
    pub ours: Vec<Result<f64, String>>,
    /// Whether the first variant's value agrees with the quoted one.
    pub agrees: bool,
}

/// Results of a validation study.
#[derive(Debug, Clone, Serialize)]
pub struct ValidationResults {
    /// The study.
    #[serde(skip)]
    pub study: ValidationStudy,
    /// Results of every case of the first variant.
    pub paths: Vec<PathResults>,
    /// Comparisons, in the order of the quoted numbers.
    pub compared: Vec<Compared>,
}

impl Quoted {
    /// Returns the largest difference from the quoted value that agrees, in the unit of its quantity.
    pub fn allowed(&self) -> f64 {
        self.agreement * if self.value == 0.0 { 1.0 } else { self.value.abs() }
    }

    /// Returns whether `ours`, in the unit of the quantity, agrees with the quoted value within its tolerance, as the relation says.
    pub fn agrees(&self, ours: f64) -> bool {
        match self.relation {
            Relation::About => (ours - self.value).abs() <= self.allowed(),
            Relation::AtLeast => ours >= self.value,
            Relation::AtMost => ours <= self.value,
        }
    }
}

/// Returns the number of points that [`run`] solves, over all passes.
pub fn point_count(study: &ValidationStudy) -> usize {
    let paths = study.variants.iter().flat_map(|variant| &variant.paths);
    paths.map(|path| path.stations.len() * path::pass_count(path)).sum()
}

/// Returns the number of blocks of work, over all passes.
pub(super) fn block_count(study: &ValidationStudy) -> usize {
    study.variants.iter().flat_map(|variant| &variant.paths).map(path::block_count).sum()
}

/// Computes all paths under all processes on the current rayon pool, and compares the quoted numbers. `Err` if `work` was stopped, could
/// not be kept, or another shard computes a piece.
pub fn run(study: &ValidationStudy, work: &Work) -> error::Result<ValidationResults> {
    let mut ours: Vec<Vec<Result<f64, String>>> = vec![Vec::new(); study.quoted.len()];
    let (mut first_paths, mut pieces) = (Vec::new(), 0);
    for (index, variant) in study.variants.iter().enumerate() {
        let mut paths: Vec<PathResults> = Vec::with_capacity(variant.paths.len());
        for (case, path) in variant.paths.iter().enumerate() {
            paths
                .extend(if_this_shard(path::run(path, &work.part(&format!("{index}/{case}")).numbered_after(pieces)))?);
            pieces += path::block_count(path);
        }
        if if_this_shard(work.barrier())?.is_none() {
            continue;
        }
        for (quoted, ours) in study.quoted.iter().zip(&mut ours) {
            ours.push(quoted.quantity.of(&paths[quoted.case]));
        }
        if index == 0 {
            first_paths = paths;
        }
    }
    work.barrier()?;
    let compared = study.quoted.iter().zip(ours).map(|(quoted, ours)| {
        let agrees = ours.first().and_then(|value| value.as_ref().ok()).is_some_and(|&value| quoted.agrees(value));
        Compared { ours, agrees }
    });
    Ok(ValidationResults { compared: compared.collect(), paths: first_paths, study: study.clone() })
}
