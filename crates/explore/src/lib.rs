//! The local web page of `slipmap explore`: parameter space under the mouse.
//!
//! A server on the loopback address answers one page with pictures of planes, with everything that is known
//! of a point, and with figures, all of them computed by the engines of the library. It keeps no state of a
//! user: the whole state of a page is in its link, and each request contains all that it needs. Nothing is
//! read from the disk but the file that the command names.

// Only the program and its tests use this crate.
#![allow(missing_docs)]

mod assets;
mod body;
mod boundaries;
mod catalogue;
mod export;
mod figures;
mod guard;
mod law;
mod picture;
mod place;
mod plane;
mod point;
mod quantities;
mod refusal;
mod server;
mod show;
mod start;

pub use server::serve;
pub use start::Start;
