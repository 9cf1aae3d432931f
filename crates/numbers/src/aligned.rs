//! Numbers that are computed side by side.

use std::ops::{Deref, DerefMut};

/// `N` numbers from the start of a line of the processor's cache on: a vector that lies in two lines takes twice as long to
/// load and to store.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Aligned<const N: usize>(pub [f64; N]);

impl<const N: usize> Aligned<N> {
    /// `N` times `value`.
    #[inline(always)]
    pub fn all(value: f64) -> Self {
        Self([value; N])
    }

    /// The numbers `of` 0, 1, ..
    #[inline(always)]
    pub fn from_fn(of: impl FnMut(usize) -> f64) -> Self {
        Self(std::array::from_fn(of))
    }
}

impl<const N: usize> Default for Aligned<N> {
    #[inline(always)]
    fn default() -> Self {
        Self::all(0.0)
    }
}

impl<const N: usize> Deref for Aligned<N> {
    type Target = [f64; N];

    #[inline(always)]
    fn deref(&self) -> &[f64; N] {
        &self.0
    }
}

impl<const N: usize> DerefMut for Aligned<N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64; N] {
        &mut self.0
    }
}
