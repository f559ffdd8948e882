//! The machined surface in patches, and how far that of displaced moves is from it, against closed forms.

use kinetostat_removal::{Cutter, Field, Patch, Stock};
use nalgebra::{Vector2, Vector3};

const D: f64 = 10.0;
const EVERYWHERE: [Vector2<f64>; 2] = [Vector2::new(-1e3, -1e3), Vector2::new(1e3, 1e3)];

fn block() -> Stock {
    Stock::cuboid(Vector3::new(-30.0, -20.0, -10.0), Vector3::new(30.0, 20.0, 0.0)).unwrap()
}

/// A field after a polyline of one cutter, displaced by `shift`.
fn cut(stock: Stock, cutter: &Cutter, points: &[Vector3<f64>], shift: Vector3<f64>) -> Field {
    let mut field = Field::new(stock, 0.25).unwrap();
    for (number, pair) in points.windows(2).enumerate() {
        field.cut(cutter, &(pair[0] + shift), &(pair[1] + shift), number as u32).unwrap();
    }
    field
}

/// A slot at an angle: walls and floor are displaced by what the shift is along their normals, whatever the direction of the walls.
#[test]
fn a_displaced_slot_is_off_by_the_shift_along_its_normals() {
    let cutter = Cutter::flat(D).unwrap();
    let shift = Vector3::new(0.12, -0.05, 0.03);
    for angle in [0.0, 0.3, 0.5 * std::f64::consts::PI, 2.0] {
        let (sine, cosine) = f64::sin_cos(angle);
        let along = Vector3::new(cosine, sine, 0.0);
        let points = [-60.0 * along - 4.0 * Vector3::z(), 60.0 * along - 4.0 * Vector3::z()];
        let field = cut(block(), &cutter, &points, Vector3::zeros());
        let moved = cut(block(), &cutter, &points, shift);
        let patches = field.patches(EVERYWHERE, 0.5).unwrap();
        let (mut floors, mut walls) = (0, 0);
        for own in patches.iter().filter(|own| own.tag.is_some()) {
            let across = Vector3::new(-sine, cosine, 0.0).dot(&own.position);
            if own.normal.z == 1.0 {
                assert!((own.position.z + 4.0).abs() < 1e-9 && across.abs() < 5.0, "{own:?}");
                // Not where the displaced wall stands.
                if across.abs() > 4.7 {
                    continue;
                }
                floors += 1;
            } else {
                assert!((across.abs() - 5.0).abs() < 1e-5 && own.normal.z == 0.0, "{own:?}");
                let inward = -across.signum() * Vector3::new(-sine, cosine, 0.0);
                assert!((own.normal - inward).norm() < 1e-9, "{own:?}");
                walls += 1;
            }
            // At the skin the surface ends.
            if own.position.x.abs() > 29.0 || own.position.y.abs() > 19.0 {
                continue;
            }
            let off = moved.deviation(&own.position, &own.normal, 0.5).mm;
            assert!((off - shift.dot(&own.normal)).abs() < 1e-5, "{angle}: {off} at {own:?}");
        }
        assert!(floors > 1000 && walls > 100, "{floors} {walls}");
    }
}

/// The area of a slot and of what is left about it, from its patches.
#[test]
fn patches_cover_the_surface() {
    let cutter = Cutter::flat(D).unwrap();
    let points = [Vector3::new(-60.0, 3.0, -4.0), Vector3::new(60.0, 3.0, -4.0)];
    let patches = cut(block(), &cutter, &points, Vector3::zeros()).patches(EVERYWHERE, 0.5).unwrap();
    let of =
        |made: bool| -> f64 { patches.iter().filter(|own| own.tag.is_some() == made).map(|own| own.area_mm2()).sum() };
    assert!((of(true) - 60.0 * (10.0 + 2.0 * 4.0)).abs() < 1.0, "{}", of(true));
    // The top beside the slot, and four sides, two of which it cuts.
    let skin = 60.0 * 30.0 + 2.0 * 60.0 * 10.0 + 2.0 * (40.0 * 10.0 - 10.0 * 4.0);
    assert!((of(false) - skin).abs() < 1.0, "{} {skin}", of(false));
    // Each is seen from outside.
    for own in &patches {
        let [a, b, c, d] = own.corners;
        assert!((c - a).cross(&(d - b)).dot(&own.normal) >= 0.0, "{own:?}");
    }
}

/// A ball on a slope: the normal is that of the sphere, and a shift along it shows whole.
#[test]
fn a_ball_shows_the_shift_along_the_normals_of_its_groove() {
    let cutter = Cutter::ball(D).unwrap();
    let points = [Vector3::new(-40.0, 1.0, -6.0), Vector3::new(40.0, 1.0, -2.0)];
    let shift = Vector3::new(0.0, 0.08, -0.06);
    let (field, moved) = (cut(block(), &cutter, &points, Vector3::zeros()), cut(block(), &cutter, &points, shift));
    let mut count = 0;
    for own in field.patches(EVERYWHERE, 0.5).unwrap() {
        if own.tag.is_none() || own.position.x.abs() > 28.0 || own.position.z > -0.5 {
            continue;
        }
        // From the axis of the groove.
        let along = (points[1] - points[0]).normalize();
        let from = own.position - (points[0] + 5.0 * Vector3::z());
        let radial: Vector3<f64> = from - along * along.dot(&from);
        assert!((radial.norm() - 5.0).abs() < 1e-5, "{own:?}");
        assert!((own.normal + radial / 5.0).norm() < 1e-4, "{own:?} {radial}");
        let off = moved.deviation(&own.position, &own.normal, 0.3).mm;
        // A cylinder displaced across its axis.
        let across = shift - along * along.dot(&shift);
        let exact = {
            let n = own.normal;
            let b = n.dot(&(radial - across));
            let c = (radial - across).norm_squared() - 25.0;
            -b - (b * b - c).sqrt()
        };
        let exact = if exact.abs() < 0.3 { exact } else { -n_far(&own.normal, &(radial - across)) };
        assert!((off - exact).abs() < 2e-5, "{off} {exact} {own:?}");
        count += 1;
    }
    assert!(count > 500, "{count}");
}

/// The farther root of |r + t n| = 5, reversed.
fn n_far(n: &Vector3<f64>, r: &Vector3<f64>) -> f64 {
    let b = n.dot(r);
    -(-b + (b * b - r.norm_squared() + 25.0).sqrt())
}

/// Where a wall stands over the floor and the floor is higher as well, what is left there is how far it is to the wall.
#[test]
fn a_wall_over_a_raised_floor_is_as_far_as_it_is() {
    let cutter = Cutter::flat(D).unwrap();
    let points = [Vector3::new(-60.0, 0.0, -4.0), Vector3::new(60.0, 0.0, -4.0)];
    for up in [-0.05, 0.0, 0.05] {
        let moved = cut(block(), &cutter, &points, Vector3::new(0.0, 0.2, up));
        let patches = cut(block(), &cutter, &points, Vector3::zeros()).patches(EVERYWHERE, 0.07).unwrap();
        let under = |own: &&Patch| own.normal.z == 1.0 && own.tag.is_some() && own.position.y < -4.81;
        let mut count = 0;
        for own in patches.iter().filter(under).filter(|own| own.position.x.abs() < 29.0) {
            let off = moved.deviation(&own.position, &own.normal, 0.4).mm;
            assert!((off - (-4.8 - own.position.y)).abs() < 1e-5, "{up}: {off} at {own:?}");
            count += 1;
        }
        assert!(count > 500, "{count}");
    }
}

/// A roughing pass that bends into the wall leaves a gouge that the finishing pass does not take away.
#[test]
fn a_gouge_of_an_earlier_pass_stays() {
    let cutter = Cutter::flat(D).unwrap();
    let rough = [Vector3::new(-40.0, -15.3, -5.0), Vector3::new(40.0, -15.3, -5.0)];
    let finish = [Vector3::new(40.0, -15.0, -5.0), Vector3::new(-40.0, -15.0, -5.0)];
    let program = |rough_off: f64, finish_off: f64| {
        let mut field = Field::new(block(), 0.25).unwrap();
        for (points, off) in [(rough, rough_off), (finish, finish_off)] {
            let shift = Vector3::new(0.0, off, 0.0);
            field.cut(&cutter, &(points[0] + shift), &(points[1] + shift), 0).unwrap();
        }
        field
    };
    let nominal = program(0.0, 0.0);
    for (rough_off, finish_off, left) in [(0.5, 0.05, -0.2), (0.1, 0.05, -0.05), (0.0, -0.1, 0.1), (0.32, -0.1, -0.02)]
    {
        let field = program(rough_off, finish_off);
        let walls: Vec<f64> = nominal
            .patches(EVERYWHERE, 0.5)
            .unwrap()
            .iter()
            .filter(|own| own.tag.is_some() && own.normal.z == 0.0 && own.position.x.abs() < 29.0)
            .map(|own| field.deviation(&own.position, &own.normal, 0.6).mm)
            .collect();
        assert!(walls.len() > 100);
        for own in walls {
            assert!((own - left).abs() < 1e-5, "{own} instead of {left}");
        }
    }
}

/// Where a wall goes into what was not to be cut, the top that it takes is missing by how far it went, at most.
#[test]
fn the_top_beside_a_wall_is_missing_by_as_much() {
    let cutter = Cutter::flat(D).unwrap();
    let points = [Vector3::new(-60.0, 3.0, -6.0), Vector3::new(60.0, 3.0, -6.0)];
    let moved = cut(block(), &cutter, &points, Vector3::new(0.0, 0.2, 0.0));
    let (mut count, top) = (0, cut(block(), &cutter, &points, Vector3::zeros()).patches(EVERYWHERE, 0.13).unwrap());
    for own in top.iter().filter(|own| own.tag.is_none() && own.normal.z > 0.0) {
        let off = moved.deviation(&own.position, &own.normal, 0.3).mm;
        let inside = (8.2 - own.position.y).clamp(0.0, 0.2);
        assert!((off + if own.position.y > 0.0 { inside } else { 0.0 }).abs() < 2e-4, "{off} {inside} {own:?}");
        count += usize::from(inside > 0.0 && own.position.y > 0.0);
    }
    assert!(count > 100);
}

/// Walls of any height are in the surface, also where a rib is gone that stood between them.
#[test]
fn low_walls_and_lost_ribs_are_seen() {
    let cutter = Cutter::flat(D).unwrap();
    for depth in [0.002, 0.05, 0.7] {
        let points = [Vector3::new(-60.0, 3.0, -depth), Vector3::new(60.0, 3.0, -depth)];
        let (field, moved) = (
            cut(block(), &cutter, &points, Vector3::zeros()),
            cut(block(), &cutter, &points, Vector3::new(0.0, 0.1, 0.0)),
        );
        let patches = field.patches(EVERYWHERE, 2.0).unwrap();
        let walls: Vec<_> = patches.iter().filter(|own| own.tag.is_some() && own.normal.z == 0.0).collect();
        let area: f64 = walls.iter().map(|own| own.area_mm2()).sum();
        assert!((area - 2.0 * 60.0 * depth).abs() < 1e-6 * 60.0, "{depth}: {area}");
        for own in walls {
            let off = moved.deviation(&own.position, &own.normal, 0.11).mm;
            assert!((off - 0.1 * own.normal.y).abs() < 1e-5, "{off} {own:?}");
        }
    }
    // 0.3 mm between two slots, each of which goes 0.2 mm into it.
    let slots = |off: f64| {
        let mut field = Field::new(block(), 0.25).unwrap();
        for side in [-1.0, 1.0] {
            let y = side * (5.15 - off);
            let at = |x: f64| Vector3::new(x, y, -4.0);
            field.cut(&cutter, &at(-60.0), &at(60.0), 0).unwrap();
        }
        field
    };
    let (field, moved) = (slots(0.0), slots(0.2));
    let tops: Vec<_> = field
        .patches(EVERYWHERE, 0.1)
        .unwrap()
        .into_iter()
        .filter(|own| own.position.z > -3.9 && own.position.y.abs() < 0.16 && own.position.x.abs() < 29.0)
        .collect();
    assert!(tops.len() > 1000);
    for own in tops {
        assert!(moved.deviation(&own.position, &own.normal, 0.21).mm <= -0.1, "{own:?}");
    }
}
