//! Branches of six-axis arms with a spherical wrist: the eight joint configurations for one pose of the flange, in words.
//!
//! `arm` says which machines are such arms and on which branch they stand, `closed_form` finds the joints of all branches at a
//! pose, `postures` what drives and limits make of them, `change` what becomes of a path that would change branch.

mod arm;
mod asked;
mod change;
mod closed_form;
mod postures;

pub(super) use arm::Arm;
pub use arm::Clearance;
pub use change::PostureChange;
pub use postures::Posture;

pub use crate::spatial::{AskedPosture, Branch, Elbow, Shoulder, Wrist};
