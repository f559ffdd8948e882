//! Description of a result folder, `report.json`: from it, and the tables and figures beside it, the page is made.

use serde::{Deserialize, Serialize};

use super::{explore::Interactive, machine::MachineDescription};
use crate::{
    figures::{Colours, Figure},
    page::headline::Headline,
};

/// Version of `report.json`.
pub(crate) const SCHEMA: u32 = 3;

/// Contents of `report.json`: the results of a run in words, and the meaning of its files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// Version of this description.
    pub schema: u32,
    /// What was computed: `workspace_map`, `path`, `placement`, …
    pub kind: String,
    /// Name of the study.
    pub name: String,
    /// The question that the study answers.
    pub question: String,
    /// Machine, process, errors and limits, one line each.
    pub setting: Vec<Fact>,
    /// Answer, key numbers and cautions, for the first screen.
    pub headline: Headline,
    /// Meanings of words on the first screen that are special to this question.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<Fact>,
    /// Folded parts of the page after the first screen, in the order in which a reader asks.
    pub sections: Vec<Section>,
    /// The machine.
    pub machine: MachineDescription,
    /// Interactive views of tables, in which a reader picks quantity, source and slice.
    pub explorers: Vec<Explorer>,
    /// Figures, in the order shown.
    pub figures: Vec<FigureNote>,
    /// Tables, in the order shown.
    pub tables: Vec<TableNote>,
    /// Colours of maps: `viridis`, `cividis` or `grey`; viridis if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colours: Option<String>,
    /// What a reader can try with the engine in the page.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interactive: Option<Interactive>,
    /// The machined part, an interactive view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<PartView>,
}

/// The surface of a machined part: faces with what made them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartView {
    /// Its heading.
    pub title: String,
    /// Coordinates of the corners of its faces, four of each in turn, mm.
    pub corners_mm: [Vec<f64>; 3],
    /// Which of `places` made a face; `None` on the skin of the stock.
    pub made: Vec<Option<usize>>,
    /// Names of the courses of the tool, each with how far its surface is from the programmed one at each face, mm.
    pub courses: Vec<(String, Vec<Option<f64>>)>,
    /// Ends of the colour scale, mm.
    pub end_mm: f64,
    /// Places of the program, in words.
    pub places: Vec<String>,
    /// Label, unit and values at each place.
    pub columns: Vec<(String, String, Vec<Option<f64>>)>,
}

/// A label with its value, such as one line of the setting.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fact {
    /// What the value is.
    pub label: String,
    /// The value in words, with its unit.
    pub value: String,
}

/// A figure of the folder: `FILE.svg` and `FILE.png`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureNote {
    /// File name without extension.
    pub file: String,
    /// Title and conditions.
    pub caption: String,
    /// Description for readers who do not see the figure.
    pub alternative: String,
}

/// A table of the folder, and how a page shows it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableNote {
    /// Name of the CSV file.
    pub file: String,
    /// What its rows are.
    pub caption: String,
    /// Column whose largest values a page shows first; `None` shows the first rows.
    pub largest_first: Option<String>,
    /// Which rows it has, if not all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kept: Option<String>,
}

/// A folded part of the page under a heading.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Section {
    /// Its heading: a reader's question.
    pub heading: String,
    /// What is found there, in a few words.
    pub hint: String,
    /// Paragraphs of text.
    pub text: Vec<String>,
    /// Tables that are in no file.
    pub small_tables: Vec<SmallTable>,
    /// Something to copy, such as a command or a table of a file.
    pub to_copy: Option<String>,
    /// Titles of the views shown here.
    pub explorers: Vec<String>,
    /// Beginnings of the file names of the figures shown here.
    pub figures: Vec<String>,
    /// File names of the tables shown here.
    pub tables: Vec<String>,
}

/// A table of a few rows that is in no file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SmallTable {
    /// What its rows are.
    pub caption: String,
    /// Headings of its columns.
    pub header: Vec<String>,
    /// Its rows, a text for each column.
    pub rows: Vec<Vec<String>>,
}

/// An interactive view of a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Explorer {
    /// Its heading.
    pub title: String,
    /// Name of the CSV file.
    pub table: String,
    /// How the rows are arranged.
    pub shape: Shape,
    /// Columns that identify a node: of a grid three or four (x fastest), else one. A curve may have a second one to be drawn over.
    pub coordinates: Vec<Column>,
    /// Columns that distinguish curves or layers over the same coordinates, such as the source of error.
    pub group: Option<Group>,
    /// Quantities to choose from, the first one shown first.
    pub quantities: Vec<Quantity>,
    /// Named points.
    pub marks: Vec<Mark>,
}

/// How the rows of a table are arranged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// On a regular grid.
    Grid,
    /// Along a curve.
    Curve,
    /// One row for each name.
    Names,
}

/// A column of a table, with label and unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Its header in the file.
    pub column: String,
    /// Its name in words.
    pub label: String,
    /// Unit, empty if it has none.
    pub unit: String,
}

/// Columns whose values divide the rows into groups, such as the source of error.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// Headers of these columns.
    pub columns: Vec<String>,
    /// Name of the grouping in words.
    pub label: String,
    /// The groups, the first one shown first; rows of no group are left out.
    pub values: Vec<GroupValue>,
}

/// One group.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupValue {
    /// Cells that its rows have in the columns of the group.
    pub cells: Vec<String>,
    /// Name of the group in words.
    pub label: String,
}

/// A quantity that a reader can choose in a view.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// Headers of its columns; of several, the largest absolute value in a row counts.
    pub columns: Vec<String>,
    /// Its name in words.
    pub label: String,
    /// Unit, empty if it has none.
    pub unit: String,
    /// Which of two values is the better one.
    pub better: Better,
}

/// Which of two values of a quantity is better.
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

impl Better {
    /// Returns by what a value is multiplied so that the smaller product is better; values of which neither is better count as costs.
    pub(super) fn sign(self) -> f64 {
        if self == Self::Larger { -1.0 } else { 1.0 }
    }
}

/// A named point of a view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mark {
    /// Its name.
    pub label: String,
    /// Its position: a number for each coordinate of the view.
    pub position: Vec<f64>,
}

impl Description {
    /// Returns the description of a result of `kind` for `machine`, without texts, views and files.
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
            interactive: None,
            part: None,
        }
    }

    /// Returns the name of the colour map of the study, or of the default one.
    pub(crate) fn colours(&self) -> &'static str {
        let named = |colours: &&Colours| Some(colours.label()) == self.colours.as_deref();
        Colours::ALL.iter().find(named).copied().unwrap_or_default().label()
    }

    /// Replaces the figures by these, given with their file stems.
    #[must_use]
    pub(crate) fn with_figures(mut self, figures: &[(String, Figure)]) -> Self {
        let note = |(file, figure): &(String, Figure)| FigureNote {
            file: file.clone(),
            caption: figure.caption(),
            alternative: figure.alternative_text(),
        };
        self.figures = figures.iter().map(note).collect();
        self
    }

    /// Returns the contents of `report.json`.
    pub(crate) fn to_json(&self) -> String {
        // A struct of strings and numbers always serialises.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

impl Explorer {
    /// Returns a view of curves over the first of the `coordinates`, without marks.
    pub(crate) fn curve(
        title: impl Into<String>,
        table: impl Into<String>,
        coordinates: Vec<Column>,
        group: Option<Group>,
        quantities: Vec<Quantity>,
    ) -> Self {
        let (title, table) = (title.into(), table.into());
        Self { title, table, shape: Shape::Curve, coordinates, group, quantities, marks: Vec::new() }
    }

    /// Returns the columns that identify a row: of a curve only the first coordinate.
    pub(crate) fn keys(&self) -> &[Column] {
        let count = if self.shape == Shape::Curve { 1 } else { self.coordinates.len() };
        &self.coordinates[..count.min(self.coordinates.len())]
    }
}

impl Section {
    /// Returns a section without contents.
    pub fn new(heading: &str, hint: &str) -> Self {
        Self { heading: heading.into(), hint: hint.into(), ..Self::default() }
    }

    /// Adds a paragraph for each line of `text`.
    #[must_use]
    pub fn text(mut self, text: &str) -> Self {
        self.text.extend(text.lines().map(str::trim).filter(|line| !line.is_empty()).map(String::from));
        self
    }

    /// Adds tables that are in no file.
    #[must_use]
    pub fn small_tables(mut self, tables: impl IntoIterator<Item = SmallTable>) -> Self {
        self.small_tables.extend(tables);
        self
    }

    /// Sets the text to copy.
    #[must_use]
    pub fn to_copy(mut self, text: impl Into<String>) -> Self {
        self.to_copy = Some(text.into());
        self
    }

    /// Adds the views with these titles.
    #[must_use]
    pub fn explorers<S: Into<String>>(mut self, titles: impl IntoIterator<Item = S>) -> Self {
        self.explorers.extend(titles.into_iter().map(Into::into));
        self
    }

    /// Adds the figures whose file names begin with one of `begins`.
    #[must_use]
    pub fn figures(mut self, begins: &[&str]) -> Self {
        self.figures.extend(begins.iter().map(|begin| begin.to_string()));
        self
    }

    /// Adds the tables of these files.
    #[must_use]
    pub fn tables<S: Into<String>>(mut self, files: impl IntoIterator<Item = S>) -> Self {
        self.tables.extend(files.into_iter().map(Into::into));
        self
    }
}

impl Fact {
    /// Returns the value with its label.
    pub fn new(label: impl Into<String>, value: impl Into<String>) -> Self {
        Self { label: label.into(), value: value.into() }
    }
}

impl Column {
    /// Returns the column with this header, label and unit.
    pub fn new(column: impl Into<String>, label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { column: column.into(), label: label.into(), unit: unit.into() }
    }
}

impl Group {
    /// Returns the grouping by one column, called `label`, from the cell and the name of each group.
    pub(crate) fn by_column<C: Into<String>, N: Into<String>>(
        column: &str,
        label: &str,
        groups: impl IntoIterator<Item = (C, N)>,
    ) -> Self {
        let value = |(cell, name): (C, N)| GroupValue { cells: vec![cell.into()], label: name.into() };
        Self { columns: vec![column.into()], label: label.into(), values: groups.into_iter().map(value).collect() }
    }
}

impl Quantity {
    /// Returns a quantity of one or several columns.
    pub fn new<S: Into<String>>(columns: impl IntoIterator<Item = S>, label: &str, unit: &str, better: Better) -> Self {
        Self { columns: columns.into_iter().map(Into::into).collect(), label: label.into(), unit: unit.into(), better }
    }
}

impl TableNote {
    /// Returns a note for a table that is shown from its first row on.
    pub fn new(file: &str, caption: &str) -> Self {
        Self { file: file.into(), caption: caption.into(), largest_first: None, kept: None }
    }

    /// Returns a note for a table whose rows with the largest values of `column` are shown first.
    pub fn ranked(file: &str, caption: &str, column: &str) -> Self {
        Self { largest_first: Some(column.into()), ..Self::new(file, caption) }
    }
}
