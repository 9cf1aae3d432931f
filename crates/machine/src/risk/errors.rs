//! The critical damping of a machine with the standard error that measured or fitted friction makes.

use super::{MOST_JOINT, Spread, TOLERANCE, Uncertain};
use crate::{Friction, Machine, Model};
use slipmap_column::critical::{critical_damping, known_or_nan};
use slipmap_column::sensitivity::sensitivity_of_any_sign;

/// A number and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WithError {
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// The critical damping of a machine, which may be negative, and its standard error, in SI units, by the
/// standard errors of its measured friction or by the covariance of a fit among the `uncertain` quantities. `None`
/// if the friction has neither, the critical damping has no derivatives, or a number is not one of a machine.
pub fn uncertain_critical_damping(machine: &Machine, uncertain: &[Uncertain]) -> Option<WithError> {
    let joint = joint(uncertain);
    let model = machine.is_legal().then(|| machine.model())??;
    let unit = model.si.damping;
    let [value, standard_error] = match (has_standard_errors(machine), joint.is_empty()) {
        (true, _) => of_measured(&model).map(|c| c * unit),
        (false, false) => of_fitted(machine, &joint),
        (false, true) => return None,
    };
    (standard_error >= 0.0).then_some(WithError { value, standard_error })
}

/// Quantities with correlated errors, each with its row of the Cholesky factor.
pub(crate) type Joint = Vec<(&'static str, [f64; MOST_JOINT])>;

/// The quantities whose errors are correlated.
pub(crate) fn joint(uncertain: &[Uncertain]) -> Joint {
    let row = |&(name, spread): &Uncertain| match spread {
        Spread::Joint { row } => Some((name, row)),
        Spread::Normal { .. } | Spread::Relative { .. } | Spread::Uniform { .. } => None,
    };
    uncertain.iter().filter_map(row).collect()
}

/// Machines whose quantities are moved along each independent error.
pub(crate) struct Moved {
    /// By which share of its standard deviation.
    share: f64,
    /// The machines moved forward and backward.
    ends: Vec<[Machine; 2]>,
}

/// Shares of a standard deviation that are tried: wide errors reach machines that are none.
const SHARES: [f64; 4] = [1.0, 0.25, 0.0625, 0.015_625];

impl Moved {
    /// The machines moved as far as they are legal; `None` where that is nowhere.
    pub(crate) fn of(machine: &Machine, joint: &Joint) -> Option<Self> {
        let directions: Vec<usize> =
            (0..joint.len()).filter(|&k| joint.iter().any(|(_, row)| row[k] != 0.0)).collect();
        let moved = |k: usize, by: f64| {
            joint.iter().try_fold(machine.clone(), |machine, (name, row)| {
                let value = machine.quantities().into_iter().find(|(known, _)| known == name)?.1;
                machine.with(name, value + by * row[k]).filter(Machine::is_legal)
            })
        };
        SHARES.into_iter().find_map(|share| {
            let ends = directions.iter().map(|&k| Some([moved(k, share)?, moved(k, -share)?]));
            Some(Self { share, ends: ends.collect::<Option<_>>()? })
        })
    }

    /// The standard errors of numbers of the machine; `None` where they are unknown of one of the machines.
    pub(crate) fn errors<const N: usize>(
        &self,
        of: impl Fn(&Machine) -> Option<[f64; N]>,
    ) -> Option<[f64; N]> {
        let mut squares = [0.0; N];
        for [after, before] in &self.ends {
            let (after, before) = (of(after)?, of(before)?);
            for (sum, (after, before)) in squares.iter_mut().zip(after.into_iter().zip(before)) {
                *sum += (0.5 * (after - before) / self.share).powi(2);
            }
        }
        Some(squares.map(f64::sqrt))
    }
}

/// The critical damping of a machine with fitted friction, and its standard deviation by the covariance of the fit,
/// from differences over a standard deviation; both in SI units, NaN where unknown.
fn of_fitted(machine: &Machine, joint: &Joint) -> [f64; 2] {
    let critical = |machine: &Machine| {
        let model = machine.model()?;
        Some(known_or_nan(critical_damping(&model.column(), TOLERANCE)) * model.si.damping)
    };
    let error = Moved::of(machine, joint).and_then(|moved| moved.errors(|it| Some([critical(it)?])));
    [critical(machine), error.map(|[error]| error)].map(|value| value.unwrap_or(f64::NAN))
}

/// The critical damping of a machine with measured friction, and its standard deviation by the standard
/// errors of the data; both dimensionless, NaN where unknown. A negative critical damping has a deviation,
/// too: other data may have a positive one.
fn of_measured(model: &Model) -> [f64; 2] {
    let column = model.column();
    match sensitivity_of_any_sign(&column) {
        Ok(found) => {
            // In SI the unit of friction is not the static friction.
            let deviation = found.standard_error_in_fixed_unit;
            [found.critical.c, deviation.map_or(f64::NAN, |deviation| deviation.value)]
        }
        Err(_) => [known_or_nan(critical_damping(&column, TOLERANCE)), f64::NAN],
    }
}

/// Returns whether the friction was measured with standard errors.
pub(super) fn has_standard_errors(machine: &Machine) -> bool {
    matches!(&machine.friction, Friction::Measured(table) if table.standard_errors().is_some())
}
