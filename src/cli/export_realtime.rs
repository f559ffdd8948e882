//! `kinetostat export-realtime`: writes the loaded kinematics of a machine as code for its controller.

use std::path::{Path, PathBuf};

use clap::Args;
use kinetostat::{
    compensation::Target,
    files::{Foreign, PreparedFolder},
    input::{check::Check, error::Result},
    machine::Machine,
    process::file::Process,
    products::realtime::{AIM_MM, Domain, PLACES, Question, Realtime, generate, write},
    simulation::Machines,
};

use super::{Ending, number, numbers, print};

/// Write the loaded kinematics of a machine as code for its controller: a Rust package that builds a static library for C.
#[derive(Debug, Args)]
#[command(after_help = "\
The code is the program's own solver for this machine, written down operation by operation: a fixed number of Newton steps
from a start by polynomials, without allocation, loops of unknown length or panics. A search over box and forces says how
far the code is from the solver; OUT/README.md and the header state this error. Files in OUT are only replaced if
this command wrote them, or with --force.

Examples:
  kinetostat export-realtime --machine orthoglide --out orthoglide_correction
  kinetostat export-realtime --machine orthoglide --process milling.toml --out correction --force-N 300 --moment-Nmm 3000
  kinetostat export-realtime --machine delta.toml --out correction --box -200,-200,-900,200,200,-700 --steps 3
  cd correction && cargo build --release")]
pub struct ExportRealtimeArguments {
    /// Built-in machine or machine file: one whose three drives control the three translations
    #[arg(long, short)]
    machine: String,
    /// Process file: errors of the chains, tool, uncertain inputs and tolerance; nothing else of it is used
    #[arg(long, short)]
    process: Option<PathBuf>,
    /// Folder for the package
    #[arg(long, short)]
    out: PathBuf,
    /// Newton steps of each call, 1 to 8
    #[arg(long, default_value_t = 2)]
    steps: usize,
    /// Box of the tool tip in the base frame, mm [default: the machine's workspace, as the tool tip sees it]
    #[arg(long = "box", value_parser = numbers::<6>, allow_hyphen_values = true, value_name = "X,Y,Z,X,Y,Z")]
    tip_box: Option<[f64; 6]>,
    /// Largest size of each component of the force on the tool, N
    #[arg(long = "force-N", value_parser = number, default_value = "250", value_name = "N")]
    force: f64,
    /// Largest size of each component of the moment about the tool tip, N·mm
    #[arg(long = "moment-Nmm", value_parser = number, default_value = "2500", value_name = "N·mm")]
    moment: f64,
    /// Replace files in OUT that were not written by this command
    #[arg(long = "force")]
    replace: bool,
}

/// Runs `kinetostat export-realtime`: writes the generated package and prints its errors.
pub fn export_realtime(arguments: &ExportRealtimeArguments) -> Result<Ending> {
    let nominal = Machine::named_or_file(&arguments.machine)?;
    let (nominal, errors, uncertainty, tolerance_mm) = match &arguments.process {
        None => (nominal, Vec::new(), None, None),
        Some(file) => {
            let Process { machine, errors, target, uncertainty, tolerance_mm, .. } =
                Process::open(file, &nominal)?.as_programmed("export-realtime")?;
            if target == Target::PlatformPoint {
                let problem = "compensates P: expected the tool tip, which controllers are asked for";
                return Check::new(&file.display().to_string()).key("target").fail(problem.into());
            }
            let uncertainty = uncertainty.map(|table| table.of_box(&machine, &errors)).transpose()?;
            (machine, errors, uncertainty, tolerance_mm)
        }
    };
    let corners = match arguments.tip_box {
        Some([a, b, c, d, e, f]) => [[a, b, c].into(), [d, e, f].into()],
        None => Domain::workspace(&nominal),
    };
    let domain = Domain::new(corners, arguments.force, arguments.moment)?;
    let folder = &arguments.out;
    let _prepared = PreparedFolder::new(folder)?;
    let machines = Machines::new(&nominal, &errors)?;
    let (steps, places) = (arguments.steps, PLACES);
    let realtime = generate(Question { machines, errors, domain, steps, places, uncertainty, tolerance_mm })?;
    write(&realtime, folder, Foreign::forced(arguments.replace))?;
    print(&summary_text(&realtime, folder))?;
    Ok(Ending::Complete)
}

/// Returns errors and operations of each function, and what to do next.
fn summary_text(realtime: &Realtime, folder: &Path) -> String {
    let mut text = realtime.field_text().map_or_else(String::new, |words| words.join("\n") + "\n");
    for (name, code) in realtime.functions() {
        let (start, step) = code.operations();
        let errors: Vec<String> = code.errors.found_mm.iter().map(|error| format!("{error:.1e}")).collect();
        text += &format!(
            "{name}: error below {:.1e} mm (found at the start and after each step: {} mm); {start} operations for the start, {step} for each \
             step\n",
            code.errors.stated_mm(),
            errors.join(", ")
        );
    }
    if realtime.functions().iter().any(|(_, code)| code.errors.stated_mm() > AIM_MM) {
        text +=
            &format!("An error is above {AIM_MM:e} mm: more --steps, a smaller --box or smaller forces reduce it.\n");
    }
    let shown = folder.display();
    text + &format!("Written to {shown}; next: cd {shown} && cargo build --release\n")
}
