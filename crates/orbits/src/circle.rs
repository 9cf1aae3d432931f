//! The damping at which an orbit of Stribeck's law closes, for many orbits together: a spectral iteration on
//! equal angles.
//!
//! On the closed orbit through the maximum r = V of x2, ln(r/V) is a *periodic* function p of the angle with
//! p(0) = 0. That turns the root search into a small spectral problem without any stepping:
//! on M equal angles, sweep
//!
//! ```text
//! g = p'(theta; p, C),    C <- C - mean(g) / mean(dg/dC),    p <- antiderivative of g
//! ```
//!
//! by trigonometric interpolation, starting from the p of a coarser circle. The sweep converges fast because
//! p changes D only through D'(u), and the error falls geometrically with M because the orbit is analytic.
//! Orbits outside the domain of the polar form are refused.
//!
//! [`super::elements`] solves the same problem for every law, more slowly: in 17 microseconds a column near
//! the circle against 3 here, and in 85, with the law's compilation, far from it against 20 here.
//!
//! **Error of the sweeps.** Let delta be the residual of the equation after the last sweep: its g less the
//! slope of the p at which g was taken. It has zero mean. A small change delta of the right-hand side moves C
//! by the mean of W delta over that of W dg/dC, with the weight W = exp(integral of a from theta to 2 pi), a
//! = dg/dp: a change made at theta has grown or shrunk by that factor at the end of the turn. As delta has
//! zero mean, any constant may be subtracted from W, and the best one leaves half of its range:
//!
//! ```text
//! |error of C| <= (exp(R) - 1)/2 mean|delta| / mean|dg/dC|,    R = max(integral of a+, integral of a-)
//! ```
//!
//! up to the square of delta. The size of the last *correction* of C is not such a bound: it is a mean, and
//! passes through zero where p has not converged.
//!
//! **Error of the angles.** Estimated from three successive M, never from one, nor from two, which may agree
//! by chance.

use std::f64::consts::TAU;
use std::sync::{LazyLock, OnceLock};

use super::polar::{Angle, Closing, LANES, Lanes, Vector};
use slipmap_model::point::ScaledGroups;
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::elementary::exp;
use slipmap_numbers::{Aligned, vectorized};

/// A column that fails on one of this many coarsest circles, or on its first, is tried again on the next.
const RETRY_RUNGS: usize = 4;
/// Numbers of angles, coarse to fine.
const ANGLES: [usize; 11] = [8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256];
/// Number of sweeps on one set of angles after which the iteration counts as divergent.
const MOST_SWEEPS: u32 = 40;
/// Round-off of C, and of the residual, in units of the scale of C: sums of up to 256 terms of that size,
/// with random signs of error.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;
/// Error estimate of C in units of its change from the last circle: the error oscillates as it falls.
const LAST_CHANGE_WEIGHT: f64 = 8.0;
/// Error estimate of C in units of the change before the last: two circles may agree by chance, three do not.
const CHANGE_BEFORE_WEIGHT: f64 = 0.2;
/// Largest |ln(r/V)| that [`exp`] covers.
const LARGEST_LOG: f64 = 0.7;

/// Equal angles, and matrices for periodic functions that are sampled on them.
struct Circle {
    angles: Vec<Angle>,
    /// Matrix from a function of zero mean to its antiderivative that vanishes at angle 0.
    antiderivative: Vec<f64>,
    /// Matrix from a function on the next coarser circle to that function on this one; empty on the coarsest.
    interpolation: Vec<f64>,
}

impl Circle {
    fn new(size: usize, coarser: usize) -> Self {
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
        // The trigonometric interpolant of a unit sample, without the harmonic coarser/2, is Dirichlet's
        // kernel.
        let unit_sample = |i: usize, j: usize| match (i * coarser + (coarser - j) * size) % (size * coarser) {
            0 => (coarser - 1) as f64 / coarser as f64,
            place => {
                let half = 0.5 * TAU * place as f64 / (size * coarser) as f64;
                ((coarser - 1) as f64 * half).sin() / half.sin() / coarser as f64
            }
        };
        let pairs = (0..size).flat_map(|i| (0..coarser).map(move |j| (i, j)));
        Self { angles, antiderivative, interpolation: pairs.map(|(i, j)| unit_sample(i, j)).collect() }
    }

    fn of_rung(rung: usize) -> &'static Circle {
        static TABLES: LazyLock<[OnceLock<Circle>; ANGLES.len()]> = LazyLock::new(Default::default);
        let coarser = rung.checked_sub(1).map_or(0, |coarser| ANGLES[coarser]);
        TABLES[rung].get_or_init(|| Circle::new(ANGLES[rung], coarser))
    }
}

/// An upper bound on exp(x) - 1 for x >= 0, close to it for x < 8, infinite from 16 on: exp(y) <= (1 + y/2) /
/// (1 - y/2) for 0 <= y < 2.
#[inline(always)]
fn exp_m1_above(x: f64) -> f64 {
    let y = 0.0625 * x;
    // ((1 + y) / (1 - y))^8 - 1 by squarings that keep small values accurate.
    let mut expm1 = 2.0 * y / (1.0 - y);
    for _ in 0..3 {
        expm1 *= 2.0 + expm1;
    }
    if y < 1.0 { expm1 } else { f64::INFINITY }
}

/// Result of the sweeps on one circle.
struct Sweeps {
    /// Bound on the error of C that more sweeps would remove.
    left: Vector,
    /// Whether `left` is as small as requested, or at the level of round-off.
    settled: [bool; LANES],
    /// Whether the orbit stays in the domain of the polar form.
    inside: [bool; LANES],
    sweeps: u32,
}

/// Arrays of the sweeps, angle by angle; allocated once for many circles.
struct Workspace {
    /// ln(r/V) on the next coarser circle, with which the sweeps start.
    coarse: Vec<Vector>,
    log_r: Vec<Vector>,
    slope: Vec<Vector>,
    by_c: Vec<Vector>,
    /// The function whose antiderivative is `log_r`.
    fitted: Vec<Vector>,
}

impl Workspace {
    fn new() -> Self {
        let angles = || vec![Vector::default(); ANGLES[ANGLES.len() - 1]];
        let [coarse, log_r, slope, by_c, fitted] = std::array::from_fn(|_| angles());
        Self { coarse, log_r, slope, by_c, fitted }
    }
}

/// Sums over the angles of one sweep.
struct Sums {
    slope: Vector,
    by_c: Vector,
    /// R of the bound on the error, if requested.
    range: Vector,
    /// Distance from the border of the domain of the polar form.
    room: Vector,
}

/// Evaluates the equation on the orbit `log_r`.
#[inline(always)]
fn evaluate<const GROWTH: bool>(lanes: &Lanes, angles: &[Angle], workspace: &mut Workspace) -> Sums {
    let [mut mean, mut mean_by_c, mut growth, mut growth_size] = [Vector::default(); 4];
    let mut room = Vector::all(f64::INFINITY);
    let Workspace { log_r, slope, by_c, .. } = workspace;
    for (((angle, log_r), slope), by_c) in angles.iter().zip(log_r).zip(slope).zip(by_c) {
        let mut r = Vector::default();
        for lane in 0..LANES {
            r[lane] = exp::<3>(log_r[lane]);
            let left = LARGEST_LOG - log_r[lane].abs();
            room[lane] = if left < room[lane] { left } else { room[lane] };
        }
        let terms = lanes.log_slope::<GROWTH>(*angle, &r, &mut room);
        (*slope, *by_c) = (terms.slope, terms.by_c);
        for lane in 0..LANES {
            mean[lane] += slope[lane];
            mean_by_c[lane] += by_c[lane];
            if GROWTH {
                growth[lane] += terms.by_log_r[lane];
                growth_size[lane] += terms.by_log_r[lane].abs();
            }
        }
    }
    let step = TAU / angles.len() as f64;
    let range = Vector::from_fn(|lane| 0.5 * (growth_size[lane] + growth[lane].abs()) * step);
    Sums { slope: mean, by_c: mean_by_c, range, room }
}

/// `matrix`, row by row, times `from`.
#[inline(always)]
fn apply(matrix: &[f64], from: &[Vector], to: &mut [Vector]) {
    let columns = matrix.len() / to.len();
    for (row, to) in to.iter_mut().enumerate() {
        let mut sum = Vector::default();
        for (weight, from) in matrix[row * columns..][..columns].iter().zip(from) {
            for lane in 0..LANES {
                sum[lane] = from[lane].times_plus(*weight, sum[lane]);
            }
        }
        *to = sum;
    }
}

/// Sweeps the lanes on one circle, and updates C, until the error left in every C is below its `enough`.
#[inline(always)]
fn sweep(
    lanes: &mut Lanes,
    circle: &Circle,
    workspace: &mut Workspace,
    enough: &Vector,
    round_off: &Vector,
) -> Sweeps {
    let size = circle.angles.len();
    apply(&circle.interpolation, &workspace.coarse, &mut workspace.log_r[..size]);
    workspace.fitted[..size].fill(Vector::default());
    let mut settled = [false; LANES];
    let mut left = Vector::all(f64::INFINITY);
    let mut half_span = Vector::all(f64::INFINITY);
    let mut room = Vector::all(f64::INFINITY);
    let mut sweeps = 0_u32;
    while sweeps < MOST_SWEEPS {
        sweeps += 1;
        // R changes little from sweep to sweep, and less the more of them there are.
        let sums = if sweeps > 1 && sweeps.is_power_of_two() {
            let sums = evaluate::<true>(lanes, &circle.angles, workspace);
            half_span = Vector::from_fn(|lane| 0.5 * exp_m1_above(sums.range[lane]));
            sums
        } else {
            evaluate::<false>(lanes, &circle.angles, workspace)
        };
        room = sums.room;
        let change = Vector::from_fn(|lane| -sums.slope[lane] / sums.by_c[lane]);
        let Workspace { log_r, slope, by_c, fitted, .. } = workspace;
        let mut residual = Vector::default();
        for ((fitted, slope), by_c) in fitted[..size].iter_mut().zip(slope).zip(by_c) {
            for lane in 0..LANES {
                let better = by_c[lane].times_plus(change[lane], slope[lane]);
                residual[lane] += (better - fitted[lane]).abs();
                fitted[lane] = better;
            }
        }
        for lane in 0..LANES {
            lanes.c[lane] += change[lane];
            left[lane] = half_span[lane] * residual[lane] / sums.by_c[lane].abs();
            // Round-off of the residual stays, however many sweeps there are.
            settled[lane] = left[lane] <= enough[lane] + half_span[lane] * round_off[lane];
        }
        if sweeps > 1 && (0..LANES).all(|lane| settled[lane] || !(room[lane] > 0.0)) {
            break;
        }
        apply(&circle.antiderivative, fitted, &mut log_r[..size]);
    }
    let inside = std::array::from_fn(|lane| room[lane] > 0.0);
    Sweeps { left, settled, inside, sweeps }
}

/// The groups of an orbit at an estimate of the C at which it closes, and the size of its divergence, the unit of C.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    pub(super) groups: ScaledGroups,
    pub(super) unit: f64,
}

/// The C at which many orbits close, each with an error of at most `tolerance` times its
/// unit; `Err` with the number of evaluations outside the domain of the polar form, or without convergence.
pub(super) fn spectral(starts: &[Start], tolerance: f64) -> Vec<Result<Closing, u64>> {
    if starts.is_empty() {
        return Vec::new();
    }
    let mut workspace = Workspace::new();
    let mut answers = vec![Err(0); starts.len()];
    let mut changes = vec![f64::INFINITY; starts.len()];
    let mut waiting: Vec<usize> = Vec::new();
    // ln(r/V) on the last circle, of the columns that go on to the next.
    let mut orbits: Vec<Vec<f64>> = vec![Vec::new(); starts.len()];
    // From coarse to fine: a column begins at the first circle that resolves the pole of its divergence.
    let first: Vec<Option<usize>> = starts.iter().map(|start| first_rung(&start.groups)).collect();
    for rung in 0..ANGLES.len() {
        let circle = Circle::of_rung(rung);
        waiting.extend((0..starts.len()).filter(|&column| first[column] == Some(rung)));
        let mut still = Vec::new();
        for columns in waiting.chunks(LANES) {
            let of = |lane: usize| columns[lane.min(columns.len() - 1)];
            let coarser = circle.interpolation.len() / circle.angles.len();
            for (angle, coarse) in workspace.coarse.iter_mut().enumerate().take(coarser) {
                *coarse = Vector::from_fn(|lane| orbits[of(lane)].get(angle).map_or(0.0, |log_r| *log_r));
            }
            let units = Vector::from_fn(|lane| starts[of(lane)].unit);
            let enough = Aligned(units.map(|unit| 0.1 * tolerance * unit));
            let round_off = Aligned(units.map(|unit| ROUND_OFF * unit));
            let mut lanes = Lanes::new(|lane| {
                let Start { groups, .. } = starts[of(lane)];
                answers[of(lane)].map_or(groups, |Closing { viscous: c, .. }| ScaledGroups { c, ..groups })
            });
            let done = vectorized(
                #[inline(always)]
                || sweep(&mut lanes, circle, &mut workspace, &enough, &round_off),
            );
            for (lane, &column) in columns.iter().enumerate() {
                orbits[column].clear();
                let before = answers[column];
                let (Ok(Closing { rhs, .. }) | Err(rhs)) = before;
                let rhs = rhs + u64::from(done.sweeps) * circle.angles.len() as u64;
                let viscous = lanes.c[lane];
                if !(done.inside[lane] && done.settled[lane] && viscous.is_finite()) {
                    // A coarse circle may fail where a fine one does not, but a finer one would cost more
                    // than the search by orbits.
                    answers[column] = Err(rhs);
                    if rung < RETRY_RUNGS || Some(rung) == first[column] {
                        still.push(column);
                    }
                    continue;
                }
                let unit = units[lane];
                let change = before.map_or(f64::INFINITY, |before| (viscous - before.viscous).abs());
                let uncertain = (LAST_CHANGE_WEIGHT * change).max(CHANGE_BEFORE_WEIGHT * changes[column]);
                changes[column] = change;
                let error = uncertain + done.left[lane] + ROUND_OFF * unit;
                answers[column] = Ok(Closing { viscous, error, rhs, slope: None });
                if uncertain > (tolerance + 4.0 * LAST_CHANGE_WEIGHT * ROUND_OFF) * unit {
                    if rung + 1 < ANGLES.len() {
                        still.push(column);
                        let log_r = &workspace.log_r[..circle.angles.len()];
                        orbits[column].extend(log_r.iter().map(|log_r| log_r[lane]));
                    } else {
                        answers[column] = Err(rhs);
                    }
                }
            }
        }
        waiting = still;
    }
    answers
}

/// The coarsest circle that resolves the pole of the divergence, sqrt(2 / k) from the angle 0: on coarser ones
/// several in a row may agree on a wrong value. `None` if no circle does.
fn first_rung(groups: &ScaledGroups) -> Option<usize> {
    let fewest = (1.0 + groups.k).sqrt();
    ANGLES.iter().position(|&angles| angles as f64 >= fewest)
}
