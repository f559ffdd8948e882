//! Stock given as a closed surface of triangles.

use std::collections::HashMap;

use nalgebra::{Vector2, Vector3};

use crate::error::{RemovalError, finite};

/// A closed surface of triangles, sorted into tiles of the plan.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mesh {
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// Tiles along x and y.
    tiles: [usize; 2],
    /// Where the triangles of each tile start in `listed`, and where those of the last one end.
    starts: Vec<u32>,
    /// Numbers of triangles, tile after tile.
    listed: Vec<u32>,
}

/// About how many triangles are looked at to see whether the surface faces outwards.
const MAX_LOOKED_AT: usize = 50_000;
/// Surfaces that touch may be the wrong way round by so much, mm: files round.
const HAIR_MM: f64 = 1e-3;

impl Mesh {
    pub fn new(vertices: Vec<Vector3<f64>>, triangles: Vec<[u32; 3]>) -> Result<Self, RemovalError> {
        for vertex in &vertices {
            finite("vertex of the mesh", vertex)?;
        }
        check_closed(&vertices, &triangles)?;
        let low = vertices.iter().skip(1).fold(vertices[0], |low, vertex| low.inf(vertex));
        let high = vertices.iter().skip(1).fold(vertices[0], |high, vertex| high.sup(vertex));
        let size = high - low;
        // About one triangle a tile of either orientation; a mesh without extent holds nothing.
        let tile = (size.x * size.y / triangles.len() as f64).sqrt();
        if !(tile > 0.0 && size.z > 0.0) {
            return Err(RemovalError::Mesh { fault: "it has no volume".to_owned() });
        }
        let count = |extent: f64| (extent / tile).ceil().clamp(1.0, 4096.0) as usize;
        let mut mesh = Self {
            tiles: [count(size.x), count(size.y)],
            vertices,
            triangles,
            low,
            high,
            starts: Vec::new(),
            listed: Vec::new(),
        };
        mesh.sort_into_tiles();
        mesh.check_sense()?;
        Ok(mesh)
    }

    pub fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        (self.low, self.high)
    }

    fn sort_into_tiles(&mut self) {
        let mut counts = vec![0_u32; self.tiles[0] * self.tiles[1] + 1];
        for triangle in &self.triangles {
            self.each_tile_of(triangle, |tile| counts[tile + 1] += 1);
        }
        for tile in 1..counts.len() {
            counts[tile] += counts[tile - 1];
        }
        let mut listed = vec![0; counts[counts.len() - 1] as usize];
        let mut next = counts.clone();
        for (number, triangle) in self.triangles.iter().enumerate() {
            self.each_tile_of(triangle, |tile| {
                listed[next[tile] as usize] = number as u32;
                next[tile] += 1;
            });
        }
        (self.starts, self.listed) = (counts, listed);
    }

    fn each_tile_of(&self, triangle: &[u32; 3], mut visit: impl FnMut(usize)) {
        let corners = self.corners(triangle).map(|corner| corner.xy());
        let low = corners[0].inf(&corners[1]).inf(&corners[2]);
        let high = corners[0].sup(&corners[1]).sup(&corners[2]);
        let ([x0, y0], [x1, y1]) = (self.tile_of(low), self.tile_of(high));
        for y in y0..=y1 {
            for x in x0..=x1 {
                visit(y * self.tiles[0] + x);
            }
        }
    }

    fn tile_of(&self, p: Vector2<f64>) -> [usize; 2] {
        [0, 1].map(|axis| {
            let share = (p[axis] - self.low[axis]) / (self.high[axis] - self.low[axis]);
            ((share * self.tiles[axis] as f64).max(0.0) as usize).min(self.tiles[axis] - 1)
        })
    }

    fn corners(&self, triangle: &[u32; 3]) -> [Vector3<f64>; 3] {
        triangle.map(|vertex| self.vertices[vertex as usize])
    }

    /// Fails where the surface winds backwards around a place: where that of a body faces inwards, or a cavity is in no body.
    fn check_sense(&self) -> Result<(), RemovalError> {
        let mut crossings = Vec::new();
        for triangle in self.triangles.iter().step_by(self.triangles.len() / MAX_LOOKED_AT + 1) {
            let [a, b, c] = self.corners(triangle);
            let centre = (a + b + c) / 3.0;
            crossings.clear();
            self.add_crossings(centre.xy(), &mut crossings);
            let mut winding = 0.0;
            for pair in crossings.windows(2) {
                let ([z, turn], [next, _]) = (pair[0], pair[1]);
                winding += turn;
                if winding < 0.0 && next - z > HAIR_MM {
                    let [x, y]: [f64; 2] = centre.xy().into();
                    let fault = format!(
                        "it faces inwards at ({x:.3}, {y:.3}, {z:.3}) mm: expected the corners of triangles counter-clockwise seen from outside"
                    );
                    return Err(RemovalError::Mesh { fault });
                }
            }
        }
        Ok(())
    }

    /// Appends the heights at which the vertical through `p` crosses the surface, rising, and whether it comes in there (1) or leaves (−1).
    fn add_crossings(&self, p: Vector2<f64>, crossings: &mut Vec<[f64; 2]>) {
        let [x, y] = self.tile_of(p);
        let (tile, first) = (y * self.tiles[0] + x, crossings.len());
        for &number in &self.listed[self.starts[tile] as usize..self.starts[tile + 1] as usize] {
            crossings.extend(crossing(&self.corners(&self.triangles[number as usize]), p));
        }
        crossings[first..].sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(b[1].total_cmp(&a[1])));
    }

    /// Appends the intervals of z that are inside over `p`.
    pub fn spans(&self, p: Vector2<f64>, spans: &mut Vec<[f64; 2]>) {
        if (0..2).any(|axis| !(p[axis] > self.low[axis] && p[axis] < self.high[axis])) {
            return;
        }
        let first = spans.len();
        self.add_crossings(p, spans);
        // Inside is what the surface winds around, so that where two bodies overlap there is material, and none in a cavity; it is closed, and each edge of the plan belongs to one side.
        let (mut winding, mut entry, mut end) = (0.0, 0.0, first);
        for k in first..spans.len() {
            let [height, turn] = spans[k];
            if winding == 0.0 {
                entry = height;
            }
            winding += turn;
            if winding == 0.0 {
                spans[end] = [entry, height];
                end += 1;
            }
        }
        spans.truncate(end);
    }

    /// Whether over a rectangle there is no edge of a triangle, and all of it has the same triangles, all level.
    pub fn is_uniform(&self, low: Vector2<f64>, high: Vector2<f64>) -> bool {
        let ([x0, y0], [x1, y1]) = (self.tile_of(low), self.tile_of(high));
        (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| y * self.tiles[0] + x)).all(|tile| {
            self.listed[self.starts[tile] as usize..self.starts[tile + 1] as usize].iter().all(|&number| {
                let [a, b, c] = self.corners(&self.triangles[number as usize]);
                a.z == b.z && b.z == c.z && {
                    let inside = |x, y| crossing(&[a, b, c], Vector2::new(x, y)).is_some();
                    inside(low.x, low.y) && inside(high.x, low.y) && inside(low.x, high.y) && inside(high.x, high.y)
                }
            })
        })
    }
}

/// Returns the height at which the vertical through `p` crosses a triangle, and whether it comes into the body there (1) or leaves it (−1) on its way
/// up; `None` if it passes beside. A vertical through an edge crosses one of the two triangles that share it: the sign of an edge is computed from
/// its ends in a fixed order, and zero counts as left of it.
fn crossing(corners: &[Vector3<f64>; 3], p: Vector2<f64>) -> Option<[f64; 2]> {
    let [a, b, c] = corners;
    let (w_c, w_a, w_b) = (side(a, b, p), side(b, c, p), side(c, a, p));
    let left = |value: f64, from: &Vector3<f64>, to: &Vector3<f64>| {
        if value != 0.0 { value > 0.0 } else { (from.x, from.y) < (to.x, to.y) }
    };
    let signs = [left(w_c, a, b), left(w_a, b, c), left(w_b, c, a)];
    if signs[0] != signs[1] || signs[1] != signs[2] {
        return None;
    }
    let sum = w_a + w_b + w_c;
    let turn = if signs[0] { -1.0 } else { 1.0 };
    (sum != 0.0).then(|| [(w_a * a.z + w_b * b.z + w_c * c.z) / sum, turn])
}

/// Twice the area of the triangle of an edge and `p`, with the same bits but the sign for the reversed edge.
fn side(from: &Vector3<f64>, to: &Vector3<f64>, p: Vector2<f64>) -> f64 {
    let swapped = (from.x, from.y) > (to.x, to.y);
    let (a, b) = if swapped { (to, from) } else { (from, to) };
    let area = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    if swapped { -area } else { area }
}

/// Fails unless each edge joins two triangles that run along it in opposite senses.
fn check_closed(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Result<(), RemovalError> {
    let fault = |fault: String| Err(RemovalError::Mesh { fault });
    if triangles.is_empty() || triangles.len() > u32::MAX as usize / 2 {
        return fault(format!("{} triangles", triangles.len()));
    }
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for (number, triangle) in triangles.iter().enumerate() {
        for corner in 0..3 {
            let (from, to) = (triangle[corner], triangle[(corner + 1) % 3]);
            if from as usize >= vertices.len() || from == to {
                return fault(format!("triangle {number} names vertices {triangle:?} of {}", vertices.len()));
            }
            *edges.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
        }
    }
    match edges.iter().filter(|edge| *edge.1 != 0).map(|edge| edge.0).min() {
        Some((from, to)) => {
            let [a, b] = [from, to].map(|own| <[f64; 3]>::from(vertices[*own as usize]));
            fault(format!("it is open at the edge between vertices {from} and {to}, at {a:?} and {b:?} mm"))
        }
        None => Ok(()),
    }
}
