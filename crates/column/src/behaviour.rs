//! The attractors of a column at each of its dampings, from one backbone.

use std::cell::OnceCell;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::Regime;
use super::end::End;
use super::verdict::Attractors;
use crate::backbone::{Backbone, COARSE, CycleRange, InterpolatedBackbone};
use crate::critical::critical_damping_with;
use crate::crossing::{crossing_cycles, landing_and_cycle, no_loop_needed, some_cross_for_ever};
use crate::slip_cycle::TIGHT;
use crate::slip_cycle::{BACKBONE_TOLERANCE, CyclesUnknown, Kick, kick_onto, kick_onto_grazing, locate};
use crate::{Change, CriticalDamping, Neighbour};
use slipmap_model::filippov::{HopfRate, Oscillator, Stability};
use slipmap_model::flow::{Failure, Fate, Flow};
use slipmap_model::friction::{Column, Curve, Range};
use slipmap_numbers::text::rounded;
use slipmap_orbits::far_loops::FarLoops;
use slipmap_orbits::{Cycle, Effort, Piece, Work};

/// Tolerance of C(V) of a curve with a drop.
const GRAZING: f64 = 1e-11;

/// Number of fixed dampings, each half-way between two others, at which loops are followed before those of the damping itself:
/// they serve all dampings, and what they tell does not depend on what else was asked.
const PLACES: usize = 5;

/// The edge of a basin: the outermost slip cycle that repels. With a drop of friction, between C(V) and eps c*,
/// the orbit that grazes the belt line, closed by a piece of that line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasinBoundary {
    /// The slip cycle; `None` where the edge is the grazing orbit.
    pub cycle: Option<Cycle>,
    /// The largest x2 on it.
    pub radius: f64,
    /// The kicks that carry steady slip onto it.
    pub kick: Kick,
    /// Where it is the grazing orbit: from the time j/V before the end of the stick phase on, and for as long as
    /// this, any disturbance against the belt ends stick-slip (theory, "Breakaway").
    pub fragile_time: Option<f64>,
    /// The attractors of orbits just inside it and just outside it.
    pub separates: [Neighbour; 2],
}

/// The attractors of one friction curve and belt speed, for all dampings. Each piece of knowledge is computed when an answer
/// needs it, once, within a quota of its own: an answer is the same in any order of questions, and from any thread.
pub struct Behaviour<'a> {
    pub(crate) curve: &'a Curve,
    pub(crate) belt_speed: f64,
    pub(crate) effort: Effort,
    pub(crate) hopf: HopfRate<'a>,
    even: OnceLock<Range>,
    has_one_at_most: OnceLock<bool>,
    /// Coarse backbones, each with twice as many nodes as the one before. Every damping tries them in this
    /// order, so that its answer does not depend on other dampings.
    coarse: Mutex<Coarse>,
    /// The backbone of full accuracy.
    fine: OnceLock<Result<Backbone, Failure>>,
    /// Where loops far beyond the exit point lead.
    far: OnceLock<FarLoops<'a>>,
    grazing: OnceLock<Option<CriticalDamping>>,
    /// Whether some orbits cross for ever at a damping, by its bits.
    crosses: Mutex<HashMap<u64, Option<bool>>>,
    /// The dampings at which anything changes.
    pub(crate) changes: OnceLock<Vec<Change>>,
}

/// The coarse backbones so far, and what is left of their quota.
struct Coarse {
    levels: Vec<Result<Arc<Backbone>, Failure>>,
    work: Work,
}

/// Keeps the behaviour of the last column that was requested. Columns that differ only in eps share it if the
/// law does not contain eps, which then only scales the damping.
#[derive(Default)]
pub struct Behaviours<'a> {
    last: Option<Behaviour<'a>>,
}

impl<'a> Behaviours<'a> {
    /// The behaviour of a column.
    pub fn of(&mut self, column: &'a Column) -> &Behaviour<'a> {
        let same = |it: &Behaviour| it.belt_speed == column.belt_speed && *it.curve == column.curve;
        if !self.last.as_ref().is_some_and(same) {
            self.last = None;
        }
        self.last.get_or_insert_with(|| Behaviour::new(&column.curve, column.belt_speed))
    }
}

impl<'a> Behaviour<'a> {
    /// The behaviour of a curve at a belt speed; nothing is computed yet.
    pub fn new(curve: &'a Curve, belt_speed: f64) -> Self {
        Self::with(Effort::Whole, curve, belt_speed)
    }

    /// [`Self::new`] with an effort.
    pub fn with(effort: Effort, curve: &'a Curve, belt_speed: f64) -> Self {
        let coarse = Coarse { levels: Vec::new(), work: Work::with(effort, Piece::CoarseBackbones, curve) };
        Self {
            curve,
            belt_speed,
            effort,
            hopf: HopfRate::new(curve, belt_speed),
            even: OnceLock::new(),
            has_one_at_most: OnceLock::new(),
            coarse: Mutex::new(coarse),
            fine: OnceLock::new(),
            far: OnceLock::new(),
            grazing: OnceLock::new(),
            crosses: Mutex::default(),
            changes: OnceLock::new(),
        }
    }

    /// The column at the damping of an oscillator, where the orbit from the exit point ends as `end`.
    pub fn at<'b>(&'b self, oscillator: &'b Oscillator, end: End, tolerance: f64) -> At<'b, 'a> {
        At { behaviour: self, oscillator, end, tolerance, cycles: OnceCell::new() }
    }

    /// What small disturbances of steady slip do at eps c = `viscous`.
    pub fn stability(&self, viscous: f64) -> Stability {
        self.hopf.stability(viscous)
    }

    /// Whether the equilibrium attracts at eps c = `viscous`; `None` where it is neutral. Where friction is
    /// constant next to the belt speed and there is no damping, all orbits about it close.
    fn equilibrium_attracts(&self, viscous: f64) -> Option<bool> {
        match self.stability(viscous) {
            Stability::Attracts => Some(true),
            Stability::Neutral => None,
            Stability::Repels => Some(false),
        }
    }

    /// Whether the orbit from (V, 0) returns to the belt line, where that from the exit point ends as `end`;
    /// `None` if that is unknown. Only with a drop are they two orbits: then C(V) < eps c*. By C(V), too, where the orbit
    /// from the exit point cannot be followed to its end.
    fn grazing_returns(&self, viscous: f64, end: End) -> Option<bool> {
        match end.returns() {
            Some(true) if self.curve.drop() > 0.0 => {}
            None => {}
            known => return known,
        }
        let CriticalDamping { c, error, .. } = self.grazing()?;
        ((c - viscous).abs() > error).then_some(viscous < c)
    }

    /// C(V) of a curve with a drop, with its error; `None` where it is unknown.
    pub(crate) fn grazing(&self) -> Option<CriticalDamping> {
        *self.grazing.get_or_init(|| {
            let column = Column { curve: self.curve.without_drop(), ..self.column() };
            critical_damping_with(self.effort, &column, GRAZING).ok()
        })
    }

    /// The column whose dampings are C.
    pub(crate) fn column(&self) -> Column {
        Column { curve: self.curve.clone(), epsilon: 1.0, belt_speed: self.belt_speed, unit: 1.0 }
    }

    /// Bounds of the even part of the weakening rate about the belt speed.
    pub(crate) fn even(&self) -> &Range {
        self.even.get_or_init(|| self.curve.even_weakening_range(self.belt_speed))
    }

    /// Whether at most one slip cycle is proved to exist at each damping.
    pub(crate) fn has_one_at_most(&self) -> bool {
        *self.has_one_at_most.get_or_init(|| self.curve.has_one_slip_cycle_at_most(self.belt_speed))
    }

    /// The slip cycles at eps c = `viscous`, where the orbit from the exit point ends as `end`, between any bounds: for their
    /// number and their stability. By the even part, where at most one is proved to exist, or else by a backbone.
    ///
    /// # Errors
    /// [`CyclesUnknown`].
    pub fn count(&self, viscous: f64, end: End) -> Result<Vec<CycleRange>, CyclesUnknown> {
        let stable = self.equilibrium_attracts(viscous).ok_or(CyclesUnknown::Neutral)?;
        if self.even().excludes(viscous) {
            return Ok(Vec::new());
        }
        let returns = self.grazing_returns(viscous, end).ok_or(CyclesUnknown::TooClose)?;
        if self.has_one_at_most() {
            // A repelling one if the equilibrium is stable and the orbit returns, an attracting one if neither holds.
            let one = CycleRange::between([0.0, self.belt_speed], !returns);
            return Ok(if stable == returns { vec![one] } else { Vec::new() });
        }
        self.read(viscous, |backbone| backbone.cycles(viscous, stable, returns))?
            .ok_or(CyclesUnknown::TooClose)
    }

    /// What is read from the first coarse backbone that is reliable at `viscous`, from the last where it is rough, or else
    /// from the fine one.
    fn read<T>(&self, viscous: f64, read: impl FnOnce(&Backbone) -> T) -> Result<T, Failure> {
        for level in 0.. {
            let Some(coarse) = self.coarse(level) else { break };
            // Where a coarse backbone fails, a fine one does.
            let coarse = coarse?;
            let is_last = || self.coarse(level + 1).is_none() && coarse.is_rough(self.curve);
            if coarse.is_reliable_at(viscous) || is_last() {
                return Ok(read(&coarse));
            }
        }
        Ok(read(self.backbone()?))
    }

    /// What is read from the backbone that shows most: the fine one, or the last of the coarse ones where that is rough.
    pub(crate) fn read_last<T>(&self, read: impl FnOnce(&Backbone) -> T) -> Result<T, Failure> {
        let mut last = None;
        for level in 0.. {
            let Some(coarse) = self.coarse(level) else { break };
            last = Some(coarse?);
        }
        match last.filter(|coarse| coarse.is_rough(self.curve)) {
            Some(coarse) => Ok(read(&coarse)),
            None => Ok(read(self.backbone()?)),
        }
    }

    /// A coarse backbone; `None` where the one before would not be improved.
    fn coarse(&self, level: usize) -> Option<Result<Arc<Backbone>, Failure>> {
        let mut coarse = self.coarse.lock().unwrap_or_else(PoisonError::into_inner);
        let Coarse { levels, work } = &mut *coarse;
        if level == levels.len() {
            let finer = match levels.last() {
                None => Backbone::coarsest(self.curve, self.belt_speed, COARSE, work).map(Some),
                Some(Ok(last)) => last.refined(self.curve, COARSE, work),
                Some(Err(why)) => Err(*why),
            };
            levels.extend(finer.transpose().map(|finer| finer.map(Arc::new)));
        }
        levels.get(level).cloned()
    }

    /// The backbone of full accuracy.
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn backbone(&self) -> Result<&Backbone, Failure> {
        let make = || Backbone::with(self.effort, self.curve, self.belt_speed, BACKBONE_TOLERANCE);
        self.fine.get_or_init(make).as_ref().map_err(|failed| *failed)
    }

    /// The regime at eps c = `viscous`: the set of attractors, from the backbone `interpolated` where it
    /// decides. `no_other_crosses`: no orbit except perhaps that from the exit point crosses for ever.
    ///
    /// An orbit that spirals inward around an unstable equilibrium tends to a slip cycle inside its first
    /// turn (Poincare-Bendixson); a stable equilibrium attracts. The attractor of the orbit from the exit
    /// point coexists with all attractors inside that orbit, and with crossing cycles around it.
    pub fn regime(
        &self,
        viscous: f64,
        end: End,
        interpolated: Option<&InterpolatedBackbone>,
        no_other_crosses: bool,
    ) -> Regime {
        let Some(equilibrium) = self.equilibrium_attracts(viscous) else { return Regime::Neutral };
        let by_interpolation = || interpolated?.attracts(viscous, equilibrium, end.returns()?);
        let counted = || Some(self.count(viscous, end).ok()?.iter().any(|cycle| cycle.is_stable));
        let attractors = || {
            end.returns()?;
            Some(Attractors {
                equilibrium,
                slip: by_interpolation().or_else(counted)?,
                stick_slip: end == End::Sticks,
                crossing: end == End::Crosses || !no_other_crosses && self.some_cross_for_ever(viscous)?,
            })
        };
        attractors().map_or(Regime::Failed, Regime::of)
    }

    /// The regime of a point of this curve and belt speed; `flow` is that of its orbit from the exit point.
    pub fn regime_of(&self, oscillator: &Oscillator, flow: &Flow) -> Regime {
        self.regime(oscillator.viscous, End::of(flow), None, false)
    }

    /// All slip cycles of a point, by growing amplitude; `flow` is that of its orbit from the exit point.
    ///
    /// # Errors
    /// [`CyclesUnknown`].
    pub fn slip_cycles(
        &self,
        oscillator: &Oscillator,
        flow: &Flow,
        tolerance: f64,
    ) -> Result<Vec<Cycle>, CyclesUnknown> {
        self.at(oscillator, End::of(flow), tolerance).slip_cycles().map_err(|why| because(why, flow))
    }

    /// The long-run behaviour of a point, as [`Self::regime_of`]; what was counted and does not close is no regime.
    pub fn long_run(&self, oscillator: &Oscillator, flow: &Flow, tolerance: f64) -> LongRun {
        let at = self.at(oscillator, End::of(flow), tolerance);
        let slip = at.slip_cycles().map_err(|why| because(why, flow));
        LongRun {
            regime: match slip {
                Err(CyclesUnknown::NotClosed) => Regime::Failed,
                _ => self.regime_of(oscillator, flow),
            },
            slip,
            cycle: at.attracting_cycle(),
            basin: at.basin_boundary(),
        }
    }

    /// Whether some orbits cross the belt line for ever, though the orbit from the exit point does not;
    /// `None` if unknown. If no orbit does at one damping, none does at a larger one.
    pub(crate) fn some_cross_for_ever(&self, viscous: f64) -> Option<bool> {
        if let Some(known) = no_loop_needed(&self.oscillator(viscous), self.far()) {
            return Some(known);
        }
        // About the damping from which on friction, which changes x2 by 1 at most, carries no orbit across.
        let most = 2.0 / self.belt_speed;
        let [mut low, mut high] = [0.0, most];
        for _ in 0..PLACES {
            let middle = 0.5 * (low + high);
            match self.some_cross_at(middle) {
                Some(true) if viscous <= middle => return Some(true),
                Some(false) if viscous >= middle => return Some(false),
                _ => {}
            }
            *(if viscous < middle { &mut high } else { &mut low }) = middle;
        }
        self.some_cross_at(viscous)
    }

    fn some_cross_at(&self, viscous: f64) -> Option<bool> {
        let known = || self.crosses.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known().get(&viscous.to_bits()) {
            return *known;
        }
        let work = Work::with(self.effort, Piece::Loops, self.curve).part(PLACES + 1);
        let some = some_cross_for_ever(&self.oscillator(viscous), self.far(), &work).ok();
        known().insert(viscous.to_bits(), some);
        some
    }

    pub(crate) fn oscillator(&self, viscous: f64) -> Oscillator {
        Oscillator { curve: self.curve.clone(), viscous, belt_speed: self.belt_speed }
    }

    /// Where loops lead that stay at slip speeds at which friction resists.
    pub(crate) fn far(&self) -> &FarLoops<'a> {
        self.far.get_or_init(|| FarLoops::where_friction_resists(self.curve, self.belt_speed))
    }

    /// The slip speed from which on friction pushes, if the regime says nothing of orbits that reach it.
    pub fn left_out_from(&self) -> Option<f64> {
        self.far.get()?.left_out_from()
    }
}

/// The reason why slip cycles are unknown: where it is that the orbit from the exit point is, the reason for that.
fn because(why: CyclesUnknown, flow: &Flow) -> CyclesUnknown {
    match (why, flow.fate) {
        (CyclesUnknown::TooClose, Fate::Failed(failed)) => failed.into(),
        _ => why,
    }
}

/// A column at one damping: what has a size there. The count, the regime, the edge of the basin and the list of slip cycles
/// are read from one list.
pub struct At<'b, 'a> {
    behaviour: &'b Behaviour<'a>,
    oscillator: &'b Oscillator,
    end: End,
    tolerance: f64,
    /// The slip cycles by growing amplitude, each located when it is asked for.
    cycles: OnceCell<Result<Vec<Located>, CyclesUnknown>>,
}

/// A slip cycle that may have been located.
type Located = (CycleRange, OnceCell<Result<Cycle, CyclesUnknown>>);

impl At<'_, '_> {
    /// The slip cycles, with bounds of their amplitudes that are as narrow as possible.
    fn cycles(&self) -> Result<&[Located], CyclesUnknown> {
        let Self { behaviour, oscillator: Oscillator { viscous, .. }, end, .. } = *self;
        let make = || {
            let cycles = behaviour.count(*viscous, end)?;
            // The fine one is dear, and serves all dampings.
            let fine = (!cycles.is_empty() && !behaviour.curve.weakening_is_convex())
                .then(|| behaviour.backbone().ok())
                .flatten();
            let narrowed = |cycle| fine.map_or(cycle, |fine| fine.narrowed(cycle, *viscous));
            Ok(cycles.into_iter().map(|cycle| (narrowed(cycle), OnceCell::new())).collect())
        };
        self.cycles.get_or_init(make).as_deref().map_err(|why| *why)
    }

    fn located(&self, cycles: &[Located], position: usize) -> Result<Cycle, CyclesUnknown> {
        let (range, found) = &cycles[position];
        let tolerance = self.tolerance.min(TIGHT);
        *found.get_or_init(|| locate(self.oscillator, range, tolerance, cycles.len()))
    }

    /// All slip cycles, by growing amplitude.
    ///
    /// # Errors
    /// [`CyclesUnknown`].
    pub fn slip_cycles(&self) -> Result<Vec<Cycle>, CyclesUnknown> {
        let cycles = self.cycles()?;
        (0..cycles.len()).map(|position| self.located(cycles, position)).collect()
    }

    /// The attracting cycle: the cycle that the orbit from the exit point reaches, or else the largest
    /// attracting slip cycle. `None` if there is none, or if its orbit cannot be computed.
    pub fn attracting_cycle(&self) -> Option<Cycle> {
        match self.end {
            End::Sticks => Some(landing_and_cycle(self.oscillator, self.tolerance).ok()??.1),
            End::Crosses => {
                let cycles = crossing_cycles(self.oscillator, self.behaviour.far(), self.tolerance);
                cycles.all().ok()?.into_iter().find(Cycle::is_stable)
            }
            End::Inward => {
                let cycles = self.cycles().ok()?;
                self.located(cycles, cycles.iter().rposition(|(cycle, _)| cycle.is_stable)?).ok()
            }
            End::TooClose | End::Failed => None,
        }
    }

    /// The boundary between basins; `None` if there is none, or if its orbit cannot be computed.
    pub fn basin_boundary(&self) -> Option<BasinBoundary> {
        let Self { behaviour, oscillator, end, .. } = *self;
        let cycles = self.cycles().ok()?;
        let tolerance = self.tolerance.min(TIGHT);
        if behaviour.grazing_returns(oscillator.viscous, end)? != end.returns()? {
            let (kick, g) = kick_onto_grazing(oscillator, tolerance).ok()??;
            let fragile_time = Some(g / behaviour.belt_speed);
            let inside = if cycles.is_empty() { Neighbour::Equilibrium } else { Neighbour::SlipCycle };
            let outside = if end == End::Crosses { Neighbour::Crossing } else { Neighbour::StickSlip };
            let (cycle, radius, separates) = (None, behaviour.belt_speed, [inside, outside]);
            return Some(BasinBoundary { cycle, radius, kick, fragile_time, separates });
        }
        // Cycles inside the outermost that repels separate smaller basins.
        let position = cycles.iter().rposition(|(cycle, _)| !cycle.is_stable)?;
        let cycle = self.located(cycles, position).ok()?;
        let kick = kick_onto(oscillator, &cycle, tolerance).ok()?;
        // Cycles alternate in stability.
        let inside = if position == 0 { Neighbour::Equilibrium } else { Neighbour::SlipCycle };
        let outside = match end {
            _ if position + 1 < cycles.len() => Neighbour::SlipCycle,
            End::Sticks => Neighbour::StickSlip,
            End::Crosses => Neighbour::Crossing,
            End::Inward | End::TooClose | End::Failed => Neighbour::Unknown,
        };
        let radius = cycle.velocity.hi;
        let (cycle, fragile_time) = (Some(cycle), None);
        Some(BasinBoundary { cycle, radius, kick, fragile_time, separates: [inside, outside] })
    }
}

/// The long-run behaviour of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct LongRun {
    /// The set of attractors.
    pub regime: Regime,
    /// The slip cycles, by growing amplitude.
    pub slip: Result<Vec<Cycle>, CyclesUnknown>,
    /// The attracting cycle: the stick-slip or the crossing cycle, or else the largest attracting slip cycle.
    /// `None` if there is none, or if its orbit cannot be computed.
    pub cycle: Option<Cycle>,
    /// The boundary between basins; `None` if there is none, or if its orbit cannot be computed.
    pub basin: Option<BasinBoundary>,
}

/// The long-run behaviour of a point, from one backbone; `flow` is that of its orbit from the exit point.
pub fn long_run(oscillator: &Oscillator, flow: &Flow, tolerance: f64) -> LongRun {
    Behaviour::new(&oscillator.curve, oscillator.belt_speed).long_run(oscillator, flow, tolerance)
}

/// The slip cycles of a point, by growing amplitude: those of its regime, its basin and their number; `flow` is that of its
/// orbit from the exit point.
///
/// # Errors
/// [`CyclesUnknown`].
pub fn slip_cycles(
    oscillator: &Oscillator,
    flow: &Flow,
    tolerance: f64,
) -> Result<Vec<Cycle>, CyclesUnknown> {
    Behaviour::new(&oscillator.curve, oscillator.belt_speed).slip_cycles(oscillator, flow, tolerance)
}

/// The words for orbits that are left out: friction pushes from the slip speed `from` on.
#[must_use]
pub fn left_out(from: f64) -> String {
    format!("friction is negative from u = {}: crossing cycles that reach it are left out", rounded(from, 4))
}

/// The regime of a point; `flow` is the answer for its orbit from the exit point.
#[must_use]
pub fn regime(oscillator: &Oscillator, flow: &Flow) -> Regime {
    Behaviour::new(&oscillator.curve, oscillator.belt_speed).regime_of(oscillator, flow)
}

/// The number of slip cycles of a point, stable or not; `None` if it is unknown.
#[must_use]
pub fn slip_cycle_count(oscillator: &Oscillator, flow: &Flow) -> Option<usize> {
    let behaviour = Behaviour::new(&oscillator.curve, oscillator.belt_speed);
    behaviour.count(oscillator.viscous, End::of(flow)).ok().map(|cycles| cycles.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law};
    use slipmap_orbits::arc::{SlipTurn, turn};
    use slipmap_orbits::flow;

    /// Steady slip, inside an unstable slip cycle, inside a stable one, which no orbit leaves.
    #[test]
    fn the_boundary_is_known_where_the_outermost_cycle_attracts() {
        let law =
            Expression::new("1 - 1.4012*u*exp(-u/1.51636) + 0.19596*sin(7.376*u) - 0.06*u", 1.0).unwrap();
        let law = Law::Expression(law);
        let oscillator = Oscillator::new(&law, &law.point(1.0, &[], 1.6726, 0.2).unwrap());
        let LongRun { regime, basin, .. } = long_run(&oscillator, &flow(&oscillator, 1e-9), 1e-9);
        assert_eq!(regime, Regime::PureSlipAndEquilibrium);
        let BasinBoundary { cycle, kick, separates, .. } = basin.unwrap();
        let cycle = cycle.unwrap();
        assert_eq!(separates, [Neighbour::Equilibrium, Neighbour::SlipCycle]);
        let outward = |share: f64| match turn(&oscillator, share * cycle.velocity.hi, 1e-12).unwrap() {
            SlipTurn::Returns { radius, .. } => radius > share * cycle.velocity.hi,
            SlipTurn::MeetsBelt { .. } | SlipTurn::Rests => panic!("{share}"),
        };
        assert!(!outward(0.999) && outward(1.001));
        assert!(kick.forward <= cycle.velocity.hi && kick.backward <= -cycle.velocity.lo, "{kick:?}");
    }

    /// The kick leads onto the outermost slip cycle that repels, also where the outermost of all attracts.
    #[test]
    fn the_kick_is_that_onto_the_boundary() {
        let law = Law::Expression(Expression::new("0.6 + 0.4*exp(-u) - 0.1*sin(7*u)", 1.0).unwrap());
        let oscillator = Oscillator::new(&law, &law.point(1.0, &[], 1.2, 0.15).unwrap());
        let answer = flow(&oscillator, 1e-9);
        let kick = long_run(&oscillator, &answer, 1e-9).basin.unwrap().kick;
        let cycles = slip_cycles(&oscillator, &answer, TIGHT).unwrap();
        let [.., repels, last] = &cycles[..] else { panic!("{cycles:?}") };
        assert!(last.is_stable() && !repels.is_stable());
        let other = kick_onto(&oscillator, repels, TIGHT).unwrap();
        for (one, other) in [(kick.forward, other.forward), (kick.backward, other.backward)] {
            assert!((one - other).abs() < 1e-9, "{one} {other}");
        }
    }
}
