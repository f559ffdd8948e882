//! The field of columns: which move made the machined surface where.

use nalgebra::{Vector2, Vector3};

use crate::cutter::Cutter;
use crate::error::{RemovalError, finite, positive};
use crate::stock::Stock;
use crate::sweep::Sweep;

/// No move.
pub(crate) const NONE: u32 = u32::MAX;
/// A column is safely inside what a move cut when its centre is inside by this many cells: so is all that is seen from its neighbours.
const SAFE_CELLS: f64 = 2.2;
/// Moves that a column keeps: as many levels may have walls within two cells.
pub(crate) const KEPT: usize = 4;
/// Heights of columns that differ by less are one, mm: the rounding of heights 200 mm from the datum.
const SAME_HEIGHT: f32 = 2e-5;

/// What is left of a stock after moves of cutters along straight lines.
///
/// The machined surface is H(x, y), the least height that a cutter reached over a point of the plan; material is what was in the stock and
/// lies below H. A column stands on the centre of each cell of a grid over the plan and holds, besides its height, which moves reached it: the
/// lowest, the one that reached farthest beyond it, and up to two between. [`Field::surface`] evaluates H from the lines of such moves, so walls
/// are where the lines put them, not where columns are.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    pub(crate) stock: Stock,
    pub(crate) grid: Grid,
    pub(crate) columns: Vec<Column>,
    pub(crate) moves: Vec<Sweep>,
    pub(crate) cutters: Vec<Cutter>,
    /// Height that columns count from, mm.
    pub(crate) datum: f64,
}

/// Where cells are in the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    pub low: Vector2<f64>,
    pub size: Vector2<f64>,
    pub count: [u32; 2],
}

/// A column of the field: the moves that made the surface about it, of which none reached lower and farther than another.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub(crate) struct Column {
    /// Heights from the datum that the moves reached, rising, mm; infinite for none.
    heights: [f32; KEPT],
    /// Numbers of the moves; [`NONE`] behind the last.
    pub numbers: [u32; KEPT],
    /// How far the moves reached beyond the column, rising with the height, as [`Grid::margin_scale`] counts.
    margins: [u16; KEPT],
    /// Shapes of the cutters.
    shapes: [u8; KEPT],
}

const UNCUT: Column =
    Column { heights: [f32::INFINITY; KEPT], numbers: [NONE; KEPT], margins: [0; KEPT], shapes: [FLAT; KEPT] };

/// The shape of flat cutters; others have that of their number.
const FLAT: u8 = 0;
/// The shape of cutters beyond those that have one: each counts as different from all.
const OTHER: u8 = u8::MAX;

/// How a move reached a column.
#[derive(Debug, Clone, Copy)]
struct Visit {
    height: f32,
    margin: u16,
    number: u32,
    shape: u8,
}

impl Visit {
    /// Whether the other visit adds nothing: it is not lower, to within `tie`, and reached less far. What is said of the column holds about it
    /// for two cutters of one shape, of which the nearer rises later, and under a flat one, which does not rise.
    #[inline]
    fn dominates(&self, other: &Visit, tie: f32) -> bool {
        self.height <= other.height + tie
            && self.margin >= other.margin
            && (self.shape == FLAT || (self.shape == other.shape && self.shape != OTHER))
    }
}

impl Grid {
    pub fn new(stock: &Stock, cell_mm: f64) -> Result<Self, RemovalError> {
        let (low, high) = stock.bounds();
        Self::over(low.xy(), high.xy(), cell_mm)
    }

    /// Makes a grid over a rectangle of the plan.
    pub fn over(low: Vector2<f64>, high: Vector2<f64>, cell_mm: f64) -> Result<Self, RemovalError> {
        positive("cell", cell_mm)?;
        let extent = high - low;
        let count = extent.map(|extent| (extent / cell_mm * (1.0 - 1e-12)).ceil().max(1.0));
        if count.x * count.y >= f64::from(NONE) {
            return Err(RemovalError::TooManyColumns { columns: count.x * count.y, cell_mm, most: NONE - 1 });
        }
        let size = extent.component_div(&count);
        Ok(Self { low, size, count: [count.x as u32, count.y as u32] })
    }

    fn columns(&self) -> usize {
        self.count[0] as usize * self.count[1] as usize
    }

    pub fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.count[0] as usize + x as usize
    }

    /// Returns the position of a cell's centre in the plan, or along one axis.
    pub fn centre(&self, x: u32, y: u32) -> Vector2<f64> {
        Vector2::new(self.along(0, x), self.along(1, y))
    }

    fn along(&self, axis: usize, number: u32) -> f64 {
        self.low[axis] + (f64::from(number) + 0.5) * self.size[axis]
    }

    /// Returns the numbers of the cell that holds `p`; that at the rim for a point beyond it.
    pub fn cell(&self, p: Vector2<f64>) -> [u32; 2] {
        // Casts saturate.
        let number = |axis: usize| (((p[axis] - self.low[axis]) / self.size[axis]) as u32).min(self.count[axis] - 1);
        [number(0), number(1)]
    }

    /// Returns the numbers of the cells along an axis whose centres are between `from` and `to`.
    fn between(&self, axis: usize, from: f64, to: f64) -> std::ops::Range<u32> {
        let number = |at: f64| ((at - self.low[axis]) / self.size[axis] - 0.5).max(0.0).ceil();
        let count = f64::from(self.count[axis]);
        let first = number(from).min(count);
        let end = (((to - self.low[axis]) / self.size[axis] - 0.5).floor() + 1.0).clamp(0.0, count);
        first as u32..end.max(first) as u32
    }

    /// Margins per mm.
    pub fn margin_scale(&self) -> f64 {
        f64::from(u16::MAX) / (SAFE_CELLS * self.size.max())
    }
}

impl Field {
    /// Makes the field of an uncut `stock` with cells of at most `cell_mm`; a fortieth of the diameter of the smallest cutter is good. Fails if
    /// the cell is not positive or so small that columns cannot be numbered.
    pub fn new(stock: Stock, cell_mm: f64) -> Result<Self, RemovalError> {
        let grid = Grid::new(&stock, cell_mm)?;
        let datum = stock.bounds().1.z;
        let columns = vec![UNCUT; grid.columns()];
        Ok(Self { stock, grid, columns, moves: Vec::new(), cutters: Vec::new(), datum })
    }

    /// Returns the bytes that a field of `stock` with cells of `cell_mm` and `moves` moves takes, before any of them is allocated, not
    /// counting a mesh. Fails as [`Field::new`] does.
    pub fn memory_bytes(stock: &Stock, cell_mm: f64, moves: usize) -> Result<usize, RemovalError> {
        Ok(Grid::new(stock, cell_mm)?.columns() * size_of::<Column>() + moves * size_of::<Sweep>())
    }

    /// Makes room for `moves` more moves, so that cutting them allocates nothing.
    pub fn reserve(&mut self, moves: usize) {
        self.moves.reserve_exact(moves);
    }

    /// Returns the stock before any cut.
    #[must_use]
    pub fn stock(&self) -> &Stock {
        &self.stock
    }

    /// Removes what `cutter` sweeps while its tip moves straight between two points (frame of the workpiece, mm). `tag` is what the caller
    /// calls the move, such as its line. Moves of one path are to be cut in its order, as walls are looked for along it. Returns whether the
    /// move is kept: one that stays above or beside the stock is not. Fails if a coordinate is not finite or moves cannot be numbered any more.
    pub fn cut(
        &mut self,
        cutter: &Cutter,
        from: &Vector3<f64>,
        to: &Vector3<f64>,
        tag: u32,
    ) -> Result<bool, RemovalError> {
        finite("start of a move", from)?;
        finite("end of a move", to)?;
        let (low, high) = self.stock.bounds();
        let reach = Vector3::new(cutter.radius, cutter.radius, 0.0);
        let (first, last) = (from.inf(to) - reach, from.sup(to) + reach);
        if first.z >= high.z || first.x >= high.x || first.y >= high.y || last.x <= low.x || last.y <= low.y {
            return Ok(false);
        }
        if self.moves.len() >= NONE as usize {
            return Err(RemovalError::TooManyMoves { most: NONE });
        }
        let number = self.moves.len() as u32;
        let sweep = Sweep::new(from, to, self.number_of(cutter), tag);
        // About where the last move ended it cut as low as a move that goes on from there and does not lead down.
        let is_start = |last: &Sweep| last.cutter == sweep.cutter && (last.position(last.length) - from).amax() < 1e-9;
        let goes_on = sweep.lowest() >= from.z && self.moves.last().is_some_and(is_start);
        self.moves.push(sweep);
        for row in self.grid.between(1, first.y, last.y) {
            let y = self.grid.along(1, row);
            let (mut start, mut end) = span_of_row(&sweep, cutter.radius, y);
            let aside = y - from.y;
            // Behind its start a move reaches no farther than the last one. Across a row that is all of it or nothing.
            let ahead = aside * sweep.uy / sweep.ux.abs();
            if goes_on && sweep.ux < 0.0 {
                end = end.min(from.x + ahead);
            } else if goes_on {
                start = start.max(from.x - ahead);
            }
            self.cut_row(&sweep, number, cutter, row, self.grid.between(0, start, end));
        }
        Ok(true)
    }

    /// Returns a point of material that `cutter` would meet while its tip moves straight between two points, at the centre of a column; what it comes into by less than
    /// `free_mm` counts as met by none. Nothing is cut. Fails if a coordinate is not finite.
    pub fn first_in_way(
        &self,
        cutter: &Cutter,
        from: &Vector3<f64>,
        to: &Vector3<f64>,
        free_mm: f64,
    ) -> Result<Option<Vector3<f64>>, RemovalError> {
        finite("start of a move", from)?;
        finite("end of a move", to)?;
        let reach = Vector3::new(cutter.radius, cutter.radius, 0.0);
        let (first, last) = (from.inf(to) - reach, from.sup(to) + reach);
        let sweep = Sweep::new(from, to, 0, 0);
        let mut spans = Vec::new();
        for row in self.grid.between(1, first.y, last.y) {
            let y = self.grid.along(1, row);
            let (start, end) = span_of_row(&sweep, cutter.radius, y);
            for x in self.grid.between(0, start, end) {
                let p = Vector2::new(self.grid.along(0, x), y);
                let met = sweep.reach(cutter, p);
                if met.height == f64::INFINITY || met.squared.sqrt() > cutter.radius - free_mm {
                    continue;
                }
                let top = self.datum + f64::from(self.columns[self.grid.index(x, row)].height());
                spans.clear();
                self.stock.spans(p, &mut spans);
                let met = spans.iter().find_map(|[bottom, high]| {
                    let (low, high) = (bottom.max(met.height), high.min(top));
                    (high > low + free_mm).then_some(Vector3::new(p.x, p.y, 0.5 * (low + high)))
                });
                if met.is_some() {
                    return Ok(met);
                }
            }
        }
        Ok(None)
    }

    /// Returns the number of a cutter, a new one if it has none. Programs have few, and mostly use the last one again.
    fn number_of(&mut self, cutter: &Cutter) -> u32 {
        let known = self.cutters.iter().rposition(|known| known == cutter);
        known.unwrap_or_else(|| {
            self.cutters.push(*cutter);
            self.cutters.len() - 1
        }) as u32
    }

    fn cut_row(&mut self, sweep: &Sweep, number: u32, cutter: &Cutter, row: u32, cells: std::ops::Range<u32>) {
        let scale = self.grid.margin_scale();
        let lowest = (sweep.lowest() - self.datum) as f32;
        let y = self.grid.along(1, row);
        let start = self.grid.index(0, row);
        let shape =
            if cutter.end_radius() == cutter.radius { FLAT } else { u8::try_from(sweep.cutter + 1).unwrap_or(OTHER) };
        for (x, column) in
            cells.clone().zip(&mut self.columns[start + cells.start as usize..start + cells.end as usize])
        {
            // Most columns of a short move are known to be cut as low, and far beyond.
            if column.heights[0] <= lowest && column.is_flat_beyond() {
                continue;
            }
            let reach = sweep.reach(cutter, Vector2::new(self.grid.along(0, x), y));
            if reach.height == f64::INFINITY {
                continue;
            }
            // Casts saturate: what is safely inside is all the same.
            let margin = ((cutter.radius - reach.squared.sqrt()) * scale) as u16;
            column.receive(&Visit { height: (reach.height - self.datum) as f32, margin, number, shape });
        }
    }
}

impl Column {
    /// Least height that a move reached, from the datum; infinite where none came.
    pub fn height(&self) -> f32 {
        self.heights[0]
    }

    /// How far the lowest move reached beyond the column.
    pub fn margin(&self) -> u16 {
        self.margins[0]
    }

    /// Whether the lowest move is known to be flat and to have reached far beyond the column.
    pub fn is_flat_beyond(&self) -> bool {
        self.margins[0] == u16::MAX && self.shapes[0] == FLAT
    }

    pub fn is_uncut(&self) -> bool {
        self.numbers[0] == NONE
    }

    fn visit(&self, at: usize) -> Visit {
        Visit { height: self.heights[at], margin: self.margins[at], number: self.numbers[at], shape: self.shapes[at] }
    }

    /// Takes in a move that reached the column, unless one that is kept makes it needless.
    #[inline]
    fn receive(&mut self, visit: &Visit) {
        if !self.visit(0).dominates(visit, 0.0) {
            self.insert(visit);
        }
    }

    fn insert(&mut self, visit: &Visit) {
        let lowest = visit.height.min(self.heights[0]);
        let mut kept = [*visit; KEPT + 1];
        let mut count = 0;
        let mut is_placed = false;
        for at in 0..KEPT {
            let known = self.visit(at);
            if known.number == NONE {
                break;
            }
            if known.dominates(visit, SAME_HEIGHT) {
                self.heights[0] = lowest;
                return;
            }
            if visit.dominates(&known, SAME_HEIGHT) {
                continue;
            }
            if !is_placed && known.height > visit.height {
                is_placed = true;
                count += 1;
            }
            kept[count] = known;
            count += 1;
        }
        if !is_placed {
            kept[count] = *visit;
            count += 1;
        }
        if count > KEPT {
            drop_least(&mut kept);
            count = KEPT;
        }
        *self = UNCUT;
        for (at, visit) in kept[..count].iter().enumerate() {
            (self.heights[at], self.margins[at]) = (visit.height, visit.margin);
            (self.numbers[at], self.shapes[at]) = (visit.number, visit.shape);
        }
        self.heights[0] = lowest;
    }
}

/// Drops of visits in the order of their heights the one between whose strip of surface, as wide as it reached beyond the lower one and as high
/// as the higher one is above it, is the least.
fn drop_least(kept: &mut [Visit; KEPT + 1]) {
    let strip = |at: usize| {
        f32::from(kept[at].margin.saturating_sub(kept[at - 1].margin)) * (kept[at + 1].height - kept[at].height)
    };
    let mut least = 1;
    for at in 2..KEPT {
        if strip(at) < strip(least) {
            least = at;
        }
    }
    kept.copy_within(least + 1.., least);
}

/// Returns the least and the largest x at which a move comes within `radius` at the height y of the plan: an empty range if it does not.
fn span_of_row(sweep: &Sweep, radius: f64, y: f64) -> (f64, f64) {
    let mut span = (f64::INFINITY, f64::NEG_INFINITY);
    let mut add = |x: f64| span = (span.0.min(x), span.1.max(x));
    let [bx, by] = [sweep.x + sweep.ux * sweep.length, sweep.y + sweep.uy * sweep.length];
    for (cx, cy) in [(sweep.x, sweep.y), (bx, by)] {
        let rest = radius * radius - (y - cy) * (y - cy);
        if rest >= 0.0 {
            add(cx - rest.sqrt());
            add(cx + rest.sqrt());
        }
    }
    for side in [-radius, radius] {
        // The line beside the path, from the start of the motion to its end.
        let (sx, sy) = (sweep.x - side * sweep.uy, sweep.y + side * sweep.ux);
        let along = (y - sy) / sweep.uy;
        if along >= 0.0 && along <= sweep.length {
            add(sx + along * sweep.ux);
        }
    }
    span
}
