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
    /// Index of the point in the corner.
    point: usize,
    /// Length of the path up to it, mm.
    at_mm: f64,
    jump: Vector6<f64>,
}

/// A smaller jump is rounding, in N and N·mm.
const LEAST_JUMP: f64 = 1e-9;

/// Spreads the jumps of the wrenches in `demands` of `path` over the length that the process gives. Loads that come with the path or from a
/// table stay, and so does where cutting begins and ends.
///
/// # Errors
/// A path that lacks what the cutting force needs.
pub(super) fn go_round_corners(
    process: &Process,
    path: &Toolpath,
    demands: &mut [Demand],
) -> std::result::Result<(), LoadError> {
    let length = process.corner_mm;
    if length == 0.0 {
        return Ok(());
    }
    let corners = corners(process, path, &process.loads(path)?, demands);
    // Sums of J and of J times its place, of the corners before each.
    let mut sums = vec![(Vector6::zeros(), Vector6::zeros())];
    let mut sum = sums[0];
    for corner in &corners {
        sum = (sum.0 + corner.jump, sum.1 + corner.jump * corner.at_mm);
        sums.push(sum);
    }
    let (mut begin, mut here, mut run_begin) = (0, 0, 0);
    for (k, (point, demand)) in path.points().iter().zip(demands.iter_mut()).enumerate() {
        if !point.cutting {
            run_begin = k + 1;
            continue;
        }
        let at = point.arc_length_mm;
        let passed = |corner: &Corner| corner.point < run_begin || corner.at_mm <= at - length;
        begin += corners[begin..].iter().take_while(|corner| passed(corner)).count();
        here = here.max(begin);
        here += corners[here..].iter().take_while(|corner| corner.point < k).count();
        if here > begin {
            let (jumps, moments) = (sums[here].0 - sums[begin].0, sums[here].1 - sums[begin].1);
            let missing = jumps * (1.0 - at / length) + moments / length;
            demand.load = Wrench::from_vector(&(demand.load.to_vector() - missing));
        }
    }
    Ok(())
}

/// Where the wrench jumps, in the order of the path.
fn corners(process: &Process, path: &Toolpath, loads: &[PathLoad], demands: &[Demand]) -> Vec<Corner> {
    let mut led = Led::new(&process.machine, &process.placement);
    let follows = |load: &PathLoad| !matches!(load, PathLoad::Workpiece(_));
    let corner = |(point, pair): (usize, &[PathPoint])| {
        let [from, to] = pair else { return None };
        let is_corner = from.cutting && to.cutting && from.source.segment != to.source.segment;
        if !is_corner || !loads[point..=point + 1].iter().all(follows) {
            return None;
        }
        let there = led.placed(demands[point].external).turned(&demands[point].pose.rotation);
        let departing = loads[point + 1].on_tool(departure(from, to), there.tool_axes());
        let jump = there.wrench(&departing).to_vector() - demands[point].load.to_vector();
        (jump.amax() > LEAST_JUMP).then_some(Corner { point, at_mm: from.arc_length_mm, jump })
    };
    path.points().windows(2).enumerate().filter_map(corner).collect()
}

/// The direction in which a move begins that leads to its first point `to`: the chord halves the angle to the direction there, as it does
/// on lines and arcs.
fn departure(from: &PathPoint, to: &PathPoint) -> Vector3<f64> {
    match (to.position_mm - from.position_mm).try_normalize(1e-12) {
        Some(chord) => chord * (2.0 * chord.dot(&to.tangent)) - to.tangent,
        None => to.tangent,
    }
}
