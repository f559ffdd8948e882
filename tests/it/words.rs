//! What people read speaks the language of the field: phrases that this project once had of its own are not in it.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use crate::architecture::{files, root};

/// Phrases, as plain text in lower case, and what the field says. A phrase has its sense in it, so that words that have an ordinary one as well
/// (told, left, place, reach, lead, hold) may be used in that.
const PHRASES: [(&str, &str); 53] = [
    ("what must be told", "corrected drive commands"),
    ("must be told instead", "corrected drive commands"),
    ("to tell the drives", "corrected drive commands"),
    ("the drives be told", "corrected drive commands"),
    ("are told to the drives", "commanded"),
    ("told where to stand", "locked"),
    ("is not told", "not identifiable, not known"),
    ("what is not told", "not identifiable"),
    ("not told:", "not known"),
    ("of the unknowns are told", "identifiable"),
    ("told by the scatter", "estimated from"),
    ("what is left along", "residual along"),
    ("what is left is", "residual"),
    ("what is left where", "residual error"),
    ("of what is left", "residuals"),
    ("in what is left", "residuals"),
    ("error left", "residual error"),
    ("error_left", "residual_error"),
    ("leftover rotation", "residual rotation"),
    ("leftover_rotation", "residual_rotation"),
    ("cannot put right", "uncompensable"),
    ("puts right", "compensates"),
    ("is put right", "is compensated"),
    ("led along", "tracked"),
    ("cannot be led", "cannot be tracked continuously"),
    ("led point", "tracked point"),
    ("ways around", "alternative solution branches"),
    ("straight way ends", "continuation from home stops"),
    ("turns with position", "parasitic rotation"),
    ("turns with its position", "parasitic rotation"),
    ("drives to spare", "redundant drives"),
    ("held drive", "locked drive"),
    ("drives held", "locked drives"),
    ("shortest motion of the drives", "minimum-norm joint motion"),
    ("free turn", "rotation about the tool axis"),
    ("turn about the tool's axis", "rotation about the tool axis"),
    ("turned about the tool's axis", "rotated about the tool axis"),
    ("map of turns", "redundancy map"),
    ("given_up", "pruned"),
    ("no_band", "no_continuous_path"),
    ("hangs on", "correlates with"),
    ("hang on", "correlate with"),
    ("far off all others", "outliers"),
    ("reach at home", "characteristic length"),
    ("mm is kept", "within tolerance"),
    ("tolerance is kept", "within tolerance"),
    ("keeps the tolerance", "within tolerance"),
    ("nothing unsolved", "all points solved"),
    ("is wrong by up to", "superposition error"),
    ("departure of superposition", "superposition error"),
    ("departure_mm", "superposition_error_mm"),
    ("smallest table that keeps", "smallest table within tolerance"),
    ("corner goes over", "force blending at corners"),
];

/// Where people read: folders, and single files.
const READ: [&str; 6] = ["src", "crates", "docs", "studies", "examples", "python/kinetostat"];
const FILES: [&str; 3] = ["README.md", "packaging/README.md", "web/README.md"];
/// What of it is not of this program, or quotes others.
const NOT_OURS: [&str; 4] = ["plotly", "target", "catalogue", "tests"];

/// The lines of `text` that are read by others than its programmers: of Rust what is no comment, or is one that makes a help text.
fn is_read(file: &Path, line: &str) -> bool {
    let line = line.trim_start();
    let is_help = line.starts_with("///") && file.to_string_lossy().contains("src/cli/");
    file.extension().is_none_or(|own| own != "rs") || is_help || !line.starts_with("//")
}

#[test]
fn what_people_read_has_no_words_of_our_own() {
    let mut all: Vec<PathBuf> = FILES.map(PathBuf::from).into();
    READ.iter().for_each(|own| files(&root().join(own), &["rs", "md", "toml", "html", "js", "py"], &mut all));
    all.retain(|file| !file.iter().any(|part| NOT_OURS.iter().any(|own| part == *own)));
    assert!(all.len() > 400, "{} files", all.len());
    let mut found = String::new();
    for file in &all {
        let text = fs::read_to_string(root().join(file)).unwrap();
        let lines: Vec<&str> = text.lines().map(|line| if is_read(file, line) { line } else { "" }).collect();
        for (k, line) in lines.iter().enumerate() {
            // A sentence may go on in the next line, behind the backslash of a text or the mark of a comment.
            let next =
                lines.get(k + 1).map_or("", |next| next.trim_start().trim_start_matches(['/', '#', '!']).trim_start());
            let line = line.trim_end_matches('\\').trim_end();
            let both = format!("{line} {next}").to_lowercase();
            for (phrase, field) in PHRASES {
                if both.find(phrase).is_some_and(|at| at < line.len()) {
                    let _ = writeln!(found, "{}:{}: \"{phrase}\": {field}", file.display(), k + 1);
                }
            }
        }
    }
    assert!(found.is_empty(), "\n{found}");
}
