//! Friction laws: the force phi(u) at slip speed u >= 0 in units of the static force, phi(0) = 1.
//!
//! A [`Law`] is a family with named parameters, each of which becomes an axis of a map. Fixing eps and
//! the parameters gives a [`Curve`], the function of one variable that the tests and the flow see. Code
//! above this module asks a curve for its values and for sign-certain bounds; it never learns which
//! parameters the law has.

mod enclose;
mod exponential;
mod expression;
pub(crate) mod interval;
pub(crate) mod jet;
mod lorentzian;
mod stribeck;
mod table;

pub use exponential::Exponential;
pub use expression::{Expression, ExpressionCurve, ExpressionError};
pub use lorentzian::Lorentzian;
pub use stribeck::Stribeck;
pub use table::{Table, TableError};

use crate::point::{LawParameters, Point};
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
}

/// Name of the laws given as text.
const EXPRESSION: &str = "expression";
/// Name of the laws given by data.
const TABLE: &str = "table";

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
        }
    }

    /// The law's own parameters, in the order in which they become axes of a map, slowest first.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        match self {
            Law::Stribeck => &stribeck::PARAMETERS,
            Law::Exponential | Law::Lorentzian => &exponential::PARAMETERS,
            Law::Expression(law) => law.parameters(),
            Law::Table(_) => &[],
        }
    }

    /// What has to be known beside the name to make the law again with [`Law::from_definition`]; empty for
    /// the built-in laws.
    #[must_use]
    pub fn definition(&self) -> String {
        match self {
            Law::Stribeck | Law::Exponential | Law::Lorentzian => String::new(),
            Law::Expression(law) => format!("{}\n{}", law.static_level(), law.text()),
            Law::Table(table) => {
                let rows = table.data().map(|(u, phi)| format!("\n{u},{phi}"));
                let head = format!("{} {}", table.static_level(), table.origin());
                std::iter::once(head).chain(rows).collect()
            }
        }
    }

    /// The law of this name and definition; `None` if there is none.
    #[must_use]
    pub fn from_definition(name: &str, definition: &str) -> Option<Law> {
        if let Some(law) = Self::BUILT_IN.into_iter().find(|law| law.name() == name) {
            return Some(law);
        }
        let (head, rest) = definition.split_once('\n')?;
        match name {
            EXPRESSION => Some(Law::Expression(Expression::new(rest, head.parse().ok()?).ok()?)),
            TABLE => {
                let row = |line: &str| {
                    let (u, phi) = line.split_once(',')?;
                    Some((u.parse().ok()?, phi.parse().ok()?))
                };
                let data: Vec<(f64, f64)> = rest.lines().map(row).collect::<Option<_>>()?;
                let (level, origin) = head.split_once(' ')?;
                Some(Law::Table(Table::new(origin, &data, level.parse().ok()?).ok()?))
            }
            _ => None,
        }
    }

    /// The friction curve at one eps and one choice of the law's parameters.
    #[must_use]
    pub fn curve(&self, epsilon: f64, parameters: &LawParameters) -> Curve {
        match self {
            Law::Stribeck => Curve::Stribeck(Stribeck::new(epsilon, parameters)),
            Law::Exponential => Curve::Exponential(Exponential::new(parameters)),
            Law::Lorentzian => Curve::Lorentzian(Lorentzian::new(parameters)),
            Law::Expression(law) => Curve::Expression(law.curve(epsilon, parameters)),
            Law::Table(table) => Curve::Table(table.clone()),
        }
    }

    /// The column of parameter space (all but the damping fixed) that holds `point`.
    #[must_use]
    pub fn column(&self, point: &Point) -> Column {
        Column {
            curve: self.curve(point.epsilon, &point.law),
            epsilon: point.epsilon,
            belt_speed: point.belt_speed,
        }
    }
}

/// A friction curve: a law with all its parameters fixed.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// The paper's Stribeck curve.
    Stribeck(Stribeck),
    /// An exponential curve.
    Exponential(Exponential),
    /// A Lorentzian curve.
    Lorentzian(Lorentzian),
    /// A curve given as text.
    Expression(ExpressionCurve),
    /// A measured curve.
    Table(Table),
}

/// What the first-order theory (eps -> 0) needs of a law: phi = 1 + eps F1(u) + O(eps^2).
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

/// Why a law has no first order in eps.
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
    /// phi(u), the friction force at slip speed `u` >= 0.
    #[must_use]
    #[inline]
    pub fn phi(&self, u: f64) -> f64 {
        match self {
            Curve::Stribeck(law) => law.phi(u),
            Curve::Exponential(law) => law.phi(u),
            Curve::Lorentzian(law) => law.phi(u),
            Curve::Expression(law) => law.phi(u),
            Curve::Table(law) => law.phi(u),
        }
    }

    /// The weakening rate -phi'(u): positive where the friction falls with speed. The divergence of the
    /// flow is D(u) = weakening(u) - eps c.
    #[must_use]
    #[inline]
    pub fn weakening(&self, u: f64) -> f64 {
        match self {
            Curve::Stribeck(law) => law.weakening(u),
            Curve::Exponential(law) => law.weakening(u),
            Curve::Lorentzian(law) => law.weakening(u),
            Curve::Expression(law) => law.weakening(u),
            Curve::Table(law) => law.weakening(u),
        }
    }

    /// Sign-certain bounds of the weakening rate over slip speeds u in [`lo`, `hi`], 0 <= lo <= hi.
    #[must_use]
    pub fn weakening_range(&self, lo: f64, hi: f64) -> Range {
        match self {
            Curve::Stribeck(law) => law.weakening_range(lo, hi),
            Curve::Exponential(law) => law.weakening_range(lo, hi),
            Curve::Lorentzian(law) => law.weakening_range(lo, hi),
            Curve::Expression(law) => law.weakening_range(lo, hi),
            Curve::Table(law) => law.weakening_range(lo, hi),
        }
    }

    /// Sign-certain bounds, over 0 < |v| <= V, of the even part in v of `weakening(V - v)`.
    #[must_use]
    pub fn even_weakening_range(&self, belt_speed: f64) -> Range {
        match self {
            Curve::Stribeck(law) => law.even_weakening_range(belt_speed),
            Curve::Exponential(law) => law.even_weakening_range(belt_speed),
            Curve::Lorentzian(law) => law.even_weakening_range(belt_speed),
            Curve::Expression(law) => law.even_weakening_range(belt_speed),
            Curve::Table(law) => law.even_weakening_range(belt_speed),
        }
    }

    /// The weakening rate averaged over the grazing circle v = V cos t with weight sin^2 t / pi:
    /// the energy that friction feeds into one turn, in units of that taken by unit damping eps c.
    #[must_use]
    pub fn mean_weakening(&self, belt_speed: f64) -> f64 {
        match self {
            Curve::Stribeck(law) => law.mean_weakening(belt_speed),
            Curve::Exponential(law) => law.mean_weakening(belt_speed),
            Curve::Lorentzian(law) => law.mean_weakening(belt_speed),
            Curve::Expression(law) => law.mean_weakening(belt_speed),
            Curve::Table(law) => law.mean_weakening(belt_speed),
        }
    }

    /// The law to first order in eps at belt speed V.
    ///
    /// # Errors
    /// [`NoFirstOrder`] for a law that is not 1 + O(eps).
    pub fn first_order(&self, belt_speed: f64) -> Result<FirstOrder, NoFirstOrder> {
        match self {
            Curve::Stribeck(law) => Ok(law.first_order(belt_speed)),
            Curve::Expression(law) => law.first_order(belt_speed),
            Curve::Exponential(_) | Curve::Lorentzian(_) | Curve::Table(_) => Err(NoFirstOrder::NoEpsilon),
        }
    }

    /// phi on numbers, intervals or series; `None` for measured laws, which have no formula.
    pub(crate) fn formula<T: Real>(&self, u: T) -> Option<T> {
        match self {
            Curve::Stribeck(law) => Some(law.formula(u)),
            Curve::Exponential(law) => Some(law.formula(u)),
            Curve::Lorentzian(law) => Some(law.formula(u)),
            Curve::Expression(law) => Some(law.formula(u)),
            Curve::Table(_) => None,
        }
    }

    /// As [`Curve::even_weakening_range`] with 0 <= v <= `reach`, rounded outwards; `None` for measured laws.
    pub(crate) fn even_weakening_within(&self, belt_speed: f64, reach: f64) -> Option<Range> {
        self.formula(0.0)?;
        let enclosure = |u: Interval| {
            let phi = self.formula(Jet::<Interval, 4>::variable(u, 1.0));
            [1, 2, 3].map(|order| phi.map_or(Interval::ENTIRE, |phi| -phi.derivative(order)))
        };
        Some(enclose::even_range(enclosure, belt_speed, reach))
    }

    /// Slip speeds > 0, in growing order, at which the slope of the weakening rate jumps: everywhere else the
    /// curve is smooth.
    #[must_use]
    pub fn corners(&self) -> &[f64] {
        match self {
            Curve::Table(law) => law.corners(),
            Curve::Stribeck(_) | Curve::Exponential(_) | Curve::Lorentzian(_) | Curve::Expression(_) => &[],
        }
    }

    /// Whether the weakening rate certainly never rises with the slip speed and falls ever more slowly (is convex),
    /// the continuation to u < 0 included.
    ///
    /// Then its even part in v at V - v rises with |v|, and so, to first order in the divergence, does the growth
    /// of a turn with its amplitude: there is one slip cycle at most, and it repels. No proof of that is known to us for
    /// every divergence; [`crate::simulate::slip_count`] proves it point by point, and has found no exception.
    #[must_use]
    pub fn weakens_less_and_less(&self) -> bool {
        match self {
            Curve::Stribeck(_) | Curve::Exponential(_) => true,
            Curve::Lorentzian(_) | Curve::Expression(_) | Curve::Table(_) => false,
        }
    }
}

/// All parameters but the damping: the unit of work of a map. Verdicts along a column change at most
/// twice, because every orbit's amplitude falls with c.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The friction curve.
    pub curve: Curve,
    /// eps > 0.
    pub epsilon: f64,
    /// Belt speed V > 0.
    pub belt_speed: f64,
}
