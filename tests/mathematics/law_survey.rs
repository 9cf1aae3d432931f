//! The margins of random pairs of a friction law and a point compared with those of the witness.

use crate::agreement::{damping, law};
use crate::sample::{Random, Sampling};
use rayon::prelude::*;
use slipmap::filippov::Oscillator;
use slipmap::orbits::return_map::{Turn, turns_of};
use slipmap::witness;

/// The margin of one turn by the engine of maps, at several tolerances, and by the direct engine.
fn margins_are_within_their_error(count: u64) {
    let compare = |number: u64| {
        let mut random = Random(0xface ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let (kind, law, parameters) = law(&mut random, [0.05, 0.95], [0.15, 1.5]);
        let (belt_speed, epsilon) = (random.log(0.05, 4.0), random.log(0.02, 1.0));
        let column = law.column(&law.point(epsilon, &parameters, belt_speed, 0.0).unwrap());
        let c = damping(&column, &mut random);
        let direct = witness::flow(&Oscillator::in_column(&column, c), 1e-12);
        let mut compared = [0; 3];
        for (compared, tolerance) in compared.iter_mut().zip([1e-6, 1e-9, 1e-11]) {
            let [Turn::Complete { margin, error, .. }] = turns_of(&column, &[c], tolerance)[..] else {
                continue;
            };
            let off = (margin - direct.margin).abs();
            assert!(
                !(off > error + direct.margin_error),
                "{kind} {number} at {tolerance:e}: {margin} +- {error:e}, {direct:?}"
            );
            *compared += u64::from(off.is_finite() && error <= tolerance);
        }
        compared
    };
    // The last is an orbit that turns just before a corner, where the end of a span lies beyond its turning
    // point.
    let all = (0..count).into_par_iter().chain([3082]).map(compare);
    let compared = all.reduce(|| [0; 3], |a, b| std::array::from_fn(|i| a[i] + b[i]));
    assert!(compared.iter().all(|compared| 10 * compared > 6 * count), "{compared:?}");
}

#[test]
fn margins_of_random_laws_are_those_of_the_direct_engine() {
    margins_are_within_their_error(600);
}

#[test]
#[ignore = "minutes: cargo test --test mathematics law_survey:: -- --ignored --nocapture"]
fn ten_thousand_margins_of_random_laws_are_those_of_the_direct_engine() {
    margins_are_within_their_error(10_000);
}
