//! What a feature is off, split into its size, where it is, and its form.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// How far a feature is off: `d = offset + n·shift + rest` along its outward normals `n`, by least squares over its area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Split {
    /// Material left all over it, along the normal, mm: a pocket is smaller by this at each wall, a boss larger.
    pub offset_mm: f64,
    /// Where it is beside where it should be, mm; of directions that its normals do not tell from its size, nothing.
    pub shift_mm: Vector3<f64>,
    /// Its form: from the lowest to the highest of what is left, mm.
    pub form_mm: f64,
}

/// Share of the area, squared, that must face another way for location to be told from size.
const TOLD: f64 = 1e-3;

/// Splits what a feature is off at places with a unit normal, an area (mm²) and a deviation along it (mm, positive where material is left); `None` of no place.
pub fn split(places: impl Iterator<Item = (Vector3<f64>, f64, f64)> + Clone) -> Option<Split> {
    let area: f64 = places.clone().map(|(_, area, _)| area).sum();
    if area <= 0.0 {
        return None;
    }
    let mean = |of: &dyn Fn(&Vector3<f64>, f64) -> Vector3<f64>| -> Vector3<f64> {
        places.clone().map(|(normal, area, mm)| area * of(&normal, mm)).sum::<Vector3<f64>>() / area
    };
    let normal = mean(&|normal, _| *normal);
    let middle = places.clone().map(|(_, area, mm)| area * mm).sum::<f64>() / area;
    let spread = |(own, area, _)| {
        let way: Vector3<f64> = own - normal;
        area * way * way.transpose()
    };
    let spread = SymmetricEigen::new(places.clone().map(spread).sum::<Matrix3<f64>>() / area);
    let slope = mean(&|own, mm| (mm - middle) * (own - normal));
    let along = spread.eigenvalues.iter().zip(spread.eigenvectors.column_iter()).filter(|(told, _)| **told > TOLD);
    let shift_mm: Vector3<f64> = along.map(|(told, way)| way * (way.dot(&slope) / told)).sum();
    let offset_mm = middle - normal.dot(&shift_mm);
    let rest = places.map(|(own, _, mm)| mm - offset_mm - own.dot(&shift_mm));
    let [low, high] = rest.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], own| [low.min(own), high.max(own)]);
    Some(Split { offset_mm, shift_mm, form_mm: high - low })
}
