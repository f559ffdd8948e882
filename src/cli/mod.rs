//! The command line: a file for each command, arguments, terminal, Ctrl-C, exit codes.

mod check;
mod choice;
mod compare;
mod compensate;
mod explore;
mod export_correction;
mod export_realtime;
mod headline;
mod machines;
mod measuring;
mod merge;
mod new;
mod on_machine;
mod point;
mod progress;
mod report;
mod reporting;
mod results;
mod run;

use std::{
    io::{ErrorKind, Write},
    sync::atomic::{AtomicBool, Ordering},
};

use clap::{Args, CommandFactory, Parser, Subcommand};
use clap_complete::{Shell, generate};
use kinetostat::{
    ending::{Ending, STOPPED},
    files::{visible, visible_json},
    input::{
        check::LARGEST,
        error::{Error, Result},
    },
};

/// How far a loaded machine leaves its path, which drive commands compensate that, and where to put the workpiece.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  kinetostat run studies/01_workspace_map
  kinetostat merge parts --out results/01_workspace_map
  kinetostat point --machine orthoglide --at Q1 --phi 130 --chain-errors 1,-1,1
  kinetostat compensate part.nc --machine orthoglide --process milling.toml --out part_compensated.nc
  kinetostat compare --machine orthoglide --process milling.toml --path part.nc --at Q0 --at 50,0,20
  kinetostat report results/01_workspace_map /tmp/stiffer_feet --out comparison.html
  kinetostat explore orthoglide --path part.nc --process milling.toml
  kinetostat identify my_measurements --out found
  kinetostat predict my_measurements --poses others.csv
  kinetostat design-measurements my_plan --out plan
  kinetostat export-correction --machine orthoglide --process milling.toml --out correction
  kinetostat export-realtime --machine orthoglide --out orthoglide_correction
  kinetostat check my_machine.toml
  kinetostat new map my_question

Exit codes: 0 all points solved; 1 some points could not be solved (their status says why), or a correction probably does harm; 2 bad input, or a file that cannot
be read or written; 3 an internal error, which is a fault of this program; 130 stopped (run goes on
with --resume).";

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::RunArguments),
    Merge(merge::MergeArguments),
    Identify(measuring::IdentifyArguments),
    Predict(measuring::PredictArguments),
    DesignMeasurements(measuring::DesignArguments),
    Point(point::PointArguments),
    Compensate(compensate::CompensateArguments),
    Compare(compare::CompareArguments),
    Report(report::ReportArguments),
    Explore(explore::ExploreArguments),
    ExportCorrection(export_correction::ExportCorrectionArguments),
    ExportRealtime(export_realtime::ExportRealtimeArguments),
    Machines(machines::MachinesArguments),
    Check(check::CheckArguments),
    New(new::NewArguments),
    Completions(CompletionsArguments),
}

/// Whether the command is to answer in JSON (`--json`), and to write lines of JSON on standard error (`--progress json`), as its words say
/// before they are parsed: also of wrong ones.
fn asks_for_json() -> [bool; 2] {
    let words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
    let words: Vec<String> = words.take_while(|word| word != "--").collect();
    let has_lines = words.windows(2).any(|pair| pair == ["--progress", "json"] || pair[1] == "--progress=json");
    [words.iter().any(|word| word == "--json"), has_lines]
}

/// Whether standard output has an answer in JSON.
static HAS_JSON: AtomicBool = AtomicBool::new(false);

/// Parses the words of the command line. Help ends the program, as do wrong words unless they are told in JSON.
pub fn parse() -> Result<Arguments> {
    Arguments::try_parse().or_else(|fault| match fault.use_stderr() && asks_for_json().contains(&true) {
        true => {
            let text = fault.to_string();
            Err(Error::argument("command line", text.trim().trim_start_matches("error: ")))
        }
        false => fault.exit(),
    })
}

/// Tells why a command ended without an answer: for readers, or as the JSON that was asked for.
pub fn fail(text: &str) {
    let ([is_json, has_lines], message) = (asks_for_json(), text.trim_start_matches("error: "));
    if is_json && !HAS_JSON.load(Ordering::Relaxed) {
        // The exit code reports what cannot be printed.
        let _ = print_json(&serde_json::json!({ "error": message }));
    }
    match has_lines {
        true => say_as("error", message),
        false => say(text),
    }
}

/// Begins to listen for Ctrl-C.
pub fn listen() -> Result<()> {
    if asks_for_json()[1] {
        std::panic::set_hook(Box::new(|panic| say_as("panic", &panic.to_string())));
    }
    reporting::stop_flag().map(drop)
}

/// Runs the command of the arguments, and returns how it ended.
pub fn dispatch(arguments: Arguments) -> Result<Ending> {
    reporting::stop_at_once()?;
    match arguments.command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Merge(arguments) => merge::merge(&arguments),
        Command::Identify(arguments) => measuring::identify(&arguments),
        Command::Predict(arguments) => measuring::predict(&arguments),
        Command::DesignMeasurements(arguments) => measuring::design(&arguments),
        Command::Point(arguments) => point::point(&arguments),
        Command::Compensate(arguments) => compensate::compensate(&arguments),
        Command::Compare(arguments) => compare::compare(&arguments),
        Command::Report(arguments) => report::report(&arguments),
        Command::Explore(arguments) => explore::explore(&arguments),
        Command::ExportCorrection(arguments) => export_correction::export_correction(&arguments),
        Command::ExportRealtime(arguments) => export_realtime::export_realtime(&arguments),
        Command::Machines(arguments) => machines::machines(&arguments),
        Command::Check(arguments) => check::check(&arguments),
        Command::New(arguments) => new::new(&arguments),
        Command::Completions(arguments) => completions(&arguments),
    }
}

/// Print what a shell needs to complete commands, options and their values.
#[derive(Debug, Args)]
#[command(after_help = "\
A new shell has the completions if its start reads the file: bash-completion looks into ~/.local/share/bash-completion/completions,
fish into ~/.config/fish/completions, zsh into the folders of $fpath for a file _kinetostat.

Examples:
  kinetostat completions bash > ~/.local/share/bash-completion/completions/kinetostat
  kinetostat completions fish > ~/.config/fish/completions/kinetostat.fish
  kinetostat completions zsh > ~/.zfunc/_kinetostat")]
struct CompletionsArguments {
    /// The shell
    shell: Shell,
}

/// Runs `kinetostat completions`: prints the completions for a shell.
fn completions(arguments: &CompletionsArguments) -> Result<Ending> {
    let mut script = Vec::new();
    generate(arguments.shell, &mut Arguments::command(), "kinetostat", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(Ending::Complete)
}

/// Prints `text` for reading, with control characters made visible.
fn print(text: &str) -> Result<()> {
    send(&visible(text))
}

/// Prints a JSON object, with control characters in strings escaped.
fn print_json(value: &serde_json::Value) -> Result<()> {
    HAS_JSON.store(true, Ordering::Relaxed);
    send(&visible_json(&format!("{value:#}\n")))
}

/// Prints `text` on standard error; if that fails, only the exit code reports the problem.
pub fn say(text: &str) {
    match asks_for_json() {
        [_, true] => say_as("message", text),
        _ => _ = writeln!(std::io::stderr(), "{}", visible(text)),
    }
}

/// Prints an event with a message as a line of JSON on standard error.
fn say_as(event: &str, message: &str) {
    let line = serde_json::json!({ "event": event, "message": message }).to_string();
    let _ = writeln!(std::io::stderr(), "{}", visible_json(&line));
}

/// Prints `text`, already visible; keeps its styles on a terminal unless NO_COLOR is set.
fn print_styled(text: &str) -> Result<()> {
    let choice = anstream::AutoStream::choice(&std::io::stdout());
    match choice {
        anstream::ColorChoice::Never => send(&anstream::adapter::strip_str(text).to_string()),
        _ => send(text),
    }
}

/// Writes on standard output. A reader that has gone away, such as `head`, is no error.
fn send(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => {
            Err(Error::Write { file: "standard output".into(), source })
        }
        _ => Ok(()),
    }
}

/// Parses `COUNT` comma-separated numbers.
fn numbers<const COUNT: usize>(text: &str) -> std::result::Result<[f64; COUNT], String> {
    let values = text.split(',').map(|part| {
        let value: f64 = part.trim().parse().map_err(|_| format!("\"{part}\" is not a number"))?;
        if value.abs() <= LARGEST {
            return Ok(value);
        }
        Err(format!("\"{part}\" is not between {:e} and {LARGEST:e}", -LARGEST))
    });
    let values = values.collect::<std::result::Result<Vec<_>, _>>()?;
    let found = values.len();
    values.try_into().map_err(|_| format!("expected {COUNT} numbers separated by commas, got {found}"))
}

/// Returns an error for a `--tolerance` that is not positive.
fn check_tolerance(tolerance_mm: Option<f64>) -> Result<()> {
    match tolerance_mm.filter(|tolerance| *tolerance <= 0.0) {
        Some(tolerance) => Err(Error::argument("--tolerance", format!("must be greater than 0, got {tolerance}"))),
        None => Ok(()),
    }
}

/// Parses one number.
fn number(text: &str) -> std::result::Result<f64, String> {
    numbers::<1>(text).map(|[value]| value)
}

/// Parses any number of comma-separated numbers.
fn any_numbers(text: &str) -> std::result::Result<Vec<f64>, String> {
    text.split(',').map(number).collect()
}
