//! The probability that a machine may stick-slip, in each cell of a map.

use std::sync::atomic::{AtomicBool, Ordering};

use super::{Grid, pool, unravel};
use slipmap_machine::Machine;
use slipmap_machine::risk::{
    FEWEST_DRAWS, Needed, NoRisk, USUAL_DRAWS, Uncertain, is_uncertain, usual_draws,
};

/// The probability that a machine may stick-slip, over a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Probabilities {
    /// Probabilities, row-major over machines (slower) and dampings; NaN where no draw has an answer.
    pub values: Vec<f64>,
    /// The probabilities that it vibrates by itself, likewise.
    pub by_itself: Vec<f64>,
    /// Number of draws, over all machines, whose critical damping was not found; they are left out.
    pub failed: usize,
    /// Number of illegal machines that were drawn, see [`slipmap_machine::risk::Risk::redrawn`].
    pub redrawn: usize,
}

/// The least and the largest number of draws in a column of a map, the least as long as [`USUAL_DRAWS`] are usual: the
/// standard error of a probability is then at most 0.016, and need not be below 0.005. All columns together have as many as
/// one machine, if that is more.
const DRAWS_OF_COLUMN: [usize; 2] = [1_000, 10_000];

/// The probability of stick-slip in each cell of a map.
pub struct Chances<'a> {
    grid: &'a Grid,
    uncertain: &'a [Uncertain],
    /// Number of draws in each column.
    pub draws: usize,
}

impl<'a> Chances<'a> {
    /// `None` for a grid without a machine or without uncertain quantities.
    pub fn of(grid: &'a Grid, uncertain: &'a [Uncertain]) -> Option<Self> {
        grid.machine().filter(|machine| is_uncertain(machine, uncertain))?;
        let [fewest, most] = DRAWS_OF_COLUMN;
        let columns = grid.column_count();
        // A few columns tell how long their draws take.
        let some = [0, columns / 2, columns - 1].into_iter().filter_map(|column| machine_of(grid, column));
        let usual = some.filter(Machine::is_legal).map(|machine| usual_draws(&machine)).min();
        let usual = usual.unwrap_or(USUAL_DRAWS);
        let fewest = (fewest * usual / USUAL_DRAWS).max(FEWEST_DRAWS);
        Some(Self { grid, uncertain, draws: (usual / columns).clamp(fewest, most) })
    }

    /// Computes them on `threads` threads, all machines from the same random numbers. Ends with an error once `stop` is true.
    ///
    /// # Errors
    /// [`NoRisk`].
    pub fn probabilities(&self, threads: Option<usize>, stop: &AtomicBool) -> Result<Probabilities, NoRisk> {
        let Self { grid, uncertain, draws } = *self;
        let dampings = grid.dampings();
        let find = || {
            let mut all = Probabilities { values: Vec::new(), by_itself: Vec::new(), failed: 0, redrawn: 0 };
            for machine in (0..grid.column_count()).filter_map(|column| machine_of(grid, column)) {
                if stop.load(Ordering::Relaxed) {
                    return Err(NoRisk::Interrupted);
                }
                // What is no machine has no probability.
                let unknown = |all: &mut Probabilities| {
                    all.values.extend(dampings.iter().map(|_| f64::NAN));
                    all.by_itself.extend(dampings.iter().map(|_| f64::NAN));
                };
                if !machine.is_legal() {
                    unknown(&mut all);
                    continue;
                }
                match Needed::of(&machine, uncertain, draws) {
                    Ok(needed) => {
                        all.values.extend(dampings.iter().map(|&damping| needed.probability(damping).value));
                        all.by_itself.extend(dampings.iter().map(|&damping| needed.by_itself(damping).value));
                        all.failed += needed.failed;
                        all.redrawn += needed.redrawn;
                    }
                    Err(NoRisk::NoneFound) => {
                        unknown(&mut all);
                        all.failed += draws;
                    }
                    Err(why) => return Err(why),
                }
            }
            Ok(all)
        };
        // If no pool can be created, the global pool is used.
        match pool(threads) {
            Ok(pool) => pool.install(find),
            Err(_) => find(),
        }
    }
}

/// The machine at the first damping of a column.
fn machine_of(grid: &Grid, column: usize) -> Option<Machine> {
    grid.machine_at(&grid.values(&unravel(column * grid.dampings().len(), &grid.shape())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_machine::risk::{Spread, risk};
    use slipmap_machine::{Friction, Motion};
    use slipmap_model::friction::{Expression, Law};
    use slipmap_model::point::LawParameters;

    fn example() -> Machine {
        let values = [2.0, 800.0, 4.0, 50.0, 0.4, 0.3, 0.25, 0.0, 0.1];
        Machine::from_array(Motion::Translation, Law::Stribeck, values)
    }

    /// A formula with many waves takes long to compile for each draw. Columns of a map share the draws of one machine then,
    /// but for the fewest.
    #[test]
    fn fewer_draws_are_usual_where_each_takes_long() {
        let of = |phi: &str| {
            let formula = Expression::new(phi, 0.4).unwrap();
            let friction = Friction::Formula(formula, LawParameters::new(&[]));
            let machine = Machine { friction, ..example() };
            let uncertain = [("normal_force", Spread::Normal { sd: 10.0 })];
            let of_map = |columns: usize| {
                let masses = (0..columns).map(|i| machine.mass * (1.0 + 1e-12 * i as f64)).collect();
                let grid =
                    Grid::of_machine(&machine, &[("mass", masses), ("damping", vec![0.0, 1.0])]).unwrap();
                Chances::of(&grid, &uncertain).unwrap().draws
            };
            (usual_draws(&machine), of_map(2), of_map(5000))
        };
        let (many, ..) = of("0.3 + 0.1*exp(-u/0.25)");
        let (few, each_of_two, each_of_more) = of("0.3 + 0.1*exp(-u/0.25) + 1e-4*sin(300*u)^2");
        assert!(FEWEST_DRAWS <= few && few < many / 2 && many <= USUAL_DRAWS, "{few} {many}");
        for (draws, expected) in [(each_of_two, few / 2), (each_of_more, (few / 100).max(FEWEST_DRAWS))] {
            assert!(draws.abs_diff(expected) <= expected / 10, "{draws} {expected}");
        }
    }

    #[test]
    fn a_map_of_probabilities_has_each_of_its_points() {
        let machine = example();
        let uncertain = [("normal_force", Spread::Normal { sd: 10.0 })];
        let (speeds, dampings) = ([0.1, 0.3], [0.0, 2.0, 4.0]);
        let stop = AtomicBool::new(false);
        let varied = [("belt_speed", speeds.to_vec()), ("damping", dampings.to_vec())];
        let grid = Grid::of_machine(&machine, &varied).unwrap();
        let chances = Chances { draws: 3000, ..Chances::of(&grid, &uncertain).unwrap() };
        let Probabilities { values: map, by_itself, .. } = chances.probabilities(Some(1), &stop).unwrap();
        for (i, speed) in speeds.into_iter().enumerate() {
            for (j, damping) in dampings.into_iter().enumerate() {
                let here = machine.with("belt_speed", speed).unwrap().with("damping", damping).unwrap();
                let alone = risk(&here, &uncertain, Some(3000), &[], None).unwrap();
                let of_map = [map[3 * i + j], by_itself[3 * i + j]];
                assert_eq!(of_map, [alone.probability.value, alone.by_itself.value], "{speed} {damping}");
            }
        }
        assert!(map[0] == 1.0 && map[5] < map[3], "{map:?}");
    }
}
