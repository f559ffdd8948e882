//! Sweeps against many samples, and meshes against their pieces.

use kinetostat_cell::{Ball, Body, BodyGrade, Cell, MeshFault, Motion, Shape, SweepOptions, pieces_of_mesh};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

/// Numbers between -1 and 1, the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| size * self.next())
    }
}

/// Two joints that turn and a slide, each as a polynomial of the parameter.
struct Arm {
    turns: [[f64; 2]; 2],
    slide: [f64; 2],
}

impl Motion for Arm {
    fn poses(&mut self, s: f64, poses: &mut [Isometry3<f64>]) -> Result<(), String> {
        let at = |[a, b]: [f64; 2]| a * s + b * s * s;
        let first = Isometry3::from_parts(
            Translation3::identity(),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), at(self.turns[0])),
        );
        let second = Isometry3::from_parts(
            Translation3::new(400.0, 0.0, 0.0),
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), at(self.turns[1])),
        );
        poses[1] = first;
        poses[2] = first * second * Isometry3::translation(at(self.slide), 0.0, 0.0);
        Ok(())
    }

    fn speed(&mut self, frame: usize, ball: &Ball, [from, to]: [f64; 2]) -> f64 {
        let rate = |[a, b]: [f64; 2]| (a + 2.0 * b * from).abs().max((a + 2.0 * b * to).abs());
        let reach = ball.centre_mm.coords.norm() + ball.radius_mm;
        let slide = self.slide[0].abs() + self.slide[1].abs();
        match frame {
            0 => 0.0,
            1 => rate(self.turns[0]) * reach,
            _ => {
                rate(self.turns[0]) * (400.0 + slide + reach) + rate(self.turns[1]) * (slide + reach) + rate(self.slide)
            }
        }
    }
}

fn capsule(from: Vector3<f64>, to: Vector3<f64>, radius_mm: f64) -> Shape {
    Shape::Capsule { ends_mm: [from.into(), to.into()], radius_mm }
}

#[test]
fn no_sample_is_nearer_than_a_sweep_says() {
    let mut numbers = Numbers(7);
    for _ in 0..60 {
        let arm = capsule(Vector3::zeros(), Vector3::new(300.0, 0.0, 0.0), 20.0);
        let obstacle = numbers.vector(600.0);
        let bodies = vec![
            Body::new("post", 0, BodyGrade::Given, &[capsule(obstacle, obstacle + numbers.vector(100.0), 3.0)])
                .unwrap(),
            Body::new("link", 1, BodyGrade::Given, &[capsule(Vector3::zeros(), Vector3::new(400.0, 0.0, 0.0), 30.0)])
                .unwrap(),
            Body::new("tool", 2, BodyGrade::Given, &[arm]).unwrap(),
        ];
        let cell = Cell::new(bodies, |a, b| [a, b] == [1, 2]);
        let mut motion = Arm {
            turns: std::array::from_fn(|_| [2.0 * numbers.next(), numbers.next()]),
            slide: [100.0 * numbers.next(), 50.0 * numbers.next()],
        };
        let found = cell.sweep(&mut motion, 3, &SweepOptions::default());
        let mut poses = vec![Isometry3::identity(); 3];
        let mut least = f64::INFINITY;
        for k in 0..=2_000 {
            motion.poses(f64::from(k) / 2_000.0, &mut poses).unwrap();
            least = least.min(cell.nearest(&poses).unwrap().distance_mm);
        }
        let reached = found.at.unwrap().1.distance_mm;
        assert!(found.lower_mm <= least + 1e-9, "{found:?} {least}");
        assert!(reached >= least - 0.1 && reached <= found.lower_mm + 0.1 + 1e-9, "{found:?} {least}");
    }
}

/// An L of two boxes as a closed mesh: its outline in xy, run up z.
fn corner() -> Vec<[Point3<f64>; 3]> {
    let outline = [[0.0, 0.0], [100.0, 0.0], [100.0, 20.0], [20.0, 20.0], [20.0, 100.0], [0.0, 100.0]];
    let at = |k: usize, z: f64| Point3::new(outline[k % 6][0], outline[k % 6][1], z);
    let mut all = Vec::new();
    for k in 0..6 {
        all.extend([[at(k, 0.0), at(k + 1, 0.0), at(k + 1, 30.0)], [at(k, 0.0), at(k + 1, 30.0), at(k, 30.0)]]);
    }
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        all.extend([[at(a, 0.0), at(c, 0.0), at(b, 0.0)], [at(a, 30.0), at(b, 30.0), at(c, 30.0)]]);
    }
    all
}

#[test]
fn pieces_of_a_mesh_enclose_it_and_leave_its_corner_free() {
    let pieces = pieces_of_mesh(&corner(), 4).unwrap();
    assert!(pieces.len() >= 2, "{pieces:?}");
    let ball = |at: [f64; 3]| {
        let bodies = vec![
            Body::new("corner", 0, BodyGrade::Given, &pieces).unwrap(),
            Body::new("ball", 1, BodyGrade::Given, &[capsule(Vector3::zeros(), Vector3::zeros(), 1.0)]).unwrap(),
        ];
        Cell::new(bodies, |_, _| false)
            .nearest(&[Isometry3::identity(), Isometry3::translation(at[0], at[1], at[2])])
            .unwrap()
    };
    assert!(ball([60.0, 60.0, 15.0]).distance_mm > 30.0);
    assert!((ball([50.0, 30.0, 15.0]).distance_mm - 9.0).abs() < 2.6);
    for at in [[50.0, 19.5, 15.0], [10.0, 90.0, 2.0], [10.0, 10.0, 15.0], [99.0, 10.0, 29.0]] {
        assert!(ball(at).distance_mm < 0.0, "{at:?}");
    }
    let mut open = corner();
    open.pop();
    assert!(matches!(pieces_of_mesh(&open, 4), Err(MeshFault::Open(..))));
    let turned: Vec<_> = corner().into_iter().map(|[a, b, c]| [a, c, b]).collect();
    assert_eq!(pieces_of_mesh(&turned, 4), Err(MeshFault::InsideOut));
    assert_eq!(pieces_of_mesh(&[], 4), Err(MeshFault::Count(0)));
}

/// A part of the motion of an arm.
struct Part<'a> {
    whole: &'a mut Arm,
    ends: [f64; 2],
}

impl Part<'_> {
    fn at(&self, s: f64) -> f64 {
        self.ends[0] + (self.ends[1] - self.ends[0]) * s
    }
}

impl Motion for Part<'_> {
    fn poses(&mut self, s: f64, poses: &mut [Isometry3<f64>]) -> Result<(), String> {
        self.whole.poses(self.at(s), poses)
    }

    fn speed(&mut self, frame: usize, ball: &Ball, interval: [f64; 2]) -> f64 {
        let interval = interval.map(|s| self.at(s));
        (self.ends[1] - self.ends[0]) * self.whole.speed(frame, ball, interval)
    }
}

#[test]
fn margins_led_on_from_part_to_part_hide_no_hit() {
    const PARTS: usize = 40;
    let (mut numbers, mut hits, mut spared) = (Numbers(11), 0, 0);
    for _ in 0..80 {
        let obstacle = numbers.vector(600.0);
        let rod = capsule(obstacle, obstacle + numbers.vector(100.0), 3.0);
        let post = Body::new("post", 0, BodyGrade::Given, &[rod]).unwrap();
        let arm = capsule(Vector3::zeros(), Vector3::new(300.0, 0.0, 0.0), 20.0);
        let tool = Body::new("tool", 2, BodyGrade::Given, &[arm]).unwrap();
        let cell = Cell::new(vec![post, tool], |_, _| false);
        let mut whole = Arm { turns: std::array::from_fn(|_| [2.0 * numbers.next(), numbers.next()]), slide: [0.0; 2] };
        let mut poses = vec![Isometry3::identity(); 3];
        let mut least = f64::INFINITY;
        for k in 0..=4_000 {
            whole.poses(f64::from(k) / 4_000.0, &mut poses).unwrap();
            least = least.min(cell.nearest(&poses).unwrap().distance_mm);
        }
        let wanted_mm = 250.0;
        let decided = SweepOptions { wanted_mm, enough_mm: wanted_mm, beyond_mm: wanted_mm, ..SweepOptions::default() };
        let (mut margins, mut is_near, mut lower) = (Vec::new(), false, f64::INFINITY);
        for k in 0..PARTS {
            let ends = [k, k + 1].map(|k| k as f64 / PARTS as f64);
            let found = cell.sweep_on(&mut Part { whole: &mut whole, ends }, 3, &decided, &mut margins);
            spared += usize::from(found.states == 0);
            is_near |= found.at.is_some_and(|(_, own)| own.distance_mm < wanted_mm);
            lower = lower.min(found.lower_mm);
        }
        assert!(is_near || lower <= least + 1e-9, "{lower} {least}");
        assert!(is_near == (least < wanted_mm) || (least - wanted_mm).abs() < 0.01, "{is_near} {least}");
        hits += usize::from(is_near);
    }
    assert!((10..70).contains(&hits) && spared > 1_000, "{hits} {spared}");
}
