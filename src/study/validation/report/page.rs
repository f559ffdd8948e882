//! What the page of a validation study shows.

use crate::{
    report::{
        file_stem,
        page::{Better, Description, Explorer, Fact, MachineDescription, Quantity, TableNote, error_facts},
    },
    study::{path::report::points_view, validation::ValidationResults},
};

/// Setting, views and tables; answer, figures and question are added by the run.
pub fn page(results: &ValidationResults) -> Description {
    let study = &results.study;
    let mut tables = vec![
        TableNote::new("summary.csv", "Numbers quoted and ours, and why they differ."),
        TableNote::new("variants.csv", "The same numbers under each process."),
    ];
    for case in &study.cases {
        let caption = format!("{case}: one row per point and source of error.");
        tables.push(TableNote::ranked(&points_file(case), &caption, "displacement_mm"));
    }
    Description {
        setting: setting(results),
        explorers: study.cases.iter().map(|case| curves(results, case)).collect(),
        tables,
        ..Description::new("validation", MachineDescription::new(&study.machine))
    }
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
            facts.push(Fact::new("put right by compensation", demand.target.words()));
        }
        facts.extend(error_facts(&study.machine, &path.errors));
    }
    facts
}

fn curves(results: &ValidationResults, case: &str) -> Explorer {
    let first = vec![Quantity::new(["displacement_mm"], "displacement |Δt|", "mm", Better::Smaller)];
    points_view(&results.study.machine, format!("Along the circle: {case}"), points_file(case), first)
}
