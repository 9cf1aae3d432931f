//! The margins of random pairs of a friction law and a point compared with those of the witness.

use crate::agreement::{damping, law};
use crate::sample::{Random, Sampling};
use rayon::prelude::*;
use slipmap::filippov::Oscillator;
use slipmap::orbits::flow;
use slipmap::witness;

/// The margin of the orbit by arcs, and by the direct engine.
fn margins_are_within_their_error(count: u64) {
    let compare = |number: u64| {
        let mut random = Random(0xface ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let (kind, law, parameters) = law(&mut random, [0.05, 0.95], [0.15, 1.5]);
        let (belt_speed, epsilon) = (random.log(0.05, 4.0), random.log(0.02, 1.0));
        let column = law.column(&law.point(epsilon, &parameters, belt_speed, 0.0).unwrap());
        let c = damping(&column, &mut random);
        let direct = witness::flow(&Oscillator::in_column(&column, c), 1e-14);
        let told = flow(&Oscillator::in_column(&column, c), 1e-9);
        let off = (told.margin - direct.margin).abs();
        let errors = told.margin_error + direct.margin_error;
        assert!(!(off > 10.0 * errors), "{kind} {number}: {told:?}, {direct:?}");
        [u64::from(off > errors), u64::from(off.is_finite())]
    };
    // The last is an orbit that turns just before a corner, where the end of a span lies beyond its turning
    // point.
    let all = (0..count).into_par_iter().chain([3082]).map(compare);
    let [small, compared] = all.reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    // Both errors are estimates.
    assert!(1000 * small <= count + 1000 && 10 * compared > 6 * count, "{small} and {compared} of {count}");
}

#[test]
fn margins_of_random_laws_are_those_of_the_direct_engine() {
    margins_are_within_their_error(600);
}

#[test]
#[ignore = "minutes: cargo test --test mathematics law_survey:: -- --ignored --nocapture"]
fn ten_thousand_margins_are_those_of_the_direct_engine() {
    margins_are_within_their_error(10_000);
}
