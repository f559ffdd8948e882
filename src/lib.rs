//! How far a loaded machine leaves its path, which drive commands compensate that, and where to put the workpiece.
//!
//! A machine is a set of elastic chains between base and platform. Chain `i` with drives ρ, virtual joints θ (link and
//! drive deflections) and passive joints q obeys
//!
//! ```text
//! ∂U/∂θ − J_θᵀ F_i = 0        ∂U/∂q − J_qᵀ F_i = 0        g_i(ρ; θ, q) = t            (1)
//! Σ F_i = F                                                                            (3)
//! ```
//!
//! with the elastic energy U, the wrench F_i the chain receives and the platform pose t. [`statics`] solves this for the
//! pose under a load, `t = f⁻¹(F | t₀)` (7), or for the load at a pose, `F = f(t | t₀)` (2), (3), with the exact loaded
//! stiffness (4)–(6). [`compensation`] finds the drives that bring the loaded tool to where it was commanded (8)–(13).
//! [`questions`] asks what a user wants to know, [`answer`] says it in tables and figures. Equation numbers are those of
//! Klimchik, Pashkevich, Chablat and Hovland, *Compliance error compensation technique for parallel robots composed of
//! non-perfect serial chains*.
//!
//! Lengths are in mm, forces in N, moments in N·mm and angles in rad throughout the library; files and tables carry the
//! unit in the key or column name. Frames are written in Drake's monogram notation, see [`spatial`].
//!
//! # The doorway
//!
//! What a program needs that uses the library is named at the top of the crate, in fewer than sixty names; the modules are how it is made,
//! for those who need more. Everything a program may want to hold is owned (a
//! [`Machine`] is a handle that is cheap to clone), results can be serialized, and long computations take progress and stop
//! as arguments ([`Work`]). `examples/` has a page each for an equilibrium, a map, a placement and a compensated program.
//!
//! | to | use |
//! |---|---|
//! | read a machine | [`Machine::named_or_file`], [`Machine::from_toml`] |
//! | read and set its numbers by name | [`Machine::parameters`], [`Machine::with_parameters`] |
//! | make a machine file of a URDF | [`urdf::import`] |
//! | solve a loaded state | [`Solver`], many at once [`Batch`] |
//! | compensate a command | [`compensate`] on a [`Session`], a whole path within limits [`compensation::compensate_bounded`] |
//! | map a workspace, or a range of it | [`map::run`], [`map::run_range`] |
//! | judge places for a workpiece | [`Evaluator`], [`placement::run`] |
//! | rewrite a program and verify it | [`ProgramJob::compensate`] |
//! | run a study file into a folder | [`Study::open`], [`Study::run_into`] |
//! | share it out, and merge the parts | [`Study::part`], [`Study::merge_into`] |
//!
//! # Features
//!
//! `cli` (the program, default) holds `report` (tables, figures, pages, studies run into folders). Without either, questions are computed and
//! nothing is drawn or written; that also builds for `wasm32-unknown-unknown`, where files are read from memory ([`Folder::in_memory`]).
//! `parquet` and `vtk` add formats of tables and maps. The engine alone is the package `kinetostat-engine`, programs alone
//! are `kinetostat-programs`.
//!
//! ```
//! use kinetostat::{Machine, MillingForce, Solver, Status, nalgebra::Vector3};
//!
//! let machine = Machine::named("orthoglide")?;
//! let commanded = machine.inverse_kinematics_at(Vector3::new(30.0, -40.0, 75.0))?;
//! let load = MillingForce::KLIMCHIK_GROOVE.wrench(0.0, &machine.tool_at(&commanded.pose.rotation));
//! let loaded = Solver::new(&machine).solve(&commanded.drives, &load)?;
//! assert_eq!(loaded.status, Status::Solved);
//! let moved = machine.tool_displacement(&commanded.pose, &loaded.pose);
//! assert!((0.2..0.5).contains(&moved.norm()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]
// The linker leaves out what pages do not ask for.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_imports, unused_variables))]

#[cfg(all(doctest, feature = "report"))]
#[doc = include_str!("../docs/library.md")]
struct Library;

#[cfg(feature = "report")]
pub mod answer;
#[cfg(feature = "cli")]
pub mod ending;
pub mod explore;
#[cfg(feature = "report")]
pub mod figures;
#[cfg(feature = "report")]
pub mod files;
pub mod input;
pub mod inspect;
#[cfg(feature = "report")]
pub mod page;
pub mod process;
#[cfg(not(target_family = "wasm"))]
pub mod products;
pub mod questions;
pub mod redundancy;
#[cfg(feature = "report")]
pub mod run;
pub mod simulation;
#[cfg(not(target_family = "wasm"))]
pub mod urdf;
pub mod work;

/// The engine: static equilibrium of the loaded machine, and the drive commands that compensate it.
pub use kinetostat_engine::{compensation, machine, spatial, statics};
/// NC and robot programs: read, followed and rewritten.
pub use kinetostat_programs as toolpath;
/// The linear algebra in the types of this library.
pub use nalgebra;

use kinetostat_engine::lanes;

/// Whether this is the engine of pages: it is small, and computes with nominal numbers what the program has checked.
pub(crate) const FOR_PAGES: bool = cfg!(target_family = "wasm");

pub use compensation::{Compensation, CompensationSettings, Method, Session, Target, TaskPoint, compensate};
pub use input::{
    Folder,
    error::{Error, Result},
};
pub use machine::{Branch, ChainError, Machine};
pub use process::{GammaChoice, MillingForce, Placement, Process};
#[cfg(not(target_family = "wasm"))]
pub use products::program::{
    CommandSource, CompensateOptions, Compensated, NoFiles, NotWritten, PartSink, ProgramJob, VerifiedProgram,
};
pub use questions::{
    Overrides, Study, StudyKind, map,
    map::WorkspaceMapStudy,
    placement,
    placement::{Evaluator, Metric, PlacementStudy, Site},
};
#[cfg(feature = "report")]
pub use run::{FinishedRun, RunOptions, Start};
pub use simulation::{Failure, LoadCase, Source};
pub use spatial::{Grid, Pose, Wrench};
pub use statics::{Batch, Case, Solution, Solver, Status};
pub use toolpath::{Orientation, PathPoint, ProgramFile, Toolpath};
pub use work::{
    Event, Work,
    part_file::{Part, PartSource},
    share::Share,
};
