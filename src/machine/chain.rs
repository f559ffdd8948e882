//! A chain: an ordered product of elementary motions from the machine base to the platform; drives and joints, with
//! the units and words of their positions and forces (`Motion`).

use nalgebra::SMatrix;

use crate::{
    lanes::{Frame, Real, Screw, Vec3},
    spatial::{Axis, Pose, Twist},
};

/// Kind of an elementary one-parameter motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Along the axis; parameter in mm, generalised force in N.
    Prismatic,
    /// About the axis; parameter in rad, generalised force in N·mm.
    Revolute,
}

impl Motion {
    /// Word in files.
    pub fn label(self) -> &'static str {
        match self {
            Motion::Prismatic => "prismatic",
            Motion::Revolute => "revolute",
        }
    }

    /// Unit of positions in files, as names of keys and columns end with it.
    pub fn position_unit(self) -> &'static str {
        match self {
            Motion::Prismatic => "mm",
            Motion::Revolute => "deg",
        }
    }

    /// Unit of forces in files, as names of keys and columns end with it.
    pub fn force_unit(self) -> &'static str {
        match self {
            Motion::Prismatic => "N",
            Motion::Revolute => "Nmm",
        }
    }

    /// Unit of positions in computations.
    pub fn computed_position_unit(self) -> &'static str {
        match self {
            Motion::Prismatic => "mm",
            Motion::Revolute => "rad",
        }
    }

    /// Unit of positions as readers see it, with the blank between a number and it.
    pub fn position_suffix(self) -> &'static str {
        match self {
            Motion::Prismatic => " mm",
            Motion::Revolute => "°",
        }
    }

    /// Unit of positions as readers see it.
    pub fn shown_position_unit(self) -> &'static str {
        self.position_suffix().trim_start()
    }

    /// Unit of forces as readers see it.
    pub fn shown_force_unit(self) -> &'static str {
        match self {
            Motion::Prismatic => "N",
            Motion::Revolute => "N·mm",
        }
    }

    /// What a drive of this kind carries, in one word.
    pub fn force_word(self) -> &'static str {
        match self {
            Motion::Prismatic => "force",
            Motion::Revolute => "torque",
        }
    }

    /// A position in the unit of files and readers, mm or degrees, from mm or rad.
    pub fn shown(self, value: f64) -> f64 {
        match self {
            Motion::Prismatic => value,
            Motion::Revolute => value.to_degrees(),
        }
    }

    /// A position in mm or rad, from mm or degrees. What there is per mm or rad becomes what there is per mm or degree.
    pub fn from_shown(self, value: f64) -> f64 {
        match self {
            Motion::Prismatic => value,
            Motion::Revolute => value.to_radians(),
        }
    }

    /// A position, given in mm or degrees, with its unit: to 0.001 mm or 0.0001°.
    pub fn position_words(self, value: f64) -> String {
        let decimals = match self {
            Motion::Prismatic => 3,
            Motion::Revolute => 4,
        };
        format!("{value:.decimals$}{}", self.position_suffix())
    }
}

/// One factor of the product that a chain is.
#[derive(Debug, Clone, Copy)]
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
}

/// A drive: an actuated joint, elastic about its commanded position.
#[derive(Debug, Clone)]
pub struct Drive {
    /// Name, unique within its chain.
    pub name: String,
    /// Prismatic (mm, N) or revolute (rad, N·mm).
    pub motion: Motion,
    /// Chain coordinate that holds its deflection θ_a; the joint stands at ρ + θ_a.
    pub coordinate: usize,
    /// Stiffness k_act in N/mm or N·mm/rad.
    pub stiffness: f64,
    /// Smallest and largest ρ in mm or rad.
    pub travel: Option<(f64, f64)>,
    /// Largest force in N, or torque in N·mm, either way.
    pub force_limit: Option<f64>,
    /// ρ from which the home configuration is sought, mm or rad.
    pub home: f64,
}

/// A passive joint (a parallelogram counts as one).
#[derive(Debug, Clone)]
pub struct PassiveJoint {
    /// Name, unique within its chain.
    pub name: String,
    /// Prismatic (mm) or revolute (rad).
    pub motion: Motion,
    /// Smallest and largest q in mm or rad.
    pub limits: Option<(f64, f64)>,
    /// Stiffness about `neutral` in N/mm or N·mm/rad; 0 for a free joint.
    pub stiffness: f64,
    /// q without spring force, mm or rad.
    pub neutral: f64,
    /// q from which the home configuration is sought, mm or rad.
    pub home: f64,
    /// Distance between the bars if it is a parallelogram, mm.
    pub parallelogram_width: Option<f64>,
}

/// Stiffness of a group of virtual joints: `U = ½ θᵀ K θ`.
#[derive(Debug, Clone)]
pub struct Spring {
    /// What it belongs to: the drive or parallelogram, or the element's place in the chain.
    pub name: String,
    /// First virtual coordinate of the group; the group is contiguous.
    pub start: usize,
    /// Its stiffness.
    pub law: SpringLaw,
}

/// How the stiffness of a group of virtual joints is given.
#[derive(Debug, Clone)]
pub enum SpringLaw {
    /// A drive: one coordinate, N/mm or N·mm/rad.
    Drive(f64),
    /// A 6-dof link end, in link axes (N, mm, rad).
    Link(Box<SMatrix<f64, 6, 6>>),
    /// A parallelogram: `K(q) = mean + cosine·cos 2q + sine·sin 2q`, five coordinates (N, mm, rad).
    Parallelogram {
        /// Chain coordinate of q.
        passive: usize,
        /// The matrices of the law, in that order.
        terms: Box<[SMatrix<f64, 5, 5>; 3]>,
    },
}

impl SpringLaw {
    /// Number of virtual coordinates of the group.
    pub fn size(&self) -> usize {
        match self {
            SpringLaw::Drive(_) => 1,
            SpringLaw::Link(_) => 6,
            SpringLaw::Parallelogram { .. } => 5,
        }
    }
}

/// A chain from base to platform.
///
/// Its coordinates are the virtual ones θ (drive deflections and link deflections, in order from base to platform)
/// followed by the passive ones q. The pose of its end is `g(ρ; θ, q) = X_O,end`; the end coincides with P.
#[derive(Debug, Clone)]
pub struct Chain {
    /// Name, unique within the machine.
    pub name: String,
    /// Pose of the chain's first frame in O.
    pub base: Pose,
    /// The product, from base to platform.
    pub steps: Vec<Step>,
    /// Pose of P in the chain's last frame.
    pub attachment: Pose,
    /// Number of virtual coordinates.
    pub virtual_count: usize,
    /// Springs of the virtual coordinates, covering each once.
    pub springs: Vec<Spring>,
    /// Drives, from base to platform.
    pub drives: Vec<Drive>,
    /// Passive joints, from base to platform; joint `j` has coordinate `virtual_count + j`.
    pub passive: Vec<PassiveJoint>,
}

/// Instantaneous screw of one elementary motion of a chain.
#[derive(Debug, Clone, Copy, Default)]
pub struct MoveScrew {
    /// Twist of the chain's end at its own position, O axes, per unit of the coordinate (sign included).
    pub twist: Twist,
    /// Coordinate that drives it.
    pub coordinate: usize,
}

impl Chain {
    /// Number of chain coordinates, virtual and passive.
    pub fn coordinate_count(&self) -> usize {
        self.virtual_count + self.passive.len()
    }

    /// Number of elementary motions.
    pub fn move_count(&self) -> usize {
        self.steps.iter().filter(|step| matches!(step, Step::Move { .. })).count()
    }

    /// Chain coordinate of passive joint `joint`.
    pub fn passive_coordinate(&self, joint: usize) -> usize {
        self.virtual_count + joint
    }

    /// Pose of the chain's end and the screw of each elementary motion.
    ///
    /// `values`: one per chain coordinate, drive coordinates with ρ added (mm, rad). `screws`: cleared and refilled in
    /// chain order.
    pub fn forward(&self, values: &[f64], screws: &mut Vec<MoveScrew>) -> Pose {
        screws.clear();
        let end = self.propagate(values, |coordinate, twist: Screw<f64>| {
            screws.push(MoveScrew { twist: twist.into(), coordinate });
        });
        let end = Pose::from(end);
        for screw in screws.iter_mut() {
            screw.twist.linear += screw.twist.angular.cross(&end.translation);
        }
        end
    }

    /// Pose of the chain's end; `each` is told the coordinate and the twist of each elementary motion in chain order, at
    /// the point that coincides with O. Seen at the end the twist gains `ω × p_end`.
    #[inline(always)]
    pub(crate) fn propagate<R: Real>(&self, values: &[R], mut each: impl FnMut(usize, Screw<R>)) -> Frame<R> {
        let mut frame = Frame::splat(&self.base);
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
                    if !values[coordinate].is_zero() {
                        frame.rotate_about(axis, R::splat(sign) * values[coordinate]);
                    }
                }
            }
        }
        frame.compose(&self.attachment)
    }
}
