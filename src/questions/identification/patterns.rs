//! What the residuals correlate with, which names the effect that a model lacks: rank correlations (Spearman) with the order of measuring, the
//! load, its direction, and where the machine stood.

use super::{
    fit::Fit,
    measurements::{Measurement, Quantity},
};
use crate::machine::Machine;

/// A rank correlation of residuals with something.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Of what: the size of what is left of lengths in standard deviations, residual along an axis, or its share along the predicted
    /// displacement.
    pub of: &'static str,
    /// With what.
    pub with: String,
    /// What such a pattern hints at.
    pub hint: &'static str,
    /// Rank correlation.
    pub correlation: f64,
    /// What chance alone exceeds once in a thousand times, either way.
    pub limit: f64,
}

impl Pattern {
    /// Whether it is more than chance.
    pub fn is_seen(&self) -> bool {
        self.correlation.abs() > self.limit
    }
}

/// Half width in standard deviations that normal noise leaves once in a thousand times.
const ONCE_IN_A_THOUSAND: f64 = 3.290_526_73;
/// Fewer measurements show no pattern.
const FEWEST: usize = 8;

/// What a measurement left of lengths.
struct Left {
    /// Root of the sum of squares, in standard deviations.
    size: f64,
    /// Along x, y and z where they were read, in standard deviations.
    along: [Option<f64>; 3],
    /// Of displacements: the size of the one that is predicted, mm, and residual along it as a share of that; positive if more was
    /// measured.
    along_predicted: Option<(f64, f64)>,
}

fn left(fit: &Fit, measurements: &[Measurement]) -> Vec<Option<Left>> {
    let mut at = 0;
    let of = |own: &Measurement| {
        let (mut squares, mut along, mut has_any) = (0.0, [None; 3], false);
        let (mut product, mut predicted_squares) = (0.0, 0.0);
        for reading in &own.readings {
            let (r, predicted) = (fit.residuals[at] / fit.stds[at], fit.predicted.values[at]);
            let left = fit.residuals[at];
            at += 1;
            if let Quantity::Displacement(_) = reading.quantity {
                product += left * predicted;
                predicted_squares += predicted * predicted;
            }
            let axis = match reading.quantity {
                Quantity::Rotation(_) => continue,
                Quantity::Position(axis) => Some(axis),
                Quantity::Displacement(unit) => (0..3).find(|&axis| unit[axis] == 1.0),
            };
            (squares, has_any) = (squares + r * r, true);
            if let Some(axis) = axis {
                along[axis] = Some(r);
            }
        }
        let predicted = predicted_squares.sqrt();
        let along_predicted = (predicted > 0.0).then(|| (predicted, product / predicted_squares));
        has_any.then_some(Left { size: squares.sqrt(), along, along_predicted })
    };
    measurements.iter().map(of).collect()
}

/// All rank correlations that can be formed.
pub fn patterns(machine: &Machine, fit: &Fit, measurements: &[Measurement]) -> Vec<Pattern> {
    const ALONG: [&str; 3] = ["residual along x", "residual along y", "residual along z"];
    const SIZE: &str = "size of the residual";
    let left = left(fit, measurements);
    let mut patterns = Vec::new();
    const LOAD_SIGNED: &str = "lost motion, or a stiffness that changes with the load: the share is larger where the force is small (lost \
                               motion, a stiffness that grows) or where it is large (one that falls)";
    if let Some((correlation, limit)) = by_load(&left, measurements) {
        let (of, with) = ("residual along the predicted displacement", "size of the force, as a share of it".into());
        patterns.push(Pattern { of, with, hint: LOAD_SIGNED, correlation, limit });
    }
    let mut add = |of: &'static str, with: String, hint: &'static str, pairs: Vec<(f64, f64)>| {
        if let Some((correlation, limit)) = rank_correlation(&pairs) {
            patterns.push(Pattern { of, with, hint, correlation, limit });
        }
    };
    let sizes = |value: &dyn Fn(usize, &Measurement) -> f64| -> Vec<(f64, f64)> {
        let rows = left.iter().zip(measurements).enumerate();
        rows.filter_map(|(i, (left, own))| Some((value(i, own), left.as_ref()?.size))).collect()
    };
    const DRIFT: &str = "drift: something changed while measuring";
    const LOAD: &str = "yielding that the model lacks; try play of the drives, bearings that tilt (an arm's elbow first), elastic links";
    const POSE: &str = "a stiffness or an error that changes with the pose: links, bearings, gravity springs";
    add(SIZE, "order of measuring".into(), DRIFT, sizes(&|i, _| i as f64));
    add(SIZE, "size of the force".into(), LOAD, sizes(&|_, own| (own.load.force - own.reference.force).norm()));
    for (axis, word) in ["x", "y", "z"].into_iter().enumerate() {
        let share = |own: &Measurement| {
            let force = own.load.force - own.reference.force;
            force.try_normalize(0.0).map_or(0.0, |unit| unit[axis].abs())
        };
        let hint = "yielding in a direction that the model lacks";
        add(SIZE, format!("share of the force along {word}"), hint, sizes(&|_, own| share(own)));
    }
    let reach = |_: usize, own: &Measurement| own.at.pose.transform(machine.tool_tip).norm();
    add(SIZE, "distance of the tool tip from O".into(), POSE, sizes(&reach));
    for (k, label) in machine.drive_labels().into_iter().enumerate() {
        add(SIZE, format!("position of {label}"), POSE, sizes(&|_, own| own.at.drives[k]));
    }
    for axis in 0..3 {
        let along = |value: &dyn Fn(usize, &Measurement) -> f64| -> Vec<(f64, f64)> {
            let rows = left.iter().zip(measurements).enumerate();
            rows.filter_map(|(i, (left, own))| Some((value(i, own), left.as_ref()?.along[axis]?))).collect()
        };
        add(ALONG[axis], "order of measuring".into(), DRIFT, along(&|i, _| i as f64));
        let force = |_: usize, own: &Measurement| own.load.force[axis] - own.reference.force[axis];
        add(
            ALONG[axis],
            format!("force along {}", ["x", "y", "z"][axis]),
            "yielding along the force that the model lacks",
            along(&force),
        );
    }
    patterns
}

/// What only a machine that is not elastic leaves: a share along the predicted displacement that hangs on the size of the force. Rank
/// correlation of both with what each displacement per force tells of them taken out, since whatever yields at a place and the model lacks
/// is the same share of the displacement there under any force; and what chance exceeds once in a thousand times.
fn by_load(left: &[Option<Left>], measurements: &[Measurement]) -> Option<(f64, f64)> {
    let rows = left.iter().zip(measurements).filter_map(|(left, own)| {
        let (predicted, share) = left.as_ref()?.along_predicted?;
        let force = (own.load.force - own.reference.force).norm();
        (force > 0.0).then(|| [share, force, predicted / force])
    });
    let rows: Vec<[f64; 3]> = rows.collect();
    let of = |a: usize, b: usize| rank_correlation(&rows.iter().map(|row| (row[a], row[b])).collect::<Vec<_>>());
    let ((share_force, _), (share_yield, _), (force_yield, _)) = (of(0, 1)?, of(0, 2)?, of(1, 2)?);
    let rest = ((1.0 - share_yield * share_yield) * (1.0 - force_yield * force_yield)).sqrt();
    let limit = (ONCE_IN_A_THOUSAND * (1.06 / (rows.len() as f64 - 4.0)).sqrt()).tanh();
    (rest > 1e-6).then(|| (((share_force - share_yield * force_yield) / rest).clamp(-1.0, 1.0), limit))
}

/// Rank correlation of pairs and what chance exceeds once in a thousand times (Fieller, Hartley and Pearson 1957); `None` for too few,
/// or where one side is always the same.
pub fn rank_correlation(pairs: &[(f64, f64)]) -> Option<(f64, f64)> {
    if pairs.len() < FEWEST {
        return None;
    }
    let (a, b) = (ranks(pairs.iter().map(|pair| pair.0)), ranks(pairs.iter().map(|pair| pair.1)));
    let mean = (pairs.len() - 1) as f64 / 2.0;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let size = (product(&a, &a) * product(&b, &b)).sqrt();
    let limit = (ONCE_IN_A_THOUSAND * (1.06 / (pairs.len() as f64 - 3.0)).sqrt()).tanh();
    (size > 0.0).then(|| (product(&a, &b) / size, limit))
}

/// Ranks from 0; equal values share the mean of theirs.
pub fn ranks(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let values: Vec<f64> = values.collect();
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    for group in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let first = order.iter().position(|own| *own == group[0]).unwrap_or(0);
        let rank = first as f64 + (group.len() - 1) as f64 / 2.0;
        group.iter().for_each(|&i| ranks[i] = rank);
    }
    ranks
}
