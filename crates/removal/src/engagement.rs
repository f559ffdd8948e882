//! Where a cutter touches material at an instant: arcs, depth, width, chip thickness, volume.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::Range;

use nalgebra::{Vector2, Vector3};

use crate::cutter::{Cutter, Ring};
use crate::error::{RemovalError, finite, positive};
use crate::field::Field;
use crate::ring::{Front, Samples};

/// Into how many parts the surface of a cutter is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slicing {
    /// Largest height of a slice of the cylindrical part, mm.
    pub slice_mm: f64,
    /// Slices of the engaged part of a corner or of a drill's point.
    pub nose_slices: u32,
    /// Rings of the flat end, for a motion that leads down.
    pub end_rings: u32,
}

impl Default for Slicing {
    fn default() -> Self {
        Self { slice_mm: 1.0, nose_slices: 8, end_rings: 8 }
    }
}

impl Slicing {
    /// Fails if a number is not positive, or makes more than 10,000 slices of a stock of the height `stock_mm`.
    fn check(&self, stock_mm: f64) -> Result<(), RemovalError> {
        const MOST: u32 = 10_000;
        let nose = positive("number of slices of the nose", f64::from(self.nose_slices))?;
        let end = positive("number of rings of the end", f64::from(self.end_rings))?;
        let slices = (stock_mm / positive("slice", self.slice_mm)?).max(nose).max(end);
        if slices > f64::from(MOST) { Err(RemovalError::TooManySlices { slices, most: MOST }) } else { Ok(()) }
    }
}

/// An arc in which a slice cuts, rad.
///
/// Angles θ count from the horizontal direction of motion counter-clockwise seen from the spindle: the left of the motion is at 90°. A motion
/// along z has none; they count from the x axis then. With the angle ψ of a tooth's chip h = c sin ψ ([`Arc::tooth_angles`])
///
/// ```text
/// ψ = 90° − θ    spindle clockwise seen from the spindle (M3)
/// ψ = 90° + θ    counter-clockwise (M4)
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Where it begins, −π to π.
    pub from: f64,
    /// Where it ends, larger.
    pub to: f64,
}

impl Arc {
    /// Returns the angles ψ at which a tooth enters and leaves the material, rad: 0 to π for what a horizontal motion engages.
    #[must_use]
    pub fn tooth_angles(&self, spindle: Spindle) -> (f64, f64) {
        match spindle {
            Spindle::Clockwise => (FRAC_PI_2 - self.to, FRAC_PI_2 - self.from),
            Spindle::CounterClockwise => (FRAC_PI_2 + self.from, FRAC_PI_2 + self.to),
        }
    }
}

/// The direction in which the spindle turns, seen from the spindle towards the workpiece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spindle {
    /// M3.
    Clockwise,
    /// M4.
    CounterClockwise,
}

/// How teeth pass through the material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Milling {
    /// They do not.
    Air,
    /// Up milling: chips begin with no thickness.
    Up,
    /// Down milling: chips end with no thickness.
    Down,
    /// Both, as in a slot.
    Both,
}

/// A slice of the cutter that touches material.
#[derive(Debug, Clone, PartialEq)]
pub struct Slice {
    /// Heights above the tip between which it is, mm.
    pub bottom_mm: f64,
    /// The upper of them.
    pub top_mm: f64,
    /// Its mean radius over its height, mm.
    pub radius_mm: f64,
    /// Length of its meridian, mm: of the edge of a tooth without helix.
    pub edge_mm: f64,
    /// How much its radius grows over its height, mm.
    pub run_mm: f64,
    /// Where its arcs are in [`Engagement::arcs`].
    pub arcs: Range<usize>,
}

/// How a cutter engages at an instant. It is a buffer to be used again: [`Field::engage`] replaces what is in it.
#[derive(Debug, Clone, Default)]
pub struct Engagement {
    /// Slices that touch material, from the tip up.
    pub slices: Vec<Slice>,
    /// Arcs of all slices.
    pub arcs: Vec<Arc>,
    /// Axial depth: height above the tip up to which the surface that moves into material touches it, mm.
    pub depth_mm: f64,
    /// Radial width: the largest sum, over a slice, of the widths of its arcs across the motion, mm.
    pub width_mm: f64,
    /// Largest chip thickness per feed per tooth: the largest n · t of the surface in material, n its normal and t the motion. On a cylinder it
    /// is sin ψ.
    pub chip_ratio: f64,
    /// Area of the flat end in material, of a motion that leads down, mm².
    pub end_area_mm2: f64,
    /// Volume removed per mm of motion, mm²: ∫ n · t dA over the surface in material.
    pub volume_per_mm: f64,
    samples: Samples,
    trial: Vec<Arc>,
}

impl Engagement {
    /// Whether no material is touched.
    #[must_use]
    pub fn is_air(&self) -> bool {
        self.slices.is_empty() && self.end_area_mm2 == 0.0
    }

    /// Returns how the teeth of the slices pass through the material: up milling where it is on the side on which they enter, and both where it
    /// reaches both sides (within 0.5° of 90°) or lies in the middle.
    #[must_use]
    pub fn milling(&self, spindle: Spindle) -> Milling {
        const SIDE: f64 = FRAC_PI_2 - 0.5 * PI / 180.0;
        let left = self.arcs.iter().any(|arc| arc.to >= SIDE);
        let right = self.arcs.iter().any(|arc| arc.from <= -SIDE);
        // Where the chip is, as its moment about the direction of motion: ∫ sin θ cos θ dθ.
        let moment: f64 = self.arcs.iter().map(|arc| libm::sin(arc.to).powi(2) - libm::sin(arc.from).powi(2)).sum();
        let to_left = match (left, right) {
            _ if self.arcs.is_empty() => return Milling::Air,
            (true, true) => return Milling::Both,
            (true, false) => true,
            (false, true) => false,
            (false, false) if moment.abs() < 1e-3 => return Milling::Both,
            (false, false) => moment > 0.0,
        };
        if to_left == (spindle == Spindle::Clockwise) { Milling::Up } else { Milling::Down }
    }

    fn clear(&mut self) {
        self.slices.clear();
        self.arcs.clear();
        (self.depth_mm, self.width_mm, self.chip_ratio) = (0.0, 0.0, 0.0);
        (self.end_area_mm2, self.volume_per_mm) = (0.0, 0.0);
    }
}

impl Field {
    /// Computes into `engagement` where `cutter` touches material with its tip at `tip` while it moves along `direction` (frame of the
    /// workpiece, mm; a vector of any length). Of a short move: its middle, with all moves before it cut and itself not.
    ///
    /// Ends of arcs are found within 1e-3°. On the cylinder an arc between arcs of air is found if it is wider than 0.5°, on corner, point and end
    /// and on uncut stock that stands alone, a pin or a thin wall, if it is wider than 5°; arcs that reach to 90° from the motion, as those of a wall beside it, if they are wider than 0.25°. Fails if a
    /// number is not finite, the direction has no length, or a number of `slicing` is not
    /// positive or makes more than 10,000 slices.
    pub fn engage(
        &self,
        cutter: &Cutter,
        tip: &Vector3<f64>,
        direction: &Vector3<f64>,
        slicing: &Slicing,
        engagement: &mut Engagement,
    ) -> Result<(), RemovalError> {
        finite("tip", tip)?;
        finite("direction of motion", direction)?;
        let (low, high) = self.stock.bounds();
        slicing.check(high.z - low.z)?;
        let front = Front::new(tip, direction).ok_or(RemovalError::NoDirection)?;
        engagement.clear();
        if tip.z >= high.z {
            return Ok(());
        }
        let mut samples = std::mem::take(&mut engagement.samples);
        if front.vertical < 0.0 && cutter.end_radius() > 0.0 {
            let make = |from: f64, at: f64, to: f64| cutter.end_ring(from, at, to);
            let rings = Rings { make, from: 0.0, to: 1.0, count: slicing.end_rings };
            engagement.add_rings(self, &rings, &front, &mut samples);
            // The end is no slice: it has no depth, and its chips no angle.
            engagement.end_area_mm2 = engagement.volume_per_mm / -front.vertical;
            engagement.slices.clear();
            engagement.arcs.clear();
            engagement.width_mm = 0.0;
        }
        let nose = cutter.nose_height_mm();
        if nose > 0.0
            && let Some((from, to)) = self.nose_contact(cutter, &front)
        {
            let make = |from: f64, at: f64, to: f64| cutter.nose_ring(from, at, to);
            let rings = Rings { make, from, to, count: slicing.nose_slices };
            engagement.add_rings(self, &rings, &front, &mut samples);
        }
        let side_depth = samples.fill_side(self, cutter, &front);
        if side_depth > nose {
            // Below the stock there is nothing to slice.
            let bottom = nose.max(low.z - tip.z);
            let count = ((side_depth - bottom) / slicing.slice_mm * (1.0 - 1e-9)).ceil().max(1.0);
            let height = (side_depth - bottom) / count;
            for slice in 0..count as u32 {
                let ring = cutter.side_ring(bottom + f64::from(slice) * height, bottom + f64::from(slice + 1) * height);
                let first = engagement.arcs.len();
                engagement.arcs.extend(samples.arcs(self, &ring, &front));
                engagement.add_slice(&ring, &front, first..engagement.arcs.len());
            }
            engagement.volume_per_mm += samples.side_volume(cutter.radius, nose, &front);
            engagement.depth_mm = side_depth;
        }
        engagement.samples = samples;
        Ok(())
    }
}

/// Rings of a part of the cutter's surface by shares of it.
struct Rings<Make> {
    /// Makes the ring between two shares, with the middle at the one between.
    make: Make,
    /// The part that may touch material.
    from: f64,
    to: f64,
    count: u32,
}

/// Neighbouring rings whose arcs differ by more have a step of the material between them, rad.
const STEP_OF_MATERIAL: f64 = 10.0 * PI / 180.0;

impl Engagement {
    /// Adds the rings of a part as slices, with their volume. The edge between two of them is put where the material has a step, if there is one:
    /// so slices end at floors and tops.
    fn add_rings<Make: Fn(f64, f64, f64) -> Ring>(
        &mut self,
        field: &Field,
        rings: &Rings<Make>,
        front: &Front,
        samples: &mut Samples,
    ) {
        let width = (rings.to - rings.from) / f64::from(rings.count);
        let thin = |at: f64| (rings.make)(at - 1e-3 * width, at, at + 1e-3 * width);
        let measure = |share: f64, samples: &mut Samples, arcs: &mut Vec<Arc>, known: &dyn Fn(f64) -> Option<bool>| {
            let (ring, first) = (thin(share), arcs.len());
            samples.fill(field, &ring, front, known);
            arcs.extend(samples.arcs(field, &ring, front));
            arcs[first..].iter().map(|arc| arc.to - arc.from).sum::<f64>()
        };
        let mut trial = std::mem::take(&mut self.trial);
        // A ring's share, arcs, and their length: the one before.
        let mut last = (rings.from, self.arcs.len()..self.arcs.len(), 0.0);
        let mut edge = rings.from;
        for number in 0..rings.count {
            let at = rings.from + (f64::from(number) + 0.5) * width;
            let first = self.arcs.len();
            let length = measure(at, samples, &mut self.arcs, &|_| None);
            let arcs = first..self.arcs.len();
            let upper = match number {
                0 => outer_edge((at, length), rings.from, |share| samples.touches(field, &thin(share), front)),
                _ => edge_between([(last.0, last.2), (at, length)], |share| {
                    let is_in = |arcs: &Range<usize>, angle: f64| {
                        self.arcs[arcs.clone()].iter().any(|arc| arc.from <= angle && angle <= arc.to)
                    };
                    trial.clear();
                    // Between two rings it is as on both where they are alike.
                    measure(share, samples, &mut trial, &|angle| {
                        let is_below = is_in(&last.1, angle);
                        (is_below == is_in(&arcs, angle)).then_some(is_below)
                    })
                }),
            };
            if number > 0 {
                self.add_ring(&(rings.make)(edge, last.0, upper), front, last.1);
            }
            edge = upper;
            last = (at, arcs, length);
        }
        self.trial = trial;
        let upper = outer_edge((last.0, last.2), rings.to, |share| samples.touches(field, &thin(share), front));
        self.add_ring(&(rings.make)(edge, last.0, upper), front, last.1);
    }

    fn add_ring(&mut self, ring: &Ring, front: &Front, arcs: Range<usize>) {
        self.volume_per_mm += self.arcs[arcs.clone()].iter().map(|arc| front.volume(ring, arc)).sum::<f64>();
        self.add_slice(ring, front, arcs);
    }

    /// Adds a slice if it has arcs, but not its volume.
    fn add_slice(&mut self, ring: &Ring, front: &Front, arcs: Range<usize>) {
        if arcs.is_empty() {
            return;
        }
        let across = |angle: f64| libm::sin(angle.clamp(-FRAC_PI_2, FRAC_PI_2));
        let mut width = 0.0;
        for arc in &self.arcs[arcs.clone()] {
            width += ring.radius * (across(arc.to) - across(arc.from));
            self.chip_ratio = self.chip_ratio.max(front.chip(ring, arc));
        }
        self.width_mm = self.width_mm.max(width);
        self.depth_mm = self.depth_mm.max(ring.top);
        self.slices.push(Slice {
            bottom_mm: ring.bottom,
            top_mm: ring.top,
            radius_mm: ring.side / (ring.top - ring.bottom),
            edge_mm: ring.edge,
            run_mm: ring.run,
            arcs,
        });
    }
}

/// Returns the share towards `limit` up to which rings touch material, given the length of the arcs of the outermost ring.
fn outer_edge(ring: (f64, f64), limit: f64, mut touches: impl FnMut(f64) -> bool) -> f64 {
    let (mut inside, mut outside) = (ring.0, limit);
    if ring.1 == 0.0 || touches(inside + 0.99 * (outside - inside)) {
        return limit;
    }
    for _ in 0..6 {
        let middle = 0.5 * (inside + outside);
        if touches(middle) { inside = middle } else { outside = middle }
    }
    0.5 * (inside + outside)
}

/// Returns the share at which the slices of two rings meet: so that both with the arcs of their rings have the area that is between the rings,
/// whether the length of arcs steps from one's to the other's or changes smoothly.
fn edge_between([low, high]: [(f64, f64); 2], mut length_of: impl FnMut(f64) -> f64) -> f64 {
    let (mut from, mut to) = (low, high);
    if (high.1 - low.1).abs() <= STEP_OF_MATERIAL {
        return 0.5 * (low.0 + high.0);
    }
    let area = |a: (f64, f64), b: (f64, f64)| 0.5 * (a.1 + b.1) * (b.0 - a.0);
    let mut found = 0.0;
    for _ in 0..5 {
        let share = 0.5 * (from.0 + to.0);
        let middle = (share, length_of(share));
        // On with the half in which more changes.
        if (middle.1 - from.1).abs() < (to.1 - middle.1).abs() {
            found += area(from, middle);
            from = middle;
        } else {
            found += area(middle, to);
            to = middle;
        }
        if (to.1 - from.1).abs() <= STEP_OF_MATERIAL {
            break;
        }
    }
    found += area(from, to);
    ((found + low.0 * low.1 - high.0 * high.1) / (low.1 - high.1)).clamp(low.0, high.0)
}

impl Field {
    /// Returns the part of corner or point, as shares of it, that may touch material: by the columns below it, each with the cutter as low as over
    /// any point of its cell.
    fn nose_contact(&self, cutter: &Cutter, front: &Front) -> Option<(f64, f64)> {
        let (centre, heading) = front.plan();
        let half_cell = 0.5 * self.grid.size.norm();
        let reach = cutter.radius + half_cell;
        let [low, high] = [-reach, reach].map(|reach| self.grid.cell(centre + Vector2::repeat(reach)));
        let top = self.stock.bounds().1.z;
        let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                let from_tip = self.grid.centre(x, y) - centre;
                let squared = from_tip.norm_squared();
                let is_behind = front.vertical >= 0.0 && from_tip.dot(&heading) < -half_cell;
                if is_behind || squared > reach * reach || (nearest <= squared && squared <= farthest) {
                    continue;
                }
                let height = top.min(self.datum + f64::from(self.columns[self.grid.index(x, y)].height()));
                if height > front.height() + cutter.height_mm((squared.sqrt() - half_cell).max(0.0)) {
                    nearest = squared.min(nearest);
                    farthest = squared.max(farthest);
                }
            }
        }
        if farthest < nearest {
            return None;
        }
        let [nearest, farthest] = [nearest, farthest].map(f64::sqrt);
        let share = |distance: f64| cutter.nose_share(cutter.height_mm(distance));
        let (from, to) = (share((nearest - half_cell).max(0.0)), share(farthest + half_cell));
        let to = to.min(cutter.nose_share(top - front.height()));
        (from < to).then_some((from, to))
    }
}
