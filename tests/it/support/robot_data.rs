//! The measurements of Liu et al. 2026 on an R-2000iC, where they are at hand; the project does not ship them.

/// As a file of ours; `None` and a printed reason where they are not at hand.
pub fn robot_data() -> Option<String> {
    let beside = || std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("KINETOSTAT_DATA").map_or_else(beside, std::path::PathBuf::from);
    let file = folder.join("fanuc_r2000ic/poses.csv");
    let Ok(text) = std::fs::read_to_string(&file) else {
        println!("skipped: no measurements at {}; the project does not ship them", file.display());
        return None;
    };
    let (head, rows) = text.split_once('\n').unwrap();
    let mut head = head.to_string();
    for (i, axis) in (1..=6).zip(["x", "y", "z", "", "", ""]) {
        head = head.replace(&format!("j{i}_rad"), &format!("J{i}_rad"));
        if !axis.is_empty() {
            head = head.replace(&format!("f{axis}_N"), &format!("force_{axis}_N"));
            head = head.replace(&format!("d{axis}_mm"), &format!("displacement_{axis}_mm"));
        }
    }
    Some(format!("{head}\n{rows}"))
}
