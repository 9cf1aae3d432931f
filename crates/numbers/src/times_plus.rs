//! The product and sum that loops consist of.

/// `self * by + plus`: in one instruction where processors have it and the error is half of a unit in the last place,
/// and with two roundings in WebAssembly, which has no such instruction. Where the exact error of a product is wanted,
/// `f64::mul_add` has it.
pub trait TimesPlus {
    /// `self * by + plus`.
    #[must_use]
    fn times_plus(self, by: f64, plus: f64) -> f64;
}

impl TimesPlus for f64 {
    #[inline(always)]
    fn times_plus(self, by: f64, plus: f64) -> f64 {
        if cfg!(target_family = "wasm") { self * by + plus } else { self.mul_add(by, plus) }
    }
}
