//! Statistics over random seeds: bands of the residual for each force error, and the force error from which on-line correction pays.

use serde::Serialize;

use super::{Residual, Trial};

/// Quantiles over seeds of the RMS residual for one force error, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Band {
    /// p: standard deviation of the relative error of the predicted force.
    pub force_error: f64,
    /// 5 % quantile.
    pub low_mm: f64,
    /// Median.
    pub median_mm: f64,
    /// 95 % quantile.
    pub high_mm: f64,
}

impl Band {
    /// Returns the band of each force error of `trials`, in their order, of residuals that `residual_of` picks; `None` where there are
    /// none.
    pub fn of(trials: &[Trial], residual_of: impl Fn(&Trial) -> Residual) -> Vec<Option<Band>> {
        let by_error = trials.chunk_by(|a, b| a.force_error == b.force_error);
        by_error
            .map(|trials| {
                let mut sizes: Vec<f64> = trials.iter().filter_map(|trial| residual_of(trial).rms_mm).collect();
                sizes.sort_by(f64::total_cmp);
                let force_error = trials[0].force_error;
                let at = |share| quantile(&sizes, share);
                Some(Band { force_error, low_mm: at(0.05)?, median_mm: at(0.5)?, high_mm: at(0.95)? })
            })
            .collect()
    }
}

/// Returns the quantile of `share` (0 to 1) of ascending `values`, linear between them; `None` if there are none.
fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let rank = share * values.len().checked_sub(1)? as f64;
    let (low, high) = (values[rank.floor() as usize], values[rank.ceil() as usize]);
    Some(low + (high - low) * rank.fract())
}

/// Force error from which correction by measured forces has the smaller median residual than by predicted forces.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum BreakEven {
    /// Smaller even where the prediction is right.
    Always,
    /// Smaller from this force error on, linear between those computed.
    From(f64),
    /// Not smaller up to this force error, the largest computed.
    Never(f64),
}

impl BreakEven {
    /// Compares the medians of both ways to correct, a band for each force error; `None` if no force error has both.
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
