//! What several results have in common, node by node.

use std::collections::HashSet;

use super::dataset::Dataset;

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

    /// What a reader must know if results have nodes of their own.
    pub fn remark(&self, data: &[Dataset]) -> Option<String> {
        let counts: Vec<usize> = data.iter().map(Dataset::node_count).collect();
        let common = self.count();
        if counts.iter().all(|count| *count == common) {
            return None;
        }
        let all = counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" and ");
        Some(match common {
            0 => format!(
                "The results have {all} nodes and none in common: smallest, mean and largest values are compared, each \
                 over its own nodes, but not node by node."
            ),
            common => format!(
                "The results have {all} nodes, {common} of them in common: differences and who is better where are \
                 taken at these; smallest, mean and largest values are each over all own nodes."
            ),
        })
    }
}
