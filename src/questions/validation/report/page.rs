//! What the page of a validation study shows.

use crate::{
    files::file_stem,
    page::{Description, Explorer, Fact, MachineDescription, Section, TableNote, error_facts},
    questions::{
        path::report::{DISPLACEMENT, points_view},
        validation::ValidationResults,
    },
};

/// Sections, setting, views and tables; first screen, figures and question are added by the run.
pub fn page(results: &ValidationResults, differences: &str) -> Description {
    let study = &results.study;
    let mut tables = vec![
        TableNote::new("summary.csv", "Numbers quoted and ours, and why they differ."),
        TableNote::new("variants.csv", "The same numbers under each process."),
    ];
    for case in &study.cases {
        let caption = format!("{case}: one row per point and source of error.");
        tables.push(TableNote::ranked(&points_file(case), &caption, &DISPLACEMENT.name));
    }
    Description {
        setting: setting(results),
        sections: sections(results, differences),
        explorers: study.cases.iter().map(|case| curves(results, case)).collect(),
        tables,
        ..Description::new("validation", MachineDescription::new(&study.machine))
    }
}

fn sections(results: &ValidationResults, differences: &str) -> Vec<Section> {
    let study = &results.study;
    let title = |case: &String| along(case);
    vec![
        Section::new("Which numbers agree?", "each number quoted, ours, and why they differ")
            .text(differences)
            .tables(["summary.csv"]),
        Section::new("Figures of the paper", "drawn with our numbers").figures(&["figure_"]),
        Section::new("Along the paths", "each point, each source of error").explorers(study.cases.iter().map(title)),
    ]
}

fn along(case: &str) -> String {
    format!("Along the circle: {case}")
}

fn points_file(case: &str) -> String {
    format!("points_{}.csv", file_stem(case))
}

fn setting(results: &ValidationResults) -> Vec<Fact> {
    let study = &results.study;
    let names: Vec<&str> = study.variants.iter().map(|variant| variant.name.as_str()).collect();
    let mut facts = vec![
        Fact::new("machine", study.machine.title.clone()),
        Fact::new("process of the figures", names[0]),
        Fact::new("other processes", names[1..].join(", ")),
        Fact::new("cases", study.cases.join(", ")),
    ];
    facts.extend(study.facts().into_iter().map(|(label, words)| Fact::new(label, words)));
    if let Some(path) = study.variants[0].paths.first() {
        if let Some(demand) = path.demands.first() {
            facts.push(Fact::new("compensation holds", demand.target.words()));
        }
        facts.extend(error_facts(&study.machine, &path.errors));
    }
    facts
}

fn curves(results: &ValidationResults, case: &str) -> Explorer {
    let mut displacement = DISPLACEMENT;
    displacement.label = "displacement |Δt|".into();
    points_view(&results.study.machine, along(case), points_file(case), vec![displacement])
}
