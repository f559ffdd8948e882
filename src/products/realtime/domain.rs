//! Domain of a generated function: a box of tool tip positions and a range of wrenches, and points spread over them.

use nalgebra::Vector3;

use crate::{
    input::error::{Error, Result},
    machine::{Coordinate, Machine, ZeroState},
};

/// Positions and wrenches for which a function is generated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Domain {
    /// Smallest tool tip coordinates in O, mm.
    pub low: [f64; 3],
    /// Largest tool tip coordinates in O, mm.
    pub high: [f64; 3],
    /// Largest size of each wrench component about the tool tip, three in N and three in N·mm.
    pub wrench: [f64; 6],
}

/// Normalised coordinates of a point in a domain: three of the position and six of the wrench, each from −1 to 1.
pub(super) type Sample = [f64; 9];

/// A position of the tool tip (O, mm) and a wrench about it (N, N·mm).
pub(super) type TipTask = ([f64; 3], [f64; 6]);

impl Domain {
    /// Returns the corners of the machine's workspace box moved to the tool tip (O), rounded to 1e-6 mm.
    pub fn workspace(machine: &Machine) -> [Vector3<f64>; 2] {
        let tip = machine.home.pose.rotation * machine.tool_tip;
        [machine.workspace.min, machine.workspace.max].map(|corner| (corner + tip).map(|at| (at * 1e6).round() / 1e6))
    }

    /// Creates a domain from a box (O, mm) and the largest size of force (N) and moment (N·mm) components.
    ///
    /// # Errors
    /// A box without extent, or a negative range.
    pub fn new([low, high]: [Vector3<f64>; 2], force: f64, moment: f64) -> Result<Self> {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            if low[axis] >= high[axis] {
                let problem =
                    format!("{name} from {} to {} mm is no range: expected the smaller first", low[axis], high[axis]);
                return Err(Error::argument("--box", problem));
            }
        }
        for (argument, value) in [("--force-N", force), ("--moment-Nmm", moment)] {
            if !(0.0..f64::INFINITY).contains(&value) {
                return Err(Error::argument(argument, format!("must be 0 or more, got {value}")));
            }
        }
        let wrench = [force, force, force, moment, moment, moment];
        Ok(Self { low: low.into(), high: high.into(), wrench })
    }

    /// Returns tool tip position (O, mm) and wrench about the tip (N, N·mm) at a point of the domain.
    pub(super) fn task_at(&self, sample: &Sample) -> TipTask {
        let position = std::array::from_fn(|i| {
            let (middle, half) = (0.5 * (self.low[i] + self.high[i]), 0.5 * (self.high[i] - self.low[i]));
            middle + half * sample[i]
        });
        (position, std::array::from_fn(|i| self.wrench[i] * sample[3 + i]))
    }
}

/// The root of x¹⁰ = x + 1: its powers spread points evenly over nine coordinates (M. Roberts, The unreasonable effectiveness of
/// quasirandom sequences, 2018).
const SPREAD: f64 = 1.075_766_066_086_837_2;

/// Returns point `index` of a quasirandom sequence that fills the domain evenly, in normalised coordinates.
pub(super) fn sequence_point(index: usize) -> Sample {
    let mut power = 1.0;
    std::array::from_fn(|_| {
        power /= SPREAD;
        2.0 * (0.5 + power * (index + 1) as f64).fract() - 1.0
    })
}

/// Returns point `index` of [`sequence_point`] with its position moved towards the faces of the box, where polynomials err most.
pub(super) fn point_near_faces(index: usize) -> Sample {
    let mut sample = sequence_point(index);
    for coordinate in &mut sample[..3] {
        *coordinate = libm::sin(std::f64::consts::FRAC_PI_2 * *coordinate);
    }
    sample
}

/// Returns the 512 corners of the domain.
pub(super) fn corners() -> impl Iterator<Item = Sample> {
    (0..512_usize).map(|corner| std::array::from_fn(|i| if corner >> i & 1 == 1 { 1.0 } else { -1.0 }))
}

/// Returns an error that says why code cannot be generated for `machine`, if it cannot.
pub(super) fn check_machine(machine: &Machine) -> Result<()> {
    let translations = (0..3).all(|axis| machine.controls_translation(axis));
    let controls = || machine.controls.iter().map(|c: &Coordinate| c.name()).collect::<Vec<_>>().join(", ");
    let problem = if !translations || machine.controls.len() != 3 {
        format!("its drives control {}: expected the translations x, y, z and nothing else", controls())
    } else if machine.drive_count() != 3 {
        format!("it has {} drives: expected three", machine.drive_count())
    } else if machine.has_parasitic_rotation {
        "its platform has a parasitic rotation: expected one that keeps its orientation".into()
    } else if machine.carrier.is_some() {
        "what carries its workpiece can move or bend: expected a workpiece that stands fast".into()
    } else if machine.tool_compliance.is_some() {
        "its tool bends: expected a rigid one, without platform.tool_stiffness".into()
    } else if let (ZeroState::AtRest, Some(own)) = (machine.zeroed, machine.own_load_text()) {
        format!(
            "the machine has {own} and is zeroed at rest, which shifts positions in the base frame: expected zeroed = \"weightless\" or \
             \"at_home\""
        )
    } else {
        return Ok(());
    };
    Err(Error::argument("--machine", format!("{}: {problem}", machine.name)))
}
