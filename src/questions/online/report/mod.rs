//! Reports of an online study.

mod answer;
mod headline;
mod page;
mod picture;
mod tables;
mod text;

use super::{Band, BreakEven, OnlineResults, OnlineStudy};

/// What is said of the results, computed once.
struct Compared<'a> {
    study: &'a OnlineStudy,
    results: &'a OnlineResults,
    offline: Vec<Option<Band>>,
    online: Vec<Option<Band>>,
    break_even: Option<BreakEven>,
}

impl<'a> Compared<'a> {
    fn new(study: &'a OnlineStudy, results: &'a OnlineResults) -> Self {
        let offline = Band::of(&results.trials, |trial| trial.offline);
        let online = Band::of(&results.trials, |trial| trial.online);
        let break_even = BreakEven::of(&offline, &online);
        Self { study, results, offline, online, break_even }
    }

    /// The medians of off-line and on-line at the largest force error, mm.
    fn at_the_largest(&self) -> Option<[f64; 2]> {
        Some([(*self.offline.last()?)?.median_mm, (*self.online.last()?)?.median_mm])
    }
}

/// A share in per cent, as short as it is true.
fn percent_of(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 10.0 || percent.fract() == 0.0 { format!("{percent:.0} %") } else { format!("{percent:.1} %") }
}
