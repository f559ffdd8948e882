//! `kinetostat compensate`: writes a program that makes the loaded tool follow its path.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use clap::Args;
use kinetostat::{
    answer::cautions,
    compensation::Method,
    files::{Foreign, counted, exchange::WrittenRows, millimetres_in_table, text_table::text_table},
    input::error::{Error, Result},
    process::{GammaChoice, file::Process},
    products::program::{
        CommandSource, CompensateOptions, NotWritten, Pass, ProgramJob,
        files::{ProgramFiles, ProgramOutcome, compensate_into},
        report::{outside_workspace, passes_table},
    },
    questions::path::report::{facts_text, failures_text},
    toolpath::{CommandedPath, gcode::Expand, polyline::Polyline},
    work::Work,
};

use super::{Ending, choice, headline, on_machine::OnMachine, reporting::Reporting};

/// Write the program that makes the loaded tool follow its path, and verify it by simulating what was written.
#[derive(Debug, Args)]
#[command(after_help = "\
The program keeps its format: in G-code only motion words change; comments, line numbers, other words and, without [feed] in the process,
the feed stay.
Beside the program, its points and errors are written to OUT.points.csv and OUT.report.json, what the verdict rests on to OUT.budget.csv, and a page about the program to OUT.html.
Files that the program calls are written beside it, too, if their calls stay. Files of these names are only replaced if they are
as this command left them, or with --force.

Examples:
  kinetostat compensate part.nc --machine orthoglide --process milling.toml --out part_compensated.nc
  kinetostat compensate path.csv --machine my_machine.toml --process milling.toml --method newton --out compensated.csv
  kinetostat compensate part.nc --machine orthoglide --process limited.toml --method bounded --out part_bounded.nc
  kinetostat compensate path.csv --machine orthoglide --process milling.toml --measured pass1.csv --out mirrored.csv
  kinetostat compensate path.csv --machine kr270 --branch front-up-noflip --process milling.toml --out compensated.csv
  kinetostat compensate path.csv --machine kr270 --redundancy best --process milling.toml --out turned.csv")]
pub struct CompensateArguments {
    /// Program: a polyline (.csv), KRL (.src), RAPID (.mod, .prg), FANUC (.ls), URScript (.script), APT (.apt, .cl, .cls, .ncl) or G-code (any other name)
    path: PathBuf,
    #[command(flatten)]
    on: OnMachine,
    /// Rotation about the tool axis along a polyline, instead of that of [redundancy] of the process; the compensated program says how the
    /// platform stands at each point
    #[arg(long, value_parser = choice::redundancy())]
    redundancy: Option<GammaChoice>,
    /// File for the compensated program
    #[arg(long, short)]
    out: PathBuf,
    /// Replace OUT and the files beside it even if they were not written by this command, or were changed since
    #[arg(long)]
    force: bool,
    /// Language of a program that is no CSV [default: as [gcode] of the process says, or auto]
    #[arg(long, value_parser = choice::dialect())]
    dialect: Option<choice::ChosenDialect>,
    /// Write the program (G-code, RAPID) out as the motion it makes before correcting it, its calls and its cycles [default: as expand in [gcode]
    /// of the process says, or only where lines that run several times have other corrections each time]
    #[arg(long)]
    expand: bool,
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
    /// Write all points into OUT.points.csv [default: at most 50000 rows: the worst points, and points at equal steps]
    #[arg(long, value_name = "all")]
    points: Option<WrittenRows>,
    /// Also simulate every other method for comparison [default: linear and mirror, up to 20 000 points]
    #[arg(long)]
    all_methods: bool,
    #[command(flatten)]
    reporting: Reporting,
}

/// Runs `kinetostat compensate`: writes the compensated program and prints its errors, or why none was written.
pub fn compensate(arguments: &CompensateArguments) -> Result<Ending> {
    let reporting = &arguments.reporting;
    reporting.start_log()?;
    let started = Instant::now();
    let mut process = arguments.on.process()?;
    if let Some(choice::ChosenDialect(dialect)) = arguments.dialect {
        process.gcode.dialect = dialect;
    }
    if arguments.expand {
        process.gcode.expand = Expand::Always;
    }
    let chosen = chosen_source(arguments)?;
    process.redundancy.gamma = arguments.redundancy.unwrap_or(process.redundancy.gamma);
    let job = open_job(process, &arguments.path, reporting)?;
    let commands = match &arguments.measured {
        Some(file) => CommandSource::Mirror(mirrored_pass(file, &job)?),
        None => chosen,
    };
    // When all inputs are read: none of them is written over.
    let files = ProgramFiles::prepare(&arguments.out, Foreign::forced(arguments.force))?
        .with_rows(arguments.points.unwrap_or_default());
    let is_long = job.path.len() > COMPARED;
    let asked = CompensateOptions {
        compared: compared_methods(arguments, is_long),
        commands,
        sources_apart: true,
        ends_early: true,
    };
    let (name, passes) = (arguments.path.display().to_string(), asked.pass_count(&job));
    let progress = reporting.progress(&name, passes * job.path.len(), &format!("points in {passes} passes"));
    let file_name = arguments.path.file_name().unwrap_or_default().to_string_lossy();
    let outcome = compensate_into(job, &asked, &files, &file_name, &progress.work());
    progress.end();
    let results = match outcome? {
        ProgramOutcome::Written(results) => *results,
        ProgramOutcome::Refused(job, refused) => {
            reporting.print(&refusal_text(&job, &refused)?)?;
            return Ok(Ending::SomeUnsolved);
        }
    };
    let (headline, verified) = (&results.headline, &results.verified);
    reporting.print_styled(&headline::result_text(headline, &format!("{:.1} s", started.elapsed().as_secs_f64())))?;
    if let Some(gamma) = &results.gamma {
        reporting.print(&format!("\n{gamma}"))?;
    }
    if reporting.is_verbose() {
        reporting.print(&format!("\n{}", results.facts))?;
    }
    reporting.print(&format!("\n{}\n{}", TABLE, pass_table(&verified.passes)))?;
    if is_long && !arguments.all_methods {
        reporting.print("Of so many points, other methods are simulated with --all-methods only.\n")?;
    }
    reporting.print_styled(&headline::sentences(&results.findings))?;
    if verified.uncorrected > 0 {
        let positions = counted(verified.uncorrected, "position");
        reporting.print(&format!("Left as written, as there is no correction: {positions} where nothing is cut.\n"))?;
    }
    if let Some(rows) = &results.rows {
        reporting.print(&format!("{rows}\n"))?;
    }
    reporting.print(&format!("Written to {}; read {}\n\n", arguments.out.display(), results.page.display()))?;
    reporting.print_styled(&headline::sentences(&results.used))?;
    let does_harm = verified.worse_as_written().is_some() || verified.is_probably_worse();
    let is_unsure = results.exceeds_feed_limits || results.knows_no_force || results.hits;
    Ok(Ending::of(headline.unsolved.is_none() && !does_harm && !is_unsure))
}

/// Opens the program to compensate, with progress where γ is sought or stock is cut.
fn open_job(process: Process, path: &Path, reporting: &Reporting) -> Result<ProgramJob> {
    let of = match (process.redundancy.is_sought(), process.stock.is_some()) {
        (true, _) => "values of γ",
        (false, true) => "moves cut",
        (false, false) => return ProgramJob::open(process, path, &Work::default()),
    };
    // Before Ctrl-C waits for the next point.
    let program = process.read_program(path)?;
    let name = path.display().to_string();
    let progress = reporting.progress(&name, 0, of);
    let job = ProgramJob::new(process, program, &name, &progress.work());
    progress.end();
    job
}

/// Returns the source of commands that the arguments choose; an error for an unknown method or a wrong step length.
fn chosen_source(arguments: &CompensateArguments) -> Result<CommandSource> {
    let fault = |argument: &str, problem: String| Err(Error::argument(argument, problem));
    let alpha = arguments.alpha.unwrap_or(1.0);
    if !(alpha > 0.0 && alpha <= 1.0) {
        return fault("--alpha", format!("must be above 0 and at most 1, got {alpha}"));
    }
    let method = Method::named(&arguments.method, alpha);
    if arguments.alpha.is_some() && !method.is_some_and(Method::has_step_length) {
        return fault("--alpha", format!("method {} has no step length", arguments.method));
    }
    match (arguments.method.as_str(), method) {
        ("bounded", _) => Ok(CommandSource::Bounded),
        (_, Some(method)) => Ok(CommandSource::Method(method)),
        (name, None) => {
            let names = Method::ALL.map(Method::label).join(", ");
            fault("--method", format!("no method \"{name}\"; there are: {names}, bounded"))
        }
    }
}

/// Most points of a program for which other methods are simulated unasked.
const COMPARED: usize = 20_000;

/// Returns the methods simulated for comparison besides none: the usual ones, none where the program is long, or all.
fn compared_methods(arguments: &CompensateArguments, is_long: bool) -> Vec<Method> {
    let chosen = Method::named(&arguments.method, 1.0).map(Method::label);
    let is_chosen = |method: &Method| chosen == Some(method.label());
    let usual = |method: &Method| !is_long && matches!(method, Method::Linear | Method::Mirror { passes: 1 });
    let others = Method::ALL.into_iter().filter(|method| *method != Method::None && !is_chosen(method));
    others.filter(|method| arguments.all_methods || usual(method)).collect()
}

/// Returns the path that mirrors the measured pass in `file`; an error if it has another number of positions than the program.
fn mirrored_pass(file: &Path, job: &ProgramJob) -> Result<CommandedPath> {
    let bytes = kinetostat::input::file::read(file)?;
    let path = Polyline::read(bytes, &file.display().to_string())?.toolpath().positions_mm();
    let path = job.measured_points(path).map_err(|problem| Error::argument(file.display().to_string(), problem))?;
    Ok(job.mirrored_path(&path))
}

/// Returns machine, program and cautions in words, for a refusal.
fn header_text(job: &ProgramJob) -> Result<String> {
    let cutting = job.path.points().iter().filter(|point| point.cutting).count();
    let machine = &job.machine;
    let facts = facts_text(&job.process.facts());
    let outside = outside_workspace(job)?.text("point");
    let cautions = cautions::carrier(machine) + &cautions::large_errors(machine, &job.process.errors) + &outside;
    let (name, points, length) = (&machine.name, counted(job.path.len(), "point"), job.path.length_mm());
    Ok(format!("{name}: {points}, {cutting} of them cutting, path length {length:.1} mm\n{facts}{cautions}"))
}

const TABLE: &str =
    "Error of the tool's path while it cuts, without and with compensation (steps: correction steps per point):";

/// Returns the table of passes and the failures of their commands.
fn pass_table(passes: &[Pass]) -> String {
    let (header, rows) = passes_table(passes, true, |length_mm| millimetres_in_table(length_mm, 4));
    let mut table = text_table(header, 1);
    table.add_rows(rows);
    let failures = passes.iter().map(|pass| (pass.name.clone(), &pass.summary));
    format!("{table}\n{}", failures_text(failures))
}

/// Most points that are shown of those that cannot be compensated.
const SHOWN: usize = 5;

/// Returns which points have no command and why.
fn refusal_text(job: &ProgramJob, refused: &NotWritten) -> Result<String> {
    let (count, visited) = (counted(refused.failures.len(), "cutting point"), refused.visited);
    let mut text = match visited < job.path.len() {
        _ if refused.is_out_of_reach => {
            "The machine cannot reach or track every point; nothing was written. The first points:\n".into()
        }
        true => {
            let among = counted(visited, "point");
            format!("Compensation stops: it fails at {count} of the first {among}. Nothing was written. The first:\n")
        }
        false => format!("Compensation fails at {count}. Nothing was written. The first:\n"),
    };
    for (point, reason) in refused.failures.iter().take(SHOWN) {
        let path_point = &job.path.points()[*point];
        let line = job.file.line_name(path_point.source.segment).map_or_else(String::new, |line| format!("{line}, "));
        let [x, y, z]: [f64; 3] = path_point.position_mm.into();
        text += &format!("  {line}point {point} at ({x:.3}, {y:.3}, {z:.3}) mm: {reason}\n");
    }
    Ok(header_text(job)? + &text)
}
