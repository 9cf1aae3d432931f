//! Friction laws: the force phi(u) at slip speed u >= 0 in units of the static force, phi(0) = 1.
//!
//! A [`Law`] is a family with named parameters, each of which becomes an axis of a map. Fixing eps and
//! the parameters gives a [`Curve`], the function of one variable that the tests and the flow see. Code
//! above this module asks a curve for its values and for sign-certain bounds; it never learns which
//! parameters the law has.

mod stribeck;

pub use stribeck::Stribeck;

use crate::point::{LawParameters, Point};

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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// The paper's law, `(1 - alpha) / (1 + eps gamma u) + alpha + eps beta u^2`.
    Stribeck,
}

impl Law {
    /// Every law, in the order in which messages list them.
    pub const ALL: [Law; 1] = [Law::Stribeck];

    /// The law's name in a configuration.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Law::Stribeck => "stribeck",
        }
    }

    /// The law's own parameters, in the order in which they become axes of a map, slowest first.
    #[must_use]
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Law::Stribeck => &stribeck::PARAMETERS,
        }
    }

    /// The friction curve at one eps and one choice of the law's parameters.
    #[must_use]
    pub fn curve(self, epsilon: f64, parameters: &LawParameters) -> Curve {
        match self {
            Law::Stribeck => Curve::Stribeck(Stribeck::new(epsilon, parameters)),
        }
    }

    /// The column of parameter space (all but the damping fixed) that holds `point`.
    #[must_use]
    pub fn column(self, point: &Point) -> Column {
        Column {
            curve: self.curve(point.epsilon, &point.law),
            epsilon: point.epsilon,
            belt_speed: point.belt_speed,
        }
    }
}

/// A friction curve: a law with all its parameters fixed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// The paper's Stribeck curve.
    Stribeck(Stribeck),
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

impl Curve {
    /// phi(u), the friction force at slip speed `u` >= 0.
    #[must_use]
    #[inline]
    pub fn phi(&self, u: f64) -> f64 {
        match self {
            Curve::Stribeck(law) => law.phi(u),
        }
    }

    /// The weakening rate -phi'(u): positive where the friction falls with speed. The divergence of the
    /// flow is D(u) = weakening(u) - eps c.
    #[must_use]
    #[inline]
    pub fn weakening(&self, u: f64) -> f64 {
        match self {
            Curve::Stribeck(law) => law.weakening(u),
        }
    }

    /// Sign-certain bounds of the weakening rate over slip speeds u in [`lo`, `hi`], 0 <= lo <= hi.
    #[must_use]
    pub fn weakening_range(&self, lo: f64, hi: f64) -> Range {
        match self {
            Curve::Stribeck(law) => law.weakening_range(lo, hi),
        }
    }

    /// Sign-certain bounds, over 0 < |v| <= V, of the even part in v of `weakening(V - v)`.
    #[must_use]
    pub fn even_weakening_range(&self, belt_speed: f64) -> Range {
        match self {
            Curve::Stribeck(law) => law.even_weakening_range(belt_speed),
        }
    }

    /// The weakening rate averaged over the grazing circle v = V cos t with weight sin^2 t / pi:
    /// the energy that friction feeds into one turn, in units of that taken by unit damping eps c.
    #[must_use]
    pub fn mean_weakening(&self, belt_speed: f64) -> f64 {
        match self {
            Curve::Stribeck(law) => law.mean_weakening(belt_speed),
        }
    }

    /// The law to first order in eps at belt speed V; `None` for a law that does not depend on eps.
    #[must_use]
    pub fn first_order(&self, belt_speed: f64) -> Option<FirstOrder> {
        match self {
            Curve::Stribeck(law) => Some(law.first_order(belt_speed)),
        }
    }
}

/// All parameters but the damping: the unit of work of a map. Verdicts along a column change at most
/// twice, because every orbit's amplitude falls with c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// The friction curve.
    pub curve: Curve,
    /// eps > 0.
    pub epsilon: f64,
    /// Belt speed V > 0.
    pub belt_speed: f64,
}
