//! Gauss's rules on [-1, 1], with the matrices of collocation at their nodes.

use std::f64::consts::PI;

/// Largest number of nodes of a rule.
pub const MOST: usize = 8;

/// The rule of N nodes. Functions are given by their values at the nodes, as the polynomials of degree N - 1
/// through them. Its rows begin at lines of the cache, as [`Aligned`](crate::Aligned) does.
#[repr(align(64))]
pub struct Rule<const N: usize> {
    /// The nodes, increasing.
    pub nodes: [f64; N],
    /// The weights of the integral over [-1, 1].
    pub weights: [f64; N],
    /// Row j gives, from a function's values, those of its antiderivative that vanishes at -1; transposed:
    /// `[k][j]` is the part of value k in node j.
    pub antiderivative: [[f64; N]; N],
    /// The matrix of the derivative, in the same layout.
    pub derivative: [[f64; N]; N],
}

/// Legendre polynomials P_0 to P_n at x.
fn legendre<const N: usize>(x: f64) -> [f64; N] {
    let mut p = [1.0; N];
    p[1] = x;
    for n in 2..N {
        let order = n as f64;
        p[n] = ((2.0 * order - 1.0) * x * p[n - 1] - (order - 1.0) * p[n - 2]) / order;
    }
    p
}

impl<const N: usize> Rule<N> {
    /// The rule of N nodes.
    pub fn gauss() -> Self {
        // More than P_0 to P_(N + 1) for every rule in use.
        let at = |x: f64| legendre::<18>(x);
        let order = N as f64;
        let slope = |x: f64, p: &[f64]| order * (p[N - 1] - x * p[N]) / (1.0 - x * x);
        let nodes: [f64; N] = std::array::from_fn(|j| {
            let mut x = -(PI * (j as f64 + 0.75) / (order + 0.5)).cos();
            for _ in 0..6 {
                let p = at(x);
                x -= p[N] / slope(x, &p);
            }
            x
        });
        let weights = nodes.map(|x| 2.0 / ((1.0 - x * x) * slope(x, &at(x)).powi(2)));
        // The polynomial through unit value k has the Legendre coefficients (n + 1/2) w_k P_n(x_k). `term`
        // returns two factors of n + 1/2 times what the matrix makes of P_n.
        let matrix = |term: &dyn Fn(usize, &[f64]) -> [f64; 2]| {
            std::array::from_fn(|k| {
                let of_node = at(nodes[k]);
                nodes.map(|x| {
                    let p = at(x);
                    let terms = (0..N).map(|n| (of_node[n], term(n, &p)));
                    weights[k] * terms.map(|(of_node, [factor, of_p])| factor * of_node * of_p).sum::<f64>()
                })
            })
        };
        // P_n has the antiderivative (P_(n+1) - P_(n-1)) / (2 n + 1).
        let antiderivative = matrix(&|n, p| [0.5, p[n + 1] - if n == 0 { -1.0 } else { p[n - 1] }]);
        // P_n' = the sum of (2 m + 1) P_m over m = n - 1, n - 3, ...
        let derivative = matrix(&|n, p| {
            [n as f64 + 0.5, (0..n).rev().step_by(2).map(|m| (2 * m + 1) as f64 * p[m]).sum()]
        });
        Self { nodes, weights, antiderivative, derivative }
    }

    /// The value at `x` of the polynomial through `values`.
    pub fn interpolate(&self, values: &[f64; MOST], x: f64) -> f64 {
        let p = legendre::<{ MOST + 2 }>(x);
        let basis = self.nodes.iter().zip(&self.weights).zip(values).map(|((node, weight), value)| {
            let of_node = legendre::<{ MOST + 2 }>(*node);
            let kernel: f64 = (0..N).map(|n| (n as f64 + 0.5) * of_node[n] * p[n]).sum();
            weight * kernel * value
        });
        basis.sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds<const N: usize>() {
        let rule = Rule::<N>::gauss();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 2e-14, "{N}: {a} {b}");
        for power in 0..2 * N as i32 {
            let sum: f64 = rule.nodes.iter().zip(&rule.weights).map(|(x, w)| w * x.powi(power)).sum();
            near(sum, if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 });
        }
        for power in 0..N as i32 {
            let apply = |matrix: &[[f64; N]; N], j: usize| -> f64 {
                (0..N).map(|k| matrix[k][j] * rule.nodes[k].powi(power)).sum()
            };
            for (j, x) in rule.nodes.iter().enumerate() {
                let next = f64::from(power + 1);
                near(apply(&rule.antiderivative, j), (x.powi(power + 1) - (-1f64).powi(power + 1)) / next);
                let slope = if power == 0 { 0.0 } else { f64::from(power) * x.powi(power - 1) };
                near(0.1 * apply(&rule.derivative, j), 0.1 * slope);
            }
            let mut values = [0.0; MOST];
            for (value, x) in values.iter_mut().zip(rule.nodes) {
                *value = x.powi(power);
            }
            near(rule.interpolate(&values, 0.3), 0.3f64.powi(power));
        }
    }

    #[test]
    fn rules_are_exact_for_polynomials() {
        holds::<4>();
        holds::<5>();
        holds::<6>();
        holds::<8>();
    }
}
