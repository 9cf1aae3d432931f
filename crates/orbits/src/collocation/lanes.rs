//! Numbers of several orbits, one per lane of two vector registers.
//!
//! A thin layer over `pulp` that makes formulas readable. Every operation acts on each lane alone and
//! `mul_add` is fused on all machines: an orbit's digits depend neither on its neighbours nor on the vector
//! width.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use pulp::Simd;

/// One number for each of [`Lanes::COUNT`] orbits. Two registers hide the latency of one operation behind
/// the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes<S: Simd> {
    simd: S,
    low: S::f64s,
    high: S::f64s,
}

/// Defines functions that apply an operation of `S` to both registers.
macro_rules! lanewise {
    ($($(#[$doc:meta])* $name:ident($($operand:ident),*) = $op:ident;)*) => {
        impl<S: Simd> Lanes<S> {
            $($(#[$doc])*
            #[inline(always)]
            pub(super) fn $name(self, $($operand: Self),*) -> Self {
                Self {
                    simd: self.simd,
                    low: self.simd.$op(self.low, $($operand.low),*),
                    high: self.simd.$op(self.high, $($operand.high),*),
                }
            })*
        }
    };
}

lanewise! {
    /// `self * factor + term`, rounded once.
    mul_add(factor, term) = mul_add_f64s;
    /// `term - self * factor`, rounded once.
    neg_mul_add(factor, term) = negate_mul_add_f64s;
    /// The smaller one; unspecified where either is NaN.
    min(other) = min_f64s;
    /// The absolute value.
    abs() = abs_f64s;
    /// The square root.
    sqrt() = sqrt_f64s;
}

/// Defines the operators.
macro_rules! operators {
    ($($trait:ident $name:ident $op:ident;)*) => {
        $(impl<S: Simd> $trait for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self {
                    simd: self.simd,
                    low: self.simd.$op(self.low, other.low),
                    high: self.simd.$op(self.high, other.high),
                }
            }
        })*
    };
}

operators! {
    Add add add_f64s;
    Sub sub sub_f64s;
    Mul mul mul_f64s;
    Div div div_f64s;
}

impl<S: Simd> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { simd: self.simd, low: self.simd.neg_f64s(self.low), high: self.simd.neg_f64s(self.high) }
    }
}

impl<S: Simd> Lanes<S> {
    /// Number of orbits per value.
    pub(super) const COUNT: usize = 2 * S::F64_LANES;

    /// The same number in every lane.
    #[inline(always)]
    pub(super) fn splat(simd: S, value: f64) -> Self {
        let value = simd.splat_f64s(value);
        Self { simd, low: value, high: value }
    }

    /// The same number in every lane, without an `S`.
    #[inline(always)]
    pub(super) fn same(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    /// The first [`Lanes::COUNT`] values of `from`.
    #[inline(always)]
    pub(super) fn load(simd: S, from: &[f64]) -> Self {
        let (vectors, _) = S::as_simd_f64s(from);
        Self { simd, low: vectors[0], high: vectors[1] }
    }

    /// Writes to the first [`Lanes::COUNT`] places of `to`.
    #[inline(always)]
    pub(super) fn store(self, to: &mut [f64]) {
        let (vectors, _) = S::as_mut_simd_f64s(to);
        vectors[0] = self.low;
        vectors[1] = self.high;
    }
}
