//! Routes through chains: elementary motions in order, and what hangs on frames between them (masses, springs between points, loops).

use nalgebra::Vector3;

use super::{
    bodies::MachineBody,
    chain::{Motion, MoveScrew},
};
use crate::{
    lanes::{Frame, Real, Screw, Vec3},
    spatial::{Axis, Pose},
};

/// One factor of the product of transforms and motions that is a route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// A rigid transform.
    Fixed(Pose),
    /// An elementary motion by `sign` times the value of a chain coordinate.
    Move {
        /// Along or about.
        motion: Motion,
        /// Local axis.
        axis: Axis,
        /// Index of the coordinate among the chain's coordinates.
        coordinate: usize,
        /// +1 or −1.
        sign: f64,
    },
    /// Nothing: the frame reached is one on which something hangs. The `n`-th of a route is its frame `n`.
    Frame,
}

/// A mass that moves with a frame of a route.
#[derive(Debug, Clone, PartialEq)]
pub struct Mass {
    /// Frame of the route on which it hangs.
    pub frame: usize,
    /// Its centre in that frame, mm.
    pub at: Vector3<f64>,
    /// Mass, kg.
    pub kilograms: f64,
}

/// A point that moves with a frame of a route, or stays in O.
#[derive(Debug, Clone, PartialEq)]
pub struct Anchor {
    /// Frame of the route; `None` for O.
    pub frame: Option<usize>,
    /// The point in that frame, mm.
    pub at: Vector3<f64>,
}

/// A spring between two points: `U = ½ k (|d| − l₀)² + F₀ (|d| − l₀)`.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSpring {
    /// Its name in tables.
    pub name: String,
    /// The end nearer the base.
    pub from: Anchor,
    /// The end farther from it.
    pub to: Anchor,
    /// k in N/mm.
    pub stiffness: f64,
    /// l₀ in mm.
    pub free_length: f64,
    /// Tension F₀ at the free length, N.
    pub preload: f64,
}

impl PointSpring {
    /// Tension at length zero, N; without any, the spring is as regular where its ends meet as elsewhere.
    pub fn tension_at_zero_length(&self) -> f64 {
        self.preload - self.stiffness * self.free_length
    }
}

/// A body that moves with a frame of a route.
#[derive(Debug, Clone, PartialEq)]
pub struct HungBody {
    /// Frame of the route on which it hangs.
    pub frame: usize,
    /// The body.
    pub body: MachineBody,
}

/// Another route between two frames of a route. It and the part of the route between them are a parallel module.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// Its name, unique within the chain.
    pub name: String,
    /// Frame of the route where it starts, and in which its `base` is given.
    pub from: usize,
    /// Frame of the route where it ends.
    pub to: usize,
    /// The way.
    pub route: Route,
}

/// A product of transforms and motions from one frame to another, with masses, springs and loops on its frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    /// Pose of its first frame in O, or in the frame where a loop starts.
    pub base: Pose,
    /// The product.
    pub steps: Vec<Step>,
    /// Pose of the target (P, or the frame where a loop ends) in its last frame.
    pub attachment: Pose,
    /// Masses on its frames.
    pub masses: Vec<Mass>,
    /// Bodies on its frames.
    pub bodies: Vec<HungBody>,
    /// Springs between points of its frames.
    pub point_springs: Vec<PointSpring>,
    /// Other ways between its frames.
    pub loops: Vec<Loop>,
}

impl Default for Route {
    fn default() -> Self {
        Self {
            base: Pose::identity(),
            steps: Vec::new(),
            attachment: Pose::identity(),
            masses: Vec::new(),
            bodies: Vec::new(),
            point_springs: Vec::new(),
            loops: Vec::new(),
        }
    }
}

impl Route {
    /// Number of elementary motions.
    pub fn move_count(&self) -> usize {
        self.steps.iter().filter(|step| matches!(step, Step::Move { .. })).count()
    }

    /// Number of elementary motions before each frame.
    pub fn moves_before_frames(&self) -> Vec<usize> {
        let mut moves = 0;
        let mut before = Vec::new();
        for step in &self.steps {
            match step {
                Step::Move { .. } => moves += 1,
                Step::Frame => before.push(moves),
                Step::Fixed(_) => {}
            }
        }
        before
    }

    /// Chain coordinates of its own motions, ascending, each once.
    pub fn coordinates(&self) -> Vec<usize> {
        let moved = self.steps.iter().filter_map(|step| match *step {
            Step::Move { coordinate, .. } => Some(coordinate),
            _ => None,
        });
        let mut coordinates: Vec<usize> = moved.collect();
        coordinates.sort_unstable();
        coordinates.dedup();
        coordinates
    }

    /// Whether a mass hangs on this route or on one of its loops.
    pub fn has_mass(&self) -> bool {
        !self.masses.is_empty() || self.loops.iter().any(|other| other.route.has_mass())
    }

    /// This route and all loops within it, each before its own loops.
    pub fn with_loops(&self) -> Vec<&Route> {
        let inner = self.loops.iter().flat_map(|other| other.route.with_loops());
        std::iter::once(self).chain(inner).collect()
    }

    /// Applies `change` to this route and to all loops within it.
    pub fn for_each(&mut self, change: &mut impl FnMut(&mut Route)) {
        change(self);
        for other in &mut self.loops {
            other.route.for_each(change);
        }
    }

    /// Number of loops within this route, those within loops included.
    pub fn loop_count(&self) -> usize {
        self.loops.iter().map(|other| 1 + other.route.loop_count()).sum()
    }

    /// Pose of the target, the screw of each elementary motion and the pose of each frame, from a start at `start`.
    ///
    /// `values`: one per chain coordinate, drive coordinates with the drives' positions added (mm, rad). `screws` and `frames`: cleared
    /// and refilled in order; twists are those of the target at its own position.
    pub(crate) fn forward(
        &self,
        start: &Pose,
        values: &[f64],
        screws: &mut Vec<MoveScrew>,
        frames: &mut Vec<Pose>,
    ) -> Pose {
        screws.clear();
        frames.clear();
        let end = self.propagate(
            Frame::splat(start).compose(&self.base),
            values,
            |coordinate, twist: Screw<f64>| screws.push(MoveScrew { twist: twist.into(), coordinate }),
            |frame| frames.push(frame.into()),
        );
        let end = Pose::from(end);
        for screw in screws.iter_mut() {
            screw.twist.linear += screw.twist.angular.cross(&end.translation);
        }
        end
    }

    /// Pose of the target from a first frame at `frame`. `each` gets the coordinate and the twist of each elementary motion in order, at the point
    /// that coincides with O (seen at the target it gains `ω × p_end`); `reached` gets each frame.
    #[inline(always)]
    pub(crate) fn propagate<R: Real>(
        &self,
        mut frame: Frame<R>,
        values: &[R],
        mut each: impl FnMut(usize, Screw<R>),
        mut reached: impl FnMut(Frame<R>),
    ) -> Frame<R> {
        for step in &self.steps {
            match *step {
                Step::Fixed(transform) => frame = frame.compose(&transform),
                Step::Move { motion: Motion::Prismatic, axis, coordinate, sign } => {
                    let linear = frame.axes[axis.index()].scale(R::splat(sign));
                    each(coordinate, Screw { linear, angular: Vec3::zero() });
                    frame.translate_along(axis, R::splat(sign) * values[coordinate]);
                }
                Step::Move { motion: Motion::Revolute, axis, coordinate, sign } => {
                    let angular = frame.axes[axis.index()].scale(R::splat(sign));
                    each(coordinate, Screw { linear: frame.origin.cross(angular), angular });
                    // Springs of a rigid configuration stand at zero.
                    if !values[coordinate].all_zero() {
                        frame.rotate_about(axis, R::splat(sign) * values[coordinate]);
                    }
                }
                Step::Frame => reached(frame),
            }
        }
        frame.compose(&self.attachment)
    }
}
