//! The built-in laws as their files define them, and the kinds of curves: one variant for each kind of law
//! with all parameters fixed.

use super::custom::CustomCurve;
use super::family::Series;
use super::interval::Interval;
use super::jet::{Jet, Real};
use super::{
    Exponential, ExpressionCurve, FirstOrder, Function, Gradient, Lorentzian, Parameter, Range, Stribeck,
    Table,
};
use crate::point::LawParameters;

/// A built-in law, defined in its own file.
pub(crate) struct BuiltIn {
    /// Name in configurations.
    pub(super) name: &'static str,
    /// phi(u) as text.
    #[cfg_attr(not(feature = "explore"), allow(dead_code))]
    pub(crate) formula: &'static str,
    /// Its parameters, in the order in which they become axes of a map.
    pub(super) parameters: &'static [Parameter],
    /// Returns whether phi(u) depends on eps.
    pub(super) depends_on_epsilon: bool,
    /// The curve at one eps and one choice of the parameters.
    pub(super) curve: fn(f64, &LawParameters) -> Form,
    /// phi at slip speed u, eps and parameters, enclosed with its derivatives; `None` if the number of
    /// parameters is not the law's.
    pub(super) phi_at: fn(u: Series, epsilon: Series, parameters: &[Series]) -> Option<Series>,
    /// How friction rises at high slip speed.
    pub(crate) strengthening: Strengthening,
    /// The parameters of a machine's friction, for slip speeds in units of `velocity`, in m/s.
    pub(crate) parameters_of: fn(friction: &Fall, velocity: f64) -> [f64; 3],
}

/// How the friction of a built-in law rises at high slip speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Strengthening {
    /// In proportion to the slip speed, as viscous damping does.
    Linear,
    /// In proportion to its square.
    Quadratic,
}

/// Friction in units of that at rest, as a machine has it: it falls, and rises at high slip speed.
pub(crate) struct Fall {
    /// Kinetic friction.
    pub(crate) kinetic: f64,
    /// Slip speed over which friction falls, m/s.
    pub(crate) width: f64,
    /// Strengthening at high slip speed, per m/s or per (m/s)^2, see [`BuiltIn::strengthening`].
    pub(crate) strengthening: f64,
}

/// A built-in law with all parameters fixed.
pub(super) trait ClosedForm {
    /// Returns whether no coefficient of the law is a product below the normal numbers, where it may be wrong
    /// by any factor.
    fn is_normal(&self) -> bool;

    /// Derivatives of the weakening rate.
    fn gradient(&self, u: f64) -> Gradient;

    /// See [`super::Curve::mean_weakening`].
    fn mean_weakening(&self, belt_speed: f64) -> f64;

    /// Cost of one evaluation in units of the cost of the Stribeck law.
    fn cost(&self) -> u64 {
        1
    }

    /// See [`super::Curve::weakening_is_convex`].
    fn weakening_is_convex(&self) -> bool {
        false
    }

    /// Bounds of phi on [0, hi]; `None` if they come from the formula in interval arithmetic.
    fn friction_range(&self, _hi: f64) -> Option<Range> {
        None
    }

    /// See [`super::Curve::even_weakening_range`]; `None` if the bounds come from the compiled law.
    fn even_weakening_range(&self, _belt_speed: f64) -> Option<Range> {
        None
    }

    /// The first order in eps; `None` for a law that does not depend on eps.
    fn first_order(&self, _belt_speed: f64) -> Option<FirstOrder> {
        None
    }
}

/// The kinds of curves, each with its own closed forms.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Form {
    Stribeck(Stribeck),
    Exponential(Exponential),
    Lorentzian(Lorentzian),
    Expression(ExpressionCurve),
    /// F1, the first order in eps of a formula, in place of phi.
    Leading(ExpressionCurve),
    Table(Table),
    Function(Function),
    Custom(CustomCurve),
}

impl Form {
    /// The closed form of a built-in law; `None` for other laws.
    pub(super) fn closed(&self) -> Option<&dyn ClosedForm> {
        match self {
            Form::Stribeck(law) => Some(law),
            Form::Exponential(law) => Some(law),
            Form::Lorentzian(law) => Some(law),
            Form::Expression(_) | Form::Leading(_) | Form::Table(_) | Form::Function(_) | Form::Custom(_) => {
                None
            }
        }
    }

    /// Proved bounds of the weakening rate of a built-in law; `None` for other laws.
    #[inline]
    pub(super) fn weakening_range(&self, lo: f64, hi: f64) -> Option<Range> {
        match self {
            Form::Stribeck(law) => Some(law.weakening_range(lo, hi)),
            Form::Exponential(law) => Some(law.weakening_range(lo, hi)),
            Form::Lorentzian(law) => Some(law.weakening_range(lo, hi)),
            Form::Expression(_) | Form::Leading(_) | Form::Table(_) | Form::Function(_) | Form::Custom(_) => {
                None
            }
        }
    }

    pub(super) fn phi(&self, u: f64) -> f64 {
        match self {
            Form::Stribeck(law) => law.phi(u),
            Form::Exponential(law) => law.phi(u),
            Form::Lorentzian(law) => law.phi(u),
            Form::Expression(law) => law.phi(u),
            Form::Leading(law) => law.leading(u),
            Form::Table(law) => law.phi(u),
            Form::Function(law) => law.phi(u),
            Form::Custom(law) => law.phi(u),
        }
    }

    #[inline]
    pub(super) fn weakening(&self, u: f64) -> f64 {
        match self {
            Form::Stribeck(law) => law.weakening(u),
            Form::Exponential(law) => law.weakening(u),
            Form::Lorentzian(law) => law.weakening(u),
            Form::Expression(law) => law.weakening(u),
            Form::Leading(law) => -law.leading(Jet::<f64, 2>::variable(u, 1.0)).0[1],
            Form::Table(law) => law.weakening(u),
            Form::Function(law) => law.weakening(u),
            Form::Custom(law) => law.weakening(u),
        }
    }

    /// The weakening rate at several slip speeds >= 0.
    pub(super) fn weakenings<const N: usize>(&self, u: [f64; N]) -> [f64; N] {
        match self {
            Form::Expression(law) => law.weakenings(u),
            law => u.map(|u| law.weakening(u)),
        }
    }

    /// phi in any arithmetic (numbers, intervals or series); `None` for laws given by data or functions.
    pub(super) fn formula<T: Real>(&self, u: T) -> Option<T> {
        match self {
            Form::Stribeck(law) => Some(law.formula(u)),
            Form::Exponential(law) => Some(law.formula(u)),
            Form::Lorentzian(law) => Some(law.formula(u)),
            Form::Expression(law) => Some(law.formula(u)),
            Form::Leading(law) => Some(law.leading(u)),
            Form::Table(_) | Form::Function(_) | Form::Custom(_) => None,
        }
    }

    /// Enclosures of the Taylor coefficients of phi at all slip speeds in `u`, in powers of the slip speed
    /// divided by `unit`.
    pub(super) fn series<const N: usize>(&self, u: Interval, unit: f64) -> Option<Jet<Interval, N>> {
        match self {
            Form::Function(law) => law.series(u, unit),
            law => law.formula(Jet::<Interval, N>::variable(u, unit)),
        }
    }

    pub(super) fn corners(&self) -> &[f64] {
        match self {
            Form::Table(law) => law.corners(),
            Form::Function(law) => law.corners(),
            Form::Custom(law) => law.corners(),
            _ => &[],
        }
    }

    /// Ends of the pieces on which the law is one smooth formula: its corners, and the ends of a function's
    /// polynomials.
    pub(super) fn seams(&self) -> &[f64] {
        match self {
            Form::Function(law) => law.seams(),
            law => law.corners(),
        }
    }
}
