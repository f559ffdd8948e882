//! From a study file as written to a checked study.

use std::path::Path;

use nalgebra::Vector3;

use super::{
    Study, StudyKind, folder_name,
    spec::{MillingSpec, StudySpec, WorkspaceMapSpec},
};
use crate::{
    input::{check::Check, error::Result},
    machine::{Machine, catalogue},
    process::{MillingForce, file::chain_errors::chain_errors},
    spatial::Grid,
    study::map::WorkspaceMapStudy,
    work::Inputs,
};

/// What the command line changes in a study.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// Grid points per axis of a map.
    pub grid: Option<[usize; 3]>,
    /// Points along a circle.
    pub points: Option<usize>,
}

/// Most points of a map, which is computed in blocks: its table takes about 80 GB.
const MAX_MAP_POINTS: usize = 100_000_000;

pub(super) fn study(spec: &StudySpec, text: &str, origin: &str, folder: &Path, overrides: &Overrides) -> Result<Study> {
    let check = Check::new(origin);
    check.schema(spec.schema)?;
    if spec.question.trim().is_empty() {
        return check.key("question").fail("must be a sentence, which is printed with the answer, got none".into());
    }
    let (machine, machine_text) = machine(&spec.machine, folder, &check.key("machine"))?;
    let kinds = [
        ("workspace_map", spec.workspace_map.is_some()),
        ("path", spec.path.is_some()),
        ("placement", spec.placement.is_some()),
        ("superposition", spec.superposition.is_some()),
        ("validation", spec.validation.is_some()),
    ];
    let not_one = || {
        let names = kinds.map(|(name, _)| name).join(", ");
        check.key("workspace_map").fail(format!("give exactly one of {names}"))
    };
    if kinds.iter().filter(|(_, given)| *given).count() > 1 {
        return not_one();
    }
    let (kind, settings) = if let Some(map) = &spec.workspace_map {
        refuse_points(overrides, "a workspace map")?;
        let map = workspace_map(spec, map, machine, overrides, &check)?;
        let settings = grid_input(map.grid.counts());
        (StudyKind::WorkspaceMap(map), settings)
    } else if let Some(path) = &spec.path {
        refuse_grid(overrides, "a path study")?;
        refuse_process_keys(spec, "path", &check)?;
        let (study, process) = super::path::resolve::path(path, machine, folder, overrides, &check.key("path"))?;
        let settings = process.and(Inputs::of("points of the path", study.stations.len().to_string()));
        (StudyKind::Path(study), settings)
    } else if let Some(placement) = &spec.placement {
        refuse_process_keys(spec, "placement", &check)?;
        let check = check.key("placement");
        let (study, process) = super::placement::resolve(placement, machine, folder, overrides, &check)?;
        let settings = process.and(grid_input(study.grid.counts()));
        (StudyKind::Placement(Box::new(study)), settings)
    } else if let Some(superposition) = &spec.superposition {
        refuse_points(overrides, "a superposition study")?;
        let study = super::superposition::resolve(spec, superposition, machine, overrides, &check)?;
        let settings = grid_input(study.grid.counts());
        (StudyKind::Superposition(study), settings)
    } else if let Some(validation) = &spec.validation {
        refuse_grid(overrides, "a validation study")?;
        refuse_process_keys(spec, "validation", &check)?;
        let check = check.key("validation");
        let (study, processes) = super::validation::resolve(validation, machine, folder, overrides, &check)?;
        let points: Vec<usize> = study.variants[0].paths.iter().map(|path| path.stations.len()).collect();
        (StudyKind::Validation(study), processes.and(Inputs::of("points of the paths", format!("{points:?}"))))
    } else {
        return not_one();
    };
    Ok(Study {
        name: folder_name(folder),
        question: spec.question.trim().to_string(),
        inputs: Inputs::of(crate::input::file::name(origin), text)
            .and(Inputs::of(&spec.machine, machine_text))
            .and(settings),
        kind,
    })
}

/// The size of a grid, which the command line can change.
fn grid_input(counts: impl std::fmt::Debug) -> Inputs {
    Inputs::of("grid", format!("{counts:?}"))
}

fn refuse_points(overrides: &Overrides, kind: &str) -> Result<()> {
    match overrides.points {
        Some(_) => command_line("--points").fail(format!("{kind} has no points along a path; use --grid")),
        None => Ok(()),
    }
}

fn refuse_grid(overrides: &Overrides, kind: &str) -> Result<()> {
    match overrides.grid {
        Some(_) => command_line("--grid").fail(format!("{kind} has no grid; use --points")),
        None => Ok(()),
    }
}

/// An option of the command line that overrides a study.
pub(super) fn command_line(option: &str) -> Check {
    Check::new("command line").key(option)
}

/// Keys that a study of this kind has in its process files.
fn refuse_process_keys(spec: &StudySpec, kind: &str, check: &Check) -> Result<()> {
    let key = match (&spec.milling, spec.chain_error.is_empty()) {
        (Some(_), _) => "milling",
        (None, false) => "chain_error",
        (None, true) => return Ok(()),
    };
    check.key(key).fail(format!("belongs in the process file of a {kind} study"))
}

/// The machine and its file's text.
fn machine(name: &str, folder: &Path, check: &Check) -> Result<(Machine, String)> {
    if let Some(entry) = catalogue::find(name) {
        return Ok((Machine::from_toml(entry.toml, entry.name)?, entry.toml.to_string()));
    }
    let file = folder.join(name);
    if !file.is_file() {
        let names = catalogue::names().collect::<Vec<_>>().join(", ");
        return check
            .fail(format!("\"{name}\" is neither a built-in machine ({names}) nor a file in the study's folder"));
    }
    let text = crate::input::toml_file::read(&file)?;
    Ok((Machine::from_toml(&text, &file.display().to_string())?, text))
}

fn workspace_map(
    spec: &StudySpec,
    map: &WorkspaceMapSpec,
    machine: Machine,
    overrides: &Overrides,
    check: &Check,
) -> Result<WorkspaceMapStudy> {
    let Some(milling_spec) = &spec.milling else {
        return check.key("milling").fail("a workspace map needs a [milling] table with the cutting force".into());
    };
    let (force, phis) = milling(milling_spec, &check.key("milling"))?;
    let check_map = check.key("workspace_map");
    let corners = map_box(map.min_mm, map.max_mm, &machine, &check_map)?;
    let grid = box_grid(corners, map.grid, overrides, (MAX_MAP_POINTS, &check_map))?;
    let slices_z = slice_heights(&map.slices_z_mm, corners, &check_map)?;
    let errors = chain_errors(&spec.chain_error, &machine, check)?;
    Ok(WorkspaceMapStudy { grid, force, phis, errors, target: map.compensate.into(), slices_z, machine })
}

/// The box of a map: the machine's workspace unless both corners are given. `check` is the place of the map.
pub(super) fn map_box(
    min_mm: Option<[f64; 3]>,
    max_mm: Option<[f64; 3]>,
    machine: &Machine,
    check: &Check,
) -> Result<[Vector3<f64>; 2]> {
    let missing = |key: &str, other: &str| {
        check.key(key).fail(format!(
            "is missing: expected both corners of the box, or neither for the machine's workspace box, got only {other}"
        ))
    };
    let corners = match (min_mm, max_mm) {
        (None, None) => [machine.workspace.min, machine.workspace.max],
        (Some(min), Some(max)) => [check.key("min_mm").finite(min)?, check.key("max_mm").finite(max)?],
        (Some(_), None) => return missing("max_mm", "min_mm"),
        (None, Some(_)) => return missing("min_mm", "max_mm"),
    };
    check.ordered_box(corners[0], corners[1])?;
    Ok(corners)
}

/// The grid of a map over a box; `most` is the largest number of points, `check` the place of the map.
pub(super) fn box_grid(
    [min, max]: [Vector3<f64>; 2],
    counts: [usize; 3],
    overrides: &Overrides,
    (most, check): (usize, &Check),
) -> Result<Grid> {
    match overrides.grid {
        Some(counts) => grid(min, max, counts, most, &command_line("--grid")),
        None => grid(min, max, counts, most, &check.key("grid")),
    }
}

/// Heights of the slices of a map over a box; `check` is the place of the map.
pub(super) fn slice_heights(heights: &[f64], [min, max]: [Vector3<f64>; 2], check: &Check) -> Result<Vec<f64>> {
    let check = check.key("slices_z_mm");
    if heights.is_empty() || heights.len() > 6 {
        return check.fail(format!("must name 1 to 6 heights, got {}", heights.len()));
    }
    let height = |&z: &f64| {
        let z = check.finite_scalar(z)?;
        if (min.z..=max.z).contains(&z) {
            return Ok(z);
        }
        check.fail(format!("must be within the map's box, z {} to {} mm, got {z}", min.z, max.z))
    };
    heights.iter().map(height).collect()
}

fn grid(min: Vector3<f64>, max: Vector3<f64>, counts: [usize; 3], most: usize, check: &Check) -> Result<Grid> {
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

/// The force law and the tool angles of one turn, rad.
pub(super) fn milling(spec: &MillingSpec, check: &Check) -> Result<(MillingForce, Vec<f64>)> {
    let force = MillingForce {
        radial: check.key("radial_force_N").finite_scalar(spec.radial_force)?,
        tangential: check.key("tangential_force_N").finite_scalar(spec.tangential_force)?,
        axial: check.key("axial_force_N").finite_scalar(spec.axial_force)?,
        law: spec.law,
    };
    let step = spec.phi_step_deg;
    let check = check.key("phi_step_deg");
    if !(0.01..=360.0).contains(&step) {
        return check.fail(format!("must be between 0.01 and 360, got {step}"));
    }
    let count = (360.0 / step).round();
    if (count * step - 360.0).abs() > 1e-9 {
        return check.fail(format!("must divide 360, got {step}"));
    }
    Ok((force, (0..count as usize).map(|i| (i as f64 * step).to_radians()).collect()))
}
