//! Cutters: bodies of revolution about the vertical, open upwards.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use crate::error::{RemovalError, positive};
use crate::sweep::norm;

/// A cutter as its cutting part: what the rotating edges sweep, and everything above it. Shank and holder are not part of it.
///
/// At the distance d from its axis its surface is g(d) above the tip, convex and not falling, up to its radius R:
///
/// ```text
/// rounded   g = 0 for d ≤ R − c,   g = c − √(c² − (d − R + c)²) beyond      c corner radius: 0 flat, R ball
/// drill     g = d / tan(σ/2)                                              σ point angle
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutter {
    pub(crate) radius: f64,
    pub(crate) nose: Nose,
}

/// The lower end of a cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Nose {
    /// A flat end of radius `flat` with a corner of radius `corner`: they add up to the cutter's radius.
    Rounded { flat: f64, corner: f64 },
    /// A cone that rises by `rise` per mm of radius.
    Cone { rise: f64 },
}

impl Cutter {
    /// Makes a flat end mill of `diameter_mm`. Fails if it is not positive.
    pub fn flat(diameter_mm: f64) -> Result<Self, RemovalError> {
        Self::bull(diameter_mm, 0.0)
    }

    /// Makes a ball end mill of `diameter_mm`. Fails if it is not positive.
    pub fn ball(diameter_mm: f64) -> Result<Self, RemovalError> {
        Self::bull(diameter_mm, diameter_mm / 2.0)
    }

    /// Makes a bull-nose end mill of `diameter_mm` with corners of radius `corner_mm`, from 0 (flat) to half the diameter (ball). Fails
    /// otherwise.
    pub fn bull(diameter_mm: f64, corner_mm: f64) -> Result<Self, RemovalError> {
        let radius = positive("diameter of the cutter", diameter_mm)? / 2.0;
        if !(0.0..=radius).contains(&corner_mm) {
            return Err(RemovalError::Corner { corner_mm, radius_mm: radius });
        }
        Ok(Self { radius, nose: Nose::Rounded { flat: radius - corner_mm, corner: corner_mm } })
    }

    /// Makes a drill of `diameter_mm` with the point angle `angle_deg` (118° is usual). Fails unless it is between 0 and 180°.
    pub fn drill(diameter_mm: f64, angle_deg: f64) -> Result<Self, RemovalError> {
        let radius = positive("diameter of the drill", diameter_mm)? / 2.0;
        if !(angle_deg > 0.0 && angle_deg < 180.0) {
            return Err(RemovalError::PointAngle { angle_deg });
        }
        Ok(Self { radius, nose: Nose::Cone { rise: 1.0 / libm::tan(angle_deg.to_radians() / 2.0) } })
    }

    /// Returns the cutter whose surface is everywhere `by` (mm) inside of this one, and how much higher its tip is, mm; `None` if nothing is left.
    #[must_use]
    pub fn inside(&self, by: f64) -> Option<(Self, f64)> {
        let radius = self.radius - by;
        let (nose, up) = match self.nose {
            Nose::Rounded { flat, corner } if corner >= by => (Nose::Rounded { flat, corner: corner - by }, by),
            Nose::Rounded { .. } => (Nose::Rounded { flat: radius, corner: 0.0 }, by),
            Nose::Cone { rise } => (Nose::Cone { rise }, by * norm(rise, 1.0)),
        };
        (radius > 0.0).then_some((Self { radius, nose }, up))
    }

    /// R, mm.
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        self.radius
    }

    /// Height above the tip from which the cutter is a cylinder, mm: the corner radius, or the height of a drill's point.
    #[must_use]
    pub fn nose_height_mm(&self) -> f64 {
        match self.nose {
            Nose::Rounded { corner, .. } => corner,
            Nose::Cone { rise } => rise * self.radius,
        }
    }

    /// Returns g(d), the height above the tip of the lower surface at the distance d = `distance` from the axis, mm; that at the rim beyond it.
    #[must_use]
    #[inline]
    pub fn height_mm(&self, distance: f64) -> f64 {
        match self.nose {
            Nose::Rounded { flat, .. } if distance <= flat => 0.0,
            Nose::Rounded { flat, corner } => {
                let into = (distance - flat).min(corner);
                corner - (corner * corner - into * into).sqrt()
            }
            Nose::Cone { rise } => rise * distance.min(self.radius),
        }
    }

    /// Returns g(d) at the square of d.
    #[inline]
    pub(crate) fn height_over(&self, squared: f64) -> f64 {
        match self.nose {
            Nose::Rounded { flat: 0.0, corner } => corner - (corner * corner - squared).max(0.0).sqrt(),
            Nose::Rounded { corner: 0.0, .. } => 0.0,
            _ => self.height_mm(squared.sqrt()),
        }
    }

    /// Returns the radius of the cutter at `height` above its tip, mm; `None` below the tip.
    #[must_use]
    pub fn radius_at_mm(&self, height: f64) -> Option<f64> {
        if height < 0.0 {
            return None;
        }
        Some(match self.nose {
            Nose::Rounded { flat, corner } => {
                let below = (corner - height).max(0.0);
                flat + (corner * corner - below * below).max(0.0).sqrt()
            }
            Nose::Cone { rise } => (height / rise).min(self.radius),
        })
    }

    /// Returns the outward unit normal of the lower surface at the point `from_tip`, of which the plan counts.
    pub(crate) fn normal(&self, from_tip: &Vector3<f64>) -> Vector3<f64> {
        let distance = from_tip.xy().norm();
        // The slope of g as a sine and a cosine.
        let (sine, cosine) = match self.nose {
            Nose::Rounded { flat, corner } if distance > flat && corner > 0.0 => {
                let sine = ((distance - flat) / corner).min(1.0);
                (sine, (1.0 - sine * sine).sqrt())
            }
            Nose::Rounded { .. } => (0.0, 1.0),
            Nose::Cone { rise } => (rise / norm(rise, 1.0), 1.0 / norm(rise, 1.0)),
        };
        let outward = from_tip.xy().try_normalize(f64::MIN_POSITIVE).unwrap_or_default() * sine;
        Vector3::new(outward.x, outward.y, -cosine)
    }

    /// Radius of the flat end, mm.
    pub(crate) fn end_radius(&self) -> f64 {
        match self.nose {
            Nose::Rounded { flat, .. } => flat,
            Nose::Cone { .. } => 0.0,
        }
    }

    /// Returns distance from the axis and height above the tip at a place of a part, as [`Part`] counts.
    pub(crate) fn place(&self, part: Part, at: f64) -> (f64, f64) {
        match (part, self.nose) {
            (Part::Side, _) => (self.radius, at),
            (Part::End, _) => (self.end_radius() * at, 0.0),
            (Part::Nose, Nose::Rounded { flat, corner }) => {
                let (sine, cosine) = libm::sincos(at * FRAC_PI_2);
                (flat + corner * sine, corner * (1.0 - cosine))
            }
            (Part::Nose, Nose::Cone { rise }) => (self.radius * at, rise * self.radius * at),
        }
    }

    /// Returns the ring of a part between two of its places.
    pub(crate) fn ring(&self, part: Part, from: f64, to: f64) -> Ring {
        let ((inner, bottom), (outer, top)) = (self.place(part, from), self.place(part, to));
        let run = outer - inner;
        let down = 0.5 * run * (outer + inner);
        let (side, edge) = match (part, self.nose) {
            (Part::Side, _) => (self.radius * (top - bottom), top - bottom),
            (Part::End, _) => (0.0, run),
            (Part::Nose, Nose::Rounded { flat, corner }) => {
                // ∫ r du with r = flat + c sin φ and du = c sin φ dφ.
                let round = |share: f64| {
                    let angle = share * FRAC_PI_2;
                    0.5 * corner * corner * (angle - 0.5 * libm::sin(2.0 * angle))
                };
                (flat * (top - bottom) + round(to) - round(from), corner * (to - from) * FRAC_PI_2)
            }
            (Part::Nose, Nose::Cone { rise }) => (rise * down, run * norm(rise, 1.0)),
        };
        Ring { bottom, top, side, down, edge, run }
    }

    /// Returns the share of corner or point that is up to `height` above the tip.
    pub(crate) fn nose_share(&self, height: f64) -> f64 {
        match self.nose {
            Nose::Rounded { corner, .. } if corner > 0.0 => {
                libm::acos((1.0 - height / corner).clamp(0.0, 1.0)) / FRAC_PI_2
            }
            Nose::Rounded { .. } => 1.0,
            Nose::Cone { rise } => (height / (rise * self.radius)).clamp(0.0, 1.0),
        }
    }

    /// Returns the share of corner or point up to which its normal is less than `tangent` off from straight down, by its tangent.
    pub(crate) fn nose_share_below(&self, tangent: f64) -> f64 {
        match self.nose {
            Nose::Rounded { .. } => libm::atan(tangent) / FRAC_PI_2,
            Nose::Cone { rise } => f64::from(u8::from(rise < tangent)),
        }
    }
}

/// A part of the cutter's surface, and how places on it are counted from its axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Part {
    /// The flat end, by shares of its radius.
    End,
    /// Corner or point, by shares of the corner's angle or of the point's height.
    Nose,
    /// The cylinder, by heights above the tip, mm.
    #[default]
    Side,
}

/// A ring of the cutter's surface, about its axis. Its area is known exactly by its projections per radian of the ring.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ring {
    /// Heights above the tip between which it is, mm.
    pub bottom: f64,
    pub top: f64,
    /// ∫ n_r dA per radian: what it shows sideways, mm².
    pub side: f64,
    /// −∫ n_z dA per radian: what it shows downwards, mm².
    pub down: f64,
    /// Length of its meridian, and how much its radius grows over it, mm.
    pub edge: f64,
    /// The latter.
    pub run: f64,
}
