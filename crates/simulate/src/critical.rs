//! The critical damping c* of a column: the root of the grazing margin.
//!
//! At c* the orbit from the exit point grazes the belt line: it closes with the maximum V of x2. The search
//! is that of `closing`; columns outside the domain of the polar form are searched with single orbits.

use std::cell::Cell;
use std::f64::consts::TAU;

use super::closing::{Amplitude, closing_dampings};
use super::polar::{Closing, Turn};
use super::quarters::{Sought, WIDE, closing_dampings_by_quarters};
use super::return_map::{UNRESOLVED, decisive_turn};
use super::{Failure, Fate, Landing, exit_orbit, flow};
use slipmap_model::filippov::{HopfRate, Oscillator};
use slipmap_model::friction::Column;
use slipmap_numbers::roots::{falling_bracket, falling_root};
use slipmap_numbers::text::{is_known, rounded};

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
    /// The engines gave no verdict where the search needed one.
    #[error("the simulated flow gives no verdict next to the boundary")]
    NoVerdict,
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
    let is_stribeck = |column: &Column| column.curve.stribeck().is_some();
    let mut found: Vec<Result<Closing, u64>> = vec![Err(0); columns.len()];
    let mut by_quarters: Vec<(usize, Sought)> = Vec::new();
    let mut smooth: Vec<(usize, Amplitude)> = Vec::new();
    for (number, column) in columns.iter().enumerate() {
        match if is_stribeck(column) { None } else { sought_by_quarters(column) } {
            Some(sought) => by_quarters.push((number, sought)),
            None => {
                smooth.push((number, Amplitude::new(&column.curve, column.belt_speed, column.belt_speed)))
            }
        }
    }
    let (numbers, orbits): (Vec<usize>, Vec<Amplitude>) = smooth.into_iter().unzip();
    for (number, closing) in numbers.into_iter().zip(closing_dampings(&orbits, tolerance, None)) {
        found[number] = closing;
    }
    let (numbers, sought): (Vec<usize>, Vec<Sought>) = by_quarters.into_iter().unzip();
    for (number, closing) in numbers.into_iter().zip(closing_dampings_by_quarters(&sought, tolerance)) {
        found[number] = closing;
    }
    let answer = |column: &Column, found: Result<Closing, u64>| match found {
        Ok(Closing { viscous, error, rhs, .. }) => {
            Ok(CriticalDamping { c: viscous / column.epsilon, error: error / column.epsilon, rhs })
        }
        Err(rhs) if column.curve.is_hidden_by_rounding(column.belt_speed) => Ok(hidden(column, rhs)),
        Err(rhs) => search(column, tolerance, rhs),
    };
    // An error delta of the weakening rate, of the samples of a function, moves eps c* by at most delta.
    let sampled = |column: &Column, found: CriticalDamping| CriticalDamping {
        error: found.error + column.curve.sampling_error() / column.epsilon,
        ..found
    };
    let answers = columns.iter().zip(found);
    answers.map(|(column, found)| answer(column, found).map(|found| sampled(column, found))).collect()
}

/// What is known of a fall that rounding hides from all orbits: the balance of energy, and that no orbit returns that is
/// damped critically.
fn hidden(column: &Column, rhs: u64) -> CriticalDamping {
    let balance = energy_balance(column);
    CriticalDamping { c: balance / column.epsilon, error: (2.0 + balance.abs()) / column.epsilon, rhs }
}

fn sought_by_quarters(column: &Column) -> Option<Sought<'_>> {
    let Column { curve, epsilon, belt_speed, .. } = column;
    let bounds = || search_bounds(column).map(|c| c * epsilon);
    Sought::from_exit(curve, *belt_speed, || energy_balance(column), bounds)
}

/// About eps c* by the balance of energy on the grazing circle, to first order in the weakening rate, with what the drop
/// supplies (theory, "Breakaway").
fn energy_balance(column: &Column) -> f64 {
    let Column { curve, belt_speed, .. } = column;
    let mean = curve.rough_mean_weakening(*belt_speed);
    let drop = of_drop(curve.drop() / belt_speed);
    // A law that falls steeply acts as one that drops. Where neither is small the cube root of the sum of cubes is next to
    // c*, found by trial.
    let steep = of_drop((1.0 - curve.phi(*belt_speed)) / belt_speed) - drop;
    let larger = mean.abs().max(steep.abs()).max(f64::MIN_POSITIVE);
    drop + larger * ((mean / larger).powi(3) + (steep / larger).powi(3)).cbrt()
}

/// About eps c* of friction that drops by j = `drop` V to a constant: from (V, -j) to (V, 0) v^2 + C v w + w^2 falls by the
/// factor exp(-C t), and the tangent of the phase is -(w + C v/2) / (omega v), omega^2 = 1 - C^2/4. At most 1.9: an orbit
/// that is damped critically, at C = 2, does not return.
fn of_drop(drop: f64) -> f64 {
    let next = |c: f64| {
        let omega = (1.0 - 0.25 * c * c).sqrt();
        let phase = TAU - (0.5 * c / omega).atan() - ((drop - 0.5 * c) / omega).atan();
        ((drop * (drop - c)).ln_1p() * omega / phase).min(1.9)
    };
    // Half of each change: whole ones swing about the solution where the drop is large.
    (0..3).fold(next(0.0), |c, _| 0.5 * (c + next(c)))
}

/// The critical damping of one column, see [`critical_dampings`].
///
/// # Errors
/// [`NoCriticalDamping`] where the flow gives no verdict next to the boundary.
pub fn critical_damping(column: &Column, tolerance: f64) -> Result<CriticalDamping, NoCriticalDamping> {
    critical_dampings(std::slice::from_ref(column), tolerance)[0]
}

/// The lowest damping in `[low, high]` from which the orbit from the exit point sticks, given that it sticks
/// just below `high`. Along c the fates have a fixed order: crossing, sticking, inward.
pub fn sticks_from(column: &Column, [low, high]: [f64; 2], tolerance: f64) -> f64 {
    let sticks = |c: f64| {
        let fate = flow(&Oscillator::in_column(column, c), tolerance).fate;
        !matches!(fate, Fate::CrossesForever | Fate::Failed(_))
    };
    if sticks(low) {
        return low;
    }
    let (mut low, mut high) = (low, high);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if sticks(middle) { &mut high } else { &mut low }) = middle;
    }
    high
}

/// Two dampings around c*, by the even part of the divergence (theory, "The tests"), widened a little. With a
/// drop c* may be larger: D <= -2 at all slip speeds that the orbit can reach excludes a return.
fn bounds(column: &Column) -> [f64; 2] {
    let mut range = column.curve.even_weakening_range(column.belt_speed);
    let drop = column.curve.drop();
    if drop > 0.0 {
        let fastest = column.belt_speed + column.belt_speed.hypot(drop);
        range.hi = column.curve.weakening_range(0.0, fastest).hi + 2.0;
    }
    let width = (range.hi - range.lo).abs() / column.epsilon;
    let pad = 1e-6 * width + 1e-12 * (range.hi.abs() + range.lo.abs()) / column.epsilon;
    [range.lo / column.epsilon - pad, range.hi / column.epsilon + pad]
}

/// Two dampings between which c* is sought: [`bounds`], or where nothing proves any, such as of laws given as
/// functions, some that lie far around the balance of energy.
fn search_bounds(column: &Column) -> [f64; 2] {
    let [low, high] = bounds(column);
    let far = |sign: f64| {
        let balance = energy_balance(column);
        (balance + sign * WIDE * (1.0 + balance.abs())) / column.epsilon
    };
    [if low.is_finite() { low } else { far(-1.0) }, if high.is_finite() { high } else { far(1.0) }]
}

/// Number of bisections for the damping from which orbits stick.
const HALVINGS: u32 = 40;

/// Work after which the search of a column ends, in evaluations of the right-hand side of the Stribeck law.
/// Only orbits so stiff that one takes a million reach it. The check of the result may take as much again.
const WORK: u64 = 4_000_000;
/// Tolerance of the orbits of the search, and of those that check its result.
const COARSE: f64 = 1e-8;
const FINE: f64 = 1e-12;
/// Belt speeds below this are not searched: orbits leave the normal numbers, where they take ten times as
/// long.
const SLOWEST: f64 = 1e-290;
/// Width of the bracket of c*, relative to it, to which a search goes on where its tolerance leaves more; each
/// time it finds c* anew.
const RELATIVE: f64 = 1e-4;
const REFINEMENTS: u32 = 4;
/// Largest error of a critical damping whose search ended early, relative to the range of the weakening rate.
const UNFINISHED: f64 = 1e-3;

/// The side of c* on which a damping lies, by the orbit from the exit point.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// Positive below c*, negative above it, 0 if the orbit is too close to call: the grazing margin, or a
    /// number of its size.
    margin: f64,
    error: f64,
    /// Number of evaluations of the right-hand side.
    rhs: u64,
    /// The evaluations in units of those of the Stribeck law.
    work: u64,
}

/// Follows the orbit from the exit point at one damping; `None` where no engine decides. The return map is left out
/// where it was undecided at the last damping, as it usually is at the next.
fn side_of(column: &Column, c: f64, tolerance: f64, turns_decide: &mut bool) -> Option<Side> {
    let oscillator = Oscillator::in_column(column, c);
    let by_turn = if *turns_decide { side_by_turn(&oscillator, tolerance) } else { Err(0) };
    *turns_decide = by_turn.is_ok();
    match by_turn {
        Ok(side) => Some(side),
        Err(spent) => side_by_flow(column, &oscillator, tolerance, spent),
    }
}

/// Finds the side by the return map; `Err` with the number of evaluations where it is undecided.
fn side_by_turn(oscillator: &Oscillator, tolerance: f64) -> Result<Side, u64> {
    match decisive_turn(oscillator, tolerance) {
        // Where a law's polynomials are inaccurate, the orbit that follows the law itself has a smaller
        // error.
        Turn::Complete { margin, error, rhs } if margin.abs() > error || error <= UNRESOLVED => {
            let size = if margin.abs() > error { margin.clamp(-1.0, 1.0) } else { 0.0 };
            Ok(Side { margin: size, error, rhs: rhs.into(), work: rhs.into() })
        }
        Turn::Complete { rhs, .. } | Turn::HandOver { rhs } => Err(rhs.into()),
    }
}

/// Finds the side by arcs, after `spent` evaluations.
fn side_by_flow(column: &Column, oscillator: &Oscillator, tolerance: f64, spent: u64) -> Option<Side> {
    let flow = exit_orbit::flow(oscillator, tolerance);
    let margin = match flow.fate {
        // Far beyond the line r at the landing is about what it would be after the turn.
        Fate::Sticks(Landing { x1, crossings, .. }) if flow.margin.is_nan() && crossings != Some(1) => {
            let speed = (oscillator.exit_x1() - x1 - oscillator.drop()) / column.belt_speed;
            (speed * speed / (1.0 + speed.hypot(1.0))).clamp(f64::MIN_POSITIVE, 1.0)
        }
        _ => flow.signed_margin()?,
    };
    let work = spent + flow.rhs * column.curve.cost();
    Some(Side { margin, error: flow.margin_error, rhs: spent + flow.rhs, work })
}

/// Whether the orbit from the exit point leaves the slip speeds at which the law is known.
fn leaves_data(column: &Column, c: f64) -> bool {
    column.curve.fastest().is_finite()
        && exit_orbit::flow(&Oscillator::in_column(column, c), COARSE).fate
            == Fate::Failed(Failure::NotFinite)
}

/// Searches a column with the simulated flow, which also decides overdamped points.
fn search(column: &Column, tolerance: f64, rhs: u64) -> Result<CriticalDamping, NoCriticalDamping> {
    if column.belt_speed < SLOWEST {
        return Err(NoCriticalDamping::NoVerdict);
    }
    // Bounds that differ by rounding alone are the answer, as for flat friction.
    let [low, mut high] = search_bounds(column);
    if !(low.is_finite() && high.is_finite()) {
        return Err(NoCriticalDamping::NoVerdict);
    }
    let rounding = HopfRate::new(&column.curve, column.belt_speed).rounding();
    if column.epsilon * (high - low) <= rounding {
        return Ok(CriticalDamping { c: 0.5 * (low + high), error: 0.5 * (high - low), rhs });
    }
    let (mut rhs, mut work) = (rhs, 0);
    // Error of the margin of an orbit that is too close to call.
    let undecided = Cell::new(0.0);
    // The nearest dampings known to lie below and above c*.
    let known = Cell::new([f64::NEG_INFINITY, f64::INFINITY]);
    let mut turns_decide = true;
    let mut follow = |c: f64, tolerance: f64, most: u64| {
        if work > most {
            return Err(NoCriticalDamping::NoVerdict);
        }
        let side = side_of(column, c, tolerance, &mut turns_decide).ok_or(NoCriticalDamping::NoVerdict)?;
        rhs += side.rhs;
        work += side.work;
        Ok(side)
    };
    let mut margin = |c: f64| {
        let mut side = match follow(c, COARSE, WORK) {
            // It lies outside those of higher damping. If c* were below, its orbit would leave the data, too, and the
            // check of the result has no verdict.
            Err(_) if leaves_data(column, c) => return Ok(1.0),
            side => side?,
        };
        if side.margin == 0.0 {
            side = follow(c, FINE, WORK)?;
        }
        let [below, above] = known.get();
        if side.margin > 0.0 {
            known.set([below.max(c), above]);
        } else if side.margin < 0.0 {
            known.set([below, above.min(c)]);
        } else {
            undecided.set(side.error);
        }
        Ok(side.margin)
    };
    // The signs at the bounds are checked nevertheless. The undamped orbit of a table may leave its data where orbits near c* do not: a failure is ignored.
    if low < 0.0 && high > 0.0 && margin(0.0).is_ok_and(|margin| margin < 0.0) {
        high = 0.0;
    }
    let from = if high > 0.0 { low.max(0.0) } else { low };
    let mean = energy_balance(column) / column.epsilon;
    let start = if mean.is_finite() { mean.clamp(from, high) } else { 0.5 * (from + high) };
    let mut enough = tolerance.max(4.0 * f64::EPSILON) * (low.abs() + high.abs());
    let widest = Cell::new([from, high]);
    let first_step = 0.1 * start.abs() + 1e-3 * (high - from);
    let found = falling_bracket([start, first_step], [from, high], &mut margin).and_then(|bracket| {
        let bracket = bracket.ok_or(NoCriticalDamping::NoVerdict)?;
        widest.set([bracket.low.0, bracket.high.0]);
        falling_root(bracket, enough, &mut margin)
    });
    let (mut c, mut bracket) = match found {
        Ok(found) => found,
        Err(why) => {
            // The bounds by the orbits that were followed.
            let [below, above] = known.get();
            let (c, error) = (0.5 * (below + above), above - below);
            return match error <= UNFINISHED * (low.abs() + high.abs()) {
                true => Ok(CriticalDamping { c, error, rhs }),
                false => Err(why),
            };
        }
    };
    // The divergence of a steep law is far larger than its c*, of which the tolerance leaves nothing then.
    for _ in 0..REFINEMENTS {
        let finer = RELATIVE * c.abs();
        if enough <= finer || undecided.get() > 0.0 {
            break;
        }
        let Ok(found) = falling_root(bracket, finer, &mut margin) else { break };
        ((c, bracket), enough) = (found, finer);
    }
    // The resolution of the flow limits the error, though a secant may have left the other end of the bracket
    // far away: the error is the distance of the nearest dampings, on either side, that the flow
    // distinguishes at the fine tolerance.
    let mut near = (2.0 * undecided.get() / bracket.steepness()).max(enough);
    let [lowest, highest] = widest.get();
    let mut fine = |c: f64| Ok(follow(c, FINE, 2 * WORK)?.margin);
    loop {
        let told_below = c - near <= lowest || fine(c - near)? > 0.0;
        let told_above = c + near >= highest || fine(c + near)? < 0.0;
        if told_below && told_above {
            return Ok(CriticalDamping { c, error: near.min(highest - lowest), rhs });
        }
        near *= 2.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Law, Table};

    /// Friction that drops to a constant: the search begins next to c*, of which phi(V) as rounded tells nothing more.
    #[test]
    fn the_balance_of_a_drop_is_next_to_its_critical_damping() {
        for drop in (1..100).map(|percent| f64::from(percent) / 100.0) {
            for belt_speed in [0.01, 0.1, 0.3, 1.0, 3.0] {
                let point = Law::Coulomb.point(1.0, &[drop, 0.0], belt_speed, 0.0).unwrap();
                let column = Law::Coulomb.column(&point);
                let (balance, found) = (energy_balance(&column), critical_damping(&column, 1e-9).unwrap());
                assert!((balance / found.c - 1.0).abs() < 0.05, "{drop} {belt_speed}: {balance} {found:?}");
            }
        }
    }

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
}
