//! What the errors of measured friction do to the answers: the standard errors of the limits, and the
//! behaviours between which the data cannot decide.

use std::borrow::Cow;

use super::{Assessment, SAME, TOLERANCE};
use crate::intervals::belt_speeds;
use crate::risk::{Moved, NORMAL, Uncertain, WithError, error_by_curve, joint, uncertain_critical_damping};
use crate::{Friction, Machine, Model};
use rayon::prelude::*;
use slipmap_column::critical::{critical_damping, known_or_nan};
use slipmap_column::slip_cycle::Kick;
use slipmap_column::{Attractors, Regime, long_run};
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::Table;
use slipmap_model::point::Point;
use slipmap_numbers::random::Random;
use slipmap_orbits::flow;

/// Number of standard errors within which a limit leaves open on which side of it the machine is.
const NEAR: f64 = 2.0;
/// Number of changes from falling to rising friction, or back, from which rows without standard errors scatter: a curve
/// that falls and rises once has one.
const FEWEST_TURNS: usize = 2;
/// Relative step of the slope of the critical damping.
const STEP: f64 = 1e-3;
/// Numerical error of a critical damping less the working one, relative to that.
const NUMERICAL: f64 = 1e-6;
/// Share of [`NORMAL`] that a limit of the belt speed is to be away at least, and the number of limits that are tried.
const CLOSE_TO_NORMAL: f64 = 0.9;
const ROUNDS: u32 = 6;
/// Number of faster belts per factor of ten whose critical dampings are compared with the working one.
const FASTER_PER_DECADE: i32 = 8;
/// Number of data that are drawn for the error of a kick, and the share of them that is to have one.
const DRAWS: u32 = 48;
const LEAST_WITH_KICKS: f64 = 0.75;

/// Where standard errors of measured friction come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorsFrom {
    /// They are given with the data.
    Data,
    /// The scatter of the rows: the data have none.
    Scatter,
    /// What the curve between the rows could be: the data have no errors and do not scatter.
    Curve,
    /// The covariance of a fit.
    Fit,
}

impl ErrorsFrom {
    /// "by the scatter of the rows ...".
    pub fn in_words(self) -> &'static str {
        match self {
            ErrorsFrom::Data => "the standard errors of the data and the curve between the rows",
            ErrorsFrom::Fit => "the covariance of the fit",
            ErrorsFrom::Curve => "what the curve between the rows could be",
            ErrorsFrom::Scatter => "the scatter of the rows, which have no standard errors",
        }
    }
}

/// Standard errors that follow from those of the data of measured friction. Dampings are in N s/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandardErrors {
    /// Where the errors come from.
    pub from: ErrorsFrom,
    /// The critical damping, which may be negative here; `None` where it has no derivatives.
    pub critical_damping: Option<WithError>,
    /// The highest belt speed below which it may stick-slip, m/s; `None` where none is known, its error is unknown, or the
    /// errors leave open which of several speeds it is.
    pub critical_belt_speed: Option<WithError>,
    /// The damping below which steady slip is unstable.
    pub hopf_damping: WithError,
    /// Those of the kicks, m/s: of a fit to first order, of a table by random data; `None` where there is no kick, or they
    /// are unknown.
    pub kick: Option<Kick>,
}

impl StandardErrors {
    /// The standard errors of a machine; `None` for friction of which no errors are known.
    /// `belt_speed` is the highest one at which it may stick-slip, if that is known; `has_kick` whether a kick leads to
    /// another attractor.
    pub(super) fn of(
        machine: &Machine,
        uncertain: &[Uncertain],
        belt_speed: Option<f64>,
        has_kick: bool,
    ) -> Option<Self> {
        let errors = Self::of_dampings(machine, uncertain)?;
        let fit = joint(uncertain);
        let (machine, uncertain, kick) = if fit.is_empty() {
            let (machine, _) = measured_with_errors(machine)?;
            let kick = has_kick.then(|| error_of_drawn_kicks(&machine)).flatten();
            (machine, &[][..], kick)
        } else {
            let kick = has_kick.then(|| Moved::of(machine, &fit)?.errors(kicks)).flatten();
            (machine.clone(), uncertain, kick)
        };
        Some(Self {
            critical_belt_speed: error_of_belt_speed(&machine, uncertain, belt_speed),
            kick: kick.map(|[forward, backward]| Kick { forward, backward }),
            ..errors
        })
    }

    /// Those of the two limits of the damping alone, which take a small part of the time: by the data, or by the
    /// covariance of a fit, from differences over a standard deviation of each of its independent errors.
    pub fn of_dampings(machine: &Machine, uncertain: &[Uncertain]) -> Option<Self> {
        // The weakening rate at the belt speed is eps c at the Hopf bifurcation.
        let hopf = |machine: &Machine| {
            let model = machine.model()?;
            let per_rate = model.si.damping / model.point.epsilon;
            Some(model.column().curve.weakening(model.point.belt_speed) * per_rate)
        };
        let of = |from, critical_damping, hopf_damping| Self {
            from,
            critical_damping,
            critical_belt_speed: None,
            hopf_damping,
            kick: None,
        };
        let fit = joint(uncertain);
        if !fit.is_empty() {
            let [standard_error] = Moved::of(machine, &fit)?.errors(|it| Some([hopf(it)?]))?;
            let hopf = WithError { value: hopf(machine)?, standard_error };
            return Some(of(ErrorsFrom::Fit, uncertain_critical_damping(machine, uncertain), hopf));
        }
        let (machine, from) = measured_with_errors(machine)?;
        let model = machine.model()?;
        let column = model.column();
        let of_rate = column.curve.table()?.standard_error_of_weakening(column.belt_speed)?;
        let standard_error = of_rate * model.si.damping / model.point.epsilon;
        let hopf = WithError { value: hopf(&machine)?, standard_error };
        Some(of(from, uncertain_critical_damping(&machine, &[]), hopf))
    }

    /// What they leave open at a damping in N s/m, at which this regime was found.
    pub fn leave_open(&self, damping: f64, found: Regime) -> LeftOpen {
        let is_near = |limit: &WithError| (limit.value - damping).abs() <= NEAR * limit.standard_error;
        let hopf = Some(self.hopf_damping).filter(is_near).map(|limit| (DampingLimit::Hopf, limit));
        let critical = self.critical_damping.filter(is_near).map(|limit| (DampingLimit::Critical, limit));
        let regimes = possible(found, hopf.is_some(), critical.is_some());
        LeftOpen { from: self.from, limits: hopf.into_iter().chain(critical).collect(), regimes }
    }
}

/// A machine with measured friction, with the errors of its data, and where they come from.
fn measured_with_errors(machine: &Machine) -> Option<(Machine, ErrorsFrom)> {
    let Friction::Measured(table) = &machine.friction else { return None };
    let (table, from) = with_errors(table)?;
    Some((Machine { friction: Friction::Measured(table), ..machine.clone() }, from))
}

/// The belt speed below which a machine may stick-slip, with its standard error. It is where the critical damping takes
/// the working one, so at the 95 % limits that follow from its slope it is to differ from that by about [`NORMAL`] of its
/// own standard errors; where it differs by less, next to a steep slope, they are farther. `None` where it does so
/// nowhere, or may be above the working damping at a faster belt: then the errors leave open which speed it is.
fn error_of_belt_speed(
    machine: &Machine,
    uncertain: &[Uncertain],
    belt_speed: Option<f64>,
) -> Option<WithError> {
    let value = belt_speed?;
    let least_error = NUMERICAL * machine.damping;
    let at = |speed: f64| {
        let moved = machine.with("belt_speed", speed)?;
        let WithError { value, standard_error } = uncertain_critical_damping(&moved, uncertain)?;
        Some([value - machine.damping, standard_error.max(least_error)])
    };
    let slope = (at(value * (1.0 + STEP))?[0] - at(value * (1.0 - STEP))?[0]) / (2.0 * STEP * value);
    let mut standard_error = at(value)?[1] / slope.abs();
    let is_far = |distance: f64| distance >= CLOSE_TO_NORMAL * NORMAL;
    let found = (0..ROUNDS).find_map(|_| {
        let from_it =
            |by: f64| at(value + by * NORMAL * standard_error).map(|[off, error]| -by * off / error);
        // Of belts beyond the data, and of those at rest, nothing is known.
        let least = [-1.0, 1.0].into_iter().filter_map(from_it).reduce(f64::min)?;
        if is_far(least) {
            return Some(standard_error);
        }
        standard_error *= if least > 0.0 { NORMAL / least } else { f64::INFINITY };
        None
    });
    let standard_error = found.filter(|error| error.is_finite())?;
    let Model { law, point, si } = machine.model()?;
    let faster = belt_speeds(&law.column(&point).curve, FASTER_PER_DECADE).into_iter();
    let faster = faster.filter(|speed| speed * si.velocity > value + NORMAL * standard_error);
    let critical = |speed: f64| {
        let column = law.column(&Point { belt_speed: speed, ..point });
        known_or_nan(critical_damping(&column, TOLERANCE))
    };
    let highest = faster.map(|speed| (speed, critical(speed))).filter(|(_, c)| !c.is_nan());
    let is_open = highest.max_by(|one, other| one.1.total_cmp(&other.1)).is_some_and(|(speed, c)| {
        let known = at(speed * si.velocity);
        known.map_or(c > point.damping, |[off, error]| !is_far(-off / error))
    });
    (!is_open).then_some(WithError { value, standard_error })
}

/// A table with the standard errors of its data, and where they come from: those that it has, or else the scatter of
/// its rows, and what the curve between them could be.
pub fn with_errors(table: &Table) -> Option<(Table, ErrorsFrom)> {
    if table.standard_errors().is_some() {
        return Some((table.clone(), ErrorsFrom::Data));
    }
    let scatters = table.turns() >= FEWEST_TURNS;
    let (error, from) = match scatters {
        true => (table.scatter(), ErrorsFrom::Scatter),
        false => (0.0, ErrorsFrom::Curve),
    };
    let table = table.with_standard_errors(&vec![error; table.data().count()]).ok()?;
    Some((table.with_error_of_curve(), from))
}

/// The kicks of a machine with and against the belt, m/s; `None` where it has none.
fn kicks(machine: &Machine) -> Option<[f64; 2]> {
    let Model { law, point, si } = machine.model()?;
    let oscillator = Oscillator::new(&law, &point);
    let Kick { forward, backward } =
        long_run(&oscillator, &flow(&oscillator, TOLERANCE), TOLERANCE).basin?.kick;
    Some([forward, backward].map(|kick| kick * si.velocity))
}

/// The standard deviations of the kicks by random data. Data that scatter bend the curve within their errors, so
/// differences over a standard error of each row say less; they move the equilibrium, too. `None` where fewer than
/// [`LEAST_WITH_KICKS`] of them have a kick.
fn error_of_drawn_kicks(machine: &Machine) -> Option<[f64; 2]> {
    let Friction::Measured(table) = &machine.friction else { return None };
    let of_curve = error_by_curve(machine);
    let mut random = Random(16);
    let draws: Vec<Machine> = (0..DRAWS)
        .filter_map(|_| {
            let friction = Friction::Measured(table.drawn(|| random.normal()).ok()?);
            let damping = machine.damping + of_curve * random.normal();
            let drawn = Machine { friction, damping, ..machine.clone() };
            // A machine that is given by its damping ratio does not check what follows from it.
            Some(drawn).filter(|drawn| damping >= 0.0 && drawn.is_legal())
        })
        .collect();
    let drawn: Vec<[f64; 2]> = draws.par_iter().filter_map(kicks).collect();
    let count = drawn.len() as f64;
    if count < LEAST_WITH_KICKS * f64::from(DRAWS) {
        return None;
    }
    Some([0, 1].map(|of| {
        let mean = drawn.iter().map(|kicks| kicks[of]).sum::<f64>() / count;
        let squares = drawn.iter().map(|kicks| (kicks[of] - mean).powi(2));
        (squares.sum::<f64>() / (count - 1.0)).sqrt()
    }))
}

/// A limit of the damping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DampingLimit {
    /// Below it steady slip is unstable.
    Hopf,
    /// Below it the stick-slip cycle exists.
    Critical,
}

/// What the errors of the data leave open at the working point.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOpen {
    /// Where the errors come from.
    pub from: ErrorsFrom,
    /// The limits within two standard errors of the working damping, each with its error; none where the data
    /// decide.
    pub limits: Vec<(DampingLimit, WithError)>,
    /// The regimes that are possible, that of the curve through the data first; only that one where the data
    /// decide. Slip cycles that other data would have are left out.
    pub regimes: Vec<Regime>,
}

impl LeftOpen {
    /// The regime that was found, in `words`, and which others are possible.
    pub fn in_words(&self, words: impl Fn(Regime) -> Cow<'static, str>) -> String {
        let all: Vec<_> = self.regimes.iter().map(|regime| words(*regime)).collect();
        let by = match self.from {
            ErrorsFrom::Fit => "the fit, whose errors leave",
            ErrorsFrom::Data | ErrorsFrom::Scatter | ErrorsFrom::Curve => {
                "the curve through the data, which leave"
            }
        };
        match all.as_slice() {
            [found, others @ ..] if !others.is_empty() => {
                format!("{found} by {by} it open; possible as well: {}", others.join(", or "))
            }
            found => found.concat(),
        }
    }

    /// The names of the possible regimes; none where the data decide.
    pub fn names(&self) -> Vec<&'static str> {
        let is_open = !self.limits.is_empty();
        self.regimes.iter().filter(|_| is_open).map(|regime| regime.name()).collect()
    }
}

impl Assessment {
    /// What the errors of the data leave open; `None` where none are known.
    pub fn left_open(&self) -> Option<LeftOpen> {
        self.standard_errors.map(|errors| errors.leave_open(self.machine.damping, self.behaviour.regime))
    }

    /// Whether the errors of the data leave open what the machine does.
    pub fn is_left_open(&self) -> bool {
        self.left_open().is_some_and(|open| !open.limits.is_empty())
    }

    /// The numerical error of a limit of the damping, of which only that of the critical damping is known: 0 for
    /// others.
    pub fn numerical_error_of(&self, damping: f64) -> f64 {
        match (self.behaviour.critical_damping, self.behaviour.critical_damping_error) {
            (Some(critical), Some(error)) if (damping - critical).abs() <= SAME * critical.abs() => error,
            _ => 0.0,
        }
    }

    /// The standard error of a limit of the damping; `None` unless it is the critical or the Hopf damping.
    pub fn standard_error_of(&self, damping: f64) -> Option<f64> {
        let errors = self.standard_errors?;
        let is = |limit: f64| (damping - limit).abs() <= SAME * limit.abs();
        match self.behaviour.critical_damping {
            Some(critical) if is(critical) => errors.critical_damping.map(|of| of.standard_error),
            _ => is(self.hopf_damping).then_some(errors.hopf_damping.standard_error),
        }
    }
}

/// The regimes that are possible if these limits are open: the one found, first, and those on their other
/// sides. A slip cycle attracts where nothing else does. One that attracts beside others may be made by the
/// errors: its own limits lie between these two.
fn possible(found: Regime, hopf: bool, critical: bool) -> Vec<Regime> {
    let mut regimes = vec![found];
    if matches!(found, Regime::Failed | Regime::Neutral) || !(hopf || critical) {
        return regimes;
    }
    let here = found.attractors();
    let slip_with_others = here.slip && found != Regime::PureSlip;
    let both = |is_open: bool, here: bool| if is_open { vec![here, !here] } else { vec![here] };
    // Where the orbit from the exit point crosses for ever, that ends at the critical damping or little below it.
    let crosses = here.crossing && !here.stick_slip;
    let may_return = match crosses && critical {
        true => vec![(false, true), (true, false), (false, false)],
        false => both(critical, here.stick_slip).into_iter().map(|sticks| (sticks, here.crossing)).collect(),
    };
    for equilibrium in both(hopf, here.equilibrium) {
        for &(stick_slip, crossing) in &may_return {
            for slip in both(slip_with_others, slip_with_others) {
                let slip = slip || !(equilibrium || stick_slip || crossing);
                let regime = Regime::of(Attractors { equilibrium, stick_slip, slip, crossing });
                if !regimes.contains(&regime) {
                    regimes.push(regime);
                }
            }
        }
    }
    regimes
}

#[cfg(test)]
mod tests {
    use super::super::assess;
    use super::*;
    use crate::behaviour::Limit;
    use crate::example_of;

    const DATA: [(f64, f64); 7] =
        [(0.0, 0.42), (0.03, 0.37), (0.07, 0.33), (0.15, 0.3), (0.3, 0.285), (0.6, 0.28), (1.2, 0.285)];

    /// So small that their effects are proportional to them.
    const ERROR: f64 = 1e-5;

    fn machine(data: &[(f64, f64)], damping: f64) -> Machine {
        let table = Table::new("a pad", data, data[0].1).unwrap();
        let friction = Friction::Measured(table.with_standard_errors(&[ERROR; 7]).unwrap());
        example_of(friction, [1.8, 4.2e5, 900.0, 0.1, damping])
    }

    #[test]
    fn the_error_of_the_kick_is_that_of_changed_data() {
        let limits = assess(&machine(&DATA, 1.0)).unwrap();
        let damping = 0.5 * (limits.hopf_damping + limits.behaviour.critical_damping.unwrap());
        let all = assess(&machine(&DATA, damping)).unwrap();
        assert_eq!(all.behaviour.regime, Regime::Bistable);
        let basin = |data: &[(f64, f64)]| {
            let Model { law, point, si } = machine(data, damping).model().unwrap();
            let oscillator = Oscillator::new(&law, &point);
            let basin = long_run(&oscillator, &flow(&oscillator, TOLERANCE), TOLERANCE).basin.unwrap();
            [basin.kick.forward, basin.kick.backward].map(|velocity| velocity * si.velocity)
        };
        let here = basin(&DATA);
        assert!((here[0] / all.kick.unwrap().forward - 1.0).abs() < 1e-9);
        const SHARE: f64 = 2.0;
        let squares = (0..DATA.len()).map(|row| {
            let moved = |by: f64| {
                let mut data = DATA;
                data[row].1 += by * SHARE * ERROR;
                basin(&data)
            };
            let [after, before] = [moved(1.0), moved(-1.0)];
            [0, 1].map(|of| ((after[of] - before[of]) / (2.0 * SHARE * here[of])).powi(2))
        });
        let sums = squares.fold([0.0; 2], |sums, squares| [sums[0] + squares[0], sums[1] + squares[1]]);
        let Kick { forward, backward } = all.standard_errors.unwrap().kick.unwrap();
        for ((found, expected), here) in [forward, backward].into_iter().zip(sums).zip(here) {
            let (found, expected) = (found / here, expected.sqrt());
            // Three standard deviations of that of so many draws.
            let tolerance = 3.0 / f64::from(2 * DRAWS).sqrt();
            assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected}");
        }
    }

    /// Orbits of the fastest belts leave the data. The highest belt speed has its error where its own orbit does not, and
    /// else the page says how far to measure.
    #[test]
    fn speeds_within_the_data_have_errors_others_a_remedy() {
        let at = |speed: f64| {
            let model = machine(&DATA, 1.0).with("belt_speed", speed).unwrap().model().unwrap();
            let critical = critical_damping(&model.column(), 1e-9).unwrap().c * model.si.damping;
            assess(&machine(&DATA, critical)).unwrap()
        };
        let within = at(0.575);
        let WithError { value, standard_error } =
            within.standard_errors.unwrap().critical_belt_speed.unwrap();
        assert!((value - 0.575).abs() < 1e-5 && standard_error > 0.0, "{value} {standard_error}");
        assert!(matches!(within.behaviour.critical_belt_speed, Limit::AtLeast(_)), "{:?}", within.behaviour);
        assert_eq!(within.needed_for_speeds, None);
        let beyond = at(0.59);
        assert_eq!(beyond.standard_errors.unwrap().critical_belt_speed, None);
        assert!(beyond.needed_for_speeds.is_some_and(|speed| speed > 1.2), "{:?}", beyond.needed_for_speeds);
    }

    /// Rows next to rest make a window of slow belts. Its end has an error unless the machine may stick-slip at faster
    /// belts, too, by the curve or within the errors; at 1.96 errors from it on either side the critical damping is as
    /// many of its own from the working one, though its slope changes.
    #[test]
    fn a_window_below_open_speeds_ends_without_error() {
        let data =
            [(0.0, 0.42), (0.001, 0.4), (0.03, 0.4), (0.06, 0.33), (0.12, 0.29), (0.2, 0.28), (0.3, 0.28)];
        let of = |damping: f64, error: f64| {
            let machine = machine(&data, damping);
            let Friction::Measured(table) = &machine.friction else { unreachable!() };
            let table = table.with_standard_errors(&[error; 7]).unwrap();
            Machine { friction: Friction::Measured(table), ..machine }
        };
        let critical = |machine: &Machine, speed: f64| {
            uncertain_critical_damping(&machine.with("belt_speed", speed)?, &[])
        };
        // From the critical damping of belts at 0.037 m/s, the largest of faster ones, and from where the slope is steep.
        let highest = critical(&of(1.0, ERROR), 0.037).unwrap().value;
        for (damping, error, end, is_known) in [
            (0.95 * highest, ERROR, 0.001_580_576, false),
            (1.05 * highest, ERROR, 0.001_303_664, true),
            (1.05 * highest, 1e-2, 0.001_303_664, false),
            (5000.0, 3e-3, 0.000_925_102, true),
        ] {
            let machine = of(damping, error);
            let off =
                |speed: f64| critical(&machine, speed).map(|at| (at.value - damping) / at.standard_error);
            assert!(off(end).unwrap().abs() < 0.1, "{damping}: {end} m/s is no end");
            let found = error_of_belt_speed(&machine, &[], Some(end));
            assert_eq!(found.is_some(), is_known, "{damping} {error}: {found:?}");
            let Some(WithError { standard_error, .. }) = found else { continue };
            let [below, above] = [-NORMAL, NORMAL].map(|by| off(end + by * standard_error).unwrap());
            assert!(below.min(-above) >= CLOSE_TO_NORMAL * NORMAL, "{damping}: {below} {above}");
        }
    }

    /// On each side of each limit: the regime of the curve, and that of the other side.
    #[test]
    fn a_limit_within_the_errors_leaves_two_regimes_open() {
        use DampingLimit::{Critical, Hopf};
        use Regime::{Bistable, Equilibrium, PureSlip, StickSlip};
        let mut all = assess(&machine(&DATA, 1.0)).unwrap();
        let of = |value: f64| WithError { value, standard_error: 10.0 };
        let mut open = |found: Regime, hopf: f64, critical: f64| {
            all.machine.damping = 100.0;
            all.behaviour.regime = found;
            let errors = all.standard_errors.as_mut().unwrap();
            (errors.hopf_damping, errors.critical_damping) = (of(hopf), Some(of(critical)));
            let LeftOpen { limits, regimes, .. } = all.left_open().unwrap();
            (limits.into_iter().map(|(limit, _)| limit).collect::<Vec<_>>(), regimes)
        };
        assert_eq!(open(StickSlip, 121.0, 200.0), (vec![], vec![StickSlip]));
        assert_eq!(open(StickSlip, 119.0, 200.0), (vec![Hopf], vec![StickSlip, Bistable]));
        assert_eq!(open(Bistable, 81.0, 200.0), (vec![Hopf], vec![Bistable, StickSlip]));
        assert_eq!(open(Bistable, 50.0, 110.0), (vec![Critical], vec![Bistable, Equilibrium]));
        assert_eq!(open(Equilibrium, 50.0, 90.0), (vec![Critical], vec![Equilibrium, Bistable]));
        assert_eq!(open(Equilibrium, 90.0, 50.0), (vec![Hopf], vec![Equilibrium, PureSlip]));
        assert_eq!(open(PureSlip, 110.0, 50.0), (vec![Hopf], vec![PureSlip, Equilibrium]));
        assert_eq!(open(StickSlip, 200.0, 110.0), (vec![Critical], vec![StickSlip, PureSlip]));
        let four = vec![StickSlip, PureSlip, Bistable, Equilibrium];
        assert_eq!(open(StickSlip, 105.0, 110.0), (vec![Hopf, Critical], four));
        // The slip cycle may be one of the errors.
        use Regime::{EquilibriumPureSlipAndStickSlip, PureSlipAndStickSlip};
        let four = vec![PureSlipAndStickSlip, StickSlip, EquilibriumPureSlipAndStickSlip, Bistable];
        assert_eq!(open(PureSlipAndStickSlip, 119.0, 200.0), (vec![Hopf], four));
        assert_eq!(open(Regime::Failed, 119.0, 200.0), (vec![Hopf], vec![Regime::Failed]));
        all.standard_errors = None;
        assert_eq!(all.left_open(), None);
    }
}
