//! The smallest and the largest value of a quantity, and where they were found.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::Quantity;
use crate::files::words::position;

/// A value, where it was found, and what it was found `at`, such as the tool angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Found<A> {
    /// The value.
    pub value: f64,
    /// Where, mm.
    pub position_mm: [f64; 3],
    /// What else is known of it.
    #[serde(flatten)]
    pub at: A,
}

impl<A> Found<A> {
    /// Where, in words.
    pub fn place(&self) -> String {
        let [x, y, z] = self.position_mm;
        position(x, y, z)
    }
}

/// The smallest and the largest value seen, each where it was seen first.
#[derive(Debug, Clone, PartialEq)]
pub struct Extremes<A>(Option<[Found<A>; 2]>);

impl<A> Default for Extremes<A> {
    fn default() -> Self {
        Self(None)
    }
}

impl<A: Clone> Extremes<A> {
    /// Takes a value.
    pub fn see(&mut self, value: f64, position_mm: [f64; 3], at: &A) {
        let found = || Found { value, position_mm, at: at.clone() };
        let [least, most] = self.0.get_or_insert_with(|| [found(), found()]);
        if value < least.value {
            *least = found();
        }
        if value > most.value {
            *most = found();
        }
    }

    /// The smallest and the largest.
    pub fn get(&self) -> Option<&[Found<A>; 2]> {
        self.0.as_ref()
    }
}

/// Extremes of several quantities of what is found, an `E`.
pub struct OfQuantities<E, A>(Vec<(Quantity<E>, Extremes<A>)>);

impl<E: 'static, A: Clone + Serialize> OfQuantities<E, A> {
    /// Of `quantities`, nothing seen.
    pub fn new(quantities: impl IntoIterator<Item = Quantity<E>>) -> Self {
        Self(quantities.into_iter().map(|quantity| (quantity, Extremes::default())).collect())
    }

    /// Takes what was found at a place.
    pub fn see(&mut self, found: &E, position_mm: [f64; 3], at: &A) {
        for (quantity, extremes) in &mut self.0 {
            if let Some(value) = quantity.value(found) {
                extremes.see(value, position_mm, at);
            }
        }
    }

    /// The smallest and the largest value of `quantity`.
    pub fn of(&self, quantity: &Quantity<E>) -> Option<&[Found<A>; 2]> {
        self.0.iter().find(|(own, _)| own.name == quantity.name)?.1.get()
    }

    /// What was seen, by the names of the quantities.
    pub fn json(&self) -> Map<String, Value> {
        let entry = |(quantity, extremes): &(Quantity<E>, Extremes<A>)| {
            let [smallest, largest] = extremes.get()?;
            Some((quantity.name.to_string(), json!({ "smallest": smallest, "largest": largest })))
        };
        self.0.iter().filter_map(entry).collect()
    }
}
