//! Cycles that slip all the time below the belt line, and what separates the basins.
//!
//! The return map P takes a maximum r of x2, 0 < r < V, to the next one. Its fixed points are the slip
//! cycles; their Floquet multiplier is its slope there. At r = 0 its slope tells the stability of the
//! equilibrium, at r = V the sign of P(r) - r is that of the grazing margin. Where both the equilibrium and
//! the stick-slip cycle attract, an unstable slip cycle lies between them: the boundary of their basins.
//!
//! **Slope.** The flow stretches areas by exp(integral of D), and passes the section x2' = 0 at the rate
//! x2'' = -r. Hence P'(r) = (r / P(r)) exp(integral of D along the turn): no derivative of the friction
//! law is needed. At a fixed point the angles cancel.

use super::arc::{LowerEnd, State, Walk};
use super::{Failure, Range};
use crate::filippov::{Oscillator, Side};

/// Radii in equal steps at which ln(P(r) / r) is looked at; below the first of them they go down by halves. A pair of
/// cycles between two of them is missed only if ln(P(r) / r) bends more than once there;
/// [`super::slip_count::count_slip_cycles`] proves how many there are.
const RADII: u32 = 32;
/// Errors of a turn, in units of its tolerance, that a sign must exceed.
const NOISE: f64 = 10.0;
/// Newton steps and bisections that find a fixed point.
const MOST_TRIALS: u32 = 100;

/// One turn below the belt line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlipTurn {
    /// x2 has its next maximum below V.
    Returns {
        /// The maximum, P(r).
        radius: f64,
        /// P'(r).
        slope: f64,
        /// Time of the turn.
        time: f64,
    },
    /// The orbit comes to the belt line.
    MeetsBelt,
    /// It creeps into the equilibrium.
    Rests,
}

/// A cycle that slips all the time below the belt line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipCycle {
    /// Velocities x2 on it; the upper one is the fixed point of the return map.
    pub velocity: Range,
    /// Positions x1 on it.
    pub displacement: Range,
    /// Floquet multiplier: it attracts if this is below 1 and repels if it is above.
    pub multiplier: f64,
    /// Period.
    pub period: f64,
}

impl SlipCycle {
    /// Whether it attracts.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.multiplier < 1.0
    }
}

/// Sudden changes of velocity that carry the mass from steady slip, at rest at the equilibrium, onto the
/// basin boundary: any larger one ends in stick-slip (or in whatever else lies outside).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kick {
    /// Along the belt's motion, > 0.
    pub forward: f64,
    /// Against it, as a positive number.
    pub backward: f64,
}

/// The turn below the belt line that starts at a maximum `radius` of x2, 0 < `radius` <= V, with the error
/// `tolerance` relative to it.
///
/// # Errors
/// [`Failure`].
pub fn turn(oscillator: &Oscillator, radius: f64, tolerance: f64) -> Result<SlipTurn, Failure> {
    let mut walk = Walk::new(oscillator, Side::Below, [radius, 0.0], tolerance, radius);
    Ok(match walk.lower_arc(|_, _, _| ())? {
        LowerEnd::Turns(end) => {
            SlipTurn::Returns { radius: end.v, slope: radius / end.v * end.growth.exp(), time: end.time }
        }
        LowerEnd::Meets(_) => SlipTurn::MeetsBelt,
        LowerEnd::Rests => SlipTurn::Rests,
    })
}

/// Whether a turn leads outward.
fn outward(from: f64, turn: &SlipTurn) -> bool {
    match turn {
        SlipTurn::Returns { radius, .. } => *radius > from,
        SlipTurn::MeetsBelt => true,
        SlipTurn::Rests => false,
    }
}

/// Whether it is proved that no slip cycle exists: where the even part E in v of weakening(V - v) stays above
/// eps c for 0 < |v| <= V, every turn below the belt line leads outward, and where it stays below, inward.
///
/// **Proof.** That of the test `symmetric` with a start at any maximum r <= V of x2 in place of V: the bounds
/// on |v| <= V hold on |v| <= r. []
#[must_use]
pub fn none_proved(oscillator: &Oscillator) -> bool {
    let even = oscillator.curve.even_weakening_range(oscillator.belt_speed);
    even.lo > oscillator.viscous || even.hi < oscillator.viscous
}

/// The slip cycles, by growing amplitude, located with the relative error `tolerance` of one turn divided by
/// |1 - multiplier|.
///
/// They alternate in stability. The equilibrium's own stability and the turn from the belt line are put in,
/// so the number found is even or odd as it must be. Pairs between two radii of the same sign are looked for
/// where the slope of ln(P(r) / r) at the two leaves room for an extreme. None exists where [`none_proved`].
///
/// # Errors
/// [`Failure`] of one of the turns.
pub fn slip_cycles(oscillator: &Oscillator, tolerance: f64) -> Result<Vec<SlipCycle>, Failure> {
    let belt_speed = oscillator.belt_speed;
    let mut cycles = Vec::new();
    if none_proved(oscillator) {
        return Ok(cycles);
    }
    let mut low = Sample { radius: 0.0, outward: !oscillator.eigenvalues().is_stable(), growth: None };
    for radius in radii(belt_speed, tolerance) {
        let high = Sample::at(oscillator, radius, tolerance)?;
        if high.growth.is_some_and(|growth| growth.value.abs() <= NOISE * tolerance) && radius < belt_speed {
            // Its sign is not known; those of its neighbours tell as much.
            continue;
        }
        let mut brackets = Vec::new();
        if low.outward != high.outward {
            brackets.push([low, high]);
        } else if let Some(between) = hidden_between(oscillator, low, high, tolerance)? {
            brackets.extend([[low, between], [between, high]]);
        }
        for [low, high] in brackets {
            let radius = fixed_point(oscillator, [low.radius, high.radius], low.outward, tolerance)?;
            if radius > 0.0 {
                cycles.push(cycle_at(oscillator, radius, tolerance)?);
            }
        }
        low = high;
    }
    Ok(cycles)
}

/// The radii to look at, in growing order. Next to the equilibrium ln(P(r) / r) changes with (r / V)^2; where that comes
/// near the error of a turn there is nothing more to see.
fn radii(belt_speed: f64, tolerance: f64) -> Vec<f64> {
    let first = 1.0 / f64::from(RADII);
    let halves = std::iter::successors(Some(0.5 * first), |ratio| Some(0.5 * ratio));
    let mut ratios: Vec<f64> = halves.take_while(|ratio| ratio * ratio > 100.0 * tolerance).collect();
    ratios.reverse();
    ratios.extend((1..=RADII).map(|i| f64::from(i) * first));
    ratios.into_iter().map(|ratio| ratio * belt_speed).collect()
}

/// What is known of the return map at one radius.
#[derive(Clone, Copy, Debug)]
struct Sample {
    radius: f64,
    outward: bool,
    growth: Option<Growth>,
}

impl Sample {
    fn at(oscillator: &Oscillator, radius: f64, tolerance: f64) -> Result<Self, Failure> {
        let turn = turn(oscillator, radius, tolerance)?;
        Ok(Self { radius, outward: outward(radius, &turn), growth: Growth::of(radius, &turn) })
    }
}

/// A radius between two of the same sign of ln(P(r) / r) at which it has the other one, if the slopes lead there.
fn hidden_between(
    oscillator: &Oscillator,
    mut low: Sample,
    mut high: Sample,
    tolerance: f64,
) -> Result<Option<Sample>, Failure> {
    // Towards zero from both ends: its size falls at the lower one and rises at the higher one.
    let sign = if low.outward { 1.0 } else { -1.0 };
    while let (Some(Growth { slope: falls, .. }), Some(Growth { slope: rises, .. })) =
        (low.growth, high.growth)
    {
        if !(sign * falls < 0.0 && sign * rises > 0.0) || high.radius - low.radius <= 1e-6 * high.radius {
            return Ok(None);
        }
        // Where the tangent of the slopes' secant vanishes, kept away from the ends.
        let share = (falls / (falls - rises)).clamp(0.1, 0.9);
        let radius = low.radius + share * (high.radius - low.radius);
        let middle = Sample::at(oscillator, radius, tolerance)?;
        if middle.outward != low.outward {
            return Ok(Some(middle));
        }
        match middle.growth {
            Some(growth) if sign * growth.slope < 0.0 => low = middle,
            _ => high = middle,
        }
    }
    Ok(None)
}

/// Where turns grow or shrink most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// The maximum r of x2 from which the turn starts.
    pub radius: f64,
    /// ln(P(r) / r).
    pub growth: f64,
    /// Estimate of its absolute error.
    pub error: f64,
}

/// ln(P(r) / r) at a radius and its slope by ln r, r P'(r) / P(r) - 1, which needs no derivative of the law.
#[derive(Clone, Copy, Debug)]
struct Growth {
    radius: f64,
    value: f64,
    slope: f64,
}

impl Growth {
    /// `None` where the orbit has no next maximum below the belt line.
    fn of(radius: f64, turn: &SlipTurn) -> Option<Self> {
        match *turn {
            SlipTurn::Returns { radius: next, slope, .. } => {
                Some(Self { radius, value: (next / radius).ln(), slope: radius * slope / next - 1.0 })
            }
            SlipTurn::MeetsBelt | SlipTurn::Rests => None,
        }
    }

    fn at(oscillator: &Oscillator, radius: f64, tolerance: f64) -> Result<Option<Self>, Failure> {
        Ok(Self::of(radius, &turn(oscillator, radius, tolerance)?))
    }
}

/// Accuracy of the turns that bracket an extreme.
const ROUGH: f64 = 1e-6;

/// The local extreme of ln(P(r) / r) over 0 < r < V with the growth nearest to zero: as it passes zero, two slip
/// cycles meet and vanish. `None` if there is none between two of the radii that are looked at.
///
/// # Errors
/// [`Failure`] of one of the turns.
pub fn extreme_growth(oscillator: &Oscillator, tolerance: f64) -> Result<Option<Extreme>, Failure> {
    let mut brackets = Vec::new();
    let mut low: Option<Growth> = None;
    for radius in radii(oscillator.belt_speed, tolerance) {
        // Next to the equilibrium the slope is of the size of (r / V)^2.
        let ratio = radius / oscillator.belt_speed;
        let enough = (1e-4 * ratio * ratio).min(ROUGH).max(tolerance);
        let high = Growth::at(oscillator, radius, enough)?;
        if high.is_some_and(|high| high.slope.abs() <= NOISE * enough) {
            continue;
        }
        if let (Some(low), Some(high)) = (low, high)
            && (low.slope > 0.0) != (high.slope > 0.0)
        {
            brackets.push([low, high]);
        }
        low = high;
    }
    let size = |bracket: &[Growth; 2]| bracket[0].value.abs().min(bracket[1].value.abs());
    let nearest = brackets.into_iter().min_by(|a, b| size(a).total_cmp(&size(b)));
    nearest.map_or(Ok(None), |bracket| extreme_between(oscillator, bracket, tolerance))
}

/// The extreme between two radii with slopes of opposite signs.
fn extreme_between(
    oscillator: &Oscillator,
    [mut low, mut high]: [Growth; 2],
    tolerance: f64,
) -> Result<Option<Extreme>, Failure> {
    let rises = low.slope > 0.0;
    // Next to the extreme the growth is flat: its error is of second order in that of the radius.
    let enough = 0.1 * tolerance.sqrt();
    for trial in 1..=MOST_TRIALS {
        let secant = low.radius - low.slope * (high.radius - low.radius) / (high.slope - low.slope);
        let inside = secant > low.radius && secant < high.radius && trial % 3 != 0;
        let radius = if inside { secant } else { 0.5 * (low.radius + high.radius) };
        let Some(middle) = Growth::at(oscillator, radius, tolerance)? else { return Ok(None) };
        if middle.slope.abs() <= enough || high.radius - low.radius <= enough * radius {
            let Some(rough) = Growth::at(oscillator, radius, 100.0 * tolerance)? else { return Ok(None) };
            // The extreme itself is farther by slope^2 / 2 over the rate at which the slope changes.
            let bend = (high.slope - low.slope) / (high.radius / low.radius).ln();
            let missed = middle.slope * middle.slope / bend.abs();
            let error = (middle.value - rough.value).abs() + missed + 4.0 * f64::EPSILON;
            return Ok(Some(Extreme { radius, growth: middle.value, error }));
        }
        *if (middle.slope > 0.0) == rises { &mut low } else { &mut high } = middle;
    }
    Ok(None)
}

/// The fixed point between two radii; turns lead outward at the lower one or not, and at the higher one the
/// other way.
fn fixed_point(
    oscillator: &Oscillator,
    [mut low, mut high]: [f64; 2],
    low_outward: bool,
    tolerance: f64,
) -> Result<f64, Failure> {
    let mut radius = 0.5 * (low + high);
    for _ in 0..MOST_TRIALS {
        let here = turn(oscillator, radius, tolerance)?;
        if outward(radius, &here) == low_outward {
            low = radius;
        } else {
            high = radius;
        }
        let newton = match here {
            SlipTurn::Returns { radius: next, slope, .. } => radius + (next - radius) / (1.0 - slope),
            SlipTurn::MeetsBelt | SlipTurn::Rests => f64::NAN,
        };
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        let moved = (next - radius).abs();
        radius = next;
        if moved <= 0.1 * tolerance * radius || next <= low || next >= high {
            break;
        }
    }
    Ok(radius)
}

/// Extremes and multiplier of the cycle through (x2, x2') = (`radius`, 0).
fn cycle_at(oscillator: &Oscillator, radius: f64, tolerance: f64) -> Result<SlipCycle, Failure> {
    let mut walk = Walk::new(oscillator, Side::Below, [radius, 0.0], tolerance, radius);
    let mut extent = Extent::new(&walk);
    let end = walk.lower_arc(|walk, from, to| extent.step(walk, from, to))?;
    let (LowerEnd::Turns(State { growth, time, .. }) | LowerEnd::Meets(State { growth, time, .. })) = end
    else {
        // A cycle does not creep into the equilibrium.
        return Err(Failure::StepUnderflow);
    };
    Ok(SlipCycle {
        velocity: extent.velocity,
        displacement: extent.displacement,
        multiplier: growth.exp(),
        period: time,
    })
}

/// The extremes of x1 and x2 on an orbit, step by step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) velocity: Range,
    pub(super) displacement: Range,
}

impl Extent {
    pub(super) fn new(walk: &Walk) -> Self {
        let mut extent = Self {
            velocity: Range { lo: f64::INFINITY, hi: f64::NEG_INFINITY },
            displacement: Range { lo: f64::INFINITY, hi: f64::NEG_INFINITY },
        };
        extent.include(walk, &walk.here);
        extent
    }

    fn include(&mut self, walk: &Walk, state: &State) {
        let widen = |range: &mut Range, x: f64| {
            *range = Range { lo: range.lo.min(x), hi: range.hi.max(x) };
        };
        widen(&mut self.velocity, state.v);
        widen(&mut self.displacement, walk.x1(state));
    }

    /// Extremes of x2 lie at x2' = 0, those of x1 at x2 = 0; steps are short enough to hold one of each.
    pub(super) fn step(&mut self, walk: &mut Walk, from: &State, to: &State) {
        self.include(walk, to);
        let h = to.time - from.time;
        if from.w * to.w < 0.0 {
            let at = walk.locate(from, h, |_, state| state.w);
            self.include(walk, &at);
        }
        if from.v * to.v < 0.0 {
            let at = walk.locate(from, h, |_, state| state.v);
            self.include(walk, &at);
        }
    }
}

/// The kicks that carry the equilibrium onto `cycle`: the velocities at which the cycle passes the
/// equilibrium's x1.
///
/// # Errors
/// [`Failure`].
pub fn kick_onto(oscillator: &Oscillator, cycle: &SlipCycle, tolerance: f64) -> Result<Kick, Failure> {
    let radius = cycle.velocity.hi;
    let rest = oscillator.equilibrium_x1();
    let mut walk = Walk::new(oscillator, Side::Below, [radius, 0.0], tolerance, radius);
    let mut kick = Kick { forward: radius, backward: -cycle.velocity.lo };
    walk.lower_arc(|walk, from, to| {
        let [before, after] = [from, to].map(|state| walk.x1(state) - rest);
        if before * after <= 0.0 && before != after {
            let at = walk.locate(from, to.time - from.time, |walk, state| walk.x1(state) - rest);
            // x1' = x2: the cycle passes once on the way forward and once on the way back.
            if at.v > 0.0 {
                kick.forward = at.v;
            } else {
                kick.backward = -at.v;
            }
        }
    })?;
    Ok(kick)
}
