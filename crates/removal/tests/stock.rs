//! Meshes as stock against the same stock in closed form, and what is refused.

use std::f64::consts::{PI, TAU};

use kinetostat_removal::{Cutter, Field, RemovalError, Slicing, Stock};
use nalgebra::Vector3;

use crate::paths::{cut_only, cut_path};

/// A prism over a polygon, its caps as fans about the first corner.
fn prism(polygon: &[[f64; 2]], bottom: f64, top: f64) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let n = polygon.len() as u32;
    let ring = |z: f64| polygon.iter().map(move |p| Vector3::new(p[0], p[1], z));
    let vertices = ring(bottom).chain(ring(top)).collect();
    let mut triangles = Vec::new();
    for k in 0..n {
        let next = (k + 1) % n;
        triangles.extend([[k, next, n + next], [k, n + next, n + k]]);
        if k > 0 && next > 0 {
            triangles.extend([[0, next, k], [n, n + k, n + next]]);
        }
    }
    (vertices, triangles)
}

const SQUARE: [[f64; 2]; 4] = [[-20.0, -15.0], [20.0, -15.0], [20.0, 15.0], [-20.0, 15.0]];

#[test]
fn a_box_of_triangles_is_a_box() {
    let (vertices, triangles) = prism(&SQUARE, -10.0, 0.0);
    let mesh = Stock::mesh(vertices, triangles).unwrap();
    let closed = Stock::cuboid(Vector3::new(-20.0, -15.0, -10.0), Vector3::new(20.0, 15.0, 0.0)).unwrap();
    let cutter = Cutter::bull(10.0, 2.0).unwrap();
    let path = [Vector3::new(-30.0, -13.0, -3.0), Vector3::new(10.0, 4.0, -3.0), Vector3::new(25.0, 8.0, -6.0)];
    let [a, b] = [mesh, closed].map(|stock| {
        let mut field = Field::new(stock, 0.25).unwrap();
        let mut seen = Vec::new();
        let volume = cut_path(&mut field, &cutter, &path, 0.5, &Slicing::default(), |_, engagement| {
            seen.push((engagement.depth_mm, engagement.arcs.clone()));
        });
        (volume, field.volumes(), seen)
    });
    assert!(
        (a.0 - b.0).abs() < 1e-6
            && (a.1.stock_mm3 - 12000.0).abs() < 1e-6
            && (a.1.removed_mm3 - b.1.removed_mm3).abs() < 0.5
    );
    assert_eq!(a.2, b.2);
}

/// Two boxes in one file that overlap are their union, as the same union in one surface is.
#[test]
fn bodies_that_overlap_are_one() {
    let (mut vertices, mut triangles) = prism(&SQUARE, -10.0, 0.0);
    let (more, above) = prism(&[[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]], -5.0, 5.0);
    let shift = vertices.len() as u32;
    triangles.extend(above.iter().map(|triangle| triangle.map(|vertex| vertex + shift)));
    vertices.extend(more);
    let mut field = Field::new(Stock::mesh(vertices, triangles).unwrap(), 0.25).unwrap();
    assert!((field.volumes().stock_mm3 - (12000.0 + 500.0)).abs() < 1e-6, "{}", field.volumes().stock_mm3);
    let path = [Vector3::new(-30.0, 0.0, -8.0), Vector3::new(30.0, 0.0, -8.0)];
    cut_path(&mut field, &Cutter::flat(8.0).unwrap(), &path, 0.5, &Slicing::default(), |tip, engagement| {
        let depth = if tip.x > -4.0 && tip.x < 0.0 { 13.0 } else { 8.0 };
        if (-15.0..-10.0).contains(&tip.x) || (-4.0..0.0).contains(&tip.x) {
            assert!((engagement.depth_mm - depth).abs() < 1e-9, "{} at {}", engagement.depth_mm, tip.x);
        }
    });
}

#[test]
fn undercuts_are_kept_as_spans() {
    // A plate above another, with a gap between: two spans a column.
    let (mut vertices, mut triangles) = prism(&SQUARE, -10.0, -6.0);
    let (more, above) = prism(&SQUARE, -3.0, 0.0);
    let shift = vertices.len() as u32;
    triangles.extend(above.iter().map(|triangle| triangle.map(|vertex| vertex + shift)));
    vertices.extend(more);
    let mut field = Field::new(Stock::mesh(vertices, triangles).unwrap(), 0.25).unwrap();
    let cutter = Cutter::flat(8.0).unwrap();
    let path = [Vector3::new(-30.0, 0.0, -8.0), Vector3::new(0.0, 0.0, -8.0)];
    cut_path(&mut field, &cutter, &path, 0.5, &Slicing::default(), |tip, engagement| {
        if tip.x > -15.0 {
            assert!((engagement.depth_mm - 8.0).abs() < 1e-9);
            assert!((engagement.volume_per_mm - 5.0 * 8.0).abs() < 0.05, "{}", engagement.volume_per_mm);
            // Slices of 1 mm: none in the gap.
            assert_eq!(engagement.slices.len(), 5);
        }
    });
    let removed = field.volumes().removed_mm3;
    let expected = 5.0 * (20.0 * 8.0 + 8.0 * PI);
    assert!((removed / expected - 1.0).abs() < 2e-4, "{removed} {expected}");
}

#[test]
fn a_prism_of_many_sides_has_its_volume() {
    let polygon: Vec<_> =
        (0..97).map(|k| TAU * f64::from(k) / 97.0).map(|a| [17.0 * a.cos() + 0.1, 17.0 * a.sin()]).collect();
    let (vertices, triangles) = prism(&polygon, 0.0, 12.0);
    let mut field = Field::new(Stock::mesh(vertices, triangles).unwrap(), 0.5).unwrap();
    let area = 0.5 * 97.0 * 17.0 * 17.0 * (TAU / 97.0).sin();
    assert!((field.volumes().stock_mm3 / (12.0 * area) - 1.0).abs() < 1e-4);
    cut_only(
        &mut field,
        &Cutter::flat(50.0).unwrap(),
        &[Vector3::new(-50.0, 0.0, 7.0), Vector3::new(50.0, 0.0, 7.0)],
        1.0,
    );
    assert!((field.volumes().removed_mm3 / (5.0 * area) - 1.0).abs() < 1e-4);
}

/// Volume within closed surfaces by the divergence theorem: a third of the sum of place · area vector over their triangles.
fn enclosed_mm3(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|corner| move |own: &[u32; 3]| vertices[own[corner] as usize]);
    let part = |own| (a(own) + b(own) + c(own)).dot(&(b(own) - a(own)).cross(&(c(own) - a(own)))) / 18.0;
    triangles.iter().map(part).sum()
}

/// Corners, and the numbers of those of each triangle.
type Surface = (Vec<Vector3<f64>>, Vec<[u32; 3]>);

/// Joins meshes; of each whether its triangles are turned.
fn joined(parts: &[(Surface, bool)]) -> Surface {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for ((own, faces), is_turned) in parts {
        let shift = vertices.len() as u32;
        let order = if *is_turned { [0, 2, 1] } else { [0, 1, 2] };
        triangles.extend(faces.iter().map(|face| order.map(|corner| face[corner] + shift)));
        vertices.extend(own);
    }
    (vertices, triangles)
}

/// A surface within a body that faces it is a cavity: nothing is cut there, and the volume is that of the divergence theorem.
#[test]
fn a_cavity_is_a_void() {
    let tilted: Vec<_> = (0..7).map(|k| TAU * f64::from(k) / 7.0).map(|a| [8.0 * a.cos(), 8.0 * a.sin()]).collect();
    let island = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]];
    // A body in the cavity of a body.
    let parts =
        [(prism(&SQUARE, -10.0, 0.0), false), (prism(&tilted, -9.0, -1.0), true), (prism(&island, -7.0, -3.0), false)];
    let (vertices, triangles) = joined(&parts);
    let volume = enclosed_mm3(&vertices, &triangles);
    let closed = 12000.0 - 8.0 * 3.5 * 64.0 * (TAU / 7.0).sin() + 64.0;
    assert!((volume - closed).abs() < 1e-9 * closed, "{volume} {closed}");
    let mut field = Field::new(Stock::mesh(vertices, triangles).unwrap(), 0.25).unwrap();
    assert!((field.volumes().stock_mm3 / volume - 1.0).abs() < 1e-4, "{} {volume}", field.volumes().stock_mm3);
    let path = [Vector3::new(-60.0, 0.0, -20.0), Vector3::new(60.0, 0.0, -20.0)];
    cut_path(&mut field, &Cutter::flat(80.0).unwrap(), &path, 1.0, &Slicing::default(), |_, _| ());
    assert!((field.volumes().removed_mm3 / volume - 1.0).abs() < 1e-4, "{} {volume}", field.volumes().removed_mm3);
}

#[test]
fn a_surface_that_faces_the_wrong_way_is_refused() {
    let body = || prism(&SQUARE, -10.0, 0.0);
    let inner = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]];
    let beside = prism(&inner.map(|[x, y]| [x + 50.0, y]), -8.0, -2.0);
    for (parts, expected) in [
        (vec![(body(), true)], ", -10.000) mm: expected the corners of triangles counter-clockwise seen from outside"),
        (vec![(body(), false), (beside, true)], ", -8.000) mm: expected the corners of triangles"),
    ] {
        let (vertices, triangles) = joined(&parts);
        let found = Stock::mesh(vertices, triangles).unwrap_err().to_string();
        assert!(found.contains(expected), "{found}\ninstead of {expected}");
    }
}

#[test]
fn faults_are_named() {
    let (vertices, mut triangles) = prism(&SQUARE, 0.0, 1.0);
    let last = triangles.pop().unwrap();
    let open = Stock::mesh(vertices.clone(), triangles.clone()).unwrap_err();
    assert!(open.to_string().contains("open at the edge between vertices"), "{open}");
    triangles.push([last[0], last[1], 99]);
    let beyond = Stock::mesh(vertices.clone(), triangles.clone()).unwrap_err();
    assert!(beyond.to_string().contains("99"), "{beyond}");
    assert!(matches!(Stock::mesh(vertices, Vec::new()), Err(RemovalError::Mesh { .. })));
    assert!(matches!(Cutter::bull(10.0, 5.1), Err(RemovalError::Corner { .. })));
    assert!(matches!(Cutter::drill(10.0, 180.0), Err(RemovalError::PointAngle { .. })));
    assert!(matches!(Cutter::flat(f64::NAN), Err(RemovalError::NotPositive { .. })));
    assert!(matches!(Stock::cuboid(Vector3::zeros(), Vector3::x()), Err(RemovalError::EmptyBox { .. })));
    let large = Stock::cuboid(Vector3::zeros(), Vector3::new(1e3, 1e3, 1.0)).unwrap();
    assert!(matches!(Field::new(large.clone(), 1e-3), Err(RemovalError::TooManyColumns { .. })));
    // 1000 × 1000 columns of 44 bytes, and moves of 64.
    assert_eq!(Field::memory_bytes(&large, 1.0, 10).unwrap(), 44_000_000 + 640);
    let mut field = Field::new(large, 1.0).unwrap();
    let nowhere = Vector3::new(0.0, f64::INFINITY, 0.0);
    assert!(matches!(
        field.cut(&Cutter::flat(1.0).unwrap(), &nowhere, &nowhere, 0),
        Err(RemovalError::NotFinite { .. })
    ));
}
