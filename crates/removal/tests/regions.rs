//! Regions of height against fine integrals over height and angle, on geometry that is written here from the lines of moves.

use std::f64::consts::{FRAC_PI_2, PI};

use kinetostat_removal::{Cutter, Engagement, Field, Slicing, Stock};
use nalgebra::{Vector2, Vector3};

use crate::paths::{block, cut_only};

/// Numbers from 0 to 1 that are the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[(self.next() * all.len() as f64) as usize]
    }
}

/// A straight move of a flat cutter.
struct Leg {
    radius: f64,
    from: Vector3<f64>,
    to: Vector3<f64>,
}

impl Leg {
    /// The lowest height of the tip while the end covers `p`.
    fn floor(&self, p: Vector2<f64>) -> f64 {
        let along = (self.to - self.from).xy();
        let (length, w) = (along.norm(), p - self.from.xy());
        if length == 0.0 {
            return if w.norm() < self.radius { self.from.z.min(self.to.z) } else { f64::INFINITY };
        }
        let u = along / length;
        let (foot, aside) = (w.dot(&u), w.perp(&u));
        let chord = self.radius * self.radius - aside * aside;
        if chord <= 0.0 {
            return f64::INFINITY;
        }
        let (low, high) = ((foot - chord.sqrt()).max(0.0), (foot + chord.sqrt()).min(length));
        if low > high {
            return f64::INFINITY;
        }
        let z = |at: f64| self.from.z + (self.to.z - self.from.z) * at / length;
        z(low).min(z(high))
    }
}

/// What the mean force of a linear law is made of: ∫∫ dz dθ of 1, cos θ, sin θ, cos² θ, sin θ cos θ, and of the third and fourth times z.
type Moments = [f64; 7];

fn of_angle(theta: f64) -> [f64; 5] {
    let (sine, cosine) = theta.sin_cos();
    [1.0, cosine, sine, cosine * cosine, sine * cosine]
}

fn add(sum: &mut Moments, own: [f64; 5], [low, high]: [f64; 2]) {
    let middle = 0.5 * (low + high);
    let all = [own[0], own[1], own[2], own[3], own[4], own[2] * middle, own[3] * middle];
    sum.iter_mut().zip(all).for_each(|(sum, own)| *sum += own * (high - low));
}

/// Those of slices, by closed form in each arc.
fn of_slices(engagement: &Engagement) -> Moments {
    let mut sum = [0.0; 7];
    for slice in &engagement.slices {
        for arc in &engagement.arcs[slice.arcs.clone()] {
            let primitive = |at: f64| {
                let (sine, cosine) = at.sin_cos();
                [at, sine, -cosine, 0.5 * (at + sine * cosine), 0.5 * sine * sine]
            };
            let (a, b) = (primitive(arc.from), primitive(arc.to));
            add(&mut sum, [0, 1, 2, 3, 4].map(|k| b[k] - a[k]), [slice.bottom_mm, slice.top_mm]);
        }
    }
    sum
}

/// Those below the top of the block and above the floors of `legs`.
fn fine(legs: &[Leg], tip: &Vector3<f64>, heading: f64, radius: f64) -> Moments {
    const COUNT: u32 = 20_000;
    let step = PI / f64::from(COUNT);
    let mut sum = [0.0; 7];
    for number in 0..COUNT {
        let theta = (f64::from(number) + 0.5) * step - FRAC_PI_2;
        let (sine, cosine) = (heading + theta).sin_cos();
        let p = tip.xy() + radius * Vector2::new(cosine, sine);
        let floor = legs.iter().map(|leg| leg.floor(p)).fold(0.0, f64::min);
        if floor > tip.z {
            add(&mut sum, of_angle(theta).map(|own| own * step), [0.0, floor - tip.z]);
        }
    }
    sum
}

fn error(found: &Moments, right: &Moments) -> f64 {
    let size = [right[0], right[0] * (right[5].abs() + right[6].abs()).max(1e-9) / right[0].max(1e-9)];
    (0..7).map(|k| (found[k] - right[k]).abs() / size[usize::from(k > 4)].max(1e-3)).fold(0.0, f64::max)
}

/// Passes over floors of earlier ones at any angle, of one to four steps, ramps, islands between passes, and helices in chords.
#[test]
fn random_cuts_over_earlier_passes() {
    let (mut random, mut worst, mut met) = (Random(7), 0.0_f64, 0);
    for case in 0..400 {
        let (mut field, mut legs) = (Field::new(block(), 0.25).unwrap(), Vec::new());
        for _ in 0..1 + (4.0 * random.next()) as usize {
            let radius = random.one_of(&[3.0, 5.0, 5.0]);
            let mut ends = Vec::new();
            let (angle, off) = (random.between(-PI, PI), random.between(-6.0, 6.0));
            let z = random.one_of(&[-0.3, -0.6, -1.0, -1.1, -1.45, -2.0]);
            let fall = random.one_of(&[0.0, 0.0, 0.0, 0.3, 1.0]);
            if random.next() < 0.15 {
                let around = random.between(3.0, 8.0);
                let turn = |k: u32| angle + 0.05 * f64::from(k);
                ends.extend((0..126).map(|k| {
                    Vector3::new(around * turn(k).cos(), around * turn(k).sin(), z - fall * f64::from(k) / 126.0)
                }));
            } else {
                let (u, v) = (Vector2::new(angle.cos(), angle.sin()), Vector2::new(-angle.sin(), angle.cos()));
                for (along, z) in [(-18.0, z), (18.0, z - fall)] {
                    let at = along * u + off * v;
                    ends.push(Vector3::new(at.x, at.y, z));
                }
            }
            cut_only(&mut field, &Cutter::flat(2.0 * radius).unwrap(), &ends, 0.5);
            legs.extend(ends.windows(2).map(|pair| Leg { radius, from: pair[0], to: pair[1] }));
        }
        let tip = Vector3::new(
            random.between(-3.0, 3.0),
            random.between(-3.0, 3.0),
            random.one_of(&[-0.9, -2.4, -3.0, -5.0]),
        );
        let (heading, fall) = (random.between(-PI, PI), random.one_of(&[0.0, 0.0, -0.02, 0.05]));
        let direction = Vector3::new(heading.cos(), heading.sin(), fall);
        let mut engagement = Engagement::default();
        field.engage(&Cutter::flat(10.0).unwrap(), &tip, &direction, &Slicing::default(), &mut engagement).unwrap();
        let right = fine(&legs, &tip, heading, 5.0);
        if right[0] < 0.05 {
            continue;
        }
        met += 1;
        let own = error(&of_slices(&engagement), &right);
        if own > 2e-3 {
            println!(
                "{case}: {own:.1e} in {} slices, {right:.4?} {:.4?}",
                engagement.slices.len(),
                of_slices(&engagement)
            );
        }
        worst = worst.max(own);
        let volume = 5.0 * right[1] / 1.0_f64.hypot(fall);
        let sides = engagement.volume_per_mm + fall.min(0.0) / 1.0_f64.hypot(fall) * engagement.end_area_mm2;
        assert!((sides - volume).abs() < 2e-3 * 5.0 * right[0], "{case}: {sides} {volume}");
    }
    assert!(met > 300 && worst < 4e-3, "{met} {worst:.1e}");
}

/// A wall of 0.1 mm over a floor of 0.3 mm in one pass: two regions with exact arcs.
#[test]
fn a_wall_over_a_floor_is_two_regions() {
    let mut field = Field::new(block(), 0.25).unwrap();
    let flat = Cutter::flat(10.0).unwrap();
    cut_only(&mut field, &flat, &[Vector3::new(-39.0, -0.1, -2.7), Vector3::new(39.0, -0.1, -2.7)], 1.0);
    let mut engagement = Engagement::default();
    let slicing = Slicing { slice_mm: 10.0, ..Slicing::default() };
    field.engage(&flat, &Vector3::new(0.0, 0.0, -3.0), &Vector3::x(), &slicing, &mut engagement).unwrap();
    let [low, high] = &engagement.slices[..] else { panic!("{engagement:?}") };
    assert!((low.top_mm - 0.3).abs() < 1e-9 && (high.bottom_mm - 0.3).abs() < 1e-9 && (high.top_mm - 3.0).abs() < 1e-9);
    let arcs = |slice: &kinetostat_removal::Slice| {
        let arcs = &engagement.arcs[slice.arcs.clone()];
        assert_eq!(arcs.len(), 1);
        (arcs[0].from.to_degrees(), arcs[0].to.to_degrees())
    };
    let wall = 90.0 - (1.0 - 0.1 / 5.0_f64).acos().to_degrees();
    assert!((arcs(low).0 + 90.0).abs() < 1e-9 && (arcs(low).1 - 90.0).abs() < 1e-9);
    assert!((arcs(high).0 - wall).abs() < 0.002 && (arcs(high).1 - 90.0).abs() < 1e-9);
    assert!((engagement.width_mm - 10.0).abs() < 1e-6);
}

/// A rib between two slots over their floor: a region with one arc below and one with the arc of the rib above.
#[test]
fn a_rib_over_a_floor_has_its_own_arc() {
    let mut field = Field::new(block(), 0.25).unwrap();
    let flat = Cutter::flat(10.0).unwrap();
    for y in [-5.2, 5.2] {
        cut_only(&mut field, &flat, &[Vector3::new(-39.0, y, -1.0), Vector3::new(39.0, y, -1.0)], 1.0);
    }
    let mut engagement = Engagement::default();
    field.engage(&flat, &Vector3::new(0.0, 0.0, -1.5), &Vector3::x(), &Slicing::default(), &mut engagement).unwrap();
    let [low, high] = &engagement.slices[..] else { panic!("{engagement:?}") };
    assert!((low.top_mm - 0.5).abs() < 1e-9 && (high.top_mm - 1.5).abs() < 1e-9);
    let rib = (0.2 / 5.0_f64).asin();
    let [arc] = engagement.arcs[high.arcs.clone()] else { panic!("{engagement:?}") };
    assert!((arc.from + rib).abs() < 1e-4 && (arc.to - rib).abs() < 1e-4);
}

/// A motion that falls by rounding has no end in material.
#[test]
fn a_fall_of_rounding_is_level() {
    let flat = Cutter::flat(10.0).unwrap();
    let mut field = Field::new(block(), 0.25).unwrap();
    let (from, to) = (Vector3::new(-10.0, 0.0, -5.0), Vector3::new(-7.5, 0.0, -5.0 - 1e-15));
    cut_only(&mut field, &flat, &[Vector3::new(-38.0, 0.0, -5.0), from], 0.5);
    let mut engagement = Engagement::default();
    for fall in [1e-15, 1e-12] {
        field.engage(&flat, &to, &Vector3::new(2.5, 0.0, -fall), &Slicing::default(), &mut engagement).unwrap();
        assert_eq!(engagement.end_area_mm2, 0.0);
        assert!((engagement.volume_per_mm - 50.0).abs() < 1e-3);
    }
}

/// ∫ over a ball of what the force is made of: of n · t, and of 1, cos θ and sin θ with the meridian.
fn of_ball(radius: f64, front: impl Fn(f64, f64) -> Option<f64>) -> [f64; 4] {
    const COUNT: [u32; 2] = [1500, 2000];
    let (dk, dt) = (FRAC_PI_2 / f64::from(COUNT[0]), 2.0 * PI / f64::from(COUNT[1]));
    let mut sum = [0.0; 4];
    for k in 0..COUNT[0] {
        for t in 0..COUNT[1] {
            // Another offset at each angle, so that edges average out.
            let kappa = (f64::from(k) + (0.618_033_988_749_894_8 * f64::from(t)).fract()) * dk;
            let theta = (f64::from(t) + 0.5) * dt - PI;
            let Some(chip) = front(kappa, theta) else { continue };
            let edge = radius * dk * dt;
            sum[0] += chip * radius * kappa.sin() * edge;
            sum[1] += edge;
            sum[2] += theta.cos() * edge;
            sum[3] += theta.sin() * edge;
        }
    }
    sum
}

/// Finishing of a slope with a ball, uphill and downhill, in rows, with little left: 5 % of a fine integral over the sphere.
#[test]
fn a_ball_that_finishes_a_slope() {
    let (radius, rows) = (3.0, 0.2);
    let mut worst = 0.0_f64;
    for (slope, allowance) in [(25.0_f64, 0.02), (25.0, 0.1), (25.0, 0.3), (5.0, 0.02), (45.0, 0.02), (0.0, 0.02)] {
        let (sine, cosine) = slope.to_radians().sin_cos();
        // The plane z = x tan slope is left; the stock is `allowance` thicker.
        let top = |x: f64| (x * sine + allowance) / cosine;
        let corners = [[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0]];
        let at = |[x, y]: [f64; 2], z: f64| Vector3::new(x, y, z);
        let vertices: Vec<_> =
            corners.iter().map(|own| at(*own, -40.0)).chain(corners.iter().map(|own| at(*own, top(own[0])))).collect();
        let mut triangles = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
        for k in 0..4_u32 {
            let next = (k + 1) % 4;
            triangles.extend([[k, next, next + 4], [k, next + 4, k + 4]]);
        }
        let stock = Stock::mesh(vertices, triangles).unwrap();
        let ball = Cutter::ball(2.0 * radius).unwrap();
        // The centre of the ball is `radius` above the plane along its normal.
        let tip = |x: f64, y: f64| Vector3::new(x, y, x * sine / cosine + radius / cosine - radius);
        for is_down in [true, false] {
            for row in 0..2 {
                let y = rows * f64::from(row);
                let ends = [tip(-12.0, y), tip(12.0, y)];
                let (from, to) = if is_down { (ends[1], ends[0]) } else { (ends[0], ends[1]) };
                let way = (to - from).normalize();
                for share in [0.45, 0.5, 0.513] {
                    let now = from + share * (to - from);
                    let mut field = Field::new(stock.clone(), 0.15).unwrap();
                    let back = Vector3::new(0.0, -rows, 0.0);
                    if row > 0 {
                        cut_only(&mut field, &ball, &[from + back, to + back], 0.25);
                    }
                    cut_only(&mut field, &ball, &[from, now], 0.25);
                    let ahead = now + 0.25 * way;
                    let mut engagement = Engagement::default();
                    let slicing = Slicing { nose_slices: 16, ..Slicing::default() };
                    field.engage(&ball, &ahead, &way, &slicing, &mut engagement).unwrap();
                    // In a frame of the heading: material below the plane that the ball before, and the row before, have left.
                    let centre = ahead + Vector3::new(0.0, 0.0, radius);
                    let sign = way.x.signum();
                    let before = (now + Vector3::new(0.0, 0.0, radius), from + Vector3::new(0.0, 0.0, radius));
                    let is_in = |p: &Vector3<f64>| {
                        let line = |a: &Vector3<f64>, u: &Vector3<f64>, length: f64| {
                            let along = (p - a).dot(u).clamp(0.0, length);
                            (p - a - along * u).norm() >= radius
                        };
                        let row_before = from + Vector3::new(0.0, -rows, radius);
                        p.z < top(p.x)
                            && line(&before.1, &way, (before.0 - before.1).norm())
                            && (row == 0 || line(&row_before, &way, (to - from).norm()))
                    };
                    let right = of_ball(radius, |kappa, theta| {
                        let normal = Vector3::new(
                            kappa.sin() * theta.cos() * sign,
                            kappa.sin() * theta.sin() * sign,
                            -kappa.cos(),
                        );
                        let chip = normal.dot(&way);
                        (chip > 0.0 && is_in(&(centre + radius * normal))).then_some(chip)
                    });
                    let mut found = [engagement.volume_per_mm, 0.0, 0.0, 0.0];
                    for slice in &engagement.slices {
                        for arc in &engagement.arcs[slice.arcs.clone()] {
                            found[1] += slice.edge_mm * (arc.to - arc.from);
                            found[2] += slice.edge_mm * (arc.to.sin() - arc.from.sin());
                            found[3] -= slice.edge_mm * (arc.to.cos() - arc.from.cos());
                        }
                    }
                    let own = (0..4).map(|k| (found[k] - right[k]).abs() / right[k.min(1)]).fold(0.0, f64::max);
                    if own > 0.01 {
                        println!(
                            "{slope} {allowance} {is_down} {row} {share}: {own:.4} {found:.5?} {right:.5?} {}",
                            engagement.slices.len()
                        );
                    }
                    worst = worst.max(own);
                }
            }
        }
    }
    assert!(worst < 0.03, "{worst}");
}
