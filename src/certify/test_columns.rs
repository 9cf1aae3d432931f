//! Columns for the unit tests of this module.

use crate::friction::{Column, Law};
use crate::point::{LawParameters, Point};

/// A column of the Stribeck law.
pub(super) fn stribeck(epsilon: f64, alpha: f64, beta: f64, gamma: f64, belt_speed: f64) -> Column {
    let law = LawParameters::new(&[alpha, beta, gamma]);
    Law::Stribeck.column(&Point { epsilon, law, belt_speed, damping: 0.0 })
}

/// The first `count` columns of a fixed sequence: eps in [1e-3, 1] and V in [0.1, 10] spread over their
/// decades, alpha and beta in [0, 1], gamma in [0, 10].
pub(super) fn random_columns(count: usize) -> impl Iterator<Item = Column> {
    // SplitMix64.
    let mut state = 0u64;
    let mut unit = move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(move |_| {
        let epsilon = 10f64.powf(-3.0 * unit());
        let belt_speed = 10f64.powf(2.0 * unit() - 1.0);
        stribeck(epsilon, unit(), unit(), 10.0 * unit(), belt_speed)
    })
}
