//! Folders of results, file by file.

use std::{collections::BTreeMap, fs, path::Path};

/// Names and bytes of the files in `folder`.
pub fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.map(|file| (file.file_name().unwrap().to_string_lossy().into(), fs::read(file).unwrap())).collect()
}

/// Holds the files of `found` against those of `expected`, byte for byte.
pub fn assert_same(found: &Path, expected: &Path, what: &str) {
    let (found, expected) = (contents(found), contents(expected));
    assert!(found.keys().eq(expected.keys()), "{what}: {:?} instead of {:?}", found.keys(), expected.keys());
    for (name, bytes) in &expected {
        assert!(found[name] == *bytes, "{what}: {name} is not the same");
    }
}
