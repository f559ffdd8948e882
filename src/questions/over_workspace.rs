//! What studies over the workspace share: the box and its grid, the cutting force in each direction φ, and process keys that need a path.

use nalgebra::Vector3;

use super::{Overrides, StudyContext, spec::ProcessRef};
use crate::{
    compensation::Target,
    input::{Inputs, check::Check, error::Result},
    process::{
        ForceText,
        cutting::CuttingLaw,
        uncertainty::{CutBy, Uncertainty},
    },
    simulation::LoadCase,
    spatial::Grid,
};

/// Default step between tool angles φ over one revolution, degrees.
const PHI_STEP_DEG: f64 = 10.0;

/// The keys of a workspace study that its load case depends on.
pub(super) struct LoadCaseKeys {
    /// Step between tool angles φ, degrees; [`PHI_STEP_DEG`] if `None`.
    pub phi_step_deg: Option<f64>,
    /// Whether the study compensates, so that target and tolerance matter.
    pub uses_target: bool,
}

/// What the report of a workspace study draws, and which process tables it mentions as unused.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// Heights of the slices drawn, O, mm.
    pub slices_z: Vec<f64>,
    /// Process tables and keys that the question does not use.
    pub not_used: Vec<&'static str>,
}

/// Returns what is uncertain of `case`, which has no path, and the files read for it. `Err` as of [`StudyContext::uncertainty`].
pub(super) fn uncertainty_anywhere(
    context: &StudyContext<'_>,
    case: &LoadCase,
) -> Result<(Option<Uncertainty>, Inputs)> {
    let table = context.uncertainty_of_process.borrow().clone();
    let cut = CutBy::anywhere(!case.force.is_zero());
    context.uncertainty(table.as_ref(), &case.machine, &case.errors, &cut)
}

/// Returns the load case of a workspace study, process tables that it does not use, and its inputs. `Err` without a force in the tool frame.
pub(super) fn load_case(
    context: &StudyContext<'_>,
    keys: LoadCaseKeys,
) -> Result<(LoadCase, Vec<&'static str>, Inputs)> {
    let process = context.process(None, &context.check)?;
    let force = match process.cutting {
        CuttingLaw::PathFrame(frame) => Some(frame.force),
        // Its torque, about the tool's axis, is in no map.
        CuttingLaw::EndMilling(own) => own.feed_per_tooth_mm.map(|c| own.force(c).into()),
        _ => None,
    };
    let force_of_turn = ForceText::of_cut(&process);
    let Some(force) = force else {
        let problem = format!(
            "{} has no path: expected a force that is constant in the frame of the tool, [force.path_frame], or [force.end_milling] with \
             feed_per_tooth_mm",
            context.name
        );
        return context.process_location(None).key("force").fail(problem);
    };
    let mut not_used = process.path_only_tables.clone();
    // What does not compensate has no error to hold against a tolerance either.
    if !keys.uses_target && process.target != Target::default() {
        not_used.push("compensate");
    }
    if !keys.uses_target && process.tolerance_mm.is_some() {
        not_used.push("tolerance_mm");
    }
    if let (Some(ProcessRef::Tables(_)), Some(table)) = (&context.header.process, not_used.first()) {
        let problem = format!("{} has no use for it", context.name);
        return context.check.root().key("process").key(table).fail(problem);
    }
    let load_case = LoadCase {
        force,
        force_of_turn,
        phis: tool_angles(keys.phi_step_deg.unwrap_or(PHI_STEP_DEG), &context.check.key("phi_step_deg"))?,
        errors: process.errors,
        machine: process.machine,
        target: process.target,
        tolerance_mm: process.tolerance_mm,
    };
    Ok((load_case, not_used, process.inputs))
}

/// Returns the tool angles φ of one revolution in steps of `step` degrees, rad. `Err` if `step` does not divide 360.
fn tool_angles(step: f64, check: &Check) -> Result<Vec<f64>> {
    if !(0.01..=360.0).contains(&step) {
        return check.fail(format!("must be between 0.01 and 360, got {step}"));
    }
    let count = (360.0 / step).round();
    if (count * step - 360.0).abs() > 1e-9 {
        return check.fail(format!("must divide 360, got {step}"));
    }
    Ok((0..count as usize).map(|i| (i as f64 * step).to_radians()).collect())
}

/// Returns the size of a grid as an input, since the command line can change it.
pub(super) fn grid_input(counts: impl std::fmt::Debug) -> Inputs {
    Inputs::of("grid", format!("{counts:?}"))
}

/// The box, grid and slices of a map, as a study writes them.
pub(super) struct Region<'a> {
    pub min_mm: Option<[f64; 3]>,
    pub max_mm: Option<[f64; 3]>,
    pub grid: [usize; 3],
    pub slices_z_mm: &'a [f64],
}

impl Region<'_> {
    /// Returns the grid over the box (or `default`) of at most `most`, the heights of its slices (O, mm), and its size as an input.
    pub fn checked_grid(
        self,
        context: &StudyContext<'_>,
        default: [Vector3<f64>; 2],
        most: usize,
    ) -> Result<(Grid, Vec<f64>, Inputs)> {
        let check = &context.check;
        let corners = corners_or_default(self.min_mm, self.max_mm, default, check)?;
        let grid = box_grid(corners, self.grid, context.overrides, most, check)?;
        let size = grid_input(grid.counts());
        Ok((grid, self.checked_slice_heights(corners, check)?, size))
    }

    /// Checks the heights (z in O, mm) of the map's slices: 1 to 6 finite values within the box. If that comes from the machine, a height
    /// outside it is reported as a misfit of the machine and not as an error in the study.
    fn checked_slice_heights(&self, [min, max]: [Vector3<f64>; 2], check: &Check) -> Result<Vec<f64>> {
        let (heights, from_machine, check) = (self.slices_z_mm, self.min_mm.is_none(), check.key("slices_z_mm"));
        if heights.is_empty() || heights.len() > 6 {
            return check.fail(format!("must name 1 to 6 heights, got {}", heights.len()));
        }
        let checked = heights.iter().map(|z| check.finite_scalar(*z)).collect::<Result<Vec<f64>>>()?;
        let is_outside = |z: &&f64| !(min.z..=max.z).contains(*z);
        let outside: Vec<String> = checked.iter().filter(is_outside).map(f64::to_string).collect();
        if outside.is_empty() {
            return Ok(checked);
        }
        let problem = format!("must be within the map's box, z {} to {} mm, got {}", min.z, max.z, outside.join(", "));
        if from_machine { check.misfit(problem, checked) } else { check.fail(problem) }
    }
}

/// Returns the corners of the box, O, mm, or `default` if neither is given. `Err` if only one is.
pub(super) fn corners_or_default(
    min_mm: Option<[f64; 3]>,
    max_mm: Option<[f64; 3]>,
    default: [Vector3<f64>; 2],
    check: &Check,
) -> Result<[Vector3<f64>; 2]> {
    let missing = |key: &str, other: &str| {
        check.key(key).fail(format!(
            "is missing: expected both corners of the box, or neither for the machine's workspace box, got only {other}"
        ))
    };
    match (min_mm, max_mm) {
        (None, None) => Ok(default),
        (Some(min), Some(max)) => check.corners(min, max),
        (Some(_), None) => missing("max_mm", "min_mm"),
        (None, Some(_)) => missing("min_mm", "max_mm"),
    }
}

/// Returns the grid over a box, with the counts of the command line if it gives any; `most` is the largest number of points.
pub(super) fn box_grid(
    [min, max]: [Vector3<f64>; 2],
    counts: [usize; 3],
    overrides: &Overrides,
    most: usize,
    check: &Check,
) -> Result<Grid> {
    match overrides.grid {
        Some(counts) => grid_between(min, max, counts, most, &Overrides::location("grid")),
        None => grid_between(min, max, counts, most, &check.key("grid")),
    }
}

/// Returns the grid between two corners, O, mm. `Err` if it has no points, more than `most`, or points that coincide.
fn grid_between(min: Vector3<f64>, max: Vector3<f64>, counts: [usize; 3], most: usize, check: &Check) -> Result<Grid> {
    let total = counts.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
    if counts.contains(&0) || total.is_none_or(|total| total > most) {
        let problem = format!("must be at least 1 along each axis and at most {most} in all, got {counts:?}");
        return check.fail(problem);
    }
    let grid = Grid::new(min, max, counts);
    for (i, values) in grid.axes.iter().enumerate() {
        if values.windows(2).any(|pair| pair[0] >= pair[1]) {
            let (axis, count) = (["x", "y", "z"][i], counts[i]);
            let problem = format!("{count} points along {axis} fall together between {} and {} mm", min[i], max[i]);
            return check.fail(problem);
        }
    }
    Ok(grid)
}
