//! Rank correlations (Spearman) of residuals with order, load, direction and pose, which hint at effects that a model lacks.

use super::{
    fit::Fit,
    measurements::{Measurement, Quantity},
};
use crate::machine::Machine;

/// A rank correlation of residuals with something else.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// What is correlated: size of a measurement's residual, residual along an axis, or along the predicted displacement.
    pub of: &'static str,
    /// What it is correlated with.
    pub with: String,
    /// Likely cause of such a correlation.
    pub hint: &'static str,
    /// Rank correlation, −1 to 1.
    pub correlation: f64,
    /// Size of the correlation that chance alone exceeds once in a thousand times.
    pub limit: f64,
}

impl Pattern {
    /// Whether the correlation is larger than chance explains.
    pub fn is_significant(&self) -> bool {
        self.correlation.abs() > self.limit
    }
}

/// Two-sided 99.9 % quantile of the normal distribution.
const ONCE_IN_A_THOUSAND: f64 = 3.290_526_73;
/// Fewest measurements that can show a pattern.
const FEWEST: usize = 8;

/// Residual of the lengths of one measurement.
struct LengthResidual {
    /// Norm of the residuals over their standard deviations.
    size: f64,
    /// Residuals along x, y and z of O over their standard deviations, where they were read.
    along: [Option<f64>; 3],
    /// Size of the predicted displacement, mm, and residual along it as a share of it, positive if more was measured.
    along_predicted: Option<(f64, f64)>,
}

/// Returns the residual of the lengths of each measurement; `None` where it has no length.
fn length_residuals(fit: &Fit, measurements: &[Measurement]) -> Vec<Option<LengthResidual>> {
    let mut index = 0;
    let residual_of = |measurement: &Measurement| {
        let (mut squares, mut along, mut has_any) = (0.0, [None; 3], false);
        let (mut product, mut predicted_squares) = (0.0, 0.0);
        for reading in &measurement.readings {
            let (r, predicted) = (fit.residuals[index] / fit.stds[index], fit.predicted.values[index]);
            let residual = fit.residuals[index];
            index += 1;
            if let Quantity::Displacement(_) = reading.quantity {
                product += residual * predicted;
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
        has_any.then_some(LengthResidual { size: squares.sqrt(), along, along_predicted })
    };
    measurements.iter().map(residual_of).collect()
}

/// Returns all rank correlations of the residuals for which there are enough measurements.
pub fn patterns(machine: &Machine, fit: &Fit, measurements: &[Measurement]) -> Vec<Pattern> {
    const ALONG: [&str; 3] = ["residual along x", "residual along y", "residual along z"];
    const SIZE: &str = "size of the residual";
    let residuals = length_residuals(fit, measurements);
    let mut patterns = Vec::new();
    const LOAD_SIGNED: &str = "lost motion, or a stiffness that changes with the load: the share is larger where the force is small (lost \
                               motion, a stiffness that grows) or where it is large (one that falls)";
    if let Some((correlation, limit)) = load_correlation(&residuals, measurements) {
        let (of, with) = ("residual along the predicted displacement", "size of the force, as a share of it".into());
        patterns.push(Pattern { of, with, hint: LOAD_SIGNED, correlation, limit });
    }
    let mut add = |of: &'static str, with: String, hint: &'static str, pairs: Vec<(f64, f64)>| {
        if let Some((correlation, limit)) = rank_correlation(&pairs) {
            patterns.push(Pattern { of, with, hint, correlation, limit });
        }
    };
    let pairs = |value: &dyn Fn(usize, &Measurement) -> f64, of: &dyn Fn(&LengthResidual) -> Option<f64>| {
        let rows = residuals.iter().zip(measurements).enumerate();
        rows.filter_map(|(i, (residuals, m))| Some((value(i, m), of(residuals.as_ref()?)?))).collect::<Vec<_>>()
    };
    let sizes = |value: &dyn Fn(usize, &Measurement) -> f64| pairs(value, &|residual| Some(residual.size));
    const DRIFT: &str = "drift: something changed while measuring";
    const LOAD: &str = "yielding that the model lacks; try play of the drives, bearings that tilt (an arm's elbow first), elastic links";
    const POSE: &str = "a stiffness or an error that changes with the pose: links, bearings, gravity springs";
    add(SIZE, "order of measuring".into(), DRIFT, sizes(&|i, _| i as f64));
    add(SIZE, "size of the force".into(), LOAD, sizes(&|_, m| (m.load.force - m.reference.force).norm()));
    for (axis, word) in ["x", "y", "z"].into_iter().enumerate() {
        let share = |m: &Measurement| {
            let force = m.load.force - m.reference.force;
            force.try_normalize(0.0).map_or(0.0, |unit| unit[axis].abs())
        };
        let hint = "yielding in a direction that the model lacks";
        add(SIZE, format!("share of the force along {word}"), hint, sizes(&|_, m| share(m)));
    }
    let reach = |_: usize, m: &Measurement| m.at.pose.transform(machine.tool_tip).norm();
    add(SIZE, "distance of the tool tip from O".into(), POSE, sizes(&reach));
    for (k, label) in machine.drive_labels().into_iter().enumerate() {
        add(SIZE, format!("position of {label}"), POSE, sizes(&|_, m| m.at.drives[k]));
    }
    for axis in 0..3 {
        let along = |value: &dyn Fn(usize, &Measurement) -> f64| pairs(value, &|residual| residual.along[axis]);
        add(ALONG[axis], "order of measuring".into(), DRIFT, along(&|i, _| i as f64));
        let force = |_: usize, m: &Measurement| m.load.force[axis] - m.reference.force[axis];
        let with = format!("force along {}", ["x", "y", "z"][axis]);
        add(ALONG[axis], with, "yielding along the force that the model lacks", along(&force));
    }
    patterns
}

/// Returns the rank correlation of force with the missing share of the predicted displacement, and its limit. The displacement per force is
/// partialled out, as missing compliance is the same share under any force: only nonlinear elasticity correlates. `None` for under `FEWEST` or
/// constant values, or where the displacement per force alone ranks the force or the share.
fn load_correlation(residuals: &[Option<LengthResidual>], measurements: &[Measurement]) -> Option<(f64, f64)> {
    let rows = residuals.iter().zip(measurements).filter_map(|(residuals, m)| {
        let (predicted, share) = residuals.as_ref()?.along_predicted?;
        let force = (m.load.force - m.reference.force).norm();
        (force > 0.0).then(|| [share, force, predicted / force])
    });
    let rows: Vec<[f64; 3]> = rows.collect();
    let rank = |a: usize, b: usize| rank_correlation(&rows.iter().map(|row| (row[a], row[b])).collect::<Vec<_>>());
    let ((share_force, _), (share_yield, _), (force_yield, _)) = (rank(0, 1)?, rank(0, 2)?, rank(1, 2)?);
    let rest = ((1.0 - share_yield * share_yield) * (1.0 - force_yield * force_yield)).sqrt();
    let limit = libm::tanh(ONCE_IN_A_THOUSAND * (1.06 / (rows.len() as f64 - 4.0)).sqrt());
    (rest > 1e-6).then(|| (((share_force - share_yield * force_yield) / rest).clamp(-1.0, 1.0), limit))
}

/// Returns rank correlation and its once-in-a-thousand limit (Fieller, Hartley and Pearson 1957); `None` for under `FEWEST` or constant
/// values.
pub fn rank_correlation(pairs: &[(f64, f64)]) -> Option<(f64, f64)> {
    if pairs.len() < FEWEST {
        return None;
    }
    let (a, b) = (ranks(pairs.iter().map(|pair| pair.0)), ranks(pairs.iter().map(|pair| pair.1)));
    let mean = (pairs.len() - 1) as f64 / 2.0;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let size = (product(&a, &a) * product(&b, &b)).sqrt();
    let limit = libm::tanh(ONCE_IN_A_THOUSAND * (1.06 / (pairs.len() as f64 - 3.0)).sqrt());
    (size > 0.0).then(|| (product(&a, &b) / size, limit))
}

/// Returns the rank of each of `values`, from 0 for the smallest; equal values share their mean rank.
pub fn ranks(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let values: Vec<f64> = values.collect();
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for group in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let rank = first as f64 + (group.len() - 1) as f64 / 2.0;
        group.iter().for_each(|&i| ranks[i] = rank);
        first += group.len();
    }
    ranks
}
