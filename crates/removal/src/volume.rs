//! Volumes of a field.

use nalgebra::Vector2;

use crate::field::{Column, Field};

/// Points in a cell that is not smooth: a Fibonacci lattice, whose points all differ in x and in y, so that a wall along an axis errs by no more
/// than 1/178 of a cell.
const POINTS: u32 = 89;
const POINTS_ACROSS: u32 = 55;
/// A cell bends smoothly if its height leaves the line through its neighbours by less than this share of a cell.
const SMOOTH: f64 = 0.05;

/// Volumes of a field, mm³.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Volumes {
    /// Of the stock before any cut.
    pub stock_mm3: f64,
    /// Of what was removed.
    pub removed_mm3: f64,
}

impl Field {
    /// Returns the volumes of stock and of what was removed. Cells in which the surface is smooth count with their height in the middle and its
    /// second differences, others, as those with walls and rims, with points at which the surface is evaluated from its lines.
    #[must_use]
    pub fn volumes(&self) -> Volumes {
        let mut spans = Vec::new();
        let mut volumes = Volumes::default();
        for y in 0..self.grid.count[1] {
            for x in 0..self.grid.count[0] {
                self.add_cell(x, y, &mut spans, &mut volumes);
            }
        }
        let area = self.grid.size.x * self.grid.size.y;
        Volumes { stock_mm3: volumes.stock_mm3 * area, removed_mm3: volumes.removed_mm3 * area }
    }

    fn add_cell(&self, x: u32, y: u32, spans: &mut Vec<[f64; 2]>, volumes: &mut Volumes) {
        let centre = self.grid.centre(x, y);
        let half = 0.5 * self.grid.size;
        if self.stock.is_uniform(centre - half, centre + half)
            && let Some(height) = self.smooth_height(x, y)
        {
            self.add_point(centre, height, 1.0, spans, volumes);
            return;
        }
        for number in 0..POINTS {
            let share = |number: u32| (f64::from(number) + 0.5) / f64::from(POINTS) - 0.5;
            let offset = Vector2::new(share(number), share(number * POINTS_ACROSS % POINTS));
            let p = centre + offset.component_mul(&self.grid.size);
            self.add_point(p, self.floor(p).height, 1.0 / f64::from(POINTS), spans, volumes);
        }
    }

    fn add_point(&self, p: Vector2<f64>, height: f64, share: f64, spans: &mut Vec<[f64; 2]>, volumes: &mut Volumes) {
        spans.clear();
        self.stock.spans(p, spans);
        for span in spans {
            volumes.stock_mm3 += share * (span[1] - span[0]);
            volumes.removed_mm3 += share * (span[1] - span[0].max(height)).max(0.0);
        }
    }

    /// Returns the mean of H over a cell in which it is smooth; `None` where it is not sure to be.
    fn smooth_height(&self, x: u32, y: u32) -> Option<f64> {
        let at = |dx: i64, dy: i64| -> Option<&Column> {
            let [cx, cy] = [i64::from(x) + dx, i64::from(y) + dy];
            let inside = cx >= 0 && cy >= 0 && cx < i64::from(self.grid.count[0]) && cy < i64::from(self.grid.count[1]);
            inside.then(|| &self.columns[self.grid.index(cx as u32, cy as u32)])
        };
        let column = at(0, 0)?;
        let mut bends = [0.0; 4];
        for (bend, (dx, dy)) in bends.iter_mut().zip([(1, 0), (0, 1), (1, 1), (1, -1)]) {
            // Beside the field there is no stock, and nothing is known of it.
            let (before, after) = (at(-dx, -dy)?, at(dx, dy)?);
            if before.is_uncut() != column.is_uncut() || after.is_uncut() != column.is_uncut() {
                return None;
            }
            *bend = f64::from(before.height()) - 2.0 * f64::from(column.height()) + f64::from(after.height());
        }
        if column.is_uncut() {
            return Some(f64::INFINITY);
        }
        // Half a diagonal: the whole cell is inside what its lowest move cut.
        let inside = f64::from(column.margin()) >= 0.71 * self.grid.size.max() * self.grid.margin_scale();
        let smooth = bends.iter().all(|bend| bend.abs() < SMOOTH * self.grid.size.max());
        (inside && smooth).then(|| self.datum + f64::from(column.height()) + (bends[0] + bends[1]) / 24.0)
    }
}
