//! Friction laws: the force phi(u) at slip speed u >= 0 in units of the static force, phi(0) = 1.
//!
//! A [`Law`] is a family with named parameters, each of which becomes an axis of a map. Fixing eps and the
//! parameters gives a [`Curve`], a function of the slip speed. All other modules use a curve through its
//! values and its proved bounds, and do not depend on which parameters the law has.

mod custom;
pub(crate) mod domain;
mod exponential;
mod expression;
mod function;
pub(crate) mod interval;
pub(crate) mod jet;
mod lorentzian;
mod mean;
mod stribeck;
mod table;
mod weakening;

pub use custom::{Custom, CustomLaw, CustomLawError};
pub use domain::PointError;
pub use exponential::Exponential;
pub use expression::{Expression, ExpressionCurve, ExpressionError};
pub use function::{Function, FunctionError};
pub use lorentzian::Lorentzian;
pub use stribeck::Stribeck;
pub use table::{Table, TableError};
pub use weakening::{Accuracy, Weakening};
pub(crate) use weakening::{COUNT, ProvedPiece};

use std::cell::RefCell;
use std::sync::{Arc, Mutex, PoisonError};

use crate::point::{LawParameters, Point};
use custom::CustomCurve;
use interval::Interval;
use jet::{Jet, Real};

/// A closed interval [lo, hi] that encloses every value of a function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower bound.
    pub lo: f64,
    /// Upper bound.
    pub hi: f64,
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
    /// Largest legal value (included); infinite where the law sets none.
    pub max: f64,
}

/// A family of friction laws.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Law {
    /// The paper's law, `(1 - alpha) / (1 + eps gamma u) + alpha + eps beta u^2`.
    Stribeck,
    /// `mu + (1 - mu) exp(-u / vs) + eta u`.
    Exponential,
    /// `mu + (1 - mu) / (1 + (u / vs)^2) + eta u`.
    Lorentzian,
    /// A law given as text.
    Expression(Expression),
    /// A law given by data.
    Table(Table),
    /// A law given as a function of a program.
    Function(Function),
    /// A law implemented by a Rust program, see [`Law::custom`].
    Custom(Custom),
    /// A law read as `1 + eps F(u)`, see [`Law::read_as_small`].
    Small(Arc<Law>),
}

/// First line of the definition of a law read as `1 + eps F(u)`.
const SMALL: &str = "small eps";
/// Name of the laws given as text.
const EXPRESSION: &str = "expression";
/// Name of the laws given by data.
const TABLE: &str = "table";
/// Name of the laws given as functions, which no configuration can name.
const FUNCTION: &str = "function";

impl Law {
    /// The laws that need no definition, in the order in which messages list them.
    pub const BUILT_IN: [Law; 3] = [Law::Stribeck, Law::Exponential, Law::Lorentzian];

    /// The names of all laws.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Self::BUILT_IN.iter().map(Law::name).chain([EXPRESSION, TABLE])
    }

    /// The law's name in a configuration.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Law::Stribeck => "stribeck",
            Law::Exponential => "exponential",
            Law::Lorentzian => "lorentzian",
            Law::Expression(_) => EXPRESSION,
            Law::Table(_) => TABLE,
            Law::Function(_) => FUNCTION,
            Law::Custom(law) => law.name(),
            Law::Small(law) => law.name(),
        }
    }

    /// A law given by functions.
    ///
    /// ```
    /// use slipmap::certify::TESTS;
    /// use slipmap::filippov::Oscillator;
    /// use slipmap::friction::{CustomLaw, Law, Parameter};
    /// use slipmap::simulate::{Fate, flow};
    ///
    /// /// The friction of R. I. Leine and others, 1 / (1 + a u).
    /// #[derive(Debug)]
    /// struct Hyperbola([Parameter; 1]);
    ///
    /// impl CustomLaw for Hyperbola {
    ///     fn name(&self) -> &'static str {
    ///         "hyperbola"
    ///     }
    ///     fn parameters(&self) -> &[Parameter] {
    ///         &self.0
    ///     }
    ///     fn phi(&self, u: f64, _epsilon: f64, a: &[f64]) -> f64 {
    ///         1.0 / (1.0 + a[0] * u)
    ///     }
    ///     fn slope(&self, u: f64, _epsilon: f64, a: &[f64]) -> f64 {
    ///         -a[0] / (1.0 + a[0] * u).powi(2)
    ///     }
    /// }
    ///
    /// let a = Parameter { name: "a", long_name: "rate of weakening", min: 0.0, max: f64::INFINITY };
    /// let law = Law::custom(Hyperbola([a]))?;
    /// let point = law.point(1.0, &[3.0], 0.2, 0.0)?;
    /// let oscillator = Oscillator::new(&law, &point);
    /// assert!(matches!(flow(&oscillator, 1e-9).fate, Fate::Sticks(_)));
    /// let column = law.column(&point);
    /// // Of functions nothing is proved: the theorems are silent.
    /// let symmetric = TESTS.iter().find(|test| test.name == "symmetric").unwrap();
    /// assert_eq!((symmetric.claim)(&column).present_below, f64::NEG_INFINITY);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`CustomLawError`].
    pub fn custom(law: impl CustomLaw) -> Result<Law, CustomLawError> {
        Custom::new(law).map(Law::Custom)
    }

    /// The same law, read as `1 + eps F(u)` with `F = (phi - 1) / eps` at the given eps: then the paper's
    /// test (6), which takes a law to first order in eps, applies to every law. Nothing else changes.
    #[must_use]
    pub fn read_as_small(self) -> Law {
        match self {
            Law::Small(_) => self,
            law => Law::Small(Arc::new(law)),
        }
    }

    /// Returns whether the law is read as `1 + eps F(u)`.
    #[must_use]
    pub fn is_read_as_small(&self) -> bool {
        matches!(self, Law::Small(_))
    }

    /// The law itself, without the reading as `1 + eps F(u)`.
    #[must_use]
    pub fn as_written(&self) -> &Law {
        match self {
            Law::Small(law) => law,
            law => law,
        }
    }

    /// The law's own parameters, in the order in which they become axes of a map, slowest first.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        match self {
            Law::Stribeck => &stribeck::PARAMETERS,
            Law::Exponential | Law::Lorentzian => &exponential::PARAMETERS,
            Law::Expression(law) => law.parameters(),
            Law::Table(_) | Law::Function(_) => &[],
            Law::Custom(law) => law.parameters(),
            Law::Small(law) => law.parameters(),
        }
    }

    /// The data that [`Law::from_definition`] needs, beside the name, to restore the law; empty for the
    /// built-in laws.
    #[must_use]
    pub fn definition(&self) -> String {
        match self {
            Law::Stribeck | Law::Exponential | Law::Lorentzian | Law::Custom(_) => String::new(),
            Law::Small(law) => format!("{SMALL}\n{}", law.definition()),
            Law::Expression(law) => format!("{}\n{}", law.static_level(), law.text()),
            Law::Table(table) => {
                let errors = table.standard_errors();
                let rows = table.data().enumerate().map(|(i, (u, phi))| match errors {
                    Some(errors) => format!("\n{u},{phi},{}", errors[i]),
                    None => format!("\n{u},{phi}"),
                });
                let head = format!("{} {}", table.static_level(), table.origin());
                std::iter::once(head).chain(rows).collect()
            }
            Law::Function(law) => law.definition(),
        }
    }

    /// The law of this name and definition; `None` if there is none.
    #[must_use]
    pub fn from_definition(name: &str, definition: &str) -> Option<Law> {
        if let Some((SMALL, definition)) = definition.split_once('\n') {
            return Self::from_definition(name, definition).map(Law::read_as_small);
        }
        if let Some(law) = Self::BUILT_IN.into_iter().find(|law| law.name() == name) {
            return Some(law);
        }
        let (head, rest) = definition.split_once('\n')?;
        match name {
            FUNCTION => Function::from_definition(definition).map(Law::Function),
            EXPRESSION => Some(Law::Expression(Expression::new(rest, head.parse().ok()?).ok()?)),
            TABLE => {
                let numbers = |line: &str| -> Option<Vec<f64>> {
                    line.split(',').map(|number| number.parse().ok()).collect()
                };
                let rows: Vec<Vec<f64>> = rest.lines().map(numbers).collect::<Option<_>>()?;
                let column =
                    |i: usize| rows.iter().map(|row| row.get(i).copied()).collect::<Option<Vec<_>>>();
                let data: Vec<(f64, f64)> = column(0)?.into_iter().zip(column(1)?).collect();
                let (level, origin) = head.split_once(' ')?;
                let table = Table::new(origin, &data, level.parse().ok()?).ok()?;
                Some(Law::Table(match column(2) {
                    Some(errors) => table.with_standard_errors(&errors).ok()?,
                    None => table,
                }))
            }
            _ => None,
        }
    }

    /// The friction curve at one eps and one choice of the law's parameters.
    ///
    /// Successive curves with the same eps and parameters, as the columns of a map that differ in the belt
    /// speed only, share their compiled form.
    #[must_use]
    pub fn curve(&self, epsilon: f64, parameters: &LawParameters) -> Curve {
        thread_local! {
            static LATEST: RefCell<Option<(Law, f64, LawParameters, Curve)>> = const { RefCell::new(None) };
        }
        LATEST.with_borrow_mut(|latest| {
            if let Some((law, eps, known, curve)) = latest
                && *eps == epsilon
                && known == parameters
                && law == self
            {
                return curve.clone();
            }
            let small = self.is_read_as_small().then_some(epsilon);
            let curve = Curve { form: self.form(epsilon, parameters), small, compiled: Arc::default() };
            *latest = Some((self.clone(), epsilon, *parameters, curve.clone()));
            curve
        })
    }

    fn form(&self, epsilon: f64, parameters: &LawParameters) -> Form {
        match self {
            Law::Stribeck => Form::Stribeck(Stribeck::new(epsilon, parameters)),
            Law::Exponential => Form::Exponential(Exponential::new(parameters)),
            Law::Lorentzian => Form::Lorentzian(Lorentzian::new(parameters)),
            Law::Expression(law) => Form::Expression(law.curve(epsilon, parameters)),
            Law::Table(table) => Form::Table(table.clone()),
            Law::Function(law) => Form::Function(law.clone()),
            Law::Custom(law) => Form::Custom(law.curve(epsilon, parameters)),
            Law::Small(law) => law.form(epsilon, parameters),
        }
    }

    /// The column of parameter space (all parameters fixed but the damping) that contains `point`.
    ///
    /// # Panics
    /// If the point is not legal: [`Law::point`] makes legal points, [`Law::check`] tells.
    #[must_use]
    pub fn column(&self, point: &Point) -> Column {
        if let Err(error) = self.check(point) {
            panic!("{error}");
        }
        Column {
            curve: self.curve(point.epsilon, &point.law),
            epsilon: point.epsilon,
            belt_speed: point.belt_speed,
        }
    }
}

/// A friction curve: a law with all its parameters fixed. Clones share the compiled form.
#[derive(Clone, Debug)]
pub struct Curve {
    form: Form,
    /// eps, if the law is read as 1 + eps F(u).
    small: Option<f64>,
    compiled: Arc<Mutex<Compiled>>,
}

impl PartialEq for Curve {
    fn eq(&self, other: &Self) -> bool {
        self.form == other.form && self.small == other.small
    }
}

/// The compiled forms of a curve, as far as they have been needed.
#[derive(Debug, Default)]
struct Compiled {
    weakening: Vec<Arc<Weakening>>,
    /// -F1', of the law to first order in eps.
    leading: Vec<Arc<Weakening>>,
}

/// The kinds of curves, each with its own closed forms.
#[derive(Clone, Debug, PartialEq)]
enum Form {
    Stribeck(Stribeck),
    Exponential(Exponential),
    Lorentzian(Lorentzian),
    Expression(ExpressionCurve),
    /// F1 of a formula, in place of phi.
    Leading(ExpressionCurve),
    Table(Table),
    Function(Function),
    Custom(CustomCurve),
}

impl Form {
    fn phi(&self, u: f64) -> f64 {
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
    fn weakening(&self, u: f64) -> f64 {
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

    /// phi in any arithmetic (numbers, intervals or series); `None` for laws given by data or as functions,
    /// which have no formula.
    fn formula<T: Real>(&self, u: T) -> Option<T> {
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
    fn series<const N: usize>(&self, u: Interval, unit: f64) -> Option<Jet<Interval, N>> {
        match self {
            Form::Function(law) => law.series(u, unit),
            law => law.formula(Jet::<Interval, N>::variable(u, unit)),
        }
    }

    fn corners(&self) -> &[f64] {
        match self {
            Form::Table(law) => law.corners(),
            Form::Function(law) => law.corners(),
            Form::Custom(law) => law.corners(),
            Form::Stribeck(_)
            | Form::Exponential(_)
            | Form::Lorentzian(_)
            | Form::Expression(_)
            | Form::Leading(_) => &[],
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

    /// The law compiled to a slip speed of at least `reach`: to a power of two, so that similar belt speeds
    /// share the result, and anew for each, so that it does not depend on what was compiled before.
    fn compile(&self, known: &mut Vec<Arc<Weakening>>, reach: f64) -> Arc<Weakening> {
        // Neither its square nor its inverse may leave the range of normal numbers.
        let exponent = reach.clamp(1e-150, 1e150).log2().ceil() as i32;
        let wanted = match self {
            Form::Function(law) => law.fastest(),
            Form::Table(law) => law.fastest(),
            _ => 2f64.powi(exponent),
        };
        if let Some(known) = known.iter().find(|known| known.reach() == wanted) {
            return Arc::clone(known);
        }
        let compiled = Arc::new(weakening::compile(self, wanted));
        known.push(Arc::clone(&compiled));
        compiled
    }
}

/// The quantities that the first-order theory (eps -> 0) needs of a law phi = 1 + eps F1(u) + O(eps^2).
///
/// Slopes are per unit eps, so that they compare directly with the damping c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstOrder {
    /// `1/(pi V) * integral over a turn of F1(V - V cos t) cos t dt`, the right side of the paper's
    /// condition (6) divided by pi V.
    pub mean_weakening: f64,
    /// Range of -F1'(u) over slip speeds u in [0, 2 V].
    pub weakening_range: Range,
}

/// Derivatives of the weakening rate at one slip speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient {
    /// By eps.
    pub epsilon: f64,
    /// By each parameter of the law.
    pub parameters: LawParameters,
}

/// Reason why a law has no first order in eps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoFirstOrder {
    /// eps does not occur in it.
    #[error("the friction law does not depend on eps")]
    NoEpsilon,
    /// phi is not 1 at eps = 0.
    #[error("the friction law is not constant at eps = 0")]
    NotSmall,
    /// Its derivative by eps does not exist at eps = 0.
    #[error("the friction law has no derivative by eps at eps = 0")]
    NotDifferentiable,
}

impl Curve {
    /// Cost of one evaluation, in units of that of the Stribeck law, at least 1: budgets of work are divided
    /// by it.
    #[must_use]
    pub fn cost(&self) -> u64 {
        match &self.form {
            Form::Stribeck(_) | Form::Lorentzian(_) => 1,
            Form::Exponential(_) | Form::Table(_) | Form::Function(_) | Form::Custom(_) => 2,
            Form::Expression(law) | Form::Leading(law) => law.cost(),
        }
    }

    /// phi(u), the friction force at slip speed `u` >= 0.
    #[must_use]
    #[inline]
    pub fn phi(&self, u: f64) -> f64 {
        self.form.phi(u)
    }

    /// The weakening rate -phi'(u): positive where the friction falls with speed. The divergence of the
    /// flow is D(u) = weakening(u) - eps c.
    #[must_use]
    #[inline]
    pub fn weakening(&self, u: f64) -> f64 {
        self.form.weakening(u)
    }

    /// The weakening rate as polynomials on slip speeds from 0 to at least `reach`; for a table up to its
    /// end. Compiled once for each power of two.
    #[must_use]
    pub fn compiled(&self, reach: f64) -> Arc<Weakening> {
        let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        self.form.compile(&mut compiled.weakening, reach)
    }

    /// Proved bounds of the weakening rate over slip speeds u in [`lo`, `hi`], 0 <= lo <= hi.
    #[must_use]
    pub fn weakening_range(&self, lo: f64, hi: f64) -> Range {
        match &self.form {
            Form::Stribeck(law) => law.weakening_range(lo, hi),
            Form::Exponential(law) => law.weakening_range(lo, hi),
            Form::Lorentzian(law) => law.weakening_range(lo, hi),
            Form::Expression(_) | Form::Leading(_) | Form::Table(_) | Form::Function(_) | Form::Custom(_) => {
                // Of columns this is the reach of `Column::compiled`.
                self.compiled(2.0 * hi).range(lo, hi)
            }
        }
    }

    /// Proved bounds, over 0 < |v| <= V, of the even part in v of `weakening(V - v)`.
    #[must_use]
    pub fn even_weakening_range(&self, belt_speed: f64) -> Range {
        match &self.form {
            Form::Stribeck(law) => law.even_weakening_range(belt_speed),
            Form::Exponential(law) => law.even_weakening_range(belt_speed),
            Form::Lorentzian(_)
            | Form::Expression(_)
            | Form::Leading(_)
            | Form::Table(_)
            | Form::Function(_)
            | Form::Custom(_) => self.compiled(4.0 * belt_speed).even_range(belt_speed, belt_speed),
        }
    }

    /// The weakening rate averaged over the grazing circle v = V cos t with weight sin^2 t / pi: the energy
    /// that friction supplies in one turn, in units of that dissipated by unit damping eps c.
    #[must_use]
    pub fn mean_weakening(&self, belt_speed: f64) -> f64 {
        match &self.form {
            Form::Stribeck(law) => law.mean_weakening(belt_speed),
            Form::Table(law) => law.mean_weakening(belt_speed),
            Form::Exponential(_)
            | Form::Lorentzian(_)
            | Form::Expression(_)
            | Form::Leading(_)
            | Form::Function(_)
            | Form::Custom(_) => {
                let weakening = self.compiled(4.0 * belt_speed);
                mean::mean_weakening(|u| weakening.at(u), belt_speed)
            }
        }
    }

    /// The law to first order in eps at belt speed V.
    ///
    /// # Errors
    /// [`NoFirstOrder`] for a law that is not 1 + O(eps).
    pub fn first_order(&self, belt_speed: f64) -> Result<FirstOrder, NoFirstOrder> {
        if let Some(epsilon) = self.small {
            // -F' = w / eps.
            let Range { lo, hi } = self.weakening_range(0.0, 2.0 * belt_speed);
            return Ok(FirstOrder {
                mean_weakening: self.mean_weakening(belt_speed) / epsilon,
                weakening_range: Range { lo: lo / epsilon, hi: hi / epsilon },
            });
        }
        match &self.form {
            Form::Stribeck(law) => Ok(law.first_order(belt_speed)),
            Form::Expression(law) => {
                law.check_leading(belt_speed)?;
                let leading = {
                    let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
                    Form::Leading(law.clone()).compile(&mut compiled.leading, 2.0 * belt_speed)
                };
                // By parts, (6) divided by pi V is the mean of -F1'.
                Ok(FirstOrder {
                    mean_weakening: mean::mean_weakening(|u| leading.at(u), belt_speed),
                    weakening_range: leading.range(0.0, 2.0 * belt_speed),
                })
            }
            Form::Exponential(_)
            | Form::Lorentzian(_)
            | Form::Leading(_)
            | Form::Table(_)
            | Form::Function(_)
            | Form::Custom(_) => Err(NoFirstOrder::NoEpsilon),
        }
    }

    /// Returns whether the law's weakening rate has proved bounds for slip speeds up to `fastest`; theorems
    /// need them.
    #[must_use]
    pub fn is_enclosed(&self, fastest: f64) -> bool {
        let range = self.weakening_range(0.0, fastest);
        range.lo.is_finite() && range.hi.is_finite()
    }

    /// Derivatives of the weakening rate at slip speed `u` by eps and by each parameter of the law.
    #[must_use]
    pub fn weakening_gradient(&self, u: f64) -> Gradient {
        match &self.form {
            Form::Stribeck(law) => law.gradient(u),
            Form::Exponential(law) => law.gradient(u),
            Form::Lorentzian(law) => law.gradient(u),
            Form::Expression(law) | Form::Leading(law) => law.gradient(u),
            Form::Table(_) | Form::Function(_) => {
                Gradient { epsilon: 0.0, parameters: LawParameters::new(&[]) }
            }
            Form::Custom(law) => law.gradient(u),
        }
    }

    /// The table behind a measured law.
    #[must_use]
    pub fn table(&self) -> Option<&Table> {
        match &self.form {
            Form::Table(table) => Some(table),
            _ => None,
        }
    }

    /// Returns whether the closed forms of the law are evaluated in normal numbers: below them products may
    /// be wrong by any factor, and no result is a theorem.
    #[must_use]
    pub fn is_normal(&self) -> bool {
        match &self.form {
            Form::Stribeck(law) => law.is_normal(),
            Form::Exponential(law) => law.is_normal(),
            Form::Lorentzian(law) => law.is_normal(),
            // Enclosures are valid for numbers of every size.
            Form::Expression(_) | Form::Leading(_) | Form::Table(_) | Form::Function(_) | Form::Custom(_) => {
                true
            }
        }
    }

    /// phi in any arithmetic (numbers, intervals or series); `None` for measured laws, which have no formula.
    pub(crate) fn formula<T: Real>(&self, u: T) -> Option<T> {
        self.form.formula(u)
    }

    /// As [`Curve::even_weakening_range`] with 0 <= v <= `reach`, rounded outwards; `None` for measured laws.
    pub(crate) fn even_weakening_within(&self, belt_speed: f64, reach: f64) -> Option<Range> {
        self.formula(0.0)?;
        Some(self.compiled(4.0 * belt_speed).even_range(belt_speed, reach))
    }

    /// Slip speeds > 0, increasing, at which the slope of the weakening rate jumps: everywhere else the curve
    /// is smooth.
    #[must_use]
    pub fn corners(&self) -> &[f64] {
        self.form.corners()
    }

    /// Stribeck's law, for proofs over boxes and for vectorised engines, which use its three numbers; `None`
    /// for other laws.
    #[must_use]
    pub fn stribeck(&self) -> Option<&Stribeck> {
        match &self.form {
            Form::Stribeck(law) => Some(law),
            Form::Exponential(_)
            | Form::Lorentzian(_)
            | Form::Expression(_)
            | Form::Leading(_)
            | Form::Table(_)
            | Form::Function(_)
            | Form::Custom(_) => None,
        }
    }

    /// Returns whether the weakening rate is proved to be nonincreasing and convex in the slip speed, the
    /// continuation to u < 0 included.
    ///
    /// Then its even part in v at V - v rises with |v|, and so, to first order in the divergence, does the
    /// growth of a turn with its amplitude: there is at most one slip cycle, and it repels. No proof for
    /// every divergence is known to us; [`crate::simulate::slip_count`] proves it point by point, and has
    /// found no exception.
    #[must_use]
    pub fn weakening_is_convex(&self) -> bool {
        match self.form {
            Form::Stribeck(_) | Form::Exponential(_) => true,
            Form::Lorentzian(_)
            | Form::Expression(_)
            | Form::Leading(_)
            | Form::Table(_)
            | Form::Function(_)
            | Form::Custom(_) => false,
        }
    }
}

impl Column {
    /// The weakening rate as polynomials, up to the slip speeds of orbits that start within the belt speed.
    #[must_use]
    pub fn compiled(&self) -> Arc<Weakening> {
        self.curve.compiled(4.0 * self.belt_speed)
    }
}

/// All parameters but the damping: the unit of work of a map. Verdicts along a column change at most
/// twice, because every orbit's amplitude falls with c. Made by [`Law::column`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Column {
    /// The friction curve.
    pub curve: Curve,
    /// eps > 0.
    pub epsilon: f64,
    /// Belt speed V > 0.
    pub belt_speed: f64,
}
