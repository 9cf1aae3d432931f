//! A friction law with all its parameters fixed: its values, its proved bounds and its first order in eps.

use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError};

use super::built_in::ClosedForm;
use super::exponential::ExponentialFall;
use super::{FirstOrder, Form, Gradient, NoFirstOrder, Range, Stribeck, Table, Weakening, mean, weakening};
use crate::point::{LawParameters, MAX_LAW_PARAMETERS};
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real};

/// Slip speed up to which bounds of the friction are tried for [`Curve::fastest_of_slip_cycles`], in units of the
/// belt speed or of 1: where 0 <= phi <= 1 the bound is 2 V + 1 at most.
const FASTEST_TRIED: f64 = 4.0;

/// A friction curve: a law with all its parameters fixed. Clones share the compiled form.
#[derive(Clone, Debug)]
pub struct Curve {
    pub(super) form: Form,
    /// eps, if the law is read as 1 + eps F(u).
    pub(super) small: Option<f64>,
    /// The parameter of [`super::Law::with_drop`], if the law has it.
    axis: Option<f64>,
    drop: f64,
    pub(super) compiled: Arc<Mutex<Compiled>>,
}

impl PartialEq for Curve {
    fn eq(&self, other: &Self) -> bool {
        self.form == other.form && self.small == other.small && self.axis == other.axis
    }
}

/// The compiled forms of a curve, each computed when it is first needed.
#[derive(Debug, Default)]
pub(super) struct Compiled {
    weakening: Vec<Arc<Weakening>>,
    /// Those of a formula as it was written, if its slip speed has another unit here.
    pub(super) written: Arc<Mutex<Vec<Arc<Weakening>>>>,
    /// -F1', the weakening rate of the law to first order in eps.
    leading: Vec<Arc<Weakening>>,
}

/// Compiles the law up to a slip speed of at least `reach`: the next power of two, so that similar belt
/// speeds share the result, or the end of the data. The forms `known` save time and do not change the result.
fn compile(form: &Form, known: &mut Vec<Arc<Weakening>>, reach: f64) -> Arc<Weakening> {
    // Neither the square nor the inverse of the reach may leave the range of normal numbers.
    let exponent = reach.clamp(1e-150, 1e150).log2().ceil() as i32;
    let wanted = match form {
        Form::Function(law) => law.fastest(),
        Form::Table(law) => law.fastest(),
        _ => 2f64.powi(exponent),
    };
    weakening::compile(form, wanted, known)
}

/// The intervals of slip speed on which a formula is evaluated to bound the friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pieces {
    /// One interval.
    One,
    /// Intervals each of which reaches twice as far as the one before.
    Octaves,
}

/// Number of intervals of [`Pieces::Octaves`], without the first.
const OCTAVES: i32 = 14;
/// Number of intervals between the samples of a function, which are dense next to 0.
const SAMPLES: u32 = 256;
/// Number of the intervals of [`Curve::friction_by_intervals`] per factor of two.
const PER_OCTAVE: i32 = 4;
/// Powers of two between which these intervals lie, and at which phi is sampled beyond them.
const INTERVALS: std::ops::RangeInclusive<i32> = -4..=40;
const SAMPLED: std::ops::RangeInclusive<i32> = 41..=80;
/// Intervals this narrow, in units of their ends, are not halved though the sign of a formula is not known
/// there.
const NARROWEST: f64 = 1.0 / 64.0;
/// Largest number of parts of one interval on which a formula is evaluated: laws whose sign can be known there
/// need some dozens.
const MOST_PARTS: u32 = 1000;
/// A distance that is less than this share of another halves with the interval.
const HALVED: f64 = 0.6;
/// A number at which powers of slip speeds are finite yet.
const FASTEST: f64 = 1e60;
/// Friction above this counts as not negative: less than rounding makes of it.
pub const NOT_NEGATIVE: f64 = -1e-12;
/// See [`Curve::is_hidden_by_rounding`]: c* of such a law is about as uncertain as its friction, of which a thousandth is
/// well within the 1 % to which a critical damping is told.
const HIDDEN: f64 = 1e-3;
/// Change of friction that is rounding error alone.
const ROUNDED: f64 = 1e-12;

/// The smallest range that contains all `ranges`.
fn hull(ranges: impl Iterator<Item = Range>) -> Range {
    ranges.fold(Range::EMPTY, Range::hull)
}

impl Curve {
    /// Work of compiling the law for a column of this belt speed, in evaluations of the Stribeck law. The
    /// Stribeck law itself is not compiled.
    pub fn compiling_work(&self, belt_speed: f64) -> u64 {
        match self.stribeck() {
            Some(_) => 0,
            None => self.form.work_of_piece() * self.compiled(4.0 * belt_speed).breaks().len() as u64,
        }
    }

    /// Cost of one evaluation, at least 1, in units of the cost of the Stribeck law. Quotas of work are
    /// divided by this number.
    pub fn cost(&self) -> u64 {
        self.form.cost()
    }

    pub(super) fn new(
        form: Form,
        small: Option<f64>,
        axis: Option<f64>,
        compiled: Arc<Mutex<Compiled>>,
    ) -> Self {
        let drop = form.drop() + axis.unwrap_or(0.0);
        Self { form, small, axis, drop, compiled }
    }

    /// The drop j: the friction at rest, 1, less the friction in slip as u -> 0; 0 <= j < 1.
    #[must_use]
    #[inline]
    pub fn drop(&self) -> f64 {
        self.drop
    }

    /// The same friction in slip, up to a constant, with no drop: its slip motion about the equilibrium is the
    /// same.
    #[must_use]
    pub fn without_drop(&self) -> Self {
        Self { drop: 0.0, axis: None, ..self.clone() }
    }

    /// phi(u), the friction force in slip at the speed `u` >= 0; at 0 the limit u -> 0.
    #[must_use]
    #[inline]
    pub fn phi(&self, u: f64) -> f64 {
        self.form.phi(u) - self.axis.unwrap_or(0.0)
    }

    /// The weakening rate -phi'(u): positive where the friction falls with speed. The divergence of the
    /// flow is D(u) = weakening(u) - eps c.
    #[must_use]
    #[inline]
    pub fn weakening(&self, u: f64) -> f64 {
        self.form.weakening(u)
    }

    /// The size of the weakening rate in its means over orbits about the equilibrium: the rate there, and the changes of
    /// friction. A narrow fall has a rate that is larger by any factor.
    pub(crate) fn weakening_scale(&self, belt_speed: f64) -> f64 {
        let places = [0.0, 0.5, 1.0, 1.5, 2.0].map(|share| share * belt_speed);
        let changes =
            places.windows(2).map(|ends| (self.phi(ends[1]) - self.phi(ends[0])).abs() / belt_speed);
        let here = std::iter::once(self.weakening(belt_speed).abs());
        here.chain(changes).filter(|rate| rate.is_finite()).fold(0.0, f64::max)
    }

    /// Bound of the rounding error of the weakening rate at slip speed `u`, where one is known: by interval
    /// arithmetic for a formula, of the differences of a table's data; the error of a function's samples.
    pub(crate) fn weakening_rounding(&self, u: f64) -> f64 {
        if let Form::Table(table) = &self.form {
            return table.rounding_of_weakening(u);
        }
        let slope = self.formula(Jet::<Interval, 2>::variable(Interval::of(u), 1.0)).map(|phi| phi.0[1]);
        slope.map_or(self.sampling_error(), |slope| slope.hi - slope.lo)
    }

    /// How far the weakening rate may be from that of the function of which the law holds samples; 0 for other laws.
    pub fn sampling_error(&self) -> f64 {
        match &self.form {
            Form::Function(law) => law.error(),
            _ => 0.0,
        }
    }

    /// The weakening rate as polynomials on slip speeds from 0 to at least `reach`, or to the end of a table
    /// or of a sampled function. The law is compiled once for each power of two.
    #[must_use]
    pub fn compiled(&self, reach: f64) -> Arc<Weakening> {
        let compiled = &mut *self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let Some((unit, written)) = self.form.unit() else {
            return compile(&self.form, &mut compiled.weakening, reach);
        };
        let written = {
            let mut known = compiled.written.lock().unwrap_or_else(PoisonError::into_inner);
            compile(&written, &mut known, reach * unit)
        };
        weakening::compile_in_unit(&self.form, unit, &written, &mut compiled.weakening)
    }

    /// What a curve shares of its compiled forms with one of another `form`.
    pub(super) fn shared(&self, form: &Form) -> Arc<Mutex<Compiled>> {
        let compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        match (&self.form, form) {
            (Form::Expression(own), Form::Expression(other)) if own.is_of_same_formula(other) => {
                let written = Arc::clone(&compiled.written);
                Arc::new(Mutex::new(Compiled { written, ..Compiled::default() }))
            }
            _ => Arc::default(),
        }
    }

    /// Proved bounds of the weakening rate over slip speeds u in [`lo`, `hi`], 0 <= lo <= hi.
    #[must_use]
    #[inline]
    pub fn weakening_range(&self, lo: f64, hi: f64) -> Range {
        self.form.weakening_range(lo, hi).unwrap_or_else(|| self.compiled(hi).range(lo, hi))
    }

    /// Upper bounds of the weakening rate for many intervals. The law is compiled once, up to `reach`;
    /// intervals beyond it take longer.
    pub fn ranges(&self, reach: f64) -> Ranges<'_> {
        let is_compiled = self.form.closed().is_none();
        Ranges { curve: self, compiled: is_compiled.then(|| self.compiled(reach)) }
    }

    /// The largest slip speed at which the law is known: the end of a table or a function, else infinity.
    pub fn fastest(&self) -> f64 {
        match &self.form {
            Form::Table(law) => law.fastest(),
            Form::Function(law) => law.fastest(),
            _ => f64::INFINITY,
        }
    }

    /// Bounds of phi over slip speeds u in [0, `hi`], 0 < hi <= [`Curve::fastest`]. For laws given by
    /// functions they are taken from samples and not proved. A formula is bounded on the intervals `pieces`.
    pub fn friction_range(&self, hi: f64, pieces: Pieces) -> Range {
        let octaves = match pieces {
            Pieces::One => 0,
            Pieces::Octaves => OCTAVES,
        };
        let ends = || (0..=octaves).rev().map(|octave| hi * 0.5_f64.powi(octave));
        let starts = || std::iter::once(0.0).chain(ends());
        let lowered = |range: Range| {
            let drop = self.axis.unwrap_or(0.0);
            Range { lo: range.lo - drop, hi: range.hi - drop }
        };
        if let Some(range) = self.form.closed().and_then(|law| law.friction_range(hi)) {
            return lowered(range);
        }
        match &self.form {
            Form::Table(law) => lowered(law.friction_range(0.0, hi)),
            Form::Function(_) | Form::Custom(_) => {
                let place = |i: u32| hi * (f64::from(i) / f64::from(SAMPLES)).powi(2);
                Range::of((0..=SAMPLES).map(|i| self.phi(place(i))))
            }
            _ => hull(
                starts().zip(ends()).filter_map(|(lo, hi)| Some(self.formula(Interval::new(lo, hi))?.into())),
            ),
        }
    }

    /// Whether friction is proved to push at no slip speed by its bounds on all of them at once.
    pub fn is_proved_to_resist(&self) -> bool {
        !self.is_sampled() && self.friction_range(self.fastest().min(FASTEST), Pieces::One).lo >= NOT_NEGATIVE
    }

    /// Ranges of phi on intervals of slip speed, with the ends of each, from 0 up to [`Curve::fastest`]. They
    /// are bounds up to 10^12 `unit` (2^40), but for formulas with terms that cancel and laws given by
    /// functions, whose ranges are sampled. Beyond there are samples only, one per factor of two up to 2^80
    /// and none from there on: intervals without a length. So no theorem may use them.
    pub fn friction_by_intervals(&self, unit: f64) -> Vec<([f64; 2], Range)> {
        let end = |i: i32| unit * 2_f64.powf(f64::from(i) / f64::from(PER_OCTAVE));
        let fastest = self.fastest();
        let mut from = 0.0;
        let mut found = Vec::new();
        let [first, last] = [*INTERVALS.start(), *INTERVALS.end()].map(|octave| PER_OCTAVE * octave);
        for to in (first..=last).map(|i| end(i).min(fastest)) {
            if to > from {
                found.push(([from, to], self.friction_between(from, to, 0.0)));
            }
            from = to;
        }
        if fastest == f64::INFINITY {
            found.extend(SAMPLED.map(|octave| {
                let at = end(PER_OCTAVE * octave);
                // Large terms that cancel leave a number of any sign; what overflows has the sign of its value.
                let bounds = self.formula(Interval::of(at)).filter(|phi| phi.is_bounded());
                let value = Range { lo: self.phi(at), hi: self.phi(at) };
                ([at; 2], bounds.map_or(value, Range::from))
            }));
        }
        found
    }

    /// The range of phi(u) + C u, C = `viscous`, over slip speeds u in [`lo`, `hi`]: bounds, or samples for
    /// laws given by functions and for terms that cancel. It need not be narrow where its sign is certain.
    pub fn friction_between(&self, lo: f64, hi: f64, viscous: f64) -> Range {
        if let Form::Table(table) = &self.form {
            let (phi, drop) = (table.friction_range(lo, hi), self.axis.unwrap_or(0.0));
            return Range {
                lo: viscous.times_plus(lo, phi.lo - drop),
                hi: viscous.times_plus(hi, phi.hi - drop),
            };
        }
        if self.formula(0.0).is_some() {
            return self.formula_between(lo, hi, viscous);
        }
        let place = |i: u32| (hi - lo).times_plus(f64::from(i) / f64::from(SAMPLES), lo).min(hi);
        let psi = |u: f64| viscous.times_plus(u, self.phi(u));
        Range::of((0..=SAMPLES).map(place).map(psi))
    }

    /// As [`Curve::friction_between`] for a formula. Where the distances of the bounds from samples halve with
    /// the interval, the bounds are wide because terms cancel, as in `1 - u/(1 + u)`, and the samples are the
    /// bounds; a narrow dip would leave them as they are. What [`MOST_PARTS`] do not decide keeps the bounds
    /// that are proved of it.
    fn formula_between(&self, lo: f64, hi: f64, viscous: f64) -> Range {
        let mut found = Range::EMPTY;
        // With the distances on twice and four times the interval. The last part is the next one: first those
        // at high speeds, since towards rest halving need not end.
        let mut waiting = vec![(lo, hi, [f64::INFINITY; 2])];
        let mut left = MOST_PARTS;
        while let Some((lo, hi, before)) = waiting.pop() {
            let u = Interval::new(lo, hi);
            let Some(phi) = self.formula(u) else { return Interval::ENTIRE.into() };
            let range: Range = (phi + Interval::of(viscous) * u).into();
            let middle = 0.5 * (lo + hi);
            let samples = [lo, middle, hi].map(|u| viscous.times_plus(u, self.phi(u)));
            let pushes = samples.map(|phi| phi < 0.0);
            let sampled = Range::of(samples);
            let distance = if pushes[0] { range.hi - sampled.hi } else { sampled.lo - range.lo };
            let is_decided = range.lo >= NOT_NEGATIVE || range.hi < 0.0 || pushes != [pushes[0]; 3];
            let cancels = distance < HALVED * before[0] && before[0] < HALVED * before[1] && before[1] < 1.0;
            left = left.saturating_sub(1);
            let bounds = match is_decided {
                false if cancels => sampled,
                false if left > 0 && hi - lo >= NARROWEST * hi => {
                    let before = [distance, before[0]];
                    waiting.extend([(lo, middle, before), (middle, hi, before)]);
                    continue;
                }
                _ => range,
            };
            found = found.hull(bounds);
        }
        found
    }

    /// Proved bounds, over 0 < |v| <= V, of the even part in v of `weakening(V - v)`.
    #[must_use]
    pub fn even_weakening_range(&self, belt_speed: f64) -> Range {
        let closed = self.form.closed().and_then(|law| law.even_weakening_range(belt_speed));
        closed.unwrap_or_else(|| self.compiled(4.0 * belt_speed).even_range(belt_speed, belt_speed))
    }

    /// The weakening rate averaged over the grazing circle v = V cos t with weight sin^2 t / pi: the energy
    /// that friction supplies in one turn, in units of that dissipated by unit damping eps c. NaN where the data of a law
    /// end below 2 V.
    #[must_use]
    pub fn mean_weakening(&self, belt_speed: f64) -> f64 {
        self.mean_weakening_with_error(belt_speed)[0]
    }

    /// [`Curve::mean_weakening`], and how far it may be from that of the law, rounding apart; infinite where that is not known.
    pub fn mean_weakening_with_error(&self, belt_speed: f64) -> [f64; 2] {
        if let Some(law) = self.form.closed() {
            return [law.mean_weakening(belt_speed), 0.0];
        }
        match &self.form {
            Form::Table(law) => [law.mean_weakening(belt_speed), 0.0],
            _ => self.compiled(4.0 * belt_speed).mean(belt_speed),
        }
    }

    /// [`Curve::mean_weakening`] of a law that need not be compiled: for laws of which many are compared at one
    /// belt speed each.
    pub fn mean_weakening_of_many(&self, belt_speed: f64) -> f64 {
        match self.form.closed().is_some() || self.table().is_some() {
            true => self.mean_weakening(belt_speed),
            false => mean::of_formula(|u| self.weakening(u), belt_speed),
        }
    }

    /// About [`Curve::mean_weakening`], for searches to begin with.
    pub fn rough_mean_weakening(&self, belt_speed: f64) -> f64 {
        match &self.form {
            Form::Exponential(law) => law.mean(belt_speed, 0),
            form if form.closed().is_some() || self.table().is_some() => self.mean_weakening(belt_speed),
            _ => self.compiled(4.0 * belt_speed).rough_mean(belt_speed),
        }
    }

    /// The law to first order in eps at belt speed V.
    ///
    /// # Errors
    /// [`NoFirstOrder`] for a law that is not 1 + O(eps).
    pub fn first_order(&self, belt_speed: f64) -> Result<FirstOrder, NoFirstOrder> {
        if self.drop > 0.0 {
            return Err(NoFirstOrder::Drop);
        }
        if let Some(epsilon) = self.small {
            // -F' = w / eps.
            let Range { lo, hi } = self.weakening_range(0.0, 2.0 * belt_speed);
            let [mean, error] = self.mean_weakening_with_error(belt_speed);
            return Ok(FirstOrder {
                mean_weakening: mean / epsilon,
                mean_error: error / epsilon,
                weakening_range: Range { lo: lo / epsilon, hi: hi / epsilon },
            });
        }
        match &self.form {
            Form::Expression(law) => {
                law.check_leading(belt_speed)?;
                let leading = {
                    let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
                    compile(&Form::Leading(law.clone()), &mut compiled.leading, 2.0 * belt_speed)
                };
                // By parts, (6) divided by pi V is the mean of -F1'.
                let [mean_weakening, mean_error] = leading.mean(belt_speed);
                Ok(FirstOrder {
                    mean_weakening,
                    mean_error,
                    weakening_range: leading.range(0.0, 2.0 * belt_speed),
                })
            }
            form => {
                let closed = form.closed().and_then(|law| law.first_order(belt_speed));
                closed.ok_or(NoFirstOrder::NoEpsilon)
            }
        }
    }

    /// Returns whether the law's weakening rate has finite proved bounds for slip speeds up to `fastest`, as
    /// theorems require.
    pub fn is_enclosed(&self, fastest: f64) -> bool {
        let range = self.weakening_range(0.0, fastest);
        range.lo.is_finite() && range.hi.is_finite()
    }

    /// Returns whether the law is given by functions of a program, so that it has no proved bounds.
    pub(crate) fn is_sampled(&self) -> bool {
        matches!(self.form, Form::Function(_) | Form::Custom(_))
    }

    /// Derivatives of the weakening rate at slip speed `u` with respect to eps and each parameter of the law.
    #[must_use]
    pub fn weakening_gradient(&self, u: f64) -> Gradient {
        // The weakening rate does not depend on the drop.
        self.with_axis(self.own_gradient(u), 0.0)
    }

    /// [`Self::weakening_gradient`] without the parameter of [`super::Law::with_drop`].
    fn own_gradient(&self, u: f64) -> Gradient {
        match &self.form {
            Form::Expression(law) | Form::Leading(law) => law.derivatives(u, 1),
            Form::Custom(law) => law.gradient(u),
            form => {
                let nothing = Gradient { epsilon: 0.0, parameters: LawParameters::new(&[]) };
                form.closed().map_or(nothing, |law| law.gradient(u))
            }
        }
    }

    /// Adds the derivative with respect to the parameter of [`super::Law::with_drop`], if the law has it.
    fn with_axis(&self, own: Gradient, by_axis: f64) -> Gradient {
        match self.axis {
            None => own,
            Some(_) => {
                let parameters = [own.parameters.as_slice(), &[by_axis]].concat();
                Gradient { parameters: LawParameters::new(&parameters), ..own }
            }
        }
    }

    /// Derivatives of the drop with respect to eps and each parameter of the law.
    #[must_use]
    pub fn drop_gradient(&self) -> Gradient {
        let own = match &self.form {
            Form::Expression(curve) if curve.law.may_drop() => curve.derivatives(0.0, 0),
            Form::Coulomb(_) => Gradient { epsilon: 0.0, parameters: LawParameters::new(&[1.0, 0.0]) },
            _ => {
                let count = self.own_gradient(0.0).parameters.as_slice().len();
                let zeros = [0.0; MAX_LAW_PARAMETERS];
                Gradient { epsilon: 0.0, parameters: LawParameters::new(&zeros[..count]) }
            }
        };
        self.with_axis(own, 1.0)
    }

    /// The table of a measured law; `None` for other laws.
    pub fn table(&self) -> Option<&Table> {
        match &self.form {
            Form::Table(table) => Some(table),
            _ => None,
        }
    }

    /// Returns whether the closed forms of the law are evaluated in normal numbers. A product below the
    /// normal numbers may be wrong by any factor, and then no result is a theorem.
    #[must_use]
    pub fn is_normal(&self) -> bool {
        // Enclosures of other laws are valid for numbers of every size.
        self.form.closed().is_none_or(ClosedForm::is_normal)
    }

    /// phi in any arithmetic (numbers, intervals or series); `None` for laws given by data or by functions.
    pub fn formula<T: Real>(&self, u: T) -> Option<T> {
        let phi = self.form.formula(u)?;
        Some(self.axis.map_or(phi, |drop| phi - T::constant(drop)))
    }

    /// As [`Curve::even_weakening_range`] with 0 <= v <= `reach`, rounded outwards; `None` without a formula.
    pub fn even_weakening_within(&self, belt_speed: f64, reach: f64) -> Option<Range> {
        self.formula(0.0)?;
        Some(self.compiled(4.0 * belt_speed).even_range(belt_speed, reach))
    }

    /// Slip speeds > 0, increasing, at which the slope of the weakening rate jumps. Elsewhere the curve is
    /// smooth.
    #[must_use]
    pub fn corners(&self) -> &[f64] {
        self.form.corners()
    }

    /// A slip speed up to which the law has no feature that is narrower: that over which a closed form falls, and the
    /// length of the first piece of a compiled law. Integrators that leave the belt line, or come back to it, change the
    /// slip speed by no more than a factor in a step from there on, so that they pass over no fall next to rest,
    /// however narrow it is.
    pub fn onset(&self, belt_speed: f64) -> f64 {
        match self.form.closed() {
            Some(law) => law.onset(),
            None => self.compiled(4.0 * belt_speed).breaks()[1],
        }
    }

    /// Whether friction changes within the rounding errors of slip speeds by more than a thousandth of the friction at rest,
    /// or of its change up to the belt speed: no orbit in double precision shows it.
    pub fn is_hidden_by_rounding(&self, belt_speed: f64) -> bool {
        let at_rest = self.phi(0.0);
        let change = |u: f64| (at_rest - self.phi(u)).abs();
        let hidden = change(2.0 * f64::EPSILON * belt_speed);
        hidden > ROUNDED && hidden > HIDDEN * change(belt_speed).min(1.0) + ROUNDED
    }

    /// Slip speeds, increasing, at which integrators end their steps: the corners, 0 where a formula does not
    /// continue the law below, and the speeds of `Weakening::narrow` on orbits with velocities up to `fastest`,
    /// but at least 1, the velocity that the static friction gives to an orbit however slow the belt is.
    pub fn stops(&self, fastest: f64) -> Cow<'_, [f64]> {
        if self.has_known_features() {
            return Cow::Borrowed(self.corners());
        }
        self.stops_of(&self.compiled(4.0 * fastest.max(1.0)))
    }

    /// As [`Curve::stops`], up to the reach of the law in compiled form.
    pub fn stops_of(&self, compiled: &Weakening) -> Cow<'_, [f64]> {
        let corners = self.corners();
        if self.has_known_features() {
            return Cow::Borrowed(corners);
        }
        let at_rest = if self.formula(0.0).is_none() || compiled.is_continued() { &[][..] } else { &[0.0] };
        if compiled.narrow().is_empty() && at_rest.is_empty() {
            return Cow::Borrowed(corners);
        }
        let mut stops = [corners, at_rest, compiled.narrow()].concat();
        stops.sort_by(f64::total_cmp);
        stops.dedup();
        Cow::Owned(stops)
    }

    /// Returns whether the law's weakening rate is evaluated by a closed form of its own.
    #[must_use]
    pub fn has_closed_form(&self) -> bool {
        self.form.closed().is_some()
    }

    /// Returns whether the law has features only at rest and at its corners: closed forms, but for uncommon
    /// exponents, and tables.
    pub fn has_known_features(&self) -> bool {
        self.form.closed().is_some_and(ClosedForm::has_known_features) || matches!(self.form, Form::Table(_))
    }

    /// Returns whether the law has a narrow feature below the slip speed `u`.
    pub fn is_narrow_below(&self, u: f64) -> bool {
        !self.has_known_features() && self.compiled(2.0 * u).narrow().first().is_some_and(|stop| *stop < u)
    }

    /// Returns whether the weakening rate is one analytic function of the slip speeds of orbits that start
    /// within `belt_speed`, those below 0 included, and without narrow features.
    pub fn is_analytic(&self, belt_speed: f64) -> bool {
        match self.form.closed() {
            Some(law) if law.has_known_features() => true,
            None if !(matches!(self.form, Form::Expression(_)) && self.corners().is_empty()) => false,
            _ => self.compiled(4.0 * belt_speed).is_analytic(),
        }
    }

    /// Stribeck's law without a drop, for proofs over boxes and for vectorised engines, which use its
    /// parameters; `None` for other laws.
    pub fn stribeck(&self) -> Option<&Stribeck> {
        match &self.form {
            Form::Stribeck(law) if self.drop == 0.0 => Some(law),
            _ => None,
        }
    }

    /// The weakening rate of the exponential law with the exponent 1 or 2, and that of friction that does not fall, with or
    /// without a drop; `None` for other laws.
    pub fn exponential_fall(&self) -> Option<ExponentialFall> {
        match &self.form {
            Form::Exponential(law) => law.fall(),
            Form::Coulomb(law) => {
                let rise = -law.weakening(0.0);
                Some(ExponentialFall { steepest: 0.0, rate: 0.0, rise, is_squared: false })
            }
            _ => None,
        }
    }

    /// Returns whether the weakening rate is proved to be nonincreasing and convex in the slip speed, the
    /// continuation to u < 0 included.
    ///
    /// Then there is at most one slip cycle, at any damping, and it repels: [`Self::has_one_slip_cycle_at_most`].
    #[must_use]
    pub fn weakening_is_convex(&self) -> bool {
        self.form.closed().is_some_and(ClosedForm::weakening_is_convex)
    }

    /// Returns whether at most one slip cycle is proved to exist at each damping c >= 0: the weakening rate is
    /// convex, or concave, over all slip speeds that slip cycles may pass (theory, "At most one slip cycle").
    /// It then exists where the equilibrium attracts and the orbit from (V, 0) returns, and repels, or where neither
    /// holds, and attracts.
    #[must_use]
    pub fn has_one_slip_cycle_at_most(&self, belt_speed: f64) -> bool {
        let bends_one_way = |fastest: f64| self.compiled(fastest).bends_one_way(fastest);
        match self.form.closed() {
            Some(law) => law.weakening_is_convex(),
            None => self.fastest_of_slip_cycles(belt_speed).is_some_and(bends_one_way),
        }
    }

    /// A proved bound of the slip speeds on slip cycles at dampings c >= 0; `None` where there is none.
    ///
    /// Slip cycles lie inside the orbit from (V, 0), whose lower half lies inside that without damping. There the
    /// energy about x1 = M, M the largest friction up to the slip speed V, bounds x1 by M + sqrt(V^2 + (M - phi(0))^2)
    /// where x2 falls to 0, and from there on -x2 is at most the distance of that from the least friction.
    fn fastest_of_slip_cycles(&self, belt_speed: f64) -> Option<f64> {
        let between = |lo: f64, hi: f64| self.formula(Interval::new(lo, hi)).filter(|phi| phi.is_bounded());
        let speed = Interval::of(belt_speed);
        let highest = Interval::of(between(0.0, belt_speed)?.hi);
        let excess = highest - between(0.0, 0.0)?;
        let farthest = highest + (speed.square() + excess.square()).sqrt();
        let bound = |tried: f64| Some((speed + farthest - Interval::of(between(belt_speed, tried)?.lo)).hi);
        let tried = FASTEST_TRIED * belt_speed.max(1.0);
        // Up to a bound that holds the friction is bounded better.
        bound(bound(tried).filter(|fastest| *fastest <= tried)?)
    }
}

/// Proved upper bounds of a curve's weakening rate, see [`Curve::ranges`].
pub struct Ranges<'a> {
    curve: &'a Curve,
    compiled: Option<Arc<Weakening>>,
}

impl Ranges<'_> {
    /// The upper bound of [`Curve::weakening_range`] over [`lo`, `hi`].
    #[inline]
    pub fn highest(&self, lo: f64, hi: f64) -> f64 {
        match &self.compiled {
            Some(law) if hi <= law.reach() => law.highest(lo, hi),
            _ => match &self.curve.form {
                // It falls with the slip speed. Its lower bound, half of the work, is not computed.
                Form::Stribeck(law) => law.bounds(lo).hi,
                _ => self.curve.weakening_range(lo, hi).hi,
            },
        }
    }
}
