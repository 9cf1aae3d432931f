//! The attractors of a column at each of its dampings, from one backbone.

use std::cell::{Cell, OnceCell, RefCell};

use super::Regime;
use super::end::End;
use super::verdict::Attractors;
use crate::backbone::{Backbone, COARSE, CycleRange, InterpolatedBackbone};
use crate::crossing::{crossing_cycles, landing_and_cycle, some_cross_for_ever};
use crate::slip_cycle::TIGHT;
use crate::slip_cycle::{BACKBONE_TOLERANCE, Kick, Unknown, kick_onto, kick_onto_grazing, locate};
use crate::{CriticalDamping, Neighbour, critical_damping};
use slipmap_model::filippov::{HopfRate, Oscillator, Stability};
use slipmap_model::flow::{Failure, Fate, Flow};
use slipmap_model::friction::{Column, Curve, Range};
use slipmap_numbers::text::rounded;
use slipmap_orbits::Cycle;
use slipmap_orbits::far_loops::FarLoops;

/// Tolerance of C(V) of a curve with a drop.
const GRAZING: f64 = 1e-11;

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

/// The attractors of one friction curve and belt speed, for all dampings.
pub struct Behaviour<'a> {
    curve: &'a Curve,
    belt_speed: f64,
    hopf: HopfRate<'a>,
    /// Bounds of the even part of the weakening rate about the belt speed, computed on first use.
    even: OnceCell<Range>,
    /// Whether at most one slip cycle is proved to exist at each damping; computed on first use.
    has_one_at_most: OnceCell<bool>,
    /// Coarse backbones, each with twice as many nodes as the one before. Every damping tries them in this
    /// order, so that its answer does not depend on other dampings.
    coarse: RefCell<Vec<Result<Backbone, Failure>>>,
    /// The backbone of full accuracy, computed on first use.
    fine: OnceCell<Result<Backbone, Failure>>,
    /// Where loops far beyond the exit point lead; computed on first use.
    far: OnceCell<FarLoops<'a>>,
    /// C(V) of a curve with a drop, with its error; computed on first use.
    grazing: OnceCell<Option<CriticalDamping>>,
    /// The smallest eps c, so far, at which the search found no orbit that crosses the belt line for ever.
    none_cross_from: Cell<f64>,
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

/// The properties of a column at one damping that are known before its cycles.
#[derive(Clone, Copy)]
struct Ends {
    /// Whether the equilibrium attracts.
    stable: bool,
    /// Whether the orbit from (V, 0) returns to the belt line: without a drop that from the exit point.
    returns: bool,
}

impl<'a> Behaviour<'a> {
    /// The behaviour of a curve at a belt speed; nothing is computed yet.
    pub fn new(curve: &'a Curve, belt_speed: f64) -> Self {
        Self {
            curve,
            belt_speed,
            hopf: HopfRate::new(curve, belt_speed),
            even: OnceCell::new(),
            has_one_at_most: OnceCell::new(),
            coarse: RefCell::default(),
            fine: OnceCell::new(),
            far: OnceCell::new(),
            grazing: OnceCell::new(),
            none_cross_from: Cell::new(f64::INFINITY),
        }
    }

    /// The slip cycles at eps c = `viscous`, where the orbit from the exit point ends as `end`, with bounds
    /// of their amplitudes that are as narrow as possible; `None` if the cycles are unknown.
    fn slip_cycles(&self, viscous: f64, end: End) -> Option<Vec<CycleRange>> {
        let cycles = self.count(viscous, end)?;
        // The fine one is dear, and serves all dampings.
        let fine =
            (!cycles.is_empty() && !self.curve.weakening_is_convex()).then(|| self.backbone()).flatten();
        let narrowed = |cycle| fine.map_or(cycle, |fine| fine.narrowed(cycle, viscous));
        Some(cycles.into_iter().map(narrowed).collect())
    }

    /// The slip cycles between any bounds: for their number and their stability.
    pub fn count(&self, viscous: f64, end: End) -> Option<Vec<CycleRange>> {
        self.cycles(viscous, end, |ends| {
            self.read(viscous, |backbone| backbone.cycles(viscous, ends.stable, ends.returns))
        })
    }

    /// The reason why the slip cycles are unknown, where they are.
    pub fn slip_cycles_unknown(&self, oscillator: &Oscillator, flow: &Flow) -> Option<Unknown> {
        if self.slip_cycles(oscillator.viscous, End::of(flow)).is_some() {
            return None;
        }
        match (oscillator.stability(), self.fine.get(), self.coarse.borrow().last(), flow.fate) {
            (Stability::Neutral, ..) => Some(Unknown::Neutral),
            (_, Some(Err(failed)), ..) | (_, _, Some(Err(failed)), _) => Some((*failed).into()),
            (.., Fate::Failed(failed)) => Some(failed.into()),
            _ => Some(Unknown::TooClose),
        }
    }

    /// Whether the equilibrium attracts at eps c = `viscous`; `None` where it is neutral. Where friction is
    /// constant next to the belt speed and there is no damping, all orbits about it close.
    fn equilibrium_attracts(&self, viscous: f64) -> Option<bool> {
        match self.hopf.stability(viscous) {
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
        let column = || Column {
            curve: self.curve.without_drop(),
            epsilon: 1.0,
            belt_speed: self.belt_speed,
            unit: 1.0,
        };
        let grazing = self.grazing.get_or_init(|| critical_damping(&column(), GRAZING).ok());
        let CriticalDamping { c, error, .. } = (*grazing)?;
        ((c - viscous).abs() > error).then_some(viscous < c)
    }

    /// The slip cycles, by the even part, where at most one is proved to exist, or else as `read` from a backbone.
    fn cycles(
        &self,
        viscous: f64,
        end: End,
        read: impl FnOnce(Ends) -> Option<Vec<CycleRange>>,
    ) -> Option<Vec<CycleRange>> {
        let stable = self.equilibrium_attracts(viscous)?;
        let even = self.even.get_or_init(|| self.curve.even_weakening_range(self.belt_speed));
        if even.excludes(viscous) {
            return Some(Vec::new());
        }
        let returns = self.grazing_returns(viscous, end)?;
        let curve = self.curve;
        if *self.has_one_at_most.get_or_init(|| curve.has_one_slip_cycle_at_most(self.belt_speed)) {
            // A repelling one if the equilibrium is stable and the orbit returns, an attracting one if neither holds.
            let between = [0.0, self.belt_speed];
            let one = CycleRange::between(between, !returns);
            return Some(if stable == returns { vec![one] } else { Vec::new() });
        }
        read(Ends { stable, returns })
    }

    /// What is read from the first coarse backbone that is reliable at `viscous`, from the last where it is rough, or else
    /// from the fine one.
    fn read<T>(&self, viscous: f64, read: impl FnOnce(&Backbone) -> Option<T>) -> Option<T> {
        let mut coarse = self.coarse.borrow_mut();
        let mut level = 0;
        loop {
            if level == coarse.len() {
                let finer = match coarse.last() {
                    None => Backbone::coarsest(self.curve, self.belt_speed, COARSE).map(Some),
                    Some(Ok(last)) => last.refined(self.curve, COARSE),
                    // Where a coarse backbone fails, a fine one does.
                    Some(Err(_)) => return None,
                };
                match (finer.transpose(), coarse.last()) {
                    (Some(finer), _) => coarse.push(finer),
                    (None, Some(Ok(last))) if last.is_rough(self.curve) => return read(last),
                    (None, _) => return read(self.backbone()?),
                }
            }
            match &coarse[level] {
                Ok(backbone) if backbone.is_reliable_at(viscous) => return read(backbone),
                _ => level += 1,
            }
        }
    }

    /// The backbone of full accuracy; `None` where an orbit fails.
    pub fn backbone(&self) -> Option<&Backbone> {
        let make = || Backbone::of_curve(self.curve, self.belt_speed, BACKBONE_TOLERANCE);
        self.fine.get_or_init(make).as_ref().ok()
    }

    /// The reason why the backbone of full accuracy is unknown, if it was asked for.
    pub fn backbone_unknown(&self) -> Option<Unknown> {
        self.fine.get()?.as_ref().err().map(|failed| (*failed).into())
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
        let counted = || Some(self.count(viscous, end)?.iter().any(|cycle| cycle.is_stable));
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

    /// All slip cycles of a point, by growing amplitude.
    fn located(&self, oscillator: &Oscillator, flow: &Flow, tolerance: f64) -> Result<Vec<Cycle>, Unknown> {
        match self.slip_cycles(oscillator.viscous, End::of(flow)) {
            Some(all) => all.iter().map(|cycle| locate(oscillator, cycle, tolerance.min(TIGHT))).collect(),
            None => Err(self.slip_cycles_unknown(oscillator, flow).unwrap_or(Unknown::TooClose)),
        }
    }

    /// The long-run behaviour of a point, as [`Self::regime_of`]; what was counted and does not close is no regime.
    pub fn long_run(&self, oscillator: &Oscillator, flow: &Flow, tolerance: f64) -> LongRun {
        let slip = self.located(oscillator, flow, tolerance);
        LongRun {
            regime: match slip {
                Err(Unknown::NotClosed) => Regime::Failed,
                _ => self.regime_of(oscillator, flow),
            },
            slip,
            cycle: self.attracting_cycle(oscillator, End::of(flow), tolerance),
            basin: self.basin_boundary(oscillator, End::of(flow), tolerance),
        }
    }

    /// Whether some orbits cross the belt line for ever, though the orbit from the exit point does not;
    /// `None` if unknown. If no orbit does at one damping, none does at a larger one.
    fn some_cross_for_ever(&self, viscous: f64) -> Option<bool> {
        if viscous >= self.none_cross_from.get() {
            return Some(false);
        }
        let oscillator = Oscillator { curve: self.curve.clone(), viscous, belt_speed: self.belt_speed };
        let some = some_cross_for_ever(&oscillator, self.far()).ok()?;
        if !some {
            self.none_cross_from.set(viscous);
        }
        Some(some)
    }

    /// Where loops lead that stay at slip speeds at which friction resists.
    fn far(&self) -> &FarLoops<'a> {
        self.far.get_or_init(|| FarLoops::where_friction_resists(self.curve, self.belt_speed))
    }

    /// The slip speed from which on friction pushes, if the regime says nothing of orbits that reach it.
    pub fn left_out_from(&self) -> Option<f64> {
        self.far.get()?.left_out_from()
    }

    /// The attracting cycle: the cycle that the orbit from the exit point reaches, or else the largest
    /// attracting slip cycle. `None` if there is none, or if its orbit cannot be computed. That orbit ends as `end`.
    pub fn attracting_cycle(&self, oscillator: &Oscillator, end: End, tolerance: f64) -> Option<Cycle> {
        match end {
            End::Sticks => Some(landing_and_cycle(oscillator, tolerance).ok()??.1),
            End::Crosses => {
                let cycles = crossing_cycles(oscillator, self.far(), tolerance).all().ok()?;
                cycles.into_iter().find(Cycle::is_stable)
            }
            End::Inward => {
                let cycle =
                    self.slip_cycles(oscillator.viscous, end)?.into_iter().rfind(|cycle| cycle.is_stable)?;
                locate(oscillator, &cycle, tolerance.min(TIGHT)).ok()
            }
            End::TooClose | End::Failed => None,
        }
    }

    /// The boundary between basins; `None` if there is none, or if its orbit cannot be computed.
    pub fn basin_boundary(&self, oscillator: &Oscillator, end: End, tolerance: f64) -> Option<BasinBoundary> {
        let cycles = self.slip_cycles(oscillator.viscous, end)?;
        if self.grazing_returns(oscillator.viscous, end)? != end.returns()? {
            let (kick, g) = kick_onto_grazing(oscillator, tolerance.min(TIGHT)).ok()??;
            let fragile_time = Some(g / self.belt_speed);
            let inside = if cycles.is_empty() { Neighbour::Equilibrium } else { Neighbour::SlipCycle };
            let outside = if end == End::Crosses { Neighbour::Crossing } else { Neighbour::StickSlip };
            let radius = self.belt_speed;
            return Some(BasinBoundary {
                cycle: None,
                radius,
                kick,
                fragile_time,
                separates: [inside, outside],
            });
        }
        // Cycles inside the outermost that repels separate smaller basins.
        let position = cycles.iter().rposition(|cycle| !cycle.is_stable)?;
        let tolerance = tolerance.min(TIGHT);
        let cycle = locate(oscillator, &cycles[position], tolerance).ok()?;
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
    pub slip: Result<Vec<Cycle>, Unknown>,
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
/// [`Unknown`].
pub fn slip_cycles(oscillator: &Oscillator, flow: &Flow, tolerance: f64) -> Result<Vec<Cycle>, Unknown> {
    Behaviour::new(&oscillator.curve, oscillator.belt_speed).located(oscillator, flow, tolerance)
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
    behaviour.count(oscillator.viscous, End::of(flow)).map(|cycles| cycles.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slip_cycle::slip_cycles;
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
        let cycles = slip_cycles(&oscillator, TIGHT).unwrap();
        let [.., repels, last] = &cycles[..] else { panic!("{cycles:?}") };
        assert!(last.is_stable() && !repels.is_stable());
        let other = kick_onto(&oscillator, repels, TIGHT).unwrap();
        for (one, other) in [(kick.forward, other.forward), (kick.backward, other.backward)] {
            assert!((one - other).abs() < 1e-9, "{one} {other}");
        }
    }
}
