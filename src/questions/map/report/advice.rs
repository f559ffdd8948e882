//! What one measurement would gain, where inputs are uncertain.

use super::summary::AtAngle;
use crate::{
    answer::ValueAt,
    input::error,
    questions::map::{WorkspaceMapStudy, run_range},
    simulation::{Source, spread::IfMeasured},
    spatial::Grid,
    work::Work,
};

/// Solves `study` anew where the 95 % quantile is the largest, `worst`, with each of `causes` measured, as far as it can be alone; returns what is worth most. `Err` if `work` is stopped, or an input makes no machine.
pub(super) fn advise<'c>(
    study: &WorkspaceMapStudy,
    worst: &ValueAt<AtAngle>,
    causes: impl Iterator<Item = &'c str>,
    work: &Work,
) -> error::Result<Option<IfMeasured>> {
    let work = work.part("measured");
    let measured = |cause: &str| -> error::Result<Option<IfMeasured>> {
        let Some((uncertainty, known)) = study.uncertainty.as_ref().and_then(|own| own.measured(cause)) else {
            return Ok(None);
        };
        let grid = Grid { axes: worst.position_mm.map(|own| vec![own]) };
        let there = WorkspaceMapStudy { grid, uncertainty: Some(uncertainty), load_case: study.load_case.clone() };
        let points = run_range(&there, 0..1, &work)?;
        let effect = points.first().and_then(|point| point.effect(Source::All));
        let then = effect.and_then(|own| own.spread.as_ref()?.p95_mm);
        Ok(then.map(|then| IfMeasured { cause: cause.into(), known: known.into(), p95_mm: [worst.value, then] }))
    };
    work.piece(
        &0,
        |_| 0,
        || {
            let all = causes.map(measured).collect::<error::Result<Vec<_>>>()?;
            Ok(IfMeasured::worth_most(all.into_iter().flatten()))
        },
    )
}
