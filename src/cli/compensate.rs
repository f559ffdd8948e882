//! `kinetostat compensate`: a program that makes the loaded tool follow its path.

use std::path::{Path, PathBuf};

use clap::Args;
use comfy_table::{Table, presets::UTF8_HORIZONTAL_ONLY};
use kinetostat::{
    compensation::Method,
    input::error::{Error, Result},
    machine::Branch,
    process::file::Process,
    report::{cautions, counted, if_any},
    study::{
        along_path::{Commands, PathAnswer},
        path::report::{facts_text, failures_text},
        program::{
            Corrected, Pass, ProgramJob,
            bounded::Exceedances,
            files::ProgramFiles,
            report::{bounded_text, exceeded_text, program_columns, program_json, program_table},
        },
    },
    toolpath::polyline::Polyline,
    work::Event,
};

use super::{Ending, choice, reporting::Reporting, set};

/// Write the program that makes the loaded tool follow its path, and prove it by simulating what was written.
#[derive(Debug, Args)]
#[command(after_help = "\
The program keeps its format: in G-code only motion words change; comments, line numbers, other words and the feed stay.
Beside the program, its points and errors are written to OUT.points.csv and OUT.report.json. Files of these names are only
replaced if they are as this command left them.

Examples:
  kinetostat compensate part.nc --machine orthoglide --process milling.toml --out part_compensated.nc
  kinetostat compensate path.csv --machine my_machine.toml --process milling.toml --method newton --out compensated.csv
  kinetostat compensate part.nc --machine orthoglide --process limited.toml --method bounded --out part_bounded.nc
  kinetostat compensate path.csv --machine orthoglide --process milling.toml --measured pass1.csv --out mirrored.csv
  kinetostat compensate path.csv --machine kr270 --branch front-up-noflip --process milling.toml --out compensated.csv")]
pub struct CompensateArguments {
    /// Program: a polyline (.csv) or G-code (any other name)
    path: PathBuf,
    /// Built-in machine or machine file
    #[arg(long, short)]
    machine: String,
    /// Hold a drive at a position, mm or degrees as a pendant shows it: one that the task does not need (a rail), or one under the
    /// workpiece; repeatable
    #[arg(long, value_parser = set::setting, value_name = "DRIVE=VALUE")]
    hold: Vec<set::Setting>,
    /// Branch on which an arm with a spherical wrist is to stand [default: the one of home, and others where it does not reach]
    #[arg(long, value_parser = choice::branch())]
    branch: Option<Branch>,
    /// Process file: placement, cutting force, chain errors, limits
    #[arg(long, short)]
    process: PathBuf,
    /// File for the compensated program
    #[arg(long, short)]
    out: PathBuf,
    /// How commands are found: none, linear, mirror, mirror_N (N passes), matrix_free, fixed_matrix, procedure, newton, direct,
    /// or bounded: the whole path at once within the [limits] of the process and the machine
    #[arg(long, default_value = "direct")]
    method: String,
    /// Step length of matrix_free, fixed_matrix and procedure, above 0 and at most 1 [default: 1]
    #[arg(long, conflicts_with = "measured")]
    alpha: Option<f64>,
    /// Mirror this measured pass instead of using a method: CSV with one position per point of the path, or per row of a
    /// polyline
    #[arg(long, conflicts_with = "method")]
    measured: Option<PathBuf>,
    /// Also simulate every other method for comparison
    #[arg(long)]
    all_methods: bool,
    #[command(flatten)]
    reporting: Reporting,
}

pub fn compensate(arguments: &CompensateArguments) -> Result<Ending> {
    let reporting = &arguments.reporting;
    reporting.start_log()?;
    let machine = set::machine(&arguments.machine, &[], arguments.branch)?.machine()?;
    let machine = set::held(&machine, &arguments.hold)?;
    let process = Process::open(&arguments.process, &machine)?;
    let chosen = chosen(arguments)?;
    let job = ProgramJob::open(process, &arguments.path)?;
    let measured = arguments.measured.as_deref().map(|file| measured(file, &job)).transpose()?;
    // When all inputs are read: none of them is written over.
    let files = ProgramFiles::prepare(&arguments.out)?;
    let compared = compared(arguments, &chosen);
    let name = arguments.path.display().to_string();
    let progress = reporting.progress(&name, job.path.len() * (compared.len() + 2), "points");
    let done = || progress.tell(Event::Computed(1));
    // First what is asked for: where there is no command, the others are of no use.
    let mut corrected = Corrected::new(&job);
    let take = |_, answers: &[PathAnswer]| {
        corrected.add(&job, answers);
        if corrected.failures.is_empty() { Ok(()) } else { Err(Error::Stopped) }
    };
    let mut bounded = None;
    let own = match (&measured, chosen) {
        (Some(poses), _) => job.pass("mirror of the measured pass", &Commands::Program(poses), &done, take),
        (None, Chosen::Method(method)) => job.pass_by(method, &done, take),
        (None, Chosen::Bounded) => job.bounded_pass(&done, take).map(|found| {
            bounded = Some(found.path);
            found.pass
        }),
    };
    if !corrected.failures.is_empty() {
        progress.end();
        reporting.print(&refusal(&job, &corrected))?;
        return Ok(Ending::SomeUnsolved);
    }
    let own = own?;
    let (mut passes, mut before) = (Vec::new(), Vec::new());
    for (index, &method) in compared.iter().enumerate() {
        passes.push(job.pass_by(method, &done, |_, answers| {
            if index == 0 {
                before.extend(answers.iter().map(|answer| Some(answer.settled_error()?.norm())));
            }
            Ok(())
        })?);
    }
    let as_written = format!("{}, as written", own.name);
    passes.push(own);
    let written = job.write(&corrected)?;
    let made = files.staging()?;
    let mut points = files.points(made.path(), &program_columns(&job.machine))?;
    let mut exceedances = bounded.as_ref().map(|bounded| Exceedances::new(&job, bounded));
    passes.push(job.pass(as_written, &Commands::Program(&written.poses), &done, |first, answers| {
        exceedances.iter_mut().for_each(|exceedances| exceedances.add(first, answers));
        points.add(&program_table(&job, first, answers, &before, bounded.as_ref()))
    })?);
    progress.end();
    let exceeded = exceedances.map(Exceedances::worst);
    files.write(written.bytes, points.finish()?, program_json(&job, &passes, bounded.as_ref(), exceeded.as_deref()))?;
    let unsolved = unsolved_as_written(&passes);
    if let Some(sentence) = &unsolved {
        reporting.print(sentence)?;
    }
    let worse = worse_as_written(&passes, written.rounded_mm);
    if let Some(sentence) = &worse {
        reporting.print(sentence)?;
    }
    reporting.print(&format!("{}{TABLE}\n{}", header(&job), table(&passes)))?;
    if let (Some(bounded), Some(exceeded)) = (&bounded, &exceeded) {
        reporting.print(&bounded_text(&job.machine, bounded))?;
        reporting.print(&exceeded_text(&job, exceeded))?;
    } else if job.process.limits.is_limited() {
        reporting.print("The limits of the process were not looked at: --method bounded keeps them.\n")?;
    }
    reporting.print(&left_text(&job, &passes))?;
    if corrected.left_alone > 0 {
        reporting.print(&format!(
            "Left as written, as there is no correction: {} where nothing is cut.\n",
            counted(corrected.left_alone, "position")
        ))?;
    }
    reporting.print(&format!("Written to {}\n", arguments.out.display()))?;
    Ok(if unsolved.is_some() || worse.is_some() { Ending::SomeUnsolved } else { Ending::Complete })
}

/// What no drive can put right, where there is such a thing.
fn left_text(job: &ProgramJob, passes: &[Pass]) -> String {
    let left = passes.iter().rev().nth(1).and_then(|own| own.summary.max_mm);
    let (Some(axes), Some(left)) = (job.machine.uncontrolled_names(), left) else { return String::new() };
    format!("What is left, up to {}, no drive can put right: they do not control {axes}.\n", millimetres(left))
}

/// A program may leave this many times its rounding more than the commands that it was written from.
const ROUNDINGS: f64 = 10.0;

/// What the answer begins with if the program as written leaves more than its commands do and rounding, by `rounded_mm` at
/// most, explains.
fn worse_as_written(passes: &[Pass], rounded_mm: f64) -> Option<String> {
    let [.., commanded, written] = passes else { return None };
    let (commanded, written) = (commanded.summary.max_mm?, written.summary.max_mm?);
    let explained = commanded + ROUNDINGS * rounded_mm + EXACT_MM;
    let sentence = || {
        format!(
            "Do not run the written program: it leaves {}, its commands leave {} and writing them moved none by more than {}.\n",
            millimetres(written),
            millimetres(commanded),
            millimetres(rounded_mm)
        )
    };
    (written > explained).then(sentence)
}

/// What is left where nothing is rounded, mm.
const EXACT_MM: f64 = 1e-6;

/// What the answer begins with if points of the last pass, the program as written, have no equilibrium or cannot be reached.
fn unsolved_as_written(passes: &[Pass]) -> Option<String> {
    let summary = &passes.last()?.summary;
    let lost = summary.points - summary.solved;
    let sentence = format!(
        "{lost} of {} not solved: the written program fails there; the table of points says why.\n",
        summary.points
    );
    (lost > 0).then_some(sentence)
}

/// How commands are to be found.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Chosen {
    Method(Method),
    Bounded,
}

fn chosen(arguments: &CompensateArguments) -> Result<Chosen> {
    let fault = |argument: &str, problem: String| Err(Error::Argument { argument: argument.into(), problem });
    let alpha = arguments.alpha.unwrap_or(1.0);
    if !(alpha > 0.0 && alpha <= 1.0) {
        return fault("--alpha", format!("must be above 0 and at most 1, got {alpha}"));
    }
    let method = Method::named(&arguments.method, alpha);
    if arguments.alpha.is_some() && !method.is_some_and(Method::has_step_length) {
        return fault("--alpha", format!("method {} has no step length", arguments.method));
    }
    match (arguments.method.as_str(), method) {
        ("bounded", _) => Ok(Chosen::Bounded),
        (_, Some(method)) => Ok(Chosen::Method(method)),
        (name, None) => {
            let names = Method::ALL.map(Method::label).join(", ");
            fault("--method", format!("no method \"{name}\"; there are: {names}, bounded"))
        }
    }
}

/// Methods simulated for comparison: none at all, then what a shop would otherwise use, or all.
fn compared(arguments: &CompensateArguments, chosen: &Chosen) -> Vec<Method> {
    let is_chosen = |method: &Method| matches!(chosen, Chosen::Method(own) if own.label() == method.label());
    let usual = |method: &Method| matches!(method, Method::None | Method::Linear | Method::Mirror { passes: 1 });
    let others = Method::ALL.into_iter().filter(|method| !is_chosen(method) || *method == Method::None);
    others.filter(|method| arguments.all_methods || usual(method)).collect()
}

fn measured(file: &Path, job: &ProgramJob) -> Result<Vec<kinetostat::spatial::Pose>> {
    let bytes = kinetostat::input::file::read(file)?;
    let went = Polyline::read(bytes, &file.display().to_string())?.toolpath().positions_mm();
    let went =
        job.measured(went).map_err(|problem| Error::Argument { argument: file.display().to_string(), problem })?;
    Ok(job.mirrored(&went))
}

fn header(job: &ProgramJob) -> String {
    let cutting = job.path.points().iter().filter(|point| point.cutting).count();
    let machine = &job.machine;
    let facts = facts_text(&job.process.facts());
    let outside =
        cautions::outside_workspace(machine, "point", job.demands.iter().map(|demand| demand.pose.translation));
    let cautions = cautions::carried(machine) + &cautions::large_errors(machine, &job.process.errors) + &outside;
    format!(
        "{}: {}, {cutting} of them cutting, path length {:.1} mm\n{facts}{cautions}",
        job.machine.title,
        counted(job.path.len(), "point"),
        job.path.length_mm()
    )
}

const TABLE: &str = "Distance of the point put right from the wanted path, where the tool cuts:";

fn table(passes: &[Pass]) -> String {
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY);
    table.set_header(["commands", "max", "rms", "corrections", "rotation left", "points"]);
    for pass in passes {
        let s = &pass.summary;
        table.add_row([
            pass.name.clone(),
            if_any(s.max_mm, millimetres),
            if_any(s.rms_mm, millimetres),
            if_any(s.mean_corrections, |mean| format!("{mean:.1}")),
            if_any(s.max_leftover_rotation, |angle| format!("{:.3}°", angle.to_degrees())),
            format!("{} of {}", s.solved, s.points),
        ]);
    }
    let failures = passes.iter().map(|pass| (pass.name.clone(), &pass.summary));
    format!("{table}\n{}", failures_text(failures))
}

/// A length to a micrometre, or to its order where it is smaller.
fn millimetres(length: f64) -> String {
    match length {
        0.0 => "0 mm".into(),
        length if length < 1e-3 => format!("{length:.1e} mm"),
        length => format!("{length:.4} mm"),
    }
}

/// Points shown of those that cannot be compensated.
const SHOWN: usize = 5;

fn refusal(job: &ProgramJob, corrected: &Corrected) -> String {
    let (failures, seen) = (&corrected.failures, corrected.seen());
    let all =
        if seen < job.path.len() { format!(" among the first {}", counted(seen, "point")) } else { String::new() };
    let mut text =
        format!("No command for {}{all}; nothing was written. The first:\n", counted(failures.len(), "cutting point"));
    for (point, reason) in failures.iter().take(SHOWN) {
        let at = &job.path.points()[*point];
        let line = job.file.line_of(at.source.segment).map_or_else(String::new, |line| format!("line {line}, "));
        let [x, y, z]: [f64; 3] = at.position_mm.into();
        text += &format!("  {line}point {point} at ({x:.3}, {y:.3}, {z:.3}) mm: {reason}\n");
    }
    header(job) + &text
}
