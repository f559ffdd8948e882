//! The engine that pages carry is the one of these sources.

use std::{fs, path::Path};

use sha2::{Digest, Sha256};

use kinetostat::page::ENGINE_SOURCES;

const OWN: [&str; 5] =
    ["web/Cargo.toml", "web/Cargo.lock", "web/package.json", "web/build.sh", "web/.cargo/config.toml"];

/// What the engine is made without: see web/sources.mjs.
fn is_apart(path: &str) -> bool {
    let in_folder = |folder: &str| path == folder || path.starts_with(&format!("{folder}/"));
    in_folder("src/report")
        || in_folder("src/cli")
        || path == "src/main.rs"
        || path == "src/cases.rs"
        || path.contains("/report/")
        || path.ends_with("/report")
        || path.ends_with("/report.rs")
        || path.contains("/template/")
        || path.ends_with("/template")
}

fn files(root: &Path, folder: &str, found: &mut Vec<String>) {
    for entry in fs::read_dir(root.join(folder)).unwrap() {
        let path = format!("{folder}/{}", entry.unwrap().file_name().to_str().unwrap());
        if is_apart(&path) {
            continue;
        }
        match root.join(&path).is_dir() {
            true => files(root, &path, found),
            false if path.ends_with(".rs") || path.ends_with(".toml") => found.push(path),
            false => {}
        }
    }
}

#[test]
fn the_engine_of_the_pages_is_made_of_these_sources() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found: Vec<String> = OWN.map(String::from).to_vec();
    for folder in ["crates", "src", "web/src", "web/clock"] {
        files(root, folder, &mut found);
    }
    found.sort();
    let mut hash = Sha256::new();
    for path in &found {
        let text = fs::read_to_string(root.join(path)).unwrap();
        let is_code = |line: &&str| {
            !line.is_empty() && !line.starts_with("//") && !line.starts_with("#!") && !line.starts_with("# ")
        };
        let (own, tests) = text.split_once("\n#[cfg(test)]\nmod tests {").unwrap_or((&text, ""));
        assert!(
            tests.lines().all(|line| line.is_empty() || line.starts_with([' ', '}'])),
            "{path}: code behind its tests"
        );
        let code: Vec<&str> = own.split('\n').map(str::trim).filter(is_code).collect();
        hash.update(format!("{path}\n{}\n", code.join("\n")));
    }
    let hash: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(
        ENGINE_SOURCES.trim(),
        hash,
        "src/page/assets/engine.wasm.br is made of other sources: web/build.sh makes it anew"
    );
}
