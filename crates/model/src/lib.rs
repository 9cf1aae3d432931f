//! Friction laws, parameter points, the oscillator and its vector field, and the words for what its orbits do.

pub mod corners;
pub mod filippov;
pub mod flow;
pub mod friction;
pub mod point;
