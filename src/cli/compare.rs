//! `kinetostat compare`: compares a path at several places, or several results, side by side.

use std::path::{Path, PathBuf};

use clap::Args;
use kinetostat::{
    files::exchange,
    input::error::{Error, Result},
    machine::Machine,
    process::{
        Extent, Feature, ForceText, KnownForce,
        file::{Process, TOLERANCE_MM},
    },
    questions::placement::{
        Candidate, FeatureJob, PlacementStudy, compare as evaluate, parse_place,
        report::{candidates_table, cautions_text, entries_table, force_text, known_force},
    },
    simulation::{TrackedPath, clearance::MachineCell, with_drives_left},
    toolpath::Toolpath,
};

use super::{
    Ending, print,
    report::{ReportArguments, report},
};

/// Compare places for a workpiece: what its path costs at each. Or compare results: which is better where.
#[derive(Debug, Args)]
#[command(after_help = "\
A place is a named point of the machine, at which P stands when the path is at its origin, or the origin of the
workpiece: x,y,z in mm, or x,y,z,yaw or x,y,z,yaw,pitch,roll with angles in degrees. Where the process file gives
placement.origin_mm, that place is compared as well.

Of result folders, a page is written that compares them, as by `kinetostat report`.

Examples:
  kinetostat compare --machine orthoglide --process milling.toml --path part.nc --at Q0 --at 50,0,20
  kinetostat compare --machine orthoglide --process milling.toml --path path.csv --at 0,0,0 --at 0,0,0,90 --csv
  kinetostat compare results/before results/after --tolerance 0.05 --out before_and_after.html")]
pub struct CompareArguments {
    /// Result folders of one question instead of places; the first is what the others are held against
    #[arg(num_args = 2.., conflicts_with_all = ["machine", "process", "path", "at", "csv"])]
    results: Vec<PathBuf>,
    /// Page to write for result folders [default: comparison.html here]
    #[arg(long, requires = "results", conflicts_with = "machine")]
    out: Option<PathBuf>,
    /// Replace that page even if it was not written by kinetostat
    #[arg(long, requires = "results", conflicts_with = "machine")]
    force: bool,
    /// Built-in machine or machine file
    #[arg(long, short, required_unless_present = "results")]
    machine: Option<String>,
    /// Process file: cutting force, chain errors, limits; its place is one of those compared. [gcode] decimals are not used
    #[arg(long, short, required_unless_present = "results")]
    process: Option<PathBuf>,
    /// Path: a polyline (.csv), KRL (.src), RAPID (.mod, .prg), FANUC (.ls), URScript (.script), APT (.apt, .cl, .cls, .ncl) or G-code (any other name)
    #[arg(long, required_unless_present = "results")]
    path: Option<PathBuf>,
    /// A place; give several, or none to see that of the process file alone
    #[arg(long, allow_hyphen_values = true, value_name = "NAME|X,Y,Z[,YAW[,PITCH,ROLL]]")]
    at: Vec<String>,
    /// How far the tool may be from its path, mm, for the share within tolerance; of results, from which difference on one
    /// matters [default: that of the process, or 0.1; of results, what their studies say]
    #[arg(long, value_parser = super::number)]
    tolerance: Option<f64>,
    /// Print a CSV table with all metrics
    #[arg(long)]
    csv: bool,
}

/// Runs `kinetostat compare`: prints what a path costs at each place, or writes the page that compares results.
pub fn compare(arguments: &CompareArguments) -> Result<Ending> {
    let (Some(machine), Some(process), Some(path)) = (&arguments.machine, &arguments.process, &arguments.path) else {
        let CompareArguments { results, out, force, tolerance, .. } = arguments;
        let (results, out) = (results.clone(), out.clone());
        return report(&ReportArguments { results, out, force: *force, tolerance: *tolerance });
    };
    let study = placement_study(arguments, machine, process, path)?;
    let entries = evaluate(&study);
    if arguments.csv {
        let bytes = exchange::csv(&candidates_table(&study, &entries))
            .map_err(|e| Error::Write { file: "standard output".into(), source: std::io::Error::other(e) })?;
        print(&String::from_utf8_lossy(&bytes))?;
    } else {
        // Before numbers that lack it.
        print(&force_text(&study, |own| &own.unknown))?;
        print(&entries_table(&study, &entries))?;
        print(&format!("Counts as cutting: {}.\n", study.features[0].cuts.text()))?;
        print(&force_text(&study, |own| &own.of_turn))?;
        print(&cautions_text(&study))?;
    }
    let knows_force = known_force(&study) != KnownForce::Nowhere;
    Ok(Ending::of(knows_force && entries.iter().all(|entry| entry.feasible().is_some())))
}

/// Returns an error that names `file` if its program commands rotary drives: it can only stand where its process places it.
pub(super) fn check_placeable(file: &Path, process: &Process, toolpath: &Toolpath) -> Result<()> {
    if !process.gcode.commands_rotary_drives(toolpath) {
        return Ok(());
    }
    let problem = "commands rotary drives, whose axes lie elsewhere in the program at each place: expected the place of the process \
                   alone, as in compensate, run or compare without --at";
    Err(Error::argument(file.display().to_string(), problem))
}

/// Returns the error of a program without motions.
pub(super) fn no_motion_error(file: &Path) -> Error {
    Error::argument(file.display().to_string(), "moves nowhere: a program with at least one motion is expected")
}

/// Returns the study that compares the path in `file` at the requested places.
fn placement_study(arguments: &CompareArguments, machine: &str, process: &Path, file: &Path) -> Result<PlacementStudy> {
    let machine = Machine::named_or_file(machine)?;
    let process = Process::open(process, &machine)?
        .exact_for("a comparison of places")?
        .as_programmed("a comparison of places")?;
    let tolerance_mm = arguments.tolerance.or(process.tolerance_mm).unwrap_or(TOLERANCE_MM);
    super::check_tolerance(Some(tolerance_mm))?;
    let program = process.read_program(file)?;
    let path = program.toolpath(process.sampling)?;
    let name = file.display().to_string();
    let path = process.mark_cutting(path, &name)?;
    if !arguments.at.is_empty() {
        process.stock.iter().try_for_each(|stock| stock.check_movable(&process.machine, &process.placement))?;
        check_placeable(file, &process, &path)?;
    }
    let Some(extent) = Extent::around(path.positions_mm().into_iter()) else { return Err(no_motion_error(file)) };
    let process = with_drives_left(process, &path, Some(&program), &name)?;
    let machine = process.machine.clone();
    if process.redundancy.is_sought() {
        let problem = "is sought by the process: here the tool stands as programmed; a placement study seeks the rotation at each place";
        return Err(Error::argument("redundancy", problem));
    }
    let reference = process.placement.reference;
    let named = arguments.at.iter().map(|text| parse_place(text, "--at", &machine, reference));
    let candidates = Candidate::from_process(&process).map(Ok).into_iter().chain(named).collect::<Result<Vec<_>>>()?;
    if candidates.is_empty() {
        return Err(Error::argument("--at", "expected a place, as the process file gives no placement.origin_mm"));
    }
    let loads = process.loads(&path).map_err(|source| Error::argument(&name, source.to_string()))?;
    let force_text = ForceText::of(&process, &path, &|segment| program.line_name(segment));
    let tracked = TrackedPath { tolerance_mm: Some(tolerance_mm), ..TrackedPath::of(&process) };
    let bodies = MachineCell::of(&tracked.machine, process.cell.as_ref())?;
    let job = FeatureJob {
        bodies,
        feature: Feature { name, loads, path, reference, tolerance_mm },
        machines: tracked.machines()?,
        tracked,
        limits: process.limits,
        target: process.target,
        cuts: process.cutting_rule,
        force_text,
        verdict: process.verdict,
        worst: None,
        components: None,
        gamma_search: None,
    };
    Ok(PlacementStudy::for_candidates(machine, job, extent, candidates))
}
