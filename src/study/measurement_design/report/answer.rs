//! A plan of measurements into its folder.

use serde_json::json;

use super::{
    headline, page,
    pictures::figures,
    summary::{Report, json},
    tables, text,
};
use crate::{
    input::error::Result,
    report::{Manifest, Output, Run, page::Description},
    study::{
        SOLVED,
        measurement_design::{MeasurementDesignStudy, run},
    },
};

/// Chooses the measurements and makes what is left.
///
/// # Errors
/// Of the work.
pub fn answer(study: &MeasurementDesignStudy, asked: &Run<'_>) -> Result<Output> {
    let settings = json!({
        "candidates": study.candidates.len(), "unknowns": study.unknowns.len(), "count": study.count, "draws": study.draws
    });
    let plan = match run(study, asked.work)? {
        Ok(plan) => plan,
        Err(failure) => {
            let headline = headline::failed(study, &failure);
            return Ok(Output {
                settings,
                statuses: Manifest::count([&*failure.status].into_iter()),
                is_answered: Some(false),
                tables: tables::none(study),
                streamed: Default::default(),
                summary: json!({ "schema": 1, "status": failure.status, "reason": failure.reason }),
                figures: Vec::new(),
                page: Description { headline, ..page::without_answer(study) },
                bent: None,
                details: failure.reason,
                best_place: None,
            });
        }
    };
    let report = Report { study, plan: &plan };
    let failed = plan.failures.iter().map(|(_, failure)| &*failure.status);
    let solved = std::iter::repeat_n(SOLVED, study.candidates.len() - plan.failures.len());
    Ok(Output {
        settings,
        statuses: Manifest::count(solved.chain(failed)),
        is_answered: Some(!plan.chosen.is_empty()),
        tables: tables::tables(&report),
        streamed: Default::default(),
        summary: json(&report),
        figures: asked.drawn(|| figures(&report)),
        page: Description { headline: headline::headline(&report), ..page::page(&report) },
        bent: None,
        details: text::details(&report),
        best_place: None,
    })
}
