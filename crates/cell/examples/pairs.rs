//! Random pairs of shapes with their distance, a line each, for `tests/against_coal.py`: `cargo run --release -p kinetostat-cell --example pairs -- SEED COUNT`.
//! Every other pair is put where it is within the frames of its bodies, slanted there, not by the poses of these. With `-` instead, the distance alone of
//! each pair given on standard input, in the same words: `shape|shape|pose|pose`.

use std::{env, io};

use kinetostat_cell::{Body, BodyGrade, Cell, Shape};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// Random numbers, the same for a seed on every machine.
struct Numbers(u64);

impl Numbers {
    /// Returns a number between 0 and 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns a length, mm: as many between 5 and 50 as between 50 and 500.
    fn length(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn rotation(&mut self) -> UnitQuaternion<f64> {
        let mut normal = || {
            let (size, turn) = (self.unit().max(1e-12), self.unit());
            (-2.0 * size.ln()).sqrt() * (std::f64::consts::TAU * turn).cos()
        };
        UnitQuaternion::from_quaternion(Quaternion::new(normal(), normal(), normal(), normal()))
    }

    /// Returns a shape about the origin, and its words: kind and sizes.
    fn shape(&mut self) -> (Shape, String) {
        let kind = (4.0 * self.unit()) as usize;
        if kind == 0 {
            let size = [0; 3].map(|_| self.length(5.0, 800.0));
            let shape = Shape::Cuboid { pose: Isometry3::identity(), size_mm: size.into() };
            return (shape, format!("box {} {} {}", size[0], size[1], size[2]));
        }
        if kind == 1 {
            let (count, half) = (6 + (40.0 * self.unit()) as usize, self.length(10.0, 400.0));
            let points_mm: Vec<Point3<f64>> =
                (0..count).map(|_| Point3::from([0; 3].map(|_| self.between(-half, half)))).collect();
            let words: Vec<String> = points_mm.iter().map(|own| format!("{} {} {}", own.x, own.y, own.z)).collect();
            return (Shape::Hull { points_mm }, format!("hull {}", words.join(" ")));
        }
        let (length, radius_mm) = (self.length(5.0, 800.0), self.length(3.0, 200.0));
        let ends_mm = [-0.5, 0.5].map(|end| Point3::new(0.0, 0.0, end * length));
        match kind {
            2 => (Shape::Capsule { ends_mm, radius_mm }, format!("capsule {length} {radius_mm}")),
            _ => (Shape::Cylinder { ends_mm, radius_mm }, format!("cylinder {length} {radius_mm}")),
        }
    }
}

fn words(pose: &Isometry3<f64>) -> String {
    let (at, turn) = (pose.translation.vector, pose.rotation.quaternion());
    format!("{} {} {} {} {} {} {}", at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k)
}

fn numbers(words: &str) -> Vec<f64> {
    words.split_whitespace().map(|word| word.parse().expect("a number")).collect()
}

/// Returns the shape of its words.
fn shape_of(text: &str) -> Shape {
    let (kind, sizes) = text.split_once(' ').expect("kind and sizes");
    let sizes = numbers(sizes);
    let ends_mm = [-0.5, 0.5].map(|end| Point3::new(0.0, 0.0, end * sizes[0]));
    match kind {
        "box" => Shape::Cuboid { pose: Isometry3::identity(), size_mm: Vector3::new(sizes[0], sizes[1], sizes[2]) },
        "hull" => Shape::Hull { points_mm: sizes.chunks_exact(3).map(Point3::from_slice).collect() },
        "capsule" => Shape::Capsule { ends_mm, radius_mm: sizes[1] },
        "cylinder" => Shape::Cylinder { ends_mm, radius_mm: sizes[1] },
        _ => panic!("{kind}: expected box, hull, capsule or cylinder"),
    }
}

/// Returns the pose of its words.
fn pose_of(text: &str) -> Isometry3<f64> {
    let own = numbers(text);
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(own[3], own[4], own[5], own[6]));
    Isometry3::from_parts(Translation3::new(own[0], own[1], own[2]), turn)
}

/// Returns a shape where `by` moves it within its frame.
fn moved(shape: &Shape, by: &Isometry3<f64>) -> Shape {
    match shape {
        Shape::Cuboid { pose, size_mm } => Shape::Cuboid { pose: by * pose, size_mm: *size_mm },
        Shape::Capsule { ends_mm, radius_mm } => {
            Shape::Capsule { ends_mm: ends_mm.map(|end| by * end), radius_mm: *radius_mm }
        }
        Shape::Cylinder { ends_mm, radius_mm } => {
            Shape::Cylinder { ends_mm: ends_mm.map(|end| by * end), radius_mm: *radius_mm }
        }
        Shape::Hull { points_mm } => Shape::Hull { points_mm: points_mm.iter().map(|own| by * own).collect() },
    }
}

/// Returns the distance of two shapes at their poses, mm.
fn distance(shapes: [Shape; 2], poses: [Isometry3<f64>; 2]) -> f64 {
    let body = |index: usize| Body::new("", index, BodyGrade::Given, &shapes[index..=index]).expect("a volume");
    Cell::new(vec![body(0), body(1)], |_, _| false).separations(&poses)[0].distance_mm
}

fn main() {
    if env::args().nth(1).as_deref() == Some("-") {
        for line in io::stdin().lines() {
            let line = line.expect("text");
            let words: Vec<&str> = line.split('|').collect();
            let &[one, other, at, beside] = &words[..] else { panic!("{line}: expected shape|shape|pose|pose") };
            println!("{}", distance([one, other].map(shape_of), [at, beside].map(pose_of)));
        }
        return;
    }
    let argument = |index: usize, otherwise: u64| {
        env::args().nth(index).map_or(otherwise, |text| text.parse().expect("SEED and COUNT are whole numbers"))
    };
    let mut numbers = Numbers(argument(1, 1));
    for pair in 0..argument(2, 1000) {
        let shapes = [numbers.shape(), numbers.shape()];
        let body = |index: usize| Body::new("", index, BodyGrade::Given, &[shapes[index].0.clone()]).expect("a volume");
        let reach = body(0).ball().1 + body(1).ball().1;
        let first = Vector3::from([0; 3].map(|_| numbers.between(-2000.0, 2000.0)));
        let second = first + numbers.rotation() * Vector3::x() * numbers.between(0.0, 1.2) * reach;
        let poses = [first, second].map(|at| Isometry3::from_parts(Translation3::from(at), numbers.rotation()));
        let unmoved = [Isometry3::identity(); 2];
        let (within, of_frames) = if pair % 2 == 0 { (unmoved, poses) } else { (poses, unmoved) };
        let distance_mm = distance([0, 1].map(|index| moved(&shapes[index].0, &within[index])), of_frames);
        println!("{}|{}|{}|{}|{distance_mm}", shapes[0].1, shapes[1].1, words(&poses[0]), words(&poses[1]));
    }
}
