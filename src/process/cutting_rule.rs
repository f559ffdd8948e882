//! The rule that decides which moves of a path cut, where the path itself does not say: G1 through air does not.

use crate::toolpath::{PathPoint, Toolpath};

/// Conditions under which a move that is not rapid counts as cutting; without any, every such move does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CuttingRule {
    /// Highest z in W at which the tool cuts, mm: for a workpiece below the tool.
    pub below_z_mm: Option<f64>,
    /// Lowest z in W at which the tool cuts, mm: for a workpiece above the tool.
    pub above_z_mm: Option<f64>,
    /// Fastest feed at which the tool cuts, mm/min. A move without a feed is no faster.
    pub max_feed_mm_per_min: Option<f64>,
}

impl CuttingRule {
    /// Returns `path`, in which cutting points that the conditions exclude no longer cut.
    #[must_use]
    pub fn apply(&self, path: Toolpath) -> Toolpath {
        if *self == Self::default() { path } else { path.cutting_where(|point| self.meets_conditions(point)) }
    }

    /// Whether a cutting point meets all conditions.
    fn meets_conditions(&self, point: &PathPoint) -> bool {
        let z = point.position_mm.z;
        self.below_z_mm.is_none_or(|most| z <= most)
            && self.above_z_mm.is_none_or(|least| z >= least)
            && self.max_feed_mm_per_min.is_none_or(|most| point.feed_mm_per_min.is_none_or(|feed| feed <= most))
    }

    /// Describes in words which moves count as cutting.
    #[must_use]
    pub fn text(&self) -> String {
        let conditions = [
            self.below_z_mm.map(|z| format!("z of the workpiece up to {z} mm")),
            self.above_z_mm.map(|z| format!("z of the workpiece from {z} mm")),
            self.max_feed_mm_per_min.map(|feed| format!("a feed up to {feed} mm/min")),
        ];
        let conditions: Vec<String> = conditions.into_iter().flatten().collect();
        match conditions.is_empty() {
            true => "every move but rapid ones, also through air".into(),
            false => format!("every move but rapid ones, with {}", conditions.join(" and ")),
        }
    }
}
