//! The smallest and the largest value of a quantity, and where they are.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::Quantity;
use crate::files::words::position;

/// A value of a quantity, its position, and what else is known of it, such as the tool angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ValueAt<A> {
    /// The value.
    pub value: f64,
    /// Position, O, mm.
    pub position_mm: [f64; 3],
    /// What else is known of it.
    #[serde(flatten)]
    pub at: A,
}

impl<A> ValueAt<A> {
    /// Returns the position at which the value was found as text, such as "(1.0, 2.0, 3.0) mm".
    pub fn place(&self) -> String {
        let [x, y, z] = self.position_mm;
        position(x, y, z)
    }
}

/// The smallest and the largest of the values added, each where it was first.
#[derive(Debug, Clone, PartialEq)]
pub struct Extremes<A>(Option<[ValueAt<A>; 2]>);

impl<A> Default for Extremes<A> {
    fn default() -> Self {
        Self(None)
    }
}

impl<A: Clone> Extremes<A> {
    /// Adds a value, found at a position (O, mm); `at` is what else is known of it.
    pub fn add(&mut self, value: f64, position_mm: [f64; 3], at: &A) {
        let entry = || ValueAt { value, position_mm, at: at.clone() };
        let [least, most] = self.0.get_or_insert_with(|| [entry(), entry()]);
        if value < least.value {
            *least = entry();
        }
        if value > most.value {
            *most = entry();
        }
    }

    /// Returns the smallest and the largest value; `None` if none was added.
    pub fn get(&self) -> Option<&[ValueAt<A>; 2]> {
        self.0.as_ref()
    }
}

/// Extremes of several quantities of results of type `E`.
pub struct QuantityExtremes<E, A>(Vec<(Quantity<E>, Extremes<A>)>);

impl<E: 'static, A: Clone + Serialize> QuantityExtremes<E, A> {
    /// Starts the extremes of these quantities, without values.
    pub fn new(quantities: impl IntoIterator<Item = Quantity<E>>) -> Self {
        Self(quantities.into_iter().map(|quantity| (quantity, Extremes::default())).collect())
    }

    /// Adds the values of all quantities of a `result`, found at a position (O, mm); `at` is what else is known of them.
    pub fn add(&mut self, result: &E, position_mm: [f64; 3], at: &A) {
        for (quantity, extremes) in &mut self.0 {
            if let Some(value) = quantity.value(result) {
                extremes.add(value, position_mm, at);
            }
        }
    }

    /// Returns the smallest and the largest value of `quantity`; `None` if it is not among these or has no value.
    pub fn of(&self, quantity: &Quantity<E>) -> Option<&[ValueAt<A>; 2]> {
        self.0.iter().find(|(known, _)| known.name == quantity.name)?.1.get()
    }

    /// Returns all extremes as JSON, by the names of the quantities.
    pub fn json(&self) -> Map<String, Value> {
        let entry = |(quantity, extremes): &(Quantity<E>, Extremes<A>)| {
            let [smallest, largest] = extremes.get()?;
            Some((quantity.name.to_string(), json!({ "smallest": smallest, "largest": largest })))
        };
        self.0.iter().filter_map(entry).collect()
    }
}
