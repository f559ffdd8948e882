//! Poses, twists, wrenches and their transport; grids and ranks. Pure algebra, no more than a library lacks; knows no machine.
//!
//! Notation is Drake's monogram notation: `X_AB` is the pose of frame B in frame A, `p_AB_C` the position of B's origin from A's origin expressed
//! in C, `R_AB` a rotation matrix. A [`Twist`] is the velocity of a point together with the angular velocity, a [`Wrench`] the force and the moment
//! about the same point, both in the same axes, so that `power = wrench · twist`.

#![warn(missing_docs)]

mod arm;
mod grid;
mod halton;
mod pose;
mod rank_revealing;
mod screw;
mod skeleton;

pub use arm::{ARM_BORDER, AskedPosture, Branch, Elbow, MAX_EXTERNAL_AXES, Shoulder, Wrist, branch_labels};
pub use grid::Grid;
pub use halton::radical_inverse;
pub use pose::{
    Axis, PARALLEL_TO_X, Pose, frame_about, least_turn, matrix_product, matrix_vector, rotation_exp, rotation_log,
};
pub use rank_revealing::{RankRevealing, rank};
pub use screw::{Twist, Wrench, larger, skew};
pub use skeleton::{BodyOutline, ChainSkeleton, JointMark, MassMark, Polyline, Skeleton};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
