//! Where a cutter touches material at an instant: arcs, depth, width, chip thickness, volume.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::Range;

use nalgebra::{Vector2, Vector3};

use crate::cutter::{Cutter, Part, Ring};
use crate::error::{RemovalError, finite, positive};
use crate::field::Field;
use crate::profile::{Front, Profile, View};

/// Into how many parts the surface of a cutter is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slicing {
    /// Largest height of a slice of the cylindrical part, mm.
    pub slice_mm: f64,
    /// Fewest slices of the engaged part of a corner or of a drill's point.
    pub nose_slices: u32,
    /// Points of the flat end along its radius, for a motion that leads down: what is narrower may be missed.
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
    profile: Profile,
    regions: Vec<[f64; 2]>,
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
        // Where the chip is, as its mean moment about the direction of motion over the edge: ∫ sin θ cos θ dθ.
        let of_arc = |arc: &Arc| libm::sin(arc.to).powi(2) - libm::sin(arc.from).powi(2);
        let (moment, edge) = self.slices.iter().fold((0.0, 0.0), |(moment, edge), slice| {
            let own: f64 = self.arcs[slice.arcs.clone()].iter().map(of_arc).sum();
            (moment + own * slice.edge_mm, edge + slice.edge_mm)
        });
        let moment = moment / edge;
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
    /// workpiece, mm; a vector of any length). Of a short move: its middle, with all moves before it cut and itself not. A direction that rises or falls by
    /// less than 1e-9 of its length is level.
    ///
    /// Slices end where the material behind the cutter has steps; where it slopes they are so low that integrals over their arcs are known within about
    /// 0.2 %. On the cylinder ends of arcs are found within 1e-3° at such steps. An arc between arcs of air is found if it is wider than 0.5°, on
    /// corner, point and end and on uncut stock that stands alone, a pin or a thin wall, as what is cut deeper than both of its sides, if it is wider than 5°; arcs that
    /// reach to 90° from the motion, as those of a wall beside it, if they are wider than 0.25°. Fails if a number is not finite, the direction has no
    /// length, or a number of `slicing` is not positive or makes more than 10,000 slices.
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
        let view = |part: Part, range: [f64; 2]| View { field: self, cutter, front: &front, part, range };
        let mut profile = std::mem::take(&mut engagement.profile);
        if front.vertical < 0.0 && cutter.end_radius() > 0.0 {
            let end = view(Part::End, [0.0, 1.0]);
            profile.fill_lines(&end, [-PI, PI], slicing.end_rings);
            // The end is no slice: it has no depth, and its chips no angle.
            engagement.end_area_mm2 = profile.volume(&end);
            engagement.volume_per_mm -= front.vertical * engagement.end_area_mm2;
        }
        let nose = cutter.nose_height_mm();
        if nose > 0.0
            && let Some(Contact { shares, angles }) = self.nose_contact(cutter, &front)
        {
            let view = view(Part::Nose, shares);
            profile.fill_lines(&view, angles, LINE_STEPS);
            engagement.add(&view, &mut profile, |[low, high], [bottom, top]| {
                (high - low) / (top - bottom) * f64::from(slicing.nose_slices)
            });
        }
        // Below the stock there is nothing to slice.
        let bottom = nose.max(low.z - tip.z);
        if bottom < high.z - tip.z {
            let view = view(Part::Side, [bottom, high.z - tip.z]);
            profile.fill_side(&view);
            engagement.add(&view, &mut profile, |[low, high], _| (high - low) / slicing.slice_mm);
        }
        engagement.profile = profile;
        Ok(())
    }
}

impl Engagement {
    /// Adds the volume of a part, and its regions as slices: each as many as `slices` says of it and of all that is in material.
    fn add(&mut self, view: &View<'_>, profile: &mut Profile, slices: impl Fn([f64; 2], [f64; 2]) -> f64) {
        let mut regions = std::mem::take(&mut self.regions);
        profile.regions(&mut regions);
        if let (Some(first), Some(last)) = (regions.first(), regions.last()) {
            self.volume_per_mm += profile.volume(view);
            let all = [first[0], last[1]];
            for [low, high] in &regions {
                let count = (slices([*low, *high], all) * (1.0 - 1e-9)).ceil().max(1.0);
                let at = |slice: f64| low + (high - low) * (slice / count);
                let mut arcs = self.arcs.len()..self.arcs.len();
                for slice in 0..count as u32 {
                    let (from, to) = (at(f64::from(slice)), at(f64::from(slice + 1)));
                    // Slices of a region of the cylinder have arcs in common.
                    if slice == 0 || view.part != Part::Side {
                        let middle = if view.part == Part::Side { 0.5 * (low + high) } else { 0.5 * (from + to) };
                        let start = self.arcs.len();
                        profile.arcs(middle, &mut self.arcs);
                        arcs = start..self.arcs.len();
                    }
                    self.add_slice(&view.cutter.ring(view.part, from, to), view.front, arcs.clone());
                }
            }
        }
        self.regions = regions;
    }

    /// Adds a slice if it has arcs and a height, but not its volume.
    fn add_slice(&mut self, ring: &Ring, front: &Front, arcs: Range<usize>) {
        if arcs.is_empty() || ring.top <= ring.bottom {
            return;
        }
        let radius = ring.side / (ring.top - ring.bottom);
        let across = |angle: f64| libm::sin(angle.clamp(-FRAC_PI_2, FRAC_PI_2));
        let mut width = 0.0;
        for arc in &self.arcs[arcs.clone()] {
            width += radius * (across(arc.to) - across(arc.from));
            self.chip_ratio = self.chip_ratio.max(front.chip(ring, arc));
        }
        self.width_mm = self.width_mm.max(width);
        self.depth_mm = self.depth_mm.max(ring.top);
        self.slices.push(Slice {
            bottom_mm: ring.bottom,
            top_mm: ring.top,
            radius_mm: radius,
            edge_mm: ring.edge,
            run_mm: ring.run,
            arcs,
        });
    }
}

/// What is left may rise by so much against the cutter's surface from the centre of a cell, mm for each mm, where that is level.
const OFF_CENTRE: f64 = 0.15;
/// Points at which lines down corner or point are looked at before ends of material between them are sought.
const LINE_STEPS: u32 = 6;

/// Where corner or point may touch material.
struct Contact {
    /// Shares of it.
    shares: [f64; 2],
    /// Angles θ, the first at least −π.
    angles: [f64; 2],
}

/// A range of directions in the plan that grows with each, counted by |sin| / (|sin| + |cos|) through the quadrants: from −2 behind the motion to 2, and from 0
/// ahead of it to 4.
#[derive(Clone, Copy)]
struct Directions {
    ahead: [f64; 2],
    behind: [f64; 2],
}

impl Directions {
    const NONE: Self = Self { ahead: [f64::INFINITY, f64::NEG_INFINITY], behind: [f64::INFINITY, f64::NEG_INFINITY] };

    /// Counts the direction `along` the motion and to its `left` from it.
    fn count(along: f64, left: f64) -> f64 {
        let share = left / (along.abs() + left.abs()).max(f64::MIN_POSITIVE);
        if along >= 0.0 { share } else { 2.0_f64.copysign(left) - share }
    }

    fn around(count: f64) -> f64 {
        if count < 0.0 { count + 4.0 } else { count }
    }

    fn has(&self, count: f64) -> bool {
        let is_in = |[low, high]: [f64; 2], own: f64| low <= own && own <= high;
        is_in(self.ahead, count) && is_in(self.behind, Self::around(count))
    }

    fn add(&mut self, count: f64) {
        let grow = |range: &mut [f64; 2], own: f64| *range = [range[0].min(own), range[1].max(own)];
        grow(&mut self.ahead, count);
        grow(&mut self.behind, Self::around(count));
    }

    /// Returns the angles between which they are, counted from behind the motion or, if that is clearly narrower, from ahead of it.
    fn angles(&self) -> [f64; 2] {
        let [ahead, behind] = [self.ahead, self.behind].map(|own| own[1] - own[0]);
        let narrow = if behind + 0.1 < ahead { self.behind } else { self.ahead };
        narrow.map(|count| {
            let turned = if count > 2.0 { count - 4.0 } else { count };
            let (along, left) = if turned.abs() <= 1.0 {
                (1.0 - turned.abs(), turned)
            } else {
                (1.0 - turned.abs(), (2.0 - turned.abs()).copysign(turned))
            };
            let angle = libm::atan2(left, along);
            if count > 2.0 { angle + TAU } else { angle }
        })
    }
}

impl Field {
    /// Returns where corner or point may touch material: by the columns below it, each with the cutter as low as over any point of its cell; `None`
    /// if nowhere.
    fn nose_contact(&self, cutter: &Cutter, front: &Front) -> Option<Contact> {
        let (centre, heading) = front.plan();
        // A wall may be as far from the centres on both sides of it.
        let (cell, half_cell) = (self.grid.size.norm(), 0.5 * self.grid.size.norm());
        let reach = cutter.radius + cell;
        let [low, high] = [-reach, reach].map(|reach| self.grid.cell(centre + Vector2::repeat(reach)));
        let top = self.stock.bounds().1.z;
        let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut directions = Directions::NONE;
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                let from_tip = self.grid.centre(x, y) - centre;
                let squared = from_tip.norm_squared();
                let along = from_tip.dot(&heading);
                if squared > reach * reach || (front.vertical >= 0.0 && along < -cell) {
                    continue;
                }
                let direction = Directions::count(along, heading.perp(&from_tip));
                if nearest <= squared && squared <= farthest && directions.has(direction) {
                    continue;
                }
                let height = top.min(self.datum + f64::from(self.columns[self.grid.index(x, y)].height()));
                let height = height + OFF_CENTRE * half_cell;
                if height > front.height() + cutter.height_mm((squared.sqrt() - half_cell).max(0.0)) {
                    (nearest, farthest) = (nearest.min(squared), farthest.max(squared));
                    directions.add(direction);
                }
            }
        }
        if farthest < nearest {
            return None;
        }
        let [nearest, farthest] = [nearest, farthest].map(f64::sqrt);
        let share = |distance: f64| cutter.nose_share(cutter.height_mm(distance));
        let (from, to) = (share((nearest - cell).max(0.0)), share(farthest + cell));
        let to = to.min(cutter.nose_share(top - front.height()));
        let [mut right, mut left] = directions.angles();
        let beside = if nearest > cell { libm::asin(cell / nearest) } else { PI };
        (right, left) = (right - beside, left + beside);
        if left - right >= TAU {
            (right, left) = (-PI, PI);
        }
        if front.vertical >= 0.0 {
            (right, left) = (right.max(-FRAC_PI_2), left.min(FRAC_PI_2));
        } else if right < -PI {
            (right, left) = (right + TAU, left + TAU);
        }
        (from < to && right < left).then_some(Contact { shares: [from, to], angles: [right, left] })
    }
}
