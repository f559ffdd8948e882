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
