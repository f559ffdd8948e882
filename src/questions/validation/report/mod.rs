//! Report of a validation study: its page, tables and figures.

mod compared;
mod pictures;

pub use compared::{differences, quoted_table, variants_table};
pub use pictures::{figures, short_number};

use serde_json::json;

use crate::{
    answer::{Output, Run, facts_of, machine::described},
    files::Manifest,
    input::{check::file_stem, error::Result},
    page::{Description, Explorer, Fact, Section, TableNote},
    questions::{
        Answered,
        path::report::{DISPLACEMENT, facts_text, points_table, points_view},
        validation::{self, Shown, ValidationResults, ValidationStudy},
    },
};

impl Answered for ValidationStudy {
    /// Runs the study, and makes tables, figures, page and summary.
    fn answer(&self, shown: &Shown, run: &Run<'_>) -> Result<Output> {
        let results = validation::run(self, run.work)?;
        let sources = results.paths.iter().flat_map(|path| path.whole.sources.iter());
        let statuses = sources.flat_map(|(_, along)| along).map(|at| at.answer.status.label());
        let compared = results.compared.iter().flat_map(|compared| &compared.ours).map(compared::status);
        let points: Vec<usize> = results.paths.iter().map(|path| path.study.stations.len()).collect();
        let mut tables =
            vec![("summary".to_string(), quoted_table(&results)), ("variants".to_string(), variants_table(&results))];
        for (case, path) in self.cases.iter().zip(&results.paths) {
            tables.push((points_table_name(case), points_table(&path.study, &path.whole)));
        }
        let assumed = facts_text(&self.variants[0].paths[0].assumed);
        let text = differences(&results);
        Ok(Output {
            tables,
            figures: run.draw_figures(|| figures(&results, shown)),
            details: format!("{}\n{text}", compared::summary_text(&results)),
            ..Output::of(
                json!({ "points": points }),
                Manifest::count(statuses.chain(compared)),
                compared::summary_json(&results),
                Description { headline: compared::headline(&results, &assumed), ..page(&results, &text) },
            )
        })
    }
}

/// Returns the name of the table with the points of a case.
fn points_table_name(case: &str) -> String {
    format!("points_{}", file_stem(case))
}

/// Returns sections, setting, views and tables of the page; first screen, figures and question are added by the run.
pub fn page(results: &ValidationResults, differences: &str) -> Description {
    let study = &results.study;
    let mut tables = vec![
        TableNote::new("summary.csv", "Numbers quoted and ours, and why they differ."),
        TableNote::new("variants.csv", "The same numbers under each process."),
    ];
    for case in &study.cases {
        let caption = format!("{case}: one row per point and source of error.");
        tables.push(TableNote::ranked(&format!("{}.csv", points_table_name(case)), &caption, &DISPLACEMENT.name));
    }
    let explorers: Vec<Explorer> = study.cases.iter().map(|case| case_view(study, case)).collect();
    let sections = vec![
        Section::new("Which numbers agree?", "each number quoted, ours, and why they differ")
            .text(differences)
            .tables(["summary.csv"]),
        Section::new("Figures of the paper", "drawn with our numbers").figures(&["figure_"]),
        Section::new("Along the paths", "each point, each source of error")
            .explorers(explorers.iter().map(|view| view.title.clone())),
    ];
    Description {
        setting: setting(study),
        sections,
        explorers,
        tables,
        ..Description::new("validation", described(&study.machine))
    }
}

/// Returns the facts about the study that the page lists.
fn setting(study: &ValidationStudy) -> Vec<Fact> {
    let names: Vec<&str> = study.variants.iter().map(|variant| variant.name.as_str()).collect();
    let mut facts = vec![
        Fact::new("process of the figures", names[0]),
        Fact::new("other processes", names[1..].join(", ")),
        Fact::new("cases", study.cases.join(", ")),
    ];
    facts.extend(study.facts().into_iter().map(|(label, text)| Fact::new(label, text)));
    // There is at least one case.
    let path = &study.variants[0].paths[0];
    facts.extend(path.tasks.first().map(|task| Fact::new("compensation holds", task.target.text())));
    facts_of(&study.machine, &path.errors, facts)
}

/// Returns the interactive view of displacements along the circle of a case.
fn case_view(study: &ValidationStudy, case: &str) -> Explorer {
    let mut displacement = DISPLACEMENT;
    displacement.label = "displacement |Δt|".into();
    let (title, table) = (format!("Along the circle: {case}"), format!("{}.csv", points_table_name(case)));
    points_view(&study.machine, title, table, vec![displacement])
}
