//! Where labels stand: beside what they name, and on no other label.

use super::scene::{Point, Rect};

/// Directions in which a label may stand from its place, the likeliest first.
const DIRECTIONS: [Point; 16] = [
    [1.0, -0.6],
    [1.0, 0.6],
    [-1.0, -0.6],
    [-1.0, 0.6],
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, -1.0],
    [0.0, 1.0],
    [0.5, -1.0],
    [0.5, 1.0],
    [-0.5, -1.0],
    [-0.5, 1.0],
    [1.0, -0.3],
    [1.0, 0.3],
    [-1.0, -0.3],
    [-1.0, 0.3],
];
/// Distances from the place tried, in heights of the label.
const DISTANCES: [f64; 12] = [0.0, 0.4, 0.9, 1.5, 2.2, 3.0, 4.0, 5.2, 6.6, 8.2, 10.0, 12.0];
/// Beyond this distance a line leads from the place to its label.
const NEAR: f64 = 1.0;
/// What a pixel's worth of distance costs against a square pixel of covered lines.
const DISTANCE_COST: f64 = 30.0;

/// Where a label stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spot {
    pub rect: Rect,
    /// From its place, if it stands so far off that it needs a line to it.
    pub leader: Option<[Point; 2]>,
}

/// What labels keep clear of.
#[derive(Debug, Clone, Default)]
pub(super) struct Occupied {
    /// Labels and marks, which no label covers as long as there is room.
    pub marks: Vec<Rect>,
    /// Pieces of lines, which labels rather do not cover.
    pub lines: Vec<Rect>,
}

impl Occupied {
    /// Takes a line as a row of small squares.
    pub(crate) fn add_line(&mut self, points: &[Point], width: f64) {
        for pair in points.windows(2) {
            let [dx, dy] = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            let steps = ((dx * dx + dy * dy).sqrt() / (2.0 * width.max(4.0))).ceil().clamp(1.0, 400.0);
            let at = |k: f64| [pair[0][0] + dx * k / steps, pair[0][1] + dy * k / steps];
            self.lines.extend((0..=steps as usize).map(|k| around(at(k as f64), [width.max(4.0); 2])));
        }
    }

    /// The place for a label of half the size `half` that names what reaches `reach` around `at`: the nearest in `bounds`
    /// that covers no mark, and few lines. It is then occupied.
    pub(crate) fn place(&mut self, at: Point, reach: f64, half: [f64; 2], bounds: Rect) -> Spot {
        let height = 2.0 * half[1];
        let candidates = DISTANCES.iter().flat_map(|distance| DIRECTIONS.map(|direction| (*distance, direction)));
        let spot = |(distance, [dx, dy]): (f64, Point)| {
            let away = reach + 4.0 + distance * height;
            let centre = [at[0] + dx * (half[0] + away), at[1] + dy * (half[1] + away)];
            (distance, around(centre, half))
        };
        let cost = |&(distance, rect): &(f64, Rect)| {
            let outside = half[0] * half[1] * 4.0 - rect.overlap(&bounds);
            let covered: f64 = self.marks.iter().map(|other| rect.overlap(other)).sum();
            let lines: f64 = self.lines.iter().map(|other| rect.overlap(other)).sum();
            1e4 * outside.max(0.0) + 1e4 * covered + lines + DISTANCE_COST * distance * height
        };
        let mut best = spot((0.0, DIRECTIONS[0]));
        let mut least = cost(&best);
        for candidate in candidates.map(spot) {
            let cost = cost(&candidate);
            if cost < least - 1e-6 {
                (best, least) = (candidate, cost);
            }
        }
        let (distance, rect) = best;
        self.marks.push(rect);
        let nearest = [at[0].clamp(rect.x, rect.right()), at[1].clamp(rect.y, rect.bottom())];
        Spot { rect, leader: (distance > NEAR).then_some([at, nearest]) }
    }
}

/// The rectangle of half the size `half` around a place.
pub(super) fn around(centre: Point, half: [f64; 2]) -> Rect {
    Rect { x: centre[0] - half[0], y: centre[1] - half[1], width: 2.0 * half[0], height: 2.0 * half[1] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_points_that_crowd_do_not_cover_each_other() {
        let page = Rect { x: 0.0, y: 0.0, width: 1600.0, height: 1200.0 };
        let points: Vec<Point> =
            (0..12).map(|k| [800.0 + f64::from(k % 4) * 9.0, 600.0 + f64::from(k / 4) * 7.0]).collect();
        let mut occupied =
            Occupied { marks: points.iter().map(|p| around(*p, [19.0; 2])).collect(), ..Occupied::default() };
        let spots: Vec<Rect> = points.iter().map(|p| occupied.place(*p, 19.0, [60.0, 24.0], page).rect).collect();
        for (k, spot) in spots.iter().enumerate() {
            assert!(spots[..k].iter().all(|other| other.overlap(spot) == 0.0), "{k}");
            assert!(points.iter().all(|p| around(*p, [19.0; 2]).overlap(spot) == 0.0), "{k}");
            assert!((spot.overlap(&page) - spot.width * spot.height).abs() < 1e-6, "{k}");
        }
    }
}
