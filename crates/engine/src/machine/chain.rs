//! A chain from the machine base to the platform: its route, drives and joints, with the units and words of their positions and forces (`Motion`).

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, SMatrix};

use super::route::Route;
use crate::{
    lanes::{Real, pairs},
    spatial::{Pose, Twist},
};

/// Most turns of a joint after which a coupled drive is taken to stand as before, and how near they must be to whole ones.
const MAX_TURNS: u32 = 12;
const WHOLE: f64 = 1e-9;

/// Kind of an elementary one-parameter motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Along the axis; parameter in mm, generalised force in N.
    Prismatic,
    /// About the axis; parameter in rad, generalised force in N·mm.
    Revolute,
}

impl Motion {
    /// Chooses `prismatic` for a prismatic motion and `revolute` for a revolute one.
    pub(crate) fn choose<T>(self, prismatic: T, revolute: T) -> T {
        match self {
            Motion::Prismatic => prismatic,
            Motion::Revolute => revolute,
        }
    }

    /// Name of the motion in machine files.
    pub fn label(self) -> &'static str {
        self.choose("prismatic", "revolute")
    }

    /// Unit of positions in files, the ending of keys and columns.
    pub fn position_unit(self) -> &'static str {
        self.choose("mm", "deg")
    }

    /// Unit of forces in files, the ending of keys and columns.
    pub fn force_unit(self) -> &'static str {
        self.choose("N", "Nmm")
    }

    /// Unit of positions in computations.
    pub fn computed_position_unit(self) -> &'static str {
        self.choose("mm", "rad")
    }

    /// Unit of positions as readers see it, with the blank that precedes it.
    pub fn position_suffix(self) -> &'static str {
        self.choose(" mm", "°")
    }

    /// Unit of positions as readers see it.
    pub fn shown_position_unit(self) -> &'static str {
        self.position_suffix().trim_start()
    }

    /// Unit of forces as readers see it.
    pub fn shown_force_unit(self) -> &'static str {
        self.choose("N", "N·mm")
    }

    /// Word for the load that a drive of this kind carries: `force` or `torque`.
    pub fn force_word(self) -> &'static str {
        self.choose("force", "torque")
    }

    /// Converts a position from mm or rad to mm or degrees, the unit of files and readers.
    pub fn to_shown(self, value: f64) -> f64 {
        self.choose(value, value.to_degrees())
    }

    /// Converts a position from mm or degrees to mm or rad, and a quantity per mm or rad to one per mm or degree.
    pub fn from_shown(self, value: f64) -> f64 {
        self.choose(value, value.to_radians())
    }

    /// Formats a force (N) or torque (N·mm) with its unit, torques from 10 N·m on in N·m: "415 N", "64.3 N·m", "2787 N·m".
    pub fn force_text(self, load: f64) -> String {
        match self {
            Motion::Revolute if load.abs() >= 1e6 => format!("{:.0} N·m", 1e-3 * load),
            Motion::Revolute if load.abs() >= 1e4 => format!("{:.1} N·m", 1e-3 * load),
            _ => format!("{load:.0} {}", self.shown_force_unit()),
        }
    }

    /// Formats a position, given in mm or degrees, to 0.001 mm or 0.0001° and with its unit.
    pub fn position_text(self, value: f64) -> String {
        let decimals = self.choose(3, 4);
        // What is nothing has no sign.
        let value = if value.abs() < 0.5 * 0.1f64.powi(decimals as i32) { 0.0 } else { value };
        format!("{value:.decimals$}{}", self.position_suffix())
    }
}

/// A drive: an actuated joint, elastic about its commanded position.
#[derive(Debug, Clone, PartialEq)]
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
    /// Half the backlash: largest distance of the joint to either side of where its spring has it, mm or rad.
    pub half_backlash: f64,
    /// Largest force or torque that static friction holds, N or N·mm.
    pub friction: f64,
    /// ρ from which the home configuration is sought, mm or rad.
    pub home: f64,
}

/// A passive joint (a parallelogram counts as one).
#[derive(Debug, Clone, PartialEq)]
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
#[derive(Debug, Clone, PartialEq)]
pub struct Spring {
    /// What it belongs to: the drive or parallelogram, or the element's place in the chain.
    pub name: String,
    /// First virtual coordinate of the group; the group is contiguous.
    pub start: usize,
    /// Its stiffness.
    pub law: SpringLaw,
}

/// How the stiffness of a group of virtual joints is given.
#[derive(Debug, Clone, PartialEq)]
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

/// Linear map from the coordinates that a pendant shows to the joints of a chain's drives: `joint = per_shown · shown + offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// Motion of each joint (rows) per unit of each shown coordinate.
    pub per_shown: DMatrix<f64>,
    /// Position of each joint where all shown coordinates are zero, mm or rad.
    pub offset: Vec<f64>,
}

/// A chain from base to platform.
///
/// Its coordinates are the virtual ones θ (drive deflections and link deflections, in the order of the machine file) followed by the passive ones
/// q, those of loops among them. The pose of its end is `g(ρ; θ, q) = X_O,end`; the end coincides with P.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Name, unique within the machine.
    pub name: String,
    /// The way from base to platform.
    pub route: Route,
    /// Number of virtual coordinates.
    pub virtual_count: usize,
    /// Springs of the virtual coordinates, covering each once.
    pub springs: Vec<Spring>,
    /// Drives, in the order of the machine file.
    pub drives: Vec<Drive>,
    /// How the drives' joints follow from what is commanded; `None` where each is commanded alone.
    pub coupling: Option<Box<Coupling>>,
    /// Passive joints; joint `j` has coordinate `virtual_count + j`.
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

    /// Chain coordinate of passive joint `joint`.
    pub fn passive_coordinate(&self, joint: usize) -> usize {
        self.virtual_count + joint
    }

    /// Motion of the joint of drive `joint` per unit of the command of drive `drive`; 1 or 0 without coupling.
    #[inline]
    pub fn joint_per_drive(&self, joint: usize, drive: usize) -> f64 {
        match &self.coupling {
            Some(coupling) => coupling.per_shown[(joint, drive)],
            None if joint == drive => 1.0,
            None => 0.0,
        }
    }

    /// 1 where drive `drive` shows its joint's motion with the joint's sign, −1 where it shows the opposite.
    pub(crate) fn shown_sign(&self, drive: usize) -> f64 {
        if self.joint_per_drive(drive, drive) < 0.0 { -1.0 } else { 1.0 }
    }

    /// Full turn of revolute drive `drive`: the least change of its command, rad, that turns every joint by whole turns, 2π where it moves one joint
    /// alone. `None` for a prismatic joint, and where up to [`MAX_TURNS`] turns of a joint do not suffice.
    pub(crate) fn full_turn(&self, drive: usize) -> Option<f64> {
        if self.drives[drive].motion == Motion::Prismatic {
            return None;
        }
        let shares: Vec<f64> = (0..self.drives.len())
            .map(|joint| self.joint_per_drive(joint, drive))
            .filter(|share| *share != 0.0)
            .collect();
        let first = shares.first()?.abs();
        let is_whole = |turns: f64| (turns - turns.round()).abs() < WHOLE;
        let mut whole = (1..=MAX_TURNS).map(|turns| f64::from(turns) / first);
        whole.find(|turns| shares.iter().all(|share| is_whole(share * turns))).map(|turns| turns * TAU)
    }

    /// Commands of the drives (mm, rad) at the chain coordinates `values`, drive coordinates with the drives' positions added.
    pub(crate) fn commanded_drives(&self, values: &[f64]) -> Vec<f64> {
        (self.command_solver())(values)
    }

    /// Function that computes [`Chain::commanded_drives`], the coupling factored once.
    pub(crate) fn command_solver(&self) -> impl Fn(&[f64]) -> Vec<f64> {
        let coupling = self.coupling.as_ref().map(|coupling| (coupling.per_shown.clone().lu(), &coupling.offset));
        move |values| {
            let joints: Vec<f64> = self.drives.iter().map(|drive| values[drive.coordinate]).collect();
            let Some((per_shown, offset)) = &coupling else { return joints };
            let moved = DVector::from_fn(joints.len(), |i, _| joints[i] - offset[i]);
            per_shown.solve(&moved).map_or(joints, |shown| shown.as_slice().to_vec())
        }
    }

    /// Adds the joint positions that follow from the drive commands `drives` (mm, rad) to the chain coordinates `values`.
    #[inline(always)]
    pub fn add_joint_positions<R: Real>(&self, drives: &[R], values: &mut [R]) {
        match &self.coupling {
            None => {
                for (drive, &rho) in pairs(&self.drives, drives) {
                    values[drive.coordinate] += rho;
                }
            }
            Some(coupling) => {
                for (joint, drive) in self.drives.iter().enumerate() {
                    let mut position = R::splat(coupling.offset[joint]);
                    for (shown, &rho) in drives[..self.drives.len()].iter().enumerate() {
                        position += R::splat(coupling.per_shown[(joint, shown)]) * rho;
                    }
                    values[drive.coordinate] += position;
                }
            }
        }
    }

    /// Fills `values` with rigid chain coordinates: drives at `drives` (mm, rad; the chain's come first), joints at `passive`.
    pub fn rigid_values(&self, drives: &[f64], passive: &[f64], values: &mut Vec<f64>) {
        values.clear();
        values.resize(self.virtual_count, 0.0);
        self.add_joint_positions(drives, values);
        values.extend_from_slice(passive);
    }

    /// Pose of the chain's end and the screw of each elementary motion of its route.
    ///
    /// `values`: one per chain coordinate, drive coordinates with the drives' positions added (mm, rad). `screws`: cleared and refilled in order.
    pub fn forward(&self, values: &[f64], screws: &mut Vec<MoveScrew>) -> Pose {
        self.route.forward(&Pose::identity(), values, screws, &mut Vec::new())
    }
}
