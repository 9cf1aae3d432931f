//! How the critical damping depends on the quantities of a machine, and on the slope of friction at each slip speed.

use crate::behaviour::is_positive;
use crate::{Machine, Model, NORMAL_FORCE};
use slipmap_column::{critical_damping, sensitivity};

/// The sensitivity of the critical damping to a quantity of the machine.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct QuantitySensitivity {
    /// Name of the quantity, as in configurations.
    pub quantity: &'static str,
    /// Per cent by which the critical damping (in N s/m) changes when the quantity grows by one per cent; NaN
    /// where its error is more than 0.01, and more than 1 % of it.
    pub critical_damping: f64,
    /// Estimate of its absolute error.
    pub critical_damping_error: f64,
}

/// The weight of one range of slip speeds in the critical damping.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SpeedInfluence {
    /// Slip speed, m/s: the middle of one of the equal ranges from 0 to the largest slip speed on the orbit.
    pub slip_speed: f64,
    /// Share of the weight in this range; the shares add up to 1.
    pub share: f64,
}

/// Accuracies of the critical damping, and the relative steps of the central differences for them. The second
/// pair is for laws whose orbits cannot be followed to the first accuracy.
const ACCURACIES_AND_STEPS: [(f64, f64); 2] = [(1e-12, 1e-4), (1e-10, 1e-3)];
/// Largest error of a sensitivity that is told, in per cent for 1 %; of large ones 1 % of it.
const LARGEST_ERROR: f64 = 0.01;

/// Logarithmic derivatives of the critical damping with respect to each nonzero quantity of a machine, except
/// its damping; without those for which no critical damping is known next to the machine.
///
/// The error is that of the critical dampings over the step, and the difference of the two differences, on either
/// side or, next to a limit of the quantity, on one: far more than the error of their slope where the critical damping is smooth, and its own at a corner.
pub fn sensitivities(machine: &Machine) -> Vec<QuantitySensitivity> {
    sensitivities_to(machine, |_| true)
}

/// As [`sensitivities`], with respect to those quantities that are `wanted`.
pub fn sensitivities_to(machine: &Machine, wanted: impl Fn(&str) -> bool) -> Vec<QuantitySensitivity> {
    let critical = |machine: &Machine, accuracy: f64| -> Option<[f64; 2]> {
        let model = machine.model()?;
        let column = model.column();
        let root = critical_damping(&column, accuracy).ok()?.known().ok()?;
        is_positive(&column, root.c).then_some([root.c, root.error].map(|it| it * model.si.damping))
    };
    let here = ACCURACIES_AND_STEPS.map(|(accuracy, _)| critical(machine, accuracy));
    let derivative = |(quantity, value): (&'static str, f64)| {
        let by = |((accuracy, step), here): ((f64, f64), Option<[f64; 2]>)| {
            let [here, error_here] = here?;
            let moved =
                |steps: f64| machine.with(quantity, value * (1.0 + steps * step)).filter(Machine::is_legal);
            // Next to a limit of the quantity both are on the side that is legal.
            let sides = [[1.0, -1.0], [1.0, 2.0], [-1.0, -2.0]];
            let ([a, b], [at_a, at_b]) =
                sides.into_iter().find_map(|[a, b]| Some(([a, b], [moved(a)?, moved(b)?])))?;
            let [[at_a, error_a], [at_b, error_b]] = [critical(&at_a, accuracy)?, critical(&at_b, accuracy)?];
            let [slope_a, slope_b] = [(at_a - here) / a, (at_b - here) / b];
            // The slope of the parabola through the three.
            let value = (b * slope_a - a * slope_b) / ((b - a) * step * here);
            let of_a_and_b = (b / a).abs() * error_a + (a / b).abs() * error_b;
            let of_three = of_a_and_b + (b / a - a / b).abs() * error_here;
            let sides = 2.0 * (slope_a - slope_b) / (b - a);
            let error = of_three / ((b - a).abs() * step * here) + (sides / (step * here)).abs();
            let is_known = error <= LARGEST_ERROR * value.abs().max(1.0);
            Some(QuantitySensitivity {
                quantity,
                critical_damping: if is_known { value } else { f64::NAN },
                critical_damping_error: error,
            })
        };
        ACCURACIES_AND_STEPS.into_iter().zip(here).find_map(by)
    };
    // A factor of all friction forces, if these are given instead of coefficients.
    let forces = (!machine.normal_force_is_known).then_some((NORMAL_FORCE, machine.normal_force));
    let quantities = machine.quantities().into_iter().chain(forces);
    let quantities =
        quantities.filter(|(name, value)| *name != machine.damping_name() && *value != 0.0 && wanted(name));
    quantities.filter_map(derivative).collect()
}

/// Number of equal parts of the range of slip speeds.
const PARTS: usize = 40;

/// The weights of slip speeds on the grazing orbit at the critical damping; `None` where they are unknown.
pub(super) fn influence(model: &Model) -> Option<Vec<SpeedInfluence>> {
    let parts = sensitivity::influence(&model.column(), PARTS).ok()?;
    let velocity = model.si.velocity;
    let of_machine = parts
        .into_iter()
        .map(|part| SpeedInfluence { slip_speed: 0.5 * (part.from + part.to) * velocity, share: part.share });
    Some(of_machine.collect())
}
