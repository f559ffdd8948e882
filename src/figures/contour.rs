//! Level lines of a field over a grid.

/// Pieces of the line on which the field equals `level`, in the coordinates of the nodes, by linear interpolation along the
/// edges of the grid. `values` are row-major, y outer; cells with a missing corner carry no line.
pub(super) fn contour(x: &[f64], y: &[f64], values: &[Option<f64>], level: f64) -> Vec<[(f64, f64); 2]> {
    let mut pieces = Vec::new();
    for row in 1..y.len() {
        for column in 1..x.len() {
            let at = |r: usize, c: usize| values[r * x.len() + c].map(|value| (x[c], y[r], value - level));
            let corners = [at(row - 1, column - 1), at(row - 1, column), at(row, column), at(row, column - 1)];
            if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                in_cell([a, b, c, d], &mut pieces);
            }
        }
    }
    pieces
}

/// The pieces within a cell of corners (x, y, value less level) in turn around it.
fn in_cell(corners: [(f64, f64, f64); 4], pieces: &mut Vec<[(f64, f64); 2]>) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_a_plane_is_straight_and_stops_at_missing_nodes() {
        let (x, y) = ([0.0, 1.0, 2.0, 4.0], [0.0, 2.0, 3.0]);
        let mut values: Vec<Option<f64>> = y.iter().flat_map(|y| x.map(|x| Some(x + y))).collect();
        let pieces = contour(&x, &y, &values, 2.5);
        assert!(!pieces.is_empty());
        assert!(pieces.iter().flatten().all(|(x, y)| (x + y - 2.5).abs() < 1e-12), "{pieces:?}");
        let length = |pieces: &[[(f64, f64); 2]]| pieces.iter().map(|[a, b]| (a.0 - b.0).hypot(a.1 - b.1)).sum::<f64>();
        assert!((length(&pieces) - 2.5 * 2f64.sqrt()).abs() < 1e-12);
        // The cell of the missing node holds the line from (0.5, 2) to (1, 1.5).
        values[0] = None;
        assert!((length(&contour(&x, &y, &values, 2.5)) - 2.0 * 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_saddle_gives_two_pieces_around_the_corners_off_the_middle() {
        let values = [1.0, -1.0, -1.0, 2.0].map(Some);
        let pieces = contour(&[0.0, 1.0], &[0.0, 1.0], &values, 0.0);
        assert_eq!(pieces[0], [(0.5, 0.0), (1.0, 1.0 / 3.0)]);
        assert_eq!(pieces.len(), 2);
        assert_eq!(contour(&[0.0, 1.0], &[0.0, 1.0], &values.map(|v| v.map(|v| -v)), 0.0).len(), 2);
    }
}
