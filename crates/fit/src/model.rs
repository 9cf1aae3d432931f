//! The laws that are fitted.

use nalgebra::DVector;

/// How friction falls: g(x) with x = u / v_s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// It does not: friction in slip is F_k + B u.
    None,
    /// exp(-x), as in the law `exponential`.
    Exponential,
    /// exp(-x^2).
    Gaussian,
    /// exp(-x^delta).
    Stretched,
    /// 1 / (1 + x^2), as in the law `lorentzian`.
    Lorentzian,
    /// 1 / (1 + x), as in the law `stribeck`.
    Hyperbolic,
}

/// A law with free parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Form {
    /// How friction falls.
    pub shape: Shape,
    /// Whether it rises in proportion to the slip speed: B is fitted.
    pub viscous: bool,
    /// Whether it drops as slip begins: friction at rest may be above that at the onset of slip.
    pub drop: bool,
}

/// Parameters in which the fit is made: those of the law, with the logarithm of v_s.
pub(crate) type Point = DVector<f64>;

/// Position of v_s, after F_o and F_k; delta follows it, and B is the last.
pub(crate) const FALL: usize = 2;

impl Form {
    /// All laws.
    pub fn all() -> impl Iterator<Item = Form> {
        use Shape::{Exponential, Gaussian, Hyperbolic, Lorentzian, None, Stretched};
        let shapes = [None, Exponential, Gaussian, Stretched, Lorentzian, Hyperbolic];
        shapes.into_iter().flat_map(move |shape| {
            [false, true].into_iter().flat_map(move |viscous| {
                [false, true].into_iter().map(move |drop| Form { shape, viscous, drop })
            })
        })
    }

    /// Whether friction falls, or drops as slip begins: else it excites nothing, but for a viscous part below 0.
    pub fn falls(self) -> bool {
        self.shape != Shape::None || self.drop
    }

    /// The names of the parameters: friction at the onset of slip and far out, the speed of the fall, its exponent,
    /// and the viscous part.
    pub fn names(self) -> Vec<&'static str> {
        let mut names = match self.shape {
            Shape::None => vec!["F_k"],
            Shape::Stretched => vec!["F_s", "F_k", "v_s", "delta"],
            _ => vec!["F_s", "F_k", "v_s"],
        };
        if self.viscous {
            names.push("B");
        }
        names
    }

    /// The law as a formula in the slip speed u.
    pub fn formula(self) -> String {
        let fall = match self.shape {
            Shape::None => "",
            Shape::Exponential => " + (F_s - F_k)*exp(-u/v_s)",
            Shape::Gaussian => " + (F_s - F_k)*exp(-(u/v_s)^2)",
            Shape::Stretched => " + (F_s - F_k)*exp(-(u/v_s)^delta)",
            Shape::Lorentzian => " + (F_s - F_k)/(1 + (u/v_s)^2)",
            Shape::Hyperbolic => " + (F_s - F_k)/(1 + u/v_s)",
        };
        let rise = if self.viscous { " + B*u" } else { "" };
        format!("F_k{fall}{rise}")
    }

    /// g, and its derivatives by the logarithm of v_s and by delta.
    fn fall(self, x: f64, delta: f64) -> [f64; 3] {
        match self.shape {
            Shape::None => [0.0; 3],
            Shape::Exponential => [(-x).exp(), x * (-x).exp(), 0.0],
            Shape::Gaussian => [(-x * x).exp(), 2.0 * x * x * (-x * x).exp(), 0.0],
            Shape::Stretched => {
                let power = x.powf(delta);
                let value = (-power).exp();
                let by_delta = if x > 0.0 { -power * x.ln() * value } else { 0.0 };
                [value, delta * power * value, by_delta]
            }
            Shape::Lorentzian => {
                let value = 1.0 / (1.0 + x * x);
                [value, 2.0 * x * x * value * value, 0.0]
            }
            Shape::Hyperbolic => {
                let value = 1.0 / (1.0 + x);
                [value, x * value * value, 0.0]
            }
        }
    }

    /// A point of parameters with a fall over this speed; friction is a sum of all others but delta, each times its derivative.
    pub(crate) fn with_fall(self, log: f64) -> Point {
        let mut point = DVector::zeros(self.names().len());
        if self.shape != Shape::None {
            point[FALL] = log;
        }
        if self.shape == Shape::Stretched {
            point[FALL + 1] = START_DELTA;
        }
        point
    }

    /// The values of the parameters at a point.
    pub(crate) fn values(self, point: &Point) -> Vec<f64> {
        let mut values: Vec<f64> = point.iter().copied().collect();
        if self.shape != Shape::None {
            values[FALL] = values[FALL].exp();
        }
        values
    }

    /// The friction at a slip speed.
    pub fn friction(self, values: &[f64], speed: f64) -> f64 {
        let rise = if self.viscous { values[values.len() - 1] * speed } else { 0.0 };
        match self.shape {
            Shape::None => values[0] + rise,
            _ => {
                let [fall, ..] = self.fall(speed / values[FALL], self.delta(values));
                values[1] + (values[0] - values[1]) * fall + rise
            }
        }
    }

    fn delta(self, values: &[f64]) -> f64 {
        if self.shape == Shape::Stretched { values[FALL + 1] } else { 1.0 }
    }

    /// The derivatives of the friction by the parameters.
    pub(crate) fn gradient(self, values: &[f64], speed: f64) -> Vec<f64> {
        let mut gradient = match self.shape {
            Shape::None => vec![1.0],
            shape => {
                let [fall, by_log, by_delta] = self.fall(speed / values[FALL], self.delta(values));
                let height = values[0] - values[1];
                let mut of = vec![fall, 1.0 - fall, height * by_log / values[FALL]];
                if shape == Shape::Stretched {
                    of.push(height * by_delta);
                }
                of
            }
        };
        if self.viscous {
            gradient.push(speed);
        }
        gradient
    }

    /// Whether the values are those of a friction law.
    pub(crate) fn is_legal(self, values: &[f64]) -> bool {
        let falls = self.shape == Shape::None
            || values[0] > values[1] && values[1] >= 0.0 && values[FALL] > 0.0 && self.delta(values) >= 1.0;
        values[0] > 0.0 && falls && values.iter().all(|value| value.is_finite())
    }
}

/// The exponent at which a fit begins.
const START_DELTA: f64 = 1.3;
