//! The number of slip cycles, proved round-off included where the proof succeeds.
//!
//! The return map P of `slip_cycle` takes a maximum r of x2 to the next one; the slip cycles are its
//! fixed points in (0, V), the zeros of g = ln(P(r) / r). The interval (0, V] is cut into pieces, and for
//! each piece one of two things is proved: g has one sign there, so that it holds no cycle; or g is strictly
//! monotone there, so that it holds at most one cycle, and exactly one where g has opposite signs at its
//! ends. Pieces without a proof are listed.
//!
//! # Statements
//! **Polar form.** With x2 = r cos th, x2' = -r sin th, rho = ln r and D = D(V - r cos th),
//!
//! ```text
//! rho' = F(th, rho) = D sin^2 th / (1 + D sin th cos th),    g(rho(0)) = rho(2 pi) - rho(0),
//! ```
//!
//! as long as 1 + D sin th cos th > 0. Where an orbit reaches the belt line, r cos th > V, it is continued by
//! the formula of the law at slip speeds below zero. A zero of g in (0, V) is a slip cycle for any
//! continuation, because x2 falls on (0, pi) and rises on (pi, 2 pi) to P(r): an orbit with P(r) = r < V
//! never uses the continuation.
//!
//! **Slope.** psi = d rho(2 pi) / d rho(0) is (r / P)^2 exp(integral of D dt) by Liouville's formula, so that
//!
//! ```text
//! dg/d rho(0) = e^h - 1,    h = integral over a turn of H,    H(th, rho) = D cos 2 th / (1 + D sin th cos th).
//! ```
//!
//! It contains no derivative of D, and the sign of h is that of the slope of g.
//!
//! **One orbit.** The steps of `crates/certify/src/enclosure.rs` in th, with rho for y, enclose rho and the integral of H.
//! The region where the orbit may be is guessed, and confirmed by the bound on its distance from the
//! polynomial.
//!
//! **All orbits of a piece.** Let w be its half-width in rho(0). The same bound, begun at w, holds for their
//! distance from the polynomial. With L over that tube, psi up to th is at most exp(integral of L), and so
//!
//! ```text
//! |h - h_m| <= w K,    |g - g_m| <= w max |e^(h_m +- w K) - 1|,    K = integral of max |dH/drho| max psi,
//! ```
//!
//! with g_m and h_m those of the piece's middle. A piece is decided if one of these excludes zero, and is
//! bisected otherwise.
//!
//! **Near the equilibrium** pieces would shrink with r. There the even part in v of D(V - v), |v| <= r,
//! decides: where it has one sign, g has that sign on (0, r] (the theorem of
//! `slip_cycle::none_proved`).
//!
//! **Laws that bend one way.** Where the weakening rate is convex, or concave, over the slip speeds of slip cycles
//! there is at most one (theory, "At most one slip cycle"). Beyond the amplitudes next to the equilibrium one
//! sign of g is then enough, that at V.
//!
//! The law is the stored curve: its coefficients, such as 1 - alpha, are rounded once when it is made. A
//! measured law has no formula and D has corners: only the statement by the even part is proved for it.

use std::f64::consts::TAU;

use crate::enclosure::{Polar, Polynomial, distance};
use slipmap_model::filippov::{Oscillator, Stability};
use slipmap_model::friction::Range;
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real};

/// Longest and shortest step.
const STEPS: [f64; 2] = [0.25, 1e-3];
/// Shortest step for a piece: if confirming the guess needs a shorter one, the piece is too wide.
const SHORTEST_OF_PIECE: f64 = 0.03;
/// Least and greatest target defect of a step, relative to |D|; between these limits it is small compared
/// with the square of the piece's width.
const DEFECTS: [f64; 2] = [1e-8, 1e-5];
/// Least dth/dt.
const SLOWEST_TURN: f64 = 0.05;
/// Largest number of steps, after which the rest stays open: half a second; most counts need a tenth of it.
const BUDGET: u32 = 20_000;
/// Ratio of the radii at the ends of the first pieces.
const WIDEST: f64 = 1.5;
/// Pieces shorter than this in ln r stay open.
const SHORTEST: f64 = 1e-3;
/// Smallest radius, relative to V, at which the sign of the even part is computed.
const INNERMOST: f64 = 1e-4;
/// Ratio of successive radii at which that sign is computed.
const NEXT_RADIUS: f64 = 0.8;
/// What is small compared with the square of a piece's width, and with the target of a defect. Defects and guesses
/// of tubes are bounded where they are used: they decide how much work a proof takes, not what it states.
const SMALL: f64 = 0.01;
/// Divergences below this are not followed: squares of round-off times them leave the normal numbers, where
/// enclosures are too wide and operations take ten times as long.
const LEAST_DIVERGENCE: f64 = 1e-270;

/// Proved bounds on the number of slip cycles.
#[derive(Clone, Debug, PartialEq)]
pub struct SlipCount {
    /// Lower bound.
    pub at_least: u32,
    /// Upper bound; `None` where there is none.
    pub at_most: Option<u32>,
    /// Ranges of the maximum of x2 in which nothing is proved: further cycles may lie there.
    pub open: Vec<Range>,
}

impl SlipCount {
    /// The number, where it is proved.
    #[must_use]
    pub fn exact(&self) -> Option<u32> {
        self.at_most.filter(|most| *most == self.at_least)
    }
}

/// Proved property of g on a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// One sign: all turns lead outward, or all inward.
    Sign(bool),
    /// Strictly rising, or falling.
    Monotone(bool),
    /// At most one zero.
    OneZero,
    /// Nothing.
    Open,
}

impl Shape {
    fn sign(self) -> Option<bool> {
        if let Self::Sign(outward) = self { Some(outward) } else { None }
    }
}

#[derive(Clone, Copy, Debug)]
struct Piece {
    from: f64,
    to: f64,
    shape: Shape,
}

/// Returns whether a count of the slip cycles proves that the orbit from the exit point does not return to
/// the belt line: there is none, the equilibrium attracts, and friction does not drop as slip begins.
///
/// **Proof.** g has no zero on (0, V], and is negative near 0. So it is negative at V. [] The orbit from the exit
/// point starts there without a drop; with one it starts outside.
pub fn proves_absence(oscillator: &Oscillator, count: &SlipCount) -> bool {
    count.exact() == Some(0)
        && oscillator.stability() == Stability::Attracts
        && oscillator.drop() == 0.0
        && oscillator.curve.is_normal()
}

/// Counts the slip cycles with proof.
#[must_use]
pub fn count_slip_cycles(oscillator: &Oscillator) -> SlipCount {
    let belt_speed = oscillator.belt_speed;
    if oscillator.curve.formula(0.0).is_none() {
        let even = oscillator.curve.even_weakening_range(belt_speed);
        return match even.excludes(oscillator.viscous) {
            true => SlipCount { at_least: 0, at_most: Some(0), open: Vec::new() },
            false => SlipCount { at_least: 0, at_most: None, open: vec![Range { lo: 0.0, hi: belt_speed }] },
        };
    }
    let inner = innermost(oscillator);
    // Where eps c is w(V) within rounding all orbits next to the equilibrium may close.
    if inner.shape != Shape::Open && oscillator.curve.has_one_slip_cycle_at_most(belt_speed) {
        let outer = Piece { from: inner.to, to: belt_speed, shape: Shape::OneZero };
        return tally(oscillator, &[inner, outer], &mut BUDGET.clone());
    }
    count_between(oscillator, inner)
}

/// As [`count_slip_cycles`] for a law with a formula, by enclosures of the orbits beyond the `inner` piece.
fn count_between(oscillator: &Oscillator, inner: Piece) -> SlipCount {
    let belt_speed = oscillator.belt_speed;
    let mut pieces = vec![inner];
    let mut waiting = Vec::new();
    let mut top = belt_speed;
    while top > inner.to {
        let from = (top / WIDEST).max(inner.to);
        waiting.push([from, top]);
        top = from;
    }
    let vanishes = [0.0, 1.0, 2.0]
        .iter()
        .all(|share| oscillator.divergence(share * belt_speed).abs() < LEAST_DIVERGENCE);
    // A formula's series take longer than those of the built-in laws.
    let mut budget = match vanishes {
        true => 0,
        false => BUDGET / u32::try_from(oscillator.curve.cost().div_ceil(64)).unwrap_or(BUDGET),
    };
    while let Some([from, to]) = waiting.pop() {
        let shape = shape(oscillator, from, to, &mut budget);
        let middle = (from * to).sqrt();
        if shape != Shape::Open
            || budget == 0
            || (to / from).ln() < SHORTEST
            || !(from < middle && middle < to)
        {
            pieces.push(Piece { from, to, shape });
        } else {
            waiting.push([middle, to]);
            waiting.push([from, middle]);
        }
    }
    tally(oscillator, &pieces, &mut budget)
}

/// The largest piece (0, r] found on which the even part of D has one sign.
fn innermost(oscillator: &Oscillator) -> Piece {
    let Oscillator { curve, viscous, belt_speed } = oscillator;
    let mut reach = *belt_speed;
    while reach > INNERMOST * belt_speed {
        let even = curve.even_weakening_within(*belt_speed, reach);
        if let Some(even) = even.filter(|even| even.excludes(*viscous)) {
            return Piece { from: 0.0, to: reach, shape: Shape::Sign(even.lo > *viscous) };
        }
        reach *= NEXT_RADIUS;
    }
    Piece { from: 0.0, to: reach, shape: Shape::Open }
}

/// Combines the proved properties of adjacent pieces.
fn tally(oscillator: &Oscillator, pieces: &[Piece], budget: &mut u32) -> SlipCount {
    // Adjacent pieces on which g is monotone in one direction are merged, and so are open ones.
    let mut runs: Vec<Piece> = Vec::new();
    for piece in pieces {
        match runs.last_mut() {
            Some(last) if last.shape == piece.shape => last.to = piece.to,
            _ => runs.push(*piece),
        }
    }
    // The sign at the end of a run: that of an adjacent run with one sign, or that of the orbit there.
    let sign = |piece: Option<&Piece>| piece?.shape.sign();
    let mut signs = vec![sign(runs.first())];
    for (i, run) in runs.iter().enumerate() {
        let known = sign(Some(run)).or_else(|| sign(runs.get(i + 1)));
        signs.push(known.or_else(|| shape(oscillator, run.to, run.to, budget).sign()));
    }
    let known: Vec<bool> = signs.iter().flatten().copied().collect();
    let at_least = known.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let mut at_most = Some(0);
    for (run, ends) in runs.iter().zip(signs.windows(2)) {
        let more = match (run.shape, ends) {
            (Shape::Sign(_), _) => Some(0),
            (Shape::Monotone(_) | Shape::OneZero, [Some(a), Some(b)]) => Some(u32::from(a != b)),
            (Shape::Monotone(_) | Shape::OneZero, _) => Some(1),
            (Shape::Open, _) => None,
        };
        at_most = at_most.zip(more).map(|(sum, more)| sum + more);
    }
    let open = runs.iter().filter(|run| run.shape == Shape::Open);
    SlipCount {
        at_least: at_least as u32,
        at_most,
        open: open.map(|run| Range { lo: run.from, hi: run.to }).collect(),
    }
}

impl Polar for Oscillator {
    /// F, H, and dth/dt, at rho.
    fn polar<T: Real>(&self, theta: T, rho: T) -> Option<[T; 3]> {
        let c = T::constant;
        let (sin, cos) = theta.sin_cos();
        let u = c(self.belt_speed) - rho.exp() * cos;
        let slope = self.curve.formula(Jet::<T, 2>::variable(u, 1.0))?.0[1];
        let d = -slope - c(self.viscous);
        let turning = c(1.0) + d * sin * cos;
        let pace = d / turning;
        Some([pace * sin * sin, pace * (cos * cos - sin * sin), turning])
    }
}

/// Bounds over a box of angles and rho: dF/drho and |dH/drho|.
fn sensitivity(oscillator: &Oscillator, theta: Interval, rho: Interval) -> Option<[Interval; 2]> {
    let angle = Jet::<Interval, 2>::of(theta);
    let [f, h, turning] = oscillator.polar(angle, Jet::variable(rho, 1.0))?;
    let fine = turning.0[0].lo > SLOWEST_TURN && f.0[1].is_bounded() && h.0[1].is_bounded();
    fine.then_some([f.0[1], h.0[1]])
}

/// Proves a property of g on [`from`, `to`]; at a single radius, its sign.
fn shape(oscillator: &Oscillator, from: f64, to: f64, budget: &mut u32) -> Shape {
    let is_positive = |x: Interval| (x.lo > 0.0 || x.hi < 0.0).then_some(x.lo > 0.0);
    match walk(oscillator, from, to, budget) {
        Some(Walked::MeetsBelt) => Shape::Sign(true),
        Some(Walked::Turned { all, slopes }) => {
            let monotone = || is_positive(slopes).map(Shape::Monotone);
            is_positive(all).map(Shape::Sign).or_else(monotone).unwrap_or(Shape::Open)
        }
        None => Shape::Open,
    }
}

/// Result of following the orbits of a piece.
#[derive(Clone, Copy, Debug)]
enum Walked {
    /// All reach the belt line.
    MeetsBelt,
    /// All complete a turn.
    Turned {
        /// g on the piece.
        all: Interval,
        /// h on the piece.
        slopes: Interval,
    },
}

/// Follows the orbits of a piece for one turn; `None` where they cannot be enclosed or the budget of steps is
/// spent.
fn walk(oscillator: &Oscillator, from: f64, to: f64, budget: &mut u32) -> Option<Walked> {
    let of = Interval::of;
    let ends = [from, to].map(|r| of(r).ln());
    let start = 0.5 * (ends[0].hi + ends[1].lo);
    // Half-width of the piece around the middle orbit.
    let half = (ends[0].hull(ends[1]) - of(start)).size();
    let aim = (SMALL * half * half).clamp(DEFECTS[0], DEFECTS[1]);
    let (mut theta, mut rho, mut h) = (0.0, start, STEPS[0]);
    // Distances from the polynomial: of the middle orbit, and of all.
    let (mut missed, mut tube) = (of(0.0), of(half));
    // Bounds of psi, of the integral of |dH/drho| psi, and of the error of the integral of H.
    let (mut psi, mut bend, mut error) = (of(1.0), of(0.0), of(0.0));
    let mut slope = of(0.0);
    while theta < TAU {
        *budget = budget.checked_sub(1)?;
        let last = theta + h >= TAU;
        let end = if last { TAU } else { theta + h };
        let width = Interval::of(end) - Interval::of(theta);
        let pace = oscillator.divergence(oscillator.belt_speed - rho.exp() * f64::cos(theta)).abs();
        let polynomial = Polynomial::new(oscillator, theta, rho);
        let tried = polynomial.and_then(|polynomial| polynomial.enclosed(oscillator, width));
        let tried = tried.filter(|it| it.slowest > SLOWEST_TURN);
        let Some(taken) = tried.filter(|it| it.defect <= aim * pace.max(1e-6) || h <= STEPS[1]) else {
            if h <= STEPS[1] {
                return None;
            }
            h = (0.5 * h).max(STEPS[1]);
            continue;
        };
        let angles = Interval::new(theta, end);
        let guess = 1.5 * tube.hi + 2.0 * taken.defect * width.hi + 1e-15;
        let around = taken.along.0[0] + Interval::new(-guess, guess);
        let [by_rho, slope_by_rho] = sensitivity(oscillator, angles, around)?;
        let all = distance(by_rho, width, tube, of(taken.defect));
        if !(all.during.hi < guess) {
            if h <= SHORTEST_OF_PIECE {
                return None;
            }
            h *= 0.5;
            continue;
        }
        let middle = distance(by_rho, width, missed, of(taken.defect));
        let steep = width * of(slope_by_rho.size());
        bend = of((bend + steep * psi * of(all.growth.hi.max(1.0))).hi);
        error = of((error + steep * of(middle.during.hi)).hi);
        psi = of((psi * all.growth).hi);
        slope = slope + taken.integral;
        // The next polynomial begins near the end of this one.
        rho = 0.5 * (taken.end.lo + taken.end.hi);
        let jump = of((taken.end - of(rho)).size());
        missed = of((middle.after + jump).hi);
        tube = of((all.after + jump).hi);
        theta = end;
        // On the way up, beyond the belt line.
        let below = (of(rho) - tube).exp() * of(theta).sin_cos().1;
        if theta > 3.5 && below.lo > oscillator.belt_speed {
            return Some(Walked::MeetsBelt);
        }
        if taken.defect < SMALL * aim * pace {
            h = (2.0 * h).min(STEPS[0]);
        }
    }
    // From the floating-point number TAU to 2 pi, which lies between it and the next number.
    let angle = Jet::<Interval, 1>::of(Interval::new(TAU, TAU.next_up()));
    let around = Interval::new(rho - 2.0 * tube.hi - 1e-9, rho + 2.0 * tube.hi + 1e-9);
    let [last_f, last_h, _] = oscillator.polar(angle, Jet::of(around))?;
    let gap = of(TAU.next_up()) - of(TAU);
    let wide = |x: Interval| Interval::new(-x.hi, x.hi);
    let growth = of(rho) - of(start) + wide(missed + gap * of(last_f.0[0].size()));
    let slope = slope + wide(error + gap * of(last_h.0[0].size()));
    let slopes = slope + wide(of(half) * bend);
    let all = growth + wide(of(half) * of((slopes.exp() - of(1.0)).size()));
    Some(Walked::Turned { all, slopes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law};
    use slipmap_model::point::LawParameters;
    use slipmap_numbers::random::Random;
    use slipmap_orbits::arc::{SlipTurn, turn};

    fn oscillators() -> Vec<Oscillator> {
        let wavy = Law::Expression(Expression::new("1 - s*(u - a*sin(k*u)/k)", 1.0).unwrap());
        let at = |law: Law, parameters: &[f64], viscous, belt_speed| Oscillator {
            curve: law.curve(1.0, &LawParameters::new(parameters)),
            viscous,
            belt_speed,
        };
        vec![
            at(Law::Stribeck, &[0.3, 0.05, 0.8], 0.3, 0.7),
            at(Law::Exponential, &[0.4, 0.7, 0.02], 0.2, 0.9),
            at(Law::Lorentzian, &[0.0, 1.0, 0.0], 0.6, 0.58),
            at(wavy, &[0.3, 0.8, 4.0], 0.2, 1.3),
        ]
    }

    #[test]
    fn enclosures_hold_what_is_integrated() {
        for oscillator in oscillators() {
            for i in 1..20 {
                let from = oscillator.belt_speed * f64::from(i) / 20.0;
                let to = from * (1.0 + 0.002 * f64::from(i % 5));
                let numbers = |r: f64| match turn(&oscillator, r, 1e-13).unwrap() {
                    SlipTurn::Returns { radius, slope, .. } => {
                        Some([(radius / r).ln(), (slope * r / radius).ln()])
                    }
                    SlipTurn::MeetsBelt { .. } | SlipTurn::Rests => None,
                };
                let Some(Walked::Turned { all, slopes }) = walk(&oscillator, from, to, &mut BUDGET.clone())
                else {
                    assert!(numbers(to).is_none(), "{oscillator:?} {from} {to}");
                    continue;
                };
                // The integration has errors of some units of its tolerance.
                let slack = Interval::new(-1e-11, 1e-11);
                let holds = |interval: Interval, x: f64| {
                    let wide = interval + slack;
                    wide.lo <= x && x <= wide.hi
                };
                for r in [from, (from * to).sqrt(), to] {
                    let Some([growth, slope]) = numbers(r) else { continue };
                    assert!(
                        holds(all, growth) && holds(slopes, slope),
                        "{oscillator:?} {r}: {all:?} {slopes:?}"
                    );
                }
                // Over a turn the defects add up, and grow by a factor below ten.
                if from == to {
                    assert!(all.hi - all.lo < 20.0 * TAU * DEFECTS[0], "{oscillator:?} {from}: {all:?}");
                }
            }
        }
    }

    #[test]
    fn unproved_parts_stay_open() {
        // A pole at u = 0.3: the even part has no bounds near it, and orbits that reach it have no enclosure.
        let pole = Law::Expression(Expression::new("1 - 0.01*u/(0.3 - u)", 1.0).unwrap());
        let curve = pole.curve(1.0, &LawParameters::new(&[]));
        let count = count_slip_cycles(&Oscillator { curve, viscous: 0.1, belt_speed: 1.0 });
        assert_eq!(count.at_most, None, "{count:?}");
        assert!(count.open.iter().any(|open| open.lo <= 0.7 && 0.7 <= open.hi), "{count:?}");
        // A node: the polar angle is not monotone in time, but the even part of a law that weakens everywhere
        // decides.
        let curve = Law::Exponential.curve(1.0, &LawParameters::new(&[0.0, 0.1, 0.0]));
        let count = count_slip_cycles(&Oscillator { curve, viscous: 0.0, belt_speed: 0.1 });
        assert_eq!(count.exact(), Some(0), "{count:?}");
        // Degenerate numbers terminate.
        for parameters in [[0.0, 1e-300, 0.0], [0.5, 1e300, 1e300], [1.0, 1.0, 0.0]] {
            let curve = Law::Lorentzian.curve(1.0, &LawParameters::new(&parameters));
            let count = count_slip_cycles(&Oscillator { curve, viscous: 0.0, belt_speed: 1.0 });
            assert!(count.at_most.is_none_or(|most| most >= count.at_least), "{count:?}");
        }
    }

    /// At most one slip cycle is a theorem; enclosures of the orbits share nothing with its proof.
    #[test]
    fn laws_that_bend_one_way_have_one_cycle_at_most() {
        let mut random = Random(91);
        let mut proved = [0; 2];
        for i in 0..60 {
            let mut between = |lo: f64, hi: f64| (hi - lo).mul_add(random.unit(), lo);
            let (law, parameters) = match i % 3 {
                0 => (Law::Stribeck, vec![between(0.0, 0.9), between(0.0, 0.1), between(0.1, 1.0)]),
                1 => (Law::Exponential, vec![between(0.0, 0.9), between(0.3, 3.0), between(0.0, 0.1)]),
                _ => {
                    let text = "1 - a*u + b*u^2 - d*(1 - exp(-k*u))";
                    let law = Law::Expression(Expression::new(text, 1.0).unwrap());
                    (law, vec![between(-0.3, 0.3), between(0.0, 0.3), between(0.0, 0.5), between(0.5, 2.0)])
                }
            };
            let belt_speed = between(0.2, 2.0);
            let curve = law.curve(1.0, &LawParameters::new(&parameters));
            assert!(curve.has_one_slip_cycle_at_most(belt_speed), "{curve:?}");
            let viscous = curve.weakening(belt_speed) * between(1.0, 1.4);
            if viscous < 0.0 {
                continue;
            }
            let oscillator = Oscillator { curve, viscous, belt_speed };
            let by_enclosures = count_between(&oscillator, innermost(&oscillator));
            assert!(by_enclosures.at_least <= 1, "{oscillator:?} {by_enclosures:?}");
            let counted = count_slip_cycles(&oscillator);
            if let Some(count) = by_enclosures.exact() {
                assert_eq!(counted.exact(), Some(count), "{oscillator:?}");
                proved[count as usize] += 1;
            }
        }
        assert!(proved[0] >= 10 && proved[1] >= 10, "{proved:?}");
    }
}
