//! Size, location and form of features whose deviations are known.

use kinetostat_removal::split;
use nalgebra::Vector3;

/// Four walls of a pocket and its floor, with their outward normals, areas and what each is off by `of`.
fn pocket(of: impl Fn(&Vector3<f64>, usize) -> f64) -> Vec<(Vector3<f64>, f64, f64)> {
    let walls = [(Vector3::x(), 200.0), (-Vector3::x(), 200.0), (Vector3::y(), 300.0), (-Vector3::y(), 300.0)];
    let all = walls.into_iter().chain([(Vector3::z(), 600.0)]);
    let halves = all.flat_map(|(normal, area)| [0, 1].map(|half| (normal, area / 2.0, of(&normal, half))));
    halves.collect()
}

#[test]
fn a_pocket_that_is_small_and_beside_its_place_is_split() {
    let (offset, shift) = (0.03, Vector3::new(0.05, -0.02, 0.01));
    let found = split(pocket(|normal, _| offset + normal.dot(&shift)).into_iter()).unwrap();
    assert!((found.offset_mm - offset).abs() < 1e-12 && (found.shift_mm - shift).norm() < 1e-12, "{found:?}");
    assert!(found.form_mm < 1e-12, "{found:?}");
    // One half of each wall above, the other below.
    let wavy = split(pocket(|normal, half| offset + normal.dot(&shift) + [0.004, -0.004][half]).into_iter()).unwrap();
    assert!((wavy.form_mm - 0.008).abs() < 1e-12 && (wavy.shift_mm - shift).norm() < 1e-12, "{wavy:?}");
}

#[test]
fn a_plane_alone_is_off_by_its_size_and_form() {
    let floor = [(Vector3::z(), 1.0, 0.02), (Vector3::z(), 3.0, 0.06)];
    let found = split(floor.into_iter()).unwrap();
    assert!((found.offset_mm - 0.05).abs() < 1e-12 && found.shift_mm.norm() < 1e-12, "{found:?}");
    assert!((found.form_mm - 0.04).abs() < 1e-12, "{found:?}");
    assert_eq!(split(floor[..0].iter().copied()), None);
}
