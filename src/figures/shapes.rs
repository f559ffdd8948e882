//! Geometry of lines: hatching of a polygon, level lines of a map, and lines thinned to fewer points that look the same.

use super::drawing::Point;

/// Returns the corners, in order around it, of the smallest convex polygon around `points` (Andrew's monotone chain).
pub fn hull(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    points.dedup();
    let turn = |a: (f64, f64), b: (f64, f64), c: (f64, f64)| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    let half = |points: &mut dyn Iterator<Item = (f64, f64)>| {
        let mut chain: Vec<(f64, f64)> = Vec::new();
        for point in points {
            while chain.len() > 1 && turn(chain[chain.len() - 2], chain[chain.len() - 1], point) <= 0.0 {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    if points.len() < 3 {
        return points;
    }
    let (mut lower, upper) = (half(&mut points.iter().copied()), half(&mut points.iter().rev().copied()));
    lower.extend(upper);
    lower
}

/// Returns the parts within a convex polygon of hatching lines that rise to the right, `pitch` pixels apart; `corners` are in turn.
pub fn hatching_lines(corners: &[Point], pitch: f64) -> Vec<[Point; 2]> {
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

/// Returns the parts of hatching lines that rise to the right, `pitch` pixels apart, on which a map is above 0, linear between its nodes. `values` are in rows, y outer;
/// the map has its upper left and lower right node at the points `from` and `to` of the page.
pub fn hatching_beyond(
    x: &[f64],
    y: &[f64],
    values: &[Option<f64>],
    [from, to]: [Point; 2],
    pitch: f64,
) -> Vec<[Point; 2]> {
    let place = |nodes: &[f64], share: f64| {
        let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
        let at = first + share * (last - first);
        let cell = nodes.partition_point(|node| *node <= at).clamp(1, (nodes.len() - 1).max(1)) - 1;
        let next = (cell + 1).min(nodes.len() - 1);
        (cell, next, if next > cell { (at - nodes[cell]) / (nodes[next] - nodes[cell]) } else { 0.0 })
    };
    let (width, height) = (to[0] - from[0], to[1] - from[1]);
    let value = |[px, py]: Point| {
        let (column, right, across) = place(x, (px - from[0]) / width);
        let (row, upper, up) = place(y, (to[1] - py) / height);
        let at = |row: usize, column: usize| values[row * x.len() + column];
        let along = |row: usize| Some(at(row, column)? * (1.0 - across) + at(row, right)? * across);
        Some(along(row)? * (1.0 - up) + along(upper)? * up)
    };
    let mut out = Vec::new();
    for [a, b] in hatching_lines(&[from, [to[0], from[1]], to, [from[0], to[1]]], pitch) {
        let steps = ((b[0] - a[0]).abs() / STEP).ceil().max(1.0) as usize;
        let point = |k: usize| [0, 1].map(|i| a[i] + (b[i] - a[i]) * k as f64 / steps as f64);
        let mut start: Option<Point> = None;
        let mut before: Option<(Point, f64)> = None;
        for k in 0..=steps {
            let (here, own) = (point(k), value(point(k)).unwrap_or(-1.0));
            let crossing = before.map_or(here, |(there, other)| {
                let share = other / (other - own);
                if share.is_finite() { [0, 1].map(|i| there[i] + share * (here[i] - there[i])) } else { here }
            });
            match start {
                None if own > 0.0 => start = Some(if before.is_some() { crossing } else { here }),
                Some(begin) if own <= 0.0 => {
                    out.push([begin, crossing]);
                    start = None;
                }
                _ => {}
            }
            before = Some((here, own));
        }
        out.extend(start.map(|begin| [begin, b]));
    }
    out
}

/// Distance in x of the points at which a hatching line is held against the map, in pixels.
const STEP: f64 = 4.0;

/// Returns the segments of the line on which the map has the value `level`, by linear interpolation along the edges of the grid, in the
/// coordinates of its nodes. `values` are in rows, y outer; cells with a missing corner have no line.
pub fn contour(x: &[f64], y: &[f64], values: &[Option<f64>], level: f64) -> Vec<[(f64, f64); 2]> {
    let mut pieces = Vec::new();
    for row in 1..y.len() {
        for column in 1..x.len() {
            let at = |r: usize, c: usize| values[r * x.len() + c].map(|value| (x[c], y[r], value - level));
            let corners = [at(row - 1, column - 1), at(row - 1, column), at(row, column), at(row, column - 1)];
            if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                add_cell_contour([a, b, c, d], &mut pieces);
            }
        }
    }
    pieces
}

/// Adds the segments of the level line within one cell; corners are (x, y, value − level), in turn around it.
fn add_cell_contour(corners: [(f64, f64, f64); 4], pieces: &mut Vec<[(f64, f64); 2]>) {
    let is_above = |k: usize| corners[k % 4].2 >= 0.0;
    let crossing = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        let share = a.2 / (a.2 - b.2);
        (a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1))
    };
    let crossed: Vec<usize> = (0..4).filter(|k| is_above(*k) != is_above(k + 1)).collect();
    match crossed[..] {
        [first, second] => pieces.push([crossing(first), crossing(second)]),
        [_, _, _, _] => {
            // A saddle: the line goes around the corners that the middle does not side with.
            let middle = corners.iter().map(|corner| corner.2).sum::<f64>() >= 0.0;
            let around = if middle == is_above(0) { [[0, 1], [2, 3]] } else { [[3, 0], [1, 2]] };
            pieces.extend(around.map(|edges| edges.map(crossing)));
        }
        _ => {}
    }
}

/// Largest distance in pixels of a removed point from the line.
const UNSEEN: f64 = 0.4;

/// Returns a line without the points whose absence does not show (Ramer, Douglas and Peucker).
///
/// Source: D. H. Douglas, T. K. Peucker, Cartographica 10(2), 1973.
pub fn simplify_line(points: &[Point]) -> Vec<Point> {
    let Some(last) = points.len().checked_sub(1).filter(|last| *last > 1) else { return points.to_vec() };
    let mut is_kept = vec![false; points.len()];
    (is_kept[0], is_kept[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop() {
        let distances = (from + 1..to).map(|k| (k, segment_distance(points[k], points[from], points[to])));
        let farthest = distances.fold((from, UNSEEN), |most, next| if next.1 > most.1 { next } else { most });
        if farthest.0 != from {
            is_kept[farthest.0] = true;
            open.extend([(from, farthest.0), (farthest.0, to)]);
        }
    }
    points.iter().zip(is_kept).filter_map(|(point, is_kept)| is_kept.then_some(*point)).collect()
}

/// Returns the distance of a point from the segment between `from` and `to`.
fn segment_distance(point: Point, from: Point, to: Point) -> f64 {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let square = dx * dx + dy * dy;
    let along = ((point[0] - from[0]) * dx + (point[1] - from[1]) * dy) / square.max(f64::MIN_POSITIVE);
    let share = along.clamp(0.0, 1.0);
    let offset = [point[0] - from[0] - share * dx, point[1] - from[1] - share * dy];
    (offset[0] * offset[0] + offset[1] * offset[1]).sqrt()
}
