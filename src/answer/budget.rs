//! What a verdict rests on as a table, a figure and JSON: one row for each cause of error.

use kinetostat_budget::{Budget, Cause, Entry, Mark};
use serde_json::{Value, json};

use super::clearance::CLEARANCE;
use crate::{
    figures::{BudgetBar, BudgetFigure, BudgetRow, Figure},
    files::{
        exchange::{Table, numbers, texts},
        words::{millimetres, percent},
    },
    page::Section,
    process::uncertainty::{CauseShare, Shares},
};

/// File stem of table and figure.
pub const BUDGET: &str = "budget";
/// What the table says.
pub const CAPTION: &str = "One row per cause of error: how it is known, by whom, and what it contributes.";

/// What is known of the causes of the number that is judged.
#[derive(Debug, Clone, Copy)]
pub struct OfVerdict<'a> {
    /// The causes that the verdict is about.
    pub budget: &'a Budget,
    /// What those that vary contribute; `None` with nominal inputs.
    pub shares: Option<&'a Shares>,
    /// The number that is judged, mm.
    pub judged_mm: Option<f64>,
    /// What it is held to, mm.
    pub tolerance_mm: Option<f64>,
}

impl OfVerdict<'_> {
    /// What varies by cause, the largest share of the variance first.
    fn shares(&self) -> Vec<&CauseShare> {
        let mut all: Vec<&CauseShare> = self.shares.iter().flat_map(|own| &own.causes).collect();
        all.sort_by(|a, b| b.variance_share.total_cmp(&a.variance_share));
        all
    }

    /// Makes the table: how each cause is known, and what it contributes.
    pub fn table(&self) -> Table {
        let names = ["cause", "mark", "source", "in_judged_number"];
        let columns = [texts(names), numbers(["bound_mm", "p95_if_known_mm", "variance_share"])].concat();
        let share = |entry: &Entry| self.shares().into_iter().find(|own| own.cause == Some(entry.cause));
        let of_entry = |entry: &Entry| {
            let own = share(entry);
            let mark = match entry.mark {
                Mark::Full => "full",
                Mark::Half => "half",
                Mark::Hollow => "hollow",
            };
            let in_number = match (entry.mark, entry.counted) {
                (Mark::Hollow, _) => "unknown",
                (_, true) => "yes",
                (_, false) => "added",
            };
            vec![
                entry.cause.text().into(),
                mark.into(),
                entry.source.as_str().into(),
                in_number.into(),
                entry.mm.into(),
                own.map(|own| own.if_known_mm).into(),
                own.map(|own| own.variance_share).into(),
            ]
        };
        let setup = self.shares().into_iter().filter(|own| own.cause.is_none()).map(|own| {
            let nothing: Option<f64> = None;
            vec![
                SETUP.into(),
                "half".into(),
                "as [uncertainty] gives it".into(),
                "yes".into(),
                nothing.into(),
                Some(own.if_known_mm).into(),
                Some(own.variance_share).into(),
            ]
        });
        Table::new(columns, self.budget.entries().map(of_entry).chain(setup))
    }

    /// Draws what each cause takes of the tolerance; `None` where nothing is judged, or nothing is beside the number that is.
    pub fn figure(&self) -> Option<Figure> {
        let judged = self.judged_mm?;
        let mut rows = Vec::new();
        match self.shares {
            None => rows.push(BudgetRow {
                label: "computed".into(),
                bar: BudgetBar::Length(judged),
                words: millimetres(judged, 3),
            }),
            Some(all) => rows.extend(self.shares().into_iter().map(|own| BudgetRow {
                label: own.cause.map_or_else(|| SETUP.into(), |cause| self.label(cause)),
                bar: BudgetBar::IfKnown([own.if_known_mm, all.p95_mm]),
                words: format!(
                    "{} left, {} of the variance",
                    millimetres(own.if_known_mm, 3),
                    percent(own.variance_share).replace(' ', "\u{a0}")
                ),
            })),
        }
        let mut bounds: Vec<&Entry> =
            self.budget.entries().filter(|own| own.mark != Mark::Hollow && !own.counted && own.mm.is_some()).collect();
        bounds.sort_by(|a, b| b.mm.unwrap_or(0.0).total_cmp(&a.mm.unwrap_or(0.0)));
        rows.extend(bounds.into_iter().map(|own| BudgetRow {
            label: self.label(own.cause),
            bar: BudgetBar::Length(own.mm.unwrap_or(0.0)),
            words: format!("{} added", millimetres(own.mm.unwrap_or(0.0), 3)),
        }));
        rows.extend(self.budget.unknown().into_iter().map(|own| BudgetRow {
            label: self.label(own),
            bar: BudgetBar::Unknown,
            words: match self.entry(own).and_then(|entry| entry.mm) {
                Some(mm) => format!("more than {}", millimetres(mm, 3)),
                None => "unknown".into(),
            },
        }));
        if rows.len() < 2 {
            return None;
        }
        let subtitle = match self.shares {
            None => "the number that is judged, and what is added to it".into(),
            Some(all) => {
                let [x, y, z] =
                    [0, 1, 2].map(|axis| format!("{:.3} ± {:.3}", all.mean_mm[axis], all.expanded_mm[axis]));
                format!(
                    "distance that is not exceeded with 95 % probability, {} where it is largest (along the base, mean ± U with k = 2: x {x}, y {y}, z {z} mm); what is added to it",
                    millimetres(all.p95_mm, 3)
                )
            }
        };
        let title = "What each cause takes of the tolerance".into();
        Some(Figure::Budget(BudgetFigure { title, subtitle, tolerance_mm: self.tolerance_mm, rows }))
    }

    fn entry(&self, cause: Cause) -> Option<&Entry> {
        self.budget.entries().find(|own| own.cause == cause)
    }

    /// Mark and name of a cause; the name alone where it is not asked about.
    fn label(&self, cause: Cause) -> String {
        self.entry(cause).map_or_else(|| cause.text().into(), |own| format!("{} {}", own.mark.sign(), cause.text()))
    }

    /// Returns the section of a page with figure and table.
    pub fn section() -> Section {
        Section::new(
            "What does the verdict rest on?",
            "what each cause of error takes of the tolerance, and which nobody knows",
        )
        .figures(&[BUDGET, CLEARANCE])
    }

    /// Returns the causes as JSON.
    pub fn json(&self) -> Value {
        json!({
            "judged_mm": self.judged_mm,
            "tolerance_mm": self.tolerance_mm,
            "causes": self.budget.entries().collect::<Vec<_>>(),
            "where_largest": self.shares,
        })
    }
}

/// What is no number of the machine.
const SETUP: &str = "setup";
