//! The cutting force round the corners of a program: it goes over from one move to the next, and does not jump.
//!
//! Where two cutting moves meet in a corner, a law that follows the direction of motion gives two wrenches there, w₁ of arrival and
//! w₂ of departure. A control slows down or rounds the corner, and a cutter enters the new cut as it goes. The wrench is therefore
//! that of arrival up to the corner, and over a length b behind it the jump J = w₂ − w₁ comes in evenly: at the distance u b
//! behind the corner, J (1 − u) is taken off what the law gives there. What changes smoothly stays as it is.

use nalgebra::{Vector3, Vector6};

use crate::{
    compensation::Demand,
    process::{
        cutting::{LoadError, PathLoad},
        file::Process,
    },
    spatial::Wrench,
    study::demands::Led,
    toolpath::{PathPoint, Toolpath},
};

/// A jump of the wrench.
struct Corner {
    /// Length of the path up to it, mm.
    at_mm: f64,
    jump: Vector6<f64>,
}

/// A smaller jump is rounding, in N and N·mm.
const LEAST_JUMP: f64 = 1e-9;

/// The corners of a path, its points taken one after another.
pub(super) struct Corners<'a> {
    process: &'a Process,
    path: &'a Toolpath,
    led: Led<'a>,
    /// Those less than the length behind which the process gives.
    behind: Vec<Corner>,
}

impl<'a> Corners<'a> {
    /// Those of `path`, none of its points taken.
    pub fn new(process: &'a Process, path: &'a Toolpath) -> Self {
        Self { process, path, led: Led::new(&process.machine, &process.placement), behind: Vec::new() }
    }

    /// `demand` of the next point, that with the index `k`, the jumps of the wrench behind it spread over the length that the process
    /// gives. Loads that come with the path or from a table stay, and so does where cutting begins and ends.
    ///
    /// # Errors
    /// A path that lacks what the cutting force needs.
    pub fn rounded(&mut self, k: usize, demand: Demand) -> Result<Demand, LoadError> {
        let (length, point) = (self.process.corner_mm, &self.path.points()[k]);
        if length == 0.0 {
            return Ok(demand);
        }
        if !point.cutting {
            self.behind.clear();
            return Ok(demand);
        }
        let at = point.arc_length_mm;
        self.behind.retain(|corner| corner.at_mm > at - length);
        let mut rounded = demand;
        if !self.behind.is_empty() {
            let missing = |corner: &Corner| corner.jump * (1.0 - (at - corner.at_mm) / length);
            let missing: Vector6<f64> = self.behind.iter().map(missing).sum();
            rounded.load = Wrench::from_vector(&(demand.load.to_vector() - missing));
        }
        let corner = self.corner(k, &demand)?;
        self.behind.extend(corner);
        Ok(rounded)
    }

    /// The corner in point `k`, if the wrench jumps there.
    fn corner(&mut self, k: usize, demand: &Demand) -> Result<Option<Corner>, LoadError> {
        let Some([from, to]) = self.path.points().get(k..k + 2).and_then(|pair| <&[PathPoint; 2]>::try_from(pair).ok())
        else {
            return Ok(None);
        };
        if !to.cutting || from.source.segment == to.source.segment {
            return Ok(None);
        }
        let (arriving, departing) = (self.process.load(from)?, self.process.load(to)?);
        if [arriving, departing].iter().any(|load| matches!(load, PathLoad::Workpiece(_))) {
            return Ok(None);
        }
        let there = self.led.placed(demand.external).turned(&demand.pose.rotation);
        let departing = departing.on_tool(departure(from, to), there.tool_axes());
        let jump = there.wrench(&departing).to_vector() - demand.load.to_vector();
        Ok((jump.amax() > LEAST_JUMP).then_some(Corner { at_mm: from.arc_length_mm, jump }))
    }
}

/// The direction in which a move begins that leads to its first point `to`: the chord halves the angle to the direction there, as it does
/// on lines and arcs.
fn departure(from: &PathPoint, to: &PathPoint) -> Vector3<f64> {
    match (to.position_mm - from.position_mm).try_normalize(1e-12) {
        Some(chord) => chord * (2.0 * chord.dot(&to.tangent)) - to.tangent,
        None => to.tangent,
    }
}
