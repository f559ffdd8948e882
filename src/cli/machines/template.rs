//! `kinetostat machines --new`: machine files to begin with, which work as they are.

/// The line that tells editors where the schema of a machine file is.
pub const SCHEMA: &str = "#:schema machine.schema.json";

/// Kinds of machines, and the file of each.
const TEMPLATES: [(&str, &str); 2] =
    [("serial", include_str!("../templates/serial.toml")), ("parallel", include_str!("../templates/parallel.toml"))];

/// What `--new` may be given.
pub fn kinds() -> impl clap::builder::TypedValueParser<Value = &'static str> {
    use clap::builder::{PossibleValuesParser, TypedValueParser};
    let kinds = TEMPLATES.map(|(kind, _)| kind);
    PossibleValuesParser::new(kinds).map(|given| template(&given).0)
}

/// The file of a kind.
pub fn text(kind: &str) -> String {
    template(kind).1.into()
}

fn template(kind: &str) -> (&'static str, &'static str) {
    TEMPLATES.into_iter().find(|(name, _)| *name == kind).unwrap_or(TEMPLATES[0])
}
