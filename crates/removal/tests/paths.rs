//! Paths cut in short moves, as programs are.

use kinetostat_removal::{Cutter, Engagement, Field, RemovalError, Slicing, Stock};
use nalgebra::{Rotation2, Vector2, Vector3};

/// A turn about z and a shift in the plan, applied to whole cases.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    pub turn: f64,
    pub shift: Vector2<f64>,
}

impl Placed {
    pub fn at(&self, x: f64, y: f64, z: f64) -> Vector3<f64> {
        let turned = Rotation2::new(self.turn) * Vector2::new(x, y) + self.shift;
        Vector3::new(turned.x, turned.y, z)
    }
}

/// A large block with its top at z = 0, whose sides no case reaches.
pub fn block() -> Stock {
    Stock::cuboid(Vector3::new(-40.0, -40.0, -30.0), Vector3::new(40.0, 40.0, 0.0)).unwrap()
}

/// Cuts along a path through `points` in moves of at most `step`, and shows the engagement in the middle of each with its length. Returns the
/// sum of engaged volumes.
pub fn cut_path(
    field: &mut Field,
    cutter: &Cutter,
    points: &[Vector3<f64>],
    step: f64,
    slicing: &Slicing,
    mut see: impl FnMut(&Vector3<f64>, &Engagement),
) -> f64 {
    let mut engagement = Engagement::default();
    let mut volume = 0.0;
    for (leg, ends) in points.windows(2).enumerate() {
        let along = ends[1] - ends[0];
        let count = (along.norm() / step).ceil().max(1.0);
        for number in 0..count as u32 {
            let at = |share: f64| ends[0] + along * (share / count);
            let middle = at(f64::from(number) + 0.5);
            field.engage(cutter, &middle, &along, slicing, &mut engagement).unwrap();
            see(&middle, &engagement);
            volume += engagement.volume_per_mm * along.norm() / count;
            cut(field, cutter, &at(f64::from(number)), &at(f64::from(number + 1)), leg as u32).unwrap();
        }
    }
    volume
}

/// Cuts one move.
pub fn cut(
    field: &mut Field,
    cutter: &Cutter,
    from: &Vector3<f64>,
    to: &Vector3<f64>,
    tag: u32,
) -> Result<bool, RemovalError> {
    field.cut(cutter, from, to, tag)
}

/// Cuts along a path in moves of at most `step` without looking.
pub fn cut_only(field: &mut Field, cutter: &Cutter, points: &[Vector3<f64>], step: f64) {
    for ends in points.windows(2) {
        let along = ends[1] - ends[0];
        let count = (along.norm() / step).ceil().max(1.0);
        for number in 0..count as u32 {
            let at = |share: f64| ends[0] + along * (share / count);
            cut(field, cutter, &at(f64::from(number)), &at(f64::from(number + 1)), 0).unwrap();
        }
    }
}

/// A full circle about (x, y) in chords, counter-clockwise, from the angle `start`.
pub fn circle(placed: &Placed, [x, y]: [f64; 2], radius: f64, z: f64, start: f64, chords: u32) -> Vec<Vector3<f64>> {
    (0..=chords)
        .map(|chord| {
            let angle = start + std::f64::consts::TAU * f64::from(chord) / f64::from(chords);
            placed.at(x + radius * angle.cos(), y + radius * angle.sin(), z)
        })
        .collect()
}
