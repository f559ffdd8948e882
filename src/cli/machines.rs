//! `kinetostat machines`: the built-in machines.

use clap::Args;
use comfy_table::{Table, presets::UTF8_HORIZONTAL_ONLY};
use kinetostat::{
    input::error::{Error, Result},
    machine::{Machine, catalogue},
};

use super::{Ending, print};

/// List the built-in machines, or print the file of one as a start for your own.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat machines
  kinetostat machines --show orthoglide > my_machine.toml")]
pub struct MachinesArguments {
    /// Print the machine file of this machine
    #[arg(long, value_name = "NAME")]
    show: Option<String>,
}

pub fn machines(arguments: &MachinesArguments) -> Result<Ending> {
    if let Some(name) = &arguments.show {
        let Some(entry) = catalogue::find(name) else {
            let names = catalogue::names().collect::<Vec<_>>().join(", ");
            let problem = format!("no built-in machine \"{name}\"; there are: {names}");
            return Err(Error::Argument { argument: "--show".into(), problem });
        };
        print(entry.toml)?;
        return Ok(Ending::Complete);
    }
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY).set_header(["name", "machine", "drives", "named points"]);
    for entry in catalogue::ENTRIES {
        let machine = Machine::from_toml(entry.toml, entry.name)?;
        let points = machine.points.iter().map(|point| point.name.as_str()).collect::<Vec<_>>().join(", ");
        table.add_row([entry.name.to_string(), machine.title.clone(), machine.drive_labels().join(", "), points]);
    }
    print(&format!("{table}\n"))?;
    Ok(Ending::Complete)
}
