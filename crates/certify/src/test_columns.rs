//! Columns for unit tests of the closed-form tests.

use slipmap_model::friction::{Column, Law};
use slipmap_model::point::{LawParameters, Point};
use slipmap_numbers::random::Random;

/// A column of the Stribeck law.
pub(super) fn stribeck(epsilon: f64, alpha: f64, beta: f64, gamma: f64, belt_speed: f64) -> Column {
    let law = LawParameters::new(&[alpha, beta, gamma]);
    Law::Stribeck.column(&Point { epsilon, law, belt_speed, damping: 0.0 })
}

/// The first `count` columns of a fixed sequence: eps in [1e-3, 1] and V in [0.1, 10] spread over their
/// decades, alpha and beta in [0, 1], gamma in [0, 10].
pub(super) fn random_columns(count: usize) -> impl Iterator<Item = Column> {
    let mut random = Random(0);
    let mut unit = move || random.unit();
    (0..count).map(move |_| {
        let epsilon = 10f64.powf(-3.0 * unit());
        let belt_speed = 10f64.powf(2.0 * unit() - 1.0);
        stribeck(epsilon, unit(), unit(), 10.0 * unit(), belt_speed)
    })
}
