//! Closed-form tests for stick-slip limit cycles, one file each, and their table.
//!
//! Every test answers the question "does the orbit that leaves the belt at the exit point stick again?" by
//! thresholds along the damping axis: a [`Claim`] per [`Column`]. This module does not use `orbits`: the
//! agreement of the two is evidence only while they are independent.
//!
//! # Equation numbers
//! The paper is O. Makarenkov, "A new test for stick-slip limit cycles in dry-friction oscillators with
//! small nonlinear friction characteristics". Numbers here count its numbered equations: (6) is the
//! perturbation test for any law, (12) the same for the Stribeck law, (13) the Stribeck oscillator and
//! (14) the divergence at the equilibrium. Where the perturbation test is called "(13)" and the
//! divergence test "(14)", the first means the inequality (12), which is stated for the system (13).
//! Everywhere else tests are cited by name.
//!
//! # Common ground of the finite-eps tests
//! Write v = x2, w = x2' and D(u) = weakening(u) - eps c. Below the belt line the flow is v' = w, w' = -v +
//! D(V - v) w, and the exit point is (V, 0). Put s = -v, p = -w in the lower half plane and s = v, p = w in
//! the upper one: in both, p > 0 and
//!
//! ```text
//! dp/ds = D - s / p,        u = V + s in the lower half plane, u = V - s in the upper one.   (H)
//! ```
//!
//! One turn is a lower half, from s = -V to the turning point s = R (the *amplitude*), and an upper half,
//! from s = -R to the belt line s = V, where the mass arrives with speed p = `wL` (the *landing speed*). It
//! sticks there iff `wL` < 2, see [`landing`]. What changes where friction drops as slip begins is in the source of
//! `certify::drop`. An orbit may also fail to return: its upper half may turn at
//! some s < V, and then it is trapped inside its own first turn; or a half may never end, because the orbit
//! tends to a stable node at the origin or runs away to infinity.
//!
//! **Comparison lemma.** If D >= D~ along two solutions of (H) and p >= p~ >= 0 at the start, then p >= p~
//! as long as both last; p > p~ at the end, even if p~ = 0 there, if moreover p > p~ at the start or D > D~
//! on an interval. *Proof.* z = (p^2 - p~^2)/2 solves
//!
//! ```text
//! z' = (D - D~) p + a z,      a = 2 D~ / (p + p~),
//! ```
//!
//! a linear equation with a source >= 0, whose coefficient is integrable up to and including turning
//! points, where p behaves like the square root of the distance. No bound on D is needed: the lemma holds
//! for nodes (|D| >= 2) as for foci. []
//!
//! **Monotonicity in c.** D falls with c, so, by the lemma, do the amplitude and the landing speed. An
//! orbit that comes back at some damping comes back at every smaller one at which it does not run away, and
//! one that does not run away at some damping does not at any larger one. Hence presence proved at one
//! damping and a landing speed proved below 2 at a smaller one settle everything between them.

pub mod bendixson;
pub mod bendixson_leading;
pub mod certificate;
pub mod curve;
mod drop;
mod enclosure;
pub mod harmonic_balance;
pub mod instability;
pub mod landing;
pub mod perturbation;
pub mod slip_count;
pub mod symmetric;
pub mod validated;

#[cfg(test)]
mod test_columns;

use std::cell::OnceCell;
use std::ops::Deref;

use slipmap_model::friction::Column;
use slipmap_numbers::named;

named! {
    /// The verdict of a test at one point, with its name in proofs.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Decision {
        /// A stick-slip limit cycle exists.
        Present => "present",
        /// None exists.
        Absent => "absent",
        /// The test does not apply here, or does not decide.
        Undecided => "undecided",
    }
}

/// The verdicts of a test along a whole column: presence for c >= 0 in [`sticks_from`, `present_below`),
/// absence for c > `absent_above`, undecided elsewhere. Infinite thresholds mean "never" or "no limit".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claim {
    /// Presence is claimed from this damping up: below it the orbit may land beyond the stick segment.
    /// Negative infinity for the asymptotic tests, which ignore the landing.
    pub sticks_from: f64,
    /// The test's critical damping: edge of the claim of presence. Negative infinity if it claims none.
    pub present_below: f64,
    /// Edge of the claim of absence. Infinity if it claims none.
    pub absent_above: f64,
}

impl Claim {
    /// No claim anywhere.
    pub const NOTHING: Claim = Claim {
        sticks_from: f64::NEG_INFINITY,
        present_below: f64::NEG_INFINITY,
        absent_above: f64::INFINITY,
    };

    /// The verdict at damping `c`.
    #[must_use]
    pub fn decide(&self, c: f64) -> Decision {
        if c > self.absent_above {
            Decision::Absent
        } else if c < self.present_below && c >= self.sticks_from {
            Decision::Present
        } else {
            Decision::Undecided
        }
    }

    /// The edge of the claim of presence; `None` where presence is claimed at no legal damping.
    pub fn edge(&self) -> Option<f64> {
        let is_claimed = self.present_below >= 0.0 && self.sticks_from < self.present_below;
        (is_claimed && self.present_below.is_finite()).then_some(self.present_below)
    }

    /// Signed distance in c to the edge of the claim of presence: positive below it, negative above, and where the
    /// landing is not proved. Negative infinity if the test claims no presence in this column.
    #[must_use]
    pub fn margin(&self, c: f64) -> f64 {
        match self.sticks_from < self.present_below {
            true if self.sticks_from > 0.0 => (self.present_below - c).min(c - self.sticks_from),
            true => self.present_below - c,
            false => f64::NEG_INFINITY,
        }
    }
}

/// Dampings that ascend, at which claims are asked one after the other.
#[derive(Debug)]
pub struct Dampings<'a> {
    cs: &'a [f64],
    /// Where the last claim had its edges. Those of neighbouring columns lie between the same dampings as a rule.
    sticks_from: usize,
    present_to: usize,
    absent_from: usize,
}

impl<'a> Dampings<'a> {
    /// The dampings `cs`, which ascend.
    pub fn new(cs: &'a [f64]) -> Self {
        Self { cs, sticks_from: 0, present_to: 0, absent_from: 0 }
    }

    /// The verdicts of a claim: in the order of the dampings the number of those with each.
    #[inline]
    pub fn decide(&mut self, claim: &Claim) -> [(Decision, usize); 4] {
        let Claim { sticks_from, present_below, absent_above } = *claim;
        let sticks_from = edge(self.cs, &mut self.sticks_from, |c| !(c >= sticks_from));
        let present_to = edge(self.cs, &mut self.present_to, |c| c < present_below);
        let absent_from = edge(self.cs, &mut self.absent_from, |c| !(c > absent_above)).max(present_to);
        let present_from = sticks_from.min(present_to);
        [
            (Decision::Undecided, present_from),
            (Decision::Present, present_to - present_from),
            (Decision::Undecided, absent_from - present_to),
            (Decision::Absent, self.cs.len() - absent_from),
        ]
    }
}

/// The number of the dampings that are before an edge, first tried as it `was`.
#[inline]
fn edge(cs: &[f64], was: &mut usize, is_before: impl Fn(f64) -> bool) -> usize {
    let is_still = (*was == 0 || is_before(cs[*was - 1])) && (*was == cs.len() || !is_before(cs[*was]));
    if !is_still {
        *was = cs.partition_point(|&c| is_before(c));
    }
    *was
}

/// The edge of a claim of presence for eps c < `bound`: `bound` / eps.
///
/// Below the normal numbers a bound may be wrong by any factor, and nothing is claimed, nor where it overflows to NaN. The quotient's own
/// rounding does no harm at any size: a double c that is less than the rounded quotient is less than the
/// quotient.
fn presence_edge(column: &Column, bound: f64) -> f64 {
    if is_reliable(column, bound) { bound / column.epsilon } else { f64::NEG_INFINITY }
}

/// The edge of a claim of absence for eps c > `bound`, as [`presence_edge`].
fn absence_edge(column: &Column, bound: f64) -> f64 {
    if is_reliable(column, bound) { bound / column.epsilon } else { f64::INFINITY }
}

fn is_reliable(column: &Column, bound: f64) -> bool {
    column.curve.is_normal() && !bound.is_subnormal() && !bound.is_nan()
}

named! {
    /// Strength of a verdict, with its name in map files.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Guarantee {
        /// True in the limit eps -> 0; may be wrong at any given eps.
        Asymptotic => "asymptotic",
        /// A theorem at every eps > 0, evaluated in double precision.
        FiniteEpsilon => "finite_epsilon",
        /// Numerical integration with an error estimate.
        Numerical => "numerical",
        /// A theorem including round-off.
        Validated => "validated",
        /// No claim of correctness: a method that is included to be measured.
        None => "none",
    }
}

impl Guarantee {
    /// Whether claims are theorems at every eps.
    #[must_use]
    pub fn is_rigorous(self) -> bool {
        matches!(self, Guarantee::FiniteEpsilon | Guarantee::Validated)
    }
}

/// Columns with the claims of [`symmetric`], which several methods use; each is computed once.
pub struct Columns<'a> {
    columns: &'a [Column],
    symmetric: Vec<OnceCell<Claim>>,
}

impl<'a> Columns<'a> {
    /// Columns of which nothing is computed yet.
    pub fn new(columns: &'a [Column]) -> Self {
        Self { columns, symmetric: vec![OnceCell::new(); columns.len()] }
    }

    /// The claim of [`symmetric`] about a column.
    pub fn symmetric(&self, number: usize) -> Claim {
        *self.symmetric[number].get_or_init(|| symmetric::claim(&self.columns[number]))
    }
}

impl Deref for Columns<'_> {
    type Target = [Column];

    fn deref(&self) -> &[Column] {
        self.columns
    }
}

/// A closed-form test.
#[derive(Clone, Copy, Debug)]
pub struct Test {
    /// Name in configurations and map files.
    pub name: &'static str,
    /// One phrase for legends and `long_name`.
    pub long_name: &'static str,
    /// Its equation in the paper, or its section of the crate's theory pages.
    pub equation: &'static str,
    /// The guarantee of its verdicts.
    pub guarantee: Guarantee,
    /// Whether it needs the law's expansion to first order in eps, and claims nothing without one.
    pub first_order: bool,
    /// The claim along each column; of some tests those of many columns cost less together.
    pub(crate) claims: fn(&Columns) -> Vec<Claim>,
}

impl Test {
    /// The claim along a column.
    #[must_use]
    pub fn claim(&self, column: &Column) -> Claim {
        self.claims(&Columns::new(std::slice::from_ref(column)))[0]
    }

    /// The claim of [`Test::claim`] along each column.
    pub fn claims(&self, columns: &Columns) -> Vec<Claim> {
        (self.claims)(columns)
    }
}

/// Every closed-form test, in the order in which maps and tables list them.
pub static TESTS: [Test; 6] = [
    perturbation::TEST,
    instability::TEST,
    bendixson_leading::TEST,
    bendixson::TEST,
    symmetric::TEST,
    harmonic_balance::TEST,
];

/// The test of this name, [`validated::TEST`] included; `None` if there is none.
#[must_use]
pub fn by_name(name: &str) -> Option<&'static Test> {
    TESTS.iter().chain([&validated::TEST]).find(|test| test.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law};
    use slipmap_model::point::{LawParameters, Point};

    #[test]
    fn a_claim_decides_by_its_thresholds() {
        let claim = Claim { sticks_from: 0.5, present_below: 1.0, absent_above: 2.0 };
        for (c, decision) in [
            (0.25, Decision::Undecided),
            (0.5, Decision::Present),
            (0.75, Decision::Present),
            (1.0, Decision::Undecided),
            (2.0, Decision::Undecided),
            (2.5, Decision::Absent),
        ] {
            assert_eq!(claim.decide(c), decision, "c = {c}");
        }
        assert_eq!([0.25, 0.625, 0.75, 2.5].map(|c| claim.margin(c)), [-0.25, 0.125, 0.25, -1.5]);
        assert_eq!(claim.edge(), Some(1.0));
        // The landing is proved at no damping at which the orbit is proved to return.
        let never = Claim { sticks_from: 1.5, ..claim };
        assert_eq!((never.edge(), never.margin(0.25)), (None, f64::NEG_INFINITY));
        assert_eq!(Claim { present_below: -0.1, ..claim }.edge(), None);
        assert_eq!(Claim::NOTHING.decide(0.0), Decision::Undecided);
    }

    #[test]
    fn edges_by_hand() {
        // gamma (1 - alpha) = 1 with each eps, 2 beta V = 1/32, and k = 4 with eps = 1.
        let column = |eps: f64| test_columns::stribeck(eps, 0.5, 0.0078125, 2.0, 2.0);
        let never = f64::INFINITY;
        for (test, eps, present_below, absent_above) in [
            (perturbation::TEST, 1.0, 1.0 - 0.03125, 1.0 - 0.03125),
            (perturbation::TEST, 1e-3, 1.0 - 0.03125, 1.0 - 0.03125),
            (bendixson_leading::TEST, 1.0, 1.0 - 0.0625, never),
            (instability::TEST, 1.0, 1.0 / 25.0 - 0.03125, never),
            (symmetric::TEST, 1.0, 1.0 / 25.0 - 0.03125, (1.0 + 1.0 / 81.0) / 2.0 - 0.03125),
            // q = 3: 2 / (q (1 + k + q)).
            (harmonic_balance::TEST, 1.0, 1.0 / 12.0 - 0.03125, 1.0 / 12.0 - 0.03125),
        ] {
            let claim = test.claim(&column(eps));
            // Some roundings of the terms, since bounds are rounded outwards, and none of whole numbers and halves.
            let rounding =
                |edge: f64| if test.first_order { 0.0 } else { 16.0 * f64::EPSILON * (edge + 0.03125) };
            let is = |found: f64, edge: f64| found == edge || (found - edge).abs() <= rounding(edge);
            assert!(is(claim.present_below, present_below), "{}: {claim:?}", test.name);
            assert!(is(claim.absent_above, absent_above), "{}: {claim:?}", test.name);
            assert!(!test.first_order || claim.sticks_from == f64::NEG_INFINITY, "{}: {claim:?}", test.name);
        }
    }

    #[test]
    fn verdicts_along_a_column_are_those_of_its_cells() {
        let thresholds = [f64::NEG_INFINITY, -1.0, 0.0, 0.5, 1.0, 2.0, f64::INFINITY, f64::NAN];
        for cs in [&[][..], &[0.5], &[0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0]] {
            let mut dampings = Dampings::new(cs);
            for [sticks_from, present_below, absent_above] in thresholds
                .iter()
                .flat_map(|&a| thresholds.iter().flat_map(move |&b| thresholds.map(|c| [a, b, c])))
            {
                // A claim of presence never meets one of absence.
                if present_below > absent_above {
                    continue;
                }
                let claim = Claim { sticks_from, present_below, absent_above };
                let along = dampings.decide(&claim).into_iter();
                let along: Vec<_> = along.flat_map(|(decision, cells)| vec![decision; cells]).collect();
                let one_by_one: Vec<_> = cs.iter().map(|&c| claim.decide(c)).collect();
                assert_eq!(along, one_by_one, "{claim:?} {cs:?}");
            }
        }
    }

    /// Methods share claims; the answer of each is what it would be alone.
    #[test]
    fn claims_of_many_columns_are_those_of_each() {
        let law = Law::Expression(Expression::new("1 - 0.4*tanh(3*u) + 0.01*u^2", 1.0).unwrap());
        let formula = |i: i32| {
            let belt_speed = 0.1 * 1.15_f64.powi(i);
            law.column(&Point { epsilon: 0.9, law: LawParameters::new(&[]), belt_speed, damping: 0.0 })
        };
        // Stribeck's law with and without a drop: engines of their own, side by side.
        let dropped = Law::Stribeck.with_drop();
        let of_drop = |i: u32| {
            let law = LawParameters::new(&[0.313, 0.0117, 2.07, if i.is_multiple_of(3) { 0.1 } else { 0.0 }]);
            let belt_speed = 0.2 + 0.0137 * f64::from(i);
            dropped.column(&Point { epsilon: 0.3, law, belt_speed, damping: 0.0 })
        };
        let columns: Vec<Column> = (0..32).map(formula).collect();
        let stribeck: Vec<Column> = test_columns::random_columns(100).collect();
        for columns in [columns, stribeck, (0..300).map(of_drop).collect()] {
            let shared = Columns::new(&columns);
            for test in &TESTS {
                for (column, claim) in columns.iter().zip(test.claims(&shared)) {
                    assert_eq!(claim, test.claim(column), "{} {column:?}", test.name);
                }
            }
        }
    }

    /// As eps vanishes the edges tend to gamma (1 - alpha) - 2 beta V = 1.2 for presence and, for absence, to
    /// the same or to gamma (1 - alpha) = 1.4. Where products of eps fall below the normal numbers, there is
    /// no claim; at eps = 5e-324 presence and absence were once claimed of the same point.
    #[test]
    fn claims_are_right_or_missing_down_to_the_smallest_eps() {
        let (mut claimed, mut silent) = (0, 0);
        for exponent in -1074..=-960 {
            // In two factors: the power alone is the inverse of one that overflows.
            let power = 2f64.powi(exponent + 500) * 2f64.powi(-500);
            for eps in [power, 1.37 * power] {
                let column = test_columns::stribeck(eps, 0.3, 0.1, 2.0, 1.0);
                for test in &TESTS {
                    let claim = test.claim(&column);
                    let Claim { present_below, absent_above, .. } = claim;
                    let tends_to = |edge: f64, limits: &[f64]| {
                        // The edge of `bendixson` is found to 1e-9.
                        edge.is_infinite() || limits.iter().any(|limit| (edge / limit - 1.0).abs() < 1e-8)
                    };
                    assert!(tends_to(present_below, &[1.2, 1.0]), "{} {eps:e}: {claim:?}", test.name);
                    assert!(tends_to(absent_above, &[1.2, 1.4]), "{} {eps:e}: {claim:?}", test.name);
                    assert!(present_below <= absent_above, "{} {eps:e}: {claim:?}", test.name);
                    if test.guarantee == Guarantee::FiniteEpsilon {
                        *(if claim == Claim::NOTHING { &mut silent } else { &mut claimed }) += 1;
                    }
                }
            }
        }
        assert!(claimed > 100 && silent > 100, "{claimed} {silent}");
        // A factor of zero is exact: Coulomb friction has no cycle with any damping.
        let coulomb = symmetric::TEST.claim(&test_columns::stribeck(5e-324, 0.3, 0.0, 0.0, 1.0));
        assert_eq!(coulomb.absent_above, 0.0);
    }
}
