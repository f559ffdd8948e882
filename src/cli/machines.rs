//! `kinetostat machines`: the built-in machines, the numbers of a machine, machine files to begin with, and their schema.

use std::path::{Path, PathBuf};

use clap::{
    ArgGroup, Args,
    builder::{PossibleValuesParser, TypedValueParser},
};
use comfy_table::{CellAlignment, ContentArrangement};
use kinetostat::{
    files::{OutputFile, OutputLock, prepare_beside, text_table::text_table, write_beside},
    input::error::{Error, Result},
    machine::{Geometry, Grade, Machine, Parameter, catalogue, file_schema},
    urdf::{DriveStiffness, ImportOptions, import_file},
};
use serde_json::json;

use super::{Ending, any_numbers, numbers, print, print_json, say};

/// List the built-in machines, print the file of one as a start for your own, write a new one, or make one from a URDF.
#[derive(Debug, Args)]
#[command(after_help = "\
A URDF gives geometry, travel, largest torques, bodies and, where they are plausible, masses. The machine file goes to standard
output or to --out; what was not used and what was assumed is said on standard error and in comments at the top of the file.
Stiffness, which a URDF cannot say, is written as \"unknown\": `check` shows such a machine's geometry, everything else needs numbers.

Examples:
  kinetostat machines
  kinetostat machines --show orthoglide > my_machine.toml
  kinetostat machines --new serial --out my_robot.toml
  kinetostat machines orthoglide
  kinetostat machines --schema > machine.schema.json
  kinetostat machines --import robot.urdf --tool 0,0,250 --tip tool0 --out my_robot.toml
  kinetostat machines --import robot.urdf --tool 0,0,250,0,90,0 --stiffness 3.8e6,6.6e6,3.9e6,5.6e5,6.6e5,4.7e5
  kinetostat machines --import robot.urdf --tool 0,0,250 --like my_machine.toml")]
#[command(group(ArgGroup::new("written").args(["new", "import"]).multiple(true)))]
#[command(group(ArgGroup::new("what").args(["name", "show", "new", "schema", "import"])))]
pub struct MachinesArguments {
    /// Machine whose parameters are listed by name, with unit and grade: built in, or a file
    name: Option<String>,
    /// List its parameters, as NAME alone does
    #[arg(long, requires = "name")]
    parameters: bool,
    /// Print them as JSON
    #[arg(long, requires = "name")]
    json: bool,
    /// Print the machine file of this machine
    #[arg(long, value_name = "NAME")]
    show: Option<String>,
    /// Write a commented machine file to begin with, of this kind
    #[arg(long, value_name = "KIND", value_parser = template_kinds())]
    new: Option<&'static str>,
    /// Print the JSON Schema of machine files, for editors
    #[arg(long)]
    schema: bool,
    /// Make a machine file from this URDF
    #[arg(long, value_name = "URDF", requires = "tool")]
    import: Option<PathBuf>,
    /// Tool tip in the frame of the link that carries the tool, mm, and roll, pitch, yaw in degrees that turn the link's z axis
    /// to the direction from the spindle to the tip; without angles the axis of the link nearest to the tip
    #[arg(long, value_parser = parse_tool, allow_hyphen_values = true, value_name = "X,Y,Z[,R,P,Y]", requires = "import")]
    tool: Option<Tool>,
    /// The link that carries the tool; needed where the robot has several tips
    #[arg(long, value_name = "LINK", requires = "import")]
    tip: Option<String>,
    /// Stiffness of the drives from this machine, built in or a file, which has the same kinds of drives
    #[arg(long, value_name = "MACHINE", requires = "import", conflicts_with = "stiffness")]
    like: Option<String>,
    /// Stiffness of each drive from base to tip: N·m/rad of revolute joints, N/mm of prismatic joints
    #[arg(long, value_parser = any_numbers, value_name = "K1,K2,…", requires = "import")]
    stiffness: Option<std::vec::Vec<f64>>,
    /// Write the machine file here, where nothing may be, instead of to standard output
    #[arg(long, value_name = "FILE", requires = "written")]
    out: Option<PathBuf>,
}

/// Tool tip, mm, and roll, pitch and yaw of the tool, degrees.
type Tool = ([f64; 3], Option<[f64; 3]>);

/// Parses `--tool`: three or six numbers.
fn parse_tool(text: &str) -> std::result::Result<Tool, String> {
    if text.split(',').count() == 3 {
        return numbers::<3>(text).map(|tip| (tip, None));
    }
    let [x, y, z, roll, pitch, yaw] = numbers::<6>(text).map_err(|problem| format!("{problem} (or 3)"))?;
    Ok(([x, y, z], Some([roll, pitch, yaw])))
}

/// Runs `kinetostat machines`: lists, shows, starts or imports machine files, as the arguments say.
pub fn machines(arguments: &MachinesArguments) -> Result<Ending> {
    match arguments {
        MachinesArguments { name: Some(name), json, .. } => list_parameters(name, *json)?,
        MachinesArguments { show: Some(name), .. } => show_file(name)?,
        MachinesArguments { new: Some(kind), .. } => print_or_write(template(kind).1, arguments.out.as_deref())?,
        MachinesArguments { schema: true, .. } => print_json(file_schema().as_value())?,
        MachinesArguments { import: Some(urdf), .. } => import_urdf(urdf, arguments)?,
        _ => list_machines()?,
    }
    Ok(Ending::Complete)
}

/// Prints the file of a built-in machine.
fn show_file(name: &str) -> Result<()> {
    let Some(entry) = catalogue::find(name) else {
        let names = catalogue::names().collect::<Vec<_>>().join(", ");
        let problem = format!("no built-in machine \"{name}\"; there are: {names}");
        return Err(Error::argument("--show", problem));
    };
    print(&entry.toml.replacen(SCHEMA_HERE, SCHEMA, 1))
}

/// First line of built-in machine files, which says where their schema is.
const SCHEMA_HERE: &str = "#:schema ../../../docs/machine.schema.json";

/// Prints a table of the built-in machines.
fn list_machines() -> Result<()> {
    let mut table = text_table(["name", "machine", "drives", "named points"], 4);
    table.set_content_arrangement(ContentArrangement::Dynamic).set_width(textwrap::termwidth() as u16);
    for entry in catalogue::ENTRIES {
        let machine = Machine::from_toml(entry.toml, entry.name)?;
        let points = machine.points.iter().map(|point| point.name.as_str()).collect::<Vec<_>>().join(", ");
        table.add_row([entry.name.to_string(), machine.title.clone(), machine.drive_count().to_string(), points]);
    }
    print(&format!("{table}\n"))
}

/// Makes a machine file from a URDF, and prints or writes it.
fn import_urdf(urdf: &Path, arguments: &MachinesArguments) -> Result<()> {
    arguments.out.as_deref().map(new_file).transpose().map(drop)?;
    let stiffness = match (&arguments.like, &arguments.stiffness) {
        (Some(name), _) => DriveStiffness::Like(Machine::named_or_file(name)?),
        (None, Some(values)) => DriveStiffness::Given(values.clone()),
        (None, None) => DriveStiffness::Unknown,
    };
    let (tool_tip, tool_angles) = arguments.tool.unwrap_or_default();
    let imported = import_file(urdf, &ImportOptions { tool_tip, tool_angles, tip: arguments.tip.clone(), stiffness })?;
    for note in &imported.notes {
        say(&format!("note: {note}"));
    }
    print_or_write(&imported.toml, arguments.out.as_deref())
}

/// Prints a machine file, or writes it to `out`, where nothing may be yet.
fn print_or_write(toml: &str, out: Option<&Path>) -> Result<()> {
    let Some(file) = out else { return print(toml) };
    let (name, _lock) = new_file(file)?;
    write_beside(file, vec![OutputFile::new(name, toml)])?;
    let shown = file.display();
    print(&format!("Written to {shown}. Next:\n  kinetostat check {shown}\n"))
}

/// Returns the name of `file` and its lock if it does not exist yet and can be written.
pub(super) fn new_file(file: &Path) -> Result<(&str, OutputLock)> {
    if file.symlink_metadata().is_ok() {
        let problem =
            format!("{} exists already and was left as it is: expected the name of a new file", file.display());
        return Err(Error::argument("--out", problem));
    }
    prepare_beside(file)
}

/// Prints the parameters of the machine called `name`, or of this file.
fn list_parameters(name: &str, as_json: bool) -> Result<()> {
    let geometry = Geometry::named_or_file(name)?;
    let parameters = geometry.parameters();
    if as_json {
        return print_json(&json!({ "machine": geometry.kinematics().name, "parameters": parameters }));
    }
    let has_intervals = parameters.iter().any(|parameter| parameter.interval.is_some());
    let columns = if has_intervals { 5 } else { 4 };
    let mut table = text_table(["name", "value", "unit", "grade", "95 % interval"].into_iter().take(columns), columns);
    if let Some(column) = table.column_mut(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    for Parameter { name, value, unit, grade, interval, .. } in parameters {
        let value = value.map_or_else(|| "unknown".into(), |value| format!("{value:?}"));
        let grade = grade.map_or("", Grade::label);
        let interval = interval.map_or(String::new(), |[low, high]| format!("{low:?} to {high:?}"));
        table.add_row([name, value, unit.to_string(), grade.into(), interval].into_iter().take(columns));
    }
    print(&format!("{table}\n"))
}

/// Line that tells editors where the schema of a machine file is.
const SCHEMA: &str = "#:schema machine.schema.json";

/// Kinds of machines, each with a file to start from.
const TEMPLATES: [(&str, &str); 2] =
    [("serial", include_str!("templates/serial.toml")), ("parallel", include_str!("templates/parallel.toml"))];

/// Returns the parser of `--new`.
fn template_kinds() -> impl TypedValueParser<Value = &'static str> {
    let kinds = TEMPLATES.map(|(kind, _)| kind);
    PossibleValuesParser::new(kinds).map(|kind| template(&kind).0)
}

/// Returns a kind of machine and its file.
fn template(kind: &str) -> (&'static str, &'static str) {
    TEMPLATES.into_iter().find(|(name, _)| *name == kind).unwrap_or(TEMPLATES[0])
}
