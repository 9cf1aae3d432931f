//! Friction laws: the force phi(u) at slip speed u > 0 in units of the static force, that at rest. Friction in
//! slip may begin below 1: phi(u) tends to 1 - j as u -> 0, where j >= 0 is the [drop](Curve::drop).
//!
//! A [`Law`] is a family with named parameters, each of which becomes an axis of a map. Fixing eps and the
//! parameters gives a [`Curve`], a function of the slip speed. All other modules use only the values and the
//! proved bounds of a curve, and do not depend on which parameters the law has.

mod built_in;
mod column;
mod coulomb;
mod curve;
mod custom;
pub mod domain;
mod exponential;
mod expression;
mod family;
mod function;
mod lorentzian;
mod mean;
mod peak;
mod stribeck;
mod table;
mod weakening;

pub use built_in::{BuiltIn, Fall, Strengthening};
pub use column::Column;
pub use coulomb::Coulomb;
pub use curve::{Curve, NOT_NEGATIVE, Pieces, Ranges};
pub use custom::{Custom, CustomLaw, CustomLawError};
pub use domain::PointError;
pub use exponential::{Exponential, ExponentialFall};
pub use expression::ExpressionCurve;
pub use expression::{Expression, ExpressionError, Op};
pub use family::{Series, Slope, TERMS};
pub use function::{Function, FunctionError};
pub use lorentzian::Lorentzian;
pub use slipmap_numbers::Range;
pub use stribeck::Stribeck;
pub use table::{Source, Table, TableError};
pub use weakening::{Accuracy, Weakening};
pub use weakening::{COUNT, Polynomial, ProvedPiece};

use std::cell::RefCell;
use std::sync::Arc;

use crate::point::{LawParameters, MAX_LAW_PARAMETERS, Point};
use built_in::ClosedForm;
use custom::CustomCurve;
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real};

/// What a law that vanishes at rest means, and what to write, in words.
const NO_REST: &str = "friction vanishes at rest: the mass never sticks, and the rise of a smoothed law is a viscous \
                                  contact";
const REST_AT_PEAK: &str = "write rest = \"peak\" (or --rest peak) for the law beyond its first peak, with the peak as \
                                       friction at rest; or write the law without its smoothing";

/// The quantities of a law phi = 1 + eps F1(u) + O(eps^2) that the first-order theory (eps -> 0) needs.
///
/// Slopes are divided by eps, so that they can be compared with the damping c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstOrder {
    /// `1/(pi V) * integral over a turn of F1(V - V cos t) cos t dt`, the right side of the paper's
    /// condition (6) divided by pi V.
    pub mean_weakening: f64,
    /// How far that may be from the law's, rounding apart.
    pub mean_error: f64,
    /// Range of -F1'(u) over slip speeds u in [0, 2 V].
    pub weakening_range: Range,
}

/// Derivatives of the weakening rate at one slip speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient {
    /// With respect to eps.
    pub epsilon: f64,
    /// With respect to each parameter of the law.
    pub parameters: LawParameters,
}

/// Reason why a law has no first order in eps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoFirstOrder {
    /// Friction drops as slip begins.
    #[error("friction drops as slip begins, by more than a small eps does")]
    Drop,
    /// The law does not depend on eps.
    #[error("the friction law does not depend on eps")]
    NoEpsilon,
    /// phi is not 1 at eps = 0.
    #[error("the friction law is not constant at eps = 0")]
    NotSmall,
    /// phi has no derivative with respect to eps at eps = 0.
    #[error("the friction law has no derivative by eps at eps = 0")]
    NotDifferentiable,
}

/// A parameter of a friction law, as it appears in a configuration and as an axis of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name in configurations, command lines and map files.
    pub name: &'static str,
    /// One phrase for a figure's axis or a file's `long_name`.
    pub long_name: &'static str,
    /// Smallest legal value (included).
    pub min: f64,
    /// Largest legal value (included); infinite where the law has no upper limit.
    pub max: f64,
}

/// A family of friction laws.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// The paper's law, `(1 - alpha) / (1 + eps gamma u) + alpha + eps beta u^2`.
    Stribeck,
    /// `mu + (1 - mu) exp(-u / vs) + eta u`.
    Exponential,
    /// The exponential law with the parameter `exponent`, `mu + (1 - mu) exp(-(u / vs)^exponent) + eta u`, see
    /// [`Law::with_exponent`].
    Stretched,
    /// `mu + (1 - mu) / (1 + (u / vs)^2) + eta u`.
    Lorentzian,
    /// `1 - drop + eta u`: two coefficients, static and kinetic.
    Coulomb,
    /// A law given as text.
    Expression(Expression),
    /// A law given by data.
    Table(Table),
    /// A law given as a function of a program, which is sampled once.
    Function(Function),
    /// A law implemented by a Rust program, see [`Law::custom`].
    Custom(Custom),
    /// A law read as `1 + eps F(u)`, see [`Law::read_as_small`].
    Small(Arc<Law>),
    /// A law with the parameter `drop` besides its own, see [`Law::with_drop`].
    Dropping(Arc<Dropping>),
}

/// A law whose friction in slip is less by the parameter `drop`, the last one.
#[derive(Debug, PartialEq)]
pub struct Dropping {
    law: Law,
    parameters: Vec<Parameter>,
}

/// The drop of a law: friction at rest less friction at the onset of slip.
const DROP: Parameter = Parameter {
    name: "drop",
    long_name: "drop of friction as slip begins",
    min: 0.0,
    max: 1.0 - f64::EPSILON,
};

/// First line of the definition of a law read as `1 + eps F(u)`.
const SMALL: &str = "small eps";
/// First line of the definition of a law with the parameter `drop`.
const DROPPING: &str = "drop";
/// Definition of the exponential law with the parameter `exponent`.
const STRETCHED: &str = "exponent";
/// Name of the laws given as text.
const EXPRESSION: &str = "expression";
/// Name of the laws given by data.
const TABLE: &str = "table";
/// Follows the friction at rest, in the definition of a law whose friction in slip may begin below it.
const ABOVE: &str = " above:";
const ABOVE_WORD: &str = "above: ";

fn above(may_drop: bool) -> &'static str {
    if may_drop { ABOVE } else { "" }
}

/// Name of the laws given as functions, which no configuration can name.
const FUNCTION: &str = "function";

impl Law {
    /// The laws that a name alone defines, in the order in which messages list them.
    pub const BUILT_IN: [Law; 4] = [Law::Stribeck, Law::Exponential, Law::Lorentzian, Law::Coulomb];

    /// The names of laws that a configuration can choose.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Self::BUILT_IN.iter().map(Law::name).chain([EXPRESSION, TABLE])
    }

    /// The law's name in a configuration.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Law::Expression(_) => EXPRESSION,
            Law::Table(_) => TABLE,
            Law::Custom(law) => law.name(),
            Law::Small(law) => law.name(),
            Law::Dropping(dropping) => dropping.law.name(),
            law => law.built_in().map_or(FUNCTION, |law| law.name),
        }
    }

    /// What the file of a built-in law defines; `None` for other laws.
    pub fn built_in(&self) -> Option<&'static BuiltIn> {
        Some(match self {
            Law::Stribeck => &stribeck::LAW,
            Law::Exponential => &exponential::LAW,
            Law::Stretched => &exponential::STRETCHED,
            Law::Lorentzian => &lorentzian::LAW,
            Law::Coulomb => &coulomb::LAW,
            Law::Small(law) => return law.built_in(),
            Law::Dropping(dropping) => return dropping.law.built_in(),
            Law::Expression(_) | Law::Table(_) | Law::Function(_) | Law::Custom(_) => return None,
        })
    }

    /// A law given by functions.
    ///
    /// # Errors
    /// [`CustomLawError`].
    pub fn custom(law: impl CustomLaw) -> Result<Law, CustomLawError> {
        Custom::new(law).map(Law::Custom)
    }

    /// The same law, read as `1 + eps F(u)` with `F = (phi - 1) / eps` at the given eps. So the paper's test
    /// (6), which takes a law to first order in eps, applies to every law. Nothing else changes.
    #[must_use]
    pub fn read_as_small(self) -> Law {
        match self {
            Law::Small(_) => self,
            law => Law::Small(Arc::new(law)),
        }
    }

    /// The exponential law with the parameter `exponent` after its own, for [`Law::with_drop`] to add to; other
    /// laws as they are.
    #[must_use]
    pub fn with_exponent(self) -> Law {
        match self {
            Law::Exponential => Law::Stretched,
            Law::Small(law) => Law::Small(Arc::new(law.as_ref().clone().with_exponent())),
            law => law,
        }
    }

    /// The law with the parameter `drop` after its own: friction in slip is less by it, and friction at rest
    /// is not. A law that has that parameter stays as it is.
    ///
    /// # Panics
    /// If the law has [`MAX_LAW_PARAMETERS`] already.
    #[must_use]
    pub fn with_drop(self) -> Law {
        if self.parameters().iter().any(|parameter| parameter.name == DROP.name) {
            return self;
        }
        match self {
            Law::Small(law) => Law::Small(Arc::new(law.as_ref().clone().with_drop())),
            law => {
                assert!(law.parameters().len() < MAX_LAW_PARAMETERS, "the law has no room for a drop");
                let parameters = law.parameters().iter().copied().chain([DROP]).collect();
                Law::Dropping(Arc::new(Dropping { law, parameters }))
            }
        }
    }

    /// Returns whether friction may drop as slip begins, at some point of the law.
    #[must_use]
    pub fn may_drop(&self) -> bool {
        self.parameters().iter().any(|parameter| parameter.name == DROP.name)
            || match self.as_written() {
                Law::Expression(law) => law.may_drop(),
                Law::Table(law) => law.may_drop(),
                _ => false,
            }
    }

    /// Returns whether the law is read as `1 + eps F(u)`.
    #[must_use]
    pub fn is_read_as_small(&self) -> bool {
        matches!(self, Law::Small(_))
    }

    /// The law itself, without the reading as `1 + eps F(u)` and without the parameter of [`Law::with_drop`].
    pub fn as_written(&self) -> &Law {
        match self {
            Law::Small(law) => law.as_written(),
            Law::Dropping(dropping) => &dropping.law,
            law => law,
        }
    }

    /// The law's own parameters, in the order in which they become axes of a map, slowest first.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        match self {
            Law::Small(law) => law.parameters(),
            Law::Dropping(dropping) => &dropping.parameters,
            Law::Expression(law) => law.parameters(),
            Law::Custom(law) => law.parameters(),
            law => law.built_in().map_or(&[], |law| law.parameters),
        }
    }

    /// The data that [`Law::from_definition`] needs, besides the name, to restore the law; empty for laws that
    /// a name alone defines and for custom laws.
    #[must_use]
    pub fn definition(&self) -> String {
        match self {
            Law::Small(law) => format!("{SMALL}\n{}", law.definition()),
            Law::Dropping(dropping) => format!("{DROPPING}\n{}", dropping.law.definition()),
            Law::Stretched => STRETCHED.to_owned(),
            Law::Expression(law) => {
                format!("{}{}\n{}", law.static_level(), above(law.may_drop()), law.text())
            }
            Law::Table(table) => {
                let head = format!("{}{} {}", table.static_level(), above(table.may_drop()), table.origin());
                let known = table.known();
                let lines = std::iter::once(head).chain(table.rows()).chain(known);
                lines.collect::<Vec<_>>().join("\n")
            }
            Law::Function(law) => law.definition(),
            _ => String::new(),
        }
    }

    /// The law of this name and definition; `None` if there is none, or if its definition is another text.
    #[must_use]
    pub fn from_definition(name: &str, definition: &str) -> Option<Law> {
        // At most once: nothing is written twice, and what is read may be forged.
        let law = match definition.split_once('\n') {
            Some((SMALL, definition)) => Self::dropping_of(name, definition)?.read_as_small(),
            _ => Self::dropping_of(name, definition)?,
        };
        (law.definition() == definition).then_some(law)
    }

    /// The law of this name and definition, with or without the parameter `drop`.
    fn dropping_of(name: &str, definition: &str) -> Option<Law> {
        match definition.split_once('\n') {
            Some((DROPPING, definition)) => {
                let law = Self::as_written_of(name, definition)?;
                (law.parameters().len() < MAX_LAW_PARAMETERS).then(|| law.with_drop())
            }
            _ => Self::as_written_of(name, definition),
        }
    }

    /// The law of this name and definition, without the reading as `1 + eps F(u)` and without a parameter `drop`.
    fn as_written_of(name: &str, definition: &str) -> Option<Law> {
        if let Some(law) = Self::BUILT_IN.into_iter().find(|law| law.name() == name) {
            return Some(if definition == STRETCHED { law.with_exponent() } else { law });
        }
        let (head, rest) = definition.split_once('\n')?;
        match name {
            FUNCTION => Function::from_definition(definition).map(Law::Function),
            EXPRESSION => {
                let formula = match head.strip_suffix(ABOVE) {
                    Some(level) => Expression::with_static(rest, level.parse().ok()?),
                    None => Expression::new(rest, head.parse().ok()?),
                };
                Some(Law::Expression(formula.ok()?))
            }
            TABLE => {
                let (mut data, mut errors) = (Vec::new(), Vec::new());
                let (rows, known) = match rest.rsplit_once('\n') {
                    Some((rows, known)) if known.starts_with('{') => (rows, Some(known)),
                    _ => (rest, None),
                };
                for line in rows.lines() {
                    let mut numbers = line.split(',').map(str::parse);
                    data.push((numbers.next()?.ok()?, numbers.next()?.ok()?));
                    errors.push(numbers.collect::<Result<Vec<f64>, _>>().ok()?);
                }
                // One number in each row is its own error; the rows of a triangle have one more each.
                let own: Vec<f64> = errors.iter().filter(|row| row.len() == 1).flatten().copied().collect();
                let (level, origin) = head.split_once(' ')?;
                let level = level.parse().ok()?;
                let table = match origin.strip_prefix(ABOVE_WORD) {
                    Some(origin) => Table::with_static(origin, &data, level).ok()?,
                    None => Table::new(origin, &data, level).ok()?,
                };
                let table = match own.len() {
                    0 => table,
                    1 => table.with_root_of_covariance(errors).ok()?,
                    _ => table.with_standard_errors(&own).ok()?,
                };
                Some(Law::Table(known.map_or(Some(table.clone()), |known| table.with_known(known))?))
            }
            _ => None,
        }
    }

    /// The friction curve at one eps and one choice of the law's parameters.
    ///
    /// Successive curves with the same eps and parameters share their compiled form, such as those of the
    /// columns of a map that differ only in the belt speed. If the law does not depend on eps, so do
    /// successive curves that differ only in eps; and curves of one formula in several units share that of the formula.
    #[must_use]
    pub fn curve(&self, epsilon: f64, parameters: &LawParameters) -> Curve {
        thread_local! {
            static LATEST: RefCell<Option<(Law, f64, LawParameters, Curve)>> = const { RefCell::new(None) };
        }
        LATEST.with_borrow_mut(|latest| {
            let alike = latest.as_ref().filter(|(law, _, known, _)| known == parameters && law == self);
            if let Some((.., curve)) = alike.filter(|(_, eps, ..)| *eps == epsilon) {
                return curve.clone();
            }
            let small = self.is_read_as_small().then_some(epsilon);
            let (form, axis) = self.form(epsilon, parameters);
            let compiled = match (alike, latest.as_ref()) {
                (Some((.., curve)), _) if !self.depends_on_epsilon() => Arc::clone(&curve.compiled),
                (_, Some((.., curve))) => curve.shared(&form),
                (_, None) => Arc::default(),
            };
            let curve = Curve::new(form, small, axis, compiled);
            *latest = Some((self.clone(), epsilon, *parameters, curve.clone()));
            curve
        })
    }

    /// Returns whether phi(u) may depend on eps.
    pub fn depends_on_epsilon(&self) -> bool {
        match self.as_written() {
            Law::Expression(law) => law.depends_on_epsilon(),
            Law::Custom(_) => true,
            law => law.built_in().is_some_and(|law| law.depends_on_epsilon),
        }
    }

    /// The closed form, and the value of the parameter of [`Law::with_drop`].
    fn form(&self, epsilon: f64, parameters: &LawParameters) -> (Form, Option<f64>) {
        let form = match self {
            Law::Stribeck => Form::Stribeck(Stribeck::new(epsilon, parameters)),
            Law::Exponential | Law::Stretched => Form::Exponential(Exponential::new(parameters)),
            Law::Lorentzian => Form::Lorentzian(Lorentzian::new(parameters)),
            Law::Expression(law) => Form::Expression(law.curve(epsilon, parameters)),
            Law::Table(table) => Form::Table(table.clone()),
            Law::Function(law) => Form::Function(law.clone()),
            Law::Coulomb => Form::Coulomb(Coulomb::new(parameters)),
            Law::Custom(law) => Form::Custom(law.curve(epsilon, parameters)),
            Law::Small(law) => return law.form(epsilon, parameters),
            Law::Dropping(dropping) => {
                let (own, drop) = parameters.as_slice().split_at(dropping.parameters.len() - 1);
                return (dropping.law.form(epsilon, &LawParameters::new(own)).0, drop.first().copied());
            }
        };
        (form, None)
    }

    /// The column of parameter space (all parameters fixed except the damping) that contains `point`.
    ///
    /// # Panics
    /// If [`Law::check`] refuses the point. Points made by [`Law::point`] are legal.
    #[must_use]
    pub fn column(&self, point: &Point) -> Column {
        if let Err(error) = self.check(point) {
            panic!("{error}");
        }
        Column {
            curve: self.curve(point.epsilon, &point.law),
            epsilon: point.epsilon,
            belt_speed: point.belt_speed,
            unit: 1.0,
        }
    }
}

/// The kinds of curves, each with its own closed forms.
#[derive(Clone, Debug, PartialEq)]
enum Form {
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

/// A match with one arm for all built-in laws, which are listed here alone, before the arms of the others.
macro_rules! built_in {
    ($form:expr, $law:ident => $closed:expr; { $($others:tt)* }) => {
        match $form {
            Form::Stribeck($law) => $closed,
            Form::Exponential($law) => $closed,
            Form::Lorentzian($law) => $closed,
            Form::Coulomb($law) => $closed,
            $($others)*
        }
    };
}

impl Form {
    /// The closed form of a built-in law; `None` for other laws.
    fn closed(&self) -> Option<&dyn ClosedForm> {
        built_in!(self, law => Some(law); { _ => None })
    }

    /// See [`Curve::cost`].
    fn cost(&self) -> u64 {
        match self {
            Form::Expression(law) | Form::Leading(law) => law.cost(),
            form => form.closed().map_or(2, ClosedForm::cost),
        }
    }

    /// Work of compiling one piece, in evaluations of the Stribeck law: values at its points, their series and bounds, also of
    /// the pieces that were halved.
    fn work_of_piece(&self) -> u64 {
        24 * self.cost()
    }

    /// Proved bounds of the weakening rate of a built-in law; `None` for other laws.
    #[inline]
    fn weakening_range(&self, lo: f64, hi: f64) -> Option<Range> {
        built_in!(self, law => Some(law.weakening_range(lo, hi)); { _ => None })
    }

    fn phi(&self, u: f64) -> f64 {
        built_in!(self, law => law.phi(u); {
            Form::Expression(law) => law.phi(u),
            Form::Leading(law) => law.leading(u),
            Form::Table(law) => law.phi(u),
            Form::Function(law) => law.phi(u),
            Form::Custom(law) => law.phi(u),
        })
    }

    #[inline]
    fn weakening(&self, u: f64) -> f64 {
        built_in!(self, law => law.weakening(u); {
            Form::Expression(law) => law.weakening(u),
            Form::Leading(law) => -law.leading(Jet::<f64, 2>::variable(u, 1.0)).0[1],
            Form::Table(law) => law.weakening(u),
            Form::Function(law) => law.weakening(u),
            Form::Custom(law) => law.weakening(u),
        })
    }

    /// The weakening rate at several slip speeds >= 0.
    fn weakenings<const N: usize>(&self, u: [f64; N]) -> [f64; N] {
        match self {
            Form::Expression(law) => law.weakenings(u),
            law => u.map(|u| law.weakening(u)),
        }
    }

    /// phi in any arithmetic (numbers, intervals or series); `None` for laws given by data or functions.
    fn formula<T: Real>(&self, u: T) -> Option<T> {
        built_in!(self, law => Some(law.formula(u)); {
            Form::Expression(law) => Some(law.formula(u)),
            Form::Leading(law) => Some(law.leading(u)),
            Form::Table(_) | Form::Function(_) | Form::Custom(_) => None,
        })
    }

    /// Enclosures of the Taylor coefficients of phi at all slip speeds in `u`, in powers of the slip speed
    /// divided by `unit`.
    fn series<const N: usize>(&self, u: Interval, unit: f64) -> Option<Jet<Interval, N>> {
        match self {
            Form::Exponential(law) => Some(law.series(u, unit)),
            law => law.formula(Jet::<Interval, N>::variable(u, unit)),
        }
    }

    /// The unit of the slip speed of a formula, where that is not the one of the formula as it was written; and the form of
    /// that formula.
    fn unit(&self) -> Option<(f64, Self)> {
        match self {
            Form::Expression(law) => law.unit().map(|(unit, law)| (unit, Form::Expression(law))),
            _ => None,
        }
    }

    /// The friction at rest less that in slip as u -> 0.
    fn drop(&self) -> f64 {
        match self {
            Form::Coulomb(law) => law.drop(),
            Form::Expression(law) => law.drop(),
            Form::Table(law) => law.drop(),
            _ => 0.0,
        }
    }

    fn corners(&self) -> &[f64] {
        match self {
            Form::Expression(law) | Form::Leading(law) => law.corners(),
            Form::Table(law) => law.corners(),
            Form::Function(law) => law.corners(),
            Form::Custom(law) => law.corners(),
            _ => &[],
        }
    }

    /// Ends of the pieces on which the law is one smooth formula: its corners, and the ends of a function's
    /// polynomials.
    fn seams(&self) -> &[f64] {
        match self {
            Form::Function(law) => law.seams(),
            law => law.corners(),
        }
    }
}
