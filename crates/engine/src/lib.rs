//! How a loaded machine deflects, how stiff it is, and which drive commands compensate that: parallel machines and robots.
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
//! stiffness (4)–(6) and its derivatives. [`compensation`] finds the drives that bring the loaded tool to where it was commanded
//! (8)–(13). Equation numbers are those of Klimchik, Pashkevich, Chablat and Hovland, *Compliance error compensation technique
//! for parallel robots composed of non-perfect serial chains*.
//!
//! Lengths are in mm, forces in N, moments in N·mm and angles in rad throughout; machine files carry the unit in the name of a
//! key. Frames are written in Drake's monogram notation, see [`spatial`].
//!
//! The engine knows no toolpath, no process and no study, and neither threads nor a terminal:
//! [kinetostat](https://docs.rs/kinetostat) has them. It also builds for `wasm32-unknown-unknown`, where no machine is built in.
//!
//! ```
//! use kinetostat_engine::{Machine, Solver, Wrench, nalgebra::Vector3, statics::Status};
//!
//! let machine = Machine::named("orthoglide")?;
//! let commanded = machine.inverse_kinematics_at(Vector3::new(30.0, -40.0, 75.0))?;
//! let load = Wrench { force: Vector3::new(0.0, 0.0, -100.0), moment: Vector3::zeros() };
//! let loaded = Solver::new(&machine).solve(&commanded.drives, &load)?;
//! assert_eq!(loaded.status, Status::Solved);
//! let moved = machine.tool_displacement(&commanded.pose, &loaded.pose);
//! assert!((0.01..1.0).contains(&-moved.z), "{moved}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]

pub mod compensation;
pub mod lanes;
pub mod machine;
pub mod statics;

/// Bodies and their distances.
pub use kinetostat_cell as cell;
/// What machine files are read with.
pub use kinetostat_input as input;
/// Poses, wrenches, and their transport.
pub use kinetostat_spatial as spatial;
/// The linear algebra in the types of this library.
pub use nalgebra;

pub use compensation::{Compensation, Method, Session, Target, TaskPoint, compensate};
pub use input::error::{Error, Result};
pub use machine::{ChainError, Machine};
pub use spatial::{Grid, Pose, Wrench};
pub use statics::{Solution, Solver};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
