//! The report of one result folder as an HTML page.

use std::{collections::BTreeMap, path::Path};

use serde::Serialize;
use serde_json::json;

use super::{
    dataset::{Dataset, MAX_NUMBERS},
    description::{Better, Column, Description, Explorer, Fact, Mark, PartView, Quantity, Section, Shape},
    explore::{EngineView, Interactive},
    folder::{ResultFolder, href},
    packed::{Packed, Precision, data_url, script_json},
    point_command::{PointCommand, point_commands},
    record::{ReasonView, StatusView, count_reasons, manifest_facts, recorded_keys, status_rows},
    table::TableView,
    template::render,
};
use crate::{
    figures::{Colours, Figure, FigureError},
    files::words::typographic,
    input::error::{Error, Result},
    spatial::{MassMark, Polyline},
};

/// Most reasons listed on a page.
const MAX_REASONS: usize = 20;

/// Content of the template `single.html`.
#[derive(Debug, Serialize)]
struct SinglePage<'a> {
    description: &'a Description,
    /// Figure of the first screen.
    hero: Option<FigureView>,
    /// The interactive view that takes its place on a screen, and the script of one that no other page has.
    pointed: Option<Pointed>,
    pointed_script: &'static str,
    terms: Vec<Fact>,
    sections: Vec<SectionView<'a>>,
    machine: FigureView,
    /// Views, figures and tables that no section contains.
    rest: Contents,
    statuses: Vec<StatusView>,
    reasons: Vec<ReasonView>,
    more_reasons: usize,
    manifest: Vec<Fact>,
    engine: Option<EngineView>,
}

/// A section with the views, figures and tables it contains.
#[derive(Debug, Serialize)]
struct SectionView<'a> {
    section: &'a Section,
    contents: Contents,
}

/// Views, figures and tables of a section.
#[derive(Debug, Default, Serialize)]
struct Contents {
    explorers: Vec<ExplorerView>,
    figures: Vec<FigureView>,
    tables: Vec<TableView>,
}

/// A figure on a page with its texts and addresses.
#[derive(Debug, Serialize)]
pub(super) struct FigureView {
    source: String,
    /// The same for the width of a telephone.
    portrait: Option<String>,
    caption: String,
    alternative: String,
    href: Option<String>,
    png: Option<String>,
    csv: Option<String>,
    /// File name without extension.
    #[serde(skip)]
    stem: String,
}

/// An interactive view: its texts, and its numbers as JSON for the script.
#[derive(Debug, Serialize)]
pub(super) struct ExplorerView {
    pub title: String,
    pub shape: Shape,
    pub note: String,
    pub json: String,
    pub id: String,
}

/// What the reader can point at on the first screen: a quantity of an interactive view.
#[derive(Debug, Serialize)]
struct Pointed {
    /// Index of the view.
    index: usize,
    /// Label of the quantity.
    quantity: String,
    group: usize,
    /// Tolerance of the tool's displacement, mm.
    tolerance_mm: Option<f64>,
}

impl Pointed {
    /// Returns the quantity of the first key number, if the view in place of the first figure shows it, else `None`.
    fn of(ResultFolder { description, kind, .. }: &ResultFolder) -> Option<Self> {
        let found = description.headline.numbers.first()?.found.as_ref()?;
        let shape = kind.pointed?;
        let mut views = description.explorers.iter().enumerate();
        let (index, view) = views.find(|(_, view)| view.table == found.file && view.shape == shape)?;
        let quantity = view.quantities.iter().find(|quantity| quantity.columns == found.columns)?.label.clone();
        let is_of_rows = |cells: &[String]| cells.iter().all(|cell| found.rows.iter().any(|[_, own]| own == cell));
        let group = view.group.as_ref().and_then(|group| group.values.iter().position(|one| is_of_rows(&one.cells)));
        let tolerance_mm = description.interactive.as_ref().and_then(process_tolerance_mm);
        Some(Self { index, quantity, group: group.unwrap_or(0), tolerance_mm })
    }
}

/// Returns the tolerance of the process in a scene, or half of its tolerance zone, mm; `None` without these, or without a scene.
fn process_tolerance_mm(interactive: &Interactive) -> Option<f64> {
    let Interactive::Scene(scene) = interactive else { return None };
    let study: toml::Table = scene.get("study")?.as_str()?.parse().ok()?;
    let process = match study.get("process")? {
        toml::Value::String(file) => scene.get("files")?.get(file)?.as_str()?.parse().ok()?,
        process => process.as_table()?.clone(),
    };
    let number = |key: &str| {
        let tolerance = process.get(key)?;
        tolerance.as_float().or_else(|| tolerance.as_integer().map(|whole| whole as f64))
    };
    number("tolerance_mm").or_else(|| number("tolerance_zone_mm").map(|width| 0.5 * width))
}

/// Script of the plan of a path.
const PLAN: &str = include_str!("assets/plan.js");
/// Columns of the wanted positions on a path.
const WANTED: [&str; 3] = ["wanted_x_mm", "wanted_y_mm", "wanted_z_mm"];

/// Numbers of an interactive view for the page's script.
#[derive(Debug, Serialize)]
struct ExplorerData<'a> {
    shape: Shape,
    title: &'a str,
    colours: &'a str,
    coordinates: &'a [Column],
    axes: &'a [Vec<f64>],
    names: &'a [String],
    group_label: &'a str,
    groups: Vec<&'a str>,
    quantities: Vec<QuantityData>,
    notes: &'a [String],
    flags: &'a [Vec<(usize, usize)>],
    marks: &'a [Mark],
    commands: Vec<Option<PointCommand>>,
    command_note: String,
    /// Source of error by group for which the engine in the page can be asked; none where it cannot.
    sources: Vec<String>,
    phi: Option<usize>,
    /// Wanted positions of a path, and the labels of the displacements along the same axes; empty for others.
    plan: Vec<(Option<Packed>, String)>,
    machine: Vec<&'a Polyline>,
    springs: Vec<&'a Polyline>,
    masses: Vec<&'a MassMark>,
    tool: [[f64; 3]; 2],
}

/// Packed values of one quantity, by group.
#[derive(Debug, Serialize)]
struct QuantityData {
    label: String,
    unit: String,
    series: Vec<Option<Packed>>,
}

/// Returns the report of `folder` as an HTML page that will lie at `out`; `Err` when a file is missing or not of the expected form.
pub fn page(folder: &ResultFolder, out: &Path) -> Result<String> {
    page_with(folder, &[], out)
}

/// Returns the report of `folder` as [`page`] does, with additional figures, which are given with their names; `Err` as there.
pub fn page_with(folder: &ResultFolder, besides: &[(String, Figure)], out: &Path) -> Result<String> {
    let description = &folder.description;
    let address = |name: &str| href(out, &folder.path.join(name));
    let mut explorers = Vec::new();
    let share = MAX_NUMBERS / description.explorers.len().max(1);
    let keys = recorded_keys(folder)?;
    let mut pointed = Pointed::of(folder);
    for explorer in &description.explorers {
        let (index, table) = (explorers.len(), folder.table(&explorer.table)?);
        let mut read = explorer.clone();
        if explorer.shape == Shape::Curve && pointed.as_ref().is_some_and(|pointed| pointed.index == index) {
            match WANTED.iter().all(|column| table.column(column).is_ok()) {
                true => read.quantities.extend(WANTED.map(wanted_quantity)),
                false => pointed = None,
            }
        }
        let mut data = Dataset::read(&read, &table, share)?;
        let wanted = data.values.split_off(explorer.quantities.len());
        explorers.push(explorer_view(explorer, &data, folder, &keys, index, &wanted));
    }
    let index = explorers.len();
    explorers.extend(description.part.as_ref().map(|part| part_view(part, index)));
    let mut tables = Vec::new();
    let mut reasons = Vec::new();
    for note in &description.tables {
        let table = folder.table(&note.file)?;
        count_reasons(&note.file, &table, &mut reasons)?;
        tables.push(TableView::new(&table, note, address(&note.file))?);
    }
    let more_reasons = reasons.len().saturating_sub(MAX_REASONS);
    reasons.truncate(MAX_REASONS);
    let mut figures = folder_figures(folder, out)?;
    for (stem, figure) in besides {
        figures.push(FigureView { stem: stem.clone(), ..draw_figure(stem, figure)? });
    }
    let hero = figures.iter().position(|figure| figure.stem == ANSWER).map(|at| figures.remove(at));
    let mut rest = Contents { explorers, figures, tables };
    let sections = description.sections.iter().map(|section| SectionView { section, contents: rest.take_of(section) });
    let context = SinglePage {
        description,
        pointed_script: if folder.kind.pointed == Some(Shape::Curve) { PLAN } else { "" },
        pointed: pointed.filter(|_| hero.is_some()),
        hero,
        terms: terms(description),
        sections: sections.collect(),
        machine: draw_figure("machine", &description.machine.figure())?,
        rest,
        statuses: status_rows(&folder.manifest),
        reasons,
        more_reasons,
        manifest: manifest_facts(&folder.manifest),
        engine: description
            .interactive
            .as_ref()
            .map(|interactive| EngineView::new(folder.kind.interactive, interactive)),
    };
    render("single.html", &context)
}

impl Contents {
    /// Moves the contents that `section` names out of these, and returns them.
    fn take_of(&mut self, section: &Section) -> Self {
        let is_named = |stem: &str| section.figures.iter().any(|begin| stem.starts_with(begin));
        Self {
            explorers: self.explorers.extract_if(.., |view| section.explorers.contains(&view.title)).collect(),
            figures: self.figures.extract_if(.., |figure| is_named(&figure.stem)).collect(),
            tables: self.tables.extract_if(.., |table| section.tables.contains(&table.file)).collect(),
        }
    }
}

/// File stem of the figure that shows the result.
pub(crate) const ANSWER: &str = "answer";
/// File stem of the same figure for the width of a telephone.
pub(crate) const PORTRAIT: &str = "answer_portrait";

/// Draws a figure into the page, without files beside it; `Err` with its `name` if it cannot be drawn.
pub(super) fn draw_figure(name: &str, figure: &Figure) -> Result<FigureView> {
    let fault = |fault: FigureError| Error::Figure { name: name.into(), problem: fault.to_string() };
    Ok(FigureView {
        source: svg_data_url(&figure.svg(Colours::default()).map_err(fault)?),
        portrait: None,
        caption: figure.caption(),
        alternative: figure.alternative_text(),
        href: None,
        png: None,
        csv: None,
        stem: String::new(),
    })
}

/// Returns an SVG document as a `data:` URL that is dark on dark pages.
fn svg_data_url(svg: &str) -> String {
    data_url("image/svg+xml", Figure::with_dark_theme(svg).as_bytes())
}

/// Returns the figures of the folder, without the machine at home, which every page has.
fn folder_figures(folder: &ResultFolder, out: &Path) -> Result<Vec<FigureView>> {
    let shown = folder.description.figures.iter().filter(|note| note.file != MACHINE_AT_HOME);
    shown
        .map(|note| {
            let name = format!("{}.svg", note.file);
            let beside = |name: String| Some(href(out, &folder.path.join(name)));
            let data = format!("{}_data.csv", note.file);
            let portrait = format!("{PORTRAIT}.svg");
            let has_portrait = note.file == ANSWER && folder.path.join(&portrait).is_file();
            Ok(FigureView {
                source: svg_data_url(&folder.text(&name)?),
                portrait: has_portrait.then(|| folder.text(&portrait)).transpose()?.as_deref().map(svg_data_url),
                caption: note.caption.clone(),
                alternative: note.alternative.clone(),
                png: beside(format!("{}.png", note.file)),
                csv: if folder.path.join(&data).is_file() { beside(data) } else { None },
                href: beside(name),
                stem: note.file.clone(),
            })
        })
        .collect()
}

/// File stem of the figure of the machine at home.
pub(crate) const MACHINE_AT_HOME: &str = "machine_at_home";

/// Returns a wanted coordinate as a quantity, to be read from its `column`.
fn wanted_quantity(column: &str) -> Quantity {
    Quantity { columns: vec![column.into()], label: column.into(), unit: "mm".into(), better: Better::Neither }
}

/// Returns an interactive view with its numbers, and with the `wanted` positions of a path by axis and group; `index` makes its id unique.
fn explorer_view(
    explorer: &Explorer,
    data: &Dataset,
    ResultFolder { description, kind, .. }: &ResultFolder,
    keys: &BTreeMap<(String, String), String>,
    index: usize,
    wanted: &[Vec<Vec<f64>>],
) -> ExplorerView {
    let precision = Precision::for_numbers(data.number_count());
    let quantity = |(quantity, groups): (&'_ Quantity, &Vec<Vec<f64>>)| QuantityData {
        label: quantity.label.clone(),
        unit: quantity.unit.clone(),
        series: groups.iter().map(|values| Packed::new(values, precision)).collect(),
    };
    let quantities: Vec<QuantityData> = explorer
        .quantities
        .iter()
        .zip(&data.values)
        .map(quantity)
        .filter(|q| q.series.iter().any(Option::is_some))
        .collect();
    let labels: Vec<&str> = quantities.iter().map(|q| q.label.as_str()).collect();
    let phi = labels.iter().position(|label| *label == WORST_ANGLE);
    let (commands, command_note) = match kind.has_point_command {
        true => point_commands(explorer, phi, keys),
        false => Default::default(),
    };
    let home = &description.machine.home;
    let lines = home.chains.iter().flat_map(|chain| &chain.links);
    let json = script_json(&ExplorerData {
        shape: explorer.shape,
        title: &explorer.title,
        colours: description.colours(),
        coordinates: &explorer.coordinates,
        axes: &data.axes,
        names: &data.names,
        group_label: explorer.group.as_ref().map_or("", |group| &group.label),
        groups: group_labels(explorer),
        quantities,
        notes: &data.notes,
        flags: &data.flags,
        marks: &explorer.marks,
        commands,
        command_note,
        sources: if kind.has_sources { group_sources(explorer) } else { Vec::new() },
        phi,
        plan: wanted.iter().zip(WANTED).map(|(of, column)| plan_axis(explorer, of, column)).collect(),
        machine: lines.collect(),
        springs: home.springs().collect(),
        masses: home.masses().collect(),
        tool: [home.platform_mm, home.tool_tip_mm],
    });
    ExplorerView {
        title: explorer.title.clone(),
        shape: explorer.shape,
        note: precision_note(explorer, data, precision),
        json,
        id: format!("data-{index}"),
    }
}

/// Returns the wanted coordinates along an axis, and the label of the displacement along it.
fn plan_axis(explorer: &Explorer, wanted: &[Vec<f64>], column: &str) -> (Option<Packed>, String) {
    let along = column.replace("wanted", "displacement");
    let moved = explorer.quantities.iter().find(|quantity| quantity.columns == [along.as_str()]);
    let places = wanted.first().and_then(|values| Packed::new(values, Precision::Single));
    (places, moved.map(|quantity| quantity.label.clone()).unwrap_or_default())
}

/// Returns the interactive view of a part; `index` makes its id unique.
fn part_view(part: &PartView, index: usize) -> ExplorerView {
    let note = Precision::Steps.text();
    let packed = |values: &[f64]| Packed::new(values, Precision::Steps);
    let known = |values: &[Option<f64>]| values.iter().map(|own| own.unwrap_or(f64::NAN)).collect::<Vec<_>>();
    let made: Vec<f64> = part.made.iter().map(|own| own.map_or(f64::NAN, |own| own as f64)).collect();
    let columns = part.columns.iter().map(|(label, unit, values)| {
        json!({ "label": label, "unit": unit, "values": Packed::new(&known(values), Precision::Single) })
    });
    let json = json!({
        "shape": "part",
        "title": part.title,
        "note": note,
        "cases": [],
        "units": [],
        "end": part.end_mm,
        "corners": part.corners_mm.each_ref().map(|values| packed(values)),
        "made": Packed::new(&made, Precision::Single),
        "courses": part.courses.iter().map(|own| own.0.as_str()).collect::<Vec<_>>(),
        "deviations": part.courses.iter().map(|own| packed(&known(&own.1))).collect::<Vec<_>>(),
        "places": part.places,
        "columns": columns.collect::<Vec<_>>(),
    });
    ExplorerView {
        title: part.title.clone(),
        shape: Shape::Names,
        note: format!("{note}."),
        json: script_json(&json),
        id: format!("data-{index}"),
    }
}

/// Label of the quantity that is the tool angle.
pub(crate) const WORST_ANGLE: &str = "tool angle of the worst deflection";

/// Returns the source of error of each group.
pub(super) fn group_sources(explorer: &Explorer) -> Vec<String> {
    explorer.group.iter().flat_map(|group| &group.values).map(|value| value.cells.join(" ")).collect()
}

/// Returns the labels of the groups.
pub(super) fn group_labels(explorer: &Explorer) -> Vec<&str> {
    explorer.group.iter().flat_map(|group| group.values.iter().map(|value| value.label.as_str())).collect()
}

/// Returns a note on how the numbers of a view are thinned and rounded.
pub(super) fn precision_note(explorer: &Explorer, data: &Dataset, precision: Precision) -> String {
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
    note += &format!("{}; {} has all digits.", precision.text(), explorer.table);
    note
}

/// Terms explained on a page: title, the words to look for in a text, and meaning.
const TERMS: [(&str, &str, &str); 3] = [
    (
        "Chain errors",
        "chain error",
        "how the machine as built differs from its file: legs turned and displaced, drives zeroed elsewhere",
    ),
    (
        "Tool angle φ",
        "tool angle",
        "immersion direction: that of the radial cutting force about the tool, from the x axis; the angle follows the direction of feed",
    ),
    ("Superposition error", "superposition error", "displacements by single sources added, less that by all at once"),
];

/// Returns the terms that the first screen of `description` uses, with their meanings.
fn terms(description: &Description) -> Vec<Fact> {
    let headline = &description.headline;
    let numbers = headline.numbers.iter().flat_map(|number| [&number.what, &number.against]);
    let texts = [&description.question, &headline.sentence, &headline.basis].into_iter();
    let text: Vec<&str> = texts.chain(numbers).chain(&headline.cautions).map(String::as_str).collect();
    let text = text.join(" ");
    let lower_case = text.to_lowercase();
    let used = TERMS.iter().filter(|(_, begin, _)| lower_case.contains(begin));
    let mut terms: Vec<Fact> =
        used.map(|(term, _, meaning)| Fact { label: (*term).into(), value: (*meaning).into() }).collect();
    terms.extend(description.terms.iter().cloned());
    let machine = &description.machine;
    if text.contains("workspace box") {
        let [low, high] = machine.workspace_mm;
        let ranges: Vec<String> =
            (0..3).map(|axis| format!("{} {} to {}", ["x", "y", "z"][axis], low[axis], high[axis])).collect();
        let value = format!("where the machine's file has P work: {} mm", typographic(&ranges.join(", ")));
        terms.push(Fact { label: "Workspace box".into(), value });
    }
    let words: Vec<&str> = text.split(|letter: char| !(letter.is_alphanumeric() || letter == '_')).collect();
    for point in machine.points.iter().filter(|point| words.contains(&point.label.as_str())) {
        let place: Vec<String> = point.position.iter().map(f64::to_string).collect();
        let value = format!("a point of the machine's file, at {} mm", typographic(&format!("({})", place.join(", "))));
        terms.push(Fact { label: point.label.clone(), value });
    }
    terms
}
