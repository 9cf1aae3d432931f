//! The critical damping c* of a column, at which the orbit from the exit point grazes the belt line.

use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::{Failure, Fate};
use slipmap_model::friction::Column;
use slipmap_numbers::text::rounded;
use slipmap_orbits::grazing::{Belt, grazing_dampings};
use slipmap_orbits::{Closing, Effort, Piece, Work, flow_within};

/// Largest error of a number that is told, as a share of it. A number with a larger error is withheld.
const LARGEST_ERROR: f64 = 0.01;
/// An error that is never too large, for numbers that vanish.
const SMALL_ERROR: f64 = 1e-9;

/// Whether a dimensionless number is told: its error is at most 1 % of it, or 1e-9.
pub fn is_known(value: f64, error: f64) -> bool {
    error <= (LARGEST_ERROR * value.abs()).max(SMALL_ERROR)
}

/// The critical damping of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalDamping {
    /// c*: the orbit from the exit point returns to the belt line for c < c* and not for c > c*. Negative
    /// where it does not return for any legal damping.
    pub c: f64,
    /// Estimate of the absolute error of `c`.
    pub error: f64,
    /// Number of evaluations of the right-hand side.
    pub rhs: u64,
}

impl CriticalDamping {
    /// The damping itself where it is told: its error is at most 1 % of it (or 1e-9), or it is negative.
    ///
    /// # Errors
    /// [`NoCriticalDamping::Inaccurate`].
    pub fn known(self) -> Result<Self, NoCriticalDamping> {
        match is_known(self.c, self.error) || self.c + self.error <= 0.0 {
            true => Ok(self),
            false => Err(NoCriticalDamping::Inaccurate { error: self.error }),
        }
    }
}

/// The critical damping c* that was found, where it is known to 1 %; else NaN.
pub fn known_or_nan(found: Result<CriticalDamping, NoCriticalDamping>) -> f64 {
    found.and_then(CriticalDamping::known).map_or(f64::NAN, |known| known.c)
}

/// Reason why a column has no critical damping.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoCriticalDamping {
    /// No engine could follow the orbit that grazes the belt line.
    #[error("the orbit that grazes the belt line cannot be followed")]
    NotFollowed,
    /// The search takes more work than its quota.
    #[error("{}", Failure::Quota)]
    Quota,
    /// Another engine contradicts what was found.
    #[error("two engines contradict each other about it")]
    Contradicted,
    /// It was found with an error above 1 % of it.
    #[error("it is known to no better than {}, which is more than 1 % of it", rounded(*error, 2))]
    Inaccurate {
        /// Estimate of the absolute error.
        error: f64,
    },
}

/// The critical damping of many columns.
///
/// `tolerance` is relative to the size of the divergence: about the error of the scaled grazing margin that
/// corresponds to the error of c*.
#[must_use]
pub fn critical_dampings(
    columns: &[Column],
    tolerance: f64,
) -> Vec<Result<CriticalDamping, NoCriticalDamping>> {
    critical_dampings_with(Effort::Whole, columns, tolerance)
}

/// [`critical_dampings`] with an effort.
#[must_use]
pub fn critical_dampings_with(
    effort: Effort,
    columns: &[Column],
    tolerance: f64,
) -> Vec<Result<CriticalDamping, NoCriticalDamping>> {
    let quota = |column: &Column| Work::with(effort, Piece::Critical, &column.curve);
    let works: Vec<Work> = columns.iter().map(quota).collect();
    let belts = columns.iter().zip(&works).map(|(column, work)| (&column.curve, column.belt_speed, work));
    let belts: Vec<Belt> = belts.collect();
    let answer = |((column, work), found): ((&Column, &Work), Result<Closing, u64>)| {
        let why = || if work.left() == 0 { NoCriticalDamping::Quota } else { NoCriticalDamping::NotFollowed };
        let Closing { viscous, error, rhs, .. } = found.map_err(|_| why())?;
        Ok(CriticalDamping { c: viscous / column.epsilon, error: error / column.epsilon, rhs })
    };
    columns.iter().zip(&works).zip(grazing_dampings(&belts, tolerance)).map(answer).collect()
}

/// The critical damping of one column, see [`critical_dampings`].
///
/// # Errors
/// [`NoCriticalDamping`] where the orbit cannot be followed.
pub fn critical_damping(column: &Column, tolerance: f64) -> Result<CriticalDamping, NoCriticalDamping> {
    critical_damping_with(Effort::Whole, column, tolerance)
}

/// [`critical_damping`] with an effort.
///
/// # Errors
/// As there.
pub fn critical_damping_with(
    effort: Effort,
    column: &Column,
    tolerance: f64,
) -> Result<CriticalDamping, NoCriticalDamping> {
    critical_dampings_with(effort, std::slice::from_ref(column), tolerance)[0]
}

/// From which damping on the orbit from the exit point sticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SticksFrom {
    /// Bounds of it. The first is the greatest damping at which the orbit is known to cross for ever, or the least that was
    /// asked; the second is the least at which it is known to stick. They are equal where it sticks from the least on.
    pub between: [f64; 2],
    /// Why orbits between them cannot be followed, where that keeps the bounds apart.
    pub failure: Option<Failure>,
}

impl SticksFrom {
    /// The damping from which on the orbit is known to stick, where the bounds agree to 1 %.
    #[must_use]
    pub fn known(&self) -> Option<f64> {
        let [low, high] = self.between;
        is_known(high, high - low).then_some(high)
    }
}

/// The lowest damping in `[low, high]` from which the orbit from the exit point sticks, given that it sticks just below
/// `high`; in 2^-`halvings` of that range, as far as orbits can be followed.
///
/// Along c the fates have a fixed order: crossing, sticking, inward. So an orbit that crosses bounds that damping from
/// below, and one that sticks from above. An orbit that fails, or is too close to call, does neither.
#[must_use]
pub fn sticks_from(
    effort: Effort,
    column: &Column,
    range: [f64; 2],
    halvings: u32,
    tolerance: f64,
) -> SticksFrom {
    let work = Work::with(effort, Piece::SticksFrom, &column.curve);
    let mut failure = None;
    let crosses = |c: f64| match flow_within(&Oscillator::in_column(column, c), tolerance, &work).fate {
        Fate::CrossesForever => Some(true),
        Fate::Sticks(_) | Fate::SpiralsInward => Some(false),
        Fate::TooCloseToCall => None,
        Fate::Failed(why) => {
            // Of the lowest damping: next to where orbits can be followed again they may fail for other reasons.
            failure = failure.or(Some(why));
            None
        }
    };
    let between = last_below(range, halvings, crosses);
    SticksFrom { between, failure: failure.filter(|_| between[0] < between[1]) }
}

/// Bounds of the damping in `[low, high]` below which a statement holds, given that it does not at `high` and that it holds
/// below any damping at which it does. The first is the greatest damping at which it is known to hold, or `low`; the second is
/// the least at which it is known not to. Both are `low` where it does not hold there.
pub(crate) fn last_below(
    [low, high]: [f64; 2],
    halvings: u32,
    mut holds: impl FnMut(f64) -> Option<bool>,
) -> [f64; 2] {
    let (mut below, mut state, mut above, mut known) = (low, holds(low), high, None);
    if state == Some(false) {
        return [low; 2];
    }
    for _ in 0..halvings {
        if state == Some(true) {
            known = Some(below);
        }
        let middle = 0.5 * (below + above);
        match holds(middle) {
            Some(false) => above = middle,
            other => (below, state) = (middle, other),
        }
    }
    if state == Some(true) {
        return [below, above];
    }
    let Some(mut known) = known else { return [low, above] };
    for _ in 0..halvings {
        let middle = 0.5 * (known + below);
        *(if holds(middle) == Some(true) { &mut known } else { &mut below }) = middle;
    }
    [known, above]
}

/// Number of bisections that locate the damping from which orbits stick to 10^-12 of a range.
pub const HALVINGS: u32 = 40;

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law, Table};

    /// A first row next to rest makes the bounds of the search wide, and the rows end where orbits of lower damping leave
    /// them but the grazing orbit does not: rows beyond change the last piece alone.
    #[test]
    fn data_that_the_grazing_orbit_does_not_leave_suffice() {
        let rows = [
            (0.0, 1.0),
            (2.9e-6, 0.99516),
            (0.012_127, 0.921_15),
            (0.023_686, 0.915_38),
            (0.040_93, 0.827_79),
            (0.065, 0.770_3),
            (0.088_205, 0.741_36),
            (0.117_72, 0.720_66),
            (0.126_944, 0.727_2),
        ];
        let of_rows = |rows: &[(f64, f64)]| {
            let law = Law::Table(Table::new("falls", rows, 1.0).unwrap());
            critical_damping(&law.column(&law.point(1.0, &[], 0.044_172, 0.0).unwrap()), 1e-9).unwrap()
        };
        let [short, long] = [of_rows(&rows), of_rows(&[&rows[..], &[(0.5, 0.727_2)]].concat())];
        assert!((short.c - long.c).abs() < short.error + long.error, "{short:?} {long:?}");
        assert!(short.error < 1e-5, "{short:?}");
    }

    /// Next to the most braking, where a quarter may start late, the speed at which braking and spring balance does not change.
    #[test]
    fn errors_hold_where_the_balance_turns() {
        let law = Law::Expression(Expression::new("0.58 + 0.42*exp(-(u/0.03)^2)", 1.0).unwrap());
        for belt_speed in [0.232_846_642_3, 0.274_968_748_4, 0.325_191_259_6] {
            let column = law.column(&law.point(1.0, &[], belt_speed, 0.0).unwrap());
            let [found, exact] = [1e-9, 1e-12].map(|tolerance| critical_damping(&column, tolerance).unwrap());
            assert!((found.c - exact.c).abs() < found.error + exact.error, "{found:?} {exact:?}");
            assert!(found.error < 1e-9, "{found:?}");
        }
    }

    /// A fall that rounds off at rest tends to a drop as it becomes narrow. Next to rest x2'' = -x2 and friction falls as
    /// u^2 / w^2: the time until it falls, and the error, are of the order w^(2/3).
    #[test]
    fn narrow_falls_that_are_round_at_rest_have_a_critical_damping() {
        let coulomb = Law::Coulomb.column(&Law::Coulomb.point(1.0, &[0.3, 0.0], 1.0, 0.0).unwrap());
        let drop = critical_damping(&coulomb, 1e-12).unwrap().c;
        let law = Law::Expression(Expression::new("1 - 0.3*tanh(u/w)^2", 1.0).unwrap());
        let excess = |width: f64| {
            let column = law.column(&law.point(1.0, &[width], 1.0, 0.0).unwrap());
            let found = critical_damping(&column, 1e-9).unwrap();
            assert!(found.error < 1e-7, "{width}: {found:?}");
            found.c - drop
        };
        // An orbit by arcs gave 0.028750799 +- 1.2e-8.
        assert!((excess(1e-2) + drop - 0.028_750_799).abs() < 1.2e-8);
        for width in [1e-4, 1e-6, 1e-8, 1e-10] {
            let off = excess(width) / width.powf(2.0 / 3.0);
            assert!((0.25..0.3).contains(&off), "{width}: {off}");
        }
    }

    #[test]
    fn a_number_is_told_up_to_an_error_of_one_per_cent() {
        assert!(is_known(0.05, 4e-4) && !is_known(0.05, 6e-4) && is_known(0.0, 1e-10));
        assert!(!is_known(f64::NAN, 0.1) && !is_known(1.0, f64::NAN) && !is_known(1.0, f64::INFINITY));
    }
    /// Rows whose end the orbits of low dampings pass: from which damping on orbits stick is not known there.
    #[test]
    fn an_orbit_that_leaves_the_data_is_on_neither_side() {
        let rows = |number: u32| -> Vec<(f64, f64)> {
            let row = |i: u32| 1.0125 * f64::from(i) / 40.0;
            (0..number).map(row).map(|u| (u, 0.6 + 0.4 * (-2.0 * u).exp())).collect()
        };
        let column = |number: u32| {
            let law = Law::Table(Table::new("falls", &rows(number), 1.0).unwrap());
            law.column(&law.point(1.0, &[], 0.5, 0.0).unwrap())
        };
        let critical = critical_damping(&column(41), 1e-9).unwrap().c;
        let of = |number: u32, low: f64| {
            sticks_from(Effort::Whole, &column(number), [low, critical], HALVINGS, 1e-9)
        };
        let short = of(41, 0.29);
        // By another integration the law itself reaches the end of the data at c = 0.3162127; steps may pass it by 1e-5.
        assert!(short.between[0] == 0.29 && (short.between[1] - 0.316_212_7).abs() < 2e-5, "{short:?}");
        assert!(short.failure == Some(Failure::NotFinite) && short.known().is_none(), "{short:?}");
        for known in [of(80, 0.29), of(41, 0.317)] {
            assert!(known.between[0] == known.between[1] && known.failure.is_none(), "{known:?}");
        }
    }

    /// Falls in a thin layer, flat at rest or not steep, with a drop that carries orbits through it: no step passes over the
    /// layer. The dampings are those of Taylor series in 113-bit arithmetic. The orbit returns below c* and not above it.
    #[test]
    fn no_step_passes_over_a_thin_layer() {
        let built_in = |mu: f64, vs: f64, exponent: f64, belt_speed: f64, drop: f64| {
            let law = Law::Exponential.with_exponent().with_drop();
            law.column(&law.point(1.0, &[mu, vs, 0.0, exponent, drop], belt_speed, 0.0).unwrap())
        };
        let formula = |text: &str, belt_speed: f64| {
            let law = Law::Expression(Expression::with_static(text, 1.0).unwrap());
            law.column(&law.point(1.0, &[], belt_speed, 0.0).unwrap())
        };
        for (column, exact) in [
            (built_in(0.996, 1e-4, 2.0, 5.0, 0.3), 5.887_281_283_812_113e-4),
            (built_in(0.99, 1e-4, 2.0, 30.0, 0.02), 5.788_430_540_409_507e-7),
            (built_in(0.6, 1e-4, 3.0, 0.3, 0.3), 0.343_447_339_930_449_9),
            (built_in(0.996, 5e-5, 3.0, 5.0, 0.02), 5.088_645_717_225_951e-6),
            (built_in(0.6, 1e-5, 6.0, 1.0, 0.5), 0.098_158_999_617_322_41),
            (built_in(0.9, 5e-4, 10.0, 5.0, 0.1), 3.162_779_989_011_083e-4),
            (built_in(0.3, 3e-6, 10.0, 0.3, 0.02), 0.353_256_702_421_234_4),
            (formula("0.8 + 0.1*(1 - tanh((u/3e-5)^3))", 0.3), 0.059_792_322_826_909_4),
            (formula("0.89 + 0.01*exp(-(u/2e-4)^3)", 2.0), 5.012_155_238_129_539e-4),
        ] {
            for tolerance in [1e-9, 1e-12] {
                let found = critical_damping(&column, tolerance).unwrap();
                let rounding = 1e-15 * (1.0 + 1.0 / column.belt_speed) * exact;
                let missed = (found.c - exact).abs();
                assert!(missed <= found.error + rounding, "{found:?} {exact} off by {missed:e}");
                assert!(found.error <= 1e-8 * exact, "{found:?}");
            }
            for (share, returns) in [(0.9, true), (1.1, false)] {
                let fate = slipmap_orbits::flow(&Oscillator::in_column(&column, share * exact), 1e-9).fate;
                assert_eq!(matches!(fate, Fate::Sticks(_)), returns, "{exact} {share}: {fate:?}");
            }
        }
    }
}
