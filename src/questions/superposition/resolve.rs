//! From a superposition study as written to a checked one.

use super::{
    Location, Shown, SuperpositionStudy,
    spec::{LocationSpec, ScalesSpec, SuperpositionSpec},
};
use crate::{
    input::{check::Check, error::Result},
    machine::Machine,
    questions::{
        Given, Resolved,
        over_workspace::{Acting, OwnKeys, acting, box_grid, grid_input, map_box, slice_heights},
        path::resolve::named_point,
    },
    simulation::ROUNDING_MM,
};

/// Most points of the map.
const MAX_POINTS: usize = 10_000_000;
/// Fewest and most factors of the growth study.
const STEPS: std::ops::RangeInclusive<usize> = 2..=100;

pub(super) fn resolve(spec: &SuperpositionSpec, given: &Given<'_>) -> Result<Resolved<SuperpositionStudy>> {
    given.overrides.refuse_points(given.name)?;
    if let Some(carrier) = &given.machine.carrier {
        let problem = format!(
            "the workpiece carrier {} of machine {} bends as well, which this question does not take apart: expected a \
             machine without [workpiece_carrier]",
            carrier.name, given.machine.name
        );
        return given.check.root().key("machine").fail(problem);
    }
    let Acting { machine, force, phis, errors, not_used, inputs, .. } =
        acting(given, OwnKeys { phi_step_deg: spec.phi_step_deg, uses_target: false })?;
    let own = &given.check;
    let corners = map_box(spec.min_mm, spec.max_mm, &machine, own)?;
    let grid = box_grid(corners, spec.grid, given.overrides, (MAX_POINTS, own))?;
    let slices_z = slice_heights(&spec.slices_z_mm, corners, own)?;
    let tolerance = own.key("tolerance_mm").positive(spec.tolerance_mm)?;
    if tolerance < ROUNDING_MM {
        let problem =
            format!("must be at least {ROUNDING_MM:e}, below which departures are rounding, got {tolerance:e}");
        return own.key("tolerance_mm").fail(problem);
    }
    let largest_factor = spec.largest_factor;
    if !(1.0..=1e6).contains(&largest_factor) {
        return own.key("largest_factor").fail(format!("must be between 1 and 1e6, got {largest_factor}"));
    }
    let inputs = inputs.and(grid_input(grid.counts()));
    let study = SuperpositionStudy {
        errors,
        not_used,
        force,
        phis,
        grid,
        locations: locations(spec.location.as_deref(), &machine, own)?,
        tolerance,
        scales: scales(&spec.scales, &own.key("scales"))?,
        largest_factor,
        machine,
    };
    Ok(Resolved { study, shown: Shown { slices_z }, inputs })
}

fn locations(specs: Option<&[LocationSpec]>, machine: &Machine, check: &Check) -> Result<Vec<Location>> {
    let Some(specs) = specs else {
        let named = machine.points.iter();
        return Ok(named.map(|p| Location { name: p.name.clone(), position: p.position }).collect());
    };
    let mut locations: Vec<Location> = Vec::new();
    for (i, spec) in specs.iter().enumerate() {
        let check = check.key("location").item(i);
        let Some(name) = spec.name.clone().or_else(|| spec.point.clone()) else {
            return check.key("name").fail("a location that is no point needs a name".into());
        };
        check.key("name").readable(&name)?;
        check.key("name").unique(&name, locations.iter().map(|l| l.name.as_str()))?;
        check.key("name").unique_file(&name, locations.iter().map(|l| l.name.as_str()))?;
        let position = match (&spec.point, spec.position_mm) {
            (Some(point), None) => named_point(machine, point, &check.key("point"))?,
            (None, Some(position)) => check.key("position_mm").finite(position)?,
            _ => return check.key("point").fail("give exactly one of point and position_mm".into()),
        };
        locations.push(Location { name, position });
    }
    Ok(locations)
}

/// Factors at equal ratios.
fn scales(spec: &ScalesSpec, check: &Check) -> Result<Vec<f64>> {
    let ScalesSpec { smallest, largest, steps } = *spec;
    check.key("smallest").positive(smallest)?;
    check.key("largest").positive(largest)?;
    if largest < smallest * (1.0 + 1e-6) {
        return check.key("largest").fail(format!("must be larger than smallest, {smallest}, got {largest}"));
    }
    if !STEPS.contains(&steps) {
        return check.key("steps").fail(format!("must be between {} and {}, got {steps}", STEPS.start(), STEPS.end()));
    }
    let factor = |i: usize| match i {
        i if i + 1 == steps => largest,
        i => smallest * ((largest / smallest).log2() * i as f64 / (steps - 1) as f64).exp2(),
    };
    Ok((0..steps).map(factor).collect())
}
