//! A fitted law in `[friction]`: the values of the names in its formula, with their covariance, are quantities of a
//! machine whose errors are correlated.

use toml_edit::{Item, TableLike, Value};

use super::described::FitText;
use super::source::{ConfigError, Section, Shape};
use slipmap_machine::risk::MOST_JOINT;
use slipmap_model::friction::Law;

/// Key of the fit in `[friction]`, and of the covariance in it.
pub(super) const KEY: &str = "fit";
const COVARIANCE: &str = "covariance";

/// The fit of `[friction]`; `None` where there is none. One that is no fit is left to [`check`].
pub(super) fn values(friction: &Section) -> Option<FitText> {
    friction.get(KEY).and_then(|node| read(node.entries()?)).filter(|fit| fit.spreads().is_some())
}

/// The names, values and covariance of a fit; `None` if it is none.
fn read(fit: &dyn TableLike) -> Option<FitText> {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    let entries: Vec<(&str, &Item)> = fit.iter().filter(|(key, _)| *key != COVARIANCE).collect();
    let names = entries.iter().map(|(name, _)| (*name).to_owned()).collect();
    let values = entries.iter().map(|(_, item)| number(item.as_value()?)).collect::<Option<Vec<f64>>>()?;
    let rows = fit.get(COVARIANCE)?.as_array()?.iter();
    let rows = rows.map(|row| row.as_array()?.iter().map(number).collect::<Option<Vec<f64>>>());
    Some(FitText { names, values, covariance: rows.collect::<Option<Vec<_>>>()? })
}

/// The Cholesky factor of a covariance; `None` if it is none.
pub(super) fn factor(covariance: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let n = covariance.len();
    let is_symmetric =
        |i: usize, j: usize| (covariance[i][j] - covariance[j][i]).abs() <= 1e-9 * covariance[i][j].abs();
    if n > MOST_JOINT || covariance.iter().any(|row| row.len() != n) {
        return None;
    }
    let mut factor = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let rest = covariance[i][j] - known;
            // The sum rounds: a parameter that others determine has no variance of its own.
            let round_off = (n + 1) as f64 * f64::EPSILON * covariance[i][j].abs();
            let rest = if i == j && rest.abs() <= round_off { 0.0 } else { rest };
            if !is_symmetric(i, j) || i == j && !(rest >= 0.0) {
                return None;
            }
            factor[i][j] = match (i == j, factor[j][j] > 0.0) {
                (true, _) => rest.sqrt(),
                (false, true) => rest / factor[j][j],
                // A parameter without an error has no covariances.
                (false, false) => 0.0,
            };
        }
    }
    factor.iter().flatten().all(|value| value.is_finite()).then_some(factor)
}

/// Refuses a fit whose values are not those of the law's names, or whose covariance is none.
pub(super) fn check(friction: &Section, law: &Law) -> Result<(), ConfigError> {
    let Some(node) = friction.get(KEY) else { return Ok(()) };
    let Law::Expression(formula) = law.as_written() else {
        return Err(node.error("only a formula has a fit", "leave it out, or set law = \"expression\""));
    };
    let Shape::Table(fit) = node.shape() else {
        return Err(node.error("this is not a table", "take it as `slipmap fit` writes it"));
    };
    let names: Vec<&str> = formula.parameters().iter().map(|parameter| parameter.name).collect();
    let known: Vec<&str> = names.iter().copied().chain([COVARIANCE]).collect();
    super::refuse_unknown_keys(&fit, &known)?;
    let Some(covariance) = fit.get(COVARIANCE) else {
        return Err(fit.missing(COVARIANCE, "take it as `slipmap fit` writes it".into()));
    };
    for key in fit.keys().iter().filter(|key| *key != COVARIANCE) {
        if let Some(node) = fit.get(key)
            && !node.number()?.is_finite()
        {
            return Err(node.error("a fitted value must be finite", "take it as `slipmap fit` writes it"));
        }
    }
    let count = fit.keys().len() - 1;
    match node.entries().and_then(read).and_then(|fit| Some(fit.spreads()?.len())) {
        Some(spreads) if spreads == count => Ok(()),
        _ => {
            let problem = format!("this is no covariance of {count} parameters");
            let remedy =
                format!("write {count} rows of {count} numbers, symmetric, with variances of at least 0");
            Err(covariance.error(&problem, remedy))
        }
    }
}
