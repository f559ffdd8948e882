//! A number that counts the operations made with it, for the account of what an equilibrium costs.

use std::cell::Cell;

use kinetostat_engine::lanes::Real;

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
pub fn take_counts() -> [u64; 4] {
    COUNTS.replace([0; 4])
}

#[derive(Debug, Clone, Copy)]
pub struct Counted(f64);

/// An operator between two numbers, which is counted.
macro_rules! operator {
    ($operator:ident, $method:ident, $kind:ident) => {
        impl std::ops::$operator for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                counted(Kind::$kind, self.0.$method(other.0))
            }
        }
    };
}
operator!(Add, add, Sum);
operator!(Sub, sub, Sum);
operator!(Mul, mul, Product);
operator!(Div, div, Quotient);

impl std::ops::Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl std::ops::AddAssign for Counted {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl std::ops::SubAssign for Counted {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
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

    fn all_zero(self) -> bool {
        self.0 == 0.0
    }

    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    fn mask_to_bits(mask: bool) -> u8 {
        u8::from(mask)
    }

    fn mask_from_bits(bits: u8) -> bool {
        bits & 1 == 1
    }
}
