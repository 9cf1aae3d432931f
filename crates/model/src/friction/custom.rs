//! Friction laws implemented by a Rust program.

use std::sync::Arc;

use super::{Gradient, Law, Parameter};
use crate::point::{LawParameters, MAX_LAW_PARAMETERS};

/// A friction law given by functions, for [`Law::custom`].
///
/// A law that can be written as a formula is better given as text ([`super::Expression`]), because a formula
/// has proved bounds. Functions can only be sampled: for them the engines estimate their error, and the
/// theorems claim nothing.
pub trait CustomLaw: std::fmt::Debug + Send + Sync + 'static {
    /// Name in messages and map files.
    fn name(&self) -> &'static str;

    /// The law's own parameters, in the order in which they become axes of a map, slowest first.
    fn parameters(&self) -> &[Parameter];

    /// phi(u), the friction force at slip speed `u` >= 0 in units of the static friction: phi(0) = 1. For
    /// negative `u`, at most a fraction of the belt speed below 0, a smooth continuation.
    fn phi(&self, u: f64, epsilon: f64, parameters: &[f64]) -> f64;

    /// phi'(u), continuous, to full precision.
    fn slope(&self, u: f64, epsilon: f64, parameters: &[f64]) -> f64;

    /// Slip speeds > 0, in growing order, at which phi'' jumps.
    fn corners(&self, _epsilon: f64, _parameters: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}

/// Reason why a custom law is not accepted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CustomLawError {
    /// The law has more parameters than a point can hold.
    #[error("the law {name} has {count} parameters, more than {MAX_LAW_PARAMETERS}")]
    TooManyParameters {
        /// Name of the law.
        name: &'static str,
        /// Number of its parameters.
        count: usize,
    },
    /// The name belongs to another axis or law.
    #[error("the name {0} is taken")]
    NameTaken(String),
}

/// A law given by functions. Clones share it.
#[derive(Clone, Debug)]
pub struct Custom(Arc<dyn CustomLaw>);

impl PartialEq for Custom {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Custom {
    pub(super) fn new(law: impl CustomLaw) -> Result<Self, CustomLawError> {
        let (name, parameters) = (law.name(), law.parameters());
        if Law::names().any(|known| known == name) {
            return Err(CustomLawError::NameTaken(name.into()));
        }
        if parameters.len() > MAX_LAW_PARAMETERS {
            return Err(CustomLawError::TooManyParameters { name, count: parameters.len() });
        }
        for (i, parameter) in parameters.iter().enumerate() {
            let mut before = parameters[..i].iter().map(|known| known.name).chain(["epsilon", "V", "c"]);
            if before.any(|known| known == parameter.name) {
                return Err(CustomLawError::NameTaken(parameter.name.into()));
            }
        }
        Ok(Self(Arc::new(law)))
    }

    pub(super) fn name(&self) -> &'static str {
        self.0.name()
    }

    pub(super) fn parameters(&self) -> &[Parameter] {
        self.0.parameters()
    }

    pub(super) fn curve(&self, epsilon: f64, parameters: &LawParameters) -> CustomCurve {
        let corners = self.0.corners(epsilon, parameters.as_slice()).into();
        CustomCurve { law: self.clone(), epsilon, parameters: *parameters, corners }
    }
}

/// A custom law with all its parameters fixed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CustomCurve {
    law: Custom,
    epsilon: f64,
    parameters: LawParameters,
    corners: Arc<[f64]>,
}

impl CustomCurve {
    pub(super) fn phi(&self, u: f64) -> f64 {
        self.law.0.phi(u, self.epsilon, self.parameters.as_slice())
    }

    pub(super) fn weakening(&self, u: f64) -> f64 {
        -self.law.0.slope(u, self.epsilon, self.parameters.as_slice())
    }

    /// Derivatives of the weakening rate by central differences, with the step (relative to the parameter) at
    /// which truncation and rounding errors are about equal.
    pub(super) fn gradient(&self, u: f64) -> Gradient {
        let parameters = self.parameters.as_slice();
        let slope = |epsilon: f64, parameters: &[f64]| -self.law.0.slope(u, epsilon, parameters);
        let by = |x: f64, f: &dyn Fn(f64) -> f64| {
            let step = f64::EPSILON.cbrt() * if x == 0.0 { 1.0 } else { x.abs() };
            (f(x + step) - f(x - step)) / (2.0 * step)
        };
        let derivatives: Vec<f64> = (0..parameters.len())
            .map(|i| {
                by(parameters[i], &|x| {
                    let mut moved = parameters.to_vec();
                    moved[i] = x;
                    slope(self.epsilon, &moved)
                })
            })
            .collect();
        Gradient {
            epsilon: by(self.epsilon, &|x| slope(x, parameters)),
            parameters: LawParameters::new(&derivatives),
        }
    }

    pub(super) fn corners(&self) -> &[f64] {
        &self.corners
    }
}
