//! A number that counts the operations made with it, for the account of what an equilibrium costs.

use std::cell::Cell;

use super::{Real, operators::operators};

/// Kinds of operations. Comparisons, selections and signs are not counted.
#[derive(Clone, Copy)]
enum Kind {
    /// Additions and subtractions.
    Sum,
    Product,
    Quotient,
    Root,
}

thread_local! {
    static COUNTS: Cell<[u64; 4]> = const { Cell::new([0; 4]) };
}

/// `result`, made by an operation of this kind.
fn counted(kind: Kind, result: f64) -> Counted {
    let mut counts = COUNTS.get();
    counts[kind as usize] += 1;
    COUNTS.set(counts);
    Counted(result)
}

/// Sums, products, quotients and roots made on this thread since the last call.
pub(crate) fn take_counts() -> [u64; 4] {
    COUNTS.replace([0; 4])
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Counted(f64);

operators! { Counted, - |a| Self(-a.0),
    Add add |a, b| counted(Kind::Sum, a.0 + b.0),
    Sub sub |a, b| counted(Kind::Sum, a.0 - b.0),
    Mul mul |a, b| counted(Kind::Product, a.0 * b.0),
    Div div |a, b| counted(Kind::Quotient, a.0 / b.0),
}

impl Real for Counted {
    const LANES: usize = 1;
    type Mask = bool;

    fn splat(value: f64) -> Self {
        Self(value)
    }

    fn lane(self, _lane: usize) -> f64 {
        self.0
    }

    fn set_lane(&mut self, _lane: usize, value: f64) {
        self.0 = value;
    }

    fn sqrt(self) -> Self {
        counted(Kind::Root, self.0.sqrt())
    }

    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    fn greater(self, other: Self) -> bool {
        self.0 > other.0
    }

    fn is_nan(self) -> bool {
        self.0.is_nan()
    }

    fn is_zero(self) -> bool {
        self.0 == 0.0
    }

    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    fn bits(mask: bool) -> u8 {
        u8::from(mask)
    }

    fn mask(bits: u8) -> bool {
        bits & 1 == 1
    }
}
