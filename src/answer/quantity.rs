//! A quantity that a question computes, declared once: name, unit, meaning, and how it is computed from a result.

use std::{borrow::Cow, sync::Arc};

use crate::simulation::Failure;
use crate::{
    files::exchange::{Cell, Column, Kind},
    page::{
        self, Better,
        headline::{Extreme, InTable},
    },
};

/// A result, or why there is none.
pub type FoundOr<'a, E> = Result<&'a E, &'a Failure>;

/// A quantity computed from a result of type `E`, with its column in tables and its label on pages.
pub struct Quantity<E> {
    /// Name of its column, which ends with the unit.
    pub name: Cow<'static, str>,
    /// Label on pages and figures; empty if it is in tables only.
    pub label: Cow<'static, str>,
    /// Which of two values is better.
    pub better: Better,
    /// Columns whose largest size it is, if it is no column itself.
    of: Vec<String>,
    get: Get<E>,
}

/// Computes a number from a result; `None` where there is none.
pub type Getter<E> = dyn Fn(&E) -> Option<f64> + Send + Sync;

/// How a quantity is computed from a result.
enum Get<E> {
    Number(fn(&E) -> Option<f64>),
    Part(fn(&E) -> Option<[f64; 3]>, usize),
    Count(fn(&E) -> Option<usize>),
    Cell(Kind, fn(FoundOr<'_, E>) -> Cell),
    Computed(Arc<Getter<E>>),
}

impl<E> Clone for Get<E> {
    fn clone(&self) -> Self {
        match self {
            Get::Number(get) => Get::Number(*get),
            Get::Part(get, axis) => Get::Part(*get, *axis),
            Get::Count(get) => Get::Count(*get),
            Get::Cell(kind, get) => Get::Cell(*kind, *get),
            Get::Computed(get) => Get::Computed(Arc::clone(get)),
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
    /// Makes a quantity that pages show; a result for which `get` returns `None` has no value.
    pub const fn new(name: &'static str, label: &'static str, better: Better, get: fn(&E) -> Option<f64>) -> Self {
        Self::from_getter(name, label, better, Get::Number(get))
    }

    /// Makes a quantity that is in tables only; `None`: no value.
    pub const fn in_table(name: &'static str, get: fn(&E) -> Option<f64>) -> Self {
        Self::new(name, "", Better::Neither, get)
    }

    /// Makes a whole number that is in tables only; `None`: no value.
    pub const fn count(name: &'static str, get: fn(&E) -> Option<usize>) -> Self {
        Self::from_getter(name, "", Better::Neither, Get::Count(get))
    }

    /// Makes a cell of any kind, which may have content without a result as well.
    pub const fn cell(
        name: &'static str,
        label: &'static str,
        better: Better,
        kind: Kind,
        get: fn(FoundOr<'_, E>) -> Cell,
    ) -> Self {
        Self::from_getter(name, label, better, Get::Cell(kind, get))
    }

    /// Makes a cell of text, which may have content without a result as well.
    pub const fn text(name: &'static str, get: fn(FoundOr<'_, E>) -> Cell) -> Self {
        Self::cell(name, "", Better::Neither, Kind::Text, get)
    }

    /// Makes a quantity from name, label and the way to compute it.
    const fn from_getter(name: &'static str, label: &'static str, better: Better, get: Get<E>) -> Self {
        Self { name: Cow::Borrowed(name), label: Cow::Borrowed(label), better, of: Vec::new(), get }
    }

    /// Makes the components of a vector in mm: columns `WHAT_x_mm` and so on, each with `label` and its axis; `None`: no value.
    pub fn vector_mm(what: &str, label: &str, get: fn(&E) -> Option<[f64; 3]>) -> [Self; 3] {
        Self::vector(what, "mm", label, get)
    }

    /// Makes the components of a vector in `unit`, as [`vector_mm`](Self::vector_mm).
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

    /// Makes a quantity from names and a closure that are known only at run time; `None`: no value.
    pub fn computed(
        name: String,
        label: String,
        better: Better,
        get: impl Fn(&E) -> Option<f64> + Send + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), label: label.into(), better, of: Vec::new(), get: Get::Computed(Arc::new(get)) }
    }

    /// Makes the quantity of the largest absolute value of `all`; it is missing where one of them is.
    pub fn largest_of(name: String, label: String, better: Better, all: Vec<Self>) -> Self {
        let of = all.iter().map(|each| each.name.to_string()).collect();
        let largest =
            move |result: &E| all.iter().try_fold(0.0, |most: f64, each| Some(most.max(each.value(result)?.abs())));
        Self { of, ..Self::computed(name, label, better, largest) }
    }

    /// Computes the value of the quantity from a result; `None` where there is none, or it is text.
    pub fn value(&self, result: &E) -> Option<f64> {
        match &self.get {
            Get::Number(get) => get(result),
            Get::Part(get, axis) => get(result).map(|vector| vector[*axis]),
            Get::Count(get) => get(result).map(|count| count as f64),
            Get::Cell(_, get) => match get(Ok(result)) {
                Cell::Number(number) => Some(number),
                Cell::Count(count) => Some(count as f64),
                Cell::Missing | Cell::Text(_) => None,
            },
            Get::Computed(get) => get(result),
        }
    }

    /// Returns the table cell of the quantity for a result, or for the failure in its place.
    pub fn cell_of(&self, result: FoundOr<'_, E>) -> Cell {
        match &self.get {
            Get::Cell(_, get) => get(result),
            Get::Count(get) => result.ok().and_then(get).into(),
            _ => result.ok().and_then(|result| self.value(result)).into(),
        }
    }

    /// Returns the table column of the quantity.
    pub fn column(&self) -> Column {
        let kind = match &self.get {
            Get::Cell(kind, _) => *kind,
            Get::Count(_) => Kind::Count,
            _ => Kind::Number,
        };
        Column { name: self.name.to_string(), kind }
    }

    /// Returns the unit of the quantity as pages and figures write it, empty if there is none.
    pub fn unit(&self) -> String {
        match self.column().unit() {
            Some("deg") => "°".into(),
            unit => unit.unwrap_or_default().into(),
        }
    }

    /// Returns the label of the quantity with its unit, for an axis of a figure.
    pub fn axis_label(&self) -> String {
        format!("{} [{}]", self.label, self.unit())
    }

    /// Returns the quantity as pages describe it.
    pub fn layer(&self) -> page::Quantity {
        page::Quantity {
            columns: self.columns(),
            label: self.label.to_string(),
            unit: self.unit(),
            better: self.better,
        }
    }

    /// Returns the name of the quantity's column, or of those of which it is the largest.
    fn columns(&self) -> Vec<String> {
        if self.of.is_empty() { vec![self.name.to_string()] } else { self.of.clone() }
    }

    /// Returns where an extreme `value` of the quantity is in the table `file`, among the rows with these cells.
    pub fn found_in(&self, file: &str, rows: &[[&str; 2]], extreme: Extreme, value: f64) -> InTable {
        InTable::new(file, self.columns(), rows, extreme, value)
    }
}

/// Returns quantities as pages describe them, in this order.
pub(crate) fn layers<'a, E: 'static>(quantities: impl IntoIterator<Item = &'a Quantity<E>>) -> Vec<page::Quantity> {
    quantities.into_iter().map(Quantity::layer).collect()
}
