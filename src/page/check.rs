//! Which number of which table a headline quotes, for whoever checks the page against its files.

use serde::Serialize;

use super::verdict::Compares;

/// A number on the first screen, and how it follows from a table.
#[derive(Debug, Serialize)]
pub(super) struct Check {
    /// Address of the table on the page.
    file: String,
    /// Columns; of several, the largest size counts.
    columns: Vec<String>,
    /// Cells that a row must have, by column.
    r#where: Vec<(String, String)>,
    /// Columns that say where a row belongs.
    coordinates: Vec<String>,
    /// Tables that must have the same place.
    common: Vec<String>,
    /// What is taken of the rows.
    rule: Checked,
    /// The number.
    value: f64,
}

/// What is taken of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Checked {
    /// The largest number.
    Max,
    /// The smallest.
    Min,
}

impl Check {
    /// That `value` is the extreme of a quantity of the result `who`, in the first group; `None` if the page leaves nodes out.
    pub fn of(compares: &Compares<'_>, quantity: usize, who: usize, rule: Checked, value: f64) -> Option<Self> {
        let aligned = compares.aligned;
        if aligned.data.iter().any(|data| data.thinned_from.is_some()) {
            return None;
        }
        let shared = &aligned.shared;
        let table = |folder: &String| format!("{folder}/{}", shared.table);
        let group = shared.group.as_ref().and_then(|group| Some((&group.columns, &group.values.first()?.cells)));
        let (_, over) = aligned.extremes_of();
        let is_own = over.contains("own");
        let others = compares.folders.iter().enumerate().filter(|(other, _)| *other != who && !is_own);
        Some(Self {
            file: table(&compares.folders[who]),
            columns: shared.quantities[quantity].columns.clone(),
            r#where: group
                .map(|(columns, cells)| columns.iter().cloned().zip(cells.iter().cloned()).collect())
                .unwrap_or_default(),
            coordinates: shared.keys().iter().map(|column| column.column.clone()).collect(),
            common: others.map(|(_, folder)| table(folder)).collect(),
            rule,
            value,
        })
    }

    /// The same over all rows of its own table.
    #[must_use]
    pub fn alone(self) -> Self {
        Self { common: Vec::new(), ..self }
    }
}
