//! Cycles that meet the belt line: crossing cycles, which never stick, and the shape of the stick-slip cycle.
//!
//! A point (e + y, V), y > 0, beyond the exit point e = 1 - eps c V is crossed downward with x2' = -(y + j), j
//! the drop. The loop from it goes below the belt line, comes back there with x2' = wL, crosses upward if wL >
//! 2 - j (the other side's x2' is less by 2 (1 - j), twice the friction at the onset of slip) and comes back
//! with x2' = W < 0 above; it crosses again if y' = -(W + 2 - j) > 0. Fixed points of y -> y' are the crossing cycles. The map is monotone,
//! since orbits do not cross.
//!
//! **Multiplier.** From one passage of the belt line to the next, dx1 at the end is dx1 at the start times
//! exp(integral of D) times the ratio of the passing speeds |x2'|, start over end, each by the field of the
//! arc. The slope of the loop map is the product over both arcs.

use super::slip_cycle::{CyclesUnknown, is_closed};
use slipmap_model::filippov::{Oscillator, Side};
use slipmap_model::flow::{Failure, Fate, Flow, Landing};
use slipmap_model::friction::Range;
use slipmap_numbers::roots::fixed_point;
use slipmap_orbits::Cycle;
use slipmap_orbits::arc::{Extent, LowerEnd, State, Walk};
use slipmap_orbits::far_loops::FarLoops;
use slipmap_orbits::fate_and_extent;
use slipmap_orbits::{Piece, Work};

/// Number of values of y per factor of ten at which the sign of y' - y is computed first.
const PER_DECADE: i32 = 8;
/// The first decade searched, in units of max(1, V).
const FIRST_DECADE: i32 = -6;
/// The last decade searched, in the same units, where no distance is known from which on all loops lead inward
/// or all outward. [`CyclesUnknown::FarOut`] names it.
const LAST_DECADE: i32 = 4;
/// Slip speeds up to which the divergence is looked at, in the same units, and at least four times the
/// distance searched.
const CONTRACTS_TO: f64 = 400.0;
/// Relative error of a loop where only its direction is required.
const DIRECTION_TOLERANCE: f64 = 1e-6;
/// Change of a loop, in units of the tolerance, below which its direction is that of its error.
const ERRORS: f64 = 10.0;

/// A loop from a downward crossing of the belt line.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Loop {
    /// The orbit crosses again.
    Crosses {
        /// y', the new distance beyond the exit point.
        beyond_exit: f64,
        /// Slope of the loop map.
        slope: f64,
        /// Time of the loop.
        time: f64,
    },
    /// The orbit sticks.
    Sticks,
    /// The orbit stays below the belt line.
    SpiralsInward,
}

/// Where an orbit that starts on the belt line meets the line again.
struct Passage {
    /// The state in which it arrives from below; `None` if it stays below.
    up: Option<State>,
    /// The state in which it comes back from above, if it crosses there.
    down: Option<State>,
}

/// Follows the orbit from (e + `y`, V), `y` >= 0, below the belt line and, where it crosses, above it.
/// `visit` is called with the two ends of every step.
fn passage(
    oscillator: &Oscillator,
    y: f64,
    tolerance: f64,
    work: &Work,
    mut visit: impl FnMut(&mut Walk, &State, &State),
) -> Result<Passage, Failure> {
    let belt_speed = oscillator.belt_speed;
    let scale = belt_speed.max(y);
    let start = [belt_speed, -(y + oscillator.drop())];
    let mut lower = Walk::new(oscillator, Side::Below, start, tolerance, scale, work);
    let LowerEnd::Meets(up) = lower.lower_arc(&mut visit)? else {
        return Ok(Passage { up: None, down: None });
    };
    let rise = up.w - oscillator.jump();
    if up.w <= oscillator.fastest_sticking() {
        return Ok(Passage { up: Some(up), down: None });
    }
    let upper = Walk::new(oscillator, Side::Above, [belt_speed, rise], tolerance, scale, work);
    let mut upper = upper.starting_with(up.spread / up.w);
    Ok(Passage { up: Some(up), down: Some(upper.upper_arc(visit)?) })
}

impl Passage {
    /// Estimate of the error of the place at which the orbit comes back from above.
    fn error(&self) -> f64 {
        self.down.as_ref().map_or(f64::INFINITY, |down| down.spread / -down.w)
    }

    /// The loop of an orbit that started `y` beyond the exit point.
    fn end(&self, oscillator: &Oscillator, y: f64) -> Loop {
        let Passage { up: Some(up), down } = self else { return Loop::SpiralsInward };
        let fastest = oscillator.fastest_sticking();
        let Some(down) = down.as_ref().filter(|down| down.w < -fastest) else { return Loop::Sticks };
        let speeds = ((y + oscillator.drop()) / up.w) * ((up.w - oscillator.jump()) / -down.w);
        let slope = (up.growth + down.growth).exp() * speeds;
        Loop::Crosses { beyond_exit: -(down.w + fastest), slope, time: up.time + down.time }
    }
}

/// The loop from (e + `y`, V), `y` >= 0, with the error `tolerance` relative to the larger of V and `y`.
fn loop_within(oscillator: &Oscillator, y: f64, tolerance: f64, work: &Work) -> Result<Loop, Failure> {
    passage(oscillator, y, tolerance, work, |_, _, _| ()).map(|passage| passage.end(oscillator, y))
}

/// A function of the parameters for the orbit from `beyond_exit` beyond the exit point, smooth where friction
/// has no drop: 0 if it does not return, else the landing speed up to 2 - j. If the orbit crosses the belt
/// line, it is 2 (2 - j) plus the distance beyond the exit point at which the orbit crosses again; below that
/// the orbit sticks. The orbit follows the compiled law.
pub fn reach(oscillator: &Oscillator, beyond_exit: f64, tolerance: f64) -> Result<f64, Failure> {
    reach_within(oscillator, beyond_exit, tolerance, &Work::of(Piece::Loops, &oscillator.curve))
}

pub(super) fn reach_within(
    oscillator: &Oscillator,
    beyond_exit: f64,
    tolerance: f64,
    work: &Work,
) -> Result<f64, Failure> {
    Ok(match passage(oscillator, beyond_exit, tolerance, work, |_, _, _| ())? {
        Passage { up: None, .. } => 0.0,
        Passage { up: Some(up), down: None } => up.w,
        Passage { down: Some(down), .. } => oscillator.fastest_sticking() - down.w,
    })
}

/// The speed x2' with which the orbit from the exit point comes back to the belt line, less that at which it
/// would land at the far end of the segment where friction at rest holds; `None` if it does not come back.
pub fn beyond_landing(oscillator: &Oscillator, tolerance: f64, work: &Work) -> Result<Option<f64>, Failure> {
    let passage = passage(oscillator, 0.0, tolerance, work, |_, _, _| ())?;
    Ok(passage.up.map(|up| up.w - oscillator.fastest_sticking()))
}

/// Returns whether a loop leads farther out.
fn outward(from: f64, end: &Loop) -> bool {
    matches!(end, Loop::Crosses { beyond_exit, .. } if *beyond_exit > from)
}

/// Returns whether it is proved that no crossing cycle exists up to the distance `farthest` beyond the exit
/// point: where the divergence is nowhere positive.
///
/// **Proof.** The integral of D over the region that a crossing cycle encloses is the flux out of its parts
/// below and above the belt line. Nothing flows through the orbit; through the part of the line inside, of
/// length s, flows x2' of the lower field less x2' of the upper one, which is 2 (1 - j) everywhere. So the
/// integral is 2 (1 - j) s > 0. []
fn contracts(oscillator: &Oscillator, farthest: f64) -> bool {
    let fastest = (CONTRACTS_TO * oscillator.belt_speed.max(1.0)).max(4.0 * farthest);
    oscillator.divergence_is_at_most(0.0, 0.0, fastest)
}

/// A loop, from `y` > 0 beyond the exit point.
#[derive(Clone, Copy, Debug)]
struct Node {
    y: f64,
    outward: bool,
    /// g = ln(y'/y) and its slope by ln y, where the loop crosses again.
    growth: Option<[f64; 2]>,
}

impl Node {
    fn of(y: f64, end: &Loop) -> Self {
        let growth = match *end {
            Loop::Crosses { beyond_exit, slope, .. } => {
                Some([(beyond_exit / y).ln(), slope * y / beyond_exit - 1.0])
            }
            Loop::Sticks | Loop::SpiralsInward => None,
        };
        Self { y, outward: outward(y, end), growth }
    }

    /// Whether g of this loop and of its neighbours is within the error: far out, friction that vanishes
    /// hardly changes loops.
    fn is_flat(&self, tolerance: f64) -> bool {
        // Where g falls as a power of y its slope is as small, up to the exponent.
        let within_error = |[g, slope]: [f64; 2]| g.abs().max(0.1 * slope.abs()) <= ERRORS * tolerance;
        self.growth.is_some_and(within_error)
    }
}

/// The search for loops that lead the other way than those on both sides of them.
struct Search<'a> {
    oscillator: &'a Oscillator,
    tolerance: f64,
    work: &'a Work,
    /// Assumed error of a cubic between two loops until a loop between them has been followed. It is infinite
    /// where friction may push. Elsewhere no pair of cycles is known to exist, and it is zero.
    missed: f64,
}

impl<'a> Search<'a> {
    fn new(oscillator: &'a Oscillator, far: &FarLoops, tolerance: f64, work: &'a Work) -> Self {
        Self { oscillator, tolerance, work, missed: if far.may_push() { f64::INFINITY } else { 0.0 } }
    }

    fn node(&self, y: f64) -> Result<Node, Failure> {
        Ok(Node::of(y, &loop_within(self.oscillator, y, self.tolerance, self.work)?))
    }

    /// Finds, between two loops that lead in the direction `outward`, one that leads the other way; `None` if
    /// there is none.
    ///
    /// Loops are nested: if that from b ends below a, all between lead inward, and if that from a ends beyond
    /// b, outward. Else g is compared with the cubic in ln y that has the values and slopes at both ends; its
    /// error is about `missed`, found from a loop between two others.
    ///
    /// # Errors
    /// [`CyclesUnknown::TooClose`] if two cycles may meet there.
    fn reversal(
        &self,
        [a, b]: [&Node; 2],
        outward: bool,
        missed: f64,
    ) -> Result<Option<Node>, CyclesUnknown> {
        let sign = if outward { 1.0 } else { -1.0 };
        let proved = match outward {
            true => a.growth.is_some_and(|[g, _]| a.y * g.exp() >= b.y),
            false => b.growth.is_none_or(|[g, _]| b.y * g.exp() <= a.y),
        };
        if proved || a.is_flat(self.tolerance) || b.is_flat(self.tolerance) {
            return Ok(None);
        }
        let width = (b.y / a.y).ln();
        if width <= self.tolerance {
            return Err(CyclesUnknown::TooClose);
        }
        let mut at_middle = None;
        if let (Some([from, rise]), Some([to, fall])) = (a.growth, b.growth) {
            // The inner coefficients of the cubic by Bernstein: it lies between the least and the greatest of
            // the four.
            let inner = [from + rise * width / 3.0, to - fall * width / 3.0];
            if inner.iter().all(|value| sign * value > missed) {
                return Ok(None);
            }
            at_middle = Some(0.125 * (from + to) + 0.375 * (inner[0] + inner[1]));
        }
        let middle = self.node((a.y * b.y).sqrt())?;
        let is_flat = middle.is_flat(self.tolerance);
        if !is_flat && middle.growth.is_some_and(|[g, _]| g.abs() <= ERRORS * self.tolerance) {
            return Err(CyclesUnknown::TooClose);
        }
        if !is_flat && middle.outward != outward {
            return Ok(Some(middle));
        }
        let missed = match (at_middle, middle.growth) {
            (Some(cubic), Some([g, _])) => (cubic - g).abs(),
            _ => missed,
        };
        match self.reversal([a, &middle], outward, missed)? {
            None => self.reversal([&middle, b], outward, missed),
            found => Ok(found),
        }
    }

    /// Adds the cycles between two loops, by growing size.
    fn cycles(&self, [a, b]: [&Node; 2], cycles: &mut Vec<Cycle>) -> Result<(), CyclesUnknown> {
        if a.outward == b.outward {
            return match self.reversal([a, b], a.outward, self.missed)? {
                None => Ok(()),
                Some(between) => {
                    self.cycles([a, &between], cycles)?;
                    self.cycles([&between, b], cycles)
                }
            };
        }
        let Some((y, cycle)) = self.cycle_between([a.y, b.y], a.outward)? else { return Ok(()) };
        let at = |outward| Node { y, outward, growth: Some([0.0, cycle.multiplier - 1.0]) };
        if a.y > 0.0 {
            self.cycles([a, &at(a.outward)], cycles)?;
        }
        cycles.push(cycle);
        self.cycles([&at(b.outward), b], cycles)
    }

    /// The cycle between two distances beyond the exit point, of which one leads outward and one inward, and its own;
    /// `None` if loops change from outward to sticking there without passing through a cycle.
    fn cycle_between(
        &self,
        between: [f64; 2],
        low_outward: bool,
    ) -> Result<Option<(f64, Cycle)>, CyclesUnknown> {
        let Self { oscillator, tolerance, work, .. } = *self;
        let mut sticks_at = f64::NAN;
        let (y, (from, passage, Extent { velocity, displacement })) =
            fixed_point(between, low_outward, tolerance, |y| {
                let mut extent = Extent::default();
                let visit = |walk: &mut Walk, from: &State, to: &State| extent.step(walk, from, to);
                let passage = passage(oscillator, y, tolerance, work, visit)?;
                let here = passage.end(oscillator, y);
                let returns = match here {
                    Loop::Crosses { beyond_exit, slope, .. } => Some([beyond_exit, slope]),
                    Loop::Sticks | Loop::SpiralsInward => {
                        sticks_at = y;
                        None
                    }
                };
                Ok::<_, Failure>((outward(y, &here), returns, (y, passage, extent)))
            })?;
        let Loop::Crosses { beyond_exit, slope: multiplier, time: period } = passage.end(oscillator, from)
        else {
            return Ok(None);
        };
        // Far from a fixed point Newton's last step may be short where the map is steep.
        let located = tolerance * y * (1.0 - multiplier).abs().max(1.0);
        if !is_closed(from, beyond_exit, passage.error(), located) {
            let is_jump = (sticks_at - from).abs() <= tolerance * y;
            return if is_jump { Ok(None) } else { Err(CyclesUnknown::NotClosed) };
        }
        Ok(Some((y, Cycle { period, displacement, velocity, multiplier, beyond_exit: Some(y) })))
    }
}

/// Whether some orbits cross the belt line for ever, where that takes no loop to know.
pub(super) fn no_loop_needed(oscillator: &Oscillator, far: &FarLoops) -> Option<bool> {
    let settled_from = far.inward_from(oscillator.viscous);
    if settled_from == 0.0 || contracts(oscillator, settled_from) {
        return Some(false);
    }
    let all_grow = settled_from == f64::INFINITY && far.outward_from(oscillator.viscous) < f64::INFINITY;
    all_grow.then_some(true)
}

/// Returns whether some orbits cross the belt line for ever: whether a loop leads outward. They tend to a
/// crossing cycle, or grow. Loops are followed inward from where all others lead inward.
pub fn some_cross_for_ever(
    oscillator: &Oscillator,
    far: &FarLoops,
    work: &Work,
) -> Result<bool, CyclesUnknown> {
    if let Some(known) = no_loop_needed(oscillator, far) {
        return Ok(known);
    }
    let settled_from = far.inward_from(oscillator.viscous);
    let unit = oscillator.belt_speed.max(1.0);
    let search = Search::new(oscillator, far, DIRECTION_TOLERANCE, work);
    // From outside: loops are nested, so that none between a loop and the next leads outward.
    let is_settled = settled_from < f64::INFINITY;
    let mut y = if is_settled { settled_from } else { unit * 10_f64.powi(LAST_DECADE) };
    let mut last: Option<Node> = None;
    while y > unit * 10_f64.powi(FIRST_DECADE) {
        let end = loop_within(oscillator, y, DIRECTION_TOLERANCE, work)?;
        let here = Node::of(y, &end);
        let outward = matches!(end, Loop::Crosses { beyond_exit, .. } if beyond_exit >= y);
        if outward && !here.is_flat(DIRECTION_TOLERANCE) {
            return Ok(true);
        }
        if let Some(last) = last
            && search.reversal([&here, &last], false, search.missed)?.is_some()
        {
            return Ok(true);
        }
        let Loop::Crosses { beyond_exit, .. } = end else { break };
        y = beyond_exit.min(y / 10_f64.powf(1.0 / f64::from(PER_DECADE)));
        last = Some(here);
    }
    if is_settled { Ok(false) } else { Err(CyclesUnknown::FarOut) }
}

/// The crossing cycles that were found.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossingCycles {
    /// The cycles, by growing size.
    pub cycles: Vec<Cycle>,
    /// Reason why there may be others; `None` where these are all.
    pub unknown: Option<CyclesUnknown>,
}

impl CrossingCycles {
    /// All cycles.
    ///
    /// # Errors
    /// [`CyclesUnknown`] where there may be others.
    pub fn all(self) -> Result<Vec<Cycle>, CyclesUnknown> {
        self.unknown.map_or(Ok(self.cycles), Err)
    }
}

/// The crossing cycles whose loops `far` does not leave out. An orbit from the exit point that never sticks tends to
/// the first of all, if there is any; otherwise it grows without bound. None exists where the divergence is nowhere
/// positive, or where the friction force falls too little (theory, "Any friction law").
pub fn crossing_cycles(oscillator: &Oscillator, far: &FarLoops, tolerance: f64) -> CrossingCycles {
    let mut found = CrossingCycles { cycles: Vec::new(), unknown: None };
    let settled_from = far.inward_from(oscillator.viscous);
    if settled_from == 0.0 || contracts(oscillator, settled_from) {
        return found;
    }
    let known_from = match settled_from == f64::INFINITY {
        true => far.outward_from(oscillator.viscous),
        false => settled_from,
    };
    let unit = oscillator.belt_speed.max(1.0);
    let farthest = if known_from < f64::INFINITY { known_from } else { unit * 10_f64.powi(LAST_DECADE) };
    let work = Work::of(Piece::Loops, &oscillator.curve);
    let search = Search::new(oscillator, far, tolerance, &work);
    // Inward from the first place at which the direction of all larger loops is known. A loop that does not
    // cross again excludes all cycles inside it.
    let place = |i: i32| unit * 10_f64.powf(f64::from(i) / f64::from(PER_DECADE));
    let first = FIRST_DECADE * PER_DECADE;
    let last = ((farthest / unit).log10() * f64::from(PER_DECADE)).ceil() as i32;
    let mut nodes: Vec<Node> = Vec::new();
    for i in (first..=last.max(first)).rev() {
        let node = match search.node(place(i)) {
            Ok(node) => node,
            Err(failure) => {
                found.unknown = Some(failure.into());
                break;
            }
        };
        if !node.is_flat(tolerance) {
            nodes.push(node);
        }
        if node.growth.is_none() {
            break;
        }
    }
    // Beyond the outermost of these loops others change by less than their error, if they are followed at all.
    // Of a law that is known up to a slip speed only, and of friction that is left out where it pushes, cycles that
    // leave it are not asked for.
    let is_cut = oscillator.curve.fastest() < f64::INFINITY || far.is_cut_short();
    let leads_on = nodes.first().is_some_and(|node| node.outward == (settled_from < f64::INFINITY));
    if known_from == f64::INFINITY || !is_cut && leads_on {
        found.unknown = found.unknown.or(Some(CyclesUnknown::FarOut));
    }
    if found.unknown.is_none() && nodes.last().is_some_and(|last| last.growth.is_some()) {
        // All loops from less than the first distance count as one.
        match loop_within(oscillator, 0.0, tolerance, &work).map(|end| Node::of(0.0, &end)) {
            Ok(smallest) if nodes.last().is_some_and(|last| last.outward != smallest.outward) => {
                nodes.push(smallest);
            }
            Ok(_) => {}
            Err(failure) => found.unknown = Some(failure.into()),
        }
    }
    for pair in nodes.windows(2).rev() {
        if let Err(why) = search.cycles([&pair[1], &pair[0]], &mut found.cycles) {
            found.unknown = found.unknown.or(Some(why));
        }
    }
    found
}

/// The stick-slip cycle, where `flow` found one.
///
/// # Errors
/// [`Failure`] of the arcs.
pub fn stick_slip_cycle(
    oscillator: &Oscillator,
    flow: &Flow,
    tolerance: f64,
) -> Result<Option<Cycle>, Failure> {
    match flow.fate {
        Fate::Sticks(_) => Ok(landing_and_cycle(oscillator, tolerance)?.map(|(_, cycle)| cycle)),
        _ => Ok(None),
    }
}

/// The landing and the stick-slip cycle of an orbit that is known to return to the belt line; `None` where it does not stick.
///
/// # Errors
/// [`Failure`] of the arcs.
pub fn landing_and_cycle(
    oscillator: &Oscillator,
    tolerance: f64,
) -> Result<Option<(Landing, Cycle)>, Failure> {
    let (fate, Extent { velocity, displacement }) = fate_and_extent(oscillator, tolerance);
    let landing = match fate {
        Fate::Sticks(landing) => landing,
        Fate::Failed(failure) => return Err(failure),
        Fate::SpiralsInward | Fate::CrossesForever | Fate::TooCloseToCall => return Ok(None),
    };
    let cycle = Cycle {
        period: landing.slip_time + landing.stick_time,
        // While it sticks the mass moves from the landing to the exit point.
        displacement: displacement.hull(Range::of([landing.x1, oscillator.exit_x1()])),
        velocity,
        multiplier: 0.0,
        beyond_exit: None,
    };
    Ok(Some((landing, cycle)))
}

/// The stick-slip cycle and the crossing cycles; `None` where they are not known.
pub fn beyond_slip(oscillator: &Oscillator, tolerance: f64) -> (Option<Option<Cycle>>, Option<Vec<Cycle>>) {
    let flow = slipmap_orbits::flow(oscillator, tolerance);
    let sticks = match flow.fate {
        Fate::TooCloseToCall | Fate::Failed(_) => None,
        _ => stick_slip_cycle(oscillator, &flow, tolerance).ok(),
    };
    let far = FarLoops::where_friction_resists(&oscillator.curve, oscillator.belt_speed);
    (sticks, crossing_cycles(oscillator, &far, tolerance).all().ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law};
    use slipmap_numbers::random::Random;

    /// Laws with a step or a dip; some of them push for ever, some nowhere.
    fn law(random: &mut Random) -> (Law, Vec<f64>) {
        let phi = [
            "1-a*u/(u+b)-d*(tanh((u-s)/w)+tanh(s/w))/2",
            "1-a*(1-exp(-u/b))-d*exp(-((u-s)/w)^2)",
            "1-a*tanh(u/b)-d*u/(u+s)+w*0",
        ];
        let log = |random: &mut Random, lo: f64, hi: f64| lo * (hi / lo).powf(random.unit());
        let e = log(random, 0.1, 50.0);
        let values =
            vec![random.unit(), log(random, 0.01, 10.0), 2.0 * random.unit(), e, e * log(random, 0.05, 0.5)];
        let phi = phi[(3.0 * random.unit()) as usize];
        (Law::Expression(Expression::new(phi, 1.0).unwrap()), values)
    }

    /// Friction that pushes for ever from 10^11 on: no loop is followed there, and none needs to be.
    #[test]
    fn orbits_that_run_away_are_known_however_far_out() {
        let law = Law::Expression(Expression::new("1-1e-11*u", 1.0).unwrap());
        let oscillator = Oscillator::new(&law, &law.point(1.0, &[], 1.0, 0.0).unwrap());
        let far = FarLoops::new(&oscillator.curve, 1.0);
        assert!((1e11..1e13).contains(&far.outward_from(0.0)) && far.inward_from(0.0) == f64::INFINITY);
        let work = Work::of(Piece::Loops, &oscillator.curve);
        assert_eq!(some_cross_for_ever(&oscillator, &far, &work), Ok(true));
    }

    #[test]
    fn loops_lead_where_all_are_proved_to_lead() {
        let (mut random, mut seen) = (Random(0xfa5), [0; 3]);
        for i in 0..120 {
            let (law, values) = law(&mut random);
            let belt_speed = 0.01 * 3000_f64.powf(random.unit());
            let damping = if i % 2 == 0 { 0.0 } else { 1e-3 * 1e3_f64.powf(random.unit()) };
            let oscillator = Oscillator::new(&law, &law.point(1.0, &values, belt_speed, damping).unwrap());
            let far = FarLoops::new(&oscillator.curve, belt_speed);
            let (inward, outward) = (far.inward_from(damping), far.outward_from(damping));
            assert!(inward == f64::INFINITY || outward == f64::INFINITY, "{law:?} {values:?}");
            let from = inward.min(outward);
            if from == f64::INFINITY {
                continue;
            }
            seen[if outward < inward { 2 } else { usize::from(far.may_push()) }] += 1;
            for times in [1.0, 1.3, 3.0, 30.0] {
                let y = (from * times).max(1e-3);
                let end = reach(&oscillator, y, 1e-10).unwrap();
                let leads_outward = end - 2.0 * oscillator.fastest_sticking() > y;
                assert_eq!(
                    leads_outward,
                    outward < inward,
                    "{law:?} {values:?} {belt_speed} {damping}: {y} {end:?}"
                );
            }
        }
        assert!(seen.iter().all(|count| *count > 12), "{seen:?}");
    }
}
