//! The answer of one method about a point.

use slipmap_certify::curve;
use slipmap_certify::{Claim, Decision, Guarantee, Test};
use slipmap_column::{Method, Verdict};
use slipmap_model::friction::Column;
use slipmap_numbers::text::short;

/// The answer of one method.
#[derive(Debug)]
pub struct MethodAnswer {
    /// The method.
    pub method: Method,
    /// Its verdict.
    pub verdict: Verdict,
    /// The margin as in a map: the signed distance in c to the edge of presence, -infinity where a test claims
    /// no presence, NaN where the method has no edge.
    pub margin: f64,
    /// The edge of presence; `None` where the method has none at c >= 0, or none that is known to 1 %.
    pub critical_c: Option<f64>,
    /// Estimate of its absolute error; `None` for methods whose edge is exact to rounding.
    pub critical_c_error: Option<f64>,
    /// Reason why the verdict is neither presence nor absence.
    pub reason: Option<String>,
}

/// The answer of a closed-form test, or of proofs.
pub(crate) fn of_test(test: &'static Test, column: &Column, c: f64) -> MethodAnswer {
    let method = Method::Test(test);
    let (claim, stop) = if method == Method::validated() {
        let proof = curve::prove(column);
        (proof.claim(), proof.stop.map(|stop| stop.to_string()))
    } else {
        (test.claim(column), None)
    };
    let claim = &claim;
    let decision = claim.decide(c);
    let reason = (decision == Decision::Undecided).then(|| {
        why_inapplicable(method, claim, column, stop.as_ref()).unwrap_or_else(|| {
            let reason = why_undecided(claim, c);
            why_not_sharp(method, claim, stop.clone())
                .map_or(reason.clone(), |obstacle| format!("{reason}; {obstacle}"))
        })
    });
    MethodAnswer {
        method,
        verdict: decision.into(),
        margin: claim.margin(c),
        critical_c: claim.edge(),
        critical_c_error: None,
        reason,
    }
}

/// The reason, if a property of the law itself makes a test inapplicable.
fn why_inapplicable(method: Method, claim: &Claim, column: &Column, stop: Option<&String>) -> Option<String> {
    if *claim != Claim::NOTHING {
        return None;
    }
    if !column.curve.is_normal() {
        return Some(
            "a coefficient of the friction law is too small for the full accuracy of double precision".into(),
        );
    }
    match method.guarantee() {
        Guarantee::Asymptotic => {
            let is_first_order = matches!(method, Method::Test(test) if test.first_order);
            let no_first_order = is_first_order.then(|| column.first_order().err()).flatten();
            let is_unknown = || column.curve.mean_weakening(column.belt_speed).is_nan();
            let unknown = "the friction law is not known at all slip speeds up to 2 V";
            no_first_order.map(|why| why.to_string()).or_else(|| is_unknown().then(|| unknown.into()))
        }
        Guarantee::Validated => stop.cloned(),
        Guarantee::FiniteEpsilon => (!column.curve.is_enclosed(2.0 * column.belt_speed))
            .then(|| "the friction law has no proved bounds at all slip speeds up to 2 V".into()),
        Guarantee::Numerical | Guarantee::None => None,
    }
}

/// The reason why a proof claims less than there is, or a balance of energy leaves a band.
fn why_not_sharp(method: Method, claim: &Claim, stop: Option<String>) -> Option<String> {
    if method.guarantee() == Guarantee::Asymptotic {
        // Its two edges differ by the error of the balance of energy.
        let error = 0.5 * (claim.absent_above - claim.present_below);
        let told = |error| format!("the balance of energy is known to +- {} only", short(error));
        return (error > 0.0 && error.is_finite()).then(|| told(error));
    }
    stop
}

/// The reason why a claim is undecided at damping `c`.
fn why_undecided(claim: &Claim, c: f64) -> String {
    let Claim { sticks_from, present_below, absent_above } = *claim;
    if c < present_below && c < sticks_from {
        let from = match sticks_from.is_finite() {
            true => format!("c >= {} would rule that out", short(sticks_from)),
            false => "no damping rules that out".into(),
        };
        return format!("the orbit does not spiral inward, but might land beyond the stick segment; {from}");
    }
    match (present_below >= 0.0, absent_above.is_finite()) {
        (true, true) => format!(
            "the test claims presence below c = {} and absence above c = {} only",
            short(present_below),
            short(absent_above)
        ),
        (true, false) => {
            format!("the test claims presence only, and that below c = {}", short(present_below))
        }
        (false, true) => format!(
            "the test claims absence only at these parameters, and that above c = {}",
            short(absent_above)
        ),
        (false, false) => "the test claims presence only, and none at these parameters".into(),
    }
}
