//! The closed forms of the laws with all parameters fixed, one variant for each kind of law.

use super::built_in::ClosedForm;
use super::custom::CustomCurve;
use super::{Coulomb, Exponential, ExpressionCurve, Function, Lorentzian, Range, Stribeck, Table};
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real};

/// The kinds of curves, each with its own closed forms.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Form {
    Stribeck(Stribeck),
    Exponential(Exponential),
    Lorentzian(Lorentzian),
    Coulomb(Coulomb),
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
            Form::Coulomb(law) => Some(law),
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
            Form::Coulomb(law) => Some(law.weakening_range(lo, hi)),
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
            Form::Coulomb(law) => law.phi(u),
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
            Form::Coulomb(law) => law.weakening(u),
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
            Form::Coulomb(law) => Some(law.formula(u)),
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
            Form::Exponential(law) => Some(law.series(u, unit)),
            law => law.formula(Jet::<Interval, N>::variable(u, unit)),
        }
    }

    /// The unit of the slip speed of a formula, where that is not the one of the formula as it was written; and the form of
    /// that formula.
    pub(super) fn unit(&self) -> Option<(f64, Self)> {
        match self {
            Form::Expression(law) => law.unit().map(|(unit, law)| (unit, Form::Expression(law))),
            _ => None,
        }
    }

    /// The friction at rest less that in slip as u -> 0.
    pub(super) fn drop(&self) -> f64 {
        match self {
            Form::Coulomb(law) => law.drop(),
            Form::Expression(law) => law.drop(),
            Form::Table(law) => law.drop(),
            _ => 0.0,
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
