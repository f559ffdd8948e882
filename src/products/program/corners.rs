//! The cutting force round the corners of a program: it goes over from one move to the next, and does not jump.
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

use crate::{
    process::{
        Placed,
        cutting::{LoadError, PathLoad},
        file::Process,
    },
    spatial::Wrench,
    toolpath::{Load, PathPoint, Toolpath},
};

/// A jump of the load.
struct Corner {
    /// Length of the path up to it, mm.
    at_mm: f64,
    /// What the law gives on arrival.
    arriving: Vector6<f64>,
    /// Size of the jump, N.
    jump: f64,
}

/// A smaller jump is rounding, N.
const LEAST_JUMP: f64 = 1e-9;

/// In the size of a load, a moment counts as a force at this arm, mm: the radius of a cutter.
const ARM_MM: f64 = 10.0;

/// The corners of a path, its points taken one after another.
pub(super) struct Corners<'a> {
    process: &'a Process,
    path: &'a Toolpath,
    /// Those less than the length behind which the process gives.
    behind: Vec<Corner>,
}

impl<'a> Corners<'a> {
    /// Those of `path`, none of its points taken.
    pub fn new(process: &'a Process, path: &'a Toolpath) -> Self {
        Self { process, path, behind: Vec::new() }
    }

    /// The load at the next point, that with the index `k`, where workpiece and tool stand as `there` says: the jumps behind it are spread
    /// over the length that the process gives. Loads that come with the path or from a table stay, and so does where cutting begins and
    /// ends.
    ///
    /// # Errors
    /// A path that lacks what the cutting force needs.
    pub fn load(&mut self, k: usize, there: &Placed) -> Result<Load, LoadError> {
        let (length, point) = (self.process.corner_mm, &self.path.points()[k]);
        let law = self.process.load(point)?;
        let load = law.on_tool(point.tangent, there.tool_axes());
        if length == 0.0 || !point.cutting || matches!(law, PathLoad::Workpiece(_)) {
            self.behind.clear();
            return Ok(load);
        }
        let (at, own) = (point.arc_length_mm, six(&load));
        self.behind.retain(|corner| corner.at_mm > at - length);
        let corner = self.corner(k, &own, there)?;
        let gone_over = if self.behind.is_empty() { load } else { load_of(&self.gone_over(at, own)) };
        self.behind.extend(corner);
        Ok(gone_over)
    }

    /// The load at the length `at` of the path, where the law gives `own`.
    fn gone_over(&self, at: f64, own: Vector6<f64>) -> Vector6<f64> {
        let length = self.process.corner_mm;
        let (mut load, mut to, mut before) = (Vector6::zeros(), at, own);
        for corner in self.behind.iter().rev() {
            load += before * ((to - corner.at_mm) / length);
            let away = corner.arriving - before;
            let whole = size(&away);
            if whole > 0.0 {
                before += away * (corner.jump / whole).min(1.0);
            }
            to = corner.at_mm;
        }
        load + before * (1.0 - (at - to) / length)
    }

    /// The corner in point `k`, where the law gives `arriving`, if the load jumps there.
    fn corner(&self, k: usize, arriving: &Vector6<f64>, there: &Placed) -> Result<Option<Corner>, LoadError> {
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
        let departing = departing.on_tool(departure(from, to), there.tool_axes());
        let jump = size(&(six(&departing) - arriving));
        let corner = Corner { at_mm: from.arc_length_mm, arriving: *arriving, jump };
        Ok((jump > LEAST_JUMP).then_some(corner))
    }
}

/// Force and moment.
fn six(load: &Load) -> Vector6<f64> {
    Wrench { force: load.force_N, moment: load.moment_Nmm }.to_vector()
}

fn load_of(six: &Vector6<f64>) -> Load {
    let Wrench { force, moment } = Wrench::from_vector(six);
    Load { force_N: force, moment_Nmm: moment }
}

/// N.
fn size(difference: &Vector6<f64>) -> f64 {
    Wrench::from_vector(difference).norm(ARM_MM)
}

/// The direction in which a move begins that leads to its first point `to`: the chord halves the angle to the direction there, as it does
/// on lines and arcs.
fn departure(from: &PathPoint, to: &PathPoint) -> Vector3<f64> {
    match (to.position_mm - from.position_mm).try_normalize(1e-12) {
        Some(chord) => chord * (2.0 * chord.dot(&to.tangent)) - to.tangent,
        None => to.tangent,
    }
}
