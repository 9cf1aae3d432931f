//! Critical dampings of many columns by the engine itself: the baseline for calls from Python.
//!
//! Arguments: the law, the number of columns and the number of passes. Belt speeds run over equal steps from
//! 0.3 to 3. Prints the seconds of each pass and the sum of all critical dampings.

use std::time::Instant;

use rayon::prelude::*;
use slipmap::friction::{Column, Law};
use slipmap::simulate::critical::critical_dampings;

/// Columns of one task, as in the Python package.
const TASK: usize = 256;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, count, passes] = arguments.as_slice() else { panic!("usage: rate LAW COLUMNS PASSES") };
    let law = Law::BUILT_IN.into_iter().find(|law| law.name() == name).expect("a built-in law");
    let (epsilon, parameters) = match law {
        Law::Stribeck => (0.1, [0.4, 0.2, 2.0]),
        _ => (1.0, [0.5, 1.0, 0.0]),
    };
    let count: usize = count.parse().expect("a number of columns");
    for _ in 0..passes.parse().expect("a number of passes") {
        let start = Instant::now();
        let speed = |i: usize| 0.3 + 2.7 * i as f64 / (count - 1) as f64;
        let sums: Vec<f64> = (0..count.div_ceil(TASK))
            .into_par_iter()
            .map(|task| {
                let columns: Vec<Column> = (task * TASK..((task + 1) * TASK).min(count))
                    .map(|i| {
                        law.column(&law.point(epsilon, &parameters, speed(i), 0.0).expect("a legal point"))
                    })
                    .collect();
                critical_dampings(&columns, 1e-9).into_iter().flatten().map(|root| root.c).sum()
            })
            .collect();
        println!("{} {}", start.elapsed().as_secs_f64(), sums.iter().sum::<f64>());
    }
}
