//! The report of several result folders side by side; the first is what the others are held against.

use std::path::Path;

use serde::Serialize;

use super::{
    address::href,
    compared::{Compared, compared},
    folder::ResultFolder,
    record::facts,
    single::{FigureView, drawn},
    template::render,
};
use crate::input::error::{Error, Result};

/// Most results in one comparison: each needs a colour of its own.
const MOST_RESULTS: usize = 6;

#[derive(Debug, Serialize)]
struct ComparisonPage {
    title: String,
    cases: Vec<Case>,
    machines: Vec<FigureView>,
    setting: Vec<SettingRow>,
    sentences: Vec<String>,
    explorers: Vec<Compared>,
    notes: Vec<String>,
    manifest: Vec<SettingRow>,
}

/// One of the results.
#[derive(Debug, Serialize)]
struct Case {
    letter: char,
    name: String,
    machine: String,
    question: String,
    answer: Vec<String>,
    folder: String,
    report: String,
}

/// A line of the setting with what each result has there.
#[derive(Debug, Serialize)]
struct SettingRow {
    label: String,
    values: Vec<String>,
    differs: bool,
}

/// The comparison of `folders`, at least two, as HTML that lies at `out`.
///
/// # Errors
/// The folders hold results of different kinds or are too many, or a file of theirs cannot be read.
pub fn comparison(folders: &[ResultFolder], out: &Path) -> Result<String> {
    let first = check(folders)?;
    let letters: Vec<char> = ('A'..).take(folders.len()).collect();
    let mut notes = Vec::new();
    let mut explorers = Vec::new();
    let mut sentences = Vec::new();
    for explorer in &first.description.explorers {
        if let Some(compared) = compared(explorer, folders, &letters, &mut notes, &mut sentences)? {
            explorers.push(compared);
        }
    }
    let mut machines: Vec<FigureView> = Vec::new();
    let mut shown = Vec::new();
    for folder in folders {
        let machine = &folder.description.machine;
        if !shown.contains(&machine) {
            shown.push(machine);
            machines.push(drawn(&machine.figure())?);
        }
    }
    let case = |(folder, letter): (&ResultFolder, &char)| Case {
        letter: *letter,
        name: folder.description.name.clone(),
        machine: folder.description.machine.title.clone(),
        question: folder.description.question.clone(),
        answer: vec![folder.description.headline.sentence.clone()],
        folder: folder.path.display().to_string(),
        report: href(out, &folder.path.join("report.html")),
    };
    let names: Vec<&str> = folders.iter().map(|folder| folder.description.name.as_str()).collect();
    let setting = folders.iter().map(|f| f.description.setting.iter().map(|s| (s.label.clone(), s.value.clone())));
    let manifest = folders.iter().map(|f| facts(&f.manifest).into_iter().map(|fact| (fact.label, fact.value)));
    let context = ComparisonPage {
        title: format!("{} compared", names.join(", ")),
        cases: folders.iter().zip(&letters).map(case).collect(),
        machines,
        setting: side_by_side(setting.map(Iterator::collect).collect()),
        sentences,
        explorers,
        notes,
        manifest: side_by_side(manifest.map(Iterator::collect).collect()),
    };
    render("comparison.html", &context)
}

fn check(folders: &[ResultFolder]) -> Result<&ResultFolder> {
    let refused = |argument: String, problem: String| Err(Error::Argument { argument, problem });
    let [first, others @ ..] = folders else {
        return refused("results".into(), "give at least one result folder".into());
    };
    if folders.len() > MOST_RESULTS {
        return refused("results".into(), format!("at most {MOST_RESULTS} can be compared, got {}", folders.len()));
    }
    for other in others {
        let (kind, expected) = (&other.description.kind, &first.description.kind);
        if kind != expected {
            let problem = format!(
                "is a result of kind {kind}, but {} is one of kind {expected}; only results of one kind can be compared",
                first.path.display()
            );
            return refused(other.path.display().to_string(), problem);
        }
    }
    Ok(first)
}

fn side_by_side(all: Vec<Vec<(String, String)>>) -> Vec<SettingRow> {
    let mut labels: Vec<&String> = Vec::new();
    for (label, _) in all.iter().flatten() {
        if !labels.contains(&label) {
            labels.push(label);
        }
    }
    let row = |label: &String| {
        let value = |facts: &Vec<(String, String)>| {
            facts.iter().find(|(own, _)| own == label).map_or_else(|| "–".to_string(), |(_, value)| value.clone())
        };
        let values: Vec<String> = all.iter().map(value).collect();
        SettingRow { label: label.clone(), differs: values.iter().any(|v| *v != values[0]), values }
    };
    labels.into_iter().map(row).collect()
}
