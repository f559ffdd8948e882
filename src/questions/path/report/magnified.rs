//! The wanted and the real path in one drawing, deviations magnified and coloured by their size.

use nalgebra::Vector3;

use crate::{
    figures::{Figure, Look, PlanFigure, PlanShape, amplification::amplification},
    files::words::{counted, millimetres},
    questions::path::PathStudy,
};

const AXES: [&str; 3] = ["x", "y", "z"];

/// A point of the path that is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    /// Its index.
    pub point: usize,
    /// Where the point put right is off, mm; `None` where nothing settles.
    pub displacement: Option<Vector3<f64>>,
}

/// The drawing; `worst` is the point of the path with the largest displacement, and that, if any is solved.
pub(super) fn figure(
    study: &PathStudy,
    drawn: &[Moved],
    worst: Option<(usize, Vector3<f64>)>,
    is_circle: bool,
) -> Figure {
    let wanted = study.wanted();
    let [across, up, along] = view(&wanted);
    let factor = amplification_in(&wanted, [across, up], worst.map_or(0.0, |(_, largest)| largest.norm()));
    let flat = |p: Vector3<f64>| (p[across], p[up]);
    let mut coloured: Vec<Vec<(f64, f64, f64)>> = vec![Vec::new()];
    for moved in drawn {
        match moved.displacement {
            Some(displacement) => {
                let (x, y) = flat(wanted[moved.point] + displacement * factor);
                coloured.last_mut().into_iter().for_each(|piece| piece.push((x, y, displacement.norm())));
            }
            None => coloured.push(Vec::new()),
        }
    }
    coloured.retain(|piece| !piece.is_empty());
    let thinned = match drawn.len() {
        all if all == wanted.len() => String::new(),
        some => format!(", {some} of them drawn"),
    };
    let mark = |(farthest, largest): (usize, Vector3<f64>)| {
        let (x, y) = flat(wanted[farthest] + largest * factor);
        let station = &study.stations[farthest];
        let angle =
            station.phi_deg.filter(|_| is_circle).map_or_else(String::new, |phi| format!("\ntool angle {phi:.0}°"));
        (x, y, format!("worst {}\n{:.1} mm along{angle}", millimetres(largest.norm(), 3), station.arc_length_mm))
    };
    Figure::Plan(Box::new(PlanFigure {
        title: "Where the tool goes without compensation".into(),
        subtitle: format!(
            "{}, {}{thinned}, seen along {}; thin: wanted",
            study.machine.short_title(),
            counted(study.stations.len(), "point"),
            AXES[along]
        ),
        x_label: format!("{} [mm]", AXES[across]),
        y_label: format!("{} [mm]", AXES[up]),
        quantity: "distance from the wanted path [mm]".into(),
        field: None,
        shapes: vec![PlanShape {
            look: Look::Wanted,
            points: drawn.iter().map(|moved| flat(wanted[moved.point])).collect(),
            label: String::new(),
        }],
        coloured,
        marks: worst.map(mark).into_iter().collect(),
        note: match worst {
            Some(_) => {
                format!("deviations drawn {factor} times as large; those along {} show in the colour only", AXES[along])
            }
            None => "nothing of the path is solved".into(),
        },
    }))
}

/// The axes to the right, upward and along the view in which the path spreads most; along z where that hides no more than
/// another.
fn view(wanted: &[Vector3<f64>]) -> [usize; 3] {
    let extent = |axis: usize| {
        let (low, high) = wanted.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[axis]), h.max(p[axis])));
        high - low
    };
    let hidden = [2, 1, 0].into_iter().reduce(|a, b| if extent(b) < 0.999 * extent(a) { b } else { a }).unwrap_or(2);
    match hidden {
        0 => [1, 2, 0],
        1 => [0, 2, 1],
        _ => [0, 1, 2],
    }
}

/// As [`amplification`], which looks at x and y.
fn amplification_in(wanted: &[Vector3<f64>], [across, up]: [usize; 2], largest: f64) -> f64 {
    let turned: Vec<Vector3<f64>> = wanted.iter().map(|p| Vector3::new(p[across], p[up], 0.0)).collect();
    amplification(&turned, largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_seen_along_the_axis_in_which_it_spreads_least() {
        let path = |x: f64, y: f64, z: f64| [Vector3::zeros(), Vector3::new(x, y, z)];
        assert_eq!(view(&path(10.0, 10.0, 0.0)), [0, 1, 2]);
        assert_eq!(view(&path(10.0, 0.0, 10.0)), [0, 2, 1]);
        assert_eq!(view(&path(0.0, 10.0, 10.0)), [1, 2, 0]);
        assert_eq!(view(&path(10.0, 0.0, 0.0)), [0, 1, 2]);
    }
}
