//! Writes the machine file of an imported chain, with notes at its top.

use std::fmt::Write as _;

use nalgebra::Vector3;

use super::{
    chain::{Drive, Element},
    home::Home,
};
use crate::machine::{Motion, WorkspaceBox};

/// The contents of the machine file to write.
#[derive(Debug)]
pub(super) struct MachineFile {
    pub name: String,
    pub title: String,
    pub source: String,
    /// What was assumed: which numbers, and why these.
    pub assumed: Vec<(&'static str, String)>,
    /// Notes at the top of the file, a sentence each.
    pub notes: Vec<String>,
    /// Name of the tip link.
    pub tip: String,
    pub tool_tip: [f64; 3],
    pub tool_axis: Vector3<f64>,
    /// How the tool's axis was found.
    pub tool_axis_from: &'static str,
    pub controls: Vec<&'static str>,
    pub home: Home,
    pub workspace: WorkspaceBox,
    pub elements: Vec<Element>,
    /// Stiffness of each drive in N/mm or N·mm/rad, `None` if it is unknown.
    pub stiffness: Vec<Option<f64>>,
    /// Keys of the bodies in O, with those that may touch, and in P.
    pub bodies: [String; 2],
}

/// Longest line of a comment.
const WIDTH: usize = 120;

impl MachineFile {
    /// Returns the text of the machine file.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for note in &self.notes {
            text += &comment_lines(note);
        }
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let controls = self.controls.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
        let provenance: String = self
            .assumed
            .iter()
            .map(|(what, source)| {
                let (what, source) = (quoted(what), quoted(source));
                format!("[[provenance]]\nwhat = {what}\ngrade = \"assumed\"\nsource = {source}\n\n")
            })
            .collect();
        let _ = write!(
            text,
            "schema = 1\nname = {}\ntitle = {}\nsource = {}\n{}\n{provenance}\
             [platform]\n# P is the origin of link {}.\ntool_tip_mm = {}\n# {}\ntool_axis = {}\ncontrols = [{controls}]\n{}\n\
             [home]\n# Of {} postures tried, one in which the drives move P evenly in all directions; set your own.\nposition_mm = {}\n\
             rotation_deg = {}\n\n\
             [workspace]\n# A box about home that is reached with the platform as at home; set your own.\nmin_mm = {}\n\
             max_mm = {}\n\n\
             [[chain]]\nname = \"arm\"\nelements = [\n",
            quoted(&self.name),
            quoted(&self.title),
            quoted(&self.source),
            self.bodies[0],
            self.tip,
            vector_text(self.tool_tip),
            self.tool_axis_from,
            vector_text(self.tool_axis.into()),
            self.bodies[1],
            self.home.chosen_from,
            vector_text(self.home.pose.translation.into()),
            vector_text(self.home.pose.roll_pitch_yaw_deg()),
            vector_text(self.workspace.min.into()),
            vector_text(self.workspace.max.into()),
        );
        let mut drives = self.stiffness.iter().zip(&self.home.drives);
        for element in &self.elements {
            text += &element_line(element, || drives.next().unwrap_or((&None, &0.0)));
        }
        text + "]\n\n[[mount]]\nname = \"robot\"\nchain = \"arm\"\n"
    }
}

/// Formats a vector as TOML.
fn vector_text(components: [f64; 3]) -> String {
    format!("[{}]", components.map(|v| format!("{:?}", v + 0.0)).join(", "))
}

/// Formats an element as a line of the chain's list; `next` yields stiffness and home of the next drive.
fn element_line<'a>(element: &Element, next: impl FnOnce() -> (&'a Option<f64>, &'a f64)) -> String {
    match element {
        Element::Comment(text) => format!("  # {text}\n"),
        Element::Fixed { translation_mm, rotation_deg } => {
            let mut parts = Vec::new();
            if *translation_mm != [0.0; 3] {
                parts.push(format!("translation_mm = {}", vector_text(*translation_mm)));
            }
            if *rotation_deg != [0.0; 3] {
                parts.push(format!("rotation_deg = {}", vector_text(*rotation_deg)));
            }
            format!("  {{ fixed = {{ {} }} }},\n", parts.join(", "))
        }
        Element::Mass { kg, at_mm } => format!("  {{ mass = {{ kg = {kg:?}, at_mm = {} }} }},\n", vector_text(*at_mm)),
        Element::Drive(drive) => {
            let (stiffness, home) = next();
            drive_line(drive, *stiffness, *home)
        }
        Element::Body(body) => format!("  {{ body = {body} }},\n"),
    }
}

/// Formats a drive as a line of the chain's list; stiffness in N/mm or N·mm/rad (`None`: "unknown"), home in mm or degrees.
fn drive_line(drive: &Drive, stiffness: Option<f64>, home: f64) -> String {
    let (kind, stiffness_key, unit, limit_key) = match drive.motion {
        Motion::Prismatic => ("prismatic_drive", "stiffness_N_per_mm", "mm", "force_limit_N"),
        Motion::Revolute => ("revolute_drive", "stiffness_Nmm_per_rad", "deg", "torque_limit_Nmm"),
    };
    let axis = ["x", "y", "z"][drive.axis.index()];
    let stiffness = stiffness.map_or_else(|| "\"unknown\"".into(), |stiffness| format!("{stiffness:?}"));
    let mut parts =
        format!("name = \"{}\", axis = \"{axis}\", {stiffness_key} = {stiffness}, home_{unit} = {home:?}", drive.name);
    if let Some([low, high]) = drive.travel {
        parts += &format!(", travel_{unit} = [{low:?}, {high:?}]");
    }
    if let Some(limit) = drive.force_limit {
        parts += &format!(", {limit_key} = {limit:?}");
    }
    format!("  {{ {kind} = {{ {parts} }} }},\n")
}

/// Wraps a sentence into comment lines.
fn comment_lines(note: &str) -> String {
    let mut lines = vec!["#".to_string()];
    for word in note.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < WIDTH => *line += &format!(" {word}"),
            _ => lines.push(format!("#   {word}")),
        }
    }
    lines.join("\n") + "\n"
}
