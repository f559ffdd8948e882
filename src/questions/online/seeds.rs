//! What seeds come to: bands of the residual over the force error, and where on-line begins to pay.

use serde::Serialize;

use super::{Residual, Trial};

/// Residuals of one force error over seeds: root mean squares, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Band {
    /// p.
    pub force_error: f64,
    /// One seed in twenty leaves less.
    pub low_mm: f64,
    /// Half of them leave less.
    pub median_mm: f64,
    /// One in twenty leaves more.
    pub high_mm: f64,
}

impl Band {
    /// For each force error of `trials`, in their order: of those residuals that `pick` takes; `None` where no seed has one.
    pub fn of(trials: &[Trial], pick: impl Fn(&Trial) -> Residual) -> Vec<Option<Band>> {
        let by_error = trials.chunk_by(|a, b| a.force_error == b.force_error);
        by_error
            .map(|trials| {
                let mut sizes: Vec<f64> = trials.iter().filter_map(|trial| pick(trial).rms_mm).collect();
                sizes.sort_by(f64::total_cmp);
                let force_error = trials[0].force_error;
                let at = |share| quantile(&sizes, share);
                Some(Band { force_error, low_mm: at(0.05)?, median_mm: at(0.5)?, high_mm: at(0.95)? })
            })
            .collect()
    }
}

/// The quantile of ascending `values`, linear between them; `None` of none.
fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let place = share * values.len().checked_sub(1)? as f64;
    let (low, high) = (values[place.floor() as usize], values[place.ceil() as usize]);
    Some(low + (high - low) * place.fract())
}

/// From which force error on correction by measured forces leaves less than by predicted ones, in the median over seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum BreakEven {
    /// It leaves less even where the prediction is right.
    Always,
    /// From this force error on, linear between those computed.
    From(f64),
    /// Up to this force error, the largest computed, it never does.
    Never(f64),
}

impl BreakEven {
    /// Of the bands of both, one for each force error; `None` where there are none to compare.
    pub fn of(offline: &[Option<Band>], online: &[Option<Band>]) -> Option<BreakEven> {
        let gains = offline.iter().zip(online).filter_map(|(offline, online)| {
            let (offline, online) = ((*offline)?, (*online)?);
            Some((offline.force_error, offline.median_mm - online.median_mm))
        });
        let gains: Vec<(f64, f64)> = gains.collect();
        let (first, last) = (gains.first()?, gains.last()?);
        if first.1 > 0.0 {
            return Some(BreakEven::Always);
        }
        let crossing = gains.windows(2).find(|pair| pair[1].1 > 0.0);
        Some(crossing.map_or(BreakEven::Never(last.0), |pair| {
            let ((from, below), (to, above)) = (pair[0], pair[1]);
            BreakEven::From(from + (to - from) * -below / (above - below))
        }))
    }
}
