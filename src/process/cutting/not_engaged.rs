//! Milling whose engagement is found from the stock, on pages: none, as they cut no stock.

use std::convert::Infallible;

/// No law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngagedMilling {
    /// As there is no law, none.
    pub feed_per_tooth_mm: Option<f64>,
    never: Infallible,
}
