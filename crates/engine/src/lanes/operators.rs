//! Macro for the arithmetic operators of a type of number.

/// Implements the operators that [`Real`](super::Real) asks for: `- |a| …` is the negative of `a`, `Add add |a, b| …` the sum.
macro_rules! operators {
    ($type:ident, - |$number:ident| $negative:expr, $($operator:ident $method:ident |$a:ident, $b:ident| $result:expr),+ $(,)?) => {
        $(
            impl std::ops::$operator for $type {
                type Output = Self;
                #[inline(always)]
                fn $method(self, $b: Self) -> Self {
                    let $a = self;
                    $result
                }
            }
        )+

        impl std::ops::Neg for $type {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                let $number = self;
                $negative
            }
        }

        impl std::ops::AddAssign for $type {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl std::ops::SubAssign for $type {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }
    };
}
pub(super) use operators;
