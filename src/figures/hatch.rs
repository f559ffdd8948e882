//! Slanted lines over a convex polygon.

use super::scene::Point;

/// The pieces, rising to the right, of lines `pitch` apart that lie within the convex polygon of `corners` in turn.
pub(super) fn hatched(corners: &[Point], pitch: f64) -> Vec<[Point; 2]> {
    // Of a point on a line, x and y add up to the number of the line.
    let sums = || corners.iter().map(|[x, y]| x + y);
    let (low, high) = sums().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return Vec::new();
    }
    let first = (low / pitch).ceil() as i64;
    let last = (high / pitch).ceil() as i64 - 1;
    let line = |k: i64| {
        let sum = k as f64 * pitch;
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        let mut crossings: Vec<Point> = sides
            .filter_map(|(a, b)| {
                let (from, to) = (a[0] + a[1] - sum, b[0] + b[1] - sum);
                let share = from / (from - to);
                ((from < 0.0) != (to < 0.0)).then(|| [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])])
            })
            .collect();
        crossings.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Some([*crossings.first()?, *crossings.get(1)?])
    };
    (first..=last).filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_the_border() {
        let square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        assert_eq!(hatched(&square, 5.0)[0], [[0.0, 5.0], [5.0, 0.0]]);
        assert_eq!(hatched(&square, 5.0).len(), 3);
        assert!(hatched(&[], 5.0).is_empty());
    }
}
