//! The command line that recomputes one point of a map: `kinetostat point` with the machine, force and errors of the study.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{description::Explorer, single::group_sources};

/// A command with placeholders: `{position}`, and `{phi}` where the tool angle matters.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PointCommand {
    /// The command with placeholders.
    pub text: String,
    /// Index of the view's quantity that is the tool angle, if the command needs it.
    pub phi: Option<usize>,
}

/// Values of the inputs by part and key.
type Keys = BTreeMap<(String, String), String>;

/// Returns the command for each group of `explorer`, with the tool angle as quantity `phi`, and a note on what the commands leave out.
pub fn point_commands(explorer: &Explorer, phi: Option<usize>, keys: &Keys) -> (Vec<Option<PointCommand>>, String) {
    let commands = group_sources(explorer).iter().map(|source| point_command(source, phi, keys)).collect();
    (commands, omission_note(keys))
}

/// Returns the command for a source of error; `None` if `kinetostat point` cannot repeat it.
fn point_command(source: &str, phi: Option<usize>, keys: &Keys) -> Option<PointCommand> {
    let key = |part: &str, name: &str| keys.get(&(part.to_string(), name.to_string())).map(String::as_str);
    let mut text = format!("kinetostat point --machine {} --position {{position}}", quote(key("study", "machine")?));
    let (has_force, has_errors) = match source {
        "all" => (true, true),
        "cutting" => (true, false),
        "geometry" => (false, true),
        "weight" => (false, false),
        _ => return None,
    };
    if has_force {
        let force = ["radial_force_N", "tangential_force_N", "axial_force_N"]
            .map(|name| key("process", &format!("force.path_frame.{name}")));
        let [Some(radial), Some(tangential), Some(axial)] = force else { return None };
        phi?;
        text += &format!(" --phi {{phi}} --force {radial},{tangential},{axial}");
        text += &key("process", "force.path_frame.law").map_or_else(String::new, |law| format!(" --law {law}"));
    } else {
        text += " --wrench 0,0,0,0,0,0";
    }
    if has_errors {
        for (chain, turn) in chain_rotations(keys) {
            text += &format!(" --set {}={turn}", quote(&format!("{chain}.turn")));
        }
    }
    text += &key("study", "branch").map_or_else(String::new, |branch| format!(" --branch {branch}"));
    text += match key("process", "compensate.target") {
        Some("platform_point") => " --platform",
        Some("full_pose") => " --full-pose",
        _ => "",
    };
    Some(PointCommand { text, phi: phi.filter(|_| has_force) })
}

/// Yields each chain with its rotation error about its drive's axis, in degrees.
fn chain_rotations(keys: &Keys) -> impl Iterator<Item = (&str, &str)> {
    keys.iter().filter_map(|((part, key), value)| {
        let chain = key.strip_prefix("chain_error.")?.strip_suffix(".turn_about_drive_axis_deg")?;
        (part == "process").then_some((chain, value.as_str()))
    })
}

/// Returns a note on what the commands leave out of the process, and where to run them.
fn omission_note(keys: &Keys) -> String {
    let is_included = |key: &str| {
        ["force.path_frame.", "compensate.target"].iter().any(|prefix| key.starts_with(prefix))
            || (key.starts_with("chain_error.")
                && (key.ends_with(".turn_about_drive_axis_deg") || key.ends_with(".chain")))
            || matches!(key, "schema" | "name" | "title")
    };
    let mut omitted: Vec<&str> = Vec::new();
    for ((_, key), _) in keys.iter().filter(|((part, key), _)| part == "process" && !is_included(key)) {
        let table = key.split('.').next().unwrap_or(key);
        if !omitted.contains(&table) {
            omitted.push(table);
        }
    }
    let mut note = match omitted.join(", ") {
        none if none.is_empty() => none,
        all => format!(
            "The command leaves out of the process: {all}; where these act, its numbers differ from those above."
        ),
    };
    if keys.get(&("study".into(), "machine".into())).is_some_and(|machine| machine.ends_with(".toml")) {
        note += " Run the command in the folder of the study.";
    }
    note.trim().to_string()
}

/// Quotes a word for a shell if need be.
fn quote(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./=".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
