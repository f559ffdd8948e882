//! Milling whose engagement is found from the stock, on pages: none, as they cut no stock.

use std::convert::Infallible;

/// No law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngagedMilling {
    never: Infallible,
}
