//! Descriptions of the named points of a machine, for the first figure that shows them.

use crate::files::words::position;
use crate::machine::{Machine, NamedPoint};

/// Largest distance, as a share of the workspace box, at which a point is on its border or in its middle.
const ON: f64 = 1e-6;

/// Describes a named point: its name, where it is in the workspace box of P, and its coordinates.
pub fn named_point_text(machine: &Machine, point: &NamedPoint) -> String {
    let (low, high) = (machine.workspace.min, machine.workspace.max);
    let is_near = |i: usize, value: f64| (point.position[i] - value).abs() <= ON * (high[i] - low[i]).max(1.0);
    let axes = |end: &dyn Fn(usize) -> f64| -> Vec<&str> {
        (0..3).filter(|&i| high[i] > low[i] && is_near(i, end(i))).map(|i| ["x", "y", "z"][i]).collect()
    };
    let (lowest, highest) = (axes(&|i| low[i]), axes(&|i| high[i]));
    let middle = (0..3).all(|i| is_near(i, 0.5 * (low[i] + high[i])));
    let text = match (lowest.len() + highest.len(), lowest.as_slice(), highest.as_slice()) {
        _ if high == low => String::new(),
        (3, lowest, highest) => {
            let end = |word: &str, axes: &[&str]| match axes {
                [] => None,
                axes => Some(format!("{word} {}", axes.join(", "))),
            };
            let ends: Vec<String> = [end("largest", highest), end("smallest", lowest)].into_iter().flatten().collect();
            format!("the corner of the workspace box at the {}, ", ends.join(" and the "))
        }
        _ if middle => "the middle of the workspace box, ".into(),
        _ if (0..3).all(|i| (low[i]..=high[i]).contains(&point.position[i])) => {
            "a point within the workspace box, ".into()
        }
        _ => "a point outside the workspace box, ".into(),
    };
    let [x, y, z]: [f64; 3] = point.position.into();
    format!("{}: {text}{}", point.name, position(x, y, z))
}

/// Describes all named points, for the caption of the first figure that shows them; empty without any.
pub fn named_points_text(machine: &Machine) -> String {
    machine.points.iter().map(|p| named_point_text(machine, p)).collect::<Vec<_>>().join("; ")
}
