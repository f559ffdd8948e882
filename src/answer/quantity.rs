//! The numbers of a question: each is declared once, with its name, unit, meaning and how it is had of what was found.

use std::{borrow::Cow, sync::Arc};

use crate::simulation::Failure;
use crate::{
    files::exchange::{Cell, Column, Kind},
    page::{
        self, Better,
        headline::{Extreme, InTable},
    },
};

/// What was found, or why there is nothing.
pub type FoundOr<'a, E> = Result<&'a E, &'a Failure>;

/// A number that a question computes of what it finds, an `E`.
pub struct Quantity<E> {
    /// Name of its column, which ends with its unit.
    pub name: Cow<'static, str>,
    /// What it is, as pages and figures call it; empty of what stands in tables alone.
    pub label: Cow<'static, str>,
    /// Which of two values is the better one.
    pub better: Better,
    /// The columns whose largest size it is, if it is no column itself.
    of: Vec<String>,
    get: Get<E>,
}

/// How a number is had of what was found; `None` where it is not.
pub type Getter<E> = dyn Fn(&E) -> Option<f64> + Send + Sync;

/// How it is had.
enum Get<E> {
    Number(fn(&E) -> Option<f64>),
    Part(fn(&E) -> Option<[f64; 3]>, usize),
    Count(fn(&E) -> Option<usize>),
    Cell(Kind, fn(FoundOr<'_, E>) -> Cell),
    Made(Arc<Getter<E>>),
}

impl<E> Clone for Get<E> {
    fn clone(&self) -> Self {
        match self {
            Get::Number(get) => Get::Number(*get),
            Get::Part(get, axis) => Get::Part(*get, *axis),
            Get::Count(get) => Get::Count(*get),
            Get::Cell(kind, get) => Get::Cell(*kind, *get),
            Get::Made(get) => Get::Made(Arc::clone(get)),
        }
    }
}

impl<E> Clone for Quantity<E> {
    fn clone(&self) -> Self {
        let Self { name, label, better, of, get } = self;
        Self { name: name.clone(), label: label.clone(), better: *better, of: of.clone(), get: get.clone() }
    }
}

impl<E: 'static> Quantity<E> {
    /// A number that pages show.
    pub const fn new(name: &'static str, label: &'static str, better: Better, get: fn(&E) -> Option<f64>) -> Self {
        Self::with(name, label, better, Get::Number(get))
    }

    /// A number that stands in tables alone.
    pub const fn in_table(name: &'static str, get: fn(&E) -> Option<f64>) -> Self {
        Self::new(name, "", Better::Neither, get)
    }

    /// A whole number that stands in tables alone.
    pub const fn count(name: &'static str, get: fn(&E) -> Option<usize>) -> Self {
        Self::with(name, "", Better::Neither, Get::Count(get))
    }

    /// A cell of any kind, which there may be as well where nothing was found.
    pub const fn cell(
        name: &'static str,
        label: &'static str,
        better: Better,
        kind: Kind,
        get: fn(FoundOr<'_, E>) -> Cell,
    ) -> Self {
        Self::with(name, label, better, Get::Cell(kind, get))
    }

    /// Words, which there may be as well where nothing was found.
    pub const fn text(name: &'static str, get: fn(FoundOr<'_, E>) -> Cell) -> Self {
        Self::cell(name, "", Better::Neither, Kind::Text, get)
    }

    const fn with(name: &'static str, label: &'static str, better: Better, get: Get<E>) -> Self {
        Self { name: Cow::Borrowed(name), label: Cow::Borrowed(label), better, of: Vec::new(), get }
    }

    /// The components of a vector: columns `WHAT_x_mm` and so on, each the `label` along its axis.
    pub fn vector_mm(what: &str, label: &str, get: fn(&E) -> Option<[f64; 3]>) -> [Self; 3] {
        Self::vector(what, "mm", label, get)
    }

    /// The same of a vector with another unit.
    pub fn vector(what: &str, unit: &str, label: &str, get: fn(&E) -> Option<[f64; 3]>) -> [Self; 3] {
        std::array::from_fn(|axis| {
            let letter = ["x", "y", "z"][axis];
            Self {
                name: format!("{what}_{letter}_{unit}").into(),
                label: format!("{label} along {letter}").into(),
                better: Better::Neither,
                of: Vec::new(),
                get: Get::Part(get, axis),
            }
        })
    }

    /// A number that is had in a way which is known at run time alone.
    pub fn made(
        name: String,
        label: String,
        better: Better,
        get: impl Fn(&E) -> Option<f64> + Send + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), label: label.into(), better, of: Vec::new(), get: Get::Made(Arc::new(get)) }
    }

    /// The largest size of `all`; there is none where one of them is missing.
    pub fn largest_of(name: String, label: String, better: Better, all: Vec<Self>) -> Self {
        let of = all.iter().map(|one| one.name.to_string()).collect();
        let largest =
            move |found: &E| all.iter().try_fold(0.0, |most: f64, one| Some(most.max(one.value(found)?.abs())));
        Self { of, ..Self::made(name, label, better, largest) }
    }

    /// Its value.
    pub fn value(&self, found: &E) -> Option<f64> {
        match &self.get {
            Get::Number(get) => get(found),
            Get::Part(get, axis) => get(found).map(|vector| vector[*axis]),
            Get::Count(get) => get(found).map(|count| count as f64),
            Get::Cell(_, get) => match get(Ok(found)) {
                Cell::Number(number) => Some(number),
                Cell::Count(count) => Some(count as f64),
                Cell::Missing | Cell::Text(_) => None,
            },
            Get::Made(get) => get(found),
        }
    }

    /// Its cell in a table.
    pub fn cell_of(&self, found: FoundOr<'_, E>) -> Cell {
        match &self.get {
            Get::Cell(_, get) => get(found),
            Get::Count(get) => found.ok().and_then(get).into(),
            _ => found.ok().and_then(|found| self.value(found)).into(),
        }
    }

    /// Its column in a table.
    pub fn column(&self) -> Column {
        let kind = match &self.get {
            Get::Cell(kind, _) => *kind,
            Get::Count(_) => Kind::Count,
            _ => Kind::Number,
        };
        Column { name: self.name.to_string(), kind }
    }

    /// Its unit as pages and figures write it, empty if it has none.
    pub fn unit(&self) -> String {
        match self.column().unit() {
            Some("deg") => "°".into(),
            unit => unit.unwrap_or_default().into(),
        }
    }

    /// Its label with its unit, as an axis has it.
    pub fn axis_label(&self) -> String {
        format!("{} [{}]", self.label, self.unit())
    }

    /// As a page shows it.
    pub fn layer(&self) -> page::Quantity {
        page::Quantity {
            columns: self.columns(),
            label: self.label.to_string(),
            unit: self.unit(),
            better: self.better,
        }
    }

    /// The columns that it is, or is the largest of.
    fn columns(&self) -> Vec<String> {
        if self.of.is_empty() { vec![self.name.to_string()] } else { self.of.clone() }
    }

    /// Where an extreme `value` of it stands.
    pub fn found_in(&self, file: &str, rows: &[[&str; 2]], extreme: Extreme, value: f64) -> InTable {
        InTable::new(file, self.columns(), rows, extreme, value)
    }
}

/// Pages show these, one after another.
pub(crate) fn layers<'a, E: 'static>(quantities: impl IntoIterator<Item = &'a Quantity<E>>) -> Vec<page::Quantity> {
    quantities.into_iter().map(Quantity::layer).collect()
}
