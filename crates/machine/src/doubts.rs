//! Warnings about numbers of a machine that are legal but suggest that they are not in SI units.

use super::{Dimension, Friction, Machine, Motion};
use slipmap_model::friction::Table;

/// Fastest belt speed of a plausible machine, m/s.
const FASTEST: f64 = 100.0;
/// Largest plausible coefficient of friction.
const HIGHEST_FRICTION: f64 = 5.0;
/// Largest plausible ratio of the fastest measured slip speed to the belt speed.
const WIDEST_TABLE: f64 = 500.0;
/// Least number of changes of direction, and least share of the rows that have one, of a measured table that
/// is taken to be scattered. With independent errors alone, two thirds of the rows have one.
const FEWEST_TURNS: usize = 8;
const SHARE_OF_TURNS: f64 = 0.25;
/// Largest number of rows that are taken to be means already if they have standard errors.
const MOST_MEANS: usize = 20;

impl Machine {
    /// The warnings: which number is implausible, and why, one line each.
    pub fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        let unit = self.motion.unit(Dimension::Velocity);
        if self.motion == Motion::Translation && self.belt_speed > FASTEST {
            doubts.push(format!(
                "belt_speed = {} m/s is above {FASTEST} m/s; if it is in mm/s, divide it by 1000",
                self.belt_speed
            ));
        }
        let rest = self.friction.at_rest();
        if rest > HIGHEST_FRICTION && self.normal_force_is_known {
            doubts.push(format!(
                "the coefficient of friction at rest is {rest}, above {HIGHEST_FRICTION}; if these are forces, divide them by \
                 the normal force, or for a table set quantity = \"force\" in [friction]"
            ));
        }
        let Friction::Measured(table) = &self.friction else { return doubts };
        if table.fastest() >= WIDEST_TABLE * self.belt_speed {
            doubts.push(format!(
                "the slip speeds of {} reach {} {unit}, {:.0} times belt_speed = {} {unit}; if they are in thousandths \
                 of that unit, such as mm/s, divide them by 1000",
                table.origin(),
                table.fastest(),
                table.fastest() / self.belt_speed,
                self.belt_speed
            ));
        }
        if let Some(errors) = table.standard_errors()
            && table.root_of_covariance().is_none()
            && !table.source().named_errors
            && let largest = errors.iter().copied().fold(0.0, f64::max)
            && largest > table.static_level()
        {
            doubts.push(format!(
                "the third column of {} reaches {largest}, more than the friction at rest: it is read as the standard error \
                 of the friction; if it is not, leave it out",
                table.origin()
            ));
        }
        doubts.extend(negative(table));
        if let Some((turns, rows)) = scatter(table) {
            doubts.push(format!(
                "the friction of {} rises and falls by turns, at {turns} of {rows} rows: the curve goes through every \
                 row, and its bumps may be errors of the data; average neighbouring rows into at most {MOST_MEANS} \
                 speeds, with the standard error of each mean as third column",
                table.origin()
            ));
        }
        doubts
    }
}

/// The warning about a table with negative friction, which would push the mass on; `None` for other tables.
pub fn negative(table: &Table) -> Option<String> {
    let mut rows = table.data().enumerate().filter(|(_, (_, friction))| *friction < 0.0);
    let (row, (u, friction)) = rows.next()?;
    let also = match rows.count() {
        0 => String::new(),
        1 => ", and in one more row".to_owned(),
        more => format!(", and in {more} more rows"),
    };
    let place = table
        .source()
        .lines
        .get(row)
        .filter(|line| **line > 0)
        .map_or_else(|| format!(", row {}", row + 1), |line| format!(":{line}"));
    Some(format!(
        "{}{place}: the friction is negative, {friction} at slip speed {u}{also}: it would push the mass on; check the \
         sign, and the zero of the measurement",
        table.origin()
    ))
}

/// The number of changes of direction and the number of rows, for a table that changes its direction so often
/// that its errors must be the cause; `None` for other tables, and for as few means with standard errors as
/// the warning asks for.
pub fn scatter(table: &Table) -> Option<(usize, usize)> {
    let (turns, rows) = (table.turns(), table.data().count());
    let averaged = table.standard_errors().is_some() && rows <= MOST_MEANS;
    let scatters = turns >= FEWEST_TURNS && turns as f64 >= SHARE_OF_TURNS * rows as f64;
    (scatters && !averaged).then_some((turns, rows))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use slipmap_model::friction::{Law, Source};

    /// Once its advice is followed the warning of scatter is silent, even if the means still scatter.
    #[test]
    fn scatter_is_told_until_the_rows_are_averaged() {
        let scattered = |rows: usize, errors: bool| {
            let row = |i| (0.01 * f64::from(i), 0.4 - 0.002 * f64::from(i) + 0.005 * f64::from(i % 2));
            let data: Vec<(f64, f64)> = (0..).map(row).take(rows).collect();
            let table = Table::new("a.csv", &data, 0.4).unwrap();
            let with_errors = || table.with_standard_errors(&vec![0.002; rows]).unwrap();
            let friction = Friction::Measured(if errors { with_errors() } else { table.clone() });
            Machine { friction, belt_speed: 0.1, ..example(Law::Exponential) }.doubts().join("; ")
        };
        assert_eq!(scattered(9, false), "");
        for (rows, errors) in [(40, false), (40, true), (20, false)] {
            let said = scattered(rows, errors);
            assert!(said.contains(&format!("at {} of {rows} rows", rows - 2)), "{said}");
            assert!(said.contains("into at most 20 speeds, with the standard error"), "{said}");
        }
        assert_eq!(scattered(20, true), "");
    }

    #[test]
    fn numbers_in_other_units_look_odd() {
        let machine = example(Law::Exponential);
        assert_eq!(machine.doubts(), Vec::<String>::new());
        let odd = |name: &str, value: f64| machine.with(name, value).unwrap().doubts().join("; ");
        assert!(odd("belt_speed", 150.0).contains("150 m/s is above 100 m/s"));
        assert!(odd("static_friction", 20.0).contains("at rest is 20, above 5"));
        let of = |table: Table| {
            let friction = Friction::Measured(table);
            Machine { friction, belt_speed: 0.1, ..machine.clone() }.doubts().join("; ")
        };
        let data = [(0.0, 0.4), (0.2, -0.1), (0.5, 0.33), (0.6, -0.2)];
        let negative = Table::new("pad.csv", &data, 0.4).unwrap();
        let lines = Source { lines: vec![2, 5, 6, 7], readings: 4, ..Source::default() };
        let said = of(negative.with_source(lines));
        let expected = "pad.csv:5: the friction is negative, -0.1 at slip speed 0.2, and in one more row: ";
        assert!(said.starts_with(expected), "{said}");
        assert!(of(negative).starts_with("pad.csv, row 2: the friction is negative"));
        let table = |unit: f64| {
            let data = [(0.0, 0.4), (0.2 * unit, 0.35), (0.5 * unit, 0.33)];
            Table::new("a.csv", &data, 0.4).unwrap()
        };
        let measured = |unit: f64| of(table(unit));
        assert_eq!(measured(1.0), "");
        let with_third_column = |third: [f64; 3]| of(table(1.0).with_standard_errors(&third).unwrap());
        let named = Source { named_errors: true, ..Source::default() };
        let named = table(1.0).with_standard_errors(&[27.0, 31.0, 37.0]).unwrap().with_source(named);
        assert!(!of(named).contains("third column"));
        assert_eq!(with_third_column([0.01, 0.02, 0.02]), "");
        // A temperature.
        assert!(with_third_column([27.0, 31.0, 37.0]).contains("third column of a.csv reaches 37"));
        assert!(measured(1000.0).contains("a.csv reach 500 m/s, 5000 times"), "{}", measured(1000.0));
    }
}
