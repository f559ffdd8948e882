//! Rings of the cutter's surface, sampled in angle.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Vector2, Vector3};

use crate::cutter::{Cutter, Ring};
use crate::engagement::Arc;
use crate::field::{Field, NONE};
use crate::surface::Floor;
use crate::sweep::{TOUCH, norm};

const DEGREE: f64 = PI / 180.0;
/// Ends of arcs are found within this.
const END: f64 = 1e-3 * DEGREE;
/// Step of the samples before any are added.
const STEP: f64 = 5.0 * DEGREE;
/// Widest arc of material that may be missed at the ends of the angles that move into material: there walls beside the path begin.
const LEAST_END: f64 = 0.25 * DEGREE;
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

    fn point(&self, radius: f64, place: &Place) -> Vector2<f64> {
        let ([cosine, sine], [fx, fy]) = (place.direction.into(), self.heading.into());
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

/// A place on a ring.
#[derive(Debug, Clone, Copy)]
struct Place {
    angle: f64,
    /// Its cosine and sine.
    direction: Vector2<f64>,
}

impl Place {
    fn new(angle: f64) -> Self {
        let (sine, cosine) = libm::sincos(angle);
        Self { angle, direction: Vector2::new(cosine, sine) }
    }

    /// Returns the place halfway to another, less than half a turn away.
    fn halfway(&self, other: &Self) -> Self {
        let sum = self.direction + other.direction;
        Self { angle: 0.5 * (self.angle + other.angle), direction: sum / norm(sum.x, sum.y) }
    }
}

/// What is at a point of a ring.
#[derive(Debug, Clone, Copy)]
struct Sample {
    place: Place,
    /// H there, or a height at or below the lowest of the ring that was cut to, and the move that made it.
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
    /// Where there are samples before any are added.
    places: Vec<Place>,
    spans: Vec<[f64; 2]>,
    radius: f64,
    /// The lowest height that is asked for: which of the moves that cut deeper cut deepest is all the same.
    lowest: f64,
    /// Whether they are of the cylinder, where higher slices are asked for as well.
    is_side: bool,
}

impl Samples {
    /// Whether a ring touches material.
    pub fn touches(&mut self, field: &Field, ring: &Ring, front: &Front) -> bool {
        self.fill(field, ring, front, |_| None);
        self.samples.iter().any(|sample| self.is_material(sample, self.lowest))
    }

    /// Samples the points of a ring that move into material. Of angles that are `known` to be in material or not no point is looked at.
    pub fn fill(&mut self, field: &Field, ring: &Ring, front: &Front, known: impl Fn(f64) -> Option<bool>) {
        (self.is_side, self.lowest) = (ring.run == 0.0, front.tip.z + ring.height);
        self.samples.clear();
        self.spans.clear();
        // That of what is known.
        self.spans.push([f64::NEG_INFINITY, f64::INFINITY]);
        self.radius = ring.radius;
        let Some(widest) = front.widest(ring) else { return };
        self.place(widest);
        let mut clear_to = f64::NEG_INFINITY;
        for number in 0..self.places.len() {
            let place = self.places[number];
            if place.angle <= clear_to {
                continue;
            }
            if let Some(is_material) = known(place.angle) {
                let floor = if is_material { f64::INFINITY } else { f64::NEG_INFINITY };
                self.samples.push(Sample { place, floor, number: NONE, first: 0, end: 1 });
                continue;
            }
            let guess = self.samples.last().map_or(NONE, |sample| sample.number);
            let sample = self.sample(field, front, &place, guess);
            self.samples.push(sample);
            // What one move has cut about a sample needs no more.
            if sample.floor <= self.lowest {
                clear_to = place.angle + self.clear(field, front, &sample, self.lowest) / ring.radius;
            }
        }
    }

    /// Makes the places to sample between −`widest` and `widest`, if they are not those of the ring before.
    fn place(&mut self, widest: f64) {
        if self.places.last().is_some_and(|last| last.angle == widest) {
            return;
        }
        let steps = (2.0 * widest / STEP).ceil().max(2.0);
        let at = |number: f64| -widest + 2.0 * widest * number / steps;
        self.places.clear();
        self.places.extend((0..steps as u32).map(|number| Place::new(at(f64::from(number)))));
        self.places.push(Place::new(widest));
    }

    /// Samples the cylinder and returns the height above the tip up to which there is material.
    pub fn fill_side(&mut self, field: &Field, cutter: &Cutter, front: &Front) -> f64 {
        let bottom = front.tip.z + cutter.nose_height_mm();
        if bottom >= field.stock.bounds().1.z {
            return 0.0;
        }
        let lowest = bottom.max(field.stock.bounds().0.z) - front.tip.z;
        self.fill(field, &cutter.side_ring(lowest - 0.5, lowest + 0.5), front, |_| None);
        // Walls between the samples, where they are lowest.
        self.refine(field, self.lowest + 10.0 * TOUCH, front);
        let tops = self.samples.iter().map(|sample| self.top(sample, bottom) - front.tip.z);
        tops.fold(0.0, f64::max)
    }

    /// How far a sample is, at the height `z`, inside what its move cut, mm.
    fn clear(&self, field: &Field, front: &Front, sample: &Sample, z: f64) -> f64 {
        field.clearance(sample.number, front.point(self.radius, &sample.place), z)
    }

    /// Samples a place, at which the move `guess` may have cut.
    fn sample(&mut self, field: &Field, front: &Front, place: &Place, guess: u32) -> Sample {
        let p = front.point(self.radius, place);
        let first = self.spans.len() as u32;
        field.stock.spans(p, &mut self.spans);
        let end = self.spans.len() as u32;
        let floor = if end == first {
            Floor { height: f64::INFINITY, number: NONE }
        } else if guess != NONE && field.clearance(guess, p, self.lowest) > self.radius * STEP {
            Floor { height: self.lowest, number: guess }
        } else {
            field.floor_from(p, guess, self.lowest)
        };
        Sample { place: *place, floor: floor.height, number: floor.number, first, end }
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
    pub fn arcs(&mut self, field: &Field, ring: &Ring, front: &Front) -> impl Iterator<Item = Arc> {
        let z = front.tip.z + ring.height;
        self.refine(field, z, front);
        let samples = &*self;
        let mut next = 0;
        std::iter::from_fn(move || samples.next_arc(&mut next, z))
    }

    /// Adds samples until the ends of arcs at the height `z` are known.
    fn refine(&mut self, field: &Field, z: f64, front: &Front) {
        let (mut at, mut is_halved) = (0, true);
        while at + 1 < self.samples.len() {
            let (a, b) = (self.samples[at], self.samples[at + 1]);
            if !self.is_between_unknown(field, [&a, &b], z, front) {
                (at, is_halved) = (at + 1, true);
                continue;
            }
            let (mut from, mut to) = (a.place, b.place);
            let is_rising = self.is_material(&b, z);
            // The rim of what the move in air cut is mostly the end. If not, halving goes on from there.
            let air = if is_rising { a } else { b };
            is_halved =
                !is_halved || self.is_material(&a, z) == is_rising || air.number == NONE || air.floor > z + TOUCH;
            while !is_halved && to.angle - from.angle > END {
                let middle = from.halfway(&to);
                let is_cut = field.reach(air.number, front.point(self.radius, &middle)).height <= z + TOUCH;
                *(if is_cut == is_rising { &mut from } else { &mut to }) = middle;
            }
            for place in if is_halved { [from.halfway(&to); 2] } else { [to, from] } {
                if place.angle > a.place.angle && place.angle < self.samples[at + 1].place.angle {
                    let sample = self.sample(field, front, &place, air.number);
                    self.samples.insert(at + 1, sample);
                }
            }
        }
    }

    /// Whether between two neighbours an end of an arc, or a whole arc, may be.
    fn is_between_unknown(&self, field: &Field, [a, b]: [&Sample; 2], z: f64, front: &Front) -> bool {
        let gap = b.place.angle - a.place.angle;
        match (self.is_material(a, z), self.is_material(b, z)) {
            (true, true) => false,
            (false, false) => {
                let widest = self.places.last().map_or(0.0, |last| last.angle);
                let from_end = widest - a.place.angle.abs().max(b.place.angle.abs());
                let least = if self.is_side { LEAST_ARC } else { f64::INFINITY };
                let is_end = gap > (1.01 * from_end).max(LEAST_END);
                // Nothing is nearer to a sample than the rim of what was cut about it; the side of the stock may be.
                (is_end || gap > least) && {
                    let is_beside = |sample: &Sample| is_end && sample.first == sample.end;
                    let clear = |sample: &Sample| self.clear(field, front, sample, z).max(0.0);
                    is_beside(a) || is_beside(b) || clear(a) + clear(b) < self.radius * gap
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
        let middle = |a: usize, b: usize| 0.5 * (self.samples[a].place.angle + self.samples[b].place.angle);
        let from = if first == 0 { self.samples[0].place.angle } else { middle(first - 1, first) };
        let to = if end == count { self.samples[count - 1].place.angle } else { middle(end - 1, end) };
        (to > from).then_some(Arc { from, to })
    }

    /// Returns ∫ n · t dA over the cylinder above `nose`, from the heights of material at the samples, mm².
    pub fn side_volume(&self, radius: f64, nose: f64, front: &Front) -> f64 {
        let bottom = front.tip.z + nose;
        let height = |sample: &Sample| -> f64 {
            self.spans_of(sample).iter().map(|span| (span[1].min(sample.floor) - span[0].max(bottom)).max(0.0)).sum()
        };
        let between = |pair: &[Sample]| {
            let (from, to) = (pair[0].place.angle.max(-FRAC_PI_2), pair[1].place.angle.min(FRAC_PI_2));
            0.5 * (height(&pair[0]) + height(&pair[1])) * (libm::sin(to) - libm::sin(from))
        };
        radius * front.horizontal * self.samples.windows(2).map(between).sum::<f64>()
    }
}
