//! What the page of a validation study shows.

use crate::{
    report::{
        file_stem,
        page::{
            Better, Column, Description, Explorer, Fact, MachineDescription, Quantity, Shape, TableNote, error_facts,
            target_words,
        },
        table::{correction_columns, force_columns, force_unit, position_unit},
        workspace_map::source_group,
    },
    study::validation::ValidationResults,
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
    if let Some(path) = study.variants[0].paths.first() {
        if let Some(demand) = path.demands.first() {
            facts.push(Fact::new("put right by compensation", target_words(demand.target)));
        }
        facts.extend(error_facts(&study.machine, &path.errors));
    }
    facts
}

fn curves(results: &ValidationResults, case: &str) -> Explorer {
    let machine = &results.study.machine;
    let (position, force) = (position_unit(machine), force_unit(machine));
    let mut quantities = vec![Quantity::new(["displacement_mm"], "displacement |Δt|", "mm", Better::Smaller)];
    for axis in ["x", "y", "z"] {
        let column = format!("displacement_{axis}_mm");
        quantities.push(Quantity::new([column], &format!("displacement along {axis}"), "mm", Better::Neither));
    }
    let labels = machine.drive_labels();
    for (column, label) in correction_columns(machine).zip(&labels) {
        quantities.push(Quantity::new([column], &format!("correction of drive {label}"), position, Better::Neither));
    }
    for (column, label) in force_columns(machine).zip(&labels) {
        quantities.push(Quantity::new([column], &format!("force of drive {label}"), force, Better::Neither));
    }
    Explorer {
        title: format!("Along the circle: {case}"),
        table: points_file(case),
        shape: Shape::Curve,
        coordinates: vec![Column::new("arc_length_mm", "length along the path", "mm")],
        group: Some(source_group()),
        quantities,
        marks: Vec::new(),
    }
}
