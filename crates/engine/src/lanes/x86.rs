//! Vector registers of x86-64: AVX2 (four lanes) and AVX-512 (eight).
//!
//! # Safety
//! The types of this file may only be used on a processor that has their instructions. `statics::Batch`, `machine::BatchKinematics` and
//! `Level::run`, all that name them, ask [`Level::is_available`](super::Level::is_available) first; the `unsafe` blocks rely on it.

use std::arch::x86_64::*;

use super::{Real, operators::operators};

/// Four numbers in an AVX register.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub(crate) struct F64x4(__m256d);

/// Eight numbers in an AVX-512 register.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub(crate) struct F64x8(__m512d);

/// A type of number in registers, from the intrinsics of its instructions and what is written differently for each.
macro_rules! real {
    ($type:ident, $lanes:literal, $features:literal, $mask:ty, $splat:ident, $sqrt:ident, $compare:ident,
     $add:ident, $sub:ident, $mul:ident, $div:ident, $($function:tt)+) => {
        // SAFETY of all blocks: the processor has the instruction, see the top of this file.
        operators! { $type, - |a| Self::splat(-0.0) - a,
            Add add |a, b| Self(unsafe { $add(a.0, b.0) }),
            Sub sub |a, b| Self(unsafe { $sub(a.0, b.0) }),
            Mul mul |a, b| Self(unsafe { $mul(a.0, b.0) }),
            Div div |a, b| Self(unsafe { $div(a.0, b.0) }),
        }

        impl $type {
            /// The numbers of the lanes.
            #[inline(always)]
            fn as_array(&self) -> &[f64; $lanes] {
                // SAFETY: the register is that many numbers side by side, and more strictly aligned than they are.
                unsafe { &*std::ptr::from_ref(self).cast() }
            }

            /// The numbers of the lanes, to be changed.
            #[inline(always)]
            fn as_array_mut(&mut self) -> &mut [f64; $lanes] {
                // SAFETY: as in `as_array`.
                unsafe { &mut *std::ptr::from_mut(self).cast() }
            }

            /// Runs `work` compiled with these instructions.
            #[inline]
            #[target_feature(enable = $features)]
            fn run<T>(work: impl FnOnce() -> T) -> T {
                work()
            }
        }

        impl Real for $type {
            const LANES: usize = $lanes;
            type Mask = $mask;

            #[inline(always)]
            fn splat(value: f64) -> Self {
                Self(unsafe { $splat(value) })
            }

            #[inline(always)]
            fn lane(self, lane: usize) -> f64 {
                self.as_array()[lane]
            }

            #[inline(always)]
            fn set_lane(&mut self, lane: usize, value: f64) {
                self.as_array_mut()[lane] = value;
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(unsafe { $sqrt(self.0) })
            }

            #[inline(always)]
            fn greater(self, other: Self) -> $mask {
                unsafe { $compare::<_CMP_GT_OQ>(self.0, other.0) }
            }

            #[inline(always)]
            fn is_nan(self) -> $mask {
                unsafe { $compare::<_CMP_UNORD_Q>(self.0, self.0) }
            }

            #[inline(always)]
            fn all_zero(self) -> bool {
                Self::mask_to_bits(unsafe { $compare::<_CMP_NEQ_UQ>(self.0, $splat(0.0)) }) == 0
            }

            #[inline(always)]
            fn vectorized<T>(work: impl FnOnce() -> T) -> T {
                unsafe { Self::run(work) }
            }

            $($function)+
        }
    };
}

// SAFETY of all blocks: as in `real`.
real! { F64x4, 4, "avx2", __m256d, _mm256_set1_pd, _mm256_sqrt_pd, _mm256_cmp_pd,
    _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd,

    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn select(mask: __m256d, yes: Self, no: Self) -> Self {
        Self(unsafe { _mm256_blendv_pd(no.0, yes.0, mask) })
    }

    #[inline(always)]
    fn mask_to_bits(mask: __m256d) -> u8 {
        unsafe { _mm256_movemask_pd(mask) as u8 }
    }

    #[inline(always)]
    fn mask_from_bits(bits: u8) -> __m256d {
        let lane = |bit: u8| if bits & bit != 0 { -1 } else { 0 };
        unsafe { _mm256_castsi256_pd(_mm256_set_epi64x(lane(8), lane(4), lane(2), lane(1))) }
    }
}

real! { F64x8, 8, "avx512f", __mmask8, _mm512_set1_pd, _mm512_sqrt_pd, _mm512_cmp_pd_mask,
    _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd,

    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_abs_pd(self.0) })
    }

    #[inline(always)]
    fn select(mask: __mmask8, yes: Self, no: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_pd(mask, no.0, yes.0) })
    }

    #[inline(always)]
    fn mask_to_bits(mask: __mmask8) -> u8 {
        mask
    }

    #[inline(always)]
    fn mask_from_bits(bits: u8) -> __mmask8 {
        bits
    }
}
