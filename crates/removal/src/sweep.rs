//! The volume that a cutter sweeps on a straight move, as its lower envelope.

use nalgebra::{Vector2, Vector3};

use crate::cutter::{Cutter, Nose};

/// What touches within this is counted as cut, mm: a wall cut twice along the same path is air the second time.
pub(crate) const TOUCH: f64 = 1e-6;

/// A straight move of the tip. A vertical one is held as its lower end, as nothing else of it is left.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub(crate) struct Sweep {
    /// Where the tip starts.
    pub x: f64,
    pub y: f64,
    pub z: f64,
    /// Unit vector of the horizontal motion.
    pub ux: f64,
    pub uy: f64,
    /// Horizontal length, mm.
    pub length: f64,
    /// Rise per mm of horizontal length.
    pub slope: f64,
    /// Number of the cutter.
    pub cutter: u32,
    /// What the caller calls the move.
    pub tag: u32,
}

/// Where a swept cutter is at a point of the plan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    /// Height of the lower envelope; infinite where the cutter does not come.
    pub height: f64,
    /// Horizontal distance to the nearest point of the path, squared, mm².
    pub squared: f64,
}

impl Sweep {
    pub fn new(from: &Vector3<f64>, to: &Vector3<f64>, cutter: u32, tag: u32) -> Self {
        let along = (to - from).xy();
        let length = along.norm();
        // Shorter than this, direction and slope are of rounding, as is a rise of less.
        if length < 1e-9 {
            let low = if to.z < from.z { to } else { from };
            return Self { x: low.x, y: low.y, z: low.z, ux: 1.0, uy: 0.0, length: 0.0, slope: 0.0, cutter, tag };
        }
        let [ux, uy] = (along / length).into();
        let rise = if (to.z - from.z).abs() < 1e-9 { 0.0 } else { to.z - from.z };
        Self { x: from.x, y: from.y, z: from.z, ux, uy, length, slope: rise / length, cutter, tag }
    }

    /// Lowest height of the tip.
    pub fn lowest(&self) -> f64 {
        self.z + (self.slope * self.length).min(0.0)
    }

    /// Position of the tip after `along` mm of the horizontal path.
    pub fn position(&self, along: f64) -> Vector3<f64> {
        Vector3::new(self.x + along * self.ux, self.y + along * self.uy, self.tip(along))
    }

    /// Height of the tip after `along` mm of the horizontal path.
    fn tip(&self, along: f64) -> f64 {
        self.z + self.slope * along
    }

    /// Returns the length along the path of its point nearest to `p`, that of the foot on the unbounded line, and the distance to this line.
    #[inline]
    fn foot(&self, p: Vector2<f64>) -> (f64, f64, f64) {
        let (wx, wy) = (p.x - self.x, p.y - self.y);
        let along = wx * self.ux + wy * self.uy;
        (along.max(0.0).min(self.length), along, wy * self.ux - wx * self.uy)
    }

    /// Returns the square of the horizontal distance of `p` from the path.
    #[inline]
    pub fn squared(&self, p: Vector2<f64>) -> f64 {
        let (nearest, along, aside) = self.foot(p);
        aside * aside + (along - nearest) * (along - nearest)
    }

    /// Whether both are level moves of one cutter at one height.
    #[inline]
    pub fn is_level_with(&self, other: &Self) -> bool {
        self.slope == 0.0 && other.slope == 0.0 && self.z == other.z && self.cutter == other.cutter
    }

    /// Returns where the cutter comes at `p`.
    #[inline]
    pub fn reach(&self, cutter: &Cutter, p: Vector2<f64>) -> Reach {
        let (nearest, along, aside) = self.foot(p);
        let squared = aside * aside + (along - nearest) * (along - nearest);
        let reach = cutter.radius + TOUCH;
        if squared > reach * reach {
            return Reach { height: f64::INFINITY, squared };
        }
        let height = if self.slope == 0.0 {
            self.z + cutter.height_over(squared)
        } else {
            let lowest = self.lowest_along(cutter, along, aside.abs());
            self.tip(lowest) + cutter.height_over(aside * aside + (along - lowest) * (along - lowest))
        };
        Reach { height, squared }
    }

    /// Returns the length along the path of its point nearest to `p`.
    pub fn nearest(&self, p: Vector2<f64>) -> f64 {
        self.foot(p).0
    }

    /// Returns the length along the path at which the cutter is lowest over the point `p`, given that it comes there.
    pub fn generating(&self, cutter: &Cutter, p: Vector2<f64>) -> f64 {
        let (nearest, along, aside) = self.foot(p);
        if self.slope == 0.0 { nearest } else { self.lowest_along(cutter, along, aside.abs()) }
    }

    /// Returns where along a sloping path the cutter is lowest over a point whose foot is at `along`, `aside` from the line: the minimum of
    /// slope · s + g(√(aside² + (s − along)²)), convex in s, over the part of the path that comes within the radius.
    fn lowest_along(&self, cutter: &Cutter, along: f64, aside: f64) -> f64 {
        let reach = cutter.radius + TOUCH;
        let half = (reach * reach - aside * aside).max(0.0).sqrt();
        let (low, high) = ((along - half).max(0.0), (along + half).min(self.length));
        let falling = if self.slope > 0.0 { -half } else { half };
        // The offset s − along at which the derivative is zero.
        let offset = match cutter.nose {
            Nose::Rounded { flat: 0.0, corner } => {
                let chord = (corner * corner - aside * aside).max(0.0).sqrt();
                -self.slope * chord / (1.0 + self.slope * self.slope).sqrt()
            }
            Nose::Rounded { corner: 0.0, .. } => falling,
            Nose::Rounded { flat, corner } => self.bull_offset(flat, corner, aside, [low - along, high - along]),
            Nose::Cone { rise } => {
                let ratio = self.slope / rise;
                if ratio.abs() < 1.0 { -ratio * aside / (1.0 - ratio * ratio).sqrt() } else { falling }
            }
        };
        (along + offset).max(low).min(high)
    }

    /// Returns the offset between two at which a bull nose is lowest: safeguarded Newton steps on slope + g'(d) o/d, which rises with o.
    fn bull_offset(&self, flat: f64, corner: f64, aside: f64, [mut low, mut high]: [f64; 2]) -> f64 {
        // The derivative, and its own.
        let derivative = |offset: f64| {
            let distance = norm(aside, offset);
            let into = (distance - flat).clamp(0.0, corner);
            let rest = (corner * corner - into * into).sqrt();
            if into == 0.0 || rest == 0.0 {
                return (self.slope + if into == 0.0 { 0.0 } else { f64::INFINITY.copysign(offset) }, 0.0);
            }
            let (cosine, steepness) = (offset / distance, into / rest);
            let bent = corner * corner / (rest * rest * rest) * cosine * cosine
                + steepness * aside * aside / (distance * distance * distance);
            (self.slope + steepness * cosine, bent)
        };
        // Mostly an end of a short path.
        if derivative(low).0 >= 0.0 {
            return low;
        }
        if derivative(high).0 <= 0.0 {
            return high;
        }
        let mut offset = 0.5 * (low + high);
        for _ in 0..60 {
            let (value, bent) = derivative(offset);
            if value > 0.0 {
                high = offset
            } else {
                low = offset
            }
            let newton = offset - value / bent;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let step = (next - offset).abs();
            offset = next;
            // Steps square, and the height is flat here.
            if step <= 1e-7 {
                break;
            }
        }
        offset
    }

    /// Returns how far `p` lies within what the cutter, where the path is nearest to it, has cut at the height `z`: negative outside.
    pub fn clearance(&self, cutter: &Cutter, p: Vector2<f64>, z: f64) -> f64 {
        let (nearest, along, aside) = self.foot(p);
        match cutter.radius_at_mm(z - self.tip(nearest)) {
            Some(radius) => radius - norm(aside, along - nearest),
            None => f64::NEG_INFINITY,
        }
    }
}

/// √(a² + b²) with the same bits everywhere.
#[inline]
pub(crate) fn norm(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}
