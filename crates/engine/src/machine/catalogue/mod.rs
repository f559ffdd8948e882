//! Built-in machines, one TOML file each. To add one: put its file here and its line in [`ENTRIES`].

/// A built-in machine.
#[derive(Debug)]
pub struct Entry {
    /// Name by which commands and studies call it.
    pub name: &'static str,
    /// Its machine file.
    pub toml: &'static str,
}

/// The built-in machines; none in a page, which brings its machine along.
#[cfg(target_family = "wasm")]
pub const ENTRIES: &[Entry] = &[];
/// The built-in machines.
#[cfg(not(target_family = "wasm"))]
pub const ENTRIES: &[Entry] = &[
    Entry { name: "orthoglide", toml: include_str!("orthoglide.toml") },
    Entry { name: "tripteron", toml: include_str!("tripteron.toml") },
    Entry { name: "delta_3puu", toml: include_str!("delta_3puu.toml") },
    Entry { name: "delta_3prpar", toml: include_str!("delta_3prpar.toml") },
    Entry { name: "rotary_delta", toml: include_str!("rotary_delta.toml") },
    Entry { name: "hexapod", toml: include_str!("hexapod.toml") },
    Entry { name: "fanuc_r2000ic", toml: include_str!("fanuc_r2000ic.toml") },
    Entry { name: "kr270", toml: include_str!("kr270.toml") },
    Entry { name: "kr500", toml: include_str!("kr500.toml") },
    Entry { name: "irb7600", toml: include_str!("irb7600.toml") },
    Entry { name: "ur10e", toml: include_str!("ur10e.toml") },
    Entry { name: "ur5e", toml: include_str!("ur5e.toml") },
    Entry { name: "hybrid_3ups", toml: include_str!("hybrid_3ups.toml") },
];

/// The built-in machine called `name`; `None` if there is none.
pub fn find(name: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.name == name)
}

/// Names of the built-in machines.
pub fn names() -> impl Iterator<Item = &'static str> {
    ENTRIES.iter().map(|entry| entry.name)
}
