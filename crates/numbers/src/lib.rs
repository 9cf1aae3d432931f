//! Arithmetic that knows no friction: elementary functions, intervals, truncated Taylor series, Chebyshev polynomials, quadrature,
//! roots; numbers as text, names of enums; the processor's vectors.

mod aligned;
pub mod chebyshev;
pub mod elementary;
pub mod gauss;
pub mod interval;
pub mod jet;
mod named;
pub mod random;
mod range;
pub mod roots;
pub mod spacing;
pub mod text;
mod times_plus;
mod vectorized;

pub use aligned::Aligned;
pub use range::Range;
pub use times_plus::TimesPlus;
pub use vectorized::vectorized;
