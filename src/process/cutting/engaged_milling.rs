//! Mechanistic model of milling where the engagement is found from the stock: slices of the cutter, each with its arcs.

use std::f64::consts::TAU;

use kinetostat_removal::{Arc, Engagement, Slice};
use nalgebra::Vector3;

use super::{
    EdgeForce, EdgeLaw, LoadError,
    arc::{ArcIntegrals, double_exponential},
    feed,
};
use crate::toolpath::{PathPoint, TurnDirection};

/// Force of an end mill of any shape whose engagement is known.
///
/// θ counts from the heading counter-clockwise seen from the spindle ([`Arc`]), κ is the angle of the surface's outward normal from straight down (90° on
/// the cylinder) and α the rise of the motion. An element of edge that is dz high cuts a chip of the width `db = dz / sin κ` and the thickness
///
/// ```text
/// h = c (sin κ cos θ cos α − cos κ sin α)          c feed per tooth
/// ```
///
/// and receives F_t db against its motion, F_r db along the normal into the tool and F_a db up along its flank ([`EdgeLaw`]). On the tool that is, with e the
/// direction at θ and s that to the spindle,
///
/// ```text
/// (−F_r sin κ + F_a cos κ) e  ±  F_t s × e  +  (F_r cos κ + F_a sin κ) s        + for a spindle clockwise seen from the spindle (M3)
/// ```
///
/// with the torque ± F_t r about s. The mean is N/2π times the integral over θ, in closed form for linear coefficients. On a cylinder that moves
/// horizontally it is [`EndMilling`](super::EndMilling), with ψ = 90° ∓ θ. Not in it: the end teeth of a plunge, run-out, and the helix, which does not change the
/// mean.
///
/// Source: S. Engin, Y. Altintas, Mechanics and dynamics of general milling cutters, Int. J. Machine Tools & Manufacture 41 (2001).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngagedMilling {
    /// The law of the force on a tooth.
    pub edge: EdgeLaw,
    /// c, feed per tooth, mm. `None`: from the feed v and spindle speed S of each point, c = v / (S N).
    pub feed_per_tooth_mm: Option<f64>,
    /// The spindle's direction of rotation, seen from the spindle towards the workpiece.
    pub spindle: TurnDirection,
}

/// The chip thickness along an arc, `along cos θ + below`, mm.
#[derive(Debug, Clone, Copy)]
struct Chip {
    along: f64,
    below: f64,
}

impl EngagedMilling {
    /// Returns the mean force (N) and moment about the tip (N·mm) over a revolution, along the heading, to its left seen from the spindle, and to the spindle: of a cutter with
    /// so many `teeth` that engages as `engagement` says, at feed per tooth `c` (mm) and the sine of the rise of its motion. What a slice receives acts in its middle.
    #[must_use]
    pub fn mean(&self, engagement: &Engagement, teeth: u32, c: f64, rise: f64) -> (Vector3<f64>, Vector3<f64>) {
        let side = -self.spindle.sign();
        let level = (1.0 - rise * rise).max(0.0).sqrt();
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for slice in &engagement.slices {
            let Slice { bottom_mm, top_mm, radius_mm, normal_angle, .. } = slice;
            let (sine, cosine) = libm::sincos(*normal_angle);
            let chip = Chip { along: c * sine * level, below: -c * cosine * rise };
            let (width, height) = ((top_mm - bottom_mm) / sine, 0.5 * (bottom_mm + top_mm));
            for arc in &engagement.arcs[slice.arcs.clone()] {
                let [tangential, radial, axial] = integrals(&self.edge, arc, chip);
                let of = |radial_share: f64, axial_share: f64, own: fn(&ArcIntegrals) -> f64| {
                    radial_share * own(&radial) + axial_share * own(&axial)
                };
                let own = Vector3::new(
                    of(-sine, cosine, |own| own.cosine) - side * tangential.sine,
                    of(-sine, cosine, |own| own.sine) + side * tangential.cosine,
                    of(cosine, sine, |own| own.plain),
                ) * width;
                // Of what acts up along the flank, at the radius where it does.
                let [up_left, up_ahead] = [of(cosine, sine, |own| own.sine), of(cosine, sine, |own| own.cosine)]
                    .map(|own| own * radius_mm * width);
                force += own;
                moment += Vector3::new(
                    up_left - height * own.y,
                    height * own.x - up_ahead,
                    side * tangential.plain * radius_mm * width,
                );
            }
        }
        let share = f64::from(teeth) / TAU;
        (force * share, moment * share)
    }

    /// Returns the feed per tooth c of a cutter with so many `teeth` at `point`, mm. Fails when it follows from the point's feed and spindle speed and one of them is
    /// missing.
    pub fn feed_per_tooth(&self, point: &PathPoint, teeth: u32) -> Result<f64, LoadError> {
        feed::feed_per_tooth_at(point, self.feed_per_tooth_mm, teeth, "feed_per_tooth_mm")
    }
}

/// Returns the integrals over θ of tangential, radial and axial force per mm of edge, of themselves and times sin θ and cos θ, N/mm.
fn integrals(edge: &EdgeLaw, arc: &Arc, chip: Chip) -> [ArcIntegrals; 3] {
    match edge {
        EdgeLaw::Linear { tangential, radial, axial } => {
            [tangential, radial, axial].map(|force| linear_integrals(*force, arc, chip))
        }
        EdgeLaw::Kienzle { tangential, tangential_share, radial_ratio, axial_ratio } => {
            let on_edge = |theta: f64| tangential.on_edge((chip.along * libm::cos(theta) + chip.below).max(0.0));
            let integral =
                |factor: fn(f64) -> f64| double_exponential(arc.from, arc.to, |theta| on_edge(theta) * factor(theta));
            let main =
                ArcIntegrals { plain: integral(|_| 1.0), sine: integral(libm::sin), cosine: integral(libm::cos) };
            [*tangential_share, *radial_ratio, *axial_ratio].map(|share| main.scaled(share))
        }
    }
}

fn linear_integrals(force: EdgeForce, arc: &Arc, chip: Chip) -> ArcIntegrals {
    let ((sin_in, cos_in), (sin_out, cos_out)) = (libm::sincos(arc.from), libm::sincos(arc.to));
    let (angle, sine, cosine) = (arc.to - arc.from, cos_in - cos_out, sin_out - sin_in);
    let cosine_squared = 0.5 * (angle + sin_out * cos_out - sin_in * cos_in);
    let sine_cosine = 0.5 * (sin_out - sin_in) * (sin_out + sin_in);
    let (along, constant) = (force.cutting * chip.along, force.cutting * chip.below + force.edge);
    ArcIntegrals {
        plain: along * cosine + constant * angle,
        sine: along * sine_cosine + constant * sine,
        cosine: along * cosine_squared + constant * cosine,
    }
}
