//! Which pictures a validation study asks for.

use serde::Deserialize;

use crate::machine::{Machine, Motion};

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
