//! How near bodies come while their frames move, by conservative advancement.

use std::collections::BinaryHeap;

use nalgebra::{Isometry3, Point3};
use parry3d_f64::math::Pose;

use crate::{
    body::{Cell, Separation, pose},
    separation::Search,
};

/// A ball in a frame, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Its centre.
    pub centre_mm: Point3<f64>,
    /// Its radius.
    pub radius_mm: f64,
}

/// How the frames move, over a parameter from 0 to 1.
pub trait Motion {
    /// Writes the pose of each frame at `s`. `Err` with a reason where the machine has none.
    ///
    /// # Errors
    /// As above; the sweep ends with it.
    fn poses(&mut self, s: f64, poses: &mut [Isometry3<f64>]) -> Result<(), String>;

    /// Returns a bound of how far any point of `ball`, fixed to `frame`, moves between two parameters in `[from, to]`, mm for each 1 of the parameter:
    /// no point may be faster. It may be infinite where it is not known, and becomes finite on a shorter interval.
    fn speed(&mut self, frame: usize, ball: &Ball, interval: [f64; 2]) -> f64;
}

/// When a sweep ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepOptions {
    /// The least distance is found to within this, mm.
    pub tolerance_mm: f64,
    /// Whether it is less than this is told to within a ten-thousandth of a millimetre, mm.
    pub wanted_mm: f64,
    /// It ends as soon as a distance below this is certain, mm; minus infinity for the least distance whatever it is.
    pub enough_mm: f64,
    /// Distances certain to be at least this are not resolved, mm.
    pub beyond_mm: f64,
    /// Most states that are looked at.
    pub max_states: usize,
}

impl Default for SweepOptions {
    fn default() -> Self {
        let (wanted_mm, enough_mm, beyond_mm) = (f64::MIN_POSITIVE, f64::NEG_INFINITY, f64::INFINITY);
        Self { tolerance_mm: 0.1, wanted_mm, enough_mm, beyond_mm, max_states: 100_000 }
    }
}

/// How near the bodies come along a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearest {
    /// No distance along the motion is less, mm, as far as it was looked at.
    pub lower_mm: f64,
    /// Why it was not looked at any farther.
    pub end: SweepEnd,
    /// The nearest state that was looked at: its parameter, and the pair that is nearest there.
    pub at: Option<(f64, Separation)>,
    /// States that were looked at.
    pub states: usize,
    /// Searches for a distance of two convex pieces.
    pub searches: usize,
}

/// Why a sweep ended.
#[derive(Debug, Clone, PartialEq)]
pub enum SweepEnd {
    /// All of the motion was looked at.
    Whole,
    /// A distance is less than is enough.
    Enough,
    /// After the most states: bounds of the motion do not tell whether a pair comes nearer, as next to a singular place.
    Undecided,
    /// The reason for which a state is not known.
    Broken(String),
}

/// How finely it is told whether a distance is less than wanted, mm.
const FINE_MM: f64 = 1e-4;

/// An interval between states that is not cleared yet.
struct Open {
    /// No distance in it is less.
    lower: f64,
    interval: [f64; 2],
    /// Pairs with which this may be, by index.
    pairs: Vec<u32>,
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    // The least bound is looked at first, of equals the one that comes first.
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.lower.total_cmp(&self.lower).then_with(|| other.interval[0].total_cmp(&self.interval[0]))
    }
}

impl Cell {
    /// Returns how near the pairs of bodies come along `motion` of `frames` frames.
    pub fn sweep(&self, motion: &mut dyn Motion, frames: usize, options: &SweepOptions) -> Nearest {
        self.sweep_on(motion, frames, options, &mut Vec::new())
    }

    /// Sweeps a motion that goes on from where another ended. `margins_mm` has a lower bound of the distance of each pair there, in the order of
    /// [`pairs`](Self::pairs), or is empty, and gets those at its end. A pair that is too far apart to come near is not looked at.
    pub fn sweep_on(
        &self,
        motion: &mut dyn Motion,
        frames: usize,
        options: &SweepOptions,
        margins_mm: &mut Vec<f64>,
    ) -> Nearest {
        margins_mm.resize(self.pairs.len(), f64::NEG_INFINITY);
        let mut state = Sweep {
            cell: self,
            options,
            poses: vec![Isometry3::identity(); frames],
            fast: vec![Pose::IDENTITY; frames],
            search: Search::default(),
            found: Nearest { lower_mm: f64::INFINITY, end: SweepEnd::Whole, at: None, states: 0, searches: 0 },
        };
        if let Err(why) = state.all(motion, margins_mm) {
            state.found.end = SweepEnd::Broken(why);
            margins_mm.clear();
        }
        state.found.lower_mm = state.found.lower_mm.min(state.upper());
        state.found.searches = state.search.count;
        state.found
    }
}

struct Sweep<'a> {
    cell: &'a Cell,
    options: &'a SweepOptions,
    poses: Vec<Isometry3<f64>>,
    fast: Vec<Pose>,
    search: Search,
    found: Nearest,
}

impl Sweep<'_> {
    fn upper(&self) -> f64 {
        self.found.at.map_or(f64::INFINITY, |(_, own)| own.distance_mm)
    }

    /// A distance certain to be at least this is not of interest, mm.
    fn limit(&self) -> f64 {
        let (upper, SweepOptions { tolerance_mm, wanted_mm, beyond_mm, .. }) = (self.upper(), *self.options);
        let coarse = upper - tolerance_mm;
        let is_open = coarse < wanted_mm && upper >= wanted_mm;
        (if is_open { coarse.max(wanted_mm.min(upper - FINE_MM)) } else { coarse }).min(beyond_mm)
    }

    /// Looks at all of the motion, as far as is asked. `Err` with the reason of a state that it does not have.
    fn all(&mut self, motion: &mut dyn Motion, margins_mm: &mut [f64]) -> Result<(), String> {
        let mut near: Vec<u32> = Vec::new();
        for (pair, margin_mm) in (0..).zip(&mut *margins_mm) {
            let is_far = *margin_mm >= self.limit();
            let left = if is_far { *margin_mm - self.speed_of(motion, pair, [0.0, 1.0]) } else { f64::NEG_INFINITY };
            if left >= self.limit() {
                *margin_mm = left;
                self.found.lower_mm = self.found.lower_mm.min(left);
            } else {
                near.push(pair);
            }
        }
        if near.is_empty() {
            // That the machine does not make the motion is told whatever is near.
            return motion.poses(0.5, &mut self.poses);
        }
        self.look(motion, 0.0, &near)?;
        for (&pair, distance) in near.iter().zip(self.look(motion, 1.0, &near)?) {
            margins_mm[pair as usize] = distance;
        }
        let mut open = BinaryHeap::new();
        open.push(Open { lower: f64::NEG_INFINITY, interval: [0.0, 1.0], pairs: near });
        while let Some(next) = open.pop() {
            if next.lower >= self.limit() {
                self.found.lower_mm = self.found.lower_mm.min(next.lower);
                break;
            }
            if self.upper() < self.options.enough_mm || self.found.states >= self.options.max_states {
                let is_enough = self.upper() < self.options.enough_mm;
                self.found.end = if is_enough { SweepEnd::Enough } else { SweepEnd::Undecided };
                break;
            }
            self.split(motion, next, &mut open)?;
        }
        Ok(())
    }

    /// Looks at the state at `s` and returns the distance of each of `pairs`.
    fn look(&mut self, motion: &mut dyn Motion, s: f64, pairs: &[u32]) -> Result<Vec<f64>, String> {
        motion.poses(s, &mut self.poses)?;
        self.fast.iter_mut().zip(&self.poses).for_each(|(fast, own)| *fast = pose(own));
        self.found.states += 1;
        let mut distances = Vec::with_capacity(pairs.len());
        for &pair in pairs {
            let own = self.cell.separation(self.cell.pairs[pair as usize], &self.fast, f64::INFINITY, &mut self.search);
            if own.distance_mm < self.upper() {
                self.found.at = Some((s, own));
            }
            distances.push(own.distance_mm);
        }
        Ok(distances)
    }

    /// Looks at the middle of an interval and keeps of its halves what may be nearer than what is known.
    fn split(&mut self, motion: &mut dyn Motion, own: Open, open: &mut BinaryHeap<Open>) -> Result<(), String> {
        let [from, to] = own.interval;
        let middle = 0.5 * (from + to);
        let distances = self.look(motion, middle, &own.pairs)?;
        for interval in [[from, middle], [middle, to]] {
            let mut left = Open { lower: f64::INFINITY, interval, pairs: Vec::new() };
            let limit = self.limit();
            for (&pair, distance) in own.pairs.iter().zip(&distances) {
                let speed = self.speed_of(motion, pair, interval);
                let lower = (distance - speed * (interval[1] - interval[0])).max(own.lower);
                if lower < limit {
                    left.pairs.push(pair);
                    left.lower = left.lower.min(lower);
                } else {
                    self.found.lower_mm = self.found.lower_mm.min(lower);
                }
            }
            if !left.pairs.is_empty() {
                open.push(left);
            }
        }
        Ok(())
    }

    /// Returns a bound of how fast the distance of a pair changes in an interval, mm for each 1 of the parameter.
    fn speed_of(&self, motion: &mut dyn Motion, pair: u32, interval: [f64; 2]) -> f64 {
        let speed = |&body: &usize| {
            let body = &self.cell.bodies[body];
            let (centre_mm, radius_mm) = body.ball();
            motion.speed(body.frame, &Ball { centre_mm, radius_mm }, interval)
        };
        self.cell.pairs[pair as usize].iter().map(speed).sum()
    }
}
