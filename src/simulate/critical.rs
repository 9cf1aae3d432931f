//! The critical damping c* of a column: where the grazing margin vanishes.
//!
//! At c* the orbit from the exit point grazes the belt line, so ln(r/V) is a *periodic* function p of the
//! angle with p(0) = 0. That turns the root search into a small spectral problem without any stepping:
//! on M equal angles, sweep
//!
//! ```text
//! g = p'(theta; p, C),    C <- C - mean(g) / mean(dg/dC),    p <- antiderivative of g
//! ```
//!
//! by trigonometric interpolation. The sweep contracts fast because p moves D only through D'(u), and the
//! error falls geometrically with M because the orbit is analytic. Convergence is judged by two successive
//! M, never by one. Columns outside the domain of the polar form are searched with [`flow`].

use std::cell::Cell;
use std::f64::consts::TAU;
use std::sync::{LazyLock, OnceLock};

use super::polar::{Angle, LANES, Lanes};
use super::{Fate, flow, general};
use crate::filippov::Oscillator;
use crate::friction::Column;
use crate::point::ScaledGroups;

/// A column that leaves the domain of the polar form is tried again on this many further circles.
const RETRY_RUNGS: usize = 4;
/// Numbers of angles, coarse to fine.
const ANGLES: [usize; 11] = [8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256];
/// Sweeps on one set of angles after which the iteration is taken to diverge.
const MOST_SWEEPS: u32 = 40;
/// Round-off of C in units of its scale: sums of up to 256 terms of that size, with random signs of error.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;
/// Error estimate of C in units of its change from the last circle: the error oscillates as it falls.
const LAST_CHANGE_WEIGHT: f64 = 8.0;
/// And in units of the change before: two circles may agree by chance, three do not.
const CHANGE_BEFORE_WEIGHT: f64 = 0.2;
/// Largest |ln(r/V)| that [`exp`] covers.
const LARGEST_LOG: f64 = 0.7;

/// The critical damping of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalDamping {
    /// c*: the orbit from the exit point comes back to the belt line for c < c* and not for c > c*.
    /// Negative where it does not come back for any legal damping.
    pub c: f64,
    /// Estimate of the absolute error of `c`.
    pub error: f64,
    /// Evaluations of the right-hand side.
    pub rhs: u64,
}

/// Why a column has no critical damping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoCriticalDamping {
    /// The engines gave no verdict where the search needed one.
    #[error("the simulated flow gives no verdict next to the boundary")]
    NoVerdict,
}

/// What the spectral iteration found.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Spectral {
    /// C* and its error estimate.
    Root { viscous: f64, error: f64, rhs: u64 },
    /// Outside the domain of the polar form, or no convergence.
    NoAnswer { rhs: u64 },
}

/// Angles of one size and the matrix that maps a periodic function of zero mean, sampled on them, to its
/// antiderivative that vanishes at angle 0.
struct Circle {
    angles: Vec<Angle>,
    antiderivative: Vec<f64>,
}

impl Circle {
    fn new(size: usize) -> Self {
        let theta = |i: usize| TAU * (i % size) as f64 / size as f64;
        let angles = (0..size).map(|i| Angle::new(theta(i))).collect();
        // The trigonometric interpolant of a unit sample at j is a sum of cos k(x - x_j) over the harmonics
        // k; integrated from 0 to x_i it is h(i - j) + h(j). The harmonic size/2 cannot be integrated here.
        let h: Vec<f64> = (0..size)
            .map(|d| {
                let sum: f64 = (1..size / 2).rev().map(|k| theta(k * d).sin() / k as f64).sum();
                2.0 * sum / size as f64
            })
            .collect();
        let antiderivative = (0..size)
            .flat_map(|i| (0..size).map(move |j| (i, j)))
            .map(|(i, j)| h[(size + i - j) % size] + h[j])
            .collect();
        Self { angles, antiderivative }
    }

    fn of_rung(rung: usize) -> &'static Circle {
        static TABLES: LazyLock<[OnceLock<Circle>; ANGLES.len()]> = LazyLock::new(Default::default);
        TABLES[rung].get_or_init(|| Circle::new(ANGLES[rung]))
    }
}

/// exp(x) for |x| <= [`LARGEST_LOG`] to about an ulp: Taylor series of exp(x/8) to degree 9, cubed in twos.
#[inline(always)]
fn exp(x: f64) -> f64 {
    let y = 0.125 * x;
    let mut sum = 1.0 / 362_880.0;
    for inverse_factorial in
        [1.0 / 40_320.0, 1.0 / 5_040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0]
    {
        sum = y.mul_add(sum, inverse_factorial);
    }
    // expm1 keeps the accuracy of small arguments through the squarings: e(2y) = e(y) (2 + e(y)).
    let mut expm1 = y * sum;
    for _ in 0..3 {
        expm1 *= 2.0 + expm1;
    }
    1.0 + expm1
}

/// Result of the sweeps on one circle.
struct Sweeps {
    /// Size of the last correction of C.
    change: [f64; LANES],
    room: [f64; LANES],
    sweeps: u32,
}

/// Sweeps the lanes on one circle until every correction of C is below its lane's `enough`, C in place.
#[inline(always)]
fn sweep(lanes: &mut Lanes, circle: &Circle, enough: &[f64; LANES]) -> Sweeps {
    let size = circle.angles.len();
    let mut log_r = [[0.0_f64; LANES]; 256];
    let mut slope = [[0.0_f64; LANES]; 256];
    let mut by_c = [[0.0_f64; LANES]; 256];
    let mut change = [f64::INFINITY; LANES];
    let mut room = [f64::INFINITY; LANES];
    let mut sweeps = 0;
    while sweeps < MOST_SWEEPS {
        sweeps += 1;
        room = [f64::INFINITY; LANES];
        let (mut mean, mut mean_by_c) = ([0.0_f64; LANES], [0.0_f64; LANES]);
        for i in 0..size {
            let mut r = [0.0; LANES];
            for lane in 0..LANES {
                r[lane] = exp(log_r[i][lane]);
                let left = LARGEST_LOG - log_r[i][lane].abs();
                room[lane] = if left < room[lane] { left } else { room[lane] };
            }
            (slope[i], by_c[i]) = lanes.log_slope(circle.angles[i], &r, &mut room);
            for lane in 0..LANES {
                mean[lane] += slope[i][lane];
                mean_by_c[lane] += by_c[i][lane];
            }
        }
        for lane in 0..LANES {
            change[lane] = -mean[lane] / mean_by_c[lane];
        }
        lanes.shift_damping(&change);
        // The first sweep sees the unperturbed circle, whatever its size: only from the second on does a
        // small change mean convergence.
        if sweeps > 1 && (0..LANES).all(|lane| !(change[lane].abs() > enough[lane]) || !(room[lane] > 0.0)) {
            break;
        }
        for i in 0..size {
            for lane in 0..LANES {
                slope[i][lane] = by_c[i][lane].mul_add(change[lane], slope[i][lane]);
            }
        }
        for (row, log_r) in circle.antiderivative.chunks_exact(size).zip(&mut log_r) {
            let mut sum = [0.0_f64; LANES];
            for (weight, slope) in row.iter().zip(&slope) {
                for lane in 0..LANES {
                    sum[lane] = slope[lane].mul_add(*weight, sum[lane]);
                }
            }
            *log_r = sum;
        }
    }
    Sweeps { change, room, sweeps }
}

/// Carries [`sweep`] into the function whose vector width pulp picks at run time.
struct Dispatched<'a> {
    lanes: &'a mut Lanes,
    circle: &'a Circle,
    enough: &'a [f64; LANES],
}

impl pulp::WithSimd for Dispatched<'_> {
    type Output = Sweeps;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Sweeps {
        sweep(self.lanes, self.circle, self.enough)
    }
}

/// C* of many scaled oscillators, started at the C in `starts`, with an error of at most `tolerance`
/// times their divergence scale A.
fn spectral(starts: &[ScaledGroups], tolerance: f64) -> Vec<Spectral> {
    let arch = pulp::Arch::new();
    let mut answers = vec![Spectral::NoAnswer { rhs: 0 }; starts.len()];
    let mut changes = vec![f64::INFINITY; starts.len()];
    let mut waiting: Vec<usize> = (0..starts.len()).collect();
    for rung in 0..ANGLES.len() {
        let circle = Circle::of_rung(rung);
        let mut still = Vec::new();
        for columns in waiting.chunks(LANES) {
            let of = |lane: usize| columns[lane.min(columns.len() - 1)];
            let starts: [ScaledGroups; LANES] = std::array::from_fn(|lane| {
                let start = starts[of(lane)];
                match answers[of(lane)] {
                    Spectral::Root { viscous, .. } => ScaledGroups { c: viscous, ..start },
                    Spectral::NoAnswer { .. } => start,
                }
            });
            let enough: [f64; LANES] =
                std::array::from_fn(|lane| (0.1 * tolerance).max(ROUND_OFF) * scale(&starts[lane]));
            let mut lanes = Lanes::new(|lane| &starts[lane]);
            let done = arch.dispatch(Dispatched { lanes: &mut lanes, circle, enough: &enough });
            for (lane, &column) in columns.iter().enumerate() {
                let (before, rhs) = match answers[column] {
                    Spectral::Root { viscous, rhs, .. } => (Some(viscous), rhs),
                    Spectral::NoAnswer { rhs } => (None, rhs),
                };
                let rhs = rhs + u64::from(done.sweeps) * circle.angles.len() as u64;
                let viscous = lanes.damping()[lane];
                let inside = done.room[lane] > 0.0 && viscous.is_finite();
                if !inside || !(done.change[lane].abs() <= enough[lane]) {
                    // A coarse circle may fail where a fine one does not, but a finer one will cost more
                    // than the search that takes over.
                    answers[column] = Spectral::NoAnswer { rhs };
                    if rung < RETRY_RUNGS {
                        still.push(column);
                    }
                    continue;
                }
                let unit = scale(&starts[lane]);
                let change = before.map_or(f64::INFINITY, |before| (viscous - before).abs());
                let uncertain = (LAST_CHANGE_WEIGHT * change).max(CHANGE_BEFORE_WEIGHT * changes[column]);
                changes[column] = change;
                let error = uncertain + enough[lane] + ROUND_OFF * unit;
                answers[column] = Spectral::Root { viscous, error, rhs };
                if uncertain > (tolerance + 4.0 * LAST_CHANGE_WEIGHT * ROUND_OFF) * unit {
                    if rung + 1 < ANGLES.len() {
                        still.push(column);
                    } else {
                        answers[column] = Spectral::NoAnswer { rhs };
                    }
                }
            }
        }
        waiting = still;
    }
    answers
}

/// Size of the divergence along a grazing orbit, the natural unit of C.
fn scale(groups: &ScaledGroups) -> f64 {
    groups.a.max(groups.b).max(f64::MIN_POSITIVE)
}

/// The critical damping of many columns.
///
/// `tolerance` is relative to the size of the divergence: about the error of the scaled grazing margin
/// that the error of c* amounts to.
#[must_use]
pub fn critical_dampings(
    columns: &[Column],
    tolerance: f64,
) -> Vec<Result<CriticalDamping, NoCriticalDamping>> {
    let scaled = |column: &Column| {
        let law = column.curve.stribeck()?;
        Some(law.scaled(column.belt_speed, column.curve.mean_weakening(column.belt_speed)))
    };
    // The vectorised search knows the Stribeck law; other columns go one by one.
    let starts: Vec<ScaledGroups> = columns.iter().filter_map(scaled).collect();
    let mut vectorised = spectral(&starts, tolerance).into_iter();
    let answer = |column: &Column| {
        let is_stribeck = column.curve.stribeck().is_some();
        let answer = match is_stribeck.then(|| vectorised.next()).flatten() {
            Some(Spectral::Root { viscous, error, rhs }) => {
                let (c, error) = (viscous / column.epsilon, error / column.epsilon);
                Ok(CriticalDamping { c, error, rhs })
            }
            Some(Spectral::NoAnswer { rhs }) => Err(rhs),
            None => general::critical_damping(column, tolerance),
        };
        answer.or_else(|rhs| search(column, tolerance, rhs))
    };
    columns.iter().map(answer).collect()
}

/// The critical damping of one column, see [`critical_dampings`].
///
/// # Errors
/// [`NoCriticalDamping`] where the flow gives no verdict next to the boundary.
pub fn critical_damping(column: &Column, tolerance: f64) -> Result<CriticalDamping, NoCriticalDamping> {
    critical_dampings(std::slice::from_ref(column), tolerance)[0]
}

/// Searches a column with the simulated flow, which decides overdamped points too: the ITP method of
/// Oliveira and Takahashi (ACM Trans. Math. Softw. 47, 2020), which is as fast as the secant where the margin
/// is smooth and never slower than bisection where only its sign is known.
fn search(column: &Column, tolerance: f64, rhs: u64) -> Result<CriticalDamping, NoCriticalDamping> {
    let mut rhs = rhs;
    // Error of the margin where it leaves the sign open.
    let undecided = Cell::new(0.0);
    let mut margin = |c: f64| {
        let answer = flow(&Oscillator::in_column(column, c), tolerance.max(1e-12));
        rhs += answer.rhs;
        let size = if answer.margin.is_finite() { answer.margin.abs().min(1.0) } else { 1.0 };
        match answer.fate {
            Fate::Sticks(_) | Fate::CrossesForever => Ok(size),
            Fate::SpiralsInward => Ok(-size),
            Fate::TooCloseToCall => {
                undecided.set(answer.margin_error);
                Ok(0.0)
            }
            Fate::Failed(_) => Err(NoCriticalDamping::NoVerdict),
        }
    };
    // The even part of the divergence brackets the root (theory, "The tests"); signs are checked all the same.
    let range = column.curve.even_weakening_range(column.belt_speed);
    let width = (range.hi - range.lo).abs() / column.epsilon;
    let pad = 1e-6 * width + 1e-12 * (range.hi.abs() + range.lo.abs()) / column.epsilon;
    let (mut low, mut high) = (range.lo / column.epsilon - pad, range.hi / column.epsilon + pad);
    if low < 0.0 && high > 0.0 && margin(0.0)? < 0.0 {
        // No legal damping is small enough: how negative c* is concerns nobody.
        return Ok(CriticalDamping { c: 0.5 * low, error: -0.5 * low, rhs });
    }
    let (mut at_low, mut at_high) = (margin(low)?, margin(high)?);
    if at_low < 0.0 || at_high > 0.0 {
        return Err(NoCriticalDamping::NoVerdict);
    }
    let enough = tolerance.max(4.0 * f64::EPSILON) * (low.abs() + high.abs());
    let truncation = 0.2 / (high - low);
    // Half the width that bisection alone would leave, with one step to spare.
    let mut allowance = high - low;
    while high - low > enough {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        let secant = (at_low * high - at_high * low) / (at_low - at_high);
        let towards = (middle - secant).signum();
        let shift = truncation * (high - low) * (high - low);
        let moved = if shift <= (middle - secant).abs() { secant + towards * shift } else { middle };
        let reach = (allowance - 0.5 * (high - low)).max(0.0);
        allowance *= 0.5;
        let next = if (moved - middle).abs() <= reach { moved } else { middle - towards * reach };
        // Round-off must not let the secant stand still on an end.
        let next = if next > low && next < high { next } else { middle };
        match margin(next)? {
            found if found > 0.0 => (low, at_low) = (next, found),
            found if found < 0.0 => (high, at_high) = (next, found),
            _ => {
                // As near as the flow sees, though a secant may have left the other end far behind: c* is as
                // near as the next dampings, on either side, that it tells apart.
                let slope = (at_low - at_high) / (high - low);
                let mut near = (2.0 * undecided.get() / slope).max(enough);
                while near < high - low {
                    let told_below = next - near <= low || margin(next - near)? > 0.0;
                    let told_above = next + near >= high || margin(next + near)? < 0.0;
                    if told_below && told_above {
                        return Ok(CriticalDamping { c: next, error: near, rhs });
                    }
                    near *= 2.0;
                }
                return Ok(CriticalDamping { c: next, error: high - low, rhs });
            }
        }
    }
    Ok(CriticalDamping { c: 0.5 * (low + high), error: high - low, rhs })
}
