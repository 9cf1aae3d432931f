//! Critical dampings of many columns by the engine itself: the baseline for calls from Python.
//!
//! Arguments: the law or `pad`, the number of columns and the number of passes. Belt speeds run over equal steps from
//! 0.3 to 3, those of a brake pad from 0.02 to 0.4 m/s. Prints the seconds of each pass and the sum of all critical
//! dampings.

// What it does not know ends it.
#![allow(clippy::expect_used)]

use std::time::Instant;

use rayon::prelude::*;
use slipmap::column::critical::critical_dampings;
use slipmap::friction::{Column, Law};
use slipmap::machine::{Machine, Motion};

/// Columns of one task, as in the Python package.
const TASK: usize = 256;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, count, passes] = arguments.as_slice() else { panic!("usage: rate LAW COLUMNS PASSES") };
    let law = Law::BUILT_IN.into_iter().find(|law| law.name() == name);
    let (epsilon, parameters) = match law {
        Some(Law::Stribeck) => (0.1, [0.4, 0.2, 2.0]),
        _ => (1.0, [0.5, 1.0, 0.0]),
    };
    // mass, stiffness, damping, normal force, friction at rest and in slip, Stribeck velocity, strengthening, belt speed
    let pad = [2.0, 5.05e5, 20.0, 1000.0, 0.4, 0.25, 0.05, 0.0, 0.1];
    let pad = Machine::from_array(Motion::Translation, Law::Stribeck, pad);
    // The column at a share of the range of belt speeds.
    let column = |share: f64| match &law {
        Some(law) => {
            law.column(&law.point(epsilon, &parameters, 0.3 + 2.7 * share, 0.0).expect("a legal point"))
        }
        None => pad
            .with("belt_speed", 0.02 + 0.38 * share)
            .expect("it has one")
            .model()
            .expect("a legal pad")
            .column(),
    };
    let count: usize = count.parse().expect("a number of columns");
    for _ in 0..passes.parse().expect("a number of passes") {
        let start = Instant::now();
        let sums: Vec<f64> = (0..count.div_ceil(TASK))
            .into_par_iter()
            .map(|task| {
                let columns: Vec<Column> = (task * TASK..((task + 1) * TASK).min(count))
                    .map(|i| column(i as f64 / (count - 1) as f64))
                    .collect();
                critical_dampings(&columns, 1e-9).into_iter().flatten().map(|root| root.c).sum()
            })
            .collect();
        println!("{} {}", start.elapsed().as_secs_f64(), sums.iter().sum::<f64>());
    }
}
