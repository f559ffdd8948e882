//! One view of several results, brought to the same quantities, groups and nodes.

use std::collections::HashSet;

use super::{
    dataset::{Dataset, MOST_NUMBERS},
    description::{Explorer, Quantity, Shape},
    folder::ResultFolder,
    single::group_labels,
    winners::{Extremes, Winners},
};
use crate::{files::words::counted, input::error::Result};

/// A view that all results have.
pub(super) struct Aligned {
    /// What all have of it; table and marks are those of the first.
    pub shared: Explorer,
    /// A letter for each result.
    pub letters: Vec<char>,
    /// The numbers of each result.
    pub data: Vec<Dataset>,
    /// The same at the nodes that all have.
    pub parts: Vec<Dataset>,
    /// Below which size a number is rounding, by quantity; see [`Floors`](super::winners::Floors).
    pub floors: Vec<f64>,
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
        let parts = data.iter().map(|own| data.iter().fold(own.clone(), |part, other| part.at_nodes_of(other)));
        Ok(Some(Self { parts: parts.collect(), letters: letters.to_vec(), floors: Vec::new(), shared, data, remarks }))
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

    /// Number of nodes that all have.
    pub fn count(&self) -> usize {
        self.parts.first().map_or(0, Dataset::node_count)
    }

    /// Nodes whose value is a plain answer in both results.
    pub fn counts(&self, group: usize, other: usize) -> impl Fn(usize) -> bool {
        let bad: HashSet<usize> =
            [0, other].iter().flat_map(|i| self.parts[*i].flags[group].iter().map(|flag| flag.0)).collect();
        move |node| !bad.contains(&node)
    }

    /// What smallest, mean and largest values are taken of, and its name: the nodes in common, so that they are of the
    /// same places; of a curve all own ones, since curves of other lengths are other paths and share nodes by chance.
    pub fn extremes_of(&self) -> (&[Dataset], String) {
        let all = counted(self.count(), self.noun());
        match (self.is_whole(), self.shared.shape) {
            (true, _) => (&self.parts, format!("over {all}")),
            (false, Shape::Curve) => (&self.data, format!("over all own {}s", self.noun())),
            (false, _) => (&self.parts, format!("over {all} in common")),
        }
    }

    /// Whether no result has nodes of its own.
    pub fn is_whole(&self) -> bool {
        self.data.iter().all(|own| own.node_count() == self.count())
    }

    /// What a reader must know if results have nodes of their own.
    pub fn remark(&self) -> Option<String> {
        if self.is_whole() {
            return None;
        }
        let noun = self.noun();
        let all = self.data.iter().map(|own| own.node_count().to_string()).collect::<Vec<_>>().join(" and ");
        let own = format!("The results have {all} {noun}s");
        let of_curves = format!("smallest, mean and largest values are each over all own {noun}s");
        Some(match (self.count(), self.shared.shape) {
            (0, Shape::Curve) => {
                format!("{own} and none in common: {of_curves}; nothing is compared point by point.")
            }
            (0, _) => format!("{own} and none in common: their numbers are not compared."),
            (common, Shape::Curve) => format!(
                "{own}, {common} of them in common: differences and who is better where are taken at these; {of_curves}."
            ),
            (common, _) => format!(
                "{own}, {common} of them in common: smallest, mean and largest values, differences and who is better \
                 where are taken at these."
            ),
        })
    }

    /// Smallest, mean and largest value of each result; `None` if one has no number.
    pub fn extremes(&self, quantity: usize, group: usize) -> Option<Vec<Extremes>> {
        let (data, _) = self.extremes_of();
        data.iter().map(|own| extremes(own, quantity, group)).collect()
    }

    /// Which result is best where, of a quantity in the first group; `None` if neither value is the better one by its nature.
    pub fn winners(&self, quantity: usize) -> Option<Winners> {
        let parts: Vec<&Dataset> = self.parts.iter().collect();
        Winners::new(&parts, quantity, 0, self.shared.quantities[quantity].better, self.floors[quantity])
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
