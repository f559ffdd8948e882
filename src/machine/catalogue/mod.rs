//! Built-in machines, one TOML file each. To add one: put its file here and its line in [`ENTRIES`].

/// A built-in machine.
#[derive(Debug)]
pub struct Entry {
    /// Name by which commands and studies call it.
    pub name: &'static str,
    /// Its machine file.
    pub toml: &'static str,
}

/// The built-in machines.
pub const ENTRIES: &[Entry] = &[
    Entry { name: "orthoglide", toml: include_str!("orthoglide.toml") },
    Entry { name: "tripteron", toml: include_str!("tripteron.toml") },
    Entry { name: "delta_3puu", toml: include_str!("delta_3puu.toml") },
    Entry { name: "delta_3prpar", toml: include_str!("delta_3prpar.toml") },
    Entry { name: "rotary_delta", toml: include_str!("rotary_delta.toml") },
    Entry { name: "hexapod", toml: include_str!("hexapod.toml") },
];

/// The built-in machine called `name`.
pub fn find(name: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.name == name)
}

/// Names of the built-in machines.
pub fn names() -> impl Iterator<Item = &'static str> {
    ENTRIES.iter().map(|entry| entry.name)
}
