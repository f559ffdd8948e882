//! Rings of the cutter's surface, sampled in angle.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Vector2, Vector3};

use crate::cutter::{Cutter, Ring};
use crate::engagement::Arc;
use crate::field::{Field, NONE};
use crate::sweep::{TOUCH, norm};

const DEGREE: f64 = PI / 180.0;
/// Ends of arcs are found within this.
const END: f64 = 1e-3 * DEGREE;
/// Step of the samples before any are added.
const STEP: f64 = 5.0 * DEGREE;
/// Samples before the ends of the angles that move into material: there walls beside the path begin.
const NEAR_ENDS: [f64; 5] = [0.25 * DEGREE, 0.5 * DEGREE, 1.0 * DEGREE, 2.0 * DEGREE, 3.5 * DEGREE];
/// Widest arc of material on the cylinder that may be missed.
const LEAST_ARC: f64 = 0.5 * DEGREE;

/// The tip and how it moves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Front {
    tip: Vector3<f64>,
    /// Unit vector of the horizontal motion; the x axis without.
    heading: Vector2<f64>,
    /// Horizontal part of the unit vector of motion, not negative.
    pub horizontal: f64,
    /// Its part along z.
    pub vertical: f64,
}

impl Front {
    /// `None` for a direction without length.
    pub fn new(tip: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Self> {
        let unit = direction.try_normalize(f64::MIN_POSITIVE)?;
        let horizontal = unit.xy().norm();
        // Steeper than one in a million the heading is of rounding, as for the force (`cutting` of kinetostat).
        if horizontal < 1e-6 {
            return Some(Self { tip: *tip, heading: Vector2::x(), horizontal: 0.0, vertical: unit.z.signum() });
        }
        Some(Self { tip: *tip, heading: unit.xy() / horizontal, horizontal, vertical: unit.z })
    }

    /// Position of the tip in the plan, and the direction of motion there.
    pub fn plan(&self) -> (Vector2<f64>, Vector2<f64>) {
        (self.tip.xy(), self.heading)
    }

    /// Height of the tip.
    pub fn height(&self) -> f64 {
        self.tip.z
    }

    fn point(&self, radius: f64, angle: f64) -> Vector2<f64> {
        let (sine, cosine) = libm::sincos(angle);
        let [fx, fy] = self.heading.into();
        self.tip.xy() + radius * Vector2::new(cosine * fx - sine * fy, cosine * fy + sine * fx)
    }

    /// Returns the largest |θ| at which a ring moves into material; `None` if it does nowhere.
    fn widest(&self, ring: &Ring) -> Option<f64> {
        let (across, along) = (ring.side * self.horizontal, ring.down * self.vertical);
        if across > along.abs() {
            return Some(libm::acos(along / across));
        }
        (along < 0.0).then_some(PI)
    }

    /// ∫ n · t dA over an arc of a ring, mm².
    pub fn volume(&self, ring: &Ring, arc: &Arc) -> f64 {
        ring.side * self.horizontal * (libm::sin(arc.to) - libm::sin(arc.from))
            - ring.down * self.vertical * (arc.to - arc.from)
    }

    /// Largest n · t in an arc of a ring.
    pub fn chip(&self, ring: &Ring, arc: &Arc) -> f64 {
        let foremost = libm::cos(0.0_f64.clamp(arc.from, arc.to));
        (ring.side * self.horizontal * foremost - ring.down * self.vertical) / norm(ring.side, ring.down)
    }
}

/// What is at a point of a ring.
#[derive(Debug, Clone, Copy)]
struct Sample {
    angle: f64,
    /// H there, and the move that made it.
    floor: f64,
    number: u32,
    /// Its intervals of stock in [`Samples::spans`].
    first: u32,
    end: u32,
}

/// Samples of a ring, by angle. Kept for all slices of the cylinder, which have the same points.
#[derive(Debug, Clone, Default)]
pub(crate) struct Samples {
    samples: Vec<Sample>,
    spans: Vec<[f64; 2]>,
    radius: f64,
}

impl Samples {
    /// Samples the points of a ring that move into material.
    pub fn fill(&mut self, field: &Field, ring: &Ring, front: &Front) {
        self.samples.clear();
        self.spans.clear();
        self.radius = ring.radius;
        let Some(widest) = front.widest(ring) else { return };
        let steps = (2.0 * widest / STEP).ceil().max(2.0);
        let at = |number: f64| -widest + 2.0 * widest * number / steps;
        let mut add = |angle: f64| {
            let sample = self.sample(field, front, angle);
            self.samples.push(sample);
        };
        add(-widest);
        NEAR_ENDS.iter().filter(|from_end| -widest + **from_end < at(1.0)).for_each(|from_end| add(-widest + from_end));
        (1..steps as u32).for_each(|number| add(at(f64::from(number))));
        NEAR_ENDS
            .iter()
            .rev()
            .filter(|from_end| widest - **from_end > at(steps - 1.0))
            .for_each(|from_end| add(widest - from_end));
        add(widest);
    }

    /// Samples the cylinder and returns the height above the tip up to which there is material.
    pub fn fill_side(&mut self, field: &Field, cutter: &Cutter, front: &Front) -> f64 {
        self.fill(field, &cutter.side_ring(0.0, 1.0), front);
        let bottom = front.tip.z + cutter.nose_height_mm();
        // Walls between the samples, where they are lowest.
        self.refine(field, bottom.max(field.stock.bounds().0.z) + 10.0 * TOUCH, front, true);
        let tops = self.samples.iter().map(|sample| self.top(sample, bottom) - front.tip.z);
        tops.fold(0.0, f64::max)
    }

    fn sample(&mut self, field: &Field, front: &Front, angle: f64) -> Sample {
        let p = front.point(self.radius, angle);
        let first = self.spans.len() as u32;
        field.stock.spans(p, &mut self.spans);
        let end = self.spans.len() as u32;
        let (floor, number) = if end == first {
            (f64::INFINITY, NONE)
        } else {
            let floor = field.floor(p);
            (floor.height, floor.number)
        };
        Sample { angle, floor, number, first, end }
    }

    fn spans_of(&self, sample: &Sample) -> &[[f64; 2]] {
        &self.spans[sample.first as usize..sample.end as usize]
    }

    fn is_material(&self, sample: &Sample, z: f64) -> bool {
        z < sample.floor - TOUCH && self.spans_of(sample).iter().any(|span| z > span[0] + TOUCH && z < span[1] - TOUCH)
    }

    /// Returns the height up to which there is material above `bottom`; minus infinity if there is none.
    fn top(&self, sample: &Sample, bottom: f64) -> f64 {
        let tops = self.spans_of(sample).iter().map(|span| (span[0], span[1].min(sample.floor)));
        tops.filter(|(low, top)| *top > low.max(bottom) + TOUCH)
            .fold(f64::NEG_INFINITY, |highest, span| highest.max(span.1))
    }

    /// Returns the arcs in which a ring is in material.
    pub fn arcs(&mut self, field: &Field, ring: &Ring, front: &Front, is_side: bool) -> impl Iterator<Item = Arc> {
        let z = front.tip.z + ring.height;
        self.refine(field, z, front, is_side);
        let samples = &*self;
        let mut next = 0;
        std::iter::from_fn(move || samples.next_arc(&mut next, z))
    }

    /// Adds samples until the ends of arcs at the height `z` are known.
    fn refine(&mut self, field: &Field, z: f64, front: &Front, is_side: bool) {
        let mut at = 0;
        while at + 1 < self.samples.len() {
            let (a, b) = (self.samples[at], self.samples[at + 1]);
            if self.is_between_unknown(field, [&a, &b], z, front, is_side) {
                let middle = self.sample(field, front, 0.5 * (a.angle + b.angle));
                self.samples.insert(at + 1, middle);
            } else {
                at += 1;
            }
        }
    }

    /// Whether between two neighbours an end of an arc, or a whole arc, may be.
    fn is_between_unknown(&self, field: &Field, [a, b]: [&Sample; 2], z: f64, front: &Front, is_side: bool) -> bool {
        let gap = b.angle - a.angle;
        match (self.is_material(a, z), self.is_material(b, z)) {
            (true, true) => false,
            (false, false) => {
                // Nothing is nearer to a sample than the rim of what was cut about it.
                is_side && gap > LEAST_ARC && {
                    let clear =
                        |sample: &Sample| field.clearance(sample.number, front.point(self.radius, sample.angle), z);
                    clear(a).max(0.0) + clear(b).max(0.0) < self.radius * gap
                }
            }
            _ => gap > END,
        }
    }

    /// Returns the first arc from the sample `next` on, and leaves there the sample behind it.
    fn next_arc(&self, next: &mut usize, z: f64) -> Option<Arc> {
        let is_material = |number: usize| self.is_material(&self.samples[number], z);
        let count = self.samples.len();
        let first = (*next..count).find(|number| is_material(*number))?;
        let end = (first..count).find(|number| !is_material(*number)).unwrap_or(count);
        *next = end;
        let middle = |a: usize, b: usize| 0.5 * (self.samples[a].angle + self.samples[b].angle);
        let from = if first == 0 { self.samples[0].angle } else { middle(first - 1, first) };
        let to = if end == count { self.samples[count - 1].angle } else { middle(end - 1, end) };
        (to > from).then_some(Arc { from, to })
    }

    /// Returns ∫ n · t dA over the cylinder above `nose`, from the heights of material at the samples, mm².
    pub fn side_volume(&self, radius: f64, nose: f64, front: &Front) -> f64 {
        let bottom = front.tip.z + nose;
        let height = |sample: &Sample| -> f64 {
            self.spans_of(sample).iter().map(|span| (span[1].min(sample.floor) - span[0].max(bottom)).max(0.0)).sum()
        };
        let between = |pair: &[Sample]| {
            let (from, to) = (pair[0].angle.max(-FRAC_PI_2), pair[1].angle.min(FRAC_PI_2));
            0.5 * (height(&pair[0]) + height(&pair[1])) * (libm::sin(to) - libm::sin(from))
        };
        radius * front.horizontal * self.samples.windows(2).map(between).sum::<f64>()
    }
}
