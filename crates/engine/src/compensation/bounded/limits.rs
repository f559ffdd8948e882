//! Limits of the drives, by process and machine, checked; and the corrections within them.
//!
//! Limits on the correction, the travel and its change from point to point concern each drive by itself and are linear: whether they can all be
//! kept, and the nearest corrections that keep them, follow from intervals. Only the limits on forces need the machine.

use std::fmt;

use serde::Serialize;

use super::{error::BoundedError, program::RowLimit};
use crate::machine::{Drive, Machine};

/// Limits of each drive along a path. One entry per drive in machine order where a list is given; an infinite entry is no limit. The
/// default is what the machine itself sets: its travel and its force limits.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Limits {
    /// Largest |Δρ|, mm or rad.
    pub correction: Option<Vec<f64>>,
    /// Largest |Δρ_k − Δρ_{k−1}| between neighbouring points, mm or rad. Does not apply across a point that is left out.
    pub correction_change: Option<Vec<f64>>,
    /// Smallest and largest ρ, mm or rad; `None`: the machine's own [`Drive::travel`].
    pub travel: Option<Vec<(f64, f64)>>,
    /// Largest |τ|, N or N·mm; `None`: the machine's own [`Drive::force_limit`].
    pub force: Option<Vec<f64>>,
}

/// Kind of a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum LimitKind {
    /// Size of the correction, |Δρ|.
    Correction,
    /// Travel of the drive, ρ.
    Travel,
    /// Change of the correction from the point before, |Δρ_k − Δρ_{k−1}|.
    Change,
    /// Force of the drive, |τ|.
    Force,
}

impl LimitKind {
    /// Word used in tables.
    pub fn label(self) -> &'static str {
        match self {
            LimitKind::Correction => "correction",
            LimitKind::Travel => "travel",
            LimitKind::Change => "change",
            LimitKind::Force => "force",
        }
    }
}

impl fmt::Display for LimitKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            LimitKind::Correction => "limit on the correction",
            LimitKind::Travel => "travel",
            LimitKind::Change => "limit on the change from point to point",
            LimitKind::Force => "force limit",
        })
    }
}

/// End of a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Side {
    /// The value is as small as it may be.
    Lower,
    /// The value is as large as it may be.
    Upper,
}

/// The limits of one path, as intervals of the corrections u = Δρ of the points that take part.
#[derive(Debug, Clone)]
pub(super) struct Bounds {
    /// Smallest and largest u of each point and drive (point-major), mm or rad.
    pub range: Vec<[Bound; 2]>,
    /// Largest change of each drive; infinite where there is none.
    pub change: Vec<f64>,
    /// Largest force of each drive; infinite where there is none.
    pub force: Vec<f64>,
    /// Whether a point follows directly on the one before it in this list.
    pub is_consecutive: Vec<bool>,
    /// Index in the path of each point that takes part.
    pub index: Vec<usize>,
}

/// One end of an interval, and the kind of limit that sets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bound {
    pub value: f64,
    pub kind: LimitKind,
}

/// A value nearer to its limit than this binds: mm or rad, or a share of the limit of a force.
const TOUCH: f64 = 1e-5;

/// Limits of all drives after checks, in machine order; infinite where there is none.
struct CheckedLimits {
    correction: Vec<f64>,
    travel: Vec<(f64, f64)>,
    change: Vec<f64>,
    force: Vec<f64>,
}

impl Limits {
    /// Whether any drive of `machine` has a force limit.
    pub(super) fn has_force_limits(&self, machine: &Machine) -> bool {
        match &self.force {
            Some(limits) => limits.iter().any(|limit| limit.is_finite()),
            None => machine.drives().any(|(_, drive)| drive.force_limit.is_some()),
        }
    }

    /// Limits of all drives of `machine`, one entry each; those not set are the machine's, or infinite. `Err` for a wrong length or value.
    fn check(&self, machine: &Machine) -> Result<CheckedLimits, BoundedError> {
        let none = || vec![f64::INFINITY; machine.drive_count()];
        let own_travel = |drive: &Drive| drive.travel.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let checked = CheckedLimits {
            correction: self.correction.clone().unwrap_or_else(none),
            change: self.correction_change.clone().unwrap_or_else(none),
            travel: self.travel.clone().unwrap_or_else(|| machine.drives().map(|(_, d)| own_travel(d)).collect()),
            force: self
                .force
                .clone()
                .unwrap_or_else(|| machine.drives().map(|(_, d)| d.force_limit.unwrap_or(f64::INFINITY)).collect()),
        };
        let sizes = [(LimitKind::Correction, &checked.correction), (LimitKind::Change, &checked.change)];
        for (kind, values) in sizes {
            check_values(machine, kind, values, |value| *value >= 0.0, "a number of at least 0")?;
        }
        check_values(machine, LimitKind::Force, &checked.force, |value| *value > 0.0, "a number above 0")?;
        let is_range = |(low, high): &(f64, f64)| low <= high;
        check_values(machine, LimitKind::Travel, &checked.travel, is_range, "a range, smallest first")?;
        Ok(checked)
    }
}

/// Checks that `values` has one value for each drive and that `is_good` holds for all; `expected` says in the `Err` what is good.
fn check_values<T: fmt::Debug>(
    machine: &Machine,
    limit: LimitKind,
    values: &[T],
    is_good: impl Fn(&T) -> bool,
    expected: &'static str,
) -> Result<(), BoundedError> {
    let drives = machine.drive_labels();
    if values.len() != drives.len() {
        return Err(BoundedError::Count { limit, got: values.len(), expected: drives.len() });
    }
    match values.iter().zip(drives).find(|(value, _)| !is_good(value)) {
        Some((value, drive)) => Err(BoundedError::Value { limit, drive, value: format!("{value:?}"), expected }),
        None => Ok(()),
    }
}

impl Bounds {
    /// The limits on a path whose points `index` take part, with drives `nominal` (mm, rad) by nominal inverse kinematics.
    ///
    /// # Errors
    /// A limit that makes no sense, or limits on correction, travel and change that exclude one another.
    pub fn new(
        limits: &Limits,
        machine: &Machine,
        index: Vec<usize>,
        nominal: &[&[f64]],
    ) -> Result<Self, BoundedError> {
        let CheckedLimits { correction, travel, change, force } = limits.check(machine)?;
        let mut range = Vec::with_capacity(nominal.len() * correction.len());
        for rho in nominal {
            for (i, rho) in rho.iter().enumerate() {
                let (low, high) = (travel[i].0 - rho, travel[i].1 - rho);
                range.push([
                    tighter_bound(-correction[i], low, low > -correction[i]),
                    tighter_bound(correction[i], high, high < correction[i]),
                ]);
            }
        }
        let is_consecutive = (0..index.len()).map(|k| k > 0 && index[k] == index[k - 1] + 1).collect();
        let bounds = Self { range, change, force, is_consecutive, index };
        bounds.check_feasible(machine, nominal, &travel)?;
        Ok(bounds)
    }

    /// Number of drives.
    pub fn drive_count(&self) -> usize {
        self.change.len()
    }

    /// Number of points that take part.
    pub fn point_count(&self) -> usize {
        self.is_consecutive.len()
    }

    /// Smallest and largest correction of a drive at a point, mm or rad.
    fn range(&self, point: usize, drive: usize) -> [f64; 2] {
        self.range[point * self.drive_count() + drive].map(|bound| bound.value)
    }

    /// Checks that limits on correction, travel and change can be kept together, by the reachable interval of each drive along the path;
    /// the `Err` names the points that set the ends of the first empty one.
    fn check_feasible(&self, machine: &Machine, nominal: &[&[f64]], travel: &[(f64, f64)]) -> Result<(), BoundedError> {
        let names = machine.drive_labels();
        for (i, ((_, drive), name)) in machine.drives().zip(names).enumerate() {
            let (mut low, mut high) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
            for k in 0..self.point_count() {
                let [lower, upper] = self.range(k, i);
                if lower > upper {
                    let (point, unit) = (self.index[k], drive.motion.computed_position_unit());
                    let (nominal, limit) = (nominal[k][i], if lower > 0.0 { upper } else { -lower });
                    let needed = if lower > 0.0 { lower } else { -upper };
                    let travel = travel[i];
                    return Err(BoundedError::Travel { drive: name, point, nominal, travel, needed, limit, unit });
                }
                let reach = if self.is_consecutive[k] { self.change[i] } else { f64::INFINITY };
                (low, high) = ((low.0 - reach, low.1), (high.0 + reach, high.1));
                let jump = match () {
                    () if lower > high.0 => Some((high.1, lower - self.range(high.1, i)[1])),
                    () if upper < low.0 => Some((low.1, self.range(low.1, i)[0] - upper)),
                    () => None,
                };
                if let Some((first, needed)) = jump {
                    let (from, to, limit) = (self.index[first], self.index[k], self.change[i]);
                    let unit = drive.motion.computed_position_unit();
                    return Err(BoundedError::Change { drive: name, from, to, needed, limit, unit });
                }
                if lower > low.0 {
                    low = (lower, k);
                }
                if upper < high.0 {
                    high = (upper, k);
                }
            }
        }
        Ok(())
    }

    /// Moves `corrections` (point-major) to values that keep the limits on correction, travel and change exactly, up to
    /// rounding. Values that keep them already stay as they are.
    pub fn project(&self, corrections: &mut [f64]) {
        let (count, points) = (self.drive_count(), self.point_count());
        for i in 0..count {
            // From the end: what each point may be, so that all later ones can follow.
            let mut allowed: Vec<[f64; 2]> = (0..points).map(|k| self.range(k, i)).collect();
            for k in (1..points).rev().filter(|&k| self.is_consecutive[k]) {
                let [low, high] = allowed[k];
                allowed[k - 1][0] = allowed[k - 1][0].max(low - self.change[i]);
                allowed[k - 1][1] = allowed[k - 1][1].min(high + self.change[i]);
            }
            for k in 0..points {
                let [mut low, mut high] = allowed[k];
                if self.is_consecutive[k] {
                    let before = corrections[(k - 1) * count + i];
                    low = low.max(before - self.change[i]);
                    high = high.min(before + self.change[i]);
                }
                let value = &mut corrections[k * count + i];
                *value = value.min(high).max(low);
            }
        }
    }

    /// Whether `candidate`, corrections of point `k` (one per drive), keeps the limits on correction, travel and change in `corrections`.
    pub fn allows(&self, k: usize, candidate: &[f64], corrections: &[f64]) -> bool {
        let count = self.drive_count();
        candidate.iter().enumerate().all(|(i, &u)| {
            let [low, high] = self.range(k, i);
            let near = |other: usize| (u - corrections[other * count + i]).abs() <= self.change[i];
            let before = !self.is_consecutive[k] || near(k - 1);
            let after = !self.is_consecutive.get(k + 1).is_some_and(|is_consecutive| *is_consecutive) || near(k + 1);
            low <= u && u <= high && before && after
        })
    }

    /// Largest excess of a drive's force over its limit, as a share of it; 0 if all are kept. `forces`: of each point, one per drive.
    pub fn force_excess<'f>(&self, forces: impl Iterator<Item = &'f [f64]>) -> f64 {
        let shares = forces.flat_map(|forces| forces.iter().zip(&self.force));
        shares.map(|(force, limit)| force.abs() / limit - 1.0).fold(0.0, f64::max)
    }

    /// Narrows the range of each drive at each point to `corrections` (point-major) ± `steps` (one per drive), mm or rad.
    pub fn narrow(&mut self, corrections: &[f64], steps: &[f64]) {
        for (column, [low, high]) in self.range.iter_mut().enumerate() {
            let (present, step) = (corrections[column], steps[column % steps.len()]);
            low.value = low.value.max(present - step);
            high.value = high.value.min(present + step);
        }
    }

    /// Whether `limit` binds, to [`TOUCH`], at the `corrections` of the path and the drive `forces` of its point.
    pub fn is_binding(&self, limit: &RowLimit, corrections: &[f64], forces: &[f64]) -> bool {
        let RowLimit { point, drive, kind, side } = *limit;
        let column = point * self.drive_count() + drive;
        let sign = match side {
            Side::Lower => -1.0,
            Side::Upper => 1.0,
        };
        let (slack, scale) = match kind {
            LimitKind::Correction | LimitKind::Travel => {
                let end = self.range[column][usize::from(side == Side::Upper)].value;
                (sign * (end - corrections[column]), 1.0)
            }
            LimitKind::Change => {
                let change = corrections[column] - corrections[column - self.drive_count()];
                (self.change[drive] - sign * change, 1.0)
            }
            LimitKind::Force => (self.force[drive] - sign * forces[drive], self.force[drive]),
        };
        slack <= TOUCH * scale
    }

    /// Whether any drive has a force limit.
    pub fn has_force_limits(&self) -> bool {
        self.force.iter().any(|limit| limit.is_finite())
    }
}

/// The bound by travel if it is the tighter one, else that by the limit on the correction.
fn tighter_bound(correction: f64, travel: f64, travel_is_tighter: bool) -> Bound {
    match travel_is_tighter {
        true => Bound { value: travel, kind: LimitKind::Travel },
        false => Bound { value: correction, kind: LimitKind::Correction },
    }
}
