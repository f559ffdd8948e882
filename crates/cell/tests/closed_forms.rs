//! Distances that are known, and motions between two samples.

use kinetostat_cell::{Ball, Body, BodyGrade, Cell, Motion, Shape, SweepOptions, pieces_of_mesh};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

fn cuboid(size: [f64; 3]) -> Shape {
    Shape::Cuboid { pose: Isometry3::identity(), size_mm: size.into() }
}

fn rod(radius: f64) -> Shape {
    Shape::Capsule { ends_mm: [Point3::new(0.0, 0.0, -50.0), Point3::new(0.0, 0.0, 50.0)], radius_mm: radius }
}

fn two(a: Shape, b: Shape) -> Cell {
    let bodies =
        vec![Body::new("a", 0, BodyGrade::Given, &[a]).unwrap(), Body::new("b", 1, BodyGrade::Given, &[b]).unwrap()];
    Cell::new(bodies, |_, _| false)
}

fn distance(a: Shape, b: Shape, at: [f64; 3]) -> f64 {
    let poses = [Isometry3::identity(), Isometry3::translation(at[0], at[1], at[2])];
    two(a, b).nearest(&poses).unwrap().distance_mm
}

#[test]
fn boxes_rods_and_cylinders() {
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    near(distance(cuboid([10.0; 3]), cuboid([10.0; 3]), [20.0, 0.0, 0.0]), 10.0);
    near(distance(cuboid([10.0; 3]), cuboid([10.0; 3]), [13.0, 14.0, 0.0]), 5.0);
    near(distance(cuboid([10.0; 3]), cuboid([10.0; 3]), [8.0, 1.0, 0.5]), -2.0);
    near(distance(cuboid([100.0; 3]), cuboid([10.0; 3]), [1.0, 2.0, 40.0]), -15.0);
    near(distance(rod(3.0), rod(4.0), [10.0, 0.0, 20.0]), 3.0);
    near(distance(rod(3.0), rod(4.0), [5.0, 0.0, 20.0]), -2.0);
    let cylinder =
        || Shape::Cylinder { ends_mm: [Point3::new(0.0, 0.0, 0.0), Point3::new(0.0, 0.0, 100.0)], radius_mm: 30.0 };
    near(distance(cylinder(), cylinder(), [80.0, 0.0, 10.0]), 20.0);
    near(distance(cylinder(), cuboid([10.0; 3]), [0.0, 0.0, 120.0]), 15.0);
    near(distance(cylinder(), cuboid([10.0; 3]), [0.0, 0.0, 104.0]), -1.0);
}

#[test]
fn faces_that_are_aligned_but_for_rounding() {
    let pose = |at: [f64; 3], [w, i, j, k]: [f64; 4]| {
        let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, i, j, k));
        Isometry3::from_parts(Translation3::from(Vector3::from(at)), turn)
    };
    let gap = |a: Shape, b: Shape, poses: &[Isometry3<f64>; 2]| two(a, b).nearest(poses).unwrap().distance_mm;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // Each lies along the middle of the other.
    let along = Shape::Capsule { ends_mm: [-30.0, 30.0].map(|end| Point3::new(0.0, 0.0, end)), radius_mm: 10.0 };
    let found =
        gap(along, cuboid([100.0, 80.0, 60.0]), &[Isometry3::identity(), pose([0.0; 3], [half, half, 0.0, 0.0])]);
    assert!((found + 40.0).abs() < 1e-6, "{found}");
    let turned = [
        pose([0.0, 0.0, 81.25], [0.9998965964968352, 0.0, 0.0, -0.01438041425150814]),
        pose(
            [-1.8869909861331178, -65.58940405078162, 81.25],
            [0.4927580911226636, 0.5071385053741718, 0.49275809112266356, -0.5071385053741717],
        ),
    ];
    let [large, small] =
        [[181.00689655172414, 144.8055172413793, 162.5], [20.34602364351444, 133.69322205035536, 26.569883954770784]];
    let found = gap(cuboid(large), cuboid(small), &turned);
    assert!((found + 20.0711580).abs() < 1e-6, "{found}");
    // A clamp flush with the side of a part, both turned.
    let turn = [0.9366721892483976, 0.0, 0.0, -0.35020738125946743];
    let flush = [[21.0, 75.0, -28.0], [43.64128740668316, 55.31822913028478, -28.0]].map(|at| pose(at, turn));
    let found = gap(cuboid([30.0, 170.0, 40.0]), cuboid([30.0, 40.0, 40.0]), &flush);
    assert!(found.abs() < 1e-9, "{found}");
}

struct Straight {
    from: Vector3<f64>,
    to: Vector3<f64>,
    turn: f64,
}

impl Motion for Straight {
    fn poses(&mut self, s: f64, poses: &mut [Isometry3<f64>]) -> Result<(), String> {
        poses[1] = Isometry3::from_parts(
            Translation3::from(self.from.lerp(&self.to, s)),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.turn * s),
        );
        Ok(())
    }

    fn speed(&mut self, frame: usize, ball: &Ball, _: [f64; 2]) -> f64 {
        if frame == 0 {
            return 0.0;
        }
        (self.to - self.from).norm() + self.turn.abs() * (ball.centre_mm.coords.xy().norm() + ball.radius_mm)
    }
}

#[test]
fn cylinders_in_any_direction_end_at_their_caps() {
    // A thin one on the axis of a wide one, or beside it, ahead of its cap or in it: the cap is nearest.
    for k in 0..2000 {
        let turns = [0.37, 0.71, 0.13].map(|by: f64| std::f64::consts::TAU * (by * f64::from(k)).fract());
        let turn = UnitQuaternion::from_euler_angles(turns[0], turns[1], turns[2]);
        let ends = |low: f64, high: f64, beside: f64| {
            [low, high].map(|end| turn * Point3::new(beside, 0.0, end) + Vector3::new(100.0, -20.0, 7.0))
        };
        for (gap, beside) in [(5.0, 0.0), (5.0, 12.0), (-5.0, 0.0), (-5.0, 12.0)] {
            let wide = Shape::Cylinder { ends_mm: ends(-70.0, 0.0, 0.0), radius_mm: 60.0 };
            let thin = Shape::Cylinder { ends_mm: ends(gap, gap + 57.0, beside), radius_mm: 3.0 };
            let found = distance(wide, thin, [0.0; 3]);
            assert!((found - gap).abs() < 1e-5, "{k}: {found} {gap} {beside}");
        }
    }
    // Known from Coal: a rod within a body, beside its axis.
    let cylinder = |ends: [[f64; 3]; 2], radius_mm: f64| Shape::Cylinder { ends_mm: ends.map(Point3::from), radius_mm };
    let body = cylinder(
        [
            [-2.9396672925231684, -7.550102599639952, -70.6315428171738],
            [2.9396672925231684, 7.550102599639952, -4.386465524850074],
        ],
        58.0099219217857,
    );
    let rod = cylinder([[122.1258, -1.8042, 70.7568], [122.1258, -1.8042, 128.042]], 3.0);
    let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(0.0, 0.0, 1.0, 0.0));
    let at = Translation3::new(1842.966092782747, -16.17571407066499, 565.6047251623661);
    let poses = [Isometry3::from_parts(at, turn), Isometry3::translation(1691.463, 8.823, 511.616)];
    let found = two(body, rod).nearest(&poses).unwrap().distance_mm;
    assert!((-28.6..-28.2).contains(&found), "{found}");
}

#[test]
fn a_thin_rod_between_two_samples_is_found() {
    let cell = two(rod(3.0), rod(3.0));
    let mut motion = Straight { from: Vector3::new(-500.0, 1.0, 0.0), to: Vector3::new(723.0, 1.0, 0.0), turn: 0.0 };
    let found = cell.sweep(&mut motion, 2, &SweepOptions::default());
    assert!(found.lower_mm <= -5.0 && found.lower_mm >= -5.1 - 1e-9, "{found:?}");
    let mut past = Straight { from: Vector3::new(-500.0, 7.0, 0.0), to: Vector3::new(723.0, 7.0, 0.0), turn: 0.0 };
    let found = cell.sweep(&mut past, 2, &SweepOptions::default());
    assert!(found.lower_mm <= 1.0 && found.lower_mm >= 0.9, "{found:?}");
    println!("{found:?}");
}

/// A ring is no disc: what stands in it, or goes through it, is apart.
#[test]
fn a_ring_of_a_mesh_is_hollow() {
    const SIDES: usize = 64;
    let corner = |k: usize, radius: f64, z: f64| {
        let angle = k as f64 / SIDES as f64 * std::f64::consts::TAU;
        Point3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    let mut triangles = Vec::new();
    for k in 0..SIDES {
        let profile = [(100.0, 0.0), (100.0, 20.0), (80.0, 20.0), (80.0, 0.0)];
        for side in 0..4 {
            let [(r, z), (s, w)] = [profile[side], profile[(side + 1) % 4]];
            let [a, b, c, d] = [corner(k, r, z), corner(k + 1, r, z), corner(k + 1, s, w), corner(k, s, w)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    // The last side ends where the first begins, to the bit.
    for own in triangles.iter_mut().flatten() {
        *own = own.map(|x| (x * 1e6).round() / 1e6 + 0.0);
    }
    let ring = Body::new("ring", 0, BodyGrade::Given, &pieces_of_mesh(&triangles, 12).unwrap()).unwrap();
    let ball = Shape::Capsule { ends_mm: [Point3::origin(); 2], radius_mm: 30.0 };
    let ball = Body::new("ball", 1, BodyGrade::Given, &[ball]).unwrap();
    let found = Cell::new(vec![ring, ball], |_, _| false).nearest(&[Isometry3::identity(); 2]).unwrap();
    assert!((0.0..=50.0).contains(&found.distance_mm), "{found:?}");
}
