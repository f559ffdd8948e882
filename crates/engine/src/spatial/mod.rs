//! Poses, twists, wrenches and their transport; grids and ranks. Pure algebra, no more than a library lacks; knows no machine.
//!
//! Notation is Drake's monogram notation: `X_AB` is the pose of frame B in frame A, `p_AB_C` the position of B's origin from A's origin expressed
//! in C, `R_AB` a rotation matrix. A [`Twist`] is the velocity of a point together with the angular velocity, a [`Wrench`] the force and the moment
//! about the same point, both in the same axes, so that `power = wrench · twist`.

mod grid;
mod halton;
mod pose;
mod rank_revealing;
mod screw;

pub use grid::Grid;
pub use halton::radical_inverse;
pub use pose::{Axis, PARALLEL_TO_X, Pose, frame_about, rotation_exp, rotation_log};
pub(crate) use pose::{matrix_product, matrix_vector};
pub use rank_revealing::{RankRevealing, rank};
pub use screw::{Twist, Wrench, larger, skew};
