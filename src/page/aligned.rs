//! One view of several results, brought to the same quantities, groups and nodes.

use std::collections::HashSet;

use super::{
    common::Common,
    dataset::{Dataset, MOST_NUMBERS},
    description::{Explorer, Quantity, Shape},
    folder::ResultFolder,
    single::group_labels,
    wins::Extremes,
};
use crate::input::error::Result;

/// A view that all results have.
pub(super) struct Aligned {
    /// What all have of it; table and marks are those of the first.
    pub shared: Explorer,
    /// The numbers of each result.
    pub data: Vec<Dataset>,
    /// The same at the nodes that all have.
    pub common: Common,
    /// What is left out.
    pub remarks: Vec<String>,
}

impl Aligned {
    /// `explorer` of the first folder with what the others have of it; `None`, and a note, if one has no such view.
    pub fn read(
        explorer: &Explorer,
        folders: &[ResultFolder],
        letters: &[char],
        notes: &mut Vec<String>,
    ) -> Result<Option<Self>> {
        let mut own: Vec<&Explorer> = Vec::new();
        for (folder, letter) in folders.iter().zip(letters) {
            match folder.description.explorers.iter().find(|e| e.title == explorer.title && e.shape == explorer.shape) {
                Some(same) if same.keys() == explorer.keys() => own.push(same),
                _ => {
                    notes.push(format!("{letter} has no view \"{}\" over the same coordinates.", explorer.title));
                    return Ok(None);
                }
            }
        }
        let mut remarks = Vec::new();
        let shared = shared_part(explorer, &own, letters, &mut remarks);
        let mut data = Vec::new();
        for (folder, own) in folders.iter().zip(&own) {
            let table = folder.table(&own.table)?;
            data.push(Dataset::read(&reordered(own, &shared), &table, MOST_NUMBERS / 2 / folders.len())?);
        }
        let common = Common::new(&data);
        Ok(Some(Self { shared, data, common, remarks }))
    }

    /// What one node is to a reader: a grid point, a method, a place.
    pub fn noun(&self) -> &str {
        match self.shared.shape {
            Shape::Grid if self.shared.title.to_lowercase().contains("place") => "place",
            Shape::Grid => "grid point",
            Shape::Curve => "path point",
            Shape::Names => self.shared.coordinates.first().map_or("row", |column| &column.label),
        }
    }

    /// What extremes are taken of, and its name.
    pub fn extremes_of(&self) -> (&[Dataset], String) {
        self.common.extremes_of(&self.data, self.shared.shape, self.noun())
    }

    /// Smallest, mean and largest value of each result; `None` if one has no number.
    pub fn extremes(&self, quantity: usize, group: usize) -> Option<Vec<Extremes>> {
        let (data, _) = self.extremes_of();
        data.iter().map(|own| extremes(own, quantity, group)).collect()
    }

    /// Number of groups, at least 1.
    pub fn groups(&self) -> usize {
        self.shared.group.as_ref().map_or(1, |group| group.values.len())
    }

    /// Name of a group; empty if there are none.
    pub fn group_name(&self, group: usize) -> &str {
        group_labels(&self.shared).get(group).copied().unwrap_or_default()
    }
}

/// Of one result; flagged nodes, whose numbers are bounds, do not count.
fn extremes(data: &Dataset, quantity: usize, group: usize) -> Option<Extremes> {
    let bad: HashSet<usize> = data.flags[group].iter().map(|flag| flag.0).collect();
    Extremes::new(&data.values[quantity][group], |node| !bad.contains(&node))
}

/// The quantities and groups of `explorer` that all of `own` have in the same unit.
fn shared_part(explorer: &Explorer, own: &[&Explorer], letters: &[char], remarks: &mut Vec<String>) -> Explorer {
    let mut shared = explorer.clone();
    shared.quantities.retain(|quantity| {
        let missing = own.iter().position(|e| !e.quantities.iter().any(|q| same(q, quantity)));
        if let Some(missing) = missing {
            let with_unit = in_unit(&quantity.label, &quantity.unit);
            remarks.push(format!("{} does not have {with_unit}; it is not compared.", letters[missing]));
        }
        missing.is_none()
    });
    if let Some(group) = &mut shared.group {
        group.values.retain(|value| {
            let has = |e: &&Explorer| e.group.as_ref().is_some_and(|g| g.values.contains(value));
            let missing = own.iter().position(|e| !has(e));
            if let Some(missing) = missing {
                remarks.push(format!("{} does not have \"{}\"; it is not compared.", letters[missing], value.label));
            }
            missing.is_none()
        });
    }
    shared
}

fn same(a: &Quantity, b: &Quantity) -> bool {
    a.label == b.label && a.unit == b.unit
}

pub(super) fn in_unit(label: &str, unit: &str) -> String {
    if unit.is_empty() { label.into() } else { format!("{label} [{unit}]") }
}

/// `own` with the quantities and groups of `shared`, in its order.
fn reordered(own: &Explorer, shared: &Explorer) -> Explorer {
    let quantities = shared.quantities.iter().filter_map(|q| own.quantities.iter().find(|other| same(q, other)));
    Explorer { quantities: quantities.cloned().collect(), group: shared.group.clone(), ..own.clone() }
}
