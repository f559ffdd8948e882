//! Grid points that stand out.

use crate::study::superposition::{
    MapPoint, Superposition,
    departure::{Followed, Sum, Worst},
};

/// The solved grid point at which `value` of the departure of `sum` at `followed` is largest.
pub fn largest(
    results: &Superposition,
    sum: Sum,
    followed: Followed,
    value: fn(&Worst) -> Option<f64>,
) -> Option<(f64, &MapPoint, &Worst)> {
    let mut found: Option<(f64, &MapPoint, &Worst)> = None;
    for point in &results.points {
        let worst = point.departures.as_ref().ok().and_then(|departures| departures.worst(sum, followed).ok());
        let here = worst.and_then(|worst| Some((value(worst)?, point, worst)));
        if let Some(here) = here
            && found.is_none_or(|found| here.0 > found.0)
        {
            found = Some(here);
        }
    }
    found
}

/// Size of the departure, mm.
pub fn size(worst: &Worst) -> Option<f64> {
    Some(worst.departure_mm)
}

/// Grid points that keep within the tolerance up to the smallest and to the largest factor on the load.
pub fn load_extremes(results: &Superposition) -> Option<[(f64, &MapPoint); 2]> {
    let mut found: Option<[(f64, &MapPoint); 2]> = None;
    for point in &results.points {
        if let Some(factor) = point.largest_load.factor() {
            let here = (factor, point);
            found = Some(match found {
                None => [here, here],
                Some([least, most]) => {
                    [if factor < least.0 { here } else { least }, if factor > most.0 { here } else { most }]
                }
            });
        }
    }
    found
}

/// Number of solved grid points.
pub fn solved_points(results: &Superposition) -> usize {
    results.points.iter().filter(|point| point.departures.is_ok()).count()
}
