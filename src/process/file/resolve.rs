//! Checks a process file as written and converts it to a process.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::tables::{cell, feed, redundancy, robot, rotary::rotary, stock};
use crate::{
    compensation::Target,
    input::{Folder, check::Check, error::Result},
    machine::Machine,
    process::{
        CuttingRule, Placement, VerdictTable,
        cutting::CuttingLaw,
        file::{
            CORNER_MM, CorrectionLimits, Decimals, Process, WRITE_TOLERANCE_MM,
            chain_errors::chain_errors,
            force::{cutting_law, own_forces},
            spec::{
                CutterCompensation, CuttingRuleSpec, GcodeSpec, LimitsSpec, PlacementSpec, ProcessSpec, SamplingSpec,
            },
        },
        tilt::TiltAngles,
        uncertainty::UncertaintyTable,
    },
    toolpath::{
        NumberFormat, Sampling,
        gcode::{CutterOf, Expand, GcodeOptions, WorkOffset},
    },
};

/// Checks the schema and all tables of a process file, and converts them to a process for `machine`.
pub(super) fn file(spec: &ProcessSpec, check: &Check, folder: &Folder, machine: &Machine) -> Result<Process> {
    match spec.schema {
        Some(version) => check.schema(version)?,
        None => return check.missing("schema"),
    }
    process(spec, check, folder, machine, "")
}

impl Process {
    /// Checks a process whose tables are part of another file, at `check`; that file's text is not among its inputs.
    pub(crate) fn from_tables(spec: &ProcessSpec, check: &Check, folder: &Folder, machine: &Machine) -> Result<Self> {
        if spec.schema.is_some() {
            return check.key("schema").fail("belongs at the top of the file".into());
        }
        process(spec, check, folder, machine, "process.")
    }
}

/// Checks all tables of a process, whose keys begin with `key_prefix` in messages; its inputs are the files that it names.
fn process(
    spec: &ProcessSpec,
    check: &Check,
    folder: &Folder,
    machine: &Machine,
    key_prefix: &'static str,
) -> Result<Process> {
    let sampling = sampling(&spec.sampling, &check.key("sampling"))?;
    let (stock, mesh) = stock::stock(spec, sampling, folder, check)?;
    let has_stock = stock.is_some();
    let (cutting, wrenches) = cutting_law(&spec.force, has_stock, folder, &check.key("force"))?;
    let (own_forces, own_tables) = own_forces(&spec.force_of_tool, &spec.force_of_feature, has_stock, folder, check)?;
    if has_stock && cutting == CuttingLaw::None && own_forces.is_empty() {
        return check.key("force").fail("missing: expected end_milling or drilling, as [stock] is cut".into());
    }
    if has_stock && spec.cutting != CuttingRuleSpec::default() {
        return check
            .key("cutting")
            .fail("is given where [stock] is, which says what cuts: expected no such table".into());
    }
    let feed = feed::limits(spec, [&cutting].into_iter().chain(own_forces.laws()), check)?;
    let features = own_forces.by_feature.iter().map(|(text, _)| text.clone()).collect();
    let check_gcode = check.key("gcode");
    let machine = match &spec.tool {
        Some(tool) => &machine.with_tool(tool, &check.key("tool"))?,
        None => machine,
    };
    let placement = placement(&spec.placement, machine, &check.key("placement"))?;
    let target = spec.compensate.target;
    let (cell, bodies) = cell::cell(spec, stock.as_ref(), machine, folder, check)?;
    let table = |spec| UncertaintyTable::read(spec, folder, check.key("uncertainty"));
    let uncertainty = spec.uncertainty.as_ref().map(table).transpose()?;
    let (uncertainty, covariance) = uncertainty.unzip();
    let stationary_tip = stationary_tip(spec, check)?;
    let process = Process {
        machine: machine.clone(),
        has_own_tool: spec.tool.is_some(),
        stationary_tip: stationary_tip.clone(),
        tolerance_mm: check.tolerance(spec.tolerance_mm, spec.tolerance_zone_mm)?,
        gcode: GcodeOptions {
            features,
            tool_comments: has_stock,
            ..gcode_options(&spec.gcode, machine, &placement, target, &check_gcode)?
        },
        placement,
        is_placed: spec.placement.origin_mm.is_some(),
        cutting,
        own_forces,
        stock,
        cell,
        cutting_rule: cutting_rule(&spec.cutting, &check.key("cutting"))?,
        errors: chain_errors(&spec.chain_error, machine, check)?,
        uncertainty,
        verdict: VerdictTable::resolve(&spec.verdict, spec.temperature.as_ref(), machine, check)?,
        sampling,
        feed,
        limits: limits(&spec.limits, &check.key("limits"))?,
        natural_frequencies_hz: natural_frequencies(spec, check)?,
        target,
        corner_mm: check.key("compensate.corner_mm").not_negative(spec.compensate.corner_mm.unwrap_or(CORNER_MM))?,
        redundancy: redundancy::settings(&spec.redundancy, machine, &check.key("redundancy"))?,
        robot_program: robot::options(&spec.robot_program, stationary_tip.is_some(), &check.key("robot_program"))?,
        decimals: decimals(&spec.gcode, &check_gcode)?,
        write_tolerance_mm: write_tolerance(spec, &check_gcode)?,
        helical_arcs: spec.gcode.helical_arcs.unwrap_or(true),
        path_only_tables: spec.path_only_tables(),
        key_prefix,
        inputs: wrenches.and(own_tables).and(covariance.unwrap_or_default()).and(mesh).and(bodies),
    };
    stock::with_earlier(process, spec.stock.as_ref(), folder, check)
}

/// Returns the tip of a stationary tool, mm, with its place in the file; what errors and uncertain inputs then do is not computed.
fn stationary_tip(spec: &ProcessSpec, check: &Check) -> Result<Option<(Vector3<f64>, Check)>> {
    let Some(tool) = spec.tool.as_ref().filter(|tool| tool.stationary) else { return Ok(None) };
    let check_stationary = check.key("tool.stationary");
    if !spec.chain_error.is_empty() {
        let problem = "is not followed where the tool stands: expected no such table";
        return check.key("chain_error").fail(problem.into());
    }
    if spec.cell.is_some() {
        return check.key("cell").fail("is not looked at where the tool stands: expected no such table".into());
    }
    if spec.uncertainty.is_some() {
        return check_stationary.fail("is not followed with [uncertainty]: expected exact inputs".into());
    }
    Ok(Some((tool.tip_mm.unwrap_or_default().into(), check_stationary)))
}

/// Checks the natural frequencies, Hz; those of the stock are among them.
fn natural_frequencies(spec: &ProcessSpec, check: &Check) -> Result<Vec<f64>> {
    let positive = |check: &Check, given: &[f64]| -> Result<Vec<f64>> {
        let own = given.iter().enumerate();
        own.map(|(k, own)| check.key(&format!("natural_frequencies_Hz[{k}]")).positive(*own)).collect()
    };
    let own = positive(check, &spec.natural_frequencies_hz)?;
    let of_stock = positive(&check.key("stock"), stock::natural_frequencies_hz(spec))?;
    Ok([own, of_stock].concat())
}

/// Checks the placement of the workpiece (degrees become rad), and that the machine can follow its tilt.
fn placement(spec: &PlacementSpec, machine: &Machine, check: &Check) -> Result<Placement> {
    let angle = |key: &str, degrees: f64| check.key(key).finite_scalar(degrees).map(f64::to_radians);
    let roll_pitch_yaw = Vector3::new(
        angle("roll_deg", spec.roll_deg)?,
        angle("pitch_deg", spec.pitch_deg)?,
        angle("yaw_deg", spec.yaw_deg)?,
    );
    let [roll, pitch, yaw] = [0, 1, 2].map(|i| roll_pitch_yaw[i] != 0.0);
    TiltAngles { roll, pitch, yaw }.check(machine, |name| check.key(name))?;
    Ok(Placement {
        origin_mm: check.key("origin_mm").finite(spec.origin_mm.unwrap_or_default())?,
        roll_pitch_yaw,
        reference: spec.reference,
    })
}

/// Checks the rule that decides which moves cut; fails if no height can meet it.
fn cutting_rule(spec: &CuttingRuleSpec, check: &Check) -> Result<CuttingRule> {
    let height = |key: &str, z: Option<f64>| z.map(|z| check.key(key).finite_scalar(z)).transpose();
    let rule = CuttingRule {
        below_z_mm: height("below_z_mm", spec.below_z_mm)?,
        above_z_mm: height("above_z_mm", spec.above_z_mm)?,
        max_feed_mm_per_min: check.key("max_feed_mm_per_min").optional_positive(spec.max_feed_mm_per_min)?,
    };
    match (rule.above_z_mm, rule.below_z_mm) {
        (Some(above), Some(below)) if above > below => {
            check.fail(format!("nothing is both above z = {above} mm and below z = {below} mm"))
        }
        _ => Ok(rule),
    }
}

/// Checks how finely paths are sampled; what is not given has its default.
fn sampling(spec: &SamplingSpec, check: &Check) -> Result<Sampling> {
    let default = Sampling::default();
    let tolerance = spec.chordal_tolerance_mm.unwrap_or(default.chordal_tolerance_mm());
    let tolerance = check.key("chordal_tolerance_mm").positive(tolerance)?;
    let segment = check.key("max_segment_mm").positive(spec.max_segment_mm.unwrap_or(default.max_segment_mm()))?;
    let turn = check.key("max_turn_deg").optional_positive(spec.max_turn_deg)?;
    let sampling = Sampling::new(tolerance, segment)
        .and_then(|sampling| sampling.with_max_turn(turn.map_or(default.max_turn_rad(), f64::to_radians)));
    sampling.or_else(|error| check.fail(error.to_string()))
}

/// Checks the limits of corrections (mm) and drive forces (N), each above 0 if given.
fn limits(spec: &LimitsSpec, check: &Check) -> Result<CorrectionLimits> {
    let change = check.key("max_correction_change_mm");
    Ok(CorrectionLimits {
        correction_mm: check.key("max_correction_mm").optional_positive(spec.max_correction_mm)?,
        correction_change_mm: change.optional_positive(spec.max_correction_change_mm)?,
        force_N: check.key("force_limit_N").optional_positive(spec.force_limit)?,
        objective: spec.objective,
        unloaded_gouge_mm: check.key("unloaded_gouge_mm").optional_positive(spec.unloaded_gouge_mm)?,
    })
}

/// Checks the options for reading G-code: dialect, unit, start, work offsets and rotary axes; features are added later.
fn gcode_options(
    spec: &GcodeSpec,
    machine: &Machine,
    placement: &Placement,
    target: Target,
    check: &Check,
) -> Result<GcodeOptions> {
    let given = [spec.g54_mm, spec.g55_mm, spec.g56_mm, spec.g57_mm, spec.g58_mm, spec.g59_mm];
    let mut work_offsets_mm = BTreeMap::new();
    for (number, given) in (1..).zip(given) {
        if let (Some(offset), Some(given)) = (WorkOffset::from_g10_number(number), given) {
            work_offsets_mm.insert(offset, check.key(&format!("g{}_mm", 53 + number)).finite(given)?);
        }
    }
    for (name, given) in &spec.offsets_mm {
        let check = check.key(&format!("offsets_mm.\"{name}\""));
        match name.parse::<WorkOffset>() {
            Ok(offset) if !offset.has_own_key() => work_offsets_mm.insert(offset, check.finite(*given)?),
            _ => {
                return check.fail(
                    "must be G59.1 to G59.3, G54.1 P1 to G54.1 P300, G15 H1 to G15 H300, G500, G505 to G599 or preset 0 and so on".into(),
                );
            }
        };
    }
    let rotary = rotary(spec, machine, placement, target, check);
    let (rotary, rotary_columns) = check.or_misfit(rotary, Default::default())?;
    Ok(GcodeOptions {
        dialect: spec.dialect,
        unit: spec.unit,
        start_mm: spec.start_mm.map(|start| check.key("start_mm").finite(start)).transpose()?,
        work_offsets_mm,
        block_delete: spec.block_delete,
        arc_centres: spec.arc_centres,
        features: Vec::new(),
        rotary,
        rotary_columns,
        tool_axis: tool_axis(spec, &check.key("tool_axis"))?,
        expand: match spec.expand {
            None => Expand::WhereNeeded,
            Some(true) => Expand::Always,
            Some(false) => Expand::Never,
        },
        calls_kept: spec.calls_kept.clone(),
        cutter_radii_mm: cutter_radii(spec, check)?,
        tool_comments: false,
    })
}

/// Checks how the tool stands in programs that do not say it; returns a unit vector.
fn tool_axis(spec: &GcodeSpec, check: &Check) -> Result<Option<Vector3<f64>>> {
    let Some(given) = spec.tool_axis else { return Ok(None) };
    match check.finite(given)?.try_normalize(1e-9) {
        None => check.fail("has no length: expected a direction".into()),
        axis => Ok(axis),
    }
}

/// Returns the radii of cutters whose compensation is written out; `None` if none is.
fn cutter_radii(spec: &GcodeSpec, check: &Check) -> Result<Option<BTreeMap<CutterOf, f64>>> {
    let mut radii = BTreeMap::new();
    for (name, given) in &spec.cutter_radius_mm {
        let check = check.key(&format!("cutter_radius_mm.{name}"));
        let Ok(of) = name.parse::<CutterOf>() else {
            return check
                .fail("must be D with the number of an offset, or T with that of a tool, such as D1 or T3".into());
        };
        radii.insert(of, check.not_negative(*given)?);
    }
    match spec.cutter_compensation {
        Some(CutterCompensation::Off) => Ok(Some(radii)),
        None if radii.is_empty() => Ok(None),
        None => check.key("cutter_radius_mm").fail("needs cutter_compensation = \"off\"".into()),
    }
}

/// Checks the numbers of decimals of written coordinates, in mm and in inches.
fn decimals(spec: &GcodeSpec, check: &Check) -> Result<Decimals> {
    for (key, decimals) in [("decimals_mm", spec.decimals_mm), ("decimals_inch", spec.decimals_inch)] {
        if let Some(decimals) = decimals.filter(|decimals| !(1..=NumberFormat::MAX_DECIMALS).contains(decimals)) {
            return check.key(key).fail(format!("must be from 1 to {}, got {decimals}", NumberFormat::MAX_DECIMALS));
        }
    }
    Ok(Decimals { mm: spec.decimals_mm, inch: spec.decimals_inch })
}

/// Returns the write tolerance, mm: the given one, or a tenth of the process's tolerance, at most [`WRITE_TOLERANCE_MM`].
fn write_tolerance(spec: &ProcessSpec, check: &Check) -> Result<f64> {
    let half_of_zone = spec.tolerance_zone_mm.map(|width| 0.5 * width);
    match spec.gcode.write_tolerance_mm {
        Some(given) => check.key("write_tolerance_mm").not_negative(given),
        None => Ok(spec
            .tolerance_mm
            .or(half_of_zone)
            .map_or(WRITE_TOLERANCE_MM, |tolerance| WRITE_TOLERANCE_MM.min(tolerance / 10.0))),
    }
}
