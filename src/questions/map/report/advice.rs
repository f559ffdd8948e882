//! What one measurement would gain, where inputs are uncertain.

use serde::{Deserialize, Serialize};

use super::summary::AtAngle;
use crate::{
    answer::ValueAt,
    input::error,
    questions::map::{WorkspaceMapStudy, run_range},
    simulation::Source,
    spatial::Grid,
    work::Work,
};

/// What becomes of the largest 95 % quantile of a map if its main cause is measured.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Advice {
    /// The cause.
    pub cause: String,
    /// How well it is known then.
    pub known: String,
    /// The quantile as it is, and then, mm.
    pub p95_mm: [f64; 2],
}

/// Solves `study` anew where the 95 % quantile is the largest, `worst`, with each of `causes` measured, as far as it can be alone; returns what is worth most. `Err` if `work` is stopped, or an input makes no machine.
pub(super) fn advise<'c>(
    study: &WorkspaceMapStudy,
    worst: &ValueAt<AtAngle>,
    causes: impl Iterator<Item = &'c str>,
    work: &Work,
) -> error::Result<Option<Advice>> {
    let work = work.part("measured");
    let measured = |cause: &str| -> error::Result<Option<Advice>> {
        let Some((uncertainty, known)) = study.uncertainty.as_ref().and_then(|own| own.measured(cause)) else {
            return Ok(None);
        };
        let grid = Grid { axes: worst.position_mm.map(|own| vec![own]) };
        let there = WorkspaceMapStudy { grid, uncertainty: Some(uncertainty), scene: study.scene.clone() };
        let points = run_range(&there, 0..1, &work)?;
        let effect = points.first().and_then(|point| point.effect(Source::All));
        let then = effect.and_then(|own| own.spread.as_ref()?.p95_mm);
        Ok(then.map(|then| Advice { cause: cause.into(), known: known.into(), p95_mm: [worst.value, then] }))
    };
    work.piece(
        &0,
        |_| 0,
        || {
            let all = causes.map(measured).collect::<error::Result<Vec<_>>>()?;
            Ok(all.into_iter().flatten().min_by(|a, b| a.p95_mm[1].total_cmp(&b.p95_mm[1])))
        },
    )
}
