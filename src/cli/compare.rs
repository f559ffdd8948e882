//! `kinetostat compare`: a path at several places, side by side.

use std::path::PathBuf;

use clap::Args;
use kinetostat::{
    input::error::{Error, Result},
    machine::Machine,
    process::{Extent, Feature, file::Process},
    report::exchange,
    study::{
        Machines, ProgramFile,
        placement::{
            Candidate, FeatureJob, PlacementStudy, compare as evaluate, place,
            report::{candidates_table, entries_table, known},
        },
    },
};

use super::{Ending, print};

/// Compare places for a workpiece: what its path costs at each.
#[derive(Debug, Args)]
#[command(after_help = "\
A place is a named point of the machine, at which P stands when the path is at its origin, or the origin of the
workpiece: x,y,z in mm, or x,y,z,yaw or x,y,z,yaw,pitch,roll with angles in degrees. Where the process file gives
placement.origin_mm, that place is compared as well.

Examples:
  kinetostat compare --machine orthoglide --process milling.toml --path part.nc --at Q0 --at 50,0,20
  kinetostat compare --machine orthoglide --process milling.toml --path path.csv --at 0,0,0 --at 0,0,0,90 --csv")]
pub struct CompareArguments {
    /// Built-in machine or machine file
    #[arg(long, short)]
    machine: String,
    /// Process file: cutting force, chain errors, limits; its place is one of those compared. [gcode] decimals are not used
    #[arg(long, short)]
    process: PathBuf,
    /// Path: a polyline (.csv) or G-code (any other name)
    #[arg(long)]
    path: PathBuf,
    /// A place; give several, or none to see that of the process file alone
    #[arg(long, allow_hyphen_values = true, value_name = "NAME|X,Y,Z[,YAW[,PITCH,ROLL]]")]
    at: Vec<String>,
    /// How far the tool may be from its path, mm, for the share within tolerance
    #[arg(long, default_value_t = 0.1, value_parser = super::number)]
    tolerance: f64,
    /// Print a CSV table with all metrics
    #[arg(long)]
    csv: bool,
}

pub fn compare(arguments: &CompareArguments) -> Result<Ending> {
    let study = study(arguments)?;
    let entries = evaluate(&study);
    if arguments.csv {
        let bytes = exchange::csv(&candidates_table(&study, &entries))
            .map_err(|e| Error::Write { file: "standard output".into(), source: std::io::Error::other(e) })?;
        print(&String::from_utf8_lossy(&bytes))?;
    } else {
        print(&entries_table(&study, &entries))?;
        print(&format!("Counts as cutting: {}.\n", study.features[0].cuts.words()))?;
        print(&known(&study))?;
    }
    let complete = entries.iter().all(|entry| entry.feasible().is_some());
    Ok(if complete { Ending::Complete } else { Ending::SomeUnsolved })
}

fn study(arguments: &CompareArguments) -> Result<PlacementStudy> {
    let machine = Machine::named_or_file(&arguments.machine)?;
    let process = Process::open(&arguments.process, &machine)?;
    let fault = |argument: String, problem: String| Err(Error::Argument { argument, problem });
    if arguments.tolerance <= 0.0 {
        return fault("--tolerance".into(), format!("must be greater than 0, got {}", arguments.tolerance));
    }
    let path = ProgramFile::read(&arguments.path, &process.gcode)?.toolpath(process.sampling)?;
    let path = process.with_cuts(path, &arguments.path.display().to_string())?;
    let Some(extent) = Extent::of(path.positions_mm().into_iter()) else {
        let problem = "moves nowhere: a program with at least one motion is expected".into();
        return fault(arguments.path.display().to_string(), problem);
    };
    let reference = process.placement.reference;
    let given = arguments.at.iter().map(|text| place(text, "--at", &machine, reference));
    let candidates: Vec<Candidate> =
        Candidate::of_process(&process).map(Ok).into_iter().chain(given).collect::<Result<_>>()?;
    if candidates.is_empty() {
        return fault("--at".into(), "expected a place, as the process file gives no placement.origin_mm".into());
    }
    let feature = Feature {
        name: arguments.path.display().to_string(),
        loads: process.cutting.loads(&path).map_err(|source| Error::Argument {
            argument: arguments.path.display().to_string(),
            problem: source.to_string(),
        })?,
        path,
        reference,
        tolerance_mm: arguments.tolerance,
    };
    let cuts = process.cutting_rule;
    let machines = Machines::new(&machine, &process.errors)?;
    let job =
        FeatureJob { feature, machines, errors: process.errors, limits: process.limits, target: process.target, cuts };
    Ok(PlacementStudy::of_places(machine, job, extent, candidates))
}
