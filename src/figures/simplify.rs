//! Lines with fewer points that look the same.

use super::scene::Point;

/// How far a left out point may lie from the line, in pixels.
const UNSEEN: f64 = 0.4;

/// The points of a line without those that do not show (Ramer, Douglas and Peucker).
///
/// Source: D. H. Douglas, T. K. Peucker, Cartographica 10(2), 1973.
pub(super) fn simplified(points: &[Point]) -> Vec<Point> {
    let Some(last) = points.len().checked_sub(1).filter(|last| *last > 1) else { return points.to_vec() };
    let mut is_kept = vec![false; points.len()];
    (is_kept[0], is_kept[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop() {
        let distances = (from + 1..to).map(|k| (k, distance(points[k], points[from], points[to])));
        let farthest = distances.fold((from, UNSEEN), |most, next| if next.1 > most.1 { next } else { most });
        if farthest.0 != from {
            is_kept[farthest.0] = true;
            open.extend([(from, farthest.0), (farthest.0, to)]);
        }
    }
    points.iter().zip(is_kept).filter_map(|(point, is_kept)| is_kept.then_some(*point)).collect()
}

/// From a point to the piece of line between two others.
fn distance(point: Point, from: Point, to: Point) -> f64 {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let square = dx * dx + dy * dy;
    let along = ((point[0] - from[0]) * dx + (point[1] - from[1]) * dy) / square.max(f64::MIN_POSITIVE);
    let share = along.clamp(0.0, 1.0);
    let off = [point[0] - from[0] - share * dx, point[1] - from[1] - share * dy];
    (off[0] * off[0] + off[1] * off[1]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_stay_and_points_on_the_way_go() {
        let line = [[0.0, 0.0], [5.0, 0.1], [10.0, 0.0], [10.0, 10.0], [10.2, 15.0], [10.0, 20.0]];
        assert_eq!(simplified(&line), [[0.0, 0.0], [10.0, 0.0], [10.0, 20.0]]);
        let closed = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 0.0]];
        assert_eq!(simplified(&closed), closed);
    }
}
