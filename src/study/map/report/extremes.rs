//! Where a map is best and worst, for the figure that shows its answer.

use crate::study::map::MapPoint;

/// A value and where it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct At {
    pub value: f64,
    pub position_mm: [f64; 3],
}

/// The smallest and the largest value seen, each where it was seen first.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Extremes(pub Option<[At; 2]>);

impl Extremes {
    pub(super) fn add(&mut self, point: &MapPoint, value: Option<f64>) {
        let Some(value) = value.filter(|value| value.is_finite()) else { return };
        let here = At { value, position_mm: point.position_mm };
        let [least, most] = self.0.unwrap_or([here; 2]);
        self.0 = Some([if value < least.value { here } else { least }, if value > most.value { here } else { most }]);
    }
}
