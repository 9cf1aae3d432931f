//! Functions for the instructions that the processor has.

/// Calls a closure that is always inlined, as is all that it calls, with the widest vectors of the processor.
#[inline(always)]
pub fn vectorized<R>(f: impl FnMut() -> R) -> R {
    pulp::Arch::new().dispatch(Inlined(f))
}

/// pulp calls a closure by the adapter that makes a `FnOnce` of it, which is not inlined: there each fused product would
/// be a library call.
struct Inlined<F>(F);

impl<R, F: FnMut() -> R> pulp::WithSimd for Inlined<F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) -> R {
        (self.0)()
    }
}
