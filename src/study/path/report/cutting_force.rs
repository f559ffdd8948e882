//! The cutting force along a path, as tables, views and pictures show it: on the tool, in base axes.

use nalgebra::Vector3;

use crate::{
    compensation::Demand,
    report::{
        exchange::{Row, cells},
        page::{Better, Quantity},
    },
    study::path::report::Curve,
};

/// Axes of the base.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Columns of the force on the tool in base axes.
pub fn columns() -> [String; 3] {
    AXES.map(|axis| format!("cutting_force_{axis}_N"))
}

/// The cells of [`columns`].
pub fn force_cells(demand: &Demand) -> Row {
    // No sign before a zero.
    cells(demand.load.force.iter().map(|force| force + 0.0)).collect()
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

/// Components and size of the force along a path, with their labels; nothing where there is no force all along. `points` are
/// where the curves stand on their axis and what is demanded there.
pub fn curves<'d>(points: impl Iterator<Item = (Option<f64>, &'d Demand)> + Clone) -> Vec<(String, Curve)> {
    if points.clone().all(|(_, demand)| demand.load.force == Vector3::zeros()) {
        return Vec::new();
    }
    let count = points.clone().count();
    let curve = |value: &dyn Fn(&Vector3<f64>) -> f64| {
        let mut curve = Curve::new(count);
        for (k, (x, demand)) in points.clone().enumerate() {
            x.iter().for_each(|x| curve.add(k, *x, value(&demand.load.force)));
        }
        curve
    };
    let components = (0..3).map(|i| (format!("along {}", AXES[i]), curve(&|force| force[i])));
    components.chain([(SIZE.to_string(), curve(&|force| force.norm()))]).collect()
}
