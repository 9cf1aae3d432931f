//! The Filippov system in its original variables.
