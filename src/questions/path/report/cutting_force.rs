//! The cutting force along a path, as tables, views and pictures show it: on the tool, in base axes.

use nalgebra::Vector3;

use crate::{
    compensation::TaskPoint,
    files::exchange::{Row, cells},
    page::{Better, Quantity},
    questions::path::report::Curve,
};

/// Axes of the base.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Columns of the force on the tool in base axes.
pub fn columns() -> [String; 3] {
    AXES.map(|axis| format!("cutting_force_{axis}_N"))
}

/// The cells of [`columns`].
pub fn force_cells(task: &TaskPoint) -> Row {
    // No sign before a zero.
    cells(task.load.force.iter().map(|force| force + 0.0)).collect()
}

/// Components of the force as quantities of a view.
pub fn quantities() -> impl Iterator<Item = Quantity> {
    columns().into_iter().zip(AXES).map(|(column, axis)| {
        Quantity::new([column], &format!("cutting force on the tool along {axis}"), "N", Better::Neither)
    })
}

/// Title of the picture.
pub const TITLE: &str = "Cutting force on the tool, in base axes";

/// Label of its size.
pub const SIZE: &str = "size";

/// Components and size of the force along a path, gathered point by point.
#[derive(Debug, Clone)]
pub struct ForceCurves {
    seen: usize,
    acts: bool,
    /// Along the axes, and the size.
    curves: [Curve; 4],
}

impl ForceCurves {
    /// Along a path of `points`.
    pub fn new(points: usize) -> Self {
        Self { seen: 0, acts: false, curves: std::array::from_fn(|_| Curve::new(points)) }
    }

    /// Takes the next point: where the curves stand on their axis, if they do, and what is asked there.
    pub fn add(&mut self, x: Option<f64>, task: &TaskPoint) {
        let force = &task.load.force;
        self.acts |= *force != Vector3::zeros();
        if let Some(x) = x {
            let values = [force.x, force.y, force.z, force.norm()];
            self.curves.iter_mut().zip(values).for_each(|(curve, value)| curve.add(self.seen, x, value));
        }
        self.seen += 1;
    }

    /// The curves with their labels; nothing where there is no force all along.
    pub fn labelled(&self) -> Vec<(String, &Curve)> {
        let labels = AXES.iter().map(|axis| format!("along {axis}")).chain([SIZE.to_string()]);
        if self.acts { labels.zip(&self.curves).collect() } else { Vec::new() }
    }
}
