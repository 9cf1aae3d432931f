//! What curves prove of a column: its critical damping between two, and from where on the orbit sticks.

use super::find::Finder;
use super::{CurveKind, OneWay};
use crate::Claim;
use slipmap_model::friction::{Column, Range};

/// Distances of the curves that close from c*, in units of it, tried in this order.
const MARGINS: [f64; 5] = [1e-8, 1e-7, 1e-6, 1e-4, 1e-2];
/// Least size of C* of which they are shares: C is the damping at a frequency of 1.
const LEAST_SIZE: f64 = 1e-3;
/// Shares of c* at which a landing is tried.
const LANDINGS: [f64; 7] = [0.0, 0.25, 0.5, 0.75, 0.9, 0.97, 0.99];
/// Number of bisections between a damping at which it failed and one at which it did not.
const HALVINGS: u32 = 6;

/// Why there is no curve.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Stop {
    /// C* is sought between bounds.
    #[error("no orbit comes back at c = {at:.3e}, the smallest at which the critical one may be")]
    NeverReturns {
        /// c.
        at: f64,
    },
    /// C* is sought between bounds.
    #[error("the orbit comes back yet at c = {at:.3e}, the largest at which the critical one may be")]
    AlwaysReturns {
        /// c.
        at: f64,
    },
    /// The law ends.
    #[error("the orbit passes slip speed {known:.3e}, at which what is known of the law ends")]
    BeyondTheLaw {
        /// The largest slip speed at which it is known.
        known: f64,
    },
    /// The law has no proved enclosure at this slip speed.
    #[error("the law has no proved bounds at slip speed {at:.3e}")]
    NoEnclosure {
        /// The slip speed.
        at: f64,
    },
    /// No kappa closes the curve.
    #[error("no curve that orbits cross one way closes")]
    NotClosed,
    /// The curve passes the stick segment.
    #[error("the orbit may land beyond the stick segment at c = {damping:.3e}")]
    LandsBeyond {
        /// c.
        damping: f64,
    },
    /// No piece is short enough.
    #[error("no polynomial is short enough that orbits are proved to cross it one way")]
    Pieces,
    /// Curves are linear over a box.
    #[error("the box of parameters is too wide for one curve")]
    TooWide,
    /// A law by data over a box.
    #[error("boxes of parameters are proved of laws that are formulas")]
    NoFormula,
    /// Not legal, or below the normal numbers.
    #[error("at these parameters there is no friction law, or its coefficients are below the normal numbers")]
    NoLaw,
    /// Pieces or cells.
    #[error("the curve takes too many pieces or cells")]
    TooMuchWork,
    /// The checker refuses what was found.
    #[error("the curve that was found is no proof: {0}")]
    Refused(super::Fault),
}

/// The curves of a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Proof {
    /// Each of them checked.
    pub curves: Vec<OneWay>,
    /// The reason why something is left open that need not be.
    pub stop: Option<Stop>,
}

impl Proof {
    /// The damping of the best curve of a kind.
    fn damping(&self, kind: CurveKind) -> Option<f64> {
        self.curves.iter().find(|curve| curve.kind == kind).map(|curve| curve.c)
    }

    /// The enclosure of c*; an end is infinite where no curve proves it.
    #[must_use]
    pub fn critical(&self) -> Range {
        Range {
            lo: self.damping(CurveKind::Returns).unwrap_or(f64::NEG_INFINITY),
            hi: self.damping(CurveKind::Absent).unwrap_or(f64::INFINITY),
        }
    }

    /// The claim that follows.
    #[must_use]
    pub fn claim(&self) -> Claim {
        claim(&self.curves)
    }
}

/// The claim that curves prove of a column, if each of them proves what it claims.
pub(crate) fn claim(curves: &[OneWay]) -> Claim {
    let at = |kind: CurveKind| curves.iter().filter(move |curve| curve.kind == kind).map(|curve| curve.c);
    Claim {
        sticks_from: at(CurveKind::Lands).map(|c| c.max(0.0)).fold(f64::INFINITY, f64::min),
        present_below: at(CurveKind::Returns).fold(f64::NEG_INFINITY, f64::max),
        absent_above: at(CurveKind::Absent).fold(f64::INFINITY, f64::min),
    }
}

/// Finds and checks the curves of a column.
#[must_use]
pub fn prove(column: &Column) -> Proof {
    let mut proof = Proof { curves: Vec::new(), stop: None };
    // Coefficients below the normal numbers have lost digits that no enclosure accounts for.
    if !column.curve.is_normal() {
        return proof;
    }
    if let Err(stop) = proof.complete(column) {
        proof.stop = Some(stop);
    }
    proof
}

impl Proof {
    /// Adds a curve, if it is a proof: the finder has asked the checker for the sign of S on each of its
    /// pieces already.
    fn add(&mut self, finder: &Finder, curve: OneWay) -> Result<(), Stop> {
        curve.lies_well_in(finder.field()).map_err(Stop::Refused)?;
        self.curves.push(curve);
        Ok(())
    }

    fn complete(&mut self, column: &Column) -> Result<(), Stop> {
        let finder = Finder::new(column);
        let critical = critical(column, &finder)?;
        let kinds =
            if critical > 0.0 { &[CurveKind::Absent, CurveKind::Returns][..] } else { &[CurveKind::Absent] };
        let mut stop = None;
        for kind in kinds {
            stop = stop.or(self.close(&finder, *kind, column, critical).err());
        }
        if self.damping(CurveKind::Returns).is_some() {
            self.land(&finder, critical)?;
        }
        stop.map_or(Ok(()), Err)
    }

    /// The curve of a kind next to c*, as near as it can be found.
    fn close(
        &mut self,
        finder: &Finder,
        kind: CurveKind,
        column: &Column,
        critical: f64,
    ) -> Result<(), Stop> {
        let size = critical.abs().max(LEAST_SIZE / column.epsilon);
        let mut stop = Stop::NotClosed;
        for margin in MARGINS {
            let off = if kind == CurveKind::Returns { -margin * size } else { margin * size };
            let damping = critical + off;
            let found = finder.closed(kind, damping, 0.5 * column.epsilon * (damping - critical).abs());
            match found.and_then(|found| self.add(finder, found.curve)) {
                Ok(()) => return Ok(()),
                Err(why) => stop = why,
            }
        }
        Err(stop)
    }

    /// The curve that lands at the smallest damping found.
    fn land(&mut self, finder: &Finder, critical: f64) -> Result<(), Stop> {
        let mut failed = None;
        let mut stop = Stop::NotClosed;
        let tried = LANDINGS.map(|share| share * critical);
        let found = tried.into_iter().find_map(|damping| match finder.landing(damping) {
            Ok(found) => Some(found.curve),
            Err(why) => {
                (failed, stop) = (Some(damping), why);
                None
            }
        });
        let mut best = found.ok_or(stop)?;
        if let Some(mut failed) = failed {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (failed + best.c);
                match finder.landing(middle) {
                    Ok(found) => best = found.curve,
                    Err(_) => failed = middle,
                }
            }
        }
        self.add(finder, best)
    }
}

/// c*, approximately.
pub(super) fn critical(column: &Column, finder: &Finder) -> Result<f64, Stop> {
    finder.critical(search(column, finder)?.map(|viscous| viscous / column.epsilon))
}

/// Dampings between which C* is sought: bounds by the even part of w, and with a drop, D <= -2 at all slip
/// speeds.
fn search(column: &Column, finder: &Finder) -> Result<[f64; 2], Stop> {
    let belt_speed = column.belt_speed;
    let law = &finder.field().law;
    if law.reach() < 2.0 * belt_speed {
        return Err(Stop::BeyondTheLaw { known: law.reach() });
    }
    let even = law.even_range(belt_speed, belt_speed);
    let hi = if finder.field().drop.hi > 0.0 { law.range(0.0, law.reach()).hi + 2.0 } else { even.hi };
    let room = 1e-6 * (LEAST_SIZE + even.lo.abs().max(hi.abs()));
    let range = [even.lo - room, hi + room];
    if range.iter().all(|end| end.is_finite()) { Ok(range) } else { Err(Stop::NoEnclosure { at: 0.0 }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law, Table};

    fn brake(law: &Law, parameters: &[f64], belt_speed: f64) -> Column {
        law.column(&law.point(1.0, parameters, belt_speed, 0.0).unwrap())
    }

    /// Steep laws, drops, nodes, a jump of w, a table. The critical dampings of the first ones are those of a
    /// program in Python.
    #[test]
    fn machines_are_proved() {
        let (exponential, stretched) = (Law::Exponential, Law::Exponential.with_exponent());
        let dropping = Law::Exponential.with_drop();
        let jump = Law::Expression(Expression::new("1.08 - 0.4*max(u, 0.2)", 1.0).unwrap());
        let data = [(0.0, 1.0), (0.05, 0.8), (0.2, 0.66), (0.6, 0.62), (1.5, 0.6), (3.0, 0.6)];
        let table = Law::Table(Table::new("data", &data, 1.0).unwrap());
        let cases = [
            (brake(&exponential, &[0.6, 0.05, 0.0], 0.5), Some(0.188_799)),
            (brake(&exponential, &[0.6, 0.05, 0.0], 0.1), Some(1.448_509)),
            (brake(&dropping, &[0.8, 0.05, 0.0, 0.3], 0.5), Some(0.164_093)),
            (brake(&stretched, &[0.6, 1e-3, 0.0, 3.0], 0.5), Some(0.088_763)),
            (brake(&exponential, &[0.6, 5e-4, 0.0], 0.5), Some(0.083_870)),
            (brake(&stretched, &[0.4, 0.1, 0.01, 1.5], 0.5), None),
            (brake(&jump, &[], 0.5), None),
            (brake(&table, &[], 0.5), None),
        ];
        for (column, critical) in &cases {
            let proof = prove(column);
            let found = proof.critical();
            assert_eq!(proof.stop, None);
            assert!(proof.curves.iter().all(|curve| curve.check(column).is_ok()), "{found:?}");
            assert_eq!(proof.claim().sticks_from, 0.0);
            assert!(found.hi - found.lo <= 3.0 * MARGINS[0] * found.hi, "{found:?}");
            assert!(critical.is_none_or(|known| (found.lo - known).abs() < 1e-6), "{found:?}");
        }
        // Orbits pass the last datum: nothing is said.
        let short = Law::Table(Table::new("short", &data[..5], 1.0).unwrap());
        let proof = prove(&brake(&short, &[], 1.0));
        assert!(
            proof.curves.is_empty() && matches!(proof.stop, Some(Stop::BeyondTheLaw { .. })),
            "{proof:?}"
        );
    }

    /// Readings that scatter: the orbit turns next to two rows between which friction falls at once.
    #[test]
    fn data_that_scatter_are_proved() {
        let data = [
            (0.0, 1.0),
            (0.021866965, 0.95892523),
            (0.114450572, 0.846587906),
            (0.164998255, 0.811430703),
            (0.2170343996, 0.8173090275),
            (0.218272982, 0.785263793),
            (0.2921409775, 0.7518592133),
            (0.355308, 0.752849),
            (0.409898, 0.732692),
            (0.542248, 0.692422),
            (1.161892, 0.655463),
            (6.0, 0.62),
        ];
        let table = Law::Table(Table::new("data", &data, 1.0).unwrap());
        let proof = prove(&brake(&table, &[], 0.109_932_745_5));
        let found = proof.critical();
        assert!(proof.stop.is_none() && found.hi - found.lo < 1e-3 * found.hi, "{proof:?}");
    }

    /// c* <= c_HB is not a theorem: at k = 56 the orbit returns at c_HB.
    #[test]
    fn harmonic_balance_is_exceeded_at_large_k() {
        let balance_less = |epsilon, law: [f64; 3], belt_speed| {
            let column = Law::Stribeck.column(&Law::Stribeck.point(epsilon, &law, belt_speed, 0.0).unwrap());
            let balance = crate::harmonic_balance::TEST.claim(&column).present_below;
            let proved = prove(&column).critical();
            [balance - proved.lo, balance - proved.hi]
        };
        assert!(balance_less(0.79377, [0.32659, 0.0, 9.5262], 7.4949)[0] < 0.0);
        for k in [0.1, 0.3, 0.9] {
            assert!(balance_less(k, [0.2, 0.1, 1.0], 1.0)[1] > 0.0, "{k}");
        }
    }

    /// Where no damping is small enough, one curve proves absence at all.
    #[test]
    fn rising_friction_has_no_cycle() {
        let column = brake(&Law::Expression(Expression::new("1 + 0.1*u", 1.0).unwrap()), &[], 0.5);
        let proof = prove(&column);
        assert_eq!((proof.stop, proof.curves.len()), (None, 1));
        let claim = proof.claim();
        assert!(claim.absent_above < 0.0 && claim.present_below == f64::NEG_INFINITY, "{claim:?}");
    }

    /// Every piece missing, moved, reversed; the damping beyond c*, another direction, another law, other
    /// ends.
    #[test]
    fn forged_curves_are_refused() {
        let column = brake(&Law::Exponential, &[0.6, 0.05, 0.0], 0.5);
        let others = [[0.6, 0.0501, 0.0], [0.601, 0.05, 0.0], [0.599, 0.05, 0.0]];
        let proof = prove(&column);
        assert_eq!(proof.curves.len(), 3);
        for curve in &proof.curves {
            let changed = |change: &dyn Fn(&mut OneWay)| {
                let mut other = curve.clone();
                change(&mut other);
                other
            };
            let reversed = |it: &mut OneWay| {
                let points: Vec<_> =
                    it.pieces.iter().rev().map(|piece| piece.iter().rev().copied().collect()).collect();
                it.pieces = points.into_iter().collect();
            };
            let mut forged = vec![
                changed(&reversed),
                changed(&|it| it.pieces = std::iter::empty().collect()),
                changed(&|it| it.c = f64::NAN),
                changed(&|it| it.c = 5.0 * it.kind.sign()),
            ];
            for kind in [CurveKind::Returns, CurveKind::Absent, CurveKind::Lands]
                .into_iter()
                .filter(|kind| *kind != curve.kind)
            {
                forged.push(changed(&|it| it.kind = kind));
            }
            if curve.kind != CurveKind::Lands {
                let across = if curve.kind == CurveKind::Returns { 1.002 } else { 0.998 };
                forged.push(changed(&|it| it.c *= across));
            }
            for i in 0..curve.pieces.len() {
                forged.push(changed(&|it| drop(it.pieces.remove(i))));
                forged.push(changed(&|it| it.pieces[i].reverse()));
                forged.push(changed(&|it| it.pieces[i].iter_mut().for_each(|point| point[1] += 1e-4)));
                forged.push(changed(&|it| it.pieces[i][4][0] = f64::INFINITY));
                forged.push(changed(&|it| it.pieces[i][4][0] = -1.0));
                forged.push(changed(&|it| it.pieces[i][4][1] *= -1.0));
                forged.push(changed(&|it| it.pieces[i].clear()));
            }
            for other in forged {
                assert!(other.check(&column).is_err(), "{:?} of {}", other.kind, other.pieces.len());
            }
        }
        let near = proof.curves.iter().filter(|curve| curve.kind != CurveKind::Lands);
        let refused =
            near.flat_map(|curve| others.map(|other| curve.check(&brake(&Law::Exponential, &other, 0.5))));
        assert!(
            refused.filter(Result::is_err).count() >= others.len(),
            "each law is refused by one of the two"
        );
    }
}
