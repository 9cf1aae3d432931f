//! How the nodes of an axis are spaced.

/// Returns whether neighbouring nodes have equal differences, up to the rounding of decimal input.
pub fn is_linear(values: &[f64]) -> bool {
    let (first, last) = (values[0], values[values.len() - 1]);
    let step = (last - first) / (values.len().max(2) - 1) as f64;
    values.iter().enumerate().all(|(i, value)| (value - first - step * i as f64).abs() <= 1e-6 * step)
}

/// Returns whether all nodes are positive and neighbouring nodes have equal ratios.
pub fn is_logarithmic(values: &[f64]) -> bool {
    values[0] > 0.0 && is_linear(&values.iter().map(|value| value.ln()).collect::<Vec<_>>())
}
