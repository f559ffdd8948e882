//! Makes machine files from URDFs: the chain from the base to the link that carries the tool, with its limits, masses
//! and bodies.
//!
//! What a URDF cannot say, the stiffness of the drives, is written as "unknown" unless it is given. Nothing is dropped without a note.

mod bodies;
mod chain;
mod home;
mod masses;
mod read;
mod source;
mod stiffness;
mod tree;
mod workspace;
mod write;

use std::path::Path;

use nalgebra::Vector3;

pub use stiffness::DriveStiffness;

use crate::{
    input::{error::Result, file},
    machine::{Geometry, WorkspaceBox},
    spatial::Pose,
};
use chain::Element;
use read::Robot;
use source::{Source, identifier, note_names, quoted};
use tree::Tree;
use write::MachineFile;

/// What a URDF does not say: tool, tip link and stiffness of the drives.
#[derive(Debug, Clone, Default)]
pub struct ImportOptions {
    /// Tool tip in the frame of the link that carries the tool, mm.
    pub tool_tip: [f64; 3],
    /// Roll, pitch, yaw of the tool frame in the tip link, degrees; its z axis is the tool's direction.
    pub tool_angles: Option<[f64; 3]>,
    /// The link that carries the tool; not needed where there is only one at the end of the robot.
    pub tip: Option<String>,
    /// Stiffness of the drives.
    pub stiffness: DriveStiffness,
}

/// A machine file made from a URDF.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImportedMachine {
    /// The text of the machine file.
    pub toml: String,
    /// What was not used or was assumed, a sentence each; also comments at the top of the file.
    pub notes: Vec<String>,
}

/// A longer file is no robot, bytes.
const MAX_LENGTH: u64 = 16 << 20;

/// Makes a machine file from the URDF `file`; fails like [`import`], or if the file cannot be read or is no text.
pub fn import_file(file: &Path, options: &ImportOptions) -> Result<ImportedMachine> {
    let bytes = file::read_at_most(file, MAX_LENGTH)?;
    let shown = file.display().to_string();
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            let is_utf_16 = matches!(error.as_bytes(), [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..]);
            let hint = if is_utf_16 { "; it is UTF-16: iconv -f UTF-16 -t UTF-8 makes one of it" } else { "" };
            let problem = format!("is no UTF-8 text, expected a URDF{hint}");
            return Source { origin: &shown, text: "" }.fail_whole_file(problem);
        }
    };
    import(&text, &shown, options)
}

/// Makes a machine file from the text of a URDF; `origin` names it in errors and in the machine file. Fails if it is no URDF, or no machine
/// can be made from it.
pub fn import(text: &str, origin: &str, options: &ImportOptions) -> Result<ImportedMachine> {
    let source = Source { origin, text };
    let robot = read::robot(&source)?;
    let tree = Tree::build(&robot, &source)?;
    let tip = tree.tip(options.tip.as_deref(), &robot, &source)?;
    let joints_to_tip = tree.joints_to(tip);
    let reach = chain::reach_bound(&robot, &joints_to_tip);
    let mut notes: Vec<String> = Vec::new();
    note_ends(&robot, &tree, tip, &mut notes);
    let masses = masses::plausible_masses(&robot, &tree, reach, &mut notes);
    let (elements, bodies) = chain::chain_elements(&robot, &tree, &joints_to_tip, &masses, &source, &mut notes)?;
    note_weight(&elements, &mut notes);
    note_unread(&robot, &mut notes);
    let drives: Vec<_> = home::drives(&elements).collect();
    let stiffness = options.stiffness.for_drives(&drives)?;
    if stiffness.contains(&None) {
        let names = drives.iter().map(|drive| drive.name.as_str());
        note_names(
            &mut notes,
            "stiffness unknown, to be written below or given with --stiffness or --like, of drives",
            names,
        );
    }
    let name = if robot.name.is_empty() { "robot".into() } else { identifier(&robot.name) };
    let reach_mm = (1000.0 * reach).max(1.0);
    let home = home::choose_home(&elements, reach_mm);
    let (tool_axis, tool_axis_from) = tool_axis(options);
    notes.insert(0, tool_at_home(&(home.pose.rotation * tool_axis)));
    let file = MachineFile {
        title: format!(
            "{name}, {} drives to {}, imported from a URDF",
            drives.len(),
            identifier(&robot.links[tip].name)
        ),
        name,
        source: format!("{}; {}", file_name(origin), options.stiffness.text()),
        assumed: assumptions(options),
        notes,
        tip: quoted(&robot.links[tip].name),
        tool_tip: options.tool_tip,
        tool_axis,
        tool_axis_from,
        controls: vec!["x"],
        workspace: WorkspaceBox { min: home.pose.translation, max: home.pose.translation },
        home,
        stiffness,
        elements,
        bodies,
    };
    complete_file(file, origin, reach_mm)
}

/// Completes the file by its own kinematics: coordinates that the drives control, a reachable workspace box (mm), bodies that overlap.
fn complete_file(mut file: MachineFile, origin: &str, reach_mm: f64) -> Result<ImportedMachine> {
    let model = Geometry::from_toml(&file.text(), origin)?;
    let model = model.kinematics();
    file.controls = model.controllable_axes(&model.home).into_iter().map(|coordinate| coordinate.name()).collect();
    let controlled = Geometry::from_toml(&file.text(), origin)?;
    file.workspace = workspace::box_about_home(controlled.kinematics(), reach_mm);
    let mut notes = file.notes.clone();
    let touching = bodies::overlapping(controlled.kinematics()).join(", ");
    if !touching.is_empty() {
        file.bodies[0] += &format!("may_touch = [{touching}]\n");
        notes.push(format!("may_touch: bodies that overlap at home and are not held against each other: {touching}"));
    }
    if file.workspace.min == file.workspace.max {
        notes.push("workspace: no box about home was found that is reached, set one".into());
    }
    let first = format!("Made from {} by `kinetostat machines --import`.", quoted(&file_name(origin)));
    file.notes = std::iter::once(first).chain(notes.iter().cloned()).collect();
    let toml = file.text();
    Geometry::from_toml(&toml, origin)?;
    Ok(ImportedMachine { toml, notes })
}

/// Returns the last part of a path.
fn file_name(origin: &str) -> String {
    Path::new(origin).file_name().map_or_else(|| origin.into(), |name| name.to_string_lossy().into_owned())
}

/// Returns the direction of the tool in axes of the tip link, and a sentence that says how it was found.
fn tool_axis(options: &ImportOptions) -> (Vector3<f64>, &'static str) {
    let tip = Vector3::from(options.tool_tip);
    match options.tool_angles {
        Some(angles) => {
            let turned = Pose::from_roll_pitch_yaw(Vector3::from(angles).map(f64::to_radians));
            let axis = turned.rotation.column(2).map(|v| if v.abs() < NO_COMPONENT { 0.0 } else { v });
            (axis, "From the spindle to the tip: z of the link turned by the angles given at the import.")
        }
        None if tip == Vector3::zeros() => {
            (Vector3::z(), "From the spindle to the tip: assumed, z of the link; set your own.")
        }
        None => {
            let mut axis = Vector3::zeros();
            axis[tip.iamax()] = tip[tip.iamax()].signum();
            (
                axis,
                "From the spindle to the tip: assumed, the axis of the link nearest to the direction of the tip; set your own.",
            )
        }
    }
}

/// Says how the tool points at home, where it has the direction `axis` of O.
fn tool_at_home(axis: &Vector3<f64>) -> String {
    let [x, y, z]: [f64; 3] = axis.map(|v| (v * 1e3).round() / 1e3 + 0.0).into();
    let from_down = libm::acos((-axis.z).clamp(-1.0, 1.0)).to_degrees();
    let text = match from_down < 0.5 {
        true => "down".to_owned(),
        false => format!(
            "{from_down:.0} degrees from straight down: programs that do not say how the tool stands, as three-axis G-code, are cut with the \
             tool as it points at home, so set [home] and home_deg of the drives to how yours points where it cuts"
        ),
    };
    format!("tool: at home it points along ({x}, {y}, {z}) of O from the spindle to the tip, {text}")
}

/// A smaller component of a direction is rounding.
const NO_COMPONENT: f64 = 1e-15;

/// Returns what in the machine file was assumed, and on what grounds.
fn assumptions(options: &ImportOptions) -> Vec<(&'static str, String)> {
    let mut assumed = vec![("home and workspace box", "chosen at the import of the URDF: well within reach".into())];
    if options.tool_angles.is_none() {
        assumed.push(("direction of the tool", "chosen at the import of the URDF: an axis of the tip's link".into()));
    }
    if let DriveStiffness::Like(machine) = &options.stiffness {
        assumed.push(("stiffness of the drives", format!("as that of {}", machine.name)));
    }
    assumed
}

/// Notes the links at which the chain begins and ends; `tip` is an index.
fn note_ends(robot: &Robot, tree: &Tree, tip: usize, notes: &mut Vec<String>) {
    let name = |link: usize| quoted(&robot.links[link].name);
    notes.push(format!("chain: from link {}, whose frame is O, to link {}", name(tree.root), name(tip)));
}

/// Notes the total weight of the links used, and that spindle and tool are not in it.
fn note_weight(elements: &[Element], notes: &mut Vec<String>) {
    let masses =
        elements.iter().filter_map(|element| if let Element::Mass { kg, .. } = element { Some(kg) } else { None });
    let total: f64 = masses.sum();
    if total > 0.0 {
        notes.push(format!(
            "weight: {total:.3} kg of links, along -z of O (gravity_m_per_s2 says otherwise); that of spindle and tool is \
             platform.mass"
        ));
    }
}

/// Notes the kinds of elements that were not read, as machine files have no place for them.
fn note_unread(robot: &Robot, notes: &mut Vec<String>) {
    let kinds =
        robot.unread.iter().map(|(kind, count)| format!("{count} <{}>", kind.escape_debug())).collect::<Vec<_>>();
    if !kinds.is_empty() {
        notes.push(format!("not read, as machine files have no place for it: {}", kinds.join(", ")));
    }
}
