//! The machined surface in patches, and how far another field is from it.

use nalgebra::{Vector2, Vector3};

use crate::error::RemovalError;
use crate::field::{Field, Grid, NONE};

/// A piece of the surface of what is left of a stock: of a floor, or of a wall between two floors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Its corners in turn, counter-clockwise seen from outside, mm: for a picture, within half a patch.
    pub corners: [Vector3<f64>; 4],
    /// A point of the surface in it, from the lines that made it, mm.
    pub position: Vector3<f64>,
    /// Unit normal out of the material there.
    pub normal: Vector3<f64>,
    /// What the caller called the move that made it; `None` on the skin of the stock.
    pub tag: Option<u32>,
}

impl Patch {
    /// Returns its area, mm².
    #[must_use]
    pub fn area_mm2(&self) -> f64 {
        let [a, b, c, d] = &self.corners;
        0.5 * (c - a).cross(&(d - b)).norm()
    }
}

/// How far a surface is beyond a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Distance, mm: positive where material is left, negative where it is missing.
    pub mm: f64,
    /// The point of the surface.
    pub position: Vector3<f64>,
    /// Direction out of the material in which it was found: if the surface moves along it, the distance grows by as much. Zero where none was found.
    pub normal: Vector3<f64>,
}

/// Neighbouring cells have a wall between them if their heights differ by more than this, mm, and most of it at one place.
const LEAST_WALL: f64 = 1e-3;
/// Bisections that find whether it does.
const JUMP: usize = 12;
/// Bisections of the way between two cells.
const BISECTIONS: usize = 36;
/// How far off a surface it is looked for across its normal, and what made it, mm.
const BELOW_MM: f64 = 1e-5;
/// So near a distance is found, mm.
const NEAR_MM: f64 = 1e-7;
/// Steps along a normal, to either side.
const STEPS: u32 = 8;

/// Top of what is left in a cell.
#[derive(Debug, Clone, Copy)]
struct Top {
    z: f64,
    /// Whether there is nothing in the cell.
    is_void: bool,
}

/// Tops of the cells of a grid, and where the walls between them are.
struct Tops<'a> {
    field: &'a Field,
    grid: Grid,
    tops: Vec<Top>,
    /// Where the wall towards the next cell along x and along y crosses the line between their centres.
    walls: [Vec<Option<Vector2<f64>>>; 2],
}

impl Field {
    /// Returns the surface of what is left over a rectangle of the plan, as far as there was stock, seen from the spindle, in patches of at most `patch_mm`: what is narrower may
    /// not be seen. Undercuts of a mesh below what is left are not in it. Fails if the size is not positive, or so small that patches cannot be numbered.
    pub fn patches(&self, [from, to]: [Vector2<f64>; 2], patch_mm: f64) -> Result<Vec<Patch>, RemovalError> {
        let (low, high) = self.stock.bounds();
        let (low, high) = (low.xy().sup(&from), high.xy().inf(&to));
        if low.x >= high.x || low.y >= high.y {
            return Ok(Vec::new());
        }
        let grid = Grid::over(low, high, patch_mm)?;
        let mut spans = Vec::new();
        let cells = || (0..grid.count[1]).flat_map(|y| (0..grid.count[0]).map(move |x| (x, y)));
        let tops = cells().map(|(x, y)| self.top(grid.centre(x, y), &mut spans)).collect();
        let mut tops = Tops { field: self, grid, tops, walls: [Vec::new(), Vec::new()] };
        for axis in 0..2 {
            let wall = |(x, y): (u32, u32)| {
                let [a, b] = [[x, y], tops.next(x, y, axis)?];
                tops.wall_between(a, b)
            };
            tops.walls[axis] = cells().map(wall).collect();
        }
        let mut patches = Vec::new();
        for (x, y) in cells() {
            patches.extend(tops.floor_patch(x, y));
            tops.rim_patches(x, y, &mut patches);
            for axis in 0..2 {
                if let Some(next) = tops.next(x, y, axis) {
                    tops.wall_patches([x, y], next, axis, &mut patches);
                }
            }
        }
        Ok(patches)
    }

    /// Returns how far the surface is beyond `position` along `normal`, at most `reach_mm`. Where a wall now stands over the point, or is gone from it, that is how far across the
    /// normal, in eight directions; where no surface is found, `reach_mm`.
    #[must_use]
    pub fn deviation(&self, position: &Vector3<f64>, normal: &Vector3<f64>, reach_mm: f64) -> Deviation {
        let (mut spans, mut guess) = (Vec::new(), NONE);
        let is_left = self.is_material(position, &mut guess, &mut spans);
        let sign = if is_left { 1.0 } else { -1.0 };
        let mut distance = |from: &Vector3<f64>, direction: &Vector3<f64>| {
            if direction.xy() == Vector2::zeros() && sign * direction.z > 0.0 {
                return Some(self.to_surface(from, is_left, &mut spans)?.abs()).filter(|own| *own <= reach_mm);
            }
            let mut differs =
                |along: f64| self.is_material(&(from + along * direction), &mut guess, &mut spans) != is_left;
            let at = |step: u32| reach_mm * f64::from(step) / f64::from(STEPS);
            let step = (1..=STEPS).find(|step| differs(at(*step)))?;
            let (mut near, mut far) = (at(step - 1), at(step));
            while far - near > NEAR_MM {
                let middle = 0.5 * (near + far);
                if differs(middle) { far = middle } else { near = middle }
            }
            Some(0.5 * (near + far))
        };
        let found = |along: f64, from: &Vector3<f64>, direction: &Vector3<f64>| Deviation {
            mm: sign * along,
            position: from + along * direction,
            normal: sign * direction,
        };
        if let Some(along) = distance(position, &(sign * normal)) {
            return found(along, position, &(sign * normal));
        }
        let axis = if normal.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
        let across = normal.cross(&axis).normalize();
        let [across, aside] = [across, normal.cross(&across)];
        let directions = (0..8).map(|eighth| {
            let (sine, cosine) = libm::sincos(f64::from(eighth) * std::f64::consts::FRAC_PI_4);
            cosine * across + sine * aside
        });
        // On the surface itself nothing is within it; where the floor beside the wall has moved along the normal as well, the wall is found beyond that.
        let below = position - if is_left { 0.0 } else { BELOW_MM } * normal;
        let beyond = position + sign * reach_mm * normal;
        let ways = directions.flat_map(|own| [(below, own), (beyond, own)]);
        let all = ways.filter_map(|(from, own)| Some((distance(&from, &own)?, from, own)));
        match all.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((along, from, direction)) => found(along, &from, &direction),
            None => Deviation { normal: Vector3::zeros(), ..found(reach_mm, position, &(sign * normal)) },
        }
    }

    /// Returns the tag of the move that made the surface at a deviation; `None` on the skin of the stock.
    #[must_use]
    pub fn made_by(&self, surface: &Deviation) -> Option<u32> {
        let cut = surface.position + BELOW_MM * surface.normal;
        let floor = self.floor(cut.xy());
        (floor.number != NONE && floor.height <= cut.z).then(|| self.moves[floor.number as usize].tag)
    }

    /// Whether there is material at `p`; `guess`, a move that may have cut there, becomes the one that did.
    fn is_material(&self, p: &Vector3<f64>, guess: &mut u32, spans: &mut Vec<[f64; 2]>) -> bool {
        spans.clear();
        self.stock.spans(p.xy(), spans);
        if !spans.iter().any(|span| span[0] < p.z && p.z < span[1]) {
            return false;
        }
        let floor = self.floor_from(p.xy(), *guess, p.z);
        *guess = floor.number;
        p.z < floor.height
    }

    /// Returns how far the end of the material at `p` is above it where it `is_left`, or the next below it; `None` without one.
    fn to_surface(&self, p: &Vector3<f64>, is_left: bool, spans: &mut Vec<[f64; 2]>) -> Option<f64> {
        spans.clear();
        self.stock.spans(p.xy(), spans);
        let floor = self.floor(p.xy()).height;
        let begun = spans.iter().filter(|span| span[0] < floor.min(p.z)).map(|span| span[1].min(floor) - p.z);
        begun.filter(|above| (*above > 0.0) == is_left).max_by(f64::total_cmp)
    }

    /// Returns the top of what is left over `p`.
    fn top(&self, p: Vector2<f64>, spans: &mut Vec<[f64; 2]>) -> Top {
        spans.clear();
        self.stock.spans(p, spans);
        let height = self.floor(p).height;
        match spans.iter().rev().find(|span| span[0] < height) {
            Some(span) => Top { z: height.min(span[1]), is_void: false },
            None => Top { z: self.stock.bounds().0.z, is_void: true },
        }
    }

    /// Returns the normal out of the material at a point of a wall, and what the move that made it is called; `None` on the skin of the stock. `cut` is beside it, where
    /// there is no material.
    fn wall_maker(&self, position: &Vector3<f64>, cut: Vector2<f64>) -> Option<(Vector3<f64>, u32)> {
        let floor = self.floor(cut);
        if floor.number == NONE || floor.height > position.z {
            return None;
        }
        let sweep = &self.moves[floor.number as usize];
        let cutter = &self.cutters[sweep.cutter as usize];
        let tip = sweep.position(sweep.nearest(position.xy()));
        if position.z - tip.z >= cutter.nose_height_mm() {
            let inward = (tip - position).xy().try_normalize(f64::MIN_POSITIVE)?;
            return Some((Vector3::new(inward.x, inward.y, 0.0), sweep.tag));
        }
        let tip = sweep.position(sweep.generating(cutter, position.xy()));
        Some((-cutter.normal(&(position - tip)), sweep.tag))
    }
}

impl Tops<'_> {
    fn next(&self, x: u32, y: u32, axis: usize) -> Option<[u32; 2]> {
        let next = if axis == 0 { [x + 1, y] } else { [x, y + 1] };
        (next[axis] < self.grid.count[axis]).then_some(next)
    }

    fn at(&self, [x, y]: [u32; 2]) -> Option<&Top> {
        (x < self.grid.count[0] && y < self.grid.count[1]).then(|| &self.tops[self.grid.index(x, y)])
    }

    /// Whether there is a wall between a cell and a neighbour.
    fn is_wall(&self, a: [u32; 2], b: [u32; 2]) -> bool {
        let [x, y] = [0, 1].map(|axis| a[axis].min(b[axis]));
        self.walls[usize::from(a[0] == b[0])][self.grid.index(x, y)].is_some()
    }

    /// Returns where the wall between two neighbours is, on the line between their centres; `None` if there is none.
    fn wall_between(&self, a: [u32; 2], b: [u32; 2]) -> Option<Vector2<f64>> {
        let [top_a, top_b] = [*self.at(a)?, *self.at(b)?];
        let height = (top_a.z - top_b.z).abs();
        if top_a.is_void == top_b.is_void && height <= LEAST_WALL {
            return None;
        }
        let z = 0.5 * (top_a.z + top_b.z);
        let [low, high] = self.around_crossing(a, b, z, JUMP)?;
        let mut spans = Vec::new();
        let [low_top, high_top] = [low, high].map(|p| self.field.top(p, &mut spans));
        let is_jump = low_top.is_void != high_top.is_void || high_top.z - low_top.z > 0.5 * height;
        is_jump.then(|| self.around_crossing(a, b, z, BISECTIONS).map(|[low, high]| 0.5 * (low + high)))?
    }

    /// Returns the points beside the wall at `z` between the centres of two cells: where there is no material, and where there is; `None` if there is
    /// some at both centres or at neither.
    fn around_crossing(&self, a: [u32; 2], b: [u32; 2], z: f64, bisections: usize) -> Option<[Vector2<f64>; 2]> {
        let mut spans = Vec::new();
        let mut is_below = |p: Vector2<f64>| {
            let top = self.field.top(p, &mut spans);
            top.is_void || top.z < z
        };
        let [a, b] = [a, b].map(|[x, y]| self.grid.centre(x, y));
        let (mut low, mut high) = match (is_below(a), is_below(b)) {
            (true, false) => (a, b),
            (false, true) => (b, a),
            _ => return None,
        };
        for _ in 0..bisections {
            let middle = 0.5 * (low + high);
            if is_below(middle) { low = middle } else { high = middle }
        }
        Some([low, high])
    }

    /// Returns the corner of cell (x, y) on its side (right, far), at the height of its floor there.
    fn corner(&self, [x, y]: [u32; 2], [right, far]: [bool; 2]) -> Vector3<f64> {
        let shifted = |own: u32, up: bool| if up { Some(own + 1) } else { own.checked_sub(1) };
        let (beside, behind) = (shifted(x, right), shifted(y, far));
        let cells = [beside.map(|x| [x, y]), behind.map(|y| [x, y]), beside.zip(behind).map(|(x, y)| [x, y])];
        // Floors that go on across the corner.
        let goes_on = |from: Option<[u32; 2]>, to: Option<[u32; 2]>| match (from, to) {
            (Some(from), Some(to)) => self.at(to).is_some() && !self.is_wall(from, to),
            _ => false,
        };
        let own = [x, y];
        let [is_beside, is_behind] = [cells[0], cells[1]].map(|cell| goes_on(Some(own), cell));
        let is_across = (is_beside && goes_on(cells[0], cells[2])) || (is_behind && goes_on(cells[1], cells[2]));
        let floors = [(Some(own), true), (cells[0], is_beside), (cells[1], is_behind), (cells[2], is_across)];
        let heights = floors.iter().filter(|own| own.1).filter_map(|own| self.at(own.0?)).map(|top| top.z);
        let (sum, count) = heights.fold((0.0, 0), |(sum, count), z| (sum + z, count + 1));
        // Walls that meet at the corner: of the two cells before it along x, and along y.
        let low = |own: u32, up: bool| if up { Some(own) } else { own.checked_sub(1) };
        let (first_x, first_y) = (low(x, right), low(y, far));
        let of = |axis: usize, x: Option<u32>, y: Option<u32>| {
            let cell = [x?, y?];
            self.at(cell).and_then(|_| self.walls[axis][self.grid.index(cell[0], cell[1])])
        };
        let next = |own: Option<u32>| own.map_or(Some(0), |own| Some(own + 1));
        let walls = [
            of(0, first_x, first_y),
            of(0, first_x, next(first_y)),
            of(1, first_x, first_y),
            of(1, next(first_x), first_y),
        ];
        let (walls, crossings) =
            walls.iter().flatten().fold((Vector2::zeros(), 0), |(sum, count), wall| (sum + wall, count + 1));
        let half = |up: bool| if up { 0.5 } else { -0.5 };
        let plain = self.grid.centre(x, y) + Vector2::new(half(right), half(far)).component_mul(&self.grid.size);
        let mut plan = if crossings == 0 { plain } else { walls / f64::from(crossings) };
        for (axis, own) in [first_x, first_y].into_iter().enumerate() {
            // The rim of the field is where it is.
            if own.is_none_or(|own| own + 1 == self.grid.count[axis]) {
                plan[axis] = plain[axis];
            }
        }
        Vector3::new(plan.x, plan.y, sum / f64::from(count))
    }

    fn floor_patch(&self, x: u32, y: u32) -> Option<Patch> {
        let top = self.at([x, y]).filter(|top| !top.is_void)?;
        let corners =
            [[false, false], [true, false], [true, true], [false, true]].map(|side| self.corner([x, y], side));
        let p = self.grid.centre(x, y);
        let made = self.field.surface(p).filter(|made| made.position.z <= top.z);
        Some(Patch {
            corners,
            position: Vector3::new(p.x, p.y, top.z),
            normal: made.map_or_else(Vector3::z, |made| made.normal),
            tag: made.map(|made| made.tag),
        })
    }

    /// Adds the sides of the stock at the rim of the field.
    fn rim_patches(&self, x: u32, y: u32, patches: &mut Vec<Patch>) {
        let Some(top) = self.at([x, y]).filter(|top| !top.is_void) else { return };
        let bottom = self.field.stock.bounds().0.z;
        let [right, far] = [x + 1 == self.grid.count[0], y + 1 == self.grid.count[1]];
        let sides = [
            (y == 0, [[false, false], [true, false]], -Vector3::y()),
            (right, [[true, false], [true, true]], Vector3::x()),
            (far, [[true, true], [false, true]], Vector3::y()),
            (x == 0, [[false, true], [false, false]], -Vector3::x()),
        ];
        for (_, ends, normal) in sides.into_iter().filter(|side| side.0) {
            let [a, b] = ends.map(|side| self.corner([x, y], side));
            let low = |corner: Vector3<f64>| Vector3::new(corner.x, corner.y, bottom);
            let position = Vector3::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y), 0.5 * (bottom + top.z));
            patches.push(Patch { corners: [low(a), low(b), b, a], position, normal, tag: None });
        }
    }

    /// Adds the wall between two cells in pieces about as high as a cell is wide.
    fn wall_patches(&self, a: [u32; 2], b: [u32; 2], axis: usize, patches: &mut Vec<Patch>) {
        if !self.is_wall(a, b) {
            return;
        }
        let sides = |far: bool| if axis == 0 { [[far, false], [far, true]] } else { [[false, far], [true, far]] };
        let (of_a, of_b) =
            (sides(true).map(|side| self.corner(a, side)), sides(false).map(|side| self.corner(b, side)));
        let is_rising = of_a[0].z + of_a[1].z < of_b[0].z + of_b[1].z;
        let (low, high) = if is_rising { (of_a, of_b) } else { (of_b, of_a) };
        let height = 0.5 * (high[0].z + high[1].z - low[0].z - low[1].z);
        let pieces = (height / (4.0 * self.grid.size.max())).ceil().max(1.0) as u32;
        for piece in 0..pieces {
            let share = |number: u32| f64::from(number) / f64::from(pieces);
            let at = |corner: usize, share: f64| low[corner] + share * (high[corner] - low[corner]);
            let (bottom, top) = (share(piece), share(piece + 1));
            let mut corners = [at(0, bottom), at(1, bottom), at(1, top), at(0, top)];
            if is_rising == (axis == 0) {
                corners.reverse();
            }
            let z = 0.25 * corners.iter().map(|corner| corner.z).sum::<f64>();
            let Some([cut, left]) = self.around_crossing(a, b, z, BISECTIONS) else { continue };
            let plan = 0.5 * (cut + left);
            let position = Vector3::new(plan.x, plan.y, z);
            let made = self.field.wall_maker(&position, cut);
            let skin = || (cut - left).try_normalize(f64::MIN_POSITIVE).map_or_else(Vector3::z, |out| out.push(0.0));
            patches.push(Patch {
                corners,
                position,
                normal: made.map_or_else(skin, |made| made.0),
                tag: made.map(|made| made.1),
            });
        }
    }
}
