//! The legal parameter points of a law.

use super::{Law, Parameter, exponential};
use crate::point::{LawParameters, MAX_LAW_PARAMETERS, Point};

/// The parameter eps of every law.
pub const EPSILON: Parameter = Parameter {
    name: "epsilon",
    long_name: "size of the small terms",
    min: f64::from_bits(1), // the smallest number above 0
    max: f64::INFINITY,
};
/// The belt speed V of every law.
pub const BELT_SPEED: Parameter = Parameter { name: "V", long_name: "belt speed", ..EPSILON };
/// The damping c of every law.
pub const DAMPING: Parameter =
    Parameter { name: "c", long_name: "viscous damping", min: 0.0, max: f64::INFINITY };

impl Parameter {
    /// Returns whether the value is finite and within the legal range.
    pub fn admits(&self, value: f64) -> bool {
        value.is_finite() && (self.min..=self.max).contains(&value)
    }

    fn check(&self, value: f64) -> Result<(), PointError> {
        if self.admits(value) {
            return Ok(());
        }
        let domain = if value.is_finite() { self.domain() } else { "finite".into() };
        Err(PointError::OutOfDomain { name: self.name, value, domain })
    }

    /// The legal values in words, for messages that end with "it must be ...".
    pub fn domain(&self) -> String {
        if 0.0 < self.min && self.min <= f64::MIN_POSITIVE && self.max == f64::INFINITY {
            "greater than 0".into()
        } else if self.min == f64::MIN {
            "finite".into()
        } else if self.max.is_finite() {
            // Why not below 1, and what to write.
            let why = if *self == exponential::EXPONENT {
                ": friction that falls steeper at rest is a drop"
            } else {
                ""
            };
            format!("between {} and {}{why}", self.min, self.max)
        } else {
            format!("at least {}", self.min)
        }
    }
}

/// Reason why a parameter point is not legal for a law.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PointError {
    /// The number of values given differs from the law's number of parameters.
    #[error("the law {law} has {wanted} parameters of its own, and {given} are given")]
    ParameterCount {
        /// Name of the law.
        law: &'static str,
        /// Its number of parameters.
        wanted: usize,
        /// Number of parameters given.
        given: usize,
    },
    /// A value is NaN, infinite, or outside the legal domain.
    #[error("{name} is {value:?}; it must be {domain}")]
    OutOfDomain {
        /// Name of the quantity, as in configurations.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The legal values, in words.
        domain: String,
    },
}

impl Law {
    /// The parameters of a point of this law: eps, those of its own, V, c.
    pub fn coordinate_parameters(&self) -> impl Iterator<Item = &Parameter> {
        std::iter::once(&EPSILON).chain(self.parameters()).chain([&BELT_SPEED, &DAMPING])
    }

    /// Their names: those of the axes of a map of this law, slowest dimension first.
    #[must_use]
    pub fn axis_names(&self) -> Vec<&'static str> {
        self.coordinate_parameters().map(|parameter| parameter.name).collect()
    }

    /// The name of each coordinate of a point and its value, in the order of [`Law::axis_names`].
    #[must_use]
    pub fn coordinates(&self, point: &Point) -> Vec<(&'static str, f64)> {
        let own = point.law.as_slice().iter().copied();
        let values = std::iter::once(point.epsilon).chain(own).chain([point.belt_speed, point.damping]);
        self.axis_names().into_iter().zip(values).collect()
    }

    /// Returns whether all points of a box of eps, the law's parameters and V are legal for the law.
    pub fn admits_box(&self, ranges: &[[f64; 2]]) -> bool {
        let known = std::iter::once(&EPSILON).chain(self.parameters()).chain([&BELT_SPEED]);
        ranges.len() == self.parameters().len() + 2
            && known.zip(ranges).all(|(known, [lo, hi])| lo <= hi && known.admits(*lo) && known.admits(*hi))
    }

    /// The point of this law with the given eps, the law's own parameters (in the order of
    /// [`Law::parameters`]), belt speed V and damping c, if it is legal.
    ///
    /// # Errors
    /// [`PointError`].
    pub fn point(
        &self,
        epsilon: f64,
        parameters: &[f64],
        belt_speed: f64,
        damping: f64,
    ) -> Result<Point, PointError> {
        self.check_count(parameters.len())?;
        let point = Point { epsilon, law: LawParameters::new(parameters), belt_speed, damping };
        self.check(&point)?;
        Ok(point)
    }

    /// Checks that `point` is a legal point of this law.
    ///
    /// # Errors
    /// The first [`PointError`], in the order of a map's axes.
    pub fn check(&self, point: &Point) -> Result<(), PointError> {
        self.check_count(point.law.as_slice().len())?;
        let own = self.parameters().iter().zip(point.law.as_slice().iter().copied());
        let all = std::iter::once((&EPSILON, point.epsilon))
            .chain(own)
            .chain([(&BELT_SPEED, point.belt_speed), (&DAMPING, point.damping)]);
        for (parameter, value) in all {
            parameter.check(value)?;
        }
        Ok(())
    }

    fn check_count(&self, given: usize) -> Result<(), PointError> {
        let wanted = self.parameters().len();
        if wanted == given && given <= MAX_LAW_PARAMETERS {
            return Ok(());
        }
        Err(PointError::ParameterCount { law: self.name(), wanted, given })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn illegal_points_are_refused_by_name() {
        let refused = |epsilon, law: &[f64], belt_speed, damping| {
            Law::Stribeck.point(epsilon, law, belt_speed, damping).unwrap_err().to_string()
        };
        let law = [0.4, 0.2, 2.0];
        assert_eq!(refused(f64::NAN, &law, 1.0, 0.0), "epsilon is NaN; it must be finite");
        assert_eq!(refused(0.1, &[3.0, 0.2, 2.0], 1.0, 0.0), "alpha is 3.0; it must be between 0 and 1");
        assert_eq!(refused(0.1, &law, 0.0, 0.0), "V is 0.0; it must be greater than 0");
        assert_eq!(refused(0.1, &law, f64::INFINITY, 0.0), "V is inf; it must be finite");
        assert_eq!(refused(0.1, &law, 1.0, -1.0), "c is -1.0; it must be at least 0");
        assert_eq!(
            refused(0.1, &[0.4], 1.0, 0.0),
            "the law stribeck has 3 parameters of its own, and 1 are given"
        );
        assert!(refused(0.1, &[0.0; 12], 1.0, 0.0).contains("12 are given"));
        // The smallest positive number is legal.
        let point = Law::Stribeck.point(5e-324, &law, 5e-324, 0.0).unwrap();
        assert_eq!((point.epsilon, point.law.as_slice()), (5e-324, &law[..]));
    }

    #[test]
    #[should_panic(expected = "V is -1.0; it must be greater than 0")]
    fn no_column_is_made_of_an_illegal_point() {
        let law = LawParameters::new(&[0.4, 0.2, 2.0]);
        let _ = Law::Stribeck.column(&Point { epsilon: 0.1, law, belt_speed: -1.0, damping: 0.0 });
    }
}
