//! Regions of a part of the cutter over which its arcs are one, or nearly.

use std::f64::consts::{PI, TAU};

use crate::cutter::Part;
use crate::engagement::Arc;
use crate::profile::{Profile, Sample, View};
use crate::sweep::TOUCH;

/// Neighbouring samples nearer than this have an end of material between them where they differ, rad.
const JUMP: f64 = 2e-3 * PI / 180.0;
/// A region is one where its arcs, times its height, differ in sum over sectors by at most this share of the area from what is in material.
const OFF: f64 = 2e-4;
/// Within a sector arcs that grow or shrink by Δ (rad) over the height h of a region have an error of about h Δ²/24, which is at most a twenty-fourth of this share.
const SLIDE: f64 = 2e-3;
const SECTORS: usize = 24;

/// How a bound of material goes between two samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    /// Places of the part between which it goes.
    low: f64,
    high: f64,
    /// The angle over which it does, rad: positive where material is before it, seen from the axis or the tip.
    gap: f64,
    sector: usize,
}

impl Edge {
    /// Returns by how much arcs at the middle of a region, times its height, are less than what is in material there between the two samples; and where in it the bound goes.
    fn off(&self, [low, high]: [f64; 2]) -> (f64, [f64; 2]) {
        let (height, middle) = (high - low, 0.5 * (low + high));
        let (from, to) = (self.low.clamp(low, high), self.high.clamp(low, high));
        let width = self.high - self.low;
        let is_step = width <= TOUCH;
        let inside = if is_step { 1.0 } else { (to - from) / width };
        let above = if is_step { 0.0 } else { (self.high - to) / width };
        let right = inside * (0.5 * (from + to) - low) + above * height;
        let beyond = match is_step {
            true => f64::from(u8::from(from >= middle)),
            false => ((self.high - middle) / width).clamp(0.0, 1.0),
        };
        (self.gap * (right - beyond * height), [from, to])
    }
}

impl Profile {
    /// Whether material ends between two neighbours, and not where it goes on with other bounds.
    fn is_jump(&self, a: &Sample, b: &Sample) -> bool {
        self.intervals_of(a).len() != self.intervals_of(b).len()
            || (b.place.angle - a.place.angle < JUMP && self.difference(a, b) > TOUCH)
    }

    /// Puts into `found` the regions of the part from its axis, or its tip, on: bounded where the material has steps, and so small where it slopes that an integral
    /// over their arcs is known within about 0.2 %.
    pub fn regions(&mut self, found: &mut Vec<[f64; 2]>) {
        found.clear();
        let mut edges = std::mem::take(&mut self.edges);
        edges.clear();
        let all = || self.samples.iter().flat_map(|sample| self.intervals_of(sample));
        let low = all().fold(f64::INFINITY, |low, own| low.min(own[0]));
        let high = all().fold(f64::NEG_INFINITY, |high, own| high.max(own[1]));
        for pair in self.samples.windows(2).filter(|pair| !self.is_jump(&pair[0], &pair[1])) {
            let gap = pair[1].place.angle - pair[0].place.angle;
            let turned = (0.5 * (pair[0].place.angle + pair[1].place.angle) + PI) / TAU;
            let sector = (turned * SECTORS as f64) as usize % SECTORS;
            for (a, b) in self.intervals_of(&pair[0]).iter().zip(self.intervals_of(&pair[1])) {
                for (side, gap) in [-gap, gap].into_iter().enumerate() {
                    edges.push(Edge { low: a[side].min(b[side]), high: a[side].max(b[side]), gap, sector });
                }
            }
        }
        let area = self.area();
        if low < high && area > 0.0 {
            split(&edges, [low, high], area, found);
        }
        self.edges = edges;
    }

    /// Appends the arcs at a place of the part.
    pub fn arcs(&self, at: f64, arcs: &mut Vec<Arc>) {
        let is_in = |sample: &Sample| self.intervals_of(sample).iter().any(|own| own[0] < at && at < own[1]);
        let Some((first, last)) = self.samples.first().zip(self.samples.last()) else { return };
        let mut open = is_in(first).then_some(first.place.angle);
        for pair in self.samples.windows(2) {
            let is_end = is_in(&pair[1]);
            if is_in(&pair[0]) == is_end {
                continue;
            }
            let angle = self.crossing([&pair[0], &pair[1]], at);
            match open.take() {
                Some(from) => add_arc(from, angle, arcs),
                None => open = Some(angle),
            }
        }
        if let Some(from) = open {
            add_arc(from, last.place.angle, arcs);
        }
    }

    /// Returns the angle at which a bound passes a place of the part between two neighbours.
    fn crossing(&self, [a, b]: [&Sample; 2], at: f64) -> f64 {
        let (from, to) = (a.place.angle, b.place.angle);
        let middle = 0.5 * (from + to);
        if self.is_jump(a, b) {
            return middle;
        }
        let bounds = self.intervals_of(a).iter().zip(self.intervals_of(b));
        let mut bounds = bounds.flat_map(|(a, b)| [(a[0], b[0]), (a[1], b[1])]);
        let passing = bounds.find(|(a, b)| (*a < at) != (*b < at));
        passing.map_or(middle, |(a, b)| from + (to - from) * (at - a) / (b - a))
    }

    /// Returns ∫ n · t dA over what is in material, mm²; and of the end its area.
    pub fn volume(&self, view: &View<'_>) -> f64 {
        let shown = |sample: &Sample| {
            self.intervals_of(sample).iter().fold([0.0, 0.0], |sum, own| {
                let ring = view.cutter.ring(view.part, own[0], own[1]);
                [sum[0] + ring.side, sum[1] + ring.down]
            })
        };
        let [horizontal, vertical] = match view.part {
            Part::End => [0.0, -1.0],
            _ => [view.front.horizontal, view.front.vertical],
        };
        let between = |pair: &[Sample]| {
            let (from, to) = (&pair[0].place, &pair[1].place);
            let ([side_a, down_a], [side_b, down_b]) = (shown(&pair[0]), shown(&pair[1]));
            0.5 * ((side_a + side_b) * (to.direction.y - from.direction.y) * horizontal
                - (down_a + down_b) * (to.angle - from.angle) * vertical)
        };
        self.samples.windows(2).map(between).sum()
    }
}

/// Appends an arc, in two where it passes the angle behind the motion.
fn add_arc(from: f64, to: f64, arcs: &mut Vec<Arc>) {
    let mut add = |from: f64, to: f64| {
        if to > from {
            arcs.push(Arc { from, to });
        }
    };
    match (from < PI, to <= PI) {
        (_, true) => add(from, to),
        (true, false) => {
            add(from, PI);
            add(-PI, to - TAU);
        }
        (false, false) => add(from - TAU, to - TAU),
    }
}

/// Splits a region where what is in material is off its arcs the most, and halves it while its arcs grow or shrink too much.
fn split(edges: &[Edge], region: [f64; 2], area: f64, found: &mut Vec<[f64; 2]>) {
    let [low, high] = region;
    let (mut sectors, mut slid, mut most) = ([0.0; SECTORS], 0.0, (0.0, 0.0));
    for edge in edges.iter().filter(|edge| edge.high > low && edge.low < high) {
        let (off, [from, to]) = edge.off(region);
        sectors[edge.sector] += off;
        if edge.high - edge.low > TOUCH {
            slid += edge.gap.abs() * (to - from) / (edge.high - edge.low);
        }
        if off.abs() > most.0 {
            most = (off.abs(), 0.5 * (from + to));
        }
    }
    let off = sectors.iter().map(|own| own.abs()).sum::<f64>();
    let is_in = |at: f64| at > low + TOUCH && at < high - TOUCH;
    let at = match off > OFF * area && is_in(most.1) {
        true => most.1,
        false => 0.5 * (low + high),
    };
    let is_one = off <= OFF * area && (high - low) * slid * slid <= SLIDE * area;
    if is_one || !is_in(at) {
        found.push(region);
        return;
    }
    split(edges, [low, at], area, found);
    split(edges, [at, high], area, found);
}
