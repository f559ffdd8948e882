//! Cutting forces specific to single tools and to features of a program.

use std::collections::BTreeMap;

use crate::{
    process::cutting::{CuttingLaw, LoadError},
    toolpath::{PathPoint, Toolpath},
};

/// Cutting forces that apply only to certain tools and certain features of a program.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OwnForces {
    /// The cutting law of each tool, by tool number.
    pub by_tool: BTreeMap<u32, CuttingLaw>,
    /// The cutting law of each feature, with the text that begins it; [`PathPoint::feature`] is the index.
    pub by_feature: Vec<(String, CuttingLaw)>,
}

impl OwnForces {
    /// Whether no tool and no feature has a force of its own.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.by_tool.is_empty() && self.by_feature.is_empty()
    }

    /// Returns the cutting law at `point`: that of its feature, or else that of its tool; `None` if neither has one.
    #[must_use]
    pub fn law_at(&self, point: &PathPoint) -> Option<&CuttingLaw> {
        let of_feature = point.feature.and_then(|index| self.by_feature.get(usize::from(index)));
        let of_tool = || point.tool.and_then(|number| self.by_tool.get(&number));
        of_feature.map(|(_, law)| law).or_else(of_tool)
    }

    /// Returns all of them.
    pub(crate) fn laws(&self) -> impl Iterator<Item = &CuttingLaw> {
        self.by_tool.values().chain(self.by_feature.iter().map(|(_, law)| law))
    }

    /// Returns these forces with one component each, as [`CuttingLaw::with_only`] does; `None` if one of them is no sum of components.
    pub(crate) fn with_only(&self, component: usize) -> Option<Self> {
        let by_tool = self.by_tool.iter().map(|(number, law)| Some((*number, law.with_only(component)?)));
        let by_feature = self.by_feature.iter().map(|(text, law)| Some((text.clone(), law.with_only(component)?)));
        Some(Self { by_tool: by_tool.collect::<Option<_>>()?, by_feature: by_feature.collect::<Option<_>>()? })
    }

    /// Checks that `path` as a whole suits these forces, with `others` where no tool or feature has its own. Fails like [`CuttingLaw::check`],
    /// and if the path does not say which tool cuts, a tool has no force, or nothing is cut in a feature.
    pub fn check(&self, others: &CuttingLaw, path: &Toolpath) -> Result<(), LoadError> {
        if self.is_empty() {
            return others.check(path);
        }
        let mut laws = self.laws().chain([others]);
        if !laws.any(CuttingLaw::takes_loads) && path.points().iter().any(|point| point.load.is_some()) {
            return Err(LoadError::UnusedLoads { other_law: true });
        }
        let cutting = || path.points().iter().filter(|point| point.cutting);
        for (index, (text, _)) in self.by_feature.iter().enumerate() {
            if !cutting().any(|point| point.feature.map(usize::from) == Some(index)) {
                return Err(LoadError::NoSuchFeature { text: text.clone() });
            }
        }
        if !self.by_tool.is_empty() && cutting().all(|point| point.tool.is_none()) {
            return Err(LoadError::ToolNotKnown);
        }
        match cutting().find(|point| *others == CuttingLaw::None && self.law_at(point).is_none()) {
            Some(point) => Err(LoadError::NoForce { tool: point.tool, segment: point.source.segment }),
            None => Ok(()),
        }
    }

    /// Describes in words which tools and features have a force of their own.
    #[must_use]
    pub fn text(&self) -> String {
        let tools = self.by_tool.keys().map(|number| format!("tool {number}"));
        let features = self.by_feature.iter().map(|(text, _)| format!("\"{text}\""));
        format!("its own for {}", tools.chain(features).collect::<Vec<_>>().join(", "))
    }
}
