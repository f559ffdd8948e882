//! One interactive view of several results, restricted to the quantities, groups and nodes that all of them have.

use std::collections::HashSet;

use super::{
    dataset::{Dataset, MAX_NUMBERS},
    description::{Explorer, Quantity, Shape},
    folder::ResultFolder,
    single::group_labels,
    winners::{Extremes, Winners},
};
use crate::{files::words::counted, input::error::Result};

/// A view of several results, which are named by letters, with their numbers at the same nodes (points, methods or places).
pub(super) struct Aligned {
    /// Quantities and groups that all results have; table and marks are those of the first result.
    pub shared: Explorer,
    pub letters: Vec<char>,
    /// Numbers of each result at all its own nodes.
    pub data: Vec<Dataset>,
    /// Numbers of each result at the nodes that all results have.
    pub common: Vec<Dataset>,
    /// Size below which a number counts as rounding, by quantity; see [`Floors`](super::winners::Floors).
    pub floors: Vec<f64>,
    pub remarks: Vec<String>,
}

impl Aligned {
    /// Reads the view `explorer` of the first folder from all `folders`; returns `None`, and adds a note, if one has no such view.
    pub fn read(
        explorer: &Explorer,
        folders: &[ResultFolder],
        letters: &[char],
        notes: &mut Vec<String>,
    ) -> Result<Option<Self>> {
        let mut views: Vec<&Explorer> = Vec::new();
        for (folder, letter) in folders.iter().zip(letters) {
            match folder.description.explorers.iter().find(|e| e.title == explorer.title && e.shape == explorer.shape) {
                Some(same) if same.keys() == explorer.keys() => views.push(same),
                _ => {
                    notes.push(format!("{letter} has no view \"{}\" over the same coordinates.", explorer.title));
                    return Ok(None);
                }
            }
        }
        let mut remarks = Vec::new();
        let shared = shared_part(explorer, &views, letters, &mut remarks);
        let mut data = Vec::new();
        for ((folder, view), letter) in folders.iter().zip(&views).zip(letters) {
            let table = folder.table(&view.table)?;
            let mut notes = folder.description.tables.iter();
            if let Some(kept) = notes.find(|note| note.file == view.table).and_then(|note| note.kept.as_ref()) {
                remarks.push(format!(
                    "{letter}: {kept} Here, means, smallest values and shares are of the rows that the table has."
                ));
            }
            data.push(Dataset::read(&reordered_like(view, &shared), &table, MAX_NUMBERS / 2 / folders.len())?);
        }
        let parts = data.iter().map(|own| data.iter().fold(own.clone(), |part, other| part.restricted_to(other)));
        Ok(Some(Self { common: parts.collect(), letters: letters.to_vec(), floors: Vec::new(), shared, data, remarks }))
    }

    /// Returns what a reader calls one node: grid point, path point, place, or the label of the names.
    pub fn node_noun(&self) -> &str {
        match self.shared.shape {
            Shape::Grid if self.shared.title.to_lowercase().contains("place") => "place",
            Shape::Grid => "grid point",
            Shape::Curve => "path point",
            Shape::Names => self.shared.coordinates.first().map_or("row", |column| &column.label),
        }
    }

    /// Returns the number of nodes that all results have.
    pub fn node_count(&self) -> usize {
        self.common.first().map_or(0, Dataset::node_count)
    }

    /// Returns a predicate: whether a node is flagged neither in the first result nor in the result `other`.
    pub fn is_valid_in_both(&self, group: usize, other: usize) -> impl Fn(usize) -> bool {
        let flagged: HashSet<usize> =
            [0, other].iter().flat_map(|i| self.common[*i].flags[group].iter().map(|flag| flag.0)).collect();
        move |node| !flagged.contains(&node)
    }

    /// Returns the numbers over which smallest, mean and largest values are taken, and their description: those at common nodes, or of
    /// different curves at all own nodes, since these share nodes by chance.
    pub fn extremes_basis(&self) -> (&[Dataset], String) {
        let all = counted(self.node_count(), self.node_noun());
        match self.has_same_nodes() {
            true => (&self.common, format!("over {all}")),
            false if self.has_own_extremes() => (&self.data, format!("over all own {}s", self.node_noun())),
            false => (&self.common, format!("over {all} in common")),
        }
    }

    /// Returns whether smallest, mean and largest values are taken over all own nodes of each result: those of different curves.
    pub fn has_own_extremes(&self) -> bool {
        self.shared.shape == Shape::Curve && !self.has_same_nodes()
    }

    /// Returns whether all results have the same nodes.
    pub fn has_same_nodes(&self) -> bool {
        self.data.iter().all(|dataset| dataset.node_count() == self.node_count())
    }

    /// Returns a sentence on nodes that not all results have; `None` if all have the same.
    pub fn node_remark(&self) -> Option<String> {
        if self.has_same_nodes() {
            return None;
        }
        let noun = self.node_noun();
        let all = self.data.iter().map(|own| own.node_count().to_string()).collect::<Vec<_>>().join(" and ");
        let own = format!("The results have {all} {noun}s");
        let of_curves = format!("smallest, mean and largest values are each over all own {noun}s");
        Some(match (self.node_count(), self.shared.shape) {
            (0, Shape::Curve) => {
                format!("{own} and none in common: {of_curves}; nothing is compared point by point.")
            }
            (0, _) => format!("{own} and none in common: their numbers are not compared."),
            (common, Shape::Curve) => format!(
                "{own}, {common} of them in common: differences and who is better where are taken at the common ones; {of_curves}."
            ),
            (common, _) => format!(
                "{own}, {common} of them in common: smallest, mean and largest values, differences and who is better \
                 where are taken at the common ones."
            ),
        })
    }

    /// Returns smallest, mean and largest value of each result; `None` if a result has no number.
    pub fn extremes(&self, quantity: usize, group: usize) -> Option<Vec<Extremes>> {
        let (data, _) = self.extremes_basis();
        let is_valid = self.valid_nodes(quantity, group);
        let of =
            |(data, valid): (&Dataset, &Vec<bool>)| Extremes::new(&data.values[quantity][group], |node| valid[node]);
        data.iter().zip(&is_valid).map(of).collect()
    }

    /// Returns for each result which nodes of [`Aligned::extremes_basis`] count: those with a number that is no bound, in all results where these
    /// have the same nodes.
    pub fn valid_nodes(&self, quantity: usize, group: usize) -> Vec<Vec<bool>> {
        let own = self.known_nodes(quantity, group);
        if self.has_own_extremes() {
            return own;
        }
        let all: Vec<bool> =
            (0..self.node_count()).map(|node| own.iter().all(|own| own.get(node) == Some(&true))).collect();
        vec![all; own.len()]
    }

    /// Returns for each result which nodes of [`Aligned::extremes_basis`] have a number in it that is no bound.
    pub fn known_nodes(&self, quantity: usize, group: usize) -> Vec<Vec<bool>> {
        let of = |data: &Dataset| -> Vec<bool> {
            let flagged: HashSet<usize> = data.flags[group].iter().map(|flag| flag.0).collect();
            let values = data.values[quantity][group].iter().enumerate();
            values.map(|(node, value)| value.is_finite() && !flagged.contains(&node)).collect()
        };
        self.extremes_basis().0.iter().map(of).collect()
    }

    /// Whether nodes are points of a map, which stand for the volume around them.
    pub fn is_map(&self) -> bool {
        self.shared.shape == Shape::Grid && self.node_noun() == "grid point"
    }

    /// Returns what each node of `data` stands for in shares: on a map the volume of its cell, as a map itself counts; else all the same.
    pub fn weights(&self, data: &Dataset) -> Vec<f64> {
        let is_map = self.is_map();
        let cell = |axis: &Vec<f64>, k: usize| match axis.len() {
            0 | 1 => 1.0,
            n => 0.5 * (axis[(k + 1).min(n - 1)] - axis[k.saturating_sub(1)]) / (axis[n - 1] - axis[0]),
        };
        let volume = |mut node: usize| {
            data.axes.iter().fold(1.0, |volume, axis| {
                let k = node % axis.len();
                node /= axis.len();
                volume * cell(axis, k)
            })
        };
        (0..data.node_count()).map(|node| if is_map { volume(node) } else { 1.0 }).collect()
    }

    /// Returns which result is best at each node, for a quantity in the first group; `None` if neither small nor large values are better.
    pub fn winners(&self, quantity: usize) -> Option<Winners> {
        let parts: Vec<&Dataset> = self.common.iter().collect();
        let winners = Winners::new(&parts, quantity, 0, self.shared.quantities[quantity].better, self.floors[quantity]);
        winners.map(|winners| winners.weighted(parts.first().map_or_else(Vec::new, |part| self.weights(part))))
    }

    /// Returns the number of groups, at least 1.
    pub fn group_count(&self) -> usize {
        self.shared.group.as_ref().map_or(1, |group| group.values.len())
    }

    /// Returns the label of a group; empty if there are no groups.
    pub fn group_name(&self, group: usize) -> &str {
        group_labels(&self.shared).get(group).copied().unwrap_or_default()
    }
}

/// Returns `explorer` with the quantities (in the same unit) and groups that `all` views have; remarks say what is left out.
fn shared_part(explorer: &Explorer, all: &[&Explorer], letters: &[char], remarks: &mut Vec<String>) -> Explorer {
    let mut shared = explorer.clone();
    shared.quantities.retain(|quantity| {
        let missing = all.iter().position(|e| !e.quantities.iter().any(|q| is_same(q, quantity)));
        if let Some(missing) = missing {
            let with_unit = label_with_unit(&quantity.label, &quantity.unit);
            remarks.push(format!("{} does not have {with_unit}, which is not compared.", letters[missing]));
        }
        missing.is_none()
    });
    if let Some(group) = &mut shared.group {
        group.values.retain(|value| {
            let has = |e: &&Explorer| e.group.as_ref().is_some_and(|g| g.values.contains(value));
            let missing = all.iter().position(|e| !has(e));
            if let Some(missing) = missing {
                remarks.push(format!("{} does not have \"{}\", which is not compared.", letters[missing], value.label));
            }
            missing.is_none()
        });
    }
    shared
}

/// Returns whether two quantities have the same label and unit.
fn is_same(a: &Quantity, b: &Quantity) -> bool {
    a.label == b.label && a.unit == b.unit
}

/// Returns a label with its unit in brackets, or alone if it has none.
pub(super) fn label_with_unit(label: &str, unit: &str) -> String {
    if unit.is_empty() { label.into() } else { format!("{label} [{unit}]") }
}

/// Returns `own` with the quantities and groups of `shared`, in the order of `shared`.
fn reordered_like(own: &Explorer, shared: &Explorer) -> Explorer {
    let quantities = shared.quantities.iter().filter_map(|q| own.quantities.iter().find(|other| is_same(q, other)));
    Explorer { quantities: quantities.cloned().collect(), group: shared.group.clone(), ..own.clone() }
}
