//! Material removal and engagement of milling cutters on three axes.
//!
//! A [`Field`] holds what is left of a [`Stock`] after moves of [`Cutter`]s whose axis is along z, the spindle towards +z. [`Field::engage`] says
//! where a cutter touches material at an instant: entry and exit of each slice, depth, width, chip thickness, volume.
//!
//! ```
//! use kinetostat_removal::{Cutter, Engagement, Field, Slicing, Spindle, Stock};
//! use nalgebra::Vector3;
//!
//! let stock = Stock::cuboid(Vector3::new(0.0, 0.0, -20.0), Vector3::new(60.0, 40.0, 0.0))?;
//! let cutter = Cutter::flat(10.0)?;
//! let mut field = Field::new(stock, 0.25)?;
//! // A shoulder 2.5 mm wide and 5 mm deep along the edge y = 0, in moves of 0.5 mm: the last of them.
//! let at = |x: f64| Vector3::new(x, -2.5, -5.0);
//! for step in 0..80 {
//!     field.cut(&cutter, &at(0.5 * f64::from(step)), &at(0.5 * f64::from(step + 1)), step)?;
//! }
//! let mut engagement = Engagement::default();
//! field.engage(&cutter, &at(40.25), &Vector3::x(), &Slicing::default(), &mut engagement)?;
//! assert!((engagement.depth_mm - 5.0).abs() < 1e-9);
//! assert!((engagement.width_mm - 2.5).abs() < 1e-3);
//! // The material is to the left: up milling, from 0 to acos(1 − 2 b/D) = 60°.
//! let (entry, exit) = engagement.arcs[0].tooth_angles(Spindle::Clockwise);
//! assert!(entry.abs() < 1e-4 && (exit.to_degrees() - 60.0).abs() < 0.01);
//! # Ok::<(), kinetostat_removal::RemovalError>(())
//! ```

#![warn(missing_docs)]

mod cutter;
mod engagement;
mod error;
mod field;
mod mesh;
mod patches;
mod profile;
mod regions;
mod split;
mod stock;
mod surface;
mod sweep;
mod volume;

pub use cutter::Cutter;
pub use engagement::{Arc, Engagement, Milling, Slice, Slicing, Spindle};
pub use error::RemovalError;
pub use field::Field;
pub use patches::{Deviation, Patch};
pub use split::{Split, split};
pub use stock::Stock;
pub use surface::SurfacePoint;
pub use volume::Volumes;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
