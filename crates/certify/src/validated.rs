//! Verdicts that are theorems, round-off included: what curves that orbits cross one way prove of a column, see
//! [`super::curve`].

use super::{Guarantee, Test, curve};

/// The method.
pub static TEST: Test = Test {
    name: "validated",
    long_name: "proof of the grazing orbit and of the landing, by curves that orbits cross one way",
    equation: "paper, Proposition 1, by a computer-assisted proof",
    guarantee: Guarantee::Validated,
    first_order: false,
    claims: |columns| columns.iter().map(|column| curve::prove(column).claim()).collect(),
};
