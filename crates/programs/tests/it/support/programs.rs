//! Programs that tests read.

/// Every file of a folder of the repository, with its name, in the order of names.
pub fn programs_in(folder: &str) -> Vec<(String, Vec<u8>)> {
    let mut programs: Vec<_> = std::fs::read_dir(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(folder))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&path).unwrap()))
        .collect();
    programs.sort();
    programs
}
