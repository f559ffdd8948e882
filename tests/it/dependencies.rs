//! packaging/made_of.md says of every package that a manifest names what it is for, and of no other.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Manifests of the program, of what it is made of in this repository, of Python and of the pages.
fn manifests() -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> =
        ["Cargo.toml", "python/Cargo.toml", "web/Cargo.toml"].map(|file| root().join(file)).into();
    let crates = fs::read_dir(root().join("crates")).into_iter().flatten();
    found.extend(crates.map(|entry| entry.unwrap().path().join("Cargo.toml")).filter(|file| file.exists()));
    found
}

/// Packages of others that a manifest names, for the program or its tests.
fn named(manifest: &Path) -> Vec<String> {
    let text = fs::read_to_string(manifest).unwrap();
    let table: toml::Table = text.parse().unwrap_or_else(|error| panic!("{}: {error}", manifest.display()));
    let of = |table: &toml::Table| {
        let groups = ["dependencies", "dev-dependencies", "build-dependencies"];
        let tables = groups.iter().filter_map(|group| table.get(*group)?.as_table());
        let entries = tables.flatten().filter(|(_, value)| value.get("path").is_none());
        let names = entries.map(|(key, value)| value.get("package").and_then(|name| name.as_str()).unwrap_or(key));
        names.map(String::from).collect::<Vec<_>>()
    };
    let targets = table.get("target").and_then(|targets| targets.as_table()).into_iter().flatten();
    let workspace = table.get("workspace").and_then(|workspace| workspace.as_table());
    let mut found = of(&table);
    found.extend(targets.filter_map(|(_, target)| target.as_table()).chain(workspace).flat_map(of));
    let own = |name: &String| name == "kinetostat" || name.starts_with("kinetostat-");
    found.into_iter().filter(|name| !own(name)).collect()
}

#[test]
fn every_package_has_a_row_and_every_row_a_package() {
    let text = fs::read_to_string(root().join("packaging/made_of.md")).unwrap();
    let (_, table) = text.split_once("\n| package | what it does for us |\n|---|---|\n").expect("a table of packages");
    let rows = table.lines().map_while(|line| line.strip_prefix("| `")?.strip_suffix(" |")?.split_once("` | "));
    let rows: Vec<(&str, &str)> = rows.collect();
    assert!(rows.is_sorted(), "rows are in the order of names");
    for (package, what) in &rows {
        assert!(what.len() > 8 && what.ends_with('.'), "{package}: \"{what}\" says nothing");
    }
    let told: BTreeSet<String> = rows.iter().map(|(package, _)| (*package).to_string()).collect();
    assert_eq!(told.len(), rows.len(), "a package has one row");
    let named: BTreeSet<String> = manifests().iter().flat_map(|file| named(file)).collect();
    assert!(named.len() > 30, "{named:?}");
    let unnamed: Vec<_> = named.difference(&told).collect();
    assert!(unnamed.is_empty(), "packaging/made_of.md does not say what these are for: {unnamed:?}");
    let gone: Vec<_> = told.difference(&named).collect();
    assert!(gone.is_empty(), "no manifest names these, of which packaging/made_of.md has a row: {gone:?}");
}
