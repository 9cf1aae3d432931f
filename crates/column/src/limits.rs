//! Limits in eps: the largest eps up to which a method's verdict equals that of the simulated flow.
//!
//! With all parameters but eps fixed, the verdicts of a method and of the simulated flow are step functions
//! of eps. [`Ray`] locates the steps of the flow once; [`Ray::limit`] locates the first eps at which a method
//! differs from the flow. Steps are located by bisection, to a relative width of 1e-12, without any grid.
//!
//! # Justification of "for all smaller eps"
//! **Theorems, for the Stribeck law** ([`ProvedThresholds`]). Both edges of the test `symmetric` fall as eps grows; so
//! the orbit from the exit point comes back for every eps below one closed form, and for none above another.
//! The landing speed is bounded by that of the linear flow with the largest divergence, which grows with eps;
//! so an orbit that comes back sticks for every eps below a third closed form. The three closed forms leave
//! an interval of eps, often empty or narrow, in which the flow must be computed. It is empty where
//! gamma (1-alpha) - 2 beta V <= c: no cycle exists at any eps > 0.
//!
//! **Search, in that interval** (for other laws, in all of [[`LOWEST`], [`HIGHEST`]]): the flow is computed
//! at `PER_DECADE` nodes per factor of ten, and every interval between nodes with different verdicts is
//! bisected. A pair of steps between neighbouring nodes would be missed. No pair at grazing is expected,
//! since c* falls with eps wherever that was tried (tests/mathematics/limits.rs). A pair at the landing is
//! possible: the orbit may land ever farther out and then closer again. So the maximum of the landing
//! distance is searched between the neighbours of a node with the farthest landing.
//!
//! **Methods.** The edges of `perturbation` and `bendixson_leading` do not depend on eps, and those of
//! `instability`, `symmetric` and `harmonic_balance` fall with eps. So c crosses each edge at most once, and
//! bisection finds that eps. The nodes may miss a claim of `bendixson` or of a landing that holds only
//! between two nodes, and alternations of the verdicts of naive methods, whose limit is that of the nodes. That
//! `validated` contradicts the flow nowhere is checked at the nodes and where its verdict changes.
//!
//! **Budget.** A ray and all limits along it spend at most `WORK`. If the budget is spent, or the flow has no
//! answer, limits found at smaller eps hold, and all others are [`EpsilonLimit::Unknown`], with the reason.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::f64::consts::TAU;

use super::{Method, Verdict};
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::{Fate, Flow};
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::Point;
use slipmap_orbits::{Effort, flow_with};

/// The smallest eps at which methods are evaluated; their verdicts below it are taken to be the same.
pub const LOWEST: f64 = 1e-6;
/// The largest eps considered.
pub const HIGHEST: f64 = 10.0;
/// Number of nodes per factor of ten.
pub const PER_DECADE: u32 = 8;
/// Largest number of bisections, which reduce an interval between nodes by a factor of 1e-12.
const HALVINGS: u32 = 40;
/// Width in log(eps) at which a bisection ends earlier.
const WIDTH: f64 = 1e-13;
/// Largest number of changes of a method's verdict that are located between two nodes.
const MOST_CHANGES: usize = 4;
/// Relative distance beyond a change at which the new verdict is evaluated; exceeds the error of its place.
const BEYOND: f64 = 1e-10;
/// Relative distance up to which a change of a method and a change of the flow are taken as one.
const SAME: f64 = 1e-9;
/// Number of golden sections in the search for the farthest landing, which reduce its interval by 1e-5.
const SECTIONS: u32 = 24;

/// Budget of a ray and its limits: evaluations of the right-hand side, in units of that of the Stribeck law
/// (see [`Curve::cost`](slipmap_model::friction::Curve::cost)). Rays of moderate parameters take a tenth of it,
/// without the naive methods.
pub const WORK: u64 = 4_000_000;

/// Reason why a limit is unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoEpsilonLimit {
    /// The simulated flow has no answer at some smaller eps.
    #[error("the simulated flow gives no answer at some smaller epsilon")]
    NoFlow,
    /// The budget `WORK` was spent before the limit was found.
    #[error("its search was given up, since it takes too much work")]
    GivenUp,
    /// Of a point, only closed-form tests are asked for theirs: the others would take most of the time.
    #[error("only maps and tables of points have it")]
    NotSought,
}

/// The range of eps, from 0 up, in which a method's verdict equals that of the simulated flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EpsilonLimit {
    /// They differ even as eps -> 0.
    Never,
    /// They are equal at all smaller eps, and differ just beyond this one.
    UpTo(f64),
    /// They are equal at every eps up to [`HIGHEST`].
    Throughout,
    /// The limit is unknown.
    Unknown(NoEpsilonLimit),
}

impl EpsilonLimit {
    /// The limit as a number: 0 for `Never`, infinity for `Throughout`, NaN for `Unknown`.
    #[must_use]
    pub fn value(self) -> f64 {
        match self {
            EpsilonLimit::Never => 0.0,
            EpsilonLimit::UpTo(epsilon) => epsilon,
            EpsilonLimit::Throughout => f64::INFINITY,
            EpsilonLimit::Unknown(_) => f64::NAN,
        }
    }

    /// The reason why the limit is unknown; `None` if it is known.
    #[must_use]
    pub fn unknown(self) -> Option<NoEpsilonLimit> {
        match self {
            EpsilonLimit::Unknown(why) => Some(why),
            EpsilonLimit::Never | EpsilonLimit::UpTo(_) | EpsilonLimit::Throughout => None,
        }
    }
}

/// Thresholds in eps that are proved in closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProvedThresholds {
    /// A stick-slip cycle exists at every eps below this.
    pub present_below: f64,
    /// Above this eps no cycle exists, and the orbit from the exit point does not come back.
    pub absent_above: f64,
}

impl ProvedThresholds {
    const NOTHING: ProvedThresholds = ProvedThresholds { present_below: 0.0, absent_above: f64::INFINITY };

    /// The thresholds for the ray through `point`, whose own eps does not matter.
    ///
    /// For the Stribeck law with g = gamma (1-alpha) and s = c + 2 beta V, by the theorem of
    /// [`slipmap_certify::symmetric`]: the orbit returns if s < g / (1 + eps gamma V)^2, and does not if
    /// s > (g/2) (1 + 1/(1 + 2 eps gamma V)^2). The divergence is at most d = eps (g - c). In the linear flow
    /// with divergence d one turn multiplies v^2 + v'^2 by F = exp(2 pi d / sqrt(1 - d^2/4)). So, by the
    /// comparison lemma of [`slipmap_certify`], the landing speed is below 2 if V^2 (F - 1) < 4.
    #[must_use]
    pub fn of(law: &Law, point: &Point) -> Self {
        let (Law::Stribeck, &[alpha, beta, gamma]) = (law.as_written(), point.law.as_slice()) else {
            return Self::NOTHING;
        };
        let (speed, c) = (point.belt_speed, point.damping);
        let (drop, loss) = (gamma * (1.0 - alpha), c + 2.0 * beta * speed);
        if drop == 0.0 && loss == 0.0 {
            // The divergence vanishes: every orbit is a circle.
            return Self::NOTHING;
        }
        if drop <= loss {
            return Self { present_below: 0.0, absent_above: 0.0 };
        }
        let rate = gamma * speed;
        let returns = ((drop / loss).sqrt() - 1.0) / rate;
        let energy = (1.0 + 4.0 / (speed * speed)).ln() / TAU;
        let lands = energy / (1.0 + 0.25 * energy * energy).sqrt() / (drop - c);
        let share = 2.0 * loss / drop - 1.0;
        let absent_above =
            if share > 0.0 { (1.0 / share.sqrt() - 1.0) / (2.0 * rate) } else { f64::INFINITY };
        Self { present_below: returns.min(lands), absent_above }
    }
}

/// All points that differ only in eps, with the verdicts of the simulated flow along them.
#[derive(Clone, Debug)]
pub struct Ray {
    law: Law,
    point: Point,
    tolerance: f64,
    /// The verdict as eps -> 0.
    first: Verdict,
    /// The eps at which the verdict changes, increasing, and the verdict beyond each.
    changes: Vec<(f64, Verdict)>,
    /// The eps from which on the flow is unknown, and the reason.
    unknown_from: Option<(f64, NoEpsilonLimit)>,
    /// The part of the budget [`WORK`] that is not spent.
    left: Cell<u64>,
    /// The columns computed so far, by the bits of eps, so that a law is compiled once for all methods.
    columns: RefCell<HashMap<u64, Column>>,
}

/// A coordinate of the landing of an orbit that sticks; `None` for others. It is 0 next to grazing, 2 at the
/// far end of the stick segment, 4 where the orbit has crossed, comes back, and just sticks.
fn reach(oscillator: &Oscillator, flow: &Flow) -> Option<f64> {
    let landing = flow.landing()?;
    let from_exit = oscillator.exit_x1() - landing.x1;
    Some(if landing.crossings == Some(1) { 4.0 - from_exit } else { from_exit })
}

/// The verdict of the simulated flow. Where the margin is within its error its sign decides, since bisection
/// needs a verdict; undecided if the margin is zero or NaN, as for circles.
fn verdict_of(flow: &Flow) -> Verdict {
    match flow.fate {
        Fate::TooCloseToCall if flow.margin > 0.0 => Verdict::Present,
        Fate::TooCloseToCall if flow.margin < 0.0 => Verdict::Absent,
        _ => Verdict::from(&flow.fate),
    }
}

/// Nodes in equal ratios from `from` to `to`, ends included; none if `from` > `to`.
fn nodes(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let decades = (to / from).log10();
    let intervals = (decades * f64::from(PER_DECADE)).ceil().max(1.0);
    let count = if from <= to { intervals as u32 + 1 } else { 0 };
    (0..count).map(move |i| {
        let share = f64::from(i) / intervals;
        if share < 1.0 { from * 10_f64.powf(decades * share) } else { to }
    })
}

/// Bisects log(eps) between `holding`, where `holds` is true, and `other`, on either side, where it is false.
fn halve(
    mut holding: f64,
    mut other: f64,
    holds: impl Fn(f64) -> Result<bool, NoEpsilonLimit>,
) -> Result<f64, NoEpsilonLimit> {
    for _ in 0..HALVINGS {
        if (holding / other).ln().abs() < WIDTH {
            break;
        }
        let middle = (holding * other).sqrt();
        *(if holds(middle)? { &mut holding } else { &mut other }) = middle;
    }
    Ok((holding * other).sqrt())
}

/// The eps between two nodes at which a method's verdict changes, increasing, each with the new verdict.
/// Between presence and absence a method may be undecided in an interval far narrower than that of the nodes.
fn changes(
    [low, high]: [f64; 2],
    at_low: Verdict,
    verdict_at: impl Fn(f64) -> Result<Verdict, NoEpsilonLimit>,
) -> Result<Vec<(f64, Verdict)>, NoEpsilonLimit> {
    let last = verdict_at(high)?;
    let (mut from, mut verdict) = (low, at_low);
    let mut changes = Vec::new();
    while verdict != last && changes.len() < MOST_CHANGES {
        let place = halve(from, high, |epsilon| Ok(verdict_at(epsilon)? == verdict))?;
        from = (place * (1.0 + BEYOND)).min(high);
        verdict = verdict_at(from)?;
        changes.push((place, verdict));
    }
    if let Some(change) = changes.last_mut() {
        change.1 = last;
    }
    Ok(changes)
}

/// The flow at one eps.
#[derive(Clone, Copy, Debug)]
struct FlowAt {
    epsilon: f64,
    verdict: Verdict,
    /// See [`reach`].
    reach: Option<f64>,
}

impl Ray {
    /// The ray through `point`, whose own eps does not matter; `tolerance` is that of the simulation.
    #[must_use]
    pub fn new(law: &Law, point: &Point, tolerance: f64) -> Self {
        let proved = ProvedThresholds::of(law, point);
        let from = proved.present_below.max(LOWEST);
        let to = proved.absent_above.min(HIGHEST);
        let first = match proved {
            ProvedThresholds { present_below, .. } if present_below > 0.0 => Verdict::Present,
            // Absence at every eps, or from an eps below LOWEST on.
            ProvedThresholds { absent_above, .. } if absent_above == 0.0 || from > to => Verdict::Absent,
            _ => Verdict::Undecided,
        };
        let mut ray = Self {
            law: law.clone(),
            point: *point,
            tolerance,
            first,
            changes: Vec::new(),
            unknown_from: None,
            left: Cell::new(WORK),
            columns: RefCell::default(),
        };
        let found = ray.search(from, to);
        ray.unknown_from = found.err();
        let last = ray.changes.last().map_or(ray.first, |change| change.1);
        // Proved verdicts need no computation, even beyond the last node.
        if to < HIGHEST && last.is_decision() && last != Verdict::Absent {
            ray.changes.push((to, Verdict::Absent));
        }
        ray.changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        ray
    }

    /// Computes the flow at the nodes and locates the steps between them. An error contains the eps from
    /// which on the verdict is unknown.
    fn search(&mut self, from: f64, to: f64) -> Result<(), (f64, NoEpsilonLimit)> {
        let mut flows: Vec<FlowAt> = Vec::new();
        let mut last = (from, self.first);
        let mut stop = None;
        for epsilon in nodes(from, to) {
            match self.flow_at(epsilon) {
                Ok(answer) => flows.push(answer),
                Err(why) => {
                    let known = if self.first.is_decision() { from } else { 0.0 };
                    stop = Some((flows.last().map_or(known, |flow| flow.epsilon), why));
                    break;
                }
            }
        }
        if let (Some(node), Verdict::Undecided) = (flows.first(), self.first) {
            (self.first, last.1) = (node.verdict, node.verdict);
        }
        for (i, &FlowAt { epsilon, verdict, .. }) in flows.iter().enumerate() {
            // A flow without a decision makes no step.
            if verdict.is_decision() && last.1.is_decision() && verdict != last.1 {
                let place = self.halve(last.0, epsilon, last.1).map_err(|why| (last.0, why))?;
                self.changes.push((place, verdict));
            } else if let Some([low, farthest, high]) =
                self.overshoot_beside(&flows, i).map_err(|why| (last.0, why))?
            {
                let leaves = self.halve(low, farthest, Verdict::Present).map_err(|why| (low, why))?;
                self.changes.push((leaves, Verdict::Absent));
                let again = self.halve(high, farthest, Verdict::Present).map_err(|why| (farthest, why))?;
                self.changes.push((again, Verdict::Present));
            }
            if verdict.is_decision() {
                last = (epsilon, verdict);
            }
        }
        stop.map_or(Ok(()), Err)
    }

    fn flow_at(&self, epsilon: f64) -> Result<FlowAt, NoEpsilonLimit> {
        let oscillator = Oscillator::in_column(&self.column(epsilon)?, self.point.damping);
        let flow = flow_with(Effort::Small, &oscillator, self.tolerance);
        self.spend(flow.rhs * oscillator.curve.cost())?;
        match flow.fate {
            Fate::Failed(_) => Err(NoEpsilonLimit::NoFlow),
            _ => Ok(FlowAt { epsilon, verdict: verdict_of(&flow), reach: reach(&oscillator, &flow) }),
        }
    }

    fn column(&self, epsilon: f64) -> Result<Column, NoEpsilonLimit> {
        if let Some(known) = self.columns.borrow().get(&epsilon.to_bits()) {
            return Ok(known.clone());
        }
        let column = self.law.column(&Point { epsilon, ..self.point });
        // Where the law does not depend on eps, all columns share the curve that the first one compiles.
        let compiles = self.law.depends_on_epsilon() || self.columns.borrow().is_empty();
        if compiles {
            self.spend(column.curve.compiling_work(column.belt_speed))?;
        }
        self.columns.borrow_mut().insert(epsilon.to_bits(), column.clone());
        Ok(column)
    }

    /// Subtracts `work` from the budget; returns an error if nothing is left.
    fn spend(&self, work: u64) -> Result<(), NoEpsilonLimit> {
        let left = self.left.get().saturating_sub(work);
        self.left.set(left);
        if left > 0 { Ok(()) } else { Err(NoEpsilonLimit::GivenUp) }
    }

    /// Bisects between an eps at which the flow has `verdict`, and one at which it has another.
    fn halve(&self, has: f64, has_not: f64, verdict: Verdict) -> Result<f64, NoEpsilonLimit> {
        halve(has, has_not, |epsilon| Ok(self.flow_at(epsilon)?.verdict == verdict))
    }

    /// If the orbit sticks at node `i` and at both neighbours, and lands farthest out at node `i`: searches
    /// for an eps between the neighbours at which the orbit does not stick. Returns the eps of the lower
    /// neighbour, that eps, and the eps of the upper neighbour.
    fn overshoot_beside(&self, flows: &[FlowAt], i: usize) -> Result<Option<[f64; 3]>, NoEpsilonLimit> {
        let neighbours = i.checked_sub(1).and_then(|i| flows.get(i)).zip(flows.get(i + 1));
        let Some((before, after)) = neighbours else { return Ok(None) };
        let (Some(here), Some(left), Some(right)) = (flows[i].reach, before.reach, after.reach) else {
            return Ok(None);
        };
        // At c = 0 orbits of a law without eps land alike at every eps.
        if here < left || here < right || here == left && here == right {
            return Ok(None);
        }
        // An orbit with a reach above 4 never sticks.
        let value = |epsilon: f64| {
            let FlowAt { reach, verdict, .. } = self.flow_at(epsilon)?;
            Ok(reach.unwrap_or(if verdict == Verdict::Absent { 5.0 } else { 0.0 }))
        };
        let golden = 0.5 * (5_f64.sqrt() - 1.0);
        let (mut low, mut high) = (before.epsilon.ln(), after.epsilon.ln());
        let inner = |low: f64, high: f64| [high - golden * (high - low), low + golden * (high - low)];
        let mut places = inner(low, high);
        let mut values = [value(places[0].exp())?, value(places[1].exp())?];
        for _ in 0..SECTIONS {
            if let Some(which) = values.iter().position(|&value| value > 4.0) {
                return Ok(Some([before.epsilon, places[which].exp(), after.epsilon]));
            }
            if values[0] < values[1] {
                (low, places[0], values[0]) = (places[0], places[1], values[1]);
                places[1] = inner(low, high)[1];
                values[1] = value(places[1].exp())?;
            } else {
                (high, places[1], values[1]) = (places[1], places[0], values[0]);
                places[0] = inner(low, high)[0];
                values[0] = value(places[0].exp())?;
            }
        }
        Ok(None)
    }

    /// The verdict of the flow as eps -> 0, and each eps up to [`HIGHEST`] at which it changes, with the new
    /// verdict.
    #[must_use]
    pub fn steps(&self) -> (Verdict, &[(f64, Verdict)]) {
        (self.first, &self.changes)
    }

    /// The eps nearest to `epsilon` at which the verdict of the flow changes; `None` if it changes nowhere up
    /// to [`HIGHEST`].
    #[must_use]
    pub fn nearest_change(&self, epsilon: f64) -> Option<f64> {
        let places = self.changes.iter().map(|(place, _)| *place);
        places.min_by(|a, b| (a - epsilon).abs().total_cmp(&(b - epsilon).abs()))
    }

    /// The limit in eps of `method`.
    #[must_use]
    pub fn limit(&self, method: Method) -> EpsilonLimit {
        match (self.first_difference(method), self.unknown_from) {
            (Ok(Some(found)), _) => found,
            (Err(why), _) | (Ok(None), Some((_, why))) => EpsilonLimit::Unknown(why),
            (Ok(None), None) => EpsilonLimit::Throughout,
        }
    }

    /// Goes through the verdicts of `method` and of the flow in increasing eps, as far as both are known. Returns
    /// where they begin to differ; `None` if they do not.
    fn first_difference(&self, method: Method) -> Result<Option<EpsilonLimit>, NoEpsilonLimit> {
        if method == Method::Simulation {
            return Ok(None);
        }
        let end = self.unknown_from.map_or(HIGHEST, |(from, _)| from);
        if end < LOWEST {
            return Ok(None);
        }
        let verdict_at = |epsilon: f64| {
            // Stop if the budget is spent.
            self.spend(0)?;
            let (column, damping) = (self.column(epsilon)?, self.point.damping);
            match method {
                // Each eps would need a proof of its own.
                Method::Test(_) if method == Method::validated() => Err(NoEpsilonLimit::GivenUp),
                Method::Test(test) => Ok(test.claim(&column).decide(damping).into()),
                Method::Naive(naive, knobs) => {
                    let oscillator = Oscillator::in_column(&column, damping);
                    let answer = naive.decide(&oscillator, &knobs);
                    self.spend(answer.rhs * oscillator.curve.cost())?;
                    Ok(Verdict::from(answer.verdict))
                }
                // The direct engine is the judge of the other, and no part of a search.
                Method::Simulation | Method::Direct => Err(NoEpsilonLimit::GivenUp),
            }
        };
        // An undecided flow is not compared.
        let differ = |(verdict, truth): (Verdict, Verdict)| truth.is_decision() && verdict != truth;
        // The pairs (method, flow) in increasing eps.
        let mut pair = (verdict_at(LOWEST)?, self.first);
        if differ(pair) {
            return Ok(Some(EpsilonLimit::Never));
        }
        let mut truth = self.changes.iter().peekable();
        let mut low = LOWEST;
        for high in nodes(LOWEST, end).skip(1) {
            let mut own = changes([low, high], pair.0, verdict_at)?.into_iter().peekable();
            loop {
                let flow_changes = truth.peek().filter(|(place, _)| *place <= high).map(|(place, _)| *place);
                let own_changes = own.peek().map(|(place, _)| *place);
                let place = match (own_changes, flow_changes) {
                    (None, None) => break,
                    (Some(own), Some(flow)) if own < flow => own,
                    (Some(own), None) => own,
                    (_, Some(flow)) => flow,
                };
                // Changes within the errors of their places are taken as one.
                let together = place * (1.0 + SAME);
                while let Some((_, verdict)) = own.next_if(|change| change.0 <= together) {
                    pair.0 = verdict;
                }
                while let Some((_, verdict)) = truth.next_if(|change| change.0 <= together) {
                    pair.1 = *verdict;
                }
                if differ(pair) {
                    return Ok(Some(EpsilonLimit::UpTo(place)));
                }
            }
            low = high;
        }
        Ok(None)
    }
}
