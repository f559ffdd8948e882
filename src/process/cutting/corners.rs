//! Blends the cutting force at the corners of a program: it passes gradually from one move to the next.
//!
//! Where two cutting moves meet in a corner, a law that follows the direction of motion gives two loads there, A of arrival and D of
//! departure. A control slows down or rounds the corner, and a cutter enters the new cut as it goes. The load is therefore A up to the
//! corner and goes over to the law L evenly along the length b behind it. At the distance s behind the corner it is
//!
//! ```text
//! s/b L + (1 − s/b) Y      Y = L + min(1, |D − A| / |L − A|) (A − L)
//! ```
//!
//! On a line L stays D, and Y is A. On an arc L turns meanwhile, and what turned smoothly stays as it is: Y is nearer to L than A by so
//! much that L is left by no more than the jump, and a corner that is none but for rounding changes nothing but rounding. Of several
//! corners closer than b, each share of the length behind has the Y of its corner, Y of the corner after it in place of L. All of this
//! lies between the law's loads at the point and those that arrive at the corners: loads on the tool about its tip, in axes of W.

use nalgebra::{Vector3, Vector6};

use super::{LoadError, PathLoad};
use crate::{
    process::{PlacedWorkpiece, file::Process},
    spatial::Wrench,
    toolpath::{Load, PathPoint, Toolpath},
};

/// A corner of the path at which the load jumps.
struct Corner {
    /// Arc length of the path up to the corner, mm.
    at_mm: f64,
    /// Load of the cutting-force law on arrival: force and moment, N and N·mm.
    arriving: Vector6<f64>,
    /// Size of the jump in load, N.
    jump: f64,
}

/// A jump of the load below this is rounding, N.
const LEAST_JUMP: f64 = 1e-9;

/// Lever arm at which a moment counts as a force in the size of a load, mm: about the radius of a cutter.
const ARM_MM: f64 = 10.0;

/// Blends the load along a path, whose points are visited in order.
pub(crate) struct Corners<'a> {
    process: &'a Process,
    path: &'a Toolpath,
    /// Corners passed within the blending length of the process.
    behind: Vec<Corner>,
}

impl<'a> Corners<'a> {
    /// Starts at the beginning of `path`.
    pub fn new(process: &'a Process, path: &'a Toolpath) -> Self {
        Self { process, path, behind: Vec::new() }
    }

    /// Returns the blended load at the next point, number `k`, about the tool tip in axes of W, where workpiece and tool are placed as in
    /// `there`. Loads given by the path or a table are not blended, nor is the load where cutting begins or ends.
    pub fn load(&mut self, k: usize, there: &PlacedWorkpiece) -> Result<Load, LoadError> {
        let (length, point) = (self.process.corner_mm, &self.path.points()[k]);
        let law = self.process.load(point)?;
        let load = law.on_tool(point.tangent, there.tool_axes());
        if length == 0.0 || !point.cutting || matches!(law, PathLoad::Workpiece(_)) {
            self.behind.clear();
            return Ok(load);
        }
        let (along, law_load) = (point.arc_length_mm, to_vector(&load));
        self.behind.retain(|corner| corner.at_mm > along - length);
        let corner = self.corner(k, &law_load, there)?;
        let blended_load = if self.behind.is_empty() { load } else { from_vector(&self.blended_load(along, law_load)) };
        self.behind.extend(corner);
        Ok(blended_load)
    }

    /// Returns the blended load at arc length `at`, mm, where the law gives `law_load`: N and N·mm.
    fn blended_load(&self, at: f64, law_load: Vector6<f64>) -> Vector6<f64> {
        let length = self.process.corner_mm;
        let (mut load, mut to, mut before) = (Vector6::zeros(), at, law_load);
        for corner in self.behind.iter().rev() {
            load += before * ((to - corner.at_mm) / length);
            let away = corner.arriving - before;
            let whole = load_norm(&away);
            if whole > 0.0 {
                before += away * (corner.jump / whole).min(1.0);
            }
            to = corner.at_mm;
        }
        load + before * (1.0 - (at - to) / length)
    }

    /// Returns the corner in point `k`, where the law gives the load `arriving` (N, N·mm); `None` if the load does not jump there.
    fn corner(&self, k: usize, arriving: &Vector6<f64>, there: &PlacedWorkpiece) -> Result<Option<Corner>, LoadError> {
        let Some([from, to]) = self.path.points().get(k..k + 2).and_then(|pair| <&[PathPoint; 2]>::try_from(pair).ok())
        else {
            return Ok(None);
        };
        if !to.cutting || from.source.segment == to.source.segment {
            return Ok(None);
        }
        let departing = self.process.load(to)?;
        if matches!(departing, PathLoad::Workpiece(_)) {
            return Ok(None);
        }
        let departing = departing.on_tool(departure_direction(from, to), there.tool_axes());
        let jump = load_norm(&(to_vector(&departing) - arriving));
        let corner = Corner { at_mm: from.arc_length_mm, arriving: *arriving, jump };
        Ok((jump > LEAST_JUMP).then_some(corner))
    }
}

/// Returns force and moment of a load as six components, N and N·mm.
fn to_vector(load: &Load) -> Vector6<f64> {
    Wrench { force: load.force_N, moment: load.moment_Nmm }.to_vector()
}

/// Returns the load with these six components, N and N·mm.
fn from_vector(six: &Vector6<f64>) -> Load {
    let Wrench { force, moment } = Wrench::from_vector(six);
    Load { force_N: force, moment_Nmm: moment }
}

/// Returns the size of a load, N, its moment divided by the lever arm.
fn load_norm(difference: &Vector6<f64>) -> f64 {
    Wrench::from_vector(difference).norm(ARM_MM)
}

/// Returns the direction in which a move begins that leads to its first point `to`: on lines and arcs the chord halves the angle to the tangent.
fn departure_direction(from: &PathPoint, to: &PathPoint) -> Vector3<f64> {
    match (to.position_mm - from.position_mm).try_normalize(1e-12) {
        Some(chord) => chord * (2.0 * chord.dot(&to.tangent)) - to.tangent,
        None => to.tangent,
    }
}
