//! Checks of a path study as written, which make it a [`PathStudy`].

use std::sync::Arc;

use nalgebra::Vector3;

use crate::{
    compensation::{Method, TaskPoint},
    input::{Inputs, check::Check, error::Result, names::listed},
    machine::Machine,
    process::{CutPath, ForceText, Process, program_inputs},
    questions::{
        Overrides, Question, Resolved, StudyContext, Template,
        path::{
            PathGammaSearch, PathStudy, Shown, Station,
            spec::{LineSpec, PathSpec},
        },
        spec::CircleSpec,
    },
    simulation::{
        TrackedPath,
        tasks::{PoseTracker, drawn_forces_at, tasks},
        with_drives_left,
    },
    toolpath::{Circle, PathPoint, Plane, ProgramFile, Sampling, Toolpath, TurnDirection},
    work::Work,
};

impl Question for PathStudy {
    type Spec = PathSpec;
    type Shown = super::Shown;
    const NAME: &str = "a path study";
    const TEMPLATE: Template = Template {
        name: "path",
        about: "How far the tool leaves a path, and which drive commands compensate that",
        files: &[
            ("study.toml", include_str!("template/study.toml")),
            ("process.toml", include_str!("template/process.toml")),
        ],
    };
    const TABLES: &[&str] = &["points", "methods"];

    /// Checks the path study and reads its program.
    fn resolve(spec: &PathSpec, context: &StudyContext<'_>) -> Result<Resolved<Self>> {
        context.overrides.refuse_grid(context.name)?;
        let process = context.process_with_gamma(None, &context.check)?;
        let (mut study, toolpath, program) = path(spec, &process, context, &context.check)?;
        let tools = toolpath.cutting_tools();
        let (table, cut) = (process.uncertainty.as_ref(), process.cut_by(&tools));
        let (uncertainty, read) = context.uncertainty(table, &study.machine, &study.errors, &cut)?;
        if let Some(uncertainty) = &uncertainty {
            let components = process.component_loads(&toolpath, &uncertainty.force);
            let TrackedPath { machine, placement, .. } = &study.tracked;
            study.drawn_forces = drawn_forces_at(uncertainty, machine, placement, &toolpath, components.as_ref());
        }
        study.tracked.uncertainty = uncertainty.map(Arc::new);
        if study.uncertainty.is_some() && study.gamma_search.is_some() {
            let problem = "is not computed where γ is sought: compensate with the γ found first, and give that program";
            return context.check.root().key("uncertainty").fail(problem.into());
        }
        let points = Inputs::of("points of the path", study.stations.len().to_string());
        let inputs = process.inputs.and(read).and(program).and(points);
        Ok(Resolved { study, shown: Shown { is_circle: spec.circle.is_some() }, inputs })
    }

    /// Returns the number of points that are solved: the points of the path in each pass.
    fn items(&self) -> (usize, &'static str) {
        (self.stations.len() * super::pass_count(self), "points")
    }

    /// Returns the number of blocks of all passes along the path.
    fn pieces(&self) -> usize {
        super::block_count(self)
    }

    /// Solves the path and keeps its blocks in `work`, after the search for γ if there is one.
    fn compute(&self, work: &Work) -> Result<()> {
        super::run_in_parts(self.with_gamma(work)?.as_ref(), work, |_| Ok(())).map(drop)
    }
}

/// Returns the path study that `spec` describes, checked at `check` and cut by `process`, its path, and the program that it is read from as an input.
pub(crate) fn path(
    spec: &PathSpec,
    process: &Process,
    context: &StudyContext<'_>,
    check: &Check,
) -> Result<(PathStudy, CutPath, Inputs)> {
    let (toolpath, program) = match &spec.line {
        Some(line) if spec.circle.is_none() && spec.file.is_none() => {
            (self::line_toolpath(line, process, &check.key("line"))?, None)
        }
        Some(_) => return check.key("line").fail("give exactly one of circle, line and file".into()),
        None => toolpath(spec.circle.as_ref(), spec.file.as_deref(), process, context, check)?,
    };
    let origin =
        spec.file.as_ref().map_or_else(|| check.location(), |file| context.folder.path(file).display().to_string());
    let toolpath = process.mark_cutting(toolpath, &origin)?;
    let process = &with_drives_left(process.clone(), &toolpath, program.as_ref(), &origin)?;
    let tasks = tasks(process, &toolpath, &origin)?;
    let line_name = |segment: usize| program.as_ref()?.line_name(segment);
    let ForceText { unknown, known, of_turn } = ForceText::of(process, &toolpath, &line_name);
    let of_force =
        [("force not known", unknown), ("mean or peak", of_turn)].into_iter().filter(|own| !own.1.is_empty());
    let of_force = of_force.map(|(label, text)| (label, text.trim_end_matches(['.', '\n']).to_string()));
    let study = PathStudy {
        tracked: TrackedPath::of(process),
        stations: stations(process, toolpath.points(), &tasks, program.as_ref()),
        tasks,
        fastest_mm_per_s: toolpath.largest_cutting_feed_mm_per_min().map(|own| own / 60.0),
        methods: named_methods(spec, &check.key("methods"))?,
        is_closed: spec.file.is_some() && toolpath.is_closed(),
        facts: process.facts(),
        assumed: process.assumed().into_iter().chain(of_force).collect(),
        gamma_search: PathGammaSearch::of(process, &toolpath, &origin),
        called_files: program.as_ref().map_or_else(Vec::new, ProgramFile::called_files),
        known_force: known,
        verdict: process.verdict.clone(),
        drawn_forces: Vec::new(),
        cell: process.cell.clone(),
    };
    Ok((study, toolpath, program_input(spec.file.as_deref(), program.as_ref())))
}

/// Returns the program called `file` as an input; no inputs for a circle or line, which stand in the study.
pub(crate) fn program_input(file: Option<&str>, program: Option<&ProgramFile>) -> Inputs {
    file.zip(program).map_or_else(Inputs::default, |(file, program)| program_inputs(program, file))
}

/// Returns the toolpath of a circle, or of a program in the study's folder together with the program. `Err` unless exactly one is given.
pub(crate) fn toolpath(
    circle: Option<&CircleSpec>,
    file: Option<&str>,
    process: &Process,
    context: &StudyContext<'_>,
    check: &Check,
) -> Result<(Toolpath, Option<ProgramFile>)> {
    match (circle, file) {
        (Some(circle), None) => {
            Ok((self::circle_toolpath(circle, &context.machine, context.overrides, &check.key("circle"))?, None))
        }
        (None, Some(_)) if context.overrides.points.is_some() => {
            Overrides::location("points").fail("the points of a path from a file are those of the file".into())
        }
        (None, Some(file)) => {
            let program = process.program_in_folder(context.folder, file)?;
            let path = program.toolpath(process.sampling)?;
            if path.is_empty() {
                let problem = format!("{file} moves nowhere: a program with at least one motion is expected");
                return check.key("file").fail(problem);
            }
            Ok((path, Some(program)))
        }
        _ => check.key("circle").fail("give exactly one of circle and file".into()),
    }
}

/// Refuses paths that together have more than [`Sampling::MAX_POINTS`] points.
pub(crate) fn check_total(points: usize, check: &Check) -> Result<()> {
    match points {
        0..=Sampling::MAX_POINTS => Ok(()),
        _ => check.fail(format!("the paths have {points} points together: expected at most {}", Sampling::MAX_POINTS)),
    }
}

/// Returns how many points the circles have together, with the number of the command line if it gives one.
pub(crate) fn circle_points<'a>(circles: impl Iterator<Item = &'a CircleSpec>, overrides: &Overrides) -> usize {
    circles.map(|circle| overrides.points.unwrap_or(circle.points)).fold(0, usize::saturating_add)
}

/// Returns the toolpath along a straight line in W, with the point spacing of the process.
fn line_toolpath(spec: &LineSpec, process: &Process, check: &Check) -> Result<Toolpath> {
    let start = check.key("start_mm").finite(spec.start_mm)?;
    let end = check.key("end_mm").finite(spec.end_mm)?;
    Toolpath::line(start, end, process.sampling).or_else(|fault| check.fail(fault.to_string()))
}

/// Returns the toolpath around a full circle in the xy-plane of W, counter-clockwise.
fn circle_toolpath(spec: &CircleSpec, machine: &Machine, overrides: &Overrides, check: &Check) -> Result<Toolpath> {
    let centre_mm = match (spec.centre_mm, &spec.centre_point) {
        (Some(centre), None) => check.key("centre_mm").finite(centre)?,
        (None, Some(name)) => named_point(machine, name, &check.key("centre_point"))?,
        _ => return check.key("centre_mm").fail("give exactly one of centre_mm and centre_point".into()),
    };
    let circle = Circle {
        centre_mm,
        diameter_mm: check.key("diameter_mm").positive(spec.diameter_mm)?,
        plane: Plane::Xy,
        turn: TurnDirection::CounterClockwise,
        start_angle_rad: 0.0,
        points: overrides.points.unwrap_or(spec.points),
    };
    circle.toolpath().or_else(|fault| check.fail(fault.to_string()))
}

/// Returns the position of the machine's point `name`, O, mm. `Err` on a machine with a workpiece carrier.
pub(crate) fn named_point(machine: &Machine, name: &str, check: &Check) -> Result<Vector3<f64>> {
    match machine.point(name) {
        Some(point) if machine.carrier.is_some() => check.misfit(on_carrier_problem(machine, name), point.position),
        Some(point) => Ok(point.position),
        None => {
            let known = listed(machine.points.iter().map(|point| &point.name));
            let known =
                if known.is_empty() { "no points are named in its file" } else { &format!("there are: {known}") };
            check.misfit(format!("the machine has no point \"{name}\"; {known}"), machine.home.pose.translation)
        }
    }
}

/// Returns the error message for a named point of `machine` used as a position on its workpiece carrier.
pub(crate) fn on_carrier_problem(machine: &Machine, name: &str) -> String {
    let carrier = machine.carrier.as_ref().map_or("", |carrier| carrier.name.as_str());
    format!(
        "point \"{name}\" is a place in the base, and the workpiece lies on the carrier {carrier}: expected coordinates on it"
    )
}

/// Returns the compensation methods that the study names, or all if it has no such key. `Err` if a name is unknown.
fn named_methods(spec: &PathSpec, check: &Check) -> Result<Vec<Method>> {
    let Some(names) = &spec.methods else { return Ok(Method::ALL.into()) };
    let method = |name: &String| match Method::named(name, 1.0) {
        Some(method) => Ok(method),
        None => {
            let known = Method::ALL.map(Method::label).join(", ");
            check.fail(format!("no method is called \"{name}\"; there are: {known}"))
        }
    };
    names.iter().map(method).collect()
}

/// Returns the station of each point. φ is the heading about the tool axis less 90°: on a circle about it, the polar angle of the point.
pub(crate) fn stations(
    process: &Process,
    points: &[PathPoint],
    tasks: &[TaskPoint],
    program: Option<&ProgramFile>,
) -> Vec<Station> {
    let mut track = PoseTracker::new(&process.machine, &process.placement);
    let station = |(point, task): (&PathPoint, &TaskPoint)| {
        let placed = track.placed(task.external);
        let heading = placed
            .with_platform_rotation(&task.pose.rotation)
            .tool_axes()
            .tr_mul(&point.tangent)
            .xy()
            .try_normalize(1e-6);
        Station {
            arc_length_mm: point.arc_length_mm,
            phi_deg: heading.map(|h| rounded_angle(libm::atan2(h.y, h.x).to_degrees() - 90.0)),
            cutting: point.cutting,
            arrival: point.into(),
            line: program.and_then(|program| program.line_of(point.source.segment)),
            file: program.map_or(0, |program| program.file_of(point.source.segment)),
        }
    };
    points.iter().zip(tasks).map(station).collect()
}

/// Returns an angle in [0, 360) degrees, rounded to 1e-9.
fn rounded_angle(degrees: f64) -> f64 {
    ((degrees.rem_euclid(360.0) * 1e9).round() / 1e9).rem_euclid(360.0)
}
