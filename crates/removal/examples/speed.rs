//! Time a move: a pocket cut in levels of short moves, a D10 cutter in cells of 0.2 mm.
//!
//! ```sh
//! cargo run --release -p kinetostat-removal --example speed -- 1000000 flat
//! cargo run --release -p kinetostat-removal --example speed -- 100000 ball 16
//! ```

use std::time::Instant;

use kinetostat_removal::{Cutter, Engagement, Field, RemovalError, Slicing, Stock};
use nalgebra::Vector3;

/// A pocket 120 mm × 80 mm in contours 4 mm apart from the inside, level by level of 1 mm; short moves of 0.1 to 0.5 mm.
fn pocket(count: usize) -> Vec<Vector3<f64>> {
    let mut points = Vec::with_capacity(count + 1);
    let mut level = 0;
    loop {
        level += 1;
        let z = -f64::from(level);
        for ring in 0..9 {
            let (x, y) = (25.0 + 4.0 * f64::from(ring), 5.0 + 4.0 * f64::from(ring));
            let corners = [[-x, -y], [x, -y], [x, y], [-x, y], [-x, -y]];
            for pair in corners.windows(2) {
                let (a, b) = (Vector3::new(pair[0][0], pair[0][1], z), Vector3::new(pair[1][0], pair[1][1], z));
                let mut share = 0.0;
                while share < 1.0 {
                    points.push(a + (b - a) * share);
                    if points.len() > count {
                        return points;
                    }
                    // 0.1 to 0.5 mm.
                    share += (0.1 + 0.4 * (f64::from(points.len() as u32) * 0.618_033_988_75).fract()) / (b - a).norm();
                }
            }
        }
    }
}

fn main() -> Result<(), RemovalError> {
    let mut arguments = std::env::args().skip(1);
    let count = arguments.next().and_then(|count| count.parse().ok()).unwrap_or(200_000);
    let cutter = match arguments.next().as_deref() {
        Some("ball") => Cutter::ball(10.0)?,
        Some("bull") => Cutter::bull(10.0, 1.0)?,
        _ => Cutter::flat(10.0)?,
    };
    let nose_slices = arguments.next().and_then(|count| count.parse().ok()).unwrap_or(Slicing::default().nose_slices);
    let slicing = Slicing { nose_slices, ..Slicing::default() };
    let points = pocket(count);
    let stock = Stock::cuboid(Vector3::new(-80.0, -60.0, -40.0), Vector3::new(80.0, 60.0, 0.0))?;
    println!("{} MB announced", Field::memory_bytes(&stock, 0.2, count)? / 1_000_000);
    let mut field = Field::new(stock, 0.2)?;
    field.reserve(count);
    let mut engagement = Engagement::default();
    let (mut cutting, mut engaging) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut volume = 0.0;
    for (number, ends) in points.windows(2).enumerate() {
        let start = Instant::now();
        let along = ends[1] - ends[0];
        field.engage(&cutter, &(0.5 * (ends[0] + ends[1])), &along, &slicing, &mut engagement)?;
        volume += engagement.volume_per_mm * along.norm();
        let middle = Instant::now();
        field.cut(&cutter, &ends[0], &ends[1], number as u32)?;
        cutting.push(middle.elapsed().as_nanos());
        engaging.push((middle - start).as_nanos());
    }
    for (what, times) in [("cut", &mut cutting), ("engage", &mut engaging)] {
        let mean = times.iter().sum::<u128>() as f64 / times.len() as f64 / 1e3;
        times.sort_unstable();
        println!("{what}: median {:.1} µs, mean {mean:.1} µs a move", times[times.len() / 2] as f64 / 1e3);
    }
    println!("engagements {volume:.0} mm³, field {:.0} mm³", field.volumes().removed_mm3);
    Ok(())
}
