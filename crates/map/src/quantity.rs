//! The real numbers, besides margins, that a map can store in every cell: properties of the flow, derivatives
//! of the critical damping, and the limits in eps of the methods.

use std::collections::HashMap;

use super::interpolation::Interpolated;
use super::{Field, Plan, Quantity, Runs, Tile};
use crate::clock::timed;
use slipmap_column::critical::{critical_damping, known_or_nan};
use slipmap_column::crossing::landing_and_cycle;
use slipmap_column::limits::Ray;
use slipmap_column::sensitivity::sensitivity;
use slipmap_column::{BasinBoundary, Behaviour, Behaviours, End, Regime};
use slipmap_machine::Units;
use slipmap_machine::assessment::sensitivities_to;
use slipmap_machine::behaviour::growth_time;
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::Landing;
use slipmap_model::friction::Column;
use slipmap_model::friction::Range;
use slipmap_model::point::Point;
use slipmap_orbits::Cycle;

/// What a map stores of the orbits of a tile's cells, besides verdicts.
#[derive(Default)]
pub(super) struct Described {
    /// Empty where the plan stores none.
    pub(super) regimes: Runs<Regime>,
    /// Processor seconds that the regimes took.
    pub(super) regime_seconds: f64,
    /// See [`super::Account::left_out_from`].
    pub(super) left_out_from: Option<f64>,
    /// In the order of [`Plan::quantities`], for all cells each.
    pub(super) quantities: Vec<Vec<f64>>,
}

/// Describes a tile; `ends` holds the ends of its cells' orbits from the exit point.
pub(super) fn describe(
    plan: &Plan,
    tile: &Tile,
    columns: &[Column],
    ends: &Runs<End>,
    known: &Interpolated,
) -> Described {
    let quantities = plan.quantities();
    let mut described = Described {
        quantities: vec![vec![f64::NAN; tile.cells()]; quantities.len()],
        ..Described::default()
    };
    let stores_regimes = plan.stores(Field::Regime);
    if quantities.is_empty() && !stores_regimes {
        // Most maps of many cells hold verdicts alone: nothing is asked of their columns here.
        return described;
    }
    let cs = &plan.grid.dampings()[tile.damping_range()];
    let ends: Vec<End> = ends.values().collect();
    let mut regimes = vec![Regime::Failed; if stores_regimes { tile.cells() } else { 0 }];
    let mut known_limits: HashMap<Vec<u64>, Vec<f64>> = HashMap::new();
    let mut behaviours = Behaviours::default();
    for number in tile.columns_by_epsilon(&plan.grid) {
        let column = &columns[number];
        let behaviour = behaviours.of(column);
        let cells = number * cs.len()..(number + 1) * cs.len();
        if stores_regimes {
            let ((), taken) = timed(|| {
                let backbone = known.backbone(number, column);
                let none_crosses = known.no_other_crosses(number);
                for ((regime, &end), &c) in
                    regimes[cells.clone()].iter_mut().zip(&ends[cells.clone()]).zip(cs)
                {
                    *regime = behaviour.regime(column.epsilon * c, end, backbone.as_ref(), none_crosses);
                }
            });
            described.regime_seconds += taken;
            let from = [described.left_out_from, behaviour.left_out_from()].into_iter().flatten();
            described.left_out_from = from.reduce(f64::min);
        }
        if quantities.is_empty() {
            continue;
        }
        let mut values = plan.grid.values(&tile.column_index(number));
        let Some((law, start, si)) = plan.grid.place(&values) else { continue };
        let derivatives = derivatives(plan, &values, column);
        for (position, &c) in cells.zip(cs) {
            if let Some(damping) = values.last_mut() {
                *damping = c;
            }
            let cell = Description::of(plan, behaviour, &Oscillator::in_column(column, c), ends[position]);
            let limits = plan.stores(Field::EpsilonLimit).then(|| {
                // In dimensionless numbers.
                let point = Point { damping: c / column.unit, ..start };
                // Limits do not depend on the cell's own eps, so cells that differ only in eps share them. Each
                // machine has a law of its own.
                let machine = plan.grid.machine().map_or(0.0, |_| 1.0 + known_limits.len() as f64);
                let rest = point.law.as_slice().iter().chain([&point.belt_speed, &point.damping, &machine]);
                known_limits.entry(rest.map(|value| value.to_bits()).collect()).or_insert_with(|| {
                    let ray = Ray::new(&law, &point, plan.tolerance);
                    plan.methods.iter().map(|method| ray.limit(*method).value()).collect()
                })
            });
            for (values, quantity) in described.quantities.iter_mut().zip(&quantities) {
                values[position] = match quantity {
                    Quantity::EpsilonLimit(method) => {
                        limits.as_ref().map_or(f64::NAN, |limits| limits[*method])
                    }
                    Quantity::CriticalDerivative(axis) => derivatives.get(*axis).copied().unwrap_or(f64::NAN),
                    other => cell.value(*other) * factor(*other, si.as_ref()),
                };
            }
        }
    }
    described.regimes = regimes.into_iter().collect();
    described
}

/// The factor from the dimensionless number of a quantity to the map's: to SI units for a machine.
fn factor(quantity: Quantity, si: Option<&Units>) -> f64 {
    let dimension = quantity.about().dimension;
    si.zip(dimension).map_or(1.0, |(si, dimension)| si.factor(dimension))
}

/// The derivatives of the critical damping of a column by each axis but the damping; empty if they are unknown
/// or not stored. `values` are those of the axes.
fn derivatives(plan: &Plan, values: &[f64], column: &Column) -> Vec<f64> {
    if !plan.stores(Field::Sensitivity) {
        return Vec::new();
    }
    let Some(machine) = plan.grid.machine_at(values) else {
        let found = sensitivity(column).ok();
        let named = found.iter().flat_map(|found| found.named(plan.grid.law()));
        return named.map(|(_, by)| by.value).collect();
    };
    let names = plan.grid.axes().iter().map(|axis| axis.name.as_str());
    let names: Vec<&str> = names.take(plan.grid.axes().len() - 1).collect();
    let found = sensitivities_to(&machine, |name| names.contains(&name));
    let critical = known_or_nan(critical_damping(column, plan.tolerance));
    let by = |(name, value): (&&str, &f64)| {
        let found = found.iter().find(|found| found.quantity == *name);
        // They are logarithmic, of the damping in N s/m, of which that given is a power.
        let power =
            machine.with(name, 2.0 * value).map_or(0.0, |it| (it.si_damping() / machine.si_damping()).log2());
        found.map_or(f64::NAN, |found| (found.critical_damping - power) * critical / value)
    };
    names.iter().zip(values).map(by).collect()
}

/// Properties of the orbits of one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Description {
    /// Where and when the orbit from the exit point sticks.
    pub landing: Option<Landing>,
    /// The number of slip cycles, stable or not.
    pub slip_cycles: Option<usize>,
    /// The attracting cycle.
    pub cycle: Option<Cycle>,
    /// The edge of its basin.
    pub boundary: Option<BasinBoundary>,
    /// See [`growth_time`].
    pub growth_time: Option<f64>,
}

impl Description {
    /// Follows the orbits that the plan's fields need.
    fn of(plan: &Plan, behaviour: &Behaviour, oscillator: &Oscillator, end: End) -> Self {
        let (cycle, basin) = (plan.stores(Field::Cycle), plan.stores(Field::Basin));
        let lands = end == End::Sticks && (cycle || plan.stores(Field::Landing));
        let stick_slip = lands.then(|| landing_and_cycle(oscillator, plan.tolerance).ok()?).flatten();
        let at = behaviour.at(oscillator, end, plan.tolerance);
        Self {
            landing: stick_slip.map(|(landing, _)| landing),
            slip_cycles: cycle
                .then(|| behaviour.count(oscillator.viscous, end).ok())
                .flatten()
                .map(|cycles| cycles.len()),
            cycle: match end {
                _ if !cycle => None,
                End::Sticks => stick_slip.map(|(_, cycle)| cycle),
                _ => at.attracting_cycle(),
            },
            boundary: basin.then(|| at.basin_boundary()).flatten(),
            growth_time: growth_time(oscillator),
        }
    }

    /// The value of a quantity of the flow; NaN if unknown, and for limits in eps and derivatives.
    pub fn value(&self, quantity: Quantity) -> f64 {
        let half = |range: Range| 0.5 * (range.hi - range.lo);
        let landing = self.landing.as_ref();
        let cycle = self.cycle.as_ref();
        let boundary = self.boundary.as_ref();
        let value = match quantity {
            Quantity::LandingX1 => landing.map(|landing| landing.x1),
            Quantity::StickTime => landing.map(|landing| landing.stick_time),
            Quantity::SlipTime => landing.map(|landing| landing.slip_time),
            Quantity::Crossings => landing.and_then(|landing| landing.crossings).map(f64::from),
            Quantity::SlipCycles => self.slip_cycles.map(|count| count as f64),
            Quantity::CyclePeriod => cycle.map(|cycle| cycle.period),
            Quantity::CycleAmplitudeX1 => cycle.map(|cycle| half(cycle.displacement)),
            Quantity::CycleAmplitudeX2 => cycle.map(|cycle| half(cycle.velocity)),
            Quantity::CycleMultiplier => cycle.map(|cycle| cycle.multiplier),
            Quantity::BoundaryVelocity => boundary.map(|boundary| boundary.radius),
            Quantity::BoundaryMultiplier => {
                boundary.and_then(|boundary| boundary.cycle).map(|cycle| cycle.multiplier)
            }
            Quantity::KickForward => boundary.map(|boundary| boundary.kick.forward),
            Quantity::KickBackward => boundary.map(|boundary| boundary.kick.backward),
            Quantity::GrowthTime => self.growth_time,
            Quantity::EpsilonLimit(_) | Quantity::CriticalDerivative(_) => None,
        };
        value.unwrap_or(f64::NAN)
    }
}
