//! The lines of the page about the intervals of belt speed and damping in which the machine behaves in one way.

use super::lines::{Line, damping_limit, digits_of_data, with_error};
use super::units::{Unit, Written};
use slipmap_figure::text::{Rich, rich};
use slipmap_map::assessment::{Assessment, End, Intervals, Statement};
use slipmap_map::machine::Dimension;
use slipmap_map::risk::WithError;

/// A quantity that varies: its words, its unit, and how a located end of an interval is printed, without unit.
struct Varied<'a> {
    words: String,
    unit: Unit,
    located: &'a dyn Fn(f64, f64) -> Rich,
}

/// The belt speeds at which each statement holds.
pub(super) fn of_speeds(all: &Assessment, written: &Written) -> Vec<Line> {
    let words = all.machine.motion.words("belt_speed");
    let unit = Unit::of(&all.machine, written, "belt_speed", Dimension::Velocity);
    let size = unit.size;
    let [of_slope, of_mean] = digits_of_data(all);
    let of_data = all.standard_errors.and_then(|errors| errors.critical_belt_speed);
    let lines = Statement::ALL.into_iter().zip(&all.speeds).filter_map(|(statement, intervals)| {
        let digits = if statement == Statement::AlwaysSticks { of_slope } else { of_mean };
        let located = |value: f64, error: f64| match of_data {
            Some(WithError { value: limit, standard_error }) if (limit - value).abs() <= error => {
                with_error(WithError { value: limit / size, standard_error: standard_error / size }, "")
            }
            _ => Rich::with_error(value / size, error / size, digits),
        };
        let varied = Varied { words: words.clone(), unit: unit.clone(), located: &located };
        varied.line(statement, intervals)
    });
    lines.collect()
}

/// The dampings at which each statement holds; but for those below the critical damping, which has a line of its
/// own.
pub(super) fn of_dampings(all: &Assessment) -> Vec<Line> {
    let [of_slope, _] = digits_of_data(all);
    let located = |value: f64, error: f64| match all.numerical_error_of(value) >= error {
        true => damping_limit(all, value, of_slope, ""),
        false => match all.standard_error_of(value) {
            Some(standard_error) if standard_error >= error => {
                with_error(WithError { value, standard_error }, "")
            }
            _ => Rich::with_error(value, error, of_slope),
        },
    };
    let unit = Unit::of(&all.machine, &[], "damping", Dimension::Damping);
    let varied = Varied { words: "damping".into(), unit, located: &located };
    let each = Statement::ALL.into_iter().zip(&all.dampings);
    let told = each.filter(|(statement, intervals)| {
        !matches!((statement, intervals.holds.as_slice()), (Statement::MayStick, [] | [[End::Tried(_), _]]))
    });
    told.filter_map(|(statement, intervals)| varied.line(statement, intervals)).collect()
}

impl Varied<'_> {
    /// "always stick-slips below belt speed: 0.1956 m/s", "may stick-slip at belt speeds: 0.0002 to 0.01 m/s";
    /// `None` for what machines seldom do, unless this one does it.
    fn line(&self, statement: Statement, intervals: &Intervals) -> Option<Line> {
        let words = match statement {
            Statement::AlwaysSticks => "always stick-slips",
            Statement::MayStick => "may stick-slip",
            Statement::MaySlip => "may vibrate without sticking",
            Statement::MayCross => "may overtake the belt for ever",
        };
        let seldom = matches!(statement, Statement::MaySlip | Statement::MayCross);
        if seldom && intervals.holds.is_empty() {
            return None;
        }
        if let ([[End::Tried(_), End::At { value, error }]], []) =
            (intervals.holds.as_slice(), intervals.unknown.as_slice())
        {
            let name = rich(&format!("{words} below {}", self.words));
            return Some((name, (self.located)(*value, *error).with_unit(&self.unit.name)));
        }
        Some((rich(&format!("{words} at {}s", self.words)), self.intervals(intervals)))
    }

    fn intervals(&self, of: &Intervals) -> Rich {
        let number = |value: f64| Rich::number(value / self.unit.size, 3);
        let [least, most] = of.tried.map(number);
        let known = match of.holds.as_slice() {
            [] if of.unknown == [of.tried] => return rich("not determined"),
            [] => rich("none of those tried, ").then(least).then(" to ").then(most),
            [[End::Tried(_), End::Tried(_)]] => {
                rich("all of those tried, ").then(least).then(" to ").then(most)
            }
            several => several
                .iter()
                .map(|ends| self.interval(*ends))
                .reduce(|text, next| text.then(", ").then(next))
                .unwrap_or_default(),
        };
        let unknown = of.unknown.iter().map(|[from, to]| number(*from).then(" to ").then(number(*to)));
        let unknown = unknown.reduce(|text, next| text.then(", ").then(next));
        let known = known.with_unit(&self.unit.name);
        match unknown {
            Some(unknown) => known.then("; not known at ").then(unknown).with_unit(&self.unit.name),
            None => known,
        }
    }

    /// "0.0002 to 0.01", "up to 0.01", "0.0002 to at least 13.5".
    fn interval(&self, [from, to]: [End; 2]) -> Rich {
        let number = |end: End| match end.located() {
            Some([value, error]) => (self.located)(value, error),
            None => Rich::number(end.value() / self.unit.size, 3),
        };
        let end = match to {
            End::At { .. } => number(to),
            End::Tried(_) | End::Open(_) => rich("at least ").then(number(to)),
        };
        match from {
            End::Tried(_) => rich("up to ").then(end),
            End::At { .. } | End::Open(_) => number(from).then(" to ").then(end),
        }
    }
}
