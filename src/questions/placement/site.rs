//! Coordinates of a workpiece's place, their bounds, and the grid of a sweep.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::process::{PathReference, Placement};

/// Names of the coordinates of a [`Site`], in the order of its numbers.
pub const COORDINATES: [&str; 6] = ["x", "y", "z", "yaw", "pitch", "roll"];
/// Units in which they are shown.
pub const UNITS: [&str; 6] = ["mm", "mm", "mm", "deg", "deg", "deg"];
/// Number of coordinates.
const N: usize = COORDINATES.len();

/// A place for the workpiece: origin of W in O, mm, and its angles, rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Site(
    /// x, y, z in mm; yaw, pitch and roll in rad, see [`Placement`].
    pub [f64; N],
);

impl Site {
    /// Makes a place from the origin of W in O (mm) and its angle about z (rad).
    pub fn new(position_mm: Vector3<f64>, yaw_rad: f64) -> Self {
        Self([position_mm.x, position_mm.y, position_mm.z, yaw_rad, 0.0, 0.0])
    }

    /// Returns the origin of W in O, mm.
    pub fn position_mm(&self) -> Vector3<f64> {
        Vector3::new(self.0[0], self.0[1], self.0[2])
    }

    /// Returns the coordinates in mm and degrees, rounded to 1e-9 degrees.
    pub fn shown(&self) -> [f64; N] {
        // The way through radians must not show.
        let degrees = |angle: f64| (angle.to_degrees() * 1e9).round() / 1e9;
        std::array::from_fn(|i| if is_angle(i) { degrees(self.0[i]) } else { self.0[i] })
    }

    /// Returns the placement, at this place, of a path whose positions are those of `reference`, P or the tool tip.
    pub fn placement(&self, reference: PathReference) -> Placement {
        let [.., yaw, pitch, roll] = self.0;
        Placement { origin_mm: self.position_mm(), roll_pitch_yaw: Vector3::new(roll, pitch, yaw), reference }
    }
}

/// Returns whether a coordinate is an angle.
pub fn is_angle(coordinate: usize) -> bool {
    UNITS[coordinate] == "deg"
}

/// Returns the unit of a coordinate to be appended to a number: "°" or " mm".
#[cfg(feature = "report")]
pub(super) fn unit_suffix(coordinate: usize) -> &'static str {
    if is_angle(coordinate) { "°" } else { " mm" }
}

/// Converts a distance along the site coordinate with this index from mm or rad to mm or degrees, as shown.
#[cfg(feature = "report")]
pub(super) fn in_unit(coordinate: usize, distance: f64) -> f64 {
    if is_angle(coordinate) { distance.to_degrees() } else { distance }
}

/// Steps per mm and per degree to which found places are rounded before they are judged, so that a place is what is printed.
const PRINTED_STEPS: [f64; 2] = [100.0, 10.0];

/// Returns `value`, mm or degrees, in one decimal, in two if it has two, or in all its digits: what is read is the place itself.
#[cfg(feature = "report")]
pub(super) fn printed_text(value: f64) -> String {
    let rounded = [1, 2].map(|decimals| format!("{value:.decimals$}"));
    let is_all = |words: &String| words.parse::<f64>().is_ok_and(|rounded| (rounded - value).abs() < 1e-8);
    let words = rounded.into_iter().find(is_all).unwrap_or_else(|| value.to_string());
    if words.parse() == Ok(0.0) { words.replace('-', "") } else { words }
}

/// Differences below this share of a coordinate's range, or of 1 mm or rad, are rounding.
const ROUNDING: f64 = 1e-9;

/// Smallest and largest value of each coordinate; equal ends fix it. The ends of an angle that may make a full turn are one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Smallest values, mm and rad.
    pub low: [f64; N],
    /// Largest values, mm and rad.
    pub high: [f64; N],
}

impl Bounds {
    /// Returns the indices of the coordinates that are not fixed.
    pub fn free(&self) -> Vec<usize> {
        (0..N).filter(|&i| self.high[i] > self.low[i]).collect()
    }

    /// Returns the length of a coordinate's range, mm or rad.
    pub fn range(&self, coordinate: usize) -> f64 {
        self.high[coordinate] - self.low[coordinate]
    }

    /// Returns whether a coordinate is an angle that may take any value.
    pub fn is_full_turn(&self, coordinate: usize) -> bool {
        is_angle(coordinate) && self.range(coordinate) >= TAU * (1.0 - ROUNDING)
    }

    /// Returns the distance between two values of a coordinate, mm or rad; the shorter arc where it may make a full turn.
    pub fn distance(&self, coordinate: usize, a: f64, b: f64) -> f64 {
        let distance = (a - b).abs();
        if self.is_full_turn(coordinate) { (distance - (distance / TAU).round() * TAU).abs() } else { distance }
    }

    /// Returns `site` within the bounds, clamped where it is off by rounding, its angles shifted by full turns; `None` if it lies outside.
    pub fn inside(&self, site: &Site) -> Option<Site> {
        let mut inside = *site;
        for (i, value) in inside.0.iter_mut().enumerate() {
            let (low, high) = (self.low[i], self.high[i]);
            let slack = ROUNDING * self.range(i).max(1.0);
            if is_angle(i) {
                *value -= ((*value - low + slack) / TAU).floor() * TAU;
            }
            if !(low - slack..=high + slack).contains(value) {
                return None;
            }
            *value = value.clamp(low, high);
        }
        Some(inside)
    }

    /// Returns the places around `site` as they are printed, to 0.01 mm and 0.1°, within the bounds, nearest first, and at last `site`.
    pub fn printed(&self, site: &Site) -> Vec<Site> {
        let mut around = vec![(0.0, *site)];
        for i in self.free() {
            let scale = PRINTED_STEPS[usize::from(is_angle(i))];
            let shown = scale * if is_angle(i) { site.0[i].to_degrees() } else { site.0[i] };
            // Degrees that were whole steps may be off by rounding.
            let ends = if (shown - shown.round()).abs() < 1e-7 {
                vec![shown.round()]
            } else {
                vec![shown.floor(), shown.ceil()]
            };
            let rounded = |(off, site): &(f64, Site)| {
                let (off, site) = (*off, *site);
                let to = ends.iter().map(move |end| {
                    let (mut site, value) = (site, end / scale + 0.0);
                    site.0[i] = if is_angle(i) { value.to_radians() } else { value };
                    (off + (end - shown).powi(2), site)
                });
                to.filter(|(_, site)| (self.low[i]..=self.high[i]).contains(&site.0[i])).collect::<Vec<_>>()
            };
            around = around.iter().flat_map(rounded).collect();
        }
        around.sort_by(|a, b| a.0.total_cmp(&b.0));
        around.into_iter().map(|(_, site)| site).chain([*site]).collect()
    }

    /// Returns `site` moved along one coordinate by `by`, mm or rad, clamped to the bounds, or wrapped where it may make a full turn.
    pub fn moved(&self, site: &Site, coordinate: usize, by: f64) -> Site {
        let (low, high) = (self.low[coordinate], self.high[coordinate]);
        let mut moved = *site;
        let value = moved.0[coordinate] + by;
        moved.0[coordinate] = match self.is_full_turn(coordinate) {
            true => low + (value - low).rem_euclid(TAU),
            false => value.clamp(low, high),
        };
        moved
    }

    /// Returns `count` equally spaced values of a coordinate, with both ends unless these are one angle; a single one lies in the middle.
    pub fn values(&self, coordinate: usize, count: usize) -> Vec<f64> {
        let (low, high) = (self.low[coordinate], self.high[coordinate]);
        match count {
            1 => vec![0.5 * (low + high)],
            n if self.is_full_turn(coordinate) => (0..n).map(|k| low + (high - low) * k as f64 / n as f64).collect(),
            n => {
                (0..n).map(|k| if k + 1 == n { high } else { low + (high - low) * k as f64 / (n - 1) as f64 }).collect()
            }
        }
    }
}

/// The grid of places of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct SiteGrid {
    /// Values of x, y, z (mm), yaw, pitch and roll (rad), ascending.
    pub axes: [Vec<f64>; N],
}

impl SiteGrid {
    /// Makes a grid with `counts` values of each coordinate within `bounds`.
    pub fn new(bounds: &Bounds, counts: [usize; N]) -> Self {
        Self { axes: std::array::from_fn(|i| bounds.values(i, counts[i])) }
    }

    /// Returns the number of values of each coordinate.
    pub fn counts(&self) -> [usize; N] {
        std::array::from_fn(|i| self.axes[i].len())
    }

    /// Returns the number of places.
    pub fn len(&self) -> usize {
        self.counts().iter().product()
    }

    /// Returns whether there is no place.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the place with this index; x runs fastest, then y, z, yaw, pitch, roll.
    pub fn site(&self, index: usize) -> Site {
        let mut rest = index;
        Site(std::array::from_fn(|i| {
            let n = self.axes[i].len();
            let value = self.axes[i][rest % n];
            rest /= n;
            value
        }))
    }

    /// Returns the index of the place with these positions on the axes; the inverse of [`SiteGrid::site`].
    pub fn index(&self, positions: [usize; N]) -> usize {
        (0..N).rev().fold(0, |index, i| index * self.axes[i].len() + positions[i])
    }

    /// Returns the step of a coordinate between neighbouring places, mm or rad; its whole range if there is only one.
    pub fn step(&self, coordinate: usize, bounds: &Bounds) -> f64 {
        match self.axes[coordinate].as_slice() {
            [first, second, ..] => second - first,
            _ => bounds.range(coordinate),
        }
    }
}
