//! What a run leaves for its page: `report.json`, from which, with the tables and figures beside it, the page is made.

use serde::{Deserialize, Serialize};

use super::{explore::ToTry, machine::MachineDescription};
use crate::{
    figures::{Colours, Figure},
    page::headline::Headline,
};

/// Version of `report.json`.
pub(crate) const SCHEMA: u32 = 3;

/// A result folder in words, and what its files are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// Version of this description; 2.
    pub schema: u32,
    /// What was computed: `workspace_map`, `path`, `placement`, …
    pub kind: String,
    /// Name of the study.
    pub name: String,
    /// The question.
    pub question: String,
    /// Machine, process, errors and limits, a line each.
    pub setting: Vec<Fact>,
    /// The first screen.
    pub headline: Headline,
    /// Words of the first screen that mean something of their own in this question.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<Fact>,
    /// What follows it, folded, in the order in which a reader asks.
    pub sections: Vec<Section>,
    /// The machine.
    pub machine: MachineDescription,
    /// Views of tables in which a reader picks quantity, source and slice.
    pub explorers: Vec<Explorer>,
    /// Figures, in the order to be shown.
    pub figures: Vec<FigureNote>,
    /// Tables, in the order to be shown.
    pub tables: Vec<TableNote>,
    /// Colours of maps: `viridis`, `cividis` or `grey`; viridis if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colours: Option<String>,
    /// What its reader can try.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_try: Option<ToTry>,
}

/// One line of the setting.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fact {
    /// What.
    pub label: String,
    /// How much, with its unit.
    pub value: String,
}

/// A figure of the folder: `FILE.svg` and `FILE.png`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureNote {
    /// File name without extension.
    pub file: String,
    /// Title and setting.
    pub caption: String,
    /// For readers who do not see it.
    pub alternative: String,
}

/// A table of the folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableNote {
    /// CSV file.
    pub file: String,
    /// What its rows are.
    pub caption: String,
    /// Column whose largest values a page shows first; `None` shows the first rows.
    pub largest_first: Option<String>,
}

/// A part of the page under a heading.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Section {
    /// Its heading: a reader's question.
    pub heading: String,
    /// What is found there, in a few words.
    pub hint: String,
    /// Paragraphs.
    pub text: Vec<String>,
    /// Tables that no file holds.
    pub small_tables: Vec<SmallTable>,
    /// Something to copy, such as a command or a table of a file.
    pub to_copy: Option<String>,
    /// Titles of its views.
    pub explorers: Vec<String>,
    /// Begins of the file names of its figures.
    pub figures: Vec<String>,
    /// Files of its tables.
    pub tables: Vec<String>,
}

/// A few rows.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SmallTable {
    /// What its rows are.
    pub caption: String,
    /// Heads of its columns.
    pub header: Vec<String>,
    /// Its rows, a text for each column.
    pub rows: Vec<Vec<String>>,
}

/// A view of a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Explorer {
    /// Its heading.
    pub title: String,
    /// CSV file.
    pub table: String,
    /// How its rows lie.
    pub shape: Shape,
    /// Columns that say where a row belongs: three or four of a grid (x fastest), one of a curve or of names. A curve may have a second
    /// one that it can be seen over as well: the label of a quantity.
    pub coordinates: Vec<Column>,
    /// What tells curves or layers over the same coordinates apart, such as the source of error.
    pub group: Option<Group>,
    /// What can be picked, the first one shown first.
    pub quantities: Vec<Quantity>,
    /// Named places.
    pub marks: Vec<Mark>,
}

/// How the rows of a table lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// On a regular grid.
    Grid,
    /// Along a line.
    Curve,
    /// One per name.
    Names,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Its header.
    pub column: String,
    /// In words.
    pub label: String,
    /// Unit, empty if it has none.
    pub unit: String,
}

/// Groups of rows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// Column headers.
    pub columns: Vec<String>,
    /// In words.
    pub label: String,
    /// The groups, the first one shown first; rows of no group are left out.
    pub values: Vec<GroupValue>,
}

/// One group.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupValue {
    /// As in the table, one per column.
    pub cells: Vec<String>,
    /// In words.
    pub label: String,
}

/// A quantity that can be picked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// Column headers; of several, the largest size counts.
    pub columns: Vec<String>,
    /// In words.
    pub label: String,
    /// Unit, empty if it has none.
    pub unit: String,
    /// Which of two values is the better one.
    pub better: Better,
}

/// Which of two values is the better one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Better {
    /// The smaller.
    Smaller,
    /// The larger.
    Larger,
    /// Neither.
    Neither,
}

/// A named place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mark {
    /// Its name.
    pub label: String,
    /// Where, one number per coordinate of the view.
    pub position: Vec<f64>,
}

impl Description {
    /// A result of `kind` for `machine`, without words, views and files.
    pub fn new(kind: &str, machine: MachineDescription) -> Self {
        Self {
            schema: SCHEMA,
            kind: kind.into(),
            name: String::new(),
            question: String::new(),
            setting: Vec::new(),
            headline: Headline::default(),
            terms: Vec::new(),
            sections: Vec::new(),
            machine,
            explorers: Vec::new(),
            figures: Vec::new(),
            tables: Vec::new(),
            colours: None,
            to_try: None,
        }
    }

    /// Colours of maps, as a page names them.
    pub(crate) fn colours(&self) -> &'static str {
        let named = |colours: &&Colours| Some(colours.label()) == self.colours.as_deref();
        Colours::ALL.iter().find(named).copied().unwrap_or_default().label()
    }

    /// With the figures of the folder, by file stem.
    #[must_use]
    pub(crate) fn with_figures(mut self, figures: &[(String, Figure)]) -> Self {
        let note = |(file, figure): &(String, Figure)| FigureNote {
            file: file.clone(),
            caption: figure.caption(),
            alternative: figure.alternative(),
        };
        self.figures = figures.iter().map(note).collect();
        self
    }

    /// As a JSON file.
    pub(crate) fn to_json(&self) -> String {
        // A struct of strings and numbers always serialises.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

impl Explorer {
    /// The columns by which a row is found again: of a curve the first.
    pub(crate) fn keys(&self) -> &[Column] {
        let count = if self.shape == Shape::Curve { 1 } else { self.coordinates.len() };
        &self.coordinates[..count.min(self.coordinates.len())]
    }
}

impl Section {
    /// A part without contents.
    pub fn new(heading: &str, hint: &str) -> Self {
        Self { heading: heading.into(), hint: hint.into(), ..Self::default() }
    }

    /// With the paragraphs of `text`, one a line.
    #[must_use]
    pub fn text(mut self, text: &str) -> Self {
        self.text.extend(text.lines().map(str::trim).filter(|line| !line.is_empty()).map(String::from));
        self
    }

    /// With tables that no file holds.
    #[must_use]
    pub fn small_tables(mut self, tables: impl IntoIterator<Item = SmallTable>) -> Self {
        self.small_tables.extend(tables);
        self
    }

    /// With something to copy.
    #[must_use]
    pub fn to_copy(mut self, text: impl Into<String>) -> Self {
        self.to_copy = Some(text.into());
        self
    }

    /// With the views of these titles.
    #[must_use]
    pub fn explorers<S: Into<String>>(mut self, titles: impl IntoIterator<Item = S>) -> Self {
        self.explorers.extend(titles.into_iter().map(Into::into));
        self
    }

    /// With the figures whose file names begin so.
    #[must_use]
    pub fn figures(mut self, begins: &[&str]) -> Self {
        self.figures.extend(begins.iter().map(|begin| begin.to_string()));
        self
    }

    /// With these tables.
    #[must_use]
    pub fn tables<S: Into<String>>(mut self, files: impl IntoIterator<Item = S>) -> Self {
        self.tables.extend(files.into_iter().map(Into::into));
        self
    }
}

impl Fact {
    /// A line of the setting.
    pub fn new(label: impl Into<String>, value: impl Into<String>) -> Self {
        Self { label: label.into(), value: value.into() }
    }
}

impl Column {
    /// A column.
    pub fn new(column: impl Into<String>, label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { column: column.into(), label: label.into(), unit: unit.into() }
    }
}

impl Quantity {
    /// A quantity of one or several columns.
    pub fn new<S: Into<String>>(columns: impl IntoIterator<Item = S>, label: &str, unit: &str, better: Better) -> Self {
        Self { columns: columns.into_iter().map(Into::into).collect(), label: label.into(), unit: unit.into(), better }
    }
}

impl TableNote {
    /// A table shown from its first row on.
    pub fn new(file: &str, caption: &str) -> Self {
        Self { file: file.into(), caption: caption.into(), largest_first: None }
    }

    /// A table of which the rows with the largest values of `column` are shown first.
    pub fn ranked(file: &str, caption: &str, column: &str) -> Self {
        Self { largest_first: Some(column.into()), ..Self::new(file, caption) }
    }
}
