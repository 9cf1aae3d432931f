//! How small is "sufficiently small": up to which eps a method's verdict holds.
//!
//! Along the ray of points with all parameters but eps fixed, a method's verdict and that of the simulated
//! flow are step functions of eps. The limit is the first eps at which they part.
//!
//! **How it is found.** The verdicts are compared at nodes of equal ratio; between the last node at which they
//! go together and the first at which they do not, the place is found by halving, to a relative width of
//! 1e-12. **What is assumed**: that they do not part and come together again between two neighbouring
//! nodes. For the Stribeck law the critical damping and every test's edge were monotone in eps wherever that
//! was looked at, so each verdict changes at most once at grazing and once at the landing; with 8 nodes per
//! factor of ten nothing was missed against a grid 40 times finer (tests/failures.rs).

use super::{Method, Verdict};
use crate::filippov::Oscillator;
use crate::friction::Law;
use crate::point::Point;
use crate::simulate::{Fate, flow};

/// Halvings after which an interval of one node's ratio is down to 1e-12 of itself.
const HALVINGS: u32 = 40;

/// The eps that are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EpsilonRange {
    /// Smallest eps, > 0; what holds here is taken to hold below.
    pub from: f64,
    /// Largest eps.
    pub to: f64,
    /// Nodes per factor of ten, at least 1.
    pub per_decade: u32,
}

impl Default for EpsilonRange {
    /// 1e-6 to 10, with 8 nodes per factor of ten.
    fn default() -> Self {
        Self { from: 1e-6, to: 10.0, per_decade: 8 }
    }
}

impl EpsilonRange {
    /// The nodes, in increasing order, both ends among them.
    pub fn nodes(&self) -> impl Iterator<Item = f64> + use<> {
        let decades = (self.to / self.from).log10();
        let intervals = (decades * f64::from(self.per_decade.max(1))).ceil().max(1.0);
        let (from, to) = (self.from, self.to);
        (0..=intervals as u32).map(move |i| {
            let share = f64::from(i) / intervals;
            if share < 1.0 { from * 10_f64.powf(decades * share) } else { to }
        })
    }
}

/// Up to which eps something holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Not even at the smallest eps that was looked at.
    Never,
    /// Up to here, and not just beyond.
    UpTo(f64),
    /// At every eps that was looked at.
    Throughout,
}

impl Limit {
    /// The limit as a number: 0 for never, infinity for throughout.
    #[must_use]
    pub fn value(self) -> f64 {
        match self {
            Limit::Never => 0.0,
            Limit::UpTo(epsilon) => epsilon,
            Limit::Throughout => f64::INFINITY,
        }
    }
}

/// How far a method can be trusted along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EpsilonLimit {
    /// Its verdict equals that of the simulated flow at all smaller eps.
    pub equal: Limit,
    /// It does not contradict the simulated flow at any smaller eps, though it may leave cells undecided.
    pub sound: Limit,
}

/// The point of the ray through `point` at another eps.
#[must_use]
pub fn at_epsilon(point: &Point, epsilon: f64) -> Point {
    Point { epsilon, ..*point }
}

/// The limits of `method` along the ray of eps through `point`; `tolerance` is that of the simulation.
#[must_use]
pub fn epsilon_limit(
    method: Method,
    law: Law,
    point: &Point,
    range: &EpsilonRange,
    tolerance: f64,
) -> EpsilonLimit {
    let verdicts = |epsilon: f64| {
        let here = at_epsilon(point, epsilon);
        (method.decide(&law.column(&here), here.damping, tolerance), simulated(law, &here, tolerance))
    };
    // Where the simulation itself has no answer there is nothing to compare.
    let equal = |(said, truth): (Verdict, Option<Verdict>)| truth.is_none_or(|truth| said == truth);
    let sound = |(said, truth): (Verdict, Option<Verdict>)| {
        truth.is_none_or(|truth| said == truth || !matches!(said, Verdict::Present | Verdict::Absent))
    };
    EpsilonLimit {
        equal: first_failure(range, |epsilon| equal(verdicts(epsilon))),
        sound: first_failure(range, |epsilon| sound(verdicts(epsilon))),
    }
}

/// The verdict of the simulated flow. At the very boundary, within its error, it is read off the margin's sign,
/// which halving needs; `None` if it fails.
fn simulated(law: Law, point: &Point, tolerance: f64) -> Option<Verdict> {
    let flow = flow(&Oscillator::new(law, point), tolerance);
    match flow.fate {
        Fate::Sticks(_) => Some(Verdict::Present),
        Fate::SpiralsInward | Fate::CrossesForever => Some(Verdict::Absent),
        Fate::TooCloseToCall if flow.margin > 0.0 => Some(Verdict::Present),
        Fate::TooCloseToCall if flow.margin < 0.0 => Some(Verdict::Absent),
        Fate::TooCloseToCall | Fate::Failed(_) => None,
    }
}

/// The first eps at which `holds` does not.
fn first_failure(range: &EpsilonRange, holds: impl Fn(f64) -> bool) -> Limit {
    let mut last = None;
    for epsilon in range.nodes() {
        if !holds(epsilon) {
            return match last {
                None => Limit::Never,
                Some(good) => Limit::UpTo(change(good, epsilon, holds)),
            };
        }
        last = Some(epsilon);
    }
    Limit::Throughout
}

/// The place between `good`, at which `holds`, and `bad`, at which it does not.
fn change(mut good: f64, mut bad: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = (good * bad).sqrt();
        *(if holds(middle) { &mut good } else { &mut bad }) = middle;
    }
    good
}

/// The eps nearest to that of `point` (in ratio) at which the verdict of the simulated flow changes along the
/// ray; `None` if it changes nowhere in `range`, or is not known at `point`.
#[must_use]
pub fn nearest_change(law: Law, point: &Point, range: &EpsilonRange, tolerance: f64) -> Option<f64> {
    let here = simulated(law, point, tolerance)?;
    let same = |epsilon: f64| {
        simulated(law, &at_epsilon(point, epsilon), tolerance).is_none_or(|verdict| verdict == here)
    };
    let ratio = 10_f64.powf(1.0 / f64::from(range.per_decade.max(1)));
    let (mut below, mut above) = (point.epsilon, point.epsilon);
    loop {
        let (lower, higher) = (below / ratio, above * ratio);
        let (look_below, look_above) = (lower >= range.from, higher <= range.to);
        if !look_below && !look_above {
            return None;
        }
        let changes: [Option<f64>; 2] = [
            (look_below && !same(lower)).then(|| change(below, lower, same)),
            (look_above && !same(higher)).then(|| change(above, higher, same)),
        ];
        let far = |epsilon: &f64| (epsilon / point.epsilon).ln().abs();
        if let Some(found) = changes.into_iter().flatten().min_by(|a, b| far(a).total_cmp(&far(b))) {
            return Some(found);
        }
        if look_below {
            below = lower;
        }
        if look_above {
            above = higher;
        }
    }
}
