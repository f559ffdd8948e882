//! What of a part of the cutter is in material, by angle: sampled until it is known in between.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Vector2, Vector3};

use crate::cutter::{Cutter, Part, Ring};
use crate::engagement::Arc;
use crate::field::{Field, NONE};
use crate::regions::Edge;
use crate::surface::{Floor, LEVEL};
use crate::sweep::{TOUCH, norm};

const DEGREE: f64 = PI / 180.0;
/// Ends of arcs on the cylinder are found within this.
const END: f64 = 1e-3 * DEGREE;
/// Step of the samples before any are added.
const STEP: f64 = 5.0 * DEGREE;
/// Widest arc of material that may be missed at the ends of the angles that move into material: there walls beside the path begin.
const LEAST_END: f64 = 0.25 * DEGREE;
/// Widest arc of material on the cylinder that may be missed.
const LEAST_ARC: f64 = 0.5 * DEGREE;
/// Fewest samples over the angles at which corner, point or end may touch material.
const LEAST_LINES: f64 = 8.0;
/// Doubt between two samples, as a share of the area of the part in material: where the material bends, and where it ends on corner, point or end.
const BENT: f64 = 1e-3;
const ENDED: f64 = 5e-3;
/// Ends on a line are known within this share of the step along it.
const ON_LINE: f64 = 2e-3;
/// Times that the surface is sought to come out of material between places on a line: what is narrower than a sixteenth of their distance may be missed.
const CREST_ROUNDS: u32 = 4;
/// What stands between two samples, and rises less above both than this share of the depth, may be missed where no more of it can be excluded.
const LEAST_RISE: f64 = 0.1;

/// A direction is across the motion up to this, as the cosine of the angle.
const ACROSS: f64 = 1e-9;

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
        // Nor is a motion that is so nearly level anything but level.
        let vertical = if unit.z.abs() < LEVEL { 0.0 } else { unit.z };
        Some(Self { tip: *tip, heading: unit.xy() / horizontal, horizontal, vertical })
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

    /// Largest n · t in an arc of a ring.
    pub fn chip(&self, ring: &Ring, arc: &Arc) -> f64 {
        let foremost = libm::cos(0.0_f64.clamp(arc.from, arc.to));
        (ring.side * self.horizontal * foremost - ring.down * self.vertical) / norm(ring.side, ring.down)
    }
}

/// An angle about the cutter's axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub angle: f64,
    /// Its cosine and sine.
    pub direction: Vector2<f64>,
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

/// What is in material at an angle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub place: Place,
    /// A move that cut what is in air there.
    number: u32,
    /// Its intervals in [`Profile::intervals`].
    first: u32,
    end: u32,
    /// Whether there is no stock.
    is_beside: bool,
    /// Whether bounds go straight to those of the next sample.
    pub is_straight: bool,
}

/// A part of a cutter's surface on its way through a field.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub field: &'a Field,
    pub cutter: &'a Cutter,
    pub front: &'a Front,
    pub part: Part,
    /// Places of the part between which it may be in material.
    pub range: [f64; 2],
}

/// What of a part is in material, by angle. Between two samples it is as on the nearer one, or its bounds go straight.
#[derive(Debug, Clone, Default)]
pub(crate) struct Profile {
    pub samples: Vec<Sample>,
    pub intervals: Vec<[f64; 2]>,
    /// Where there are samples of the cylinder before any are added.
    places: Vec<Place>,
    spans: Vec<[f64; 2]>,
    /// How far places of the line that was looked at last are at least inside what was cut, mm.
    clear: f64,
    /// How the bounds go, for [`Profile::regions`].
    pub edges: Vec<Edge>,
}

impl View<'_> {
    /// Returns the part of its range that moves into material at an angle; `None` if none does.
    fn moving(&self, place: &Place) -> Option<[f64; 2]> {
        let [from, to] = self.range;
        // Across the motion the sign is of rounding.
        let forward = if place.direction.x.abs() < ACROSS { ACROSS } else { place.direction.x };
        let across = forward * self.front.horizontal;
        let vertical = self.front.vertical;
        let moving = match self.part {
            Part::Nose if across > 0.0 && vertical > 0.0 => [self.cutter.nose_share_below(vertical / across), 1.0],
            Part::Nose if across < 0.0 && vertical < 0.0 => [0.0, self.cutter.nose_share_below(vertical / across)],
            Part::Nose if across <= 0.0 && vertical >= 0.0 => return None,
            _ => [from, to],
        };
        let (from, to) = (from.max(moving[0]), to.min(moving[1]));
        (from < to).then_some([from, to])
    }
}

impl Profile {
    pub fn intervals_of(&self, sample: &Sample) -> &[[f64; 2]] {
        &self.intervals[sample.first as usize..sample.end as usize]
    }

    /// Sum of the lengths of what is in material at a sample.
    pub fn length(&self, sample: &Sample) -> f64 {
        self.intervals_of(sample).iter().map(|own| own[1] - own[0]).sum()
    }

    fn clear(&mut self) {
        self.samples.clear();
        self.intervals.clear();
    }

    /// Samples the cylinder within a range of heights, from −90° to 90° of the motion.
    pub fn fill_side(&mut self, view: &View<'_>) {
        self.clear();
        if view.front.horizontal == 0.0 {
            return;
        }
        if self.places.is_empty() {
            let steps = (PI / STEP).round();
            self.places.extend((0..=steps as u32).map(|k| Place::new(PI * f64::from(k) / steps - FRAC_PI_2)));
        }
        let mut clear_to = f64::NEG_INFINITY;
        for number in 0..self.places.len() {
            let place = self.places[number];
            if place.angle <= clear_to {
                continue;
            }
            let guess = self.samples.last().map_or(NONE, |sample| sample.number);
            let sample = self.sample(view, &place, guess);
            self.samples.push(sample);
            // What one move has cut about a sample needs no more.
            if sample.first == sample.end && sample.number != NONE {
                let p = view.front.point(view.cutter.radius, &place);
                let clear = view.field.clearance(sample.number, p, view.front.tip.z + view.range[0]);
                clear_to = place.angle + clear / view.cutter.radius;
            }
        }
        self.refine(view);
    }

    /// Samples corner, point or end between two angles along so many steps, and once more over less of its range where that is enough.
    pub fn fill_lines(&mut self, view: &View<'_>, angles: [f64; 2], steps: u32) {
        self.lay_lines(view, angles, steps);
        let [from, to] = view.range;
        let step = (to - from) / f64::from(steps);
        let low = self.intervals.iter().fold(to, |low, own| low.min(own[0]));
        let high = self.intervals.iter().fold(from, |high, own| high.max(own[1]));
        let near = View { range: [(low - step).max(from), (high + step).min(to)], ..*view };
        if low < high && 2.0 * (near.range[1] - near.range[0]) < to - from {
            self.lay_lines(&near, angles, steps);
            self.refine_lines(&near, steps);
        } else {
            self.refine_lines(view, steps);
        }
    }

    fn lay_lines(&mut self, view: &View<'_>, [low, high]: [f64; 2], steps: u32) {
        self.clear();
        let count = ((high - low) / STEP).ceil().max(LEAST_LINES);
        let mut clear_to = f64::NEG_INFINITY;
        for number in 0..=count as u32 {
            let angle = low + (high - low) * f64::from(number) / count;
            if angle <= clear_to {
                continue;
            }
            let place = Place::new(angle);
            self.clear = f64::INFINITY;
            let guess = self.samples.last().map_or(NONE, |sample| sample.number);
            let sample = self.sample_line(view, &place, guess, steps);
            self.samples.push(sample);
            // As on the cylinder, where all of the line was cut and its range is the same at all angles.
            if sample.first == sample.end && view.front.vertical == 0.0 && self.clear.is_finite() {
                clear_to = angle + self.clear / view.cutter.radius;
            }
        }
    }

    /// Samples the cylinder at a place, at which the move `guess` may have cut.
    fn sample(&mut self, view: &View<'_>, place: &Place, guess: u32) -> Sample {
        let View { field, cutter, front, range: [from, _], .. } = *view;
        let p = front.point(cutter.radius, place);
        self.spans.clear();
        field.stock.spans(p, &mut self.spans);
        let first = self.intervals.len() as u32;
        let is_beside = self.spans.is_empty();
        let lowest = front.tip.z + from;
        let mut floor = if is_beside {
            Floor { height: f64::INFINITY, number: NONE }
        } else if guess != NONE && field.clearance(guess, p, lowest) > cutter.radius * STEP {
            Floor { height: lowest, number: guess }
        } else {
            field.floor_from(p, guess, lowest)
        };
        for span in &self.spans {
            let (low, high) = (span[0].max(lowest), span[1].min(floor.height));
            if high > low + TOUCH {
                self.intervals.push([low - front.tip.z, high - front.tip.z]);
            }
        }
        // What passed above the stock cut nothing.
        if self.spans.last().is_some_and(|last| floor.height >= last[1]) {
            floor.number = NONE;
        }
        let end = self.intervals.len() as u32;
        Sample { place: *place, number: floor.number, first, end, is_beside, is_straight: false }
    }

    /// Samples corner, point or end at a place, along so many steps of its range.
    fn sample_line(&mut self, view: &View<'_>, place: &Place, guess: u32, steps: u32) -> Sample {
        let first = self.intervals.len() as u32;
        let mut number = guess;
        if let Some([from, to]) = view.moving(place) {
            let share = (to - from) / (view.range[1] - view.range[0]);
            let steps = (f64::from(steps) * share).ceil().max(2.0);
            let tolerance = ON_LINE * (to - from) / steps;
            let mut last = (from, self.depth(view, place, from, &mut number));
            let mut before = (from, f64::NEG_INFINITY);
            let mut open = (last.1 > 0.0).then_some(from);
            for step in 1..=steps as u32 {
                let at = from + (to - from) * f64::from(step) / steps;
                let next = (at, self.depth(view, place, at, &mut number));
                // It may come out next to the ends of the line, too.
                if step == 1 {
                    before = (from, next.1);
                }
                if let Some(own) = self.crest(view, place, [before, last, next], tolerance, &mut number) {
                    self.intervals.push(own);
                }
                if (last.1 > 0.0) != (next.1 > 0.0) {
                    let end = self.line_end(view, place, [last, next], tolerance, &mut number);
                    match open.take() {
                        Some(start) => self.intervals.push([start, end]),
                        None => open = Some(end),
                    }
                }
                (before, last) = (last, next);
            }
            if let Some(own) = self.crest(view, place, [before, last, (to, before.1)], tolerance, &mut number) {
                self.intervals.push(own);
            }
            if let Some(start) = open {
                self.intervals.push([start, to]);
            }
        }
        let end = self.intervals.len() as u32;
        Sample { place: *place, number, first, end, is_beside: false, is_straight: false }
    }

    /// Returns what is in material about the highest of three places on a line in air, where the surface may come out of it between them; `None` if
    /// it is not seen to.
    fn crest(
        &mut self,
        view: &View<'_>,
        place: &Place,
        mut near: [(f64, f64); 3],
        tolerance: f64,
        number: &mut u32,
    ) -> Option<[f64; 2]> {
        let [low, top, high] = near.map(|own| own.1);
        let may_come = low < top && high <= top && top <= 0.0 && 2.0 * top > low.min(high);
        let rounds = if may_come { CREST_ROUNDS } else { 0 };
        for _ in 0..rounds {
            let mut halfway = |a: (f64, f64), b: (f64, f64)| {
                let at = 0.5 * (a.0 + b.0);
                (at, self.depth(view, place, at, number))
            };
            let [low, top, high] = near;
            let all = [low, halfway(low, top), top, halfway(top, high), high];
            if let Some(first) = all.iter().position(|own| own.1 > 0.0) {
                let last = if all[3].1 > 0.0 { 3 } else { first };
                let start = self.line_end(view, place, [all[first - 1], all[first]], tolerance, number);
                let end = self.line_end(view, place, [all[last], all[last + 1]], tolerance, number);
                return Some([start, end]);
            }
            let best = (1..4).fold(2, |best, k| if all[k].1 > all[best].1 { k } else { best });
            near = [all[best - 1], all[best], all[best + 1]];
        }
        None
    }

    /// Returns how far a place of the surface is below what is left there, or above what is below it, mm; and puts the number of the move that left it.
    fn depth(&mut self, view: &View<'_>, place: &Place, at: f64, number: &mut u32) -> f64 {
        let (radius, height) = view.cutter.place(view.part, at);
        let (p, z) = (view.front.point(radius, place), view.front.tip.z + height);
        self.spans.clear();
        view.field.stock.spans(p, &mut self.spans);
        if self.spans.is_empty() {
            self.clear = f64::NEG_INFINITY;
            return f64::NEG_INFINITY;
        }
        let floor = view.field.floor_from(p, *number, z);
        *number = floor.number;
        let inside = self.spans.iter().map(|span| (span[1].min(floor.height) - z).min(z - span[0]));
        let depth = inside.fold(f64::NEG_INFINITY, f64::max) - TOUCH;
        let is_cut = depth <= 0.0 && floor.number != NONE;
        let clear = if is_cut { view.field.clearance(floor.number, p, z) } else { f64::NEG_INFINITY };
        self.clear = self.clear.min(clear);
        depth
    }

    /// Returns where on a line material ends between two places of it, given how deep they are in it.
    fn line_end(
        &mut self,
        view: &View<'_>,
        place: &Place,
        [mut a, mut b]: [(f64, f64); 2],
        tolerance: f64,
        number: &mut u32,
    ) -> f64 {
        let small = 1e-3 * a.1.abs().min(b.1.abs());
        for round in 0..16 {
            if (b.0 - a.0).abs() <= tolerance {
                break;
            }
            let share = a.1 / (a.1 - b.1);
            // A floor may end in a wall.
            let share = if round % 3 == 2 || !share.is_finite() { 0.5 } else { share.clamp(0.02, 0.98) };
            let at = a.0 + share * (b.0 - a.0);
            let middle = (at, self.depth(view, place, at, number));
            if middle.1.abs() < small {
                return at;
            }
            *(if (middle.1 > 0.0) == (a.1 > 0.0) { &mut a } else { &mut b }) = middle;
        }
        0.5 * (a.0 + b.0)
    }

    /// ∫ of lengths over the angle.
    pub fn area(&self) -> f64 {
        let between = |pair: &[Sample]| {
            0.5 * (self.length(&pair[0]) + self.length(&pair[1])) * (pair[1].place.angle - pair[0].place.angle)
        };
        self.samples.windows(2).map(between).sum()
    }

    /// Returns how far bounds at two samples differ in sum; of different intervals, all that is there.
    pub fn difference(&self, a: &Sample, b: &Sample) -> f64 {
        let (own, other) = (self.intervals_of(a), self.intervals_of(b));
        if own.len() != other.len() {
            return self.length(a) + self.length(b);
        }
        own.iter().zip(other).map(|(a, b)| (a[0] - b[0]).abs() + (a[1] - b[1]).abs()).sum()
    }

    /// Whether bounds go straight from one sample over another, at half of the way, to a third, but for a `least` area.
    fn is_straight(&self, [a, m, b]: [&Sample; 3], least: f64) -> bool {
        let [a_own, m_own, b_own] = [a, m, b].map(|sample| self.intervals_of(sample));
        if a_own.len() != m_own.len() || b_own.len() != m_own.len() {
            return false;
        }
        let off = |k: usize, side: usize| (m_own[k][side] - 0.5 * (a_own[k][side] + b_own[k][side])).abs();
        let sum: f64 = (0..m_own.len()).map(|k| off(k, 0) + off(k, 1)).sum();
        sum * (b.place.angle - a.place.angle) <= least
    }

    /// Adds samples halfway between two until what is in material between them is known.
    fn refine_lines(&mut self, view: &View<'_>, steps: u32) {
        let area = self.area();
        let mut at = 0;
        while at + 1 < self.samples.len() {
            let (a, b) = (self.samples[at], self.samples[at + 1]);
            let gap = b.place.angle - a.place.angle;
            if a.is_straight || gap <= END || self.difference(&a, &b) * gap <= ENDED * area {
                at += 1;
                continue;
            }
            let middle = self.sample_line(view, &a.place.halfway(&b.place), a.number, steps);
            self.insert(at, [&a, &middle, &b], BENT * area);
        }
    }

    fn insert(&mut self, at: usize, [a, middle, b]: [&Sample; 3], least: f64) {
        self.samples.insert(at + 1, *middle);
        let is_straight = self.is_straight([a, middle, b], least);
        self.samples[at].is_straight = is_straight;
        self.samples[at + 1].is_straight = is_straight;
    }

    /// Adds samples of the cylinder until ends of material, at all heights, are known.
    fn refine(&mut self, view: &View<'_>) {
        let area = self.area();
        let top = self.samples.iter().map(|sample| self.top(view, sample)).fold(view.range[0], f64::max);
        let rise = (LEAST_RISE * (top - view.range[0])).max(10.0 * TOUCH);
        let (mut at, mut is_halved) = (0, true);
        while at + 1 < self.samples.len() {
            let (a, b) = (self.samples[at], self.samples[at + 1]);
            let gap = b.place.angle - a.place.angle;
            let difference = self.difference(&a, &b);
            let is_known = a.is_straight || gap <= END || difference <= TOUCH || difference * gap <= 0.1 * BENT * area;
            if is_known && !self.may_hide(view, [&a, &b], rise) {
                (at, is_halved) = (at + 1, true);
                continue;
            }
            let rim = if is_known || !is_halved { None } else { self.rim(view, [&a, &b]) };
            is_halved = rim.is_none();
            match rim {
                // The rim of what the lower move cut is mostly the end.
                Some((places, number)) => {
                    for place in places {
                        if place.angle > a.place.angle && place.angle < self.samples[at + 1].place.angle {
                            let sample = self.sample(view, &place, number);
                            self.samples.insert(at + 1, sample);
                        }
                    }
                }
                None => {
                    let middle = self.sample(view, &a.place.halfway(&b.place), a.number);
                    self.insert(at, [&a, &middle, &b], BENT * area);
                }
            }
        }
    }

    /// Height up to which there is material at a sample of the cylinder.
    fn top(&self, view: &View<'_>, sample: &Sample) -> f64 {
        self.intervals_of(sample).last().map_or(view.range[0], |last| last[1])
    }

    /// Returns places on both sides of the rim of what the move at the lower one of two samples cut, the second first, and its number; `None` if the rim is not between them.
    fn rim(&self, view: &View<'_>, [a, b]: [&Sample; 2]) -> Option<([Place; 2], u32)> {
        let View { field, cutter, front, .. } = view;
        let (top_a, top_b) = (self.top(view, a), self.top(view, b));
        let is_rising = top_b > top_a;
        let (low, high) = if is_rising { (a, b) } else { (b, a) };
        let middle = front.tip.z + 0.5 * (top_a + top_b);
        let reach = |place: &Place| field.reach(low.number, front.point(cutter.radius, place)).height;
        if low.number == NONE || (top_a - top_b).abs() <= TOUCH {
            return None;
        }
        // A floor that goes on below the higher one has no rim here, nor has one that rises to it.
        if reach(&low.place) > middle || reach(&high.place) <= front.tip.z + top_a.max(top_b) + TOUCH {
            return None;
        }
        let (mut from, mut to) = (a.place, b.place);
        while to.angle - from.angle > END {
            let between = from.halfway(&to);
            let is_cut = reach(&between) <= middle;
            *(if is_cut == is_rising { &mut from } else { &mut to }) = between;
        }
        Some(([to, from], low.number))
    }

    /// Whether material that is higher than both of two neighbours may stand between them.
    fn may_hide(&self, view: &View<'_>, [a, b]: [&Sample; 2], rise: f64) -> bool {
        let gap = b.place.angle - a.place.angle;
        let from_end = FRAC_PI_2 - a.place.angle.abs().max(b.place.angle.abs());
        let is_end = gap > (1.01 * from_end).max(LEAST_END);
        // Nothing is nearer to a sample than the rim of what was cut about it; the side of the stock may be.
        (is_end || gap > LEAST_ARC) && {
            let above = view.front.tip.z + self.top(view, a).max(self.top(view, b)) + rise;
            let is_beside = |sample: &Sample| is_end && sample.is_beside;
            let clear = |sample: &Sample| {
                let p = view.front.point(view.cutter.radius, &sample.place);
                view.field.clearance_above(sample.number, p, above).max(0.0)
            };
            is_beside(a) || is_beside(b) || clear(a) + clear(b) < view.cutter.radius * gap
        }
    }
}
