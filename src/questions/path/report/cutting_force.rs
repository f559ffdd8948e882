//! Columns, view and curves of the cutting force on the tool along a path, in base axes (O).

use crate::{
    compensation::TaskPoint,
    files::exchange::{Row, cells},
    page::{Better, Quantity},
    questions::path::report::Curve,
};

/// Axes of the base.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Returns the names of the columns of the cutting force on the tool, O axes, N.
pub fn columns() -> [String; 3] {
    AXES.map(|axis| format!("cutting_force_{axis}_N"))
}

/// Returns the cells of [`columns`] for one task point.
pub fn force_cells(task: &TaskPoint) -> Row {
    // No sign before a zero.
    cells(task.load.force.iter().map(|force| force + 0.0)).collect()
}

/// Returns the components of the cutting force as quantities of a view.
pub fn quantities() -> impl Iterator<Item = Quantity> {
    columns().into_iter().zip(AXES).map(|(column, axis)| {
        Quantity::new([column], &format!("cutting force on the tool along {axis}"), "N", Better::Neither)
    })
}

/// Title of the picture.
pub const TITLE: &str = "Cutting force on the tool, in base axes";

/// Label of the curve of the force's norm.
pub const SIZE: &str = "size";

/// Curves of the components and the norm of the cutting force along a path, collected point by point; O axes, N.
#[derive(Debug, Clone)]
pub struct ForceCurves {
    count: usize,
    /// The largest norm so far, N.
    pub(crate) largest: f64,
    /// Curves along x, y and z, and of the norm.
    curves: [Curve; 4],
}

impl ForceCurves {
    /// Makes empty curves for a path of `points` points.
    pub fn new(points: usize) -> Self {
        Self { count: 0, largest: 0.0, curves: std::array::from_fn(|_| Curve::new(points)) }
    }

    /// Adds the next point, at `x` on the horizontal axis; without `x` it is not drawn.
    pub fn add(&mut self, x: Option<f64>, task: &TaskPoint) {
        let force = &task.load.force;
        self.largest = self.largest.max(force.norm());
        if let Some(x) = x {
            let values = [force.x, force.y, force.z, force.norm()];
            self.curves.iter_mut().zip(values).for_each(|(curve, value)| curve.add(self.count, x, value));
        }
        self.count += 1;
    }

    /// Returns the curves with their labels; none if the force is zero everywhere.
    pub fn labelled_curves(&self) -> Vec<(String, &Curve)> {
        let labels = AXES.iter().map(|axis| format!("along {axis}")).chain([SIZE.to_string()]);
        if self.largest > 0.0 { labels.zip(&self.curves).collect() } else { Vec::new() }
    }
}
