//! The dampings at which the behaviour of a column changes, as one sorted list.
//!
//! Every orbit shrinks as C = eps c grows (theory, "Monotonicity"). So what happens at a damping is a question of the sides on
//! which it lies of a few values:
//!
//! | change | where | below it | above it |
//! | --- | --- | --- | --- |
//! | Hopf | C(0) = w(V) | steady slip repels | it attracts |
//! | fold | an extreme of C(r), 0 < r < V | two slip cycles more, or fewer | |
//! | unresolved | where a backbone is flat within its error | | |
//! | grazing | C(V), of a law with a drop | the orbit at rest on the belt line comes back to it | it spirals inward |
//! | return | eps c* | the orbit from the exit point comes back | it spirals inward |
//! | crossing | | that orbit crosses the belt line for ever | it sticks |
//! | far crossing | | some orbit crosses for ever | none does |

use slipmap_model::flow::{Failure, Fate};
use slipmap_numbers::named;
use slipmap_orbits::{Piece, Work, flow_within};

use crate::backbone::Backbone;
use crate::behaviour::Behaviour;
use crate::critical::{HALVINGS, critical_damping_with, last_below, sticks_from};
use crate::crossing::no_loop_needed;
use crate::{DEFAULT_TOLERANCE, End, Regime};

/// Number of bisections that locate a far crossing, after steps by the factor `STEP`.
const OF_LOOPS: u32 = 20;
const STEP: f64 = 8.0;
/// Least damping up to which these steps lead, in units of the first.
const LEAST: f64 = 1e-9;

named! {
    /// What changes at a damping, with its name in JSON.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ChangeKind {
        /// Steady slip begins to attract.
        Hopf => "hopf",
        /// Two slip cycles meet.
        Fold => "fold",
        /// Slip cycles may meet: next to it their number is not told.
        Unresolved => "unresolved",
        /// With a drop of friction: the orbit from rest on the belt line ceases to come back to it.
        Grazing => "grazing",
        /// The orbit from the exit point ceases to come back to the belt line: the critical damping.
        Return => "return",
        /// The orbit from the exit point ceases to cross the belt line for ever.
        Crossing => "crossing",
        /// All orbits cease to do so.
        FarCrossing => "far_crossing",
    }
}

/// A damping at which the behaviour changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// What changes there.
    pub kind: ChangeKind,
    /// C = eps c there.
    pub viscous: f64,
    /// Bounds of it, between which it is not known on which side of the change a damping lies. They are far apart where
    /// orbits cannot be followed, and infinite above where it may be anywhere.
    pub between: [f64; 2],
    /// Why orbits between them cannot be followed, where that keeps the bounds apart.
    pub failure: Option<Failure>,
}

impl Change {
    fn near(kind: ChangeKind, viscous: f64, error: f64) -> Self {
        Self { kind, viscous, between: [viscous - error, viscous + error], failure: None }
    }

    fn within(kind: ChangeKind, between: [f64; 2], failure: Option<Failure>) -> Self {
        let [low, high] = between;
        let viscous = if high < f64::INFINITY { 0.5 * (low + high) } else { low };
        Self { kind, viscous, between, failure }
    }

    /// Whether C = `viscous` is below it; `None` where that is not known.
    #[must_use]
    pub fn is_above(&self, viscous: f64) -> Option<bool> {
        match self.between {
            [low, _] if viscous < low => Some(true),
            [_, high] if viscous > high => Some(false),
            _ => None,
        }
    }
}

/// The folds of a backbone, and where it does not tell how many slip cycles there are.
fn of_backbone(backbone: &Backbone) -> Vec<Change> {
    let mut ranges = backbone.uncertain().to_vec();
    ranges.sort_by(|one, other| one[0].total_cmp(&other[0]));
    ranges.dedup_by(|next, last| {
        let overlap = next[0] <= last[1];
        if overlap {
            last[1] = last[1].max(next[1]);
        }
        overlap
    });
    let changes = ranges.into_iter().flat_map(|between| {
        let within = |kind| Change::within(kind, between, None);
        let is_there = |viscous: f64| (between[0]..=between[1]).contains(&viscous);
        let folds = backbone.folds().iter().map(|fold| fold.viscous).filter(|viscous| is_there(*viscous));
        let folds: Vec<_> = folds.map(|viscous| Change { viscous, ..within(ChangeKind::Fold) }).collect();
        if folds.is_empty() { vec![within(ChangeKind::Unresolved)] } else { folds }
    });
    changes.collect()
}

impl Behaviour<'_> {
    /// All changes at dampings C > 0, by growing damping.
    pub fn changes(&self) -> &[Change] {
        self.changes.get_or_init(|| {
            let returns = self.returns_below();
            let hopf = Change::near(ChangeKind::Hopf, self.hopf.value(), self.hopf.error());
            let mut found = vec![hopf, returns];
            found.extend(self.folds());
            if self.curve.drop() > 0.0 {
                found.push(match self.grazing() {
                    Some(known) => Change::near(ChangeKind::Grazing, known.c, known.error),
                    None => Change::within(ChangeKind::Grazing, [0.0, returns.between[1]], returns.failure),
                });
            }
            found.extend(self.crosses_below(returns.between[0]));
            found.extend(self.some_cross_below());
            found.retain(|change| change.between[1] > 0.0);
            found.sort_by(|one, other| one.viscous.total_cmp(&other.viscous));
            found
        })
    }

    /// How the orbit from the exit point ends at C = `viscous`, by the changes.
    pub fn end_at(&self, viscous: f64) -> End {
        let is_below = |kind: ChangeKind| {
            let change = self.changes().iter().find(|change| change.kind == kind);
            change.map_or(Some(false), |change| change.is_above(viscous))
        };
        match (is_below(ChangeKind::Return), is_below(ChangeKind::Crossing)) {
            (Some(false), _) => End::Inward,
            (_, Some(true)) => End::Crosses,
            (Some(true), Some(false)) => End::Sticks,
            _ => End::TooClose,
        }
    }

    /// The regime at C = `viscous`, by the changes.
    pub fn regime_at(&self, viscous: f64) -> Regime {
        self.regime(viscous, self.end_at(viscous), None, false)
    }

    /// The critical damping; where the orbit that grazes cannot be followed, bounds by those of other dampings.
    fn returns_below(&self) -> Change {
        let column = self.column();
        if let Ok(found) = critical_damping_with(self.effort, &column, DEFAULT_TOLERANCE) {
            return Change::near(ChangeKind::Return, found.c, found.error);
        }
        // With D <= -2 wherever it may lead, the orbit never returns (theory, "Breakaway").
        let fastest = self.belt_speed + self.belt_speed.hypot(self.curve.drop());
        let most = 2.0 + self.curve.weakening_range(0.0, fastest.min(self.curve.fastest())).hi.max(0.0);
        if most == f64::INFINITY {
            return Change::within(ChangeKind::Return, [0.0, most], None);
        }
        let (work, mut failure) = (Work::with(self.effort, Piece::SticksFrom, self.curve), None);
        let returns = |viscous: f64| {
            let fate = flow_within(&self.oscillator(viscous), DEFAULT_TOLERANCE, &work).fate;
            if let Fate::Failed(why) = fate {
                failure = Some(why);
            }
            End::from(&fate).returns()
        };
        Change::within(ChangeKind::Return, last_below([0.0, most], HALVINGS, returns), failure)
    }

    /// Where slip cycles meet, or may; anywhere where no closed orbits are known.
    fn folds(&self) -> Vec<Change> {
        if self.has_one_at_most() {
            return Vec::new();
        }
        self.read_last(of_backbone).unwrap_or_else(|why| {
            let even = self.even();
            vec![Change::within(ChangeKind::Unresolved, [even.lo.max(0.0), even.hi], Some(why))]
        })
    }

    /// The damping below which the orbit from the exit point crosses for ever, if there is one; it is known to return below
    /// `returning`.
    fn crosses_below(&self, returning: f64) -> Option<Change> {
        if returning <= 0.0 {
            return None;
        }
        let found = sticks_from(self.effort, &self.column(), [0.0, returning], HALVINGS, DEFAULT_TOLERANCE);
        let [low, high] = found.between;
        (low < high).then(|| Change::within(ChangeKind::Crossing, found.between, found.failure))
    }

    /// The damping below which some orbits cross for ever, if there is one.
    fn some_cross_below(&self) -> Option<Change> {
        if no_loop_needed(&self.oscillator(0.0), self.far()) == Some(false) {
            return None;
        }
        let some_cross = |viscous: f64| self.some_cross_for_ever(viscous);
        // About the damping from which on friction, which changes x2 by 1 at most, carries no orbit across.
        let most = 2.0 / self.belt_speed;
        let mut high = most;
        if some_cross(high) != Some(false) {
            return Some(Change::within(ChangeKind::FarCrossing, [0.0, f64::INFINITY], None));
        }
        while high > LEAST * most && some_cross(high / STEP) == Some(false) {
            high /= STEP;
        }
        let between = last_below([0.0, high], OF_LOOPS, some_cross);
        (between[0] < between[1]).then(|| Change::within(ChangeKind::FarCrossing, between, None))
    }
}
