//! A parameter point, and the scaled groups on which its behaviour depends.
//!
//! All quantities are dimensionless (time in units of sqrt(mass / stiffness), force in units of the
//! static friction force).

/// Largest number of parameters of a friction law.
pub const MAX_LAW_PARAMETERS: usize = 8;

/// Values of a friction law's own parameters, in the order of [`crate::friction::Law::parameters`].
///
/// Stored inline so that points can be copied freely in hot loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawParameters {
    values: [f64; MAX_LAW_PARAMETERS],
    len: usize,
}

impl LawParameters {
    /// Copies up to [`MAX_LAW_PARAMETERS`] values.
    ///
    /// # Panics
    /// If `values` is longer: a law with more parameters is a bug, not an input error.
    #[must_use]
    pub fn new(values: &[f64]) -> Self {
        let mut stored = [0.0; MAX_LAW_PARAMETERS];
        stored[..values.len()].copy_from_slice(values);
        Self { values: stored, len: values.len() }
    }

    /// Replaces the value at this position.
    ///
    /// # Panics
    /// If there is no such position.
    pub fn set(&mut self, position: usize, value: f64) {
        self.values[..self.len][position] = value;
    }

    /// The values, in the law's order.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.len]
    }
}

/// A point of parameter space: the parameters that all laws share, and the law's own. Made by
/// [`crate::friction::Law::point`], which checks it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Size of the nonlinear part of the friction law and of the viscous damping, eps > 0.
    pub epsilon: f64,
    /// The friction law's own parameters.
    pub law: LawParameters,
    /// Belt speed V > 0.
    pub belt_speed: f64,
    /// Viscous damping c >= 0; the force is `-eps c x2`.
    pub damping: f64,
}

/// The four groups on which the existence of a cycle of a Stribeck oscillator depends, once velocity is
/// measured in belt speeds, s = u / V:
///
/// ```text
/// D(s) = -C + A / (1 + k s)^2 - 2 b s
/// ```
///
/// Two points with equal groups have the same scaled orbit, whatever their six parameters; the belt
/// speed enters only through the landing condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaledGroups {
    /// A = eps gamma (1 - alpha): weakening rate of the friction at zero slip.
    pub a: f64,
    /// k = eps gamma V: belt speed in units of the speed over which the friction weakens.
    pub k: f64,
    /// b = eps beta V: half the rate, at belt speed, at which the quadratic term strengthens the friction.
    pub b: f64,
    /// C = eps c: viscous damping.
    pub c: f64,
}

impl ScaledGroups {
    /// The divergence D at the scaled slip speed `s` = u / V.
    #[must_use]
    pub fn divergence(&self, s: f64) -> f64 {
        let q = 1.0 + self.k * s;
        self.a / (q * q) - self.c - 2.0 * self.b * s
    }
}
