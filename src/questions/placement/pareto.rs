//! The best compromises between metrics.

use super::{
    metric::{Metric, Metrics},
    site::Site,
};

/// Whether `a` is no worse than `b` in every one of `metrics` and better in one. False where a value is missing.
pub(super) fn dominates(a: &Metrics, b: &Metrics, metrics: &[Metric]) -> bool {
    let mut is_better = false;
    for metric in metrics {
        let (Some(a), Some(b)) = (a.get(*metric), b.get(*metric)) else { return false };
        match metric.cost(a).total_cmp(&metric.cost(b)) {
            std::cmp::Ordering::Greater => return false,
            std::cmp::Ordering::Less => is_better = true,
            std::cmp::Ordering::Equal => {}
        }
    }
    is_better
}

/// The places that no other one dominates, by the first metric; of equal ones the first.
pub(super) fn front(places: &[(Site, Metrics)], metrics: &[Metric]) -> Vec<(Site, Metrics)> {
    if metrics.is_empty() {
        return Vec::new();
    }
    let cost = |place: &(Site, Metrics)| -> Vec<f64> {
        metrics.iter().map(|m| place.1.get(*m).map_or(f64::INFINITY, |value| m.cost(value))).collect()
    };
    let mut sorted: Vec<(Vec<f64>, usize)> =
        places.iter().enumerate().map(|(index, place)| (cost(place), index)).collect();
    sorted.retain(|(costs, _)| costs.iter().all(|cost| cost.is_finite()));
    sorted.sort_by(|(a, i), (b, j)| {
        let by_cost = a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
        by_cost.unwrap_or(i.cmp(j))
    });
    // Sorted like this, a place can only be dominated by, or equal to, one before it.
    let mut front: Vec<(Vec<f64>, usize)> = Vec::new();
    for (costs, index) in sorted {
        let covered = |other: &(Vec<f64>, usize)| other.0.iter().zip(&costs).all(|(a, b)| a <= b);
        if !front.iter().any(covered) {
            front.push((costs, index));
        }
    }
    front.into_iter().map(|(_, index)| places[index]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(deflection: f64, margin: f64) -> (Site, Metrics) {
        let mut metrics = Metrics::default();
        metrics.set(Metric::WorstDeflection, deflection);
        metrics.set(Metric::StabilityMargin, margin);
        (Site([deflection, margin, 0.0, 0.0, 0.0, 0.0]), metrics)
    }

    #[test]
    fn the_front_is_what_nothing_dominates() {
        let metrics = [Metric::WorstDeflection, Metric::StabilityMargin];
        // A larger margin is better.
        let places = [place(3.0, 9.0), place(1.0, 5.0), place(2.0, 5.0), place(2.0, 8.0), place(1.0, 5.0)];
        let found: Vec<[f64; 2]> = front(&places, &metrics).iter().map(|(site, _)| [site.0[0], site.0[1]]).collect();
        assert_eq!(found, [[1.0, 5.0], [2.0, 8.0], [3.0, 9.0]]);
        assert!(dominates(&places[3].1, &places[2].1, &metrics));
        assert!(!dominates(&places[1].1, &places[4].1, &metrics));
        assert!(front(&places, &[]).is_empty());
    }
}
