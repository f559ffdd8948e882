//! The sources of error as a page tells them apart.

use crate::{
    report::page::{Group, GroupValue},
    study::Source,
};

/// The sources of error, both at once first.
pub(super) fn source_group() -> Group {
    let value = |source: Source, label: &str| GroupValue { cells: vec![source.label().into()], label: label.into() };
    Group {
        columns: vec!["source".into()],
        label: "source of error".into(),
        values: vec![
            value(Source::Both, "both at once"),
            value(Source::Cutting, "cutting force"),
            value(Source::Assembly, "chain errors"),
        ],
    }
}
