//! The machined surface, evaluated from the lines that generate it.

use nalgebra::{Vector2, Vector3};

use crate::field::{Column, Field, KEPT, NONE};
use crate::sweep::Reach;

/// A point of the machined surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Where it is, frame of the workpiece, mm.
    pub position: Vector3<f64>,
    /// Unit normal out of the material, that of the cutter at the point reversed; up under a flat end.
    pub normal: Vector3<f64>,
    /// What the caller called the move that made it.
    pub tag: u32,
    /// Where the tip of its cutter was, mm.
    pub tip: Vector3<f64>,
}

/// H at a point of the plan, and what made it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Floor {
    /// H, mm; infinite where no cutter came.
    pub height: f64,
    /// Number of the move that made it; [`NONE`] where no cutter came.
    pub number: u32,
}

/// Runs of consecutive moves that were tried at a point: at most those of nine columns and one more.
struct Tried {
    runs: [(u32, u32); 9 * KEPT + 1],
    count: usize,
}

/// The best move so far: covering before not, then lower, then nearer.
#[derive(Clone, Copy)]
struct Best {
    reach: Reach,
    number: u32,
}

/// Heights that differ by less are one, mm: level moves of one depth.
pub(crate) const LEVEL: f64 = 1e-9;
/// Moves beyond one that is no better at which the walk still looks.
const LOOK_AHEAD: u32 = 2;

/// Whether `a` is a better maker of the surface than `b`: lower, or as low and nearer.
#[inline]
fn is_better(a: &Reach, b: &Reach) -> bool {
    // Where both are infinite the first test is of NaN and false.
    if a.height < b.height - LEVEL {
        return true;
    }
    if a.height > b.height + LEVEL {
        return false;
    }
    a.squared < b.squared
}

impl Field {
    /// Returns the point of the machined surface over (x, y) = `p`; `None` where no cutter came. Whether the stock reaches up to it is not asked.
    #[must_use]
    pub fn surface(&self, p: Vector2<f64>) -> Option<SurfacePoint> {
        let floor = self.floor(p);
        if floor.number == NONE {
            return None;
        }
        let sweep = &self.moves[floor.number as usize];
        let cutter = &self.cutters[sweep.cutter as usize];
        let tip = sweep.position(sweep.generating(cutter, p));
        let position = Vector3::new(p.x, p.y, floor.height);
        Some(SurfacePoint { position, normal: -cutter.normal(&(position - tip)), tag: sweep.tag, tip })
    }

    /// Returns H at `p` and the move that made it.
    ///
    /// The columns about `p` name moves; from each the walk goes along consecutive moves while they are better at `p`.
    pub(crate) fn floor(&self, p: Vector2<f64>) -> Floor {
        self.floor_from(p, NONE, f64::NEG_INFINITY)
    }

    /// Returns H at `p` and the move that made it as [`Field::floor`], or any move that cut as low as `enough`, looking first at the move `guess`.
    pub(crate) fn floor_from(&self, p: Vector2<f64>, guess: u32, enough: f64) -> Floor {
        let [x, y] = self.grid.cell(p);
        if let Some(floor) = self.level_floor(x, y) {
            return floor;
        }
        let mut tried = Tried { runs: [(0, 0); 9 * KEPT + 1], count: 0 };
        let mut best = Best { reach: Reach { height: f64::INFINITY, squared: f64::INFINITY }, number: NONE };
        self.try_move(p, guess, &mut tried, &mut best);
        self.try_move(p, self.columns[self.grid.index(x, y)].numbers[0], &mut tried, &mut best);
        for row in self.around(x, y) {
            for column in row {
                if best.reach.height <= enough {
                    break;
                }
                for number in column.numbers.into_iter().take_while(|number| *number != NONE) {
                    self.try_move(p, number, &mut tried, &mut best);
                }
            }
        }
        if best.reach.height == f64::INFINITY {
            best.number = NONE;
        }
        Floor { height: best.reach.height, number: best.number }
    }

    /// Returns H over the cell where a flat cutter on a level move left it and the cells about it no lower: it reached beyond them; `None` elsewhere.
    fn level_floor(&self, x: u32, y: u32) -> Option<Floor> {
        let column = &self.columns[self.grid.index(x, y)];
        if !column.is_flat_beyond() {
            return None;
        }
        let sweep = &self.moves[column.numbers[0] as usize];
        let height = (sweep.z - self.datum) as f32;
        let is_level = sweep.slope == 0.0
            && column.height() == height
            && self.around(x, y).all(|row| row.iter().all(|other| other.height() >= height));
        is_level.then_some(Floor { height: sweep.z, number: column.numbers[0] })
    }

    /// Returns the columns of a cell and of those about it, in rows.
    fn around(&self, x: u32, y: u32) -> impl Iterator<Item = &[Column]> {
        let columns = x.saturating_sub(1)..=(x + 1).min(self.grid.count[0] - 1);
        (y.saturating_sub(1)..=(y + 1).min(self.grid.count[1] - 1)).map(move |row| {
            &self.columns[self.grid.index(*columns.start(), row)..=self.grid.index(*columns.end(), row)]
        })
    }

    pub(crate) fn reach(&self, number: u32, p: Vector2<f64>) -> Reach {
        let sweep = &self.moves[number as usize];
        sweep.reach(&self.cutters[sweep.cutter as usize], p)
    }

    fn try_move(&self, p: Vector2<f64>, number: u32, tried: &mut Tried, best: &mut Best) {
        if number == NONE || tried.has(number) {
            return;
        }
        let start = Best { reach: self.reach(number, p), number };
        let (down, first) = self.walk(p, start, tried, |at| at.checked_sub(1));
        let (up, last) = self.walk(p, start, tried, |at| (at as usize + 1 < self.moves.len()).then(|| at + 1));
        for found in [down, up] {
            if is_better(&found.reach, &best.reach) {
                *best = found;
            }
        }
        tried.add(first, last);
    }

    /// Walks from `start` in one direction, by `next` (`None` at its end), while moves get better at `p`. Returns the best, and the last that was
    /// tried.
    fn walk(&self, p: Vector2<f64>, start: Best, tried: &Tried, next: impl Fn(u32) -> Option<u32>) -> (Best, u32) {
        let (mut best, mut at, mut worse) = (start, start.number, 0);
        while worse < LOOK_AHEAD {
            match next(at) {
                Some(number) if !tried.has(number) => at = number,
                _ => break,
            }
            // Of alike moves on one level the nearer one is better, which takes no height to see.
            let sweep = &self.moves[at as usize];
            if sweep.is_level_with(&self.moves[best.number as usize]) && sweep.squared(p) >= best.reach.squared {
                worse += 1;
                continue;
            }
            let reach = self.reach(at, p);
            if is_better(&reach, &best.reach) {
                (best, worse) = (Best { reach, number: at }, 0);
            } else {
                worse += 1;
            }
        }
        (best, at)
    }

    /// Returns how far `p` is, at the height `z`, inside what a move cut, mm; negative outside, infinite for no move.
    pub(crate) fn clearance(&self, number: u32, p: Vector2<f64>, z: f64) -> f64 {
        if number == NONE {
            return f64::INFINITY;
        }
        let sweep = &self.moves[number as usize];
        sweep.clearance(&self.cutters[sweep.cutter as usize], p, z)
    }
}

impl Field {
    /// Returns the same for all that is higher than about `z`: a flat end leaves nothing above it.
    pub(crate) fn clearance_above(&self, number: u32, p: Vector2<f64>, z: f64) -> f64 {
        let cutter = |number: u32| &self.cutters[self.moves[number as usize].cutter as usize];
        let is_flat = number != NONE && cutter(number).end_radius() == cutter(number).radius;
        self.clearance(number, p, if is_flat { f64::INFINITY } else { z })
    }
}

impl Tried {
    #[inline]
    fn has(&self, number: u32) -> bool {
        self.runs[..self.count].iter().any(|run| run.0 <= number && number <= run.1)
    }

    fn add(&mut self, first: u32, last: u32) {
        // Walks end at runs that were tried before, so they mostly join one.
        for run in &mut self.runs[..self.count] {
            if first <= run.1 + 1 && run.0 <= last + 1 {
                *run = (run.0.min(first), run.1.max(last));
                return;
            }
        }
        self.runs[self.count] = (first, last);
        self.count += 1;
    }
}
