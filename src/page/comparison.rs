//! The report that compares several result folders side by side, all with the first.

use std::path::Path;

use serde::Serialize;

use super::{
    aligned::Aligned,
    compared::{Compared, compare_view},
    description::Shape,
    drawn::{before_nominal, compare_draws},
    folder::{ResultFolder, href, relative_display},
    headline::{Headline, State, Verdict},
    of_parts::hold_to_causes,
    picture::{Picture, winner_picture},
    record::{Changes, input_changes, manifest_facts, tolerance_mm},
    single::{FigureView, draw_figure},
    template::render,
    verdict::{FirstScreen, VerdictWriter},
    winners::Floors,
};
use crate::{
    files::words::cannot_be_run,
    input::error::{Error, Result},
};

/// Most results in one comparison: each needs a colour of its own.
const MAX_RESULTS: usize = 6;

/// Content of the template `comparison.html`.
#[derive(Debug, Serialize)]
struct ComparisonPage {
    title: String,
    kind: String,
    question: String,
    cases: Vec<Case>,
    /// What the first screen says; `None` where no number can be held against another.
    headline: Option<Headline>,
    checks: String,
    picture: Option<Picture>,
    changes: Changes,
    machines: Vec<FigureView>,
    setting: Vec<SettingRow>,
    explorers: Vec<Compared>,
    notes: Vec<String>,
    rules: Vec<String>,
    manifest: Vec<SettingRow>,
}

/// One of the compared results.
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

/// One row of the settings: a label and its value in each result.
#[derive(Debug, Serialize)]
struct SettingRow {
    label: String,
    values: Vec<String>,
    differs: bool,
}

/// Results held against each other.
#[derive(Debug)]
pub struct Comparison {
    /// The HTML page.
    pub page: String,
    /// What its first screen says; `None` where no number can be held against another.
    pub headline: Option<Headline>,
}

/// Returns the comparison of `folders`, whose page will lie at `out`. `tolerance` is the difference in mm from which one
/// matters; by default that of the first study that has one. `Err` for no or too many folders, different kinds, or unreadable files.
pub fn comparison(folders: &[ResultFolder], out: &Path, tolerance: Option<f64>) -> Result<Comparison> {
    let first = check_comparable(folders)?;
    let letters: Vec<char> = ('A'..).take(folders.len()).collect();
    let mut notes = Vec::new();
    let mut views = Vec::new();
    for explorer in &first.description.explorers {
        views.extend(Aligned::read(explorer, folders, &letters, &mut notes)?);
    }
    let floors = Floors::of(&mut views);
    let is_given = tolerance.is_some();
    let tolerance = match tolerance {
        Some(custom) => Some((custom, "--tolerance".to_string())),
        None => study_tolerance(folders, &letters)?,
    };
    let addresses: Vec<String> = folders.iter().map(|folder| href(out, &folder.path)).collect();
    let names = short_names(folders);
    let writer = |aligned| VerdictWriter {
        aligned,
        names: &names,
        tolerance_mm: tolerance.as_ref().map(|(mm, _)| *mm),
        folders: &addresses,
    };
    let best_places = views.iter().find_map(|aligned| writer(aligned).best_places(is_given));
    let main_view = views.iter().find(|aligned| writer(aligned).main_quantity().is_some());
    let is_of_places = best_places.is_some();
    let nominal = best_places.or_else(|| writer(main_view?).first_screen());
    let screen = first_screen(folders, &names, nominal, &mut notes)?;
    let (headline, checks) = screen.map(|own| (own.headline, own.checks)).unzip();
    let by_place = views.iter().filter(|aligned| aligned.shared.shape != Shape::Names).find_map(|aligned| {
        let quantity = writer(aligned).main_quantity()?;
        let winners = aligned.winners(quantity)?;
        winner_picture(aligned, quantity, &winners)
            .filter(|_| winners.compared_count() > 0 || aligned.shared.shape == Shape::Curve)
    });
    let picture = by_place.or_else(|| {
        let named = views.iter().filter(|aligned| aligned.shared.shape == Shape::Names);
        named.filter(|_| is_of_places).find_map(|aligned| writer(aligned).best_place_picture())
    });
    let case = |(folder, letter): (&ResultFolder, &char)| Case {
        letter: *letter,
        name: folder.description.name.clone(),
        machine: folder.description.machine.title.clone(),
        question: folder.description.question.clone(),
        answer: vec![folder.description.headline.sentence.clone()],
        folder: relative_display(out, &folder.path),
        report: href(out, &folder.path.join("report.html")),
    };
    let all_names: Vec<&str> = folders.iter().map(|folder| folder.description.name.as_str()).collect();
    let setting = folders.iter().map(|f| f.description.setting.iter().map(|s| (s.label.clone(), s.value.clone())));
    let manifest = folders.iter().map(|f| manifest_facts(&f.manifest).into_iter().map(|fact| (fact.label, fact.value)));
    let context = ComparisonPage {
        title: format!("{} compared", all_names.join(", ")),
        kind: kind_line(&first.description.kind, main_view.filter(|_| !is_of_places)),
        question: shared_question(folders),
        cases: folders.iter().zip(&letters).map(case).collect(),
        checks: checks.map(|checks| super::packed::script_json(&checks)).unwrap_or_default(),
        headline: headline.clone(),
        picture,
        changes: input_changes(folders, &letters)?,
        machines: machine_figures(folders)?,
        setting: setting_rows(setting.map(Iterator::collect).collect()),
        explorers: views.iter().map(|aligned| compare_view(aligned, folders, first.description.colours())).collect(),
        notes,
        rules: rule_sentences(&floors, tolerance.as_ref()),
        manifest: setting_rows(manifest.map(Iterator::collect).collect()),
    };
    Ok(Comparison { page: render("comparison.html", &context)?, headline })
}

/// Returns the first screen from that of `nominal` numbers: draws come before these, what a verdict rests on limits it, and paths that cannot be run come
/// before all. Words on draws that no screen has are added to `notes`.
fn first_screen(
    folders: &[ResultFolder],
    names: &[String],
    mut nominal: Option<FirstScreen>,
    notes: &mut Vec<String>,
) -> Result<Option<FirstScreen>> {
    let letters: Vec<char> = ('A'..).take(folders.len()).collect();
    let cannot_run = cannot_run(folders, &letters)?;
    let folder_name =
        |folder: &ResultFolder| folder.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let called = if names.is_empty() { folders.iter().map(folder_name).collect() } else { names.to_vec() };
    let mut screen = match compare_draws(folders, &called)? {
        Some(Ok(drawn)) => Some(before_nominal(drawn, nominal)),
        Some(Err(text)) => {
            match &mut nominal {
                Some(own) => own.headline.cautions.insert(0, text),
                None => notes.push(text),
            }
            nominal
        }
        None => nominal,
    };
    if let Some(own) = &mut screen {
        hold_to_causes(&mut own.headline, folders, &letters)?;
    }
    if let (Some(own), [first, others @ ..]) = (&mut screen, cannot_run.as_slice()) {
        let better = std::mem::replace(&mut own.headline.sentence, first.clone());
        own.headline.cautions.splice(0..0, others.iter().cloned().chain([better]));
        own.headline.verdict = Some(Verdict::new(State::Bad, "One of the paths cannot be run as placed"));
        own.headline.next =
            Some("move that part into the workspace box of its machine, and compute its path again.".into());
    }
    Ok(screen)
}

/// Returns a sentence for each result along a path of which positions are outside the workspace box: what is better of what cannot be run is no answer.
fn cannot_run(folders: &[ResultFolder], letters: &[char]) -> Result<Vec<String>> {
    let mut sentences = Vec::new();
    for (folder, letter) in folders.iter().zip(letters) {
        let summary = folder.summary()?;
        if let Some(outside) = summary["points_outside_workspace"].as_u64().filter(|outside| *outside > 0) {
            let points = summary["points"].as_u64().unwrap_or_default();
            let sentence = cannot_be_run(&letter.to_string(), outside, points, &folder.description.machine.name);
            sentences.push(sentence.trim_end().to_string());
        }
    }
    Ok(sentences)
}

/// Returns the question that all studies ask, or a general one if they differ.
fn shared_question(folders: &[ResultFolder]) -> String {
    let question_of = |folder: &ResultFolder| folder.description.question.clone();
    let first = folders.first().map(question_of).unwrap_or_default();
    if folders.iter().all(|folder| question_of(folder) == first) {
        first
    } else {
        "Which result is better, where, by how much, and does the difference matter?".into()
    }
}

/// Returns the line that says which kind of results is compared, and over which nodes.
fn kind_line(kind: &str, main_view: Option<&Aligned>) -> String {
    let over = main_view.map_or_else(String::new, |aligned| {
        let group = Some(aligned.group_name(0)).filter(|group| !group.is_empty());
        let group = group.map_or_else(String::new, |group| format!(" · {group}"));
        format!(" · computed {}{group}", aligned.extremes_basis().1)
    });
    format!("Comparison · {}{over}", kind.replace('_', " "))
}

/// Returns sentences on what counts as rounding, and on the tolerance that decides whether a difference matters.
fn rule_sentences(floors: &Floors, tolerance: Option<&(f64, String)>) -> Vec<String> {
    let matters = match tolerance {
        Some((mm, source)) => format!("A difference matters if it is larger than {mm} mm ({source})."),
        None => "No tolerance is given: with --tolerance MM this page says whether a difference matters.".into(),
    };
    vec![floors.rule_sentence(), matters]
}

/// Returns the tolerance in mm of the first study that has one, with a description of its source.
fn study_tolerance(folders: &[ResultFolder], letters: &[char]) -> Result<Option<(f64, String)>> {
    for (folder, letter) in folders.iter().zip(letters) {
        if let Some(tolerance) = tolerance_mm(folder)? {
            return Ok(Some((tolerance, format!("tolerance_mm of the study of {letter}"))));
        }
    }
    Ok(None)
}

/// Returns names by which sentences distinguish results: those of machines, else of studies; none if all are equal.
fn short_names(folders: &[ResultFolder]) -> Vec<String> {
    let machines: Vec<&str> = folders.iter().map(|f| f.description.machine.name.as_str()).collect();
    let studies: Vec<&str> = folders.iter().map(|f| f.description.name.as_str()).collect();
    let are_different = |names: &[&str]| names.iter().enumerate().all(|(i, name)| !names[..i].contains(name));
    let chosen = [machines, studies].into_iter().find(|names| are_different(names));
    chosen.map_or_else(Vec::new, |names| names.into_iter().map(String::from).collect())
}

/// Returns a figure of each different machine.
fn machine_figures(folders: &[ResultFolder]) -> Result<Vec<FigureView>> {
    let mut shown = Vec::new();
    for folder in folders {
        let machine = &folder.description.machine;
        if !shown.contains(&machine) {
            shown.push(machine);
        }
    }
    shown.into_iter().map(|machine| draw_figure("machine", &machine.figure())).collect()
}

/// Returns the first folder; `Err` if there is none, there are too many, or their kinds differ.
fn check_comparable(folders: &[ResultFolder]) -> Result<&ResultFolder> {
    let refuse = |argument: String, problem: String| Err(Error::Argument { argument, problem });
    let [first, others @ ..] = folders else {
        return refuse("results".into(), "give at least one result folder".into());
    };
    if folders.len() > MAX_RESULTS {
        return refuse("results".into(), format!("at most {MAX_RESULTS} can be compared, got {}", folders.len()));
    }
    for other in others {
        let (kind, expected) = (&other.description.kind, &first.description.kind);
        if kind != expected {
            let problem = format!(
                "is a result of kind {kind}, but {} is one of kind {expected}; only results of one kind can be compared: \
                 give two of kind {kind} or two of kind {expected}",
                first.path.display()
            );
            return refuse(other.path.display().to_string(), problem);
        }
    }
    Ok(first)
}

/// Returns a row for each label in any of `all` results (label and value of each fact), with its value in every result.
fn setting_rows(all: Vec<Vec<(String, String)>>) -> Vec<SettingRow> {
    let mut labels: Vec<&String> = Vec::new();
    for (label, _) in all.iter().flatten() {
        if !labels.contains(&label) {
            labels.push(label);
        }
    }
    let row = |label: &String| {
        let value = |facts: &Vec<(String, String)>| {
            facts.iter().find(|(known, _)| known == label).map_or_else(|| "–".to_string(), |(_, value)| value.clone())
        };
        let values: Vec<String> = all.iter().map(value).collect();
        SettingRow { label: label.clone(), differs: values.iter().any(|v| *v != values[0]), values }
    };
    labels.into_iter().map(row).collect()
}
