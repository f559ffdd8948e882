//! Where a generated function answers: a box of the tool tip and a range of wrenches, and points spread over them.

use nalgebra::Vector3;

use crate::{
    input::error::{Error, Result},
    machine::{Coordinate, Machine, Zeroed},
};

/// Positions and wrenches for which a function is generated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Domain {
    /// Corners of the box of the tool tip in O, mm.
    pub low: [f64; 3],
    /// The other ones.
    pub high: [f64; 3],
    /// Largest component of the wrench about the tool tip, N and then N·mm.
    pub wrench: [f64; 6],
}

/// Coordinates of a place of a domain: three of the position and six of the wrench, each from -1 to 1.
pub(super) type Place = [f64; 9];

/// A position of the tool tip, mm, and a wrench about it.
pub(super) type Asked = ([f64; 3], [f64; 6]);

impl Domain {
    /// The machine's workspace, as the tool tip sees it, in as many digits as are written: 1e-6 mm.
    pub fn workspace(machine: &Machine) -> [Vector3<f64>; 2] {
        let tip = machine.home.pose.rotation * machine.tool_tip;
        [machine.workspace.min, machine.workspace.max].map(|corner| (corner + tip).map(|at| (at * 1e6).round() / 1e6))
    }

    /// Of a box and the largest component of force, N, and moment, N·mm.
    ///
    /// # Errors
    /// A box without extent, or a range that is negative.
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

    /// What is asked at `place`.
    pub(super) fn asked(&self, place: &Place) -> Asked {
        let position = std::array::from_fn(|i| {
            let (middle, half) = (0.5 * (self.low[i] + self.high[i]), 0.5 * (self.high[i] - self.low[i]));
            middle + half * place[i]
        });
        (position, std::array::from_fn(|i| self.wrench[i] * place[3 + i]))
    }
}

/// The root of x¹⁰ = x + 1: its powers spread points evenly over nine coordinates (M. Roberts, The unreasonable effectiveness of
/// quasirandom sequences, 2018).
const SPREAD: f64 = 1.075_766_066_086_837_2;

/// Point `index` of a sequence that fills the domain evenly.
pub(super) fn spread(index: usize) -> Place {
    let mut power = 1.0;
    std::array::from_fn(|_| {
        power /= SPREAD;
        2.0 * (0.5 + power * (index + 1) as f64).fract() - 1.0
    })
}

/// The same, its positions nearer to the faces of the box: where a polynomial that is fitted to them errs least.
pub(super) fn towards_faces(index: usize) -> Place {
    let mut place = spread(index);
    for coordinate in &mut place[..3] {
        *coordinate = (std::f64::consts::FRAC_PI_2 * *coordinate).sin();
    }
    place
}

/// The corners of the domain.
pub(super) fn corners() -> impl Iterator<Item = Place> {
    (0..512_usize).map(|corner| std::array::from_fn(|i| if corner >> i & 1 == 1 { 1.0 } else { -1.0 }))
}

/// Refuses a machine by what is missing.
pub(super) fn check(machine: &Machine) -> Result<()> {
    let translations = (0..3).all(|axis| machine.controls_translation(axis));
    let controls = || machine.controls.iter().map(|c: &Coordinate| c.name()).collect::<Vec<_>>().join(", ");
    let problem = if !translations || machine.controls.len() != 3 {
        format!("its drives control {}: expected the translations x, y, z and nothing else", controls())
    } else if machine.drive_count() != 3 {
        format!("it has {} drives: expected three", machine.drive_count())
    } else if machine.turns_with_position {
        "its platform has a parasitic rotation: expected one that keeps its orientation".into()
    } else if machine.carrier.is_some() {
        "what carries its workpiece can move or bend: expected a workpiece that stands fast".into()
    } else if machine.tool_compliance.is_some() {
        "its tool bends: expected a rigid one, without platform.tool_stiffness".into()
    } else if let (Zeroed::AtRest, Some(own)) = (machine.zeroed, machine.own_forces()) {
        format!(
            "it has {own} and is zeroed where it rests, from where it is elsewhere in the base frame: expected zeroed = \"weightless\" or \
             \"at_home\""
        )
    } else {
        return Ok(());
    };
    Err(Error::argument("--machine", format!("{}: {problem}", machine.name)))
}
