//! `kinetostat export-correction`: writes the correction as a table that a controller reads.

use std::{path::PathBuf, time::Instant};

use clap::Args;
use kinetostat::{
    input::{Inputs, error::Result, toml_file},
    machine::catalogue,
    products::correction::{
        CorrectionQuestion,
        report::{CorrectionExport, CorrectionFormat, export},
    },
};

use super::{
    Ending, choice, headline, number, numbers, on_machine::OnMachine, reporting::Reporting, results::as_option_error,
};

/// Write corrections as a table that a controller reads, the smallest within tolerance, with its largest residual error.
#[derive(Debug, Args)]
#[command(after_help = "\
The table gives, at each node of a grid over positions of P and for each drive, its correction as a polynomial in the force on the
tool tip: one table for predicted and for measured forces. Between nodes the controller interpolates linearly along each axis.
FOLDER holds correction.csv and correction.json, joint_LABEL.comp (LinuxCNC's COMP_FILE) where each joint is an axis and such a table is
of use, and a page with maps of the residual error. Other commands' files in FOLDER are not replaced.

Examples:
  kinetostat export-correction --machine orthoglide --process milling.toml --out correction
  kinetostat export-correction --machine tripteron --process milling.toml --tolerance 0.02 --format csv,comp --out correction
  kinetostat export-correction --machine orthoglide --process milling.toml --box -50,50,-50,50,-40,40 --force-N 300 --out correction
  kinetostat export-correction --machine my_machine.toml --process milling.toml --grid 9,9,5 --out correction

Exit codes: 0 within tolerance; 1 out of tolerance, with a --grid that is too coarse.")]
pub struct ExportCorrectionArguments {
    #[command(flatten)]
    on: OnMachine,
    /// Folder for the table and its page
    #[arg(long, short)]
    out: PathBuf,
    /// How far the tool may be from where it is wanted anywhere in the box, mm
    #[arg(long, value_parser = number, default_value = "0.005", allow_hyphen_values = true)]
    tolerance: f64,
    /// Ends of the box along each axis of the base, positions of P, mm [default: the machine's workspace box]
    #[arg(long = "box", value_parser = numbers::<6>, allow_hyphen_values = true, value_name = "X0,X1,Y0,Y1,Z0,Z1")]
    corners: Option<[f64; 6]>,
    /// Largest force on the tool tip that the table is for, N [default: the largest force of the process]
    #[arg(long = "force-N", value_parser = number, allow_hyphen_values = true)]
    force: Option<f64>,
    /// Nodes along x,y,z, or one number for all, instead of the fewest that stay within tolerance
    #[arg(long, value_parser = super::run::parse_grid, allow_hyphen_values = true)]
    grid: Option<[usize; 3]>,
    /// Formats, separated by commas [default: all that are of use for the machine]
    #[arg(long, value_parser = choice::correction_format(), value_delimiter = ',')]
    format: Vec<CorrectionFormat>,
    /// Write tables and the page only
    #[arg(long)]
    no_figures: bool,
    #[command(flatten)]
    reporting: Reporting,
}

/// Runs `kinetostat export-correction`: writes the correction table and prints its largest residual error.
pub fn export_correction(arguments: &ExportCorrectionArguments) -> Result<Ending> {
    let reporting = &arguments.reporting;
    reporting.start_log()?;
    let started = Instant::now();
    let process = arguments.on.process()?.as_programmed("export-correction")?;
    let corners = arguments.corners.map(|[x0, x1, y0, y1, z0, z1]| [[x0, y0, z0].into(), [x1, y1, z1].into()]);
    let question = CorrectionQuestion::new(&process, corners, arguments.force, arguments.tolerance, arguments.grid);
    let question = question.map_err(as_option_error)?;
    let inputs = all_inputs(arguments, &question, process.inputs)?;
    let options = CorrectionExport { formats: arguments.format.clone(), figures: !arguments.no_figures, inputs };
    let progress = reporting.progress("correction", 0, "nodes");
    let exported = export(&question, &options, &arguments.out, &progress.work());
    progress.end();
    let exported = exported.map_err(as_option_error)?;
    let seconds = format!("{:.1} s", started.elapsed().as_secs_f64());
    reporting.print_styled(&headline::result_text(&exported.headline, &seconds))?;
    if reporting.is_verbose() {
        reporting.print_styled(&headline::sentences(&format!("\n{}\n", exported.details)))?;
    }
    reporting.print_written(&arguments.out, &exported.files, true)?;
    Ok(Ending::of(exported.is_within))
}

/// Returns the inputs on which the table depends: settings of the command line, machine file and process.
fn all_inputs(arguments: &ExportCorrectionArguments, question: &CorrectionQuestion, process: Inputs) -> Result<Inputs> {
    let [min, max] = question.corners;
    let mut text = format!(
        "tolerance_mm = {:?}\nforce_N = {:?}\nbox_mm = {:?}\n",
        question.tolerance_mm,
        question.largest_force_N,
        [min.x, max.x, min.y, max.y, min.z, max.z]
    );
    if let Some(counts) = question.counts {
        text += &format!("grid = {counts:?}\n");
    }
    if let Some(branch) = arguments.on.branch {
        text += &format!("branch = \"{}\"\n", branch.label());
    }
    for (drive, value) in &arguments.on.lock {
        text += &format!("locked.\"{drive}\" = {value:?}\n");
    }
    let machine = match catalogue::find(&arguments.on.machine) {
        Some(entry) => entry.toml.to_string(),
        None => toml_file::read(arguments.on.machine.as_ref())?,
    };
    Ok(Inputs::of("command line", text).and(Inputs::of(&arguments.on.machine, machine)).and(process))
}
