//! The page of `slipmap explore`: parameter space under the mouse.
//!
//! One HTML file asks for pictures of planes, for everything that is known of a point, and for figures, all of them
//! computed by the engines of the library: by [`ask`], which a server calls, or a worker of the browser in which this
//! crate runs as WebAssembly. No state is kept between requests: the whole state of a page is in its link, and each
//! request contains all that it needs.

// Only the program and its tests use this crate.
#![allow(missing_docs)]

mod ask;
mod boundaries;
mod catalogue;
mod export;
mod figures;
mod law;
mod page;
mod picture;
mod place;
mod plane;
mod point;
mod quantities;
mod refusal;
mod show;
mod start;

pub use ask::{LONGEST_BODY, ask};
pub use page::{Engine, WASM, page};
pub use refusal::Refusal;
pub use start::Start;
