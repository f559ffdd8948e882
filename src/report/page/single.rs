//! The report of one result folder.

use std::{
    collections::HashMap,
    path::{Component, Path, PathBuf},
};

use serde::Serialize;
use serde_json::Value;

use super::{
    dataset::{Dataset, MOST_NUMBERS},
    description::{Column, Description, Explorer, Fact, Mark, Quantity, Shape},
    folder::ResultFolder,
    packed::{Packed, Precision, data_address, script_json},
    table::{Table, TableView, number},
    template::render,
};
use crate::{
    error::{Error, Result},
    machine::Polyline,
    report::{
        Manifest,
        figures::{Figure, FigureError},
    },
};

/// Most reasons listed.
const MOST_REASONS: usize = 20;

/// What the template shows.
#[derive(Debug, Serialize)]
struct SinglePage<'a> {
    description: &'a Description,
    machine: FigureView,
    explorers: Vec<ExplorerView>,
    figures: Vec<FigureView>,
    tables: Vec<TableView>,
    statuses: Vec<StatusView>,
    reasons: Vec<ReasonView>,
    more_reasons: usize,
    manifest: Vec<Fact>,
    manifest_href: String,
}

/// An image with its words.
#[derive(Debug, Serialize)]
pub(super) struct FigureView {
    source: String,
    caption: String,
    alternative: String,
    /// Where the figure lies as a file, if it does.
    href: Option<String>,
}

/// An interactive view: its words, and its numbers for the script.
#[derive(Debug, Serialize)]
pub(super) struct ExplorerView {
    pub title: String,
    pub shape: Shape,
    pub note: String,
    pub json: String,
}

#[derive(Debug, Serialize)]
struct StatusView {
    status: String,
    rows: String,
}

#[derive(Debug, Serialize)]
struct ReasonView {
    table: String,
    status: String,
    reason: String,
    rows: usize,
}

/// What the script needs of an explorer.
#[derive(Debug, Serialize)]
struct ExplorerData<'a> {
    shape: Shape,
    title: &'a str,
    coordinates: &'a [Column],
    axes: &'a [Vec<f64>],
    names: &'a [String],
    group_label: &'a str,
    groups: Vec<&'a str>,
    quantities: Vec<QuantityData<'a>>,
    notes: &'a [String],
    flags: &'a [Vec<(usize, usize)>],
    marks: &'a [Mark],
    machine: Vec<&'a Polyline>,
}

#[derive(Debug, Serialize)]
struct QuantityData<'a> {
    label: &'a str,
    unit: &'a str,
    series: Vec<Option<Packed>>,
}

/// The report of `folder` as HTML that lies at `out`.
///
/// # Errors
/// A file of the folder is missing or not of the expected form.
pub fn page(folder: &ResultFolder, out: &Path) -> Result<String> {
    let description = &folder.description;
    let address = |name: &str| href(out, &folder.path.join(name));
    let mut explorers = Vec::new();
    let share = MOST_NUMBERS / description.explorers.len().max(1);
    for explorer in &description.explorers {
        let data = Dataset::read(explorer, &folder.table(&explorer.table)?, share)?;
        explorers.push(explorer_view(explorer, &data, description));
    }
    let mut tables = Vec::new();
    let mut reasons = Vec::new();
    for note in &description.tables {
        let table = folder.table(&note.file)?;
        count_reasons(&note.file, &table, &mut reasons)?;
        tables.push(TableView::new(&table, note, address(&note.file))?);
    }
    let more_reasons = reasons.len().saturating_sub(MOST_REASONS);
    reasons.truncate(MOST_REASONS);
    let context = SinglePage {
        description,
        machine: drawn(&description.machine.figure())?,
        explorers,
        figures: figures(folder, out)?,
        tables,
        statuses: statuses(&folder.manifest),
        reasons,
        more_reasons,
        manifest: facts(&folder.manifest),
        manifest_href: address("manifest.json"),
    };
    render("single.html", &context)
}

/// A figure drawn for the page alone.
pub(super) fn drawn(figure: &Figure) -> Result<FigureView> {
    let fault = |fault: FigureError| Error::Figure { name: "machine".into(), problem: fault.to_string() };
    Ok(FigureView {
        source: data_address("image/svg+xml", figure.svg().map_err(fault)?.as_bytes()),
        caption: figure.caption(),
        alternative: figure.alternative(),
        href: None,
    })
}

/// The figures of the folder, but for the machine at home, which every page has.
fn figures(folder: &ResultFolder, out: &Path) -> Result<Vec<FigureView>> {
    let shown = folder.description.figures.iter().filter(|note| note.file != MACHINE_AT_HOME);
    shown
        .map(|note| {
            let name = format!("{}.svg", note.file);
            Ok(FigureView {
                source: data_address("image/svg+xml", &folder.bytes(&name)?),
                caption: note.caption.clone(),
                alternative: note.alternative.clone(),
                href: Some(href(out, &folder.path.join(&name))),
            })
        })
        .collect()
}

/// File stem of the figure of the machine at home.
pub const MACHINE_AT_HOME: &str = "machine_at_home";

fn explorer_view(explorer: &Explorer, data: &Dataset, description: &Description) -> ExplorerView {
    let precision = Precision::for_numbers(data.number_count());
    let quantity = |(quantity, groups): (&'_ Quantity, &Vec<Vec<f64>>)| QuantitySeries {
        label: quantity.label.clone(),
        unit: quantity.unit.clone(),
        series: groups.iter().map(|values| Packed::new(values, precision)).collect(),
    };
    let quantities: Vec<QuantitySeries> = explorer
        .quantities
        .iter()
        .zip(&data.values)
        .map(quantity)
        .filter(|q| q.series.iter().any(Option::is_some))
        .collect();
    let lines = description.machine.home.chains.iter().flat_map(|chain| &chain.links);
    let json = script_json(&ExplorerData {
        shape: explorer.shape,
        title: &explorer.title,
        coordinates: &explorer.coordinates,
        axes: &data.axes,
        names: &data.names,
        group_label: explorer.group.as_ref().map_or("", |group| &group.label),
        groups: group_labels(explorer),
        quantities: quantities
            .iter()
            .map(|q| QuantityData { label: &q.label, unit: &q.unit, series: q.series.clone() })
            .collect(),
        notes: &data.notes,
        flags: &data.flags,
        marks: &explorer.marks,
        machine: lines.collect(),
    });
    ExplorerView { title: explorer.title.clone(), shape: explorer.shape, note: note(explorer, data, precision), json }
}

struct QuantitySeries {
    label: String,
    unit: String,
    series: Vec<Option<Packed>>,
}

pub(super) fn group_labels(explorer: &Explorer) -> Vec<&str> {
    explorer.group.iter().flat_map(|group| group.values.iter().map(|value| value.label.as_str())).collect()
}

/// What a reader must know of the numbers of a view.
pub(super) fn note(explorer: &Explorer, data: &Dataset, precision: Precision) -> String {
    let times = |axes: Vec<usize>| axes.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
    let counts = |axes: &[Vec<f64>]| times(axes.iter().map(Vec::len).collect());
    let mut note = match &data.thinned_from {
        Some(all) => format!(
            "{} of {} nodes of {}, evenly chosen so that this page stays small. ",
            counts(&data.axes),
            times(all.clone()),
            explorer.table
        ),
        None => String::new(),
    };
    note += &format!("{}; {} has all digits.", precision.words(), explorer.table);
    note
}

fn statuses(manifest: &Value) -> Vec<StatusView> {
    let list = manifest.get("statuses").and_then(Value::as_array);
    let word =
        |value: Option<&Value>| value.map_or_else(String::new, |v| v.as_str().map_or(v.to_string(), String::from));
    list.into_iter()
        .flatten()
        .map(|entry| StatusView { status: word(entry.get("status")).replace('_', " "), rows: word(entry.get("rows")) })
        .collect()
}

/// Statuses with reasons, most frequent first; rows that differ in the numbers of their reason only count as one.
fn count_reasons(file: &str, table: &Table, reasons: &mut Vec<ReasonView>) -> Result<()> {
    let (Ok(status), Ok(reason)) = (table.column("status"), table.column("reason")) else { return Ok(()) };
    let mut known: HashMap<(String, String), usize> = HashMap::new();
    let mut found: Vec<ReasonView> = Vec::new();
    table.each_row(|row| {
        let (Some(status), Some(reason)) = (row.get(status), row.get(reason).filter(|reason| !reason.is_empty()))
        else {
            return;
        };
        let key = (status.to_string(), without_numbers(reason));
        let index = *known.entry(key).or_insert_with(|| {
            found.push(ReasonView {
                table: file.into(),
                status: status.replace('_', " "),
                reason: reason.into(),
                rows: 0,
            });
            found.len() - 1
        });
        found[index].rows += 1;
    })?;
    found.sort_by(|a, b| b.rows.cmp(&a.rows));
    reasons.extend(found);
    Ok(())
}

fn without_numbers(text: &str) -> String {
    text.chars().filter(|c| !c.is_ascii_digit()).collect()
}

/// The manifest as lines, but for what differs between runs of the same study.
pub(super) fn facts(manifest: &Value) -> Vec<Fact> {
    let Some(entries) = manifest.as_object() else { return Vec::new() };
    let mut facts = Vec::new();
    for (key, value) in entries.iter().filter(|(key, _)| !Manifest::DIFFERS_BETWEEN_RUNS.contains(&key.as_str())) {
        match value {
            Value::Object(inner) => {
                let own = inner.iter().filter(|(key, _)| !Manifest::DIFFERS_BETWEEN_RUNS.contains(&key.as_str()));
                facts.extend(own.map(|(name, value)| Fact::new(name.replace('_', " "), words(value))));
            }
            Value::Array(_) => {}
            _ => facts.push(Fact::new(key.replace('_', " "), words(value))),
        }
    }
    facts
}

fn words(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(text) => text.clone(),
        Value::Number(n) => n.as_f64().map_or_else(|| n.to_string(), number),
        Value::Array(items) => items.iter().map(words).collect::<Vec<_>>().join(" × "),
        other => other.to_string(),
    }
}

/// Address of `file` on a page that lies at `page`, both relative to the present folder or absolute.
pub(super) fn href(page: &Path, file: &Path) -> String {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (page, file) = (absolute(page), absolute(file));
    let from: Vec<Component<'_>> = page.parent().map(|p| p.components().collect()).unwrap_or_default();
    let to: Vec<Component<'_>> = file.components().collect();
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n(Component::ParentDir, from.len() - shared);
    let way: PathBuf = up.chain(to[shared..].iter().copied()).collect();
    let parts = way.components().map(|part| encoded(&part.as_os_str().to_string_lossy()));
    parts.collect::<Vec<_>>().join("/")
}

/// A file name in an address.
fn encoded(name: &str) -> String {
    let byte = |b: u8| match b {
        b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => char::from(b).to_string(),
        other => format!("%{other:02X}"),
    };
    name.bytes().map(byte).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_relative_to_the_page() {
        for (page, file, address) in [
            ("results/a/report.html", "results/a/map.csv", "map.csv"),
            ("comparison.html", "results/a b/map.csv", "results/a%20b/map.csv"),
            ("/tmp/x/page.html", "/tmp/y/map.csv", "../y/map.csv"),
        ] {
            assert_eq!(href(Path::new(page), Path::new(file)), address);
        }
    }

    #[test]
    fn reasons_that_differ_in_numbers_are_one() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("t.csv");
        std::fs::write(&file, "status,reason\nsolved,\nlost,gap 1.5 mm\nlost,gap 20 mm\nbent,x\n").unwrap();
        let mut reasons = Vec::new();
        count_reasons("t.csv", &Table::open(&file).unwrap(), &mut reasons).unwrap();
        let found: Vec<_> = reasons.iter().map(|r| (r.reason.as_str(), r.rows)).collect();
        assert_eq!(found, [("gap 1.5 mm", 2), ("x", 1)]);
    }
}
