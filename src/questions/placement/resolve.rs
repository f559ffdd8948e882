//! Checks of a placement study as written, which make it a [`PlacementStudy`].

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};

use super::{
    Allowance, Candidate, FeatureJob, PlacementStudy, Search,
    allowance::{ANGLE_DEG, POSITION_MM},
    boxes::Table,
    metric::{Metric, Objective},
    outcome::is_name_of_found,
    site::{Bounds, COORDINATES, Site, SiteGrid, is_angle},
};
use crate::{
    input::{
        Inputs,
        check::Check,
        error::{Error, Result},
        names::listed,
    },
    machine::{Machine, ToolAxisSource},
    process::{
        Extent, Feature, ForbiddenBox, ForceText, GammaChoice, PathReference, Process,
        cutting::LoadError,
        tilt::TiltAngles,
        uncertainty::{CutBy, Uncertainty},
    },
    questions::{
        Overrides, Question, Resolved, StudyContext, Template,
        over_workspace::grid_input,
        path::resolve::{check_total, circle_points, named_point, on_carrier_problem, program_input, toolpath},
        placement::spec::{
            AllowanceSpec, CandidateSpec, FeatureSpec, ForbiddenSpec, ObjectiveSpec, OfCoordinates, PlacementStudySpec,
            SearchSpec, TableSpec,
        },
    },
    simulation::{TrackedPath, with_drives_left, within_limits},
    toolpath::{Orientation, PathPoint},
    work::Work,
};

/// Largest number of places of a sweep.
const MAX_PLACES: usize = 100_000;
/// Largest number of refinements.
const MAX_STARTS: usize = 100;
/// Default distance of the workpiece from forbidden boxes, mm.
pub const CLEARANCE_MM: f64 = 5.0;
/// Largest distance of a path outside the workpiece's box that is rounding, mm.
const OUTSIDE_MM: f64 = 1e-6;
/// Largest number of iterations of each refinement.
const MAX_ITERATIONS: usize = 10_000;

impl Question for PlacementStudy {
    type Spec = PlacementStudySpec;
    type Shown = ();
    const NAME: &str = "a placement study";
    const TEMPLATE: Template = Template {
        name: "placement",
        about: "Where a workpiece should stand",
        files: &[
            ("study.toml", include_str!("template/study.toml")),
            ("process.toml", include_str!("template/process.toml")),
        ],
    };
    const TABLES: &[&str] = &["candidates", "sweep", "refinements", "pareto"];

    /// Checks the placement study and reads the programs of its features.
    fn resolve(spec: &PlacementStudySpec, context: &StudyContext<'_>) -> Result<Resolved<Self>> {
        let (overrides, check) = (context.overrides, &context.check);
        let (features, today, inputs) = all_features(&spec.feature, context)?;
        // Places of the tool tip are told of the first feature's tool.
        let machine = features[0].machine();
        let reference = features[0].feature.reference;
        let bounds = resolve_bounds(&spec.bounds, &spec.fixed, machine, check)?;
        let extent = match &spec.workpiece {
            Some(spec) => {
                let check = check.key("workpiece");
                let extent = checked_box(spec.min_mm, spec.max_mm, &check)?;
                check_holds_paths(&extent, &features, &check)?;
                extent
            }
            None => {
                let points = features.iter().flat_map(|job| job.feature.path.points()).map(|point| point.position_mm);
                Extent::around(points).unwrap_or(Extent { min: Vector3::zeros(), max: Vector3::zeros() })
            }
        };
        let clearance_mm = check.key("clearance_mm").not_negative(spec.clearance_mm.unwrap_or(CLEARANCE_MM))?;
        let footprint = || match &spec.workpiece {
            Some(_) => extent.corners().to_vec(),
            None => features.iter().flat_map(|job| job.feature.path.points()).map(|point| point.position_mm).collect(),
        };
        let mut study = PlacementStudy {
            table: spec
                .table
                .map(|spec| resolve_table(&spec, footprint(), tool_points_up(&features), &check.key("table")))
                .transpose()?,
            forbidden: resolve_forbidden(&spec.forbidden, check)?,
            clearance_mm,
            grid: resolve_grid(&spec.search, &bounds, overrides, &check.key("search"))?,
            search: resolve_search(&spec.search, &check.key("search"))?,
            objective: resolve_objective(&spec.objective, machine, &features, &check.key("objective"))?,
            candidates: Vec::new(),
            allowance: resolve_allowance(&spec.allowance, &bounds, &check.key("allowance"))?,
            bounds,
            extent,
            machine: machine.clone(),
            features,
        };
        let seeks_gamma = study.seeks_gamma();
        study.candidates = resolve_candidates(&spec.candidate, today, &study.machine, reference, seeks_gamma, check)?;
        let inputs = inputs.and(grid_input(study.grid.counts()));
        Ok(Resolved { study, shown: (), inputs })
    }

    /// Returns the number of places of the sweep.
    fn items(&self) -> (usize, &'static str) {
        (self.grid.len(), "places")
    }

    /// Returns the number of pieces of the first level of the sweep.
    fn pieces(&self) -> usize {
        super::sweep::piece_count(self)
    }

    /// Returns true: pruning after each level depends on all places.
    fn goes_in_rounds(&self) -> bool {
        true
    }

    /// Runs the whole search and keeps its evaluations in `work`.
    fn compute(&self, work: &Work) -> Result<()> {
        super::compute(self, work)
    }
}

/// Checks all features; returns them, the place that their process files give, and their inputs.
fn all_features(
    specs: &[FeatureSpec],
    context: &StudyContext<'_>,
) -> Result<(Vec<FeatureJob>, Option<Candidate>, Inputs)> {
    let (overrides, check) = (context.overrides, &context.check);
    if specs.is_empty() {
        return check.key("feature").fail("expected at least one feature".into());
    }
    check_total(circle_points(specs.iter().filter_map(|spec| spec.circle.as_ref()), overrides), &check.key("feature"))?;
    let mut points = 0;
    let mut today: Option<Candidate> = None;
    let (mut jobs, mut inputs): (Vec<FeatureJob>, Inputs) = (Vec::new(), Inputs::default());
    let mut processes = Vec::new();
    for (i, spec) in specs.iter().enumerate() {
        let check = check.key("feature").item(i);
        check.key("name").readable(&spec.name)?;
        check.key("name").unique(&spec.name, specs[..i].iter().map(|s| s.name.as_str()))?;
        check.key("name").unique_file(&spec.name, specs[..i].iter().map(|s| s.name.as_str()))?;
        let (job, process, place, read) = resolve_feature(spec, context, &check)?;
        if let (Some(place), Some(before)) = (&place, &today)
            && place.site != before.site
        {
            let process = spec.process.as_deref().unwrap_or("the process of the study");
            let problem = format!("{process} places the workpiece elsewhere than the feature before");
            return check.key("process").fail(problem);
        }
        today = today.or(place);
        if jobs.first().is_some_and(|first| first.feature.reference != job.feature.reference) {
            return check.key("process").fail("placement.reference differs from that of the first feature".into());
        }
        points += job.feature.path.len();
        check_total(points, &check)?;
        jobs.push(job);
        processes.push(process);
        inputs = inputs.and(read);
    }
    // One draw is of all features, and so of all their tools.
    let tools: Vec<Option<u32>> = jobs.iter().flat_map(|job| job.feature.path.cutting_tools()).collect();
    for (job, process) in jobs.iter_mut().zip(&processes) {
        // Another feature may have a force.
        let cut = CutBy { has_force: true, has_components: process.with_only(0).is_some(), tools: &tools };
        let (uncertainty, read) =
            context.uncertainty(process.uncertainty.as_ref(), &process.machine, &process.errors, &cut)?;
        let loads = |own: &Uncertainty| process.component_loads(&job.feature.path, &own.force);
        job.components = uncertainty.as_ref().and_then(loads);
        job.tracked.uncertainty = uncertainty.map(Arc::new);
        inputs = inputs.and(read);
    }
    check_same_draws(&jobs, &check.key("feature"))?;
    Ok((jobs, today, inputs))
}

/// Checks that all features have the same uncertain numbers and draws, as one drawn machine cuts all of them.
fn check_same_draws(jobs: &[FeatureJob], check: &Check) -> Result<()> {
    let is_same = |a: &Uncertainty, b: &Uncertainty| {
        (&a.parameters, a.force, a.model) == (&b.parameters, b.force, b.model)
            && (&a.draws.normal, &a.draws.force) == (&b.draws.normal, &b.draws.force)
    };
    let have_different_draws = |pair: &&[FeatureJob]| match [0, 1].map(|k| &pair[k].tracked.uncertainty) {
        [Some(a), Some(b)] => !is_same(a, b),
        [a, b] => a.is_some() != b.is_some(),
    };
    match jobs.windows(2).find(have_different_draws) {
        None => Ok(()),
        Some(pair) => check.fail(format!(
            "{} and {} do not have the same uncertain numbers and draws: give [uncertainty] in the study instead of their processes, with numbers that the machines of both have",
            pair[0].feature.name, pair[1].feature.name
        )),
    }
}

/// Checks one feature and reads its path; returns it as with exact inputs, its process, the place that this gives, and what was read.
fn resolve_feature(
    spec: &FeatureSpec,
    context: &StudyContext<'_>,
    check: &Check,
) -> Result<(FeatureJob, Process, Option<Candidate>, Inputs)> {
    let folder = context.folder;
    let process = with_constant_gamma(context.process_with_gamma(spec.process.as_deref(), check)?, context, spec)?;
    let (path, program) = toolpath(spec.circle.as_ref(), spec.file.as_deref(), &process, context, check)?;
    let origin = spec.file.as_ref().map_or_else(|| check.location(), |file| folder.path(file).display().to_string());
    if let [first, ..] = path.external_axes() {
        let problem =
            format!("commands {first}: a place is sought for one position of such a drive, expected [locked] instead");
        return Err(Error::Argument { argument: origin, problem });
    }
    if let Some(stock) = &process.stock {
        stock.check_movable(&process.machine, &process.placement)?;
    }
    let path = process.mark_cutting(path, &origin)?;
    let process = with_drives_left(process, &path, program.as_ref(), &origin)?;
    let fault = |source: LoadError| Error::Argument { argument: origin.clone(), problem: source.to_string() };
    let loads = process.loads(&path).map_err(fault)?;
    let points = Inputs::of(format!("points of {}", spec.name), path.len().to_string());
    let force_text = ForceText::of(&process, &path, &|segment| program.as_ref()?.line_name(segment));
    let inputs = process.inputs.clone().and(program_input(spec.file.as_deref(), program.as_ref())).and(points);
    let feature = Feature {
        name: spec.name.clone(),
        path,
        loads,
        reference: process.placement.reference,
        tolerance_mm: match check.tolerance(spec.tolerance_mm, spec.tolerance_zone_mm)?.or(process.tolerance_mm) {
            Some(tolerance) => tolerance,
            None => {
                let problem =
                    "missing: expected how far the tool may be from this path, or tolerance_mm in its process file";
                return check.key("tolerance_mm").fail(problem.into());
            }
        },
    };
    within_limits::check_limits(&process.machine, &process.limits)
        .or_else(|problem| context.process_location(spec.process.as_deref()).key("limits").misfit(problem, ()))?;
    let today = Candidate::from_process(&process);
    let cuts = process.cutting_rule;
    let tracked = TrackedPath { tolerance_mm: Some(feature.tolerance_mm), ..TrackedPath::of(&process) };
    #[cfg(not(target_family = "wasm"))]
    let bodies = crate::simulation::clearance::MachineCell::of(&tracked.machine, process.cell.as_ref())?;
    let job = FeatureJob {
        feature,
        #[cfg(not(target_family = "wasm"))]
        bodies,
        machines: tracked.machines()?,
        tracked,
        limits: process.limits,
        target: process.target,
        cuts,
        force_text,
        verdict: process.verdict.clone(),
        worst: None,
        components: None,
        gamma_search: Some(process.redundancy.clone()).filter(crate::process::RedundancySettings::is_sought),
    };
    job.check_gamma_search()?;
    Ok((job, process, today, inputs))
}

/// Returns `process`, with the machine kept on the branch of home if it asks for one constant γ. `Err` if γ may vary along the path.
fn with_constant_gamma(process: Process, context: &StudyContext<'_>, spec: &FeatureSpec) -> Result<Process> {
    match process.redundancy.gamma {
        crate::process::GammaChoice::AsProgrammed => Ok(process),
        crate::process::GammaChoice::Best => {
            let place = context.process_location(spec.process.as_deref()).key("redundancy.gamma");
            place.fail("is best: a place is judged at one γ for each feature, expected best_constant".into())
        }
        crate::process::GammaChoice::BestConstant => {
            let branch = process.machine.branch_of(&process.machine.home);
            let machine = match branch {
                Some(branch) => process.machine.on_branch(branch)?,
                None => process.machine.clone(),
            };
            Ok(Process { machine, ..process })
        }
    }
}

/// Returns the box between two corners, mm.
fn checked_box(min: [f64; 3], max: [f64; 3], check: &Check) -> Result<Extent> {
    check.corners(min, max).map(|[min, max]| Extent { min, max })
}

/// Checks that the workpiece's box `extent` (W, mm) holds every point to which the tool cuts; beyond the side that the tool comes from is air.
fn check_holds_paths(extent: &Extent, features: &[FeatureJob], check: &Check) -> Result<()> {
    for job in features {
        let machine = job.machine();
        // Without a length or an axis of the tool, either side along z may be the one it comes from.
        let is_known = machine.tool_tip.norm() > 0.0 || machine.tool_axis_source == ToolAxisSource::Given;
        let comes_from = |point: &PathPoint, axis: usize, side: f64| match point.orientation {
            None if !is_known => axis == 2,
            _ => side * spindle_to_tip(machine, point)[axis] < -0.5,
        };
        let points = job.feature.path.points();
        let never_cuts = points.iter().all(|point| !point.cutting);
        for (k, point) in points.iter().enumerate().filter(|(_, point)| point.cutting || never_cuts) {
            // On which side of the box the point is, along an axis.
            let beyond = |axis: usize| match point.position_mm[axis] {
                p if p < extent.min[axis] - OUTSIDE_MM => Some(-1.0),
                p if p > extent.max[axis] + OUTSIDE_MM => Some(1.0),
                _ => None,
            };
            let is_in_air = (0..3).any(|axis| beyond(axis).is_some_and(|side| comes_from(point, axis, side)));
            if !is_in_air && (0..3).any(|axis| beyond(axis).is_some()) {
                let corner = |p: Vector3<f64>| format!("({}, {}, {})", p.x, p.y, p.z);
                let [x, y, z]: [f64; 3] = point.position_mm.into();
                return check.fail(format!(
                    "the box {} to {} mm does not hold point {k} of feature \"{}\" at ({x:.3}, {y:.3}, {z:.3}) mm, to \
                     which the tool cuts",
                    corner(extent.min),
                    corner(extent.max),
                    job.feature.name
                ));
            }
        }
    }
    Ok(())
}

/// Returns the unit direction from the spindle to the tip at a point of a path, in W; that at home where the path gives no orientation.
fn spindle_to_tip(machine: &Machine, point: &PathPoint) -> Vector3<f64> {
    let in_platform = machine.tool_axes.column(2);
    match point.orientation {
        Some(Orientation::ToolAxis(to_spindle)) => -to_spindle,
        Some(Orientation::Platform(rotation)) => rotation * in_platform,
        None => machine.home.pose.rotation * in_platform,
    }
}

/// Returns whether the tool points up on average over the points it cuts, so that the workpiece hangs above its tip.
fn tool_points_up(features: &[FeatureJob]) -> bool {
    let axes = features.iter().flat_map(|job| {
        let cutting = job.feature.path.points().iter().filter(|point| point.cutting);
        cutting.map(|point| spindle_to_tip(job.machine(), point))
    });
    let sum: Vector3<f64> = axes.sum();
    sum.z > 0.5 * sum.norm()
}

/// Returns the table on which the workpiece stands, checked; `footprint` are the points of the workpiece that must be on it, W, mm.
fn resolve_table(spec: &TableSpec, footprint: Vec<Vector3<f64>>, is_overhead: bool, check: &Check) -> Result<Table> {
    let pair = |key: &str, [x, y]: [f64; 2]| -> Result<Vector2<f64>> {
        let check = check.key(key);
        Ok(Vector2::new(check.finite_scalar(x)?, check.finite_scalar(y)?))
    };
    let (centre_mm, size_mm) = match (spec.min_mm, spec.max_mm, spec.centre_mm, spec.size_mm) {
        (Some(min), Some(max), None, None) => {
            let (min, max) = (pair("min_mm", min)?, pair("max_mm", max)?);
            (0.5 * (min + max), max - min)
        }
        (None, None, Some(centre), Some(size)) => (pair("centre_mm", centre)?, pair("size_mm", size)?),
        _ => return check.fail("expected min_mm and max_mm, or centre_mm and size_mm".into()),
    };
    if size_mm.min() <= 0.0 {
        let [x, y]: [f64; 2] = size_mm.into();
        return check.fail(format!("is {x} mm × {y} mm: expected sides above 0"));
    }
    let margin_mm = check.key("margin_mm").not_negative(spec.margin_mm.unwrap_or(0.0))?;
    if 2.0 * margin_mm >= size_mm.min() {
        return check.key("margin_mm").fail(format!(
            "is {margin_mm} mm at each edge, which leaves nothing of a table {0} mm wide: expected less than {1} mm",
            size_mm.min(),
            0.5 * size_mm.min()
        ));
    }
    let yaw = check.key("yaw_deg").finite_scalar(spec.yaw_deg.unwrap_or(0.0))?.to_radians();
    let height_mm = spec.height_mm.map(|height| check.key("height_mm").finite_scalar(height)).transpose()?;
    Ok(Table { centre_mm, size_mm, yaw, height_mm, is_overhead, margin_mm, footprint })
}

/// Returns the forbidden boxes, checked: readable, different names and corners in order.
fn resolve_forbidden(specs: &[ForbiddenSpec], check: &Check) -> Result<Vec<ForbiddenBox>> {
    let mut boxes = Vec::new();
    for (i, spec) in specs.iter().enumerate() {
        let check = check.key("forbidden").item(i);
        check.key("name").readable(&spec.name)?;
        check.key("name").unique(&spec.name, specs[..i].iter().map(|s| s.name.as_str()))?;
        boxes.push(ForbiddenBox { name: spec.name.clone(), extent: checked_box(spec.min_mm, spec.max_mm, &check)? });
    }
    Ok(boxes)
}

/// Keys of a site's coordinates.
const KEYS: [&str; 6] = ["x_mm", "y_mm", "z_mm", "yaw_deg", "pitch_deg", "roll_deg"];

/// Returns the bounds of the coordinates, mm and rad, equal ends for `fixed` ones; an angle in neither is 0. `Err` for both, a length in neither, or a tilt it cannot do.
fn resolve_bounds(
    bounds: &OfCoordinates<[f64; 2]>,
    fixed: &OfCoordinates<f64>,
    machine: &Machine,
    check: &Check,
) -> Result<Bounds> {
    let (ranges, values) = (bounds.in_order(), fixed.in_order());
    let (mut low, mut high) = ([0.0; 6], [0.0; 6]);
    for i in 0..KEYS.len() {
        let unit = if is_angle(i) { 1f64.to_radians() } else { 1.0 };
        let value = values[i].or((is_angle(i) && ranges[i].is_none()).then_some(0.0));
        let check_range = check.key("bounds").key(KEYS[i]);
        (low[i], high[i]) = match (ranges[i], value) {
            (Some(_), None) => check_range.interval(ranges[i], unit)?.unwrap_or((0.0, 0.0)),
            (None, Some(value)) => {
                let value = check.key("fixed").key(KEYS[i]).finite_scalar(value)? * unit;
                (value, value)
            }
            _ => return check.fail(format!("give exactly one of bounds.{} and fixed.{}", KEYS[i], KEYS[i])),
        };
        if let (true, Some([first, last])) = (is_angle(i), ranges[i])
            && last - first > 360.0 * (1.0 + 1e-12)
        {
            return check_range.fail(format!("must not exceed a full turn, got {first} to {last}"));
        }
    }
    let [.., yaw, pitch, roll] = std::array::from_fn::<_, 6, _>(|i| low[i] != 0.0 || high[i] != 0.0);
    TiltAngles { roll, pitch, yaw }.check(machine, |name| {
        let is_sought = KEYS.iter().position(|key| *key == name).is_some_and(|i| ranges[i].is_some());
        check.key(if is_sought { "bounds" } else { "fixed" }).key(name)
    })?;
    Ok(Bounds { low, high })
}

/// Largest allowance of positions, mm, and of angles, degrees: farther off, another place is meant.
const MAX_ALLOWANCE: [f64; 2] = [100.0, 10.0];

/// Returns the allowance of places, checked. What is not sought and not in the plane of the table has none.
fn resolve_allowance(spec: &AllowanceSpec, bounds: &Bounds, check: &Check) -> Result<Allowance> {
    let half = |key: &str, written: Option<f64>, default: f64, largest: f64| {
        let check = check.key(key);
        match check.not_negative(written.unwrap_or(default))? {
            half if half <= largest => Ok(half),
            half => check.fail(format!("must be at most {largest}, got {half}")),
        }
    };
    let position = half("position_mm", spec.position_mm, POSITION_MM, MAX_ALLOWANCE[0])?;
    let angle = half("angle_deg", spec.angle_deg, ANGLE_DEG, MAX_ALLOWANCE[1])?.to_radians();
    let varies = |i: usize| matches!(COORDINATES[i], "x" | "y" | "yaw") || bounds.high[i] > bounds.low[i];
    let of = |i: usize| if is_angle(i) { angle } else { position };
    Ok(Allowance { half: std::array::from_fn(|i| if varies(i) { of(i) } else { 0.0 }) })
}

/// Makes the grid of the sweep, with the counts of the command line along x, y and z if it gives any.
fn resolve_grid(spec: &SearchSpec, bounds: &Bounds, overrides: &Overrides, check: &Check) -> Result<SiteGrid> {
    let mut counts = [spec.grid.x, spec.grid.y, spec.grid.z, spec.grid.yaw, spec.grid.pitch, spec.grid.roll];
    let is_free = |i: usize| bounds.high[i] > bounds.low[i];
    for i in 0..counts.len() {
        let count = counts[i];
        let check = check.key("grid").key(COORDINATES[i]);
        if count == 0 {
            return check.fail("must be at least 1, got 0".into());
        }
        if count > 1 && !is_free(i) {
            return check.fail(format!("{} is fixed: expected 1, got {count}", COORDINATES[i]));
        }
    }
    if let Some(requested) = overrides.grid {
        for i in (0..3).filter(|&i| is_free(i)) {
            counts[i] = requested[i];
        }
    }
    let total = counts.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
    if total.is_none_or(|total| total == 0 || total > MAX_PLACES) {
        let problem =
            format!("must be 1 to {MAX_PLACES} places in all, got {counts:?} along {}", COORDINATES.join(", "));
        return check.key("grid").fail(problem);
    }
    Ok(SiteGrid::new(bounds, counts))
}

/// Returns the settings of the search, checked, with defaults where none are given.
fn resolve_search(spec: &SearchSpec, check: &Check) -> Result<Search> {
    let count = |key: &str, written: Option<usize>, default: usize, limit: usize| match written.unwrap_or(default) {
        n if (1..=limit).contains(&n) => Ok(n),
        n => check.key(key).fail(format!("must be from 1 to {limit}, got {n}")),
    };
    let tolerance = check.key("tolerance").positive(spec.tolerance.unwrap_or(1e-4))?;
    if tolerance >= 1.0 {
        return check
            .key("tolerance")
            .fail(format!("is a share of the objective and must be below 1, got {tolerance}"));
    }
    Ok(Search {
        starts: count("starts", spec.starts, 3, MAX_STARTS)?,
        max_iterations: count("max_iterations", spec.max_iterations, 100, MAX_ITERATIONS)?,
        tolerance,
        coarse_to_fine: spec.coarse_to_fine.unwrap_or(true),
    })
}

/// Returns the objective, checked: at least one weight, all positive, and none, two or three different Pareto metrics.
fn resolve_objective(
    spec: &ObjectiveSpec,
    machine: &Machine,
    features: &[FeatureJob],
    check: &Check,
) -> Result<Objective> {
    let check_weights = check.key("weights");
    if spec.weights.is_empty() {
        return check_weights.fail("expected at least one metric with its weight".into());
    }
    let mut weights = Vec::new();
    for (name, &weight) in &spec.weights {
        let check = check_weights.key(name);
        weights.push((resolve_metric(name, machine, features, &check)?, check.positive(weight)?));
    }
    if !matches!(spec.pareto.len(), 0 | 2 | 3) {
        return check.key("pareto").fail(format!("must name two or three metrics, or none, got {}", spec.pareto.len()));
    }
    let mut pareto: Vec<Metric> = Vec::new();
    for (i, name) in spec.pareto.iter().enumerate() {
        let check = check.key("pareto").item(i);
        check.unique(name, spec.pareto[..i].iter().map(String::as_str))?;
        pareto.push(resolve_metric(name, machine, features, &check)?);
    }
    Ok(Objective { weights, pareto })
}

/// Returns the metric called `name`. `Err` if the machine or the features do not have it.
fn resolve_metric(name: &str, machine: &Machine, features: &[FeatureJob], check: &Check) -> Result<Metric> {
    let Some(metric) = Metric::named(name) else {
        let known = Metric::ALL.map(Metric::label).join(", ");
        return check.fail(format!("no metric is called \"{name}\"; there are: {known}"));
    };
    if !metric.exists_on(machine) {
        let problem = "is of machines with prismatic and revolute joints: where all drives turn, expected worst_correction or \
                       worst_drive_force";
        check.misfit(problem.into(), ())?;
    }
    if metric.is_bounded() && !features.iter().any(|job| job.limits.is_limited()) {
        return check.fail("needs [limits] of corrections or forces in a process file".into());
    }
    if metric.is_uncertain() {
        if features.iter().any(|job| job.gamma_search.is_some()) {
            return check.fail("is not computed where [compensate.redundancy] seeks γ: expected another metric".into());
        }
        if features.iter().any(|job| job.tracked.uncertainty.is_none()) {
            return check.fail("needs the table [uncertainty]".into());
        }
        let tolerances = features.windows(2).all(|pair| pair[0].feature.tolerance_mm == pair[1].feature.tolerance_mm);
        if metric == Metric::WithinProbability && !tolerances {
            return check.fail("needs the same tolerance for all features".into());
        }
    }
    let has_force_limit = features.iter().any(|job| job.limits.force_N.is_some())
        || machine.drives().any(|(_, drive)| drive.force_limit.is_some());
    #[cfg(not(target_family = "wasm"))]
    if metric == Metric::LeastClearance && features.iter().any(|job| job.bodies.is_none()) {
        return check.fail("needs the table [cell] in the process of each feature".into());
    }
    #[cfg(not(target_family = "wasm"))]
    if metric == Metric::LeastClearance {
        let cells = features.iter().filter_map(|job| job.bodies.as_ref());
        cells.into_iter().find_map(|cell| cell.has_no_distance()).map_or(Ok(()), |problem| check.fail(problem))?;
    }
    if metric == Metric::ForceMargin && !has_force_limit {
        check.misfit("neither the machine nor a process file has force limits".into(), ())?;
    }
    Ok(metric)
}

/// Returns the named places, checked; that of the process files, `today`, comes first. `reference` is the point whose positions paths give;
/// `seeks_gamma` says whether γ of a feature is sought.
fn resolve_candidates(
    specs: &[CandidateSpec],
    today: Option<Candidate>,
    machine: &Machine,
    reference: PathReference,
    seeks_gamma: bool,
    check: &Check,
) -> Result<Vec<Candidate>> {
    let mut candidates: Vec<Candidate> = today.into_iter().collect();
    for (i, spec) in specs.iter().enumerate() {
        let check = check.key("candidate").item(i);
        let name = spec.name.clone().or_else(|| spec.point.clone());
        let Some(name) = name else { return check.key("name").fail("a place that is no point needs a name".into()) };
        check.key("name").readable(&name)?;
        check.key("name").unique(&name, candidates.iter().map(|c| c.name.as_str()))?;
        if is_name_of_found(&name) {
            let problem = format!("\"{name}\" is a name of places that the search finds: choose another");
            return check.key("name").fail(problem);
        }
        let position = match (&spec.point, spec.origin_mm) {
            (Some(point), None) => {
                reference_position(machine, reference, named_point(machine, point, &check.key("point"))?)
            }
            (None, Some(origin)) => check.key("origin_mm").finite(origin)?,
            _ => return check.key("point").fail("give exactly one of point and origin_mm".into()),
        };
        let angles = [("yaw_deg", spec.yaw_deg), ("pitch_deg", spec.pitch_deg), ("roll_deg", spec.roll_deg)];
        let mut site = Site::new(position, 0.0);
        for (i, (key, degrees)) in angles.into_iter().enumerate() {
            site.0[3 + i] = check.key(key).finite_scalar(degrees)?.to_radians();
        }
        rotated_axes(&site).check(machine, |name| check.key(name))?;
        let at_best_gamma = match (spec.gamma, seeks_gamma) {
            (GammaChoice::AsProgrammed, _) => false,
            (GammaChoice::BestConstant, true) => true,
            _ => {
                let problem =
                    "must be as_programmed, or best_constant where redundancy.gamma of a process is best_constant";
                return check.key("gamma").fail(problem.into());
            }
        };
        candidates.push(Candidate { name, site, at_best_gamma });
    }
    Ok(candidates)
}

/// Returns which of the angles roll, pitch and yaw of `site` are not zero.
fn rotated_axes(site: &Site) -> TiltAngles {
    let [.., yaw, pitch, roll] = site.0.map(|value| value != 0.0);
    TiltAngles { roll, pitch, yaw }
}

/// Returns the position of the point that paths refer to when P is at `position` and the platform oriented as at home, O, mm.
pub(crate) fn reference_position(machine: &Machine, reference: PathReference, position: Vector3<f64>) -> Vector3<f64> {
    match reference {
        PathReference::PlatformPoint => position,
        PathReference::ToolTip => position + machine.home.pose.rotation * machine.tool_tip,
    }
}

impl Candidate {
    /// Returns the place that a process file gives; `None` where it gives no origin.
    pub fn from_process(process: &Process) -> Option<Self> {
        let placement = &process.placement;
        let mut site = Site::new(placement.origin_mm, placement.roll_pitch_yaw.z);
        [site.0[4], site.0[5]] = [placement.roll_pitch_yaw.y, placement.roll_pitch_yaw.x];
        process.is_placed.then(|| Self { name: "as in the process file".into(), site, at_best_gamma: false })
    }
}

/// Reads a place from text: a named point of `machine`, or the coordinates of the origin of W, mm and degrees. `Err`, which names `origin`,
/// if it is neither.
pub fn parse_place(text: &str, origin: &str, machine: &Machine, reference: PathReference) -> Result<Candidate> {
    let numbers: std::result::Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    let fault = |problem: String| Err(Error::Argument { argument: origin.into(), problem });
    let site = match numbers.as_deref() {
        Ok([x, y, z, angles @ ..])
            if [0, 1, 3].contains(&angles.len())
                && numbers.iter().flatten().all(|v| v.abs() <= crate::input::check::LARGEST) =>
        {
            let mut site = Site::new(Vector3::new(*x, *y, *z), 0.0);
            for (coordinate, degrees) in site.0[3..].iter_mut().zip(angles) {
                *coordinate = degrees.to_radians();
            }
            rotated_axes(&site).check(machine, |key| {
                Check::new(origin).key(&format!("{} of \"{text}\"", key.trim_end_matches("_deg")))
            })?;
            site
        }
        Ok(_) => {
            return fault(format!(
                "\"{text}\": expected x,y,z in mm, or x,y,z,yaw or x,y,z,yaw,pitch,roll with angles in degrees"
            ));
        }
        Err(_) => match machine.point(text) {
            Some(_) if machine.carrier.is_some() => return fault(on_carrier_problem(machine, text)),
            Some(point) => Site::new(reference_position(machine, reference, point.position), 0.0),
            None => {
                let known = listed(machine.points.iter().map(|point| &point.name));
                return fault(format!("machine {} has no point \"{text}\"; there are: {known}", machine.name));
            }
        },
    };
    Ok(Candidate { name: text.into(), site, at_best_gamma: false })
}
