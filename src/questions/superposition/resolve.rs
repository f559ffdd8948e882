//! Checks a superposition study as written and makes a study of it.

use super::{
    Location, SuperpositionStudy, map_pieces, run_locations, run_map,
    spec::{LocationSpec, ScalesSpec, SuperpositionSpec},
};
use crate::{
    input::{check::Check, error::Result},
    machine::Machine,
    process::uncertainty::Uncertainty,
    questions::{
        Question, Resolved, StudyContext, Template,
        over_workspace::{LoadCaseKeys, Region, Shown, load_case, uncertainty_anywhere},
        path::resolve::named_point,
    },
    simulation::ROUNDING_MM,
    work::{Work, if_this_shard},
};

/// Most points of the map.
const MAX_POINTS: usize = 10_000_000;
/// Fewest and most factors of the growth study.
const STEPS: std::ops::RangeInclusive<usize> = 2..=100;

impl Question for SuperpositionStudy {
    type Spec = SuperpositionSpec;
    type Shown = Shown;
    const NAME: &str = "a superposition study";
    const TEMPLATE: Template = Template {
        name: "superposition",
        about: "Whether the effects of cutting force and chain errors may be added",
        files: &[("study.toml", include_str!("template/study.toml"))],
    };
    const TABLES: &[&str] = &["map", "safe_load", "locations", "largest_factors", "scaling", "slopes", "ablation"];

    /// Checks the study and makes its load case, grid and locations.
    fn resolve(spec: &SuperpositionSpec, context: &StudyContext<'_>) -> Result<Resolved<Self>> {
        context.overrides.refuse_points(context.name)?;
        context.refuse_carrier("this question does not take apart")?;
        let keys = LoadCaseKeys { phi_step_deg: spec.phi_step_deg, uses_target: false };
        let (load_case, not_used, inputs) = load_case(context, keys)?;
        let check = &context.check;
        let region =
            Region { min_mm: spec.min_mm, max_mm: spec.max_mm, grid: spec.grid, slices_z_mm: &spec.slices_z_mm };
        let box_of_p = [load_case.machine.workspace.min, load_case.machine.workspace.max];
        let (grid, slices_z, size) = region.checked_grid(context, box_of_p, MAX_POINTS)?;
        let tolerance = check.key("tolerance_mm").positive(spec.tolerance_mm)?;
        if tolerance < ROUNDING_MM {
            let problem = format!(
                "must be at least {ROUNDING_MM:e}, below which superposition errors are rounding, got {tolerance:e}"
            );
            return check.key("tolerance_mm").fail(problem);
        }
        let largest_factor = spec.largest_factor.unwrap_or(16.0);
        if !(1.0..=1e6).contains(&largest_factor) {
            return check.key("largest_factor").fail(format!("must be between 1 and 1e6, got {largest_factor}"));
        }
        let locations = locations(spec.location.as_deref(), &load_case.machine, check)?;
        let (uncertainty, read) = uncertainty_anywhere(context, &load_case)?;
        let uncertainty = uncertainty.map(Uncertainty::without_model);
        if let Some(own) = &uncertainty {
            if !own.varies_machine_or_force() {
                return context.uncertainty_location().fail("varies nothing of a superposition error, of which [uncertainty.model] and errors of the setup are no part: expected a machine or a force that varies".into());
            }
            if locations.is_empty() {
                return check
                    .key("location")
                    .fail("missing: the distribution is computed at locations, and none is given".into());
            }
        }
        let study = SuperpositionStudy {
            locations,
            scales: scales(&spec.scales, &check.key("scales"))?,
            tolerance,
            largest_factor,
            grid,
            load_case,
            uncertainty,
        };
        Ok(Resolved { study, shown: Shown { slices_z, not_used }, inputs: inputs.and(read).and(size) })
    }

    /// Returns the number of grid points and locations.
    fn items(&self) -> (usize, &'static str) {
        (self.grid.len() + self.locations.len(), "points")
    }

    /// Returns the number of grid points, never `None`, as every map can be an image.
    fn image_points(&self) -> Option<usize> {
        Some(self.grid.len())
    }

    /// Returns the number of pieces of map and locations.
    fn pieces(&self) -> usize {
        map_pieces(self) + self.locations.len()
    }

    /// Computes map and locations and keeps them in `work`.
    fn compute(&self, work: &Work) -> Result<()> {
        if_this_shard(run_map(self, work, |_| Ok(())))?;
        if_this_shard(run_locations(self, work))?;
        work.barrier()
    }
}

/// Returns the locations of P, checked; the named points of the machine if the study gives none. `Err` for one without name or position.
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

/// Returns the factors of the growth study, checked: from smallest to largest at equal ratios.
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
        i => smallest * libm::exp2(libm::log2(largest / smallest) * i as f64 / (steps - 1) as f64),
    };
    Ok((0..steps).map(factor).collect())
}
