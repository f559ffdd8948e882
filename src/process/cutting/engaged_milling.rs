//! Mechanistic model of milling where the engagement is found from the stock: slices of the cutter, each with its arcs.

use std::f64::consts::{FRAC_PI_2, TAU};

use kinetostat_removal::{Arc, Engagement, Slice};
use nalgebra::Vector3;

use super::{
    EdgeForce, EdgeLaw, LoadError,
    arc::{ArcIntegrals, double_exponential},
    feed,
};
use crate::{
    process::{Bend, BentWall},
    toolpath::{PathPoint, TurnDirection},
};

/// Force of an end mill of any shape whose engagement is known.
///
/// θ counts from the heading counter-clockwise seen from the spindle ([`Arc`]), κ is the angle of the surface's outward normal from straight down (90° on
/// the cylinder) and α the rise of the motion. An element of edge of the length db, dz = db sin κ high, cuts a chip of the width db and the thickness
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

/// A tool as a cantilever from its holder, with teeth on a helix.
///
/// Its flutes bend like a cylinder of 0.8 of the diameter (L. Kops, D. T. Vo, Determination of the equivalent diameter of an end mill based on its compliance, CIRP Annals 39
/// (1990)).
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct Stub {
    /// Length from the holder to the tip, mm.
    pub stick_out_mm: f64,
    /// E I, N·mm².
    pub rigidity_Nmm2: f64,
    /// Displacement of the holder for each N across it, mm/N.
    pub holder_mm_per_N: f64,
    /// Angle by which a tooth lags behind for each mm above the tip, rad.
    pub lag_per_mm: f64,
}

impl Stub {
    /// Returns the displacement at one height above the tip for each N across the tool at another, mm/N: both below the holder.
    #[must_use]
    pub fn compliance(&self, at_mm: f64, force_mm: f64) -> f64 {
        let [near, far] = [at_mm, force_mm].map(|height| self.stick_out_mm - height);
        let (short, long) = if near < far { (near, far) } else { (far, near) };
        short * short * (3.0 * long - short) / (6.0 * self.rigidity_Nmm2) + self.holder_mm_per_N
    }
}

/// A tooth that comes so near to where a wall is made has made it, rad: as well as arcs are known.
const AT_WALL: f64 = 2e-3;
/// Longest pieces of an edge over which the force is integrated, mm, and where in them, as a share of half their length.
const PIECE_MM: f64 = 0.5;
const GAUSS: f64 = 0.577_350_269_189_625_8;
/// Heights over a wall at each of which a tooth passes it, for the mean over the wall.
const STRIPS: f64 = 96.0;
/// Instants over a pitch at which the largest force is looked for.
const INSTANTS: u32 = 48;

/// The chip thickness along an arc, `along cos θ + below`, mm.
#[derive(Debug, Clone, Copy)]
struct Chip {
    along: f64,
    below: f64,
}

impl EngagedMilling {
    /// Returns the mean force (N) and moment about the tip (N·mm) over a revolution, along the heading, to its left seen from the spindle, and to the spindle: of a cutter with
    /// so many `teeth` that engages as `engagement` says, at feed per tooth `c` (mm) and the sine of the rise of its motion. What a slice receives acts in its middle. Of slices
    /// that move into material only ahead, the `lateral` share of what acts across the tool counts: near its axis the heading is of rounding.
    #[must_use]
    pub fn mean(
        &self,
        engagement: &Engagement,
        teeth: u32,
        c: f64,
        rise: f64,
        lateral: f64,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let side = -self.spindle.sign();
        let level = (1.0 - rise * rise).max(0.0).sqrt();
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        // What the arcs of the last slice receive for each mm of edge: slices of a region have them in common.
        let mut last = None;
        for slice in &engagement.slices {
            let Slice { bottom_mm, top_mm, radius_mm, edge_mm: width, .. } = slice;
            let [sine, cosine] = directions(slice);
            let chip = Chip { along: c * sine * level, below: -c * cosine * rise };
            let of_arcs = || {
                let mut sums = [ArcIntegrals::default(); 3];
                for arc in &engagement.arcs[slice.arcs.clone()] {
                    let own = integrals(&self.edge, arc, chip);
                    sums.iter_mut().zip(own).for_each(|(sum, own)| *sum = sum.plus(own));
                }
                sums
            };
            let key = (&slice.arcs, [sine, cosine]);
            let [tangential, radial, axial] = match last {
                Some((known, sums)) if known == key => sums,
                _ => of_arcs(),
            };
            last = Some((key, [tangential, radial, axial]));
            let height = 0.5 * (bottom_mm + top_mm);
            let share = if chip.below > chip.along { 1.0 } else { lateral };
            let of = |radial_share: f64, axial_share: f64, own: fn(&ArcIntegrals) -> f64| {
                radial_share * own(&radial) + axial_share * own(&axial)
            };
            let own = Vector3::new(
                of(-sine, cosine, |own| own.cosine) - side * tangential.sine,
                of(-sine, cosine, |own| own.sine) + side * tangential.cosine,
                of(cosine, sine, |own| own.plain),
            ) * *width;
            // Of what acts up along the flank, at the radius where it does.
            let [up_left, up_ahead] = [of(cosine, sine, |own| own.sine), of(cosine, sine, |own| own.cosine)]
                .map(|own| own * radius_mm * width);
            force += own.component_mul(&Vector3::new(share, share, 1.0));
            let about = Vector3::new(up_left - height * own.y, height * own.x - up_ahead, 0.0);
            moment += about * share + Vector3::z() * (side * tangential.plain * radius_mm * width);
        }
        let share = f64::from(teeth) / TAU;
        (force * share, moment * share)
    }

    /// Returns the largest force within a turn of straight teeth, which bounds that of a helix, N; as for [`EngagedMilling::mean`].
    #[must_use]
    pub fn peak(&self, engagement: &Engagement, teeth: u32, c: f64, rise: f64) -> f64 {
        const INSIDE: f64 = 1e-9;
        let (side, level) = (-self.spindle.sign(), (1.0 - rise * rise).max(0.0).sqrt());
        let pitch = TAU / f64::from(teeth);
        let force_at = |instant: f64| {
            let mut sum = Vector3::zeros();
            for slice in &engagement.slices {
                let [sine, cosine] = directions(slice);
                for (arc, tooth) in
                    engagement.arcs[slice.arcs.clone()].iter().flat_map(|arc| (0..teeth).map(move |own| (arc, own)))
                {
                    let own = instant + pitch * f64::from(tooth);
                    let theta = own + TAU * ((0.5 * (arc.from + arc.to) - own) / TAU).round();
                    if theta < arc.from || theta > arc.to {
                        continue;
                    }
                    let (sin, cos) = libm::sincos(theta);
                    let on_edge = self.edge.on_edge((c * (sine * cos * level - cosine * rise)).max(0.0));
                    let outward = on_edge.z * cosine - on_edge.y * sine;
                    let across = side * on_edge.x;
                    let up = on_edge.y * cosine + on_edge.z * sine;
                    sum += Vector3::new(outward * cos - across * sin, outward * sin + across * cos, up) * slice.edge_mm;
                }
            }
            sum.norm()
        };
        // A tooth that enters or leaves may end it.
        let ends = [engagement.slices.first(), engagement.slices.last()].into_iter().flatten();
        let ends = ends.flat_map(|slice| &engagement.arcs[slice.arcs.clone()]);
        let ends = ends.flat_map(|arc| [arc.from + INSIDE, arc.to - INSIDE]);
        let instants = (0..INSTANTS).map(|instant| pitch * f64::from(instant) / f64::from(INSTANTS));
        instants.chain(ends).map(force_at).fold(0.0, f64::max)
    }

    /// Returns how `stub` bends to the `left` of its heading (a unit vector, W), for a tool as in [`EngagedMilling::mean`]. Where a tooth passes the wall at a height, forces act on all teeth that are in
    /// material then; each height of the wall has its own instant. What bends along the heading does not show.
    #[must_use]
    #[allow(non_snake_case, reason = "the unit is N, not n")]
    pub fn bend(
        &self,
        stub: &Stub,
        engagement: &Engagement,
        teeth: u32,
        c: f64,
        rise: f64,
        left: Vector3<f64>,
    ) -> Bend {
        let depth = engagement.depth_mm;
        let pitch = TAU / f64::from(teeth);
        // A tooth above lags behind: the spindle turns against θ.
        let lag = -self.spindle.sign() * stub.lag_per_mm;
        let each_force = |tip_angle: f64, see: &mut dyn FnMut(f64, f64)| {
            for slice in &engagement.slices {
                let middle = 0.5 * (slice.bottom_mm + slice.top_mm);
                for (arc, tooth) in
                    engagement.arcs[slice.arcs.clone()].iter().flat_map(|arc| (0..teeth).map(move |own| (arc, own)))
                {
                    let own = tip_angle + pitch * f64::from(tooth);
                    let turns = ((0.5 * (arc.from + arc.to) - own - lag * middle) / TAU).round();
                    let own = own + TAU * turns;
                    let Some([low, high]) = heights_in(arc, own, lag, [slice.bottom_mm, slice.top_mm]) else {
                        continue;
                    };
                    let pieces = ((high - low) / PIECE_MM).ceil().max(1.0);
                    let half = 0.5 * (high - low) / pieces;
                    for piece in 0..pieces as u32 {
                        let centre = low + (2.0 * f64::from(piece) + 1.0) * half;
                        for height in [centre - half * GAUSS, centre + half * GAUSS] {
                            see(height, half * self.force_to_left(slice, own + lag * height, c, rise));
                        }
                    }
                }
            }
        };
        // Force and bend where a tooth passes the wall at a height.
        let at_wall = |wall: f64, height: f64| {
            let (mut across, mut mm) = (0.0, 0.0);
            each_force(wall - lag * height, &mut |force_height, force| {
                across += force;
                mm += force * stub.compliance(height, force_height);
            });
            [across, mm]
        };
        // ∫ over the heights of the walls that are made, and these heights.
        let (mut integral, mut made_mm) = ([0.0, 0.0], 0.0);
        let walls = [FRAC_PI_2, -FRAC_PI_2].map(|wall| {
            let reaches = |arc: &Arc| arc.from <= wall + AT_WALL && arc.to >= wall - AT_WALL;
            let makes = |slice: &&Slice| engagement.arcs[slice.arcs.clone()].iter().any(reaches);
            let made = || engagement.slices.iter().filter(makes);
            let bottom = made().next()?;
            let (low, high) = (bottom.bottom_mm, made().next_back().unwrap_or(bottom).top_mm);
            for slice in made() {
                let height = slice.top_mm - slice.bottom_mm;
                let strips = (height / (high - low) * STRIPS).ceil().max(1.0);
                for strip in 0..strips as u32 {
                    let at = slice.bottom_mm + height * (f64::from(strip) + 0.5) / strips;
                    let own = at_wall(wall, at);
                    integral = [0, 1].map(|k| integral[k] + own[k] * height / strips);
                }
                made_mm += height;
            }
            let mut bends_mm = [0.0; Bend::HEIGHTS];
            for (at, bend) in bends_mm.iter_mut().enumerate() {
                let height = low + (high - low) * at as f64 / (Bend::HEIGHTS - 1) as f64;
                *bend = at_wall(wall, height)[1] as f32;
            }
            Some(BentWall { heights_mm: [low as f32, high as f32], bends_mm })
        });
        let (force, moment) = self.mean(engagement, teeth, c, rise, 1.0);
        let [made_force, made_bend] = integral.map(|own| (made_mm > 0.0).then_some(own / made_mm));
        // −M_x / F_y is the height at which the mean force acts.
        let acts_at = || if force.y == 0.0 { 0.0 } else { (-moment.x / force.y).clamp(0.0, depth) };
        let aimed_mm = made_bend.unwrap_or_else(|| force.y * stub.compliance(0.5 * depth, acts_at()));
        let peak = (0..INSTANTS).fold(0.0, |most: f64, instant| {
            let mut own = 0.0;
            each_force(pitch * f64::from(instant) / f64::from(INSTANTS), &mut |_, force| own += force);
            if own.abs() > most.abs() { own } else { most }
        });
        let across_N = [Some(force.y as f32), made_force.map(|own| own as f32), Some(peak as f32)];
        Bend { aimed_mm: aimed_mm * left, left, walls, across_N }
    }

    /// Returns the force to the left on a tooth that is at θ = `theta` in a slice, for each mm of its height, N/mm.
    fn force_to_left(&self, slice: &Slice, theta: f64, c: f64, rise: f64) -> f64 {
        let [sine, cosine] = directions(slice);
        let ((sin_theta, cos_theta), level) = (libm::sincos(theta), (1.0 - rise * rise).max(0.0).sqrt());
        let own = self.edge.on_edge((c * (sine * cos_theta * level - cosine * rise)).max(0.0));
        let outward = -own.y * sine + own.z * cosine;
        (outward * sin_theta - self.spindle.sign() * own.x * cos_theta) / sine
    }

    /// Returns the feed per tooth c of a cutter with so many `teeth` at `point`, mm. Fails when it follows from the point's feed and spindle speed and one of them is
    /// missing.
    pub fn feed_per_tooth(&self, point: &PathPoint, teeth: u32) -> Result<f64, LoadError> {
        feed::feed_per_tooth_at(point, self.feed_per_tooth_mm, teeth, "feed_per_tooth_mm")
    }
}

/// Returns the heights between `bottom` and `top`, mm, at which a tooth that is at `tip_angle` at the tip, and lags by `lag` for each mm above, is in
/// an arc; `None` if it is there at none.
fn heights_in(arc: &Arc, tip_angle: f64, lag: f64, [bottom, top]: [f64; 2]) -> Option<[f64; 2]> {
    if lag == 0.0 {
        return (arc.from - AT_WALL <= tip_angle && tip_angle <= arc.to + AT_WALL).then_some([bottom, top]);
    }
    let [from, to] = [arc.from, arc.to].map(|end| (end - tip_angle) / lag);
    let (low, high) = (bottom.max(from.min(to)), top.min(from.max(to)));
    (low < high).then_some([low, high])
}

/// Returns the mean of sin κ and cos κ along the edge of a slice.
fn directions(slice: &Slice) -> [f64; 2] {
    [(slice.top_mm - slice.bottom_mm) / slice.edge_mm, slice.run_mm / slice.edge_mm]
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
