//! Cutting forces of single tools and of features of a program.

use std::collections::BTreeMap;

use crate::{
    process::cutting::{CuttingLaw, LoadError},
    toolpath::{PathPoint, Toolpath},
};

/// Cutting forces of their own, which some tools and some features of a program have.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OwnForces {
    /// By the number of the tool.
    pub of_tools: BTreeMap<u32, CuttingLaw>,
    /// By the text that begins the feature; [`PathPoint::feature`] counts them.
    pub of_features: Vec<(String, CuttingLaw)>,
}

impl OwnForces {
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.of_tools.is_empty() && self.of_features.is_empty()
    }

    /// The force at `point`: that of its feature, or else that of its tool.
    #[must_use]
    pub fn at(&self, point: &PathPoint) -> Option<&CuttingLaw> {
        let of_feature = point.feature.and_then(|index| self.of_features.get(usize::from(index)));
        let of_tool = || point.tool.and_then(|number| self.of_tools.get(&number));
        of_feature.map(|(_, law)| law).or_else(of_tool)
    }

    /// Whether `path` as a whole suits these forces, `others` where there is none of its own.
    ///
    /// # Errors
    /// As [`CuttingLaw::check`]; a path that does not say which tool cuts, a tool without any force, a feature in which nothing is
    /// cut.
    pub fn check(&self, others: &CuttingLaw, path: &Toolpath) -> Result<(), LoadError> {
        if self.is_empty() {
            return others.check(path);
        }
        let mut laws = self.of_tools.values().chain(self.of_features.iter().map(|(_, law)| law)).chain([others]);
        if !laws.any(|law| *law == CuttingLaw::FromPath) && path.points().iter().any(|point| point.load.is_some()) {
            return Err(LoadError::UnusedLoads { other_law: true });
        }
        let cutting = || path.points().iter().filter(|point| point.cutting);
        for (index, (text, _)) in self.of_features.iter().enumerate() {
            if !cutting().any(|point| point.feature.map(usize::from) == Some(index)) {
                return Err(LoadError::NoSuchFeature { text: text.clone() });
            }
        }
        if !self.of_tools.is_empty() && cutting().all(|point| point.tool.is_none()) {
            return Err(LoadError::ToolNotKnown);
        }
        match cutting().find(|point| *others == CuttingLaw::None && self.at(point).is_none()) {
            Some(point) => Err(LoadError::NoForce { tool: point.tool, segment: point.source.segment }),
            None => Ok(()),
        }
    }

    /// Which tools and features have one, in words.
    #[must_use]
    pub fn words(&self) -> String {
        let tools = self.of_tools.keys().map(|number| format!("tool {number}"));
        let features = self.of_features.iter().map(|(text, _)| format!("\"{text}\""));
        format!("its own for {}", tools.chain(features).collect::<Vec<_>>().join(", "))
    }
}
