//! What several results have in common, node by node.

use std::collections::HashSet;

use super::{dataset::Dataset, description::Shape};
use crate::files::words::counted;

/// The nodes that all results have.
pub(super) struct Common {
    /// Each result at these nodes.
    pub parts: Vec<Dataset>,
}

impl Common {
    pub fn new(data: &[Dataset]) -> Self {
        let parts = data.iter().map(|own| data.iter().fold(own.clone(), |part, other| part.at_nodes_of(other)));
        Self { parts: parts.collect() }
    }

    /// Their number.
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
    pub(crate) fn extremes_of<'a>(&'a self, data: &'a [Dataset], shape: Shape, noun: &str) -> (&'a [Dataset], String) {
        match (self.is_whole(data), shape) {
            (true, _) => (&self.parts, format!("over {}", counted(self.count(), noun))),
            (false, Shape::Curve) => (data, format!("over all own {noun}s")),
            (false, _) => (&self.parts, format!("over {} in common", counted(self.count(), noun))),
        }
    }

    /// Whether no result has nodes of its own.
    pub fn is_whole(&self, data: &[Dataset]) -> bool {
        data.iter().all(|own| own.node_count() == self.count())
    }

    /// What a reader must know if results have nodes, each a `noun`, of their own.
    pub(crate) fn remark(&self, data: &[Dataset], shape: Shape, noun: &str) -> Option<String> {
        if self.is_whole(data) {
            return None;
        }
        let all = data.iter().map(|own| own.node_count().to_string()).collect::<Vec<_>>().join(" and ");
        let own = format!("The results have {all} {noun}s");
        let of_curves = format!("smallest, mean and largest values are each over all own {noun}s");
        Some(match (self.count(), shape) {
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
}
