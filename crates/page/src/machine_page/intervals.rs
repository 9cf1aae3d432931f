//! The lines of the page about the intervals of belt speed and damping in which the machine behaves in one way.

use super::Line;
use super::units::{Unit, Written, with_error};
use slipmap_figure::text::{Rich, rich};
use slipmap_machine::assessment::{Assessment, End, Intervals, Statement};
use slipmap_machine::risk::WithError;
use slipmap_numbers::text::digits_within;

/// Numbers of digits of what depends on the slope of the friction and on its mean over the motion in a way
/// that is not known: those of the damping below which steady slip is unstable, and of the critical damping.
pub(super) fn digits_of_data(all: &Assessment) -> [usize; 2] {
    let errors = all.standard_errors;
    let limits =
        [errors.map(|errors| errors.hopf_damping), errors.and_then(|errors| errors.critical_damping)];
    limits.map(|limit| {
        limit.map_or(4, |WithError { value, standard_error }| digits_within(value, standard_error, 4).max(2))
    })
}

/// A quantity that varies: its words, its unit, and the error and number of digits with which an end of an interval is
/// printed that is located to within an error.
struct Varied<'a> {
    words: String,
    unit: Unit<'a>,
    located: &'a dyn Fn(f64, f64) -> (f64, usize),
}

/// The belt speeds at which each statement holds.
pub(super) fn of_speeds(all: &Assessment, written: &Written) -> Vec<Line> {
    let motion = all.machine.motion;
    let [of_slope, of_mean] = digits_of_data(all);
    let of_data = all.standard_errors.and_then(|errors| errors.critical_belt_speed);
    let unit = Unit::of(&all.machine, written, "belt_speed");
    let lines = Statement::ALL.into_iter().zip(&all.speeds).filter_map(|(statement, intervals)| {
        let digits = if statement == Statement::AlwaysSticks { of_slope } else { of_mean };
        let located = |value: f64, error: f64| match of_data {
            Some(limit) if (limit.value - value).abs() <= error => (limit.standard_error, 4),
            _ => (error, digits),
        };
        let varied = Varied { words: motion.words("belt_speed"), unit, located: &located };
        varied.line(statement, intervals)
    });
    lines.collect()
}

/// Whether it may stick-slip from the least damping on, if at any: then the critical damping tells at which it may.
pub(super) fn sticks_from_the_least(all: &Assessment) -> bool {
    match all.dampings[Statement::MayStick as usize].holds.as_slice() {
        [] => all.behaviour.critical_damping.is_none(),
        several => matches!(several, [[End::Tried(_), _]]),
    }
}

/// The dampings at which each statement holds; but for those at which it may stick-slip where the critical damping tells
/// them in a line of its own.
pub(super) fn of_dampings(all: &Assessment, written: &Written) -> Vec<Line> {
    let [of_slope, _] = digits_of_data(all);
    let unit = Unit::of(&all.machine, written, "damping");
    let located = |value: f64, error: f64| {
        let numerical = all.numerical_error_of(value).max(error);
        all.standard_error_of(value)
            .filter(|error| *error >= numerical)
            .map_or((numerical, of_slope), |error| (error, 4))
    };
    let varied = Varied { words: "damping".into(), unit, located: &located };
    let each = Statement::ALL.into_iter().zip(&all.dampings);
    let told = each.filter(|(statement, _)| *statement != Statement::MayStick || !sticks_from_the_least(all));
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
            let (error, digits) = (self.located)(*value, *error);
            return Some((name, with_error(*value, error, digits, self.unit)));
        }
        Some((rich(&format!("{words} at {}s", self.words)), self.intervals(intervals)))
    }

    fn intervals(&self, of: &Intervals) -> Rich {
        let number = |value: f64| self.unit.unnamed().number(value, 3);
        let [least, most] = of.tried.map(number);
        let unknown = of.unknown.iter().map(|[from, to]| between(number(*from), number(*to)));
        let unknown = unknown.reduce(|text, next| text.then(", ").then(next));
        let known = match (of.holds.as_slice(), unknown.is_some()) {
            ([], true) if of.unknown == [of.tried] => return rich("not determined"),
            ([], true) => rich("none known"),
            ([], false) => rich("none of those tried, ").then(least).then(" to ").then(most),
            ([[End::Tried(_), End::Tried(_)]], _) => {
                rich("all of those tried, ").then(least).then(" to ").then(most)
            }
            (several, _) => several
                .iter()
                .map(|ends| self.interval(*ends))
                .reduce(|text, next| text.then(", ").then(next))
                .unwrap_or_default(),
        };
        match unknown {
            Some(unknown) => known.then("; not known at ").then(unknown),
            None => known,
        }
        .with_unit(self.unit.name)
    }

    /// "0.0002 to 0.01", "up to 0.01", "0.0002 to at least 13.5".
    fn interval(&self, [from, to]: [End; 2]) -> Rich {
        let width = to.value() - from.value();
        // An error beyond the width of the interval moves both of its ends.
        let number = |end: End| {
            let unit = self.unit.unnamed();
            let located = end.located().map(|[value, error]| (value, (self.located)(value, error)));
            match located.filter(|(_, (error, _))| *error < width) {
                Some((value, (error, digits))) => with_error(value, error, digits, unit),
                None => unit.number(end.value(), 3),
            }
        };
        let end = match to {
            End::At { .. } => number(to),
            End::Tried(_) | End::Open(_) => rich("at least ").then(number(to)),
        };
        match from {
            End::Tried(_) => rich("up to ").then(end),
            End::At { .. } | End::Open(_) => between(number(from), end),
        }
    }
}

/// "0.3 to 0.4"; "about 0.3" where the digits that are printed do not tell the ends apart.
fn between(from: Rich, to: Rich) -> Rich {
    match from.plain() == to.plain() {
        true => rich("about ").then(from),
        false => from.then(" to ").then(to),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is known nowhere is not told as nowhere true, and ends that look alike are one number.
    #[test]
    fn intervals_have_one_line_each() {
        let located = |_: f64, error: f64| (error, 3);
        let unit = Unit { name: "rpm", size: 0.1, also: None };
        let varied = Varied { words: "speed".into(), unit, located: &located };
        let line = |holds: Vec<[End; 2]>, unknown: Vec<[f64; 2]>| {
            varied.intervals(&Intervals { holds, unknown, tried: [0.0, 8.0] }).plain()
        };
        assert_eq!(line(vec![], vec![]), "none of those tried, 0 to 80 rpm");
        assert_eq!(line(vec![], vec![[0.0, 8.0]]), "not determined");
        assert_eq!(line(vec![], vec![[0.0, 4.0]]), "none known; not known at 0 to 40 rpm");
        let open = [End::Tried(0.0), End::Open(2.0)];
        assert_eq!(line(vec![open], vec![[2.0, 2.000_001]]), "up to at least 20; not known at about 20 rpm");
        let at = |value: f64, error: f64| End::At { value, error };
        assert_eq!(line(vec![[at(4.3, 1e-6), at(4.4, 5.0)]], vec![]), "43 to 44 rpm");
    }
}
